"""MCAP as octets: records, one file as spans of records, and one being written."""

from __future__ import annotations

import errno
import os
import struct
import tempfile
import zlib
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO, FileIO, RawIOBase
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

from tauto_core.scene.errors import BagError

if TYPE_CHECKING:
    from mcap.records import Channel as ChannelRecord
    from mcap.records import McapRecord, Schema
    from mcap.summary import Summary


# -----------------------------------------------------------------------------
# MCAP as octets: records, the messages among them, and what a chunk holds.
#
# A record is an opcode, a length and a body, both in the file and in a decompressed chunk (MCAP
# specification, sections Records and Chunk). Whole records before a truncation can be read; a
# compressed chunk can be read only as a whole.

MESSAGE = 0x05
RECORD = struct.Struct('<BQ')
"""Opcode and length of a record."""

MESSAGE_HEAD = struct.Struct('<HIQQ')
"""Channel, sequence, log time and publish time of a message."""

# opcode, length and fields in one, without sequence and publish time
_MESSAGE_RECORD = struct.Struct('<BQH4xQ8x')
_CHUNK_HEAD = struct.Struct('<QQQII')


class Stored(NamedTuple):
    """A stored message."""

    stamp_ns: int
    channel: int
    payload: bytes


def chunk_records(record: bytes) -> bytes:
    """Return the records of a chunk; of an uncompressed one that is truncated, those before.

    Raises:
        ValueError: says what is damaged.
    """
    try:
        _, _, size, crc, name_length = _CHUNK_HEAD.unpack_from(record, RECORD.size)
        first = RECORD.size + _CHUNK_HEAD.size
        compression = record[first : first + name_length].decode()
        (length,) = struct.unpack_from('<Q', record, first + name_length)
    except struct.error:
        raise ValueError('its head is cut') from None
    first += name_length + 8
    body = record[first : first + length]
    if compression == '' and len(body) < length:
        return body
    if len(body) < length:
        raise ValueError(f'{len(body)} of {length} bytes')
    octets = _decompress(compression, body, size)
    if len(octets) != size or (crc and zlib.crc32(octets) != crc):
        raise ValueError('wrong checksum')
    return octets


def _decompress(compression: str, body: bytes, size: int) -> bytes:
    if compression == 'zstd':
        return _decompress_zstd(body, size)
    if compression == 'lz4':
        return _decompress_lz4(body)
    if compression:
        raise ValueError(f'compression {compression!r}, where zstd, lz4 or none can be read')
    return body


def _decompress_zstd(body: bytes, size: int) -> bytes:
    import zstandard

    try:
        return zstandard.decompress(body, size)
    except (zstandard.ZstdError, MemoryError, OverflowError) as error:
        raise ValueError(str(error)) from None


def _decompress_lz4(body: bytes) -> bytes:
    import lz4.frame  # type: ignore[import-untyped]

    try:
        return bytes(lz4.frame.decompress(body))
    except (RuntimeError, EOFError, MemoryError) as error:
        raise ValueError(str(error)) from None


