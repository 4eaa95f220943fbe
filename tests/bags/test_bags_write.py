"""The writer: folders for other programs, existing folders, failures during writing."""

import os
import signal
import subprocess
import sys
import textwrap
import tracemalloc
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest
import yaml
from bags_examples import START_NS, all_batches, assert_same, digests, example, library_payloads
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader

from tauto_core import samples as s
from tauto_core.bags import TOPICS, BagWriter, check_bag, encode, offered_qos, read_bag
from tauto_core.bags import write as bags_write
from tauto_core.scene.errors import BagError, BagPlaceError, TautoWarning


def write(folder: Path, batches: s.Batches, **options: Any) -> Path:
    with BagWriter(folder, **options) as writer:
        writer.write(batches)
    return folder


def interrupt(folder: Path, batches: s.Batches, error: type[BaseException]) -> Path:
    """Leave a bag by an exception. Return the place of its messages."""
    with pytest.raises(error):
        enter_and_raise(writer := BagWriter(folder, force=True), batches, error)
    return writer.path


def enter_and_raise(writer: BagWriter, batches: s.Batches, error: type[BaseException]) -> None:
    with writer:
        writer.write(batches)
        raise error


def read_metadata(folder: Path) -> dict[str, Any]:
    text = (folder / 'metadata.yaml').read_text('utf-8')
    return yaml.safe_load(text)['rosbag2_bagfile_information']


def test_rosbags_reads_the_same_messages(tmp_path: Path) -> None:
    batches = all_batches()
    found = defaultdict(list)
    with Reader(write(tmp_path / 'voyage', batches)) as reader:
        for connection, stamp_ns, payload in reader.messages():
            found[connection.topic].append((stamp_ns, bytes(payload)))
        types = {connection.topic: connection.msgtype for connection in reader.connections}
        profiles = {c.topic: c.ext.offered_qos_profiles[0] for c in reader.connections}
    with AnyReader([tmp_path / 'voyage']) as reader:  # by the definitions in the file
        [imu] = [each for each in reader.connections if each.topic == '/ship/imu']
        frames = {
            reader.deserialize(payload, imu.msgtype).header.frame_id
            for _, _, payload in reader.messages([imu])
        }
    assert frames == {'clock_mount'}
    for name, samples in batches.items():
        payloads = library_payloads(TOPICS[name].ros_type, samples)
        assert found[f'/{name}'] == list(zip(samples.stamp_ns.tolist(), payloads, strict=True))
        assert types[f'/{name}'] == TOPICS[name].ros_type
        assert profiles[f'/{name}'].depth == TOPICS[name].depth
        assert profiles[f'/{name}'].durability.name == (
            'TRANSIENT_LOCAL' if name == s.SCENE else 'VOLATILE'
        )


def test_mcap_finds_profile_times_sequence_and_qos(tmp_path: Path) -> None:
    folder = write(tmp_path / 'voyage', all_batches())
    with (folder / 'voyage_0.mcap').open('rb') as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == 'ros2'
        rows = list(reader.iter_messages())
        names = {metadata.name for metadata in reader.iter_metadata()}
    assert names == {'rosbag2'}
    hashes = {c.topic: c.metadata['topic_type_hash'] for _, c, _ in rows}
    assert hashes == {
        t['topic_metadata']['name']: t['topic_metadata']['type_description_hash']
        for t in read_metadata(folder)['topics_with_message_count']
    }
    sequences = defaultdict(list)
    for _, channel, message in rows:
        assert message.publish_time == message.log_time
        qos = yaml.safe_load(channel.metadata['offered_qos_profiles'])
        topic = TOPICS[channel.topic.lstrip('/')]
        assert qos == offered_qos(topic.depth, latched=topic.latched)
        sequences[channel.topic].append(message.sequence)
    assert sequences['/ship/imu'] == list(range(1, 41))
    stored = [message.log_time for _, _, message in rows]
    assert stored == sorted(stored)


def test_sequence_numbers_wrap_at_32_bits(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'voyage') as writer:
        writer.write(all_batches())
        writer.counts['ship/imu'] = 2**32 - 2
        for stamp_ns in (1, 2, 3):
            writer.write_raw('ship/imu', bytes(324), START_NS + stamp_ns)
        writer.counts['ship/imu'] = 43
    with (tmp_path / 'voyage' / 'voyage_0.mcap').open('rb') as stream:
        rows = list(make_reader(stream).iter_messages(topics=['/ship/imu'], log_time_order=False))
    assert [message.sequence for _, _, message in rows][-3:] == [2**32 - 1, 0, 1]


