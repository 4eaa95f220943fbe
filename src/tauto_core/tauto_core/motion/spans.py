"""A mechanism stepped through spans of forcing: collocation between events, in any planes.

Events (`span_events`) are stepped to; the end of the range and a slack thread end the run. What a
mechanism is, overloads of the functions of `mechanism` say for its type of `system`; `place` as
there. `floats` begin with the state.
"""

from __future__ import annotations

import math
from typing import Any

from tauto_core.kernels import compiled, entry
from tauto_core.motion.lanes import pointer
from tauto_core.motion.layout import BEYOND, CROWDED, lay_out, phase_to
from tauto_core.motion.mechanism import (
    ACCELERATION,
    ANGLE,
    BEND,
    COORDINATE,
    MARGIN,
    RATE,
    SPEED,
    TENSION,
    TORQUE,
    at_nodes,
    instant,
)
from tauto_core.motion.outside import outside_at, set_piece
from tauto_core.motion.passages import APART, ahead
from tauto_core.motion.rotation import sum_exactly
from tauto_core.motion.span_events import (
    ARMED,
    AT_EDGE,
    AT_SLACK,
    AT_TURNING,
    BEATS,
    DIRECTION,
    INTS,
    LEVEL,
    NEVER,
    NEWTON,
    NO_EVENT,
    PALLET,
    TURNS,
    count,
    first_event,
    happen,
    mode_of,
    passed,
    swings_clear,
    value,
)
from tauto_core.motion.step_size import step_error
from tauto_core.motion.turning import (
    PART_STEP,
    WHOLE_STEP,
    between,
    collocate,
    copy_state,
    expand,
    finish,
    pointers,
)

__all__ = ['INTS', 'LEVEL', 'NEWTON', 'advance', 'release']

OK, EDGE, SLACK, NO_CONVERGENCE = 0, 1, 2, 3
ROW = 8
MAX_EVENTS = 10_000
"""Most events that may crowd."""

MAX_STALLED = 4
MAX_LEVEL = 24
NEAR = 1e-8
"""Angle of turning within which one more step of Newton's method is exact to rounding [rad]."""

COARSEN = 2.0**-17
"""Part of the tolerance below which steps double: their error grows by 2^16."""


@compiled
def _carry(
    kind: int,
    xi: float,
    angle: float,
    tolerance: Any,
    system: Any,
    mode: Any,
    omega: Any,
    place: Any,
    hop: float,
    start: Any,
    memory: Any,
) -> tuple[float, float]:
    """Carry a state that is near an event to it; return where it is, and where the event is.

    Both as fractions of the step. It is carried along the polynomials of the step of `hop` from
    `start` that led to it.
    """
    _, terms, x0, hx = place
    d, length, end = mode[0], hx * place[0], memory.end
    expand(len(omega), memory.work)
    done = 1.0
    for _ in range(4):
        now = instant(system, mode, omega, end, outside_at(terms, x0 + xi * hx, memory.work))
        slope = d * now[BEND] if kind == AT_TURNING else -d * now[RATE]
        if kind >= AT_EDGE or not slope < 0.0:
            return xi, xi
        late = -value(kind, angle, d, now) / slope
        reached = xi + late / length
        if not 0.0 < reached <= 1.0:
            return xi, xi
        if not omega[0] * abs(late) <= tolerance[3]:
            return xi, reached
        for p in range(len(omega)):
            x, y = between(omega, p, hop, done, start, memory.work)
            to_x, to_y = between(omega, p, hop, done + late / hop, start, memory.work)
            end[4 * p] += to_x - x
            end[4 * p + 2] += to_y - y
        done += late / hop
        xi = reached
        if omega[0] * abs(late) <= NEAR:
            break
    return xi, xi


@compiled
def _step_to_event(
    kind: int,
    xi: float,
    angle: float,
    tolerance: Any,
    system: Any,
    mode: Any,
    omega: Any,
    place: Any,
    floats: Any,
    memory: Any,
    scratch: Any,
) -> float:
    """Step to an event from the nearer end of the step; return the fraction where it is."""
    length, terms, x0, hx = place
    planes, part, end = len(omega), PART_STEP, memory.end
    there = 1.0
    if xi <= 0.5:
        copy_state(planes, floats, end)
        there = 0.0
    for _ in range(4):
        if xi <= 0.0:
            copy_state(planes, floats, end)
            return 0.0
        copy_state(planes, end, scratch)
        at_nodes(system, (length, terms, x0 + there * hx, (xi - there) * hx), memory.work)
        hop = (xi - there) * hx * length
        collocate(system, mode, omega, hop, part, tolerance[2], scratch, memory)
        finish(omega, hop, part, scratch, memory)
        there, xi = _carry(
            kind, xi, angle, tolerance, system, mode, omega, place, hop, scratch, memory
        )
        if there == xi:
            break
    return there


