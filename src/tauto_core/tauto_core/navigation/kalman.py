"""The navigator's clock model: a linear Kalman filter on phase, rate and ageing.

State: offset x of the dial [s, fast is positive], rate y = dx/dt [1], ageing d = dy/dt [1/s].
Over a time τ without observations (Brown and Hwang; Zucca and Tavella, Metrologia 2005):

    x' = x + τ y + τ²/2 d,   y' = y + τ d,   d' = d,   P' = F P Fᵀ + Q(τ)

    Q = | q1 τ + q2 τ³/3 + q3 τ⁵/20   q2 τ²/2 + q3 τ⁴/8   q3 τ³/6 |
        |                             q2 τ + q3 τ³/3      q3 τ²/2 |
        |  symmetric                                      q3 τ    |

An observation is a scalar phase z = x + noise of variance R. With two states d and its variances
are zero and stay so. Formulas are written out in IEEE sums and products: floats and arrays, one
sample or many, give the same bits.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from tauto_core.samples import SECONDS_PER_DAY, FloatArray
from tauto_core.scene.errors import EstimationError

Number = TypeVar('Number', float, FloatArray)

WHITE_FM_FLOOR_S = 0.01**2 / SECONDS_PER_DAY
"""Least q1 of a real clock [s]: the phase walks by 0.01 s in a day."""

RANDOM_WALK_FM_FLOOR_PER_S = (0.001 / SECONDS_PER_DAY) ** 2 / SECONDS_PER_DAY
"""Least q2 of a real clock [1/s]: the rate walks by 0.001 s/day in a day."""

AGEING_TIME_S = 100.0 * SECONDS_PER_DAY
"""Time in which, one sigma, ageing may change the rate by the prior sigma of the rate [s]."""


class Estimate(NamedTuple, Generic[Number]):
    """Mean and covariance of the state, floats or arrays of one shape.

    Units: x [s], y [1], d [1/s]; `xy` is the covariance of x and y, and so on.
    """

    x: Number
    y: Number
    d: Number
    xx: Number
    xy: Number
    xd: Number
    yy: Number
    yd: Number
    dd: Number


@dataclass(frozen=True)
class ClockModel:
    """What the navigator assumes of the clock and of the observations.

    Args:
        observation_sigma_s: sigma of one phase observation, and of the setting at the start [s].
        prior_rate_sigma: sigma of the rate before any observation [1].
        states: 2 (offset, rate) or 3 (and ageing).
        white_fm_s: q1 [s], >= 0.
        random_walk_fm_per_s: q2 [1/s], >= 0.
        random_run_per_s3: q3 [1/s³], >= 0; of three states only.

    Raises:
        EstimationError: a value outside its range.
    """

    observation_sigma_s: float
    prior_rate_sigma: float
    states: int = 2
    white_fm_s: float = WHITE_FM_FLOOR_S
    random_walk_fm_per_s: float = RANDOM_WALK_FM_FLOOR_PER_S
    random_run_per_s3: float = 0.0

    def __post_init__(self) -> None:
        if self.states not in (2, 3):
            raise EstimationError(
                f'states = {self.states}: must be 2 (offset, rate) or 3 (and ageing). '
                'Choose one of them'
            )
        for name in ('observation_sigma_s', 'prior_rate_sigma'):
            _check(name, getattr(self, name), above_zero=True)
        for name in ('white_fm_s', 'random_walk_fm_per_s', 'random_run_per_s3'):
            _check(name, getattr(self, name), above_zero=False)
        if self.states == 2 and self.random_run_per_s3:
            raise EstimationError(
                f'random_run_per_s3 = {self.random_run_per_s3}: must be 0 with 2 states. '
                'Take 3 states to let the ageing wander'
            )


def _check(name: str, value: float, *, above_zero: bool) -> None:
    if math.isfinite(value) and (value > 0.0 or (value == 0.0 and not above_zero)):
        return
    raise EstimationError(
        f'{name} = {value}: must be finite and {"> 0" if above_zero else ">= 0"}. '
        'Give the sigma or noise that is known of the clock'
    )


def prior(model: ClockModel) -> Estimate[float]:
    """Return the state when the dial has just been set: x = 0 within one observation's sigma."""
    rate = model.prior_rate_sigma
    ageing = rate / AGEING_TIME_S if model.states == 3 else 0.0
    sigma = model.observation_sigma_s
    return Estimate(0.0, 0.0, 0.0, sigma * sigma, 0.0, 0.0, rate * rate, 0.0, ageing * ageing)


def predict(now: Estimate[Number], elapsed_s: Number, model: ClockModel) -> Estimate[Number]:
    """Return the state `elapsed_s` >= 0 later, with no observation in between.

    F P Fᵀ + Q(τ) in exact discrete form (see the module).
    """
    t = elapsed_s
    x, y, d, xx, xy, xd, yy, yd, dd = now
    q1, q2, q3 = model.white_fm_s, model.random_walk_fm_per_s, model.random_run_per_s3
    h = 0.5 * t * t
    fxx = xx + t * xy + h * xd
    fxy = xy + t * yy + h * yd
    fxd = xd + t * yd + h * dd
    fyy = yy + t * yd
    fyd = yd + t * dd
    return Estimate(
        x + t * y + h * d,
        y + t * d,
        d,
        fxx + t * fxy + h * fxd + t * (q1 + t * t * (q2 / 3.0 + t * t * (q3 / 20.0))),
        fxy + t * fxd + h * (q2 + h * (q3 / 2.0)),
        fxd + h * t * (q3 / 3.0),
        fyy + t * fyd + t * (q2 + t * t * (q3 / 3.0)),
        fyd + h * q3,
        dd + t * q3,
    )


def update(now: Estimate[float], phase_s: float, variance_s2: float) -> Estimate[float]:
    """Return the state after an observed phase, by Joseph's form (I−KH) P (I−KH)ᵀ + K R Kᵀ.

    Args:
        now: the state predicted for the instant of the observation.
        phase_s: z, reading minus observed true time [s].
        variance_s2: R [s²], > 0.
    """
    x, y, d, xx, xy, xd, yy, yd, dd = now
    r = variance_s2
    s = xx + r
    kx, ky, kd = xx / s, xy / s, xd / s
    innovation = phase_s - x
    # 1 - xx/s would lose the digits of a precise observation
    g = r / s
    ay, ad = g * xy, g * xd
    return Estimate(
        x + kx * innovation,
        y + ky * innovation,
        d + kd * innovation,
        g * g * xx + kx * kx * r,
        g * ay + kx * ky * r,
        g * ad + kx * kd * r,
        (yy - ky * xy) - ky * ay + ky * ky * r,
        (yd - ky * xd) - kd * ay + ky * kd * r,
        (dd - kd * xd) - kd * ad + kd * kd * r,
    )


def filter_phases(
    start: Estimate[float], elapsed_s: Iterable[float], phase_s: Iterable[float], model: ClockModel
) -> Estimate[FloatArray]:
    """Return the start and the state after each of n observations, as arrays of length n + 1.

    Args:
        start: the state to begin with.
        elapsed_s: time from the start to the first observation, then between observations [s],
            each >= 0; n values.
        phase_s: observed phases [s]; n values.
        model: noise and variance of the observations.
    """
    variance = model.observation_sigma_s * model.observation_sigma_s
    now = start
    rows = [now]
    for elapsed, phase in zip(elapsed_s, phase_s, strict=True):
        now = update(predict(now, elapsed, model), phase, variance)
        rows.append(now)
    return Estimate(*np.array(rows, np.float64).T)
