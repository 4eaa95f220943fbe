"""The comparison as a figure: error against time, or rate against roll, a panel per clock."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tauto_core.comparison.running import Comparison, Row
from tauto_core.files import write_figure
from tauto_core.samples import SECONDS_PER_DAY
from tauto_core.wording import span

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NEEDED_S = 120.0
"""Time in which the earth turns by half a degree: 30 nautical miles at the equator."""

_BAND = '#f4e9cd'
_STYLES: dict[bool, dict[str, Any]] = {
    False: {'color': '#003f88', 'linewidth': 1.3, 'label': 'fixed to the ship'},
    True: {
        'color': '#c1121f',
        'linewidth': 1.3,
        'linestyle': (0, (3, 2)),
        'label': 'hung on an axle',
    },
}


def draw(result: Comparison, path: Path) -> None:
    """Draw a comparison to an SVG or PNG file; replaces the file.

    Errors against time where all clocks sail in one sea, with the error that the Act of 1714
    allows where it judges the voyage; where the roll differs, rates against the roll.

    Args:
        result: what `compare` returns.
        path: name of the file, ending in .svg, .png or .pdf.

    Raises:
        OutputError: the file cannot be written.
        UsageError: see `files.check_plot`.
    """
    write_figure(lambda: side_by_side(result), path)


def side_by_side(result: Comparison) -> Figure:
    """Return the figure: small panels with common axes."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    clocks = list(dict.fromkeys(row.clock for row in result.rows))
    judged = any(row.prize_pounds is not None for row in result.rows)
    by_roll = len({row.roll_deg for row in result.rows}) > 1
    columns = min(4, len(clocks))
    lines = math.ceil(len(clocks) / columns)
    figure = Figure(figsize=(2.6 * columns + 0.6, 2.2 * lines + 0.9), layout='constrained')
    grid = figure.subplots(lines, columns, squeeze=False, sharex=True, sharey=not by_roll)
    for axes, clock in zip(grid.ravel(), clocks, strict=False):
        rows = [row for row in result.rows if row.clock == clock]
        (_rates if by_roll else _errors)(axes, rows)
        if judged and not by_roll:
            axes.axhspan(-NEEDED_S, NEEDED_S, color=_BAND, zorder=0, linewidth=0.0)
        axes.set_title(clock.removeprefix('clock_').replace('_', ' '), fontsize=9.0, loc='left')
        axes.axhline(0.0, color='#888888', linewidth=0.6, zorder=1)
        axes.grid(color='#e4e4e4', linewidth=0.5)
        axes.set_axisbelow(True)
        for side in ('top', 'right'):
            axes.spines[side].set_visible(False)
    for axes in grid.ravel()[len(clocks) :]:
        axes.set_axis_off()
    rate = f'mean rate over {span(result.duration_s)} [s/day]'
    figure.supylabel(rate if by_roll else 'error of the clock [s]', fontsize=9.0)
    figure.supxlabel('significant roll [degrees]' if by_roll else 'days', fontsize=9.0)
    shown = sorted({row.suspended for row in result.rows})
    handles: list[Line2D | Patch] = [Line2D([], [], **_STYLES[hung]) for hung in shown]
    if judged and not by_roll:
        handles.append(Patch(color=_BAND, label='within 30 miles at the equator'))
    figure.legend(handles=handles, loc='outside upper right', frameon=False, ncols=3)
    return figure


def _errors(axes: Axes, rows: Sequence[Row]) -> None:
    for row in rows:
        style = _STYLES[row.suspended]
        axes.plot([time / SECONDS_PER_DAY for time in row.time_s], row.trace_s, **style)
        if row.stopped is not None:
            last = row.trace_s[-1] if row.trace_s else 0.0
            axes.plot(row.stopped.at_s / SECONDS_PER_DAY, last, 'x', color=style['color'])


def _rates(axes: Axes, rows: Sequence[Row]) -> None:
    """Draw rates on the panel's own scale; those of a force are a millionth of a weight's."""
    for hung, style in _STYLES.items():
        shown = sorted(
            (row.roll_deg, row.rate_s_per_day)
            for row in rows
            if row.suspended == hung
            and row.rate_s_per_day is not None
            and row.roll_deg is not None
        )
        if shown:
            axes.plot(*zip(*shown, strict=True), **style, marker='o', markersize=3.0)
