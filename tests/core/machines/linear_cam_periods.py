"""Period against amplitude for a linear lever arm, exactly and by series.

Euler's cams are isochronous for a constant pull without inertia. With a weight of mass m (theory
A; Euler 1727, XX) T/T₀ = (2/π) E(−ε), ε = m b²A²/I; with a spring (a Duffing oscillator)
T/T₀ = (2/π) K(η/(2(1 + η)))/√(1 + η), η = κbA²/(2P). E and K take the parameter.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.polynomial.polynomial import polyval

_SMALL = 0.05
_TERMS = 14
"""0.05 to the 14th is 6e-19, and the coefficients are below a half."""


def weight_period_series(order: int) -> list[Fraction]:
    """Return c₀ … c_order of T/T₀ = Σ c_n εⁿ for a weight: 1, 1/4, −3/64, 5/256, …

    c_n = (−1)ⁿ (C(2n, n)/4ⁿ)²/(1 − 2n), convergent for |ε| < 1.
    """
    return [
        (-1) ** n * _binomial(n) ** 2 / (1 - 2 * n) if n else Fraction(1) for n in range(order + 1)
    ]


def spring_period_series(order: int) -> list[Fraction]:
    """Return d₀ … d_order of T/T₀ = Σ d_n ηⁿ for a spring: 1, −3/8, 57/256, …

    From K(m) = (π/2) Σ (C(2n, n)/4ⁿ)² mⁿ with m = η/(2(1 + η)); convergent for |η| < 1.
    """
    return [
        sum(
            (_binomial(n) ** 2 / 2**n * _power(n, whole - n) for n in range(whole + 1)),
            Fraction(0),
        )
        for whole in range(order + 1)
    ]


def weight_period_excess(epsilon: float) -> float:
    """Return T/T₀ − 1 = (2/π) E(−ε) − 1 without cancellation.

    Args:
        epsilon: m b²A²/I ≥ 0, of the mass m, lever rate b and amplitude A.
    """
    from scipy.special import ellipe

    if epsilon < _SMALL:
        return _without_first(weight_period_series(_TERMS), epsilon)
    return float(ellipe(-epsilon)) * 2.0 / math.pi - 1.0


def spring_period_excess(eta: float) -> float:
    """Return T/T₀ − 1 = (2/π) K(η/(2(1 + η)))/√(1 + η) − 1 without cancellation.

    Args:
        eta: κbA²/(2P) ≥ 0, of the stiffness κ, lever rate b, amplitude A and pull P at rest.
    """
    from scipy.special import ellipk

    if eta < _SMALL:
        return _without_first(spring_period_series(_TERMS), eta)
    stretched = 1.0 + eta
    return float(ellipk(0.5 * eta / stretched)) * 2.0 / (math.pi * math.sqrt(stretched)) - 1.0


def _without_first(series: list[Fraction], x: float) -> float:
    return float(polyval(x, np.array([0.0, *map(float, series[1:])])))


def _binomial(n: int) -> Fraction:
    """Return C(2n, n)/4ⁿ."""
    return Fraction(math.comb(2 * n, n), 4**n)


def _power(n: int, k: int) -> Fraction:
    """Return the coefficient of x^k of (1 + x)^(−n − 1/2)."""
    found = Fraction(1)
    for j in range(k):
        found = found * (Fraction(-2 * n - 1, 2) - j) / (j + 1)
    return found
