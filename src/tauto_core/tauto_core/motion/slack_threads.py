"""Sully's lever and the swinging thread while their threads are slack.

The wheel is free: ψ̈ = −(drag and recoil)/I. The lever falls about its fulcrum in the case,

    β̈ = −α̈ − (κ/√j) g_eff cos(β − τ),

with the letters of `lever`, and is slack while it is higher than β(θ), at which the thread would
hold it. The weight of a swinging thread falls freely beside the axle, Ẅ = g_eff (sin β, −cos β)
with the direction β of the apparent vertical, and what acts beside it (`beside`). A thread that
leaves the cam for the weight at W has the lean δ of W · n = r u, u = ψ − δ, with
n = (cos δ, sin δ) and d = (sin δ, −cos δ). It has to reach W · d − r and has l₀ − ½ r u² left:
slack while that is more.

Along the thread, with ρ = r u and v = −Ẇ · d, the momentum is shared,

    ψ̇⁺ = (I ψ̇⁻ + m ρ v)/(I + m ρ²),    δ̇⁺ = (Ẇ · n − r ψ̇⁺)/l,

and Ẇ · n stays as it is. Of the lever, with b = dβ/dθ and its inertia J = j I,
θ̇⁺ = (θ̇⁻ + j b β̇)/(1 + j b²).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.gauss_step import (
    Mode,
    Omega,
    Work,
    sine_versine,
)
from tauto_core.motion.lanes import (
    Numeric,
    filled,
    lane,
    largest,
    row_of,
    store,
    width,
    with_lane,
)
from tauto_core.motion.lever import LeverNodes, SullyLever, lever_now, lever_on_arc
from tauto_core.motion.slack import LooseSystem, Tautened, rounding_of
from tauto_core.motion.system import (
    Beyond,
    Instant,
    Outside,
    Plane,
    RunningState,
    StepPlace,
    first_below,
    hot_at_nodes,
    near_zero,
    planes_of,
)
from tauto_core.motion.threads import (
    MOST_ITERATIONS,
    SETTLED,
    Hanging,
    OnWheel,
    ThreadNodes,
    WithThread,
    beside,
    drag_on_wheel,
    hot_on_wheel,
    thread_now,
)
from tauto_core.motion.wells import whole_turns_off


class LooseOnWheel(WithThread, LooseSystem):
    """The base of a free wheel whose thread is slack."""

    def strike(
        self, mode: Mode, omega: Omega, at: Outside, now: Instant, state: RunningState
    ) -> None:
        """Let an impulse change the momentum of the wheel alone: ½ I θ̇² grows by its energy."""
        on_wheel, plane = self.on_wheel, state.planes[0]
        if on_wheel.heat is not None and at.hot is not None:
            on_wheel = hot_on_wheel(on_wheel, at.hot)
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


@inlined
def _on_wheel_at_nodes(on_wheel: OnWheel, work: Work) -> OnWheel:
    """Return the terms on the wheel at the nodes of a step."""
    return on_wheel if on_wheel.heat is None else hot_on_wheel(on_wheel, hot_at_nodes(work))


# -----------------------------------------------------------------------------
# The swinging thread. X of the three planes: ψ, and the place of the weight over l₀, across the
# vertical and above where it hangs at rest.


class _LooseThreadNumbers(NamedTuple):
    """The swinging thread that is slack; `thread` is the taut one."""

    thread: Hanging


class HangsAt(NamedTuple):
    """A slack thread as it leaves the cam for the weight.

    Attributes:
        delta: its lean δ [rad].
        reach: W · d − r, the way to the weight [m].
        free: its length free of the cam [m].
    """

    delta: float
    reach: float
    free: float


class LooseThread(_LooseThreadNumbers, LooseOnWheel):
    """A free wheel, and its weight that falls."""

    @property
    def on_wheel(self) -> OnWheel:
        """The terms on the wheel besides the thread."""
        return self.thread.on_wheel

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill β, g_eff and α̇."""
        self.thread.at_nodes(place, work)

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the disturbances of the planes' rotation."""
        nodes: ThreadNodes = work.nodes
        w = omega[0] * row_of(work.y, 0)
        rate = w - row_of(nodes.alpha_rate)
        against = _against(_on_wheel_at_nodes(self.on_wheel, work), mode, rate, w)
        store(work.d2, 0, omega[0] * row_of(work.x, 0) - against * (1.0 / omega[0]))
        sine, versine = sine_versine(whole_turns_off(row_of(nodes.vertical)))
        scale = 1.0 / (self.thread.length * omega[1])
        fall, aside = scale * row_of(nodes.gravity), scale * row_of(nodes.beside)
        cosine = 1.0 - versine
        store(work.d2, 1, omega[1] * row_of(work.x, 1) + (fall * sine + aside * cosine))
        store(work.d2, 2, omega[2] * row_of(work.x, 2) - (fall * cosine - aside * sine))

    def beyond(self, mode: Mode, omega: Omega, work: Work) -> Beyond:
        """Return whether the thread tautens in the step, or the weight comes up to the wheel."""
        gap = margin = filled(row_of(work.x), 0.0)
        for i in range(width(work.fractions)):
            radius = self.thread.radius
            if self.on_wheel.heat is not None:
                radius = lane(row_of(work.nodes.carried), i)
            psi = lane(row_of(work.x, 0), i)
            x, y = lane(row_of(work.x, 1), i), lane(row_of(work.x, 2), i)
            hangs = _hangs_at(self.thread, radius, psi, x, y)
            gap = with_lane(gap, i, _gap(self.thread, hangs))
            margin = with_lane(margin, i, _margin(self.thread, hangs))
        edge, slack = first_below(margin, work), first_below(gap, work)
        return Beyond(edge, slack, False, largest(row_of(work.x, 0)), near_zero(gap))

    def coordinate(self, planes: tuple[Plane, ...]) -> float:
        """Return u."""
        psi, x, y = planes[0].x, planes[1].x, planes[2].x
        return psi - _hangs_at(self.thread, self.thread.radius, psi, x, y).delta

    def wheel_angle(self, planes: tuple[Plane, ...], at: Outside) -> float:
        """Return θ = ψ − α."""
        return planes[0].x - (at.drive.value - at.tilt.value)

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Outside) -> Instant:
        """Return wheel and weight at an instant."""
        line, tilt, thread = at.drive, at.tilt, thread_now(self.thread, at)
        psi, psi_rate, length = planes[0].x, omega[0] * planes[0].y, thread.length
        rate = psi_rate - (line.rate - tilt.rate)
        psi_bend = -_against(thread.on_wheel, mode, rate, psi_rate)
        hangs = _hangs_at(thread, thread.radius, psi, planes[1].x, planes[2].x)
        aside = beside(at.gravity, tilt.value)
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

    def let_go(self, taut: Hanging, omega: Omega, at: Outside, now: Instant, free: Any) -> None:
        """Set wheel and weight to the motion of the taut thread."""
        alpha, alpha_rate = at.drive.value - at.tilt.value, at.drive.rate - at.tilt.rate
        thread, u = thread_now(taut, at), now.coordinate
        psi, psi_rate = now.angle + alpha, now.rate + alpha_rate
        delta, delta_rate = psi - u, psi_rate - now.speed
        radius, length = thread.radius, thread.length
        left = length - 0.5 * radius * u * u
        sine, cosine = math.sin(delta), math.cos(delta)
        turn_rate, along_rate = radius * psi_rate + left * delta_rate, -radius * u * psi_rate
        planes = free.planes
        planes[0].x, planes[0].y = psi, psi_rate / omega[0]
        # W = r u n + (r + l) d; its height is counted from −(r + l₀), where nothing cancels
        low = math.sin(0.5 * delta)
        planes[1].x = (radius * u * cosine + (radius + left) * sine) / length
        raised = radius * u * sine + 2.0 * (radius + left) * low * low + (length - left)
        planes[2].x = raised / length
        planes[1].y = (turn_rate * cosine + along_rate * sine) / (length * omega[1])
        planes[2].y = (turn_rate * sine - along_rate * cosine) / (length * omega[2])
        for p in range(3):
            planes[p].x_rest = planes[p].y_rest = 0.0

    def tauten(
        self, taut: Hanging, omega: Omega, taut_omega: Omega, at: Outside, free: Any, state: Any
    ) -> Tautened:
        """Share the momentum along the thread; across it the weight keeps its velocity."""
        thread, planes = thread_now(taut, at), planes_of(omega, free.planes)
        psi, psi_rate = planes[0].x, omega[0] * planes[0].y
        hangs = _hangs_at(thread, thread.radius, psi, planes[1].x, planes[2].x)
        across_rate = thread.length * omega[1] * planes[1].y
        up_rate = thread.length * omega[2] * planes[2].y
        u, (sine, cosine) = psi - hangs.delta, (math.sin(hangs.delta), math.cos(hangs.delta))
        lifted = up_rate * cosine - across_rate * sine
        turn_rate = across_rate * cosine + up_rate * sine
        arm, mu = thread.radius * u, thread.ratio / thread.radius
        mass, apart = 1.0 + mu * arm * arm, arm * psi_rate - lifted
        psi_rate = (psi_rate + mu * arm * lifted) / mass
        delta_rate = (turn_rate - thread.radius * psi_rate) / hangs.free
        first, second = taut.to_first, taut.to_second
        state.planes[0].x = first[0] * psi + first[1] * hangs.delta
        state.planes[1].x = second[0] * psi + second[1] * hangs.delta
        state.planes[0].y = (first[0] * psi_rate + first[1] * delta_rate) / taut_omega[0]
        state.planes[1].y = (second[0] * psi_rate + second[1] * delta_rate) / taut_omega[1]
        for p in range(2):
            state.planes[p].x_rest = state.planes[p].y_rest = 0.0
        rate = psi_rate - (at.drive.rate - at.tilt.rate)
        return Tautened(rate, psi_rate - delta_rate, mu * apart * apart / mass)


