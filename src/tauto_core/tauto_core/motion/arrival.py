"""Steps of the trochlea to an event, from the nearer end of the step that it lies in.

`system` is the trochlea as `turning` takes it; `well`, `mode`, `place`, `limits` and `floats` are
those of events.
"""

from __future__ import annotations

from typing import Any

from tauto_core.kernels import compiled
from tauto_core.motion.events import (
    feels_case,
    feels_drag,
    slope,
    value_of_state,
)
from tauto_core.motion.outside import (
    forcing_at,
    forcing_at_nodes,
)
from tauto_core.motion.turning import (
    PART_STEP,
    collocate,
    copy_state,
    finish,
)
from tauto_core.motion.wells import (
    acceleration,
    drift,
)


@compiled
def _carry(
    kind: int,
    xi: float,
    limits: Any,
    tolerance: Any,
    well: Any,
    mode: Any,
    omega: Any,
    place: Any,
    end: Any,
    work: Any,
) -> tuple[float, float]:
    """Carry a state that is near an event to it; return where it is, and where the event is.

    Both as fractions of the step. The midpoint rule errs by the cube of what it spans, and tells
    how the slope changes on the way; a wheel that has just been released may lie so near its
    event that this takes repetition.
    """
    length, terms, x0, hx = place
    whole = hx * length
    for _ in range(8):
        at = forcing_at(terms, x0 + xi * hx, work)
        state = acceleration(well, mode, end[0], omega[0] * end[2], at)
        value, fall = value_of_state(kind, limits, mode, state), slope(kind, mode, state, at)
        if not fall < 0.0:
            return xi, xi
        late = -value / fall
        reached = xi + late / whole
        if not 0.0 < reached <= 1.0:
            return xi, xi
        if not omega[0] * abs(late) < tolerance[3]:
            return xi, reached
        along, more = drift(well, mode, state, at)
        x, w = end[0] + 0.5 * late * along, omega[0] * end[2] + 0.5 * late * more
        at = forcing_at(terms, x0 + 0.5 * (xi + reached) * hx, work)
        state = acceleration(well, mode, x, w, at)
        along, more = drift(well, mode, state, at)
        mean = slope(kind, mode, state, at)
        late *= fall / mean if mean < 0.0 else 1.0
        end[0] += late * along
        end[2] += late * more / omega[0]
        xi += late / whole
        change = mean / fall - 1.0
        if omega[0] * abs(late) * change * change <= tolerance[2]:
            break
    return xi, xi


@compiled
def step_to_event(
    kind: int,
    xi: float,
    limits: Any,
    tolerance: Any,
    system: Any,
    mode: Any,
    omega: Any,
    place: Any,
    floats: Any,
    memory: Any,
) -> float:
    """Step to an event from the nearer end of the step; return the fraction where it is.

    From the beginning where nothing drags or pushes: forth and back again is not symmetric in
    time, and what it errs in the energy of a lasting swing would add up.
    """
    machine, lever, shape, felt = system
    length, terms, x0, hx = place
    work, end = memory.work, memory.end
    well = machine, lever, shape
    part = PART_STEP
    there = 1.0
    if xi <= 0.5 or not feels_case(machine):
        copy_state(1, floats, end)
        there = 0.0
    for _ in range(4):
        if xi <= 0.0:
            copy_state(1, floats, end)
            return 0.0
        hop = length, terms, x0 + there * hx, (xi - there) * hx
        forcing_at_nodes(felt, feels_drag(machine), hop, work)
        h = hop[3] * length
        collocate(system, mode, omega, h, part, tolerance[2], end, memory)
        finish(omega, h, part, end, memory)
        there, xi = _carry(kind, xi, limits, tolerance, well, mode, omega, place, end, work)
        if there == xi:
            break
    return there
