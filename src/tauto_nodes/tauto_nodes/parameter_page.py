"""docs/parameters.md, from the table."""

from __future__ import annotations

from tauto_nodes.parameters import PARAMETERS, Value


def _spelled(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return '[' + ', '.join(value) + ']'
    return repr(value) if isinstance(value, float) else (value or '(empty)')


def reference_page() -> str:
    """Return docs/parameters.md."""
    lines = [
        '# Parameters of the nodes',
        '',
        'Generated from `tauto_nodes/parameters.py`; a test keeps the two equal.',
        'Unknown names, wrong types and values out of range stop a node at its start, with the',
        'reason. Only in the section `/**` of a parameter file, which nodes share, may a name be',
        "another node's; one that no node has is a warning there. Doubles need their point:",
        '`speed:=2.0`. Besides these, `use_sim_time` is known, and of topics that the node has',
        '`qos_overrides.<topic>.<publisher|subscription>.<history|depth|reliability>`.',
    ]
    for role, table in PARAMETERS.items():
        lines += [
            '',
            f'## {role}',
            '',
            '| name | type | default | unit | allowed | at run time | meaning |',
            '|---|---|---|---|---|---|---|',
        ]
        lines += [
            f'| `{p.name}` | {p.type} | `{_spelled(p.default)}` | {p.unit} | {p.allowed} '
            f'| {"no" if p.read_only else "yes"} | {p.description} |'
            for p in table
        ]
    return '\n'.join(lines) + '\n'
