"""Faulty peers: garbage, wild stamps, second publishers, duplicate nodes. No node ends, and every
fault is reported.
"""

from __future__ import annotations

import os
import pickle
import random
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from conftest import (
    FOREIGN,
    START_NS,
    WARM,
    Bench,
    Heard,
    overrides,
    publish,
    publisher_of,
    send,
    still_sensor,
    with_sensor,
)
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from tauto_core.bags import TOPICS, decode, encode, read_bag
from tauto_core.clockwork import DialSetting
from tauto_core.clockwork.trochlea import SLACK_NAMES
from tauto_core.navigation.longitude import STATUS_NO_FIX, fix_samples
from tauto_core.samples import (
    LONGITUDE_ERROR,
    LONGITUDE_FIX,
    READING,
    SHIP_FIX,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    SLACK,
    FixSamples,
    TimeSamples,
    count,
    same,
    scalars,
    take,
)
from tauto_core.scene import load_scene, parse_scene, scene_yaml
from tauto_core.scene.errors import PropagationError
from tauto_core.voyage import sail
from tauto_nodes.live.markers import MARKERS, MarkersNode
from tauto_nodes.live.node import Intake, node_of, port
from tauto_nodes.live.recorder import RecorderNode
from tauto_nodes.live.stages import DriftEstimatorNode, LongitudeNode, TrochleaNode

COVARIATES = {'covariates': ['roll'], 'coefficients': {'roll': {'value': 0.01, 'sigma': 0.02}}}
GARBAGE = int(os.environ.get('TAUTO_GARBAGE', '500'))
"""Messages on each subscription. `make stress` sends ten thousand."""


def garbage(topic: str, rng: random.Random) -> bytes:
    """Return random bytes, or a message of the topic with random numbers or a byte changed."""
    kind = rng.randrange(3)
    if kind == 0:
        return rng.randbytes(rng.randrange(1, 400))
    if kind == 1:
        return b'\x00\x01\x00\x00' + rng.randbytes(rng.randrange(0, 400))
    payload = bytearray(VALID[topic])
    for _ in range(rng.randrange(1, 9)):
        payload[rng.randrange(4, len(payload))] = rng.randrange(256)
    return bytes(payload)


def _valid() -> dict[str, bytes]:
    # no thread of this scene goes slack, so a message stands for one
    tautened = scalars(np.array([0], np.int64), SLACK_NAMES, np.array([[1.0, 0.1, 1e-3]]))
    found = {SLACK: encode(SLACK, tautened)[0]}
    # with air, so the thermometer publishes, too
    air = {'kind': 'constant', 'celsius': 20.0}
    scene = load_scene('measured', duration=61.0, air=air)

    def keep(batches: Any) -> None:
        for topic, samples in batches.items():
            if topic not in found and len(samples.stamp_ns):
                found[topic] = encode(topic, take(samples, slice(0, 1)))[0]

    sail(scene, watch=keep)
    return found


VALID = _valid()


def resident_bytes() -> int:
    return int(Path('/proc/self/statm').read_text().split()[1]) * 4096


