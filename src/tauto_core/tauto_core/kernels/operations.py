"""Operators, functions of Python and NumPy, items, and phi nodes, as instructions of LLVM."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from llvmlite import ir

from tauto_core.kernels.marks import KernelError
from tauto_core.kernels.values import (
    BOOL,
    BYTE,
    DOUBLE,
    ELEMENTS,
    FLOAT,
    INT,
    UINT,
    WORD,
    Array,
    Conflict,
    Emission,
    Fields,
    Group,
    NumberKind,
    Pointer,
    Record,
    Value,
    at_run_time,
    described,
    is_number,
    is_static,
    leaves,
    rebuilt,
)

STATIC: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
_FLOATS: dict[type, str] = {ast.Add: 'fadd', ast.Sub: 'fsub', ast.Mult: 'fmul', ast.Div: 'fdiv'}
_INTS: dict[type, str] = {
    ast.Add: 'add',
    ast.Sub: 'sub',
    ast.Mult: 'mul',
    ast.LShift: 'shl',
    ast.RShift: 'ashr',
    ast.BitAnd: 'and_',
    ast.BitOr: 'or_',
    ast.BitXor: 'xor',
}
_SIGNS: dict[type, str] = {
    ast.Eq: '==',
    ast.NotEq: '!=',
    ast.Lt: '<',
    ast.LtE: '<=',
    ast.Gt: '>',
    ast.GtE: '>=',
}
_ZERO = ir.Constant(WORD, 0)


def binary(out: Emission, op: type, x: Any, y: Any) -> Any:
    """Return the result of an operator on two values, except powers with run-time exponents."""
    if isinstance(x, Group) and isinstance(y, Group) and op is ast.Add:
        return Group(x.items + y.items)
    if is_number(x) and is_number(y) and not (op in (ast.Div, ast.FloorDiv, ast.Mod) and y == 0):
        return STATIC[op](x, y)
    x, y = at_run_time(x), at_run_time(y)
    if not isinstance(x, Value) or not isinstance(y, Value):
        raise KernelError(f'{op.__name__} of {described(x)} and {described(y)}')
    b, lanes = out.b, x.kind.lanes or y.kind.lanes
    if lanes:
        kind = x.kind if x.kind.lanes else y.kind
        if op not in _FLOATS or {x.kind.lanes, y.kind.lanes} - {0, lanes}:
            raise KernelError(f'{op.__name__} of {x.kind} and {y.kind}')
        pair = out.convert(x, kind).ir, out.convert(y, kind).ir
        return Value(kind, getattr(b, _FLOATS[op])(*pair))
    if op is ast.Div or FLOAT in (x.kind, y.kind):
        if op not in _FLOATS:
            raise KernelError(f'{op.__name__} of {x.kind} and {y.kind}')
        return Value(FLOAT, getattr(b, _FLOATS[op])(out.float(x), out.float(y)))
    if x.kind is BOOL and y.kind is BOOL and op in (ast.BitAnd, ast.BitOr, ast.BitXor):
        return Value(BOOL, getattr(b, _INTS[op])(x.ir, y.ir))
    kind = _whole(op, x, y)
    a, c = out.int(x), out.int(y)
    if op in (ast.FloorDiv, ast.Mod):
        return Value(kind, _divided(out, op, kind, a, c))
    name = 'lshr' if op is ast.RShift and kind is UINT else _INTS[op]
    return Value(kind, getattr(b, name)(a, c))


def _whole(op: type, x: Value, y: Value) -> NumberKind:
    """Return the kind of the result of an operator on two whole numbers."""
    if any(v.kind not in (INT, UINT, BOOL) for v in (x, y)) or op not in STATIC:
        raise KernelError(f'{op.__name__} of {x.kind} and {y.kind}')
    if op in (ast.LShift, ast.RShift):
        return UINT if x.kind is UINT else INT
    if UINT not in (x.kind, y.kind):
        return INT
    if x.kind is not y.kind:
        raise KernelError(
            f'{op.__name__} of {x.kind} and {y.kind}: say which it shall be by np.int64 or '
            'np.uint64'
        )
    return UINT


def _divided(out: Emission, op: type, kind: NumberKind, a: ir.Value, c: ir.Value) -> ir.Value:
    """Return the floor of a quotient, or its remainder. Division by 0 gives 0, as in NumPy."""
    b = out.b
    is_nonzero = isinstance(c, ir.Constant) and c.constant != 0
    nothing = b.icmp_signed('==', c, _ZERO)
    by = c if is_nonzero else b.select(nothing, ir.Constant(WORD, 1), c)
    if kind is UINT:
        result = (b.udiv if op is ast.FloorDiv else b.urem)(a, by)
    else:
        quotient, remainder = b.sdiv(a, by), b.srem(a, by)
        signs_differ = b.icmp_signed('<', b.xor(remainder, by), _ZERO)
        off = b.and_(b.icmp_signed('!=', remainder, _ZERO), signs_differ)
        if op is ast.FloorDiv:
            result = b.sub(quotient, b.zext(off, WORD))
        else:
            result = b.add(remainder, b.select(off, by, _ZERO))
    return result if is_nonzero else b.select(nothing, _ZERO, result)


def whole_power(out: Emission, x: Any, n: int) -> Any:
    """Return x to a constant power, by repeated squaring."""
    if is_number(x):
        return x**n
    x = at_run_time(x)
    if not isinstance(x, Value) or x.kind not in (FLOAT, INT) or (n < 0 and x.kind is INT):
        raise KernelError(f'power {n} of {described(x)}')
    multiply = out.b.fmul if x.kind is FLOAT else out.b.mul
    square, result, power = x.ir, None, abs(n)
    while power:
        if power & 1:
            result = square if result is None else multiply(result, square)
        power >>= 1
        if power:
            square = multiply(square, square)
    if result is None:
        return 1.0 if x.kind is FLOAT else 1
    unity = ir.Constant(DOUBLE, 1.0)
    return Value(x.kind, out.b.fdiv(unity, result) if n < 0 else result)


def power_at_run_time(a: float, n: int) -> float:
    """Return a to a whole power: a kernel, translated for run-time exponents."""
    power = -n if n < 0 else n
    result = 1.0
    while power != 0:
        if power & 1:
            result *= a
        power >>= 1
        a *= a
    return 1.0 / result if n < 0 else result


def unary(out: Emission, op: Any, x: Any) -> Any:
    """Return not x, −x, +x or ~x."""
    if isinstance(op, ast.Not):
        truth = out.truth(x)
        return (not truth) if isinstance(truth, bool) else Value(BOOL, out.b.not_(truth.ir))
    if is_number(x):
        return -x if isinstance(op, ast.USub) else ~x if isinstance(op, ast.Invert) else +x
    x = at_run_time(x)
    if isinstance(x, Value):
        if isinstance(op, ast.UAdd):
            return x
        if isinstance(op, ast.Invert) and x.kind in (INT, UINT):
            return Value(x.kind, out.b.not_(x.ir))
        if isinstance(op, ast.USub):
            if x.kind is FLOAT or x.kind.lanes:
                return Value(x.kind, out.b.fneg(x.ir))
            if x.kind in (INT, UINT):
                return Value(x.kind, out.b.neg(x.ir))
    raise KernelError(f'{type(op).__name__} of {described(x)}')


def compared(out: Emission, op: Any, x: Any, y: Any) -> Any:
    """Return the result of a comparison of two values."""
    if isinstance(op, (ast.Is, ast.IsNot)):
        return (x is y) == isinstance(op, ast.Is)
    if type(op) not in _SIGNS:
        raise KernelError(f'kernels know no {type(op).__name__}. Compare with each item')
    if is_static(x) and is_static(y):
        return STATIC[type(op)](x, y)
    x, y = at_run_time(x), at_run_time(y)
    if not isinstance(x, Value) or not isinstance(y, Value) or x.kind.lanes or y.kind.lanes:
        raise KernelError(f'{described(x)} and {described(y)} are compared')
    sign = _SIGNS[type(op)]
    if FLOAT in (x.kind, y.kind):
        test = out.b.fcmp_unordered if sign == '!=' else out.b.fcmp_ordered
        return Value(BOOL, test(sign, out.float(x), out.float(y)))
    if UINT in (x.kind, y.kind):
        if x.kind is not y.kind:
            raise KernelError(f'{x.kind} and {y.kind} are compared')
        return Value(BOOL, out.b.icmp_unsigned(sign, x.ir, y.ir))
    return Value(BOOL, out.b.icmp_signed(sign, out.int(x), out.int(y)))


# -----------------------------------------------------------------------------
# The functions of Python, math and NumPy that kernels may call.
#
# Each takes the emission, then the arguments.


def _float_function(name: str, out: Emission, *args: Any) -> Any:
    """Call a function of floats, of LLVM or the C library."""
    return Value(FLOAT, out.external(name, DOUBLE, [out.float(x) for x in args]))


def _to_whole(name: str, out: Emission, x: Any) -> Any:
    """Round a float to a whole number."""
    x = at_run_time(x)
    if isinstance(x, Value) and x.kind in (INT, UINT):
        return x
    return Value(INT, out.b.fptosi(out.external(name, DOUBLE, [out.float(x)]), WORD))


def _extreme(sign: str, out: Emission, *args: Any) -> Any:
    """Return min or max: the first of equals, as in Python."""
    args = tuple(args[0]) if len(args) == 1 else args
    values = [at_run_time(x) for x in args]
    if any(not isinstance(x, Value) or x.kind.lanes for x in values):
        raise KernelError(f'min or max of {", ".join(described(x) for x in values)}')
    best, b = values[0], out.b
    for x in values[1:]:
        if FLOAT in (best.kind, x.kind):
            old, new = out.float(best), out.float(x)
            best = Value(FLOAT, b.select(b.fcmp_ordered(sign, new, old), new, old))
        else:
            old, new = out.int(best), out.int(x)
            best = Value(INT, b.select(b.icmp_signed(sign, new, old), new, old))
    return best


def _abs(out: Emission, x: Any) -> Any:
    if is_number(x):
        return abs(x)
    if isinstance(x, Value) and x.kind is INT:
        below = out.b.icmp_signed('<', x.ir, ir.Constant(WORD, 0))
        return Value(INT, out.b.select(below, out.b.neg(x.ir), x.ir))
    return Value(FLOAT, out.external('llvm.fabs.f64', DOUBLE, [out.float(x)]))


def _as(kind: NumberKind, plain: Callable[[Any], Any], out: Emission, x: Any) -> Any:
    return plain(x) if is_number(x) else out.convert(x, kind)


def _len(_out: Emission, x: Any) -> Any:
    if isinstance(x, Array):
        return Value(INT, x.shape[0])
    if isinstance(x, Value):
        raise KernelError(f'{described(x)} has no length')
    return len(x)


def _isinstance(_out: Emission, x: Any, wanted: Any) -> bool:
    """Return the class test of a value: of a NamedTuple, `None` or a number."""
    classes = tuple(wanted) if isinstance(wanted, (tuple, Group)) else (wanted,)
    if isinstance(x, Group):
        return issubclass(x.instance_class or tuple, classes)
    if isinstance(x, Value):
        python_type = {FLOAT: float, INT: int, BOOL: bool}.get(x.kind)
        return python_type is not None and issubclass(python_type, classes)
    return isinstance(x, classes)


def _isfinite(out: Emission, x: Any) -> Any:
    value = out.float(x)
    zero = out.b.fsub(value, value)
    return Value(BOOL, out.b.fcmp_ordered('ord', zero, zero))


ALIGNED = 64
"""Alignment of allocated memory, a cache line. The word before it holds malloc's address."""


