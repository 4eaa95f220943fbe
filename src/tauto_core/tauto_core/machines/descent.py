"""Motion along Euler's tautochrone in a fluid, in closed form (Euler 1729, 13–15, 21, 31–35).

On the way towards −s, z = (1 − e^{−κs})/κ obeys z̈ = −(g/f) z: it is the harmonic coordinate. As
in Euler's paper, a speed V is given by its height of fall v = V²/2g, and b is v at A. `curve` is a
`FluidTautochrone`; constant friction that its curve allows for does not change the motion, but
then A is not the lowest point. `gravity` is g [m/s2] in vacuum.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.fluid import FluidTautochrone, within
from tauto_core.curves.numerics import exponential_mean, logarithmic_mean
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import DescentError


class Arcs(NamedTuple):
    """The arcs of descent and ascent of a half swing [m], each > 0."""

    descent: float
    ascent: float
    loss: float
    """Arc of descent less that of ascent; also the arc before A at which the speed is greatest."""


def harmonic_of_arc(kappa: float, arc: ArrayLike) -> FloatArray:
    """Return z = (1 − e^{−κs})/κ [m]."""
    s = np.asarray(arc, np.float64)
    return s * exponential_mean(-kappa * s)


def arc_of_harmonic(kappa: float, z: ArrayLike) -> FloatArray:
    """Return s = −ln(1 − κz)/κ [m], for κz < 1."""
    z = np.asarray(z, np.float64)
    return z * logarithmic_mean(-kappa * z)


def descent_time(curve: FluidTautochrone, gravity: float) -> float:
    """Return (π/2) √(f/g): from rest anywhere to A [s] (§15)."""
    return 0.5 * math.pi * math.sqrt(curve.pendulum_length / gravity)


def composed_length(descent: float, ascent: float) -> float:
    """Return L = ((√f + √h)/2)² [m]: descent on a curve of f, ascent on one of h (§21).

    Args:
        descent: f, pendulum length of the branch of descent [m].
        ascent: h, of the branch of ascent [m].
    """
    return (0.5 * (math.sqrt(descent) + math.sqrt(ascent))) ** 2


def half_swing(
    curve: FluidTautochrone, gravity: float, start: ArrayLike, time: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return arc [m] and ds/dt [m/s] at times since the release at rest [s].

    Args:
        curve: the curve, with its fluid.
        gravity: g [m/s2].
        start: arc of the release [m], > 0.
        time: from 0 to π√(f/g), the duration of the half swing; of the same shape.

    Raises:
        DescentError: a start that is not on the branch of descent.
    """
    top = harmonic_of_arc(curve.kappa, _on_descent(curve, start))
    omega = math.sqrt(gravity / curve.pendulum_length)
    angle = omega * np.asarray(time, np.float64)
    z, rate = top * np.cos(angle), -top * omega * np.sin(angle)
    return arc_of_harmonic(curve.kappa, z), rate / (1.0 - curve.kappa * z)


def velocity_height(curve: FluidTautochrone, arc: ArrayLike, at_lowest: float) -> FloatArray:
    """Return v(s) = b e^{2κs} − (e^{κs} − 1)²/(2κ²f) [m] (§31–32).

    Args:
        curve: the curve, with its fluid.
        arc: s [m], within the half swing.
        at_lowest: b, the height of fall of the speed at A [m].
    """
    s = np.asarray(arc, np.float64)
    top = _top(curve, at_lowest)
    z = harmonic_of_arc(curve.kappa, s)
    fall = (top - z) * (top + z) / (2.0 * curve.pendulum_length)
    return np.exp(2.0 * curve.kappa * s) * fall


def height_at_lowest(curve: FluidTautochrone, start: float) -> float:
    """Return b = z²/2f [m] of a descent from rest at an arc.

    Raises:
        DescentError: a start that is not on the branch of descent.
    """
    z = float(harmonic_of_arc(curve.kappa, _on_descent(curve, start)))
    return z * z / (2.0 * curve.pendulum_length)


def arcs(curve: FluidTautochrone, at_lowest: float) -> Arcs:
    """Return the arcs of descent and ascent and their difference (§33–34).

    S_d = −ln(1 − κ√(2bf))/κ, S_a = ln(1 + κ√(2bf))/κ. Exactly, S_d − S_a = −ln(1 − 2κ²bf)/κ, which
    is also the arc before A at which the body is fastest.

    Args:
        curve: the curve, with its fluid.
        at_lowest: b, the height of fall of the speed at A [m], 0 < b < 1/(2κ²f).

    Raises:
        DescentError: a b that no descent on the curve reaches.
    """
    top = _top(curve, at_lowest)
    kappa = curve.kappa
    found = Arcs(
        float(arc_of_harmonic(kappa, top)),
        -float(arc_of_harmonic(kappa, -top)),
        float(arc_of_harmonic(kappa, kappa * top * top)),
    )
    if found.descent > curve.descent_cusp:
        limit = height_at_lowest(curve, curve.descent_cusp)
        raise DescentError(
            f'at_lowest = {at_lowest!r} m: needs a descent of {found.descent!r} m, beyond the '
            f'cusp at {curve.descent_cusp!r} m; give at most {limit!r} m, or take a longer '
            'pendulum'
        )
    return found


def greatest_velocity_height(curve: FluidTautochrone, at_lowest: float) -> float:
    """Return v = b/(1 − 2κ²bf) [m], at the arc `arcs(…).loss` before A (§33).

    Raises:
        DescentError: a b that no descent reaches.
    """
    reduced = curve.kappa * _top(curve, at_lowest)
    return at_lowest / ((1.0 - reduced) * (1.0 + reduced))


def _top(curve: FluidTautochrone, at_lowest: float) -> float:
    """Return √(2bf), the z from which a descent reaches b; refuse a b that none reaches."""
    kappa, length = curve.kappa, curve.pendulum_length
    top = math.sqrt(2.0 * max(at_lowest, 0.0) * length)
    if not (0.0 <= at_lowest < math.inf and kappa * top < 1.0):
        limit = 1.0 / (2.0 * kappa * kappa * length) if kappa else math.inf
        raise DescentError(
            f'at_lowest = {at_lowest!r} m: must be at least 0 and less than {limit!r} m, the '
            'speed that the resistance leaves a descent without end; give a smaller one'
        )
    return top


def _on_descent(curve: FluidTautochrone, start: ArrayLike) -> FloatArray:
    found = within(curve, start)
    if not np.all(found > 0.0):
        raise DescentError(
            f'start = {float(np.min(found))!r} m: a half swing forward starts above 0 m, '
            f'at most at the cusp, {curve.descent_cusp!r} m; give another, or ask for the half '
            'swing backward'
        )
    return found
