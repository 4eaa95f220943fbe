"""Log-books: files of noon entries, the passages in them, and a scene of a passage.

Formats, recognised by the beginning of a file:

- our columns: `passage`, `utc`, `latitude`, `longitude` [degrees, north and east +],
  `wind_from_deg`, `wind_mps`, and optionally `air_celsius`, `nation`, `ship`, `from`, `to`;
- CLIWOC's table of release 2.1 (`YR`, …);
- tracks in GPX (by gpxpy, the extra `gpx`), with a CSV file of winds: `utc`, `wind_from_deg`,
  `wind_mps`, `air_celsius`.

Any of them may be compressed (`.gz`). In our columns the rows of one name form a passage, and a
faulty passage is refused. In the other formats the entries of a log are sorted by time, and a
passage ends at a gap longer than `LONGEST_GAP_DAYS` or at a step faster than a ship sails.
"""

from __future__ import annotations

import codecs
import csv
import datetime
import difflib
import gzip
import io
import math
import re
import zlib
from array import array
from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import groupby, pairwise
from typing import Any, BinaryIO

import numpy as np
from pydantic import ValidationError

from tauto_core.files import PLAUSIBLE, SMALL_PART
from tauto_core.scene.errors import ABSENT, Problem, SceneError, install
from tauto_core.scene.refuse import explain
from tauto_core.scene.sections import (
    FASTEST_KNOTS,
    FIRST_HOURS,
    LONGEST_TEXT,
    NEAREST_ENTRIES_S,
    VARIABLE_WINDS,
    EntryProblem,
    LogEntry,
    LogFile,
    entry_problems,
    has_wind,
    log_time,
    nautical_miles,
)
from tauto_core.scene.tables import (
    LARGEST_BYTES,
    MISSING,
    Column,
    data_path,
    header_words,
    missing_file,
    read_table,
    source_name,
    words_of,
)
from tauto_core.scene.times import DAY_S, in_utc, number_in, utc_on
from tauto_core.wording import counted

LONGEST_GAP_DAYS = 6.0
"""Longest time between two entries of a passage, if the format does not name passages."""

LEAST_ENTRIES = 25
"""Fewest entries of such a passage. Shorter pieces are left out."""

FAST_KNOTS = 10.0
"""Mean speed between two entries above which a step is doubtful [knots]."""

WINDY_MPS = 13.0
"""Mean wind of a passage above which its unit is doubtful [m/s].

371 passages of CLIWOC have 4.0 to 12.6 m/s. Their median, 7.9 m/s, is 15.4 knots.
"""

FORMS = (
    'our columns (passage, utc, latitude, longitude, wind_from_deg, wind_mps), a table of CLIWOC, '
    'release 2.1, or GPX tracks'
)

_WORDS = {'ship': 'ship', 'nation': 'nation', 'sailed_from': 'from', 'bound_to': 'to'}
"""Names of a passage and their columns in our tables."""

Progress = Callable[[float], None]


