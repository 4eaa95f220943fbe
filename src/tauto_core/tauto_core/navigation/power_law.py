"""Estimated variances of power-law noise: their expectation and their scatter.

The errors of a clock are sampled phases with the spectrum S_x(f) ~ (2 sin πfτ₀)^(α−2), the noise
of Kasdin and Walter (IEEE Frequency Control Symposium, 1992): α = 2 is white PM, 0 white FM, −2
random-walk FM. A variance of the Allan family is the mean square of M overlapping differences
of order d over m samples; for a modified one, phases are first averaged over m samples. The
differences are stationary, with the spectrum

    S_z(f) ~ (2 sin πfτ₀)^(α−2+2d) D^2d (D/m)²,    D = sin πmfτ₀/sin πfτ₀,

without (D/m)² where phases are not averaged, and with an autocorrelation ρ_j. For Gaussian noise
the estimate then scatters as χ² with ν = M/(1 + 2 Σ (1 − j/M) ρ_j²) degrees of freedom. Greenhall
and Riley (Uncertainty of stability variances based on finite differences, PTTI 2003) give ν for
phases that were averaged over the sampling interval. A dial is read at an instant, which at
m = 1 makes ν smaller by up to a sixth, or larger by a third.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from tauto_core.samples import FloatArray

LARGEST = 64
"""Averaging time, in intervals, beyond which it may be taken as continuous."""

_PERIODS = 32
"""Length of the transform in spans of the difference; beyond it ρ² is below 1e-6."""


class Difference(NamedTuple):
    """The difference of phases whose mean square is a variance.

    Attributes:
        order: d, 2 (Allan) or 3 (Hadamard).
        factor: m, the averaging time in sampling intervals.
        modified: whether phases are averaged over m samples first.
    """

    order: int
    factor: int
    modified: bool

    @property
    def span(self) -> int:
        """Number of samples over which one difference extends, less one."""
        return self.order * self.factor + (self.factor - 1 if self.modified else 0)


class Pair(NamedTuple):
    """The relation of two estimates from the same readings.

    Attributes:
        ratio: expectation of the mean square of the second difference over that of the first.
        shared: covariance of the relative errors of both mean squares.
    """

    ratio: float
    shared: float


def degrees_of_freedom(alpha: int, difference: Difference, count: int) -> float:
    """Return the degrees of freedom of an estimated variance, 2/(its relative variance).

    Args:
        alpha: α of the noise, at least 2 − 2d.
        difference: the difference whose mean square is the variance.
        count: number of the readings.
    """
    return 2.0 / pair(alpha, difference, difference, count).shared


def pair(alpha: int, first: Difference, second: Difference, count: int) -> Pair:
    """Return the ratio and the covariance of the mean squares of two differences.

    Where the averaging time is many intervals, only its ratio to the length of the record matters.
    Phase noise that is not averaged is an exception: there neighbouring samples are independent.

    Args:
        alpha: α of the noise, at least 2 − 2d of both.
        first: one of them.
        second: the other, of the same order, modified or not as the first.
        count: number of the readings.
    """
    factor = max(first.factor, second.factor)
    if factor > LARGEST and (first.modified or alpha <= 0):
        count = round(count * LARGEST / factor)
        first, second = (
            each._replace(factor=round(each.factor * LARGEST / factor)) for each in (first, second)
        )
    return _pair(alpha, first, second, count)


@lru_cache(maxsize=4096)
def _pair(alpha: int, first: Difference, second: Difference, count: int) -> Pair:
    span = max(first.span, second.span)
    length = 2 ** math.ceil(math.log2(min(_PERIODS * (span + 1), 2 * count)))
    spectrum = _sine(length) ** (alpha - 2 + 2 * first.order)
    one = _response(first, length)
    other = one if first == second else _response(second, length)
    crossed = np.fft.irfft(spectrum * one * other)
    sizes = [_mean(spectrum * each * each) for each in (one, other)]
    counts = count - first.span, count - second.span
    # differences are paired by the distance of their middles
    apart = np.arange(min(max(counts), length // 2))
    pairs = np.clip(0.5 * sum(counts) - apart, 0.0, min(counts))
    squares = crossed[: len(apart)] ** 2 * pairs
    total = float(2.0 * np.sum(squares) - squares[0]) / (sizes[0] * sizes[1])
    return Pair(sizes[1] / sizes[0], 2.0 * total / (counts[0] * counts[1]))


def _mean(spectrum: FloatArray) -> float:
    """Return the covariance at lag zero, the mean over both halves of a spectrum."""
    return float(np.sum(spectrum[:-1]) + np.sum(spectrum[1:])) / (2.0 * (len(spectrum) - 1))


def _sine(length: int) -> FloatArray:
    """Return 2 sin πf on the frequencies of a transform."""
    return np.asarray(2.0 * np.sin(np.pi / length * np.arange(length // 2 + 1)))


def _response(difference: Difference, length: int) -> FloatArray:
    """Return D^d, times D/m of a modified variance, on the frequencies of a transform."""
    m, place = difference.factor, np.arange(1, length // 2 + 1)
    # reduced in integers, so that high frequencies are rounded no more than low ones
    turned = np.sin(np.pi / length * (place * m % (2 * length)))
    ratio = np.append(float(m), turned / np.sin(np.pi / length * place))
    response: FloatArray = ratio**difference.order
    return response * (ratio / m) if difference.modified else response
