"""SIGTERM as an exception, so that a run ends as after Ctrl-C."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager


class Terminated(KeyboardInterrupt):
    """SIGTERM came during a run."""


@contextmanager
def ended_by_sigterm() -> Iterator[None]:
    """Turn SIGTERM into `Terminated` for as long as the context lasts."""

    def end(_number: int, _frame: object) -> None:
        raise Terminated

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
