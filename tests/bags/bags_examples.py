"""Batches with a value in every field, and payloads made by other programs."""

import hashlib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import Writer as McapWriter
from rosbags.typesys import Stores, get_typestore

from tauto_core import samples as s
from tauto_core.bags import TOPICS
from tauto_core.scene.times import NS_PER_S

START_NS = 86_400 * NS_PER_S
STORE = get_typestore(Stores.ROS2_JAZZY)


def stamps(n: int, step_ns: int = 50_000_000) -> s.IntArray:
    return START_NS + step_ns * np.arange(n)


def example(kind: type[s.Samples], n: int, seed: int = 1726) -> s.Samples:
    """A batch of n samples with different numbers, and strings that change in between."""
    rng = np.random.default_rng(seed)
    when = stamps(n)
    sources = np.array(['dial', 'port', 'Königsberg', ''] * n, object)[:n]
    if kind is s.TextSamples:
        return s.TextSamples(when, sources)
    if kind is s.ImuSamples:
        parts = [rng.normal(size=(n, width)) for width in (4, 9, 3, 9, 3, 9)]
        return s.ImuSamples(when, 'clock_mount', *parts)
    if kind is s.JointSamples:
        three = [rng.normal(size=(n, 2)) for _ in range(3)]
        return s.JointSamples(when, 'case', ('wheel', 'fusee'), *three)
    if kind is s.TimeSamples:
        return s.TimeSamples(when, '', when + rng.integers(-(10**12), 10**12, n), sources)
    if kind is s.TemperatureSamples:
        return s.TemperatureSamples(when, 'clock_case', *rng.normal(size=(2, n)))
    status, service = rng.integers(-2, 3, n), rng.integers(0, 65536, n)
    latitude, longitude, altitude = rng.normal(size=(3, n))
    return s.FixSamples(
        when,
        'wgs84',
        status.astype(np.int8),
        service.astype(np.uint16),
        latitude,
        longitude,
        altitude,
        rng.normal(size=(n, 9)),
        rng.integers(0, 4, n).astype(np.uint8),
    )


def fill(make: Callable[[str], Any], samples: s.Samples, i: int) -> Any:
    """Sample i as a message, of whatever library `make` takes the empty messages from."""

    def time(ns: int) -> Any:
        message = make('builtin_interfaces/msg/Time')
        message.sec, message.nanosec = divmod(int(ns), NS_PER_S)
        return message

    def vector(name: str, values: s.FloatArray) -> Any:
        message = make(f'geometry_msgs/msg/{name}')
        for axis, value in zip('xyzw', values, strict=False):
            setattr(message, axis, float(value))
        return message

    if isinstance(samples, s.TextSamples):
        text = make('std_msgs/msg/String')
        text.data = samples.data[i]
        return text
    header = make('std_msgs/msg/Header')
    header.stamp, header.frame_id = time(samples.stamp_ns[i]), samples.frame_id
    if isinstance(samples, s.ImuSamples):
        message = make('sensor_msgs/msg/Imu')
        message.orientation = vector('Quaternion', samples.orientation[i])
        message.angular_velocity = vector('Vector3', samples.angular_velocity[i])
        message.linear_acceleration = vector('Vector3', samples.linear_acceleration[i])
        for name in ('orientation', 'angular_velocity', 'linear_acceleration'):
            setattr(
                message, f'{name}_covariance', getattr(samples, f'{name}_covariance')[i].copy()
            )
    elif isinstance(samples, s.JointSamples):
        message = make('sensor_msgs/msg/JointState')
        message.name = list(samples.name)
        for name in ('position', 'velocity', 'effort'):
            setattr(message, name, np.ascontiguousarray(getattr(samples, name)[i]))
    elif isinstance(samples, s.TimeSamples):
        message = make('sensor_msgs/msg/TimeReference')
        message.time_ref, message.source = time(samples.time_ref_ns[i]), samples.source[i]
    elif isinstance(samples, s.TemperatureSamples):
        message = make('sensor_msgs/msg/Temperature')
        message.temperature = float(samples.temperature[i])
        message.variance = float(samples.variance[i])
    else:
        message = make('sensor_msgs/msg/NavSatFix')
        message.status = make('sensor_msgs/msg/NavSatStatus')
        message.status.status = int(samples.status[i])
        message.status.service = int(samples.service[i])
        for name in ('latitude', 'longitude', 'altitude'):
            setattr(message, name, float(getattr(samples, name)[i]))
        message.position_covariance = samples.position_covariance[i].copy()
        message.position_covariance_type = int(samples.position_covariance_type[i])
    message.header = header
    return message


def library_payloads(
    ros_type: str, samples: s.Samples, *, little_endian: bool = True
) -> list[bytes]:
    """The payloads as the rosbags library serialises them."""

    def make(name: str) -> Any:
        kind = STORE.types[name]
        return kind.__new__(kind)

    def serialised(i: int) -> bytes:
        message = fill(make, samples, i)
        return bytes(STORE.serialize_cdr(message, ros_type, little_endian=little_endian))

    return [serialised(i) for i in range(s.count(samples))]


Channels = Mapping[str, tuple[str, str, Iterable[tuple[int, bytes]]]]
"""Type, encoding, and log times [ns] with payloads of each topic."""


def mcap_file(path: Path, channels: Channels, definition: bytes = b'', **options: Any) -> Path:
    """A bare file by the mcap library: message k is published 7 ns late, with number 5 k."""
    with path.open('wb') as stream:
        writer = McapWriter(stream, **options)
        writer.start('ros2')
        for topic, (ros_type, encoding, messages) in channels.items():
            schema = writer.register_schema(ros_type, 'ros2msg', definition)
            channel = writer.register_channel(topic, encoding, schema)
            for k, (stamp_ns, payload) in enumerate(messages):
                writer.add_message(channel, stamp_ns, payload, stamp_ns + 7, 5 * k)
        writer.finish()
    return path


def assert_same(one: s.Samples, other: s.Samples) -> None:
    """Bit for bit: NaN equals itself, zero does not equal minus zero."""
    assert type(one) is type(other)
    for name, value in vars(one).items():
        if isinstance(value, np.ndarray) and value.dtype != object:
            there = getattr(other, name)
            assert (there.dtype, there.shape) == (value.dtype, value.shape), name
            assert there.tobytes() == value.tobytes(), name
        else:
            np.testing.assert_array_equal(getattr(other, name), value, strict=True)


def all_batches(n: int = 40) -> s.Batches:
    """n samples of every topic of the table, and one scene."""
    batches = {name: example(topic.message.samples, n) for name, topic in TOPICS.items()}
    batches[s.SCENE] = s.text(START_NS, 'name: a scene\n')
    return batches


def digests(folder: Path) -> dict[str, str]:
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in folder.iterdir()}
