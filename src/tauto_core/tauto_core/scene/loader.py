"""The whole scene: the model, reading from names, files and YAML 1.2 text, and writing.

Numbers are in SI units and radians. Sections that are `None` are not simulated. `Scene` has the
rules that connect several sections, and those of its times.
"""

from __future__ import annotations

import copy
import difflib
import errno
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, cast

import numpy as np
import yaml
from pydantic import Field, Strict, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from tauto_core.files import SCALARS, YAML_TAG, YamlError, read_yaml
from tauto_core.machines.axle_pendulum import AxleRegulator
from tauto_core.machines.parts import DRAGS, ESCAPEMENTS, DragKind, EscapementKind
from tauto_core.machines.sections import FluidTautochroneRegulator, Trochlea
from tauto_core.scene.errors import ABSENT, Problem, SceneError, UsageError, problems_where
from tauto_core.scene.refuse import NO_KEY, SECTIONS, explain, out_of_proportion
from tauto_core.scene.sections import (
    ACCURACY,
    Clock,
    DriftSettings,
    Gravity,
    Itinerary,
    KindIn,
    Log,
    OneLine,
    Positive,
    Section,
    Solver,
    VoyageLog,
    kind_of,
    kinds_in,
    log_of_voyage,
)
from tauto_core.scene.tables import is_shipped, missing_file, read_data
from tauto_core.scene.times import (
    DAY_S,
    LAST_STAMP_S,
    LOOKAHEAD,
    MAX_GAP_S,
    NS_PER_S,
    STANDARD_GRAVITY,
    exact_nanoseconds,
    exact_step,
    nanoseconds,
    step_of_rate,
)
from tauto_core.scene.units import declared, in_unit
from tauto_core.ship.airs import FOLDER as AIRS
from tauto_core.ship.airs import AirKind, RecordAir
from tauto_core.ship.motions import FOLDER as SHIPS
from tauto_core.ship.motions import ShipKind, StillShip
from tauto_core.ship.passage import normal_gravity
from tauto_core.ship.sampling import LARGEST_SLOW_TURN, MOST_STEP_PARTS, largest_turn, rate_for
from tauto_core.ship.sections import names_hindcast
from tauto_core.ship.suspensions import FOLDER as SUSPENSIONS
from tauto_core.ship.suspensions import SuspensionKind


