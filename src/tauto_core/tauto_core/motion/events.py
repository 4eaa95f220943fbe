"""Events of a system: their effects, the first one within a step, and short steps to it.

The kinds are the turning point of θ, the kink of a cam, the impulse of the escapement, the end of
the range, and a slack thread. Each has a value that is positive before it and negative after it.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

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
"""Kinds of events, in the order in which they are sought. `WatchEvent` uses the negative of a
kind for the instant at which its value stops falling.
"""


@inlined
def expects_events(system: System) -> bool:
    """Return whether any events but the ends of the range and a slack thread can occur."""
    return system.drag_has_kink or system.feels_impulse or system.kinked


@compiled
def event_value(kind: int, system: System, mode: Mode, now: Instant) -> float:
    """Return the value that is positive before an event and negative after it."""
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
    """Return the time derivative of an event's value; 0 for those that end a run."""
    if kind == TURNING:
        return mode.direction * now.bend
    if kind == KINK:
        return mode.side * now.speed
    if kind == IMPULSE:
        return -mode.direction * now.rate
    return 0.0


@inlined
def alternates(system: System, state: RunningState, direction: float) -> bool:
    """Return whether the pallet that pushes in a direction is the one on which a tooth rests.

    After an impulse a tooth falls on the other pallet, and lies there until that has pushed, also
    if the wheel turns back before. The first impulse is given by either pallet, unless recoil
    shows on which a tooth lies at the release.
    """
    return direction != float(state.pallet) or (state.given == 0 and not system.recoils)


@inlined
def is_due(system: System, state: RunningState, direction: float, angle: float) -> bool:
    """Return whether the swing from θ = angle on reaches the angle of an impulse that is due."""
    reaches = direction * angle < system.impulse < math.inf
    return reaches and alternates(system, state, direction)


@compiled
def happen(kind: int, run: SteppedRun, at: Inputs, now: Instant) -> None:
    """Apply an event: change signs and counts of the state, and at an impulse the planes.

    `at` and `now` are the ship and the system there, before the event.
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
# How steps are laid out over a span: so that the next event lies just inside the last of them.
#
# A stretch reaches to the end of the span, or a little beyond the place where the next event is
# expected, and is divided into equal steps. An expected event need not happen: the next stretch
# is laid out from wherever this one ends. Near its end an event costs a short step, which leads
# back to it, and not a second long one.

OVERSHOOT = 0.05
"""Phase by which a stretch ends after the expected event [rad]."""

CROWDED = 1e-3
"""Phase since the last event below which events count as crowded [rad]."""

SPARE = 0.05
"""Share of a step by which steps may be longer than the longest, if that saves one."""


@compiled
def phase_to(way: float, x: float, y: float, reach: float) -> float:
    """Return the phase in (0, 2π] until way·x next rises to `reach`, for x = A sin φ, y = A cos φ.

    `way` is 1 or −1. The phase is infinite if A is at most |reach|.
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

    `late` is the value divided by its rate of change [s], the estimate of first order; `bend` the
    rate of change of that rate, divided by it [1/s]; and `omega` the frequency with which the
    value swings [rad/s], for its third derivative.
    """
    turned = bend * late
    return late * (1.0 + 0.5 * turned * (1.0 + turned) + (omega * late) ** 2 / 6.0)


@compiled
def lay_out(
    remaining: float, per_s: float, longest_s: float, ahead_s: float, level: int
) -> tuple[float, int]:
    """Return the length of the next stretch, in the unit of `remaining`, and its steps.

    `per_s` is a second in that unit, `remaining` the rest of the span, `ahead_s` the time to the
    next event, infinite where none is expected, and `level` how often steps are halved.
    """
    stretch = min(remaining, ahead_s * per_s)
    steps = math.ceil(stretch / (per_s * longest_s) - SPARE)
    # Equal steps: the energy of a swing drifts where the length of steps depends on its phase.
    return stretch, max(1, steps) << level


# -----------------------------------------------------------------------------
# The place within a step at which a value that was positive falls to zero.

FIRST_TRIALS = 12
"""Places tried up to the last fraction, each four times as far on as the one before."""

# Halving alone reaches the last bit of a fraction in 52; this only ends the loop.
MAX_PROBES = 200


class WatchedValue(Protocol):
    """An object with a value within a step: a NamedTuple with this method."""

    def value(self, xi: float) -> float:
        """Return the value at the fraction xi of the step, from the stage polynomials."""


@compiled
def locate(watch: WatchedValue, last_x: float, at_last: float, precision: float) -> float:
    """Return the fraction of the step at which a value falls to zero; 0 if it was never positive.

    `last_x` is a fraction at which it is no longer positive, `precision` the error allowed. By the
    Illinois form of false position (Dowell and Jarratt, BIT 11, 1971, 168). It probes no closer to
    either bound than half the precision: a value that is tiny at the beginning would otherwise
    draw the first probe there, which would be taken for a root.
    """
    a, b, fb = 0.0, last_x, min(at_last, 0.0)
    fa = watch.value(a)
    if not fa > 0.0:
        # A step may begin where the value has just been zero, and have it positive for a moment.
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
# The place within a step from which a condition holds.

HALVINGS = 60
"""As many as leave no doubt in a double."""


class WatchedCondition(Protocol):
    """An object with a condition within a step: a NamedTuple with this method."""

    def holds(self, xi: float) -> bool:
        """Return whether it holds at the fraction xi of the step."""


@compiled
def first_holds(watch: WatchedCondition, probes: int) -> float:
    """Return the first fraction of the step at which a condition holds; 2 if it holds nowhere.

    It is looked at in so many equal parts, and found by bisection in the first at whose end it
    holds.
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
    """The condition that friction no longer holds a system that rests at an angle in the ship."""

    system: System
    mode: Mode
    angle: float
    place: StepPlace
    work: Work

    def holds(self, xi: float) -> bool:
        """Return whether it holds at a fraction of the step."""
        place = self.place
        at = outside_at(place.terms, place.begin + xi * place.size, self.work)
        return self.system.breaks_loose(self.mode, self.angle, at)


