"""The kinds of weather: their base, lists of states of the sea, and records of buoys."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, Strict

from tauto_core.scene.errors import ABSENT, Problem, SceneError, problems_where
from tauto_core.scene.sections import Flag, Kind, OneLine, Positive, SceneTime, Section
from tauto_core.scene.times import LAST_STAMP_S, NS_PER_S, nanoseconds, whole_intervals
from tauto_core.ship.motions import Surroundings, sampled
from tauto_core.ship.sections import CUTOFF_MEANS, ComponentCount, Cutoff, Heading, Sea, cutoff_for
from tauto_core.ship.waves import Fades, Harmonics
from tauto_core.wording import counted

if TYPE_CHECKING:
    from tauto_core.ship.passage import Passage


FOLDER = 'tauto_core.ship.weathers'

LEAST_CHANGE_S = 600.0
"""Shortest time in which one sea changes into another [s]. It is long compared with the waves. The
jump of the fourth derivative at its ends is below the rounding of the interpolation.
"""

HIGHEST_M = 30.0
"""Limit of significant wave height, above any known sea [m]."""

Height = Annotated[float, Strict(), Field(gt=0.0, le=HIGHEST_M)]


@dataclass(frozen=True)
class WeatherState:
    """A sea that is fully established at an instant.

    Attributes:
        at_ns: time from the start of the scene, possibly negative.
        sea: the sea, or `None` in a calm.
        heading: direction in which the waves run, from the bow to port [rad].
        speed: speed of the ship [m/s].
        key: the scene's key, for error messages.
        swell: a second sea at the same time, with its own heading, and so on.
    """

    at_ns: int
    sea: Sea | None
    heading: float
    speed: float
    key: str
    swell: WeatherState | None = None

    @property
    def height(self) -> float:
        """Significant wave height of all seas together [m]."""
        size = 0.0 if self.sea is None else self.sea.significant_wave_height
        return size if self.swell is None else math.hypot(size, self.swell.height)

    @property
    def alone(self) -> tuple[WeatherState, ...]:
        """A state for each of its seas."""
        if self.swell is None:
            return (self,)
        return (replace(self, swell=None), *self.swell.alone)

    def goes_on(self, previous: WeatherState) -> bool:
        """Return whether the seas are the same as in the previous state."""
        ours, theirs = (
            [(one.sea, one.sea and (one.heading, one.speed)) for one in state.alone]
            for state in (self, previous)
        )
        return ours == theirs


class WeatherKind(Kind):
    """How the sea changes."""

    spectrum: Literal['bretschneider', 'jonswap'] = Field(
        default='bretschneider', description='spectrum of the seas: bretschneider or jonswap'
    )
    gamma: Annotated[float, Strict(), Field(ge=1.0, le=10.0)] = Field(
        default=3.3, description='peak enhancement factor of jonswap, 1 to 10'
    )
    components: ComponentCount = Field(
        default=64, description='number of components of each sea, 1 to 4096'
    )
    cutoff: Cutoff | None = Field(default=None, description=CUTOFF_MEANS)
    follow_route: Flag = Field(
        default=False,
        description='true: the voyage sets the speed, and its course made good the heading if the '
        'direction of the waves is known',
    )
    kind: str

    def resolved(self, setting: WeatherSetting) -> tuple[WeatherState, ...]:
        """Return the states in the order of their times.

        Raises:
            SceneError: the weather does not suit the scene.
        """
        raise NotImplementedError

    def problems(self, rate_hz: float) -> Iterator[Problem]:
        """Yield the contradictions between its keys, with the rate of the motion's samples."""
        return iter(())

    def facts(self) -> dict[str, object]:
        """Return facts about the weather for reports, in addition to its states."""
        return {}

    def warnings(self, setting: WeatherSetting) -> tuple[str, ...]:
        """Return warnings for the user."""
        return ()


