"""The kind of noise of a clock at each averaging time, with its probability.

From m to 2m the mean square of third differences of averaged phases changes by about 2^(1−α):
by a half for white PM, twofold for white FM, eightfold for random-walk FM, whatever the drift of
the rate. Expectation and scatter of each such ratio are known for each kind (`power_law`), so
Bayes' rule gives the probabilities of the kinds. All are equal at first. At each doubling a kind
may change into another with a small probability, since a clock has different kinds of noise at
short and at long times. So long averaging times, of which a record has few, also use the shorter
ones.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.navigation.power_law import Difference, pair
from tauto_core.samples import FloatArray

KINDS = {
    2: 'white PM',
    1: 'flicker PM',
    0: 'white FM',
    -1: 'flicker FM',
    -2: 'random walk FM',
    -3: 'flicker walk FM',
}
"""Kinds of noise by the exponent α of the spectrum of the frequency, S_y ~ f^α."""

ORDER = 3

CHANGE = 0.05
"""Probability that the noise is of another kind at twice an averaging time."""


def weights_of_kinds(phase: FloatArray, octaves: int) -> FloatArray:
    """Return the probability of each of the `KINDS` at m = 1, 2, 4, …, (octaves, kinds).

    Args:
        phase: evenly spaced phases without their trend, at least 4·2^octaves of them.
        octaves: number of averaging times, ≥ 2.
    """
    differences = [Difference(ORDER, 2**k, True) for k in range(octaves)]
    squares = [mean_square(phase, difference) for difference in differences]
    weight = np.full(len(KINDS), 1.0 / len(KINDS))
    found = []
    for before, after, *sizes in zip(
        differences, differences[1:], squares, squares[1:], strict=False
    ):
        weight = (1.0 - CHANGE) * weight + CHANGE * (1.0 - weight) / (len(KINDS) - 1)
        if min(sizes) > 0.0:
            grown = math.log(sizes[1] / sizes[0])
            fit = np.array([_log_likelihood(grown, a, before, after, len(phase)) for a in KINDS])
            weight = weight * np.exp(fit - np.max(fit))
            weight = weight / np.sum(weight)
        found.append(weight)
    # the first ratio also gives the kind at m = 1
    return np.array([found[0], *found])


def mean_square(phase: FloatArray, difference: Difference) -> float:
    """Return the mean square of all overlapping differences of phases."""
    m = difference.factor
    if difference.modified:
        sums = np.concatenate([[0.0], np.cumsum(phase)])
        phase = (sums[m:] - sums[:-m]) / m
    for _ in range(difference.order):
        phase = phase[m:] - phase[:-m]
    return float(np.mean(phase * phase))


def _log_likelihood(
    grown: float, alpha: int, before: Difference, after: Difference, count: int
) -> float:
    """Return the log-likelihood of the logarithm of a ratio of mean squares, less a constant.

    Each of the two is χ² with its degrees of freedom; the logarithm of their ratio is nearly
    normal.
    """
    from scipy import special  # slow to import

    halves = np.array([1.0 / pair(alpha, each, each, count).shared for each in (before, after)])
    both = pair(alpha, before, after, count)
    lower, upper = (special.digamma(halves) - np.log(halves)).tolist()
    # the trigamma function is the zeta function of order two
    variance = float(np.sum(special.zeta(2.0, halves))) - 2.0 * both.shared
    wrong = grown - (math.log(both.ratio) + upper - lower)
    return float(-0.5 * (wrong * wrong / variance + math.log(variance)))