@dataclass(frozen=True)
class LoggedPassage:
    """A passage of a log-book.

    Attributes:
        name: key in a scene: day of the first entry and number of the voyage, or the name of the
            track.
        source: name of the file.
        lines: line or point of each entry in the file.
        entries: see `voyage.log.entries`.
        wrong: first cell that cannot be read. It makes the passage unusable.
        left_out: number of entries dropped because another is less than an hour away.
        lost: other reasons for dropping rows of the log, and the number of rows.
        unit: `line` of a table or `point` of a track.
    """

    name: str
    source: str
    ship: str = ''
    nation: str = ''
    sailed_from: str = ''
    bound_to: str = ''
    lines: tuple[int, ...] = ()
    entries: tuple[LogEntry, ...] = ()
    wrong: EntryProblem | None = None
    left_out: int = 0
    lost: tuple[tuple[str, int], ...] = ()
    unit: str = field(default='line', compare=False)

    def problems(self, longest_gap_days: float = LONGEST_GAP_DAYS) -> Iterator[Problem]:
        """Yield the problems that make it unusable, by passage and row."""
        for item in [self.wrong] if self.wrong else entry_problems(self.entries, longest_gap_days):
            place = f'passage {self.name}'
            if item.entry < len(self.lines):
                place += f', row {item.entry + 1} ({self.unit} {self.lines[item.entry]})'
            key = f'{place}, {item.column}' if item.column else place
            yield Problem(key, item.value, item.problem, item.remedy)

    @property
    def days(self) -> float:
        """Time from the first to the last entry [days]."""
        begin, end = (log_time(self.entries[index][0]) for index in (0, -1))
        return (end - begin).total_seconds() / DAY_S

    @property
    def is_track(self) -> bool:
        """Whether it is a track in GPX. Its entries are an hour apart, its winds are not."""
        return self.unit == 'point'

    def share(self, column: int) -> float:
        """Return the share of entries that have a number in a column of `LogEntry`.

        For the winds of a track it is the share of the time. A wind has blown since the previous
        one, but at most for `FIRST_HOURS`.
        """
        has_one = [entry[column] is not None for entry in self.entries]
        if not self.is_track or column != 4 or not any(has_one):
            return sum(has_one) / max(len(has_one), 1)
        at = [log_time(entry[0]).timestamp() / 3600.0 for entry in self.entries]
        winds = [hour for hour, is_known in zip(at, has_one, strict=True) if is_known]
        since = [min(winds[0] - at[0], FIRST_HOURS)]
        since += [min(b - a, FIRST_HOURS) for a, b in pairwise(winds)]
        return sum(since) / (at[-1] - at[0])

    def notes(self) -> list[str]:
        """Return notes on doubtful entries."""
        notes = []
        times = [log_time(entry[0]) for entry in self.entries]
        hours = [(end - begin).total_seconds() / 3600.0 for begin, end in pairwise(times)]
        miles = [nautical_miles(a[1:3], b[1:3]) for a, b in pairwise(self.entries)]
        knots = [way / took for way, took in zip(miles, hours, strict=True) if took]
        fast = [speed for speed in knots if speed > FAST_KNOTS]
        if fast and not self.is_track:
            notes.append(
                f'{counted(len(fast), "step")} of {FAST_KNOTS:g} to {max(fast):.1f} knots, '
                'perhaps corrections of the reckoning'
            )
        gaps = [took / 24.0 for took in hours if took > 36.0]
        if gaps:
            notes.append(f'{counted(len(gaps), "gap")} of up to {max(gaps):.2g} days')
        windless = sum(not has_wind(entry) for entry in self.entries)
        if self.is_track and windless < len(self.entries):
            covered = f'{100.0 * self.share(4):.0f} % of the time'
            number = counted(len(self.entries) - windless, 'wind')
            notes.append(f'{number}, each has blown since the one before: {covered}')
        elif windless:
            variable = sum(entry[3] in VARIABLE_WINDS for entry in self.entries)
            suffix = f', {variable} variable' if variable else ''
            sealess = ': no sea grows from it' if windless == len(self.entries) else ''
            of = f'{windless} of {len(self.entries)} entries'
            notes.append(f'{of} without a wind{suffix}{sealess}')
        winds = [wind for *_, wind, _ in self.entries if wind is not None]
        mean = sum(winds) / max(len(winds), 1)
        if mean > WINDY_MPS:
            notes.append(f'a wind of {mean:.3g} m/s in the mean: perhaps in knots')
        if self.left_out:
            notes.append(f'{counted(self.left_out, "row")} within an hour of others, left out')
        for why, rows in self.lost:
            notes.append(f'{counted(rows, "row")} of this log {why}, left out')
        return notes

    def section(self) -> dict[str, Any]:
        """Return the keys of `voyage.log`, with the entries as figures."""
        words = {key: getattr(self, key) for key in _WORDS if getattr(self, key)}
        entries = [list(entry) for entry in self.entries]
        return {'source': self.source, 'passage': self.name, **words, 'entries': entries}


