"""The real nodes with sources of others, with a bag, and as two clocks in one graph."""

from __future__ import annotations

import re
import time
from dataclasses import replace
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import (
    FOREIGN,
    Bench,
    Heard,
    imu,
    overrides,
    publish,
    publisher_of,
    still_sensor,
    with_sensor,
)
from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, TimeReference
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from tauto_core.bags import check_bag, encode, read_bag
from tauto_core.clockwork import LiveTrochlea
from tauto_core.samples import PHASE, READING, SCENE, SHIP_IMU, ImuSamples, TimeSamples
from tauto_core.scene import load_scene
from tauto_core.scene.errors import BagError
from tauto_core.ship.imu import MOUNT_FRAME, imu_from_roll
from tauto_core.voyage import ShipSource, replay, sail
from tauto_nodes import NodesError, ParameterError
from tauto_nodes.live import player as playing
from tauto_nodes.live.node import TICK_S, assess
from tauto_nodes.live.player import PlayerNode
from tauto_nodes.live.recorder import RecorderNode
from tauto_nodes.live.stages import DriftEstimatorNode, LongitudeNode, Mounting, TrochleaNode
from tauto_nodes.simulation.ship import ShipMotionNode


def test_a_best_effort_sensor_drives_the_suite(bench: Bench, tmp_path: Path) -> None:
    best_effort = {'imu_reliability': 'best_effort'}
    recorder = RecorderNode(**overrides(output=str(tmp_path / 'bag'), **best_effort))
    trochlea = TrochleaNode(**overrides(**FOREIGN, **best_effort))
    nodes = [DriftEstimatorNode(**overrides(**FOREIGN)), LongitudeNode(**overrides(**FOREIGN))]
    sensor = bench.add(Node('xsens'), recorder, trochlea, *nodes)
    publisher = sensor.create_publisher(Imu, SHIP_IMU, qos_profile_sensor_data)
    client = sensor.create_client(Trigger, 'trochlea/finish')
    bench.until(lambda: publisher.get_subscription_count() == 2 and client.service_is_ready())
    # ten seconds of sea, no faster than it is taken (best effort)
    for number, payload in enumerate(encode(SHIP_IMU, still_sensor(10.05))):
        publisher.publish(payload)
        bench.until(lambda n=number: trochlea.inputs[SHIP_IMU].received > n)
    asked = client.call_async(Trigger.Request())
    bench.until(asked.done)
    assert asked.result().success
    sent = trochlea.outputs[READING].sent
    bench.until(lambda: recorder.inputs['longitude/error'].taken >= sent - 1)
    recorder.close()
    readings = read_bag(tmp_path / 'bag').samples(READING)
    assert isinstance(readings, TimeSamples)
    # Anchored at the first stamp, log interval 1 s, ten seconds, both ends counted.
    np.testing.assert_array_equal(readings.stamp_ns, (1_700_000_000 + np.arange(11)) * 10**9)


def heard_from(
    bench: Bench, motion: ImuSamples, **parameters: Any
) -> tuple[TrochleaNode, tuple[bytes, str]]:
    """Return a clock that has taken the samples of a sensor, and its own status."""
    trochlea = TrochleaNode(**overrides(**FOREIGN, **parameters))
    publisher, _ = with_sensor(bench, trochlea)
    publish(publisher, motion)
    bench.until(lambda: trochlea.inputs[SHIP_IMU].taken == len(motion.stamp_ns))
    return trochlea, assess(trochlea, time.monotonic())


def test_imu_rotation_turns_a_sensor_into_the_clocks_axes(bench: Bench) -> None:
    upside_down = still_sensor(5.05)
    upside_down.linear_acceleration[:, 2] *= -1.0
    upside_down.orientation[:] = [-1.0, 0.0, 0.0, 0.0]
    turned, _ = heard_from(bench, upside_down, imu_rotation='180 0 0')
    assert turned.outputs[READING].sent
    assert not turned.notices
    assert not turned.health()['sensor_refused']


