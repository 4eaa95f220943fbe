"""The equation of motion of a wheel with one degree of freedom, term by term, over its inertia.

The coordinate is q = ϑ, the angle that the cam senses [rad]. The momentum per unit of inertia is w
= q̇ + γ̇ + μt²q̇ [rad/s]. Hamilton's form (machine_at_sea.md) needs no second derivative of the
ship's motion:

    q̇ = (w − γ̇) / (1 + μt²)                                                 μ = m/I
    ẇ = −pull · t + μ t t′ q̇² − (c₁θ̇ + c₂ d θ̇² + c₀ d + R s)/I − w İ/I       θ̇ = q̇ + τ̇

with the lever arm t(q) [m], t′ = dt/dq, pull = F/I, the neutral line γ, its tilt in the case τ = γ
− α_c, and θ = q + τ. d is the sign of θ̇ and s the sign of the last impulse, both constant between
events. If heat changes the machine (heat.md), t(q) stays and the parameters over I follow the
temperature. Otherwise İ is absent.

A heavy weight on a linear lever arm has a `shape` (`arc_shape`). Its coordinate is the arc s of
the well, its momentum p = ṡ + γ̇n with n = dϑ/ds. Below, x and w are coordinate and momentum of
either kind. As in `system`, `rate` is θ̇, `speed` q̇, and `drive` γ.

Absent terms are `None` and compile to no code.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.polynomial.polynomial import polyval

from tauto_core.curves.cam import (
    ArcLever,
    LeverArm,
    LinearLever,
    SmoothLever,
    SpringLever,
    TableLever,
)
from tauto_core.curves.numerics import bracketed_newton, powers_on_unit
from tauto_core.kernels import compiled, inlined
from tauto_core.machines import Machine
from tauto_core.machines.parts import DragLaw, ImpulseDecline
from tauto_core.motion.gauss_step import Mode, sine_versine
from tauto_core.motion.lanes import (
    Lanes,
    Numeric,
    filled,
    fma,
    is_lanes,
    lane,
    largest,
    negative,
    square_root,
    width,
    with_lane,
)
from tauto_core.motion.system import HeatTerms
from tauto_core.samples import FloatArray

# -----------------------------------------------------------------------------
# The arc as the coordinate of a wheel that lifts a heavy weight by a linear lever arm.
#
# With the lever arm t = bϑ and k² = mb²/I the inertia M/I = 1 + k²ϑ² grows with the angle. Along
# the arc s = ∫√(M/I) dϑ = ½ (ϑ√(1 + k²ϑ²) + asinh(kϑ)/k) it is one. With n = dϑ/ds and the
# momentum p = ṡ + γ̇n,
#
#     (methods.2)   ṡ = p − γ̇n,    ṗ = ṡγ̇ dn/ds − n (pull · t + drag).
#
# Steps need even functions of s. They are polynomials in u = s²/limit, interpolated at Chebyshev
# nodes, accurate to rounding. Beyond the limit the functions themselves are evaluated. In s the
# disturbance of the rotating plane is half as large as in ϑ, and smoother: at five steps per
# oscillation the error falls thirteenfold.

MAX_TERMS = 20
"""Most terms. With more, steps would take longer than with ϑ as the coordinate."""

REACH_PER_RELEASE = 1.5
"""Reach of a cam's and a lever's polynomials over the release angle.

Sea and escapement commonly drive the wheel this far. Beyond, evaluation is slower but as accurate.
"""

# Coefficients of x^2n in asinh(x)/x − 1, |x| < 1: (−1/4)^n (2n over n)/(2n + 1).
_ASINH = [(-0.25) ** n * math.comb(2 * n, n) / (2 * n + 1) for n in range(1, 18)]

# Largest kϑ for the series: the first omitted term is 0.0036 · 0.3^36 = 5e-22.
_SERIES_TO = 0.3

# u at which polynomials are compared with the functions.
_CHECKED = (np.arange(64) + 0.5) / 64

# Largest difference at these u, as a share of the function's largest value.
_AGREED = 4e-15


ROUNDING_SHIFT = 1.5 * 2.0**52
"""Adding and subtracting it rounds to a whole number."""

ARC_SETTLED = 4e-16
"""Change of ϑ, as a share of s, that ends Newton's method: two roundings."""


