"""A module of LLVM: an entry and all that it calls."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from types import FunctionType
from typing import Any

from llvmlite import ir

from tauto_core.kernels.entries import DATA, DIMENSIONS, FLAGS, NEEDED_FLAGS, Rows, Tuple
from tauto_core.kernels.marks import KernelError, Used, arguments_of, source_of
from tauto_core.kernels.translation import Frame
from tauto_core.kernels.values import (
    BIT,
    BOOL,
    BYTE,
    DOUBLE,
    FLOAT,
    INDEX,
    INT,
    UINT,
    WORD,
    Array,
    Emission,
    Group,
    Record,
    Value,
    at_run_time,
    described,
    element,
    fields_of,
    leaves,
    rebuilt,
)


class Instance:
    """A function of LLVM: a kernel specialised for arguments of one structure.

    Attributes:
        f: LLVM's function.
        result: its result, with placeholders for the values of a call.
    """

    def __init__(self, program: Program, function: FunctionType, args: list[Any]) -> None:
        kind = ir.FunctionType(ir.VoidType(), [leaf.type for arg in args for leaf in leaves(arg)])
        program.count += 1
        name = f'{function.__name__.strip("<>")}.{program.count}'
        self.f = ir.Function(program.module, kind, name)
        out = Emission(program.module, self.f)
        head = out.b.block
        out.b.position_at_end(out.block('body'))
        first = out.b.block
        given = iter(self.f.args)
        self.result = Frame(program, out, function).result([rebuilt(a, given) for a in args], {})
        self._return(out)
        out.b.position_at_end(head)
        out.b.branch(first)
        self.f.linkage = 'internal'
        self.f.attributes.add('nounwind')

    def _return(self, out: Emission) -> None:
        b = out.b
        kept = _rooms_of(self.result)
        if out.rooms:
            if None in kept:
                raise KernelError('an array is returned that may be one of several')
            free = free_function(out.module)
            for room in out.rooms:
                if all(room is not other for other in kept):
                    b.call(free, [room])
        values = leaves(self.result)
        if not values:
            b.ret_void()
            return
        kind = ir.LiteralStructType([value.type for value in values])
        whole = ir.Constant(kind, ir.Undefined)
        for i, value in enumerate(values):
            whole = b.insert_value(whole, value, i)
        b.ret(whole)
        self.f.ftype = ir.FunctionType(kind, self.f.ftype.args)
        self.f.return_value.type = kind
        self.f.type = self.f.ftype.as_pointer()

    def called(self, out: Emission, values: list[ir.Value]) -> Any:
        """Emit a call; return its result."""
        result, count = out.b.call(self.f, values), len(leaves(self.result))
        return rebuilt(self.result, iter([out.b.extract_value(result, i) for i in range(count)]))


def free_function(module: ir.Module) -> ir.Function:
    """Return the C library's function that gives memory back."""
    found = module.globals.get('free')
    return found or ir.Function(
        module, ir.FunctionType(ir.VoidType(), [BYTE.as_pointer()]), 'free'
    )


def _rooms_of(x: Any) -> list[Any]:
    if isinstance(x, Array):
        return [x.room]
    return [room for item in x for room in _rooms_of(item)] if isinstance(x, Group) else []


