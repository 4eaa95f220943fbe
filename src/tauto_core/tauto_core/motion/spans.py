"""A mechanism stepped through spans of forcing: collocation between events, in any planes.

Events: turning points of θ, where quadratic drag or an escapement need them, and impulses are
stepped to; the end of the range and a slack thread end the run. What a mechanism is, overloads of
the functions of `mechanism` say for its type of `system`; `place` as there. `floats` begin with
the state.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tauto_core.motion.compiled import compiled, entry, inlined
from tauto_core.motion.gauss import NODES, STAGES
from tauto_core.motion.lanes import lane, least
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
    margins,
    outside_at,
    strike,
)
from tauto_core.motion.turning import PART_STEP, WHOLE_STEP, between, collocate, expand, finish

OK, EDGE, SLACK, NO_CONVERGENCE = 0, 1, 2, 3
NO_EVENT, AT_TURNING, AT_IMPULSE, AT_EDGE, AT_SLACK = 0, 1, 2, 3, 4
DIRECTION, ARMED, SIGN, TURNS, BEATS, LEVEL, NEWTON, INTS = range(8)
LAST_X, LAST_Y, EXTRA = 0, 1, 2
"""Numbers behind the state in `floats`: where the phase was last."""

ROW = 8
MAX_EVENTS = 10_000
MAX_STALLED = 4
MAX_LEVEL = 24
COARSEN = 2.0**-17
"""Part of the tolerance below which steps double: their error grows by 2^16."""

_NEVER = 2.0


@inlined
def _error(factor: float, last: float, newton: bool) -> float:
    """Return the error of a step relative to the state, from its last coefficient."""
    return last if newton else factor * last * last


@compiled
def _copy(planes: int, source: Any, target: Any) -> None:
    for i in range(4 * planes):
        target[i] = source[i]


@compiled
def _value(kind: int, angle: float, d: float, now: Any) -> float:
    """Return what is positive before an event and negative after it."""
    if kind == AT_TURNING:
        return d * now[RATE]
    if kind == AT_IMPULSE:
        return angle - d * now[ANGLE]
    if kind == AT_EDGE:
        return now[MARGIN]
    return now[TENSION]


@compiled
def _within(
    kind: int,
    angle: float,
    system: Any,
    d: float,
    omega: Any,
    place: Any,
    xi: float,
    floats: Any,
    memory: Any,
    scratch: Any,
) -> float:
    """Return an event's value at the fraction xi of the step, from the stage polynomials."""
    forcing, k, x0, hx = place
    for p in range(len(omega)):
        x, y = between(omega, p, hx * forcing[0][k], xi, floats, memory.work)
        scratch[4 * p], scratch[4 * p + 2] = x, y
    now = instant(system, d, omega, scratch, outside_at(forcing, k, x0 + xi * hx))
    return _value(kind, angle, d, now)


@compiled
def _locate(
    kind: int,
    angle: float,
    system: Any,
    d: float,
    omega: Any,
    place: Any,
    last: float,
    floats: Any,
    memory: Any,
    scratch: Any,
) -> float:
    """Return the fraction of the step at which an event's value falls to zero (Illinois)."""
    a, fa, b = 0.0, 0.0, last
    fb = _within(kind, angle, system, d, omega, place, b, floats, memory, scratch)
    for trial in range(4):
        a = 0.0 if trial == 0 else last * 0.25 ** (4 - trial)
        fa = _within(kind, angle, system, d, omega, place, a, floats, memory, scratch)
        if fa > 0.0:
            break
    if not fa > 0.0:
        return 0.0
    if not fb < 0.0:
        return b
    kept = 0
    for _ in range(100):
        x = (a * fb - b * fa) / (fb - fa)
        if not a < x < b:
            return b
        fx = _within(kind, angle, system, d, omega, place, x, floats, memory, scratch)
        if fx == 0.0 or x - a <= 1e-13 or b - x <= 1e-13:
            return x
        if fx > 0.0:
            a, fa = x, fx
            fb = 0.5 * fb if kept == 1 else fb
            kept = 1
        else:
            b, fb = x, fx
            fa = 0.5 * fa if kept == -1 else fa
            kept = -1
    return b


