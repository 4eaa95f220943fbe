"""Imu messages from an MCAP file or rosbag2 folder, as far as it can be read."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np

from tauto_core.samples import NS_PER_S, ImuSamples
from tauto_core.scene.errors import MotionDataError

IMU_TYPE = 'sensor_msgs/msg/Imu'
MCAP_MAGIC = b'\x89MCAP0\r\n'


def read_imu(path: Path, name: str, topic: str) -> tuple[ImuSamples, tuple[str, ...]]:
    """Return the Imu messages on a topic in the order stored, by their header stamps.

    A file that is truncated or damaged is read as far as possible, with a warning.

    Args:
        path: MCAP file, or folder with MCAP files, read in the order of their numbers.
        name: name of the bag as the user wrote it, for messages.
        topic: with or without leading slash.

    Returns:
        The samples and the warnings.

    Raises:
        MotionDataError: not MCAP; topic missing, empty, of another type or encoding; a payload
            that is not an Imu message.
    """
    topics: dict[str, str] = {}
    payloads: list[bytes] = []
    warnings: list[str] = []
    for file in _files(path, name):
        with _open(file, name) as stream:
            warning = _collect(stream, topic.lstrip('/'), topics, payloads)
        if warning:
            warnings.append(
                f'{name}: {file.name} breaks off ({warning}); the {len(payloads)} Imu messages '
                'read up to there are used'
            )
    _check_topic(name, topic, topics, len(payloads))
    return _decode(name, topic, payloads), tuple(warnings)


def _files(path: Path, name: str) -> list[Path]:
    """Return the MCAP files of a bag."""
    if not path.is_dir():
        return [path]
    numbered = sorted(
        path.glob('*.mcap'), key=lambda file: (*map(int, re.findall(r'\d+', file.stem)[-1:]),)
    )
    if not numbered:
        raise MotionDataError(f'{name}: the folder holds no .mcap file. Give an MCAP bag.')
    return numbered


def _open(file: Path, name: str) -> IO[bytes]:
    """Open a file that begins with the MCAP magic bytes."""
    try:
        stream = file.open('rb')
    except OSError as error:
        raise MotionDataError(
            f'{name}: {file.name} cannot be read: {error.strerror}. Give an MCAP bag.'
        ) from error
    if stream.read(len(MCAP_MAGIC)) != MCAP_MAGIC:
        stream.close()
        raise MotionDataError(
            f'{name}: {file.name} is not an MCAP file (it does not begin with the magic bytes). '
            'Give an MCAP bag, or the columns of a CSV instead of topic.'
        )
    stream.seek(0)
    return stream


def _collect(stream: IO[bytes], topic: str, topics: dict[str, str], payloads: list[bytes]) -> str:
    """Add the topics found, with type and encoding, and the payloads on one; return what broke."""
    from mcap.records import Channel, Message, Schema  # only for bags

    schemas: dict[int, str] = {}
    wanted: set[int] = set()
    records = _records(stream)
    while True:
        try:
            record = next(records)
        except StopIteration:
            return ''
        except Exception as error:  # in a damaged file parser and decompressor may raise anything
            return f'{type(error).__name__}: {error}'
        if isinstance(record, Schema):
            schemas[record.id] = record.name
        elif isinstance(record, Channel):
            kind = schemas.get(record.schema_id, 'no type')
            topics[record.topic.lstrip('/')] = f'{kind} ({record.message_encoding})'
            if record.topic.lstrip('/') == topic:
                wanted.add(record.id)
        elif isinstance(record, Message) and record.channel_id in wanted:
            payloads.append(record.data)


def _records(stream: IO[bytes]) -> Iterator[Any]:
    # mcap's seeking readers cannot read a file without a footer
    from mcap.stream_reader import StreamReader

    return iter(StreamReader(stream, validate_crcs=True).records)


def _check_topic(name: str, topic: str, topics: dict[str, str], number: int) -> None:
    """Refuse a topic that cannot give Imu messages."""
    found = topics.get(topic.lstrip('/'))
    if found is None:
        listed = ', '.join(f'{other}: {kind}' for other, kind in sorted(topics.items()))
        raise MotionDataError(
            f'{name}: has no topic {topic!r}; it has {listed or "none"}. Name one with Imu '
            'messages.'
        )
    if found != f'{IMU_TYPE} (cdr)':
        raise MotionDataError(
            f'{name}: topic {topic!r} is {found}; it must be {IMU_TYPE} (cdr). Name another topic.'
        )
    if number == 0:
        raise MotionDataError(f'{name}: topic {topic!r} holds no message. Name another topic.')


def _decode(name: str, topic: str, payloads: list[bytes]) -> ImuSamples:
    """Return CDR payloads as samples."""
    from rosbags.typesys import Stores, get_typestore  # slow to import

    store = get_typestore(Stores.ROS2_JAZZY)
    messages: list[Any] = []
    for number, payload in enumerate(payloads, start=1):
        try:
            messages.append(store.deserialize_cdr(payload, IMU_TYPE))
        except Exception as error:  # the exceptions of the deserialiser are not documented
            raise MotionDataError(
                f'{name}: message {number} on {topic!r} is not a valid {IMU_TYPE}: {error}. '
                'Record the bag again.'
            ) from error
    stamps = [m.header.stamp.sec * NS_PER_S + m.header.stamp.nanosec for m in messages]
    return ImuSamples(
        np.array(stamps, np.int64),
        messages[0].header.frame_id,
        np.array([_xyz(m.orientation, 'xyzw') for m in messages]),
        np.array([m.orientation_covariance for m in messages]),
        np.array([_xyz(m.angular_velocity, 'xyz') for m in messages]),
        np.array([m.angular_velocity_covariance for m in messages]),
        np.array([_xyz(m.linear_acceleration, 'xyz') for m in messages]),
        np.array([m.linear_acceleration_covariance for m in messages]),
    )


def _xyz(vector: Any, axes: str) -> list[float]:
    return [getattr(vector, axis) for axis in axes]
