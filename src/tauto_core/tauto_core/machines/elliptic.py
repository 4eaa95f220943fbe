"""Jacobi's elliptic functions from the complementary parameter, good up to m = 1.

By the arithmetic–geometric mean (Abramowitz & Stegun 16.4, 17.6). Near m = 1 all depends on
m₁ = 1 − m, which m itself does not hold.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.samples import FloatArray

_STEPS = 12
"""Means taken: they agree to rounding down to m₁ = 1e-300."""


def quarter_period(complement: FloatArray) -> FloatArray:
    """Return K(m) = π/(2 agm(1, √m₁)).

    Args:
        complement: m₁ = 1 − m, 0 < m₁ ≤ 1.
    """
    one, other = np.ones_like(complement), np.sqrt(complement)
    for _ in range(_STEPS):
        one, other = 0.5 * (one + other), np.sqrt(one * other)
    return 0.5 * math.pi / one


def amplitude(argument: FloatArray, complement: FloatArray) -> FloatArray:
    """Return φ = am(u | m), so that sn = sin φ, cn = cos φ, dn² = m₁ + m cos²φ.

    Args:
        argument: u, 0 ≤ u ≤ K.
        complement: m₁ = 1 − m, 0 < m₁ ≤ 1, of the same shape.
    """
    one, other = np.ones_like(complement), np.sqrt(complement)
    ratios: list[FloatArray] = []
    for _ in range(_STEPS):
        mean = 0.5 * (one + other)
        ratios.append(0.5 * (one - other) / mean)
        one, other = mean, np.sqrt(one * other)
    phi = 2.0**_STEPS * one * argument
    for ratio in reversed(ratios):
        phi = 0.5 * (phi + np.arcsin(ratio * np.sin(phi)))
    return phi
