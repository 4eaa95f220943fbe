"""Marks of kernels, their sources, and the dependencies of their compiled code, without LLVM."""

from __future__ import annotations

import ast
import hashlib
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple, TypeVar

from tauto_core.scene.errors import TautoError

# -----------------------------------------------------------------------------
# Errors and warnings of kernels.


class KernelError(TautoError):
    """A kernel cannot be compiled. The message names the fault, the file and the line.

    Attributes:
        places: file, line and function of the fault, and of each call on the way to it.
        passed: the lowering that added the last place.
    """

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.places: list[str] = []
        self.passed: object = None

    def __str__(self) -> str:
        return '\n  '.join([super().__str__(), *self.places])


class KernelCacheWarning(UserWarning):
    """Compiled kernels cannot be stored: each run compiles them again."""


_Function = TypeVar('_Function', bound=Callable[..., Any])

IS_INLINED: set[Any] = set()


def compiled(function: _Function) -> _Function:
    """Mark a function that kernels call. Called from Python it runs as Python."""
    return function


def inlined(function: _Function) -> _Function:
    """Mark a function that is inlined at every call: a short one, or one in a hot loop."""
    IS_INLINED.add(function)
    return function


class Intrinsic:
    """A function that writes instructions itself, see `intrinsic`."""

    def __init__(self, function: Any) -> None:
        self.function = function
        self.__name__, self.__doc__ = function.__name__, function.__doc__

    def __call__(self, *_args: Any) -> Any:
        raise KernelError(f'{self.__name__} runs in compiled code only')


