"""A ship in a long-crested sea, and its motion there (theory/sea.md)."""

from __future__ import annotations

import math
from base64 import b64decode
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, Strict, field_validator, model_validator

from tauto_core.curves.numerics import trapezoid
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import ABSENT, Problem, SceneError, problems_where
from tauto_core.scene.sections import Flag, Itinerary, KindIn, key_of_place
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.ship.motions import (
    Channels,
    ShipKind,
    SixMotions,
    StillShip,
    Surroundings,
    UncertainNumber,
    WorstSea,
)
from tauto_core.ship.sea import (
    at_clock,
    band_hz,
    check_operator,
    elevation,
    height_and_period,
    operator_answer,
    roll_answer,
)
from tauto_core.ship.sections import (
    CUTOFF,
    MOTIONS,
    ClockSection,
    Heading,
    HullSection,
    Rao,
    Roll,
    Sea,
    SpectrumTable,
    cutoff_for,
)
from tauto_core.ship.waves import Encounter, Harmonics, together
from tauto_core.ship.weathers import FOLDER as WEATHERS
from tauto_core.ship.weathers import (
    WeatherKind,
    WeatherSetting,
    WeatherState,
    checked,
    fades_of,
    seas_at_once,
    told,
)

if TYPE_CHECKING:
    from tauto_core.ship.hull import ClockPlace, Hull, HullCoefficients, HullError

DAMPING_PARTS = (0.5, 1.5)
"""Range of the roll damping over its given value, since bilges, keel and sails vary it."""

GYRATION_PARTS = (0.88, 1.12)
"""Range of the radius of gyration in pitch over its value: 0.22 to 0.28 of the length."""

CENTRE_PART = 0.08
"""Uncertainty of the height of the centre of gravity over the beam, a metre on 12.6 m, and at most
half of the metacentric height.
"""

MET_ORDER = 10
"""Order of the derivative by which seas are compared: the interpolation error between eight
samples of accelerations, themselves second derivatives, has this order.
"""


SWELL_STREAMS = 1_000_000
"""Offset of streams between simultaneous seas, more than a weather has states."""


DrawnSea: TypeAlias = tuple[Sea | SpectrumTable, int, int]
"""A sea, and the seed and the stream of its waves."""


@dataclass(frozen=True)
class SeaMotion:
    """The waves that a ship meets and its motion in them, at encounter frequencies.

    Attributes:
        roll: [rad], starboard down positive.
        heave: [m], upwards, or `None`.
        unanswered: shares of the waves' energy above and below the frequencies of the operator.
        six: all motions at the clock, of a ship with a hull.
    """

    roll: Harmonics
    heave: Harmonics | None
    unanswered: tuple[float, float] = (0.0, 0.0)
    six: SixMotions[Harmonics] | None = None


@dataclass(frozen=True)
class WeatherScope:
    """The `Surroundings` on which the weather depends. The name is for errors alone."""

    name: str = field(compare=False)
    seed: int
    g: float
    duration: float
    duration_ns: int
    log_interval_ns: int
    voyage: Itinerary | None


@lru_cache(maxsize=16)  # a scene and each clock in its sea read them a dozen times
def _states(setting: WeatherSetting) -> tuple[WeatherState, ...]:
    """Return the states of a weather, or raise a `SceneError` if it does not suit the scene."""
    return checked(setting.weather.resolved(setting), setting.scene)


