"""The isochronous cam for a spring without mass (theory D)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from tauto_core.curves.cam import CorrectedCam, SpringLever, hollow
from tauto_core.curves.kind import CamKind, Setting, rate_for_period
from tauto_core.curves.numerics import farther, nearest
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import SceneError
from tauto_core.scene.fields import Positive


@dataclass(frozen=True)
class SpringCorrected(CorrectedCam):
    """The isochronous cam for a spring of any stiffness without mass (theory D).

    With b = I ω²/P and c² = bκ/P: t = bϑ/√(1 + c²ϑ²), h = bϑ²/(1 + √(1 + c²ϑ²)), which becomes the
    involute as κ → 0. The torque is exactly −I ω²ϑ. Through a hole at distance a the range is
    a/√(b² − a²c²), unlimited where a c ≥ b. The cheek may be hollow at its tip (`curvature`).

    Attributes:
        rate: b = t'(0) [m/rad], > 0.
        stiffness_ratio: κ/P [1/m], ≥ 0.
        distance: distance of the hole from the axle, a [m]; inf for a vertical thread.
    """

    rate: float
    stiffness_ratio: float
    distance: float = math.inf

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
        """Angle at which t reaches the hole [rad]; inf if it never does."""
        reached = self.distance * math.sqrt(self.bend)
        if math.isinf(self.distance) or reached >= self.rate:
            return math.inf
        return self.distance / math.sqrt((self.rate - reached) * (self.rate + reached))

    @property
    def hole_distance(self) -> float:
        """Distance a of the hole [m]; inf for a vertical thread."""
        return self.distance

    def lever_arm(self, angle: ArrayLike) -> FloatArray:
        """Return t = bϑ/√(1 + c²ϑ²) [m]."""
        angle = self.within(angle)
        return self.rate * angle / np.sqrt(self._square(angle))

    def lever_rate(self, angle: ArrayLike) -> FloatArray:
        """Return t' = b (1 + c²ϑ²)^(−3/2) [m/rad]."""
        square = self._square(self.within(angle))
        rate: FloatArray = self.rate / (square * np.sqrt(square))
        return rate

    def lever_curvature(self, angle: ArrayLike) -> FloatArray:
        """Return t'' = −3bc²ϑ (1 + c²ϑ²)^(−5/2) [m/rad²]."""
        angle = self.within(angle)
        square = self._square(angle)
        bent: FloatArray = (
            -3.0 * self.rate * self.bend * angle / (square * square * np.sqrt(square))
        )
        return bent

    def lift(self, angle: ArrayLike) -> FloatArray:
        """Return h = (√(P² + κkϑ²) − P)/κ = bϑ²/(1 + √(1 + c²ϑ²)) [m]."""
        angle = self.within(angle)
        return self.rate * angle * angle / (1.0 + np.sqrt(self._square(angle)))

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return ϑ = √(h (2 + hκ/P)/b) [rad], for 0 ≤ h ≤ h(range)."""
        lift = np.asarray(lift, dtype=np.float64)
        return self.within(np.sqrt(lift * (2.0 + self.stiffness_ratio * lift) / self.rate))

    def _square(self, angle: FloatArray) -> FloatArray:
        square: FloatArray = 1.0 + self.bend * angle * angle
        return square

    def _rate_gain(self, angle: FloatArray) -> FloatArray:
        return self.rate * np.expm1(-1.5 * np.log1p(self.bend * angle * angle))

    def _arm_gain(self, angle: FloatArray) -> FloatArray:
        return self.rate * angle * np.expm1(-0.5 * np.log1p(self.bend * angle * angle))

    def wider(self, amplitude: float, mass: float, period: float) -> str:
        """Return what change would widen the range to an amplitude, as the end of a sentence."""
        del mass, period
        return farther(float(replace(self, distance=math.inf).lever_arm(amplitude)))


class SpringCorrectedCam(CamKind):
    """The isochronous cam for a spring with stiffness, made for one period (theory D)."""

    threads = ('vertical', 'hole')
    corrects = 'spring'
    rank = 6
    starter = {'period': 1.0}

    kind: Literal['spring_corrected'] = 'spring_corrected'
    period: Positive = Field(description='period of every swing on land [s]')

    def made(self, setting: Setting) -> SpringCorrected:
        """Return the cam for the wheel and its spring.

        Raises:
            SceneError: a cheek that would be hollow.
        """
        pull, distance = setting.pull, setting.distance

        def cam(period: float, stiffness: float) -> SpringCorrected:
            rate = rate_for_period(setting, period)
            return SpringCorrected(rate, stiffness / pull.force, distance)

        made = cam(self.period, pull.stiffness)
        stretch = hollow(made)
        if stretch is None:
            return made
        softest = nearest(
            pull.stiffness, 0.5, lambda value: hollow(cam(self.period, value)) is None
        )
        slowest = nearest(
            self.period, 2.0, lambda value: hollow(cam(value, pull.stiffness)) is None
        )
        nearer = '' if math.isinf(distance) else ', or bring the hole nearer'
        raise SceneError(
            'trochlea',
            'trochlea.power.stiffness',
            pull.stiffness,
            f'the cheek of spring_corrected would be hollow from {stretch[0]:.6g} to '
            f'{stretch[1]:.6g} rad, and a thread bridges a hollow',
            f'Use a stiffness of at most {softest:.4g} N/m, or a period of at least {slowest:.4g} '
            f's{nearer}.',
        )


KIND = SpringCorrectedCam