@dataclass(frozen=True)
class WeatherSetting:
    """Scene and ship for which the states of a weather are computed.

    Attributes:
        heading: default heading of the waves [rad].
        speed: default speed of the ship [m/s].
        length: length of the hull [m], or `None` for a ship without a hull.
    """

    scene: Surroundings
    weather: WeatherKind
    heading: float
    speed: float
    length: float | None = None

    @cached_property
    def passage(self) -> Passage | None:
        """The passage of the scene's voyage, if any."""
        from tauto_core.ship.passage import Passage

        voyage = self.scene.voyage
        return None if voyage is None else Passage(self.scene, voyage)

    def passage_for(self, key: str, value: object) -> Passage:
        """Return the passage that a key needs.

        Raises:
            SceneError: the scene has no voyage.
        """
        if self.passage is None:
            problem = 'needs a voyage, and the scene has no voyage'
            remedy = 'Write `voyage: …`, or give times, headings and speeds in numbers.'
            raise SceneError(self.scene.name, key, value, problem, remedy)
        return self.passage

    def time_of(self, section: Any, key: str) -> int:
        """Return the time `at` of a section, or of the place `waypoint`, or 0 [ns].

        Raises:
            SceneError: there is no such place.
        """
        if section.at is not None or section.waypoint is None:
            return nanoseconds(section.at or 0.0)
        key, place = f'{key}.waypoint', int(section.waypoint)
        times = self.passage_for(key, place).places_ns
        if place < len(times):
            return times[place]
        problem = f'is not a place of the voyage, which has {len(times)}: 0 is the departure, '
        problem += f'{len(times) - 1} the arrival'
        remedy = f'Give a number from 0 to {len(times) - 1}, or `at: …` in seconds.'
        raise SceneError(self.scene.name, key, place, problem, remedy)

    def calm(self, at_ns: int, key: str) -> WeatherState:
        """Return a state without waves."""
        return WeatherState(at_ns, None, self.heading, self.speed, key)

    def state(
        self,
        at_ns: int,
        height: float,
        period: float,
        key: str,
        *,
        spectrum: Literal['bretschneider', 'jonswap'] | None = None,
        heading: float | None = None,
        waves_to: float | None = None,
        speed: float | None = None,
        cutoff: float | None = None,
    ) -> WeatherState:
        """Return a state with waves.

        Args:
            at_ns: time at which it is fully established.
            height: significant wave height [m].
            period: period of the peak [s].
            key: the scene's key, for error messages.
            spectrum: the spectrum, by default the weather's.
            heading: direction in which the waves run, from the bow to port [rad].
            waves_to: the same from north to the east [rad], for `follow_route`.
            speed: speed of the ship [m/s], without `follow_route`.
            cutoff: cutoff of the spectrum, unless the weather gives it.

        Raises:
            SceneError: a sea higher than any known, or no voyage to follow.
        """
        if height > HIGHEST_M:
            problem = f'makes a sea of {height:.3g} m, higher than any known ({HIGHEST_M:g} m)'
            remedy = 'Correct it, or its unit.'
            raise SceneError(self.scene.name, key, ABSENT, problem, remedy)
        weather = self.weather
        shape = spectrum or weather.spectrum
        sea = Sea(
            spectrum=shape,
            significant_wave_height=height,
            peak_period=period,
            components=weather.components,
            cutoff=weather.cutoff or cutoff or cutoff_for(self.length, period),
            **({'gamma': weather.gamma} if shape == 'jonswap' else {}),
        )
        if weather.follow_route:
            passage = self.passage_for('ship.weather.follow_route', True)
            speed = passage.speed_m_s(at_ns)
            if waves_to is not None:
                heading = (passage.course(at_ns) - waves_to) % math.tau
        return WeatherState(
            at_ns,
            sea,
            self.heading if heading is None else heading,
            self.speed if speed is None else speed,
            key,
        )


def checked(states: Sequence[WeatherState], scene: Surroundings) -> tuple[WeatherState, ...]:
    """Return the states. Raise `SceneError` if times do not increase or a change is too quick."""
    for previous, state in pairwise(states):
        apart_s = (state.at_ns - previous.at_ns) / NS_PER_S
        if apart_s <= 0.0:
            problem = f'is at {state.at_ns / NS_PER_S:g} s, not later than the state before, at '
            problem += f'{previous.at_ns / NS_PER_S:g} s'
            remedy = 'Give the states in the order of their times.'
            raise SceneError(scene.name, state.key, ABSENT, problem, remedy)
        if apart_s < LEAST_CHANGE_S and not state.goes_on(previous):
            problem = f'comes {apart_s:g} s after the state before, and a sea takes at least '
            problem += f'{LEAST_CHANGE_S:g} s to turn into another'
            raise SceneError(scene.name, state.key, ABSENT, problem, 'Put them further apart.')
    return tuple(states)


