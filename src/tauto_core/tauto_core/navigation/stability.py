"""How steady a clock is: Allan's deviation and its kin, with confidence intervals.

`allantools` computes deviations, tells the kind of noise and counts degrees of freedom (Riley,
Handbook of Frequency Stability Analysis, NIST SP 1065, 2008; Greenhall and Riley, Uncertainty of
stability variances based on finite differences, PTTI 2003).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tauto_core.samples import NS_PER_S, FloatArray, IntArray, TimeSamples
from tauto_core.scene.errors import EstimationError

CONFIDENCE = 0.95
"""Probability that a confidence interval holds the clock's own deviation."""

NOISES = {
    2: 'white PM',
    1: 'flicker PM',
    0: 'white FM',
    -1: 'flicker FM',
    -2: 'random walk FM',
    -3: 'flicker walk FM',
}
"""Kinds of noise by the exponent α of the spectrum of the frequency, S_y ~ f^α."""

FEWEST = 32
"""Readings that the kind of noise can be told from (30 are left without their trend)."""

MOST = 20_000
"""Readings, of the spacing in question, that the kind of noise is told from."""

SHARE = 6
"""τ is at most this part of the record: a Hadamard deviation spans three τ, twice over."""

JITTER = 0.01
"""How far, relative to the interval, evenly spaced readings may be off."""


@dataclass(frozen=True)
class Deviation:
    """One kind of deviation against τ; all (n,).

    Args:
        value: of relative frequency [1]; the time deviation in seconds.
        low, high: confidence interval of `CONFIDENCE`.
    """

    value: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True)
class Stability:
    """The stability of a clock.

    Args:
        samples: readings used.
        tau_s: averaging times, doubling from the interval of the readings [s], (n,).
        noise: kind of noise at each, one of `NOISES`; where too few readings are left to tell,
            that of the τ before.
        allan, modified, hadamard: overlapping deviations, of relative frequency.
        time: τ/√3 times the modified one [s].
    """

    samples: int
    tau_s: FloatArray
    noise: tuple[str, ...]
    allan: Deviation
    modified: Deviation
    time: Deviation
    hadamard: Deviation


def stability_of(reading: TimeSamples) -> dict[str, Any]:
    """Return the stability of a clock from its readings as plain values.

    Returns:
        `samples`, `interval_s`, `confidence`, and `rows`: for each τ `tau_s`, `noise` and, of
        `allan`, `modified`, `time` and `hadamard`, value and confidence interval (`allan`,
        `allan_low`, `allan_high`, …); `time` in seconds, the others of relative frequency.

    Raises:
        EstimationError: too few readings, not evenly spaced, or without any noise.
    """
    error, interval_s = error_of(reading)
    found = stability(error, interval_s)
    columns: dict[str, Sequence[Any]] = {'tau_s': found.tau_s.tolist(), 'noise': found.noise}
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
            f'{len(stamps)} readings are too few to tell the stability of a clock, which takes '
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
            f'{interval / NS_PER_S:.9g} s after: stability is told from evenly spaced readings. '
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
        interval_s: between them, > 0 [s].
        factors: τ in intervals, rising; when left out powers of two. None above a sixth of the
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
    exponents = _exponents(error, factors)
    rate = 1.0 / interval_s
    taus = np.array(factors) * interval_s
    found = {}
    for name, order, modified in (('oadev', 2, False), ('mdev', 2, True), ('ohdev', 3, False)):
        deviation = getattr(allantools, name)(error, rate=rate, data_type='phase', taus=taus)[1]
        ends = [
            _interval(value, exponent, order, factor, len(error), modified)
            for value, exponent, factor in zip(deviation, exponents, factors, strict=True)
        ]
        low, high = np.array(ends).T
        found[name] = Deviation(deviation, low, high)
    modified_one, to_time = found['mdev'], taus / np.sqrt(3.0)
    return Stability(
        samples=len(error),
        tau_s=taus,
        noise=tuple(NOISES[exponent] for exponent in exponents),
        allan=found['oadev'],
        modified=modified_one,
        time=Deviation(
            to_time * modified_one.value, to_time * modified_one.low, to_time * modified_one.high
        ),
        hadamard=found['ohdev'],
    )


def _without_trend(error: FloatArray) -> FloatArray:
    """Return errors less the straight line through their ends, which no deviation sees.

    Raises:
        EstimationError: nothing is left but a parabola.
    """
    place = np.arange(len(error)) / (len(error) - 1)
    left = error - error[0] - (error[-1] - error[0]) * place
    third = np.diff(left, 3)
    if np.abs(third).max() <= 8.0 * np.finfo(np.float64).eps * np.abs(error).max():
        raise EstimationError(
            'the errors of the clock lie on a parabola: its rate is steady or changes steadily, '
            'and there is no noise to tell of. Leave out the stability'
        )
    return np.asarray(left, np.float64)


def _exponents(error: FloatArray, factors: tuple[int, ...]) -> list[int]:
    """Return α of the noise at each τ, −3 to 2."""
    import allantools

    found: list[int] = []
    for factor in factors:
        part = error[: MOST * factor]
        seen = part[::factor]
        if len(seen) < FEWEST or not np.diff(seen, 2).any():
            found.append(found[-1] if found else 2)
            continue
        told = allantools.autocorr_noise_id(part, factor, data_type='phase', dmin=0, dmax=3)[0]
        found.append(int(np.clip(told, -3, 2)))
    return found


def _interval(
    value: float, exponent: int, order: int, factor: int, count: int, modified: bool
) -> tuple[float, float]:
    """Return the confidence interval of a deviation, by the χ² law of its variance.

    Args:
        value: the deviation.
        exponent: α of the noise; for differences of second order at least −2 counts.
        order: of the differences, 2 (Allan) or 3 (Hadamard).
        factor: τ in intervals.
        count: readings.
        modified: whether phases are averaged over τ.
    """
    import allantools

    if value == 0.0:
        return 0.0, 0.0
    freedom = allantools.edf_greenhall(
        alpha=max(exponent, 2 - 2 * order),
        d=order,
        m=factor,
        N=count,
        overlapping=True,
        modified=modified,
    )
    low, high = allantools.confidence_interval(value, freedom, ci=CONFIDENCE)
    return float(low), float(high)
