"""A small bag that would become a large one is read for what is plausible of it, and no more."""

from __future__ import annotations

import os
import struct
import tracemalloc
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]
import pytest
import zstandard

from tauto_core.bags.check import check_bag
from tauto_core.bags.read import MAGIC, open_mcap
from tauto_core.files import decompressed
from tauto_core.scene.errors import BagError, MotionDataError
from tauto_core.ship.motions.recorded import read_imu

LARGE = 2**28


def record(opcode: int, body: bytes) -> bytes:
    return struct.pack('<BQ', opcode, len(body)) + body


def text(word: str) -> bytes:
    return struct.pack('<I', len(word)) + word.encode()


def zeros(compression: str, count: int) -> bytes:
    if compression == 'lz4':
        return bytes(lz4.frame.compress(bytes(count)))
    made = zstandard.ZstdCompressor().compressobj(size=count)
    return b''.join(made.compress(bytes(2**24)) for _ in range(count // 2**24)) + made.flush()


@pytest.mark.parametrize('compression', ['zstd', 'lz4'])
@pytest.mark.parametrize('declared', [LARGE, 1000])
def test_a_bomb_in_a_bag_is_left_out(tmp_path: Path, compression: str, declared: int) -> None:
    """Whether it says how large it becomes, or says another size."""
    body = zeros(compression, LARGE)
    head = struct.pack('<QQQI', 0, 0, declared, 0) + text(compression)
    chunk = record(0x06, head + struct.pack('<Q', len(body)) + body)
    start = record(0x01, text('') + text('')) + chunk
    end = record(0x0F, bytes(4)) + record(0x02, bytes(20))
    file = tmp_path / 'bomb.mcap'
    file.write_bytes(MAGIC + start + end + MAGIC)
    tracemalloc.start()
    try:
        found = check_bag(file)
        with pytest.raises(MotionDataError):
            read_imu(file, 'bomb.mcap', 'imu')
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert any('is damaged' in each for each in found.damage)
    assert most < 2**24


def test_parts_that_shrink_much_and_stay_small_are_read() -> None:
    for compression in ('zstd', 'lz4'):
        assert decompressed(compression, zeros(compression, 2**24), 2**24) == bytes(2**24)


def test_a_pipe_is_no_bag(tmp_path: Path) -> None:
    pipe = tmp_path / 'pipe.mcap'
    os.mkfifo(pipe)
    with pytest.raises(BagError, match='is not a regular file'):
        open_mcap(pipe)