def scene_of_passage(
    scene: dict[str, Any], passage: LoggedPassage, harbour_days: float = 0.0
) -> dict[str, Any]:
    """Return the mapping of a scene that sails a passage with the machine of another scene.

    The log gives air, duration and times, and its winds raise the sea. The scene's weather and
    air keep only the keys that do not depend on the voyage. The dial is regulated at the start.

    Args:
        scene: mapping as in a scene file.
        passage: one without problems.
        harbour_days: time in still water before it [days].
    """
    dropped = 'duration', 'starts_at', 'voyage', 'air'
    mapping = {key: value for key, value in scene.items() if key not in dropped}
    clock = '' if passage.is_track else f'{scene.get("name", "scene")} '
    mapping['name'] = f'{clock}{passage.name}'[:LONGEST_TEXT]
    if isinstance(scene.get('clock'), dict):
        mapping['clock'] = {**scene['clock'], 'nominal_period': None}
    ship = dict(mapping.get('ship') or {})
    for key in OF_THE_SEA:
        ship.pop(key, None)
    weather = ship.get('weather') or {}
    afar = ('background_swell',) if weather.get('kind') == 'log' else ()
    keys = ('spectrum', 'gamma', 'components', 'cutoff', *afar)
    options = {key: weather[key] for key in keys if weather.get(key) is not None}
    mapping['ship'] = {**ship, 'kind': 'sea', 'weather': {'kind': 'log', **options}}
    if isinstance(scene.get('air'), dict):
        options = {key: scene['air'][key] for key in OF_THE_BOX if key in scene['air']}
        mapping['air'] = {'kind': 'log', **options}
    log = passage.section()
    if harbour_days:
        log['harbour_days'] = harbour_days
    mapping['voyage'] = {'log': log}
    return mapping


OF_THE_SEA = 'sea', 'heading', 'speed'
"""Keys of `ship` that the log replaces."""
OF_THE_BOX = 'diurnal', 'warmest_hour', 'box_hours'
"""Keys of `air` that a passage keeps."""


def with_log_read(voyage: dict[str, Any], origin: str) -> dict[str, Any]:
    """Return the keys of a voyage, with the entries of the passage if `log` names a file.

    Raises:
        SceneError: wrong keys, file or passage, by passage and row.
    """
    log = voyage.get('log')
    if not isinstance(log, dict) or 'path' not in log:
        return voyage
    try:
        file = LogFile.model_validate(log)
    except ValidationError as error:
        problems = [
            Problem(f'voyage.log.{item.key}', item.value, item.problem, item.remedy)
            for item in explain(error, LogFile)
        ]
    else:
        problems = missing_file('voyage.log.path', file.path, folders=True)
        if file.winds is not None:
            problems += missing_file('voyage.log.winds', file.winds)
        if not problems:
            passage = find_passage(file.path, file.passage, winds=file.winds)
            problems = list(passage.problems(file.longest_gap_days))
            if not problems:
                options = file.model_dump(include={'harbour_days', 'longest_gap_days'})
                return {**voyage, 'log': {**passage.section(), **options}}
            origin = file.path
    raise SceneError.of(origin, problems) from None


def find_passage(path: str, name: str | None, *, winds: str | None = None) -> LoggedPassage:
    """Return the passage of a log-book with this name, or the only one without a name.

    Raises:
        SceneError: no passage has the name, or there are several and `name` is `None`.
    """
    names = []
    match = None
    for passage in read_passages(path, winds=winds):
        if passage.name == name:
            return passage
        names.append(passage.name)
        match = match or passage
    if name is None and match is not None and len(names) == 1:
        return match
    like = difflib.get_close_matches(name or '', names, 3) or names[:3]
    problem = (
        f'is missing: {source_name(path)} has {len(names)} passages'
        if name is None
        else f'is not one of the {len(names)} passages of {source_name(path)}'
    )
    remedy = f'Use for example {", ".join(like)}, or see `tauto logbook`.' if like else 'See it.'
    raise SceneError(path, 'voyage.log.passage', name or ABSENT, problem, remedy)


def sound_passage(path: str, name: str | None, *, winds: str | None = None) -> LoggedPassage:
    """Return a passage as `find_passage` does. Raise SceneError if it has problems."""
    passage = find_passage(path, name, winds=winds)
    if problems := list(passage.problems()):
        raise SceneError.of(path, problems)
    return passage


# -----------------------------------------------------------------------------
# Reading files, row by row.


LONGEST_LINE = 65_536
"""Limit of a line [characters]. A longer one may come from a file that unpacks to gigabytes."""


