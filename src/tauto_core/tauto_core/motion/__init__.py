"""Propagators: how the regulator moves under the ship's motion.

`make_propagator` chooses one by the machine and by whether the platform is still.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, cast

from tauto_core.machines import AnyMachine, LeverMachine, Machine, OtherRegulator, SlackThreadError
from tauto_core.motion.forcing import Forcing, Motion
from tauto_core.samples import State
from tauto_core.scene.errors import CamRangeError

if TYPE_CHECKING:
    from tauto_core.motion.collocation import Collocation
    from tauto_core.motion.real_threads import RealThreads

__all__ = [
    'Forcing',
    'Motion',
    'Propagator',
    'make_collocation',
    'make_propagator',
    'propagator_name',
    'steps_in',
    'sweeps_for',
]


class Propagator(Protocol):
    """Moves the regulator over spans of forcing, with the same result in one call or in many."""

    name: str

    def release(self, forcing: Forcing) -> Motion:
        """Release at rest in the case, at the beginning of the first span."""
        ...

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans and return the motion at their logged ends."""
        ...

    def state(self) -> State:
        """Return everything that the further motion depends on."""
        ...

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        ...


def propagator_name(machine: AnyMachine | OtherRegulator, *, still: bool) -> str:
    """Return the name of the cheapest propagator that is exact for the machine."""
    if isinstance(machine, OtherRegulator):
        return machine.propagator
    undriven = machine.drag is None and machine.escapement is None
    if not isinstance(machine, Machine):
        well = isinstance(machine, LeverMachine) and _swings_freely(machine)
        free = still and undriven and well and not machine.heat.acts
        return 'action_angle' if free else 'collocation'
    steady = not machine.heat.acts
    if steady and still and machine.is_harmonic and undriven:
        return 'harmonic'
    if steady and _stays_linear(machine) and (still or not machine.pulling_mass):
        return 'forced_harmonic'
    even = machine.imbalance is None and machine.has_small_swings
    if not (steady and still and undriven and even):
        return 'collocation'
    return 'action_angle' if _swings_freely(machine) else 'collocation'


def _stays_linear(machine: Machine) -> bool:
    """Return whether the wheel on land is a linear oscillator below critical damping."""
    if not machine.is_linear or machine.escapement is not None:
        return False
    drag = machine.drag
    if drag is None:
        return True
    underdamped = drag.viscous < 2.0 * machine.inertia * machine.frequency
    return underdamped and drag.is_linear


def _swings_freely(machine: Machine | LeverMachine) -> bool:
    """Return whether a release leads to a swing within range, with a taut thread."""
    try:
        return machine.release_angle != 0.0 and machine.period(machine.release_angle) > 0.0
    except (CamRangeError, SlackThreadError):
        return False


ROUGH_SHARE, LEAST_ROUGH = 3e-4, 3e-13
"""Tolerance over the accuracy [day/s] for a lever arm with joints or a real thread, and the least
such tolerance. There the rate errs by up to 1000 s/day times the tolerance, elsewhere by 250
(measured over the built-in scenes, from 1e-3 to 1e-10).
"""

FREE_SHARE = 5e-7
"""Tolerance over the accuracy [day/s] for a wheel without an escapement. No impulse restores its
amplitude, and the energy errors at kinks and joints add up: a cheek errs in the first day by up
to 1.8e6 s times the tolerance.
"""

SMOOTH_SHARE, LEAST_SMOOTH, LARGEST_ASKED = 1e-3, 2e-12, 1e-3
"""Tolerance over the accuracy [day/s] for smooth steps, the least such tolerance
(`stepping.TOLERANCE`), and the largest tolerance of all.
"""


def asked_tolerance(
    machine: AnyMachine | OtherRegulator, *, accuracy: float | None, tolerance: float | None
) -> float | None:
    """Return the tolerance for an accuracy [s/day], or `tolerance` without an accuracy."""
    if accuracy is None:
        return tolerance
    smooth = isinstance(machine, Machine) and not (machine.cam.joints.size or machine.cam.kinked)
    if smooth or isinstance(machine, OtherRegulator):
        return smooth_tolerance(accuracy)
    free = isinstance(machine, Machine) and machine.escapement is None
    share = FREE_SHARE if free else ROUGH_SHARE
    return min(max(share * accuracy, LEAST_ROUGH), LARGEST_ASKED)


