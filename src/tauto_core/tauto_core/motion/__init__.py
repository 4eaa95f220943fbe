"""Propagators: how the regulator moves under the ship's motion.

Nobody outside this package knows which one runs: `make_propagator` chooses once, from the
machine and whether the platform lies still.
"""

from __future__ import annotations

from typing import Protocol

from tauto_core.machines import (
    AnyMachine,
    HangingMachine,
    LeverMachine,
    Machine,
    SlackThreadError,
)
from tauto_core.motion.forcing import Forcing, Motion
from tauto_core.samples import State
from tauto_core.scene.errors import CamRangeError

__all__ = ['Forcing', 'Motion', 'Propagator', 'make_propagator', 'propagator_name']


class Propagator(Protocol):
    """Moves the regulator over spans of forcing; chunk-invariant and resumable."""

    name: str

    longest_step_s: float
    """Longest span it takes at one go [s]: pieces of forcing may be as long; 0: any single one."""

    def release(self, forcing: Forcing) -> Motion:
        """Start at rest in the case at the beginning of the first span; return that instant."""
        ...

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans; return the motion at the logged ends."""
        ...

    def state(self) -> State:
        """Return all that the next output depends on."""
        ...

    def restore(self, state: State) -> None:
        """Go on from a state."""
        ...


def propagator_name(machine: AnyMachine, *, still: bool) -> str:
    """Return the name of the cheapest propagator that is exact for the machine."""
    if not isinstance(machine, Machine):
        free = still and machine.drag is None and machine.escapement is None
        well = free and isinstance(machine, LeverMachine) and _swings_freely(machine)
        return 'action_angle' if well else 'collocation'
    if _stays_linear(machine):
        if still and machine.drag is None:
            return 'harmonic'
        if still or not machine.pulling_mass:
            return 'forced_harmonic'
    if not still or machine.drag is not None or machine.escapement is not None:
        return 'collocation'
    return 'action_angle' if _swings_freely(machine) else 'collocation'


def _stays_linear(machine: Machine) -> bool:
    """Return whether nothing but an underdamped linear well acts on a platform at rest."""
    if not machine.is_harmonic or machine.escapement is not None:
        return False
    drag = machine.drag
    if drag is None:
        return True
    underdamped = drag.viscous < 2.0 * machine.inertia * machine.frequency
    return underdamped and not drag.quadratic and not drag.coulomb


def _swings_freely(machine: Machine | LeverMachine) -> bool:
    """Return whether the wheel is released away from rest into a swing with a taut thread."""
    try:
        return machine.release_angle != 0.0 and machine.period(machine.release_angle) > 0.0
    except (CamRangeError, SlackThreadError):
        return False


def make_propagator(
    machine: AnyMachine, *, still: bool, tolerance: float | None = None
) -> Propagator:
    """Return the propagator for a machine on a platform that lies still or moves.

    Args:
        machine: what swings.
        still: whether the platform lies still.
        tolerance: error allowed a step, relative to the state, where steps are needed; None: the
            propagator's default.
    """
    name = propagator_name(machine, still=still)
    if not isinstance(machine, Machine):
        return _of_real_thread(machine, name, tolerance)
    match name:
        case 'harmonic':
            from tauto_core.motion.harmonic import Harmonic

            return Harmonic(machine)
        case 'forced_harmonic':
            from tauto_core.motion.forced_harmonic import ForcedHarmonic

            return ForcedHarmonic(machine)
        case 'action_angle':
            from tauto_core.motion.action_angle import ActionAngle

            return ActionAngle(machine)
        case _:
            from tauto_core.motion.collocation import Collocation  # imports numba

            return Collocation(machine, tolerance)


def _of_real_thread(
    machine: LeverMachine | HangingMachine, name: str, tolerance: float | None
) -> Propagator:
    if name == 'action_angle' and isinstance(machine, LeverMachine):
        from tauto_core.motion.uneven_well import UnevenWell

        return UnevenWell(machine)
    from tauto_core.motion.real_threads import RealThreads  # imports numba

    return RealThreads(machine, tolerance)
