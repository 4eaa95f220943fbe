"""A thread that swings with the weight at its end, and the periodic swing of both.

Two degrees of freedom, both absolute angles: ψ of the wheel, δ of the thread. With u = ψ − δ, the
angle by which the cam winds the thread, and l = l₀ − r u²/2, the free length,

    (I + m r²u²) ψ̈ = −m r u [g cos(δ − β) + l δ̇² + r ψ̇²] + torque on the wheel,
    l δ̈ = −g sin(δ − β) − r ψ̈ + r u δ̇ (2ψ̇ − δ̇) + Q/(m l),

where Q = −c (δ̇ − α̇) damps the lean of the thread in the case, whose tilt is α, and adds −Q r/l
to the torque on the wheel. The power lost is c (δ̇ − α̇)². β is the direction of the apparent
vertical and g the apparent gravity. Small swings are the modes of paper C (`modes`).

A spring of the stiffness κ, anchored far below in the case and slack at rest, may pull the weight
down. If the weight has risen by H along the case's vertical, the pull is κ H,

    H = r u sin ε + (r + l₀)(1 − cos ε) + ½ r u² cos ε,    ε = δ − α,

which adds κ H/m cos ε to g cos(δ − β), and κ H/m sin ε to g sin(δ − β).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, Strict

from tauto_core.curves.materials import as_written
from tauto_core.machines.axle_pendulum import Modes, modes
from tauto_core.machines.heat import NO_HEAT, Heat
from tauto_core.machines.parts import DragKind, EscapementKind, PowerKind, wrong
from tauto_core.machines.trochlea import Parts, SlackThreadError, ThreadKind
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import CamRangeError, Problem, TautoError
from tauto_core.scene.sections import Positive

# -----------------------------------------------------------------------------
# The periodic swing of a wheel and its thread together: Fourier series and Newton's method.
#
# Both angles start at rest and pass the middle together: their series have odd cosines only, ψ
# = Σ a_k cos(2k + 1)ωt, δ = Σ b_k cos(2k + 1)ωt. The equations of motion at as many instants of a
# quarter swing, and Σ a_k = A, determine the unknowns. The series converge geometrically, to an
# accuracy of rounding.

_FEWEST_TERMS, _MOST_TERMS = 8, 128
# Size of the last coefficients over the amplitude at which a series is complete.
_TAIL = 2.0**-46

_SETTLED = 2.0**-48
_ITERATIONS = 40

Accelerations = Callable[
    [np.ndarray, np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]
]


class SwingError(TautoError):
    """A swing without a common periodic motion of wheel and thread."""


def common_swing(
    accelerations: Accelerations, amplitude: float, frequency: float, share: float
) -> tuple[float, list[FloatArray]]:
    """Return the periodic swing of an amplitude of ψ, continued from a mode of small swings.

    The result is its period [s], and ψ, δ [rad], ψ̇, δ̇ at n instants of a quarter.
    `accelerations` gives ψ̈ and δ̈ of (ψ, δ, ψ̇, δ̇), complex arrays. The mode has a frequency
    [rad/s] and `share`, its δ/ψ. SwingError: no such swing, or more than 128 terms.
    """
    terms = _FEWEST_TERMS
    while terms <= _MOST_TERMS:
        swing = _continued(accelerations, amplitude, frequency, share, terms)
        if swing is None:
            break
        if np.max(np.abs(swing[[terms - 2, terms - 1, -3, -2]])) <= _TAIL * amplitude:
            angles, rates, _ = _along(swing[None], terms)
            return math.tau / float(swing[-1]), [part[0] for part in (*angles, *rates)]
        terms *= 2
    raise SwingError(
        f'at {amplitude:.6g} rad wheel and thread have no common swing that continues the mode of '
        'small swings: the thread is near a resonance with the wheel, or goes slack. Use a '
        'smaller amplitude, a longer thread or a lighter weight'
    )


def _continued(
    accelerations: Accelerations, amplitude: float, frequency: float, share: float, terms: int
) -> FloatArray | None:
    """Return a_k, b_k, ω at the amplitude, continued from small swings, if possible."""
    unknowns = np.zeros(2 * terms + 1)
    unknowns[-1] = frequency
    # in steps of at most a quarter of a radian
    steps = max(1, math.ceil(amplitude / 0.25))
    unknowns[0], unknowns[terms] = amplitude / steps, share * amplitude / steps
    for step in range(1, steps + 1):
        reached = amplitude * step / steps
        unknowns[: 2 * terms] *= reached / np.sum(unknowns[:terms])
        solution = _newton(accelerations, reached, unknowns, terms)
        if solution is None:
            return None
        unknowns = solution
    return unknowns


def _newton(
    accelerations: Accelerations, amplitude: float, unknowns: FloatArray, terms: int
) -> FloatArray | None:
    """Return the solution near some unknowns, if any, by Newton's method with complex steps.

    The equations are divided by ω². All columns of their derivative are computed together.
    """
    count, scale = len(unknowns), np.append(np.full(2 * terms, amplitude), unknowns[-1])
    old = math.inf
    for _ in range(_ITERATIONS):
        shifted = np.broadcast_to(unknowns.astype(complex), (count, count)).copy()
        # imaginary parts give derivatives without a difference: the step may be tiny
        steps = 1e-30 * np.maximum(np.abs(unknowns), 1.0)
        shifted[np.arange(count), np.arange(count)] += 1j * steps
        angles, rates, bends = _along(shifted, terms)
        pushed = accelerations(angles[0], angles[1], rates[0], rates[1])
        omega = shifted[:, -1:]
        residuals = [bend - push / omega**2 for bend, push in zip(bends, pushed, strict=True)]
        size = np.sum(shifted[:, :terms], axis=1, keepdims=True)
        errors = np.hstack([*residuals, size - amplitude])
        residual, matrix = errors[0].real, (errors.imag / steps[:, None]).T
        if not np.all(np.isfinite(residual)):
            return None
        change = np.linalg.solve(matrix, residual)
        unknowns = unknowns - change
        shift = float(np.max(np.abs(change / scale)))
        # or rounding keeps Newton's method from halving the rest
        if shift <= _SETTLED or (shift <= 2.0**-40 and shift >= 0.5 * old):
            return unknowns
        if not math.isfinite(shift) or not unknowns[-1] > 0.0:
            return None
        old = shift
    return None


def _along(
    unknowns: np.ndarray, terms: int
) -> tuple[list[np.ndarray], list[np.ndarray], list[np.ndarray]]:
    """Return ψ and δ, their rates over ω and second derivatives over ω², each (m, n)."""
    orders = 2.0 * np.arange(terms) + 1.0
    phases = 0.5 * math.pi * (np.arange(terms) + 0.5) / terms
    cosines, sines = np.cos(np.outer(orders, phases)), np.sin(np.outer(orders, phases))
    omega = unknowns[:, -1:]
    series = unknowns[:, :terms], unknowns[:, terms:-1]
    angles = [part @ cosines for part in series]
    rates = [-omega * ((orders * part) @ sines) for part in series]
    bends = [-((orders * orders * part) @ cosines) for part in series]
    return angles, rates, bends


LEAST_FREE = 0.01
"""Part of the thread that must stay free, since its frequency diverges as it is used up."""


@dataclass(frozen=True)
class HangingMachine:
    """A wheel, its involute and a weight on a thread that swings.

    Attributes:
        inertia: I of the wheel about its axle [kg m2], > 0.
        mass: m of the weight [kg], > 0.
        base_radius: r of the involute [m], > 0.
        length: l₀ of the free thread at rest [m], > 0.
        gravity, drag, escapement, heat, stops_when_slack: as in `Machine`.
        release_angle: angle of the wheel in its case at release, from rest, with the thread
            plumb [rad].
        damping: c, of the lean of the thread in the case [N m s].
        stiffness: κ of a spring that pulls the weight down [N/m], 0 without one.
    """

    inertia: float
    mass: float
    base_radius: float
    length: float
    gravity: float
    drag: DragKind | None
    escapement: EscapementKind | None
    release_angle: float
    damping: float = 0.0
    heat: Heat = NO_HEAT
    stops_when_slack: bool = False
    stiffness: float = 0.0

    follows_apparent_vertical = True
    feels_gravity = True
    limited_by = 'the range of the thread,'
    widening = ', or use a longer thread or a smaller base_radius'

    def at_celsius(self, celsius: float, time_s: float = 0.0) -> HangingMachine:
        """Return the machine with its parameters at this temperature [°C] and time [s].

        The result has constant parameters. Its thread keeps its length.
        """
        factors = self.heat.factors(np.asarray(celsius), np.asarray(time_s))
        return replace(
            self,
            inertia=self.inertia * float(factors.inertia),
            base_radius=self.base_radius * math.sqrt(float(factors.carried)),
            drag=None if self.drag is None else self.drag.thinned(float(factors.viscous)),
            heat=Heat(celsius),
        )

    @cached_property
    def modes(self) -> Modes:
        """The modes of small swings."""
        return modes(self.length, self.base_radius, self.inertia / self.mass)

    @property
    def wheel_is_fast(self) -> bool:
        """Whether the wheel's mode is the faster one: l₀ > r + I/(m r), a long thread.

        The wheel's mode dominates after a release of the wheel with the thread plumb. At
        l₀ = r + I/(m r) both modes have equal parts.
        """
        return self.length > self.base_radius + self.inertia / (self.mass * self.base_radius)

    @property
    def frequency(self) -> float:
        """Angular frequency of small swings in the wheel's mode on land [rad/s].

        For a long thread it tends to √(m g r/I), as on an ideal vertical thread.
        """
        return math.sqrt(
            self.gravity / (self.modes.h_prime if self.wheel_is_fast else self.modes.h)
        )

    @property
    def thread_frequency(self) -> float:
        """Angular frequency of small swings in the thread's mode on land [rad/s]."""
        return math.sqrt(
            self.gravity / (self.modes.h if self.wheel_is_fast else self.modes.h_prime)
        )

    @property
    def small_period(self) -> float:
        """Period of small swings in the wheel's mode on land [s]."""
        return math.tau / self.frequency

    @property
    def range_rad(self) -> float:
        """Largest |u| [rad], with LEAST_FREE of the thread still free."""
        return math.sqrt(2.0 * (1.0 - LEAST_FREE) * self.length / self.base_radius)

    def sensed_angle(self, angle: float, tilt: float) -> float:
        """Return u of a wheel at `angle` in its case with the thread plumb [rad]."""
        return angle - tilt

    def accelerations(
        self, psi: np.ndarray, delta: np.ndarray, psi_rate: np.ndarray, delta_rate: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return ψ̈ and δ̈ of free motion on land [rad/s2]; arrays may be complex."""
        radius, ratio = self.base_radius, self.mass * self.base_radius / self.inertia
        u = psi - delta
        free = self.length - 0.5 * radius * u * u
        drawn = self.stiffness / self.mass * self.risen(u, delta) if self.stiffness else 0.0
        gravity = self.gravity + drawn
        pulled = gravity * np.cos(delta) + free * delta_rate**2 + radius * psi_rate**2
        psi_bend = -ratio * u * pulled / (1.0 + ratio * radius * u * u)
        carried = radius * u * delta_rate * (2.0 * psi_rate - delta_rate)
        delta_bend = (carried - gravity * np.sin(delta) - radius * psi_bend) / free
        return psi_bend, delta_bend

    def risen(self, u: np.ndarray, lean: np.ndarray) -> np.ndarray:
        """Return H, the rise of the weight above its place at rest [m], of u and ε."""
        radius, versine = self.base_radius, 2.0 * np.sin(0.5 * lean) ** 2
        risen = radius * u * np.sin(lean) + (radius + self.length) * versine
        return np.asarray(risen + 0.5 * radius * u * u * np.cos(lean))

    def tension(
        self, psi: FloatArray, delta: FloatArray, psi_rate: FloatArray, delta_rate: FloatArray
    ) -> FloatArray:
        """Return the tension of the thread in free motion on land, u ≠ 0 [N]."""
        bend, _ = self.accelerations(psi, delta, psi_rate, delta_rate)
        return np.asarray(-self.inertia * bend / (self.base_radius * (psi - delta)))

    def period(self, amplitude: float) -> float:
        """Return the period of the periodic swing in the wheel's mode on land [s].

        Wheel and thread come to rest together and pass the middle together, which makes the swing
        repeat. Other releases also excite the thread's mode. The sign of A does not matter, and
        A → 0 gives the mode of small swings. CamRangeError: an amplitude that winds up the whole
        thread. SwingError: no such swing. SlackThreadError: a swing in which the thread goes
        slack.
        """
        amplitude = abs(amplitude)
        # the period differs from its limit by a share of order A², here below rounding
        if amplitude < 2.0**-40:
            return self.small_period
        if not amplitude < self.range_rad:
            raise CamRangeError(
                f'an amplitude of {amplitude!r} rad winds up the whole thread at '
                f'{self.range_rad:.6g} rad. Use a smaller amplitude or a longer thread'
            )
        share = self.modes.B_prime if self.wheel_is_fast else self.modes.B
        period, course = common_swing(
            self.accelerations, amplitude, self.frequency, self.base_radius / share
        )
        taut = self.tension(*course) > 0.0
        if not taut.all():
            where = float(course[0][~taut][0])
            raise SlackThreadError(
                f'the thread goes slack at an angle of {where!r} rad of the wheel. Use a smaller '
                'amplitude or a lighter weight'
            )
        return period


MOST_DAMPED = 2.0
"""Largest damping ratio, with which the lean returns four times slower than it would swing."""


class HangingThread(ThreadKind):
    """Thread that hangs freely with its weight, and swings."""

    moves_the_weight = True
    compensable = False
    takes_a_spring = True
    rank = 4
    starter = {'length': 1.0}

    kind: Literal['hanging'] = 'hanging'
    length: Positive = Field(description='free length of the thread at rest [m]')
    damping_ratio: Annotated[float, Strict(), Field(ge=0.0, le=MOST_DAMPED)] = Field(
        default=0.0,
        description='damping of the lean of the thread in the case, over the critical one of its '
        f'swing below a wheel at rest, 0 to {MOST_DAMPED:g}. When left out it is undamped',
    )

    @property
    def swinging_length(self) -> float:
        """Free length of the thread at rest [m]."""
        return self.length

    def problems(
        self, power: PowerKind, drag: DragKind | None, escapement: EscapementKind | None
    ) -> Iterator[Problem]:
        """Yield the keys that a swinging thread excludes."""
        yield from super().problems(power, drag, escapement)
        made_of = getattr(power, 'material', None)
        yield from wrong(
            (
                power.pull.stiffness and made_of is not None,
                'trochlea.power.material',
                as_written(made_of),
                f'does not go with trochlea.thread.kind {self.kind}: its spring does not change '
                'with temperature',
                'Leave it out.',
            )
        )

    def machine(self, parts: Parts) -> HangingMachine:
        """Return the machine with a swinging thread."""
        rate = self.cam(parts).linear_rate
        assert rate is not None  # linear in all cams for this thread
        mass, stiffness = parts.power.pull.carried_mass, parts.power.pull.stiffness
        critical = 2.0 * mass * self.length * math.sqrt(parts.gravity * self.length)
        return HangingMachine(
            inertia=parts.inertia,
            mass=mass,
            base_radius=rate,
            length=self.length,
            gravity=parts.gravity,
            drag=parts.drag,
            escapement=parts.escapement,
            release_angle=parts.release_angle,
            damping=self.damping_ratio * critical,
            heat=parts.heat,
            stops_when_slack=stiffness > 0.0,
            stiffness=stiffness,
        )


KIND = HangingThread
