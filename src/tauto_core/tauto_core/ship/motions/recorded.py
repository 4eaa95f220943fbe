"""Measured motion: from CSV or a bag, checked, and resampled within a pass-band.

A cubic spline maps the record to a uniform grid of its median step. The record is continued evenly
(mirrored) at both ends and transformed by a DCT-I. Harmonics of the frequencies n/(2 length) with
low <= f <= high are kept. The result is a sum of cosines, so its derivatives are exact. Mirroring
makes its rate zero at both ends, an effect that lasts for about 1/high.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from tauto_core.curves.numerics import spline
from tauto_core.samples import FloatArray, ImuSamples
from tauto_core.scene.errors import (
    ABSENT,
    BagError,
    MotionDataError,
    Problem,
    SceneError,
    problems_where,
)
from tauto_core.scene.sections import NonNegative, Number, OneLine, Positive, Section
from tauto_core.scene.tables import (
    ANGLE_UNITS,
    LENGTH_UNITS,
    TIME_UNITS,
    Column,
    Columns,
    data_path,
    read_table,
    unit_factor,
)
from tauto_core.scene.times import NS_PER_S, whole_intervals
from tauto_core.ship.imu import REFUSALS, attitude, refusal_reasons
from tauto_core.ship.motions import Channels, ShipKind, Surroundings
from tauto_core.ship.waves import Harmonics

# -----------------------------------------------------------------------------
# Imu messages from an MCAP file or rosbag2 folder, as far as it can be read.

IMU_TYPE = 'sensor_msgs/msg/Imu'


def read_imu(path: Path, name: str, topic: str) -> tuple[ImuSamples, tuple[str, ...]]:
    """Return the Imu messages on a topic in the order stored, by header stamps, and warnings.

    The path is an MCAP file, or a folder of such in the order of their numbers. A truncated or
    damaged file is read as far as possible, with a warning.

    Raises:
        MotionDataError: not MCAP, or a topic that is missing, empty or not of Imu messages.
    """
    from tauto_core.bags.read import read_bag  # slow to import

    wanted = topic.lstrip('/')
    try:
        bag = read_bag(path)
        full = {topic.lstrip('/'): topic for topic in bag.topics}.get(wanted)
        if full is None:
            listed = ', '.join(f'{topic}: {kind}' for topic, kind in sorted(bag.topics.items()))
            raise MotionDataError(
                f'{name}: has no topic {topic!r}; it has {listed or "none"}. Name one with Imu '
                'messages.'
            )
        bag.check_type(full, IMU_TYPE)
        imu = bag.samples(full)
    except BagError as error:
        raise MotionDataError(f'{name}: {error}') from error
    if not isinstance(imu, ImuSamples) or not len(imu.stamp_ns):
        raise MotionDataError(
            f'{name}: topic {topic!r} has no messages. Name a topic with Imu messages.'
        )
    note = f'the {len(imu.stamp_ns)} Imu messages that can be read are used'
    return imu, tuple(f'{warning}; {note}' for warning in bag.warnings)


# -----------------------------------------------------------------------------
# The motion of a record: its time, roll and heave or specific force, and the part that is kept.

_CSV_FORM = 'Give a CSV file with a header line, or topic for a bag.'
_UNITS = {'time': TIME_UNITS, 'roll': ANGLE_UNITS, 'heave': LENGTH_UNITS}
FEWEST_SAMPLES = 4
MOST_STEPS = 50_000_000
LARGEST_MOTION: dict[str, tuple[float, str, str]] = {
    'roll': (math.pi / 2.0, 'rad', 'the ship would capsize'),
    'heave': (1000.0, 'm', 'no sea lifts a ship so far'),
}
"""Largest size of a channel of a CSV with its unit, and the reason for the limit."""


class Recorded(Section):
    """Measured motion, from the named columns of a CSV file or a sensor_msgs/Imu topic of a bag.

    The name of a column ends in its unit: _s, _deg or _rad, _m. Roll is positive starboard down,
    heave upwards. A negative `scale` reverses both.
    """

    path: OneLine = Field(description='CSV file, .mcap file or rosbag2 folder')
    time_column: OneLine | None = Field(default=None, description='CSV column of the time, …_s')
    roll_column: OneLine | None = Field(default=None, description='CSV column of the roll, …_deg')
    heave_column: OneLine | None = Field(default=None, description='CSV column of the heave, …_m')
    topic: OneLine | None = Field(default=None, description='topic of sensor_msgs/Imu in a bag')
    scale: Number = Field(default=1.0, description='factor on the motion, not 0')
    passband: tuple[NonNegative, Positive] = Field(
        default=(0.02, 0.4), description='[lowest, highest] frequency kept [Hz]'
    )
    max_gap: Positive = Field(
        default=3.0, description='longest gap between samples that is interpolated [s]'
    )


def recorded_motion(scene: Surroundings, recorded: Recorded) -> Channels:
    """Read a measured motion and resample it within its pass-band, with t = 0 at the first sample.

    From a CSV file the means are dropped unless the pass-band includes 0 Hz. From a bag the means
    of roll and specific force are kept, to preserve the apparent vertical, and the specific force
    is used without adding `ship.height` or gravity.

    Raises:
        MotionDataError: the file cannot be read or used, or is shorter than the scene.
    """
    in_bag = recorded.topic is not None
    record, warnings = _read_bag(recorded) if in_bag else (_read_csv(recorded), ())
    gaps = _check_times(record, recorded)
    for quantity, (limit, unit, reason) in LARGEST_MOTION.items():
        # a bag's roll is an unwrapped angle of any size
        values = np.empty(0) if in_bag else record.values.get(quantity, np.empty(0))
        wrong = np.flatnonzero(np.abs(values) >= limit)
        if wrong.size:
            at = int(wrong[0])
            raise MotionDataError(
                f'{record.name}, {record.where(at)}: {quantity} = {values[at]:.6g} {unit} '
                f'with its scale must stay within ±{limit:.6g} {unit}: {reason}. Correct the '
                "row, the column's unit or scale."
            )
    length_s = float(record['time'][-1])
    if scene.duration_ns > round(length_s * NS_PER_S):
        longest_ns = whole_intervals(round(length_s * NS_PER_S), scene.log_interval_ns)
        raise MotionDataError(
            f'{record.name}: the scene lasts {scene.duration!r} s, the record only '
            f'{length_s:.6g} s. Set duration to at most {longest_ns / NS_PER_S:.15g}.'
        )
    time_s = record['time']
    keep_mean = in_bag or recorded.passband[0] == 0.0
    harmonics = {
        name: band_limited(time_s, values, recorded.passband, keep_mean=keep_mean)
        for name, values in record.values.items()
        if name != 'time'
    }
    metadata = {
        'path': recorded.path,
        'passband_hz': list(recorded.passband),
        'components': len(harmonics['roll'].amplitude),
        'record_s': length_s,
        'gaps_interpolated': gaps,
        'scale': recorded.scale,
    }
    return Channels(
        harmonics['roll'],
        harmonics.get('heave'),
        harmonics.get('force_y'),
        harmonics.get('force_z'),
        metadata,
        warnings,
    )


def band_limited(
    time_s: FloatArray, values: FloatArray, passband: tuple[float, float], *, keep_mean: bool
) -> Harmonics:
    """Return the part of a record within a pass-band (see the module).

    Times are from 0 [s], strictly increasing, at least 4. The pass-band [Hz] ends below half the
    sampling rate.
    """
    length = float(time_s[-1])
    steps = round(length / float(np.median(np.diff(time_s))))
    instants = np.asarray(length / steps * np.arange(steps + 1), np.float64)
    uniform = spline(time_s, values, instants)
    mirrored = np.concatenate([uniform, uniform[-2:0:-1]])
    coefficients = np.fft.rfft(mirrored).real / steps
    n = np.arange(1, steps)
    frequency = n / (2.0 * length)
    numbers = n[(passband[0] <= frequency) & (frequency <= passband[1])]
    return Harmonics(
        coefficients[numbers],
        2.0 * length / numbers,
        np.zeros(len(numbers)),
        0.5 * float(coefficients[0]) if keep_mean else 0.0,
    )


def _read_csv(recorded: Recorded) -> Columns:
    """Return time, roll and optionally heave from a CSV, in units from the columns' suffixes."""
    named = {'time': recorded.time_column or '', 'roll': recorded.roll_column or ''}
    if recorded.heave_column is not None:
        named['heave'] = recorded.heave_column
    remedy = 'Correct or drop the row. Gaps up to max_gap are interpolated.'
    try:
        columns = {
            quantity: Column(
                name,
                factor=unit_factor(recorded.path, f'{quantity}_column', name, _UNITS[quantity]),
                remedy=remedy,
            )
            for quantity, name in named.items()
        }
        table = read_table(recorded.path, tuple(columns.values()), remedy=_CSV_FORM)
    except SceneError as error:
        raise MotionDataError(str(error)) from error
    values = {quantity: recorded.scale * table[name] for quantity, name in named.items()}
    time = table[named['time']]
    return Columns(recorded.path, {**values, 'time': time - time[0]}, table.places)


