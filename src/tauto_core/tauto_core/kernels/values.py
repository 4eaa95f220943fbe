"""What a variable of a kernel may be while the kernel is compiled.

What is known when compiling is called static, and is any Python object: a number, None, a tuple, a
function, a class. Known at run time only are `Value`s, which are numbers, lanes or pointers,
`Array`s and `Record`s. A `Group` is a tuple with items that are known at run time only. It is
never built in memory: each of its numbers is an SSA value of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
from llvmlite import ir

from tauto_core.kernels.errors import KernelError

DOUBLE, WORD, BIT, BYTE, INDEX = (
    ir.DoubleType(),
    ir.IntType(64),
    ir.IntType(1),
    ir.IntType(8),
    ir.IntType(32),
)


class Kind:
    """What a number at run time is; there is one object of each kind.

    Attributes:
        name: as error messages say it.
        type: LLVM's type of a value.
        stored: LLVM's type in memory.
        lanes: how many doubles lanes are; 0: no lanes.
    """

    def __init__(self, name: str, kind: ir.Type, stored: ir.Type | None = None, lanes: int = 0):
        self.name, self.type, self.stored, self.lanes = name, kind, stored or kind, lanes

    def __repr__(self) -> str:
        return self.name


FLOAT, INT, UINT = Kind('float', DOUBLE), Kind('int', WORD), Kind('uint64', WORD)
BOOL = Kind('bool', BIT, BYTE)
ELEMENTS = {'f8': FLOAT, 'i8': INT, 'u8': UINT, 'b1': BOOL}


@cache
def lanes_of(count: int) -> Kind:
    """Return the kind of so many doubles as one number."""
    return Kind(f'{count} lanes', ir.VectorType(DOUBLE, count), lanes=count)


class Pointer(Kind):
    """The address of the numbers of an array, `row` of which are one row of lanes."""

    def __init__(self, item: Kind, row: int) -> None:
        super().__init__(f'pointer to {item} in rows of {row}', item.stored.as_pointer())
        self.item, self.row = item, row


@cache
def pointer_to(item: Kind, row: int) -> Pointer:
    """Return the kind of pointers to such numbers."""
    return Pointer(item, row)


class Value:
    """A number, lanes or a pointer at run time.

    Attributes:
        kind: what it is.
        ir: LLVM's value.
    """

    __slots__ = ('ir', 'kind')

    def __init__(self, kind: Kind, value: ir.Value) -> None:
        self.kind, self.ir = kind, value


class Group:
    """A tuple, named where `instance_class` is a NamedTuple; it can be read like a tuple."""

    __slots__ = ('instance_class', 'items')

    def __init__(self, items: Any, instance_class: type | None = None) -> None:
        self.items, self.instance_class = tuple(items), instance_class

    def __getitem__(self, i: Any) -> Any:
        return Group(self.items[i]) if isinstance(i, slice) else self.items[i]

    def __len__(self) -> int:
        return len(self.items)

    def __iter__(self) -> Iterator[Any]:
        return iter(self.items)


class Fields:
    """What an item of a structured array is: NumPy's type of it, and the address of one."""

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self.dtype, self.stored, self.name = dtype, BYTE, str(dtype.descr)


@cache
def fields_of(dtype: np.dtype[Any]) -> Fields:
    """Return what an item of such an array is; of equal types it is one."""
    return Fields(dtype)


class Array:
    """A C-contiguous array.

    Attributes:
        kind: the kind of its items: a Kind, or Fields.
        data: address of the first.
        shape: lengths, LLVM's integers.
        room: what was allocated for it in this kernel, if it was.
    """

    __slots__ = ('data', 'kind', 'room', 'shape')

    def __init__(self, kind: Any, data: ir.Value, shape: Any, room: Any = None) -> None:
        self.kind, self.data, self.shape, self.room = kind, data, tuple(shape), room


class Record:
    """One item of a structured array, read and written by the names of its fields."""

    __slots__ = ('data', 'kind')

    def __init__(self, kind: Fields, data: ir.Value) -> None:
        self.kind, self.data = kind, data


class Conflict:
    """What a variable is whose kind depends on the way taken: it may be set, but not read."""

    __slots__ = ('why',)

    def __init__(self, why: str) -> None:
        self.why = why


RUN_TIME = (Value, Group, Array, Record, Conflict)


def is_static(x: Any) -> bool:
    """Return whether a value is known when compiling."""
    return not isinstance(x, RUN_TIME)


def is_number(x: Any) -> bool:
    """Return whether a static value is a plain number of Python."""
    return isinstance(x, (bool, int, float))


def at_run_time(x: Any) -> Any:
    """Return a value whose numbers are all known at run time only; all else stays static."""
    if isinstance(x, (bool, np.bool_)):
        return Value(BOOL, ir.Constant(BIT, int(x)))
    if isinstance(x, np.uint64):
        return Value(UINT, ir.Constant(WORD, int(x)))
    if isinstance(x, (int, np.integer)):
        return Value(INT, ir.Constant(WORD, int(x)))
    if isinstance(x, (float, np.floating)):
        return Value(FLOAT, ir.Constant(DOUBLE, float(x)))
    if isinstance(x, Group):
        return Group([at_run_time(item) for item in x.items], x.instance_class)
    if isinstance(x, tuple):
        return Group([at_run_time(i) for i in x], type(x) if hasattr(x, '_fields') else None)
    if isinstance(x, Conflict):
        raise KernelError(x.why)
    return x


def leaves(x: Any) -> list[ir.Value]:
    """Return the LLVM values of which a value consists, in the order of `rebuilt`."""
    if isinstance(x, Value):
        return [x.ir]
    if isinstance(x, Group):
        return [leaf for item in x.items for leaf in leaves(item)]
    if isinstance(x, Array):
        return [x.data, *x.shape]
    return [x.data] if isinstance(x, Record) else []


def rebuilt(x: Any, values: Iterator[ir.Value]) -> Any:
    """Return a value of the structure of x with other values of LLVM."""
    if isinstance(x, Value):
        return Value(x.kind, next(values))
    if isinstance(x, Group):
        return Group([rebuilt(item, values) for item in x.items], x.instance_class)
    if isinstance(x, Array):
        return Array(x.kind, next(values), [next(values) for _ in x.shape])
    if isinstance(x, Record):
        return Record(x.kind, next(values))
    return x


def described(x: Any) -> str:
    """Return what a value is: for messages, and to tell specialisations apart."""
    if isinstance(x, Value):
        return x.kind.name
    if isinstance(x, Group):
        named = x.instance_class
        name = f'{named.__module__}.{named.__qualname__}' if named else ''
        return f'{name}({", ".join(described(item) for item in x.items)})'
    if isinstance(x, Array):
        return f'{x.kind.name}[{len(x.shape)}]'
    if isinstance(x, Record):
        return f'record {x.kind.name}'
    return x.why if isinstance(x, Conflict) else repr(x)
