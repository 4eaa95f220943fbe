"""The data files of a scene: where they lie, and columns of numbers from them.

A path is either `shipped:<folder>/<file>`, data that come with the package, or a file of the
user. A shipped path means the same on every machine, so a bag may contain it.
"""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tauto_core.scene.errors import ABSENT, Problem, SceneError, UsageError

PREFIX = 'shipped:'
_DATA = Path(__file__).parent / 'data'


def is_shipped(path: str) -> bool:
    """Return whether a path names data that come with the package."""
    return path.startswith(PREFIX)


def shipped_data() -> list[str]:
    """Return the shipped paths of all data files that come with the package."""
    return sorted(PREFIX + file.relative_to(_DATA).as_posix() for file in _DATA.rglob('*.csv'))


def data_path(path: str) -> Path:
    """Return the location of a scene's data file, whether it exists or not.

    Args:
        path: `shipped:<folder>/<file>`, or a path of the file system.

    Raises:
        UsageError: a shipped path that leads out of the shipped data.
    """
    if not is_shipped(path):
        return Path(path)
    name = Path(path.removeprefix(PREFIX))
    if name.is_absolute() or '..' in name.parts:
        raise UsageError(
            f'{path}: must stay within the shipped data. Use one of {", ".join(shipped_data())}.'
        )
    return _DATA / name


def source_name(path: str) -> str:
    """Return the name by which a scene refers to a file whose contents it contains.

    A shipped path stays as it is; of another path the folder is left out.
    """
    return path if is_shipped(path) else Path(path).name


def missing_file(key: str, path: str, *, folders: bool = False) -> list[Problem]:
    """Return why a file of a scene cannot be read: one problem, or none.

    Args:
        key: the key of the scene that names the file.
        path: the path as the scene has it.
        folders: whether a folder (a bag) is allowed.
    """
    shipped = f'Shipped data: {", ".join(shipped_data())}.'
    try:
        file = data_path(path)
    except UsageError:
        return [Problem(key, path, 'must stay within the shipped data', shipped)]
    remedy = (
        shipped if is_shipped(path) else "Give a path from the scene's folder, or an absolute."
    )
    try:
        file.stat()
    except (FileNotFoundError, NotADirectoryError):
        return [Problem(key, path, 'there is no such file', remedy)]
    except (OSError, ValueError) as error:
        said = f'cannot be read: {getattr(error, "strerror", None) or error}'
        return [Problem(key, path, said, remedy)]
    if file.is_dir() and not folders:
        bag = '; for a bag give ship.recorded.topic' if key == 'ship.recorded.path' else ''
        remedy = f'Name the CSV file in it{bag}.'
        return [Problem(key, path, 'is a folder', remedy)]
    if not os.access(file, os.R_OK):
        return [Problem(key, path, 'cannot be read: no permission', 'Make it readable.')]
    return []


# -----------------------------------------------------------------------------
# Columns of numbers from a CSV file that belongs to a scene, with the line of each row.


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
