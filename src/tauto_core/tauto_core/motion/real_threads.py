"""Propagator of Sully's lever and of the swinging thread: collocation from event to event.

On a ship at rest the apparent vertical and gravity are constant polynomials, hence the same
kernels serve on land and at sea. The last part has the systems with a slack thread.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import compiled, inlined
from tauto_core.machines import HangingMachine, LeverMachine
from tauto_core.machines.drags import Drag
from tauto_core.machines.heat import NO_HEAT, HeatFactors
from tauto_core.machines.threads.hanging import LEAST_FREE
from tauto_core.motion import lever, stepping, threads
from tauto_core.motion.forcing import Forcing, Motion, polar, polar_rate, thread_slack
from tauto_core.motion.free_end import (
    FREE,
    TO_END,
    FreeEnds,
    free_end,
)
from tauto_core.motion.gauss_step import Mode, Omega, Work, sine_versine
from tauto_core.motion.lanes import (
    SIZE,
    WIDE_SIZE,
    Numeric,
    filled,
    lane,
    largest,
    row_of,
    store,
    width,
    with_lane,
)
from tauto_core.motion.lever import SullyLever, arc_series, lever_on_arc
from tauto_core.motion.slack import LooseSystem, Retension, SlackThread, rounding_of
from tauto_core.motion.stepping import (
    ERROR_OF_LAST_STRONG,
    ITERATION_SHARE,
    MIN_ANGLE,
    TOLERANCE_SHARE,
    Model,
    thermal_pieces,
    tolerance_of,
)
from tauto_core.motion.system import (
    HOT_NODES,
    Exits,
    ForcingPieces,
    HeatTerms,
    Inputs,
    Instant,
    Plane,
    RunningState,
    StepPlace,
    first_below,
    heated_at_nodes,
    heated_now,
    near_zero,
    planes_of,
)
from tauto_core.motion.threads import (
    MOST_ITERATIONS,
    SETTLED,
    Hanging,
    OnWheel,
    WithThread,
    drag_on_wheel,
    transverse,
)
from tauto_core.motion.wells import REACH_PER_RELEASE, whole_turns_off
from tauto_core.motion.wheel import reference_frequency
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import PropagationError

LONGEST_PHASE = {SIZE: 2.0, WIDE_SIZE: 3.05}
"""Longest step by its number of stages, as the phase ωh of the fastest plane [rad]."""

# Factor between one trial step and the next shorter one.
_SHORTER = 0.94

# Most steps of a trial, for threads with a far longer period than the wheel.
_MOST_TRIAL_STEPS = 4096


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


def _lever(machine: LeverMachine, settled: float, per_release: float) -> Model:
    """Return the lever in a plane that turns as the free swing from the release angle does."""
    omega = reference_frequency(machine)
    root_j = math.sqrt(machine.turned_inertia / machine.inertia)
    side = machine.geometry.side
    kappa = side * machine.moment / (machine.inertia * root_j)
    on_wheel, mirrored = _on_wheel(machine, omega), True if side < 0.0 else None
    shape = arc_series(machine, settled, per_release)
    system = SullyLever(shape, root_j, kappa, on_wheel, mirrored)
    return Model(system, (omega,))


def _hanging(machine: HangingMachine) -> Model:
    """Return the swinging thread in the planes of its modes."""
    slow, fast, slow_share, fast_share = machine.modes
    columns = np.array([[slow_share, fast_share], [machine.base_radius, machine.base_radius]])
    columns = columns / np.max(np.abs(columns), axis=0)
    wheel, thread = map(tuple, columns.tolist())
    to_first, to_second = map(tuple, np.linalg.inv(columns).tolist())
    system = Hanging(
        machine.base_radius,
        machine.length,
        LEAST_FREE * machine.length,
        machine.mass * machine.base_radius / machine.inertia,
        wheel,
        thread,
        to_first,
        to_second,
        _on_wheel(machine, machine.frequency),
        machine.damping / machine.mass if machine.damping else None,
        spring=machine.stiffness / machine.mass if machine.stiffness else None,
    )
    omega = math.sqrt(machine.gravity / slow), math.sqrt(machine.gravity / fast)
    return Model(system, omega)


class RealThreads(SlackThread):
    """Propagator of a machine with a thread that draws on a lever, or swings."""

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
        rows, columns = (HOT_NODES, 2 * SIZE) if hot else ((), SIZE)
        super().__init__(machine, planes, (*nodes, *rows, *constants), stages, allowed, columns)
        if hot:
            lasting = replace(machine, heat=NO_HEAT)
            cold = RealThreads(lasting, tolerance, stages, (), shape_share, per_release)
            self.longest_step_s = cold.longest_step_s
        else:
            self.longest_step_s = self._longest_step()

    def _model_of(self, forcing: Forcing) -> Model:
        return self._model

    def _loose_model(self, taut: Model) -> Model:
        """Return the machine with a slack thread."""
        system, pace = taut.system, taut.system.pace
        if isinstance(system, Hanging):
            return Model(LooseThread(system), (pace, pace, pace))
        return Model(LooseLever(system), (pace, pace))

    def release(self, forcing: Forcing) -> Motion:
        """Release the wheel at rest in the case at the beginning of the first span.

        A swinging thread hangs along the apparent vertical and moves with it. Raises a
        PropagationError if the release angle is beyond the geometry's range, or the thread is
        slack and the machine stops with a slack thread.
        """
        # the case at the beginning of the first span
        x, per_s = float(forcing.begin[0]), 1.0 / float(forcing.length_s[0])
        parts: list[float] = []
        for channel in (forcing.neutral, forcing.tilt):
            series = np.polynomial.Polynomial([0.0] if channel is None else channel[0])
            parts += [float(series(x)), float(series.deriv()(x)) * per_s]
        machine = self._machine
        sensed_angle = machine.sensed_angle(machine.release_angle, parts[2])
        if not abs(sensed_angle) <= machine.range_rad:
            raise PropagationError(
                f'the release angle {machine.release_angle:.6g} rad and the motion at the start '
                f'make the angle of the thread on the wheel {sensed_angle:.6g} rad, beyond '
                f'±{machine.range_rad:.6g} rad. Release at a smaller angle',
                0.0,
            )
        self._place(*parts)
        row, tension = self._released(forcing)
        if self._machine.stops_when_slack and not tension > 0.0:
            raise thread_slack(0.0)
        return self._motion(row)

    def _outside(self, forcing: Forcing) -> ForcingPieces:
        """Return the pieces, with the machine's parameters if heat changes them.

        Channels are constants on a ship at rest. So are gravity and tilt for a machine driven by a
        force, which depends on neither.
        """
        zeros = np.zeros((len(forcing.length_s), 1))
        if forcing.neutral is None or forcing.tilt is None:
            case = zeros if forcing.neutral is None else forcing.neutral
            pieces = ForcingPieces(forcing.length_s, case, zeros, zeros + self._machine.gravity)
        else:
            pieces = super()._outside(forcing)
        heat, system = self._machine.heat, self._model.system
        if not heat.acts:
            return pieces
        # κ of the lever (weight or force), m r/I of the thread
        swings = isinstance(system, Hanging)
        drawn, radius = (system.ratio, system.radius) if swings else (system.kappa, 0.0)
        viscous, temperatures = system.on_wheel.viscous, forcing.temperatures
        widening = 0.0 if temperatures is None else radius * heat.cam * temperatures.per_s

        def numbers(factors: HeatFactors, growth: FloatArray) -> HeatTerms:
            share = 1.0 / factors.inertia
            return HeatTerms(
                carried=radius * np.sqrt(factors.carried),
                force=widening,
                stiffness=0.0,
                # a weight has factor 1: heat changes a spring's force only
                weight=share * drawn * factors.force,
                viscous=share * viscous * factors.viscous,
                share=share,
                growth=growth,
            )

        return pieces._replace(hot=thermal_pieces(forcing, heat, numbers))

    def _place(self, vertical: float, vertical_rate: float, tilt: float, tilt_rate: float) -> None:
        """Put the wheel at rest in the case at the release angle, given β, β̇, τ and τ̇.

        The lever then has ṡ = 0, hence p = Aα̇ (`lever`).
        """
        machine, (system, omega) = self._machine, self._model
        case_rate, planes = vertical_rate - tilt_rate, self._state['planes']
        planes[:] = 0.0, 0.0, 0.0, 0.0
        if isinstance(system, Hanging):
            angles = machine.release_angle + vertical - tilt, vertical
            for p, row in enumerate((system.to_first, system.to_second)):
                planes['x'][p] = row[0] * angles[0] + row[1] * angles[1]
                rate = row[0] * case_rate + row[1] * vertical_rate
                planes['y'][p] = rate / omega[p]
        elif isinstance(machine, LeverMachine):
            angle = machine.release_angle
            ratio = machine.geometry.side * system.root_j * float(machine.ratio(angle))
            a = (1.0 + system.root_j * ratio) / math.hypot(1.0, ratio)
            planes['x'] = float(machine.arc(angle)) / math.sqrt(machine.inertia)
            planes['y'] = a * case_rate / omega[0]

    def _longest_step(self) -> float:
        """Return the longest step [s] that a swing on land takes without halving."""
        stages = self.order // 2
        angle, fastest = LONGEST_PHASE[stages], max(self._model.omega)
        swing_s = math.tau / min(self._model.omega)
        # The trial does not search for turning points, hence drag must not depend on the swing's
        # direction. Without impulses the pallet stays 0, and recoil with it.
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
            self._place(0.0, 0.0, 0.0, 0.0)
            super()._run(trial, free, tolerance, step_s)
            if self._state['level'] == 0:
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
                'dimensions of wheel and thread. On a moving ship, raise ship.rate',
                time_s,
            )
        if isinstance(self._machine, LeverMachine):
            reached = 'the wheel turned beyond the range of the lever, near a dead point'
        else:
            reached = 'the whole thread is wound up on the wheel'
        return PropagationError(
            f'{reached} (range ±{self._machine.range_rad:.6g} rad). Use a longer thread or lever, '
            'a smaller release angle, a weaker escapement or a calmer sea',
            time_s,
        )

    def _phase(self, rows: NDArray[np.void]) -> tuple[FloatArray, FloatArray]:
        """Return phase and phase rate of s of the lever or u of the thread, within a turn."""
        x, speed, acceleration = (rows[name] for name in ('coordinate', 'speed', 'acceleration'))
        arguments = x, speed, acceleration, self._machine.frequency
        return polar(*arguments), polar_rate(*arguments)


# -----------------------------------------------------------------------------
# Event-to-event steps (`free_end`).

LEAST_ERROR_OF_THREAD, NEAR_ON_THREAD = 1e-8, 0.003
"""Smallest error of a step, and the phase before its end within which it is not repeated [rad].

