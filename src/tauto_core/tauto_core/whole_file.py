"""Files that are written completely or not at all."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from tauto_core.scene.errors import UsageError


def check_place(path: Path, option: str) -> None:
    """Refuse, before anything runs, a place where no file can be written.

    Args:
        path: the file.
        option: the option that named it.

    Raises:
        UsageError: a folder, or in a folder that does not exist or cannot be written.
    """
    if path.is_dir():
        raise UsageError(f'{option} {path}: is a folder. Name a file')
    if not path.parent.is_dir():
        raise UsageError(f'{option} {path}: there is no folder {path.parent}. Make it first')
    if not os.access(path.parent, os.W_OK):
        raise UsageError(
            f'{option} {path}: the folder {path.parent} cannot be written. Name another file'
        )


def write_whole(path: Path, content: bytes) -> None:
    """Write a file, or replace it; if that fails, what was there before remains.

    Args:
        path: the file; a link is followed, and what is no regular file (`/dev/stdout`) receives
            the content directly.
        content: what it will hold.

    Raises:
        OSError: it cannot be written.
    """
    if path.exists() and not path.is_file():
        path.write_bytes(content)
        return
    place = path.resolve()
    draft = place.with_name(f'.{os.getpid()}.{place.name}')
    try:
        draft.write_bytes(content)
        draft.replace(place)
    except OSError:
        with suppress(OSError):
            draft.unlink()
        raise
