"""The wheel as a system of one rotating plane."""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import NamedTuple

import numpy as np

from tauto_core.curves.cam import ArcLever, LeverArm, LinearLever
from tauto_core.kernels import compiled, inlined
from tauto_core.machines import LeverMachine, Machine, SlackThreadError
from tauto_core.motion.events import OVERSHOOT, is_due, phase_to, ride_held
from tauto_core.motion.gauss_step import Mode, Omega, Planes, Work, gauss_constants
from tauto_core.motion.lanes import (
    SIZE,
    WIDE_SIZE,
    Lanes,
    Numeric,
    fma,
    larger,
    largest,
    lowest,
    row_of,
    store,
    width,
)
from tauto_core.motion.stepping import (
    CLEAR,
    ERROR_OF_LAST,
    ERROR_OF_LAST_STRONG,
    MIN_ANGLE,
    TOLERANCE_SHARE,
    bounds_of,
    step_error,
)
from tauto_core.motion.system import (
    APPARENT_GRAVITY,
    DRIVE_BEND,
    DRIVE_RATE,
    HOT_NODES,
    LEAN,
    NOWHERE,
    TILT_RATE,
    Exits,
    ForcingPieces,
    HeatTerms,
    Inputs,
    Instant,
    Plane,
    RunningState,
    SteppedRun,
    StepPlace,
    column_at,
    fill_hot,
    first_below,
    heated_at_nodes,
    heated_now,
    mode_of,
    near_zero,
    nodes_of,
    outside_at,
)
from tauto_core.motion.wells import (
    ArcShape,
    Arm,
    PerInertia,
    angle_along,
    angles_of,
    arc_of,
    arc_shape,
    excess,
    given_energy,
    kick,
    lever_arm,
    mass_of,
    on_arc,
    pull_of,
    resistance,
    ride,
    shortening_and_angle,
    speed_of,
    term,
    thermal_numbers,
    unbalanced,
)
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import CamRangeError

# -----------------------------------------------------------------------------
# Forcing of the wheel at the nodes of a step.

WHEEL_NODES = 'line_rate', 'line_bend', 'tilt_rate', 'gravity', 'lean'
"""Rows of the nodes: γ̇, γ̈, τ̇, g_eff and β − γ."""

THERMAL_NODES = *WHEEL_NODES, *HOT_NODES
"""Rows of the nodes if temperature changes the wheel."""


class InputChannels(NamedTuple):
    """The channels of the ship's motion that act: True or `None`, a constant when compiling.

    With `heat`, the forcing holds the wheel's parameters.
    """

    line: bool | None
    tilt: bool | None
    gravity: bool | None
    lean: bool | None = None
    heat: bool | None = None


@inlined
def row_or_zero(channel: bool | None, row: FloatArray) -> Lanes:
    """Return a row of the nodes, or 0 if its channel is absent."""
    return 0.0 if channel is None else row_of(row)


# -----------------------------------------------------------------------------
# Whether a step of the wheel leaves the range of the cam, or the thread goes slack.

SURELY_WITHIN = 0.97
"""A step surely stays in the range if all its nodes stay within this share of it."""

ALL_AGAINST = Mode(1.0, 1.0, 1.0)
"""The mode in which drag and recoil add up for a positive rate."""


