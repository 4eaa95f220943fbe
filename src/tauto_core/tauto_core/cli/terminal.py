"""Text and tables on a terminal, in a file or for another program."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from rich.console import RenderableType


def print_rich(*parts: RenderableType, err: bool = False) -> None:
    """Print texts and tables below each other, without blanks at the ends of lines.

    Args:
        parts: what to print; a text stands as it is, without rich's markup.
        err: whether on stderr, in place of stdout.
    """
    from rich.console import Console

    console = Console(stderr=err, highlight=False, markup=False)
    with console.capture() as captured:
        for part in parts:
            console.print(part, crop=False)
    lines = captured.get().splitlines()
    typer.echo('\n'.join(line.rstrip() for line in lines), err=err)
