"""The involute of a circle, for a vertical thread (Euler 1727, VII–XIV)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from tauto_core.curves.cam import LinearCam
from tauto_core.curves.kind import CamKind, Setting
from tauto_core.curves.lever_geometry import LeverGeometry, LeverSetting
from tauto_core.curves.numerics import arctangent_defect
from tauto_core.samples import FloatArray
from tauto_core.scene.fields import Positive


@dataclass(frozen=True)
class Involute(LinearCam):
    """Involute of a circle, for a vertical thread: t = r·ϑ (§VII–XIV). It has no limit of range.

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
        """Infinite: any length of thread can be wound on the involute."""
        return math.inf

    def polar(self, roll_angle: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return polar angle [rad] and radius [m] of the curve from the roll angle z = ϑ.

        x = z − arctan z from the tip, counter-clockwise; r·√(1 + z²) (§XII–XIII).
        """
        z = self.within(roll_angle)
        return arctangent_defect(z), self.base_radius * np.hypot(1.0, z)


class InvoluteCam(CamKind):
    """Involute of a circle (Euler 1727, XIV): lever arm = base_radius · angle."""

    threads = ('vertical', 'lever', 'hanging')
    rank = 1
    starter = {'base_radius': 0.005}

    kind: Literal['involute'] = 'involute'
    base_radius: Positive = Field(description='radius of the base circle [m]')

    def made(self, setting: Setting) -> Involute:
        """Return the involute; it is the same for any wheel and power."""
        del setting
        return Involute(self.base_radius)

    def on_lever(self, lever: LeverSetting) -> LeverGeometry:
        """Return the lever machine with an involute."""
        return LeverGeometry(self.base_radius, lever.arm, lever.length)


KIND = InvoluteCam
