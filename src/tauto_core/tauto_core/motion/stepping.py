"""The driver: advances a system over spans of forcing, from event to event, and counts passages.

It divides a span into stretches and a stretch into equal steps (`lay_out`). It collocates a step,
halves it if its error is too large, searches it for events, and cuts it at the first. The end of
the range and a slack thread end the run. The driver uses only the methods of `system.System`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import compiled, entry, inlined
from tauto_core.machines.heat import Heat, HeatFactors
from tauto_core.motion.events import (
    AT_EDGE,
    CROWDED,
    IMPULSE,
    NO_EVENT,
    expects_events,
    first_event,
    happen,
    lay_out,
    step_to_event,
)
from tauto_core.motion.forcing import Forcing
from tauto_core.motion.gauss_step import (
    LEAST_SETTLED,
    PART_STEP,
    PLANE,
    WHOLE_STEP,
    Mode,
    Omega,
    Step,
    Work,
    collocate,
    copy_planes,
    fill_integrals,
    finish,
    sum_exactly,
)
from tauto_core.motion.lanes import (
    SIZE,
    Lanes,
    fma,
    lane,
    largest,
    negative,
    ones,
    row_of,
    splat,
    width,
    with_lane,
)
from tauto_core.motion.system import (
    HEAT_POWERS,
    ForcingPieces,
    HeatPieces,
    HeatTerms,
    Inputs,
    Instant,
    RunningState,
    SteppedRun,
    StepPlace,
    StepWatch,
    System,
    Tolerance,
    mode_of,
    outside_at,
    planes_of,
    set_piece,
)
from tauto_core.samples import FloatArray

# -----------------------------------------------------------------------------
# The passages of zero that a clock counts: turns are upward passages of ϑ, beats all of θ.
#
# The cam angle ϑ, or the coordinate in its place, and the wheel's angle θ in its case differ by
# the tilt of the neutral line in the case (machine_at_sea.md). If the swing is clear of that tilt,
# both pass zero once each half swing, and the signs of ϑ at the nodes of a step are enough.
# Otherwise an angle may reach zero and turn back between two nodes. It is then followed on the
# polynomials of the step.
#
# An angle of exactly zero counts as positive. `state.beats` is the passages of θ minus its lead
# over ϑ (`ahead`). While the swing is clear of the tilt, θ is therefore not needed.

SEARCH_MARGIN = 0.1
"""Fraction of the step by which a counted node must precede an event.

