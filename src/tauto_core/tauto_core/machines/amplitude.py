"""How far a wheel swings, from its angle and rate at any instant."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.machines.compiling import AnyMachine
from tauto_core.machines.threads.hanging import HangingMachine
from tauto_core.machines.threads.lever import LeverMachine
from tauto_core.samples import FloatArray

_SAME = 4.0 * np.finfo(float).eps


def swing_energy(machine: AnyMachine, angle: FloatArray, rate: FloatArray) -> FloatArray:
    """Return V(θ) + ½ M θ̇² as on land [J], (n,); of a thread that swings as in small swings.

    Args:
        machine: what swings.
        angle: θ of the wheel in its case [rad], (n,); beyond its range the end of it counts.
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
    """Return R s θ [J], (n,), what recoil adds to the energy that a swing keeps (theory E2).

    s is that of a swing that comes to both impulses: sgn θ̇ beyond the angle of the impulse, −sgn θ̇
    before it.

    Args:
        machine: what swings.
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
    """Return the amplitude A on land [rad] of a swing of an energy V(A) + R A [J].

    Of the lever that on the positive side; at most the end of the range.

    Args:
        machine: what swings.
        energy: as `swing_energy` and `recoil_energy` add up to; below 0 as 0.
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


def _free_amplitude(machine: AnyMachine, energy: float) -> float:
    if isinstance(machine, HangingMachine):
        return math.sqrt(2.0 * energy / machine.inertia) / machine.frequency
    return machine.angle_of_potential(energy)
