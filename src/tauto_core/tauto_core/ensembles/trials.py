"""Trials: clocks sent along the passages of a log-book, in the seas that the logged winds raise.

The choice of passages, the voyage of several clocks in one sea, and the answers: three ways of
navigating (`WAYS`), by season and by ocean.
"""

from __future__ import annotations

import copy
import hashlib
import math
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from tauto_core import voyage
from tauto_core.checks.cost import work_s
from tauto_core.checks.readiness import check_known
from tauto_core.ensembles.comparison import (
    CLOCKS,
    ClockInSea,
    Sea,
    on_passage_of,
    refuse_same_names,
    with_rate,
)
from tauto_core.ensembles.rows import (
    ENDED,
    ERRORS,
    FIGURE_TYPES,
    Columns,
    Proportion,
    Row,
    Voyages,
    failures_of,
    quantiles_of,
    sail,
    shares_within,
    sizes_nmi,
)
from tauto_core.ensembles.workers import versions
from tauto_core.navigation import DriftStage, LongitudeStage, LongitudeTally
from tauto_core.navigation.covariates import coefficients
from tauto_core.navigation.longitude import AWARDS, LEAST_UNCHECKED_DAYS
from tauto_core.navigation.regressors import SHAKEN_BY
from tauto_core.results import drawn_by
from tauto_core.samples import (
    LONGITUDE_ERROR,
    OBSERVATION,
    READING,
    SHIP_FIX,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    Batches,
    FloatArray,
    JointSamples,
    merged,
)
from tauto_core.scene import Scene, load_scene, scene_yaml
from tauto_core.scene.errors import (
    ABSENT,
    Argument,
    ArgumentText,
    Problem,
    SceneError,
    UsageError,
    naming,
)
from tauto_core.scene.loader import checked_scene, origin_of, read_mapping
from tauto_core.scene.sections import has_wind, log_time
from tauto_core.scene.tables import missing_file
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.ship.coast import no_landfall, ocean_of
from tauto_core.ship.logbook import (
    OF_THE_BOX,
    OF_THE_SEA,
    LoggedPassage,
    read_passages,
    scene_of_passage,
)
from tauto_core.ship.passage import Passage
from tauto_core.ship.sampling import rate_under_way
from tauto_core.wording import counted

# -----------------------------------------------------------------------------
# The choice of passages from a log-book.


SIX_WEEKS = LEAST_UNCHECKED_DAYS, math.inf
"""Lengths of the passages that the Act of 1714 would judge [days]."""


def is_wanted(
    passage: LoggedPassage,
    days: tuple[float, float] = SIX_WEEKS,
    years: tuple[float, float] = (0.0, math.inf),
) -> bool:
    """Return whether a passage has a wanted length, and year of its first entry.

    One whose length is unknown is wanted.
    """
    try:
        year = log_time(passage.entries[0][0]).year
    except ValueError:
        return True  # so that it is refused with its name and row
    has_problem = next(passage.problems(), None) is not None
    return years[0] <= year <= years[1] and (has_problem or days[0] <= passage.days <= days[1])


def ocean_of_passage(passage: LoggedPassage) -> str:
    """Return the ocean of most entries of a passage."""
    counts = Counter(
        ocean_of(latitude, longitude) for _, latitude, longitude, *_ in passage.entries
    )
    return counts.most_common(1)[0][0] if counts else ''


SEASONS = ('December to February', 'March to May', 'June to August', 'September to November')


