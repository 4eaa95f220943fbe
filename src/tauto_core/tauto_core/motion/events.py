"""Events of a system: their effects, the first one within a step, and short steps to it.

The kinds are the turning point of θ, the kink of a cam, the impulse of the escapement, the end of
the range, and a slack thread. The value of an event changes from positive to negative at it.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.gauss_step import (
    PART_STEP,
    Mode,
    Omega,
    Planes,
    Step,
    Work,
    collocate,
    copy_planes,
    fill_integrals,
    finish,
)
from tauto_core.motion.lanes import largest, lowest
from tauto_core.motion.system import (
    NOWHERE,
    Exits,
    Inputs,
    Instant,
    Plane,
    RunningState,
    SteppedRun,
    StepPlace,
    StepWatch,
    System,
    mode_of,
    outside_at,
    planes_of,
)

NO_EVENT, TURNING, KINK, IMPULSE, AT_EDGE, AT_SLACK, UNSURE = range(7)
"""Kinds of events, in the order of the search. In `WatchEvent` a negative kind is the instant at
which the value of that kind stops falling.
"""


@inlined
def expects_events(system: System) -> bool:
    """Return whether turning points, kinks or impulses can be events of the system."""
    return system.drag_has_kink or system.feels_impulse or system.kinked


@compiled
def event_value(kind: int, system: System, mode: Mode, now: Instant) -> float:
    """Return the value of an event at an instant."""
    if kind == TURNING:
        return mode.direction * now.rate
    if kind == KINK:
        return mode.side * now.coordinate
    if kind == IMPULSE:
        return system.impulse - mode.direction * now.angle
    if kind == AT_EDGE:
        return now.margin
    return now.tension


@compiled
def event_slope(kind: int, mode: Mode, now: Instant) -> float:
    """Return the time derivative of an event's value, or 0 for an event that ends a run."""
    if kind == TURNING:
        return mode.direction * now.bend
    if kind == KINK:
        return mode.side * now.speed
    if kind == IMPULSE:
        return -mode.direction * now.rate
    return 0.0


@inlined
def alternates(system: System, state: RunningState, direction: float) -> bool:
    """Return whether a tooth rests on the pallet that pushes in a direction.

    After an impulse a tooth falls on the other pallet and rests there until that pallet pushes,
    even if the wheel turns back before. Either pallet may give the first impulse, unless recoil
    defines the resting pallet at the release.
    """
    return direction != float(state.pallet) or (state.given == 0 and not system.recoils)


@inlined
def is_due(system: System, state: RunningState, direction: float, angle: float) -> bool:
    """Return whether an impulse is due on the swing from θ = angle on."""
    reaches = direction * angle < system.impulse < math.inf
    return reaches and alternates(system, state, direction)


@compiled
def happen(kind: int, run: SteppedRun, at: Inputs, now: Instant) -> None:
    """Apply an event to the signs and counts of the state, and an impulse also to the planes.

    `at` and `now` are the ship's motion and the system before the event.
    """
    system, state = run.system, run.state
    mode = mode_of(state)
    if system.kinked and kind == KINK:
        state.side = -state.side
    if system.feels_impulse and kind == IMPULSE:
        system.strike(mode, run.omega, at, now, state)
        state.armed, state.pallet = False, state.direction
        state.given += 1
    if kind == TURNING:
        state.direction = -state.direction
        if system.sticks:
            system.set_off(run.omega, now.angle, at, state)
        else:
            state.armed = is_due(system, state, float(state.direction), now.angle)


# -----------------------------------------------------------------------------
# The layout of steps over a span.
#
# A stretch reaches to the end of the span, or a little beyond the next expected event, and is
# divided into equal steps. The event is then near the end of the last step, and one short step
# back reaches it. The next stretch begins at the end of this one, with or without the event.

OVERSHOOT = 0.05
"""Phase by which a stretch ends after the expected event [rad]."""

CROWDED = 1e-3
"""Phase since the last event below which events count as crowded [rad]."""

SPARE = 0.05
"""Excess over the longest step, as a share of it, that is allowed if it saves a step."""


