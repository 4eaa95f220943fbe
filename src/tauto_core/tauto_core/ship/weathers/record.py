"""Weather from the record of a buoy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, Strict

from tauto_core.scene.errors import ABSENT, Problem, SceneError
from tauto_core.scene.sections import OneLine, Positive
from tauto_core.scene.times import LAST_STAMP_S, NS_PER_S, nanoseconds, whole_intervals
from tauto_core.ship.sections import Heading
from tauto_core.ship.weather_kind import WeatherKind, WeatherSetting, WeatherState
from tauto_core.wording import counted

_Time = Annotated[float, Strict(), Field(ge=-LAST_STAMP_S, le=LAST_STAMP_S)]


class RecordWeather(WeatherKind):
    """Seas measured by a buoy, each row changing gradually into the next.

    The file is read when the scene is loaded; the scene that runs contains its rows.
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
    time: tuple[_Time, ...] = Field(description='list of increasing times from the start [s]')
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
        description='with follow_route: number of rows without a direction; they are left out, '
        'or, if no row has one, all waves have the heading of the ship (ship.heading)',
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
                nanoseconds(time),
                height,
                period,
                f'ship.weather.time[{index}]',
                waves_to=waves_to,
            )
            for index, (time, height, period, waves_to) in enumerate(rows)
        )

    def problems(self, rate_hz: float) -> Iterator[Problem]:
        """Yield the problems of its lists; the rate is checked once the speed is known."""
        del rate_hz
        if not self.time:
            yield Problem('ship.weather.time', ABSENT, 'is empty', 'Give at least one row.')
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
        """Return a warning of rows without a direction where the route is followed."""
        del setting
        number = self.rows_without_direction
        if not number:
            return ()
        said = f'ship.weather: {counted(number, "row")} of {self.source} without a direction '
        if self.waves_to is None:
            return (
                f'{said}and none with one: all waves have the heading of ship.heading. Fill in '
                'the directions, or set follow_route: false.',
            )
        return (f'{said}left out, since the heading of the waves follows from it.',)


KIND = RecordWeather
