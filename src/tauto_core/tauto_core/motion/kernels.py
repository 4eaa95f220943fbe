"""The collocation engine: compiled kernels, one file so that the cache on disk follows it.

Absent terms are `None`: numba compiles them away, they are not in the code that runs.

Variables per unit of inertia: ψ, the wheel's absolute angle, and w = p/I with the momentum
p = (I + m t²) ψ̇ − m t² γ̇ (theory E2 in Hamilton's form: no second derivative of the forcing):

    ψ̇ = (w + μ t² γ̇) / (1 + μ t²)                                          μ = m/I
    ẇ = −pull · t + μ t t' (ψ̇ − γ̇)² − (c₁ v + c₂ d v² + c₀ d)/I              v = ψ̇ − α̇_c = θ̇

with t the lever arm at ϑ = ψ − γ, pull = F/I and d the sign of θ̇, constant between the events.

What goes together travels together: `machine` is (μ, force, stiffness, weight, viscous, quadratic,
coulomb, escapement), each over I or None; `well` (machine, lever); `mode` (side of the kink, d);
`place` (forcing, piece k, x₀, length in x) of a step; `limits` (impulse angle, edge of the cam);
`at` what `_at` returns; `work` the rows below, one entry a stage.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numba.extending import overload

from tauto_core.curves.levers import ArcLever, LinearLever
from tauto_core.motion.gauss import COLUMNS, NODES, PROJECTION, STAGES, WEIGHTS

OK, EDGE, SLACK, NO_CONVERGENCE = 0, 1, 2, 3
NO_EVENT, TURNING, KINK, IMPULSE, AT_EDGE, AT_SLACK = 0, 1, 2, 3, 4, 5
PSI, W, HELD_ANGLE, LAST_ANGLE, LAST_RATE, FLOATS = 0, 1, 2, 3, 4, 5
DIRECTION, SIDE, ARMED, HELD, THETA_SIGN, TURNS, BEATS, LEVEL, INTS = 0, 1, 2, 3, 4, 5, 6, 7, 8
ROW = 8
MAX_EVENTS = 10_000
MAX_STALLED = 4
COARSEN = 1e-4
MAX_LEVEL = 24
MAX_ITERATIONS = 60
ROUNDING = 2.0**-53

compiled = njit(cache=True, nogil=True, error_model='numpy')


@compiled
def _horner(coefficients: Any, k: int, x: float) -> tuple[float, float, float]:
    """Return Σ c_kj x^j and its first two derivatives in x."""
    value = first = half_second = 0.0
    for j in range(coefficients.shape[1] - 1, -1, -1):
        half_second = half_second * x + first
        first = first * x + value
        value = value * x + coefficients[k, j]
    return value, first, 2.0 * half_second


@compiled
def _piece(knots: Any, size: float) -> int:
    """Return the piece of a spline that holds, or is nearest to, an angle ≥ 0."""
    return min(int(np.searchsorted(knots, size, 'right')) - 1, len(knots) - 2)


def lever_terms(lever: Any, side: float, q: float) -> tuple[float, float, float]:
    """Return t, t' and t'' at the cam angle q; `side` continues a kinked cam smoothly."""
    raise TypeError('lever_terms runs in compiled code only')


@overload(lever_terms, strict=False)
def _lever_terms(lever: Any, side: Any, q: Any) -> Any:
    if lever.instance_class is LinearLever:
        return lambda lever, side, q: (lever.rate * q, lever.rate, 0.0)
    if lever.instance_class is ArcLever:

        def arc(lever: Any, side: float, q: float) -> tuple[float, float, float]:
            sine, half = math.sin(q), math.sin(0.5 * q)
            sagitta = 2.0 * half * half
            cosine = 1.0 - sagitta
            return (
                lever.root_depth * sine + side * lever.radius * sagitta,
                lever.root_depth * cosine + side * lever.radius * sine,
                -lever.root_depth * sine + side * lever.radius * cosine,
            )

        return arc

    def table(lever: Any, side: float, q: float) -> tuple[float, float, float]:
        # Odd in q: t and t'' change sign with it.
        size = abs(q)
        k = _piece(lever.knots, size)
        value, first, second = _horner(lever.coefficients, k, size - lever.knots[k])
        sign = math.copysign(1.0, q)
        return sign * value, first, sign * second

    return table


def lever_lift(lever: Any, side: float, q: float) -> float:
    """Return h = ∫ t dϑ at the cam angle q."""
    raise TypeError('lever_lift runs in compiled code only')