The fraction of the event is still rough at that time, and passages after it do not happen.
"""

EIGHT = 0, 1, 2, 3, 4, 5, 6, 7
BOUND_PER_LARGEST = 1.5
"""Bound of a polynomial over its piece, over its largest value at eight even points. A motion
sampled finely enough for interpolation does not rise higher between them.
"""

CLEAR = 2.0
"""Least square of a clear swing, over the bound."""

AT_REST = 1e-11
"""Angle [rad] and rate [rad/s] up to which a wheel at rest at zero may err by rounding, as in the
interpolated rate of a hung case.
"""

TURNING_HALVINGS = 40
"""Most bisections in the search for a turning point between two nodes."""


class CountedAngles(NamedTuple):
    """The counted quantities at an instant: ϑ or its coordinate, θ, and their rates."""

    coordinate: float
    speed: float
    angle: float
    rate: float


class WatchAngles(NamedTuple):
    """The angles of a system that swings."""

    step: StepWatch

    def angles(self, xi: float) -> CountedAngles:
        """Return the angles at a fraction of the step."""
        now = self.step.instant(xi)
        return CountedAngles(now.coordinate, now.speed, now.angle, now.rate)


class WatchRide(NamedTuple):
    """The angles while friction holds the wheel at θ = angle: ϑ = θ − τ."""

    angle: float
    place: StepPlace
    work: Work

    def angles(self, xi: float) -> CountedAngles:
        """Return the angles at a fraction of the step."""
        place = self.place
        tilt = outside_at(place.terms, place.begin + xi * place.size, self.work).tilt
        return CountedAngles(self.angle - tilt.value, -tilt.rate, self.angle, 0.0)


class PassageCount(NamedTuple):
    """The passages of zero up to the last counted node. `count_step` adds a later one.

    Attributes:
        turns: upward passages of ϑ.
        beats: passages of θ, plus its lead over ϑ at the beginning.
        below, behind: whether ϑ and θ were below zero at the last counted node.
    """

    turns: int
    beats: int
    below: bool
    behind: bool


@compiled
def ahead(coordinate: float, rate: float, angle: float) -> int:
    """Return the lead of θ over ϑ (`coordinate`, with its rate), in passages of zero.

    0 on the same side of zero, 1 if ϑ moves towards the side of θ, −1 if ϑ comes from there.
    """
    if (coordinate < 0.0) == (angle < 0.0):
        return 0
    return 1 if (coordinate < 0.0) == (rate > 0.0) else -1


@compiled
def _returns(watch: Any, of_wheel: bool, a: float, b: float, length_s: float) -> bool:
    """Return whether an angle passes zero and comes back between the fractions a and b of a step.

    The angle, θ if `of_wheel` and otherwise ϑ, is on the same side at both, and moves towards zero
    at a and away from it at b. The sign of its rate brackets the turning point, until the angle
    has changed its side or can no longer reach zero.
    """
    start = watch.angles(a)
    below = (start.angle if of_wheel else start.coordinate) < 0.0
    for _ in range(TURNING_HALVINGS):
        middle = 0.5 * (a + b)
        now = watch.angles(middle)
        value = now.angle if of_wheel else now.coordinate
        rate = now.rate if of_wheel else now.speed
        if (value < 0.0) != below:
            return True
        # towards the turning point the angle gets no steeper than here
        if abs(value) > abs(rate) * (b - a) * length_s:
            return False
        if (rate < 0.0) != below:
            a = middle
        else:
            b = middle
    return False


@compiled
def passages(watch: Any, length_s: float, limit: float, stop: float, work: Work) -> PassageCount:
    """Return the passages of zero within a step, followed on its polynomials.

    Nodes before the fraction `limit` are counted. The motion ends at the fraction `stop` or at the
    end of the step. `count_step` counts a last change of side there, at the exact event.
    """
    old = watch.angles(0.0)
    below, behind = old.coordinate < 0.0, old.angle < 0.0
    # a wheel that starts from rest at zero does not pass it
    leaving = abs(old.angle) < AT_REST and abs(old.rate) < AT_REST
    turns, beats = 0, ahead(old.coordinate, old.speed, old.angle)
    last_x, fractions = 0.0, row_of(work.fractions)
    for i in range(width(fractions) + 1):
        ends = i == width(fractions)
        xi = min(stop, 1.0) if ends else lane(fractions, min(i, width(fractions) - 1))
        if not ends and xi >= limit:
            continue
        now = watch.angles(xi)
        if (now.coordinate < 0.0) != below:
            turns += 1 if below and not ends else 0
        elif (old.speed < 0.0) != below and (now.speed < 0.0) == below:
            turns += 1 if _returns(watch, False, last_x, xi, length_s) else 0
        if (now.angle < 0.0) != behind:
            beats += 0 if ends or leaving else 1
        elif (old.rate < 0.0) != behind and (now.rate < 0.0) == behind and not leaving:
            beats += 2 if _returns(watch, True, last_x, xi, length_s) else 0  # there and back
        if not ends:
            below, behind = now.coordinate < 0.0, now.angle < 0.0
            leaving = leaving and abs(now.angle) < AT_REST
        old, last_x = now, xi
    return PassageCount(turns, beats, below, behind)


@compiled
def signs_at_nodes(coordinates: Lanes, below: bool, limit: float, work: Work) -> PassageCount:
    """Return the result of `passages` for a swing clear of the tilt, by the signs at the nodes.

    `below` is whether the coordinate was below zero at the beginning of the step.
    """
    # bit i belongs to node i, and the shifted bits to the node before
    mask, signs = negative(row_of(work.fractions) - limit), negative(coordinates)
    crossed = (signs ^ (signs << 1 | (1 if below else 0))) & mask
    count_seen = ones(mask)
    if count_seen > 0:
        below = signs >> (count_seen - 1) & 1 == 1
    return PassageCount(ones(crossed & ~signs), ones(crossed), below, below)


@compiled
def bounds_of(
    channel: FloatArray | None, k: int, per: float, other_channel: FloatArray | None = None
) -> tuple[float, float]:
    """Return bounds of |f| and of `per`·|df/dx| over piece k of a channel f, or 0 if it is absent.

    With another channel, f is the difference. The sum of the coefficients' magnitudes is a hundred
    times too large a bound on a piece about as long as a wave.
    """
    if channel is None:
        return 0.0, 0.0
    x = splat(0.0)
    for i in EIGHT:  # both ends and six points between: eight lanes cost as much as one
        x = with_lane(x, i, i / 7.0)
    value, slope = splat(0.0), splat(0.0)
    powers, count = channel.shape[1], channel.shape[1]
    if other_channel is not None:
        count = max(powers, other_channel.shape[1])
    for j in range(count - 1, -1, -1):
        coefficient = channel[k, j] if j < powers else 0.0
        if other_channel is not None and j < other_channel.shape[1]:
            coefficient -= other_channel[k, j]
        slope = fma(slope, x, value)
        value = fma(value, x, coefficient)
    return BOUND_PER_LARGEST * largest(value), BOUND_PER_LARGEST * per * largest(slope)


@compiled
def in_step(
    clear: bool,
    limit: float,
    stop: float,
    run: SteppedRun,
    mode: Mode,
    pieces: ForcingPieces,
    k: int,
    place: StepPlace,
) -> PassageCount:
    """Return the passages of zero within the step last collocated (see `passages`).

    `clear` is whether the swing is clear of the tilt.
    """
    work = run.work
    if clear:
        below = run.system.coordinate(planes_of(run.omega, run.state.planes)) < 0.0
        return signs_at_nodes(run.system.coordinates(work), below, limit, work)
    set_piece(pieces, k, True, work)
    fill_integrals(run.omega, work)
    watch = WatchAngles(StepWatch(run, mode, place))
    return passages(watch, place.size * place.length, limit, stop, work)


@compiled
def count_step(clear: bool, counts: PassageCount, run: SteppedRun, terms: int, x: float) -> None:
    """Add the passages of a step that ends at x to the state there, after any event."""
    state, system = run.state, run.system
    planes = planes_of(run.omega, state.planes)
    below = behind = system.coordinate(planes) < 0.0
    if not clear:
        end = system.instant(mode_of(state), run.omega, planes, outside_at(terms, x, run.work))
        below, behind = end.coordinate < 0.0, end.angle < 0.0
        state.beats -= ahead(end.coordinate, end.speed, end.angle)
    state.turns += counts.turns + (1 if counts.below and not below else 0)
    state.beats += counts.beats + (1 if counts.behind != behind else 0)


# -----------------------------------------------------------------------------
# The accuracy of steps.

MIN_ANGLE = 0.005
"""Longest step ωh [rad] that is laid out regardless of its error."""

TOLERANCE = 2e-12
"""Default error allowed in a step, relative to the state."""

TOLERANCE_SHARE = 0.3
"""Share of the tolerance for the layout of steps. The rest is for the sea."""

ITERATION_SHARE, MOST_ITERATION_SHARE = 1e-5, 1e-3
"""Least and greatest share of the tolerance for the iteration of the stage equations.

