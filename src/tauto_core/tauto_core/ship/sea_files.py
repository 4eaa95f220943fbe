"""The files from which a sea is computed: operators, spectra, roll decay tests, records of buoys.

A scene that runs contains tables and numbers, no paths, so a bag needs nothing but its text.
"""

from __future__ import annotations

import glob
import math
import warnings
from base64 import b64encode
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import reduce
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import Field, Strict, ValidationError

from tauto_core.samples import FloatArray
from tauto_core.scene.errors import ABSENT, Problem, SceneError, install
from tauto_core.scene.refuse import explain
from tauto_core.scene.sections import LONGEST_TEXT, NonNegative, OneLine, Positive, Section
from tauto_core.scene.tables import (
    ANGLE_UNITS,
    TIME_UNITS,
    Column,
    Columns,
    data_path,
    missing_file,
    read_data,
    read_header,
    read_table,
    source_name,
    unit_factor,
    utc,
    words_of,
)
from tauto_core.ship.sections import (
    ATHWART,
    MOTIONS,
    RAO_HEADING_MEANS,
    RAO_LENGTH_MEANS,
    ComponentCount,
    Heading,
    HullWeights,
)
from tauto_core.ship.weather_kind import HIGHEST_M, WeatherKind
from tauto_core.wording import with_sigma

# -----------------------------------------------------------------------------
# Response amplitude operators of a ship.
#
# Columns: `heading_deg` (0 following seas, 90 beam seas to port, 180 head seas), `omega_radps` of
# the waves, `speed_mps` where the ship makes way, and for each motion that is known its real and
# imaginary part, `surge_re`, `surge_im` and so on [m or rad per m of wave amplitude], as factors
# of exp(i ω t) at the ship's origin, in the axes of theory/ship.md, E1; other columns are ignored.
# All headings and speeds have the same frequencies, and all speeds the same headings.

HEADING, OMEGA, SPEED = 'heading_deg', 'omega_radps', 'speed_mps'
_PARTS = {'re': 'real', 'im': 'imaginary'}
_OPTIONAL = tuple(
    Column(each, optional=True)
    for each in (SPEED, *(f'{name}_{part}' for name in MOTIONS for part in _PARTS))
)
_OPERATOR_FORM = (
    f'Give a CSV file with the columns {HEADING}, {OMEGA} and, for each motion, its two parts: '
    'roll_re, roll_im, heave_re, heave_im, …'
)


class HullFile(HullWeights):
    """A hull from a file of `tauto hull`; the scene that runs contains the file."""

    path: OneLine = Field(description='.npz file that `tauto hull` has written')


def read_hull(asked: HullFile) -> dict[str, Any]:
    """Return the keys of `ship.hull`, with the contents of the file as `table`; refuse others."""
    from tauto_core.ship.hull import HullError, hull_of_file

    content = read_data(data_path(asked.path))
    try:
        hull_of_file(content, asked.path)
    except HullError as error:
        found = error.problem
        raise SceneError(asked.path, found.key, ABSENT, found.problem, found.remedy) from None
    table = b64encode(content).decode('ascii')
    return {**asked.model_dump(exclude={'path'}, exclude_none=True), 'table': table}


class RaoFile(Section):
    """An operator from a file; the scene that runs contains its values."""

    path: OneLine = Field(description='CSV file of the operator')
    heading: Heading | None = Field(default=None, description=RAO_HEADING_MEANS)
    length: Annotated[float, Strict(), Field(ge=2.0, le=400.0)] | None = Field(
        default=None, description=RAO_LENGTH_MEANS
    )