@overload(lever_lift, strict=False)
def _lever_lift(lever: Any, side: Any, q: Any) -> Any:
    if lever.instance_class is LinearLever:
        return lambda lever, side, q: 0.5 * lever.rate * q * q
    if lever.instance_class is ArcLever:

        def arc(lever: Any, side: float, q: float) -> float:
            half = math.sin(0.5 * q)
            return 2.0 * lever.root_depth * half * half + side * lever.radius * (q - math.sin(q))

        return arc

    def table(lever: Any, side: float, q: float) -> float:
        size = abs(q)
        k = _piece(lever.knots, size)
        x = size - lever.knots[k]
        total = 0.0
        for j in range(lever.coefficients.shape[1] - 1, -1, -1):
            total = total * x + lever.coefficients[k, j] / (j + 1.0)
        return lever.lifts[k] + total * x

    return table


def kinked(lever: Any) -> bool:
    """Return whether the lever arm has a kink in its second derivative at ϑ = 0."""
    raise TypeError('kinked runs in compiled code only')


@overload(kinked, strict=False)
def _kinked(lever: Any) -> Any:
    if lever.instance_class is ArcLever:
        return lambda lever: True
    return lambda lever: False


@compiled
def _term(coefficient: Any, value: float) -> float:
    """Return coefficient · value; an absent term is −0.0, the sum's neutral element."""
    if coefficient is None:
        return -0.0
    return coefficient * value


@compiled
def _spring_term(stiffness: Any, lever: Any, side: float, q: float) -> float:
    if stiffness is None:
        return -0.0
    return stiffness * lever_lift(lever, side, q)


@compiled
def _line(coefficients: Any, k: int, x: float, per_s: float) -> tuple[float, float, float]:
    """Return a direction and its first two time derivatives; zeros on a platform at rest."""
    if coefficients is None:
        return 0.0, 0.0, 0.0
    value, first, second = _horner(coefficients, k, x)
    return value, first * per_s, second * per_s * per_s


@compiled
def _case_line(
    case: Any, neutral: Any, k: int, x: float, per_s: float
) -> tuple[float, float, float]:
    """Return the case's tilt: the neutral line's where the thread goes with the case."""
    if case is None:
        return _line(neutral, k, x, per_s)
    return _line(case, k, x, per_s)


@compiled
def _gravity(coefficients: Any, k: int, x: float) -> float:
    if coefficients is None:
        return 0.0
    return _horner(coefficients, k, x)[0]


@compiled
def _pull(well: Any, side: float, q: float, g_eff: float) -> float:
    """Return F/I."""
    machine, lever = well
    _, force, stiffness, weight, _, _, _, _ = machine
    return _term(force, 1.0) + _spring_term(stiffness, lever, side, q) + _term(weight, g_eff)


@compiled
def _drag(machine: Any, v: float, d: float) -> float:
    """Return the drag torque against the motion in the case, over I."""
    _, _, _, _, viscous, quadratic, coulomb, _ = machine
    return _term(viscous, v) + _term(quadratic, d * v * v) + _term(coulomb, d)


@compiled
def _mass(mu: Any, t: float) -> float:
    """Return M/I = 1 + μ t²."""
    if mu is None:
        return 1.0
    return 1.0 + mu * t * t


@compiled
def _velocity(mu: Any, t: float, w: float, line_rate: float) -> float:
    """Return ψ̇ from the momentum."""
    if mu is None:
        return w
    carried = mu * t * t
    return (w + carried * line_rate) / (1.0 + carried)


@compiled
def _momentum(mu: Any, t: float, velocity: float, line_rate: float) -> float:
    """Return w from ψ̇, the inverse of `_velocity`."""
    if mu is None:
        return velocity
    carried = mu * t * t
    return velocity + carried * (velocity - line_rate)


@compiled
def _ride(mu: Any, t: float, t1: float, q_rate: float) -> float:
    """Return what the weight's ride on the changing lever arm adds to ẇ."""
    if mu is None:
        return -0.0
    return mu * t * t1 * q_rate * q_rate


@compiled
def _ride_holding(mu: Any, t: float, t1: float, q_rate: float, q_acceleration: float) -> float:
    """Return μ t ḧ: the part of the thread's torque that moves the weight."""
    if mu is None:
        return -0.0
    return mu * t * (t1 * q_rate * q_rate + t * q_acceleration)