@dataclass
class _Text:
    """The text of a log-book, unpacked if it is compressed, up to a limit."""

    path: str
    raw: BinaryIO
    progress: Progress | None
    part: float = 0.5  # share of the progress, if all rows are read before the first passage

    def __post_init__(self) -> None:
        packed = self.raw.read(2) == b'\x1f\x8b'
        self.size = self.raw.seek(0, 2)
        self.raw.seek(0)
        self._most = max(SMALL_PART, PLAUSIBLE * self.size)
        self._bytes: Any = gzip.GzipFile(fileobj=self.raw) if packed else self.raw
        self._text = io.TextIOWrapper(self._bytes, encoding='utf-8-sig', errors=_LATIN, newline='')
        self.beginning = self._text.readline(LONGEST_LINE)

    def refusal(self, problem: str) -> SceneError:
        """Return the error for a text that is not a log-book."""
        return SceneError(self.path, '', ABSENT, problem, f'Give {FORMS}.')

    def check(self, line: int, text: str) -> str:
        """Return a line. Refuse one that is too long, and a file that unpacks without end."""
        if len(text) == LONGEST_LINE:
            problem = f'line {line} has {LONGEST_LINE:,} characters or more, which no log-book has'
            raise self.refusal(problem)
        if line % 4096 == 0 and self._bytes.tell() > self._most:
            raise self.refusal(f'unpacks to more than {self._most:,} bytes, as no log-book does')
        return text

    def lines(self) -> Iterator[str]:
        """Yield the lines below the first."""
        for line, text in enumerate(iter(partial(self._text.readline, LONGEST_LINE), ''), 2):
            if self.progress is not None and line % 4096 == 2:
                self.progress(self.part * self.raw.tell() / self.size)
            yield self.check(line, text)

    def whole(self) -> str:
        """Return all of the text."""
        limit = min(self._most, LARGEST_BYTES)
        text = self.beginning + self._text.read(limit)
        if len(text) >= limit:
            raise self.refusal(f'has more than {limit:,} bytes, as no track has')
        return text


def read_passages(
    path: str, *, winds: str | None = None, progress: Progress | None = None
) -> Iterator[LoggedPassage]:
    """Yield the passages of a log-book, including those with problems.

    Args:
        path: the file, in any of the formats above.
        winds: for tracks in GPX, a CSV file of winds.
        progress: called with the share of the file that has been read.

    Raises:
        SceneError: the file has another format, cannot be read, or lacks columns.
    """
    file = data_path(path)
    try:
        with file.open('rb') as raw:
            book = _Text(path, raw, progress)
            is_track = book.beginning.lstrip().startswith('<')
            beginning = '' if is_track else book.check(1, book.beginning).rstrip('\r\n')
            if winds is not None and not is_track:
                problem = 'go with tracks in GPX, and this log-book has its own winds'
                raise SceneError(path, 'winds', winds, problem, 'Leave them out.')
            divided = max('\t;,', key=beginning.count)
            names = [name.strip().strip('"') for name in beginning.split(divided)]
            rows = csv.reader(book.lines(), delimiter=divided)
            if is_track:
                logs = _tracks(path, book.whole(), winds)
            elif 'YR' in names:
                logs = _cliwoc(path, names, rows)
            elif _OURS & {name.casefold() for name in names}:
                book.part = 1.0
                yield from _ours(path, names, rows)
                return
            else:
                problem = f'is not a known log-book. Its columns are {header_words(names)}'
                raise book.refusal(problem)
            yield from _pieces(path, logs, 'point' if is_track else 'line', progress)
    except (OSError, EOFError, zlib.error) as error:
        problem = f'cannot be read: {getattr(error, "strerror", None) or error}'
        raise SceneError(path, '', None, problem, 'Name another file.') from None
    except csv.Error as error:
        problem = f'cannot be read as a table: {error}'
        raise SceneError(path, '', None, problem, f'Give {FORMS}.') from None


_LATIN = 'tauto-latin'
_OURS = {'passage', 'utc', 'latitude', 'longitude', 'wind_from_deg', 'wind_mps'}


codecs.register_error(_LATIN, lambda e: (e.object[e.start : e.end].decode('latin-1'), e.end))  # type: ignore[attr-defined]