class Scene(Section):
    """A whole scene. `duration` and one of `trochlea` and `regulator` are required."""

    name: OneLine = Field(default='unnamed', description='name of the scene')
    duration: Positive = Field(description='length of the scene [s]')
    starts_at: Positive = Field(default=DAY_S, description='stamp of the first sample [s]')
    seed: Annotated[int, Strict(), Field(ge=0, le=2**63 - 1)] = Field(
        default=1726, description='seed of all random numbers, 0 to 2**63 - 1'
    )
    gravity: Gravity = Field(
        default=STANDARD_GRAVITY,
        description='acceleration of gravity [m/s2], or normal: gravity at each place of the '
        "voyage, with Eötvös' term (default of scenes with a voyage)",
    )
    trochlea: Trochlea | None = Field(
        default=None,
        description='mapping: inertia, cam, thread, power, release_angle of the regulator',
    )
    regulator: Annotated[
        AxleRegulator | FluidTautochroneRegulator | None, Field(discriminator='kind')
    ] = Field(default=None, description='mapping with `kind`: an oscillator instead of a trochlea')
    drag: Annotated[DragKind, KindIn(DRAGS, default='polynomial')] | None = Field(
        default=None, description='mapping: viscous, quadratic, coulomb'
    )
    escapement: Annotated[EscapementKind, KindIn(ESCAPEMENTS, default='impulse')] | None = Field(
        default=None, description='mapping: kind, energy, angle, rest'
    )
    ship: Annotated[ShipKind, KindIn(SHIPS)] = Field(
        default=StillShip(), description='mapping with `kind` and the motion of the ship'
    )
    suspension: Annotated[SuspensionKind, KindIn(SUSPENSIONS, default='axle')] | None = Field(
        default=None, description='mapping: kind, depth, gyration_radius, …'
    )
    air: Annotated[AirKind, KindIn(AIRS, default='constant', by='celsius')] | None = Field(
        default=None, description='mapping with `kind`: temperature of the air and of the clock'
    )
    clock: Clock = Field(
        default=Clock(), description='mapping: nominal_period, white_fm, random_walk_fm'
    )
    voyage: Itinerary | None = Field(
        default=None,
        description='mapping: departure, arrival, sails_at, arrives_at or speed, … (or log)',
    )
    drift: DriftSettings = Field(
        default=DriftSettings(), description='mapping: observation_interval, …'
    )
    log: Log = Field(default=Log(), description='mapping: interval, motion')
    solver: Solver | None = Field(default=None, description='mapping: accuracy or tolerance')

    @model_validator(mode='before')
    @classmethod
    def _by_the_voyage(cls, keys: Any) -> Any:
        """Set defaults of a voyage: normal gravity, and for a log-book duration and start.

        The scene ends one log interval after the arrival, when the clock is checked.
        """
        if not isinstance(keys, dict) or not keys.get('voyage'):
            return keys
        keys = {**keys}
        if keys.get('gravity') is None:
            keys['gravity'] = 'normal'
        log = log_of_voyage(keys['voyage'])
        if log is None:
            if isinstance(keys['voyage'], dict) and keys['voyage'].get('log') is not None:
                keys.setdefault('duration', DAY_S)  # report the wrong log only
        else:
            section = keys.get('log')
            interval = section.get('interval', 1.0) if isinstance(section, dict) else 1.0
            interval = in_unit(interval, 's')
            if keys.get('duration') is None and isinstance(interval, int | float) and interval > 0:
                keys['duration'] = (math.ceil(log.at[-1] / interval) + 1.0) * interval
            if keys.get('starts_at') is None:
                keys['starts_at'] = DAY_S + _since_midnight(log)
        return keys

    @model_validator(mode='after')
    def _refuse_impossible_combinations(self) -> Scene:
        problems = tuple(self._problems())
        if problems:
            raise PydanticCustomError(
                'combination', '{summary}', {'summary': str(problems[0]), 'problems': problems}
            )
        accuracy, ship = self.accuracy, self.ship
        if accuracy is not None and 'rate' not in ship.model_fields_set and not ship.lies_still:
            hung, case_hz, linear = self.suspension, None, True
            if hung is not None:
                slow, *_, fast = 2 * hung.frequencies(self.g)
                linear = hung.is_linear
                case_hz = fast / (largest_turn(accuracy, linear=linear) * MOST_STEP_PARTS)
                if hung.large_angles:
                    case_hz = max(case_hz, slow / (LARGEST_SLOW_TURN * MOST_STEP_PARTS))
            swinging = self.trochlea is not None and self.trochlea.thread.swinging_length > 0.0
            rate = rate_for(
                self,
                ship,
                accuracy,
                forgets=self.escapement is not None,
                swings=hung is not None or swinging,
                case_hz=case_hz,
                linear=hung is not None and linear and not swinging,
            )
            # set it in the model, since a scene written and read again must have the same rate
            self.__dict__['ship'] = ship.model_copy(update={'rate': rate})
        return self

    @property
    def accuracy(self) -> float | None:
        """Largest error of the reading in a day [s], None with a tolerance."""
        if self.solver is None or (self.solver.accuracy is None and self.solver.tolerance is None):
            return ACCURACY
        return self.solver.accuracy

    def sections_besides(self, *used: str) -> tuple[str, ...]:
        """Return the sections that the scene sets and a study of its machine does not use.

        Machine and gravity are always used. Sections drift, log and solver do not affect a rate.
        """
        sections = 'drag', 'escapement', 'ship', 'suspension', 'air', 'clock', 'voyage'
        fields = type(self).model_fields
        is_set = (name for name in sections if getattr(self, name) != fields[name].default)
        return tuple(name for name in is_set if name not in used)

    @property
    def g(self) -> float:
        """Acceleration of gravity at the start [m/s²], for which the dial is regulated."""
        if self.gravity != 'normal':
            return self.gravity
        if self.voyage is None:  # an error that is reported with all others
            return STANDARD_GRAVITY
        return float(normal_gravity(math.radians(self.voyage.departure[0])))

    @property
    def starts_at_ns(self) -> int:
        """Stamp of the first sample [ns]."""
        return nanoseconds(self.starts_at)

    @property
    def duration_ns(self) -> int:
        """Length of the scene [ns]."""
        return nanoseconds(self.duration)

    @property
    def log_interval_ns(self) -> int:
        """Time between logged samples [ns]."""
        return nanoseconds(self.log.interval)

    @property
    def lies_still(self) -> bool:
        """Whether the forcing is constant: no motion and, for a weight, no change of gravity."""
        feels = self.trochlea is not None and self.trochlea.power.pull.pulling_mass > 0.0
        return self.ship.lies_still and not (self.gravity == 'normal' and feels)

    @property
    def step_ns(self) -> int:
        """Time between samples of ship/imu [ns], for a ship at rest the log interval."""
        return self.log_interval_ns if self.ship.lies_still else step_of_rate(self.ship.rate)

    @property
    def samples(self) -> int:
        """Number of samples of ship/imu within the duration, both ends counted."""
        return self.duration_ns // self.step_ns + 1

    @property
    def samples_beyond_end(self) -> int:
        """Number of samples of ship/imu that the stages need beyond the end."""
        return 0 if self.lies_still else self._lookahead

    @property
    def log_count(self) -> int:
        """Number of logged samples, both ends counted."""
        return self.duration_ns // self.log_interval_ns + 1

    @property
    def keeps_motion(self) -> bool:
        """Whether the bag keeps ship/imu at its full rate."""
        if self.log.motion is None:
            return self.duration <= DAY_S
        return self.log.motion

    @property
    def _lookahead(self) -> int:
        """Samples that interpolation needs beyond the end, twice with a suspension."""
        return LOOKAHEAD if self.suspension is None else 2 * LOOKAHEAD

    def _problems(self) -> Iterator[Problem]:
        """Yield all contradictions between the keys of valid sections."""
        yield from out_of_proportion(self.model_dump(include=set(SECTIONS)))
        yield from self._regulator_problems()
        lunars = self.drift.lunars
        yield from _time_problems(self)
        yield from self.ship.problems()
        yield from self.drift.problems()
        yield from self._suspension_problems()
        if self.voyage is not None:
            yield from self.voyage.problems()
            yield from self._log_problems(self.voyage)
        if self.air is not None:
            yield from self.air.problems(self)
        if self.solver is not None:
            yield from self.solver.problems()
        named = list(self.drift.covariates or ())
        heat = [name for name in named if name.startswith('temperature')]
        yield from problems_where(
            (
                self.voyage is None and self.gravity == 'normal',
                'gravity',
                'normal',
                'depends on latitude, and there is no voyage',
                'Give a number [m/s2], such as 9.80665, or write `voyage: …`.',
            ),
            (
                self.voyage is None and lunars is not None,
                'drift.lunars',
                ABSENT,
                'needs a voyage: in port the time is known better',
                'Write `voyage: …`, or leave lunars out.',
            ),
            (
                'gravity' in named and self.gravity != 'normal',
                'drift.covariates',
                named,
                f'names gravity, which is {self.gravity} m/s2 everywhere in this scene',
                'Write `gravity: normal` and a voyage, or leave gravity out of the list.',
            ),
            (
                heat and self.air is None,
                'drift.covariates',
                named,
                f'names {" and ".join(heat)}, and the scene has no air',
                f'Write `air: …`, or leave {" and ".join(heat)} out of the list.',
            ),
        )

    def _log_problems(self, voyage: Itinerary) -> Iterator[Problem]:
        """Yield the contradictions between a log and the times of the scene."""
        if voyage.log is None or any(voyage.log.problems()):
            return
        begins, end = _since_midnight(voyage.log), voyage.log.at[-1]
        yield from problems_where(
            (
                abs(math.remainder(self.starts_at - begins, DAY_S)) > 1e-6,
                'starts_at',
                self.starts_at,
                f'is another hour of the day than in the log, {begins / 3600.0:.6g} h after '
                'midnight when the scene starts',
                f'Leave it out, or write {DAY_S + begins!r}.',
            ),
            (
                self.duration > end + 2.0 * self.log.interval,
                'duration',
                self.duration,
                f'is longer than the log, which ends {end!r} s after the start',
                'Leave it out, or make it shorter.',
            ),
        )

    def _suspension_problems(self) -> Iterator[Problem]:
        """Yield the problems of the suspension, alone or with the trochlea."""
        if self.suspension is None:
            return
        yield from self.suspension.problems(still=self.lies_still)
        plane = None if self.trochlea is None else self.trochlea.plane
        if self.suspension.plane and plane not in (None, self.suspension.plane):
            yield Problem(
                'trochlea.plane',
                plane,
                f'does not go with suspension.kind {self.suspension.kind}, which holds it '
                f'{self.suspension.plane}',
                'Leave it out.',
            )

    def _regulator_problems(self) -> Iterator[Problem]:
        """Yield the problems of the trochlea or the regulator."""
        if self.regulator is not None:
            sections = {
                'trochlea': self.trochlea,
                'drag': self.drag,
                'escapement': self.escapement,
                'suspension': self.suspension,
            }
            yield from self.regulator.problems(sections, self.ship.kind, still=self.lies_still)
            if self.drift.covariates:
                yield Problem(
                    'drift.covariates',
                    list(self.drift.covariates),
                    'does not go with regulator: covariates are for a trochlea',
                    'Leave it out.',
                )
        if self.trochlea is not None:
            yield from self.trochlea.problems(self.drag, self.escapement, still=self.lies_still)
        if self.escapement is not None:
            yield from self.escapement.problems()
        if self.trochlea is None and self.regulator is None:
            yield Problem(
                'trochlea',
                ABSENT,
                'is missing, and there is no regulator',
                'Write `trochlea: …`, mapping: inertia, cam, thread, power, release_angle; or '
                '`regulator: …`, mapping with `kind`.',
            )


