"""Polynomials that represent the ship's motion between its samples.

A piece spans n samples. Roll comes with its rate: with one more sample on either side, n + 3
samples give a Hermite polynomial of degree 2n + 5 (with three more, where samples are coarse and
no polynomial is fitted, one of degree 2n + 13). The specific force comes without a rate: with
four more samples on either side, n + 9 samples give a Lagrange polynomial of degree n + 8. Both
are written in powers of x, which runs from 0 to 1 over the piece.

Remainder for a wave of angular frequency Ω sampled every h, of unit amplitude: at most
(Ωh)^w max|ω(u)|/w!, with w conditions and ω(u) the product of the distances to their nodes, in
samples, over the piece. For n = 1 that is, in the middle, for roll (Ωh)⁸ (3/4)⁴/8! =
8e-6 (Ωh)⁸ and for force (Ωh)¹⁰ (945/32)²/10! = 2.4e-4 (Ωh)¹⁰. Source: the remainder of (Hermite)
interpolation, e.g. Stoer & Bulirsch, Introduction to Numerical Analysis, 2.1.

Measured, for a wave of 5 s of unit amplitude: largest error of the value, of the first derivative
over Ω, of the second over Ω² (the last two are mostly rounding of the samples).

| n | force, 20 Hz       | roll, 20 Hz        | force, 10 Hz       | roll, 10 Hz        |
|---|--------------------|--------------------|--------------------|--------------------|
| 1 | 3e-16 1e-14 6e-13  | 2e-15 9e-15 1e-11  | 2e-13 6e-12 1e-10  | 5e-13 5e-14 8e-10  |
| 2 | 2e-16 4e-15 1e-13  | 2e-16 4e-15 3e-13  | 1e-14 4e-13 9e-12  | 7e-16 5e-15 1e-12  |
| 3 | 3e-16 7e-15 2e-13  | 2e-16 9e-15 5e-13  | 1e-15 3e-14 6e-13  | 2e-16 4e-15 1e-13  |
| 4 | 3e-16 4e-15 2e-13  | 2e-16 5e-15 9e-13  | 3e-16 5e-15 7e-14  | 3e-16 4e-15 1e-13  |
| 6 | 3e-16 8e-15 2e-13  | 3e-16 1e-14 2e-12  | 3e-16 5e-15 7e-14  | 2e-16 4e-15 5e-13  |
| 8 | 6e-16 1e-14 4e-13  | 7e-16 3e-14 1e-11  | 3e-16 6e-15 1e-13  | 7e-16 1e-14 3e-12  |

At the start of a run pieces span one sample, unless the motion is known to be smooth: wide
one-sided windows magnify noise up to a thousandfold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import FloatArray, IntArray

ROLL_BEFORE, ROLL_POINTS = 1, 4
FORCE_BEFORE, FORCE_POINTS = 4, 10
MAX_STRIDE = 8
"""Most samples that one piece spans."""

COARSE_NS, COARSE_BEFORE = 400_000_000, 3
"""Samples farther apart [ns] have wider windows where that costs little: the first piece, whose
window lies on one side, would be the worst by far. Closer ones would gain nothing by it but
rounding, which such windows magnify: at 2.5 Hz, in a sea with a peak at 9 s, both are alike.
"""


@dataclass(frozen=True)
class Pieces:
    """Pieces of motion between samples of a buffer, arrays of shape (n,).

    Attributes:
        begin: sample at which each piece begins.
        end: sample at which it ends.
        regular: whether the window is centred and evenly spaced; such pieces are of equal length.
    """

    begin: IntArray
    end: IntArray
    regular: NDArray[np.bool_]

    def part(self, which: slice | IntArray) -> Pieces:
        """Return some of the pieces."""
        return Pieces(self.begin[which], self.end[which], self.regular[which])


def _conditions(stride: int, before: int, *, slopes: bool) -> int:
    return (stride + 1 + 2 * before) * (2 if slopes else 1)


@lru_cache(maxsize=64)
def newton_basis(stride: int, before: int, *, slopes: bool) -> FloatArray:
    """Return the powers of x of Newton's basis over a piece of evenly spaced samples.

    Column k has the coefficients of Π_{i<k} (stride·x + before − z_i), with z = 0, 1, 2, … and a
    factor 1/k! for values, and z = 0, 0, 1, 1, … for values and slopes. Exact up to the rounding
    of each number.

    Args:
        stride: samples that the piece spans.
        before: samples before and after it.
        slopes: whether each node counts twice.
    """
    size = _conditions(stride, before, slopes=slopes)
    basis = np.zeros((-(-size // 2) * 2,) * 2)
    row = [Fraction(1)]
    for k in range(size):
        scale = 1 if slopes else math.factorial(k)
        basis[: k + 1, k] = [float(value / scale) for value in row]
        shift = before - (k // 2 if slopes else k)
        row = [
            shift * low + stride * high
            for low, high in zip([*row, Fraction(0)], [Fraction(0), *row], strict=True)
        ]
    return basis


def polynomials(
    stamps_ns: IntArray,
    values: FloatArray,
    rates: FloatArray | None,
    pieces: Pieces,
    *,
    stride: int,
    offset: int,
    wide: int | None = None,
) -> FloatArray:
    """Return the coefficients over some pieces, shape (n, w).

    w is that of a regular piece: stride + 9, with rates 2·(stride + 3). Others of several samples
    have windows as wide; those of one sample, with windows of `FORCE_POINTS` or `ROLL_POINTS`
    samples (fewer where there are no more), have zeros beyond.
    Windows that would reach before the first sample of the run or beyond the last at hand are
    shifted.

    Args:
        stamps_ns: stamps of the samples [ns], strictly increasing, (m,).
        values: the channel, (m,).
        rates: its time derivative [1/s], (m,), or None.
        pieces: the pieces wanted, in order, (n,).
        stride: samples that a regular piece spans.
        offset: index of the first sample at hand, counted from the start of the run.
        wide: samples before and after a piece of several samples; None: as above.
    """
    from tauto_core.ship.fitting import fit_hermite, fit_values, fit_windows  # imports kernels

    slopes = rates is not None
    before, points = (ROLL_BEFORE, ROLL_POINTS) if slopes else (FORCE_BEFORE, FORCE_POINTS)
    around = before if wide is None else wide
    size = _conditions(stride, around, slopes=slopes)
    result = np.empty((len(pieces.begin), size))
    if not len(result):
        return result
    rows = np.flatnonzero(pieces.regular)
    if len(rows):
        basis = newton_basis(stride, around, slopes=slopes)
        first = pieces.begin[rows] - around
        if rates is None:
            fit_values(basis, size, values, first, rows, result)
        else:
            step_s = np.asarray((stamps_ns[first + 1] - stamps_ns[first]) * 1e-9, np.float64)
            fit_hermite(basis, size, values, rates, step_s, first, rows, result)
    if len(rows) < len(result):
        long = pieces.end - pieces.begin > 1
        kinds = (long, around, stride + 1 + 2 * around), (~long, before, points)
        for which, earlier, wanted in kinds:
            rows = np.flatnonzero(which & ~pieces.regular)
            begin, end = pieces.begin[rows], pieces.end[rows]
            many = min(wanted, offset + len(stamps_ns))
            first = np.maximum(begin + offset - earlier, 0) - offset
            first = np.minimum(first, len(stamps_ns) - many)
            fit_windows(stamps_ns, values, rates, (begin, end), first, many, rows, result)
    return result


@lru_cache(maxsize=2 * MAX_STRIDE)
def window_nodes(stride: int, before: int) -> tuple[float, ...]:
    """Return x at the samples of a window of a regular piece, with so many before it."""
    points = _conditions(stride, before, slopes=False)
    return tuple((i - before) / stride for i in range(points))


def windows(
    stamps_ns: IntArray,
    values: FloatArray,
    rates: FloatArray,
    pieces: Pieces,
    *,
    stride: int,
    offset: int,
    before: int,
) -> tuple[IntArray, FloatArray]:
    """Return the first sample of the window of each piece, (n,), and coefficients.

    The coefficients are those of the pieces that are not regular; for these the first sample is
    given as −1 less their row. Args: as `polynomials`, with `before` for `wide`.
    """
    others = np.flatnonzero(~pieces.regular)
    first = pieces.begin - before
    first[others] = -1 - np.arange(len(others))
    fitted = polynomials(
        stamps_ns,
        values,
        rates,
        pieces.part(others),
        stride=stride,
        offset=offset,
        wide=before,
    )
    return first, fitted
