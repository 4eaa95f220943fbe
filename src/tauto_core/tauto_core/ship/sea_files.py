"""The files from which a sea is computed: operators, spectra, hulls, buoy records.

A running scene holds tables and numbers instead of paths, so a bag needs only its text.
"""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial, reduce
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import Field, Strict, ValidationError

from tauto_core.scene.errors import ABSENT, Problem, SceneError
from tauto_core.scene.refuse import explain
from tauto_core.scene.sections import LONGEST_TEXT, OneLine, Positive, Section
from tauto_core.scene.tables import (
    Column,
    Columns,
    data_path,
    missing_file,
    read_data,
    read_header,
    read_table,
    source_name,
    utc,
)
from tauto_core.ship.sea import neighbours
from tauto_core.ship.sections import (
    ATHWART,
    MOTIONS,
    RAO_HEADING_MEANS,
    RAO_LENGTH_MEANS,
    ComponentCount,
    Heading,
    HullWeights,
)
from tauto_core.ship.weathers import HIGHEST_M, WeatherKind

# -----------------------------------------------------------------------------
# Response amplitude operators of a ship.
#
# Columns: `heading_deg` (0 following seas, 90 beam seas to port, 180 head seas), `omega_radps` of
# the waves, `speed_mps` under way, and for each known motion its real and imaginary part,
# `surge_re`, `surge_im` and so on [m or rad per m of wave amplitude], as factors of exp(i ω t) at
# the ship's origin, in the axes of theory/ship.md. Other columns are ignored. All headings and
# speeds have the same frequencies, and all speeds the same headings.

HEADING, OMEGA, SPEED = 'heading_deg', 'omega_radps', 'speed_mps'
_PARTS = {'re': 'real', 'im': 'imaginary'}
_OPTIONAL = tuple(
    Column(column, optional=True)
    for column in (SPEED, *(f'{name}_{part}' for name in MOTIONS for part in _PARTS))
)
_OPERATOR_FORM = (
    f'Give a CSV file with the columns {HEADING}, {OMEGA} and, for each motion, its two parts: '
    'roll_re, roll_im, heave_re, heave_im, …'
)


class HullFile(HullWeights):
    """A hull from a file of `tauto hull`. The running scene contains the file."""

    path: OneLine = Field(description='.npz file of `tauto hull`')


def read_hull(file: HullFile) -> dict[str, Any]:
    """Return the keys of `ship.hull`, with the contents of the file as `table`."""
    from tauto_core.ship.hull import HullError, hull_of_file

    content = read_data(data_path(file.path))
    try:
        hull_of_file(content, file.path)
    except HullError as error:
        problem = error.problem
        raise SceneError(file.path, problem.key, ABSENT, problem.problem, problem.remedy) from None
    table = b64encode(content).decode('ascii')
    return {**file.model_dump(exclude={'path'}, exclude_none=True), 'table': table}


class RaoFile(Section):
    """An operator from a file. The running scene contains its values."""

    path: OneLine = Field(description='CSV file of the operator')
    heading: Heading | None = Field(default=None, description=RAO_HEADING_MEANS)
    length: Annotated[float, Strict(), Field(ge=2.0, le=400.0)] | None = Field(
        default=None, description=RAO_LENGTH_MEANS
    )


def read_operator(file: RaoFile) -> dict[str, Any]:
    """Return the keys of `ship.rao`: all headings, or one, interpolated between two.

    By symmetry, waves to starboard (heading > π) have the operator to port, with sway, roll and
    yaw reversed.

    Raises:
        SceneError: headings with different frequencies, or a heading outside the file, with the
            line.
    """
    columns = (Column(HEADING), Column(OMEGA), *_OPTIONAL)
    table = read_table(file.path, columns, remedy=_OPERATOR_FORM)
    parts = {name: [f'{name}_{part}' for part in _PARTS] for name in MOTIONS}
    pairs = {name: pair for name, pair in parts.items() if any(column in table for column in pair)}
    for column in [column for pair in pairs.values() for column in pair] or ['roll_re']:
        if column not in table:
            raise SceneError(
                file.path, f'line 1, column {column}', ABSENT, 'is missing', _OPERATOR_FORM
            )
    blocks = _by_course(table)
    speeds, headings = (sorted({course[i] for course in blocks}) for i in (0, 1))
    under_way = speeds != [0.0]
    keys: dict[str, Any] = {
        'source': source_name(file.path),
        **file.model_dump(exclude={'path'}, exclude_none=True),
        **({'speeds': speeds} if under_way else {}),
        'angular_frequency': table[OMEGA][next(iter(blocks.values()))].tolist(),
    }
    mirrored = False
    if file.heading is None:
        headings = [angle for angle in headings if 0.0 <= angle <= 180.0]
        keys['headings'] = [math.radians(angle) for angle in headings]
        rows = [((k, k, 0.0), speed) for speed in speeds for k in range(len(headings))]
    else:
        mirrored = file.heading > math.pi
        heading = math.degrees(math.tau - file.heading if mirrored else file.heading)
        pair = neighbours(headings, heading)
        if pair is None:
            problem = (
                f'is {heading:.6g} deg off following seas, but the operator {file.path} covers '
                f'{headings[0]:g} to {headings[-1]:g} deg'
            )
            remedy = 'Choose a heading within it.'
            raise SceneError(file.path, 'heading', file.heading, problem, remedy)
        rows = [(pair, speed) for speed in speeds]
    for name, columns_of in pairs.items():
        sign = -1.0 if mirrored and name in ATHWART else 1.0
        for column, part in zip(columns_of, _PARTS.values(), strict=True):
            values = []
            for (below, above, share), speed in rows:
                low, high = (table[column][blocks[speed, headings[k]]] for k in (below, above))
                values += (sign * ((1.0 - share) * low + share * high)).tolist()
            keys[f'{name}_{part}'] = values
    return keys


