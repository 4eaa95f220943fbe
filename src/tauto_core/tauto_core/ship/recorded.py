"""Measured motion: read, checked, and resampled within a pass-band.

The record is mapped to a uniform grid of its median step by a cubic spline, continued evenly
(mirrored) at both ends, and transformed by a DCT-I. Of its harmonics, with frequencies n/(2
length), those with low <= f <= high are kept and the others dropped. The result is a sum of
cosines, so its derivatives are exact. Mirroring makes its rate zero at both ends of the record, an
effect that lasts for about 1/high.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import Field

from tauto_core.samples import NS_PER_S, FloatArray
from tauto_core.scene.data import data_path
from tauto_core.scene.errors import MotionDataError
from tauto_core.scene.fields import NonNegative, Number, Positive, Section, Text
from tauto_core.scene.times import whole_intervals
from tauto_core.ship.cubic import spline
from tauto_core.ship.imu import REFUSALS, attitude, refusal_reasons
from tauto_core.ship.imu_bag import read_imu
from tauto_core.ship.motion_csv import read_columns
from tauto_core.ship.motion_kind import Surroundings
from tauto_core.ship.waves import Harmonics

FEWEST_SAMPLES = 4
MOST_STEPS = 50_000_000
LARGEST: dict[str, tuple[float, str, str]] = {
    'roll': (math.pi / 2.0, 'rad', 'the ship would capsize'),
    'heave': (1000.0, 'm', 'no sea lifts a ship so far'),
}
"""Largest size of a channel of a CSV with its unit, and the reason for the limit."""


class Recorded(Section):
    """Measured motion, from the named columns of a CSV file or a sensor_msgs/Imu topic of a bag.

    The name of a column ends in its unit: _s, _deg or _rad, _m. Roll is positive with the
    starboard side down, heave upwards; a negative `scale` reverses both.
    """

    path: Text = Field(description='CSV file, .mcap file or rosbag2 folder')
    time_column: Text | None = Field(default=None, description='CSV column of the time, …_s')
    roll_column: Text | None = Field(default=None, description='CSV column of the roll, …_deg')
    heave_column: Text | None = Field(default=None, description='CSV column of the heave, …_m')
    topic: Text | None = Field(default=None, description='topic of sensor_msgs/Imu in a bag')
    scale: Number = Field(default=1.0, description='factor on the motion, not 0')
    passband: tuple[NonNegative, Positive] = Field(
        default=(0.02, 0.4), description='[lowest, highest] frequency kept [Hz]'
    )
    max_gap: Positive = Field(
        default=3.0, description='longest gap between samples that is interpolated [s]'
    )


@dataclass(frozen=True)
class Record:
    """A measured motion as read; arrays of shape (n,).

    Attributes:
        name: name of the file, for messages.
        time_s: time from the first sample [s], strictly increasing.
        where: for each sample, its line or message number, for messages.
        channels: `roll` [rad]; `heave` [m] or `force_y`, `force_z` [m/s2] where measured.
        warnings: anything unusual about the file.
    """

    name: str
    time_s: FloatArray
    where: list[str]
    channels: dict[str, FloatArray]
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class RecordedMotion:
    """Measured motion within the pass-band; t = 0 at the record's first sample.

    Attributes:
        roll: [rad], starboard down positive.
        heave: upwards [m]; None where not measured.
        force_y: measured specific force along the ship's y [m/s2]; None for a CSV.
        force_z: measured specific force along the ship's z [m/s2]; None for a CSV.
        length_s: length of the record.
        gaps: number of gaps bridged by interpolation.
        warnings: anything unusual about the file.
    """

    roll: Harmonics
    heave: Harmonics | None
    force_y: Harmonics | None
    force_z: Harmonics | None
    length_s: float
    gaps: int
    warnings: tuple[str, ...]


def recorded_motion(scene: Surroundings, recorded: Recorded) -> RecordedMotion:
    """Read a measured motion and resample it within its pass-band.

    For a CSV file the means are dropped unless the pass-band includes 0 Hz. For a bag the means of
    roll and specific force are kept, so that the apparent vertical stays where it was measured;
    the specific force is used as it is, without adding `ship.height` or gravity.

    Raises:
        MotionDataError: the file cannot be read or used, or is shorter than the scene.
    """
    record = read_bag_record(recorded) if recorded.topic is not None else read_csv_record(recorded)
    try:
        gaps = _check_times(record, recorded)
        _check_sizes(record)
        _check_length(record, scene)
    except MotionDataError as error:
        # a truncated file may be the reason
        for warning in record.warnings:
            error.add_note(warning)
        raise
    length = float(record.time_s[-1])
    keep_mean = recorded.topic is not None or recorded.passband[0] == 0.0
    harmonics = {
        name: band_limited(record.time_s, values, recorded.passband, keep_mean=keep_mean)
        for name, values in record.channels.items()
    }
    return RecordedMotion(
        harmonics['roll'],
        harmonics.get('heave'),
        harmonics.get('force_y'),
        harmonics.get('force_z'),
        length,
        gaps,
        record.warnings,
    )


def band_limited(
    time_s: FloatArray, values: FloatArray, passband: tuple[float, float], *, keep_mean: bool
) -> Harmonics:
    """Return the part of a record within a pass-band, as described at the top of this module.

    Args:
        time_s: from 0 [s], strictly increasing, shape (n,), n >= 4.
        values: shape (n,).
        passband: lowest and highest frequency kept [Hz], the highest below half the sampling rate.
        keep_mean: whether the mean over the record is kept.
    """
    length = float(time_s[-1])
    steps = round(length / float(np.median(np.diff(time_s))))
    instants = np.asarray(length / steps * np.arange(steps + 1), np.float64)
    uniform = spline(time_s, values, instants)
    mirrored = np.concatenate([uniform, uniform[-2:0:-1]])
    coefficients = np.fft.rfft(mirrored).real / steps
    n = np.arange(1, steps)
    frequency = n / (2.0 * length)
    inside = n[(passband[0] <= frequency) & (frequency <= passband[1])]
    return Harmonics(
        coefficients[inside],
        2.0 * length / inside,
        np.zeros(len(inside)),
        0.5 * float(coefficients[0]) if keep_mean else 0.0,
    )


def read_csv_record(recorded: Recorded) -> Record:
    """Read time, roll and, where named, heave from a CSV; units from the columns' suffixes."""
    columns = {'time': recorded.time_column, 'roll': recorded.roll_column}
    if recorded.heave_column is not None:
        columns['heave'] = recorded.heave_column
    wanted = {quantity: column or '' for quantity, column in columns.items()}
    lines, values = read_columns(data_path(recorded.path), recorded.path, wanted)
    time = values.pop('time')
    channels = {name: recorded.scale * value for name, value in values.items()}
    return Record(recorded.path, time - time[:1], [f'line {line}' for line in lines], channels, ())


