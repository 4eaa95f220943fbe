"""Whether the axle of a suspended case stays in its bearing, also between samples (theory E3).

The contact force over the mass is P/(1 + (c/k)² sin²δ) with δ = φ − θ and

    P = (g + z̈) cos θ − ÿ sin θ + e θ̇² + c φ̇² cos δ,

so contact is lost where P falls to 0. Between two instants P is approximated by the cubic through
its values and slopes there, both in closed form from the motion. Where the fast mode turns by ωh
the cubic is off by at most (2ωh)⁴/384 of the amplitude of P in that mode, 1e-3 at ωh = 0.4.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tauto_core.motion.suspended_case import BearingMotion, CaseMotion
from tauto_core.samples import FloatArray


class Case(NamedTuple):
    """A case hung at small angles.

    Attributes:
        e: support's radius less the axle's [m].
        c: depth of the centre of gravity below the axle's centre [m].
        k: radius of gyration [m].
        gravity: g [m/s2], of the equations of small angles.
    """

    e: float
    c: float
    k: float
    gravity: float


class Felt(NamedTuple):
    """The specific force at the bearing and its slope, arrays of shape (n,) [m/s2, m/s3]."""

    sway: FloatArray
    lift: FloatArray
    sway_rate: FloatArray
    lift_rate: FloatArray


def felt_at(bearing: BearingMotion, x: FloatArray) -> Felt:
    """Return the specific force at a place of each part's piece, 0 ≤ x ≤ 1, (Σ parts,)."""
    piece = bearing.piece
    found = []
    for coefficients in (bearing.sway, bearing.lift):
        value, slope = np.zeros((2, len(x)))
        for j in range(coefficients.shape[1] - 1, -1, -1):
            slope = slope * x + value
            value = value * x + coefficients[piece, j]
        found.append((value, slope / (bearing.length_ns[piece] * 1e-9)))
    (sway, sway_rate), (lift, lift_rate) = found
    return Felt(sway, lift, sway_rate, lift_rate)


def lost_at(
    case: Case, bearing: BearingMotion, before: CaseMotion, after: CaseMotion, pressed: FloatArray
) -> float | None:
    """Return the time at which contact is first lost [s] from the start of the run; None: never.

    Args:
        case: the suspended case, at small angles.
        bearing: motion of the bearing.
        before: motion of the case at the beginning of each part, (Σ parts,).
        after: the same at its end.
        pressed: P at the end of each part [m/s2], (Σ parts,).
    """
    longest = float(np.max(bearing.length_ns / bearing.parts)) * 1e-9
    if np.min(pressed) > 2.0 * longest * _steepest(case, bearing, before, after):
        return None
    end, end_ns, piece = bearing.end, bearing.end_ns, bearing.piece
    first = np.concatenate([[True], piece[1:] != piece[:-1]])
    begin = np.where(first, 0.0, np.roll(end, 1))
    begin_ns = np.where(first, bearing.begin_ns[piece], np.roll(end_ns, 1))
    length = (end_ns - begin_ns) * 1e-9
    ends, slopes = np.empty((2, 2, len(end)))
    for side, (motion, x) in enumerate(((before, begin), (after, end))):
        felt = felt_at(bearing, x)
        ends[side] = pressing(case, motion, felt.sway, felt.lift)
        slopes[side] = length * pressing_rate(case, motion, felt)
    loss = first_loss(ends, slopes)
    if loss is None:
        return None
    stretch, share = loss
    return float(begin_ns[stretch] * 1e-9 + share * length[stretch])


def pressing(case: Case, motion: CaseMotion, sway: FloatArray, lift: FloatArray) -> FloatArray:
    """Return P [m/s2], (n,)."""
    pressed = lift * np.cos(motion.theta) - sway * np.sin(motion.theta)
    pressed += case.e * motion.theta_rate**2
    pressed += case.c * np.cos(motion.phi - motion.theta) * motion.phi_rate**2
    return np.asarray(pressed)


