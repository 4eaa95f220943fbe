"""MCAP as octets: records, the messages among them, and what a chunk holds.

A record is an opcode, a length and a body, both in the file and in a decompressed chunk (MCAP
specification, sections Records and Chunk). Whole records before a truncation can be read; a
compressed chunk can be read only as a whole.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Iterator
from typing import NamedTuple

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
