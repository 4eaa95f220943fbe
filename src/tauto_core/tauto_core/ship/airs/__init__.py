"""The air on the voyage, and the temperature in the box of the clock (theory/air.md).

The air has a mean temperature, piecewise linear in time, and a daily sine wave about it. The box
follows the air with one time constant, in closed form between the knots.
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, Protocol

import numpy as np
from pydantic import Field, Strict

from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene.errors import ABSENT, Problem, SceneError, problems_where
from tauto_core.scene.sections import (
    LONGEST_TEXT,
    Kind,
    OneLine,
    Positive,
    Section,
    log_time,
)
from tauto_core.scene.tables import Column, read_header, read_table, source_name, utc
from tauto_core.scene.times import DAY_S, LAST_STAMP_S, NS_PER_S, nanoseconds
from tauto_core.ship.motions import Surroundings
from tauto_core.ship.passage import Passage

FOLDER = 'tauto_core.ship.airs'

COLDEST, WARMEST = -60.0, 60.0
"""Limits of the air's temperature at sea level, with a margin [°C]."""

Celsius = Annotated[float, Strict(), Field(ge=COLDEST, le=WARMEST)]

AIR_KNOT_S = 600
"""Time between knots under way [s], with linear mean and local time between them."""


class AirKind(Kind):
    """The air: its daily variation, and the box of the clock.

    Each kind gives a mean temperature that is piecewise linear in time.
    """

    diurnal: Annotated[float, Strict(), Field(ge=0.0, le=30.0)] = Field(
        default=0.0,
        description='half of the difference between the warmest and the coldest hour of a day, '
        '0 to 30 [K]',
    )
    warmest_hour: Annotated[float, Strict(), Field(ge=0.0, le=24.0)] = Field(
        default=12.0,
        description="hour of the day that is warmest, 0 to 24, by the Sun at the ship's "
        'longitude: 12 is noon',
    )
    box_hours: Annotated[float, Strict(), Field(gt=0.0, le=1000.0)] = Field(
        default=6.0,
        description="time constant with which the clock's box follows the air, more than 0, at "
        'most 1000 [h]',
    )

    def knots(self, scene: AirySurroundings) -> tuple[IntArray, FloatArray]:
        """Return times from the start of the scene [ns], and the mean of the air then [°C].

        The mean is constant before the first time and after the last.
        """
        raise NotImplementedError

    def problems(self, scene: AirySurroundings) -> Iterator[Problem]:
        """Yield its problems in a scene."""
        return iter(())


class AirySurroundings(Surroundings, Protocol):
    """The parts of a scene that determine the temperature of the box."""

    @property
    def air(self) -> AirKind | None:
        """The air, or `None` if no temperature is simulated."""

    @property
    def starts_at(self) -> float:
        """Stamp of the first sample [s]. Stamp 0 is midnight at Greenwich."""


def knots_between(first_ns: int, last_ns: int, scene: AirySurroundings) -> IntArray:
    """Return times every `AIR_KNOT_S`, to `last_ns` at most.

    Some are after the end of the scene, as the temperature must not depend on the duration.
    """
    step = AIR_KNOT_S * NS_PER_S
    needed = scene.duration_ns + 2 * scene.log_interval_ns + 2 * step
    return np.arange(first_ns, min(last_ns, needed), step, dtype=np.int64)


# -----------------------------------------------------------------------------
# The box: τ dB/dt = A − B, for A = a + b s + D cos(φ + ω s) between two knots.