def _by_course(table: Columns) -> dict[tuple[float, float], list[int]]:
    """Return the rows by speed and heading [m/s, deg], with the same increasing frequencies."""
    blocks: dict[tuple[float, float], list[int]] = {}
    speeds = table[SPEED].tolist() if SPEED in table else [0.0] * len(table)
    for row, course in enumerate(zip(speeds, table[HEADING].tolist(), strict=True)):
        if course[0] < 0.0:
            raise table.refusal(row, SPEED, 'must not be negative', 'Give the speed in m/s.')
        blocks.setdefault(course, []).append(row)
    omega, remedy = table[OMEGA], 'Give every heading the same frequencies, in increasing order.'
    rising = 'greater than the one before'
    block = next(iter(blocks.values()))
    headings = {heading for _, heading in blocks}
    for (speed, heading), rows in blocks.items():
        table.rows(np.array(rows)).check(
            Column(OMEGA, unit='rad/s', above=0.0, rising=rising, remedy=remedy)
        )
        if not np.array_equal(omega[rows], omega[block]):
            problem = (
                f'begins a heading, {heading:g} deg, with other frequencies than the first one'
            )
            raise table.refusal(rows[0], OMEGA, problem, remedy)
        lacking = sorted(angle for angle in headings if (speed, angle) not in blocks)
        if lacking:
            problem = f'begins a speed, {speed:g} m/s, without the heading {lacking[0]:g} deg'
            remedy = 'Give every speed the same headings.'
            raise table.refusal(rows[0], SPEED, problem, remedy)
    if len(block) < 2:
        problem = 'is the only frequency; an operator needs at least 2'
        value = float(omega[block[0]])
        raise SceneError(table.name, OMEGA, value, problem, 'Give it at more frequencies.')
    return blocks


# -----------------------------------------------------------------------------
# Measured wave spectra: CSV files with the columns `frequency_hz` and `energy_density_m2_per_hz`.

FREQUENCY, DENSITY = 'frequency_hz', 'energy_density_m2_per_hz'
_SPECTRUM_FORM = (
    f'Give a CSV file with the columns {FREQUENCY} and {DENSITY}. wavespectra converts the file '
    "of a buoy (docs/seas.md, 'From the file of a buoy')."
)


class SpectrumFile(Section):
    """A measured spectrum from a file. The running scene contains the table."""

    spectrum: Literal['file'] = Field(description='file')
    path: OneLine = Field(description='CSV file of the spectrum')
    components: ComponentCount = Field(default=64, description='number of components, 1 to 4096')


