"""The trochlea stepped through spans of forcing: collocation between events, in one plane.

`system` is the trochlea as `turning` takes it; `well`, `mode`, `place`, `limits`, `floats` and
`ints` are those of events.
"""

from __future__ import annotations

import math
from typing import Any

from tauto_core.kernels import compiled, entry
from tauto_core.motion import turning
from tauto_core.motion.arrival import step_to_event
from tauto_core.motion.event_search import by_the_end, first_event, limit_passed, turns_quietly
from tauto_core.motion.events import (
    ARMED,
    AT_EDGE,
    AT_SLACK,
    BEATS,
    DIRECTION,
    HELD,
    HELD_ANGLE,
    LEVEL,
    NEWTON,
    NO_EVENT,
    PALLET,
    SIDE,
    STATE,
    TURNING,
    TURNS,
    UNSURE,
    expects_events,
    feels_case,
    feels_drag,
    feels_impulse,
    happen,
    hold,
    mode_of,
    set_off,
    turns_abruptly,
)
from tauto_core.motion.lanes import pointer
from tauto_core.motion.layout import BEYOND, CROWDED, lay_out, phase_to
from tauto_core.motion.outside import (
    forcing_at,
    forcing_at_nodes,
    outside_at,
    presence,
    set_piece,
)
from tauto_core.motion.passages import APART, ahead
from tauto_core.motion.rotation import sum_exactly
from tauto_core.motion.step_size import step_error
from tauto_core.motion.turning import (
    PART_STEP,
    WHOLE_STEP,
    collocate,
    copy_state,
    finish,
    pointers,
)
from tauto_core.motion.wells import (
    acceleration,
    angle_at,
    kinked,
    lever_arm,
)
from tauto_core.motion.wheel_passages import clear_square, count, in_ride, in_step, swings_clear
from tauto_core.motion.wheel_plane import Trochlea

OK, EDGE, SLACK, NO_CONVERGENCE = 0, 1, 2, 3
ROW = 8
MAX_EVENTS = 10_000
"""Most events that may crowd."""

MAX_STALLED = 4
HALF_SWING = 3.25
"""Longest step within which events are looked for, as the angle it turns [rad]."""

MAX_LEVEL = 24


@compiled
def _turns_smoothly(
    xi: float,
    limits: Any,
    passed: Any,
    well: Any,
    omega: Any,
    place: Any,
    floats: Any,
    ints: Any,
    after: Any,
    work: Any,
) -> bool:
    """Turn without a step to the turning point, where nothing happens there or after it."""
    length, terms, x0, hx = place
    if turns_abruptly(well[0]) or kinked(well[1]) or min(passed[0], passed[1]) <= 1.0:
        return False
    mode = mode_of(ints)
    q, y = turning.between(omega, 0, hx * length, xi, floats, work)
    there = acceleration(well, mode, q, omega[0] * y, forcing_at(terms, x0 + xi * hx, work))
    back = -ints[DIRECTION]
    if abs(after[4]) >= limits[1] or not after[5] > 0.0:
        return False
    armed = back * there[0] < limits[0]
    if not back * after[1] > 0.0 or (armed and not back * after[0] < limits[0]):
        return False
    ints[DIRECTION] = back
    ints[ARMED] = 1 if armed else 0
    return True


@compiled
def _first_event(
    limits: Any,
    passed: Any,
    well: Any,
    omega: Any,
    stalled: bool,
    h: float,
    at: Any,
    after: Any,
    felt: Any,
    place: Any,
    floats: Any,
    ints: Any,
    work: Any,
) -> tuple[int, float]:
    """Return the first event within a step of h that must be stepped to, and its fraction.

    Turning points at which nothing happens are none; they are taken note of.
    """
    d = float(ints[DIRECTION])
    turned = not stalled and turns_quietly(limits, passed, well, place, after, floats, ints, work)
    if turned and -d * after[0] < limits[0]:
        return NO_EVENT, 1.0
    mode, armed = mode_of(ints), ints[ARMED] == 1
    w = omega[0] * floats[STATE + 2]
    event, xi = by_the_end(limits, passed, well, mode, armed, omega, h, w, at, after, felt, work)
    if event == UNSURE:
        event, xi = first_event(
            limits, passed, well, mode, omega, armed, stalled, floats, at, after, place, work
        )
    if event == TURNING and _turns_smoothly(
        xi, limits, passed, well, omega, place, floats, ints, after, work
    ):
        event = NO_EVENT
    return event, xi


@compiled
def _ride(
    limits: Any, system: Any, omega: Any, place: Any, floats: Any, ints: Any, work: Any
) -> tuple[int, float, float]:
    """Let the held wheel ride with the case, over hx or until it breaks loose; as `_move`."""
    machine, lever, shape, felt = system
    well = machine, lever, shape
    loose = hold(limits, well, omega, felt, place, floats, ints, work)
    found = in_ride(loose, place, floats, work)
    count(False, found, well, omega, place[1], place[2] + loose * place[3], floats, ints, work)
    return NO_EVENT, loose, 0.0


