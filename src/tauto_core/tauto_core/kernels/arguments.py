"""The calling convention between Python and kernels: words of eight bytes, one for each number.

The structure of an argument is a tree: the name of a number's kind, None, `Rows` of an array, or a
`Tuple`. From it a function is made that packs arguments of this structure fast, and detects any
other structure. For an array the address of its object is packed; the compiled code reads from
there where its numbers are.
"""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from tauto_core.kernels.marks import KernelError

ENTRY = 'entry'
"""Name of an entry in its object code."""

DATA, DIMENSIONS, FLAGS = 0, 16, 48
"""Places behind the head of NumPy's array object (PyArrayObject_fields in ndarraytypes.h, which
programs compiled with NumPy depend on)."""

NEEDED_FLAGS = 0x0001 | 0x0100
"""C-contiguous and aligned."""

FORMATS = {'float': 'd', 'int': 'q', 'uint64': 'Q', 'bool': 'q'}
_TESTS = {
    'float': 'not isinstance({0}, float)',
    'int': '{0}.__class__ is not int and {0}.__class__ is not int64',
    'uint64': '{0}.__class__ is not uint64',
    'bool': '{0}.__class__ is not bool and {0}.__class__ is not bool_',
}
_DTYPES = {name: np.dtype(name) for name in ('f8', 'i8', 'u8', 'b1')}


class Rows(NamedTuple):
    """An array: its items and the number of its dimensions."""

    dtype: Any
    ndim: int


class Tuple(NamedTuple):
    """A tuple, or a NamedTuple of a class."""

    named: Any
    items: tuple[Any, ...]


def structure_of(x: Any) -> Any:
    """Return the structure of an argument.

    Raises:
        KernelError: kernels take no such argument.
    """
    if x is None:
        return None
    if isinstance(x, (bool, np.bool_)):
        return 'bool'
    if isinstance(x, float):
        return 'float'
    if isinstance(x, (int, np.int64)):
        return 'int'
    if isinstance(x, np.uint64):
        return 'uint64'
    if isinstance(x, tuple):
        named = type(x) if hasattr(x, '_fields') else None
        return Tuple(named, tuple(structure_of(item) for item in x))
    if isinstance(x, np.ndarray):
        if x.dtype.fields is None and x.dtype.str[1:] not in _DTYPES:
            raise KernelError(f'kernels take no arrays of {x.dtype}')
        return Rows(_dtype(x), x.ndim)
    raise KernelError(f'kernels take no {type(x).__name__}: {x!r}')


def _dtype(x: Any) -> Any:
    return x.dtype if x.dtype.fields is not None else _DTYPES[x.dtype.str[1:]]


def plain(x: Any) -> Any:
    """Return an argument with arrays that are just arrays, of NumPy's own objects for dtypes."""
    if isinstance(x, tuple):
        items = [plain(item) for item in x]
        return type(x)(*items) if hasattr(x, '_fields') else tuple(items)
    return np.asarray(x).view(_dtype(x)) if isinstance(x, np.ndarray) else x


def in_words(structure: Any) -> str:
    """Return a structure as text that is the same in every run."""
    if isinstance(structure, Tuple):
        named = structure.named
        name = f'{named.__module__}.{named.__qualname__}{named._fields}' if named else ''
        return f'{name}({", ".join(in_words(item) for item in structure.items)})'
    if isinstance(structure, Rows):
        return f'{structure.dtype.descr}[{structure.ndim}]'
    return str(structure)


