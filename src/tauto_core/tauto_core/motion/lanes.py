"""Eight doubles as one number: the values at the stages of a step, for numba.

`Lanes` exist in compiled code only. They add, subtract, multiply, divide and negate, with each
other and with floats, so that one formula serves a stage vector and a single state. LLVM makes
of them what the machine has: one AVX-512 register, two of AVX2, four of SSE2 or NEON. No
operation is reordered or fused but where `fma` says so: the bits are the same everywhere.

Source: the low-level extension API of numba (types, models, `lower_builtin`, `intrinsic`).
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

SIZE = 8
_DOUBLE = ir.DoubleType()
_INDEX = ir.IntType(32)
_VECTOR = ir.VectorType(_DOUBLE, SIZE)


def _built(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make an intrinsic whose calls carry no types: numba leaves out the first argument."""
    made: Callable[..., Any] = intrinsic(function)
    return made


class _LanesType(types.Type):
    def __init__(self) -> None:
        super().__init__(name=f'Lanes{SIZE}')


LANES = _LanesType()


@register_model(_LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


def _shuffled(builder: Any, a: Any, b: Any, order: list[int]) -> Any:
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_INDEX, len(order)), order))


def _splat(builder: Any, x: Any) -> Any:
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(nothing, x, ir.Constant(_INDEX, 0))
    return _shuffled(builder, first, nothing, [0] * SIZE)


