"""Curves in a fluid with two different branches, and the companion of a given branch.

Euler 1729 makes the descent alone isochronous. In §7 he leaves open his first problem: to find the
curve that, joined to a given one, makes the oscillations equal.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from tauto_core.curves.fluid import CurveInMedium, Cycloid, DescentCurve
from tauto_core.curves.numerics import (
    QuadratureError,
    bisect,
    bracketed_newton,
    chebyshev_coefficients,
    chebyshev_nodes,
    complete_series,
    exponential_mean,
    integrate,
    logarithmic_mean,
    repeated_rule,
)
from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene.errors import DescentError

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

Side: TypeAlias = Literal['descent', 'ascent']

_ROUNDING = 4.0 * np.finfo(np.float64).eps
_COUNTS = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)
# Number of places for checks of the slope.
_SCANNED = 400
# Longest branch over 1/κ: a body falls at terminal speed on most of a longer one.
_MOST_REDUCED = 64.0
_THICK = (
    'the fluid resists too strongly, or the curve is too uneven. Use a smaller amplitude, a '
    'larger or denser body, or a lighter fluid'
)


class Pieces:
    """A function as a Chebyshev series between each two neighbours of its edges.

    Args:
        edges: the edges, increasing, (n + 1,).
        function: its values at x, (m,), between the edges k and k + 1.
        tail: size of the last coefficients, over the largest, at which a series is complete.

    Raises:
        QuadratureError: a series of more than 256 terms.
    """

    def __init__(
        self,
        edges: FloatArray,
        function: Callable[[FloatArray, int], FloatArray],
        tail: float = 2.0**-49,
    ) -> None:
        self.edges, rows = edges, []
        for k, (low, high) in enumerate(pairwise(edges.tolist())):

            def series(count: int, k: int = k, low: float = low, high: float = high) -> FloatArray:
                middle, size = 0.5 * (high + low), 0.5 * (high - low)
                return chebyshev_coefficients(function(middle + size * chebyshev_nodes(count), k))

            terms = complete_series(series, _COUNTS, tail, tail_count=3)
            if terms is None:
                raise QuadratureError(f'a branch takes more than {_COUNTS[-1]} terms: {_THICK}')
            rows.append(terms)
        longest = max(map(len, rows))
        padded = [np.pad(row, (0, longest - len(row))) for row in rows]
        self._terms = np.ascontiguousarray(np.stack(padded, axis=1))

    def __call__(self, x: FloatArray) -> FloatArray:
        """Return the values at x, of any shape."""
        return self._sum(self._terms, x)[0]

    def rate(self, x: FloatArray) -> FloatArray:
        """Return the derivatives at x, of any shape."""
        rates = np.asarray(chebyshev.chebder(self._terms, axis=0), np.float64)
        sums, width = self._sum(rates, x)
        return 2.0 / width * sums

    def on_pieces(self, x: FloatArray) -> FloatArray:
        """Return the values at x of (m, n, places), each in its piece."""
        low, high = self.edges[:-1, None], self.edges[1:, None]
        share = np.clip((2.0 * x - low - high) / (high - low), -1.0, 1.0)
        return np.asarray(chebyshev.chebval(share, self._terms[:, None, :, None], tensor=False))

    def _sum(self, terms: FloatArray, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the sums at x, and the widths of the pieces."""
        index = np.clip(np.searchsorted(self.edges, x, 'right') - 1, 0, len(self.edges) - 2)
        low, high = self.edges[index], self.edges[index + 1]
        share = (2.0 * x - low - high) / (high - low)
        sums = chebyshev.chebval(share, terms[:, index], tensor=False)
        return np.asarray(sums), high - low


# -----------------------------------------------------------------------------
# A branch in one direction of the motion: the body falls on it to the zero of the force, or rises
# from there.
#
# Let x be the arc from that zero, F(x) > 0 the force along the branch over γ times the weight in
# vacuum (the slope ∓ a constant friction), and q = −2κ for a fall, 2κ for a rise. With
#
#     τ = γ ∫ e^{qσ} F dσ from 0 to x,    r = √τ,    z = ∫ e^{qσ/2} dσ,    G = dz/dr,
#
# and b the value of τ at the end of the swing, ½ẋ² = g e^{−qx} (b − τ) and dt = dz/√(2g(b − τ)).
# With r = √b sin ψ the time between two places is ∫ G(√b sin ψ) dψ/√(2g): no root remains. A half
# swing falls and rises with the same b. Euler's curve of descent has z = √(2f) r.


