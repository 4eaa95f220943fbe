"""Propagators of motions in closed form, without a running state.

The ideal cam on a platform at rest, any even conservative well by action and angle, and Sully's
lever, an uneven well.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext

import numpy as np
from numpy.polynomial import chebyshev

from tauto_core.curves.numerics import (
    bracketed_newton,
    chebyshev_coefficients,
    chebyshev_nodes,
    complete_series,
)
from tauto_core.machines import LeverMachine, Machine
from tauto_core.motion.forcing import (
    BELOW_ONE,
    PHASE_DIGITS,
    PI,
    Forcing,
    Motion,
    half_turns,
    phase_rate,
    polar_rate,
    within_turn,
)
from tauto_core.samples import FloatArray, IntArray, State
from tauto_core.scene.errors import PropagationError


class ClosedForm(ABC):
    """A propagator of a motion that is a function of the time since the release."""

    @abstractmethod
    def motion_at(self, time_ns: IntArray) -> Motion:
        """Return the motion at times since the release [ns], (n,)."""

    def release(self, forcing: Forcing) -> Motion:
        """Return the motion at the start."""
        del forcing
        return self.motion_at(np.zeros(1, np.int64))

    def advance(self, forcing: Forcing) -> Motion:
        """Return the motion at the logged ends of the spans."""
        return self.motion_at(forcing.end_ns[forcing.logged])

    def state(self) -> State:
        """Return the empty state: the motion is known at any time."""
        return {}

    def restore(self, state: State) -> None:
        """Accept the empty state."""
        del state


# -----------------------------------------------------------------------------
# The ideal cam on a platform at rest: harmonic motion in closed form.
#
# A wheel released at rest at ϑ = A moves as s = s(A) cos ωt along the arc s = ∫√M dϑ, with M the
# moment of inertia and ω² = F t'(0)/I (A §XV–XIX: isochronous with a simple pendulum of length I
# g/(P r)). If only the wheel has inertia, s is proportional to ϑ. With the cam corrected for a
# weight it is not (D in cams.md).
#
# t · ω/π is reduced to half turns with ω/π in twice the working precision. Even after a hundred
# days the phase is exact to its own rounding.


def frequency(machine: Machine) -> Decimal:
    """Return ω = √(F t'(0)/I) in 50 digits, from the machine's floats as exact numbers [rad/s]."""
    with localcontext() as context:
        context.prec = PHASE_DIGITS
        pull = Decimal(machine.force) + Decimal(machine.pulling_mass) * Decimal(machine.gravity)
        rate = Decimal(float(machine.cam.lever_rate(0.0)))
        return (pull * rate / Decimal(machine.inertia)).sqrt()


def half_turns_per_ns(angle: Decimal, per: Decimal) -> tuple[float, float]:
    """Return angle/per, half turns per second, per nanosecond as the sum of two floats.

    The sum is good to about 32 digits.
    """
    with localcontext() as context:
        context.prec = PHASE_DIGITS
        exact = angle / per / 10**9
        high = float(exact)
        return high, float(exact - Decimal(high))


class Harmonic(ClosedForm):
    """Propagator of an ideal cam on a platform at rest."""

    name = 'harmonic'

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._half_turns_per_ns = half_turns_per_ns(frequency(machine), PI)

    def motion_at(self, time_ns: IntArray) -> Motion:
        """Return the motion at times since the release [ns], (n,)."""
        machine = self._machine
        omega = machine.frequency
        count, fraction = half_turns(time_ns, self._half_turns_per_ns)
        turned = np.pi * fraction
        sign = np.where(count % 2, -1.0, 1.0)
        cosine, sine = sign * np.cos(turned), sign * np.sin(turned)
        if machine.is_linear:
            angle = machine.release_angle * cosine
            rate = -machine.release_angle * omega * sine
            torque = -machine.inertia * omega * omega * angle
        else:
            # from ṡ = √M ϑ̇ and s̈ = −ω²s: ϑ̈ = −(ω²s + m t t' ϑ̇²/√M)/√M
            top = float(machine.arc(machine.release_angle))
            angle = machine.angle_of_arc(top * cosine)
            root = np.sqrt(machine.mass(angle))
            rate = -top * omega * sine / root
            arm, slope = machine.cam.lever_arm(angle), machine.cam.lever_rate(angle)
            ride = machine.carried_mass * arm * slope * rate * rate / root
            torque = -machine.inertia * (omega * omega * top * cosine + ride) / root
        return Motion(
            angle=angle,
            rate=rate,
            torque=torque,
            half_turns=count,
            fraction=fraction,
            phase_rate=np.full(len(time_ns), omega),
            beats=count + (fraction > 0.5),
        )


# -----------------------------------------------------------------------------
# Any even conservative well on a steady platform: exact at any time, at no cost per swing.
#
# With V(ϑ) = V(A) cos²W the swing runs once round in W: ϑ = A at W = 0, the middle at W = π/2, and
# the time since the top is t(W) = ∫ g dW with
#
#     g(W) = √(2 V(A) M) · cos W / V'(ϑ),      ϑ̇ = −√(2 V(A)/M) sin W.
#
# g is smooth up to the turning points, since V' vanishes with cos W. The quarter swing 0 ≤ W ≤ π/2
# is cut at the cam's joints. On each part g is a Chebyshev series to rounding, integrated term by
# term. The other quarters follow by symmetry, even with a kink in the middle. Whole swings are
# removed exactly, then one bracketed Newton iteration per instant inverts t(W).
#
# Source: action–angle variables of one degree of freedom, e.g. Arnold, Mathematical Methods of
# Classical Mechanics, §50. The substitution is the same as in `machines.Machine.period`.

LARGEST_DEGREE = 4096
# Numbers of coefficients tried: 17 to LARGEST_DEGREE + 1.
_COUNTS = tuple(1 + 2**n for n in range(4, 13))

INVERTED_TO = 2.0**-32
"""Change of x that ends Newton's method: its next step is exact to rounding."""

LONGEST_INVERTED = 256
"""Most coefficients of a series that is inverted beforehand."""

TIME_TAIL = 2.0**-50
"""A series is complete if its last coefficients are below this share of the first."""


class ActionAngle(ClosedForm):
    """Propagator of a conservative well at rest.

    Raises a PropagationError for a swing that needs more than degree 4096, and a SlackThreadError
    if the thread goes slack.
    """

    name = 'action_angle'

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._amplitude = abs(machine.release_angle)
        self._sign = math.copysign(1.0, machine.release_angle)
        self._top = float(machine.potential(self._amplitude))
        joints = machine.cam.joints
        inner_joints = joints[joints < self._amplitude]
        cuts = np.arccos(np.sqrt(machine.potential(inner_joints) / self._top))[::-1]
        self._edges = np.concatenate([[0.0], cuts, [0.5 * math.pi]])
        pairs = zip(self._edges, self._edges[1:], strict=False)
        parts = [series_of(lambda w: self._curve(w)[1], a, b) for a, b in pairs]
        self._parts = [rising(part) for part in parts]
        self._times = np.concatenate([[0.0], np.cumsum([part.top for part in self._parts])])
        period = machine.period(self._amplitude)
        # whole swings are counted by the quadrature of the period, not by the sum of the series
        self._per_ns = half_turns_per_ns(Decimal(2), Decimal(period))

    def _curve(self, w: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return ϑ ≥ 0 and g at W in [0, π/2]."""
        machine = self._machine
        cosine = np.cos(w)
        lift = machine.lift_of_potential(self._top * cosine * cosine)
        angle = np.minimum(machine.cam.angle_of_lift(lift), self._amplitude)
        slope = machine.pull(lift) * machine.cam.lever_arm(angle)
        return angle, np.sqrt(2.0 * self._top * machine.mass(angle)) * cosine / slope

    def motion_at(self, time_ns: IntArray) -> Motion:
        """Return the motion at times since the release [ns], (n,)."""
        machine = self._machine
        count, fraction = half_turns(time_ns, self._per_ns)
        falling = fraction <= 0.5
        quarter = np.where(falling, fraction, 1.0 - fraction) * 2.0
        time = quarter * self._times[-1]
        part = np.clip(np.searchsorted(self._times, time, 'right') - 1, 0, len(self._parts) - 1)
        w = np.empty_like(time)
        for index, risen in enumerate(self._parts):
            rows = part == index
            if rows.any():
                a, b = self._edges[index], self._edges[index + 1]
                x = inverse(risen, time[rows] - self._times[index])
                w[rows] = a + 0.5 * (b - a) * (1.0 + x)
        size, _ = self._curve(w)
        sign = self._sign * np.where(count % 2 == 0, 1.0, -1.0)
        angle = sign * np.where(falling, size, -size)
        mass = machine.mass(angle)
        rate = -sign * np.sqrt(2.0 * self._top / mass) * np.sin(w)
        arm, slope = machine.cam.lever_arm(angle), machine.cam.lever_rate(angle)
        pull = machine.pull(machine.cam.lift(angle))
        carried = machine.carried_mass
        acceleration = -(pull * arm + carried * arm * slope * rate * rate) / mass
        tension = pull + carried * (slope * rate * rate + arm * acceleration)
        turned = within_turn(machine, sign * angle, sign * rate, sign * acceleration) / math.pi
        return Motion(
            angle=angle,
            rate=rate,
            torque=-tension * arm,
            half_turns=count,
            # the half turns join at the top, from either side
            fraction=np.where(
                fraction < 0.5, np.maximum(turned, 0.0), np.minimum(turned, BELOW_ONE)
            ),
            phase_rate=phase_rate(machine, angle, rate, acceleration),
            beats=count + (fraction > 0.5),
        )


def series_of(slope: Callable[[FloatArray], FloatArray], a: float, b: float) -> FloatArray:
    """Return the Chebyshev coefficients on [−1, 1] of t(W) = ∫_a^W slope dW over [a, b] [s].

    Raises a PropagationError if more than 4096 coefficients are needed.
    """

    def series(count: int) -> FloatArray:
        return chebyshev_coefficients(slope(a + 0.5 * (b - a) * (1.0 + chebyshev_nodes(count))))

    coefficients = complete_series(series, _COUNTS, TIME_TAIL)
    if coefficients is not None:
        # every instant pays for each coefficient: drop less than an eighth of a rounding
        terms = chebyshev.chebtrim(coefficients, 2.0**-56 * np.max(np.abs(coefficients)))
        return np.asarray(chebyshev.chebint(terms, scl=0.5 * (b - a), lbnd=-1.0))
    raise PropagationError(
        'the swing released takes more than 4096 Chebyshev coefficients. Smooth the table of the '
        'cam, or release at a smaller angle',
        0.0,
    )


def _value(series: FloatArray, x: FloatArray | float) -> FloatArray:
    """Return a Chebyshev series at x."""
    return np.asarray(chebyshev.chebval(x, series))


@dataclass(frozen=True)
class Rising:
    """An increasing Chebyshev series on [−1, 1], 0 at −1, with an estimate of its inverse.

    Attributes:
        series: its coefficients.
        slope: coefficients of its derivative.
        top: its value at 1.
        guess: start of Newton's method for x, as a series of 2·value/top − 1, a straight line for
            a series longer than `LONGEST_INVERTED`.
    """

    series: FloatArray
    slope: FloatArray
    top: float
    guess: FloatArray


def rising(series: FloatArray) -> Rising:
    """Return an increasing series with an estimate of its inverse."""
    slope = np.asarray(chebyshev.chebder(series), np.float64)
    straight = Rising(series, slope, float(_value(series, 1.0)), np.array([0.0, 1.0]))
    if len(series) > LONGEST_INVERTED:
        return straight
    times = 0.5 * straight.top * (1.0 + chebyshev_nodes(2 * len(series)))
    guess = chebyshev_coefficients(inverse(straight, times))
    return replace(straight, guess=np.asarray(chebyshev.chebtrim(guess, INVERTED_TO), np.float64))


def inverse(risen: Rising, value: FloatArray) -> FloatArray:
    """Return x in [−1, 1] at which an increasing series has the value, 0 to its top."""
    return bracketed_newton(
        lambda x: (_value(risen.series, x) - value, _value(risen.slope, x)),
        _value(risen.guess, 2.0 * value / risen.top - 1.0),
        (-1.0, 1.0),
        absolute=INVERTED_TO,
    )


# -----------------------------------------------------------------------------
# Sully's lever on a steady platform: exact at any time, at no cost per swing.
#
# As in `ActionAngle`, but the well is not even. With V = V(A) cos²W a half swing, from one turning
# point to the other, takes W from 0 to π, and the way back takes as long. dt/dW is one Chebyshev
# series, integrated term by term and inverted.


class UnevenWell(ClosedForm):
    """Propagator of Sully's lever at rest.

    Raises a PropagationError for a swing that needs more than degree 4096.
    """

    name = 'action_angle'

    def __init__(self, machine: LeverMachine) -> None:
        self._machine, self._amplitude = machine, machine.release_angle
        self._sign = math.copysign(1.0, machine.release_angle)
        self._time = rising(
            series_of(lambda w: machine.swing(self._amplitude, w)[1], 0.0, math.pi)
        )
        # whole swings are counted by the quadrature of the period, not by the series
        self._per_ns = half_turns_per_ns(Decimal(2), Decimal(machine.period(self._amplitude)))

    def motion_at(self, time_ns: IntArray) -> Motion:
        """Return the motion at times since the release [ns], (n,)."""
        machine = self._machine
        count, fraction = half_turns(time_ns, self._per_ns)
        is_outward = count % 2 == 0
        part = np.where(is_outward, fraction, 1.0 - fraction)
        w = 0.5 * math.pi * (1.0 + inverse(self._time, part * self._time.top))
        tau, _ = machine.swing(self._amplitude, w)
        slope, bend = machine.geometry.slopes(tau)
        turned, against = machine.turned_inertia, machine.pushed(tau) * slope
        mass = machine.inertia + turned * slope * slope
        top = float(machine.potential(self._amplitude))
        away = -self._sign * np.where(is_outward, 1.0, -1.0)
        rate = away * np.sqrt(2.0 * top / mass) * np.sin(w)
        ride = turned * slope * bend * rate * rate
        acceleration = -(against + ride) / mass
        angle = machine.geometry.theta(tau)
        x, speed = machine.arc(angle), np.sqrt(mass) * rate
        pushed = -against / np.sqrt(mass)
        side = self._sign * np.where(is_outward, 1.0, -1.0)
        turned_by = np.arctan2(0.0 - side * speed / machine.frequency, side * x) / math.pi
        return Motion(
            angle=angle,
            rate=rate,
            torque=machine.inertia * acceleration,
            half_turns=count,
            # the half turns join at the turning point, from either side
            fraction=np.where(
                fraction < 0.5, np.maximum(turned_by, 0.0), np.minimum(turned_by, BELOW_ONE)
            ),
            phase_rate=polar_rate(x, speed, pushed, machine.frequency),
            beats=count + (away * angle > 0.0),
        )