class Program:
    """All functions of an entry.

    Attributes:
        module: LLVM's.
        used: the sources and constants from which they are made.
        count: functions so far.
        result: layout of the entry's result: nested lists, names of kinds, None.
    """

    def __init__(self, function: FunctionType, arguments: list[Any], name: str) -> None:
        self.module, self.used, self.count = ir.Module(function.__name__), Used(), 0
        self._instances: dict[Any, Instance] = {}
        self._being_made: list[Any] = []
        kind = ir.FunctionType(INDEX, [WORD.as_pointer(), WORD.as_pointer()])
        out = Emission(self.module, ir.Function(self.module, kind, name))
        words = count()
        args = [value_of(argument, words, out) for argument in arguments]
        result = at_run_time(self.call(out, function, args, {}))
        for i, value in enumerate(leaves(result)):
            place = out.b.gep(out.f.args[1], [ir.Constant(WORD, i)])
            out.b.store(_as_word(out, value), place)
        out.b.ret(ir.Constant(INDEX, 0))
        self.result = _layout(result)

    def inlined(
        self, out: Emission, function: FunctionType, args: list[Any], keywords: dict[str, Any]
    ) -> Any:
        """Translate a kernel where it is called."""
        return Frame(self, out, function).result(args, keywords)

    def call(
        self, out: Emission, function: FunctionType, args: list[Any], keywords: dict[str, Any]
    ) -> Any:
        """Call a kernel as a separate function."""
        bound = arguments_of(function, args, keywords)
        args = [at_run_time(bound[name]) for name in source_of(function).arguments]
        structure = tuple(described(arg) for arg in args)
        cells = tuple(id(cell.cell_contents) for cell in function.__closure__ or ())
        key = function.__code__, cells, structure
        if key not in self._instances:
            if key in self._being_made:
                raise KernelError(f'{function.__qualname__} calls itself')
            self._being_made.append(key)
            self._instances[key] = Instance(self, function, args)
            self._being_made.pop()
        return self._instances[key].called(out, [leaf for arg in args for leaf in leaves(arg)])


def value_of(structure: Any, words: Iterator[int], out: Emission) -> Any:
    """Emit code that reads an argument from its words; return its value in compiled code."""
    if structure is None:
        return None
    if isinstance(structure, Tuple):
        items = [value_of(item, words, out) for item in structure.items]
        return Group(items, structure.named)
    b, place = out.b, next(words)
    word = b.load(b.gep(out.f.args[0], [ir.Constant(WORD, place)]))
    if isinstance(structure, Rows):
        return _array_of(structure, word, place, out)
    if structure == 'float':
        return Value(FLOAT, b.bitcast(word, DOUBLE))
    if structure == 'bool':
        return Value(BOOL, b.trunc(word, BIT))
    return Value(UINT if structure == 'uint64' else INT, word)


def _array_of(structure: Rows, word: ir.Value, place: int, out: Emission) -> Array | Record:
    """Emit code that reads an array's object, whose address is a word.

    The entry returns the number of the word, counted from one, if the array does not fit.
    """
    b = out.b

    def of_object(offset: int, kind: ir.Type) -> ir.Value:
        at = b.add(word, ir.Constant(WORD, object.__basicsize__ + offset))
        return b.load(b.inttoptr(at, kind.as_pointer()))

    needed = ir.Constant(INDEX, NEEDED_FLAGS)
    fits = b.icmp_unsigned('==', b.and_(of_object(FLAGS, INDEX), needed), needed)
    with b.if_then(b.not_(fits), likely=False):
        b.ret(ir.Constant(INDEX, place + 1))
    dimensions = of_object(DIMENSIONS, WORD.as_pointer())
    shape = [b.load(b.gep(dimensions, [ir.Constant(WORD, i)])) for i in range(structure.ndim)]
    if structure.dtype.fields is None:
        kind = element(structure.dtype)
        return Array(kind, of_object(DATA, kind.stored.as_pointer()), shape)
    fields, data = fields_of(structure.dtype), of_object(DATA, BYTE.as_pointer())
    return Array(fields, data, shape) if structure.ndim else Record(fields, data)


def _as_word(out: Emission, value: ir.Value) -> ir.Value:
    if value.type == DOUBLE:
        return out.b.bitcast(value, WORD)
    if value.type == BIT:
        return out.b.zext(value, WORD)
    if isinstance(value.type, ir.PointerType):
        return out.b.ptrtoint(value, WORD)
    if value.type == WORD:
        return value
    raise KernelError(f'{value.type} cannot be returned to Python')


def _layout(x: Any) -> Any:
    """Return the layout with which a result is made from words."""
    if isinstance(x, Value):
        return x.kind.name
    if isinstance(x, Group):
        return [_layout(item) for item in x]
    if isinstance(x, Array):
        return {'array': x.kind.name, 'ndim': len(x.shape)}
    if x is None:
        return None
    raise KernelError(f'{x!r} cannot be returned to Python')
