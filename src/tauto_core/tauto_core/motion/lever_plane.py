"""Sully's lever machine in one rotating plane, with the arc for its coordinate.

Per inertia of the wheel, with s, n, w, χ' and j of lever_shape, κ = m AD/√(IJ), A = n + √j w and
α = β − τ the tilt of the case,

    L/I = ½ ṡ² + A α̇ ṡ + … − √j κ g_eff sin(β_lever − τ),    p = ṡ + A α̇,
    ṡ = p − A α̇,    ṗ = ṡ α̇ χ' (√j n − w) − κ w g_eff cos(β_lever − τ) − n · drag:

no second derivative of the ship's motion is needed. X is s, ωY is p. The ship's motion is that of
the fulcrum.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol, TypeAlias

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.lanes import Lanes, filled, fma, largest, least, load, store
from tauto_core.motion.lever_arm import Number
from tauto_core.motion.lever_shape import (
    ANGLE,
    BEND,
    COSINE,
    RIDE,
    SHORTENING,
    SINE,
    LeverShape,
    Powers,
    Series,
)
from tauto_core.motion.outside import (
    GRAVITY,
    LINE_BEND,
    LINE_RATE,
    TILT,
    TILT_BEND,
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

NODES = 'turn', 'turn_bend', 'up', 'across'
"""Rows of α̇, α̈ and of g_eff cos τ, g_eff sin τ at the nodes."""

OnArc: TypeAlias = tuple[Number, Number, Number, Number, Number, Number]
"""n, w, χ', cos β, sin β and θ."""


class Nodes(Protocol):
    """The rows NODES."""

    turn: FloatArray
    turn_bend: FloatArray
    up: FloatArray
    across: FloatArray


class _Numbers(NamedTuple):
    """What the equations hold.

    Attributes:
        shape: the functions of the arc.
        carried: √j, of J/I.
        weight: κ.
        on_wheel: what acts on the wheel.
    """

    shape: LeverShape
    carried: float
    weight: float
    on_wheel: OnWheel


class Lever(_Numbers, ThreadSystem):
    """Sully's lever machine as `system.System`."""

    def at_nodes(self, place: Place, work: Work) -> None:
        """Fill α̇, α̈ and the apparent gravity along and across the case."""
        x, nodes = nodes_of(place, work), work.nodes
        sine, versine = sine_versine(column(TILT, place.terms, x, work))
        g_eff = column(GRAVITY, place.terms, x, work)
        store(nodes.turn, 0, difference(LINE_RATE, TILT_RATE, place.terms, x, work))
        store(nodes.turn_bend, 0, difference(LINE_BEND, TILT_BEND, place.terms, x, work))
        store(nodes.up, 0, g_eff - g_eff * versine)
        store(nodes.across, 0, g_eff * sine)

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill what disturbs the plane."""
        s, p = load(work.x), omega[0] * load(work.y)
        nodes: Nodes = work.nodes
        n, w, bend, cosine, sine = _shape_at(self.shape, s)
        turn = load(nodes.turn)
        dragged = turn * fma(self.carried, w, n)
        rate = p - dragged
        pull = load(nodes.up) * cosine + load(nodes.across) * sine
        pushed = (omega[0] * omega[0]) * s - (self.weight * w) * pull
        ride = rate * turn * bend * (self.carried * n - w)
        more = pushed + ride - n * resistance(self.on_wheel, mode, n * rate)
        store(work.d1, 0, -dragged)
        store(work.d2, 0, more * (1.0 / omega[0]))

    def beyond(self, mode: Mode, omega: Omega, work: Work) -> Beyond:
        """Return whether the step leaves the geometry, or the thread goes slack."""
        s, p = load(work.x), omega[0] * load(work.y)
        nodes: Nodes = work.nodes
        n, w, bend, cosine, sine = _shape_at(self.shape, s)
        dragged = fma(self.carried, w, n)
        rate = p - load(nodes.turn) * dragged
        pull = load(nodes.up) * cosine + load(nodes.across) * sine
        turned = load(nodes.turn_bend)
        push = (self.weight * w) * pull + n * resistance(self.on_wheel, mode, n * rate)
        bent = -(push + dragged * turned)
        tension = w * bent + n * bend * (rate * rate) + self.carried * turned
        whole = self.shape.whole
        x = (s - whole.middle) * (1.0 / whole.half)
        return beyond_by(tension + self.weight * pull, 1.0 - x * x, s, work)

    def coordinates(self, work: Work) -> Lanes:
        """Return s at the nodes."""
        return load(work.x)

    def coordinate(self, planes: tuple[Plane, ...]) -> float:
        """Return s."""
        return planes[0].x

    def clear_square(self, omega: Omega, pieces: Pieces, k: int) -> float:
        """Return the y² above which ṡ has the sign of y: the square of A α̇/ω, |A| ≤ √(1 + j).

        θ is zero where s is, so that the tilt does not matter.
        """
        dragged = case_bounds(pieces, k)[1] / omega[0]
        return CLEAR * (1.0 + self.carried * self.carried) * (dragged * dragged)

    def clear(self, square: float, omega: Omega, work: Work) -> bool:
        """Return whether s² + y² exceeds that at all nodes."""
        x, y = load(work.x), load(work.y)
        return least(x * x + y * y) > square

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Outside) -> Instant:
        """Return the lever at an instant."""
        return _instant(self, mode, planes[0].x, omega[0] * planes[0].y, at)

    def drift(self, mode: Mode, omega: Omega, at: Outside, now: Instant) -> tuple[Plane, ...]:
        """Return ṡ and ṗ = s̈ + A α̈ + ṡ α̇ dA/ds."""
        n, w, bend, _, _, _ = _values(self.shape, now.coordinate)
        turn, turned = at.line.rate - at.tilt.rate, at.line.bend - at.tilt.bend
        ride = now.speed * turn * bend * (self.carried * n - w)
        return (Plane(now.speed, now.acceleration + (n + self.carried * w) * turned + ride),)

    def wheel_angle(self, planes: tuple[Plane, ...], at: Outside) -> float:
        """Return θ."""
        return _values(self.shape, planes[0].x)[5]

    def strike(self, mode: Mode, omega: Omega, at: Outside, now: Instant, state: State) -> None:
        """Let an impulse change the momentum: ½ M θ̇² = ½ I ṡ²."""
        rate, plane = now.speed, state.planes[0]
        struck = mode.direction * math.sqrt(rate * rate + self.on_wheel.energy)
        plane.y += (struck - rate) / omega[0]
        plane.y_rest = 0.0


@inlined
def _clenshaw(terms: FloatArray, x: Number, zero: Number) -> OnArc:
    """Return n, w, χ', cos β, sin β and θ by Clenshaw's recurrence, side by side."""
    twice = 2.0 * x
    n = w = bend = cosine = sine = angle = zero
    n_old = w_old = bend_old = cosine_old = sine_old = angle_old = zero
    for j in range(terms.shape[1] - 1, 0, -1):
        n, n_old = fma(twice, n, terms[SHORTENING, j] - n_old), n
        w, w_old = fma(twice, w, terms[RIDE, j] - w_old), w
        bend, bend_old = fma(twice, bend, terms[BEND, j] - bend_old), bend
        cosine, cosine_old = fma(twice, cosine, terms[COSINE, j] - cosine_old), cosine
        sine, sine_old = fma(twice, sine, terms[SINE, j] - sine_old), sine
        angle, angle_old = fma(twice, angle, terms[ANGLE, j] - angle_old), angle
    return (
        fma(x, n, terms[SHORTENING, 0] - n_old),
        fma(x, w, terms[RIDE, 0] - w_old),
        fma(x, bend, terms[BEND, 0] - bend_old),
        fma(x, cosine, terms[COSINE, 0] - cosine_old),
        fma(x, sine, terms[SINE, 0] - sine_old),
        fma(x, angle, terms[ANGLE, 0] - angle_old),
    )


@inlined
def _horner(terms: FloatArray, x: Number, zero: Number) -> OnArc:
    """Return the same by Horner's, side by side."""
    n = w = bend = cosine = sine = angle = zero
    for j in range(terms.shape[1] - 1, -1, -1):
        n = fma(n, x, terms[SHORTENING, j])
        w = fma(w, x, terms[RIDE, j])
        bend = fma(bend, x, terms[BEND, j])
        cosine = fma(cosine, x, terms[COSINE, j])
        sine = fma(sine, x, terms[SINE, j])
        angle = fma(angle, x, terms[ANGLE, j])
    return n, w, bend, cosine, sine, angle


