"""Reading bags: a rosbag2 folder or a bare MCAP file, by any recorder, complete or truncated."""

from __future__ import annotations

import heapq
import os
import re
import struct
import zlib
from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

import numpy as np

from tauto_core.bags.codec import decode_as, payloads_joined
from tauto_core.bags.table import MESSAGE_TYPES, STRING, TOPICS
from tauto_core.files import LARGEST_PART, LARGEST_YAML, YamlError, decompressed, read_yaml
from tauto_core.samples import SCENE, Batches, IntArray, Samples, TextSamples
from tauto_core.scene.errors import BagError, BagPlaceError
from tauto_core.scene.tables import read_data

if TYPE_CHECKING:
    from mcap.records import Channel as ChannelRecord
    from mcap.records import Schema

METADATA = 'metadata.yaml'

# -----------------------------------------------------------------------------
# MCAP as octets: records, the messages among them, and the content of chunks.
#
# A record is an opcode, a length and a body, both in the file and in a decompressed chunk (MCAP
# specification, sections Records and Chunk). Whole records before a truncation can be read, but a
# compressed chunk only as a whole. Every length is compared with the bytes left, before anything
# is read or allocated.

MESSAGE = 0x05
RECORD = struct.Struct('<BQ')
"""Opcode and length of a record."""

MESSAGE_HEAD = struct.Struct('<HIQQ')
"""Channel, sequence, log time and publish time of a message."""

_MESSAGE_RECORD = struct.Struct('<BQHIQQ')
_CHUNK_HEAD = struct.Struct('<QQQII')


LATEST_NS = 2**63 - 1
"""The latest log time, of the year 2262. Messages with a later one are left out."""


class RecordedMessage(NamedTuple):
    """A stored message with all fields of its record."""

    channel: int
    sequence: int
    stamp_ns: int
    publish_ns: int
    payload: bytes


def chunk_records(record: bytes) -> bytes:
    """Return the records of a chunk: of a cut uncompressed one, those before the cut.

    The ValueError names the damaged part.
    """
    try:
        opcode, _ = RECORD.unpack_from(record)
        _, _, size, crc, name_length = _CHUNK_HEAD.unpack_from(record, RECORD.size)
        begin = RECORD.size + _CHUNK_HEAD.size
        compression = record[begin : begin + name_length].decode()
        (length,) = struct.unpack_from('<Q', record, begin + name_length)
    except struct.error:
        raise ValueError('its head is cut') from None
    if opcode != _CHUNK:
        raise ValueError('it is another record')
    begin += name_length + 8
    body = record[begin : begin + length]
    if compression == '' and len(body) < length:
        return body
    if len(body) < length:
        raise ValueError(f'{len(body)} of {length} bytes')
    octets = decompressed(compression, body, size)
    if len(octets) != size:
        raise ValueError(f'it becomes {len(octets)} bytes and states {size}')
    if crc not in (0, zlib.crc32(octets)):
        raise ValueError('wrong checksum')
    return octets


