"""Pictures of ensembles: tracks on a map, trials, fleets and comparisons."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tauto_core.ensembles.comparison import Comparison
from tauto_core.ensembles.comparison import Row as ClockRow
from tauto_core.ensembles.fleets import Fleet
from tauto_core.ensembles.rows import ERRORS, Row, sizes_nmi
from tauto_core.ensembles.trials import WAYS, Trial, TrialAnswers
from tauto_core.navigation.longitude import ARCMIN_PER_S, AWARDS
from tauto_core.plots.chart import draw_land
from tauto_core.samples import FloatArray
from tauto_core.scene.times import DAY_S
from tauto_core.ship.coast import map_frame
from tauto_core.ship.logbook import LoggedPassage
from tauto_core.wording import counted, span

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

LEAST_NMI, MOST_NMI = 1.0, 3000.0
"""Ends of the scale of colours [nmi]."""

RATIO = 1.75
"""Width of a map over its height."""

LEAST_SHOWN_NMI = 0.01
"""Left end of the axis of errors [nmi]. Below 20 m ships cannot be distinguished."""

_LINES = {'raw': (0, (4, 2)), 'corrected': '-', 'sensed': (0, (1, 1))}
_LABELS = {
    'raw': 'the dial alone',
    'corrected': 'rated in harbour',
    'sensed': 'with thermometer and IMU',
}


def passages_figure(passages: Sequence[LoggedPassage]) -> Figure:
    """Return the figure of the tracks of passages, at least one."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 5.0), layout='constrained')
    axes = figure.subplots()
    _map(axes, [_places(passage) for passage in passages])
    axes.set_title(counted(len(passages), 'passage'), loc='left', fontsize=10.0)
    return figure


