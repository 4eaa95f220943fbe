"""One MCAP file being written, so that it can be completed wherever the writing stops.

The writer of the mcap library changes its state before it writes a chunk, so after an interrupt or
a full disk it cannot finish the file. Here one value describes the content of the file. A chunk
counts once that value is replaced, and anything after its end is cut off. The index has a record
for each chunk and is written last; until then it is in an unnamed temporary file, so memory does
not grow with the voyage. Another such file keeps room on the disk for the end of this one. Records
other than messages and their index are written by the library.
"""

from __future__ import annotations

import errno
import os
import struct
import tempfile
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator
from io import FileIO, RawIOBase
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tauto_core.scene.errors import BagError

if TYPE_CHECKING:
    from mcap.records import McapRecord

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