def records_in(octets: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of the body of each whole record."""
    at = 0
    while at + RECORD.size <= len(octets):
        opcode, length = RECORD.unpack_from(octets, at)
        begin = at + RECORD.size
        at = begin + length
        if at > len(octets):
            return
        yield opcode, begin, at


def messages_in(octets: bytes, channels: Collection[int] | None) -> Iterator[RecordedMessage]:
    """Yield the whole messages among records, of some channels.

    A chunk has messages of all topics, few of which may be wanted, so skipping must be cheap.
    """
    at, size, skipped = 0, len(octets), RECORD.size + MESSAGE_HEAD.size
    head_of = _MESSAGE_RECORD.unpack_from
    while at + skipped <= size:
        opcode, length, channel, sequence, stamp_ns, publish_ns = head_of(octets, at)
        end = at + RECORD.size + length
        if end > size:
            return
        wanted = opcode == MESSAGE and (channels is None or channel in channels)
        if wanted and length >= MESSAGE_HEAD.size and stamp_ns <= LATEST_NS:
            payload = octets[at + skipped : end]
            yield RecordedMessage(channel, sequence, stamp_ns, publish_ns, payload)
        at = end


# -----------------------------------------------------------------------------
# One MCAP file as spans of records, found by its index or, without one, by reading all of it.

MAGIC = b'\x89MCAP0\r\n'
SPAN_BYTES = 1 << 20

_FOOTER, _SCHEMA, _CHANNEL, _CHUNK, _MESSAGE_INDEX = 0x02, 0x03, 0x04, 0x06, 0x07
_METADATA, _DATA_END = 0x0C, 0x0F
_FOOTER_RECORD = struct.Struct('<BQQQI')
INDEX_HEAD = struct.Struct('<HI')
"""Channel and size of a message index, before its entries."""
ENTRY = struct.Struct('<QQ')
"""Log time and offset of a message, an entry of a message index."""


class Channel(NamedTuple):
    """A topic as declared in a bag: full name, type and its definition.

    The metadata of rosbag2 are the QoS as YAML and the hash of the type.
    """

    topic: str
    ros_type: str
    encoding: str
    definition: bytes
    definition_encoding: str
    metadata: Mapping[str, str]


class Hole(NamedTuple):
    """Messages of a topic that are lost.

    Their `number` and topic are 0 and empty if unknown. The log times of the first and the last,
    or of their neighbours, are in ns.
    """

    topic: str
    number: int
    from_ns: int
    to_ns: int

    def __str__(self) -> str:
        return (
            f'{self.number:,} messages of {self.topic}' if self.topic else 'messages'
        ) + f' are lost, from {self.from_ns * 1e-9:.9g} s to {self.to_ns * 1e-9:.9g} s'


class Span(NamedTuple):
    """Consecutive records: one chunk, or messages outside of chunks.

    The `channels` of its messages are `None` if unknown.
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

    Attributes:
        warnings: damage, also if found later, while messages are read.
        indexed: whether a valid and complete index listed the contents.
        ended: whether the writer closed the data section.
        description: the rosbag2 metadata that the file repeats, as YAML.
        holes: the messages of damaged chunks, if all of the file was read.
    """

    path: Path
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: Counter[int] = field(default_factory=Counter)
    spans: list[Span] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    indexed: bool = False
    ended: bool = True
    description: str = ''
    holes: list[Hole] = field(default_factory=list)
    _octets_of: tuple[int, bytes] = field(default=(-1, b''), repr=False, compare=False)
    """Offset and records of the span that was read last: the chunk with the scene, with which the
    messages of the voyage begin, is decompressed once for both.
    """

    def messages(
        self, span: Span, stream: BinaryIO, channels: Collection[int] | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield the messages of a span in the order of the file. Warn of a damaged chunk.

        The file is open as `stream`. Without channels all messages are returned.
        """
        yield from messages_in(self._octets(span, stream), channels)

    def _octets(self, span: Span, stream: BinaryIO) -> bytes:
        """Return the records of a span. A damaged chunk is empty, and causes a warning."""
        offset, octets = self._octets_of
        if offset == span.offset:
            return octets
        try:
            stream.seek(span.offset)
            octets = stream.read(min(span.length, LARGEST_PART))
            if span.chunk:
                octets = chunk_records(octets)
        except (ValueError, OSError) as error:
            self.warn(f'the chunk at byte {span.offset} is damaged ({error}): it was left out')
            octets = b''
        self._octets_of = span.offset, octets
        return octets

    def warn(self, what: str) -> None:
        """Note damage once."""
        warning = f'{self.path}: {what}'
        if warning not in self.warnings:
            self.warnings.append(warning)


def open_mcap(path: Path, *, walk: bool = False) -> McapFile:
    """Return the content of an MCAP file, from its index, or from all of it without one.

    With `walk` all of it is read, even if it has an index. A file that cannot be opened or is not
    MCAP is a BagError.
    """
    file = McapFile(path)
    try:
        if not path.is_file() and path.exists():  # to open a pipe may block for ever
            raise BagError(f'{path} is not a regular file. Name a rosbag2 folder or an .mcap file')
        with path.open('rb') as stream:
            magic = stream.read(len(MAGIC))
            if magic != MAGIC:
                raise BagError(
                    f'{path} is not an MCAP file: it begins with {magic.hex(" ") or "nothing"}, '
                    f'not {MAGIC.hex(" ")}. Name a rosbag2 folder or an .mcap file'
                )
            file.indexed = not walk and _read_index(file, stream)
            if not file.indexed:
                _walk(file, stream)
    except OSError as error:
        raise BagError(f'{path} cannot be read ({error.strerror}). Check the path') from error
    return file


def _read_index(file: McapFile, stream: BinaryIO) -> bool:
    """Fill the file from its summary. Return whether that is valid and complete."""
    from mcap import records
    from mcap.exceptions import McapError
    from mcap.stream_reader import StreamReader

    start, octets = _summary(file, stream)
    by_type: dict[type, list[Any]] = defaultdict(list)
    try:
        reader = StreamReader(BytesIO(octets), skip_magic=True, record_size_limit=len(octets))
        for record in reader.records:
            by_type[type(record)].append(record)
    except (McapError, struct.error, ValueError, OverflowError):
        return False
    schemas: dict[int, Schema] = {schema.id: schema for schema in by_type[records.Schema]}
    channels = {
        channel.id: _channel(channel, schemas.get(channel.schema_id))
        for channel in by_type[records.Channel]
    }
    chunks = sorted(by_type[records.ChunkIndex], key=lambda chunk: chunk.chunk_start_offset)
    if len(by_type[records.Statistics]) != 1:
        return False
    [statistics] = by_type[records.Statistics]
    counts = statistics.channel_message_counts
    if (
        statistics.chunk_count != len(chunks)
        or sum(counts.values()) != statistics.message_count
        or not set(counts) <= set(channels)
        or (statistics.message_count and not chunks)
    ):
        return False
    # the index follows the listed chunks, which follow each other
    end, spans = len(MAGIC), []
    for chunk in chunks:
        places = chunk.message_index_offsets
        if (
            chunk.chunk_start_offset < end
            or max(chunk.chunk_start_offset + chunk.chunk_length, *places.values(), 0) > start
            or max(chunk.message_start_time, chunk.message_end_time) > LATEST_NS
        ):
            file.warn('its index is damaged. All readable messages are read')
            return False
        end = chunk.chunk_start_offset + chunk.chunk_length
        spans.append(
            Span(
                chunk.chunk_start_offset,
                chunk.chunk_length,
                chunk.message_start_time,
                chunk.message_end_time,
                frozenset(places) or None,
                chunk=True,
            )
        )
    file.channels, file.counts, file.spans = channels, Counter(counts), spans
    for place in by_type[records.MetadataIndex]:
        if place.name == 'rosbag2' and place.offset + place.length <= start:
            stream.seek(place.offset + RECORD.size)
            _register(file, schemas, _METADATA, stream.read(min(place.length, LARGEST_PART)))
    return True


def _summary(file: McapFile, stream: BinaryIO) -> tuple[int, bytes]:
    """Return the start of the summary and the bytes from there on, or 0 and b'' if damaged.

    The footer at the end of the file states the checksum of the summary.
    """
    tail = _FOOTER_RECORD.size + len(MAGIC)
    size = stream.seek(0, 2)
    if size < tail + len(MAGIC):
        return 0, b''
    stream.seek(size - tail)
    end = stream.read(tail)
    opcode, length, start, _, crc = _FOOTER_RECORD.unpack_from(end)
    has_end = end[-len(MAGIC) :] == MAGIC and (opcode, length) == (_FOOTER, 20)
    if not has_end or not max(len(MAGIC), size - LARGEST_PART) < start < size - tail:
        return 0, b''
    stream.seek(start)
    octets = stream.read(size - start)
    if crc not in {0, zlib.crc32(octets[: -len(MAGIC) - 4])}:
        file.warn('its index is damaged. All readable messages are read')
        return 0, b''
    return start, octets


def _walk(file: McapFile, stream: BinaryIO) -> None:
    """Fill the file from all its records up to the first that is truncated.

    A valid index gives topics with lost definitions, and the times of lost chunks.
    """
    index = McapFile(file.path)
    spans: dict[int, Span] = {}
    if _read_index(index, stream):
        file.channels |= index.channels
        spans = {span.offset: span for span in index.spans}
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
            _walk_chunk(file, stream, schemas, at, min(end, size), spans.get(at))
        elif end <= size and opcode in {_SCHEMA, _CHANNEL, _METADATA}:
            _register(file, schemas, opcode, stream.read(min(length, LARGEST_PART)))
        elif end <= size and opcode == MESSAGE and length >= MESSAGE_HEAD.size:
            channel, _, stamp_ns, _ = MESSAGE_HEAD.unpack(stream.read(MESSAGE_HEAD.size))
            _add_message(file, Span(at, end - at, stamp_ns, stamp_ns, None, chunk=False), channel)
        at = end
    if not complete:
        file.ended = False
        number = sum(file.counts.values())
        file.warn(
            f'it was cut at byte {size}: it has no end. The {number} messages before the cut can '
            'be read'
        )
        return
    opcode = 0
    while at + RECORD.size <= size and opcode != _FOOTER:  # the summary
        stream.seek(at)
        opcode, length = RECORD.unpack(stream.read(RECORD.size))
        at += RECORD.size + length
    stream.seek(min(at, size))
    has_end = opcode == _FOOTER and stream.read(len(MAGIC)) == MAGIC
    extra = size - at - len(MAGIC)
    stream.seek(size - len(MAGIC))
    if not has_end and stream.read() != MAGIC:
        file.warn('it was cut within its index. All messages can be read')
    elif has_end and extra:
        stream.seek(size - extra)
        what = 'are another MCAP file: cut them off' * (stream.read(len(MAGIC)) == MAGIC)
        file.warn(
            f'{extra} bytes follow its end at byte {size - extra}: they {what or "are not read"}'
        )


def _walk_chunk(
    file: McapFile,
    stream: BinaryIO,
    schemas: dict[int, Schema],
    at: int,
    end: int,
    entry: Span | None,
) -> None:
    """Add a chunk to the file, or its content to the holes. `entry` is its entry in the index."""
    stream.seek(at)
    record = stream.read(min(end - at, LARGEST_PART))
    cut = len(record) < RECORD.size + RECORD.unpack_from(record)[1]
    octets, is_damaged = b'', False
    try:
        octets = chunk_records(record)
    except ValueError as error:
        is_damaged = True
        file.warn(f'the chunk at byte {at} is damaged ({error}): it was left out')
    stop, heads = 0, []
    for opcode, start, stop in records_in(octets):
        if opcode in {_SCHEMA, _CHANNEL}:
            _register(file, schemas, opcode, octets[start:stop])
        elif opcode == MESSAGE and stop - start >= MESSAGE_HEAD.size:
            heads.append(MESSAGE_HEAD.unpack_from(octets, start))
    fit = [head for head in heads if head[2] <= LATEST_NS]
    if len(fit) < len(heads):
        file.warn(f'{len(heads) - len(fit)} messages of the chunk at byte {at} have {_TOO_LATE}')
    if fit:
        channels, _, stamps, _ = zip(*fit, strict=True)
        file.counts.update(channels)
        file.spans.append(
            Span(at, end - at, min(stamps), max(stamps), frozenset(channels), chunk=True)
        )
    if is_damaged and not cut:
        stream.seek(end)
        file.holes += _indexed(file, stream.read(16 * len(record)), entry)
    elif len(octets) > stop and not cut:
        file.warn(
            f'the last {len(octets) - stop} bytes of the chunk at byte {at} are not a record'
        )


_TOO_LATE = f'a log time after {LATEST_NS} ns: they were left out'


def _add_message(file: McapFile, span: Span, channel: int) -> None:
    """Add a message outside of chunks to the file, in one span with those just before it."""
    if span.start_ns > LATEST_NS:
        file.warn(f'messages outside of chunks have {_TOO_LATE}')
        return
    file.counts[channel] += 1
    previous = file.spans[-1] if file.spans else None
    follows = previous and not previous.chunk and previous.offset + previous.length == span.offset
    if previous and follows and previous.length < SPAN_BYTES:  # one span for both
        file.spans[-1] = previous._replace(
            length=previous.length + span.length,
            start_ns=min(previous.start_ns, span.start_ns),
            end_ns=max(previous.end_ns, span.end_ns),
        )
    else:
        file.spans.append(span)


def _indexed(file: McapFile, octets: bytes, entry: Span | None) -> list[Hole]:
    """Return the content of a damaged chunk, by the message indices that follow it.

    Without one, by its entry in the file's index, or by the message before it.
    """
    holes: list[Hole] = []
    for opcode, begin, end in records_in(octets):
        if opcode != _MESSAGE_INDEX or (end - begin - INDEX_HEAD.size) % ENTRY.size:
            break
        channel, _ = INDEX_HEAD.unpack_from(octets, begin)
        entries = ENTRY.iter_unpack(octets[begin + INDEX_HEAD.size : end])
        stamps = [stamp_ns for stamp_ns, _ in entries]
        if stamps and channel in file.channels:
            topic = file.channels[channel].topic
            holes.append(Hole(topic, len(stamps), min(stamps), max(stamps)))
    span = entry or (
        file.spans[-1]._replace(start_ns=file.spans[-1].end_ns) if file.spans else None
    )
    return holes or [Hole('', 0, *(span[2:4] if span else (0, 0)))]


def _register(file: McapFile, schemas: dict[int, Schema], opcode: int, body: bytes) -> None:
    """Keep a schema, a channel or rosbag2's metadata. `check_bag` finds their damage."""
    from mcap import records
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import McapError

    stream = ReadDataStream(BytesIO(body))
    try:
        if opcode == _METADATA:
            record = records.Metadata.read(stream)
            if record.name == 'rosbag2':
                file.description = record.metadata.get('serialized_metadata', '')
            return
        if opcode == _SCHEMA:
            schema = records.Schema.read(stream)
            schemas[schema.id] = schema
            return
        channel = records.Channel.read(stream)
    except (McapError, struct.error, ValueError) as error:
        if opcode == _METADATA:
            file.warn(f'a metadata record is damaged ({error})')
        else:
            file.warn(f'a schema or channel is damaged ({error}): its messages are left out')
        return
    file.channels[channel.id] = _channel(channel, schemas.get(channel.schema_id))
    file.counts.setdefault(channel.id, 0)


def _channel(channel: ChannelRecord, schema: Schema | None) -> Channel:
    name = schema.name if schema else ''
    package, _, kind = name.partition('/')
    if kind and '/' not in kind:  # the short form
        name = f'{package}/msg/{kind}'
    return Channel(
        channel.topic,
        name,
        channel.message_encoding,
        schema.data if schema else b'',
        schema.encoding if schema else '',
        channel.metadata,
    )


# -----------------------------------------------------------------------------
# A bag: the messages of its files by topic.

_PART = 100_000


class Message(NamedTuple):
    """A recorded message: full topic name, ROS type, log time [ns], CDR payload."""

    topic: str
    ros_type: str
    stamp_ns: int
    payload: bytes


@dataclass(frozen=True)
class Bag:
    """A bag opened for reading. Messages stay in the files until they are read.

    A topic is named in full (`/clock_a/ship/imu`) or by its relative name (`ship/imu`), which
    means the one topic of the bag that ends with it, or the one in `namespace` if given.
    """

    path: Path
    files: tuple[McapFile, ...]
    namespace: str | None
    """Namespace of the topics of the table (`''`: the root). `None` if missing or not unique."""
    notes: tuple[str, ...] = ()
    logged_from_ns: dict[str, int] = field(default_factory=dict, init=False, compare=False)
    """Log time of the first message [ns] of each topic that `parts` or `batches` has read."""

    @property
    def topics(self) -> dict[str, str]:
        """ROS type of each topic, by full name."""
        return {topic: next(iter(types)) for topic, (types, _) in self._types.items()}

    @property
    def counts(self) -> dict[str, int]:
        """Number of messages of each topic, by full name."""
        counts: Counter[str] = Counter()
        for file in self.files:
            for number, channel in file.channels.items():
                counts[channel.topic] += file.counts[number]
        return dict(counts)

    @property
    def start_ns(self) -> int | None:
        """Earliest log time [ns], or `None` without a message."""
        return min((span.start_ns for file in self.files for span in file.spans), default=None)

    @property
    def end_ns(self) -> int | None:
        """Latest log time [ns], or `None` without a message."""
        return max((span.end_ns for file in self.files for span in file.spans), default=None)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Descriptions of the unreadable parts, and of the messages missing therefore.

        Damage within a chunk is found when its messages are read, and reported from then on.
        """
        return self.notes + tuple(warning for file in self.files for warning in file.warnings)

    @cached_property
    def scenes(self) -> TextSamples | None:
        """The messages of the `scene` topic, read once, or `None` without one."""
        matches = self._matches(SCENE)
        if not matches or (len(matches) == 1 and self.topics[matches[0]] != STRING.name):
            return None
        samples = self.samples(SCENE)
        return samples if isinstance(samples, TextSamples) and len(samples.data) else None

    @property
    def scene(self) -> str | None:
        """The text of the `scene` topic, its last message, or `None` without one."""
        return None if self.scenes is None else str(self.scenes.data[-1])

    def __contains__(self, topic: str) -> bool:
        """Whether the bag has the topic."""
        return bool(self._matches(topic))

    def samples(self, topic: str) -> Samples:
        """Return all messages of a topic as one batch, in the order of the recording.

        No such topic, several that match, another message type than in the table, a type that is
        not in the table, or payloads that do not decode are a BagError.
        """
        return self.batches([topic])[topic]

    def batches(self, topics: Collection[str]) -> Batches:
        """Return all messages of several topics, one batch a topic, in one pass over the files."""
        read: dict[str, list[Samples]] = {topic: [] for topic in topics}
        for topic, part in self.parts(topics):
            read[topic].append(part)
        types, full = self.topics, {topic: self.find(topic) for topic in topics}
        return {
            topic: payloads_joined(
                types[full[topic]],
                f'{self.path}: {full[topic]}',
                parts or [self._decode(topic, [], [])],
            )
            for topic, parts in read.items()
        }

    def parts(self, topics: Collection[str], size: int = _PART) -> Iterator[tuple[str, Samples]]:
        """Yield topics as batches of at most `size` samples, for bags larger than the memory.

        The batches of one topic come in the order of the recording.
        """
        waiting: dict[str, tuple[list[int], list[bytes]]] = {topic: ([], []) for topic in topics}
        for topic, stored in self._stored(topics):
            stamps, payloads = waiting[topic]
            self.logged_from_ns.setdefault(topic, stored.stamp_ns)
            stamps.append(stored.stamp_ns)
            payloads.append(stored.payload)
            if len(stamps) == size:
                waiting[topic] = [], []
                yield topic, self._decode(topic, payloads, stamps)
        for topic, (stamps, payloads) in waiting.items():
            if stamps:
                yield topic, self._decode(topic, payloads, stamps)

    def payloads(self, topic: str) -> tuple[IntArray, list[bytes]]:
        """Return log times and CDR payloads of a topic, in the order of the recording."""
        stored = [message for _, message in self._stored([topic])]
        stamps = np.array([message.stamp_ns for message in stored], np.int64)
        return stamps, [message.payload for message in stored]

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Message]:
        """Yield the messages of all topics, or of some, in the order of their log times.

        Only spans that overlap in time are held in memory. Messages of equal time keep the file's
        order.
        """
        wanted = None if topics is None else {self.find(topic) for topic in topics}
        spans = sorted(
            (span.start_ns, index, span)
            for index, file in enumerate(self.files)
            for span in file.spans
        )
        waiting: list[tuple[int, int, int, int, Message]] = []
        for start_ns, index, span in spans:
            while waiting and waiting[0][0] < start_ns:
                yield heapq.heappop(waiting)[-1]
            file = self.files[index]
            with file.path.open('rb') as stream:
                for number, stored in enumerate(file.messages(span, stream)):
                    channel = file.channels.get(stored.channel)
                    if channel and (wanted is None or channel.topic in wanted):
                        message = Message(
                            channel.topic, channel.ros_type, stored.stamp_ns, stored.payload
                        )
                        key = (stored.stamp_ns, index, span.offset, number)
                        heapq.heappush(waiting, (*key, message))
        while waiting:
            yield heapq.heappop(waiting)[-1]

    def find(self, topic: str) -> str:
        """Return the full name of a topic. BagError: no topic matches, or several do."""
        matches = self._matches(topic)
        if len(matches) == 1:
            return matches[0]
        if matches:
            raise BagError(
                f'{self.path}: {topic} may be {" or ".join(matches)}. Name one namespace'
            )
        names = ', '.join(self.topics) or 'none'
        damage = f'. {self.warnings[0]}. See tauto bag check' if self.warnings else ''
        raise BagError(f'{self.path}: there is no topic {topic}. Its topics are: {names}{damage}')

    def _matches(self, topic: str) -> list[str]:
        topics = self._types
        if topic.startswith('/'):
            return [topic] if topic in topics else []
        if self.namespace is not None and topic in TOPICS:
            full = '/'.join(['', *self.namespace.split('/'), topic]).replace('//', '/')
            return [name for name in topics if f'/{name.lstrip("/")}' == full]
        return [name for name in topics if f'/{name.lstrip("/")}'.endswith(f'/{topic}')]

    @cached_property
    def _types(self) -> dict[str, tuple[dict[str, None], dict[str, None]]]:
        """The types and the encodings of each topic, in the order of the channels."""
        table: dict[str, tuple[dict[str, None], dict[str, None]]] = {}
        for file in self.files:
            for channel in file.channels.values():
                types, encodings = table.setdefault(channel.topic, ({}, {}))
                types[channel.ros_type] = encodings[channel.encoding] = None
        return table

    def _stored(self, topics: Collection[str]) -> Iterator[tuple[str, RecordedMessage]]:
        """Yield messages with their topics, file after file. Refuse another type or encoding."""
        wanted = {self.find(topic): topic for topic in topics}
        for full, topic in wanted.items():
            ros_type = TOPICS[topic].ros_type if topic in TOPICS else self.topics[full]
            self.check_type(full, ros_type)
        for file in self.files:
            topic_of = {
                number: wanted[channel.topic]
                for number, channel in file.channels.items()
                if channel.topic in wanted
            }
            with file.path.open('rb') as stream:
                for span in file.spans:
                    if span.channels is not None and span.channels.isdisjoint(topic_of):
                        continue
                    for stored in file.messages(span, stream, topic_of):
                        yield topic_of[stored.channel], stored

    def check_type(self, full: str, wanted: str) -> None:
        """Refuse a topic, by its full name, that is not all of one type in CDR (BagError)."""
        types, encodings = self._types[full]
        for actual in types:
            if actual != wanted:
                raise BagError(
                    f'{self.path}: {full} holds {actual or "messages without a type"}, but '
                    f'must hold {wanted}. Remap that topic or name another bag'
                )
        for encoding in encodings:
            if encoding != 'cdr':
                raise BagError(
                    f'{self.path}: {full} is encoded as {encoding!r}, but ROS 2 messages are '
                    "'cdr'. Record it with ROS 2"
                )

    def _decode(self, topic: str, payloads: list[bytes], stamps: list[int]) -> Samples:
        full = self.find(topic)
        ros_type = self.topics[full]
        if ros_type not in MESSAGE_TYPES:
            raise BagError(
                f'{self.path}: {full} holds {ros_type or "messages without a type"}. Tauto '
                f'decodes {", ".join(MESSAGE_TYPES)}'
            )
        origin = f'{self.path}: {full}'
        return decode_as(ros_type, origin, payloads, np.array(stamps, np.int64))


def read_bag(path: Path | str) -> Bag:
    """Open a bag: a rosbag2 folder, with or without its metadata, or an MCAP file.

    The topics of the table are taken from their namespace in the bag. BagError: the bag is
    missing, not MCAP, or compressed file by file.
    """
    path = Path(path)
    notes: list[str] = []
    files = tuple(open_mcap(file) for file in find_files(path, notes))
    bag = Bag(path, files, None, tuple(notes))
    places = sorted(
        {
            full[: -len(name) - 1].strip('/')
            for full, ros_type in bag.topics.items()
            for name, topic in TOPICS.items()
            if f'/{full.lstrip("/")}'.endswith(f'/{name}') and ros_type == topic.ros_type
        }
    )
    return Bag(path, files, places[0] if len(places) == 1 else None, tuple(notes))


def find_files(path: Path, notes: list[str]) -> list[Path]:
    """Return the MCAP files of a bag in the order of recording. Note missing ones."""
    if not path.exists():
        raise BagPlaceError(f'{path} does not exist. Name a rosbag2 folder or an .mcap file')
    if not path.is_dir():
        return [path]
    files = sorted(path.glob('*.mcap'), key=by_number)
    if (path / METADATA).exists():
        listed = _listed_files(path / METADATA)
        lost = [file.name for file in listed if not os.path.exists(file)]
        if files and len(lost) == len(listed):
            raise BagError(
                f'{path} has other .mcap files than its {METADATA} names '
                f'({", ".join(lost)[:99]}). Give them these names again, or say '
                f'`tauto bag recover {path}`'
            )
        notes += [f'{path}: {name}, named by {METADATA}, is missing' for name in lost]
        files = [file for file in listed if os.path.exists(file)]
    elif files:
        notes.append(f'{path}: it has no {METADATA}: the recording did not end by itself')
    if not files:
        raise BagError(
            f'{path} holds no .mcap file. Name a rosbag2 folder with MCAP storage, or convert it '
            'with `ros2 bag convert`'
        )
    return files


def _listed_files(metadata: Path) -> list[Path]:
    try:
        content = read_yaml(read_data(metadata, LARGEST_YAML).decode('utf-8'), any_key=True)
        information = content['rosbag2_bagfile_information']
        names = [Path(str(name)).name for name in information['relative_file_paths']]
        storage = information.get('storage_identifier', 'mcap')
        mode = str(information.get('compression_mode') or '').lower()
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        why = error.problem if isinstance(error, YamlError) else error
        raise BagError(
            f'{metadata} cannot be understood ({why}). Name the .mcap file beside it'
        ) from None
    if storage != 'mcap' or mode in {'file', 'message'}:
        what = f'compression by {mode}' if storage == 'mcap' else f'{str(storage)[:80]} storage'
        raise BagError(
            f'{metadata.parent} has {what}, but MCAP with chunk compression can be read. Convert '
            'it with `ros2 bag convert`'
        )
    if twice := next((name for name, number in Counter(names).items() if number > 1), None):
        raise BagError(
            f'{metadata} names {twice[:80]} twice. Name the .mcap files beside it one by one'
        )
    return [metadata.parent / name for name in names]


def by_number(file: Path) -> tuple[int, str]:
    """Return a sorting key that puts `bag_2.mcap` before `bag_10.mcap`."""
    number = re.search(r'_(\d+)$', file.stem)
    return (int(number[1]) if number else -1, file.name)
