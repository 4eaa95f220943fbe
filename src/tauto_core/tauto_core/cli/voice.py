"""What the commands say beside their result: on stderr, and nothing of it with --quiet."""

from __future__ import annotations

import typer

_state = {'quiet': False}


def be_quiet(quiet: bool) -> None:
    """Say nothing but results and errors from now on, or speak again."""
    _state['quiet'] = quiet


def is_quiet() -> bool:
    """Return whether only results and errors are wanted."""
    return _state['quiet']


def say(words: str) -> None:
    """Say on stderr what a user may want to know and can do without."""
    if not is_quiet():
        typer.echo(f'tauto: {words}', err=True)