class BoxTemperature:
    """Temperature in the box of the clock, at the logged instants of a scene with `air`.

    At a time s after a knot the air is a + b s + D cos(φ + ω s), and the box (air.3)

        a + b (s − τ) + D (cos x + ω τ sin x)/(1 + ω² τ²) + c exp(−s/τ), x = φ + ω s.

    c makes it continuous. Before the first knot the mean is constant, and the box has settled.

    Raises:
        SceneError: a route that cannot be sailed (see `Passage`).
    """

    def __init__(self, scene: AirySurroundings) -> None:
        air = scene.air
        assert air is not None
        self._interval_ns = scene.log_interval_ns
        at_ns, means = air.knots(scene)
        passage = None if scene.voyage is None else Passage(scene, scene.voyage)
        knots = [np.zeros(1, np.int64), at_ns]
        if air.diurnal and passage is not None:
            # the longitude sets the time of noon
            knots.append(knots_between(passage.sails_ns, passage.arrives_ns, scene))
            knots.append(np.array(passage.places_ns, np.int64))
        knots_ns = np.unique(np.concatenate(knots))
        self._knots_ns = knots_ns

        self._lag_s = air.box_hours * 3600.0
        self._mean = np.interp(knots_ns / NS_PER_S, at_ns / NS_PER_S, means)
        steps = np.append(np.diff(knots_ns) / NS_PER_S, math.inf)
        self._slope = np.append(np.diff(self._mean), 0.0) / steps
        east = np.zeros(len(knots_ns))
        if passage is not None:
            east = np.radians(passage.places(knots_ns)[1])
        turned = np.append(np.diff(east), 0.0)
        turned -= math.tau * np.round(turned / math.tau)
        self._pace = math.tau / DAY_S + turned / steps
        since_midnight = (
            (nanoseconds(scene.starts_at) + knots_ns) % round(DAY_S * NS_PER_S) / NS_PER_S
        )
        self._phase = math.tau * (since_midnight / DAY_S - air.warmest_hour / 24.0) + east
        self._swing = air.diurnal / (1.0 + np.square(self._pace * self._lag_s))

        # settled before the first knot, then continuous at each
        self._rest = np.zeros(len(knots_ns))
        which = np.arange(len(knots_ns))
        forced = self._forced(which, np.zeros(len(knots_ns))).tolist()
        reached = self._forced(which[:-1], steps[:-1]).tolist()
        decay = _each(math.exp, -steps[:-1] / self._lag_s).tolist()
        offset = self._slope[0] * self._lag_s
        for index in which.tolist():
            self._rest[index] = offset
            if index < len(reached):
                offset = reached[index] + offset * decay[index] - forced[index + 1]

    def at(self, k: IntArray) -> FloatArray:
        """Return the temperature [°C] at `starts_at` + k log intervals, k ≥ 0, (n,)."""
        time_ns = k * self._interval_ns
        which = np.searchsorted(self._knots_ns, time_ns, 'right') - 1
        since = (time_ns - self._knots_ns[which]) / NS_PER_S
        fading = _each(math.exp, -since / self._lag_s)
        celsius = self._forced(which, since) + self._rest[which] * fading
        return np.asarray(celsius)

    def _forced(self, which: IntArray, since: FloatArray) -> FloatArray:
        """Return the terms without c, at times after knots [s]."""
        steady = self._mean[which] + self._slope[which] * (since - self._lag_s)
        if not self._swing.any():
            return np.asarray(steady)
        pace = self._pace[which]
        angle = self._phase[which] + pace * since
        lagging = _each(math.cos, angle) + pace * self._lag_s * _each(math.sin, angle)
        return np.asarray(steady + self._swing[which] * lagging)


def _each(function: Callable[[float], float], values: FloatArray) -> FloatArray:
    """Return a function of each number. NumPy's functions depend on the index in the array."""
    return np.fromiter(map(function, values.tolist()), np.float64, len(values))


# -----------------------------------------------------------------------------
# The mean temperature of the air over the sea by latitude and month (theory/air.md).
#
# Zonal means over the sea of the monthly maps of Recommendation ITU-R P.1510-1 (2017): the air 2 m
# above the surface in the reanalysis ERA-Interim, 1979 to 2014, every 0.75 degrees. Straight lines
# between the values are a least-squares fit of the means of all parallels.

ZONAL_LATITUDES = np.arange(-70.0, 81.0, 10.0)
"""Latitudes of the rows of `ZONAL_CELSIUS` [degrees north]."""

