"""The propagator of a lever or a swinging thread that steps from impulse to impulse."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.machines import HangingMachine, LeverMachine
from tauto_core.motion.free_end import (
    FREE,
    LEAST_FREE_SETTLED,
    MOST_IN_ONE,
    NEARER,
    TO_END,
    FreeEnds,
)
from tauto_core.motion.free_step import FreeEnd
from tauto_core.motion.lanes import WIDE_SIZE
from tauto_core.motion.real_threads import RealThreads

LEAST_ERROR_OF_THREAD, NEAR_ON_THREAD = 1e-8, 0.003
"""The least error of a step, and the phase from its end within which it is not repeated [rad], for
a lever or a swinging thread. Within 0.01 rad Sully's lever, hung, errs by 1e-3 s/day; and 0.0166
rad before the end of half a swing lies a node, which would be counted if the impulse came before.
"""

SHAPE_SHARE, USUAL_PER_RELEASE = 3e-3, 1.2
"""Error of the functions of a lever's arc over the tolerance: a rate errs by 0.03 of the accuracy.
And how far they reach beyond the release in few terms, as `wells.REACH_PER_RELEASE`.
"""


def thread_takes_free_ends(machine: LeverMachine | HangingMachine) -> bool:
    """Return whether a lever or a swinging thread can step from impulse to impulse.

    It needs an escapement, no kink of the drag, and a pull whose law has no joints. The stages of
    a thread whose lean is damped settle too slowly.
    """
    apt = machine.law is None if isinstance(machine, LeverMachine) else not machine.damping
    linear = machine.drag is None or machine.drag.is_linear
    return machine.escapement is not None and linear and apt


def thread_end_of(pace: float, sweeps: int) -> FreeEnd:
    """Return the settings for a lever or a swinging thread of a pace [rad/s]."""
    settled = max(LEAST_FREE_SETTLED, 10.0 ** -(2 * sweeps + 1))
    error, close = max(LEAST_ERROR_OF_THREAD, 1e-6 * settled), 10.0 ** -(1.0 + 0.5 * sweeps)
    near = NEAR_ON_THREAD if sweeps <= MOST_IN_ONE else NEARER
    return FreeEnd(sweeps, settled, error, near, close, math.pi / pace, 1.0, 0.0, 0.0, 0.0)


class FreeEndThreads(FreeEnds, RealThreads):
    """Propagator of a lever or a swinging thread that steps from impulse to impulse."""

    def __init__(
        self, machine: LeverMachine | HangingMachine, tolerance: float | None, sweeps: int
    ) -> None:
        super().__init__(machine, tolerance, WIDE_SIZE, TO_END, SHAPE_SHARE, USUAL_PER_RELEASE)
        self._free_end = thread_end_of(self._model.system.pace, sweeps)
        self._free = np.zeros((), FREE)
        self._fill_constants()
