"""A force that depends on the lift of the cam in any way, and the cam that it makes of another.

A force F(H) without mass does the work E(H) = ∫ F dH. On a cam with the lever arm t(ϑ) and the
lift h(ϑ) its torque is F(h) t, which the constant force F(0) has on a cam of the lever arm

    t* = F(h) t/F(0),    h* = E(h)/F(0).

Wheel, energy, equation of motion and period are the same. So the machine is given that cam in
place of the real one, and no equation needs a further term (docs/theory/cams.md, section D).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.cam import ROOT_ROUNDING, Cam, SmoothLever, smooth_lever
from tauto_core.curves.cams.linear import LinearCam
from tauto_core.curves.numerics import bracketed_newton
from tauto_core.samples import FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

LEAST_POINTS = 6
"""Of a quintic spline."""


class ForceSplines(NamedTuple):
    """F, F', F'' and E."""

    force: PPoly
    slope: PPoly
    bend: PPoly
    energy: PPoly


@dataclass(frozen=True)
class ForceLaw:
    """F(h) as the quintic spline through points, whose derivatives up to the fourth have no jump.

    The spline ends without a condition (not-a-knot), so that a polynomial up to the fifth degree,
    as a spring's force is, comes out as itself.

    Attributes:
        points: lifts [m], which increase from 0, and forces [N], > 0; six or more.
    """

    points: tuple[tuple[float, float], ...] = field(repr=False)

    @cached_property
    def splines(self) -> ForceSplines:
        """The law and the functions derived from it."""
        from scipy.interpolate import PPoly, make_interp_spline  # slow to import

        lifts, forces = np.array(self.points).T
        whole = PPoly.from_spline(make_interp_spline(lifts, forces, k=5).tck)
        knots = np.unique(whole.x)
        pieces = np.searchsorted(whole.x, knots[:-1], side='right') - 1
        force = PPoly(np.ascontiguousarray(whole.c[:, pieces]), knots)
        return ForceSplines(force, force.derivative(), force.derivative(2), force.antiderivative())

    @property
    def at_rest(self) -> float:
        """F(0) [N]."""
        return float(self.force(0.0))

    @property
    def longest(self) -> float:
        """The largest lift of the points [m]."""
        return self.points[-1][0]

    @property
    def joints(self) -> FloatArray:
        """Lifts at which the fifth derivative jumps [m], increasing."""
        return np.asarray(self.splines.force.x[1:-1])

    @property
    def least(self) -> tuple[float, float]:
        """Lift [m] and value [N] of the least force between the points."""
        extremes = self.splines.slope.roots(extrapolate=False)
        lifts = np.concatenate([extremes[np.isfinite(extremes)], [0.0, self.longest]])
        forces = self.force(lifts)
        at = int(np.argmin(forces))
        return float(lifts[at]), float(forces[at])

    def force(self, lift: ArrayLike) -> FloatArray:
        """Return F [N] at lifts of 0 to `longest`."""
        return np.asarray(self.splines.force(np.asarray(lift, np.float64)))

    def slope(self, lift: ArrayLike) -> FloatArray:
        """Return dF/dh [N/m]."""
        return np.asarray(self.splines.slope(np.asarray(lift, np.float64)))

    def bend(self, lift: ArrayLike) -> FloatArray:
        """Return d²F/dh² [N/m²]."""
        return np.asarray(self.splines.bend(np.asarray(lift, np.float64)))

    def energy(self, lift: ArrayLike) -> FloatArray:
        """Return E = ∫ F dh from 0 [J]."""
        return np.asarray(self.splines.energy(np.asarray(lift, np.float64)))

    def lift_of_energy(self, energy: ArrayLike) -> FloatArray:
        """Return the lift at which E has the value ≥ 0 [m], to rounding."""
        goal = np.asarray(energy, np.float64)

        def excess(lift: FloatArray) -> tuple[FloatArray, FloatArray]:
            return self.energy(lift) - goal, self.force(lift)

        start = np.minimum(goal / self.at_rest, self.longest)
        return bracketed_newton(excess, start, (0.0, self.longest), relative=ROOT_ROUNDING)


def pulled(cam: Cam, law: ForceLaw) -> Cam:
    """Return the cam on which the constant F(0) makes the torque of a force on a given cam."""
    corrected = getattr(cam, 'corrected_for', None)
    if corrected == law:
        return Evened(float(cam.lever_rate(0.0)), cam.range_rad, cam, law)
    return Pulled(cam, law)


