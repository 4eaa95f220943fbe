"""The work–precision figure: cost of a swing against the error of the clock."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.work_precision.problems import Problem, WheelProblem, problems
from benchmarks.work_precision.ratios import ASKED_S_PER_DAY, targets
from tauto_core.files import OutputError, write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

LEAST_S_PER_DAY = 1e-14
"""Smaller errors are drawn at this value, since they mean nothing."""

MOST_S_PER_DAY = 3.0
"""Right end of the errors at sea [s/day]."""

LABELS = {
    'tauto': 'Tauto',
    'heyoka': 'heyoka (Taylor), plain',
    'heyoka_tuned': 'heyoka, best formulation',
    'heyoka_batch': 'heyoka, a ship of eight',
    'dop853_compiled': 'DOP853 (numba)',
}
_STYLES = {
    'tauto': ('#c1121f', 'o'),
    'heyoka': ('#6a8fc7', 's'),
    'heyoka_tuned': ('#003f88', 's'),
    'heyoka_batch': ('#00a6d6', 's'),
    'dop853_compiled': ('#2a9d5c', '^'),
}
FRONTS = ('tauto', 'heyoka_tuned', 'heyoka_batch')
"""Programs whose settings are of two kinds, and so do not form a curve."""
_DASHED = 'waves'


def draw(result: Mapping[str, Any], path: Path) -> None:
    """Draw a result to an SVG or PNG file; replaces the file.

    Raises:
        OutputError: the file cannot be written.
        UsageError: see `check_plot`.
    """
    write_figure(lambda: work_precision(result), path)


def work_precision(result: Mapping[str, Any]) -> Figure:
    """Return the figure: a panel for each problem, logarithmic cost over logarithmic error."""
    from matplotlib.figure import Figure

    shown = [p for p in problems() if any(row['problem'] == p.key for row in result['rows'])]
    if not shown:
        raise OutputError('there is no row to draw: every run failed. See why with --json')
    columns = min(3, len(shown))
    lines = math.ceil(len(shown) / columns)
    figure = Figure(figsize=(4.1 * columns, 3.6 * lines + 1.2), layout='constrained')
    grid = figure.subplots(lines, columns, squeeze=False).ravel()
    for axes, problem in zip(grid, shown, strict=False):
        _panel(axes, problem, result['rows'])
    handles = _handles(result['rows'])
    for axes in grid[len(shown) :]:
        axes.set_axis_off()
    if len(shown) < len(grid):
        grid[len(shown)].legend(
            handles=handles, loc='center', frameon=False, fontsize=9.5, labelspacing=0.6
        )
    else:
        figure.legend(handles=handles, loc='outside lower center', frameon=False, ncols=columns)
    machine = result['machine']
    figure.suptitle(
        'Cost of a swing against the error of the clock\n'
        f'one core of {machine["processor"]}, Python {machine["python"]}, {machine["date"]}',
        fontsize=11.0,
    )
    return figure


def _panel(axes: Axes, problem: Problem, rows: Iterable[Mapping[str, Any]]) -> None:
    key, title = problem.key, problem.title
    at_sea = isinstance(problem, WheelProblem) and problem.numbers.sea is not None
    for program, method, points in _series(rows, key):
        color, marker = _STYLES[program]
        ours = program == 'tauto'
        axes.loglog(
            [x for x, _ in points],
            [y for _, y in points],
            color=color,
            marker=marker,
            markersize=7.5 if ours else 4.5,
            markeredgecolor='white',
            markeredgewidth=0.7 if ours else 0.4,
            linewidth=2.2 if ours else 1.0,
            linestyle='--' if method == _DASHED else '-',
            alpha=1.0 if ours else 0.9,
            zorder=5 if ours else 3,
        )
    compared = LEAST_S_PER_DAY / 3.0, targets()[key]
    axes.axvspan(*compared, color='#f4e9cd', zorder=0, linewidth=0.0)
    if at_sea:
        axes.axvspan(*ASKED_S_PER_DAY, color='#dcebdd', zorder=0, linewidth=0.0)
        axes.set_xlim(right=MOST_S_PER_DAY)
    axes.set_xlim(left=LEAST_S_PER_DAY / 3.0)
    axes.set_title(f'({key}) {title}', fontsize=9.5, loc='left')
    axes.set_xlabel('error of the clock [s/day]')
    axes.set_ylabel('run time of a swing [µs]')
    axes.grid(color='#dddddd', linewidth=0.5, zorder=1)
    axes.set_axisbelow(True)
    for side in ('top', 'right'):
        axes.spines[side].set_visible(False)


def _series(
    rows: Iterable[Mapping[str, Any]], key: str
) -> list[tuple[str, str, list[tuple[float, float]]]]:
    """Return (program, method, points) of a problem; words in a setting name a method.

    Points are in the order of the settings. Of `FRONTS` only those rows are drawn that no other
    beats in both error and cost.
    """
    found: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for row in rows:
        if row['problem'] == key:
            words = str(row['setting']).split() if row['program'] not in FRONTS else []
            method = ' '.join(word for word in words if word.isalpha())
            x = max(LEAST_S_PER_DAY, row['error_s_per_day'])
            found.setdefault((row['program'], method), []).append((x, row['us_per_oscillation']))
    return [
        (program, method, sorted(_front(points)) if program in FRONTS else points)
        for (program, method), points in found.items()
    ]


def _front(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    return [
        (x, y)
        for x, y in points
        if not any((u <= x and v < y) or (u < x and v <= y) for u, v in points)
    ]


def _handles(rows: Iterable[Mapping[str, Any]]) -> list[Line2D | Patch]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    present = {row['program'] for row in rows}
    handles: list[Line2D | Patch] = []
    for program, (color, marker) in _STYLES.items():
        if program in present:
            style: Any = {'color': color, 'marker': marker, 'label': LABELS[program]}
            size, width = (7.5, 2.2) if program == 'tauto' else (5.5, 1.0)
            handles.append(Line2D([], [], markersize=size, linewidth=width, **style))
    if any(_DASHED in row['setting'].split() for row in rows):
        words = 'dashed: sum of waves'
        handles.append(Line2D([], [], color='#555555', linestyle='--', label=words))
    handles.append(Patch(color='#f4e9cd', label='where programs are compared'))
    handles.append(
        Patch(color='#dcebdd', label='what scenes ask for: $10^{-6}$ to $10^{-3}$ s/day')
    )
    return handles
