"""The first event within a step, and when it happens.

Most steps are decided by the state at their end, at the price of one instant. Only where more than
one event may have happened are the stage polynomials evaluated.
"""

from __future__ import annotations

from typing import NamedTuple

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.events import (
    AT_EDGE,
    AT_SLACK,
    IMPULSE,
    KINK,
    NO_EVENT,
    TURNING,
    UNSURE,
    alternates,
    event_slope,
    event_value,
    is_due,
)
from tauto_core.motion.gauss_step import fill_integrals
from tauto_core.motion.lanes import largest, least
from tauto_core.motion.layout import back_to
from tauto_core.motion.outside import Place, outside_at
from tauto_core.motion.roots import locate
from tauto_core.motion.system import (
    NOWHERE,
    Beyond,
    Instant,
    Mode,
    Run,
    Watch,
    mode_of,
    planes_of,
)

DISCERNED = 1e-7
"""Least fall of a value at the beginning of a step, as a share of its slope at the end; less is
rounding. The same share of the largest angle tells two turning points from rounding.
"""

KINK_APART = 0.05
"""Distance of all nodes from a kink that is surely not passed between two of them, as a share of
the largest angle of the step.
"""

BENT = 0.25
"""Largest relative change of the slope of an event's value between the event and the end of the
step for which the event is found from that end.
"""


class WatchEvent(NamedTuple):
    """An event's value within a step; for a negative kind, minus its time derivative."""

    kind: int
    step: Watch

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
    run: Run, stalled: bool, place: Place, after: Instant, beyond: Beyond
) -> tuple[int, float]:
    """Return the first event within a step that must be stepped to, and its fraction.

    At a turning point where drag has no kink nothing changes but the direction of the state,
    which is changed here: no step to it is needed.

    Args:
        run: the run; its state is that at the beginning.
        stalled: whether turning points and kinks are passed over, after several without progress.
        place: place of the step.
        after: the system at its end.
        beyond: whether it leaves the range.
    """
    system, state = run.system, run.state
    d = float(state.direction)
    turned = not stalled and _turns_quietly(run, place, after, beyond)
    if turned and -d * after.angle < system.impulse:
        return NO_EVENT, 1.0
    mode = mode_of(state)
    event, xi = _by_the_end(run, mode, place, after, beyond)
    if event == UNSURE:
        event, xi = _on_polynomials(run, mode, stalled, place, after, beyond)
    if event == TURNING and _turns_smoothly(xi, run, mode, place, after, beyond):
        return NO_EVENT, 1.0
    return event, xi


@inlined
def _inside(beyond: Beyond) -> bool:
    """Return whether all nodes lie within the range, with the thread taut."""
    return min(beyond.edge, beyond.slack) > 1.0


@inlined
def _watches_turning(run: Run) -> bool:
    """Return whether anything depends on the direction of θ̇."""
    return run.system.turns_abruptly or run.system.feels_impulse


@compiled
def _turns_quietly(run: Run, place: Place, after: Instant, beyond: Beyond) -> bool:
    """Reverse the direction if the step has a turning point and, at most, an impulse after it.

    Decided by the end of the step and its nodes; False means that this is not known.
    """
    system, state, work = run.system, run.state, run.work
    d, side = float(state.direction), float(state.side)
    if not system.feels_impulse or system.turns_abruptly:
        return False
    if state.armed or not _inside(beyond) or not d * after.rate < 0.0:
        return False
    # The next impulse acts at −d θ = angle. At the turning point −d θ is smaller than at either
    # end of the step, so that it is due if one of them lies before that angle. The beginning may
    # be where the last impulse acted, at that very angle.
    if not -d * after.angle < system.impulse:
        at = outside_at(place.terms, place.begin, work)
        angle = system.wheel_angle(planes_of(run.omega, state.planes), at)
        if not -d * angle < system.impulse + DISCERNED * beyond.reach:
            return False
    if not beyond.within:
        return False
    if system.kinked:
        nearest = least(side * system.coordinates(work))
        if not (side * after.coordinate > 0.0 and nearest >= KINK_APART * beyond.reach):
            return False
    state.direction = -state.direction
    state.armed = alternates(system, state, float(state.direction))
    return True


@compiled
def _turns_smoothly(
    xi: float, run: Run, mode: Mode, place: Place, after: Instant, beyond: Beyond
) -> bool:
    """Reverse the direction if the turning point found at ξ is all that happens in the step."""
    system, state = run.system, run.state
    if system.turns_abruptly or system.kinked or not _inside(beyond):
        return False
    if not (after.margin > 0.0 and after.tension > 0.0):
        return False
    there, back = Watch(run, mode, place).instant(xi), -mode.direction
    armed = is_due(system, state, back, there.angle)
    if not back * after.rate > 0.0 or (armed and not back * after.angle < system.impulse):
        return False
    state.direction = -state.direction
    state.armed = armed
    return True


@compiled
def _may_dip(kind: int, run: Run, mode: Mode) -> bool:
    """Return whether an event's value may pass zero, and back, between two nodes of the step.

    The coordinate may not where no node is near the kink: it bends too little on the way.
    """
    system = run.system
    if system.kinked and kind == KINK:
        felt = system.coordinates(run.work)
        return least(mode.side * felt) < KINK_APART * largest(felt)
    return system.turns_abruptly and kind == TURNING


