"""Events within a step of a mechanism, and what they change.

Turning points of θ, where quadratic drag or an escapement need them; impulses; the end of the
range; a slack thread. Each has a value that is positive before it and negative after it.
`mode` and `place` as in mechanism; `watched`: how turning points matter, the angle of the impulse
[rad], else inf, and gravity at rest; `scratch` a state to work with.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from tauto_core.kernels import compiled, overload
from tauto_core.motion.lanes import lane, least, load, width
from tauto_core.motion.layout import back_to
from tauto_core.motion.mechanism import (
    ACCELERATION,
    ANGLE,
    BEND,
    COORDINATE,
    MARGIN,
    RATE,
    SPEED,
    TENSION,
    instant,
    margins,
    strike,
    wheel_angle,
)
from tauto_core.motion.outside import outside_at
from tauto_core.motion.passages import ahead, angles_at, passages, settle
from tauto_core.motion.roots import locate, value_of
from tauto_core.motion.turning import FRACTIONS, between, expand

NO_EVENT, AT_TURNING, AT_IMPULSE, AT_EDGE, AT_SLACK = 0, 1, 2, 3, 4
DIRECTION, PALLET, ARMED, TURNS, BEATS, LEVEL, NEWTON, INTS = range(8)
"""BEATS: passages of θ less those by which it is ahead of the phase's coordinate (passages)."""

NEVER, SMOOTHLY, ABRUPTLY = 0, 1, 2
"""How turning points matter: not at all, for the escapement, or for a drag with a kink there."""

CLEAR = 0.05
"""Margin of all nodes of a step that is surely within the range, as `mechanism.MARGIN`."""

LARGE = 3.0
"""Radius of a swing in its phase plane, over the acceleration that disturbs it [1/ω²], from which
on it passes zero at most once within a step of two radians: 2 would do if that were constant."""

BENT = 0.25
"""Part of the rate by which it may change between an impulse and the end of the step."""

PRECISION = 1e-9
"""Of an event's place in a step: near enough to be carried there."""

_NOWHERE = 2.0


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


@compiled
def _state_within(watch: Any, xi: float) -> Any:
    """Fill `scratch` with the state at a fraction of the step; return what the ship does there."""
    length, terms, x0, hx = watch.place
    for p in range(len(watch.omega)):
        x, y = between(watch.omega, p, hx * length, xi, watch.floats, watch.memory.work)
        watch.scratch[4 * p], watch.scratch[4 * p + 2] = x, y
    return outside_at(terms, x0 + xi * hx, watch.memory.work)


@overload(value_of)
def _value_within(watch: Any, xi: Any) -> Any:
    if getattr(watch, 'instance_class', None) is not Watch:
        return None

    def within(watch: Any, xi: Any) -> Any:
        kind, angle, system, mode, omega, _, _, _, scratch = watch
        at = _state_within(watch, xi)
        if kind == AT_IMPULSE:
            return angle - mode[0] * wheel_angle(system, scratch, at)
        now = instant(system, mode, omega, scratch, at)
        return value(kind, angle, mode[0], now)

    return within


@overload(angles_at)
def _angles_within(watch: Any, xi: Any) -> Any:
    if getattr(watch, 'instance_class', None) is not Watch:
        return None

    def within(watch: Any, xi: Any) -> Any:
        at = _state_within(watch, xi)
        now = instant(watch.system, watch.mode, watch.omega, watch.scratch, at)
        return now[COORDINATE], now[SPEED], now[ANGLE], now[RATE]

    return within


@compiled
def mode_of(ints: Any) -> tuple[float, float]:
    """Return `mode` of a state."""
    return float(ints[DIRECTION]), float(ints[PALLET])


@compiled
def _first_below(values: Any, work: Any) -> float:
    """Return the first node with a value that is not positive; 2: none."""
    if least(values) > 0.0:
        return _NOWHERE
    for i in range(width(values)):
        if not lane(values, i) > 0.0:
            return lane(load(work, FRACTIONS), i)
    return _NOWHERE


@compiled
def _turns_quietly(
    watched: Any,
    system: Any,
    d: float,
    place: Any,
    after: Any,
    clear: bool,
    floats: Any,
    ints: Any,
    work: Any,
) -> bool:
    """Turn where a turning point lies within the step, and at most an impulse after it."""
    if not clear or watched[0] == ABRUPTLY or ints[ARMED] == 1 or not d * after[RATE] < 0.0:
        return False
    # the turning point lies farther out than the end, and than the beginning
    if not -d * after[ANGLE] < watched[1]:
        at = outside_at(place[1], place[2], work)
        if not -d * wheel_angle(system, floats, at) < watched[1]:
            return False
    ints[DIRECTION] = -ints[DIRECTION]
    ints[ARMED] = 1
    return True


