"""Gauss–Legendre collocation with 8 stages on [0, 1]: order 16, symmetric, symplectic.

The stage derivatives f(c_j) determine a polynomial of degree 7, in Legendre polynomials of 2x − 1
and as its integral in powers of x:

    f(x) = Σ_n F_n P_n(2x − 1),    F = PROJECTION · (f(c_1) … f(c_8)),
    ∫_0^x f = x · Σ_n G_n x^n,     G = INTEGRAL · (f(c_1) … f(c_8)).

Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.7;
J. C. Butcher, Implicit Runge–Kutta processes, Math. Comp. 18 (1964).
"""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from tauto_core.samples import FloatArray

STAGES = 8
DIGITS = 40
"""Of the decimal arithmetic: all constants are rounded once, at the end."""


def _polynomials(x: Any) -> Any:
    """Return P_0 … P_8 at x, (9, n), by their recurrence."""
    rows = [0 * x + 1, x]
    for n in range(1, STAGES):
        rows.append(((2 * n + 1) * x * rows[n] - n * rows[n - 1]) / (n + 1))
    return np.array(rows)


def _powers() -> Any:
    """Return the coefficients of ∫ P_n(2x − 1) / x, (8, 8): POWERS[j, n] of x^j."""
    rows = [[Decimal(0)] * STAGES for _ in range(STAGES)]
    for n in range(STAGES):
        for j in range(n + 1):
            sign = -1 if (n + j) % 2 else 1
            rows[j][n] = Decimal(sign * math.comb(n, j) * math.comb(n + j, j)) / (j + 1)
    return np.array(rows)


def _constants() -> tuple[FloatArray, ...]:
    """Return c_i, b_i, the projection, a_ij and the integral, each correctly rounded."""
    with localcontext() as context:
        context.prec = DIGITS
        roots = np.array([Decimal(float(x)) for x in legendre.leggauss(STAGES)[0]])
        for _ in range(3):
            values = _polynomials(roots)
            slope = STAGES * (roots * values[-1] - values[-2]) / (roots * roots - 1)
            roots = roots - values[-1] / slope
        values = _polynomials(roots)[:STAGES]
        weights = (1 - roots * roots) / (STAGES * values[-1]) ** 2
        degree = np.array([[Decimal(2 * n + 1)] for n in range(STAGES)])
        projection = degree * weights * values
        values = _polynomials(roots)
        integrals = (values[2:] - values[:-2]) / (2 * degree[1:])
        integrals = np.concatenate([[(roots + 1) / 2], integrals])
        found = (
            (roots + 1) / 2,
            weights,
            projection,
            projection.T @ integrals,
            _powers() @ projection,
        )
    return tuple(np.array(each, np.float64) for each in found)


NODES, WEIGHTS, PROJECTION, COLUMNS, INTEGRAL = _constants()
"""The nodes c_i and weights b_i, (8,); the Legendre coefficients from the values at the nodes,
(8, 8); COLUMNS[j, i] = a_ij = ∫_0^{c_i} ℓ_j, (8, 8), contiguous; the powers of the integral from
the values at the nodes, (8, 8)."""