# -----------------------------------------------------------------------------
# A ship's motion in each state of the sea, and how reports describe the states.


def sums_of(states: Sequence[WeatherState]) -> tuple[int, ...]:
    """Return the index of each state's sum of harmonics. Equal consecutive states share one."""
    sums = [0]
    for number, (previous, state) in enumerate(pairwise(states), 1):
        sums.append(sums[-1] if state.goes_on(previous) else number)
    return tuple(sums)


def fades_of(
    states: Sequence[WeatherState], motions_of: Callable[[int], Sequence[Harmonics]], count: int
) -> list[Fades]:
    """Return `count` motions that change from state to state."""
    at_ns, sums = tuple(state.at_ns for state in states), sums_of(states)
    memo = lru_cache(maxsize=4)(motions_of)

    def motion(index: int, number: int) -> Harmonics | None:
        return None if states[number].sea is None else memo(number)[index]

    return [Fades(at_ns, sums, partial(motion, index)) for index in range(count)]


def seas_at_once(states: Sequence[WeatherState], duration_ns: int) -> float:
    """Return the average number of seas that are summed at an instant of the scene, 0 to 2."""
    edges = np.array([0, *(state.at_ns for state in states), duration_ns])
    lengths = np.diff(np.clip(edges, 0, max(duration_ns, 1)))
    sums = sums_of(states)
    pairs = [(sums[0],), *pairwise(sums), (sums[-1],)]
    seas = [sum(sea.sea is not None for sea in state.alone) for state in states]
    present = [sum(seas[number] for number in set(pair)) for pair in pairs]
    return float(np.dot(lengths, present) / max(lengths.sum(), 1))


def told(states: Sequence[WeatherState]) -> list[dict[str, Any]]:
    """Return the states as rows of numbers. A calm has height 0 and `None` for the rest.

    A state with several seas has the first in its row, and the others in `swells`.
    """

    def row(state: WeatherState) -> dict[str, Any]:
        sea = state.sea
        return {
            'at_s': state.at_ns / NS_PER_S,
            'significant_wave_height_m': 0.0 if sea is None else sea.significant_wave_height,
            'peak_period_s': None if sea is None else sea.peak_period,
            'heading_rad': None if sea is None else state.heading,
            'speed_m_s': None if sea is None else state.speed,
        }

    return [
        row(state) | ({'swells': list(map(row, state.alone[1:]))} if state.swell else {})
        for state in states
    ]


# -----------------------------------------------------------------------------
# A list of states of the sea.

_OF_WAVES = ('significant_wave_height', 'peak_period', 'spectrum', 'heading', 'waves_to', 'speed')


def time_problems(section: Any, key: str) -> Iterator[Problem]:
    """Yield a problem unless a section has either `at` or `waypoint`."""
    if section.at is not None and section.waypoint is not None:
        problem, remedy = 'does not go with waypoint', 'Leave one of them out.'
        yield Problem(f'{key}.at', section.at, problem, remedy)
    elif section.at is None and section.waypoint is None:
        problem = 'is missing, and there is no waypoint in its place'
        remedy = 'Write `at: …`, time from the start [s], or `waypoint: …`, number of a place.'
        yield Problem(f'{key}.at', ABSENT, problem, remedy)


def wave_problems(
    section: Any, key: str, names: Sequence[str], rate_hz: float
) -> Iterator[Problem]:
    """Yield the contradictions between `still` and the other keys of waves, `names`."""
    for name in names:
        value = getattr(section, name)
        if section.still and value is not None:
            problem = 'does not go with still: a calm has no waves'
            yield Problem(f'{key}.{name}', value, problem, 'Leave out one of them.')
        elif not section.still and value is None and name in names[:2]:
            remedy = f'Write `{name}: …`, or `still: true` for a calm.'
            yield Problem(f'{key}.{name}', ABSENT, 'is missing', remedy)
    if section.peak_period is not None:
        yield from sampled(f'{key}.peak_period', section.peak_period, rate_hz)


