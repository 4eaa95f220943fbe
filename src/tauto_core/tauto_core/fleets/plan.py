"""The definition of a fleet: scene, number of ships, and the keys drawn for each ship."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, cast

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from tauto_core.checks.readiness import check_known
from tauto_core.scene import Scene, scene_yaml
from tauto_core.scene.errors import Argument, ArgumentText, Problem, SceneError, UsageError, naming
from tauto_core.scene.fields import Number, Positive, Section
from tauto_core.scene.loader import check_key, checked_scene, put_value, read_mapping, value_at

# -----------------------------------------------------------------------------
# The distributions from which a key of the scene is drawn for each ship of a fleet.

Value: TypeAlias = float | int | str | bool


class Normal(Section):
    """A normal distribution, truncated at `low` and `high` where they are given."""

    kind: Literal['normal']
    sigma: Positive = Field(description='standard deviation')
    mean: Number | None = Field(default=None, description="absent: the scene's value")
    low: Number | None = Field(default=None, description='nothing below is drawn')
    high: Number | None = Field(default=None, description='nothing above is drawn')

    @model_validator(mode='after')
    def _refuse_empty(self) -> Normal:
        if self.low is not None and self.high is not None:
            _check_rising(self.low, self.high)
        return self

    def draw(self, random: np.random.Generator, given: Value | None) -> Value:
        """Return a value.

        Args:
            random: the generator of random numbers.
            given: the value in the scene, used as the mean if that is absent.

        Raises:
            ValueError: that value is not a number.
        """
        from scipy.stats import truncnorm

        mean = _centre(given) if self.mean is None else self.mean
        low = -np.inf if self.low is None else (self.low - mean) / self.sigma
        high = np.inf if self.high is None else (self.high - mean) / self.sigma
        return float(mean + self.sigma * truncnorm.ppf(random.random(), low, high))


class Uniform(Section):
    """A uniform distribution, from `low` to `high` or about the scene's value."""

    kind: Literal['uniform']
    low: Number | None = Field(default=None, description='least value')
    high: Number | None = Field(default=None, description='largest value')
    half_width: Positive | None = Field(
        default=None, description="in place of low and high: about the scene's value"
    )

    @model_validator(mode='after')
    def _refuse_half(self) -> Uniform:
        if self.half_width is None and self.low is not None and self.high is not None:
            _check_rising(self.low, self.high)
        elif self.half_width is None or self.low is not None or self.high is not None:
            raise _wrong('needs both low and high, or half_width alone')
        return self

    def draw(self, random: np.random.Generator, given: Value | None) -> Value:
        """Return a value; arguments as for `Normal.draw`."""
        if self.half_width is not None:
            return _centre(given) + self.half_width * (2.0 * random.random() - 1.0)
        low, high = cast(float, self.low), cast(float, self.high)
        return low + (high - low) * random.random()


class OneOf(Section):
    """One of a list of values, each with the same probability."""

    kind: Literal['list']
    values: tuple[Value, ...] = Field(min_length=1, description='values to choose from')

    @model_validator(mode='after')
    def _refuse_mixed(self) -> OneOf:
        kinds = {float if type(value) is int else type(value) for value in self.values}
        if len(kinds) > 1:
            raise _wrong('values must be all numbers, all text or all truth values')
        return self

    def draw(self, random: np.random.Generator, given: Value | None) -> Value:
        """Return a value; arguments as for `Normal.draw`."""
        del given
        return self.values[int(random.integers(len(self.values)))]


Draw: TypeAlias = Annotated[Normal | Uniform | OneOf, Field(discriminator='kind')]

_READER: TypeAdapter[Normal | Uniform | OneOf] = TypeAdapter(Draw)
_EXAMPLE = 'Write for example `{kind: normal, sigma: 2.0e-5}`.'


def read_draws(path: Path) -> dict[str, Normal | Uniform | OneOf]:
    """Return the distributions of keys, by their paths in the scene.

    Args:
        path: a YAML file of paths such as `trochlea.cam.base_radius`, each with a mapping whose
            `kind` is normal, uniform or list.

    Raises:
        SceneError: the file cannot be read, or does not describe distributions.
    """
    try:
        content = read_mapping(path.read_text('utf-8'), str(path))
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, 'strerror', None) or 'is not UTF-8 text'
        remedy = ArgumentText('Name a YAML file with ', Argument('vary'), '.')
        raise SceneError(str(path), '', str(path), f'cannot be read: {why}', remedy) from None
    return as_draws(content, str(path))


def as_draws(content: dict[str, Any], origin: str) -> dict[str, Normal | Uniform | OneOf]:
    """Return the distributions of keys, from the mapping in such a file.

    Args:
        content: paths of keys, each with a mapping whose `kind` names the distribution.
        origin: name of the source, for error messages.

    Raises:
        SceneError: as for `read_draws`.
    """
    draws, problems = {}, []
    for key, said in content.items():
        try:
            draws[key] = _READER.validate_python(said)
        except ValidationError as error:
            problems += [_problem(key, detail) for detail in error.errors()]
    if problems:
        first, *further = problems
        raise SceneError(
            origin, first.key, first.value, first.problem, first.remedy, further=further
        )
    return draws


def _problem(key: str, detail: Any) -> Problem:
    place = '.'.join(str(part) for part in detail['loc'][1:])
    said = detail['msg'][:1].lower() + detail['msg'][1:]
    return Problem(f'{key}.{place}' if place else key, detail['input'], said, _EXAMPLE)


