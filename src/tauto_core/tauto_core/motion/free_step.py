"""A free-end step: from impulse to impulse, of a length that is solved with its stages.

Its length is predicted, and corrected by θ/θ̇ at its end when the stages are nearly settled. It
reads as many spans of forcing as it covers. First what such steps share, then those of a wheel,
then those of a real thread. `free_end` has the whole.
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
    rotation,
    start_stages,
)
from tauto_core.motion.lanes import (
    WIDE_SIZE,
    Lanes,
    filled,
    fma,
    folded_both,
    lane,
    larger,
    largest,
    row_of,
    splat,
    store,
    total,
)
from tauto_core.motion.stepping import Spans, count_step, signs_at_nodes, step_error
from tauto_core.motion.system import (
    APPARENT_GRAVITY,
    DRIVE,
    DRIVE_BEND,
    DRIVE_RATE,
    HEAT_POWERS,
    LEAN,
    NOWHERE,
    TILT,
    TILT_BEND,
    TILT_RATE,
    ForcingPieces,
    HeatPieces,
    Inputs,
    Instant,
    Plane,
    SteppedRun,
    hot_of,
    keep,
    outside_of,
    planes_of,
    powers_at,
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
from tauto_core.motion.wheel import Wheel, angle_at, surely_within, wheel_at_nodes, wheel_now
from tauto_core.samples import FloatArray


class FreeEnd(NamedTuple):
    """How free-end steps are taken.

    Attributes:
        sweeps: least sweeps of the stages; each takes a factor of some 60 off the error.
        settled: share of the state that the last sweep may have left; more are made until then.
        error: error allowed in a step, relative to the state.
        near_phase: phase from the impulse within which a step is not repeated [rad].
        close: phase from the impulse within which the ship's motion is carried on to it [rad].
        usual_s: half a swing on land [s].
        swing: its largest Y, in the middle [rad].
        slower, slower_yet: by how much half a swing lasts longer, relative to `usual_s`, as the
            coefficients of the first and second power of the relative change of Y.
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
"""Least and greatest length of a half swing, over that on land."""

MOST_LENGTHS = 4
"""Most lengths tried of one step; its prediction seldom errs by more than `NEAR`."""

MORE_SWEEPS = 12
"""Most sweeps beyond the number set."""

ROW_SETTLED = 1e-3
"""How far the stages settle for a logged row, over `FreeEnd.settled`."""

HOLDS, MISSES, PAST, UNKNOWN, DUE = range(5)
"""A step holds; its assumptions fail; the instant wanted lies beyond the impulse; the spans known
do not reach; a row is due on the way.
"""


class FreeState(Protocol):
    """Where free-end steps are: a record of FREE in compiled code.

    Attributes:
        x, x_rest: where in the first span kept the half swing began, as two doubles.
        line_rate: γ̇ there [rad/s].
        gravity: g_eff there [m/s2].
        forth, back: of a real thread, the last half swing with θ̇ > 0 at its beginning, and the
            last one back, over the time expected; 0 before the first.
        shown: first of the spans kept whose row, if any, is not written yet.
        waits: half swings to come that the driver takes, after a step that did not hold.
        missed: steps that did not hold.
        free: whether the state is that just after an impulse or a kink; otherwise at the end of a
            span.
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


class Rates(NamedTuple):
    """Coefficients of x^j of γ̇ and τ̇ over the pieces [rad/s]; None where a channel is absent.

    They have as many powers as the channels, which all have the same number.
    """

    line: FloatArray | None
    tilt: FloatArray | None


@inlined
def fill_rates(pieces: ForcingPieces, rates: Rates) -> None:
    """Fill the coefficients of the time derivatives."""
    _fill_rate(pieces.drive, pieces, rates.line)
    _fill_rate(pieces.tilt, pieces, rates.tilt)


@inlined
def _fill_rate(
    channel: FloatArray | None, pieces: ForcingPieces, rates: FloatArray | None
) -> None:
    """Fill the coefficients of the time derivative of a channel."""
    if channel is None or rates is None:
        return
    powers = channel.shape[1]
    for i in range(channel.shape[0]):
        per_s = 1.0 / pieces.length_s[i]
        for j in range(1, powers):
            rates[i, j - 1] = channel[i, j] * (j * per_s)
        rates[i, powers - 1] = 0.0


MOST_SPANS = 12
"""Most spans of forcing in a half swing; with more the driver's steps are as cheap."""

