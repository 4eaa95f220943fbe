"""Curves on which a body slides through a fluid, as functions of one signed arc.

Euler, *Curva tautochrona in fluido* (1729). The arc s [m] is counted from the point A: s > 0 on
the branch of descent AM, s < 0 on that of ascent AN. A half swing goes from s > 0 to s < 0, a
reverse half swing the other way. x(s) is the height above A and p = dx/ds the slope, the sine of
the inclination; where it reaches ±1 the curve has its cusp. Every function takes numbers or arrays
of any shape. Slope and height are analytic beyond the cusps; `within` refuses arcs beyond them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.samples import FloatArray
from tauto_core.scene.errors import DescentError


class DescentCurve(Protocol):
    """A curve and the fluid for which it is made."""

    @property
    def kappa(self) -> float:
        """κ: deceleration by the fluid over the square of the speed [1/m], ≥ 0."""

    @property
    def gamma(self) -> float:
        """γ: acceleration in the fluid over that in vacuum, 0 < γ ≤ 1."""

    @property
    def pendulum_length(self) -> float:
        """f: length of the simple pendulum in vacuum that keeps time with small swings [m]."""

    @property
    def descent_cusp(self) -> float:
        """Arc of the cusp on the branch of descent [m], > 0; inf where there is none."""

    @property
    def ascent_cusp(self) -> float:
        """Arc of the cusp on the branch of ascent [m], < 0; −inf where there is none."""

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p = dx/ds."""

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/ds [1/m]."""

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return x(s) [m], 0 at A."""


def check_medium(kappa: float, gamma: float, pendulum_length: float) -> None:
    """Refuse numbers that no body in a fluid can have.

    Raises:
        DescentError: κ < 0, γ outside (0, 1], f ≤ 0, or any that is not finite.
    """
    limits = (
        ('kappa', kappa, 'at least 0 1/m', 0.0 <= kappa < math.inf),
        ('gamma', gamma, 'above 0 and at most 1: the body must sink', 0.0 < gamma <= 1.0),
        ('pendulum_length', pendulum_length, 'above 0 m', 0.0 < pendulum_length < math.inf),
    )
    for name, value, limit, good in limits:
        if not good:
            raise DescentError(f'{name} = {value!r}: must be finite and {limit}; give another')


def within(curve: DescentCurve, arc: ArrayLike) -> FloatArray:
    """Return the arcs as an array.

    Raises:
        DescentError: an arc beyond a cusp, or NaN.
    """
    found = np.asarray(arc, np.float64)
    bad = ~((found >= curve.ascent_cusp) & (found <= curve.descent_cusp))
    bad |= np.isinf(found)
    if np.any(bad):
        worst = float(found[bad].flat[0])
        raise DescentError(
            f'arc {worst!r} m: the curve runs from {curve.ascent_cusp!r} m to '
            f'{curve.descent_cusp!r} m, where it has its cusps; stay within, or take a longer '
            'pendulum'
        )
    return found