def test_a_fast_rough_sensor_gives_the_readings_of_its_samples(bench: Bench) -> None:
    """200 Hz, noise, 1 % of the samples missing: the graph neither adds nor loses a sample."""
    rng = np.random.default_rng(200)
    t = np.arange(1_600) / 200.0
    t = t[rng.random(len(t)) > 0.01]
    n = len(t)
    roll = 0.2 * np.sin(0.785 * t) + 3.5e-3 * rng.standard_normal(n)
    rate = 0.157 * np.cos(0.785 * t) + 1e-3 * rng.standard_normal(n)
    felt = 9.81 * np.array([np.sin(roll), np.cos(roll)]) + 0.05 * rng.standard_normal((2, n))
    stamps = 1_700_000_000 * 10**9 + np.rint(t * 1e9).astype(np.int64)
    motion = imu_from_roll(stamps, roll, rate, *felt)
    alone = LiveTrochlea(load_scene('measured'))
    expected = [alone.feed({SHIP_IMU: motion}).get(READING), alone.finish().get(READING)]
    trochlea = TrochleaNode(**overrides(**FOREIGN, imu_reliability='best_effort'))
    sensor = bench.add(Node('xsens'), trochlea)
    said: list[bytes] = []
    sensor.create_subscription(
        TimeReference, READING, said.append, QoSProfile(depth=1000), raw=True
    )
    publisher = sensor.create_publisher(Imu, SHIP_IMU, qos_profile_sensor_data)
    bench.until(lambda: publisher.get_subscription_count() == 1)
    bench.until(lambda: trochlea.outputs[READING].matched)
    for number, payload in enumerate(encode(SHIP_IMU, motion)):
        publisher.publish(payload)
        if number % 16 == 15:  # best effort: no faster than it is taken
            bench.until(lambda k=number: trochlea.inputs[SHIP_IMU].received > k)
    bench.until(lambda: trochlea.inputs[SHIP_IMU].taken == n)
    trochlea.close()
    wanted = [payload for one in expected if one is not None for payload in encode(READING, one)]
    bench.until(lambda: len(said) >= len(wanted))
    assert [bytes(payload) for payload in said] == wanted
    assert trochlea.stage.health() == alone.health()


@pytest.mark.parametrize(
    ('changed', 'said'),
    [
        (
            {'frame_id': 'imu_link'},
            r"frame 'imu_link' is not clock_mount.*tf2_ros is not installed here",
        ),
        ({'linear_acceleration': np.tile([0.0, 0.0, 1.0], (101, 1))}, r'is it in g\?'),
        (
            {'angular_velocity': np.tile([1e-3, 0.0, 0.0], (101, 1))},
            'all its numbers have stayed the same for a second',
        ),
    ],
    ids=['frame', 'g', 'frozen'],
)
def test_a_sensor_that_no_clock_can_take_is_an_error(
    changed: dict[str, Any], said: str, bench: Bench
) -> None:
    trochlea, (level, words) = heard_from(bench, replace(still_sensor(5.05), **changed))
    assert level == DiagnosticStatus.ERROR
    assert re.search(said, words)
    assert 'frame_id' not in changed or not trochlea.outputs[READING].sent


class Tree:
    """Static transforms in place of tf2_ros, which is not on PyPI: frames and quaternions."""

    def __init__(self) -> None:
        self.known: dict[str, list[float]] = {}

    def to_clock(self, frame: str) -> np.ndarray | None:
        """Return what tf2 would."""
        return np.array(self.known[frame]) if frame in self.known else None


def test_a_static_transform_gives_the_mounting_once_it_comes(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    tree = Tree()
    monkeypatch.setattr('tauto_nodes.live.stages.StaticTransforms', lambda _: tree)
    node = bench.add(Node('clock'))
    mounting = Mounting(node, '')
    to_port = replace(
        imu(np.array([10**9])),
        frame_id='imu_link',
        linear_acceleration=np.array([[1.0, 0.0, 9.8]]),
    )
    assert mounting.applied(to_port) is None
    assert 'tf2 has no static transform from it' in mounting.trouble
    half = np.sqrt(0.5)
    tree.known['imu_link'] = [0.0, 0.0, half, half]  # its x points to port
    turned = mounting.applied(to_port)
    np.testing.assert_allclose(turned.linear_acceleration, [[0.0, 1.0, 9.8]], atol=1e-15)
    assert (turned.frame_id, mounting.trouble) == (MOUNT_FRAME, '')


def test_a_reliable_subscriber_of_best_effort_is_an_error(bench: Bench) -> None:
    trochlea = TrochleaNode(**overrides(**FOREIGN))
    sensor = bench.add(Node('xsens'), trochlea)
    heard = Heard(sensor)
    words = 'no publisher on ship/imu'
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.WARN, words))
    sensor.create_publisher(Imu, SHIP_IMU, qos_profile_sensor_data)
    words = 'incompatible QoS on ship/imu'
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.ERROR, words))
    sensor.create_publisher(Imu, SHIP_IMU, QoSProfile(depth=10))
    words = 'in the last 10 s: ship/imu incompatible_qos 1'
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.WARN, words))