@compiled
def ride_held(system: System, run: SteppedRun, place: StepPlace, probes: int) -> float:
    """Move a held system with the ship; return the fraction at which it breaks loose, or 1."""
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
# The first event within a step, and when it happens.
#
# Most steps are decided by the state at their end, at the price of one instant. Only where more
# than one event may have happened are the stage polynomials evaluated.

DISCERNED = 1e-7
"""Least fall of a value at the beginning of a step, as a share of its slope at the end; less is
rounding. The same share of the largest angle distinguishes two turning points from rounding.
"""

KINK_APART = 0.05
"""Distance of all nodes from a kink that is surely not passed between two of them, as a share of
the largest angle of the step.
"""

TURNS_TWICE = 2.0
"""Longest step that surely has no two turning points, as the angle ωh [rad].

They are half a swing apart, and less where the ship turns half as fast as the wheel.
"""

TURNING_PROBES = 16
"""Places at which a longer step is searched for its first turning point."""

BENT = 0.25
"""Largest relative change of the slope of an event's value between the event and the end of the
step for which the event is found from that end.
"""


class WatchEvent(NamedTuple):
    """An event's value within a step; for a negative kind, minus its time derivative."""

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

    At a turning point where drag has no kink nothing changes but the direction of the state, which
    is changed here: no step to it is needed. Turning points and kinks are passed over if
    `stalled`, after several events without progress. Unless the swing is `clear` of tilt and
    impulse, θ may pass the angle of an impulse between two turning points and come back: the end
    of a long step does not show that, so that it is searched, and no turning point passed over.
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
    """Return whether the step lies within the range, with the thread taut."""
    return min(exits.edge, exits.slack) > 1.0 and not exits.is_near


@compiled
def _turns_quietly(run: SteppedRun, place: StepPlace, at_end: Instant, exits: Exits) -> bool:
    """Reverse the direction if the step has a turning point and, at most, an impulse after it.

    Decided by the end of the step and its nodes; False means that this is not known.
    """
    system, state, work = run.system, run.state, run.work
    d, side = float(state.direction), float(state.side)
    if not system.feels_impulse or system.drag_has_kink:
        return False
    if state.armed or not _inside(exits) or not d * at_end.rate < 0.0:
        return False
    # The next impulse acts at −d θ = angle. At the turning point −d θ is smaller than at either
    # end of the step, so that it is due if one of them lies before that angle. The beginning may
    # be where the last impulse acted, at that very angle.
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
    """Reverse the direction if the turning point found at ξ is all that happens in the step."""
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
    """Return whether an event's value may pass zero, and back, between two nodes of the step.

    The coordinate may not where no node is near the kink: it bends too little on the way.
    """
    system = run.system
    if system.kinked and kind == KINK:
        angles = system.coordinates(run.work)
        return lowest(mode.side * angles) < KINK_APART * largest(angles)
    return system.drag_has_kink and kind == TURNING


