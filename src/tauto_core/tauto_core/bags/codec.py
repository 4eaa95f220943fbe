"""CDR payloads: batches of samples to serialised messages and back.

Messages whose strings and sequences have equal lengths have equal layouts. So one payload is laid
out, and numpy copies it and fills in the numbers of a whole batch. Padding is zero, so payloads
are the same bits wherever they are made. rmw_fastrtps leaves arbitrary padding and up to 8 bytes
after the message; both are accepted.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from dataclasses import field as dataclass_field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tauto_core.bags.layout import (
    HEADER_BYTES,
    Layout,
    Text,
    byte_order,
    cut_short,
    scan,
    template,
)
from tauto_core.bags.table import MESSAGE_TYPES, TOPICS, Field, MessageType
from tauto_core.samples import NS_PER_S, IntArray, JointSamples, Samples, count, join
from tauto_core.scene.errors import BagError

_MOST_LAYOUTS = 32
_BLANK = b'\x00\x01\x00\x00' + bytes(512)
_SECONDS_RANGE = (-(2**31), 2**31 - 1)


def encode(topic: str, samples: Samples) -> list[bytes]:
    """Return one little-endian CDR payload for each sample.

    Args:
        topic: relative name, a key of `TOPICS`.
        samples: a batch of the topic's class.

    Raises:
        BagError: a batch of another class, arrays of unequal length, times beyond the int32
            seconds of a ROS message, strings that UTF-8 or C cannot represent.
    """
    message = TOPICS[topic].message
    if not isinstance(samples, message.samples):
        raise BagError(
            f'{topic}: got {type(samples).__name__}, but the topic carries '
            f'{message.samples.__name__}; hand over a batch of that class'
        )
    values = {field.name: getattr(samples, field.name) for field in fields(samples)}
    _check_shapes(topic, message, values, count(samples))
    payloads: list[bytes] = []
    for first, last in _runs(message, values, count(samples)):
        payloads += _encode_run(topic, message, values, slice(first, last))
    return payloads


def decode(topic: str, payloads: Sequence[bytes], stamps_ns: IntArray) -> Samples:
    """Return the samples of serialised messages, in their order.

    Args:
        topic: relative name, a key of `TOPICS`.
        payloads: CDR of either byte order, by any publisher.
        stamps_ns: log times, shape (n,); they become the stamps of messages without a header.

    Raises:
        BagError: payloads that are not CDR of the topic's type, several frames or sets of joint
            names on one topic, joint arrays that do not match the names.
    """
    return decode_as(TOPICS[topic].ros_type, topic, payloads, stamps_ns)


def decode_as(
    ros_type: str, origin: str, payloads: Sequence[bytes], stamps_ns: IntArray
) -> Samples:
    """Return the samples of messages of a type of the table, on any topic.

    Args:
        ros_type: a key of `MESSAGE_TYPES`.
        origin: name for errors, for example the topic with its bag.
        payloads: as in `decode`.
        stamps_ns: as in `decode`.

    Raises:
        BagError: as in `decode`.
    """
    message = MESSAGE_TYPES[ros_type]
    collection = _Collection(message, origin, len(payloads))
    for where, layout in _groups(message, origin, payloads):
        collection.put(where, layout)
    if not payloads:
        blank = scan(message, origin, _BLANK)
        collection.put(np.arange(0), replace(blank, rows=blank.rows[:0]))
    if not message.stamped:
        collection.values['stamp_ns'] = np.array(stamps_ns, np.int64)
    samples = message.samples(**collection.values)
    if isinstance(samples, JointSamples):
        _check_joints(origin, samples)
    return samples


def joined(ros_type: str, origin: str, parts: Sequence[Samples]) -> Samples:
    """Return batches that `decode_as` made of one topic, in their order, as one.

    Raises:
        BagError: several frames or sets of joint names, as in `decode`.
    """
    for field in MESSAGE_TYPES[ros_type].fields:
        first, *others = [getattr(part, field.sample) for part in parts]
        for other in others:
            if field.shared and other != first:
                raise _mixed(origin, field, repr(first), repr(other))
            if not field.shared and other.shape[1:] != first.shape[1:]:
                raise _mixed(origin, field, *_lengths(first, other))
    whole: Samples = join(parts)  # type: ignore[type-var]
    return whole


def header_stamp_ns(payload: bytes) -> int:
    """Return the stamp [ns] of a serialised message that begins with a std_msgs/Header.

    Raises:
        BagError: a payload that is not CDR or too short for a header.
    """
    order = byte_order('message', payload)
    try:
        seconds, nanoseconds = struct.unpack_from(f'{order}iI', payload, HEADER_BYTES)
    except struct.error:
        raise cut_short('message', 'header.stamp', payload) from None
    return int(seconds) * NS_PER_S + int(nanoseconds)


def _runs(message: MessageType, values: Mapping[str, Any], n: int) -> Iterator[tuple[int, int]]:
    """Yield the bounds of runs of samples whose strings are equal."""
    changes = np.zeros(max(n - 1, 0), np.bool_)
    for field in message.fields:
        if field.kind == 'string' and not field.shared and values[field.sample].strides[0]:
            texts = values[field.sample]
            changes |= np.asarray(texts[1:] != texts[:-1], np.bool_)
    bounds = [0, *(np.flatnonzero(changes) + 1).tolist(), n] if n else [0]
    return pairwise(bounds)


def _encode_run(
    topic: str, message: MessageType, values: Mapping[str, Any], run: slice
) -> list[bytes]:
    """Return the payloads of samples whose strings are equal."""
    n = run.stop - run.start
    one, structure = template(topic, tuple(_texts(message, values, run.start)))
    copies = bytearray(one * n)
    block = np.frombuffer(copies, structure)
    for field in message.fields:
        if field.kind == 'time':
            seconds, nanoseconds = np.divmod(values[field.sample][run], NS_PER_S)
            _check_seconds(topic, field, seconds)
            block[f'{field.sample}.sec'] = seconds
            block[f'{field.sample}.nanosec'] = nanoseconds
        elif field.kind not in {'string', 'string[]'}:
            block[field.sample] = values[field.sample][run]
    octets, size = bytes(copies), len(one)
    return [octets[at : at + size] for at in range(0, n * size, size)]


def _texts(message: MessageType, values: Mapping[str, Any], index: int) -> Iterator[Text]:
    """Yield the values of the fields of variable length in one sample."""
    for field in message.fields:
        value = values[field.sample]
        if field.kind in {'string', 'string[]'}:
            yield value if field.shared else value[index]
        elif field.kind == 'float64[]':
            yield value.shape[1]


def _groups(
    message: MessageType, origin: str, payloads: Sequence[bytes]
) -> Iterator[tuple[IntArray, Layout]]:
    """Yield payloads of equal layout: their indices, and the layout with all of them as rows.

    After `_MOST_LAYOUTS` the rest is done one by one, which keeps the work proportional to n.
    """
    if len(payloads) == 1:
        yield np.arange(1), scan(message, origin, payloads[0])
        return
    sizes = np.fromiter(map(len, payloads), np.int64, len(payloads))
    rest = np.arange(len(payloads))
    for _ in range(_MOST_LAYOUTS):
        if not len(rest):
            return
        layout = scan(message, origin, payloads[rest[0]])
        alike = np.flatnonzero(sizes[rest] == layout.size)
        octets = b''.join([payloads[index] for index in rest[alike].tolist()])
        block = np.frombuffer(octets, np.uint8).reshape(len(alike), layout.size)
        fits = np.ones(len(alike), np.bool_)
        for at, word in layout.words:
            fits &= np.all(block[:, at : at + len(word)] == np.frombuffer(word, np.uint8), axis=1)
        rows = block[fits].view(layout.rows.dtype)[:, 0]
        yield rest[alike[fits]], replace(layout, rows=rows)
        rest = np.delete(rest, alike[fits])
    for index in rest.tolist():
        yield np.array([index]), scan(message, origin, payloads[index])


@dataclass(frozen=True)
class _Collection:
    """The fields of a batch of n samples, filled group by group."""

    message: MessageType
    origin: str
    n: int
    values: dict[str, Any] = dataclass_field(default_factory=dict)

    def put(self, where: IntArray, layout: Layout) -> None:
        """Take the payloads of one layout as the samples `where`."""
        for field in self.message.fields:
            name = field.sample
            if field.shared:
                found = layout.texts[name]
                if self.values.setdefault(name, found) != found:
                    raise _mixed(self.origin, field, repr(self.values[name]), repr(found))
            elif field.kind == 'string':
                texts = self.values.setdefault(name, np.empty(self.n, object))
                texts[where] = layout.texts[name]
            else:
                self._put_numbers(field, where, _numbers(field, layout))

    def _put_numbers(self, field: Field, where: IntArray, part: NDArray[Any]) -> None:
        whole = self.values.get(field.sample)
        if whole is None and len(part) == self.n:
            self.values[field.sample] = part.astype(part.dtype.newbyteorder('='))
            return
        if whole is None:
            whole = np.empty((self.n, *part.shape[1:]), part.dtype.newbyteorder('='))
            self.values[field.sample] = whole
        if whole.shape[1:] != part.shape[1:]:
            raise _mixed(self.origin, field, *_lengths(whole, part))
        whole[where] = part


def _lengths(first: NDArray[Any], second: NDArray[Any]) -> tuple[str, str]:
    return f'{first.shape[1]} numbers long', f'{second.shape[1]} numbers long'


def _mixed(origin: str, field: Field, first: str, second: str) -> BagError:
    return BagError(
        f'{origin}: {field.message} is {first} in one message and {second} in another; a topic '
        'must have one source: record or remap them apart'
    )


def _numbers(field: Field, layout: Layout) -> NDArray[Any]:
    """Return a numeric field of the payloads of one layout."""
    if field.kind != 'time':
        return layout.rows[field.sample]
    seconds: IntArray = layout.rows[f'{field.sample}.sec'].astype(np.int64)
    return seconds * NS_PER_S + layout.rows[f'{field.sample}.nanosec'].astype(np.int64)


def _check_shapes(topic: str, message: MessageType, values: Mapping[str, Any], n: int) -> None:
    """Refuse arrays that numpy would silently broadcast."""
    names = len(values.get('name', ()))
    for field in message.fields:
        if field.shared:
            continue
        wanted: list[tuple[int, ...]] = [(n, field.length) if field.length > 1 else (n,)]
        if field.kind == 'float64[]':
            wanted = [(n, names)] if field.sample == 'position' else [(n, names), (n, 0)]
        shape = values[field.sample].shape
        if shape not in wanted:
            raise BagError(
                f'{topic}: {field.sample} has shape {shape}, but must have '
                f'{" or ".join(map(str, wanted))}'
            )


def _check_joints(origin: str, samples: JointSamples) -> None:
    names = len(samples.name)
    for what, allowed in (
        ('position', (names,)),
        ('velocity', (0, names)),
        ('effort', (0, names)),
    ):
        length = getattr(samples, what).shape[1]
        if len(samples.stamp_ns) and length not in allowed:
            raise BagError(
                f'{origin}: {what} has {length} elements for {names} names; the publisher must '
                'send one a name' + ('' if what == 'position' else ', or none')
            )


def _check_seconds(topic: str, field: Field, seconds: IntArray) -> None:
    low, high = _SECONDS_RANGE
    if len(seconds) and not (low <= seconds.min() and seconds.max() <= high):
        raise BagError(
            f'{topic}: {field.sample} lies between {seconds.min()} s and {seconds.max()} s, but '
            f'a ROS time lies in [{low}, {high}] s; choose a nearer starts_at'
        )
