"""Events of the trochlea: what they are, and what they change.

Kinds: the turning point of θ, the kink of the cam, the impulse of the escapement, the cam's edge,
a slack thread. Each has a value that is positive before it and negative after it.

What goes together travels together: `well` and `mode` as in wells; `place` of a step as in
outside; `limits` (impulse angle, edge of the cam, gravity at rest); `floats` and `ints` the state,
`work` the stage rows of turning, `state` what `acceleration` returns.
"""

from __future__ import annotations

from typing import Any

from tauto_core.kernels import compiled
from tauto_core.motion.lanes import width
from tauto_core.motion.outside import (
    forcing_at,
)
from tauto_core.motion.wells import (
    fold,
    holding_torque,
    kick,
    kinked,
    lever_arm,
    term,
)

NO_EVENT, TURNING, KINK, IMPULSE, AT_EDGE, AT_SLACK, UNSURE = range(7)
"""The negative of a kind is no event, but where the value of that kind stops falling."""

STATE, HELD_ANGLE, FLOATS = 0, 4, 5
DIRECTION, SIDE, PALLET, ARMED, HELD, TURNS, BEATS, LEVEL, NEWTON, GIVEN, INTS = range(11)
"""PALLET: direction of the last impulse, from which the next tooth pushes the wheel back.
BEATS: passages of θ less those by which it is ahead of ϑ (passages). GIVEN: impulses so far."""


@compiled
def _sticks(quadratic: Any, coulomb: Any) -> bool:
    return quadratic is not None or coulomb is not None


@compiled
def has_weight(machine: Any) -> bool:
    """Return whether a weight keeps the thread taut."""
    return machine[0] is not None or machine[3] is not None


@compiled
def turns_abruptly(machine: Any) -> bool:
    """Return whether the drag has a kink at the turning points."""
    return _sticks(machine[5], machine[6])


@compiled
def feels_drag(machine: Any) -> bool:
    """Return whether the motion in the case matters within a step."""
    return machine[4] is not None or _sticks(machine[5], machine[6])


@compiled
def feels_case(machine: Any) -> bool:
    """Return whether the tilt in the case is known within a span, since something feels it."""
    return feels_drag(machine) or feels_impulse(machine)


@compiled
def feels_impulse(machine: Any) -> bool:
    """Return whether an escapement pushes the wheel."""
    return machine[7] is not None


@compiled
def expects_events(well: Any) -> bool:
    """Return whether anything but the ends of the cam and the thread is watched."""
    machine, lever, _ = well
    return turns_abruptly(machine) or feels_impulse(machine) or kinked(lever)


@compiled
def mode_of(ints: Any) -> tuple[float, float, float]:
    """Return `mode` of a state."""
    return float(ints[SIDE]), float(ints[DIRECTION]), float(ints[PALLET])


@compiled
def value_of_state(kind: int, limits: Any, mode: Any, state: Any) -> float:
    """Return what is positive before an event and negative after it."""
    side, d, _ = mode
    if kind == TURNING:
        return d * state[1]
    if kind == KINK:
        return side * state[4]
    if kind == IMPULSE:
        return limits[0] - d * state[0]
    if kind == AT_EDGE:
        return limits[1] - abs(state[4])
    return state[5]


@compiled
def slope(kind: int, mode: Any, state: Any, at: Any) -> float:
    """Return the time derivative of an event's value; 0 for a slack thread."""
    side, d, _ = mode
    if kind == TURNING:
        return d * (state[3] + at[1][2])
    if kind == KINK:
        return side * state[2]
    if kind == IMPULSE:
        return -d * state[1]
    if kind == AT_EDGE:
        return -state[2] if state[4] > 0.0 else state[2]
    return 0.0


@compiled
def set_off(
    limits: Any, well: Any, omega: Any, angle: float, at: Any, floats: Any, ints: Any
) -> None:
    """Decide at θ̇ = 0 whether friction holds the wheel, else which way it sets off."""
    machine = well[0]
    q = angle - at[1][0]
    ints[SIDE] = 1 if q > 0.0 or (q == 0.0 and ints[SIDE] > 0) else -1
    torque = holding_torque(well, mode_of(ints), angle, at)
    place_at_rest(well, omega, angle, at, floats, ints)
    if machine[6] is not None and abs(torque) <= term(machine[6], 1.0):
        ints[HELD] = 1
        floats[HELD_ANGLE] = angle
        return
    ints[HELD] = 0
    if torque != 0.0:
        ints[DIRECTION] = -1 if torque > 0.0 else 1
    ints[ARMED] = 1 if ints[DIRECTION] * angle < limits[0] else 0


@compiled
def place_at_rest(well: Any, omega: Any, angle: float, at: Any, floats: Any, ints: Any) -> None:
    """Put the wheel at rest in the moving case at θ = angle."""
    line, tilt, _ = at
    x, w = fold(well, angle - tilt[0], -tilt[1], line[0], float(ints[SIDE]))
    floats[STATE], floats[STATE + 1] = x, 0.0
    floats[STATE + 2], floats[STATE + 3] = w / omega[0], 0.0


@compiled
def happen(
    kind: int, limits: Any, well: Any, omega: Any, at: Any, state: Any, floats: Any, ints: Any
) -> None:
    """Change the discrete state at an event, and the rate; `state` as `acceleration` returns."""
    machine, lever, _ = well
    side, d, _ = mode_of(ints)
    if kind == KINK:
        ints[SIDE] = -ints[SIDE]
    elif kind == IMPULSE:
        t = lever_arm(lever, side, state[4])[0]
        rate = state[2] + kick(machine[7], machine[0], t, state[1], d, ints[GIVEN])
        floats[STATE + 2] = fold(well, state[4], rate, at[0][0], side)[1] / omega[0]
        floats[STATE + 3] = 0.0
        ints[ARMED], ints[PALLET] = 0, ints[DIRECTION]
        ints[GIVEN] += 1
    elif kind == TURNING:
        ints[DIRECTION] = -ints[DIRECTION]
        if machine[6] is not None:
            set_off(limits, well, omega, state[0], at, floats, ints)
        else:
            ints[ARMED] = 1 if ints[DIRECTION] * state[0] < limits[0] else 0


@compiled
def hold(
    limits: Any, well: Any, omega: Any, felt: Any, place: Any, floats: Any, ints: Any, work: Any
) -> float:
    """Let the held wheel ride with the case; return the fraction at which it breaks loose."""
    machine = well[0]
    _, terms, x0, hx = place
    angle = floats[HELD_ANGLE]
    mode = mode_of(ints)
    limit = term(machine[6], 1.0)
    probes = 1 if felt[0] is None and felt[2] is None else 2 * width(work)
    for i in range(1, probes + 1):
        b = i / probes
        at = forcing_at(terms, x0 + b * hx, work)
        if abs(holding_torque(well, mode, angle, at)) > limit:
            a = (i - 1) / probes
            for _ in range(60):
                middle = 0.5 * (a + b)
                at = forcing_at(terms, x0 + middle * hx, work)
                loose = abs(holding_torque(well, mode, angle, at)) > limit
                a, b = (a, middle) if loose else (middle, b)
            at = forcing_at(terms, x0 + b * hx, work)
            set_off(limits, well, omega, angle, at, floats, ints)
            return b
    place_at_rest(well, omega, angle, forcing_at(terms, x0 + hx, work), floats, ints)
    return 1.0
