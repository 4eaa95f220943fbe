"""Constant rows for spans of a linear oscillator that a polynomial u drives.

The integral b of the span (P.1 in docs/theory/propagators.md) and u, u̇, ü at its end are linear in
the numbers that determine u: its coefficients, or the samples that it interpolates. The product of
one row with these numbers therefore gives b, u, u̇ and ü, and no polynomial is fitted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.motion.lanes import SIZE
from tauto_core.samples import FloatArray, IntArray

B_RE, B_IM, U, U_RATE, U_BEND = range(5)
"""Columns of a product: real and imaginary part of b, then u, u̇ and ü at the end of the span."""

TURN = 0.35
"""Longest part of a span that is integrated at once, as |iω − δ| times its length [rad].

The exponential is then exact to rounding in a Gauss–Legendre rule of 24 points. The parts are also
those in which the passages of a wheel that may pass zero twice are counted (`linear_passages`).
"""

_ROOTS, _WEIGHTS = np.polynomial.legendre.leggauss(24)


class Law(NamedTuple):
    """ż = (iω − δ) z + a u + c u̇.

    Attributes:
        omega: ω [rad/s].
        delta: δ [1/s].
        per_value: a, the drive per u.
        per_rate: c, the drive per u̇.
    """

    omega: float
    delta: float
    per_value: float
    per_rate: float


class Shape(NamedTuple):
    """What spans have in common that can share rows.

    Attributes:
        length_s: length of the piece of forcing [s].
        begin: where in the piece the span begins, in x from 0 to 1.
        end: where it ends.
        sampled: whether samples determine u; otherwise its coefficients do.
    """

    length_s: float
    begin: float
    end: float
    sampled: bool = False

    @property
    def time_s(self) -> float:
        """Length of the span [s]."""
        return (self.end - self.begin) * self.length_s


class Responses(NamedTuple):
    """The constants that spans of n shapes share.

    w numbers determine u. Row j of a span or part holds the factors of the j-th of them in b, u, u̇
    and ü, in the columns `B_RE` to `U_BEND`; three zeros fill it up to the width of lanes.

    Attributes:
        rows: those of the spans, then those of all parts, (n + Σ parts, w, 8).
        parts: number of equal parts, at most `TURN` long, of each shape, (n,).
        first_part: where in `rows` the parts of a shape begin, (n,).
        time_s: length of the span [s], (n,).
        decay: e^{−δ·time}, (n,).
        per_slope: factor that turns the rates of samples, or du/dx, into u̇, (n,).
    """

    rows: FloatArray
    parts: IntArray
    first_part: IntArray
    time_s: FloatArray
    decay: FloatArray
    per_slope: FloatArray


def sorted_out(*columns: NDArray[Any]) -> tuple[IntArray, list[tuple[float, ...]]]:
    """Return the distinct rows of a table, and which of them each row is.

    Most rows of the forcing are alike, so that only those which differ from one in the middle are
    sorted.

    Args:
        columns: of the table, each (n,).

    Returns:
        The index of each row among the distinct ones, (n,), and these.
    """
    usual = [column[len(column) // 2] for column in columns]
    unlike = np.zeros(len(columns[0]), np.bool_)
    for column, one in zip(columns, usual, strict=True):
        unlike |= column != one
    kind, kinds = np.zeros(len(unlike), np.int64), [tuple(each.item() for each in usual)]
    if unlike.any():
        others = np.stack([column[unlike] for column in columns], axis=1)
        more, which = np.unique(others, axis=0, return_inverse=True)
        kinds += map(tuple, more.tolist())
        kind[unlike] = 1 + which.reshape(-1)
    return kind, kinds


def responses(
    law: Law, shapes: Sequence[Shape], nodes: tuple[float, ...], width: int
) -> Responses:
    """Return the constants that spans of some shapes share.

    Args:
        law: the law of the oscillator and its forcing.
        shapes: n of them.
        nodes: x of the samples that u interpolates, with their rates.
        width: w, how many numbers determine u: twice the number of nodes, or of coefficients; 0
            where u = 0.
    """
    found = [_rows(law, each, nodes if each.sampled else None, width) for each in shapes]
    parts = np.array([len(each) - 1 for each in found])
    time_s = np.array([each.time_s for each in shapes])
    return Responses(
        rows=np.concatenate([each[:1] for each in found] + [each[1:] for each in found]),
        parts=parts,
        first_part=len(found) + np.cumsum(parts) - parts,
        time_s=time_s,
        decay=np.exp(-law.delta * time_s),
        per_slope=np.array([1.0 if each.sampled else 1.0 / each.length_s for each in shapes]),
    )


@lru_cache(maxsize=1024)
def _rows(law: Law, shape: Shape, nodes: tuple[float, ...] | None, width: int) -> FloatArray:
    """Return the rows of a span, then those of its parts, (1 + parts, w, 8).

    Samples at `nodes` determine u, or coefficients where there are none.
    """
    length_s, begin = shape.length_s, shape.begin
    parts = max(math.ceil(math.hypot(law.omega, law.delta) * shape.time_s / TURN), 1)
    rows = np.zeros((1 + parts, width, SIZE))
    if not width:
        return rows
    edges = begin + (shape.end - begin) * np.arange(parts + 1) / parts
    edges[-1] = shape.end
    long = np.diff(edges)[:, None]
    x = edges[:-1, None] + 0.5 * long * (_ROOTS + 1.0)
    pull = law.delta - 1j * law.omega
    weight = 0.5 * _WEIGHTS * long * length_s * np.exp(pull * (x - edges[:-1, None]) * length_s)
    u, slope, _ = _basis(x, length_s, nodes, width)
    b = np.einsum('mi,mij->mj', weight, law.per_value * u + law.per_rate * slope)
    rows[1:, :, B_RE], rows[1:, :, B_IM] = b.real, b.imag
    rows[1:, :, U : U_BEND + 1] = np.moveaxis(_basis(edges[1:], length_s, nodes, width), 0, -1)
    # b of a part counts from the part's beginning, that of the span from the span's
    whole = (np.exp(pull * (edges[:-1] - begin) * length_s)[:, None] * b).sum(axis=0)
    rows[0] = rows[-1]
    rows[0, :, B_RE], rows[0, :, B_IM] = whole.real, whole.imag
    return rows


def _basis(
    x: FloatArray, length_s: float, nodes: tuple[float, ...] | None, width: int
) -> FloatArray:
    """Return the factors of the numbers that determine u in u, u̇ and ü at x, (3, …, width)."""
    if nodes is None:
        rows = _powers(x, width)
    else:
        rows = _cardinals(x, np.array(nodes))
        rows[..., len(nodes) :] *= length_s
    per_time = (1.0 / length_s) ** np.arange(3)
    return rows * per_time.reshape(3, *(1,) * (rows.ndim - 1))


def _powers(x: FloatArray, width: int) -> FloatArray:
    """Return x^j and its first two derivatives in x, (3, …, width)."""
    rows = np.zeros((3, *x.shape, width))
    rows[0] = x[..., None] ** np.arange(width)
    for n in (1, 2):
        rows[n, ..., 1:] = np.arange(1, width) * rows[n - 1, ..., :-1]
    return rows


def _cardinals(x: FloatArray, nodes: FloatArray) -> FloatArray:
    """Return the basis of Hermite interpolation and its first two derivatives in x.

    The basis function of the value at a node z is (1 − 2 l'(z) (x − z)) l², that of the slope
    (x − z) l², with l the Lagrange polynomial that is one at z. Each function is computed as its
    Taylor polynomial of degree 2 about x, which gives the derivatives.

    Returns:
        The functions of the values, then those of the slopes, (3, …, 2 · nodes).
    """
    own = np.eye(len(nodes))
    apart = nodes[:, None] - nodes + own
    lagrange = _linear(np.ones((*x.shape, len(nodes))), np.zeros(len(nodes)))
    for j, node in enumerate(nodes):
        # a factor of every polynomial but that of this node
        value = (x[..., None] - node) / apart[:, j]
        value[..., j] = 1.0
        lagrange = _product(lagrange, _linear(value, (1.0 - own[j]) / apart[:, j]))
    square = _product(lagrange, lagrange)
    slope = _product(_linear(x[..., None] - nodes, np.ones(len(nodes))), square)
    value = square - 2.0 * ((1.0 - own) / apart).sum(axis=1) * slope
    taylor = np.concatenate([value, slope], axis=-1)
    taylor[2] *= 2.0
    return taylor


def _linear(value: FloatArray, slope: FloatArray) -> FloatArray:
    """Return the Taylor polynomials of linear functions, (3, …)."""
    return np.stack([value, np.broadcast_to(slope, value.shape), np.zeros_like(value)])


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the product of two Taylor polynomials of degree 2."""
    return np.stack(
        [a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[1] * b[1] + a[2] * b[0]]
    )
