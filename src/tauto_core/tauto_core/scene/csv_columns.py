"""Columns of numbers from a CSV file that belongs to a scene, with the line of each row."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass

from tauto_core.scene.data import data_path
from tauto_core.scene.errors import ABSENT, SceneError


@dataclass(frozen=True)
class Columns:
    """The content of a CSV file.

    Attributes:
        name: name of the file as the user wrote it.
        lines: line number of each row.
        values: the finite numbers of each column, as many as there are lines.
    """

    name: str
    lines: list[int]
    values: dict[str, list[float]]


def read_columns(
    path: str, required: Sequence[str], optional: Sequence[str] = (), *, remedy: str
) -> Columns:
    """Read columns of a CSV file whose first line names them; blank lines are skipped.

    Args:
        path: `shipped:<folder>/<file>`, or a path of the file system.
        required: names of columns that must be present.
        optional: names of columns that are read if they are present.
        remedy: advice for a file that is not of this form.

    Raises:
        SceneError: unreadable or empty file, a column missing or named twice, a row of another
            length, a cell that is not a finite number; with the line.
    """
    try:
        text = data_path(path).read_text(encoding='utf-8-sig')
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(path, '', None, f'cannot be read as text: {error}', remedy) from error
    rows = csv.reader(text.splitlines())
    header = [cell.strip() for cell in next(rows, [])]
    for column in (*required, *(each for each in optional if each in header)):
        if header.count(column) != 1:
            what = 'is named more than once' if column in header else 'is missing'
            raise SceneError(path, f'line 1, column {column}', ABSENT, what, remedy)
    wanted = {each: header.index(each) for each in (*required, *optional) if each in header}
    lines: list[int] = []
    values: dict[str, list[float]] = {column: [] for column in wanted}
    for cells in rows:
        if not ''.join(cells).strip():
            continue
        line = rows.line_num
        if len(cells) != len(header):
            problem = f'has {len(cells)} cells, the header {len(header)}'
            raise SceneError(path, f'line {line}', ABSENT, problem, 'Correct or drop the row.')
        lines.append(line)
        for column, place in wanted.items():
            values[column].append(_number(path, f'line {line}, {column}', cells[place]))
    if not lines:
        raise SceneError(path, '', ABSENT, 'holds no rows below its header', remedy)
    return Columns(path, lines, values)


def _number(path: str, where: str, cell: str) -> float:
    try:
        # Python reads 1_0 as 10
        number = math.nan if '_' in cell else float(cell)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise SceneError(path, where, cell, 'is not a finite number', 'Correct or drop the row.')
    return number