@compiled
def first_event(
    watched: Any,
    system: Any,
    mode: Any,
    omega: Any,
    ints: Any,
    stalled: bool,
    place: Any,
    after: Any,
    floats: Any,
    memory: Any,
    scratch: Any,
) -> tuple[int, float]:
    """Return the kind of the first event within the step and about its fraction of the step.

    What is reached before a turning point and left again after it is looked for up to there. A
    turning point where nothing happens is no event; it is taken note of.

    Args:
        after: `instant` at the end of the step.
    """
    turns, angle, _ = watched
    tension, margin = margins(system, mode, omega, memory.work)
    slack, edge = _first_below(tension, memory.work), _first_below(margin, memory.work)
    clear = min(after[MARGIN], least(margin)) > CLEAR and min(after[TENSION], least(tension)) > 0.0
    if turns != NEVER and not stalled:
        _turns_quietly(watched, system, mode[0], place, after, clear, floats, ints, memory.work)
    armed, d = ints[ARMED] == 1, float(ints[DIRECTION])
    quiet = turns == NEVER or stalled or d * after[RATE] > 0.0
    missed = not armed or d * after[ANGLE] < angle
    inside = after[MARGIN] > 0.0 and after[TENSION] > 0.0 and min(slack, edge) > 1.0
    if quiet and missed and inside:
        return NO_EVENT, 1.0
    if quiet and inside and turns == SMOOTHLY and not stalled:
        # the only event; by the slope at the end where that has not changed much since
        late, bend = (d * after[ANGLE] - angle) / (d * after[RATE]), after[BEND] / after[RATE]
        xi = 1.0 - back_to(late, bend, omega[0]) / (place[3] * place[0])
        if xi > 0.5 and abs(bend * late) < BENT:
            return AT_IMPULSE, xi
    first, xi = NO_EVENT, _NOWHERE
    expand(len(omega), memory.work)
    now, reach = mode_of(ints), 1.0
    for kind in range(AT_TURNING, AT_SLACK + 1):
        if kind == AT_TURNING and (turns == NEVER or stalled):
            continue
        if kind == AT_IMPULSE and not armed:
            continue
        last = reach
        if kind == AT_EDGE:
            last = min(edge, reach)
        elif kind == AT_SLACK:
            last = min(slack, reach)
        watch = Watch(kind, angle, system, now, omega, place, floats, memory, scratch)
        at_last = value_of(watch, last)
        if at_last > 0.0:
            continue
        at = locate(watch, last, at_last, PRECISION)
        if at < xi:
            first, xi = kind, at
        if kind == AT_TURNING:
            reach = at
    return first, xi


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
def _radius(value: float, rate: float, bend: float, omega: float) -> tuple[float, float]:
    """Return the square of an angle's radius in its phase plane, and of what disturbs it."""
    speed, pushed = rate / omega, bend / (omega * omega) + value
    return value * value + speed * speed, pushed * pushed


@compiled
def swings_clear(omega: float, before: Any, after: Any) -> bool:
    """Return whether the phase's coordinate and θ pass zero at most once within a step.

    Args:
        omega: of the phase [rad/s].
        before, after: `instant` at both ends of the step.
    """
    for value, rate, bend in ((COORDINATE, SPEED, ACCELERATION), (ANGLE, RATE, BEND)):
        first, pushed = _radius(before[value], before[rate], before[bend], omega)
        second, more = _radius(after[value], after[rate], after[bend], omega)
        if not min(first, second) > LARGE * LARGE * max(pushed, more):
            return False
    return True


@compiled
def passed(
    clear: bool,
    before: float,
    stop: float,
    system: Any,
    mode: Any,
    omega: Any,
    place: Any,
    now: Any,
    floats: Any,
    memory: Any,
    scratch: Any,
) -> tuple[int, int, bool, bool]:
    """Return what passes zero within the step last collocated, but for its end, for `count`.

    Args:
        clear: as `swings_clear` returns.
        before, stop: as in passages.
        now: `instant` at the beginning of the step.
    """
    if clear:
        x = now[COORDINATE]
        return 0, ahead(x, now[SPEED], now[ANGLE]), x < 0.0, now[ANGLE] < 0.0
    expand(len(omega), memory.work)
    watch = Watch(NO_EVENT, 0.0, system, mode, omega, place, floats, memory, scratch)
    return passages(watch, place[3] * place[0], before, stop, memory.work)


@compiled
def count(found: Any, now: Any, ints: Any) -> None:
    """Count a step at whose end, after what happens there, `instant` is `now`."""
    turns, beats = settle(False, found, now[COORDINATE], now[SPEED], now[ANGLE])
    ints[TURNS] += turns
    ints[BEATS] += beats
