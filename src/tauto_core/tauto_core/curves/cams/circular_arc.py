"""A cheek in the form of a circular arc, an assumption for those before Euler (theory A)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from tauto_core.curves.cam import ArcLever, Cam, invert_lift
from tauto_core.curves.kind import CamKind, Setting
from tauto_core.curves.numerics import sine_defect
from tauto_core.samples import FloatArray
from tauto_core.scene.fields import Positive


@dataclass(frozen=True)
class CircularArc(Cam):
    """An assumed cheek before Euler: half a circle, vertical at its root, d below the axle.

    Euler says that the shape was found by repeated trial, and names none (E6, I).

    t = sgn ϑ (d sin|ϑ| + R (1 − cos ϑ)), for a vertical thread (theory A). The circle's centre
    is (∓R, d). The range is half a turn; there the thread has gone round the half disc and
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


class CircularArcCam(CamKind):
    """Cheek of a circular arc, assumed for the clocks before Euler (theory A)."""

    threads = ('vertical',)
    rank = 3
    starter = {'radius': 0.006, 'root_depth': 0.003}

    kind: Literal['circular_arc'] = 'circular_arc'
    radius: Positive = Field(description='radius of the arc [m]')
    root_depth: Positive = Field(description='depth of its root below the axle [m]')

    def made(self, setting: Setting) -> CircularArc:
        """Return the arc; it is the same for any wheel and power."""
        del setting
        return CircularArc(self.radius, self.root_depth)


KIND = CircularArcCam
