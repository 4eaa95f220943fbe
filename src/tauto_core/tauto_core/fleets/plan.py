"""The definition of a fleet: scene, keys that are drawn for each ship, number of ships."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from tauto_core.fleets.draws import Normal, OneOf, Uniform, Value
from tauto_core.readiness import check_known
from tauto_core.scene import Scene, scene_yaml
from tauto_core.scene.errors import Problem, SceneError, UsageError, naming
from tauto_core.scene.loader import check_key, checked_scene, put_value
from tauto_core.scene.paths import value_at
from tauto_core.scene.yaml_text import read_mapping

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
                f'--ships {self.ships}: must lie between 1 and {MOST_SHIPS:,}. Use for example 200'
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
            f'all ships meet the same motion, since ship.kind is {ship.kind}, and their clocks '
            f'swing alike: only {" and ".join(differ)} differ. Let --vary draw a key of the '
            'machine or the ship',
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