def read_spectrum(file: SpectrumFile) -> dict[str, Any]:
    """Return the keys of `ship.sea` with a measured spectrum as a table.

    A row at 0 Hz without energy is dropped, since no wave has that frequency.

    Raises:
        SceneError: a table that is not a spectrum, with row and value.
    """
    table = read_table(file.path, (Column(FREQUENCY), Column(DENSITY)), remedy=_SPECTRUM_FORM)
    is_at_rest = table[FREQUENCY][0] == 0.0 and table[DENSITY][0] == 0.0
    table = table.rows(np.arange(int(is_at_rest), len(table)))
    if len(table) < 2:
        remedy = 'Give the energy at more frequencies.'
        problem = 'is not enough: a spectrum needs at least 2 frequencies above 0 Hz'
        raise SceneError(file.path, 'number of frequencies', len(table), problem, remedy)
    table.check(
        Column(
            FREQUENCY,
            unit='Hz',
            above=0.0,
            rising='greater than the frequency before',
            remedy='Sort the rows by frequency, and drop duplicates.',
        ),
        Column(
            DENSITY,
            unit='m2/Hz',
            least=0.0,
            why='no wave has negative energy',
            remedy='Correct the row, or set noise below 0 to 0.',
        ),
    )
    if not np.any(table[DENSITY]):
        remedy = 'Choose another spectrum, or ship kind still for a calm.'
        problem = 'is 0 m2/Hz at all frequencies: the spectrum is empty'
        raise SceneError(file.path, DENSITY, ABSENT, problem, remedy)
    return {
        'spectrum': 'table',
        'source': source_name(file.path)[-LONGEST_TEXT:],
        'frequency': table[FREQUENCY].tolist(),
        'energy_density': table[DENSITY].tolist(),
        'components': file.components,
    }


# -----------------------------------------------------------------------------
# Buoy records: a CSV file. Many rows lack the waves, which buoys measure less often than the wind.

HEIGHT, PERIOD, WAVES_FROM = 'significant_wave_height_m', 'peak_period_s', 'waves_from_deg'
UTC_TIME, SECONDS = 'time_utc', 'time_s'
LONGEST_S = 40.0
"""Longest peak period of wind waves [s]."""

_RECORD_FORM = f'Give a CSV file with the columns {UTC_TIME} or {SECONDS}, {HEIGHT} and {PERIOD}.'


class RecordFile(WeatherKind):
    """A buoy record from a file. The running scene contains the rows."""

    kind: Literal['record'] = 'record'
    path: OneLine = Field(description='CSV file of the record')
    begins: OneLine | None = Field(
        default=None,
        description='UTC at the start of the scene, as 2000-01-01T02:00; when left out the time '
        'of the first row',
    )
    max_gap: Positive = Field(
        default=21_600.0, description='longest gap between rows that is bridged [s]'
    )


def read_record(file: RecordFile, *, fixed: bool) -> dict[str, Any]:
    """Return the keys of `ship.weather` with a buoy record.

    Rows without height or period are left out. So are rows without direction, if any row has one
    and the heading depends on it, which `fixed` excludes. The first row kept is the last one
    before `begins`, from which times count.

    Raises:
        SceneError: a height or period out of range, a gap longer than `max_gap`, or a beginning
            outside the record, with the line.
    """
    by_direction = file.follow_route and not fixed
    has_utc = UTC_TIME in read_header(file.path, remedy=_RECORD_FORM)
    if file.begins is not None and not has_utc:
        problem = f'needs the column {UTC_TIME}; {SECONDS} counts from an unknown start'
        raise SceneError(file.path, 'begins', file.begins, problem, 'Leave it out.')
    columns = (
        Column(UTC_TIME, utc=True) if has_utc else Column(SECONDS),
        Column(HEIGHT, gaps='skip'),
        Column(PERIOD, gaps='skip'),
        Column(WAVES_FROM, gaps='nan', least=0.0, most=360.0, unit='degrees', optional=True),
    )
    table = read_table(file.path, columns, remedy=_RECORD_FORM)
    if not len(table):
        problem = 'has no row with a wave height and a period'
        raise SceneError(file.path, '', ABSENT, problem, _RECORD_FORM)
    unknown = {WAVES_FROM: np.full(len(table), math.nan)}
    values = {**unknown, **table.values, SECONDS: table[columns[0].name]}
    table = Columns(file.path, values, table.places).rows(
        np.argsort(values[SECONDS], kind='stable')
    )
    undirected = np.isnan(table[WAVES_FROM])
    by_direction_alone = by_direction and not undirected.all()
    rows = table.rows(~undirected) if by_direction_alone else table
    first_s, last_s = float(rows[SECONDS][0]), float(rows[SECONDS][-1])
    begins_s = first_s
    if file.begins is not None:
        begins_s = utc(file.path, 'begins', file.begins).timestamp()
        if not first_s <= begins_s <= last_s:
            ends = (datetime.fromtimestamp(second, UTC) for second in (first_s, last_s))
            start, stop = (f'{end:%Y-%m-%dT%H:%M}' for end in ends)
            problem = f'is not within the record, from {start} to {stop}'
            raise SceneError(file.path, 'begins', file.begins, problem, 'Give a time within it.')
    latest_s = rows[SECONDS][rows[SECONDS] <= begins_s].max()
    missing = np.count_nonzero(undirected & (table[SECONDS] >= latest_s))
    rows = rows.rows(rows[SECONDS] >= latest_s)
    rows.check(
        Column(HEIGHT, above=0.0, most=HIGHEST_M), Column(PERIOD, above=0.0, most=LONGEST_S)
    )
    gaps = rows.gaps(
        SECONDS,
        file.max_gap,
        after=f'row with waves{" and their direction" if by_direction_alone else ""}',
        limit='max_gap',
        remedy='Raise ship.weather.max_gap, or cut the record at the gap.',
    )
    waves_from = rows[WAVES_FROM].tolist()
    headings = [math.radians((deg + 180.0) % 360.0) for deg in waves_from if not math.isnan(deg)]
    return {
        **file.model_dump(exclude={'path', 'begins'}),
        'source': source_name(file.path)[-LONGEST_TEXT:],
        'time': (rows[SECONDS] - begins_s).tolist(),
        'significant_wave_height': rows[HEIGHT].tolist(),
        'peak_period': rows[PERIOD].tolist(),
        'waves_to': headings if len(headings) == len(rows) else None,
        'gaps_bridged': gaps,
        'rows_without_direction': int(missing) if by_direction else 0,
    }


