"""`tauto scene new`: a scene to start from. `tauto scene schema`: what editors check it with."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import Annotated

import typer

from tauto_core.cli.voice import say
from tauto_core.scene.errors import UsageError

Kind = str | None

_ENDINGS = ('.yaml', '.yml')
"""A word without them may be the name of a shipped scene."""


def new(
    ship: Annotated[
        Kind, typer.Option(metavar='KIND', help='still, components, sea or recorded.')
    ] = None,
    cam: Annotated[
        Kind,
        typer.Option(metavar='KIND', help='involute, hole, circular_arc, weight_corrected, …'),
    ] = None,
    thread: Annotated[
        Kind, typer.Option(metavar='KIND', help='vertical, hole, lever or hanging.')
    ] = None,
    power: Annotated[
        Kind, typer.Option(metavar='KIND', help='force, weight, spring or weight_and_spring.')
    ] = None,
    escapement: Annotated[
        Kind, typer.Option(metavar='KIND', help='impulse or remontoire; without it there is none.')
    ] = None,
    out: Annotated[
        str | None,  # a Path drops the slash of a folder
        typer.Option(
            '--out',
            '-o',
            metavar='FILE',
            help='The file, ending in .yaml; without it, standard output.',
        ),
    ] = None,
) -> None:
    """Write a scene that sails, with the unit and meaning of every key.

    Kinds that are not asked for are chosen to go with those that are; with none asked for it is
    Euler's involute under a weight, in a wind sea.
    """
    from tauto_core.scene.template import new_scene

    if out is not None:
        _check_file(out)
    asked = {'ship': ship, 'cam': cam, 'thread': thread, 'power': power, 'escapement': escapement}
    # the name of a file need not be text, that of a scene is
    name = 'new_scene' if out is None else Path(out).stem.encode('utf-8', 'replace').decode()
    text = new_scene(name, {key: kind for key, kind in asked.items() if kind is not None})
    if out is None:
        typer.echo(text, nl=False)
        return
    try:
        with Path(out).open('x', encoding='utf-8') as file:
            file.write(text)
    except OSError as error:
        raise UsageError(
            f'--out {out}: cannot be written: {error.strerror}. Name another file'
        ) from None
    say(f'wrote {out}. Sail it with: {shlex.join(("tauto", "sail", out))}')


def _check_file(out: str) -> None:
    """Refuse a name at which no new file can be, or that a later command may not take for one."""
    if out.endswith(os.sep) or Path(out).is_dir():
        raise UsageError(f'--out {out}: is a folder. Name a file in it, such as new.yaml')
    if Path(out).exists():
        raise UsageError(f'--out {out}: exists, and is not replaced. Name another file')
    if not out.endswith(_ENDINGS):
        near = Path(out).with_suffix(_ENDINGS[0])
        raise UsageError(f'--out {out}: must end in {" or ".join(_ENDINGS)}. Use {near}')


def schema() -> None:
    """Print the JSON schema with which editors check scenes."""
    from tauto_core.scene.schema import FILE

    typer.echo(FILE.read_text(encoding='utf-8'), nl=False)