def read_bag_record(recorded: Recorded) -> Record:
    """Read roll and specific force from the Imu messages of an MCAP file or rosbag2 folder."""
    imu, warnings = read_imu(data_path(recorded.path), recorded.path, recorded.topic or '')
    reasons = refusal_reasons(imu, None)
    wrong = np.flatnonzero(reasons)
    if wrong.size:
        at = int(wrong[0])
        raise MotionDataError(
            f'{recorded.path}: Imu message {at + 1} on {recorded.topic} (stamp '
            f'{int(imu.stamp_ns[at])} ns, orientation {imu.orientation[at].tolist()}) is refused: '
            f'{REFUSALS[reasons[at] - 1]}; {wrong.size} of {len(reasons)} messages are. '
            'Every message needs a later stamp than the one before, finite vectors, a unit '
            'quaternion and no covariance that starts with -1.'
        )
    felt = attitude(imu)
    channels = {
        'roll': np.unwrap(felt.roll),
        'force_y': felt.force_y,
        'force_z': felt.force_z,
    }
    time_s = (imu.stamp_ns - imu.stamp_ns[0]) / NS_PER_S
    where = [f'message {i}' for i in range(1, len(time_s) + 1)]
    return Record(recorded.path, time_s, where, channels, warnings)


def recorded_metadata(recorded: Recorded, motion: RecordedMotion) -> dict[str, Any]:
    """Return how a record was used, for reports."""
    return {
        'path': recorded.path,
        'passband_hz': list(recorded.passband),
        'components': len(motion.roll.amplitude),
        'record_s': motion.length_s,
        'gaps_interpolated': motion.gaps,
        'scale': recorded.scale,
    }