def test_garbage_on_every_subscription_ends_no_node(bench: Bench, tmp_path: Path) -> None:
    scene = tmp_path / 'scene.yaml'  # with covariates the drift estimator takes ship/imu too
    scene.write_text(scene_yaml(load_scene('measured', drift=COVARIATES)), encoding='utf-8')
    recorder = RecorderNode(**overrides(output=str(tmp_path / 'bag')))
    nodes = [
        recorder,
        TrochleaNode(**overrides(**FOREIGN)),
        DriftEstimatorNode(**overrides(source='foreign', scene=str(scene))),
        LongitudeNode(**overrides(**FOREIGN, use_sim_time=True)),
        MarkersNode(**overrides(scene='measured')),
    ]
    vandal = bench.add(Node('vandal'), *nodes)
    heard = Heard(vandal)
    vandal.create_subscription(MarkerArray, MARKERS, lambda _: None, QoSProfile(depth=1))
    clock = vandal.create_publisher(Clock, '/clock', QoSProfile(depth=10))
    publishers = {topic: publisher_of(vandal, topic) for topic in TOPICS}
    bench.until(lambda: all(len(node.inputs) for node in nodes))
    bench.until(lambda: all(i.matched for node in nodes for i in node.inputs.values()))
    bench.until(clock.get_subscription_count)
    rng = random.Random(1726)
    used_bytes = []
    for _ in range(2):
        for number in range(GARBAGE // 2):
            for topic, publisher in publishers.items():
                publisher.publish(garbage(topic, rng))
                if number % 5 == 0:
                    publisher.publish(VALID[topic])
            clock.publish(b'\x00\x01\x00\x00' + rng.randbytes(3))
            clock.publish(Clock(clock=Time(sec=rng.randrange(2**31))))
            if number % 10 == 0:
                bench.beats(recorder, 1)
        bench.beats(recorder, 5)
        used_bytes.append(resident_bytes())
    assert used_bytes[1] - used_bytes[0] < 10 * 2**20
    assert all(node.failure is None for node in nodes)
    for node in nodes:
        assert any('undecodable' in name for name in node.health())
        bench.until(lambda n=node: n.get_name() in heard.status)
        bench.until(lambda n=node: heard.status[n.get_name()].level > DiagnosticStatus.OK)
    recorder.close()
    bag = read_bag(tmp_path / 'bag')
    assert bag.counts['/ship/imu'] > GARBAGE // 10
    assert '/diagnostics' in bag.topics
    for topic in TOPICS:
        bag.samples(topic)


def test_frames_are_not_mixed_however_they_come(bench: Bench) -> None:
    trochlea = TrochleaNode(**overrides(**FOREIGN, imu_rotation='0 0 0'))
    publisher, heard = with_sensor(bench, trochlea)
    one = encode(SHIP_IMU, replace(still_sensor(5.0), frame_id='mast'))
    other = encode(SHIP_IMU, replace(still_sensor(5.0, 0.02), frame_id='keel'))
    for pair in zip(one, other, strict=True):
        for payload in pair:
            publisher.publish(payload)
    bench.until(lambda: trochlea.inputs[SHIP_IMU].taken == 200)
    assert trochlea.health()['ship/imu other_frame'] == 100
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.WARN, 'ship/imu other_frame 100'))
    assert any("frame 'keel', not 'mast'" in line for line in heard.log)


def test_of_what_a_message_says_logs_have_80_characters() -> None:
    said: list[str] = []
    intake = Intake(SHIP_IMU, lambda _, words: said.append(words))
    for frame in ('mast', 'x' * 10**6):
        intake.samples(encode(SHIP_IMU, replace(still_sensor(5.0), frame_id=frame))[:1])
    assert len(said) == 1
    assert 'x' * 70 in said[0]
    assert len(said[0]) < 250


def test_a_second_publisher_is_named(bench: Bench) -> None:
    trochlea = TrochleaNode(**overrides(**FOREIGN))
    one, other = bench.add(Node('xsens'), trochlea), bench.add(Node('vectornav'))
    heard = Heard(one)
    for node in (one, other):
        publisher_of(node, SHIP_IMU)
    words = 'several publishers on ship/imu: /vectornav, /xsens'
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.WARN, words))


def test_a_publisher_outside_ros_is_worded_for_a_person() -> None:
    """Such a publisher has no node, and rmw gives it a placeholder for a name."""
    info = SimpleNamespace(node_name='_NODE_NAME_UNKNOWN_', node_namespace='/')
    assert node_of(info) == 'a node not yet known by name'


def test_motion_of_another_start_is_refused_with_the_parameter(bench: Bench) -> None:
    trochlea = TrochleaNode(**overrides(scene='measured'))
    publisher, _ = with_sensor(bench, trochlea)
    publish(publisher, still_sensor(5.0))
    with pytest.raises(PropagationError, match='source:=foreign for every node'):
        bench.until(lambda: False)


