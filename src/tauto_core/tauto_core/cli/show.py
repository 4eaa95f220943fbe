"""`tauto plot` and `tauto report`: a voyage to look at."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tauto_core.cli.terminal import Anyway, Duration, Settings, given_values, say, say_oddities
from tauto_core.files import write_figure
from tauto_core.scene.errors import UsageError, naming

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from tauto_core.voyage import Voyage


# -----------------------------------------------------------------------------
# The stability of a clock as a figure.

_FREQUENCY = {
    'allan': ('Allan', '#c1121f', 'o'),
    'modified': ('modified Allan', '#003f88', 's'),
    'hadamard': ('Hadamard', '#2a9d5c', '^'),
}
_TIME = {'time': ('time', '#7b2cbf', 'D')}


def draw(stability: Mapping[str, Any], title: str, path: Path) -> None:
    """Draw deviations against τ, with their confidence intervals; replaces the file.

    Args:
        stability: what `stability_of` returns.
        title: title of the figure.
        path: name of the file, ending in .svg, .png or .pdf.

    Raises:
        OutputError: the file cannot be written.
        UsageError: see `files.check_plot`.
    """
    write_figure(lambda: stability_figure(stability, title), path)


def stability_figure(stability: Mapping[str, Any], title: str) -> Figure:
    """Return the figure: deviations of frequency on the left, of time on the right."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.6, 4.0), layout='constrained')
    left, right = figure.subplots(1, 2)
    _panel(left, stability['rows'], _FREQUENCY, 'deviation of relative frequency')
    _panel(right, stability['rows'], _TIME, 'time deviation [s]')
    left.legend(frameon=False)
    percent = 100.0 * stability['confidence']
    figure.suptitle(
        f'{title}: stability from {stability["samples"]:,} readings, bars hold {percent:g} %',
        fontsize=11.0,
    )
    return figure


def _panel(
    axes: Axes,
    rows: list[Mapping[str, Any]],
    kinds: Mapping[str, tuple[str, str, str]],
    label: str,
) -> None:
    taus = [row['tau_s'] for row in rows]
    for kind, (name, color, marker) in kinds.items():
        values = [row[kind] for row in rows]
        bars = (
            [row[kind] - row[f'{kind}_low'] for row in rows],
            [row[f'{kind}_high'] - row[kind] for row in rows],
        )
        axes.errorbar(
            taus,
            values,
            yerr=bars,
            color=color,
            marker=marker,
            markersize=4.5,
            capsize=2.5,
            linewidth=1.2,
            label=name,
        )
    axes.set_xscale('log')
    axes.set_yscale('log')
    axes.set_xlabel('averaging time τ [s]')
    axes.set_ylabel(label)
    axes.grid(color='#dddddd', linewidth=0.5)
    axes.set_axisbelow(True)
    for side in ('top', 'right'):
        axes.spines[side].set_visible(False)


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
    from tauto_core.plots.contents import OF_A_SCENE, time_unit
    from tauto_core.plots.renderer import check_picture
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