def _empty(out: Emission, shape: Any, dtype: Any = np.float64) -> Array:
    if out.depth:
        raise KernelError('an array is made in a branch or a loop: make it at the beginning')
    lengths = shape if isinstance(shape, (tuple, Group)) else (shape,)
    b, kind = out.b, ELEMENTS.get(np.dtype(dtype).str[1:])
    if kind is None:
        raise KernelError(f'kernels know no arrays of {dtype}')
    dims = [out.int(length) for length in lengths]
    size = ir.Constant(WORD, 1 if kind is BOOL else 8)
    for length in dims:
        size = b.mul(size, length)
    address = BYTE.as_pointer()
    malloc = out.function('malloc', address, [WORD])
    malloc.return_value.attributes.add('noalias')
    room = b.call(malloc, [b.add(size, ir.Constant(WORD, 8 + ALIGNED))])
    behind = b.add(b.ptrtoint(room, WORD), ir.Constant(WORD, 8 + ALIGNED - 1))
    begin = b.and_(behind, ir.Constant(WORD, -ALIGNED))
    header = b.inttoptr(b.sub(begin, ir.Constant(WORD, 8)), address.as_pointer())
    b.store(room, header)
    out.rooms.append(room)
    data = b.inttoptr(begin, kind.stored.as_pointer())
    return Array(kind, data, dims, room)


