"""The trochlea in compiled code: the effect of lever arm, power and drag at an instant.

Absent terms are `None`, and are not in the compiled code. Angles, rates and forcing are floats or
`Lanes`; one formula serves both.

Variables per unit of inertia: q = ϑ, the angle the cam feels, and w = p/I with the momentum
p = I (q̇ + γ̇) + m t² q̇ (theory E2 in Hamilton's form: no second derivative of the forcing):

    q̇ = (w − γ̇) / (1 + μ t²)                                               μ = m/I
    ẇ = −pull · t + μ t t' q̇² − (c₁ v + c₂ d v² + c₀ d + R s)/I             v = q̇ + τ̇ = θ̇

with t the lever arm, pull = F/I, τ = γ − α_c the tilt of the neutral line in the case, θ = q + τ,
d the sign of θ̇ and s that of the last impulse, both constant between the events.

A heavy weight on a linear lever arm has a `shape` (arc_length): then x = s, the arc, and
p = ṡ + γ̇n stand for q and w. x and w are either of them.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from tauto_core.curves.levers import (
    ArcLever,
    Lever,
    LinearLever,
    SmoothLever,
    SpringLever,
    TableLever,
)
from tauto_core.kernels import compiled, inlined
from tauto_core.machines.escapement import Ebb
from tauto_core.motion import arc_length
from tauto_core.motion.lanes import (
    Lanes,
    filled,
    fma,
    is_lanes,
    lane,
    largest,
    negative,
    root,
    width,
    with_lane,
)
from tauto_core.motion.outside import Outside
from tauto_core.motion.rotation import sine_versine
from tauto_core.motion.system import Mode
from tauto_core.samples import FloatArray

SHORTENING, SLOPE, LEVER, ANGLE = 0, 1, 2, 3

Number: TypeAlias = Any
"""A float, or lanes of them."""

Shape: TypeAlias = tuple[Lanes, Lanes, Lanes, Lanes]
"""n, (dn/ds)/s, b − nt/s and ϑ at the stages."""

Arm: TypeAlias = tuple[Number, Number, Number]
"""t, t' and h of a lever arm."""


class Impulse(NamedTuple):
    """The escapement's impulse: twice its energy over I, and how it weakens."""

    energy: float
    ebb: Ebb | None


class Terms(NamedTuple):
    """The terms that act on the wheel, each divided by its inertia I; None where absent.

    Attributes:
        carried: μ = m/I of the mass that rides on the thread [1/m2].
        force: constant part of the pull.
        stiffness: stiffness of the spring, times the lift.
        weight: mass that draws, times the apparent gravity.
        viscous, quadratic, coulomb: c₁, c₂ and c₀ of the drag.
        impulse: impulse of the escapement.
        recoil: R.
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


class Well(Protocol):
    """A wheel in its well."""

    @property
    def machine(self) -> Terms:
        """What acts on it."""

    @property
    def lever(self) -> Lever:
        """Arm of the thread."""

    @property
    def shape(self) -> arc_length.ArcShape | None:
        """The arc, or None where the angle is the coordinate."""


arc_of = compiled(arc_length.arc_of)
angle_of = compiled(arc_length.angle_of)


@compiled
def _spline(lever: TableLever | SmoothLever, q: float) -> tuple[float, float, float]:
    """Return t, t' and h of pieces; odd, odd's derivative, even."""
    size = abs(q)
    knots = lever.knots
    k = min(int(np.searchsorted(knots, size, 'right')) - 1, len(knots) - 2)
    x = size - knots[k]
    value = first = lift = 0.0
    for j in range(lever.coefficients.shape[1] - 1, -1, -1):
        number = lever.coefficients[k, j]
        first = fma(first, x, value)
        value = fma(value, x, number)
        lift = lift * x + number / (j + 1.0)
    return math.copysign(value, q), first, lever.lifts[k] + lift * x


@compiled
def _smooth_at(lever: SmoothLever, q: float) -> tuple[float, float, float]:
    """Return t, t' and h of an analytic law."""
    if abs(q) > lever.knots[1]:
        return _spline(lever, q)
    u = q / lever.knots[1]
    u = u * u
    arm = rate = lift = 0.0
    for j in range(lever.middle.shape[1] - 1, -1, -1):
        arm = fma(arm, u, lever.middle[0, j])
        rate = fma(rate, u, lever.middle[1, j])
        lift = fma(lift, u, lever.middle[2, j])
    return q * arm, rate, (q * q) * lift


@compiled
def _splines(lever: TableLever | SmoothLever, q: Lanes) -> Arm:
    """Return t, t' and h of pieces at the stages."""
    arm = rate = lift = filled(q, 0.0)
    for i in range(width(q)):
        value, first, height = _spline(lever, lane(q, i))
        arm = with_lane(arm, i, value)
        rate = with_lane(rate, i, first)
        lift = with_lane(lift, i, height)
    return arm, rate, lift


