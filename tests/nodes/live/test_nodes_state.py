"""The state of a stage in a file: bit for bit, and refused if another node or scene wrote it."""

from __future__ import annotations

import signal
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import (
    DRIFT,
    FOREIGN,
    PATIENCE_S,
    START_NS,
    Bench,
    overrides,
    publisher_of,
    send,
    start,
    still_sensor,
    with_sensor,
)
from rclpy.node import Node

from tauto_core.bags import decode, encode
from tauto_core.clockwork import DialSetting, LiveTrochlea
from tauto_core.files import DRAFTS
from tauto_core.navigation import DriftStage, LongitudeStage
from tauto_core.samples import OBSERVATION, READING, SHIP_IMU, TimeSamples, same, take
from tauto_core.scene import load_scene
from tauto_core.version import code
from tauto_nodes import ParameterError
from tauto_nodes.commands import state_folder
from tauto_nodes.live.node import port
from tauto_nodes.live.stages import DriftEstimatorNode, StateFile, TrochleaNode

SCENE = load_scene('measured')
FELT = load_scene('measured', drift=DRIFT)


def test_all_stages_go_on_from_the_file_bit_for_bit(tmp_path: Path) -> None:
    imu = still_sensor(40.0)
    drive = LiveTrochlea(SCENE)
    reading = drive.feed({SHIP_IMU: imu})
    estimate = DriftStage(SCENE, expect_schedule=False).feed(reading)
    topics = {SHIP_IMU: imu, **reading, **estimate}
    makers: list[Any] = [
        lambda: LiveTrochlea(SCENE),
        lambda: DriftStage(SCENE, expect_schedule=False),
        lambda: DriftStage(FELT, expect_schedule=False),
        lambda: LongitudeStage(SCENE, expect_fix=False),
    ]
    for make in makers:
        first, whole = make(), make()
        inputs = {t: topics[t] for t in first.inputs if t in topics}
        halves = [
            {t: take(one, slice(*cut)) for t, one in inputs.items()}
            for cut in ((0, 20), (20, None))
        ]
        for half in halves[:1]:
            first.feed(half)
            whole.feed(half)
        file = StateFile(tmp_path, f'/ours/{len(list(tmp_path.iterdir()))}', SCENE)
        assert file.load() is None
        file.save(first.state())
        second = make()
        loaded = file.load()
        assert loaded is not None
        second.restore(loaded)
        a, b = whole.feed(halves[1]), second.feed(halves[1])
        for topic in a:
            assert encode(topic, a[topic]) == encode(topic, b[topic])
        assert not list(tmp_path.glob(DRAFTS))