@compiled
def _acceleration(
    well: Any, mode: Any, psi: float, w: float, at: Any
) -> tuple[float, float, float, float, float, float]:
    """Return θ, θ̇, ϑ, ϑ̇, ϑ̈ and the thread's tension over I (0 or less: slack)."""
    machine, lever = well
    side, d = mode
    line, case, g_eff = at
    mu = machine[0]
    q = psi - line[0]
    t, t1, _ = lever_terms(lever, side, q)
    velocity = _velocity(mu, t, w, line[1])
    q_rate = velocity - line[1]
    v = velocity - case[1]
    pull = _pull(well, side, q, g_eff)
    q_acceleration = (-line[2] - _drag(machine, v, d) - pull * t - _ride(mu, t, t1, q_rate)) / (
        _mass(mu, t)
    )
    tension = pull + _term(mu, t1 * q_rate * q_rate + t * q_acceleration)
    return psi - case[0], v, q, q_rate, q_acceleration, tension


@compiled
def _holding_torque(well: Any, side: float, angle: float, at: Any) -> float:
    """Return the torque over I that keeps the wheel at `angle` in the moving case."""
    machine, lever = well
    line, case, g_eff = at
    q = angle + case[0] - line[0]
    t, t1, _ = lever_terms(lever, side, q)
    ride = _ride_holding(machine[0], t, t1, case[1] - line[1], case[2] - line[2])
    return case[2] + ride + _pull(well, side, q, g_eff) * t


@compiled
def _at(forcing: Any, k: int, x: float) -> Any:
    """Return (γ, γ̇, γ̈), (α, α̇, α̈) and the apparent gravity at x in piece k."""
    length, neutral, case, gravity = forcing
    per_s = 1.0 / length[k]
    return (
        _line(neutral, k, x, per_s),
        _case_line(case, neutral, k, x, per_s),
        _gravity(gravity, k, x),
    )


(
    K_PSI,
    K_W,
    STAGE_PSI,
    STAGE_W,
    LINE,
    LINE_RATE,
    CASE_RATE,
    G_EFF,
    COS,
    SIN,
    STEP,
    NEXT,
    LINE_BEND,
) = range(13)
WORK_ROWS = 13


@compiled
def _prepare_nodes(place: Any, omega: float, work: Any) -> None:
    """Evaluate the forcing at the nodes, and the rotation that starts the iteration."""
    forcing, k, x0, hx = place
    length, neutral, case, gravity = forcing
    per_s = 1.0 / length[k]
    h = hx * length[k]
    for i in range(STAGES):
        x = x0 + NODES[i] * hx
        line = _line(neutral, k, x, per_s)
        work[LINE, i] = line[0]
        work[LINE_RATE, i] = line[1]
        work[LINE_BEND, i] = line[2]
        work[CASE_RATE, i] = _case_line(case, neutral, k, x, per_s)[1]
        work[G_EFF, i] = _gravity(gravity, k, x)
    if work[STEP, 0] != h:
        work[STEP, 0] = h
        for i in range(STAGES):
            work[COS, i] = math.cos(omega * NODES[i] * h)
            work[SIN, i] = math.sin(omega * NODES[i] * h)


@compiled
def _force(well: Any, mode: Any, i: int, work: Any) -> float:
    """Return ẇ at stage i."""
    machine, lever = well
    side, d = mode
    mu = machine[0]
    q = work[STAGE_PSI, i] - work[LINE, i]
    t, t1, _ = lever_terms(lever, side, q)
    velocity = _velocity(mu, t, work[STAGE_W, i], work[LINE_RATE, i])
    pull = _pull(well, side, q, work[G_EFF, i])
    ride = _ride(mu, t, t1, velocity - work[LINE_RATE, i])
    return ride - pull * t - _drag(machine, velocity - work[CASE_RATE, i], d)


@compiled
def _guess(well: Any, mode: Any, omega: float, start: Any, work: Any) -> None:
    """Fill the stages from the undisturbed rotation about the neutral line."""
    machine, lever = well
    side = mode[0]
    q0, q_rate0 = start
    mu = machine[0]
    for i in range(STAGES):
        q = q0 * work[COS, i] + q_rate0 / omega * work[SIN, i]
        q_rate = q_rate0 * work[COS, i] - q0 * omega * work[SIN, i]
        t, _, _ = lever_terms(lever, side, q)
        work[STAGE_PSI, i] = q + work[LINE, i]
        velocity = q_rate + work[LINE_RATE, i]
        work[STAGE_W, i] = _momentum(mu, t, velocity, work[LINE_RATE, i])
        work[K_W, i] = _force(well, mode, i, work)


