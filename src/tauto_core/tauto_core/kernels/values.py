"""The kinds of a kernel's variables at compile time, and the function being written.

A value known at compile time is static. It is any Python object: a number, `None`, a tuple, a
function, a class. Known at run time only are `Value`s (numbers, lanes or pointers), `Array`s and
`Record`s. A `Group` is a tuple of such items. It is never built in memory: each of its numbers is
an SSA value.
"""

from __future__ import annotations

import builtins
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any

import numpy as np
from llvmlite import ir

from tauto_core.kernels.marks import KernelError

DOUBLE, WORD, BIT, BYTE, INDEX = (
    ir.DoubleType(),
    ir.IntType(64),
    ir.IntType(1),
    ir.IntType(8),
    ir.IntType(32),
)


class NumberKind:
    """The type of a number at run time. Each type is one object.

    Attributes:
        name: its name in error messages.
        type: LLVM's type of a value.
        stored: LLVM's type in memory.
        lanes: number of doubles in lanes, or 0.
    """

    def __init__(self, name: str, kind: ir.Type, stored: ir.Type | None = None, lanes: int = 0):
        self.name, self.type, self.stored, self.lanes = name, kind, stored or kind, lanes

    def __repr__(self) -> str:
        return self.name


FLOAT, INT, UINT = NumberKind('float', DOUBLE), NumberKind('int', WORD), NumberKind('uint64', WORD)
BOOL = NumberKind('bool', BIT, BYTE)
_CONSTANTS: tuple[tuple[Any, NumberKind, Any], ...] = (
    ((bool, np.bool_), BOOL, int),
    (np.uint64, UINT, int),
    ((int, np.integer), INT, int),
    ((float, np.floating), FLOAT, float),
)
ELEMENTS = {'f8': FLOAT, 'i8': INT, 'u8': UINT, 'b1': BOOL}


@cache
def lanes_of(count: int) -> NumberKind:
    """Return the kind of `count` doubles as lanes."""
    return NumberKind(f'{count} lanes', ir.VectorType(DOUBLE, count), lanes=count)


class Pointer(NumberKind):
    """The address of an array's numbers. One row of lanes has `row` numbers."""

    def __init__(self, item: NumberKind, row: int) -> None:
        super().__init__(f'pointer to {item} in rows of {row}', item.stored.as_pointer())
        self.item, self.row = item, row


pointer_to = cache(Pointer)


class Value:
    """A number, lanes or a pointer at run time.

    Attributes:
        kind: its type.
        ir: LLVM's value.
    """

    __slots__ = ('ir', 'kind')

    def __init__(self, kind: NumberKind, value: ir.Value) -> None:
        self.kind, self.ir = kind, value


class Group:
    """A tuple that can be read like Python's, of the NamedTuple `instance_class` if given."""

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
    """An item of a structured array, by its NumPy type."""

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self.dtype, self.stored, self.name = dtype, BYTE, str(dtype.descr)


fields_of = cache(Fields)
"""Equal types give the same object."""