With 0.01 rad Sully's hung lever errs by 1e-3 s/day. A node 0.0166 rad before the end of half a
swing would be counted if the impulse came earlier.
"""

SHAPE_SHARE, USUAL_PER_RELEASE = 3e-3, 1.2
"""Error of a lever's arc functions over the tolerance, and their reach beyond the release.

The rate then errs by 0.03 of the accuracy. The reach is as in `wells.REACH_PER_RELEASE`.
"""


def thread_takes_free_ends(machine: LeverMachine | HangingMachine) -> bool:
    """Return whether a lever or a swinging thread can step from impulse to impulse.

    It needs an escapement, drag without a kink, and a pull law without joints. If the thread's
    lean is damped, the stages settle too slowly.
    """
    apt = machine.law is None if isinstance(machine, LeverMachine) else not machine.damping
    linear = machine.drag is None or machine.drag.is_linear
    return machine.escapement is not None and linear and apt


class FreeEndThreads(FreeEnds, RealThreads):
    """Propagator of a lever or a swinging thread with event-to-event steps."""

    def __init__(
        self, machine: LeverMachine | HangingMachine, tolerance: float | None, sweeps: int
    ) -> None:
        super().__init__(machine, tolerance, WIDE_SIZE, TO_END, SHAPE_SHARE, USUAL_PER_RELEASE)
        half_swing_s = math.pi / self._model.system.pace
        self._free_end = free_end(sweeps, LEAST_ERROR_OF_THREAD, NEAR_ON_THREAD, half_swing_s)
        self._free = np.zeros((), FREE)
        self._fill_constants()


# -----------------------------------------------------------------------------
# Sully's lever and the swinging thread with slack threads.
#
# The wheel is free: ψ̈ = −(drag and recoil)/I. The lever falls about its fulcrum in the case,
#
#     β̈ = −α̈ − (κ/√j) g_eff cos(β − τ),
#
# in the notation of `lever`. Its thread is slack while β is above β(θ) of the taut thread. The
# weight of a swinging thread falls freely, Ẅ = g_eff (sin β, −cos β) with the direction β of the
# apparent vertical, plus the transverse acceleration (`transverse`). A thread that leaves the cam
# for the weight at W has the lean δ with W · n = r u, u = ψ − δ, n = (cos δ, sin δ) and d = (sin
# δ, −cos δ). Its free length is l₀ − ½ r u², its way W · d − r. It is slack while it is longer
# than its way.
#
# The retension impulse acts along the thread. With ρ = r u and v = −Ẇ · d,
#
#     ψ̇⁺ = (I ψ̇⁻ + m ρ v)/(I + m ρ²),    δ̇⁺ = (Ẇ · n − r ψ̇⁺)/l,
#
# and Ẇ · n does not change. For the lever, with b = dβ/dθ and inertia J = j I,
# θ̇⁺ = (θ̇⁻ + j b β̇)/(1 + j b²).


class _TautNumbers(NamedTuple):
    """The system with a taut thread."""

    taut: Any


class LooseOnWheel(_TautNumbers, WithThread, LooseSystem):
    """Base of systems with a slack thread, which leaves the wheel free."""

    @property
    def on_wheel(self) -> OnWheel:
        """The terms on the wheel other than the thread."""
        on_wheel: OnWheel = self.taut.on_wheel
        return on_wheel

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill the rows of the taut system."""
        self.taut.at_nodes(place, work)

    def strike(
        self, mode: Mode, omega: Omega, at: Inputs, now: Instant, state: RunningState
    ) -> None:
        """Let an impulse act on the wheel alone: ½ I θ̇² grows by its energy."""
        on_wheel, plane = heated_now(self.taut, at).on_wheel, state.planes[0]
        struck = mode.direction * math.sqrt(now.rate * now.rate + on_wheel.energy)
        plane.y += (struck - now.rate) / omega[0]
        plane.y_rest = 0.0


