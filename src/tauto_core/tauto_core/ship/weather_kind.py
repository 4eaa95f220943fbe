"""The base of all kinds of weather: states of the sea one after another, and their records."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field, Strict

from tauto_core.samples import NS_PER_S
from tauto_core.scene.data import data_path, source_name
from tauto_core.scene.errors import ABSENT, Problem, SceneError
from tauto_core.scene.fields import LONGEST_TEXT, Flag, Kind, Positive, Text
from tauto_core.ship.motion_kind import Surroundings
from tauto_core.ship.sections import ComponentCount, Sea
from tauto_core.ship.waves import Fades, Harmonics

if TYPE_CHECKING:
    from tauto_core.ship.passage import Passage


FOLDER = 'tauto_core.ship.weathers'

LEAST_CHANGE_S = 600.0
"""Shortest time in which one sea changes into another [s]. It is long compared with the waves, and
the jump of the fourth derivative at its ends is below the rounding of the interpolation.
"""

HIGHEST_M = 30.0
"""Significant wave height [m] above any known sea."""


@dataclass(frozen=True)
class State:
    """A sea that is fully established at an instant.

    Attributes:
        at_ns: from the start of the scene, possibly before it.
        sea: None: a calm.
        heading: direction in which the waves run, from the bow to port [rad].
        speed: speed of the ship [m/s].
        key: the key of the scene that gives it, for error messages.
    """

    at_ns: int
    sea: Sea | None
    heading: float
    speed: float
    key: str

    @property
    def height(self) -> float:
        """Significant wave height [m]."""
        return 0.0 if self.sea is None else self.sea.significant_wave_height

    def goes_on(self, before: State) -> bool:
        """Return whether nothing has changed since the previous state."""
        same_way = (self.heading, self.speed) == (before.heading, before.speed)
        return self.sea == before.sea and (self.sea is None or same_way)


class WeatherKind(Kind):
    """How the sea changes. Each kind is a module of `ship/weathers` and names its model `KIND`."""

    spectrum: Literal['bretschneider', 'jonswap'] = Field(
        default='bretschneider', description='spectrum of the seas: bretschneider or jonswap'
    )
    gamma: Annotated[float, Strict(), Field(ge=1.0, le=10.0)] = Field(
        default=3.3, description='peak enhancement factor of jonswap, 1 to 10'
    )
    components: ComponentCount = Field(
        default=64, description='number of components of each sea, 1 to 4096'
    )
    follow_route: Flag = Field(
        default=False,
        description='true: the speed is that of the voyage, and where the direction of the waves '
        'is known the heading follows from the course made good',
    )
    kind: str

    def resolved(self, setting: Setting) -> tuple[State, ...]:
        """Return the states in the order of their times.

        Args:
            setting: scene and ship, against which times, headings and speeds are resolved.

        Raises:
            SceneError: weather that does not go with the scene.
        """
        raise NotImplementedError

    def problems(self, rate_hz: float) -> Iterator[Problem]:
        """Yield what is wrong between its keys.

        Args:
            rate_hz: samples of the motion a second.
        """
        del rate_hz
        return iter(())

    def facts(self) -> dict[str, object]:
        """Return what reports say about the weather besides its states."""
        return {}

    def warnings(self) -> tuple[str, ...]:
        """Return what the user should know about it before sailing."""
        return ()


@dataclass(frozen=True)
class Setting:
    """Scene and ship for which the states of a weather are computed.

    Attributes:
        scene: the scene of the weather.
        weather: the weather.
        heading: default heading of the waves [rad].
        speed: default speed of the ship [m/s].
    """

    scene: Surroundings
    weather: WeatherKind
    heading: float
    speed: float

    @cached_property
    def passage(self) -> Passage | None:
        """The voyage; None where there is none."""
        from tauto_core.ship.passage import Passage

        voyage = self.scene.voyage
        return None if voyage is None else Passage(self.scene, voyage)

    def passage_for(self, key: str, value: object) -> Passage:
        """Return the voyage that a key needs.

        Raises:
            SceneError: there is none.
        """
        if self.passage is None:
            problem = 'needs a voyage, and the scene has none'
            remedy = 'Write `voyage: …`, or give times, headings and speeds in numbers.'
            raise SceneError(self.scene.name, key, value, problem, remedy)
        return self.passage

    def time_of_place(self, place: int, key: str) -> int:
        """Return the time at which the ship is at a place of the voyage [ns].

        Args:
            place: 0 the departure, then the waypoints, then the arrival.
            key: the key that names the place.

        Raises:
            SceneError: there is no such place.
        """
        times = self.passage_for(key, place).places_ns
        if place < len(times):
            return times[place]
        problem = f'is not a place of the voyage, which has {len(times)}: 0 is the departure, '
        problem += f'{len(times) - 1} the arrival'
        remedy = f'Give a number from 0 to {len(times) - 1}, or `at: …` in seconds.'
        raise SceneError(self.scene.name, key, place, problem, remedy)

    def calm(self, at_ns: int, key: str) -> State:
        """Return a state without waves."""
        return State(at_ns, None, self.heading, self.speed, key)

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
    ) -> State:
        """Return a state with waves.

        Args:
            at_ns: time at which it is fully established.
            height: significant wave height [m].
            period: period of the peak [s].
            key: the key that gives it.
            spectrum: the spectrum of this sea, where it is not that of the weather.
            heading: direction in which the waves run, from the bow to port [rad].
            waves_to: the same from north to the east [rad], for `follow_route`.
            speed: speed of the ship [m/s], where the route is not followed.

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
            **({'gamma': weather.gamma} if shape == 'jonswap' else {}),
        )
        if weather.follow_route:
            passage = self.passage_for('ship.weather.follow_route', True)
            speed = passage.speed_m_s if passage.is_under_way(at_ns) else 0.0
            if waves_to is not None:
                heading = (passage.course(at_ns) - waves_to) % math.tau
        return State(
            at_ns,
            sea,
            self.heading if heading is None else heading,
            self.speed if speed is None else speed,
            key,
        )