class _Packing:
    """The source of a function that packs arguments of one structure.

    Attributes:
        lines: statements that take tuples apart, and return None for another structure.
        words: expressions that are packed, one word each.
        formats: how `struct` packs each of them.
        known: what the names in the lines stand for.
    """

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.words: list[str] = []
        self.formats: list[str] = []
        self.known: dict[str, Any] = {
            'ndarray': np.ndarray,
            'int64': np.int64,
            'uint64': np.uint64,
            'bool_': np.bool_,
        }

    def take(self, name: str, structure: Any) -> None:
        """Test and pack the argument of a name."""
        if structure is None:
            self._refuse(f'{name} is not None')
        elif isinstance(structure, Tuple):
            self._take_tuple(name, structure)
        elif isinstance(structure, Rows):
            self.known[f'D{name}'] = structure.dtype
            other = '!=' if structure.dtype.fields is not None else 'is not'
            self._refuse(f'{name}.__class__ is not ndarray or {name}.dtype {other} D{name}')
            self._refuse(f'{name}.ndim != {structure.ndim}')
            self._pack(f'id({name})', 'q')
        else:
            self._refuse(_TESTS[structure].format(name))
            self._pack(f'bool({name})' if structure == 'bool' else name, FORMATS[structure])

    def _take_tuple(self, name: str, structure: Tuple) -> None:
        items = structure.items
        self.known[f'T{name}'] = structure.named or tuple
        self._refuse(f'{name}.__class__ is not T{name} or len({name}) != {len(items)}')
        names = [f'{name}_{i}' for i in range(len(items))]
        if names:
            self.lines.append(f' {", ".join(names)}, = {name}')
        for each, item in zip(names, items, strict=True):
            self.take(each, item)

    def _refuse(self, test: str) -> None:
        self.lines.append(f' if {test}: return None')

    def _pack(self, word: str, form: str) -> None:
        self.words.append(word)
        self.formats.append(form)


def packer(structures: list[Any], kernel: str) -> Callable[..., bytes | None]:
    """Return a function that packs arguments, or returns None for those of another structure.

    It has the name of the kernel, so that Python's error for a wrong number of arguments names it.
    """
    packing = _Packing()
    names = [f'a{i}' for i in range(len(structures))]
    for name, structure in zip(names, structures, strict=True):
        packing.take(name, structure)
    known = {**packing.known, 'pack': struct.Struct(''.join(packing.formats)).pack}
    head = f'def {kernel}({", ".join(names)}):'
    exec('\n'.join([head, *packing.lines, f' return pack({", ".join(packing.words)})']), known)
    made: Callable[..., bytes | None] = known[kernel]
    return made


@cache
def check_arrays() -> None:
    """Check that NumPy's arrays are laid out as compiled code reads them.

    Raises:
        KernelError: they are not.
    """
    array = np.arange(6.0).reshape(2, 3)
    begin = id(array) + object.__basicsize__
    data = ctypes.c_void_p.from_address(begin + DATA).value
    shape = ctypes.POINTER(ctypes.c_ssize_t).from_address(begin + DIMENSIONS)
    flags = ctypes.c_int.from_address(begin + FLAGS).value
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
    """Return how many words a result takes, and a function that makes the result from them.

    Args:
        layout: the name of a number's kind, None, a list, or a dict of an array.
    """
    words, formats = 0, []
    known: dict[str, Any] = {'array': _array}

    def made(part: Any) -> str:
        nonlocal words
        if part is None:
            return 'None'
        if isinstance(part, list):
            return f'({"".join(f"{made(item)}, " for item in part)})'
        first = words
        if isinstance(part, dict):
            words += 1 + part['ndim']
            formats.append('q' * (1 + part['ndim']))
            return f'array({part["array"]!r}, w[{first}:{words}])'
        words += 1
        formats.append(FORMATS[part])
        return f'w[{first}] != 0' if part == 'bool' else f'w[{first}]'

    text = made(layout)
    known['unpack'] = struct.Struct(''.join(formats)).unpack
    exec(f'def unpacked(back):\n w = unpack(back)\n return {text}', known)
    return words, known['unpacked']


def _array(kind: str, words: tuple[int, ...]) -> Any:
    """Return an array that a kernel has made, and give its memory back."""
    dtype = {'float': 'f8', 'int': 'i8', 'uint64': 'u8', 'bool': 'b1'}[kind]
    data, shape = words[0], words[1:]
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    copy = np.frombuffer(bytearray(ctypes.string_at(data, size)), dtype).reshape(shape)
    _free()(ctypes.c_void_p.from_address(data - 8))
    return copy


@cache
def _free() -> Any:
    free = ctypes.CDLL(None).free
    free.argtypes, free.restype = [ctypes.c_void_p], None
    return free
