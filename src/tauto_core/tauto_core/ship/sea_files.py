"""The files from which a sea is computed, read into the scene before it is checked.

A scene that runs contains tables and numbers, no paths, so a bag needs nothing but its text.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any, TypeVar

from pydantic import ValidationError

from tauto_core.scene.data import missing_file
from tauto_core.scene.errors import Problem, SceneError
from tauto_core.scene.explain import explain
from tauto_core.scene.fields import Section
from tauto_core.ship.response_file import RaoFile, read_operator
from tauto_core.ship.roll_decay import RollFromDecay, fitted_roll
from tauto_core.ship.spectrum_file import SpectrumFile, read_spectrum
from tauto_core.ship.weather_file import RecordFile, read_record

S = TypeVar('S', bound=Section)

FILE_FORMS: dict[str, type[Section]] = {
    'sea': SpectrumFile,
    'rao': RaoFile,
    'roll': RollFromDecay,
    'weather': RecordFile,
}
"""The form of each section of a sea's ship whose values are in a file."""


def with_files_read(ship: dict[str, Any], origin: str) -> dict[str, Any]:
    """Return the keys of a ship with tables and numbers in place of the files of its sea.

    `ship.sea` of spectrum file becomes a table, `ship.rao` with a path the operator at its
    heading, `ship.roll` with a decay its period and damping ratio, `ship.weather` of a record its
    rows. The rest is not changed.

    Args:
        ship: keys and values as read, not checked yet.
        origin: name of the scene as the user wrote it, for error messages.

    Raises:
        SceneError: keys that are wrong, with their path; files that are missing or wrong, with
            file and line.
    """
    read = dict(ship)
    if _holds(ship, 'sea', 'spectrum') and ship['sea']['spectrum'] == 'file':
        read['sea'] = _read(SpectrumFile, read_spectrum, ship, 'sea.path', origin)
    if _holds(ship, 'rao', 'path'):
        read['rao'] = _read(RaoFile, read_operator, ship, 'rao.path', origin)
    if _holds(ship, 'roll', 'decay'):
        read['roll'] = _read(RollFromDecay, fitted_roll, ship, 'roll.decay.path', origin)
    if _holds(ship, 'weather', 'path') and ship['weather'].get('kind') == 'record':

        def read_weather(asked: RecordFile) -> dict[str, Any]:
            # a response operator has a heading of its own
            by_direction = asked.follow_route and ship.get('rao') is None
            return read_record(asked, by_direction=by_direction)

        read['weather'] = _read(RecordFile, read_weather, ship, 'weather.path', origin)
    return read


def _holds(ship: dict[str, Any], section: str, key: str) -> bool:
    return isinstance(ship.get(section), dict) and key in ship[section]


def _read(
    form: type[S],
    reader: Callable[[S], dict[str, Any]],
    ship: dict[str, Any],
    path: str,
    origin: str,
) -> dict[str, Any]:
    """Return the contents of a section, from the file that its `path` names."""
    section, *names = path.split('.')
    try:
        asked = form.model_validate(ship[section])
    except ValidationError as error:
        found = [
            Problem(f'ship.{section}.{each.key}', each.value, each.problem, each.remedy)
            for each in explain(error, form)
        ]
    else:
        found = missing_file(f'ship.{path}', str(reduce(getattr, names, asked)))
        if not found:
            return reader(asked)
    first, *further = found
    raise SceneError(
        origin, first.key, first.value, first.problem, first.remedy, further=further
    ) from None