def test_bad_messages_are_counted_and_silence_is_an_error(bench: Bench) -> None:
    trochlea = TrochleaNode(**overrides(**FOREIGN, stale_after=0.2))
    publisher, heard = with_sensor(bench, trochlea)
    # a sensor without messages is silent, too
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.ERROR, ''))
    bad = still_sensor(0.1)
    bad.orientation[1] = 0.0
    publish(publisher, bad)
    bench.until(lambda: trochlea.inputs[SHIP_IMU].taken == 2)
    assert sum(trochlea.health().values()) == 1
    heard.status.clear()
    words = 'nothing for 0.2 s on ship/imu'
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.ERROR, words))
    values = {pair.key: pair.value for pair in heard.status['trochlea'].values}
    assert values['ship/imu received'] == '2'
    assert '1' in {values[name] for name in trochlea.health()}


def graph_in(namespace: str, duration_s: float, folder: Path) -> list[Any]:
    """Return the five nodes of a graph in a namespace, on a part of a scene."""
    common = {'flow_control': 'credits', 'scene': 'measured', 'duration': duration_s}
    own: dict[Any, dict[str, Any]] = {
        RecorderNode: {'output': str(folder)},
        LongitudeNode: {},
        DriftEstimatorNode: {},
        TrochleaNode: {},
        ShipMotionNode: {'speed': 0.0},
    }
    return [
        node(namespace=namespace, **overrides(**values, **common)) for node, values in own.items()
    ]


def test_two_clocks_in_two_namespaces(bench: Bench, tmp_path: Path) -> None:
    names = {'ours': 30.0, 'theirs': 20.0}
    graphs = {n: graph_in(f'/{n}', duration_s, tmp_path / n) for n, duration_s in names.items()}
    bench.add(*(node for nodes in graphs.values() for node in nodes))
    bench.until(lambda: all(nodes[0].over for nodes in graphs.values()))
    for name, duration_s in names.items():
        bag = read_bag(tmp_path / name)
        assert bag.namespace == name
        sail(load_scene('measured', duration=duration_s), tmp_path / 'sail', force=True)
        alone = read_bag(tmp_path / 'sail')
        for topic in (READING, PHASE, 'longitude/error'):
            assert bag.payloads(topic)[1] == alone.payloads(topic)[1]


