"""Natural period and damping of the roll, fitted to a measured roll decay test."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, Strict

from tauto_core.scene.csv_columns import read_columns
from tauto_core.scene.data import source_name
from tauto_core.scene.errors import ABSENT, SceneError
from tauto_core.scene.fields import LONGEST_TEXT, NonNegative, Positive, Section, Text

if TYPE_CHECKING:
    from tauto_core.samples import FloatArray

FEWEST_A_CYCLE = 8
"""Samples that a cycle of the roll must have."""
_FORM = 'Give a CSV file whose first line names ship.roll.decay.time_column and roll_column.'
_UNITS = {'_s': 1.0, '_rad': 1.0, '_deg': math.pi / 180.0}


class RollDecay(Section):
    """A roll decay test: the ship is heeled, released, and rolls in calm water until it rests."""

    path: Text = Field(description='CSV file of the test')
    time_column: Text = Field(description='column of the time, …_s')
    roll_column: Text = Field(description='column of the roll, …_deg or …_rad')
    cycles: Annotated[int, Strict(), Field(ge=1, le=1000)] = Field(
        default=3, description='number of cycles after the release that are fitted, 1 to 1000'
    )
    model_scale: Positive = Field(
        default=1.0,
        description='length of the ship over that of the model; times are multiplied by its '
        'square root (Froude)',
    )


class RollFromDecay(Section):
    """Linear roll whose natural period and damping ratio follow from a roll decay test."""

    decay: RollDecay = Field(description='mapping: path, time_column, roll_column, …')
    slope_coefficient: NonNegative = Field(description='effective wave-slope coefficient κ_e')


@dataclass(frozen=True)
class DecayFit:
    """A linear decay with its standard errors.

    Attributes:
        natural_period: 2 pi/omega_n [s].
        damping_ratio: zeta.
        period_sigma: standard error of the period [s].
        damping_sigma: standard error of the ratio.
        residual: root mean square of the difference from the linear decay [rad].
    """

    natural_period: float
    damping_ratio: float
    period_sigma: float
    damping_sigma: float
    residual: float


def fitted_roll(asked: RollFromDecay) -> dict[str, Any]:
    """Return the keys of `ship.roll`: fitted period and damping ratio, and the source of the fit.

    Args:
        asked: the test and the slope coefficient.

    Raises:
        SceneError: a file that cannot be read, or no decay in it; with the line.
    """
    import numpy as np

    decay = asked.decay
    units = [_unit(decay, 'time_column', ('_s',)), _unit(decay, 'roll_column', ('_rad', '_deg'))]
    columns = (decay.time_column, decay.roll_column)
    table = read_columns(decay.path, columns, remedy=_FORM)
    time, roll = (
        unit * np.array(table.values[column]) for unit, column in zip(units, columns, strict=True)
    )
    backward = np.flatnonzero(np.diff(time) <= 0.0)
    if backward.size:
        line = table.lines[int(backward[0]) + 1]
        value, problem = float(time[backward[0] + 1]), 'must be later than the time before'
        remedy = 'Sort the rows and drop what is double.'
        where = f'line {line}, {decay.time_column}'
        raise SceneError(decay.path, where, value, problem, remedy)
    fit = fit_decay(*released(decay.path, time, roll, decay.cycles))
    longer = math.sqrt(decay.model_scale)
    period, sigma = longer * fit.natural_period, longer * fit.period_sigma
    if not fit.damping_ratio > 0.0:
        problem = f'is fitted to {decay.cycles} cycles, but must be > 0: the roll does not decay'
        remedy = 'Fit other cycles, or give natural_period and damping_ratio.'
        raise SceneError(decay.path, 'damping ratio', fit.damping_ratio, problem, remedy)
    said = (
        f'{source_name(decay.path)}: {decay.cycles} cycles, period {period:.5g} ± {sigma:.1g} s, '
        f'damping ratio {fit.damping_ratio:.3g} ± {fit.damping_sigma:.1g}'
    )
    return {
        'natural_period': period,
        'damping_ratio': fit.damping_ratio,
        'slope_coefficient': asked.slope_coefficient,
        'fitted_to': said[-LONGEST_TEXT:],
    }


def _unit(decay: RollDecay, key: str, suffixes: tuple[str, ...]) -> float:
    column = str(getattr(decay, key))
    for suffix in suffixes:
        if column.endswith(suffix):
            return _UNITS[suffix]
    problem = f'has no known unit; it must end in {" or ".join(suffixes)}'
    raise SceneError(decay.path, key, column, problem, 'Rename the column.')


def released(
    name: str, time: FloatArray, roll: FloatArray, cycles: int
) -> tuple[FloatArray, FloatArray]:
    """Return the part of a test in which the ship rolls freely.

    It begins where the roll first passes the middle after its largest angle (until then the ship
    may have been held) and lasts `cycles` cycles. The middle is the mean of the last quarter of
    the test.

    Args:
        name: name of the file, for messages.
        time: [s], increasing, shape (n,).
        roll: [rad], shape (n,).
        cycles: number of cycles.

    Raises:
        SceneError: there are not so many cycles, or too few samples in one.
    """
    import numpy as np

    about = roll - np.mean(roll[-(len(roll) // 4 + 1) :])
    largest = int(np.argmax(np.abs(about)))
    up = about[largest:] > 0.0
    crossings = largest + 1 + np.flatnonzero(up[1:] != up[:-1])
    last = 2 * cycles
    if len(crossings) <= last:
        problem = (
            f'is more than the test holds: {max(len(crossings) - 1, 0) // 2} whole cycles after '
            f'its largest roll'
        )
        remedy = 'Fit fewer cycles, or give the test to its end.'
        raise SceneError(name, 'cycles', cycles, problem, remedy)
    begin, end = int(crossings[0]), int(crossings[last])
    if end - begin < FEWEST_A_CYCLE * cycles:
        problem = (
            f'cycles of the roll have {end - begin} samples; at least {FEWEST_A_CYCLE} a cycle '
            'are needed'
        )
        raise SceneError(name, str(cycles), ABSENT, problem, 'Give a test sampled more finely.')
    return time[begin:end], roll[begin:end]


def fit_decay(time: FloatArray, roll: FloatArray) -> DecayFit:
    """Fit rho = mean + exp(-zeta w t) (a cos w_d t + b sin w_d t), w_d = w sqrt(1 - zeta^2).

    Least squares over w and zeta; the other parameters are linear. The damping of a ship falls
    with the angle, so the residual of this linear decay is not white noise. The standard errors
    therefore count one independent residual in each half cycle.

    Args:
        time: [s], increasing, shape (n,), of whole cycles beginning at a zero crossing.
        roll: [rad], shape (n,).
    """
    import numpy as np
    from scipy.optimize import least_squares

    t = time - time[0]
    half_cycles, first = _first_guess(t, roll)

    def rest(guess: FloatArray) -> FloatArray:
        omega, zeta = guess
        turned = omega * math.sqrt(max(1.0 - zeta * zeta, 0.0)) * t
        size = np.exp(-zeta * omega * t)
        shapes = np.stack([size * np.cos(turned), size * np.sin(turned), np.ones_like(t)], 1)
        linear = np.linalg.lstsq(shapes, roll, rcond=None)[0]
        left: FloatArray = shapes @ linear - roll
        return left

    found = least_squares(
        rest, first, jac='3-point', x_scale=first, xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    variance = float(np.mean(found.fun**2))
    slopes = np.asarray(found.jac)
    spread = np.linalg.inv(slopes.T @ slopes) * variance * len(t) / half_cycles
    omega, zeta = (float(each) for each in found.x)
    period = math.tau / omega
    return DecayFit(
        period,
        zeta,
        period * math.sqrt(float(spread[0, 0])) / omega,
        math.sqrt(float(spread[1, 1])),
        math.sqrt(variance),
    )


def _first_guess(t: FloatArray, roll: FloatArray) -> tuple[int, list[float]]:
    """Return the number of half cycles, w from it, and zeta from the sizes of both halves."""
    import numpy as np

    about = roll - np.mean(roll)
    up = about > 0.0
    half_cycles = max(int(np.count_nonzero(up[1:] != up[:-1])) + 1, 2)
    half = len(t) // 2
    early, late = (float(np.sqrt(np.mean(part**2))) for part in (about[:half], about[half:]))
    omega = math.pi * half_cycles / float(t[-1])
    decrement = 2.0 * math.log(early / late) / float(t[-1])
    return half_cycles, [omega, min(max(decrement / omega, 1e-4), 0.9)]
