"""How far a wheel swings, from its angle and rate at any instant."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.machines.compiling import AnyMachine
from tauto_core.machines.hanging import HangingMachine
from tauto_core.machines.lever import LeverMachine
from tauto_core.samples import FloatArray


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


def amplitude_of(machine: AnyMachine, energy: float) -> float:
    """Return the amplitude on land [rad] of a swing of an energy [J], as `swing_energy` has it.

    Of the lever that on the positive side; at most the end of the range.
    """
    if isinstance(machine, HangingMachine):
        return math.sqrt(2.0 * energy / machine.inertia) / machine.frequency
    return machine.angle_of_potential(energy)
