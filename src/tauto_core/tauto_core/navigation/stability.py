"""Stability of a clock: the Allan deviation and related ones, with confidence intervals.

`allantools` computes the deviations (Riley, Handbook of Frequency Stability Analysis, NIST SP
1065, 2008). Each interval weights the possible kinds of noise by their probability
(`noise_kinds`), with the degrees of freedom of each kind (`power_law`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tauto_core.curves.numerics import bracketed_newton
from tauto_core.navigation.noise_kinds import KINDS, weights_of_kinds
from tauto_core.navigation.power_law import Difference, degrees_of_freedom
from tauto_core.samples import NS_PER_S, FloatArray, IntArray, TimeSamples
from tauto_core.scene.errors import EstimationError

CONFIDENCE = 0.95
"""Probability that a confidence interval contains the true deviation of the clock."""

FEWEST = 32
"""Least number of readings from which the kind of noise can be identified."""

NEGLIGIBLE = 1e-4
"""Probability of a kind of noise below which it is ignored."""

SAME = 1e-9
"""Relative accuracy to which the ends of an interval are computed."""

SHARE = 6
"""τ is at most a sixth of the record: a Hadamard deviation spans three τ, twice over."""

JITTER = 0.01
"""Largest irregularity of evenly spaced readings, relative to their interval."""


@dataclass(frozen=True)
class Deviation:
    """One kind of deviation against τ; all (n,).

    Args:
        value: the deviation of the relative frequency [1], or the time deviation [s].
        low, high: confidence interval of `CONFIDENCE`.
    """

    value: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True)
class Stability:
    """The stability of a clock.

    Args:
        samples: number of readings used.
        tau_s: averaging times, doubling from the interval of the readings [s], (n,).
        noise: most probable kind of noise at each, one of `noise_kinds.KINDS`.
        noise_probability: its probability, (n,).
        allan, modified, hadamard: overlapping deviations of relative frequency.
        time: τ/√3 times the modified one [s].
    """

    samples: int
    tau_s: FloatArray
    noise: tuple[str, ...]
    noise_probability: FloatArray
    allan: Deviation
    modified: Deviation
    time: Deviation
    hadamard: Deviation


def stability_of(reading: TimeSamples) -> dict[str, Any]:
    """Return the stability of a clock from its readings as plain values.

    Returns:
        `samples`, `interval_s`, `confidence`, and `rows`: for each τ `tau_s`, `noise` and its
        `noise_probability` and, of `allan`, `modified`, `time` and `hadamard`, value and
        confidence interval (`allan`, `allan_low`, `allan_high`, …); `time` in seconds, the
        others of relative frequency.

    Raises:
        EstimationError: too few readings, not evenly spaced, or without any noise.
    """
    error, interval_s = error_of(reading)
    found = stability(error, interval_s)
    columns: dict[str, Sequence[Any]] = {
        'tau_s': found.tau_s.tolist(),
        'noise': found.noise,
        'noise_probability': found.noise_probability.tolist(),
    }
    for name in ('allan', 'modified', 'time', 'hadamard'):
        deviation: Deviation = getattr(found, name)
        columns[name] = deviation.value.tolist()
        columns[f'{name}_low'] = deviation.low.tolist()
        columns[f'{name}_high'] = deviation.high.tolist()
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    return {
        'samples': found.samples,
        'interval_s': interval_s,
        'confidence': CONFIDENCE,
        'rows': rows,
    }


def error_of(reading: TimeSamples) -> tuple[FloatArray, float]:
    """Return the clock's error at each reading [s] and the time between readings [s].

    Raises:
        EstimationError: fewer than `FEWEST` readings, or not evenly spaced.
    """
    stamps: IntArray = reading.stamp_ns
    if len(stamps) < FEWEST:
        raise EstimationError(
            f'{len(stamps)} readings are too few to estimate the stability of a clock: it takes '
            f'{FEWEST}. Log more of them (log.interval), or a longer run'
        )
    steps = np.diff(stamps)
    interval = float(np.median(steps))
    odd = np.flatnonzero(np.abs(steps - interval) > JITTER * interval)
    if len(odd):
        first = int(odd[0])
        raise EstimationError(
            f'the reading at {stamps[first + 1] / NS_PER_S:.9g} s comes '
            f'{steps[first] / NS_PER_S:.9g} s after the one before, most come '
            f'{interval / NS_PER_S:.9g} s after: stability needs evenly spaced readings. '
            'Take a part of the bag without gaps'
        )
    error: FloatArray = (reading.time_ref_ns - stamps) / NS_PER_S
    return error, interval / NS_PER_S


def stability(
    error_s: FloatArray, interval_s: float, factors: tuple[int, ...] | None = None
) -> Stability:
    """Return deviations of a clock from its errors.

    Args:
        error_s: reading minus true time at even intervals [s], at least `FEWEST`.
        interval_s: that interval, > 0 [s].
        factors: τ in intervals, increasing; when left out powers of two. None above a sixth of the
            readings.

    Raises:
        EstimationError: too few readings, or errors that are all on a parabola, to rounding.
    """
    import allantools

    error = np.asarray(error_s, np.float64)
    most = (len(error) - 1) // SHARE
    if len(error) < FEWEST or (factors is not None and factors[-1] > most):
        raise EstimationError(
            f'{len(error)} readings are too few: it takes {FEWEST}, and {SHARE} τ. Give more of '
            'them, or a shorter τ'
        )
    if factors is None:
        factors = tuple(2**k for k in range(most.bit_length()))
    error = _without_trend(error)
    by_octave = weights_of_kinds(error, most.bit_length())
    weights = by_octave[[factor.bit_length() - 1 for factor in factors]]
    rate = 1.0 / interval_s
    taus = np.array(factors) * interval_s
    found = {}
    for name, order, modified in (('oadev', 2, False), ('mdev', 2, True), ('ohdev', 3, False)):
        deviation = getattr(allantools, name)(error, rate=rate, data_type='phase', taus=taus)[1]
        differences = [Difference(order, factor, modified) for factor in factors]
        low, high = deviation * _bounds(weights, differences, len(error))
        found[name] = Deviation(deviation, low, high)
    modified_one, to_time = found['mdev'], taus / np.sqrt(3.0)
    return Stability(
        samples=len(error),
        tau_s=taus,
        noise=tuple(list(KINDS.values())[place] for place in np.argmax(weights, axis=1)),
        noise_probability=np.max(weights, axis=1),
        allan=found['oadev'],
        modified=modified_one,
        time=Deviation(
            to_time * modified_one.value, to_time * modified_one.low, to_time * modified_one.high
        ),
        hadamard=found['ohdev'],
    )


def _without_trend(error: FloatArray) -> FloatArray:
    """Return errors less the straight line through their ends, which no deviation depends on.

    Raises:
        EstimationError: nothing is left but a parabola.
    """
    place = np.arange(len(error)) / (len(error) - 1)
    left = error - error[0] - (error[-1] - error[0]) * place
    third = np.diff(left, 3)
    if np.abs(third).max() <= 8.0 * np.finfo(np.float64).eps * np.abs(error).max():
        raise EstimationError(
            'the errors of the clock lie on a parabola: its rate is steady or changes steadily, '
            'and there is no noise to measure. Leave out the stability'
        )
    return np.asarray(left, np.float64)


def _bounds(weights: FloatArray, differences: list[Difference], count: int) -> FloatArray:
    """Return the ratios of the interval's ends to the estimated deviation, (2, n).

    For one kind of noise ν V/σ² is χ² with ν degrees of freedom, with V the estimated variance and
    σ² the true one. Its distribution is averaged over the kinds, and cut at both ends with equal
    probability.

    Args:
        weights: probability of each of the `KINDS`, (n, kinds).
        differences: the differences whose mean squares V are, n.
        count: number of the readings.
    """
    from scipy import special

    weight = np.where(weights > NEGLIGIBLE, weights, 0.0)
    weight = weight / np.sum(weight, axis=1, keepdims=True)
    freedom = np.ones_like(weight)
    for row, column in np.argwhere(weight).tolist():
        each = differences[row]
        # for a redder noise than the difference allows, those of the reddest allowed
        alpha = max(list(KINDS)[column], 2 - 2 * each.order)
        freedom[row, column] = degrees_of_freedom(alpha, each, count)
    level = 0.5 * np.array([1.0 - CONFIDENCE, 1.0 + CONFIDENCE])[:, None]
    # logarithms of σ²/V at which one kind alone reaches the level
    ends = np.log(freedom / special.chdtri(freedom, level[:, :, None]))

    def excess(u: FloatArray) -> tuple[FloatArray, FloatArray]:
        chi, half = freedom * np.exp(-u[:, :, None]), 0.5 * freedom
        density = np.exp(half * np.log(0.5 * chi) - 0.5 * chi - special.gammaln(half))
        below = np.sum(weight * special.chdtrc(freedom, chi), axis=-1)
        return below - level, np.sum(weight * density, axis=-1)

    lowest = np.min(ends, axis=-1, where=weight > 0.0, initial=math.inf)
    highest = np.max(ends, axis=-1, where=weight > 0.0, initial=-math.inf)
    start = np.sum(weight * ends, axis=-1)
    found = bracketed_newton(excess, start, (lowest, highest), absolute=SAME)
    return np.asarray(np.exp(0.5 * found))
