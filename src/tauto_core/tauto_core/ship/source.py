"""The ship as a source of IMU samples."""

from __future__ import annotations

from typing import Any

import numpy as np

from tauto_core.samples import ImuSamples, State
from tauto_core.scene import Scene
from tauto_core.ship.imu import imu_from_roll, imu_samples
from tauto_core.ship.waves import Harmonics, SampledHarmonics

KEPT_BYTES = 2**24
"""Twice what the arrays of a chunk take (`voyage.CHUNK`)."""


class ShipMotion:
    """IMU samples k = 0 ... scene.samples - 1, and what the stages need beyond the end.

    Sample k is stamped starts_at + k step. Its bits depend on scene and k alone. A ship that lies
    still sends one constant sample per log interval.

    Attributes:
        total: number of samples in all.
        metadata: what the motion was made from: kind, and spectrum, pass-band, seed ... where
            they apply.
        warnings: what was odd about measured motion, or left out of a sea.

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
        measured = channels.force_y is not None
        turned = measured or scene.ship.height == 0.0
        self._roll = _sampled(channels.roll, scene, (0, 1) if turned else (0, 1, 2))
        self._heave = _sampled(channels.heave, scene, (2,))
        self._force_y = _sampled(channels.force_y, scene, (0,))
        self._force_z = _sampled(channels.force_z, scene, (0,))

    def produce(self, count: int) -> ImuSamples:
        """Return the next samples, at most `count`; an empty batch at the end.

        Args:
            count: >= 0.
        """
        first = self._next
        last = min(first + count, self.total)
        self._next = last
        return self._samples(first, last)

    def roll_at_start(self) -> float:
        """Return the roll of the first sample [rad]."""
        if self._roll is None:
            return 0.0
        return float(self._roll.between(0, 1)[0][0])

    def state(self) -> State:
        """Return all that the next output depends on."""
        return {'next': self._next}

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self._next = int(state['next'])

    def _samples(self, first: int, last: int) -> ImuSamples:
        scene = self._scene
        begin, end = (self._starts_at_ns + self._step_ns * k for k in (first, last))
        stamps = np.arange(begin, end, self._step_ns, dtype=np.int64)
        if self._roll is None or first == last:
            zero = np.zeros(last - first)
            return imu_from_roll(stamps, zero, zero, zero, zero + scene.gravity)
        roll = self._roll.between(first, last)
        if self._force_y is not None and self._force_z is not None:
            force_y, force_z = (f.between(first, last)[0] for f in (self._force_y, self._force_z))
            return imu_from_roll(stamps, roll[0], roll[1], force_y, force_z)
        heave = None if self._heave is None else self._heave.between(first, last)[0]
        acceleration = roll[2] if len(roll) > 2 else None
        return imu_samples(
            stamps, roll[0], roll[1], acceleration, heave, scene.ship.height, scene.gravity
        )


def _keep_freed_memory() -> None:
    """Let the allocator keep what a chunk of samples frees, for the next chunk.

    Memory given back to the system comes back page by page, each at the price of some samples.
    Under glibc what has once been mapped and freed sets the least that is mapped, and twice that
    the least that is given back (mallopt(3), M_MMAP_THRESHOLD); elsewhere it does nothing.
    """
    np.empty(KEPT_BYTES, np.uint8)


def bag_metadata(scene: Scene) -> dict[str, Any]:
    """Return what a bag says of the ship's motion, by names such as `sea.seed`; or nothing."""
    ship = scene.ship
    return {f'{ship.reported_as}.{key}': value for key, value in ship.metadata(scene).items()}


def _sampled(
    harmonics: Harmonics | None, scene: Scene, orders: tuple[int, ...]
) -> SampledHarmonics | None:
    return None if harmonics is None else SampledHarmonics(harmonics, scene.step_ns, orders)