ZONAL_CELSIUS = np.array(
    (
        (-1.2, -2.3, -5.0, -9.7, -14.4, -17.4, -19.6, -19.5, -17.6, -13.4, -6.8, -1.9),
        (1.8, 2.3, 1.9, 1.2, 0.1, -1.4, -2.8, -3.4, -3.3, -2.0, -0.4, 0.8),
        (7.3, 7.6, 7.4, 6.6, 5.6, 4.9, 4.6, 4.4, 4.4, 4.8, 5.5, 6.5),
        (15.8, 16.4, 16.0, 14.8, 13.5, 12.2, 11.3, 10.9, 11.0, 11.7, 12.8, 14.5),
        (22.2, 22.9, 22.4, 21.1, 19.6, 18.2, 17.1, 16.7, 16.9, 17.6, 18.9, 20.7),
        (25.1, 25.6, 25.7, 25.0, 23.8, 22.6, 21.7, 21.4, 21.6, 22.3, 23.2, 24.2),
        (26.6, 26.9, 27.2, 27.3, 26.9, 26.0, 25.3, 24.9, 25.0, 25.4, 25.9, 26.3),
        (26.4, 26.8, 27.1, 27.3, 27.1, 26.7, 26.1, 25.9, 26.0, 26.1, 26.2, 26.2),
        (26.6, 26.5, 26.9, 27.4, 27.6, 27.4, 27.3, 27.3, 27.3, 27.3, 27.3, 27.0),
        (23.5, 23.3, 23.7, 24.6, 25.6, 26.4, 26.7, 27.0, 27.1, 26.8, 25.8, 24.4),
        (17.9, 17.5, 17.9, 19.0, 20.8, 23.2, 25.0, 25.6, 25.4, 23.8, 21.5, 19.4),
        (9.4, 9.0, 9.9, 11.6, 13.9, 16.8, 20.2, 22.0, 20.5, 17.4, 14.0, 11.1),
        (2.9, 2.5, 3.3, 4.7, 6.4, 8.7, 11.3, 13.0, 12.2, 9.2, 6.1, 4.1),
        (-4.1, -4.5, -3.2, 0.3, 3.9, 7.1, 9.8, 10.7, 8.6, 5.1, 1.9, -1.6),
        (-14.7, -15.1, -13.6, -8.9, -2.1, 3.0, 5.7, 5.8, 3.5, -1.5, -7.9, -12.4),
        (-26.0, -26.3, -24.7, -19.0, -8.6, -0.9, 0.2, -0.6, -4.3, -12.6, -20.5, -24.4),
    )
)
"""Mean temperature of the air over the sea [°C], from January to December."""


def zonal_celsius(latitude_deg: FloatArray, year_part: FloatArray) -> FloatArray:
    """Return the climate's mean temperature over the sea [°C].

    It is linear in latitude between the rows, constant beyond them, and linear in time between
    mid-months, with months of equal length. `year_part` is the time since the new year in years.
    """
    row = np.clip((latitude_deg - ZONAL_LATITUDES[0]) / 10.0, 0.0, len(ZONAL_LATITUDES) - 1.0)
    low = np.minimum(row.astype(np.int64), len(ZONAL_LATITUDES) - 2)
    month = np.mod(year_part, 1.0) * 12.0 - 0.5
    floor = np.floor(month)
    across, along = row - low, month - floor
    now, then = floor.astype(np.int64) % 12, (floor.astype(np.int64) + 1) % 12
    south = (1.0 - along) * ZONAL_CELSIUS[low, now] + along * ZONAL_CELSIUS[low, then]
    north = (1.0 - along) * ZONAL_CELSIUS[low + 1, now] + along * ZONAL_CELSIUS[low + 1, then]
    return np.asarray((1.0 - across) * south + across * north)


# -----------------------------------------------------------------------------
# Air by the places of the voyage.


class ConstantAir(AirKind):
    """Air of one temperature, as in a room or in harbour."""

    rank = 0
    starter: ClassVar[Mapping[str, Any]] = {'celsius': 15.0}

    kind: Literal['constant'] = 'constant'
    celsius: Celsius = Field(description='temperature of the air, -60 to 60 [°C]')

    def knots(self, scene: AirySurroundings) -> tuple[IntArray, FloatArray]:
        """Return one time, and the temperature."""
        del scene
        return np.zeros(1, np.int64), np.array([self.celsius])


class AirAt(Section):
    """The temperature of the air when the ship is at a place of the voyage."""

    waypoint: Annotated[int, Strict(), Field(ge=0)] = Field(
        description='number of a place of the voyage: 0 the departure, then the waypoints, then '
        'the arrival'
    )
    celsius: Celsius = Field(description='temperature of the air there, -60 to 60 [°C]')


