"""Sully's lever machine along its arc: the functions that steps need, as Chebyshev series.

In s = ∫√(M/I) dθ the inertia is one. With j = J/I the pair n = dθ/ds, w = √j dβ/ds is a unit
vector, (cos χ, sin χ), so that the series of n, w, χ' = dχ/ds, cos β, sin β and θ are all.
They are smooth up to a dead point and beyond, where θ as the coordinate is singular.
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

SHORTENING, RIDE, BEND, COSINE, SINE, ANGLE = range(6)
"""Rows of the series: n, w, χ', cos β, sin β, θ."""

MARGIN = 1.5
"""How far beyond the release the short series reach: as far as a sea commonly drives the wheel."""

FEWEST_TERMS, MOST_TERMS, MOST_OF_ARC = 16, 128, 1024
TAIL = 2.0**-48
MOST_GROWN = 64.0
"""Largest sum of the coefficients of powers, relative to the largest one of the series."""

_NEWTON = 60


class Series(NamedTuple):
    """Functions of s on an interval.

    Attributes:
        middle: middle of the interval.
        half: half its length.
        terms: Chebyshev coefficients, (6, n).
    """

    middle: float
    half: float
    terms: FloatArray


class Powers(NamedTuple):
    """The same in powers of x, from −1 to 1 over the interval: half the work."""

    middle: float
    half: float
    terms: FloatArray


class LeverShape(NamedTuple):
    """Short series about rest, and longer ones as far as the motion may go.

    The longer ones reach as far as the geometry allows; where the inertia changes too abruptly for
    that, they are the short ones.
    """

    near: Series | Powers
    whole: Series


def lever_shape(machine: LeverMachine, blur: float = 0.0) -> LeverShape:
    """Return the series of a machine.

    Args:
        machine: the machine whose arc it is.
        blur: error allowed in a function, relative to its largest coefficient; at least rounding.
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
    return LeverShape(_in_powers(_shortened(short, blur)), _shortened(whole, blur))


def _shortened(series: Series, blur: float) -> Series:
    """Leave out the last terms that together stay below the blur."""
    size = np.abs(series.terms)
    tails = np.cumsum(size[:, ::-1], axis=1)[:, ::-1] / np.max(size, axis=1, keepdims=True)
    needed = max(2, int(np.count_nonzero(np.max(tails, axis=0) > blur)))
    return series._replace(terms=np.ascontiguousarray(series.terms[:, :needed]))


def _in_powers(series: Series) -> Series | Powers:
    """Return a series in powers, where they don't grow so large that digits would cancel."""
    terms = np.zeros_like(series.terms)
    for row, given in zip(terms, series.terms, strict=True):
        found = chebyshev.cheb2poly(given)
        row[: len(found)] = found
    grown = np.sum(np.abs(terms), axis=1) / np.max(np.abs(series.terms), axis=1)
    if np.max(grown) > MOST_GROWN:
        return series
    return Powers(series.middle, series.half, np.ascontiguousarray(terms))


def _arc_of_tau(machine: LeverMachine, low: float, high: float) -> chebyshev.Chebyshev:
    """Return s, 0 at rest, as a series of τ."""
    root = math.sqrt(machine.inertia)
    slope = _complete(lambda tau: machine.arc_slope(tau)[None] / root, low, high, MOST_OF_ARC)
    if slope is None:
        raise PropagationError(
            f'the arc of the lever takes more than {MOST_OF_ARC} Chebyshev coefficients. Use a '
            'heavier wheel or a lighter weight',
            0.0,
        )
    whole = chebyshev.Chebyshev(slope[0], domain=[low, high]).integ()
    return whole - float(whole(0.0))


def _series(
    machine: LeverMachine, arc: chebyshev.Chebyshev, low: float, high: float
) -> Series | None:
    begin, end = float(arc(low)), float(arc(high))
    slope = arc.deriv()

    def functions(s: FloatArray) -> FloatArray:
        tau = np.clip(low + (s - begin) / (end - begin) * (high - low), low, high)
        for _ in range(_NEWTON):
            change = (arc(tau) - s) / slope(tau)
            tau = np.clip(tau - change, low, high)
            if np.max(np.abs(change)) <= 1e-12 * (high - low):
                # the next one would be rounding
                break
        return _functions(machine, tau)

    terms = _complete(functions, begin, end, MOST_TERMS)
    return None if terms is None else Series(0.5 * (begin + end), 0.5 * (end - begin), terms)


def _functions(machine: LeverMachine, tau: FloatArray) -> FloatArray:
    """Return n, w, χ', cos β, sin β and θ, (6, n)."""
    shape = machine.geometry
    ratio, bend = shape.slopes(tau)
    root = math.sqrt(machine.turned_inertia / machine.inertia)
    n = 1.0 / np.hypot(1.0, root * ratio)
    w, beta = root * ratio * n, shape.pose(tau).beta
    return np.stack([n, w, root * bend * n**3, np.cos(beta), np.sin(beta), shape.theta(tau)])


def _complete(
    functions: Callable[[FloatArray], FloatArray], low: float, high: float, most: int
) -> FloatArray | None:
    """Return Chebyshev coefficients on an interval, (m, n), good to rounding; None: too many."""
    terms = FEWEST_TERMS
    while terms <= most:
        values = functions(0.5 * (low + high) + 0.5 * (high - low) * nodes(terms))
        found = coefficients(values)
        size = np.max(np.abs(found), axis=1, keepdims=True)
        if np.max(np.abs(found[:, -4:]) / size) <= TAIL:
            return found
        terms += terms // 4
    return None