class SeaState(Section):
    """A sea that is fully established at an instant. It builds up from the state before."""

    at: SceneTime | None = Field(default=None, description='time from the start [s]')
    waypoint: Annotated[int, Strict(), Field(ge=0)] | None = Field(
        default=None,
        description='or the number of a place of the voyage: 0 the departure, then the '
        'waypoints, then the arrival',
    )
    still: Flag = Field(default=False, description='true: no waves')
    significant_wave_height: Height | None = Field(
        default=None, description='significant wave height, at most 30 [m]'
    )
    peak_period: Positive | None = Field(
        default=None, description='period of the spectral peak [s]'
    )
    spectrum: Literal['bretschneider', 'jonswap'] | None = Field(
        default=None, description="bretschneider or jonswap, by default the weather's spectrum"
    )
    heading: Heading | None = Field(
        default=None,
        description='direction in which the waves run, from the bow to port, by default '
        'ship.heading [rad]',
    )
    waves_to: Heading | None = Field(
        default=None,
        description='with follow_route: direction in which the waves run, from north to the east '
        '[rad]',
    )
    speed: Annotated[float, Strict(), Field(ge=0.0, le=50.0)] | None = Field(
        default=None, description='speed of the ship, by default ship.speed [m/s]'
    )

    def problems(self, key: str, rate_hz: float, *, follow_route: bool) -> Iterator[Problem]:
        """Yield the contradictions between its keys. `key` is its own."""
        yield from time_problems(self, key)
        yield from wave_problems(self, key, _OF_WAVES, rate_hz)
        turned, waves_to = self.heading is not None, self.waves_to
        yield from problems_where(
            (
                waves_to is not None and turned,
                f'{key}.waves_to',
                waves_to,
                'does not go with heading: either gives the direction of the waves',
                'Leave one of them out.',
            ),
            (
                waves_to is not None and not turned and not follow_route,
                f'{key}.waves_to',
                waves_to,
                'needs the course made good',
                'Write `follow_route: true` in ship.weather, or give heading.',
            ),
            (
                self.speed is not None and follow_route,
                f'{key}.speed',
                self.speed,
                'does not go with follow_route: the voyage has a speed',
                'Leave one of them out.',
            ),
        )


class StatesWeather(WeatherKind):
    """Seas at given times, each changing gradually into the next.

    A change takes the whole time between two states. The sea is constant before the first state,
    after the last, and between equal states.
    """

    rank = 1
    starter: ClassVar[Mapping[str, Any]] = {
        'states': [
            {'at': 0.0, 'still': True},
            {'at': 3600.0, 'significant_wave_height': 2.5, 'peak_period': 9.0},
        ]
    }

    kind: Literal['states'] = 'states'
    states: Annotated[tuple[SeaState, ...], Field(max_length=10_000)] = Field(
        description='list of states of the sea, each with at or waypoint'
    )

    def resolved(self, setting: WeatherSetting) -> tuple[WeatherState, ...]:
        """Return the listed states."""
        states = []
        for index, state in enumerate(self.states):
            key = f'ship.weather.states[{index}]'
            at_ns = setting.time_of(state, key)
            if state.significant_wave_height is None or state.peak_period is None:
                states.append(setting.calm(at_ns, key))
                continue
            states.append(
                setting.state(
                    at_ns,
                    state.significant_wave_height,
                    state.peak_period,
                    key,
                    spectrum=state.spectrum,
                    heading=state.heading,
                    waves_to=state.waves_to,
                    speed=state.speed,
                )
            )
        return tuple(states)

    def problems(self, rate_hz: float) -> Iterator[Problem]:
        """Yield the contradictions between the keys of each state, and between their times."""
        if all(state.still for state in self.states):
            yield Problem(
                'ship.weather.states',
                ABSENT,
                'has no waves, so the ship does not move',
                'Give a state with waves, or use ship kind still.',
            )
        for index, state in enumerate(self.states):
            key = f'ship.weather.states[{index}]'
            yield from state.problems(key, rate_hz, follow_route=self.follow_route)
        timed = [(k, state.at) for k, state in enumerate(self.states) if state.at is not None]
        for (_, previous), (index, at) in pairwise(timed):
            if not at > previous:
                yield Problem(
                    f'ship.weather.states[{index}].at',
                    at,
                    f'must be later than the time before, {previous!r} s',
                    'Give the states in the order of their times.',
                )


