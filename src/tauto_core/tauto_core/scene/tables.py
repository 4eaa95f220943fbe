"""The data files of a scene: their paths, and their tables with line numbers.

The first line of a file names its columns. Other columns are ignored. Files are
CSV or separated by blanks. Reading takes 8 bytes per number.

    table = read_table(
        path,
        (
            Column('time_s', unit='s', rising='later than the time before'),
            Column('air_degc', unit='°C', least=-60.0, most=60.0),
            Column('wind_mps', optional=True, gaps='nan'),
        ),
        remedy='Give a CSV file with the columns time_s and air_degc.',
    )
    table['air_degc']  # array (n,)
    raise table.refusal(7, 'air_degc', 'is warmer than the sea', 'Correct it.')
"""

from __future__ import annotations

import csv
import errno
import math
import os
import re
import stat
from array import array
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from itertools import chain
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene import times
from tauto_core.scene.errors import ABSENT, Problem, SceneError, UsageError

# -----------------------------------------------------------------------------
# Paths of data files, and which files may be read.
#
# `shipped:<folder>/<file>` names data of the package, the same on every machine. Bags may contain
# such paths.

PREFIX = 'shipped:'
_DATA = Path(__file__).parent / 'data'

LARGEST_BYTES = 2**28
"""Largest data file: 256 MiB, six days of motion at 20 Hz. Bags have no limit."""


def is_shipped(path: str) -> bool:
    """Return whether a path names data of the package."""
    return path.startswith(PREFIX)


def shipped_data() -> list[str]:
    """Return the built-in paths of all data files of the package."""
    return sorted(PREFIX + file.relative_to(_DATA).as_posix() for file in _DATA.rglob('*.csv'))


def data_path(path: str) -> Path:
    """Return the location of a scene's data file, whether it exists or not.

    UsageError if a built-in path leads out of the built-in data.
    """
    if not is_shipped(path):
        return Path(path)
    name = Path(path.removeprefix(PREFIX))
    if name.is_absolute() or '..' in name.parts:
        raise UsageError(
            f'{path}: must stay within the built-in data. Use one of {", ".join(shipped_data())}.'
        )
    return _DATA / name


def source_name(path: str) -> str:
    """Return a built-in path, or the name of another file without its folder."""
    return path if is_shipped(path) else Path(path).name


def missing_file(
    key: str, path: str, *, folders: bool = False, any_size: bool = False
) -> list[Problem]:
    """Return the problem, if any, that prevents reading the file named by a key of a scene.

    `folders` allows a folder (a bag), `any_size` a file of any size.
    """
    problem, remedy = '', "Give a path from the scene's folder, or an absolute one."
    if is_shipped(path):
        remedy = f'Built-in data: {", ".join(shipped_data())}.'
    try:
        file = data_path(path)
        file.stat()
    except UsageError:
        problem = 'must stay within the built-in data'
    except (FileNotFoundError, NotADirectoryError):
        problem = 'there is no such file'
    except (OSError, ValueError) as error:
        problem = f'cannot be read: {getattr(error, "strerror", None) or error}'
    else:
        if file.is_dir() and not folders:
            bag = '; for a bag give ship.recorded.topic' if key == 'ship.recorded.path' else ''
            problem, remedy = 'is a folder', f'Name the file in it{bag}.'
        elif not os.access(file, os.R_OK):
            problem, remedy = 'cannot be read: no permission', 'Make it readable.'
        else:
            problem = why_unreadable(file, bag=folders or any_size)
            remedy = 'Name another file.'
    return [Problem(key, path, problem, remedy)] if problem else []


def why_unreadable(file: Path, *, bag: bool = False) -> str:
    """Return why a file must not be opened as data, or ''. A `bag` may be a folder, of any size.

    Opening a pipe without a writer blocks, and a device such as /dev/zero has no end.
    """
    try:
        status = file.stat()
    except OSError as error:
        return f'cannot be read: {error.strerror}'
    if bag and stat.S_ISDIR(status.st_mode):
        return ''
    if not stat.S_ISREG(status.st_mode):
        return 'is not a regular file (pipes, devices and folders are not read)'
    if status.st_size > LARGEST_BYTES and not bag:
        return f'has {status.st_size} bytes; a data file may have at most {LARGEST_BYTES}'
    return ''


def read_data(file: Path, limit: int = LARGEST_BYTES) -> bytes:
    """Return the content of a regular file of at most `limit` bytes, or raise OSError.

    The limit also holds for files that grow, or state no size (`/proc`).
    """
    if stat.S_ISDIR(file.stat().st_mode):
        raise IsADirectoryError(errno.EISDIR, 'it is a folder')
    if reason := why_unreadable(file):
        raise OSError(errno.EINVAL, reason)
    with file.open('rb') as stream:
        content = stream.read(limit + 1)
    if len(content) > limit:
        raise OSError(errno.EFBIG, f'it has more than {limit} bytes')
    return content