@compiled
def _quadrature(start: float, slopes: int, stages: int, work: Any) -> None:
    """Fill row `stages` with start + h Σ_j a_ij · (row `slopes`)_j; the order vectorises."""
    h = work[STEP, 0]
    for i in range(STAGES):
        work[stages, i] = 0.0
    for j in range(STAGES):
        slope = work[slopes, j]
        for i in range(STAGES):
            work[stages, i] += COLUMNS[j, i] * slope
    for i in range(STAGES):
        work[stages, i] = start + h * work[stages, i]


@compiled
def _sweep(well: Any, mode: Any, psi: float, w: float, work: Any) -> float:
    """Iterate the stage equations once, momenta before angles; return the largest change."""
    machine, lever = well
    side = mode[0]
    mu = machine[0]
    _quadrature(w, K_W, NEXT, work)
    for i in range(STAGES):
        work[STAGE_W, i] = work[NEXT, i]
        t, _, _ = lever_terms(lever, side, work[STAGE_PSI, i] - work[LINE, i])
        work[K_PSI, i] = _velocity(mu, t, work[STAGE_W, i], work[LINE_RATE, i])
    _quadrature(psi, K_PSI, NEXT, work)
    change = 0.0
    for i in range(STAGES):
        change = max(change, abs(work[NEXT, i] - work[STAGE_PSI, i]))
        work[STAGE_PSI, i] = work[NEXT, i]
    for i in range(STAGES):
        work[K_W, i] = _force(well, mode, i, work)
    return change


@compiled
def _collocate(
    well: Any, mode: Any, psi: float, w: float, place: Any, omega: float, work: Any
) -> tuple[float, float, float]:
    """Step over hx of piece k; return ψ, w at its end and the relative error indicator.

    The indicator is the last Legendre coefficient of ẇ: the error of the stage polynomial, of
    order 8, which bounds the error of the step, of order 16. It is infinite without convergence.
    """
    machine, lever = well
    forcing, k, x0, _ = place
    side = mode[0]
    _prepare_nodes(place, omega, work)
    line = _line(forcing[1], k, x0, 1.0 / forcing[0][k])
    t, _, _ = lever_terms(lever, side, psi - line[0])
    q_rate = _velocity(machine[0], t, w, line[1]) - line[1]
    _guess(well, mode, omega, (psi - line[0], q_rate), work)
    size = abs(psi) + abs(psi - line[0]) + abs(q_rate) / omega
    before = math.inf
    converged = False
    for _ in range(MAX_ITERATIONS):
        change = _sweep(well, mode, psi, w, work)
        converged = change <= 0.125 * ROUNDING * size or (
            change >= before and change <= 64.0 * ROUNDING * size
        )
        if converged or not change < 8.0 * before:
            break
        before = change
    h = work[STEP, 0]
    to_psi = to_w = last = fastest = 0.0
    for j in range(STAGES):
        to_psi += WEIGHTS[j] * work[K_PSI, j]
        to_w += WEIGHTS[j] * work[K_W, j]
        last += PROJECTION[STAGES - 1, j] * work[K_W, j]
        fastest = max(fastest, abs(work[STAGE_W, j]))
    scale = fastest + omega * size
    indicator = abs(h * last) / scale if scale > 0.0 else 0.0
    return psi + h * to_psi, w + h * to_w, indicator if converged else math.inf


@compiled
def _between(psi: float, w: float, xi: float, work: Any) -> tuple[float, float]:
    """Return ψ and w at the fraction xi of the step from the collocation polynomials."""
    h = work[STEP, 0]
    y = 2.0 * xi - 1.0
    older, old = 1.0, y
    integral = xi
    for n in range(STAGES):
        f_psi = f_w = 0.0
        for j in range(STAGES):
            f_psi += PROJECTION[n, j] * work[K_PSI, j]
            f_w += PROJECTION[n, j] * work[K_W, j]
        psi += h * f_psi * integral
        w += h * f_w * integral
        new = ((2 * n + 3) * y * old - (n + 1) * older) / (n + 2)
        integral = 0.5 * (new - older) / (2 * n + 3)
        older, old = old, new
    return psi, w


@compiled
def _event_value(kind: int, limits: Any, mode: Any, state: Any) -> float:
    """Return what is positive before an event and negative after it."""
    side, d = mode
    angle, v, q, _, _, tension = state
    impulse_angle, edge = limits
    if kind == TURNING:
        return d * v
    if kind == KINK:
        return side * q
    if kind == IMPULSE:
        return impulse_angle - d * angle
    if kind == AT_EDGE:
        return edge - abs(q)
    return tension