def _read_bag(recorded: Recorded) -> tuple[Columns, tuple[str, ...]]:
    """Return time, roll and specific force from the Imu messages of a bag, and warnings."""
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
    pose = attitude(imu)
    values = {
        'time': (imu.stamp_ns - imu.stamp_ns[0]) / NS_PER_S,
        'roll': np.unwrap(pose.roll),
        'force_y': pose.force_y,
        'force_z': pose.force_z,
    }
    places = np.arange(1, len(reasons) + 1)
    return Columns(recorded.path, values, places, 'message'), warnings


def _check_times(record: Columns, recorded: Recorded) -> int:
    """Refuse times that cannot be resampled. Return the number of gaps bridged."""
    name, time_s = record.name, record['time']
    if len(time_s) < FEWEST_SAMPLES:
        raise MotionDataError(
            f'{name}: has {len(time_s)} samples, fewer than the {FEWEST_SAMPLES} needed. '
            'Use a longer record.'
        )
    step = np.diff(time_s)
    backward = np.flatnonzero(step <= 0.0)
    if backward.size:
        at = int(backward[0]) + 1
        what = 'repeats' if step[at - 1] == 0.0 else 'goes back from'
        raise MotionDataError(
            f'{name}, {record.where(at)}: time {time_s[at]:.9g} s after the first sample {what} '
            f'the time before, {time_s[at - 1]:.9g} s; times must increase. '
            'Sort the record and drop duplicates.'
        )
    wide = np.flatnonzero(step > recorded.max_gap)
    if wide.size:
        at = int(wide[0]) + 1
        raise MotionDataError(
            f'{name}, {record.where(at)}: gap of {step[at - 1]:.9g} s before it, longer than '
            f'max_gap = {recorded.max_gap!r} s. Cut the record there, or raise max_gap.'
        )
    median = float(np.median(step))
    low, high = recorded.passband
    if high >= 0.5 / median:
        raise MotionDataError(
            f'{name}: sampled every {median:.6g} s, it ends at {0.5 / median:.6g} Hz, '
            f'but passband reaches {high!r} Hz. Lower its upper edge.'
        )
    length = float(time_s[-1])
    if length > MOST_STEPS * median:
        raise MotionDataError(
            f'{name}, {record.where(-1)}: the record lasts {length:.6g} s, more than {MOST_STEPS} '
            f'of its median steps of {median:.6g} s. Cut it at the break.'
        )
    needed = max(1.0 / (high - low), 1.0 / low if low else 0.0)
    if length < needed:
        raise MotionDataError(
            f'{name}: lasts {length:.6g} s; the passband {[low, high]} Hz needs at least '
            f'{needed:.6g} s, one period of its lower edge and of its width. '
            'Use a longer record, or raise the lower edge and widen the band.'
        )
    return int(np.count_nonzero(step > 1.5 * median))


