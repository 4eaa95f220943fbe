"""Short steps to an event, from the nearer end of the step in which it lies."""

from __future__ import annotations

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.events import event_slope, event_value, expects_events
from tauto_core.motion.gauss_step import collocate, copy_planes, finish
from tauto_core.motion.outside import Place, outside_at
from tauto_core.motion.stages import Step
from tauto_core.motion.system import Mode, Plane, Run, planes_of
from tauto_core.motion.work import PART_STEP, Omega, Planes

MAX_HOPS, MAX_CARRIES = 4, 8
"""Most short steps to an event, and most repetitions of the midpoint rule after one of them."""


@inlined
def _moved(end: Planes, omega: Omega, drift: tuple[Plane, ...], time: float) -> tuple[Plane, ...]:
    """Return X and Y of each plane after a short time [s], at the rates of `System.drift`."""
    found: tuple[Plane, ...] = ()
    for p in range(len(omega)):
        x, y = end[p].x + time * drift[p].x, end[p].y + time * drift[p].y / omega[p]
        found = (*found, Plane(x, y))
    return found


@compiled
def _carry(kind: int, xi: float, run: Run, mode: Mode, place: Place) -> tuple[float, float]:
    """Carry `work.end` to an event near it; return where it is then, and where the event is.

    Both are fractions of the step. If the event is `tolerance.near` or more away, the state stays
    and another short step is due. Else the midpoint rule carries it: its error is of the third
    order in the time, which Newton's method finds from value and slope of the event, with the
    slope halfway. It is repeated while the change of the slope on the way leaves more than the
    iteration may, as for a wheel just released.

    Args:
        kind: of the event.
        xi: where `work.end` is, as a fraction of the step.
        run: the run.
        mode: of the step.
        place: of the step.
    """
    system, omega, work = run.system, run.omega, run.work
    end = work.end
    length = place.size * place.length
    for _ in range(MAX_CARRIES):
        at = outside_at(place.terms, place.begin + xi * place.size, work)
        now = system.instant(mode, omega, planes_of(omega, end), at)
        value, fall = event_value(kind, system, mode, now), event_slope(kind, mode, now)
        if not fall < 0.0:
            return xi, xi
        late = -value / fall
        reached = xi + late / length
        if not 0.0 < reached <= 1.0:
            return xi, xi
        if not omega[0] * abs(late) < run.tolerance.near:
            return xi, reached
        halfway = _moved(end, omega, system.drift(mode, omega, at, now), 0.5 * late)
        at = outside_at(place.terms, place.begin + 0.5 * (xi + reached) * place.size, work)
        now = system.instant(mode, omega, halfway, at)
        mean = event_slope(kind, mode, now)
        late *= fall / mean if mean < 0.0 else 1.0
        there = _moved(end, omega, system.drift(mode, omega, at, now), late)
        for p in range(len(omega)):
            end[p].x, end[p].y = there[p].x, there[p].y
        xi += late / length
        change = mean / fall - 1.0
        if omega[0] * abs(late) * change * change <= run.tolerance.settled:
            break
    return xi, xi


@compiled
def step_to_event(kind: int, xi: float, run: Run, mode: Mode, place: Place) -> float:
    """Step to an event from the nearer end of the step; return the fraction where it is.

    Where nothing drags or pushes, the step is made from the beginning: a step forth and back again
    is not symmetric in time, and its errors in the energy of an undamped swing would add up.

    Args:
        kind: of the event.
        xi: about where it is, as a fraction of the step.
        run: the run; `work.end` is the state at the end of the step, then at the event.
        mode: of the step.
        place: of the step.
    """
    system, omega, work = run.system, run.omega, run.work
    end = work.end
    there = 1.0
    if xi <= 0.5 or not system.feels_tilt:
        copy_planes(omega, run.state.planes, end)
        there = 0.0
    for _ in range(MAX_HOPS):
        if xi <= 0.0:
            copy_planes(omega, run.state.planes, end)
            return 0.0
        hop = Place(
            place.length, place.terms, place.begin + there * place.size, (xi - there) * place.size
        )
        system.at_nodes(hop, work)
        step = Step(system, mode, omega, hop.size * hop.length, PART_STEP, end, work)
        collocate(step, run.tolerance.settled)
        finish(step)
        there = xi
        if expects_events(system):
            there, xi = _carry(kind, xi, run, mode, place)
        if there == xi:
            break
    return there
