"""`tauto plot` and `tauto report`: a voyage to look at."""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tauto_core.cli.terminal import Anyway, Duration, Settings, given_values, say, say_oddities
from tauto_core.scene.errors import UsageError, naming

if TYPE_CHECKING:
    from tauto_core.voyage import Voyage


Source = Annotated[
    str,
    typer.Argument(metavar='BAG|SCENE', help='A bag, or a scene, which is sailed for it.'),
]
_WHAT = (
    'error, rate, drift, longitude, stability, amplitude, phase, weather, roll, spectrum, map, '
    'cam or machine.'
)
_UNIT = (
    'in the unit of the time axis of `plot error`: days for a voyage of two days or more, then '
)
_UNIT += 'hours, minutes, seconds'


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
    from_time: Annotated[
        float | None,
        typer.Option(
            '--from',
            metavar='T',
            help=f'Begin roll or spectrum here, {_UNIT}. Without --from and --to: the roughest '
            'ten minutes.',
        ),
    ] = None,
    to_time: Annotated[
        float | None,
        typer.Option('--to', metavar='T', help='End it here; default: ten minutes after --from.'),
    ] = None,
    duration: Duration = None,
    settings: Settings = None,
    anyway: Anyway = False,
) -> None:
    """Draw one picture of a bag or a scene.

    Pictures of a scene alone (weather, cam, machine) are drawn without sailing it.
    """
    from tauto_core.api import is_bag
    from tauto_core.plots.contents import OF_A_SCENE, check_picture, time_unit
    from tauto_core.scene import load_scene
    from tauto_core.voyage import Voyage

    file = out or Path(f'{title_of(source)}_{what}.svg')
    check_picture(what, file, part=from_time is not None or to_time is not None)
    given = given_values(settings, duration)
    if what in OF_A_SCENE and not is_bag(source):
        scene = load_scene(source, **given)
        say_oddities(scene, source, anyway=True)  # it does not sail
        with naming(source, scene.name):
            Voyage(scene, {}, {}).plot(what, file)
    else:
        voyage = _voyage(source, given, anyway)
        unit_s, _ = time_unit(float(voyage.time_s[-1]))
        begin, end = (None if at is None else at * unit_s for at in (from_time, to_time))
        voyage.plot(what, file, from_s=begin, to_s=end)
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
    anyway: Anyway = False,
) -> None:
    """Write a page of all figures, with the machine as it moves."""
    from tauto_core.plots.page import check_report, write_report

    file = out or Path(f'{title_of(source)}.html')
    check_report(file)
    command = (
        shlex.join(['tauto', *sys.argv[1:]]) if len(sys.argv) > 1 else f'tauto report {source}'
    )
    voyage = _voyage(source, given_values(settings, duration), anyway)
    say('drawing')
    write_report(voyage, file, command)
    _written(file)


def _voyage(source: str, given: dict[str, Any], anyway: bool) -> Voyage:
    from tauto_core.api import is_bag
    from tauto_core.bags import read_bag
    from tauto_core.cli.terminal import progress_bar
    from tauto_core.scene import load_scene
    from tauto_core.voyage import replay, sail

    if is_bag(source):
        if given:
            raise UsageError(
                '--duration and --set are for a scene, and a bag was sailed already. Leave '
                'them out'
            )
        voyage = replay(read_bag(Path(source)))
        said = voyage.result['warnings']
    else:
        scene = load_scene(source, **given)
        say_oddities(scene, source, anyway=anyway)
        with progress_bar(scene.name) as progress:
            voyage = sail(scene, origin=source, anyway=anyway, progress=progress)
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