RING = 16
"""Pieces that are laid out at a time, more than those."""


@inlined
def lay_out_pieces(
    pieces: ForcingPieces, rates: Rates, powers: int, begin: int, end: int, table: FloatArray
) -> int:
    """Lay out pieces for `ship_at`, in the columns of `system`; return the next one after them.

    The row of a power of piece k follows those of lower powers, from `k % RING * powers` on.
    Columns of absent channels stay zero.
    """
    for k in range(begin, end + 1):
        row, per_s = k % RING * powers, 1.0 / pieces.length_s[k]
        line = tilt = 0.0
        for j in range(powers - 1, -1, -1):
            if pieces.drive is not None and rates.line is not None:
                table[row + j, DRIVE_BEND] = (j + 1.0) * per_s * line
                line = rates.line[k, j]
                table[row + j, DRIVE], table[row + j, DRIVE_RATE] = (pieces.drive[k, j], line)
            if pieces.tilt is not None and rates.tilt is not None:
                table[row + j, TILT_BEND] = (j + 1.0) * per_s * tilt
                tilt = rates.tilt[k, j]
                table[row + j, TILT], table[row + j, TILT_RATE] = pieces.tilt[k, j], tilt
            if pieces.gravity is not None:
                table[row + j, APPARENT_GRAVITY] = pieces.gravity[k, j]
            if pieces.lean is not None:
                table[row + j, LEAN] = pieces.lean[k, j]
    return max(begin, end + 1)


class FreeHalfSwing(NamedTuple):
    """A half swing that begins at an impulse or a kink, and the spans that it may read.

    Attributes:
        system: what swings: a wheel, a lever or a swinging thread.
        k, x: span, and x of its piece, where it begins.
        last_span: last span that it may read.
        known_s: time from the beginning to the end of that [s].
        square: x² + y² above which the swing is clear of tilt and impulse.
        bend: bound of |γ̈| [rad/s2].
        powers: number of powers of every channel.
        spans, pieces, rates: all of them.
        table: those read, as `lay_out_pieces` has them.
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
    rates: Rates
    table: FloatArray


@inlined
def _number(hot: HeatPieces, k: int, which: int, x: Lanes) -> Lanes:
    """Return one of `HeatTerms` at lanes of x of piece k."""
    row, u = hot.interval[k] * HEAT_POWERS, fma(x, hot.size[k], hot.begin[k])
    value = fma(u, hot.terms[row + 3, which], hot.terms[row + 2, which])
    value = fma(value, u, hot.terms[row + 1, which])
    return fma(value, u, hot.terms[row, which])


@inlined
def ship_at(swing: FreeHalfSwing, k: int, x: float) -> Inputs:
    """Return the forcing at x of piece k, and the machine's numbers."""
    pieces = swing.pieces
    values = powers_at(swing.table, k % RING * swing.powers, swing.powers, x)
    hot = None
    if pieces.hot is not None:
        terms, row = pieces.hot.terms, pieces.hot.interval[k] * HEAT_POWERS
        u = pieces.hot.begin[k] + pieces.hot.size[k] * x
        numbers = fma(row_of(terms, row + 3), u, row_of(terms, row + 2))
        numbers = fma(fma(numbers, u, row_of(terms, row + 1)), u, row_of(terms, row))
        hot = hot_of(numbers, 0)
    return outside_of(values, hot)


