"""Weather along the voyage from a hindcast, as rows (`ship/hindcast.py` reads the file)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, Strict

from tauto_core.scene.errors import ABSENT, Problem, SceneError
from tauto_core.scene.sections import Flag, OneLine, Positive, SceneTime
from tauto_core.scene.times import nanoseconds
from tauto_core.ship.sections import Heading
from tauto_core.ship.weather_kind import HIGHEST_M, WeatherKind, WeatherSetting, WeatherState
from tauto_core.ship.weathers.log import state_of_seas

_Height = Annotated[float, Strict(), Field(gt=0.0, le=HIGHEST_M)]


class HindcastWeather(WeatherKind):
    """Seas along the voyage from a hindcast, each row changing gradually into the next.

    The file is read when the scene is loaded; the scene that runs contains the rows. In the
    harbours before and after the passage the water is still.
    """

    rank = 5
    starter: ClassVar[Mapping[str, Any]] = {
        'source': 'a hindcast',
        'follow_route': False,
        'time': [0.0, 10_800.0],
        'seas': [[], [[1.5, 7.1, 1.0]]],
    }

    kind: Literal['hindcast'] = 'hindcast'
    follow_route: Flag = Field(
        default=True,
        description='true: speed and heading are those of the voyage; false: those of ship.speed '
        'and ship.heading',
    )
    source: OneLine = Field(description='origin of the rows')
    time: Annotated[tuple[SceneTime, ...], Field(min_length=1)] = Field(
        description='list of increasing times from the start [s]'
    )
    seas: tuple[tuple[tuple[_Height, Positive, Heading], ...], ...] = Field(
        description='list of the seas at each time, an empty one in a calm: [significant wave '
        'height in m, peak period in s, direction in which it runs, from north to the east in rad]'
    )

    def resolved(self, setting: WeatherSetting) -> tuple[WeatherState, ...]:
        """Return the rows.

        Raises:
            SceneError: the rows end at sea, before the scene does.
        """
        scene = setting.scene
        if self.seas[-1] and nanoseconds(self.time[-1]) < scene.duration_ns:
            problem = f'is the last time of the rows [s], and the scene lasts {scene.duration!r} s'
            remedy = 'Load the scene that names the file with this duration, or shorten it.'
            raise SceneError(scene.name, 'ship.weather.time', self.time[-1], problem, remedy)
        return tuple(
            state_of_seas(setting, nanoseconds(time), seas, f'ship.weather.time[{index}]')
            for index, (time, seas) in enumerate(zip(self.time, self.seas, strict=True))
        )

    def problems(self, rate_hz: float) -> Iterator[Problem]:
        """Yield the problems of its lists; the rate is checked once the speed is known."""
        del rate_hz
        if len(self.seas) != len(self.time):
            problem = f'has {len(self.seas)} rows for {len(self.time)} times'
            yield Problem('ship.weather.seas', ABSENT, problem, 'Give one for each time.')
        elif not any(self.seas):
            remedy = 'Use ship kind still.'
            yield Problem('ship.weather.seas', ABSENT, 'has no waves: nothing moves', remedy)

    def facts(self) -> dict[str, object]:
        """Return the source."""
        return {'source': self.source}


KIND = HindcastWeather
