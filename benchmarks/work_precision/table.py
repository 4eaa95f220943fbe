"""The result in the terminal: a table a problem."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.work_precision.problems import problems
from benchmarks.work_precision.ratios import FAMILIES, Target, ratio, targets

WIDTH = 124
"""Columns that a table takes; narrower terminals wrap its lines."""


def show(result: Mapping[str, Any]) -> None:
    """Print a result."""
    console = Console()
    if console.width < WIDTH:
        console = Console(width=WIDTH)
    for problem in problems():
        if any(row['problem'] == problem.key for row in result['rows']):
            console.print(problem_table(problem.key, problem.title, result))
    for name, keys in result['not_offered'].items():
        console.print(f'{name} cannot express problem {", ".join(keys)}')
    for failed in result['failed']:
        console.print('{problem}: {program} {setting}: {why}'.format(**failed))
    if 'passage' in result:
        console.print(
            '81 days of problem c all in: {us_per_oscillation:.3g} µs a swing '
            '(needed: at most {needed_us:g})'.format(**result['passage'])
        )
        console.print(
            'two runs at once take {ratio:.3g} times as long as one (needed: at most '
            '{needed_ratio:g}), in two processes {processes_ratio:.3g}'.format(
                **result['two_at_once']
            )
        )


def problem_table(key: str, title: str, result: Mapping[str, Any]) -> Table:
    """Return the table of a problem; Tauto's rows say how many times slower others are.

    Args:
        key: of the problem.
        title: of the problem.
        result: what `bench` returns.
    """
    rows, target = result['rows'], targets()[key]
    first = {
        (each['problem'], each['program']): each['first_run_s'] for each in result['first_runs']
    }
    table = Table(
        title=f'{key}: {title}',
        title_justify='left',
        caption=_caption(target, on_land=key in 'ab'),
        caption_justify='left',
    )
    for name in ('program', 'setting'):
        table.add_column(name, no_wrap=True)
    for name in ('run of', 's/day', 'µs/swing', 'set-up s', 'first run s', *FAMILIES):
        table.add_column(name, justify='right', no_wrap=True)
    for row in (row for row in rows if row['problem'] == key):
        ours = row['program'] == 'tauto'
        ratios = [
            times(ratio(row, rows, family, target.error_s_per_day)) if ours else ''
            for family in FAMILIES.values()
        ]
        seconds = first.get((key, row['program']))
        table.add_row(
            row['program'],
            row['setting'],
            _span(row['duration_s']),
            f'{row["error_s_per_day"]:.1e}',
            f'{row["us_per_oscillation"]:.3g}',
            f'{row["setup_s"]:.2g}',
            '' if seconds is None else f'{seconds:.2g}',
            *ratios,
            style='bold' if ours else None,
        )
    return table


def _caption(target: Target, *, on_land: bool) -> str:
    """Return what the ratios of a table mean, and which are needed."""
    needed = f'{target.faster:,g}× heyoka' + (', set-up included' if on_land else '')
    return (
        'times slower than Tauto, by the best setting of the best formulation, at '
        f"{target.error_s_per_day:.2g} s/day or Tauto's error, where larger; –: never so "
        f'accurate. Needed: {needed}'
    )


def _span(seconds: float) -> str:
    for size, unit in ((86_400.0, 'd'), (3_600.0, 'h'), (60.0, 'min')):
        if seconds >= size:
            return f'{seconds / size:g} {unit}'
    return f'{seconds:g} s'


def times(number: float | None) -> str:
    """Return a ratio in words for a table."""
    if number is None:
        return '–'
    return f'{number:.3g}×' if number < 1000.0 else f'{float(f"{number:.3g}"):,.0f}×'
