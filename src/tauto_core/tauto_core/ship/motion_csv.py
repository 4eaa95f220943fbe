"""Columns of measured motion from a CSV file, with their units."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.scene.errors import MotionDataError

UNITS: dict[str, dict[str, float]] = {
    'time': {'_s': 1.0},
    'roll': {'_rad': 1.0, '_deg': math.pi / 180.0},
    'heave': {'_m': 1.0},
}


def read_columns(
    path: Path, name: str, columns: Mapping[str, str]
) -> tuple[list[int], dict[str, FloatArray]]:
    """Read columns of a CSV file whose first line names them; blank lines are skipped.

    Args:
        path: the file.
        name: name of the file as the user wrote it, for messages.
        columns: name of the column for each quantity of `UNITS`; its suffix gives the unit.

    Returns:
        The line number of each row, and each quantity in SI units and radians, shape (n,).

    Raises:
        MotionDataError: unreadable or empty file, column missing, named twice or of unknown unit,
            a row of another length, a cell that is not a finite number.
    """
    factors = {quantity: _factor(name, quantity, column) for quantity, column in columns.items()}
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            rows = _rows(name, file, columns)
            lines = [(line, cells) for line, cells in rows]
    except OSError as error:
        raise MotionDataError(
            f'{name}: cannot be read: {error.strerror}. Give a CSV file, or topic for a bag.'
        ) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise MotionDataError(
            f'{name}: is not a CSV text: {error}. Give a CSV file, or topic for a bag.'
        ) from error
    if not lines:
        raise MotionDataError(f'{name}: holds no rows below its header. Give a longer record.')
    table = np.array([cells for _, cells in lines])
    values = {
        quantity: np.ascontiguousarray(table[:, i]) * factor
        for i, (quantity, factor) in enumerate(factors.items())
    }
    return [line for line, _ in lines], values


def _factor(name: str, quantity: str, column: str) -> float:
    """Return the factor that converts a column to SI units and radians."""
    units = UNITS[quantity]
    for suffix, factor in units.items():
        if column.endswith(suffix):
            return factor
    raise MotionDataError(
        f'{name}: {quantity}_column {column!r} has no known unit; it must end in '
        f'{" or ".join(units)}. Rename the column.'
    )


def _rows(
    name: str, file: Iterator[str], columns: Mapping[str, str]
) -> Iterator[tuple[int, list[float]]]:
    """Yield line number and wanted cells of each row."""
    reader = csv.reader(file)
    header = [cell.strip() for cell in next(reader, [])]
    if not header:
        raise MotionDataError(f'{name}: is empty. Give a CSV file with a header line.')
    places = {column: _place(name, header, column) for column in columns.values()}
    for row in reader:
        if not row:
            continue
        if len(row) != len(header):
            raise MotionDataError(
                f'{name}, line {reader.line_num}: has {len(row)} cells, the header '
                f'{len(header)}. Correct or drop the row.'
            )
        where = f'{name}, line {reader.line_num}'
        yield (
            reader.line_num,
            [_number(where, column, row[place]) for column, place in places.items()],
        )


def _place(name: str, header: list[str], column: str) -> int:
    """Return the index of a column."""
    if header.count(column) != 1:
        what = 'names more than one' if column in header else 'has no'
        raise MotionDataError(
            f'{name}: {what} column {column!r}; its columns are {", ".join(header)}. '
            'Name one of them.'
        )
    return header.index(column)


def _number(where: str, column: str, cell: str) -> float:
    """Return a cell as a finite number."""
    try:
        # Python reads 1_0 as 10
        number = math.nan if '_' in cell else float(cell)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise MotionDataError(
            f'{where}: {column} = {cell!r} is not a finite number. Correct or drop the row; '
            'gaps up to max_gap are interpolated.'
        )
    return number
