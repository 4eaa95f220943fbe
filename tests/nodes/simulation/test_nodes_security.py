"""The policy for SROS 2 allows all that the nodes do, and no more."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from conftest import Bench, overrides
from rclpy.node import Node
from rclpy.qos import QoSProfile
from visualization_msgs.msg import MarkerArray

from tauto_core.bags import TOPICS
from tauto_core.samples import SHIP_IMU, SHIP_TEMPERATURE
from tauto_core.scene import load_scene
from tauto_core.voyage import sail
from tauto_nodes.live.markers import MarkersNode
from tauto_nodes.live.player import PlayerNode
from tauto_nodes.live.recorder import RecorderNode
from tauto_nodes.live.stages import DriftEstimatorNode, LongitudeNode, TrochleaNode
from tauto_nodes.simulation.credits import PACK_TOPIC
from tauto_nodes.simulation.ship import ShipMotionNode
from tauto_nodes.simulation.supervisor import NODE_NAMES

POLICY = Path(__file__).parents[3] / 'src/tauto_nodes/config/sros2_policy.xml'
CREDITS: dict[str, Any] = {'flow_control': 'credits', 'packed': True, 'graph': NODE_NAMES}

Ports = dict[tuple[str, str], set[str]]

AIR, MOTION = ((f'/{topic}', f'/{PACK_TOPIC}{topic}') for topic in (SHIP_TEMPERATURE, SHIP_IMU))
OPTIONAL: Ports = defaultdict(
    set,
    {
        # with publish_clock
        ('ship_motion', 'publish'): {'/clock'},
        # with air, and with tf2_ros for the mounting of a sensor
        ('trochlea', 'subscribe'): {*AIR, '/tf_static'},
        # with a live sensor, if published
        ('recorder', 'subscribe'): {'/diagnostics', '/tf_static'},
        # with drift.covariates, and tf2_ros
        ('drift_estimator', 'subscribe'): {*AIR, *MOTION, '/tf_static'},
        # if tf2_msgs is installed
        ('markers', 'publish'): {'/tf', '/tf_static'},
        ('markers', 'subscribe'): {'/tf', '/tf_static'},
        # what the bag has
        ('player', 'publish'): {'/clock', *(f'/{topic}' for topic in TOPICS)},
    },
)
"""Topics of a node in some configurations only. On /clock all of them listen to sim time."""


def allowed() -> Ports:
    """Return the permissions of the policy by node and way, as full names in the root."""
    found: Ports = defaultdict(set)
    for enclave in ElementTree.parse(POLICY).getroot().iter('enclave'):
        for profile in enclave.iter('profile'):
            node = profile.get('node', '')
            assert enclave.get('path') == f'/tauto/{node}'
            assert profile.get('ns') == '/'
            for rules in profile:
                (way,) = rules.keys()
                assert rules.get(way) == 'ALLOW'
                for rule in rules:
                    name = (rule.text or '').replace('~', f'/{node}')
                    found[node, way].add(name if name.startswith('/') else f'/{name}')
    return found


def add_ports(found: Ports, name: str, onlooker: Node) -> None:
    """Add the topics of a node of the graph, as other nodes see them."""
    asked = {
        'publish': onlooker.get_publisher_names_and_types_by_node,
        'subscribe': onlooker.get_subscriber_names_and_types_by_node,
        'reply': onlooker.get_service_names_and_types_by_node,
        'request': onlooker.get_client_names_and_types_by_node,
    }
    for way, names in asked.items():
        found[name, way] |= {full for full, _ in names(name, '/')}


@pytest.fixture
def seen(bench: Bench, tmp_path: Path) -> Ports:
    """Return the topics of all nodes, with packs and without flow control."""
    sail(load_scene('measured', duration=1.0), tmp_path / 'sailed')
    found: Ports = defaultdict(set)
    onlooker = bench.add(Node('onlooker'))
    onlooker.create_subscription(MarkerArray, 'markers', lambda _: None, QoSProfile(depth=1))
    for flow in ({}, CREDITS):
        nodes: list[Any] = [
            *(
                node(**overrides(scene='measured', **flow))
                for node in (ShipMotionNode, TrochleaNode, DriftEstimatorNode, LongitudeNode)
            ),
            RecorderNode(**overrides(output=str(tmp_path / f'recorded{len(flow)}'), **flow)),
        ]
        if not flow:
            player = PlayerNode(**overrides(bag=str(tmp_path / 'sailed'), topics=['scene']))
            nodes += [player, MarkersNode(**overrides(scene='measured'))]
        bench.add(*nodes)
        bench.until(lambda nodes=nodes: all(node.diagnostics for node in nodes))
        if not flow:
            bench.until(lambda node=nodes[-1]: len(node.inputs) == 2)
        for node in nodes:
            add_ports(found, node.get_name(), onlooker)
        for node in nodes:
            node.close()
            bench.remove(node)
    return found


def test_the_policy_allows_what_the_nodes_do_and_no_more(seen: Ports) -> None:
    policy = allowed()
    for way in ('publish', 'subscribe', 'reply', 'request'):
        for node in (*NODE_NAMES, 'player', 'markers'):
            sim_time = {'/clock'} if way == 'subscribe' else set()
            most = seen[node, way] | OPTIONAL[node, way] | sim_time
            assert policy[node, way] >= seen[node, way], (node, way)
            assert policy[node, way] <= most, (node, way)
