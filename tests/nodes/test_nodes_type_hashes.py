"""The types that a bag declares are those of the ROS that is installed here."""

from __future__ import annotations

from pathlib import Path

from conftest import Bench
from rclpy.node import Node

from tauto_core.bags import TOPICS
from tauto_core.bags.read import open_mcap
from tauto_core.samples import SLACK
from tauto_core.scene import load_scene
from tauto_core.voyage import sail
from tauto_nodes.ports import port


def test_a_bag_declares_the_type_hashes_that_publishers_offer(
    bench: Bench, tmp_path: Path
) -> None:
    air = {'kind': 'route', 'celsius': 12.0}
    sail(load_scene('measured', duration=61.0, air=air), tmp_path / 'bag')
    declared = {
        channel.topic: channel.metadata['topic_type_hash']
        for channel in open_mcap(tmp_path / 'bag/bag_0.mcap').channels.values()
    }
    # no thread of this scene goes slack, and a bag declares what it holds
    assert set(declared) == {f'/{topic}' for topic in TOPICS if topic != SLACK}
    sender, onlooker = bench.add(Node('sender')), bench.add(Node('onlooker'))
    for topic in TOPICS:
        sender.create_publisher(port(topic).message, topic, port(topic).profile)
    for topic, found in declared.items():
        bench.until(lambda topic=topic: onlooker.get_publishers_info_by_topic(topic))
        (info,) = onlooker.get_publishers_info_by_topic(topic)
        assert found == str(info.topic_type_hash)
