"""Commands that are more than one call, or none.

`tauto plot` and `tauto report` print warnings before a scene sails and have a default file. `tauto
cam` prints a few points. `tauto fleet` also sails the passages of a log-book. `tauto scene show`
and `schema` print files.
"""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from tauto_core import api
from tauto_core.cli.calls import Command, signature_of
from tauto_core.cli.terminal import (
    SceneName,
    ended_by_sigterm,
    progress_bar,
    say,
    say_plausibility,
)
from tauto_core.scene.errors import Argument, UsageError, naming
from tauto_core.wording import left_out

if TYPE_CHECKING:
    from tauto_core.voyage import Voyage

_UNIT = (
    'in the unit of the time axis of `plot error` (days for a voyage of two days or more, then '
    'hours, minutes, seconds) or with a unit, such as 36 h'
)
_TEN = 'Without --from and --to: the roughest ten minutes.'


def _text(name: str, metavar: str, words: str) -> Any:
    return Annotated[str | None, typer.Option(name, metavar=metavar, help=words)]


def _file(words: str) -> Any:
    return Annotated[Path | None, typer.Option('--out', '-o', metavar='FILE', help=words)]


OF_PLOT = {
    'file': _file('Ending in .svg, .png or .pdf, which is replaced. Default: NAME_WHAT.svg.'),
    'from_s': _text('--from', 'T', f'Begin roll or spectrum here, {_UNIT}. {_TEN}'),
    'to_s': _text('--to', 'T', 'End it here. Default: ten minutes after --from.'),
}
OF_REPORT = {'file': _file('Ending in .html, which is replaced. Default: NAME.html.')}


CAM_FILES = ('csv', 'svg', 'dxf', 'step', 'stl')
SHOWN = 11
"""Number of printed points of a cam."""


USED = {
    'weather': ('ship', 'voyage'),
    'cam': ('drag', 'escapement'),
    'machine': ('drag', 'escapement', 'suspension'),
}
"""Sections, in addition to the machine's, that affect a picture of a scene."""


def plot(given: dict[str, Any]) -> None:
    """Draw one picture. Times without a unit are in the unit of its axis."""
    from tauto_core.plots.contents import OF_A_SCENE, check_picture, time_unit

    source, what = given.pop('source'), given.pop('what')
    ends = {name: given.pop(name, None) for name in ('from_s', 'to_s')}
    file = given.setdefault('file', Path(f'{title_of(source)}_{what}.svg'))
    check_picture(what, file, part=any(end is not None for end in ends.values()))
    for name, text in ends.items():
        _on_axis(name, text, 1.0)  # checks the text before the scene sails
    voyage = _voyage(source, given, sails=what not in OF_A_SCENE)
    unit_s = 1.0
    if voyage.samples:
        unit_s, _ = time_unit(float(voyage.time_s[-1]))
    part = {name: _on_axis(name, text, unit_s) for name, text in ends.items()}
    with naming(source, voyage.scene.name):
        api.plot(voyage, what, file, from_s=part['from_s'], to_s=part['to_s'])
    if what in USED:
        for words in left_out(voyage.scene.sections_besides(*USED[what])):
            say(words)


def report(given: dict[str, Any]) -> None:
    """Write a page, which shows its command."""
    from tauto_core.plots.page import check_report, write_report

    source = given.pop('source')
    file = given.setdefault('file', Path(f'{title_of(source)}.html'))
    check_report(file)
    words = ['tauto', *(sys.argv[1:] or ['report', source])]
    voyage = _voyage(source, given)
    say('drawing')
    write_report(voyage, file, shlex.join(words))


def cam(given: dict[str, Any]) -> Any:
    """Return a cam, by default with few points if they are only printed."""
    is_read = given.keys().isdisjoint(CAM_FILES) and not given['plate']
    if is_read:
        given.setdefault('points', SHOWN)
    with progress_bar('cam'):
        return api.cam(**given)


def fleet(given: dict[str, Any]) -> Any:
    """Send many ships on one voyage, or clocks along the passages of a log-book."""
    call, other_call = ('trial', 'fleet') if 'logs' in given else ('fleet', 'trial')
    unknown = signature_of(other_call).keys() - signature_of(call).keys()
    for name, value in given.items():
        if name in unknown and value is not False:
            wrong = ': needs ', Argument('logs'), '. Name a log-book, or leave it out'
            if call == 'trial':
                wrong = ': does not go with ', Argument('logs'), '. Leave one of them out'
            raise UsageError(Argument(name, value), *wrong)
    chosen = {key: value for key, value in given.items() if key not in unknown}
    things = 'voyages' if call == 'trial' else 'ships'
    with ended_by_sigterm(), progress_bar(things) as progress:
        return getattr(api, call)(**chosen, progress=progress)


class NewCommand(TyperCommand):
    """`tauto scene new`: its help lists the installed kinds."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help, with the kinds of each section."""
        from tauto_core.scene.reference import CHOICES
        from tauto_core.scene.sections import kind_of, kinds_in

        for parameter in self.params:
            if parameter.name in CHOICES:
                kinds = ', '.join(map(kind_of, kinds_in(CHOICES[parameter.name])))
                parameter.help = f'One of {kinds}.'  # type: ignore[attr-defined]
        super().format_help(ctx, formatter)


def show(scene: SceneName) -> None:
    """Print the file of a scene, with its comments."""
    from tauto_core.scene.loader import scene_text

    typer.echo(scene_text(scene), nl=False)


def schema() -> None:
    """Print the JSON schema of scenes, for editors."""
    from tauto_core.scene.reference import FILE

    typer.echo(FILE.read_text(encoding='utf-8'), nl=False)


def title_of(source: str) -> str:
    """Return the folder's name, or the file's name without its suffix, as a title."""
    place = Path(os.path.abspath(source))  # `.` has no name
    return place.name if place.is_dir() else place.stem


def _on_axis(name: str, text: str | None, unit_s: float) -> float | None:
    """Return a time [s], given in the unit of the axis or with its own unit."""
    from tauto_core.scene.units import in_words, quantity

    if text is None:
        return None
    return quantity(text, 's', Argument(name, repr(text))) * (1.0 if in_words(text) else unit_s)


def _voyage(source: str, given: Mapping[str, Any], *, sails: bool = True) -> Voyage:
    """Print warnings about a bag or a scene, and return its voyage."""
    anyway = given['anyway']
    values = {key: value for key, value in given.items() if key not in ('anyway', 'file')}
    if api.is_bag(source):
        voyage = api.voyage_of(source, values, None, anyway=anyway)
        for warning in voyage.result['warnings']:
            say(warning)
        return voyage
    scene = api.load(source, **values)
    say_plausibility(scene, source, anyway=anyway or not sails)
    with naming(source, scene.name), progress_bar(scene.name) as progress:
        return api.voyage_of(scene, {}, progress, anyway=anyway, sails=sails)


def _nothing(*_: object) -> None:
    """Print no result, since it is a file."""


_DRAWN: dict[str, Any] = {'has_json': False, 'has_scene': True, 'writes': ('file',)}
PLOT = Command(('plot',), _nothing, instead=OF_PLOT, run=plot, **_DRAWN)
REPORT = Command(('report',), _nothing, instead=OF_REPORT, run=report, **_DRAWN)
