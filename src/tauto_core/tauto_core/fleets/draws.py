"""The distributions from which a key of the scene is drawn for each ship of a fleet."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, cast

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from tauto_core.scene.errors import Problem, SceneError
from tauto_core.scene.fields import Number, Positive, Section
from tauto_core.scene.yaml_text import read_mapping

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
        raise SceneError(
            str(path), '', str(path), f'cannot be read: {why}', 'Name a YAML file with --vary.'
        ) from None
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