class RouteAir(AirKind):
    """Air by the places of the voyage. Between them its temperature is linear in time.

    Before the first place in the list and after the last one it is constant. Without a list it is
    the mean over the sea for the ship's latitude and the month.
    """

    rank = 1
    starter: ClassVar[Mapping[str, Any]] = {'at': ({'waypoint': 0, 'celsius': 15.0},)}

    kind: Literal['route'] = 'route'
    at: Annotated[tuple[AirAt, ...], Field(min_length=1)] | None = Field(
        default=None,
        description='list of {waypoint, celsius}, in the order of the voyage, by default the mean '
        'for latitude and month, from voyage.date',
    )

    def knots(self, scene: AirySurroundings) -> tuple[IntArray, FloatArray]:
        """Return the times at the listed places, or of the climate, and the temperatures."""
        assert scene.voyage is not None  # `problems`
        passage = Passage(scene, scene.voyage)
        if self.at is not None:
            return (
                np.array([passage.places_ns[place.waypoint] for place in self.at], np.int64),
                np.array([place.celsius for place in self.at]),
            )
        grid = knots_between(0, nanoseconds(LAST_STAMP_S), scene)
        at_ns = np.union1d(grid, np.array(passage.places_ns, np.int64))
        starts_at = scene.starts_at
        days = scene.voyage.day_at(starts_at, starts_at) + at_ns / NS_PER_S / DAY_S
        assert scene.voyage.date is not None
        new_year = datetime.date(scene.voyage.date.year, 1, 1).toordinal()
        return at_ns, zonal_celsius(passage.places(at_ns)[0], (days - new_year) / 365.2425)

    def problems(self, scene: AirySurroundings) -> Iterator[Problem]:
        """Yield the problems of its places and temperatures."""
        voyage, at = scene.voyage, self.at
        yield from problems_where(
            (
                voyage is None,
                'air.kind',
                self.kind,
                'is the air by the places of a voyage, and the scene has no voyage',
                'Write `kind: constant, celsius: …` for a clock in harbour, or `voyage: …`.',
            ),
            (
                at is None and voyage is not None and voyage.date is None,
                'voyage.date',
                ABSENT,
                'is needed for the mean temperature of the month, as air gives no temperatures',
                'Write the day of departure, `date: 1761-11-18`, or `air.at: …`.',
            ),
        )
        arrival = 0 if voyage is None else len(voyage.places) - 1
        for index, place in enumerate(at or ()):
            if voyage is not None and place.waypoint > arrival:
                yield Problem(
                    f'air.at[{index}].waypoint',
                    place.waypoint,
                    f'is not a place of the voyage, which has {arrival + 1}: 0 is the departure, '
                    f'{arrival} the arrival',
                    f'Give a number from 0 to {arrival}.',
                )
        for index, (previous, current) in enumerate(pairwise(at or ()), 1):
            if current.waypoint <= previous.waypoint:
                yield Problem(
                    f'air.at[{index}].waypoint',
                    current.waypoint,
                    f'does not come after the place before it, {previous.waypoint}',
                    'Name each place once, in the order of the voyage.',
                )


# -----------------------------------------------------------------------------
# Recorded air: a CSV file with the columns time_s or time_utc, and celsius.

_SECONDS, _UTC, _CELSIUS = 'time_s', 'time_utc', 'celsius'
_FORM = f'Give a CSV file with the columns {_SECONDS} or {_UTC}, and {_CELSIUS}.'
_Time = Annotated[float, Strict(), Field(ge=-LAST_STAMP_S, le=LAST_STAMP_S)]


class AirRecordFile(AirKind):
    """A record of the air in a CSV file, which the loaded scene contains.

    Its columns are `celsius`, and `time_s` from the start of the scene or `time_utc`, such as
    1761-11-18T12:00. Rows are in the order of their times.
    """

    kind: Literal['record'] = 'record'
    path: OneLine = Field(description='CSV file of the record')
    begins: OneLine | None = Field(
        default=None,
        description='with time_utc: UTC at the start of the scene, by default from voyage.date, '
        'or without it the time of the first row',
    )
    longest_gap_hours: Positive = Field(
        default=24.0, description='longest time between two rows [h]'
    )


