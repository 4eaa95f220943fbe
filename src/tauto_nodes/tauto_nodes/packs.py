"""Many messages in one, between the nodes of our own graph: the overhead is paid once.

A pack is a std_msgs/UInt8MultiArray. Its data are, as little-endian uint32, the number of
messages and their lengths, then the messages, with their exact lengths: DDS pads none of them.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence

from tauto_nodes.errors import NodesError

PACK_TOPIC = '_tauto/pack/'
"""Prefix of the name of a packed topic."""

MOST_BYTES = 60_000
"""Largest size of a pack of more than one message: it fits into a UDP datagram."""

# CDR: encapsulation, no dimensions, no offset, length of the data.
_HEAD = struct.Struct('<4sIII')
_LITTLE_ENDIAN = b'\x00\x01\x00\x00'


def pack(payloads: Sequence[bytes]) -> Iterator[bytes]:
    """Yield the serialised packs of messages, in their order."""
    first = size = 0
    for last, payload in enumerate(payloads):
        if size and size + len(payload) > MOST_BYTES:
            yield _packed(payloads[first:last])
            first, size = last, 0
        size += len(payload)
    if payloads:
        yield _packed(payloads[first:])


def _packed(payloads: Sequence[bytes]) -> bytes:
    n = len(payloads)
    lengths = struct.pack(f'<{n + 1}I', n, *map(len, payloads))
    data = b''.join([lengths, *payloads])
    return _HEAD.pack(_LITTLE_ENDIAN, 0, 0, len(data)) + data


def unpack(topic: str, octets: bytes) -> list[bytes]:
    """Return the messages of a serialised pack.

    Args:
        topic: whose messages they are.
        octets: the pack.

    Raises:
        NodesError: it is none.
    """
    try:
        (n,) = struct.unpack_from('<I', octets, _HEAD.size)
        lengths = struct.unpack_from(f'<{n}I', octets, _HEAD.size + 4)
    except struct.error:
        raise NodesError(f'{PACK_TOPIC}{topic}: not a pack of messages: {octets[:40]!r}') from None
    at = _HEAD.size + 4 * (n + 1)
    if at + sum(lengths) > len(octets):
        raise NodesError(
            f'{PACK_TOPIC}{topic}: a pack of {n} messages is cut short: {len(octets)} bytes'
        )
    messages = []
    for length in lengths:
        messages.append(octets[at : at + length])
        at += length
    return messages
