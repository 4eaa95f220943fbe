"""The data files of a scene: where they lie, and which may be read.

A path is either `shipped:<folder>/<file>`, data that come with the package, or a file of the
user. A shipped path means the same on every machine, so a bag may contain it.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

from tauto_core.scene.errors import Problem, UsageError

PREFIX = 'shipped:'
_DATA = Path(__file__).parent / 'data'

LARGEST_BYTES = 2**28
"""Largest data file that is read, 256 MiB: motion at 20 Hz for six days. Bags have no limit."""


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
    reason = why_unreadable(file, bag=folders)
    return [Problem(key, path, reason, 'Name another file.')] if reason else []


def why_unreadable(file: Path, *, bag: bool = False) -> str:
    """Return why a file is not to be opened as data; empty if it may be.

    Pipes and devices are refused by their kind, before they are opened: to open a pipe without a
    writer blocks, and a device such as /dev/zero has no end.

    Args:
        file: where it lies.
        bag: whether it is a bag, which may be a folder and of any size.
    """
    try:
        found = file.stat()
    except OSError as error:
        return f'cannot be read: {error.strerror}'
    if bag and stat.S_ISDIR(found.st_mode):
        return ''
    if not stat.S_ISREG(found.st_mode):
        return 'is not a regular file; pipes, devices and folders are not read'
    if found.st_size > LARGEST_BYTES and not bag:
        return f'has {found.st_size} bytes; a data file may have at most {LARGEST_BYTES}'
    return ''
