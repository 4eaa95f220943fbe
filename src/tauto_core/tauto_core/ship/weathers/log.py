"""Weather along a voyage, grown from the winds of a log or read from a hindcast (logbooks.md)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import Field

from tauto_core.scene.errors import ABSENT, Problem, SceneError
from tauto_core.scene.sections import (
    FIRST_HOURS,
    LEAST_WIND,
    Flag,
    OneLine,
    Positive,
    SceneTime,
    Section,
    has_wind,
)
from tauto_core.scene.times import STANDARD_GRAVITY, nanoseconds
from tauto_core.ship.motions import sampled
from tauto_core.ship.sections import CUTOFF, LEAST_CUTOFF, Heading, still_from
from tauto_core.ship.weathers import Height, WeatherKind, WeatherSetting, WeatherState
from tauto_core.wording import counted

# -----------------------------------------------------------------------------
# Wilson's growth of a wind sea (1965) in Goda's form (2003).

LARGEST_FETCH_M = 1e6
"""Longest fetch of a wind sea, an assumption [m]."""

DECAY_HOURS = 36.0
"""Time in which a swell falls to 1/e of its height, an assumption [h]."""

SAME_WIND_DEG = 45.0
"""Turn of the wind above which the old sea becomes a swell [degrees]."""

PEAK_FACTOR = 1.05
"""Period of the peak over the significant period (Goda)."""

RIPPLES_M = 0.02
"""Seas below this significant height are calm [m]."""


def highest_m(wind: float) -> float:
    """Return the fully developed significant height for a wind [m/s], 0.30 U²/g [m]."""
    return 0.30 * wind * wind / STANDARD_GRAVITY


def grown(fetch_m: float, wind: float) -> tuple[float, float]:
    """Return the significant height [m] and the period of the peak [s] of a wind sea.

    H = 0.30 (U²/g) {1 − [1 + 0.004 (g F/U²)^½]⁻²},
    T_s = 8.61 (U/g) {1 − [1 + 0.008 (g F/U²)^⅓]⁻⁵}, T_p = 1.05 T_s.

    Args:
        fetch_m: F, >= 0.
        wind: U, 10 m above the sea [m/s], > 0.
    """
    way = STANDARD_GRAVITY * fetch_m / wind**2
    height = highest_m(wind) * (1.0 - (1.0 + 0.004 * math.sqrt(way)) ** -2)
    period = 8.61 * wind / STANDARD_GRAVITY * (1.0 - (1.0 + 0.008 * way ** (1.0 / 3.0)) ** -5)
    return height, PEAK_FACTOR * period


def fetch_of_hours(hours: float, wind: float) -> float:
    """Return the effective fetch [m] after a duration [h], by t = F[km]^0.73 U^−0.46."""
    return float(1e3 * (hours * wind**0.46) ** (1.0 / 0.73))


def fetch_of_height(height: float, wind: float) -> float:
    """Return the fetch [m] for a height [m] below `highest_m` of the wind [m/s]."""
    part = 1.0 - height / highest_m(wind)
    return float(((part**-0.5 - 1.0) / 0.004) ** 2 * wind * wind / STANDARD_GRAVITY)


class WindSea(NamedTuple):
    """Significant height [m], period of the peak [s], and direction from which it runs [deg]."""

    height: float
    period: float
    runs_from: float


NO_SEA = WindSea(0.0, 0.0, 0.0)


def grown_seas(
    hours: Sequence[float], winds: Sequence[float], winds_from: Sequence[float]
) -> list[tuple[WindSea, WindSea]]:
    """Return the wind sea and the swell at the times of a log's winds.

    A wind has blown since the previous time. If it is within `SAME_WIND_DEG` of the sea and can
    raise a higher one, the sea grows on from its equivalent fetch (Wilson). Otherwise the old sea
    becomes a swell at the previous time. Its energy is added to the decayed old swell. The sum has
    period and direction of the higher one.

    `winds` are in m/s, and blow from `winds_from` [degrees].
    """
    seas: list[tuple[WindSea, WindSea]] = []
    sea, swell = NO_SEA, NO_SEA
    for number, (wind, wind_from) in enumerate(zip(winds, winds_from, strict=True)):
        lasted = hours[number] - hours[number - 1] if number else FIRST_HOURS
        decay = math.exp(-lasted / DECAY_HOURS)
        swell = swell._replace(height=decay * swell.height)
        blows = wind >= LEAST_WIND
        turned = abs(math.remainder(wind_from - sea.runs_from, 360.0))
        begun = 0.0
        if blows and turned <= SAME_WIND_DEG and 0.0 < sea.height < highest_m(wind):
            begun = fetch_of_height(sea.height, wind)
        elif sea.height:
            old = sea._replace(height=decay * sea.height)
            swell = max(old, swell)._replace(height=math.hypot(old.height, swell.height))
        sea = NO_SEA
        if blows:
            blown = (begun / 1e3) ** 0.73 * wind**-0.46
            fetch = fetch_of_hours(blown + lasted, wind)
            sea = WindSea(*grown(max(begun, min(fetch, LARGEST_FETCH_M)), wind), wind_from)
        seas.append((sea, swell))
    return seas


# -----------------------------------------------------------------------------
# The kind of weather.

LEAVES_HARBOUR_S = 3600.0
"""Time in which the sea of the first entry builds up at departure [s]."""

TURN_S = 300.0
"""Half of the time of a change of course about an entry [s]."""


class BackgroundSwell(Section):
    """A distant swell on the whole passage, which the log does not record."""

    significant_wave_height: Height = Field(description='significant wave height, at most 30 [m]')
    peak_period: Positive = Field(description='period of the spectral peak [s]')
    waves_to: Heading = Field(
        description='direction in which it runs, from north to the east [rad]'
    )


class LogWeather(WeatherKind):
    """Seas grown from the wind of the voyage's log: a wind sea and a swell.

    Each has its direction and changes gradually from entry to entry. At an entry the ship turns to
    the next course. In the harbour before the log the water is still. With a hull, waves shorter
    than a tenth of its length are left out, and so is a sea with its peak there.
    """

    rank = 4
    starter: ClassVar[Mapping[str, Any]] = {}

    kind: Literal['log'] = 'log'
    follow_route: Flag = Field(
        default=True,
        description='true: speed and heading by the log, false: by ship.speed and ship.heading',
    )
    background_swell: BackgroundSwell | None = Field(
        default=None,
        description='mapping: significant_wave_height, peak_period, waves_to: a distant swell, in '
        "addition to the log's seas",
    )

    def resolved(self, setting: WeatherSetting) -> tuple[WeatherState, ...]:
        """Return the states before and after each entry that has a wind.

        Raises:
            SceneError: the voyage has no log, or the log no winds.
        """
        scene = setting.scene
        log = None if scene.voyage is None else scene.voyage.log
        if log is None:
            problem = 'needs a log-book, and the voyage has no log'
            remedy = 'Write `voyage: {log: {path: …, passage: …}}`.'
            raise SceneError(scene.name, 'ship.weather.kind', self.kind, problem, remedy)
        windy = [number for number, entry in enumerate(log.entries) if has_wind(entry)]
        if not windy:
            problem = f'finds no wind in passage {log.passage}'
            remedy = 'Choose another passage, or another kind of weather.'
            raise SceneError(scene.name, 'ship.weather.kind', self.kind, problem, remedy)
        entries = [log.entries[number] for number in windy]
        seas = grown_seas(
            [24.0 * log.days[number] for number in windy],
            [entry[4] or 0.0 for entry in entries],
            [entry[3] or 0.0 for entry in entries],
        )
        turn_ns, states = nanoseconds(TURN_S), []
        leaves_ns = nanoseconds(log.at[0] - LEAVES_HARBOUR_S)
        if leaves_ns >= 0:
            states.append(setting.calm(leaves_ns, 'voyage.log.harbour_days'))
        for number, pair in zip(windy, seas, strict=True):
            key, at_ns = f'voyage.log.entries[{number}]', nanoseconds(log.at[number])
            turns = [-turn_ns] * (number > 0) + [turn_ns] * (number < len(log.entries) - 1)
            states += [self._state(setting, at_ns + turn, pair, key) for turn in turns]
        return tuple(states)

    def _state(
        self, setting: WeatherSetting, at_ns: int, seas: Sequence[WindSea], key: str
    ) -> WeatherState:
        towards = [
            (sea.height, sea.period, math.radians(sea.runs_from + 180.0) % math.tau)
            for sea in seas
            if sea.height >= RIPPLES_M
        ]
        if (swell := self.background_swell) is not None:
            towards.append((swell.significant_wave_height, swell.peak_period, swell.waves_to))
        return state_of_seas(setting, at_ns, towards, key)

    def warnings(self, setting: WeatherSetting) -> tuple[str, ...]:
        """Return warnings of assumed values, and of legs too fast for the hull's data."""
        voyage = setting.scene.voyage
        log = None if voyage is None else voyage.log
        if log is None:
            return ()
        texts = []
        if log.harbour_days:
            texts.append(
                f'voyage.log: the {log.harbour_days:g} days in harbour before the log are invented'
            )
        passage, limit = setting.passage_for('voyage.log', log.passage), fastest_m_s(setting)
        legs = [(a + b) // 2 for a, b in pairwise(passage.places_ns)]
        fast = sum(passage.speed_m_s(at) > limit for at in legs)
        if fast:
            texts.append(
                f'voyage.log: on {counted(fast, "leg")} the ship makes more than {limit:.3g} m/s '
                'over the ground, the fastest for which the response of its hull is known. It '
                'meets the waves at that speed there'
            )
        return tuple(texts)

    def problems(self, rate_hz: float) -> Iterator[Problem]:
        """Yield the problems of the distant swell."""
        if self.background_swell is not None:
            key = 'ship.weather.background_swell.peak_period'
            yield from sampled(key, self.background_swell.peak_period, rate_hz)

    def facts(self) -> dict[str, object]:
        """Return the height of the distant swell."""
        swell = self.background_swell
        return {} if swell is None else {'background_swell_m': swell.significant_wave_height}


def state_of_seas(
    setting: WeatherSetting, at_ns: int, seas: Sequence[tuple[float, float, float]], key: str
) -> WeatherState:
    """Return the state at a time with several seas, the first with the others as `swell`.

    `seas` are significant height [m], period of the peak [s], and direction in which each runs,
    from north to the east [rad].
    """
    weather, state = setting.weather, None
    for height, period, waves_to in reversed(seas):
        moves_her = math.inf if setting.length is None else still_from(setting.length, period)
        if moves_her < 1.0:
            continue
        # in a young sea only the longer waves move the hull, and their spectrum stays the same
        cutoff, size = None, height
        if moves_her < CUTOFF and weather.cutoff is None:
            cutoff = max(moves_her, LEAST_CUTOFF)
            size = height * math.exp(0.625 * (CUTOFF**-4 - cutoff**-4))
        above = setting.state(at_ns, size, period, key, waves_to=waves_to, cutoff=cutoff)
        state = replace(above, speed=min(above.speed, fastest_m_s(setting)), swell=state)
    return setting.calm(at_ns, key) if state is None else state


def fastest_m_s(setting: WeatherSetting) -> float:
    """Return the speed up to which the hull's response to waves is known [m/s]."""
    if setting.length is None:
        return math.inf
    from tauto_core.ship.hull import MOST_FROUDE

    return MOST_FROUDE * math.sqrt(setting.scene.g * setting.length)


# -----------------------------------------------------------------------------
# The seas of a hindcast.


class HindcastWeather(WeatherKind):
    """Seas along the voyage from a hindcast, each row changing gradually into the next.

    The file is read when the scene is loaded, and the loaded scene contains its rows. In the
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
        description='true: speed and heading by the voyage, false: by ship.speed and ship.heading',
    )
    source: OneLine = Field(description='origin of the rows')
    time: Annotated[tuple[SceneTime, ...], Field(min_length=1)] = Field(
        description='list of increasing times from the start [s]'
    )
    seas: tuple[tuple[tuple[Height, Positive, Heading], ...], ...] = Field(
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
        """Yield the problems of its lists. The rate is checked once the speed is known."""
        if len(self.seas) != len(self.time):
            problem = f'has {len(self.seas)} rows for {len(self.time)} times'
            yield Problem('ship.weather.seas', ABSENT, problem, 'Give one for each time.')
        elif not any(self.seas):
            problem = 'has no waves, so the ship does not move'
            yield Problem('ship.weather.seas', ABSENT, problem, 'Use ship kind still.')

    def facts(self) -> dict[str, object]:
        """Return the source."""
        return {'source': self.source}


KINDS = (LogWeather, HindcastWeather)
