"""A half swing on any curve in a fluid, by quadrature.

From rest at S > 0 towards −s, s̈ = −γg p(s) + κṡ² with the slope p = dx/ds, so that

    ½ṡ² = γg ∫ e^{2κ(s − σ)} p(σ) dσ from s to S,

and the body comes to rest where the integral is 0 again, at −S₁. With s from S to −S₁ as a cosine
of θ, the time is the integral of a smooth, even, periodic function of θ, whose cosine series the
midpoint rule gives to rounding. The integral is taken from the nearer end of the swing, on the
side of A where p has one sign, so that nothing cancels.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tauto_core.curves.descent_curve import DescentCurve, Mirrored
from tauto_core.curves.newton import bracketed_newton
from tauto_core.curves.quadrature import QuadratureError, integrate
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import DescentError

LARGEST_SERIES = 1024
LARGEST_REDUCED_ARC = 64.0
"""Largest κS; beyond, the body descends at its terminal speed except in the last few 1/κ."""
SMALLEST_SERIES = 16
TAIL = 2.0**-48
"""Size of the last terms over the first at which a series is complete; t has them divided by k."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_STEPS = 64
_LEFT = 2.0
_ROUNDING = 2.0**-51


class HalfSwing(NamedTuple):
    """Duration and end of a half swing."""

    duration: float
    """Time from rest to rest [s]."""
    arc: float
    """Arc from A on the other side at which it comes to rest [m], > 0."""


_LONGEST_REDUCED = 1e6


class Grid(NamedTuple):
    """Numbers of nodes that resolve a half swing, and every shorter one on the same curve."""

    nodes: int
    """Nodes of the cosine series of dt/dθ."""
    panels: int
    """Panels of the integral for the speed, of 24 nodes each."""


def descent_time(curve: DescentCurve, gravity: float, start: float) -> float:
    """Return the time from rest at an arc to A [s].

    Args:
        curve: the curve, with its fluid; its slope must be positive between A and the start.
        gravity: g [m/s2].
        start: arc of the release [m], > 0, at most at the cusp.

    Raises:
        DescentError: a start that is not on the branch of descent.
    """
    panels = _panels(curve.kappa * _on_descent(curve, start))

    def integrand(u: FloatArray) -> FloatArray:
        # s = S (1 − u²) removes the square root at the start
        mean = _mean(curve, np.full_like(u, start), start * (1.0 - u * u), panels, -1.0)
        return np.sqrt(2.0 * start / (curve.gamma * gravity * mean))

    return float(integrate(integrand, np.zeros(1), np.ones(1))[0])


def half_swing(curve: DescentCurve, gravity: float, start: float) -> HalfSwing:
    """Return the duration and end of the half swing from rest down the branch of descent.

    For the other direction pass `Mirrored(curve)`.

    Args:
        curve: the curve, with its fluid; A must be its lowest point.
        gravity: g [m/s2].
        start: arc of the release [m], > 0, at most at the cusp.

    Raises:
        DescentError: a start that is not on the branch of descent, or an ascent beyond the cusp.
        QuadratureError: resistance so strong that the series does not converge.
    """
    end = far_end(curve, start)
    grid = grid_for(curve, start, end)
    rates = _rates(curve, np.array([start]), np.array([end]), grid)
    return HalfSwing(math.pi * float(np.mean(rates)) / math.sqrt(gravity), end)


def far_end(curve: DescentCurve, start: float) -> float:
    """Return S₁ > 0, the arc of ascent from rest at S > 0 [m].

    Newton's method converges: the energy that the ascent takes, ∫ e^{2κσ} p dσ, is convex, and S₁
    is at most the arc that the body would reach without resistance.

    Raises:
        DescentError: a start beyond the cusp, or an ascent beyond it.
    """
    _on_descent(curve, start)
    mirror, kappa, zero = Mirrored(curve), curve.kappa, np.zeros(1)
    mean = _mean(curve, np.array([start]), zero, _panels(kappa * start), -1.0)
    given, edge, end = start * float(mean[0]), mirror.descent_cusp, start
    while end < edge and float(mirror.height(end)) < float(curve.height(start)):
        end *= 2.0
    # from any height of fall the body comes no farther than about 1/κ
    end = min(end, edge, _LEFT / kappa if kappa else edge)
    for _ in range(_STEPS):
        mean = _mean(mirror, np.array([end]), zero, _panels(kappa * end), 1.0)
        short = given - end * float(mean[0])
        if end == edge and short > _ROUNDING * given:
            raise DescentError(
                f'start = {start!r} m: the body would come beyond the cusp of ascent at '
                f'{edge!r} m; start nearer to A, or take a longer pendulum'
            )
        change = short / (math.exp(2.0 * kappa * end) * float(mirror.slope(end)))
        end += change
        if abs(change) <= _ROUNDING * end:
            break
    return end


def grid_for(curve: DescentCurve, start: float, end: float) -> Grid:
    """Return the nodes that resolve a half swing to rounding.

    Raises:
        QuadratureError: more than 1024 terms, or κS beyond 64.
    """
    reduced = curve.kappa * max(start, end)
    panels, nodes = _panels(reduced), SMALLEST_SERIES
    while nodes <= LARGEST_SERIES and reduced <= LARGEST_REDUCED_ARC:
        grid = Grid(nodes, panels)
        series = cosines(curve, np.array([start]), np.array([end]), grid)[0]
        if np.max(np.abs(series[-4:])) <= TAIL * series[0]:
            return grid
        nodes *= 2
    raise QuadratureError(
        f'a half swing from {start!r} m with kappa = {curve.kappa!r} 1/m: the fluid resists too '
        f'strongly, since at most {LARGEST_SERIES} terms and {LARGEST_REDUCED_ARC:g}/kappa are '
        'allowed; use a smaller amplitude, a larger or denser body, or a lighter fluid'
    )


