"""Samples: the data between the stages, with the fields of the ROS messages.

A batch has n time-ordered samples. Its arrays have the sample on the first axis. Stamps are
integer nanoseconds, strictly increasing within a topic. Units are radians and metres, in
`NavSatFix` degrees as in ROS.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Protocol, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]

SCENE = 'scene'
SHIP_IMU = 'ship/imu'
SHIP_FIX = 'ship/fix'
SHIP_TEMPERATURE = 'ship/temperature'
JOINT_STATES = 'trochlea/joint_states'
PHASE = 'trochlea/phase'
SLACK = 'trochlea/slack'
READING = 'clock/reading'
OBSERVATION = 'clock/observation'
CORRECTED = 'clock/corrected'
ESTIMATE = 'drift/estimate'
LONGITUDE_FIX = 'longitude/fix'
LONGITUDE_ERROR = 'longitude/error'


@dataclass(frozen=True)
class TextSamples:
    """std_msgs/String. The message has no header: `stamp_ns` is the log time."""

    stamp_ns: IntArray
    data: NDArray[np.object_]


@dataclass(frozen=True)
class ImuSamples:
    """sensor_msgs/Imu: attitude, angular velocity [rad/s], specific force [m/s2].

    `orientation` is (x, y, z, w), shape (n, 4). The vectors are (n, 3) in the sensor's frame, +g
    on z at rest. Covariances are (n, 9), row-major (all zero: unknown, first element -1: absent).
    """

    stamp_ns: IntArray
    frame_id: str
    orientation: FloatArray
    orientation_covariance: FloatArray
    angular_velocity: FloatArray
    angular_velocity_covariance: FloatArray
    linear_acceleration: FloatArray
    linear_acceleration_covariance: FloatArray

    def __deepcopy__(self, _: object) -> ImuSamples:
        """Return the samples themselves, since they are never changed."""
        return self


SQUARABLE = 1e150
"""Largest number with a finite square, roughly."""

IN_CACHE = 16_384
"""Samples of a simulated ship that are made at once: their arrays fit the processor's L2 cache.

A multiple of the blocks in which waves are summed (`ship.waves.SUM_BLOCK`).
"""


@dataclass(frozen=True)
class SpatialImu:
    """The motion of a simulated ship, from which the needed fields of `ImuSamples` are computed.

    All samples pass `ship.imu.screen`, and the stamps continue the previous batch.
    """

    stamp_ns: IntArray
    samples: Callable[[bool, bool, slice], ImuSamples]
    """Returns the samples of some rows, on request with angular velocity (first argument) and
    specific force (second). A channel left out has the shape (0, 3)."""
    first: int = 0
    """Number of the first sample since the ship's start."""

    def parts(self, turning: bool, felt: bool) -> Iterator[tuple[slice, ImuSamples]]:
        """Yield rows and their samples, in parts that fit the cache."""
        begin, total = 0, len(self.stamp_ns)
        while begin < total:
            end = min(begin + IN_CACHE - (self.first + begin) % IN_CACHE, total)
            rows = slice(begin, end)
            yield rows, self.samples(turning, felt, rows)
            begin = end


@dataclass(frozen=True)
class HungImu:
    """The motion of a suspended case. Stamps continue the previous batch."""

    stamp_ns: IntArray
    tilt: FloatArray
    """φ of the case [rad], unwrapped."""
    rate: FloatArray
    """φ̇ [rad/s]."""
    lean: FloatArray
    """Direction of the specific force in the case, positive to starboard [rad]."""
    pull: FloatArray
    """Magnitude of the specific force [m/s2], negative if it points to the top of the case."""


@dataclass(frozen=True)
class JointSamples:
    """sensor_msgs/JointState, also used for named scalars with a stamp.

    `position` is (n, len(name)). `velocity` and `effort` are the same, or (n, 0) if absent.
    """

    stamp_ns: IntArray
    frame_id: str
    name: tuple[str, ...]
    position: FloatArray
    velocity: FloatArray
    effort: FloatArray


@dataclass(frozen=True)
class TimeSamples:
    """sensor_msgs/TimeReference: `time_ref_ns` as read on some clock at true time `stamp_ns`."""

    stamp_ns: IntArray
    frame_id: str
    time_ref_ns: IntArray
    source: NDArray[np.object_]


@dataclass(frozen=True)
class FixSamples:
    """sensor_msgs/NavSatFix: degrees, north and east positive, covariance (n, 9) ENU [m2]."""

    stamp_ns: IntArray
    frame_id: str
    status: NDArray[np.int8]
    service: NDArray[np.uint16]
    latitude: FloatArray
    longitude: FloatArray
    altitude: FloatArray
    position_covariance: FloatArray
    position_covariance_type: NDArray[np.uint8]


