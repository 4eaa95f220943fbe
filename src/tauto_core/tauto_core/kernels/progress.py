"""Listeners that are informed when something compiles, and how long it is likely to take."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

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