def read_operator(asked: RaoFile) -> dict[str, Any]:
    """Return the keys of `ship.rao`: all of the file, or one heading, linear between two.

    A ship is symmetric: waves to starboard (heading > π) are those to port mirrored, with sway,
    roll and yaw of the other sign. A file whose headings or frequencies differ, and a heading
    outside the file's are refused, with the line.
    """
    columns = (Column(HEADING), Column(OMEGA), *_OPTIONAL)
    table = read_table(asked.path, columns, remedy=_OPERATOR_FORM)
    parts = {name: [f'{name}_{part}' for part in _PARTS] for name in MOTIONS}
    known = {name: both for name, both in parts.items() if any(each in table for each in both)}
    for column in [each for both in known.values() for each in both] or ['roll_re']:
        if column not in table:
            raise SceneError(
                asked.path, f'line 1, column {column}', ABSENT, 'is missing', _OPERATOR_FORM
            )
    blocks = _by_course(table)
    speeds, headings = (sorted({course[i] for course in blocks}) for i in (0, 1))
    under_way = speeds != [0.0]
    keys: dict[str, Any] = {
        'source': source_name(asked.path),
        **asked.model_dump(exclude={'path'}, exclude_none=True),
        **({'speeds': speeds} if under_way else {}),
        'angular_frequency': table[OMEGA][next(iter(blocks.values()))].tolist(),
    }
    mirrored = False
    if asked.heading is None:
        headings = [each for each in headings if 0.0 <= each <= 180.0]
        keys['headings'] = [math.radians(each) for each in headings]
        rows = [((heading, heading, 0.0), speed) for speed in speeds for heading in headings]
    else:
        mirrored = asked.heading > math.pi
        heading = math.degrees(math.tau - asked.heading if mirrored else asked.heading)
        rows = [(_neighbours(asked, headings, heading), speed) for speed in speeds]
    for name, columns_of in known.items():
        sign = -1.0 if mirrored and name in ATHWART else 1.0
        for column, part in zip(columns_of, _PARTS.values(), strict=True):
            values = []
            for (below, above, share), speed in rows:
                low, high = (table[column][blocks[speed, each]] for each in (below, above))
                values += (sign * ((1.0 - share) * low + share * high)).tolist()
            keys[f'{name}_{part}'] = values
    return keys


def _by_course(table: Columns) -> dict[tuple[float, float], list[int]]:
    """Return the rows by speed and heading [m/s, deg]; all have the same rising frequencies."""
    blocks: dict[tuple[float, float], list[int]] = {}
    speeds = table[SPEED].tolist() if SPEED in table else [0.0] * len(table)
    for row, course in enumerate(zip(speeds, table[HEADING].tolist(), strict=True)):
        if course[0] < 0.0:
            raise table.refusal(row, SPEED, 'must not be negative', 'Give the speed in m/s.')
        blocks.setdefault(course, []).append(row)
    omega, remedy = table[OMEGA], 'Give every heading the same frequencies, in rising order.'
    rising = 'greater than the one before'
    first = next(iter(blocks.values()))
    headings = {heading for _, heading in blocks}
    for (speed, heading), rows in blocks.items():
        table.rows(np.array(rows)).check(
            Column(OMEGA, unit='rad/s', above=0.0, rising=rising, remedy=remedy)
        )
        if not np.array_equal(omega[rows], omega[first]):
            problem = (
                f'begins a heading, {heading:g} deg, whose frequencies are not the first one’s'
            )
            raise table.refusal(rows[0], OMEGA, problem, remedy)
        lacking = sorted(each for each in headings if (speed, each) not in blocks)
        if lacking:
            problem = f'begins a speed, {speed:g} m/s, without the heading {lacking[0]:g} deg'
            remedy = 'Give every speed the same headings.'
            raise table.refusal(rows[0], SPEED, problem, remedy)
    if len(first) < 2:
        problem = 'is not enough: an operator needs at least 2 frequencies'
        value = float(omega[first[0]])
        raise SceneError(table.name, OMEGA, value, problem, 'Give it at more frequencies.')
    return blocks


def _neighbours(
    asked: RaoFile, headings: list[float], heading: float
) -> tuple[float, float, float]:
    """Return the neighbouring headings of the file [deg], and the weight of the upper one."""
    # a heading in radians never equals 90 degrees to the last bit
    near = min(headings, key=lambda each: abs(each - heading))
    if abs(near - heading) < 1e-9:
        return near, near, 0.0
    if not headings[0] < heading < headings[-1]:
        problem = (
            f'is {heading:.6g} deg off following seas, but the operator {asked.path} covers '
            f'{headings[0]:g} to {headings[-1]:g} deg'
        )
        remedy = 'Choose a heading that it covers; extrapolating it would be a guess.'
        raise SceneError(asked.path, 'heading', asked.heading, problem, remedy)
    above = next(each for each in headings if each > heading)
    below = headings[headings.index(above) - 1]
    return below, above, (heading - below) / (above - below)


