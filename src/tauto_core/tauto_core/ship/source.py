"""The ship as a source of IMU samples, and of the navigator's observations of the time."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import fields
from typing import Any

import numpy as np

from tauto_core.samples import (
    SQUARABLE,
    FloatArray,
    ImuSamples,
    IntArray,
    SpatialImu,
    Stateful,
    TimeSamples,
)
from tauto_core.scene import Scene
from tauto_core.scene.times import NS_PER_S, nanoseconds
from tauto_core.ship.imu import (
    Sensed,
    ShipAngles,
    imu_from_motions,
    imu_from_roll,
    imu_samples,
    message,
)
from tauto_core.ship.motions import SixMotions
from tauto_core.ship.passage import GravityOnTheWay, Passage
from tauto_core.ship.sections import MOTIONS
from tauto_core.ship.waves import Fades, Harmonics, SampledFades, SampledHarmonics

# -----------------------------------------------------------------------------
# The navigator's observations of the true time (theory/navigator.md).

PORT, LANDFALL, LUNAR = 'port', 'landfall', 'lunar'
"""Values of `TimeReference.source` for observations."""

# Streams of random numbers from the seed, apart from the errors of observations in port.
_LUNARS, _CLOUDS = 0x6C756E61, 0x636C6F75


def schedule(scene: Scene) -> IntArray:
    """Return the stamps of the observations [ns], on the log grid, strictly increasing.

    In port there is one every `drift.observation_interval`, from the start until setting sail,
    both included. At each landfall there is one, at the second logged instant after it. At sea
    there are lunar distances if the scene has them. A scene without a voyage is in port
    throughout. Clouds may hide any but landfalls.
    """
    return Observations(scene).stamps


class Observations:
    """Observed times t_k + N(0, σ), with the σ of the port or of lunar distances.

    PCG64 seeded by (seed, k) draws the k-th error in port and at landfalls, so the error does not
    depend on earlier calls. Separate streams draw the errors of lunar distances and the clouds in
    the same way.

    Attributes:
        stamps: of the observations, see `schedule`.
    """

    def __init__(self, scene: Scene) -> None:
        self._seed, drift = scene.seed, scene.drift
        passage = None if scene.voyage is None else Passage(scene, scene.voyage)
        # landfall is logged at the first logged instant after the ship passes the land, and the
        # clock is checked at the next one: the estimate at the landfall is older than the check
        log_ns, passed = scene.log_interval_ns, () if passage is None else passage.landfalls_ns
        checked = {log_ns * (1 - (-time // log_ns)) for time in passed}
        in_scene = sorted(time for time in checked if time <= scene.duration_ns)
        fixes = scene.starts_at_ns + np.array(in_scene, np.int64)
        end = scene.duration_ns if passage is None else min(passage.sails_ns, scene.duration_ns)
        interval = nanoseconds(drift.observation_interval)
        in_port = scene.starts_at_ns + np.arange(0, end + 1, interval, dtype=np.int64)
        stamps = np.union1d(in_port, fixes)
        errors = {
            int(stamp): (LANDFALL if stamp in fixes else PORT, k, drift.observation_sigma)
            for k, stamp in enumerate(stamps)
        }
        if drift.lunars is not None and passage is not None:
            # multiples of their interval between the ports
            interval = nanoseconds(drift.lunars.interval)
            begin = passage.sails_ns // interval + 1
            stop = min(passage.arrives_ns - 1, scene.duration_ns) // interval
            at_sea = scene.starts_at_ns + interval * np.arange(begin, stop + 1, dtype=np.int64)
            lunars = np.setdiff1d(at_sea, stamps)
            errors |= {
                int(stamp): (LUNAR, k, drift.lunars.sigma) for k, stamp in enumerate(lunars)
            }
        self._drawn = {
            stamp: errors[stamp]
            for stamp in sorted(errors)
            if errors[stamp][0] == LANDFALL or not self._hidden(stamp, drift.clouds)
        }
        self.stamps: IntArray = np.array(list(self._drawn), np.int64)

    def between(self, first_ns: int, last_ns: int) -> TimeSamples:
        """Return the observations with first_ns <= stamp < last_ns.

        `time_ref_ns` is the observed time, rounded to the nanosecond, and `source` is `port`,
        `landfall` or `lunar`.
        """
        begin, end = np.searchsorted(self.stamps, [first_ns, last_ns])
        stamps = self.stamps[begin:end]
        drawn = [self._drawn[int(stamp)] for stamp in stamps]
        errors = np.empty(len(drawn), np.int64)
        for row, (kind, k, sigma) in enumerate(drawn):
            seeds = np.random.SeedSequence([self._seed, k])
            if kind == LUNAR:
                seeds = np.random.SeedSequence(self._seed, spawn_key=(_LUNARS, k))
            normal = np.random.Generator(np.random.PCG64(seeds)).standard_normal()
            errors[row] = round(NS_PER_S * sigma * float(normal))
        source = np.empty(len(stamps), object)
        source[:] = [draw[0] for draw in drawn]
        return TimeSamples(stamps, '', stamps + errors, source)

    def _hidden(self, stamp_ns: int, share: float) -> bool:
        """Return whether clouds hide an observation at a time."""
        if share == 0.0:
            return False
        seeds = np.random.SeedSequence(self._seed, spawn_key=(_CLOUDS, *divmod(stamp_ns, 10**9)))
        return float(np.random.Generator(np.random.PCG64(seeds)).random()) < share


KEPT_BYTES = 2**24
"""Memory of the arrays of a chunk (`voyage.QUIET_CHUNK`)."""


class ShipMotion(Stateful):
    """IMU samples k = 0 ... scene.samples - 1, and the later ones that the stages need.

    Sample k is stamped starts_at + k step. Its bits depend on scene and k alone. A ship at rest
    sends one constant sample per log interval.

    Args:
        scene: the scene.
        without: motions of `Channels` to switch off, or `gravity`, to keep it constant, which
            shows the effect of each on the clock.

    Attributes:
        total: number of samples in all.
        metadata: origin of the motion: kind, spectrum, pass-band, seed and the like.
        warnings: peculiarities of measured motion, or waves that a sea leaves out.
        moves: the motions that may be switched off, see `Channels.moves`.

    Raises:
        MotionDataError: measured motion that cannot be used.
        SceneError: a sea with waves too short for `ship.rate` or outside `ship.rao`.
    """

    state_names = ('next',)

    def __init__(self, scene: Scene, without: Collection[str] = ()) -> None:
        self._scene = scene
        self._starts_at_ns, self._step_ns = scene.starts_at_ns, scene.step_ns
        self._next = 0
        channels = scene.ship.channels(scene)
        self.moves = channels.moves()
        if without:
            channels = channels.without(without)
        if channels.roll is not None:
            # Makes the allocator keep a chunk's memory for the next one: mapping a page again
            # costs as much time as several samples. In glibc the largest block mapped and freed
            # sets the thresholds of mapping and returning memory (mallopt(3), M_MMAP_THRESHOLD).
            np.empty(KEPT_BYTES, np.uint8)
        self.total = scene.samples + scene.samples_beyond_end
        self.metadata: dict[str, Any] = {'kind': scene.ship.kind, **channels.metadata}
        self.warnings = channels.warnings
        self._roll, self._heave, self._force_y, self._force_z = (
            _sampled(motion, scene)
            for motion in (channels.roll, channels.heave, channels.force_y, channels.force_z)
        )
        self._gravity: GravityOnTheWay | None = None
        # a measured force contains the gravity of the place of measurement
        changes = scene.gravity == 'normal' and 'gravity' not in without
        if changes and scene.voyage is not None and channels.force_z is None:
            self._gravity = GravityOnTheWay(Passage(scene, scene.voyage), scene.duration_ns)
        six = channels.six
        self._six: list[SampledHarmonics | SampledFades] | None = None
        if six is not None:
            # in the order of `SixMotions`
            parts = (getattr(six, item.name) for item in fields(six))
            self._six = [sums for part in parts if (sums := _sampled(part, scene)) is not None]
        # far from overflow, so every sample will be accepted
        self._is_tame = True
        if six is not None:
            self._is_tame = _is_tame(six)
        elif channels.roll is not None:
            angle, rate, bend = (channels.roll.most(order) for order in range(3))
            force = scene.g + (0.0 if channels.heave is None else channels.heave.most(2))
            force += abs(scene.ship.height) * (bend + rate * rate)
            self._is_tame = max(angle, rate, force) < SQUARABLE

    def produce(self, count: int) -> ImuSamples:
        """Return the next samples, at most `count`, or an empty batch at the end."""
        return message(self.sense(count))

    def sense(self, count: int) -> Sensed:
        """Return the same as `produce`, possibly without fields that a clock does not need."""
        start = self._next
        stop = min(start + count, self.total)
        self._next = stop
        begin, end = (self._starts_at_ns + self._step_ns * k for k in (start, stop))
        stamps = np.arange(begin, end, self._step_ns, dtype=np.int64)
        if self._roll is None or start == stop:
            zero = np.zeros(stop - start)
            return imu_from_roll(stamps, zero, zero, zero, self._weighs(stamps))
        if self._force_y is not None and self._force_z is not None:
            roll, rate = self._roll.between(start, stop, 0, 1)
            y, z = (f.between(start, stop, 0)[0] for f in (self._force_y, self._force_z))
            return imu_from_roll(stamps, roll, rate, y, z)

        def sensed(turning: bool, with_force: bool, rows: slice) -> ImuSamples:
            begin, end, _ = rows.indices(len(stamps))
            return self._sensed(stamps[begin:end], start + begin, turning, with_force)

        imu = SpatialImu(stamps, sensed, start)
        return imu if self._is_tame else message(imu)

    def _sensed(self, stamps: IntArray, start: int, turning: bool, with_force: bool) -> ImuSamples:
        """Return samples with angular velocity and specific force on request."""
        stop = start + len(stamps)
        if self._six is None:
            assert self._roll is not None
            height, gravity = self._scene.ship.height, self._scene.g
            highest = 2 if with_force and height != 0.0 else int(turning)
            motions = self._roll.between(start, stop, *range(1 + highest))
            roll, rate, bend, *_ = (*motions, None, None)
            up = None
            if with_force and self._heave is not None:
                up = self._heave.between(start, stop, 2)[0]
            if with_force and self._gravity is not None:
                # gravity that changes on the way adds a slow acceleration to the heave
                lift = self._weighs(stamps) - gravity
                up = lift if up is None else up + lift
            return imu_samples(
                stamps, roll, rate, bend, up, height, gravity, turning=turning, felt=with_force
            )
        turned = [motion.between(start, stop, *range(1 + turning)) for motion in self._six[3:]]
        angle, *rates = (ShipAngles(*angles) for angles in zip(*turned, strict=True))
        force = None
        if with_force:
            forward, port, up = (motion.between(start, stop, 2)[0] for motion in self._six[:3])
            force = forward, port, up
        weight = self._weighs(stamps) if with_force else 0.0
        return imu_from_motions(stamps, angle, rates[0] if rates else None, force, weight)

    def _weighs(self, stamps: IntArray) -> FloatArray:
        """Return gravity, less Eötvös' term, at some stamps [m/s²]."""
        if self._gravity is None:
            return np.full(len(stamps), self._scene.g)
        return self._gravity.at(stamps - self._starts_at_ns)