@compiled
def surely_within(wheel: Wheel, mode: Mode, omega: Omega, work: Work) -> bool:
    """Return whether rough bounds prove that no node leaves the range and the thread is taut.

    With M = 1 + μt², M · tension = pull + μt′ϑ̇² − μt(γ̈ + resistance). It is positive if pull
    exceeds the largest μ|t|·(|γ̈| + resistance), plus μ|t′|ϑ̇² for a shortening lever arm. In
    either coordinate |ϑ| ≤ max |x|, and |θ̇| ≤ |ωY| + |γ̇| + |τ̇|.
    """
    per_inertia, channels, x = wheel.per_inertia, wheel.channels, row_of(work.x)
    zeros = 0.0 * x
    reach = largest(x)
    line_rate = largest(zeros + row_or_zero(channels.line, work.nodes.line_rate))
    line_bend = largest(zeros + row_or_zero(channels.line, work.nodes.line_bend))
    tilt_rate = largest(zeros + row_or_zero(channels.tilt, work.nodes.tilt_rate))
    rate = omega[0] * largest(row_of(work.y)) + line_rate + tilt_rate
    pull = pull_of(per_inertia, 0.0, row_or_zero(channels.gravity, work.nodes.gravity))
    against = line_bend + resistance(per_inertia, rate, ALL_AGAINST)
    if per_inertia.imbalance is not None:
        weight = row_or_zero(channels.gravity, work.nodes.gravity)
        load = term(per_inertia.imbalance.still, 1.0) + term(per_inertia.imbalance.weight, weight)
        against = against + largest(zeros + load)
    if isinstance(wheel.lever, LinearLever):
        lost = term(per_inertia.carried, wheel.lever.rate * reach * against)
    else:
        arm = lever_arm(wheel.lever, mode.side, x)
        shorter = 0.0 if lowest(zeros + arm.t_prime) >= 0.0 else largest(zeros + arm.t_prime)
        riding = largest(zeros + arm.t) * against + shorter * (rate * rate)
        lost = term(per_inertia.carried, riding)
    if per_inertia.share is not None:
        lost = largest(zeros + lost)
    return reach <= wheel.range and lowest(zeros + pull) > lost


# -----------------------------------------------------------------------------
# The wheel as a system of one rotating plane: X is the coordinate of `wells`, ωY its momentum.
#
# The coordinate is the angle ϑ, or the arc s for a linear lever arm with a weight on the thread.
#
# `_pushed` is the equation of motion solved for ϑ̈ and the tension, at nodes and instants alike.
# Three methods arrange its terms differently to limit rounding. `Wheel.disturb` writes the small
# disturbance of an oscillator, without cancellation. `Wheel.drift` gives the rate of the momentum,
# without γ̈. `holding_torque` is for a wheel at rest in the case. `test_kernels_wheel_equations`
# checks them all, and the trial steps, against the printed equation.