class Quarter:
    """A branch in one direction, to a reach.

    Args:
        force: F(x), > 0 for x > 0.
        kappa: κ [1/m].
        gamma: γ.
        falling: whether the body falls on it.
        reach: largest x [m].
        joints: values of x at which F is not smooth [m].

    Raises:
        QuadratureError: a resistance so strong that no series describes the branch.
    """

    def __init__(
        self,
        force: Callable[[FloatArray], FloatArray],
        kappa: float,
        gamma: float,
        *,
        falling: bool,
        reach: float,
        joints: FloatArray,
    ) -> None:
        if not kappa * reach < _MOST_REDUCED:
            raise QuadratureError(f'a branch of {reach!r} m with kappa = {kappa!r} 1/m: {_THICK}')
        self._force, self._gamma = force, gamma
        self._growth = -2.0 * kappa if falling else 2.0 * kappa
        inner = joints[(joints > 0.0) & (joints < reach)]
        self._edges = np.concatenate([[0.0], np.unique(inner), [reach]])
        pieces = np.arange(len(self._edges) - 1)
        panels = 1 + int(kappa * float(np.max(np.diff(self._edges))))
        self._sums, parts = np.zeros(len(self._edges)), np.zeros(len(pieces))
        # Gauss's error falls so fast that two equal sums have converged
        for self._panels in (panels, 2 * panels, 4 * panels, 8 * panels, 16 * panels):
            old, parts = parts, self._potential(self._edges[1:], pieces)
            if np.all(np.abs(parts - old) <= 4e-16 * parts):
                break
        self._sums[1:] = np.cumsum(parts)
        self.roots = np.sqrt(self._sums)
        """r at 0, at the joints and at the reach."""
        self._arc_per_root = Pieces(self.roots, lambda r, k: self._arc(r, k) / r)
        self._spread = Pieces(self.roots, self._spread_at)
        self._nodes = 1
        top = np.array([self.roots[-1]]), np.array([0.5 * math.pi])
        total = float(self.time(*top)[0])
        for self._nodes in (2, 4, 8, 16):
            old_total, total = total, float(self.time(*top)[0])
            if abs(total - old_total) <= 4e-15 * total:
                break
        else:
            raise QuadratureError(f'a branch of {reach!r} m with kappa = {kappa!r} 1/m: {_THICK}')

    def root(self, arc: FloatArray) -> FloatArray:
        """Return r = √τ of arcs, (n,)."""
        index = np.clip(np.searchsorted(self._edges, arc, 'right') - 1, 0, len(self._edges) - 2)
        return np.sqrt(np.maximum(self._potential(arc, index), 0.0))

    def arc(self, root: FloatArray) -> FloatArray:
        """Return the arc x of r, of any shape."""
        return root * self._arc_per_root(root)

    def spread(self, root: FloatArray) -> FloatArray:
        """Return G = dz/dr of r, of any shape."""
        return self._spread(root)

    def speed(self, arc: FloatArray, top: FloatArray, angle: FloatArray) -> FloatArray:
        """Return |ẋ|/√(2g) = e^{−qx/2} √b cos ψ at ψ of a swing with r = √b at its end."""
        return np.exp(-0.5 * self._growth * arc) * top * np.cos(angle)

    def time(self, top: FloatArray, angle: FloatArray) -> FloatArray:
        """Return √(2g) times the time between x = 0 and ψ, in swings with r = √b at the end."""
        safe = np.where(top > 0.0, top, 1.0)[:, None]
        cuts = np.arcsin(np.minimum(self.roots[:-1] / safe, 1.0))
        cuts = np.concatenate([cuts, np.full_like(safe, 0.5 * math.pi)], axis=1)
        cuts = np.minimum(cuts, angle[:, None])
        places, weights = repeated_rule(self._nodes)
        width = np.diff(cuts, axis=1)[..., None]
        r = top[:, None, None] * np.sin(cuts[:, :-1, None] + width * places)
        values = self._spread.on_pieces(r)
        return np.asarray(np.sum(values * weights * width, axis=(1, 2)) / (2.0 * self._nodes))

    def angle_at(self, top: FloatArray, time: FloatArray) -> FloatArray:
        """Return ψ of a time, as `time` has it."""

        def late(angle: FloatArray) -> tuple[FloatArray, FloatArray]:
            return self.time(top, angle) - time, self.spread(top * np.sin(angle))

        start = np.minimum(time / self.spread(0.5 * top), 0.5 * math.pi)
        return bracketed_newton(late, start, (0.0, 0.5 * math.pi), absolute=_ROUNDING)

    def _potential(self, arc: FloatArray, index: IntArray) -> FloatArray:
        """Return τ of arcs in the panels of those numbers, (n,)."""
        places, weights = repeated_rule(self._panels)
        begin = self._edges[index][:, None]
        width = arc[:, None] - begin
        at = begin + width * places
        values = np.exp(self._growth * at) * self._force(at) * weights
        part = width[:, 0] * np.sum(values, axis=-1) / (2.0 * self._panels)
        return np.asarray(self._sums[index] + self._gamma * part)

    def _arc(self, root: FloatArray, k: int) -> FloatArray:
        """Return the arcs of r between two joints, (n,), by Newton's method."""
        low, high = self._edges[k], self._edges[k + 1]
        index = np.full(len(root), k)

        def excess(arc: FloatArray) -> tuple[FloatArray, FloatArray]:
            r = np.sqrt(np.maximum(self._potential(arc, index), 0.0))
            return r - root, 0.5 * self._push(arc) / np.maximum(r, 1e-300)

        share = (root - self.roots[k]) / (self.roots[k + 1] - self.roots[k])
        start = low + (high - low) * share
        return bracketed_newton(excess, start, (low, high), relative=_ROUNDING)

    def _spread_at(self, root: FloatArray, k: int) -> FloatArray:
        """Return G of r between two joints, (n,)."""
        arc = self._arc(root, k)
        return 2.0 * root * np.exp(0.5 * self._growth * arc) / self._push(arc)

    def _push(self, arc: FloatArray) -> FloatArray:
        """Return dτ/dx."""
        return self._gamma * np.exp(self._growth * arc) * self._force(arc)


