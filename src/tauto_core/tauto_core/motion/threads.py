"""The swinging thread in two rotating planes, and the parts it shares with Sully's lever."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from tauto_core.kernels import compiled, inlined
from tauto_core.machines.parts import DragLaw
from tauto_core.motion.events import OVERSHOOT, is_due, phase_to
from tauto_core.motion.forcing import LEAST_UPWARD
from tauto_core.motion.gauss_step import Mode, Omega, Work, sine_versine
from tauto_core.motion.lanes import (
    Lanes,
    Numeric,
    NumericPair,
    filled,
    fma,
    lane,
    largest,
    lowest,
    row_of,
    store,
    width,
    with_lane,
)
from tauto_core.motion.stepping import CLEAR, bounds_of
from tauto_core.motion.system import (
    APPARENT_GRAVITY,
    DRIVE,
    DRIVE_RATE,
    TILT,
    TILT_RATE,
    Exits,
    ForcingPieces,
    HeatTerms,
    Inputs,
    Instant,
    Plane,
    RunningState,
    StepPlace,
    System,
    column_at,
    difference,
    fill_hot,
    first_below,
    heated_at_nodes,
    heated_now,
    keep,
    mode_of,
    near_zero,
    nodes_of,
    outside_at,
    planes_of,
)
from tauto_core.motion.wells import law_torque, term

if TYPE_CHECKING:
    from tauto_core.motion.free_step import FreeHalfSwing

SETTLED, MOST_ITERATIONS = 1e-15, 40
"""Change, relative or of an angle, that ends Newton's method, and its most iterations."""

WELL_WITHIN = 0.05
"""Margin at all nodes above which a step surely stays in the range between them."""


class OnWheel(NamedTuple):
    """The terms on the wheel other than the thread, over its moment of inertia I.

    Attributes:
        viscous: c₁/I [1/s].
        quadratic: c₂/I.
        energy: twice the energy of an impulse over I [1/s2].
        recoil: R/I of the escapement [1/s2], or `None`.
        impulse: angle of the impulse [rad], infinite without one.
        pace: frequency of the swing [rad/s].
        gravity: g at rest [m/s2].
        law: a further drag law, over I, or `None`.
        heat: True if heat changes these parameters, which then hold at an instant or at the nodes.
        share: factor of the law's torque if heat changes I.
        growth: İ/I [1/s] if heat changes I.
    """

    viscous: float
    quadratic: float
    energy: float
    recoil: float | None
    impulse: float
    pace: float
    gravity: float
    law: DragLaw | None = None
    heat: bool | None = None
    share: float | None = None
    growth: float | None = None


class WithThread:
    """Base of systems with a wheel on a real thread, as `System`."""

    @property
    def on_wheel(self) -> OnWheel:
        """The terms on the wheel other than the thread."""
        raise NotImplementedError

    @property
    def heat(self) -> bool | None:
        """True if heat changes the system, else `None`."""
        return self.on_wheel.heat

    @property
    def impulse(self) -> float:
        """Angle of the impulse [rad]."""
        return self.on_wheel.impulse

    @property
    def recoils(self) -> bool:
        """Whether a resting tooth pushes the wheel back."""
        return self.on_wheel.recoil is not None

    @property
    def pace(self) -> float:
        """Frequency of the swing with a taut thread [rad/s]."""
        return self.on_wheel.pace

    @property
    def drag_has_kink(self) -> bool:
        """Whether the drag has a kink at the turning points."""
        return self.on_wheel.law is not None or self.on_wheel.quadratic > 0.0


