"""Numerics of curves: differences, roots, series, quadrature, splines."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import FloatArray
from tauto_core.scene.errors import TautoError

ArrayFunction: TypeAlias = Callable[[FloatArray], FloatArray]
"""A function of an array of any shape, element by element."""


def trapezoid(values: FloatArray, at: FloatArray) -> float:
    """Return the integral of values by trapezoids (`numpy.trapezoid` since NumPy 2.0)."""
    return float((np.diff(at) * (values[1:] + values[:-1]) / 2.0).sum())


# -----------------------------------------------------------------------------
# Differences of nearly equal functions, to full relative precision at small arguments.


def sine_defect(x: FloatArray) -> FloatArray:
    """Return x − sin x, by its power series for |x| < 1."""
    small = np.where(np.abs(x) < 1.0, x, 0.0)
    square = small * small
    tail = np.ones_like(square)
    for k in range(9, 1, -1):  # the first term left out is 1e-19 of the sum at |x| = 1
        tail = 1.0 - square / (2 * k * (2 * k + 1)) * tail
    return np.where(np.abs(x) < 1.0, small * square / 6.0 * tail, x - np.sin(x))


def exponential_mean(z: FloatArray) -> FloatArray:
    """Return (eᶻ − 1)/z, the mean of the exponential from 0 to z, 1 at 0."""
    safe = np.where(z == 0.0, 1.0, z)
    return np.where(z == 0.0, 1.0, np.expm1(safe) / safe)


def exponential_defect(z: FloatArray) -> FloatArray:
    """Return 2 (eᶻ − 1 − z)/z², 1 at 0, by its power series for |z| < 1."""
    series = np.ones_like(z)
    small = np.where(np.abs(z) < 1.0, z, 0.0)
    for k in range(20, 2, -1):
        series = 1.0 + small / k * series
    large = np.where(np.abs(z) < 1.0, 1.0, z)
    return np.where(np.abs(z) < 1.0, series, 2.0 * (np.expm1(large) - large) / (large * large))


def logarithmic_mean(z: FloatArray) -> FloatArray:
    """Return ln(1 + z)/z, 1 at 0, for z > −1."""
    safe = np.where(z == 0.0, 1.0, z)
    return np.where(z == 0.0, 1.0, np.log1p(safe) / safe)


# -----------------------------------------------------------------------------
# Roots: of one equation by Brent's method of SciPy, of many equations at once by Newton's method
# in brackets, which SciPy lacks, and the edge of a condition by bisection. Kernels have their own
# forms in `motion.events`.


def root_of(function: Callable[[float], float], low: float, high: float, absolute: float) -> float:
    """Return a root of a function with different signs at `low` and `high`, or 0 at one of them.

    It is within `absolute` > 0 plus rounding of a change of sign.
    """
    from scipy.optimize import brentq  # slow to import

    rounding = 4.0 * np.finfo(float).eps  # the least that it takes
    return float(brentq(function, low, high, xtol=absolute, rtol=rounding, maxiter=10_000))


_STEPS = 100


def bracketed_newton(
    equation: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
    start: FloatArray,
    bracket: tuple[FloatArray | float, FloatArray | float],
    relative: float = 0.0,
    absolute: FloatArray | float = 0.0,
) -> FloatArray:
    """Return the roots of increasing functions, in the shape of `start`.

    `equation` gives values and derivatives, element by element. Newton's method shrinks a bracket
    and halves it if a step would leave it. The bracket may be infinite if no step can overshoot.
    An element is kept after a step within the absolute plus relative tolerance: the bits of a root
    do not depend on the rest of the batch.
    """
    low, high = (np.broadcast_to(np.asarray(end, np.float64), start.shape) for end in bracket)
    x, settled = np.clip(start, low, high), np.zeros(start.shape, np.bool_)
    for _ in range(_STEPS):
        value, slope = equation(x)
        low, high = np.where(value <= 0.0, x, low), np.where(value >= 0.0, x, high)
        # a derivative of 0 halves the bracket
        with np.errstate(divide='ignore', invalid='ignore'):
            trial = x - value / slope
        is_inside = (trial >= low) & (trial <= high)
        x_next = np.where(is_inside, trial, 0.5 * (low + high))
        is_near = np.abs(x_next - x) <= absolute + relative * np.abs(x_next)
        x, settled = np.where(settled, x, x_next), settled | is_near
        if np.all(settled):
            break
    return np.asarray(x)


def bisect(holds: Callable[[float], bool], good: float, bad: float) -> tuple[float, float]:
    """Return two neighbouring numbers: a condition holds at the first and fails at the second.

    It changes once between `good` and `bad`, on either side.
    """
    # 60 halvings reach the rounding error of the first length
    for _ in range(60):
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good, bad


# -----------------------------------------------------------------------------
# Chebyshev series of functions that are known at the Chebyshev nodes of the first kind.


def chebyshev_nodes(count: int) -> FloatArray:
    """Return the nodes x_k = cos(π (k + ½)/n), k = 0 … n − 1, which fall from 1 to −1, (n,)."""
    return np.asarray(np.cos(math.pi / count * (np.arange(count) + 0.5)))


def chebyshev_coefficients(values: FloatArray) -> FloatArray:
    """Return the coefficients c_j of Σ c_j T_j(x) from values at `chebyshev_nodes(n)`, (…, n).

    c_j = (2/n) Σ_k values_k cos(πj (k + ½)/n), half of it for j = 0: a Fourier transform of the
    values and their mirror image.
    """
    count = values.shape[-1]
    mirrored = np.concatenate([values, values[..., ::-1]], axis=-1)
    half_a_node = np.exp(-0.5j * math.pi / count * np.arange(count))
    coefficients = (np.fft.rfft(mirrored)[..., :count] * half_a_node).real / count
    coefficients[..., 0] *= 0.5
    return np.ascontiguousarray(coefficients)


def powers_on_unit(series: NDArray[np.floating[Any]]) -> FloatArray:
    """Return the coefficients of x^j of Σ series_k T_k(2x − 1), by Clenshaw's recurrence, (n,).

    `Chebyshev.convert` gives the same bits at twenty times the cost.
    """

    def step(constant: float, row: FloatArray, terms: FloatArray) -> FloatArray:
        # a constant + Σ row_j x^j + (2x − 1) Σ other_j x^j
        shifted = -terms
        shifted[1:] += 2.0 * terms[:-1]
        row[0] += constant
        return row + shifted

    b1, b2 = np.zeros((2, len(series)))
    for coefficient in series[:0:-1]:
        b1, b2 = step(coefficient, -b2, 2.0 * b1), b1
    return step(series[0], -b2, b1)


def complete_series(
    series: Callable[[int], FloatArray],
    counts: Iterable[int],
    tail: float,
    *,
    tail_count: int = 4,
    scale: float | None = None,
) -> FloatArray | None:
    """Return the first complete Chebyshev series, if any.

    `series` gives the coefficients with n terms, (…, n), for each of the counts in order. A smooth
    function's coefficients fall geometrically down to rounding. A series is complete if its last
    `tail_count` are at most `tail` of the largest, or of `scale`. One alone may vanish by
    symmetry.
    """
    for count in counts:
        coefficients = series(count)
        sizes = np.abs(coefficients)
        largest = np.max(sizes, axis=-1, keepdims=True) if scale is None else scale
        if np.all(sizes[..., -tail_count:] <= tail * largest):
            return coefficients
    return None


# -----------------------------------------------------------------------------
# Integrals of smooth functions to rounding.

_NODES = 24
_HALVINGS = 48
_TOLERANCE = 1e-14


class QuadratureError(TautoError):
    """An integral of a rough function, which does not converge."""


def integrate(function: ArrayFunction, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Return the integrals of a function over n intervals, shape (n,).

    Panels of 24-point Gauss–Legendre are halved until that changes a panel by less than 1e-14 of
    the whole integral. The function must be smooth within each interval, down to layers of 2⁻⁴⁸ of
    it. The bits of an integral do not depend on the other intervals. QuadratureError: no such
    agreement after 48 halvings, or with 1024 panels at once.
    """
    count = len(lower)
    owner, begin, width = np.arange(count), lower, upper - lower
    settled = np.zeros(count)
    coarse = gauss_sums(function, begin, width)
    for _ in range(_HALVINGS):
        step = 0.5 * width
        begin, step = np.stack([begin, begin + step], axis=1), np.stack([step, step], axis=1)
        fine = gauss_sums(function, begin.ravel(), step.ravel()).reshape(-1, 2)
        sums = fine[:, 0] + fine[:, 1]
        size = np.abs(settled + np.bincount(owner, sums, count))
        open_ = ~(np.abs(sums - coarse) <= _TOLERANCE * size[owner])
        settled = settled + np.bincount(owner[~open_], sums[~open_], count)
        if not open_.any():
            return settled
        owner, coarse = np.repeat(owner[open_], 2), fine[open_].ravel()
        begin, width = begin[open_].ravel(), step[open_].ravel()
        if np.bincount(owner).max() > 1024:
            break
    raise QuadratureError(
        f'an integral does not settle to {_TOLERANCE:g} of itself, with panels of {_NODES} nodes '
        'halved again and again: the machine is too stiff. Use a smaller amplitude'
    )