# -----------------------------------------------------------------------------
# Given branches, in addition to the cycloid: a circle and a curve through points.


@dataclass(frozen=True)
class CircularDescent(CurveInMedium):
    """A circle of the radius γf, on which a body hangs from a thread: dx/ds = sin(s/γf)."""

    @property
    def radius(self) -> float:
        """R = γf [m]."""
        return self.gamma * self.pendulum_length

    @property
    def descent_cusp(self) -> float:
        """Arc of a quadrant, up to the vertical [m]."""
        return 0.5 * math.pi * self.radius

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p = sin(s/R)."""
        return np.sin(np.asarray(arc, np.float64) / self.radius)

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/ds = cos(s/R)/R [1/m]."""
        return np.cos(np.asarray(arc, np.float64) / self.radius) / self.radius

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return x = 2R sin²(s/2R) [m]."""
        sine = np.sin(0.5 * np.asarray(arc, np.float64) / self.radius)
        return 2.0 * self.radius * sine * sine


class ThroughPoints:
    """The curve through given points and their mirror images: a quintic spline of the height.

    Args:
        kappa: κ [1/m].
        gamma: γ.
        points: horizontal distance from A and height above it [m], (n, 2), both > 0, with
            increasing distances.

    Raises:
        DescentError: too few points, or a curve that does not rise from A to the last of them.
    """

    FEWEST = 3

    def __init__(self, kappa: float, gamma: float, points: FloatArray) -> None:
        from scipy.interpolate import make_interp_spline  # slow to import

        y, x = np.asarray(points, np.float64).T
        if len(y) < self.FEWEST or not (np.all(np.diff(y) > 0.0) and y[0] > 0.0):
            raise DescentError(
                f'points: {len(y)} with distances {y.tolist()[:4]!r} … m: needs at least '
                f'{self.FEWEST} points with distances > 0 in increasing order'
            )
        level = np.concatenate([-y[::-1], [0.0], y])
        height = np.concatenate([x[::-1], [0.0], x])
        self._spline: BSpline = make_interp_spline(level, height, k=5)
        self._steep = self._spline.derivative()
        self._bend = self._spline.derivative(2)
        self._far = float(y[-1])
        arcs = np.linspace(0.0, self._far, _SCANNED + 1)[1:]
        falls = np.flatnonzero(~(self._steep(arcs) > 0.0))
        if len(falls) or not float(self._bend(0.0)) > 0.0:
            where = float(arcs[falls[0]]) if len(falls) else 0.0
            raise DescentError(
                f'points: the curve through them does not rise at {where:.6g} m from A, and '
                'holds the body there. Give points that rise ever steeper, or more of them'
            )
        knots = np.unique(self._spline.t)
        self._level_joints = knots[(knots > 0.0) & (knots < self._far)]
        edges = np.concatenate([[0.0], self._level_joints, [self._far]])
        parts = integrate(self._stretch, edges[:-1], edges[1:])
        self._level_edges, self._arc_edges = edges, np.concatenate([[0.0], np.cumsum(parts)])
        self.kappa, self.gamma = kappa, gamma
        self.pendulum_length = 1.0 / (gamma * float(self._bend(0.0)))
        self.descent_cusp = float(self._arc_edges[-1])
        self.ascent_cusp = -self.descent_cusp
        self.joints = self._arc_edges[1:-1]
        self._slope_per_arc = Pieces(self._arc_edges, self._slope_over_arc)

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p = x′/√(1 + x′²), x′ = dx/dy."""
        s = np.asarray(arc, np.float64)
        return s * self._slope_per_arc(np.abs(s))

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/ds = x″/(1 + x′²)² [1/m]."""
        level = self._level(np.abs(np.asarray(arc, np.float64)))
        return np.asarray(self._bend(level) / (1.0 + self._steep(level) ** 2) ** 2)

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return x [m]."""
        return np.asarray(self._spline(self._level(np.abs(np.asarray(arc, np.float64)))))

    def _slope_over_arc(self, arc: FloatArray, piece: int) -> FloatArray:
        del piece  # no place is on an edge
        steep = self._steep(self._level(arc))
        return np.asarray(steep / np.hypot(1.0, steep) / arc)

    def _stretch(self, level: FloatArray) -> FloatArray:
        return np.hypot(1.0, self._steep(level))

    def _level(self, arc: FloatArray) -> FloatArray:
        """Return the horizontal distance y of arcs ≥ 0, of any shape, clipped at the end."""
        s = np.minimum(np.ravel(arc), self.descent_cusp)
        index = np.clip(
            np.searchsorted(self._arc_edges, s, 'right') - 1, 0, len(self._arc_edges) - 2
        )
        low, high = self._level_edges[index], self._level_edges[index + 1]
        places, weights = repeated_rule(1)

        def excess(level: FloatArray) -> tuple[FloatArray, FloatArray]:
            width = level - low
            inner = self._stretch(low[:, None] + width[:, None] * places)
            part = 0.5 * width * np.sum(inner * weights, axis=-1)
            return self._arc_edges[index] + part - s, self._stretch(level)

        share = (s - self._arc_edges[index]) / np.diff(self._arc_edges)[index]
        solution = bracketed_newton(
            excess, low + share * (high - low), (low, high), relative=_ROUNDING
        )
        return solution.reshape(np.shape(arc))


