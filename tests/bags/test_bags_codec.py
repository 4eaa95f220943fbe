"""CDR payloads against the rosbags library and rclpy, and round trips."""

import importlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from bags_examples import assert_same, example, fill, library_payloads, stamps
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tauto_core import samples as s
from tauto_core.bags import TOPICS, decode, encode, header_stamp_ns
from tauto_core.bags.codec import MOST_NAMES
from tauto_core.bags.table import MESSAGE_TYPES
from tauto_core.scene.errors import BagError
from tauto_core.scene.times import NS_PER_S

ONE_OF_EACH = {topic.ros_type: name for name, topic in TOPICS.items()}
EACH = pytest.mark.parametrize('topic', ONE_OF_EACH.values())
TEXT = st.text(st.characters(exclude_characters='\0', exclude_categories=['Cs']), max_size=12)
TIME = st.integers(-(2**31) * NS_PER_S, 2**31 * NS_PER_S - 1)
FLOAT = st.floats(width=64)


def floats(*shape: int) -> st.SearchStrategy[s.FloatArray]:
    return hnp.arrays(np.float64, shape, elements=FLOAT)


def test_a_type_of_each_message_is_tested() -> None:
    assert set(ONE_OF_EACH) == set(MESSAGE_TYPES)


@EACH
def test_equals_the_library_byte_for_byte(topic: str) -> None:
    samples = example(TOPICS[topic].message.samples, 9)
    assert encode(topic, samples) == library_payloads(TOPICS[topic].ros_type, samples)


@pytest.mark.parametrize('velocity', [0, 2])
@pytest.mark.parametrize('effort', [0, 2])
def test_joints_without_velocity_or_effort_equal_the_library(velocity: int, effort: int) -> None:
    samples = example(s.JointSamples, 3)
    assert isinstance(samples, s.JointSamples)
    samples = replace(
        samples, velocity=samples.velocity[:, :velocity], effort=samples.effort[:, :effort]
    )
    payloads = encode(s.ESTIMATE, samples)
    assert payloads == library_payloads('sensor_msgs/msg/JointState', samples)
    assert_same(samples, decode(s.ESTIMATE, payloads, samples.stamp_ns))


@pytest.mark.filterwarnings("ignore:module 'sre_.*is deprecated:DeprecationWarning")  # lark
@EACH
def test_equals_rclpy_but_for_its_padding(topic: str) -> None:
    """rclpy leaves arbitrary padding and up to 8 bytes after a message.

    Bytes that differ must not matter to rclpy's own reader.
    """
    serialization = pytest.importorskip('rclpy.serialization')

    def make(name: str) -> Any:
        package, _, kind = name.split('/')
        return getattr(importlib.import_module(f'{package}.msg'), kind)()

    samples = example(TOPICS[topic].message.samples, 4)
    for i, payload in enumerate(encode(topic, samples)):
        message = fill(make, samples, i)
        theirs = bytes(serialization.serialize_message(message))
        assert 0 <= len(theirs) - len(payload) <= 8
        assert serialization.deserialize_message(payload, type(message)) == message
        for at in (k for k in range(len(payload)) if payload[k] != theirs[k]):
            changed = payload[:at] + bytes([payload[at] ^ 0xFF]) + payload[at + 1 :]
            assert serialization.deserialize_message(changed, type(message)) == message, at
        assert_same(s.take(samples, slice(i, i + 1)), decode(topic, [theirs], stamps(i + 1)[i:]))


@EACH
def test_reads_what_a_big_endian_machine_publishes(topic: str) -> None:
    samples = example(TOPICS[topic].message.samples, 5)
    payloads = library_payloads(TOPICS[topic].ros_type, samples, little_endian=False)
    assert payloads[0][:2] == b'\x00\x00'
    assert_same(samples, decode(topic, payloads, samples.stamp_ns))


def test_payloads_of_different_layout_keep_their_order() -> None:
    samples = example(s.TimeSamples, 200)
    assert isinstance(samples, s.TimeSamples)
    sources = np.array([f'observer {i % 90}' for i in range(200)], object)
    samples = replace(samples, source=sources)
    little = encode(s.OBSERVATION, samples)
    big = library_payloads('sensor_msgs/msg/TimeReference', samples, little_endian=False)
    mixed = [little[i] + bytes(i % 4) if i % 3 else big[i] for i in range(200)]
    assert_same(samples, decode(s.OBSERVATION, mixed, samples.stamp_ns))


@EACH
def test_no_samples_keep_their_types(topic: str) -> None:
    samples = example(TOPICS[topic].message.samples, 0)
    back = decode(topic, encode(topic, samples), samples.stamp_ns)
    assert s.count(back) == 0
    assert {k: v.dtype for k, v in vars(back).items() if isinstance(v, np.ndarray)} == {
        k: v.dtype for k, v in vars(samples).items() if isinstance(v, np.ndarray)
    }


@given(st.lists(st.tuples(TIME, TIME, TEXT), max_size=6), TEXT)
def test_time_references_come_back(rows: list[tuple[int, int, str]], frame: str) -> None:
    when, ref, source = ([row[k] for row in rows] for k in range(3))
    samples = s.TimeSamples(
        np.array(when, np.int64),
        frame if rows else '',
        np.array(ref, np.int64),
        np.array(source, object),
    )
    assert_same(samples, decode(s.READING, encode(s.READING, samples), samples.stamp_ns))