def cosines(curve: DescentCurve, start: FloatArray, end: FloatArray, grid: Grid) -> FloatArray:
    """Return the cosine coefficients of √g dt/dθ, shape (n, grid.nodes).

    Args:
        curve: the curve, with its fluid.
        start: S of n half swings [m], (n,).
        end: S₁ of the same [m], (n,).
        grid: nodes that resolve them.
    """
    rates = _rates(curve, start, end, grid)
    # k θ_j reduced in integers, so that high terms are rounded no more than low ones
    turns = np.outer(np.arange(grid.nodes), 2 * np.arange(grid.nodes) + 1) % (4 * grid.nodes)
    waves = np.cos(turns * (0.5 * math.pi / grid.nodes))
    weight = np.full(grid.nodes, 2.0 / grid.nodes)
    weight[0] = 1.0 / grid.nodes
    total: FloatArray = np.sum(rates[:, None, :] * waves, axis=-1) * weight
    return total


def place(
    curve: DescentCurve, gravity: float, start: FloatArray, end: FloatArray, time: FloatArray,
    grid: Grid,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Return arc [m] and ds/dt [m/s] at times since the release, (n,) each.

    The bits of each do not depend on the others.

    Args:
        curve: the curve, with its fluid.
        gravity: g [m/s2].
        start: S [m], (n,).
        end: S₁ [m], (n,).
        time: from 0 to the duration of the half swing [s], (n,).
        grid: nodes that resolve them all.
    """
    series, order = cosines(curve, start, end, grid), np.arange(1, grid.nodes)
    goal = np.minimum(time * math.sqrt(gravity) / series[:, 0], math.pi)
    ratio = series[:, 1:] / series[:, :1]

    def excess(angle: FloatArray) -> tuple[FloatArray, FloatArray]:
        turns = angle[:, None] * order
        late = angle + np.sum(ratio / order * np.sin(turns), axis=-1) - goal
        return late, 1.0 + np.sum(ratio * np.cos(turns), axis=-1)

    angle = bracketed_newton(excess, goal, (0.0, math.pi), absolute=_ROUNDING)
    width, sine = start + end, np.sin(0.5 * angle)
    arc = start - width * sine * sine
    evenness = _evenness(curve, start, end, arc, grid.panels)
    return arc, -0.5 * width * np.sin(angle) * np.sqrt(gravity * evenness)


def _midpoints(grid: Grid) -> FloatArray:
    return np.arange(0.5, grid.nodes, dtype=np.float64) * (math.pi / grid.nodes)


def _rates(curve: DescentCurve, start: FloatArray, end: FloatArray, grid: Grid) -> FloatArray:
    """Return √g dt/dθ at the midpoints, (n, nodes)."""
    width, sines = (start + end)[:, None], np.sin(0.5 * _midpoints(grid))
    arc = start[:, None] - width * sines * sines
    top, bottom = (np.broadcast_to(part[:, None], arc.shape) for part in (start, end))
    return np.asarray(_evenness(curve, top, bottom, arc, grid.panels) ** -0.5, np.float64)


def _evenness(
    curve: DescentCurve, start: FloatArray, end: FloatArray, arc: FloatArray, panels: int
) -> FloatArray:
    """Return ṡ²/(g (S − s)(s + S₁)), positive and smooth [1/m]."""
    above, below = np.maximum(arc, 0.0), np.maximum(-arc, 0.0)
    down = _mean(curve, start, above, panels, -1.0) / (above + end)
    up = _mean(Mirrored(curve), end, below, panels, 1.0) / (start + below)
    return 2.0 * curve.gamma * np.where(arc >= 0.0, down, up)


def _mean(
    curve: DescentCurve, far: FloatArray, near: FloatArray, panels: int, sign: float
) -> FloatArray:
    """Return the mean of e^{±2κ(σ − near)} p(σ) over σ from near to far, of any shape.

    Args:
        curve: the curve, with its fluid.
        far: end of the swing [m].
        near: position of the body, on the same side of A [m].
        panels: number of panels, of 24 nodes each.
        sign: −1 where the body comes from `far`, 1 where it goes there.
    """
    shares = ((np.arange(panels)[:, None] + 0.5 * (1.0 + _NODES)) / panels).ravel()
    length = (far - near)[..., None] * shares
    weighed = np.exp(sign * 2.0 * curve.kappa * length) * np.tile(_WEIGHTS, panels)
    total: FloatArray = np.sum(weighed * curve.slope(near[..., None] + length), axis=-1)
    mean: FloatArray = total / (2.0 * panels)
    return mean


def _panels(reduced: float) -> int:
    """Return the number of panels that resolve e^{−2κσ} over an arc of κσ = `reduced`.

    Raises:
        DescentError: an arc a million times longer than the stopping distance.
    """
    if not reduced <= _LONGEST_REDUCED:
        raise DescentError(
            f'an arc of {reduced:.6g}/kappa: the fluid resists too strongly, at most '
            f'{_LONGEST_REDUCED:g}/kappa is allowed; use a smaller amplitude, a larger or denser '
            'body, or a lighter fluid'
        )
    return 1 + int(reduced / 4.0)


def _on_descent(curve: DescentCurve, start: float) -> float:
    if not 0.0 < start <= curve.descent_cusp:
        raise DescentError(
            f'start = {start!r} m: must be > 0 and at most at the cusp, {curve.descent_cusp!r} m; '
            'give another, or take a longer pendulum'
        )
    return start
