"""When, within a step of the trochlea, an event happens first.

Told by the end of the step where that is enough, else found on the stage polynomials. What travels
together is that of events.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from tauto_core.curves.levers import LinearLever
from tauto_core.kernels import compiled, overload
from tauto_core.motion.events import (
    ARMED,
    AT_EDGE,
    AT_SLACK,
    DIRECTION,
    IMPULSE,
    KINK,
    NO_EVENT,
    SIDE,
    STATE,
    TURNING,
    UNSURE,
    feels_impulse,
    has_weight,
    slope,
    turns_abruptly,
    value_of_state,
)
from tauto_core.motion.lanes import lane, largest, least, load, width
from tauto_core.motion.layout import back_to
from tauto_core.motion.outside import (
    GRAVITY,
    LINE_BEND,
    LINE_RATE,
    OUTSIDE_ROW,
    TILT_RATE,
    X_ROW,
    Y_ROW,
    forcing_at,
    node_row,
    outside_at,
)
from tauto_core.motion.roots import locate, value_of
from tauto_core.motion.turning import FRACTIONS, between, expand
from tauto_core.motion.wells import (
    acceleration,
    angle_at,
    kinked,
    lever_arm,
    mass_of,
    pull_of,
    rate_of,
    resistance,
    ride,
    shape_at,
    term,
)

DISCERNED = 1e-7
"""Part of the slope at a step's end that its beginning must fall with to count as falling."""

CLEAR = 0.05
"""Part of a step's largest angle that its nodes keep from a kink that is surely not passed."""

WELL_WITHIN = 0.97
"""Part of the range within which all nodes of a step must lie, that all of it surely does."""

BENT = 0.25
"""Part of its slope by which an event's value may bend between there and the end of the step."""


class Watch(NamedTuple):
    """What tells an event's value within a step; of a negative kind, its time derivative less."""

    kind: int
    limits: Any
    well: Any
    mode: Any
    omega: Any
    floats: Any
    place: Any
    work: Any


@overload(value_of)
def _value_within(watch: Any, xi: Any) -> Any:
    if getattr(watch, 'instance_class', None) is not Watch:
        return None

    def within(watch: Any, xi: Any) -> Any:
        kind, limits, well, mode, omega, floats, place, work = watch
        length, terms, x0, hx = place
        x, y = between(omega, 0, hx * length, xi, floats, work)
        if kind == KINK:
            return mode[0] * angle_at(well, x)
        if kind == IMPULSE:
            tilt = outside_at(terms, x0 + xi * hx, work)[1][0]
            return limits[0] - mode[1] * (angle_at(well, x) + tilt)
        at = forcing_at(terms, x0 + xi * hx, work)
        state = acceleration(well, mode, x, omega[0] * y, at)
        if kind < 0:
            return -slope(-kind, mode, state, at)
        return value_of_state(kind, limits, mode, state)

    return within


def _node_state(well: Any, mode: Any, omega: Any, felt: Any, work: Any) -> Any:
    """Return q and q̇ at the stages."""
    raise TypeError('_node_state runs in compiled code only')


@overload(_node_state)
def _node_state_of(well: Any, mode: Any, omega: Any, felt: Any, work: Any) -> Any:
    if well[2] is None:

        def angle(well: Any, mode: Any, omega: Any, felt: Any, work: Any) -> Any:
            q, w = load(work, X_ROW), omega[0] * load(work, Y_ROW)
            t = lever_arm(well[1], mode[0], q)[0]
            line_rate = node_row(felt[0], work, OUTSIDE_ROW + LINE_RATE)
            return q, rate_of(well[0][0], t, w, line_rate)

        return angle

    def arc(well: Any, mode: Any, omega: Any, felt: Any, work: Any) -> Any:
        n, _, _, q = shape_at(well[2], well[1].rate, load(work, X_ROW))
        line_rate = node_row(felt[0], work, OUTSIDE_ROW + LINE_RATE)
        return q, n * (omega[0] * load(work, Y_ROW) - line_rate * n)

    return arc


@compiled
def _node_tension(well: Any, mode: Any, q: Any, rate: Any, felt: Any, work: Any) -> Any:
    """Return the thread's tension over I at the stages."""
    machine, lever, _ = well
    mu = machine[0]
    t, t1, lift = lever_arm(lever, mode[0], q)
    v = rate + node_row(felt[1], work, OUTSIDE_ROW + TILT_RATE)
    pull = pull_of(machine, lift, node_row(felt[2], work, OUTSIDE_ROW + GRAVITY))
    pushed = pull * t + resistance(machine, v, mode) + ride(mu, t, t1, rate)
    bend = -(pushed + node_row(felt[0], work, OUTSIDE_ROW + LINE_BEND)) / mass_of(mu, t)
    # lanes, whatever the terms are
    return 0.0 * q + (pull + term(mu, t1 * (rate * rate) + t * bend))


def _surely_within(limits: Any, well: Any, omega: Any, felt: Any, work: Any) -> bool:
    """Return whether rough bounds show that no node is past the edge, and no thread slack."""
    raise TypeError('_surely_within runs in compiled code only')