@dataclass(frozen=True)
class TemperatureSamples:
    """sensor_msgs/Temperature: degrees Celsius, variance [K2], 0 if unknown."""

    stamp_ns: IntArray
    frame_id: str
    temperature: FloatArray
    variance: FloatArray


Samples: TypeAlias = (
    TextSamples
    | ImuSamples
    | SpatialImu
    | JointSamples
    | TimeSamples
    | FixSamples
    | TemperatureSamples
)
Batches: TypeAlias = dict[str, Samples]
State: TypeAlias = dict[str, Any]
AnySamples = TypeVar(
    'AnySamples',
    TextSamples,
    ImuSamples,
    JointSamples,
    TimeSamples,
    FixSamples,
    TemperatureSamples,
)


class Stage(Protocol):
    """A stage of the pipeline: takes time-ordered samples and returns samples.

    Feeding `a + b` at once or `a` and then `b` gives the same bits. So does a new stage of the
    same scene that is given the `state()` of the old one by `restore()`. A state consists of
    numbers, strings, arrays, samples, and lists, tuples or dicts of them.
    """

    outputs: ClassVar[tuple[str, ...]]

    @property
    def inputs(self) -> tuple[str, ...]:
        """Topics of its input, which may depend on the scene."""
        ...

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Take new samples of any input and return the samples that can be published now."""
        ...

    def finish(self) -> Batches:
        """Return the remaining samples at the end of the input."""
        ...

    def state(self) -> State:
        """Return everything that affects later output."""
        ...

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        ...

    def health(self) -> dict[str, int]:
        """Return counters, for example of refused samples and bridged gaps."""
        ...


class Stateful:
    """Saves and restores attributes by their names, recursively.

    Attributes:
        state_names: names, without an underscore, of the attributes that affect later output.
            A class may add to `state`.
    """

    state_names: ClassVar[tuple[str, ...]] = ()

    def state(self) -> State:
        """Return everything that affects later output."""
        return {name: _saved(getattr(self, self._attribute(name))) for name in self.state_names}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        for name in self.state_names:
            attribute = self._attribute(name)
            setattr(self, attribute, _restored(getattr(self, attribute), state[name]))

    def _attribute(self, name: str) -> str:
        return f'_{name}' if hasattr(self, f'_{name}') else name


def _saved(part: Any) -> Any:
    if isinstance(part, tuple) and part and hasattr(part[0], 'restore'):
        return [item.state() for item in part]
    return part.state() if hasattr(part, 'restore') else deepcopy(part)


def _restored(part: Any, saved: Any) -> Any:
    if isinstance(part, tuple) and part and hasattr(part[0], 'restore'):
        return tuple(map(_restored, part, saved))
    if not hasattr(part, 'restore'):
        return deepcopy(saved)
    part.restore(saved)
    return part


def count(samples: Samples) -> int:
    """Return the number of samples in a batch."""
    return len(samples.stamp_ns)


def take(samples: AnySamples, which: slice | NDArray[np.bool_]) -> AnySamples:
    """Return the samples that `which` selects along the first axis."""
    arrays: dict[str, Any] = {
        field.name: value[which]
        for field in fields(samples)
        if isinstance(value := getattr(samples, field.name), np.ndarray)
    }
    return replace(samples, **arrays)


def join(parts: Sequence[AnySamples]) -> AnySamples:
    """Return consecutive batches of one topic, with the same names and frame, as one."""
    if len(parts) == 1:
        return parts[0]
    arrays: dict[str, Any] = {
        field.name: np.concatenate([getattr(part, field.name) for part in parts])
        for field in fields(parts[0])
        if isinstance(getattr(parts[0], field.name), np.ndarray)
    }
    return replace(parts[0], **arrays)


def merged(parts: Sequence[Batches]) -> Batches:
    """Return consecutive batches of several topics as one."""
    topics = dict.fromkeys(topic for batches in parts for topic in batches)
    return {
        topic: join([cast(TimeSamples, batches[topic]) for batches in parts if topic in batches])
        for topic in topics
    }


def text(stamp_ns: int, data: str) -> TextSamples:
    """Return one text sample."""
    return TextSamples(np.array([stamp_ns], np.int64), np.array([data], object))


def same(value: object, n: int) -> NDArray[np.object_]:
    """Return the same object n times, without copies."""
    return np.broadcast_to(np.array([value], object), (n,))


def scalars(stamp_ns: IntArray, names: tuple[str, ...], values: FloatArray) -> JointSamples:
    """Return named scalars with stamps, values of shape (n, len(names))."""
    empty = np.empty((len(stamp_ns), 0))
    return JointSamples(stamp_ns, '', names, values, empty, empty)
