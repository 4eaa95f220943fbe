"""A voyage as arrays: all data of a run or a bag, each array named with its unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from tauto_core import replaying, voyage
from tauto_core.bags import BagWriter, check_folder, read_bag
from tauto_core.bags.writer import CUT_SHORT
from tauto_core.call_words import in_words_of_calls
from tauto_core.navigation.drift import MEAN_RATE_NAMES
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    JOINT_STATES,
    LONGITUDE_ERROR,
    LONGITUDE_FIX,
    NS_PER_S,
    OBSERVATION,
    PHASE,
    READING,
    SCENE,
    SHIP_FIX,
    SHIP_IMU,
    Batches,
    FixSamples,
    FloatArray,
    ImuSamples,
    JointSamples,
    Samples,
    TimeSamples,
    join,
    text,
)
from tauto_core.scene import Scene, scene_yaml
from tauto_core.ship import bag_metadata
from tauto_core.ship.imu import attitude

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

Kind = TypeVar('Kind', bound=Samples)

_NONE = np.empty(0)
_STATED = (SHIP_IMU, SHIP_FIX, OBSERVATION, JOINT_STATES, PHASE)
"""Topics, besides the scene, that a replay does not compute again."""


@dataclass(frozen=True, eq=False, repr=False)
class Voyage:
    """The data of a clock on a voyage.

    Arrays are (n,) with one value for each logged sample, at `time_s` from the start, in seconds
    and radians. Those that begin with `motion_` have the full rate of the ship's motion, and are
    empty where the voyage does not log it (`log.motion`). Arrays that a bag does not have are
    empty.

    Attributes:
        scene: the scene that was sailed.
        result: the figures, as `tauto sail --json` and `tauto replay --json` print them.
        samples: the contents of the messages, by topic and field.
    """

    scene: Scene
    result: Mapping[str, Any]
    samples: Mapping[str, Samples]

    def __repr__(self) -> str:
        return f'<Voyage of {self.scene.name}: {self.answer}>'

    @property
    def answer(self) -> str:
        """How far wrong the clock would put the ship, in a sentence."""
        return str(self.result['answer'])

    @cached_property
    def start_ns(self) -> int:
        """Stamp of the first reading [ns]."""
        return int(self._of(READING, TimeSamples).stamp_ns[0])

    @cached_property
    def time_s(self) -> FloatArray:
        """True time since the first reading [s]."""
        return self._seconds(READING)

    @cached_property
    def clock_error_s(self) -> FloatArray:
        """Reading of the dial less the true time [s], fast is positive."""
        return self._error(READING)

    @cached_property
    def corrected_error_s(self) -> FloatArray:
        """Reading less its estimated error, less the true time [s]."""
        return self._error(CORRECTED)

    @property
    def offset_s(self) -> FloatArray:
        """Estimated error of the dial [s]."""
        return self._named(ESTIMATE, 'offset_s')

    @property
    def offset_sigma_s(self) -> FloatArray:
        """Standard deviation of `offset_s` [s]."""
        return self._named(ESTIMATE, 'offset_sigma_s')

    @property
    def rate_s_per_day(self) -> FloatArray:
        """Estimated rate of the dial [s/day], fast is positive; with covariates that at rest."""
        return self._named(ESTIMATE, 'rate_s_per_day')

    @property
    def mean_rate_s_per_day(self) -> FloatArray:
        """Estimated rate [s/day]; with covariates its mean since the start."""
        return self._mean_rate(MEAN_RATE_NAMES[0], 'rate_s_per_day')

    @property
    def mean_rate_sigma_s_per_day(self) -> FloatArray:
        """Standard deviation of `mean_rate_s_per_day` [s/day]."""
        return self._mean_rate(MEAN_RATE_NAMES[1], 'rate_sigma_s_per_day')

    def _mean_rate(self, name: str, steady: str) -> FloatArray:
        if ESTIMATE not in self.samples:
            return _NONE
        named = self._of(ESTIMATE, JointSamples).name
        return self._named(ESTIMATE, name if name in named else steady)

    @property
    def rate_sigma_s_per_day(self) -> FloatArray:
        """Standard deviation of `rate_s_per_day` [s/day]."""
        return self._named(ESTIMATE, 'rate_sigma_s_per_day')

    @property
    def angle_rad(self) -> FloatArray:
        """Angle of the wheel in its case [rad]; for a body in a fluid its arc [m]."""
        return self._joint('position')

    @property
    def angular_velocity_rad_s(self) -> FloatArray:
        """Angular velocity of the wheel in its case [rad/s]; in a fluid the body's speed [m/s]."""
        return self._joint('velocity')

    @property
    def phase_rad(self) -> FloatArray:
        """Phase of the swing since the release [rad], 2π per period."""
        return self._named(PHASE, 'phase')

    @property
    def raw_longitude_error_nmi(self) -> FloatArray:
        """Error of the ship's longitude by the dial, to the east [nautical miles]."""
        return self._named(LONGITUDE_ERROR, 'raw_error_nmi')

    @property
    def longitude_error_nmi(self) -> FloatArray:
        """Error of the ship's longitude by the corrected clock, to the east [nautical miles]."""
        return self._named(LONGITUDE_ERROR, 'error_nmi')

    @property
    def longitude_sigma_nmi(self) -> FloatArray:
        """Standard deviation of `longitude_error_nmi` [nautical miles]."""
        return self._named(LONGITUDE_ERROR, 'sigma_nmi')

    @property
    def latitude_deg(self) -> FloatArray:
        """True latitude of the ship [degrees north]."""
        return self._place(SHIP_FIX, 'latitude')

    @property
    def longitude_deg(self) -> FloatArray:
        """True longitude of the ship [degrees east]."""
        return self._place(SHIP_FIX, 'longitude')

    @property
    def clock_longitude_deg(self) -> FloatArray:
        """Longitude of the ship by the corrected clock [degrees east]."""
        return self._place(LONGITUDE_FIX, 'longitude')

    @cached_property
    def observation_time_s(self) -> FloatArray:
        """Times at which the clock was compared with the true time, from the first reading [s]."""
        return self._seconds(OBSERVATION)

    @cached_property
    def observed_error_s(self) -> FloatArray:
        """Reading at `observation_time_s`, less the true time as it was observed [s]."""
        if OBSERVATION not in self.samples:
            return _NONE
        found = self._of(OBSERVATION, TimeSamples)
        noise = (found.time_ref_ns - found.stamp_ns) / NS_PER_S
        return np.interp(self.observation_time_s, self.time_s, self.clock_error_s) - noise

    @cached_property
    def motion_time_s(self) -> FloatArray:
        """Time of the motion's samples, from the first reading [s]."""
        return self._seconds(SHIP_IMU)

    @cached_property
    def motion_roll_rad(self) -> FloatArray:
        """Roll of the ship [rad], starboard side down is positive."""
        if SHIP_IMU not in self.samples:
            return _NONE
        return attitude(self._of(SHIP_IMU, ImuSamples)).roll

    @cached_property
    def roll_rad(self) -> FloatArray:
        """Roll of the ship at `time_s` [rad]; empty where the voyage does not log its motion."""
        if not len(self.motion_time_s):
            return _NONE
        return np.interp(self.time_s, self.motion_time_s, self.motion_roll_rad)

    @cached_property
    def motion_gravity_m_s2(self) -> FloatArray:
        """Apparent gravity at the clock, the size of the specific force [m/s2]."""
        if SHIP_IMU not in self.samples:
            return _NONE
        force = self._of(SHIP_IMU, ImuSamples).linear_acceleration
        size: FloatArray = np.sqrt(np.square(force).sum(axis=1))
        return size

    def plot(
        self,
        what: str,
        file: str | Path | None = None,
        *,
        from_s: float | None = None,
        to_s: float | None = None,
    ) -> Figure:
        """Draw a picture of the voyage; see `tauto_core.plot`."""
        from tauto_core.pictures import picture

        with in_words_of_calls(out='file'):
            return picture(self, what, file, from_s=from_s, to_s=to_s)

    def write(self, bag: str | Path, *, force: bool = False) -> None:
        """Write a rosbag2 folder, with the messages that `tauto sail --out` writes.

        Args:
            bag: the folder, which must not exist.
            force: replace a bag that is there.

        Raises:
            BagError: the folder may not be written to.
        """
        folder = Path(bag)
        with in_words_of_calls():
            check_folder(folder, force=force)
        with BagWriter(folder, force=force) as writer:
            writer.describe(bag_metadata(self.scene))
            if self.result.get('damage'):
                writer.describe(CUT_SHORT)
            kept = dict(self.samples)
            kept.setdefault(SCENE, text(self.start_ns, scene_yaml(self.scene)))
            writer.write(kept)

    def _of(self, topic: str, kind: type[Kind]) -> Kind:
        samples = self.samples[topic]
        assert isinstance(samples, kind)
        return samples

    def _seconds(self, topic: str) -> FloatArray:
        if topic not in self.samples:
            return _NONE
        return (self.samples[topic].stamp_ns - self.start_ns) / NS_PER_S

    def _error(self, topic: str) -> FloatArray:
        if topic not in self.samples:
            return _NONE
        found = self._of(topic, TimeSamples)
        return (found.time_ref_ns - found.stamp_ns) / NS_PER_S

    def _named(self, topic: str, name: str) -> FloatArray:
        if topic not in self.samples:
            return _NONE
        found = self._of(topic, JointSamples)
        return found.position[:, found.name.index(name)]

    def _joint(self, field: str) -> FloatArray:
        if JOINT_STATES not in self.samples:
            return _NONE
        return cast(FloatArray, getattr(self._of(JOINT_STATES, JointSamples), field)[:, 0])

    def _place(self, topic: str, field: str) -> FloatArray:
        if topic not in self.samples:
            return _NONE
        return cast(FloatArray, getattr(self._of(topic, FixSamples), field))