def trial_figure(trial: Trial, rows: Sequence[Row], answers: TrialAnswers) -> Figure:
    """Return the figure: the tracks of the first clock, and the distribution of the errors."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 8.6), layout='constrained')
    above, below = figure.subplots(2, 1, height_ratios=[3.0, 2.0])
    clock, passages = trial.clocks[0].name, trial.passages
    traces = {row['passage']: row['noon_error_nmi'] for row in rows if row['clock'] == clock}
    tracks = _map(
        above,
        [_places(passage) for passage in passages],
        [np.abs(traces[passage.name]) for passage in passages],
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
    several = len(answers.clocks) > 1
    for place, tried in enumerate(answers.clocks):
        own = [row for row in answers.voyages if row['clock'] == tried.clock]
        for way in ['corrected'] if several else tried.ways:
            label = tried.clock if several else _LABELS[way]
            _step(below, sizes_nmi(own, WAYS[way]), way, label, f'C{place}')
    _within(below, 'passage', 'passages', 'rated in harbour' if several else '')
    return figure


def _places(passage: LoggedPassage) -> FloatArray:
    """Return longitudes and latitudes of the entries [degrees], unwrapped, (n, 2)."""
    latitude, longitude = np.array([entry[1:3] for entry in passage.entries]).T
    longitude = np.degrees(np.unwrap(np.radians(longitude)))
    longitude -= 360.0 * round(float(np.mean(longitude)) / 360.0)
    return np.column_stack((longitude, latitude))


def _map(
    axes: Axes, tracks: Sequence[FloatArray], errors: Sequence[FloatArray] | None = None
) -> LineCollection:
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LogNorm

    everywhere = np.concatenate(tracks)
    frame = map_frame(everywhere[:, 0], everywhere[:, 1], ratio=RATIO)
    draw_land(axes, frame)
    pieces, sizes = [], []
    for place, track in enumerate(tracks):
        # the errors of a clock that ended early are shorter than its track
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
    axes.set_xlabel('longitude [degrees east]')
    axes.set_ylabel('latitude [degrees north]')
    return drawn


# -----------------------------------------------------------------------------
# A fleet: the distribution of the errors, and the keys with which they correlate.

_COLOURS = {'raw': '#003f88', 'corrected': '#c8553d'}


def fleet_figure(fleet: Fleet) -> Figure:
    """Return the figure: distribution of the errors, and correlations of the drawn keys."""
    from matplotlib.figure import Figure

    answers, ships = fleet.answers, len(fleet.rows)
    ranked = answers.influences
    heights = [3.6] + [0.9 + 0.32 * len(ranked)] * bool(ranked)
    figure = Figure(figsize=(7.0, sum(heights)), layout='constrained')
    grid = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)
    for way, colour in _COLOURS.items():
        _step(grid[0, 0], sizes_nmi(fleet.rows, ERRORS[way]), way, _LABELS[way], colour)
    judged, failed = answers.within is not None, sum(answers.failures.values())
    lost = f', {failed:,} of which failed' if failed else ''
    alone = f', {answers.unchecked()}' if failed < ships and not judged else ''
    title = f'{fleet.plan.scene.name}: {ships:,} ships{lost}{alone}'
    _within(grid[0, 0], 'voyage', 'ships', title, judged=judged)
    if ranked:
        _tornado(grid[1, 0], fleet)
    for axes in grid[:, 0]:
        axes.spines[['top', 'right']].set_visible(False)
        axes.set_axisbelow(True)
    return figure


def _step(axes: Axes, sizes: FloatArray, way: str, label: str, colour: str) -> None:
    """Draw the distribution of errors, infinite for clocks that did not arrive."""
    ends = np.concatenate(([LEAST_SHOWN_NMI], np.sort(np.maximum(sizes, LEAST_SHOWN_NMI))))
    shares = np.linspace(0.0, 100.0, len(ends))
    style: dict[str, Any] = {'color': colour, 'linestyle': _LINES[way], 'linewidth': 1.3}
    axes.step(ends, shares, where='post', label=label, **style)


def _within(axes: Axes, voyage: str, ships: str, title: str, *, judged: bool = True) -> None:
    """Label the axes of a distribution of errors, and draw the limits of the prizes of 1714."""
    for limit, pounds in AWARDS * judged:
        axes.axvline(limit, color='#777777', linewidth=0.8, linestyle=':')
        axes.annotate(
            f'{limit:g} nmi: £{pounds:,}',
            (limit, 2.0),
            rotation=90.0,
            ha='right',
            va='bottom',
            fontsize=7.0,
            color='#555555',
            zorder=3.0,  # above the curves
            bbox={'facecolor': 'white', 'edgecolor': 'none', 'alpha': 0.8, 'pad': 0.5},
        )
    axes.set_title(title, loc='left', fontsize=10.0)
    axes.legend(frameon=False, loc='upper left', fontsize=8.0)
    axes.set_xscale('log')
    axes.set_ylim(0.0, 101.0)
    axes.set_xlabel(f'error of the longitude at the end of the {voyage} [nautical miles]')
    axes.set_ylabel(f'{ships} within [%]')
    axes.grid(color='#e4e4e4', linewidth=0.5)


def _tornado(axes: Axes, fleet: Fleet) -> None:
    ranked = fleet.answers.influences[::-1]
    places = np.arange(len(ranked))
    for offset, (way, colour) in zip((0.2, -0.2), _COLOURS.items(), strict=True):
        values = [getattr(influence, way) or 0.0 for influence in ranked]
        axes.barh(places + offset, values, height=0.38, color=colour)
        sizes = [getattr(influence, f'{way}_size') or 0.0 for influence in ranked]
        axes.plot(sizes, places + offset, 'D', color='#222222', markersize=3.5)
    axes.axvline(0.0, color='#555555', linewidth=0.8)
    axes.set_xlim(-1.0, 1.0)
    axes.set_yticks(places, [influence.key for influence in ranked])
    axes.set_xlabel("rank correlation with the error (bars) and its size (diamonds), Spearman's ρ")
    axes.grid(axis='x', color='#e4e4e4', linewidth=0.5)


# -----------------------------------------------------------------------------
# A comparison: error against time, or rate against roll, a panel per clock.

NEEDED_S = AWARDS[0][0] / ARCMIN_PER_S
"""Time in which the Earth turns by half a degree, 30 nautical miles at the equator [s]."""

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


def comparison_figure(result: Comparison) -> Figure:
    """Return the figure: small panels with common axes.

    For clocks in one sea: errors against time, with the limit of the Act of 1714 if it judges the
    voyage. For several rolls: rates against the roll.
    """
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
        axes.spines[['top', 'right']].set_visible(False)
    for axes in grid.ravel()[len(clocks) :]:
        axes.set_axis_off()
    rate = f'mean rate over {span(result.duration_s)} [s/day]'
    figure.supylabel(rate if by_roll else 'error of the clock [s]', fontsize=9.0)
    figure.supxlabel('significant roll [degrees]' if by_roll else 'days', fontsize=9.0)
    cases = sorted({row.suspended for row in result.rows})
    handles: list[Line2D | Patch] = [Line2D([], [], **_STYLES[hung]) for hung in cases]
    if judged and not by_roll:
        handles.append(Patch(color=_BAND, label='within 30 miles at the equator'))
    figure.legend(handles=handles, loc='outside upper right', frameon=False, ncols=3)
    return figure


def _errors(axes: Axes, rows: Sequence[ClockRow]) -> None:
    for row in rows:
        style = _STYLES[row.suspended]
        axes.plot([time / DAY_S for time in row.time_s], row.trace_s, **style)
        if row.stopped is not None:
            error_s = row.trace_s[-1] if row.trace_s else 0.0
            axes.plot(row.stopped.at_s / DAY_S, error_s, 'x', color=style['color'])


def _rates(axes: Axes, rows: Sequence[ClockRow]) -> None:
    """Draw rates on the panel's own scale. A force has a millionth of a weight's rates."""
    for hung, style in _STYLES.items():
        points = sorted(
            (row.roll_deg, row.rate_s_per_day)
            for row in rows
            if row.suspended == hung
            and row.rate_s_per_day is not None
            and row.roll_deg is not None
        )
        if points:
            axes.plot(*zip(*points, strict=True), **style, marker='o', markersize=3.0)
