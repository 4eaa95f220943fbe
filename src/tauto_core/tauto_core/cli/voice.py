"""Messages of the commands besides their result: on stderr, and none with --quiet."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from tauto_core.scene import Scene

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


def say_oddities(scene: Scene, origin: str, *, anyway: bool) -> list[str]:
    """Print and return warnings about a scene to be sailed; refuse it beyond all that is known.

    Args:
        scene: the scene.
        origin: file or name that the user gave.
        anyway: do not refuse it.

    Raises:
        SceneError: see `readiness.check_known`.
    """
    from tauto_core.readiness import check_known, oddities
    from tauto_core.scene.errors import naming

    with naming(origin, scene.name):
        if not anyway:
            check_known(scene)
        odd = oddities(scene)
    for warning in odd:
        say(warning)
    return odd


def say_warnings() -> None:
    """Print the package's own Python warnings from now on as messages."""
    shown = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if category.__module__.startswith('tauto_core.'):
            say(str(message))
        else:
            shown(message, category, *where, **more)

    warnings.showwarning = show