def checked(states: Sequence[State], scene: Surroundings) -> tuple[State, ...]:
    """Return the states, after checking their times.

    Raises:
        SceneError: times that do not increase, or a change that is too quick.
    """
    for before, after in pairwise(states):
        apart_s = (after.at_ns - before.at_ns) / NS_PER_S
        if apart_s <= 0.0:
            problem = f'is at {after.at_ns / NS_PER_S:g} s, not later than the state before, at '
            problem += f'{before.at_ns / NS_PER_S:g} s'
            remedy = 'Give the states in the order of their times.'
            raise SceneError(scene.name, after.key, ABSENT, problem, remedy)
        if apart_s < LEAST_CHANGE_S and not after.goes_on(before):
            problem = f'comes {apart_s:g} s after the state before; a sea takes at least '
            problem += f'{LEAST_CHANGE_S:g} s to turn into another'
            raise SceneError(scene.name, after.key, ABSENT, problem, 'Put them further apart.')
    return tuple(states)


# -----------------------------------------------------------------------------
# A ship's motion in each state of the sea, and how reports describe the states.


def sums_of(states: Sequence[State]) -> tuple[int, ...]:
    """Return the number of each state's sum of harmonics, which equal states in a row share."""
    sums = [0]
    for number, (before, after) in enumerate(pairwise(states), 1):
        sums.append(sums[-1] if after.goes_on(before) else number)
    return tuple(sums)


def fades_of(
    states: Sequence[State],
    motion_of: Callable[[int], tuple[Harmonics, Harmonics | None]],
    *,
    heave: bool,
) -> tuple[Fades, Fades | None]:
    """Return roll and heave that change from state to state; heave is None if not asked for.

    Args:
        states: in the order of their times.
        motion_of: function that gives roll and heave of a state with waves, by its number.
        heave: whether heave is asked for.
    """
    at_ns, sums = tuple(state.at_ns for state in states), sums_of(states)
    made = lru_cache(maxsize=4)(motion_of)

    def roll_of(number: int) -> Harmonics | None:
        return None if states[number].sea is None else made(number)[0]

    def heave_of(number: int) -> Harmonics | None:
        return None if states[number].sea is None else made(number)[1]

    return Fades(at_ns, sums, roll_of), Fades(at_ns, sums, heave_of) if heave else None


