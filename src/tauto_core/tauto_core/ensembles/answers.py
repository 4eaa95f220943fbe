"""The statistics of fleets and trials: how often the longitude was found, and the errors.

A fleet also has the correlations of its drawn keys with the errors. A trial compares three ways
of navigating (`WAYS`), seasons and oceans.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tauto_core.ensembles.rows import has_arrived
from tauto_core.ensembles.trials import Trial, ocean_of_passage, season_of
from tauto_core.navigation.longitude import AWARDS, LEAST_UNCHECKED_DAYS
from tauto_core.results import drawn_by
from tauto_core.samples import FloatArray
from tauto_core.scene.times import DAY_S
from tauto_core.ship.coast import no_landfall
from tauto_core.ship.logbook import LoggedPassage
from tauto_core.wording import counted, figure, percent, span

_CONFIDENCE = 0.95
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
LEAST_RANKED = 10
"""Least number of voyages for a correlation."""

ERRORS = {'raw': 'raw_error_nmi', 'corrected': 'error_nmi'}
"""Two ways of finding the longitude and their columns: the dial alone, and the dial corrected for
the estimated drift.
"""


class _Share:
    share: float
    low: float
    high: float

    @property
    def said(self) -> str:
        """The share with its interval, as text."""
        return f'{percent(self.share)} ({100.0 * self.low:.3g}–{percent(self.high)})'


@dataclass(frozen=True)
class Portion(_Share):
    """Share of all ships with a longitude within a limit.

    A ship that failed, or lost its clock, counts as outside.

    Attributes:
        limit_nmi: limit of the Act of 1714.
        ships: number of ships within it.
        share: their share of all.
        low, high: Wilson's interval of the share, at 95 %.
    """

    limit_nmi: float
    ships: int
    share: float
    low: float
    high: float


@dataclass(frozen=True)
class Influence:
    """The correlation of a drawn key with the error.

    A key that shifts the error, such as a tolerance, correlates with the error but not with its
    size. A key that only scatters the error, such as the noise of an observation, correlates with
    the size only.

    Attributes:
        key: path in the scene.
        raw, corrected: Spearman's rank correlation, −1 to 1, with the error of the dial and of the
            corrected clock, positive to the east. It is `None` if either is constant.
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
        failures: reasons why voyages ended early or clocks stopped, with their numbers.
        unchecked_days: least and most time since a clock was last checked when its longitude was
            judged, `None` if no ship arrived.
        within: for each clock (`ERRORS`), one entry for each limit of the Act of 1714. `None` if a
            ship was unchecked for less than `LEAST_UNCHECKED_DAYS`, when the Act does not apply,
            or if no ship arrived.
        quantiles_nmi: for each clock, the quantiles of the size of the error at QUANTILES, `None`
            if no ship arrived.
        influences: correlations of the numeric drawn keys, the strongest on the corrected clock
            first.
    """

    ships: int
    failures: dict[str, int]
    unchecked_days: tuple[float, float] | None
    within: dict[str, list[Portion]] | None
    quantiles_nmi: dict[str, list[float] | None]
    influences: list[Influence]

    @property
    def answer(self) -> str:
        """How often the longitude was found within the Act's first limit, in a sentence. If the
        Act does not apply: how large the errors are.
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
        (median, q95), (half_dial, most_dial) = (
            [figure(sizes[QUANTILES.index(share)], 'nmi').lstrip('<') for share in (0.5, 0.95)]
            for sizes in (by_rated, by_dial)
        )
        return (
            f'Of {who}, {self.unchecked()}, half are within {median} nautical miles by the rated '
            f'clock and 95 % within {q95}; by the dial alone within {half_dial} and {most_dial}. '
            'That is no verdict: the Act of 1714 asks for six weeks.'
        )

    def unchecked(self) -> str:
        """Return for how long the clocks had not been checked, in words."""
        days = self.unchecked_days or (0.0, 0.0)
        if not any(days):
            return 'checked to the end'
        spans = dict.fromkeys(span(day * DAY_S) for day in days)
        return f'{" to ".join(spans)} unchecked'


def statistics_of(rows: Sequence[dict[str, Any]], drawn: Iterable[str] = ()) -> Answers:
    """Return the statistics of a fleet from at least one row and its drawn keys."""
    arrived = list(filter(has_arrived, rows))
    errors = {name: np.array([row[key] for row in arrived]) for name, key in ERRORS.items()}
    unchecked = [row['unchecked_days'] for row in arrived]
    judged = bool(unchecked) and min(unchecked) >= LEAST_UNCHECKED_DAYS
    stopped = sum(row['stopped_s'] is not None for row in rows)
    failures = failures_of(rows) + Counter({'the clock stopped': stopped})
    return Answers(
        ships=len(rows),
        failures=dict(failures.most_common()),
        unchecked_days=(min(unchecked), max(unchecked)) if unchecked else None,
        within={name: shares_within(sizes_nmi(rows, key)) for name, key in ERRORS.items()}
        if judged
        else None,
        quantiles_nmi={name: _quantiles(np.abs(error)) for name, error in errors.items()},
        influences=_influences(drawn, arrived, errors),
    )