Branch: TypeAlias = Cycloid | CircularDescent | ThroughPoints

# -----------------------------------------------------------------------------
# The companion (1729, 7). Every half swing, down one branch and up the other, takes π√(L/g) if and
# only if
#
#     z(r) + z′(r) = 2√(2L) r
#
# for z of the branch of descent and z′ of the branch of ascent, since the times of both are Abel's
# integrals of dz and dz′ with one kernel. One branch determines the other, with the slope
# p = 2r e^{−qt/2}/(γG′) at the arc t, up to the vertical, p = 1.


class Companion:
    """The branch that makes the half swings over it and a given branch isochronous.

    It ends at the vertical, or with the given one. Arcs may have either sign.

    Args:
        given: the given branch.
        side: the branch of the companion itself, 'ascent' if the descent is given.
        pendulum_length: L [m]: half swings take π√(L/g).

    Raises:
        DescentError: no companion, since L is at most a quarter of the given branch's length of
            small swings.
    """

    def __init__(self, branch: Branch, side: Side, pendulum_length: float) -> None:
        self._given, self._side, self.pendulum_length = branch, side, pendulum_length
        if not 4.0 * pendulum_length > branch.pendulum_length:
            raise DescentError(
                f'pendulum_length = {pendulum_length!r} m: no companion exists, since the given '
                f'branch alone takes half as long as a pendulum of '
                f'{branch.pendulum_length!r} m and must leave some time to the other. Give '
                f'more than {0.25 * branch.pendulum_length!r} m'
            )
        self.kappa, self.gamma = branch.kappa, branch.gamma
        self._growth = -2.0 * self.kappa if side == 'descent' else 2.0 * self.kappa
        self._whole = 2.0 * math.sqrt(2.0 * pendulum_length)
        self.own = Quarter(
            branch.slope, branch.kappa, branch.gamma, falling=side == 'ascent',
            reach=branch.descent_cusp, joints=np.asarray(branch.joints),
        )  # fmt: skip
        """The given branch in its direction."""
        self.last_root = self._last_root()
        root = np.array([self.last_root])
        self.end = float(self._arc(root)[0])
        """Arc of its end [m]."""
        self.given_end = float(self.own.arc(root)[0])
        """Arc of the same swing on the given branch [m]."""
        self.descent_cusp, self.ascent_cusp = self.end, -self.end
        inner = self.own.roots[1:-1]
        self.joints = self._arc(inner[inner < self.last_root])
        edges = np.concatenate([[0.0], self.joints, [self.end]])
        # a short companion is a difference of two nearly equal functions
        factor = self._whole / (self._whole - math.sqrt(2.0 * branch.pendulum_length))
        self._slope_per_arc = Pieces(
            edges, lambda arc, _: self._slope(self._root(arc)) / arc, 2.0**-49 * factor
        )

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p, odd in the arc."""
        t = np.asarray(arc, np.float64)
        return t * self._slope_per_arc(np.abs(t))

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/dt [1/m]."""
        t = np.abs(np.asarray(arc, np.float64))
        return self._slope_per_arc(t) + t * self._slope_per_arc.rate(t)

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return the height, (1/γ) ∫ e^{−qt} 2r dr [m]."""
        root = self._root(np.abs(np.asarray(arc, np.float64)))
        flat = np.ravel(root)
        inner = self.own.roots[1:-1]
        total = np.zeros_like(flat)

        def rise(root: FloatArray) -> FloatArray:
            return 2.0 * root * np.exp(-self._growth * self._arc(root))

        for low, high in zip([0.0, *inner], [*inner, self.own.roots[-1]], strict=True):
            part = np.clip(flat, low, high)
            total += integrate(rise, np.full_like(flat, low), part)
        return np.asarray(total.reshape(root.shape) / self.gamma)

    def _slope(self, root: FloatArray) -> FloatArray:
        spread = self._whole - self.own.spread(root)
        return 2.0 * root * np.exp(-0.5 * self._growth * self._arc(root)) / (self.gamma * spread)

    def _harmonic(self, root: FloatArray) -> FloatArray:
        """Return z of this branch."""
        arc = self.own.arc(root)
        return self._whole * root - arc * exponential_mean(-0.5 * self._growth * arc)

    def _arc(self, root: FloatArray) -> FloatArray:
        """Return the arc t = (2/q) ln(1 + ½qz)."""
        z = self._harmonic(root)
        return z * logarithmic_mean(0.5 * self._growth * z)

    def _root(self, arc: FloatArray) -> FloatArray:
        """Return r of arcs from 0 to the end, of any shape, clipped at the end."""
        z = arc * exponential_mean(0.5 * self._growth * np.minimum(arc, self.end))

        def excess(root: FloatArray) -> tuple[FloatArray, FloatArray]:
            return self._harmonic(root) - z, self._whole - self.own.spread(root)

        start = self.last_root * np.minimum(arc / self.end, 1.0)
        return bracketed_newton(excess, start, (0.0, self.last_root), relative=_ROUNDING)

    def _last_root(self) -> float:
        """Return r at the end of the branch."""

        def stands(root: float) -> bool:
            at = np.array([root])
            spread = self._whole - float(self.own.spread(at)[0])
            # on the descent z has a bound, 1/κ
            room = 1.0 + 0.5 * self._growth * float(self._harmonic(at)[0])
            return spread > 0.0 and room > 0.0 and float(self._slope(at)[0]) <= 1.0

        edge = float(self.own.roots[-1])
        roots = edge * np.linspace(0.0, 1.0, _SCANNED + 1)[1:]
        good = 1e-9 * edge
        for r in roots.tolist():
            if not stands(r):
                return bisect(stands, good, r)[0]
            good = r
        return edge


class JoinedCurve:
    """The branch of descent of one curve and the branch of ascent of another, joined at A.

    Attributes:
        descent: the curve at arcs > 0.
        ascent: the curve at arcs < 0.
        pendulum_length: L [m]: a small half swing takes π√(L/g).
        descent_cusp: largest arc of a start on the branch of descent [m].
        ascent_cusp: the same on the branch of ascent [m], < 0.
        joints: arcs at which the slope is not smooth [m].
    """

    def __init__(
        self,
        descent: DescentCurve,
        ascent: DescentCurve,
        pendulum_length: float,
        ends: tuple[float, float] | None = None,
        joints: FloatArray | None = None,
    ) -> None:
        self.descent, self.ascent, self.pendulum_length = descent, ascent, pendulum_length
        self.kappa, self.gamma = descent.kappa, descent.gamma
        self.descent_cusp, self.ascent_cusp = ends or (descent.descent_cusp, ascent.ascent_cusp)
        self.joints = np.concatenate([[0.0], [] if joints is None else joints])

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p = dx/ds."""
        return self._of_sides(arc, self.descent.slope, self.ascent.slope)

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/ds [1/m], at A of the branch of descent."""
        return self._of_sides(arc, self.descent.slope_rate, self.ascent.slope_rate)

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return x(s) [m], 0 at A."""
        return self._of_sides(arc, self.descent.height, self.ascent.height)

    def _of_sides(
        self,
        arc: ArrayLike,
        descent: Callable[[ArrayLike], FloatArray],
        ascent: Callable[[ArrayLike], FloatArray],
    ) -> FloatArray:
        s = np.asarray(arc, np.float64)
        flat = np.atleast_1d(s)
        values = np.empty_like(flat)
        falls = flat >= 0.0
        values[falls], values[~falls] = descent(flat[falls]), ascent(flat[~falls])
        return values.reshape(s.shape)


def joined_companion(branch: Branch, side: Side, pendulum_length: float) -> JoinedCurve:
    """Return a given branch joined with its companion.

    Args:
        branch: a curve with the same slope on both sides of A.
        side: the given branch, 'descent' or 'ascent'.
        pendulum_length: L [m]: every half swing down the branch of descent takes π√(L/g).

    Raises:
        DescentError: no companion exists.
    """
    opposite: Side = 'ascent' if side == 'descent' else 'descent'
    added = Companion(branch, opposite, pendulum_length)
    mine = np.asarray(branch.joints)
    if side == 'descent':
        ends, joints = (added.given_end, -added.end), np.concatenate([mine, -added.joints])
        return JoinedCurve(branch, added, pendulum_length, ends, joints)
    ends, joints = (added.end, -added.given_end), np.concatenate([-mine, added.joints])
    return JoinedCurve(added, branch, pendulum_length, ends, joints)
