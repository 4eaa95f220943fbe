"""The propagator of a wheel, and the wheel with a slack thread.

η is the height of the weight above its rest along the neutral line, and h(ϑ) its height on a taut
thread:

    ψ̈ = −(drag and recoil)/I,    η̈ = −(m g_eff + κη)/m,    slack while η > h(ϑ).

The thread tautens at η = h. With the lever arm t = h′ and v = η̇,

    ϑ̇⁺ = (I ϑ̇⁻ + m t v)/(I + m t²),    energy loss ½ I m (t ϑ̇⁻ − v)²/(I + m t²).

A massless weight is slack while apparent gravity points out of the top of the case, and loses no
energy. A force or a spring without mass never goes slack.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.machines import Machine
from tauto_core.machines.drags import Drag
from tauto_core.machines.heat import HeatFactors
from tauto_core.motion import stepping
from tauto_core.motion.events import SPARE, first_holds, is_due
from tauto_core.motion.forcing import (
    Forcing,
    Motion,
    edge_reached,
    phase_rate,
    released_beyond,
    thread_slack,
    within_turn,
)
from tauto_core.motion.gauss_step import (
    PART_STEP,
    Mode,
    Omega,
    Step,
    Work,
    collocate,
    fill_integrals,
    inside,
)
from tauto_core.motion.lanes import SIZE, larger, largest, row_of, store, width
from tauto_core.motion.slack import ROUNDING, LooseSystem, Retension, SlackThread, rounding_of
from tauto_core.motion.stepping import Model, thermal_pieces, tolerance_of
from tauto_core.motion.system import (
    NOWHERE,
    Exits,
    ForcingPieces,
    HeatTerms,
    Inputs,
    Instant,
    Plane,
    RunningState,
    SteppedRun,
    StepPlace,
    first_below,
    heated_at_nodes,
    heated_now,
    mode_of,
    near_zero,
    outside_at,
    planes_of,
)
from tauto_core.motion.wells import (
    Impulse,
    PerInertia,
    UnbalancedWheel,
    given_energy,
    kick,
    lever_arm,
    pull_of,
    resistance,
    term,
    unbalanced,
)
from tauto_core.motion.wheel import (
    THERMAL_NODES,
    WHEEL_NODES,
    InputChannels,
    Wheel,
    coordinate_and_momentum,
    error_factor,
    lasting_shape,
    longest_step,
    reference_frequency,
    row_or_zero,
    stages_of,
)
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import PropagationError

ABOUT_TO_TAUTEN = 1e-11
"""Gap up to which friction does not hold a wheel, since the thread tautens at once [rad]."""


class _FreeNumbers(NamedTuple):
    """The fields of `FreeWheel`.

    Attributes:
        wheel: the wheel with a taut thread.
        bare: the wheel without its thread.
        scale: √(m/I) at the reference temperature [1/m], or `None` for a massless weight.
    """

    wheel: Wheel
    bare: Wheel
    scale: float | None


class FreeWheel(_FreeNumbers, LooseSystem):
    """Wheel and weight: X = ϑ and ωY = ψ̇ of the one, X = scale·η and ωY = scale·η̇ of the other."""

    @property
    def impulse(self) -> float:
        """Angle of the impulse [rad]."""
        return self.wheel.impulse

    @property
    def pace(self) -> float:
        """Frequency of the wheel's swing with a taut thread [rad/s]."""
        return self.wheel.pace

    @property
    def feels_impulse(self) -> bool:
        """Whether an escapement pushes the wheel."""
        return self.wheel.feels_impulse

    @property
    def recoils(self) -> bool:
        """Whether a resting tooth pushes the wheel back."""
        return self.wheel.recoils

    @property
    def drag_has_kink(self) -> bool:
        """Whether the drag has a kink at the turning points."""
        return self.wheel.drag_has_kink

    @property
    def sticks(self) -> bool:
        """Whether friction may hold the wheel."""
        return self.wheel.sticks

    @property
    def feels_tilt(self) -> bool:
        """Whether θ or θ̇ acts within a span."""
        return self.wheel.feels_tilt

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill the forcing of the wheel."""
        self.wheel.at_nodes(place, work)

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the disturbances of the planes' rotation."""
        wheel = heated_at_nodes(self.wheel, work)
        channels, nodes, per_inertia = self.wheel.channels, work.nodes, wheel.per_inertia
        x, w = row_of(work.x, 0), omega[0] * row_of(work.y, 0)
        line_rate = row_or_zero(channels.line, nodes.line_rate)
        gravity = row_or_zero(channels.gravity, nodes.gravity)
        rate = w - line_rate + row_or_zero(channels.tilt, nodes.tilt_rate)
        against = resistance(per_inertia, rate, mode)
        against = against + unbalanced(
            per_inertia, x - row_or_zero(channels.lean, nodes.lean), gravity
        )
        if per_inertia.growth is not None:
            against = against + per_inertia.growth * w
        store(work.d1, 0, 0.0 * x - line_rate)
        # without a thread ωX cancels the rotation of the plane
        store(work.d2, 0, omega[0] * x - against * (1.0 / omega[0]))
        if self.scale is not None and per_inertia.carried is not None:
            height = row_of(work.x, 1)
            fall = pull_of(per_inertia, height * (1.0 / self.scale), gravity)
            fall = fall * (self.scale / per_inertia.carried)
            store(work.d2, 1, omega[1] * height - fall * (1.0 / omega[1]))

    def exits(self, mode: Mode, omega: Omega, work: Work) -> Exits:
        """Return whether the step leaves the cam, or the thread tautens in it."""
        wheel, channels = heated_at_nodes(self.wheel, work), self.wheel.channels
        x = row_of(work.x, 0)
        reach, edge = largest(x), NOWHERE
        if reach > wheel.range:
            edge = first_below(wheel.range - larger(x, x), work)
        lift = lever_arm(wheel.lever, 1.0, larger(x, x)).lift
        if self.scale is None:
            # a massless weight has no height: the thread is slack while its pull is negative
            gravity = row_or_zero(channels.gravity, work.nodes.gravity)
            gap = 0.0 * x - pull_of(wheel.per_inertia, lift, gravity) + self.pull_rounding
        else:
            height = row_of(work.x, 1)
            gap = height - self.scale * lift + rounding_of(reach, largest(height))
        return Exits(edge, first_below(gap, work), False, reach, near_zero(gap))

    @property
    def pull_rounding(self) -> float:
        """Rounding error of the pull of a massless weight, over I."""
        return ROUNDING * term(self.wheel.per_inertia.weight, self.wheel.gravity)

    def wheel_angle(self, planes: tuple[Plane, ...], at: Inputs) -> float:
        """Return θ = ϑ + τ."""
        return planes[0].x + at.tilt.value

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Inputs) -> Instant:
        """Return the wheel at an instant, with the gap as its tension."""
        wheel, line, tilt = heated_now(self.wheel, at), at.drive, at.tilt
        per_inertia, q, w = wheel.per_inertia, planes[0].x, omega[0] * planes[0].y
        speed = w - line.rate
        rate = speed + tilt.rate
        against = resistance(per_inertia, rate, mode)
        against = against + unbalanced(per_inertia, q - at.lean, at.gravity)
        if per_inertia.growth is not None:
            against = against + per_inertia.growth * w
        acceleration = -against - line.bend
        gap = self.gap_at(q, planes, at)
        drift: tuple[Plane, ...] = (Plane(speed, -against),)
        if self.scale is not None and per_inertia.carried is not None:
            fall = pull_of(per_inertia, planes[1].x / self.scale, at.gravity)
            fall = fall * (self.scale / per_inertia.carried)
            drift = (*drift, Plane(omega[1] * planes[1].y, -fall))
        return Instant(
            angle=q + tilt.value,
            rate=rate,
            bend=acceleration + tilt.bend,
            tension=gap,
            margin=wheel.range - abs(q),
            torque=0.0,
            coordinate=q,
            speed=speed,
            acceleration=acceleration,
            drift=drift,
        )

    def strike(
        self, mode: Mode, omega: Omega, at: Inputs, now: Instant, state: RunningState
    ) -> None:
        """Apply an impulse to the wheel only."""
        impulse, plane = heated_now(self.wheel, at).per_inertia.impulse, state.planes[0]
        if impulse is None:
            return
        energy = given_energy(impulse, state.given)
        plane.y += kick(energy, now.rate, mode.direction) / omega[0]
        plane.y_rest = 0.0

    def set_off(self, omega: Omega, angle: float, at: Inputs, state: RunningState) -> None:
        """Put the wheel at rest at θ = angle: held by friction, or about to move.

        Friction does not hold it if the thread is about to tauten.
        """
        self.bare.set_off(omega, angle, at, state)
        gap = self.gap_at(angle - at.tilt.value, planes_of(omega, state.planes), at)
        if state.held and not gap > ABOUT_TO_TAUTEN:
            state.held = False
            state.armed = is_due(self, state, float(state.direction), angle)

    def gap_at(self, q: float, planes: tuple[Plane, ...], at: Inputs) -> float:
        """Return the gap of the thread at ϑ = q, with the weight of a state."""
        lift = lever_arm(self.wheel.lever, 1.0, abs(q)).lift
        if self.scale is None:
            pull = pull_of(heated_now(self.wheel, at).per_inertia, lift, at.gravity)
            return self.pull_rounding - pull
        return planes[1].x - self.scale * lift + rounding_of(q, planes[1].x)

    def move_with_case(self, run: SteppedRun, place: StepPlace) -> float:
        """Move the held wheel with the case while the weight falls.

        Returns the fraction at which the wheel breaks loose or the thread tautens, or 1.
        """
        omega, state, work = run.omega, run.state, run.work
        mode, angle = mode_of(state), state.held_angle
        h, probes = place.size * place.length, 2 * width(work.fractions)
        self.at_nodes(place, work)
        collocate(
            Step(HeldWheel(self), mode, omega, h, PART_STEP, state.planes, work),
            run.tolerance.settled,
        )
        fill_integrals(omega, work)
        reached = min(first_holds(WatchHeld(self, run, place), probes), 1.0)
        at = outside_at(place.terms, place.begin + reached * place.size, work)
        if self.scale is not None:
            x, y = inside(omega, 1, h, reached, state.planes, work)
            weight = state.planes[1]
            weight.x, weight.y, weight.x_rest, weight.y_rest = x, y, 0.0, 0.0
        if reached < 1.0:
            self.set_off(omega, angle, at, state)
        else:
            self.bare.rest_at(omega, angle, at, state)
        return reached

    def let_go(self, taut: Wheel, omega: Omega, at: Inputs, now: Instant, free: Any) -> None:
        """Start wheel and weight from the motion on the taut thread."""
        q, wheel_plane = now.coordinate, free.planes[0]
        wheel_plane.x, wheel_plane.y = q, (now.speed + at.drive.rate) / omega[0]
        wheel_plane.x_rest = wheel_plane.y_rest = 0.0
        if self.scale is not None:
            arm = lever_arm(taut.lever, 1.0, abs(q))
            second = free.planes[1]
            # the weight leaves with the speed of the thread, η̇ = t ϑ̇
            second.x = self.scale * arm.lift
            second.y = self.scale * math.copysign(arm.t, q) * now.speed / omega[1]
            second.x_rest = second.y_rest = 0.0

    def tauten(
        self, taut: Wheel, omega: Omega, taut_omega: Omega, at: Inputs, free: Any, state: Any
    ) -> Retension:
        """Exchange momentum along the thread."""
        planes, wheel = planes_of(omega, free.planes), heated_now(taut, at)
        q, speed = planes[0].x, omega[0] * planes[0].y - at.drive.rate
        t = math.copysign(lever_arm(wheel.lever, 1.0, abs(q)).t, q)
        lost, mu = 0.0, wheel.per_inertia.carried
        if self.scale is not None and mu is not None:
            height_rate = omega[1] * planes[1].y / self.scale
            gap_rate, mass = t * speed - height_rate, 1.0 + mu * (t * t)
            lost = mu * (gap_rate * gap_rate) / mass
            speed = (speed + mu * t * height_rate) / mass
        state.side = -1 if q < 0.0 else 1
        plane = state.planes[0]
        x, w = coordinate_and_momentum(wheel, q, speed, at.drive.rate, float(state.side))
        plane.x, plane.y, plane.x_rest, plane.y_rest = x, w / taut_omega[0], 0.0, 0.0
        return Retension(speed + at.tilt.rate, speed, lost)


