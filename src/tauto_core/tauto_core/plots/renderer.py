"""The pictures of a voyage, drawn with Matplotlib to files or figures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from textwrap import fill, wrap
from typing import TYPE_CHECKING

import numpy as np

from tauto_core.files import check_plot, write_figure
from tauto_core.plots.chart import Chart, Line, Mark
from tauto_core.plots.contents import chart, check_what
from tauto_core.results import not_whole
from tauto_core.voyage import Voyage

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


COLOURS = {'blue': '#0072b2', 'orange': '#d55e00', 'green': '#009e73', 'grey': '#767676'}
"""The palette of Okabe and Ito, safe for the colour-blind; its grey suits white and black."""
_TITLE_CHARACTERS = 64
_DASHES = {'blue': '-', 'orange': '--', 'green': '-', 'grey': '-'}


def check_picture(what: str, file: str | Path | None, *, part: bool = False) -> None:
    """Refuse, before anything runs, an unknown picture or a file to which it cannot be written.

    Args:
        what: name of the picture.
        file: the file, if one is named.
        part: whether a part of the voyage is asked for.

    Raises:
        UsageError: see `contents.check_what` and `files.check_plot`.
    """
    check_what(what, part=part)
    if file is not None:
        check_plot(Path(file), 'file')


def picture(
    voyage: Voyage,
    what: str,
    file: str | Path | None = None,
    *,
    from_s: float | None = None,
    to_s: float | None = None,
) -> Figure:
    """Return a picture as a figure, and write it to a file if one is named.

    Args:
        voyage: the voyage that the picture shows.
        what: one of `contents.PICTURES`.
        file: name of the file, ending in .svg, .png or .pdf; an existing file is replaced.
        from_s, to_s: as for `contents.chart`.

    Raises:
        UsageError: no such picture, no data for it, or another suffix.
        OutputError: the file cannot be written.
    """
    check_picture(what, file, part=from_s is not None or to_s is not None)
    name = '\n'.join([*wrap(not_whole(voyage.result), _TITLE_CHARACTERS), voyage.scene.name])
    figure = draw(chart(voyage, what, from_s, to_s), name)
    if file is not None:
        write_figure(lambda: figure, Path(file), 'file')
    return figure


def draw(of: Chart, name: str) -> Figure:
    """Return a chart as a figure.

    Args:
        of: the chart.
        name: name of the scene, for the title.
    """
    from matplotlib.figure import Figure

    panels = of.panels
    high = 6.0 if of.equal else 2.4 + 1.6 * len(panels)
    figure = Figure(figsize=(6.4, high), layout='constrained')
    for axes, panel in zip(
        figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0], panels, strict=True
    ):
        draw_on(axes, panel)
        axes.label_outer()
    named = any(mark.name for mark in of.marks)
    title = f'{name}: {of.title[0].lower()}{of.title[1:]}'
    figure.axes[0].set_title(title, loc='left', fontsize=11.0, pad=22.0 if named else 6.0)
    notes = [panel.note for panel in panels if panel.note]
    if notes:
        figure.supxlabel(fill(' '.join(notes), 100), fontsize=8.0, x=0.01, ha='left')
    return figure


def draw_on(axes: Axes, of: Chart) -> None:
    """Draw a chart on axes, with its legend and without a title."""
    for line in of.lines:
        _draw_line(axes, line, '-' if of.equal else _DASHES[line.colour])
    for mark in of.marks:
        axes.axvline(mark.x, color=COLOURS['grey'], lw=0.8, ls='--' if mark.name else ':')
    _name(axes, of.marks)
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
    if not of.y_ticks:
        axes.set_yticks([])
    axes.spines[['top', 'right']].set_visible(False)
    if sum(bool(line.name) for line in of.lines) > 1:
        # where no place is free, the names stay legible on what they cover
        axes.legend(edgecolor='none', framealpha=0.8, fontsize=8.5, loc='best')


def _name(axes: Axes, marks: Sequence[Mark]) -> None:
    """Write the names of marks above the axes; one that ends the picture ends there itself."""
    low, high = axes.get_xlim()
    before, raised = -1.0, False
    for mark in (each for each in sorted(marks, key=lambda each: each.x) if each.name):
        place = (mark.x - low) / (high - low)
        raised = place - before < 0.1 and not raised
        before = place
        axes.annotate(
            mark.name,
            (mark.x, 1.0),
            (0.0, 11.0 if raised else 3.0),
            xycoords=('data', 'axes fraction'),
            textcoords='offset points',
            ha='left' if place < 0.05 else 'right' if place > 0.95 else 'center',
            fontsize=8.0,
            annotation_clip=False,
        )


def _draw_line(axes: Axes, line: Line, style: str) -> None:
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
        axes.plot(line.x, line.y, style, color=colour, linewidth=1.4, label=name)


def _dot(number: int) -> float:
    return float(np.clip(12.0 / math.log10(number + 9.0), 2.5, 8.0))
