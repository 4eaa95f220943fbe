"""The house stays one that a person can hold in mind: a table of its size, held as limits.

Neither long lines nor missing docstrings help. Statements are counted in the syntax tree: two on
one line are two, and a docstring is none. A line counts once for each WIDTH characters that it
begins. A floor holds the share of definitions that have a docstring; types are held by mypy.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from test_house_layers import circles, graph, modules

ROOT = Path(__file__).parents[1]
WIDTH = 99

LIMITS = {
    # figure: (most today, goal)
    'statements of src': (33_410, 33_500),
    'lines of src': (71_000, 71_000),
    'files of src': (180, 190),
    'lines of tests': (43_290, 42_000),
    'lines of benchmarks': (6_890, 7_000),
    'circles of imports': (0, 0),
}
"""A limit is lowered when a figure has fallen, and not raised: whoever adds takes away as much."""
DOCUMENTED_PERCENT = 93.0


def statements(source: str) -> int:
    """Return the number of statements of a source, without docstrings."""
    return sum(
        isinstance(node, ast.stmt)
        and not (
            isinstance(node, ast.Expr)
            and isinstance(node.value, ast.Constant)
            and isinstance(node.value.value, str)
        )
        for node in ast.walk(ast.parse(source))
    )


def lines(source: str) -> int:
    """Return the number of lines of a source; a long line counts as often as it should wrap."""
    return sum(max(1, -(-len(line) // WIDTH)) for line in source.splitlines())


def documented(source: str) -> list[bool]:
    """Return for each class and function with a public name whether it has a docstring."""
    return [
        ast.get_docstring(node) is not None
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith('_')
    ]


def test_neither_a_long_line_nor_a_docstring_changes_the_count() -> None:
    assert statements('def f():\n    """Return 1."""\n    x = 1; return x') == 3
    assert statements('def f():\n    x = 1\n    return x') == 3
    assert lines('a\n\n' + 'b' * WIDTH) == 3
    assert lines('b' * (WIDTH + 1)) == 2
    assert documented('def f():\n    """Return 1."""\nclass A:\n    def g(self): ...') == [
        True,
        False,
        False,
    ]


@pytest.fixture(scope='module')
def sources() -> dict[str, list[str]]:
    return {
        room: [each.read_text('utf-8') for each in sorted((ROOT / room).rglob('*.py'))]
        for room in ('src', 'tests', 'benchmarks')
    }


@pytest.mark.parametrize('figure', LIMITS)
def test_the_house_is_no_larger_than_its_table(sources: dict[str, list[str]], figure: str) -> None:
    counted, _, room = figure.partition(' of ')
    found = {
        'statements': lambda: sum(map(statements, sources[room])),
        'lines': lambda: sum(map(lines, sources[room])),
        'files': lambda: len(sources[room]),
        'circles': lambda: len(
            circles(graph({name: file.read_text('utf-8') for name, file in modules().items()}))
        ),
    }[counted]()
    most, goal = LIMITS[figure]
    assert found <= most, f'{found} {figure}: at most {most} today, {goal} is the goal'


def test_definitions_keep_their_docstrings(sources: dict[str, list[str]]) -> None:
    found = [each for source in sources['src'] for each in documented(source)]
    assert 100.0 * sum(found) / len(found) >= DOCUMENTED_PERCENT