@compiled
def _locate(
    kind: int,
    limits: Any,
    well: Any,
    mode: Any,
    psi: float,
    w: float,
    place: Any,
    last: float,
    work: Any,
) -> float:
    """Return the fraction of the step at which an event's value falls to zero (Illinois)."""
    forcing, k, x0, hx = place
    a, fa, b, fb = 0.0, 0.0, last, 0.0
    for trial in range(4):
        a = 0.0 if trial == 0 else last * 0.25 ** (4 - trial)
        psi_a, w_a = _between(psi, w, a, work)
        at = _at(forcing, k, x0 + a * hx)
        state = _acceleration(well, mode, psi_a, w_a, at)
        fa = _event_value(kind, limits, mode, state)
        if fa > 0.0:
            break
    if not fa > 0.0:
        return 0.0
    psi_b, w_b = _between(psi, w, b, work)
    state = _acceleration(well, mode, psi_b, w_b, _at(forcing, k, x0 + b * hx))
    fb = min(_event_value(kind, limits, mode, state), 0.0)
    kept = 0
    for _ in range(100):
        x = (a * fb - b * fa) / (fb - fa)
        if b - a <= 4.0 * ROUNDING or not a < x < b:
            break
        psi_x, w_x = _between(psi, w, x, work)
        state = _acceleration(well, mode, psi_x, w_x, _at(forcing, k, x0 + x * hx))
        fx = _event_value(kind, limits, mode, state)
        if fx == 0.0:
            return x
        if fx > 0.0:
            a, fa = x, fx
            fb = 0.5 * fb if kept == 1 else fb
            kept = 1
        else:
            b, fb = x, fx
            fa = 0.5 * fa if kept == -1 else fa
            kept = -1
    return b


@compiled
def _watches_turning(machine: Any) -> bool:
    """Return whether something changes at the turning points or once a beat."""
    _, _, _, _, _, quadratic, coulomb, escapement = machine
    return quadratic is not None or coulomb is not None or escapement is not None


@compiled
def _node_tension(well: Any, mode: Any, q: float, i: int, work: Any) -> float:
    """Return the thread's tension over I at stage i."""
    machine, lever = well
    side, d = mode
    mu = machine[0]
    pull = _pull(well, side, q, work[G_EFF, i])
    t, t1, _ = lever_terms(lever, side, q)
    q_rate = work[K_PSI, i] - work[LINE_RATE, i]
    drag = _drag(machine, work[K_PSI, i] - work[CASE_RATE, i], d)
    pushed = work[LINE_BEND, i] + drag + pull * t + _ride(mu, t, t1, q_rate)
    return pull + _term(mu, t1 * q_rate * q_rate - t * pushed / _mass(mu, t))


@compiled
def _stage_limit(kind: int, edge: float, well: Any, mode: Any, work: Any) -> float:
    """Return the first node past the cam's edge or with a slack thread; 2 where none is."""
    for i in range(STAGES):
        q = work[STAGE_PSI, i] - work[LINE, i]
        if kind == AT_EDGE:
            if abs(q) > edge:
                return NODES[i]
        elif _node_tension(well, mode, q, i, work) <= 0.0:
            return NODES[i]
    return 2.0


@compiled
def _first_event(
    limits: Any,
    well: Any,
    mode: Any,
    armed: bool,
    stalled: bool,
    psi: float,
    w: float,
    end: Any,
    place: Any,
    work: Any,
) -> tuple[int, float]:
    """Return the kind of the first event within the step and its fraction of the step.

    What is reached before a turning point and left again after it is looked for at that point.
    """
    machine, lever = well
    forcing, k, x0, hx = place
    first, xi, reach = NO_EVENT, 2.0, 1.0
    for kind in range(IMPULSE if stalled else TURNING, AT_SLACK + 1):
        last = reach if _event_value(kind, limits, mode, end) <= 0.0 else 2.0
        if kind == TURNING and not _watches_turning(machine):
            continue
        if kind == KINK and not kinked(lever):
            continue
        if kind == IMPULSE and not armed:
            continue
        if kind == AT_SLACK and not _has_weight(machine):
            continue
        if kind >= AT_EDGE:
            last = min(last, _stage_limit(kind, limits[1], well, mode, work))
        if last <= 1.0:
            at = _locate(kind, limits, well, mode, psi, w, place, last, work)
            if at < xi:
                first, xi = kind, at
            if kind == TURNING:
                reach = at
                psi_t, w_t = _between(psi, w, at, work)
                end = _acceleration(well, mode, psi_t, w_t, _at(forcing, k, x0 + at * hx))
    return first, xi


