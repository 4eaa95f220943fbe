"""CDR payloads: batches of samples to serialised messages and back.

Messages with strings and sequences of equal lengths have equal layouts: one payload is laid out,
and numpy copies it and fills in the numbers of a batch. Padding is zero, so payloads have the same
bits everywhere. Arbitrary padding, and up to 8 bytes after a message, as of rmw_fastrtps, are
accepted.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauto_core.bags.table import MESSAGE_TYPES, TOPICS, Field, MessageType
from tauto_core.samples import IntArray, JointSamples, Samples, count, join
from tauto_core.scene.errors import BagError
from tauto_core.scene.times import NS_PER_S

# -----------------------------------------------------------------------------
# The layout of one CDR payload: the places of its numbers, given its strings and lengths.
#
# Plain CDR, version 1, after the four-byte encapsulation header of ROS 2. Primitives are aligned
# to their size, counted from the end of that header (OMG DDSI-RTPS 2.5, section 10).

HEADER_BYTES = 4
NUMBERS = {'float64': 'f8', 'int8': 'i1', 'uint8': 'u1', 'uint16': 'u2'}
"""numpy's code of each primitive."""

MOST_NAMES = 1000
"""Most names of joints in a message: millions would take minutes to read."""

_LITTLE_ENDIAN = b'\x00\x01\x00\x00'
_BYTE_ORDER = {0: '>', 1: '<'}

_Row: TypeAlias = tuple[str, str, int]
Text: TypeAlias = str | tuple[str, ...] | int

# The last layout of each type. Messages that come one at a time seldom change it.
_recent: dict[str, Layout] = {}


@dataclass(frozen=True)
class Layout:
    """The places of the fields in payloads with equal strings and sequence lengths."""

    size: int
    rows: NDArray[np.void]
    """Payloads as arrays of the structured type of their numbers."""
    words: tuple[tuple[int, bytes], ...]
    """The bytes that determine the layout, with their places: encapsulation, lengths, strings."""
    texts: dict[str, str | tuple[str, ...]]

    def fits(self, payload: bytes) -> bool:
        """Whether another payload has this layout."""
        return len(payload) == self.size and all(
            payload.startswith(octets, at) for at, octets in self.words
        )


@lru_cache(maxsize=256)
def template(topic: str, texts: tuple[Text, ...]) -> tuple[bytes, np.dtype[np.void]]:
    """Return the payload of a sample with numbers of zero, and the structure of its numbers.

    Texts are the values of the fields of variable length, in their order: strings, tuples of
    strings, and the lengths of sequences of numbers. A string that UTF-8 or C cannot represent is
    a BagError that names topic and field.
    """
    out = bytearray(_LITTLE_ENDIAN)
    variable = iter(texts)
    for field in TOPICS[topic].message.fields:
        if field.kind in NUMBERS:
            size = np.dtype(NUMBERS[field.kind]).itemsize
            _align(out, size)
            out += bytes(size * field.length)
        elif field.kind == 'time':
            _align(out, 4)
            out += bytes(8)
        elif isinstance(value := next(variable), str):
            _put_text(topic, field, out, value)
        elif isinstance(value, int):
            _put_length(out, value)
            if value:
                _align(out, 8)
            out += bytes(8 * value)
        else:
            _put_length(out, len(value))
            for text in value:
                _put_text(topic, field, out, text)
    payload = bytes(out)
    return payload, scan(TOPICS[topic].message, topic, payload).rows.dtype


def _align(out: bytearray, size: int) -> None:
    out += bytes(-(len(out) - HEADER_BYTES) % size)


def _put_length(out: bytearray, length: int) -> None:
    _align(out, 4)
    out += length.to_bytes(4, 'little')


def _put_text(topic: str, field: Field, out: bytearray, text: str) -> None:
    try:
        octets = text.encode()
    except UnicodeEncodeError as error:
        raise BagError(
            f'{topic}: {field.sample} = {text!r} is not Unicode ({error.reason}). Remove the '
            'character'
        ) from None
    if b'\x00' in octets:
        raise BagError(
            f'{topic}: {field.sample} = {text!r} holds a zero character, which ends a ROS '
            'string. Remove it'
        )
    _put_length(out, len(octets) + 1)
    out += octets + b'\x00'


