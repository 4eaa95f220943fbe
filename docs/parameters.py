"""Write docs/parameters.md, the reference of the nodes' parameters, from their table.

.venv/bin/python docs/parameters.py
"""

from pathlib import Path

from tauto_nodes.live.parameters import PARAMETERS, ParameterValue


def _spelled(value: ParameterValue) -> str:
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
        'Generated from `tauto_nodes/live/parameters.py`; a test keeps the two equal.',
        'Unknown names, wrong types and values out of range stop a node at its start, with the',
        'reason. Nodes share the section `/**` of a parameter file: it may hold names of other',
        'nodes, and a name that no node has causes a warning. Write a double with its point:',
        '`speed:=2.0`. Also accepted are `use_sim_time` and, for the topics of the node,',
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


if __name__ == '__main__':
    Path(__file__).with_suffix('.md').write_text(reference_page(), 'utf-8')
