"""Eight or sixteen doubles as one number: the values at the stages of a step, for numba.

`Lanes` exist in compiled code only. They add, subtract, multiply, divide and negate, with each
other and with floats, so that one formula serves a stage vector and a single state. LLVM makes
of eight what the machine has: one AVX-512 register, two of AVX2, four of SSE2 or NEON. No
operation is reordered or fused but where `fma` says so: the bits are the same everywhere.

Rows of an array, or of a `pointer`, are eight numbers long; those of a `wide_pointer` sixteen.

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

SIZE, WIDE_SIZE = 8, 16
_DOUBLE = ir.DoubleType()
_INDEX = ir.IntType(32)


def _built(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make an intrinsic whose calls carry no types: numba leaves out the first argument."""
    made: Callable[..., Any] = intrinsic(function)
    return made


class LanesType(types.Type):
    """So many doubles as one number; `vector` is LLVM's name for them."""

    def __init__(self, count: int) -> None:
        super().__init__(name=f'Lanes{count}')
        self.count = count
        self.vector = ir.VectorType(_DOUBLE, count)


class _WidePointer(types.CPointer):
    def __init__(self, dtype: Any) -> None:
        super().__init__(dtype)
        self.name = f'wide {dtype}*'


LANES, WIDE_LANES = LanesType(SIZE), LanesType(WIDE_SIZE)
register_model(_WidePointer)(models.PointerModel)


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, kind.vector)


def _is_lanes(kind: Any) -> bool:
    return isinstance(kind, LanesType)


def _lanes_in(rows: Any) -> LanesType:
    """Return what a row is: of an array, of a pointer, or of what is lanes itself."""
    if isinstance(rows, LanesType):
        return rows
    return WIDE_LANES if isinstance(rows, _WidePointer) else LANES


def _shuffled(builder: Any, a: Any, b: Any, order: list[int]) -> Any:
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_INDEX, len(order)), order))


def _splat(builder: Any, kind: LanesType, x: Any) -> Any:
    nothing = ir.Constant(kind.vector, ir.Undefined)
    first = builder.insert_element(nothing, x, ir.Constant(_INDEX, 0))
    return _shuffled(builder, first, nothing, [0] * kind.count)


