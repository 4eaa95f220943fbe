"""The propagator of Sully's lever and of the swinging thread: collocation from event to event.

Where the ship lies still, its apparent vertical and gravity are constant polynomials, so that the
same kernels serve on land and at sea.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.machines import HangingMachine, LeverMachine
from tauto_core.machines.drags import Drag
from tauto_core.machines.heat import NO_HEAT, HeatFactors
from tauto_core.machines.threads.hanging import LEAST_FREE
from tauto_core.motion import lever, stepping, threads
from tauto_core.motion.forcing import Forcing, Motion, thread_slack
from tauto_core.motion.free_end import (
    FREE,
    LEAST_FREE_SETTLED,
    MOST_IN_ONE,
    NEARER,
    TO_END,
    FreeEnds,
)
from tauto_core.motion.free_step import FreeEnd
from tauto_core.motion.lanes import SIZE, WIDE_SIZE
from tauto_core.motion.lever import SullyLever, arc_series
from tauto_core.motion.phase import polar, polar_rate
from tauto_core.motion.slack import SlackThread
from tauto_core.motion.stepping import (
    ERROR_OF_LAST_STRONG,
    ITERATION_SHARE,
    MIN_ANGLE,
    TOLERANCE_SHARE,
    Moved,
    hot_pieces,
    tolerance_of,
)
from tauto_core.motion.system import ForcingPieces, HotNumbers
from tauto_core.motion.threads import Hanging, OnWheel
from tauto_core.motion.wells import REACH_PER_RELEASE
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import CamRangeError, PropagationError

LONGEST_PHASE = {SIZE: 2.0, WIDE_SIZE: 3.05}
"""Longest step by its number of stages, as the phase ωh of the fastest plane [rad]."""

# Factor by which the next shorter step is tried.
_SHORTER = 0.94

# Most steps of a trial, for threads whose own period is far longer than the wheel's.
_MOST_TRIAL_STEPS = 4096


class CaseAtStart(NamedTuple):
    """The case at the start, by the direction β of the apparent vertical and its tilt τ = β − α_c.

    Attributes:
        vertical: β [rad].
        vertical_rate: β̇ [rad/s].
        tilt: τ [rad].
        tilt_rate: τ̇ [rad/s].
    """

    vertical: float
    vertical_rate: float
    tilt: float
    tilt_rate: float


def _on_wheel(machine: LeverMachine | HangingMachine, pace: float) -> OnWheel:
    drag, escapement, inertia = machine.drag or Drag(), machine.escapement, machine.inertia
    energy = 0.0 if escapement is None else 2.0 * escapement.energy
    recoil = escapement.recoil / inertia if escapement and escapement.recoil else None
    return OnWheel(
        viscous=drag.viscous / inertia,
        quadratic=drag.quadratic / inertia,
        energy=energy / inertia,
        recoil=recoil,
        impulse=math.inf if escapement is None else escapement.angle,
        pace=pace,
        gravity=machine.gravity,
        law=drag.law(inertia),
        heat=machine.heat.acts or None,
    )


def _lever(machine: LeverMachine, settled: float, per_release: float) -> Moved:
    """Return the lever, in a plane that turns with the free swing from the release angle."""
    try:
        omega = math.tau / machine.period(machine.release_angle)
    except CamRangeError:
        omega = machine.frequency
    root_j = math.sqrt(machine.turned_inertia / machine.inertia)
    side = machine.geometry.side
    kappa = side * machine.moment / (machine.inertia * root_j)
    on_wheel, mirrored = _on_wheel(machine, omega), True if side < 0.0 else None
    shape = arc_series(machine, settled, per_release)
    system = SullyLever(shape, root_j, kappa, on_wheel, mirrored)
    return Moved(system, (omega,))


def _pair(numbers: FloatArray) -> tuple[float, float]:
    return float(numbers[0]), float(numbers[1])


def _hanging(machine: HangingMachine) -> Moved:
    """Return the swinging thread, in the planes of its modes."""
    slow, fast, slow_share, fast_share = machine.modes
    columns = np.array([[slow_share, fast_share], [machine.base_radius, machine.base_radius]])
    columns = columns / np.max(np.abs(columns), axis=0)
    back = np.linalg.inv(columns)
    system = Hanging(
        machine.base_radius,
        machine.length,
        LEAST_FREE * machine.length,
        machine.mass * machine.base_radius / machine.inertia,
        _pair(columns[0]),
        _pair(columns[1]),
        _pair(back[0]),
        _pair(back[1]),
        _on_wheel(machine, machine.frequency),
        machine.damping / machine.mass if machine.damping else None,
        spring=machine.stiffness / machine.mass if machine.stiffness else None,
    )
    omega = math.sqrt(machine.gravity / slow), math.sqrt(machine.gravity / fast)
    return Moved(system, omega)


class RealThreads(SlackThread):
    """Propagator of a machine whose thread draws on a lever, or swings."""

    def __init__(
        self,
        machine: LeverMachine | HangingMachine,
        tolerance: float | None = None,
        stages: int = SIZE,
        constants: tuple[str, ...] = (),
        shape_share: float = ITERATION_SHARE,
        per_release: float = REACH_PER_RELEASE,
    ) -> None:
        self._machine = machine
        allowed = tolerance_of(tolerance, ERROR_OF_LAST_STRONG, 2.0 ** -(2 * stages + 1))
        nodes: tuple[str, ...] = threads.THREAD_NODES
        if isinstance(machine, LeverMachine):
            self._model = _lever(machine, shape_share * allowed.step, per_release)
            nodes = lever.LEVER_NODES
        else:
            self._model = _hanging(machine)
            nodes += threads.SPRING_NODES * bool(machine.stiffness)
        hot, planes = machine.heat.acts, len(self._model.omega)
        rows, columns = (HotNumbers._fields, 2 * SIZE) if hot else ((), SIZE)
        super().__init__(machine, planes, (*nodes, *rows, *constants), stages, allowed, columns)
        if hot:
            lasting = replace(machine, heat=NO_HEAT)
            cold = RealThreads(lasting, tolerance, stages, (), shape_share, per_release)
            self.longest_step_s = cold.longest_step_s
        else:
            self.longest_step_s = self._longest_step()

    def _moved(self, forcing: Forcing) -> Moved:
        return self._model

    def _loosened(self, taut: Moved) -> Moved:
        """Return the machine with a slack thread."""
        # slow to import, and needed by few
        from tauto_core.motion.slack_threads import LooseLever, LooseThread

        system, pace = taut.system, taut.system.pace
        if isinstance(system, Hanging):
            return Moved(LooseThread(system), (pace, pace, pace))
        return Moved(LooseLever(system), (pace, pace))

    def release(self, forcing: Forcing) -> Motion:
        """Release the wheel at rest in the case at the beginning of the first span.

        A swinging thread hangs along the apparent vertical, and follows it. Raises a
        PropagationError for a release at which the geometry ends, or at which the thread of a
        machine that stops with a slack thread is slack.
        """
        # the case at the beginning of the first span
        x, per_s = float(forcing.begin[0]), 1.0 / float(forcing.length_s[0])
        parts: list[float] = []
        for channel in (forcing.neutral, forcing.tilt):
            series = np.polynomial.Polynomial([0.0] if channel is None else channel[0])
            parts += [float(series(x)), float(series.deriv()(x)) * per_s]
        machine, case = self._machine, CaseAtStart(*parts)
        felt = machine.felt_angle(machine.release_angle, case.tilt)
        if not abs(felt) <= machine.range_rad:
            raise PropagationError(
                f'the release angle {machine.release_angle:.6g} rad and the motion at the start '
                f'make the angle of the thread on the wheel {felt:.6g} rad, beyond '
                f'±{machine.range_rad:.6g} rad. Release at a smaller angle',
                0.0,
            )
        self._place(case)
        row, tension = self._released(forcing)
        if self._machine.stops_when_slack and not tension > 0.0:
            raise thread_slack(0.0)
        return self._motion(row)

    def _outside(self, forcing: Forcing) -> ForcingPieces:
        """Return the pieces, with the machine's numbers where heat changes them.

        Channels are constants on a ship that lies still. So are gravity and tilt for a force,
        which feels neither.
        """
        still = np.zeros((len(forcing.length_s), 1))
        if forcing.neutral is None or forcing.tilt is None:
            case = still if forcing.neutral is None else forcing.neutral
            pieces = ForcingPieces(forcing.length_s, case, still, still + self._machine.gravity)
        else:
            pieces = super()._outside(forcing)
        heat, system = self._machine.heat, self._model.system
        if not heat.acts:
            return pieces
        # both draw by a weight, or the lever by a force: κ of the lever, m r/I of the thread
        swings = isinstance(system, Hanging)
        drawn, radius = (system.ratio, system.radius) if swings else (system.kappa, 0.0)
        viscous, given = system.on_wheel.viscous, forcing.temperatures
        widening = 0.0 if given is None else radius * heat.cam * given.per_s

        def numbers(factors: HeatFactors, growth: FloatArray) -> HotNumbers:
            share = 1.0 / factors.inertia
            return HotNumbers(
                carried=radius * np.sqrt(factors.carried),
                force=widening,
                stiffness=0.0,
                # of a weight the same, since only the force of a spring changes with heat
                weight=share * drawn * factors.force,
                viscous=share * viscous * factors.viscous,
                share=share,
                growth=growth,
            )

        return pieces._replace(hot=hot_pieces(forcing, heat, numbers))

    def _place(self, case: CaseAtStart) -> None:
        """Put the wheel at rest in the case at the release angle.

        The lever then has ṡ = 0, so that p = Aα̇ (`lever`).
        """
        machine, (system, omega) = self._machine, self._model
        case_rate, planes = case.vertical_rate - case.tilt_rate, self._state['planes']
        planes[:] = 0.0, 0.0, 0.0, 0.0
        if isinstance(system, Hanging):
            angles = machine.release_angle + case.vertical - case.tilt, case.vertical
            for p, back in enumerate((system.to_first, system.to_second)):
                planes['x'][p] = back[0] * angles[0] + back[1] * angles[1]
                rate = back[0] * case_rate + back[1] * case.vertical_rate
                planes['y'][p] = rate / omega[p]
        elif isinstance(machine, LeverMachine):
            angle = machine.release_angle
            ratio = machine.geometry.side * system.root_j * float(machine.ratio(angle))
            a = (1.0 + system.root_j * ratio) / math.hypot(1.0, ratio)
            planes['x'] = float(machine.arc(angle)) / math.sqrt(machine.inertia)
            planes['y'] = a * case_rate / omega[0]

    def _longest_step(self) -> float:
        """Return the longest step [s] with which no step of a swing on land must be halved."""
        stages = self.order // 2
        angle, fastest = LONGEST_PHASE[stages], max(self._model.omega)
        swing_s = math.tau / min(self._model.omega)
        # No turning points are found here, so that the drag may not ask for the direction of the
        # swing; no impulse comes, so that the pallet stays 0 and recoil with it.
        on_wheel = self._model.system.on_wheel._replace(quadratic=0.0, law=None, impulse=math.inf)
        free = self._model._replace(system=self._model.system._replace(on_wheel=on_wheel))
        step = TOLERANCE_SHARE * self._tolerance.step
        tolerance = self._tolerance._replace(step=step, coarsen=step * 2.0 ** -(2 * stages + 1))
        while angle > MIN_ANGLE:
            step_s = angle / fastest
            count = min(math.ceil(swing_s / step_s), _MOST_TRIAL_STEPS)
            trial = Forcing(
                length_s=np.full(count, step_s),
                begin=np.zeros(count),
                end=np.ones(count),
                end_ns=np.zeros(count, np.int64),
                logged=np.zeros(count, np.bool_),
            )
            self._state = np.zeros_like(self._state)
            self._place(CaseAtStart(0.0, 0.0, 0.0, 0.0))
            super()._run(trial, free, tolerance, step_s)
            if self._state['level'] == 0 and self._state['newton'] == 0:
                break
            angle *= _SHORTER
        return angle / fastest

    def _failure(self, code: int, time_s: float) -> PropagationError:
        if code == stepping.SLACK:
            return thread_slack(time_s)
        if code == stepping.NO_CONVERGENCE:
            return PropagationError(
                f'no convergence to the tolerance {self._tolerance.step:g} with steps of 2^-'
                f'{stepping.MAX_LEVEL} of a sample interval. Reduce the drag, or check the '
                'dimensions of wheel and thread; on a moving ship, raise ship.rate',
                time_s,
            )
        if isinstance(self._machine, LeverMachine):
            reached = 'the wheel turned so far that the geometry of the lever ends, near '
            reached += 'a dead point, or beyond what its series describe'
        else:
            reached = 'the whole thread is wound up on the wheel'
        return PropagationError(
            f'{reached} (range ±{self._machine.range_rad:.6g} rad). Use a longer thread or lever, '
            'a smaller release angle, a weaker escapement or a calmer sea',
            time_s,
        )

    def _phase(self, rows: NDArray[np.void]) -> tuple[FloatArray, FloatArray]:
        """Return the phase within a turn, of s of the lever or u of the thread, and its rate."""
        x, speed, acceleration = (rows[name] for name in ('coordinate', 'speed', 'acceleration'))
        seen = x, speed, acceleration, self._machine.frequency
        return polar(*seen), polar_rate(*seen)


# -----------------------------------------------------------------------------
# Steps from impulse to impulse (`free_end`).

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
