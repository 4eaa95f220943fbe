"""Statements of a small bag are bounded before use: sizes, places, YAML."""

from __future__ import annotations

import os
import struct
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import lz4.frame  # type: ignore[import-untyped]
import pytest
import zstandard
from bags_examples import example, mcap_file
from mcap.reader import make_reader

from tauto_core import samples as s
from tauto_core.bags import BagWriter, encode, read_bag
from tauto_core.bags.check import check_bag, recover_bag
from tauto_core.bags.read import MAGIC, open_mcap
from tauto_core.files import YamlError, decompressed, read_yaml
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
    assert most < LARGE / 8, 'the libraries, and a few copies of the content'


def test_parts_that_shrink_much_and_stay_small_are_read() -> None:
    for compression in ('zstd', 'lz4'):
        assert decompressed(compression, zeros(compression, 2**24), 2**24) == bytes(2**24)


def test_a_pipe_is_no_bag(tmp_path: Path) -> None:
    pipe = tmp_path / 'pipe.mcap'
    os.mkfifo(pipe)
    with pytest.raises(BagError, match='is not a regular file'):
        open_mcap(pipe)


def small_bag(path: Path, topics: int = 1, log_time: Callable[[int], int] = lambda k: k) -> Path:
    """Write 40 messages of Imu on each topic, in several chunks, by the mcap library."""
    payloads = encode(s.SHIP_IMU, example(s.ImuSamples, 40 if topics == 1 else 1))
    messages = [(log_time(k), payload) for k, payload in enumerate(payloads)]
    channel = 'sensor_msgs/msg/Imu', 'cdr', messages
    channels = {f'/clock_{topic}/ship/imu': channel for topic in range(topics)}
    return mcap_file(path, channels, chunk_size=4000)


# fields of a chunk index: times of its messages, place and length of its chunk, and, after the
# length of a map and a channel, the place of a message index
START, END, PLACE, LENGTH, INDEX = 0, 8, 16, 24, 38
FIRST = 46  # the place of the first chunk, which would be decompressed as often as it is listed


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        *((LENGTH, value) for value in (2**33, 2**62, 2**63, 2**64 - 1)),
        *((PLACE, value) for value in (0, FIRST, 10**6, 2**62, 2**63, 2**64 - 1)),
        *((INDEX, value) for value in (10**6, 2**63, 2**64 - 1)),
        *((field, value) for field in (START, END) for value in (2**63, 2**64 - 1)),
    ],
)
def test_an_index_that_points_out_of_its_file_is_not_believed(
    tmp_path: Path, field: int, value: int
) -> None:
    """That place is neither read nor allocated: the reader walks the file instead."""
    file = small_bag(tmp_path / 'x.mcap')
    octets = bytearray(file.read_bytes())
    [messages] = [read_bag(file).payloads(topic)[1] for topic in read_bag(file).topics]
    with file.open('rb') as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    second = struct.pack('<Q', summary.chunk_indexes[1].chunk_start_offset)
    struct.pack_into('<Q', octets, octets.rindex(second) - PLACE + field, value)
    octets[-12:-8] = bytes(4)  # no checksum
    file.write_bytes(octets)
    bag = read_bag(file)
    assert [bag.payloads(topic)[1] for topic in bag.topics] == [messages]
    assert any('its index is damaged' in each for each in bag.warnings)
    assert any('its index is damaged' in each for each in check_bag(file).damage)
    assert check_bag(recover_bag(file).path).whole


def test_a_log_time_that_no_clock_has_is_left_out_and_said(tmp_path: Path) -> None:
    file = small_bag(tmp_path / 'x.mcap', log_time=lambda k: 2**63 - 20 + k)
    assert check_bag(file).bag.counts == {'/clock_0/ship/imu': 20}
    assert any('have a log time after' in each for each in read_bag(file).warnings)
    assert len(read_bag(file).payloads('ship/imu')[1]) == 20
    assert sum(recover_bag(file).counts.values()) == 20


def lines_run(what: Callable[[], object]) -> int:
    """Return how many lines of the reader and the check run."""
    count = 0

    def trace(frame: FrameType, event: str, _: Any) -> Any:
        nonlocal count
        count += event == 'line'
        return trace if '/bags/' in frame.f_code.co_filename else None

    sys.settrace(trace)
    try:
        what()
    finally:
        sys.settrace(None)
    return count


def test_the_work_grows_no_faster_than_the_number_of_topics(tmp_path: Path) -> None:
    """8,000 topics, in a file of 271 kB, took 43 s."""
    one, two = (small_bag(tmp_path / f'{n}.mcap', n) for n in (100, 200))
    check_bag(one)
    assert lines_run(lambda: check_bag(two)) < 2.2 * lines_run(lambda: check_bag(one))


def test_a_file_that_is_named_twice_is_refused(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write({s.SHIP_IMU: example(s.ImuSamples, 3)})
    metadata = tmp_path / 'bag' / 'metadata.yaml'
    name = '- bag_0.mcap\n'
    assert name in metadata.read_text()
    metadata.write_text(metadata.read_text().replace(name, f'{name}  {name}'))
    with pytest.raises(BagError, match=r'names bag_0\.mcap twice'):
        read_bag(tmp_path / 'bag')
    assert any('twice' in each for each in check_bag(tmp_path / 'bag').damage)


TENFOLD = ''.join(
    f'{b}: &{b} [{",".join(["*" + a] * 10)}]\n' for a, b in zip('abcdefg', 'bcdefgh', strict=True)
)
HOSTILE = {
    'aliases': 'a: &a [x, x]\n' + TENFOLD + 'custom_data: {cut_short: *h}\n',
    'depth': 'custom_data: ' + '[' * 500 + ']' * 500,
    'digits': 'message_count: ' + '9' * 5000,
    'values': 'custom_data: [' + '1,' * 5_001 + ']',
    'tag': 'custom_data: !!python/object/apply:os.system ["true"]',
    'binary': 'custom_data: !!binary "%%%"',
    'a mapping as a key': '? {a: 1}\n: 2',
    'a key twice': 'message_count: 1\nmessage_count: 2',
}


@pytest.mark.parametrize('what', HOSTILE)
def test_yaml_that_would_take_much_to_read_is_refused(
    tmp_path: Path, what: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In metadata.yaml and in the copy of it that the file has: neither is believed."""
    monkeypatch.setattr('tauto_core.files._MOST_VALUES', 5_000)
    with pytest.raises(YamlError):
        read_yaml(HOSTILE[what])
    octets = small_bag(tmp_path / 'x.mcap').read_bytes()
    at = octets.index(struct.pack('<BQ', 0x0F, 4))  # the end of the data
    pairs = text('serialized_metadata') + text(HOSTILE[what])
    told = text('rosbag2') + struct.pack('<I', len(pairs)) + pairs
    (tmp_path / 'bag').mkdir()
    (tmp_path / 'bag' / 'bag_0.mcap').write_bytes(octets[:at] + record(0x0C, told) + octets[at:])
    (tmp_path / 'bag' / 'metadata.yaml').write_text(HOSTILE[what])
    tracemalloc.start()
    try:
        found = check_bag(tmp_path / 'bag')
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert sum('cannot be understood' in each for each in found.damage) == 2
    assert sum(map(len, found.damage)) < 4000
    assert most < 2**25
    assert sum(recover_bag(tmp_path / 'bag').counts.values()) == 40
