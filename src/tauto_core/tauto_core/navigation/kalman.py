"""The navigator's clock model: a linear Kalman filter on phase, rate and ageing.

State: offset x of the dial [s, fast is positive], rate y = dx/dt [1], ageing d = dy/dt [1/s].
Over a time τ without observations (Brown and Hwang; Zucca and Tavella, Metrologia 2005):

    x' = x + τ y + τ²/2 d,   y' = y + τ d,   d' = d,   P' = F P Fᵀ + Q(τ)

    Q = | q1 τ + q2 τ³/3 + q3 τ⁵/20   q2 τ²/2 + q3 τ⁴/8   q3 τ³/6 |
        |                             q2 τ + q3 τ³/3      q3 τ²/2 |
        |  symmetric                                      q3 τ    |

An observation is a scalar phase z = x + noise of variance R. With two states d and its variances
are zero and remain so. Formulas are written out as sums and products, so floats and arrays, one
sample or many, give the same bits.

With covariates the rate is y + Σ k_j x_j, and the coefficients k_j are states too
(`coefficients`).
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any, Generic, NamedTuple, TypeVar, cast

from tauto_core.navigation.coefficients import Coefficient, correction, pairs, prediction
from tauto_core.samples import SECONDS_PER_DAY, FloatArray
from tauto_core.scene.errors import EstimationError
from tauto_core.ship.observations import LUNAR

Number = TypeVar('Number', float, FloatArray)

WHITE_FM_FLOOR_S = 0.01**2 / SECONDS_PER_DAY
"""Least q1 of a real clock [s]: a random walk of the phase by 0.01 s in a day."""

RANDOM_WALK_FM_FLOOR_PER_S = (0.001 / SECONDS_PER_DAY) ** 2 / SECONDS_PER_DAY
"""Least q2 of a real clock [1/s]: a random walk of the rate by 0.001 s/day in a day."""

AGEING_TIME_S = 100.0 * SECONDS_PER_DAY
"""Time in which ageing may change the rate by one prior sigma of the rate [s]."""


LUNAR_SIGMA_S = 60.0
"""Default sigma of lunar distances [s] (`scene.sections.Lunars`)."""

SETTING_SIGMAS = 10.0
"""Prior sigma of the dial's offset, in sigmas of an observation. It is so wide that the first
observation determines the offset, however the dial was set.
"""


class Estimate(NamedTuple, Generic[Number]):
    """Mean and covariance of the state, floats or arrays of one shape.

    Units: x [s], y [1], d [1/s]; `xy` is the covariance of x and y, and so on. Estimates of a
    model with coefficients have fields for them too (`estimate_of`).
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


def same_fields(like: Estimate[Any], values: Iterable[Number]) -> Estimate[Number]:
    """Return an estimate of the same class as another, from its values in order."""
    return cast(Estimate[Number], type(like)(*values))


@cache
def estimate_of(coefficients: tuple[str, ...]) -> type[Estimate[Any]]:
    """Return the class of estimates with these coefficients; `Estimate` if there are none.

    After the fields of `Estimate` come the means, by the coefficients' names, and the covariances
    with them: `x_heave`, `heave_roll` and so on.
    """
    if not coefficients:
        return Estimate
    kept = covariances(('x', 'y', 'd', *coefficients))
    crossed = [field for field in kept if field not in Estimate._fields]
    fields = [*Estimate._fields, *coefficients, *crossed]
    return cast(type[Estimate[Any]], namedtuple('Estimate', fields))


def covariances(names: tuple[str, ...]) -> list[str]:
    """Return the names of the covariances of states, upper triangle, row by row."""
    both = [(names[i], names[j]) for i, j in pairs(len(names))]
    return [f'{one}{other}' if len(other) == 1 else f'{one}_{other}' for one, other in both]


