"""Euler's two cams, with a lever arm proportional to the angle.

The involute of a circle is for a vertical thread (1727, VII–XIV), the second curve for a thread
through a fixed hole (1727, XXII–XXIX).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from tauto_core.curves.cam import Cam, CamKind, LinearLever, Setting
from tauto_core.curves.lever_geometry import ArcLeverGeometry, LeverGeometry, LeverSetting
from tauto_core.samples import FloatArray
from tauto_core.scene.sections import Positive


class LinearCam(Cam):
    """A cam with t = b·ϑ, h = b·ϑ²/2, isochronous under a constant pull."""

    suits = 0.0, 0.0

    @property
    @abstractmethod
    def linear_rate(self) -> float:
        """Lever rate b [m/rad]."""

    @property
    def lever(self) -> LinearLever:
        """The law of the lever arm as plain numbers."""
        return LinearLever(self.linear_rate)

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return ϑ = √(2h/b) [rad], for 0 ≤ h ≤ h(range)."""
        angle = np.sqrt(2.0 * np.asarray(lift, dtype=np.float64) / self.linear_rate)
        return self.within(angle)

    def _arm(self, x: FloatArray) -> FloatArray:
        return self.linear_rate * x

    def _rate(self, x: FloatArray) -> FloatArray:
        return np.full_like(x, self.linear_rate)

    def _bend(self, x: FloatArray) -> FloatArray:
        return np.zeros_like(x)

    def _lift(self, x: FloatArray) -> FloatArray:
        return 0.5 * self.linear_rate * x * x


@dataclass(frozen=True)
class Involute(LinearCam):
    """Involute of a circle, for a vertical thread: t = r·ϑ (§VII–XIV), of any range.

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


@dataclass(frozen=True)
class Hole(LinearCam):
    """Euler's cam for a thread through a fixed hole: t = b·ϑ for |t| ≤ a (§XXII–XXIX).

    At the edge of its range, a/b, the contact point reaches the hole.

    Attributes:
        rate: lever arm per angle b [m/rad], > 0.
        distance: distance of the hole from the axle, a [m], > 0.
    """

    rate: float
    distance: float
    widening = ', or move the hole away from the axle'

    @property
    def linear_rate(self) -> float:
        """Lever rate b [m/rad]."""
        return self.rate

    @property
    def range_rad(self) -> float:
        """a/b [rad]."""
        return self.distance / self.rate


class InvoluteCam(CamKind):
    """Involute of a circle (Euler 1727, XIV): lever arm = base_radius · angle."""

    threads = ('vertical', 'lever', 'hanging')
    rank = 1
    starter = {'base_radius': 0.005}

    kind: Literal['involute'] = 'involute'
    base_radius: Positive = Field(description='radius of the base circle [m]')

    def made(self, setting: Setting) -> Involute:
        """Return the involute, the same for any wheel and power."""
        return Involute(self.base_radius)

    def on_lever(self, lever: LeverSetting) -> LeverGeometry:
        """Return the lever machine with an involute."""
        geometry = ArcLeverGeometry if lever.on_arc else LeverGeometry
        return geometry(self.base_radius, lever.arm, lever.length, lever.inclination)


class HoleCam(CamKind):
    """Euler's second curve (1727, XXII–XXIX), for a thread through a fixed hole.

    Its lever arm is lever_rate · angle.
    """

    threads = ('hole',)
    rank = 2
    starter = {'lever_rate': 0.005}

    kind: Literal['hole'] = 'hole'
    lever_rate: Positive = Field(description='lever arm per angle of the wheel [m/rad]')

    def made(self, setting: Setting) -> Hole:
        """Return the curve for the hole, the same for any wheel and power."""
        return Hole(self.lever_rate, setting.distance)


KINDS = InvoluteCam, HoleCam