@compiled
def _hangs_at(thread: Hanging, radius: float, psi: float, x: float, y: float) -> HangsAt:
    """Return how the thread hangs, by ψ and X of the weight's planes."""
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
    return HangsAt(delta, along - radius, length - 0.5 * radius * u * u)


@inlined
def _gap(thread: Hanging, hangs: HangsAt) -> float:
    """Return by how much the thread is longer than its way, over l₀."""
    return (hangs.free - hangs.reach) / thread.length + rounding_of(hangs.delta, 1.0)


@inlined
def _margin(thread: Hanging, hangs: HangsAt) -> float:
    """Return the shorter of the thread and its way, less the least of it [m]."""
    return min(hangs.free, hangs.reach) - thread.least


# -----------------------------------------------------------------------------
# Sully's lever. X = θ and ωY = ψ̇ of the wheel, X = √j β and ωY = √j (β̇ + α̇) of the lever, whose β
# is that of the series: with the fulcrum to port it is reversed.


class _LooseLeverNumbers(NamedTuple):
    """The lever whose thread is slack; `lever` is the taut one."""

    lever: SullyLever


class HeldAt(NamedTuple):
    """The taut lever at an angle of the wheel: s, n, w, χ′, and β of the series."""

    s: float
    n: float
    w: float
    chi_slope: float
    beta: float


