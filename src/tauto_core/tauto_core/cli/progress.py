"""The progress bar."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tauto_core.cli.voice import is_quiet


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], None]]:
    """Show a bar on stderr, if that is a terminal, for as long as the context lasts.

    While a kernel compiles, the label names it, with the time that it takes.

    Args:
        label: text in front of the bar.

    Yields:
        A function to call with the share done so far, from 0 to 1.
    """
    if not sys.stderr.isatty() or is_quiet():
        yield lambda _share: None
        return
    from rich.console import Console
    from rich.progress import Progress

    from tauto_core.kernels import listening

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=1.0)

        def compiles(kernel: str | None, left_s: float) -> None:
            said = label if kernel is None else f'{label}: {_compiling(kernel, left_s)}'
            bar.update(task, description=said)

        with listening(compiles):
            yield lambda share: bar.update(task, completed=share)


@contextmanager
def counting_bar(things: str, total: int) -> Iterator[Callable[[float], None]]:
    """Show a bar on stderr, as `progress_bar` does, with the rate and the time left.

    Args:
        things: the things that are counted, in the plural.
        total: their number.

    Yields:
        A function to call with the number done so far, parts included.
    """
    if not sys.stderr.isatty() or is_quiet():
        yield lambda _done: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    said = f'{{task.completed:,.0f}} of {{task.total:,.0f}} {things}'
    columns = (
        TextColumn(said),
        BarColumn(),
        TextColumn('{task.fields[rate]}'),
        TimeRemainingColumn(),
        TextColumn('left'),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(things, total=total, rate='')

        def tell(done: float) -> None:
            speed = bar.tasks[task].speed
            bar.update(task, completed=done, rate=f'{speed:.3g} a second' if speed else '')

        yield tell


def _compiling(kernel: str, left_s: float) -> str:
    """Return the label while a kernel compiles, with seconds where they are known."""
    name = kernel.removeprefix('tauto_core.')
    return f'compiling {name} once' + (f', about {left_s:.1f} s' if left_s else '')
