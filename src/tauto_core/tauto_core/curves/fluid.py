"""Curves on which a body slides through a fluid, Euler's tautochrone of 1729 among them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.numerics import (
    bisect,
    bracketed_newton,
    exponential_defect,
    exponential_mean,
    integrate,
    logarithmic_mean,
)
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import DescentError

# -----------------------------------------------------------------------------
# Curves on which a body slides through a fluid, as functions of one signed arc.
#
# Euler, *Curva tautochrona in fluido* (1729). The arc s [m] counts from the point A: s > 0 on the
# branch of descent AM, s < 0 on the branch of ascent AN. A half swing goes from s > 0 to s < 0, a
# reverse half swing the other way. x(s) is the height above A and p = dx/ds the slope, the sine
# of the inclination, which is ±1 at the cusps. Every function takes numbers or arrays of any
# shape. Slope and height are analytic beyond the cusps. `within` refuses such arcs.


class DescentCurve(Protocol):
    """A curve and the fluid for which it is made."""

    @property
    def kappa(self) -> float:
        """κ: deceleration by the fluid over the square of the speed [1/m], ≥ 0."""

    @property
    def gamma(self) -> float:
        """γ: acceleration in the fluid over acceleration in vacuum, 0 < γ ≤ 1."""

    @property
    def pendulum_length(self) -> float:
        """f: length of the simple pendulum in vacuum that keeps time with small swings [m]."""

    @property
    def descent_cusp(self) -> float:
        """Arc of the cusp on the branch of descent [m], > 0, inf without a cusp."""

    @property
    def ascent_cusp(self) -> float:
        """Arc of the cusp on the branch of ascent [m], < 0, −inf without a cusp."""

    @property
    def joints(self) -> FloatArray:
        """Arcs at which the slope is not smooth [m]."""

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p = dx/ds."""

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/ds [1/m]."""

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return x(s) [m], 0 at A."""


def within(curve: DescentCurve, arc: ArrayLike) -> FloatArray:
    """Return the arcs as an array. DescentError: an arc beyond a cusp, or NaN."""
    arcs = np.asarray(arc, np.float64)
    bad = ~((arcs >= curve.ascent_cusp) & (arcs <= curve.descent_cusp))
    bad |= np.isinf(arcs)
    if np.any(bad):
        worst = float(arcs[bad].flat[0])
        raise DescentError(
            f'arc {worst!r} m: the curve runs from {curve.ascent_cusp!r} m to '
            f'{curve.descent_cusp!r} m, its cusps. Stay within, or take a longer pendulum'
        )
    return arcs


@dataclass(frozen=True)
class CurveInMedium:
    """A curve with its body and fluid. DescentError: a number out of its range.

    Attributes:
        kappa: κ, deceleration over the square of the speed [1/m], ≥ 0.
        gamma: γ, acceleration in the fluid over that in vacuum, 0 < γ ≤ 1.
        pendulum_length: f [m].
    """

    kappa: float
    gamma: float
    pendulum_length: float

    def __post_init__(self) -> None:
        limits = (
            ('kappa', 'at least 0 1/m', 0.0 <= self.kappa < math.inf),
            ('gamma', 'above 0 and at most 1: the body must sink', 0.0 < self.gamma <= 1.0),
            ('pendulum_length', 'above 0 m', 0.0 < self.pendulum_length < math.inf),
        )
        for name, limit, good in limits:
            if not good:
                value = getattr(self, name)
                raise DescentError(f'{name} = {value!r}: must be finite and {limit}')

    @property
    def descent_cusp(self) -> float:
        """Arc of the cusp on the branch of descent [m]."""
        raise NotImplementedError

    @property
    def joints(self) -> FloatArray:
        """Arcs at which the slope is not smooth [m], here an empty array."""
        return np.empty(0)

    @property
    def ascent_cusp(self) -> float:
        """Arc of the cusp on the other side [m], as far from A."""
        return -self.descent_cusp