def _since_midnight(log: VoyageLog) -> float:
    """Return the time of day at Greenwich when the scene of a log starts [s]."""
    begins = log.begins
    midnight = begins.replace(hour=0, minute=0, second=0, microsecond=0)
    return ((begins - midnight).total_seconds() - log.harbour_days * DAY_S) % DAY_S


# -----------------------------------------------------------------------------
# Times of a scene: whole nanoseconds, and intervals that divide each other.

# most divisors tried in the search for a log interval
_MOST_TRIED = 100_000


def _time_problems(scene: Scene) -> Iterator[Problem]:
    """Yield the problems of the times of a scene."""
    interval, lunars, overrun = scene.log.interval, scene.drift.lunars, scene._lookahead
    lengths = {
        'duration': scene.duration,
        'drift.observation_interval': scene.drift.observation_interval,
        **({} if lunars is None else {'drift.lunars.interval': lunars.interval}),
    }
    times = {'starts_at': scene.starts_at, 'log.interval': interval, **lengths}
    problems = [
        Problem(key, value, 'is not a whole number of nanoseconds', 'Round it to nine decimals.')
        for key, value in times.items()
        if exact_nanoseconds(value).denominator != 1
    ]
    if not scene.lies_still:
        problems += _rate_problems(scene.ship.rate, interval, scene.ship.shortest_wave_s)
    if problems:
        yield from problems
        return
    yield from _log_grid(
        interval, lengths, 1 if scene.lies_still else scene.step_ns, scene.ship.rate
    )
    end_ns = scene.starts_at_ns + scene.duration_ns + overrun * scene.step_ns
    if end_ns > LAST_STAMP_S * NS_PER_S:
        yield Problem(
            'duration',
            scene.duration,
            f'with {overrun} steps beyond the end the last stamp is '
            f'{Decimal(end_ns) / NS_PER_S:.12g} s; ROS stamps end at {LAST_STAMP_S} s',
            'Shorten it, or let starts_at be earlier.',
        )


