"""Lowering: from the syntax tree of a function to LLVM instructions, in one pass.

Each variable has a known value or a known kind: no types are inferred. Expressions of static
values are evaluated by Python's own operators (partial evaluation), all others become
instructions. The instructions are in SSA form from the beginning: a name stands for its last
value, and `joined` adds phi nodes at the join of branches. A `Program` is an entry with all its
callees.
"""

from __future__ import annotations

import ast
import builtins
from collections.abc import Iterator
from itertools import count
from types import FunctionType, ModuleType
from typing import Any, NamedTuple

from llvmlite import ir

from tauto_core.kernels.marks import (
    DATA,
    DIMENSIONS,
    FLAGS,
    NEEDED_FLAGS,
    ArrayStructure,
    Dependencies,
    Intrinsic,
    KernelError,
    Tuple,
    arguments_of,
    assigned_in,
    indexed_by,
    is_inlined,
    leaves_early,
    plain_function,
    source_of,
)
from tauto_core.kernels.operations import (
    FUNCTIONS,
    IN_PYTHON,
    BackEdge,
    binary,
    carried,
    compared,
    fill,
    item,
    joined,
    meet,
    picked,
    place_of,
    power_at_run_time,
    unary,
    whole_power,
)
from tauto_core.kernels.values import (
    BIT,
    BOOL,
    BYTE,
    DOUBLE,
    FLOAT,
    INDEX,
    INT,
    UINT,
    WORD,
    Array,
    Conflict,
    Emission,
    Group,
    Record,
    Value,
    at_run_time,
    described,
    element,
    fields_of,
    is_number,
    is_static,
    leaves,
    rebuilt,
)

# -----------------------------------------------------------------------------
# Expressions and statements of a function, from the syntax tree to instructions.


class Method:
    """A method of a NamedTuple's class or of an array, with its object."""

    def __init__(self, owner: Any, function: Any) -> None:
        self.owner, self.function = owner, function


UNROLLED, UNROLLED_TO_PICK = 3, 16
"""Most rounds of an unrolled loop: of any loop, and of one that picks items of a tuple."""


class Loop(NamedTuple):
    """A loop around a statement.

    Attributes:
        left: blocks that a break ends, without terminator, and the variables there.
        next: the same for continue and for the end of the body.
    """

    left: list[Any]
    next: list[Any]