# -----------------------------------------------------------------------------
# Measured wave spectra: from a table or a buoy's file to the spectrum of a scene.
#
# A table has the columns `frequency_hz` and `energy_density_m2_per_hz`. The files of buoys are
# read by wavespectra, the optional extra `spectra`; directional spectra are summed over the
# directions.

FREQUENCY, DENSITY = 'frequency_hz', 'energy_density_m2_per_hz'
NDBC_MISSING = 999.0
"""The values that NDBC writes where nothing was measured."""

_SPECTRUM_FORM = (
    f'Give a CSV file with the columns {FREQUENCY} and {DENSITY}; for the file of a buoy give '
    'ship.sea.format: ndbc, datawell, spotter or triaxys.'
)


class SpectrumFile(Section):
    """A measured spectrum from a file; the scene that runs contains the table itself."""

    spectrum: Literal['file'] = Field(description='file')
    path: OneLine = Field(description='file of the spectrum')
    format: Literal['table', 'ndbc', 'datawell', 'spotter', 'triaxys'] = Field(
        default='table', description='table (CSV), ndbc, datawell, spotter or triaxys'
    )
    time: OneLine | None = Field(
        default=None,
        description='UTC of the spectrum where the file holds several, as 2000-01-01T02:00',
    )
    components: ComponentCount = Field(default=64, description='number of components, 1 to 4096')


def read_spectrum(asked: SpectrumFile) -> dict[str, Any]:
    """Return the keys of `ship.sea` with a measured spectrum as a table.

    A row at 0 Hz without energy is dropped, since no wave has that frequency. A time that does not
    select one spectrum of the file is refused, and the missing extra `spectra` is named.
    """
    source = source_name(asked.path)
    if asked.format != 'table':
        table, stamp = _of_buoy(asked)
        source = f'{source} {stamp}'
    elif asked.time is not None:
        problem = 'does not go with format table, which holds one spectrum'
        raise SceneError(asked.path, 'time', asked.time, problem, 'Leave it out.')
    else:
        columns = Column(FREQUENCY), Column(DENSITY)
        found = read_table(asked.path, columns, remedy=_SPECTRUM_FORM)
        values = {'frequency': found[FREQUENCY], 'energy density': found[DENSITY]}
        table = Columns(asked.path, values, found.places)
    if len(table) and table['frequency'][0] == 0.0 and table['energy density'][0] == 0.0:
        table = table.rows(np.arange(1, len(table)))
    check_spectrum(table)
    return {
        'spectrum': 'table',
        'source': source[-LONGEST_TEXT:],
        'frequency': table['frequency'].tolist(),
        'energy_density': table['energy density'].tolist(),
        'components': asked.components,
    }


def check_spectrum(table: Columns) -> None:
    """Refuse a table that is not a spectrum, with file, row and value.

    It has `frequency` [Hz] and `energy density` [m2/Hz], NaN where nothing was measured.
    """
    name, density = table.name, table['energy density']
    if len(table) < 2:
        remedy = 'Give the energy at more frequencies.'
        problem = 'is not enough: a spectrum needs at least 2 frequencies above 0 Hz'
        raise SceneError(name, 'number of frequencies', len(table), problem, remedy)
    table.check(
        Column(
            'frequency',
            unit='Hz',
            above=0.0,
            rising='greater than the frequency before',
            remedy='Sort the rows by frequency, and drop what is double.',
        ),
        Column(
            'energy density',
            unit='m2/Hz',
            least=0.0,
            why='no wave has negative energy',
            remedy='Correct the row; noise below 0 may be set to 0.',
        ),
    )
    unknown = np.flatnonzero(~np.isfinite(density))
    if unknown.size:
        remedy = 'Choose a spectrum without gaps, or fill it in.'
        problem = 'is a gap: nothing was measured there'
        raise table.refusal(int(unknown[0]), 'energy density', problem, remedy)
    if not np.any(density):
        remedy = 'Choose another spectrum, or ship kind still for a calm.'
        problem = 'is 0 m2/Hz at all frequencies: the spectrum is empty'
        raise SceneError(name, 'energy density', ABSENT, problem, remedy)