class LooseLever(_LooseLeverNumbers, LooseOnWheel):
    """A free wheel, and the lever that falls."""

    @property
    def on_wheel(self) -> OnWheel:
        """The terms on the wheel besides the thread."""
        return self.lever.on_wheel

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill α̇, α̈ and the apparent gravity along and across the case."""
        self.lever.at_nodes(place, work)

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the disturbances of the planes' rotation."""
        nodes: LeverNodes = work.nodes
        root_j, alpha_rate = self.lever.root_j, row_of(nodes.alpha_rate)
        w, kappa = omega[0] * row_of(work.y, 0), self.lever.kappa + 0.0 * alpha_rate
        if self.on_wheel.heat is not None:
            kappa = row_of(work.nodes.weight)
        against = _against(_on_wheel_at_nodes(self.on_wheel, work), mode, w - alpha_rate, w)
        store(work.d1, 0, -alpha_rate)
        store(work.d2, 0, omega[0] * row_of(work.x, 0) - against * (1.0 / omega[0]))
        height = row_of(work.x, 1)
        sine, versine = sine_versine(whole_turns_off(height * (1.0 / root_j)))
        gravity = row_of(nodes.g_up) * (1.0 - versine) + row_of(nodes.g_across) * sine
        store(work.d1, 1, -(root_j * alpha_rate))
        store(work.d2, 1, omega[1] * height - kappa * gravity * (1.0 / omega[1]))

    def beyond(self, mode: Mode, omega: Omega, work: Work) -> Beyond:
        """Return whether the thread tautens in the step, or the geometry ends."""
        gap = margin = filled(row_of(work.x), 0.0)
        for i in range(width(work.fractions)):
            held = _held_at(self.lever, lane(row_of(work.x, 0), i))
            height = lane(row_of(work.x, 1), i)
            gap = with_lane(gap, i, _above(self.lever, held, height))
            margin = with_lane(margin, i, _within(self.lever, held, height))
        edge, slack = first_below(margin, work), first_below(gap, work)
        return Beyond(edge, slack, False, largest(row_of(work.x, 0)), near_zero(gap))

    def wheel_angle(self, planes: tuple[Plane, ...], at: Outside) -> float:
        """Return θ."""
        return planes[0].x

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Outside) -> Instant:
        """Return wheel and lever at an instant."""
        tilt, lever, theta = at.tilt, lever_now(self.lever, at), planes[0].x
        alpha_rate, alpha_bend = at.drive.rate - tilt.rate, at.drive.bend - tilt.bend
        psi_rate, height = omega[0] * planes[0].y, planes[1].x
        rate, held = psi_rate - alpha_rate, _held_at(lever, theta)
        psi_bend = -_against(lever.on_wheel, mode, rate, psi_rate)
        bend, speed = psi_bend - alpha_bend, rate / held.n
        above = height / lever.root_j - tilt.value
        gravity = at.gravity * math.cos(above) + beside(at.gravity, tilt.value) * math.sin(above)
        fall = lever.kappa * gravity
        height_rate = omega[1] * planes[1].y - lever.root_j * alpha_rate
        return Instant(
            angle=theta,
            rate=rate,
            bend=bend,
            tension=_above(lever, held, height),
            margin=_within(lever, held, height),
            torque=0.0,
            coordinate=held.s,
            speed=speed,
            acceleration=(bend + held.w * held.chi_slope * speed * speed) / held.n,
            drift=(Plane(rate, psi_bend), Plane(height_rate, -fall)),
        )

    def let_go(self, taut: SullyLever, omega: Omega, at: Outside, now: Instant, free: Any) -> None:
        """Set wheel and lever to the motion of the taut thread."""
        alpha_rate, planes, root_j = at.drive.rate - at.tilt.rate, free.planes, taut.root_j
        arc, angle = lever_on_arc(taut.shape, now.coordinate)
        planes[0].x, planes[0].y = angle, (now.rate + alpha_rate) / omega[0]
        planes[1].x = root_j * math.atan2(arc.sine, arc.cosine)
        planes[1].y = (arc.w * now.speed + root_j * alpha_rate) / omega[1]
        for p in range(2):
            planes[p].x_rest = planes[p].y_rest = 0.0

    def tauten(
        self,
        taut: SullyLever,
        omega: Omega,
        taut_omega: Omega,
        at: Outside,
        free: Any,
        state: Any,
    ) -> Tautened:
        """Share the momentum along the thread: ṡ⁺ = n θ̇ + w √j β̇, (n, w) being a unit vector."""
        planes, root_j = planes_of(omega, free.planes), taut.root_j
        alpha_rate, plane = at.drive.rate - at.tilt.rate, state.planes[0]
        held = _held_at(taut, planes[0].x)
        rate = omega[0] * planes[0].y - alpha_rate
        height_rate = omega[1] * planes[1].y - root_j * alpha_rate
        speed, apart = held.n * rate + held.w * height_rate, held.w * rate - held.n * height_rate
        a = held.n + root_j * held.w
        plane.x, plane.y = held.s, (speed + a * alpha_rate) / taut_omega[0]
        plane.x_rest = plane.y_rest = 0.0
        return Tautened(held.n * speed, speed, apart * apart)