@overload(_surely_within)
def _surely_within_of(limits: Any, well: Any, omega: Any, felt: Any, work: Any) -> Any:
    if getattr(well[1], 'instance_class', None) is not LinearLever:
        return lambda limits, well, omega, felt, work: False

    def linear(limits: Any, well: Any, omega: Any, felt: Any, work: Any) -> Any:
        # |q| ≤ |x| and M · tension = pull + μ t' q̇² − μ t (γ̈ + resistance), in either coordinate
        machine, lever, _ = well
        x = load(work, X_ROW)
        none = 0.0 * x
        reach = largest(x)
        line_rate = largest(none + node_row(felt[0], work, OUTSIDE_ROW + LINE_RATE))
        line_bend = largest(none + node_row(felt[0], work, OUTSIDE_ROW + LINE_BEND))
        tilt_rate = largest(none + node_row(felt[1], work, OUTSIDE_ROW + TILT_RATE))
        speed = omega[0] * largest(load(work, Y_ROW)) + line_rate + tilt_rate
        pull = pull_of(machine, 0.0, node_row(felt[2], work, OUTSIDE_ROW + GRAVITY))
        pushed = line_bend + resistance(machine, speed, (1.0, 1.0, 1.0))
        against = term(machine[0], lever.rate * reach * pushed)
        return reach <= limits[1] and least(none + pull) > against

    return linear


@compiled
def limit_passed(limits: Any, well: Any, mode: Any, omega: Any, felt: Any, work: Any) -> Any:
    """Return (the first node past the cam's edge, the first with a slack thread); 2: none."""
    edge = slack = 2.0
    if _surely_within(limits, well, omega, felt, work):
        return edge, slack
    nodes = load(work, FRACTIONS)
    q, rate = _node_state(well, mode, omega, felt, work)
    if largest(q) > limits[1]:
        for i in range(width(q) - 1, -1, -1):
            edge = lane(nodes, i) if abs(lane(q, i)) > limits[1] else edge
    if has_weight(well[0]):
        tension = _node_tension(well, mode, q, rate, felt, work)
        if least(tension) <= 0.0:
            for i in range(width(q) - 1, -1, -1):
                slack = lane(nodes, i) if lane(tension, i) <= 0.0 else slack
    return edge, slack


@compiled
def _dip(
    kind: int,
    rises: float,
    limits: Any,
    well: Any,
    mode: Any,
    omega: Any,
    floats: Any,
    place: Any,
    work: Any,
) -> tuple[float, float]:
    """Return where in the step an event's value is lowest between two passages, and the value.

    (2, 0) where it is not: only a value that falls at first and rises at last passes zero twice.
    What breaks loose from friction falls by a rounding at most.

    Args:
        rises: time derivative of the value at the end of the step.
    """
    falling = Watch(-kind, limits, well, mode, omega, floats, place, work)
    if not (rises > 0.0 and value_of(falling, 0.0) > DISCERNED * rises):
        return 2.0, 0.0
    xi = locate(falling, 1.0, -rises, 1e-3)
    value = value_of(Watch(kind, limits, well, mode, omega, floats, place, work), xi)
    return (xi, value) if value < 0.0 else (2.0, 0.0)


@compiled
def _may_dip(kind: int, mode: Any, machine: Any, work: Any) -> bool:
    """Return whether an event's value may pass zero twice within the step.

    Not the angle, where no node is near the kink: between two nodes it is no more bent than that.
    """
    if kind == KINK:
        q = load(work, X_ROW)
        return least(mode[0] * q) < CLEAR * largest(q)
    return kind == TURNING and turns_abruptly(machine)


@compiled
def turns_quietly(
    limits: Any, passed: Any, well: Any, place: Any, after: Any, floats: Any, ints: Any, work: Any
) -> bool:
    """Turn where a turning point lies within the step, and at most an impulse after it.

    Args:
        passed: as `limit_passed` returns.
        after: `acceleration` at the end of the step.
    """
    d, side = float(ints[DIRECTION]), float(ints[SIDE])
    if turns_abruptly(well[0]) or min(passed[0], passed[1]) <= 1.0 or not d * after[1] < 0.0:
        return False
    if ints[ARMED] == 1:
        return False
    q = load(work, X_ROW)
    size = largest(q)
    # the turning point lies farther out than the end, and than the beginning, which may be where
    # the last impulse was
    if not -d * after[0] < limits[0]:
        tilt = outside_at(place[1], place[2], work)[1][0]
        if not -d * (angle_at(well, floats[STATE]) + tilt) < limits[0] + DISCERNED * size:
            return False
    if not size <= WELL_WITHIN * limits[1]:
        return False
    if kinked(well[1]) and not (side * after[4] > 0.0 and least(side * q) >= CLEAR * size):
        return False
    ints[DIRECTION] = -ints[DIRECTION]
    ints[ARMED] = 1
    return True


