"""Propagators: how the regulator moves under the ship's motion.

`make_propagator` chooses one by the machine and by whether the platform is still.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Protocol

from tauto_core.machines import AnyMachine, LeverMachine, Machine, OtherRegulator
from tauto_core.motion.forcing import Forcing, Motion, swings_freely
from tauto_core.samples import State

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
    lasts = machine.drag is None and machine.escapement is None and not machine.heat.acts
    if isinstance(machine, Machine):
        if still and lasts and machine.is_harmonic:
            return 'harmonic'
        if _stays_linear(machine) and (still or not machine.pulling_mass):
            return 'forced_harmonic'
        is_even = machine.imbalance is None and machine.has_small_swings
    else:
        is_even = isinstance(machine, LeverMachine)
    closed = still and lasts and is_even and swings_freely(machine)
    return 'action_angle' if closed else 'collocation'


def _stays_linear(machine: Machine) -> bool:
    """Return whether the wheel on land is a linear oscillator below critical damping."""
    drag = machine.drag
    if machine.heat.acts or not machine.is_linear or machine.escapement is not None:
        return False
    if drag is None:
        return True
    return drag.is_linear and drag.viscous < 2.0 * machine.inertia * machine.frequency


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
    name = propagator_name(machine, still=still)
    if not isinstance(machine, OtherRegulator) and name == 'collocation':
        return make_collocation(machine, tolerance, sweeps)
    # imported at their first use: some import kernels
    module, made = EXACT['uneven' if isinstance(machine, LeverMachine) else name]
    exact: Propagator = getattr(import_module(f'tauto_core.motion.{module}'), made)(machine)
    return exact


EXACT = {
    'harmonic': ('closed_forms', 'Harmonic'),
    'action_angle': ('closed_forms', 'ActionAngle'),
    'uneven': ('closed_forms', 'UnevenWell'),
    'forced_harmonic': ('forced_harmonic', 'ForcedHarmonic'),
    'axle': ('axle', 'AxleSwings'),
    'half_swings': ('fluid', 'HalfSwings'),
}
"""Module and class of the propagators that take no steps of a given accuracy, by name."""


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
    if sweeps is None:
        count = sweeps_for(tolerance, not isinstance(machine, Machine) or machine.cam.kinked)
    else:
        count = sweeps
    leaps = count > 0 and machine.escapement is not None
    if isinstance(machine, Machine):
        if leaps:
            from tauto_core.motion.free_end import FreeEndCollocation, arm_is_bent, takes_free_ends

            if takes_free_ends(machine):
                extra = sweeps is None and arm_is_bent(machine)
                return FreeEndCollocation(machine, tolerance, count + extra)
        from tauto_core.motion.collocation import Collocation

        return Collocation(machine, tolerance)
    from tauto_core.motion.real_threads import FreeEndThreads, RealThreads, thread_takes_free_ends

    if leaps and thread_takes_free_ends(machine):
        return FreeEndThreads(machine, tolerance, count)
    return RealThreads(machine, tolerance)
