"""The answers of a trial: the share of passages on which each clock finds the longitude.

The dial alone, rated in harbour, and with thermometer and IMU; the ± of the wind and of the hull;
the effect of the navigator's error of local time; season and ocean; and ships in company.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from tauto_core.ensembles.answers import ERRORS, QUANTILES, failures_of, wilson
from tauto_core.ensembles.trials import Sailed, ocean_of_passage, season_of
from tauto_core.navigation.longitude import ARCMIN_PER_S, AWARDS, LEAST_UNCHECKED_DAYS
from tauto_core.results import drawn_by
from tauto_core.scene.errors import Argument, UsageError
from tauto_core.scene.sections import log_time, nautical_miles
from tauto_core.scene.times import DAY_S
from tauto_core.ship.coast import no_landfall
from tauto_core.ship.logbook import LoggedPassage
from tauto_core.wording import counted, percent

LOCAL_TIME_S = 4.0
"""Standard deviation of the local time that a navigator finds by the altitude of the sun [s]: a
minute of arc of the longitude."""

WAYS = {**ERRORS, 'sensed': 'sensed_error_nmi'}
"""Three ways of finding the longitude, with their columns: by the dial; by the dial less the rate
found in harbour; and corrected by thermometer and IMU as well.
"""

TRACED = {'raw': 'noon_raw_error_nmi', 'corrected': 'noon_error_nmi'}
"""Columns with the errors noon by noon."""


@dataclass(frozen=True)
class Prize:
    """Share of the passages of six weeks and more whose longitude was within a limit.

    A clock that failed counts as outside.

    Attributes:
        limit_nmi: limit of the Act of 1714.
        pounds: its sum.
        passages: number of passages within it.
        share: their share of all.
        low, high: Wilson's interval for the share of such passages, at 95 %.
        with_local_time: expected share if the navigator finds local time with an error, too.
        wind: root mean square change of the share with another random wind; None if it
            was not.
        hull: the same for the hull.
    """

    limit_nmi: float
    pounds: int
    passages: int
    share: float
    low: float
    high: float
    with_local_time: float
    wind: float | None
    hull: float | None

    @property
    def said(self) -> str:
        """The share with its interval, as text."""
        return f'{percent(self.share)} ({100.0 * self.low:.3g}–{percent(self.high)})'


@dataclass(frozen=True)
class Part:
    """The passages of one season or ocean.

    Attributes:
        name: of the season or the ocean.
        passages: number of passages of six weeks and more.
        within: how many of them are within each limit of the Act.
        median_nmi: median size of the error; None if none arrived.
    """

    name: str
    passages: int
    within: list[int]
    median_nmi: float | None


@dataclass(frozen=True)
class WayAnswers:
    """The answers of a clock in one of the three ways (`WAYS`).

    Attributes:
        prizes: one for each limit of the Act; empty without passages of six weeks.
        quantiles_nmi: quantiles of the size of the error on all passages at QUANTILES; None if
            none arrived.
        wind_nmi: median size of the change of a passage's error with another random wind;
            None if it was not.
        hull_nmi: the same for the hull.
        seasons: by the quarter of the year of the middle of the passage.
        oceans: by the ocean of most entries.
    """

    prizes: list[Prize]
    quantiles_nmi: list[float] | None
    wind_nmi: float | None
    hull_nmi: float | None
    seasons: list[Part]
    oceans: list[Part]


@dataclass(frozen=True)
class ClockAnswers:
    """The answers of a trial for one clock.

    Attributes:
        clock: name of its scene.
        scene: file or name that the user gave.
        failures: reasons for which voyages as logged ended early, with their numbers.
        stopped: number of passages as logged on which the clock stopped.
        ways: by the names of `WAYS`; without `sensed` where no rate equation fits the clock.
    """

    clock: str
    scene: str
    failures: dict[str, int]
    stopped: int
    ways: dict[str, WayAnswers]


@dataclass(frozen=True)
class Company:
    """Two ships that sailed together, each with the wind of her log.

    Attributes:
        passages: their names.
        days: days in company.
        differ_nmi: by how much the errors of each clock differ on the last of these days, by the
            name of the clock and the way [nmi].
    """

    passages: tuple[str, str]
    days: int
    differ_nmi: dict[str, dict[str, float]]


@dataclass(frozen=True)
class TrialAnswers:
    """The answers of a trial.

    Attributes:
        logs: file or name of the log-book.
        passages: number of passages.
        judged: number of those of six weeks and more, which the Act would judge.
        local_time_s: error of local time with which `Prize.with_local_time` reckons [s].
        wind_draws, hull_draws: number of repetitions with another random wind or hull.
        clocks: in the order of the trial.
        companies: ships in company.
        left_out: chosen passages that cannot be sailed, a mapping with `passage` and `problem`.
        voyages: a mapping for each clock on each passage, as logged; `ends` says where the last
            entry lies at sea, and is None elsewhere.
    """

    logs: str
    passages: int
    judged: int
    local_time_s: float
    wind_draws: int
    hull_draws: int
    clocks: list[ClockAnswers]
    companies: list[Company]
    left_out: list[dict[str, str]]
    voyages: list[dict[str, Any]]

    @property
    def answer(self) -> str:
        """On how many passages the first clock would have won the prize, in a sentence."""
        clock = self.clocks[0]
        passages = counted(self.judged, 'passage')
        rated, dial = clock.ways['corrected'], clock.ways['raw']
        if not rated.prizes:
            said = f'{counted(self.passages, "passage")} of {self.logs}: none of six weeks, '
            return f'{said}which the Act of 1714 asks for.'
        prize = rated.prizes[0]
        said = (
            f'On {prize.passages} of {passages} of six weeks and more {clock.clock} would have '
            f'found the longitude within {prize.limit_nmi:g} nautical miles when rated in '
            f'harbour: {prize.said}. By the dial alone on {dial.prizes[0].passages}'
        )
        if 'sensed' in clock.ways:
            said += f', with thermometer and IMU on {clock.ways["sensed"].prizes[0].passages}'
        return f'{said}.'

    def _repr_html_(self) -> str:
        return str(drawn_by('notebook', 'trial_html')(self))


def check_local_time(local_time_s: float) -> None:
    """Refuse an error of local time [s] that no navigator makes (UsageError)."""
    if not 0.0 <= local_time_s <= 3600.0:
        said = ': must lie between 0 and 3600 s. Use for example 4'
        raise UsageError(Argument('local_time', f'{local_time_s:g}'), said)


def answers_of(sailed: Sailed, local_time_s: float = LOCAL_TIME_S) -> TrialAnswers:
    """Return the answers of a trial; the navigator errs by `local_time_s` in his local time."""
    trial = sailed.trial
    passages = {each.name: each for each in trial.passages}
    ends = {name: no_landfall(*each.entries[-1][1:3]) for name, each in passages.items()}
    judged = {
        name for name, each in passages.items() if _days(sailed, each) >= LEAST_UNCHECKED_DAYS
    }
    clocks = []
    for clock in trial.rules.clocks:
        rows = [row for row in sailed.rows if row['clock'] == clock.name]
        logged = [row for row in rows if row['drawn'] == 'log']
        failures = dict(failures_of(logged))
        ways = {
            way: _way(rows, way, passages, judged, local_time_s)
            for way in WAYS
            if way != 'sensed' or clock.covariates
        }
        stopped = sum(row['stopped_s'] is not None for row in logged)
        clocks.append(ClockAnswers(clock.name, clock.origin, failures, stopped, ways))
    return TrialAnswers(
        logs=trial.logs,
        passages=len(passages),
        judged=len(judged),
        local_time_s=local_time_s,
        wind_draws=trial.wind_draws,
        hull_draws=trial.hull_draws,
        clocks=clocks,
        companies=list(_companies(sailed)),
        left_out=[{'passage': name, 'problem': str(why)} for name, why in trial.left_out],
        voyages=[
            _voyage(row, passages[row['passage']]) | {'ends': ends[row['passage']]}
            for row in sailed.rows
            if row['drawn'] == 'log'
        ],
    )


def _days(sailed: Sailed, passage: LoggedPassage) -> float:
    """Return the days at sea, which a shorter duration may have cut."""
    rules = sailed.trial.rules
    if rules.longest_s is None:
        return passage.days
    return min(passage.days, rules.longest_s / DAY_S - rules.harbour_days)


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


def size_nmi(row: dict[str, Any], way: str) -> float:
    """Return the size of an error, infinite where there is none [nmi]."""
    error = row[WAYS[way]]
    stopped = row['failure'] is not None or row['stopped_s'] is not None
    return math.inf if stopped or error is None else abs(error)


def _way(
    rows: Sequence[dict[str, Any]],
    way: str,
    passages: dict[str, LoggedPassage],
    judged: set[str],
    local_time_s: float,
) -> WayAnswers:
    logged = {row['passage']: row for row in rows if row['drawn'] == 'log'}
    tried = [row for name, row in logged.items() if name in judged]
    sizes = np.array([size_nmi(row, way) for row in logged.values()])
    finite = sizes[np.isfinite(sizes)]

    def part(name: str, of: Callable[[LoggedPassage], str]) -> Part:
        found = [size_nmi(row, way) for row in tried if of(passages[row['passage']]) == name]
        arrived = [size for size in found if math.isfinite(size)]
        within = [sum(size <= limit for size in found) for limit, _ in AWARDS]
        return Part(name, len(found), within, float(np.median(arrived)) if arrived else None)

    def parts(of: Callable[[LoggedPassage], str]) -> list[Part]:
        names = sorted({of(passages[row['passage']]) for row in tried})
        return [part(name, of) for name in names]

    return WayAnswers(
        prizes=list(_prizes(rows, tried, way, passages, local_time_s)),
        quantiles_nmi=np.quantile(finite, QUANTILES).tolist() if len(finite) else None,
        wind_nmi=_changes(rows, logged, way, 'wind'),
        hull_nmi=_changes(rows, logged, way, 'hull'),
        seasons=parts(season_of),
        oceans=parts(ocean_of_passage),
    )


def _prizes(
    rows: Sequence[dict[str, Any]],
    tried: Sequence[dict[str, Any]],
    way: str,
    passages: dict[str, LoggedPassage],
    local_time_s: float,
) -> Iterator[Prize]:
    if not tried:
        return
    from scipy.special import ndtr

    names = {row['passage'] for row in tried}
    sizes = np.array([size_nmi(row, way) for row in tried])
    latitudes = np.radians([passages[row['passage']].entries[-1][1] for row in tried])
    sights = np.maximum(ARCMIN_PER_S * local_time_s * np.cos(latitudes), 1e-9)
    for limit, pounds in AWARDS:
        count = int(np.count_nonzero(sizes <= limit))
        share = count / len(sizes)
        low, high = wilson(count, len(sizes))
        # the share of a normal error about each clock's own
        found = ndtr((limit - sizes) / sights) - ndtr((-limit - sizes) / sights)

        def spread(drawn: str, limit: float = limit, share: float = share) -> float | None:
            draws: dict[int, list[bool]] = {}
            for row in rows:
                if row['drawn'] == drawn and row['passage'] in names:
                    draws.setdefault(row['draw'], []).append(size_nmi(row, way) <= limit)
            apart = [float(np.mean(each)) - share for each in draws.values()]
            return float(np.sqrt(np.mean(np.square(apart)))) if apart else None

        expected = float(np.mean(found))
        yield Prize(
            limit, pounds, count, share, low, high, expected, spread('wind'), spread('hull')
        )


def _changes(
    rows: Sequence[dict[str, Any]], logged: dict[str, dict[str, Any]], way: str, drawn: str
) -> float | None:
    """Return the median size of the change of the error by a draw [nmi]; None without any."""
    column = WAYS[way]
    pairs = [
        (row[column], logged[row['passage']][column]) for row in rows if row['drawn'] == drawn
    ]
    apart = [abs(one - other) for one, other in pairs if None not in (one, other)]
    return float(np.median(apart)) if apart else None


# -----------------------------------------------------------------------------
# Ships in company: the same sea, recorded by two logs.

NEAR_NMI = 25.0
"""Distance at noon within which two ships are in company."""

LEAST_DAYS = 5
"""Least days in company of two ships that are compared."""

SAILED_WITHIN_DAYS = 3.0
"""Largest time between their first entries: both clocks have then been at sea as long."""


def _companies(sailed: Sailed) -> Iterator[Company]:
    """Yield the pairs of passages that were sailed in company."""
    rows = {(row['clock'], row['passage']): row for row in sailed.rows if row['drawn'] == 'log'}
    clocks = [clock.name for clock in sailed.trial.rules.clocks]
    for one, other in combinations(sailed.trial.passages, 2):
        begins = [log_time(each.entries[0][0]) for each in (one, other)]
        if abs((begins[1] - begins[0]).total_seconds()) > SAILED_WITHIN_DAYS * DAY_S:
            continue
        noons = {entry[0][:10]: index for index, entry in enumerate(other.entries)}
        together = [
            (index, noons[entry[0][:10]])
            for index, entry in enumerate(one.entries)
            if entry[0][:10] in noons
            and nautical_miles(entry[1:3], other.entries[noons[entry[0][:10]]][1:3]) <= NEAR_NMI
        ]
        if len(together) < LEAST_DAYS:
            continue
        first, second = together[-1]
        differ: dict[str, dict[str, float]] = {}
        for clock in clocks:
            ours, theirs = rows[clock, one.name], rows[clock, other.name]
            for way, column in TRACED.items():
                if first < len(ours[column]) and second < len(theirs[column]):
                    apart = ours[column][first] - theirs[column][second]
                    differ.setdefault(clock, {})[way] = apart
        yield Company((one.name, other.name), len(together), differ)
