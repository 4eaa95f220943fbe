"""YAML 1.2 scalars, reading and writing: `1e-4` is a number, `yes` and `12:30` are strings.

PyYAML has the older rules of 1.1; its scanner is used here with the scalar rules of the YAML 1.2
core schema (section 10.3.2). Duplicate keys, keys that are not strings, anchors and unknown tags
are refused, since a scene needs none of them and each hides a mistake.
"""

from __future__ import annotations

import re
from typing import Any

import yaml

from tauto_core.scene.errors import SceneError

_TAG = 'tag:yaml.org,2002:'
_INTEGER = re.compile(r'[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+')
_SCALARS: tuple[tuple[str, re.Pattern[str], str], ...] = (
    ('null', re.compile(r'~|null|Null|NULL|'), '~nN'),
    ('bool', re.compile(r'true|True|TRUE|false|False|FALSE'), 'tTfF'),
    ('int', _INTEGER, '-+0123456789'),
    (
        'float',
        re.compile(
            r'[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?'
            r'|[-+]?\.(?:inf|Inf|INF)|\.nan|\.NaN|\.NAN'
        ),
        '-+.0123456789',
    ),
)
# Longer than any number in use, shorter than those that Python refuses to convert.
_LONGEST_NUMBER = 400
_DEEPEST = 20


def _resolvers() -> dict[str, list[tuple[str, re.Pattern[str]]]]:
    table: dict[str, list[tuple[str, re.Pattern[str]]]] = {'': [(f'{_TAG}null', _SCALARS[0][1])]}
    for name, pattern, first_characters in _SCALARS:
        whole = re.compile(f'(?:{pattern.pattern})$')
        for character in first_characters:
            table.setdefault(character, []).append((_TAG + name, whole))
    return table


class _Loader(yaml.SafeLoader):
    """PyYAML's scanner with the scalars of YAML 1.2.

    It refuses anchors, and nesting so deep that it would cost much time and stack to read.
    """

    yaml_implicit_resolvers = _resolvers()
    depth = 0

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Return the next node, with all nodes below it."""
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]
        if isinstance(event, yaml.AliasEvent) or event.anchor:
            raise _RefusedError(event, 'anchors and aliases are not read', 'Write the value out.')
        if isinstance(event, yaml.CollectionStartEvent) and self.depth == _DEEPEST:
            problem = f'is nested more than {_DEEPEST} deep'
            raise _RefusedError(event, problem, 'A scene is at most five levels deep.')
        self.depth += 1
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node


class _Dumper(yaml.SafeDumper):
    """Quotes strings that either YAML 1.1 or 1.2 would read as something else."""


for _character, _patterns in _resolvers().items():
    for _tag, _pattern in _patterns:
        _Dumper.add_implicit_resolver(_tag, _pattern, [_character])


class _RefusedError(Exception):
    """A node or an event of the YAML that cannot be read."""

    def __init__(self, at: yaml.Node | yaml.Event, problem: str, remedy: str) -> None:
        mark: yaml.Mark = at.start_mark  # type: ignore[assignment]  # the scanner sets it always
        self.problem = f'line {mark.line + 1}, column {mark.column + 1}: {problem}'
        self.remedy = remedy
        super().__init__(self.problem)


def read_mapping(text: str, origin: str) -> dict[str, Any]:
    """Return the mapping in a YAML text.

    Args:
        text: one YAML document.
        origin: the file's name, for errors.

    Raises:
        SceneError: syntax (with line and column), not a mapping, duplicate or non-string keys.
    """
    try:
        node = yaml.compose(text, Loader=_Loader)
        content = None if node is None else _value(node)
    except _RefusedError as error:
        raise SceneError(origin, '', text, error.problem, error.remedy) from None
    except yaml.YAMLError as error:
        problem, remedy = _syntax(error), 'Correct the YAML there.'
        raise SceneError(origin, '', text, problem, remedy) from None
    if not isinstance(content, dict):
        found = 'nothing' if content is None else f'a {_kind(content)}'
        problem = f'holds {found}, but a scene is a mapping of keys to values'
        raise SceneError(origin, '', content, problem, 'Begin with `name: …` and `duration: …`.')
    return content


def write_mapping(content: dict[str, Any]) -> str:
    """Return a mapping of plain values as YAML that `read_mapping` reads back unchanged."""
    text: str = yaml.dump(content, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=99)
    return text


def _value(node: yaml.Node) -> Any:
    if isinstance(node, yaml.MappingNode) and node.tag == f'{_TAG}map':
        return _mapping(node)
    if isinstance(node, yaml.SequenceNode) and node.tag == f'{_TAG}seq':
        return [_value(item) for item in node.value]
    if isinstance(node, yaml.ScalarNode):
        return _scalar(node)
    raise _RefusedError(node, f'the tag {node.tag} is not read', 'Leave the tag out.')


def _mapping(node: yaml.MappingNode) -> dict[str, Any]:
    content: dict[str, Any] = {}
    key = ''
    for key_node, value_node in node.value:
        if key_node.tag != f'{_TAG}str' or not isinstance(key_node, yaml.ScalarNode):
            before = content.get(key, '') if content else ''
            raise _RefusedError(key_node, 'a key must be a word', _word_for(key_node, before))
        key = key_node.value
        if key in content:
            raise _RefusedError(key_node, f'the key {key!r} comes twice', 'Keep one of them.')
        content[key] = _value(value_node)
    return content


def _word_for(key: yaml.Node, before: object) -> str:
    """Return the remedy for a key that is no string, such as 322 in `{mass: 0,322}`."""
    if key.tag == f'{_TAG}int' and isinstance(before, int) and not isinstance(before, bool):
        return f'Write {before}.{key.value} with a decimal point if {before},{key.value} is meant.'
    return 'Use the names of the scene reference.'


def _scalar(node: yaml.ScalarNode) -> str | int | float | bool | None:
    text: str = node.value
    kind = node.tag.removeprefix(_TAG)
    if kind == 'str':
        return text
    pattern = next((pattern for name, pattern, _ in _SCALARS if name == kind), None)
    if pattern is None:
        raise _RefusedError(node, f'the tag {node.tag} is not read', 'Leave the tag out.')
    if not pattern.fullmatch(text) or len(text) > _LONGEST_NUMBER:
        problem = f'{text[:40]!r} cannot be read as {kind}'
        raise _RefusedError(node, problem, 'Write a plain value.')
    if kind == 'null':
        return None
    if kind == 'bool':
        return text.lower() == 'true'
    return _integer(text) if kind == 'int' else _float(text)


def _integer(text: str) -> int:
    # In base 0 Python refuses a leading zero; YAML 1.2 reads it as decimal.
    return int(text, {'0o': 8, '0x': 16}.get(text[:2], 10))


def _float(text: str) -> float:
    return float(re.sub(r'^([-+]?)\.(inf|nan)$', r'\1\2', text.lower()))


def _syntax(error: yaml.YAMLError) -> str:
    mark = getattr(error, 'problem_mark', None)
    what = getattr(error, 'problem', None) or getattr(error, 'reason', None) or 'not YAML'
    context = getattr(error, 'context', None)
    said = f'{context}, {what}' if context else what
    if mark is None:
        return f'YAML syntax: {said}'
    return f'YAML syntax, line {mark.line + 1}, column {mark.column + 1}: {said}'


def _kind(content: object) -> str:
    names = {list: 'list', str: 'text', bool: 'truth value', int: 'number', float: 'number'}
    return names[type(content)]
