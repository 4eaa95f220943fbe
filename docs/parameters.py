"""Print the page of the nodes' parameters, made from their table: python docs/parameters.py.

`make docs` writes it to docs/parameters.md.
"""

from __future__ import annotations

from collections.abc import Mapping

from tauto_nodes.live.parameters import PARAMETERS, ParameterValue


def _spelled(value: ParameterValue) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return '[' + ', '.join(value) + ']'
    return repr(value) if isinstance(value, float) else (value or '(empty)')


_HEAD = """# Parameters of the nodes

`make docs` makes this page from `tauto_nodes/live/parameters.py`. Unknown names, wrong types and
values out of range stop a node at its start, with the reason. Nodes may share a file: the names
of other nodes are ignored. Write a double with its point: `speed:=2.0`. Also accepted are
`use_sim_time` and, for the topics of the node,
`qos_overrides.<topic>.<publisher|subscription>.<history|depth|reliability>`.
"""

_COLUMNS = ('type', 'default', 'unit', 'allowed', 'at run time', 'meaning')


def reference_page() -> str:
    """Return the page: first what several nodes have alike, then the others of each node."""
    roles: dict[tuple[str, str], list[str]] = {}
    for role, table in PARAMETERS.items():
        for p in table:
            row = (
                f'| {p.type} | `{_spelled(p.default)}` | {p.unit} | {p.allowed} '
                f'| {"no" if p.read_only else "yes"} | {p.description} |'
            )
            roles.setdefault((p.name, row), []).append(role)
    shared = {
        f'`{name}` | {", ".join(nodes)}': row
        for (name, row), nodes in roles.items()
        if len(nodes) > 1
    }
    parts = [_HEAD, '## Of several nodes', *_table(('name', 'nodes'), shared)]
    for role in PARAMETERS:
        rows = {f'`{name}`': row for (name, row), nodes in roles.items() if nodes == [role]}
        parts += [f'\n## {role}', *_table(('name',), rows)]
    return '\n'.join(parts) + '\n'


def _table(first: tuple[str, ...], rows: Mapping[str, str]) -> list[str]:
    if not rows:
        return ['', 'All of its parameters are above.']
    columns = (*first, *_COLUMNS)
    lines = ['', f'| {" | ".join(columns)} |', '|---' * len(columns) + '|']
    return [*lines, *(f'| {head} {row}' for head, row in rows.items())]


if __name__ == '__main__':
    print(reference_page(), end='')
