"""Fleets: many voyages of one scene with different random numbers.

A voyage ends with an arrival, or with a failure of the clock, or is lost with its process. A
lost voyage has no row, and the statistics wait until it has been sailed again.
"""

from __future__ import annotations

import copy
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias, cast

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from tauto_core import voyage
from tauto_core.checks.cost import work_s
from tauto_core.checks.readiness import check_known, check_scene
from tauto_core.ensembles.rows import (
    ENDED,
    ERRORS,
    FIGURE_TYPES,
    QUANTILES,
    Columns,
    Portion,
    Row,
    Voyages,
    failures_of,
    figures_of,
    has_arrived,
    quantiles_of,
    sail,
    shares_within,
    sizes_nmi,
)
from tauto_core.ensembles.workers import versions
from tauto_core.navigation.longitude import LEAST_UNCHECKED_DAYS
from tauto_core.results import drawn_by
from tauto_core.samples import FloatArray
from tauto_core.scene import Scene, scene_yaml
from tauto_core.scene.errors import (
    Argument,
    ArgumentText,
    MotionDataError,
    Problem,
    SceneError,
    TautoError,
    UsageError,
    naming,
)
from tauto_core.scene.loader import (
    check_key,
    checked_scene,
    put_value,
    read_mapping,
    unit_at,
    value_at,
)
from tauto_core.scene.sections import Number, Positive, Section
from tauto_core.scene.tables import read_data
from tauto_core.scene.times import DAY_S
from tauto_core.scene.units import in_unit, misfit, unit_of, unit_table
from tauto_core.wording import counted, figure, percent, span

# -----------------------------------------------------------------------------
# The distributions of the keys that are drawn for each ship of a fleet.

_Value: TypeAlias = float | int | str | bool


class Normal(Section):
    """A normal distribution, truncated at `low` and `high` if they are given."""

    kind: Literal['normal']
    sigma: Positive = Field(description='standard deviation')
    mean: Number | None = Field(default=None, description="absent: the scene's value")
    low: Number | None = Field(default=None, description='least value')
    high: Number | None = Field(default=None, description='largest value')

    @model_validator(mode='after')
    def _refuse_empty(self) -> Normal:
        if self.low is not None and self.high is not None:
            _check_rising(self.low, self.high)
        return self

    def draw(self, random: np.random.Generator, value: _Value | None) -> _Value:
        """Return a value. `value` is the scene's, which replaces a missing mean."""
        from scipy.stats import truncnorm

        if self.mean is None and (isinstance(value, bool) or not isinstance(value, int | float)):
            raise ValueError(f"is drawn about the scene's value, which is {value!r}, not a number")
        mean = float(cast(float, value if self.mean is None else self.mean))
        low = -np.inf if self.low is None else (self.low - mean) / self.sigma
        high = np.inf if self.high is None else (self.high - mean) / self.sigma
        return float(mean + self.sigma * truncnorm.ppf(random.random(), low, high))


class Uniform(Section):
    """A uniform distribution, from `low` to `high`."""

    kind: Literal['uniform']
    low: Number = Field(description='least value')
    high: Number = Field(description='largest value')

    @model_validator(mode='after')
    def _refuse_empty(self) -> Uniform:
        _check_rising(self.low, self.high)
        return self

    def draw(self, random: np.random.Generator, value: _Value | None) -> _Value:
        """Return a value. The arguments are explained in `Normal.draw`."""
        del value
        return self.low + (self.high - self.low) * random.random()


class OneOf(Section):
    """A list of equally probable values."""

    kind: Literal['list']
    values: tuple[_Value, ...] = Field(min_length=1, description='values to choose from')

    @model_validator(mode='after')
    def _refuse_mixed(self) -> OneOf:
        kinds = {float if type(value) is int else type(value) for value in self.values}
        if len(kinds) > 1:
            raise _wrong('values must be all numbers, all text or all truth values')
        return self

    def draw(self, random: np.random.Generator, value: _Value | None) -> _Value:
        """Return a value. The arguments are explained in `Normal.draw`."""
        del value
        return self.values[int(random.integers(len(self.values)))]


Draw: TypeAlias = Annotated[Normal | Uniform | OneOf, Field(discriminator='kind')]

_READER: TypeAdapter[Normal | Uniform | OneOf] = TypeAdapter(Draw)
_EXAMPLE = 'Write for example `{kind: normal, sigma: 2.0e-5}`.'


