"""The wheel as a system: the trochlea in one rotating plane.

Along the angle ϑ, or along the arc where the lever arm is linear and a weight rides along.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

from tauto_core.curves.levers import ArcLever, Lever, LinearLever
from tauto_core.kernels import compiled, inlined
from tauto_core.motion.arc_length import ArcShape
from tauto_core.motion.lanes import Lanes, fma, lane, largest, least, load, store, width
from tauto_core.motion.layout import BEYOND, phase_to
from tauto_core.motion.outside import (
    GRAVITY,
    LINE_RATE,
    TILT_RATE,
    Outside,
    Pieces,
    Place,
    column,
    columns,
    nodes_of,
    outside_at,
)
from tauto_core.motion.passages import CLEAR, bounds_of
from tauto_core.motion.sticking import set_off_or_hold
from tauto_core.motion.system import (
    NOWHERE,
    Beyond,
    Instant,
    Mode,
    Plane,
    State,
    first_below,
)
from tauto_core.motion.wells import (
    Terms,
    angle_at,
    excess,
    fold,
    kick,
    lever_arm,
    mass_of,
    pull_of,
    rate_of,
    resistance,
    ride,
    shape_at,
    term,
    unfold,
)
from tauto_core.motion.work import Omega, Planes, Work
from tauto_core.samples import FloatArray

NODES = 'line_rate', 'line_bend', 'tilt_rate', 'gravity'
"""Rows of γ̇, γ̈, τ̇ and g_eff at the nodes."""

WELL_WITHIN = 0.97
"""Share of the range within which all nodes must lie if the whole step surely lies within the
range.
"""

ANY_MODE = Mode(1.0, 1.0, 1.0)


class Nodes(Protocol):
    """The rows NODES; those of absent channels are not set."""

    line_rate: FloatArray
    line_bend: FloatArray
    tilt_rate: FloatArray
    gravity: FloatArray


class Felt(NamedTuple):
    """Which channels there are: True or None, so that compiled code knows."""

    line: bool | None
    tilt: bool | None
    gravity: bool | None


class Wheel(NamedTuple):
    """The wheel as `system.System`.

    Attributes:
        machine: the terms that act on it.
        lever: arm of the thread.
        shape: the shape of the arc, or None where the angle is the coordinate.
        felt: the channels of the ship's motion that there are.
        impulse, pace: as in `System`.
        range: largest |ϑ| [rad].
        gravity: the acceleration of gravity at rest [m/s2].
    """

    machine: Terms
    lever: Lever
    shape: ArcShape | None
    felt: Felt
    impulse: float
    pace: float
    range: float
    gravity: float

    @property
    def feels_impulse(self) -> bool:
        """Whether an escapement pushes the wheel."""
        return self.machine.impulse is not None

    @property
    def turns_abruptly(self) -> bool:
        """Whether the drag has a kink at the turning points."""
        return self.machine.quadratic is not None or self.machine.coulomb is not None

    @property
    def kinked(self) -> bool:
        """Whether the cam has a kink."""
        return isinstance(self.lever, ArcLever)

    @property
    def sticks(self) -> bool:
        """Whether friction may hold the wheel."""
        return self.machine.coulomb is not None

    @property
    def has_weight(self) -> bool:
        """Whether a weight keeps the thread taut."""
        return self.machine.carried is not None or self.machine.weight is not None

    @property
    def feels_drag(self) -> bool:
        """Whether the motion in the case matters within a step."""
        return self.machine.viscous is not None or self.turns_abruptly

    @property
    def feels_tilt(self) -> bool:
        """Whether the angle in the case matters within a span."""
        return self.feels_drag or self.feels_impulse

    def at_nodes(self, place: Place, work: Work) -> None:
        """Fill γ̇, γ̈, τ̇ and g at the nodes of a step."""
        _fill_nodes(self.felt, self.feels_drag, place, work)

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill what disturbs the plane."""
        if self.shape is not None:
            _along_the_arc(self, self.shape, mode, omega, work)
        else:
            _along_the_angle(self, mode, omega, work)

    def coordinates(self, work: Work) -> Lanes:
        """Return ϑ, or the arc, at the nodes."""
        return load(work.x)

    def coordinate(self, planes: tuple[Plane, ...]) -> float:
        """Return ϑ, or the arc."""
        return planes[0].x

    def beyond(self, mode: Mode, omega: Omega, work: Work) -> Beyond:
        """Return whether the step leaves the cam, or its thread goes slack."""
        return _beyond(self, mode, omega, work)

    def clear_square(self, omega: Omega, pieces: Pieces, k: int) -> float:
        """Return the x² + y² above which the swing is surely clear of the tilt, over a piece.

        While |ϑ| is less than the tilt's bound τ, θ may pass zero. If the momentum then exceeds
        the contribution of the line's motion, ϑ and θ pass zero once each, the same way. With M
        the moment of inertia at ϑ = τ, x² ≤ M τ² there, and the condition is |y| > (M |τ̇| +
        |γ̇|)/ω.
        """
        per = 1.0 / (pieces.length_s[k] * omega[0])
        reach, reach_rate = bounds_of(pieces.tilt, k, per)
        _, line_rate = bounds_of(pieces.line, k, per)
        mass = mass_of(self.machine.carried, lever_arm(self.lever, 1.0, reach)[0])
        pushed = mass * reach_rate + line_rate
        return CLEAR * (mass * reach * reach + pushed * pushed)

    def clear(self, square: float, omega: Omega, work: Work) -> bool:
        """Return whether x² + y² exceeds that at all nodes."""
        x, y = load(work.x), load(work.y)
        return least(x * x + y * y) > square

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Outside) -> Instant:
        """Return the wheel at an instant."""
        return _instant(self, mode, planes[0].x, omega[0] * planes[0].y, at)

    def drift(self, mode: Mode, omega: Omega, at: Outside, now: Instant) -> tuple[Plane, ...]:
        """Return the rates of the coordinate and of the momentum."""
        return _drift(self, mode, at, now)

    def wheel_angle(self, planes: tuple[Plane, ...], at: Outside) -> float:
        """Return θ = ϑ + τ."""
        return angle_at(self, planes[0].x) + at.tilt.value

    def set_off(self, omega: Omega, angle: float, at: Outside, state: State) -> None:
        """Put the wheel at rest at θ = angle, held by friction or about to go."""
        set_off_or_hold(self, omega, angle, at, state)

    def leaves_kink(self, mode: Mode, omega: Omega, planes: Planes, work: Work) -> bool:
        """Return whether the momentum at the beginning outweighs the line's motion."""
        line_rate = felt_row(self.felt.line, work.nodes.line_rate)
        fastest = largest(0.0 * load(work.x) + line_rate)
        return mode.side * (omega[0] * planes[0].y) > fastest

    def strike(self, mode: Mode, omega: Omega, at: Outside, now: Instant, state: State) -> None:
        """Let an impulse change the momentum."""
        machine, q = self.machine, now.coordinate
        if machine.impulse is None:
            return
        t = lever_arm(self.lever, mode.side, q)[0]
        given, d = state.given, mode.direction
        rate = now.speed + kick(machine.impulse, machine.carried, t, now.rate, d, given)
        plane = state.planes[0]
        plane.y = fold(self, q, rate, at.line.rate, mode.side)[1] / omega[0]
        plane.y_rest = 0.0

    def ahead_s(
        self, omega: Omega, length: float, terms: int, x: float, state: State, work: Work
    ) -> float:
        """Return the time to a little after the next expected impulse or kink [s], or inf.

        The swing is assumed to continue about the line, which moves as it does now, at the pace
        that gravity allows on the way.
        """
        ahead, pace = math.inf, omega[0]
        if not (self.turns_abruptly or self.feels_impulse or self.kinked) or state.held:
            return ahead
        line, tilt, gravity = outside_at(terms, x, work)
        plane = state.planes[0]
        q, y = angle_at(self, plane.x), plane.y - line.rate / omega[0]
        if self.feels_impulse:
            way = float(state.direction if state.armed else -state.direction)
            ahead = phase_to(way, q, y, self.impulse - way * tilt.value)
            if ahead < math.inf:
                then = outside_at(terms, min(x + ahead / (pace * length), 1.0), work)
                ahead = phase_to(way, q, y, self.impulse - way * then.tilt.value)
                gravity = 0.5 * (gravity + then.gravity)
        if self.kinked:
            ahead = min(ahead, phase_to(-float(state.side), q, y, 0.0))
        if gravity > 0.0:
            pace *= math.sqrt(gravity / self.gravity)
        return (ahead + BEYOND) / pace


