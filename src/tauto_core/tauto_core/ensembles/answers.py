"""The statistics of a fleet: how often the longitude was found, the errors, and their causes.

They are drawn here, too.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tauto_core.ensembles.rows import Rows
from tauto_core.files import write_figure
from tauto_core.navigation.longitude import AWARDS, LEAST_UNCHECKED_DAYS
from tauto_core.samples import FloatArray
from tauto_core.scene.times import DAY_S
from tauto_core.wording import counted, figure, percent, span

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from tauto_core.ensembles.fleets import Fleet, Plan

_CONFIDENCE = 0.95
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
LEAST_RANKED = 10
"""Least number of voyages for a correlation."""

ERRORS = {'raw': 'raw_error_nmi', 'corrected': 'error_nmi'}
"""The two ways of finding the longitude, with their columns: by the dial, and by the dial less the
estimated drift.
"""


@dataclass(frozen=True)
class Within:
    """Share of all ships whose longitude was within a limit; a ship that failed counts as outside.

    Attributes:
        limit_nmi: limit of the Act of 1714.
        ships: number of ships within it.
        share: their share of all.
        low, high: Wilson's interval for the share of such voyages, at 95 %.
    """

    limit_nmi: float
    ships: int
    share: float
    low: float
    high: float


@dataclass(frozen=True)
class Influence:
    """The correlation of a drawn key with the error.

    A key that shifts the error, such as a tolerance, correlates with the error and not with its
    size. A key that only scatters the error, such as the noise of an observation, correlates with
    the size and not with the error.

    Attributes:
        key: path in the scene.
        raw, corrected: Spearman's rank correlation, −1 to 1, with the dial's error, positive to
            the east, and with the corrected clock's; None where either does not vary.
        raw_size, corrected_size: the same with the size of the error.
    """

    key: str
    raw: float | None
    corrected: float | None
    raw_size: float | None
    corrected_size: float | None

    @property
    def strongest(self) -> float:
        """Size of the larger correlation of the corrected clock."""
        return max(abs(self.corrected or 0.0), abs(self.corrected_size or 0.0))


@dataclass(frozen=True)
class Answers:
    """The statistics of a fleet.

    Attributes:
        ships: number of ships that sailed.
        failures: reasons for which voyages ended early, with their numbers.
        unchecked_days: the least and the most time for which a clock had not been checked when
            its longitude was judged; None if no ship arrived.
        within: for each clock (`ERRORS`), one entry for each limit of the Act of 1714. None where
            a ship was unchecked for less than `LEAST_UNCHECKED_DAYS`, since the Act judges no such
            voyage, or where none arrived.
        quantiles_nmi: for each clock, the quantiles of the size of the error at QUANTILES; None if
            no ship arrived.
        influences: correlations of the drawn keys that are numbers, the strongest on the corrected
            clock first.
    """

    ships: int
    failures: dict[str, int]
    unchecked_days: tuple[float, float] | None
    within: dict[str, list[Within]] | None
    quantiles_nmi: dict[str, list[float] | None]
    influences: list[Influence]

    @property
    def answer(self) -> str:
        """How often the longitude was found within the Act's first limit, in a sentence; of a
        voyage that the Act does not judge, how large the errors are.
        """
        ships = counted(self.ships, 'ship')
        if self.within is not None:
            rated, dial = (self.within[name][0] for name in ('corrected', 'raw'))
            return (
                f'Of {ships} {percent(rated.share)} ({percent(rated.low)} to '
                f'{percent(rated.high)} with 95 % confidence) found their longitude within '
                f'{rated.limit_nmi:g} nautical miles by the rated clock, {percent(dial.share)} by '
                'the dial alone.'
            )
        by_rated, by_dial = (self.quantiles_nmi[name] for name in ('corrected', 'raw'))
        if by_rated is None or by_dial is None:
            return f'None of {ships} arrived.'
        lost = sum(self.failures.values())
        who = f'the {self.ships - lost} of {ships} that arrived' if lost else ships
        (half, most), (half_dial, most_dial) = (
            [figure(sizes[QUANTILES.index(share)], 'nmi').lstrip('<') for share in (0.5, 0.95)]
            for sizes in (by_rated, by_dial)
        )
        return (
            f'Of {who}, {self.unchecked()}, half are within {half} nautical miles by the rated '
            f'clock and 95 % within {most}; by the dial alone within {half_dial} and {most_dial}. '
            'That is no verdict: the Act of 1714 asks for six weeks.'
        )

    def unchecked(self) -> str:
        """Return for how long the clocks had not been checked, in words."""
        days = self.unchecked_days or (0.0, 0.0)
        if not any(days):
            return 'checked to the end'
        spans = dict.fromkeys(span(each * DAY_S) for each in days)
        return f'{" to ".join(spans)} unchecked'


def statistics_of(plan: Plan, rows: Sequence[dict[str, Any]]) -> Answers:
    """Return the statistics of a fleet from its rows, at least one."""
    arrived = Rows(row for row in rows if row['failure'] is None)
    errors = {name: np.array([row[key] for row in arrived]) for name, key in ERRORS.items()}
    sizes = {name: distances(arrived, name) for name in ERRORS}
    unchecked = [row['unchecked_days'] for row in arrived]
    judged = bool(arrived) and min(unchecked) >= LEAST_UNCHECKED_DAYS
    return Answers(
        ships=len(rows),
        failures=dict(failures_of(rows).most_common()),
        unchecked_days=(min(unchecked), max(unchecked)) if arrived else None,
        within={name: shares_within(rows, name) for name in ERRORS} if judged else None,
        quantiles_nmi={
            name: np.quantile(size, QUANTILES).tolist() if len(size) else None
            for name, size in sizes.items()
        },
        influences=_influences(plan, arrived, errors),
    )


def failures_of(rows: Iterable[Mapping[str, Any]]) -> Counter[str]:
    """Return the reasons for which voyages ended early, with their numbers."""
    return Counter(row['failure'] for row in rows if row['failure'] is not None)


def distances(rows: Sequence[dict[str, Any]], clock: str) -> FloatArray:
    """Return the distances of the ships' longitudes from the truth by a clock of ERRORS [nmi]."""
    return np.abs(np.array([row[ERRORS[clock]] for row in rows], np.float64))


