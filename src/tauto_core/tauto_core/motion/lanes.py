"""Lanes: eight or sixteen doubles as one number, such as the values at the stages of a step.

Lanes exist in compiled code only. They support + − · / and negation with lanes and with floats.
One formula therefore serves an instant and all stages of a step. LLVM maps eight lanes to the
registers of the processor: one of AVX-512, two of AVX2, four of SSE2 or NEON. Only `fma` fuses
operations and none is reordered, which keeps the bits the same on every processor.

Arrays and fields of records are read and written by rows. A row of an array has eight numbers. A
row of a record's field has as many as the last dimension of its type.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

from tauto_core.kernels import intrinsic

if TYPE_CHECKING:
    from tauto_core.kernels.values import Emission

SIZE, WIDE_SIZE = 8, 16

Lanes: TypeAlias = Any
"""A number at each stage of a step, in compiled code."""

Numeric: TypeAlias = Any
"""A number at an instant, or at each stage of a step."""

NumericPair: TypeAlias = tuple[Numeric, Numeric]
"""A number for each of two rotating planes, or for each of two angles."""


def _is_lanes(x: Any) -> bool:
    return bool(getattr(getattr(x, 'kind', None), 'lanes', 0))


def _row(rows: Any) -> int:
    """Return the length of a row of an array or a field, or the number of lanes of lanes."""
    kind: Any = getattr(rows, 'kind', None)
    return int(kind.lanes) if _is_lanes(rows) else int(getattr(kind, 'row', SIZE))


def _loaded(out: Emission, rows: Any, number: Any) -> Any:
    return out.b.load(out.row(rows, _row(rows), number), align=8)


@intrinsic
def row_of(out: Emission, array: Any, row: Any = 0) -> Any:
    """Return row `row` of a C-contiguous float array, or of a field."""
    return out.as_lanes(_loaded(out, array, out.int(row)))


@intrinsic
def store(out: Emission, array: Any, row: Any, lanes: Any) -> None:
    """Write lanes to row `row` of a C-contiguous float array, or of a field."""
    kind = out.as_lanes(out.spread(out.float(0.0), _row(array))).kind
    value = lanes if _is_lanes(lanes) else out.convert(lanes, kind)
    out.b.store(out.lanes(value), out.row(array, _row(array), out.int(row)), align=8)


def _combined(out: Emission, rows: Any, start: Any, weight_sets: tuple[Any, ...]) -> list[Any]:
    """Return Σ_j weights_j · row (start + j) for each set of weights."""
    begin, count = out.int(start), _row(rows)
    sums: list[list[Any]] = [[] for _ in weight_sets]
    for j in range(count):
        row = _loaded(out, rows, out.next(begin, j))
        for weights, parts in zip(weight_sets, sums, strict=True):
            pair = row, out.spread(out.item(out.lanes(weights), j), count)
            # four partial sums, since an fma waits for the one before it in its sum
            if j < 4:
                parts.append(out.b.fmul(*pair))
            else:
                parts[j % 4] = out.vector_function('fma', *pair, parts[j % 4])
    add = out.b.fadd
    return [out.as_lanes(add(add(*parts[:2]), add(*parts[2:]))) for parts in sums]


@intrinsic
def combined(out: Emission, array: Any, start: Any, weights: Any) -> Any:
    """Return Σ_j weights_j · row (start + j)."""
    return _combined(out, array, start, (weights,))[0]


@intrinsic
def combined_both(out: Emission, array: Any, start: Any, weights: Any, second_weights: Any) -> Any:
    """Return `combined` of the same rows with two sets of weights, reading each row once."""
    return out.group(_combined(out, array, start, (weights, second_weights)))


def _mirrored(out: Emission, vector: Any) -> Any:
    """Return the lanes in reverse order."""
    return out.shuffled(vector, vector, range(vector.type.count - 1, -1, -1))


def _total_everywhere(out: Emission, vector: Any) -> Any:
    """Return the sum of the lanes in each lane, in a fixed order of summation."""
    count, distance = vector.type.count, 1
    while distance < count:
        partner = out.shuffled(vector, vector, [i ^ distance for i in range(count)])
        vector, distance = out.b.fadd(vector, partner), 2 * distance
    return vector


def _folded_sums(out: Emission, rows: Any, start: Any, room: Any, weights: Any) -> Any:
    """Return the sums of `folded_both` for one set of weights."""
    count = _row(rows)
    half_count = count // 2
    weight_lanes = out.lanes(weights)
    low, high = (
        out.shuffled(weight_lanes, weight_lanes, range(half_count)),
        _mirrored(out, out.shuffled(weight_lanes, weight_lanes, range(half_count, count))),
    )
    # sums and differences of the weights of mirrored stages
    even, odd = out.b.fadd(low, high), out.b.fsub(low, high)
    out.b.store(out.shuffled(even, odd, range(count)), out.row(rows, count, room), align=8)
    weight_row = out.reloaded(out.row(rows, count, room))
    sums: list[list[Any]] = [[], []]
    for j in range(half_count):
        row = _loaded(out, rows, out.next(start, j))
        for k, parts in enumerate(sums):
            part = out.shuffled(row, row, range(k * half_count, (k + 1) * half_count))
            weight = out.spread(out.number(weight_row, k * half_count + j), half_count)
            if j < 2:
                parts.append(out.b.fmul(part, weight))
            else:
                parts[j % 2] = out.vector_function('fma', part, weight, parts[j % 2])
    shared = _loaded(out, rows, out.next(start, half_count))
    shared = out.b.fmul(out.shuffled(shared, shared, range(half_count)), even)
    across, along = (out.b.fadd(*parts) for parts in sums)
    along = out.b.fadd(along, _total_everywhere(out, shared))
    front, behind = out.b.fadd(along, across), out.b.fsub(along, across)
    return out.as_lanes(out.shuffled(front, _mirrored(out, behind), range(count)))


@intrinsic
def folded_both(
    out: Emission, array: Any, start: Any, room: Any, weights: Any, second_weights: Any
) -> Any:
    """Return `combined_both` of the matrix of a symmetric rule, at half the operations.

    If half the rule's weights are subtracted from each row, the matrix changes its sign when rows
    and columns are reversed. It therefore maps sums of mirrored numbers to differences, and
    differences to sums, by matrices of half the size. Weights are read back from memory, because
    loads run in parallel with arithmetic, and moves between lanes do not.

    The matrix starts at row `start` of `array`, as `gauss_step.Gauss.folded`. Two rows from `room`
    on are overwritten.
    """
    begin, place = out.int(start), out.int(room)
    return out.group(
        [
            _folded_sums(out, array, begin, place, weights),
            _folded_sums(out, array, begin, out.next(place, 1), second_weights),
        ]
    )


@intrinsic
def is_lanes(_out: Emission, x: Any) -> Any:
    """Return whether a number is lanes (known when compiling)."""
    return _is_lanes(x)


@intrinsic
def width(_out: Emission, rows: Any) -> Any:
    """Return the length of a row, or the number of lanes (known when compiling)."""
    return _row(rows)


@intrinsic
def filled(out: Emission, like: Any, x: Any) -> Any:
    """Return lanes that all equal x, as many as `like` or its rows have."""
    return out.as_lanes(out.spread(out.float(x), _row(like)))


@intrinsic
def splat(out: Emission, x: Any) -> Any:
    """Return eight lanes that all equal x."""
    return out.as_lanes(out.spread(out.float(x), SIZE))


@intrinsic
def lane(out: Emission, lanes: Any, i: Any) -> Any:
    """Return lane i."""
    return out.as_float(out.item(out.lanes(lanes), i))


@intrinsic
def with_lane(out: Emission, lanes: Any, i: Any, x: Any) -> Any:
    """Return the lanes with lane i replaced."""
    return out.as_lanes(out.b.insert_element(out.lanes(lanes), out.float(x), out.index(i)))


@intrinsic
def fma(out: Emission, a: Any, b: Any, c: Any) -> Any:
    """Return a·b + c, rounded once: lanes if any argument is lanes, otherwise a float."""
    wide = next((x.kind for x in (a, b, c) if _is_lanes(x)), None)
    if wide is None:
        return out.as_float(out.vector_function('fma', *(out.float(x) for x in (a, b, c))))
    return out.as_lanes(out.vector_function('fma', *(out.convert(x, wide).ir for x in (a, b, c))))


@intrinsic
def square_root(out: Emission, x: Any) -> Any:
    """Return the correctly rounded square root of lanes or a float."""
    if _is_lanes(x):
        return out.as_lanes(out.vector_function('sqrt', x.ir))
    return out.as_float(out.vector_function('sqrt', out.float(x)))


def _larger(out: Emission, a: Any, b: Any) -> Any:
    return out.b.select(out.b.fcmp_ordered('>', a, b), a, b)


def _folded(out: Emission, vector: Any, pair: Callable[[Any, Any], Any]) -> Any:
    """Fold halves onto each other until one number is left, in a fixed order."""
    count = vector.type.count
    while count > 1:
        count //= 2
        low = out.shuffled(vector, vector, range(count))
        high = out.shuffled(vector, vector, range(count, 2 * count))
        vector = pair(low, high)
    return out.as_float(out.item(vector, 0))


@intrinsic
def largest(out: Emission, lanes: Any) -> Any:
    """Return the largest magnitude of the lanes. A NaN may be ignored."""
    size = out.vector_function('fabs', out.lanes(lanes))
    return _folded(out, size, lambda a, b: _larger(out, a, b))


@intrinsic
def negative(out: Emission, lanes: Any) -> Any:
    """Return one bit for each lane, set if it is below zero. Lane 0 has the lowest bit."""
    vector = out.lanes(lanes)
    return out.as_int(out.bits(out.b.fcmp_ordered('<', vector, out.zeros(vector))))


@intrinsic
def ones(out: Emission, bits: Any) -> Any:
    """Return the number of set bits."""
    return out.as_int(out.b.ctpop(out.int(bits)))


@intrinsic
def chosen(out: Emission, sign: Any, below: Any, above: Any) -> Any:
    """Return, lane by lane, `below` if the sign is below zero, otherwise `above`."""
    vector = out.lanes(sign)
    is_below = out.b.fcmp_ordered('<', vector, out.zeros(vector))
    return out.as_lanes(out.b.select(is_below, out.lanes(below), out.lanes(above)))


@intrinsic
def larger(out: Emission, a: Any, b: Any) -> Any:
    """Return, lane by lane, the larger magnitude of two."""
    sizes = [out.vector_function('fabs', out.lanes(x)) for x in (a, b)]
    return out.as_lanes(_larger(out, *sizes))


@intrinsic
def lowest(out: Emission, lanes: Any) -> Any:
    """Return the least of the lanes. A NaN may be ignored."""
    smaller = out.b.fcmp_ordered
    return _folded(out, out.lanes(lanes), lambda a, b: out.b.select(smaller('<', a, b), a, b))


@intrinsic
def total(out: Emission, lanes: Any) -> Any:
    """Return the sum of the lanes."""
    return _folded(out, out.lanes(lanes), out.b.fadd)