@compiled
def _first_below(values: Any) -> float:
    """Return the first node with a value that is not positive; 2: none."""
    if least(values) > 0.0:
        return _NEVER
    for i in range(STAGES):
        if not lane(values, i) > 0.0:
            return NODES[i]
    return _NEVER


@compiled
def _first_event(
    watched: Any,
    system: Any,
    d: float,
    omega: Any,
    armed: bool,
    stalled: bool,
    place: Any,
    floats: Any,
    memory: Any,
    scratch: Any,
) -> tuple[int, float]:
    """Return the kind of the first event within the step and its fraction of the step.

    What is reached before a turning point and left again after it is looked for up to there.
    """
    turns, angle = watched
    forcing, k, x0, hx = place
    tension, margin = margins(system, d, omega, memory.work)
    slack, edge = _first_below(tension), _first_below(margin)
    now = instant(system, d, omega, memory.end, outside_at(forcing, k, x0 + hx))
    quiet = not turns or stalled or d * now[RATE] > 0.0
    missed = not armed or d * now[ANGLE] < angle
    inside = now[MARGIN] > 0.0 and now[TENSION] > 0.0
    first, xi = NO_EVENT, _NEVER
    if quiet and missed and inside and min(slack, edge) > 1.0:
        return first, xi
    expand(len(omega), memory.work)
    reach = 1.0
    for kind in range(AT_TURNING, AT_SLACK + 1):
        if (kind == AT_TURNING and (not turns or stalled)) or (kind == AT_IMPULSE and not armed):
            continue
        last = reach
        if kind == AT_EDGE:
            last = min(edge, reach)
        elif kind == AT_SLACK:
            last = min(slack, reach)
        if _within(kind, angle, system, d, omega, place, last, floats, memory, scratch) > 0.0:
            continue
        at = _locate(kind, angle, system, d, omega, place, last, floats, memory, scratch)
        if at < xi:
            first, xi = kind, at
        if kind == AT_TURNING:
            reach = at
    return first, xi


@compiled
def _step_to_event(
    kind: int,
    xi: float,
    angle: float,
    system: Any,
    d: float,
    omega: Any,
    place: Any,
    floats: Any,
    memory: Any,
) -> float:
    """Step to an event, correct its time by the state found there; return the fraction."""
    forcing, k, x0, hx = place
    length, part = hx * forcing[0][k], np.int64(PART_STEP)
    for _ in range(4):
        if xi <= 0.0:
            _copy(len(omega), floats, memory.end)
            return 0.0
        at_nodes(system, (forcing, k, x0, xi * hx), memory.work)
        collocate(system, d, omega, xi * length, part, floats, memory)
        finish(omega, xi * length, part, floats, memory)
        now = instant(system, d, omega, memory.end, outside_at(forcing, k, x0 + xi * hx))
        slope = d * now[BEND] if kind == AT_TURNING else -d * now[RATE]
        if kind >= AT_EDGE or not slope < 0.0:
            return xi
        late = -_value(kind, angle, d, now) / slope
        reached = xi + late / length
        if not 0.0 < reached <= 1.0 or omega[0] * abs(late) <= 1e-15:
            return xi
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
) -> tuple[int, float, float]:
    """Advance over hx or to the first event; return the event, the fraction, the error."""
    forcing, k, x0, hx = place
    d, h, planes = float(ints[DIRECTION]), hx * forcing[0][k], len(omega)
    kind = WHOLE_STEP if x0 == 0.0 or not watched[0] else PART_STEP
    at_nodes(system, place, memory.work)
    last, newton = collocate(system, d, omega, h, kind, floats, memory)
    error = _error(tolerance[1], last, newton)
    if not error <= tolerance[0]:
        return NO_EVENT, 0.0, error
    ints[NEWTON] += 1 if newton else 0
    finish(omega, h, kind, floats, memory)
    event, xi = _first_event(
        watched, system, d, omega, ints[ARMED] == 1, stalled, place, floats, memory, scratch
    )
    if event == NO_EVENT:
        xi = 1.0
    else:
        xi = _step_to_event(event, xi, watched[1], system, d, omega, place, floats, memory)
    _copy(planes, memory.end, floats)
    return event, xi, error


