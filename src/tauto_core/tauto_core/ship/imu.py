"""Readings of an inertial sensor at the clock: computed from the ship's motion, and checked.

Axes follow REP-103: x forward along wheel axle and roll axis, y to port, z up. Roll ρ is
right-handed about x, positive with starboard down. Equations: theory/ship.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import Literal, NamedTuple, TypeAlias, TypeVar

import numpy as np

from tauto_core.samples import FloatArray, ImuSamples, IntArray, SpatialImu, Stateful, join, take

A = TypeVar('A', FloatArray, IntArray)

MOUNT_FRAME = 'clock_mount'

# Simulated motion is exact, but an all-zero covariance would say "unknown" (sensor_msgs/Imu).
# Of orientation [rad²], angular velocity [rad²/s²] and specific force [m²/s⁴].
_COVARIANCES = tuple(variance * np.eye(3).ravel() for variance in (1e-12, 1e-12, 1e-10))

REFUSALS = (
    'orientation_absent',
    'angular_velocity_absent',
    'linear_acceleration_absent',
    'not_finite',
    'zero_quaternion',
    'not_unit_quaternion',
    'roll_undefined',
    'duplicated',
    'out_of_order',
)


@dataclass(frozen=True)
class Attitude:
    """The ship's motion at the clock, arrays of shape (n,).

    Attributes:
        roll: ρ [rad], in (−π, π].
        roll_rate: dρ/dt [rad/s].
        force_y: specific force along the sensor's y (port) [m/s2].
        force_z: specific force along the sensor's z (up, +g at rest) [m/s2].
    """

    roll: FloatArray
    roll_rate: FloatArray
    force_y: FloatArray
    force_z: FloatArray


def imu_from_roll(
    stamp_ns: IntArray,
    roll: FloatArray,
    roll_rate: FloatArray,
    force_y: FloatArray,
    force_z: FloatArray,
) -> ImuSamples:
    """Return IMU samples of a ship that only rolls, with the specific force along y and z [m/s²].

    Orientation (sin ρ/2, 0, 0, cos ρ/2), angular velocity (ρ̇, 0, 0).
    """
    half, zero = 0.5 * np.ascontiguousarray(roll), np.zeros(len(stamp_ns))
    return sensed(
        stamp_ns,
        np.column_stack((np.sin(half), zero, zero, np.cos(half))),
        np.column_stack((roll_rate, zero, zero)),
        np.column_stack((zero, force_y, force_z)),
    )


def sensed(
    stamp_ns: IntArray, orientation: FloatArray, angular_velocity: FloatArray, force: FloatArray
) -> ImuSamples:
    """Return samples with the covariances of this module."""
    of_orientation, of_velocity, of_force = _covariances(len(stamp_ns))
    return ImuSamples(
        stamp_ns,
        MOUNT_FRAME,
        orientation,
        of_orientation,
        angular_velocity,
        of_velocity,
        force,
        of_force,
    )


@lru_cache(maxsize=8)
def _covariances(n: int) -> tuple[FloatArray, ...]:
    """Return read-only views of the covariances, for n samples."""
    return tuple(np.broadcast_to(row, (n, 9)) for row in _COVARIANCES)


def imu_samples(
    stamp_ns: IntArray,
    roll: FloatArray,
    roll_rate: FloatArray | None,
    roll_acceleration: FloatArray | None,
    heave_acceleration: FloatArray | None,
    height: float,
    gravity: float,
    *,
    turning: bool = True,
    felt: bool = True,
) -> ImuSamples:
    """Return the readings of an IMU at the clock (theory/ship.md).

    The acceleration of the clock, `height` z0 above the roll axis, is
    ÿ = -z0 (ρ̈ cos ρ - ρ̇² sin ρ) and z̈ = z̈_s - z0 (ρ̈ sin ρ + ρ̇² cos ρ). The specific force, in
    axes turned by ρ, is

        f′_y = (g + z̈_s) sin ρ - z0 ρ̈,    f′_z = (g + z̈_s) cos ρ - z0 ρ̇².

    Derivatives that the readings do not need may be `None`, and the heave if there is none.
    Without `turning` the angular velocity is empty, without `felt` the force.
    """
    from tauto_core.ship.kernels import encode_imu  # imports kernels

    n = len(stamp_ns)
    whole = -(-n // 8) * 8
    orientation = np.empty((whole, 4))
    angular_velocity, force = (np.empty((whole if asked else 0, 3)) for asked in (turning, felt))
    encode_imu(
        np.ascontiguousarray(roll),
        None if roll_rate is None else np.ascontiguousarray(roll_rate),
        None if height == 0.0 else roll_acceleration,
        heave_acceleration,
        height,
        gravity,
        orientation,
        angular_velocity if turning else None,
        force if felt else None,
    )
    return sensed(stamp_ns, orientation[:n], angular_velocity[:n], force[:n])


def attitude(imu: ImuSamples) -> Attitude:
    """Return roll, roll rate and specific force from screened IMU samples (theory/ship.md).

    The roll of the yaw-pitch-roll sequence and its rate are

        ρ = atan2(2 (w x + y z), w² - x² - y² + z²),
        ρ̇ = ω_x + (ω_y sin ρ + ω_z cos ρ) tan(pitch).

    The norm of the quaternion does not matter. The bits do not depend on batches.
    """
    x, y, z, w = (np.ascontiguousarray(imu.orientation[:, i]) for i in range(4))
    sine = 2.0 * (w * x + y * z)
    cosine = (w * w - x * x) + (z * z - y * y)
    roll = np.arctan2(sine, cosine)
    tan_pitch = 2.0 * (w * y - z * x) / np.sqrt(sine * sine + cosine * cosine)
    omega_x, omega_y, omega_z = (
        np.ascontiguousarray(imu.angular_velocity[:, i]) for i in range(3)
    )
    across = omega_y * np.sin(roll) + omega_z * np.cos(roll)
    return Attitude(
        # atan2 gives -π for a sine of -0.0
        np.where(roll == -np.pi, np.pi, roll),
        omega_x + across * tan_pitch,
        np.ascontiguousarray(imu.linear_acceleration[:, 1]),
        np.ascontiguousarray(imu.linear_acceleration[:, 2]),
    )


def screen(imu: ImuSamples, last_stamp_ns: int | None) -> tuple[ImuSamples, dict[str, int]]:
    """Return the samples that may be integrated, and the number refused for each reason.

    Each refused sample counts once, under the first of `REFUSALS` that applies:
    `orientation_absent`, `angular_velocity_absent`, `linear_acceleration_absent` (first element
    of the covariance -1, while all zero means unknown and is accepted), `not_finite` (in
    orientation, angular velocity or linear acceleration), `zero_quaternion` (norm below 1e-6),
    `not_unit_quaternion` (norm differs from 1 by more than 1e-3), `roll_undefined` (pitch at 90
    degrees), `duplicated` (stamp of the last sample kept), `out_of_order` (an earlier stamp).

    `last_stamp_ns` is the stamp of the last sample kept in earlier batches.
    """
    reasons = refusal_reasons(imu, last_stamp_ns)
    if not reasons.any():
        return imu, dict.fromkeys(REFUSALS, 0)
    totals = np.bincount(reasons, minlength=1 + len(REFUSALS))
    counts = {name: int(total) for name, total in zip(REFUSALS, totals[1:], strict=True)}
    return take(imu, reasons == 0), counts


def contiguous(array: A) -> A:
    """Return the array, or a copy, contiguous and writable for compiled functions."""
    flags = array.flags
    return array if flags.c_contiguous and flags.writeable else array.copy()


def refusal_reasons(
    imu: ImuSamples, last_stamp_ns: int | None, *, by_stamp: bool = True
) -> IntArray:
    """Return for each sample 0 if `screen` keeps it, else 1 + the index in `REFUSALS`.

    If not `by_stamp`, the content alone counts.
    """
    from tauto_core.ship.kernels import refuse_samples  # imports kernels

    reasons = np.zeros(len(imu.stamp_ns), np.int64)
    for number, vector in enumerate(('orientation', 'angular_velocity', 'linear_acceleration'), 1):
        covariance = getattr(imu, f'{vector}_covariance')
        # one row may stand for all
        is_absent = covariance[: 1 if covariance.strides[0] == 0 else None, 0] == -1.0
        if is_absent.any():
            reasons[(reasons == 0) & is_absent] = number
    refuse_samples(
        # one type of stamps, since a kernel is compiled for each
        contiguous(imu.stamp_ns) if by_stamp else np.arange(len(reasons)),
        -(2**63) if last_stamp_ns is None else last_stamp_ns,
        contiguous(imu.orientation),
        contiguous(imu.angular_velocity),
        contiguous(imu.linear_acceleration),
        reasons,
    )
    return reasons


# -----------------------------------------------------------------------------
# The readings of a `SpatialImu`, with the bits of its messages.

Sensed: TypeAlias = ImuSamples | SpatialImu


def message(imu: Sensed) -> ImuSamples:
    """Return the samples as in a message, with all fields."""
    return imu if isinstance(imu, ImuSamples) else imu.samples(True, True, slice(None))


def in_parts(imu: Sensed, turning: bool, felt: bool) -> Iterator[tuple[slice, ImuSamples]]:
    """Yield rows and samples, a `SpatialImu` in its parts with only the channels asked for."""
    if isinstance(imu, SpatialImu):
        yield from imu.parts(turning, felt)
    else:
        yield slice(None), imu


def kept(imu: Sensed, asked: set[str]) -> Sensed:
    """Return the same samples with readings that are computed once for all clocks.

    `asked` collects the channels that the clocks use: an unused force is not computed.
    """
    if isinstance(imu, ImuSamples):
        return imu
    whole = cache(lambda turning, felt: imu.samples(turning, felt, slice(None)))

    def samples(turning: bool, felt: bool, rows: slice) -> ImuSamples:
        asked.update(['turning'] * turning, ['felt'] * felt)
        return take(whole('turning' in asked, 'felt' in asked), rows)

    return replace(imu, samples=samples)


def parted(imu: Sensed, row: int) -> tuple[Sensed, Sensed]:
    """Return the samples before a row, and the rest."""
    if isinstance(imu, ImuSamples):
        return take(imu, slice(None, row)), take(imu, slice(row, None))

    def part(begin: int, end: int) -> SpatialImu:
        def samples(turning: bool, felt: bool, rows: slice) -> ImuSamples:
            first, last, _ = rows.indices(end - begin)
            return imu.samples(turning, felt, slice(begin + first, begin + last))

        return SpatialImu(imu.stamp_ns[begin:end], samples, imu.first + begin)

    return part(0, row), part(row, len(imu.stamp_ns))


# -----------------------------------------------------------------------------
# The mounting of a live sensor.


def quaternion_of_angles(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Return R_z(yaw) R_y(pitch) R_x(roll) as a quaternion x, y, z, w, for angles in radians.

    With the mounting angles of a sensor, R maps vectors from its axes to the clock's.
    """
    (a, b, c), (d, e, f) = (
        np.cos([roll / 2, pitch / 2, yaw / 2]),
        np.sin([roll / 2, pitch / 2, yaw / 2]),
    )
    return np.array(
        [
            d * b * c - a * e * f,
            a * e * c + d * b * f,
            a * b * f - d * e * c,
            a * b * c + d * e * f,
        ]
    )


