"""Free-end steps on a kinked cam: to the kink or to the impulse, whichever comes first.

The law of the side on which a step begins is continued over the kink, and the times of both
events are found at its end. A half swing is a step over the turning point and a short one between
kink and impulse, which lie apart by the tilt of the neutral line.
"""

from __future__ import annotations

import math

from tauto_core.kernels import inlined
from tauto_core.motion.free_step import (
    HOLDS,
    LONGEST,
    MISSES,
    MOST_LENGTHS,
    SHORTEST,
    FreeEnd,
    FreeHalfSwing,
    FreeState,
    Moving,
    arc_sine,
    end_of,
    event_after,
    fill_from_spans,
    given_by_impulse,
    holds,
    late_for_impulse,
    late_for_kink,
    longer_by_gravity,
    moving,
    settle,
    ship_at,
    span_at,
    to_impulse,
)
from tauto_core.motion.gauss_step import (
    PART_STEP,
    Mode,
    Step,
    fill_rotations,
    start_stages,
)
from tauto_core.motion.lanes import (
    fma,
    row_of,
    store,
)
from tauto_core.motion.passages import count_step, signs_at_nodes
from tauto_core.motion.system import (
    NOWHERE,
    Instant,
    Outside,
    Plane,
    RunningState,
    SteppedRun,
)
from tauto_core.motion.wheel import (
    Wheel,
)

AT_ONCE = 1e-9
"""Phase from the kink to the impulse, or back, within which both happen at one place [rad]."""

SHORT, MOST_LATE = 0.3, 0.05
"""Longest step to an event that lies ahead, over half a swing on land; and the largest error of a
predicted length, over the length, at which a step is not made anew.
"""

ONWARD_SWEEPS = 2
"""Least sweeps of such a step: it is short."""


@inlined
def goes_on(state: RunningState) -> bool:
    """Return whether kink or impulse come before the turning point of θ."""
    return state.armed or state.side * state.direction < 0


@inlined
def expected_s(run: SteppedRun, half: FreeHalfSwing, free: FreeState, free_end: FreeEnd) -> float:
    """Return the time to the next kink or impulse, whichever comes first [s]."""
    wheel, state, plane = half.system, run.state, run.state.planes[0]
    d, q, y = float(state.direction), plane.x, plane.y - free.line_rate / run.omega[0]
    per_size = 1.0 / math.sqrt(q * q + y * y)
    if goes_on(state):
        reach = 0.0
        if state.armed:
            k, x = span_at(half, 0.0)
            reach = wheel.impulse - d * ship_at(half, k, x).tilt.value
        return (arc_sine(reach * per_size) - arc_sine(d * q * per_size)) / run.omega[0]
    k, x = span_at(half, free_end.usual_s)
    then, quicker = ship_at(half, k, x), 1.0
    k, x = span_at(half, 0.5 * free_end.usual_s)
    middle = ship_at(half, k, x)
    # the neutral line, as it turns in the middle of the half swing, shifts the centre
    shift = d * middle.drive.bend / (run.omega[0] * run.omega[0])
    since = arc_sine((d * q + shift) * per_size)
    if wheel.felt.gravity is not None:
        quicker = longer_by_gravity(half, free, middle, then)
    # from kink to kink a larger swing takes another time; heavier, the same Y is a smaller one
    larger_by = quicker / (per_size * free_end.swing) - 1.0 - free_end.spent
    time = 1.0 + larger_by * (free_end.slower + larger_by * free_end.slower_yet)
    half_s = free_end.usual_s * quicker * time
    reach = min(0.0, wheel.impulse + d * then.tilt.value)
    return half_s + (arc_sine((reach - shift) * per_size) - since) / run.omega[0]