@pytest.fixture(scope='module')
def minute(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the bag of a minute at sea."""
    folder = tmp_path_factory.mktemp('player') / 'minute'
    sail(load_scene('measured', duration=60.0), folder)
    return folder


def test_a_played_bag_drives_the_clock_again(
    bench: Bench, minute: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorder = RecorderNode(**overrides(output=str(tmp_path / 'bag'), topics=(READING,)))
    trochlea = TrochleaNode(**overrides(scene='measured', duration=60.0))
    player = PlayerNode(**overrides(bag=str(minute), rate=30.0, topics=(SHIP_IMU,), wait=20.0))
    bench.add(recorder, trochlea)
    bench.until(lambda: recorder.inputs[READING].matched)
    ticks = count()
    clock = SimpleNamespace(monotonic=lambda: TICK_S * next(ticks), sleep=lambda _: None)
    monkeypatch.setattr(playing, 'time', clock)
    bench.add(player)
    bench.until(lambda: player.over)
    assert next(ticks) * TICK_S >= 2.0  # a minute thirty times as fast
    bench.until(lambda: recorder.inputs[READING].taken == 61)
    recorder.close()
    original = read_bag(minute).samples(READING)
    again = read_bag(tmp_path / 'bag').samples(READING)
    assert isinstance(original, TimeSamples)
    assert isinstance(again, TimeSamples)
    np.testing.assert_array_equal(again.time_ref_ns, original.time_ref_ns)


def test_player_takes_all_topics_and_refuses_none(ros: Any, minute: Path) -> None:
    ros(())
    player = PlayerNode(**overrides(bag=str(minute), topics=('all',)))
    assert set(player.outputs) == {topic[1:] for topic in read_bag(minute).topics}
    with pytest.raises(ParameterError, match=r'lacks them\. It has /scene'):
        PlayerNode(**overrides(bag=str(minute), topics=('ship/imus',)))
    with pytest.raises(BagError):
        PlayerNode(**overrides(bag=str(minute / 'no')))


def test_one_source_of_time_only_and_it_rises(bench: Bench, minute: Path) -> None:
    player = PlayerNode(
        **overrides(bag=str(minute), rate=20.0, publish_clock=True, topics=(READING,), wait=0.0)
    )
    told: list[int] = []
    listener = bench.add(Node('listener'), player)
    listener.create_subscription(
        Clock, '/clock', lambda m: told.append(m.clock.sec * 10**9 + m.clock.nanosec), 10
    )
    with pytest.raises(NodesError, match='/player already publishes /clock'):
        ShipMotionNode(**overrides(publish_clock=True))
    bench.until(lambda: player.over)
    assert len(told) > 2  # one a tick, of which a busy machine grants few
    assert told == sorted(set(told))


@pytest.mark.parametrize(
    ('node', 'values', 'words'),
    [
        (TrochleaNode, {**FOREIGN, 'imu_rotation': '90'}, 'must be roll, pitch and yaw'),
        (TrochleaNode, {'flow_control': 'credits', 'state_folder': 'here'}, 'state_folder'),
        (ShipMotionNode, {'speed': 0.0}, r'speed = 0\.0.*flow_control = credits'),
        (RecorderNode, {'topics': ('clock/readin',)}, 'clock/readin is not in the table'),
        (
            RecorderNode,
            {'topics': ('all', '/depth'), 'flow_control': 'credits', 'graph': ('recorder',)},
            '/depth is not of the graph',
        ),
    ],
)
def test_a_node_refuses_what_it_cannot_do(
    node: Any, values: dict[str, Any], words: str, ros: Any, tmp_path: Path
) -> None:
    ros(())
    bag = tmp_path / 'bag'
    given = {**values, **({'output': str(bag)} if node is RecorderNode else {})}
    with pytest.raises(ParameterError, match=words):
        node(**overrides(**given))
    assert not bag.exists()


def test_a_live_bag_has_times_of_receipt_and_its_scene(ros: Any, tmp_path: Path) -> None:
    """Receipt as log time, sending as publish time: a sensor's lateness can be seen."""
    from mcap.reader import make_reader

    ros(())
    bench = Bench('single')
    live = {'executor': 'single', 'scene': 'measured', 'topics': ('all', '/depth')}
    recorder = RecorderNode(**overrides(output=str(tmp_path / 'bag'), **live))
    trochlea = TrochleaNode(**overrides(**FOREIGN, executor='single'))
    sensor = bench.add(Node('imu'), recorder, trochlea)
    depth = sensor.create_publisher(Float64, '/depth', qos_profile_sensor_data)
    unknown = sensor.create_publisher(ParameterEvent, '/unheard', 1)
    publisher = publisher_of(sensor, SHIP_IMU)
    bench.until(lambda: publisher.get_subscription_count() == 2 and depth.get_subscription_count())
    assert not unknown.get_subscription_count()
    began_ns = time.time_ns()
    publish(publisher, still_sensor(5.0))
    depth.publish(Float64(data=40.0))
    bench.until(lambda: recorder.inputs[READING].taken and recorder.inputs['/depth'].taken)
    bench.until(lambda: '/diagnostics' in recorder.inputs)
    bench.until(lambda: recorder.inputs['/diagnostics'].taken)
    recorder.close()
    bench.close()
    seen: dict[str, list[tuple[int, int]]] = {}
    (file,) = (tmp_path / 'bag').glob('*.mcap')
    with file.open('rb') as stream:
        for _, channel, message in make_reader(stream).iter_messages(log_time_order=False):
            seen.setdefault(channel.topic, []).append((message.log_time, message.publish_time))
    assert next(iter(seen)) == '/scene'
    assert {'/ship/imu', '/depth', '/clock/reading', '/diagnostics'} <= seen.keys()
    for topic in ('/ship/imu', '/depth', '/clock/reading'):
        for received_ns, sent_ns in seen[topic]:
            assert began_ns <= sent_ns <= received_ns < time.time_ns()  # stamps are of 2023
    assert check_bag(tmp_path / 'bag').whole
    replayed = replay(read_bag(tmp_path / 'bag'), keep=False).result
    stamps = read_bag(tmp_path / 'bag').samples(READING).stamp_ns
    assert replayed['scene'] == load_scene('measured').name
    assert replayed['duration_s'] == (stamps[-1] - stamps[0]) / 1e9  # of sea, not of receipt
    assert replayed['start_s'] == stamps[0] / 1e9


def test_a_recorder_that_is_told_to_stop_hears_the_last_words(
    bench: Bench, tmp_path: Path
) -> None:
    recorder = RecorderNode(**overrides(output=str(tmp_path / 'bag')))
    trochlea = TrochleaNode(**overrides(**FOREIGN))
    sensor = bench.add(Node('imu'), recorder, trochlea)
    publisher = publisher_of(sensor, SHIP_IMU)
    bench.until(lambda: publisher.get_subscription_count() == 2)
    bench.until(lambda: recorder.inputs[READING].matched)
    publish(publisher, still_sensor(10.05))
    bench.until(lambda: trochlea.inputs[SHIP_IMU].taken == 201)
    assert recorder.waits_on_shutdown()  # both get the signal at once
    trochlea.close()
    bench.remove(trochlea)
    bench.until(lambda: not recorder.waits_on_shutdown())
    recorder.close()
    assert read_bag(tmp_path / 'bag').counts['/clock/reading'] == 11  # at 0, 1, …, 10 s


def test_a_recorder_that_is_left_alone_stops_in_the_end(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorder = RecorderNode(**overrides(output=str(tmp_path / 'bag')))
    trochlea = TrochleaNode(**overrides(**FOREIGN))
    bench.add(recorder, trochlea)
    bench.until(lambda: recorder.inputs[READING].matched)
    assert recorder.waits_on_shutdown()
    later_s = time.monotonic() + 5.0
    monkeypatch.setattr('tauto_nodes.live.recorder.time.monotonic', lambda: later_s)
    assert not recorder.waits_on_shutdown()
    monkeypatch.undo()
    recorder.close()


def test_a_recorder_started_again_writes_beside_the_bag(ros: Any, tmp_path: Path) -> None:
    ros(())
    for name in ('bag', 'bag_2', 'bag_3'):
        recorder = RecorderNode(**overrides(output=str(tmp_path / 'bag'), beside=True))
        assert (tmp_path / name / f'{name}_0.mcap').is_file()
        recorder.close()


def test_recorder_leaves_out_motion_that_the_scene_does_not_keep(ros: Any, tmp_path: Path) -> None:
    ros(())
    recorder = RecorderNode(**overrides(output=str(tmp_path / 'a'), scene='portsmouth_jamaica'))
    assert SHIP_IMU not in recorder.inputs
    assert READING in recorder.inputs
    recorder.close()


def test_full_speed_is_refused_at_run_time_too(ros: Any) -> None:
    ros(())
    ship = ShipMotionNode(**overrides(speed=1.0))
    assert not ship.set_parameters([Parameter('speed', value=0.0)])[0].successful
    assert ship.set_parameters([Parameter('speed', value=2.0)])[0].successful


def test_qos_overrides_that_would_lose_messages_are_refused(ros: Any, tmp_path: Path) -> None:
    ros(('-p', 'qos_overrides./ship/imu.subscription.depth:=10'))
    with pytest.raises(ParameterError, match=r'depth = 10.* at least 1000'):
        RecorderNode(**overrides(output=str(tmp_path / 'bag'), flow_control='credits'))


def test_what_came_before_the_last_flush_is_in_the_file(bench: Bench, tmp_path: Path) -> None:
    """A killed recorder leaves the file as it is here, while the recorder still runs."""
    options = {'flush_interval': 0.1, 'chunk_size': 1024.0, 'compression': 'none'}
    recorder = RecorderNode(
        **overrides(output=str(tmp_path / 'bag'), topics=(SHIP_IMU,), **options)
    )
    publisher, _ = with_sensor(bench, recorder)
    publish(publisher, still_sensor(0.25))
    file = next((tmp_path / 'bag').glob('*.mcap'))
    bench.until(lambda: read_bag(file).counts.get('/ship/imu') == 5)
    recorder.close()
    assert read_bag(tmp_path / 'bag').counts == {'/ship/imu': 5}


def test_the_scene_is_the_first_message_of_the_bag(ros: Any, tmp_path: Path) -> None:
    from mcap.reader import NonSeekingReader

    ros(())
    graph = ('ship_motion', 'recorder')
    flow = {'flow_control': 'credits', 'graph': graph, 'topics': (SCENE, SHIP_IMU)}
    recorder = RecorderNode(**overrides(output=str(tmp_path / 'bag'), **flow))
    scene = load_scene('ideal', duration=60.0)
    said = ShipSource(scene).produce(10)
    recorder.take({SHIP_IMU: encode(SHIP_IMU, said[SHIP_IMU])})
    recorder.take({SCENE: encode(SCENE, said[SCENE])})
    # on the disk at once: it survives a disk that fills up later
    file = next((tmp_path / 'bag').glob('*.mcap'))
    with file.open('rb') as stream:
        messages = NonSeekingReader(stream).iter_messages(log_time_order=False)
        assert next(iter(messages))[1].topic == '/scene'
    recorder.close()
    assert read_bag(tmp_path / 'bag').counts['/ship/imu'] == len(said[SHIP_IMU].stamp_ns)
