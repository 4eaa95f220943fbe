"""Power-law noise of exactly known spectrum, and its theoretical deviations.

Independent of `tauto_core`: the noise comes from its autocovariance (circulant embedding, Davies
and Harte, Biometrika 74, 1987; closed form for fractional noise of order −1/2, Hosking, Biometrika
68, 1981), the deviations from the integral of its spectrum. Phases at unit intervals have the
spectrum S_x = 2 (2 sin πf)^(α−2), 0 < f < 1/2 (Kasdin and Walter, 1992).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

Array = NDArray[np.float64]

NAMES = {2: 'white PM', 1: 'flicker PM', 0: 'white FM', -1: 'flicker FM', -2: 'random walk FM'}
# whether a half-order difference of white noise is taken, and how often it is summed to phases
_MADE_BY = {2: (False, 0), 1: (True, 1), 0: (False, 1), -1: (True, 2), -2: (False, 2)}
_NODES, _WEIGHTS = leggauss(40)


def noise(alpha: int, count: int, random: np.random.Generator) -> Array:
    """Return phases of power-law noise, exact in spectrum except for a straight line."""
    halved, sums = _MADE_BY[alpha]
    phase = _half_difference(count, random) if halved else random.standard_normal(count)
    for _ in range(sums):
        phase = np.cumsum(phase)
    return phase


def _half_difference(count: int, random: np.random.Generator) -> Array:
    """Return Gaussian noise of the spectrum 2 |2 sin πf|: of covariances (4/π)/(1 − 4k²)."""
    lag = np.arange(count + 1)
    covariance = (4.0 / math.pi) / (1.0 - 4.0 * lag * lag)
    powers = np.fft.rfft(np.concatenate([covariance, covariance[-2:0:-1]])).real
    white = np.fft.rfft(random.standard_normal(2 * count))
    made: Array = np.fft.irfft(white * np.sqrt(np.maximum(powers, 0.0)))[:count]
    return made


@cache
def variance(kind: str, alpha: int, factor: int) -> float:
    """Return a theoretical variance, the integral of S_x times its response.

    Args:
        kind: allan, modified or hadamard; time: τ²/3 times the modified one.
        alpha: exponent of the noise.
        factor: τ, a whole number of intervals.
    """
    if kind == 'time':
        return factor * factor / 3.0 * variance('modified', alpha, factor)
    edges = np.append(np.arange(0.0, 0.5, 1.0 / factor), 0.5)
    width = np.diff(edges)[:, None]
    f = edges[:-1, None] + 0.5 * width * (1.0 + _NODES)
    once, many = 2.0 * np.sin(np.pi * f), 2.0 * np.sin(np.pi * factor * f)
    response = many**6 / 6.0 if kind == 'hadamard' else many**4 / 2.0
    if kind == 'modified':
        response *= (many / (factor * once)) ** 2
    density = 2.0 * once ** (alpha - 2) * response / factor**2
    return float(np.sum(0.5 * width * _WEIGHTS * density))


def deviation(kind: str, parts: Mapping[int, float], factor: int) -> float:
    """Return the theoretical deviation of a sum of noises, each with its amplitude."""
    return math.sqrt(sum(a * a * variance(kind, alpha, factor) for alpha, a in parts.items()))


def mixed(parts: Mapping[int, float], count: int, random: np.random.Generator) -> Array:
    """Return phases of a sum of noises, each with its amplitude."""
    whole: Array = np.sum([a * noise(alpha, count, random) for alpha, a in parts.items()], axis=0)
    return whole
