"""Operators, and the functions of Python, math and NumPy that kernels may call."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir

from tauto_core.kernels.emission import Emission
from tauto_core.kernels.errors import KernelError
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
    Group,
    Kind,
    Value,
    at_run_time,
    described,
    is_number,
    is_static,
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
    """Return what an operator makes of two values, but for powers of run-time exponents."""
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


def _whole(op: type, x: Value, y: Value) -> Kind:
    """Return the kind that an operator makes of two whole numbers."""
    if any(each.kind not in (INT, UINT, BOOL) for each in (x, y)) or op not in STATIC:
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


def _divided(out: Emission, op: type, kind: Kind, a: ir.Value, c: ir.Value) -> ir.Value:
    """Return the floor of a quotient, or its remainder; 0 if divided by 0, as NumPy has it."""
    b = out.b
    known = isinstance(c, ir.Constant) and c.constant != 0
    nothing = b.icmp_signed('==', c, _ZERO)
    by = c if known else b.select(nothing, ir.Constant(WORD, 1), c)
    if kind is UINT:
        result = (b.udiv if op is ast.FloorDiv else b.urem)(a, by)
    else:
        quotient, rest = b.sdiv(a, by), b.srem(a, by)
        apart = b.icmp_signed('<', b.xor(rest, by), _ZERO)
        off = b.and_(b.icmp_signed('!=', rest, _ZERO), apart)
        if op is ast.FloorDiv:
            result = b.sub(quotient, b.zext(off, WORD))
        else:
            result = b.add(rest, b.select(off, by, _ZERO))
    return result if known else b.select(nothing, _ZERO, result)


def whole_power(out: Emission, x: Any, n: int) -> Any:
    """Return x to a power known when compiling, by repeated squaring."""
    if is_number(x):
        return x**n
    x = at_run_time(x)
    if not isinstance(x, Value) or x.kind not in (FLOAT, INT) or (n < 0 and x.kind is INT):
        raise KernelError(f'power {n} of {described(x)}')
    multiply = out.b.fmul if x.kind is FLOAT else out.b.mul
    square, result, left = x.ir, None, abs(n)
    while left:
        if left & 1:
            result = square if result is None else multiply(result, square)
        left >>= 1
        if left:
            square = multiply(square, square)
    if result is None:
        return 1.0 if x.kind is FLOAT else 1
    one = ir.Constant(DOUBLE, 1.0)
    return Value(x.kind, out.b.fdiv(one, result) if n < 0 else result)


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


def compare(out: Emission, op: Any, x: Any, y: Any) -> Any:
    """Return whether two values compare so."""
    if isinstance(op, (ast.Is, ast.IsNot)):
        return (x is y) == isinstance(op, ast.Is)
    if isinstance(op, (ast.In, ast.NotIn)):
        return (
            unary(out, ast.Not(), _within(out, x, y))
            if isinstance(op, ast.NotIn)
            else _within(out, x, y)
        )
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


def _within(out: Emission, x: Any, items: Any) -> Any:
    """Return whether a tuple holds a value."""
    result: Any = False
    for item in items:
        same = compare(out, ast.Eq(), x, item)
        if same is True or result is True:
            result = True
        elif same is not False:
            either = same.ir if result is False else out.b.or_(result.ir, same.ir)
            result = Value(BOOL, either)
    return result


# Functions. Each takes the emission, then the arguments.


def _float_function(name: str, plain: Callable[..., float]) -> Callable[..., Any]:
    """Return a function of floats, of LLVM or the C library."""

    def call(out: Emission, *args: Any) -> Any:
        if all(is_number(x) for x in args):
            try:
                return plain(*args)
            except (ValueError, OverflowError):
                pass  # at run time it is an infinity or no number
        return Value(FLOAT, out.external(name, DOUBLE, [out.float(x) for x in args]))

    return call


def _to_whole(name: str, plain: Callable[..., int]) -> Callable[..., Any]:
    def call(out: Emission, x: Any) -> Any:
        if is_number(x):
            return plain(x)
        if isinstance(x, Value) and x.kind in (INT, UINT):
            return x
        return Value(INT, out.b.fptosi(out.external(name, DOUBLE, [out.float(x)]), WORD))

    return call


def _extreme(sign: str, plain: Callable[..., Any]) -> Callable[..., Any]:
    """Return min or max: the first of equals, as Python has it."""

    def call(out: Emission, *args: Any) -> Any:
        args = tuple(args[0]) if len(args) == 1 else args
        if all(is_number(x) for x in args):
            return plain(args)
        given = [at_run_time(x) for x in args]
        if any(not isinstance(x, Value) or x.kind.lanes for x in given):
            raise KernelError(f'{plain.__name__} of {", ".join(described(x) for x in given)}')
        kept, b = given[0], out.b
        for x in given[1:]:
            if FLOAT in (kept.kind, x.kind):
                old, new = out.float(kept), out.float(x)
                kept = Value(FLOAT, b.select(b.fcmp_ordered(sign, new, old), new, old))
            else:
                old, new = out.int(kept), out.int(x)
                kept = Value(INT, b.select(b.icmp_signed(sign, new, old), new, old))
        return kept

    return call


def _abs(out: Emission, x: Any) -> Any:
    if is_number(x):
        return abs(x)
    if isinstance(x, Value) and x.kind is INT:
        below = out.b.icmp_signed('<', x.ir, _ZERO)
        return Value(INT, out.b.select(below, out.b.neg(x.ir), x.ir))
    return Value(FLOAT, out.external('llvm.fabs.f64', DOUBLE, [out.float(x)]))


def _as(kind: Kind, plain: Callable[[Any], Any]) -> Callable[..., Any]:
    def call(out: Emission, x: Any) -> Any:
        return plain(x) if is_number(x) else out.convert(x, kind)

    return call


def _bool(out: Emission, x: Any) -> Any:
    return out.truth(x)


def _len(_out: Emission, x: Any) -> Any:
    if isinstance(x, Array):
        return Value(INT, x.shape[0])
    if isinstance(x, Value):
        raise KernelError(f'{described(x)} has no length')
    return len(x)


def _isinstance(_out: Emission, x: Any, wanted: Any) -> bool:
    """Return what is known of a value's class: of NamedTuples, None and numbers."""
    classes = tuple(wanted) if isinstance(wanted, (tuple, Group)) else (wanted,)
    if isinstance(x, Group):
        return issubclass(x.instance_class or tuple, classes)
    if isinstance(x, Value):
        own = {FLOAT: float, INT: int, BOOL: bool}.get(x.kind)
        return own is not None and issubclass(own, classes)
    return isinstance(x, classes)