def test_a_state_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    file = StateFile(tmp_path, '/trochlea', SCENE)
    file.save({'a': 1})
    whole = file.path.read_bytes()
    with pytest.raises(ParameterError, match='is of another scene'):
        StateFile(tmp_path, '/trochlea', load_scene('ideal')).load()
    for wrong, said in (
        (whole.replace(b'"a", 1', b'"a", 2'), 'is damaged'),
        (whole.replace(b'"version": 1', b'"version": 0'), 'another version'),
        (whole.replace(code().encode(), b'0123'), rf'another code \(0123 in place of {code()}\)'),
        (whole[: len(whole) // 2], 'cannot be read|no state file|is damaged'),
        (b'', 'cannot be read'),
    ):
        file.path.write_bytes(wrong)
        with pytest.raises(ParameterError, match=said):
            file.load()
    with pytest.raises(ParameterError, match='cannot be made'):
        StateFile(file.path / 'in_a_file', '/trochlea', SCENE)


def _readers(node: Node) -> set[bytes]:
    infos = node.get_subscriptions_info_by_topic(SHIP_IMU)
    return {bytes(info.endpoint_gid) for info in infos}


def test_a_killed_clock_goes_on_and_states_its_losses(
    bench: Bench, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    options = {'source': 'foreign', 'state_folder': tmp_path, 'state_interval': 0.1}
    arguments = [part for k, v in options.items() for part in ('-p', f'{k}:={v}')]
    readings: list[TimeSamples] = []

    def read(payload: bytes) -> None:
        one = decode(READING, [payload], np.zeros(1, np.int64))
        assert isinstance(one, TimeSamples)
        readings.append(one)

    sensor = bench.add(Node('xsens'))
    publisher = publisher_of(sensor, SHIP_IMU)
    sensor.create_subscription(port(READING).message, READING, read, 100, raw=True)
    state = StateFile(tmp_path, '/trochlea', SCENE).path

    known_readers: set[bytes] = set()

    def found() -> bool:
        """Whether there is a new reader, and all match. A killed one is forgotten after 20 s."""
        there = _readers(sensor)
        return bool(there - known_readers) and publisher.get_subscription_count() == len(there)

    def sail(first_s: float, end_s: float) -> subprocess.Popen[str]:
        process = start('trochlea', '--ros-args', *arguments)
        request.addfinalizer(process.kill)
        bench.until(found)
        known_readers.update(_readers(sensor))
        begun = len(readings)
        for number, payload in enumerate(encode(SHIP_IMU, still_sensor(end_s - first_s, first_s))):
            publisher.publish(payload)
            if number % 10 == 0:
                bench.beats(sensor, 1)
        bench.until(lambda: len(readings) > begun)
        return process

    first = sail(0.0, 5.0)
    bench.until(lambda: len(readings) == 5)

    def saved() -> bool:
        """Whether the file knows of the last reading."""
        held = StateFile(tmp_path, '/trochlea', SCENE).load()
        shown = held and held['shown']
        return bool(shown) and shown.stamp_ns == readings[-1].stamp_ns[0]

    bench.until(saved)
    first.kill()
    first.communicate(timeout=PATIENCE_S)
    shown = readings[-1]
    second = sail(20.0, 25.0)
    again = readings[-1]
    setting = DialSetting.of(str(again.source[0]))
    assert setting is not None
    assert setting.set_ns == readings[0].stamp_ns[0] == START_NS
    assert setting.stops == 1
    assert setting.lost_ns == 20 * 10**9 + START_NS - shown.stamp_ns[0]
    # the dial is behind by its stated loss, but for the machine's rate
    behind_s = (again.stamp_ns[0] - again.time_ref_ns[0] - setting.lost_ns) * 1e-9
    assert abs(behind_s) < 0.2
    second.send_signal(signal.SIGTERM)
    words, _ = second.communicate(timeout=PATIENCE_S)
    assert second.returncode == 0, words
    assert state.exists()


def test_finish_ends_the_run_and_its_state(bench: Bench, tmp_path: Path) -> None:
    trochlea = TrochleaNode(**overrides(**FOREIGN, state_folder=str(tmp_path), state_interval=0.1))
    publisher, _ = with_sensor(bench, trochlea)
    send(publisher, still_sensor(5.0), bench, trochlea)
    bench.until(lambda: list(tmp_path.glob('*.state')))
    trochlea.end_input()
    assert not list(tmp_path.iterdir())


def test_a_sight_is_in_the_state_as_soon_as_it_has_come(bench: Bench, tmp_path: Path) -> None:
    """A kill a moment later must not lose it, an hour before the next writing."""
    options = {'state_folder': str(tmp_path), 'state_interval': 3600.0}
    drift = DriftEstimatorNode(**overrides(**FOREIGN, **options))
    navigator = bench.add(Node('navigator'), drift)
    publisher = publisher_of(navigator, OBSERVATION)
    bench.until(lambda: drift.inputs[OBSERVATION].matched)
    stamp = np.array([START_NS])
    publisher.publish(encode(OBSERVATION, TimeSamples(stamp, '', stamp, same('port', 1)))[0])
    bench.until(lambda: list(tmp_path.glob('*.state')))
    held = StateFile(tmp_path, '/drift_estimator', SCENE).load()
    assert held is not None
    assert list(held['pending']) == [START_NS]


def test_the_launch_keeps_the_states_of_each_scene_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv('TAUTO_FOLDER', raising=False)
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    here = [state_folder({'scene': s, 'state_folder': 'default'}) for s in ('measured', 'ideal')]
    assert {Path(folder).parent for folder in here} == {tmp_path / 'tauto_states'}
    assert len(set(here)) == 2
    assert state_folder({'scene': 'measured', 'state_folder': 'none'}) == ''
    assert state_folder({'scene': 'measured', 'state_folder': '/a/b'}) == '/a/b'
    monkeypatch.setenv('TAUTO_FOLDER', str(tmp_path / 'ours'))
    inside = state_folder({'scene': 'measured', 'state_folder': 'default'})
    assert Path(inside).is_relative_to(tmp_path / 'ours')
