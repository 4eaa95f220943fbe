"""The ship as a source of IMU samples."""

from __future__ import annotations

from typing import Any

import numpy as np

from tauto_core.samples import FloatArray, ImuSamples, PlanarImu, State
from tauto_core.scene import Scene
from tauto_core.ship.fading import Fades, SampledFades
from tauto_core.ship.imu import imu_from_roll
from tauto_core.ship.planar import message
from tauto_core.ship.waves import Harmonics, SampledHarmonics

LARGEST = 1e150
"""Larger values might overflow when they are squared."""

KEPT_BYTES = 2**24
"""Memory that the arrays of a chunk take (`voyage.QUIET_CHUNK`)."""


class ShipMotion:
    """IMU samples k = 0 ... scene.samples - 1, and those that the stages need beyond the end.

    Sample k is stamped starts_at + k step. Its bits depend on scene and k alone. A ship that lies
    still sends one constant sample per log interval.

    Attributes:
        total: number of samples in all.
        metadata: origin of the motion: kind, and spectrum, pass-band, seed ... where they apply.
        warnings: anything odd about measured motion, or left out of a sea.

    Raises:
        MotionDataError: measured motion that cannot be used.
        SceneError: a sea whose waves are too short for `ship.rate` or lie outside `ship.rao`.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._starts_at_ns, self._step_ns = scene.starts_at_ns, scene.step_ns
        self._next = 0
        channels = scene.ship.channels(scene)
        if channels.roll is not None:
            _keep_freed_memory()
        self.total = scene.samples + scene.samples_beyond_end
        self.metadata: dict[str, Any] = {'kind': scene.ship.kind, **channels.metadata}
        self.warnings = channels.warnings
        self._roll = _sampled(channels.roll, scene)
        self._heave = _sampled(channels.heave, scene)
        self._force_y = _sampled(channels.force_y, scene)
        self._force_z = _sampled(channels.force_z, scene)
        # in weather the acceleration of roll needs the other two, so one pass makes all three
        with_bend = isinstance(self._roll, SampledFades) and scene.ship.height != 0.0
        self._orders = (0, 1, 2) if with_bend else (0, 1)
        self._is_planar = _stays_finite(channels.roll, channels.heave, scene)

    def produce(self, count: int) -> ImuSamples:
        """Return the next samples, at most `count`; an empty batch at the end.

        Args:
            count: >= 0.
        """
        imu = self.sense(count)
        return message(imu) if isinstance(imu, PlanarImu) else imu

    def sense(self, count: int) -> ImuSamples | PlanarImu:
        """Return the same as `produce`, possibly without fields that a clock does not need."""
        first = self._next
        last = min(first + count, self.total)
        self._next = last
        return self._samples(first, last)

    def roll_at_start(self) -> float:
        """Return the roll of the first sample [rad]."""
        if self._roll is None:
            return 0.0
        return float(self._roll.between(0, 1, 0)[0][0])

    def state(self) -> State:
        """Return all that the next output depends on."""
        return {'next': self._next}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._next = int(state['next'])

    def _samples(self, first: int, last: int) -> ImuSamples | PlanarImu:
        scene = self._scene
        begin, end = (self._starts_at_ns + self._step_ns * k for k in (first, last))
        stamps = np.arange(begin, end, self._step_ns, dtype=np.int64)
        if self._roll is None or first == last:
            zero = np.zeros(last - first)
            return imu_from_roll(stamps, zero, zero, zero, zero + scene.gravity)
        roll, rate, *bend = self._roll.between(first, last, *self._orders)
        if self._force_y is not None and self._force_z is not None:
            y, z = (f.between(first, last, 0)[0] for f in (self._force_y, self._force_z))
            return imu_from_roll(stamps, roll, rate, y, z)
        turning, heave = self._roll if scene.ship.height else None, self._heave

        def accelerations() -> tuple[FloatArray | None, FloatArray | None]:
            if turning is not None and not bend:
                bend.extend(turning.between(first, last, 2))
            up = None if heave is None else heave.between(first, last, 2)[0]
            return (bend[0] if bend else None), up

        imu = PlanarImu(stamps, roll, rate, accelerations, scene.ship.height, scene.gravity)
        return imu if self._is_planar else message(imu)


def _keep_freed_memory() -> None:
    """Make the allocator keep the memory that a chunk of samples frees, for the next chunk.

    Memory returned to the system has to be mapped again page by page, and each page costs as much
    time as several samples. Under glibc the largest block that was mapped and freed becomes the
    threshold of mapping, and twice that the threshold of returning memory (mallopt(3),
    M_MMAP_THRESHOLD); elsewhere this has no effect.
    """
    np.empty(KEPT_BYTES, np.uint8)


def bag_metadata(scene: Scene) -> dict[str, Any]:
    """Return the metadata of the ship's motion in a bag, by names such as `sea.seed`."""
    ship = scene.ship
    return {f'{ship.reported_as}.{key}': value for key, value in ship.metadata(scene).items()}


def _stays_finite(
    roll: Harmonics | Fades | None, heave: Harmonics | Fades | None, scene: Scene
) -> bool:
    """Return whether all values are so far from overflow that no sample can be refused."""
    if roll is None:
        return True
    angle, rate, bend = (roll.most(order) for order in range(3))
    force = scene.gravity + (0.0 if heave is None else heave.most(2))
    force += abs(scene.ship.height) * (bend + rate * rate)
    return max(angle, rate, force) < LARGEST


def _sampled(
    motion: Harmonics | Fades | None, scene: Scene
) -> SampledHarmonics | SampledFades | None:
    if isinstance(motion, Fades):
        return SampledFades(motion, scene.step_ns)
    return None if motion is None else SampledHarmonics(motion, scene.step_ns)