_S = TypeVar('_S', bound=Section)

FILE_FORMS: dict[str, type[Section]] = {
    'sea': SpectrumFile,
    'rao': RaoFile,
    'hull': HullFile,
    'weather': RecordFile,
}
"""The model of each section of `ship` that may name a file."""


def with_files_read(ship: dict[str, Any], origin: str) -> dict[str, Any]:
    """Return the unchecked keys of a ship, with numbers in place of the files of its sea.

    `ship.sea` with spectrum file becomes a table, `ship.rao` with a path the operator, `ship.hull`
    with a path the contents of the file, and `ship.weather` of a record its rows. Errors name the
    scene, `origin`, and the path of the key, or file and line.
    """
    read = dict(ship)
    for section, form in (('sea', _SPECTRUM_FORM), ('weather', _RECORD_FORM)):
        if _holds(ship, section, 'format'):
            key, problem = f'ship.{section}.format', 'is not a key any more: all files are CSV'
            raise SceneError(origin, key, ship[section]['format'], problem, form)
    if _holds(ship, 'sea', 'spectrum') and ship['sea']['spectrum'] == 'file':
        read['sea'] = section_read(SpectrumFile, read_spectrum, ship, 'sea.path', origin)
    if _holds(ship, 'rao', 'path'):
        read['rao'] = section_read(RaoFile, read_operator, ship, 'rao.path', origin)
    if _holds(ship, 'hull', 'path'):
        read['hull'] = section_read(HullFile, read_hull, ship, 'hull.path', origin)
    if _holds(ship, 'roll', 'decay'):
        raise SceneError(
            origin,
            'ship.roll.decay',
            ABSENT,
            'is not a key any more: decay tests are not fitted',
            'Give natural_period and damping_ratio: ln(a/b)/2πn of two peaks a and b of the test '
            'n cycles apart.',
        )
    if _holds(ship, 'weather', 'path') and ship['weather'].get('kind') == 'record':
        # a response operator with its own heading needs no directions
        rao = ship.get('rao')
        fixed = isinstance(rao, dict) and rao.get('heading') is not None
        reader = partial(read_record, fixed=fixed)
        read['weather'] = section_read(RecordFile, reader, ship, 'weather.path', origin)
    return read


def _holds(ship: dict[str, Any], section: str, key: str) -> bool:
    return isinstance(ship.get(section), dict) and key in ship[section]


def section_read(
    form: type[_S],
    reader: Callable[[_S], dict[str, Any]],
    ship: dict[str, Any],
    path: str,
    origin: str,
    prefix: str = 'ship.',
    *,
    any_size: bool = False,
) -> dict[str, Any]:
    """Return the contents of a section, from the file that its `path` names.

    Args:
        form: model of a section that names a file.
        reader: returns the keys with the contents of the file in its place.
        ship: the owner of the section, such as the ship.
        path: path in `ship` of the key that names the file.
        origin: name of the scene, for errors.
        prefix: the part before the path in the scene, for errors.
        any_size: whether a file of any size is allowed because only a part of it is read.

    Raises:
        SceneError: wrong keys or a wrong file.
    """
    section, *names = path.split('.')
    try:
        keys = form.model_validate(ship[section])
    except ValidationError as error:
        problems = [
            Problem(f'{prefix}{section}.{item.key}', item.value, item.problem, item.remedy)
            for item in explain(error, form)
        ]
    else:
        named = str(reduce(getattr, names, keys))
        problems = missing_file(f'{prefix}{path}', named, any_size=any_size)
        if not problems:
            return reader(keys)
    raise SceneError.of(origin, problems) from None