def seas_at_once(states: Sequence[State], duration_ns: int) -> float:
    """Return the average number of seas that are summed at an instant of the scene: 0 to 2."""
    edges = np.array([0, *(state.at_ns for state in states), duration_ns])
    lengths = np.diff(np.clip(edges, 0, max(duration_ns, 1)))
    sums = sums_of(states)
    pairs = [(sums[0],), *pairwise(sums), (sums[-1],)]
    present = [sum(states[number].sea is not None for number in set(pair)) for pair in pairs]
    return float(np.dot(lengths, present) / max(lengths.sum(), 1))


def told(states: Sequence[State]) -> list[dict[str, Any]]:
    """Return the states as rows of numbers; for a calm the height is 0 and the rest None."""
    return [
        {
            'at_s': state.at_ns / NS_PER_S,
            'significant_wave_height_m': state.height,
            'peak_period_s': None if state.sea is None else state.sea.peak_period,
            'heading_rad': None if state.sea is None else state.heading,
            'speed_m_s': None if state.sea is None else state.speed,
        }
        for state in states
    ]


# -----------------------------------------------------------------------------
# Records of the sea from a buoy: a CSV file, or one of NDBC's standard meteorological files.
#
# NDBC's files (National Data Buoy Center, Measurement descriptions and units) have the columns
# WVHT, significant wave height [m], DPD, dominant wave period [s], and MWD, the direction from
# which the waves of that period come [degrees from true north]. Many rows have no waves, since
# these are measured less often than the wind.

HEIGHT, PERIOD, WAVES_FROM = 'significant_wave_height_m', 'peak_period_s', 'waves_from_deg'
UTC_TIME, SECONDS = 'time_utc', 'time_s'
MISSING = frozenset({'', 'MM', 'nan', 'NaN', 'NA'})
"""Cells without a measurement; heights and periods of 99 and directions of 999 mean the same."""
NINES, NINES_DEG = 99.0, 999.0
LONGEST_S = 40.0
"""Longest peak period of wind waves [s]."""

_NDBC = {HEIGHT: 'WVHT', PERIOD: 'DPD', WAVES_FROM: 'MWD'}
_YEARS = ('YY', 'YYYY')
_FORM = (
    f'Give a CSV file with the columns {UTC_TIME} or {SECONDS}, {HEIGHT} and {PERIOD}; for a '
    'standard meteorological file of NDBC give ship.weather.format: ndbc.'
)


class RecordFile(WeatherKind):
    """A buoy's record from a file; the scene that runs contains the rows themselves."""

    kind: Literal['record'] = 'record'
    path: Text = Field(description='file of the record')
    format: Literal['csv', 'ndbc'] = Field(
        default='csv', description='csv, or ndbc: a standard meteorological file'
    )
    begins: Text | None = Field(
        default=None,
        description='UTC at the start of the scene, as 2000-01-01T02:00; when left out that of '
        'the first row',
    )
    max_gap: Positive = Field(
        default=21_600.0, description='longest gap between rows that is bridged [s]'
    )


@dataclass(frozen=True)
class Row:
    """One row of a buoy's record.

    Attributes:
        line: line of the file.
        time_s: from 1970 in UTC, or as in the file.
        height: significant wave height [m].
        period: period of the peak [s].
        waves_from: direction from which the waves come, from north to the east [degrees]; None:
            unknown.
    """

    line: int
    time_s: float
    height: float
    period: float
    waves_from: float | None


