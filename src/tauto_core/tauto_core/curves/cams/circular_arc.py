"""A cheek in the form of a circular arc, an assumption for clocks before Euler."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from pydantic import Field

from tauto_core.curves.cam import ArcLever, Cam, CamKind, Setting
from tauto_core.curves.numerics import sine_defect
from tauto_core.samples import FloatArray
from tauto_core.scene.sections import NonNegative, Positive


@dataclass(frozen=True)
class CircularArc(Cam):
    """An assumed cheek before Euler: half a circle, vertical at its root, d below the axle.

    Euler says that the shape was found by repeated trial, and does not name it (E6, I).

    t = sgn ϑ (d sin|ϑ| + R (1 − cos ϑ)), for a vertical thread. t'' jumps from −R to R at rest.
    The circle's centre is (∓R, d). The range is half a turn, at which the thread leaves the half
    disc at its outer corner (∓2R, d), level with the root. Within it t > 0, and the thread meets
    neither the other cheek nor the axle.

    Attributes:
        radius: R of the arc [m], > 0.
        root_depth: d [m], ≥ 0. Cheeks rooted in the axle as Euler has them (E6, II), d = 0, have
            t ∝ ϑ² and no period of small swings.
    """

    radius: float
    root_depth: float
    kinked = True

    @property
    def lever(self) -> ArcLever:
        """The law of the lever arm as plain numbers."""
        return ArcLever(self.root_depth, self.radius)

    @property
    def range_rad(self) -> float:
        """π: half a turn round the disc."""
        return math.pi

    def _arm(self, x: FloatArray) -> FloatArray:
        h = 0.5 * x
        return 2.0 * np.sin(h) * (self.root_depth * np.cos(h) + self.radius * np.sin(h))

    def _rate(self, x: FloatArray) -> FloatArray:
        return self.root_depth * np.cos(x) + self.radius * np.sin(x)

    def _bend(self, x: FloatArray) -> FloatArray:
        return self.radius * np.cos(x) - self.root_depth * np.sin(x)

    def _lift(self, x: FloatArray) -> FloatArray:
        sine = np.sin(0.5 * x)
        return 2.0 * self.root_depth * (sine * sine) + self.radius * sine_defect(x)


class CircularArcCam(CamKind):
    """Cheek of a circular arc, assumed for the clocks before Euler (A in wheel.md)."""

    threads = ('vertical',)
    rank = 3
    starter = {'radius': 0.006, 'root_depth': 0.003}

    kind: Literal['circular_arc'] = 'circular_arc'
    radius: Positive = Field(description='radius of the arc [m]')
    root_depth: NonNegative = Field(
        description='depth of its root below the axle [m]. With 0 small swings have no '
        'period, and the swing from the release angle gives it'
    )

    def made(self, setting: Setting) -> CircularArc:
        """Return the arc, the same for any wheel and power."""
        return CircularArc(self.radius, self.root_depth)


KIND = CircularArcCam