@compiled
def _move(
    tolerance: Any,
    phase_rate: float,
    watched: Any,
    system: Any,
    omega: Any,
    stalled: bool,
    place: Any,
    now: Any,
    floats: Any,
    ints: Any,
    memory: Any,
    scratch: Any,
) -> Any:
    """Advance over hx or to the first event, and count what passes zero on the way.

    Args:
        now: `instant` at the beginning.

    Returns the event, the fraction of hx, the error, and `instant` where the event has happened.
    """
    length, terms, x0, hx = place
    mode, h, planes = mode_of(ints), hx * length, len(omega)
    kind = WHOLE_STEP if watched[0] == NEVER else PART_STEP
    at_nodes(system, place, memory.work)
    settled = tolerance[2]
    last, newton = collocate(system, mode, omega, h, kind, settled, floats, memory)
    error = step_error(tolerance[1], last, newton)
    if not error <= tolerance[0]:
        return NO_EVENT, 0.0, error, now
    ints[NEWTON] += 1 if newton else 0
    finish(omega, h, kind, floats, memory)
    after = instant(system, mode, omega, memory.end, outside_at(terms, x0 + hx, memory.work))
    event, xi = first_event(
        watched, system, mode, omega, ints, stalled, place, after, floats, memory, scratch
    )
    clear, before = swings_clear(phase_rate, now, after), 2.0 if event == NO_EVENT else xi - APART
    found = passed(clear, before, xi, system, mode, omega, place, now, floats, memory, scratch)
    if event != NO_EVENT:
        mode = mode_of(ints)
        xi = _step_to_event(
            event, xi, watched[1], tolerance, system, mode, omega, place, floats, memory, scratch
        )
    copy_state(planes, memory.end, floats)
    if event != NO_EVENT and event < AT_EDGE:
        at = outside_at(terms, x0 + xi * hx, memory.work)
        happen(event, watched, system, omega, at, floats, ints)
        after = instant(system, mode_of(ints), omega, floats, at)
    count(found, after, ints)
    return event, xi, error, after


@compiled
def _write(now: Any, ints: Any, row: Any) -> None:
    """Fill θ, θ̇, torque/I, the phase's coordinate, its rate and bend, turns and beats."""
    row[0], row[1], row[2] = now[ANGLE], now[RATE], now[TORQUE]
    row[3], row[4], row[5] = now[COORDINATE], now[SPEED], now[ACCELERATION]
    row[6] = ints[TURNS]
    row[7] = ints[BEATS] + ahead(now[COORDINATE], now[SPEED], now[ANGLE])


@entry
def release(
    watched: Any,
    pallet: int,
    system: Any,
    omega: Any,
    forcing: Any,
    x0: float,
    floats: Any,
    ints: Any,
    work: Any,
    row: Any,
) -> tuple[float, float]:
    """Set what goes with a state in which the wheel lies at rest in the case.

    `pallet`: the direction of the last impulse. Returns the tension and the margin, which must be
    positive.
    """
    at = outside_at(set_piece(forcing, 0, True, work)[1], x0, work)
    ints[:] = 0
    ints[PALLET] = pallet
    now = instant(system, mode_of(ints), omega, floats, at)
    ints[DIRECTION] = -1 if now[BEND] < 0.0 else 1
    ints[ARMED] = 1 if ints[DIRECTION] * now[ANGLE] < watched[1] < math.inf else 0
    _write(now, ints, row)
    ints[BEATS], row[7] = -int(row[7]), 0
    return now[TENSION], now[MARGIN]


@compiled
def _ahead_s(
    pace: float,
    watched: Any,
    now: Any,
    length: float,
    terms: int,
    x: float,
    ints: Any,
    work: Any,
) -> float:
    """Return the time to a little after the next impulse to expect [s], or inf.

    The swing goes on about its centre as that moves with the case now, as fast as gravity lets it
    on the way.

    Args:
        pace: of the swing [rad/s].
        now: `instant`, at x in the piece.
    """
    way = float(ints[DIRECTION] if ints[ARMED] else -ints[DIRECTION])
    _, tilt, gravity = outside_at(terms, x, work)
    pace *= math.sqrt(gravity / watched[2])
    centre = now[ANGLE] + now[BEND] / (pace * pace)
    y = (now[RATE] + tilt[1]) / pace
    ahead = phase_to(way, now[ANGLE] - centre, y, watched[1] - way * centre)
    if ahead < math.inf:
        _, then, later = outside_at(terms, min(x + ahead / (pace * length), 1.0), work)
        moved = centre - (then[0] - tilt[0])
        ahead = phase_to(way, now[ANGLE] - centre, y, watched[1] - way * moved)
        pace *= math.sqrt(0.5 * (1.0 + later / gravity))
    return (ahead + BEYOND) / pace


