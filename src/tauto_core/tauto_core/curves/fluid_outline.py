"""Coordinates and curvature of a curve in a fluid, and its outline for drawing and cutting."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.bisection import bisect
from tauto_core.curves.descent_curve import DescentCurve, within
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import DescentError

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_FLAT = 40.0
"""κ|s| from which an ascent without a cusp is straight to rounding, e⁻⁴⁰."""


def abscissa(curve: DescentCurve, arc: ArrayLike) -> FloatArray:
    """Return y = ∫ √(1 − p²) ds from A [m], the horizontal coordinate (1729, 29).

    By Gauss's quadrature in u, s = s* sin u, which takes the root out of the cusp s*.

    Raises:
        DescentError: an arc beyond a cusp.
    """
    s = within(curve, arc)
    flat = np.atleast_1d(s).astype(np.float64)
    result = np.empty_like(flat)
    for rows, cusp in ((flat >= 0.0, curve.descent_cusp), (flat < 0.0, curve.ascent_cusp)):
        result[rows] = _level(curve, flat[rows], cusp)
    return result.reshape(s.shape)


def coordinates(curve: DescentCurve, arc: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return (x, y) [m]: Euler's height above A and horizontal distance from it.

    Raises:
        DescentError: an arc beyond a cusp.
    """
    return curve.height(within(curve, arc)), abscissa(curve, arc)


def radius_of_curvature(curve: DescentCurve, arc: ArrayLike) -> FloatArray:
    """Return R = (dy/ds)/(dp/ds) [m], γf (dy/ds) e^{−κs} for Euler's curve (1729, 30).

    Raises:
        DescentError: an arc beyond a cusp.
    """
    s = within(curve, arc)
    return _cosine(curve, s) / curve.slope_rate(s)


def chained(curve: DescentCurve, arc: float, cusps: int) -> tuple[float, float]:
    """Return (x, y) [m] after the curve has passed a number of cusps (1729, 30).

    Beyond each cusp it continues as its own mirror image, in arcs congruent to the one between the
    cusps.

    Args:
        curve: the curve, with a cusp at both ends.
        arc: arc of the point on the original curve [m].
        cusps: number of cusps passed on the side of descent, ≥ 0.

    Raises:
        DescentError: an arc beyond a cusp, or a curve without one of them.
    """
    ends = curve.descent_cusp, curve.ascent_cusp
    if math.isinf(ends[0]) or math.isinf(ends[1]):
        raise DescentError(
            f'the curve has its cusps at {ends!r} m: one that is not there makes no chain of '
            'arcs; take a shorter pendulum or a thinner fluid'
        )
    x, y = (float(part) for part in coordinates(curve, arc))
    right, left = (float(abscissa(curve, end)) for end in ends)
    width = right - left
    return x, right + (cusps - 0.5) * width + (-1) ** cusps * (y - 0.5 * (right + left))


def fluid_outline(curve: DescentCurve, points: int = 200) -> tuple[FloatArray, FloatArray]:
    """Return both branches as one polyline (horizontal, height) [m], ascent first.

    The branch of ascent ends at its cusp, but not above the cusp of descent, which no body
    exceeds.

    Args:
        curve: the curve, with a cusp on the branch of descent.
        points: number on each branch, including A, ≥ 2; the shapes are (2·points − 1,).

    Raises:
        DescentError: fewer than two points.
    """
    if points < 2:
        raise DescentError(f'points = {points!r}: a branch needs at least 2; ask for more')
    # closer together at the cusps, where the curve is vertical
    share = np.sin(np.linspace(0.0, 0.5 * math.pi, points))
    arc = np.concatenate([_ascent_end(curve) * share[:0:-1], curve.descent_cusp * share])
    x, y = coordinates(curve, arc)
    return y, x


def _ascent_end(curve: DescentCurve) -> float:
    """Return the arc of the ascent's cusp, or where it is as high as the descent's [m]."""
    top = float(curve.height(curve.descent_cusp))
    low = curve.ascent_cusp
    if math.isinf(low):
        low = -curve.descent_cusp
        while curve.height(low) < top:
            low *= 2.0
    if curve.height(low) <= top:
        return low
    return bisect(lambda arc: bool(curve.height(arc) <= top), 0.0, low)[0]


def _level(curve: DescentCurve, arc: FloatArray, cusp: float) -> FloatArray:
    """Return y at arcs on one side of A, whose cusp is there or at infinity."""
    if math.isinf(cusp):
        end = np.maximum(arc, -_FLAT / curve.kappa)
        beyond = _cosine(curve, end) * (arc - end)
        # the number of panels of an arc does not depend on the other arcs
        panels, level = np.array([_panels(curve, each) for each in end.tolist()]), beyond
        for count in set(panels.tolist()):
            rows = panels == count
            level[rows] += _gauss(end[rows], count, lambda s: _cosine(curve, s))
        return level
    angle = np.arcsin(np.clip(arc / cusp, 0.0, 1.0))

    def integrand(u: FloatArray) -> FloatArray:
        return cusp * np.cos(u) * _cosine(curve, cusp * np.sin(u))

    return _gauss(angle, 1 + _panels(curve, cusp), integrand)


def _panels(curve: DescentCurve, arc: float) -> int:
    return 1 + math.ceil(curve.kappa * abs(arc))


def _gauss(
    upper: FloatArray, panels: int, function: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """Return the integrals from 0 to each upper end, (n,)."""
    places = (np.arange(panels)[:, None] + 0.5 * (1.0 + _NODES)) / panels
    values = function(upper[:, None] * places.ravel()) * np.tile(_WEIGHTS, panels)
    total: FloatArray = np.sum(values, axis=-1)
    return upper * total / (2.0 * panels)


def _cosine(curve: DescentCurve, arc: FloatArray) -> FloatArray:
    """Return dy/ds = √(1 − p²), 0 where p exceeds 1 by rounding at a cusp."""
    p = curve.slope(arc)
    return np.sqrt(np.maximum((1.0 - p) * (1.0 + p), 0.0))