@inlined
def _smooth(lever: SmoothLever, q: Lanes) -> Arm:
    """Return t, t' and h of an analytic law at the stages: mostly all in its first piece."""
    if largest(q) > lever.knots[1]:
        return _splines(lever, q)
    middle = lever.middle
    u = q * (1.0 / lever.knots[1])
    u = u * u
    last = middle.shape[1] - 1
    arm, rate = filled(q, middle[0, last]), filled(q, middle[1, last])
    lift = filled(q, middle[2, last])
    for j in range(last - 1, -1, -1):
        arm = fma(arm, u, middle[0, j])
        rate = fma(rate, u, middle[1, j])
        lift = fma(lift, u, middle[2, j])
    return q * arm, rate, (q * q) * lift


@inlined
def _spring(lever: SpringLever, q: Number) -> Arm:
    """Return t, t' and h of a spring's own cam."""
    square = q * q
    stretched = 1.0 + lever.bend * square
    longer = root(stretched)
    shorter = lever.rate / longer
    return q * shorter, shorter / stretched, lever.rate * square / (1.0 + longer)


@compiled
def _arc(lever: ArcLever, side: float, q: Number) -> Arm:
    """Return t, t' and h of a cheek of circular arc."""
    sine, versine = sine_versine(q)
    cosine = 1.0 - versine
    return (
        lever.root_depth * sine + (side * lever.radius) * versine,
        lever.root_depth * cosine + (side * lever.radius) * sine,
        lever.root_depth * versine + (side * lever.radius) * (q - sine),
    )


@inlined
def lever_arm(lever: Lever, side: float, q: Number) -> Arm:
    """Return t, t' and h at the cam angle q; `side` continues a kinked cam smoothly."""
    if isinstance(lever, LinearLever):
        return lever.rate * q, lever.rate, 0.5 * lever.rate * (q * q)
    if isinstance(lever, ArcLever):
        return _arc(lever, side, q)
    if isinstance(lever, SpringLever):
        return _spring(lever, q)
    if isinstance(lever, SmoothLever):
        return _smooth(lever, q) if is_lanes(q) else _smooth_at(lever, q)
    return _splines(lever, q) if is_lanes(q) else _spline(lever, q)


@inlined
def excess(lever: Lever, q: Number, t: Number, pull: Number, square: float) -> Number:
    """Return ω²q − pull·t: by how much the well falls short of the harmonic one."""
    if isinstance(lever, LinearLever):
        # no difference of two large terms
        return (square - lever.rate * pull) * q
    return square * q - pull * t


@inlined
def term(coefficient: float | None, value: Number) -> Number:
    """Return coefficient · value; an absent term is −0.0, the sum's neutral element."""
    return -0.0 if coefficient is None else coefficient * value


@inlined
def pull_of(machine: Terms, lift: Number, g_eff: Number) -> Number:
    """Return F/I."""
    pull = term(machine.force, 1.0) + term(machine.stiffness, lift)
    return pull + term(machine.weight, g_eff)


@inlined
def resistance(machine: Terms, v: Number, mode: Mode) -> Number:
    """Return the torques of drag and recoil, reversed, over I."""
    d = mode.direction
    drag = term(machine.viscous, v) + term(machine.quadratic, d * (v * v))
    return drag + term(machine.coulomb, d) + term(machine.recoil, mode.pallet)


@inlined
def mass_of(mu: float | None, t: Number) -> Number:
    """Return M/I = 1 + μ t²."""
    return 1.0 + term(mu, t * t)


@inlined
def rate_of(mu: float | None, t: Number, w: Number, line_rate: Number) -> Number:
    """Return q̇ from the momentum."""
    return w - line_rate if mu is None else (w - line_rate) / (1.0 + mu * (t * t))


@inlined
def ride(mu: float | None, t: Number, t1: Number, rate: Number) -> Number:
    """Return what the weight's ride on the changing lever arm adds to ẇ."""
    return term(mu, t * t1 * (rate * rate))


@inlined
def _even(terms: FloatArray, row: int, u: float) -> float:
    """Return a polynomial of the shape at u."""
    last = terms.shape[1] - 1
    value = fma(u, terms[row, last], terms[row, last - 1])
    for j in range(last - 2, -1, -1):
        value = fma(value, u, terms[row, j])
    return value


@compiled
def _angle_along(shape: arc_length.ArcShape, arc: float) -> float:
    """Return ϑ of the arc."""
    u = arc * arc / shape.limit
    if u <= 1.0:
        return arc * _even(shape.terms, ANGLE, u)
    return angle_of(arc, shape.k)