class Frame:
    """The lowering of one function: its names and statements.

    `reached` says whether the next statement can be reached.
    """

    def __init__(self, program: Any, out: Emission, function: FunctionType) -> None:
        self.program, self.out, self.function = program, out, function
        self.plan = source_of(function)
        program.used.file(function)
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
        self.free = dict(zip(function.__code__.co_freevars, cells, strict=True))
        self.variables: dict[str, Any] = {}
        self.returned: list[tuple[ir.Block, Any]] = []
        self.loops: list[Loop] = []
        self.reached = True

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
        """Return a variable, or the value of a name outside the function."""
        if name in self.variables:
            value = self.variables[name]
            if isinstance(value, Conflict):
                raise KernelError(value.why)
            return value
        if name in self.free:
            return self.free[name]
        names = self.function.__globals__
        if name in names:
            self.program.used.constant(self.function.__module__, name, names[name])
            return names[name]
        if hasattr(builtins, name):
            return getattr(builtins, name)
        raise KernelError(f'{name} is not set')

    def on_Tuple(self, e: Any) -> Any:
        items: list[Any] = []
        for node in e.elts:
            starred = isinstance(node, ast.Starred)
            items += self.eval(node.value) if starred else [self.eval(node)]
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
        value = getattr(base, name)
        if isinstance(base, ModuleType):
            self.program.used.constant(base.__name__, name, value)
        return value

    def _of_group(self, base: Group, name: str) -> Any:
        named = base.instance_class
        fields = getattr(named, '_fields', ())
        if name in fields:
            return base.items[fields.index(name)]
        classes = getattr(named, '__mro__', ())
        member = next((c.__dict__[name] for c in classes if name in c.__dict__), None)
        if isinstance(member, property) and isinstance(member.fget, FunctionType):
            return self.call(member.fget, [base], {})
        if isinstance(member, FunctionType):
            return Method(base, member)
        if named is None or not hasattr(named, name):
            raise KernelError(f'{described(base)} has no attribute {name}')
        return getattr(named, name)

    def indices(self, e: Any) -> Any:
        """Return a slice, or a list of indices."""
        if isinstance(e, ast.Slice):
            if e.step is not None:
                raise KernelError('kernels know no slices with a step')
            return slice(*(self.eval(x) if x is not None else None for x in (e.lower, e.upper)))
        index = self.eval(e)
        return list(index) if isinstance(index, (tuple, Group)) else [index]

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
        end, test = None, None
        for i, node in enumerate(e.values):
            test = out.truth(self.eval(node))
            if isinstance(test, bool):
                if test is not is_and:
                    break
            elif i + 1 < len(e.values):
                end, go_on = end or out.block('decided'), out.block('undecided')
                decided.append(b.block)
                b.cbranch(test.ir, *((go_on, end) if is_and else (end, go_on)))
                b.position_at_end(go_on)
        if end is None:
            return test
        value = at_run_time(test).ir
        came = b.block
        b.branch(end)
        b.position_at_end(end)
        phi = b.phi(BIT)
        for block in decided:
            phi.add_incoming(ir.Constant(BIT, int(not is_and)), block)
        phi.add_incoming(value, came)
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
        target = out.block('either')
        value = joined(out, values, ends, target, ast.unparse(e))
        out.go_on(ends, target)
        if isinstance(value, Conflict):
            raise KernelError(value.why)
        return value

    def on_Compare(self, e: Any) -> Any:
        value = self.eval(e.left)
        result: Any = True
        for op, node in zip(e.ops, e.comparators, strict=True):
            # the rest has no side effects and may be evaluated in any case
            right = self.eval(node)
            test = compared(self.out, op, value, right)
            if isinstance(result, bool):
                result = test if result else False
            elif isinstance(test, bool):
                result = result if test else False
            else:
                result = Value(BOOL, self.out.b.and_(result.ir, test.ir))
            value = right
        return result

    # calls

    def on_Call(self, e: Any) -> Any:
        callee = self.eval(e.func)
        args = [self.eval(node) for node in e.args]
        if any(word.arg is None for word in e.keywords):
            raise KernelError('kernels know no ** in a call')
        return self.call(callee, args, {word.arg: self.eval(word.value) for word in e.keywords})

    def call(self, callee: Any, args: list[Any], keywords: dict[str, Any]) -> Any:
        """Return the result of a call. The function is known at compile time."""
        if isinstance(callee, Method):
            if isinstance(callee.owner, Array):
                array, name = callee.owner, callee.function
                if name != 'reshape' or args != [-1]:
                    raise KernelError(
                        f'arrays in kernels have no {name}({", ".join(map(described, args))})'
                    )
                size = array.shape[0]
                for n in array.shape[1:]:
                    size = self.out.b.mul(size, n)
                return Array(array.kind, array.data, [size], array.room)
            return self.call(callee.function, [callee.owner, *args], keywords)
        if isinstance(callee, Intrinsic):
            self.program.used.file(callee.function)
            return callee.function(self.out, *args, **keywords)
        if isinstance(callee, type) and hasattr(callee, '_fields'):
            self.program.used.constant(callee.__module__, callee.__qualname__, callee)
            return Group(callee(*args, **keywords), callee)
        callee = IN_PYTHON.get(callee, callee) if callee.__hash__ else callee
        function = plain_function(callee)
        if function is not None:
            if is_inlined(function):
                return Frame(self.program, self.out, function).result(args, keywords)
            return self.program.call(self.out, function, args, keywords)
        emit = FUNCTIONS.get(callee)
        if emit is None:
            raise KernelError(f'kernels cannot call {callee!r}')
        return emit(self.out, *args, **keywords)

    def result(self, args: list[Any], keywords: dict[str, Any]) -> Any:
        """Translate the function for these arguments and return its result."""
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
        target = self.out.block('returned')
        value = joined(self.out, values, blocks, target, 'what is returned')
        self.out.go_on(blocks, target)
        if isinstance(value, Conflict):
            raise KernelError(f'in {self.function.__qualname__} {value.why}')
        return value

    # statements

    def run(self, body: list[Any]) -> None:
        """Translate statements up to the first unreachable one."""
        for statement in body:
            if not self.reached:
                return
            try:
                getattr(self, f'do_{type(statement).__name__}', self.unknown)(statement)
            except KernelError as error:
                self._locate(error, statement)
                raise
            except Exception as cause:
                failure = KernelError(f'{type(cause).__name__}: {cause}')
                self._locate(failure, statement)
                raise failure from cause

    def _locate(self, error: KernelError, statement: Any) -> None:
        """Add a line to the places of an error, once per function that it passes."""
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
            for part, item in zip(target.elts, value, strict=True):
                self.put(part, item)
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
        variables, ends = self.variables, []
        for block, body in ((yes, s.body), (no, s.orelse)):
            out.b.position_at_end(block)
            self.variables, self.reached = dict(variables), True
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
        bounds = [self.eval(node) for node in call.args]
        start, stop, step = (0, *bounds, 1) if len(bounds) == 1 else (*bounds, 1)[:3]
        if not isinstance(step, int) or not step:
            raise KernelError('the step of a range must be known when compiling, and not 0')
        if isinstance(start, int) and isinstance(stop, int):
            rounds = range(start, stop, step)
            if len(rounds) <= UNROLLED_TO_PICK and not leaves_early(s):
                names = {**self.function.__globals__, **self.free, **self.variables}
                picks = (isinstance(names.get(n), (tuple, Group)) for n in indexed_by(s))
                if len(rounds) <= UNROLLED or any(picks):
                    self._unroll(s, rounds)
                    return
        self._loop(s, (self.out.int(start), self.out.int(stop), step))

    def _unroll(self, s: Any, items: Any) -> None:
        """Translate the body of a loop once for each item."""
        if leaves_early(s):
            raise KernelError('break or continue in a loop over constant items')
        for value in items:
            if self.reached:
                self.put(s.target, value)
                self.run(s.body)

    def _loop(self, s: Any, count: Any = None) -> None:
        """Translate a loop that runs. `count` has start, end and step of a `for`."""
        if s.orelse:
            raise KernelError('kernels know no loop with else')
        out, b = self.out, self.out.b
        preheader, header = b.block, out.block('loop')
        # in the header, variables that the loop sets have the values that it carries
        outer, self.variables = self.variables, dict(self.variables)
        back_edges: dict[str, BackEdge] = {}
        for name in assigned_in(s):
            if name in outer:
                carrying = carried(out, outer[name], name, preheader, header)
                self.variables[name], back_edges[name] = carrying
        b.position_at_end(header)
        if count is not None:
            i = b.phi(WORD)
            i.add_incoming(count[0], preheader)
        out.go_on([preheader], header)
        body, leave = out.block('body'), out.block('leave')
        if count is None:
            test = at_run_time(out.truth(self.eval(s.test))).ir
        else:
            test = b.icmp_signed('<' if count[2] > 0 else '>', i, count[1])
        b.cbranch(test, body, leave)
        in_header, loop = self.variables, Loop([], [])
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
        self._go_on_from([(leave, in_header), *loop.left])

    def do_Break(self, _s: Any) -> None:
        self.loops[-1].left.append((self.out.b.block, self.variables))
        self.reached = False

    def do_Continue(self, _s: Any) -> None:
        self.loops[-1].next.append((self.out.b.block, self.variables))
        self.reached = False