def pressing_rate(case: Case, motion: CaseMotion, felt: Felt) -> FloatArray:
    """Return dP/dt at small angles [m/s3], (n,), with the accelerations of theory E3."""
    e, c, k, gravity = case
    theta, phi, theta_rate, phi_rate = (
        motion.theta,
        motion.phi,
        motion.theta_rate,
        motion.phi_rate,
    )
    delta = phi - theta
    phi_bend = -gravity * c / (k * k) * delta
    theta_bend = -(felt.sway + gravity * theta + c * phi_bend) / e
    sine, cosine = np.sin(theta), np.cos(theta)
    rate = felt.lift_rate * cosine - felt.sway_rate * sine
    rate -= (felt.lift * sine + felt.sway * cosine) * theta_rate
    rate += 2.0 * e * theta_rate * theta_bend
    rate += 2.0 * c * phi_rate * phi_bend * np.cos(delta)
    rate -= c * phi_rate**2 * np.sin(delta) * (phi_rate - theta_rate)
    return np.asarray(rate)


def _steepest(case: Case, bearing: BearingMotion, before: CaseMotion, after: CaseMotion) -> float:
    """Return an upper bound of |dP/dt| in a batch."""
    e, c, k, gravity = case
    columns = zip(vars(before).values(), vars(after).values(), strict=True)
    theta, phi, theta_rate, phi_rate = (
        float(max(abs(first[0]), np.max(np.abs(rest)))) for first, rest in columns
    )
    shortest = float(np.min(bearing.length_ns)) * 1e-9
    sums = []
    for coefficients in (np.abs(bearing.sway), np.abs(bearing.lift)):
        slopes = coefficients @ np.arange(coefficients.shape[1])
        sums += [float(np.max(coefficients.sum(axis=1))), float(np.max(slopes)) / shortest]
    sway, sway_rate, lift, lift_rate = sums
    phi_bend = gravity * c / (k * k) * (theta + phi)
    theta_bend = (sway + gravity * theta + c * phi_bend) / e
    rate = lift_rate + sway_rate * theta + (lift * theta + sway) * theta_rate
    rate += 2.0 * (e * theta_rate * theta_bend + c * phi_rate * phi_bend)
    return rate + c * phi_rate**2 * (theta + phi) * (theta_rate + phi_rate)


def first_loss(ends: FloatArray, slopes: FloatArray) -> tuple[int, float] | None:
    """Return the interval in which P first reaches 0, and the fraction of it; None if in none.

    Args:
        ends: P at the beginning and end of each of n intervals, (2, n).
        slopes: dP/dx there, x from 0 to 1 over the interval, (2, n).
    """
    a, b = ends
    # a + b₁x + b₂x² + b₃x³
    first, second = slopes[0], 3.0 * (b - a) - 2.0 * slopes[0] - slopes[1]
    third = slopes[0] + slopes[1] - 2.0 * (b - a)
    # a slope at an end adds at most 4/27 of itself to the cubic
    dips = np.maximum(-slopes[0], 0.0) + np.maximum(slopes[1], 0.0)
    low = np.minimum(a, b) - 4.0 / 27.0 * dips
    for stretch in np.flatnonzero(low <= 0.0).tolist():
        share = _first_root(*(float(part[stretch]) for part in (a, first, second, third)))
        if share is not None:
            return stretch, share
    return None


def _first_root(a: float, first: float, second: float, third: float) -> float | None:
    """Return the least x in [0, 1] where a cubic is not above 0, by bisection; None: nowhere."""

    def value(x: float) -> float:
        return a + x * (first + x * (second + x * third))

    if a <= 0.0:
        return 0.0
    low = 0.0
    # between two extremes the cubic is monotonic
    for place in (*sorted(_roots(first, 2.0 * second, 3.0 * third)), 1.0):
        if value(place) <= 0.0:
            from scipy.optimize import brentq  # slow to import

            return float(brentq(value, low, place))
        low = place
    return None


def _roots(c: float, b: float, a: float) -> list[float]:
    """Return the roots within (0, 1) of ax² + bx + c, without cancellation."""
    square = b * b - 4.0 * a * c
    if square < 0.0:
        return []
    q = -0.5 * (b + math.copysign(math.sqrt(square), b))
    found = [above / below for above, below in ((q, a), (c, q)) if abs(above) < abs(below)]
    return [root for root in found if root > 0.0]
