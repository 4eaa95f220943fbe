"""Kernels that Python calls, compiled at the first call for each structure of arguments.

LLVM's optimisation takes most of the compile time, which a run of minutes does not earn back. An
entry is first compiled without it, and optimised once it has run for a while. Compiled code is
kept on disk.
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import hashlib
import json
import os
import stat
import struct
import tempfile
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tauto_core.kernels.marks import (
    DATA,
    DIMENSIONS,
    FLAGS,
    ArrayStructure,
    KernelCacheWarning,
    KernelError,
    Tuple,
    compiling,
    digest,
    is_unchanged,
)

# -----------------------------------------------------------------------------
# The calling convention between Python and kernels: words of eight bytes, one per number.
#
# An argument's structure is a tree: the name of a number's kind, `None`, `ArrayStructure`, or a
# `Tuple`. A function generated from the structure packs such arguments fast, and detects any other
# structure. An array is packed as the address of its object, from which compiled code reads the
# address of its numbers.

ENTRY = 'entry'
"""Name of an entry in its object code."""

WORD_FORMATS = {'float': 'd', 'int': 'q', 'uint64': 'Q', 'bool': 'q'}
# class tests, since `isinstance` would take a bool for an int. np.float64 is a float to both
_TESTS = {
    'float': 'not isinstance({0}, float)',
    'int': '{0}.__class__ is not int and {0}.__class__ is not int64',
    'uint64': '{0}.__class__ is not uint64',
    'bool': '{0}.__class__ is not bool and {0}.__class__ is not bool_',
}
_KINDS = (
    ((bool, np.bool_), 'bool'),
    (float, 'float'),
    ((int, np.int64), 'int'),
    (np.uint64, 'uint64'),
)
_DTYPES = {name: np.dtype(name) for name in ('f8', 'i8', 'u8', 'b1')}


def structure_of(x: Any) -> Any:
    """Return the structure of an argument, or raise a KernelError for an unsupported one."""
    if x is None:
        return None
    for classes, name in _KINDS:
        if isinstance(x, classes):
            return name
    if isinstance(x, tuple):
        named = type(x) if hasattr(x, '_fields') else None
        return Tuple(named, tuple(structure_of(item) for item in x))
    if isinstance(x, np.ndarray):
        if x.dtype.fields is None and x.dtype.str[1:] not in _DTYPES:
            raise KernelError(f'kernels take no arrays of {x.dtype}')
        return ArrayStructure(_dtype(x), x.ndim)
    raise KernelError(f'kernels take no {type(x).__name__}: {x!r}')


def _dtype(x: Any) -> Any:
    return x.dtype if x.dtype.fields is not None else _DTYPES[x.dtype.str[1:]]


def plain_arguments(x: Any) -> Any:
    """Return an argument with plain arrays, whose dtypes are NumPy's own objects."""
    if isinstance(x, tuple):
        items = [plain_arguments(item) for item in x]
        return type(x)(*items) if hasattr(x, '_fields') else tuple(items)
    return np.asarray(x).view(_dtype(x)) if isinstance(x, np.ndarray) else x


def spelled_out(structure: Any) -> str:
    """Return a structure as text that is the same in every run."""
    if isinstance(structure, Tuple):
        named = structure.named
        name = f'{named.__module__}.{named.__qualname__}{named._fields}' if named else ''
        return f'{name}({", ".join(spelled_out(item) for item in structure.items)})'
    if isinstance(structure, ArrayStructure):
        return f'{structure.dtype.descr}[{structure.ndim}]'
    return str(structure)