def test_the_metadata_says_what_is_in_the_file(tmp_path: Path) -> None:
    folder = write(tmp_path / 'voyage', all_batches())
    information = read_metadata(folder)
    assert information['version'] == 9
    assert information['message_count'] == (len(TOPICS) - 1) * 40 + 1
    assert information['starting_time'] == {'nanoseconds_since_epoch': START_NS}
    assert information['duration'] == {'nanoseconds': 39 * 50_000_000}
    assert information['relative_file_paths'] == ['voyage_0.mcap']
    assert '&' not in (folder / 'metadata.yaml').read_text('utf-8'), 'aliases'
    hashes = [
        t['topic_metadata']['type_description_hash']
        for t in information['topics_with_message_count']
    ]
    assert all(found.startswith('RIHS01_') for found in hashes)


def test_what_is_written_is_in_the_file_chunk_by_chunk(tmp_path: Path) -> None:
    """A kill loses at most the chunk that is not yet full: the file is read as it is."""
    imu = example(s.ImuSamples, 1000)
    with BagWriter(tmp_path / 'voyage', chunk_bytes=64 * 1024) as writer:
        writer.write({s.SHIP_IMU: imu})
        assert writer.counts == {s.SHIP_IMU: 1000}
        bag = read_bag(tmp_path / 'voyage')
        left = bag.counts['/ship/imu']
        assert 1000 - 64 * 1024 / 350 < left <= 1000
        assert_same(s.take(imu, slice(left)), bag.samples(s.SHIP_IMU))
        assert 'no metadata.yaml' in bag.warnings[0]
        assert f'The {left} messages before the cut' in bag.warnings[1]
    assert writer.path == tmp_path / 'voyage'


def test_memory_does_not_grow_with_the_chunks(tmp_path: Path) -> None:
    """A record of the index takes more than 100 bytes: kept, 800 of them would be seen."""
    payload = encode(s.SHIP_IMU, example(s.ImuSamples, 1))[0]
    with BagWriter(tmp_path / 'voyage', chunk_bytes=1) as writer:
        held = []
        tracemalloc.start()
        for stamp_ns in range(1000):
            writer.write_raw(s.SHIP_IMU, payload, stamp_ns)
            if stamp_ns in {199, 999}:
                held.append(tracemalloc.get_traced_memory()[0])
        tracemalloc.stop()
    assert held[1] - held[0] < 50_000
    with (tmp_path / 'voyage/voyage_0.mcap').open('rb') as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert len(summary.chunk_indexes) == 1000


def test_an_existing_folder_is_refused_and_stays(tmp_path: Path) -> None:
    folder = write(tmp_path / 'voyage', all_batches(2))
    before = digests(folder)
    with pytest.raises(BagError, match=r'voyage exists already. .*force=True'):
        BagWriter(folder)
    assert digests(folder) == before


def test_force_replaces_a_bag_once_the_new_one_is_complete(tmp_path: Path) -> None:
    folder = write(tmp_path / 'voyage', all_batches(2), force=True)
    before = digests(folder)
    with BagWriter(folder, force=True) as writer:
        writer.write(all_batches(3))
        assert digests(folder) == before
    assert read_bag(folder).counts['/ship/imu'] == 3
    assert writer.path == folder
    assert [entry.name for entry in tmp_path.iterdir()] == ['voyage']


@pytest.mark.parametrize('suffix', ['', '.partial', '.replaced'])
def test_force_spares_what_is_not_only_a_bag(tmp_path: Path, suffix: str) -> None:
    folder = write(tmp_path / 'voyage', all_batches(2))
    other = tmp_path / f'voyage{suffix}'
    other.mkdir(exist_ok=True)
    (other / 'thesis.tex').write_text('years of work')
    with pytest.raises(BagError, match=r"'thesis.tex'"):
        BagWriter(folder, force=True)
    assert (other / 'thesis.tex').exists()