@compiled
def _fill_nodes(felt: Felt, drag: bool, place: Place, work: Work) -> None:
    """Fill the rows of the channels there are; τ̇ only if it is felt."""
    x, terms, nodes = nodes_of(place, work), place.terms, work.nodes
    if felt.line is not None:
        rate, bend = columns(LINE_RATE, terms, x, work)
        store(nodes.line_rate, 0, rate)
        store(nodes.line_bend, 0, bend)
    if drag and felt.tilt is not None:
        store(nodes.tilt_rate, 0, column(TILT_RATE, terms, x, work))
    if felt.gravity is not None:
        store(nodes.gravity, 0, column(GRAVITY, terms, x, work))


@inlined
def felt_row(channel: bool | None, row: FloatArray) -> Lanes:
    """Return a row of the nodes; 0 where its channel is absent."""
    return 0.0 if channel is None else load(row)


@inlined
def _along_the_angle(wheel: Wheel, mode: Mode, omega: Omega, work: Work) -> None:
    machine, lever, felt = wheel.machine, wheel.lever, wheel.felt
    q, w = load(work.x), omega[0] * load(work.y)
    line_rate = felt_row(felt.line, work.nodes.line_rate)
    t, t1, lift = lever_arm(lever, mode.side, q)
    rate = rate_of(machine.carried, t, w, line_rate)
    v = rate + felt_row(felt.tilt, work.nodes.tilt_rate)
    pull = pull_of(machine, lift, felt_row(felt.gravity, work.nodes.gravity))
    per_omega = 1.0 / omega[0]
    more = excess(lever, q, t, pull, omega[0] * omega[0])
    more = more + ride(machine.carried, t, t1, rate) - resistance(machine, v, mode)
    store(work.d1, 0, rate - w)
    store(work.d2, 0, more * per_omega)