class Wheel(NamedTuple):
    """The wheel as `system.System`.

    Attributes:
        per_inertia: terms of the equation of motion, over I.
        lever: law of the lever arm.
        shape: functions of the arc, or `None` if the coordinate is the angle.
        channels: the channels of the ship's motion that act.
        impulse, pace: as in `System`.
        range: largest |ϑ| [rad].
        gravity: acceleration of gravity at rest [m/s2].
    """

    per_inertia: PerInertia
    lever: LeverArm
    shape: ArcShape | None
    channels: InputChannels
    impulse: float
    pace: float
    range: float
    gravity: float

    @property
    def heat(self) -> bool | None:
        """True if heat changes the wheel, else `None`."""
        return self.channels.heat

    @inlined
    def heated(self, hot: HeatTerms) -> Wheel:
        """Return the wheel with parameters as heat changes them."""
        channels = self.channels
        return Wheel(
            thermal_numbers(self.per_inertia, hot),
            self.lever,
            self.shape,
            InputChannels(channels.line, channels.tilt, channels.gravity, channels.lean),
            self.impulse,
            self.pace,
            self.range,
            self.gravity,
        )

    @property
    def feels_impulse(self) -> bool:
        """Whether an escapement pushes the wheel."""
        return self.per_inertia.impulse is not None

    @property
    def recoils(self) -> bool:
        """Whether a resting tooth pushes the wheel back."""
        return self.per_inertia.recoil is not None

    @property
    def drag_has_kink(self) -> bool:
        """Whether the drag has a kink at the turning points."""
        on_wheel = self.per_inertia
        kinked = on_wheel.quadratic is not None or on_wheel.coulomb is not None
        return kinked or on_wheel.law is not None

    @property
    def kinked(self) -> bool:
        """Whether the cam has a kink."""
        return isinstance(self.lever, ArcLever)

    @property
    def sticks(self) -> bool:
        """Whether friction may hold the wheel."""
        return self.per_inertia.coulomb is not None

    @property
    def has_weight(self) -> bool:
        """Whether a weight keeps the thread taut."""
        return self.per_inertia.carried is not None or self.per_inertia.weight is not None

    @property
    def feels_drag(self) -> bool:
        """Whether drag acts: then θ̇ matters within a step."""
        return self.per_inertia.viscous is not None or self.drag_has_kink

    @property
    def feels_tilt(self) -> bool:
        """Whether θ or θ̇ matters within a span."""
        return self.feels_drag or self.feels_impulse

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill the rows of the channels that act, τ̇ for drag only."""
        x, terms, nodes = nodes_of(place, work), place.terms, work.nodes
        if self.channels.line is not None:
            store(nodes.line_rate, 0, column_at(DRIVE_RATE, terms, x, work))
            store(nodes.line_bend, 0, column_at(DRIVE_BEND, terms, x, work))
        if self.feels_drag and self.channels.tilt is not None:
            store(nodes.tilt_rate, 0, column_at(TILT_RATE, terms, x, work))
        if self.channels.gravity is not None:
            store(nodes.gravity, 0, column_at(APPARENT_GRAVITY, terms, x, work))
        if self.channels.lean is not None:
            store(nodes.lean, 0, column_at(LEAN, terms, x, work))
        if self.channels.heat is not None:
            fill_hot(x, work)

    @inlined
    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the disturbance of the plane."""
        per_inertia = heated_at_nodes(self, work).per_inertia
        channels, nodes = self.channels, work.nodes
        square, per_omega = omega[0] * omega[0], 1.0 / omega[0]
        x, w = row_of(work.x), omega[0] * row_of(work.y)
        line_rate = row_or_zero(channels.line, nodes.line_rate)
        tilt_rate = row_or_zero(channels.tilt, nodes.tilt_rate)
        gravity = row_or_zero(channels.gravity, nodes.gravity)
        if self.shape is None:
            # d₁ = q̇ − w and d₂ = (ẇ + ω²q)/ω
            t, t_prime, lift = lever_arm(self.lever, mode.side, x)
            speed = speed_of(per_inertia.carried, t, w, line_rate)
            pull = pull_of(per_inertia, lift, gravity)
            pushed = excess(self.lever, x, t, pull, square)
            pushed = pushed + ride(per_inertia.carried, t, t_prime, speed)
            pushed = pushed - resistance(per_inertia, speed + tilt_rate, mode)
            if per_inertia.imbalance is not None:
                lean = row_or_zero(channels.lean, nodes.lean)
                pushed = pushed - unbalanced(per_inertia, x - lean, gravity)
            store(work.d1, 0, speed - w)
        else:
            # d₁ = ṡ − p = −γ̇n and d₂ = (ṗ + ω²s)/ω. With nt = s(b − deficit),
            # ṗ + ω²s = s (ω² − b·pull + pull·deficit + ṡγ̇ (dn/ds)/s) − n·resistance
            n, n_slope, lever_deficit, _ = on_arc(self.shape, x)
            arc_speed = fma(-line_rate, n, w)
            rate = fma(n, arc_speed, tilt_rate)
            pull = pull_of(per_inertia, 0.0, gravity)
            excess_square = fma(pull, lever_deficit, square - self.shape.rate * pull)
            pushed = x * fma(arc_speed, line_rate * n_slope, excess_square)
            pushed = fma(-n, resistance(per_inertia, rate, mode), pushed)
            store(work.d1, 0, -(line_rate * n))
        if per_inertia.growth is not None:
            pushed = pushed - per_inertia.growth * w
        store(work.d2, 0, pushed * per_omega)

    def coordinates(self, work: Work) -> Lanes:
        """Return ϑ, or the arc, at the nodes."""
        return row_of(work.x)

    def coordinate(self, planes: tuple[Plane, ...]) -> float:
        """Return ϑ, or the arc."""
        return planes[0].x

    def exits(self, mode: Mode, omega: Omega, work: Work) -> Exits:
        """Return whether the step leaves the cam, or its thread goes slack.

        Rough bounds decide if they suffice.
        """
        edge, slack, is_near = NOWHERE, NOWHERE, False
        wheel = heated_at_nodes(self, work)
        reach = largest(row_of(work.x))
        is_within = reach <= SURELY_WITHIN * wheel.range
        if isinstance(wheel.lever, LinearLever) and surely_within(wheel, mode, omega, work):
            return Exits(edge, slack, is_within, reach)
        channels, nodes = wheel.channels, work.nodes
        line_rate = row_or_zero(channels.line, nodes.line_rate)
        q, speed = angle_and_speed(
            wheel, row_of(work.x), omega[0] * row_of(work.y), line_rate, mode.side
        )
        if largest(q) > wheel.range:
            edge = first_below(wheel.range - larger(q, q), work)
        if wheel.has_weight:
            arm, per_inertia = lever_arm(wheel.lever, mode.side, q), wheel.per_inertia
            rate = speed + row_or_zero(channels.tilt, nodes.tilt_rate)
            line_bend = row_or_zero(channels.line, nodes.line_bend)
            gravity = row_or_zero(channels.gravity, nodes.gravity)
            aside = unbalanced(per_inertia, q - row_or_zero(channels.lean, nodes.lean), gravity)
            _, tension = _pushed(per_inertia, arm, mode, speed, rate, line_bend, gravity, aside)
            # 0·q gives the tension one lane per node even if it is a constant
            tension = 0.0 * q + tension
            slack, is_near = first_below(tension, work), near_zero(tension)
        return Exits(edge, slack, is_within, reach, is_near)

    def clear_square(
        self, omega: Omega, pieces: ForcingPieces, k: int, besides: float = 0.0
    ) -> float:
        """Return the bound over piece k: with x² + y² above it, the swing is clear of the tilt.

        It is also clear of θ = ± `besides`. θ = ϑ + τ can pass zero only while |ϑ| ≤ T, the bound
        of |τ|. If the momentum at that point is so large that ϑ̇ and θ̇ keep its sign, each angle
        passes zero once, the same way. With M = (I + mt²)/I at ϑ = T, x² ≤ MT² there (the arc is
        at most √M times the angle), and |y| > (M|τ̇| + |γ̇|)/ω suffices.
        """
        per = 1.0 / (pieces.length_s[k] * omega[0])
        reach, reach_rate = bounds_of(pieces.tilt, k, per)
        reach += besides
        _, line_rate = bounds_of(pieces.drive, k, per)
        mass = mass_of(self.per_inertia.carried, lever_arm(self.lever, 1.0, reach).t)
        momentum = mass * reach_rate + line_rate
        return CLEAR * (mass * reach * reach + momentum * momentum)

    def clear(self, square: float, omega: Omega, work: Work) -> bool:
        """Return whether x² + y² exceeds the bound at all nodes."""
        x, y = row_of(work.x), row_of(work.y)
        return lowest(x * x + y * y) > square

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Inputs) -> Instant:
        """Return the wheel at an instant."""
        wheel, tilt, w = heated_now(self, at), at.tilt, omega[0] * planes[0].y
        q, speed = angle_and_speed(wheel, planes[0].x, w, at.drive.rate, mode.side)
        rate, arm = speed + tilt.rate, lever_arm(self.lever, mode.side, q)
        # İψ̇ is left out of ϑ̈, which no motion is computed from: at most 1e-8 of it
        acceleration, tension = _pushed(
            wheel.per_inertia,
            arm,
            mode,
            speed,
            rate,
            at.drive.bend,
            at.gravity,
            unbalanced(wheel.per_inertia, q - at.lean, at.gravity),
        )
        share = wheel.per_inertia.share
        return Instant(
            angle=q + tilt.value,
            rate=rate,
            bend=acceleration + tilt.bend,
            tension=tension,
            margin=self.range - abs(q),
            torque=-tension * arm.t if share is None else -tension * arm.t / share,
            coordinate=q,
            speed=speed,
            acceleration=acceleration,
        )

    def drift(self, mode: Mode, omega: Omega, at: Inputs, now: Instant) -> tuple[Plane, ...]:
        """Return the time derivatives of coordinate and momentum: q̇ and ẇ, or ṡ and ṗ."""
        per_inertia, q, speed = heated_now(self, at).per_inertia, now.coordinate, now.speed
        t, t_prime, lift = lever_arm(self.lever, mode.side, q)
        pull = pull_of(per_inertia, lift, at.gravity)
        against = pull * t + resistance(per_inertia, now.rate, mode)
        against = against + unbalanced(per_inertia, q - at.lean, at.gravity)
        if per_inertia.growth is not None:
            momentum = speed * mass_of(per_inertia.carried, t) + at.drive.rate
            against = against + per_inertia.growth * momentum
        if self.shape is None:
            return (Plane(speed, ride(per_inertia.carried, t, t_prime, speed) - against),)
        k = self.shape.k
        n = 1.0 / math.sqrt(1.0 + (k * q) * (k * q))
        n_slope = -(k * k) * q * (n * n) * (n * n)
        return (Plane(speed / n, speed / n * at.drive.rate * n_slope - n * against),)

    def wheel_angle(self, planes: tuple[Plane, ...], at: Inputs) -> float:
        """Return θ = ϑ + τ."""
        return angle_at(self, planes[0].x) + at.tilt.value

    def set_off(self, omega: Omega, angle: float, at: Inputs, state: RunningState) -> None:
        """Put the wheel at rest at θ = angle, held by friction or about to move."""
        set_off_or_hold(heated_now(self, at), omega, angle, at, state)

    def move_with_case(self, run: SteppedRun, place: StepPlace) -> float:
        """Move the held wheel with the case until it breaks loose, and return the fraction.

        The torque is checked twice per node, or at the end alone if it is constant.
        """
        channels = self.channels
        steady = channels.line is None and channels.gravity is None and channels.heat is None
        return ride_held(self, run, place, 1 if steady else 2 * width(run.work.fractions))

    def breaks_loose(self, mode: Mode, angle: float, at: Inputs) -> bool:
        """Return whether holding the wheel at θ = angle takes more than c₀."""
        now = heated_now(self, at)
        return abs(holding_torque(now, mode, angle, at)) > term(now.per_inertia.coulomb, 1.0)

    def rest_at(self, omega: Omega, angle: float, at: Inputs, state: RunningState) -> None:
        """Put the wheel at rest in the moving case at θ = angle."""
        _place_at_rest(heated_now(self, at), omega, angle, at, state)

    def leaves_kink(self, mode: Mode, omega: Omega, planes: Planes, work: Work) -> bool:
        """Return whether |momentum| at the beginning exceeds |γ̇| throughout, away from the kink.

        Then ϑ̇ points away from the kink at first, and passes zero at most once in a step.
        """
        line_rate = row_or_zero(self.channels.line, work.nodes.line_rate)
        fastest = largest(0.0 * row_of(work.x) + line_rate)
        return mode.side * (omega[0] * planes[0].y) > fastest

    def strike(
        self, mode: Mode, omega: Omega, at: Inputs, now: Instant, state: RunningState
    ) -> None:
        """Change the momentum by an impulse."""
        wheel, q = heated_now(self, at), now.coordinate
        per_inertia = wheel.per_inertia
        if per_inertia.impulse is None:
            return
        mass = mass_of(per_inertia.carried, lever_arm(self.lever, mode.side, q).t)
        energy = given_energy(per_inertia.impulse, state.given) / mass
        speed = now.speed + kick(energy, now.rate, mode.direction)
        plane = state.planes[0]
        _, momentum = coordinate_and_momentum(wheel, q, speed, at.drive.rate, mode.side)
        plane.y = momentum / omega[0]
        plane.y_rest = 0.0

    def ahead_s(
        self, omega: Omega, length: float, terms: int, x: float, state: RunningState, work: Work
    ) -> float:
        """Return the time to just after the next expected impulse or kink [s], or inf.

        ϑ is extrapolated as a harmonic swing at constant γ̇. The impulse is due at θ = angle,
        first with τ of now, then with τ at the time so found. The frequency is ω√(g_eff/g), with
        the mean of g_eff between both times.
        """
        ahead, pace = math.inf, omega[0]
        if not (self.drag_has_kink or self.feels_impulse or self.kinked) or state.held:
            return ahead
        at = outside_at(terms, x, work)
        line, tilt, gravity = at.drive, at.tilt, at.gravity
        plane = state.planes[0]
        q, y = angle_at(self, plane.x), plane.y - line.rate / omega[0]
        if self.feels_impulse:
            # if no impulse is due, the next one comes after the turning point
            way = float(state.direction if state.armed else -state.direction)
            ahead = phase_to(way, q, y, self.impulse - way * tilt.value)
            if ahead < math.inf:
                then = outside_at(terms, min(x + ahead / (pace * length), 1.0), work)
                ahead = phase_to(way, q, y, self.impulse - way * then.tilt.value)
                gravity = 0.5 * (gravity + then.gravity)
        if self.kinked:
            ahead = min(ahead, phase_to(-float(state.side), q, y, 0.0))
        if gravity > 0.0:
            pace *= math.sqrt(gravity / self.gravity)
        return (ahead + OVERSHOOT) / pace