@inlined
def _act(
    run: SteppedRun,
    half: FreeHalfSwing,
    free: FreeState,
    mode: Mode,
    struck: bool,
    there: Plane,
    at: Outside,
    now: Moving,
    since: float,
) -> None:
    """Let an impulse or the kink act on the state `there`, a short time after an instant."""
    state, plane, turns = run.state, run.state.planes[0], not goes_on(run.state)
    added = 0.0
    if struck:
        added = given_by_impulse(half.system, mode, there, run.omega, now, at, since, state.given)
    plane.x, plane.x_rest, plane.y_rest = there.x, 0.0, 0.0
    plane.y = there.y + added
    free.line_rate, free.gravity = at.drive.rate + since * at.drive.bend, at.gravity
    if turns:
        state.direction = -state.direction
    if struck:
        state.armed, state.pallet = False, state.direction
        state.given += 1
    else:
        state.armed, state.side = turns, -state.side


@inlined
def _to_event(
    run: SteppedRun, half: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next kink or impulse and let it act, or leave all as it is.

    Returns HOLDS or MISSES, and the length of the step [s].
    """
    wheel, omega, state, work = half.system, run.omega, run.state, run.work
    plane, onward = state.planes[0], goes_on(state)
    way = float(state.direction) if onward else -float(state.direction)
    mode = Mode(float(state.side), way, float(state.pallet))
    h = expected_s(run, half, free, free_end)
    if onward and omega[0] * abs(h) < AT_ONCE:
        k, x = span_at(half, 0.0)
        at = ship_at(half, k, x)
        now = moving(wheel, mode, omega, Plane(plane.x, plane.y), at)
        _act(run, half, free, mode, state.armed, Plane(plane.x, plane.y), at, now, 0.0)
        return HOLDS, 0.0
    usual_s, least, settled, struck = (
        free_end.usual_s,
        free_end.sweeps,
        free_end.settled,
        state.armed,
    )
    shortest, longest = SHORTEST * usual_s, LONGEST * usual_s
    if onward:
        shortest, longest, least = 0.0, SHORT * usual_s, ONWARD_SWEEPS
    for n in range(MOST_LENGTHS):
        if not shortest < h < longest:
            break
        fill_from_spans(half, h, work)
        k, x = span_at(half, h)
        at = ship_at(half, k, x)
        step = Step(wheel, mode, omega, h, PART_STEP, state.planes, work)
        fill_rotations(step)
        if n == 0:
            start_stages(step)
            if not onward:
                store(work.u, 0, fma(row_of(work.nodes.land_u), plane.y, plane.x))
                store(work.v, 0, fma(row_of(work.nodes.land_v), plane.y, plane.y))
        if not settle(step, least, settled * abs(plane.y), n > 0):
            break
        end = end_of(run, h)
        now = moving(wheel, mode, omega, end.plane, at)
        if not (way * now.rate > 0.0 and way * now.speed > 0.0):
            break
        late, impulse = late_for_kink(way, now, omega), late_for_impulse(wheel, way, now, omega)
        if not onward:
            struck = impulse < late
        if struck:
            late = impulse
        if omega[0] * abs(late) > free_end.near or abs(late) > MOST_LATE * h:
            h += late
            continue
        if not holds(run, half, mode, free_end.error, h):
            break
        found = signs_at_nodes(wheel.coordinates(work), plane.x < 0.0, NOWHERE, work)
        late, since, at, now, there = event_after(
            run, half, mode, h, late, end, at, now, free_end, struck
        )
        _act(run, half, free, mode, struck, there, at, now, since)
        count_step(True, found, run, 0, 0.0)
        return HOLDS, h + late
    return MISSES, 0.0


@inlined
def to_next(
    run: SteppedRun, half: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next event, as `to_impulse`."""
    if half.system.kinked:
        return _to_event(run, half, free, free_end)
    return to_impulse(run, half, free, free_end)


@inlined
def is_past(wheel: Wheel, state: RunningState, now: Instant | Moving) -> bool:
    """Return whether the next event of a state is past at an instant."""
    d = float(state.direction)
    if wheel.kinked:
        onward = goes_on(state)
        way = d if onward else -d
        struck = (state.armed or not onward) and not way * now.angle < wheel.impulse
        crossed = not state.armed and not state.side * now.coordinate > 0.0
        return (onward or way * now.rate > 0.0) and (struck or crossed)
    return d * now.rate < 0.0 and not -d * now.angle < wheel.impulse