class ArcShape(NamedTuple):
    """A machine with a heavy weight along its arc.

    Attributes:
        rate: b = dt/dϑ [m/rad].
        k: b√(m/I) [1/rad].
        limit: s² up to which the polynomials hold [rad2].
        per_limit: 1/limit.
        terms: coefficients of u^j of n, (dn/ds)/s, (nt/s − b)/u and ϑ/s, (4, count). `count` is
            even, since two powers are summed in parallel.
    """

    rate: float
    k: float
    limit: float
    per_limit: float
    terms: FloatArray


@compiled
def arc_of(angle: float, k: float) -> float:
    """Return the arc s of the angle ϑ."""
    return 0.5 * (angle * math.hypot(1.0, k * angle) + math.asinh(k * angle) / k)


@compiled
def angle_of(arc: float, k: float) -> float:
    """Return the angle ϑ of the arc s.

    s(ϑ) is convex for ϑ > 0, hence Newton's method converges monotonically from above. It starts
    from the bounds given by s ≥ ϑ and s ≥ ½kϑ².
    """
    size = abs(arc)
    angle = min(size, math.sqrt(2.0 * size / k))
    for _ in range(60):
        root = math.sqrt(1.0 + (k * angle) * (k * angle))
        step = (0.5 * (angle * root + math.asinh(k * angle) / k) - size) / root
        angle -= step
        if abs(step) <= ARC_SETTLED * size:
            break
    return math.copysign(angle, arc)


