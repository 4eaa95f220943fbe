"""Cams with a linear lever arm: Euler's two."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.cam import Cam
from tauto_core.curves.levers import LinearLever
from tauto_core.curves.series import involute_defect
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
