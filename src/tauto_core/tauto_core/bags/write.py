"""Writing bags: a rosbag2 folder with one MCAP file, as `ros2 bag` of Jazzy makes it."""

from __future__ import annotations

import json
import os
import shutil
import struct
import tempfile
import warnings
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from io import FileIO, RawIOBase
from itertools import chain
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from tauto_core.bags.codec import encode
from tauto_core.bags.read import MAGIC, MESSAGE, MESSAGE_HEAD, METADATA, Channel, RecordedMessage
from tauto_core.bags.table import TOPICS, Topic, offered_qos
from tauto_core.files import DRAFTS, exchange, one_writer, sync_folder, write_whole
from tauto_core.samples import SCENE, Batches, count
from tauto_core.scene.errors import Argument, BagError, BagPlaceError, TautoWarning
from tauto_core.version import identity

if TYPE_CHECKING:
    from mcap.records import McapRecord

# -----------------------------------------------------------------------------
# One MCAP file being written, which can be completed wherever the writing stops.
#
# The writer of the mcap library changes its state before it writes a chunk, so after an interrupt
# or a full disk it cannot finish the file. Here one value describes the content of the file. A
# chunk counts once that value is replaced, and anything after its end is cut off. The index has a
# record for each chunk and is written last. Until then it is in an unnamed temporary file, so
# memory does not grow with the voyage. Another such file keeps room on the disk for the end of
# this one. Records other than messages and their index are written by the library.

CHUNK_BYTES = 512 * 1024
"""Size of a chunk before compression.

An eighth of it would make a bag 2.5 % larger. A larger size gains little: the rest of the index is
16 bytes for each message, which readers such as `ros2 bag` need.
"""

_MESSAGE = struct.Struct('<BQHIQQ')
_MESSAGE_INDEX = struct.Struct('<BQHI')
_FOOTER_BYTES = 20
_PIECE_BYTES = 1 << 20
# Room for statistics, footer and rounding by file systems, and the step in which it grows.
_ROOM_BYTES = 16 * 1024

_NO_STAMP_NS = 2**64 - 1  # the largest stamp of MCAP, above any other


class _Pending(NamedTuple):
    """A record of the next chunk. Channel 0 if it is not a message."""

    channel: int
    stamp_ns: int
    record: bytes


class _Stored(NamedTuple):
    """The content of the file: chunks up to `end`, index records up to `index_end`.

    `counts` are the messages by channel. The stamps are the earliest and the latest, if any.
    """

    end: int
    counts: Counter[int]
    index_end: int = 0
    chunks: int = 0
    first_ns: int = _NO_STAMP_NS
    last_ns: int = 0