def packer(structures: list[Any], kernel: str) -> Callable[..., bytes | None]:
    """Return a function that packs arguments, or returns `None` for another structure.

    It bears the kernel's name, which Python's error for a wrong number of arguments shows.
    """
    names = [f'a{i}' for i in range(len(structures))]
    lines, words = [f'def {kernel}({", ".join(names)}):'], list[tuple[str, str]]()
    env: dict[str, Any] = {
        'ndarray': np.ndarray,
        'int64': np.int64,
        'uint64': np.uint64,
        'bool_': np.bool_,
    }

    def refuse(test: str) -> None:
        lines.append(f' if {test}: return None')

    def take(name: str, structure: Any) -> None:
        if structure is None:
            refuse(f'{name} is not None')
        elif isinstance(structure, Tuple):
            items = structure.items
            env[f'T{name}'] = structure.named or tuple
            refuse(f'{name}.__class__ is not T{name} or len({name}) != {len(items)}')
            fields = [f'{name}_{i}' for i in range(len(items))]
            if fields:
                lines.append(f' {", ".join(fields)}, = {name}')
            for field, item in zip(fields, items, strict=True):
                take(field, item)
        elif isinstance(structure, ArrayStructure):
            env[f'D{name}'] = structure.dtype
            test = '!=' if structure.dtype.fields is not None else 'is not'
            refuse(f'{name}.__class__ is not ndarray or {name}.dtype {test} D{name}')
            refuse(f'{name}.ndim != {structure.ndim}')
            words.append((f'id({name})', 'q'))
        else:
            refuse(_TESTS[structure].format(name))
            word = f'bool({name})' if structure == 'bool' else name
            words.append((word, WORD_FORMATS[structure]))

    for name, structure in zip(names, structures, strict=True):
        take(name, structure)
    env['pack'] = struct.Struct(''.join(form for _, form in words)).pack
    lines.append(f' return pack({", ".join(word for word, _ in words)})')
    exec('\n'.join(lines), env)
    pack: Callable[..., bytes | None] = env[kernel]
    return pack


@cache
def check_arrays() -> None:
    """Raise a KernelError unless NumPy's arrays are laid out as compiled code reads them."""
    array = np.arange(6.0).reshape(2, 3)
    begin = id(array) + object.__basicsize__
    data = ctypes.c_void_p.from_address(begin + DATA).value
    shape = ctypes.POINTER(ctypes.c_ssize_t).from_address(begin + DIMENSIONS)
    flags = ctypes.c_int.from_address(begin + FLAGS).value
    # contiguous, aligned and writeable are below 0x1000. NumPy marks arrays by higher bits, too
    if (
        data != array.ctypes.data
        or shape[:2] != [2, 3]
        or flags & 0xFFF != array.flags.num & 0xFFF
    ):
        raise KernelError(
            f'NumPy {np.__version__} lays its arrays out in another way than kernels read them. '
            'Use NumPy 1.26 to 2.4'
        )


def unpacker(layout: Any) -> tuple[int, Callable[[Any], Any]]:
    """Return the number of words of a result, and a function that makes the result from them.

    A layout is the name of a number's kind, `None`, a list, or a dict for an array.
    """
    words, formats = 0, []
    env: dict[str, Any] = {'array': _array}

    def made(part: Any) -> str:
        nonlocal words
        if part is None:
            return 'None'
        if isinstance(part, list):
            return f'({"".join(f"{made(item)}, " for item in part)})'
        begin = words
        if isinstance(part, dict):
            words += 1 + part['ndim']
            formats.append('q' * (1 + part['ndim']))
            return f'array({part["array"]!r}, w[{begin}:{words}])'
        words += 1
        formats.append(WORD_FORMATS[part])
        return f'w[{begin}] != 0' if part == 'bool' else f'w[{begin}]'

    text = made(layout)
    env['unpack'] = struct.Struct(''.join(formats)).unpack
    exec(f'def unpacked(back):\n w = unpack(back)\n return {text}', env)
    return words, env['unpacked']


_LIBC = ctypes.CDLL(None)
_LIBC.free.restype = None


def _array(kind: str, words: tuple[int, ...]) -> Any:
    """Return an array that a kernel has made, and free its memory."""
    dtype = {'float': 'f8', 'int': 'i8', 'uint64': 'u8', 'bool': 'b1'}[kind]
    data, shape = words[0], words[1:]
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    copy = np.frombuffer(bytearray(ctypes.string_at(data, size)), dtype).reshape(shape)
    # the word before the aligned numbers is the address from malloc
    _LIBC.free(ctypes.c_void_p.from_address(data - 8))
    return copy


