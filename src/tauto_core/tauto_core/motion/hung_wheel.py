"""The wheel and the case that it turns: a force or a spring anchored in a hung case with mass.

The wheel's torque acts on the case the other way round (G5.4 in suspension.md): with a = −ψ̈ all
that the thread, the drag and the resting teeth do to the wheel over I, the case of mass M feels
I a. Where heat changes the wheel, a = −(Iψ̇)˙/I. In the first plane X = ϑ = θ and ωY = ψ̇, as in
`wheel`, with γ̇ = φ̇; the others are those of the case, of its tilt in gimbals and of its modes on
an axle.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from tauto_core.kernels import inlined
from tauto_core.machines import Machine
from tauto_core.machines.axle_pendulum import modes
from tauto_core.machines.trochlea import CaseOfMass
from tauto_core.motion import stepping
from tauto_core.motion.events import BEYOND, is_due, phase_to
from tauto_core.motion.forcing import Forcing, lifted_off, turned_over
from tauto_core.motion.gauss_step import Omega, Work
from tauto_core.motion.gimbals import GIMBALS_NODES, GimbalsLaw, gimbals_bend
from tauto_core.motion.lanes import (
    SIZE,
    Numeric,
    fma,
    larger,
    largest,
    lowest,
    row_of,
    store,
)
from tauto_core.motion.slack import SlackThread
from tauto_core.motion.stepping import ERROR_OF_LAST_STRONG, Moved, tolerance_of
from tauto_core.motion.suspended_case import OVER, AxleNumbers, contact_force
from tauto_core.motion.system import (
    APPARENT_GRAVITY,
    DRIVE,
    NOWHERE,
    TILT_RATE,
    Beyond,
    HotNumbers,
    Instant,
    Mode,
    Outside,
    Plane,
    RunningState,
    StepPlace,
    System,
    column_at,
    fill_hot,
    first_below,
    mode_of,
    nodes_of,
    planes_of,
)
from tauto_core.motion.wells import (
    PerInertia,
    excess,
    given_energy,
    kick,
    lever_arm,
    pull_of,
    resistance,
)
from tauto_core.motion.wheel import (
    SURELY_WITHIN,
    Collocation,
    FeltChannels,
    Wheel,
    WithWheel,
    wheel_at_nodes,
    wheel_now,
)
from tauto_core.scene.errors import PropagationError

LONGEST_PHASE_RAD = 3.0
"""Longest step, as the angle by which the fastest plane turns [rad]."""


class CaseState(NamedTuple):
    """The case at an instant or at the nodes: φ, φ̇, θ of its contact (0 in gimbals), and θ̇."""

    phi: Numeric
    phi_rate: Numeric
    theta: Numeric
    theta_rate: Numeric


class CaseBends(NamedTuple):
    """Its φ̈, q̈ of its planes, and N/M of its contact (1 in gimbals)."""

    phi_bend: Numeric
    first: Numeric
    second: Numeric
    contact: Numeric


class _HungNumbers(NamedTuple):
    """Wheel and case.

    Attributes:
        wheel: the wheel, of whose channels none is felt.
        case: the law that moves the case.
        share: I/M [m2].
        squared: k² + l² in gimbals, k² on an axle [m2].
        moves: whether the ship moves; None if not, which is known when compiling.
        gravity: g where she lies still [m/s2].
    """

    wheel: Wheel
    case: GimbalsLaw | AxleNumbers
    share: float
    squared: float
    moves: bool | None
    gravity: float


class HungWheel(_HungNumbers, WithWheel, System):
    """Wheel and case as `system.System`."""

    @property
    def kinked(self) -> bool:
        """Whether the cam has a kink."""
        return self.wheel.kinked

    @property
    def has_weight(self) -> bool:
        """Whether an axle may lift off."""
        return isinstance(self.case, AxleNumbers)

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill ÿ, g + z̈ and ρ̇."""
        x, nodes = nodes_of(place, work), work.nodes
        store(nodes.sway, 0, column_at(DRIVE, place.terms, x, work))
        lift = column_at(APPARENT_GRAVITY, place.terms, x, work)
        store(nodes.lift, 0, 0.0 * x + self.gravity if self.moves is None else lift)
        store(nodes.roll_rate, 0, -column_at(TILT_RATE, place.terms, x, work))
        if self.wheel.felt.heat is not None:
            fill_hot(x, work)

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the disturbances of the planes."""
        wheel, nodes = wheel_at_nodes(self.wheel, work), work.nodes
        x, w = row_of(work.x, 0), omega[0] * row_of(work.y, 0)
        case = case_at_nodes(self, omega, work)
        t, _, drawn = lever_arm(wheel.lever, mode.side, x)
        pull = pull_of(wheel.per_inertia, drawn, 0.0)
        against = resistance(wheel.per_inertia, w - case.phi_rate, mode)
        pushed = excess(wheel.lever, x, t, pull, omega[0] * omega[0]) - against
        if wheel.per_inertia.growth is not None:
            pushed = pushed - wheel.per_inertia.growth * w
        store(work.d1, 0, -case.phi_rate)
        store(work.d2, 0, pushed * (1.0 / omega[0]))
        sway, lift = row_of(nodes.sway), row_of(nodes.lift)
        turning = on_case(wheel.per_inertia, pull * t + against)
        bends = case_bends(self, case, turning, sway, lift, row_of(nodes.roll_rate))
        # Ẏ = −ωX + d₂ and q̈ = ωẎ, so d₂ = q̈/ω + ωX
        store(work.d2, 1, fma(bends.first, 1.0 / omega[1], omega[1] * row_of(work.x, 1)))
        if isinstance(self.case, AxleNumbers):
            store(work.d2, 2, fma(bends.second, 1.0 / omega[2], omega[2] * row_of(work.x, 2)))

    def beyond(self, mode: Mode, omega: Omega, work: Work) -> Beyond:
        """Return whether the wheel leaves the cam, the case turns over, or its axle lifts off."""
        wheel, nodes = wheel_at_nodes(self.wheel, work), work.nodes
        x = row_of(work.x, 0)
        reach, case = largest(x), case_at_nodes(self, omega, work)
        edge = first_below(wheel.range - larger(x, x), work) if reach > wheel.range else NOWHERE
        over = larger(case.phi - case.theta, case.theta)
        edge, slack = min(edge, first_below(OVER - over, work)), NOWHERE
        if isinstance(self.case, AxleNumbers):
            rate = omega[0] * row_of(work.y, 0) - case.phi_rate
            t, _, drawn = lever_arm(wheel.lever, mode.side, x)
            turning = pull_of(wheel.per_inertia, drawn, 0.0) * t
            turning = on_case(
                wheel.per_inertia, turning + resistance(wheel.per_inertia, rate, mode)
            )
            sway, lift = row_of(nodes.sway), row_of(nodes.lift)
            # the roll rate enters in gimbals alone, so on an axle any value serves
            bends = case_bends(self, case, turning, sway, lift, 0.0 * x)
            slack = first_below(bends.contact, work)
        within = reach <= SURELY_WITHIN * wheel.range and min(edge, slack) > 1.0
        return Beyond(edge, slack, within, reach)

    def wheel_angle(self, planes: tuple[Plane, ...], at: Outside) -> float:
        """Return θ = ϑ."""
        return planes[0].x

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Outside) -> Instant:
        """Return wheel and case at an instant."""
        wheel, angle, w = wheel_now(self.wheel, at), planes[0].x, omega[0] * planes[0].y
        case = case_of(self, omega, planes)
        rate = w - case.phi_rate
        t, _, drawn = lever_arm(wheel.lever, mode.side, angle)
        pull = pull_of(wheel.per_inertia, drawn, 0.0)
        turning = pull * t + resistance(wheel.per_inertia, rate, mode)
        lift = self.gravity if self.moves is None else at.gravity
        felt = on_case(wheel.per_inertia, turning)
        bends = case_bends(self, case, felt, at.drive.value, lift, -at.tilt.rate)
        slowed = -turning
        if wheel.per_inertia.growth is not None:
            slowed = slowed - wheel.per_inertia.growth * w
        bend = slowed - bends.phi_bend
        drift: tuple[Plane, ...] = (
            Plane(rate, slowed),
            Plane(omega[1] * planes[1].y, bends.first),
        )
        if isinstance(self.case, AxleNumbers):
            drift = (*drift, Plane(omega[2] * planes[2].y, bends.second))
        over = OVER - max(abs(case.theta), abs(case.phi - case.theta))
        return Instant(
            angle=angle,
            rate=rate,
            bend=bend,
            tension=bends.contact,
            margin=min(wheel.range - abs(angle), over),
            torque=-pull * t,
            coordinate=angle,
            speed=rate,
            acceleration=bend,
            drift=drift,
        )

    def set_off(self, omega: Omega, angle: float, at: Outside, state: RunningState) -> None:
        """Put the wheel at rest at θ = angle in a case that hangs at rest."""
        lift = self.gravity if self.moves is None else at.gravity
        tilt = math.atan2(-at.drive.value, lift)
        state.planes[0].x = angle
        if isinstance(self.case, AxleNumbers):
            # θ = φ = tilt in the modes: c (q + q′) = B q + B′q′ = tilt
            apart = self.case.c * (self.case.B - self.case.B_prime)
            state.planes[1].x = tilt * (self.case.c - self.case.B_prime) / apart
            state.planes[2].x = tilt * (self.case.B - self.case.c) / apart
        else:
            state.planes[1].x = tilt
        for p in range(len(omega)):
            state.planes[p].y = state.planes[p].y_rest = state.planes[p].x_rest = 0.0
        state.side = -1 if angle < 0.0 else 1
        now = self.instant(mode_of(state), omega, planes_of(omega, state.planes), at)
        state.direction = -1 if now.bend < 0.0 else 1
        state.armed = is_due(self, state, float(state.direction), angle)

    def strike(
        self, mode: Mode, omega: Omega, at: Outside, now: Instant, state: RunningState
    ) -> None:
        """Let an impulse part wheel and case: its energy is all that it adds to both."""
        per_inertia, planes = wheel_now(self.wheel, at).per_inertia, state.planes
        impulse = per_inertia.impulse
        if impulse is None:
            return
        case = case_of(self, omega, planes_of(omega, planes))
        share = on_case(per_inertia, self.share / self.squared)
        if isinstance(self.case, AxleNumbers):
            # the contact force grows with φ̈ and takes up a part of the torque (G5.4)
            eccentric = self.case.c / self.case.k * math.sin(case.phi - case.theta)
            share = share / (1.0 + eccentric * eccentric)
        # The rate of the wheel in the case changes as with the reduced inertia I/(1 + share), that
        # is, as by (1 + share) times the energy on I. The wheel takes 1/(1 + share) of the change.
        energy = given_energy(impulse, state.given) * (1.0 + share)
        given = kick(energy, now.rate, mode.direction) / (1.0 + share)
        planes[0].y += given / omega[0]
        back = -share * given
        if isinstance(self.case, AxleNumbers):
            e_theta = -self.case.c * back * math.cos(case.phi - case.theta)
            first, second = of_modes(self.case, back, e_theta)
            planes[1].y += first / omega[1]
            planes[2].y += second / omega[2]
        else:
            planes[1].y += back / omega[1]
        for p in range(len(omega)):
            planes[p].y_rest = 0.0

    def leaves_kink(self, mode: Mode, omega: Omega, planes: object, work: Work) -> bool:
        """Return whether the rate of the wheel keeps its sign throughout, away from the kink."""
        case = case_at_nodes(self, omega, work)
        return lowest(mode.side * (omega[0] * row_of(work.y, 0) - case.phi_rate)) > 0.0

    def ahead_s(
        self, omega: Omega, length: float, terms: int, x: float, state: RunningState, work: Work
    ) -> float:
        """Return the time to a little after the next expected impulse or kink [s], or inf."""
        ahead = math.inf
        if not (self.turns_abruptly or self.feels_impulse or self.kinked):
            return ahead
        planes = planes_of(omega, state.planes)
        q, y = planes[0].x, planes[0].y - case_of(self, omega, planes).phi_rate / omega[0]
        if self.feels_impulse:
            way = float(state.direction if state.armed else -state.direction)
            ahead = phase_to(way, q, y, self.impulse)
        if self.kinked:
            ahead = min(ahead, phase_to(-float(state.side), q, y, 0.0))
        return (ahead + BEYOND) / omega[0]


@inlined
def on_case(per_inertia: PerInertia, turning: Numeric) -> Numeric:
    """Return the terms on the wheel over I, with the I that it has without heat."""
    return turning if per_inertia.share is None else turning / per_inertia.share


@inlined
def of_case(system: HungWheel, x: Numeric, y: Numeric, u: Numeric, v: Numeric) -> CaseState:
    """Return the case from its coordinates X and their rates: x and y, on an axle u and v too."""
    case = system.case
    if isinstance(case, AxleNumbers):
        phi, phi_rate = case.B * x + case.B_prime * u, case.B * y + case.B_prime * v
        return CaseState(phi, phi_rate, case.c * (x + u), case.c * (y + v))
    return CaseState(x, y, 0.0 * x, 0.0 * y)


@inlined
def case_at_nodes(system: HungWheel, omega: Omega, work: Work) -> CaseState:
    """Return the case at the nodes of a step."""
    x, y = row_of(work.x, 1), omega[1] * row_of(work.y, 1)
    if isinstance(system.case, AxleNumbers):
        return of_case(system, x, y, row_of(work.x, 2), omega[2] * row_of(work.y, 2))
    return of_case(system, x, y, x, y)


@inlined
def case_of(system: HungWheel, omega: Omega, planes: tuple[Plane, ...]) -> CaseState:
    """Return the case at an instant."""
    x, y = planes[1].x, omega[1] * planes[1].y
    if isinstance(system.case, AxleNumbers):
        return of_case(system, x, y, planes[2].x, omega[2] * planes[2].y)
    return of_case(system, x, y, x, y)


@inlined
def of_modes(case: AxleNumbers, phi: Numeric, e_theta: Numeric) -> tuple[Numeric, Numeric]:
    """Return q and q′ of φ and eθ, or their derivatives of the derivatives of these."""
    per = 1.0 / (case.c * (case.B - case.B_prime))
    theta = e_theta * (1.0 / case.e)
    return per * (case.c * phi - case.B_prime * theta), per * (case.B * theta - case.c * phi)


@inlined
def case_bends(
    system: HungWheel,
    now: CaseState,
    turning: Numeric,
    sway: Numeric,
    lift: Numeric,
    roll_rate: Numeric,
) -> CaseBends:
    """Return the accelerations of the case, with −ψ̈ of the wheel (`turning`).

    On an axle (E3) the torque Q = I · turning enters φ̈ = (Q/M − (N/M) c sin δ)/k², and by
    N/M = … + c φ̈ sin δ the contact force.
    """
    case, torque = system.case, system.share * turning
    if isinstance(case, AxleNumbers):
        delta, per = now.phi - now.theta, 1.0 / (case.k * case.k)
        rates = now.theta_rate, now.phi_rate
        contact, sin_theta, cos_theta, sin_delta, cos_delta = contact_force(
            (case.e, case.c, case.k), now.theta, delta, rates, sway, lift
        )
        eccentric = (case.c / case.k) * sin_delta
        contact = contact + case.c * per * sin_delta * torque / fma(eccentric, eccentric, 1.0)
        phi_bend = per * (torque - contact * (case.c * sin_delta))
        free = case.c * (now.phi_rate * now.phi_rate) * sin_delta
        free = free - (lift * sin_theta + sway * cos_theta)
        first, second = of_modes(case, phi_bend, free - case.c * phi_bend * cos_delta)
        return CaseBends(phi_bend, first, second, contact)
    bend = gimbals_bend(case, now.phi, now.phi_rate - roll_rate, 0.0, sway, lift)
    bend = bend + torque * (1.0 / system.squared)
    return CaseBends(bend, bend, bend, 0.0 * bend + 1.0)


class HungCollocation(Collocation):
    """Propagator of a wheel in a case of finite mass; both move together, at any angle."""

    def __init__(self, machine: Machine, case: CaseOfMass, tolerance: float | None = None) -> None:
        super().__init__(machine, tolerance)
        e, c, k = case.link, case.depth, case.gyration_radius
        self._numbers: GimbalsLaw | AxleNumbers
        if e:
            own, self._squared = modes(e, c, k * k), k * k
            slow, fast = (math.sqrt(each) for each in own.squared_frequencies(machine.gravity))
            self._numbers = AxleNumbers(e, c, k, own.B, own.B_prime)
            self._omegas: Omega = (self._omega, slow, fast)
        else:
            self._squared = k * k + c * c
            pull = c / self._squared
            self._numbers = GimbalsLaw(pull, case.damping or None, None)
            self._omegas = self._omega, math.sqrt(pull * machine.gravity)
        self._share = machine.inertia / case.mass
        factor = 0.0 if machine.cam.joints.size else ERROR_OF_LAST_STRONG
        allowed = tolerance_of(tolerance, factor, 2.0 ** -(2 * SIZE + 1 if factor else 9))
        heated = HotNumbers._fields if self._hot else ()
        nodes, columns = (*GIMBALS_NODES, *heated), 2 * SIZE if self._hot else SIZE
        SlackThread.__init__(self, machine, len(self._omegas), nodes, SIZE, allowed, columns)
        self.longest_step_s = min(self.longest_step_s, LONGEST_PHASE_RAD / max(self._omegas))

    def _moved(self, forcing: Forcing) -> Moved:
        """Return wheel and case."""
        felt = FeltChannels(None, None, None, heat=self._hot or None)
        wheel = super()._moved(forcing).system._replace(felt=felt)
        moves = None if forcing.gravity is None else True
        numbers = wheel, self._numbers, self._share, self._squared, moves, self._machine.gravity
        return Moved(HungWheel(*numbers), self._omegas)

    def _loosened(self, taut: Moved) -> Moved | None:
        """Return None: a force or a spring without mass never lets go of its thread."""
        return None

    def _failure(self, code: int, time_s: float) -> PropagationError:
        if code == stepping.SLACK:
            return lifted_off(time_s)
        reached = abs(float(self._state['planes']['x'][0]))
        # the code has two causes: a wheel far from the end of its cam did not leave it, so it was
        # the case that turned over
        if code == stepping.EDGE and reached < 0.9 * self._machine.cam.range_rad:
            return turned_over(time_s)
        return super()._failure(code, time_s)