class _Cursor:
    """Reads lengths and strings of one payload and notes the bytes that determine its layout."""

    def __init__(self, origin: str, payload: bytes) -> None:
        self.origin = origin
        self.payload = payload
        self.order = byte_order(origin, payload)
        self.at = HEADER_BYTES
        self.words = [(0, payload[:2])]

    def skip(self, field: Field, size: int, length: int = 1) -> int:
        """Step over `length` primitives of `size` bytes. Return the place of the first."""
        begin = self.at + -(self.at - HEADER_BYTES) % size
        self.at = begin + size * length
        if self.at > len(self.payload):
            raise cut_short(self.origin, field.message, self.payload)
        return begin

    def length(self, field: Field) -> int:
        """Return a sequence length."""
        begin = self.skip(field, 4)
        self.words.append((begin, self.payload[begin : self.at]))
        return int(struct.unpack_from(f'{self.order}I', self.payload, begin)[0])

    def text(self, field: Field) -> str:
        """Return a string, without the zero at its end."""
        length = self.length(field)
        begin = self.skip(field, 1, length)
        octets = self.payload[begin : self.at]
        self.words.append((begin, octets))
        try:
            return octets.removesuffix(b'\x00').decode()
        except UnicodeDecodeError:
            raise BagError(
                f'{self.origin}: {field.message} = {octets!r} is not UTF-8. The publisher must '
                'send UTF-8'
            ) from None


def scan(message: MessageType, origin: str, payload: bytes) -> Layout:
    """Return the layout of one payload.

    A payload that is not plain CDR, or ends within the message, or text that is not UTF-8 is a
    BagError that names `origin` and the field.
    """
    recent = _recent.get(message.name)
    if recent is not None and recent.fits(payload):
        return replace(recent, rows=np.frombuffer(payload, recent.rows.dtype))
    cursor = _Cursor(origin, payload)
    numbers: list[_Row] = []
    texts: dict[str, str | tuple[str, ...]] = {}
    for field in message.fields:
        if field.kind == 'string':
            texts[field.sample] = cursor.text(field)
        elif field.kind == 'string[]':
            length = cursor.length(field)
            if length > MOST_NAMES:
                raise BagError(
                    f'{origin}: {field.message} has {length:,} names, and at most {MOST_NAMES:,} '
                    'are read. The publisher is not a clock or a ship'
                )
            texts[field.sample] = tuple(cursor.text(field) for _ in range(length))
        elif field.kind == 'float64[]':
            length = cursor.length(field)
            begin = cursor.skip(field, 8, length) if length else cursor.at
            numbers.append((field.sample, f'({length},){cursor.order}f8', begin))
        elif field.kind == 'time':
            begin = cursor.skip(field, 4, 2)
            numbers.append((f'{field.sample}.sec', f'{cursor.order}i4', begin))
            numbers.append((f'{field.sample}.nanosec', f'{cursor.order}u4', begin + 4))
        else:
            code = NUMBERS[field.kind]
            begin = cursor.skip(field, np.dtype(code).itemsize, field.length)
            shape = f'({field.length},)' if field.length > 1 else ''
            numbers.append((field.sample, f'{shape}{cursor.order}{code}', begin))
    structure = np.dtype(
        {
            'names': [name for name, _, _ in numbers],
            'formats': [code for _, code, _ in numbers],
            'offsets': [place for _, _, place in numbers],
            'itemsize': len(payload),
        }
    )
    rows = np.frombuffer(payload, structure)
    layout = Layout(len(payload), rows, tuple(cursor.words), texts)
    _recent[message.name] = layout
    return layout


def byte_order(origin: str, payload: bytes) -> str:
    """Return numpy's sign of the byte order in the encapsulation header. BagError if not CDR."""
    kind = int.from_bytes(payload[:2], 'big') if len(payload) >= HEADER_BYTES else -1
    if kind not in _BYTE_ORDER:
        head = bytes(payload[:HEADER_BYTES]).hex(' ')
        raise BagError(
            f'{origin}: a payload of {len(payload)} bytes that begins with {head!r} is not plain '
            'CDR (00 00 or 00 01). Record with a ROS 2 middleware'
        )
    return _BYTE_ORDER[kind]


