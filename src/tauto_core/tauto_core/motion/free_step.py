"""Event-to-event steps: the shared parts, the steps of a wheel, and the steps of a real thread.

`free_end` describes the method.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Protocol

from tauto_core.kernels import inlined
from tauto_core.motion.gauss_step import (
    COSINE,
    PART_STEP,
    SINE,
    Mode,
    Omega,
    Step,
    Work,
    evaluate,
    fill_rotations,
    move_stages,
    rotation,
    start_stages,
)
from tauto_core.motion.lanes import (
    SIZE,
    Lanes,
    filled,
    fma,
    lane,
    row_of,
    splat,
    store,
    total,
)
from tauto_core.motion.stepping import Spans, count_step, signs_at_nodes, step_error
from tauto_core.motion.system import (
    APPARENT_GRAVITY,
    DRIVE_RATE,
    HEAT_POWERS,
    HOT_NUMBERS,
    LEAN,
    NOWHERE,
    TILT_RATE,
    ForcingPieces,
    HeatPieces,
    Inputs,
    Instant,
    Plane,
    RunningState,
    SteppedRun,
    heated_at_nodes,
    heated_now,
    keep,
    outside_of,
    planes_of,
    powers_at,
    set_channels,
    thermal_terms_of,
)
from tauto_core.motion.wells import (
    given_energy,
    kick,
    lever_arm,
    mass_of,
    on_arc,
    pull_of,
    resistance,
)
from tauto_core.motion.wheel import Wheel, angle_at, surely_within
from tauto_core.samples import FloatArray


class FreeEnd(NamedTuple):
    """Settings of event-to-event steps.

    Attributes:
        sweeps: least sweeps of the stages. Each reduces the error by a factor of some 60.
        settled: error, relative to the state, to which the stages are swept.
        error: error allowed in a step, relative to the state.
        near_phase: phase from the impulse within which a step is not repeated [rad].
        close: phase from the impulse within which the ship's motion is extrapolated to it [rad].
        usual_s: half a swing on land [s].
        swing: its largest Y, in the middle [rad].
        slower, slower_yet: first and second coefficient of the relative growth of half a swing's
            duration, in powers of the relative change of Y.
        spent: relative loss of Y by viscous drag in a quarter of a swing.
    """

    sweeps: int
    settled: float
    error: float
    near_phase: float
    close: float
    usual_s: float
    swing: float
    slower: float
    slower_yet: float
    spent: float


SHORTEST, LONGEST = 0.8, 1.2
"""Least and greatest length of a half swing, over half a swing on land."""

MOST_LENGTHS = 4
"""Most lengths tried for a step. The prediction seldom errs by more than `NEAR`."""

MORE_SWEEPS = 12
"""Most additional sweeps."""

ROW_SETTLED = 1e-3
"""Iteration error for a logged row, over `FreeEnd.settled`."""

HOLDS, MISSES, PAST, UNKNOWN, DUE = range(5)
"""A step holds, its assumptions fail, the instant is beyond the impulse, the known spans are too
few, a row is due on the way.
"""


class FreeState(Protocol):
    """The state of event-to-event steps, a record of FREE in compiled code.

    Attributes:
        x, x_rest: x in the first kept span at the beginning of the half swing, as two doubles.
        line_rate: γ̇ there [rad/s].
        gravity: g_eff there [m/s2].
        forth, back: for a real thread, the duration of the last half swing that began with θ̇ > 0,
            and of the last one back, over the prediction. 0 before the first.
        shown: first kept span with an unwritten row.
        waits: next half swings that the driver takes, after a step that did not hold.
        missed: steps that did not hold.
        free: whether the state is just after an impulse or a kink, not at the end of a span.
    """

    x: float
    x_rest: float
    line_rate: float
    gravity: float
    forth: float
    back: float
    shown: int
    waits: int
    missed: int
    free: bool


MOST_SPANS = 12
"""Most spans of forcing in a half swing. With more, the driver's steps are as cheap."""

RING = 16
"""Pieces in the table of `lay_out_pieces`: more than MOST_SPANS, and a power of two."""


@inlined
def _first_row(k: int, powers: int) -> int:
    """Return the first row of piece k in the table; a mask is faster than a remainder."""
    return (k & (RING - 1)) * powers


@inlined
def lay_out_pieces(
    pieces: ForcingPieces, powers: int, begin: int, end: int, table: FloatArray
) -> int:
    """Copy pieces `begin` to `end` into the table of `ship_at`; return the next piece.

    Each power is a row with the columns of `system`. Columns of absent channels stay zero.
    """
    for k in range(begin, end + 1):
        set_channels(pieces, k, True, powers, table, _first_row(k, powers))
    return max(begin, end + 1)


