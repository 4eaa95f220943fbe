"""Messages of the commands besides their result: on stderr, and none with --quiet."""

from __future__ import annotations

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
