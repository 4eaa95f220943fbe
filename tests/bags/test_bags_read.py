"""The reader: complete bags of any recorder, namespaces, and the readable part of damaged bags."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags_examples import (
    START_NS,
    STORE,
    all_batches,
    assert_same,
    example,
    library_payloads,
    mcap_file,
    stamps,
)
from mcap.writer import CompressionType, IndexType
from rosbags.rosbag2 import CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.rosbag2.enums import CompressionFormat

from tauto_core import samples as s
from tauto_core.bags import TOPICS, Bag, BagWriter, encode, read_bag
from tauto_core.scene.errors import BagError


@pytest.fixture
def voyage(tmp_path: Path) -> Path:
    with BagWriter(tmp_path / 'voyage') as writer:
        writer.write(all_batches())
    return tmp_path / 'voyage'


def imu(n: int) -> s.ImuSamples:
    samples = example(s.ImuSamples, n)
    assert isinstance(samples, s.ImuSamples)
    return samples


def foreign(path: Path, channels: dict[str, tuple[str, str, list[bytes]]], **options: Any) -> Path:
    """A bare file by the mcap library: type, encoding and payloads of each topic."""
    timed = {
        topic: (*kind, zip(stamps(len(payloads)).tolist(), payloads, strict=True))
        for topic, (*kind, payloads) in channels.items()
    }
    return mcap_file(path, timed, **options)


def imu_file(path: Path, n: int = 1000, topic: str = '/ship/imu', **options: Any) -> Path:
    payloads = encode(s.SHIP_IMU, imu(n))
    return foreign(path, {topic: ('sensor_msgs/msg/Imu', 'cdr', payloads)}, **options)


@pytest.mark.parametrize('bare', [False, True])
def test_a_whole_bag(voyage: Path, bare: bool) -> None:
    bag = read_bag(voyage / 'voyage_0.mcap' if bare else voyage)
    assert bag.topics == {f'/{name}': topic.ros_type for name, topic in TOPICS.items()}
    assert bag.counts == {f'/{name}': 1 if name == s.SCENE else 40 for name in TOPICS}
    assert (bag.start_ns, bag.end_ns) == (START_NS, START_NS + 39 * 50_000_000)
    assert (bag.namespace, bag.warnings, bag.scene) == ('', (), 'name: a scene\n')
    together = bag.batches(list(TOPICS))
    for name, samples in all_batches().items():
        assert_same(samples, together[name])
        assert_same(samples, bag.samples(f'/{name}'))
        found, payloads = bag.payloads(name)
        assert found.tolist() == samples.stamp_ns.tolist()
        assert payloads == encode(name, samples)


def test_parts_are_the_whole(voyage: Path) -> None:
    bag = read_bag(voyage)
    parts = [part for _, part in bag.parts([s.SHIP_IMU], 7)]
    assert [s.count(part) for part in parts] == [7, 7, 7, 7, 7, 5]
    joined = s.join([part for part in parts if isinstance(part, s.ImuSamples)])
    assert_same(joined, bag.samples(s.SHIP_IMU))


def test_messages_come_in_the_order_of_their_log_times(tmp_path: Path) -> None:
    """Topics written one after another, in chunks that overlap in time."""
    early, late = encode(s.SHIP_IMU, imu(900)), encode(s.SHIP_FIX, example(s.FixSamples, 900))
    bag = read_bag(
        foreign(
            tmp_path / 'x.mcap',
            {
                '/ship/imu': ('sensor_msgs/msg/Imu', 'cdr', early),
                '/ship/fix': ('sensor_msgs/msg/NavSatFix', 'cdr', late),
            },
            chunk_size=4096,
        )
    )
    found = list(bag.messages())
    assert [m.stamp_ns for m in found] == sorted(stamps(900).tolist() * 2)
    assert [m.payload for m in found[::2]] == early
    assert [m.payload for m in found[1::2]] == late
    assert {m.ros_type for m in bag.messages(['ship/fix'])} == {'sensor_msgs/msg/NavSatFix'}


@pytest.mark.parametrize('compressed', [False, True])
def test_a_bag_by_the_rosbags_writer(tmp_path: Path, compressed: bool) -> None:
    writer = RosbagsWriter(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP)
    if compressed:
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    batches = all_batches()
    with writer:
        for name, samples in batches.items():
            connection = writer.add_connection(f'/{name}', TOPICS[name].ros_type, typestore=STORE)
            payloads = library_payloads(TOPICS[name].ros_type, samples)
            for stamp_ns, payload in zip(samples.stamp_ns.tolist(), payloads, strict=True):
                writer.write(connection, stamp_ns, payload)
    bag = read_bag(tmp_path / 'bag')
    assert bag.warnings == ()
    for name, samples in batches.items():
        assert_same(samples, bag.samples(name))


@pytest.mark.parametrize('compression', CompressionType)
@pytest.mark.parametrize(
    'options',
    [
        {},
        {'use_chunking': False},
        {'index_types': IndexType.NONE},
        {'use_statistics': False},
        {'index_types': IndexType.NONE, 'use_statistics': False, 'use_summary_offsets': False,
         'repeat_channels': False, 'repeat_schemas': False},
    ],
    ids=['indexed', 'no chunks', 'no index', 'no statistics', 'no summary'],
)  # fmt: skip
def test_files_of_every_make(
    tmp_path: Path, compression: CompressionType, options: dict[str, Any]
) -> None:
    path = imu_file(tmp_path / 'x.mcap', compression=compression, chunk_size=50_000, **options)
    bag = read_bag(path)
    assert bag.warnings == ()
    assert bag.counts == {'/ship/imu': 1000}
    assert (bag.start_ns, bag.end_ns) == (START_NS, START_NS + 999 * 50_000_000)
    assert_same(imu(1000), bag.samples('ship/imu'))
    assert [m.stamp_ns for m in bag.messages()] == stamps(1000).tolist()


def test_a_split_bag_is_one(tmp_path: Path) -> None:
    folder = tmp_path / 'bag'
    folder.mkdir()
    payloads = encode(s.SHIP_IMU, imu(12))
    for k, message in enumerate(zip(stamps(12).tolist(), payloads, strict=True)):
        channel = 'sensor_msgs/msg/Imu', 'cdr', [message]
        mcap_file(folder / f'bag_{k}.mcap', {'/ship/imu': channel})
    bag = read_bag(folder)
    assert_same(imu(12), bag.samples('ship/imu'))
    assert bag.warnings == (
        f'{folder}: it has no metadata.yaml: the recording did not end by itself',
    )


def test_a_file_that_the_metadata_names_is_missing(voyage: Path) -> None:
    (voyage / 'voyage_0.mcap').rename(voyage / 'elsewhere.mcap')
    with pytest.raises(BagError, match=r'has other \.mcap files than its metadata\.yaml names'):
        read_bag(voyage)
    text = (voyage / 'metadata.yaml').read_text()
    (voyage / 'metadata.yaml').write_text(
        text.replace('  - voyage_0', '  - elsewhere.mcap\n  - voyage_0', 1)
    )
    bag = read_bag(voyage)
    assert bag.counts['/ship/imu'] == 40
    assert 'voyage_0.mcap, named by metadata.yaml, is missing' in bag.warnings[0]


def two_namespaces(tmp_path: Path) -> Path:
    channels = {
        f'/{ns}/ship/imu': ('sensor_msgs/msg/Imu', 'cdr', encode(s.SHIP_IMU, imu(n)))
        for ns, n in (('a', 3), ('b', 4))
    }
    channels['/planning/scene'] = ('moveit_msgs/msg/PlanningScene', 'cdr', [b'\0\1\0\0'])
    return foreign(tmp_path / 'two.mcap', channels)


def test_two_namespaces_must_be_told_apart(tmp_path: Path) -> None:
    bag = read_bag(two_namespaces(tmp_path))
    assert bag.namespace is None
    assert bag.scene is None, 'that of another program'
    assert '/planning/scene' in bag
    with pytest.raises(BagError, match=r'ship/imu may be /a/ship/imu or /b/ship/imu\. Name'):
        bag.samples('ship/imu')
    assert s.count(bag.samples('/b/ship/imu')) == 4


def test_one_namespace_is_found(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'x', namespace='fleet/a') as writer:
        writer.write(all_batches(2))
    bag = read_bag(tmp_path / 'x')
    assert (bag.namespace, bag.scene) == ('fleet/a', 'name: a scene\n')
    assert s.READING in bag
    assert s.count(bag.samples(s.READING)) == 2


def test_a_missing_topic_names_those_there_are(voyage: Path) -> None:
    bag = read_bag(imu_file(voyage / 'x.mcap', 3))
    with pytest.raises(BagError, match=r'no topic clock/reading\. Its topics are: /ship/imu'):
        bag.samples(s.READING)
    assert s.READING not in bag
    assert bag.scene is None


@pytest.mark.parametrize(
    ('topic', 'ros_type', 'encoding', 'payload', 'problem'),
    [
        ('/camera', 'Image', 'cdr', b'\0\1\0\0', 'Image. Tauto decodes std_msgs'),
        ('/camera', 'Imu', 'ros1', b'\0', "encoded as 'ros1'"),
        ('/camera', 'Imu', 'cdr', b'\0\1\0\0', r'x\.mcap: /camera: a payload of 4 bytes'),
        ('/ship/imu', 'NavSatFix', 'cdr', b'', 'NavSatFix, but must hold sensor_msgs/msg/Imu'),
    ],
    ids=['type', 'encoding', 'payload', 'type of the table'],
)
def test_what_cannot_be_decoded(
    tmp_path: Path, topic: str, ros_type: str, encoding: str, payload: bytes, problem: str
) -> None:
    channel = f'sensor_msgs/msg/{ros_type}', encoding, [payload]
    bag = read_bag(foreign(tmp_path / 'x.mcap', {topic: channel}))
    with pytest.raises(BagError, match=problem):
        bag.samples(topic[1:])


@pytest.mark.parametrize('content', [b'', b'\x89MCAP', b'SQLite format 3\0', b'stamp,roll\n1,2\n'])
def test_what_is_not_mcap_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / 'x.mcap').write_bytes(content)
    with pytest.raises(BagError, match=r'x\.mcap is not an MCAP file'):
        read_bag(tmp_path / 'x.mcap')


@pytest.mark.parametrize(
    ('old', 'new', 'problem'),
    [
        ('storage_identifier: mcap', 'storage_identifier: sqlite3', 'sqlite3 storage'),
        ("compression_mode: ''", 'compression_mode: FILE', 'compression by file'),
        ('rosbag2_bagfile_information', 'something_else', 'cannot be understood'),
        ('version: 9', 'version: [', 'cannot be understood'),
    ],
)
def test_metadata_that_cannot_be_followed(voyage: Path, old: str, new: str, problem: str) -> None:
    text = (voyage / 'metadata.yaml').read_text()
    assert old in text
    (voyage / 'metadata.yaml').write_text(text.replace(old, new))
    with pytest.raises(BagError, match=problem):
        read_bag(voyage)


NONE = np.empty((1, 0))


def test_topics_of_several_sources_are_refused_however_far_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They may be in different parts, which are decoded one by one."""
    parts = Bag.parts
    monkeypatch.setattr(Bag, 'parts', lambda bag, topics: parts(bag, topics, 2))
    frames = [imu(2), replace(imu(1), frame_id='mast')]
    joints = [example(s.JointSamples, 2), replace(example(s.JointSamples, 1), velocity=NONE)]
    names = replace(example(s.JointSamples, 1), name=('wheel', 'cam'))
    cases = [
        ('sensor_msgs/msg/Imu', s.SHIP_IMU, frames, r"frame_id is 'clock_mount' .* and 'mast'"),
        ('sensor_msgs/msg/JointState', s.PHASE, joints, 'velocity is 2 numbers long .* and 0'),
        ('sensor_msgs/msg/JointState', s.PHASE, [joints[0], names], r"name is .*'cam'\) in"),
    ]
    for number, (kind, topic, batches, problem) in enumerate(cases):
        payloads = [payload for batch in batches for payload in encode(topic, batch)]
        bag = read_bag(
            foreign(tmp_path / f'{number}.mcap', {f'/{topic}': (kind, 'cdr', payloads)})
        )
        with pytest.raises(BagError, match=problem):
            bag.samples(topic)