The share is three times the root of the tolerance, since in coarse steps collocation dominates the
error.
"""

ERROR_OF_LAST, ERROR_OF_LAST_STRONG = 0.03, 1.0
"""Error of a smooth step over the square of the last Legendre coefficient of its slopes.

The step has twice the order of its polynomial, hence the square. Measured
(benchmarks/stress.json): 0.002 to 0.03 for a weak disturbance, up to 0.8 for a weight or a spring
with a strongly anharmonic well.
"""


@inlined
def step_error(factor: float, last_term: float) -> float:
    """Return the error of a step relative to the state, from the result of `collocate`.

    `factor` is `Tolerance.factor`.
    """
    return last_term if factor == 0.0 else factor * last_term * last_term


# -----------------------------------------------------------------------------
# The driver.

OK, EDGE, SLACK, NO_CONVERGENCE, STRUCK = 0, 1, 2, 3, 4
"""How a run ends: at the end of the spans, at the end of the range, with a slack thread, without a
solution, or at the next impulse if it is to stop there.
"""

ROW = np.dtype(
    [
        *((name, 'f8') for name in ('angle', 'rate', 'torque')),
        *((name, 'f8') for name in ('coordinate', 'speed', 'acceleration')),
        *((name, 'i8') for name in ('turns', 'beats')),
    ]
)
"""A logged instant: fields of `Instant`, turns and beats since the release."""


MAX_EVENTS = 10_000
"""Most consecutive crowded events (`events.CROWDED`)."""

MAX_STALLED = 4
"""Most consecutive events without progress. After them turning points and kinks are ignored."""

HALF_SWING = 3.25
"""Longest step ωh [rad] that is searched for the end of the range or a slack thread."""

MAX_LEVEL = 24
"""Most halvings of a step."""


class Spans(NamedTuple):
    """The spans of a run, each in its own piece of forcing.

    Attributes:
        begin, end: x of the piece at both ends, (n,).
        logged: whether a row is written at the end, (n,).
    """

    begin: FloatArray
    end: FloatArray
    logged: NDArray[np.bool_]


class StepResult(NamedTuple):
    """The result of a step.

    Attributes:
        event: kind of the event at its end, or NO_EVENT.
        fraction: completed share of the step.
        error: its error, relative to the state. Beyond the tolerance the state is unchanged.
    """

    event: int
    fraction: float
    error: float


@compiled
def _move(
    run: SteppedRun,
    place: StepPlace,
    stalled: bool,
    clear_square: float,
    pieces: ForcingPieces,
    k: int,
) -> StepResult:
    """Advance over a step or to the first event, and count passages of zero on the way.

    Turning points and kinks are ignored if `stalled`.
    """
    system, omega, state, work = run.system, run.omega, run.state, run.work
    if system.sticks and state.held:
        # the held wheel moves with the case, over the step or until it breaks loose
        loose = system.move_with_case(run, place)
        watch = WatchRide(state.held_angle, place, work)
        counts = passages(watch, place.size * place.length, loose, loose, work)
        count_step(False, counts, run, place.terms, place.begin + loose * place.size)
        return StepResult(NO_EVENT, loose, 0.0)
    tolerance, mode, h = run.tolerance, mode_of(state), place.size * place.length
    expected = expects_events(system)
    kind = PART_STEP if expected and system.feels_tilt else WHOLE_STEP
    system.at_nodes(place, work)
    step = Step(system, mode, omega, h, kind, state.planes, work)
    error = step_error(tolerance.factor, collocate(step, tolerance.settled))
    exits = system.exits(mode, omega, work)
    is_inside = min(exits.edge, exits.slack) > 1.0
    if not is_inside and omega[0] * h > HALF_SWING:
        # only a shorter step determines the end of the motion
        error = math.inf
    if not error <= tolerance.step:
        return StepResult(NO_EVENT, 0.0, error)
    finish(step)
    clear = system.clear(clear_square, omega, work)
    event, xi = NO_EVENT, 1.0
    if expected or not is_inside or exits.is_near:
        at = outside_at(place.terms, place.begin + place.size, work)
        at_end = system.instant(mode, omega, planes_of(omega, work.end), at)
        event, xi = first_event(run, stalled, clear, place, at_end, exits)
    limit = 2.0 if event == NO_EVENT else xi - SEARCH_MARGIN
    counts = in_step(clear, limit, xi, run, mode, pieces, k, place)
    if event != NO_EVENT:
        xi = step_to_event(event, xi, run, mode_of(state), place)
    copy_planes(omega, work.end, state.planes)
    x = place.begin + xi * place.size
    if event != NO_EVENT:
        at = outside_at(place.terms, x, work)
        now = system.instant(mode_of(state), omega, planes_of(omega, state.planes), at)
        happen(event, run, at, now)
    count_step(clear, counts, run, place.terms, x)
    return StepResult(event, xi, error)


@inlined
def fill_row(now: Instant, turns: int, beats: int, row: Any) -> None:
    """Fill a row with the system at an instant."""
    row.angle, row.rate, row.torque = now.angle, now.rate, now.torque
    row.coordinate, row.speed, row.acceleration = now.coordinate, now.speed, now.acceleration
    row.turns, row.beats = turns, beats + ahead(now.coordinate, now.speed, now.angle)


@compiled
def write_row(run: SteppedRun, at: Inputs, row: Any) -> None:
    """Fill a row with the system at an instant."""
    state, mode = run.state, mode_of(run.state)
    is_held = run.system.sticks and state.held
    if is_held:
        mode = Mode(mode.side, 0.0, mode.pallet)
    planes = planes_of(run.omega, state.planes)
    now: Instant = run.system.instant(mode, run.omega, planes, at)
    fill_row(now, state.turns, state.beats, row)
    if is_held:
        row.angle, row.rate, row.acceleration = state.held_angle, 0.0, -at.tilt.bend
        row.beats = state.beats + ahead(now.coordinate, now.speed, row.angle)


@entry
def release(
    system: System,
    omega: Omega,
    angle: float,
    pieces: ForcingPieces,
    x0: float,
    state: RunningState,
    work: Work,
    row: Any,
) -> float:
    """Set the state to rest in the case at θ = angle, at x0 in the first piece.

    Returns the tension of the thread.
    """
    at = outside_at(set_piece(pieces, 0, True, work)[1], x0, work)
    state.side, state.direction, state.pallet = 1, 1, -1 if angle < 0.0 else 1
    state.turns, state.beats, state.level, state.given = 0, 0, 0, 0
    state.held, state.held_angle = False, 0.0
    system.set_off(omega, angle, at, state)
    run = SteppedRun(system, omega, Tolerance(0.0, 0.0, 0.0, 0.0, 0.0), state, work)
    write_row(run, at, row)
    state.beats, row.beats = -row.beats, 0
    now = system.instant(mode_of(state), omega, planes_of(omega, state.planes), at)
    return now.tension


@compiled
def over_span(
    k: int,
    run: SteppedRun,
    longest_s: float,
    pieces: ForcingPieces,
    spans: Spans,
    logged: bool,
    begin: float,
    to_impulse: bool,
) -> tuple[int, float, int]:
    """Advance over one span from `begin` on, or `to_impulse`.

    Returns a code, x in the piece, and the powers in use.

    A span consists of stretches, a stretch of equal steps. It ends a little after the next
    expected event or with the span. Each round of the loop takes one step, or the rest of it:

        too large an error    halve the rest of the stretch and repeat
        no event              go on with the next step
        an event              end the stretch here
        the end of the range  return
    """
    system, omega, state, work = run.system, run.omega, run.state, run.work
    # x = start + start_rest + (step + fraction)/steps · stretch, with the beginning of the stretch
    # as two doubles. A running sum would lose digits in a span of a day.
    start, start_rest, stretch, steps, step, fraction = begin, 0.0, 0.0, 0, 0, 0.0
    end = spans.end[k]
    # worst: largest error so far. events, stalled: consecutive events with little or no progress
    worst, events, stalled = 0.0, 0, 0
    length, terms = set_piece(pieces, k, system.feels_tilt or logged, work)
    per_s, is_last = 1.0 / length, False  # is_last: whether the stretch ends with the span
    besides = abs(system.impulse) if system.feels_impulse else 0.0
    clear_square = system.clear_square(omega, pieces, k, besides)
    while not is_last or step < steps:
        if step == steps:
            # lay out the next stretch from here
            start, start_rest = sum_exactly(start, start_rest + stretch)
            ahead_s = system.ahead_s(omega, length, terms, start, state, work)
            remaining = (end - start) - start_rest
            stretch, steps = lay_out(remaining, per_s, longest_s, ahead_s, state.level)
            step, fraction, is_last = 0, 0.0, stretch == remaining
        x = start + (start_rest + (step + fraction) / steps * stretch)
        place = StepPlace(length, terms, x, (1.0 - fraction) / steps * stretch)
        result = _move(run, place, stalled > MAX_STALLED, clear_square, pieces, k)
        if not result.error <= run.tolerance.step:
            # halve the steps from the beginning of this one on, until errors are small again
            state.level += 1
            if state.level > MAX_LEVEL:
                return NO_CONVERGENCE, place.begin, terms
            second_half = 1 if fraction >= 0.5 else 0
            step, steps, fraction = 2 * step + second_half, 2 * steps, 2.0 * fraction - second_half
            continue
        worst = max(worst, result.error)
        # `result.fraction` is a share of the rest of the step
        reached = 1.0 if result.fraction >= 1.0 else fraction + result.fraction * (1.0 - fraction)
        stalled = stalled + 1 if reached == fraction else 0
        turned = result.fraction * place.size * length * system.pace
        events = events + 1 if reached < 1.0 and turned < CROWDED else 0
        step, fraction = (step + 1, 0.0) if reached == 1.0 else (step, reached)
        at_end = is_last and step == steps
        x = end if at_end else start + (start_rest + (step + fraction) / steps * stretch)
        if result.event >= AT_EDGE:
            return EDGE if result.event == AT_EDGE else SLACK, x, terms
        if to_impulse and result.event == IMPULSE:
            return STRUCK, x, terms
        if result.event != NO_EVENT and not at_end:
            # end the stretch here: the next round lays out another one
            stretch *= (step + fraction) / steps
            steps, step, is_last = 0, 0, False
        if events > MAX_EVENTS:
            return NO_CONVERGENCE, x, terms
    if state.level > 0 and worst < run.tolerance.coarsen:
        # steps of twice the length would have kept the tolerance, too
        state.level -= 1
    return OK, end, terms


@entry
def advance(
    system: System,
    omega: Omega,
    tolerance: Tolerance,
    longest_s: float,
    pieces: ForcingPieces,
    spans: Spans,
    state: RunningState,
    work: Work,
    rows: NDArray[np.void],
) -> tuple[int, int, float]:
    """Advance the state over all spans and fill a row (`ROW`) for every logged one.

    Returns a code (OK, EDGE, SLACK, NO_CONVERGENCE), and span and x at the end of a failed run.
    """
    run = SteppedRun(system, omega, tolerance, state, work)
    written = 0
    for k in range(len(spans.begin)):
        logged = spans.logged[k]
        code, x, terms = over_span(k, run, longest_s, pieces, spans, logged, spans.begin[k], False)
        if code != OK:
            return code, k, x
        if logged:
            write_row(run, outside_at(terms, spans.end[k], run.work), rows[written])
            written += 1
    return OK, 0, 0.0


# -----------------------------------------------------------------------------
# The model of a machine, and the records of its run.


class Model(NamedTuple):
    """A `system.System` with its parameters, and ω of each of its planes [rad/s]."""

    system: Any
    omega: Omega


def tolerance_of(
    step: float | None, factor: float, coarsen: float, most_share: float = MOST_ITERATION_SHARE
) -> Tolerance:
    """Return the accuracy of steps.

    Args:
        step: error allowed in a step, `TOLERANCE` by default.
        factor: `Tolerance.factor`.
        coarsen: share of `step` below which steps double.
        most_share: greatest share of the tolerance for the iteration of the stage equations.
    """
    step = TOLERANCE if step is None else step
    share = min(max(3.0 * math.sqrt(step), ITERATION_SHARE), most_share)
    settled = max(LEAST_SETTLED, share * step)
    # the midpoint rule to an event errs by a 24th of the cube of the angle
    near = float(np.cbrt(24.0 * ITERATION_SHARE * step))
    return Tolerance(step, factor, settled, near, step * coarsen)


HEAT_AT = 0.0, 0.25, 0.75, 1.0
"""Chebyshev nodes of the cubic through the machine's parameters, over a log interval."""