# -----------------------------------------------------------------------------
# An LLVM module: an entry and all its callees.


class Instance:
    """An LLVM function: a kernel specialised for arguments of one structure.

    Attributes:
        f: LLVM's function.
        result: its result, with placeholders for the values of a call.
    """

    def __init__(self, program: Program, function: FunctionType, args: list[Any]) -> None:
        kind = ir.FunctionType(ir.VoidType(), [leaf.type for arg in args for leaf in leaves(arg)])
        program.count += 1
        name = f'{function.__name__.strip("<>")}.{program.count}'
        self.f = ir.Function(program.module, kind, name)
        out = Emission(program.module, self.f)
        head = out.b.block
        out.b.position_at_end(out.block('body'))
        entry = out.b.block
        words = iter(self.f.args)
        self.result = Frame(program, out, function).result([rebuilt(a, words) for a in args], {})
        self._return(out)
        out.b.position_at_end(head)
        out.b.branch(entry)
        self.f.linkage = 'internal'
        self.f.attributes.add('nounwind')

    def _return(self, out: Emission) -> None:
        b = out.b
        rooms = _rooms_of(self.result)
        if out.rooms:
            if None in rooms:
                raise KernelError('an array is returned that may be one of several')
            free = out.function('free', ir.VoidType(), [BYTE.as_pointer()])
            for room in out.rooms:
                if all(room is not owner for owner in rooms):
                    b.call(free, [room])
        values = leaves(self.result)
        if not values:
            b.ret_void()
            return
        kind = ir.LiteralStructType([value.type for value in values])
        result = ir.Constant(kind, ir.Undefined)
        for i, value in enumerate(values):
            result = b.insert_value(result, value, i)
        b.ret(result)
        self.f.ftype = ir.FunctionType(kind, self.f.ftype.args)
        self.f.return_value.type = kind
        self.f.type = self.f.ftype.as_pointer()

    def called(self, out: Emission, values: list[ir.Value]) -> Any:
        """Emit a call and return its result."""
        result, count = out.b.call(self.f, values), len(leaves(self.result))
        return rebuilt(self.result, iter([out.b.extract_value(result, i) for i in range(count)]))


def _rooms_of(x: Any) -> list[Any]:
    if isinstance(x, Array):
        return [x.room]
    return [room for item in x for room in _rooms_of(item)] if isinstance(x, Group) else []