# -----------------------------------------------------------------------------
# Compiled kernels on disk, in a private folder. Each file is complete or absent.

VARIABLE = 'TAUTO_CACHE_DIR'
_REMEDY = (
    f'Set {VARIABLE} to a folder that only you may write. Until then each run compiles its '
    'kernels anew, which takes seconds.'
)
_NOT_PRIVATE = (
    'compiled kernels are neither kept in {} nor used from there: others may write there'
)
LARGEST_ENTRY = 2**26
"""Most bytes of a kernel that is loaded. The largest has some hundred thousand."""
_warned: set[str] = set()


def folder() -> Path:
    """Return the folder of compiled kernels, or raise a RuntimeError without a home folder."""
    path = os.environ.get(VARIABLE)
    if path:
        return Path(path).expanduser()
    home = os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache'
    return Path(home) / 'tauto'


def _warn(message: str) -> None:
    if message not in _warned:
        _warned.add(message)
        warnings.warn(f'{message}. {_REMEDY}', KernelCacheWarning, stacklevel=2)


def _is_private(status: os.stat_result) -> bool:
    """Return whether only this user can write there. The content will be run."""
    if not hasattr(os, 'getuid'):
        return True
    return status.st_uid == os.getuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def read(name: str) -> tuple[dict[str, Any], bytes] | None:
    """Return the entry stored under a name, with its object code, or `None`.

    A damaged entry, or one that another user could have written, is skipped with a warning.
    """
    try:
        place = folder()
        if not _is_private(place.stat()):
            _warn(_NOT_PRIVATE.format(place))
            return None
        # a link is not followed, and a pipe not waited for
        handle = os.open(place / name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        with os.fdopen(handle, 'rb') as file:
            status = os.fstat(handle)
            is_plain = stat.S_ISREG(status.st_mode) and status.st_size <= LARGEST_ENTRY
            if not (is_plain and _is_private(status)):
                raise OSError(errno.EPERM, 'one is no plain file that only you own and may write')
            seal, _, body = file.read().partition(b'\n')
        if hashlib.sha256(body).hexdigest().encode() != seal:
            raise OSError(errno.EIO, 'one is damaged')
        header, _, code = body.partition(b'\n')
        return json.loads(header), code
    except (FileNotFoundError, NotADirectoryError, RuntimeError):
        return None
    except OSError as error:
        _warn(f'compiled kernels in {place} are made anew: {error.strerror}')
        return None


def write(name: str, header: dict[str, Any], code: bytes) -> None:
    """Keep object code under a name. Of two processes at once, one wins."""
    try:
        place = folder()
    except RuntimeError:
        _warn('compiled kernels cannot be kept: this user has no home folder')
        return
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _is_private(place.stat()):
            _warn(_NOT_PRIVATE.format(place))
            return
        body = json.dumps(header).encode() + b'\n' + code
        seal = hashlib.sha256(body).hexdigest().encode()
        handle, draft = tempfile.mkstemp(dir=place, prefix='.draft')
        try:
            with os.fdopen(handle, 'wb') as file:
                file.write(seal + b'\n' + body)
            os.replace(draft, place / name)
        except BaseException:  # a signal, too, leaves no draft
            with contextlib.suppress(OSError):
                os.unlink(draft)
            raise
    except OSError as error:
        _warn(f'compiled kernels cannot be kept in {place}: {error.strerror or error}')


# -----------------------------------------------------------------------------
# The kernels that can be called.

# One thread at a time uses LLVM.
_LOCK = threading.RLock()

OPTIMISED_AFTER_S = 0.25
"""Run time of an entry's quick code in a process [s] before optimised code replaces it.

Quick code takes up to half as long again: no run loses more than a tenth of a second.
"""

# one item for each active `optimised`
_no_hurry: list[None] = []


@contextmanager
def optimised() -> Iterator[None]:
    """Optimise entries at their first call or preparation, for code that must not stall later."""
    _no_hurry.append(None)
    try:
        yield
    finally:
        _no_hurry.pop()


@cache
def _compiler() -> dict[str, str]:
    """Return the files of this compiler with their hashes."""
    return {str(path): digest(str(path)) for path in sorted(Path(__file__).parent.glob('*.py'))}


class CompiledFunction:
    """A kernel that can be called from Python, and releases the interpreter's lock.

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
                    buffer = results()
                    if call(packed, buffer):
                        names = self.python.__code__.co_varnames
                        unfit = [n for n, x in zip(names, args, strict=False) if not _fits(x)]
                        raise KernelError(
                            f'{self.__qualname__}: {", ".join(unfit)} is or holds an array that '
                            'is not C-contiguous and aligned. Use np.ascontiguousarray'
                        )
                    return unpack(buffer)
            self.prepare(*args)
            args = plain_arguments(args)
        raise KernelError(f'{self.__qualname__}: arguments change while it is called')

    def prepare(self, *args: Any) -> None:
        """Compile or load the code for such arguments, or raise a KernelError."""
        structures = [structure_of(arg) for arg in args]
        with _LOCK:
            pack = packer(structures, self.__name__.replace('<lambda>', 'function'))
            if any(old(*plain_arguments(args)) is not None for old, *_ in self._made):
                return
            check_arrays()
            from tauto_core.kernels.machine_code import Effort

            efforts = [Effort.OPTIMISED] if _no_hurry else [Effort.OPTIMISED, Effort.QUICK]
            layout, call, effort = self._compiled(structures, efforts)
            if effort is Effort.QUICK:
                call = self._timed(call, structures)
            words, unpack = unpacker(layout)
            self._made = [(pack, call, ctypes.c_int64 * words, unpack), *self._made]

    def _timed(self, quick: Any, structures: list[Any]) -> Any:
        """Return quick code that is replaced by optimised code once it has run for a while."""
        from tauto_core.kernels.machine_code import Effort

        ran_s, best = 0.0, None

        def call(packed: bytes, buffer: Any) -> Any:
            nonlocal ran_s, best
            if best is None and (_no_hurry or ran_s > OPTIMISED_AFTER_S):
                with _LOCK:
                    best = best or self._compiled(structures, [Effort.OPTIMISED])[1]
            if best is not None:
                return best(packed, buffer)
            began = time.thread_time()
            failed = quick(packed, buffer)
            ran_s += time.thread_time() - began
            return failed

        return call

    def _compiled(self, structures: list[Any], efforts: list[Any]) -> tuple[Any, Any, Any]:
        """Return the layout of the result, the entry in memory, and its effort.

        Code on disk is taken in the order of the efforts. Without any, the last effort is made.
        """
        from tauto_core.kernels.machine_code import (
            compiler_versions,
            loaded,
            object_code,
            processor,
        )

        for effort in efforts:
            identity = '\n'.join(
                [
                    self.python.__code__.co_filename,
                    f'{self.python.__module__}.{self.python.__qualname__}',
                    *(spelled_out(structure) for structure in structures),
                    effort.name,
                    *compiler_versions(),
                ]
            )
            tag = hashlib.sha256(identity.encode()).hexdigest()[:32]
            file, name = f'{self.python.__name__}.{tag}', f'{ENTRY}_{tag}'
            entry = read(file)
            if entry is not None and is_unchanged(entry[0]['files'], entry[0]['names']):
                return entry[0]['result'], loaded(entry[1], name), effort
        # file, name and effort are now the last ones
        from tauto_core.kernels.translation import Program

        with compiling(f'{self.python.__module__}.{self.python.__qualname__}') as translated:
            program = Program(self.python, structures, name)
            text = str(program.module)
            translated(text.count('\n') / effort.lines_per_s)
            code = object_code(text, processor(), effort)
        used = program.used
        header = {'files': _compiler() | used.files, 'names': used.names, 'result': program.result}
        write(file, header, code)
        return program.result, loaded(code, name), effort


def _fits(x: Any) -> bool:
    if isinstance(x, tuple):
        return all(_fits(item) for item in x)
    flags = getattr(x, 'flags', None)
    return flags is None or bool(flags.c_contiguous and flags.aligned)


def entry(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function for calls from Python, see `CompiledFunction`."""
    return CompiledFunction(function)