@compiled
def phase_to(way: float, x: float, y: float, reach: float) -> float:
    """Return the phase in (0, 2π] until way·x next rises to `reach`, for x = A sin φ, y = A cos φ.

    `way` is 1 or −1. The phase is infinite if A ≤ |reach|.
    """
    size = math.sqrt(x * x + y * y)
    if not abs(reach) < size:
        return math.inf
    ahead = math.asin(reach / size) - math.atan2(way * x, way * y)
    while ahead <= 0.0:
        ahead += math.tau
    return ahead


@compiled
def back_to(late: float, bend: float, omega: float) -> float:
    """Return the time since a value fell below zero [s], with an error of the fourth order.

    Args:
        late: f/ḟ of the value f [s], the estimate of first order.
        bend: f̈/ḟ [1/s].
        omega: frequency of the value's swing [rad/s], for its third derivative.
    """
    turned = bend * late
    return late * (1.0 + 0.5 * turned * (1.0 + turned) + (omega * late) ** 2 / 6.0)


@compiled
def lay_out(
    remaining: float, per_s: float, longest_s: float, ahead_s: float, level: int
) -> tuple[float, int]:
    """Return the length of the next stretch, in the unit of `remaining`, and its number of steps.

    Args:
        remaining: rest of the span.
        per_s: a second in the unit of `remaining`.
        longest_s: longest step [s].
        ahead_s: time to the next expected event [s], or infinity.
        level: halvings of the steps.
    """
    stretch = min(remaining, ahead_s * per_s)
    steps = math.ceil(stretch / (per_s * longest_s) - SPARE)
    # equal steps: if their length depended on the phase of the swing, its energy would drift
    return stretch, max(1, steps) << level


# -----------------------------------------------------------------------------
# The fraction of a step at which a value that was positive falls to zero.

FIRST_TRIALS = 12
"""Fractions tried up to the last one, each four times the one before."""

# Bisection alone reaches the last bit in 52 probes, so this only ends the loop.
MAX_PROBES = 200


@compiled
def locate(watch: WatchEvent, last_x: float, at_last: float, precision: float) -> float:
    """Return the fraction of the step at which a value falls to zero; 0 if it is never positive.

    Illinois form of false position (Dowell and Jarratt, BIT 11, 1971, 168). Probes keep half the
    precision away from both bounds. Otherwise a tiny value at the beginning would draw the first
    probe there and make it look like a root.

    Args:
        watch: the value.
        last_x: fraction at which the value is not positive.
        at_last: the value there.
        precision: allowed error of the fraction.
    """
    a, b, fb = 0.0, last_x, min(at_last, 0.0)
    fa = watch.value(a)
    if not fa > 0.0:
        # after an event at the beginning of the step the value may be positive for a moment
        for trial in range(1, FIRST_TRIALS):
            x = last_x * 0.25 ** (FIRST_TRIALS - trial)
            fx = watch.value(x)
            if fx > 0.0:
                a, fa = x, fx
            elif fa > 0.0:
                b, fb = x, fx
                break
    if not fa > 0.0:
        return 0.0
    stale_end = 0
    for _ in range(MAX_PROBES):
        x = (a * fb - b * fa) / (fb - fa)
        if b - a <= precision:
            return x
        x = min(max(x, a + 0.5 * precision), b - 0.5 * precision)
        fx = watch.value(x)
        if fx == 0.0:
            return x
        if fx > 0.0:
            a, fa = x, fx
            fb = 0.5 * fb if stale_end == 1 else fb
            stale_end = 1
        else:
            b, fb = x, fx
            fa = 0.5 * fa if stale_end == -1 else fa
            stale_end = -1
    return b


# -----------------------------------------------------------------------------
# The fraction of a step from which on a condition holds.

HALVINGS = 60
"""Bisections, enough for the last bit of a double."""


@compiled
def first_holds(watch: Any, probes: int) -> float:
    """Return the first fraction of the step at which a condition holds, or 2 if it never holds.

    `watch.holds` returns whether it holds at a fraction. It is probed at the ends of `probes`
    equal parts and bisected in the first hit.
    """
    for i in range(1, probes + 1):
        b = i / probes
        if watch.holds(b):
            a = (i - 1) / probes
            for _ in range(HALVINGS):
                middle = 0.5 * (a + b)
                a, b = (a, middle) if watch.holds(middle) else (middle, b)
            return b
    return 2.0


