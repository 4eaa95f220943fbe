"""Markers: the clock rolls with the ship, at a limited rate, and only with subscribers."""

from __future__ import annotations

import importlib.util
import json
import math
import re
import time
import xml.etree.ElementTree as ET
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml
from conftest import Bench, overrides, publisher_of
from geometry_msgs.msg import TransformStamped
from modules import module_of
from rclpy.node import Node
from rosbags.highlevel import AnyReader
from visualization_msgs.msg import MarkerArray

from tauto_core.bags import encode
from tauto_core.clockwork.trochlea import WHEEL_FRAME
from tauto_core.samples import JOINT_STATES, SHIP_IMU, FloatArray, scalars
from tauto_core.scene import load_scene
from tauto_core.ship.imu import MOUNT_FRAME, imu_from_roll, quaternion_of_angles
from tauto_core.voyage import sail
from tauto_nodes.live.markers import (
    MARKERS,
    TF,
    MarkersNode,
    clock_points,
    fixed,
    moving,
    transform,
)

PACKAGE = Path(__file__).parents[3] / 'src' / 'tauto_nodes'
LAYOUTS = PACKAGE / 'layouts'


def quaternion(roll_rad: float) -> FloatArray:
    return quaternion_of_angles(roll_rad, 0.0, 0.0)


def frames(chain: list[TransformStamped]) -> list[tuple[str, str]]:
    return [(one.header.frame_id, one.child_frame_id) for one in chain]


def test_the_frames_are_those_of_rep_105_and_of_the_messages() -> None:
    turning = moving(quaternion(0.1), quaternion(0.7))
    assert frames(turning) == [('map', 'base_link'), ('clock_case', 'wheel')]
    assert frames(fixed()) == [('base_link', 'clock_mount'), ('clock_mount', 'clock_case')]
    assert turning[1].transform.rotation.x == pytest.approx(math.sin(0.35))
    # each frame of a message is in the tree
    assert {MOUNT_FRAME, WHEEL_FRAME} <= {child for _, child in frames(fixed())}


def test_a_frame_has_one_parent_and_others_come_first(bench: Bench) -> None:
    node = bench.add(MarkersNode(**overrides(scene='measured')))
    chain = moving(quaternion(0.1), quaternion(0.7))
    assert frames(node.ours(chain)) == frames(chain)
    node.hear(SimpleNamespace(transforms=chain))  # its own, which it hears, too
    assert not node.given
    # a filter on the same sensor has its stamps
    node.hear(SimpleNamespace(transforms=[transform('odom', 'base_link', quaternion(0.1))]))
    assert frames(node.ours(chain)) == [('clock_case', 'wheel')]
    node.hear(SimpleNamespace(transforms=[transform('deck', 'clock_mount', quaternion(0.0))]))
    assert frames(node.ours(fixed())) == [('clock_mount', 'clock_case')]


def test_the_urdf_has_the_frames_and_the_joint_of_the_messages() -> None:
    robot = ET.parse(PACKAGE / 'urdf/clock.urdf').getroot()
    joints = {
        joint.get('name'): (joint.find('parent').get('link'), joint.find('child').get('link'))
        for joint in robot.iter('joint')
    }
    tree = {*frames(fixed()), ('clock_case', 'wheel')}
    assert set(joints.values()) == tree
    sailed = sail(load_scene('measured', duration=2.0))
    assert joints['wheel'][0] == sailed.samples[JOINT_STATES].frame_id
    assert set(sailed.samples[JOINT_STATES].name) == {'wheel'}
    assert [axis.get('xyz') for axis in robot.iter('axis')] == ['1 0 0']


def test_the_view_of_rviz_shows_what_markers_publishes() -> None:
    view = yaml.safe_load((PACKAGE / 'rviz/clock.rviz').read_text())['Visualization Manager']
    shown = {display['Class'].split('/')[1]: display for display in view['Displays']}
    assert shown['MarkerArray']['Topic']['Value'] == f'/{MARKERS}'
    assert view['Global Options']['Fixed Frame'] == 'map'
    assert 'TF' in shown


def test_the_drawing_is_seen_from_astern() -> None:
    from tauto_core.plots.chart import Line

    line = Line('', np.array([10.0]), np.array([20.0]))
    np.testing.assert_allclose(clock_points(line, 1.0), [[0.0, -0.010, 0.020]])