def _empty_like(out: Emission, x: Array) -> Array:
    if not isinstance(x, Array):
        raise KernelError(f'empty_like of {described(x)}')
    kinds = {FLOAT: np.float64, INT: np.int64, UINT: np.uint64, BOOL: np.bool_}
    return _empty(out, tuple(Value(INT, n) for n in x.shape), kinds[x.kind])


FUNCTIONS: dict[Any, Callable[..., Any]] = {
    abs: _abs,
    bool: Emission.truth,
    float: partial(_as, FLOAT, float),
    int: partial(_as, INT, int),
    isinstance: _isinstance,
    len: _len,
    max: partial(_extreme, '>'),
    min: partial(_extreme, '<'),
    round: partial(_to_whole, 'llvm.rint.f64'),
    math.ceil: partial(_to_whole, 'llvm.ceil.f64'),
    math.floor: partial(_to_whole, 'llvm.floor.f64'),
    math.isfinite: _isfinite,
    np.empty: _empty,
    np.empty_like: _empty_like,
    np.float64: partial(_as, FLOAT, float),
    np.int64: partial(_as, INT, int),
    np.uint64: partial(_as, UINT, np.uint64),
}
_LLVM = 'sqrt', 'sin', 'cos', 'exp', 'log', 'copysign'
for _name in (
    *(*_LLVM, 'tan', 'asin', 'acos', 'atan', 'atan2', 'hypot', 'expm1', 'log1p'),
    *('sinh', 'cosh', 'tanh', 'asinh', 'acosh', 'atanh'),
):
    _symbol = f'llvm.{_name}.f64' if _name in _LLVM else _name
    FUNCTIONS[getattr(math, _name)] = partial(_float_function, _symbol)


