"""The ideal cam on a steady platform: harmonic motion in closed form.

θ = A cos ωt with ω² = F t'/I, exact at any time at no cost per swing (A §XV–XIX: isochronous with
a simple pendulum of length I g/(P r)). The phase ωt is reduced as t · ω/π with ω/π carried to
twice the working precision, so that a hundred days later only the rounding of the phase is left.
"""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np

from tauto_core.machines import Machine
from tauto_core.motion.closed_form import ClosedForm
from tauto_core.motion.forcing import Motion
from tauto_core.motion.phase import DIGITS, PI, half_turns, two_floats
from tauto_core.samples import IntArray

NAME = 'harmonic'


def frequency(machine: Machine) -> Decimal:
    """Return ω = √(F t'/I) of a harmonic well in 50 digits, the machine's numbers exact [1/s]."""
    with localcontext() as context:
        context.prec = DIGITS
        pull = Decimal(machine.force) + Decimal(machine.pulling_mass) * Decimal(machine.gravity)
        rate = Decimal(machine.cam.linear_rate or 0.0)
        return (pull * rate / Decimal(machine.inertia)).sqrt()


def half_turns_per_ns(omega: Decimal) -> tuple[float, float]:
    """Return ω/π per nanosecond as the sum of two floats."""
    with localcontext() as context:
        context.prec = DIGITS
        return two_floats(omega / PI / 10**9)


class Harmonic(ClosedForm):
    """Propagator of an ideal cam at rest; the state is the release angle, which never changes."""

    name = NAME

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._half_turns_per_ns = half_turns_per_ns(frequency(machine))

    def motion_at(self, time_ns: IntArray) -> Motion:
        """Return the motion at times since the release [ns], (n,)."""
        machine = self._machine
        omega = machine.frequency
        half, fraction = half_turns(time_ns, self._half_turns_per_ns)
        amplitude = np.where(half % 2 == 0, machine.release_angle, -machine.release_angle)
        angle = amplitude * np.cos(np.pi * fraction)
        return Motion(
            angle=angle,
            rate=-amplitude * omega * np.sin(np.pi * fraction),
            torque=-machine.inertia * omega * omega * angle,
            half_turns=half,
            fraction=fraction,
            phase_rate=np.full(len(time_ns), omega),
            beats=half + (fraction > 0.5),
        )