class FreeHalfSwing(NamedTuple):
    """A half swing that begins at an impulse or a kink, and the spans that it may read.

    Attributes:
        system: the wheel, lever or swinging thread.
        k, x: span and x at its beginning.
        last_span: last span that it may read.
        known_s: time from the beginning to the end of `last_span` [s].
        square: x² + y² above which the swing is clear of tilt and impulse.
        bend: bound of |γ̈| [rad/s2].
        powers: number of powers of every channel.
        spans, pieces: the whole forcing.
        table: the pieces to read (`lay_out_pieces`).
    """

    system: Any
    k: int
    x: float
    last_span: int
    known_s: float
    square: float
    bend: float
    powers: int
    spans: Spans
    pieces: ForcingPieces
    table: FloatArray

    @inlined
    def coefficient(self, column: int, k: int, j: int) -> float:
        """Return the coefficient of x^j in a column of piece k."""
        return self.table[(_first_row(k, self.powers) + j) * SIZE + column]


@inlined
def _number(hot: HeatPieces, k: int, which: int, x: Lanes) -> Lanes:
    """Return one of `HeatTerms` at lanes of x of piece k."""
    row, u = hot.interval[k] * HEAT_POWERS, fma(x, hot.size[k], hot.begin[k])
    value = fma(u, hot.terms[row + 3, which], hot.terms[row + 2, which])
    value = fma(value, u, hot.terms[row + 1, which])
    return fma(value, u, hot.terms[row, which])


@inlined
def ship_at(swing: FreeHalfSwing, k: int, x: float) -> Inputs:
    """Return the forcing at x of piece k, with the thermal parameters."""
    pieces = swing.pieces
    values = powers_at(swing.table, _first_row(k, swing.powers), swing.powers, x)
    hot = None
    if pieces.hot is not None:
        terms, row = pieces.hot.terms, pieces.hot.interval[k] * HEAT_POWERS
        u = pieces.hot.begin[k] + pieces.hot.size[k] * x
        numbers = fma(row_of(terms, row + 3), u, row_of(terms, row + 2))
        numbers = fma(fma(numbers, u, row_of(terms, row + 1)), u, row_of(terms, row))
        hot = thermal_terms_of(numbers, 0)
    return outside_of(values, hot)


@inlined
def span_at(swing: FreeHalfSwing, time: float) -> tuple[int, float]:
    """Return span and x a time [s] after the beginning. The last span has no end."""
    k, x, spans, lengths = swing.k, swing.x, swing.spans, swing.pieces.length_s
    remaining = time
    while k < swing.last_span:
        length = (spans.end[k] - x) * lengths[k]
        if remaining < length:
            break
        remaining -= length
        k += 1
        x = spans.begin[k]
    return k, x + remaining / lengths[k]


@inlined
def fill_from_spans(swing: FreeHalfSwing, h: float, work: Work) -> None:
    """Fill the forcing at the nodes of a step of length h [s], each from its span."""
    spans, pieces = swing.spans, swing.pieces
    seconds = row_of(work.fractions) * h
    k, x, since, interval = swing.k, swing.x, 0.0, -1
    while True:
        length = pieces.length_s[k]
        per_s, initial, times = 1.0 / length, k == swing.k, seconds - since
        at = fma(times, per_s, x)
        if isinstance(swing.system, Wheel):
            _keep_wheel(swing, k, at, times, initial, work)
        else:
            swing.system.keep_case(swing, k, at, times, initial, work)
        if pieces.hot is not None and pieces.hot.interval[k] != interval:
            # all pieces of a log interval share one cubic
            interval = pieces.hot.interval[k]
            _keep_hot(pieces.hot, k, at, times, initial, work)
        since += (spans.end[k] - x) * length
        if since >= h or k == swing.last_span:
            break
        k += 1
        x = spans.begin[k]
    if isinstance(swing.system, Wheel):
        store(work.nodes.line_bend, 0, filled(work.fractions, swing.bend))
    else:
        swing.system.complete_case(work)


@inlined
def _keep_wheel(
    swing: FreeHalfSwing, k: int, at: Lanes, times: Lanes, initial: bool, work: Work
) -> None:
    """Keep the channels of a wheel at the nodes in span k and after it."""
    nodes, wheel = work.nodes, swing.system
    channels = wheel.channels
    line = tilt = gravity = lean = filled(work.fractions, 0.0)
    for j in range(swing.powers - 1, -1, -1):
        if channels.line is not None:
            line = fma(line, at, swing.coefficient(DRIVE_RATE, k, j))
        if channels.tilt is not None and wheel.feels_drag:
            tilt = fma(tilt, at, swing.coefficient(TILT_RATE, k, j))
        if channels.gravity is not None:
            gravity = fma(gravity, at, swing.coefficient(APPARENT_GRAVITY, k, j))
        if channels.lean is not None:
            lean = fma(lean, at, swing.coefficient(LEAN, k, j))
    if channels.line is not None:
        keep(nodes.line_rate, times, initial, line)
    if channels.tilt is not None and wheel.feels_drag:
        keep(nodes.tilt_rate, times, initial, tilt)
    if channels.gravity is not None:
        keep(nodes.gravity, times, initial, gravity)
    if channels.lean is not None:
        keep(nodes.lean, times, initial, lean)


