"""The table of docs/speed.md, made from a result, so that it states what was measured."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks.work_precision.problems import WheelProblem, problems
from benchmarks.work_precision.ratios import (
    FAMILIES,
    FINE_S_PER_DAY,
    NAVIGATORS_S_PER_DAY,
    BenchRow,
    best,
    best_ratio,
    cheapest,
    ratio,
    targets,
)
from tauto_core.scene.errors import UsageError

BEGIN = '<!-- made by python -m benchmarks.work_precision --page -->'
END = '<!-- end of what was made -->'

_HEAD = (
    '| problem | error of Tauto, s/day | µs a swing | heyoka at its best takes | plain heyoka '
    '| heyoka, a ship of eight at once | DOP853 at its best | first run, s: Tauto, heyoka |'
)


def block(result: Mapping[str, Any]) -> str:
    """Return the lines between the marks: a row a problem, and what the whole took."""
    lines = [_HEAD, '|---|---|---|---|---|---|---|---|']
    for problem in problems():
        row = best(result['rows'], problem.key)
        if row is not None:
            lines.append(_line(problem.title, row, result))
    machine = result['machine']
    lines += ['', *_by_error(result['rows'])]
    lines += [
        '',
        textwrap.fill(
            f'One core of {machine["processor"]}, Python {machine["python"]}, {machine["date"]}. '
            + _extras(result),
            width=120,  # that of all pages: tests/lint_prose.py
            break_long_words=False,
            break_on_hyphens=False,
        ),
    ]
    return '\n'.join(lines).rstrip()


def _by_error(rows: list[BenchRow]) -> list[str]:
    """Return the table of the problems at sea at two errors: single ships, and one of eight."""
    found = [
        '| problem | error of at most, s/day | Tauto, µs a swing | heyoka at its best takes '
        '| heyoka, a ship of eight at once |',
        '|---|---|---|---|---|',
    ]
    for problem in problems():
        if not isinstance(problem, WheelProblem) or problem.numbers.sea is None:
            continue
        for bound in (FINE_S_PER_DAY, NAVIGATORS_S_PER_DAY):
            row = cheapest(rows, problem.key, ['tauto'], bound)
            if row is None:
                continue
            others = (FAMILIES['heyoka'], FAMILIES['heyoka, 8 ships'])
            ratios = [ratio(row, rows, names, bound) for names in others]
            cells = [
                problem.key,
                f'{bound:.0e}'.replace('e-0', 'e-'),
                f'{row["us_per_oscillation"]:.2g} ({row["setting"]})',
                *map(_times, ratios),
            ]
            found.append(f'| {" | ".join(cells)} |')
    return found


def _line(title: str, row: BenchRow, result: Mapping[str, Any]) -> str:
    key, rows = row['problem'], result['rows']
    plain = ratio(row, rows, FAMILIES['heyoka'][:1], targets()[key])
    heyoka, batch, dop853 = (best_ratio(rows, key, names) for names in FAMILIES.values())
    cells = [
        f'{key}, {title} ({row["setting"]})',
        f'{row["error_s_per_day"]:.1g}',
        f'{row["us_per_oscillation"]:.2g}',
        _best(row, heyoka, rows),
        _times(plain),
        _times(batch)
        if any(each['program'] == 'heyoka_batch' for each in rows if each['problem'] == key)
        else '–',
        _times(dop853),
        _first(row, result),
    ]
    return f'| {" | ".join(cells)} |'


def _best(row: BenchRow, times: float | None, rows: list[BenchRow]) -> str:
    """Return heyoka's ratio and setting; on land with and without set-up."""
    key, names = row['problem'], FAMILIES['heyoka']
    if times is None:
        return _times(times)
    enough = max(targets()[key], row['error_s_per_day'])
    other = cheapest(rows, key, names, enough)
    setting = '' if other is None else f' ({other["setting"]})'
    if key not in 'ab':
        return _times(times) + setting
    whole = best_ratio(rows, key, names, setup=True)
    return f'{_times(whole)} in 81 days with set-up, {_times(times)} without{setting}'


def _first(row: BenchRow, result: Mapping[str, Any]) -> str:
    """Return the first runs of Tauto and of heyoka's best formulation there."""
    found = {
        each['program']: each['first_run_s']
        for each in result.get('first_runs', ())
        if each['problem'] == row['problem']
    }
    seconds = found.get('tauto'), found.get('heyoka_tuned', found.get('heyoka'))
    return ', '.join('–' if each is None else f'{each:.2g}' for each in seconds)


def _extras(result: Mapping[str, Any]) -> str:
    if 'passage' not in result:
        return ''
    passage, both = result['passage'], result['two_at_once']
    return (
        f'An 81-day passage of {passage["problem"]} ({passage["setting"]}) took '
        f'{passage["run_s"]:.0f} s all in, {passage["us_per_oscillation"]:.2g} µs a swing; two '
        f'runs at once in one process took {both["ratio"]:.2g} times as long as one, two in two '
        f'processes {both["processes_ratio"]:.2g} times.'
    )


def _times(number: float | None) -> str:
    if number is None:
        return 'not reached'
    return f'{number:.2g}×' if number < 100.0 else f'{float(f"{number:.2g}"):,.0f}×'


def update(path: Path, result: Mapping[str, Any]) -> None:
    """Replace the lines between the marks of a file.

    Raises:
        UsageError: it has no marks.
    """
    before, begin, rest = path.read_text('utf-8').partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise UsageError(
            f'{path} has no lines {BEGIN!r} and {END!r}. Put them where the table goes'
        )
    path.write_text(f'{before}{BEGIN}\n{block(result)}\n{END}{after}', 'utf-8')


def current(path: Path) -> str:
    """Return the lines between the marks of a file."""
    text = path.read_text('utf-8')
    return text.partition(BEGIN)[2].partition(END)[0].strip('\n')