@dataclass(frozen=True)
class Cycloid:
    """Huygens' cycloid, γ f dx/ds = s: the tautochrone in vacuum, used in a fluid (1729, 18).

    Attributes:
        kappa: κ of the fluid, which the curve does not take into account [1/m].
        gamma: acceleration in the fluid over that in vacuum.
        pendulum_length: f [m].
    """

    kappa: float
    gamma: float
    pendulum_length: float

    def __post_init__(self) -> None:
        check_medium(self.kappa, self.gamma, self.pendulum_length)

    @property
    def descent_cusp(self) -> float:
        """Arc γf of the cusp [m]."""
        return self.gamma * self.pendulum_length

    @property
    def ascent_cusp(self) -> float:
        """Arc −γf of the cusp [m]."""
        return -self.descent_cusp

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
class SymmetricCurve:
    """γ f dx/ds = s + (4/9) κ² s³: closer to isochronous than Euler's curve for swings to and fro.

    On a cycloid in the fluid a swing to and fro takes 1 + (κS)²/6 of a small swing, with S its
    arc. A term cκ²s³ of the force reduces that by 3c(κS)²/8, so c = 4/9 leaves no error of second
    order in either direction. The curve does not depend on the direction of the motion.

    Attributes:
        kappa: κ of the fluid [1/m].
        gamma: acceleration in the fluid over that in vacuum.
        pendulum_length: f [m].
    """

    kappa: float
    gamma: float
    pendulum_length: float

    def __post_init__(self) -> None:
        check_medium(self.kappa, self.gamma, self.pendulum_length)

    @property
    def descent_cusp(self) -> float:
        """Arc of the cusp [m]: the root of the cubic s + (4/9) κ² s³ = γf, by hyperbolic sines."""
        end = self.gamma * self.pendulum_length
        z = math.sqrt(3.0) * self.kappa * end
        return end if z == 0.0 else end * 3.0 * math.sinh(math.asinh(z) / 3.0) / z

    @property
    def ascent_cusp(self) -> float:
        """Arc of the cusp on the other side [m]."""
        return -self.descent_cusp

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
class ActaCurve:
    """Curve of the Acta of 1726: γ f dx/ds = s + κ(S² − s²), for one start S (1729, 2–5).

    From S the body reaches A in (π/2)√(f/g), with s = S cos ωt. From other starts it does not, so
    each start needs a curve of its own. At A the slope is κS²/γf.

    Attributes:
        kappa: κ of the fluid [1/m].
        gamma: acceleration in the fluid over that in vacuum.
        pendulum_length: f [m].
        start: S [m], > 0.

    Raises:
        DescentError: a start from which the curve would be steeper than vertical on the way.
    """

    kappa: float
    gamma: float
    pendulum_length: float
    start: float

    def __post_init__(self) -> None:
        check_medium(self.kappa, self.gamma, self.pendulum_length)
        top = self.start
        if self.kappa * self.start > 0.5:
            top = 0.5 / self.kappa
        if not (self.start > 0.0 and self.slope(top) <= 1.0):
            raise DescentError(
                f'start = {self.start!r} m: must be > 0 and the curve from there nowhere steeper '
                f'than upright, but its slope at {top!r} m is {float(self.slope(top))!r}; start '
                'nearer to A or take a longer pendulum'
            )

    @property
    def descent_cusp(self) -> float:
        """Arc at which the slope reaches 1 [m]; inf if it never does."""
        room = self.gamma * self.pendulum_length - self.kappa * self.start**2
        square = 1.0 - 4.0 * self.kappa * room
        return 2.0 * room / (1.0 + math.sqrt(square)) if square >= 0.0 else math.inf

    @property
    def ascent_cusp(self) -> float:
        """Arc at which the slope reaches −1 [m]."""
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


@dataclass(frozen=True)
class Mirrored:
    """A curve with its branches exchanged, s → −s, for reverse half swings.

    Attributes:
        curve: the original curve.
    """

    curve: DescentCurve

    @property
    def kappa(self) -> float:
        """κ of the curve [1/m]."""
        return self.curve.kappa

    @property
    def gamma(self) -> float:
        """γ of the curve."""
        return self.curve.gamma

    @property
    def pendulum_length(self) -> float:
        """f of the curve [m]."""
        return self.curve.pendulum_length

    @property
    def descent_cusp(self) -> float:
        """Arc of the cusp on the original's branch of ascent [m]."""
        return -self.curve.ascent_cusp

    @property
    def ascent_cusp(self) -> float:
        """Arc of the cusp on the original's branch of descent [m]."""
        return -self.curve.descent_cusp

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p."""
        return -self.curve.slope(-np.asarray(arc, np.float64))

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/ds [1/m]."""
        return self.curve.slope_rate(-np.asarray(arc, np.float64))

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return x [m]."""
        return self.curve.height(-np.asarray(arc, np.float64))