@compiled
def _move(
    tolerance: Any,
    limits: Any,
    system: Any,
    place: Any,
    omega: Any,
    stalled: bool,
    clear: float,
    piece: Any,
    floats: Any,
    ints: Any,
    memory: Any,
) -> tuple[int, float, float]:
    """Advance over hx or to the first event, and count what passes zero on the way.

    Args:
        clear: as `clear_square` returns.
        piece: forcing, and which of its pieces the step lies in.

    Returns the event, the fraction and the error.
    """
    machine, lever, shape, felt = system
    length, terms, x0, hx = place
    work, end, h = memory.work, memory.end, hx * length
    well = machine, lever, shape
    if ints[HELD]:
        return _ride(limits, system, omega, place, floats, ints, work)
    mode = mode_of(ints)
    kind = PART_STEP if expects_events(well) and feels_case(machine) else WHOLE_STEP
    forcing_at_nodes(felt, feels_drag(machine), place, work)
    last, newton = collocate(system, mode, omega, h, kind, tolerance[2], floats, memory)
    error = step_error(tolerance[1], last, newton)
    passed = limit_passed(limits, well, mode, omega, felt, work)
    inside = min(passed[0], passed[1]) > 1.0
    if not inside and omega[0] * h > HALF_SWING:
        # where the motion ends is found in shorter steps
        error = math.inf
    if not error <= tolerance[0]:
        return NO_EVENT, 0.0, error
    ints[NEWTON] += 1 if newton else 0
    finish(omega, h, kind, floats, memory)
    large = swings_clear(clear, work)
    if inside and not expects_events(well):
        found = in_step(large, 2.0, 1.0, well, mode, omega, piece, place, floats, work)
        copy_state(1, end, floats)
        count(large, found, well, omega, terms, x0 + hx, floats, ints, work)
        return NO_EVENT, 1.0, error
    at = forcing_at(terms, x0 + hx, work)
    after = acceleration(well, mode, end[0], omega[0] * end[2], at)
    event, xi = _first_event(
        limits, passed, well, omega, stalled, h, at, after, felt, place, floats, ints, work
    )
    before = 2.0 if event == NO_EVENT else xi - APART
    found = in_step(large, before, xi, well, mode, omega, piece, place, floats, work)
    if event == NO_EVENT:
        copy_state(1, end, floats)
        count(large, found, well, omega, terms, x0 + hx, floats, ints, work)
        return event, 1.0, error
    mode = mode_of(ints)
    xi = step_to_event(event, xi, limits, tolerance, system, mode, omega, place, floats, memory)
    copy_state(1, end, floats)
    at = forcing_at(terms, x0 + xi * hx, work)
    state = acceleration(well, mode, end[0], omega[0] * end[2], at)
    happen(event, limits, well, omega, at, state, floats, ints)
    count(large, found, well, omega, terms, x0 + xi * hx, floats, ints, work)
    return event, xi, error


@compiled
def _write(well: Any, omega: Any, at: Any, floats: Any, ints: Any, row: Any) -> None:
    """Fill θ, θ̇, ϑ, ϑ̇, ϑ̈, torque/I, turns and beats."""
    held = ints[HELD] == 1
    side, d, s = mode_of(ints)
    mode = side, 0.0 if held else d, s
    x, y = floats[STATE], floats[STATE + 2]
    angle, v, rate, bend, q, tension = acceleration(well, mode, x, omega[0] * y, at)
    if held:
        angle, v, bend = floats[HELD_ANGLE], 0.0, -at[1][2]
    t = lever_arm(well[1], mode[0], q)[0]
    row[0], row[1], row[2], row[3], row[4] = angle, v, q, rate, bend
    row[5] = -tension * t
    row[6], row[7] = ints[TURNS], ints[BEATS] + ahead(x, rate, angle)


@entry
def release(
    release_angle: float,
    omega: Any,
    limits: Any,
    well: Any,
    forcing: Any,
    x0: float,
    floats: Any,
    ints: Any,
    memory: Any,
    row: Any,
) -> None:
    """Set the state: the wheel at rest in the case at the beginning of the first span."""
    work = pointers(memory).work
    at = forcing_at(set_piece(forcing, 0, True, work)[1], x0, work)
    ints[:] = 0
    ints[SIDE] = ints[DIRECTION] = 1
    ints[PALLET] = -1 if release_angle < 0.0 else 1
    set_off(limits, well, omega, release_angle, at, floats, ints)
    _write(well, omega, at, floats, ints, row)
    ints[BEATS], row[7] = -int(row[7]), 0