def read_record(asked: RecordFile, *, by_direction: bool) -> dict[str, Any]:
    """Return the keys of `ship.weather` with a buoy's record.

    Rows where height or period is missing are left out, and where directions are needed those
    without a direction, unless no row has one. Rows are kept from the last one before `begins`;
    their times count from `begins`.

    Args:
        asked: the file, its format, when it begins and the longest gap.
        by_direction: whether the heading of the waves depends on their direction.

    Raises:
        SceneError: a file that cannot be read, a column that is missing, a cell that is not a
            number, a height or period out of range, times that do not increase, a gap longer than
            `max_gap`, or a time to begin at outside the record. With the line.
    """
    rows = sorted(
        _ndbc_rows(asked) if asked.format == 'ndbc' else _csv_rows(asked),
        key=lambda row: row.time_s,
    )
    if not rows:
        problem = 'holds no row with a wave height and a period'
        raise SceneError(asked.path, '', ABSENT, problem, _FORM)
    directed = [row for row in rows if row.waves_from is not None]
    kept = directed if by_direction and directed else rows
    begins_s = _begins_s(asked, kept)
    latest_s = max(row.time_s for row in kept if row.time_s <= begins_s)
    undirected = sum(row.time_s >= latest_s and row.waves_from is None for row in rows)
    rows = [row for row in kept if row.time_s >= latest_s]
    gaps = _check(asked, rows, 'waves and their direction' if kept is directed else 'waves')
    directions = [row.waves_from for row in rows]
    known = [math.radians((each + 180.0) % 360.0) for each in directions if each is not None]
    return {
        **asked.model_dump(exclude={'path', 'format', 'begins'}),
        'source': source_name(asked.path)[-LONGEST_TEXT:],
        'time': [row.time_s - begins_s for row in rows],
        'significant_wave_height': [row.height for row in rows],
        'peak_period': [row.period for row in rows],
        'waves_to': known if len(known) == len(rows) else None,
        'gaps_bridged': gaps,
        'rows_without_direction': undirected if by_direction else 0,
    }


def _begins_s(asked: RecordFile, rows: Sequence[Row]) -> float:
    """Return the time of the record at which the scene starts."""
    if asked.begins is None:
        return rows[0].time_s
    try:
        begins = datetime.fromisoformat(asked.begins)
    except ValueError:
        problem, remedy = 'is not a date and time', 'Write it as 2000-01-01T02:00, in UTC.'
        raise SceneError(asked.path, 'begins', asked.begins, problem, remedy) from None
    begins = begins.replace(tzinfo=UTC) if begins.tzinfo is None else begins
    if rows[0].time_s <= begins.timestamp() <= rows[-1].time_s:
        return begins.timestamp()
    first, last = (
        datetime.fromtimestamp(row.time_s, UTC).strftime('%Y-%m-%dT%H:%M')
        for row in (rows[0], rows[-1])
    )
    problem = f'is not within the record, from {first} to {last}'
    raise SceneError(asked.path, 'begins', asked.begins, problem, 'Give a time within it.')