class WatchHold(NamedTuple):
    """The condition that friction no longer holds a system at rest at an angle in the ship."""

    system: System
    mode: Mode
    angle: float
    place: StepPlace
    work: Work

    def holds(self, xi: float) -> bool:
        """Return whether the system breaks loose at a fraction of the step."""
        place = self.place
        at = outside_at(place.terms, place.begin + xi * place.size, self.work)
        return self.system.breaks_loose(self.mode, self.angle, at)


@compiled
def ride_held(system: System, run: SteppedRun, place: StepPlace, probes: int) -> float:
    """Move a held system with the ship and return the fraction at which it breaks loose, or 1."""
    state, work = run.state, run.work
    watch = WatchHold(system, mode_of(state), state.held_angle, place, work)
    loose = first_holds(watch, probes)
    xi = min(loose, 1.0)
    at = outside_at(place.terms, place.begin + xi * place.size, work)
    if loose <= 1.0:
        system.set_off(run.omega, state.held_angle, at, state)
    else:
        system.rest_at(run.omega, state.held_angle, at, state)
    return xi


# -----------------------------------------------------------------------------
# The first event within a step.
#
# The state at the end decides most steps, at the cost of one instant. The stage polynomials are
# evaluated only if more than one event may have happened.

DISCERNED = 1e-7
"""Least significant fall of a value at the beginning of a step, over its slope at the end, and
least significant overshoot of the impulse's angle, over the largest angle.
"""

KINK_APART = 0.05
"""If all nodes are at least this far from a kink, over the largest angle of the step, the motion
does not pass it between two nodes.
"""

TURNS_TWICE = 2.0
"""Longest step ωh [rad] that certainly has at most one turning point.

Turning points are half a swing apart, or less if the ship turns half as fast as the wheel.
"""

TURNING_PROBES = 16
"""Fractions at which a longer step is searched for its first turning point."""

BENT = 0.25
"""Largest relative change of the slope of an event's value from the event to the end of the step
at which the end determines the event.
"""


class WatchEvent(NamedTuple):
    """The value of an event within a step, or minus its time derivative for a negative kind."""

    kind: int
    step: StepWatch

    def value(self, xi: float) -> float:
        """Return the value at a fraction of the step."""
        kind, step = self.kind, self.step
        system, mode = step.run.system, step.mode
        if system.kinked and kind == KINK:
            return mode.side * system.coordinate(step.planes(xi))
        if system.feels_impulse and kind == IMPULSE:
            angle = system.wheel_angle(step.planes(xi), step.outside(xi))
            return system.impulse - mode.direction * angle
        now = step.instant(xi)
        if kind < 0:
            return -event_slope(-kind, mode, now)
        return event_value(kind, system, mode, now)


@compiled
def first_event(
    run: SteppedRun, stalled: bool, clear: bool, place: StepPlace, at_end: Instant, exits: Exits
) -> tuple[int, float]:
    """Return the first event within a step that must be stepped to, and its fraction.

    A turning point of drag without a kink changes only the direction of the state. This function
    reverses it, and the step is not cut. After several events without progress (`stalled`)
    turning points and kinks are ignored.

    If the swing is not `clear` of tilt and impulse, θ may pass the angle of an impulse between two
    turning points and come back. The end of a long step does not show that, so its interior is
    searched.
    """
    system, state = run.system, run.state
    long = run.omega[0] * (place.size * place.length) > TURNS_TWICE
    if system.feels_impulse and long and not (clear or stalled):
        return _on_polynomials(run, mode_of(state), False, True, place, at_end, exits)
    d = float(state.direction)
    turned = not stalled and _turns_quietly(run, place, at_end, exits)
    if turned and -d * at_end.angle < system.impulse:
        return NO_EVENT, 1.0
    mode = mode_of(state)
    event, xi = _by_the_end(run, mode, place, at_end, exits)
    if event == UNSURE:
        event, xi = _on_polynomials(run, mode, stalled, False, place, at_end, exits)
    if event == TURNING and _turns_smoothly(xi, run, mode, place, at_end, exits):
        return NO_EVENT, 1.0
    return event, xi


