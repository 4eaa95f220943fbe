"""A mechanism stepped through spans of forcing: collocation between events, in any planes.

Events (`span_events`) are stepped to; the end of the range and a slack thread end the run. What a
mechanism is, overloads of the functions of `mechanism` say for its type of `system`; `place` as
there. `floats` begin with the state.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tauto_core.motion.compiled import compiled, entry
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
    outside_at,
)
from tauto_core.motion.span_events import (
    ARMED,
    AT_EDGE,
    AT_SLACK,
    AT_TURNING,
    BEATS,
    DIRECTION,
    EXTRA,
    INTS,
    LAST_X,
    LAST_Y,
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
)

__all__ = ['EXTRA', 'INTS', 'LEVEL', 'NEWTON', 'advance', 'release']

_NOTHING = (0.0,) * 9
OK, EDGE, SLACK, NO_CONVERGENCE = 0, 1, 2, 3
ROW = 8
MAX_EVENTS = 10_000
MAX_STALLED = 4
MAX_LEVEL = 24
FEW = 16
"""Steps of a span that is short enough for them to be laid out anew after an event."""

NEAR = 1e-8
"""Angle of turning over which the polynomials of a step carry a state beyond its end [rad]."""

COARSEN = 2.0**-17
"""Part of the tolerance below which steps double: their error grows by 2^16."""


@compiled
def _carry(omega: Any, h: float, late: float, floats: Any, memory: Any) -> None:
    """Carry the state at the end of a step of h a little further, along its polynomials."""
    expand(len(omega), memory.work)
    for p in range(len(omega)):
        x, y = between(omega, p, h, 1.0, floats, memory.work)
        to_x, to_y = between(omega, p, h, 1.0 + late / h, floats, memory.work)
        memory.end[4 * p] += to_x - x
        memory.end[4 * p + 2] += to_y - y


@compiled
def _step_to_event(
    kind: int,
    xi: float,
    angle: float,
    settled: float,
    system: Any,
    mode: Any,
    omega: Any,
    place: Any,
    floats: Any,
    memory: Any,
) -> float:
    """Step to an event, correct its time by the state found there; return the fraction."""
    forcing, k, x0, hx = place
    d, length, part = mode[0], hx * forcing[0][k], np.int64(PART_STEP)
    for _ in range(4):
        if xi <= 0.0:
            copy_state(len(omega), floats, memory.end)
            return 0.0
        at_nodes(system, (forcing, k, x0, xi * hx), memory.work)
        collocate(system, mode, omega, xi * length, part, settled, floats, memory)
        finish(omega, xi * length, part, floats, memory)
        now = instant(system, mode, omega, memory.end, outside_at(forcing, k, x0 + xi * hx))
        slope = d * now[BEND] if kind == AT_TURNING else -d * now[RATE]
        if kind >= AT_EDGE or not slope < 0.0:
            return xi
        late = -value(kind, angle, d, now) / slope
        reached = xi + late / length
        if not 0.0 < reached <= 1.0:
            return xi
        if omega[0] * abs(late) <= NEAR:
            _carry(omega, xi * length, late, floats, memory)
            return reached
        xi = reached
    return xi


@compiled
def _move(
    tolerance: Any,
    watched: Any,
    system: Any,
    omega: Any,
    stalled: bool,
    place: Any,
    floats: Any,
    ints: Any,
    memory: Any,
    scratch: Any,
) -> Any:
    """Advance over hx or to the first event.

    Returns the event, the fraction of hx, the error, and `instant` at the end of hx.
    """
    forcing, k, x0, hx = place
    mode, h, planes = mode_of(ints), hx * forcing[0][k], len(omega)
    kind = WHOLE_STEP if x0 == 0.0 or watched[0] == NEVER else PART_STEP
    at_nodes(system, place, memory.work)
    settled = tolerance[2]
    last, newton = collocate(system, mode, omega, h, kind, settled, floats, memory)
    error = step_error(tolerance[1], last, newton)
    if not error <= tolerance[0]:
        return NO_EVENT, 0.0, error, _NOTHING
    ints[NEWTON] += 1 if newton else 0
    finish(omega, h, kind, floats, memory)
    after = instant(system, mode, omega, memory.end, outside_at(forcing, k, x0 + hx))
    event, xi = first_event(
        watched, system, mode, omega, ints, stalled, place, after, floats, memory, scratch
    )
    if event == NO_EVENT:
        xi = 1.0
    else:
        xi = _step_to_event(
            event, xi, watched[1], settled, system, mode, omega, place, floats, memory
        )
    copy_state(planes, memory.end, floats)
    return event, xi, error, after


@compiled
def _write(now: Any, ints: Any, row: Any) -> None:
    """Fill θ, θ̇, torque/I, the phase's coordinate, its rate and bend, turns and beats."""
    row[0], row[1], row[2] = now[ANGLE], now[RATE], now[TORQUE]
    row[3], row[4], row[5] = now[COORDINATE], now[SPEED], now[ACCELERATION]
    row[6], row[7] = ints[TURNS], ints[BEATS]


