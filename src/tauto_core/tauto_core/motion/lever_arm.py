"""The lever arm of the thread in compiled code: t, dt/dϑ and the lift at any cam angle.

The laws are those of `curves.levers`, as plain numbers. A `Number` is a float or `Lanes`; one
formula serves both wherever it can.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

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
from tauto_core.motion.lanes import (
    Lanes,
    filled,
    fma,
    is_lanes,
    lane,
    largest,
    root,
    width,
    with_lane,
)
from tauto_core.motion.rotation import sine_versine

Number: TypeAlias = Any
"""A float, or lanes of them."""


class Arm(NamedTuple):
    """The lever arm at a cam angle.

    Attributes:
        t: lever arm [m].
        t_prime: dt/dϑ [m/rad].
        lift: ∫t dϑ, by which weight or spring is drawn [m].
    """

    t: Number
    t_prime: Number
    lift: Number


@compiled
def _spline(lever: TableLever | SmoothLever, q: float) -> Arm:
    """Return the arm of a law in pieces: t is odd in q, t′ and the lift are even."""
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


@compiled
def _smooth_at(lever: SmoothLever, q: float) -> Arm:
    """Return the arm of an analytic law: even polynomials of q about the middle, pieces beyond."""
    if abs(q) > lever.knots[1]:
        return _spline(lever, q)
    u = q / lever.knots[1]
    u = u * u
    t_over_q = t_prime = lift_over_square = 0.0
    for j in range(lever.middle.shape[1] - 1, -1, -1):
        t_over_q = fma(t_over_q, u, lever.middle[0, j])
        t_prime = fma(t_prime, u, lever.middle[1, j])
        lift_over_square = fma(lift_over_square, u, lever.middle[2, j])
    return Arm(q * t_over_q, t_prime, (q * q) * lift_over_square)


@compiled
def _splines(lever: TableLever | SmoothLever, q: Lanes) -> Arm:
    """Return the arm of a law in pieces at the stages, each of which may lie in another piece."""
    t = t_prime = lift = filled(q, 0.0)
    for i in range(width(q)):
        one = _spline(lever, lane(q, i))
        t = with_lane(t, i, one.t)
        t_prime = with_lane(t_prime, i, one.t_prime)
        lift = with_lane(lift, i, one.lift)
    return Arm(t, t_prime, lift)


@inlined
def _smooth(lever: SmoothLever, q: Lanes) -> Arm:
    """Return the arm of an analytic law at the stages, most of which lie about the middle."""
    if largest(q) > lever.knots[1]:
        return _splines(lever, q)
    middle = lever.middle
    u = q * (1.0 / lever.knots[1])
    u = u * u
    last = middle.shape[1] - 1
    t_over_q, t_prime = filled(q, middle[0, last]), filled(q, middle[1, last])
    lift_over_square = filled(q, middle[2, last])
    for j in range(last - 1, -1, -1):
        t_over_q = fma(t_over_q, u, middle[0, j])
        t_prime = fma(t_prime, u, middle[1, j])
        lift_over_square = fma(lift_over_square, u, middle[2, j])
    return Arm(q * t_over_q, t_prime, (q * q) * lift_over_square)


@inlined
def _spring(lever: SpringLever, q: Number) -> Arm:
    """Return the arm of a spring's own cam: t = q·rate/√(1 + bend·q²)."""
    square = q * q
    stretched = 1.0 + lever.bend * square
    stretched_root = root(stretched)
    t_over_q = lever.rate / stretched_root
    return Arm(q * t_over_q, t_over_q / stretched, lever.rate * square / (1.0 + stretched_root))


@compiled
def _arc(lever: ArcLever, side: float, q: Number) -> Arm:
    """Return the arm of a cheek of circular arc; `side` is the sign of ϑ that is felt."""
    sine, versine = sine_versine(q)
    cosine = 1.0 - versine
    return Arm(
        lever.root_depth * sine + (side * lever.radius) * versine,
        lever.root_depth * cosine + (side * lever.radius) * sine,
        lever.root_depth * versine + (side * lever.radius) * (q - sine),
    )


@inlined
def lever_arm(lever: Lever, side: float, q: Number) -> Arm:
    """Return the arm at the cam angle q.

    The law of a kinked cam on one `side` is continued smoothly over the kink, so that a step may
    reach beyond it.
    """
    if isinstance(lever, LinearLever):
        return Arm(lever.rate * q, lever.rate, 0.5 * lever.rate * (q * q))
    if isinstance(lever, ArcLever):
        return _arc(lever, side, q)
    if isinstance(lever, SpringLever):
        return _spring(lever, q)
    if isinstance(lever, SmoothLever):
        return _smooth(lever, q) if is_lanes(q) else _smooth_at(lever, q)
    return _splines(lever, q) if is_lanes(q) else _spline(lever, q)


@inlined
def excess(lever: Lever, q: Number, t: Number, pull: Number, square: float) -> Number:
    """Return ω²q − pull·t, the excess of the harmonic torque over that of the well."""
    if isinstance(lever, LinearLever):
        # the difference of two large terms would lose digits
        return (square - lever.rate * pull) * q
    return square * q - pull * t