@lru_cache(maxsize=1)
def gauss_rule() -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights of the 24-point Gauss–Legendre rule on [−1, 1]."""
    return np.polynomial.legendre.leggauss(_NODES)


def repeated_rule(panels: int) -> tuple[FloatArray, FloatArray]:
    """Return that rule on equal panels of [0, 1]: nodes, and weights of the sum 2 · panels."""
    nodes, weights = gauss_rule()
    places = (np.arange(panels)[:, None] + 0.5 * (1.0 + nodes)) / panels
    return places.ravel(), np.tile(weights, panels)


def gauss_sums(function: ArrayFunction, begin: FloatArray, width: FloatArray) -> FloatArray:
    """Return 24-point Gauss–Legendre sums over n intervals of given beginnings and widths."""
    nodes, weights = gauss_rule()
    values = function(begin[:, None] + width[:, None] * (0.5 * (1.0 + nodes)))
    # along the last axis, to sum in the same order for any shape
    total: FloatArray = np.sum(values * weights, axis=-1)
    return 0.5 * width * total


def panel_nodes(edges: FloatArray) -> FloatArray:
    """Return the 24 Gauss–Legendre nodes of each panel between edges, shape (panels, 24)."""
    return edges[:-1, None] + np.diff(edges)[:, None] * (0.5 * (1.0 + gauss_rule()[0]))


def running(values: FloatArray, edges: FloatArray) -> tuple[FloatArray, float]:
    """Return the integrals from the first edge to each node, and to the last edge.

    The values belong to a smooth function at `panel_nodes(edges)`, shape (panels, 24).
    """
    width = 0.5 * np.diff(edges)
    parts = width * np.sum(values * gauss_rule()[1], axis=-1)
    sums = np.concatenate([[0.0], np.cumsum(parts)])
    partial = width[:, None] * np.sum(values[:, None, :] * _from_left(), axis=-1)
    return sums[:-1, None] + partial, float(sums[-1])


def unresolved(values: FloatArray) -> float:
    """Return the size of the last Legendre coefficients of the panels, over the largest value."""
    nodes, weights = gauss_rule()
    basis = np.polynomial.legendre.legvander(nodes, _NODES - 1)[:, -2:] * weights[:, None]
    tails = np.abs(np.sum(values[..., None] * basis, axis=1)) * _NODES
    return float(np.max(tails) / np.max(np.abs(values)))


@lru_cache(maxsize=1)
def _from_left() -> FloatArray:
    """Return the weights of the integrals from −1 to each node, shape (24, 24)."""
    nodes, weights = gauss_rule()
    basis = np.polynomial.legendre.legvander(nodes, _NODES)
    orders = np.arange(1, _NODES)
    integrals = (basis[:, 2:] - basis[:, :-2]) / (2.0 * orders + 1.0)
    integrals = np.concatenate([nodes[:, None] + 1.0, integrals], axis=1)
    projection = basis[:, :_NODES] * (2.0 * np.arange(_NODES) + 1.0) * 0.5 * weights[:, None]
    return np.asarray(integrals @ projection.T)


# -----------------------------------------------------------------------------
# Curves through points, a cubic between neighbours: the spline's or Akima's.
#
# `scipy.interpolate` has both, but takes longer to import than a scene of ten minutes to sail. A
# test compares the values.


def spline(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Return the values of the cubic spline through points, not-a-knot at both ends.

    x has at least four points, strictly increasing, and `at` is between the first and the last.
    y has a row for each point, (n, ...), the result one for each of `at`.
    """
    return hermite(x, y, spline_slopes(x, y), at)