def shares_within(rows: Sequence[dict[str, Any]], clock: str) -> list[Within]:
    """Return the shares of all ships within each limit of the Act by a clock of ERRORS."""
    sizes = distances(Rows(row for row in rows if row['failure'] is None), clock)
    found = []
    for limit_nmi, _ in AWARDS:
        count = int(np.count_nonzero(sizes <= limit_nmi))
        found.append(Within(limit_nmi, count, count / len(rows), *wilson(count, len(rows))))
    return found


def wilson(count: int, total: int) -> tuple[float, float]:
    """Return Wilson's interval, at 95 %, for the share of which `count` of `total` were seen."""
    from scipy.stats import binomtest

    interval = binomtest(count, total).proportion_ci(_CONFIDENCE, method='wilson')
    return float(interval.low), float(interval.high)


def _influences(
    plan: Plan, rows: Sequence[dict[str, Any]], errors: dict[str, FloatArray]
) -> list[Influence]:
    if len(rows) < LEAST_RANKED:
        return []
    found = []
    for key in plan.draws:
        values = [row[key] for row in rows]
        if all(isinstance(value, int | float) for value in values):
            raw, corrected = (_spearman(values, error) for error in errors.values())
            sizes = (_spearman(values, np.abs(error)) for error in errors.values())
            found.append(Influence(key, raw, corrected, *sizes))
    return sorted(found, key=lambda each: -each.strongest)


def _spearman(values: Sequence[float], errors: FloatArray) -> float | None:
    from scipy.stats import spearmanr

    if len(set(values)) < 2 or len(np.unique(errors)) < 2:
        return None
    return float(spearmanr(values, errors).statistic)


# -----------------------------------------------------------------------------
# A picture of a fleet: the distribution of the errors, and the keys with which they correlate.

_CLOCKS = {
    'raw': ('the dial as set', '#003f88'),
    'corrected': ('rated and corrected', '#c8553d'),
}
_LEAST_NMI = 0.01
"""Left end of the axis; below 20 m ships cannot be distinguished."""


def draw_fleet(fleet: Fleet, path: Path) -> None:
    """Draw a fleet that has sailed; replaces the file, .svg, .png or .pdf (`files.check_plot`)."""
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


def mark_prizes(axes: Axes) -> None:
    """Draw the limits of the prizes of 1714 over shares in per cent, with their pounds."""
    for limit, pounds in AWARDS:
        axes.axvline(limit, color='#777777', linewidth=0.8, linestyle=':')
        axes.annotate(
            f'{limit:g} nmi: £{pounds:,}',
            (limit, 2.0),
            rotation=90.0,
            ha='right',
            va='bottom',
            fontsize=7.0,
            color='#555555',
            zorder=3.0,  # above the curves, which may cross it
            bbox={'facecolor': 'white', 'edgecolor': 'none', 'alpha': 0.8, 'pad': 0.5},
        )


def _distribution(axes: Axes, fleet: Fleet) -> None:
    arrived = Rows(row for row in fleet.rows if row['failure'] is None)
    ships = len(fleet.rows)
    for clock, (label, colour) in _CLOCKS.items():
        # shares of all ships, so that one that failed is within no limit
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
    if judged:
        mark_prizes(axes)
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
