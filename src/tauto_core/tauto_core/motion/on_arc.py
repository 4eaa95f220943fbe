"""The functions of the arc s in compiled code, for a heavy weight on a linear lever arm.

`arc_length` defines them and fits polynomials in u = s²/limit to them; beyond the limit they are
computed by their definitions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from tauto_core.kernels import compiled, inlined
from tauto_core.motion import arc_length
from tauto_core.motion.arc_length import ArcShape
from tauto_core.motion.lanes import Lanes, filled, fma, lane, negative, width, with_lane
from tauto_core.samples import FloatArray

SHORTENING, SLOPE, LEVER, ANGLE = 0, 1, 2, 3
"""Rows of `ArcShape.terms`."""

arc_of = compiled(arc_length.arc_of)
angle_of = compiled(arc_length.angle_of)


class OnArc(NamedTuple):
    """The functions of the arc s at the stages.

    Attributes:
        n: dϑ/ds.
        n_slope: (dn/ds)/s.
        lever_deficit: b − nt/s, by which the arm along the arc falls short of the linear one.
        angle: ϑ.
    """

    n: Lanes
    n_slope: Lanes
    lever_deficit: Lanes
    angle: Lanes


@inlined
def _even(terms: FloatArray, row: int, u: float) -> float:
    """Return a row of `ArcShape.terms`, a polynomial, at u = s²/limit."""
    last = terms.shape[1] - 1
    value = fma(u, terms[row, last], terms[row, last - 1])
    for j in range(last - 2, -1, -1):
        value = fma(value, u, terms[row, j])
    return value


@compiled
def angle_along(shape: ArcShape, arc: float) -> float:
    """Return ϑ at the arc s."""
    u = arc * arc / shape.limit
    if u <= 1.0:
        return arc * _even(shape.terms, ANGLE, u)
    return angle_of(arc, shape.k)


@compiled
def _on_arc_exactly(shape: ArcShape, s: Lanes) -> OnArc:
    """Return the functions of the arc by their definitions: where the polynomials end."""
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
    return OnArc(n_all, n_slope, lever_deficit, q_all)


@inlined
def on_arc(shape: ArcShape, s: Lanes) -> OnArc:
    """Return the functions of the arc at the stages."""
    u = (s * s) * shape.per_limit
    if negative(1.0 - u) != 0:
        return _on_arc_exactly(shape, s)
    terms, square = shape.terms, u * u
    last = terms.shape[1] - 1
    n, n_odd = _pair(terms, SHORTENING, last, s)
    n_slope, n_slope_odd = _pair(terms, SLOPE, last, s)
    lever, lever_odd = _pair(terms, LEVER, last, s)
    angle, angle_odd = _pair(terms, ANGLE, last, s)
    # four polynomials side by side, even and odd powers of each apart: eight chains of
    # multiplications, none of which waits for another
    for j in range(last - 3, -1, -2):
        n, n_odd = _next(terms, SHORTENING, j, square, n, n_odd)
        n_slope, n_slope_odd = _next(terms, SLOPE, j, square, n_slope, n_slope_odd)
        lever, lever_odd = _next(terms, LEVER, j, square, lever, lever_odd)
        angle, angle_odd = _next(terms, ANGLE, j, square, angle, angle_odd)
    lever = fma(lever_odd, u, lever)
    return OnArc(
        fma(n_odd, u, n),
        fma(n_slope_odd, u, n_slope),
        -(u * lever),
        s * fma(angle_odd, u, angle),
    )


@inlined
def _pair(terms: FloatArray, row: int, last: int, like: Lanes) -> tuple[Lanes, Lanes]:
    """Return the last even and the last odd coefficient as lanes."""
    return filled(like, terms[row, last - 1]), filled(like, terms[row, last])


@inlined
def _next(
    terms: FloatArray, row: int, j: int, square: Lanes, even: Lanes, odd: Lanes
) -> tuple[Lanes, Lanes]:
    """Return both after the next coefficients, by Horner's scheme in u²."""
    return fma(even, square, terms[row, j]), fma(odd, square, terms[row, j + 1])