def season_of(passage: LoggedPassage) -> str:
    """Return the season of the middle entry of a passage (`SEASONS`)."""
    month = log_time(passage.entries[len(passage.entries) // 2][0]).month
    return SEASONS[month % 12 // 3]


# -----------------------------------------------------------------------------
# The plan of a trial.

_STREAM = 4
"""Number of the random streams of passages, from the scene's seed."""

ANY_RATE_HZ = 10.0
"""A provisional `ship.rate` of scenes until theirs is known [Hz]."""


@dataclass(frozen=True)
class TriedClock:
    """A clock of a trial.

    Attributes:
        origin: file or name that the user gave.
        name: name of its scene.
        content: the scene's mapping without the keys that a log sets.
        covariates: `drift.covariates` of the navigator with thermometer and IMU, empty if no rate
            equation fits the clock.
        priors: their `drift.coefficients`, estimated once.
        why_unsensed: why there are no covariates.
    """

    origin: str
    name: str
    content: Mapping[str, Any]
    covariates: tuple[str, ...] = ()
    priors: Mapping[str, Any] | None = None
    why_unsensed: str = ''


Sailing: TypeAlias = tuple[int, LoggedPassage]
"""A passage to be sailed by all clocks of a trial, with its place in the log-book from 0."""


@dataclass(frozen=True)
class Trial:
    """A trial: the clocks on each passage.

    Attributes:
        logs: file or name that the user gave.
        clocks: clocks that share ship and passage.
        seed: seeds the seas and observations, together with the passage's name.
        harbour_days: days of rating in still water before the first entry, an assumption.
        longest_s: length to which a scene is cut [s]. `None`: the log's.
        passages: the chosen passages that can be sailed.
        left_out: chosen passages that cannot be sailed, with their problems.
        anyway: sail machines and ships larger than any known, too.
    """

    logs: str
    clocks: tuple[TriedClock, ...]
    seed: int
    harbour_days: float
    longest_s: float | None = None
    passages: tuple[LoggedPassage, ...] = ()
    left_out: tuple[tuple[str, Problem], ...] = ()
    anyway: bool = False

    def scene(
        self, clock: TriedClock, passage: LoggedPassage, *, rate_hz: float | None = None
    ) -> Scene:
        """Return the scene of a clock on a passage.

        `rate_hz` replaces the `ship.rate` that `solver.accuracy` requires; for fixed clocks with
        an escapement that is `rate_under_way`.
        """
        content = scene_of_passage(copy.deepcopy(dict(clock.content)), passage, self.harbour_days)
        name = passage.name.encode()
        seeds = np.random.SeedSequence(self.seed, spawn_key=(_STREAM, len(name), *name))
        content['seed'] = int(seeds.generate_state(1, np.uint64)[0] >> np.uint64(1))
        if self.longest_s is not None:
            content['duration'] = self.longest_s
        goes = content.get('escapement') is not None and content.get('suspension') is None
        follows = goes and rate_hz is None and 'rate' not in content['ship']
        if rate_hz is not None or follows:
            content['ship']['rate'] = rate_hz or ANY_RATE_HZ
        try:
            scene = checked_scene(content, clock.origin)
            if not self.anyway:
                check_known(scene)
        except SceneError as error:
            wrong, *further = error.problems
            place = f'passage {passage.name}, {wrong.key}'
            raise SceneError(
                clock.origin, place, wrong.value, wrong.problem, wrong.remedy, further=further
            ) from None
        if follows and scene.accuracy is not None:
            scene = with_rate(scene, rate_under_way(scene, scene.ship, scene.accuracy))
        return scene

    @cached_property
    def sailings(self) -> tuple[Sailing, ...]:
        """All passages to be sailed.

        Their order is random (from the seed), so a trial that ends early has sailed a random
        sample of its passages.
        """
        count = len(self.passages)
        seeds = np.random.SeedSequence(self.seed, spawn_key=(_STREAM, 0, count))
        order = np.random.Generator(np.random.PCG64(seeds)).permutation(count).tolist()
        return tuple((place, self.passages[place]) for place in order)

    def identity(self) -> dict[str, Any]:
        """Return everything that determines the rows."""
        entries = [[passage.name, *map(list, passage.entries)] for passage in self.passages]
        return {
            'clocks': [dict(clock.content) for clock in self.clocks],
            'logs': hashlib.sha256(repr(entries).encode()).hexdigest(),
            'passages': len(self.passages),
            'rules': {
                'seed': self.seed,
                'harbour_days': self.harbour_days,
                'longest_s': self.longest_s,
            },
            'versions': versions(),
        }

    def check(self) -> None:
        """Refuse passages that make no valid scene."""
        for passage in self.passages:
            for clock in self.clocks:
                # the `ship.rate` for an accuracy takes a hundred times as long as the rest
                scene = self.scene(clock, passage, rate_hz=ANY_RATE_HZ)
                assert scene.voyage is not None
                with naming(self.logs, f'passage {passage.name}'):
                    Passage(scene, scene.voyage)


def make_trial(
    logs: str,
    scenes: Sequence[tuple[str, Scene]],
    *,
    days: tuple[float, float] = SIX_WEEKS,
    years: tuple[float, float] = (0.0, math.inf),
    sample: int | None = None,
    progress: Callable[[float], None] | None = None,
    harbour_days: float = 14.0,
    longest_s: float | None = None,
    skip_wrong: bool = False,
    anyway: bool = False,
) -> Trial:
    """Read the log-book and return the trial of clocks that share a ship, see `tauto.trial`.

    `scenes` are the clocks, with their names as the user gave them. A voyage is cut to `longest_s`
    [s], and `progress` takes the fraction of the log-book that has been read.

    Raises:
        UsageError: no such file or passages, numbers out of range, or two clocks of one name.
        SceneError: chosen passages that cannot be sailed, each with its rows, or a clock that
            cannot be rated as its scene says.
    """
    for problem in missing_file('logs', logs, folders=True):
        raise UsageError(Argument('logs', logs), f': {problem.problem}. {problem.remedy}')
    refuse_same_names(scenes)
    if sample is not None and sample < 1:
        raise UsageError(Argument('sample', sample), ': must be at least 1. Name more')
    count, chosen, wrong = 0, list[LoggedPassage](), list[tuple[str, Problem]]()
    for passage in read_passages(logs, progress=progress):
        count += 1
        if not is_wanted(passage, days, years):
            continue
        fault = next(passage.problems(), None)
        if fault is None and not any(map(has_wind, passage.entries)):
            key = f'passage {passage.name}, wind_mps'
            fault = Problem(key, ABSENT, 'has no wind to make a sea', 'Give it some.')
        if fault is not None:
            wrong.append((passage.name, fault))
        if fault is None or not skip_wrong:
            chosen.append(passage)
    if not chosen:
        raise UsageError(
            f'{logs}: none of its {count} passages matches. List them with `tauto logbook`'
        )
    if sample is not None and sample < len(chosen):
        places = np.linspace(0, len(chosen) - 1, sample).round().astype(int)
        chosen = [chosen[place] for place in places]
    if wrong and not skip_wrong:
        (_, problem), *tail = wrong
        skip = ArgumentText('Correct them, or leave them out with ', _SKIP, '.')
        text = f'{counted(len(wrong), "passage")} cannot be sailed'
        further = [*(fault for _, fault in tail), Problem('', ABSENT, text, skip)]
        raise SceneError(
            logs, problem.key, problem.value, problem.problem, problem.remedy, further=further
        )
    plain = Trial(
        logs,
        tuple(TriedClock(origin, scene.name, _content(scene, origin)) for origin, scene in scenes),
        scenes[0][1].seed,
        harbour_days,
        longest_s,
        tuple(chosen),
        tuple(wrong),
        anyway,
    )
    typical = chosen[len(chosen) // 2]
    sensed = tuple(_sensed(plain, clock, typical) for clock in plain.clocks)
    return replace(plain, clocks=sensed)


_SKIP = Argument('skip_wrong', value=True)


def replaced_by_log(scene: Scene) -> tuple[str, ...]:
    """Return the keys of a scene that a trial replaces by the log's."""
    ship, own = scene.ship.model_fields_set, scene.air
    keys = [f'ship.{key}' for key in (*OF_THE_SEA, 'weather') if key in ship]
    air = () if own is None else own.model_fields_set
    keys += [f'air.{key}' for key in air if key not in ('kind', *OF_THE_BOX)]
    keys += ['clock.nominal_period'] * (scene.clock.nominal_period is not None)
    return (*keys, *['voyage'] * (scene.voyage is not None))


def clocks_beside(
    scene: Scene, origin: str, clocks: Sequence[str | Path | Scene]
) -> list[tuple[str, Scene]]:
    """Return further clocks (scenes, files or built-in names), fixed to the ship of a scene.

    The name `clocks` means all `CLOCKS`.
    """
    result = []
    for clock in (each for item in clocks for each in (CLOCKS if item == 'clocks' else [item])):
        own_scene = load_scene(clock, **{'solver.accuracy': scene.accuracy})
        alone, name = own_scene.model_copy(update={'suspension': None}), origin_of(clock)
        result.append((name, on_passage_of(name, alone, scene, origin)))
    return result


def _content(scene: Scene, origin: str) -> dict[str, Any]:
    """Return the mapping of a clock's scene without the keys that each passage sets."""
    content = read_mapping(scene_yaml(scene), origin)
    content.get('clock', {}).pop('nominal_period', None)
    if scene.accuracy is not None:
        content['ship'].pop('rate', None)
    return content


def _sensed(trial: Trial, clock: TriedClock, typical: LoggedPassage) -> TriedClock:
    """Return the clock with its covariates and their priors, estimated on one passage only."""
    content = {**clock.content, 'drift': dict(clock.content.get('drift') or {})}
    keys = content['drift'].pop('covariates', None)
    priors = content['drift'].pop('coefficients', None)
    plain = replace(clock, content=content)
    scene = trial.scene(plain, typical)
    names = tuple(keys or [*SHAKEN_BY, 'gravity', *['temperature'] * (scene.air is not None)])
    try:
        terms = coefficients(_with_covariates(scene, names, priors))
    except SceneError as error:
        if keys is not None:
            raise
        return replace(plain, why_unsensed=error.problem)
    stated = {term.name: {'value': term.value, 'sigma': term.sigma} for term in terms}
    return replace(plain, covariates=names, priors=stated)


def _with_covariates(
    scene: Scene, names: Sequence[str], priors: Mapping[str, Any] | None
) -> Scene:
    keys = {**scene.drift.model_dump(exclude_none=True), 'covariates': tuple(names)}
    drift = type(scene.drift).model_validate({**keys, 'coefficients': priors})
    return scene.model_copy(update={'drift': drift})


# -----------------------------------------------------------------------------
# A passage, sailed by all clocks in one sea: one row for each.

SENSED = {'sensed_error_nmi': 'error_nmi', 'sensed_sigma_nmi': 'sigma_nmi'}
"""Columns of the navigator with thermometer and IMU, and their keys in `LongitudeTally.result`."""


class _Tried(ClockInSea):
    def __init__(self, clock: TriedClock, scene: Scene, origin: str, sea: Sea) -> None:
        super().__init__(scene, origin, sea, rated=True)
        self.clock = clock
        self._tally = LongitudeTally()
        self._sensed: voyage.Pipeline | None = None
        if clock.covariates:
            rated = _with_covariates(self.scene, clock.covariates, clock.priors)
            drift = DriftStage(rated, motion=sea.integrals(rated))
            self._sensed = voyage.Pipeline([drift, LongitudeStage(rated)])
        voyage_log = self.scene.voyage and self.scene.voyage.log
        assert voyage_log
        noons = [self.scene.starts_at_ns + round(NS_PER_S * at) for at in voyage_log.at]
        self._noons = np.array(noons, np.int64)
        self._trace = list[float]()

    def keep(self, batches: Batches) -> None:
        """Take the errors at noon, and run the navigator with thermometer and IMU."""
        errors = batches.get(LONGITUDE_ERROR)
        if isinstance(errors, JointSamples) and len(errors.stamp_ns):
            # an entry beyond this batch waits for the next batch
            noons = self._noons[len(self._trace) :]
            noons = noons[noons <= errors.stamp_ns[-1]]
            rows = np.maximum(np.searchsorted(errors.stamp_ns, noons, 'right') - 1, 0)
            self._trace += errors.position[rows, errors.name.index('error_nmi')].tolist()
        if self._sensed is None:
            return
        out = self._sensed.feed({topic: batches[topic] for topic in batches if topic in _TOPICS})
        if self.at_end:
            out = merged([out, self._sensed.finish()])
        self._tally.feed(out)

    def figures(self) -> dict[str, Any]:
        """Return the figures of its row, also by the navigator with thermometer and IMU."""
        sensed = (self._tally.result() if self.ended is None else None) or {}
        figures = {name: sensed.get(key) for name, key in SENSED.items()}
        return {**super().figures(), **figures, 'noon_error_nmi': self._trace}


_TOPICS = (SHIP_IMU, SHIP_FIX, SHIP_TEMPERATURE, OBSERVATION, READING)
"""Topics that a navigator reads."""


def sail_passage(trial: Trial, sailing: Sailing, progress: Callable[[float], None]) -> list[Row]:
    """Sail all clocks along one passage in the same sea and return their rows.

    An event that ends the motion of a clock is a result, and the other clocks go on. `run_s` is
    the clock's own processor time plus an equal share of the sea's. A scene that cannot be sailed
    is a SceneError.
    """
    began = time.thread_time()
    number, passage = sailing
    scenes, rates_hz = list[Scene](), dict[str, float]()
    for clock in trial.clocks:
        # clocks of the same kind on the same ship need the same rate
        kind = repr([clock.content.get(key) for key in ('ship', 'solver', 'log', 'suspension')])
        kind += str('escapement' in clock.content)
        scenes.append(trial.scene(clock, passage, rate_hz=rates_hz.get(kind)))
        rates_hz[kind] = scenes[-1].ship.rate
    scenes = [with_rate(scene, max(rates_hz.values())) for scene in scenes]
    origins = [f'{clock.origin}, passage {passage.name}' for clock in trial.clocks]
    sea = Sea(scenes, origins)
    of_clocks = zip(trial.clocks, scenes, origins, strict=True)
    afloat = [_Tried(clock, scene, origin, sea) for clock, scene, origin in of_clocks]
    sea.sail(afloat, began, progress)
    return [
        {
            'ship': number * len(afloat) + place,
            'clock': entry.clock.name,
            'passage': passage.name,
            'seed': entry.scene.seed,
            **entry.figures(),
        }
        for place, entry in enumerate(afloat)
    ]


COLUMNS: Columns = {
    'ship': int,
    'clock': str,
    'passage': str,
    'seed': int,
    **FIGURE_TYPES,
    **dict.fromkeys(SENSED, float),
    'noon_error_nmi': list,  # at each entry of the log
    **ENDED,
}
"""Columns of the rows of a trial."""


def sail_trial(
    trial: Trial,
    jobs: int,
    out: Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Row]:
    """Sail a trial, or the rest of it, as `rows.sail` does, and return its rows by their numbers.

    Invalid passages are refused first.
    """
    trial.check()
    count = len(trial.clocks)
    plan = Voyages(
        partial(sail_passage, replace(trial, passages=(), left_out=())),
        trial.sailings,
        lambda sailing: f'passage {sailing[1].name}',
        lambda sailing: count * work_s(trial.scene(trial.clocks[0], sailing[1])),
        clocks=count,
        number=lambda sailing: sailing[0],
        columns=COLUMNS,
        identity=trial.identity(),
    )
    return sail(plan, jobs, out, progress)


# -----------------------------------------------------------------------------
# The answers of a trial.

WAYS = {**ERRORS, 'sensed': 'sensed_error_nmi'}
"""Three ways of finding the longitude and their columns: the dial alone, the dial corrected for
the rate in harbour, and corrected by thermometer and IMU as well.
"""


@dataclass(frozen=True)
class Prize(Proportion):
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
    voyages: list[Row]
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


def answers_of(trial: Trial, rows: Sequence[Row]) -> TrialAnswers:
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


def _voyage(row: Row, passage: LoggedPassage) -> dict[str, Any]:
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
    rows: Sequence[Row],
    column: str,
    passages: dict[str, LoggedPassage],
    judged: set[str],
) -> WayAnswers:
    sample = [row for row in rows if row['passage'] in judged]

    def parts(of: Callable[[LoggedPassage], str]) -> list[Part]:
        groups: dict[str, list[Row]] = {}
        for row in sample:
            groups.setdefault(of(passages[row['passage']]), []).append(row)
        return [_part(name, sizes_nmi(groups[name], column)) for name in sorted(groups)]

    shares = zip(shares_within(sizes_nmi(sample, column)) if sample else [], AWARDS, strict=False)
    return WayAnswers(
        prizes=[
            Prize(share.limit_nmi, pounds, share.ships, share.share, share.low, share.high)
            for share, (_, pounds) in shares
        ],
        quantiles_nmi=quantiles_of(sizes_nmi(rows, column)),
        seasons=parts(season_of),
        oceans=parts(ocean_of_passage),
    )


def _part(name: str, sizes: FloatArray) -> Part:
    arrived = sizes[np.isfinite(sizes)]
    counts = [int(np.count_nonzero(sizes <= limit)) for limit, _ in AWARDS]
    return Part(name, len(sizes), counts, float(np.median(arrived)) if len(arrived) else None)
