"""The base class of the propagators that take steps with the driver `stepping`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.machines import AnyMachine
from tauto_core.motion import stepping
from tauto_core.motion.forcing import Forcing, Motion, check_powers, no_motion
from tauto_core.motion.gauss_step import TERMS, Omega, make_work
from tauto_core.motion.outside import Pieces
from tauto_core.motion.phase import since_start
from tauto_core.motion.stepping import TOLERANCE, carried_within, settled_at
from tauto_core.motion.system import Tolerance, restore_record, state_of, state_type
from tauto_core.samples import FloatArray, State
from tauto_core.scene.errors import PropagationError

NAME = 'collocation'


class Moved(NamedTuple):
    """What moves: a `system.System` with its numbers, and ω of each of its planes [rad/s]."""

    system: Any
    omega: Omega


def tolerance_of(step: float | None, factor: float, coarsen: float) -> Tolerance:
    """Return the accuracy of steps.

    Args:
        step: error allowed in a step, relative to the state; None: the default.
        factor: as in `Tolerance`.
        coarsen: share of the error allowed below which steps double.
    """
    step = TOLERANCE if step is None else step
    return Tolerance(step, factor, settled_at(step), carried_within(step), step * coarsen)


class Stepped(ABC):
    """A propagator that takes steps; a derived class turns a machine into a system.

    Args:
        machine: the machine.
        planes: number of rotating planes.
        nodes: names of the rows that its system keeps at the nodes of a step.
        stages: number of stages of a step.
        tolerance: accuracy of steps.
    """

    name = NAME
    longest_step_s: float

    def __init__(
        self,
        machine: AnyMachine,
        planes: int,
        nodes: tuple[str, ...],
        stages: int,
        tolerance: Tolerance,
    ) -> None:
        self._inertia, self._release_angle = machine.inertia, machine.release_angle
        self.order = 2 * stages
        self._tolerance = tolerance
        self._state = np.zeros((), state_type(planes))
        self._work = make_work(planes, nodes, stages)
        self._start_angle = 0.0

    @abstractmethod
    def _moved(self, forcing: Forcing) -> Moved:
        """Return the system for the channels that the forcing has."""

    @abstractmethod
    def _within_turn(self, rows: NDArray[np.void]) -> FloatArray:
        """Return the phase within a turn (phase.polar)."""

    @abstractmethod
    def _phase_rate(self, rows: NDArray[np.void]) -> FloatArray:
        """Return φ̇ [rad/s]."""

    @abstractmethod
    def _failure(self, code: int, time_s: float) -> PropagationError:
        """Return the error of a run that ends early."""

    def _outside(self, forcing: Forcing) -> Pieces:
        """Return the pieces of the forcing, of which none may have too many powers."""
        check_powers(forcing, TERMS)
        return Pieces(forcing.length_s, forcing.neutral, forcing.tilt, forcing.gravity)

    def _released(self, forcing: Forcing) -> tuple[NDArray[np.void], float]:
        """Set the state; return the row at the start and the tension there."""
        row = np.empty(1, stepping.ROW)
        tension = stepping.release(
            *self._moved(forcing),
            self._release_angle,
            self._outside(forcing),
            float(forcing.begin[0]),
            self._state,
            self._work,
            row.reshape(()),
        )
        self._start_angle = float(self._within_turn(row)[0])
        return row, tension

    def _run(
        self, forcing: Forcing, moved: Moved, tolerance: Tolerance, longest_s: float
    ) -> tuple[NDArray[np.void], int, int, float]:
        """Advance; return rows of the logged ends, a code, and the span and place it ended in."""
        rows = np.empty(int(np.count_nonzero(forcing.logged)), stepping.ROW)
        code, span, x = stepping.advance(
            *moved,
            tolerance,
            longest_s,
            self._outside(forcing),
            stepping.Spans(forcing.begin, forcing.end, forcing.logged),
            self._state,
            self._work,
            rows,
        )
        return rows, code, span, x

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans; return the motion at their logged ends.

        Raises:
            PropagationError: slack thread, end of the range, or no convergence.
        """
        moved = self._moved(forcing)
        rows, code, span, x = self._run(forcing, moved, self._tolerance, self.longest_step_s)
        if code != stepping.OK:
            left = (forcing.end[span] - x) * forcing.length_s[span]
            raise self._failure(code, float(forcing.end_ns[span] * 1e-9 - left))
        return self._motion(rows) if len(rows) else no_motion()

    def _motion(self, rows: NDArray[np.void]) -> Motion:
        half_turns, fraction = since_start(
            rows['turns'], self._within_turn(rows), self._start_angle
        )
        return Motion(
            angle=rows['angle'],
            rate=rows['rate'],
            torque=self._inertia * rows['torque'],
            half_turns=half_turns,
            fraction=fraction,
            phase_rate=self._phase_rate(rows),
            beats=rows['beats'].copy(),
        )

    def state(self) -> State:
        """Return the running state by its names, and the phase at the start."""
        return {**state_of(self._state), 'start_angle': self._start_angle}

    def restore(self, state: State) -> None:
        """Go on from a state."""
        restore_record(self._state, state)
        self._start_angle = float(state['start_angle'])
