"""Stability of a clock: the Allan deviation and related ones, with confidence intervals.

`allantools` computes the deviations (Riley, Handbook of Frequency Stability Analysis, NIST SP
1065, 2008). Each interval weights the possible kinds of noise by their probability, with the
degrees of freedom of each kind.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from tauto_core.curves.numerics import bracketed_newton
from tauto_core.samples import FloatArray, IntArray, TimeSamples
from tauto_core.scene.errors import EstimationError
from tauto_core.scene.times import NS_PER_S

# -----------------------------------------------------------------------------
# Estimated variances of power-law noise: their expectation and their scatter.
#
# The errors of a clock are sampled phases with the spectrum S_x(f) ~ (2 sin πfτ₀)^(α−2), the
# noise of Kasdin and Walter (IEEE Frequency Control Symposium, 1992): α = 2 is white PM, 0 white
# FM, −2 random-walk FM. A variance of the Allan family is the mean square of M overlapping
# differences of order d over m samples. A modified one first averages phases over m samples. The
# differences are stationary, with the spectrum
#
#     S_z(f) ~ (2 sin πfτ₀)^(α−2+2d) D^2d (D/m)²,    D = sin πmfτ₀/sin πfτ₀,
#
# without (D/m)² if phases are not averaged, and with an autocorrelation ρ_j. For Gaussian noise
# the estimate then scatters as χ² with ν = M/(1 + 2 Σ (1 − j/M) ρ_j²) degrees of freedom.
# Greenhall and Riley (Uncertainty of stability variances based on finite differences, PTTI 2003)
# give ν for phases that were averaged over the sampling interval. A dial is read at an instant,
# which at m = 1 makes ν smaller by up to a sixth, or larger by a third.

LARGEST = 64
"""Averaging time, in intervals, above which it may be taken as continuous."""

# Length of the transform in spans of the difference. Beyond it ρ² is below 1e-6.
_PERIODS = 32


class Difference(NamedTuple):
    """A difference of phases with a variance as its mean square.

    Attributes:
        order: d, 2 (Allan) or 3 (Hadamard).
        factor: m, the averaging time in sampling intervals.
        modified: whether phases are averaged over m samples first.
    """

    order: int
    factor: int
    modified: bool

    @property
    def extent(self) -> int:
        """Number of samples over which one difference extends, less one."""
        return self.order * self.factor + (self.factor - 1 if self.modified else 0)


class Pair(NamedTuple):
    """The relation of two estimates from the same readings.

    Attributes:
        ratio: expectation of the mean square of the second difference over the first.
        shared: covariance of the relative errors of both mean squares.
    """

    ratio: float
    shared: float


def degrees_of_freedom(alpha: int, difference: Difference, count: int) -> float:
    """Return the degrees of freedom of an estimated variance, 2/(its relative variance).

    It is the mean square of a difference of `count` readings. α of the noise is at least 2 − 2d.
    """
    return 2.0 / pair(alpha, difference, difference, count).shared


def pair(alpha: int, first: Difference, second: Difference, count: int) -> Pair:
    """Return the ratio and the covariance of the mean squares of two differences.

    If the averaging time is many intervals, only its ratio to the length of the record matters,
    except for phase noise that is not averaged: there neighbouring samples are independent. Both
    differences have one order d and are modified or not. α of the noise is at least 2 − 2d.
    """
    factor = max(first.factor, second.factor)
    if factor > LARGEST and (first.modified or alpha <= 0):
        count = round(count * LARGEST / factor)
        first, second = (
            diff._replace(factor=round(diff.factor * LARGEST / factor)) for diff in (first, second)
        )
    return _pair(alpha, first, second, count)


@lru_cache(maxsize=4096)
def _pair(alpha: int, first: Difference, second: Difference, count: int) -> Pair:
    span = max(first.extent, second.extent)
    length = 2 ** math.ceil(math.log2(min(_PERIODS * (span + 1), 2 * count)))
    sine = np.asarray(2.0 * np.sin(np.pi / length * np.arange(length // 2 + 1)))
    spectrum = sine ** (alpha - 2 + 2 * first.order)
    first_response = _response(first, length)
    second_response = first_response if first == second else _response(second, length)
    crossed = np.fft.irfft(spectrum * first_response * second_response)
    # the covariance at lag zero, the mean over both halves of the spectrum
    powers = [spectrum * response * response for response in (first_response, second_response)]
    sizes = [
        float(np.sum(power[:-1]) + np.sum(power[1:])) / (2.0 * (len(power) - 1))
        for power in powers
    ]
    counts = count - first.extent, count - second.extent
    # differences are paired by the distance of their middles
    lags = np.arange(min(max(counts), length // 2))
    pairs = np.clip(0.5 * sum(counts) - lags, 0.0, min(counts))
    squares = crossed[: len(lags)] ** 2 * pairs
    total = float(2.0 * np.sum(squares) - squares[0]) / (sizes[0] * sizes[1])
    return Pair(sizes[1] / sizes[0], 2.0 * total / (counts[0] * counts[1]))


def _response(difference: Difference, length: int) -> FloatArray:
    """Return D^d, times D/m of a modified variance, on the frequencies of a transform."""
    m, place = difference.factor, np.arange(1, length // 2 + 1)
    # reduced in integers: high frequencies are rounded no more than low ones
    turned = np.sin(np.pi / length * (place * m % (2 * length)))
    ratio = np.append(float(m), turned / np.sin(np.pi / length * place))
    response: FloatArray = ratio**difference.order
    return response * (ratio / m) if difference.modified else response


# -----------------------------------------------------------------------------
# The kind of noise of a clock at each averaging time, with its probability.
#
# From m to 2m the mean square of third differences of averaged phases changes by about 2^(1−α):
# by a half for white PM, twofold for white FM, eightfold for random-walk FM, whatever the drift
# of the rate. Expectation and scatter of each such ratio are known for each kind, so Bayes' rule
# gives the probabilities of the kinds, with equal ones at first. At each doubling a kind may
# change into another with a small probability, since a clock has different noise at short and at
# long times. So long averaging times, of which a record has few, also use the shorter ones.

NOISES = {
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
"""Probability of another kind of noise at twice an averaging time."""


def weights_of_kinds(phase: FloatArray, octaves: int) -> FloatArray:
    """Return the probability of each of the `NOISES` at m = 1, 2, 4, …, (octaves >= 2, kinds).

    The phases, at least 4·2^octaves, are evenly spaced and without their trend.
    """
    differences = [Difference(ORDER, 2**k, True) for k in range(octaves)]
    squares = [mean_square(phase, difference) for difference in differences]
    weight = np.full(len(NOISES), 1.0 / len(NOISES))
    weights = []
    for fine, coarse, *sizes in zip(
        differences, differences[1:], squares, squares[1:], strict=False
    ):
        weight = (1.0 - CHANGE) * weight + CHANGE * (1.0 - weight) / (len(NOISES) - 1)
        if min(sizes) > 0.0:
            grown = math.log(sizes[1] / sizes[0])
            fit = np.array([_log_likelihood(grown, a, fine, coarse, len(phase)) for a in NOISES])
            weight = weight * np.exp(fit - np.max(fit))
            weight = weight / np.sum(weight)
        weights.append(weight)
    # the first ratio also gives the kind at m = 1
    return np.array([weights[0], *weights])


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
    grown: float, alpha: int, fine: Difference, coarse: Difference, count: int
) -> float:
    """Return the log-likelihood of the log of a ratio of two χ² mean squares, less a constant."""
    from scipy import special  # slow to import

    halves = np.array([1.0 / pair(alpha, diff, diff, count).shared for diff in (fine, coarse)])
    joint = pair(alpha, fine, coarse, count)
    lower, upper = (special.digamma(halves) - np.log(halves)).tolist()
    # the trigamma function is the zeta function of order two
    variance = float(np.sum(special.zeta(2.0, halves))) - 2.0 * joint.shared
    wrong = grown - (math.log(joint.ratio) + upper - lower)
    return float(-0.5 * (wrong * wrong / variance + math.log(variance)))


# Probability that a confidence interval contains the true deviation of the clock.
_CONFIDENCE = 0.95

FEWEST = 32
"""Least number of readings that identify the kind of noise."""

NEGLIGIBLE = 1e-4
"""Probability of a kind of noise below which it is ignored."""

SAME = 1e-9
"""Relative accuracy of the ends of an interval."""

SHARE = 6
"""τ is at most a sixth of the record: a Hadamard deviation spans three τ, twice over."""

JITTER = 0.01
"""Largest irregularity of evenly spaced readings, relative to their interval."""


def stability_of(reading: TimeSamples) -> dict[str, Any]:
    """Return the stability of a clock from its readings as plain values.

    `samples`, `interval_s`, `confidence`, and `rows`: for each τ `tau_s`, `noise` and its
    `noise_probability`, and value and confidence interval (`allan`, `allan_low`, `allan_high`, …)
    of `allan`, `modified` and `hadamard` in relative frequency and of `time` in seconds. Readings
    that are too few, not evenly spaced, or noiseless are an EstimationError.
    """
    error, interval_s = error_of(reading)
    columns = {
        name: np.asarray(column).tolist() for name, column in stability(error, interval_s).items()
    }
    return {
        'samples': len(error),
        'interval_s': interval_s,
        'confidence': _CONFIDENCE,
        'rows': [
            dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
        ],
    }


def error_of(reading: TimeSamples) -> tuple[FloatArray, float]:
    """Return the clock's error at each reading [s] and the time between readings [s].

    Fewer than `FEWEST` readings, or uneven ones, are an EstimationError.
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
        place = int(odd[0])
        raise EstimationError(
            f'the reading at {stamps[place + 1] / NS_PER_S:.9g} s comes '
            f'{steps[place] / NS_PER_S:.9g} s after the one before, most come '
            f'{interval / NS_PER_S:.9g} s after: stability needs evenly spaced readings. '
            'Take a part of the bag without gaps'
        )
    error: FloatArray = (reading.time_ref_ns - stamps) / NS_PER_S
    return error, interval / NS_PER_S