class SeaShip(ShipKind):
    """Roll, and heave if set, from waves that the ship meets at a speed and heading.

    The waves are one sea, `sea`, or a sequence of seas, `weather`. Roll follows from a roll
    equation, `roll`, or a response amplitude operator, `rao`. Heave equals the elevation, or
    follows from `rao`. An operator with more than roll and heave gives all its motions. A `hull`
    gives all six, with period and damping of the roll from `roll`.
    """

    rank = 3
    starter = {
        'sea': {'spectrum': 'bretschneider', 'significant_wave_height': 2.5, 'peak_period': 9.0},
        'roll': {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7},
        'heave': True,
    }

    is_random = True

    kind: Literal['sea'] = 'sea'
    sea: Annotated[Sea | SpectrumTable | None, Field(discriminator='spectrum')] = Field(
        default=None,
        description='mapping: spectrum, significant_wave_height, peak_period, …; or spectrum '
        'file, path',
        # a table replaces it before the scene is checked
        examples=['file'],
    )
    weather: Annotated[WeatherKind, KindIn(WEATHERS)] | None = Field(
        default=None, description='mapping with `kind`, in place of sea: how the sea changes'
    )
    roll: Roll | None = Field(
        default=None, description='mapping: natural_period, damping_ratio, slope_coefficient'
    )
    rao: Rao | None = Field(default=None, description='mapping: path, heading, length')
    hull: HullSection | None = Field(
        default=None,
        description='mapping: shape (or path), length; or the name of a shape. A hull gives all '
        'six motions',
    )
    clock: ClockSection | None = Field(
        default=None, description='mapping: forward, port: place of the clock in the ship'
    )
    heading: Heading | None = Field(
        default=None,
        description='direction in which the waves run, from the bow to port [rad]: 0 '
        'following seas, 1.5708 beam seas (when left out), 3.1416 head seas',
    )
    speed: Annotated[float, Strict(), Field(ge=0.0, le=50.0)] = Field(
        default=0.0, description='speed of the ship, at most 50 [m/s]'
    )
    heave: Flag = Field(default=False, description='true: heave is simulated')

    @field_validator('hull', mode='before')
    @classmethod
    def _shape_alone(cls, value: Any) -> Any:
        return {'shape': value} if isinstance(value, str) else value

    @model_validator(mode='after')
    def _cut_where_the_hull_is_still(self) -> Self:
        # written out for the scene of a bag. Models are frozen, hence object.__setattr__
        if isinstance(self.sea, Sea) and 'cutoff' not in self.sea.model_fields_set and self.hull:
            cutoff = cutoff_for(self._length, self.sea.peak_period)
            object.__setattr__(self, 'sea', self.sea.model_copy(update={'cutoff': cutoff}))
        if self.weather is not None and self.weather.cutoff is None and self.hull is None:
            weather = self.weather.model_copy(update={'cutoff': CUTOFF})
            object.__setattr__(self, 'weather', weather)
        return self

    @property
    def _length(self) -> float | None:
        """Length of a valid hull [m], or `None`."""
        from tauto_core.ship.hull import HullError

        try:
            return None if self.hull is None else _coefficients(self.hull).length
        except HullError:
            return None  # refused, by key, when the ship sails

    @property
    def relative_heading(self) -> float:
        """Direction in which the waves run, from the bow to port [rad]: of `rao` or `heading`."""
        if self.rao is not None and self.rao.heading is not None:
            return self.rao.heading
        return 0.5 * math.pi if self.heading is None else self.heading

    @property
    def turns_in_space(self) -> bool:
        """Whether it has more motions than roll and heave, by a hull or an operator."""
        return self.hull is not None or (self.rao is not None and self.rao.turns_in_space)

    @classmethod
    def with_files_read(cls, ship: dict[str, Any], origin: str) -> dict[str, Any]:
        """Return its keys with tables and numbers in place of the files of its sea."""
        from tauto_core.ship.sea_files import with_files_read

        return with_files_read(ship, origin)

    @property
    def reported_as(self) -> str:
        """`sea`, or `weather`."""
        return 'sea' if self.weather is None else 'weather'

    def channels(self, scene: Surroundings) -> Channels:
        """Return roll and heave in the sea, or in one sea after another.

        Any state of a weather is refused as `sea_motion` does.
        """
        if self.weather is None:
            sea = sea_motion(scene, self)
            return Channels(
                sea.roll,
                sea.heave,
                six=sea.six,
                metadata=self.metadata(scene),
                warnings=sea_warnings(*sea.unanswered),
            )
        states = self.states(scene)
        above = below = 0.0
        for number, state in enumerate(states):
            for place, alone in enumerate(state.alone):
                if alone.sea is None:
                    continue
                ship = self.in_state(alone)
                low, high = (2.0 * np.pi * edge for edge in band_hz(alone.sea))
                # the encounter frequency may have an extreme within the band
                along = alone.speed * math.cos(alone.heading)
                turns = 0.5 * scene.g / along if along > 0.0 else low
                band = np.array([low, high, min(max(turns, low), high)])
                _check_course(scene, ship, alone)
                _check_rate(scene, ship, band, f'{alone.key}.peak_period')
                if self.rao is not None:
                    shares = sea_motion(scene, ship, number + place * SWELL_STREAMS).unanswered
                    above, below = max(above, shares[0]), max(below, shares[1])

        names = [item.name for item in fields(SixMotions)]
        if not self.turns_in_space:
            names = ['roll', 'heave'] if self.heave else ['roll']

        def motions_of(number: int) -> list[Harmonics]:
            parts = []
            for place, alone in enumerate(states[number].alone):
                motion = sea_motion(scene, self.in_state(alone), number + place * SWELL_STREAMS)
                parts.append([getattr(motion.six or motion, name) for name in names])
            return parts[0] if len(parts) == 1 else list(map(together, zip(*parts, strict=True)))

        setting = self.setting(scene)
        motions = dict(zip(names, fades_of(states, motions_of, len(names)), strict=True))
        return Channels(
            motions['roll'],
            motions.get('heave'),
            six=SixMotions(**motions) if self.turns_in_space else None,
            metadata=self.metadata(scene),
            warnings=(*sea_warnings(above, below), *setting.weather.warnings(setting)),
        )

    def metadata(self, scene: Surroundings) -> dict[str, Any]:
        """Return a description of the sea, or of the seas, and of how the ship meets it."""
        shared: dict[str, Any] = {'seed': scene.seed, 'heave': self.heave or self.turns_in_space}
        if self.rao is not None:
            shared['operator'] = self.rao.source
        elif self.hull is not None:
            length = '' if self.hull.length is None else f', {self.hull.length:g} m'
            shared['hull'] = f'{self.hull.shape or "from a file"}{length}'
        if self.weather is not None:
            states = self.states(scene)
            heights = [state.height for state in states]
            return {
                'kind': self.weather.kind,
                'components': self.weather.components,
                **shared,
                'highest_m': max(heights),
                'median_m': float(np.median(heights)),
                'seas_at_once': seas_at_once(states, scene.duration_ns),
                **self.weather.facts(),
                'states': told(states),
            }
        sea = self.sea
        assert sea is not None
        height, period = height_and_period(sea)
        metadata: dict[str, Any] = {
            'spectrum': sea.spectrum,
            'significant_wave_height_m': height,
            'peak_period_s': period,
            'components': sea.components,
            'band_hz': list(band_hz(sea)),
            'seed': shared.pop('seed'),
            'heading_rad': self.relative_heading,
            'speed_m_s': self.speed,
            **shared,
        }
        if isinstance(sea, SpectrumTable):
            metadata['source'] = sea.source
        elif sea.spectrum == 'jonswap':
            metadata['gamma'] = sea.gamma
        if self.roll is not None and self.roll.fitted_to is not None:
            metadata['roll_fitted_to'] = self.roll.fitted_to
        return metadata

    def states(self, scene: Surroundings) -> tuple[WeatherState, ...]:
        """Return the states of the weather. A `SceneError` refuses one that misfits the scene."""
        return _states(self.setting(scene))

    def setting(self, scene: Surroundings) -> WeatherSetting:
        """Return scene and ship for which the weather is resolved."""
        assert self.weather is not None
        scope = WeatherScope(**{f.name: getattr(scene, f.name) for f in fields(WeatherScope)})
        return WeatherSetting(scope, self.weather, self.relative_heading, self.speed, self._length)

    def in_state(self, state: WeatherState) -> Self:
        """Return the ship in the sea of one state."""
        keys = {'sea': state.sea, 'weather': None, 'speed': state.speed}
        if self.rao is None or self.rao.heading is None:
            keys['heading'] = state.heading
        return self.model_copy(update=keys)

    def roughest(self, scene: Surroundings) -> ShipKind:
        """Return the ship in the highest of its seas."""
        if self.weather is None:
            return self
        seas = [sea for state in self.states(scene) for sea in state.alone]
        highest = max(seas, key=lambda state: state.height)
        # a shortened voyage may end in a calm
        return StillShip() if highest.sea is None else self.in_state(highest)

    def worst_seas(self, scene: Surroundings) -> tuple[WorstSea, ...]:
        """Return the ship in the highest of its seas and in the one with the fastest waves met.

        A high sea makes the clock swing irregularly, and short waves from ahead are sampled worst.
        The fastest waves are those with the largest derivative of order `MET_ORDER` of the motion,
        in which only frequencies with energy count. They last in proportion to it.
        """
        if self.weather is None:
            return super().worst_seas(scene)
        states = self.states(scene)
        # the worst of simultaneous seas
        steepest = [
            max(state.alone, key=lambda sea: self._abruptness(scene, sea))
            if state.swell
            else state
            for state in states
        ]
        tallest = [max(state.alone, key=lambda sea: sea.height) for state in states]
        highest = max(range(len(states)), key=lambda number: tallest[number].height)
        abrupt = np.array([self._abruptness(scene, state) for state in steepest])
        fastest = int(np.argmax(abrupt))
        reasons = {highest: 'highest'}
        reasons[fastest] = 'highest and met fastest' if fastest == highest else 'met fastest'
        at_s = np.array([state.at_ns for state in states]) / NS_PER_S
        changes = at_s[(at_s > 0.0) & (at_s < scene.duration)]
        times = np.concatenate([[0.0], changes, [scene.duration]])
        lasts_s = trapezoid(np.interp(times, at_s, abrupt), times)
        lasts_s = lasts_s / abrupt[fastest] if abrupt[fastest] > 0.0 else scene.duration
        return tuple(
            WorstSea(
                why,
                told((state,))[0],
                # a shortened voyage may end in a calm
                StillShip() if state.sea is None else self.in_state(state),
                lasts_s if number == fastest else scene.duration,
            )
            for number, why in reasons.items()
            for state in [steepest[number] if number == fastest else tallest[number]]
        )

    def seas_at_start(self, scene: Surroundings) -> tuple[ShipKind, ...]:
        """Return the ship in each sea between which the weather changes at the start."""
        if self.weather is None:
            return super().seas_at_start(scene)
        states = self.states(scene)
        index = next((k for k, state in enumerate(states) if state.at_ns > 0), len(states))
        pair = states[max(index - 1, 0) : index + 1]
        seas = [sea for state in pair for sea in state.alone if sea.sea is not None]
        return tuple(self.in_state(sea) for sea in seas)

    def _abruptness(self, scene: Surroundings, state: WeatherState) -> float:
        """Return the norm of the derivative of order `MET_ORDER` of the motion in a state."""
        if state.sea is None:
            return 0.0
        motion = sea_motion(scene, self.in_state(state))
        wave = motion.roll if motion.heave is None else motion.heave
        met = 2.0 * math.pi / wave.period
        return float(np.linalg.norm(wave.amplitude * met**MET_ORDER))

    def known_roughly(self, scene: Surroundings) -> Iterator[UncertainNumber]:
        """Yield the roll damping and, with a hull, two figures of its weights (hull.md)."""
        if self.roll is not None:
            low, high = (part * self.roll.damping_ratio for part in DAMPING_PARTS)
            yield UncertainNumber(
                'ship.roll.damping_ratio',
                '',
                (low, high),
                (self._with('roll', damping_ratio=low), self._with('roll', damping_ratio=high)),
            )
        if self.hull is None or self.roll is None:
            return
        hull = _made_hull(self.hull, self.roll, scene.g)
        k_yy = 0.25 * hull.coefficients.length if self.hull.k_yy is None else self.hull.k_yy
        # half of the metacentric height makes as tender a ship as any
        aside = min(CENTRE_PART * hull.coefficients.beam, 0.5 * hull.gm)
        for key, low, high in (
            ('k_yy', GYRATION_PARTS[0] * k_yy, GYRATION_PARTS[1] * k_yy),
            ('centre_of_gravity', hull.z_g - aside, hull.z_g + aside),
        ):
            ships = self._with('hull', **{key: low}), self._with('hull', **{key: high})
            yield UncertainNumber(f'ship.hull.{key}', 'm', (low, high), ships)

    def _with(self, section: str, **values: float) -> Self:
        changed = getattr(self, section).model_copy(update=values)
        return self.model_copy(update={section: changed})

    @property
    def roll_scales(self) -> bool:
        """False with more motions than roll and heave, since the roll is coupled to others."""
        return not self.turns_in_space

    def with_roll_scaled(self, factor: float) -> Self:
        """Return the ship with its slope coefficient, or its roll operator, times a factor."""
        if self.roll is not None:
            # missing only with a hull, and its roll does not scale
            assert self.roll.slope_coefficient is not None
            slope = factor * self.roll.slope_coefficient
            roll = self.roll.model_copy(update={'slope_coefficient': slope})
            return self.model_copy(update={'roll': roll})
        assert self.rao is not None  # a scene has roll or rao
        parts = {
            key: tuple(factor * value for value in getattr(self.rao, key) or ())
            for key in ('roll_real', 'roll_imaginary')
        }
        return self.model_copy(update={'rao': self.rao.model_copy(update=parts)})

    def problems(self) -> Iterator[Problem]:
        """Yield the contradictions between its keys."""
        sea, weather, roll, rao = self.sea, self.weather, self.roll, self.rao
        clock, bare = self.clock, self.hull is None
        # by default the longest ship. A ship is at most half as wide as long
        length = (rao and rao.length) or 400.0
        place = clock or ClockSection()
        sides = (('forward', place.forward, 0.5 * length), ('port', place.port, 0.25 * length))
        if sea is not None:
            yield from sea.problems(self.rate)
        if weather is not None:
            yield from weather.problems(self.rate)
        yield from problems_where(
            (
                weather is not None and weather.follow_route and self.speed,
                'ship.speed',
                self.speed,
                'does not go with ship.weather.follow_route: the voyage gives the speed',
                'Leave one of them out.',
            ),
            (
                sea is None and weather is None,
                'ship.sea',
                ABSENT,
                'is missing, and there is no weather in its place',
                'Write `sea: …`, mapping: spectrum, significant_wave_height, peak_period, …; '
                'or `weather: …`, mapping with `kind`.',
            ),
            (
                sea is not None and weather is not None,
                'ship.weather',
                ABSENT,
                'does not go with ship.sea: the sea is one, or one after another',
                'Leave one of them out.',
            ),
            (
                roll is None and rao is None,
                'ship.roll',
                ABSENT,
                'is missing, and there is no rao in its place',
                'Write `roll: …`, mapping: natural_period, damping_ratio, slope_coefficient; '
                'or `rao: …`, mapping: path, heading.',
            ),
            (
                roll is not None and rao is not None,
                'ship.rao',
                ABSENT,
                'does not go with ship.roll: the roll follows from one of them',
                'Leave one of them out.',
            ),
            (
                self.heading is not None and rao is not None and rao.heading is not None,
                'ship.heading',
                self.heading,
                'does not go with ship.rao, which has its own heading',
                'Give it as ship.rao.heading.',
            ),
            (
                bare and roll is not None and roll.slope_coefficient is None,
                'ship.roll.slope_coefficient',
                ABSENT,
                'is missing, and there is no hull',
                'Write for example `slope_coefficient: 0.7`, or `hull: sloop` in ship.',
            ),
            (
                bare and clock is not None and not self.turns_in_space,
                'ship.clock',
                ABSENT,
                'is a place in a hull, which the ship lacks',
                'Write `hull: …` in ship, or leave it out.',
            ),
            (
                not bare and rao is not None,
                'ship.hull',
                ABSENT,
                'does not go with ship.rao: the motions follow from one of them',
                'Leave one of them out.',
            ),
            *(
                (
                    bare and rao is not None and not abs(at) <= limit,
                    f'ship.clock.{key}',
                    at,
                    f'must be in [{-limit:g}, {limit:g}] m: the clock is outside the ship',
                    "Measure from the operator's origin.",
                )
                for key, at, limit in sides
            ),
        )
        if self.hull is not None:
            yield from self.hull.problems()
        if rao is not None:
            yield from rao.problems(heave=self.heave)

    @property
    def motions(self) -> tuple[str, ...]:
        """All with a hull, the operator's, or roll and, if set, heave."""
        if self.hull is not None:
            return MOTIONS
        if self.turns_in_space:
            assert self.rao is not None
            return self.rao.motions
        return ('heave', 'roll') if self.heave else ('roll',)