@entry
def release(
    phase_rate: float,
    watched: Any,
    pallet: int,
    system: Any,
    omega: Any,
    forcing: Any,
    x0: float,
    floats: Any,
    ints: Any,
    row: Any,
) -> tuple[float, float]:
    """Set what goes with a state in which the wheel lies at rest in the case.

    `pallet`: the direction of the last impulse. Returns the tension and the margin, which must be
    positive.
    """
    at = outside_at(forcing, 0, x0)
    ints[:] = 0
    ints[PALLET] = pallet
    now = instant(system, mode_of(ints), omega, floats, at)
    ints[DIRECTION] = -1 if now[BEND] < 0.0 else 1
    ints[ARMED] = 1 if ints[DIRECTION] * now[ANGLE] < watched[1] < math.inf else 0
    where = floats[4 * len(omega) :]
    where[LAST_X], where[LAST_Y] = now[COORDINATE], -now[SPEED] / phase_rate
    count(phase_rate, now, where, ints)
    _write(now, ints, row)
    return now[TENSION], now[MARGIN]


@compiled
def _span(
    k: int,
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
) -> tuple[int, float]:
    """Advance over one span; return a code and, of a failure, the fraction of the piece."""
    begin, end, _ = spans
    worst, events, stalled = 0.0, 0, 0
    start, whole = begin[k], end[k] - begin[k]
    where = floats[4 * len(omega) :]
    # Time is a cell and a fraction of it: it keeps its resolution in spans of a day.
    steps = max(1, int(math.ceil(whole * forcing[0][k] / longest_s - 1e-9)))
    cells, cell, f = steps << ints[LEVEL], 0, 0.0
    while cell < cells:
        place = forcing, k, start + (cell + f) / cells * whole, (1.0 - f) / cells * whole
        pause = stalled > MAX_STALLED
        kind, xi, error, now = _move(
            tolerance, watched, system, omega, pause, place, floats, ints, memory, scratch
        )
        if not error <= tolerance[0]:
            ints[LEVEL] += 1
            if ints[LEVEL] > MAX_LEVEL:
                return NO_CONVERGENCE, place[2]
            half = 1 if f >= 0.5 else 0
            cell, cells, f = 2 * cell + half, 2 * cells, 2.0 * f - half
            continue
        worst = max(worst, error)
        reached = 1.0 if xi >= 1.0 else f + xi * (1.0 - f)
        stalled = stalled + 1 if reached == f else 0
        events = 0 if reached == 1.0 else events + 1
        cell, f = (cell + 1, 0.0) if reached == 1.0 else (cell, reached)
        x = end[k] if cell == cells else start + (cell + f) / cells * whole
        if kind >= AT_EDGE or events > MAX_EVENTS:
            return EDGE if kind == AT_EDGE else SLACK if kind == AT_SLACK else NO_CONVERGENCE, x
        if kind != NO_EVENT:
            at = outside_at(forcing, k, x)
            happen(kind, watched, system, omega, at, floats, ints)
            now = instant(system, mode_of(ints), omega, floats, at)
            if cell < cells <= FEW << ints[LEVEL] and events == 1:
                start, whole = x, end[k] - x
                steps = max(1, int(math.ceil(whole * forcing[0][k] / longest_s - 1e-9)))
                cells, cell, f = steps << ints[LEVEL], 0, 0.0
        count(phase_rate, now, where, ints)
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
            its last coefficient, and how far its stages are iterated.
        phase_rate: ω of the phase [rad/s].
        longest_s: longest step [s].
        watched: how turning points matter, and the angle of the impulse [rad], else inf.
        system: the mechanism.
        omega: ω of each plane [rad/s].
        forcing: lengths of the pieces; β, τ and g_eff as coefficients in each.
        spans: begin, end, logged.
        floats: the state, then EXTRA numbers.
        ints: INTS whole numbers.
        memory: of turning.
        scratch: 4 numbers a plane.
        rows: ROW numbers a logged span.

    Returns a code (OK, EDGE, SLACK, NO_CONVERGENCE), the span and the fraction of its piece.
    """
    written = 0
    for k in range(len(spans[0])):
        code, x = _span(
            k,
            tolerance,
            phase_rate,
            longest_s,
            watched,
            system,
            omega,
            forcing,
            spans,
            floats,
            ints,
            memory,
            scratch,
        )
        if code != OK:
            return code, k, x
        if spans[2][k]:
            at = outside_at(forcing, k, spans[1][k])
            _write(instant(system, mode_of(ints), omega, floats, at), ints, rows[written])
            written += 1
    return OK, 0, 0.0
