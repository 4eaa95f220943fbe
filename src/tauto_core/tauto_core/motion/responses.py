"""Rows that turn the numbers of a polynomial u over a span into b, and into u at its end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import FloatArray, IntArray

WIDTH = 8
"""Numbers in a row of `lanes`."""

TURN = 0.35
"""Longest part of a turn that is integrated at once [rad]: there the remainder of 24 points is far
below rounding. It is also the longest part over which a wheel that may pass zero twice is
followed.
"""

_ROOTS, _WEIGHTS = np.polynomial.legendre.leggauss(24)


class Law(NamedTuple):
    """ż = (iω − δ) z + p u + q u̇, as floats."""

    omega: float
    delta: float
    p: float
    q: float


class Shape(NamedTuple):
    """Spans from `begin` to `end` of pieces of a length, with u given by samples or not."""

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

    A row multiplies one of the w numbers that determine u; it holds their factors in the real and
    imaginary part of b and in u, u̇, ü at the end, side by side, with three zeros behind.

    Attributes:
        rows: of the spans, then those of their parts, (n + m, w, 8).
        parts: in how many parts at most `TURN` long each shape is divided, (n,).
        first: where in `rows` these begin, (n,).
        time_s: length of the span, (n,).
        decay: e^{−δ·time}, (n,).
        per_slope: factor that turns rates of samples, or du/dx of coefficients, into u̇, (n,).
    """

    rows: FloatArray
    parts: IntArray
    first: IntArray
    time_s: FloatArray
    decay: FloatArray
    per_slope: FloatArray


def sorted_out(*columns: NDArray[Any]) -> tuple[IntArray, list[tuple[float, ...]]]:
    """Return the number of the kind of each row of some columns, (n,), and the kinds.

    Most rows are alike; only the others are worth sorting.
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
        nodes: x of the samples of a window.
        width: w, how many numbers give u: twice the nodes, or coefficients; 0: u = 0.
    """
    found = [_rows(law, each, nodes if each.sampled else None, width) for each in shapes]
    parts = np.array([len(each) - 1 for each in found])
    time_s = np.array([each.time_s for each in shapes])
    return Responses(
        rows=np.concatenate([each[:1] for each in found] + [each[1:] for each in found]),
        parts=parts,
        first=len(found) + np.cumsum(parts) - parts,
        time_s=time_s,
        decay=np.exp(-law.delta * time_s),
        per_slope=np.array([1.0 if each.sampled else 1.0 / each.length_s for each in shapes]),
    )


@lru_cache(maxsize=1024)
def _rows(law: Law, shape: Shape, nodes: tuple[float, ...] | None, width: int) -> FloatArray:
    """Return the row of a span, then those of its parts; no `nodes`: of powers of x."""
    length_s, begin = shape.length_s, shape.begin
    parts = max(math.ceil(math.hypot(law.omega, law.delta) * shape.time_s / TURN), 1)
    rows = np.zeros((1 + parts, width, WIDTH))
    if not width:
        return rows
    edges = begin + (shape.end - begin) * np.arange(parts + 1) / parts
    edges[-1] = shape.end
    long = np.diff(edges)[:, None]
    x = edges[:-1, None] + 0.5 * long * (_ROOTS + 1.0)
    pull = law.delta - 1j * law.omega
    weight = 0.5 * _WEIGHTS * long * length_s * np.exp(pull * (x - edges[:-1, None]) * length_s)
    u, slope, _ = _basis(x, length_s, nodes, width)
    b = np.einsum('mi,mij->mj', weight, law.p * u + law.q * slope)
    rows[1:, :, 0], rows[1:, :, 1] = b.real, b.imag
    rows[1:, :, 2], rows[1:, :, 3], rows[1:, :, 4] = _basis(edges[1:], length_s, nodes, width)
    # each part turned back to the span's beginning
    whole = (np.exp(pull * (edges[:-1] - begin) * length_s)[:, None] * b).sum(axis=0)
    rows[0] = rows[-1]
    rows[0, :, 0], rows[0, :, 1] = whole.real, whole.imag
    return rows


def _basis(
    x: FloatArray, length_s: float, nodes: tuple[float, ...] | None, width: int
) -> FloatArray:
    """Return rows that turn the numbers that determine u into u, u̇, ü at x, (3, …, width)."""
    if nodes is None:
        rows = _powers(x, width)
    else:
        rows = _cardinals(x, np.array(nodes))
        rows[..., len(nodes) :] *= length_s
    per_time = (1.0 / length_s) ** np.arange(3)
    return rows * per_time.reshape(3, *(1,) * (rows.ndim - 1))


def _powers(x: FloatArray, width: int) -> FloatArray:
    """Return x^j and its first two derivatives, (3, …, width)."""
    rows = np.zeros((3, *x.shape, width))
    rows[0] = x[..., None] ** np.arange(width)
    for n in (1, 2):
        rows[n, ..., 1:] = np.arange(1, width) * rows[n - 1, ..., :-1]
    return rows


def _cardinals(x: FloatArray, nodes: FloatArray) -> FloatArray:
    """Return Hermite's cardinal functions, of values, then slopes, and two derivatives.

    To the value at a node z belongs (1 − 2 l'(z) (x − z)) l², to the slope (x − z) l², with l
    Lagrange's polynomial of z. All are kept as their Taylor polynomials about x.
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