@lru_cache(maxsize=16)
def _coefficients(keys: HullSection) -> HullCoefficients:
    from tauto_core.ship.hull import hull_of_file, named_hull

    if keys.shape is not None:
        table = named_hull(keys.shape)
    else:
        table = hull_of_file(b64decode(keys.table or ''), 'ship.hull.table')
    return table if keys.length is None else table.scaled(keys.length)


@lru_cache(maxsize=16)
def _made_hull(keys: HullSection, roll: Roll, gravity: float) -> Hull:
    from tauto_core.ship.hull import Hull, HullError

    hull = Hull(
        _coefficients(keys),
        roll_period=roll.natural_period,
        roll_damping_ratio=roll.damping_ratio,
        gravity=gravity,
        k_xx=keys.k_xx,
        k_yy=keys.k_yy,
        k_zz=keys.k_zz,
        centre_of_gravity=keys.centre_of_gravity,
    )
    # C44 follows from the period, so the hull by itself would move with any centre of gravity
    if keys.centre_of_gravity is not None and keys.centre_of_gravity >= hull.metacentre:
        raise HullError(
            'centre_of_gravity',
            keys.centre_of_gravity,
            f'must be below the metacentre, {hull.metacentre:.3g} m over the waterline: with a '
            'negative metacentric height the ship capsizes',
            'Leave it out: it then follows from the period of the roll.',
        )
    return hull