# -----------------------------------------------------------------------------
# The kind of ship.


class RecordedShip(ShipKind):
    """Measured motion."""

    is_computed = False
    rank = 4
    starter = {
        'recorded': {
            'path': 'shipped:nbp1406_seapath/s330_motion.csv',
            'time_column': 't_s',
            'roll_column': 'roll_deg',
            'heave_column': 'heave_m',
        }
    }

    kind: Literal['recorded'] = 'recorded'
    recorded: Recorded = Field(description='mapping: path, and CSV columns or a topic')

    def channels(self, scene: Surroundings) -> Channels:
        """Return the measured motion within its pass-band."""
        return recorded_motion(scene, self.recorded)

    def files(self) -> Iterator[tuple[str, str, bool]]:
        """Yield the record, which may be a folder if it is a bag."""
        yield 'ship.recorded.path', self.recorded.path, self.recorded.topic is not None

    def problems(self) -> Iterator[Problem]:
        """Yield the contradictions between its keys."""
        recorded = self.recorded
        columns = {
            'time_column': recorded.time_column,
            'roll_column': recorded.roll_column,
            'heave_column': recorded.heave_column,
        }
        low, high = recorded.passband
        in_bag = recorded.topic is not None
        yield from problems_where(
            *(
                (
                    in_bag and column is not None,
                    f'ship.recorded.{key}',
                    column,
                    'names a CSV column, but topic says that path is a bag',
                    'Leave out topic for a CSV, the columns for a bag.',
                )
                for key, column in columns.items()
            ),
            (
                in_bag and recorded.scale not in (0.0, 1.0),
                'ship.recorded.scale',
                recorded.scale,
                'does not go with a bag: a measured specific force contains gravity and '
                'cannot be scaled',
                'Use 1.0, or a CSV of roll and heave.',
            ),
            *(
                (
                    not in_bag and columns[key] is None,
                    f'ship.recorded.{key}',
                    ABSENT,
                    'is missing',
                    'Name the column with its unit, for example t_s and roll_deg; '
                    'for a bag give topic instead.',
                )
                for key in ('time_column', 'roll_column')
            ),
            (
                low >= high,
                'ship.recorded.passband',
                [low, high],
                'must rise from the lowest to the highest frequency [Hz]',
                f'Use [{high!r}, {low!r}].'
                if low > high
                else 'Use two different frequencies, for example [0.02, 0.4].',
            ),
            (
                max(low, high) >= self.rate / 2.0,
                'ship.recorded.passband',
                [low, high],
                f'must be below half of ship.rate, {self.rate / 2.0:.6g} Hz',
                'Lower its upper edge or raise ship.rate.',
            ),
            (
                recorded.scale == 0.0,
                'ship.recorded.scale',
                recorded.scale,
                'must not be 0, which stops all motion',
                'Use 1.0 for the motion as measured, or ship kind still.',
            ),
        )

    @property
    def motions(self) -> tuple[str, ...]:
        """Roll, and the measured channels: from a bag the forces to port and upwards."""
        if self.recorded.topic is not None:
            return 'sway', 'heave', 'roll'
        return ('roll',) if self.recorded.heave_column is None else ('heave', 'roll')


KIND = RecordedShip