class _Gathered:
    """Batches of all topics, joined at the end."""

    def __init__(self, *, motion: bool) -> None:
        self._motion = motion
        self._parts: dict[str, list[Any]] = {}

    def take(self, batches: Batches) -> None:
        for topic, samples in batches.items():
            if topic != SHIP_IMU or self._motion:
                self._parts.setdefault(topic, []).append(samples)

    def joined(self) -> Batches:
        return {topic: join(parts) for topic, parts in self._parts.items()}


def sail_voyage(
    scene: Scene,
    *,
    origin: str | None = None,
    anyway: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Voyage:
    """Return the voyage of a scene, sailed offline.

    Args:
        scene: the scene to simulate.
        origin: file or name that the user gave, for errors.
        anyway: sail machines and ships beyond all that are known, too.
        progress: called with the fraction done, from 0 to 1.

    Raises:
        TautoError: see `voyage.sail`.
    """
    gathered = _Gathered(motion=scene.keeps_motion)
    result = voyage.sail(
        scene, origin=origin, anyway=anyway, progress=progress, watch=gathered.take
    )
    return Voyage(scene, result, gathered.joined())


def replay_voyage(
    path: Path, scene: Scene | None = None, *, smooth: bool = False, stable: bool = False
) -> Voyage:
    """Return the voyage in a bag, with drift and longitude estimated anew.

    Args:
        path: rosbag2 folder or MCAP file.
        scene, smooth, stable: as for `replaying.replay`.

    Raises:
        BagError: not a bag, no readings, or no scene.
        EstimationError: readings whose stability cannot be estimated.
        SceneError: the bag's scene cannot be read.
    """
    bag = read_bag(path)
    sailed = replaying.bag_scene(bag, scene)
    gathered = _Gathered(motion=True)
    result = replaying.replay(
        bag, scene=sailed, smooth=smooth, stable=stable, topics=_STATED, watch=gathered.take
    )
    told = {} if bag.scenes is None else {SCENE: bag.scenes}
    return Voyage(sailed, result, {**told, **gathered.joined()})