@inlined
def _keep_hot(hot: HeatPieces, k: int, at: Lanes, times: Lanes, initial: bool, work: Work) -> None:
    """Keep the thermal parameters at the nodes in span k and after it."""
    for i in range(HOT_NUMBERS):
        keep(work.nodes.hot, times, initial, _number(hot, k, i, at), i)


@inlined
def arc_sine(x: float) -> float:
    """Return arcsin x, |x| < 0.6, to a thousandth."""
    square = x * x
    return x * fma(square, fma(square, fma(square, 15 / 336, 3 / 40), 1 / 6), 1.0)


AT_ENDS = 1.0 / 3.0 - 2.0 / (math.pi * math.pi)
"""Weight of gravity at the ends of half a swing in its mean over sin² of the phase."""


@inlined
def longer_by_gravity(
    swing: FreeHalfSwing, free: FreeState, middle: Inputs, then: Inputs
) -> float:
    """Return the duration of half a swing over its duration in gravity at rest.

    Gravity, a parabola in time through the ends and the `middle`, is weighted with the square of
    the swing. `then` is the end of the half swing.
    """
    ends = 0.5 * (free.gravity + then.gravity) - middle.gravity
    # (1 + more)^(−1/2)
    excess = (middle.gravity + AT_ENDS * ends) / swing.system.gravity - 1.0
    return 1.0 - excess * (0.5 - excess * (0.375 - excess * 0.3125))


@inlined
def _predicted(run: SteppedRun, swing: FreeHalfSwing, free: FreeState, usual_s: float) -> float:
    """Return the time to the next impulse [s] on a harmonic swing about its centre.

    The acceleration of the neutral line in the middle of the half swing shifts the centre.
    """
    wheel, plane, way = swing.system, run.state.planes[0], -float(run.state.direction)
    k, x = span_at(swing, usual_s)
    then = ship_at(swing, k, x)
    k, x = span_at(swing, 0.5 * usual_s)
    middle = ship_at(swing, k, x)
    shift = middle.drive.bend / (run.omega[0] * run.omega[0])
    q, y = angle_at(wheel, plane.x) + shift, plane.y - free.line_rate / run.omega[0]
    per_size = 1.0 / math.sqrt(q * q + y * y)
    since, until = (
        -way * q * per_size,
        (wheel.impulse - way * (then.tilt.value - shift)) * per_size,
    )
    # gravity hardly changes the time near the middle of the swing
    correction = (arc_sine(until) - arc_sine(since)) * (usual_s / math.pi)
    if wheel.channels.gravity is not None:
        return usual_s * longer_by_gravity(swing, free, middle, then) + correction
    return usual_s + correction


@inlined
def moving(wheel: Wheel, mode: Mode, omega: Omega, plane: Plane, at: Inputs) -> Instant:
    """Return the wheel at an instant, along the arc by its polynomials, without a division.

    Tension, margin and torque, which no step needs, are missing along the arc.
    """
    if wheel.shape is None:
        now = wheel.instant(mode, omega, (plane,), at)
        return Instant(
            now.angle,
            now.rate,
            now.bend,
            now.tension,
            now.margin,
            now.torque,
            now.coordinate,
            now.speed,
            now.acceleration,
            wheel.drift(mode, omega, at, now),
        )
    per_inertia, line, tilt = heated_now(wheel, at).per_inertia, at.drive, at.tilt
    s, w = plane.x, omega[0] * plane.y
    arc = on_arc(wheel.shape, splat(s))
    n, slope, q = lane(arc.n, 0), s * lane(arc.n_slope, 0), lane(arc.angle, 0)
    arc_speed = fma(-line.rate, n, w)
    speed = n * arc_speed
    rate = speed + tilt.rate
    pull = pull_of(per_inertia, 0.0, at.gravity)
    # (methods.2), with nt = s (b − deficit)
    against = s * (wheel.shape.rate - lane(arc.lever_deficit, 0)) * pull
    w_rate = arc_speed * line.rate * slope - against - n * resistance(per_inertia, rate, mode)
    if per_inertia.growth is not None:
        w_rate = w_rate - per_inertia.growth * w
    bend = w_rate - (line.bend * n + line.rate * slope * arc_speed)
    acceleration = n * bend + slope * arc_speed * arc_speed
    return Instant(
        angle=q + tilt.value,
        rate=rate,
        bend=acceleration + tilt.bend,
        tension=0.0,
        margin=0.0,
        torque=0.0,
        coordinate=q,
        speed=speed,
        acceleration=acceleration,
        drift=(Plane(arc_speed, w_rate),),
    )