def mounted(imu: ImuSamples, mount: FloatArray) -> ImuSamples:
    """Return samples of a sensor in the clock's axes: v' = R v and q' = q R⁻¹.

    `mount` is R as a quaternion x, y, z, w. Covariances are not rotated, as they only say whether
    a quantity is known.
    """
    axis, w = mount[:3], mount[3]

    def turned(v: FloatArray) -> FloatArray:
        across = 2.0 * np.cross(axis, v)
        found: FloatArray = v + w * across + np.cross(axis, across)
        return found

    q, p = imu.orientation[:, :3], imu.orientation[:, 3:]
    back = -axis
    orientation = np.column_stack(
        (p * back + w * q + np.cross(q, back), p * w - (q @ back)[:, None])
    )
    return replace(
        imu,
        frame_id=MOUNT_FRAME,
        orientation=orientation,
        angular_velocity=turned(imu.angular_velocity),
        linear_acceleration=turned(imu.linear_acceleration),
    )


# -----------------------------------------------------------------------------
# Sorting the samples of a live sensor into runs of uninterrupted motion.
#
# A sample continues the run if it is later than the last by at most the longest gap, and the roll
# has changed as the gyro says. Other samples are suspects. If a later sample continues the run,
# the suspects were wrong and are dropped. If they continue each other for `CONFIRMED_GAPS` longest
# gaps, time or motion has jumped, and they begin a new run. Earlier samples that fill a gap of the
# last `LATE_S` are late and dropped. Other samples that go back and then pass the last good one
# are a step of the sensor's clock. A step of less than `FILLED` sample steps looks like samples
# out of order. The result depends on the samples alone, not on batches or on the playback speed.
#
# If a sensor is faster than the scene, each kept sample becomes a mean of all samples from two
# kept ones before to two after, with Hann weights. At even steps h this linear-phase filter has
# zeros at 1/(2h) and every 1/(4h) from there on, which thinning would alias onto the slow motion.
# It delays by 2 h and flattens a slow motion by 0.26 (Ω h)². The second difference of the last
# means corrects that.

