"""Gauss–Legendre collocation with s stages on [0, 1]: order 2s, symmetric, symplectic.

The stage derivatives f(c_j) determine a polynomial of degree s − 1, in Legendre polynomials of
t = 2x − 1 and as its integral in powers of t, whose coefficients stay smaller than those of x:

    f(x) = Σ_n F_n P_n(t),         F = projection · (f(c_1) … f(c_s)),
    ∫_0^x f = x · Σ_n G_n t^n,     G = integral · (f(c_1) … f(c_s)).

Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.7;
J. C. Butcher, Implicit Runge–Kutta processes, Math. Comp. 18 (1964).
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre

from tauto_core.samples import FloatArray

DIGITS = 50
"""Digits of the decimal arithmetic: all constants are rounded once, at the end."""


class Gauss(NamedTuple):
    """The constants of a method of s stages.

    Attributes:
        nodes: c_i, (s,).
        weights: b_i, (s,).
        projection: the matrix from values at the nodes to Legendre coefficients F_n, (s, s).
        columns: columns[j, i] = a_ij = ∫_0^{c_i} ℓ_j, with Lagrange's polynomials ℓ_j, (s, s).
        integral: the matrix from values at the nodes to the powers G_n, (s, s).
        folded: `columns` by sums and differences over mirrored nodes j′ = s + 1 − j, for even s
            and h = s/2, (h + 1, s). Row j ≤ h is p_1j … p_hj q_1j … q_hj, with
            p_ij = (a_ij + a_ij′ − b_j)/2 and q_ij = (a_ij − a_ij′)/2; the last one is
            b_1/2 … b_h/2, twice (`lanes.folded_both`).
    """

    nodes: FloatArray
    weights: FloatArray
    projection: FloatArray
    columns: FloatArray
    integral: FloatArray
    folded: FloatArray


def _polynomials(x: Any, stages: int) -> Any:
    """Return P_0 … P_s at x, (s + 1, n), by their recurrence."""
    rows = [0 * x + 1, x]
    for n in range(1, stages):
        rows.append(((2 * n + 1) * x * rows[n] - n * rows[n - 1]) / (n + 1))
    return np.array(rows)


def _powers(stages: int) -> Any:
    """Return the coefficients of ∫ P_n(2x − 1) / x, (s, s): [j, n] of t^j.

    ∫ from −1 to t is (P_n+1 − P_n−1)/(2n + 1), half that in x, and divided by x = (1 + t)/2.
    """
    nothing = [Decimal(0)] * (stages + 1)
    series = [[Decimal(1), *nothing[1:]], [Decimal(0), Decimal(1), *nothing[2:]]]
    for n in range(1, stages):
        raised = [Decimal(0), *series[n][:-1]]
        pairs = zip(raised, series[n - 1], strict=True)
        series.append([((2 * n + 1) * a - n * b) / (n + 1) for a, b in pairs])
    before = [-Decimal(1), *nothing[1:]], *series
    columns = []
    for n in range(stages):
        pairs = zip(series[n + 1], before[n], strict=True)
        integral = [(a - b) / (2 * n + 1) for a, b in pairs]
        left, column = Decimal(0), []
        for j in range(stages, 0, -1):
            left = integral[j] - left
            column.append(left)
        columns.append(column[::-1])
    return np.array(columns).T


def _folded(columns: Any, weights: Any) -> Any:
    half = len(weights) // 2
    near, far = columns[:half, :half], columns[-1 : -half - 1 : -1, :half]
    shared = weights[:half] / 2
    rows = np.hstack([(near + far) / 2 - shared[:, None], (near - far) / 2])
    return np.vstack([rows, np.tile(shared, 2)])


@cache
def gauss(stages: int) -> Gauss:
    """Return the constants, each correctly rounded."""
    with localcontext() as context:
        context.prec = DIGITS
        roots = np.array([Decimal(float(x)) for x in legendre.leggauss(stages)[0]])
        for _ in range(3):
            values = _polynomials(roots, stages)
            slope = stages * (roots * values[-1] - values[-2]) / (roots * roots - 1)
            roots = roots - values[-1] / slope
        values = _polynomials(roots, stages)
        weights = (1 - roots * roots) / (stages * values[-2]) ** 2
        degree = np.array([[Decimal(2 * n + 1)] for n in range(stages)])
        projection = degree * weights * values[:-1]
        integrals = (values[2:] - values[:-2]) / (2 * degree[1:])
        integrals = np.concatenate([[(roots + 1) / 2], integrals])
        columns = projection.T @ integrals
        found = (
            (roots + 1) / 2,
            weights,
            projection,
            columns,
            _powers(stages) @ projection,
            _folded(columns, weights),
        )
    return Gauss(*(np.array(each, np.float64) for each in found))