class ThreadSystem(WithThread, System):
    """A wheel on a real thread, as `System`.

    Absent drag is zero, not `None`: machines with and without drag share their kernels.
    """

    def set_off(self, omega: Omega, angle: float, at: Inputs, state: RunningState) -> None:
        """Set the direction in which the wheel starts at θ = angle, θ̇ = 0."""
        now = self.instant(mode_of(state), omega, planes_of(omega, state.planes), at)
        state.direction = -1 if now.bend < 0.0 else 1
        state.armed = is_due(self, state, float(state.direction), angle)

    def ahead_s(
        self, omega: Omega, length: float, terms: int, x: float, state: RunningState, work: Work
    ) -> float:
        """Return the time to just after the next expected impulse [s], or inf.

        The swing is extrapolated about its present centre at a frequency proportional to √g_eff.
        Only the layout of steps depends on this prediction.
        """
        if not self.feels_impulse:
            return math.inf
        at = outside_at(terms, x, work)
        now = self.instant(mode_of(state), omega, planes_of(omega, state.planes), at)
        way = float(state.direction if state.armed else -state.direction)
        pace = self.pace * math.sqrt(at.gravity / self.on_wheel.gravity)
        shift = now.bend / (pace * pace)
        centre = now.angle + shift
        ahead = phase_to(way, -shift, now.rate / pace, self.impulse - way * centre)
        if ahead < math.inf:
            then = outside_at(terms, min(x + ahead / (pace * length), 1.0), work)
            pace *= math.sqrt(0.5 * (1.0 + then.gravity / at.gravity))
        return (ahead + OVERSHOOT) / pace


@inlined
def drag_on_wheel(on_wheel: OnWheel, mode: Mode, rate: Numeric) -> Numeric:
    """Return the torques of drag and recoil, reversed, over I: c₁ θ̇ + c₂ d θ̇² + R s."""
    drag = rate * fma(on_wheel.quadratic * mode.direction, rate, on_wheel.viscous)
    law = law_torque(on_wheel.law, rate, mode)
    if on_wheel.share is not None:
        law = on_wheel.share * law
    return drag + term(on_wheel.recoil, mode.pallet) + law


@inlined
def thermal_on_wheel(cold: OnWheel, hot: HeatTerms) -> OnWheel:
    """Return the terms on the wheel as heat changes them, at an instant or at the nodes."""
    share = hot.share
    return OnWheel(
        hot.viscous,
        cold.quadratic * share,
        cold.energy * share,
        None if cold.recoil is None else cold.recoil * share,
        cold.impulse,
        cold.pace,
        cold.gravity,
        cold.law,
        None,
        share,
        hot.growth,
    )


@compiled
def exits_by(tension: Lanes, margin: Lanes, coordinate: Lanes, work: Work) -> Exits:
    """Return whether a step leaves the range, from tension, margin and coordinate at its nodes."""
    edge, slack = first_below(margin, work), first_below(tension, work)
    is_within = lowest(margin) > WELL_WITHIN and lowest(tension) > 0.0
    return Exits(edge, slack, is_within, largest(coordinate), near_zero(tension))


@compiled
def case_bounds(pieces: ForcingPieces, k: int) -> tuple[float, float]:
    """Return bounds of the case's angle α = β − τ [rad] and of α̇ [rad/s] over piece k."""
    return bounds_of(pieces.drive, k, 1.0 / pieces.length_s[k], pieces.tilt)


@compiled
def transverse(gravity: float, tilt: float) -> float:
    """Return the weight's acceleration across the apparent vertical, to port [m/s²], mostly 0.

    Near weightlessness g_eff and β come from a force with z̃ in place of z, upwards in the case
    (`ship.kernels.force_of`). A swinging thread and a lever do not follow β, hence their weight
    senses the whole force. With z̃ = ½a (1 + e^(2z/a − 2)), z solves

        z + z̃ tan² τ = g_eff/cos τ,    and the transverse part is (z̃ − z) sin τ.
    """
    # mostly this test suffices, since cos τ ≥ 1 − τ²/2
    if gravity * (1.0 - 0.5 * tilt * tilt) >= LEAST_UPWARD:
        return 0.0
    sine, cosine = math.sin(tilt), math.cos(tilt)
    if gravity * cosine >= LEAST_UPWARD:
        return 0.0
    square, apparent_gravity = (sine / cosine) ** 2, gravity / cosine
    # convex and increasing in z, and z is below this start: Newton's method descends to it
    z, upward = LEAST_UPWARD, LEAST_UPWARD
    for _ in range(MOST_ITERATIONS):
        growth = math.exp(2.0 * (z / LEAST_UPWARD - 1.0))
        upward = 0.5 * LEAST_UPWARD * (1.0 + growth)
        change = (z + upward * square - apparent_gravity) / (1.0 + growth * square)
        z -= change
        if abs(change) <= SETTLED * (abs(z) + LEAST_UPWARD):
            break
    upward = 0.5 * LEAST_UPWARD * (1.0 + math.exp(2.0 * (z / LEAST_UPWARD - 1.0)))
    return (upward - z) * sine