def _rate_problems(rate: float, interval: float, shortest_wave_s: float) -> Iterator[Problem]:
    """Return the problem of a sampling rate: its steps are too long, or not whole nanoseconds."""
    step, least_hz = exact_step(rate), 2.0 / shortest_wave_s
    common = (1.0, 2.0, 4.0, 5.0, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 32.0, 40.0, 50.0)
    fast = (64.0, 80.0, 100.0, 125.0, 128.0, 160.0, 200.0, 250.0, 400.0, 500.0, 1000.0)
    enough = [hz for hz in (*common, *fast) if hz > least_hz] or [fast[-1]]
    fitting = [hz for hz in enough if nanoseconds(interval) % exact_step(hz) == 0]
    near = min(fitting or enough, key=lambda hz: abs(math.log(hz / rate)))
    works = f'{1.0 / MAX_GAP_S!r} Hz or more'
    if least_hz >= 1.0 / MAX_GAP_S:
        works = f'more than {least_hz:.6g} Hz, two samples in a wave of {shortest_wave_s!r} s'
    return problems_where(
        (
            step.denominator != 1 or step < 1,
            'ship.rate',
            rate,
            f'makes steps of {float(step):.12g} ns, which must be whole nanoseconds',
            f'Use a rate that divides 1e9, for example {near} Hz.',
        ),
        (
            step.denominator == 1 and step > MAX_GAP_S * NS_PER_S,
            'ship.rate',
            rate,
            f'leaves {float(step) / NS_PER_S:.6g} s between samples of the motion; at most '
            f'{MAX_GAP_S:g} s are interpolated',
            f'Use {works}.',
        ),
    )