@compiled
def _dip(kind: int, rises: float, step: Watch) -> tuple[float, float]:
    """Return where in the step an event's value is lowest, and that value, if it is negative.

    (NOWHERE, 0) otherwise. Only a value that falls at first and rises at last passes zero twice.
    That of a wheel which has just broken loose from friction falls by a rounding at most, and does
    not count as falling.

    Args:
        kind: the kind of the event.
        rises: time derivative of the value at the end of the step.
        step: the step.
    """
    falling = WatchEvent(-kind, step)
    if not (rises > 0.0 and falling.value(0.0) > DISCERNED * rises):
        return NOWHERE, 0.0
    xi = locate(falling, 1.0, -rises, 1e-3)
    value = WatchEvent(kind, step).value(xi)
    return (xi, value) if value < 0.0 else (NOWHERE, 0.0)


@compiled
def _by_the_end(
    run: Run, mode: Mode, place: Place, after: Instant, beyond: Beyond
) -> tuple[int, float]:
    """Return the only event within a step and its approximate fraction, by the state at its end.

    UNSURE unless the event lies in the second half of the step, and no other near it.
    """
    system, state, work = run.system, run.state, run.work
    side, d = mode.side, mode.direction
    inside = _inside(beyond) and after.margin > 0.0
    if system.turns_abruptly or not inside or (system.has_weight and not after.tension > 0.0):
        return UNSURE, 1.0
    if system.feels_impulse and not d * after.rate > 0.0:
        return UNSURE, 1.0
    if system.kinked and side * after.coordinate > 0.0 and side * after.speed > 0.0:
        # where it leaves the kink from the beginning on, it passed none
        leaves = system.leaves_kink(mode, run.omega, state.planes, work)
        if not leaves and _may_dip(KINK, run, mode):
            return UNSURE, 1.0
    struck = state.armed and not d * after.angle < system.impulse
    crossed = system.kinked and not side * after.coordinate > 0.0
    if not struck and not crossed:
        return NO_EVENT, 1.0
    length = place.size * place.length
    impulse = _back_to(IMPULSE, run, mode, length, after) if struck else NOWHERE
    kink = _back_to(KINK, run, mode, length, after) if crossed else NOWHERE
    first, apart = min(impulse, kink), abs(impulse - kink)
    if not first > 0.5 or (struck and crossed and not apart > 0.5 * (1.0 - first)):
        return UNSURE, 1.0
    return IMPULSE if impulse < kink else KINK, first


@compiled
def _back_to(kind: int, run: Run, mode: Mode, length: float, after: Instant) -> float:
    """Return the fraction of a step at which an event's value was zero, by the step's end.

    0 if its slope has changed too much since then for the estimate to be good.

    Args:
        kind: of the event.
        run: the run.
        mode: of the step.
        length: of the step [s].
        after: the system at its end.
    """
    fall = event_slope(kind, mode, after)
    late = event_value(kind, run.system, mode, after) / fall
    bend = after.acceleration / after.speed if kind == KINK else after.bend / after.rate
    if not (fall < 0.0 and abs(bend * late) < BENT):
        return 0.0
    return 1.0 - back_to(late, bend, run.omega[0]) / length


@compiled
def _is_watched(kind: int, run: Run) -> bool:
    """Return whether events of a kind can happen now."""
    if kind == TURNING:
        return _watches_turning(run)
    if kind == KINK:
        return run.system.kinked
    if kind == IMPULSE:
        return run.state.armed
    return run.system.has_weight if kind == AT_SLACK else True


@compiled
def _on_polynomials(
    run: Run, mode: Mode, stalled: bool, place: Place, after: Instant, beyond: Beyond
) -> tuple[int, float]:
    """Return the kind of the first event within the step and its fraction of the step.

    Values are compared at the beginning and at the end of the step; kinds that come after a
    turning point in it are compared at that point instead of the end, since what is reached before
    it may be left again after it.
    """
    system, step = run.system, Watch(run, mode, place)
    fill_integrals(run.omega, run.work)
    first, xi, reach = NO_EVENT, NOWHERE, 1.0
    there = after
    for kind in range(IMPULSE if stalled else TURNING, AT_SLACK + 1):
        if not _is_watched(kind, run):
            continue
        at_last = event_value(kind, system, mode, there)
        last = reach if at_last <= 0.0 else NOWHERE
        watch = WatchEvent(kind, step)
        if last > 1.0 and _may_dip(kind, run, mode):
            last, at_last = _dip(kind, event_slope(kind, mode, after), step)
        limit = beyond.edge if kind == AT_EDGE else beyond.slack
        if kind >= AT_EDGE and limit < last:
            last = limit
            at_last = watch.value(last)
        if last <= 1.0:
            # A smooth turning point is not stepped to, so that its place may be rough. Other
            # events are carried to their place afterwards, but for those that end the run.
            smooth = kind == TURNING and not system.turns_abruptly
            precision = 1e-2 if smooth else (1e-6 if kind < AT_EDGE else 1e-13)
            located = locate(watch, last, at_last, precision)
            if located < xi:
                first, xi = kind, located
            if kind == TURNING:
                reach = located
                there = step.instant(located)
    return (first, xi) if first != NO_EVENT else (NO_EVENT, 1.0)