@compiled
def transverse_at_nodes(gravity: Lanes, tilt: Lanes, work: Work) -> Lanes:
    """Return `transverse` at the nodes."""
    values = filled(gravity, 0.0)
    steepest = largest(tilt)
    if lowest(gravity) * (1.0 - 0.5 * steepest * steepest) >= LEAST_UPWARD:
        return values
    for i in range(width(work.fractions)):
        values = with_lane(values, i, transverse(lane(gravity, i), lane(tilt, i)))
    return values


# -----------------------------------------------------------------------------
# The swinging thread in two rotating planes: its normal modes of small swings.
#
# The absolute angles of wheel and thread are ψ = Σ E_ψi X_i and δ = Σ E_δi X_i with Ẋ_i = ω_i Y_i,
# i = 1, 2. The nonlinear terms of (threads.1) and the ship's motion disturb the planes. The
# accelerated axle enters through the apparent gravity alone (machine_at_sea.md). Of the ship's
# derivatives only α̇, the rate of the case, is needed, for the drag.

THREAD_NODES = 'vertical', 'gravity', 'transverse', 'alpha_rate'
"""Rows of the nodes: β, g_eff, the transverse acceleration, and α̇."""

SPRING_NODES = ('tilt',)
"""Row of the nodes: τ = β − α, if a spring of the case draws the weight."""


class _ThreadNumbers(NamedTuple):
    """The constants of the equations.

    Attributes:
        radius: r of the involute [m].
        length: l₀ of the free thread at rest [m].
        least: free thread at the end of the range [m].
        ratio: m r/I [1/m].
        wheel: E_ψ1 and E_ψ2.
        thread: E_δ1 and E_δ2.
        to_first: X₁ per ψ and per δ, the first row of the inverse of (E_ψ, E_δ).
        to_second: X₂ per ψ and per δ.
        on_wheel: terms on the wheel other than the thread.
        damping: c/m of the lean [m2/s], or `None`.
        widening: ṙ [m/s] if heat changes the parameters.
        spring: κ/m of a spring that draws the weight [1/s2], or `None`.
    """

    radius: float
    length: float
    least: float
    ratio: float
    wheel: tuple[float, float]
    thread: tuple[float, float]
    to_first: tuple[float, float]
    to_second: tuple[float, float]
    on_wheel: OnWheel
    damping: float | None = None
    widening: float | None = None
    spring: float | None = None


