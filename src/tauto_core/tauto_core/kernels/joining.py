"""Phi nodes: the values of variables where branches meet, and in the header of a loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from llvmlite import ir

from tauto_core.kernels.emission import Emission
from tauto_core.kernels.errors import KernelError
from tauto_core.kernels.values import (
    BOOL,
    FLOAT,
    INT,
    Array,
    Conflict,
    Group,
    Kind,
    Record,
    Value,
    at_run_time,
    described,
    is_number,
    is_static,
    leaves,
    rebuilt,
)

BackEdge: TypeAlias = Callable[[Any, ir.Block], None]
"""Adds the value that a variable has at the end of a round, in the block from which it returns."""


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
    if isinstance(first, (Array, Record)) and all(_alike(x, first) for x in values):
        columns = zip(*[leaves(x) for x in values], strict=True)
        one = rebuilt(first, iter([_phi(out, column, blocks, after) for column in columns]))
        if isinstance(first, Array) and all(x.room is first.room for x in values):
            one.room = first.room
        return one
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


class Header:
    """The header of a loop, with a phi node for each number that the loop carries.

    Its kinds are those before the loop, since the loop's end is not translated yet.

    Attributes:
        out: the function that is written.
        loop: the loop's node in the syntax tree.
        preheader: the block before the loop.
        block: the header's block.
    """

    def __init__(self, out: Emission, loop: Any, preheader: ir.Block, block: ir.Block) -> None:
        self.out, self.loop, self.preheader, self.block = out, loop, preheader, block

    def carried(self, x: Any, name: str) -> tuple[Any, BackEdge]:
        """Return a variable in the header, and what adds its value at the end of a round.

        Args:
            x: its value before the loop.
            name: its name.
        """
        group = _grouped(x)
        if group is not None:
            return self._group(group, name)
        if isinstance(x, Value) or is_number(x):
            return self._number(at_run_time(x), name)
        why = (
            f'{name} is {described(x)} before a loop that sets it: loops carry numbers and tuples'
        )
        return Conflict(x.why if isinstance(x, Conflict) else why), lambda _x, _block: None

    def _group(self, group: Group, name: str) -> tuple[Any, BackEdge]:
        pairs = [self.carried(item, name) for item in group]

        def from_group(end: Any, block: ir.Block) -> None:
            other = _grouped(end)
            if other is None or not _alike(other, group):
                raise _changed(name, group, end)
            for (_, from_item), item in zip(pairs, other, strict=True):
                from_item(item, block)

        return Group([item for item, _ in pairs], group.instance_class), from_group

    def _number(self, x: Value, name: str) -> tuple[Any, BackEdge]:
        self.out.b.position_at_end(self.block)
        phi = self.out.b.phi(x.kind.type)
        phi.add_incoming(x.ir, self.preheader)

        def from_number(end: Any, block: ir.Block) -> None:
            if common_kind([x, end]) is not x.kind:
                raise _changed(name, x, end)
            self.out.b.position_at_end(block)
            phi.add_incoming(self.out.convert(end, x.kind).ir, block)

        return Value(x.kind, phi), from_number


def _changed(name: str, x: Any, end: Any) -> KernelError:
    return KernelError(
        f'{name} is {described(x)} before the loop and {described(end)} at its end. Give it one '
        'kind, for example 0.0 in place of 0, or use another name in the loop'
    )


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
    """Return whether two tuples, arrays or records differ in their numbers only."""
    if isinstance(x, Group):
        return x.instance_class is y.instance_class and len(x) == len(y)
    if isinstance(x, Array) and isinstance(y, Array):
        return x.kind is y.kind and len(x.shape) == len(y.shape)
    return isinstance(x, Record) and isinstance(y, Record) and x.kind is y.kind