@inlined
def _late(wheel: Wheel, way: float, now: Instant, omega: Omega, struck: bool) -> float:
    """Return the short time to the impulse, or to the kink of the cam [s]."""
    if struck:
        return time_until(wheel.impulse - way * now.angle, way, now.rate, now.bend, omega)
    return time_until(-way * now.coordinate, way, now.speed, now.acceleration, omega)


@inlined
def time_until(angle: float, way: float, rate: float, bend: float, omega: Omega) -> float:
    """Return the time of a small rotation [s], to the third order, as `events.back_to`."""
    per_rate = 1.0 / rate
    late = way * angle * per_rate
    turned, phase = late * bend * per_rate, omega[0] * late
    return late * (1.0 - 0.5 * turned * (1.0 - turned) + phase * phase * (1 / 6))


@inlined
def given_by_impulse(
    wheel: Wheel,
    mode: Mode,
    goal: Plane,
    omega: Omega,
    now: Instant,
    at: Inputs,
    late: float,
    count: int,
) -> float:
    """Return the change of Y by an impulse a short time after an instant.

    As `Wheel.strike`, with ϑ, γ̇ and τ̇ extrapolated by their derivatives.
    """
    per_inertia, line, tilt = heated_now(wheel, at).per_inertia, at.drive, at.tilt
    if per_inertia.impulse is None:
        return 0.0
    way, w, per_omega = mode.direction, omega[0] * goal.y, 1.0 / omega[0]
    energy = given_energy(per_inertia.impulse, count)
    line_rate, tilt_rate = line.rate + late * line.bend, tilt.rate + late * tilt.bend
    if wheel.shape is None:
        q = now.coordinate + late * (now.speed + 0.5 * late * now.acceleration)
        mass = mass_of(per_inertia.carried, lever_arm(wheel.lever, mode.side, q).t)
        rate = (w - line_rate) / mass + tilt_rate
        return kick(energy / mass, rate, way) * mass * per_omega
    arc = on_arc(wheel.shape, splat(goal.x))
    n, kq = lane(arc.n, 0), wheel.shape.k * lane(arc.angle, 0)
    rate = n * (w - line_rate * n) + tilt_rate
    # the mass is 1/n², and ṡ changes by 1/n = n (1 + k²ϑ²) times the change of ϑ̇
    return kick(energy * (n * n), rate, way) * (n * (1.0 + kq * kq)) * per_omega


@inlined
def _fill_rotations(omega: Omega, h: float, work: Work) -> None:
    """Fill the rotations to the nodes: by πξ from a table, and by (ωh − π)ξ in a short series."""
    nodes, rotation_at_end, excess = work.nodes, work.rotations[PART_STEP], omega[0] * h - math.pi
    sine, versine = _small_rotation(row_of(work.fractions) * excess)
    cosine_0, sine_0 = row_of(nodes.half_cosine), row_of(nodes.half_sine)
    store(work.cosine, PART_STEP, cosine_0 - fma(sine_0, sine, cosine_0 * versine))
    store(work.sine, PART_STEP, sine_0 + fma(cosine_0, sine, -(sine_0 * versine)))
    rotation_at_end.cos, rotation_at_end.sin = _half_turn(omega[0] * h)
    # mark the rows as unusable for `gauss_step.fill_rotations`
    rotation_at_end.h = math.nan


@inlined
def _small_rotation(angle: Any) -> Any:
    """Return sin and 1 − cos of small lanes or a small float."""
    square = angle * angle
    sine, versine = fma(square, SINE[6], SINE[5]), fma(square, COSINE[6], COSINE[5])
    for j in range(4, -1, -1):
        sine, versine = fma(sine, square, SINE[j]), fma(versine, square, COSINE[j])
    return sine * angle, versine * square


@inlined
def _half_turn(angle: float) -> tuple[float, float]:
    """Return cos and sin of an angle near π."""
    sine, versine = _small_rotation(angle - math.pi)
    return versine - 1.0, -sine


class StepEnd(NamedTuple):
    """U and V at the end of a step, and the rotation to X and Y."""

    u: float
    v: float
    cosine: float
    sine: float

    @property
    def plane(self) -> Plane:
        """X and Y."""
        return Plane(
            self.cosine * self.u + self.sine * self.v, self.cosine * self.v - self.sine * self.u
        )


