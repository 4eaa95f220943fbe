"""Euler's second curve, for a thread through a fixed hole (1727, XXII–XXIX)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from tauto_core.curves.cam import LinearCam, arm_rounding
from tauto_core.curves.kind import CamKind, Setting
from tauto_core.curves.numerics import farther
from tauto_core.samples import FloatArray
from tauto_core.scene.fields import Positive


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
        rate = np.full_like(arm, self.rate)
        return self.rate * self._thread_at(arm, rate, arm_rounding(0.0, arm, rate)).share

    def wider(self, amplitude: float, mass: float, period: float) -> str:
        """Return what change would widen the range to an amplitude, as the end of a sentence."""
        del mass, period
        return farther(float(replace(self, distance=math.inf).lever_arm(amplitude)))


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
        """Return the curve for the hole; it is the same for any wheel and power."""
        return Hole(self.lever_rate, setting.distance)


KIND = HoleCam
