"""Sully's lever on a steady platform: exact at any time, at no cost per swing.

As in `action_angle`, but the well is not even. With V = V(A) cos²W a half swing, from one turning
point to the other, takes W from 0 to π, and the way back takes as long. dt/dW is one Chebyshev
series, integrated term by term and inverted.
"""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

import numpy as np

from tauto_core.machines import LeverMachine
from tauto_core.motion.action_angle import inverse, rising, series_of
from tauto_core.motion.closed_form import ClosedForm
from tauto_core.motion.forcing import Motion
from tauto_core.motion.phase import BELOW_ONE, DIGITS, half_turns, polar_rate, two_floats
from tauto_core.samples import FloatArray, IntArray

NAME = 'action_angle'


class UnevenWell(ClosedForm):
    """Propagator of Sully's lever at rest; nothing changes but the time.

    Raises:
        PropagationError: a well whose swing no Chebyshev series of degree 4096 describes.
    """

    name = NAME

    def __init__(self, machine: LeverMachine) -> None:
        self._machine, self._amplitude = machine, machine.release_angle
        self._sign = math.copysign(1.0, machine.release_angle)
        self._time = rising(
            series_of(lambda w: machine.swing(self._amplitude, w)[1], 0.0, math.pi)
        )
        with localcontext() as context:
            context.prec = DIGITS
            # whole swings are counted by the quadrature of the period, not by the series
            per_ns = 2 / Decimal(machine.period(self._amplitude)) / 10**9
            self._per_ns = two_floats(per_ns)

    def motion_at(self, time_ns: IntArray) -> Motion:
        """Return the motion at times since the release [ns], (n,)."""
        machine = self._machine
        half, fraction = half_turns(time_ns, self._per_ns)
        there = half % 2 == 0
        part = np.where(there, fraction, 1.0 - fraction)
        w = 0.5 * math.pi * (1.0 + inverse(self._time, part * self._time.top))
        tau, _ = machine.swing(self._amplitude, w)
        _, beta, _, _ = machine.geometry.pose(tau)
        slope, bend = machine.geometry.slopes(tau)
        turned, weight = machine.turned_inertia, machine.weight_torque
        mass = machine.inertia + turned * slope * slope
        top = weight * float(np.sin(machine.beta(self._amplitude)))
        away = -self._sign * np.where(there, 1.0, -1.0)
        rate = away * np.sqrt(2.0 * top / mass) * np.sin(w)
        ride = turned * slope * bend * rate * rate
        acceleration = -(weight * np.cos(beta) * slope + ride) / mass
        angle = machine.geometry.theta(tau)
        x, speed = machine.arc(angle), np.sqrt(mass) * rate
        pushed = -weight * np.cos(beta) * slope / np.sqrt(mass)
        return Motion(
            angle=angle,
            rate=rate,
            torque=machine.inertia * acceleration,
            half_turns=half,
            fraction=self._fraction(x, speed, half, fraction),
            phase_rate=polar_rate(x, speed, pushed, machine.frequency),
            beats=half + (away * angle > 0.0),
        )

    def _fraction(
        self, x: FloatArray, speed: FloatArray, half: IntArray, time: FloatArray
    ) -> FloatArray:
        """Return the phase since the last turning point, in half turns, within [0, 1)."""
        side = self._sign * np.where(half % 2 == 0, 1.0, -1.0)
        turned = np.arctan2(0.0 - side * speed / self._machine.frequency, side * x) / math.pi
        # the turning point itself, from either side, is where the half turns join
        return np.where(time < 0.5, np.maximum(turned, 0.0), np.minimum(turned, BELOW_ONE))