def _of_buoy(asked: SpectrumFile) -> tuple[Columns, str]:
    """Return one spectrum of a buoy's file, and its time."""
    data = _read_with_library(asked)
    stamps = [str(each) for each in data['time'].values.astype('datetime64[s]').reshape(-1)]
    told = f'{len(stamps)} spectra from {min(stamps)} to {max(stamps)}' if stamps else 'none'
    if asked.time is not None:
        wanted = utc(asked.path, 'time', asked.time).replace(tzinfo=None)
        apart = {stamp: abs(datetime.fromisoformat(stamp) - wanted) for stamp in stamps}
        found = [i for i, stamp in enumerate(stamps) if not apart[stamp]]
        if len(found) > 1:
            problem, remedy = (
                f'names {len(found)} spectra of the file',
                'Cut the file to one of them.',
            )
            raise SceneError(asked.path, 'time', asked.time, problem, remedy)
        if not found:
            problem = f'is not a time of the file, which holds {told}'
            remedy = f'Use {" or ".join(sorted(stamps, key=apart.__getitem__)[:2])}.'
            raise SceneError(asked.path, 'time', asked.time, problem, remedy)
        chosen = found[0]
    elif len(stamps) == 1:
        chosen = 0
    else:
        problem = f'is missing, and the file holds {told}'
        remedy = 'Give ship.sea.time, for example ' + (stamps[0] if stamps else '…') + '.'
        raise SceneError(asked.path, 'time', ABSENT, problem, remedy)
    # the shortest digits, since the float32 nearest to 0.1 means 0.1
    frequency = np.array([float(str(each)) for each in data['freq'].values])
    density = data.transpose('time', 'freq').values[chosen].astype(np.float64)
    if asked.format == 'ndbc':
        density[density == NDBC_MISSING] = math.nan
    places = [f'{each:g} Hz' for each in frequency.tolist()]
    values = {'frequency': frequency, 'energy density': density}
    return Columns(asked.path, values, places, 'at'), stamps[chosen]


def _read_with_library(asked: SpectrumFile) -> Any:
    """Return the energy density of a buoy's file [m2/Hz] as an array over time and frequency."""
    try:
        import wavespectra
    except ImportError:
        problem = f'format {asked.format} needs the library wavespectra, which is not installed'
        remedy = f'Run {install("spectra")}, or give the spectrum as a CSV table.'
        raise SceneError(asked.path, '', None, problem, remedy) from None
    file = data_path(asked.path)
    if asked.format == 'datawell' and '}' not in file.name:
        problem = 'lacks station and time, which the name of a Datawell file states'
        raise SceneError(
            asked.path, 'name', file.name, problem, 'Name it station}2024-09-09T01h15Z.spt.'
        )
    readers: dict[str, Callable[[], Any]] = {
        'ndbc': lambda: wavespectra.read_ndbc_ascii(str(file)),
        'datawell': lambda: wavespectra.read_datawell(str(file), dd=None),
        'spotter': lambda: wavespectra.read_spotter(str(file), filetype='csv', dd=None),
        'triaxys': lambda: wavespectra.read_triaxys(glob.escape(str(file))),
    }
    # Deprecation warnings from the library's dependencies, and files that it leaves open when it
    # fails, do not concern the user of a scene; releasing its error here closes the files.
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        try:
            density = readers[asked.format]()['efth']
            return density.spec.oned() if 'dir' in density.dims else density
        except Exception as error:  # a malformed file may make the library raise anything
            said = words_of(error)
    problem = f'cannot be read as format {asked.format}: {said}'
    remedy = 'Correct ship.sea.format or the file, or give the spectrum as a CSV table.'
    raise SceneError(asked.path, '', None, problem, remedy)


# -----------------------------------------------------------------------------
# Natural period and damping of the roll, fitted to a measured roll decay test.

FEWEST_A_CYCLE = 8
"""Samples that a cycle of the roll must have."""
_DECAY_FORM = 'Give a CSV file whose first line names ship.roll.decay.time_column and roll_column.'