@inlined
def span_at(swing: FreeHalfSwing, time: float) -> tuple[int, float]:
    """Return span and x of its piece a time [s] after the beginning; the last span has no end."""
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
    """Fill the forcing at the nodes of a step of length h, each from its span."""
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
            # one cubic holds over all pieces of a log interval
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
    """Keep the channels that a wheel feels at the nodes, from x of span k at each."""
    pieces, rates, nodes, wheel = swing.pieces, swing.rates, work.nodes, swing.system
    channels = wheel.channels
    line = tilt = gravity = lean = filled(work.fractions, 0.0)
    for j in range(swing.powers - 1, -1, -1):
        if rates.line is not None:
            line = fma(line, at, rates.line[k, j])
        if rates.tilt is not None and wheel.feels_drag:
            tilt = fma(tilt, at, rates.tilt[k, j])
        if pieces.gravity is not None:
            gravity = fma(gravity, at, pieces.gravity[k, j])
        if pieces.lean is not None:
            lean = fma(lean, at, pieces.lean[k, j])
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
    """Keep the machine's numbers at the nodes, from x of span k at each."""
    nodes = work.nodes
    keep(nodes.carried, times, initial, _number(hot, k, 0, at))
    keep(nodes.force, times, initial, _number(hot, k, 1, at))
    keep(nodes.stiffness, times, initial, _number(hot, k, 2, at))
    keep(nodes.weight, times, initial, _number(hot, k, 3, at))
    keep(nodes.viscous, times, initial, _number(hot, k, 4, at))
    keep(nodes.share, times, initial, _number(hot, k, 5, at))
    keep(nodes.growth, times, initial, _number(hot, k, 6, at))


@inlined
def arc_sine(x: float) -> float:
    """Return arcsin x to a thousandth for |x| < 0.6, for predictions."""
    square = x * x
    return x * fma(square, fma(square, fma(square, 15 / 336, 3 / 40), 1 / 6), 1.0)


AT_ENDS = 1.0 / 3.0 - 2.0 / (math.pi * math.pi)
"""Weight of gravity at the ends of half a swing, in a mean over sin² of its phase."""


@inlined
def longer_by_gravity(
    swing: FreeHalfSwing, free: FreeState, middle: Inputs, then: Inputs
) -> float:
    """Return the factor by which half a swing lasts longer than in the gravity at rest.

    Gravity is weighted as the square of the swing, largest at the turning point, up to squares of
    time; `middle` and `then` are its middle and its end.
    """
    ends = 0.5 * (free.gravity + then.gravity) - middle.gravity
    # (1 + more)^(−1/2)
    excess = (middle.gravity + AT_ENDS * ends) / swing.system.gravity - 1.0
    return 1.0 - excess * (0.5 - excess * (0.375 - excess * 0.3125))


