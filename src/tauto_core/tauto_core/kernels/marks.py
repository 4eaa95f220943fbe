"""How a function is marked as a kernel; nothing of LLVM is imported here."""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import Any, TypeVar

from tauto_core.kernels.errors import KernelError

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

    Its first argument is an `emission.Emission`, which kernels do not pass; the others are the
    arguments as they are known when compiling; it returns a value likewise.
    """
    return Intrinsic(function)


def plain_function(callee: Any) -> FunctionType | None:
    """Return the function of Python that a callee is, or that it is made from."""
    callee = getattr(callee, 'python', callee)
    return callee if isinstance(callee, FunctionType) else None