def stability(
    error_s: FloatArray, interval_s: float, factors: tuple[int, ...] | None = None
) -> dict[str, Any]:
    """Return deviations of a clock from its errors [s] at even intervals, by columns (n,).

    The columns are the keys of the rows of `stability_of`. Averaging times are increasing
    `factors` of the interval, or powers of two, up to a sixth of the readings. Fewer than `FEWEST`
    errors, or a parabola to rounding, are an EstimationError.
    """
    import allantools

    error = np.asarray(error_s, np.float64)
    max_factor = (len(error) - 1) // SHARE
    if len(error) < FEWEST or (factors is not None and factors[-1] > max_factor):
        raise EstimationError(
            f'{len(error)} readings are too few: it takes {FEWEST}, and {SHARE} τ. Give more of '
            'them, or a shorter τ'
        )
    if factors is None:
        factors = tuple(2**k for k in range(max_factor.bit_length()))
    # no deviation depends on the straight line through the ends
    error = error - error[0] - (error[-1] - error[0]) * (np.arange(len(error)) / (len(error) - 1))
    third = np.diff(error, 3)
    if np.abs(third).max() <= 8.0 * np.finfo(np.float64).eps * np.abs(error_s).max():
        raise EstimationError(
            'the errors of the clock lie on a parabola: its rate is steady or changes steadily, '
            'and there is no noise to measure. Leave out the stability'
        )
    by_octave = weights_of_kinds(error, max_factor.bit_length())
    weights = by_octave[[factor.bit_length() - 1 for factor in factors]]
    rate = 1.0 / interval_s
    taus = np.array(factors) * interval_s
    kinds = list(NOISES.values())
    columns: dict[str, Any] = {
        'tau_s': taus,
        'noise': [kinds[place] for place in np.argmax(weights, axis=1)],
        'noise_probability': np.max(weights, axis=1),
    }
    for kind, name, order, scale in (
        ('allan', 'oadev', 2, 1.0),
        ('modified', 'mdev', 2, 1.0),
        ('time', 'mdev', 2, taus / np.sqrt(3.0)),
        ('hadamard', 'ohdev', 3, 1.0),
    ):
        deviation = getattr(allantools, name)(error, rate=rate, data_type='phase', taus=taus)[1]
        differences = [Difference(order, factor, name == 'mdev') for factor in factors]
        low, high = deviation * _bounds(weights, differences, len(error))
        columns |= {
            kind: scale * deviation,
            f'{kind}_low': scale * low,
            f'{kind}_high': scale * high,
        }
    return columns


