"""How a function is marked as a kernel; errors, warnings, and listeners to what compiles.

Nothing of LLVM is imported here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FunctionType
from typing import Any, TypeVar

from tauto_core.scene.errors import TautoError

# -----------------------------------------------------------------------------
# Errors and warnings of kernels.


class KernelError(TautoError):
    """A kernel cannot be compiled; the message says what, and where in which file.

    Attributes:
        places: file, line and function of the fault, and of each call on the way to it.
        passed: the lowering that added the last of them.
    """

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.places: list[str] = []
        self.passed: object = None

    def __str__(self) -> str:
        return '\n  '.join([super().__str__(), *self.places])


class KernelCacheWarning(UserWarning):
    """Compiled kernels cannot be stored, so that each run compiles them again."""


Function = TypeVar('Function', bound=Callable[..., Any])

IS_INLINED: set[Any] = set()


def compiled(function: Function) -> Function:
    """Mark a function that kernels call; called from Python it runs as Python."""
    return function


def inlined(function: Function) -> Function:
    """Mark a function that is inlined wherever it is called: short, or in a hot loop."""
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

    Its first argument is an `values.Emission`, which kernels do not pass; the others are the
    arguments as they are known when compiling; it returns a value likewise.
    """
    return Intrinsic(function)


def plain_function(callee: Any) -> FunctionType | None:
    """Return the function of Python that a callee is, or that it is made from."""
    callee = getattr(callee, 'python', callee)
    return callee if isinstance(callee, FunctionType) else None


# -----------------------------------------------------------------------------
# Listeners that are informed when something compiles, and how long it is likely to take.

_listeners: list[Callable[[str | None, float], None]] = []


@contextmanager
def listening(listener: Callable[[str | None, float], None]) -> Iterator[None]:
    """Call a function whenever a kernel begins to compile, and when it is done.

    Args:
        listener: gets the kernel's name and about the seconds left, 0 while they are not known;
            None when it is done.
    """
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


@contextmanager
def compiling(name: str) -> Iterator[Callable[[float], Any]]:
    """Tell the listeners that a kernel compiles; yield what tells them the seconds left."""

    def say(kernel: str | None, left_s: float) -> None:
        for listener in _listeners:
            listener(kernel, left_s)

    say(name, 0.0)
    try:
        yield lambda left_s: say(name, left_s)
    finally:
        say(None, 0.0)
