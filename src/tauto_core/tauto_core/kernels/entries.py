"""Kernels that are called from Python: compiled at the first call for arguments of a structure."""

from __future__ import annotations

import ctypes
import hashlib
import threading
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from tauto_core.kernels import store
from tauto_core.kernels.arguments import (
    ENTRY,
    check_arrays,
    in_words,
    packer,
    plain,
    structure_of,
    unpacker,
)
from tauto_core.kernels.errors import KernelError
from tauto_core.kernels.progress import compiling
from tauto_core.kernels.used import digest, is_as_it_was

_LOCK = threading.RLock()
"""LLVM is used by one thread at a time."""


@cache
def _stamp() -> str:
    """Return what all compiled code depends on beside its sources: processor and versions."""
    from tauto_core.kernels.target import versions

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
        made = self._made
        for pack, call, room, unpack in made:
            packed = pack(*args)
            if packed is not None:
                back = room()
                failed = call(packed, back)
                if failed:
                    raise self._unfit(args)
                return unpack(back)
        return self._slowly(args)

    def _slowly(self, args: tuple[Any, ...]) -> Any:
        self.prepare(*args)
        args = plain(args)
        for pack, call, room, unpack in self._made:
            packed = pack(*args)
            if packed is not None:
                back = room()
                if call(packed, back):
                    raise self._unfit(args)
                return unpack(back)
        raise KernelError(f'{self.__qualname__}: arguments change while it is called')

    def _unfit(self, args: tuple[Any, ...]) -> KernelError:
        names = self.python.__code__.co_varnames
        unfit = [name for name, x in zip(names, args, strict=False) if not _fits(x)]
        return KernelError(
            f'{self.__qualname__}: {", ".join(unfit)} is or holds an array that is not '
            'C-contiguous and aligned. Use np.ascontiguousarray'
        )

    def prepare(self, *args: Any) -> None:
        """Compile, or load, what a call with such arguments needs.

        Raises:
            KernelError: the kernel, or the arguments, cannot be compiled.
        """
        structures = [structure_of(arg) for arg in args]
        with _LOCK:
            pack = packer(structures, self.__name__.replace('<lambda>', 'function'))
            if any(old(*plain(args)) is not None for old, *_ in self._made):
                return
            check_arrays()
            layout, code, name = self._code(structures)
            from tauto_core.kernels.target import loaded

            words, unpack = unpacker(layout)
            call = loaded(code, name)
            self._made = [(pack, call, ctypes.c_int64 * words, unpack), *self._made]

    def _code(self, structures: list[Any]) -> tuple[Any, bytes, str]:
        """Return the layout of the result, object code and the name of the entry in it."""
        function = self.python
        identity = '\n'.join(
            [
                function.__code__.co_filename,
                f'{function.__module__}.{function.__qualname__}',
                *(in_words(structure) for structure in structures),
                _stamp(),
            ]
        )
        tag = hashlib.sha256(identity.encode()).hexdigest()[:32]
        file, name = f'{function.__name__}.{tag}', f'{ENTRY}_{tag}'
        kept = store.read(file)
        if kept is not None and is_as_it_was(kept[0]['files'], kept[0]['names']):
            return kept[0]['result'], kept[1], name
        from tauto_core.kernels.program import Program
        from tauto_core.kernels.target import object_code, processor

        with compiling(f'{function.__module__}.{function.__qualname__}') as translated:
            program = Program(function, structures, name)
            text = str(program.module)
            translated(text.count('\n'))
            code = object_code(text, processor())
        used = program.used
        header = {'files': _compiler() | used.files, 'names': used.names, 'result': program.result}
        store.write(file, header, code)
        return program.result, code, name


def _fits(x: Any) -> bool:
    if isinstance(x, tuple):
        return all(_fits(item) for item in x)
    flags = getattr(x, 'flags', None)
    return flags is None or bool(flags.c_contiguous and flags.aligned)


def entry(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function for calls from Python, see `Entry`."""
    return Entry(function)