def _bounds(weights: FloatArray, differences: list[Difference], count: int) -> FloatArray:
    """Return the ratios of the interval's ends to the estimated deviation, (2, n).

    For one kind of noise ν V/σ² is χ² with ν degrees of freedom, with the estimated variance V and
    the true one σ². This distribution is averaged over the kinds with their probabilities (n,
    kinds), and cut at both ends with equal probability.
    """
    from scipy import special

    weight = np.where(weights > NEGLIGIBLE, weights, 0.0)
    weight = weight / np.sum(weight, axis=1, keepdims=True)
    freedom = np.ones_like(weight)
    for row, column in np.argwhere(weight).tolist():
        difference = differences[row]
        # a noise redder than the difference allows has the degrees of the reddest allowed one
        alpha = max(list(NOISES)[column], 2 - 2 * difference.order)
        freedom[row, column] = degrees_of_freedom(alpha, difference, count)
    level = 0.5 * np.array([1.0 - _CONFIDENCE, 1.0 + _CONFIDENCE])[:, None]
    # logarithms of σ²/V at which one kind alone reaches the level
    ends = np.log(freedom / special.chdtri(freedom, level[:, :, None]))

    def excess(u: FloatArray) -> tuple[FloatArray, FloatArray]:
        chi, shape = freedom * np.exp(-u[:, :, None]), 0.5 * freedom
        density = np.exp(shape * np.log(0.5 * chi) - 0.5 * chi - special.gammaln(shape))
        below = np.sum(weight * special.chdtrc(freedom, chi), axis=-1)
        return below - level, np.sum(weight * density, axis=-1)

    lowest = np.min(ends, axis=-1, where=weight > 0.0, initial=math.inf)
    highest = np.max(ends, axis=-1, where=weight > 0.0, initial=-math.inf)
    start = np.sum(weight * ends, axis=-1)
    roots = bracketed_newton(excess, start, (lowest, highest), absolute=SAME)
    return np.asarray(np.exp(0.5 * roots))