CONFIRMED_GAPS = 1.0
LATE_S = 60.0
"""Time for which a gap is remembered, to recognise its late samples."""
LEAST_SUSPECTS = 3
FEW = 10
MOST_SUSPECTS = 20_000

THINNED_PART = 0.75
"""A faster sensor is thinned to steps of at least this fraction of the scene's step."""
UNEVEN = 4.0
"""Largest ratio of neighbouring steps. Polynomials through uneven nodes multiply noise by its
cube."""
FILLED = 3.0
"""A step longer than this multiple of the one before is filled with interpolated samples."""

LINE_STEPS = 4
"""Steps of the scene over which a straight line continues the motion for the reading of now."""

JUMP_RAD = 0.05
"""Largest change of roll that the gyro does not explain: above sensor errors, harmless to a clock.
"""
MEAN_RAD = 0.01
"""The same for a sample in a mean. It excludes a second sensor mounted half a degree off."""
JUMP_RAD_PER_S3 = 0.2
"""Error of the trapezoid rule, |d³ρ/dt³|/12, in a sea of 4 s and 30 degrees."""


class RollSample(NamedTuple):
    """Stamp [ns], roll [rad] and roll rate [rad/s] of a sample."""

    stamp_ns: int
    roll: float
    roll_rate: float


class MotionRun(NamedTuple):
    """Samples of one uninterrupted motion.

    Attributes:
        imu: the samples.
        begins: whether this one sample begins a new motion.
        stepped_ns: step back of its stamp behind the last good one, if any.
    """

    imu: ImuSamples
    begins: bool
    stepped_ns: int = 0