def test_a_lost_sensor_stops_the_dial_and_the_whole_graph_knows(
    bench: Bench, tmp_path: Path
) -> None:
    trochlea = TrochleaNode(**overrides(**FOREIGN))
    drift = DriftEstimatorNode(**overrides(**FOREIGN))
    recorder = RecorderNode(**overrides(output=str(tmp_path / 'bag')))
    longitude = LongitudeNode(**overrides(**FOREIGN))
    publisher, heard = with_sensor(bench, trochlea, drift, longitude, recorder)
    send(publisher, still_sensor(10.0), bench, trochlea)
    broken = still_sensor(3.0, 10.0)
    broken.orientation[:] = np.nan
    send(publisher, broken, bench, trochlea)
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.ERROR, 'not_finite'))
    wild = still_sensor(0.05, 1e6)
    send(publisher, wild, bench, trochlea)
    send(publisher, still_sensor(10.0, 13.0), bench, trochlea)
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.ERROR, 'the dial stood still'))
    bench.until(lambda: drift.health()['dial_stops'] == 1)
    assert any('the dial stood still for' in line for line in heard.log)
    # The sensor's time steps back by 13 s: the dial is not set again.
    send(publisher, still_sensor(10.0), bench, trochlea)
    bench.until(lambda: drift.health()['dial_stops'] == 2)
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.ERROR, 'goes on from where it'))
    recorder.close()
    readings = read_bag(tmp_path / 'bag').samples(READING)
    assert isinstance(readings, TimeSamples)
    settings = {DialSetting.of(str(text)) for text in readings.source}
    said = {(one.number, one.stops, one.unsure_ns // 10**9) for one in settings if one}
    assert said == {(1, 0, 0), (1, 1, 0), (1, 2, 22)}
    assert drift.health()['dial_settings'] == 0


@pytest.mark.parametrize(('moving_s', 'stands_s'), [(0.0, -1.7e9), (0.0, 0.0), (4.0, 3.95)])
def test_stamps_that_stand_are_an_error_that_names_them(
    moving_s: float, stands_s: float, bench: Bench
) -> None:
    """The node's memory does not grow, either."""
    trochlea = TrochleaNode(**overrides(**FOREIGN))
    publisher, heard = with_sensor(bench, trochlea)
    send(publisher, still_sensor(moving_s), bench, trochlea)
    stamp_ns = START_NS + round(stands_s * 1e9)
    standing = replace(still_sensor(40.0), stamp_ns=np.full(800, stamp_ns))
    sizes = []
    for _ in range(2):
        send(publisher, standing, bench, trochlea)
        sizes.append(len(pickle.dumps(trochlea.stage.state())))
    assert sizes[1] < sizes[0] + 100
    words = f'its stamps stand still at {stamp_ns / 1e9:.3f} s. Let the driver stamp each sample'
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.ERROR, words))


def test_a_late_sample_is_counted_and_is_no_fault(bench: Bench) -> None:
    trochlea = TrochleaNode(**overrides(**FOREIGN))
    publisher, heard = with_sensor(bench, trochlea)
    imu = still_sensor(10.0)
    imu.stamp_ns[99] -= 2 * 10**8
    send(publisher, take(imu, slice(0, 100)), bench, trochlea)
    assert not trochlea.trouble  # while the late one is the newest
    send(publisher, take(imu, slice(100, None)), bench, trochlea)
    assert trochlea.health()['out_of_order'] == 1

    def values() -> dict[str, str]:
        status = heard.status.get('trochlea', DiagnosticStatus())
        return {pair.key: pair.value for pair in status.values}

    bench.until(lambda: values().get('out_of_order') == '1')
    bench.until(lambda: heard.says('trochlea', DiagnosticStatus.OK, 'under way'))

    def rate_hz() -> float:
        publisher.publish(encode(SHIP_IMU, take(imu, slice(-1, None)))[0])
        return float(values().get('ship/imu rate [Hz]', 0.0))

    bench.until(lambda: rate_hz() > 0.0)
    assert float(values()['ship/imu age [s]']) >= 0.0