class _HeldNumbers(NamedTuple):
    """The field of `HeldWheel`."""

    free: FreeWheel


class HeldWheel(_HeldNumbers):
    """A weight on a slack thread of a wheel held by friction."""

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the disturbances of the planes' rotation."""
        self.free.disturb(mode, omega, work)
        store(work.d1, 0, -(omega[0] * row_of(work.y, 0)))
        store(work.d2, 0, omega[0] * row_of(work.x, 0))


class WatchHeld(NamedTuple):
    """The condition that the wheel breaks loose or the thread tautens."""

    free: FreeWheel
    run: SteppedRun
    place: StepPlace

    def holds(self, xi: float) -> bool:
        """Return whether the condition holds at a fraction of the step."""
        free, run, place = self.free, self.run, self.place
        state, work, angle = run.state, run.work, run.state.held_angle
        at = outside_at(place.terms, place.begin + xi * place.size, work)
        per_inertia = heated_now(free.wheel, at).per_inertia
        lift = lever_arm(free.wheel.lever, 1.0, abs(angle - at.tilt.value)).lift
        if free.scale is None:
            gap = free.pull_rounding - pull_of(per_inertia, lift, at.gravity)
        else:
            height, _ = inside(run.omega, 1, place.size * place.length, xi, state.planes, work)
            gap = height - free.scale * lift + rounding_of(angle, height)
        return free.bare.breaks_loose(mode_of(state), angle, at) or not gap > 0.0


