"""`tauto plot` and `tauto report`: a voyage to look at."""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tauto_core.cli.options import Duration, Settings, given_values
from tauto_core.cli.voice import say
from tauto_core.scene.errors import UsageError

if TYPE_CHECKING:
    from tauto_core.record import Voyage

Source = Annotated[
    str,
    typer.Argument(metavar='BAG|SCENE', help='A bag, or a scene, which is sailed for it.'),
]
_WHAT = (
    'error, rate, drift, longitude, stability, amplitude, phase, roll, spectrum, map, cam or '
    'machine.'
)


def plot(
    source: Source,
    what: Annotated[str, typer.Argument(metavar='WHAT', help=_WHAT)],
    out: Annotated[
        Path | None,
        typer.Option(
            '--out',
            '-o',
            metavar='FILE',
            help='Ending in .svg, .png or .pdf; is replaced. Default: NAME_WHAT.svg.',
        ),
    ] = None,
    duration: Duration = None,
    settings: Settings = None,
) -> None:
    """Draw one picture of a bag or a scene."""
    from tauto_core.pictures import check_picture

    file = out or Path(f'{title_of(source)}_{what}.svg')
    check_picture(what, file)
    _voyage(source, given_values(settings, duration)).plot(what, file)
    _written(file)


def report(
    source: Source,
    out: Annotated[
        Path | None,
        typer.Option(
            '--out', '-o', metavar='FILE', help='Ending in .html; is replaced. Default: NAME.html.'
        ),
    ] = None,
    duration: Duration = None,
    settings: Settings = None,
) -> None:
    """Write a page of all figures, with the machine as it moves."""
    from tauto_core.reporting import check_report, write_report

    file = out or Path(f'{title_of(source)}.html')
    check_report(file)
    command = (
        shlex.join(['tauto', *sys.argv[1:]]) if len(sys.argv) > 1 else f'tauto report {source}'
    )
    voyage = _voyage(source, given_values(settings, duration))
    say('drawing')
    write_report(voyage, file, command)
    _written(file)


def _voyage(source: str, given: dict[str, Any]) -> Voyage:
    from tauto_core.api import is_bag
    from tauto_core.cli.progress import progress_bar
    from tauto_core.record import replay_voyage, sail_voyage
    from tauto_core.scene import load_scene
    from tauto_core.scene.plausible import implausible

    if is_bag(source):
        if given:
            raise UsageError(
                '--duration and --set are for a scene, and a bag was sailed already. Leave '
                'them out'
            )
        voyage = replay_voyage(Path(source))
        said = voyage.result['warnings']
    else:
        scene = load_scene(source, **given)
        for warning in implausible(scene):
            say(warning)
        with progress_bar(scene.name) as progress:
            voyage = sail_voyage(scene, origin=source, progress=progress)
        said = ()
    for warning in said:
        say(warning)
    return voyage


def title_of(source: str) -> str:
    """Return a name for what is drawn: that of a folder whole, of a file without its suffix."""
    place = Path(os.path.abspath(source))  # `.` has no name
    return place.name if place.is_dir() else place.stem


def _written(file: Path) -> None:
    """Name what was written."""
    say(f'wrote {file}')