@compiled
def _has_weight(machine: Any) -> bool:
    mu = machine[0]
    weight = machine[3]
    return mu is not None or weight is not None


@compiled
def _step_to_event(
    kind: int,
    xi: float,
    limits: Any,
    well: Any,
    mode: Any,
    psi: float,
    w: float,
    place: Any,
    omega: float,
    work: Any,
) -> tuple[float, float, float]:
    """Step to the event, correcting its time by the state found there; return ψ, w, fraction."""
    forcing, k, x0, hx = place
    psi_e, w_e = psi, w
    for _ in range(3):
        if xi <= 0.0:
            return psi, w, 0.0
        psi_e, w_e, _ = _collocate(well, mode, psi, w, (forcing, k, x0, xi * hx), omega, work)
        values = np.empty(2)
        for i in range(2):
            y = 1.0 - 1e-3 * i
            psi_y, w_y = (psi_e, w_e) if i == 0 else _between(psi, w, y, work)
            at = _at(forcing, k, x0 + xi * y * hx)
            state = _acceleration(well, mode, psi_y, w_y, at)
            values[i] = _event_value(kind, limits, mode, state)
        slope = (values[0] - values[1]) / (1e-3 * xi)
        if values[0] == 0.0 or not slope < 0.0:
            break
        corrected = xi - values[0] / slope
        if not 0.0 < corrected <= 1.0 or abs(corrected - xi) <= 2.0 * ROUNDING:
            break
        xi = corrected
    return psi_e, w_e, xi


@compiled
def _kick(escapement: Any, mu: Any, t: float, v: float, d: float) -> float:
    """Return what an impulse adds to θ̇: ½ M θ̇² grows by the energy (theory E2)."""
    if escapement is None:
        return 0.0
    return d * math.sqrt(v * v + escapement[0] / _mass(mu, t)) - v


@compiled
def _set_off(limits: Any, well: Any, angle: float, at: Any, floats: Any, ints: Any) -> None:
    """Decide at θ̇ = 0 whether friction holds the wheel, else which way it sets off."""
    machine, lever = well
    line, case, _ = at
    q = angle + case[0] - line[0]
    ints[SIDE] = 1 if q > 0.0 or (q == 0.0 and ints[SIDE] > 0) else -1
    torque = _holding_torque(well, float(ints[SIDE]), angle, at)
    if machine[6] is not None and abs(torque) <= _term(machine[6], 1.0):
        ints[HELD] = 1
        floats[HELD_ANGLE] = angle
        return
    ints[HELD] = 0
    if torque != 0.0:
        ints[DIRECTION] = -1 if torque > 0.0 else 1
    t, _, _ = lever_terms(lever, float(ints[SIDE]), q)
    floats[PSI] = angle + case[0]
    floats[W] = _momentum(machine[0], t, case[1], line[1])
    ints[ARMED] = 1 if ints[DIRECTION] * angle < limits[0] else 0


@compiled
def _happen(kind: int, limits: Any, well: Any, at: Any, floats: Any, ints: Any) -> None:
    """Change the discrete state at an event."""
    machine, lever = well
    mode = side, d = float(ints[SIDE]), float(ints[DIRECTION])
    state = _acceleration(well, mode, floats[PSI], floats[W], at)
    if kind == KINK:
        ints[SIDE] = -ints[SIDE]
    elif kind == IMPULSE:
        t, _, _ = lever_terms(lever, side, state[2])
        kick = _kick(machine[7], machine[0], t, state[1], d)
        floats[W] += _mass(machine[0], t) * kick
        ints[ARMED] = 0
    elif kind == TURNING:
        ints[DIRECTION] = -ints[DIRECTION]
        if machine[6] is not None:
            _set_off(limits, well, state[0], at, floats, ints)
        else:
            ints[ARMED] = 1 if ints[DIRECTION] * state[0] < limits[0] else 0


@compiled
def _count(well: Any, at: Any, floats: Any, ints: Any) -> None:
    """Count the turns of (ϑ, −ϑ̇) about the origin and the passages of θ through zero.

    A turn goes from the state last counted, not from the state as the next piece of forcing sees
    it: the two differ where the pieces do not join smoothly, and a turn between them were lost.
    """
    mode = float(ints[SIDE]), float(ints[DIRECTION])
    state = _acceleration(well, mode, floats[PSI], floats[W], at)
    angle, x0, y0, x1, y1 = state[0], floats[LAST_ANGLE], -floats[LAST_RATE], state[2], -state[3]
    if (y0 < 0.0) != (y1 < 0.0) and x0 + (x1 - x0) * y0 / (y0 - y1) < 0.0:
        ints[TURNS] += 1 if y1 < 0.0 else -1
    floats[LAST_ANGLE], floats[LAST_RATE] = state[2], state[3]
    if angle != 0.0:
        sign = 1 if angle > 0.0 else -1
        if ints[THETA_SIGN] == -sign:
            ints[BEATS] += 1
        ints[THETA_SIGN] = sign


