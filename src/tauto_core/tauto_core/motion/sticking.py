"""Coulomb's friction at rest: the wheel is held in its case while it needs no more than c₀."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tauto_core.kernels import compiled
from tauto_core.motion.events import is_due
from tauto_core.motion.lanes import width
from tauto_core.motion.outside import Outside, Place, outside_at
from tauto_core.motion.system import Run, State, mode_of
from tauto_core.motion.wells import coordinate_and_momentum, holding_torque, term
from tauto_core.motion.work import Omega

if TYPE_CHECKING:
    from tauto_core.motion.wheel_plane import Wheel

BISECTIONS = 60
"""As many as leave no doubt in a double."""


@compiled
def set_off_or_hold(wheel: Wheel, omega: Omega, angle: float, at: Outside, state: State) -> None:
    """Set the state at θ = angle, θ̇ = 0: held if the torque allows, or the way it sets off."""
    coulomb = wheel.per_inertia.coulomb
    q = angle - at.tilt.value
    state.side = 1 if q > 0.0 or (q == 0.0 and state.side > 0) else -1
    torque = holding_torque(wheel, mode_of(state), angle, at)
    _place_at_rest(wheel, omega, angle, at, state)
    if coulomb is not None and abs(torque) <= coulomb:
        state.held, state.held_angle = True, angle
        return
    state.held = False
    if torque != 0.0:
        state.direction = -1 if torque > 0.0 else 1
    state.armed = is_due(wheel, state, float(state.direction), angle)


@compiled
def _place_at_rest(wheel: Wheel, omega: Omega, angle: float, at: Outside, state: State) -> None:
    """Put the wheel at rest in the moving case at θ = angle."""
    q, plane = angle - at.tilt.value, state.planes[0]
    x, w = coordinate_and_momentum(wheel, q, -at.tilt.rate, at.line.rate, float(state.side))
    plane.x, plane.x_rest = x, 0.0
    plane.y, plane.y_rest = w / omega[0], 0.0


@compiled
def ride_along(run: Run, place: Place) -> float:
    """Move the held wheel with the case; return the fraction of the step at which it breaks loose.

    1 if it does not. The torque is looked at twice as often as a step has nodes, or at the end
    alone where it is constant.
    """
    wheel: Wheel = run.system  # type: ignore[assignment]
    state, work = run.state, run.work
    angle, mode, coulomb = state.held_angle, mode_of(state), term(wheel.per_inertia.coulomb, 1.0)
    probes = (
        1 if wheel.felt.line is None and wheel.felt.gravity is None else 2 * width(work.fractions)
    )
    for i in range(1, probes + 1):
        b = i / probes
        at = outside_at(place.terms, place.begin + b * place.size, work)
        if abs(holding_torque(wheel, mode, angle, at)) > coulomb:
            a = (i - 1) / probes
            for _ in range(BISECTIONS):
                middle = 0.5 * (a + b)
                at = outside_at(place.terms, place.begin + middle * place.size, work)
                loose = abs(holding_torque(wheel, mode, angle, at)) > coulomb
                a, b = (a, middle) if loose else (middle, b)
            at = outside_at(place.terms, place.begin + b * place.size, work)
            set_off_or_hold(wheel, run.omega, angle, at, state)
            return b
    at = outside_at(place.terms, place.begin + place.size, work)
    _place_at_rest(wheel, run.omega, angle, at, state)
    return 1.0
