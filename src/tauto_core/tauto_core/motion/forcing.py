"""The forcing of the machine, its motion, and the oscillator phase.

A piece is the time between two joints of the forcing's polynomials. Joints are samples of the
ship's motion, one or several sample intervals apart. x runs from 0 to 1 over the `length_s` of a
piece. A span is a part of a piece, from x = `begin` to `end`. Spans follow each other without
gaps, and a span ends at each logged instant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.machines import AnyMachine, Machine, SlackThreadError
from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene.errors import CamRangeError, PropagationError

LEAST_UPWARD = 1.0
"""Least upward specific force in the case with which a thread follows its direction [m/s²]."""


def swings_freely(machine: AnyMachine) -> bool:
    """Return whether a release leads to a swing within range, with a taut thread."""
    try:
        return machine.release_angle != 0.0 and machine.period(machine.release_angle) > 0.0
    except (CamRangeError, SlackThreadError):
        return False


# -----------------------------------------------------------------------------
# Errors that end a motion, shared by all propagators.


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
    """Return the error of a slack thread."""
    return PropagationError(
        'the thread went slack (its tension fell to 0 N, and a thread cannot push). Use a lighter '
        'weight, a smaller release angle, a stronger pull or a calmer sea; smooth the '
        'accelerations of a noisy sensor',
        time_s,
    )


def lifted_off(time_s: float) -> PropagationError:
    """Return the error of a suspended case that lifts off its bearing."""
    return PropagationError(
        'the axle of the suspension lifted off its bearing (the contact force fell to 0 N). Keep '
        "its period away from the sea's, hang the case nearer to the roll axis (ship.height), or "
        'choose a calmer sea',
        time_s,
    )


def beyond_small_angles(tilt: float, limit: float, time_s: float) -> PropagationError:
    """Return the error of a suspended case that swings beyond the range of its equations."""
    return PropagationError(
        f'the suspended case swings {tilt:.3g} rad from the vertical; the equations of small '
        f'angles are taken up to {limit:g} rad. Set suspension.large_angles to true, or keep the '
        "case's periods away from the sea's",
        time_s,
    )


class Polynomials(NamedTuple):
    """A polynomial u over each of n spans.

    On a regular piece u interpolates values and rates of a window of evenly spaced samples,
    centred on the piece. All windows have the same number of samples. On other pieces u is given
    by its coefficients.

    Attributes:
        values: u at the samples, (m,).
        rates: u̇ at the samples [1/s], (m,).
        sample: index of the first sample of the span's window, ≥ 0. On an irregular piece,
            −1 minus its row in `fitted`, (n,).
        fitted: coefficients of x^j over irregular pieces, (k, w).
    """

    values: FloatArray
    rates: FloatArray
    sample: IntArray
    fitted: FloatArray


@dataclass(frozen=True)
class Window:
    """The neutral line by its samples, for linear propagators.

    Attributes:
        nodes: x of the p samples of a regular piece's window.
        line: γ over the spans [rad], with w = 2p.
    """

    nodes: tuple[float, ...]
    line: Polynomials


@dataclass(frozen=True)
class Temperatures:
    """The clock's temperature, linear within each of m log intervals, for n spans.

    Attributes:
        celsius: temperature at the beginning and at the end of each interval [°C], (m, 2).
        begin_s: time from the start of the run to the beginning of each interval [s], (m,).
        interval_s: length of a log interval [s].
        interval: index of the span's interval, (n,).
        place: time from the interval's beginning to the beginning of the span's piece, over the
            length of the interval, (n,).
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
    """n consecutive spans and their polynomials in x. An absent channel is `None`.

    Attributes:
        length_s: length of the span's piece [s], (n,).
        begin, end: x at both ends of the span, 0 ≤ begin < end ≤ 1, (n,).
        end_ns: time from the start of the run to the span's end [ns], (n,).
        logged: whether the state at the span's end is logged, (n,).
        neutral: coefficients of the neutral line's direction γ [rad], (n, m). Absent on a still
            platform, and if `window` is given.
        tilt: coefficients of the neutral line's tilt in the case, γ − α_c [rad], (n, m'). Absent
            on a still platform, and if the line moves with the case.
        gravity: coefficients of the apparent gravity [m/s2], (n, m''). Absent if the pull does
            not depend on it.
        window: the neutral line by its samples, instead of `neutral`.
        lean: coefficients of β − γ, the apparent vertical from the neutral line [rad], for an
            unbalanced wheel.
        temperatures: the clock's temperatures, for a machine that heat changes.
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

    def part(self, start: int, stop: int | None = None) -> Forcing:
        """Return the spans from `start` up to `stop`, exclusive, without copying them."""
        wanted, heat = slice(start, stop), self.temperatures
        rows = {name: getattr(self, name) for name in SPANNED}
        parts: dict[str, Any] = {
            name: None if row is None else row[wanted] for name, row in rows.items()
        }
        if heat is not None:
            first = int(heat.interval[start]) if start < len(heat.interval) else 0
            heat = Temperatures(
                heat.celsius[first:],
                heat.begin_s[first:],
                heat.interval_s,
                heat.interval[wanted] - first,
                heat.place[wanted],
            )
        return replace(self, **parts, temperatures=heat)

    def rest(self, k: int, x: float) -> Forcing:
        """Return the spans from x in span k on."""
        rest = self.part(k)
        begin = rest.begin.copy()
        begin[:1] = x
        return replace(rest, begin=begin)


SPANNED = 'length_s', 'begin', 'end', 'end_ns', 'logged', 'neutral', 'tilt', 'gravity', 'lean'
"""Fields of a forcing that have one row per span."""


@dataclass(frozen=True)
class Motion:
    """The regulator's motion at n logged instants, all (n,).

    `half_turns` + `fraction` is φ/π, with the oscillator phase φ since the start (reading.md).
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
# φ is the unwrapped angle of (s, −ṡ/ω) minus its value at the start, with the arc length of the
# well s = ∫√M dϑ and its small-amplitude frequency ω. Each upward passage of ϑ = 0 adds a turn.