def _isfinite(out: Emission, x: Any) -> Any:
    if is_number(x):
        return math.isfinite(x)
    value = out.float(x)
    less = out.b.fsub(value, value)
    return Value(BOOL, out.b.fcmp_ordered('ord', less, less))


def _isnan(out: Emission, x: Any) -> Any:
    if is_number(x):
        return math.isnan(x)
    value = out.float(x)
    return Value(BOOL, out.b.fcmp_unordered('uno', value, value))


ALIGNED = 64
"""Rooms begin at cache lines; the address to give back stands in the word before."""


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
    malloc = out.module.globals.get('malloc')
    if malloc is None:
        malloc = ir.Function(out.module, ir.FunctionType(address, [WORD]), 'malloc')
        malloc.return_value.attributes.add('noalias')
    whole = b.call(malloc, [b.add(size, ir.Constant(WORD, 8 + ALIGNED))])
    behind = b.add(b.ptrtoint(whole, WORD), ir.Constant(WORD, 8 + ALIGNED - 1))
    first = b.and_(behind, ir.Constant(WORD, -ALIGNED))
    kept = b.inttoptr(b.sub(first, ir.Constant(WORD, 8)), address.as_pointer())
    b.store(whole, kept)
    out.rooms.append(whole)
    data = b.inttoptr(first, kind.stored.as_pointer())
    return Array(kind, data, dims, whole)


def _empty_like(out: Emission, x: Array) -> Array:
    if not isinstance(x, Array):
        raise KernelError(f'empty_like of {described(x)}')
    kinds = {FLOAT: np.float64, INT: np.int64, UINT: np.uint64, BOOL: np.bool_}
    return _empty(out, tuple(Value(INT, n) for n in x.shape), kinds[x.kind])


FUNCTIONS: dict[Any, Callable[..., Any]] = {
    abs: _abs,
    bool: _bool,
    float: _as(FLOAT, float),
    int: _as(INT, int),
    isinstance: _isinstance,
    len: _len,
    max: _extreme('>', max),
    min: _extreme('<', min),
    round: _to_whole('llvm.rint.f64', round),
    math.ceil: _to_whole('llvm.ceil.f64', math.ceil),
    math.floor: _to_whole('llvm.floor.f64', math.floor),
    math.isfinite: _isfinite,
    math.isnan: _isnan,
    np.empty: _empty,
    np.empty_like: _empty_like,
    np.float64: _as(FLOAT, float),
    np.int64: _as(INT, int),
    np.uint64: _as(UINT, np.uint64),
}
for _name in ('sqrt', 'sin', 'cos', 'exp', 'log'):
    _plain = getattr(math, _name)
    FUNCTIONS[_plain] = _float_function(f'llvm.{_name}.f64', _plain)
FUNCTIONS[math.copysign] = _float_function('llvm.copysign.f64', math.copysign)
for _name in ('tan', 'asin', 'acos', 'atan', 'sinh', 'cosh', 'tanh', 'asinh', 'acosh', 'atanh'):
    FUNCTIONS[getattr(math, _name)] = _float_function(_name, getattr(math, _name))
for _name in ('atan2', 'hypot', 'fmod'):
    FUNCTIONS[getattr(math, _name)] = _float_function(_name, getattr(math, _name))
for _name in ('expm1', 'log1p', 'erf', 'erfc'):
    FUNCTIONS[getattr(math, _name)] = _float_function(_name, getattr(math, _name))


def power_at_run_time(a: float, n: int) -> float:
    """Return a to a whole power: a kernel, translated where the exponent is not known."""
    left = -n if n < 0 else n
    result = 1.0
    while left != 0:
        if left & 1:
            result *= a
        left >>= 1
        a *= a
    return 1.0 / result if n < 0 else result


def place_right_of(values: Any, x: float, side: str) -> int:
    """Return where x would stand in sorted values, behind its equals: np.searchsorted."""
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