def records_in(octets: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of the body of each whole record."""
    at = 0
    while at + RECORD.size <= len(octets):
        opcode, length = RECORD.unpack_from(octets, at)
        first = at + RECORD.size
        at = first + length
        if at > len(octets):
            return
        yield opcode, first, at


def messages_in(octets: bytes, channels: Collection[int] | None) -> Iterator[Stored]:
    """Yield the whole messages among records, of some channels.

    A chunk has messages of all topics, few of which may be wanted, so skipping must be cheap.
    """
    at, size, skipped = 0, len(octets), RECORD.size + MESSAGE_HEAD.size
    head_of = _MESSAGE_RECORD.unpack_from
    while at + skipped <= size:
        opcode, length, channel, stamp_ns = head_of(octets, at)
        end = at + RECORD.size + length
        if end > size:
            return
        wanted = opcode == MESSAGE and (channels is None or channel in channels)
        if wanted and length >= MESSAGE_HEAD.size:
            yield Stored(stamp_ns, channel, octets[at + skipped : end])
        at = end


# -----------------------------------------------------------------------------
# One MCAP file as spans of records, found by its index or, without one, by reading all of it.
#
# What the records are is said above.

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


# -----------------------------------------------------------------------------
# One MCAP file being written, so that it can be completed wherever the writing stops.
#
# The writer of the mcap library changes its state before it writes a chunk, so after an interrupt
# or a full disk it cannot finish the file. Here one value describes the content of the file. A
# chunk counts once that value is replaced, and anything after its end is cut off. The index has a
# record for each chunk and is written last; until then it is in an unnamed temporary file, so
# memory does not grow with the voyage. Another such file keeps room on the disk for the end of
# this one. Records other than messages and their index are written by the library.

CHUNK_BYTES = 64 * 1024

_MAGIC = b'\x89MCAP0\r\n'
_MESSAGE = struct.Struct('<BQHIQQ')
_MESSAGE_BYTES = 22
_MESSAGE_INDEX = struct.Struct('<BQHI')
_FOOTER_BYTES = 20
_PIECE_BYTES = 1 << 20
_ROOM_BYTES = 16 * 1024
"""Room for statistics, footer and what file systems round up; also the step in which it grows."""

_NO_STAMP_NS = 2**64 - 1


class DeclaredTopic(NamedTuple):
    """A topic as declared in a bag: full name, type and its definition, QoS as YAML, type hash."""

    name: str
    ros_type: str
    definition: bytes
    qos: str
    type_hash: str
    encoding: str = 'cdr'
    definition_encoding: str = 'ros2msg'


class _Pending(NamedTuple):
    """A record of the next chunk; channel 0 if it is not a message."""

    channel: int
    stamp_ns: int
    record: bytes


class _Stored(NamedTuple):
    """The content of the file: chunks up to `end`, whose index records end at `index_end`.

    `counts` are the messages by channel; the stamps are the earliest and the latest, if there are
    any.
    """

    end: int
    counts: Counter[int]
    index_end: int = 0
    chunks: int = 0
    first_ns: int = _NO_STAMP_NS
    last_ns: int = 0


class McapOut:
    """An MCAP file of profile ros2, in chunks.

    Args:
        path: a file that must not exist.
        library: name of the writer in the header.
        chunk_bytes: size, before compression, at which a chunk is written.
        compression: compression of the chunks, `zstd` or `none`.

    Raises:
        BagError: any error of the file system, when opening and in use. The part that has been
            written can still be finished.
    """

    def __init__(
        self,
        path: Path,
        library: str,
        *,
        chunk_bytes: int = CHUNK_BYTES,
        compression: str = 'zstd',
    ) -> None:
        from mcap.records import Header
        from zstandard import ZstdCompressor

        self.path = path
        self._chunk_bytes = chunk_bytes
        self._compression = '' if compression == 'none' else compression
        self._compress = ZstdCompressor().compress if self._compression else bytes
        self._definitions: list[McapRecord] = []
        self._definition_bytes = 0
        self.described_bytes = 0
        """Size of the metadata that will be written after the messages, to keep room for them."""
        self._room_bytes = 0
        self._channels = 0
        self._schemas: dict[str, int] = {}
        self._pending: dict[int, list[_Pending]] = {}
        self._pending_bytes = 0
        head = _MAGIC + _record(Header('ros2', library))
        self._stored = _Stored(len(head), Counter())
        try:
            self._raw = FileIO(path, 'x')
            self._index = tempfile.TemporaryFile(dir=path.parent, buffering=0)  # noqa: SIM115
            self._room = tempfile.TemporaryFile(dir=path.parent, buffering=0)  # noqa: SIM115
            _write(self._raw, 0, head)
        except OSError as error:
            raise refused(path, error) from error

    @property
    def counts(self) -> dict[int, int]:
        """Messages in the file by channel, without those of the next chunk."""
        return {channel: self._stored.counts[channel] for channel in range(1, self._channels + 1)}

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """Earliest and latest stamp in the file [ns]; `None` if it holds no message."""
        stored = self._stored
        return (stored.first_ns, stored.last_ns) if stored.chunks else None

    @property
    def end(self) -> int:
        """End of the last chunk [bytes]."""
        return self._stored.end

    def add_channel(self, declared: DeclaredTopic) -> int:
        """Register a topic; return its channel's number, from 1."""
        from mcap.records import Channel, Schema

        ros_type = declared.ros_type
        if ros_type not in self._schemas:
            self._schemas[ros_type] = len(self._schemas) + 1
            self._define(
                Schema(
                    id=self._schemas[ros_type],
                    name=ros_type,
                    encoding=declared.definition_encoding,
                    data=declared.definition,
                )
            )
        self._channels += 1
        self._define(
            Channel(
                id=self._channels,
                schema_id=self._schemas[ros_type],
                topic=declared.name,
                message_encoding=declared.encoding,
                metadata={
                    'offered_qos_profiles': declared.qos,
                    'topic_type_hash': declared.type_hash,
                },
            )
        )
        return self._channels

    def add_message(
        self,
        channel: int,
        sequence: int,
        stamp_ns: int,
        payload: bytes,
        publish_ns: int | None = None,
    ) -> None:
        """Add a message; its log time, and its publish time if none is given, is its stamp."""
        size = _MESSAGE_BYTES + len(payload)
        published_ns = stamp_ns if publish_ns is None else publish_ns
        head = _MESSAGE.pack(0x05, size, channel, sequence, stamp_ns, published_ns)
        self._collected().append(_Pending(channel, stamp_ns, head + payload))
        self._pending_bytes += size
        if self._pending_bytes > self._chunk_bytes:
            self.flush()

    def finish(self, metadata: str) -> None:
        """Write the next chunk, the rosbag2 metadata, the index and the end."""
        from mcap.records import DataEnd, Metadata, MetadataIndex

        self.flush()
        end = self.end
        self._raw.truncate(end)
        described = _record(Metadata('rosbag2', {'serialized_metadata': metadata}))
        data_end = _record(DataEnd(0))
        index = MetadataIndex(offset=end, length=len(described), name='rosbag2')
        start = end + len(described) + len(data_end)
        at, crc = start, 0
        try:
            _write(self._raw, end, described + data_end)
            for piece in self._summary(start, index):
                _write(self._raw, at, piece)
                at, crc = at + len(piece), zlib.crc32(piece, crc)
            _write(self._raw, at, struct.pack('<I', crc) + _MAGIC)
            os.fsync(self._raw.fileno())
        except OSError as error:
            self._raw.truncate(end)
            raise refused(self.path, error) from error

    def give_up(self) -> None:
        """Drop the next chunk and the room kept, so that the file can be finished without it."""
        self._pending.clear()
        self._room.close()

    def close(self) -> None:
        """Close the file."""
        self._raw.close()
        self._index.close()
        self._room.close()

    def _keep_room(self, index_bytes: int) -> None:
        """Take the disk space that the end of the file will need; `give_up` returns it."""
        needed = self._definition_bytes + index_bytes + self.described_bytes + _ROOM_BYTES
        if needed > self._room_bytes:
            more = needed - self._room_bytes + _ROOM_BYTES
            _write(self._room, self._room_bytes, bytes(more))
            self._room_bytes += more

    def _collected(self) -> list[_Pending]:
        """Return the records of the next chunk; a chunk that counts begins a new list."""
        return self._pending.setdefault(self._stored.chunks, [])

    def _define(self, record: McapRecord) -> None:
        octets = _record(record)
        self._definitions.append(record)
        self._definition_bytes += len(octets)
        self._collected().append(_Pending(0, 0, octets))

    def flush(self) -> None:
        """Write the next chunk. If that fails the chunk is kept, and may be tried again."""
        pending = self._collected()
        if not any(entry.channel for entry in pending):
            return
        octets, index, after = self._chunk(pending)
        stored = self._stored
        try:
            self._keep_room(after.index_end)
            _write(self._raw, stored.end, octets)
            _write(self._index, stored.index_end, index)
        except OSError as error:
            self._raw.truncate(stored.end)
            raise refused(self.path, error) from error
        self._stored = after
        self._pending.pop(stored.chunks, None)
        self._pending_bytes = 0

    def _chunk(self, pending: list[_Pending]) -> tuple[bytes, bytes, _Stored]:
        """Return a chunk and its indices, its index record, and the content after it."""
        from mcap.records import Chunk, ChunkIndex

        rows: dict[int, list[tuple[int, int]]] = {}
        at = 0
        for channel, stamp_ns, record in pending:
            if channel:
                rows.setdefault(channel, []).append((stamp_ns, at))
            at += len(record)
        records = b''.join([record for _, _, record in pending])
        packed = self._compress(records)
        stamps = [stamp_ns for channel, stamp_ns, _ in pending if channel]
        span: dict[str, Any] = {
            'message_start_time': min(stamps),
            'message_end_time': max(stamps),
            'uncompressed_size': len(records),
            'compression': self._compression,
        }
        chunk = _record(Chunk(data=packed, uncompressed_crc=zlib.crc32(records), **span))
        indices = b''
        offsets: dict[int, int] = {}
        for channel, entries in rows.items():
            offsets[channel] = self.end + len(chunk) + len(indices)
            body = struct.pack(f'<{2 * len(entries)}Q', *chain.from_iterable(entries))
            indices += _MESSAGE_INDEX.pack(0x07, 6 + len(body), channel, len(body)) + body
        index = ChunkIndex(
            chunk_start_offset=self.end,
            chunk_length=len(chunk),
            compressed_size=len(packed),
            message_index_length=len(indices),
            message_index_offsets=offsets,
            **span,
        )
        octets, record, stored = chunk + indices, _record(index), self._stored
        after = _Stored(
            stored.end + len(octets),
            stored.counts + Counter({channel: len(found) for channel, found in rows.items()}),
            stored.index_end + len(record),
            stored.chunks + 1,
            min(stored.first_ns, *stamps),
            max(stored.last_ns, *stamps),
        )
        return octets, record, after

    def _summary(self, start: int, metadata: McapRecord) -> Iterator[bytes]:
        """Yield the summary section, which begins at `start`, and the footer without its CRC."""
        from mcap.opcode import Opcode
        from mcap.records import Schema, SummaryOffset

        schemas = [record for record in self._definitions if isinstance(record, Schema)]
        channels = [record for record in self._definitions if not isinstance(record, Schema)]
        groups: tuple[tuple[Opcode, Iterable[bytes]], ...] = (
            (Opcode.SCHEMA, map(_record, schemas)),
            (Opcode.CHANNEL, map(_record, channels)),
            (Opcode.STATISTICS, [_record(self._statistics())]),
            (Opcode.CHUNK_INDEX, self._index_pieces()),
            (Opcode.METADATA_INDEX, [_record(metadata)]),
        )
        at, offsets = start, b''
        for opcode, pieces in groups:
            group_start = at
            for piece in pieces:
                at += len(piece)
                yield piece
            if at > group_start:
                offsets += _record(SummaryOffset(opcode, group_start, at - group_start))
        yield offsets + struct.pack('<BQQQ', Opcode.FOOTER, _FOOTER_BYTES, start, at)

    def _index_pieces(self) -> Iterator[bytes]:
        """Yield the records of the chunks from the index file."""
        self._index.seek(0)
        left = self._stored.index_end
        while left:
            piece = self._index.read(min(left, _PIECE_BYTES))
            if not piece:
                raise OSError(errno.EIO, f'the last {left} bytes of its index are lost')
            left -= len(piece)
            yield piece

    def _statistics(self) -> McapRecord:
        from mcap.records import Statistics

        counts = self.counts
        first_ns, last_ns = self.span_ns or (0, 0)
        return Statistics(
            attachment_count=0,
            channel_count=self._channels,
            channel_message_counts=counts,
            chunk_count=self._stored.chunks,
            message_count=sum(counts.values()),
            message_start_time=first_ns,
            message_end_time=last_ns,
            metadata_count=1,
            schema_count=len(self._schemas),
        )


def _write(stream: RawIOBase, at: int, octets: bytes) -> None:
    """Write all bytes at the current place."""
    rest = memoryview(octets)
    stream.seek(at)
    while rest:
        rest = rest[stream.write(rest) or 0 :]


def refused(path: Path, error: OSError) -> BagError:
    """Return the error for a file that the file system refuses to write."""
    return BagError(
        f'{path} cannot be written ({error.strerror}); make room or name another folder. What the '
        'bag held before can be read'
    )


def _record(record: McapRecord) -> bytes:
    from mcap.data_stream import RecordBuilder

    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]
