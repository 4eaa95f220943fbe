"""Messages between nodes: no loss, senders wait for receivers, ends are announced."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import rclpy
from conftest import Bench, Echo, TestSource, imu, overrides
from hypothesis import given
from hypothesis import strategies as st
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import Imu, TimeReference
from std_msgs.msg import String, UInt8MultiArray

from tauto_core.bags import check_bag, encode, read_bag
from tauto_core.samples import (
    PHASE,
    READING,
    SCENE,
    SHIP_IMU,
    JointSamples,
    TimeSamples,
    same,
    text,
)
from tauto_core.scene import load_scene, scene_yaml
from tauto_core.scene.times import NS_PER_S
from tauto_nodes import NodesError
from tauto_nodes.live import player
from tauto_nodes.live.node import TICK_S, GraphNode, port
from tauto_nodes.live.recorder import RecorderNode
from tauto_nodes.live.stages import StageNode, TrochleaNode
from tauto_nodes.simulation import credits as flow_control
from tauto_nodes.simulation.credits import (
    CREDIT_QOS,
    CREDIT_TOPIC,
    PACK_QOS,
    PACK_TOPIC,
    RUN,
    WINDOW,
    ForeignMessageError,
    Report,
    mark,
    pack,
    unpack,
)

GRAPH = ('ship_motion', 'trochlea', 'recorder')
FLOW: dict[str, Any] = {'flow_control': 'credits', 'graph': GRAPH}
TOPICS = (SHIP_IMU, READING, PHASE)
KEY = b'known to the nodes of the graph alone'
NO_FORCE = np.full((1, 3), np.nan)


def recorder(folder: Path, **parameters: Any) -> RecorderNode:
    report = str(folder.with_suffix('.json'))
    return RecorderNode(
        **overrides(output=str(folder), topics=TOPICS, report=report, **FLOW, **parameters)
    )


@pytest.mark.parametrize(('executor', 'n'), [('events', 20_000), ('single', 1_000)])
def test_nothing_is_lost_at_full_speed(executor: str, n: int, ros: Any, tmp_path: Path) -> None:
    ros(())
    bench = Bench(executor)
    sink = bench.add(
        recorder(tmp_path / 'bag', executor=executor),
        StageNode('trochlea', lambda _: Echo(), **overrides(**FLOW)),
        TestSource(n, **FLOW),
    )
    bench.until(lambda: sink.over)
    counts = json.loads((tmp_path / 'bag.json').read_text())['topics']
    assert counts == {t: {'received': n, 'written': n, 'lost': 0} for t in counts}
    bag = read_bag(tmp_path / 'bag')
    phase = bag.samples(PHASE)
    assert isinstance(phase, JointSamples)
    np.testing.assert_array_equal(phase.position[:, 0], np.arange(n))
    np.testing.assert_array_equal(phase.stamp_ns, bag.payloads(PHASE)[0])
    bench.close()


def test_strangers_that_cannot_match_do_not_hold_the_graph_up(
    bench: Bench, tmp_path: Path
) -> None:
    # One participant takes a topic for one type only, so strangers need their own.
    elsewhere = Context()
    rclpy.init(context=elsewhere, signal_handler_options=SignalHandlerOptions.NO)
    stranger = Node('stranger', context=elsewhere)
    other_type = stranger.create_subscription(
        String, SHIP_IMU, lambda _: None, QoSProfile(depth=5)
    )
    latched = QoSProfile(depth=5, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
    stranger.create_subscription(TimeReference, READING, lambda _: None, latched)
    stage = StageNode('trochlea', lambda _: Echo(), **overrides(**FLOW))
    sink = bench.add(recorder(tmp_path / 'bag'), stage, TestSource(100, **FLOW))
    assert other_type.topic_name == f'/{SHIP_IMU}'
    bench.until(lambda: sink.count_subscribers(SHIP_IMU) == 3)
    bench.until(lambda: sink.over)
    stranger.destroy_node()
    elsewhere.try_shutdown()
    assert sink.counts()[READING] == {'received': 100, 'written': 100, 'lost': 0}


class Sleeper(GraphNode):
    """A consumer that counts its messages, and takes no more while it sleeps."""

    def __init__(self, topics: Sequence[str] = TOPICS) -> None:
        super().__init__('recorder', **overrides(output='none', **FLOW))
        self.asleep = True
        self.connect([port(topic) for topic in topics], [])

    @property
    def backlogged(self) -> bool:
        """Whether it sleeps."""
        return self.asleep


@pytest.mark.parametrize('topics', [TOPICS, (READING,)], ids=['all', 'stage'])
def test_a_sleeping_consumer_holds_the_senders_back(topics: Sequence[str], bench: Bench) -> None:
    """One that sleeps on the stage's outputs only holds the stage up, and it the source."""
    n = 5_000
    stage = StageNode('trochlea', lambda _: Echo(), **overrides(**FLOW))
    source = TestSource(n, **FLOW)
    sink = bench.add(Sleeper(topics), stage, source)
    bench.until(lambda: stage.backlogged or sink.inputs[topics[0]].received == WINDOW)
    bench.beats(stage, 50)
    # In flight to it: the sink's window, the stage's content, the stage's own window.
    assert source.outputs[SHIP_IMU].sent <= (1 if topics == TOPICS else 3) * WINDOW
    assert stage.outputs[READING].sent <= WINDOW
    sink.asleep = False
    bench.until(lambda: sink.input_over)
    assert {t: i.taken for t, i in sink.inputs.items()} == dict.fromkeys(topics, n)