@dataclass(frozen=True)
class Cycloid(CurveInMedium):
    """Huygens' cycloid, γ f dx/ds = s: the tautochrone in vacuum, used in a fluid (1729, 18).

    It ignores κ of the fluid.
    """

    @property
    def descent_cusp(self) -> float:
        """Arc γf of the cusp [m]."""
        return self.gamma * self.pendulum_length

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p = s/γf."""
        return np.asarray(arc, np.float64) / self.descent_cusp

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/ds = 1/γf [1/m]."""
        return np.full(np.shape(arc), 1.0 / self.descent_cusp)

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return x = s²/2γf [m]."""
        s = np.asarray(arc, np.float64)
        return s * s / (2.0 * self.descent_cusp)


@dataclass(frozen=True)
class SymmetricCurve(CurveInMedium):
    """γ f dx/ds = s + (4/9) κ² s³: closer to isochronous than Euler's curve for swings to and fro.

    On a cycloid in the fluid a swing to and fro takes 1 + (κS)²/6 of a small swing, with S its
    arc. A term cκ²s³ of the force reduces this by 3c(κS)²/8: c = 4/9 leaves no error of second
    order in either direction.
    """

    @property
    def descent_cusp(self) -> float:
        """Arc of the cusp [m]: the root of the cubic s + (4/9) κ² s³ = γf, by hyperbolic sines."""
        end = self.gamma * self.pendulum_length
        z = math.sqrt(3.0) * self.kappa * end
        return end if z == 0.0 else end * 3.0 * math.sinh(math.asinh(z) / 3.0) / z

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p = (s + (4/9) κ² s³)/γf."""
        s = np.asarray(arc, np.float64)
        z = self.kappa * s
        return s * (1.0 + 4.0 / 9.0 * z * z) / (self.gamma * self.pendulum_length)

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/ds = (1 + (4/3) κ² s²)/γf [1/m]."""
        z = self.kappa * np.asarray(arc, np.float64)
        return (1.0 + 4.0 / 3.0 * z * z) / (self.gamma * self.pendulum_length)

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return x = (s²/2 + κ² s⁴/9)/γf [m]."""
        s = np.asarray(arc, np.float64)
        z = self.kappa * s
        return s * s * (0.5 + z * z / 9.0) / (self.gamma * self.pendulum_length)


