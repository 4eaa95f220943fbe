"""Reading bags: a rosbag2 folder or a bare MCAP file, by any recorder, complete or truncated."""

from __future__ import annotations

import heapq
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
from tauto_core.files import decompressed
from tauto_core.samples import SCENE, Batches, IntArray, Samples, TextSamples
from tauto_core.scene.errors import BagError, BagPlaceError
from tauto_core.scene.tables import read_data

if TYPE_CHECKING:
    from mcap.records import Channel as ChannelRecord
    from mcap.records import Schema

METADATA = 'metadata.yaml'
LARGEST_METADATA = 2**24

# -----------------------------------------------------------------------------
# MCAP as octets: records, the messages among them, and the content of chunks.
#
# A record is an opcode, a length and a body, both in the file and in a decompressed chunk (MCAP
# specification, sections Records and Chunk). Whole records before a truncation can be read; a
# compressed chunk can be read only as a whole.

MESSAGE = 0x05
RECORD = struct.Struct('<BQ')
"""Opcode and length of a record."""

MESSAGE_HEAD = struct.Struct('<HIQQ')
"""Channel, sequence, log time and publish time of a message."""

# opcode, length and fields in one, without sequence and publish time: quicker where few are wanted
_MESSAGE_RECORD = struct.Struct('<BQH4xQ8x')
_CHUNK_HEAD = struct.Struct('<QQQII')


class Stored(NamedTuple):
    """A stored message."""

    stamp_ns: int
    channel: int
    payload: bytes


