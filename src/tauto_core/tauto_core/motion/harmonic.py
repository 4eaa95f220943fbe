"""The ideal cam on a steady platform: harmonic motion in closed form.

θ = A cos ωt with ω² = F t'/I, exact at any time at no cost per swing (A §XV–XIX: isochronous with
a simple pendulum of length I g/(P r)). The phase ωt is reduced as t · ω/π with ω/π carried to
twice the working precision, so that a hundred days later only the rounding of the phase is left.
"""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np

from tauto_core.machines import Machine
from tauto_core.motion.forcing import Forcing, Motion
from tauto_core.samples import FloatArray, IntArray, State

NAME = 'harmonic'
_PI = Decimal('3.14159265358979323846264338327950288419716939937510582097494459')
_COARSE_NS = 2**32
_SPLIT = 134217729.0  # 2^27 + 1, Dekker's splitter


def half_turns_per_ns(machine: Machine) -> tuple[float, float]:
    """Return ω/π per nanosecond as the sum of two floats.

    The machine's numbers are taken as exact: ω = √(F t'/I) in 50 digits.
    """
    with localcontext() as context:
        context.prec = 50
        pull = Decimal(machine.force) + Decimal(machine.pulling_mass) * Decimal(machine.gravity)
        rate = Decimal(machine.cam.linear_rate or 0.0)
        exact = (pull * rate / Decimal(machine.inertia)).sqrt() / _PI / Decimal(10**9)
        high = float(exact)
        return high, float(exact - Decimal(high))


def _product(a: FloatArray, b: float) -> tuple[FloatArray, FloatArray]:
    """Return a·b and its rounding error, exactly (Dekker 1971)."""
    product = a * b
    c = _SPLIT * a
    a_high = c - (c - a)
    a_low = a - a_high
    c_b = _SPLIT * b
    b_high = c_b - (c_b - b)
    b_low = b - b_high
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, error


def phase(machine: Machine, time_ns: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the phase in whole half turns and the fraction in [0, 1).

    Args:
        machine: one with a harmonic well.
        time_ns: time since the release [ns], t ≥ 0.
    """
    high, low = half_turns_per_ns(machine)
    whole = np.zeros(len(time_ns), np.int64)
    fraction = np.zeros(len(time_ns))
    # Two parts, each exact as a float, so that no length of run rounds the time.
    for part in (time_ns - time_ns % _COARSE_NS, time_ns % _COARSE_NS):
        time = part.astype(np.float64)
        product, error = _product(time, high)
        floor = np.floor(product)
        fraction += (product - floor) + (error + time * low)
        whole += floor.astype(np.int64)
    carry = np.floor(fraction)
    return whole + carry.astype(np.int64), fraction - carry


class Harmonic:
    """Propagator of an ideal cam at rest; the state is the release angle, which never changes."""

    name = NAME

    def __init__(self, machine: Machine) -> None:
        self._machine = machine

    def release(self, forcing: Forcing) -> Motion:
        """Return the motion at the start."""
        del forcing
        return self._at(np.zeros(1, np.int64))

    def advance(self, forcing: Forcing) -> Motion:
        """Return the motion at the logged ends of the spans."""
        return self._at(forcing.end_ns[forcing.logged])

    def _at(self, time_ns: IntArray) -> Motion:
        machine = self._machine
        omega = machine.frequency
        half_turns, fraction = phase(machine, time_ns)
        amplitude = np.where(half_turns % 2 == 0, machine.release_angle, -machine.release_angle)
        angle = amplitude * np.cos(np.pi * fraction)
        return Motion(
            angle=angle,
            rate=-amplitude * omega * np.sin(np.pi * fraction),
            torque=-machine.inertia * omega * omega * angle,
            half_turns=half_turns,
            fraction=fraction,
            phase_rate=np.full(len(time_ns), omega),
            beats=half_turns + (fraction > 0.5),
        )

    def state(self) -> State:
        """Return nothing: the motion is known at any time."""
        return {}

    def restore(self, state: State) -> None:
        """Accept the empty state."""
        del state