@compiled
def _hold(limits: Any, well: Any, place: Any, floats: Any, ints: Any) -> float:
    """Let the held wheel ride with the case; return the fraction at which it breaks loose."""
    machine, lever = well
    forcing, k, x0, hx = place
    angle = floats[HELD_ANGLE]
    side = float(ints[SIDE])
    limit = _term(machine[6], 1.0)
    probes = 1 if forcing[1] is None and forcing[3] is None else 2 * STAGES
    for i in range(1, probes + 1):
        b = i / probes
        at = _at(forcing, k, x0 + b * hx)
        if abs(_holding_torque(well, side, angle, at)) > limit:
            a = (i - 1) / probes
            for _ in range(60):
                middle = 0.5 * (a + b)
                at = _at(forcing, k, x0 + middle * hx)
                loose = abs(_holding_torque(well, side, angle, at)) > limit
                a, b = (a, middle) if loose else (middle, b)
            _set_off(limits, well, angle, _at(forcing, k, x0 + b * hx), floats, ints)
            return b
    at = _at(forcing, k, x0 + hx)
    q = angle + at[1][0] - at[0][0]
    t, _, _ = lever_terms(lever, side, q)
    floats[PSI] = angle + at[1][0]
    floats[W] = _momentum(machine[0], t, at[1][1], at[0][1])
    return 1.0


@compiled
def _move(
    tolerance: float,
    limits: Any,
    well: Any,
    place: Any,
    omega: float,
    stalled: bool,
    floats: Any,
    ints: Any,
    work: Any,
) -> tuple[int, float, float]:
    """Advance over hx or to the first event; return the event, the fraction, the indicator."""
    forcing, k, x0, hx = place
    if ints[HELD]:
        return NO_EVENT, _hold(limits, well, place, floats, ints), 0.0
    mode = float(ints[SIDE]), float(ints[DIRECTION])
    psi, w = floats[PSI], floats[W]
    psi1, w1, indicator = _collocate(well, mode, psi, w, place, omega, work)
    if not indicator <= tolerance:
        return NO_EVENT, 0.0, indicator
    end = _acceleration(well, mode, psi1, w1, _at(forcing, k, x0 + hx))
    kind, xi = _first_event(
        limits, well, mode, ints[ARMED] == 1, stalled, psi, w, end, place, work
    )
    if kind == NO_EVENT:
        xi = 1.0
    else:
        psi1, w1, xi = _step_to_event(kind, xi, limits, well, mode, psi, w, place, omega, work)
    floats[PSI], floats[W] = psi1, w1
    return kind, xi, indicator


@compiled
def release(
    release_angle: float,
    limits: Any,
    well: Any,
    forcing: Any,
    x0: float,
    floats: Any,
    ints: Any,
    row: Any,
) -> None:
    """Set the state: the wheel at rest in the case at the beginning of the first span."""
    machine, lever = well
    at = _at(forcing, 0, x0)
    ints[:] = 0
    ints[SIDE] = ints[DIRECTION] = 1
    _set_off(limits, well, release_angle, at, floats, ints)
    if ints[HELD]:
        floats[PSI] = release_angle + at[1][0]
        t, _, _ = lever_terms(lever, float(ints[SIDE]), floats[PSI] - at[0][0])
        floats[W] = _momentum(machine[0], t, at[1][1], at[0][1])
    ints[THETA_SIGN] = 0 if release_angle == 0.0 else (1 if release_angle > 0.0 else -1)
    _write(well, at, floats, ints, row)
    floats[LAST_ANGLE], floats[LAST_RATE] = row[2], row[3]


@compiled
def _write(well: Any, at: Any, floats: Any, ints: Any, row: Any) -> None:
    lever = well[1]
    side = float(ints[SIDE])
    mode = side, 0.0 if ints[HELD] else float(ints[DIRECTION])
    angle, v, q, q_rate, q_acceleration, tension = _acceleration(
        well, mode, floats[PSI], floats[W], at
    )
    if ints[HELD]:
        angle, v, q_acceleration = floats[HELD_ANGLE], 0.0, at[1][2] - at[0][2]
    t, _, _ = lever_terms(lever, side, q)
    row[0], row[1], row[2], row[3], row[4] = angle, v, q, q_rate, q_acceleration
    row[5] = -tension * t
    row[6], row[7] = ints[TURNS], ints[BEATS]