@inlined
def _pushed(
    per_inertia: PerInertia,
    arm: Arm,
    mode: Mode,
    speed: Numeric,
    rate: Numeric,
    line_bend: Numeric,
    gravity: Numeric,
    aside: Numeric,
) -> tuple[Numeric, Numeric]:
    """Return ϑ̈ and the tension over I, from ϑ̇ (`speed`), θ̇ (`rate`), γ̈, g_eff, the imbalance.

    (1 + μt²) ϑ̈ = −γ̈ − resistance − pull · t − aside − μtt′ϑ̇². The tension is F + m d²h/dt²,
    with d²h/dt² = t′ϑ̇² + tϑ̈.
    """
    t, t_prime, lift = arm
    mu, pull = per_inertia.carried, pull_of(per_inertia, lift, gravity)
    against = line_bend + resistance(per_inertia, rate, mode) + pull * t + aside
    acceleration = -(against + ride(mu, t, t_prime, speed)) / mass_of(mu, t)
    return acceleration, pull + term(mu, t_prime * (speed * speed) + t * acceleration)


@inlined
def angle_at(wheel: Wheel, x: float) -> float:
    """Return ϑ at the coordinate x."""
    return x if wheel.shape is None else angle_along(wheel.shape, x)


@inlined
def angle_and_speed(
    wheel: Wheel, x: Numeric, w: Numeric, line_rate: Numeric, side: float
) -> tuple[Numeric, Numeric]:
    """Return ϑ and ϑ̇ from coordinate and momentum, at the nodes of a step or at an instant."""
    if wheel.shape is None:
        t = lever_arm(wheel.lever, side, x).t
        return x, speed_of(wheel.per_inertia.carried, t, w, line_rate)
    n, q = shortening_and_angle(wheel.shape, x)
    return q, n * (w - line_rate * n)