def test_a_place_where_no_folder_can_be_is_refused(tmp_path: Path) -> None:
    (tmp_path / 'voyage').write_text('x')
    for force in (False, True):
        with pytest.raises(BagError, match='voyage'):
            BagWriter(tmp_path / 'voyage', force=force)
    with pytest.raises(BagError, match='cannot be made'), BagWriter(tmp_path / 'voyage' / 'new'):
        pass
    with pytest.raises(BagPlaceError, match=r'cannot be used .File name too long.'):
        BagWriter(tmp_path / ('x' * 252))


@pytest.mark.parametrize('error', [KeyboardInterrupt, ValueError])
def test_an_interrupted_bag_is_finished(tmp_path: Path, error: type[BaseException]) -> None:
    batches = all_batches()
    assert interrupt(tmp_path / 'voyage', batches, error) == tmp_path / 'voyage'
    bag, found = read_bag(tmp_path / 'voyage'), check_bag(tmp_path / 'voyage')
    assert (bag.warnings, found.damage, found.cut_short, found.whole) == ((), [], True, False)
    for name, samples in batches.items():
        assert_same(samples, bag.samples(name))


def test_an_interrupted_replacement_keeps_both(tmp_path: Path) -> None:
    folder = write(tmp_path / 'voyage', all_batches(2))
    before = digests(folder)
    partial = interrupt(folder, all_batches(3), KeyboardInterrupt)
    assert digests(folder) == before
    assert partial == tmp_path / 'voyage.partial'
    assert read_bag(partial).counts['/ship/imu'] == 3
    with pytest.warns(TautoWarning, match=r'voyage\.partial: was left .* and is removed'):
        write(folder, all_batches(4), force=True)
    assert read_bag(folder).counts['/ship/imu'] == 4
    assert not partial.exists()


@pytest.mark.parametrize('there', [False, True])
def test_a_folder_has_one_writer(tmp_path: Path, there: bool) -> None:
    folder = tmp_path / 'voyage'
    if there:
        write(folder, all_batches(2))
    with BagWriter(folder, force=True) as writer:
        for force in (False, True):
            with pytest.raises(BagPlaceError, match='voyage is being written by another'):
                BagWriter(folder, force=force)
        writer.write(all_batches(3))
    assert read_bag(folder).counts['/ship/imu'] == 3
    assert [entry.name for entry in tmp_path.iterdir()] == ['voyage']


KILLED = """
    import os, signal, sys
    from pathlib import Path
    from bags_examples import all_batches
    from tauto_core.bags import BagWriter, write

    def kill(*_):
        os.kill(os.getpid(), signal.SIGKILL)

    def exchanged(*names):
        exchange(*names)
        kill()

    exchange = write.exchange
    write.exchange = {'before': kill, 'after': exchanged}[sys.argv[2]]
    with BagWriter(Path(sys.argv[1]), force=True) as writer:
        writer.write(all_batches(3))
"""


@pytest.mark.skipif(sys.platform != 'linux', reason='only Linux exchanges two names in one step')
@pytest.mark.parametrize(('moment', 'held'), [('before', 2), ('after', 3)])
def test_a_kill_leaves_a_whole_bag_in_its_place(tmp_path: Path, moment: str, held: int) -> None:
    folder = write(tmp_path / 'voyage', all_batches(2))
    done = subprocess.run(
        [sys.executable, '-c', textwrap.dedent(KILLED), folder, moment],
        cwd=Path(__file__).parent,
        check=False,
        timeout=300,
    )
    assert done.returncode == -signal.SIGKILL
    for bag, messages in ((folder, held), (tmp_path / 'voyage.partial', 5 - held)):
        assert check_bag(bag).whole
        assert read_bag(bag).counts['/ship/imu'] == messages
    with pytest.warns(TautoWarning, match=r'voyage\.partial: was left'):
        write(folder, all_batches(4), force=True)
    assert [entry.name for entry in tmp_path.iterdir()] == ['voyage']


def test_two_renames_replace_a_bag_if_names_cannot_be_exchanged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write(tmp_path / 'voyage', all_batches(2))
    monkeypatch.setattr(bags_write, 'exchange', refuse)
    write(folder, all_batches(3), force=True)
    assert [entry.name for entry in tmp_path.iterdir()] == ['voyage']
    rename, names = os.rename, []

    def fails_once(old: Path, new: Path) -> None:
        names.append(new)
        if len(names) == 2:
            raise OSError(5, 'Input/output error')
        rename(old, new)

    monkeypatch.setattr(os, 'rename', fails_once)
    with pytest.raises(BagError, match=r'cannot be replaced .Input/output error.'):
        write(folder, all_batches(4), force=True)
    assert read_bag(folder).counts['/ship/imu'] == 3, 'the old one is back'
    assert read_bag(tmp_path / 'voyage.partial').counts['/ship/imu'] == 4