@compiled
def advance(
    tolerance: float,
    omega: float,
    limits: Any,
    well: Any,
    forcing: Any,
    spans: Any,
    floats: Any,
    ints: Any,
    rows: Any,
) -> tuple[int, int, float]:
    """Advance the state over all spans and fill a row for every logged one.

    Returns a code (OK, EDGE, SLACK, NO_CONVERGENCE), the span and the fraction of its piece.
    """
    begin, end, logged = spans
    work = np.empty((WORK_ROWS, STAGES))
    work[STEP, 0] = math.nan
    written = 0
    for k in range(len(begin)):
        worst, events, stalled = 0.0, 0, 0
        whole = end[k] - begin[k]
        # Time is a cell and a fraction of it: it keeps its resolution in spans of a day.
        cell, cells, f = 0, 1 << ints[LEVEL], 0.0
        while cell < cells:
            kind, xi, indicator = _move(
                tolerance,
                limits,
                well,
                (forcing, k, begin[k] + (cell + f) / cells * whole, (1.0 - f) / cells * whole),
                omega,
                stalled > MAX_STALLED,
                floats,
                ints,
                work,
            )
            if not indicator <= tolerance:
                ints[LEVEL] += 1
                if ints[LEVEL] > MAX_LEVEL:
                    return NO_CONVERGENCE, k, begin[k] + (cell + f) / cells * whole
                half = 1 if f >= 0.5 else 0
                cell, cells, f = 2 * cell + half, 2 * cells, 2.0 * f - half
                continue
            worst = max(worst, indicator)
            reached = 1.0 if xi >= 1.0 else f + xi * (1.0 - f)
            stalled = stalled + 1 if reached == f else 0
            events = 0 if reached == 1.0 else events + 1
            cell, f = (cell + 1, 0.0) if reached == 1.0 else (cell, reached)
            x = end[k] if cell == cells else begin[k] + (cell + f) / cells * whole
            if kind in (AT_EDGE, AT_SLACK):
                return (EDGE if kind == AT_EDGE else SLACK), k, x
            at = _at(forcing, k, x)
            _happen(kind, limits, well, at, floats, ints)
            _count(well, at, floats, ints)
            if events > MAX_EVENTS:
                return NO_CONVERGENCE, k, x
        if ints[LEVEL] > 0 and worst < tolerance * COARSEN:
            ints[LEVEL] -= 1
        if logged[k]:
            _write(well, _at(forcing, k, end[k]), floats, ints, rows[written])
            written += 1
    return OK, 0, 0.0


@compiled
def _applied(row: Any, coefficients: Any, k: int) -> float:
    """Return row · coefficients of piece k; 0 on a platform at rest."""
    if coefficients is None:
        return 0.0
    total = 0.0
    for j in range(len(row)):
        total += row[j] * coefficients[k, j]
    return total


@compiled
def turn_and_add(
    omega: float,
    delta: float,
    steps: Any,
    responses: Any,
    frame: Any,
    length: Any,
    neutral: Any,
    y: Any,
    lost: Any,
    angle: Any,
    rate: Any,
) -> None:
    """Advance Y_{n+1} = e^{−δh} (Y_n + e^{−iωt_n} b_n) and fill θ, θ̇ at the ends of the steps.

    Complex numbers are pairs. The additions are compensated (Kahan; `lost` is carried on), so
    that ten million of them cost no digit.
    """
    piece, end, decay, kind = steps
    for n in range(len(piece)):
        k = piece[n]
        re = _applied(responses[kind[n], 0], neutral, k)
        im = _applied(responses[kind[n], 1], neutral, k)
        c, s = frame[n, 0], frame[n, 1]
        add_re, add_im = c * re + s * im - lost[0], c * im - s * re - lost[1]
        new_re, new_im = y[0] + add_re, y[1] + add_im
        lost[0], lost[1] = (new_re - y[0]) - add_re, (new_im - y[1]) - add_im
        y[0], y[1] = decay[n] * new_re, decay[n] * new_im
        c, s = frame[n + 1, 0], frame[n + 1, 1]
        psi = (c * y[1] + s * y[0]) / omega
        tilt = _line(neutral, k, end[n], 1.0 / length[k])
        angle[n] = psi - tilt[0]
        rate[n] = c * y[0] - s * y[1] - delta * psi - tilt[1]
