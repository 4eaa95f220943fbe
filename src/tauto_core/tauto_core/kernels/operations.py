"""Operators on values that are known when compiling, and on those known at run time."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir

from tauto_core.kernels.emission import Emission
from tauto_core.kernels.errors import KernelError
from tauto_core.kernels.values import (
    BOOL,
    DOUBLE,
    FLOAT,
    INT,
    UINT,
    WORD,
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


def _whole(op: type, x: Value, y: Value) -> Kind:
    """Return the kind of the result of an operator on two whole numbers."""
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