@inlined
def _series_at(series: Series | Powers, s: Number, zero: Number) -> OnArc:
    """Return n, w, χ', cos β, sin β and θ of lanes of s or a float; `zero` is one of that kind."""
    x = (s - series.middle) * (1.0 / series.half)
    if isinstance(series, Powers):
        return _horner(series.terms, x, zero)
    return _clenshaw(series.terms, x, zero)


@compiled
def _shape_at(shape: LeverShape, s: Lanes) -> tuple[Lanes, Lanes, Lanes, Lanes, Lanes]:
    """Return n, w, χ', cos β and sin β of lanes of s."""
    if largest(s - shape.near.middle) <= shape.near.half:
        return _series_at(shape.near, s, filled(s, 0.0))[:5]
    return _series_at(shape.whole, s, filled(s, 0.0))[:5]


@compiled
def _values(shape: LeverShape, s: float) -> OnArc:
    """Return n, w, χ', cos β, sin β and θ."""
    if abs(s - shape.near.middle) <= shape.near.half:
        return _series_at(shape.near, s, 0.0)
    return _series_at(shape.whole, s, 0.0)


@compiled
def _instant(lever: Lever, mode: Mode, s: float, p: float, at: Outside) -> Instant:
    line, tilt, shape = at.line, at.tilt, lever.shape
    n, w, bend, cosine, sine, angle = _values(shape, s)
    dragged = n + lever.carried * w
    turned = line.bend - tilt.bend
    rate = p - dragged * (line.rate - tilt.rate)
    pull = at.gravity * (cosine * math.cos(tilt.value) + sine * math.sin(tilt.value))
    drag = resistance(lever.on_wheel, mode, n * rate)
    bent = -(lever.weight * w * pull + n * drag + dragged * turned)
    tension = w * bent + n * bend * rate * rate + lever.carried * turned
    wheel_bend = n * bent - w * bend * rate * rate
    x = (s - shape.whole.middle) / shape.whole.half
    return Instant(
        angle,
        n * rate,
        wheel_bend,
        tension + lever.weight * pull,
        1.0 - x * x,
        wheel_bend + turned + drag,
        s,
        rate,
        bent,
    )
