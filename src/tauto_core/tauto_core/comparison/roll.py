"""The amplitude of a ship's roll, and the same ship in the same waves with another roll."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.scene import Scene
from tauto_core.scene.errors import UsageError
from tauto_core.ship.waves import Harmonics

LARGEST_DEG = 45.0
"""Largest roll that can be asked for; beyond it the linear roll equation does not hold."""


def significant_roll_deg(scene: Scene) -> float | None:
    """Return the significant amplitude of a ship's roll, 2 √(Σ a²/2) [deg].

    It is twice the root mean square, which in a narrow-banded sea is the mean of the highest third
    of the amplitudes (Longuet-Higgins 1952); for a single harmonic of amplitude a it is √2 a. None
    where the roll was measured, 0 for a ship that lies still; in weather it is that in the highest
    sea.
    """
    if not scene.ship.is_computed:
        return None
    roll = scene.ship.roughest(scene).channels(scene).roll
    return _significant_deg(roll.amplitude) if isinstance(roll, Harmonics) else 0.0


def with_roll(scene: Scene, roll_deg: float) -> Scene:
    """Return the scene with a ship that rolls by another significant amplitude.

    Every harmonic of the roll is scaled by the same factor, in a sea through the slope coefficient
    or the response operator; waves and heave are not changed.

    Args:
        scene: its ship must be of kind sea or components, and must roll.
        roll_deg: significant amplitude [deg], 0 to LARGEST_DEG.

    Raises:
        UsageError: an amplitude out of range, or a ship whose roll cannot be scaled.
    """
    if not 0.0 <= roll_deg <= LARGEST_DEG:
        raise UsageError(
            f'--roll {roll_deg:g}: must lie between 0 and {LARGEST_DEG:g} degrees, twice the '
            'root mean square of the roll. Write for example 0,10,20'
        )
    ship, now = scene.ship, significant_roll_deg(scene)
    if not now:
        why = 'was measured' if now is None else 'is zero'
        raise UsageError(
            f'--roll {roll_deg:g}: the roll of {scene.name} (ship.kind {ship.kind}) {why} and '
            'cannot be scaled. Use a ship of kind sea or components that rolls, or leave out '
            '--roll'
        )
    return scene.model_copy(update={'ship': ship.with_roll_scaled(roll_deg / now)})


def _significant_deg(amplitudes: FloatArray) -> float:
    return math.degrees(2.0 * math.sqrt(0.5 * float(np.sum(amplitudes**2))))