def _places(path: str, names: list[str], wanted: Sequence[str]) -> dict[str, int]:
    """Return the positions of a header's columns. Refuse missing or repeated wanted columns."""
    for name in wanted:
        if names.count(name) > 1:
            problem = f'is named more than once among the columns {", ".join(names)}'
            remedy = 'Rename the one that is not meant.'
            raise SceneError(path, f'line 1, column {name}', ABSENT, problem, remedy)
        if name not in names:
            problem = f'is missing among the columns {", ".join(names)}'
            raise SceneError(path, f'line 1, column {name}', ABSENT, problem, f'Give {FORMS}.')
    return {name: index for index, name in reversed(list(enumerate(names)))}


def _ours(path: str, names: list[str], rows: Iterator[list[str]]) -> Iterator[LoggedPassage]:
    at = _places(path, names, sorted(_OURS))
    numbers = ('latitude', 'longitude', 'wind_from_deg', 'wind_mps', 'air_celsius')
    past: set[str] = set()

    named = ((line, cells) for line, cells in enumerate(rows, 2) if ''.join(cells).strip())
    padding = [''] * (len(names) + 1)
    for name, group in groupby(named, lambda row: _printed((row[1] + padding)[at['passage']])):
        lines, table = zip(*group, strict=True)
        wrong, entries = None, []
        for row, cells in enumerate(table):
            padded = [cell.strip() for cell in cells + padding]
            entry: list[Any] = [padded[at['utc']]]
            for column in numbers:
                cell = padded[at.get(column, -1)]
                try:
                    entry.append(_measured(column, cell))
                except ValueError as error:
                    windy = column == 'wind_from_deg'
                    remedy = 'Leave it empty if the wind was variable.' if windy else 'Correct it.'
                    wrong = wrong or EntryProblem(row, column, cell or ABSENT, str(error), remedy)
                    entry.append(0.0)
            entry[2] = _wrapped(entry[2])
            entries.append(tuple(entry))
            if len(cells) != len(names):
                problem = f'has {len(cells)} cells, the header {len(names)}'
                wrong = wrong or EntryProblem(row, '', ABSENT, problem, 'Correct it.')
        if not name:
            remedy = 'Name it, for example by its first day and a number.'
            wrong = EntryProblem(0, 'passage', ABSENT, 'is missing', remedy)
        elif name in past:
            problem = 'comes again after other passages'
            remedy = 'Keep its rows together, in the order of their times.'
            wrong = wrong or EntryProblem(0, 'passage', name, problem, remedy)
        past.add(name)
        words: dict[str, Any] = {
            key: _printed((table[0] + padding)[at.get(column, -1)])
            for key, column in _WORDS.items()
        }
        yield LoggedPassage(
            name, source_name(path), **words, lines=lines, entries=tuple(entries), wrong=wrong
        )
    if not past:
        raise SceneError(path, '', ABSENT, 'holds no rows below its header', 'Add some.')


def _printed(cell: str) -> str:
    """Return a cell in one line, of at most `LONGEST_TEXT` printable letters."""
    printable = ''.join(letter if letter.isprintable() else ' ' for letter in cell)
    return ' '.join(printable.split())[:LONGEST_TEXT]


def _measured(column: str, cell: str) -> float | None:
    """Return the number in a cell of our columns, `None` if it is empty, or raise ValueError."""
    if cell.lower() == 'nan' and column in ('wind_from_deg', 'wind_mps'):
        raise ValueError('is not a number. Leave the cell empty if there was no wind')
    limit = {'latitude': 90.0, 'longitude': 360.0}.get(column)
    if cell in MISSING:
        if limit is not None:
            raise ValueError('is missing')
        return None
    value = number_in(cell)
    if not math.isfinite(value):
        raise ValueError('is not a finite number')
    if limit is not None and abs(value) > limit:
        raise ValueError(f'must be within {limit:g} degrees')
    return value


def _wrapped(longitude: float) -> float:
    return longitude if -180.0 <= longitude <= 180.0 else (longitude + 180.0) % 360.0 - 180.0


# -----------------------------------------------------------------------------
# Files that do not name passages: rows by log, cut at gaps and jumps.