class Hanging(_ThreadNumbers, ThreadSystem):
    """The swinging thread as `system.System`."""

    @inlined
    def heated(self, hot: HeatTerms) -> Hanging:
        """Return the thread with parameters as heat changes them."""
        return Hanging(
            hot.carried,
            self.length,
            self.least,
            hot.weight,
            self.wheel,
            self.thread,
            self.to_first,
            self.to_second,
            thermal_on_wheel(self.on_wheel, hot),
            self.damping,
            hot.force,
            self.spring,
        )

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill β, g_eff, the transverse acceleration, and α̇."""
        x, nodes = nodes_of(place, work), work.nodes
        tilt = column_at(TILT, place.terms, x, work)
        gravity = column_at(APPARENT_GRAVITY, place.terms, x, work)
        store(nodes.vertical, 0, column_at(DRIVE, place.terms, x, work))
        store(nodes.gravity, 0, gravity)
        store(nodes.transverse, 0, transverse_at_nodes(gravity, tilt, work))
        store(nodes.alpha_rate, 0, difference(DRIVE_RATE, TILT_RATE, place.terms, x, work))
        if self.spring is not None:
            store(nodes.tilt, 0, tilt)
        if self.on_wheel.heat is not None:
            fill_hot(x, work)

    @inlined
    def keep_case(
        self, swing: FreeHalfSwing, k: int, at: Lanes, times: Lanes, initial: bool, work: Work
    ) -> None:
        """Keep the rows of `at_nodes` at the nodes of an event-to-event step, from x of span k."""
        nodes = work.nodes
        vertical = gravity = rate = tilt = filled(work.fractions, 0.0)
        for j in range(swing.powers - 1, -1, -1):
            vertical = fma(vertical, at, swing.coefficient(DRIVE, k, j))
            gravity = fma(gravity, at, swing.coefficient(APPARENT_GRAVITY, k, j))
            rate = fma(
                rate, at, swing.coefficient(DRIVE_RATE, k, j) - swing.coefficient(TILT_RATE, k, j)
            )
            tilt = fma(tilt, at, swing.coefficient(TILT, k, j))
        keep(nodes.vertical, times, initial, vertical)
        keep(nodes.gravity, times, initial, gravity)
        keep(nodes.alpha_rate, times, initial, rate)
        # the tilt until `complete_case`
        keep(nodes.transverse, times, initial, tilt)

    @inlined
    def complete_case(self, work: Work) -> None:
        """Turn the tilt at the nodes into the transverse acceleration."""
        nodes, tilt = work.nodes, row_of(work.nodes.transverse)
        if self.spring is not None:
            store(nodes.tilt, 0, tilt)
        store(nodes.transverse, 0, transverse_at_nodes(row_of(nodes.gravity), tilt, work))

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill d2 from the accelerations. d1 stays zero."""
        psi_bend, delta_bend, _, _ = _at_stages(self, mode, omega, work)
        bends = _modes(self, psi_bend, delta_bend)
        for p in range(len(omega)):
            store(work.d2, p, omega[p] * row_of(work.x, p) + bends[p] * (1.0 / omega[p]))

    def exits(self, mode: Mode, omega: Omega, work: Work) -> Exits:
        """Return whether the step winds up the whole thread, or the thread goes slack."""
        _, _, tension, free = _at_stages(self, mode, omega, work)
        return exits_by(tension, free - self.least, self.coordinates(work), work)

    def coordinates(self, work: Work) -> Lanes:
        """Return u = ψ − δ at the nodes."""
        psi, delta = _angles(self, row_of(work.x, 0), row_of(work.x, 1))
        return psi - delta

    def coordinate(self, planes: tuple[Plane, ...]) -> float:
        """Return u."""
        psi, delta = _angles(self, planes[0].x, planes[1].x)
        return psi - delta

    def clear_square(
        self, omega: Omega, pieces: ForcingPieces, k: int, besides: float = 0.0
    ) -> float:
        """Return a bound of α² + (α̇/ω)² over piece k, ω the frequency of the swing.

        With `besides`, the square of (the bound's root + that angle).
        """
        value, rate = case_bounds(pieces, k)
        rate = rate / self.pace
        square = value * value + rate * rate
        if besides > 0.0:
            reach = math.sqrt(square) + besides
            square = reach * reach
        return square

    def clear(self, square: float, omega: Omega, work: Work) -> bool:
        """Return whether at all nodes u swings wider than θ − u = δ − α can.

        Widths are measured in the phase plane, |(u, u̇/ω)|.
        """
        (psi, delta), (psi_rate, delta_rate) = _stages(self, omega, work)
        u, u_rate = psi - delta, (psi_rate - delta_rate) * (1.0 / self.pace)
        inclined = largest(delta * delta + delta_rate * delta_rate * (1.0 / self.pace**2))
        bound = math.sqrt(inclined) + math.sqrt(square)
        return lowest(u * u + u_rate * u_rate) > CLEAR * (bound * bound)

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Inputs) -> Instant:
        """Return wheel and thread at an instant."""
        line, tilt, hot = at.drive, at.tilt, heated_now(self, at)
        psi, delta = _angles(self, planes[0].x, planes[1].x)
        rates = _angles(self, omega[0] * planes[0].y, omega[1] * planes[1].y)
        rate = rates[0] - (line.rate - tilt.rate)
        drag = drag_on_wheel(hot.on_wheel, mode, rate)
        lean, turn = delta - line.value, line.rate - tilt.rate
        cosine, sine = math.cos(lean), math.sin(lean)
        aside = transverse(at.gravity, tilt.value)
        down, across = at.gravity * cosine + aside * sine, at.gravity * sine - aside * cosine
        if hot.spring is not None:
            in_case = lean + tilt.value
            drawn = hot.spring * _risen(
                hot, psi - delta, math.sin(in_case), 2.0 * math.sin(0.5 * in_case) ** 2
            )
            down, across = down + drawn * math.cos(in_case), across + drawn * math.sin(in_case)
        psi_bend, delta_bend, tension, free = _pushed(
            hot, psi, delta, rates, down, across, drag, turn
        )
        torque = psi_bend + drag
        if hot.on_wheel.growth is not None and hot.on_wheel.share is not None:
            # over the cold I, as in the rows
            torque = (torque + hot.on_wheel.growth * rates[0]) / hot.on_wheel.share
        return Instant(
            angle=psi - (line.value - tilt.value),
            rate=rate,
            bend=psi_bend - (line.bend - tilt.bend),
            tension=tension,
            margin=free - self.least,
            torque=torque,
            coordinate=psi - delta,
            speed=rates[0] - rates[1],
            acceleration=psi_bend - delta_bend,
        )

    def drift(self, mode: Mode, omega: Omega, at: Inputs, now: Instant) -> tuple[Plane, ...]:
        """Return Ẋ and ωẎ of each mode."""
        psi_rate = now.rate + (at.drive.rate - at.tilt.rate)
        psi_bend = now.bend + (at.drive.bend - at.tilt.bend)
        rates = _modes(self, psi_rate, psi_rate - now.speed)
        bends = _modes(self, psi_bend, psi_bend - now.acceleration)
        return Plane(rates[0], bends[0]), Plane(rates[1], bends[1])

    def wheel_angle(self, planes: tuple[Plane, ...], at: Inputs) -> float:
        """Return θ = ψ − α."""
        psi, _ = _angles(self, planes[0].x, planes[1].x)
        return psi - (at.drive.value - at.tilt.value)

    def strike(
        self, mode: Mode, omega: Omega, at: Inputs, now: Instant, state: RunningState
    ) -> None:
        """Let an impulse change both rates: the taut thread's by −r/l of the wheel's.

        The energy goes into ½(I + m r²u²)θ̇².
        """
        hot, u, planes = heated_now(self, at), now.coordinate, state.planes
        radius = hot.radius
        mass = 1.0 + hot.ratio * radius * u * u
        struck = mode.direction * math.sqrt(now.rate * now.rate + hot.on_wheel.energy / mass)
        kick = struck - now.rate
        thread_kick = -radius / (self.length - 0.5 * radius * u * u) * kick
        first_mode, second = _modes(self, kick, thread_kick)
        planes[0].y += first_mode / omega[0]
        planes[1].y += second / omega[1]
        planes[0].y_rest = planes[1].y_rest = 0.0