def test_nothing_is_sent_before_the_whole_graph_is_there(bench: Bench, tmp_path: Path) -> None:
    source = TestSource(100, **FLOW)
    stage = StageNode('trochlea', lambda _: Echo(), **overrides(**FLOW))
    bench.add(source, stage)
    bench.beats(stage, 30)
    assert source.outputs[SHIP_IMU].sent == 0
    assert source.waiting == ['node recorder']
    sink = bench.add(recorder(tmp_path / 'bag'))
    bench.until(lambda: sink.over)
    assert sink.counts()[SHIP_IMU]['written'] == 100


@pytest.mark.parametrize('packed', [False, True])
def test_an_outsider_is_served_and_does_not_disturb_the_count(
    packed: bool, bench: Bench, tmp_path: Path
) -> None:
    flow = {**FLOW, 'packed': packed}
    source = TestSource(3_000, **flow)
    outsider = GraphNode('longitude')
    outsider.connect([port(SHIP_IMU)], [])
    bench.add(outsider, source)
    output = source.outputs[SHIP_IMU]
    bench.until(lambda: output.watchers if packed else output.matched)
    sink = recorder(tmp_path / 'bag', packed=packed)
    bench.add(sink, StageNode('trochlea', lambda _: Echo(), **overrides(**flow)))
    bench.until(lambda: sink.over)
    assert {n['written'] for n in sink.counts().values()} == {3_000}
    bench.until(lambda: outsider.inputs[SHIP_IMU].received)