@inlined
def coordinate_and_momentum(
    wheel: Wheel, q: float, speed: float, line_rate: float, side: float
) -> tuple[float, float]:
    """Return coordinate and momentum from ϑ and ϑ̇: the inverse of `angle_and_speed`."""
    if wheel.shape is None:
        t = lever_arm(wheel.lever, side, q).t
        return q, speed * mass_of(wheel.per_inertia.carried, t) + line_rate
    k = wheel.shape.k
    per_n = math.sqrt(1.0 + (k * q) * (k * q))
    return arc_of(q, k), speed * per_n + line_rate / per_n


@compiled
def holding_torque(wheel: Wheel, mode: Mode, angle: float, at: Inputs) -> float:
    """Return the torque over I that keeps the wheel at θ = angle in the moving case.

    The held wheel has ϑ̇ = −τ̇, ϑ̈ = −τ̈ and ψ̈ = α̈ = γ̈ − τ̈. The mass on the thread accelerates
    by t′τ̇² − tτ̈. The torque is ψ̈ + μt(t′τ̇² − tτ̈) + pull · t + R s/I.
    """
    per_inertia, tilt = wheel.per_inertia, at.tilt
    t, t_prime, lift = lever_arm(wheel.lever, mode.side, angle - tilt.value)
    carried = term(per_inertia.carried, t * (t_prime * tilt.rate * tilt.rate - t * tilt.bend))
    pulled = carried + pull_of(per_inertia, lift, at.gravity) * t
    pulled = pulled + unbalanced(per_inertia, angle - tilt.value - at.lean, at.gravity)
    return at.drive.bend - tilt.bend + pulled + term(per_inertia.recoil, mode.pallet)


