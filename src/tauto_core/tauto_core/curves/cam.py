"""The cam: a lever arm as a function of the angle, and the curve that gives it.

Euler, *De novo quodam curvarum tautochronarum genere* (1727). The lever arm t(ϑ) is the distance
of the thread's line from the axle. In the wheel's frame these lines have the support function t,
and the cheek is their envelope. With ψ the direction of a line's normal: p = dt/dψ, contact point
t (cos ψ, sin ψ) + p (−sin ψ, cos ψ), radius of curvature R = t + dp/dψ. A vertical thread has ψ =
ϑ (§VII–XIV), a thread through a hole at distance a from the axle ψ = ϑ + arcsin(t/a) (§XXII–XXIX).

The frame turns with the wheel. +y points along the thread at rest, towards weight or hole.
Angles are radians, lengths metres. Every function takes numbers or arrays of any shape.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, NamedTuple, TypeAlias

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike
from pydantic import Field

from tauto_core.curves.lever_geometry import LeverLinkage, LeverSetting
from tauto_core.curves.materials import NamedMaterial
from tauto_core.curves.numerics import (
    ArrayFunction,
    bisect,
    bracketed_newton,
    powers_on_unit,
)
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import CamRangeError, SceneError, TautoError
from tauto_core.scene.sections import Kind, Positive

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# -----------------------------------------------------------------------------
# Lever arms t(ϑ) as plain numbers: all that a compiled kernel needs of a cam.
#
# All are odd, t(−ϑ) = −t(ϑ). Lifts h = ∫ t dϑ are even.


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
        root_depth: depth of the cheek's root below the axle [m], > 0, equal to t'(0).
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
        coefficients: shape (n, 6), C order, [m/rad^j], with exact zeros for even j on piece 0.
        lifts: shape (n,) [m], the lift at knots[k], lifts[0] = 0.
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
    """An analytic lever arm as polynomials in |ϑ|, with joints below rounding.

    On n pieces as TableLever, of any degree. Up to knots[1], with u = (ϑ/knots[1])²,
    t = ϑ Σ_j middle[0, j]·u^j, t' = Σ_j middle[1, j]·u^j and h = ϑ² Σ_j middle[2, j]·u^j.

    Attributes:
        knots: shape (n + 1,) [rad], strictly increasing from 0 to the cam's range.
        coefficients: shape (n, d), C order, [m/rad^j].
        lifts: shape (n,) [m], the lift at knots[k], lifts[0] = 0.
        middle: shape (3, (d + 1)/2), C order [m/rad], [m/rad], [m/rad²].
    """

    knots: FloatArray
    coefficients: FloatArray
    lifts: FloatArray
    middle: FloatArray


LeverArm: TypeAlias = LinearLever | ArcLever | TableLever | SpringLever | SmoothLever


ROOT_ROUNDING = 4.0 * np.finfo(np.float64).eps
"""Relative rounding of a lift, and of the root of an equation for an angle."""

# Relative rounding of an angle at the edge of a range, and of a lever arm there.
_ROUNDING = 16.0 * np.finfo(np.float64).eps


class _Thread(NamedTuple):
    """The thread's line: sine and cosine of its angle at the hole, and the rate t'/a."""

    sine: FloatArray
    cosine: FloatArray
    rate: FloatArray

    @property
    def share(self) -> FloatArray:
        """dϑ/dψ = 1/(1 + t'/s), s the distance from the hole to the foot of t."""
        return self.cosine / (self.cosine + self.rate)


def arm_rounding(angle: ArrayLike, arm: ArrayLike, rate: ArrayLike) -> FloatArray:
    """Return the possible change of a lever arm by rounding of the angle and of the law [m]."""
    size = np.abs(arm) + np.abs(np.asarray(rate) * np.asarray(angle))
    return np.asarray(_ROUNDING * size)


class Cam(ABC):
    """A pair of mirror-image cheeks: t and ψ are odd in ϑ, lift, p, arc and R are even.

    A cam gives `range_rad` and its law at angles x = |ϑ| within the range, as arrays of
    any shape: `_arm`, `_rate`, `_bend` and `_lift`. `cams.table` has these for a cam given by a
    function (`Fitted`) or by points (`Table`).

    All methods of an angle raise CamRangeError beyond `range_rad`, and at NaN.

    Attributes:
        kinked: whether t has a |ϑ|ϑ term at ϑ = 0, a jump of t''.
        knows_angle_of_lift: whether `angle_of_lift` is a closed form.
        distance: distance of the hole from the axle [m], inf for a vertical thread.
        widening: the change that widens its range, as the end of a sentence.
    """

    kinked: bool = False
    knows_angle_of_lift: bool = False
    distance: float = math.inf
    widening: ClassVar[str] = ', or give the cam a wider range'

    @property
    def lever(self) -> LeverArm:
        """The law of the lever arm as plain numbers, for kernels, by default polynomials."""
        return self._polynomials

    @cached_property
    def _polynomials(self) -> SmoothLever:
        return smooth_lever(self.lever_arm, self.lift, self.range_rad, self.joints)

    @property
    @abstractmethod
    def range_rad(self) -> float:
        """Largest |ϑ| with the thread on the cheek [rad], or inf."""

    @abstractmethod
    def _arm(self, x: FloatArray) -> FloatArray:
        """Return t [m]."""

    @abstractmethod
    def _rate(self, x: FloatArray) -> FloatArray:
        """Return t' [m/rad]."""

    @abstractmethod
    def _bend(self, x: FloatArray) -> FloatArray:
        """Return t'' [m/rad²], or its limit from above for a kinked cam at 0."""

    @abstractmethod
    def _lift(self, x: FloatArray) -> FloatArray:
        """Return h = ∫ t dϑ from 0 [m]."""

    @property
    def drawn_rad(self) -> float:
        """Angle up to which the cheek is drawn and checked by default [rad]: at most a turn."""
        return min(self.range_rad, math.tau)

    @property
    def linear_rate(self) -> float | None:
        """dt/dϑ [m/rad] if the lever arm is exactly linear, else None."""
        return None

    @property
    def suits(self) -> tuple[float, float] | None:
        """(m/I [1/m²], κ/P [1/m]) of the power for which the cam is isochronous."""
        return None

    @property
    def joints(self) -> FloatArray:
        """Angles within the range at which t is not analytic [rad], increasing."""
        return np.empty(0)

    def lever_arm(self, angle: ArrayLike) -> FloatArray:
        """Return t(ϑ) [m]."""
        angle = self.within(angle)
        return np.copysign(1.0, angle) * self._arm(np.abs(angle))

    def lever_rate(self, angle: ArrayLike) -> FloatArray:
        """Return dt/dϑ [m/rad]."""
        return self._rate(np.abs(self.within(angle)))

    def lever_curvature(self, angle: ArrayLike) -> FloatArray:
        """Return d²t/dϑ² [m/rad²], or its limit from that side for a kinked cam at ±0."""
        angle = self.within(angle)
        return np.copysign(1.0, angle) * self._bend(np.abs(angle))

    def lift(self, angle: ArrayLike) -> FloatArray:
        """Return h = ∫ t dϑ from 0 [m]: the rise of the weight, or the extension of the spring."""
        return self._lift(np.abs(self.within(angle)))

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return the ϑ ≥ 0 at which the lift is h [rad], to rounding, for t > 0 at ϑ > 0.

        Newton's method on √h, which is nearly linear in ϑ. CamRangeError: a lift [m] that is
        negative, NaN or beyond the cam's range.
        """
        lift, _ = self._reached(lift)
        goal, edge = np.sqrt(lift), self.range_rad
        rate, start = float(self.lever_rate(0.0)), np.full_like(lift, 0.5 * edge)
        if rate:
            start = np.minimum(np.sqrt(2.0 * lift / rate), start)

        def excess(angle: FloatArray) -> tuple[FloatArray, FloatArray]:
            root, arm = np.sqrt(self._lift(angle)), self._arm(angle)
            return root - goal, np.divide(arm, 2.0 * root, np.zeros_like(arm), where=root > 0.0)

        return bracketed_newton(excess, start, (0.0, edge), relative=ROOT_ROUNDING)

    def _reached(self, lift: ArrayLike) -> tuple[FloatArray, float]:
        """Return lifts that the cam reaches, and the highest, itself rounded [m]."""
        lift = np.asarray(lift, dtype=np.float64)
        highest = float(self.lift(self.range_rad))
        if not np.all((lift >= 0.0) & (lift <= highest * (1.0 + ROOT_ROUNDING))):
            raise CamRangeError(
                f'lifts from {float(np.min(lift))!r} to {float(np.max(lift))!r} m: the cam '
                f'{self!r} lifts by at most {highest!r} m. Use a smaller amplitude or a '
                'cam with a wider range'
            )
        return lift, highest

    def psi(self, angle: ArrayLike) -> FloatArray:
        """Return ψ, the direction of the normal of the thread's line [rad], 0 at rest."""
        angle, thread = self._thread(angle)
        return angle + np.arctan2(thread.sine, thread.cosine)

    def p(self, angle: ArrayLike) -> FloatArray:
        """Return p = dt/dψ = t'/(1 + t'/√(a² − t²)) [m] (§XXIX)."""
        angle, thread = self._thread(angle)
        return self._rate(np.abs(angle)) * thread.share

    def contact(self, angle: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the point at which the thread leaves the cheek, (x, y) in the wheel's frame [m].

        Positive angles use the cheek at x < 0.
        """
        angle, thread = self._thread(angle)
        arm, rate = self.lever_arm(angle), self.lever_rate(angle)
        sine, cosine = np.sin(angle), np.cos(angle)
        # the contact of a vertical thread, and t·s·(−sin ϑ, cos ϑ) with s the sine at the hole
        scale, along = thread.cosine * thread.share, arm * thread.sine
        x = scale * (arm * cosine - rate * sine) - along * sine
        return x, scale * (arm * sine + rate * cosine) + along * cosine

    def radius_of_curvature(self, angle: ArrayLike) -> FloatArray:
        """Return R = sgn ϑ·(t + dp/dψ) [m].

        R = |t| (1 − w³) + (1 − w)³ |t|'', w = t'/(t' + √(a² − t²)). It is negative in a hollow,
        which a thread would bridge.
        """
        angle, thread = self._thread(np.abs(angle))
        share = thread.share
        w = 1.0 - share
        bend = self._bend(angle) * (share * share * share)
        return self._arm(angle) * share * (1.0 + w + w * w) + bend

    def within(self, angle: ArrayLike) -> FloatArray:
        """Return the angle as an array. CamRangeError: an angle beyond the range."""
        angle = np.asarray(angle, dtype=np.float64)
        bad = ~(np.abs(angle) <= min(self.range_rad, np.finfo(np.float64).max))
        if np.any(bad):
            worst = float(np.atleast_1d(angle)[np.atleast_1d(bad)][0])
            raise CamRangeError(
                f'angle {worst!r} rad is beyond the range ±{self.range_rad!r} rad of the cam '
                f'{self!r}. Use a smaller amplitude or a cam with a wider range'
            )
        return angle

    def _thread(self, angle: ArrayLike) -> tuple[FloatArray, _Thread]:
        """Return the angle as an array, and the thread's line. CamRangeError: t is too long."""
        angle = self.within(angle)
        arm, rate = self.lever_arm(angle), self.lever_rate(angle)
        a = self.distance
        if math.isinf(a):
            return angle, _Thread(np.zeros_like(arm), np.ones_like(arm), np.zeros_like(arm))
        too_long = ~(np.abs(arm) <= a + arm_rounding(angle, arm, rate))
        if np.any(too_long):
            longest = float(np.atleast_1d(np.abs(arm))[np.atleast_1d(too_long)][0])
            raise CamRangeError(
                f'a lever arm of {longest!r} m is longer than the hole is away, {a!r} m, on the '
                f'cam {self!r}. Use a smaller amplitude or move the hole away'
            )
        arm = np.clip(arm, -a, a)
        return angle, _Thread(arm / a, np.sqrt((a - arm) * (a + arm)) / a, rate / a)


# -----------------------------------------------------------------------------
# Possible cams: a thread wraps only a convex cheek, has a thickness, and pulls back.
#
# Every machine and every drawing passes through `possible_cam` or `possible_lever`.
#
# The radius of curvature R must not be negative under the thread, which would bridge a hollow. The
# centre line of a thread of thickness e follows the cam's curve, and the cheek is the parallel
# curve e/2 inwards, which does not exist for R < e/2. Every cam that is smooth through rest has
# R = 0 at its tip: a thick thread bends round the cheek's edge.

_PROBES = 2000
_FLAT = 1e-12


def possible_cam(
    cam: Cam, kind: str, if_hollow: str = 'let the lever arm bend down less there'
) -> Cam:
    """Return a cam after a check over its range, or over a turn if that is unlimited.

    SceneError, with the kind: a lever arm that is not a number or does not drive the wheel back,
    one longer than the hole is away, or a hollow cheek, with the remedy `if_hollow`.
    """
    edge = cam.range_rad if math.isfinite(cam.range_rad) else cam.drawn_rad
    if not edge > 0.0:
        raise _impossible(kind, f'has a range of {edge!r} rad', 'Give it a range above 0.')
    angles = _probes(edge)
    arms = cam.lever_arm(angles)
    at, rate = _first(~(arms > 0.0)), float(cam.lever_rate(0.0))
    # cheeks rooted in the axle drive the wheel back as the square of the angle
    if at is not None or not (rate > 0.0 or (rate == 0.0 and cam.kinked)):
        where = 'at rest' if at is None else f'at {angles[at]:.6g} rad'
        what = 'of 0 a radian' if at is None else f'of {arms[at]:.6g} m'
        raise _impossible(
            kind,
            f'has a lever arm {what} {where}, which does not drive the wheel back',
            'Make the lever arm rise from rest, and end before 0.',
        )
    # the range is rounded and the lever arm steep there
    allowed = cam.distance + arm_rounding(angles, arms, cam.lever_rate(angles))
    at = _first(~(arms <= allowed))
    if at is not None:
        raise _impossible(
            kind,
            f'has a lever arm of {arms[at]:.6g} m at {angles[at]:.6g} rad, longer than the hole '
            f'is away, trochlea.thread.distance = {cam.distance!r} m',
            f'End the cam before {angles[at]:.6g} rad, or move the hole away.',
        )
    for low, high in too_sharp(cam, 0.0, edge)[:1]:
        problem = (
            f'has a cheek that would be hollow from {low:.6g} to {high:.6g} rad (a '
            'radius of curvature below 0), and a thread bridges a hollow'
        )
        earlier = f'end the cam before {low:.6g} rad, or ' if low > 0.0 else ''
        remedy = f'{earlier}{if_hollow}.'
        raise _impossible(kind, problem, remedy[0].upper() + remedy[1:])
    return cam


def possible_lever(shape: LeverLinkage, kind: str) -> LeverLinkage:
    """Return cam, thread and lever of Sully's machine after a check between its edges.

    SceneError: a lever arm that does not drive the wheel back, a wheel that turns back while the
    lever rises, a thread that is wound up, or a hollow cheek.
    """
    low, high = shape.edges
    if not low < 0.0 < high:
        raise _impossible(kind, f'reaches from {low!r} to {high!r}', 'Let it reach to both sides.')
    for edge in (low, high):
        tau = np.linspace(0.0, edge, _PROBES // 4 + 1)[1:]
        pose, theta_rate = shape.pose(tau), shape.rates(tau)[0]
        arms = shape.base_radius * np.abs(tau) * shape.u_per_tau(tau)
        wound = np.abs(pose.u)
        radius = arms + np.gradient(np.gradient(arms, wound), wound)
        # differences are one-sided at the ends
        radius[:2], radius[-2:] = radius[2], radius[-3]
        for bad, problem, remedy in (
            (~(arms > 0.0), 'has a lever arm that does not drive the wheel back', 'End it before'),
            (~(theta_rate > 0.0), 'turns the wheel back as the lever rises', 'End it before'),
            (
                ~(pose.free > 0.0),
                'winds up the whole thread',
                'Use a longer thread, or end before',
            ),
            (
                # second differences err by 1e-5 of the largest lever arm
                ~(radius >= -1e-3 * arms.max()),
                'has a cheek that would be hollow, and a thread bridges a hollow,',
                'Let the lever arm bend down less, or end before',
            ),
        ):
            at = _first(bad)
            if at is not None:
                where = f'{pose.u[at]:.6g} rad of thread wound up'
                raise _impossible(kind, f'{problem} at {where}', f'{remedy} that angle.')
    return shape


def _impossible(kind: str, problem: str, remedy: str) -> SceneError:
    return SceneError('trochlea', 'trochlea.cam.kind', kind, problem, remedy)


def _first(bad: np.ndarray) -> int | None:
    """Return the index of the first true element, if any."""
    indices = np.flatnonzero(bad)
    return int(indices[0]) if len(indices) else None


def too_sharp(
    cam: Cam, radius: float, reach_rad: float | None = None
) -> list[tuple[float, float]]:
    """Return the intervals of angles [rad] with R < radius [m], but for rounding.

    With the radius 0 they are hollow. The search ends at `reach_rad`, by default `cam.drawn_rad`.
    """
    edge = cam.drawn_rad if reach_rad is None else reach_rad

    def is_wide(angles: FloatArray) -> np.ndarray:
        excess = cam.radius_of_curvature(angles) - radius
        return np.asarray(excess + _FLAT * cam.lever_arm(angles) >= 0.0)

    angles = _probes(edge)
    wide = is_wide(angles)
    bounds = [] if wide[0] else [0.0]
    for i in np.flatnonzero(np.diff(wide)).tolist():
        good, bad = (i, i + 1) if wide[i] else (i + 1, i)
        ends = float(angles[good]), float(angles[bad])
        bounds.append(bisect(lambda at: bool(is_wide(np.array([at]))[0]), *ends)[0])
    bounds += [] if wide[-1] else [edge]
    return list(zip(bounds[::2], bounds[1::2], strict=True))


def _probes(edge: float) -> FloatArray:
    """Return angles up to `edge` for a check [rad], denser at both ends.

    R may vanish at the ends. The angles go down to the tip itself.
    """
    even = edge * np.sin(np.linspace(0.0, 0.5 * math.pi, _PROBES)) ** 2
    return np.unique(np.concatenate([edge * np.logspace(-9.0, -4.0, 11), even[1:]]))


# -----------------------------------------------------------------------------
# An analytic lever arm as polynomials to rounding, the form that kernels evaluate.
#
# Chebyshev interpolation on pieces, each as long as one degree can represent to rounding. Towards
# a singularity just beyond the range the pieces shorten in proportion to its distance. The first
# piece is a polynomial in ϑ², to keep the relative accuracy of t down to rest.

TERMS = 12
"""Terms of the first piece, in ϑ². The others have twice as many, in ϑ."""

RESOLVED = 4e-16
"""Largest size of the last coefficients over the first."""

SHORTEST = 2.0**-48
_CHECKED = (np.arange(32) + 0.5) / 32


class FitError(TautoError):
    """A lever arm that no polynomials represent, since it is not smooth."""


def smooth_lever(
    arm: ArrayFunction, lift: ArrayFunction, edge: float, joints: ArrayLike = ()
) -> SmoothLever:
    """Return an odd lever arm t(ϑ), h = ∫ t dϑ on 0 ≤ ϑ ≤ edge, as polynomials.

    The two functions give t and h [m] of angles to rounding. t is analytic except at the joints
    [rad], which increase between 0 and the edge. FitError: pieces of 2⁻⁴⁸ of the range do not
    resolve the lever arm.
    """
    ends = np.append(joints, edge)

    def ratio(u: FloatArray) -> FloatArray:
        angle = knot * np.sqrt(u)
        return arm(angle) / angle

    def piece(x: FloatArray) -> FloatArray:
        return arm(np.minimum(begin + span * x, edge))

    # the first piece: t/ϑ in u = (ϑ/knot)²
    knot = float(ends[0])
    while (even := _interpolated(ratio, TERMS)) is None:
        # halving would make up to twice the necessary number of pieces
        knot *= 0.8
        if not knot > SHORTEST * edge:
            raise _rough(0.0)
    powers = np.arange(TERMS)
    row = np.zeros(2 * TERMS)
    row[1::2] = even / knot ** (2 * powers)
    knots, rows = [0.0, knot], [row]
    # the others, in ϑ less their left end
    begin, width = knot, knot
    while begin < edge:
        end = float(ends[np.searchsorted(ends, begin, side='right')])
        # away from a singularity pieces may grow
        width = min(1.5 * width, end - begin)
        while True:
            # the last piece ends exactly at the edge, or at a joint
            right = end if width >= (1.0 - 1e-9) * (end - begin) else begin + width
            span = right - begin
            terms = _interpolated(piece, 2 * TERMS, 4.0 * 2.0**-52 * right / span)
            if terms is not None:
                break
            width *= 0.8
            if width < SHORTEST * edge:
                raise _rough(begin)
        rows.append(terms / span ** np.arange(2 * TERMS))
        knots.append(right)
        begin = right
    middle = np.array([even, even * (2 * powers + 1), even / (2 * powers + 2)])
    starts = np.array(knots)
    lifts = np.concatenate([[0.0], lift(starts[1:-1])])
    return SmoothLever(starts, np.array(rows), lifts, middle)


def _interpolated(function: ArrayFunction, terms: int, blur: float = 0.0) -> FloatArray | None:
    """Return the coefficients of x^j of a function on 0 ≤ x ≤ 1, if they resolve it.

    The function is accurate to rounding of its value, and x to the blur.
    """
    nodes = 0.5 * (chebyshev.chebpts1(terms) + 1.0)
    values = function(nodes)
    series = chebyshev.chebfit(2.0 * nodes - 1.0, values, terms - 1)
    noise = blur * float(np.ptp(values))
    if not np.max(np.abs(series[-2:])) <= RESOLVED * np.max(np.abs(series)) + noise:
        return None
    row = powers_on_unit(series)
    wanted = function(_CHECKED)
    wrong = np.abs(np.polynomial.polynomial.polyval(_CHECKED, row) - wanted)
    return row if np.all(wrong <= 8.0 * (RESOLVED * np.abs(wanted) + noise)) else None


def _rough(angle: float) -> FitError:
    return FitError(
        f'the lever arm near {angle!r} rad is not smooth enough for polynomials of degree '
        f'{2 * TERMS - 1}. Use a smaller range, or tabulate the cam'
    )


# -----------------------------------------------------------------------------
# A force that depends on the lift in any way (D in cams.md).

LEAST_POINTS = 6
"""Of a quintic spline."""


class ForceSplines(NamedTuple):
    """F, F', F'' and E."""

    force: PPoly
    slope: PPoly
    bend: PPoly
    energy: PPoly


@dataclass(frozen=True)
class ForceLaw:
    """F(h) as the quintic spline through points, with continuous derivatives up to the fourth.

    Its ends are not-a-knot: a polynomial up to the fifth degree, such as a spring's force, is
    reproduced.

    Attributes:
        points: six or more lifts [m], which increase from 0, and forces [N], > 0.
    """

    points: tuple[tuple[float, float], ...] = field(repr=False)

    @cached_property
    def splines(self) -> ForceSplines:
        """The law and the functions derived from it."""
        from scipy.interpolate import PPoly, make_interp_spline  # slow to import

        lifts, forces = np.array(self.points).T
        spline = PPoly.from_spline(make_interp_spline(lifts, forces, k=5).tck)
        knots = np.unique(spline.x)
        pieces = np.searchsorted(spline.x, knots[:-1], side='right') - 1
        force = PPoly(np.ascontiguousarray(spline.c[:, pieces]), knots)
        return ForceSplines(force, force.derivative(), force.derivative(2), force.antiderivative())

    @property
    def at_rest(self) -> float:
        """F(0) [N]."""
        return float(self.force(0.0))

    @property
    def longest(self) -> float:
        """The largest lift of the points [m]."""
        return self.points[-1][0]

    @property
    def joints(self) -> FloatArray:
        """Lifts at which the fifth derivative jumps [m], increasing."""
        return np.asarray(self.splines.force.x[1:-1])

    @property
    def least(self) -> tuple[float, float]:
        """Lift [m] and value [N] of the least force between the points."""
        extremes = self.splines.slope.roots(extrapolate=False)
        lifts = np.concatenate([extremes[np.isfinite(extremes)], [0.0, self.longest]])
        forces = self.force(lifts)
        at = int(np.argmin(forces))
        return float(lifts[at]), float(forces[at])

    def force(self, lift: ArrayLike) -> FloatArray:
        """Return F [N] at lifts of 0 to `longest`."""
        return np.asarray(self.splines.force(np.asarray(lift, np.float64)))

    def slope(self, lift: ArrayLike) -> FloatArray:
        """Return dF/dh [N/m]."""
        return np.asarray(self.splines.slope(np.asarray(lift, np.float64)))

    def bend(self, lift: ArrayLike) -> FloatArray:
        """Return d²F/dh² [N/m²]."""
        return np.asarray(self.splines.bend(np.asarray(lift, np.float64)))

    def energy(self, lift: ArrayLike) -> FloatArray:
        """Return E = ∫ F dh from 0 [J]."""
        return np.asarray(self.splines.energy(np.asarray(lift, np.float64)))

    def lift_of_energy(self, energy: ArrayLike) -> FloatArray:
        """Return the lift [m] of an energy E ≥ 0 [J], to rounding."""
        goal = np.asarray(energy, np.float64)

        def excess(lift: FloatArray) -> tuple[FloatArray, FloatArray]:
            return self.energy(lift) - goal, self.force(lift)

        start = np.minimum(goal / self.at_rest, self.longest)
        return bracketed_newton(excess, start, (0.0, self.longest), relative=ROOT_ROUNDING)


# -----------------------------------------------------------------------------
# The base of all kinds of cam.

CAMS = 'tauto_core.curves.cams'


class Pull(NamedTuple):
    """The pull of a power in the thread: F = force + stiffness · lift + pulling_mass · g_eff.

    Attributes:
        carried_mass: m, the mass with inertia on the thread [kg].
        pulling_mass: mass of the weight that pulls [kg].
        force: constant pull, or pull of a spring at zero draw [N].
        stiffness: stiffness of a spring [N/m].
        law: any other dependence of the force on the lift, F(0) = force.
    """

    carried_mass: float = 0.0
    pulling_mass: float = 0.0
    force: float = 0.0
    stiffness: float = 0.0
    law: ForceLaw | None = None

    def at_rest(self, gravity: float) -> float:
        """Return F(0) on land [N]."""
        return self.force + self.pulling_mass * gravity


class Setting(NamedTuple):
    """The properties of the machine that determine a cam.

    Attributes:
        inertia: I of the wheel [kg m2].
        pull: the pull of the power.
        gravity: g [m/s2].
        distance: distance of the hole from the axle [m], inf for a vertical thread.
    """

    inertia: float
    pull: Pull
    gravity: float
    distance: float = math.inf


class CamKind(Kind):
    """A cam of a scene. Each kind is a module of `curves/cams` with a `KIND`.

    Attributes:
        threads: the kinds of thread that it takes.
        corrects: its power, as in `PowerKind.acts_as`, or '' for any.
        if_hollow: remedy for a hollow cheek, as a clause.
    """

    threads: ClassVar[tuple[str, ...]]
    corrects: ClassVar[str] = ''
    if_hollow: ClassVar[str] = 'let the lever arm bend down less there'

    kind: str
    material: NamedMaterial | None = Field(
        default=None,
        description='a name, or mapping: expansion. When left out it is trochlea.material',
    )

    def made(self, setting: Setting) -> Cam:
        """Return the cam for an ideal thread.

        Raises:
            SceneError: no such cam, or an unusable table.
        """
        raise self._no_cheek('an ideal thread')

    def on_lever(self, lever: LeverSetting) -> LeverLinkage:
        """Return cam, thread and lever of Sully's machine.

        Raises:
            SceneError: a cam that does not go with a lever.
        """
        raise self._no_cheek('a lever')

    def files(self) -> Iterator[tuple[str, str]]:
        """Yield key and path of the files that must exist when a scene is loaded."""
        return iter(())

    def _no_cheek(self, thread: str) -> SceneError:
        return SceneError(
            'trochlea',
            'trochlea.cam.kind',
            self.kind,
            f'does not go with {thread}',
            f'`tauto scene new --cam {self.kind}` writes a scene with a thread that fits.',
        )


class PeriodCam(CamKind):
    """A cam that is made for one period."""

    threads: ClassVar[tuple[str, ...]] = ('vertical', 'hole')
    starter: ClassVar[Mapping[str, object]] = {'period': 1.0}

    period: Positive = Field(description='period of every swing on land [s]')


def rate_for_period(setting: Setting, period: float) -> float:
    """Return t'(0) = I ω²/F(0) for a period of small swings [m/rad].

    SceneError: a period that is impossible with wheel and power.
    """
    omega = math.tau / period
    rate = setting.inertia * omega * omega / setting.pull.at_rest(setting.gravity)
    if not 0.0 < rate < math.inf:
        raise SceneError(
            'trochlea',
            'trochlea.cam.period',
            period,
            f'asks for a lever arm of {rate!r} m a radian at rest',
            'Give a period in seconds that wheel and power can keep, for example 1.0.',
        )
    return rate
