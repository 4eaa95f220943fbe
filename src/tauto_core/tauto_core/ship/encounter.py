"""Waves as a ship under way meets them (theory E5)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.ship.waves import Harmonics

STANDING = 1e-12
"""Least encounter frequency [rad/s]; slower waves move with the ship and seem to stand still."""


@dataclass(frozen=True)
class Course:
    """Speed and heading of a ship in a long-crested sea.

    Attributes:
        speed: V [m/s], >= 0.
        heading: mu, direction in which the waves run, from the bow to port [rad]: 0 following
            seas, pi/2 beam seas, pi head seas.
        gravity: g [m/s2].
    """

    speed: float
    heading: float
    gravity: float

    def frequency(self, omega: FloatArray) -> FloatArray:
        """Return the encounter frequency omega - omega^2 V cos(mu)/g [rad/s].

        It is negative where the ship overtakes the waves.

        Args:
            omega: angular frequencies of the waves in deep water [rad/s], > 0, any shape.
        """
        if self.speed == 0.0:
            return omega
        met: FloatArray = omega - omega**2 * (self.speed * math.cos(self.heading) / self.gravity)
        return met

    def answer(self, waves: Harmonics, amplitude: FloatArray, lead: FloatArray) -> Harmonics:
        """Return the response sum amplitude_i cos(omega_e,i t + eps_i + lead_i).

        Args:
            waves: the waves, with omega and eps.
            amplitude: amplitudes of the response, shape (n,).
            lead: phase of the response ahead of the waves [rad], shape (n,).
        """
        phase = waves.phase + lead
        if self.speed == 0.0:
            return Harmonics(amplitude, waves.period, phase)
        met = self.frequency(waves.angular_frequency)
        period = 2.0 * np.pi / np.maximum(np.abs(met), STANDING)
        return Harmonics(amplitude, period, np.where(met < 0.0, -phase, phase))

    def met(self, waves: Harmonics) -> Harmonics:
        """Return the elevation at the ship."""
        return self.answer(waves, waves.amplitude, np.zeros_like(waves.phase))