# A place of a point that Python would read as a number: 1_0 as 10.
_SLIP = re.compile(r"""\b(?:lat|lon)\s*=\s*["']\s*([-+.\d]*_[^"']{0,20})""")

_NUMBERS = 7
"""Numbers of a row: time since 1970 [s], line, latitude, longitude, wind from, wind, air, or NaN.

As tuples, CLIWOC's rows would take six times the memory.
"""


@dataclass
class _Logs:
    """The rows of each log, of `_NUMBERS` each, its names, and the counts of unusable rows."""

    rows: dict[Any, array[float]] = field(default_factory=lambda: defaultdict(lambda: array('d')))
    named: dict[Any, dict[str, str]] = field(default_factory=dict)
    lost: dict[Any, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))

    def add(
        self,
        log: object,
        line: int,
        at: datetime.datetime,
        place: tuple[float, float],
        wind: Sequence[float | None],
    ) -> None:
        """Add a row with a time and a place."""
        since_s = math.floor(at.timestamp())
        numbers = (math.nan if value is None else value for value in wind)
        self.rows[log].extend((since_s, line, *place, *numbers))


def _at(row: list[float]) -> datetime.datetime:
    return datetime.datetime.fromtimestamp(row[0], datetime.UTC).replace(tzinfo=None)


def _pieces(
    path: str, logs: _Logs, unit: str, progress: Progress | None
) -> Iterator[LoggedPassage]:
    """Yield the passages of logs. Without any, a `SceneError` counts the rows by their faults."""
    fewest, timespec = (LEAST_ENTRIES, 'minutes') if unit == 'line' else (2, 'seconds')
    empty = True
    ships = Counter(words.get('ship') for words in logs.named.values())
    for number, (log, named) in enumerate(logs.named.items(), 1):
        table = np.frombuffer(logs.rows[log]).reshape(-1, _NUMBERS)
        pieces: list[list[list[float]]] = []
        dropped = 0
        for row in table[np.lexsort((table[:, 1], table[:, 0]))].tolist():
            if not pieces:
                pieces.append([row])
                continue
            previous = pieces[-1][-1]
            took_s = row[0] - previous[0]
            if took_s < NEAREST_ENTRIES_S:
                dropped += 1
                continue
            miles = nautical_miles((previous[2], previous[3]), (row[2], row[3]))
            is_far = miles > FASTEST_KNOTS * took_s / 3600.0
            if is_far or took_s > LONGEST_GAP_DAYS * DAY_S:
                pieces.append([])
            pieces[-1].append(row)
        if progress is not None:
            progress(0.5 + 0.5 * number / len(logs.named))
        words: dict[str, Any] = {key: _printed(word) for key, word in named.items()}
        name = words.pop('number')
        track = words['ship'] if unit == 'point' and ships[named['ship']] == 1 else ''
        for count, piece in enumerate(pieces, 1):
            if len(piece) >= fewest:
                empty = False
                numbered = f'{track}-{count}' if track and count > 1 else track
                yield LoggedPassage(
                    numbered or f'{_at(piece[0]):%Y%m%d}-{name}',
                    source_name(path),
                    **words,
                    lines=tuple(int(row[1]) for row in piece),
                    entries=tuple(_entry(row, timespec) for row in piece),
                    left_out=dropped,
                    lost=tuple(logs.lost[log].items()),
                    unit=unit,
                )
    if empty:
        lost = sum(logs.lost.values(), Counter[str]())
        count = sum(map(len, logs.rows.values())) // _NUMBERS + lost.total()
        counts = [f'{counted(count, unit)} of {counted(len(logs.named), "log")}']
        counts += [f'{number} {why}' for why, number in lost.items()]
        problem = f'has no passage of {fewest} entries, but {", ".join(counts)}'
        remedy = f'A gap of more than {LONGEST_GAP_DAYS:g} days ends a passage. Give a longer log.'
        raise SceneError(path, '', ABSENT, problem, remedy)


def _entry(row: list[float], timespec: str) -> LogEntry:
    _, _, latitude, longitude, *wind = row
    blows_from, blows, celsius = (None if math.isnan(value) else value for value in wind)
    return _at(row).isoformat(timespec=timespec), latitude, longitude, blows_from, blows, celsius