def test_only_a_clock_that_goes_back_sets_the_dial_anew(bench: Bench) -> None:
    trochlea = TrochleaNode(**overrides(**FOREIGN, use_sim_time=True))
    publisher, _ = with_sensor(bench, trochlea)
    clock = bench.add(Node('gazebo')).create_publisher(Clock, '/clock', QoSProfile(depth=10))
    bench.until(clock.get_subscription_count)

    def tell(seconds: int) -> None:
        clock.publish(Clock(clock=Time(sec=1_700_000_000 + seconds)))
        bench.until(lambda: trochlea.get_clock().now().nanoseconds == START_NS + seconds * 10**9)

    tell(300)
    send(publisher, still_sensor(5.0, 300.0), bench, trochlea)
    tell(0)
    send(publisher, still_sensor(5.0), bench, trochlea)
    bench.until(lambda: trochlea.health()['dial_settings'] == 1)
    assert trochlea.health()['dial_stops'] == 0
    send(publisher, still_sensor(5.0, -300.0), bench, trochlea)  # /clock did not go back
    bench.until(lambda: trochlea.health()['dial_stops'] == 1)
    assert trochlea.health()['dial_settings'] == 1


def test_who_asks_for_it_has_the_dial_set_anew(bench: Bench) -> None:
    trochlea = TrochleaNode(**overrides(**FOREIGN, reset_on_time_jump=True))
    publisher, _ = with_sensor(bench, trochlea)
    for _ in range(2):
        send(publisher, still_sensor(5.0), bench, trochlea)
    bench.until(lambda: trochlea.health()['dial_settings'] == 1)


def test_a_place_without_a_good_fix_is_unknown_and_said(bench: Bench, tmp_path: Path) -> None:
    """A right dial is read each second, and each part of the passage has its own fixes.

    A second estimator, with gravity as a covariate, hears the same receiver.
    """
    file = tmp_path / 'scene.yaml'
    file.write_text(WARM.replace('temperature_squared, gravity, temperature', 'gravity'), 'utf-8')
    heavy = DriftEstimatorNode(
        namespace='/other',
        cli_args=['--ros-args', '-r', f'{SHIP_FIX}:=/{SHIP_FIX}'],
        **overrides(source='foreign', scene=str(file)),
    )
    drift = DriftEstimatorNode(**overrides(**FOREIGN))
    longitude = LongitudeNode(**overrides(**FOREIGN))
    ship = bench.add(Node('ship'), heavy, drift, longitude)
    heard = Heard(ship)
    receiver, dial = publisher_of(ship, SHIP_FIX), publisher_of(ship, READING)
    places: list[bytes] = []
    ship.create_subscription(port(SHIP_FIX).message, LONGITUDE_FIX, places.append, 100, raw=True)
    errors, fixes = longitude.outputs[LONGITUDE_ERROR], longitude.outputs[LONGITUDE_FIX]
    heard_by = drift.inputs[READING], *longitude.inputs.values(), heavy.inputs[SHIP_FIX]
    bench.until(lambda: fixes.matched and all(source.matched for source in heard_by))

    def sail(until_s: int, *place: float, status: int = 0) -> FixSamples:
        """Return the places that are published by then, with such a fix in each second."""
        places.clear()
        before = fixes.sent
        for second in range(errors.sent + 1, until_s + 1):
            stamp = np.array([START_NS + second * 10**9])
            for north, east in zip(place[::2], place[1::2], strict=True):
                fix = fix_samples(stamp, np.array([north]), np.array([east]), np.ones((1, 3)))
                fix.status[:] = status
                receiver.publish(encode(SHIP_FIX, fix)[0])
                taken = longitude.inputs[SHIP_FIX].taken
                for one in (longitude, heavy):
                    bench.until(lambda s=one.inputs[SHIP_FIX], n=taken: s.taken > n)
            dial.publish(encode(READING, TimeSamples(stamp, '', stamp, same('dial', 1)))[0])
            bench.until(lambda n=second: errors.sent == n)
        bench.until(lambda: len(places) == fixes.sent - before)
        published = decode(LONGITUDE_FIX, places, np.zeros(len(places), np.int64))
        assert isinstance(published, FixSamples)
        assert (published.status == STATUS_NO_FIX).all()
        return published

    assert not count(sail(3, 50.0, -5.0, status=-1))  # no fix
    bench.until(lambda: heard.says('longitude', DiagnosticStatus.WARN, 'no fix has come'))
    assert longitude.health()['fixes_invalid'] == heavy.health()['latitude_refused'] == 3
    np.testing.assert_array_equal(sail(6, 50.0, -5.0).latitude, 50.0)
    np.testing.assert_array_equal(sail(9, 0.0, 0.0).latitude, 50.0)
    np.testing.assert_array_equal(sail(12, 50.0, 135.0).latitude, 50.0)
    for name in ('longitude', 'other/drift_estimator'):
        words = 'fixes_at_0_0 3, fixes_out_of_reach 3'
        bench.until(lambda n=name, w=words: heard.says(n, DiagnosticStatus.WARN, w))
    assert heavy.health()['latitude_refused'] == 9
    ship.destroy_publisher(receiver)
    aged = sail(18)
    assert (aged.stamp_ns - START_NS)[-1] == 16 * 10**9  # fix_max_age, 10 s, after the last good
    assert np.all(np.diff(aged.position_covariance[:, 4]) > 0.0)
    words = 'the last fix is 12 s old, fix_max_age is 10'
    bench.until(lambda: heard.says('longitude', DiagnosticStatus.WARN, words))