def chunk_records(record: bytes) -> bytes:
    """Return the records of a chunk; of an uncompressed one that is truncated, those before.

    The ValueError names the damaged part.
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
    octets = decompressed(compression, body, size)
    if len(octets) != size or (crc and zlib.crc32(octets) != crc):
        raise ValueError('wrong checksum')
    return octets


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


def heads_in(octets: bytes) -> Iterator[tuple[int, int, tuple[int, int, int, int]]]:
    """Yield begin and end of the body of each whole message, and the fields of its head."""
    for opcode, first, last in records_in(octets):
        if opcode == MESSAGE and last - first >= MESSAGE_HEAD.size:
            yield first, last, MESSAGE_HEAD.unpack_from(octets, first)


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


class RecordedMessage(NamedTuple):
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
    counts: Counter[int] = field(default_factory=Counter)
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

        The file is open as `stream`. Without channels all are wanted.
        """
        yield from messages_in(self._octets(span, stream), channels)

    def recorded(self, span: Span, stream: BinaryIO) -> Iterator[RecordedMessage]:
        """Yield the messages of a span as they were recorded, in the order of the file."""
        octets = self._octets(span, stream)
        for first, last, head in heads_in(octets):
            yield RecordedMessage(*head, octets[first + MESSAGE_HEAD.size : last])

    def places(self, span: Span, stream: BinaryIO) -> dict[int, set[tuple[int, int]]]:
        """Return stamp [ns] and offset of each message among the records of a span, by channel."""
        found: dict[int, set[tuple[int, int]]] = defaultdict(set)
        for first, _, (channel, _, stamp_ns, _) in heads_in(self._octets(span, stream)):
            found[channel].add((stamp_ns, first - RECORD.size))
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

    With `walk` all of it is read, even if it has an index. A file that cannot be opened or is not
    MCAP is a BagError.
    """
    file = McapFile(path)
    try:
        if not path.is_file() and path.exists():  # to open a pipe may block for ever
            raise BagError(f'{path} is not a regular file; name a rosbag2 folder or an .mcap file')
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
    if summary is None or summary.statistics is None:
        return False
    statistics, chunks = summary.statistics, summary.chunk_indexes
    counts = statistics.channel_message_counts
    if (
        statistics.chunk_count != len(chunks)
        or sum(counts.values()) != statistics.message_count
        or not set(counts) <= set(summary.channels)
        or (statistics.message_count and not chunks)
    ):
        return False
    for number, channel in summary.channels.items():
        file.channels[number] = _channel(channel, summary.schemas.get(channel.schema_id))
    file.counts = Counter(counts)
    file.spans += [
        Span(
            index.chunk_start_offset,
            index.chunk_length,
            index.message_start_time,
            index.message_end_time,
            frozenset(index.message_index_offsets) or None,
            chunk=True,
        )
        for index in sorted(chunks, key=lambda index: index.chunk_start_offset)
    ]
    return True


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
                file.warn(f'the last {left} bytes of the chunk at byte {at} are not a record')
        elif end <= size and opcode in {_SCHEMA, _CHANNEL, _METADATA}:
            _register(file, schemas, opcode, stream.read(length))
        elif end <= size and opcode == MESSAGE and length >= MESSAGE_HEAD.size:
            channel, _, stamp_ns, _ = MESSAGE_HEAD.unpack(stream.read(MESSAGE_HEAD.size))
            file.counts[channel] += 1
            span = Span(at, end - at, stamp_ns, stamp_ns, None, chunk=False)
            last = file.spans[-1] if file.spans else None
            follows = last and not last.chunk and last.offset + last.length == at
            if last and follows and last.length < SPAN_BYTES:  # one span for both
                span = last._replace(
                    length=last.length + span.length,
                    start_ns=min(last.start_ns, stamp_ns),
                    end_ns=max(last.end_ns, stamp_ns),
                )
                file.spans.pop()
            file.spans.append(span)
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
    last, heads = 0, []
    for opcode, first, last in records_in(octets):
        if opcode in {_SCHEMA, _CHANNEL}:
            _register(file, schemas, opcode, octets[first:last])
        elif opcode == MESSAGE and last - first >= MESSAGE_HEAD.size:
            heads.append(MESSAGE_HEAD.unpack_from(octets, first))
    if heads:
        channels, _, stamps, _ = zip(*heads, strict=True)
        file.counts.update(channels)
        file.spans.append(
            Span(at, end - at, min(stamps), max(stamps), frozenset(channels), chunk=True)
        )
    return len(octets) - last


def _register(file: McapFile, schemas: dict[int, Schema], opcode: int, body: bytes) -> None:
    """Keep a schema, a channel or rosbag2's metadata; their damage is found by `check_bag`."""
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
    """A bag opened for reading; messages stay in the files until they are read.

    A topic is named in full (`/clock_a/ship/imu`) or by its relative name (`ship/imu`). A relative
    name stands for the one topic of the bag that ends with it, or that is in `namespace` if given.
    """

    path: Path
    files: tuple[McapFile, ...]
    namespace: str | None
    """Namespace of the topics of the table (`''`: the root); `None` where they have none or
    several.
    """
    notes: tuple[str, ...] = ()
    logged_from_ns: dict[str, int] = field(default_factory=dict, init=False, compare=False)
    """Log time of the first message [ns] of each topic that `parts` or `batches` has read."""

    @property
    def topics(self) -> dict[str, str]:
        """ROS type of each topic, by full name."""
        return {topic: types[0] for topic, types in self._types().items()}

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
        """Earliest log time [ns]; `None` if there is no message."""
        return min((span.start_ns for file in self.files for span in file.spans), default=None)

    @property
    def end_ns(self) -> int | None:
        """Latest log time [ns]; `None` if there is no message."""
        return max((span.end_ns for file in self.files for span in file.spans), default=None)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Descriptions of the unreadable parts, and of the messages missing therefore.

        Damage within a chunk is found when its messages are read, and reported from then on.
        """
        return self.notes + tuple(warning for file in self.files for warning in file.warnings)

    @cached_property
    def scenes(self) -> TextSamples | None:
        """The messages of the `scene` topic, read once; `None` where the bag has none."""
        matches = self._matches(SCENE)
        if not matches or (len(matches) == 1 and self.topics[matches[0]] != STRING.name):
            return None
        samples = self.samples(SCENE)
        return samples if isinstance(samples, TextSamples) and len(samples.data) else None

    @property
    def scene(self) -> str | None:
        """The text of the `scene` topic, its last message; `None` where the bag has none."""
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
        """Return the full name of a topic; none such, or several that match, is a BagError."""
        matches = self._matches(topic)
        if len(matches) == 1:
            return matches[0]
        if matches:
            raise BagError(
                f'{self.path}: {topic} may be {" or ".join(matches)}; name one namespace'
            )
        held = ', '.join(self.topics) or 'none'
        raise BagError(f'{self.path}: there is no topic {topic}; its topics are: {held}')

    def _matches(self, topic: str) -> list[str]:
        topics = self._types()
        if topic.startswith('/'):
            return [topic] if topic in topics else []
        if self.namespace is not None and topic in TOPICS:
            full = '/'.join(['', *self.namespace.split('/'), topic]).replace('//', '/')
            return [found for found in topics if f'/{found.lstrip("/")}' == full]
        return [found for found in topics if f'/{found.lstrip("/")}'.endswith(f'/{topic}')]

    def _types(self) -> dict[str, list[str]]:
        types: dict[str, dict[str, None]] = defaultdict(dict)
        for file in self.files:
            for channel in file.channels.values():
                types[channel.topic][channel.ros_type] = None
        return {topic: list(known) for topic, known in types.items()}

    def _stored(self, topics: Collection[str]) -> Iterator[tuple[str, Stored]]:
        """Yield messages with their topics, file after file; refuse another type or encoding."""
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
        for found in self._types()[full]:
            if found != wanted:
                raise BagError(
                    f'{self.path}: {full} holds {found or "messages without a type"}, but '
                    f'must hold {wanted}; remap that topic or name another bag'
                )
        for file in self.files:
            for channel in file.channels.values():
                if channel.topic == full and channel.encoding != 'cdr':
                    raise BagError(
                        f'{self.path}: {full} is encoded as {channel.encoding!r}, but ROS 2 '
                        "messages are 'cdr'; record it with ROS 2"
                    )

    def _decode(self, topic: str, payloads: list[bytes], stamps: list[int]) -> Samples:
        full = self.find(topic)
        ros_type = self.topics[full]
        if ros_type not in MESSAGE_TYPES:
            raise BagError(
                f'{self.path}: {full} holds {ros_type or "messages without a type"}; what can be '
                f'decoded is {", ".join(MESSAGE_TYPES)}'
            )
        origin = f'{self.path}: {full}'
        return decode_as(ros_type, origin, payloads, np.array(stamps, np.int64))


def read_bag(path: Path | str, *, namespace: str | None = None) -> Bag:
    """Open a bag: a rosbag2 folder, with or without its metadata, or an MCAP file.

    Without a namespace the topics of the table are taken from the one in which they are found.
    Nothing there, not MCAP, compressed file by file, or no topic of the table in the namespace is
    a BagError.
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
    if namespace is not None and namespace.strip('/') not in places:
        held = ', '.join(f'/{place}' for place in places) or 'none'
        raise BagError(f'{path}: there is no namespace {namespace!r}; its namespaces are: {held}')
    if namespace is None and len(places) == 1:
        namespace = places[0]
    return Bag(path, files, None if namespace is None else namespace.strip('/'), tuple(notes))