# a word that may name a column
_NAME = re.compile(r'[^\W\d][\w .%°/()-]{0,31}')


def header_words(cells: Sequence[str]) -> str:
    """Return the names in a header, for a message, but no other text, which may be
    confidential."""
    if not all(_NAME.fullmatch(cell) for cell in cells):
        return 'no names'
    return ', '.join(cells[:12]) + ', …' * (len(cells) > 12) or 'none'


def words_of(error: Exception) -> str:
    """Return the first words of a library's error, without its quotations of a file."""
    words = re.split('[\'"`\\n]', str(error))[0].strip()
    return f'{type(error).__name__}: {words}' if words else type(error).__name__


# -----------------------------------------------------------------------------
# Columns of numbers.

MISSING = frozenset({'', 'MM', 'nan', 'NaN', 'NA'})
"""Cells without a measurement, in columns with gaps."""

CORRECT = 'Correct or drop the row.'

TIME_UNITS = {'_s': 1.0}
ANGLE_UNITS = {'_rad': 1.0, '_deg': math.pi / 180.0}
LENGTH_UNITS = {'_m': 1.0}
"""Factors to SI units and radians by the suffix of the column's name."""
WIDER = 1.5
"""A step longer than this many median steps is a gap."""


@dataclass(frozen=True)
class Column:
    """A column to be read, with conditions on its numbers.

    Attributes:
        name: its heading.
        optional: whether the file may lack it.
        utc: whether cells are dates and times, such as 2000-01-01T02:00, read as seconds since
            1970.
        gaps: effect of a cell without a number (`MISSING`): 'refuse' the file, 'skip' the row, or
            read 'nan'.
        factor: converts the unit of the numbers.
        unit: unit after the conversion, for messages.
        above: exclusive lower limit.
        least: inclusive lower limit.
        most: inclusive upper limit.
        why: reason for the limits, for messages.
        rising: if not empty, numbers must increase, in words such as 'later than the time before'.
        remedy: advice for a number that is refused.
    """

    name: str
    optional: bool = False
    utc: bool = False
    gaps: Literal['refuse', 'skip', 'nan'] = 'refuse'
    factor: float = 1.0
    unit: str = ''
    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf
    why: str = ''
    rising: str = ''
    remedy: str = CORRECT

    def number(self, file: str, line: int, cell: str) -> float:
        """Return the number in a cell, NaN for a missing value, or raise SceneError."""
        where = f'line {line}, {self.name}'
        if self.gaps != 'refuse' and cell.strip() in MISSING:
            return math.nan
        if self.utc:
            return utc(file, where, cell.strip()).timestamp()
        try:
            number = times.number_in(cell)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise SceneError(file, where, cell, 'is not a finite number', self.remedy)
        return self.factor * number


