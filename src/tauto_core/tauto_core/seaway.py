"""The motion of the ship on a part of a voyage, for pictures: roll, and heave in metres."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tauto_core.record import Voyage
from tauto_core.samples import NS_PER_S, SECONDS_PER_DAY, SHIP_IMU, FloatArray, ImuSamples, take
from tauto_core.scene import Scene
from tauto_core.scene.errors import UsageError
from tauto_core.ship import ShipMotion
from tauto_core.ship.imu import attitude
from tauto_core.ship.motions.sea import SeaShip
from tauto_core.ship.weather_kind import State

PART_S = 600.0
"""Length of a part [s]; in a picture of weeks no wave could be seen."""
MOST_SAMPLES = 1_000_000
"""Largest number of samples of the motion in a picture: 28 hours at 10 Hz, some 0.3 GB."""
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
        plumb_rad: apparent vertical from the true one, (n,), as the roll of a ship whose mast
            points along it.
        note: further information for the reader; may be empty.
    """

    time_s: FloatArray
    roll_rad: FloatArray
    vertical_m_s2: FloatArray
    plumb_rad: FloatArray
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


@dataclass(frozen=True)
class Window:
    """A part of a voyage.

    Attributes:
        from_s: beginning, from the first reading [s].
        to_s: end [s].
        note: why this part is shown; empty for the whole voyage or one that was asked for.
    """

    from_s: float
    to_s: float
    note: str = ''


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


def window(voyage: Voyage, from_s: float | None, to_s: float | None) -> Window:
    """Return the part of a voyage that is shown: the one asked for, or else the roughest.

    Args:
        voyage: the voyage.
        from_s: beginning, from the first reading [s]; when left out, `PART_S` before the end.
        to_s: end [s]; when left out, `PART_S` after the beginning.

    Raises:
        UsageError: a part that does not lie in the voyage, or is too long to be drawn.
    """
    end_s = float(voyage.time_s[-1])
    if from_s is None and to_s is None:
        return _roughest(voyage, end_s)
    if from_s is None:
        assert to_s is not None
        from_s = max(to_s - PART_S, 0.0)
    if to_s is None:
        to_s = min(from_s + PART_S, end_s)
    if not 0.0 <= from_s < to_s <= end_s:
        raise UsageError(
            f'from {from_s:.9g} to {to_s:.9g} s: is not a part of the voyage, which lasts '
            f'{end_s:.9g} s ({end_s / SECONDS_PER_DAY:.6g} days). Give a beginning and a later '
            'end within it'
        )
    most_s = MOST_SAMPLES * voyage.scene.step_ns * 1e-9
    if to_s - from_s > most_s:
        raise UsageError(
            f'from {from_s:.9g} to {to_s:.9g} s: has more than {MOST_SAMPLES} samples of the '
            f'motion. Show at most {most_s:.6g} s ({most_s / SECONDS_PER_DAY:.4g} days)'
        )
    return Window(from_s, to_s)


def _roughest(voyage: Voyage, end_s: float) -> Window:
    """Return the ten minutes with the greatest motion where it is logged, else of highest sea.

    The motion is measured as the mean square of the roll and of the vertical acceleration over g:
    the tilt and the share by which the apparent gravity changes.
    """
    if end_s <= PART_S:
        return Window(0.0, end_s)
    if SHIP_IMU in voyage.samples:
        moved = seaway(voyage, 0.0, end_s + 1.0)
        size = np.square(moved.roll_rad) + np.square(moved.vertical_m_s2 / voyage.scene.gravity)
        sums = np.concatenate(([0.0], np.cumsum(size)))
        last = np.searchsorted(moved.time_s, moved.time_s + PART_S, side='right')
        whole = moved.time_s + PART_S <= moved.time_s[-1]
        mean = (sums[last] - sums[:-1]) / (last - np.arange(len(size)))
        from_s = float(moved.time_s[np.argmax(np.where(whole, mean, -1.0))])
        return Window(from_s, from_s + PART_S, 'the roughest ten minutes')
    met = weather(voyage.scene)
    if not met:
        return Window(0.0, PART_S, 'the first ten minutes')
    highest = max(
        met[:1] + tuple(each for each in met if each.at_ns <= end_s * NS_PER_S),
        key=lambda state: state.height,
    )
    from_s = min(max(highest.at_ns / NS_PER_S - 0.5 * PART_S, 0.0), end_s - PART_S)
    return Window(from_s, from_s + PART_S, 'the ten minutes about the highest sea')


def weather(scene: Scene) -> tuple[State, ...]:
    """Return the states of the sea that a ship meets within a scene; none without a weather.

    The first is the one in force at the start, the last may be one that comes after the end.
    """
    ship = scene.ship
    if not isinstance(ship, SeaShip) or ship.weather is None:
        return ()
    states = ship.states(scene)
    begun = sum(state.at_ns <= 0 for state in states)
    ended = sum(state.at_ns < scene.duration_ns for state in states)
    return states[max(begun - 1, 0) : ended + 1]


def _felt(imu: ImuSamples, time_s: FloatArray, note: str) -> Seaway:
    found = attitude(imu)
    upwards = found.force_y * np.sin(found.roll) + found.force_z * np.cos(found.roll)
    return Seaway(
        time_s,
        found.roll,
        upwards - (upwards.mean() if len(upwards) else 0.0),
        found.roll - np.arctan2(found.force_y, found.force_z),
        note,
    )