def cut_short(origin: str, what: str, payload: bytes) -> BagError:
    """Return the error for a payload that ends within the field `what`."""
    return BagError(
        f'{origin}: a payload of {len(payload)} bytes ends within {what}. The message is cut or '
        'of another type'
    )


_MOST_LAYOUTS = 32
_BLANK = b'\x00\x01\x00\x00' + bytes(512)
_SECONDS_RANGE = (-(2**31), 2**31 - 1)


def encode(topic: str, samples: Samples) -> list[bytes]:
    """Return one little-endian CDR payload for each sample of a topic of `TOPICS`.

    A batch of another class, arrays of unequal length, times beyond the int32 seconds of a ROS
    message, and strings that UTF-8 or C cannot represent are a BagError.
    """
    message = TOPICS[topic].message
    if not isinstance(samples, message.samples):
        raise BagError(
            f'{topic}: got {type(samples).__name__}, but the topic carries '
            f'{message.samples.__name__}. Hand over a batch of that class'
        )
    values = {field.name: getattr(samples, field.name) for field in fields(samples)}
    _check_shapes(topic, message, values, count(samples))
    # Runs of samples with equal strings have one layout.
    n = count(samples)
    changes = np.zeros(max(n - 1, 0), np.bool_)
    for field in message.fields:
        if field.kind == 'string' and not field.shared and values[field.sample].strides[0]:
            texts = values[field.sample]
            changes |= np.asarray(texts[1:] != texts[:-1], np.bool_)
    bounds = [0, *(np.flatnonzero(changes) + 1).tolist(), n] if n else [0]
    payloads: list[bytes] = []
    for begin, end in pairwise(bounds):
        varying: list[Text] = []
        for field in message.fields:
            value = values[field.sample]
            if field.kind in {'string', 'string[]'}:
                varying.append(value if field.shared else value[begin])
            elif field.kind == 'float64[]':
                varying.append(value.shape[1])
        record, structure = template(topic, tuple(varying))
        size = len(record)
        copies = bytearray(record * (end - begin))
        block = np.frombuffer(copies, structure)
        for field in message.fields:
            if field.kind == 'time':
                seconds, nanoseconds = np.divmod(values[field.sample][begin:end], NS_PER_S)
                low, high = _SECONDS_RANGE
                if not (low <= seconds.min() and seconds.max() <= high):
                    raise BagError(
                        f'{topic}: {field.sample} is between {seconds.min()} s and '
                        f'{seconds.max()} s, but a ROS time is within [{low}, {high}] s. Choose a '
                        'nearer starts_at'
                    )
                block[f'{field.sample}.sec'] = seconds
                block[f'{field.sample}.nanosec'] = nanoseconds
            elif field.kind not in {'string', 'string[]'}:
                block[field.sample] = values[field.sample][begin:end]
        octets = bytes(copies)
        payloads += [octets[at : at + size] for at in range(0, len(octets), size)]
    return payloads


def decode(topic: str, payloads: Sequence[bytes], stamps_ns: IntArray) -> Samples:
    """Return the samples of serialised messages, in their order.

    The topic is a key of `TOPICS`. Payloads are CDR of either byte order, by any publisher. Log
    times become the stamps of messages without a header. Payloads that are not CDR of the topic's
    type, several frames or sets of joint names on one topic, and joint arrays that do not match
    the names are a BagError.
    """
    return decode_as(TOPICS[topic].ros_type, topic, payloads, stamps_ns)