def _lower(operation: Any, method: str, kinds: tuple[Any, Any], result: LanesType) -> None:
    @lower_builtin(operation, *kinds)
    def _(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        pair = [
            arg if kind is result else _splat(builder, result, arg)
            for arg, kind in zip(args, kinds, strict=True)
        ]
        return getattr(builder, method)(*pair)


def _register(operation: Any, method: str) -> None:
    """Let an operator take lanes with as many lanes, or with floats."""

    @infer_global(operation)
    class Operator(AbstractTemplate):
        def generic(self, args: Any, _kws: Any) -> Any:
            wide = [arg for arg in args if _is_lanes(arg)]
            if len(args) != 2 or not wide:
                return None
            if not all(arg is wide[0] or isinstance(arg, types.Number) for arg in args):
                return None
            kinds = (arg if arg is wide[0] else types.float64 for arg in args)
            return signature(wide[0], *kinds)

    for lanes in (LANES, WIDE_LANES):
        for kinds in ((lanes, lanes), (lanes, types.float64), (types.float64, lanes)):
            _lower(operation, method, kinds, lanes)


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
        return signature(args[0], args[0]) if len(args) == 1 and _is_lanes(args[0]) else None


@lower_builtin(operator.neg, LanesType)
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


@_built
def wide_pointer(_typing: Any, array: Any) -> Any:
    """Return a `pointer` whose rows are of sixteen numbers."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _data(context, builder, sig.args[0], args[0])

    return _WidePointer(array.dtype)(array), build


def _row_pointer(context: Any, builder: Any, kind: Any, array: Any, row: Any) -> Any:
    data, lanes = _data(context, builder, kind, array), _lanes_in(kind)
    first = builder.mul(row, ir.Constant(row.type, lanes.count))
    return builder.bitcast(builder.gep(data, [first]), lanes.vector.as_pointer())


def _loaded(context: Any, builder: Any, kind: Any, array: Any, row: Any) -> Any:
    return builder.load(_row_pointer(context, builder, kind, array, row), align=8)


@_built
def load(_typing: Any, array: Any, row: Any) -> Any:
    """Return row `row` of a C-contiguous float array, or of a pointer."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _loaded(context, builder, sig.args[0], *args)

    return _lanes_in(array)(array, types.int64), build


@_built
def store(_typing: Any, array: Any, row: Any, lanes: Any) -> Any:
    """Write lanes to row `row` of a C-contiguous float array, or of a pointer."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        pointer = _row_pointer(context, builder, sig.args[0], *args[:2])
        builder.store(args[2], pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, types.int64, _lanes_in(array)), build


def _combined(context: Any, builder: Any, kind: Any, args: Any, many: tuple[Any, ...]) -> list[Any]:
    """Sum rows with each of several weights, each row read once."""
    lanes = _lanes_in(kind)
    name = f'llvm.fma.v{lanes.count}f64'
    sums: list[list[Any]] = [[] for _ in many]
    for j in range(lanes.count):
        place = builder.add(args[1], ir.Constant(args[1].type, j))
        row = _loaded(context, builder, kind, args[0], place)
        for weights, parts in zip(many, sums, strict=True):
            one = builder.extract_element(weights, ir.Constant(_INDEX, j))
            pair = [row, _splat(builder, lanes, one)]
            if j < 4:
                parts.append(builder.fmul(*pair))
            else:
                parts[j % 4] = _call(builder, name, lanes.vector, [*pair, parts[j % 4]])
    return [
        builder.fadd(builder.fadd(*parts[:2]), builder.fadd(*parts[2:])) for parts in sums
    ]


@_built
def combined(_typing: Any, array: Any, first: Any, weights: Any) -> Any:
    """Return Σ_j weights_j · row (first + j); four sums side by side, for speed."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _combined(context, builder, sig.args[0], args, args[2:])[0]

    lanes = _lanes_in(array)
    return lanes(array, types.int64, lanes), build


@_built
def combined_both(_typing: Any, array: Any, first: Any, weights: Any, others: Any) -> Any:
    """Return `combined` of the same rows with two weights; each row is read once."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        both = _combined(context, builder, sig.args[0], args, args[2:])
        return context.make_tuple(builder, sig.return_type, both)

    lanes = _lanes_in(array)
    return types.UniTuple(lanes, 2)(array, types.int64, lanes, lanes), build


@_built
def width(_typing: Any, rows: Any) -> Any:
    """Return how many numbers a row is long, or how many lanes there are: a constant."""

    def build(_context: Any, _builder: Any, sig: Any, _args: Any) -> Any:
        return ir.Constant(ir.IntType(64), _lanes_in(sig.args[0]).count)

    return types.int64(rows), build


@_built
def filled(_typing: Any, like: Any, x: Any) -> Any:
    """Return the same number in all lanes: as many as `like`, lanes or rows, has."""

    def build(_context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _splat(builder, sig.return_type, args[1])

    return _lanes_in(like)(like, types.float64), build


@_built
def splat(_typing: Any, x: Any) -> Any:
    """Return the same number in eight lanes."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return _splat(builder, LANES, args[0])

    return LANES(types.float64), build


@_built
def lane(_typing: Any, lanes: Any, i: Any) -> Any:
    """Return lane i."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return builder.extract_element(args[0], builder.trunc(args[1], _INDEX))

    return types.float64(lanes, types.int64), build


@_built
def with_lane(_typing: Any, lanes: Any, i: Any, x: Any) -> Any:
    """Return the lanes with lane i replaced."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return builder.insert_element(args[0], args[2], builder.trunc(args[1], _INDEX))

    return lanes(lanes, types.int64, types.float64), build


def _call(builder: Any, name: str, result: Any, args: list[Any]) -> Any:
    kind = ir.FunctionType(result, [arg.type for arg in args])
    function = cgutils.get_or_insert_function(builder.module, kind, name)
    return builder.call(function, args)


@_built
def fma(_typing: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a·b + c, rounded once; lanes where any of them is lanes, else a float."""
    wide = [kind for kind in (a, b, c) if _is_lanes(kind)]
    kinds = [kind if _is_lanes(kind) else types.float64 for kind in (a, b, c)]

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        if not wide:
            return _call(builder, 'llvm.fma.f64', _DOUBLE, list(args))
        spread = [
            arg if kind is wide[0] else _splat(builder, wide[0], arg)
            for arg, kind in zip(args, kinds, strict=True)
        ]
        return _call(builder, f'llvm.fma.v{wide[0].count}f64', wide[0].vector, spread)

    return (wide[0] if wide else types.float64)(*kinds), build


@_built
def root(_typing: Any, x: Any) -> Any:
    """Return the square root, correctly rounded: lanes of lanes, a float of a float."""
    kind = x if _is_lanes(x) else types.float64

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        name, result = (f'v{x.count}f64', x.vector) if _is_lanes(x) else ('f64', _DOUBLE)
        return _call(builder, f'llvm.sqrt.{name}', result, list(args))

    return kind(kind), build


@_built
def largest(_typing: Any, lanes: Any) -> Any:
    """Return the largest magnitude of the lanes; NaNs may be passed over."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        size = _call(builder, f'llvm.fabs.v{lanes.count}f64', lanes.vector, [args[0]])
        return _folded(builder, size, lambda a, b: _larger(builder, a, b))

    return types.float64(lanes), build


def _larger(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered('>', a, b), a, b)


def _smaller(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered('<', a, b), a, b)


def _folded(builder: Any, vector: Any, pair: Callable[[Any, Any], Any]) -> Any:
    """Fold halves onto each other until one number is left: the same order everywhere."""
    count = vector.type.count
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
        below = builder.fcmp_ordered('<', args[0], ir.Constant(lanes.vector, [0.0] * lanes.count))
        return builder.zext(builder.bitcast(below, ir.IntType(lanes.count)), ir.IntType(64))

    return types.int64(lanes), build


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
        name = f'llvm.fabs.v{a.count}f64'
        return _larger(builder, *(_call(builder, name, a.vector, [arg]) for arg in args))

    return a(a, a), build


@_built
def least(_typing: Any, lanes: Any) -> Any:
    """Return the least of the lanes; NaNs may be passed over."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return _folded(builder, args[0], lambda a, b: _smaller(builder, a, b))

    return types.float64(lanes), build


@_built
def total(_typing: Any, lanes: Any) -> Any:
    """Return the sum of the lanes."""

    def build(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return _folded(builder, args[0], builder.fadd)

    return types.float64(lanes), build