@inlined
def _angles(system: Hanging, first_mode: Numeric, second: Numeric) -> NumericPair:
    """Return ψ and δ from the modes' coordinates, or their rates from the modes' rates."""
    wheel, thread = system.wheel, system.thread
    return wheel[0] * first_mode + wheel[1] * second, thread[0] * first_mode + thread[1] * second


@inlined
def _stages(system: Hanging, omega: Omega, work: Work) -> tuple[NumericPair, NumericPair]:
    """Return ψ, δ and their rates at the stages."""
    angles = _angles(system, row_of(work.x, 0), row_of(work.x, 1))
    return angles, _angles(system, omega[0] * row_of(work.y, 0), omega[1] * row_of(work.y, 1))


@inlined
def _pushed(
    system: Hanging,
    psi: Numeric,
    delta: Numeric,
    rates: NumericPair,
    down: Numeric,
    across: Numeric,
    drag: Numeric,
    alpha_rate: Numeric,
) -> tuple[Numeric, Numeric, Numeric, Numeric]:
    """Return ψ̈ and δ̈ of (threads.1), the tension over m [m/s2] and the free thread l [m].

    `down` and `across` are the accelerations of the weight along and across the thread: g_eff
    cos(δ − β), g_eff sin(δ − β), the transverse part and the pull of a spring. `drag` is the
    torque of drag and recoil, reversed, over I. The damping of the lean needs α̇ of the case.
    """
    psi_rate, delta_rate = rates
    radius, u = system.radius, psi - delta
    free = system.length - (0.5 * radius) * (u * u)
    pulled = down + free * (delta_rate * delta_rate) + radius * (psi_rate * psi_rate)
    mass = 1.0 + (system.ratio * radius) * (u * u)
    turning = u * pulled
    wound = radius * (u * delta_rate) * (2.0 * psi_rate - delta_rate)
    if system.damping is not None:
        # −Q/(m l): only the lean loses energy, hence the wheel is pushed by −Q r/l
        lost = system.damping * (delta_rate - alpha_rate) / free
        turning, wound = turning - lost, wound - lost
    if system.widening is not None:
        # r grows, and the wound-up thread with it: 2ṙψ̇ across the thread, and along it 2ṙψ̇ −
        # ṙu²δ̇
        turning = turning + 2.0 * system.widening * (u * u) * psi_rate
        wound = wound - system.widening * (2.0 * psi_rate - (u * u) * delta_rate)
    against = system.ratio * turning + drag
    if system.on_wheel.growth is not None:
        against = against + system.on_wheel.growth * psi_rate
    psi_bend = -against / mass
    delta_bend = (wound - across - radius * psi_bend) / free
    return psi_bend, delta_bend, pulled + radius * (u * psi_bend), free