@compiled
def _happen(
    kind: int, watched: Any, system: Any, omega: Any, at: Any, floats: Any, ints: Any
) -> None:
    """Change the discrete state, and the rates, at an event."""
    d = float(ints[DIRECTION])
    if kind == AT_IMPULSE:
        strike(system, d, omega, at, floats)
        ints[ARMED] = 0
    elif kind == AT_TURNING:
        ints[DIRECTION] = -ints[DIRECTION]
        angle = instant(system, -d, omega, floats, at)[ANGLE]
        ints[ARMED] = 1 if -d * angle < watched[1] < math.inf else 0


@compiled
def _count(phase_rate: float, now: Any, where: Any, ints: Any) -> None:
    """Count the turns of (x, −ẋ/ω) about the origin and the passages of θ through zero."""
    x0, y0 = where[LAST_X], where[LAST_Y]
    x1, y1 = now[COORDINATE], -now[SPEED] / phase_rate
    if (y0 < 0.0) != (y1 < 0.0) and x0 + (x1 - x0) * y0 / (y0 - y1) < 0.0:
        ints[TURNS] += 1 if y1 < 0.0 else -1
    where[LAST_X], where[LAST_Y] = x1, y1
    if now[ANGLE] != 0.0:
        sign = 1 if now[ANGLE] > 0.0 else -1
        if ints[SIGN] == -sign:
            ints[BEATS] += 1
        ints[SIGN] = sign


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
    system: Any,
    omega: Any,
    forcing: Any,
    x0: float,
    floats: Any,
    ints: Any,
    row: Any,
) -> tuple[float, float]:
    """Set what goes with a state in which the wheel lies at rest in the case.

    Returns the tension and the margin, which must be positive.
    """
    at = outside_at(forcing, 0, x0)
    ints[:] = 0
    now = instant(system, 0.0, omega, floats, at)
    ints[DIRECTION] = -1 if now[BEND] < 0.0 else 1
    ints[ARMED] = 1 if ints[DIRECTION] * now[ANGLE] < watched[1] < math.inf else 0
    where = floats[4 * len(omega) :]
    where[LAST_X], where[LAST_Y] = now[COORDINATE], -now[SPEED] / phase_rate
    _count(phase_rate, now, where, ints)
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
    worst, events, stalled, whole = 0.0, 0, 0, end[k] - begin[k]
    where = floats[4 * len(omega) :]
    # Time is a cell and a fraction of it: it keeps its resolution in spans of a day.
    steps = max(1, int(math.ceil(whole * forcing[0][k] / longest_s - 1e-9)))
    cells, cell, f = steps << ints[LEVEL], 0, 0.0
    while cell < cells:
        place = forcing, k, begin[k] + (cell + f) / cells * whole, (1.0 - f) / cells * whole
        pause = stalled > MAX_STALLED
        kind, xi, error = _move(
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
        x = end[k] if cell == cells else begin[k] + (cell + f) / cells * whole
        if kind >= AT_EDGE or events > MAX_EVENTS:
            return EDGE if kind == AT_EDGE else SLACK if kind == AT_SLACK else NO_CONVERGENCE, x
        at = outside_at(forcing, k, x)
        if kind != NO_EVENT:
            _happen(kind, watched, system, omega, at, floats, ints)
        d = float(ints[DIRECTION])
        _count(phase_rate, instant(system, d, omega, floats, at), where, ints)
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
        tolerance: error allowed a step relative to the state, and the error of a step per square
            of its last coefficient.
        phase_rate: ω of the phase [rad/s].
        longest_s: longest step [s].
        watched: whether turning points matter, and the angle of the impulse [rad], else inf.
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
            _write(instant(system, float(ints[DIRECTION]), omega, floats, at), ints, rows[written])
            written += 1
    return OK, 0, 0.0