# -----------------------------------------------------------------------------
# Coulomb's friction at rest: the wheel is held in its case by a torque of at most c₀.


@compiled
def set_off_or_hold(
    wheel: Wheel, omega: Omega, angle: float, at: Inputs, state: RunningState
) -> None:
    """Set the state at θ = angle, θ̇ = 0: held, or the direction in which it moves off."""
    coulomb = wheel.per_inertia.coulomb
    q = angle - at.tilt.value
    state.side = 1 if q > 0.0 or (q == 0.0 and state.side > 0) else -1
    torque = holding_torque(wheel, mode_of(state), angle, at)
    _place_at_rest(wheel, omega, angle, at, state)
    if coulomb is not None and abs(torque) <= coulomb:
        state.held, state.held_angle = True, angle
        return
    state.held = False
    if torque != 0.0:
        state.direction = -1 if torque > 0.0 else 1
    state.armed = is_due(wheel, state, float(state.direction), angle)


@compiled
def _place_at_rest(
    wheel: Wheel, omega: Omega, angle: float, at: Inputs, state: RunningState
) -> None:
    """Put the wheel at rest in the moving case at θ = angle."""
    q, plane = angle - at.tilt.value, state.planes[0]
    x, w = coordinate_and_momentum(wheel, q, -at.tilt.rate, at.drive.rate, float(state.side))
    plane.x, plane.x_rest = x, 0.0
    plane.y, plane.y_rest = w / omega[0], 0.0