def place_right_of(values: Any, x: float, side: str) -> int:
    """Return the insertion point of x in sorted values, after its equals: np.searchsorted."""
    if side != 'right':
        raise TypeError("searchsorted of kernels knows the side 'right' only")
    low, high = 0, len(values)
    while low < high:
        middle = (low + high) >> 1
        if x < values[middle]:
            high = middle
        else:
            low = middle + 1
    return low


IN_PYTHON = {np.searchsorted: place_right_of}
"""Functions that are kernels themselves."""


# -----------------------------------------------------------------------------
# Items of tuples and arrays: their addresses, and parts of arrays.


def picked(out: Emission, items: Any, i: Any) -> Any:
    """Return an item of a tuple. For a run-time index all items must be of one kind."""
    if isinstance(i, (int, slice)):
        return items[i]
    values, b = [at_run_time(x) for x in items], out.b
    kinds = {x.kind if isinstance(x, Value) else None for x in values}
    if len(kinds) != 1 or None in kinds:
        raise KernelError(
            f'an item of {described(items)} is picked by a number known at run time only'
        )
    kind = values[0].kind
    # at the function's head: the room exists once, however often the loop runs
    with b.goto_block(out.f.blocks[0]):
        room = b.alloca(ir.ArrayType(kind.type, len(values)))
    for k, value in enumerate(values):
        b.store(value.ir, b.gep(room, [ir.Constant(WORD, 0), ir.Constant(WORD, k)]))
    place = b.gep(room, [ir.Constant(WORD, 0), out.int(i)])
    return Value(kind, b.load(place))


def item(out: Emission, base: Any, where: Any) -> Any:
    """Return an item of an array or behind a pointer, or a row or rows if indices are missing."""
    if isinstance(base, Array):
        if isinstance(where, slice):
            b, length = out.b, base.shape[0]
            stop = length if where.stop is None else _index(out, where.stop, length)
            if where.start is None:
                return Array(base.kind, base.data, [stop, *base.shape[1:]], base.room)
            start = _index(out, where.start, length)
            data = _rows(out, base, [Value(INT, start)]).data
            return Array(base.kind, data, [b.sub(stop, start), *base.shape[1:]])
        if len(where) < len(base.shape):
            return _rows(out, base, where)
    return out.load(*place_of(out, base, where))