def read_draws(path: Path, scene: Scene) -> dict[str, Normal | Uniform | OneOf]:
    """Return the distributions in a YAML file by the paths of their keys.

    The file maps paths such as `trochlea.cam.base_radius` to mappings with `kind` normal, uniform
    or list. Any other contents and an unreadable file are a SceneError.
    """
    try:
        content = read_mapping(read_data(path, 2**20).decode(), str(path))
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, 'strerror', None) or 'is not UTF-8 text'
        remedy = ArgumentText('Name a YAML file with ', Argument('vary'), '.')
        raise SceneError(str(path), '', str(path), f'cannot be read: {why}', remedy) from None
    return as_draws(content, str(path), scene)


def as_draws(
    content: dict[str, Any], origin: str, scene: Scene
) -> dict[str, Normal | Uniform | OneOf]:
    """Return the distributions in the mapping of such a file.

    Numbers are in the unit of the key in the scene, or texts with a unit, such as `20 um`.
    `origin` names the source in errors (see `read_draws`).
    """
    draws, problems = {}, []
    for key, distribution in content.items():
        unit = unit_at(scene, key)
        try:
            stated = distribution
            if unit is not None and isinstance(stated, dict):
                stated = {
                    name: in_unit(value, _asked(name, unit)) for name, value in stated.items()
                }
            draws[key] = _READER.validate_python(stated)
        except ValidationError as error:
            for detail in error.errors():
                names = detail['loc'][1:]
                full = '.'.join([key, *map(str, names)])
                value = detail['input']
                target = _asked(str(names[0]), unit) if names and unit else None
                why = misfit(value, target) if target and isinstance(value, str) else None
                problem, remedy = why or (detail['msg'][:1].lower() + detail['msg'][1:], _EXAMPLE)
                problems.append(Problem(full, value, problem, remedy))
    if problems:
        raise SceneError.of(origin, problems)
    return draws


def _asked(name: str, unit: str) -> str:
    """Return the unit of a number of a distribution. The spread of a temperature is in kelvin."""
    is_temperature = (unit_of(unit) or unit_table()['K']).zero
    return 'K' if is_temperature and name == 'sigma' else unit


def _check_rising(low: float, high: float) -> None:
    if not low < high:
        raise _wrong(f'low = {low!r} must be below high = {high!r}')


def _wrong(text: str) -> PydanticCustomError:
    return PydanticCustomError('draw', '{said}', {'said': text})


MOST_SHIPS = 100_000

CHECKED_FIRST = 2_000
"""Number of scenes that are checked before the start, at 2 ms each."""

_STREAM = 3
"""Number of the random streams of ships and draws, from the scene's seed."""


class Ship(NamedTuple):
    """One ship of a fleet: its drawn values by the paths of their keys, and its scene."""

    drawn: dict[str, _Value]
    scene: Scene


@dataclass(frozen=True)
class Plan:
    """A fleet: every ship has another seed and another value of each drawn key.

    A ship depends only on the scene, its seed, the ship's number and the draws: more ships or more
    drawn keys do not change it.

    Attributes:
        scene: the scene that the ships vary.
        origin: file or name that the user gave.
        ships: number of ships.
        draws: distributions by the paths of their keys.
        drawn_by: the file with the distributions, for errors.
        anyway: sail machines and ships larger than any known, too.
    """

    scene: Scene
    origin: str
    ships: int
    draws: Mapping[str, Normal | Uniform | OneOf] = field(default_factory=dict)
    drawn_by: str = 'vary'
    anyway: bool = False

    def __post_init__(self) -> None:
        if not 1 <= self.ships <= MOST_SHIPS:
            raise UsageError(
                Argument('ships', self.ships),
                f': must be between 1 and {MOST_SHIPS:,}. Use for example 200',
            )

    @cached_property
    def content(self) -> dict[str, Any]:
        """The scene's mapping, with all defaults."""
        return read_mapping(scene_yaml(self.scene), self.origin)

    @property
    def columns(self) -> Columns:
        """Columns of the fleet's rows."""
        values = {key: getattr(draw, 'values', (0.0,)) for key, draw in self.draws.items()}
        kinds = {key: {type(value) for value in some} for key, some in values.items()}
        drawn = {key: kind.pop() if len(kind) == 1 else float for key, kind in kinds.items()}
        return {'ship': int, 'seed': int, **drawn, **FIGURE_TYPES, **ENDED}

    def identity(self) -> dict[str, Any]:
        """Return everything that determines the rows, except the number of ships."""
        return {
            'scene': self.content,
            'vary': {key: draw.model_dump(exclude_none=True) for key, draw in self.draws.items()},
            'versions': versions(),
        }

    def ship(self, number: int) -> Ship:
        """Return the ship of a number, from 0. An impossible key or value is a SceneError.

        A drawn machine or ship larger than any known is one, too, unless `anyway`.
        """
        content = copy.deepcopy(self.content)
        drawn: dict[str, _Value] = {}
        for key, draw in self.draws.items():
            random = np.random.default_rng(_stream(self.scene.seed, number, *key.encode()))
            try:
                drawn[key] = draw.draw(random, value_at(content, key))
            except ValueError as error:
                raise self._refused(number, Problem(key, None, str(error), _CENTRE)) from None
        words = _stream(self.scene.seed, number).generate_state(1, np.uint64)
        content['seed'] = int(words[0] >> np.uint64(1))
        try:
            for key, value in drawn.items():
                put_value(content, key, value, self.drawn_by)
            scene = checked_scene(content, self.origin)
            if drawn and not self.anyway:
                check_known(scene)
            return Ship(drawn, scene)
        except SceneError as error:
            problem, *further = error.problems
            raise self._refused(number, problem, *further) from None

    def check(self) -> None:
        """Check the scenes of the first `CHECKED_FIRST` ships before any ship sails.

        The SceneError names the ship, the key, the drawn value and the limit.
        """
        for key in self.draws:
            check_key(self.content, key, self.drawn_by)
        if not self.anyway and not self.draws:
            with naming(self.origin, self.scene.name):
                check_known(self.scene)
        for number in range(min(self.ships, CHECKED_FIRST)):
            self.ship(number)

    def _refused(self, number: int, problem: Problem, *further: Problem) -> SceneError:
        text = f'ship {number}, as drawn: {problem.problem}'
        narrow = ' Narrow the distribution, or cut it off with low and high.' * bool(self.draws)
        remedy = f'{problem.remedy}{narrow}'
        return SceneError(self.drawn_by, problem.key, problem.value, text, remedy, further=further)


