"""Tracks of log-books on a map, and a trial on them: tracks coloured by the error of a clock."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tauto_core.ensembles.answers import mark_prizes
from tauto_core.ensembles.trial_answers import TrialAnswers, size_nmi
from tauto_core.ensembles.trials import Sailed
from tauto_core.files import write_figure
from tauto_core.samples import FloatArray
from tauto_core.ship.coast import land, map_frame
from tauto_core.ship.logbook import LoggedPassage
from tauto_core.wording import counted

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

LEAST_NMI, MOST_NMI = 1.0, 3000.0
"""Ends of the scale of colours [nmi]."""

RATIO = 1.75
"""Width of a map over its height."""

_LINES = {'raw': (0, (4, 2)), 'corrected': '-', 'sensed': (0, (1, 1))}
_SAID = {
    'raw': 'the dial alone',
    'corrected': 'rated in harbour',
    'sensed': 'with thermometer and IMU',
}


def draw_passages(passages: Sequence[LoggedPassage], path: Path) -> None:
    """Draw the tracks of passages, at least one; replaces the file, .svg, .png or .pdf."""
    from matplotlib.figure import Figure

    def made() -> Figure:
        figure = Figure(figsize=(8.0, 5.0), layout='constrained')
        axes = figure.subplots()
        _map(axes, [_places(each) for each in passages])
        axes.set_title(counted(len(passages), 'passage'), loc='left', fontsize=10.0)
        return figure

    write_figure(made, path)


def draw_trial(sailed: Sailed, answers: TrialAnswers, path: Path) -> None:
    """Draw a trial that has been sailed; replaces the file, .svg, .png or .pdf."""
    write_figure(lambda: trial_figure(sailed, answers), path)


def trial_figure(sailed: Sailed, answers: TrialAnswers) -> Figure:
    """Return the figure: the tracks of the first clock, and the distribution of the errors."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 8.6), layout='constrained')
    above, below = figure.subplots(2, 1, height_ratios=[3.0, 2.0])
    clock = sailed.trial.rules.clocks[0].name
    traces = {
        row['passage']: row['noon_error_nmi']
        for row in sailed.rows
        if row['drawn'] == 'log' and row['clock'] == clock
    }
    passages = sailed.trial.passages
    tracks = _map(
        above,
        [_places(each) for each in passages],
        [np.abs(traces[each.name]) for each in passages],
    )
    above.set_title(
        f'{clock}, rated in harbour: {counted(len(passages), "passage")}',
        loc='left',
        fontsize=10.0,
    )
    bar = figure.colorbar(tracks, ax=above, shrink=0.8, label='error [nautical miles]')
    ticks = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0]
    bar.set_ticks(ticks, labels=[f'{tick:,.0f}' for tick in ticks])
    bar.minorticks_off()
    _distribution(below, answers)
    return figure


def _places(passage: LoggedPassage) -> FloatArray:
    """Return longitudes and latitudes of the entries [degrees], without jumps, (n, 2)."""
    latitude, longitude = np.array([entry[1:3] for entry in passage.entries]).T
    longitude = np.degrees(np.unwrap(np.radians(longitude)))
    longitude -= 360.0 * round(float(np.mean(longitude)) / 360.0)
    return np.column_stack((longitude, latitude))


def _map(
    axes: Axes, tracks: Sequence[FloatArray], errors: Sequence[FloatArray] | None = None
) -> LineCollection:
    """Draw coasts and tracks, which are coloured by the errors at their places."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LogNorm

    everywhere = np.concatenate(tracks)
    shown = map_frame(everywhere[:, 0], everywhere[:, 1], ratio=RATIO)
    for outline in land(shown):
        axes.fill(*outline, facecolor='#e4dfd4', edgecolor='#a39c8d', linewidth=0.3)
    pieces, sizes = [], []
    for place, track in enumerate(tracks):
        # a clock that ended early has no errors from there on
        count = len(track) if errors is None else min(len(track), len(errors[place]))
        legs = np.stack((track[:-1], track[1:]), axis=1)[: max(count - 1, 0)]
        pieces.append(legs)
        if errors is not None:
            sizes.append(errors[place][1:count])
    drawn = LineCollection(list(np.concatenate(pieces)), linewidths=0.9)
    if errors is None:
        drawn.set_color('#003f88')
    else:
        drawn.set_norm(LogNorm(LEAST_NMI, MOST_NMI))
        drawn.set_cmap('viridis_r')
        drawn.set_array(np.clip(np.concatenate(sizes), LEAST_NMI, MOST_NMI))
    axes.add_collection(drawn)
    axes.set_xlim(shown.west, shown.east)
    axes.set_ylim(shown.south, shown.north)
    axes.set_aspect(shown.stretch)
    axes.set_xlabel('longitude [degrees east]')
    axes.set_ylabel('latitude [degrees north]')
    return drawn


LEAST_SHOWN_NMI = 0.1
"""Left end of the axis of errors [nmi]."""


def _distribution(axes: Axes, answers: TrialAnswers) -> None:
    several = len(answers.clocks) > 1
    for place, clock in enumerate(answers.clocks):
        for way in ['corrected'] if several else clock.ways:
            rows = [row for row in answers.voyages if row['clock'] == clock.clock]
            sizes = np.sort([max(size_nmi(row, way), LEAST_SHOWN_NMI) for row in rows])
            axes.step(
                np.concatenate(([LEAST_SHOWN_NMI], sizes)),
                100.0 * np.arange(len(sizes) + 1) / len(sizes),
                where='post',
                color=f'C{place}',
                linestyle=_LINES[way],
                linewidth=1.2,
                label=clock.clock if several else _SAID[way],
            )
    mark_prizes(axes)
    axes.set_xscale('log')
    axes.set_ylim(0.0, 101.0)
    axes.set_xlabel('error of the longitude at the end of the passage [nautical miles]')
    axes.set_ylabel('passages within [%]')
    axes.set_title('rated in harbour' if several else '', loc='left', fontsize=10.0)
    axes.grid(color='#e4e4e4', linewidth=0.5)
    axes.legend(frameon=False, loc='upper left', fontsize=7.0)