@dataclass(frozen=True)
class ClockModel:
    """The navigator's assumptions about the clock and the observations.

    Args:
        observation_sigma_s: sigma of one phase observation in port or at a landfall [s].
        prior_rate_sigma: sigma of the rate before any observation [1].
        states: 2 (offset, rate) or 3 (and ageing).
        white_fm_s: q1 [s], >= 0.
        random_walk_fm_per_s: q2 [1/s], >= 0.
        random_run_per_s3: q3 [1/s³], >= 0; for three states only.
        gate: largest innovation that is accepted, in its own sigmas, > 0; None: any.
        patience_s: time after the last observation used for which others are refused [s], > 0
            (`filtering`).
        lunar_sigma_s: sigma of one phase observation by a lunar distance [s].
        coefficients: the coefficients of the rate equation with their priors.

    Raises:
        EstimationError: a value outside its range.
    """

    observation_sigma_s: float
    prior_rate_sigma: float
    states: int = 2
    white_fm_s: float = WHITE_FM_FLOOR_S
    random_walk_fm_per_s: float = RANDOM_WALK_FM_FLOOR_PER_S
    random_run_per_s3: float = 0.0
    gate: float | None = None
    patience_s: float = math.inf
    lunar_sigma_s: float = LUNAR_SIGMA_S
    coefficients: tuple[Coefficient, ...] = ()

    def __post_init__(self) -> None:
        if self.states not in (2, 3):
            raise EstimationError(
                f'states = {self.states}: must be 2 (offset, rate) or 3 (and ageing). '
                'Choose one of them'
            )
        for name in ('observation_sigma_s', 'prior_rate_sigma', 'lunar_sigma_s'):
            _check(name, getattr(self, name), above_zero=True)
        for name in ('white_fm_s', 'random_walk_fm_per_s', 'random_run_per_s3'):
            _check(name, getattr(self, name), above_zero=False)
        for name in ('gate', 'patience_s'):
            value = getattr(self, name)
            if value is not None and not value > 0.0:
                raise EstimationError(f'{name} = {value}: must be > 0. Give the limit meant')
        if self.states == 2 and self.random_run_per_s3:
            raise EstimationError(
                f'random_run_per_s3 = {self.random_run_per_s3}: must be 0 with 2 states. '
                'Take 3 states to let the ageing wander'
            )
        for coefficient in self.coefficients:
            _check(f'sigma of {coefficient.name}', coefficient.sigma, above_zero=True)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coefficients."""
        return tuple(coefficient.name for coefficient in self.coefficients)

    def sigma_of(self, source: str) -> float:
        """Return sigma of an observation by the source that its message states [s]."""
        return self.lunar_sigma_s if source == LUNAR else self.observation_sigma_s


def _check(name: str, value: float, *, above_zero: bool) -> None:
    if math.isfinite(value) and (value > 0.0 or (value == 0.0 and not above_zero)):
        return
    raise EstimationError(
        f'{name} = {value}: must be finite and {"> 0" if above_zero else ">= 0"}. '
        'Give the sigma or noise that is known of the clock'
    )


def prior(model: ClockModel) -> Estimate[float]:
    """Return the state just after the dial was set: x = 0 ± `SETTING_SIGMAS` observations."""
    rate = model.prior_rate_sigma
    ageing = rate / AGEING_TIME_S if model.states == 3 else 0.0
    sigma = SETTING_SIGMAS * model.observation_sigma_s
    clock = Estimate(0.0, 0.0, 0.0, sigma * sigma, 0.0, 0.0, rate * rate, 0.0, ageing * ageing)
    if not model.coefficients:
        return clock
    kind = estimate_of(model.names)
    known = dict.fromkeys(kind._fields, 0.0) | clock._asdict()
    for name, value, deviation in model.coefficients:
        known |= {name: value, f'{name}_{name}': deviation * deviation}
    return kind(**known)


def predict(
    now: Estimate[Number],
    elapsed_s: Number,
    model: ClockModel,
    gained_s: tuple[Number, ...] = (),
) -> Estimate[Number]:
    """Return the state `elapsed_s` >= 0 later, without an observation in between.

    F P Fᵀ + Q(τ) in exact discrete form (see the module).

    Args:
        now: state before.
        elapsed_s: time until then [s].
        model: the model of the state.
        gained_s: growth of the integral of each covariate in that time [s].
    """
    law = law_of(model)
    return law.whole(now, law.ahead(law.part(now), elapsed_s, *noise_of(model), *gained_s))


def update(now: Estimate[float], phase_s: float, variance_s2: float) -> Estimate[float]:
    """Return the state after an observed phase, by Joseph's form (I−KH) P (I−KH)ᵀ + K R Kᵀ.

    Args:
        now: the state predicted for the instant of the observation.
        phase_s: z, reading minus observed true time [s].
        variance_s2: R [s²], > 0.
    """
    return Estimate(*corrected_three(now, phase_s - now.x, now.xx + variance_s2, variance_s2))


def reopen(ahead: Estimate[Number], innovation_s: Number, elapsed_s: Number) -> Estimate[Number]:
    """Return a predicted state with its variance widened after an outlier (theory E7).

    Either the offset may have jumped by the innovation ν, or the rate may have changed by ν/τ just
    after the last observation used. P grows by ν² for the first and by (ν/τ)² (τ, 1)ᵀ(τ, 1) for
    the second.

    Args:
        ahead: the state predicted for the instant of the observation.
        innovation_s: ν, observed less predicted phase [s].
        elapsed_s: τ > 0, since the last observation used [s]; infinite where only the offset can
            have changed.
    """
    v, w = innovation_s, innovation_s / elapsed_s
    return ahead._replace(xx=ahead.xx + 2.0 * (v * v), xy=ahead.xy + v * w, yy=ahead.yy + w * w)


def noise_of(model: ClockModel) -> tuple[float, float, float]:
    """Return q1 [s], q2 [1/s], q3 [1/s³]."""
    return model.white_fm_s, model.random_walk_fm_per_s, model.random_run_per_s3


def ahead_three(
    now: tuple[Number, ...], t: Number, q1: float, q2: float, q3: float
) -> tuple[Number, ...]:
    """Return x, y, d, xx, xy, xd, yy, yd, dd after a time t [s] (see the module)."""
    x, y, d, xx, xy, xd, yy, yd, dd = now
    h = 0.5 * t * t
    fxx = xx + t * xy + h * xd
    fxy = xy + t * yy + h * yd
    fxd = xd + t * yd + h * dd
    fyy = yy + t * yd
    fyd = yd + t * dd
    return (
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


def ahead_two(
    now: tuple[Number, ...], t: Number, q1: float, q2: float, _q3: float
) -> tuple[Number, ...]:
    """Return x, y, xx, xy, yy after a time t [s]; bits as of `ahead_three` without ageing."""
    x, y, xx, xy, yy = now
    fxy = xy + t * yy
    return (
        x + t * y,
        y,
        xx + t * xy + t * fxy + t * (q1 + t * t * (q2 / 3.0)),
        fxy + 0.5 * t * t * q2,
        yy + t * q2,
    )


def corrected_three(
    now: tuple[float, ...], innovation: float, s: float, r: float
) -> tuple[float, ...]:
    """Return the nine numbers after an observation of variance r; s = xx + r."""
    x, y, d, xx, xy, xd, yy, yd, dd = now
    kx, ky, kd = xx / s, xy / s, xd / s
    # 1 - xx/s would lose digits for a precise observation
    g = r / s
    ay, ad = g * xy, g * xd
    return (
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


def corrected_two(
    now: tuple[float, ...], innovation: float, s: float, r: float
) -> tuple[float, ...]:
    """Return the five numbers after an observation, with the bits of `corrected_three`."""
    x, y, xx, xy, yy = now
    kx, ky, g = xx / s, xy / s, r / s
    ay = g * xy
    return (
        x + kx * innovation,
        y + ky * innovation,
        g * g * xx + kx * kx * r,
        g * ay + kx * ky * r,
        (yy - ky * xy) - ky * ay + ky * ky * r,
    )


@dataclass(frozen=True)
class Law:
    """The filter's arithmetic on the numbers that a model has: five, nine, or more.

    Args:
        fields: indices of these numbers in an `Estimate`.
        xx: index of the variance of x among them.
        ahead: (numbers, elapsed time, q1, q2, q3, growth of each integral) -> numbers predicted.
        corrected: (numbers predicted, innovation, its variance, R) -> numbers.
    """

    fields: tuple[int, ...]
    xx: int
    ahead: Callable[..., tuple[Any, ...]]
    corrected: Callable[..., tuple[Any, ...]]

    def part(self, whole: Estimate[Number]) -> tuple[Number, ...]:
        """Return the numbers of an estimate that the arithmetic changes."""
        return tuple(whole[field] for field in self.fields)

    def whole(self, rest: Estimate[Number], part: tuple[Number, ...]) -> Estimate[Number]:
        """Return an estimate with these numbers, and the others from `rest`."""
        names = (rest._fields[field] for field in self.fields)
        return rest._replace(**dict(zip(names, part, strict=True)))


_LAWS = {
    2: Law((0, 1, 3, 4, 6), 2, ahead_two, corrected_two),
    3: Law(tuple(range(9)), 3, ahead_three, corrected_three),
}


def law_of(model: ClockModel) -> Law:
    """Return the arithmetic of a model, without terms that it does not have."""
    return _with(model.names, model.states) if model.coefficients else _LAWS[model.states]


@cache
def _with(coefficients: tuple[str, ...], states: int) -> Law:
    """Return the arithmetic of a clock with coefficients."""
    names = (*('x', 'y', 'd')[:states], *coefficients)
    size, known = len(names), estimate_of(coefficients)._fields
    fields = tuple(known.index(field) for field in (*names, *covariances(names)))
    return Law(fields, size, prediction(states, size), correction(size))