# -----------------------------------------------------------------------------
# Reference frequency of the rotating frame, and the longest step that meets a tolerance.

LONGEST_ANGLE = {SIZE: 3.05, WIDE_SIZE: 6.1}
"""Longest step by its number of stages, as the angle ωh [rad].

`events.SPARE` may lengthen it by a twentieth. Eight stages then span half a swing and
`events.OVERSHOOT`. Sixteen stay within `gauss_step.MAX_ANGLE`.
"""

WIDE_ERROR_OF_LAST, WIDE_ERROR_OF_GROWTH = 0.003, 0.05
"""`stepping.ERROR_OF_LAST` for sixteen stages, and its growth with k²ϑ², the inertia's growth."""

MOST_DISTURBED = 1.0
"""Growth of the inertia k²ϑ², or damping c₁/(Iω), up to which sixteen stages pay."""

WIDE_ERROR_OF_LAST_STRONG = 0.1
"""The same for sixteen stages from kink to kink of a cheek: 0.0003 to 0.15, as measured."""

# Phases of the swing at which steps are tried.
_PHASES = 12


def reference_frequency(machine: Machine | LeverMachine) -> float:
    """Return the frequency of the rotating frame [rad/s]: the released swing's, if there is one.

    Any frequency would do. With this one the disturbance has no mean and is smallest.
    """
    try:
        return math.tau / machine.period(machine.release_angle)
    except (CamRangeError, SlackThreadError):
        return machine.frequency


def stages_of(machine: Machine, shape: ArcShape | None) -> int:
    """Return the number of stages: sixteen for a weakly disturbed swing, else eight.

    Steps end at a kink and at the joints of a spline, and are short in a strongly anharmonic or
    damped well. Sixteen stages would not lengthen them.
    """
    drag = machine.drag
    abrupt = drag is not None and not drag.is_linear
    cam = machine.cam
    if abrupt or cam.kinked or cam.joints.size:
        return SIZE
    damped = drag.viscous / (machine.inertia * machine.frequency) if drag is not None else 0.0
    smooth = shape is not None or machine.is_linear
    disturbed = max(_inertia_growth(machine, shape), damped)
    return WIDE_SIZE if smooth and disturbed <= MOST_DISTURBED else SIZE


def lasting_shape(machine: Machine) -> ArcShape | None:
    """Return the functions of the arc, or `None` if the coordinate is the angle.

    The arc needs an M(ϑ)/I that does not change with time.
    """
    lasts = not machine.heat.acts or machine.heat.keeps_shape
    return arc_shape(machine) if lasts else None


def _inertia_growth(machine: Machine, shape: ArcShape | None) -> float:
    """Return the relative growth of the inertia from ϑ = 0 to the release, k²ϑ² (`ArcShape`)."""
    return 0.0 if shape is None else (shape.k * machine.release_angle) ** 2