class McapOut:
    """A new MCAP file of profile ros2, in chunks.

    A chunk is written at `chunk_bytes` before compression, `zstd` or `none`. Any error of the file
    system, when opening and in use, is a BagError. The part that has been written can still be
    finished.
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
        head = MAGIC + _record(Header('ros2', library))
        self._stored = _Stored(len(head), Counter())
        with ExitStack() as opened:
            try:
                self._raw = opened.enter_context(FileIO(path, 'x'))
                self._index, self._room = (
                    opened.enter_context(tempfile.TemporaryFile(dir=path.parent, buffering=0))
                    for _ in '12'
                )
                _write(self._raw, 0, head)
            except OSError as error:
                raise refused(path, error) from error
            opened.pop_all()

    @property
    def counts(self) -> dict[int, int]:
        """Messages in the file by channel, without the next chunk."""
        return {channel: self._stored.counts[channel] for channel in range(1, self._channels + 1)}

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """Earliest and latest stamp in the file [ns], or `None` without a message."""
        stored = self._stored
        return (stored.first_ns, stored.last_ns) if stored.chunks else None

    def add_channel(self, declared: Channel) -> int:
        """Register a topic. Return its channel's number, from 1."""
        from mcap.records import Channel as ChannelRecord
        from mcap.records import Schema

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
            ChannelRecord(
                id=self._channels,
                schema_id=self._schemas[ros_type],
                topic=declared.topic,
                message_encoding=declared.encoding,
                metadata=dict(declared.metadata),
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
        """Add a message. Its stamp is the log time and, unless given, the publish time."""
        size = MESSAGE_HEAD.size + len(payload)
        published_ns = stamp_ns if publish_ns is None else publish_ns
        head = _MESSAGE.pack(MESSAGE, size, channel, sequence, stamp_ns, published_ns)
        self._collected().append(_Pending(channel, stamp_ns, head + payload))
        self._pending_bytes += size
        if self._pending_bytes > self._chunk_bytes:
            self.flush()

    def finish(self, metadata: str) -> None:
        """Write the next chunk, the rosbag2 metadata, the index and the end."""
        from mcap.records import DataEnd, Metadata, MetadataIndex

        self.flush()
        end = self._stored.end
        described = _record(Metadata('rosbag2', {'serialized_metadata': metadata}))
        data_end = _record(DataEnd(0))
        index = MetadataIndex(offset=end, length=len(described), name='rosbag2')
        start = end + len(described) + len(data_end)
        at, crc = start, 0
        try:
            self._raw.truncate(end)
            _write(self._raw, end, described + data_end)
            for piece in self._summary(start, index):
                _write(self._raw, at, piece)
                at, crc = at + len(piece), zlib.crc32(piece, crc)
            _write(self._raw, at, struct.pack('<I', crc) + MAGIC)
            os.fsync(self._raw.fileno())
        except OSError as error:
            self._cut(end)
            raise refused(self.path, error) from error

    def _cut(self, end: int) -> None:
        """Cut the file after its last chunk, unless the disk refuses this, too."""
        with suppress(OSError):
            self._raw.truncate(end)

    def give_up(self) -> None:
        """Drop the next chunk and the reserved room, to finish the file without it."""
        self._pending.clear()
        self._room.close()

    def close(self) -> None:
        """Close the file."""
        self._raw.close()
        self._index.close()
        self._room.close()

    def _collected(self) -> list[_Pending]:
        """Return the records of the next chunk. A chunk that counts begins a new list."""
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
        octets, index, state = self._chunk(pending)
        stored = self._stored
        try:
            # The disk space that the end of the file will need. `give_up` returns it.
            needed = self._definition_bytes + state.index_end + self.described_bytes + _ROOM_BYTES
            if needed > self._room_bytes:
                growth = needed - self._room_bytes + _ROOM_BYTES
                _write(self._room, self._room_bytes, bytes(growth))
                self._room_bytes += growth
            _write(self._raw, stored.end, octets)
            _write(self._index, stored.index_end, index)
        except OSError as error:
            self._cut(stored.end)
            raise refused(self.path, error) from error
        self._stored = state
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
            offsets[channel] = self._stored.end + len(chunk) + len(indices)
            body = struct.pack(f'<{2 * len(entries)}Q', *chain.from_iterable(entries))
            indices += _MESSAGE_INDEX.pack(0x07, 6 + len(body), channel, len(body)) + body
        index = ChunkIndex(
            chunk_start_offset=self._stored.end,
            chunk_length=len(chunk),
            compressed_size=len(packed),
            message_index_length=len(indices),
            message_index_offsets=offsets,
            **span,
        )
        octets, record, stored = chunk + indices, _record(index), self._stored
        state = _Stored(
            stored.end + len(octets),
            stored.counts + Counter({channel: len(entries) for channel, entries in rows.items()}),
            stored.index_end + len(record),
            stored.chunks + 1,
            min(stored.first_ns, *stamps),
            max(stored.last_ns, *stamps),
        )
        return octets, record, state

    def _summary(self, start: int, metadata: McapRecord) -> Iterator[bytes]:
        """Yield the summary section, which begins at `start`, and the footer without its CRC."""
        from mcap.opcode import Opcode
        from mcap.records import Schema, Statistics, SummaryOffset

        self._index.truncate(self._stored.index_end)
        self._index.seek(0)
        schemas = [record for record in self._definitions if isinstance(record, Schema)]
        channels = [record for record in self._definitions if not isinstance(record, Schema)]
        counts = self.counts
        first_ns, last_ns = self.span_ns or (0, 0)
        statistics = Statistics(
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
        groups: tuple[tuple[Opcode, Iterable[bytes]], ...] = (
            (Opcode.SCHEMA, map(_record, schemas)),
            (Opcode.CHANNEL, map(_record, channels)),
            (Opcode.STATISTICS, [_record(statistics)]),
            (Opcode.CHUNK_INDEX, iter(lambda: self._index.read(_PIECE_BYTES), b'')),
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


def _write(stream: RawIOBase, at: int, octets: bytes) -> None:
    """Write all bytes at the current place."""
    view = memoryview(octets)
    stream.seek(at)
    while view:
        view = view[stream.write(view) or 0 :]


def refused(path: Path, error: OSError) -> BagError:
    """Return the error for a file that the file system refuses to write."""
    return BagError(
        f'{path} cannot be written ({error.strerror}). Make room or name another folder. What the '
        'bag held before can be read'
    )


def _record(record: McapRecord) -> bytes:
    from mcap.data_stream import RecordBuilder

    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


# -----------------------------------------------------------------------------
# The folder of a bag, which one process writes at a time and puts in place as a whole.

QOS, TYPE_HASH = 'offered_qos_profiles', 'topic_type_hash'
"""Metadata of a channel."""

CUT_SHORT = {'cut_short': True}
"""Metadata of a bag that ended before its voyage."""

_METADATA_VERSION = 9  # of Jazzy's rosbag2
BUDGET = 'budget.json'
"""File in the bag's folder with the budget of the voyage's rate. It goes when the bag is replaced.
"""
_OF_A_BAG = (METADATA, '*.mcap', DRAFTS, BUDGET)
_EMPTY_START_NS = 2**63 - 1  # as rosbag2 writes it of a bag without messages
_SEQUENCE_MASK = 2**32 - 1  # the field has 32 bits


def check_folder(folder: Path, *, force: bool = False) -> None:
    """Refuse a folder to which a bag may not be written (BagPlaceError).

    It exists without `force`, it holds anything but one bag, or another process is writing it.
    """
    folder = _real(folder)
    try:
        with suppress(FileNotFoundError, NotADirectoryError), _one_writer(folder, make=False):
            pass
    except OSError as error:
        raise BagPlaceError(
            f'{folder} cannot be used ({error.strerror}). Name another folder'
        ) from error
    _check_replaceable(folder, force=force)


def _real(folder: Path) -> Path:
    """Return the real path of a folder, next to which its drafts are written."""
    return folder.resolve() if folder.is_symlink() or not folder.name else folder


def _check_replaceable(folder: Path, *, force: bool) -> None:
    if not folder.exists():
        return
    if not force:
        raise BagPlaceError(
            f'{folder} exists already. Name another folder, or say ',
            Argument('force', value=True),
            ' to replace it',
        )
    for place in (folder, _sibling(folder, '.partial'), _sibling(folder, '.replaced')):
        if not place.exists():
            continue
        if not place.is_dir():
            raise BagPlaceError(f'{place} is a file, not the folder of a bag. Name another folder')
        names = sorted(
            entry.name
            for entry in place.iterdir()
            if entry.is_dir() or not any(map(entry.match, _OF_A_BAG))
        )
        if names:
            raise BagPlaceError(
                f'{place} is not only a bag: it holds {names[0]!r}, which replacing would lose. '
                'Name another folder, or move the other files'
            )


@contextmanager
def _one_writer(folder: Path, *, make: bool = True) -> Iterator[None]:
    """Keep other writers out of a folder as long as the context lasts.

    The lock is a file next to the folder, since the folder itself is exchanged at the end.
    """
    with ExitStack() as stack:
        try:
            stack.enter_context(one_writer(folder.with_name(f'.{folder.name}.lock'), make=make))
        except BlockingIOError:
            raise BagPlaceError(
                f'{folder} is being written by another process. Wait until it ends, or name '
                'another folder'
            ) from None
        yield


def _sibling(folder: Path, suffix: str) -> Path:
    return folder.with_name(folder.name + suffix)


class BagWriter:
    """A bag being written, as a context manager.

    The folder contains `<name>_0.mcap` (profile ros2, CDR, zstd chunks of 512 KiB) and, once the
    MCAP file is complete, `metadata.yaml`. Log time and publish time of a message are its stamp,
    unless others are given, sequence numbers count from 1 in each topic, independent of the wall
    clock.

    An existing bag is replaced only when the new one is complete and on the disk. Until then the
    new one is the sibling `<name>.partial`. Then the two are exchanged in one step, or, if the
    system cannot, in two by way of `<name>.replaced`, and the old one is removed. If an exception
    leaves the `with` block, the written part is finished where it is (`path`), an old bag is not
    changed, and a note on the exception names the path. No other process can write a bag to the
    same folder meanwhile.

    Args:
        folder: its parents are made.
        force: replace an existing bag.
        namespace: namespace of the topics, for example `clock_a`. Empty for the root.
        chunk_bytes: size, before compression, at which a chunk is written.
        compression: compression of the chunks, `zstd` or `none`.

    Raises:
        BagError: the folder may not be written to (see `check_folder`), and later an unknown
            topic, a stamp before zero, or an error of the file system, such as a full disk.
    """

    def __init__(
        self,
        folder: Path,
        *,
        force: bool = False,
        namespace: str = '',
        chunk_bytes: int = CHUNK_BYTES,
        compression: str = 'zstd',
    ) -> None:
        self._chunk_bytes, self._compression = chunk_bytes, compression
        check_folder(Path(folder), force=force)
        self._folder, self._force = _real(Path(folder)), force
        self._prefix = '/'.join(['', *namespace.strip('/').split('/')]).rstrip('/') + '/'
        self._replaces = False
        self._held = ExitStack()
        self._channels: dict[str, int] = {}
        self._declared: dict[str, Channel] = {}
        self._custom = {'tauto_core': identity()}
        self.counts: dict[str, int] = {}
        """Messages written, by relative topic, in the order of their first message."""
        self.path = self._folder
        """The folder that holds the messages."""

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            try:
                self._folder.parent.mkdir(parents=True, exist_ok=True)
                stack.enter_context(_one_writer(self._folder))
                _check_replaceable(self._folder, force=self._force)
                self._replaces = self._folder.exists()
                if self._replaces:
                    self.path = _sibling(self._folder, '.partial')
                    for relic in (self.path, _sibling(self._folder, '.replaced')):
                        if relic.exists():
                            shutil.rmtree(relic)
                            warnings.warn(
                                f'{relic}: was left by a process that did not end in good order, '
                                'and is removed',
                                TautoWarning,
                                stacklevel=2,
                            )
                self.path.mkdir()
            except OSError as error:
                raise BagError(
                    f'{self.path} cannot be made ({error.strerror}). Name another folder'
                ) from error
            self._file = McapOut(
                self.path / f'{self._folder.name}_0.mcap',
                f'tauto_core {identity()}',
                chunk_bytes=self._chunk_bytes,
                compression=self._compression,
            )
            self._held = stack.pop_all()
        return self

    def write(self, batches: Batches) -> None:
        """Write batches by relative topic, their samples merged in the order of the stamps."""
        topics = [name for name in TOPICS if name in batches and count(batches[name])]
        for name in batches:
            _topic(name)
        payloads = [payload for name in topics for payload in encode(name, batches[name])]
        if not payloads:
            return
        stamps = np.concatenate([batches[name].stamp_ns for name in topics])
        owners = np.repeat(np.arange(len(topics)), [count(batches[name]) for name in topics])
        for index in np.argsort(stamps, kind='stable').tolist():
            self.write_raw(topics[owners[index]], payloads[index], int(stamps[index]))

    def describe(self, facts: Mapping[str, object]) -> None:
        """Add to the bag's metadata (`custom_data`): numbers and lists are written as JSON.

        They replace earlier ones of the same name.
        """
        self._custom |= {
            name: fact if isinstance(fact, str) else json.dumps(fact)
            for name, fact in facts.items()
        }
        # in the MCAP file and in metadata.yaml, in YAML with its quotes and folded lines
        size = sum(len(name) + len(fact.encode()) for name, fact in self._custom.items())
        self._file.described_bytes = 3 * size

    def declare(self, key: str, declared: Channel) -> None:
        """Add a topic that need not be in the table, under a key for `copy`."""
        self.counts[key] = 0
        self._declared[key] = declared
        self._channels[key] = self._file.add_channel(declared)

    def write_raw(
        self, topic: str, payload: bytes, stamp_ns: int, publish_ns: int | None = None
    ) -> None:
        """Write one serialised message, CDR of the topic's type.

        The topic is a key of `TOPICS`, or was declared. The stamp, >= 0, is the log time: in a
        simulated voyage the stamp in the header, without one the start, in a live one the time of
        receipt. The publish time is the same, unless given.
        """
        if topic not in self._channels:
            entry = _topic(topic)
            full = self._prefix + entry.name
            self.declare(
                topic, declared_topic(full, entry.ros_type, entry.depth, latched=entry.latched)
            )
        if stamp_ns < 0:
            raise BagError(f'{topic}: stamp {stamp_ns} ns is before 0. Choose a later starts_at')
        number = self.counts[topic] + 1
        channel = self._channels[topic]
        self._file.add_message(channel, number & _SEQUENCE_MASK, stamp_ns, payload, publish_ns)
        self.counts[topic] = number
        if (
            topic == SCENE
        ):  # at once: a bag cut short by a full disk or a kill can then be replayed
            self.flush()

    def copy(self, key: str, message: RecordedMessage) -> None:
        """Write a message of another bag unchanged, on a topic that was declared."""
        _, sequence, stamp_ns, publish_ns, payload = message
        self._file.add_message(self._channels[key], sequence, stamp_ns, payload, publish_ns)
        self.counts[key] += 1

    def flush(self) -> None:
        """Write the messages in memory, which a killed process would lose."""
        self._file.flush()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._held:
            failure = error
            if error is not None:
                self.describe(CUT_SHORT)
            try:
                self._finish()
            except BagError as full:
                self.describe(CUT_SHORT)
                failure = error or full
                self._file.give_up()
                with suppress(BagError):
                    self._finish()
            finally:
                self._file.close()
            if error is not None and self.counts:
                error.add_note(f'{self.path} holds the part that was written')
            if error is None and failure is not None:
                raise failure
            if error is None and self._replaces:
                self._swap()

    def _finish(self) -> None:
        """Complete the MCAP file, then write the metadata, completely or not at all."""
        import yaml

        from tauto_core.files import read_yaml

        self._file.flush()
        stored = self._file.counts
        self.counts = {name: stored[channel] for name, channel in self._channels.items()}
        information = {
            'version': _METADATA_VERSION,
            'storage_identifier': 'mcap',
            **self._span(),
            'topics_with_message_count': [
                {
                    'topic_metadata': {
                        'name': declared.topic,
                        'type': declared.ros_type,
                        'serialization_format': declared.encoding,
                        'offered_qos_profiles': read_yaml(declared.metadata[QOS]) or [],
                        'type_description_hash': declared.metadata[TYPE_HASH],
                    },
                    'message_count': self.counts[key],
                }
                for key, declared in self._declared.items()
            ],
            'compression_format': '',
            'compression_mode': '',
            'relative_file_paths': [self._file.path.name],
            'files': [{'path': self._file.path.name, **self._span()}],
            'custom_data': self._custom or None,
            'ros_distro': 'jazzy',
        }
        self._file.finish(yaml.safe_dump(information, sort_keys=False))
        file = self.path / METADATA
        text = yaml.safe_dump({'rosbag2_bagfile_information': information}, sort_keys=False)
        try:
            write_whole(file, text.encode())
            sync_folder(self.path.parent)
        except OSError as error:
            raise refused(file, error) from error

    def _span(self) -> dict[str, Any]:
        first_ns, last_ns = self._file.span_ns or (_EMPTY_START_NS, _EMPTY_START_NS)
        return {
            'duration': {'nanoseconds': last_ns - first_ns},
            'starting_time': {'nanoseconds_since_epoch': first_ns},
            'message_count': sum(self.counts.values()),
        }

    def _swap(self) -> None:
        """Put the complete bag in the place of the old one."""
        old = self.path
        try:
            try:
                exchange(self.path, self._folder)
            except OSError:  # macOS and some network file systems cannot
                old = _sibling(self._folder, '.replaced')
                os.rename(self._folder, old)
                try:
                    os.rename(self.path, self._folder)
                except OSError:
                    os.rename(old, self._folder)
                    raise
        except OSError as error:
            raise BagError(
                f'{self._folder} cannot be replaced ({error.strerror}). The new bag is whole in '
                f'{self.path}, the old one in {self._folder}'
            ) from error
        self.path = self._folder
        try:
            sync_folder(self.path.parent)
            shutil.rmtree(old)
        except OSError as error:
            warnings.warn(
                f'{self._folder} is replaced, but {old} with the old bag cannot be removed '
                f'({error.strerror}). Remove it',
                TautoWarning,
                stacklevel=2,
            )


def _topic(name: str) -> Topic:
    if name not in TOPICS:
        raise BagError(f'topic {name!r} is not in the table. It holds {", ".join(TOPICS)}')
    return TOPICS[name]


def declared_topic(name: str, ros_type: str, depth: int, *, latched: bool) -> Channel:
    """Return a topic of a standard type, as a bag declares it. BagError for another type."""
    import yaml
    from rosbags.typesys.base import TypesysError

    try:
        text, type_hash = definition_of(ros_type)
    except TypesysError as error:
        raise BagError(
            f'{name}: {ros_type} is not one of the standard types of Jazzy, so a bag of Tauto '
            'cannot declare it. Record it by ros2 bag'
        ) from error
    qos = yaml.safe_dump(offered_qos(depth, latched=latched), sort_keys=False).strip()
    metadata = {QOS: qos, TYPE_HASH: type_hash}
    return Channel(name, ros_type, 'cdr', text.encode(), 'ros2msg', metadata)


# Fields of Quaternion and NavSatStatus, and the same with the default values that Jazzy gives
# them, which rosbags leaves out of its definitions.
_DEFAULTS = {
    'float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n': (
        'float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n'
    ),
    'int8 status\nuint16 service\n': 'int8 status -2\nuint16 service\n',
}


@cache
def definition_of(ros_type: str) -> tuple[str, str]:
    """Return the text of a message definition with its dependencies, and its RIHS01 hash."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    text, _ = store.generate_msgdef(ros_type, ros_version=2)
    for fields, defaults in _DEFAULTS.items():
        text = text.replace(fields, defaults)
    return text, store.hash_rihs01(ros_type)
