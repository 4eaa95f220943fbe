"""The standard error of a run's mean rate, from the slowest changes of its rate."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tauto_core.samples import NS_PER_S, SECONDS_PER_DAY, FloatArray, IntArray, TimeSamples

PARTS = 1024
"""Enough that the slowest changes are seen apart from the jitter of the single readings, which
waves and escapement cause.
"""

LEAST_PARTS = 32

COSINES = 20
"""Number of coefficients from which the memory of the rate is found."""

SLOWEST = 4
"""Number of those that give the error; more would include faster changes, which say less of the
mean, fewer leave it uncertain by more than a third of itself.
"""

MEMORIES = np.geomspace(0.003, 1.0, 30)
"""Times for which a rate may remember, in lengths of the run, equally likely beforehand. A
shorter one has the same coefficients as none, and of a longer one nothing can be known.
"""

LONGEST = 0.1
"""Memory, in lengths of the run, beyond which the run is too short: ten of its parts would not be
independent.
"""

NEGLIGIBLE_S_PER_DAY = 0.001
"""Standard error that is good enough however long the memory: it is 0.02 nmi after 81 days."""

TOO_SHORT = 'cannot be projected from so short a run: '
"""Beginning of the reasons that a longer run removes."""


class RateError(NamedTuple):
    """How well the mean rate of a run is known.

    Attributes:
        standard_error_s_per_day: of the mean rate [s/day]; None where it cannot be known.
        length_s: length of the run [s].
        why_unknown: the reason for None, with the remedy where there is one; otherwise empty.
    """

    standard_error_s_per_day: float | None
    length_s: float
    why_unknown: str = ''


class RateScatter:
    """Takes the readings of a dial in order, in batches of any size, and keeps 1,025 of them.

    With y the rate and T the length of the run, the coefficients

        c_j = √2/T ∫ y(t) cos(πjt/T) dt,   j = 1, 2, …

    have the variance of the mean rate itself where y has no memory longer than T/j, however it is
    correlated over shorter times: both are the density of y at frequencies near zero, over T. So
    the mean of the first `SLOWEST` c_j² is the square of the standard error (the equally weighted
    cosine estimator: Müller, J. Econometrics 141, 2007; Lazarus, Lewis, Stock and Watson, JBES
    36, 2018). It holds in two more cases. Jitter of the readings at both ends of the run gives
    c_j² twice the variance of the mean. A transient at the start that has died away gives c_j √2
    times the bias of the mean.

    A rate that forgets e-fold in θ has c_j² that fall off as 1/(1 + (πjθ/T)²), and a mean of the
    variance c_0² (1 − θ/T (1 − exp(−T/θ))). The likelihood of the first `COSINES`, normal and
    independent, weighs the `MEMORIES`; the square of the standard error is the mean over them.
    Where a memory beyond `LONGEST` is likelier than not, the error is not known.

    Args:
        first_ns: stamp of the first reading [ns].
        length_ns: length of the run [ns], > 0; it may end early.
    """

    def __init__(self, first_ns: int, length_ns: int) -> None:
        self._ends_ns = np.array(
            [first_ns + part * length_ns // PARTS for part in range(PARTS + 1)], dtype=np.int64
        )
        self._passed = 0
        self._kept: list[tuple[int, int]] = []

    def feed(self, readings: TimeSamples) -> None:
        """Keep the first reading at or after the end of each part."""
        stamps = readings.stamp_ns
        if not len(stamps):
            return
        reached = int(np.searchsorted(self._ends_ns, stamps[-1], side='right'))
        places = np.unique(np.searchsorted(stamps, self._ends_ns[self._passed : reached]))
        self._passed = max(self._passed, reached)
        for reading in zip(
            stamps[places].tolist(), readings.time_ref_ns[places].tolist(), strict=True
        ):
            if reading not in self._kept[-1:]:
                self._kept.append(reading)

    def rate_error(self) -> RateError:
        """Return how well the mean rate of the readings so far is known."""
        kept = np.array(self._kept, dtype=np.int64).reshape(-1, 2)
        parts = max(len(kept) - 1, 0)
        length_s = float(kept[-1, 0] - kept[0, 0]) / NS_PER_S if parts else 0.0
        if parts < LEAST_PARTS:
            return RateError(
                None,
                length_s,
                f'{TOO_SHORT}it is logged {len(kept)} times, and how its rate scatters shows in '
                f'{LEAST_PARTS + 1} or more. Sail longer, or log more often',
            )
        squares = _cosines(kept) ** 2
        if not squares.any():
            return RateError(0.0, length_s)
        shape = 1.0 / (1.0 + (np.pi * np.outer(MEMORIES, np.arange(1, COSINES + 1))) ** 2)
        levels = squares / shape
        likely = -0.5 * np.sum(np.log(shape) + np.log(np.mean(levels, 1))[:, None], axis=1)
        chance = np.exp(likely - np.max(likely))
        chance /= np.sum(chance)
        of_mean = 1.0 - MEMORIES * (1.0 - np.exp(-1.0 / MEMORIES))
        sigma = math.sqrt(float(np.sum(chance * np.mean(levels[:, :SLOWEST], 1) * of_mean)))
        if np.sum(chance[MEMORIES > LONGEST]) > 0.5 and sigma > NEGLIGIBLE_S_PER_DAY:
            return RateError(
                None,
                length_s,
                f'{TOO_SHORT}its rate still changes from one end to the other, so the mean is '
                f'known to {sigma:.2g} s/day at best. Sail longer',
            )
        return RateError(sigma, length_s)


def _cosines(kept: IntArray) -> FloatArray:
    """Return c_j [s/day] for j = 1 to `COSINES`, the rate being constant in each part.

    Args:
        kept: stamps and readings [ns], (n, 2), n > 1.
    """
    elapsed, gained = kept[:, 0] - kept[0, 0], kept[:, 1] - kept[:, 0]
    rate = np.diff(gained) / np.diff(elapsed) * SECONDS_PER_DAY
    turns = math.pi * np.arange(1, COSINES + 1)[:, None]
    weights = np.diff(np.sin(turns * (elapsed / elapsed[-1])), axis=1) / turns
    cosines: FloatArray = math.sqrt(2.0) * np.sum(weights * rate, axis=1)
    return cosines