@inlined
def _inside(exits: Exits) -> bool:
    """Return whether the step is within the range, with a taut thread."""
    return min(exits.edge, exits.slack) > 1.0 and not exits.is_near


@compiled
def _turns_quietly(run: SteppedRun, place: StepPlace, at_end: Instant, exits: Exits) -> bool:
    """Reverse the direction if the step has a turning point and at most an impulse after it.

    The end of the step and its nodes decide. False means that they cannot.
    """
    system, state, work = run.system, run.state, run.work
    d, side = float(state.direction), float(state.side)
    if not system.feels_impulse or system.drag_has_kink:
        return False
    if state.armed or not _inside(exits) or not d * at_end.rate < 0.0:
        return False
    # The next impulse acts at −d θ = angle. −d θ is least at the turning point, so the impulse is
    # due if either end of the step is before that angle. The last impulse may have acted at the
    # beginning, at that very angle.
    if not -d * at_end.angle < system.impulse:
        at = outside_at(place.terms, place.begin, work)
        angle = system.wheel_angle(planes_of(run.omega, state.planes), at)
        if not -d * angle < system.impulse + DISCERNED * exits.reach:
            return False
    if not exits.is_within:
        return False
    if system.kinked:
        nearest = lowest(side * system.coordinates(work))
        if not (side * at_end.coordinate > 0.0 and nearest >= KINK_APART * exits.reach):
            return False
    state.direction = -state.direction
    state.armed = alternates(system, state, float(state.direction))
    return True


@compiled
def _turns_smoothly(
    xi: float, run: SteppedRun, mode: Mode, place: StepPlace, at_end: Instant, exits: Exits
) -> bool:
    """Reverse the direction if the turning point at ξ is the only event of the step."""
    system, state = run.system, run.state
    if system.drag_has_kink or system.kinked or not _inside(exits):
        return False
    if not (at_end.margin > 0.0 and at_end.tension > 0.0):
        return False
    turning, way = StepWatch(run, mode, place).instant(xi), -mode.direction
    armed = is_due(system, state, way, turning.angle)
    if not way * at_end.rate > 0.0 or (armed and not way * at_end.angle < system.impulse):
        return False
    state.direction = -state.direction
    state.armed = armed
    return True


@compiled
def _may_dip(kind: int, run: SteppedRun, mode: Mode) -> bool:
    """Return whether an event's value may pass zero and come back between two nodes."""
    system = run.system
    if system.kinked and kind == KINK:
        angles = system.coordinates(run.work)
        return lowest(mode.side * angles) < KINK_APART * largest(angles)
    return system.drag_has_kink and kind == TURNING


@compiled
def _dip(kind: int, rises: float, step: StepWatch) -> tuple[float, float]:
    """Return the fraction of an event's lowest value and that value, or (NOWHERE, 0) if positive.

    A value that passes zero twice falls at the beginning and rises at the end, at the rate
    `rises`. A fall within rounding, after a wheel has broken loose from friction, does not count.
    """
    falling = WatchEvent(-kind, step)
    if not (rises > 0.0 and falling.value(0.0) > DISCERNED * rises):
        return NOWHERE, 0.0
    # near its minimum the value errs by the square of the fraction's error
    xi = locate(falling, 1.0, -rises, 1e-3)
    value = WatchEvent(kind, step).value(xi)
    return (xi, value) if value < 0.0 else (NOWHERE, 0.0)


@compiled
def _first_below(watch: WatchEvent, at_end: float) -> tuple[float, float]:
    """Return the first probe at which a value is no longer positive, and the value there.

    (NOWHERE, at_end) if it stays positive. A value that begins at zero may rise first.
    """
    was_positive = watch.value(0.0) > 0.0
    for i in range(1, TURNING_PROBES):
        value = watch.value(i / TURNING_PROBES)
        if value > 0.0:
            was_positive = True
        elif was_positive:
            return i / TURNING_PROBES, value
    return (1.0, at_end) if at_end <= 0.0 else (NOWHERE, at_end)