@inlined
def _along_the_arc(wheel: Wheel, shape: ArcShape, mode: Mode, omega: Omega, work: Work) -> None:
    machine, felt = wheel.machine, wheel.felt
    s, p = load(work.x), omega[0] * load(work.y)
    n, slope, less, _ = shape_at(shape, s)
    line_rate = felt_row(felt.line, work.nodes.line_rate)
    rate = fma(-line_rate, n, p)
    v = fma(n, rate, felt_row(felt.tilt, work.nodes.tilt_rate))
    pull = pull_of(machine, 0.0, felt_row(felt.gravity, work.nodes.gravity))
    per_omega = 1.0 / omega[0]
    square = fma(pull, less, omega[0] * omega[0] - shape.rate * pull)
    more = s * fma(rate, line_rate * slope, square)
    more = fma(-n, resistance(machine, v, mode), more)
    store(work.d1, 0, -(line_rate * n))
    store(work.d2, 0, more * per_omega)


@compiled
def _instant(wheel: Wheel, mode: Mode, x: float, w: float, at: Outside) -> Instant:
    machine, tilt = wheel.machine, at.tilt
    q, rate = unfold(wheel, x, w, at.line.rate, mode.side)
    t, t1, lift = lever_arm(wheel.lever, mode.side, q)
    v = rate + tilt.rate
    pull = pull_of(machine, lift, at.gravity)
    pushed = at.line.bend + resistance(machine, v, mode) + pull * t
    bend = -(pushed + ride(machine.carried, t, t1, rate)) / mass_of(machine.carried, t)
    tension = pull + term(machine.carried, t1 * (rate * rate) + t * bend)
    margin = wheel.range - abs(q)
    return Instant(
        q + tilt.value, v, bend + tilt.bend, tension, margin, -tension * t, q, rate, bend
    )


