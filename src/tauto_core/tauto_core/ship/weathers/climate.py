"""Weather drawn from the wave climate of a part of the ocean (theory/weather.md)."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field, Strict

from tauto_core.scene.errors import ABSENT, Problem, SceneError
from tauto_core.scene.sections import Flag, Positive, SceneTime, Section
from tauto_core.scene.times import DAY_S, LAST_STAMP_S, NS_PER_S, nanoseconds
from tauto_core.ship.sections import Heading
from tauto_core.ship.weathers import (
    LEAST_CHANGE_S,
    Height,
    WeatherKind,
    WeatherSetting,
    WeatherState,
    time_problems,
    wave_problems,
)

# -----------------------------------------------------------------------------
# Wave climates, from records of hourly significant wave heights Hs: the median is exp⟨ln Hs⟩, the
# deviation the standard deviation of ln Hs, and exp(−24 h/τ) with the correlation time τ the
# autocorrelation of ln Hs at a lag of a day.

HOUR_S = DAY_S / 24.0


class Climate(NamedTuple):
    """The wave climate of a part of the ocean in a season.

    Attributes:
        median_wave_height: median of the significant wave heights [m].
        log_deviation: standard deviation of their logarithm.
        correlation_time: correlation time of the logarithm [s].
        steepness: significant steepness s_p = 2π Hs/(g Tp²).
        waves_to: direction in which the waves run, from north to the east, if known [rad].
        source: source of the numbers.
    """

    median_wave_height: float
    log_deviation: float
    correlation_time: float
    steepness: float
    waves_to: float | None
    source: str


CLIMATES = {
    'north_atlantic_winter': Climate(
        median_wave_height=4.06,
        log_deviation=0.42,
        correlation_time=41.0 * HOUR_S,
        # 0.040 by the record's mean period, which in a Bretschneider sea is 0.710 Tp (ITTC)
        steepness=0.020,
        waves_to=math.radians(76.0),
        source='Marine Institute of Ireland, buoy M6 (53.07 N, 15.88 W), 2156 hours of November '
        '2025 to January 2026',
    ),
    'trades': Climate(
        median_wave_height=1.31,
        log_deviation=0.30,
        correlation_time=70.0 * HOUR_S,
        # of a fully developed sea (Pierson and Moskowitz, J. Geophys. Res. 69, 1964):
        # Hs = 0.209 U²/g and Tp = 7.16 U/g at any wind U
        steepness=0.0256,
        waves_to=math.radians(267.0),
        source='NDBC buoy 42060 (16.4 N, 63.3 W), 58,452 records of November to April, '
        '2009 to 2025; steepness of a fully developed sea',
    ),
}
"""The climates by their names in `ship.weather.regions[…].climate`."""


# -----------------------------------------------------------------------------
# The kind of weather: regions, port, and the states that the seed draws.

# Stream of random numbers from the seed, separate from the seas' and the dial noise's streams.
_STREAM = 0x636C696D
_NUMBERS = ('median_wave_height', 'log_deviation', 'correlation_time', 'steepness')


class Region(Section):
    """A part of the route with a climate: a name, numbers, or both."""

    at: SceneTime | None = Field(
        default=None,
        description='time from the start at which the region begins, optional for the first [s]',
    )
    waypoint: Annotated[int, Strict(), Field(ge=0)] | None = Field(
        default=None,
        description='or the number of a place of the voyage: 0 the departure, then the '
        'waypoints, then the arrival',
    )
    climate: Literal['north_atlantic_winter', 'trades'] | None = Field(
        default=None,
        description='north_atlantic_winter or trades, which gives the numbers left out below',
    )
    median_wave_height: Height | None = Field(
        default=None, description='median significant wave height [m]'
    )
    log_deviation: Annotated[float, Strict(), Field(ge=0.0, le=2.0)] | None = Field(
        default=None, description='standard deviation of its logarithm, 0 to 2'
    )
    correlation_time: Positive | None = Field(
        default=None,
        description='time in which the autocorrelation of its logarithm falls e-fold [s]',
    )
    steepness: Annotated[float, Strict(), Field(ge=1e-4, le=0.1)] | None = Field(
        default=None, description='significant steepness 2π Hs/(g Tp²), 0.0001 to 0.1'
    )
    waves_to: Heading | None = Field(
        default=None,
        description='with follow_route: direction in which the waves run, from north to the east '
        '[rad]',
    )

    def resolved(self) -> Climate:
        """Return the climate's numbers, replaced by the region's own."""
        climate = CLIMATES[self.climate]._asdict() if self.climate is not None else {}
        numbers = {name: getattr(self, name) for name in (*_NUMBERS, 'waves_to')}
        values = {name: value for name, value in numbers.items() if value is not None}
        return Climate(**({'waves_to': None, 'source': 'the scene'} | climate | values))


class Port(Section):
    """The sea in port, before departure and after arrival."""

    still: Flag = Field(default=False, description='true: no waves')
    significant_wave_height: Height | None = Field(
        default=None, description='significant wave height, at most 30 [m]'
    )
    peak_period: Positive | None = Field(
        default=None, description='period of the spectral peak [s]'
    )
    heading: Heading | None = Field(
        default=None, description='direction in which the waves run, from the bow to port [rad]'
    )


class ClimateWeather(WeatherKind):
    """Seas drawn from the scene's seed: significant wave height Hs and peak period.

    ln Hs is a Gauss–Markov process with the autocorrelation exp(−d/correlation_time) after a time
    d. The peak period follows from the height and the steepness.
    """

    rank = 3
    starter: ClassVar[Mapping[str, Any]] = {'regions': [{'climate': 'north_atlantic_winter'}]}

    kind: Literal['climate'] = 'climate'
    regions: Annotated[tuple[Region, ...], Field(min_length=1)] = Field(
        description='list of regions in the order of the route: climate, at or waypoint, …'
    )
    interval: Annotated[float, Strict(), Field(ge=LEAST_CHANGE_S, le=LAST_STAMP_S)] = Field(
        default=21_600.0, description='time between states, at least 600 [s]'
    )
    port: Port | None = Field(
        default=None,
        description='mapping: still, or significant_wave_height, peak_period and heading: the '
        'sea in the ports of the voyage, by default the sea of the climate',
    )

    def resolved(self, setting: WeatherSetting) -> tuple[WeatherState, ...]:
        """Return the states that the seed draws."""
        scene = setting.scene
        begin_ns, step_ns = 0, nanoseconds(self.interval)
        # one state after the end, as the sea must not depend on the duration
        end_ns = scene.duration_ns + step_ns
        sea_ns, port = 0, self.port
        if port is not None:
            passage = setting.passage_for('ship.weather.port', ABSENT)
            begin_ns, sea_ns = passage.sails_ns, passage.sails_ns + step_ns
            last_change_ns = max(step_ns // 2, nanoseconds(LEAST_CHANGE_S))
            end_ns = min(passage.arrives_ns - last_change_ns, end_ns)
        at_sea = list(range(sea_ns, end_ns, step_ns))
        normal = np.random.Generator(
            np.random.PCG64(np.random.SeedSequence(scene.seed, spawn_key=(_STREAM,)))
        ).standard_normal(len(at_sea))
        begins: list[int] = []
        for index, region in enumerate(self.regions):
            key = f'ship.weather.regions[{index}]'
            begins.append(setting.time_of(region, key))
            if index and begins[-1] <= begins[-2]:
                problem = (
                    f'begins at {begins[-1] / NS_PER_S:g} s, not later than the region before'
                )
                remedy = 'Give the regions in the order of the route.'
                raise SceneError(scene.name, key, ABSENT, problem, remedy)
        states, departure = [], 0.0
        for index, (at_ns, drawn) in enumerate(zip(at_sea, normal.tolist(), strict=True)):
            number = max(bisect_right(begins, at_ns) - 1, 0)
            climate = self.regions[number].resolved()
            decay = math.exp(-self.interval / climate.correlation_time) if index else 0.0
            departure = decay * departure + math.sqrt(1.0 - decay * decay) * drawn
            # departure of ln Hs from its mean, in deviations
            height = climate.median_wave_height * math.exp(climate.log_deviation * departure)
            period = math.sqrt(math.tau * height / (scene.g * climate.steepness))
            key = f'ship.weather.regions[{number}]'
            states.append(setting.state(at_ns, height, period, key, waves_to=climate.waves_to))
        if port is None:
            return tuple(states)
        key = 'ship.weather.port'

        def in_port(at_ns: int) -> WeatherState:
            if port.significant_wave_height is None or port.peak_period is None:
                return setting.calm(at_ns, key)
            waves = port.significant_wave_height, port.peak_period
            return setting.state(at_ns, *waves, key, heading=port.heading, speed=0.0)

        in_harbour = [in_port(at_ns) for at_ns in [0] * (begin_ns > 0) + [begin_ns]]
        return (*in_harbour, *states, in_port(passage.arrives_ns))

    def problems(self, rate_hz: float) -> Iterator[Problem]:
        """Yield the contradictions in the regions and the port."""
        for index, region in enumerate(self.regions):
            key = f'ship.weather.regions[{index}]'
            if index or region.at is not None:
                yield from time_problems(region, key)
            for name in _NUMBERS:
                if region.climate is None and getattr(region, name) is None:
                    yield Problem(
                        f'{key}.{name}',
                        ABSENT,
                        'is missing, and there is no climate to take it from',
                        f'Write `{name}: …`, or `climate: {" or ".join(CLIMATES)}`.',
                    )
        if self.port is not None:
            names = 'significant_wave_height', 'peak_period', 'heading'
            yield from wave_problems(self.port, 'ship.weather.port', names, rate_hz)

    def facts(self) -> dict[str, object]:
        """Return the sources of the numbers."""
        return {'sources': [region.resolved().source for region in self.regions]}


KIND = ClimateWeather