def read_air(record: AirRecordFile) -> dict[str, Any]:
    """Return the keys of `air` with the rows of a record.

    Raises:
        SceneError: temperatures that no air has, times that do not increase, or long gaps, with
            the line.
    """
    has_utc = _UTC in read_header(record.path, remedy=_FORM)
    if record.begins is not None and not has_utc:
        problem = f'needs the column {_UTC}, as {_SECONDS} counts from the start of the scene'
        raise SceneError(record.path, 'begins', record.begins, problem, 'Leave it out.')
    time = _UTC if has_utc else _SECONDS
    columns = (
        Column(time, utc=has_utc, unit='s', rising='later than the row before'),
        Column(
            _CELSIUS,
            least=COLDEST,
            most=WARMEST,
            unit='°C',
            remedy='Give it in degrees Celsius.',
        ),
    )
    table = read_table(record.path, columns, remedy=_FORM)
    table.gaps(
        time,
        record.longest_gap_hours * 3600.0,
        limit='the longest, by air.longest_gap_hours,',
        remedy='Fill the gap, or raise air.longest_gap_hours.',
    )
    zero_s, first_utc = 0.0, None
    if record.begins is not None:
        zero_s = utc(record.path, 'begins', record.begins).timestamp()
    elif has_utc:
        zero_s = float(table[time][0])
        first_utc = datetime.datetime.fromtimestamp(zero_s, datetime.UTC).isoformat()
    return {
        **record.model_dump(exclude={'path', 'begins'}),
        'source': source_name(record.path)[-LONGEST_TEXT:],
        'first_utc': first_utc,
        'time': (table[time] - zero_s).tolist(),
        'celsius': table[_CELSIUS].tolist(),
    }


class RecordAir(AirKind):
    """Recorded air, with a linear temperature between the rows.

    A file is read when the scene is loaded, and the loaded scene contains its rows.
    """

    rank = 2
    starter: ClassVar[Mapping[str, Any]] = {
        'source': 'a thermometer',
        'time': [0.0, 86_400.0],
        'celsius': [12.0, 14.0],
    }

    kind: Literal['record'] = 'record'
    source: OneLine = Field(description='origin of the record')
    first_utc: OneLine | None = Field(
        default=None,
        description='UTC of time 0. Without it, or without voyage.date, time 0 is the start of '
        'the scene',
    )
    time: tuple[_Time, ...] = Field(
        description='list of increasing times from the start of the scene, or from first_utc [s]'
    )
    celsius: tuple[Celsius, ...] = Field(
        description='list of temperatures of the air, one for each time, -60 to 60 [°C]'
    )
    longest_gap_hours: Positive = Field(
        default=24.0, description='longest time between two rows [h]'
    )

    @staticmethod
    def with_file_read(air: dict[str, Any], origin: str) -> dict[str, Any]:
        """Return the keys with the rows of the file `path`, if there is one."""
        from tauto_core.ship.sea_files import section_read

        if air.get('kind') != 'record' or 'path' not in air:
            return air
        return section_read(AirRecordFile, read_air, {'air': air}, 'air.path', origin, prefix='')

    def knots(self, scene: AirySurroundings) -> tuple[IntArray, FloatArray]:
        """Return the times and temperatures of the rows."""
        ahead_s = self._ahead_s(scene)
        times = [nanoseconds(time_s + ahead_s) for time_s in self.time]
        return np.array(times, np.int64), np.array(self.celsius)

    def _ahead_s(self, scene: AirySurroundings) -> float:
        """Return the time 0 of the record, from the start of the scene [s]."""
        voyage = scene.voyage
        if self.first_utc is None or voyage is None or voyage.date is None:
            return 0.0
        moment = utc(self.source, 'air.first_utc', self.first_utc)
        midnight = datetime.datetime.combine(moment.date(), datetime.time(), datetime.UTC)
        days = moment.toordinal() - voyage.day_at(scene.starts_at, scene.starts_at)
        return float(round(days * DAY_S, 3)) + (moment - midnight).total_seconds()

    def problems(self, scene: AirySurroundings) -> Iterator[Problem]:
        """Yield the problems of its rows."""
        if not self.time or len(self.time) != len(self.celsius):
            yield Problem(
                'air.celsius',
                ABSENT,
                f'has {len(self.celsius)} values for {len(self.time)} times',
                'Give one for each time, and at least one.',
            )
            return
        longest_s = self.longest_gap_hours * 3600.0
        for index, (previous, current) in enumerate(pairwise(self.time), 1):
            if not 0.0 < current - previous <= longest_s:
                yield Problem(
                    f'air.time[{index}]',
                    current,
                    f'must be later than the time before, {previous!r} s, by at most '
                    f'longest_gap_hours, {self.longest_gap_hours:g} h',
                    'Sort the rows, fill the gap, or raise longest_gap_hours.',
                )
        if self.first_utc is not None:
            try:
                utc(self.source, 'air.first_utc', self.first_utc)
            except SceneError as error:
                yield from error.problems
                return
        ahead_s = self._ahead_s(scene)
        first_s, last_s = self.time[0] + ahead_s, self.time[-1] + ahead_s
        if first_s > 0.0 or last_s < scene.duration:
            yield Problem(
                'air.time',
                [self.time[0], self.time[-1]],
                f'lasts from {first_s:.10g} s to {last_s:.10g} s by the scene, which lasts from 0 '
                f'to {scene.duration!r} s',
                'Give a longer record or a shorter scene, or correct voyage.date.',
            )


