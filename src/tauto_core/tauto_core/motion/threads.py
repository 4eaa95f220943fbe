"""What the systems of both real threads share: that of the lever and the swinging one."""

from __future__ import annotations

import math
from typing import Any

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.events import is_due
from tauto_core.motion.lanes import fma, largest, least
from tauto_core.motion.layout import BEYOND, phase_to
from tauto_core.motion.outside import Outside, Pieces, outside_at
from tauto_core.motion.system import (
    Beyond,
    Lanes,
    Mode,
    Omega,
    State,
    first_below,
    mode_of,
    planes_of,
)
from tauto_core.motion.wells import term
from tauto_core.samples import FloatArray

WELL_WITHIN = 0.05
"""Margin that all nodes must have if a step is surely within the range."""


@inlined
def resistance(system: Any, mode: Mode, rate: Any) -> Any:
    """Return the torques of drag and recoil, reversed, over I: c₁ θ̇ + c₂ d θ̇² + R s."""
    drag = rate * fma(system.quadratic * mode.direction, rate, system.viscous)
    return drag + term(system.recoil, mode.pallet)


@compiled
def beyond_by(tension: Lanes, margin: Lanes, coordinate: Lanes, work: FloatArray) -> Beyond:
    """Return whether a step leaves the range, by tension and margin at its nodes."""
    edge, slack = first_below(margin, work), first_below(tension, work)
    within = least(margin) > WELL_WITHIN and least(tension) > 0.0
    return Beyond(edge, slack, within, largest(coordinate))


@compiled
def goes_off(system: Any, omega: Omega, angle: float, at: Outside, state: State) -> None:
    """Decide at θ = angle, θ̇ = 0 in which direction the wheel moves."""
    now = system.instant(mode_of(state), omega, planes_of(omega, state.planes), at)
    state.direction = -1 if now.bend < 0.0 else 1
    state.armed = is_due(system, float(state.direction), angle)


@compiled
def impulse_ahead_s(
    system: Any,
    omega: Omega,
    length: float,
    terms: int,
    x: float,
    state: State,
    work: FloatArray,
) -> float:
    """Return the time to a little after the next expected impulse [s], or inf.

    The swing is assumed to continue about its centre, which moves as the case does now, at the
    pace that gravity allows on the way.
    """
    if not system.feels_impulse:
        return math.inf
    at = outside_at(terms, x, work)
    now = system.instant(mode_of(state), omega, planes_of(omega, state.planes), at)
    way = float(state.direction if state.armed else -state.direction)
    pace = system.pace * math.sqrt(at.gravity / system.gravity)
    centre = now.angle + now.bend / (pace * pace)
    y = (now.rate + at.tilt.rate) / pace
    ahead = phase_to(way, now.angle - centre, y, system.impulse - way * centre)
    if ahead < math.inf:
        then = outside_at(terms, min(x + ahead / (pace * length), 1.0), work)
        moved = centre - (then.tilt.value - at.tilt.value)
        ahead = phase_to(way, now.angle - centre, y, system.impulse - way * moved)
        pace *= math.sqrt(0.5 * (1.0 + then.gravity / at.gravity))
    return (ahead + BEYOND) / pace


@compiled
def case_bounds(pieces: Pieces, k: int) -> tuple[float, float]:
    """Return bounds of the case's angle α = β − τ [rad] and of α̇ [rad/s] over piece k."""
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