@given(st.data(), st.lists(TEXT, max_size=4), TEXT, st.integers(1, 4))
def test_joints_come_back(data: st.DataObject, names: list[str], frame: str, n: int) -> None:
    position, velocity, effort = (data.draw(floats(n, k)) for k in (len(names), len(names), 0))
    samples = s.JointSamples(stamps(n), frame, tuple(names), position, velocity, effort)
    assert_same(samples, decode(s.PHASE, encode(s.PHASE, samples), samples.stamp_ns))


@EACH
def test_a_cut_payload_is_refused_at_every_byte(topic: str) -> None:
    samples = example(TOPICS[topic].message.samples, 1)
    (payload,) = encode(topic, samples)
    for length in range(len(payload)):
        with pytest.raises(BagError, match=topic):
            decode(topic, [payload[:length]], samples.stamp_ns)


@EACH
@given(data=st.data())
def test_any_bytes_are_decoded_or_refused(topic: str, data: st.DataObject) -> None:
    (payload,) = encode(topic, example(TOPICS[topic].message.samples, 1))
    damaged = bytearray(payload)
    for at in data.draw(st.lists(st.integers(0, len(payload) - 1), min_size=1, max_size=4)):
        damaged[at] = data.draw(st.integers(0, 255))
    try:
        samples = decode(topic, [bytes(damaged)], stamps(1))
    except BagError:
        return
    assert s.count(samples) == 1


@pytest.mark.parametrize(
    ('topic', 'change', 'problem'),
    [
        (s.SHIP_IMU, {'frame_id': 'mast'}, r"ship/imu: header.frame_id is 'clock_mount'.*'mast'"),
        (s.PHASE, {'name': ('a', 'b')}, r'name is .*wheel.*fusee.*one source'),
        (s.PHASE, {'velocity': np.empty((1, 0))}, r'velocity is 2 numbers .* 0 numbers long'),
    ],
)
def test_messages_of_two_sources_on_a_topic_are_refused(
    topic: str, change: dict[str, Any], problem: str
) -> None:
    first: Any = example(TOPICS[topic].message.samples, 1)
    payloads = encode(topic, first) + encode(topic, replace(first, **change))
    with pytest.raises(BagError, match=problem):
        decode(topic, payloads, stamps(2))


def joints(names: int, numbers: int) -> bytes:
    empty, position = np.empty((1, 0)), np.zeros((1, numbers))
    named = tuple(map(str, range(names)))
    samples = s.JointSamples(stamps(1), '', named, position, empty, empty)
    return library_payloads('sensor_msgs/msg/JointState', samples)[0]


MANY = MOST_NAMES + 1


@pytest.mark.parametrize(
    ('topic', 'payload', 'problem'),
    [
        *(
            (s.SCENE, octets, 'not plain CDR')
            for octets in (b'', b'\x00', b'\x00\x03\x00\x00data', b'{"d": 1}')
        ),
        (s.SCENE, b'\x00\x01\x00\x00\x02\x00\x00\x00\xff\x00', r'data = .* is not UTF-8'),
        (s.PHASE, joints(1, 2), r'position has 2 elements for 1 names'),
        (s.PHASE, joints(MANY, MANY), r'name has 1,001 names, and at most 1,000'),
    ],
)
def test_what_is_no_message_is_refused(topic: str, payload: bytes, problem: str) -> None:
    with pytest.raises(BagError, match=problem):
        decode(topic, [payload], stamps(1))


def at_second(seconds: int) -> s.TimeSamples:
    return s.TimeSamples(stamps(1), '', np.array([seconds * NS_PER_S]), s.same('dial', 1))


NARROW: Any = example(s.ImuSamples, 3)


@pytest.mark.parametrize(
    ('topic', 'samples', 'problem'),
    [
        (s.SCENE, s.text(0, 'a\0b'), 'zero character'),
        (s.SCENE, s.text(0, '\ud800'), 'not Unicode'),
        *((s.READING, at_second(k), f'{k} s') for k in (2**31, -(2**31) - 1)),
        (s.SHIP_IMU, s.text(0, 'x'), r'ship/imu: got TextSamples'),
        (
            s.SHIP_IMU,
            replace(NARROW, orientation=NARROW.orientation[:, :1]),
            r'orientation has shape \(3, 1\), but must have \(3, 4\)',
        ),
    ],
)
def test_what_a_message_cannot_hold_is_refused(
    topic: str, samples: s.Samples, problem: str
) -> None:
    with pytest.raises(BagError, match=problem):
        encode(topic, samples)


@EACH
def test_header_stamp(topic: str) -> None:
    if not TOPICS[topic].message.stamped:
        return
    samples = example(TOPICS[topic].message.samples, 3)
    payloads = encode(topic, samples)
    big = library_payloads(TOPICS[topic].ros_type, samples, little_endian=False)
    for found in (payloads, big):
        assert [header_stamp_ns(payload) for payload in found] == samples.stamp_ns.tolist()
    with pytest.raises(BagError, match=r'ends within header.stamp'):
        header_stamp_ns(payloads[0][:11])