# -----------------------------------------------------------------------------
# Air by the log-book of the voyage.


DEPARTS_S = 8.0 * DAY_S
"""Time in which a departure of the air from its mean falls to 1/e [s].

It predicts withheld noon temperatures of 371 passages best.
"""


def departures(time_s: FloatArray, values: FloatArray) -> FloatArray:
    """Return departures of the air from its mean [K], with the unknown ones estimated.

    An unknown departure is the expectation of an Ornstein–Uhlenbeck process (1930) of correlation
    time `DEPARTS_S`, given its known neighbours: nearly linear in a short gap, and 0 far from a
    thermometer (theory/logbooks.md). Unknown values are nan. Times are whole numbers, for exact
    differences.
    """
    estimates, rows = np.zeros(len(time_s)), np.flatnonzero(~np.isnan(values))
    for index in range(len(time_s) if len(rows) else 0):
        place = int(np.searchsorted(rows, index))
        low, high = rows[max(place - 1, 0)], rows[min(place, len(rows) - 1)]
        past = abs(time_s[index] - time_s[low]) / DEPARTS_S
        ahead = abs(time_s[high] - time_s[index]) / DEPARTS_S
        if index == high:
            estimates[index] = values[index]
        elif low == high:
            estimates[index] = values[low] * math.exp(-past)
        else:
            weights = math.sinh(ahead), math.sinh(past)
            estimates[index] = weights[0] * values[low] + weights[1] * values[high]
            estimates[index] /= math.sinh(past + ahead)
    return estimates


class LogAir(AirKind):
    """Air by the thermometer of the voyage's log, linear in time between entries.

    For an entry without a temperature it is the mean over the sea for latitude and month, plus a
    fading share of the departure from it at the neighbouring readings. In the harbour before the
    log the air has the temperature of the first entry.
    """

    rank = 3
    starter: ClassVar[Mapping[str, Any]] = {}

    kind: Literal['log'] = 'log'

    def knots(self, scene: AirySurroundings) -> tuple[IntArray, FloatArray]:
        """Return the times and temperatures of the entries."""
        log = None if scene.voyage is None else scene.voyage.log
        assert log is not None
        times = [log_time(entry[0]) for entry in log.entries]
        years = [
            (moment - datetime.datetime(moment.year, 1, 1)).total_seconds() / DAY_S / 365.2425
            for moment in times
        ]
        usual = zonal_celsius(np.array([entry[1] for entry in log.entries]), np.array(years))
        read = np.array([math.nan if entry[5] is None else entry[5] for entry in log.entries])
        since = np.array([(moment - times[0]).total_seconds() for moment in times])
        celsius = usual + departures(since, read - usual)
        celsius = np.where(np.isnan(read), celsius, read)
        return np.array([nanoseconds(at) for at in log.at], np.int64), celsius

    def problems(self, scene: AirySurroundings) -> Iterator[Problem]:
        """Yield a problem if the voyage has no log."""
        if scene.voyage is None or scene.voyage.log is None:
            yield Problem(
                'air.kind',
                self.kind,
                'needs a log-book, and the voyage has no log',
                'Write `voyage: {log: {path: …, passage: …}}`, or another kind.',
            )


KINDS = (ConstantAir, RouteAir, RecordAir, LogAir)