@compiled
def _span(
    k: int,
    tolerance: Any,
    phase_rate: float,
    longest_s: float,
    watched: Any,
    system: Any,
    omega: Any,
    piece: tuple[float, int],
    spans: Any,
    floats: Any,
    ints: Any,
    memory: Any,
    scratch: Any,
) -> tuple[int, float]:
    """Advance over one span; return a code and, of a failure, the fraction of the piece."""
    begin, end, _ = spans
    worst, events, stalled = 0.0, 0, 0
    work = memory.work
    # Time is where a stretch starts, twofold, a cell of it and a fraction of that: it keeps its
    # resolution in spans of a day.
    start, low, whole, cells, cell, f = begin[k], 0.0, 0.0, 0, 0, 0.0
    length, terms = piece
    per_s, last, ahead_s = 1.0 / length, False, math.inf
    pace = omega[0] if len(omega) == 1 else phase_rate
    now = instant(system, mode_of(ints), omega, floats, outside_at(terms, start, work))
    while not last or cell < cells:
        if cell == cells:
            start, low = sum_exactly(start, low + whole)
            if watched[1] < math.inf:
                ahead_s = _ahead_s(pace, watched, now, length, terms, start, ints, work)
            left = (end[k] - start) - low
            whole, cells = lay_out(left, per_s, longest_s, ahead_s, ints[LEVEL])
            cell, f, last = 0, 0.0, whole == left
        x = start + (low + (cell + f) / cells * whole)
        place = length, terms, x, (1.0 - f) / cells * whole
        pause = stalled > MAX_STALLED
        kind, xi, error, after = _move(
            tolerance,
            phase_rate,
            watched,
            system,
            omega,
            pause,
            place,
            now,
            floats,
            ints,
            memory,
            scratch,
        )
        if not error <= tolerance[0]:
            ints[LEVEL] += 1
            if ints[LEVEL] > MAX_LEVEL:
                return NO_CONVERGENCE, x
            half = 1 if f >= 0.5 else 0
            cell, cells, f = 2 * cell + half, 2 * cells, 2.0 * f - half
            continue
        now, worst = after, max(worst, error)
        reached = 1.0 if xi >= 1.0 else f + xi * (1.0 - f)
        stalled = stalled + 1 if reached == f else 0
        crowded = reached < 1.0 and xi * place[3] * length * pace < CROWDED
        events = events + 1 if crowded else 0
        cell, f = (cell + 1, 0.0) if reached == 1.0 else (cell, reached)
        done = last and cell == cells
        x = end[k] if done else start + (low + (cell + f) / cells * whole)
        if kind >= AT_EDGE or events > MAX_EVENTS:
            return EDGE if kind == AT_EDGE else SLACK if kind == AT_SLACK else NO_CONVERGENCE, x
        if kind != NO_EVENT and not done:
            whole *= (cell + f) / cells
            cells, cell, last = 0, 0, False
    if ints[LEVEL] > 0 and worst < tolerance[0] * COARSEN:
        ints[LEVEL] -= 1
    return OK, 0.0


@entry
def advance(
    tolerance: Any,
    phase_rate: float,
    longest_s: float,
    watched: Any,
    system: Any,
    omega: Any,
    forcing: Any,
    spans: Any,
    floats: Any,
    ints: Any,
    memory: Any,
    scratch: Any,
    rows: Any,
) -> tuple[int, int, float]:
    """Advance the state over all spans and fill a row for every logged one.

    Args:
        tolerance: error allowed a step relative to the state, the error of a step per square of
            its last coefficient, how far its stages are iterated, and how near an event the state
            is carried to it [rad].
        phase_rate: ω of the phase [rad/s].
        longest_s: longest step [s].
        watched: how turning points matter, the angle of the impulse [rad], else inf, and gravity
            at rest.
        system: the mechanism.
        omega: ω of each plane [rad/s].
        forcing: lengths of the pieces; β, τ and g_eff as coefficients in each.
        spans: begin, end, logged.
        floats: the state.
        ints: INTS whole numbers.
        memory: of turning.
        scratch: 4 numbers a plane.
        rows: ROW numbers a logged span.

    Returns a code (OK, EDGE, SLACK, NO_CONVERGENCE), the span and the fraction of its piece.
    """
    written = 0
    memory, floats, ints = pointers(memory), pointer(floats), pointer(ints)
    scratch = pointer(scratch)
    for k in range(len(spans[0])):
        piece = set_piece(forcing, k, True, memory.work)
        code, x = _span(
            k,
            tolerance,
            phase_rate,
            longest_s,
            watched,
            system,
            omega,
            piece,
            spans,
            floats,
            ints,
            memory,
            scratch,
        )
        if code != OK:
            return code, k, x
        if spans[2][k]:
            at = outside_at(piece[1], spans[1][k], memory.work)
            _write(instant(system, mode_of(ints), omega, floats, at), ints, rows[written])
            written += 1
    return OK, 0, 0.0
