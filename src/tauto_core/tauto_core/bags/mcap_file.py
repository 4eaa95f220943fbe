"""One MCAP file as spans of records, found by its index or, without one, by reading all of it.

What the records are, `mcap_records` knows.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

from tauto_core.bags.mcap_records import (
    MESSAGE,
    MESSAGE_HEAD,
    RECORD,
    Stored,
    chunk_records,
    messages_in,
    records_in,
)
from tauto_core.scene.errors import BagError

if TYPE_CHECKING:
    from mcap.records import Channel as ChannelRecord
    from mcap.records import Schema
    from mcap.summary import Summary

MAGIC = b'\x89MCAP0\r\n'
SPAN_BYTES = 1 << 20

_SCHEMA, _CHANNEL, _CHUNK = 0x03, 0x04, 0x06
_METADATA, _DATA_END, _FOOTER = 0x0C, 0x0F, 0x02
_FOOTER_RECORD = struct.Struct('<BQQQI')


class Channel(NamedTuple):
    """A topic as one writer recorded it."""

    topic: str
    ros_type: str
    encoding: str
    definition: bytes
    definition_encoding: str
    metadata: Mapping[str, str]


class Recorded(NamedTuple):
    """A stored message with all fields of its record."""

    channel: int
    sequence: int
    stamp_ns: int
    publish_ns: int
    payload: bytes


class Span(NamedTuple):
    """Consecutive records: one chunk, or messages outside of chunks.

    `channels` are the channels of its messages, `None` if unknown.
    """

    offset: int
    length: int
    start_ns: int
    end_ns: int
    channels: frozenset[int] | None
    chunk: bool


@dataclass
class McapFile:
    """The content of a file.

    `warnings` grows when damage is found later, while messages are read. `indexed` says whether a
    valid and complete index listed the contents, `ended` whether the writer closed the data
    section. `description` is the rosbag2 metadata that the file repeats, as YAML, if all of the
    file was read and has it.
    """

    path: Path
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    spans: list[Span] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    indexed: bool = False
    ended: bool = True
    description: str = ''
    _held: tuple[int, bytes] = field(default=(-1, b''), repr=False, compare=False)
    """Offset and records of the span that was read last: the chunk with the scene, with which the
    messages of the voyage begin, is decompressed once for both.
    """

    def messages(
        self, span: Span, stream: BinaryIO, channels: Collection[int] | None = None
    ) -> Iterator[Stored]:
        """Yield the messages of a span in the order of the file; warn of a damaged chunk.

        Args:
            span: the span of this file.
            stream: this file, open.
            channels: those wanted; all when left out.
        """
        yield from messages_in(self._octets(span, stream), channels)

    def recorded(self, span: Span, stream: BinaryIO) -> Iterator[Recorded]:
        """Yield the messages of a span as they were recorded, in the order of the file."""
        octets = self._octets(span, stream)
        for opcode, first, last in records_in(octets):
            if opcode == MESSAGE and last - first >= MESSAGE_HEAD.size:
                head = MESSAGE_HEAD.unpack_from(octets, first)
                payload = octets[first + MESSAGE_HEAD.size : last]
                yield Recorded._make((*head, payload))

    def places(self, span: Span, stream: BinaryIO) -> dict[int, set[tuple[int, int]]]:
        """Return stamp [ns] and offset of each message among the records of a span, by channel."""
        octets = self._octets(span, stream)
        found: dict[int, set[tuple[int, int]]] = {}
        for opcode, first, last in records_in(octets):
            if opcode == MESSAGE and last - first >= MESSAGE_HEAD.size:
                channel, _, stamp_ns, _ = MESSAGE_HEAD.unpack_from(octets, first)
                found.setdefault(channel, set()).add((stamp_ns, first - RECORD.size))
        return found

    def _octets(self, span: Span, stream: BinaryIO) -> bytes:
        """Return the records of a span; none of a damaged chunk, with a warning."""
        offset, octets = self._held
        if offset == span.offset:
            return octets
        stream.seek(span.offset)
        try:
            octets = stream.read(span.length)
            octets = chunk_records(octets) if span.chunk else octets
        except (ValueError, OSError) as error:
            self.warn(f'the chunk at byte {span.offset} is damaged ({error}): it was left out')
            octets = b''
        self._held = span.offset, octets
        return octets

    def warn(self, what: str) -> None:
        """Note damage once."""
        warning = f'{self.path}: {what}'
        if warning not in self.warnings:
            self.warnings.append(warning)


def open_mcap(path: Path, *, walk: bool = False) -> McapFile:
    """Return the content of an MCAP file, from its index, or from all of it without one.

    Args:
        path: the file.
        walk: read all of it, even if it has an index.

    Raises:
        BagError: a file that cannot be opened or is not MCAP.
    """
    file = McapFile(path)
    try:
        with path.open('rb') as stream:
            magic = stream.read(len(MAGIC))
            if magic != MAGIC:
                raise BagError(
                    f'{path} is not an MCAP file: it begins with {magic.hex(" ") or "nothing"}, '
                    f'not {MAGIC.hex(" ")}; name a rosbag2 folder or an .mcap file'
                )
            file.indexed = not walk and _read_index(file, stream)
            if not file.indexed:
                _walk(file, stream)
    except OSError as error:
        raise BagError(f'{path} cannot be read ({error.strerror}); check the path') from error
    return file


def _read_index(file: McapFile, stream: BinaryIO) -> bool:
    """Fill the file from its summary; return whether that is valid and complete."""
    from mcap.exceptions import McapError
    from mcap.reader import SeekingReader

    try:
        if not _has_summary(file, stream):
            return False
        stream.seek(0)
        summary = SeekingReader(stream).get_summary()
    except (McapError, struct.error, ValueError, KeyError, EOFError, OverflowError):
        return False
    if summary is None or summary.statistics is None or not _is_complete(summary):
        return False
    for number, channel in summary.channels.items():
        file.channels[number] = _channel(channel, summary.schemas.get(channel.schema_id))
    file.counts.update(summary.statistics.channel_message_counts)
    file.spans += [
        Span(
            index.chunk_start_offset,
            index.chunk_length,
            index.message_start_time,
            index.message_end_time,
            frozenset(index.message_index_offsets) or None,
            chunk=True,
        )
        for index in sorted(summary.chunk_indexes, key=lambda index: index.chunk_start_offset)
    ]
    return True


def _is_complete(summary: Summary) -> bool:
    """Whether a summary indexes every message of its file."""
    statistics = summary.statistics
    if statistics is None or statistics.chunk_count != len(summary.chunk_indexes):
        return False
    counts = statistics.channel_message_counts
    return (
        sum(counts.values()) == statistics.message_count
        and set(counts) <= set(summary.channels)
        and bool(summary.chunk_indexes or not statistics.message_count)
    )


def _has_summary(file: McapFile, stream: BinaryIO) -> bool:
    """Whether the file ends with a footer, and its summary has the checksum stated there."""
    tail = _FOOTER_RECORD.size + len(MAGIC)
    size = stream.seek(0, 2)
    if size < tail + len(MAGIC):
        return False
    stream.seek(size - tail)
    end = stream.read(tail)
    opcode, length, start, _, crc = _FOOTER_RECORD.unpack_from(end)
    if end[-len(MAGIC) :] != MAGIC or (opcode, length) != (_FOOTER, 20):
        return False
    if not len(MAGIC) < start < size - tail:
        return False
    stream.seek(start)
    summed = stream.read(size - start - len(MAGIC) - 4)
    if crc not in {0, zlib.crc32(summed)}:
        file.warn('its index is damaged; all messages that can be found are read')
        return False
    return True


def _walk(file: McapFile, stream: BinaryIO) -> None:
    """Fill the file from all its records up to the first that is truncated."""
    schemas: dict[int, Schema] = {}
    size = stream.seek(0, 2)
    at = len(MAGIC)
    complete = False
    while at + RECORD.size <= size:
        stream.seek(at)
        opcode, length = RECORD.unpack(stream.read(RECORD.size))
        end = at + RECORD.size + length
        complete = opcode in {_DATA_END, _FOOTER} and end <= size
        if complete:
            break
        if opcode == _CHUNK:
            left = _walk_chunk(file, stream, schemas, at, min(end, size))
            if left and end <= size:
                file.warn(f'the last {left} bytes of the chunk at byte {at} are no record')
        elif end <= size and opcode in {_SCHEMA, _CHANNEL}:
            _register(file, schemas, opcode, stream.read(length))
        elif end <= size and opcode == _METADATA:
            _describe(file, stream.read(length))
        elif end <= size and opcode == MESSAGE and length >= MESSAGE_HEAD.size:
            channel, _, stamp_ns, _ = MESSAGE_HEAD.unpack(stream.read(MESSAGE_HEAD.size))
            _extend(file, Span(at, end - at, stamp_ns, stamp_ns, None, chunk=False), channel)
        at = end
    if not complete:
        file.ended = False
        number = sum(file.counts.values())
        file.warn(
            f'it was cut at byte {size}: it has no end; the {number} messages before the cut can '
            'be read'
        )
        return
    stream.seek(size - len(MAGIC))
    if stream.read() != MAGIC:
        file.warn('it was cut within its index; all messages can be read')


def _walk_chunk(
    file: McapFile, stream: BinaryIO, schemas: dict[int, Schema], at: int, end: int
) -> int:
    """Add a chunk to the file; return the number of octets after its last whole record."""
    stream.seek(at)
    try:
        octets = chunk_records(stream.read(end - at))
    except ValueError as error:
        file.warn(f'the chunk at byte {at} is damaged ({error}): it was left out')
        return 0
    last = 0
    stamps: list[int] = []
    channels: set[int] = set()
    for opcode, first, last in records_in(octets):
        if opcode in {_SCHEMA, _CHANNEL}:
            _register(file, schemas, opcode, octets[first:last])
        elif opcode == MESSAGE and last - first >= MESSAGE_HEAD.size:
            channel, _, stamp_ns, _ = MESSAGE_HEAD.unpack_from(octets, first)
            stamps.append(stamp_ns)
            channels.add(channel)
            file.counts[channel] = file.counts.get(channel, 0) + 1
    if stamps:
        file.spans.append(
            Span(at, end - at, min(stamps), max(stamps), frozenset(channels), chunk=True)
        )
    return len(octets) - last


def _register(file: McapFile, schemas: dict[int, Schema], opcode: int, body: bytes) -> None:
    from mcap import records
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import McapError

    stream = ReadDataStream(BytesIO(body))
    try:
        if opcode == _SCHEMA:
            schema = records.Schema.read(stream)
            schemas[schema.id] = schema
            return
        channel = records.Channel.read(stream)
    except (McapError, struct.error, ValueError) as error:
        file.warn(f'a schema or channel is damaged ({error}): its messages are left out')
        return
    file.channels[channel.id] = _channel(channel, schemas.get(channel.schema_id))
    file.counts.setdefault(channel.id, 0)


def _channel(channel: ChannelRecord, schema: Schema | None) -> Channel:
    return Channel(
        channel.topic,
        _full_name(schema.name if schema else ''),
        channel.message_encoding,
        schema.data if schema else b'',
        schema.encoding if schema else '',
        channel.metadata,
    )


def _describe(file: McapFile, body: bytes) -> None:
    """Keep the rosbag2 metadata; damage in it is found when the file is checked."""
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import McapError
    from mcap.records import Metadata

    try:
        record = Metadata.read(ReadDataStream(BytesIO(body)))
    except (McapError, struct.error, ValueError) as error:
        file.warn(f'a metadata record is damaged ({error})')
        return
    if record.name == 'rosbag2':
        file.description = record.metadata.get('serialized_metadata', '')


def _extend(file: McapFile, span: Span, channel: int) -> None:
    """Add a message outside of chunks, to the last span if it follows that one."""
    file.counts[channel] = file.counts.get(channel, 0) + 1
    last = file.spans[-1] if file.spans else None
    follows = last and not last.chunk and last.offset + last.length == span.offset
    if last and follows and last.length < SPAN_BYTES:
        span = Span(
            last.offset,
            last.length + span.length,
            min(last.start_ns, span.start_ns),
            max(last.end_ns, span.end_ns),
            None,
            chunk=False,
        )
        file.spans.pop()
    file.spans.append(span)


def _full_name(name: str) -> str:
    """Return `package/msg/Type`, also from the short form `package/Type`."""
    package, _, kind = name.partition('/')
    return name if '/' in kind or not kind else f'{package}/msg/{kind}'