def intrinsic(function: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a function that writes instructions of LLVM itself.

    Its first argument is a `values.Emission`, which kernels do not pass. The others are the
    arguments as known at compile time. It returns a value of the same kind.
    """
    return Intrinsic(function)


def plain_function(callee: Any) -> FunctionType | None:
    """Return the Python function that a callee is, or is made from."""
    callee = getattr(callee, 'python', callee)
    return callee if isinstance(callee, FunctionType) else None


# -----------------------------------------------------------------------------
# Listeners to compilations and their expected duration.

_listeners: list[Callable[[str | None, float], None]] = []


@contextmanager
def listening(listener: Callable[[str | None, float], None]) -> Iterator[None]:
    """Call a function whenever a kernel begins to compile, and when it is done.

    Args:
        listener: gets the kernel's name and roughly the seconds left, 0 while unknown, then
            `None`.
    """
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


@contextmanager
def compiling(name: str) -> Iterator[Callable[[float], Any]]:
    """Notify the listeners that a kernel compiles. Yields a reporter of the seconds left."""

    def say(kernel: str | None, left_s: float) -> None:
        for listener in _listeners:
            listener(kernel, left_s)

    say(name, 0.0)
    try:
        yield lambda left_s: say(name, left_s)
    finally:
        say(None, 0.0)


# -----------------------------------------------------------------------------
# The dependencies of compiled code, which is valid until one of them changes.


@cache
def contents(path: str) -> bytes:
    """Return a file as first read: the translated text is the hashed one."""
    try:
        return Path(path).read_bytes()
    except OSError:
        return b''


@cache
def digest(path: str) -> str:
    """Return the hash of a file."""
    return hashlib.sha256(contents(path)).hexdigest()


def token(x: Any) -> str:
    """Return the value of a name at compile time, as text."""
    if isinstance(x, ModuleType):
        return f'module {x.__name__}'
    if isinstance(x, type) and hasattr(x, '_fields'):
        return f'{x.__module__}.{x.__qualname__}{x._fields}'
    if isinstance(x, tuple):
        return f'({", ".join(token(item) for item in x)})'
    if x is None or isinstance(x, (bool, int, float, str)):
        return repr(x)
    name = getattr(x, '__qualname__', None) or getattr(x, '__name__', None)
    return f'{getattr(x, "__module__", "")}.{name}' if name else repr(x)


class Dependencies:
    """The files and the values of names that a kernel was translated from.

    Attributes:
        files: hash of each file, by its path.
        names: value of each name, by module and name.
    """

    def __init__(self) -> None:
        self.files: dict[str, str] = {}
        self.names: dict[str, dict[str, str]] = {}

    def file(self, function: Any) -> None:
        """Record the file of a function."""
        path = function.__code__.co_filename
        self.files[path] = digest(path)

    def constant(self, module: str, name: str, value: Any) -> None:
        """Record the value of a module's name."""
        self.names.setdefault(module, {})[name] = token(value)


def is_unchanged(files: dict[str, str], names: dict[str, dict[str, str]]) -> bool:
    """Return whether files and names are unchanged."""
    if any(digest(path) != wanted for path, wanted in files.items()):
        return False
    for module, tokens in names.items():
        now = vars(sys.modules[module]) if module in sys.modules else {}
        for name, wanted in tokens.items():
            if name not in now or token(now[name]) != wanted:
                return False
    return True


# -----------------------------------------------------------------------------
# The syntax trees of kernels, and their properties that do not depend on values.

SIMPLE = 60
"""A function without loops is inlined if its syntax tree has fewer nodes."""

_LOOPS = (ast.For, ast.While)


@cache
def _definitions(path: str) -> dict[tuple[str, int], list[Any]]:
    """Return the functions of a file by kind and first line."""
    tree = ast.parse(contents(path))
    nodes: dict[tuple[str, int], list[Any]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            line = min([node.lineno, *(item.lineno for item in node.decorator_list)])
            nodes.setdefault((node.name, line), []).append(node)
        elif isinstance(node, ast.Lambda):
            nodes.setdefault(('<lambda>', node.lineno), []).append(node)
    return nodes


class FunctionSource:
    """The source of a function.

    Attributes:
        arguments: names of its arguments.
        body: statements.
        simple: whether it is short and has no loop.
    """

    def __init__(self, code: CodeType) -> None:
        nodes = _definitions(code.co_filename).get((code.co_name, code.co_firstlineno), [])
        if len(nodes) != 1:
            raise KernelError(
                f'the source of {code.co_qualname} is not at {code.co_filename}:'
                f'{code.co_firstlineno}. Import the file again if it has changed, and give each '
                'lambda a line of its own'
            )
        node = nodes[0]
        kind = node.args
        if kind.vararg or kind.kwarg or kind.kwonlyargs:
            raise KernelError(f'{code.co_qualname} has arguments with * or by keyword only')
        self.arguments = [arg.arg for arg in (*kind.posonlyargs, *kind.args)]
        if isinstance(node, ast.Lambda):
            self.body: list[Any] = [ast.copy_location(ast.Return(value=node.body), node)]
        else:
            head = node.body[0]
            documented = isinstance(head, ast.Expr) and isinstance(head.value, ast.Constant)
            self.body = node.body[1:] if documented else node.body
        parts = [node for statement in self.body for node in ast.walk(statement)]
        looped = any(isinstance(node, _LOOPS) for node in parts)
        self.simple = not looped and len(parts) < SIMPLE


@cache
def source_of(function: FunctionType) -> FunctionSource:
    """Return the source of a function."""
    return FunctionSource(function.__code__)


def is_inlined(function: FunctionType) -> bool:
    """Return whether a function is translated at its call."""
    return function in IS_INLINED or source_of(function).simple


def arguments_of(
    function: FunctionType, args: list[Any], keywords: dict[str, Any]
) -> dict[str, Any]:
    """Return the arguments of a call by name, or raise a KernelError if they do not fit."""
    names, defaults = source_of(function).arguments, function.__defaults__ or ()
    values = dict(zip(names[len(names) - len(defaults) :], defaults, strict=True))
    values.update(zip(names, args, strict=False))
    values.update(keywords)
    if len(args) > len(names) or set(values) != set(names):
        raise KernelError(
            f'{function.__qualname__} takes {", ".join(names)}; '
            f'{len(args)} and {", ".join(keywords) or "none"} by name are given'
        )
    return values


@cache
def assigned_in(loop: Any) -> tuple[str, ...]:
    """Return the names that a loop sets, in order of first appearance."""
    return tuple(
        dict.fromkeys(
            node.id
            for node in ast.walk(loop)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        )
    )


@cache
def leaves_early(loop: Any) -> bool:
    """Return whether a loop, or a loop within it, has a break or continue."""
    return any(isinstance(node, (ast.Break, ast.Continue)) for node in ast.walk(loop))


@cache
def indexed_by(loop: Any) -> frozenset[str]:
    """Return the names of the values that a loop's variable indexes."""
    if not isinstance(loop.target, ast.Name):
        return frozenset()
    return frozenset(
        node.value.id
        for node in ast.walk(loop)
        if isinstance(node, ast.Subscript)
        and isinstance(node.value, ast.Name)
        and any(isinstance(n, ast.Name) and n.id == loop.target.id for n in ast.walk(node.slice))
    )


# -----------------------------------------------------------------------------
# Arrays and tuples as arguments of entries (`entries`).

DATA, DIMENSIONS, FLAGS = 0, 16, 48
"""Offsets behind the head of NumPy's array object, PyArrayObject_fields in ndarraytypes.h.

Programs compiled with NumPy depend on them.
"""

NEEDED_FLAGS = 0x0001 | 0x0100
"""C-contiguous and aligned."""


class ArrayStructure(NamedTuple):
    """An array: the type of its items and the number of its dimensions."""

    dtype: Any
    ndim: int


class Tuple(NamedTuple):
    """A tuple, or a NamedTuple of a class."""

    named: Any
    items: tuple[Any, ...]