def _log_grid(
    interval: float, lengths: Mapping[str, float], step_ns: int, rate: float
) -> Iterator[Problem]:
    """Yield the times that are not multiples of log.interval, or the interval if all are not."""
    interval_ns = nanoseconds(interval)
    odd = {key: value for key, value in lengths.items() if nanoseconds(value) % interval_ns}
    off_steps = interval_ns % step_ns
    # lengths in whole seconds fit the default log interval
    if off_steps or (odd == lengths and all(size.is_integer() for size in lengths.values())):
        text = f'is not a whole number of steps of {_digits(step_ns)} s (ship.rate {rate!r} Hz)'
        words = ', nor '.join(f'{key}, {value!r} s' for key, value in lengths.items())
        yield Problem(
            'log.interval',
            interval,
            text if off_steps else f'does not divide {words}',
            f'Use {_fitting(interval_ns, step_ns, map(nanoseconds, lengths.values()))}.',
        )
        return
    for key, value in odd.items():
        yield Problem(
            key,
            value,
            f'is not a whole number of log intervals (log.interval {interval!r} s)',
            f'Use {_multiple(nanoseconds(value), interval_ns)}, or change log.interval.',
        )


def _fitting(interval_ns: int, step_ns: int, lengths_ns: Iterable[int]) -> str:
    """Return the nearest shorter log interval in whole steps that divides all lengths, if any."""
    steps, remainder = divmod(math.gcd(*lengths_ns), step_ns)
    fewest = math.ceil(steps * step_ns / interval_ns)
    parts = (n for n in range(fewest, fewest + _MOST_TRIED) if n and steps % n == 0)
    n = None if remainder else next(parts, None)
    return f'{_digits(steps // n * step_ns)} s' if n else _multiple(interval_ns, step_ns)


def _multiple(value_ns: int, grid_ns: int) -> str:
    below = value_ns // grid_ns * grid_ns
    return ' or '.join(_digits(ns) for ns in (below, below + grid_ns) if ns) + ' s'


def _digits(length_ns: int) -> str:
    return f'{Decimal(length_ns) / NS_PER_S:.15g}'


# -----------------------------------------------------------------------------
# Values in the mapping of a scene, by the paths of their keys, such as `ship.sea.peak_period`.


def value_at(content: Any, path: str) -> Any:
    """Return the value at a path of names separated by dots, None if absent.

    Items of lists are numbered from 0.
    """
    for name in path.split('.'):
        key = _key_in(content, name)
        content = None if key is None else content[key]
    return content


def unit_at(scene: Scene, path: str) -> str | None:
    """Return the unit, if any, of the key at a path (`value_at`), for an item of its list."""
    node: Any = scene
    unit = None
    for name in path.split('.'):
        if isinstance(node, list | tuple) and name.isdecimal() and int(name) < len(node):
            node = node[int(name)]
        elif isinstance(node, Section) and name in type(node).model_fields:
            unit = declared(type(node).model_fields[name].description)
            node = getattr(node, name)
        else:
            return None
    return unit


def remove_at(content: dict[str, Any], path: str) -> None:
    """Remove the key or item at a path, if it exists, in place."""
    section, _, name = path.rpartition('.')
    node: Any = value_at(content, section) if section else content
    key = _key_in(node, name)
    if key is not None:
        del node[key]


