"""`check_bag` and `recover_bag`: faults are reported, the readable part recovered unchanged."""

from __future__ import annotations

import json
import shutil
import struct
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml
from bags_examples import START_NS, digests, example, mcap_file
from mcap.reader import make_reader
from mcap.records import ChunkIndex
from mcap.writer import CompressionType
from rosbags.rosbag2 import Reader

from tauto_core import samples as s
from tauto_core import voyage
from tauto_core.bags import Message, check, check_bag, encode, read_bag, recover_bag
from tauto_core.bags.read import Channel, Hole, McapFile
from tauto_core.scene.errors import BagError, BagPlaceError

GOLDEN = Path(__file__).resolve().parents[2] / 'bags' / 'measured_2min'
FILE = 'measured_2min_0.mcap'
SIZE = (GOLDEN / FILE).stat().st_size


def killed(folder: Path, cut: int) -> Path:
    """The golden bag as SIGKILL leaves one: no metadata, and the file ends anywhere."""
    folder.mkdir()
    (folder / FILE).write_bytes((GOLDEN / FILE).read_bytes()[:cut])
    return folder


@cache
def golden_messages() -> list[Message]:
    return list(read_bag(GOLDEN).messages())


def flip(path: Path, at: int) -> None:
    octets = bytearray(path.read_bytes())
    octets[at] ^= 0x5A
    path.write_bytes(octets)


def chunk_indexes() -> list[ChunkIndex]:
    with (GOLDEN / FILE).open('rb') as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    return summary.chunk_indexes


def chunk_places() -> list[tuple[int, int]]:
    return [(index.chunk_start_offset, index.chunk_length) for index in chunk_indexes()]


@pytest.mark.parametrize('cut', [*range(9_000, SIZE, 96_001), SIZE - 3000, SIZE - 20, SIZE - 1])
def test_what_a_kill_leaves_is_recovered_for_every_reader(tmp_path: Path, cut: int) -> None:
    torn = killed(tmp_path / 'torn', cut)
    before = digests(torn)
    left = list(read_bag(torn).messages())
    whole_chunks = [at for at, length in chunk_places() if at + length <= cut]
    found = check_bag(torn)
    assert any('no metadata.yaml' in each for each in found.damage)
    assert any('was cut' in each for each in found.damage)
    if not whole_chunks:
        assert left == []
        with pytest.raises(BagError, match='no message can be read'):
            recover_bag(torn)
        assert not (tmp_path / 'torn_recovered').exists()
        return
    made = recover_bag(torn)
    assert digests(torn) == before, 'the original is only read'
    assert made.path == tmp_path / 'torn_recovered'
    assert set(found.damage) == set(made.lost)
    # our own reader: a prefix of the golden bag's messages
    again = list(read_bag(made.path).messages())
    assert read_bag(made.path).warnings == ()
    assert again == left == golden_messages()[: len(left)]
    # the rosbags library, which goes by metadata.yaml as rosbag2 does
    with Reader(made.path) as reader:
        assert reader.message_count == len(left)
        stored = [
            (connection.topic, connection.msgtype, stamp_ns, bytes(payload))
            for connection, stamp_ns, payload in reader.messages()
        ]
        assert all(connection.ext.offered_qos_profiles for connection in reader.connections)
    # older releases of it change the order of messages of one time
    assert sorted(stored) == sorted(tuple(message) for message in left)
    # the mcap library: checksums, sequence numbers and publish times as they were
    [file] = made.path.glob('*.mcap')
    with file.open('rb') as one, (GOLDEN / FILE).open('rb') as other:
        ours = make_reader(one, validate_crcs=True).iter_messages(log_time_order=False)
        theirs = make_reader(other, validate_crcs=True).iter_messages(log_time_order=False)
        for (schema, channel, message), (schema_0, channel_0, message_0) in zip(
            ours, theirs, strict=False
        ):
            assert schema is not None
            assert schema_0 is not None
            assert (schema.name, schema.data) == (schema_0.name, schema_0.data)
            assert channel.topic == channel_0.topic
            assert message == message_0
    checked = check_bag(made.path)
    assert (checked.damage, checked.faults) == ([], [])
    ended = cut > chunk_places()[-1][0] + 20_000
    assert ended or checked.cut_short
    assert checked.whole == (not checked.cut_short)