def failures_of(rows: Iterable[Mapping[str, Any]]) -> Counter[str]:
    """Return the reasons why voyages ended early, with their numbers."""
    return Counter(row['failure'] for row in rows if row['failure'] is not None)


def sizes_nmi(rows: Iterable[Mapping[str, Any]], column: str) -> FloatArray:
    """Return the sizes of errors [nmi], infinite if a clock did not arrive or has no error."""
    sizes = (
        abs(row[column]) if has_arrived(row) and row[column] is not None else math.inf
        for row in rows
    )
    return np.fromiter(sizes, np.float64)


def _quantiles(sizes: FloatArray) -> list[float] | None:
    finite = sizes[np.isfinite(sizes)]
    return np.quantile(finite, QUANTILES).tolist() if len(finite) else None


def shares_within(sizes: FloatArray) -> list[Portion]:
    """Return the shares of all ships within each limit of the Act, from `sizes_nmi`."""
    counts = [(limit, int(np.count_nonzero(sizes <= limit))) for limit, _ in AWARDS]
    total = len(sizes)
    return [Portion(limit, count, count / total, *wilson(count, total)) for limit, count in counts]


def wilson(count: int, total: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share of which `count` of `total` were observed."""
    from scipy.stats import binomtest

    interval = binomtest(count, total).proportion_ci(_CONFIDENCE, method='wilson')
    return float(interval.low), float(interval.high)


def _influences(
    drawn: Iterable[str], rows: Sequence[dict[str, Any]], errors: dict[str, FloatArray]
) -> list[Influence]:
    if len(rows) < LEAST_RANKED:
        return []
    influences = []
    for key in drawn:
        values = [row[key] for row in rows]
        if all(isinstance(value, int | float) for value in values):
            raw, corrected = (_spearman(values, error) for error in errors.values())
            sizes = (_spearman(values, np.abs(error)) for error in errors.values())
            influences.append(Influence(key, raw, corrected, *sizes))
    return sorted(influences, key=lambda item: -item.strongest)


def _spearman(values: Sequence[float], errors: FloatArray) -> float | None:
    from scipy.stats import spearmanr

    if len(set(values)) < 2 or len(np.unique(errors)) < 2:
        return None
    return float(spearmanr(values, errors).statistic)


# -----------------------------------------------------------------------------
# The answers of a trial.

WAYS = {**ERRORS, 'sensed': 'sensed_error_nmi'}
"""Three ways of finding the longitude and their columns: the dial alone, the dial corrected for
the rate in harbour, and corrected by thermometer and IMU as well.
"""


@dataclass(frozen=True)
class Prize(_Share):
    """Share of the passages of six weeks and more with a longitude within a limit.

    A clock that failed counts as outside.

    Attributes:
        limit_nmi: limit of the Act of 1714.
        pounds: prize for this limit.
        passages: number of passages within it.
        share: their share of all.
        low, high: Wilson's interval of the share, at 95 %.
    """

    limit_nmi: float
    pounds: int
    passages: int
    share: float
    low: float
    high: float


@dataclass(frozen=True)
class Part:
    """The passages of one season or ocean.

    Attributes:
        name: of the season or the ocean.
        passages: number of passages of six weeks and more.
        within: how many of them are within each limit of the Act.
        median_nmi: median size of the error, `None` if no clock arrived.
    """

    name: str
    passages: int
    within: list[int]
    median_nmi: float | None


@dataclass(frozen=True)
class WayAnswers:
    """The answers for a clock and one of the three `WAYS`.

    Attributes:
        prizes: one for each limit of the Act, empty without passages of six weeks.
        quantiles_nmi: quantiles of the size of the error on all passages at QUANTILES, `None` if
            no clock arrived.
        seasons: by the season of the middle of the passage.
        oceans: by the ocean of most entries.
    """

    prizes: list[Prize]
    quantiles_nmi: list[float] | None
    seasons: list[Part]
    oceans: list[Part]


@dataclass(frozen=True)
class ClockAnswers:
    """The answers of a trial for one clock.

    Attributes:
        clock: name of its scene.
        scene: file or name that the user gave.
        failures: reasons why voyages ended early, with their numbers.
        stopped: number of passages on which the clock stopped.
        ways: by the names of `WAYS`, without `sensed` if no rate equation fits the clock.
    """

    clock: str
    scene: str
    failures: dict[str, int]
    stopped: int
    ways: dict[str, WayAnswers]


@dataclass(frozen=True)
class TrialAnswers:
    """The answers of a trial.

    Attributes:
        logs: file or name of the log-book.
        passages: number of passages.
        judged: number of passages of six weeks and more, which the Act would judge.
        clocks: in the order of the trial.
        left_out: chosen passages that cannot be sailed, a mapping with `passage` and `problem`.
        voyages: a mapping for each clock on each passage; `ends` describes a last entry
            at sea, otherwise it is `None`.
        keys_left_out: keys of the first scene that the log replaces.
    """

    logs: str
    passages: int
    judged: int
    clocks: list[ClockAnswers]
    left_out: list[dict[str, str]]
    voyages: list[dict[str, Any]]
    keys_left_out: tuple[str, ...] = ()

    @property
    def answer(self) -> str:
        """On how many passages the first clock would have won the prize, in a sentence."""
        clock = self.clocks[0]
        passages = counted(self.judged, 'passage')
        rated, dial = clock.ways['corrected'], clock.ways['raw']
        if not rated.prizes:
            sentence = f'{counted(self.passages, "passage")} of {self.logs}: none of six weeks, '
            return f'{sentence}which the Act of 1714 asks for.'
        prize = rated.prizes[0]
        sentence = (
            f'On {prize.passages} of {passages} of six weeks and more {clock.clock} would have '
            f'found the longitude within {prize.limit_nmi:g} nautical miles when rated in '
            f'harbour: {prize.said}. By the dial alone on {dial.prizes[0].passages}'
        )
        if 'sensed' in clock.ways:
            sentence += f', with thermometer and IMU on {clock.ways["sensed"].prizes[0].passages}'
        return f'{sentence}.'

    def _repr_html_(self) -> str:
        return str(drawn_by('notebook', 'trial_html')(self))


def answers_of(trial: Trial, rows: Sequence[dict[str, Any]]) -> TrialAnswers:
    """Return the answers of a trial from its rows."""
    passages = {passage.name: passage for passage in trial.passages}
    ends = {name: no_landfall(*passage.entries[-1][1:3]) for name, passage in passages.items()}
    cut_s = trial.longest_s
    # days at sea, which a shorter duration may have cut
    longest = math.inf if cut_s is None else cut_s / DAY_S - trial.harbour_days
    judged = {
        name
        for name, passage in passages.items()
        if min(passage.days, longest) >= LEAST_UNCHECKED_DAYS
    }
    clocks = []
    for clock in trial.clocks:
        own = [row for row in rows if row['clock'] == clock.name]
        ways = {
            way: _way(own, column, passages, judged)
            for way, column in WAYS.items()
            if way != 'sensed' or clock.covariates
        }
        stopped = sum(row['stopped_s'] is not None for row in own)
        failures = dict(failures_of(own))
        clocks.append(ClockAnswers(clock.name, clock.origin, failures, stopped, ways))
    return TrialAnswers(
        logs=trial.logs,
        passages=len(passages),
        judged=len(judged),
        clocks=clocks,
        left_out=[{'passage': name, 'problem': str(why)} for name, why in trial.left_out],
        voyages=[
            _voyage(row, passages[row['passage']]) | {'ends': ends[row['passage']]} for row in rows
        ],
    )


def _voyage(row: dict[str, Any], passage: LoggedPassage) -> dict[str, Any]:
    return {
        'passage': passage.name,
        'ship': passage.ship,
        'from': passage.sailed_from,
        'to': passage.bound_to,
        'first_utc': passage.entries[0][0],
        'days': passage.days,
        'season': season_of(passage),
        'ocean': ocean_of_passage(passage),
        'clock': row['clock'],
        **{key: row[key] for key in WAYS.values()},
        'stopped_s': row['stopped_s'],
        'failure': row['failure'],
    }


def _way(
    rows: Sequence[dict[str, Any]],
    column: str,
    passages: dict[str, LoggedPassage],
    judged: set[str],
) -> WayAnswers:
    sample = [row for row in rows if row['passage'] in judged]

    def parts(of: Callable[[LoggedPassage], str]) -> list[Part]:
        groups: dict[str, list[dict[str, Any]]] = {}
        for row in sample:
            groups.setdefault(of(passages[row['passage']]), []).append(row)
        return [_part(name, sizes_nmi(groups[name], column)) for name in sorted(groups)]

    shares = zip(shares_within(sizes_nmi(sample, column)) if sample else [], AWARDS, strict=False)
    return WayAnswers(
        prizes=[
            Prize(share.limit_nmi, pounds, share.ships, share.share, share.low, share.high)
            for share, (_, pounds) in shares
        ],
        quantiles_nmi=_quantiles(sizes_nmi(rows, column)),
        seasons=parts(season_of),
        oceans=parts(ocean_of_passage),
    )


def _part(name: str, sizes: FloatArray) -> Part:
    arrived = sizes[np.isfinite(sizes)]
    counts = [int(np.count_nonzero(sizes <= limit)) for limit, _ in AWARDS]
    return Part(name, len(sizes), counts, float(np.median(arrived)) if len(arrived) else None)
