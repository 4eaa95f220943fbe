"""Polynomials that stand for the ship's motion between its samples.

Roll comes with its rate: four samples give a Hermite polynomial of degree 7. The specific force
comes without: ten samples give a Lagrange polynomial of degree 9. Both are written in powers of
x = (t − t_k)/(t_{k+1} − t_k), which is well conditioned on 0 ≤ x ≤ 1.

Interpolation error for a wave of angular frequency Ω sampled every h, of unit amplitude, at the
middle of the interval: roll (Ωh)⁸ (3/4)⁴/8! = 8e-6 (Ωh)⁸, force (Ωh)¹⁰ (945/32)²/10! =
2.4e-4 (Ωh)¹⁰; for a period of 5 s at 20 Hz both are below 2e-15. Source: the remainder of
(Hermite) interpolation, e.g. Stoer & Bulirsch, Introduction to Numerical Analysis, 2.1.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import FloatArray, IntArray

ROLL_BEFORE, ROLL_POINTS = 1, 4
FORCE_BEFORE, FORCE_POINTS = 4, 10


def _inverse(rows: list[list[Fraction]]) -> FloatArray:
    """Return the inverse of a small exact matrix by Gauss–Jordan elimination."""
    n = len(rows)
    work = [[*row, *(Fraction(int(i == j)) for j in range(n))] for i, row in enumerate(rows)]
    for i in range(n):
        pivot = next(r for r in range(i, n) if work[r][i] != 0)
        work[i], work[pivot] = work[pivot], work[i]
        work[i] = [value / work[i][i] for value in work[i]]
        for r in range(n):
            if r != i and work[r][i] != 0:
                work[r] = [a - work[r][i] * b for a, b in zip(work[r], work[i], strict=True)]
    return np.array([[float(value) for value in row[n:]] for row in work])


def _conditions(nodes: tuple[Fraction, ...], slopes: bool) -> list[list[Fraction]]:
    """Return the interpolation conditions on the coefficients: values, then slopes."""
    size = len(nodes) * (2 if slopes else 1)
    rows = [[node**j for j in range(size)] for node in nodes]
    if slopes:
        rows += [
            [j * node ** (j - 1) if j else Fraction(0) for j in range(size)] for node in nodes
        ]
    return rows


@lru_cache(maxsize=64)
def _regular(begin: int, points: int, slopes: bool) -> FloatArray:
    """Return the transposed matrix from values (and slopes in x) at x = begin, begin + 1, … ."""
    return np.ascontiguousarray(
        _inverse(_conditions(tuple(Fraction(begin + i) for i in range(points)), slopes)).T
    )


def _irregular(nodes: FloatArray, data: FloatArray, slopes: bool) -> FloatArray:
    """Return the coefficients for samples at any x."""
    size = len(data)
    powers = nodes[:, None] ** np.arange(size)
    if slopes:
        steepness = np.zeros_like(powers)
        steepness[:, 1:] = np.arange(1, size) * powers[:, :-1]
        powers = np.concatenate([powers, steepness])
    return np.asarray(np.linalg.solve(powers, data))


def polynomials(
    stamps_ns: IntArray,
    values: FloatArray,
    rates: FloatArray | None,
    first: IntArray,
    points: int,
    piece: IntArray,
) -> FloatArray:
    """Return the coefficients over some pieces, shape (n, points) or with rates (n, 2·points).

    Args:
        stamps_ns: stamps of the samples [ns], strictly increasing, (m,).
        values: the channel, (m,).
        rates: its time derivative [1/s], or None.
        first: index of the first sample of each piece's window, (n,).
        points: samples in a window.
        piece: index of the sample at which each piece begins; it ends at the next, (n,).
    """
    from tauto_core.ship.kernels import fit_windows  # imports numba

    slopes = rates is not None
    lengths = stamps_ns[piece + 1] - stamps_ns[piece]
    length_s = np.asarray(lengths * 1e-9, np.float64)
    result = np.empty((len(piece), points * (2 if slopes else 1)))
    regular = _even(stamps_ns, first, points)
    begin = first - piece
    for shift in np.unique(begin).tolist():
        rows = np.flatnonzero(regular & (begin == shift))
        columns = _regular(shift, points, slopes)
        fit_windows(columns, values, rates, length_s, first, rows, result)
    for row in np.flatnonzero(~regular):
        window = slice(first[row], first[row] + points)
        nodes = (stamps_ns[window] - stamps_ns[piece[row]]) / lengths[row]
        data = values[window]
        if rates is not None:
            data = np.concatenate([data, rates[window] * (lengths[row] * 1e-9)])
        result[row] = _irregular(nodes, data, slopes)
    return result


def _even(stamps_ns: IntArray, first: IntArray, points: int) -> NDArray[np.bool_]:
    """Return which windows hold evenly spaced samples."""
    steps = np.diff(stamps_ns)
    uneven = np.concatenate([[0], np.cumsum(steps[1:] != steps[:-1])])
    return np.asarray(uneven[first + points - 2] == uneven[first])