class Continuity(Stateful):
    """Sorts screened samples of a live sensor into runs, independently of batches.

    `step_ns` is the scene's step, `max_gap_ns` the longest that is interpolated.
    """

    state_names = (
        'last', 'kept', 'before_ns', 'window', 'nodes', 'waiting', 'means', 'suspects', 'gaps',
        'astray', 'counts',
    )  # fmt: skip

    def __init__(self, step_ns: int, max_gap_ns: int) -> None:
        self._step_ns, self._max_gap_ns = step_ns, max_gap_ns
        self._last: RollSample | None = None
        self._kept: ImuSamples | None = None
        self._before_ns = step_ns
        self._window: list[tuple[int, FloatArray]] = []
        self._nodes: list[int] = []
        self._waiting: list[ImuSamples] = []
        self._means: list[FloatArray] = []
        self._suspects: list[tuple[RollSample, ImuSamples]] = []
        self._gaps: list[tuple[int, int]] = []
        self._astray = 0
        self.counts = {
            'duplicated': 0,
            'out_of_order': 0,
            'stamps_ahead': 0,
            'roll_jumps': 0,
            'bridged_gaps': 0,
        }

    @property
    def holds_s(self) -> float:
        """Time from the last good sample to the latest suspect [s].

        0 for fewer than `FEW` in a row, which are late or wrong.
        """
        if self._astray < FEW or not self._suspects or self._last is None:
            return 0.0
        return (self._suspects[-1][0].stamp_ns - self._last.stamp_ns) * 1e-9

    @property
    def last_ns(self) -> int:
        """Stamp of the last good sample of the run [ns]; -1: there is none."""
        return -1 if self._last is None else self._window[-1][0]

    def restart(self) -> None:
        """Begin a new run with the next sample."""
        self._last = self._kept = None
        self._waiting, self._astray = [], 0
        self._drop_suspects()

    def feed(
        self, imu: ImuSamples, is_due: Callable[[int], bool] = lambda _: False
    ) -> Iterator[MotionRun]:
        """Yield the samples to use, in runs. Their content must have been screened.

        A part also ends, perhaps without samples, at each good sample if `is_due` of its stamp.
        """
        motion = attitude(imu)
        places = list(
            map(RollSample, imu.stamp_ns.tolist(), motion.roll.tolist(), motion.roll_rate.tolist())
        )
        parts: list[ImuSamples] = []
        for index, place in enumerate(places):
            one = take(imu, slice(index, index + 1))
            if self._last is None:
                self._before_ns, self._last, self._kept = self._step_ns, place, one
                self._window, self._nodes, self._means = [_row(one)], [place.stamp_ns], []
                yield MotionRun(one, True)
            elif self._goes_on(self._last, place) and not self._steps_back(place):
                self._drop_suspects()
                self._astray = 0
                parts += self._spaced(place, one)
                if is_due(place.stamp_ns):
                    yield MotionRun(join(parts) if parts else take(one, slice(0, 0)), False)
                    parts = []
            elif place.stamp_ns == self._last.stamp_ns:
                self.counts['duplicated'] += 1
            elif (again := self._suspected(place, one)) is not None:
                if parts := [*parts, *self._waiting]:
                    yield MotionRun(join(parts), False)
                stepped_ns = self._last.stamp_ns - int(again.stamp_ns[0])
                if stepped_ns < 0:
                    self._remember(self._last.stamp_ns, int(again.stamp_ns[0]))
                else:
                    self._gaps.clear()
                self.restart()
                for run in self.feed(again, is_due):
                    yield run._replace(stepped_ns=max(stepped_ns, 0))
                parts = []
        if parts:
            yield MotionRun(join(parts), False)

    def finish(self) -> list[MotionRun]:
        """Return the last samples, which were waiting for later ones, without averaging."""
        left, self._waiting = self._waiting, []
        return [MotionRun(join(left), False)] if left else []

    def _goes_on(self, before: RollSample, now: RollSample) -> bool:
        elapsed_ns = now.stamp_ns - before.stamp_ns
        if not 0 < elapsed_ns <= self._max_gap_ns:
            return False
        most = JUMP_RAD + JUMP_RAD_PER_S3 * (elapsed_ns * 1e-9) ** 3
        return abs(_unexplained(before, now)) <= most

    def _suspected(self, place: RollSample, one: ImuSamples) -> ImuSamples | None:
        """Add a suspect. Return all suspects once they are confirmed as a new run."""
        aside = self._suspects
        if aside and (len(aside) == MOST_SUSPECTS or not self._goes_on(aside[-1][0], place)):
            self._drop_suspects()
        aside.append((place, one))
        self._astray += 1
        covered_ns = place.stamp_ns - aside[0][0].stamp_ns
        if len(aside) < LEAST_SUSPECTS:
            return None
        if covered_ns < CONFIRMED_GAPS * self._max_gap_ns and not self._steps_back(place):
            return None
        if self._are_late():
            self._drop_suspects()
            return None
        confirmed = join([sample for _, sample in aside])
        aside.clear()
        return confirmed

    def _steps_back(self, place: RollSample) -> bool:
        """Return whether the suspects went back and now pass the last good sample."""
        aside = [one for one, _ in self._suspects]
        if self._last is None or len(aside) < LEAST_SUSPECTS:
            return False
        back_ns, usual_ns = self._last.stamp_ns - aside[0].stamp_ns, self._usual_ns
        passes = back_ns > FILLED * usual_ns and place.stamp_ns > self._last.stamp_ns
        follows = aside[-1] == place or self._goes_on(aside[-1], place)
        return passes and follows and not self._are_late()

    def _are_late(self) -> bool:
        fills = [any(a < one.stamp_ns < b for a, b in self._gaps) for one, _ in self._suspects]
        return 2 * sum(fills) > len(fills)

    @property
    def _usual_ns(self) -> int:
        return max(self._step_ns, self._before_ns)

    def _remember(self, last_ns: int, next_ns: int) -> None:
        oldest_ns = next_ns - round(LATE_S * 1e9)
        self._gaps = [gap for gap in self._gaps if gap[1] > oldest_ns] + [(last_ns, next_ns)]

    def _drop_suspects(self) -> None:
        for place, _ in self._suspects:
            last_ns = place.stamp_ns if self._last is None else self._last.stamp_ns
            ahead = place.stamp_ns > last_ns + self._max_gap_ns
            late = 'stamps_ahead' if ahead else 'roll_jumps'
            self.counts['out_of_order' if place.stamp_ns < last_ns else late] += 1
        self._suspects.clear()

    def _spaced(self, place: RollSample, one: ImuSamples) -> list[ImuSamples]:
        """Return the samples to add for one that continues the run: with any that fill a gap."""
        assert self._last is not None
        assert self._kept is not None
        elapsed_ns = place.stamp_ns - self._last.stamp_ns
        if elapsed_ns < max(THINNED_PART * self._step_ns, self._before_ns / UNEVEN):
            if abs(_unexplained(self._last, place)) < MEAN_RAD:
                self._window.append(_row(one))
            return []
        usual_ns, last_ns = self._usual_ns, self._last.stamp_ns
        parts: list[ImuSamples] = []
        self._before_ns = elapsed_ns
        if self._window[-1][0] == last_ns or elapsed_ns > FILLED * usual_ns:
            # without samples in between there is no mean to wait for
            parts = [*self._waiting, one]
            self._waiting, self._nodes, self._means = [], [], []
            self._window = self._window[-LINE_STEPS:]
        if elapsed_ns > FILLED * usual_ns:
            self.counts['bridged_gaps'] += 1
            self._remember(last_ns, place.stamp_ns)
            number = -(-elapsed_ns // usual_ns)
            parts.insert(-1, _between(self._kept, one, number))
            self._before_ns = elapsed_ns // number
        self._window.append(_row(one))
        self._nodes.append(place.stamp_ns)
        self._last, self._kept = place, one
        if not parts:
            self._waiting.append(one)
            if len(self._waiting) > 2:
                parts = [self._averaged(self._waiting.pop(0))]
        return parts

    def ahead(self, due_ns: int, number: int) -> ImuSamples | None:
        """Return the samples that wait and the next `number`, as a straight line predicts them.

        The line is fitted to all good samples of the last `LINE_STEPS` steps, with Hann's weights.
        None: fewer than two, or the latest good sample is before `due_ns`.
        """
        now_ns, step_ns = self.last_ns, self._usual_ns
        if self._last is None or now_ns < due_ns:
            return None
        window = [each for each in self._window if each[0] >= now_ns - LINE_STEPS * step_ns]
        if len(window) < 2:
            return None
        rows = np.array([row for _, row in window])
        rows[:, :4] *= np.sign(rows[:, :4] @ rows[-1, :4])[:, None]
        waiting = [int(one.stamp_ns[0]) for one in self._waiting]
        after = (self._last.stamp_ns + step_ns * k for k in range(1, number + 1))
        stamps = np.array([*waiting, *after])
        span_ns = now_ns - window[0][0]
        since = np.array([stamp_ns - now_ns for stamp_ns, _ in window]) / span_ns
        hann = np.sin(np.pi * (0.02 - since) / 1.04)
        level, slope = np.polynomial.polynomial.polyfit(since, rows, 1, w=hann)
        rows = level + ((stamps - now_ns) / span_ns)[:, None] * slope
        attitudes = rows[:, :4] / np.linalg.norm(rows[:, :4], axis=1)[:, None]
        return sensed(stamps, attitudes, rows[:, 4:7], rows[:, 7:])

    def _averaged(self, one: ImuSamples) -> ImuSamples:
        """Return the mean of the samples about a kept one, up to the second kept after it."""
        at_ns, kept = _row(one)
        place = self._nodes.index(at_ns)
        first_ns, last_ns = self._nodes[max(place - 2, 0)], self._nodes[-1]
        self._nodes = self._nodes[max(place - 2, 0) :]
        self._window = [each for each in self._window if each[0] >= first_ns]
        rows = np.array([row for _, row in self._window])
        since = np.array([stamp_ns - at_ns for stamp_ns, _ in self._window], float)
        reach = np.where(since < 0.0, max(at_ns - first_ns, 1), last_ns - at_ns)
        weight = np.cos(0.5 * np.pi * since / reach) ** 2
        rows[:, :4] *= np.sign(rows[:, :4] @ kept[:4])[:, None]  # q and −q are one attitude
        sums = [float(weight @ since**k) for k in range(3)]
        # least-squares line: uneven stamps do not shift its value
        weight *= (sums[2] - sums[1] * since) / (sums[0] * sums[2] - sums[1] ** 2)
        mean: FloatArray = weight @ rows
        self._means = [*self._means[-2:], mean]
        if len(self._means) == 3:
            bend = np.diff(self._means, 2, axis=0)[0] / (0.5 * (at_ns - first_ns)) ** 2
            mean = mean - 0.5 * sums[2] / sums[0] * bend
        return replace(
            one,
            orientation=(mean[:4] / np.linalg.norm(mean[:4]))[None],
            angular_velocity=mean[None, 4:7],
            linear_acceleration=mean[None, 7:],
        )


def _unexplained(before: RollSample, now: RollSample) -> float:
    turned = math.remainder(now.roll - before.roll, math.tau)
    elapsed_s = (now.stamp_ns - before.stamp_ns) * 1e-9
    return turned - 0.5 * (before.roll_rate + now.roll_rate) * elapsed_s


def _row(one: ImuSamples) -> tuple[int, FloatArray]:
    """Return the stamp of a sample and its ten numbers."""
    vectors = one.orientation[0], one.angular_velocity[0], one.linear_acceleration[0]
    return int(one.stamp_ns[0]), np.concatenate(vectors)


def _between(before: ImuSamples, after: ImuSamples, number: int) -> ImuSamples:
    """Return samples, interpolated linearly, that divide a gap into `number` parts."""
    x = np.arange(1, number) / number
    first, last = int(before.stamp_ns[0]), int(after.stamp_ns[0])

    def mixed(one: FloatArray, other: FloatArray) -> FloatArray:
        return one + x[:, None] * (other - one)

    # q and −q are the same attitude: use the nearer one
    sign = math.copysign(1.0, float(np.sum(before.orientation * after.orientation)))
    orientation = mixed(before.orientation, sign * after.orientation)
    rows = np.zeros(number - 1, np.int64)
    return ImuSamples(
        np.array([first + (last - first) * k // number for k in range(1, number)], np.int64),
        after.frame_id,
        orientation / np.linalg.norm(orientation, axis=1)[:, None],
        after.orientation_covariance[rows],
        mixed(before.angular_velocity, after.angular_velocity),
        after.angular_velocity_covariance[rows],
        mixed(before.linear_acceleration, after.linear_acceleration),
        after.linear_acceleration_covariance[rows],
    )


# -----------------------------------------------------------------------------
# A ship with six degrees of freedom: readings at the clock, and the force that its thread follows.

ThreadPlane: TypeAlias = Literal['free', 'vertical', 'ship']
"""The plane in which the weight of a clock can follow the apparent vertical (hull.md).

`free`: the thread leans in all directions. `vertical`: gimbals hold the wheel's axle level.
`ship`: the plane athwart, fixed to the ship.
"""


class ShipAngles(NamedTuple):
    """Angles of the ship [rad], or their rates [rad/s], (n,) each."""

    roll: FloatArray
    pitch: FloatArray
    yaw: FloatArray


def imu_from_motions(
    stamp_ns: IntArray,
    angle: ShipAngles,
    rate: ShipAngles | None,
    acceleration: tuple[FloatArray, FloatArray, FloatArray] | None,
    gravity: FloatArray | float,
) -> ImuSamples:
    """Return the readings of an IMU fixed to the ship at the clock.

    Specific force f = Rᵀ(a + g ẑ), R = R_z(ψ) R_y(θ) R_x(ρ), and angular velocity in ship axes

        ω_x = ρ̇ − ψ̇ sin θ,  ω_y = θ̇ cos ρ + ψ̇ cos θ sin ρ,  ω_z = −θ̇ sin ρ + ψ̇ cos θ cos ρ.

    The bits of a sample depend on its own values alone.

    Args:
        stamp_ns: true time of each sample [ns], (n,).
        angle: roll, pitch, yaw.
        rate: their derivatives. Without it the angular velocity is empty.
        acceleration: acceleration of the clock forward, to port and up, in level axes [m/s²].
            Without it the force is empty.
        gravity: gravity, less Eötvös' term [m/s²].
    """
    from tauto_core.ship.kernels import encode_six  # imports kernels

    n = len(stamp_ns)
    whole = -(-n // 8) * 8
    orientation = np.empty((whole, 4))
    turning = None if rate is None else np.empty((whole, 3))
    force = None if acceleration is None else np.empty((whole, 3))
    parts: list[FloatArray | None] = [*angle, *(rate or (None,) * 3), None, None, None]
    if acceleration is not None:
        forward, port, up = acceleration
        parts[6:] = forward, port, up + gravity
    given = (None if part is None else contiguous(part) for part in parts)
    encode_six(*given, orientation, turning, force)
    none = np.empty((0, 3))
    return sensed(
        stamp_ns,
        orientation[:n],
        none if turning is None else turning[:n],
        none if force is None else force[:n],
    )


def force_in_plane(imu: ImuSamples, plane: ThreadPlane) -> FloatArray:
    """Return the specific force that a clock's thread can follow, in the last two columns.

    They are athwart and upright in the axes of the case. The first column, along the axle, has no
    effect. A free thread follows all of |f|: the weight pulls with |f| in the direction of the
    other two components.
    """
    force = imu.linear_acceleration
    if plane == 'ship':
        return force
    from tauto_core.ship import kernels  # kernels

    orientation, force = contiguous(imu.orientation), contiguous(force)
    # a sample of a ship that only rolls has the same bits in all planes
    if kernels.rolls_alone(orientation, force):
        return force
    felt = np.empty((-(-len(force) // 8) * 8, 3))
    kernels.force_in_plane(orientation, force, plane == 'vertical', felt)
    return felt[: len(force)]


def upward(imu: ImuSamples) -> FloatArray:
    """Return the vertical in the axes of the sensor, (n, 3): u̇ = u × ω.

    u = Rᵀ ẑ = (−sin θ, cos θ sin ρ, cos θ cos ρ), for any yaw.
    """
    sr, cr, sp, cp = _roll_and_pitch(imu.orientation)
    return np.column_stack((-sp, cp * sr, cp * cr))


def level_force(imu: ImuSamples) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the specific force of screened samples forward, to port and up, in level axes."""
    x, y, z = (np.ascontiguousarray(imu.linear_acceleration[:, i]) for i in range(3))
    sr, cr, sp, cp = _roll_and_pitch(imu.orientation)
    aside, deck = cr * y - sr * z, sr * y + cr * z
    return cp * x + sp * deck, aside, cp * deck - sp * x


def _roll_and_pitch(orientation: FloatArray) -> tuple[FloatArray, ...]:
    """Return sine and cosine of roll and pitch, of quaternions of any norm (n, 4)."""
    qx, qy, qz, qw = (np.ascontiguousarray(orientation[:, i]) for i in range(4))
    # sine and cosine of the roll, times cos θ and the squared norm
    square = (qx * qx + qy * qy) + (qz * qz + qw * qw)
    sr, cr = 2.0 * (qw * qx + qy * qz), (qw * qw - qx * qx) + (qz * qz - qy * qy)
    cp = np.hypot(sr, cr)
    return sr / cp, cr / cp, 2.0 * (qw * qy - qz * qx) / square, cp / square