@compiled
def _ahead_s(
    limits: Any,
    well: Any,
    omega: Any,
    length: float,
    terms: int,
    x: float,
    floats: Any,
    ints: Any,
    work: Any,
) -> float:
    """Return the time to a little after the next event to expect [s], or inf.

    The swing goes on about the line as that moves now, as fast as gravity lets it on the way.
    """
    machine, lever, _ = well
    ahead, pace = math.inf, omega[0]
    if not expects_events(well) or ints[HELD]:
        return ahead
    side, d, _ = mode_of(ints)
    line, tilt, gravity = outside_at(terms, x, work)
    q, y = angle_at(well, floats[STATE]), floats[STATE + 2] - line[1] / omega[0]
    if feels_impulse(machine):
        way = d if ints[ARMED] else -d
        ahead = phase_to(way, q, y, limits[0] - way * tilt[0])
        if ahead < math.inf:
            _, tilt, then = outside_at(terms, min(x + ahead / (pace * length), 1.0), work)
            ahead = phase_to(way, q, y, limits[0] - way * tilt[0])
            gravity = 0.5 * (gravity + then)
    if kinked(lever):
        ahead = min(ahead, phase_to(-side, q, y, 0.0))
    if gravity > 0.0:
        pace *= math.sqrt(gravity / limits[2])
    return (ahead + BEYOND) / pace


@compiled
def _coarsen(worst: float, tolerance: Any, ints: Any) -> None:
    """Let steps double where none in the span erred by more than that would cost."""
    if ints[LEVEL] > 0 and worst < tolerance[4]:
        ints[LEVEL] -= 1


@entry
def advance(
    tolerance: Any,
    longest_s: float,
    omega: Any,
    limits: Any,
    well: Any,
    forcing: Any,
    spans: Any,
    floats: Any,
    ints: Any,
    memory: Any,
    rows: Any,
) -> tuple[int, int, float]:
    """Advance the state over all spans and fill a row for every logged one.

    Args:
        tolerance: error allowed a step relative to the state, `error_factor` of the machine, how
            far the stages are iterated, how near an event the state is carried to it [rad], and
            the error below which steps double.
        longest_s: longest step [s].
        spans: begin, end, logged.

    Returns a code (OK, EDGE, SLACK, NO_CONVERGENCE), the span and the fraction of its piece.
    """
    begin, end, logged = spans
    machine, lever, shape = well
    felt = presence(forcing[1]), presence(forcing[2]), presence(forcing[3])
    system = Trochlea(machine, lever, shape, felt)
    memory, floats, ints = pointers(memory), pointer(floats), pointer(ints)
    work = memory.work
    written = 0
    for k in range(len(begin)):
        worst, events, stalled = 0.0, 0, 0
        # Time is where a stretch starts, twofold, a cell of it and a fraction of that: it keeps
        # its resolution in spans of a day.
        start, low, whole, cells, cell, f = begin[k], 0.0, 0.0, 0, 0, 0.0
        length, terms = set_piece(forcing, k, feels_case(machine) or logged[k], work)
        per_s, last = 1.0 / length, False
        clear = clear_square(well, omega, forcing, k)
        while not last or cell < cells:
            if cell == cells:
                start, low = sum_exactly(start, low + whole)
                ahead_s = _ahead_s(limits, well, omega, length, terms, start, floats, ints, work)
                left = (end[k] - start) - low
                whole, cells = lay_out(left, per_s, longest_s, ahead_s, ints[LEVEL])
                cell, f, last = 0, 0.0, whole == left
            x = start + (low + (cell + f) / cells * whole)
            place = length, terms, x, (1.0 - f) / cells * whole
            kind, xi, error = _move(
                tolerance,
                limits,
                system,
                place,
                omega,
                stalled > MAX_STALLED,
                clear,
                (forcing, k),
                floats,
                ints,
                memory,
            )
            if not error <= tolerance[0]:
                ints[LEVEL] += 1
                if ints[LEVEL] > MAX_LEVEL:
                    return NO_CONVERGENCE, k, place[2]
                half = 1 if f >= 0.5 else 0
                cell, cells, f = 2 * cell + half, 2 * cells, 2.0 * f - half
                continue
            worst = max(worst, error)
            reached = 1.0 if xi >= 1.0 else f + xi * (1.0 - f)
            stalled = stalled + 1 if reached == f else 0
            crowded = reached < 1.0 and xi * place[3] * length * omega[0] < CROWDED
            events = events + 1 if crowded else 0
            cell, f = (cell + 1, 0.0) if reached == 1.0 else (cell, reached)
            done = last and cell == cells
            x = end[k] if done else start + (low + (cell + f) / cells * whole)
            if kind in (AT_EDGE, AT_SLACK):
                return (EDGE if kind == AT_EDGE else SLACK), k, x
            if kind != NO_EVENT and not done:
                whole *= (cell + f) / cells
                cells, cell, last = 0, 0, False
            if events > MAX_EVENTS:
                return NO_CONVERGENCE, k, x
        _coarsen(worst, tolerance, ints)
        if logged[k]:
            at = forcing_at(terms, end[k], work)
            _write(well, omega, at, floats, ints, rows[written])
            written += 1
    return OK, 0, 0.0