@inlined
def _predicted(run: SteppedRun, swing: FreeHalfSwing, free: FreeState, usual_s: float) -> float:
    """Return the time to the next impulse [s], on a harmonic swing about its centre.

    The neutral line, as it turns in the middle of the half swing, shifts the centre.
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
    # near the middle of the swing gravity hardly changes the time
    correction = (arc_sine(until) - arc_sine(since)) * (usual_s / math.pi)
    if wheel.channels.gravity is not None:
        return usual_s * longer_by_gravity(swing, free, middle, then) + correction
    return usual_s + correction


class WheelInstant(NamedTuple):
    """A wheel at an instant.

    Attributes:
        angle, rate, bend: θ [rad], θ̇ and θ̈.
        coordinate, speed, acceleration: ϑ [rad], ϑ̇ and ϑ̈.
        drift: the time derivatives of X and ωY.
    """

    angle: float
    rate: float
    bend: float
    coordinate: float
    speed: float
    acceleration: float
    drift: Plane


@inlined
def moving(wheel: Wheel, mode: Mode, omega: Omega, plane: Plane, at: Inputs) -> WheelInstant:
    """Return the wheel at an instant; along the arc by its polynomials, without a division."""
    if wheel.shape is None:
        now = wheel.instant(mode, omega, (plane,), at)
        drift = wheel.drift(mode, omega, at, now)[0]
        return WheelInstant(
            now.angle, now.rate, now.bend, now.coordinate, now.speed, now.acceleration, drift
        )
    per_inertia, line, tilt = wheel_now(wheel, at).per_inertia, at.drive, at.tilt
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
    return WheelInstant(
        q + tilt.value,
        rate,
        acceleration + tilt.bend,
        q,
        speed,
        acceleration,
        Plane(arc_speed, w_rate),
    )


@inlined
def late_for_impulse(wheel: Wheel, way: float, now: WheelInstant, omega: Omega) -> float:
    """Return the time to the impulse [s], a short one."""
    return time_until(wheel.impulse - way * now.angle, way, now.rate, now.bend, omega)


@inlined
def time_until(angle: float, way: float, rate: float, bend: float, omega: Omega) -> float:
    """Return the time in which an angle moves on its way, to the third order.

    Its rate [rad/s] changes by `bend` [rad/s2]; see `events.back_to`.
    """
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
    now: WheelInstant,
    at: Inputs,
    late: float,
    count: int,
) -> float:
    """Return what an impulse adds to Y, a short time after an instant.

    It is `Wheel.strike` with ϑ, γ̇ and τ̇ carried on by their derivatives.
    """
    per_inertia, line, tilt = wheel_now(wheel, at).per_inertia, at.drive, at.tilt
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
    # the mass is 1/n², and what ṡ gains is 1/n = n (1 + k²ϑ²) of what ϑ̇ does
    return kick(energy * (n * n), rate, way) * (n * (1.0 + kq * kq)) * per_omega


@inlined
def _fill_rotations(omega: Omega, h: float, work: Work) -> None:
    """Fill the rotations to the nodes: by πξ from a table, and by (ωh − π)ξ in few terms."""
    nodes = work.nodes
    angle = row_of(work.fractions) * (omega[0] * h - math.pi)
    square = angle * angle
    sine, versine = filled(angle, SINE[6]), filled(angle, COSINE[6])
    for j in range(5, -1, -1):
        sine, versine = fma(sine, square, SINE[j]), fma(versine, square, COSINE[j])
    sine, versine = sine * angle, versine * square
    cosine_0, sine_0 = row_of(nodes.half_cosine), row_of(nodes.half_sine)
    store(work.cosine, PART_STEP, cosine_0 - fma(sine_0, sine, cosine_0 * versine))
    store(work.sine, PART_STEP, sine_0 + fma(cosine_0, sine, -(sine_0 * versine)))
    # these rows are not those of a step that `gauss_step` has made
    work.rotations[PART_STEP].h = math.nan


@inlined
def _turn(run: SteppedRun, time: float) -> tuple[float, float]:
    """Return cos and sin of the rotation over a time, near half a turn without a kink."""
    if run.system.kinked:
        return rotation(run.omega[0] * time)
    return _half_turn(run.omega[0] * time)


@inlined
def _half_turn(angle: float) -> tuple[float, float]:
    """Return cos and sin of an angle near π."""
    small = angle - math.pi
    square = small * small
    sine, versine = SINE[6], COSINE[6]
    for j in range(5, -1, -1):
        sine, versine = fma(sine, square, SINE[j]), fma(versine, square, COSINE[j])
    return versine * square - 1.0, -(sine * small)


class StepEnd(NamedTuple):
    """The end of a step: U and V, and the rotation to X and Y."""

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
def end_of(run: SteppedRun, h: float) -> StepEnd:
    """Return the end of the step last collocated."""
    work, start, weights = run.work, run.state.planes[0], row_of(run.work.quadrature)
    cosine, sine = _turn(run, h)
    u = start.x + h * total(weights * row_of(work.k1))
    v = start.y + h * total(weights * row_of(work.k2))
    return StepEnd(u, v, cosine, sine)


@inlined
def end_later(run: SteppedRun, h: float, late: float, end: StepEnd, drift: Plane) -> Plane:
    """Return the state a short time after the end of a step.

    The slopes there are those of the state, and change as the polynomial of the step does.
    """
    work, nodes, w = run.work, run.work.nodes, run.omega[0]
    eta, plane = late / h, end.plane
    d1, d2 = drift.x - w * plane.y, drift.y / w + w * plane.x
    k1, k2 = end.cosine * d1 - end.sine * d2, end.sine * d1 + end.cosine * d2
    weights = fma(row_of(nodes.third), eta, row_of(nodes.second))
    weights = fma(weights, eta, row_of(nodes.first)) * (eta * eta * h)
    u = end.u + (late * k1 + total(weights * row_of(work.k1)))
    v = end.v + (late * k2 + total(weights * row_of(work.k2)))
    cosine, sine = _turn(run, h + late)
    return StepEnd(u, v, cosine, sine).plane


@inlined
def late_for_kink(way: float, now: WheelInstant, omega: Omega) -> float:
    """Return the time to the kink of a cam [s], a short one."""
    return time_until(-way * now.coordinate, way, now.speed, now.acceleration, omega)


@inlined
def event_after(
    run: SteppedRun,
    swing: FreeHalfSwing,
    mode: Mode,
    h: float,
    late: float,
    end: StepEnd,
    at: Inputs,
    now: WheelInstant,
    free_end: FreeEnd,
    struck: bool = True,
) -> tuple[float, float, Inputs, WheelInstant, Plane]:
    """Return an impulse, or the kink, a short time `late` [s] after the end of a step of length h.

    `at` and `now` are forcing and motion at that end. Returned are the time as looked at again,
    how much of it is after the instant last looked at, forcing and motion at that, and the state
    at the event.
    """
    wheel, omega = swing.system, run.omega
    drift, since = now.drift, late
    if omega[0] * abs(late) > free_end.close:
        # look again from where the event was expected
        goal = end_later(run, h, late, end, drift)
        k, x = span_at(swing, h + late)
        at = ship_at(swing, k, x)
        now = moving(wheel, mode, omega, goal, at)
        way = mode.direction
        since = (
            late_for_impulse(wheel, way, now, omega) if struck else late_for_kink(way, now, omega)
        )
        late += since
    return late, since, at, now, end_later(run, h, late, end, drift)


@inlined
def holds(run: SteppedRun, swing: FreeHalfSwing, mode: Mode, error: float, h: float) -> bool:
    """Return whether a step is exact enough, within range, and clear of tilt and impulse."""
    wheel, omega, work = swing.system, run.omega, run.work
    tail, start = row_of(work.tail), run.state.planes[0]
    last_term = max(abs(total(tail * row_of(work.k1))), abs(total(tail * row_of(work.k2)))) * h
    size = math.sqrt(start.x * start.x + start.y * start.y)
    if not step_error(run.tolerance.factor, last_term / size, False) <= error:
        return False
    if not wheel.clear(swing.square, omega, work):
        return False
    if wheel.has_weight:
        # by rough bounds alone, since the row of γ̈ is a bound
        return surely_within(wheel_at_nodes(wheel, work), mode, omega, work)
    exits = wheel.exits(mode, omega, work)
    return exits.is_within and exits.edge > 1.0 and exits.slack > 1.0


@inlined
def settle(step: Step, sweeps: int, floor: float, has_stages: bool) -> bool:
    """Sweep the stages `sweeps` times and until they have settled; return whether so.

    As `gauss_step.sweep`, which looks at the changes from the first sweep on; a single sweep is
    not looked at. Where it `has_stages`, of a step of about this length, the first sweep
    takes them.
    """
    work = step.work
    old_change = change = math.inf
    for n in range(sweeps + MORE_SWEEPS):
        if n > 0 or not has_stages:
            evaluate(step)
        if n >= sweeps and (change <= floor or change * change <= floor * (old_change - change)):
            return True
        changes = filled(work.u, 0.0)
        for p in range(len(step.omega)):
            start, room = step.planes[p], WIDE_SIZE // 2 + 1 + 2 * p
            slopes = row_of(work.k1, p), row_of(work.k2, p)
            u, v = folded_both(work.folded, 0, room, slopes[0], slopes[1])
            u, v = fma(u, step.h, start.x), fma(v, step.h, start.y)
            changes = larger(changes, larger(u - row_of(work.u, p), v - row_of(work.v, p)))
            store(work.u, p, u)
            store(work.v, p, v)
        if n >= sweeps - 2:
            old_change = change
            change = largest(changes)
    return False


@inlined
def to_impulse(
    run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next impulse and let it act, or leave all as it is.

    Returns HOLDS or MISSES, and the length of the step [s].
    """
    wheel, omega, state, work = swing.system, run.omega, run.state, run.work
    way, plane, usual_s = -float(state.direction), state.planes[0], free_end.usual_s
    mode = Mode(float(state.side), way, float(state.pallet))
    h = _predicted(run, swing, free, usual_s)
    for n in range(MOST_LENGTHS):
        if not SHORTEST * usual_s < h < LONGEST * usual_s:
            return MISSES, 0.0
        fill_from_spans(swing, h, work)
        _fill_rotations(omega, h, work)
        # before the sweeps, beside which it is computed
        k, x = span_at(swing, h)
        at = ship_at(swing, k, x)
        if n == 0:
            store(work.u, 0, fma(row_of(work.nodes.land_u), plane.y, plane.x))
            store(work.v, 0, fma(row_of(work.nodes.land_v), plane.y, plane.y))
        step = Step(wheel, mode, omega, h, PART_STEP, state.planes, work)
        if not settle(step, free_end.sweeps, free_end.settled * abs(plane.y), n > 0):
            return MISSES, 0.0
        end = end_of(run, h)
        now = moving(wheel, mode, omega, end.plane, at)
        if not way * now.rate > 0.0:
            return MISSES, 0.0
        late = late_for_impulse(wheel, way, now, omega)
        if omega[0] * abs(late) > free_end.near_phase:
            h += late
            continue
        if not holds(run, swing, mode, free_end.error, h):
            return MISSES, 0.0
        signs = signs_at_nodes(wheel.coordinates(work), plane.x < 0.0, NOWHERE, work)
        late, since, at, now, goal = event_after(run, swing, mode, h, late, end, at, now, free_end)
        added = given_by_impulse(wheel, mode, goal, omega, now, at, since, state.given)
        plane.x, plane.x_rest, plane.y_rest = goal.x, 0.0, 0.0
        plane.y = goal.y + added
        free.line_rate, free.gravity = at.drive.rate + since * at.drive.bend, at.gravity
        state.direction = -state.direction
        state.armed, state.pallet = False, state.direction
        state.given += 1
        count_step(True, signs, run, 0, 0.0)
        return HOLDS, h + late
    return MISSES, 0.0


