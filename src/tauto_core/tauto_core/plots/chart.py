"""Charts: lines, bands and points on axes with units, and how Matplotlib draws them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING, Literal

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.ship.coast import MapFrame, land, map_frame
from tauto_core.wording import significant

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Colour = Literal['blue', 'orange', 'green', 'grey']


@dataclass(frozen=True)
class Line:
    """A line, a band between two lines, points, or bars.

    Attributes:
        name: name in the legend, or empty.
        x: (n,), in the unit of the axis.
        y: (n,), the lower edge of a band.
        colour: by role: blue the dial or the machine, orange estimates, green the ship, grey given
            values.
        kind: how it is drawn. An area is a closed and filled line.
        high: upper edge of a band or end of a bar, (n,).
    """

    name: str
    x: FloatArray
    y: FloatArray
    colour: Colour = 'blue'
    kind: Literal['line', 'band', 'points', 'bars', 'area'] = 'line'
    high: FloatArray | None = None


@dataclass(frozen=True)
class Mark:
    """An event, drawn as a vertical line.

    Attributes:
        x: in the unit of the axis.
        name: label above the line, or empty for a faint dotted line that the note explains.
    """

    x: float
    name: str = ''


@dataclass(frozen=True)
class Chart:
    """A picture with two axes, and the charts below it that share its x axis.

    Attributes:
        x_label, y_label: labels of the axes, with their units.
        lines: from the back to the front.
        log_x, log_y, equal: whether an axis is logarithmic, and both have the same scale.
        note: further information for the reader, or empty.
        y_ticks: whether the y axis has numbers. A drawing with a break has no numbers.
        is_map: whether x and y are longitude and latitude [°]. Coasts are drawn below the lines,
            and miles are as long both ways mid-map. A band without `high` is a closed line.
        names: names at places (x, y).
        below: the next chart below, on the same x axis.
    """

    title: str
    x_label: str
    y_label: str
    lines: Sequence[Line]
    log_x: bool = False
    log_y: bool = False
    equal: bool = False
    note: str = ''
    marks: Sequence[Mark] = ()
    y_ticks: bool = True
    is_map: bool = False
    names: Sequence[tuple[str, float, float]] = ()
    below: Chart | None = None

    @property
    def panels(self) -> list[Chart]:
        """The chart and all below it, from top to bottom."""
        return [self, *(self.below.panels if self.below else ())]

    def y_limits(self) -> tuple[float, float] | None:
        """Return the range of the lines and of the bands' ends, or `None` for an automatic range.

        It is automatic without bands, on maps, and on logarithmic and equal axes.
        """
        if (
            self.log_y
            or self.equal
            or self.is_map
            or not any(line.kind == 'band' for line in self.lines)
        ):
            return None
        ends = [line.y for line in self.lines if line.kind != 'band' and len(line.y)]
        ends += [
            np.array([line.y[-1], line.high[-1]])
            for line in self.lines
            if line.kind == 'band' and line.high is not None and len(line.y)
        ]
        low, high = min(float(y.min()) for y in ends), max(float(y.max()) for y in ends)
        # a flat line needs some height
        margin = 0.05 * (high - low) or 1e-9
        return low - margin, high + margin

    @property
    def described(self) -> str:
        """The chart in words: titles, axes, and the range and end of each line."""
        sentences = [f'{self.title}.'] if self.title else []
        for panel in self.panels:
            sentences.append(f'{panel.y_label} against {panel.x_label}.')
            for line in panel.lines if not panel.equal and not panel.is_map else ():
                y = line.y[np.isfinite(line.y)]
                if line.kind == 'band' or not len(y):
                    continue
                name = f'{line.name}: ' if line.name else ''
                low, high, end = (significant(float(size)) for size in (y.min(), y.max(), y[-1]))
                sentences.append(f'{name}{low} to {high}, at the end {end}.')
            sentences += [f'{mark.name} at {mark.x:.3g}.' for mark in panel.marks if mark.name]
            sentences += [f'{name}.' for name, _, _ in panel.names]
        return ' '.join(filter(None, sentences))

    @property
    def name_rows(self) -> list[list[Mark]]:
        """The named marks in rows that keep names apart by a tenth of the width."""
        ends = [
            float(end(line.x)) for line in self.lines if len(line.x) for end in (np.min, np.max)
        ]
        rows: list[list[Mark]] = []
        for mark in sorted((mark for mark in self.marks if mark.name), key=lambda mark: mark.x):
            limit = mark.x - 0.1 * (max(ends) - min(ends))
            row = next((row for row in rows if row[-1].x <= limit), None)
            if row is None:
                rows.append([mark])
            else:
                row.append(mark)
        return rows

    def frame(self, ratio: float = 0.0) -> MapFrame:
        """Return the frame of a map that contains all lines (`coast.map_frame`)."""
        x = np.concatenate([line.x for line in self.lines])
        return map_frame(x, np.concatenate([line.y for line in self.lines]), ratio)


COLOURS = {'blue': '#0072b2', 'orange': '#d55e00', 'green': '#009e73', 'grey': '#767676'}
"""The palette of Okabe and Ito, safe for the colour-blind, with a grey for white and black."""
LAND = '#e4dfd3'
"""The colour of land on white paper."""
MAP_RATIO = 1.5
"""Width over height of a map."""


def draw(of: Chart, name: str = '', width_in: float = 6.4) -> Figure:
    """Return a chart as a figure, with title and notes if the name of the scene is given."""
    from tauto_core.plots.picture import Picture

    panels = of.panels
    high = 6.0 if of.equal else 0.78 * width_in if of.is_map else 2.4 + 1.6 * len(panels)
    figure = Picture(figsize=(width_in, high), layout='constrained')
    figure.described = of.described
    for axes, panel in zip(
        figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0], panels, strict=True
    ):
        draw_on(axes, panel)
        axes.label_outer()
    if not name:
        return figure
    named = any(mark.name for mark in of.marks)
    title = f'{name}: {of.title[0].lower()}{of.title[1:]}'
    figure.axes[0].set_title(title, loc='left', fontsize=11.0, pad=22.0 if named else 6.0)
    notes = [panel.note for panel in panels if panel.note]
    if notes:
        figure.supxlabel(fill(' '.join(notes), 100), fontsize=8.0, x=0.01, ha='left')
    return figure


def draw_on(axes: Axes, of: Chart) -> None:
    """Draw a chart on axes, with its legend and without a title."""
    if of.is_map:
        draw_land(axes, of.frame(MAP_RATIO))
    for line in of.lines:
        _draw_line(axes, line, solid=of.equal)
    for mark in of.marks:
        axes.axvline(mark.x, color=COLOURS['grey'], lw=0.8, ls='--' if mark.name else ':')
    # names are above the axes, aligned to the edge if near it, and raised if they would collide
    left, right = axes.get_xlim()
    for row, marks in enumerate(of.name_rows):
        for mark in marks:
            place = (mark.x - left) / (right - left)
            axes.annotate(
                mark.name,
                (mark.x, 1.0),
                (0.0, 3.0 + 8.0 * min(row, 1)),
                xycoords=('data', 'axes fraction'),
                textcoords='offset points',
                ha='left' if place < 0.05 else 'right' if place > 0.95 else 'center',
                fontsize=8.0,
                annotation_clip=False,
            )
    if (limits := of.y_limits()) is not None:
        axes.set_ylim(*limits)
    for name, x, y in of.names:
        axes.plot(x, y, 'o', color=COLOURS['grey'], markersize=4.0)
        axes.annotate(name, (x, y), (4.0, 5.0), textcoords='offset points', fontsize=8.5)
    axes.set_xlabel(of.x_label)
    axes.set_ylabel(of.y_label)
    axes.set_xscale('log' if of.log_x else 'linear')
    axes.set_yscale('log' if of.log_y else 'linear')
    if of.equal:
        axes.set_aspect('equal', adjustable='datalim')
    elif not of.is_map:
        axes.ticklabel_format(useOffset=False) if not (of.log_x or of.log_y) else None
        axes.grid(color='#999999', alpha=0.3, linewidth=0.5)
    if not of.y_ticks:
        axes.set_yticks([])
    axes.spines[['top', 'right']].set_visible(False)
    if sum(bool(line.name) for line in of.lines) > 1:
        # opaque enough to be legible if it covers lines
        axes.legend(edgecolor='none', framealpha=0.8, fontsize=8.5, loc='best')


def draw_land(axes: Axes, of: MapFrame) -> None:
    """Draw the land of a map, and fix the sides of its axes."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    outlines = [Path(outline.T, closed=True) for outline in land(of)]
    if outlines:
        colour = COLOURS['grey']
        coast = Path.make_compound_path(*outlines)
        axes.add_patch(PathPatch(coast, facecolor=LAND, edgecolor=colour, lw=0.4, zorder=0.5))
    axes.set_xlim(of.west, of.east)
    axes.set_ylim(of.south, of.north)
    axes.set_aspect(of.stretch)
    axes.grid(color='#999999', alpha=0.3, linewidth=0.5)


def _draw_line(axes: Axes, line: Line, *, solid: bool) -> None:
    x, y, high, colour = line.x, line.y, line.high, COLOURS[line.colour]
    name = line.name or '_'
    if line.kind == 'band' and high is None:
        axes.fill(x, y, color=colour, alpha=0.2, lw=0, label=name)
    elif line.kind == 'band':
        assert high is not None
        axes.fill_between(x, y, high, color=colour, alpha=0.2, lw=0, label=name)
    elif line.kind == 'bars':
        assert high is not None
        axes.vlines(x, y, high, color=colour, alpha=0.6, lw=4.0, label=name)
    elif line.kind == 'points':
        dot = float(np.clip(12.0 / math.log10(len(x) + 9.0), 2.5, 8.0))
        axes.plot(x, y, '.', color=colour, markersize=dot, label=name)
    elif line.kind == 'area':
        axes.fill(x, y, color=colour, alpha=0.5, label=name)
        axes.plot(x, y, color=colour, linewidth=1.0)
    else:
        style = '--' if line.colour == 'orange' and not solid else '-'
        axes.plot(x, y, style, color=colour, linewidth=1.4, label=name)
