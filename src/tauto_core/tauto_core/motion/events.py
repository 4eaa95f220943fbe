"""Events of a system: what they are, and what they change.

The kinds are the turning point of θ, the kink of a cam, the impulse of the escapement, the end of
the range, and a slack thread. Each has a value that is positive before it and negative after it.
"""

from __future__ import annotations

import math

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.outside import Outside
from tauto_core.motion.system import Instant, Mode, Run, State, System, mode_of

NO_EVENT, TURNING, KINK, IMPULSE, AT_EDGE, AT_SLACK, UNSURE = range(7)
"""Kinds of events, in the order in which they are sought. `event_search` uses the negative of a
kind for the instant at which its value stops falling.
"""


@inlined
def expects_events(system: System) -> bool:
    """Return whether any events but the ends of the range and a slack thread can occur."""
    return system.turns_abruptly or system.feels_impulse or system.kinked


@compiled
def event_value(kind: int, system: System, mode: Mode, now: Instant) -> float:
    """Return the value that is positive before an event and negative after it."""
    if kind == TURNING:
        return mode.direction * now.rate
    if kind == KINK:
        return mode.side * now.coordinate
    if kind == IMPULSE:
        return system.impulse - mode.direction * now.angle
    if kind == AT_EDGE:
        return now.margin
    return now.tension


@compiled
def event_slope(kind: int, mode: Mode, now: Instant) -> float:
    """Return the time derivative of an event's value; 0 for those that end a run."""
    if kind == TURNING:
        return mode.direction * now.bend
    if kind == KINK:
        return mode.side * now.speed
    if kind == IMPULSE:
        return -mode.direction * now.rate
    return 0.0


@inlined
def alternates(system: System, state: State, direction: float) -> bool:
    """Return whether the pallet that pushes in a direction is the one on which a tooth rests.

    After an impulse a tooth falls on the other pallet, and lies there until that has pushed, also
    if the wheel turns back before. The first impulse is given by either pallet, unless recoil
    shows on which a tooth lies at the release.
    """
    return direction != float(state.pallet) or (state.given == 0 and not system.recoils)


@inlined
def is_due(system: System, state: State, direction: float, angle: float) -> bool:
    """Return whether the swing from θ = angle on reaches the angle of an impulse that is due."""
    reaches = direction * angle < system.impulse < math.inf
    return reaches and alternates(system, state, direction)


@compiled
def happen(kind: int, run: Run, at: Outside, now: Instant) -> None:
    """Apply an event: change signs and counts of the state, and at an impulse the planes.

    Args:
        kind: the kind of the event.
        run: the run.
        at: the motion of the ship there.
        now: the system there, before the event.
    """
    system, state = run.system, run.state
    mode = mode_of(state)
    if system.kinked and kind == KINK:
        state.side = -state.side
    if system.feels_impulse and kind == IMPULSE:
        system.strike(mode, run.omega, at, now, state)
        state.armed, state.pallet = False, state.direction
        state.given += 1
    if kind == TURNING:
        state.direction = -state.direction
        if system.sticks:
            system.set_off(run.omega, now.angle, at, state)
        else:
            state.armed = is_due(system, state, float(state.direction), now.angle)
