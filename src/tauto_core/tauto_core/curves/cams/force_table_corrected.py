"""The isochronous cam for a force that depends on the lift as a table says (D in cams.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from tauto_core.curves.cam import (
    CamKind,
    Setting,
    SmoothLever,
    hollow,
    rate_for_period,
    smooth_lever,
)
from tauto_core.curves.cams.corrected import CorrectedCam
from tauto_core.curves.force_law import ForceLaw
from tauto_core.curves.numerics import bisect, farther, nearest_if_any
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import SceneError
from tauto_core.scene.sections import Positive

_PROBES = 2000


@dataclass(frozen=True)
class ForceTableCorrected(CorrectedCam):
    """The isochronous cam for a force F(h) without mass.

    E(h) = ½F(0) b ϑ², with E = ∫ F dh: so the torque F t is exactly F(0) b ϑ = I ω²ϑ, and

        t = F(0) b ϑ/F,    t' = (F(0) b − F' t²)/F,    t'' = −(3F' t' + F'' t²) t/F.

    It is as isochronous as F(h) is the force. It ends where the table does, or where t reaches
    the hole.

    Attributes:
        rate: b = t'(0) = I ω²/F(0) [m/rad], > 0.
        law: F(h).
        distance: distance of the hole from the axle, a [m]; inf for a vertical thread.
    """

    rate: float
    law: ForceLaw
    distance: float = math.inf

    @property
    def corrected_for(self) -> ForceLaw:
        """The force for which it is isochronous."""
        return self.law

    @cached_property
    def lever(self) -> SmoothLever:
        """The law of the lever arm as plain numbers."""
        return smooth_lever(self.lever_arm, self.lift, self.range_rad, self.joints)

    @property
    def _stiffness(self) -> float:
        """I ω² = F(0) b [N m/rad]."""
        return self.law.at_rest * self.rate

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return ϑ = √(2E/F(0)b) [rad]."""
        found = np.sqrt(2.0 * self.law.energy(lift) / self._stiffness)
        return np.asarray(np.minimum(found, self.range_rad))

    @property
    def _edge(self) -> float:
        """Angle at which the table ends [rad]."""
        return math.sqrt(2.0 * float(self.law.energy(self.law.longest)) / self._stiffness)

    @cached_property
    def range_rad(self) -> float:
        """Angle at which the table ends, or t reaches the hole [rad]."""
        edge = self._edge
        if math.isinf(self.distance):
            return edge

        def within(angle: float) -> bool:
            return float(self._arm(np.array([angle]))[0]) <= self.distance

        angles = np.linspace(0.0, edge, _PROBES)
        beyond = np.flatnonzero(self._arm(angles) > self.distance)
        if not len(beyond):
            return edge
        return bisect(within, float(angles[beyond[0] - 1]), float(angles[beyond[0]]))[0]

    @cached_property
    def joints(self) -> FloatArray:
        """Angles at which F is joined [rad]."""
        found = np.sqrt(2.0 * self.law.energy(self.law.joints) / self._stiffness)
        return np.asarray(found[found < self.range_rad])

    def wider(self, amplitude: float, mass: float, period: float) -> str:
        """Return the change that widens the range to an amplitude, as the end of a sentence."""
        del mass, period
        if amplitude <= self._edge:
            return farther(float(self._arm(np.linspace(0.0, amplitude, _PROBES)).max()))
        needed = 0.5 * self._stiffness * amplitude * amplitude
        return (
            f', or give trochlea.power.points up to a lift at which the force has done '
            f'{needed:.6g} J (they end at {self.law.longest!r} m, after '
            f'{float(self.law.energy(self.law.longest)):.6g} J)'
        )

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

    def _risen(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the lift, F, and F − F(0) without cancellation near rest."""
        lift = self._lift(x)
        coefficients, first = self.law.splines.force.c, float(self.law.splines.force.x[1])
        near = lift * np.polynomial.polynomial.polyval(lift, coefficients[-2::-1, 0])
        force = self.law.force(lift)
        return lift, force, np.where(lift < first, near, force - self.law.at_rest)

    def _rate_gain(self, x: FloatArray) -> FloatArray:
        lift, force, risen = self._risen(x)
        arm = self._stiffness * x / force
        return np.asarray(-(self.rate * risen + self.law.slope(lift) * arm * arm) / force)

    def _arm_gain(self, x: FloatArray) -> FloatArray:
        _, force, risen = self._risen(x)
        return np.asarray(-self.rate * x * risen / force)


class ForceTableCorrectedCam(CamKind):
    """The isochronous cam for a force given by a table, made for one period (D in cams.md)."""

    threads = ('vertical', 'hole')
    corrects = 'force_table'
    rank = 10
    starter = {'period': 1.0}

    kind: Literal['force_table_corrected'] = 'force_table_corrected'
    period: Positive = Field(description='period of every swing on land [s]')

    def made(self, setting: Setting) -> ForceTableCorrected:
        """Return the cam for the wheel and its force; SceneError: a cheek that is hollow."""
        law = setting.pull.law
        assert law is not None  # `corrects` has made sure

        def cam(period: float) -> ForceTableCorrected:
            return ForceTableCorrected(rate_for_period(setting, period), law, setting.distance)

        made = cam(self.period)
        stretch = hollow(made)
        if stretch is None:
            return made
        slowest = nearest_if_any(self.period, 2.0, lambda period: hollow(cam(period)) is None)
        longer = '' if slowest is None else f'Use a period of at least {slowest:.4g} s, or points'
        raise SceneError(
            'trochlea',
            'trochlea.cam.period',
            self.period,
            f'the cheek of {self.kind} would be hollow from {stretch[0]:.6g} to '
            f'{stretch[1]:.6g} rad, since the force rises so fast with the lift, and a thread '
            'bridges a hollow',
            f'{longer or "Give points"} of a force that rises less there.',
        )


KIND = ForceTableCorrectedCam
