"""Isochronous cams for powers with inertia or stiffness, unlike Euler's two.

The well is exactly harmonic in the arc s = ∫ √(I + m t²) dϑ if V = ½ ω² s². With a weight of mass
m, V = m g h, and in the plane (√(I/m) ϑ, h) the machine moves like a bead on a wire, which must be
Huygens' cycloid. With a massless spring, V = P h + κh²/2 = ½ k ϑ², k = I ω². Another force has its
own integral (docs/theory/cams.md, section D).

All take a vertical thread or one through a hole. A weight moves strictly along the thread only
with a hole. A vertical thread is the limit of a long one (A in wheel.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.cam import (
    ROOT_ROUNDING,
    Cam,
    ForceLaw,
    PeriodCam,
    Setting,
    SpringLever,
    rate_for_period,
)
from tauto_core.curves.cams.linear import LinearCam
from tauto_core.curves.numerics import (
    bisect,
    bracketed_newton,
    sine_defect,
)
from tauto_core.samples import FloatArray

AWAY = ', or move the hole away from the axle'
FURTHER = ', or give trochlea.power.points up to a larger lift'
STEEPEST_THREAD = 1000.0
"""tan χ at the edge of a weight's cam on a vertical thread, near the pole of t."""


@dataclass(frozen=True)
class WeightCorrected(Cam):
    """The isochronous cam for a weight with inertia.

    With λ = √(I/m), L = λ²/r = g/ω² and the slope χ of the cycloid:
    ϑ = (L/2λ)(χ + sin χ cos χ), h = (L/2) sin²χ, t = λ tan χ, t' = r sec⁴χ, t'' = 4(λ³/L²) tan χ
    sec⁶χ. The arc is L√m sin χ. On a vertical thread the range is πλ/(4r) less 4e-10 of it, with a
    lever arm of 1000 λ just before its pole. Through a hole at distance a, tan χ ≤ a/λ.

    Attributes:
        rate: r = t'(0) = I ω²/(m g) [m/rad], > 0.
        mass_ratio: m/I [1/m²], > 0.
        distance: distance of the hole from the axle, a [m], inf for a vertical thread.
    """

    rate: float
    mass_ratio: float
    distance: float = math.inf
    knows_angle_of_lift = True
    widening = ', or use a heavier weight or a longer period'

    @property
    def suits(self) -> tuple[float, float]:
        """(m/I, 0): a weight of this inertia, in any gravity."""
        return self.mass_ratio, 0.0

    @property
    def range_rad(self) -> float:
        """Angle at which t reaches the hole, or the range on a vertical thread [rad]."""
        return float(self.angle_of_slope(min(self.distance / self.gyration, STEEPEST_THREAD)))

    @property
    def drawn_rad(self) -> float:
        """At most a turn, on a vertical thread up to t = λ [rad], before it gets too wide."""
        steepest = STEEPEST_THREAD if math.isfinite(self.distance) else 1.0
        return min(self.range_rad, math.tau, float(self.angle_of_slope(steepest)))

    @property
    def gyration(self) -> float:
        """λ = √(I/m) [m]."""
        return 1.0 / math.sqrt(self.mass_ratio)

    @property
    def length(self) -> float:
        """L = λ²/r = g/ω² [m]: of the isochronous simple pendulum."""
        return 1.0 / (self.mass_ratio * self.rate)

    def angle_of_slope(self, slope: ArrayLike) -> FloatArray:
        """Return ϑ ≥ 0 [rad] of tan χ = t/λ ≥ 0."""
        slope = np.asarray(slope, dtype=np.float64)
        halved = np.arctan(slope) + slope / (1.0 + slope * slope)
        return np.asarray(0.5 * self.gyration / self.rate * halved)

    def slope(self, angle: ArrayLike) -> FloatArray:
        """Return tan χ = t/λ, odd in ϑ, from Kepler's equation χ + sin χ cos χ = 2rϑ/λ."""
        angle = self.within(angle)
        return np.copysign(self._slope(np.abs(angle)), angle)

    def _slope(self, x: FloatArray) -> FloatArray:
        x = np.asarray(x)
        per_rad, flat = 2.0 * self.rate / self.gyration, np.atleast_1d(x)
        mean = per_rad * flat
        # beyond three quarters of the way to π/2 the angle counts from π/2
        values, is_near = np.empty_like(mean), mean < 1.2
        if is_near.any():
            part = mean[is_near]

            def rising(chi: FloatArray) -> tuple[FloatArray, FloatArray]:
                cosine = np.cos(chi)
                return chi + np.sin(chi) * cosine - part, 2.0 * cosine * cosine

            # two terms of the series of χ about the middle, half of the mean ≤ χ ≤ the mean
            start, bracket = 0.5 * part * (1.0 + part * part / 12.0), (0.5 * part, part)
            values[is_near] = np.tan(
                bracketed_newton(rising, start, bracket, relative=ROOT_ROUNDING, absolute=1e-17)
            )
        if not is_near.all():
            # w = π/2 − χ, w − sin w cos w = gap
            edge = 0.25 * math.pi * self.gyration / self.rate
            gap = per_rad * (edge - flat[~is_near])

            def falling(w: FloatArray) -> tuple[FloatArray, FloatArray]:
                sine = np.sin(w)
                return 0.5 * sine_defect(2.0 * w) - gap, 2.0 * sine * sine

            # w − sin w cos w = ⅔w³ − …: the second term gives the factor of the start
            w = np.cbrt(1.5 * gap)
            start, bracket = w * (1.0 + w * w / 15.0), (0.5 * w, 2.0 * w)
            values[~is_near] = 1.0 / np.tan(
                bracketed_newton(falling, start, bracket, relative=ROOT_ROUNDING)
            )
        return values.reshape(x.shape)

    def _arm(self, x: FloatArray) -> FloatArray:
        return self.gyration * self._slope(x)

    def _rate(self, x: FloatArray) -> FloatArray:
        slope = self._slope(x)
        secant = 1.0 + slope * slope
        return np.asarray(self.rate * (secant * secant))

    def _bend(self, x: FloatArray) -> FloatArray:
        slope = self._slope(x)
        secant = 1.0 + slope * slope
        factor = 4.0 * self.rate**2 / self.gyration
        return factor * slope * (secant * secant * secant)

    def _lift(self, x: FloatArray) -> FloatArray:
        slope = self._slope(x)
        square = slope * slope
        return 0.5 * self.length * (square / (1.0 + square))

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return the ϑ ≥ 0 of a lift [rad], for 0 ≤ h ≤ h(range)."""
        lift, highest = self._reached(lift)
        square = 2.0 * np.minimum(lift, highest) / self.length
        return np.minimum(self.angle_of_slope(np.sqrt(square / (1.0 - square))), self.range_rad)


@dataclass(frozen=True)
class SpringCorrected(Cam):
    """The isochronous cam for a spring of any stiffness without mass.

    With b = I ω²/P and c² = bκ/P: t = bϑ/√(1 + c²ϑ²), h = bϑ²/(1 + √(1 + c²ϑ²)), the involute as
    κ → 0. The torque is exactly −I ω²ϑ. Through a hole at distance a the range is a/√(b² − a²c²),
    or unlimited if a c ≥ b. The cheek may be hollow at its tip (`hollow`).

    Attributes:
        rate: b = t'(0) [m/rad], > 0.
        stiffness_ratio: κ/P [1/m], ≥ 0.
        distance: distance of the hole from the axle, a [m], inf for a vertical thread.
    """

    rate: float
    stiffness_ratio: float
    distance: float = math.inf
    knows_angle_of_lift = True
    widening = AWAY

    @property
    def lever(self) -> SpringLever:
        """The law of the lever arm as plain numbers."""
        return SpringLever(self.rate, self.bend)

    @property
    def bend(self) -> float:
        """c² = bκ/P [1/rad²]."""
        return self.rate * self.stiffness_ratio

    @property
    def suits(self) -> tuple[float, float]:
        """(0, κ/P): a spring of this stiffness for its pull, without inertia."""
        return 0.0, self.stiffness_ratio

    @property
    def range_rad(self) -> float:
        """Angle at which t reaches the hole [rad], or inf."""
        reached = self.distance * math.sqrt(self.bend)
        if math.isinf(self.distance) or reached >= self.rate:
            return math.inf
        return self.distance / math.sqrt((self.rate - reached) * (self.rate + reached))

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return ϑ = √(h (2 + hκ/P)/b) [rad], for 0 ≤ h ≤ h(range)."""
        lift = np.asarray(lift, dtype=np.float64)
        return self.within(np.sqrt(lift * (2.0 + self.stiffness_ratio * lift) / self.rate))

    def _square(self, x: FloatArray) -> FloatArray:
        return 1.0 + self.bend * x * x

    def _arm(self, x: FloatArray) -> FloatArray:
        return self.rate * x / np.sqrt(self._square(x))

    def _rate(self, x: FloatArray) -> FloatArray:
        square = self._square(x)
        return self.rate / (square * np.sqrt(square))

    def _bend(self, x: FloatArray) -> FloatArray:
        square = self._square(x)
        return -3.0 * self.rate * self.bend * x / (square * square * np.sqrt(square))

    def _lift(self, x: FloatArray) -> FloatArray:
        return self.rate * x * x / (1.0 + np.sqrt(self._square(x)))


