"""The swinging thread in two turning planes: the modes of small swings.

ψ = Σ E_ψi X_i and δ = Σ E_δi X_i with Ẋ_i = ω_i Y_i; all that is not linear, and all that the ship
does, is disturbance. The equations are those of `machines.threads.hanging`, whose accelerated axle
needs the apparent gravity only: no derivative of the ship's motion but α̇ in the drag.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from tauto_core.kernels import inlined, overload
from tauto_core.motion import mechanism, turning
from tauto_core.motion.lanes import filled, load, store
from tauto_core.motion.mechanism import resistance
from tauto_core.motion.outside import (
    GRAVITY,
    LINE,
    LINE_RATE,
    TILT_RATE,
    column,
    difference,
    nodes_of,
)
from tauto_core.motion.rotation import sine_versine
from tauto_core.motion.turning import D1, D2, FIRST, OUTSIDE, X, Y, row

PLANES = 2
FIRST_ROW = FIRST + OUTSIDE * PLANES
VERTICAL_ROW, GRAVITY_ROW, TURN_ROW = range(FIRST_ROW, FIRST_ROW + 3)
"""Rows of β, g_eff and α̇ at the nodes."""

ROWS = 3


class Hanging(NamedTuple):
    """The swinging thread as `turning` and `spans` take it.

    Attributes:
        radius: r [m].
        length: l₀ [m].
        least: free thread at the end of the range [m].
        ratio: m r/I [1/m].
        wheel: E_ψi, of the modes.
        thread: E_δi.
        to_first: X₁ of ψ = 1 and of δ = 1.
        to_second: X₂ of the same.
        viscous: c₁/I.
        quadratic: c₂/I.
        energy: twice the impulse's over I.
        recoil: R/I, or None.
    """

    radius: float
    length: float
    least: float
    ratio: float
    wheel: tuple[float, float]
    thread: tuple[float, float]
    to_first: tuple[float, float]
    to_second: tuple[float, float]
    viscous: float
    quadratic: float
    energy: float
    recoil: float | None


def _is_hanging(system: Any) -> bool:
    return getattr(system, 'instance_class', None) is Hanging


@inlined
def _angles(system: Any, first: Any, second: Any) -> Any:
    """Return ψ and δ, or their rates, of the modes."""
    wheel, thread = system.wheel, system.thread
    return wheel[0] * first + wheel[1] * second, thread[0] * first + thread[1] * second


@inlined
def _stages(system: Any, omega: Any, work: Any) -> Any:
    """Return ψ, δ and their rates at the stages."""
    angles = _angles(system, load(work, row(X, PLANES, 0)), load(work, row(X, PLANES, 1)))
    first, second = load(work, row(Y, PLANES, 0)), load(work, row(Y, PLANES, 1))
    return angles, _angles(system, omega[0] * first, omega[1] * second)


@inlined
def _pushed(
    system: Any, psi: Any, delta: Any, rates: Any, cosine: Any, sine: Any, g: Any, drag: Any
) -> Any:
    """Return ψ̈, δ̈, the tension over m and the free thread.

    Args:
        cosine: of δ − β.
        sine: of δ − β.
        g: g_eff.
        drag: on the wheel, and recoil, over I.
    """
    psi_rate, delta_rate = rates
    radius, u = system.radius, psi - delta
    free = system.length - (0.5 * radius) * (u * u)
    pulled = g * cosine + free * (delta_rate * delta_rate) + radius * (psi_rate * psi_rate)
    mass = 1.0 + (system.ratio * radius) * (u * u)
    psi_bend = -(system.ratio * (u * pulled) + drag) / mass
    carried = radius * (u * delta_rate) * (2.0 * psi_rate - delta_rate)
    delta_bend = (carried - g * sine - radius * psi_bend) / free
    return psi_bend, delta_bend, pulled + radius * (u * psi_bend), free


@overload(mechanism.at_nodes)
def _at_nodes(system: Any, place: Any, work: Any) -> Any:
    if not _is_hanging(system):
        return None

    def fill(system: Any, place: Any, work: Any) -> None:
        terms, x = place[1], nodes_of(place, work)
        store(work, VERTICAL_ROW, column(LINE, terms, x, work))
        store(work, GRAVITY_ROW, column(GRAVITY, terms, x, work))
        store(work, TURN_ROW, difference(LINE_RATE, TILT_RATE, terms, x, work))

    return fill


@inlined
def _at_stages(system: Any, mode: Any, omega: Any, work: Any) -> Any:
    (psi, delta), rates = _stages(system, omega, work)
    sine, versine = sine_versine(delta - load(work, VERTICAL_ROW))
    drag = resistance(system, mode, rates[0] - load(work, TURN_ROW))
    gravity = load(work, GRAVITY_ROW)
    return _pushed(system, psi, delta, rates, 1.0 - versine, sine, gravity, drag)


@overload(turning.disturb)
def _disturb(system: Any, mode: Any, omega: Any, work: Any) -> Any:
    if not _is_hanging(system):
        return None

    def disturb(system: Any, mode: Any, omega: Any, work: Any) -> None:
        psi, delta, _, _ = _at_stages(system, mode, omega, work)
        first, second = system.to_first, system.to_second
        bends = first[0] * psi + first[1] * delta, second[0] * psi + second[1] * delta
        for p in range(PLANES):
            bend = bends[0] if p == 0 else bends[1]
            x = load(work, row(X, PLANES, p))
            store(work, row(D1, PLANES, p), filled(work, 0.0))
            store(work, row(D2, PLANES, p), omega[p] * x + bend * (1.0 / omega[p]))

    return disturb


@overload(mechanism.margins)
def _margins(system: Any, mode: Any, omega: Any, work: Any) -> Any:
    if not _is_hanging(system):
        return None

    def margins(system: Any, mode: Any, omega: Any, work: Any) -> Any:
        _, _, tension, free = _at_stages(system, mode, omega, work)
        return tension, free - system.least

    return margins


@overload(mechanism.instant)
def _instant(system: Any, mode: Any, omega: Any, state: Any, at: Any) -> Any:
    if not _is_hanging(system):
        return None

    def instant(system: Any, mode: Any, omega: Any, state: Any, at: Any) -> Any:
        line, tilt, g_eff = at
        psi, delta = _angles(system, state[0], state[4])
        rates = _angles(system, omega[0] * state[2], omega[1] * state[6])
        rate = rates[0] - (line[1] - tilt[1])
        drag = resistance(system, mode, rate)
        lean = delta - line[0]
        psi_bend, delta_bend, tension, free = _pushed(
            system, psi, delta, rates, math.cos(lean), math.sin(lean), g_eff, drag
        )
        return (
            psi - (line[0] - tilt[0]),
            rate,
            psi_bend - (line[2] - tilt[2]),
            tension,
            free - system.least,
            psi_bend + drag,
            psi - delta,
            rates[0] - rates[1],
            psi_bend - delta_bend,
        )

    return instant


@overload(mechanism.wheel_angle)
def _wheel_angle(system: Any, state: Any, at: Any) -> Any:
    if not _is_hanging(system):
        return None

    def wheel_angle(system: Any, state: Any, at: Any) -> Any:
        return _angles(system, state[0], state[4])[0] - (at[0][0] - at[1][0])

    return wheel_angle


@overload(mechanism.strike)
def _strike(system: Any, mode: Any, omega: Any, at: Any, state: Any) -> Any:
    if not _is_hanging(system):
        return None

    def strike(system: Any, mode: Any, omega: Any, at: Any, state: Any) -> None:
        psi, delta = _angles(system, state[0], state[4])
        psi_rate, _ = _angles(system, omega[0] * state[2], omega[1] * state[6])
        radius, u = system.radius, psi - delta
        mass = 1.0 + system.ratio * radius * u * u
        rate = psi_rate - (at[0][1] - at[1][1])
        kick = mode[0] * math.sqrt(rate * rate + system.energy / mass) - rate
        # the thread stays taut: it takes up what the wheel winds
        swung = -radius / (system.length - 0.5 * radius * u * u) * kick
        first, second = system.to_first, system.to_second
        state[2] += (first[0] * kick + first[1] * swung) / omega[0]
        state[6] += (second[0] * kick + second[1] * swung) / omega[1]
        state[3] = state[7] = 0.0

    return strike
