"""Which kind of noise a clock has at each averaging time, with its probability.

From m to 2m the mean square of third differences of averaged phases changes by about 2^(1−α):
halved of white PM, doubled of white FM, eightfold of random-walk FM, whatever drift the rate has.
Expectation and scatter of each such ratio are known for each kind (`power_law`), so that Bayes'
rule weighs the kinds: all alike at first, and at each doubling a kind may give way to another with
a small probability, since a clock is of different kinds at short and at long times. Long averaging
times, of which a record holds few, so lean on the shorter ones, as far as they go together.
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
"""Probability that a clock is of another kind at twice an averaging time."""


def weights_of_kinds(phase: FloatArray, octaves: int) -> FloatArray:
    """Return the probability of each of the `KINDS` at m = 1, 2, 4, …, (octaves, kinds).

    Args:
        phase: evenly spaced phases without their trend, at least 4·2^octaves of them.
        octaves: averaging times, ≥ 2.
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
    # the first ratio tells of m = 1 as well
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
    """Return how likely the logarithm of a ratio of mean squares is, less a constant.

    Each of the two is χ² by its degrees of freedom; their ratio's logarithm is nearly normal.
    """
    from scipy import special  # slow to import

    halves = np.array([1.0 / pair(alpha, each, each, count).shared for each in (before, after)])
    both = pair(alpha, before, after, count)
    lower, upper = (special.digamma(halves) - np.log(halves)).tolist()
    # the trigamma function is the zeta function of order two
    variance = float(np.sum(special.zeta(2.0, halves))) - 2.0 * both.shared
    wrong = grown - (math.log(both.ratio) + upper - lower)
    return float(-0.5 * (wrong * wrong / variance + math.log(variance)))