def _check(asked: RecordFile, rows: Sequence[Row], measured: str) -> int:
    """Refuse rows that cannot be used as weather; return the number of gaps that are bridged.

    Args:
        asked: file and longest gap.
        rows: the rows that are kept.
        measured: what they all have.
    """
    for row in rows:
        for name, value, limit in (
            (HEIGHT, row.height, HIGHEST_M),
            (PERIOD, row.period, LONGEST_S),
        ):
            if not 0.0 < value <= limit:
                problem = f'must be greater than 0 and at most {limit:g}'
                remedy = 'Correct or drop the row.'
                raise SceneError(asked.path, f'line {row.line}, {name}', value, problem, remedy)
    steps = [after.time_s - before.time_s for before, after in pairwise(rows)]
    for step, row in zip(steps, rows[1:], strict=True):
        if step <= 0.0:
            problem, remedy = 'has the time of another row', 'Drop what is double.'
            raise SceneError(asked.path, f'line {row.line}', ABSENT, problem, remedy)
        if step > asked.max_gap:
            problem = f'comes {step:g} s after the last row with {measured}; max_gap is '
            problem += f'{asked.max_gap!r} s'
            remedy = 'Raise ship.weather.max_gap, or cut the record at the gap.'
            raise SceneError(asked.path, f'line {row.line}', ABSENT, problem, remedy)
    usual = sorted(steps)[len(steps) // 2] if steps else 0.0
    return sum(step > 1.5 * usual for step in steps)


def _lines(asked: RecordFile) -> list[str]:
    try:
        return data_path(asked.path).read_text(encoding='utf-8-sig').splitlines()
    except (OSError, UnicodeDecodeError) as error:
        problem = f'cannot be read as text: {error}'
        raise SceneError(asked.path, '', None, problem, _FORM) from error


def _csv_rows(asked: RecordFile) -> Iterator[Row]:
    """Yield the rows of a CSV file in which waves were measured."""
    reader = csv.reader(_lines(asked))
    header = [cell.strip() for cell in next(reader, [])]
    time = UTC_TIME if UTC_TIME in header else SECONDS
    if time == SECONDS and asked.begins is not None:
        problem = f'needs the column {UTC_TIME}; {SECONDS} counts from a start of its own'
        raise SceneError(asked.path, 'begins', asked.begins, problem, 'Leave it out.')
    _check_header(asked, header, (time, HEIGHT, PERIOD))
    for cells in reader:
        if ''.join(cells).strip():
            line = reader.line_num
            named = _named(asked, header, cells, line)
            waves = _waves(asked, line, named, {each: each for each in _NDBC})
            if waves is not None:
                at = _utc(asked, line, named[time]) if time == UTC_TIME else None
                seconds = _number(asked, line, time, named[time]) if at is None else at
                yield Row(line, seconds, *waves)


def _ndbc_rows(asked: RecordFile) -> Iterator[Row]:
    """Yield the rows of a standard meteorological file in which waves were measured."""
    lines = _lines(asked)
    header = lines[0].lstrip('#').split() if lines else []
    year = next((name for name in _YEARS if name in header), 'YYYY')
    # MM is the month in the header, and a missing value in the rows
    _check_header(asked, header, (year, 'MM', 'DD', 'hh', 'WVHT', 'DPD'))
    for line, text in enumerate(lines[1:], 2):
        if not text.strip() or text.startswith('#'):
            continue
        named = _named(asked, header, text.split(), line)
        waves = _waves(asked, line, named, _NDBC)
        if waves is not None:
            yield Row(line, _ndbc_time(asked, line, named, year), *waves)


def _check_header(asked: RecordFile, header: Sequence[str], wanted: Sequence[str]) -> None:
    for column in wanted:
        if header.count(column) != 1:
            what = 'is named more than once' if column in header else 'is missing'
            raise SceneError(asked.path, f'line 1, column {column}', ABSENT, what, _FORM)


def _named(
    asked: RecordFile, header: Sequence[str], cells: Sequence[str], line: int
) -> dict[str, str]:
    if len(cells) != len(header):
        problem = f'has {len(cells)} cells, the header {len(header)}'
        raise SceneError(asked.path, f'line {line}', ABSENT, problem, 'Correct or drop the row.')
    return {name: cell.strip() for name, cell in zip(header, cells, strict=True)}


def _waves(
    asked: RecordFile, line: int, named: dict[str, str], columns: dict[str, str]
) -> tuple[float, float, float | None] | None:
    """Return height, period and direction of a row; None where no waves were measured."""
    found = []
    for column, nines in ((HEIGHT, NINES), (PERIOD, NINES), (WAVES_FROM, NINES_DEG)):
        name = columns[column]
        cell = named.get(name, '')
        value = None if cell in MISSING else _number(asked, line, name, cell)
        found.append(None if value is None or value >= nines else value)
    height, period, waves_from = found
    return None if height is None or period is None else (height, period, waves_from)


def _ndbc_time(asked: RecordFile, line: int, named: dict[str, str], year: str) -> float:
    try:
        whole = int(named[year])
        # files before 1999 have two digits
        whole += 1900 if whole < 100 else 0
        minute = timedelta(minutes=int(named.get('mm', '0')))
        at = datetime(whole, int(named['MM']), int(named['DD']), int(named['hh']), tzinfo=UTC)
    except ValueError as error:
        problem = f'has no date and time: {error}'
        remedy = 'Correct or drop the row.'
        raise SceneError(asked.path, f'line {line}', ABSENT, problem, remedy) from None
    return (at + minute).timestamp()


def _utc(asked: RecordFile, line: int, cell: str) -> float:
    try:
        at = datetime.fromisoformat(cell)
    except ValueError:
        problem, remedy = 'is not a date and time', 'Write it as 2000-01-01T02:00, in UTC.'
        key = f'line {line}, {UTC_TIME}'
        raise SceneError(asked.path, key, cell, problem, remedy) from None
    return (at.replace(tzinfo=UTC) if at.tzinfo is None else at).timestamp()


def _number(asked: RecordFile, line: int, name: str, cell: str) -> float:
    try:
        # Python reads 1_0 as 10
        number = math.nan if '_' in cell else float(cell)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        problem, remedy = 'is not a finite number', 'Correct or drop the row.'
        raise SceneError(asked.path, f'line {line}, {name}', cell, problem, remedy)
    return number