class Program:
    """All functions of an entry.

    Attributes:
        module: LLVM's module.
        used: the sources and constants that they are made from.
        count: number of functions so far.
        result: layout of the entry's result: nested lists, names of kinds, `None`.
    """

    def __init__(self, function: FunctionType, arguments: list[Any], name: str) -> None:
        self.module, self.used, self.count = ir.Module(function.__name__), Dependencies(), 0
        self._instances: dict[Any, Instance] = {}
        self._being_made: list[Any] = []
        kind = ir.FunctionType(INDEX, [WORD.as_pointer(), WORD.as_pointer()])
        out = Emission(self.module, ir.Function(self.module, kind, name))
        words = count()
        args = [value_of(argument, words, out) for argument in arguments]
        result = at_run_time(self.call(out, function, args, {}))
        for i, value in enumerate(leaves(result)):
            place = out.b.gep(out.f.args[1], [ir.Constant(WORD, i)])
            out.b.store(_as_word(out, value), place)
        out.b.ret(ir.Constant(INDEX, 0))
        self.result = _layout(result)

    def call(
        self, out: Emission, function: FunctionType, args: list[Any], keywords: dict[str, Any]
    ) -> Any:
        """Call a kernel as a separate function."""
        bound = arguments_of(function, args, keywords)
        args = [at_run_time(bound[name]) for name in source_of(function).arguments]
        structure = tuple(described(arg) for arg in args)
        cells = tuple(id(cell.cell_contents) for cell in function.__closure__ or ())
        key = function.__code__, cells, structure
        if key not in self._instances:
            if key in self._being_made:
                raise KernelError(f'{function.__qualname__} calls itself')
            self._being_made.append(key)
            self._instances[key] = Instance(self, function, args)
            self._being_made.pop()
        return self._instances[key].called(out, [leaf for arg in args for leaf in leaves(arg)])


def value_of(structure: Any, words: Iterator[int], out: Emission) -> Any:
    """Emit code that reads an argument from its words, and return its compiled value."""
    if structure is None:
        return None
    if isinstance(structure, Tuple):
        items = [value_of(item, words, out) for item in structure.items]
        return Group(items, structure.named)
    b, place = out.b, next(words)
    word = b.load(b.gep(out.f.args[0], [ir.Constant(WORD, place)]))
    if isinstance(structure, ArrayStructure):
        return _array_of(structure, word, place, out)
    if structure == 'float':
        return Value(FLOAT, b.bitcast(word, DOUBLE))
    if structure == 'bool':
        return Value(BOOL, b.trunc(word, BIT))
    return Value(UINT if structure == 'uint64' else INT, word)


def _array_of(
    structure: ArrayStructure, word: ir.Value, place: int, out: Emission
) -> Array | Record:
    """Emit code that reads an array's object from the address in a word.

    If the array does not fit, the entry returns the number of the word, counted from one.
    """
    b = out.b

    def of_object(offset: int, kind: ir.Type) -> ir.Value:
        at = b.add(word, ir.Constant(WORD, object.__basicsize__ + offset))
        return b.load(b.inttoptr(at, kind.as_pointer()))

    needed = ir.Constant(INDEX, NEEDED_FLAGS)
    fits = b.icmp_unsigned('==', b.and_(of_object(FLAGS, INDEX), needed), needed)
    with b.if_then(b.not_(fits), likely=False):
        b.ret(ir.Constant(INDEX, place + 1))
    dimensions = of_object(DIMENSIONS, WORD.as_pointer())
    shape = [b.load(b.gep(dimensions, [ir.Constant(WORD, i)])) for i in range(structure.ndim)]
    if structure.dtype.fields is None:
        kind = element(structure.dtype)
        return Array(kind, of_object(DATA, kind.stored.as_pointer()), shape)
    fields, data = fields_of(structure.dtype), of_object(DATA, BYTE.as_pointer())
    return Array(fields, data, shape) if structure.ndim else Record(fields, data)


def _as_word(out: Emission, value: ir.Value) -> ir.Value:
    if value.type == DOUBLE:
        return out.b.bitcast(value, WORD)
    if value.type == BIT:
        return out.b.zext(value, WORD)
    if isinstance(value.type, ir.PointerType):
        return out.b.ptrtoint(value, WORD)
    if value.type == WORD:
        return value
    raise KernelError(f'{value.type} cannot be returned to Python')


def _layout(x: Any) -> Any:
    """Return the layout by which a result is made from words."""
    if isinstance(x, Value):
        return x.kind.name
    if isinstance(x, Group):
        return [_layout(item) for item in x]
    if isinstance(x, Array):
        return {'array': x.kind.name, 'ndim': len(x.shape)}
    if x is None:
        return None
    raise KernelError(f'{x!r} cannot be returned to Python')
