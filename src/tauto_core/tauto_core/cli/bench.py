"""`tauto bench`: run time against error, beside other programs on the same equations."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tauto_core.cli.options import AsJson, Plots

if TYPE_CHECKING:
    from rich.table import Table

    from tauto_core.bench.ratios import Target


def bench(
    problem: Annotated[
        str | None, typer.Option(metavar='A,B,…', help='Problems, of a to f; default: all.')
    ] = None,
    peers: Annotated[
        str | None,
        typer.Option(metavar='NAME,…', help='Programs; default: all that are installed.'),
    ] = None,
    quick: Annotated[
        bool, typer.Option('--quick', help='Few settings and short runs: to see that all works.')
    ] = False,
    budget: Annotated[
        float | None,
        typer.Option(min=0.1, metavar='S', help='Time allowed a run [s]; default: 20.'),
    ] = None,
    first: Annotated[
        bool, typer.Option('--first', help='Also the first run of each program, all cold.')
    ] = False,
    passage: Annotated[
        bool,
        typer.Option('--passage', help='Also an 81-day passage all in, and two runs at once.'),
    ] = False,
    plot: Plots = None,
    as_json: AsJson = False,
) -> None:
    """Measure run time against error, beside other programs on the same equations.

    Programs that are not installed are named and left out; the extra `bench` of tauto_core
    installs them. Without --quick or a small
    --budget it takes an hour or so on a quiet machine.
    """
    from tauto_core import bench as core

    for path in plot or ():
        core.check_plot(path)
    result = core.bench(
        _names(problem), _names(peers), quick=quick, budget_s=budget, cold=first, say=_say
    )
    if passage:
        _say('passage')
        result['passage'] = core.passage()
        _say('two at once')
        result['two_at_once'] = core.two_at_once()
    for path in plot or ():
        core.draw(result, path)
    if as_json:
        typer.echo(json.dumps(result, allow_nan=False, indent=1))
    else:
        _print(result)


def _names(text: str | None) -> list[str] | None:
    return None if text is None else [name.strip().lower() for name in text.split(',')]


def _say(words: str) -> None:
    typer.echo(f'tauto: {words}', err=True)


def _print(result: Mapping[str, Any]) -> None:
    from rich.console import Console

    from tauto_core.bench import problems

    console = Console()
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
    from rich.table import Table

    from tauto_core.bench import FAMILIES, ratio, targets

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
        table.add_column(name)
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
    return '–' if number is None else f'{number:,.3g}×'
