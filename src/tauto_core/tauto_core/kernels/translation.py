"""Lowering: from the syntax tree of a function to instructions of LLVM, in one pass.

Of each variable the value is known, or its kind, so that no types have to be inferred. What is
known when compiling is worked out with Python's own operators (partial evaluation); all else
becomes an instruction. The instructions are in SSA form from the beginning: a name stands for the
value last assigned to it, and where branches meet `joining` adds phi nodes.
"""

from __future__ import annotations

import ast
from types import FunctionType
from typing import Any

from llvmlite import ir

from tauto_core.kernels.emission import Emission
from tauto_core.kernels.errors import KernelError
from tauto_core.kernels.expressions import Scope
from tauto_core.kernels.items import fill, place_of
from tauto_core.kernels.joining import BackEdge, Header, joined, meet
from tauto_core.kernels.source import arguments_of, assigned_in, indexed_by, leaves_early
from tauto_core.kernels.values import (
    INT,
    WORD,
    Conflict,
    Group,
    Record,
    Value,
    at_run_time,
    described,
)

UNROLLED, UNROLLED_TO_PICK = 2, 16
"""Most rounds of a loop of known length that is unrolled: any loop, and one whose variable picks
items of a tuple, which are then known."""


class Loop:
    """A loop around a statement.

    Attributes:
        left: blocks in which a break leaves it, which have no branch yet, and the variables there.
        next: the same of continue, and of the end of its body.
    """

    def __init__(self) -> None:
        self.left: list[Any] = []
        self.next: list[Any] = []


