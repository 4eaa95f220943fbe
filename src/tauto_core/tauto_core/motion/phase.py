"""The oscillator phase (E4 in docs/theory/reading.md) and its exact reduction to half turns.

φ is the unwrapped angle of (s, −ṡ/ω) less its value at the start, with s = ∫√M dϑ the arc length
of the well and ω its small-amplitude frequency. A turn is added at every upward passage of ϑ = 0.
"""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

import numpy as np

from tauto_core.machines import Machine
from tauto_core.samples import FloatArray, IntArray

PI = Decimal('3.14159265358979323846264338327950288419716939937510582097494459')
PHASE_DIGITS = 50
"""Digits of decimal arithmetic with phases."""

# Largest time in nanoseconds that is exact as a float: 104 days.
_COARSE_NS = 2**53

BELOW_ONE = 1.0 - 2.0**-53
"""The largest fraction of a half turn: at 1 the next half turn begins."""

_SPLIT = 134217729.0  # 2^27 + 1, Dekker's splitter


def two_floats(exact: Decimal) -> tuple[float, float]:
    """Return a number as the sum of two floats, to about 32 digits."""
    with localcontext() as context:
        context.prec = PHASE_DIGITS
        high = float(exact)
        return high, float(exact - Decimal(high))


def half_turns(time_ns: IntArray, per_ns: tuple[float, float]) -> tuple[IntArray, FloatArray]:
    """Return the phase of a uniform rotation in whole half turns and the fraction in [0, 1).

    The time since the release is ≥ 0 [ns], (n,), and the half turns per ns are two floats. Only
    the fraction is rounded, however long the time (Dekker's exact product, 1971).
    """
    high, low = per_ns
    whole = np.zeros(len(time_ns), np.int64)
    fraction = np.zeros(len(time_ns))
    # Two parts, each exact as a float, so that no length of run rounds the time.
    fine = time_ns % _COARSE_NS
    coarse = time_ns - fine
    for part in (coarse, fine) if coarse.any() else (fine,):
        time = part.astype(np.float64)
        product, error = _product(time, high)
        floor = np.floor(product)
        fraction += (product - floor) + (error + time * low)
        whole += floor.astype(np.int64)
    carry = np.floor(fraction)
    return whole + carry.astype(np.int64), fraction - carry


def _product(a: FloatArray, b: float) -> tuple[FloatArray, FloatArray]:
    """Return a·b and its rounding error, exactly."""
    product = a * b
    c = _SPLIT * a
    a_high = c - (c - a)
    a_low = a - a_high
    c_b = _SPLIT * b
    b_high = c_b - (c_b - b)
    b_low = b - b_high
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, error


def polar(
    coordinate: FloatArray, speed: FloatArray, acceleration: FloatArray, omega: float
) -> FloatArray:
    """Return the angle of (x, −ẋ/ω) within a turn, in [−π/2, 3π/2) [rad], (n,).

    A turn ends where x passes zero upwards, which is where turns are counted (E4 in reading.md). A
    release lies there only where it is at rest at zero and starts upwards. So rounding cannot put
    any other release on either side of the joint. At rest at zero the angle is that of the motion
    just after, which the acceleration starts; only its sign is used.
    """
    rests = (coordinate == 0.0) & (speed == 0.0)
    speed = np.where(rests, acceleration, speed)
    # the sums turn −0.0, which arctan2 tells from 0.0, into 0.0
    angle = np.arctan2(0.0 - speed / omega, coordinate + 0.0)
    return np.where((coordinate < 0.0) & (angle < 0.0), angle + math.tau, angle)


def polar_rate(
    coordinate: FloatArray, speed: FloatArray, acceleration: FloatArray, omega: float
) -> FloatArray:
    """Return φ̇ = ω (ẋ² − x ẍ)/(ω² x² + ẋ²) [rad/s]; 0 at rest at zero, where φ has no value."""
    square = omega * omega * coordinate * coordinate + speed * speed
    areal = omega * (speed * speed - coordinate * acceleration)
    return np.divide(areal, square, out=np.zeros_like(square), where=square > 0.0)


def since_start(turns: IntArray, angle: FloatArray, start: float) -> tuple[IntArray, FloatArray]:
    """Return the phase since the start in whole half turns and the fraction in [0, 1), (n,).

    From upward passages since the start, the angle within a turn (`polar`) [rad], and that at the
    start.
    """
    half = (angle - start) / math.pi
    whole = np.floor(half)
    return 2 * turns + whole.astype(np.int64), half - whole


def within_turn(
    machine: Machine, angle: FloatArray, rate: FloatArray, acceleration: FloatArray
) -> FloatArray:
    """Return the angle of (s, −ṡ/ω) in [−π/2, 3π/2) from ϑ, ϑ̇ and ϑ̈; see `polar`."""
    speed = np.sqrt(machine.mass(angle)) * rate
    return polar(machine.arc(angle), speed, acceleration, machine.frequency)


def phase_rate(
    machine: Machine, angle: FloatArray, rate: FloatArray, acceleration: FloatArray
) -> FloatArray:
    """Return φ̇ of the arc s from ϑ, ϑ̇, ϑ̈: ṡ = √M ϑ̇ and s̈ = √M ϑ̈ + (d√M/dϑ) ϑ̇²."""
    root = np.sqrt(machine.mass(angle))
    lever = machine.cam.lever_arm(angle)
    arc, arc_speed = machine.arc(angle), root * rate
    root_slope = machine.carried_mass * lever * machine.cam.lever_rate(angle) / root
    arc_acceleration = root * acceleration + root_slope * rate * rate
    return polar_rate(arc, arc_speed, arc_acceleration, machine.frequency)
