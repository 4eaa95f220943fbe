"""Samples: the data that flow between the stages, with the same fields as the messages.

Only `SpatialImu` is not a message; it replaces `ImuSamples` where not all of its
fields are needed.

A batch has n time-ordered samples as arrays whose first axis is the sample. Stamps are integer
nanoseconds, strictly increasing within a topic. Angles are in radians and lengths in metres,
except where the ROS message itself says otherwise (`NavSatFix` has degrees).
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
    """std_msgs/String; `stamp_ns` is the log time, since the message has no header."""

    stamp_ns: IntArray
    data: NDArray[np.object_]


@dataclass(frozen=True)
class ImuSamples:
    """sensor_msgs/Imu: attitude, angular velocity [rad/s], specific force [m/s2].

    `orientation` is (x, y, z, w), shape (n, 4); the vectors are (n, 3) in the sensor's frame,
    +g on z at rest; covariances (n, 9), row-major (all zero: unknown; first element -1: absent).
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
        """Return the samples themselves: nobody changes them."""
        return self


SQUARABLE = 1e150
"""Numbers up to this one do not overflow when they are squared."""

IN_CACHE = 16_384
"""Samples of a simulated ship that are made at once: their arrays stay in the processor's
second cache. A multiple of the blocks in which waves are summed (`ship.waves.SUM_BLOCK`).
"""


@dataclass(frozen=True)
class SpatialImu:
    """The motion of a simulated ship, from which `ImuSamples` are made.

    A clock may not need all of a sample. No sample would be refused (`ship.imu.screen`), and the
    stamps continue those before.
    """

    stamp_ns: IntArray
    samples: Callable[[bool, bool, slice], ImuSamples]
    """Returns the samples of some rows. The first argument asks for the angular velocity, the
    second for the specific force; a channel that is not needed has the shape (0, 3). The bits of
    the rest are the same."""
    first: int = 0
    """Number of the first sample since the ship's start."""

    def parts(self, turning: bool, felt: bool) -> Iterator[tuple[slice, ImuSamples]]:
        """Yield the samples as `samples` does, with their rows, in parts that fit the cache."""
        begin, total = 0, len(self.stamp_ns)
        while begin < total:
            end = min(begin + IN_CACHE - (self.first + begin) % IN_CACHE, total)
            rows = slice(begin, end)
            yield rows, self.samples(turning, felt, rows)
            begin = end


@dataclass(frozen=True)
class HungImu:
    """The motion of a clock in a case that is hung in the ship; stamps continue those before."""

    stamp_ns: IntArray
    tilt: FloatArray
    """φ of the case [rad], unwrapped."""
    rate: FloatArray
    """φ̇ [rad/s]."""
    lean: FloatArray
    """Direction of the specific force in the case, positive to starboard [rad]."""
    pull: FloatArray
    """Its size [m/s2], negative where it would throw a weight out of the top of the case."""


@dataclass(frozen=True)
class JointSamples:
    """sensor_msgs/JointState, also used for named scalars with a stamp.

    `position` is (n, len(name)); `velocity` and `effort` are the same, or (n, 0) where absent.
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
    """sensor_msgs/NavSatFix: degrees, north and east positive; covariance (n, 9) ENU [m2]."""

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
    """sensor_msgs/Temperature: degrees Celsius, and their variance [K2], 0 where it is unknown."""

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

    Feeding `a + b` at once or `a` and then `b` gives the same bits. So does taking `state()`
    (plain numbers, strings, arrays, samples, and lists, tuples or dicts of them), making a new
    stage from the same scene and calling `restore()`.
    """

    outputs: ClassVar[tuple[str, ...]]

    @property
    def inputs(self) -> tuple[str, ...]:
        """Topics of its input; they may depend on the scene."""
        ...

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Take new samples of any input; return the samples that can be published now."""
        ...

    def finish(self) -> Batches:
        """Return all that is still held back, since no more input will come."""
        ...

    def state(self) -> State:
        """Return all that the next output depends on."""
        ...

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        ...

    def health(self) -> dict[str, int]:
        """Return counters of refused samples, bridged gaps and the like; empty if it has none."""
        ...


class Stateful:
    """Saves and restores attributes by their names; of parts that have a state, that state.

    Attributes:
        state_names: the names, without an underscore: of all that the next result depends on,
            but for what a class adds to its own `state`.
    """

    state_names: ClassVar[tuple[str, ...]] = ()

    def state(self) -> State:
        """Return all that the next result depends on."""
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
    """Return batches of one topic, in order, as one. The parts must share names and frame."""
    if len(parts) == 1:
        return parts[0]
    arrays: dict[str, Any] = {
        field.name: np.concatenate([getattr(part, field.name) for part in parts])
        for field in fields(parts[0])
        if isinstance(getattr(parts[0], field.name), np.ndarray)
    }
    return replace(parts[0], **arrays)


def merged(parts: Sequence[Batches]) -> Batches:
    """Return batches of the same topics, in order, as one."""
    topics = dict.fromkeys(topic for batches in parts for topic in batches)
    return {
        topic: join([cast(TimeSamples, batches[topic]) for batches in parts if topic in batches])
        for topic in topics
    }


def text(stamp_ns: int, data: str) -> TextSamples:
    """Return one text sample."""
    return TextSamples(np.array([stamp_ns], np.int64), np.array([data], object))


def same(value: object, n: int) -> NDArray[np.object_]:
    """Return n times the same object, without copies."""
    return np.broadcast_to(np.array([value], object), (n,))


def scalars(stamp_ns: IntArray, names: tuple[str, ...], values: FloatArray) -> JointSamples:
    """Return named scalars with stamps: values of shape (n, len(names))."""
    empty = np.empty((len(stamp_ns), 0))
    return JointSamples(stamp_ns, '', names, values, empty, empty)
