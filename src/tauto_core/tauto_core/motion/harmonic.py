"""The ideal cam on a platform at rest: harmonic motion in closed form.

A wheel released at rest at ϑ = A moves as s = s(A) cos ωt along the arc s = ∫√M dϑ, with M the
moment of inertia and ω² = F t'(0)/I (A §XV–XIX: isochronous with a simple pendulum of length
I g/(P r)). Where nothing but the wheel has inertia, s is proportional to ϑ; with the cam corrected
for a weight it is not (theory D).

t · ω/π is reduced to half turns with ω/π in twice the working precision, so that even after a
hundred days the phase is exact to its own rounding.
"""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np

from tauto_core.machines import Machine
from tauto_core.motion.closed_form import ClosedForm
from tauto_core.motion.forcing import Motion
from tauto_core.motion.phase import DIGITS, PI, half_turns, two_floats
from tauto_core.samples import FloatArray, IntArray

NAME = 'harmonic'


def frequency(machine: Machine) -> Decimal:
    """Return ω = √(F t'(0)/I) in `DIGITS` digits; the machine's numbers are exact [rad/s]."""
    with localcontext() as context:
        context.prec = DIGITS
        pull = Decimal(machine.force) + Decimal(machine.pulling_mass) * Decimal(machine.gravity)
        rate = Decimal(float(machine.cam.lever_rate(0.0)))
        return (pull * rate / Decimal(machine.inertia)).sqrt()


def half_turns_per_ns(omega: Decimal) -> tuple[float, float]:
    """Return ω/π per nanosecond as the sum of two floats."""
    with localcontext() as context:
        context.prec = DIGITS
        return two_floats(omega / PI / 10**9)


class Harmonic(ClosedForm):
    """Propagator of an ideal cam on a platform at rest."""

    name = NAME

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._half_turns_per_ns = half_turns_per_ns(frequency(machine))

    def motion_at(self, time_ns: IntArray) -> Motion:
        """Return the motion at times since the release [ns], (n,)."""
        machine = self._machine
        omega = machine.frequency
        half, fraction = half_turns(time_ns, self._half_turns_per_ns)
        turned = np.pi * fraction
        sign = np.where(half % 2, -1.0, 1.0)
        cosine, sine = sign * np.cos(turned), sign * np.sin(turned)
        angle, rate, torque = self._swing(cosine, sine)
        return Motion(
            angle=angle,
            rate=rate,
            torque=torque,
            half_turns=half,
            fraction=fraction,
            phase_rate=np.full(len(time_ns), omega),
            beats=half + (fraction > 0.5),
        )

    def _swing(
        self, cosine: FloatArray, sine: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return ϑ, ϑ̇ and the torque Iϑ̈ where the phase has this cosine and sine.

        From ṡ = √M ϑ̇ and s̈ = −ω²s: ϑ̈ = −(ω²s + m t t' ϑ̇²/√M)/√M.
        """
        machine = self._machine
        omega = machine.frequency
        if machine.is_linear:
            angle = machine.release_angle * cosine
            rate = -machine.release_angle * omega * sine
            return angle, rate, -machine.inertia * omega * omega * angle
        top = float(machine.arc(machine.release_angle))
        angle = machine.angle_of_arc(top * cosine)
        root = np.sqrt(machine.mass(angle))
        rate = -top * omega * sine / root
        arm, slope = machine.cam.lever_arm(angle), machine.cam.lever_rate(angle)
        ride = machine.carried_mass * arm * slope * rate * rate / root
        return angle, rate, -machine.inertia * (omega * omega * top * cosine + ride) / root