# -----------------------------------------------------------------------------
# Free-end steps of Sully's lever and of the swinging thread: from impulse to impulse.
#
# The length of a step is predicted from the ship's motion in its middle, and by how much the last
# half swing the same way was longer than predicted. It is corrected before the last two sweeps of
# the stages, since few predictions are near. `free_end` has the whole.

SHORTEST_ON_THREAD, LONGEST_ON_THREAD = 0.6, 1.5
"""Least and greatest length of a half swing, over that on land: the sea moves a thread more."""

LIKELY = 0.7, 1.3
"""Least and greatest length of a half swing with which the first sweeps are made, over that on
land."""

LATER_SWEEPS = 2
"""Least sweeps after the length of a step was corrected, or corrected again: only two show whether
the stages settle. All others are made before.
"""


@inlined
def time_to_impulse(run: SteppedRun, swing: FreeHalfSwing, usual_s: float) -> float:
    """Return about the time to the next impulse [s].

    The swing is taken as harmonic about its centre, as in `ThreadSystem.ahead_s`. Gravity and what
    shifts the centre are those in the middle of the half swing: of what changes evenly that is the
    mean. No library is called, since arc tangents take as long as a sweep of the stages.
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
    """Return the factor by which the last half swing this way was longer than expected."""
    factor = free.forth if run.state.direction > 0 else free.back
    return factor if factor > 0.0 else 1.0


@inlined
def _ends(run: SteppedRun, h: float) -> tuple[StepEnd, ...]:
    """Return the end of the step last collocated, for each plane."""
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
    """Return X and Y of each plane a short time after the end of a step.

    The slopes there are those of the state, and change as the polynomial of the step does.
    """
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
    """Return what an impulse asks for a short time after an instant, as of a harmonic swing."""
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
def holds_on_thread(
    run: SteppedRun, swing: FreeHalfSwing, mode: Mode, error: float, h: float
) -> bool:
    """Return whether a step is exact enough, within range, and clear of tilt and impulse."""
    system, omega, work = swing.system, run.omega, run.work
    tail, last_term, size = row_of(work.tail), 0.0, 0.0
    for p in range(len(omega)):
        start = run.state.planes[p]
        last_term = max(last_term, abs(total(tail * row_of(work.k1, p))))
        last_term = max(last_term, abs(total(tail * row_of(work.k2, p))))
        size = max(size, start.x * start.x + start.y * start.y)
    if not step_error(run.tolerance.factor, last_term * h / math.sqrt(size), False) <= error:
        return False
    if not system.clear(swing.square, omega, work):
        return False
    exits = system.exits(mode, omega, work)
    return exits.is_within and exits.edge > 1.0 and exits.slack > 1.0 and not exits.is_near


@inlined
def to_impulse_on_thread(
    run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next impulse and let it act, or leave all as it is.

    Returns HOLDS or MISSES, and the length of the step [s].
    """
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
        if not holds_on_thread(run, swing, mode, free_end.error, h):
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
