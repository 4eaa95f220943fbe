"""The trochlea on a live sensor: the dial stops if the motion is lost or impossible.

A run ends at its last reading if the motion breaks off for more than `MAX_GAP_S`, jumps, or would
make the wheel swing impossibly. The next good motion releases the wheel again, and the dial
continues from where it stopped. It loses the time in between, which each reading states
(`source`, DialSetting). If the stamps have gone back, the duration of the break is unknown, and
the readings state by how much. The dial is set again only on request or if all time begins again.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from tauto_core.clockwork.trochlea import (
    MOST_CELSIUS,
    NOTHING_YET,
    WHEEL_FRAME,
    DialSetting,
    TrochleaStage,
)
from tauto_core.machines import OtherRegulator, compile_machine
from tauto_core.samples import (
    JOINT_STATES,
    READING,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    Batches,
    FloatArray,
    ImuSamples,
    IntArray,
    JointSamples,
    Samples,
    Stateful,
    TemperatureSamples,
    TimeSamples,
    join,
    merged,
    same,
    take,
)
from tauto_core.scene import Scene
from tauto_core.scene.errors import PropagationError
from tauto_core.scene.times import EPOCH_1990_NS, MAX_GAP_S, NS_PER_S
from tauto_core.ship.imu import (
    REFUSALS,
    Continuity,
    MotionRun,
    attitude,
    level_force,
    refusal_reasons,
    upward,
)

# -----------------------------------------------------------------------------
# Motions that no machine can have. Readings from them are refused.

MOST_RELEASES = math.tau
"""Largest accepted amplitude over the release: a whole turn for a release of 1 rad."""

GROWTH_MARGIN = 2.0
"""Allowance for impulses and anharmonic swings."""
GROWTH_RELEASES = 0.25
"""Growth from one reading to the next that is always accepted, over the release."""


LATEST_NS = 2**63 - 1
"""A stamp after all others."""
_UNUSABLE = 'the dial stands still: ship/imu cannot be used'

# -----------------------------------------------------------------------------
# Faults of a sensor that a single sample does not show.

TOLD_S = 60.0
"""Interval in which a fault is reported only once [s]."""

MOST_HELD = 5000
"""Batches after which the sensor is tested even if their stamps hardly advance."""

BLOCK_S = 0.5
"""Length of the blocks over which turning is compared [s]: a fraction of a roll, but long enough
for 0.2 degrees of noise of the attitude."""
FIRST_S, WINDOW_S = 3.0, 10.0
"""Length of the test of a sensor at the start, before its first use, and later [s]."""
STUCK_S, NO_FORCE = 1.0, 0.002
"""Time after which equal numbers, or a force below this share of g, are a fault [s]. A single axis
may repeat itself for a window: a coarse sensor in harbour does."""
LONGEST_S = 2.0
"""Longest time between samples of a block [s]."""

TILTED_RAD = math.radians(25.0)
"""Angle between the mean force and upwards that no ship keeps up for a window."""
TURNING_RAD = 0.015
"""Least root mean square turning in a block that is compared."""
SLOWEST_S = 0.25
"""Largest distance of samples that show how the ship turns [s]."""


_RESTART = 'Restart the sensor, or its driver'
_STUCK = (
    *(
        f'{axis} of {vector} has stayed the same for {WINDOW_S:g} s. {_RESTART}'
        for vector in ('angular_velocity', 'linear_acceleration')
        for axis in 'xyz'
    ),
    f'all its numbers have stayed the same for a second. {_RESTART}',
    'no force for a second, and no ship falls: is gravity removed, or the accelerometer dead?',
)
_STUCK_NS = np.array([round(WINDOW_S * NS_PER_S)] * 6 + [round(STUCK_S * NS_PER_S)] * 2)


def _first(hints: Mapping[str, bool]) -> str:
    return next((words for words, holds in hints.items() if holds), '')


class SensorWatch(Stateful):
    """Tests windows of samples: attitude against gravity, gyro against attitude, life.

    Averaged over some waves the force is g upwards. The upward direction u in the sensor's axes
    obeys u̇ = u × ω. Its changes over blocks are compared with the integral of the gyro, both
    minus their means, which removes bias and yaw.

    Args:
        gravity: g [m/s²].
    """

    state_names = ('last', 'stuck_ns', 'open', 'rows', 'covered_ns', 'wanted_ns')

    def __init__(self, gravity: float) -> None:
        self._gravity = gravity
        self._last = np.full(10, math.nan)
        self._stuck_ns = np.full(len(_STUCK), NOTHING_YET)
        self.begin()

    def begin(self, window_s: float = FIRST_S) -> None:
        """Begin a window of this length [s]."""
        self._open: list[ImuSamples] = []
        self._rows: list[FloatArray] = []
        self._covered_ns, self._wanted_ns = 0, round(window_s * NS_PER_S)

    @property
    def is_full(self) -> bool:
        """Whether the window is complete."""
        return self._covered_ns >= self._wanted_ns

    def stuck(self, imu: ImuSamples) -> tuple[NDArray[np.bool_], str]:
        """Return which samples are of a stuck sensor, and the fault of the last one.

        A simulated sensor at rest repeats itself, too, but its gyro is exactly 0. So is a single
        axis without motion.
        """
        rows = np.hstack((imu.orientation, imu.angular_velocity, imu.linear_acceleration))
        same: NDArray[np.bool_] = rows == np.vstack((self._last, rows[:-1]))
        same &= np.logical_or.reduce(rows[:, 4:7], axis=1, keepdims=True)
        weightless = np.linalg.norm(rows[:, 7:], axis=1) < NO_FORCE * self._gravity
        axes = same[:, 4:] & (rows[:, 4:] != 0.0)
        hangs = np.column_stack((axes, same.all(axis=1), weightless))
        stamps = np.repeat(imu.stamp_ns[:, None], len(_STUCK), axis=1)
        if self._stuck_ns[0] == NOTHING_YET:
            self._stuck_ns = stamps[0]
        alive = np.where(hangs, NOTHING_YET, stamps)
        since = np.maximum.accumulate(np.vstack((self._stuck_ns, alive)))[1:]
        self._last, self._stuck_ns = rows[-1], since[-1]
        faults: NDArray[np.bool_] = stamps - since > _STUCK_NS
        words = [words for words, is_so in zip(_STUCK, faults[-1], strict=True) if is_so]
        return np.logical_or.reduce(faults, axis=1), words[-1] if words else ''

    def feed(self, imu: ImuSamples) -> int:
        """Take samples up to the end of the window and return their number."""
        for number in range(len(imu.stamp_ns)):
            one = take(imu, slice(number, number + 1))
            elapsed_ns = (
                int(one.stamp_ns[0]) - int(self._open[-1].stamp_ns[0]) if self._open else 0
            )
            if abs(elapsed_ns) > LONGEST_S * NS_PER_S:
                self._open = []
            if elapsed_ns > 0 or not self._open:
                self._open.append(one)
                self._close(BLOCK_S)
            if self.is_full:
                return number + 1
        return len(imu.stamp_ns)

    def _close(self, least_s: float) -> None:
        """Reduce a block to a row of numbers once it is long enough."""
        block_ns = int(self._open[-1].stamp_ns[0] - self._open[0].stamp_ns[0])
        if block_ns < least_s * NS_PER_S:
            return
        imu = join(self._open)
        self._open, self._covered_ns = self._open[-1:], self._covered_ns + block_ns
        up, force = upward(imu), imu.linear_acceleration
        shifted = replace(imu, orientation=imu.orientation[:, [1, 2, 3, 0]])
        elapsed_s = np.diff(imu.stamp_ns)[:, None] / NS_PER_S
        turned = np.cross(up, imu.angular_velocity)
        by_gyro = np.sum(0.5 * (turned[1:] + turned[:-1]) * elapsed_s, axis=0)
        by_attitude = up[-1] - up[0]
        if block_ns > SLOWEST_S * NS_PER_S * len(elapsed_s):
            by_gyro = by_attitude = np.zeros(3)
        means = [
            np.linalg.norm(force, axis=1),
            force[:, 2],
            *level_force(imu),
            *level_force(shifted),
        ]
        self._rows.append(
            np.array([*(float(np.mean(one)) for one in means), *by_attitude[:2], *by_gyro[:2]])
        )

    def fault(self) -> str:
        """Return the fault that the window shows, with its likely cause, or an empty text."""
        if not self._rows:
            self._close(0.0)
        rows = np.array(self._rows)
        return self._fault_of_force(rows) or _fault_of_turning(rows[:, 8:10], rows[:, 10:])

    def _fault_of_force(self, rows: FloatArray) -> str:
        size, down = float(np.median(rows[:, 0])), float(np.median(rows[:, 1])) < 0.0
        tilts = [
            math.atan2(math.hypot(forward, port), up)
            for forward, port, up in (rows[:, 2:5].mean(axis=0), rows[:, 5:8].mean(axis=0))
        ]
        tilted = tilts[0] > TILTED_RAD
        hints = {
            'is it in g? It must be in m/s²': abs(size - 1.0) < 0.1,
            'is gravity removed? It must be the specific force, g upwards at rest': size
            < 0.5 * self._gravity,
            'is the sensor calibrated?': abs(size / self._gravity - 1.0) > 0.1,
            'is it of a frame with z down (NED)? x must point forward, y to port, z up': tilted
            and down,
            'is the order of the quaternion w, x, y, z? It must be x, y, z, w': tilted
            and tilts[1] < TILTED_RAD,
            'is the sensor mounted as imu_rotation says?': tilted,
        }
        hint = _first(hints)
        return hint and (
            f'linear_acceleration on ship/imu is {size:.4g} m/s², by orientation '
            f'{math.degrees(tilts[0]):.3g} degrees from upwards, but '
            f'{self._gravity:.4g} m/s² upwards are expected: {hint}'
        )


def _fault_of_turning(by_attitude: FloatArray, by_gyro: FloatArray) -> str:
    """Return the fault of the changes of u along x and y in blocks, made by pitch and roll."""
    for axis, column in (('x', 1), ('y', 0)):
        attitude, gyro = (
            each[:, column] - each[:, column].mean() for each in (by_attitude, by_gyro)
        )
        one, other = (math.sqrt(float(np.mean(each**2))) for each in (attitude, gyro))
        if max(one, other) < TURNING_RAD:
            continue
        alike = float(np.mean(attitude * gyro)) / max(one * other, 1e-30)
        hints = {
            'is it in deg/s? It must be in rad/s': alike > 0.8 and 30.0 < other / one < 90.0,
            'is the sign of that axis wrong? x must point forward, y to port, z up': alike < -0.8
            and 0.5 < other / one < 2.0,
            'are both alive, of one sensor, and of the same axes?': bool(
                np.mean((attitude - gyro) ** 2) > 0.8 * max(one, other) ** 2
            ),
        }
        hint = _first(hints)
        if hint:
            return (
                f'on ship/imu orientation turns about {axis} by {one:.2g} rad in {BLOCK_S} s, '
                f'angular_velocity says {math.copysign(other, alike):.2g}: {hint}'
            )
    return ''


class Limits(Stateful):
    """Checks the amplitude A = √(θ² + (θ̇/ω)²) and its growth from reading to reading.

    A harmonic wheel with a neutral line inclined by γ obeys θ̈ = −ω² (θ − γ), and dA/dt ≤ ω |γ|.
    More growth, at the largest inclination of the sensor until then, would violate the
    conservation of energy.
    """

    state_names = ('stamp_ns', 'amplitude', 'felt_ns', 'tilt')

    def __init__(self, scene: Scene) -> None:
        machine = compile_machine(scene)
        self._frequency = math.tau / machine.small_period
        self._moves = not scene.lies_still
        if isinstance(machine, OtherRegulator):
            self._release, self._moves = machine.largest_start, machine.follows_apparent_vertical
        else:
            self._release = max(1.0, abs(machine.release_angle))
        self.begin()

    def begin(self) -> None:
        """Begin a run. Its first reading may have any amplitude up to the largest."""
        self._stamp_ns: int | None = None
        self._amplitude = 0.0
        self._felt_ns, self._tilt = np.empty(0, np.int64), np.zeros(1)

    def feel(self, imu: ImuSamples) -> None:
        """Take motion samples, before the readings that depend on them."""
        motion = attitude(imu)
        tilt = np.maximum(np.abs(motion.roll), np.abs(np.arctan2(motion.force_y, motion.force_z)))
        self._felt_ns = np.concatenate([self._felt_ns, imu.stamp_ns])
        self._tilt = np.maximum.accumulate(np.concatenate([self._tilt, tilt]))

    def check(self, wheel: JointSamples, origin_ns: int) -> None:
        """Take readings of a run begun at `origin_ns`. PropagationError: an impossible motion."""
        size = np.hypot(wheel.position[:, 0], wheel.velocity[:, 0] / self._frequency)
        most = MOST_RELEASES * self._release
        allowed = np.full(len(size), most)
        known = self._stamp_ns is not None
        felt = np.searchsorted(self._felt_ns, wheel.stamp_ns, 'right')
        tilt = self._tilt[felt]
        if self._moves:
            stamps = np.concatenate([[self._stamp_ns or 0], wheel.stamp_ns])
            before = np.concatenate([[self._amplitude], size[:-1]])
            elapsed_s = np.diff(stamps) / NS_PER_S
            growth = GROWTH_MARGIN * tilt * (1.0 + self._frequency * elapsed_s)
            growth += GROWTH_RELEASES * self._release
            rows = slice(0 if known else 1, None)
            allowed[rows] = np.minimum(most, (before + growth)[rows])
        wrong = np.flatnonzero(~(size <= allowed))  # also true for NaN
        if len(wrong):
            at = int(wrong[0])
            raise PropagationError(
                f'the wheel swings to {size[at]:.6g}, at most {allowed[at]:.6g} can be (released '
                f'at {self._release:.6g}, motion inclined by up to {tilt[at]:.6g} rad). Check the '
                'stamps of ship/imu and the rate of the scene',
                (int(wheel.stamp_ns[at]) - origin_ns) / NS_PER_S,
            )
        self._stamp_ns, self._amplitude = int(wheel.stamp_ns[-1]), float(size[-1])
        self._felt_ns, self._tilt = self._felt_ns[felt[-1] :], self._tilt[felt[-1] :]


class HeldTemperature(Stateful):
    """Temperatures at the logged instants of a run, from a thermometer with its own stamps.

    The first motion sample after a logged instant sets the temperature of the next instant: the
    thermometer's last value, or `trochlea.at_celsius` before the first. So the clock never waits
    for the thermometer, and follows it by one to two log intervals.
    """

    state_names = ('stamps', 'celsius', 'origin_ns', 'next')

    def __init__(self, scene: Scene) -> None:
        self._log_ns = scene.log_interval_ns
        at_celsius = 20.0 if scene.trochlea is None else scene.trochlea.at_celsius
        self._stamps, self._celsius = np.array([NOTHING_YET]), np.array([at_celsius])
        self._origin_ns, self._next = 0, 0

    def hear(self, felt: TemperatureSamples) -> None:
        """Take values of the thermometer. Impossible values are left out."""
        stamps = np.concatenate([self._stamps, felt.stamp_ns])
        celsius = np.concatenate([self._celsius, felt.temperature])
        known = np.abs(celsius) < MOST_CELSIUS
        order = np.argsort(stamps[known], kind='stable')
        self._stamps, self._celsius = stamps[known][order], celsius[known][order]

    def begin(self, origin_ns: int) -> None:
        """Begin a run with the first logged instant `origin_ns`."""
        self._origin_ns, self._next = origin_ns, 0

    def during(self, stamps_ns: IntArray) -> TemperatureSamples:
        """Return the next temperatures of the run, which these motion samples need."""
        since, log_ns = stamps_ns - self._origin_ns, self._log_ns
        wanted = np.arange(self._next, max(-(-int(since[-1]) // log_ns) + 1, self._next))
        # the first sample after the previous logged instant
        decided = stamps_ns[np.searchsorted(since, (wanted - 1) * log_ns, 'right')]
        heard = np.searchsorted(self._stamps, decided, 'right') - 1
        celsius = self._celsius[heard]
        if len(wanted):
            self._next = int(wanted[-1]) + 1
            self._stamps, self._celsius = self._stamps[heard[-1] :], self._celsius[heard[-1] :]
        return TemperatureSamples(
            self._origin_ns + wanted * log_ns, WHEEL_FRAME, celsius, np.zeros(len(wanted))
        )


class LiveTrochlea(Stateful):
    """A TrochleaStage for motion with its own stamps, anchored at the first stamp.

    Args:
        scene: the scene to simulate. Its motion comes through `feed`.
        reset_on_time_jump: whether the dial is set again if the stamps go back for good.

    Raises:
        SceneError: the machine or its suspension cannot be built.
    """

    state_names = (
        'stage', 'continuity', 'limits', 'run', 'shown', 'refused', 'counts', 'trouble',
        'all_back', 'anew', 'watch', 'held', 'newest_ns', 'standing', 'thermometer', 'told_ns',
    )  # fmt: skip
    outputs: ClassVar[tuple[str, ...]] = TrochleaStage.outputs

    def __init__(self, scene: Scene, reset_on_time_jump: bool = False) -> None:
        self._resets, self._all_back, self._anew = reset_on_time_jump, False, False
        still = scene.lies_still
        gap_ns = round(MAX_GAP_S * NS_PER_S)
        self._continuity = Continuity(scene.step_ns, max(gap_ns, 2 * scene.step_ns * still))
        self._stage = TrochleaStage(scene, anchor='first')
        self._fresh = self._stage.state()
        felt = SHIP_TEMPERATURE in self._stage.inputs
        self._thermometer = HeldTemperature(scene) if felt else None
        self._limits = Limits(scene)
        self._run: DialRun | None = None
        self._shown: ShownReading | None = None
        self._refused = dict.fromkeys(REFUSALS, 0)
        self._counts = {'dial_stops': 0, 'dial_settings': 0, 'runs_failed': 0}
        self._counts |= {'sensor_refused': 0, 'sensor_stuck': 0}
        self._trouble = ''
        self._news: list[str] = []
        self._watch = SensorWatch(scene.g)
        self._held: list[ImuSamples] | None = []
        self._told_ns: dict[str, int] = {}
        self._newest_ns, self._standing, self._step_ns = NOTHING_YET, 0, scene.step_ns
        self._log_ns, self._lookahead = scene.log_interval_ns, scene.samples_beyond_end + 2

    @property
    def inputs(self) -> tuple[str, ...]:
        """The motion, and the temperature if the machine depends on it."""
        return self._stage.inputs

    @property
    def trouble(self) -> str:
        """The reason why the dial stands still at present, empty if it runs."""
        if self._standing * self._step_ns > NS_PER_S:
            return (
                f'{_UNUSABLE}: its stamps stand still at {self._newest_ns / NS_PER_S:.3f} s. Let '
                'the driver stamp each sample with the time at which it was taken'
            )
        if ahead_s := self._continuity.holds_s:
            side = 'after' if ahead_s > 0.0 else 'before'
            return (
                'the dial stands still: ship/imu does not continue the last good '
                f'sample: its stamps are {abs(ahead_s):.6g} s {side} it'
            )
        return self._trouble

    def time_went_back(self) -> None:
        """Set the dial again when the stamps next go back: all time begins again, as in a bag."""
        self._all_back = True

    def reset(self) -> None:
        """Set the dial again at the next good sample."""
        self._anew = True
        self._continuity.restart()

    def news(self) -> list[str]:
        """Return a description of the changes of the dial since the last call."""
        news, self._news = self._news, []
        return news

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Take motion samples and return the samples that are known by now.

        Temperatures never delay them (`HeldTemperature`).
        """
        imu, felt = batches.get(SHIP_IMU), batches.get(SHIP_TEMPERATURE)
        if self._thermometer is not None and isinstance(felt, TemperatureSamples):
            self._thermometer.hear(felt)
        if not isinstance(imu, ImuSamples) or not len(imu.stamp_ns):
            return {}
        several, heard = len(imu.stamp_ns) > 1, len(self._news)
        before = self.state() if several else {}
        said: list[Batches] = []
        try:
            self._take(imu, said)
        except PropagationError as error:
            del self._news[heard:]
            if several:  # use all samples before the one that fails
                self.restore(before)
                ones = [take(imu, slice(k, k + 1)) for k in range(len(imu.stamp_ns))]
                return merged([self.feed({SHIP_IMU: one}) for one in ones])
            self._fail(str(error))
        return merged(said)

    def finish(self) -> Batches:
        """Return the remaining samples, interpolated with one-sided windows."""
        said: list[Batches] = []
        try:
            if self._held:
                self._test(take(self._held[0], slice(0, 0)), said, final=True)
            self._move(self._continuity.finish(), said)
            if self._run is not None:
                self._believe(self._stage.finish(), said)
        except PropagationError as error:
            self._fail(str(error))
        return merged(said)

    def _say(self, kind: str, now_ns: int, words: str) -> None:
        """Add a line to the news, at most one of a kind in `TOLD_S`."""
        before_ns = self._told_ns.get(kind)
        if before_ns is None or abs(now_ns - before_ns) >= TOLD_S * NS_PER_S:
            self._told_ns[kind] = now_ns
            self._news.append(words)

    def _moving(self, imu: ImuSamples) -> ImuSamples:
        """Return the samples without repeated stamps, and count these."""
        if not len(imu.stamp_ns):
            return imu
        moves = np.diff(imu.stamp_ns, prepend=self._newest_ns) != 0
        self._newest_ns = int(imu.stamp_ns[-1])
        after = len(moves) - 1 - int(np.flatnonzero(moves)[-1]) if moves.any() else 0
        self._standing = after if moves.any() else self._standing + len(moves)
        self._continuity.counts['duplicated'] += int(np.count_nonzero(~moves))
        return take(imu, moves)

    def _take(self, imu: ImuSamples, said: list[Batches]) -> None:
        reasons = refusal_reasons(imu, None, by_stamp=False)
        if reasons.any():
            for number, name in enumerate(REFUSALS, start=1):
                self._refused[name] += int(np.count_nonzero(reasons == number))
            imu = take(imu, reasons == 0)
        fault = f'({REFUSALS[reasons[-1] - 1]})' if reasons[-1] else ''
        imu = self._moving(imu)
        if len(imu.stamp_ns):
            stuck, words = self._watch.stuck(imu)
            self._counts['sensor_stuck'] += int(np.count_nonzero(stuck))
            imu, fault = take(imu, ~stuck), fault or words
            if words:
                self._say(words, self._newest_ns, f'{_UNUSABLE}: {words}')
                self._watch.begin()
                self._held = None if self._held is None else []
        while len(imu.stamp_ns):
            end = self._watch.feed(imu)
            self._test(take(imu, slice(0, end)), said)
            imu = take(imu, slice(end, None))
        if fault or self._held is None:
            self._trouble = fault and f'{_UNUSABLE}: {fault}'

    def _test(self, imu: ImuSamples, said: list[Batches], *, final: bool = False) -> None:
        """Use samples, unless their window shows a fault. Hold those of the first window."""
        held = self._held
        if held is not None:
            held += [imu] if len(imu.stamp_ns) else []
            final = bool(held) and (final or len(held) >= MOST_HELD)
        if final or self._watch.is_full:
            words = self._watch.fault()
            self._watch.begin(WINDOW_S)
            imu, self._held = join(held) if held else imu, [] if words else None
            if words:
                self._trouble = f'{_UNUSABLE}: {words}'
                self._say(words.rpartition(': ')[2], self._newest_ns, self._trouble)
                self._counts['sensor_refused'] += len(imu.stamp_ns)
                self._continuity.restart()
        if self._held is None:
            self._move(self._continuity.feed(imu, self._is_due), said)

    def _is_due(self, stamp_ns: int) -> bool:
        return self._run is not None and stamp_ns >= self._run.due_ns

    def _hasten(self, said: list[Batches]) -> None:
        """Publish the logged instants up to now, with the motion continued by a straight line.

        The wheel itself goes on with the measured motion, once that is complete.
        """
        due_ns = LATEST_NS if self._run is None else self._run.due_ns
        ahead = self._continuity.ahead(due_ns, self._lookahead)
        if ahead is None:
            return
        before, early, now_ns = self.state(), list[Batches](), self._continuity.last_ns
        try:
            self._believe(self._stage.feed(self._moved(ahead)), early, now_ns)
        except PropagationError:
            early = []
        run, shown = self._run, self._shown
        self.restore(before)
        if early:
            self._run, self._shown = run, shown
            said += early

    def _moved(self, imu: ImuSamples) -> Batches:
        """Return the stage's next input, with the temperatures that it needs."""
        self._limits.feel(imu)
        moved: Batches = {SHIP_IMU: imu}
        if self._thermometer is not None:
            moved[SHIP_TEMPERATURE] = self._thermometer.during(imu.stamp_ns)
        return moved

    def _move(self, parts: Iterable[MotionRun], said: list[Batches]) -> None:
        for part in parts:
            if part.begins:
                # a run without any reading is dropped
                if self._run is not None and self._run.due_ns > self._run.origin_ns:
                    self._believe(self._stage.finish(), said)
                self._begin(int(part.imu.stamp_ns[0]), part.stepped_ns)
            if len(part.imu.stamp_ns):
                self._believe(self._stage.feed(self._moved(part.imu)), said)
            self._hasten(said)

    def _begin(self, origin_ns: int, stepped_ns: int) -> None:
        """Release the wheel again, and account for the time since the last reading."""
        self._stage.restore(self._fresh)
        self._limits.begin()
        if self._thermometer is not None:
            self._thermometer.begin(origin_ns)
        shown = self._shown
        resets, self._all_back = self._resets or self._all_back, False
        if shown is None:
            self._run = DialRun(DialSetting(origin_ns), origin_ns, origin_ns, origin_ns)
            return
        stepped_ns = max(stepped_ns, shown.stamp_ns - origin_ns)
        back = f'the stamps of ship/imu went back by {stepped_ns / NS_PER_S:.6g} s: the dial '
        if shown.setting.set_ns < EPOCH_1990_NS <= origin_ns:  # the clock was set to no date
            back, resets, stepped_ns = 'the stamps of ship/imu have a date now: the dial ', True, 1
        if self._anew:
            back, resets, stepped_ns, self._anew = 'on request the dial ', True, 1, False
        if stepped_ns > 0 and resets:
            again = DialSetting(origin_ns, number=shown.setting.number + 1)
            self._run = DialRun(again, origin_ns, origin_ns, origin_ns)
            self._counts['dial_settings'] += 1
            self._news.append(f'{back}is set anew, to {origin_ns / NS_PER_S:.3f} s')
            return
        lost_ns, known = max(origin_ns - shown.stamp_ns, 0), shown.setting
        setting = replace(
            known,
            lost_ns=known.lost_ns + lost_ns,
            stops=known.stops + 1,
            unsure_ns=known.unsure_ns + max(stepped_ns, 0),
        )
        self._run = DialRun(setting, origin_ns, shown.dial_ns, origin_ns)
        self._counts['dial_stops'] += 1
        if stepped_ns > 0:
            self._news.append(
                f'{back}goes on from where it stood. How long it stood still is unknown: '
                'the estimate is less sure by that. reset_on_time_jump would set it anew'
            )
            return
        self._say(
            'break',
            origin_ns,
            f'ship/imu goes on after a break: the dial stood still for {lost_ns / NS_PER_S:.6g} '
            f's, until {origin_ns / NS_PER_S:.3f} s; in all {setting.lost_ns / NS_PER_S:.6g} s',
        )

    def _fail(self, why: str) -> None:
        self._run = None
        self._trouble = why
        self._counts['runs_failed'] += 1
        self._say('stop', self._newest_ns, f'the dial stopped: {why}')
        self._continuity.restart()

    def _believe(self, batches: Batches, said: list[Batches], until_ns: int = LATEST_NS) -> None:
        """Check the output of the stage, and add what is not published yet, up to `until_ns`."""
        run, wheel = self._run, batches.get(JOINT_STATES)
        if run is None or not isinstance(wheel, JointSamples) or not len(wheel.stamp_ns):
            return
        self._limits.check(wheel, run.origin_ns)
        fresh = {
            topic: take(part, (part.stamp_ns >= run.due_ns) & (part.stamp_ns <= until_ns))
            for topic, part in cast(dict[str, TimeSamples], batches).items()
        }
        reading = fresh[READING]
        if not len(reading.stamp_ns):
            return
        dial = reading.time_ref_ns + (run.base_ns - run.origin_ns)
        source, last_ns = same(run.setting.source(), len(dial)), int(reading.stamp_ns[-1])
        said.append({**fresh, READING: replace(reading, time_ref_ns=dial, source=source)})
        self._run = replace(run, due_ns=last_ns + self._log_ns)
        self._shown = ShownReading(last_ns, int(dial[-1]), run.setting)

    def health(self) -> dict[str, int]:
        """Return the numbers of refused and omitted samples, bridged gaps and stops."""
        slacks = {k: n for k, n in self._stage.health().items() if k == 'slacks'}
        return {**self._refused, **self._continuity.counts, **self._counts, **slacks}


@dataclass(frozen=True)
class DialRun:
    """A run: setting of the dial, start of the run, reading of the dial there; the next instant
    that is published.
    """

    setting: DialSetting
    origin_ns: int
    base_ns: int
    due_ns: int


@dataclass(frozen=True)
class ShownReading:
    """The last reading."""

    stamp_ns: int
    dial_ns: int
    setting: DialSetting