def decode_as(
    ros_type: str, origin: str, payloads: Sequence[bytes], stamps_ns: IntArray
) -> Samples:
    """Return the samples of messages of a type of `MESSAGE_TYPES`, on any topic, as `decode`.

    Errors name `origin`, for example the topic with its bag.
    """
    message, n = MESSAGE_TYPES[ros_type], len(payloads)
    values: dict[str, Any] = {}
    for where, layout in _groups(message, origin, payloads):
        for field in message.fields:
            name = field.sample
            if field.shared:
                text = layout.texts[name]
                if values.setdefault(name, text) != text:
                    raise _mixed(origin, field, repr(values[name]), repr(text))
                continue
            if field.kind == 'string':
                values.setdefault(name, np.empty(n, object))[where] = layout.texts[name]
                continue
            rows = layout.rows
            part = (
                rows[f'{name}.sec'].astype(np.int64) * NS_PER_S + rows[f'{name}.nanosec']
                if field.kind == 'time'
                else rows[name]
            )
            native = part.dtype.newbyteorder('=')
            if name not in values and len(part) == n:
                values[name] = part.astype(native)
                continue
            array = values.setdefault(name, np.empty((n, *part.shape[1:]), native))
            if array.shape[1:] != part.shape[1:]:
                raise _mixed(origin, field, *_lengths(array, part))
            array[where] = part
    if not message.stamped:
        values['stamp_ns'] = np.array(stamps_ns, np.int64)
    samples = message.samples(**values)
    if isinstance(samples, JointSamples) and payloads:
        names = len(samples.name)
        for what in ('position', 'velocity', 'effort'):
            length = getattr(samples, what).shape[1]
            if length != names and (length or what == 'position'):
                raise BagError(
                    f'{origin}: {what} has {length} elements for {names} names. The publisher '
                    'must send one a name' + ('' if what == 'position' else ', or none')
                )
    return samples


def payloads_joined(ros_type: str, origin: str, parts: Sequence[Samples]) -> Samples:
    """Return batches that `decode_as` made of one topic, in their order, as one.

    Several frames or sets of joint names are a BagError, as in `decode`.
    """
    for field in MESSAGE_TYPES[ros_type].fields:
        value, *values = [getattr(part, field.sample) for part in parts]
        for item in values:
            if field.shared and item != value:
                raise _mixed(origin, field, repr(value), repr(item))
            if not field.shared and item.shape[1:] != value.shape[1:]:
                raise _mixed(origin, field, *_lengths(value, item))
    batch: Samples = join(parts)  # type: ignore[type-var]
    return batch


def header_stamp_ns(payload: bytes) -> int:
    """Return the stamp [ns] of a serialised message that begins with a std_msgs/Header.

    A payload that is not CDR or too short for a header is a BagError.
    """
    order = byte_order('message', payload)
    try:
        seconds, nanoseconds = struct.unpack_from(f'{order}iI', payload, HEADER_BYTES)
    except struct.error:
        raise cut_short('message', 'header.stamp', payload) from None
    return int(seconds) * NS_PER_S + int(nanoseconds)


def _groups(
    message: MessageType, origin: str, payloads: Sequence[bytes]
) -> Iterator[tuple[IntArray, Layout]]:
    """Yield payloads of equal layout: their indices, and the layout with all of them as rows.

    After `_MOST_LAYOUTS` the rest is done one by one, which keeps the work proportional to n.
    """
    if len(payloads) < 2:
        layout = scan(message, origin, payloads[0] if payloads else _BLANK)
        yield (
            np.arange(len(payloads)),
            layout if payloads else replace(layout, rows=layout.rows[:0]),
        )
        return
    sizes = np.fromiter(map(len, payloads), np.int64, len(payloads))
    pending = np.arange(len(payloads))
    for _ in range(_MOST_LAYOUTS):
        if not len(pending):
            return
        layout = scan(message, origin, payloads[pending[0]])
        alike = np.flatnonzero(sizes[pending] == layout.size)
        octets = b''.join([payloads[index] for index in pending[alike].tolist()])
        block = np.frombuffer(octets, np.uint8).reshape(len(alike), layout.size)
        fits = np.ones(len(alike), np.bool_)
        for at, word in layout.words:
            fits &= np.all(block[:, at : at + len(word)] == np.frombuffer(word, np.uint8), axis=1)
        rows = block[fits].view(layout.rows.dtype)[:, 0]
        yield pending[alike[fits]], replace(layout, rows=rows)
        pending = np.delete(pending, alike[fits])
    for index in pending.tolist():
        yield np.array([index]), scan(message, origin, payloads[index])


def _lengths(first: NDArray[Any], second: NDArray[Any]) -> tuple[str, str]:
    return f'{first.shape[1]} numbers long', f'{second.shape[1]} numbers long'


def _mixed(origin: str, field: Field, first: str, second: str) -> BagError:
    return BagError(
        f'{origin}: {field.message} is {first} in one message and {second} in another. A topic '
        'must have one source: record or remap them apart'
    )


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
