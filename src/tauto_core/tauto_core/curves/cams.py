"""The cams with a closed form: Euler's two, and the circular cheek that was before them."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.cam import Cam
from tauto_core.curves.inversion import invert_lift
from tauto_core.curves.levers import ArcLever, LinearLever
from tauto_core.curves.series import arctangent_defect, involute_defect, sine_defect
from tauto_core.samples import FloatArray


class LinearCam(Cam):
    """A cam whose lever arm is t = b·ϑ, h = b·ϑ²/2."""

    @property
    @abstractmethod
    def linear_rate(self) -> float:
        """Lever rate b [m/rad]."""

    @property
    def lever(self) -> LinearLever:
        """The law of the lever arm as plain numbers."""
        return LinearLever(self.linear_rate)

    @property
    def suits(self) -> tuple[float, float]:
        """(0, 0): a constant pull without inertia."""
        return 0.0, 0.0

    def lever_arm(self, angle: ArrayLike) -> FloatArray:
        """Return t = b·ϑ [m]."""
        return self.linear_rate * self.within(angle)

    def lever_rate(self, angle: ArrayLike) -> FloatArray:
        """Return b [m/rad]."""
        return np.full_like(self.within(angle), self.linear_rate)

    def lever_curvature(self, angle: ArrayLike) -> FloatArray:
        """Return 0 [m/rad²]."""
        return np.zeros_like(self.within(angle))

    def lift(self, angle: ArrayLike) -> FloatArray:
        """Return h = b·ϑ²/2 [m]."""
        angle = self.within(angle)
        return 0.5 * self.linear_rate * angle * angle

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return ϑ = √(2h/b) [rad], for 0 ≤ h ≤ h(range)."""
        angle = np.sqrt(2.0 * np.asarray(lift, dtype=np.float64) / self.linear_rate)
        return self.within(angle)

    def _rate_gain(self, angle: FloatArray) -> FloatArray:
        return np.zeros_like(angle)

    def _hanging_contact(self, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
        b = self.linear_rate
        return -b * involute_defect(angle), b * (np.cos(angle) + angle * np.sin(angle))


@dataclass(frozen=True)
class Involute(LinearCam):
    """Involute of a circle, for a vertical thread: t = r·ϑ (§VII–XIV). No range.

    Attributes:
        base_radius: radius r of the circle [m], > 0.
    """

    base_radius: float

    @property
    def linear_rate(self) -> float:
        """Lever rate r [m/rad]."""
        return self.base_radius

    @property
    def range_rad(self) -> float:
        """Infinite: the involute can be wound on for ever."""
        return math.inf

    def polar(self, roll_angle: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return polar angle [rad] and radius [m] of the curve from the roll angle z = ϑ.

        x = z − arctan z from the tip, counter-clockwise; r·√(1 + z²) (§XII–XIII).
        """
        z = self.within(roll_angle)
        return arctangent_defect(z), self.base_radius * np.hypot(1.0, z)


@dataclass(frozen=True)
class Hole(LinearCam):
    """Euler's cam for a thread through a fixed hole: t = b·ϑ for |t| ≤ a (§XXII–XXIX).

    At the edge of its range, a/b, the contact point reaches the hole.

    Attributes:
        rate: lever arm per angle b [m/rad], > 0.
        distance: of the hole from the axle, a [m], > 0.
    """

    rate: float
    distance: float

    @property
    def linear_rate(self) -> float:
        """Lever rate b [m/rad]."""
        return self.rate

    @property
    def range_rad(self) -> float:
        """a/b [rad]."""
        return self.distance / self.rate

    @property
    def hole_distance(self) -> float:
        """Distance a of the hole [m]."""
        return self.distance

    def p_of_lever_arm(self, lever_arm: ArrayLike) -> FloatArray:
        """Return p = b·√(a² − t²)/(b + √(a² − t²)) [m] for |t| ≤ a (§XXIX)."""
        arm = np.asarray(lever_arm, dtype=np.float64)
        return self.rate * self._thread_at(arm, np.full_like(arm, self.rate)).share


@dataclass(frozen=True)
class CircularArc(Cam):
    """The cheek before Euler: half a circle, root at depth d under the axle, vertical there.

    t = sgn ϑ (d sin|ϑ| + R (1 − cos ϑ)), for a vertical thread (theory E2). The circle's centre
    is (∓R, d). The range is half a turn: there the thread has gone round the half disc and
    leaves it at its outer corner (∓2R, d), level with the root. Up to there it meets neither
    the other cheek nor the axle, and t > 0, so that the well rises all the way.

    Attributes:
        radius: R of the arc [m], > 0.
        root_depth: d [m], > 0.
    """

    radius: float
    root_depth: float

    @property
    def lever(self) -> ArcLever:
        """The law of the lever arm as plain numbers."""
        return ArcLever(self.root_depth, self.radius)

    @property
    def range_rad(self) -> float:
        """π: half a turn round the disc."""
        return math.pi

    @property
    def kinked(self) -> bool:
        """True: t'' jumps from −R to R at rest."""
        return True

    def lever_arm(self, angle: ArrayLike) -> FloatArray:
        """Return t [m]."""
        angle = self.within(angle)
        half = 0.5 * np.abs(angle)
        arm = 2.0 * np.sin(half) * (self.root_depth * np.cos(half) + self.radius * np.sin(half))
        return np.copysign(arm, angle)

    def lever_rate(self, angle: ArrayLike) -> FloatArray:
        """Return t' = d cos ϑ + R sin|ϑ| [m/rad]."""
        angle = np.abs(self.within(angle))
        return self.root_depth * np.cos(angle) + self.radius * np.sin(angle)

    def lever_curvature(self, angle: ArrayLike) -> FloatArray:
        """Return t'' = sgn ϑ (R cos ϑ − d sin|ϑ|) [m/rad²]; ±R at ±0."""
        angle = self.within(angle)
        size = np.abs(angle)
        bend = self.radius * np.cos(size) - self.root_depth * np.sin(size)
        return np.copysign(1.0, angle) * bend

    def lift(self, angle: ArrayLike) -> FloatArray:
        """Return h = d (1 − cos ϑ) + R (|ϑ| − sin|ϑ|) [m]."""
        angle = np.abs(self.within(angle))
        sine = np.sin(0.5 * angle)
        rise = 2.0 * self.root_depth * (sine * sine)
        return rise + self.radius * sine_defect(angle)

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return the ϑ ≥ 0 of a lift [rad], for 0 ≤ h ≤ h(π)."""
        return invert_lift(self, lift)

    def _rate_gain(self, angle: FloatArray) -> FloatArray:
        sine = np.sin(0.5 * angle)
        drop = 2.0 * self.root_depth * (sine * sine)
        return self.radius * np.sin(np.abs(angle)) - drop

    def _hanging_contact(self, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
        sine = np.sin(0.5 * angle)
        back = 2.0 * self.radius * (sine * sine)
        side = self.root_depth + self.radius * np.sin(np.abs(angle))
        return -np.copysign(back, angle), side
