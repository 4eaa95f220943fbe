"""The topic table against the samples, the message definitions, and the committed reference."""

from pathlib import Path

import pytest
import yaml
from modules import module_of
from rosbags.rosbag2.metadata import dump_qos_v9, parse_qos

from tauto_core import samples as s
from tauto_core.bags import TOPICS, Topic, offered_qos

ROOT = Path(__file__).parents[2]


def test_every_topic_of_the_samples_is_in_the_table() -> None:
    named = {value for name, value in vars(s).items() if name.isupper() and isinstance(value, str)}
    assert set(TOPICS) == named


@pytest.mark.parametrize('topic', TOPICS.values(), ids=TOPICS)
def test_offered_qos_is_what_rosbag2_spells(topic: Topic) -> None:
    profiles = offered_qos(topic.depth, latched=topic.latched)
    assert dump_qos_v9(parse_qos(yaml.safe_dump(profiles))) == profiles


def test_only_the_scene_is_latched() -> None:
    assert [topic.name for topic in TOPICS.values() if topic.latched] == [s.SCENE]
    durability = [offered_qos(1, latched=latched)[0]['durability'] for latched in (True, False)]
    assert durability == ['transient_local', 'volatile']


def test_the_page_of_topics_has_each_topic_and_its_message() -> None:
    made = module_of(ROOT / 'docs/topics.py').topic_reference()
    for topic in TOPICS.values():
        row = next(line for line in made.splitlines() if line.startswith(f'| `{topic.name}` |'))
        assert f'| {topic.depth} |' in row
        assert topic.meaning in row
        assert made.count(f'\n### {topic.message.name}: ') == 1