def test_the_service_reset_sets_the_dial_anew(bench: Bench) -> None:
    trochlea = TrochleaNode(**overrides(**FOREIGN))
    drift = DriftEstimatorNode(**overrides(**FOREIGN))
    publisher, heard = with_sensor(bench, trochlea, drift)
    client = bench.add(Node('officer')).create_client(Trigger, 'trochlea/reset')
    bench.until(client.service_is_ready)
    send(publisher, still_sensor(5.0), bench, trochlea)
    asked = client.call_async(Trigger.Request())
    bench.until(asked.done)
    assert asked.result().success
    send(publisher, still_sensor(5.0, 5.0), bench, trochlea)
    bench.until(lambda: drift.health()['dial_settings'] == 1)
    assert trochlea.health()['dial_stops'] == 0
    bench.until(lambda: any('on request the dial is set anew' in line for line in heard.log))


def test_a_failed_node_says_so_and_keeps_answering(bench: Bench) -> None:
    trochlea = TrochleaNode(**overrides(scene='measured'))
    sensor = Node('xsens')
    heard = Heard(sensor)
    alone = Bench()
    alone.add(sensor)
    bench.add(trochlea)
    publisher = publisher_of(sensor, SHIP_IMU)

    def failed() -> bool:
        publisher.publish(encode(SHIP_IMU, still_sensor(0.05))[0])
        return trochlea.failure is not None

    bench.until(failed)
    # As in a foreign executor, which does not know of failures.
    bench._executor.remove_node(trochlea)
    alone._executor.add_node(trochlea)

    def told() -> bool:
        fatal = any('the scene starts at' in line for line in heard.log)
        return fatal and heard.says('trochlea', DiagnosticStatus.ERROR, 'failed:')

    alone.until(told)
    heard.status.clear()
    alone.until(told)
    alone.close()


def test_a_latitude_and_a_thermometer_that_never_come_are_said(
    bench: Bench, tmp_path: Path
) -> None:
    """The estimate does not wait, and the coefficients keep their priors."""
    file = tmp_path / 'scene.yaml'
    file.write_text(WARM, encoding='utf-8')
    estimator = bench.add(DriftEstimatorNode(**overrides(source='foreign', scene=str(file))))
    scene = parse_scene(WARM, 'warm')
    publisher = publisher_of(bench.add(Node('dial')), READING)
    source = estimator.inputs[READING]
    bench.until(lambda: source.matched == 1)
    for payload in encode(READING, sail(scene).samples[READING]):
        publisher.publish(payload)
    bench.until(lambda: source.taken == scene.log_count)
    bench.until(lambda: len(estimator.notices) == 2)
    for topic, notice in zip((SHIP_FIX, SHIP_TEMPERATURE), estimator.notices, strict=True):
        assert f'on {topic}, or leave' in notice
