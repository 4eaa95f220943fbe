"""Events within a step of a mechanism, and what they change.

Turning points of θ, where quadratic drag or an escapement need them; impulses; the end of the
range; a slack thread. Each has a value that is positive before it and negative after it.
`mode` and `place` as in mechanism; `watched`: whether turning points matter, and the angle of the
impulse [rad], else inf; `scratch` a state to work with.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from numba.extending import overload

from tauto_core.motion.compiled import compiled
from tauto_core.motion.gauss import NODES, STAGES
from tauto_core.motion.lanes import lane, least
from tauto_core.motion.mechanism import (
    ANGLE,
    COORDINATE,
    MARGIN,
    RATE,
    SPEED,
    TENSION,
    instant,
    margins,
    outside_at,
    strike,
)
from tauto_core.motion.roots import locate, value_of
from tauto_core.motion.turning import between, expand

NO_EVENT, AT_TURNING, AT_IMPULSE, AT_EDGE, AT_SLACK = 0, 1, 2, 3, 4
DIRECTION, PALLET, ARMED, SIGN, TURNS, BEATS, LEVEL, NEWTON, INTS = range(9)
LAST_X, LAST_Y, EXTRA = 0, 1, 2
"""Numbers behind the state in `floats`: where the phase was last."""

_NEVER = 2.0


@compiled
def value(kind: int, angle: float, d: float, now: Any) -> float:
    """Return what is positive before an event and negative after it."""
    if kind == AT_TURNING:
        return d * now[RATE]
    if kind == AT_IMPULSE:
        return angle - d * now[ANGLE]
    if kind == AT_EDGE:
        return now[MARGIN]
    return now[TENSION]


class Watch(NamedTuple):
    """What tells an event's value within a step."""

    kind: int
    angle: float
    system: Any
    mode: Any
    omega: Any
    place: Any
    floats: Any
    memory: Any
    scratch: Any


@overload(value_of, strict=False)
def _value_within(watch: Any, xi: Any) -> Any:
    if getattr(watch, 'instance_class', None) is not Watch:
        return None

    def within(watch: Any, xi: Any) -> Any:
        kind, angle, system, mode, omega, place, floats, memory, scratch = watch
        forcing, k, x0, hx = place
        for p in range(len(omega)):
            x, y = between(omega, p, hx * forcing[0][k], xi, floats, memory.work)
            scratch[4 * p], scratch[4 * p + 2] = x, y
        now = instant(system, mode, omega, scratch, outside_at(forcing, k, x0 + xi * hx))
        return value(kind, angle, mode[0], now)

    return within


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
def first_event(
    watched: Any,
    system: Any,
    mode: Any,
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
    d = mode[0]
    tension, margin = margins(system, mode, omega, memory.work)
    slack, edge = _first_below(tension), _first_below(margin)
    now = instant(system, mode, omega, memory.end, outside_at(forcing, k, x0 + hx))
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
        watch = Watch(kind, angle, system, mode, omega, place, floats, memory, scratch)
        at_last = value_of(watch, last)
        if at_last > 0.0:
            continue
        at = locate(watch, last, at_last, 1e-13)
        if at < xi:
            first, xi = kind, at
        if kind == AT_TURNING:
            reach = at
    return first, xi


@compiled
def mode_of(ints: Any) -> tuple[float, float]:
    """Return `mode` of a state."""
    return float(ints[DIRECTION]), float(ints[PALLET])


@compiled
def happen(
    kind: int, watched: Any, system: Any, omega: Any, at: Any, floats: Any, ints: Any
) -> None:
    """Change the discrete state, and the rates, at an event."""
    d, s = mode_of(ints)
    if kind == AT_IMPULSE:
        strike(system, (d, s), omega, at, floats)
        ints[ARMED], ints[PALLET] = 0, ints[DIRECTION]
    elif kind == AT_TURNING:
        ints[DIRECTION] = -ints[DIRECTION]
        angle = instant(system, (-d, s), omega, floats, at)[ANGLE]
        ints[ARMED] = 1 if -d * angle < watched[1] < math.inf else 0


@compiled
def count(phase_rate: float, now: Any, where: Any, ints: Any) -> None:
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