def _lower(operation: Any, method: str, kinds: tuple[Any, Any]) -> None:
    @lower_builtin(operation, *kinds)
    def _(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        pair = [
            arg if kind is LANES else _splat(builder, arg)
            for arg, kind in zip(args, kinds, strict=True)
        ]
        return getattr(builder, method)(*pair)


def _register(operation: Any, method: str) -> None:
    """Let an operator take lanes with lanes or floats."""

    @infer_global(operation)
    class Operator(AbstractTemplate):
        def generic(self, args: Any, _kws: Any) -> Any:
            if len(args) != 2 or LANES not in args:
                return None
            if not all(arg is LANES or isinstance(arg, types.Number) for arg in args):
                return None
            kinds = (LANES if arg is LANES else types.float64 for arg in args)
            return signature(LANES, *kinds)

    for kinds in ((LANES, LANES), (LANES, types.float64), (types.float64, LANES)):
        _lower(operation, method, kinds)


for _operation, _method in (
    (operator.add, 'fadd'),
    (operator.sub, 'fsub'),
    (operator.mul, 'fmul'),
    (operator.truediv, 'fdiv'),
):
    _register(_operation, _method)


@infer_global(operator.neg)
class _Negation(AbstractTemplate):
    def generic(self, args: Any, _kws: Any) -> Any:
        return signature(LANES, LANES) if tuple(args) == (LANES,) else None


@lower_builtin(operator.neg, LANES)
def _negate(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
    return builder.fneg(args[0])


def _data(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    if isinstance(kind, types.CPointer):
        return array
    return context.make_array(kind)(context, builder, array).data


@_built
def pointer(_typing: Any, array: Any) -> Any:
    """Return where the numbers of a C-contiguous array are: one word to hand on instead of many.

    A pointer can be indexed like a flat array. The array must live as long; so it does where a
    caller from Python holds it.
    """

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _data(context, builder, sig.args[0], args[0])

    return types.CPointer(array.dtype)(array), build


def _row_pointer(context: Any, builder: Any, kind: Any, array: Any, row: Any) -> Any:
    data = _data(context, builder, kind, array)
    first = builder.mul(row, ir.Constant(row.type, SIZE))
    return builder.bitcast(builder.gep(data, [first]), _VECTOR.as_pointer())


@_built
def load(_typing: Any, array: Any, row: Any) -> Any:
    """Return row `row` of 8 numbers of a C-contiguous float array, or of a pointer."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        pointer = _row_pointer(context, builder, sig.args[0], *args)
        return builder.load(pointer, align=8)

    return LANES(array, types.int64), build


@_built
def store(_typing: Any, array: Any, row: Any, lanes: Any) -> Any:
    """Write lanes to row `row` of 8 numbers of a C-contiguous float array, or of a pointer."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        pointer = _row_pointer(context, builder, sig.args[0], *args[:2])
        builder.store(args[2], pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, types.int64, LANES), build


@_built
def splat(_typing: Any, x: Any) -> Any:
    """Return the same number in all lanes."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return _splat(builder, args[0])

    return LANES(types.float64), build


@_built
def lane(_typing: Any, lanes: Any, i: Any) -> Any:
    """Return lane i."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return builder.extract_element(args[0], builder.trunc(args[1], _INDEX))

    return types.float64(LANES, types.int64), build


@_built
def with_lane(_typing: Any, lanes: Any, i: Any, x: Any) -> Any:
    """Return the lanes with lane i replaced."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return builder.insert_element(args[0], args[2], builder.trunc(args[1], _INDEX))

    return LANES(LANES, types.int64, types.float64), build


def _call(builder: Any, name: str, result: Any, args: list[Any]) -> Any:
    kind = ir.FunctionType(result, [arg.type for arg in args])
    function = cgutils.get_or_insert_function(builder.module, kind, name)
    return builder.call(function, args)


@_built
def fma(_typing: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a·b + c, rounded once; lanes where any of them is lanes, else a float."""
    kinds = [kind if kind is LANES else types.float64 for kind in (a, b, c)]
    whole = LANES in kinds

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        if not whole:
            return _call(builder, 'llvm.fma.f64', _DOUBLE, list(args))
        spread = [
            arg if kind is LANES else _splat(builder, arg)
            for arg, kind in zip(args, kinds, strict=True)
        ]
        return _call(builder, f'llvm.fma.v{SIZE}f64', _VECTOR, spread)

    return (LANES if whole else types.float64)(*kinds), build


@_built
def root(_typing: Any, x: Any) -> Any:
    """Return the square root, correctly rounded: lanes of lanes, a float of a float."""
    kind = x if x is LANES else types.float64

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        name, result = (f'v{SIZE}f64', _VECTOR) if kind is LANES else ('f64', _DOUBLE)
        return _call(builder, f'llvm.sqrt.{name}', result, list(args))

    return kind(kind), build


@_built
def largest(_typing: Any, lanes: Any) -> Any:
    """Return the largest magnitude of the lanes; NaNs may be passed over."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        size = _call(builder, f'llvm.fabs.v{SIZE}f64', _VECTOR, [args[0]])
        return _folded(builder, size, lambda a, b: _larger(builder, a, b))

    return types.float64(LANES), build


def _larger(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered('>', a, b), a, b)


def _smaller(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered('<', a, b), a, b)


def _folded(builder: Any, vector: Any, pair: Callable[[Any, Any], Any]) -> Any:
    """Fold halves onto each other until one number is left: the same order everywhere."""
    count = SIZE
    while count > 1:
        count //= 2
        low = _shuffled(builder, vector, vector, list(range(count)))
        high = _shuffled(builder, vector, vector, list(range(count, 2 * count)))
        vector = pair(low, high)
    return builder.extract_element(vector, ir.Constant(_INDEX, 0))


@_built
def negative(_typing: Any, lanes: Any) -> Any:
    """Return which lanes are below zero, a bit each, the first lane in the lowest."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        below = builder.fcmp_ordered('<', args[0], ir.Constant(_VECTOR, [0.0] * SIZE))
        return builder.zext(builder.bitcast(below, ir.IntType(SIZE)), ir.IntType(64))

    return types.int64(LANES), build


@_built
def ones(_typing: Any, bits: Any) -> Any:
    """Return how many bits are set."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return builder.ctpop(args[0])

    return types.int64(types.int64), build


@_built
def larger(_typing: Any, a: Any, b: Any) -> Any:
    """Return the larger magnitude of two, lane by lane."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        sizes = [_call(builder, f'llvm.fabs.v{SIZE}f64', _VECTOR, [arg]) for arg in args]
        return _larger(builder, *sizes)

    return LANES(LANES, LANES), build


@_built
def least(_typing: Any, lanes: Any) -> Any:
    """Return the least of the lanes; NaNs may be passed over."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return _folded(builder, args[0], lambda a, b: _smaller(builder, a, b))

    return types.float64(LANES), build


@_built
def total(_typing: Any, lanes: Any) -> Any:
    """Return the sum of the lanes."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return _folded(builder, args[0], builder.fadd)

    return types.float64(LANES), build