def spline_slopes(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the slopes of the cubic spline at its points, of the shape of y.

    The slopes s make the second derivative continuous: with h_i = x_i+1 − x_i and d_i the slope of
    the chord over it, h_i s_i−1 + 2 (h_i−1 + h_i) s_i + h_i−1 s_i+1 = 3 (h_i d_i−1 + h_i−1 d_i).
    The third derivative is continuous at the second point and at the last but one. (C. de Boor, A
    Practical Guide to Splines, 1978, chapter IV.)
    """
    h, n = np.diff(x), len(x)
    # zeros outside the matrix, which the solver multiplies
    below, diagonal, above = np.zeros((3, n))
    below[1:-1], diagonal[1:-1], above[1:-1] = h[1:], 2.0 * (h[:-1] + h[1:]), h[:-1]
    d0, d1 = x[2] - x[0], x[-1] - x[-3]
    diagonal[0], above[0] = h[1], d0
    below[-1], diagonal[-1] = d1, h[-2]
    spacing = h.reshape(-1, *[1] * (y.ndim - 1))
    chord, right = np.diff(y, axis=0) / spacing, np.zeros(y.shape)
    right[1:-1] = 3.0 * (spacing[1:] * chord[:-1] + spacing[:-1] * chord[1:])
    right[0] = ((h[0] + 2.0 * d0) * h[1] * chord[0] + h[0] ** 2 * chord[1]) / d0
    right[-1] = (h[-1] ** 2 * chord[-2] + (2.0 * d1 + h[-1]) * h[-2] * chord[-1]) / d1
    # without pivots, which this system does not need
    sought: Any = right.tolist() if y.ndim == 1 else right  # numbers are quicker by themselves
    rows = zip(*(band.tolist() for band in (below, diagonal, above)), sought, strict=True)
    _, pivot, upper, value = next(rows)
    pivots, aboves, values = [pivot], [upper], [value]
    for low, middle, high, wanted in rows:
        factor = low / pivot
        pivot, value = middle - factor * upper, wanted - factor * value
        upper = high
        pivots.append(pivot)
        aboves.append(high)
        values.append(value)
    slopes = [0.0]
    for pivot, upper, value in zip(*map(reversed, (pivots, aboves, values)), strict=True):
        slopes.append((value - upper * slopes[-1]) / pivot)
    return np.array(slopes[:0:-1])


def akima(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Return the values of Akima's curve through points (J. ACM 17, 1970, 589).

    With m_i the slopes of the chords, the slope at a point between the chords m₂ and m₃ is
    (w₂ m₂ + w₃ m₃)/(w₂ + w₃), w₂ = |m₄ − m₃| and w₃ = |m₂ − m₁|, or their mean if both are zero.
    The slopes m are extended linearly beyond the ends, and two points give a straight line. x is
    strictly increasing, and `at` is between the first and the last.
    """
    m = np.pad(np.diff(y) / np.diff(x), 2, mode='edge')
    for i, j, k in ((1, 2, 3), (0, 1, 2), (-2, -3, -4), (-1, -2, -3)):
        m[i] = 2.0 * m[j] - m[k]
    change = np.abs(np.diff(m))
    w0, w1 = change[:-2], change[2:]
    weights = w0 + w1
    slopes = 0.5 * (m[3:] + m[:-3])
    # as in SciPy: a ratio of weights that are both rounding is meaningless
    clear = weights > 1e-9 * np.max(weights)
    share = w0[clear] / weights[clear]
    slopes[clear] = m[1:-2][clear] + share * (m[2:-1][clear] - m[1:-2][clear])
    return hermite(x, y, slopes, at)


def hermite(x: FloatArray, y: FloatArray, slopes: FloatArray, at: FloatArray) -> FloatArray:
    """Return the cubics with given values and slopes at the points, a row for each of `at`."""
    i = np.clip(np.searchsorted(x, at, 'right') - 1, 0, len(x) - 2)
    h, u = (values.reshape(-1, *[1] * (y.ndim - 1)) for values in (np.diff(x), at - x[i]))
    chord = np.diff(y, axis=0) / h
    bend = (slopes[:-1] + slopes[1:] - 2.0 * chord) / h
    square = u * u
    value = y[i] + slopes[i] * u + ((chord - slopes[:-1]) / h - bend)[i] * square
    return np.asarray(value + (bend / h)[i] * (square * u))
