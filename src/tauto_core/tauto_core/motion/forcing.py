"""The forcing of the machine over short pieces, its motion, and the phase of that.

A piece is the time between two joints of the polynomials, which are samples of the motion, next to
each other or several apart; x runs from 0 to 1 over its `length_s`. A span is a part of a piece,
from x = `begin` to `end`. Spans follow each other without gaps, and one ends wherever the motion
is to be logged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.machines import Machine
from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene.errors import PropagationError

LEAST_UPWARD = 1.0
"""Specific force upwards in the case with which a thread still follows its direction [m/s²]."""


# -----------------------------------------------------------------------------
# Errors that end a motion, the same for all propagators.


def edge_reached(machine: Machine, time_s: float) -> PropagationError:
    """Return the error of a cam angle that reached the edge of the cam."""
    return PropagationError(
        f'the cam angle reached the edge of the cam at ±{machine.cam.range_rad:.6g} rad. Use a '
        'cam with a longer range, a smaller release angle, a weaker escapement or a calmer sea',
        time_s,
    )


def released_beyond(machine: Machine, cam_angle: float) -> PropagationError:
    """Return the error of a release that puts the cam angle beyond the cam."""
    return PropagationError(
        f'the release angle {machine.release_angle:.6g} rad and the roll at the start put the cam '
        f"angle at {cam_angle:.6g} rad, beyond the cam's range of ±{machine.cam.range_rad:.6g} "
        'rad. Release at a smaller angle',
        0.0,
    )


def thread_slack(time_s: float) -> PropagationError:
    """Return the error of a thread that would have to push."""
    return PropagationError(
        'the thread went slack (its tension fell to 0 N, and a thread cannot push). Use a lighter '
        'weight, a smaller release angle, a stronger pull or a calmer sea; smooth the '
        'accelerations of a noisy sensor',
        time_s,
    )


def lifted_off(time_s: float) -> PropagationError:
    """Return the error of a case whose axle would have to be held down."""
    return PropagationError(
        'the axle of the suspension lifted off its bearing (the contact force fell to 0 N). Keep '
        "its period away from the sea's, hang the case nearer to the roll axis (ship.height), or "
        'choose a calmer sea',
        time_s,
    )


def turned_over(time_s: float) -> PropagationError:
    """Return the error of a case that swings all the way round."""
    return PropagationError(
        'the suspended case turned over (more than 3 rad from the contact or from the vertical). '
        "Keep its period away from the sea's, or hang it nearer to the roll axis (ship.height)",
        time_s,
    )


def beyond_small_angles(tilt: float, limit: float, time_s: float) -> PropagationError:
    """Return the error of a suspended case that swings wider than its equations hold."""
    return PropagationError(
        f'the suspended case swings {tilt:.3g} rad from the vertical; the equations of small '
        f'angles are taken up to {limit:g} rad. Set suspension.large_angles to true, or keep the '
        "case's periods away from the sea's",
        time_s,
    )


class Polynomials(NamedTuple):
    """A polynomial u over each of n spans, by the numbers that determine it.

    Where the piece of a span is regular, the samples of its window do: they are as many for all of
    these, evenly spaced and centred on the piece, and u has their values and rates.

    Attributes:
        values: u at the samples, (m,).
        rates: u̇ at the samples [1/s], (m,).
        sample: of a span of a regular piece, the index of the first sample of its window, ≥ 0; of
            any other, −1 less its row in `fitted`; (n,).
        fitted: coefficients of x^j over pieces that are not regular, (k, w).
    """

    values: FloatArray
    rates: FloatArray
    sample: IntArray
    fitted: FloatArray


@dataclass(frozen=True)
class Window:
    """The neutral line as the samples that its polynomials interpolate, for linear propagators.

    Attributes:
        nodes: x of the p samples of a regular piece's window.
        line: γ over the spans [rad]; w of `Polynomials` is 2p.
    """

    nodes: tuple[float, ...]
    line: Polynomials


@dataclass(frozen=True)
class Temperatures:
    """The clock's temperature over the log intervals of n spans: linear within each of them.

    Attributes:
        celsius: temperature where each of m intervals begins, and where it ends [°C], (m, 2).
        begin_s: time from the start of the run at which they begin [s], (m,).
        interval_s: length of a log interval [s].
        interval: interval in which each span lies, (n,).
        place: where in it the piece of the span begins, as a part of its length, (n,).
    """

    celsius: FloatArray
    begin_s: FloatArray
    interval_s: float
    interval: IntArray
    place: FloatArray

    @property
    def per_s(self) -> FloatArray:
        """Ṫ over each interval [K/s]."""
        return (self.celsius[:, 1] - self.celsius[:, 0]) / self.interval_s


@dataclass(frozen=True)
class Forcing:
    """n consecutive spans and the polynomials that hold over them.

    Attributes:
        length_s: length of the piece each span belongs to [s], (n,).
        begin: where in the piece the span begins, 0 ≤ begin < end ≤ 1, (n,).
        end: where in the piece the span ends, (n,).
        end_ns: time of the span's end from the start of the run [ns], (n,).
        logged: whether the state at the span's end is wanted, (n,).
        neutral: coefficients of x^j of the neutral line's direction γ [rad], (n, m); None where
            the platform lies still, or a window takes its place.
        tilt: the same of the neutral line's tilt in the case, γ − α_c [rad], (n, m'); None where
            it is zero, because the line moves with the case or the platform lies still.
        gravity: the same of the apparent gravity [m/s2], (n, m''); None where the pull does not
            depend on it.
        window: the neutral line by its samples; None where coefficients are wanted.
        lean: coefficients of x^j of the apparent vertical's direction less γ, β − γ [rad]; None
            where it is zero, or nothing asks for it.
        temperatures: those of the clock; None where the machine does not feel them.
    """

    length_s: FloatArray
    begin: FloatArray
    end: FloatArray
    end_ns: IntArray
    logged: NDArray[np.bool_]
    neutral: FloatArray | None = None
    tilt: FloatArray | None = None
    gravity: FloatArray | None = None
    window: Window | None = None
    lean: FloatArray | None = None
    temperatures: Temperatures | None = None


@dataclass(frozen=True)
class Motion:
    """The regulator's motion at n logged instants, all (n,).

    `half_turns` + `fraction` is the oscillator phase φ since the start, over π (reading.md).
    """

    angle: FloatArray
    """θ, the wheel in its case [rad]."""
    rate: FloatArray
    """θ̇ [rad/s]."""
    torque: FloatArray
    """Torque of the thread on the wheel [N m]."""
    half_turns: IntArray
    fraction: FloatArray
    phase_rate: FloatArray
    """φ̇ [rad/s]."""
    beats: IntArray
    """Passages of θ through zero since the start."""


def no_motion() -> Motion:
    """Return the motion at no instant."""
    empty, counts = np.empty(0), np.empty(0, np.int64)
    return Motion(empty, empty, empty, counts, empty, empty, counts)


# -----------------------------------------------------------------------------
# The oscillator phase (docs/theory/reading.md) and its exact reduction to half turns.
#
# φ is the unwrapped angle of (s, −ṡ/ω) less its value at the start, with s = ∫√M dϑ the arc length
# of the well and ω its small-amplitude frequency. A turn is added at every upward passage of ϑ =
# 0.

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
    halves = np.zeros(len(time_ns), np.int64)
    fraction = np.zeros(len(time_ns))
    # Two parts, each exact as a float, so that no length of run rounds the time.
    fine = time_ns % _COARSE_NS
    coarse = time_ns - fine
    for part in (coarse, fine) if coarse.any() else (fine,):
        time = part.astype(np.float64)
        product, error = _product(time, high)
        floor = np.floor(product)
        fraction += (product - floor) + (error + time * low)
        halves += floor.astype(np.int64)
    carry = np.floor(fraction)
    return halves + carry.astype(np.int64), fraction - carry


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

    A turn ends where x passes zero upwards, which is where turns are counted (reading.md). A
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
    phase = (angle - start) / math.pi
    floor = np.floor(phase)
    return 2 * turns + floor.astype(np.int64), phase - floor


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
