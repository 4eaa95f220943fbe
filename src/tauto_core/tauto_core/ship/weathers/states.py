"""Weather as a list of states of the sea."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, Strict

from tauto_core.scene.errors import ABSENT, Problem
from tauto_core.scene.sections import Flag, Positive, SceneTime, Section
from tauto_core.scene.times import nanoseconds
from tauto_core.ship.motion_kind import sampled
from tauto_core.ship.sections import Heading
from tauto_core.ship.weather_kind import WeatherKind, WeatherSetting, WeatherState

_OF_WAVES = (
    'significant_wave_height',
    'peak_period',
    'spectrum',
    'heading',
    'waves_to',
    'speed',
)


class SeaState(Section):
    """A sea that is fully established at an instant; it builds up from the state before."""

    at: SceneTime | None = Field(default=None, description='time from the start [s]')
    waypoint: Annotated[int, Strict(), Field(ge=0)] | None = Field(
        default=None,
        description='or the number of a place of the voyage: 0 the departure, then the '
        'waypoints, then the arrival',
    )
    still: Flag = Field(default=False, description='true: no waves')
    significant_wave_height: Annotated[float, Strict(), Field(gt=0.0, le=30.0)] | None = Field(
        default=None, description='significant wave height, at most 30 [m]'
    )
    peak_period: Positive | None = Field(
        default=None, description='period of the spectral peak [s]'
    )
    spectrum: Literal['bretschneider', 'jonswap'] | None = Field(
        default=None, description='bretschneider or jonswap, that of the weather when left out'
    )
    heading: Heading | None = Field(
        default=None,
        description='direction in which the waves run, from the bow to port [rad]; ship.heading '
        'when left out',
    )
    waves_to: Heading | None = Field(
        default=None,
        description='with follow_route: direction in which the waves run, from north to the east '
        '[rad]',
    )
    speed: Annotated[float, Strict(), Field(ge=0.0, le=50.0)] | None = Field(
        default=None, description='speed of the ship [m/s]; ship.speed when left out'
    )

    def problems(self, key: str, rate_hz: float, *, follow_route: bool) -> Iterator[Problem]:
        """Yield the contradictions between its keys.

        Args:
            key: its own key.
            rate_hz: samples of the motion a second.
            follow_route: whether the weather follows the route of the voyage.
        """
        if (self.at is None) == (self.waypoint is None):
            what = 'is missing, and there is no waypoint in its place'
            remedy = 'Write `at: …`, time from the start [s], or `waypoint: …`, number of a place.'
            if self.at is not None:
                what, remedy = 'does not go with waypoint', 'Leave one of them out.'
            yield Problem(f'{key}.at', ABSENT if self.at is None else self.at, what, remedy)
        if self.still:
            given = [name for name in _OF_WAVES if getattr(self, name) is not None]
            for name in given[:1]:
                yield Problem(
                    f'{key}.{name}',
                    getattr(self, name),
                    'does not go with still: a calm has no waves',
                    'Leave out one of them.',
                )
        else:
            for name in ('significant_wave_height', 'peak_period'):
                if getattr(self, name) is None:
                    yield Problem(
                        f'{key}.{name}',
                        ABSENT,
                        'is missing',
                        f'Write `{name}: …`, or `still: true` for a calm.',
                    )
            if self.peak_period is not None:
                yield from sampled(f'{key}.peak_period', self.peak_period, rate_hz)
        if self.waves_to is not None and self.heading is not None:
            yield Problem(
                f'{key}.waves_to',
                self.waves_to,
                'does not go with heading: either says where the waves run to',
                'Leave one of them out.',
            )
        elif self.waves_to is not None and not follow_route:
            yield Problem(
                f'{key}.waves_to',
                self.waves_to,
                'needs the course made good',
                'Write `follow_route: true` in ship.weather, or give heading.',
            )
        if self.speed is not None and follow_route:
            yield Problem(
                f'{key}.speed',
                self.speed,
                'does not go with follow_route: the voyage has a speed',
                'Leave one of them out.',
            )


class StatesWeather(WeatherKind):
    """Seas at given times, each changing gradually into the next.

    A change takes the whole time between two states. Where two states in a row are equal, the sea
    does not change between them, nor does it before the first state and after the last.
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
        """Return the states as they are listed."""
        states = []
        for index, state in enumerate(self.states):
            key = f'ship.weather.states[{index}]'
            if state.at is not None:
                at_ns = nanoseconds(state.at)
            else:
                at_ns = setting.time_of_place(state.waypoint or 0, f'{key}.waypoint')
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
                'has no waves: nothing moves',
                'Give a state with waves, or use ship kind still.',
            )
        for index, state in enumerate(self.states):
            key = f'ship.weather.states[{index}]'
            yield from state.problems(key, rate_hz, follow_route=self.follow_route)
        timed = [(k, each.at) for k, each in enumerate(self.states) if each.at is not None]
        for (_, before), (index, at) in pairwise(timed):
            if not at > before:
                yield Problem(
                    f'ship.weather.states[{index}].at',
                    at,
                    f'must be later than the time before, {before!r} s',
                    'Give the states in the order of their times.',
                )


KIND = StatesWeather