class Array:
    """A C-contiguous array.

    Attributes:
        kind: the kind of its items, a NumberKind or Fields.
        data: address of the first item.
        shape: lengths, LLVM's integers.
        room: the memory allocated for it in this kernel, if any.
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
    """A variable with a type that depends on the branch taken: it may be set, but not read."""

    __slots__ = ('why',)

    def __init__(self, why: str) -> None:
        self.why = why


RUN_TIME = (Value, Group, Array, Record, Conflict)


def is_static(x: Any) -> bool:
    """Return whether a value is known at compile time."""
    return not isinstance(x, RUN_TIME)


def is_number(x: Any) -> bool:
    """Return whether a static value is a plain Python number."""
    return isinstance(x, (bool, int, float))


def at_run_time(x: Any) -> Any:
    """Return a value with its numbers turned into run-time values. The rest stays static."""
    for classes, kind, python_type in _CONSTANTS:
        if isinstance(x, classes):
            return Value(kind, ir.Constant(kind.type, python_type(x)))
    if isinstance(x, Group):
        return Group([at_run_time(item) for item in x.items], x.instance_class)
    if isinstance(x, tuple):
        return Group([at_run_time(i) for i in x], type(x) if hasattr(x, '_fields') else None)
    if isinstance(x, Conflict):
        raise KernelError(x.why)
    return x


def leaves(x: Any) -> list[ir.Value]:
    """Return the LLVM values of a value, in the order of `rebuilt`."""
    if isinstance(x, Value):
        return [x.ir]
    if isinstance(x, Group):
        return [leaf for item in x.items for leaf in leaves(item)]
    if isinstance(x, Array):
        return [x.data, *x.shape]
    return [x.data] if isinstance(x, Record) else []


def rebuilt(x: Any, values: Iterator[ir.Value]) -> Any:
    """Return a value of the structure of x with other LLVM values."""
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
    """Return a description of a value, for messages and to distinguish specialisations."""
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


# -----------------------------------------------------------------------------
# The LLVM function being written, with conversions and memory access.

FIELD_ROW = 8
"""Numbers per row of lanes in a field of several numbers that has no rows itself."""


class Emission:
    """The emitted part of one LLVM function, and the position of the next instruction.

    Attributes:
        module: LLVM's module with all functions of an entry.
        f: LLVM's function.
        b: writes instructions.
        depth: number of enclosing branches and loops. Their code may run never, or many times.
        rooms: addresses of the allocated memory.
    """

    def __init__(self, module: Any, f: ir.Function) -> None:
        self.module, self.f = module, f
        self.b = ir.IRBuilder(f.append_basic_block('start'))
        self.depth = 0
        self.rooms: list[ir.Value] = []

    def block(self, name: str) -> ir.Block:
        """Return a new, empty block."""
        return self.f.append_basic_block(name)

    @contextmanager
    def nested(self) -> Any:
        """Mark the emitted code as not run exactly once."""
        self.depth += 1
        yield
        self.depth -= 1

    def function(self, name: str, result: ir.Type, args: Sequence[ir.Type]) -> ir.Function:
        """Return an LLVM intrinsic or a C library function, declared once."""
        known = self.module.globals.get(name)
        return known or ir.Function(self.module, ir.FunctionType(result, args), name)

    def external(self, name: str, result: ir.Type, args: Sequence[ir.Value]) -> ir.Value:
        """Call an LLVM intrinsic or a C library function without side effects."""
        function = self.function(name, result, [arg.type for arg in args])
        if not name.startswith('llvm.'):
            function.attributes.add('nounwind')
            function.attributes.add('readnone')
        return self.b.call(function, args)

    # numbers

    def convert(self, x: Any, kind: NumberKind) -> Value:
        """Return a number as another kind.

        Raises a KernelError if it is not a number, or would not keep its value.
        """
        x = at_run_time(x)
        if isinstance(x, Value):
            if x.kind is kind:
                return x
            change = self._change(x, kind)
            if change is not None:
                return Value(kind, change)
        raise KernelError(f'{described(x)} where {kind} is wanted')

    def _change(self, x: Value, kind: NumberKind) -> ir.Value | None:
        b, was = self.b, x.kind
        if kind is FLOAT:
            if was is INT:
                return b.sitofp(x.ir, DOUBLE)
            return b.uitofp(x.ir, DOUBLE) if was in (UINT, BOOL) else None
        if kind in (INT, UINT):
            if was is FLOAT:
                return (b.fptosi if kind is INT else b.fptoui)(x.ir, WORD)
            if was is BOOL:
                return b.zext(x.ir, WORD)
            return x.ir if was in (INT, UINT) else None
        if kind is BOOL:
            truth = self.truth(x)
            return truth.ir if isinstance(truth, Value) else None
        return self.spread(self.float(x), kind.lanes) if kind.lanes and not was.lanes else None

    def float(self, x: Any) -> ir.Value:
        """Return the LLVM value of a number as a float."""
        return self.convert(x, FLOAT).ir

    def int(self, x: Any) -> ir.Value:
        """Return the LLVM value of a whole number."""
        x = at_run_time(x)
        if not isinstance(x, Value) or x.kind not in (INT, UINT, BOOL):
            raise KernelError(f'{described(x)} where a whole number is wanted')
        return self.convert(x, INT).ir if x.kind is BOOL else x.ir

    def truth(self, x: Any) -> Any:
        """Return the truth of a value, as a bool if it is known at compile time."""
        if is_static(x):
            return bool(x)
        if isinstance(x, Value):
            if x.kind is BOOL:
                return x
            if x.kind in (INT, UINT):
                return Value(BOOL, self.b.icmp_signed('!=', x.ir, ir.Constant(WORD, 0)))
            if x.kind is FLOAT:
                return Value(BOOL, self.b.fcmp_unordered('!=', x.ir, ir.Constant(DOUBLE, 0.0)))
        raise KernelError(f'{described(x)} is neither true nor false')

    # lanes

    def lanes(self, x: Any) -> ir.Value:
        """Return the LLVM vector of lanes."""
        if not isinstance(x, Value) or not x.kind.lanes:
            raise KernelError(f'{described(x)} where lanes are wanted')
        return x.ir

    def as_lanes(self, vector: ir.Value) -> Value:
        """Return an LLVM vector as lanes."""
        return Value(lanes_of(vector.type.count), vector)

    def as_float(self, value: ir.Value) -> Value:
        """Return an LLVM double as a float."""
        return Value(FLOAT, value)

    def as_int(self, value: ir.Value) -> Value:
        """Return an LLVM integer as a whole number, zero-extended."""
        return Value(INT, value if value.type == WORD else self.b.zext(value, WORD))

    def group(self, items: Sequence[Any]) -> Group:
        """Return values as a tuple."""
        return Group(items)

    def item(self, vector: ir.Value, i: Any) -> ir.Value:
        """Return a double of a vector. i is a number, or an LLVM value."""
        return self.b.extract_element(vector, self.index(i))

    def index(self, i: Any) -> ir.Value:
        """Return a position in a vector."""
        return ir.Constant(INDEX, i) if is_number(i) else self.b.trunc(self.int(i), INDEX)

    def vector_function(self, name: str, *vectors: ir.Value) -> ir.Value:
        """Call the LLVM intrinsic of this name for vectors, or for doubles, of their own type."""
        kind = vectors[0].type
        suffix = f'v{kind.count}f64' if isinstance(kind, ir.VectorType) else 'f64'
        return self.external(f'llvm.{name}.{suffix}', kind, vectors)

    def row(self, rows: Any, count: builtins.int, number: ir.Value) -> ir.Value:
        """Return the address of a row of `count` doubles in an array or behind a pointer."""
        if isinstance(rows, Array) and rows.kind is FLOAT:
            data = rows.data
        elif isinstance(rows, Value) and isinstance(rows.kind, Pointer):
            data = rows.ir
        else:
            raise KernelError(f'{described(rows)} where rows of floats are wanted')
        is_constant = isinstance(number, ir.Constant)
        size = ir.Constant(WORD, count * number.constant if is_constant else count)
        address = self.b.gep(data, [size if is_constant else self.b.mul(number, size)])
        return self.b.bitcast(address, ir.VectorType(DOUBLE, count).as_pointer())

    def next(self, number: ir.Value, step: builtins.int) -> ir.Value:
        """Return a whole number plus a constant."""
        return self.b.add(number, ir.Constant(WORD, step))

    def shuffled(self, a: ir.Value, c: ir.Value, order: Sequence[builtins.int]) -> ir.Value:
        """Return lanes picked from two concatenated vectors."""
        mask = ir.Constant(ir.VectorType(INDEX, len(order)), list(order))
        return self.b.shuffle_vector(a, c, mask)

    def spread(self, x: ir.Value, lanes: builtins.int) -> ir.Value:
        """Return a double in each of `lanes` lanes."""
        nothing = ir.Constant(ir.VectorType(DOUBLE, lanes), ir.Undefined)
        vector = self.b.insert_element(nothing, x, ir.Constant(INDEX, 0))
        return self.shuffled(vector, nothing, [0] * lanes)

    def zeros(self, vector: ir.Value) -> ir.Value:
        """Return a vector of zeros like another."""
        return ir.Constant(vector.type, [0.0] * vector.type.count)

    def bits(self, vector: ir.Value) -> ir.Value:
        """Return a vector of bits as one integer, the first bit lowest."""
        return self.b.bitcast(vector, ir.IntType(vector.type.count))

    # memory

    def reloaded(self, vector: ir.Value) -> ir.Value:
        """Return the address of a vector's numbers, hidden from LLVM's optimiser.

        They are then read from memory, even if a register still holds them.
        """
        address = self.b.bitcast(vector, DOUBLE.as_pointer())
        kind = ir.FunctionType(address.type, [address.type])
        return self.b.asm(kind, '', '=r,0', [address], False)

    def number(self, address: ir.Value, i: builtins.int) -> ir.Value:
        """Return the double i numbers behind an address."""
        return self.b.load(self.b.gep(address, [ir.Constant(WORD, i)]))

    def load(self, address: ir.Value, kind: Any) -> Any:
        """Return the value at an address, or the address of a field of several numbers."""
        if isinstance(kind, Array):
            return kind
        if isinstance(kind, Fields):
            return Record(kind, address)
        if isinstance(kind, Pointer):
            return Value(kind, address)
        value = self.b.load(address)
        if kind is BOOL:
            value = self.b.icmp_unsigned('!=', value, ir.Constant(BYTE, 0))
        return Value(kind, value)

    def save(self, address: ir.Value, kind: Any, x: Any) -> None:
        """Write a number to memory."""
        if isinstance(kind, Fields | Pointer | Array):
            raise KernelError('a whole record cannot be set, only its fields and their items')
        value = self.convert(x, kind).ir
        self.b.store(self.b.zext(value, BYTE) if kind is BOOL else value, address)

    def field(self, record: Record, name: str) -> tuple[ir.Value, Any]:
        """Return the address and kind of a field of a record."""
        fields: Any = record.kind.dtype.fields or {}
        if name not in fields:
            raise KernelError(f'the record has no field {name}; it has {", ".join(fields)}')
        dtype, offset = fields[name][:2]
        place = self.b.gep(record.data, [ir.Constant(WORD, offset)])
        if dtype.base.fields is not None:
            nested, shape = fields_of(dtype.base), [ir.Constant(WORD, n) for n in dtype.shape]
            return place, Array(nested, place, shape) if shape else nested
        kind = element(dtype.base)
        address = self.b.bitcast(place, kind.stored.as_pointer())
        if dtype.subdtype is None:
            return address, kind
        row = dtype.shape[-1] if dtype.ndim > 1 else FIELD_ROW
        return address, pointer_to(kind, row)

    # blocks

    def go_on(self, blocks: Sequence[ir.Block], target: ir.Block) -> None:
        """Let several blocks continue in another one, and write there."""
        for block in blocks:
            self.b.position_at_end(block)
            self.b.branch(target)
        self.b.position_at_end(target)


def element(dtype: Any) -> NumberKind:
    """Return the kind of an array's items, or raise a KernelError for unsupported items."""
    kind = ELEMENTS.get(dtype.str[1:])
    if kind is None or dtype.byteorder == '>':
        raise KernelError(f'kernels know no arrays of {dtype}')
    return kind
