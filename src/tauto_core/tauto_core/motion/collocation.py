"""The general propagator: Gauss collocation in the rotating frame, between events.

A span is one step or more, none longer than `longest_step_s`; steps are halved when the error
estimate exceeds the tolerance or the iteration does not converge, and events – turning points
where drag is not smooth, the kink of a cam, impulses, the cam's edge, a slack thread – are
stepped to, never over.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tauto_core.machines import Machine
from tauto_core.motion import stepping
from tauto_core.motion.arc_length import arc_shape
from tauto_core.motion.forcing import Forcing, Motion, check_powers, no_motion
from tauto_core.motion.lanes import SIZE
from tauto_core.motion.layout import SPARE
from tauto_core.motion.limits import edge_reached, released_beyond, thread_slack
from tauto_core.motion.outside import Pieces
from tauto_core.motion.phase import phase_rate, within_turn
from tauto_core.motion.step_size import (
    TOLERANCE,
    carried_within,
    error_factor,
    longest_step,
    reference_frequency,
    settled_at,
    stages_of,
)
from tauto_core.motion.system import Tolerance, restore_record, state_of, state_type
from tauto_core.motion.wells import Impulse, Terms
from tauto_core.motion.wheel_plane import NODES, Felt, Wheel
from tauto_core.motion.work import TERMS, make_work
from tauto_core.samples import State
from tauto_core.scene.errors import PropagationError

NAME = 'collocation'


def _or_none(value: float, unit: float) -> float | None:
    return value / unit if value else None


class Collocation:
    """Propagator of any machine with one degree of freedom."""

    name = NAME

    def __init__(self, machine: Machine, tolerance: float | None = None) -> None:
        self._machine = machine
        self._omega = reference_frequency(machine)
        self._lever = machine.cam.lever
        self._shape = arc_shape(machine)
        stages = stages_of(machine, self._shape)
        self.order = 2 * stages
        self._factor = error_factor(machine, self._shape)
        tolerance = TOLERANCE if tolerance is None else tolerance
        # steps double below this: the error of smooth ones grows by 2^2S, else by 2^8
        coarsen = 2.0 ** -((self.order if self._factor else 8) + 1)
        self._tolerance = Tolerance(
            tolerance,
            self._factor,
            settled_at(tolerance),
            carried_within(tolerance),
            tolerance * coarsen,
        )
        self._state = np.zeros((), state_type(1))
        self._work = make_work(1, NODES, stages)
        self._start_angle = 0.0
        self.longest_step_s = longest_step(
            machine, self._shape, self._omega, factor=self._factor, tolerance=tolerance
        )

    def steps_in(self, length_s: float) -> int:
        """Return how many steps fill a piece of forcing; 1 if they end at events."""
        if self.order == 2 * SIZE or self._machine.escapement is not None:
            return 1
        return max(1, math.ceil(length_s / self.longest_step_s - SPARE))

    def _system(self, forcing: Forcing) -> Wheel:
        """Return the machine's numbers divided by its inertia, absent ones as None."""
        machine = self._machine
        inertia = machine.inertia
        force, weight = machine.force, machine.pulling_mass
        if forcing.gravity is None:
            force, weight = force + weight * machine.gravity, 0.0
        drag, escapement = machine.drag, machine.escapement
        terms = Terms(
            carried=_or_none(machine.carried_mass, inertia),
            force=_or_none(force, inertia),
            stiffness=_or_none(machine.stiffness, inertia),
            weight=_or_none(weight, inertia),
            viscous=_or_none(drag.viscous, inertia) if drag else None,
            quadratic=_or_none(drag.quadratic, inertia) if drag else None,
            coulomb=_or_none(drag.coulomb, inertia) if drag else None,
            impulse=Impulse(2.0 * escapement.energy / inertia, escapement.ebb)
            if escapement
            else None,
            recoil=_or_none(escapement.recoil, inertia) if escapement else None,
        )
        channels = forcing.neutral, forcing.tilt, forcing.gravity
        return Wheel(
            terms,
            self._lever,
            self._shape,
            Felt(*(None if channel is None else True for channel in channels)),
            impulse=escapement.angle if escapement else math.inf,
            pace=self._omega,
            range=machine.cam.range_rad,
            gravity=machine.gravity,
        )

    @staticmethod
    def _outside(forcing: Forcing) -> Pieces:
        check_powers(forcing, TERMS)
        return Pieces(forcing.length_s, forcing.neutral, forcing.tilt, forcing.gravity)

    def release(self, forcing: Forcing) -> Motion:
        """Release the wheel at rest in the case at the beginning of the first span.

        Raises:
            PropagationError: the roll at the start puts the cam angle beyond the cam.
        """
        row = np.empty(1, stepping.ROW)
        stepping.release(
            self._system(forcing),
            (self._omega,),
            self._machine.release_angle,
            self._outside(forcing),
            float(forcing.begin[0]),
            self._state,
            self._work,
            row.reshape(()),
        )
        felt = float(row['coordinate'][0])
        if not abs(felt) <= self._machine.cam.range_rad:
            raise released_beyond(self._machine, felt)
        self._start_angle = float(within_turn(self._machine, row['coordinate'], row['speed'])[0])
        return self._motion(row)

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans; return the motion at their logged ends.

        Raises:
            PropagationError: slack thread, edge of the cam, or no convergence.
        """
        rows = np.empty(int(np.count_nonzero(forcing.logged)), stepping.ROW)
        code, span, x = stepping.advance(
            self._system(forcing),
            (self._omega,),
            self._tolerance,
            self.longest_step_s,
            self._outside(forcing),
            stepping.Spans(forcing.begin, forcing.end, forcing.logged),
            self._state,
            self._work,
            rows,
        )
        if code != stepping.OK:
            left = (forcing.end[span] - x) * forcing.length_s[span]
            raise self._failure(code, float(forcing.end_ns[span] * 1e-9 - left))
        return self._motion(rows) if len(rows) else no_motion()

    def _failure(self, code: int, time_s: float) -> PropagationError:
        if code == stepping.EDGE:
            return edge_reached(self._machine, time_s)
        if code == stepping.SLACK:
            return thread_slack(time_s)
        return PropagationError(
            f'no convergence to the tolerance {self._tolerance.step:g} with steps of 2^-'
            f'{stepping.MAX_LEVEL} of a sample interval (cam angle '
            f'{self._state["planes"]["x"][0]:.6g} rad). Raise ship.rate, or check drag and cam',
            time_s,
        )

    def _motion(self, rows: NDArray[np.void]) -> Motion:
        machine, felt, speed = self._machine, rows['coordinate'], rows['speed']
        half = (within_turn(machine, felt, speed) - self._start_angle) / math.pi
        whole = np.floor(half)
        return Motion(
            angle=rows['angle'],
            rate=rows['rate'],
            torque=machine.inertia * rows['torque'],
            half_turns=2 * rows['turns'] + whole.astype(np.int64),
            fraction=half - whole,
            phase_rate=phase_rate(machine, felt, speed, rows['acceleration']),
            beats=rows['beats'].copy(),
        )

    def state(self) -> State:
        """Return the running state by its names, and the phase at the start."""
        return {**state_of(self._state), 'start_angle': self._start_angle}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        restore_record(self._state, state)
        self._start_angle = float(state['start_angle'])
