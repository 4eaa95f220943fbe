"""A picture of a fleet: the distribution of the errors, and the keys with which they correlate."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tauto_core.files import write_figure
from tauto_core.fleets.answers import distances
from tauto_core.fleets.sailing import Fleet
from tauto_core.navigation.longitude import AWARDS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CLOCKS = {
    'raw': ('the dial as set', '#003f88'),
    'corrected': ('rated and corrected', '#c8553d'),
}
_LEAST_NMI = 0.01
"""Left end of the axis; below 20 m ships cannot be distinguished."""


def draw(fleet: Fleet, path: Path) -> None:
    """Draw a fleet; replaces the file.

    Args:
        fleet: the fleet that has sailed.
        path: name of the file, ending in .svg, .png or .pdf.

    Raises:
        OutputError: the file cannot be written.
        UsageError: see `files.check_plot`.
    """
    write_figure(lambda: figure_of(fleet), path)


def figure_of(fleet: Fleet) -> Figure:
    """Return the figure: distribution of the errors, and correlations of the drawn keys."""
    from matplotlib.figure import Figure

    ranked = fleet.answers.influences
    heights = [3.6] + [0.9 + 0.32 * len(ranked)] * bool(ranked)
    figure = Figure(figsize=(7.0, sum(heights)), layout='constrained')
    grid = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)
    _distribution(grid[0, 0], fleet)
    if ranked:
        _tornado(grid[1, 0], fleet)
    for axes in grid[:, 0]:
        for side in ('top', 'right'):
            axes.spines[side].set_visible(False)
        axes.set_axisbelow(True)
    return figure


def _distribution(axes: Axes, fleet: Fleet) -> None:
    arrived = [row for row in fleet.rows if row['failure'] is None]
    ships = len(fleet.rows)
    for clock, (label, colour) in _CLOCKS.items():
        sizes = np.sort(np.maximum(distances(arrived, clock), _LEAST_NMI))
        shares = np.arange(1, len(sizes) + 1) / ships
        axes.step(
            np.concatenate(([_LEAST_NMI], sizes)),
            100.0 * np.concatenate(([0.0], shares)),
            where='post',
            color=colour,
            linewidth=1.4,
            linestyle='-' if clock == 'corrected' else (0, (4, 2)),
            label=label,
        )
    judged = fleet.answers.within is not None
    for limit, pounds in AWARDS if judged else ():
        axes.axvline(limit, color='#777777', linewidth=0.8, linestyle=':')
        axes.annotate(
            f'{limit:g} nmi: £{pounds:,}',
            (limit, 2.0),
            rotation=90.0,
            ha='right',
            va='bottom',
            fontsize=7.0,
            color='#555555',
        )
    axes.set_xscale('log')
    axes.set_ylim(0.0, 101.0)
    axes.set_xlabel('error of the longitude at the end of the voyage [nautical miles]')
    axes.set_ylabel('ships within [%]')
    failed = ships - len(arrived)
    lost = f', {failed:,} of which failed' if failed else ''
    alone = f', {fleet.answers.unchecked()}' if arrived and not judged else ''
    title = f'{fleet.plan.scene.name}: {ships:,} ships{lost}{alone}'
    axes.set_title(title, loc='left', fontsize=10.0)
    axes.grid(color='#e4e4e4', linewidth=0.5)
    axes.legend(frameon=False, loc='upper left')


def _tornado(axes: Axes, fleet: Fleet) -> None:
    ranked = fleet.answers.influences[::-1]
    places = np.arange(len(ranked))
    for offset, (clock, (label, colour)) in zip((0.2, -0.2), _CLOCKS.items(), strict=True):
        values = [getattr(each, clock) or 0.0 for each in ranked]
        axes.barh(places + offset, values, height=0.38, color=colour, label=label)
        sizes = [getattr(each, f'{clock}_size') or 0.0 for each in ranked]
        axes.plot(sizes, places + offset, 'D', color='#222222', markersize=3.5)
    axes.axvline(0.0, color='#555555', linewidth=0.8)
    axes.set_xlim(-1.0, 1.0)
    axes.set_yticks(places, [each.key for each in ranked])
    axes.set_xlabel("rank correlation with the error (bars) and its size (diamonds), Spearman's ρ")
    axes.grid(axis='x', color='#e4e4e4', linewidth=0.5)