@compiled
def _by_the_end(
    run: SteppedRun, mode: Mode, place: StepPlace, at_end: Instant, exits: Exits
) -> tuple[int, float]:
    """Return the only event within a step and its approximate fraction, by the state at its end.

    UNSURE unless the event is in the second half of the step and no other event is near it.
    """
    system, state, work = run.system, run.state, run.work
    side, d = mode.side, mode.direction
    is_inside = _inside(exits) and at_end.margin > 0.0
    if system.drag_has_kink or not is_inside or (system.has_weight and not at_end.tension > 0.0):
        return UNSURE, 1.0
    if system.feels_impulse and not d * at_end.rate > 0.0:
        return UNSURE, 1.0
    if system.kinked and side * at_end.coordinate > 0.0 and side * at_end.speed > 0.0:
        # a motion that leaves the kink from the beginning on has not passed it
        leaves = system.leaves_kink(mode, run.omega, state.planes, work)
        if not leaves and _may_dip(KINK, run, mode):
            return UNSURE, 1.0
    struck = state.armed and not d * at_end.angle < system.impulse
    crossed = system.kinked and not side * at_end.coordinate > 0.0
    if not struck and not crossed:
        return NO_EVENT, 1.0
    length = place.size * place.length
    impulse = _back_to(IMPULSE, run, mode, length, at_end) if struck else NOWHERE
    kink = _back_to(KINK, run, mode, length, at_end) if crossed else NOWHERE
    fraction, distance = min(impulse, kink), abs(impulse - kink)
    if not fraction > 0.5 or (struck and crossed and not distance > 0.5 * (1.0 - fraction)):
        return UNSURE, 1.0
    return IMPULSE if impulse < kink else KINK, fraction


@compiled
def _back_to(kind: int, run: SteppedRun, mode: Mode, length: float, at_end: Instant) -> float:
    """Return the fraction at which an event's value was zero, by the step's end.

    0 if the slope has changed too much since then for a good estimate.
    """
    fall = event_slope(kind, mode, at_end)
    late = event_value(kind, run.system, mode, at_end) / fall
    bend = at_end.acceleration / at_end.speed if kind == KINK else at_end.bend / at_end.rate
    if not (fall < 0.0 and abs(bend * late) < BENT):
        return 0.0
    return 1.0 - back_to(late, bend, run.omega[0]) / length


@compiled
def _is_watched(kind: int, run: SteppedRun) -> bool:
    """Return whether events of a kind can happen now."""
    if kind == TURNING:
        # does anything depend on the direction of θ̇?
        return run.system.drag_has_kink or run.system.feels_impulse
    if kind == KINK:
        return run.system.kinked
    if kind == IMPULSE:
        return run.state.armed
    return run.system.has_weight if kind == AT_SLACK else True


@compiled
def _on_polynomials(
    run: SteppedRun,
    mode: Mode,
    stalled: bool,
    searched: bool,
    place: StepPlace,
    at_end: Instant,
    exits: Exits,
) -> tuple[int, float]:
    """Return the kind of the first event within the step and its fraction, by the polynomials.

    An event is detected by its values at the beginning and at the end of the step. If the step has
    a turning point, later kinds are compared at that point instead of the end, since the motion
    may come back after it. A step with perhaps several turning points is `searched` for the first.
    """
    system, step = run.system, StepWatch(run, mode, place)
    fill_integrals(run.omega, run.work)
    event, xi, reach = NO_EVENT, NOWHERE, 1.0
    at_reach = at_end
    for kind in range(IMPULSE if stalled else TURNING, AT_SLACK + 1):
        if not _is_watched(kind, run):
            continue
        at_last = event_value(kind, system, mode, at_reach)
        last_x = reach if at_last <= 0.0 else NOWHERE
        watch = WatchEvent(kind, step)
        if searched and kind == TURNING:
            last_x, at_last = _first_below(watch, at_last)
        if last_x > 1.0 and _may_dip(kind, run, mode):
            last_x, at_last = _dip(kind, event_slope(kind, mode, at_end), step)
        limit = exits.edge if kind == AT_EDGE else exits.slack
        if kind >= AT_EDGE and limit < last_x:
            last_x = limit
            at_last = watch.value(last_x)
        if last_x <= 1.0:
            # No step ends at a smooth turning point, so a rough fraction is enough. A short step
            # refines the fraction of all others except those that end the run.
            smooth = kind == TURNING and not system.drag_has_kink
            precision = 1e-2 if smooth else (1e-6 if kind < AT_EDGE else 1e-13)
            located = locate(watch, last_x, at_last, precision)
            if located < xi:
                event, xi = kind, located
            if kind == TURNING:
                reach = located
                at_reach = step.instant(located)
    return (event, xi) if event != NO_EVENT else (NO_EVENT, 1.0)


