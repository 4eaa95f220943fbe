"""Compiled kernels on disk: in a folder that is the user's alone, each file whole or not there."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import stat
import tempfile
import warnings
from pathlib import Path
from typing import Any

from tauto_core.kernels.errors import KernelCacheWarning

VARIABLE = 'TAUTO_CACHE_DIR'
_REMEDY = (
    f'Set {VARIABLE} to a folder that only you may write. Until then each run compiles its '
    'kernels anew, which takes seconds.'
)
_NOT_PRIVATE = (
    'compiled kernels are neither kept in {} nor used from there: others may write there'
)
_warned: set[str] = set()


def folder() -> Path:
    """Return where compiled kernels are kept.

    Raises:
        RuntimeError: neither the environment nor the system gives this user a home folder.
    """
    given = os.environ.get(VARIABLE)
    if given:
        return Path(given).expanduser()
    home = os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache'
    return Path(home) / 'tauto'


def _warn(message: str) -> None:
    if message not in _warned:
        _warned.add(message)
        warnings.warn(f'{message}. {_REMEDY}', KernelCacheWarning, stacklevel=2)


def _is_private(place: Path) -> bool:
    """Return whether nobody else may have put something there: it will be run."""
    if not hasattr(os, 'getuid'):
        return True
    found = place.stat()
    return found.st_uid == os.getuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def read(name: str) -> tuple[dict[str, Any], bytes] | None:
    """Return what is kept under a name, and its object code; None if there is nothing whole."""
    try:
        place = folder()
        if not _is_private(place):
            _warn(_NOT_PRIVATE.format(place))
            return None
        whole = (place / name).read_bytes()
        seal, header, code = whole.split(b'\n', 2)
        if hashlib.sha256(header + b'\n' + code).hexdigest() != seal.decode():
            return None
        return json.loads(header), code
    except (OSError, ValueError, RuntimeError):
        return None


def write(name: str, header: dict[str, Any], code: bytes) -> None:
    """Keep object code under a name; two processes at once leave the one's or the other's."""
    try:
        place = folder()
    except RuntimeError:
        _warn('compiled kernels cannot be kept: this user has no home folder')
        return
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _is_private(place):
            _warn(_NOT_PRIVATE.format(place))
            return
        body = json.dumps(header).encode() + b'\n' + code
        seal = hashlib.sha256(body).hexdigest().encode()
        handle, draft = tempfile.mkstemp(dir=place, prefix='.draft')
        try:
            with os.fdopen(handle, 'wb') as file:
                file.write(seal + b'\n' + body)
            os.replace(draft, place / name)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(draft)
            raise
    except OSError as error:
        _warn(f'compiled kernels cannot be kept in {place}: {error.strerror or error}')
