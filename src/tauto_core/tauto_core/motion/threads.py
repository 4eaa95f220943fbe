"""What Sully's lever and the swinging thread share as systems of the driver."""

from __future__ import annotations

import math
from typing import NamedTuple

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.events import is_due
from tauto_core.motion.lanes import Lanes, fma, largest, least
from tauto_core.motion.layout import BEYOND, phase_to
from tauto_core.motion.lever_arm import Number
from tauto_core.motion.outside import Outside, Pieces, outside_at
from tauto_core.motion.system import (
    Beyond,
    Mode,
    State,
    System,
    first_below,
    mode_of,
    planes_of,
)
from tauto_core.motion.wells import term
from tauto_core.motion.work import Omega, Work

WELL_WITHIN = 0.05
"""Margin at all nodes from which on a step counts as within the range between them, too."""


class OnWheel(NamedTuple):
    """What acts on the wheel besides the thread, over its moment of inertia I.

    Attributes:
        viscous: c₁/I [1/s].
        quadratic: c₂/I.
        energy: twice the energy of an impulse over I [1/s2].
        recoil: R/I of the escapement [1/s2], or None.
        impulse: angle of the impulse [rad]; infinite without one.
        pace: frequency of the swing [rad/s].
        gravity: g at rest [m/s2].
    """

    viscous: float
    quadratic: float
    energy: float
    recoil: float | None
    impulse: float
    pace: float
    gravity: float


class ThreadSystem(System):
    """A wheel on a real thread, as `System`.

    Absent drag is zero, not None, so that machines with and without it share their kernels.
    """

    @property
    def on_wheel(self) -> OnWheel:
        """What acts on the wheel."""
        raise NotImplementedError

    @property
    def impulse(self) -> float:
        """Angle of the impulse [rad]."""
        return self.on_wheel.impulse

    @property
    def recoils(self) -> bool:
        """Whether a resting tooth pushes the wheel back."""
        return self.on_wheel.recoil is not None

    @property
    def pace(self) -> float:
        """Frequency of the swing [rad/s]."""
        return self.on_wheel.pace

    @property
    def turns_abruptly(self) -> bool:
        """Whether the drag has a kink at the turning points."""
        return self.on_wheel.quadratic > 0.0

    def set_off(self, omega: Omega, angle: float, at: Outside, state: State) -> None:
        """Decide at θ = angle, θ̇ = 0 which way the wheel goes."""
        now = self.instant(mode_of(state), omega, planes_of(omega, state.planes), at)
        state.direction = -1 if now.bend < 0.0 else 1
        state.armed = is_due(self, state, float(state.direction), angle)

    def ahead_s(
        self, omega: Omega, length: float, terms: int, x: float, state: State, work: Work
    ) -> float:
        """Return the time to a little after the next impulse to expect [s], or inf.

        The swing goes on about its centre of now, at a frequency that goes with √g_eff on the way.
        Only the layout of steps depends on this prediction.
        """
        if not self.feels_impulse:
            return math.inf
        at = outside_at(terms, x, work)
        now = self.instant(mode_of(state), omega, planes_of(omega, state.planes), at)
        way = float(state.direction if state.armed else -state.direction)
        pace = self.pace * math.sqrt(at.gravity / self.on_wheel.gravity)
        shift = now.bend / (pace * pace)
        centre = now.angle + shift
        ahead = phase_to(way, -shift, now.rate / pace, self.impulse - way * centre)
        if ahead < math.inf:
            then = outside_at(terms, min(x + ahead / (pace * length), 1.0), work)
            pace *= math.sqrt(0.5 * (1.0 + then.gravity / at.gravity))
        return (ahead + BEYOND) / pace


@inlined
def resistance(on_wheel: OnWheel, mode: Mode, rate: Number) -> Number:
    """Return the torques of drag and recoil, reversed, over I: c₁ θ̇ + c₂ d θ̇² + R s."""
    drag = rate * fma(on_wheel.quadratic * mode.direction, rate, on_wheel.viscous)
    return drag + term(on_wheel.recoil, mode.pallet)


@compiled
def beyond_by(tension: Lanes, margin: Lanes, coordinate: Lanes, work: Work) -> Beyond:
    """Return whether a step leaves the range, from tension, margin and coordinate at its nodes."""
    edge, slack = first_below(margin, work), first_below(tension, work)
    within = least(margin) > WELL_WITHIN and least(tension) > 0.0
    return Beyond(edge, slack, within, largest(coordinate))


@compiled
def case_bounds(pieces: Pieces, k: int) -> tuple[float, float]:
    """Return bounds of the case's angle α = β − τ [rad] and of α̇ [rad/s] over piece k.

    They are the sums of the coefficients' magnitudes, which no polynomial exceeds for 0 ≤ x ≤ 1.
    """
    vertical, tilt = pieces.line, pieces.tilt
    if vertical is None or tilt is None:
        return 0.0, 0.0
    value = slope = 0.0
    for j in range(max(vertical.shape[1], tilt.shape[1])):
        first = vertical[k, j] if j < vertical.shape[1] else 0.0
        size = abs(first - tilt[k, j]) if j < tilt.shape[1] else abs(first)
        value += size
        slope += j * size
    return value, slope / pieces.length_s[k]