_CENTRE = 'Give the mean, or low and high.'


def _stream(seed: int, *which: int) -> np.random.SeedSequence:
    return np.random.SeedSequence(seed, spawn_key=(_STREAM, *which))


# -----------------------------------------------------------------------------
# The voyage of one ship of a fleet, and its row of figures.


def sail_ship(plan: Plan, number: int, progress: Callable[[float], None]) -> list[Row]:
    """Return the row of a ship: number, seed, drawn values and `figures_of` its voyage.

    Errors other than an end of the voyage, such as a MemoryError, are raised.
    """
    ship = plan.ship(number)
    report: Mapping[str, Any] = {}
    began, ended = time.thread_time(), None
    try:
        report = voyage.sail(
            ship.scene,
            origin=plan.origin,
            anyway=True,  # `Plan.ship` has checked it
            keep=False,
            progress=progress,
        ).result
    except MotionDataError:  # a missing or unreadable file
        raise
    except TautoError as error:
        ended = error
    figures = figures_of(report, ended, time.thread_time() - began)
    return [{'ship': number, 'seed': ship.scene.seed, **ship.drawn, **figures}]


# -----------------------------------------------------------------------------
# The statistics of a fleet.

LEAST_RANKED = 10
"""Least number of voyages for a correlation."""


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


def statistics_of(rows: Sequence[Row], drawn: Iterable[str] = ()) -> Answers:
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
        quantiles_nmi={name: quantiles_of(np.abs(error)) for name, error in errors.items()},
        influences=_influences(drawn, arrived, errors),
    )


def _influences(
    drawn: Iterable[str], rows: Sequence[Row], errors: dict[str, FloatArray]
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


@dataclass(frozen=True, repr=False)
class Fleet:
    """A fleet that has sailed: rows of `sail_ship`, sorted by ship, and their statistics."""

    plan: Plan
    rows: list[Row]
    answers: Answers

    def __repr__(self) -> str:
        return f'<Fleet of {self.plan.scene.name}: {self.answers.answer}>'

    def _repr_html_(self) -> str:
        return str(drawn_by('notebook', 'fleet_html')(self))


def sail_fleet(
    plan: Plan,
    jobs: int,
    out: Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> Fleet:
    """Sail a fleet, or the rest of it, as `rows.sail` does.

    An invalid scene is a SceneError before any ship sails.
    """
    plan.check()
    scene = plan.ship(0).scene
    with naming(plan.origin, scene.name):
        check_scene(scene)
    voyages = Voyages(
        partial(sail_ship, plan),
        range(plan.ships),
        'ship {}'.format,
        lambda _: work_s(scene),
        number=int,
        columns=plan.columns,
        identity=plan.identity(),
    )
    rows = sail(voyages, jobs, out, progress)
    return Fleet(plan, rows, statistics_of(rows, plan.draws))