def _key_in(content: Any, name: str) -> str | int | None:
    """Return the key or index for a name in a mapping or list, None if absent."""
    if isinstance(content, list) and name.isdecimal() and int(name) < len(content):
        return int(name)
    return name if isinstance(content, dict) and name in content else None


# -----------------------------------------------------------------------------
# The mapping of a scene as YAML.


class _Dumper(yaml.SafeDumper):
    """Quotes strings that YAML 1.1 or 1.2 would read as another type."""


for _kind, (_pattern, _first_characters) in SCALARS.items():
    _full = re.compile(f'(?:{_pattern.pattern})$')
    _Dumper.add_implicit_resolver(YAML_TAG + _kind, _full, [*_first_characters, ''])


# a key, or its path
_WORD = re.compile(r'[^\W\d][\w.\[\] -]{0,199}')


def read_mapping(text: str, origin: str) -> dict[str, Any]:
    """Return the mapping in a YAML text, or raise SceneError with origin, line and column."""
    try:
        content = read_yaml(text)
    except YamlError as error:
        raise SceneError(origin, '', text, error.problem, error.remedy) from None
    if not isinstance(content, dict):
        names = {list: 'list', str: 'text', bool: 'truth value', int: 'number', float: 'number'}
        kind = 'empty' if content is None else f'a {names[type(content)]}'
        problem = f'is {kind}, but a scene is a mapping of keys to values'
        raise SceneError(origin, '', content, problem, 'Begin with `name: …` and `duration: …`.')
    if any(not _WORD.fullmatch(key) for key in content):
        # the message shows no content, since a file named by mistake may be confidential
        problem = 'has a line that does not begin with a word and a colon: it is not a scene'
        raise SceneError(origin, '', None, problem, 'Name a YAML file of keys and values.')
    return content


def write_mapping(content: dict[str, Any]) -> str:
    """Return a mapping of plain values as YAML; `read_mapping` returns it unchanged."""
    text: str = yaml.dump(content, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=99)
    return text


# keys of a scene that name files
_PATHS = (
    ('air', 'path'),
    ('trochlea', 'cam', 'path'),
    ('ship', 'recorded', 'path'),
    ('ship', 'sea', 'path'),
    ('ship', 'rao', 'path'),
    ('ship', 'hull', 'path'),
    ('ship', 'weather', 'path'),
    ('voyage', 'log', 'path'),
    ('voyage', 'log', 'winds'),
)
_OF_BAGS = 'tauto replay, plot, report, play and bag check'
_SHIPPED = Path(__file__).parent / 'shipped'
# a larger file is not a scene
_LARGEST_FILE = 1_000_000


def shipped_scenes() -> list[str]:
    """Return the sorted names of the built-in scenes."""
    return sorted(file.stem for file in _SHIPPED.glob('*.yaml'))


def _file_of(scene: str) -> Path:
    return _SHIPPED / f'{scene}.yaml' if scene in shipped_scenes() else Path(scene)


def scene_text(scene: str) -> str:
    """Return the text of a scene's file, or raise SceneError."""
    return _read(_file_of(scene), scene)


def load_scene(scene: str | Path | Scene, **overrides: object) -> Scene:
    """Return the scene of a built-in name or a YAML file, or a loaded scene with other values.

    A built-in name takes precedence over a file of that name in the current folder. Write `./name`
    for the file. Relative data paths are resolved against the scene's folder, and the files must
    exist.

    Args:
        scene: for example `measured` or `scenes/mine.yaml`, or a scene.
        overrides: values by key (`duration`) or path (`ship.sea.peak_period`), set before the
            scene is checked. `None` keeps the value of the file. Data paths are relative to the
            working directory.

    Raises:
        SceneError: all problems of the scene, with file, key, value and remedy.
        UsageError: neither a name nor a file.
    """
    values = {key: value for key, value in overrides.items() if value is not None}
    if isinstance(scene, Scene):
        if not values:
            return scene
        content = read_mapping(scene_yaml(scene), scene.name)
        set_values(content, values, scene.name)
        return checked_scene(content, scene.name, values)
    if scene == '':
        raise UsageError('scene: is empty. Give a built-in name or a YAML file')
    if not isinstance(scene, str | Path):
        kind = type(scene).__name__
        raise UsageError(
            f'scene: must be a built-in name or a YAML file, and is of type {kind}. Name one'
        )
    origin, file = str(scene), _file_of(str(scene))
    content = read_mapping(_read(file, origin), origin)
    content = {'name': file.stem} | content
    _resolve_paths(content, file.parent)
    set_values(content, values, origin)
    loaded = checked_scene(content, origin, values)
    problems = []
    if loaded.trochlea is not None:
        for key, path in loaded.trochlea.cam.files():
            problems += missing_file(key, path)
    for key, path, folders in loaded.ship.files():
        problems += missing_file(key, path, folders=folders)
    voyage = loaded.voyage
    # a duration among the overrides may cut the voyage short
    if voyage is not None and voyage.sails_at > loaded.duration and 'duration' not in values:
        why = f'is after the end of the scene, duration {loaded.duration!r} s'
        remedy = 'Let the ship sail earlier, make the scene longer, or leave out voyage.'
        problems.append(Problem('voyage.sails_at', voyage.sails_at, why, remedy))
    if problems:
        raise SceneError.of(origin, tuple(problems))
    return loaded