@inlined
def _modes(system: Hanging, psi: Numeric, delta: Numeric) -> NumericPair:
    """Return the modes' coordinates from ψ and δ, or their rates from ψ̇ and δ̇."""
    to_first, second = system.to_first, system.to_second
    return to_first[0] * psi + to_first[1] * delta, second[0] * psi + second[1] * delta


@inlined
def _at_stages(
    system: Hanging, mode: Mode, omega: Omega, work: Work
) -> tuple[Lanes, Lanes, Lanes, Lanes]:
    """Return ψ̈, δ̈, the tension over m and the free thread at the stages."""
    (psi, delta), rates = _stages(system, omega, work)
    system = heated_at_nodes(system, work)
    nodes = work.nodes
    lean = delta - row_of(nodes.vertical)
    sine, versine = sine_versine(lean)
    alpha_rate, gravity = row_of(nodes.alpha_rate), row_of(nodes.gravity)
    down, across = gravity * (1.0 - versine), gravity * sine
    if largest(row_of(nodes.transverse)) > 0.0:
        aside = row_of(nodes.transverse)
        down, across = down + aside * sine, across - aside * (1.0 - versine)
    if system.spring is not None:
        sine, versine = sine_versine(lean + row_of(nodes.tilt))
        drawn = system.spring * _risen(system, psi - delta, sine, versine)
        down, across = down + drawn * (1.0 - versine), across + drawn * sine
    drag = drag_on_wheel(system.on_wheel, mode, rates[0] - alpha_rate)
    return _pushed(system, psi, delta, rates, down, across, drag, alpha_rate)


@inlined
def _risen(system: Hanging, u: Numeric, sine: Numeric, versine: Numeric) -> Numeric:
    """Return the weight's rise above rest, along the case [m], from u and ε."""
    wound = (0.5 * system.radius) * (u * u)
    risen = (system.radius * u) * sine + (system.radius + system.length) * versine
    return risen + wound * (1.0 - versine)
