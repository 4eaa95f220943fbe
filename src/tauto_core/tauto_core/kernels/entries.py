"""Kernels that are called from Python: compiled at the first call for arguments of a structure.

LLVM's optimisation is most of the time that compiling takes, and a run of minutes never earns it
back. So an entry is compiled without it first, and again, optimised, when it has run for a while.
What was compiled is kept on disk.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import json
import os
import stat
import tempfile
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from tauto_core.kernels.arguments import (
    ENTRY,
    check_arrays,
    in_words,
    packer,
    plain,
    structure_of,
    unpacker,
)
from tauto_core.kernels.marks import KernelCacheWarning, KernelError, compiling
from tauto_core.kernels.source import digest, is_as_it_was

# -----------------------------------------------------------------------------
# Compiled kernels on disk: in a folder that is the user's alone, each file whole or not there.

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


_LOCK = threading.RLock()
"""LLVM is used by one thread at a time."""

OPTIMISED_AFTER_S = 0.25
"""Time that quick code of an entry runs in a process [s] until optimised code takes its place.

Quick code takes up to half as long again, so that no run loses more than a tenth of a second.
"""

_no_hurry: list[None] = []
"""As many as there are `optimised` around."""


@contextmanager
def optimised() -> Iterator[None]:
    """Let entries that are called, or prepared, be optimised at once: where nothing may stall."""
    _no_hurry.append(None)
    try:
        yield
    finally:
        _no_hurry.pop()


@cache
def _stamp() -> str:
    """Return processor and versions, on which compiled code depends beside its sources."""
    from tauto_core.kernels.program import versions

    return '\n'.join(versions())


@cache
def _compiler() -> dict[str, str]:
    """Return the files of this compiler with their hashes."""
    return {str(path): digest(str(path)) for path in sorted(Path(__file__).parent.glob('*.py'))}


class Entry:
    """A kernel that can be called from Python; the interpreter's lock is free while it runs.

    Attributes:
        python: the function itself, as Python runs it.
    """

    def __init__(self, function: Any) -> None:
        self.python = function
        self.__name__, self.__qualname__ = function.__name__, function.__qualname__
        self.__doc__, self.__module__ = function.__doc__, function.__module__
        self._made: list[tuple[Any, ...]] = []

    def __call__(self, *args: Any) -> Any:
        for _ in range(2):
            for pack, call, results, unpack in self._made:
                packed = pack(*args)
                if packed is not None:
                    back = results()
                    if call(packed, back):
                        raise self._unfit(args)
                    return unpack(back)
            self.prepare(*args)
            args = plain(args)
        raise KernelError(f'{self.__qualname__}: arguments change while it is called')

    def _unfit(self, args: tuple[Any, ...]) -> KernelError:
        names = self.python.__code__.co_varnames
        unfit = [name for name, x in zip(names, args, strict=False) if not _fits(x)]
        return KernelError(
            f'{self.__qualname__}: {", ".join(unfit)} is or holds an array that is not '
            'C-contiguous and aligned. Use np.ascontiguousarray'
        )

    def prepare(self, *args: Any) -> None:
        """Compile or load the code that a call with such arguments needs.

        Raises:
            KernelError: the kernel, or the arguments, cannot be compiled.
        """
        structures = [structure_of(arg) for arg in args]
        with _LOCK:
            pack = packer(structures, self.__name__.replace('<lambda>', 'function'))
            if any(old(*plain(args)) is not None for old, *_ in self._made):
                return
            check_arrays()
            from tauto_core.kernels.program import Effort

            efforts = [Effort.OPTIMISED] if _no_hurry else [Effort.OPTIMISED, Effort.QUICK]
            layout, call, effort = self._compiled(structures, efforts)
            if effort is Effort.QUICK:
                call = self._timed(call, structures)
            words, unpack = unpacker(layout)
            self._made = [(pack, call, ctypes.c_int64 * words, unpack), *self._made]

    def _timed(self, quick: Any, structures: list[Any]) -> Any:
        """Return quick code that gives way to optimised code when it has run for a while."""
        from tauto_core.kernels.program import Effort

        ran_s, best = 0.0, None

        def call(packed: bytes, back: Any) -> Any:
            nonlocal ran_s, best
            if best is None and (_no_hurry or ran_s > OPTIMISED_AFTER_S):
                with _LOCK:
                    best = best or self._compiled(structures, [Effort.OPTIMISED])[1]
            if best is not None:
                return best(packed, back)
            began = time.thread_time()
            failed = quick(packed, back)
            ran_s += time.thread_time() - began
            return failed

        return call

    def _compiled(self, structures: list[Any], efforts: list[Any]) -> tuple[Any, Any, Any]:
        """Return the layout of the result, the entry in memory, and with which effort it is made.

        What is kept of the first effort is taken, else of the next; else the last is made.
        """
        from tauto_core.kernels.program import loaded

        for effort in efforts:
            file, name = self._file_and_name(structures, effort)
            kept = read(file)
            if kept is not None and is_as_it_was(kept[0]['files'], kept[0]['names']):
                return kept[0]['result'], loaded(kept[1], name), effort
        layout, code = self._translated(structures, efforts[-1])
        return layout, loaded(code, name), effort

    def _file_and_name(self, structures: list[Any], effort: Any) -> tuple[str, str]:
        """Return the file in which code is kept, and the name of the entry in it."""
        identity = '\n'.join(
            [
                self.python.__code__.co_filename,
                f'{self.python.__module__}.{self.python.__qualname__}',
                *(in_words(structure) for structure in structures),
                effort.name,
                _stamp(),
            ]
        )
        tag = hashlib.sha256(identity.encode()).hexdigest()[:32]
        return f'{self.python.__name__}.{tag}', f'{ENTRY}_{tag}'

    def _translated(self, structures: list[Any], effort: Any) -> tuple[Any, bytes]:
        """Compile, and keep it; return the layout of the result and object code."""
        from tauto_core.kernels.program import Program, object_code, processor

        function, (file, name) = self.python, self._file_and_name(structures, effort)
        with compiling(f'{function.__module__}.{function.__qualname__}') as translated:
            program = Program(function, structures, name)
            text = str(program.module)
            translated(text.count('\n') / effort.lines_per_s)
            code = object_code(text, processor(), effort)
        used = program.used
        header = {'files': _compiler() | used.files, 'names': used.names, 'result': program.result}
        write(file, header, code)
        return program.result, code


def _fits(x: Any) -> bool:
    if isinstance(x, tuple):
        return all(_fits(item) for item in x)
    flags = getattr(x, 'flags', None)
    return flags is None or bool(flags.c_contiguous and flags.aligned)


def entry(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function for calls from Python, see `Entry`."""
    return Entry(function)
