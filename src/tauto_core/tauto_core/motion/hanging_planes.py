"""The swinging thread in two rotating planes: the modes of small swings.

ψ = Σ E_ψi X_i and δ = Σ E_δi X_i with Ẋ_i = ω_i Y_i; all that is not linear, and all that the ship
does, is disturbance. The equations are those of `machines.threads.hanging`, whose accelerated axle
needs the apparent gravity only: no derivative of the ship's motion but α̇ in the drag.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol, TypeAlias

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.lanes import Lanes, largest, least, load, store
from tauto_core.motion.lever_arm import Number
from tauto_core.motion.outside import (
    GRAVITY,
    LINE,
    LINE_RATE,
    TILT_RATE,
    Outside,
    Pieces,
    Place,
    column,
    difference,
    nodes_of,
)
from tauto_core.motion.passages import CLEAR
from tauto_core.motion.rotation import sine_versine
from tauto_core.motion.system import Beyond, Instant, Mode, Plane, State
from tauto_core.motion.threads import OnWheel, ThreadSystem, beyond_by, case_bounds, resistance
from tauto_core.motion.work import Omega, Work
from tauto_core.samples import FloatArray

NODES = 'vertical', 'gravity', 'turn'
"""Rows of β, g_eff and α̇ at the nodes."""

Pair: TypeAlias = tuple[Number, Number]
"""A number of each plane, or of wheel and thread."""


class Nodes(Protocol):
    """The rows NODES."""

    vertical: FloatArray
    gravity: FloatArray
    turn: FloatArray


class _Numbers(NamedTuple):
    """What the equations hold.

    Attributes:
        radius: r [m].
        length: l₀ [m].
        least: free thread at the end of the range [m].
        ratio: m r/I [1/m].
        wheel: E_ψi, of the modes.
        thread: E_δi.
        to_first: X₁ of ψ = 1 and of δ = 1.
        to_second: X₂ of the same.
        on_wheel: what acts on the wheel.
    """

    radius: float
    length: float
    least: float
    ratio: float
    wheel: tuple[float, float]
    thread: tuple[float, float]
    to_first: tuple[float, float]
    to_second: tuple[float, float]
    on_wheel: OnWheel


class Hanging(_Numbers, ThreadSystem):
    """The swinging thread as `system.System`."""

    def at_nodes(self, place: Place, work: Work) -> None:
        """Fill β, g_eff and α̇."""
        x, nodes = nodes_of(place, work), work.nodes
        store(nodes.vertical, 0, column(LINE, place.terms, x, work))
        store(nodes.gravity, 0, column(GRAVITY, place.terms, x, work))
        store(nodes.turn, 0, difference(LINE_RATE, TILT_RATE, place.terms, x, work))

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill what disturbs the planes; d1 stays zero."""
        psi, delta, _, _ = _at_stages(self, mode, omega, work)
        bends = _modes(self, psi, delta)
        for p in range(len(omega)):
            store(work.d2, p, omega[p] * load(work.x, p) + bends[p] * (1.0 / omega[p]))

    def beyond(self, mode: Mode, omega: Omega, work: Work) -> Beyond:
        """Return whether the step winds up the whole thread, or the thread goes slack."""
        _, _, tension, free = _at_stages(self, mode, omega, work)
        return beyond_by(tension, free - self.least, self.coordinates(work), work)

    def coordinates(self, work: Work) -> Lanes:
        """Return u = ψ − δ at the nodes."""
        psi, delta = _angles(self, load(work.x, 0), load(work.x, 1))
        return psi - delta

    def coordinate(self, planes: tuple[Plane, ...]) -> float:
        """Return u."""
        psi, delta = _angles(self, planes[0].x, planes[1].x)
        return psi - delta

    def clear_square(self, omega: Omega, pieces: Pieces, k: int) -> float:
        """Return the largest square of the difference of θ and u over piece k."""
        value, rate = case_bounds(pieces, k)
        rate = rate / self.pace
        return value * value + rate * rate

    def clear(self, square: float, omega: Omega, work: Work) -> bool:
        """Return whether u swings wider at all nodes than what parts θ from u: δ − α."""
        (psi, delta), (psi_rate, delta_rate) = _stages(self, omega, work)
        u, u_rate = psi - delta, (psi_rate - delta_rate) * (1.0 / self.pace)
        swung = largest(delta * delta + delta_rate * delta_rate * (1.0 / self.pace**2))
        apart = math.sqrt(swung) + math.sqrt(square)
        return least(u * u + u_rate * u_rate) > CLEAR * (apart * apart)

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Outside) -> Instant:
        """Return wheel and thread at an instant."""
        return _instant(self, mode, omega, planes, at)

    def drift(self, mode: Mode, omega: Omega, at: Outside, now: Instant) -> tuple[Plane, ...]:
        """Return the rates of the modes and of their rates."""
        psi_rate = now.rate + (at.line.rate - at.tilt.rate)
        psi_bend = now.bend + (at.line.bend - at.tilt.bend)
        rates = _modes(self, psi_rate, psi_rate - now.speed)
        bends = _modes(self, psi_bend, psi_bend - now.acceleration)
        return Plane(rates[0], bends[0]), Plane(rates[1], bends[1])

    def wheel_angle(self, planes: tuple[Plane, ...], at: Outside) -> float:
        """Return θ = ψ − α."""
        psi, _ = _angles(self, planes[0].x, planes[1].x)
        return psi - (at.line.value - at.tilt.value)

    def strike(self, mode: Mode, omega: Omega, at: Outside, now: Instant, state: State) -> None:
        """Let an impulse change both rates; the thread stays taut."""
        radius, u, planes = self.radius, now.coordinate, state.planes
        mass = 1.0 + self.ratio * radius * u * u
        struck = mode.direction * math.sqrt(now.rate * now.rate + self.on_wheel.energy / mass)
        kick = struck - now.rate
        swung = -radius / (self.length - 0.5 * radius * u * u) * kick
        first, second = _modes(self, kick, swung)
        planes[0].y += first / omega[0]
        planes[1].y += second / omega[1]
        planes[0].y_rest = planes[1].y_rest = 0.0


