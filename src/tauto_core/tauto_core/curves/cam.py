"""The cam: a lever arm as a function of the angle, and the curve that gives it.

Euler, *De novo quodam curvarum tautochronarum genere* (1727). The lever arm t(ϑ) is the distance
of the thread's line from the axle, so the family of these lines in the wheel's frame has t as
its support function and the cheek is their envelope. With ψ the direction of a line's normal:
p = dt/dψ, contact point t (cos ψ, sin ψ) + p (−sin ψ, cos ψ), radius of curvature R = t + dp/dψ.
A thread that hangs vertically has ψ = ϑ (§VII–XIV); through a hole at distance a from the axle
ψ = ϑ + arcsin(t/a) (§XXII–XXIX).

The frame turns with the wheel; +y points along the thread at rest, towards weight or hole.
Angles are radians, lengths metres. Every function takes numbers or arrays of any shape.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.levers import Lever
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import CamRangeError

_ROUNDING = 16.0 * np.finfo(np.float64).eps
"""Relative rounding of an angle at the edge of a range, and of a lever arm there."""


class _Thread(NamedTuple):
    """The thread's line: sine and cosine of its angle at the hole, and the rate t'/a."""

    sine: FloatArray
    cosine: FloatArray
    rate: FloatArray

    @property
    def share(self) -> FloatArray:
        """dϑ/dψ = 1/(1 + t'/s), s the distance from the hole to the foot of t."""
        return self.cosine / (self.cosine + self.rate)


def arm_rounding(angle: ArrayLike, arm: ArrayLike, rate: ArrayLike) -> FloatArray:
    """Return by how much rounding of the angle and of the law may change a lever arm [m].

    Args:
        angle: ϑ [rad].
        arm: t [m].
        rate: dt/dϑ [m/rad].
    """
    size = np.abs(arm) + np.abs(np.asarray(rate) * np.asarray(angle))
    return np.asarray(_ROUNDING * size)


class Cam(ABC):
    """A pair of mirror-image cheeks: t and ψ are odd in ϑ, lift, p, arc and R are even.

    All methods of an angle raise CamRangeError beyond `range_rad`, and at NaN.
    """

    @property
    @abstractmethod
    def lever(self) -> Lever:
        """The law of the lever arm as plain numbers."""

    @property
    @abstractmethod
    def range_rad(self) -> float:
        """Largest |ϑ| at which the thread lies on the cheek [rad]; inf if there is no limit."""

    @property
    def drawn_rad(self) -> float:
        """Angle up to which the cheek is drawn and checked by default [rad]: at most a turn."""
        return min(self.range_rad, math.tau)

    @property
    def linear_rate(self) -> float | None:
        """dt/dϑ [m/rad] where the lever arm is exactly linear, else None."""
        return None

    @property
    def suits(self) -> tuple[float, float] | None:
        """(m/I [1/m²], κ/P [1/m]) of the power for which the cam is isochronous."""
        return None

    @property
    def kinked(self) -> bool:
        """Whether t has a |ϑ|ϑ term at ϑ = 0, so that t'' jumps there."""
        return False

    @property
    def joints(self) -> FloatArray:
        """Angles between 0 and the range where t is not analytic [rad], increasing."""
        return np.empty(0)

    @property
    def hole_distance(self) -> float:
        """Distance a of the hole from the axle [m]; inf where the thread hangs vertically."""
        return math.inf

    @property
    def knows_angle_of_lift(self) -> bool:
        """Whether `angle_of_lift` is a closed form, good to rounding at any lift."""
        return False

    def wider(self, amplitude: float, mass: float, period: float) -> str:
        """Return what change would widen the range to an amplitude, as the end of a sentence.

        Args:
            amplitude: the angle that the cam should allow [rad], > 0.
            mass: the mass whose inertia rides on the thread [kg].
            period: period of small swings [s].
        """
        del amplitude, mass, period
        return ' or give the cam a wider range'

    @abstractmethod
    def lever_arm(self, angle: ArrayLike) -> FloatArray:
        """Return t(ϑ) [m]."""

    @abstractmethod
    def lever_rate(self, angle: ArrayLike) -> FloatArray:
        """Return dt/dϑ [m/rad]."""

    @abstractmethod
    def lever_curvature(self, angle: ArrayLike) -> FloatArray:
        """Return d²t/dϑ² [m/rad²]; for a kinked cam at ±0, the limit from that side."""

    @abstractmethod
    def lift(self, angle: ArrayLike) -> FloatArray:
        """Return h = ∫ t dϑ from 0 [m]: the rise of the weight, or the extension of the spring."""

    @abstractmethod
    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return the ϑ ≥ 0 at which the lift is h ≥ 0 [m]; within the range."""

    @abstractmethod
    def _rate_gain(self, angle: FloatArray) -> FloatArray:
        """Return t'(ϑ) − t'(0) [m/rad], without cancellation."""

    @abstractmethod
    def _hanging_contact(self, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (t cos ϑ − t' sin ϑ, t sin ϑ + t' cos ϑ): the contact of a vertical thread."""

    def psi(self, angle: ArrayLike) -> FloatArray:
        """Return ψ, the direction of the normal of the thread's line [rad], 0 at rest."""
        angle = self.within(angle)
        thread = self._thread(angle)
        return angle + np.arctan2(thread.sine, thread.cosine)

    def p(self, angle: ArrayLike) -> FloatArray:
        """Return p = dt/dψ = t'/(1 + t'/√(a² − t²)) [m] (§XXIX)."""
        angle = self.within(angle)
        return self.lever_rate(angle) * self._thread(angle).share

    def contact(self, angle: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the point at which the thread leaves the cheek, (x, y) in the wheel's frame [m].

        Positive angles use the cheek at x < 0.
        """
        angle = self.within(angle)
        thread = self._thread(angle)
        # With s the sine at the hole: c·q·(hanging contact) + t·s·(−sin ϑ, cos ϑ), which has no
        # cancellation at small angles.
        scale = thread.cosine * thread.share
        along = self.lever_arm(angle) * thread.sine
        x, y = self._hanging_contact(angle)
        return scale * x - along * np.sin(angle), scale * y + along * np.cos(angle)

    def arc_length(self, angle: ArrayLike) -> FloatArray:
        """Return the length of thread wound on the cheek, ∫ R dψ from 0 [m]; ≥ 0 where R is."""
        angle = np.abs(self.within(angle))
        thread = self._thread(angle)
        sine, cosine, rate = thread
        gain = self._rate_gain(angle)
        tip = self.lever_rate(0.0) / self.hole_distance
        # h + (a − s) + (p − p(0)) with the differences resolved: ∫ t dψ = h + a − s.
        shift = self.lever_arm(angle) * sine * (cosine + tip + tip * cosine)
        shift = shift / ((1.0 + cosine) * (1.0 + tip) * (cosine + tip))
        gained = gain * cosine * cosine / ((cosine + rate) * (cosine + tip))
        return self.lift(angle) + shift + gained

    def radius_of_curvature(self, angle: ArrayLike) -> FloatArray:
        """Return R = sgn ϑ·(t + dp/dψ) [m].

        R = |t| (1 − w³) + (1 − w)³ |t|'', w = t'/(t' + √(a² − t²)). Where the curve is hollow R is
        negative; a thread would bridge the hollow.
        """
        angle = np.abs(self.within(angle))
        share = self._thread(angle).share
        w = 1.0 - share
        bend = self.lever_curvature(angle) * (share * share * share)
        return self.lever_arm(angle) * share * (1.0 + w + w * w) + bend

    def free_thread(self, angle: ArrayLike) -> FloatArray:
        """Return the length of thread between cheek and hole [m]; inf without a hole."""
        thread = self._thread(self.within(angle))
        return self.hole_distance * thread.cosine * thread.share

    def within(self, angle: ArrayLike) -> FloatArray:
        """Return the angle as an array; raise CamRangeError if any is beyond the range."""
        angle = np.asarray(angle, dtype=np.float64)
        bad = ~(np.abs(angle) <= min(self.range_rad, np.finfo(np.float64).max))
        if np.any(bad):
            worst = float(np.atleast_1d(angle)[np.atleast_1d(bad)][0])
            raise CamRangeError(
                f'angle {worst!r} rad is beyond the cam {self!r}, whose range is '
                f'±{self.range_rad!r} rad: use a smaller amplitude or a cam with a wider range'
            )
        return angle

    def _thread(self, angle: FloatArray) -> _Thread:
        arm, rate = self.lever_arm(angle), self.lever_rate(angle)
        return self._thread_at(arm, rate, arm_rounding(angle, arm, rate))

    def _thread_at(self, arm: FloatArray, rate: FloatArray, rounding: FloatArray) -> _Thread:
        """Return the thread's line at a lever arm.

        Args:
            arm: t [m].
            rate: dt/dϑ [m/rad].
            rounding: by how much t may exceed the distance of the hole, since it is rounded [m].

        Raises:
            CamRangeError: a lever arm that is longer.
        """
        a = self.hole_distance
        if math.isinf(a):
            return _Thread(np.zeros_like(arm), np.ones_like(arm), np.zeros_like(arm))
        beyond = ~(np.abs(arm) <= a + rounding)
        if np.any(beyond):
            longest = float(np.atleast_1d(np.abs(arm))[np.atleast_1d(beyond)][0])
            raise CamRangeError(
                f'a lever arm of {longest!r} m is longer than the hole is away, {a!r} m, on the '
                f'cam {self!r}: use a smaller amplitude or move the hole away'
            )
        arm = np.clip(arm, -a, a)
        return _Thread(arm / a, np.sqrt((a - arm) * (a + arm)) / a, rate / a)
