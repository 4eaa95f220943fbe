"""Where the data files of a scene are.

A path is either `shipped:<folder>/<file>`, data that come with the package, or a file of the
user's own. A shipped path means the same on every machine, so a bag can carry it.
"""

from __future__ import annotations

from pathlib import Path

from tauto_core.scene.errors import UsageError

PREFIX = 'shipped:'
_DATA = Path(__file__).parent / 'data'


def is_shipped(path: str) -> bool:
    """Return whether a path names data that come with the package."""
    return path.startswith(PREFIX)


def shipped_data() -> list[str]:
    """Return the shipped paths of all data files that come with the package."""
    return sorted(PREFIX + file.relative_to(_DATA).as_posix() for file in _DATA.rglob('*.csv'))


def data_path(path: str) -> Path:
    """Return where the file of a scene is, whether it exists or not.

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
