"""The general propagator of a wheel: Gauss collocation in the rotating frame, from event to event.

No step is longer than `longest_step_s`. A step is halved where its error exceeds the tolerance or
its stage equations are not solved. Events – turning points where drag has a kink, the kink of a
cam, impulses, the cam's edge, a slack thread – are stepped to, never over.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tauto_core.machines import Machine
from tauto_core.motion import stepping
from tauto_core.motion.arc_length import arc_shape
from tauto_core.motion.forcing import Forcing, Motion
from tauto_core.motion.lanes import SIZE
from tauto_core.motion.layout import SPARE
from tauto_core.motion.limits import edge_reached, released_beyond, thread_slack
from tauto_core.motion.phase import phase_rate, within_turn
from tauto_core.motion.step_size import (
    error_factor,
    longest_step,
    reference_frequency,
    stages_of,
)
from tauto_core.motion.stepped import Moved, Stepped, tolerance_of
from tauto_core.motion.wells import Impulse, PerInertia
from tauto_core.motion.wheel_nodes import NODES, Felt
from tauto_core.motion.wheel_plane import Wheel
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import PropagationError


def _or_none(value: float, inertia: float) -> float | None:
    """Return a term per inertia; None if it is zero, so that compiled code does without it."""
    return value / inertia if value else None


class Collocation(Stepped):
    """Propagator of any machine with one degree of freedom."""

    def __init__(self, machine: Machine, tolerance: float | None = None) -> None:
        self._machine = machine
        self._omega = reference_frequency(machine)
        self._shape = arc_shape(machine)
        stages = stages_of(machine, self._shape)
        factor = error_factor(machine, self._shape)
        # Steps of twice the length err 2^2S times as much with S stages, where the cam has joints
        # 2^8 times; a factor of two is left to spare.
        coarsen = 2.0 ** -((2 * stages if factor else 8) + 1)
        allowed = tolerance_of(tolerance, factor, coarsen)
        super().__init__(machine, 1, NODES, stages, allowed)
        self.longest_step_s = longest_step(
            machine, self._shape, self._omega, factor=factor, tolerance=allowed.step
        )

    def steps_in(self, length_s: float) -> int:
        """Return how many steps fill a piece of forcing; 1 if they end at events."""
        if self.order == 2 * SIZE or self._machine.escapement is not None:
            return 1
        return max(1, math.ceil(length_s / self.longest_step_s - SPARE))

    def _moved(self, forcing: Forcing) -> Moved:
        """Return the machine's numbers per inertia, absent ones as None."""
        machine = self._machine
        inertia = machine.inertia
        force, weight = machine.force, machine.pulling_mass
        if forcing.gravity is None:
            force, weight = force + weight * machine.gravity, 0.0
        drag, escapement = machine.drag, machine.escapement
        per_inertia = PerInertia(
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
        wheel = Wheel(
            per_inertia,
            machine.cam.lever,
            self._shape,
            Felt(*(None if channel is None else True for channel in channels)),
            impulse=escapement.angle if escapement else math.inf,
            pace=self._omega,
            range=machine.cam.range_rad,
            gravity=machine.gravity,
        )

        return Moved(wheel, (self._omega,))

    def release(self, forcing: Forcing) -> Motion:
        """Release the wheel at rest in the case at the beginning of the first span.

        Raises:
            PropagationError: the roll at the start puts the cam angle beyond the cam.
        """
        row, _ = self._released(forcing)
        felt = float(row['coordinate'][0])
        if not abs(felt) <= self._machine.cam.range_rad:
            raise released_beyond(self._machine, felt)
        return self._motion(row)

    def _failure(self, code: int, time_s: float) -> PropagationError:
        if code == stepping.EDGE:
            return edge_reached(self._machine, time_s)
        if code == stepping.SLACK:
            return thread_slack(time_s)
        return PropagationError(
            f'no convergence to the tolerance {self._tolerance.step:g} with steps of 2^-'
            f'{stepping.MAX_LEVEL} of a sample interval (cam angle '
            f'{self._state["planes"]["x"][0]:.6g} rad). Reduce the drag, or check '
            'the cam; on a moving ship, raise ship.rate',
            time_s,
        )

    def _within_turn(self, rows: NDArray[np.void]) -> FloatArray:
        angle, rate, bend = (rows[name] for name in ('coordinate', 'speed', 'acceleration'))
        return within_turn(self._machine, angle, rate, bend)

    def _phase_rate(self, rows: NDArray[np.void]) -> FloatArray:
        angle, rate, bend = (rows[name] for name in ('coordinate', 'speed', 'acceleration'))
        return phase_rate(self._machine, angle, rate, bend)
