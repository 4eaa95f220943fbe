"""Items of tuples and arrays: where they are, and parts of arrays."""

from __future__ import annotations

from typing import Any

from llvmlite import ir

from tauto_core.kernels.emission import Emission
from tauto_core.kernels.errors import KernelError
from tauto_core.kernels.values import (
    INT,
    WORD,
    Array,
    Fields,
    Pointer,
    Value,
    at_run_time,
    described,
)


def picked(out: Emission, items: Any, i: Any) -> Any:
    """Return an item of a tuple; of a place known at run time, all must be of one kind."""
    if isinstance(i, (int, slice)):
        return items[i]
    values, b = [at_run_time(x) for x in items], out.b
    kinds = {x.kind if isinstance(x, Value) else None for x in values}
    if len(kinds) != 1 or None in kinds:
        raise KernelError(
            f'an item of {described(items)} is picked by a number known at run time only'
        )
    kind = values[0].kind
    # at the function's head: the room is there once, however often a loop comes by
    with b.goto_block(out.f.blocks[0]):
        room = b.alloca(ir.ArrayType(kind.type, len(values)))
    for k, value in enumerate(values):
        b.store(value.ir, b.gep(room, [ir.Constant(WORD, 0), ir.Constant(WORD, k)]))
    place = b.gep(room, [ir.Constant(WORD, 0), out.int(i)])
    return Value(kind, b.load(place))


def item(out: Emission, base: Any, where: Any) -> Any:
    """Return an item of an array or behind a pointer; a row or rows, where indices are missing."""
    if isinstance(base, Array):
        if isinstance(where, slice):
            return _slice(out, base, where)
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
    head, body, after = out.block('fill'), out.block('item'), out.block('filled')
    out.go_on([came], head)
    i = b.phi(WORD)
    b.cbranch(b.icmp_signed('<', i, part.shape[0]), body, after)
    b.position_at_end(body)
    out.save(b.gep(part.data, [i]), part.kind, value)
    i.add_incoming(ir.Constant(WORD, 0), came)
    i.add_incoming(b.add(i, ir.Constant(WORD, 1)), body)
    out.go_on([body], head)
    b.position_at_end(after)


def _slice(out: Emission, base: Array, where: slice) -> Array:
    b, first = out.b, base.shape[0]
    stop = first if where.stop is None else _index(out, where.stop, first)
    if where.start is None:
        return Array(base.kind, base.data, [stop, *base.shape[1:]], base.room)
    start = _index(out, where.start, first)
    data = _rows(out, base, [Value(INT, start)]).data
    return Array(base.kind, data, [b.sub(stop, start), *base.shape[1:]])


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
    """Return a place as LLVM's integer: one known when compiling may count from the end."""
    if isinstance(i, int) and i < 0:
        return out.b.add(length, ir.Constant(WORD, int(i)))
    return out.int(i)