# -----------------------------------------------------------------------------
# A force F(H) without mass that depends on the lift does the work E(H) = ∫ F dH. On a cam with the
# lever arm t(ϑ) and the lift h(ϑ) its torque is F(h) t, as of the constant force F(0) on a cam
# with
#
#     t* = F(h) t/F(0),    h* = E(h)/F(0).
#
# Energy, equation of motion and period are the same. The machine gets that cam in place of the
# real one, and its equations stay as they are (docs/theory/cams.md, section D).

_PROBES = 2000


@dataclass(frozen=True)
class ForceTableCorrected(Cam):
    """The isochronous cam for a force F(h) without mass.

    E(h) = ½F(0) b ϑ², with E = ∫ F dh: the torque F t is exactly F(0) b ϑ = I ω²ϑ, and

        t = F(0) b ϑ/F,    t' = (F(0) b − F' t²)/F,    t'' = −(3F' t' + F'' t²) t/F.

    It ends with the table, or as t reaches the hole.

    Attributes:
        rate: b = t'(0) = I ω²/F(0) [m/rad], > 0.
        law: F(h).
        distance: distance of the hole from the axle, a [m], inf for a vertical thread.
    """

    rate: float
    law: ForceLaw
    distance: float = math.inf
    knows_angle_of_lift = True
    widening = f'{FURTHER}{AWAY}'

    @property
    def _stiffness(self) -> float:
        """I ω² = F(0) b [N m/rad]."""
        return self.law.at_rest * self.rate

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return ϑ = √(2E/F(0)b) [rad]."""
        angle = np.sqrt(2.0 * self.law.energy(lift) / self._stiffness)
        return np.asarray(np.minimum(angle, self.range_rad))

    @cached_property
    def range_rad(self) -> float:
        """Angle at which the table ends, or t reaches the hole [rad]."""
        edge = math.sqrt(2.0 * float(self.law.energy(self.law.longest)) / self._stiffness)
        if math.isinf(self.distance):
            return edge

        def within(angle: float) -> bool:
            return float(self._arm(np.array([angle]))[0]) <= self.distance

        angles = np.linspace(0.0, edge, _PROBES)
        bad = np.flatnonzero(self._arm(angles) > self.distance)
        if not len(bad):
            return edge
        return bisect(within, float(angles[bad[0] - 1]), float(angles[bad[0]]))[0]

    @cached_property
    def joints(self) -> FloatArray:
        """Angles at which F is joined [rad]."""
        angles = np.sqrt(2.0 * self.law.energy(self.law.joints) / self._stiffness)
        return np.asarray(angles[angles < self.range_rad])

    def _lift(self, x: FloatArray) -> FloatArray:
        return self.law.lift_of_energy(0.5 * self._stiffness * x * x)

    def _arm(self, x: FloatArray) -> FloatArray:
        return np.asarray(self._stiffness * x / self.law.force(self._lift(x)))

    def _rate(self, x: FloatArray) -> FloatArray:
        lift = self._lift(x)
        force = self.law.force(lift)
        arm = self._stiffness * x / force
        return np.asarray((self._stiffness - self.law.slope(lift) * arm * arm) / force)

    def _bend(self, x: FloatArray) -> FloatArray:
        lift = self._lift(x)
        force, slope = self.law.force(lift), self.law.slope(lift)
        arm = self._stiffness * x / force
        rate = (self._stiffness - slope * arm * arm) / force
        return np.asarray(-(3.0 * slope * rate + self.law.bend(lift) * arm * arm) * arm / force)


def pulled(cam: Cam, law: ForceLaw) -> Cam:
    """Return the cam on which the constant F(0) has the torque of F(h) on a given cam."""
    if isinstance(cam, ForceTableCorrected) and cam.law == law:
        return LinearisedCam(float(cam.lever_rate(0.0)), cam.range_rad, cam, law)
    return EquivalentCam(cam, law)


@dataclass(frozen=True, eq=False)
class EquivalentCam(Cam):
    """A cam on which the constant F(0) has the torque of the force F(h) on another.

    Attributes:
        cam: the other.
        law: F(h).
        scale: factor of all lengths of the other.
    """

    cam: Cam
    law: ForceLaw
    scale: float = 1.0
    widening = f'{FURTHER}{Cam.widening}'

    @cached_property
    def range_rad(self) -> float:
        """Range of the other cam, or angle at which the points of the force end [rad]."""
        edge = self.cam.range_rad
        if np.isfinite(edge) and self.scale * float(self.cam.lift(edge)) <= self.law.longest:
            return edge
        return float(self.cam.angle_of_lift(self.law.longest / self.scale))

    @cached_property
    def joints(self) -> FloatArray:
        """Joints of the other cam, and angles at which F is joined [rad]."""
        edge = self.range_rad
        highest = self.scale * float(self.cam.lift(edge))
        lifts = self.law.joints
        angles = self.cam.angle_of_lift(lifts[lifts < highest] / self.scale)
        joints = np.unique(np.concatenate([self.cam.joints, angles]))
        return np.asarray(joints[joints < edge])

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return the ϑ ≥ 0 of a lift h* [rad]."""
        lifts = self.law.lift_of_energy(np.asarray(lift) * self.law.at_rest) / self.scale
        if np.isfinite(self.cam.range_rad):
            lifts = np.minimum(lifts, float(self.cam.lift(self.cam.range_rad)))
        return np.minimum(self.cam.angle_of_lift(lifts), self.range_rad)

    def _forced(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the lift of the other cam, up to the last point, and F there."""
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


@dataclass(frozen=True, eq=False)
class LinearisedCam(LinearCam):
    """The cam corrected for a force: F(h) t = F(0) b ϑ, hence t* = b ϑ exactly.

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
    widening = ForceTableCorrected.widening

    @property
    def linear_rate(self) -> float:
        """Lever rate b [m/rad]."""
        return self.rate

    @property
    def range_rad(self) -> float:
        """Range of the cam [rad]."""
        return self.edge


# -----------------------------------------------------------------------------
# The kinds.


class WeightCorrectedCam(PeriodCam):
    """The isochronous cam for a weight with inertia, for one period (D in cams.md)."""

    corrects = 'weight'
    rank = 5

    kind: Literal['weight_corrected'] = 'weight_corrected'

    def made(self, setting: Setting) -> WeightCorrected:
        """Return the cam for the wheel and its weight."""
        rate = rate_for_period(setting, self.period)
        return WeightCorrected(rate, setting.pull.carried_mass / setting.inertia, setting.distance)


class SpringCorrectedCam(PeriodCam):
    """The isochronous cam for a spring with stiffness, for one period (D in cams.md)."""

    corrects = 'spring'
    if_hollow = 'use a softer spring, a longer period or a nearer hole'
    rank = 6

    kind: Literal['spring_corrected'] = 'spring_corrected'

    def made(self, setting: Setting) -> SpringCorrected:
        """Return the cam for the wheel and its spring."""
        rate, pull = rate_for_period(setting, self.period), setting.pull
        return SpringCorrected(rate, pull.stiffness / pull.force, setting.distance)


class ForceTableCorrectedCam(PeriodCam):
    """The isochronous cam for a force given by a table, for one period (D in cams.md)."""

    corrects = 'force_table'
    if_hollow = 'use a longer period, or points of a force that rises less with the lift'
    rank = 10

    kind: Literal['force_table_corrected'] = 'force_table_corrected'

    def made(self, setting: Setting) -> ForceTableCorrected:
        """Return the cam for the wheel and its force."""
        law = setting.pull.law
        assert law is not None  # by `corrects`
        return ForceTableCorrected(rate_for_period(setting, self.period), law, setting.distance)


KINDS = WeightCorrectedCam, SpringCorrectedCam, ForceTableCorrectedCam
