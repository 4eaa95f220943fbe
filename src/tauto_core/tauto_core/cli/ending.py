"""SIGTERM as an exception, so that a run ends as after Ctrl-C; and neither is lost."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_AGAIN_S = 0.05
"""Time after which a lost signal is sent again: what lost it has ended by then."""


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


def send_lost_again() -> None:
    """Send SIGINT or SIGTERM again where Python has lost its exception.

    An exception in a callback, such as that which frees the lock of an import, is reported and
    forgotten: Ctrl-C would do nothing.
    """
    report = sys.unraisablehook

    def hear(lost: sys.UnraisableHookArgs) -> None:
        if not issubclass(lost.exc_type, KeyboardInterrupt):
            report(lost)
            return
        number = signal.SIGTERM if issubclass(lost.exc_type, Terminated) else signal.SIGINT
        again = threading.Timer(_AGAIN_S, os.kill, (os.getpid(), number))
        again.daemon = True
        again.start()

    sys.unraisablehook = hear
