"""The layout of one CDR payload: the places of its numbers, given its strings and lengths.

Plain CDR, version 1, after the four-byte encapsulation header of ROS 2; primitives are aligned to
their size, counted from the end of that header (OMG DDSI-RTPS 2.5, section 10).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauto_core.bags.table import TOPICS, Field, MessageType
from tauto_core.scene.errors import BagError

HEADER_BYTES = 4
NUMBERS = {'float64': 'f8', 'int8': 'i1', 'uint8': 'u1', 'uint16': 'u2'}
"""numpy's code of each primitive."""

_LITTLE_ENDIAN = b'\x00\x01\x00\x00'
_BYTE_ORDER = {0: '>', 1: '<'}

_Row: TypeAlias = tuple[str, str, int]
Text: TypeAlias = str | tuple[str, ...] | int

_recent: dict[str, Layout] = {}
"""The last layout of each type; messages that come one at a time seldom change it."""


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
    """Return the payload of a sample whose numbers are zero, and the structure of its numbers.

    Args:
        topic: relative name.
        texts: values of the fields of variable length, in their order: strings, tuples of strings,
            and the lengths of sequences of numbers.

    Raises:
        BagError: a string that UTF-8 or C cannot represent; names `topic` and the sample field.
    """
    out = bytearray(_LITTLE_ENDIAN)
    variable = iter(texts)
    for field in TOPICS[topic].fields:
        if field.kind in NUMBERS:
            size = np.dtype(NUMBERS[field.kind]).itemsize
            _align(out, size)
            out += bytes(size * field.length)
        elif field.kind == 'time':
            _align(out, 4)
            out += bytes(8)
        else:
            _put_variable(topic, field, out, next(variable))
    payload = bytes(out)
    return payload, scan(TOPICS[topic].message, topic, payload).rows.dtype


def _put_variable(topic: str, field: Field, out: bytearray, value: Text) -> None:
    if isinstance(value, str):
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
            f'{topic}: {field.sample} = {text!r} is not Unicode ({error.reason}); remove the '
            'character'
        ) from None
    if b'\x00' in octets:
        raise BagError(
            f'{topic}: {field.sample} = {text!r} holds a zero character, which ends a ROS '
            'string; remove it'
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
        """Step over `length` primitives of `size` bytes; return the place of the first."""
        first = self.at + -(self.at - HEADER_BYTES) % size
        self.at = first + size * length
        if self.at > len(self.payload):
            raise cut_short(self.origin, field.message, self.payload)
        return first

    def length(self, field: Field) -> int:
        """Return a sequence length."""
        first = self.skip(field, 4)
        self.words.append((first, self.payload[first : self.at]))
        return int(struct.unpack_from(f'{self.order}I', self.payload, first)[0])

    def text(self, field: Field) -> str:
        """Return a string; the zero at its end is not part of it."""
        length = self.length(field)
        first = self.skip(field, 1, length)
        octets = self.payload[first : self.at]
        self.words.append((first, octets))
        try:
            return octets.removesuffix(b'\x00').decode()
        except UnicodeDecodeError:
            raise BagError(
                f'{self.origin}: {field.message} = {octets!r} is not UTF-8; the publisher must '
                'send UTF-8'
            ) from None


def scan(message: MessageType, origin: str, payload: bytes) -> Layout:
    """Return the layout of one payload.

    Raises:
        BagError: a payload that is not plain CDR, or ends within the message, or text that is not
            UTF-8; names `origin` and the field.
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
            texts[field.sample] = tuple(cursor.text(field) for _ in range(cursor.length(field)))
        elif field.kind == 'float64[]':
            length = cursor.length(field)
            first = cursor.skip(field, 8, length) if length else cursor.at
            numbers.append((field.sample, f'({length},){cursor.order}f8', first))
        elif field.kind == 'time':
            first = cursor.skip(field, 4, 2)
            numbers.append((f'{field.sample}.sec', f'{cursor.order}i4', first))
            numbers.append((f'{field.sample}.nanosec', f'{cursor.order}u4', first + 4))
        else:
            code = NUMBERS[field.kind]
            first = cursor.skip(field, np.dtype(code).itemsize, field.length)
            shape = f'({field.length},)' if field.length > 1 else ''
            numbers.append((field.sample, f'{shape}{cursor.order}{code}', first))
    rows = np.frombuffer(payload, _structure(numbers, len(payload)))
    layout = Layout(len(payload), rows, tuple(cursor.words), texts)
    _recent[message.name] = layout
    return layout


def _structure(numbers: list[_Row], size: int) -> np.dtype[np.void]:
    return np.dtype(
        {
            'names': [name for name, _, _ in numbers],
            'formats': [code for _, code, _ in numbers],
            'offsets': [first for _, _, first in numbers],
            'itemsize': size,
        }
    )


def byte_order(origin: str, payload: bytes) -> str:
    """Return numpy's sign of the byte order that the encapsulation header states.

    Raises:
        BagError: a payload that is not plain CDR.
    """
    kind = int.from_bytes(payload[:2], 'big') if len(payload) >= HEADER_BYTES else -1
    if kind not in _BYTE_ORDER:
        head = bytes(payload[:HEADER_BYTES]).hex(' ')
        raise BagError(
            f'{origin}: a payload of {len(payload)} bytes that begins with {head!r} is not plain '
            'CDR (00 00 or 00 01); record with a ROS 2 middleware'
        )
    return _BYTE_ORDER[kind]


def cut_short(origin: str, what: str, payload: bytes) -> BagError:
    """Return the error for a payload that ends within the field `what`."""
    return BagError(
        f'{origin}: a payload of {len(payload)} bytes ends within {what}; the message is cut or '
        'of another type'
    )