@inlined
def _angles(system: Hanging, first: Number, second: Number) -> Pair:
    """Return ψ and δ, or their rates, of the modes."""
    wheel, thread = system.wheel, system.thread
    return wheel[0] * first + wheel[1] * second, thread[0] * first + thread[1] * second


@inlined
def _stages(system: Hanging, omega: Omega, work: Work) -> tuple[Pair, Pair]:
    """Return ψ, δ and their rates at the stages."""
    angles = _angles(system, load(work.x, 0), load(work.x, 1))
    return angles, _angles(system, omega[0] * load(work.y, 0), omega[1] * load(work.y, 1))


@inlined
def _pushed(
    system: Hanging,
    psi: Number,
    delta: Number,
    rates: Pair,
    cosine: Number,
    sine: Number,
    g: Number,
    drag: Number,
) -> tuple[Number, Number, Number, Number]:
    """Return ψ̈, δ̈, the tension over m and the free thread.

    Args:
        cosine: cosine of δ − β.
        sine: sine of δ − β.
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


@inlined
def _modes(system: Hanging, psi: Number, delta: Number) -> Pair:
    """Return of ψ and δ, or their rates, what the modes have."""
    first, second = system.to_first, system.to_second
    return first[0] * psi + first[1] * delta, second[0] * psi + second[1] * delta


@inlined
def _at_stages(
    system: Hanging, mode: Mode, omega: Omega, work: Work
) -> tuple[Lanes, Lanes, Lanes, Lanes]:
    """Return ψ̈, δ̈, the tension over m and the free thread at the stages."""
    (psi, delta), rates = _stages(system, omega, work)
    nodes: Nodes = work.nodes
    sine, versine = sine_versine(delta - load(nodes.vertical))
    drag = resistance(system.on_wheel, mode, rates[0] - load(nodes.turn))
    gravity = load(nodes.gravity)
    return _pushed(system, psi, delta, rates, 1.0 - versine, sine, gravity, drag)


@compiled
def _instant(
    system: Hanging, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Outside
) -> Instant:
    line, tilt = at.line, at.tilt
    psi, delta = _angles(system, planes[0].x, planes[1].x)
    rates = _angles(system, omega[0] * planes[0].y, omega[1] * planes[1].y)
    rate = rates[0] - (line.rate - tilt.rate)
    drag = resistance(system.on_wheel, mode, rate)
    lean = delta - line.value
    psi_bend, delta_bend, tension, free = _pushed(
        system, psi, delta, rates, math.cos(lean), math.sin(lean), at.gravity, drag
    )
    return Instant(
        psi - (line.value - tilt.value),
        rate,
        psi_bend - (line.bend - tilt.bend),
        tension,
        free - system.least,
        psi_bend + drag,
        psi - delta,
        rates[0] - rates[1],
        psi_bend - delta_bend,
    )
