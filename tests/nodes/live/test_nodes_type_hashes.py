"""The types that a bag declares are the types of the installed ROS."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest
from conftest import Bench, publisher_of
from rclpy.node import Node

from tauto_core.bags import TOPICS
from tauto_core.bags.read import open_mcap
from tauto_core.bags.write import definition_of
from tauto_core.samples import SLACK
from tauto_core.scene import load_scene
from tauto_core.voyage import sail


def test_a_bag_declares_the_type_hashes_that_publishers_offer(
    bench: Bench, tmp_path: Path
) -> None:
    air = {'kind': 'constant', 'celsius': 12.0}
    sail(load_scene('measured', duration=61.0, air=air), tmp_path / 'bag')
    declared = {
        channel.topic: channel.metadata['topic_type_hash']
        for channel in open_mcap(tmp_path / 'bag/bag_0.mcap').channels.values()
    }
    # no thread of this scene goes slack, and a bag declares only recorded topics
    assert set(declared) == {f'/{topic}' for topic in TOPICS if topic != SLACK}
    sender, onlooker = bench.add(Node('sender')), bench.add(Node('onlooker'))
    for topic in TOPICS:
        publisher_of(sender, topic)
    for topic, found in declared.items():
        bench.until(lambda topic=topic: onlooker.get_publishers_info_by_topic(topic))
        (info,) = onlooker.get_publishers_info_by_topic(topic)
        assert found == str(info.topic_type_hash)


def fields_of(text: str, package: str) -> set[str]:
    """Return the fields of a definition, with their defaults, and its constants.

    A type of the same package may have its name in front.
    """
    said = (line.partition('#')[0].split() for line in text.splitlines())
    lines = (' '.join(words).replace(' = ', '=') for words in said if words)
    return {line.removeprefix(f'{package}/') for line in lines}


@pytest.mark.parametrize(
    'ros_type',
    sorted({each.ros_type for each in TOPICS.values()} | {'diagnostic_msgs/msg/DiagnosticArray'}),
)
def test_a_bag_declares_definitions_with_their_defaults(ros_type: str) -> None:
    """Each definition, and those that it is made of, as the installed packages have them."""
    text = definition_of(ros_type)[0]
    first, *others = re.split(r'={80}\nMSG: (\S+)\n', text)
    parts = {
        ros_type.replace('/msg/', '/'): first,
        **dict(zip(others[::2], others[1::2], strict=True)),
    }
    for name, part in parts.items():
        package, _, message = name.partition('/')
        file = Path('share') / package / 'msg' / f'{message}.msg'
        above = Path(str(import_module(package).__file__)).parents
        installed = next(place / file for place in above if (place / file).exists())
        assert fields_of(part, package) == fields_of(installed.read_text(), package), name
