"""Markers: the clock rolls with the ship, at a limited rate, and only while somebody looks."""

from __future__ import annotations

import json
import math
import re
import time
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Bench, overrides
from rclpy.node import Node
from visualization_msgs.msg import MarkerArray

from tauto_core.bags import TOPICS, encode
from tauto_core.navigation import ESTIMATE_NAMES
from tauto_core.navigation.longitude import ERROR_NAMES
from tauto_core.samples import JOINT_STATES, SHIP_IMU, scalars
from tauto_core.ship.imu import imu_from_roll
from tauto_nodes.markers import MARKERS, Markers, about_x, clock_points, product, transforms
from tauto_nodes.qos import port

LAYOUTS = Path(__file__).parents[2] / 'src' / 'tauto_nodes' / 'layouts'


def turned(rotation: tuple[float, ...], vector: tuple[float, ...]) -> np.ndarray[Any, Any]:
    """Rotate a vector, by the formula v + 2 w (u × v) + 2 u × (u × v)."""
    u, w = np.array(rotation[:3]), rotation[3]
    once = np.cross(u, vector)
    return np.array(vector) + 2 * w * once + 2 * np.cross(u, once)


def test_a_roll_to_starboard_lowers_the_starboard_side() -> None:
    # REP-103: x forward, y to port; a positive turn about x lifts y, the port side.
    np.testing.assert_allclose(turned(about_x(math.pi / 2), (0, 1, 0)), (0, 0, 1), atol=1e-15)


@pytest.mark.parametrize(('first', 'second'), [(0.3, 0.7), (-1.2, 2.5)])
def test_turns_about_one_axis_add_up(first: float, second: float) -> None:
    np.testing.assert_allclose(
        product(about_x(first), about_x(second)), about_x(first + second), atol=1e-15
    )


def test_a_product_turns_by_the_second_within_the_first() -> None:
    yaw = (0.0, 0.0, math.sin(0.4), math.cos(0.4))
    both = product(yaw, about_x(0.9))
    vector = (0.2, -0.5, 0.8)
    within = turned(about_x(0.9), vector)
    np.testing.assert_allclose(turned(both, vector), turned(yaw, tuple(within)), atol=1e-15)


def test_the_frames_are_those_of_rep_105() -> None:
    chain = transforms(about_x(0.1), about_x(0.7))
    names = [(one.header.frame_id, one.child_frame_id) for one in chain]
    assert names == [('map', 'base_link'), ('base_link', 'clock_mount'), ('clock_mount', 'wheel')]
    assert chain[2].transform.rotation.x == math.sin(0.35)


def test_the_drawing_is_seen_from_astern() -> None:
    from tauto_core.chart import Line

    line = Line('', np.array([10.0]), np.array([20.0]))
    np.testing.assert_allclose(clock_points(line, 1.0), [[0.0, -0.010, 0.020]])


def test_layouts_show_what_there_is() -> None:
    foxglove = json.loads((LAYOUTS / 'foxglove.json').read_text())
    panels = foxglove['configById']
    paths = [p['value'] for panel in panels.values() for p in panel.get('paths', ())]
    assert {path.split('.')[0].strip('/') for path in paths} <= TOPICS.keys()
    assert list(panels['3D!clock']['topics']) == ['/markers']
    shown = re.findall(r'"(\w+!\w+)"', json.dumps(foxglove['layout']))
    assert sorted(shown) == sorted(panels)
    curves = ET.parse(LAYOUTS / 'plotjuggler.xml').getroot().iter('curve')
    names = [curve.attrib['name'].strip('/') for curve in curves]
    scalars_of = {'drift/estimate': ESTIMATE_NAMES, 'longitude/error': ERROR_NAMES}
    for name in names:
        topic = next(topic for topic in TOPICS if name.startswith(f'{topic}/'))
        field = name.removeprefix(f'{topic}/').split('/')[0]
        assert field in scalars_of.get(topic, (field,))


def test_drawn_at_a_limited_rate_and_only_while_somebody_looks(bench: Bench) -> None:
    rate_hz = 5.0
    node = Markers(**overrides(scene='involute_weight_at_sea', rate=rate_hz))
    sender = bench.add(Node('sender'), node)
    publishers = {
        topic: sender.create_publisher(port(topic).message, topic, port(topic).profile)
        for topic in (SHIP_IMU, JOINT_STATES)
    }
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