def refuse(*_: Path) -> None:
    raise OSError(22, 'Invalid argument')


def test_bad_messages_are_refused(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'voyage') as writer:
        with pytest.raises(
            BagError, match=r"'ship/imü' is not in the table\. It holds scene, ship/imu"
        ):
            writer.write_raw('ship/imü', b'', 0)
        with pytest.raises(BagError, match=r'stamp -1 ns is before 0'):
            writer.write_raw(s.SHIP_IMU, b'', -1)
        with pytest.raises(BagError, match='not in the table'):
            writer.write({'elsewhere': s.text(0, 'x')})


OWN = ['unshare', '--map-root-user', '--mount']
"""Runs a command that may mount what others do not see."""

SMALL = """
    import sys
    from pathlib import Path
    from bags_examples import example
    from tauto_core import samples as s
    from tauto_core.bags import BagWriter, check_bag, encode
    from tauto_core.scene.errors import BagError

    [payload] = encode(s.SHIP_IMU, example(s.ImuSamples, 1))
    folder = Path(sys.argv[1], 'voyage')
    try:
        with BagWriter(folder, chunk_bytes=1000) as writer:
            writer.describe({'weather': 'x' * 50_000})
            for stamp_ns in range(100_000):
                writer.write_raw(s.SHIP_IMU, payload, stamp_ns)
    except BagError as error:
        found = check_bag(folder)
        print('No space left' in str(error), found.damage, found.cut_short)
        print(sum(found.bag.counts.values()))
"""


@pytest.mark.skipif(
    subprocess.run([*OWN, 'true'], capture_output=True, check=False).returncode != 0,
    reason='this user may mount nothing',
)
def test_a_bag_that_fills_a_disk_has_its_end(tmp_path: Path) -> None:
    """Its index grows with its chunks, and so does the room that is kept for it."""
    mount = f'mount -t tmpfs -o size=1m none {tmp_path} && exec "$@"'
    done = subprocess.run(
        [*OWN, 'sh', '-c', mount, 'sh', sys.executable, '-c', textwrap.dedent(SMALL), tmp_path],
        cwd=Path(__file__).parent,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.stdout.splitlines()[0] == 'True [] True', done.stderr
    assert int(done.stdout.splitlines()[1]) > 1000


LOOP = """
    import signal
    import sys
    from pathlib import Path
    from bags_examples import example
    from tauto_core import samples as s
    from tauto_core.bags import BagWriter

    # A shell that starts jobs in the background lets them ignore it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with BagWriter(Path(sys.argv[1])) as writer:
        writer.write({s.SHIP_IMU: example(s.ImuSamples, 300)})
        print('written', flush=True)
        while True:
            writer.write({s.SHIP_IMU: example(s.ImuSamples, 300)})
"""


def test_a_bag_is_finished_wherever_an_interrupt_comes(tmp_path: Path) -> None:
    folder = tmp_path / 'voyage'
    with subprocess.Popen(
        [sys.executable, '-c', textwrap.dedent(LOOP), folder],
        cwd=Path(__file__).parent,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b'written\n'
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=300)
    assert b'KeyboardInterrupt' in errors
    bag = read_bag(folder)
    assert bag.warnings == ()
    found = bag.samples(s.SHIP_IMU)
    assert s.count(found) == bag.counts['/ship/imu'] >= 300
    assert_same(example(s.ImuSamples, 300), s.take(found, slice(300)))
    assert read_metadata(folder)['message_count'] == s.count(found)


def test_a_scene_is_in_the_file_at_once(tmp_path: Path) -> None:
    """The bag of a killed process or a full disk can be replayed."""
    scene = all_batches(1)[s.SCENE]
    with BagWriter(tmp_path / 'voyage') as writer:
        writer.write({s.SHIP_IMU: example(s.ImuSamples, 1), s.SCENE: scene})
        file = next((tmp_path / 'voyage').glob('*.mcap'))
        assert read_bag(file).counts['/scene'] == 1