@inlined
def _ends(run: SteppedRun, h: float) -> tuple[StepEnd, ...]:
    """Return the end of the step last collocated for each plane."""
    work, omega = run.work, run.omega
    weights = row_of(work.quadrature)
    ends: tuple[StepEnd, ...] = ()
    for p in range(len(omega)):
        start, turn = run.state.planes[p], work.rotations[PART_STEP * len(omega) + p]
        u = start.x + h * total(weights * row_of(work.k1, p))
        v = start.y + h * total(weights * row_of(work.k2, p))
        ends = (*ends, StepEnd(u, v, turn.cos, turn.sin))
    return ends


@inlined
def _end_later(run: SteppedRun, h: float, late: float, end: StepEnd, drift: Plane) -> Plane:
    """Return the state a short time `late` [s] after the end of a step.

    The slopes follow from the state at the end, and their derivatives from the step's polynomial.
    """
    work, nodes, w = run.work, run.work.nodes, run.omega[0]
    eta, plane = late / h, end.plane
    d1, d2 = drift.x - w * plane.y, drift.y / w + w * plane.x
    k1, k2 = end.cosine * d1 - end.sine * d2, end.sine * d1 + end.cosine * d2
    weights = fma(row_of(nodes.third), eta, row_of(nodes.second))
    weights = fma(weights, eta, row_of(nodes.first)) * (eta * eta * h)
    u = end.u + (late * k1 + total(weights * row_of(work.k1)))
    v = end.v + (late * k2 + total(weights * row_of(work.k2)))
    if run.system.kinked:
        cosine, sine = rotation(w * (h + late))
    else:
        cosine, sine = _half_turn(w * (h + late))
    return StepEnd(u, v, cosine, sine).plane


@inlined
def holds(run: SteppedRun, swing: FreeHalfSwing, mode: Mode, error: float, h: float) -> bool:
    """Return whether a step is exact enough, within range, and clear of tilt and impulse."""
    system, omega, work = swing.system, run.omega, run.work
    tail, last_term, size = row_of(work.tail), 0.0, 0.0
    for p in range(len(omega)):
        start = run.state.planes[p]
        last_term = max(last_term, abs(total(tail * row_of(work.k1, p))))
        last_term = max(last_term, abs(total(tail * row_of(work.k2, p))))
        size = max(size, start.x * start.x + start.y * start.y)
    if not step_error(run.tolerance.factor, last_term * h / math.sqrt(size)) <= error:
        return False
    if not system.clear(swing.square, omega, work):
        return False
    if isinstance(system, Wheel) and system.has_weight:
        # rough bounds only, since the row of γ̈ is a bound
        return surely_within(heated_at_nodes(system, work), mode, omega, work)
    exits = system.exits(mode, omega, work)
    return exits.is_within and exits.edge > 1.0 and exits.slack > 1.0 and not exits.is_near


@inlined
def settle(step: Step, sweeps: int, floor: float, has_stages: bool) -> bool:
    """Sweep the stages at least `sweeps` times and return whether they have settled to `floor`.

    As `gauss_step.sweep`, but changes are compared only from sweep `sweeps` on. If it `has_stages`
    of a step of about this length, the first sweep uses their slopes.
    """
    old_change = change = math.inf
    for n in range(sweeps + MORE_SWEEPS):
        if n > 0 or not has_stages:
            evaluate(step)
        if n >= sweeps and (change <= floor or change * change <= floor * (old_change - change)):
            return True
        moved = move_stages(step)
        if n >= sweeps - 2:
            old_change, change = change, moved
    return False


AT_ONCE = 1e-9
"""Phase between kink and impulse within which both are simultaneous [rad]."""

SHORT, MOST_LATE = 0.3, 0.05
"""Longest step between kink and impulse, over half a swing on land, and the largest error of a
predicted length, over the length, without a repetition of the step.
"""

ONWARD_SWEEPS = 2
"""Least sweeps of a step between kink and impulse."""


@inlined
def _goes_on(wheel: Wheel, state: RunningState) -> bool:
    """Return whether a kink or an impulse comes before the turning point of θ."""
    return wheel.kinked and (state.armed or state.side * state.direction < 0)