def _number(cell: str, factor: float = 1.0) -> float | None:
    """Return the number in a cell times a factor, or `None`."""
    try:
        number = number_in(cell)
    except ValueError:
        return None
    return round(factor * number, 9) if math.isfinite(number) else None


_UNITS = {'HR': 0.01, 'LAT': 0.01, 'LON': 0.01, 'W': 0.1, 'AT': 0.1}
_CLIWOC_WORDS = {
    'ship': 'ShipName',
    'nation': 'Nationality',
    'sailed_from': 'VoyageFrom',
    'bound_to': 'VoyageTo',
}


def _cliwoc(path: str, names: list[str], rows: Iterator[list[str]]) -> _Logs:
    """Return the logs of a table of CLIWOC. Rows without a possible time or place are lost."""
    wanted = ('YR', 'MO', 'DY', 'HR', 'LAT', 'LON', 'ID', 'D', 'W')
    at, logs = _places(path, names, wanted), _Logs()
    for line, cells in enumerate(rows, 2):
        if len(cells) != len(names):
            logs.lost[None]['with more or fewer cells than the header'] += 1
            continue
        log = cells[at['ID']].strip()
        year, month, day, hour, latitude, longitude, *wind = (
            _number(cells[at[name]], _UNITS.get(name, 1.0)) if name in at else None
            for name in (*wanted, 'AT')
            if name != 'ID'
        )
        if log not in logs.named:
            words = {
                key: cells[at[name]].strip() for key, name in _CLIWOC_WORDS.items() if name in at
            }
            words = {key: word for key, word in words.items() if word not in MISSING}
            logs.named[log] = {'number': log.lstrip('0') or '0', **words}
        lost = ''
        if latitude is None or longitude is None:
            lost = 'without a place'
        elif not (abs(latitude) <= 90.0 and abs(longitude) <= 360.0):
            lost = 'with a place that is not on the globe'
        else:
            try:
                second = -1.0 if hour is None else 3600.0 * hour
                moment = utc_on(year or 0.0, month or 0.0, day or 0.0, second)
                logs.add(log, line, moment, (latitude, _wrapped(longitude)), wind)
            except ValueError:
                lost = 'with the hour 24' if hour == 24.0 else 'without a possible time'
        if lost:
            logs.lost[log][lost] += 1
    return logs


def _tracks(path: str, text: str, winds: str | None) -> _Logs:
    """Return the tracks of a text in GPX, hour by hour, with the winds of a table.

    The place of a wind is interpolated between the points of the track.
    """
    try:
        import gpxpy
    except ImportError:
        raise SceneError(
            path, '', None, 'is a track in GPX, which gpxpy reads', install('gpx')
        ) from None
    try:
        if slip := _SLIP.search(text):
            raise ValueError(f'{slip[1]} is not a number')
        tracks = gpxpy.parse(text).tracks
    except Exception as error:  # gpxpy's and its parsers' errors
        problem = f'cannot be read as GPX: {words_of(error)}'
        raise SceneError(path, '', None, problem, 'Correct it.') from None
    if not tracks:
        problem = 'has no tracks, and points and routes have no times'
        raise SceneError(path, '', ABSENT, problem, 'Give a track that was recorded.')
    logs = _Logs()
    blown = [] if winds is None else _winds(winds)
    for number, track in enumerate(tracks, 1):
        points = [point for segment in track.segments for point in segment.points]
        timed = sorted(
            (_moment(path, f'track {number}, point {index}', point), index, point)
            for index, point in enumerate(points, 1)
            if point.time is not None
        )
        if not timed:
            problem = f'track {number} has no points with a time'
            raise SceneError(path, '', ABSENT, problem, 'Give one that was recorded.')
        hours: list[tuple[datetime.datetime, int, tuple[float, float]]] = []
        for at, index, point in timed:
            if not hours or (at - hours[-1][0]).total_seconds() >= NEAREST_ENTRIES_S:
                hours.append((at, index, (point.latitude, point.longitude)))
        moments = [at for at, *_ in timed]
        windy = []
        for at, wind in blown:
            if not (len(moments) > 1 and moments[0] <= at <= moments[-1]):
                continue
            upper = max(bisect_left(moments, at), 1)
            (begin, _, a), (end, index, b) = timed[upper - 1 : upper + 1]
            part = (at - begin) / (end - begin)
            east = math.remainder(b.longitude - a.longitude, 360.0)
            place = (
                a.latitude + part * (b.latitude - a.latitude),
                _wrapped(a.longitude + part * east),
            )
            logs.add(number, index, at, place, wind)
            windy.append(at)
        for at, index, place in hours:
            # a wind replaces the hours of the track near it
            nearest = bisect_left(windy, at)
            neighbours = windy[max(nearest - 1, 0) : nearest + 1]
            if all(abs((wind - at).total_seconds()) >= NEAREST_ENTRIES_S for wind in neighbours):
                logs.add(number, index, at, place, (None, None, None))
        logs.named[number] = {'number': str(number), 'ship': (track.name or '').strip()}
    return logs