def place_of(out: Emission, base: Any, where: list[Any]) -> tuple[ir.Value, Any]:
    """Return the address and kind of an item of an array, or behind a pointer."""
    if isinstance(base, Array) and len(where) == len(base.shape):
        return _at(out, base, _flat(out, base.shape, where)), base.kind
    if isinstance(base, Value) and isinstance(base.kind, Pointer) and len(where) == 1:
        return out.b.gep(base.ir, [out.int(where[0])]), base.kind.item
    raise KernelError(f'{described(base)} with {len(where)} indices')


def fill(out: Emission, part: Any, value: Any) -> None:
    """Set all items of a row to a number."""
    if not isinstance(part, Array) or len(part.shape) != 1:
        raise KernelError(f'{described(part)} cannot be filled')
    b, came = out.b, out.b.block
    value = out.convert(value, part.kind)
    head, body, leave = out.block('fill'), out.block('item'), out.block('filled')
    out.go_on([came], head)
    i = b.phi(WORD)
    b.cbranch(b.icmp_signed('<', i, part.shape[0]), body, leave)
    b.position_at_end(body)
    out.save(b.gep(part.data, [i]), part.kind, value)
    i.add_incoming(ir.Constant(WORD, 0), came)
    i.add_incoming(b.add(i, ir.Constant(WORD, 1)), body)
    out.go_on([body], head)
    b.position_at_end(leave)


def _rows(out: Emission, base: Array, where: list[Any]) -> Array:
    offset = _flat(out, base.shape, where)
    for n in base.shape[len(where) :]:
        offset = out.b.mul(offset, n)
    return Array(base.kind, _at(out, base, offset), base.shape[len(where) :])


def _at(out: Emission, base: Array, offset: ir.Value) -> ir.Value:
    if isinstance(base.kind, Fields):
        offset = out.b.mul(offset, ir.Constant(WORD, base.kind.dtype.itemsize))
    return out.b.gep(base.data, [offset])


def _flat(out: Emission, shape: Any, where: list[Any]) -> ir.Value:
    """Return the number of an item, counted through the rows."""
    b, offset = out.b, None
    for n, i in zip(shape, where, strict=False):
        place = _index(out, i, n)
        offset = place if offset is None else b.add(b.mul(offset, n), place)
    return offset if offset is not None else ir.Constant(WORD, 0)


def _index(out: Emission, i: Any, length: ir.Value) -> ir.Value:
    """Return an index as an LLVM integer. A constant one may count from the end."""
    if isinstance(i, int) and i < 0:
        return out.b.add(length, ir.Constant(WORD, int(i)))
    return out.int(i)


# -----------------------------------------------------------------------------
# Phi nodes: the values of variables at the join of branches, and in the header of a loop.

BackEdge: TypeAlias = Callable[[Any, ir.Block], None]
"""Adds a variable's value at the end of a round, in the block that jumps back."""


def joined(
    out: Emission, values: Sequence[Any], blocks: Sequence[ir.Block], target: ir.Block, name: str
) -> Any:
    """Return the value in `target` of a variable that differs between the preceding blocks.

    The blocks have no terminator yet: numbers can be converted there.
    """
    head = values[0]
    if all(_same(x, head) for x in values):
        return head
    if any(isinstance(x, Conflict) for x in values):
        return next(x for x in values if isinstance(x, Conflict))
    grouped = [group for group in map(_grouped, values) if group is not None]
    if len(grouped) == len(values) and all(_alike(g, grouped[0]) for g in grouped):
        columns = zip(*[g.items for g in grouped], strict=True)
        items = [joined(out, column, blocks, target, name) for column in columns]
        return Group(items, grouped[0].instance_class)
    if isinstance(head, (Array, Record)) and all(_alike(x, head) for x in values):
        columns = zip(*[leaves(x) for x in values], strict=True)
        result = rebuilt(head, iter([_phi(out, column, blocks, target) for column in columns]))
        if isinstance(head, Array) and all(x.room is head.room for x in values):
            result.room = head.room
        return result
    kind = common_kind(values)
    if kind is None:
        kinds = ' or '.join(dict.fromkeys(described(x) for x in values))
        return Conflict(f'{name} is {kinds}, by the way taken')
    converted = []
    for x, block in zip(values, blocks, strict=True):
        out.b.position_at_end(block)
        converted.append(out.convert(x, kind).ir)
    return Value(kind, _phi(out, converted, blocks, target))