@dataclass(frozen=True)
class Columns:
    """Columns of numbers, and the place of each row for messages.

    Attributes:
        name: name of the file as the user wrote it.
        values: the numbers of each column, arrays of shape (n,).
        places: place of each row, (n,), such as its line.
        kind: the word before a place, `line` or for a bag `message`.
    """

    name: str
    values: Mapping[str, FloatArray]
    places: IntArray | Sequence[object]
    kind: str = 'line'

    def __len__(self) -> int:
        return len(self.places)

    def __contains__(self, column: str) -> bool:
        return column in self.values

    def __getitem__(self, column: str) -> FloatArray:
        return self.values[column]

    def rows(self, which: IntArray | NDArray[np.bool_]) -> Columns:
        """Return rows by their numbers or a mask, with their places."""
        values = {column: numbers[which] for column, numbers in self.values.items()}
        return Columns(self.name, values, np.asarray(self.places)[which], self.kind)

    def where(self, row: int) -> str:
        """Return the place of a row, such as `line 12`."""
        return f'{self.kind} {self.places[row]}'

    def refusal(self, row: int, column: str, problem: str, remedy: str = CORRECT) -> SceneError:
        """Return the error with file, place, column ('': whole row) and number."""
        value = float(self[column][row]) if column else ABSENT
        where = ', '.join(filter(None, (self.where(row), column)))
        return SceneError(self.name, where, value, problem, remedy)

    def check(self, *columns: Column) -> None:
        """Raise SceneError for the first number out of range or order. NaN is allowed."""
        for column in columns:
            values, unit = self[column.name], f' {column.unit}' if column.unit else ''
            limits = (
                (column.above, values <= column.above, 'greater than'),
                (column.least, values < column.least, 'at least'),
                (column.most, values > column.most, 'at most'),
            )
            wrong = np.flatnonzero(np.logical_or.reduce([mask for _, mask, _ in limits]))
            if wrong.size:
                words = [f'{word} {limit:g}' for limit, _, word in limits if math.isfinite(limit)]
                problem = f'must be {" and ".join(words)}{unit}'
                problem += f': {column.why}' if column.why else ''
                raise self.refusal(int(wrong[0]), column.name, problem, column.remedy)
            wrong = np.flatnonzero(values[1:] <= values[:-1]) if column.rising else wrong
            if wrong.size:
                previous = float(values[wrong[0]])
                problem = f'must be {column.rising}, {previous!r}{unit}'
                raise self.refusal(int(wrong[0]) + 1, column.name, problem, column.remedy)

    def gaps(
        self, column: str, longest: float, *, after: str = 'row', limit: str, remedy: str
    ) -> int:
        """Return the number of gaps, steps above `WIDER` medians, in a column of times.

        SceneError for a step of 0 or less, or longer than `longest` [s], the value of the key
        `limit`. `after` is the word for the previous row.
        """
        steps = np.diff(self[column])
        for row, step in enumerate(steps.tolist(), start=1):
            if step <= 0.0:
                raise self.refusal(row, '', 'has the time of another row', 'Drop one of them.')
            if step > longest:
                problem = f'comes {step:g} s after the last {after}; {limit} is {longest!r} s'
                raise self.refusal(row, '', problem, remedy)
        usual = np.sort(steps)[len(steps) // 2] if len(steps) else 0.0
        return int(np.count_nonzero(steps > WIDER * usual))


def read_table(path: str, columns: Sequence[Column], *, remedy: str) -> Columns:
    """Read columns of numbers, skipping blank lines.

    If a gap skips a row, its other cells are not checked.

    Args:
        path: `shipped:<folder>/<file>`, or a path of the file system.
        columns: the columns, with their limits.
        remedy: advice for a file that is not of this form.

    Raises:
        SceneError: with the line: no regular file, too large, unreadable or empty, a column
            missing or named twice, a row of another length, a cell without a finite number, a
            number out of range or order.
    """
    with _opened(path, remedy) as rows:
        _, header = next(rows, (1, []))
        wanted: list[tuple[Column, int, array[float]]] = []
        for column in columns:
            if header.count(column.name) > 1 or not (column.optional or column.name in header):
                what = 'is named more than once' if column.name in header else 'is missing'
                problem = f'{what}; the columns are {header_words(header)}'
                raise SceneError(path, f'line 1, column {column.name}', ABSENT, problem, remedy)
            if column.name in header:
                wanted.append((column, header.index(column.name), array('d')))
        wanted.sort(key=lambda item: item[0].gaps != 'skip')
        places = array('q')
        for line, cells in rows:
            if not ''.join(cells).strip():
                continue
            if len(cells) != len(header):
                problem = f'has {len(cells)} cells, the header {len(header)}'
                raise SceneError(path, f'line {line}', ABSENT, problem, CORRECT)
            row = []
            for column, place, _ in wanted:
                number = column.number(path, line, cells[place])
                if column.gaps == 'skip' and math.isnan(number):
                    break
                row.append(number)
            else:
                places.append(line)
                for (_, _, numbers), number in zip(wanted, row, strict=True):
                    numbers.append(number)
    if not places and not any(column.gaps == 'skip' for column in columns):
        raise SceneError(path, '', ABSENT, 'holds no rows below its header', remedy)
    values = {column.name: np.array(numbers) for column, _, numbers in wanted}
    table = Columns(path, values, np.array(places, np.int64))
    table.check(*(column for column in columns if column.name in table))
    return table


def read_header(path: str, *, remedy: str) -> list[str]:
    """Return the names of all columns of a file, with arguments and errors of `read_table`."""
    with _opened(path, remedy) as rows:
        return next(rows, (1, []))[1]


@contextmanager
def _opened(path: str, remedy: str) -> Iterator[Iterator[tuple[int, list[str]]]]:
    """Open a file and yield number and cells of each line, first the header."""
    file = data_path(path)
    reason = why_unreadable(file)
    if reason:
        raise SceneError(path, '', None, reason, remedy)
    try:
        with file.open(encoding='utf-8-sig') as lines:
            reader = csv.reader(lines)
            header = [name.strip() for name in next(reader, [])]
            yield chain([(1, header)], ((reader.line_num, cells) for cells in reader))
    except OSError as error:
        problem = f'cannot be read: {error.strerror}'
        raise SceneError(path, '', None, problem, remedy) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise SceneError(path, '', None, f'cannot be read as text: {error}', remedy) from error


def unit_factor(file: str, key: str, column: str, units: Mapping[str, float]) -> float:
    """Return the factor to SI units and radians by the suffix of a column's name.

    SceneError at `key` for a suffix that is not in `units`, such as `ANGLE_UNITS`.
    """
    for suffix, factor in units.items():
        if column.endswith(suffix):
            return factor
    problem = f'has no known unit; it must end in {" or ".join(units)}'
    raise SceneError(file, key, column, problem, 'Rename the column.')


def utc(file: str, key: str, text: str) -> datetime:
    """Return a date and time in UTC, or raise SceneError with file and key."""
    try:
        return times.utc_in(text)
    except ValueError as error:
        remedy = 'Write it as 2000-01-01T02:00, in UTC.'
        raise SceneError(file, key, text, str(error), remedy) from None