@inlined
def _expected_on_wheel_s(
    run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> float:
    """Return the time to the next kink or impulse, whichever comes first [s]."""
    if not swing.system.kinked:
        return _predicted(run, swing, free, free_end.usual_s)
    wheel, state, plane = swing.system, run.state, run.state.planes[0]
    d, q, y = float(state.direction), plane.x, plane.y - free.line_rate / run.omega[0]
    per_size = 1.0 / math.sqrt(q * q + y * y)
    if _goes_on(wheel, state):
        reach = 0.0
        if state.armed:
            k, x = span_at(swing, 0.0)
            reach = wheel.impulse - d * ship_at(swing, k, x).tilt.value
        return (arc_sine(reach * per_size) - arc_sine(d * q * per_size)) / run.omega[0]
    k, x = span_at(swing, free_end.usual_s)
    then, quicker = ship_at(swing, k, x), 1.0
    k, x = span_at(swing, 0.5 * free_end.usual_s)
    middle = ship_at(swing, k, x)
    # in the middle of the half swing the acceleration of the neutral line shifts the centre
    shift = d * middle.drive.bend / (run.omega[0] * run.omega[0])
    since = arc_sine((d * q + shift) * per_size)
    if wheel.channels.gravity is not None:
        quicker = longer_by_gravity(swing, free, middle, then)
    # the time from kink to kink depends on the swing, and the swing of a given Y on gravity
    larger_by = quicker / (per_size * free_end.swing) - 1.0 - free_end.spent
    time = 1.0 + larger_by * (free_end.slower + larger_by * free_end.slower_yet)
    half_s = free_end.usual_s * quicker * time
    reach = min(0.0, wheel.impulse + d * then.tilt.value)
    return half_s + (arc_sine((reach - shift) * per_size) - since) / run.omega[0]


@inlined
def _act(
    run: SteppedRun,
    swing: FreeHalfSwing,
    free: FreeState,
    mode: Mode,
    struck: bool,
    goal: Plane,
    at: Inputs,
    now: Instant,
    since: float,
) -> None:
    """Apply an impulse or the kink to the state `goal`, a short time after an instant."""
    state, plane, turns = run.state, run.state.planes[0], not _goes_on(swing.system, run.state)
    added = 0.0
    if struck:
        added = given_by_impulse(swing.system, mode, goal, run.omega, now, at, since, state.given)
    plane.x, plane.x_rest, plane.y_rest = goal.x, 0.0, 0.0
    plane.y = goal.y + added
    free.line_rate, free.gravity = at.drive.rate + since * at.drive.bend, at.gravity
    if turns:
        state.direction = -state.direction
    if struck:
        state.armed, state.pallet = False, state.direction
        state.given += 1
    else:
        state.armed, state.side = turns, -state.side


@inlined
def _prepare(step: Step, wheel: Wheel, has_stages: bool, onward: bool) -> None:
    """Fill the rotations and the first stages: on land over a half swing, else the state."""
    work, plane = step.work, step.planes[0]
    if wheel.kinked:
        fill_rotations(step)
    else:
        _fill_rotations(step.omega, step.h, work)
    if onward and not has_stages:
        start_stages(step)
    elif not has_stages:
        store(work.u, 0, fma(row_of(work.nodes.land_u), plane.y, plane.x))
        store(work.v, 0, fma(row_of(work.nodes.land_v), plane.y, plane.y))


@inlined
def _to_event(
    run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step a wheel to the next event, as `to_next`.

    On a kinked cam a step continues the law of its first side over the kink, and its end gives the
    times of kink and impulse. A half swing is a long step over the turning point and a short one
    between both events, which differ by the tilt of the neutral line.
    """
    wheel, omega, state, work = swing.system, run.omega, run.state, run.work
    plane, usual_s, onward = state.planes[0], free_end.usual_s, _goes_on(wheel, state)
    way = float(state.direction) if onward else -float(state.direction)
    mode = Mode(float(state.side), way, float(state.pallet))
    h = _expected_on_wheel_s(run, swing, free, free_end)
    struck = state.armed or not wheel.kinked
    shortest, longest, least_sweeps = SHORTEST * usual_s, LONGEST * usual_s, free_end.sweeps
    if onward:
        shortest, longest, least_sweeps = 0.0, SHORT * usual_s, ONWARD_SWEEPS
        if omega[0] * abs(h) < AT_ONCE:
            k, x = span_at(swing, 0.0)
            at, goal = ship_at(swing, k, x), Plane(plane.x, plane.y)
            _act(
                run, swing, free, mode, struck, goal, at, moving(wheel, mode, omega, goal, at), 0.0
            )
            return HOLDS, 0.0
    for n in range(MOST_LENGTHS):
        if not shortest < h < longest:
            break
        fill_from_spans(swing, h, work)
        # before the sweeps, in parallel with which it is computed
        k, x = span_at(swing, h)
        at = ship_at(swing, k, x)
        step = Step(wheel, mode, omega, h, PART_STEP, state.planes, work)
        _prepare(step, wheel, n > 0, onward)
        if not settle(step, least_sweeps, free_end.settled * abs(plane.y), n > 0):
            break
        end = _ends(run, h)[0]
        now = moving(wheel, mode, omega, end.plane, at)
        if not (way * now.rate > 0.0 and (not wheel.kinked or way * now.speed > 0.0)):
            break
        late = _late(wheel, way, now, omega, True)
        if wheel.kinked:
            kink = _late(wheel, way, now, omega, False)
            if not onward:
                struck = late < kink
            late = late if struck else kink
        if omega[0] * abs(late) > free_end.near_phase or (
            wheel.kinked and abs(late) > MOST_LATE * h
        ):
            h += late
            continue
        if not holds(run, swing, mode, free_end.error, h):
            break
        signs = signs_at_nodes(wheel.coordinates(work), plane.x < 0.0, NOWHERE, work)
        goal, since = _end_later(run, h, late, end, now.drift[0]), late
        if omega[0] * abs(late) > free_end.close:
            # evaluate once more at the expected event
            k, x = span_at(swing, h + late)
            at, drift = ship_at(swing, k, x), now.drift[0]
            now = moving(wheel, mode, omega, goal, at)
            since = _late(wheel, way, now, omega, struck)
            late += since
            goal = _end_later(run, h, late, end, drift)
        _act(run, swing, free, mode, struck, goal, at, now, since)
        count_step(True, signs, run, 0, 0.0)
        return HOLDS, h + late
    return MISSES, 0.0


# -----------------------------------------------------------------------------
# Event-to-event steps of Sully's lever and of the swinging thread: from impulse to impulse.
#
# The length of a step is predicted from the ship's motion in its middle, and from the error of the
# prediction for the last half swing in the same direction. Few predictions are near, so the length
# is corrected before the last two sweeps of the stages.

SHORTEST_ON_THREAD, LONGEST_ON_THREAD = 0.6, 1.5
"""The same lengths for a real thread, which the sea moves more."""

LIKELY = 0.7, 1.3
"""Range of the length for the first sweeps, over half a swing on land."""

LATER_SWEEPS = 2
"""Least sweeps after each correction of the length: two show whether the stages settle."""


@inlined
def time_to_impulse(run: SteppedRun, swing: FreeHalfSwing, usual_s: float) -> float:
    """Return the approximate time to the next impulse [s].

    On a harmonic swing about its centre, as in `ThreadSystem.ahead_s`, with gravity and the shift
    of the centre in the middle of the half swing. An arc tangent would cost as much as a sweep.
    """
    system, state = swing.system, run.state
    way = -float(state.direction)
    mode = Mode(float(state.side), way, float(state.pallet))
    k, x = span_at(swing, 0.5 * usual_s)
    at = ship_at(swing, k, x)
    now = system.instant(mode, run.omega, planes_of(run.omega, state.planes), at)
    pace = system.pace * math.sqrt(at.gravity / system.on_wheel.gravity)
    shift = now.bend / (pace * pace)
    per_pace = 1.0 / pace
    y = now.rate * per_pace
    per_size = 1.0 / math.sqrt(shift * shift + y * y)
    since, until = way * shift, system.impulse - way * (now.angle + shift)
    return (math.pi + arc_sine(until * per_size) - arc_sine(since * per_size)) * per_pace


@inlined
def lasting(run: SteppedRun, free: FreeState) -> float:
    """Return the duration of the last half swing in this direction over its prediction."""
    factor = free.forth if run.state.direction > 0 else free.back
    return factor if factor > 0.0 else 1.0


@inlined
def _planes_at(run: SteppedRun, ends: tuple[StepEnd, ...]) -> tuple[Plane, ...]:
    """Return X and Y of each plane at the end of a step."""
    planes: tuple[Plane, ...] = ()
    for p in range(len(run.omega)):
        planes = (*planes, ends[p].plane)
    return planes


@inlined
def _planes_later(
    run: SteppedRun, h: float, late: float, ends: tuple[StepEnd, ...], drift: tuple[Plane, ...]
) -> tuple[Plane, ...]:
    """Return X and Y of each plane a short time after the end of a step, as `end_later`."""
    work, nodes, omega, eta = run.work, run.work.nodes, run.omega, late / h
    weights = fma(row_of(nodes.third), eta, row_of(nodes.second))
    weights = fma(weights, eta, row_of(nodes.first)) * (eta * eta * h)
    planes: tuple[Plane, ...] = ()
    for p in range(len(omega)):
        w, (u, v, c, s) = omega[p], ends[p]
        x, y = c * u + s * v, c * v - s * u
        d1, d2 = drift[p].x - w * y, drift[p].y / w + w * x
        u += late * (c * d1 - s * d2) + total(weights * row_of(work.k1, p))
        v += late * (s * d1 + c * d2) + total(weights * row_of(work.k2, p))
        x, y = c * u + s * v, c * v - s * u
        angle = w * late
        square = angle * angle
        versine = 0.5 * square * (1.0 - square / 12.0)
        sine = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0))
        planes = (*planes, Plane(x - versine * x + sine * y, y - versine * y - sine * x))
    return planes


@inlined
def _moved_on(now: Instant, late: float, pace: float) -> Instant:
    """Return the fields that `strike` needs a short time after an instant of a harmonic swing."""
    reduction = 0.5 * (pace * late) * (pace * late)
    return Instant(
        angle=now.angle,
        rate=now.rate + late * now.bend - reduction * now.rate,
        bend=now.bend,
        tension=now.tension,
        margin=now.margin,
        torque=now.torque,
        coordinate=now.coordinate + late * (now.speed + 0.5 * late * now.acceleration),
        speed=now.speed + late * now.acceleration - reduction * now.speed,
        acceleration=now.acceleration,
    )


@inlined
def _to_impulse_on_thread(
    run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step a lever or a swinging thread to the next impulse, as `to_next`."""
    system, omega, state, work = swing.system, run.omega, run.state, run.work
    way, usual_s, pace = -float(state.direction), free_end.usual_s, system.pace
    mode = Mode(float(state.side), way, float(state.pallet))
    size = 0.0
    for p in range(len(omega)):
        size = max(size, abs(state.planes[p].y))
    expected = time_to_impulse(run, swing, usual_s)
    h = expected * lasting(run, free)
    h = min(max(h, LIKELY[0] * usual_s), LIKELY[1] * usual_s)
    for n in range(MOST_LENGTHS):
        if not SHORTEST_ON_THREAD * usual_s < h < LONGEST_ON_THREAD * usual_s:
            return MISSES, 0.0
        fill_from_spans(swing, h, work)
        step = Step(system, mode, omega, h, PART_STEP, state.planes, work)
        fill_rotations(step)
        if n == 0:
            start_stages(step)
        least_sweeps = max(free_end.sweeps - LATER_SWEEPS, 1) if n == 0 else LATER_SWEEPS
        if not settle(step, least_sweeps, free_end.settled * size, n > 0):
            return MISSES, 0.0
        k, x = span_at(swing, h)
        at, ends = ship_at(swing, k, x), _ends(run, h)
        now = system.instant(mode, omega, _planes_at(run, ends), at)
        if not way * now.rate > 0.0:
            return MISSES, 0.0
        remaining = system.impulse - way * now.angle
        late = time_until(remaining, way, now.rate, now.bend, (pace,))
        if n == 0 or pace * abs(late) > free_end.near_phase:
            h += late
            continue
        if not holds(run, swing, mode, free_end.error, h):
            return MISSES, 0.0
        below = system.coordinate(planes_of(omega, state.planes)) < 0.0
        signs = signs_at_nodes(system.coordinates(work), below, NOWHERE, work)
        targets = _planes_later(run, h, late, ends, system.drift(mode, omega, at, now))
        for p in range(len(omega)):
            plane = state.planes[p]
            plane.x, plane.y, plane.x_rest, plane.y_rest = targets[p].x, targets[p].y, 0.0, 0.0
        system.strike(mode, omega, at, _moved_on(now, late, pace), state)
        state.direction = -state.direction
        state.armed, state.pallet = False, state.direction
        state.given += 1
        count_step(True, signs, run, 0, 0.0)
        if state.direction < 0:
            free.forth = (h + late) / expected
        else:
            free.back = (h + late) / expected
        return HOLDS, h + late
    return MISSES, 0.0


# -----------------------------------------------------------------------------
# The step of any system.


@inlined
def to_next(
    run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next event and apply it (HOLDS), or leave the state unchanged (MISSES).

    Returns the code and the length of the step [s].
    """
    if isinstance(swing.system, Wheel):
        return _to_event(run, swing, free, free_end)
    return _to_impulse_on_thread(run, swing, free, free_end)


@inlined
def expected_s(run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd) -> float:
    """Return the expected time to the next event [s]."""
    if isinstance(swing.system, Wheel):
        return _expected_on_wheel_s(run, swing, free, free_end)
    return time_to_impulse(run, swing, free_end.usual_s) * lasting(run, free)


@inlined
def is_past(wheel: Wheel, state: RunningState, now: Instant) -> bool:
    """Return whether the next event of a state precedes an instant."""
    onward = _goes_on(wheel, state)
    way = float(state.direction) if onward else -float(state.direction)
    struck = (state.armed or not onward) and not way * now.angle < wheel.impulse
    crossed = wheel.kinked and not state.armed and not state.side * now.coordinate > 0.0
    return (onward or way * now.rate > 0.0) and (struck or crossed)