# -----------------------------------------------------------------------------
# The record of a buoy.

_Time = Annotated[float, Strict(), Field(ge=-LAST_STAMP_S, le=LAST_STAMP_S)]


class RecordWeather(WeatherKind):
    """Seas measured by a buoy, each row changing gradually into the next.

    The file is read when the scene is loaded, and the loaded scene contains its rows.
    """

    rank = 2
    starter: ClassVar[Mapping[str, Any]] = {
        'source': 'a buoy',
        'time': [0.0, 3600.0],
        'significant_wave_height': [1.5, 1.7],
        'peak_period': [7.1, 7.7],
    }

    kind: Literal['record'] = 'record'
    source: OneLine = Field(description='origin of the record')
    time: Annotated[tuple[_Time, ...], Field(min_length=1)] = Field(
        description='list of increasing times from the start [s]'
    )
    significant_wave_height: tuple[Positive, ...] = Field(
        description='list of significant wave heights [m], one for each time'
    )
    peak_period: tuple[Positive, ...] = Field(
        description='list of periods of the spectral peak [s], one for each time'
    )
    waves_to: tuple[Heading, ...] | None = Field(
        default=None,
        description='list of directions in which the waves run, from north to the east [rad]',
    )
    max_gap: Positive = Field(
        default=21_600.0, description='longest gap between rows that was bridged [s]'
    )
    gaps_bridged: Annotated[int, Strict(), Field(ge=0)] = Field(
        default=0, description='number of gaps that were bridged'
    )
    rows_without_direction: Annotated[int, Strict(), Field(ge=0)] = Field(
        default=0,
        description='with follow_route: number of rows without a direction, which are left out. '
        'If no row has a direction, all waves have the heading ship.heading',
    )

    def resolved(self, setting: WeatherSetting) -> tuple[WeatherState, ...]:
        """Return the rows.

        Raises:
            SceneError: the record ends before the scene.
        """
        scene = setting.scene
        if nanoseconds(self.time[-1]) < scene.duration_ns:
            longest_ns = whole_intervals(nanoseconds(self.time[-1]), scene.log_interval_ns)
            raise SceneError(
                scene.name,
                'ship.weather.time',
                self.time[-1],
                f'is the last time of the record [s], and the scene lasts {scene.duration!r} s',
                f'Set duration to at most {longest_ns / NS_PER_S:.15g}, or give a longer record.',
            )
        directions = self.waves_to or (None,) * len(self.time)
        rows = zip(
            self.time, self.significant_wave_height, self.peak_period, directions, strict=True
        )
        return tuple(
            setting.state(
                nanoseconds(time), height, period, f'ship.weather.time[{index}]', waves_to=waves_to
            )
            for index, (time, height, period, waves_to) in enumerate(rows)
        )

    def problems(self, rate_hz: float) -> Iterator[Problem]:
        """Yield the problems of its lists. The rate is checked once the speed is known."""
        for name in ('significant_wave_height', 'peak_period', 'waves_to'):
            values = getattr(self, name)
            if values is not None and len(values) != len(self.time):
                yield Problem(
                    f'ship.weather.{name}',
                    ABSENT,
                    f'has {len(values)} values for {len(self.time)} times',
                    'Give one for each time.',
                )

    def facts(self) -> dict[str, object]:
        """Return the source, the gaps that were bridged and the rows without a direction."""
        return {
            'source': self.source,
            'gaps_bridged': self.gaps_bridged,
            'rows_without_direction': self.rows_without_direction,
        }

    def warnings(self, setting: WeatherSetting) -> tuple[str, ...]:
        """Return a warning of rows without a direction if the route is followed."""
        number = self.rows_without_direction
        if not number:
            return ()
        text = f'ship.weather: {counted(number, "row")} of {self.source} without a direction '
        if self.waves_to is None:
            return (
                f'{text}and no row with one: all waves have the heading ship.heading. Fill in '
                'the directions, or set follow_route: false.',
            )
        return (f'{text}left out, since the heading of the waves follows from it.',)


KINDS = (StatesWeather, RecordWeather)
