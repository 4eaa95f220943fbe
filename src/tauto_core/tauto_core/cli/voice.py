"""Messages of the commands besides their result: on stderr, and none with --quiet."""

from __future__ import annotations

import warnings
from typing import Any

import typer

_state = {'quiet': False}


def be_quiet(quiet: bool) -> None:
    """Print only results and errors from now on, or print messages again."""
    _state['quiet'] = quiet


def is_quiet() -> bool:
    """Return whether only results and errors are wanted."""
    return _state['quiet']


def say(words: str) -> None:
    """Print a message on stderr that is useful but not part of the result."""
    if not is_quiet():
        typer.echo(f'tauto: {words}', err=True)


def say_warnings() -> None:
    """Print the package's own Python warnings from now on as messages."""
    shown = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if category.__module__.startswith('tauto_core.'):
            say(str(message))
        else:
            shown(message, category, *where, **more)

    warnings.showwarning = show