class RollDecay(Section):
    """A roll decay test: the ship is heeled, released, and rolls in calm water until it rests."""

    path: OneLine = Field(description='CSV file of the test')
    time_column: OneLine = Field(description='column of the time, …_s')
    roll_column: OneLine = Field(description='column of the roll, …_deg or …_rad')
    cycles: Annotated[int, Strict(), Field(ge=1, le=1000)] = Field(
        default=3, description='number of cycles after the release that are fitted, 1 to 1000'
    )
    model_scale: Positive = Field(
        default=1.0,
        description='length of the ship over that of the model; times are multiplied by its '
        'square root (Froude)',
    )


class RollFromDecay(Section):
    """Linear roll whose natural period and damping ratio follow from a roll decay test."""

    decay: RollDecay = Field(description='mapping: path, time_column, roll_column, …')
    slope_coefficient: NonNegative = Field(description='effective wave-slope coefficient κ_e')


@dataclass(frozen=True)
class DecayFit:
    """A linear decay with its standard errors.

    Attributes:
        natural_period: 2π/ω_n [s].
        damping_ratio: ζ.
        period_sigma: standard error of the period [s].
        damping_sigma: standard error of the ratio.
        residual: root mean square of the difference from the linear decay [rad].
    """

    natural_period: float
    damping_ratio: float
    period_sigma: float
    damping_sigma: float
    residual: float


def fitted_roll(asked: RollFromDecay) -> dict[str, Any]:
    """Return the keys of `ship.roll`: fitted period and damping ratio, and the fit's source."""
    decay = asked.decay
    columns = (
        Column(
            decay.time_column,
            factor=unit_factor(decay.path, 'time_column', decay.time_column, TIME_UNITS),
            unit='s',
            rising='later than the time before',
            remedy='Sort the rows and drop what is double.',
        ),
        Column(
            decay.roll_column,
            factor=unit_factor(decay.path, 'roll_column', decay.roll_column, ANGLE_UNITS),
        ),
    )
    table = read_table(decay.path, columns, remedy=_DECAY_FORM)
    time, roll = table[decay.time_column], table[decay.roll_column]
    fit = fit_decay(*released(decay.path, time, roll, decay.cycles))
    longer = math.sqrt(decay.model_scale)
    period, sigma = longer * fit.natural_period, longer * fit.period_sigma
    if not fit.damping_ratio > 0.0:
        problem = f'is fitted to {decay.cycles} cycles, but must be > 0: the roll does not decay'
        remedy = 'Fit other cycles, or give natural_period and damping_ratio.'
        raise SceneError(decay.path, 'damping ratio', fit.damping_ratio, problem, remedy)
    said = (
        f'{source_name(decay.path)}: {decay.cycles} cycles, '
        f'period {with_sigma(period, sigma, signed=False)} s, '
        f'damping ratio {with_sigma(fit.damping_ratio, fit.damping_sigma, signed=False)}'
    )
    return {
        'natural_period': period,
        'damping_ratio': fit.damping_ratio,
        'slope_coefficient': asked.slope_coefficient,
        'fitted_to': said[-LONGEST_TEXT:],
    }