@inlined
def _against(on_wheel: OnWheel, mode: Mode, rate: Numeric, psi_rate: Numeric) -> Numeric:
    """Return −ψ̈ of the free wheel."""
    against = drag_on_wheel(on_wheel, mode, rate)
    if on_wheel.growth is not None:
        against = against + on_wheel.growth * psi_rate
    return against


# -----------------------------------------------------------------------------
# The swinging thread. X of its three planes: ψ, then the weight's position over l₀, across the
# vertical and above the point at which it hangs at rest.


class LooseThreadPose(NamedTuple):
    """A slack thread as it leaves the cam for the weight.

    Attributes:
        delta: lean δ [rad].
        reach: W · d − r, the way to the weight [m].
        free: length free of the cam [m].
    """

    delta: float
    reach: float
    free: float


class LooseThread(LooseOnWheel):
    """A free wheel and a freely falling weight."""

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the disturbances of the three planes."""
        nodes = work.nodes
        w = omega[0] * row_of(work.y, 0)
        rate = w - row_of(nodes.alpha_rate)
        on_wheel = heated_at_nodes(self.taut, work).on_wheel
        against = _against(on_wheel, mode, rate, w)
        store(work.d2, 0, omega[0] * row_of(work.x, 0) - against * (1.0 / omega[0]))
        sine, versine = sine_versine(whole_turns_off(row_of(nodes.vertical)))
        scale = 1.0 / (self.taut.length * omega[1])
        fall, aside = scale * row_of(nodes.gravity), scale * row_of(nodes.transverse)
        cosine = 1.0 - versine
        store(work.d2, 1, omega[1] * row_of(work.x, 1) + (fall * sine + aside * cosine))
        store(work.d2, 2, omega[2] * row_of(work.x, 2) - (fall * cosine - aside * sine))

    def exits(self, mode: Mode, omega: Omega, work: Work) -> Exits:
        """Return whether the thread tautens in the step, or the weight reaches the wheel."""
        gap = margin = filled(row_of(work.x), 0.0)
        for i in range(width(work.fractions)):
            radius = self.taut.radius
            if self.on_wheel.heat is not None:
                radius = lane(row_of(work.nodes.hot), i)
            psi = lane(row_of(work.x, 0), i)
            x, y = lane(row_of(work.x, 1), i), lane(row_of(work.x, 2), i)
            hangs = _hangs_at(self.taut, radius, psi, x, y)
            gap = with_lane(gap, i, _gap(self.taut, hangs))
            margin = with_lane(margin, i, _margin(self.taut, hangs))
        edge, slack = first_below(margin, work), first_below(gap, work)
        return Exits(edge, slack, False, largest(row_of(work.x, 0)), near_zero(gap))

    def coordinate(self, planes: tuple[Plane, ...]) -> float:
        """Return u."""
        psi, x, y = planes[0].x, planes[1].x, planes[2].x
        return psi - _hangs_at(self.taut, self.taut.radius, psi, x, y).delta

    def wheel_angle(self, planes: tuple[Plane, ...], at: Inputs) -> float:
        """Return θ = ψ − α."""
        return planes[0].x - (at.drive.value - at.tilt.value)

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Inputs) -> Instant:
        """Return wheel and weight at an instant."""
        line, tilt, thread = at.drive, at.tilt, heated_now(self.taut, at)
        psi, psi_rate, length = planes[0].x, omega[0] * planes[0].y, thread.length
        rate = psi_rate - (line.rate - tilt.rate)
        psi_bend = -_against(thread.on_wheel, mode, rate, psi_rate)
        hangs = _hangs_at(thread, thread.radius, psi, planes[1].x, planes[2].x)
        aside = transverse(at.gravity, tilt.value)
        sine, cosine = math.sin(line.value), math.cos(line.value)
        across_bend = at.gravity * sine + aside * cosine
        up_bend = aside * sine - at.gravity * cosine
        across_rate = length * omega[1] * planes[1].y
        up_rate = length * omega[2] * planes[2].y
        u, (sine, cosine) = psi - hangs.delta, (math.sin(hangs.delta), math.cos(hangs.delta))
        # along d and n
        along_rate = across_rate * sine - up_rate * cosine
        turn_rate = across_rate * cosine + up_rate * sine
        turn_bend = across_bend * cosine + up_bend * sine
        delta_rate = (turn_rate - thread.radius * psi_rate) / hangs.reach
        reach_rate = along_rate + thread.radius * u * delta_rate
        delta_bend = turn_bend - thread.radius * psi_bend - delta_rate * along_rate
        delta_bend = (delta_bend - reach_rate * delta_rate) / hangs.reach
        return Instant(
            angle=psi - (line.value - tilt.value),
            rate=rate,
            bend=psi_bend - (line.bend - tilt.bend),
            tension=_gap(thread, hangs),
            margin=_margin(thread, hangs),
            torque=0.0,
            coordinate=u,
            speed=psi_rate - delta_rate,
            acceleration=psi_bend - delta_bend,
            drift=(
                Plane(psi_rate, psi_bend),
                Plane(across_rate / length, across_bend / length),
                Plane(up_rate / length, up_bend / length),
            ),
        )

    def let_go(self, taut: Hanging, omega: Omega, at: Inputs, now: Instant, free: Any) -> None:
        """Start wheel and weight with the motion of the taut thread."""
        alpha, alpha_rate = at.drive.value - at.tilt.value, at.drive.rate - at.tilt.rate
        thread, u = heated_now(taut, at), now.coordinate
        psi, psi_rate = now.angle + alpha, now.rate + alpha_rate
        delta, delta_rate = psi - u, psi_rate - now.speed
        radius, length = thread.radius, thread.length
        span = length - 0.5 * radius * u * u
        sine, cosine = math.sin(delta), math.cos(delta)
        turn_rate, along_rate = (radius * psi_rate + span * delta_rate, -radius * u * psi_rate)
        planes = free.planes
        planes[0].x, planes[0].y = psi, psi_rate / omega[0]
        # W = r u n + (r + l) d, with the height counted from −(r + l₀) to avoid cancellation
        low = math.sin(0.5 * delta)
        planes[1].x = (radius * u * cosine + (radius + span) * sine) / length
        raised = radius * u * sine + 2.0 * (radius + span) * low * low + (length - span)
        planes[2].x = raised / length
        planes[1].y = (turn_rate * cosine + along_rate * sine) / (length * omega[1])
        planes[2].y = (turn_rate * sine - along_rate * cosine) / (length * omega[2])
        for p in range(3):
            planes[p].x_rest = planes[p].y_rest = 0.0

    def tauten(
        self, taut: Hanging, omega: Omega, taut_omega: Omega, at: Inputs, free: Any, state: Any
    ) -> Retension:
        """Share the momentum along the thread. Across it the weight keeps its velocity."""
        thread, planes = heated_now(taut, at), planes_of(omega, free.planes)
        psi, psi_rate = planes[0].x, omega[0] * planes[0].y
        hangs = _hangs_at(thread, thread.radius, psi, planes[1].x, planes[2].x)
        across_rate = thread.length * omega[1] * planes[1].y
        up_rate = thread.length * omega[2] * planes[2].y
        u, (sine, cosine) = psi - hangs.delta, (math.sin(hangs.delta), math.cos(hangs.delta))
        lifted = up_rate * cosine - across_rate * sine
        turn_rate = across_rate * cosine + up_rate * sine
        arm, mu = thread.radius * u, thread.ratio / thread.radius
        mass, gap_rate = 1.0 + mu * arm * arm, arm * psi_rate - lifted
        psi_rate = (psi_rate + mu * arm * lifted) / mass
        delta_rate = (turn_rate - thread.radius * psi_rate) / hangs.free
        to_first, second = taut.to_first, taut.to_second
        state.planes[0].x = to_first[0] * psi + to_first[1] * hangs.delta
        state.planes[1].x = second[0] * psi + second[1] * hangs.delta
        state.planes[0].y = (to_first[0] * psi_rate + to_first[1] * delta_rate) / taut_omega[0]
        state.planes[1].y = (second[0] * psi_rate + second[1] * delta_rate) / taut_omega[1]
        for p in range(2):
            state.planes[p].x_rest = state.planes[p].y_rest = 0.0
        rate = psi_rate - (at.drive.rate - at.tilt.rate)
        return Retension(rate, psi_rate - delta_rate, mu * gap_rate * gap_rate / mass)


@compiled
def _hangs_at(thread: Hanging, radius: float, psi: float, x: float, y: float) -> LooseThreadPose:
    """Return the slack thread's pose, from ψ and X of the weight's planes."""
    length = thread.length
    across, up = length * x, length * y - (radius + length)
    delta, along = math.atan2(across, -up), 0.0
    for _ in range(MOST_ITERATIONS):
        sine, cosine = math.sin(delta), math.cos(delta)
        along = across * sine - up * cosine
        wrong = across * cosine + up * sine - radius * (psi - delta)
        change = wrong / (along - radius)
        delta += change
        if abs(change) <= SETTLED:
            break
    sine, cosine = math.sin(delta), math.cos(delta)
    along = across * sine - up * cosine
    u = psi - delta
    return LooseThreadPose(delta, along - radius, length - 0.5 * radius * u * u)


@inlined
def _gap(thread: Hanging, hangs: LooseThreadPose) -> float:
    """Return the excess of the thread's length over its way, over l₀."""
    return (hangs.free - hangs.reach) / thread.length + rounding_of(hangs.delta, 1.0)