def origin_of(scene: str | Path | Scene) -> str:
    """Return the name of a scene in errors, as the caller wrote it."""
    return scene.name if isinstance(scene, Scene) else str(scene)


def set_values(content: dict[str, Any], values: Mapping[str, object], origin: str) -> None:
    """Set values in the mapping of a scene by key or path, in place. `ABSENT` removes a key.

    Data paths are relative to the working directory. SceneError for a path that no scene has.
    """
    section = values.get('solver')
    accuracy = values.get('solver.accuracy') or (
        isinstance(section, Mapping) and section.get('accuracy')
    )
    if accuracy and accuracy is not ABSENT:  # it replaces the scene's value
        remove_at(content, 'solver.tolerance')
        if 'ship' not in values:
            remove_at(content, 'ship.rate')
    for path, value in values.items():
        if value is ABSENT:
            check_key(content, path, origin)
            remove_at(content, path)
        else:
            put_value(content, path, value, origin)
    _resolve_paths(content, Path.cwd())


def put_value(content: dict[str, Any], path: str, value: object, origin: str) -> None:
    """Set a copy of a value in the mapping of a scene, in place, converting from NumPy.

    SceneError if the path has an empty name, or leads through a value without keys.
    """
    problem, remedy = 'there is no such key in the scene', 'Name a key of the scene.'
    *sections, leaf = path.split('.')
    node: Any = content
    if all((*sections, leaf)):
        for name in sections:
            if isinstance(node, dict) and node.get(name) is None:
                node[name] = {}
            node = value_at(node, name)
        key = leaf if isinstance(node, dict) else _key_in(node, leaf)
        if key is not None:
            node[key] = _plain(value)
            return
        if isinstance(node, str):  # a section may be replaced by a name, as in `hull: deptford`
            problem = f'{problem}: {".".join(sections)} is {node!r}'
    else:
        problem = 'has an empty name'
        remedy = 'Write names with one dot between two, such as ship.rate.'
    raise SceneError(origin, path or "''", ABSENT, problem, remedy)