ANSWERS_KEPT = 1024
"""Seas with motions kept in memory, 9 kB each: a passage needs each of them many times."""


@lru_cache(maxsize=ANSWERS_KEPT)
def _answered(
    keys: HullSection, roll: Roll, place: ClockPlace, course: Encounter, sea: DrawnSea
) -> SixMotions[Harmonics]:
    """Return the motions of a hull at a place on board, in one sea.

    Raises:
        HullError: a speed beyond the validity of the coefficients, or a place outside the hull.
    """
    waves, hull = elevation(*sea), _made_hull(keys, roll, course.gravity)
    hull.check_place(place)
    response = hull.response(waves.angular_frequency, course.heading, course.speed)
    return at_clock(waves, response, place, course)


def _in_keys(scene: Surroundings, error: HullError) -> SceneError:
    """Return the refusal of a hull or an operator in terms of a scene's keys."""
    problem = error.problem
    key = _KEYS_OF_HULLS.get(problem.key, f'hull.{problem.key}')
    return SceneError(scene.name, f'ship.{key}', problem.value, problem.problem, problem.remedy)


def _check_course(scene: Surroundings, ship: SeaShip, state: WeatherState) -> None:
    """Refuse a state's heading or speed that the hull or operator does not cover."""
    from tauto_core.ship.hull import HullError
    from tauto_core.ship.passage import Passage

    try:
        if ship.rao is not None:
            check_operator(ship.rao, ship.relative_heading, ship.speed)
        elif ship.hull is not None and ship.roll is not None:
            _made_hull(ship.hull, ship.roll, scene.g).check_speed(ship.speed)
    except HullError as error:
        problem, voyage = error.problem, scene.voyage
        if problem.key not in ('speed', 'heading'):
            raise _in_keys(scene, error) from None  # a fault on any course
        where = f'after {state.at_ns / NS_PER_S / DAY_S:.3g} days'
        if voyage is not None:
            times = Passage(scene, voyage).places_ns
            end = min(max(bisect_right(times, state.at_ns), 1), len(times) - 1)
            ends = (key_of_place(voyage, place) for place in (end - 1, end))
            where += f', on the leg from {" to ".join(ends)}'
        raise SceneError(
            scene.name,
            state.key,
            problem.value,
            f'{where}: {problem.key} {problem.problem}',
            problem.remedy,
        ) from None


