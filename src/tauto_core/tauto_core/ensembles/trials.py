"""Trials: clocks sent along the passages of a log-book, in the seas that the logged winds raise.

The choice of passages, the random wind and hull, and the voyage of several clocks in one sea.
"""

from __future__ import annotations

import copy
import hashlib
import math
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Literal, TypeAlias

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
from tauto_core.ensembles.rows import ENDED, FIGURE_TYPES, Columns, Voyages, sail
from tauto_core.ensembles.workers import versions
from tauto_core.navigation import DriftStage, LongitudeStage, LongitudeTally
from tauto_core.navigation.covariates import coefficients
from tauto_core.navigation.longitude import LEAST_UNCHECKED_DAYS
from tauto_core.navigation.regressors import SHAKEN_BY
from tauto_core.samples import (
    LONGITUDE_ERROR,
    OBSERVATION,
    READING,
    SHIP_FIX,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    Batches,
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
from tauto_core.scene.sections import LEAST_WIND, VARIABLE_WINDS, LogEntry, has_wind, log_time
from tauto_core.scene.tables import missing_file
from tauto_core.scene.times import NS_PER_S
from tauto_core.ship.coast import OCEANS, ocean_of
from tauto_core.ship.hull import SHAPES
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


@dataclass(frozen=True)
class Choice:
    """Which passages are wanted.

    Attributes:
        days: least and largest length [days].
        years: first and last year of the first entry.
        port: part of the name of the port of departure or destination, in any case.
        ocean: part of the name of the ocean of most entries (`OCEANS`).
        sample: number of passages taken, spread evenly over the list. `None`: all.
    """

    days: tuple[float, float] = (LEAST_UNCHECKED_DAYS, math.inf)
    years: tuple[float, float] = (0.0, math.inf)
    port: str | None = None
    ocean: str | None = None
    sample: int | None = None

    def __post_init__(self) -> None:
        if self.sample is not None and self.sample < 1:
            raise UsageError(Argument('sample', self.sample), ': must be at least 1. Name more')
        if self.ocean is not None and not any(self._is_in(ocean) for ocean in OCEANS):
            raise UsageError(
                Argument('ocean', self.ocean), f': is not one of {", ".join(OCEANS)}. Name one'
            )

    def _is_in(self, ocean: str) -> bool:
        return self.ocean is None or self.ocean.casefold() in ocean.casefold()

    def takes(self, passage: LoggedPassage) -> bool:
        """Return whether a passage is wanted. One whose length is unknown is."""
        try:
            year = log_time(passage.entries[0][0]).year
        except ValueError:
            return True  # so that it is refused with its name and row
        ports = f'{passage.sailed_from}\n{passage.bound_to}'.casefold()
        return (
            self.years[0] <= year <= self.years[1]
            and (self.port is None or self.port.casefold() in ports)
            and self._is_in(ocean_of_passage(passage))
            and (
                next(passage.problems(), None) is not None
                or self.days[0] <= passage.days <= self.days[1]
            )
        )

    def of(self, passages: Iterable[LoggedPassage], origin: str) -> tuple[LoggedPassage, ...]:
        """Return the wanted passages. No such passage is a UsageError."""
        count, matches = 0, []
        for passage in passages:
            count += 1
            if self.takes(passage):
                matches.append(passage)
        if not matches:
            raise UsageError(
                f'{origin}: none of its {count} passages matches. List them with `tauto logbook`'
            )
        if self.sample is not None and self.sample < len(matches):
            places = np.linspace(0, len(matches) - 1, self.sample).round().astype(int)
            matches = [matches[place] for place in places]
        return tuple(matches)


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
# The unknowns of a passage, drawn at random: the wind (theory/logbooks.md) and the hull.

WIND_OFFSET = 0.92
"""Standard deviation of a log's mean wind over a passage [m/s]: two logs differ by 1.3 rms."""

WIND_DAILY = 1.90
"""Further standard deviation of a day [m/s]: two logs differ by 2.98 rms, one errs by 2.11."""

WIND_FROM_DEG = 21.0
"""Standard deviation of a log's wind direction [degrees]: the median of two logs differs by 19."""

HULL_SHAPES = ('sloop', 'deptford', 'ketch')
"""The 18th-century hulls among `SHAPES`."""

GYRATIONS = 0.22, 0.28
"""Radius of gyration in pitch over the length of the hull, an assumption."""

CENTRES_M = -0.5, 0.5
"""Height of the centre of gravity above the waterline [m], an assumption."""

DAMPINGS = 0.5, 3.0
"""Roll damping over the scene's. Sails increase it several-fold. An assumption."""

HULL_KEYS = (
    'ship.hull.shape',
    'ship.hull.k_yy',
    'ship.hull.centre_of_gravity',
    'ship.roll.damping_ratio',
)

_STREAM = 4
"""Number of the random streams of passages, from the scene's seed."""

Drawn: TypeAlias = Literal['log', 'wind', 'hull']


def with_wind_drawn(
    entries: Sequence[LogEntry], random: np.random.Generator
) -> tuple[LogEntry, ...]:
    """Return the entries with random winds within the scatter of a log.

    A wind of U m/s becomes max(U + a + b, 0) and turns by a normal angle; a belongs to the passage
    and b to the day. A wind below `LEAST_WIND` gets a random direction. Entries without a wind or
    a direction stay unchanged.
    """
    offset = WIND_OFFSET * random.standard_normal()
    result = []
    for utc, latitude, longitude, wind_from, wind, celsius in entries:
        daily, turn, anywhere = *random.standard_normal(2), 360.0 * random.random()
        calm = wind is not None and wind < LEAST_WIND
        if wind is None or (not calm and (wind_from is None or wind_from in VARIABLE_WINDS)):
            result.append((utc, latitude, longitude, wind_from, wind, celsius))
            continue
        has_direction = not calm and wind_from is not None
        blows_from = (wind_from + WIND_FROM_DEG * turn) % 360.0 if has_direction else anywhere
        blows = max(wind + offset + WIND_DAILY * daily, 0.0)
        result.append((utc, latitude, longitude, float(blows_from), float(blows), celsius))
    return tuple(result)


def drawn_hull(scene: Mapping[str, Any], random: np.random.Generator) -> dict[str, Any]:
    """Return random values of `HULL_KEYS` for a ship of the century."""
    shape = HULL_SHAPES[int(random.integers(len(HULL_SHAPES)))]
    gyration, centre, damping = random.random(3)
    low, high = (math.log(bound) for bound in DAMPINGS)
    factor = math.exp(low + (high - low) * damping)
    return {
        'ship.hull.shape': shape,
        'ship.hull.k_yy': SHAPES[shape].length
        * (GYRATIONS[0] + (GYRATIONS[1] - GYRATIONS[0]) * float(gyration)),
        'ship.hull.centre_of_gravity': CENTRES_M[0]
        + (CENTRES_M[1] - CENTRES_M[0]) * float(centre),
        'ship.roll.damping_ratio': factor * float(scene['ship']['roll']['damping_ratio']),
    }


# -----------------------------------------------------------------------------
# The plan of a trial.

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


@dataclass(frozen=True)
class Sailing:
    """A passage to be sailed by all clocks of a trial: as logged, or with random wind or hull.

    Attributes:
        number: from 0, unchanged if more are drawn.
        passage: the log.
        drawn: the drawn quantity; `log`: as logged.
        draw: number of the draw from 1; 0 as logged.
    """

    number: int
    passage: LoggedPassage
    drawn: Drawn = 'log'
    draw: int = 0


@dataclass(frozen=True)
class Rules:
    """The settings that all passages of a trial share.

    Attributes:
        clocks: clocks that share ship and passage.
        seed: seeds the seas, observations and draws, together with the passage's name.
        harbour_days: days of rating in still water before the first entry, an assumption.
        longest_s: length to which a scene is cut [s]. `None`: the log's.
        anyway: sail machines and ships larger than any known, too.
    """

    clocks: tuple[TriedClock, ...]
    seed: int
    harbour_days: float
    longest_s: float | None = None
    anyway: bool = False

    def scene(
        self, clock: TriedClock, sailing: Sailing, *, rate_hz: float | None = None
    ) -> tuple[Scene, dict[str, Any]]:
        """Return the scene of a clock on a passage, and the random values of its hull.

        `rate_hz` replaces the `ship.rate` that `solver.accuracy` requires; for fixed clocks with
        an escapement that is `rate_under_way`.
        """
        passage, hull = sailing.passage, dict[str, Any]()
        if sailing.drawn == 'wind':
            random = np.random.default_rng(self._stream(passage, 1, sailing.draw))
            passage = replace(passage, entries=with_wind_drawn(passage.entries, random))
        content = scene_of_passage(copy.deepcopy(dict(clock.content)), passage, self.harbour_days)
        content['seed'] = int(
            self._stream(passage).generate_state(1, np.uint64)[0] >> np.uint64(1)
        )
        if self.longest_s is not None:
            content['duration'] = self.longest_s
        goes = content.get('escapement') is not None and content.get('suspension') is None
        follows = goes and rate_hz is None and 'rate' not in content['ship']
        if rate_hz is not None or follows:
            content['ship']['rate'] = rate_hz or ANY_RATE_HZ
        if sailing.drawn == 'hull':
            random = np.random.default_rng(self._stream(passage, 2, sailing.draw))
            hull = drawn_hull(content, random)
            ship = content['ship']
            ship['hull'] = {key.rpartition('.')[2]: hull[key] for key in HULL_KEYS[:3]}
            ship['roll']['damping_ratio'] = hull[HULL_KEYS[3]]
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
        return scene, hull

    def _stream(self, passage: LoggedPassage, *which: int) -> np.random.SeedSequence:
        name = passage.name.encode()
        return np.random.SeedSequence(self.seed, spawn_key=(_STREAM, len(name), *name, *which))


@dataclass(frozen=True)
class Trial:
    """A trial: the clocks on each passage as logged, and with random wind or hull.

    Attributes:
        logs: file or name that the user gave.
        wind_draws, hull_draws: repetitions of each passage with another random wind or hull.
        left_out: chosen passages that cannot be sailed, with their problems.
    """

    logs: str
    rules: Rules
    passages: tuple[LoggedPassage, ...]
    wind_draws: int = 0
    hull_draws: int = 0
    left_out: tuple[tuple[str, Problem], ...] = ()

    def __post_init__(self) -> None:
        for name in ('wind_draws', 'hull_draws'):
            if not 0 <= getattr(self, name) <= MOST_DRAWS:
                raise UsageError(
                    Argument(name, getattr(self, name)),
                    f': must be between 0 and {MOST_DRAWS}. Use for example 2',
                )
        if self.hull_draws:
            for clock in self.rules.clocks:
                ship = clock.content['ship']
                if 'shape' not in (ship.get('hull') or {}) or 'roll' not in ship:
                    raise UsageError(
                        Argument('hull_draws', self.hull_draws),
                        f': {clock.origin} has no ship.hull with a shape, or no ship.roll. Give '
                        'it `hull: deptford`, or leave this out',
                    )

    @cached_property
    def sailings(self) -> tuple[Sailing, ...]:
        """All passages to be sailed, first as logged, then draw by draw.

        Within a draw their order is random (from the seed), so a trial that ends early has sailed
        a random sample of its passages.
        """
        count = len(self.passages)
        seeds = np.random.SeedSequence(self.rules.seed, spawn_key=(_STREAM, 0, count))
        order = np.random.Generator(np.random.PCG64(seeds)).permutation(count).tolist()
        kinds: list[tuple[Drawn, int, int]] = [('log', 0, 0)]
        for draw in range(1, max(self.wind_draws, self.hull_draws) + 1):
            kinds += [('wind', draw, 2 * draw - 1)] * (draw <= self.wind_draws)
            kinds += [('hull', draw, 2 * draw)] * (draw <= self.hull_draws)
        return tuple(
            Sailing(turn * count + place, self.passages[place], kind, draw)
            for kind, draw, turn in kinds
            for place in order
        )

    @property
    def ships(self) -> int:
        """Number of rows: one for each clock on each passage."""
        return len(self.sailings) * len(self.rules.clocks)

    def identity(self) -> dict[str, Any]:
        """Return everything that determines the rows, except the numbers of draws."""
        entries = [[passage.name, *map(list, passage.entries)] for passage in self.passages]
        return {
            'clocks': [dict(clock.content) for clock in self.rules.clocks],
            'logs': hashlib.sha256(repr(entries).encode()).hexdigest(),
            'passages': len(self.passages),
            'rules': {
                'seed': self.rules.seed,
                'harbour_days': self.rules.harbour_days,
                'longest_s': self.rules.longest_s,
            },
            'versions': versions(),
        }

    def check(self) -> None:
        """Refuse passages that make no valid scene."""
        for number, passage in enumerate(self.passages):
            for clock in self.rules.clocks:
                # the `ship.rate` for an accuracy takes a hundred times as long as the rest
                scene, _ = self.rules.scene(clock, Sailing(number, passage), rate_hz=ANY_RATE_HZ)
                assert scene.voyage is not None
                with naming(self.logs, f'passage {passage.name}'):
                    Passage(scene, scene.voyage)


MOST_DRAWS = 1000


def make_trial(
    logs: str,
    scenes: Sequence[tuple[str, Scene]],
    choice: Choice = Choice(),
    *,
    progress: Callable[[float], None] | None = None,
    harbour_days: float = 14.0,
    longest_s: float | None = None,
    wind_draws: int = 0,
    hull_draws: int = 0,
    skip_wrong: bool = False,
    anyway: bool = False,
) -> Trial:
    """Read the log-book and return the trial of clocks that share ship and passage.

    Args:
        logs: file or folder of the log-book.
        scenes: the clocks, with their names as the user gave them.
        choice: which passages.
        progress: called with the fraction of the log-book that has been read.
        harbour_days: rating before the first entry [days].
        longest_s: length to which a voyage is cut [s]. `None`: the log's.
        wind_draws, hull_draws: repetitions of each passage with another random wind or hull.
        skip_wrong: leave out passages that cannot be sailed.
        anyway: sail machines and ships larger than any known, too.

    Raises:
        UsageError: no such file or passages, numbers out of range, or two clocks of one name.
        SceneError: chosen passages that cannot be sailed, each with its rows, or a clock that
            cannot be rated as its scene says.
    """
    check_logs(logs)
    refuse_same_names(scenes)
    wrong: list[tuple[str, Problem]] = []

    def sound() -> Iterator[LoggedPassage]:
        for passage in read_passages(logs, progress=progress):
            fault = passage.fault()
            if fault is None and not any(map(has_wind, passage.entries)):
                key = f'passage {passage.name}, wind_mps'
                fault = Problem(key, ABSENT, 'has no wind to make a sea', 'Give it some.')
            if fault is not None and choice.takes(passage):
                wrong.append((passage.name, fault))
            if fault is None or not skip_wrong:
                yield passage

    chosen = choice.of(sound(), logs)
    if wrong and not skip_wrong:
        (_, problem), *tail = wrong
        skip = ArgumentText('Correct them, or leave them out with ', _SKIP, '.')
        text = f'{counted(len(wrong), "passage")} cannot be sailed'
        further = [*(fault for _, fault in tail), Problem('', ABSENT, text, skip)]
        raise SceneError(
            logs, problem.key, problem.value, problem.problem, problem.remedy, further=further
        )
    rules = Rules(
        tuple(TriedClock(origin, scene.name, _content(scene, origin)) for origin, scene in scenes),
        scenes[0][1].seed,
        harbour_days,
        longest_s,
        anyway,
    )
    typical = Sailing(0, chosen[len(chosen) // 2])
    rules = replace(rules, clocks=tuple(_sensed(rules, clock, typical) for clock in rules.clocks))
    return Trial(logs, rules, chosen, wind_draws, hull_draws, tuple(wrong))


_SKIP = Argument('skip_wrong', value=True)


def replaced_by_log(scene: Scene) -> tuple[str, ...]:
    """Return the keys of a scene that a trial replaces by the log's."""
    ship, own = scene.ship.model_fields_set, scene.air
    keys = [f'ship.{key}' for key in (*OF_THE_SEA, 'weather') if key in ship]
    air = () if own is None else own.model_fields_set
    keys += [f'air.{key}' for key in air if key not in ('kind', *OF_THE_BOX)]
    keys += ['clock.nominal_period'] * (scene.clock.nominal_period is not None)
    return (*keys, *['voyage'] * (scene.voyage is not None))


def check_logs(logs: str) -> None:
    """Refuse a log-book that does not exist (UsageError)."""
    for problem in missing_file('logs', logs, folders=True):
        raise UsageError(Argument('logs', logs), f': {problem.problem}. {problem.remedy}')


def clocks_beside(
    scene: Scene, origin: str, clocks: Sequence[str | Path | Scene]
) -> list[tuple[str, Scene]]:
    """Return further clocks (scenes, files or built-in names), fixed to the ship of a scene.

    The name `clocks` means all `CLOCKS`.
    """
    result = []
    for item in clocks:
        for clock in CLOCKS if item == 'clocks' else (item,):
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


def _sensed(rules: Rules, clock: TriedClock, typical: Sailing) -> TriedClock:
    """Return the clock with its covariates and their priors, estimated on one passage only."""
    content = {**clock.content, 'drift': dict(clock.content.get('drift') or {})}
    keys = content['drift'].pop('covariates', None)
    priors = content['drift'].pop('coefficients', None)
    plain = replace(clock, content=content)
    scene, _ = rules.scene(plain, typical)
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

TRACES = {'noon_raw_error_nmi': 'raw_error_nmi', 'noon_error_nmi': 'error_nmi'}
"""Columns with the errors at each entry of the log, and their names in `longitude/error`."""


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
        self._traces: dict[str, list[float]] = {name: [] for name in TRACES}

    def keep(self, batches: Batches) -> None:
        """Take the errors at noon, and run the navigator with thermometer and IMU."""
        errors = batches.get(LONGITUDE_ERROR)
        if isinstance(errors, JointSamples) and len(errors.stamp_ns):
            count = len(self._traces['noon_error_nmi'])
            until = np.searchsorted(errors.stamp_ns, self._noons[count:], 'right') - 1
            # an entry beyond this batch waits for the next batch
            rows = until[self._noons[count:] <= errors.stamp_ns[-1]]
            for name, column in TRACES.items():
                values = errors.position[np.maximum(rows, 0), errors.name.index(column)]
                self._traces[name] += values.tolist()
        if self._sensed is None:
            return
        out = self._sensed.feed({topic: batches[topic] for topic in batches if topic in _TOPICS})
        if self.at_end:
            out = merged([out, self._sensed.finish()])
        self._tally.take(out)

    def figures(self) -> dict[str, Any]:
        """Return the figures of its row, also by the navigator with thermometer and IMU."""
        sensed = (self._tally.result() if self.ended is None else None) or {}
        figures = {name: sensed.get(key) for name, key in SENSED.items()}
        return {**super().figures(), **figures, **self._traces}


_TOPICS = (SHIP_IMU, SHIP_FIX, SHIP_TEMPERATURE, OBSERVATION, READING)
"""Topics that a navigator reads."""


def sail_passage(
    rules: Rules, sailing: Sailing, progress: Callable[[float], None]
) -> list[dict[str, Any]]:
    """Sail all clocks along one passage in the same sea and return their rows.

    An event that ends the motion of a clock is a result, and the other clocks go on. `run_s` is
    the clock's own processor time plus an equal share of the sea's. A scene that cannot be sailed
    is a SceneError.
    """
    began = time.thread_time()
    built: list[tuple[Scene, dict[str, Any]]] = []
    rates_hz: dict[str, float] = {}
    for clock in rules.clocks:
        # clocks of the same kind on the same ship need the same rate
        kind = repr([clock.content.get(key) for key in ('ship', 'solver', 'log', 'suspension')])
        kind += str('escapement' in clock.content)
        built.append(rules.scene(clock, sailing, rate_hz=rates_hz.get(kind)))
        rates_hz[kind] = built[-1][0].ship.rate
    scenes = [with_rate(scene, max(rates_hz.values())) for scene, _ in built]
    origins = [f'{clock.origin}, passage {sailing.passage.name}' for clock in rules.clocks]
    sea = Sea(scenes, origins)
    of_clocks = zip(rules.clocks, scenes, origins, strict=True)
    afloat = [_Tried(clock, scene, origin, sea) for clock, scene, origin in of_clocks]
    sea.sail(afloat, began, progress)
    return [
        {
            'ship': sailing.number * len(afloat) + place,
            'clock': entry.clock.name,
            'passage': sailing.passage.name,
            'drawn': sailing.drawn,
            'draw': sailing.draw,
            **dict.fromkeys(HULL_KEYS),
            **hull,
            'seed': entry.scene.seed,
            **entry.figures(),
        }
        for place, (entry, (_, hull)) in enumerate(zip(afloat, built, strict=True))
    ]


COLUMNS: Columns = {
    'ship': int,
    'clock': str,
    'passage': str,
    'drawn': str,
    'draw': int,
    **dict.fromkeys(HULL_KEYS, float),
    HULL_KEYS[0]: str,
    'seed': int,
    **FIGURE_TYPES,
    **dict.fromkeys(SENSED, float),
    **dict.fromkeys(TRACES, list),
    **ENDED,
}
"""Columns of the rows of a trial."""


@dataclass(frozen=True)
class SailedTrial:
    """A trial that has been sailed, with the rows of `sail_passage`, sorted by their numbers."""

    trial: Trial
    rows: Sequence[dict[str, Any]]


def sail_trial(
    trial: Trial,
    jobs: int,
    out: Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> SailedTrial:
    """Sail a trial, or the rest of it, as `rows.sail` does. Invalid passages are refused first."""
    trial.check()
    leader, *peers = trial.rules.clocks
    plan = Voyages(
        partial(sail_passage, trial.rules),
        trial.sailings,
        lambda sailing: f'passage {sailing.passage.name}',
        lambda sailing: (1 + len(peers)) * work_s(trial.rules.scene(leader, sailing)[0]),
        clocks=1 + len(peers),
        number=lambda sailing: sailing.number,
        columns=COLUMNS,
        identity=trial.identity(),
    )
    return SailedTrial(trial, list(sail(plan, jobs, out, progress)))
