"""The isochronous cam for any power train, by quadrature (docs/theory/cams.md).

A power train has the potential V(y) and the inertia M(y) in its own coordinate y: the lift of a
weight, the draw of a spring or the angle of a lever. The wheel's moment of inertia is I. Every
swing takes 2π/ω if V = ½ω²s² in the arc ds² = I dϑ² + M dy². With F = dV/dy

    dy/ds = ω²s/F,    I (dϑ/ds)² = 1 − M (ω²s/F)²,    dy/dϑ = √I ω²s/√(F² − M ω⁴s²),

and ϑ(s) is one quadrature. The range ends at F² = M ω⁴s², the speed of the train by itself. Each
side is isochronous by itself, which determines it uniquely (Abel).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from pydantic import Field

from tauto_core.curves.cam import (
    FitError,
    PeriodCam,
    Setting,
    rate_for_period,
    smooth_lever,
)
from tauto_core.curves.cams.table import Fitted
from tauto_core.curves.numerics import ArrayFunction, bisect, bracketed_newton, integrate
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import SceneError, TautoError
from tauto_core.scene.sections import Positive


class SynthesisError(TautoError):
    """A power train without such a cam."""


@dataclass(frozen=True)
class PowerTrain:
    """The power train as a function of its coordinate y ≥ 0.

    Attributes:
        pull: F(y) = dV/dy > 0 [N, or N m for an angle y].
        place: y(V), the inverse of the potential, y(0) = 0.
        mass: M(y) ≥ 0 [kg, or kg m2].
        largest: largest potential of the train [J], or inf.
    """

    pull: ArrayFunction
    place: ArrayFunction
    mass: ArrayFunction
    largest: float = math.inf


@dataclass(frozen=True)
class Synthesis:
    """The motion that an isochronous cam must produce: y and ϑ as functions of the arc.

    Attributes:
        inertia: I of the wheel [kg m2].
        frequency: ω [rad/s].
        train: the power train.
        arc_range: largest s [√kg m].
    """

    inertia: float
    frequency: float
    train: PowerTrain
    arc_range: float

    def place(self, arc: FloatArray) -> FloatArray:
        """Return y at the arc s ≥ 0: V = ½ω²s²."""
        return self.train.place(0.5 * (self.frequency * arc) ** 2)

    def angle(self, arc: FloatArray) -> FloatArray:
        """Return ϑ = ∫ √(1 − M (ω²s/F)²) ds/√I at the arc s ≥ 0, shape (n,)."""
        top, root = self.arc_range, math.sqrt(self.inertia)
        if math.isinf(top):
            return integrate(self._share, np.zeros_like(arc), arc) / root

        # s = S sin v makes the integrand smooth at the end of the range, a zero of the root
        def rate(v: FloatArray) -> FloatArray:
            return self._share(top * np.sin(v)) * (top * np.cos(v))

        until = np.arcsin(np.minimum(arc / top, 1.0))
        return np.asarray(integrate(rate, np.zeros_like(until), until) / root)

    def ratio(self, arc: FloatArray) -> FloatArray:
        """Return dy/dϑ at the arc s ≥ 0, which is the lever arm t if y is a lift."""
        pull = self.train.pull(self.place(arc))
        share = self._share(arc)
        drawn: FloatArray = math.sqrt(self.inertia) * self.frequency**2 * arc
        return drawn / (pull * share)

    @property
    def angle_range(self) -> float:
        """Largest ϑ [rad]."""
        if math.isinf(self.arc_range):
            return math.inf
        return float(self.angle(np.array([self.arc_range]))[0])

    def arc(self, angle: FloatArray) -> FloatArray:
        """Return the arc s of an angle ϑ ≥ 0 within the range, shape (n,).

        Newton's method with dϑ/ds.
        """
        root = math.sqrt(self.inertia)

        def excess(arc: FloatArray) -> tuple[FloatArray, FloatArray]:
            return self.angle(arc) - angle, self._share(arc) / root

        low = root * angle
        high = np.full_like(angle, self.arc_range)
        if math.isinf(self.arc_range):
            high = low
            while np.any(short := self.angle(high) < angle):
                high = np.where(short, 2.0 * high, high)
        return bracketed_newton(excess, low, (low, high), relative=2e-16)

    def _share(self, arc: FloatArray) -> FloatArray:
        """Return √I dϑ/ds = √(1 − M (ω²s/F)²)."""
        rate = _speed(self.train, self.frequency, arc)
        return np.asarray(np.sqrt(np.maximum((1.0 - rate) * (1.0 + rate), 0.0)))


def synthesise(inertia: float, frequency: float, train: PowerTrain) -> Synthesis:
    """Return the motion of the cam that makes a wheel of inertia I and a power train isochronous.

    SynthesisError: a train that by itself cannot swing at ω = 2π/period [rad/s].
    """
    largest = math.inf
    if math.isfinite(train.largest):
        largest = math.sqrt(2.0 * train.largest) / frequency
    # the least arc at which the train has all of the speed
    arcs = min(largest, 1e6) * np.logspace(-12.0, 0.0, 400)
    too_fast = np.flatnonzero(~(_speed(train, frequency, arcs) < 1.0))
    edge = largest
    if len(too_fast) and too_fast[0] > 0:
        low, high = float(arcs[too_fast[0] - 1]), float(arcs[too_fast[0]])
        edge, _ = bisect(
            lambda arc: bool(_speed(train, frequency, np.array([arc]))[0] < 1.0), low, high
        )
    if (len(too_fast) and too_fast[0] == 0) or not edge > 0.0:
        raise SynthesisError(
            f'no cam makes this power train swing at {frequency!r} rad/s: it is slower by itself '
            'at any amplitude. Use less inertia, a stronger pull or a longer period'
        )
    return Synthesis(inertia, frequency, train, edge)


def synthesised_cam(
    synthesis: Synthesis, distance: float = math.inf, edge: float | None = None
) -> Fitted:
    """Return the cam of a power train with the length of thread drawn as coordinate: t = dy/dϑ.

    The distance of the hole is inf for a vertical thread. The range `edge` [rad] is by default the
    largest possible. SynthesisError, with a range that works: an impossible range. FitError: a
    train that is not smooth.
    """
    limit = synthesis.angle_range
    reach = limit if edge is None else edge
    if not 0.0 < reach <= limit or math.isinf(reach):
        raise SynthesisError(
            f'a range of {reach!r} rad: must be > 0, finite and at most {limit!r} rad, at '
            'which the power train takes all of the speed. Give a smaller one'
        )

    def arm(angle: FloatArray) -> FloatArray:
        return synthesis.ratio(synthesis.arc(angle))

    def lift(angle: FloatArray) -> FloatArray:
        return synthesis.place(synthesis.arc(angle))

    return Fitted('synthesis', smooth_lever(arm, lift, reach), distance)


def _speed(train: PowerTrain, frequency: float, arc: FloatArray) -> FloatArray:
    """Return √M ω²s/F, the share of the train in the speed along the arc."""
    place = train.place(0.5 * (frequency * arc) ** 2)
    return np.asarray(np.sqrt(train.mass(place)) * (frequency**2 * arc) / train.pull(place))


class SynthesisedCam(PeriodCam):
    """The isochronous cam for any power, made for one period and a range of angles (D in cams.md).

    For a weight alone it equals weight_corrected, for a spring alone spring_corrected.
    """

    if_hollow = 'use a smaller range, a longer period or a nearer hole'
    rank = 9
    starter = {'period': 1.0, 'range': 2.0}

    kind: Literal['synthesised'] = 'synthesised'
    range: Positive = Field(description='largest angle of the cam [rad]')

    def made(self, setting: Setting) -> Fitted:
        """Return the cam for the wheel and its power.

        SceneError: a power too slow for the period, or an impossible range.
        """
        rate_for_period(setting, self.period)
        key, value = 'trochlea.cam.period', self.period
        try:
            motion = synthesise(setting.inertia, math.tau / self.period, power_train(setting))
            key, value = 'trochlea.cam.range', self.range
            return synthesised_cam(motion, setting.distance, self.range)
        except (SynthesisError, FitError) as error:
            problem, _, remedy = str(error).rpartition('. ')
            raise SceneError(
                'trochlea',
                key,
                value,
                problem or remedy,
                f'{remedy if problem else "Give a smaller range"}.',
            ) from None


def power_train(setting: Setting) -> PowerTrain:
    """Return V and M of a power as functions of its lift y: F = F(0) + κy, V = F(0) y + κy²/2."""
    pull, force = setting.pull, setting.pull.at_rest(setting.gravity)
    stiffness = pull.stiffness
    return PowerTrain(
        pull=lambda y: force + stiffness * y,
        place=lambda v: 2.0 * v / (force + np.sqrt(force * force + 2.0 * stiffness * v)),
        mass=lambda y: np.full_like(y, pull.carried_mass),
    )


KIND = SynthesisedCam
