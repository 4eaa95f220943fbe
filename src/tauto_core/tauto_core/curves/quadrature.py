"""Integrals of smooth functions to rounding."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.scene.errors import TautoError

_NODES = 24
_HALVINGS = 48
_PANELS = 1024
_TOLERANCE = 1e-14


class QuadratureError(TautoError):
    """An integral that does not converge, since the function is not smooth."""


def integrate(
    function: Callable[[FloatArray], FloatArray], lower: FloatArray, upper: FloatArray
) -> FloatArray:
    """Return the integrals of a function over n intervals, shape (n,).

    24-point Gauss–Legendre; each panel is halved until that changes it by less than 1e-14 of the
    whole integral, and the value of the halves is returned. Layers as thin as 2⁻⁴⁸ of the interval
    are found. The bits of an integral do not depend on the other intervals.

    Args:
        function: a function of an array of any shape, element by element, smooth within each
            interval.
        lower: lower limits, shape (n,).
        upper: upper limits, shape (n,).

    Raises:
        QuadratureError: no such agreement after 48 halvings, or with 1024 panels at once.
    """
    count = len(lower)
    owner, left, width = np.arange(count), lower, upper - lower
    settled = np.zeros(count)
    coarse = gauss(function, left, width)
    for _ in range(_HALVINGS):
        half = 0.5 * width
        left, half = np.stack([left, left + half], axis=1), np.stack([half, half], axis=1)
        fine = gauss(function, left.ravel(), half.ravel()).reshape(-1, 2)
        both = fine[:, 0] + fine[:, 1]
        whole = np.abs(settled + np.bincount(owner, both, count))
        open_ = ~(np.abs(both - coarse) <= _TOLERANCE * whole[owner])
        settled = settled + np.bincount(owner[~open_], both[~open_], count)
        if not open_.any():
            return settled
        owner, coarse = np.repeat(owner[open_], 2), fine[open_].ravel()
        left, width = left[open_].ravel(), half[open_].ravel()
        if np.bincount(owner).max() > _PANELS:
            break
    raise QuadratureError(
        f'an integral does not settle to {_TOLERANCE:g} of itself, with panels of {_NODES} nodes '
        'halved again and again: the machine is too stiff; use a smaller amplitude'
    )


@lru_cache(maxsize=1)
def _rule() -> tuple[FloatArray, FloatArray]:
    return np.polynomial.legendre.leggauss(_NODES)


def gauss(
    function: Callable[[FloatArray], FloatArray], left: FloatArray, width: FloatArray
) -> FloatArray:
    """Return 24-point Gauss–Legendre sums over intervals, shape (n,).

    Args:
        function: a function of an array of any shape, element by element.
        left: where the intervals begin, shape (n,).
        width: lengths of the intervals, shape (n,).
    """
    nodes, weights = _rule()
    values = function(left[:, None] + width[:, None] * (0.5 * (1.0 + nodes)))
    # along the last axis, so that the order of summation does not depend on the shape
    total: FloatArray = np.sum(values * weights, axis=-1)
    return 0.5 * width * total


def panel_nodes(edges: FloatArray) -> FloatArray:
    """Return the 24 Gauss–Legendre nodes of each panel between edges, shape (panels, 24)."""
    return edges[:-1, None] + np.diff(edges)[:, None] * (0.5 * (1.0 + _rule()[0]))


def running(values: FloatArray, edges: FloatArray) -> tuple[FloatArray, float]:
    """Return the integrals from the first edge to each node, and to the last edge.

    Args:
        values: the values of a smooth function at `panel_nodes(edges)`, shape (panels, 24).
        edges: edges of the panels, ascending, shape (panels + 1,).
    """
    width = 0.5 * np.diff(edges)
    parts = width * np.sum(values * _rule()[1], axis=-1)
    before = np.concatenate([[0.0], np.cumsum(parts)])
    within = width[:, None] * np.sum(values[:, None, :] * _from_left(), axis=-1)
    return before[:-1, None] + within, float(before[-1])


def unresolved(values: FloatArray) -> float:
    """Return the size of the last Legendre coefficients of the panels against the largest value.

    Args:
        values: the values at `panel_nodes`, shape (panels, 24).
    """
    nodes, weights = _rule()
    last = np.polynomial.legendre.legvander(nodes, _NODES - 1)[:, -2:] * weights[:, None]
    tails = np.abs(np.sum(values[..., None] * last, axis=1)) * _NODES
    return float(np.max(tails) / np.max(np.abs(values)))


@lru_cache(maxsize=1)
def _from_left() -> FloatArray:
    """Return the weights of the integrals from −1 to each node, shape (24, 24)."""
    nodes, weights = _rule()
    basis = np.polynomial.legendre.legvander(nodes, _NODES)
    orders = np.arange(1, _NODES)
    integrals = (basis[:, 2:] - basis[:, :-2]) / (2.0 * orders + 1.0)
    integrals = np.concatenate([nodes[:, None] + 1.0, integrals], axis=1)
    projection = basis[:, :_NODES] * (2.0 * np.arange(_NODES) + 1.0) * 0.5 * weights[:, None]
    return np.asarray(integrals @ projection.T)