def bag_metadata(scene: Scene) -> dict[str, Any]:
    """Return the metadata of the ship's motion in a bag, by names such as `sea.seed`."""
    ship = scene.ship
    return {f'{ship.reported_as}.{key}': value for key, value in ship.metadata(scene).items()}


GENTLE_PITCH = 1.0
"""Bound of the pitch in one sea [rad]. It is √2 times as large in a change of seas, and the roll
is undefined at π/2.
"""


def _is_tame(six: SixMotions[Harmonics] | SixMotions[Fades]) -> bool:
    """Return whether all samples are sure to be accepted.

    All seas are computed, so a hull refuses any of them at the start.
    """
    sums = six.pitch.sums if isinstance(six.pitch, Fades) else (0,)
    for number in dict.fromkeys(sums):  # sea by sea: a hull computes all motions of a sea at once
        for name in MOTIONS:
            motion = getattr(six, name)
            part = motion.of(number) if isinstance(motion, Fades) else motion
            if part is None:
                continue
            size = max(part.most(order) for order in range(3))
            if size > 1e-2 * SQUARABLE or (name == 'pitch' and part.most(0) > GENTLE_PITCH):
                return False
    return True


def _sampled(
    motion: Harmonics | Fades | None, scene: Scene
) -> SampledHarmonics | SampledFades | None:
    if isinstance(motion, Fades):
        return SampledFades(motion, scene.step_ns)
    return None if motion is None else SampledHarmonics(motion, scene.step_ns)