PI = Decimal('3.14159265358979323846264338327950288419716939937510582097494459')
PHASE_DIGITS = 50
"""Digits of decimal arithmetic with phases."""

# Nanoseconds are exact as a float up to here: 104 days.
_COARSE_NS = 2**53

BELOW_ONE = 1.0 - 2.0**-53
"""The largest fraction of a half turn."""

_SPLIT = 134217729.0  # 2^27 + 1, Dekker's splitter


def half_turns(time_ns: IntArray, per_ns: tuple[float, float]) -> tuple[IntArray, FloatArray]:
    """Return the phase of a uniform rotation in whole half turns and the fraction in [0, 1).

    The time since the release is ≥ 0 [ns], (n,). `per_ns` is the half turns per ns as two floats.
    Only the fraction is rounded, at any length of time (Dekker's exact product, 1971).
    """
    high, low = per_ns
    halves = np.zeros(len(time_ns), np.int64)
    fraction = np.zeros(len(time_ns))
    # two parts, each exact as a float, keep the time exact at any length of run
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
    """Return a·b and its exact rounding error."""
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

    A turn ends at the upward passage of x through zero, which is counted (reading.md). Only a
    release from rest at zero can coincide with this end. Its angle then follows the sign of the
    acceleration.
    """
    rests = (coordinate == 0.0) & (speed == 0.0)
    speed = np.where(rests, acceleration, speed)
    # adding 0.0 turns −0.0, which arctan2 distinguishes from 0.0, into 0.0
    angle = np.arctan2(0.0 - speed / omega, coordinate + 0.0)
    return np.where((coordinate < 0.0) & (angle < 0.0), angle + math.tau, angle)


def polar_rate(
    coordinate: FloatArray, speed: FloatArray, acceleration: FloatArray, omega: float
) -> FloatArray:
    """Return φ̇ = ω (ẋ² − x ẍ)/(ω² x² + ẋ²) [rad/s], or 0 at rest at zero (φ is undefined)."""
    square = omega * omega * coordinate * coordinate + speed * speed
    areal = omega * (speed * speed - coordinate * acceleration)
    return np.divide(areal, square, out=np.zeros_like(square), where=square > 0.0)


def since_start(turns: IntArray, angle: FloatArray, start: float) -> tuple[IntArray, FloatArray]:
    """Return the phase since the start in whole half turns and the fraction in [0, 1), (n,).

    Args:
        turns: upward passages since the start, (n,).
        angle: angle within a turn (`polar`) [rad], (n,).
        start: the angle at the start [rad].
    """
    phase = (angle - start) / math.pi
    floor = np.floor(phase)
    return 2 * turns + floor.astype(np.int64), phase - floor


def within_turn(
    machine: Machine, angle: FloatArray, rate: FloatArray, acceleration: FloatArray
) -> FloatArray:
    """Return the angle of (s, −ṡ/ω) in [−π/2, 3π/2) from ϑ, ϑ̇ and ϑ̈ (`polar`)."""
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
