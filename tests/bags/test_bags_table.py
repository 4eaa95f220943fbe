"""The topic table against the samples, the message definitions, and the committed reference."""

from dataclasses import fields
from pathlib import Path

import pytest
import yaml
from bags_examples import STORE
from modules import module_of
from rosbags.interfaces import Nodetype
from rosbags.rosbag2.metadata import dump_qos_v9, parse_qos

from tauto_core import samples as s
from tauto_core.bags import TOPICS, Topic, offered_qos
from tauto_core.bags.table import MESSAGE_TYPES, MessageType

ROOT = Path(__file__).parents[2]
EACH_TYPE = pytest.mark.parametrize('message', MESSAGE_TYPES.values(), ids=MESSAGE_TYPES)


def test_every_topic_of_the_samples_is_in_the_table() -> None:
    named = {value for name, value in vars(s).items() if name.isupper() and isinstance(value, str)}
    assert set(TOPICS) == named


@EACH_TYPE
def test_every_sample_field_is_in_a_message(message: MessageType) -> None:
    sample_fields = {field.name for field in fields(message.samples)}
    stamp = set() if message.stamped else {'stamp_ns'}
    assert {field.sample for field in message.fields} == sample_fields - stamp


@EACH_TYPE
def test_fields_are_those_of_the_definition_in_its_order(message: MessageType) -> None:
    """Primitives of our table and of the definition, both flattened, are the same list."""
    ours = []
    for field in message.fields:
        if field.kind == 'time':
            ours += [(f'{field.message}.sec', 'int32'), (f'{field.message}.nanosec', 'uint32')]
        else:
            ours.append((field.message, f'{field.length} {field.kind}'))
    merged: list[tuple[str, str]] = []
    for path, kind in flatten(message.name):
        parent, _, axis = path.rpartition('.')
        if axis in {'x', 'y', 'z', 'w'}:
            length = int(merged.pop()[1].split()[0]) + 1 if axis != 'x' else 1
            merged.append((parent, f'{length} {kind}'))
        else:
            merged.append(
                (path, kind if kind in {'int32', 'uint32'} or ' ' in kind else f'1 {kind}')
            )
    assert ours == merged


def flatten(name: str, path: str = '') -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    for field, (node, detail) in STORE.fielddefs[name][1]:
        here = f'{path}{field}'
        if node == Nodetype.NAME:
            found += flatten(detail, f'{here}.')
        elif node == Nodetype.BASE:
            found.append((here, detail[0]))
        elif node == Nodetype.ARRAY:
            found.append((here, f'{detail[1]} {detail[0][1][0]}'))
        else:
            found.append((here, f'1 {detail[0][1][0]}[]'))
    return found


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