HEAT_TO_POWERS = (
    (1.0, 0.0, 0.0, 0.0),
    (-19.0 / 3.0, 8.0, -8.0 / 3.0, 1.0),
    (32.0 / 3.0, -56.0 / 3.0, 40.0 / 3.0, -16.0 / 3.0),
    (-16.0 / 3.0, 32.0 / 3.0, -32.0 / 3.0, 16.0 / 3.0),
)
"""Matrix from values at `HEAT_AT` to the cubic's coefficients."""


def thermal_pieces(
    forcing: Forcing, heat: Heat, numbers: Callable[[HeatFactors, FloatArray], HeatTerms]
) -> HeatPieces:
    """Return the machine's thermal parameters over the log intervals of the forcing.

    `numbers` computes them from the heat factors and İ/I [1/s]. Raises ValueError if the forcing
    has no temperatures.
    """
    temperatures = forcing.temperatures
    if temperatures is None:
        raise ValueError(
            'Forcing.temperatures is missing. Set it, or use a machine that heat does not change'
        )
    celsius_begin, celsius_end = temperatures.celsius[:, 0], temperatures.celsius[:, 1]
    at_nodes = []
    for node in HEAT_AT:
        celsius = celsius_begin + node * (celsius_end - celsius_begin)
        factors = heat.factors(celsius, temperatures.begin_s + node * temperatures.interval_s)
        at_nodes.append(numbers(factors, heat.inertia_growth(celsius, temperatures.per_s)))
    terms = np.zeros((len(celsius_begin), HEAT_POWERS, SIZE))
    for j, row in enumerate(HEAT_TO_POWERS):
        for i, values in enumerate(zip(*at_nodes, strict=True)):
            terms[:, j, i] = sum(weight * value for weight, value in zip(row, values, strict=True))
    size = forcing.length_s / temperatures.interval_s
    return HeatPieces(terms.reshape(-1, SIZE), temperatures.interval, temperatures.place, size)


def state_type(planes: int) -> np.dtype[Any]:
    """Return the type of the record `RunningState`."""
    integers = ('side', 'direction', 'pallet', 'turns', 'beats', 'level', 'given')
    return np.dtype(
        [
            ('planes', PLANE, (planes,)),
            ('held_angle', 'f8'),
            *((name, 'i8') for name in integers),
            ('armed', '?'),
            ('held', '?'),
        ],
        align=True,
    )


def state_of(record: NDArray[np.void]) -> dict[str, Any]:
    """Return a running state by names, as plain numbers, with planes as tuples."""
    return {name: record[name].tolist() for name in record.dtype.names or ()}


def restore_record(record: NDArray[np.void], state: dict[str, Any]) -> None:
    """Set a running state from the result of `state_of`."""
    for name in record.dtype.names or ():
        record[name] = state[name]
