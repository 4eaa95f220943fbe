"""The amplitude of a wheel, from its angle and rate at any instant."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.curves.quadrature import QuadratureError
from tauto_core.machines.compiling import AnyMachine
from tauto_core.machines.hanging_swing import SwingError
from tauto_core.machines.threads.hanging import HangingMachine
from tauto_core.machines.threads.lever import LeverMachine
from tauto_core.machines.trochlea import SlackThreadError
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import CamRangeError

_SAME = 4.0 * np.finfo(float).eps


def swing_energy(machine: AnyMachine, angle: FloatArray, rate: FloatArray) -> FloatArray:
    """Return the energy V(θ) + ½ M θ̇² of a swing as on land [J], (n,).

    For a thread that swings it is the energy of small swings.

    Args:
        machine: the machine.
        angle: θ of the wheel in its case [rad], (n,); an angle beyond the range counts as its end.
        rate: θ̇ [rad/s], (n,).
    """
    if isinstance(machine, HangingMachine):
        small = (machine.frequency * angle) ** 2 + rate * rate
        return np.asarray(0.5 * machine.inertia * small)
    if isinstance(machine, LeverMachine):
        angle = np.clip(angle, *machine.sides)
        return machine.potential(angle) + 0.5 * machine.mass_at(angle) * rate * rate
    angle = np.clip(angle, -machine.range_rad, machine.range_rad)
    return machine.potential(angle) + 0.5 * machine.mass(angle) * rate * rate


def recoil_energy(machine: AnyMachine, angle: FloatArray, rate: FloatArray) -> FloatArray:
    """Return R s θ [J], (n,), the term that recoil adds to the conserved energy (theory E2).

    s, the sign of the last impulse, is that of a swing that reaches both impulses: sgn θ̇ beyond
    the angle of the impulse, −sgn θ̇ before it.

    Args:
        machine: the machine.
        angle: θ of the wheel in its case [rad], (n,).
        rate: θ̇ [rad/s], (n,).
    """
    escapement = machine.escapement
    if escapement is None or escapement.recoil == 0.0:
        return np.zeros_like(angle)
    way = np.where(rate < 0.0, -1.0, 1.0)
    struck = np.where(way * angle > escapement.angle, way, -way)
    return escapement.recoil * struck * angle


def amplitude_of(machine: AnyMachine, energy: float) -> float:
    """Return the amplitude A on land [rad] of a swing of the energy V(A) + R A [J].

    For the lever it is the turning point on the positive side. It is at most the end of the range.

    Args:
        machine: the machine.
        energy: sum of `swing_energy` and `recoil_energy`; a negative one counts as 0.
    """
    energy = max(energy, 0.0)
    free = _free_amplitude(machine, energy)
    recoil = 0.0 if machine.escapement is None else machine.escapement.recoil

    def above(amplitude: float) -> float:
        at_rest = swing_energy(machine, np.array([amplitude]), np.zeros(1))
        return float(at_rest[0]) + recoil * amplitude - energy

    if recoil == 0.0 or above(free) <= 0.0:
        return free
    from scipy.optimize import brentq  # slow to import

    return float(brentq(above, 0.0, free, xtol=_SAME * free, rtol=_SAME))


def nearest_period(machine: AnyMachine, amplitude: float) -> float:
    """Return the period on land of free swings of an amplitude [s], or of a smaller one.

    Where no such swing exists, as with an amplitude that only the sea makes possible, it is that
    of half the amplitude, and so on. Half the amplitude has at least half the period: a period
    grows at most in proportion to the amplitude, where the weight alone has inertia.

    Args:
        machine: the machine.
        amplitude: as `amplitude_of` returns [rad].
    """
    while amplitude > 0.0:
        try:
            return machine.period(amplitude)
        except (CamRangeError, SlackThreadError, SwingError, QuadratureError):
            amplitude *= 0.5
    return machine.small_period


def _free_amplitude(machine: AnyMachine, energy: float) -> float:
    if isinstance(machine, HangingMachine):
        return math.sqrt(2.0 * energy / machine.inertia) / machine.frequency
    return machine.angle_of_potential(energy)
