"""Values of variables where branches meet, or at the head of a loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir

from tauto_core.kernels.emission import Emission
from tauto_core.kernels.values import (
    BOOL,
    FLOAT,
    INT,
    Array,
    Conflict,
    Fields,
    Group,
    Kind,
    Record,
    Value,
    at_run_time,
    described,
    is_number,
    is_static,
)


class BeginAnewError(Exception):
    """A variable of a loop has another kind at its end than at its beginning: start again."""


def joined(
    out: Emission, values: Sequence[Any], blocks: Sequence[ir.Block], after: ir.Block, name: str
) -> Any:
    """Return the value in `after` of a variable that differs between the blocks before it.

    The blocks have no end yet, so that numbers can be converted there.
    """
    first = values[0]
    if all(_same(x, first) for x in values):
        return first
    if any(isinstance(x, Conflict) for x in values):
        return next(x for x in values if isinstance(x, Conflict))
    grouped = [group for group in map(_grouped, values) if group is not None]
    if len(grouped) == len(values) and all(_alike(g, grouped[0]) for g in grouped):
        columns = zip(*[g.items for g in grouped], strict=True)
        items = [joined(out, column, blocks, after, name) for column in columns]
        return Group(items, grouped[0].instance_class)
    if all(isinstance(x, Array) and _alike(x, first) for x in values):
        room = first.room if all(x.room is first.room for x in values) else None
        data = _phi(out, [x.data for x in values], blocks, after)
        columns = zip(*[x.shape for x in values], strict=True)
        return Array(first.kind, data, [_phi(out, c, blocks, after) for c in columns], room)
    if all(isinstance(x, Record) and x.kind.dtype == first.kind.dtype for x in values):
        return Record(first.kind, _phi(out, [x.data for x in values], blocks, after))
    kind = common_kind(values)
    if kind is None:
        said = ' or '.join(dict.fromkeys(described(x) for x in values))
        return Conflict(f'{name} is {said}, by the way taken')
    converted = []
    for x, block in zip(values, blocks, strict=True):
        out.b.position_at_end(block)
        converted.append(out.convert(x, kind).ir)
    return Value(kind, _phi(out, converted, blocks, after))


def _phi(
    out: Emission, values: Sequence[ir.Value], blocks: Sequence[ir.Block], after: ir.Block
) -> ir.Value:
    if all(value is values[0] for value in values):
        return values[0]
    out.b.position_at_end(after)
    phi = out.b.phi(values[0].type)
    for value, block in zip(values, blocks, strict=True):
        phi.add_incoming(value, block)
    return phi


def meet(out: Emission, ends: Sequence[tuple[ir.Block, dict[str, Any]]]) -> dict[str, Any]:
    """Join several branches; return the variables there."""
    if len(ends) == 1:
        out.b.position_at_end(ends[0][0])
        return ends[0][1]
    after, blocks = out.block('after'), [block for block, _ in ends]
    together: dict[str, Any] = {}
    for name in dict.fromkeys(name for _, variables in ends for name in variables):
        found = [variables.get(name, _unset(name)) for _, variables in ends]
        together[name] = joined(out, found, blocks, after, name)
    out.go_on(blocks, after)
    return together


def carried(
    out: Emission, x: Any, loop: Any, name: str, came: ir.Block, head: ir.Block, place: Any = ()
) -> tuple[Any, Callable[[Any, ir.Block], None]]:
    """Return a variable at a loop's head, and a function that adds its value from an end."""
    key = loop, name, place
    change = out.widened.get(key)
    group = _grouped(x)
    if change == 'dropped' or isinstance(x, Conflict):
        why = x.why if isinstance(x, Conflict) else f'{name} changes its kind in the loop'
        return Conflict(why), lambda _x, _block: None
    if group is not None:
        pairs = [
            carried(out, item, loop, name, came, head, (*place, i))
            for i, item in enumerate(group.items)
        ]

        def from_group(end: Any, block: ir.Block) -> None:
            other = _grouped(end)
            if other is None or not _alike(other, group):
                _restart(out, key, 'dropped')
            for (_, tell), item in zip(pairs, other or (), strict=True):
                tell(item, block)

        return Group([item for item, _ in pairs], group.instance_class), from_group
    if isinstance(x, (Array, Record)) or not (is_number(x) or isinstance(x, Value)):

        def from_same(end: Any, _block: ir.Block) -> None:
            if not _same(end, x):
                _restart(out, key, 'dropped')

        return (x, from_same) if not isinstance(x, Array) else _rows(out, x, key, came, head)
    x = at_run_time(x)
    kind = FLOAT if change == 'float' else INT if change == 'int' else x.kind
    out.b.position_at_end(came)
    begun = out.convert(x, kind).ir
    out.b.position_at_end(head)
    phi = out.b.phi(kind.type)
    phi.add_incoming(begun, came)

    def from_number(end: Any, block: ir.Block) -> None:
        wanted = common_kind([Value(kind, phi), end])
        if wanted is None:
            _restart(out, key, 'dropped')
        elif wanted is not kind:
            _restart(out, key, 'float' if wanted is FLOAT else 'int')
        out.b.position_at_end(block)
        phi.add_incoming(out.convert(end, kind).ir, block)

    return Value(kind, phi), from_number


def _rows(out: Emission, x: Array, key: Any, came: ir.Block, head: ir.Block) -> Any:
    """Return `carried` of an array."""
    out.b.position_at_end(head)
    phis = [out.b.phi(value.type) for value in (x.data, *x.shape)]
    for phi, value in zip(phis, (x.data, *x.shape), strict=True):
        phi.add_incoming(value, came)

    def from_array(end: Any, block: ir.Block) -> None:
        if not isinstance(end, Array) or not _alike(end, x):
            _restart(out, key, 'dropped')
        for phi, value in zip(phis, (end.data, *end.shape), strict=True):
            phi.add_incoming(value, block)

    return Array(x.kind, phis[0], phis[1:]), from_array


def _restart(out: Emission, key: Any, change: str) -> None:
    out.widened[key] = change
    raise BeginAnewError


def common_kind(values: Sequence[Any]) -> Kind | None:
    """Return the common kind of numbers: a float for a float and a whole number."""
    kinds: list[Kind] = []
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


def _unset(name: str) -> Conflict:
    return Conflict(f'{name} may not have been set')


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
    if isinstance(x, Group):
        return x.instance_class is y.instance_class and len(x) == len(y)
    if isinstance(x, Array) and isinstance(y, Array):
        same = x.kind is y.kind or (
            isinstance(x.kind, Fields)
            and isinstance(y.kind, Fields)
            and x.kind.dtype == y.kind.dtype
        )
        return same and len(x.shape) == len(y.shape)
    return False
