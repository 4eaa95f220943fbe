"""Sully's lever machine along its arc: the functions that steps need, as Chebyshev series.

θ is the angle of the wheel, β that of the lever (β_l in theory E2.3), I and J their moments of
inertia, M = I + J (dβ/dθ)². Along the arc s = ∫√(M/I) dθ the inertia is one: with j = J/I the pair
n = dθ/ds, w = √j dβ/ds is a unit vector (cos χ, sin χ). What steps need are n, w, χ' = dχ/ds,
cos β, sin β and θ. As functions of s they are smooth up to a dead point and beyond it, where
functions of θ are singular.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from tauto_core.machines import LeverMachine
from tauto_core.motion.chebyshev_fit import coefficients, nodes
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import PropagationError

N, W, CHI_SLOPE, COSINE, SINE, ANGLE = range(6)
"""Rows of the series: n, w, χ', cos β, sin β, θ."""

MARGIN = 1.5
"""How far beyond the release the short series reach: as far as a sea commonly drives the wheel.
Beyond them the long series are taken, at a higher cost and to the same accuracy.
"""

FEWEST_TERMS, MOST_TERMS = 16, 128
"""Numbers of terms tried for the functions of s."""

MOST_TERMS_OF_ARC = 1024
"""The same for s as a function of τ, which is evaluated only while the series are made."""

TAIL = 2.0**-48
"""Largest of the last four coefficients, relative to the largest one, of a complete series."""

MOST_GROWN = 64.0
"""Largest sum of the coefficients of powers, relative to the largest one of the Chebyshev series:
so much more than a rounding do powers lose at most by cancellation.
"""

_NEWTON = 60
"""Most iterations of Newton's method for τ of s; it converges in a few."""


class Series(NamedTuple):
    """The six functions of s on an interval, as Chebyshev series.

    Attributes:
        middle: middle of the interval.
        half: half its length.
        terms: coefficients of T_k(x), x = (s − middle)/half, (6, n).
    """

    middle: float
    half: float
    terms: FloatArray


class Powers(NamedTuple):
    """The same as sums of terms · x^k, which take half as many operations."""

    middle: float
    half: float
    terms: FloatArray


class LeverShape(NamedTuple):
    """The functions on two intervals.

    Attributes:
        near: about rest, as far as the motion commonly goes.
        whole: as far as the geometry allows; where that takes too many terms, as far as `near`.
    """

    near: Series | Powers
    whole: Series


def lever_shape(machine: LeverMachine, allowed: float = 0.0) -> LeverShape:
    """Return the series of a machine.

    Args:
        machine: the machine whose arc it is.
        allowed: error allowed in a function, relative to its largest coefficient; rounding if
            less.

    Raises:
        PropagationError: the inertia changes too abruptly for `MOST_TERMS`.
    """
    low, high = machine.geometry.edges
    arc = _arc_of_tau(machine, low, high)
    reach = MARGIN * abs(machine.release_angle) + 0.1
    near = np.clip(np.array([-reach, reach]), *machine.sides)
    inner = machine.geometry.tau_of(near)
    short = _series(machine, arc, float(inner[0]), float(inner[1]))
    if short is None:
        raise PropagationError(
            f'the inertia of weight and lever changes too abruptly for {MOST_TERMS} Chebyshev '
            'coefficients. Use a heavier wheel, a lighter weight or a smaller release angle',
            0.0,
        )
    whole = _series(machine, arc, low, high) or short
    return LeverShape(_in_powers(_shortened(short, allowed)), _shortened(whole, allowed))


def _shortened(series: Series, allowed: float) -> Series:
    """Leave out the last terms whose sum stays below the error allowed."""
    size = np.abs(series.terms)
    tails = np.cumsum(size[:, ::-1], axis=1)[:, ::-1] / np.max(size, axis=1, keepdims=True)
    needed = max(2, int(np.count_nonzero(np.max(tails, axis=0) > allowed)))
    return series._replace(terms=np.ascontiguousarray(series.terms[:, :needed]))


def _in_powers(series: Series) -> Series | Powers:
    """Return a series in powers, unless they grow so large that digits would cancel."""
    terms = np.zeros_like(series.terms)
    for row, given in zip(terms, series.terms, strict=True):
        found = chebyshev.cheb2poly(given)
        row[: len(found)] = found
    grown = np.sum(np.abs(terms), axis=1) / np.max(np.abs(series.terms), axis=1)
    if np.max(grown) > MOST_GROWN:
        return series
    return Powers(series.middle, series.half, np.ascontiguousarray(terms))


def _arc_of_tau(machine: LeverMachine, low: float, high: float) -> chebyshev.Chebyshev:
    """Return s, 0 at rest, as a series of τ, the parameter of the geometry."""
    root = math.sqrt(machine.inertia)
    slope = _complete(
        lambda tau: machine.arc_slope(tau)[None] / root, low, high, MOST_TERMS_OF_ARC
    )
    if slope is None:
        raise PropagationError(
            f'the arc of the lever takes more than {MOST_TERMS_OF_ARC} Chebyshev coefficients. '
            'Use a heavier wheel or a lighter weight',
            0.0,
        )
    whole = chebyshev.Chebyshev(slope[0], domain=[low, high]).integ()
    return whole - float(whole(0.0))


def _series(
    machine: LeverMachine, arc: chebyshev.Chebyshev, low: float, high: float
) -> Series | None:
    """Return the functions between two values of τ; None if they take too many terms."""
    begin, end = float(arc(low)), float(arc(high))
    slope = arc.deriv()

    def functions(s: FloatArray) -> FloatArray:
        tau = np.clip(low + (s - begin) / (end - begin) * (high - low), low, high)
        for _ in range(_NEWTON):
            change = (arc(tau) - s) / slope(tau)
            tau = np.clip(tau - change, low, high)
            if np.max(np.abs(change)) <= 1e-12 * (high - low):
                # convergence is quadratic, so that the next change would be rounding
                break
        return _functions(machine, tau)

    terms = _complete(functions, begin, end, MOST_TERMS)
    return None if terms is None else Series(0.5 * (begin + end), 0.5 * (end - begin), terms)


def _functions(machine: LeverMachine, tau: FloatArray) -> FloatArray:
    """Return n, w, χ', cos β, sin β and θ, (6, n).

    With b = dβ/dθ, n = 1/√(1 + jb²), w = √j bn and χ' = √j n³ db/dθ.
    """
    shape = machine.geometry
    ratio, ratio_slope = shape.slopes(tau)
    root_j = math.sqrt(machine.turned_inertia / machine.inertia)
    n = 1.0 / np.hypot(1.0, root_j * ratio)
    w, beta = root_j * ratio * n, shape.pose(tau).beta
    chi_slope = root_j * ratio_slope * n**3
    return np.stack([n, w, chi_slope, np.cos(beta), np.sin(beta), shape.theta(tau)])


def _complete(
    functions: Callable[[FloatArray], FloatArray], low: float, high: float, most: int
) -> FloatArray | None:
    """Return Chebyshev coefficients on an interval to rounding, (m, n); None: too many."""
    terms = FEWEST_TERMS
    while terms <= most:
        values = functions(0.5 * (low + high) + 0.5 * (high - low) * nodes(terms))
        found = coefficients(values)
        size = np.max(np.abs(found), axis=1, keepdims=True)
        if np.max(np.abs(found[:, -4:]) / size) <= TAIL:
            return found
        terms += terms // 4
    return None