@dataclass(frozen=True)
class ActaCurve(CurveInMedium):
    """Curve of the Acta of 1726: γ f dx/ds = s + κ(S² − s²), for one start S (1729, 2–5).

    From S > 0 alone the body reaches A in (π/2)√(f/g), with s = S cos ωt. At A the slope is
    κS²/γf. DescentError: a start from which the curve would be steeper than vertical on the way.
    """

    start: float

    def __post_init__(self) -> None:
        super().__post_init__()
        top = self.start
        if self.kappa * self.start > 0.5:
            top = 0.5 / self.kappa
        if not (self.start > 0.0 and self.slope(top) <= 1.0):
            raise DescentError(
                f'start = {self.start!r} m: must be > 0 and the curve from there nowhere steeper '
                f'than upright, but its slope at {top!r} m is {float(self.slope(top))!r}. Start '
                'nearer to A or take a longer pendulum'
            )

    @property
    def descent_cusp(self) -> float:
        """Arc of slope 1 [m], or inf."""
        room = self.gamma * self.pendulum_length - self.kappa * self.start**2
        square = 1.0 - 4.0 * self.kappa * room
        return 2.0 * room / (1.0 + math.sqrt(square)) if square >= 0.0 else math.inf

    @property
    def ascent_cusp(self) -> float:
        """Arc of slope −1 [m]."""
        room = self.gamma * self.pendulum_length + self.kappa * self.start**2
        return -2.0 * room / (1.0 + math.sqrt(1.0 + 4.0 * self.kappa * room))

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p = (s + κ(S² − s²))/γf."""
        s = np.asarray(arc, np.float64)
        bend = self.kappa * (self.start - s) * (self.start + s)
        return (s + bend) / (self.gamma * self.pendulum_length)

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/ds = (1 − 2κs)/γf [1/m]."""
        s = np.asarray(arc, np.float64)
        return (1.0 - 2.0 * self.kappa * s) / (self.gamma * self.pendulum_length)

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return x = (s²/2 + κ(S² s − s³/3))/γf [m]."""
        s = np.asarray(arc, np.float64)
        bend = self.kappa * s * (self.start**2 - s * s / 3.0)
        return (0.5 * s * s + bend) / (self.gamma * self.pendulum_length)


# -----------------------------------------------------------------------------
# Euler's tautochrone in a fluid that resists as the square of the speed (Euler 1729).
#
#     γκ²f x = e^{κs} − 1 − κs,     dx/ds = (e^{κs} − 1)/(γκf) = s/(γf) + κx        (§16–20, 23)
#
# for all signed s (`descent_curve`). A body that moves towards −s has the drag κṡ², and then z =
# (1 − e^{−κs})/κ obeys z̈ = −(g/f) z exactly: the descent takes (π/2)√(f/g) from any start. All
# formulas hold down to κ = 0, the cycloid (§18).

_ROUNDING = 4.0 * np.finfo(np.float64).eps


@dataclass(frozen=True)
class FluidTautochrone(CurveInMedium):
    """The joined curve of descent and ascent (§22), with or without constant friction (§35).

    Attributes:
        friction: μ, constant resistance over the weight in the fluid, 0 ≤ μ < 1. The curve is then
            x = μs + (e^{κs} − 1 − κs)/(γκ²f), which still has the slope μ at A.

    Raises:
        DescentError: a number out of its range, or β μ ≥ 1 with β = γκf: the friction leaves the
            curve without a lowest point.
    """

    friction: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        limit = min(1.0, 1.0 / self.beta) if self.beta > 0.0 else 1.0
        if not 0.0 <= self.friction < limit:
            raise DescentError(
                f'friction = {self.friction!r}: must be at least 0 and less than {limit!r} of the '
                f'weight in the fluid, or the curve has no lowest point (beta = {self.beta!r}). '
                'Give less friction'
            )

    @property
    def beta(self) -> float:
        """β = γκf. Without friction β ≥ 1 leaves no ascent cusp."""
        return self.gamma * self.kappa * self.pendulum_length

    @property
    def descent_cusp(self) -> float:
        """Arc s* = ln(1 + β(1 − μ))/κ at which dx/ds = 1 [m] (§26)."""
        return self._arc_of_force(self._gf * (1.0 - self.friction))

    @property
    def ascent_cusp(self) -> float:
        """Arc ln(1 − β(1 + μ))/κ at which dx/ds = −1 [m], −inf if β(1 + μ) ≥ 1 (§28)."""
        if self.beta * (1.0 + self.friction) >= 1.0:
            return -math.inf
        return self._arc_of_force(-self._gf * (1.0 + self.friction))

    @property
    def lowest_arc(self) -> float:
        """Arc of the lowest point [m]: 0 without friction, else ln(1 − βμ)/κ < 0."""
        return self._arc_of_force(-self._gf * self.friction)

    @property
    def _gf(self) -> float:
        return self.gamma * self.pendulum_length

    def _arc_of_force(self, force: float) -> float:
        """Return s with (e^{κs} − 1)/κ = force [m]."""
        return force * float(logarithmic_mean(np.asarray(self.kappa * force)))

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p = dx/ds = μ + (e^{κs} − 1)/(γκf)."""
        s = np.asarray(arc, np.float64)
        return self.friction + s * exponential_mean(self.kappa * s) / self._gf

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/ds = e^{κs}/(γf) [1/m]."""
        return np.exp(self.kappa * np.asarray(arc, np.float64)) / self._gf

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return x = μs + (e^{κs} − 1 − κs)/(γκ²f) [m]."""
        s = np.asarray(arc, np.float64)
        return self.friction * s + s * s * exponential_defect(self.kappa * s) / (2.0 * self._gf)

    def arc_of_height(self, height: ArrayLike, branch: Literal['descent', 'ascent']) -> FloatArray:
        """Return the arc s on a branch at a height above A [m].

        Newton's method on √x solves κs = ln(1 + κs + γκ²f x) (§16). With friction the curve about
        its lowest point is Euler's with f/(1 − βμ) in place of f.
        DescentError: a height below the lowest point, or NaN.
        """
        x = np.asarray(height, np.float64)
        lowest = self.lowest_arc
        above = x - self.height(lowest)
        if not np.all(above >= 0.0):
            raise DescentError(
                f'height {float(np.min(x))!r} m: the lowest point of the curve is at '
                f'{float(self.height(lowest))!r} m. Give a height above it'
            )
        root = np.sqrt(2.0 * self._gf / (1.0 - self.beta * self.friction) * above)
        if branch == 'ascent':
            root = -root
        # s √(2(e^{κs} − 1 − κs)/(κs)²) = root is convex in s: Newton's method from the right never
        # overshoots. The start is e^z − 1 − z ≥ z²/2 for z ≥ 0, and beyond z < 2 ln(1 + root)
        scaled = self.kappa * root
        log = logarithmic_mean(np.where(scaled > 0.0, scaled, 0.0))
        start = np.where(scaled > 0.0, root * np.minimum(1.0, 2.0 * log), root)

        def excess(arc: FloatArray) -> tuple[FloatArray, FloatArray]:
            z = self.kappa * arc
            growth = np.sqrt(exponential_defect(z))
            return arc * growth - root, exponential_mean(z) / growth

        return lowest + bracketed_newton(excess, start, (-math.inf, math.inf), relative=_ROUNDING)