@compiled
def _drift(wheel: Wheel, mode: Mode, at: Outside, now: Instant) -> tuple[Plane, ...]:
    machine, rate = wheel.machine, now.speed
    t, t1, lift = lever_arm(wheel.lever, mode.side, now.coordinate)
    resisted = pull_of(machine, lift, at.gravity) * t + resistance(machine, now.rate, mode)
    if wheel.shape is None:
        return (Plane(rate, ride(machine.carried, t, t1, rate) - resisted),)
    k, q = wheel.shape.k, now.coordinate
    n = 1.0 / math.sqrt(1.0 + (k * q) * (k * q))
    bent = -(k * k) * q * (n * n) * (n * n)
    return (Plane(rate / n, rate / n * at.line.rate * bent - n * resisted),)


@compiled
def _at_nodes_felt(wheel: Wheel, mode: Mode, omega: Omega, work: Work) -> tuple[Lanes, Lanes]:
    """Return q and q̇ at the stages."""
    line_rate = felt_row(wheel.felt.line, work.nodes.line_rate)
    if wheel.shape is None:
        q, w = load(work.x), omega[0] * load(work.y)
        t = lever_arm(wheel.lever, mode.side, q)[0]
        return q, rate_of(wheel.machine.carried, t, w, line_rate)
    n, _, _, angle = shape_at(wheel.shape, load(work.x))
    return angle, n * (omega[0] * load(work.y) - line_rate * n)


@compiled
def _tension(wheel: Wheel, mode: Mode, q: Lanes, rate: Lanes, work: Work) -> Lanes:
    """Return the thread's tension over I at the stages."""
    machine, felt = wheel.machine, wheel.felt
    mu = machine.carried
    t, t1, lift = lever_arm(wheel.lever, mode.side, q)
    v = rate + felt_row(felt.tilt, work.nodes.tilt_rate)
    pull = pull_of(machine, lift, felt_row(felt.gravity, work.nodes.gravity))
    pushed = pull * t + resistance(machine, v, mode) + ride(mu, t, t1, rate)
    bend = -(pushed + felt_row(felt.line, work.nodes.line_bend)) / mass_of(mu, t)
    # lanes, whatever the terms are
    return 0.0 * q + (pull + term(mu, t1 * (rate * rate) + t * bend))


@compiled
def _surely_within(wheel: Wheel, omega: Omega, work: Work) -> bool:
    """Return whether rough bounds show that no node is past the edge, and no thread slack."""
    if not isinstance(wheel.lever, LinearLever):
        return False
    # |q| ≤ |x| and M · tension = pull + μ t' q̇² − μ t (γ̈ + resistance), in either coordinate
    machine, felt, x = wheel.machine, wheel.felt, load(work.x)
    none = 0.0 * x
    reach = largest(x)
    line_rate = largest(none + felt_row(felt.line, work.nodes.line_rate))
    line_bend = largest(none + felt_row(felt.line, work.nodes.line_bend))
    tilt_rate = largest(none + felt_row(felt.tilt, work.nodes.tilt_rate))
    speed = omega[0] * largest(load(work.y)) + line_rate + tilt_rate
    pull = pull_of(machine, 0.0, felt_row(felt.gravity, work.nodes.gravity))
    pushed = line_bend + resistance(machine, speed, ANY_MODE)
    against = term(machine.carried, wheel.lever.rate * reach * pushed)
    return reach <= wheel.range and least(none + pull) > against


@compiled
def _beyond(wheel: Wheel, mode: Mode, omega: Omega, work: Work) -> Beyond:
    edge = slack = NOWHERE
    reach = largest(load(work.x))
    within = reach <= WELL_WITHIN * wheel.range
    if _surely_within(wheel, omega, work):
        return Beyond(edge, slack, within, reach)
    q, rate = _at_nodes_felt(wheel, mode, omega, work)
    if largest(q) > wheel.range:
        nodes = load(work.fractions)
        for i in range(width(q) - 1, -1, -1):
            edge = lane(nodes, i) if abs(lane(q, i)) > wheel.range else edge
    if wheel.has_weight:
        slack = first_below(_tension(wheel, mode, q, rate, work), work)
    return Beyond(edge, slack, within, reach)