def _plain(value: object) -> object:
    """Return a copy with numbers and arrays of NumPy converted to Python."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return copy.deepcopy(value)


def check_key(content: Mapping[str, Any], path: str, origin: str) -> None:
    """Raise SceneError, with the nearest key, for a path that no scene of these kinds has."""
    if value_at(content, path) is not None:
        return
    trial = copy.deepcopy(dict(content))
    put_value(trial, path, 0.0, origin)
    try:
        checked_scene(trial, origin)
    except SceneError as error:
        unknown = [
            item
            for item in error.problems
            if item.problem.startswith(NO_KEY) and f'{path}.'.startswith(f'{item.key}.')
        ]
        if unknown:
            problem, remedy = unknown[0].problem, unknown[0].remedy
            raise SceneError(origin, path, ABSENT, problem, remedy) from None


def parse_scene(text: str, origin: str) -> Scene:
    """Return the scene of a YAML text, such as the `scene` topic of a bag.

    Only files of seas, winds and logs are read; the scene of a bag has their contents instead.
    Other data files need not exist.

    Args:
        text: YAML.
        origin: the source of the text, for error messages.

    Raises:
        SceneError: all problems of the scene, with origin, key, value and remedy.
    """
    return checked_scene(read_mapping(text, origin), origin)


def scene_yaml(scene: Scene) -> str:
    """Return the scene with all defaults as YAML; `parse_scene` returns an equal scene."""
    return write_mapping(scene.model_dump(mode='json', exclude_none=True))


def checked_scene(
    content: dict[str, Any], origin: str, overrides: Mapping[str, object] = MappingProxyType({})
) -> Scene:
    """Return the scene of a mapping from a YAML file, with the errors of `parse_scene`.

    `overrides` are values by path that replaced values of the file. Errors mention it.
    """
    ship = content.get('ship')
    if isinstance(ship, dict):
        models = cast(tuple[type[ShipKind], ...], kinds_in(SHIPS))
        for model in models:
            if kind_of(model) == ship.get('kind'):
                content = content | {'ship': model.with_files_read(ship, origin)}
    if isinstance(content.get('air'), dict):
        content = content | {'air': RecordAir.with_file_read(content['air'], origin)}
    voyage = content.get('voyage')
    if isinstance(voyage, dict) and isinstance(voyage.get('log'), dict):
        from tauto_core.ship.logbook import with_log_read  # few scenes have a log

        content = content | {'voyage': with_log_read(voyage, origin)}
    ship = content.get('ship')
    along_her_way = [content.get('air'), ship.get('weather') if isinstance(ship, dict) else None]
    try:
        if any(map(names_hindcast, along_her_way)):
            from tauto_core.ship.hindcast import with_hindcast_read  # few scenes have one

            # the track follows from the other sections
            left_out = ('ship', 'air', 'suspension', 'drift')
            bare = {key: value for key, value in content.items() if key not in left_out}
            content = with_hindcast_read(content, Scene.model_validate(bare), origin)
        return Scene.model_validate(content)
    except ValidationError as error:
        problems = list(explain(error, Scene))
    for index, item in enumerate(problems):
        place = item.key.replace('[', '.').replace(']', '') + '.'
        path = next((path for path in overrides if place.startswith(f'{path}.')), None)
        if path is not None:
            text = f"{item.problem} ({path} is given, in place of the scene's)"
            problems[index] = Problem(item.key, item.value, text, item.remedy)
    raise SceneError.of(origin, problems)


def _read(file: Path, origin: str) -> str:
    try:
        raw = read_data(file, _LARGEST_FILE)
    except (FileNotFoundError, NotADirectoryError):
        shipped = shipped_scenes()
        matches = difflib.get_close_matches(origin, shipped, 1)
        matches = matches or [name for name in shipped if origin in name][:1]
        guess = f'Did you mean {matches[0]}? ' if matches else 'Check its path and name. '
        problem = 'there is no such file or built-in scene'
        remedy = f'{guess}`tauto scenes` lists the built-in scenes.'
    except IsADirectoryError:
        problem, remedy = 'is a folder', 'Name the YAML file in it.'
        if any(file.glob('*.mcap')):
            problem, remedy = 'is a bag', f'Name a scene. The bag is read by: {_OF_BAGS}.'
    except (OSError, ValueError) as error:
        problem = f'cannot be read: {getattr(error, "strerror", None) or error}'
        remedy = 'Make it readable, or name another file.'
        if getattr(error, 'errno', None) == errno.EFBIG:
            problem = f'is larger than {_LARGEST_FILE} bytes: it is not a scene'
            remedy = 'Name a scene, not its data or a bag.'
    else:
        try:
            return raw.decode('utf-8-sig')
        except UnicodeDecodeError as error:
            problem = f'is not UTF-8 text (byte {error.start})'
            remedy = 'Name a YAML file, saved as UTF-8.'
    raise SceneError(origin, '', origin, problem, remedy) from None


def _resolve_paths(content: dict[str, Any], folder: Path) -> None:
    """Make relative data paths absolute, without validation."""
    for *sections, key in _PATHS:
        section: Any = content
        for name in sections:
            section = section.get(name) if isinstance(section, dict) else None
        path = section.get(key) if isinstance(section, dict) else None
        if isinstance(path, str) and path and not is_shipped(path):
            section[key] = os.path.abspath(folder / path)