# -----------------------------------------------------------------------------
# Coordinates and curvature of a curve in a fluid, and its outline for drawing and cutting.

# Least κ|s| at which an ascent without a cusp is straight to rounding, e⁻⁴⁰.
_FLAT = 40.0


def abscissa(curve: DescentCurve, arc: ArrayLike) -> FloatArray:
    """Return y = ∫ √(1 − p²) ds from A [m], the horizontal coordinate (1729, 29).

    By Gauss's quadrature in u, s = s* sin u, which removes the root at the cusp s*.
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

    DescentError: an arc beyond a cusp.
    """
    return curve.height(within(curve, arc)), abscissa(curve, arc)


def radius_of_curvature(curve: DescentCurve, arc: ArrayLike) -> FloatArray:
    """Return R = (dy/ds)/(dp/ds) [m], γf (dy/ds) e^{−κs} for Euler's curve (1729, 30).

    DescentError: an arc beyond a cusp.
    """
    s = within(curve, arc)
    return _cosine(curve, s) / curve.slope_rate(s)


def chained(curve: DescentCurve, arc: float, cusps: int) -> tuple[float, float]:
    """Return (x, y) [m] after the curve has passed cusps on the side of descent (1729, 30).

    Beyond each cusp it continues as its own mirror image, in arcs congruent to the one between the
    cusps. DescentError: an arc beyond a cusp, or a curve without one of them.
    """
    ends = curve.descent_cusp, curve.ascent_cusp
    if math.isinf(ends[0]) or math.isinf(ends[1]):
        raise DescentError(
            f'the curve has its cusps at {ends!r} m: one that is not there makes no chain of '
            'arcs. Take a shorter pendulum or a thinner fluid'
        )
    x, y = (float(part) for part in coordinates(curve, arc))
    right, x_left = (float(abscissa(curve, end)) for end in ends)
    width = right - x_left
    return x, right + (cusps - 0.5) * width + (-1) ** cusps * (y - 0.5 * (right + x_left))


def fluid_outline(curve: DescentCurve, points: int = 200) -> tuple[FloatArray, FloatArray]:
    """Return both branches as one polyline (horizontal, height) [m], ascent first.

    It has 2·points − 1 points, A among them. The branch of ascent ends at its cusp, or at the
    height of the cusp of descent. DescentError: fewer than two points.
    """
    if points < 2:
        raise DescentError(f'points = {points!r}: a branch needs at least 2')
    top, low = float(curve.height(curve.descent_cusp)), curve.ascent_cusp
    if math.isinf(low):
        low = -curve.descent_cusp
        while curve.height(low) < top:
            low *= 2.0
    if not curve.height(low) <= top:
        low = bisect(lambda arc: bool(curve.height(arc) <= top), 0.0, low)[0]
    # denser at the cusps, with a vertical tangent
    share = np.sin(np.linspace(0.0, 0.5 * math.pi, points))
    arc = np.concatenate([low * share[:0:-1], curve.descent_cusp * share])
    x, y = coordinates(curve, arc)
    return y, x


def _level(curve: DescentCurve, arc: FloatArray, cusp: float) -> FloatArray:
    """Return y at arcs on one side of A, with its cusp."""
    if math.isinf(cusp):
        end = np.maximum(arc, -_FLAT / curve.kappa)
        level = integrate(lambda s: _cosine(curve, s), np.zeros_like(end), end)
        return level + _cosine(curve, end) * (arc - end)

    def integrand(u: FloatArray) -> FloatArray:
        return cusp * np.cos(u) * _cosine(curve, cusp * np.sin(u))

    angle = np.arcsin(np.clip(arc / cusp, 0.0, 1.0))
    return integrate(integrand, np.zeros_like(angle), angle)


def _cosine(curve: DescentCurve, arc: FloatArray) -> FloatArray:
    """Return dy/ds = √(1 − p²), or 0 if p exceeds 1 by rounding at a cusp."""
    p = curve.slope(arc)
    return np.sqrt(np.maximum((1.0 - p) * (1.0 + p), 0.0))
