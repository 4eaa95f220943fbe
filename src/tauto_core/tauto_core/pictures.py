"""The pictures of a voyage, drawn with Matplotlib to files or figures."""

from __future__ import annotations

import math
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from tauto_core.answer import not_whole
from tauto_core.chart import Chart, Line
from tauto_core.charts import PICTURES, chart
from tauto_core.figure_file import check_plot, write_figure
from tauto_core.record import Voyage
from tauto_core.scene.errors import UsageError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {'blue': '#0072b2', 'orange': '#d55e00', 'green': '#009e73', 'grey': '#767676'}
"""The palette of Okabe and Ito, safe for the colour-blind; its grey suits white and black."""
_TITLE_CHARACTERS = 64
_DASHES = {'blue': '-', 'orange': '--', 'green': '-', 'grey': '-'}


def check_picture(what: str, file: str | Path | None) -> None:
    """Refuse, before anything runs, an unknown picture or a file to which it cannot be written.

    Raises:
        UsageError: see `charts.chart` and `figure_file.check_plot`.
    """
    if what not in PICTURES:
        raise UsageError(f'{what!r}: is not a picture. Choose one of {", ".join(PICTURES)}')
    if file is not None:
        check_plot(Path(file), '--out')


def picture(voyage: Voyage, what: str, file: str | Path | None = None) -> Figure:
    """Return a picture as a figure, and write it to a file if one is named.

    Args:
        voyage: the voyage that the picture shows.
        what: one of `charts.PICTURES`.
        file: name of the file, ending in .svg, .png or .pdf; an existing file is replaced.

    Raises:
        UsageError: no such picture, no data for it, or another suffix.
        FigureError: the file cannot be written.
    """
    check_picture(what, file)
    name = '\n'.join([*wrap(not_whole(voyage.result), _TITLE_CHARACTERS), voyage.scene.name])
    figure = draw(chart(voyage, what), name)
    if file is not None:
        write_figure(lambda: figure, Path(file), '--out')
    return figure


def draw(of: Chart, name: str) -> Figure:
    """Return a chart as a figure.

    Args:
        of: the chart.
        name: name of the scene, for the title.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 6.0 if of.equal else 4.0), layout='constrained')
    axes = figure.subplots()
    draw_on(axes, of)
    axes.set_title(f'{name}: {of.title[0].lower()}{of.title[1:]}', loc='left', fontsize=11.0)
    if of.note:
        figure.supxlabel(of.note, fontsize=8.0, x=0.01, ha='left')
    return figure


def draw_on(axes: Axes, of: Chart) -> None:
    """Draw a chart on axes, with its legend and without a title."""
    for line in of.lines:
        _draw_line(axes, line)
    if (limits := of.y_limits()) is not None:
        axes.set_ylim(*limits)
    axes.set_xlabel(of.x_label)
    axes.set_ylabel(of.y_label)
    if of.log_x:
        axes.set_xscale('log')
    if of.log_y:
        axes.set_yscale('log')
    if of.equal:
        axes.set_aspect('equal', adjustable='datalim')
    else:
        axes.ticklabel_format(useOffset=False) if not (of.log_x or of.log_y) else None
        axes.grid(color='#999999', alpha=0.3, linewidth=0.5)
    axes.spines[['top', 'right']].set_visible(False)
    if sum(bool(line.name) for line in of.lines) > 1:
        axes.legend(frameon=False, fontsize=8.5, loc='best')


def _draw_line(axes: Axes, line: Line) -> None:
    colour, name = COLOURS[line.colour], line.name or '_'
    if line.kind == 'band':
        assert line.high is not None
        axes.fill_between(line.x, line.y, line.high, color=colour, alpha=0.2, lw=0, label=name)
    elif line.kind == 'bars':
        assert line.high is not None
        axes.vlines(line.x, line.y, line.high, color=colour, alpha=0.6, lw=4.0, label=name)
    elif line.kind == 'points':
        axes.plot(line.x, line.y, '.', color=colour, markersize=_dot(len(line.x)), label=name)
    elif line.kind == 'area':
        axes.fill(line.x, line.y, color=colour, alpha=0.5, label=name)
        axes.plot(line.x, line.y, color=colour, linewidth=1.0)
    else:
        style = _DASHES[line.colour]
        axes.plot(line.x, line.y, style, color=colour, linewidth=1.4, label=name)


def _dot(number: int) -> float:
    return float(np.clip(12.0 / math.log10(number + 9.0), 2.5, 8.0))