@dataclass(frozen=True, eq=False)
class Pulled(Cam):
    """A cam on which the constant F(0) makes the torque that the force F(h) makes on another.

    Attributes:
        cam: the other.
        law: F(h).
        scale: size of the other; all its lengths are multiplied by this.
    """

    cam: Cam
    law: ForceLaw
    scale: float = 1.0

    @cached_property
    def lever(self) -> SmoothLever:
        """The law of the lever arm as plain numbers."""
        return smooth_lever(self.lever_arm, self.lift, self.range_rad, self.joints)

    @cached_property
    def range_rad(self) -> float:
        """That of the other cam, or the angle at which the points of the force end [rad]."""
        edge = self.cam.range_rad
        if np.isfinite(edge) and self.scale * float(self.cam.lift(edge)) <= self.law.longest:
            return edge
        return float(self.cam.angle_of_lift(self.law.longest / self.scale))

    @cached_property
    def joints(self) -> FloatArray:
        """Those of the other cam, and the angles at which F is joined [rad]."""
        edge = self.range_rad
        highest = self.scale * float(self.cam.lift(edge))
        lifts = self.law.joints
        angles = self.cam.angle_of_lift(lifts[lifts < highest] / self.scale)
        found = np.unique(np.concatenate([self.cam.joints, angles]))
        return np.asarray(found[found < edge])

    def wider(self, amplitude: float, mass: float, period: float) -> str:
        """Return the change that widens the range to an amplitude, as the end of a sentence."""
        return wider_points(self.cam, self.law, self.scale, amplitude, mass, period)

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return the ϑ ≥ 0 of a lift h* [rad]."""
        found = self.law.lift_of_energy(np.asarray(lift) * self.law.at_rest) / self.scale
        if np.isfinite(self.cam.range_rad):
            found = np.minimum(found, float(self.cam.lift(self.cam.range_rad)))
        return np.minimum(self.cam.angle_of_lift(found), self.range_rad)

    def _forced(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the lift of the other cam, as far as the points reach, and F there."""
        lift = np.minimum(self.scale * self.cam.lift(x), self.law.longest)
        return lift, self.law.force(lift)

    def _arm(self, x: FloatArray) -> FloatArray:
        _, force = self._forced(x)
        return np.asarray(self.scale / self.law.at_rest * force * self.cam.lever_arm(x))

    def _rate(self, x: FloatArray) -> FloatArray:
        lift, force = self._forced(x)
        arm = self.cam.lever_arm(x)
        rate = force * self.cam.lever_rate(x) + self.scale * self.law.slope(lift) * arm * arm
        return np.asarray(self.scale / self.law.at_rest * rate)

    def _bend(self, x: FloatArray) -> FloatArray:
        lift, force = self._forced(x)
        arm, rate = self.scale * self.cam.lever_arm(x), self.scale * self.cam.lever_rate(x)
        bend = self.scale * force * self.cam.lever_curvature(x)
        bend = bend + (3.0 * self.law.slope(lift) * rate + self.law.bend(lift) * arm**2) * arm
        return np.asarray(bend / self.law.at_rest)

    def _lift(self, x: FloatArray) -> FloatArray:
        lift, _ = self._forced(x)
        return self.law.energy(lift) / self.law.at_rest

    def _rate_gain(self, x: FloatArray) -> FloatArray:
        return self._rate(x) - self._rate(np.zeros_like(x))


@dataclass(frozen=True, eq=False)
class Evened(LinearCam):
    """The cam made for a force: with it F(h) t = F(0) b ϑ, so that t* = b ϑ exactly.

    Attributes:
        rate: b = t'(0) [m/rad].
        edge: range of the cam [rad].
        cam: the cam itself.
        law: F(h).
    """

    rate: float
    edge: float
    cam: Cam
    law: ForceLaw

    @property
    def linear_rate(self) -> float:
        """Lever rate b [m/rad]."""
        return self.rate

    @property
    def range_rad(self) -> float:
        """That of the cam [rad]."""
        return self.edge

    def wider(self, amplitude: float, mass: float, period: float) -> str:
        """Return the change that widens the range to an amplitude, as the end of a sentence."""
        return self.cam.wider(amplitude, mass, period)


def wider_points(
    cam: Cam, law: ForceLaw, scale: float, amplitude: float, mass: float, period: float
) -> str:
    """Return how far the points of a force must reach for an amplitude, as the end of a sentence.

    If the cam ends first, the change that widens the cam.
    """
    if amplitude > cam.range_rad:
        return cam.wider(amplitude, mass, period)
    reached = scale * float(cam.lift(amplitude))
    return (
        f', or give trochlea.power.points up to a lift of {reached:.6g} m (they end at '
        f'{law.longest!r} m)'
    )


def as_law(points: Sequence[tuple[float, float]]) -> ForceLaw:
    """Return the law through points."""
    return ForceLaw(tuple((float(lift), float(force)) for lift, force in points))