def _check_times(record: Record, recorded: Recorded) -> int:
    """Refuse times and lengths that cannot be resampled; return the number of gaps bridged."""
    name, time_s = record.name, record.time_s
    if len(time_s) < FEWEST_SAMPLES:
        raise MotionDataError(
            f'{name}: holds {len(time_s)} samples; at least {FEWEST_SAMPLES} are needed. '
            'Give a longer record.'
        )
    step = np.diff(time_s)
    backward = np.flatnonzero(step <= 0.0)
    if backward.size:
        at = int(backward[0]) + 1
        what = 'repeats' if step[at - 1] == 0.0 else 'goes back from'
        raise MotionDataError(
            f'{name}, {record.where[at]}: time {time_s[at]:.9g} s after the first sample {what} '
            f'the time before, {time_s[at - 1]:.9g} s; times must increase. '
            'Sort the record and drop what is double.'
        )
    wide = np.flatnonzero(step > recorded.max_gap)
    if wide.size:
        at = int(wide[0]) + 1
        raise MotionDataError(
            f'{name}, {record.where[at]}: gap of {step[at - 1]:.9g} s before it, longer than '
            f'max_gap = {recorded.max_gap!r} s. Cut the record there, or raise max_gap.'
        )
    median = float(np.median(step))
    low, high = recorded.passband
    if high >= 0.5 / median:
        raise MotionDataError(
            f'{name}: sampled every {median:.6g} s, it holds nothing above {0.5 / median:.6g} Hz, '
            f'but passband reaches {high!r} Hz. Lower its upper edge.'
        )
    length = float(time_s[-1])
    if length > MOST_STEPS * median:
        raise MotionDataError(
            f'{name}, {record.where[-1]}: the record lasts {length:.6g} s, more than {MOST_STEPS} '
            f'of its median steps of {median:.6g} s. Cut it where it breaks off.'
        )
    needed = max(1.0 / (high - low), 1.0 / low if low else 0.0)
    if length < needed:
        raise MotionDataError(
            f'{name}: lasts {length:.6g} s; the passband {[low, high]} Hz needs at least '
            f'{needed:.6g} s, one period of its lower edge and of its width. '
            'Give a longer record, or another passband.'
        )
    return int(np.count_nonzero(step > 1.5 * median))


def _check_length(record: Record, scene: Surroundings) -> None:
    """Refuse a record that ends before the scene."""
    length = float(record.time_s[-1])
    if scene.duration_ns > round(length * NS_PER_S):
        longest_ns = whole_intervals(round(length * NS_PER_S), scene.log_interval_ns)
        raise MotionDataError(
            f'{record.name}: the scene lasts {scene.duration!r} s, the record only '
            f'{length:.6g} s. Set duration to at most {longest_ns / NS_PER_S:.15g}.'
        )


def _check_sizes(record: Record) -> None:
    """Refuse motion larger than any ship makes; the numbers are probably in another unit."""
    for quantity, (limit, unit, reason) in LARGEST.items():
        values = record.channels.get(quantity)
        # the roll of a bag is an unwrapped angle of any size
        if values is None or 'force_y' in record.channels:
            continue
        wrong = np.flatnonzero(np.abs(values) >= limit)
        if wrong.size:
            at = int(wrong[0])
            raise MotionDataError(
                f'{record.name}, {record.where[at]}: {quantity} = {values[at]:.6g} {unit} with '
                f'its scale must stay within ±{limit:.6g} {unit}: {reason}. Correct the row, the '
                "column's unit or scale."
            )
