"""Isochronous cams for powers with inertia or stiffness, for which Euler's two are not (theory D).

The well is exactly harmonic in the arc s = ∫ √(I + m t²) dϑ when V = ½ ω² s². With a weight of
mass m, V = m g h, and in the plane (√(I/m) ϑ, h) the machine moves like a bead on a wire, which
must be Huygens' cycloid. With a massless spring, V = P h + κh²/2 = ½ k ϑ², k = I ω².

Both take a vertical thread or one through a hole. Only with a hole is the weight's motion
strictly along the thread; a vertical thread is the limit of a long one (theory A).
"""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from tauto_core.curves.cam import Cam
from tauto_core.curves.series import involute_defect
from tauto_core.samples import FloatArray


class CorrectedCam(Cam):
    """A cam whose lever arm departs from t'(0)·ϑ so that one power train is isochronous."""

    @property
    def knows_angle_of_lift(self) -> bool:
        """True: the lift determines the angle in closed form."""
        return True

    @abstractmethod
    def _arm_gain(self, angle: FloatArray) -> FloatArray:
        """Return t(ϑ) − t'(0)·ϑ [m], without cancellation."""

    def _hanging_contact(self, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
        rate = float(self.lever_rate(0.0))
        sine, cosine = np.sin(angle), np.cos(angle)
        arm, gain = self._arm_gain(angle), self._rate_gain(angle)
        x = -rate * involute_defect(angle) + (arm * cosine - gain * sine)
        return x, rate * (cosine + angle * sine) + (arm * sine + gain * cosine)
