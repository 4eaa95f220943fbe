"""Who wants to know that something compiles, and how long it is likely to take."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

LINES_PER_S = 9_000.0
"""Lines of LLVM's text that this compiler and LLVM take a second for, on a common machine."""

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
def compiling(name: str) -> Iterator[Callable[[int], Any]]:
    """Tell the listeners that a kernel compiles; yield what tells them its lines."""

    def say(kernel: str | None, left_s: float) -> None:
        for listener in _listeners:
            listener(kernel, left_s)

    say(name, 0.0)
    try:
        yield lambda lines: say(name, lines / LINES_PER_S)
    finally:
        say(None, 0.0)
