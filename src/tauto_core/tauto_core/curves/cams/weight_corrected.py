"""The isochronous cam for a weight with inertia (theory D)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from tauto_core.curves.cam import CorrectedCam, SmoothLever, smooth_lever
from tauto_core.curves.kind import CamKind, Setting, rate_for_period
from tauto_core.curves.numerics import (
    arctangent_defect,
    bracketed_newton,
    farther,
    nearest,
    sine_defect,
)
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import CamRangeError
from tauto_core.scene.fields import Positive

STEEPEST = 1000.0
"""tan χ at the edge of a weight's cam on a vertical thread, where t grows without bound."""

_ROUNDING = 4.0 * np.finfo(np.float64).eps


@dataclass(frozen=True)
class WeightCorrected(CorrectedCam):
    """The isochronous cam for a weight that has inertia (theory D).

    With λ = √(I/m), L = λ²/r = g/ω² and the slope χ of the cycloid:
    ϑ = (L/2λ)(χ + sin χ cos χ), h = (L/2) sin²χ, t = λ tan χ, t' = r sec⁴χ, t'' = 4(λ³/L²) tan χ
    sec⁶χ. The arc is L√m sin χ. On a vertical thread the range is πλ/(4r), less 4e-10 of it; there
    the lever arm is 1000 λ and grows without bound. Through a hole at distance a, tan χ ≤ a/λ.

    Attributes:
        rate: r = t'(0) = I ω²/(m g) [m/rad], > 0.
        mass_ratio: m/I [1/m²], > 0.
        distance: distance of the hole from the axle, a [m]; inf for a vertical thread.
    """

    rate: float
    mass_ratio: float
    distance: float = math.inf

    @cached_property
    def lever(self) -> SmoothLever:
        """The law of the lever arm as plain numbers."""
        return smooth_lever(self.lever_arm, self.lift, self.range_rad)

    @property
    def suits(self) -> tuple[float, float]:
        """(m/I, 0): a weight of this inertia, in any gravity."""
        return self.mass_ratio, 0.0

    @property
    def range_rad(self) -> float:
        """Angle where t reaches the hole; on a vertical thread πλ/(4r), less 4e-10 of it [rad]."""
        return float(self.angle_of_slope(min(self.distance / self.gyration, STEEPEST)))

    @property
    def drawn_rad(self) -> float:
        """At most a turn, on a vertical thread up to t = λ [rad]; beyond, it is too wide."""
        steepest = STEEPEST if math.isfinite(self.distance) else 1.0
        return min(self.range_rad, math.tau, float(self.angle_of_slope(steepest)))

    @property
    def hole_distance(self) -> float:
        """Distance a of the hole [m]; inf for a vertical thread."""
        return self.distance

    @property
    def gyration(self) -> float:
        """λ = √(I/m) [m]."""
        return 1.0 / math.sqrt(self.mass_ratio)

    @property
    def length(self) -> float:
        """L = λ²/r = g/ω² [m]: of the isochronous simple pendulum."""
        return 1.0 / (self.mass_ratio * self.rate)

    def angle_of_slope(self, slope: ArrayLike) -> FloatArray:
        """Return ϑ ≥ 0 [rad] where tan χ = t/λ has the value ≥ 0."""
        slope = np.asarray(slope, dtype=np.float64)
        halved = np.arctan(slope) + slope / (1.0 + slope * slope)
        angle: FloatArray = 0.5 * self.gyration / self.rate * halved
        return angle

    def slope(self, angle: ArrayLike) -> FloatArray:
        """Return tan χ = t/λ, odd in ϑ; Kepler's equation χ + sin χ cos χ = 2rϑ/λ."""
        angle = self.within(angle)
        per_rad = 2.0 * self.rate / self.gyration
        mean = np.atleast_1d(per_rad * np.abs(angle))
        found = np.empty_like(mean)
        near = mean < 1.2
        if near.any():
            found[near] = np.tan(_rising(mean[near]))
        if not near.all():
            # near the edge the angle is counted from there
            edge = 0.25 * math.pi * self.gyration / self.rate
            left = per_rad * (edge - np.abs(np.atleast_1d(angle)[~near]))
            found[~near] = 1.0 / np.tan(_falling(left))
        return np.copysign(found.reshape(angle.shape), angle)

    def lever_arm(self, angle: ArrayLike) -> FloatArray:
        """Return t = λ tan χ [m]."""
        return self.gyration * self.slope(angle)

    def lever_rate(self, angle: ArrayLike) -> FloatArray:
        """Return t' = r sec⁴χ [m/rad]."""
        slope = self.slope(angle)
        secant = 1.0 + slope * slope
        rate: FloatArray = self.rate * (secant * secant)
        return rate

    def lever_curvature(self, angle: ArrayLike) -> FloatArray:
        """Return t'' = 4(λ³/L²) tan χ sec⁶χ [m/rad²]."""
        slope = self.slope(angle)
        factor = 4.0 * self.rate**2 / self.gyration
        secant = 1.0 + slope * slope
        curvature: FloatArray = factor * slope * (secant * secant * secant)
        return curvature

    def lift(self, angle: ArrayLike) -> FloatArray:
        """Return h = (L/2) sin²χ [m]."""
        slope = self.slope(angle)
        square = slope * slope
        lift: FloatArray = 0.5 * self.length * (square / (1.0 + square))
        return lift

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return the ϑ ≥ 0 of a lift [rad], for 0 ≤ h ≤ h(range)."""
        lift = np.asarray(lift, dtype=np.float64)
        edge = self.range_rad
        highest = float(self.lift(edge))
        if not np.all((lift >= 0.0) & (lift <= highest * (1.0 + _ROUNDING))):
            raise CamRangeError(
                f'lifts from {float(np.min(lift))!r} to {float(np.max(lift))!r} m: the cam '
                f'{self!r} lifts by 0 to {highest!r} m and no more; use a smaller amplitude or a '
                'cam with a wider range'
            )
        square = 2.0 * np.minimum(lift, highest) / self.length
        return np.minimum(self.angle_of_slope(np.sqrt(square / (1.0 - square))), edge)

    def _rate_gain(self, angle: FloatArray) -> FloatArray:
        slope = self.slope(angle)
        square = slope * slope
        gain: FloatArray = self.rate * square * (2.0 + square)
        return gain

    def _arm_gain(self, angle: FloatArray) -> FloatArray:
        slope = self.slope(angle)
        square = slope * slope
        bent = arctangent_defect(slope) + slope * (square / (1.0 + square))
        gain: FloatArray = 0.5 * self.gyration * bent
        return gain

    def wider(self, amplitude: float, mass: float, period: float) -> str:
        """Return what change would widen the range to an amplitude, as the end of a sentence.

        A heavier weight or a longer period needs shorter lever arms.
        """

        def heavier(tried: float) -> bool:
            share = tried / mass
            wider = replace(self, rate=self.rate / share, mass_ratio=self.mass_ratio * share)
            return wider.range_rad >= amplitude

        def slower(tried: float) -> bool:
            share = tried / period
            return replace(self, rate=self.rate / (share * share)).range_rad >= amplitude

        heaviest, slowest = nearest(mass, 2.0, heavier), nearest(period, 2.0, slower)
        hanging = replace(self, distance=math.inf)
        reachable = hanging.range_rad >= amplitude
        away = farther(float(hanging.lever_arm(amplitude))) if reachable else ''
        return (
            f', or use a weight of at least {heaviest:.4g} kg (this one is too light for the '
            f'period, or the wheel too heavy), or a period of at least {slowest:.4g} s{away}'
        )


class WeightCorrectedCam(CamKind):
    """The isochronous cam for a weight that has inertia, made for one period (theory D)."""

    threads = ('vertical', 'hole')
    corrects = 'weight'
    rank = 5
    starter = {'period': 1.0}

    kind: Literal['weight_corrected'] = 'weight_corrected'
    period: Positive = Field(description='period of every swing on land [s]')

    def made(self, setting: Setting) -> WeightCorrected:
        """Return the cam for the wheel and its weight."""
        rate = rate_for_period(setting, self.period)
        return WeightCorrected(rate, setting.pull.carried_mass / setting.inertia, setting.distance)


KIND = WeightCorrectedCam


def _rising(mean: FloatArray) -> FloatArray:
    """Return the χ with χ + sin χ cos χ = mean, 0 ≤ mean ≤ 1.2, by Newton's method."""

    def excess(chi: FloatArray) -> tuple[FloatArray, FloatArray]:
        cosine = np.cos(chi)
        return chi + np.sin(chi) * cosine - mean, 2.0 * cosine * cosine

    start = 0.5 * mean * (1.0 + mean * mean / 12.0)
    return bracketed_newton(excess, start, (0.5 * mean, mean), relative=_ROUNDING, absolute=1e-17)


def _falling(left: FloatArray) -> FloatArray:
    """Return the w with w − sin w cos w = left, 0 < left ≤ 0.4, by Newton's method."""

    def excess(w: FloatArray) -> tuple[FloatArray, FloatArray]:
        sine = np.sin(w)
        return 0.5 * sine_defect(2.0 * w) - left, 2.0 * sine * sine

    w = np.cbrt(1.5 * left)
    start = w * (1.0 + w * w / 15.0)
    return bracketed_newton(excess, start, (0.5 * w, 2.0 * w), relative=_ROUNDING)