@inlined
def _margin(thread: Hanging, hangs: LooseThreadPose) -> float:
    """Return the smaller of the thread's length and its way, minus their lower limit [m]."""
    return min(hangs.free, hangs.reach) - thread.least


# -----------------------------------------------------------------------------
# Sully's lever. X = θ and ωY = ψ̇ of the wheel, X = √j β and ωY = √j (β̇ + α̇) of the lever. β is
# the angle of the series, which is mirrored if the fulcrum is to port.


class TautLever(NamedTuple):
    """The taut lever at an angle of the wheel: s, n, w, χ′, and β of the series."""

    s: float
    n: float
    w: float
    chi_slope: float
    beta: float


class LooseLever(LooseOnWheel):
    """A free wheel and a falling lever."""

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the disturbances of both planes."""
        nodes = work.nodes
        root_j, alpha_rate = self.taut.root_j, row_of(nodes.alpha_rate)
        w, taut = omega[0] * row_of(work.y, 0), heated_at_nodes(self.taut, work)
        kappa = taut.kappa + 0.0 * alpha_rate
        against = _against(taut.on_wheel, mode, w - alpha_rate, w)
        store(work.d1, 0, -alpha_rate)
        store(work.d2, 0, omega[0] * row_of(work.x, 0) - against * (1.0 / omega[0]))
        height = row_of(work.x, 1)
        sine, versine = sine_versine(whole_turns_off(height * (1.0 / root_j)))
        gravity = row_of(nodes.g_up) * (1.0 - versine) + row_of(nodes.g_across) * sine
        store(work.d1, 1, -(root_j * alpha_rate))
        store(work.d2, 1, omega[1] * height - kappa * gravity * (1.0 / omega[1]))

    def exits(self, mode: Mode, omega: Omega, work: Work) -> Exits:
        """Return whether the thread tautens in the step, or the geometry ends."""
        gap = margin = filled(row_of(work.x), 0.0)
        for i in range(width(work.fractions)):
            pose = _pose_at(self.taut, lane(row_of(work.x, 0), i))
            height = lane(row_of(work.x, 1), i)
            gap = with_lane(gap, i, _above(self.taut, pose, height))
            margin = with_lane(margin, i, _within(self.taut, pose, height))
        edge, slack = first_below(margin, work), first_below(gap, work)
        return Exits(edge, slack, False, largest(row_of(work.x, 0)), near_zero(gap))

    def wheel_angle(self, planes: tuple[Plane, ...], at: Inputs) -> float:
        """Return θ."""
        return planes[0].x

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Inputs) -> Instant:
        """Return wheel and lever at an instant."""
        tilt, lever, theta = at.tilt, heated_now(self.taut, at), planes[0].x
        alpha_rate, alpha_bend = at.drive.rate - tilt.rate, at.drive.bend - tilt.bend
        psi_rate, height = omega[0] * planes[0].y, planes[1].x
        rate, pose = psi_rate - alpha_rate, _pose_at(lever, theta)
        psi_bend = -_against(lever.on_wheel, mode, rate, psi_rate)
        bend, speed = psi_bend - alpha_bend, rate / pose.n
        lean = height / lever.root_j - tilt.value
        gravity = at.gravity * math.cos(lean) + transverse(at.gravity, tilt.value) * math.sin(lean)
        fall = lever.kappa * gravity
        height_rate = omega[1] * planes[1].y - lever.root_j * alpha_rate
        return Instant(
            angle=theta,
            rate=rate,
            bend=bend,
            tension=_above(lever, pose, height),
            margin=_within(lever, pose, height),
            torque=0.0,
            coordinate=pose.s,
            speed=speed,
            acceleration=(bend + pose.w * pose.chi_slope * speed * speed) / pose.n,
            drift=(Plane(rate, psi_bend), Plane(height_rate, -fall)),
        )

    def let_go(self, taut: SullyLever, omega: Omega, at: Inputs, now: Instant, free: Any) -> None:
        """Start wheel and lever with the motion of the taut thread."""
        alpha_rate, planes, root_j = at.drive.rate - at.tilt.rate, free.planes, taut.root_j
        arc, angle = lever_on_arc(taut.shape, now.coordinate)
        planes[0].x, planes[0].y = angle, (now.rate + alpha_rate) / omega[0]
        planes[1].x = root_j * math.atan2(arc.sine, arc.cosine)
        planes[1].y = (arc.w * now.speed + root_j * alpha_rate) / omega[1]
        for p in range(2):
            planes[p].x_rest = planes[p].y_rest = 0.0

    def tauten(
        self, taut: SullyLever, omega: Omega, taut_omega: Omega, at: Inputs, free: Any, state: Any
    ) -> Retension:
        """Share the momentum along the thread: ṡ⁺ = n θ̇ + w √j β̇."""
        planes, root_j = planes_of(omega, free.planes), taut.root_j
        alpha_rate, plane = at.drive.rate - at.tilt.rate, state.planes[0]
        pose = _pose_at(taut, planes[0].x)
        rate = omega[0] * planes[0].y - alpha_rate
        height_rate = omega[1] * planes[1].y - root_j * alpha_rate
        speed, gap = pose.n * rate + pose.w * height_rate, pose.w * rate - pose.n * height_rate
        a = pose.n + root_j * pose.w
        plane.x, plane.y = pose.s, (speed + a * alpha_rate) / taut_omega[0]
        plane.x_rest = plane.y_rest = 0.0
        return Retension(pose.n * speed, speed, gap * gap)


@compiled
def _pose_at(lever: SullyLever, theta: float) -> TautLever:
    """Return the taut lever at θ, or at the nearest end of the geometry."""
    full = lever.shape.full
    low, high = full.middle - full.half_width, full.middle + full.half_width
    s = min(max(theta, low), high)
    for _ in range(MOST_ITERATIONS):
        arc, angle = lever_on_arc(lever.shape, s)
        # n = dθ/ds is at most 1, hence the step in s is never too short
        s_next = min(max(s + (theta - angle) / arc.n, low), high)
        change = abs(s_next - s)
        s = s_next
        if change <= SETTLED:
            break
    arc, _ = lever_on_arc(lever.shape, s)
    return TautLever(s, arc.n, arc.w, arc.chi_slope, math.atan2(arc.sine, arc.cosine))


@inlined
def _above(lever: SullyLever, pose: TautLever, height: float) -> float:
    """Return the lever's height above the taut thread's, times √j."""
    above = height - lever.root_j * pose.beta
    return (above if lever.mirrored is None else -above) + rounding_of(pose.s, height)


@inlined
def _within(lever: SullyLever, pose: TautLever, height: float) -> float:
    """Return the smaller margin: to the end of the arc, or to a lever thrown over."""
    full = lever.shape.full
    x = (pose.s - full.middle) / full.half_width
    tilt_margin = 0.5 * math.pi - abs(height / lever.root_j - pose.beta)
    return min(1.0 - x * x, tilt_margin)