def _phi(
    out: Emission, values: Sequence[ir.Value], blocks: Sequence[ir.Block], target: ir.Block
) -> ir.Value:
    if all(value is values[0] for value in values):
        return values[0]
    out.b.position_at_end(target)
    phi = out.b.phi(values[0].type)
    for value, block in zip(values, blocks, strict=True):
        phi.add_incoming(value, block)
    return phi


def meet(out: Emission, ends: Sequence[tuple[ir.Block, dict[str, Any]]]) -> dict[str, Any]:
    """Join several branches and return the variables after them."""
    if len(ends) == 1:
        out.b.position_at_end(ends[0][0])
        return ends[0][1]
    target, blocks = out.block('after'), [block for block, _ in ends]
    together: dict[str, Any] = {}
    for name in dict.fromkeys(name for _, variables in ends for name in variables):
        unset = Conflict(f'{name} may not have been set')
        values = [variables.get(name, unset) for _, variables in ends]
        together[name] = joined(out, values, blocks, target, name)
    out.go_on(blocks, target)
    return together


def carried(
    out: Emission, x: Any, name: str, preheader: ir.Block, header: ir.Block
) -> tuple[Any, BackEdge]:
    """Return a variable in the header of a loop, and a function to set its value after a round.

    Each number gets a phi node. Its kind is the kind before the loop, since the loop's end is not
    translated yet.
    """
    group = _grouped(x)
    if group is not None:
        pairs = [carried(out, item, name, preheader, header) for item in group]

        def from_group(end: Any, block: ir.Block) -> None:
            items = _grouped(end)
            if items is None or not _alike(items, group):
                raise _changed(name, group, end)
            for (_, from_item), item in zip(pairs, items, strict=True):
                from_item(item, block)

        return Group([item for item, _ in pairs], group.instance_class), from_group
    if not (isinstance(x, Value) or is_number(x)):
        why = (
            f'{name} is {described(x)} before a loop that sets it: loops carry numbers and tuples'
        )
        return Conflict(x.why if isinstance(x, Conflict) else why), lambda _x, _block: None
    begin: Value = at_run_time(x)
    out.b.position_at_end(header)
    phi = out.b.phi(begin.kind.type)
    phi.add_incoming(begin.ir, preheader)

    def from_number(end: Any, block: ir.Block) -> None:
        if common_kind([begin, end]) is not begin.kind:
            raise _changed(name, begin, end)
        out.b.position_at_end(block)
        phi.add_incoming(out.convert(end, begin.kind).ir, block)

    return Value(begin.kind, phi), from_number


def _changed(name: str, x: Any, end: Any) -> KernelError:
    return KernelError(
        f'{name} is {described(x)} before the loop and {described(end)} at its end. Give it one '
        'kind, for example 0.0 in place of 0, or use another name in the loop'
    )


def common_kind(values: Sequence[Any]) -> NumberKind | None:
    """Return the common kind of numbers: a float for a float and a whole number."""
    kinds: list[NumberKind] = []
    for x in values:
        if isinstance(x, Conflict) or not (isinstance(x, Value) or is_number(x)):
            return None
        kind = at_run_time(x).kind
        if kind not in kinds:
            kinds.append(kind)
    if len(kinds) == 1:
        return kinds[0]
    if all(kind in (FLOAT, INT, BOOL) for kind in kinds):
        return FLOAT if FLOAT in kinds else INT
    return None


def _same(x: Any, y: Any) -> bool:
    if x is y:
        return True
    if isinstance(x, Value) and isinstance(y, Value):
        return x.ir is y.ir and x.kind is y.kind
    if not (is_static(x) and is_static(y)) or type(x) is not type(y):
        return False
    return repr(x) == repr(y) if is_number(x) or isinstance(x, tuple) else False


def _grouped(x: Any) -> Group | None:
    if isinstance(x, tuple):
        return Group(x, type(x) if hasattr(x, '_fields') else None)
    return x if isinstance(x, Group) else None


def _alike(x: Any, y: Any) -> bool:
    """Return whether two tuples, arrays or records differ in their numbers only."""
    if isinstance(x, Group):
        return x.instance_class is y.instance_class and len(x) == len(y)
    if isinstance(x, Array) and isinstance(y, Array):
        return x.kind is y.kind and len(x.shape) == len(y.shape)
    return isinstance(x, Record) and isinstance(y, Record) and x.kind is y.kind