@compiled
def _held_at(lever: SullyLever, theta: float) -> HeldAt:
    """Return the taut lever at θ, or at the end of the geometry if θ is beyond it."""
    whole = lever.shape.whole
    low, high = whole.middle - whole.half, whole.middle + whole.half
    s = min(max(theta, low), high)
    for _ in range(MOST_ITERATIONS):
        arc, angle = lever_on_arc(lever.shape, s)
        # n = dθ/ds is at most 1, so that the way is never shorter
        moved = min(max(s + (theta - angle) / arc.n, low), high)
        change = abs(moved - s)
        s = moved
        if change <= SETTLED:
            break
    arc, _ = lever_on_arc(lever.shape, s)
    return HeldAt(s, arc.n, arc.w, arc.chi_slope, math.atan2(arc.sine, arc.cosine))


@inlined
def _above(lever: SullyLever, held: HeldAt, height: float) -> float:
    """Return by how much the lever is higher than the thread would hold it, times √j."""
    above = height - lever.root_j * held.beta
    return (above if lever.mirrored is None else -above) + rounding_of(held.s, height)


@inlined
def _within(lever: SullyLever, held: HeldAt, height: float) -> float:
    """Return a margin: of the arc, and of a lever that is not thrown over."""
    whole = lever.shape.whole
    x = (held.s - whole.middle) / whole.half
    over = 0.5 * math.pi - abs(height / lever.root_j - held.beta)
    return min(1.0 - x * x, over)
