"""The functions of Python, math and NumPy that kernels may call.

Each takes the emission, then the arguments.
"""

from __future__ import annotations

import math
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
)


def _float_function(name: str) -> Callable[..., Any]:
    """Return a function of floats, of LLVM or the C library."""

    def call(out: Emission, *args: Any) -> Any:
        return Value(FLOAT, out.external(name, DOUBLE, [out.float(x) for x in args]))

    return call


def _to_whole(name: str) -> Callable[..., Any]:
    """Return a function that rounds a float to a whole number."""

    def call(out: Emission, x: Any) -> Any:
        x = at_run_time(x)
        if isinstance(x, Value) and x.kind in (INT, UINT):
            return x
        return Value(INT, out.b.fptosi(out.external(name, DOUBLE, [out.float(x)]), WORD))

    return call


def _extreme(sign: str) -> Callable[..., Any]:
    """Return min or max: the first of equals, as Python has it."""

    def call(out: Emission, *args: Any) -> Any:
        args = tuple(args[0]) if len(args) == 1 else args
        given = [at_run_time(x) for x in args]
        if any(not isinstance(x, Value) or x.kind.lanes for x in given):
            raise KernelError(f'min or max of {", ".join(described(x) for x in given)}')
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
        below = out.b.icmp_signed('<', x.ir, ir.Constant(WORD, 0))
        return Value(INT, out.b.select(below, out.b.neg(x.ir), x.ir))
    return Value(FLOAT, out.external('llvm.fabs.f64', DOUBLE, [out.float(x)]))


def _as(kind: Kind, plain: Callable[[Any], Any]) -> Callable[..., Any]:
    def call(out: Emission, x: Any) -> Any:
        return plain(x) if is_number(x) else out.convert(x, kind)

    return call


def _len(_out: Emission, x: Any) -> Any:
    if isinstance(x, Array):
        return Value(INT, x.shape[0])
    if isinstance(x, Value):
        raise KernelError(f'{described(x)} has no length')
    return len(x)


def _isinstance(_out: Emission, x: Any, wanted: Any) -> bool:
    """Return what is known about a value's class: for NamedTuples, None and numbers."""
    classes = tuple(wanted) if isinstance(wanted, (tuple, Group)) else (wanted,)
    if isinstance(x, Group):
        return issubclass(x.instance_class or tuple, classes)
    if isinstance(x, Value):
        own = {FLOAT: float, INT: int, BOOL: bool}.get(x.kind)
        return own is not None and issubclass(own, classes)
    return isinstance(x, classes)


def _isfinite(out: Emission, x: Any) -> Any:
    value = out.float(x)
    less = out.b.fsub(value, value)
    return Value(BOOL, out.b.fcmp_ordered('ord', less, less))


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
    bool: Emission.truth,
    float: _as(FLOAT, float),
    int: _as(INT, int),
    isinstance: _isinstance,
    len: _len,
    max: _extreme('>'),
    min: _extreme('<'),
    round: _to_whole('llvm.rint.f64'),
    math.ceil: _to_whole('llvm.ceil.f64'),
    math.floor: _to_whole('llvm.floor.f64'),
    math.isfinite: _isfinite,
    np.empty: _empty,
    np.empty_like: _empty_like,
    np.float64: _as(FLOAT, float),
    np.int64: _as(INT, int),
    np.uint64: _as(UINT, np.uint64),
}
for _name in ('sqrt', 'sin', 'cos', 'exp', 'log', 'copysign'):
    FUNCTIONS[getattr(math, _name)] = _float_function(f'llvm.{_name}.f64')
for _name in (
    *('tan', 'asin', 'acos', 'atan', 'atan2', 'hypot', 'expm1', 'log1p'),
    *('sinh', 'cosh', 'tanh', 'asinh', 'acosh', 'atanh'),
):
    FUNCTIONS[getattr(math, _name)] = _float_function(_name)


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