def released(
    name: str, time: FloatArray, roll: FloatArray, cycles: int
) -> tuple[FloatArray, FloatArray]:
    """Return time [s] and roll [rad] of the part of a test in which the ship rolls freely.

    It begins where the roll first passes the middle after its largest angle (until then the ship
    may have been held) and lasts `cycles` cycles. The middle is the mean of the last quarter of
    the test. A `SceneError` says that there are not so many, or too few samples in one.
    """
    about = roll - np.mean(roll[-(len(roll) // 4 + 1) :])
    largest = int(np.argmax(np.abs(about)))
    up = about[largest:] > 0.0
    crossings = largest + 1 + np.flatnonzero(up[1:] != up[:-1])
    last = 2 * cycles
    if len(crossings) <= last:
        problem = (
            f'is more than the test holds: {max(len(crossings) - 1, 0) // 2} whole cycles after '
            f'its largest roll'
        )
        remedy = 'Fit fewer cycles, or give the test to its end.'
        raise SceneError(name, 'cycles', cycles, problem, remedy)
    begin, end = int(crossings[0]), int(crossings[last])
    if end - begin < FEWEST_A_CYCLE * cycles:
        problem = (
            f'cycles of the roll have {end - begin} samples; at least {FEWEST_A_CYCLE} a cycle '
            'are needed'
        )
        raise SceneError(name, str(cycles), ABSENT, problem, 'Give a test sampled more finely.')
    return time[begin:end], roll[begin:end]


def fit_decay(time: FloatArray, roll: FloatArray) -> DecayFit:
    """Fit ρ = mean + exp(-ζ w t) (a cos w_d t + b sin w_d t), w_d = w √(1 - ζ²).

    Least squares over w and ζ; the other parameters are linear. The damping of a ship falls
    with the angle, so the residual of this linear decay is not white noise. The standard errors
    therefore count one independent residual in each half cycle. Whole cycles are expected, from a
    zero crossing on.
    """
    from scipy.optimize import least_squares

    t = time - time[0]
    # first ω from the number of half cycles, ζ from the sizes of both halves
    about = roll - np.mean(roll)
    up = about > 0.0
    half_cycles = max(int(np.count_nonzero(up[1:] != up[:-1])) + 1, 2)
    half = len(t) // 2
    early, late = (float(np.sqrt(np.mean(part**2))) for part in (about[:half], about[half:]))
    first_omega = math.pi * half_cycles / float(t[-1])
    decrement = 2.0 * math.log(early / late) / float(t[-1])
    first = [first_omega, min(max(decrement / first_omega, 1e-4), 0.9)]

    def rest(guess: FloatArray) -> FloatArray:
        omega, zeta = guess
        turned = omega * math.sqrt(max(1.0 - zeta * zeta, 0.0)) * t
        size = np.exp(-zeta * omega * t)
        shapes = np.stack([size * np.cos(turned), size * np.sin(turned), np.ones_like(t)], 1)
        linear = np.linalg.lstsq(shapes, roll, rcond=None)[0]
        left: FloatArray = shapes @ linear - roll
        return left

    found = least_squares(
        rest, first, jac='3-point', x_scale=first, xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    variance = float(np.mean(found.fun**2))
    slopes = np.asarray(found.jac)
    spread = np.linalg.inv(slopes.T @ slopes) * variance * len(t) / half_cycles
    omega, zeta = (float(each) for each in found.x)
    period = math.tau / omega
    return DecayFit(
        period,
        zeta,
        period * math.sqrt(float(spread[0, 0])) / omega,
        math.sqrt(float(spread[1, 1])),
        math.sqrt(variance),
    )


# -----------------------------------------------------------------------------
# Records of the sea from a buoy: a CSV file, or one of NDBC's standard meteorological files.
#
# NDBC's files (National Data Buoy Center, Measurement descriptions and units) have the columns
# WVHT, significant wave height [m], DPD, dominant wave period [s], and MWD, the direction from
# which the waves of that period come [degrees from true north]. Many rows have no waves, since
# these are measured less often than the wind. Heights and periods of 99 and directions of 999
# mean the same.

HEIGHT, PERIOD, WAVES_FROM = 'significant_wave_height_m', 'peak_period_s', 'waves_from_deg'
UTC_TIME, SECONDS = 'time_utc', 'time_s'
LONGEST_S = 40.0
"""Longest peak period of wind waves [s]."""

_YEARS = ('YYYY', 'YY')
_DATE = ('MM', 'DD', 'hh')
_RECORD_FORM = (
    f'Give a CSV file with the columns {UTC_TIME} or {SECONDS}, {HEIGHT} and {PERIOD}; for a '
    'standard meteorological file of NDBC give ship.weather.format: ndbc.'
)


class RecordFile(WeatherKind):
    """A buoy's record from a file; the scene that runs contains the rows themselves."""

    kind: Literal['record'] = 'record'
    path: OneLine = Field(description='file of the record')
    format: Literal['csv', 'ndbc'] = Field(
        default='csv', description='csv, or ndbc: a standard meteorological file'
    )
    begins: OneLine | None = Field(
        default=None,
        description='UTC at the start of the scene, as 2000-01-01T02:00; when left out that of '
        'the first row',
    )
    max_gap: Positive = Field(
        default=21_600.0, description='longest gap between rows that is bridged [s]'
    )


def read_record(asked: RecordFile, *, by_direction: bool) -> dict[str, Any]:
    """Return the keys of `ship.weather` with a buoy's record.

    Rows where height or period is missing are left out, and where directions are needed those
    without a direction, unless no row has one: `by_direction` says whether the heading depends on
    them. Rows are kept from the last one before `begins`, and their times count from it. Heights
    and periods out of range, gaps longer than `max_gap` and a beginning outside the record are
    refused, with the line.
    """
    table = _ndbc_table(asked) if asked.format == 'ndbc' else _csv_table(asked)
    if not len(table):
        problem = 'holds no row with a wave height and a period'
        raise SceneError(asked.path, '', ABSENT, problem, _RECORD_FORM)
    table = table.rows(np.argsort(table[SECONDS], kind='stable'))
    undirected = np.isnan(table[WAVES_FROM])
    by_direction_alone = by_direction and not undirected.all()
    kept = table.rows(~undirected) if by_direction_alone else table
    first_s, last_s = float(kept[SECONDS][0]), float(kept[SECONDS][-1])
    begins_s = first_s
    if asked.begins is not None:
        begins_s = utc(asked.path, 'begins', asked.begins).timestamp()
        if not first_s <= begins_s <= last_s:
            ends = (datetime.fromtimestamp(each, UTC) for each in (first_s, last_s))
            first, last = (f'{end:%Y-%m-%dT%H:%M}' for end in ends)
            problem = f'is not within the record, from {first} to {last}'
            raise SceneError(asked.path, 'begins', asked.begins, problem, 'Give a time within it.')
    latest_s = kept[SECONDS][kept[SECONDS] <= begins_s].max()
    missing = np.count_nonzero(undirected & (table[SECONDS] >= latest_s))
    kept = kept.rows(kept[SECONDS] >= latest_s)
    kept.check(
        Column(HEIGHT, above=0.0, most=HIGHEST_M), Column(PERIOD, above=0.0, most=LONGEST_S)
    )
    gaps = kept.gaps(
        SECONDS,
        asked.max_gap,
        after=f'row with waves{" and their direction" if by_direction_alone else ""}',
        limit='max_gap',
        remedy='Raise ship.weather.max_gap, or cut the record at the gap.',
    )
    waves_from = kept[WAVES_FROM].tolist()
    known = [math.radians((each + 180.0) % 360.0) for each in waves_from if not math.isnan(each)]
    return {
        **asked.model_dump(exclude={'path', 'format', 'begins'}),
        'source': source_name(asked.path)[-LONGEST_TEXT:],
        'time': (kept[SECONDS] - begins_s).tolist(),
        'significant_wave_height': kept[HEIGHT].tolist(),
        'peak_period': kept[PERIOD].tolist(),
        'waves_to': known if len(known) == len(kept) else None,
        'gaps_bridged': gaps,
        'rows_without_direction': int(missing) if by_direction else 0,
    }


def _waves(height: str, period: str, waves_from: str) -> tuple[Column, ...]:
    """Return the columns of the waves; rows without height or period are skipped."""
    return (
        Column(height, gaps='skip', nines=99.0),
        Column(period, gaps='skip', nines=99.0),
        Column(waves_from, gaps='nan', nines=999.0, optional=True),
    )


def _csv_table(asked: RecordFile) -> Columns:
    """Return time, height, period and direction of the waves from a CSV file."""
    has_utc = UTC_TIME in read_header(asked.path, remedy=_RECORD_FORM)
    if asked.begins is not None and not has_utc:
        problem = f'needs the column {UTC_TIME}; {SECONDS} counts from an unknown start'
        raise SceneError(asked.path, 'begins', asked.begins, problem, 'Leave it out.')
    time = Column(UTC_TIME, utc=True) if has_utc else Column(SECONDS)
    columns = (time, *_waves(HEIGHT, PERIOD, WAVES_FROM))
    table = read_table(asked.path, columns, remedy=_RECORD_FORM)
    unknown = {WAVES_FROM: np.full(len(table), math.nan)}
    values = {**unknown, **table.values, SECONDS: table[time.name]}
    return Columns(asked.path, values, table.places)


def _ndbc_table(asked: RecordFile) -> Columns:
    """Return the same from a standard meteorological file; times from 1970 in UTC."""
    header = read_header(asked.path, remedy=_RECORD_FORM, divided=' ')
    year = next((name for name in _YEARS if name in header), _YEARS[0])
    # MM is the month in the header, and a missing value in the rows
    date = (*(Column(name) for name in (year, *_DATE)), Column('mm', optional=True))
    columns = (*date, *_waves('WVHT', 'DPD', 'MWD'))
    table = read_table(asked.path, columns, remedy=_RECORD_FORM, divided=' ')
    count = len(table)
    minutes = table['mm'] if 'mm' in table else np.zeros(count)
    time_s = np.empty(count)
    for row in range(count):
        parts = [float(table[name][row]) for name in (year, *_DATE)]
        try:
            if not all(map(float.is_integer, parts)):
                raise ValueError('its parts must be whole numbers')
            whole, month, day, hour = map(int, parts)
            # files before 1999 have two digits
            whole += 1900 if whole < 100 else 0
            at = datetime(whole, month, day, hour, tzinfo=UTC)
        except ValueError as error:
            raise table.refusal(row, '', f'has no date and time: {error}') from None
        time_s[row] = (at + timedelta(minutes=float(minutes[row]))).timestamp()
    values = {
        HEIGHT: table['WVHT'],
        PERIOD: table['DPD'],
        WAVES_FROM: table['MWD'] if 'MWD' in table else np.full(count, math.nan),
        SECONDS: time_s,
    }
    return Columns(asked.path, values, table.places)


_S = TypeVar('_S', bound=Section)

FILE_FORMS: dict[str, type[Section]] = {
    'sea': SpectrumFile,
    'rao': RaoFile,
    'hull': HullFile,
    'roll': RollFromDecay,
    'weather': RecordFile,
}
"""The form of each section of a sea's ship whose values are in a file."""


def with_files_read(ship: dict[str, Any], origin: str) -> dict[str, Any]:
    """Return the keys of a ship, not checked yet, with numbers in place of the files of its sea.

    `ship.sea` of spectrum file becomes a table, `ship.rao` with a path the operator, `ship.hull`
    with a path the contents of the file, `ship.roll` with a decay its period and damping ratio,
    `ship.weather` of a record its rows. The rest is not changed. Errors name the scene,
    `origin`, and the path of the key, or file and line.
    """
    read = dict(ship)
    if _holds(ship, 'sea', 'spectrum') and ship['sea']['spectrum'] == 'file':
        read['sea'] = section_read(SpectrumFile, read_spectrum, ship, 'sea.path', origin)
    if _holds(ship, 'rao', 'path'):
        read['rao'] = section_read(RaoFile, read_operator, ship, 'rao.path', origin)
    if _holds(ship, 'hull', 'path'):
        read['hull'] = section_read(HullFile, read_hull, ship, 'hull.path', origin)
    if _holds(ship, 'roll', 'decay'):
        read['roll'] = section_read(RollFromDecay, fitted_roll, ship, 'roll.decay.path', origin)
    if _holds(ship, 'weather', 'path') and ship['weather'].get('kind') == 'record':

        def read_weather(asked: RecordFile) -> dict[str, Any]:
            # a response operator may have its own heading
            rao = ship.get('rao')
            fixed = isinstance(rao, dict) and rao.get('heading') is not None
            by_direction = asked.follow_route and not fixed
            return read_record(asked, by_direction=by_direction)

        read['weather'] = section_read(RecordFile, read_weather, ship, 'weather.path', origin)
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
        path: path of the key that names the file, from there.
        origin: name of the scene, for errors.
        prefix: the part before the path in the scene, for errors.
        any_size: whether a file of any size will do, because only a part of it is read.

    Raises:
        SceneError: keys or a file that are wrong.
    """
    section, *names = path.split('.')
    try:
        asked = form.model_validate(ship[section])
    except ValidationError as error:
        found = [
            Problem(f'{prefix}{section}.{each.key}', each.value, each.problem, each.remedy)
            for each in explain(error, form)
        ]
    else:
        named = str(reduce(getattr, names, asked))
        found = missing_file(f'{prefix}{path}', named, any_size=any_size)
        if not found:
            return reader(asked)
    first, *further = found
    raise SceneError(
        origin, first.key, first.value, first.problem, first.remedy, further=further
    ) from None