def find_files(path: Path, notes: list[str]) -> list[Path]:
    """Return the MCAP files of a bag in the order of recording; note missing ones."""
    if not path.exists():
        raise BagPlaceError(f'{path} does not exist; name a rosbag2 folder or an .mcap file')
    if not path.is_dir():
        return [path]
    found = sorted(path.glob('*.mcap'), key=by_number)
    if (path / METADATA).exists():
        listed = _listed_files(path / METADATA)
        lost = [file.name for file in listed if not file.exists()]
        if found and len(lost) == len(listed):
            raise BagError(
                f'{path} has other .mcap files than its {METADATA} names ({", ".join(lost)}); '
                f'give them these names again, or say `tauto bag recover {path}`'
            )
        notes += [f'{path}: {name}, named by {METADATA}, is missing' for name in lost]
        found = [file for file in listed if file.exists()]
    elif found:
        notes.append(f'{path}: it has no {METADATA}: the recording did not end by itself')
    if not found:
        raise BagError(
            f'{path} holds no .mcap file; name a rosbag2 folder with MCAP storage, or convert it '
            'with `ros2 bag convert`'
        )
    return found


def _listed_files(metadata: Path) -> list[Path]:
    import yaml

    try:
        content: Any = yaml.safe_load(read_data(metadata, LARGEST_METADATA))
        information = content['rosbag2_bagfile_information']
        names = [str(name) for name in information['relative_file_paths']]
        storage = information.get('storage_identifier', 'mcap')
        mode = str(information.get('compression_mode') or '').lower()
    except (OSError, ValueError, KeyError, TypeError, AttributeError, yaml.YAMLError) as error:
        raise BagError(
            f'{metadata} cannot be understood ({error}); name the .mcap file beside it'
        ) from None
    if storage != 'mcap' or mode in {'file', 'message'}:
        what = f'{storage} storage' if storage != 'mcap' else f'compression by {mode}'
        raise BagError(
            f'{metadata.parent} has {what}, but MCAP with chunk compression can be read; convert '
            'it with `ros2 bag convert`'
        )
    return [metadata.parent / Path(name).name for name in names]


def by_number(file: Path) -> tuple[int, str]:
    """Return a sorting key that puts `bag_2.mcap` before `bag_10.mcap`."""
    number = re.search(r'_(\d+)$', file.stem)
    return (int(number[1]) if number else -1, file.name)