_KEYS_OF_HULLS = {
    'roll_period': 'roll.natural_period',
    'roll_damping_ratio': 'roll.damping_ratio',
    'speed': 'speed',
    'heading': 'heading',
    'clock.forward': 'clock.forward',
    'clock.port': 'clock.port',
    'clock.up': 'height',
}


def course_of(scene: Surroundings, ship: SeaShip) -> Encounter:
    """Return speed and heading of the ship of a scene in the waves."""
    return Encounter(ship.speed, ship.relative_heading, scene.g)


def sea_motion(scene: Surroundings, ship: SeaShip, stream: int = 0) -> SeaMotion:
    """Return waves, roll and heave of a ship in one sea. Each state of a weather has a stream.

    Raises:
        SceneError: waves too short for `ship.rate`, or a speed or heading that the hull or
            operator does not cover.
    """
    assert ship.sea is not None
    course = course_of(scene, ship)
    waves = elevation(ship.sea, scene.seed, stream)
    parametric = isinstance(ship.sea, Sea)
    key = 'ship.sea.peak_period' if parametric else 'ship.sea.frequency'
    highest = 2.0 * np.pi * band_hz(ship.sea)[1]
    _check_rate(scene, ship, np.append(waves.angular_frequency, highest), key)
    if ship.roll is not None and ship.hull is None:
        roll = roll_answer(waves, ship.roll, course)
        return SeaMotion(roll, course.met(waves) if ship.heave else None)
    from tauto_core.ship.hull import ClockPlace, HullError, Response

    clock = ship.clock or ClockSection()
    place = ClockPlace(clock.forward, clock.port, ship.height)
    try:
        if ship.hull is not None and ship.roll is not None:
            sea = (ship.sea, scene.seed, stream)
            six = _answered(ship.hull, ship.roll, place, course, sea)
            return SeaMotion(six.roll, six.heave, six=six)
        assert ship.rao is not None  # a scene has roll or rao
        answer = operator_answer(waves, ship.rao, course, heave=ship.heave)
    except HullError as error:
        raise _in_keys(scene, error) from None
    parts, shares = answer.waves, (answer.above, answer.below)
    omega = parts.angular_frequency
    if ship.turns_in_space:
        zeros = np.zeros(len(omega), np.complex128)
        motions = np.stack([answer.motions.get(name, zeros) for name in MOTIONS], axis=1)
        response = Response(omega, course.frequency(omega), motions, scene.g)
        six = at_clock(parts, response, place, course)
        return SeaMotion(six.roll, six.heave, shares, six)
    answers = {
        name: course.answer(parts, parts.amplitude * np.abs(operator), np.angle(operator))
        for name, operator in answer.motions.items()
    }
    return SeaMotion(answers['roll'], answers.get('heave'), shares)