def smooth_tolerance(accuracy: float) -> float:
    """Return the tolerance of smooth steps for an accuracy [s/day]."""
    return min(max(SMOOTH_SHARE * accuracy, LEAST_SMOOTH), LARGEST_ASKED)


def make_propagator(
    machine: AnyMachine | OtherRegulator,
    *,
    still: bool,
    tolerance: float | None = None,
    sweeps: int | None = None,
) -> Propagator:
    """Return the propagator for a machine on a still or moving platform.

    Args:
        machine: what moves.
        still: whether the platform is still.
        tolerance: error allowed in a step, relative to the state.
        sweeps: sweeps over the stages of an event-to-event step (`free_end`): 0 for no such
            steps, `None` for the number that the tolerance needs (`sweeps_for`).
    """
    if isinstance(machine, OtherRegulator):
        return _in_place_of_wheel(machine)
    match propagator_name(machine, still=still), machine:
        case 'harmonic', Machine():
            from tauto_core.motion.closed_forms import Harmonic

            return Harmonic(machine)
        case 'forced_harmonic', Machine():
            from tauto_core.motion.forced_harmonic import ForcedHarmonic

            return ForcedHarmonic(machine)
        case 'action_angle', Machine():
            from tauto_core.motion.closed_forms import ActionAngle

            return ActionAngle(machine)
        case 'action_angle', LeverMachine():
            from tauto_core.motion.closed_forms import UnevenWell

            return UnevenWell(machine)
        case _:
            return make_collocation(machine, tolerance, sweeps)


def _in_place_of_wheel(machine: OtherRegulator) -> Propagator:
    """Return the propagator for a regulator without a wheel."""
    from tauto_core.machines import AxleClock, FluidPendulum

    if isinstance(machine, AxleClock):
        from tauto_core.motion.axle import AxleSwings

        return AxleSwings(machine)
    from tauto_core.motion.fluid import HalfSwings

    return HalfSwings(cast(FluidPendulum, machine))


def steps_in(propagator: Propagator | None) -> Callable[[float], int]:
    """Return a function from the length of a piece of forcing [s] to the number of its steps.

    The number is 1 without a propagator or steps, and if steps end at events in every swing.
    """
    steps: Callable[[float], int] = getattr(propagator, 'steps_in', lambda _: 1)
    return steps


FREE_END_SWEEPS = (1e-6, 2), (1e-9, 3)
"""Least tolerances of event-to-event steps, and their sweeps. One sweep is never enough: a weight
in a winter sea then errs by minutes a day.
"""

STRONG_SWEEPS = ((1e-7, 3),)
"""The same for a kinked cam and a real thread, which have strongly anharmonic wells."""


def sweeps_for(tolerance: float | None, strong: bool = False) -> int:
    """Return the sweeps of event-to-event steps within a tolerance, or 0 if such steps exceed it.

    A kinked cam and a real thread have a `strong` well.
    """
    bound, table = tolerance or 0.0, STRONG_SWEEPS if strong else FREE_END_SWEEPS
    return next((sweeps for error, sweeps in table if bound >= error), 0)


def make_collocation(
    machine: AnyMachine, tolerance: float | None = None, sweeps: int | None = None
) -> Collocation | RealThreads:
    """Return the general propagator for a machine, which takes steps. This imports kernels."""
    if isinstance(machine, Machine):
        count = sweeps_for(tolerance, machine.cam.kinked) if sweeps is None else sweeps
        if count and machine.escapement is not None:
            from tauto_core.motion.free_end import FreeEndCollocation, arm_is_bent, takes_free_ends

            if takes_free_ends(machine):
                extra = sweeps is None and arm_is_bent(machine)
                return FreeEndCollocation(machine, tolerance, count + extra)
        from tauto_core.motion.collocation import Collocation

        return Collocation(machine, tolerance)
    sweeps = sweeps_for(tolerance, True) if sweeps is None else sweeps
    if sweeps and machine.escapement is not None:
        from tauto_core.motion.real_threads import FreeEndThreads, thread_takes_free_ends

        if thread_takes_free_ends(machine):
            return FreeEndThreads(machine, tolerance, sweeps)
    from tauto_core.motion.real_threads import RealThreads

    return RealThreads(machine, tolerance)
