"""Lever arms t(ϑ) as plain numbers: all that a compiled kernel needs of a cam.

Angles are in radians, lengths in metres. All are odd, t(−ϑ) = −t(ϑ); lifts h = ∫ t dϑ are even.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from tauto_core.samples import FloatArray


class LinearLever(NamedTuple):
    """t = rate·ϑ, h = rate·ϑ²/2: the involute, and Euler's cam for a hole.

    Attributes:
        rate: dt/dϑ [m/rad], > 0.
    """

    rate: float


class ArcLever(NamedTuple):
    """t = sgn ϑ (root_depth·sin|ϑ| + radius·(1 − cos ϑ)): a cheek of circular arc.

    h = root_depth·(1 − cos ϑ) + radius·(|ϑ| − sin|ϑ|).

    Attributes:
        root_depth: depth of the cheek's root below the axle [m], > 0; it is t'(0).
        radius: radius of the arc [m], > 0.
    """

    root_depth: float
    radius: float


class TableLever(NamedTuple):
    """A quintic spline in |ϑ|, on n pieces.

    On piece k, with x = |ϑ| − knots[k] and knots[k] ≤ |ϑ| ≤ knots[k + 1]:
    |t| = Σ_j coefficients[k, j]·x^j and h = lifts[k] + Σ_j coefficients[k, j]·x^(j+1)/(j + 1).

    Attributes:
        knots: shape (n + 1,) [rad], strictly increasing from 0 to the cam's range.
        coefficients: shape (n, 6), C order, [m/rad^j]; the even ones of piece 0 are exactly 0.
        lifts: shape (n,) [m], the lift at knots[k]; lifts[0] = 0.
    """

    knots: FloatArray
    coefficients: FloatArray
    lifts: FloatArray


class SpringLever(NamedTuple):
    """t = rate·ϑ/√(1 + bend·ϑ²), h = rate·ϑ²/(1 + √(1 + bend·ϑ²)): a spring's own cam.

    Attributes:
        rate: t'(0) [m/rad], > 0.
        bend: rate · stiffness/force of the spring [1/rad²], ≥ 0.
    """

    rate: float
    bend: float


class SmoothLever(NamedTuple):
    """An analytic lever arm as polynomials in |ϑ|, whose joints are below rounding.

    On n pieces as TableLever, of any degree. Up to knots[1], with u = (ϑ/knots[1])²,
    t = ϑ Σ_j middle[0, j]·u^j, t' = Σ_j middle[1, j]·u^j and h = ϑ² Σ_j middle[2, j]·u^j.

    Attributes:
        knots: shape (n + 1,) [rad], strictly increasing from 0 to the cam's range.
        coefficients: shape (n, d), C order, [m/rad^j].
        lifts: shape (n,) [m], the lift at knots[k]; lifts[0] = 0.
        middle: shape (3, (d + 1)/2), C order [m/rad], [m/rad], [m/rad²].
    """

    knots: FloatArray
    coefficients: FloatArray
    lifts: FloatArray
    middle: FloatArray


Lever: TypeAlias = LinearLever | ArcLever | TableLever | SpringLever | SmoothLever