def _moment(path: str, where: str, point: Any) -> datetime.datetime:
    """Return the time of a point. Raise `SceneError` if its time or place is not possible."""
    key, value = 'time', point.time
    try:
        at = in_utc(value)
        for key, limit in (('latitude', 90.0), ('longitude', 360.0)):
            value = getattr(point, key)
            if not abs(value) <= limit:
                raise ValueError(f'must be within {limit:g} degrees')
    except ValueError as error:
        where = f'{where}, {key}'
        raise SceneError(path, where, value, str(error), 'Correct or drop it.') from None
    return at


def _winds(path: str) -> list[tuple[datetime.datetime, tuple[float, float, float | None]]]:
    """Return the time, and direction, speed and air, of each row of a table of winds."""
    columns = (
        Column('utc', utc=True, rising='later than the row before'),
        Column('wind_from_deg', least=0.0, most=360.0, unit='degrees'),
        Column('wind_mps', least=0.0, most=40.0, unit='m/s', why='a hurricane has 35'),
        Column('air_celsius', optional=True, gaps='nan', least=-60.0, most=60.0),
    )
    remedy = 'Give a CSV file with the columns utc, wind_from_deg and wind_mps.'
    table = read_table(path, columns, remedy=remedy)
    airs = table['air_celsius'] if 'air_celsius' in table else [math.nan] * len(table)
    return [
        (
            datetime.datetime.fromtimestamp(at, datetime.UTC),
            (float(wind_from), float(wind), None if math.isnan(air) else float(air)),
        )
        for at, wind_from, wind, air in zip(
            table['utc'], table['wind_from_deg'], table['wind_mps'], airs, strict=True
        )
    ]


INLAND_KM = 30.0
"""Distance inland beyond which a place is reported [km]. The maps err by less."""


def passage_facts(passage: LoggedPassage) -> dict[str, Any]:
    """Return a passage as JSON. Missing values are `None`."""
    from tauto_core.ship.coast import inland_km, no_landfall

    problems = [f'{item.key}: {item.problem}' for item in passage.problems()]
    sound = not problems
    notes = passage.notes() if sound else []
    inland = [inland_km(*entry[1:3]) for entry in passage.entries] if sound else []
    if rows := [index for index, km in enumerate(inland) if km > INLAND_KM]:
        where = ', '.join(f'{index + 1}' for index in rows[:5]) + ', …' * (len(rows) > 5)
        notes.append(f'more than {INLAND_KM:g} km inland: row{"s" * (len(rows) > 1)} {where}')
    if sound and (away := no_landfall(*passage.entries[-1][1:3])) is not None:
        notes.append(f'last entry {away}')
    return {
        'passage': passage.name,
        'ship': passage.ship,
        'nation': passage.nation,
        'from': passage.sailed_from,
        'to': passage.bound_to,
        'first_utc': passage.entries[0][0],
        'last_utc': passage.entries[-1][0],
        'days': passage.days if sound else None,
        'entries': len(passage.entries),
        'first_place': list(passage.entries[0][1:3]),
        'last_place': list(passage.entries[-1][1:3]),
        'wind_share': passage.share(4),
        'air_share': passage.share(5),
        'problems': problems,
        'notes': notes,
    }