def angles_of(arcs: FloatArray, k: float) -> FloatArray:
    """Return the angles ϑ of many arcs s, as `angle_of`."""
    sizes = np.abs(arcs)
    upper = np.minimum(sizes, np.sqrt(2.0 * sizes / k))

    def excess(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        root = np.sqrt(1.0 + (k * angles) ** 2)
        return 0.5 * (angles * root + np.arcsinh(k * angles) / k) - sizes, root

    angles = bracketed_newton(excess, upper, (0.0, math.inf), absolute=ARC_SETTLED * sizes)
    return np.copysign(angles, arcs)


def arc_shape(machine: Machine) -> ArcShape | None:
    """Return the shape of a machine, or `None` if ϑ is the better coordinate.

    That is so without a linear lever arm or a carried weight, with a spring (its pull grows with
    the lift), with an imbalance, or if the polynomials take more than `MAX_TERMS`.
    """
    rate = machine.cam.linear_rate
    if rate is None or machine.carried_mass == 0.0 or machine.stiffness > 0.0:
        return None
    if machine.imbalance is not None:
        return None
    k = rate * math.sqrt(machine.carried_mass / machine.inertia)
    # 0.1 rad serves a wheel that is released at rest and moved by the ship only
    reach = min(machine.cam.range_rad, REACH_PER_RELEASE * abs(machine.release_angle) + 0.1)
    return _fitted(k, arc_of(reach, k) ** 2, rate)


@lru_cache(maxsize=64)  # the machines of a fleet are often alike
def _fitted(k: float, limit: float, rate: float) -> ArcShape | None:
    for terms in range(2, MAX_TERMS + 1):
        nodes = 0.5 * (chebyshev.chebpts1(terms) + 1.0)
        rows = [
            powers_on_unit(chebyshev.chebfit(2.0 * nodes - 1.0, values, terms - 1))
            for values in _functions(nodes, limit, k, rate)
        ]
        fitted = [np.asarray(polyval(_CHECKED, row), np.float64) for row in rows]
        wanted = _functions(_CHECKED, limit, k, rate)
        if all(
            np.all(np.abs(a - b) <= _AGREED * np.max(np.abs(b)))
            for a, b in zip(fitted, wanted, strict=True)
        ):
            slope = np.append(rows[0][1:] * np.arange(1, terms), 0.0) * (2.0 / limit)
            padded = np.pad([rows[0], slope, *rows[1:]], ((0, 0), (0, terms % 2)))
            return ArcShape(rate, k, limit, 1.0 / limit, np.ascontiguousarray(padded))
    return None


def _functions(u: FloatArray, limit: float, k: float, rate: float) -> tuple[FloatArray, ...]:
    """Return n, (nt/s − b)/u and ϑ/s at u = s²/limit."""
    arcs = np.sqrt(limit * u)
    angles = angles_of(arcs, k)
    square = (k * angles) ** 2
    n = 1.0 / np.sqrt(1.0 + square)
    # nϑ/s − 1 = ((n − 1) ϑ − (s − ϑ))/s without cancellation: n − 1 = −k²ϑ²n²/(1 + n) and
    # s − ϑ = ½ϑ (√(1 + k²ϑ²) − 1 + asinh(kϑ)/(kϑ) − 1)
    x = np.sqrt(square)
    series = square * polyval(square, _ASINH)
    asinh = np.where(x < _SERIES_TO, series, np.arcsinh(x) / x - 1.0)
    longer = 0.5 * angles * (square / (1.0 + np.sqrt(1.0 + square)) + asinh)
    shorter = -square * n * n / (1.0 + n)
    return n, rate * ((shorter * angles - longer) / arcs) / u, angles / arcs


# -----------------------------------------------------------------------------
# The functions of the arc s in compiled code: polynomials in u up to the limit, definitions
# beyond.

ROWS = SHORTENING, SHORTENING_SLOPE, LEVER, ANGLE = 0, 1, 2, 3
"""Rows of `ArcShape.terms`."""


class CamOnArc(NamedTuple):
    """The functions of the arc s at the stages.

    Attributes:
        n: dϑ/ds.
        n_slope: (dn/ds)/s.
        lever_deficit: b − nt/s, the linear lever arm minus the arm along the arc.
        angle: ϑ.
    """

    n: Lanes
    n_slope: Lanes
    lever_deficit: Lanes
    angle: Lanes


@compiled
def angle_along(shape: ArcShape, arc: float) -> float:
    """Return ϑ at the arc s."""
    u = arc * arc / shape.limit
    if u <= 1.0:
        terms, degree = shape.terms, shape.terms.shape[1] - 1
        value = fma(u, terms[ANGLE, degree], terms[ANGLE, degree - 1])
        for j in range(degree - 2, -1, -1):
            value = fma(value, u, terms[ANGLE, j])
        return arc * value
    return angle_of(arc, shape.k)


@inlined
def shortening_and_angle(shape: ArcShape, s: Numeric) -> tuple[Numeric, Numeric]:
    """Return n and ϑ at the arc s. For a single s, n is computed by its definition."""
    if is_lanes(s):
        arc = on_arc(shape, s)
        return arc.n, arc.angle
    q = angle_along(shape, s)
    return 1.0 / math.sqrt(1.0 + (shape.k * q) * (shape.k * q)), q


@compiled
def _on_arc_exactly(shape: ArcShape, s: Lanes) -> CamOnArc:
    """Return the functions of the arc by their definitions, beyond the polynomials."""
    n_all = n_slope = lever_deficit = q_all = filled(s, 0.0)
    for i in range(width(s)):
        arc = lane(s, i)
        q = angle_of(arc, shape.k)
        ratio = q / arc if arc != 0.0 else 1.0
        n = 1.0 / math.sqrt(1.0 + (shape.k * q) * (shape.k * q))
        n_all = with_lane(n_all, i, n)
        n_slope = with_lane(n_slope, i, -(shape.k * shape.k) * ratio * (n * n) * (n * n))
        lever_deficit = with_lane(lever_deficit, i, shape.rate * (1.0 - n * ratio))
        q_all = with_lane(q_all, i, q)
    return CamOnArc(n_all, n_slope, lever_deficit, q_all)


@inlined
def on_arc(shape: ArcShape, s: Lanes) -> CamOnArc:
    """Return the functions of the arc at the stages."""
    u = (s * s) * shape.per_limit
    if negative(1.0 - u) != 0:
        return _on_arc_exactly(shape, s)
    terms, square = shape.terms, u * u
    degree = terms.shape[1] - 1
    even: tuple[Lanes, ...] = ()
    odd: tuple[Lanes, ...] = ()
    for row in ROWS:
        even = (*even, filled(s, terms[row, degree - 1]))
        odd = (*odd, filled(s, terms[row, degree]))
    # eight independent chains of multiplications: four polynomials, even and odd powers apart
    for j in range(degree - 3, -1, -2):
        next_even: tuple[Lanes, ...] = ()
        next_odd: tuple[Lanes, ...] = ()
        for row in ROWS:
            next_even = (*next_even, fma(even[row], square, terms[row, j]))
            next_odd = (*next_odd, fma(odd[row], square, terms[row, j + 1]))
        even, odd = next_even, next_odd
    n, n_slope, lever, angle = even
    return CamOnArc(
        fma(odd[0], u, n),
        fma(odd[1], u, n_slope),
        -(u * fma(odd[2], u, lever)),
        s * fma(odd[3], u, angle),
    )


# -----------------------------------------------------------------------------
# The thread's lever arm in compiled code: t, dt/dϑ and the lift at any cam angle.
#
# These are the laws of `curves.cam` as plain numbers. A `Numeric` is a float or `Lanes`.


class Arm(NamedTuple):
    """The lever arm at a cam angle.

    Attributes:
        t: lever arm [m].
        t_prime: dt/dϑ [m/rad].
        lift: ∫t dϑ, the lift of the weight or the draw of the spring [m].
    """

    t: Numeric
    t_prime: Numeric
    lift: Numeric


@compiled
def _spline(lever: TableLever | SmoothLever, q: float) -> Arm:
    """Return the arm of a piecewise law: t is odd in q, t′ and the lift are even."""
    size = abs(q)
    knots = lever.knots
    k = min(int(np.searchsorted(knots, size, 'right')) - 1, len(knots) - 2)
    x = size - knots[k]
    t = t_prime = lift = 0.0
    for j in range(lever.coefficients.shape[1] - 1, -1, -1):
        coefficient = lever.coefficients[k, j]
        t_prime = fma(t_prime, x, t)
        t = fma(t, x, coefficient)
        lift = lift * x + coefficient / (j + 1.0)
    return Arm(math.copysign(t, q), t_prime, lever.lifts[k] + lift * x)


@inlined
def _near_middle(middle: FloatArray, q: Numeric, u: Numeric) -> Arm:
    """Return the arm of an analytic law near the middle, by even polynomials of u = q/reach."""
    u = u * u
    t_over_q = t_prime = lift_over_square = 0.0 * u
    for j in range(middle.shape[1] - 1, -1, -1):
        t_over_q = fma(t_over_q, u, middle[0, j])
        t_prime = fma(t_prime, u, middle[1, j])
        lift_over_square = fma(lift_over_square, u, middle[2, j])
    return Arm(q * t_over_q, t_prime, (q * q) * lift_over_square)


@compiled
def _smooth_at(lever: SmoothLever, q: float) -> Arm:
    """Return the arm of an analytic law, in pieces beyond the middle."""
    if abs(q) > lever.knots[1]:
        return _spline(lever, q)
    return _near_middle(lever.middle, q, q / lever.knots[1])


@compiled
def _splines(lever: TableLever | SmoothLever, q: Lanes) -> Arm:
    """Return the arm of a piecewise law at the stages, each in a piece of its own."""
    t = t_prime = lift = filled(q, 0.0)
    for i in range(width(q)):
        arm = _spline(lever, lane(q, i))
        t = with_lane(t, i, arm.t)
        t_prime = with_lane(t_prime, i, arm.t_prime)
        lift = with_lane(lift, i, arm.lift)
    return Arm(t, t_prime, lift)


@inlined
def _smooth(lever: SmoothLever, q: Lanes) -> Arm:
    """Return the arm of an analytic law at the stages, most of them near the middle."""
    if largest(q) > lever.knots[1]:
        return _splines(lever, q)
    return _near_middle(lever.middle, q, q * (1.0 / lever.knots[1]))


@inlined
def lever_arm(lever: LeverArm, side: float, q: Numeric) -> Arm:
    """Return the arm at the cam angle q.

    The law of a kinked cam on one `side` continues smoothly past the kink, for steps that cross
    it.
    """
    if isinstance(lever, LinearLever):
        return Arm(lever.rate * q, lever.rate, 0.5 * lever.rate * (q * q))
    if isinstance(lever, ArcLever):
        # `side` is the sign of ϑ
        sine, versine = sine_versine(q)
        cosine = 1.0 - versine
        return Arm(
            lever.root_depth * sine + (side * lever.radius) * versine,
            lever.root_depth * cosine + (side * lever.radius) * sine,
            lever.root_depth * versine + (side * lever.radius) * (q - sine),
        )
    if isinstance(lever, SpringLever):
        # a spring's own cam: t = q·rate/√(1 + bend·q²)
        square = q * q
        stretched = 1.0 + lever.bend * square
        stretched_root = square_root(stretched)
        t_over_q = lever.rate / stretched_root
        lift = lever.rate * square / (1.0 + stretched_root)
        return Arm(q * t_over_q, t_over_q / stretched, lift)
    if isinstance(lever, SmoothLever):
        return _smooth(lever, q) if is_lanes(q) else _smooth_at(lever, q)
    return _splines(lever, q) if is_lanes(q) else _spline(lever, q)


@inlined
def excess(lever: LeverArm, q: Numeric, t: Numeric, pull: Numeric, square: float) -> Numeric:
    """Return ω²q − pull·t, the harmonic torque minus the torque of the well."""
    if isinstance(lever, LinearLever):
        # the difference of two large terms would lose digits
        return (square - lever.rate * pull) * q
    return square * q - pull * t


class Impulse(NamedTuple):
    """The escapement's impulse.

    Attributes:
        energy: twice its energy over I [rad2/s2].
        ebb: decline of the energy with the number of impulses, or `None` if constant.
    """

    energy: float
    ebb: ImpulseDecline | None


class UnbalancedWheel(NamedTuple):
    """The imbalance of the wheel over I.

    Attributes:
        still: m d g/I on land [1/s2], `None` at sea.
        weight: m d/I, to be multiplied by the apparent gravity [1/m], `None` on land.
        direction: φ₀ [rad].
    """

    still: float | None
    weight: float | None
    direction: float


class PerInertia(NamedTuple):
    """The terms on the wheel, divided by its moment of inertia I, `None` if absent.

    Attributes:
        carried: μ = m/I of the mass that moves with the thread [1/m2].
        force: constant part of the pull F/I [1/(m s2)].
        stiffness: κ/I of the spring, to be multiplied by the lift [1/(m2 s2)].
        weight: m/I of the driving weight, to be multiplied by the apparent gravity [1/m2].
        viscous, quadratic, coulomb: c₁/I [1/s], c₂/I [1/rad] and c₀/I [rad/s2] of the drag.
        impulse: the escapement's impulse.
        recoil: R/I [rad/s2].
        law: a further drag law, over I.
        imbalance: imbalance of the wheel.
        share: factor of the law's torque if heat changes I.
        growth: İ/I [1/s] if heat changes I.
    """

    carried: float | None
    force: float | None
    stiffness: float | None
    weight: float | None
    viscous: float | None
    quadratic: float | None
    coulomb: float | None
    impulse: Impulse | None
    recoil: float | None
    law: DragLaw | None = None
    imbalance: UnbalancedWheel | None = None
    share: float | None = None
    growth: float | None = None


@inlined
def thermal_numbers(cold: PerInertia, hot: HeatTerms) -> PerInertia:
    """Return the terms on the wheel as heat changes them, at an instant or at the nodes."""
    share = hot.share
    impulse = cold.impulse
    imbalance = cold.imbalance
    if imbalance is not None:
        # the arm of the imbalance grows with the wheel, by 1/grown
        grown, still, weight = square_root(share), imbalance.still, imbalance.weight
        imbalance = UnbalancedWheel(
            None if still is None else still * grown,
            None if weight is None else weight * grown,
            imbalance.direction,
        )
    return PerInertia(
        carried=None if cold.carried is None else hot.carried,
        force=None if cold.force is None else hot.force,
        stiffness=None if cold.stiffness is None else hot.stiffness,
        weight=None if cold.weight is None else hot.weight,
        viscous=None if cold.viscous is None else hot.viscous,
        quadratic=None if cold.quadratic is None else cold.quadratic * share,
        coulomb=None if cold.coulomb is None else cold.coulomb * share,
        impulse=None if impulse is None else Impulse(impulse.energy * share, impulse.ebb),
        recoil=None if cold.recoil is None else cold.recoil * share,
        law=cold.law,
        imbalance=imbalance,
        share=share,
        growth=hot.growth,
    )


@inlined
def term(coefficient: float | None, value: Numeric) -> Numeric:
    """Return coefficient · value. An absent term is −0.0, the sum's neutral element."""
    return -0.0 if coefficient is None else coefficient * value


@inlined
def pull_of(per_inertia: PerInertia, lift: Numeric, gravity: Numeric) -> Numeric:
    """Return the pull on the thread over I, F/I, from the lift and the apparent gravity."""
    pull = term(per_inertia.force, 1.0) + term(per_inertia.stiffness, lift)
    return pull + term(per_inertia.weight, gravity)


@inlined
def whole_turns_off(angle: Numeric) -> Numeric:
    """Return the angle minus whole turns, between −π and π."""
    # by rounding: below 2⁵¹ the sum keeps no fraction
    turns = (angle * (0.5 / math.pi) + ROUNDING_SHIFT) - ROUNDING_SHIFT
    return angle - turns * math.tau


@inlined
def unbalanced(per_inertia: PerInertia, angle: Numeric, gravity: Numeric) -> Numeric:
    """Return the torque of the imbalance, reversed, over I, or −0.0 for a balanced wheel.

    It is m d g_eff sin(ψ − β + φ₀)/I. The angle is ψ − β.
    """
    imbalance = per_inertia.imbalance
    if imbalance is None:
        return -0.0
    sine, _ = sine_versine(whole_turns_off(angle + imbalance.direction))
    return (term(imbalance.still, 1.0) + term(imbalance.weight, gravity)) * sine


@inlined
def resistance(per_inertia: PerInertia, rate: Numeric, mode: Mode) -> Numeric:
    """Return the torque of drag and recoil against the motion over I, at the rate θ̇."""
    d = mode.direction
    drag = term(per_inertia.viscous, rate) + term(per_inertia.quadratic, d * (rate * rate))
    drag = drag + term(per_inertia.coulomb, d) + term(per_inertia.recoil, mode.pallet)
    law = law_torque(per_inertia.law, rate, mode)
    return drag + (law if per_inertia.share is None else per_inertia.share * law)


@inlined
def law_torque(law: DragLaw | None, rate: Numeric, mode: Mode) -> Numeric:
    """Return the torque over I of the additional drag law, or −0.0 without one."""
    # adding −0.0 keeps the bits of any number, including −0.0
    return -0.0 if law is None else law.torque(rate, mode.direction)


@inlined
def mass_of(mu: float | None, t: Numeric) -> Numeric:
    """Return M/I = 1 + μ t²."""
    return 1.0 + term(mu, t * t)


@inlined
def speed_of(mu: float | None, t: Numeric, w: Numeric, line_rate: Numeric) -> Numeric:
    """Return q̇ from the momentum w."""
    return w - line_rate if mu is None else (w - line_rate) / (1.0 + mu * (t * t))


@inlined
def ride(mu: float | None, t: Numeric, t_prime: Numeric, speed: Numeric) -> Numeric:
    """Return μ t t′ q̇², the force of the moving mass as the lever arm changes."""
    return term(mu, t * t_prime * (speed * speed))


@inlined
def given_energy(impulse: Impulse, count: int) -> float:
    """Return twice the energy of an impulse over I [1/s2], after `count` impulses."""
    return impulse.energy * (1.0 if impulse.ebb is None else impulse.ebb.strength(count))


@inlined
def kick(energy: float, rate: float, direction: float) -> float:
    """Return the change of θ̇ and of ϑ̇ by an impulse of half the given energy, over the inertia.

    `rate` is θ̇ before it, `direction` the sign of θ̇ after it.
    """
    return direction * math.sqrt(rate * rate + energy) - rate