# -----------------------------------------------------------------------------
# The general propagator of a wheel.


class Collocation(SlackThread):
    """Propagator of any wheel by Gauss collocation in the rotating frame.

    Without a number of `stages`, `stages_of` chooses it by the machine.
    """

    def __init__(
        self, machine: Machine, tolerance: float | None = None, stages: int | None = None
    ) -> None:
        self._machine = machine
        self._hot = hot = machine.heat.acts
        self._omega = reference_frequency(machine)
        self._shape = lasting_shape(machine)
        stages = stages_of(machine, self._shape) if stages is None else stages
        factor = error_factor(machine, self._shape, stages)
        # steps of twice the length err 2^2S times as much with S stages, or 2^8 times if the cam
        # has joints; a factor of two is a reserve
        coarsen = 2.0 ** -((2 * stages if factor else 8) + 1)
        allowed = tolerance_of(tolerance, factor, coarsen)
        rows, columns = (THERMAL_NODES, 2 * SIZE) if hot else (WHEEL_NODES, SIZE)
        super().__init__(machine, 1, rows, stages, allowed, columns)
        self.longest_step_s = longest_step(
            machine, self._shape, self._omega, factor=factor, tolerance=allowed.step
        )

    def steps_in(self, length_s: float) -> int:
        """Return the number of steps in a piece of forcing, or 1 if steps end at events."""
        if self.order == 2 * SIZE or self._machine.escapement is not None:
            return 1
        return max(1, math.ceil(length_s / self.longest_step_s - SPARE))

    def _model_of(self, forcing: Forcing) -> Model:
        """Return the wheel with its parameters per inertia."""
        machine = self._machine
        inertia = machine.inertia

        def share(value: float) -> float | None:
            # None removes a zero term from the compiled code
            return value / inertia if value else None

        force, weight = machine.force, machine.pulling_mass
        if forcing.gravity is None:
            force, weight = force + weight * machine.gravity, 0.0
        drag, escapement = machine.drag or Drag(), machine.escapement
        imbalance = None
        if machine.imbalance is not None:
            off = machine.imbalance.moment / machine.inertia
            at_rest = off * machine.gravity if forcing.gravity is None else None
            swung = None if forcing.gravity is None else off
            imbalance = UnbalancedWheel(at_rest, swung, machine.imbalance.direction)
        per_inertia = PerInertia(
            carried=share(machine.carried_mass),
            force=share(force),
            stiffness=share(machine.stiffness),
            weight=share(weight),
            viscous=share(drag.viscous),
            quadratic=share(drag.quadratic),
            coulomb=share(drag.coulomb),
            impulse=Impulse(2.0 * escapement.energy / inertia, escapement.ebb)
            if escapement
            else None,
            recoil=share(escapement.recoil) if escapement else None,
            law=drag.law(inertia),
            imbalance=imbalance,
        )
        channels = forcing.neutral, forcing.tilt, forcing.gravity, forcing.lean, self._hot or None
        wheel = Wheel(
            per_inertia,
            machine.cam.lever,
            self._shape,
            InputChannels(*(None if channel is None else True for channel in channels)),
            impulse=escapement.angle if escapement else math.inf,
            pace=self._omega,
            range=machine.cam.range_rad,
            gravity=machine.gravity,
        )
        return Model(wheel, (self._omega,))

    def _loose_model(self, taut: Model) -> Model | None:
        """Return wheel and weight with a slack thread, or `None` without a weight."""
        wheel, omega = taut
        if not wheel.has_weight:
            return None
        carried = wheel.per_inertia.carried
        terms = dict.fromkeys(('carried', 'force', 'stiffness', 'weight'))
        bare = wheel._replace(per_inertia=wheel.per_inertia._replace(**terms), shape=None)
        if carried is None:
            return Model(FreeWheel(wheel, bare, None), (omega[0],))
        return Model(FreeWheel(wheel, bare, math.sqrt(carried)), (omega[0], omega[0]))

    def _outside(self, forcing: Forcing) -> ForcingPieces:
        """Return the pieces of the forcing, with thermal parameters if heat acts."""
        pieces = super()._outside(forcing)
        if not self._hot:
            return pieces
        machine = self._machine

        def numbers(factors: HeatFactors, growth: FloatArray) -> HeatTerms:
            share = 1.0 / factors.inertia
            per_inertia = share / machine.inertia
            force, weight = machine.force * factors.force, machine.pulling_mass * factors.weight
            if forcing.gravity is None:
                force = force + weight * machine.gravity
            viscous = machine.drag.viscous if machine.drag else 0.0
            return HeatTerms(
                per_inertia * machine.carried_mass * factors.carried,
                per_inertia * force,
                per_inertia * machine.stiffness * factors.stiffness,
                per_inertia * weight,
                per_inertia * viscous * factors.viscous,
                share,
                growth,
            )

        return pieces._replace(hot=thermal_pieces(forcing, machine.heat, numbers))

    def release(self, forcing: Forcing) -> Motion:
        """Release the wheel at rest in the case at the beginning of the first span.

        Raises PropagationError if the roll at the start puts the cam angle beyond the cam.
        """
        row, _ = self._released(forcing)
        angle = float(row['coordinate'][0])
        if not abs(angle) <= self._machine.cam.range_rad:
            raise released_beyond(self._machine, angle)
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

    def _phase(self, rows: NDArray[np.void]) -> tuple[FloatArray, FloatArray]:
        angle, rate, bend = (rows[name] for name in ('coordinate', 'speed', 'acceleration'))
        arguments = self._machine, angle, rate, bend
        return within_turn(*arguments), phase_rate(*arguments)