def _check_rate(scene: Surroundings, ship: SeaShip, omega: FloatArray, key: str) -> None:
    """Refuse waves that are too short for the samples of the motion."""
    assert ship.sea is not None
    shortest = float(np.max(np.abs(course_of(scene, ship).frequency(omega)))) / (2.0 * np.pi)
    if shortest < 0.5 * ship.rate:
        return
    parametric = isinstance(ship.sea, Sea)
    meets = '' if ship.speed == 0.0 else f', met at {ship.speed:g} m/s,'
    raise SceneError(
        scene.name,
        key,
        height_and_period(ship.sea)[1] if parametric else band_hz(ship.sea)[1],
        f'the shortest waves{meets} have {shortest:.6g} Hz, which must be below half of '
        f'ship.rate ({ship.rate!r} Hz)',
        f'Raise ship.rate above {2.0 * shortest:.6g} Hz.',
    )


def sea_warnings(above: float, below: float) -> tuple[str, ...]:
    """Return warnings of energy shares above and below the frequencies of the operator."""
    cases = (
        (above, 'above', 'not to move the ship'),
        (below, 'below', 'to move it as their surface does'),
    )
    return tuple(
        f'{100.0 * share:.2g} % of the energy of the waves is {where} the frequencies of '
        f'ship.rao: these waves are taken {how}'
        for share, where, how in cases
        if share
    )


KIND = SeaShip