class Frame(Scope):
    """The lowering of one function: its statements, and whether the next one can be reached."""

    def __init__(self, program: Any, out: Emission, function: FunctionType) -> None:
        super().__init__(program, out, function)
        self.returned: list[tuple[ir.Block, Any]] = []
        self.loops: list[Loop] = []
        self.reached = True

    def result(self, args: list[Any], keywords: dict[str, Any]) -> Any:
        """Translate the function for these arguments; return what it returns."""
        self.variables = arguments_of(self.function, args, keywords)
        self.run(self.plan.body)
        if self.reached:
            self.returned.append((self.out.b.block, None))
        blocks, values = [r[0] for r in self.returned], [r[1] for r in self.returned]
        if len(blocks) == 1:
            self.out.b.position_at_end(blocks[0])
            return values[0]
        if not blocks:
            raise KernelError(f'{self.function.__qualname__} never returns')
        after = self.out.block('returned')
        value = joined(self.out, values, blocks, after, 'what is returned')
        self.out.go_on(blocks, after)
        if isinstance(value, Conflict):
            raise KernelError(f'in {self.function.__qualname__} {value.why}')
        return value

    # statements

    def run(self, body: list[Any]) -> None:
        """Translate statements, up to where the rest is not reached."""
        for statement in body:
            if not self.reached:
                return
            try:
                getattr(self, f'do_{type(statement).__name__}', self.unknown)(statement)
            except KernelError as error:
                self._locate(error, statement)
                raise
            except Exception as cause:
                said = KernelError(f'{type(cause).__name__}: {cause}')
                self._locate(said, statement)
                raise said from cause

    def _locate(self, error: KernelError, statement: Any) -> None:
        """Add a line to the places of an error, once in each function that it passes."""
        if error.passed is not self:
            error.passed = self
            code = self.function.__code__
            error.places.append(f'{code.co_filename}:{statement.lineno} in {code.co_qualname}')

    def do_Pass(self, _s: Any) -> None:
        pass

    def do_Expr(self, s: Any) -> None:
        if not isinstance(s.value, ast.Constant):
            self.eval(s.value)

    def do_Raise(self, s: Any) -> None:
        raise KernelError(f'this is reached when compiling: {ast.unparse(s)}')

    def do_Assign(self, s: Any) -> None:
        value = self.eval(s.value)
        for target in s.targets:
            self.put(target, value)

    def do_AnnAssign(self, s: Any) -> None:
        if s.value is not None:
            self.put(s.target, self.eval(s.value))

    def do_AugAssign(self, s: Any) -> None:
        op, target = type(s.op), s.target
        if isinstance(target, ast.Name):
            old = self.lookup(target.id)
            self.variables[target.id] = self.binary(op, old, self.eval(s.value))
            return
        address, kind = self.place(target)
        old = self.out.load(address, kind)
        self.out.save(address, kind, self.binary(op, old, self.eval(s.value)))

    def put(self, target: Any, value: Any) -> None:
        """Set a variable, an item or a field."""
        if isinstance(target, ast.Name):
            self.variables[target.id] = value
        elif isinstance(target, ast.Tuple):
            if not isinstance(value, (Group, tuple)) or len(value) != len(target.elts):
                raise KernelError(f'{described(value)} is unpacked into {ast.unparse(target)}')
            for each, item in zip(target.elts, value, strict=True):
                self.put(each, item)
        elif isinstance(target, ast.Subscript) and isinstance(target.slice, ast.Slice):
            fill(self.out, self.on_Subscript(target), value)
        else:
            self.out.save(*self.place(target), value)

    def place(self, target: Any) -> tuple[ir.Value, Any]:
        """Return the address and kind of an item or a field."""
        if isinstance(target, ast.Attribute):
            base = self.eval(target.value)
            if isinstance(base, Record):
                return self.out.field(base, target.attr)
        elif isinstance(target, ast.Subscript):
            return place_of(self.out, self.eval(target.value), self.indices(target.slice))
        raise KernelError(f'{ast.unparse(target)} cannot be set')

    def do_Return(self, s: Any) -> None:
        value = self.eval(s.value) if s.value is not None else None
        self.returned.append((self.out.b.block, value))
        self.reached = False

    def do_If(self, s: Any) -> None:
        test = self.out.truth(self.eval(s.test))
        if isinstance(test, bool):
            self.run(s.body if test else s.orelse)
            return
        out = self.out
        yes, no = out.block('then'), out.block('else')
        out.b.cbranch(test.ir, yes, no)
        before, ends = self.variables, []
        for block, body in ((yes, s.body), (no, s.orelse)):
            out.b.position_at_end(block)
            self.variables, self.reached = dict(before), True
            with out.nested():
                self.run(body)
            if self.reached:
                ends.append((out.b.block, self.variables))
        self._go_on_from(ends)

    def _go_on_from(self, ends: list[Any]) -> None:
        self.reached = bool(ends)
        if ends:
            self.variables = meet(self.out, ends)

    def do_While(self, s: Any) -> None:
        self._loop(s)

    def do_For(self, s: Any) -> None:
        call = s.iter
        if not (isinstance(call, ast.Call) and self.eval(call.func) is range):
            items = self.eval(call)
            if not isinstance(items, (Group, tuple, range)):
                raise KernelError(f'kernels do not loop over {described(items)}')
            self._unroll(s, items)
            return
        bounds = [self.eval(each) for each in call.args]
        start, stop, step = (0, *bounds, 1) if len(bounds) == 1 else (*bounds, 1)[:3]
        if not isinstance(step, int) or not step:
            raise KernelError('the step of a range must be known when compiling, and not 0')
        if isinstance(start, int) and isinstance(stop, int):
            rounds = range(start, stop, step)
            if self._is_unrolled(s, len(rounds)):
                self._unroll(s, rounds)
                return
        self._loop(s, (self.out.int(start), self.out.int(stop), step))

    def _is_unrolled(self, s: Any, rounds: int) -> bool:
        if leaves_early(s) or rounds > UNROLLED_TO_PICK:
            return False
        known = {**self.function.__globals__, **self.free, **self.variables}
        picked = [known.get(name) for name in indexed_by(s)]
        return rounds <= UNROLLED or any(isinstance(x, (tuple, Group)) for x in picked)

    def _unroll(self, s: Any, items: Any) -> None:
        """Translate the body of a loop once for each item."""
        if leaves_early(s):
            raise KernelError('break or continue in a loop over what is known when compiling')
        for each in items:
            if self.reached:
                self.put(s.target, each)
                self.run(s.body)

    def _loop(self, s: Any, count: Any = None) -> None:
        """Translate a loop that runs; `count` is from where, to where and by what `for` counts."""
        if s.orelse:
            raise KernelError('kernels know no loop with else')
        out, b = self.out, self.out.b
        preheader, header = b.block, out.block('loop')
        back_edges = self._carry(Header(out, s, preheader, header))
        b.position_at_end(header)
        if count is not None:
            i = b.phi(WORD)
            i.add_incoming(count[0], preheader)
        out.go_on([preheader], header)
        body, after = out.block('body'), out.block('leave')
        if count is None:
            test = at_run_time(out.truth(self.eval(s.test))).ir
        else:
            test = b.icmp_signed('<' if count[2] > 0 else '>', i, count[1])
        b.cbranch(test, body, after)
        in_header, loop = self.variables, Loop()
        b.position_at_end(body)
        self.variables = dict(in_header)
        self.loops.append(loop)
        with out.nested():
            if count is not None:
                self.put(s.target, Value(INT, i))
            self.run(s.body)
        self.loops.pop()
        if self.reached:
            loop.next.append((b.block, self.variables))
        if loop.next:
            self.variables = meet(out, loop.next)
            latch = b.block
            for name, from_end in back_edges.items():
                from_end(self.variables[name], latch)
            b.position_at_end(latch)
            if count is not None:
                by = ir.Constant(WORD, count[2])
                i.add_incoming(b.add(i, by, flags=('nsw',)), latch)
            b.branch(header)
        self._go_on_from([(after, in_header), *loop.left])

    def _carry(self, header: Header) -> dict[str, BackEdge]:
        """Give the variables that a loop sets the values that they have in its header."""
        before, self.variables, back_edges = self.variables, dict(self.variables), {}
        for name in assigned_in(header.loop):
            if name in before:
                self.variables[name], back_edges[name] = header.carried(before[name], name)
        return back_edges

    def do_Break(self, _s: Any) -> None:
        self.loops[-1].left.append((self.out.b.block, self.variables))
        self.reached = False

    def do_Continue(self, _s: Any) -> None:
        self.loops[-1].next.append((self.out.b.block, self.variables))
        self.reached = False