@pytest.fixture(scope='module')
def recorded(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return a message of each topic of a bag, decoded by rosbags."""
    out = tmp_path_factory.mktemp('layouts') / 'bag'
    sail(load_scene('measured', duration=60.0), out)
    with AnyReader([out]) as reader:
        return {c.topic: reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages()}


def panels_of(layout: dict[str, Any] | str) -> list[str]:
    """Return the panels of a Foxglove layout: a tree of rows and columns of two."""
    if isinstance(layout, str):
        return [layout]
    assert layout['direction'] in {'row', 'column'}
    assert 0 < layout['splitPercentage'] < 100
    return [*panels_of(layout['first']), *panels_of(layout['second'])]


def number_at(message: Any, path: list[str]) -> float:
    """Return the number that a path of fields leads to."""
    for field in path:
        name, _, index = field.partition('[')
        message = getattr(message, name)
        if index:
            message = message[int(index.rstrip(']'))]
    return float(message)


def test_the_foxglove_layout_shows_fields_of_recorded_messages(recorded: dict[str, Any]) -> None:
    foxglove = json.loads((LAYOUTS / 'foxglove.json').read_text())
    panels = foxglove['configById']
    assert sorted(panels_of(foxglove['layout'])) == sorted(panels)
    assert list(panels['3D!clock']['topics']) == [f'/{MARKERS}']
    shown = [path for panel in panels.values() for path in panel.get('paths', ())]
    assert len(shown) == 6
    documented = module_of(LAYOUTS.parents[2] / 'docs/topics.py').topic_reference()
    for path in shown:
        topic, *fields = path['value'].split('.')
        assert f'`{topic.strip("/")}`' in documented
        assert math.isfinite(number_at(recorded[topic], fields)), path
    names = {
        path['label']: recorded[topic].name[int(index)]
        for path in shown
        for topic, index in re.findall(r'(.*)\.position\[(\d)\]', path['value'])
    }
    assert names == {
        'angle of the wheel [rad]': 'wheel',
        'estimated offset': 'offset_s',
        'its standard deviation': 'offset_sigma_s',
        'raw': 'raw_error_nmi',
        'corrected': 'error_nmi',
    }


def test_the_plotjuggler_layout_shows_recorded_series(recorded: dict[str, Any]) -> None:
    """PlotJuggler names a joint's series topic/joint/position, others topic/field/field."""
    root = ET.parse(LAYOUTS / 'plotjuggler.xml').getroot()
    for splitter in root.iter('DockSplitter'):
        assert int(splitter.attrib['count']) == len(splitter)
        assert len(splitter.attrib['sizes'].split(';')) == len(splitter)
        assert splitter.attrib['orientation'] in {'-', '|'}
    curves = [curve.attrib['name'] for curve in root.iter('curve')]
    assert len(curves) == 6
    for curve in curves:
        topic = next(topic for topic in recorded if curve.startswith(f'{topic}/'))
        message, fields = recorded[topic], curve.removeprefix(f'{topic}/').split('/')
        if hasattr(message, 'position') and hasattr(message, 'name'):
            joint, field = fields
            fields = [f'{field}[{list(message.name).index(joint)}]']
        assert math.isfinite(number_at(message, fields)), curve


def test_transforms_need_tf2_msgs_and_their_absence_is_said(
    bench: Bench, capfd: pytest.CaptureFixture[str]
) -> None:
    """The wheels on PyPI lack tf2_msgs, a ROS machine has it."""
    node = bench.add(MarkersNode(**overrides(scene='involute_weight_at_sea')))
    words = 'tf2_msgs is not installed here: markers only, no transforms'
    absent = importlib.util.find_spec('tf2_msgs') is None
    assert (TF in node.outputs) == (not absent)
    assert (words in ''.join(capfd.readouterr())) == absent
    assert MARKERS in node.outputs


def test_drawn_at_a_limited_rate_and_only_while_somebody_looks(bench: Bench) -> None:
    rate_hz = 5.0
    node = MarkersNode(**overrides(scene='involute_weight_at_sea', rate=rate_hz))
    sender = bench.add(Node('sender'), node)
    publishers = {topic: publisher_of(sender, topic) for topic in (SHIP_IMU, JOINT_STATES)}
    bench.beats(node, 20)
    assert node.inputs == {}
    drawn: list[tuple[float, MarkerArray]] = []
    viewer = sender.create_subscription(
        MarkerArray, MARKERS, lambda array: drawn.append((time.monotonic(), array)), 10
    )
    bench.until(lambda: len(node.inputs) == 2 and all(i.matched for i in node.inputs.values()))
    stamps = np.array([10**18])
    level = np.zeros(1)
    roll = level + 0.2
    payload = {
        SHIP_IMU: encode(SHIP_IMU, imu_from_roll(stamps, roll, level, level, level + 9.8))[0],
        JOINT_STATES: encode(JOINT_STATES, scalars(stamps, ('wheel',), level[:, None] + 0.7))[0],
    }

    def enough() -> bool:
        for topic, publisher in publishers.items():
            publisher.publish(payload[topic])
        return len(drawn) > 5

    bench.until(enough)
    took_s = drawn[-1][0] - drawn[0][0]
    assert len(drawn) - 1 <= took_s * rate_hz + 1
    markers = {(m.ns, m.id): m for m in drawn[-1][1].markers}
    assert {m.header.frame_id for m in markers.values()} == {'map'}
    attitude = {name: m.pose.orientation.x for (name, _), m in markers.items()}
    assert attitude['ship'] == pytest.approx(math.sin(0.1), abs=1e-12)
    assert attitude['wheel'] == pytest.approx(math.sin(0.45), abs=1e-12)
    assert attitude['thread'] == attitude['case'] == attitude['ship']
    assert {len(m.points) > 1 for m in markers.values()} == {True}
    sender.destroy_subscription(viewer)
    bench.until(lambda: not node.inputs)
