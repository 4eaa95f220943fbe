"""The motion of the ship on a part of a voyage, for pictures: roll, and heave in metres."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tauto_core.record import Voyage
from tauto_core.samples import SHIP_IMU, FloatArray, ImuSamples, take
from tauto_core.ship import ShipMotion
from tauto_core.ship.imu import attitude

PART_S = 600.0
"""Length of a part [s]; in a picture of weeks no wave could be seen."""
LOWEST_HZ = 0.03
"""Lowest frequency [Hz]; below it an accelerometer shows its own drift rather than waves."""
TAPER_S = 30.0
"""At both ends of a record the heave is tapered over this time [s]."""


@dataclass(frozen=True)
class Seaway:
    """The motion on a part of a voyage.

    Attributes:
        time_s: time from the first reading, (n,) [s].
        roll_rad: (n,), starboard side down is positive.
        vertical_m_s2: acceleration of the clock upwards, less its mean, (n,).
        note: further information for the reader; may be empty.
    """

    time_s: FloatArray
    roll_rad: FloatArray
    vertical_m_s2: FloatArray
    note: str = ''

    @cached_property
    def heave_m(self) -> FloatArray:
        """Height of the clock above its mean [m], (n,).

        The acceleration integrated twice: −a/ω² for every frequency from `LOWEST_HZ` up.
        """
        count = len(self.time_s)
        if count < 4:
            return np.zeros(count)
        step_s = float(self.time_s[-1] - self.time_s[0]) / (count - 1)
        frequency = np.fft.rfftfreq(count, step_s)
        ends = np.minimum(np.arange(count), np.arange(count)[::-1]) * step_s
        fade = np.sin(0.5 * np.pi * np.minimum(ends / TAPER_S, 1.0)) ** 2
        spectrum = np.fft.rfft(self.vertical_m_s2 * fade)
        kept = frequency >= LOWEST_HZ
        spectrum[~kept] = 0.0
        spectrum[kept] /= -np.square(2.0 * np.pi * frequency[kept])
        heave: FloatArray = np.fft.irfft(spectrum, count)
        return heave


def seaway(voyage: Voyage, from_s: float = 0.0, length_s: float = PART_S) -> Seaway:
    """Return the motion from a time on, computed from the scene if the voyage does not log it.

    Args:
        voyage: the voyage whose ship is shown.
        from_s: beginning, since the first reading [s], >= 0.
        length_s: length [s], > 0; less at the end of the voyage.
    """
    if SHIP_IMU in voyage.samples:
        imu = voyage.samples[SHIP_IMU]
        assert isinstance(imu, ImuSamples)
        shown = slice(*np.searchsorted(voyage.motion_time_s, (from_s, from_s + length_s)))
        return _felt(take(imu, shown), voyage.motion_time_s[shown], '')
    ship, step_s = ShipMotion(voyage.scene), voyage.scene.step_ns * 1e-9
    first = min(round(from_s / step_s), max(ship.total - 1, 0))
    ship.restore({'next': first})
    made = ship.produce(max(round(length_s / step_s), 1))
    time_s = np.arange(first, first + len(made.stamp_ns), dtype=np.float64) * step_s
    return _felt(made, time_s, 'made anew from the scene')


def _felt(imu: ImuSamples, time_s: FloatArray, note: str) -> Seaway:
    found = attitude(imu)
    upwards = found.force_y * np.sin(found.roll) + found.force_z * np.cos(found.roll)
    return Seaway(time_s, found.roll, upwards - (upwards.mean() if len(upwards) else 0.0), note)