@compiled
def _dip(kind: int, rises: float, step: StepWatch) -> tuple[float, float]:
    """Return where in the step an event's value is lowest, and that value, if it is negative.

    (NOWHERE, 0) otherwise. Only a value that falls at first and rises at last, at the rate
    `rises`, passes zero twice. That of a wheel which has just broken loose from friction falls by
    a rounding at most, and does not count as falling.
    """
    falling = WatchEvent(-kind, step)
    if not (rises > 0.0 and falling.value(0.0) > DISCERNED * rises):
        return NOWHERE, 0.0
    # near its lowest place the value errs by the square of the error of that place
    xi = locate(falling, 1.0, -rises, 1e-3)
    value = WatchEvent(kind, step).value(xi)
    return (xi, value) if value < 0.0 else (NOWHERE, 0.0)


@compiled
def _first_below(watch: WatchEvent, at_end: float) -> tuple[float, float]:
    """Return the first of `TURNING_PROBES` places in the step where a value is not positive.

    With the value there; (NOWHERE, at_end) if there is none. It may begin at zero and rise, so
    that it counts from where it was positive.
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

    UNSURE unless the event lies in the second half of the step, and no other near it.
    """
    system, state, work = run.system, run.state, run.work
    side, d = mode.side, mode.direction
    is_inside = _inside(exits) and at_end.margin > 0.0
    if system.drag_has_kink or not is_inside or (system.has_weight and not at_end.tension > 0.0):
        return UNSURE, 1.0
    if system.feels_impulse and not d * at_end.rate > 0.0:
        return UNSURE, 1.0
    if system.kinked and side * at_end.coordinate > 0.0 and side * at_end.speed > 0.0:
        # where it leaves the kink from the beginning on, it passed none
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
    """Return the fraction of a step at which an event's value was zero, by the step's end.

    0 if its slope has changed too much since then for the estimate to be good.
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
    """Return the kind of the first event within the step and its fraction of the step.

    Values are compared at the beginning and at the end of the step. If the step holds a turning
    point, kinds after it in the order are compared there instead of at the end, since a value that
    is reached before the turning point may be left again after it. A step that may hold several
    is `searched` for the first of them.
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
            # No step ends at a smooth turning point, so its place may be rough. Most others are
            # carried to their place afterwards; those that end the run are not.
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
# Short steps to an event, from the nearer end of the step in which it lies.

MAX_HOPS, MAX_CARRIES = 4, 8
"""Most short steps to an event, and most repetitions of the midpoint rule after one of them."""


@inlined
def _drift(end: Planes, omega: Omega, drift: tuple[Plane, ...], time: float) -> tuple[Plane, ...]:
    """Return X and Y of each plane after a short time [s], at the rates of `System.drift`."""
    planes: tuple[Plane, ...] = ()
    for p in range(len(omega)):
        x, y = end[p].x + time * drift[p].x, end[p].y + time * drift[p].y / omega[p]
        planes = (*planes, Plane(x, y))
    return planes


@compiled
def _carry(
    kind: int, xi: float, run: SteppedRun, mode: Mode, place: StepPlace
) -> tuple[float, float]:
    """Carry `work.end` to an event near it; return where it is then, and where the event is.

    Both, like ξ where it is before, are fractions of the step. If the event is `near_phase` or
    more away, the state stays and another short step is due. Else the midpoint rule carries it:
    its error is of the third order in the time, which Newton's method finds from value and slope
    of the event, with the slope halfway. It is repeated while the change of the slope on the way
    leaves more than the iteration may, as for a wheel just released.
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
    """Step to an event from the nearer end of the step; return the fraction where it is.

    It is expected near ξ. `work.end` is the state at the end of the step, then that at the event.
    Where nothing drags or pushes, the step is made from the beginning: a step forth and back again
    is not symmetric in time, and its errors in the energy of an undamped swing would add up.
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
