"""Expressions of a function, from the syntax tree to instructions, and what its names mean."""

from __future__ import annotations

import ast
import builtins
from types import FunctionType, ModuleType
from typing import Any

from llvmlite import ir

from tauto_core.kernels.emission import Emission
from tauto_core.kernels.errors import KernelError
from tauto_core.kernels.functions import FUNCTIONS, IN_PYTHON
from tauto_core.kernels.items import item, picked
from tauto_core.kernels.joining import joined
from tauto_core.kernels.marks import Intrinsic, plain_function
from tauto_core.kernels.operations import (
    binary,
    compare,
    power_at_run_time,
    unary,
    whole_power,
)
from tauto_core.kernels.source import is_inlined, plan_of
from tauto_core.kernels.values import (
    BIT,
    BOOL,
    FLOAT,
    INT,
    Array,
    Conflict,
    Group,
    Record,
    Value,
    at_run_time,
    described,
    is_number,
    is_static,
)


class Method:
    """A method of a NamedTuple's class, or of an array, with what it is called on."""

    def __init__(self, owner: Any, function: Any) -> None:
        self.owner, self.function = owner, function


class Scope:
    """A function and what its names mean."""

    def __init__(self, program: Any, out: Emission, function: FunctionType) -> None:
        self.program, self.out, self.function = program, out, function
        self.plan = plan_of(function)
        program.used.file(function)
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
        self.free = dict(zip(function.__code__.co_freevars, cells, strict=True))
        self.variables: dict[str, Any] = {}

    def unknown(self, node: Any) -> Any:
        """Refuse a construct that the language does not have."""
        raise KernelError(f'kernels know no {type(node).__name__}: {ast.unparse(node)}')

    def eval(self, e: Any) -> Any:
        """Return the value of an expression."""
        return getattr(self, f'on_{type(e).__name__}', self.unknown)(e)

    def on_Constant(self, e: Any) -> Any:
        return e.value

    def on_Name(self, e: Any) -> Any:
        return self.lookup(e.id)

    def lookup(self, name: str) -> Any:
        """Return a variable, or what a name means outside the function."""
        if name in self.variables:
            found = self.variables[name]
            if isinstance(found, Conflict):
                raise KernelError(found.why)
            return found
        if name in self.free:
            return self.free[name]
        known = self.function.__globals__
        if name in known:
            self.program.used.constant(self.function.__module__, name, known[name])
            return known[name]
        if hasattr(builtins, name):
            return getattr(builtins, name)
        raise KernelError(f'{name} is not set')

    def on_Tuple(self, e: Any) -> Any:
        items: list[Any] = []
        for each in e.elts:
            starred = isinstance(each, ast.Starred)
            items += self.eval(each.value) if starred else [self.eval(each)]
        return tuple(items) if all(is_static(x) for x in items) else Group(items)

    def on_Attribute(self, e: Any) -> Any:
        base, name = self.eval(e.value), e.attr
        if isinstance(base, Group):
            return self._of_group(base, name)
        if isinstance(base, Record):
            return self.out.load(*self.out.field(base, name))
        if isinstance(base, Array):
            if name == 'shape':
                return Group([Value(INT, n) for n in base.shape])
            return Method(base, name)
        if not is_static(base):
            raise KernelError(f'{described(base)} has no attribute {name}')
        found = getattr(base, name)
        if isinstance(base, ModuleType):
            self.program.used.constant(base.__name__, name, found)
        return found

    def _of_group(self, base: Group, name: str) -> Any:
        named = base.instance_class
        fields = getattr(named, '_fields', ())
        if name in fields:
            return base.items[fields.index(name)]
        classes = getattr(named, '__mro__', ())
        found = next((c.__dict__[name] for c in classes if name in c.__dict__), None)
        if isinstance(found, property) and isinstance(found.fget, FunctionType):
            return self.call(found.fget, [base], {})
        if isinstance(found, FunctionType):
            return Method(base, found)
        if named is None or not hasattr(named, name):
            raise KernelError(f'{described(base)} has no attribute {name}')
        return getattr(named, name)

    def indices(self, e: Any) -> Any:
        """Return a slice, or a list of indices."""
        if isinstance(e, ast.Slice):
            if e.step is not None:
                raise KernelError('kernels know no slices with a step')
            return slice(*(self.eval(x) if x is not None else None for x in (e.lower, e.upper)))
        found = self.eval(e)
        return list(found) if isinstance(found, (tuple, Group)) else [found]

    def on_Subscript(self, e: Any) -> Any:
        base, where = self.eval(e.value), self.indices(e.slice)
        if isinstance(base, (Group, tuple)):
            return picked(self.out, base, where[0] if isinstance(where, list) else where)
        return item(self.out, base, where)

    def on_UnaryOp(self, e: Any) -> Any:
        return unary(self.out, e.op, self.eval(e.operand))

    def on_BinOp(self, e: Any) -> Any:
        return self.binary(type(e.op), self.eval(e.left), self.eval(e.right))

    def binary(self, op: type, x: Any, y: Any) -> Any:
        """Return the result of an operator on two values."""
        if op is not ast.Pow or (is_number(x) and is_number(y)):
            return binary(self.out, op, x, y)
        if isinstance(y, int):
            return whole_power(self.out, x, y)
        y = at_run_time(y)
        if isinstance(y, Value) and y.kind is INT:
            return self.call(power_at_run_time, [self.out.convert(x, FLOAT), y], {})
        raise KernelError(f'kernels know no power {described(y)}, only whole ones')

    def on_BoolOp(self, e: Any) -> Any:
        out, b, is_and = self.out, self.out.b, isinstance(e.op, ast.And)
        decided: list[ir.Block] = []  # blocks that jump to the end
        end, last = None, None
        for i, each in enumerate(e.values):
            last = out.truth(self.eval(each))
            if isinstance(last, bool):
                if last is not is_and:
                    break
            elif i + 1 < len(e.values):
                end, go_on = end or out.block('decided'), out.block('undecided')
                decided.append(b.block)
                b.cbranch(last.ir, *((go_on, end) if is_and else (end, go_on)))
                b.position_at_end(go_on)
        if end is None:
            return last
        rest = at_run_time(last).ir
        came = b.block
        b.branch(end)
        b.position_at_end(end)
        phi = b.phi(BIT)
        for block in decided:
            phi.add_incoming(ir.Constant(BIT, int(not is_and)), block)
        phi.add_incoming(rest, came)
        return Value(BOOL, phi)

    def on_IfExp(self, e: Any) -> Any:
        test = self.out.truth(self.eval(e.test))
        if isinstance(test, bool):
            return self.eval(e.body if test else e.orelse)
        out, b = self.out, self.out.b
        blocks = [out.block('one'), out.block('other')]
        b.cbranch(test.ir, *blocks)
        values, ends = [], []
        for block, branch in zip(blocks, (e.body, e.orelse), strict=True):
            b.position_at_end(block)
            with out.nested():
                values.append(self.eval(branch))
            ends.append(b.block)
        after = out.block('either')
        value = joined(out, values, ends, after, ast.unparse(e))
        out.go_on(ends, after)
        if isinstance(value, Conflict):
            raise KernelError(value.why)
        return value

    def on_Compare(self, e: Any) -> Any:
        left = self.eval(e.left)
        result: Any = True
        for op, each in zip(e.ops, e.comparators, strict=True):
            # what follows has no effects: it may be worked out whether it counts or not
            right = self.eval(each)
            one = compare(self.out, op, left, right)
            if isinstance(result, bool):
                result = one if result else False
            elif isinstance(one, bool):
                result = result if one else False
            else:
                result = Value(BOOL, self.out.b.and_(result.ir, one.ir))
            left = right
        return result

    # calls

    def on_Call(self, e: Any) -> Any:
        callee = self.eval(e.func)
        args = [self.eval(each) for each in e.args]
        if any(word.arg is None for word in e.keywords):
            raise KernelError('kernels know no ** in a call')
        return self.call(callee, args, {word.arg: self.eval(word.value) for word in e.keywords})

    def call(self, callee: Any, args: list[Any], keywords: dict[str, Any]) -> Any:
        """Return the result of a call; the function is known when compiling."""
        if isinstance(callee, Method):
            if isinstance(callee.owner, Array):
                return self._of_array(callee.owner, callee.function, args)
            return self.call(callee.function, [callee.owner, *args], keywords)
        if isinstance(callee, Intrinsic):
            self.program.used.file(callee.function)
            return callee.function(self.out, *args, **keywords)
        if isinstance(callee, type) and hasattr(callee, '_fields'):
            self.program.used.type(callee)
            made = callee(*args, **keywords)
            return Group(made, callee)
        callee = IN_PYTHON.get(callee, callee) if callee.__hash__ else callee
        function = plain_function(callee)
        if function is not None:
            translate = self.program.inlined if is_inlined(function) else self.program.call
            return translate(self.out, function, args, keywords)
        known = FUNCTIONS.get(callee)
        if known is None:
            raise KernelError(f'kernels cannot call {callee!r}')
        return known(self.out, *args, **keywords)

    def _of_array(self, array: Array, name: str, args: list[Any]) -> Any:
        if name == 'reshape' and args == [-1]:
            size = array.shape[0]
            for n in array.shape[1:]:
                size = self.out.b.mul(size, n)
            return Array(array.kind, array.data, [size], array.room)
        raise KernelError(f'arrays in kernels have no {name}({", ".join(map(described, args))})')