@inlined
def angle_at(well: Well, x: float) -> float:
    """Return q of a state."""
    return x if well.shape is None else _angle_along(well.shape, x)


@inlined
def unfold(well: Well, x: float, w: float, line_rate: float, side: float) -> tuple[float, float]:
    """Return q and q̇ of a state."""
    if well.shape is None:
        t = lever_arm(well.lever, side, x)[0]
        return x, rate_of(well.machine.carried, t, w, line_rate)
    k = well.shape.k
    q = _angle_along(well.shape, x)
    n = 1.0 / math.sqrt(1.0 + (k * q) * (k * q))
    return q, n * (w - line_rate * n)


@inlined
def fold(well: Well, q: float, rate: float, line_rate: float, side: float) -> tuple[float, float]:
    """Return x and w of q and q̇."""
    if well.shape is None:
        t = lever_arm(well.lever, side, q)[0]
        return q, rate * mass_of(well.machine.carried, t) + line_rate
    k = well.shape.k
    root = math.sqrt(1.0 + (k * q) * (k * q))
    return arc_of(q, k), rate * root + line_rate / root


@compiled
def holding_torque(well: Well, mode: Mode, angle: float, at: Outside) -> float:
    """Return the torque over I that keeps the wheel at `angle` in the moving case."""
    machine, tilt = well.machine, at.tilt
    t, t1, lift = lever_arm(well.lever, mode.side, angle - tilt.value)
    carried = term(machine.carried, t * (t1 * tilt.rate * tilt.rate - t * tilt.bend))
    pushed = carried + pull_of(machine, lift, at.gravity) * t
    return at.line.bend - tilt.bend + pushed + term(machine.recoil, mode.pallet)


@compiled
def kick(impulse: Impulse, mu: float | None, t: float, v: float, d: float, given: int) -> float:
    """Return what an impulse adds to q̇: ½ M θ̇² grows by the energy (theory E2)."""
    strength = 1.0 if impulse.ebb is None else impulse.ebb.strength(given)
    energy = impulse.energy * strength
    return d * math.sqrt(v * v + energy / mass_of(mu, t)) - v


@compiled
def _shape_exactly(shape: arc_length.ArcShape, s: Lanes) -> Shape:
    """Return n, (dn/ds)/s, b − nt/s and ϑ of each lane from the functions themselves."""
    n_all = slope = less = q_all = filled(s, 0.0)
    for i in range(width(s)):
        arc = lane(s, i)
        q = angle_of(arc, shape.k)
        ratio = q / arc if arc != 0.0 else 1.0
        n = 1.0 / math.sqrt(1.0 + (shape.k * q) * (shape.k * q))
        n_all = with_lane(n_all, i, n)
        slope = with_lane(slope, i, -(shape.k * shape.k) * ratio * (n * n) * (n * n))
        less = with_lane(less, i, shape.rate * (1.0 - n * ratio))
        q_all = with_lane(q_all, i, q)
    return n_all, slope, less, q_all


@inlined
def shape_at(shape: arc_length.ArcShape, s: Lanes) -> Shape:
    """Return n, (dn/ds)/s, b − nt/s and ϑ at the stages."""
    u = (s * s) * shape.per_limit
    if negative(1.0 - u) != 0:
        return _shape_exactly(shape, s)
    terms, square = shape.terms, u * u
    last = terms.shape[1] - 1
    n, n_odd = _pair(terms, SHORTENING, last, s)
    slope, slope_odd = _pair(terms, SLOPE, last, s)
    more, more_odd = _pair(terms, LEVER, last, s)
    angle, angle_odd = _pair(terms, ANGLE, last, s)
    # side by side, even powers and odd ones: each waits for its own last term only
    for j in range(last - 3, -1, -2):
        n, n_odd = _next(terms, SHORTENING, j, square, n, n_odd)
        slope, slope_odd = _next(terms, SLOPE, j, square, slope, slope_odd)
        more, more_odd = _next(terms, LEVER, j, square, more, more_odd)
        angle, angle_odd = _next(terms, ANGLE, j, square, angle, angle_odd)
    more = fma(more_odd, u, more)
    return fma(n_odd, u, n), fma(slope_odd, u, slope), -(u * more), s * fma(angle_odd, u, angle)


@inlined
def _pair(terms: FloatArray, row: int, last: int, like: Lanes) -> tuple[Lanes, Lanes]:
    """Return the last even and the last odd coefficient as lanes."""
    return filled(like, terms[row, last - 1]), filled(like, terms[row, last])


@inlined
def _next(
    terms: FloatArray, row: int, j: int, square: Lanes, even: Lanes, odd: Lanes
) -> tuple[Lanes, Lanes]:
    return fma(even, square, terms[row, j]), fma(odd, square, terms[row, j + 1])