# -----------------------------------------------------------------------------
# Short steps to an event, from the nearer end of its step.

MAX_HOPS, MAX_CARRIES = 4, 8
"""Most short steps to an event, and most midpoint rules after each of them."""


@inlined
def _drift(end: Planes, omega: Omega, drift: tuple[Plane, ...], time: float) -> tuple[Plane, ...]:
    """Return X and Y of each plane after a short time [s] at constant rates `drift`."""
    planes: tuple[Plane, ...] = ()
    for p in range(len(omega)):
        x, y = end[p].x + time * drift[p].x, end[p].y + time * drift[p].y / omega[p]
        planes = (*planes, Plane(x, y))
    return planes


@compiled
def _carry(
    kind: int, xi: float, run: SteppedRun, mode: Mode, place: StepPlace
) -> tuple[float, float]:
    """Carry `work.end` from ξ to an event near it; return the fractions of both afterwards.

    If the event is `near_phase` or more away, the state stays, and another short step is due.
    Otherwise the midpoint rule carries it, with an error of the third order in the time. Newton's
    method gives the time from value and slope of the event, with the slope halfway. The rule is
    repeated while the change of the slope leaves too large an error, as after a release.
    """
    system, omega, work = run.system, run.omega, run.work
    end = work.end
    length = place.size * place.length
    for _ in range(MAX_CARRIES):
        at = outside_at(place.terms, place.begin + xi * place.size, work)
        now = system.instant(mode, omega, planes_of(omega, end), at)
        value, fall = event_value(kind, system, mode, now), event_slope(kind, mode, now)
        if not fall < 0.0:
            return xi, xi
        late = -value / fall
        reached = xi + late / length
        if not 0.0 < reached <= 1.0:
            return xi, xi
        if not omega[0] * abs(late) < run.tolerance.near_phase:
            return xi, reached
        halfway = _drift(end, omega, system.drift(mode, omega, at, now), 0.5 * late)
        at = outside_at(place.terms, place.begin + 0.5 * (xi + reached) * place.size, work)
        now = system.instant(mode, omega, halfway, at)
        mean = event_slope(kind, mode, now)
        late *= fall / mean if mean < 0.0 else 1.0
        planes = _drift(end, omega, system.drift(mode, omega, at, now), late)
        for p in range(len(omega)):
            end[p].x, end[p].y = planes[p].x, planes[p].y
        xi += late / length
        change = mean / fall - 1.0
        if omega[0] * abs(late) * change * change <= run.tolerance.settled:
            break
    return xi, xi


@compiled
def step_to_event(kind: int, xi: float, run: SteppedRun, mode: Mode, place: StepPlace) -> float:
    """Step to an event expected near ξ, from the nearer end of the step; return its fraction.

    `work.end` is first the state at the end of the step and then the state at the event. If the
    tilt does not act, the short step starts at the beginning: forward and back is not symmetric in
    time, and its energy errors would add up in an undamped swing.
    """
    system, omega, work = run.system, run.omega, run.work
    end = work.end
    at_xi = 1.0
    if xi <= 0.5 or not system.feels_tilt:
        copy_planes(omega, run.state.planes, end)
        at_xi = 0.0
    for _ in range(MAX_HOPS):
        if xi <= 0.0:
            copy_planes(omega, run.state.planes, end)
            return 0.0
        hop = StepPlace(
            place.length, place.terms, place.begin + at_xi * place.size, (xi - at_xi) * place.size
        )
        system.at_nodes(hop, work)
        step = Step(system, mode, omega, hop.size * hop.length, PART_STEP, end, work)
        collocate(step, run.tolerance.settled)
        finish(step)
        at_xi = xi
        if expects_events(system):
            at_xi, xi = _carry(kind, xi, run, mode, place)
        if at_xi == xi:
            break
    return at_xi