def copied(folder: Path, flipped: int | None = None) -> Path:
    """The golden bag, with one byte flipped."""
    shutil.copytree(GOLDEN, folder)
    if flipped is not None:
        flip(folder / FILE, flipped)
    return folder


@pytest.mark.parametrize('what', ['chunk', 'index', 'metadata'])
def test_damage_elsewhere_costs_no_more_than_it_hit(tmp_path: Path, what: str) -> None:
    at, length = chunk_places()[1]
    bag = copied(tmp_path / 'bag', {'chunk': at + length // 2, 'index': SIZE - 200}.get(what))
    if what == 'metadata':
        (bag / 'metadata.yaml').write_text('rosbag2_bagfile_information: [', 'utf-8')
    assert not check_bag(bag).whole
    made = recover_bag(bag, tmp_path / 'new' / 'bag')
    kept = list(read_bag(made.path).messages())
    lost = len(golden_messages()) - len(kept)
    assert made.missing == lost
    assert (lost > 0) == (what == 'chunk')
    assert set(kept) <= set(golden_messages())
    assert check_bag(made.path).whole == (lost == 0)


def lost_by_topic(kept: Path) -> dict[str, tuple[int, int, int]]:
    """Number, first and last log time of the golden bag's messages that another bag lacks."""
    left = set(golden_messages()) - set(read_bag(kept).messages())
    stamps: dict[str, list[int]] = {}
    for message in left:
        stamps.setdefault(message.topic, []).append(message.stamp_ns)
    return {topic: (len(each), min(each), max(each)) for topic, each in stamps.items()}


def holes_said(folder: Path) -> dict[str, tuple[int, int, int]]:
    held = yaml.safe_load((folder / 'metadata.yaml').read_text('utf-8'))
    listed = json.loads(held['rosbag2_bagfile_information']['custom_data']['holes'])
    return {topic: tuple(rest) for topic, *rest in listed}


@pytest.mark.parametrize('number', [0, 1])
def test_a_bag_with_a_hole_says_so_for_ever(tmp_path: Path, number: int) -> None:
    """Losses by topic, even if the chunk had the definitions of the topics."""
    at, length = chunk_places()[number]
    made = recover_bag(copied(tmp_path / 'bag', at + length // 2), tmp_path / 'once').path
    expected = lost_by_topic(made)
    assert len(expected) > 5
    assert holes_said(made) == expected
    if number == 0:  # the scene was in it
        return
    [mark, *_] = [each for each in check_bag(made).marks if '/ship/imu' in each]
    count, first_ns, last_ns = expected['/ship/imu']
    said = f'it says {count:,} messages of /ship/imu are lost, from {first_ns * 1e-9:.9g} s'
    assert f'{said} to {last_ns * 1e-9:.9g} s' in mark
    result = voyage.replay(read_bag(made)).result
    assert mark in result['damage']
    assert result['answer'].startswith('The bag is not whole.')
    # neither a new metadata.yaml nor another recovery, nor a replay that is written, lose it
    (made / 'metadata.yaml').unlink()
    [file] = made.glob('*.mcap')
    assert len(check_bag(file).marks) == len(voyage.replay(read_bag(file)).result['damage'])
    assert len(check_bag(file).marks) == len(expected)
    again = recover_bag(made, tmp_path / 'twice').path
    assert holes_said(again) == expected
    voyage.replay(read_bag(again)).write(tmp_path / 'written')
    assert holes_said(tmp_path / 'written') == expected


def test_a_hole_without_indices_has_the_times_of_the_chunk(tmp_path: Path) -> None:
    bag = copied(tmp_path / 'bag')
    octets = bytearray((bag / FILE).read_bytes())
    (at, length), (after, _), *_ = chunk_places()[1:]
    octets[at + length - 99 : after] = bytes(after - at - length + 99)
    octets[at + length : at + length + 9] = struct.pack('<BQ', 0x7F, after - at - length - 9)
    (bag / FILE).write_bytes(octets)
    made = recover_bag(bag).path
    lost = lost_by_topic(made)
    first_ns, last_ns = (
        min(each[1] for each in lost.values()),
        max(each[2] for each in lost.values()),
    )
    assert holes_said(made) == {'': (0, first_ns, last_ns)}


def test_a_list_of_holes_that_is_none_is_one_hole() -> None:
    for wrong in ('[[1]]', '{"a": 1}', '[["/a", -1, 0, 0]]', '[["/a", 1e999, 0, 0]]', '[' * 5000):
        assert check.holes_in({'holes': wrong}) == [Hole('', 0, 0, 0)]


@pytest.mark.parametrize('tail', [b'rest', None])
def test_what_follows_the_end_of_a_file_is_said(tmp_path: Path, tail: bytes | None) -> None:
    bag = copied(tmp_path / 'bag')
    tail = (GOLDEN / FILE).read_bytes() if tail is None else tail
    (bag / FILE).write_bytes((GOLDEN / FILE).read_bytes() + tail)
    [said] = [each for each in check_bag(bag).damage if 'follow its end' in each]
    assert f'{len(tail)} bytes follow its end at byte {SIZE}' in said
    assert ('another MCAP file' in said) == (len(tail) > 8)
    assert check_bag(recover_bag(bag).path).whole


def rewrite(bag: Path, change: Any) -> None:
    file = bag / 'metadata.yaml'
    content = yaml.safe_load(file.read_text('utf-8'))
    change(content['rosbag2_bagfile_information'])
    file.write_text(yaml.safe_dump(content), 'utf-8')


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        (lambda m: m.update(message_count=3), 'message_count = 3, but the files hold 3377'),
        (lambda m: m['duration'].update(nanoseconds=1), 'duration'),
        (lambda m: m['topics_with_message_count'][1].update(message_count=1), '/ship/imu is'),
        (lambda m: m['topics_with_message_count'].pop(1), '/ship/imu is nothing'),
        (lambda m: m['relative_file_paths'].append('b_1.mcap'), 'b_1.mcap, named by'),
        (lambda m: m.update(custom_data={'cut_short': 'true'}), ''),
    ],
)
def test_metadata_that_says_otherwise_is_noticed(tmp_path: Path, change: Any, words: str) -> None:
    bag = copied(tmp_path / 'bag')
    rewrite(bag, change)
    found = check_bag(bag)
    assert not found.whole
    assert found.cut_short == (not words)
    assert words in ' '.join(found.damage)


def test_a_message_index_that_points_elsewhere_is_noticed(tmp_path: Path) -> None:
    bag = copied(tmp_path / 'bag')
    [at, *_] = chunk_indexes()[0].message_index_offsets.values()
    octets = bytearray((bag / FILE).read_bytes())
    struct.pack_into('<Q', octets, at + 15 + 8, 12345)
    (bag / FILE).write_bytes(octets)
    found = check_bag(bag)
    assert '2 entries of its message indices' in ' '.join(found.damage)
    assert check_bag(recover_bag(bag).path).whole


def test_a_chunk_that_ends_within_a_record_is_noticed(tmp_path: Path) -> None:
    rows = {'/depth': ('a_msgs/msg/Depth', 'cdr', [(k, bytes(12)) for k in range(3)])}
    bare: dict[str, Any] = {'compression': CompressionType.NONE, 'enable_crcs': False}
    path = mcap_file(tmp_path / 'x.mcap', rows, **bare)
    assert check_bag(path).whole
    octets = bytearray(path.read_bytes())
    length = struct.pack('<BQ', 0x05, 22 + 12)
    octets[octets.rindex(length) + 1] += 1
    path.write_bytes(octets)
    [words, *_] = check_bag(path).damage
    assert 'the last 43 bytes of the chunk at byte' in words


def test_undecodable_or_early_messages_are_faults_not_damage(tmp_path: Path) -> None:
    payloads = encode(s.SHIP_IMU, example(s.ImuSamples, 3))
    back = [(START_NS - k, payload) for k, payload in enumerate(payloads)]
    rows = {'/ship/imu': back, '/bad': [(START_NS, b'\0\1\0\0')]}
    channels = {topic: ('sensor_msgs/msg/Imu', 'cdr', row) for topic, row in rows.items()}
    path = mcap_file(tmp_path / 'x.mcap', channels)
    found = check_bag(path)
    assert found.damage == []
    assert len(found.faults) == 2
    assert 'ends within' in found.faults[0]
    assert '/ship/imu: 2 times a log time is before' in found.faults[1]
    assert 'there is no scene' in found.notes[0]
    with pytest.raises(BagError, match='need no recovery'):
        recover_bag(path)


def test_a_foreign_topic_is_recovered_with_its_definition(tmp_path: Path) -> None:
    deep = {'/depth': ('a_msgs/msg/Depth', 'cdr', [(k, bytes(12)) for k in range(20)])}
    path = mcap_file(tmp_path / 'x.mcap', deep, b'float64 metres\n', chunk_size=200)
    octets = path.read_bytes()
    path.write_bytes(octets[: len(octets) // 2])
    made = recover_bag(path)
    assert made.path == tmp_path / 'x_recovered'
    with next(made.path.glob('*.mcap')).open('rb') as stream:
        rows = list(make_reader(stream, validate_crcs=True).iter_messages())
    assert 3 < len(rows) < 20
    for k, (found, channel, message) in enumerate(rows):
        assert found is not None
        assert (found.name, found.data) == ('a_msgs/msg/Depth', b'float64 metres\n')
        assert channel.topic == '/depth'
        assert (message.sequence, message.log_time, message.publish_time) == (5 * k, k, k + 7)


def test_a_split_bag_is_recovered_as_one(tmp_path: Path) -> None:
    torn = killed(tmp_path / 'torn', SIZE)
    (torn / FILE).rename(torn / 'torn_0.mcap')
    (torn / 'torn_1.mcap').write_bytes((GOLDEN / FILE).read_bytes()[: SIZE // 2])
    (torn / 'torn_2.mcap').write_bytes(b'')
    made = recover_bag(torn)
    assert sum(made.counts.values()) > 1.3 * len(golden_messages())
    assert any('torn_2.mcap is not an MCAP file' in lost for lost in made.lost)
    assert len(list(made.path.glob('*.mcap'))) == 1
    with Reader(made.path) as reader:
        assert reader.message_count == sum(made.counts.values())


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    torn = killed(tmp_path / 'torn', SIZE // 2)
    with pytest.raises(BagPlaceError, match='is in the bag'):
        recover_bag(torn, torn / 'new')
    (tmp_path / 'torn_recovered').mkdir()
    with pytest.raises(BagPlaceError, match='exists already'):
        recover_bag(torn)
    with pytest.raises(BagPlaceError, match='does not exist'):
        check_bag(tmp_path / 'nowhere')
    with pytest.raises(BagError, match='need no recovery'):
        recover_bag(GOLDEN, tmp_path / 'x')


def test_a_topic_that_never_had_a_message_is_no_damage(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """rosbag2 declares one of its own in the index, and nowhere else."""
    bag = copied(tmp_path / 'bag')
    plain = check.open_mcap

    def declared(path: Path, **how: bool) -> McapFile:
        file = plain(path, **how)
        if 'walk' not in how:
            file.channels[999] = Channel('/events/write_split', 'a/msg/B', 'cdr', b'', '', {})
        return file

    monkeypatch.setattr(check, 'open_mcap', declared)
    assert check_bag(bag).whole


def test_log_times_that_go_back_on_a_topic_of_others_are_a_note(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """rosbag2 writes /rosout, of all nodes, with times of receipt that cross."""
    bag = copied(tmp_path / 'bag')
    plain = McapFile.messages

    def crossed(self: McapFile, *arguments: Any) -> Any:
        yield from sorted(plain(self, *arguments), key=lambda each: -each.stamp_ns)

    monkeypatch.setattr(McapFile, 'messages', crossed)
    assert any('a log time is before' in each for each in check_bag(bag).faults)
    monkeypatch.setattr(check, 'MESSAGE_TYPES', {})
    found = check_bag(bag)
    assert not any('a log time is' in each for each in found.faults)
    assert any('a log time is before' in each for each in found.notes)
