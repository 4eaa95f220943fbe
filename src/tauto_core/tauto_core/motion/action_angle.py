"""Any even conservative well on a steady platform: exact at any time, at no cost per swing.

With V(ϑ) = V(A) cos²W the swing runs once round in W: ϑ = A at W = 0, the middle at W = π/2, and
the time since the top is t(W) = ∫ g dW with

    g(W) = √(2 V(A) M) · cos W / V'(ϑ),      ϑ̇ = −√(2 V(A)/M) sin W,

smooth up to the turning points, since V' vanishes with cos W. The quarter swing 0 ≤ W ≤ π/2 is cut
at the cam's joints; on each part g is a Chebyshev series to rounding, integrated term by term. The
other quarters follow by symmetry, also where the well has a kink in the middle. Inverting t(W) is
one bracketed Newton iteration per instant; whole swings are taken off beforehand, exactly.

Source: action–angle variables of one degree of freedom, e.g. Arnold, Mathematical Methods of
Classical Mechanics, §50; the substitution is that of `machines.Machine.period`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext

import numpy as np
from numpy.polynomial import chebyshev

from tauto_core.curves.newton import bracketed_newton
from tauto_core.machines import Machine
from tauto_core.motion.chebyshev_fit import coefficients, nodes
from tauto_core.motion.closed_form import ClosedForm
from tauto_core.motion.forcing import Motion
from tauto_core.motion.phase import (
    BELOW_ONE,
    DIGITS,
    half_turns,
    phase_rate,
    two_floats,
    within_turn,
)
from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene.errors import PropagationError

NAME = 'action_angle'

LARGEST_DEGREE = 4096
SMALLEST_DEGREE = 16
NEAR = 2.0**-32
"""Change of x at which Newton's method ends: its next step is exact to rounding."""

LONGEST_INVERTED = 256
"""Largest number of coefficients of a series that is inverted beforehand."""

TAIL = 2.0**-50
"""Size of the last coefficients, relative to the first, at which a series counts as complete."""


class ActionAngle(ClosedForm):
    """Propagator of a conservative well at rest; nothing changes but the time.

    Raises:
        PropagationError: a well whose swing no Chebyshev series of degree 4096 describes.
        SlackThreadError: a swing in which the thread goes slack.
    """

    name = NAME

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._amplitude = abs(machine.release_angle)
        self._sign = math.copysign(1.0, machine.release_angle)
        self._top = float(machine.potential(self._amplitude))
        joints = machine.cam.joints
        inside = joints[joints < self._amplitude]
        cuts = np.arccos(np.sqrt(machine.potential(inside) / self._top))[::-1]
        self._edges = np.concatenate([[0.0], cuts, [0.5 * math.pi]])
        pairs = zip(self._edges, self._edges[1:], strict=False)
        parts = [series_of(lambda w: self._curve(w)[1], a, b) for a, b in pairs]
        self._parts = [rising(part) for part in parts]
        self._times = np.concatenate([[0.0], np.cumsum([part.top for part in self._parts])])
        period = machine.period(self._amplitude)
        # whole swings are counted by the quadrature of the period, not by the sum of the series
        with localcontext() as context:
            context.prec = DIGITS
            self._per_ns = two_floats(2 / Decimal(period) / 10**9)

    def _curve(self, w: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return ϑ ≥ 0 and g at W in [0, π/2]."""
        machine = self._machine
        cosine = np.cos(w)
        lift = machine.lift_of_potential(self._top * cosine * cosine)
        angle = np.minimum(machine.cam.angle_of_lift(lift), self._amplitude)
        slope = machine.pull(lift) * machine.cam.lever_arm(angle)
        return angle, np.sqrt(2.0 * self._top * machine.mass(angle)) * cosine / slope

    def _w_at(self, time: FloatArray) -> FloatArray:
        """Return W in [0, π/2] at times since the top, 0 ≤ t ≤ a quarter swing [s]."""
        part = np.clip(np.searchsorted(self._times, time, 'right') - 1, 0, len(self._parts) - 1)
        result = np.empty_like(time)
        for index, risen in enumerate(self._parts):
            rows = part == index
            if rows.any():
                a, b = self._edges[index], self._edges[index + 1]
                x = inverse(risen, time[rows] - self._times[index])
                result[rows] = a + 0.5 * (b - a) * (1.0 + x)
        return result

    def motion_at(self, time_ns: IntArray) -> Motion:
        """Return the motion at times since the release [ns], (n,)."""
        machine = self._machine
        half, fraction = half_turns(time_ns, self._per_ns)
        falling = fraction <= 0.5
        quarter = np.where(falling, fraction, 1.0 - fraction) * 2.0
        w = self._w_at(quarter * self._times[-1])
        size, _ = self._curve(w)
        sign = self._sign * np.where(half % 2 == 0, 1.0, -1.0)
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
            half_turns=half,
            # the top itself, from either side, is where the half turns join
            fraction=np.where(
                fraction < 0.5, np.maximum(turned, 0.0), np.minimum(turned, BELOW_ONE)
            ),
            phase_rate=phase_rate(machine, angle, rate, acceleration),
            beats=half + (fraction > 0.5),
        )


def series_of(slope: Callable[[FloatArray], FloatArray], a: float, b: float) -> FloatArray:
    """Return the Chebyshev coefficients on [−1, 1] of t(W) = ∫_a^W (dt/dW) dW over [a, b].

    Args:
        slope: dt/dW of W [s/rad], > 0.
        a: where W begins [rad].
        b: where it ends [rad].

    Raises:
        PropagationError: more than 4096 coefficients.
    """
    degree = SMALLEST_DEGREE
    while degree <= LARGEST_DEGREE:
        w = a + 0.5 * (b - a) * (1.0 + nodes(degree + 1))
        found = coefficients(slope(w))
        if np.max(np.abs(found[-4:])) <= TAIL * np.max(np.abs(found)):
            kept = chebyshev.chebtrim(found, 2.0**-56 * np.max(np.abs(found)))
            return np.asarray(chebyshev.chebint(kept, scl=0.5 * (b - a), lbnd=-1.0))
        degree *= 2
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
        slope: those of its derivative.
        top: its value at 1.
        back: an estimate of x, as a series of 2·value/top − 1, from which Newton's method starts;
            a straight line where the series is too long to be inverted beforehand.
    """

    series: FloatArray
    slope: FloatArray
    top: float
    back: FloatArray


def rising(series: FloatArray) -> Rising:
    """Return an increasing series with an estimate of its inverse."""
    slope = np.asarray(chebyshev.chebder(series), np.float64)
    straight = Rising(series, slope, float(_value(series, 1.0)), np.array([0.0, 1.0]))
    if len(series) > LONGEST_INVERTED:
        return straight
    found = coefficients(inverse(straight, 0.5 * straight.top * (1.0 + nodes(2 * len(series)))))
    return replace(straight, back=np.asarray(chebyshev.chebtrim(found, NEAR), np.float64))


def inverse(risen: Rising, value: FloatArray) -> FloatArray:
    """Return x in [−1, 1] at which an increasing series has the value, 0 to its top."""
    return bracketed_newton(
        lambda x: (_value(risen.series, x) - value, _value(risen.slope, x)),
        _value(risen.back, 2.0 * value / risen.top - 1.0),
        (-1.0, 1.0),
        absolute=NEAR,
    )
