"""Free-end steps of Sully's lever and of the swinging thread: from impulse to impulse.

The length of a step is predicted from the ship's motion in its middle, and by how much the last
half swing the same way was longer than predicted. It is corrected before the last two sweeps of
the stages, since few predictions are near. `free_end` has the whole.
"""

from __future__ import annotations

import math

from tauto_core.kernels import inlined
from tauto_core.motion.free_step import (
    HOLDS,
    MISSES,
    MOST_LENGTHS,
    FreeEnd,
    FreeHalfSwing,
    FreeState,
    StepEnd,
    arc_sine,
    fill_from_spans,
    settle,
    ship_at,
    span_at,
    time_until,
)
from tauto_core.motion.gauss_step import (
    PART_STEP,
    Mode,
    Step,
    fill_rotations,
    start_stages,
)
from tauto_core.motion.lanes import fma, row_of, total
from tauto_core.motion.passages import count_step, signs_at_nodes
from tauto_core.motion.stepping import step_error
from tauto_core.motion.system import (
    NOWHERE,
    Instant,
    Plane,
    SteppedRun,
    planes_of,
)

SHORTEST_ON_THREAD, LONGEST_ON_THREAD = 0.6, 1.5
"""Least and greatest length of a half swing, over that on land: the sea moves a thread more."""

LIKELY = 0.7, 1.3
"""Least and greatest length of a half swing with which the first sweeps are made, over that on
land."""

LATER = 2
"""Least sweeps after the length of a step was corrected, or corrected again: only two show whether
the stages settle. All others are made before.
"""


@inlined
def time_to_impulse(run: SteppedRun, half: FreeHalfSwing, usual_s: float) -> float:
    """Return about the time to the next impulse [s].

    The swing is taken as harmonic about its centre, as in `ThreadSystem.ahead_s`. Gravity and what
    shifts the centre are those in the middle of the half swing: of what changes evenly that is the
    mean. No library is called, since arc tangents take as long as a sweep of the stages.
    """
    system, state = half.system, run.state
    way = -float(state.direction)
    mode = Mode(float(state.side), way, float(state.pallet))
    k, x = span_at(half, 0.5 * usual_s)
    at = ship_at(half, k, x)
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
    found: tuple[StepEnd, ...] = ()
    for p in range(len(omega)):
        start, over = run.state.planes[p], work.rotations[PART_STEP * len(omega) + p]
        u = start.x + h * total(weights * row_of(work.k1, p))
        v = start.y + h * total(weights * row_of(work.k2, p))
        found = (*found, StepEnd(u, v, over.cos, over.sin))
    return found


@inlined
def _planes_at(run: SteppedRun, ends: tuple[StepEnd, ...]) -> tuple[Plane, ...]:
    """Return X and Y of each plane at the end of a step."""
    found: tuple[Plane, ...] = ()
    for p in range(len(run.omega)):
        found = (*found, ends[p].plane)
    return found


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
    found: tuple[Plane, ...] = ()
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
        found = (*found, Plane(x - versine * x + sine * y, y - versine * y - sine * x))
    return found


@inlined
def _moved_on(now: Instant, late: float, pace: float) -> Instant:
    """Return what an impulse asks for a short time after an instant, as of a harmonic swing."""
    less = 0.5 * (pace * late) * (pace * late)
    return Instant(
        angle=now.angle,
        rate=now.rate + late * now.bend - less * now.rate,
        bend=now.bend,
        tension=now.tension,
        margin=now.margin,
        torque=now.torque,
        coordinate=now.coordinate + late * (now.speed + 0.5 * late * now.acceleration),
        speed=now.speed + late * now.acceleration - less * now.speed,
        acceleration=now.acceleration,
    )


@inlined
def holds_on_thread(
    run: SteppedRun, half: FreeHalfSwing, mode: Mode, error: float, h: float
) -> bool:
    """Return whether a step is exact enough, within range, and clear of tilt and impulse."""
    system, omega, work = half.system, run.omega, run.work
    tail, last, size = row_of(work.tail), 0.0, 0.0
    for p in range(len(omega)):
        start = run.state.planes[p]
        last = max(last, abs(total(tail * row_of(work.k1, p))))
        last = max(last, abs(total(tail * row_of(work.k2, p))))
        size = max(size, start.x * start.x + start.y * start.y)
    if not step_error(run.tolerance.factor, last * h / math.sqrt(size), False) <= error:
        return False
    if not system.clear(half.square, omega, work):
        return False
    beyond = system.beyond(mode, omega, work)
    return beyond.within and beyond.edge > 1.0 and beyond.slack > 1.0 and not beyond.near


@inlined
def to_impulse_on_thread(
    run: SteppedRun, half: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next impulse and let it act, or leave all as it is.

    Returns HOLDS or MISSES, and the length of the step [s].
    """
    system, omega, state, work = half.system, run.omega, run.state, run.work
    way, usual_s, pace = -float(state.direction), free_end.usual_s, system.pace
    mode = Mode(float(state.side), way, float(state.pallet))
    size = 0.0
    for p in range(len(omega)):
        size = max(size, abs(state.planes[p].y))
    expected = time_to_impulse(run, half, usual_s)
    h = expected * lasting(run, free)
    h = min(max(h, LIKELY[0] * usual_s), LIKELY[1] * usual_s)
    for n in range(MOST_LENGTHS):
        if not SHORTEST_ON_THREAD * usual_s < h < LONGEST_ON_THREAD * usual_s:
            return MISSES, 0.0
        fill_from_spans(half, h, work)
        step = Step(system, mode, omega, h, PART_STEP, state.planes, work)
        fill_rotations(step)
        if n == 0:
            start_stages(step)
        least = max(free_end.sweeps - LATER, 1) if n == 0 else LATER
        if not settle(step, least, free_end.settled * size, n > 0):
            return MISSES, 0.0
        k, x = span_at(half, h)
        at, ends = ship_at(half, k, x), _ends(run, h)
        now = system.instant(mode, omega, _planes_at(run, ends), at)
        if not way * now.rate > 0.0:
            return MISSES, 0.0
        left = system.impulse - way * now.angle
        late = time_until(left, way, now.rate, now.bend, (pace,))
        if n == 0 or pace * abs(late) > free_end.near:
            h += late
            continue
        if not holds_on_thread(run, half, mode, free_end.error, h):
            return MISSES, 0.0
        below = system.coordinate(planes_of(omega, state.planes)) < 0.0
        found = signs_at_nodes(system.coordinates(work), below, NOWHERE, work)
        there = _planes_later(run, h, late, ends, system.drift(mode, omega, at, now))
        for p in range(len(omega)):
            plane = state.planes[p]
            plane.x, plane.y, plane.x_rest, plane.y_rest = there[p].x, there[p].y, 0.0, 0.0
        system.strike(mode, omega, at, _moved_on(now, late, pace), state)
        state.direction = -state.direction
        state.armed, state.pallet = False, state.direction
        state.given += 1
        count_step(True, found, run, 0, 0.0)
        if state.direction < 0:
            free.forth = (h + late) / expected
        else:
            free.back = (h + late) / expected
        return HOLDS, h + late
    return MISSES, 0.0