def error_factor(machine: Machine, shape: ArcShape | None, stages: int | None = None) -> float:
    """Return the error of a step over the square of its last coefficient.

    0 for a cam with joints: derivatives of its law jump, and the error is the coefficient itself.
    `stages` is `stages_of` by default.
    """
    if machine.cam.joints.size:
        return 0.0
    if stages_of(machine, shape) == WIDE_SIZE:
        return WIDE_ERROR_OF_LAST + WIDE_ERROR_OF_GROWTH * _inertia_growth(machine, shape)
    if stages == WIDE_SIZE and machine.is_harmonic:
        # along ϑ: a weight's own cam
        reached = min(abs(machine.release_angle), machine.cam.range_rad)
        growth = float(machine.mass(reached)) / machine.inertia - 1.0
        return WIDE_ERROR_OF_LAST + WIDE_ERROR_OF_GROWTH * growth
    if stages == WIDE_SIZE and machine.cam.kinked:
        return WIDE_ERROR_OF_LAST_STRONG
    weak = shape is not None or machine.is_linear
    weak = weak or (machine.carried_mass == 0.0 and machine.stiffness == 0.0)
    weak = weak and machine.imbalance is None
    return ERROR_OF_LAST if weak else ERROR_OF_LAST_STRONG


def longest_step(
    machine: Machine, shape: ArcShape | None, omega: float, *, factor: float, tolerance: float
) -> float:
    """Return the longest step [s] whose error on land is within the tolerance, at any phase.

    The disturbance is evaluated along the undisturbed motion at the release amplitude.
    """
    amplitude = machine.release_angle
    if shape is not None:
        amplitude = arc_of(amplitude, shape.k)
    stages = stages_of(machine, shape)
    # an impulse may come every half swing
    longest_angle = LONGEST_ANGLE[stages if machine.escapement is None else SIZE]
    constants, angles = gauss_constants(stages), [longest_angle]
    while angles[-1] > MIN_ANGLE:  # finds the longest step to 3 %
        angles.append(0.97 * angles[-1])

    def is_within(angle: float) -> bool:
        # the largest last Legendre coefficient of steps of ωh = angle, relative to the state, at
        # all phases except those over a kink
        tail_size = 0.0
        if amplitude != 0.0:
            phase = (np.arange(_PHASES) * (math.tau / _PHASES))[:, None]
            turned = constants.nodes * angle
            x, y = amplitude * np.cos(phase + turned), -amplitude * np.sin(phase + turned)
            if machine.cam.kinked:
                is_one_sided = np.min(x, axis=1) * np.max(x, axis=1) >= 0.0
                x, y = x[is_one_sided], y[is_one_sided]
            d1, d2 = disturbance_on_land(machine, shape, omega, x, y)
            cosine, sine = np.cos(turned), np.sin(turned)
            slopes = cosine * d1 - sine * d2, sine * d1 + cosine * d2
            tail = constants.projection[-1]
            tails = [np.max(np.abs(slope @ tail), initial=0.0) for slope in slopes]
            tail_size = angle / omega * float(max(tails)) / abs(amplitude)
        return step_error(factor, tail_size) <= TOLERANCE_SHARE * tolerance

    # the coefficient falls with the length of the step. The shortest step is always taken
    return angles[bisect_left(angles, True, hi=len(angles) - 1, key=is_within)] / omega


def disturbance_on_land(
    machine: Machine, shape: ArcShape | None, omega: float, x: FloatArray, y: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return d₁ and d₂ of a wheel on land, as `Wheel.disturb` does, for arrays x and y.

    Written in NumPy, which needs no compiling. Drag uses the momentum w, which is no less than the
    speed. Along the arc drag is left out, since the error is an estimate.
    """
    q = angles_of(x, shape.k) if shape is not None else x
    edge = machine.cam.range_rad
    q = np.clip(q, -edge, edge)
    t, t_prime = machine.cam.lever_arm(q), machine.cam.lever_rate(q)
    mass = machine.mass(q) / machine.inertia
    force = machine.pull(machine.cam.lift(q)) * t / machine.inertia
    if machine.imbalance is not None:
        moment, direction = machine.imbalance
        force = force + moment * machine.gravity / machine.inertia * np.sin(q + direction)
    if shape is not None:
        return np.zeros(x.shape), omega * x - force / np.sqrt(mass) / omega
    w = omega * y
    ride = machine.carried_mass / machine.inertia * t * t_prime * (w / mass) ** 2
    viscous = machine.drag.viscous / machine.inertia if machine.drag else 0.0
    return w / mass - w, omega * x + (ride - force - viscous * w) / omega