def _centre(given: Value | None) -> float:
    if isinstance(given, bool) or not isinstance(given, int | float):
        raise ValueError(f"is drawn about the scene's value, which is {given!r}, not a number")
    return float(given)


def _check_rising(low: float, high: float) -> None:
    if not low < high:
        raise _wrong(f'low = {low!r} must be below high = {high!r}')


def _wrong(said: str) -> PydanticCustomError:
    return PydanticCustomError('draw', '{said}', {'said': said})


MOST_SHIPS = 1_000_000

_STREAM = 3
"""Number of the streams of random numbers from the scene's seed for ships and draws."""


@dataclass(frozen=True)
class Ship:
    """One ship of a fleet.

    Attributes:
        number: from 0.
        drawn: value of each drawn key, by its path.
        scene: the scene of her voyage.
    """

    number: int
    drawn: dict[str, Value]
    scene: Scene


@dataclass(frozen=True)
class Plan:
    """A fleet: every ship has a seed of her own, and her own value of each drawn key.

    A ship depends on the scene, its seed, her number and the draws alone. With more ships, or more
    drawn keys, the other values drawn for her do not change.

    Attributes:
        scene: the scene that the ships vary.
        origin: file or name that the user gave.
        ships: number of ships.
        draws: distributions of the drawn keys, by their paths.
        drawn_by: the file with the distributions, for errors.
    """

    scene: Scene
    origin: str
    ships: int
    draws: Mapping[str, Normal | Uniform | OneOf] = field(default_factory=dict)
    drawn_by: str = 'vary'

    def __post_init__(self) -> None:
        if not 1 <= self.ships <= MOST_SHIPS:
            raise UsageError(
                Argument('ships', self.ships),
                f': must lie between 1 and {MOST_SHIPS:,}. Use for example 200',
            )

    @cached_property
    def content(self) -> dict[str, Any]:
        """The scene's mapping, with all defaults."""
        return read_mapping(scene_yaml(self.scene), self.origin)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the answer does not say: ships that differ too little to be counted."""
        ship, drawn = self.scene.ship, set(self.draws)
        if ship.is_random or {key.partition('.')[0] for key in drawn} & _OF_THE_MOTION:
            return ()
        noisy = self.scene.clock.is_noisy or drawn & _NOISES
        differ = [*sorted(drawn), *['the noise of the clock'] * bool(noisy), 'the observations']
        return (
            ArgumentText(
                f'all ships meet the same motion, since ship.kind is {ship.kind}, and their '
                f'clocks swing alike: only {" and ".join(differ)} differ. Let ',
                Argument('vary'),
                ' draw a key of the machine or the ship',
            ),
        )

    def ship(self, number: int) -> Ship:
        """Return a ship, 0 to ships - 1.

        Raises:
            SceneError: a key or value that a scene cannot have.
        """
        given = copy.deepcopy(self.content)
        drawn: dict[str, Value] = {}
        for key, draw in self.draws.items():
            random = np.random.default_rng(_stream(self.scene.seed, number, *key.encode()))
            try:
                drawn[key] = draw.draw(random, value_at(given, key))
            except ValueError as error:
                raise self._refused(number, Problem(key, None, str(error), _CENTRE)) from None
        words = _stream(self.scene.seed, number).generate_state(1, np.uint64)
        given['seed'] = int(words[0] >> np.uint64(1))
        try:
            for key, value in drawn.items():
                put_value(given, key, value, self.drawn_by)
            return Ship(number, drawn, checked_scene(given, self.origin))
        except SceneError as error:
            first, *further = error.problems
            raise self._refused(number, first, *further) from None

    def check(self, *, anyway: bool = False) -> None:
        """Refuse a fleet in which the scene of any ship is invalid, before any of them sails.

        Args:
            anyway: let ships sail with machines beyond all that are known, too.

        Raises:
            SceneError: naming the ship, the key, the value that was drawn and the limit.
        """
        for key in self.draws:
            check_key(self.content, key, self.drawn_by)
        if not anyway and not self.draws:
            with naming(self.origin, self.scene.name):
                check_known(self.scene)
        for number in range(self.ships):
            scene = self.ship(number).scene
            if anyway or not self.draws:
                continue
            try:
                check_known(scene)
            except SceneError as error:
                first, *further = error.problems
                raise self._refused(number, first, *further) from None

    def _refused(self, number: int, first: Problem, *further: Problem) -> SceneError:
        said = f'ship {number}, as drawn: {first.problem}'
        remedy = f'{first.remedy} Narrow what is drawn, or cut it off with low and high.'
        return SceneError(
            self.drawn_by,
            first.key,
            first.value,
            said,
            remedy if self.draws else first.remedy,
            further=further,
        )


_OF_THE_MOTION = {
    'gravity',
    'trochlea',
    'regulator',
    'drag',
    'escapement',
    'ship',
    'suspension',
}
"""Sections of a scene on which the motion of the ship, or of the regulator in it, depends."""

_NOISES = {'clock.white_fm', 'clock.random_walk_fm'}

_CENTRE = 'Give the mean, or low and high.'


def _stream(seed: int, *which: int) -> np.random.SeedSequence:
    return np.random.SeedSequence(seed, spawn_key=(_STREAM, *which))