def test_at_a_pace_a_queue_of_ten_is_never_full(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sixty times a sensor at 20 Hz are 12 messages a tick, which come in slices.

    Its wall clock moves by a tick at each reading, and stands without credits: a late source on a
    busy machine sends at once.
    """
    now_s = 100.0
    pauses: list[float] = []

    def monotonic() -> float:
        nonlocal now_s
        now_s += 0.0 if source.backlogged else TICK_S
        return now_s

    flow = {**FLOW, 'packed': True}
    source = TestSource(1_200, speed=1.2, **flow)  # a millisecond apart, 1200 a second
    outsider = Node('outsider')
    came: list[bytes] = []
    bench.add(outsider, source)
    outsider.create_subscription(Imu, SHIP_IMU, came.append, QoSProfile(depth=10), raw=True)
    monkeypatch.setattr(player, 'time', SimpleNamespace(monotonic=monotonic, sleep=pauses.append))
    bench.until(lambda: source.outputs[SHIP_IMU].watchers)
    at_once: list[int] = []
    publish = source.outputs[SHIP_IMU].publish

    def counted(payloads: Sequence[bytes]) -> None:
        at_once.append(len(payloads))
        publish(payloads)

    source.outputs[SHIP_IMU].publish = counted
    sink = recorder(tmp_path / 'bag', packed=True)
    bench.add(sink, StageNode('trochlea', lambda _: Echo(), **overrides(**flow)))
    bench.until(lambda: sink.over)
    assert sum(at_once) == 1_200
    assert max(at_once) == 4
    assert set(pauses) == {player.PAUSE_S}


def test_a_second_publisher_on_a_topic_of_the_graph_ends_it(bench: Bench, tmp_path: Path) -> None:
    # Its messages would go into the bag and into the counts.
    source = TestSource(10**5, speed=1.0, **FLOW)
    stage = StageNode('trochlea', lambda _: Echo(), **overrides(**FLOW))
    sink = bench.add(recorder(tmp_path / 'bag'), stage, source)
    bench.until(lambda: sink.inputs[SHIP_IMU].taken)
    bench.add(Node('compass')).create_publisher(Imu, SHIP_IMU, 10)
    with pytest.raises(NodesError, match=r'ship/imu: more than one publisher .*/ship_motion'):
        bench.until(lambda: False)
    sink.close()


HOSTILE: list[bytes] = [
    *(b'', b'not json', b'[]', b'null', b'{}', b'{"node": 3}', b'{"node":"a","taken":[1]}'),
    *(
        b'{"node":"trochlea","taken":{},"matched":[],"ready":true,"number":1,"sent":{"clock/reading":%s}}'
        % n
        for n in (b'Infinity', b'-1', b'1e400', b'true')
    ),
    b'{"node":"trochlea","taken":{},"matched":[],"ready":true,"number":1,"sent":{"ship/imu":1}}',
    b'{"node":"recorder","taken":{"ship/imu":' + b'9' * 5_000 + b'},"matched":[],"number":1}',
    *(b'[' * 60_000, b'\xff\xfe\xfd', b'x' * 2**20),
]
"""Foreign messages: invalid JSON, reports, counts (also of another sender) or text, too deep, too
large."""


def closed(key: bytes, topic: str, said: bytes) -> bytes:
    """Return a text as a message of a graph."""
    said += b' ' + mark(key, topic, said).hex().encode()
    return struct.pack('<4sI', b'\0\1\0\0', len(said) + 1) + said + b'\0'


@pytest.mark.parametrize('key', [b'', KEY])
@pytest.mark.parametrize('said', HOSTILE)
def test_malformed_or_foreign_messages_are_no_report(said: bytes, key: bytes) -> None:
    for made_with in (key, b'another'):
        with pytest.raises(ForeignMessageError) as refused:
            Report.from_octets(closed(made_with, CREDIT_TOPIC, said), key)
        assert len(str(refused.value)) < 400
    with pytest.raises(ForeignMessageError):
        unpack(key, 'scene', said)


@given(st.binary(max_size=200), st.sampled_from([b'', KEY]))
def test_any_octets_are_refused(octets: bytes, key: bytes) -> None:
    with pytest.raises(ForeignMessageError):
        Report.from_octets(octets, key)
    with pytest.raises(ForeignMessageError):
        unpack(key, 'scene', octets)


def test_nothing_that_a_stranger_says_ends_a_graph_or_its_voyage(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It knows all topics and forms, and repeats messages, but lacks the key."""
    monkeypatch.setenv(RUN, KEY.decode())
    flow = {**FLOW, 'packed': True}
    stage = StageNode('trochlea', lambda _: Echo(), **overrides(**flow))
    source = TestSource(3_000, speed=1.0, **flow)
    sink = bench.add(recorder(tmp_path / 'bag', packed=True), stage, source)
    stranger, heard = bench.add(Node('stranger')), dict[str, list[bytes]]()
    topics = {CREDIT_TOPIC: (String, CREDIT_QOS)}
    topics |= {f'{PACK_TOPIC}{SHIP_IMU}': (UInt8MultiArray, PACK_QOS)}
    speak = {}
    for topic, (kind, qos) in topics.items():
        heard[topic] = []
        stranger.create_subscription(kind, topic, heard[topic].append, qos, raw=True)
        speak[topic] = stranger.create_publisher(kind, topic, qos)
    bench.until(lambda: sink.inputs[SHIP_IMU].taken > 50 and heard[f'{PACK_TOPIC}{SHIP_IMU}'])
    stranger.create_publisher(Imu, SHIP_IMU, 10).publish(Imu())
    false = Report('ship_motion', {}, number=10**6, sent={SHIP_IMU: 3}).to_octets(b'')
    for octets in [*(closed(b'', topic, each) for topic in topics for each in HOSTILE), false]:
        for publisher in speak.values():
            publisher.publish(octets)
    for topic, publisher in speak.items():
        for octets in [*pack(b'', SHIP_IMU, [b'x' * 320]), *heard[topic][:20]]:
            publisher.publish(octets)
    bench.until(lambda: all(f'{t} not_of_this_graph' in sink.health() for t in topics))
    bench.until(lambda: sink.over)
    assert sink.exit_code == 0
    assert sink.counts() == {
        topic: {'received': 3_000, 'written': 3_000, 'lost': 0} for topic in sink.counts()
    }
    stamps_ns, _ = read_bag(tmp_path / 'bag').payloads(SHIP_IMU)
    np.testing.assert_array_equal(stamps_ns, sorted(set(stamps_ns)))


def test_a_bag_with_too_few_readings_is_cut_short(bench: Bench, tmp_path: Path) -> None:
    topics = (SCENE, READING)
    sink = RecorderNode(**overrides(output=str(tmp_path / 'bag'), topics=topics, **FLOW))
    ship, clock = (GraphNode(name, **overrides(**FLOW)) for name in GRAPH[:2])
    bench.add(sink, ship, clock)
    ship.connect([], [port(SCENE)])
    clock.connect([], [port(READING)])
    bench.until(lambda: ship.flow.everyone_ready() and clock.flow.everyone_ready())
    scene = load_scene('measured', duration=3.0)
    ship.send(SCENE, encode(SCENE, text(scene.starts_at_ns, scene_yaml(scene))))
    at_ns = scene.starts_at_ns + np.arange(scene.log_count - 1) * NS_PER_S
    readings = TimeSamples(at_ns, 'clock', at_ns, same('clock', len(at_ns)))
    clock.send(READING, encode(READING, readings))
    ship.input_over = clock.input_over = True
    bench.until(lambda: sink.over)
    assert sink.counts()[READING]['lost'] == 0
    assert sink.exit_code == 1
    assert check_bag(tmp_path / 'bag').cut_short


@pytest.fixture
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nodes wait for half a second, not ten, for messages that were never sent."""
    monkeypatch.setattr(flow_control, 'LOST_AFTER_S', 0.5)


def lie(bench: Bench, node: GraphNode, role: str, topic: str) -> None:
    """Report to a node that its sender has sent seven messages, and is at its end."""
    liar = bench.add(GraphNode(role, **overrides(flow_control='credits', graph=(role, node.role))))
    bench.add(node)
    liar.connect([], [port(topic)])
    bench.until(liar.flow.everyone_ready)
    reports = liar.create_publisher(String, CREDIT_TOPIC, CREDIT_QOS)
    bench.until(lambda: reports.get_subscription_count() == 2)
    report = Report(liar.role, {}, (), True, 10**6, {topic: 7})
    reports.publish(report.to_octets(b''))


@pytest.mark.usefixtures('patience')
def test_the_last_report_counts_and_a_loss_is_told(bench: Bench, tmp_path: Path) -> None:
    # A sender that claims to have sent more than it did: the recorder must not wait for ever.
    flow = {'flow_control': 'credits', 'graph': ('trochlea', 'recorder')}
    sink = RecorderNode(**overrides(output=str(tmp_path / 'bag'), topics=(READING,), **flow))
    lie(bench, sink, 'trochlea', READING)
    bench.until(lambda: sink.over)
    assert sink.counts() == {READING: {'received': 0, 'written': 0, 'lost': 7}}
    assert sink.exit_code == 1


@pytest.mark.usefixtures('patience')
def test_a_stage_that_loses_messages_ends_with_their_number(bench: Bench) -> None:
    # Its results without them would be wrong, and no other node would notice.
    flow = overrides(flow_control='credits', graph=('ship_motion', 'trochlea'))
    lie(bench, StageNode('trochlea', lambda _: Echo(), **flow), 'ship_motion', SHIP_IMU)
    with pytest.raises(NodesError, match=r"lost on the way: \{'ship/imu': 7\}"):
        bench.until(lambda: False)


def test_an_unusable_sample_of_the_own_ship_ends_the_graph(bench: Bench) -> None:
    # from a sensor it is counted and omitted, from the scene's own ship it is a fault
    graph = ('ship_motion', 'trochlea')
    flow = overrides(flow_control='credits', graph=graph, scene='measured')
    source = bench.add(GraphNode('ship_motion', **flow), TrochleaNode(**flow))
    source.connect([], [port(SHIP_IMU)])
    bench.until(source.flow.everyone_ready)
    sample = imu(np.array([load_scene('measured').starts_at_ns]))
    source.send(SHIP_IMU, encode(SHIP_IMU, replace(sample, linear_acceleration=NO_FORCE)))
    with pytest.raises(NodesError, match='cannot be integrated: 1 not_finite'):
        bench.until(lambda: False)