@compiled
def by_the_end(
    limits: Any,
    passed: Any,
    well: Any,
    mode: Any,
    armed: bool,
    omega: Any,
    h: float,
    w: float,
    at: Any,
    after: Any,
    felt: Any,
    work: Any,
) -> tuple[int, float]:
    """Return the only event within a step of h and about its fraction, by the step's end alone.

    UNSURE where more may have happened than one passage in the second half of the step.

    Args:
        passed: as `limit_passed` returns.
        armed: whether an impulse is due in this swing.
        w: ωY at the beginning.
        at: `forcing_at` the end of the step.
        after: `acceleration` there.
    """
    machine, lever, _ = well
    side, d, _ = mode
    inside = min(passed[0], passed[1]) > 1.0 and abs(after[4]) < limits[1]
    if not inside or (has_weight(machine) and not after[5] > 0.0):
        return UNSURE, 1.0
    if turns_abruptly(machine) or (feels_impulse(machine) and not d * after[1] > 0.0):
        return UNSURE, 1.0
    if kinked(lever) and side * after[4] > 0.0 and side * after[2] > 0.0:
        # where it leaves the kink from the beginning on, it passed none
        line_rate = 0.0 * load(work, X_ROW) + node_row(felt[0], work, OUTSIDE_ROW + LINE_RATE)
        if not side * w > largest(line_rate) and _may_dip(KINK, mode, machine, work):
            return UNSURE, 1.0
    kick = armed and not d * after[0] < limits[0]
    kink = kinked(lever) and not side * after[4] > 0.0
    if not kick and not kink:
        return NO_EVENT, 1.0
    kicked = _back_to(IMPULSE, limits, mode, omega, h, at, after) if kick else 2.0
    crossed = _back_to(KINK, limits, mode, omega, h, at, after) if kink else 2.0
    first, apart = min(kicked, crossed), abs(kicked - crossed)
    if not first > 0.5 or (kick and kink and not apart > 0.5 * (1.0 - first)):
        return UNSURE, 1.0
    return IMPULSE if kicked < crossed else KINK, first


@compiled
def _back_to(
    kind: int, limits: Any, mode: Any, omega: Any, h: float, at: Any, after: Any
) -> float:
    """Return the fraction of a step at which a value was zero, by its slope at the end.

    0 where the slope changes so much since then that this would be far off.
    """
    fall = slope(kind, mode, after, at)
    late = value_of_state(kind, limits, mode, after) / fall
    bend = after[3] / after[2] if kind == KINK else (after[3] + at[1][2]) / after[1]
    if not (fall < 0.0 and abs(bend * late) < BENT):
        return 0.0
    return 1.0 - back_to(late, bend, omega[0]) / h


@compiled
def first_event(
    limits: Any,
    passed: Any,
    well: Any,
    mode: Any,
    omega: Any,
    armed: bool,
    stalled: bool,
    floats: Any,
    at: Any,
    after: Any,
    place: Any,
    work: Any,
) -> tuple[int, float]:
    """Return the kind of the first event within the step and its fraction of the step.

    What is reached before a turning point and left again after it is looked for at that point.

    Args:
        passed: as `limit_passed` returns.
        armed: whether an impulse is due in this swing.
        stalled: whether turning points and kinks are passed over, since time stands still.
        at: `forcing_at` the end of the step.
        after: `acceleration` there.
    """
    machine, lever, _ = well
    length, terms, x0, hx = place
    expand(1, work)
    first, xi, reach = NO_EVENT, 2.0, 1.0
    state = after
    for kind in range(IMPULSE if stalled else TURNING, AT_SLACK + 1):
        at_last = value_of_state(kind, limits, mode, state)
        last = reach if at_last <= 0.0 else 2.0
        if kind == TURNING and not (turns_abruptly(machine) or feels_impulse(machine)):
            continue
        if kind == KINK and not kinked(lever):
            continue
        if kind == IMPULSE and not armed:
            continue
        if kind == AT_SLACK and not has_weight(machine):
            continue
        watch = Watch(kind, limits, well, mode, omega, floats, place, work)
        if last > 1.0 and _may_dip(kind, mode, machine, work):
            rises = slope(kind, mode, after, at)
            last, at_last = _dip(kind, rises, limits, well, mode, omega, floats, place, work)
        if kind >= AT_EDGE and passed[kind - AT_EDGE] < last:
            last = passed[kind - AT_EDGE]
            at_last = value_of(watch, last)
        if last <= 1.0:
            # a smooth turning point need not be stepped to; a slack thread's value has no slope
            rough = kind == TURNING and not turns_abruptly(machine)
            precision = 1e-2 if rough else (1e-6 if kind < AT_EDGE else 1e-13)
            located = locate(watch, last, at_last, precision)
            if located < xi:
                first, xi = kind, located
            if kind == TURNING:
                reach = located
                q, y = between(omega, 0, hx * length, located, floats, work)
                there = forcing_at(terms, x0 + located * hx, work)
                state = acceleration(well, mode, q, omega[0] * y, there)
    return first, xi
