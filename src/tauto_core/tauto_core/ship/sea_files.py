"""The files from which a sea is computed: operators, spectra, roll decay tests.

A scene that runs contains tables and numbers, no paths, so a bag needs nothing but its text.
"""

from __future__ import annotations

import glob
import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import reduce
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

from pydantic import Field, Strict, ValidationError

from tauto_core.scene.data import Columns, data_path, missing_file, read_columns, source_name
from tauto_core.scene.errors import ABSENT, Problem, SceneError, install
from tauto_core.scene.fields import LONGEST_TEXT, NonNegative, Positive, Section, Text
from tauto_core.scene.refuse import explain
from tauto_core.ship.sections import ComponentCount, Heading
from tauto_core.ship.weather_kind import RecordFile, read_record

if TYPE_CHECKING:
    from tauto_core.samples import FloatArray


# -----------------------------------------------------------------------------
# Response amplitude operators of a ship: from a file with all headings to one heading.
#
# Columns: `heading_deg` (0 following seas, 90 beam seas to port, 180 head seas), `omega_radps`,
# `roll_re` and `roll_im` [rad per m of wave amplitude] and, where the ship's heave is known,
# `heave_re` and `heave_im` [m/m], as factors of exp(i omega t) at the ship's origin, in the axes
# of theory E1; other columns are ignored. All headings have the same frequencies.

HEADING, OMEGA, SPEED = 'heading_deg', 'omega_radps', 'speed_mps'
ROLL = ('roll_re', 'roll_im')
HEAVE = ('heave_re', 'heave_im')
_OPERATOR_FORM = (
    f'Give a CSV file with the columns {HEADING}, {OMEGA}, {", ".join(ROLL)} and, for the heave, '
    f'{", ".join(HEAVE)}.'
)


class RaoFile(Section):
    """An operator from a file; the scene that runs contains its values at the heading."""

    path: Text = Field(description='CSV file of the operator')
    heading: Heading = Field(
        description='direction in which the waves run, from the bow to port [rad]: 0 following '
        'seas, 1.5708 beam seas, 3.1416 head seas'
    )


def read_operator(asked: RaoFile) -> dict[str, Any]:
    """Return the keys of `ship.rao`: the operator at one heading, linear between two of the file.

    A ship is symmetric: waves to starboard (heading > pi) are those to port mirrored, with the
    roll of the other sign.

    Args:
        asked: the file and the heading.

    Raises:
        SceneError: a file that cannot be read, an operator of a ship under way, frequencies that
            do not increase or differ between headings, a heading outside the file's; with the
            line.
    """
    optional = (*HEAVE, SPEED)
    table = read_columns(asked.path, (HEADING, OMEGA, *ROLL), optional, remedy=_OPERATOR_FORM)
    _check_at_rest(table)
    blocks = _by_heading(table)
    mirrored = asked.heading > math.pi
    heading = math.degrees(math.tau - asked.heading if mirrored else asked.heading)
    below, above, share = _neighbours(asked, sorted(blocks), heading)
    sign = -1.0 if mirrored else 1.0
    columns = {'roll_real': ROLL[0], 'roll_imaginary': ROLL[1]}
    if all(column in table.values for column in HEAVE):
        columns |= {'heave_real': HEAVE[0], 'heave_imaginary': HEAVE[1]}
    keys: dict[str, Any] = {
        'source': source_name(asked.path),
        'heading': asked.heading,
        'angular_frequency': [table.values[OMEGA][row] for row in blocks[below]],
    }
    for key, column in columns.items():
        factor, values = sign if column in ROLL else 1.0, table.values[column]
        rows = zip(blocks[below], blocks[above], strict=True)
        keys[key] = [factor * ((1.0 - share) * values[i] + share * values[j]) for i, j in rows]
    return keys


def _check_at_rest(table: Columns) -> None:
    for line, speed in zip(table.lines, table.values.get(SPEED, []), strict=False):
        if speed != 0.0:
            problem = 'must be 0: the operator of a ship at rest is carried over to ship.speed'
            remedy = f'Keep the rows at rest, or drop the column {SPEED} if they are.'
            raise SceneError(table.name, f'line {line}, {SPEED}', speed, problem, remedy)


def _by_heading(table: Columns) -> dict[float, list[int]]:
    """Return the rows of each heading [deg]; all must have the same increasing frequencies."""
    blocks: dict[float, list[int]] = {}
    for row, heading in enumerate(table.values[HEADING]):
        blocks.setdefault(heading, []).append(row)
    omega = table.values[OMEGA]
    first = next(iter(blocks.values()))
    for where, value, problem in _wrong_frequencies(table, blocks, first):
        remedy = 'Give every heading the same frequencies, in rising order.'
        raise SceneError(table.name, f'{where}, {OMEGA}', value, problem, remedy)
    if len(first) < 2:
        problem = 'is not enough: an operator needs at least 2 frequencies'
        remedy = 'Give it at more frequencies.'
        raise SceneError(table.name, OMEGA, omega[first[0]], problem, remedy)
    return blocks


def _wrong_frequencies(
    table: Columns, blocks: dict[float, list[int]], first: list[int]
) -> Iterator[tuple[str, float, str]]:
    omega, lines = table.values[OMEGA], table.lines
    if not omega[first[0]] > 0.0:
        yield f'line {lines[first[0]]}', omega[first[0]], 'must be greater than 0 rad/s'
    for heading, rows in blocks.items():
        for before, row in pairwise(rows):
            if not omega[row] > omega[before]:
                problem = f'must be greater than the one before, {omega[before]!r} rad/s'
                yield f'line {lines[row]}', omega[row], problem
        if [omega[row] for row in rows] != [omega[row] for row in first]:
            problem = (
                f'begins a heading, {heading:g} deg, whose frequencies are not the first one’s'
            )
            yield f'line {lines[rows[0]]}', omega[rows[0]], problem


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
    path: Text = Field(description='file of the spectrum')
    format: Literal['table', 'ndbc', 'datawell', 'spotter', 'triaxys'] = Field(
        default='table', description='table (CSV), ndbc, datawell, spotter or triaxys'
    )
    time: Text | None = Field(
        default=None,
        description='UTC of the spectrum where the file holds several, as 2000-01-01T02:00',
    )
    components: ComponentCount = Field(default=64, description='number of components, 1 to 4096')


def read_spectrum(asked: SpectrumFile) -> dict[str, Any]:
    """Return the keys of `ship.sea` with a measured spectrum as a table.

    A row at 0 Hz without energy is dropped, since no wave has that frequency.

    Args:
        asked: the file, its format and, where it holds several spectra, the time of one.

    Raises:
        SceneError: a file that cannot be read, a time that does not select one spectrum, fewer
            than two frequencies, frequencies that do not increase, gaps, negative or no energy; or
            the extra `spectra` is not installed. With the line, or the frequency.
    """
    source = source_name(asked.path)
    if asked.format == 'table':
        where, frequency, density = _table(asked)
    else:
        frequency, density, stamp = _of_buoy(asked)
        where = [f'at {each:g} Hz' for each in frequency]
        source = f'{source} {stamp}'
    if frequency and frequency[0] == 0.0 and density[0] == 0.0:
        where, frequency, density = where[1:], frequency[1:], density[1:]
    check_spectrum(asked.path, where, frequency, density)
    return {
        'spectrum': 'table',
        'source': source[-LONGEST_TEXT:],
        'frequency': list(frequency),
        'energy_density': list(density),
        'components': asked.components,
    }


def check_spectrum(
    name: str, where: Sequence[str], frequency: Sequence[float], density: Sequence[float]
) -> None:
    """Refuse a table that is not a spectrum.

    Args:
        name: name of its file.
        where: for each row, its line or frequency, for messages.
        frequency: [Hz].
        density: [m2/Hz], as many.

    Raises:
        SceneError: the table is refused; names file, row and value.
    """
    if len(frequency) < 2:
        remedy = 'Give the energy at more frequencies.'
        problem = 'is not enough: a spectrum needs at least 2 frequencies above 0 Hz'
        raise SceneError(name, 'number of frequencies', len(frequency), problem, remedy)
    before = 0.0
    for place, each, energy in zip(where, frequency, density, strict=True):
        if not each > before:
            problem = f'must be greater than the frequency before, {before!r} Hz'
            remedy = 'Sort the rows by frequency, and drop what is double.'
            raise SceneError(name, f'{place}, frequency', each, problem, remedy)
        if not math.isfinite(energy):
            remedy = 'Choose a spectrum without gaps, or fill it in.'
            problem = 'is a gap: nothing was measured there'
            raise SceneError(name, f'{place}, energy density', energy, problem, remedy)
        if energy < 0.0:
            remedy = 'Correct the row; noise below 0 may be set to 0.'
            problem = 'must be at least 0 m2/Hz: no wave has negative energy'
            raise SceneError(name, f'{place}, energy density', energy, problem, remedy)
        before = each
    if not any(density):
        remedy = 'Choose another spectrum, or ship kind still for a calm.'
        problem = 'is 0 m2/Hz at all frequencies: the spectrum is empty'
        raise SceneError(name, 'energy density', ABSENT, problem, remedy)


def _table(asked: SpectrumFile) -> tuple[list[str], list[float], list[float]]:
    if asked.time is not None:
        problem = 'does not go with format table, which holds one spectrum'
        raise SceneError(asked.path, 'time', asked.time, problem, 'Leave it out.')
    table = read_columns(asked.path, (FREQUENCY, DENSITY), remedy=_SPECTRUM_FORM)
    where = [f'line {line}' for line in table.lines]
    return where, table.values[FREQUENCY], table.values[DENSITY]


def _of_buoy(asked: SpectrumFile) -> tuple[list[float], list[float], str]:
    """Return frequencies, energy densities and the time of one spectrum of a buoy's file."""
    data = _read_with_library(asked)
    stamps = [str(each) for each in data['time'].values.astype('datetime64[s]').reshape(-1)]
    chosen = _chosen(asked, stamps)
    # the shortest digits, since the float32 nearest to 0.1 means 0.1
    frequency = [float(str(each)) for each in data['freq'].values]
    density = [float(each) for each in data.transpose('time', 'freq').values[chosen]]
    if asked.format == 'ndbc':
        density = [math.nan if each == NDBC_MISSING else each for each in density]
    return frequency, density, stamps[chosen]


def _chosen(asked: SpectrumFile, stamps: list[str]) -> int:
    """Return the number of the one spectrum that is asked for."""
    told = f'{len(stamps)} spectra from {min(stamps)} to {max(stamps)}' if stamps else 'none'
    if asked.time is None:
        if len(stamps) == 1:
            return 0
        problem = f'is missing, and the file holds {told}'
        remedy = 'Give ship.sea.time, for example ' + (stamps[0] if stamps else '…') + '.'
        raise SceneError(asked.path, 'time', ABSENT, problem, remedy)
    wanted = _instant(asked)
    found = [i for i, stamp in enumerate(stamps) if datetime.fromisoformat(stamp) == wanted]
    if len(found) == 1:
        return found[0]
    if found:
        problem = f'names {len(found)} spectra of the file'
        raise SceneError(asked.path, 'time', asked.time, problem, 'Cut the file to one of them.')
    near = sorted(stamps, key=lambda stamp: abs(datetime.fromisoformat(stamp) - wanted))[:2]
    problem = f'is not a time of the file, which holds {told}'
    raise SceneError(asked.path, 'time', asked.time, problem, f'Use {" or ".join(near)}.')


def _instant(asked: SpectrumFile) -> datetime:
    try:
        instant = datetime.fromisoformat(asked.time or '')
    except ValueError:
        problem, remedy = 'is not a date and time', 'Write it as 2000-01-01T02:00, in UTC.'
        raise SceneError(asked.path, 'time', asked.time, problem, remedy) from None
    return instant if instant.tzinfo is None else instant.astimezone(UTC).replace(tzinfo=None)


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
            said = f'{type(error).__name__}: {" ".join(str(error).split())}'
    problem = f'cannot be read as format {asked.format}: {said}'
    remedy = 'Correct ship.sea.format or the file, or give the spectrum as a CSV table.'
    raise SceneError(asked.path, '', None, problem, remedy)


# -----------------------------------------------------------------------------
# Natural period and damping of the roll, fitted to a measured roll decay test.

FEWEST_A_CYCLE = 8
"""Samples that a cycle of the roll must have."""
_DECAY_FORM = 'Give a CSV file whose first line names ship.roll.decay.time_column and roll_column.'
_UNITS = {'_s': 1.0, '_rad': 1.0, '_deg': math.pi / 180.0}


class RollDecay(Section):
    """A roll decay test: the ship is heeled, released, and rolls in calm water until it rests."""

    path: Text = Field(description='CSV file of the test')
    time_column: Text = Field(description='column of the time, …_s')
    roll_column: Text = Field(description='column of the roll, …_deg or …_rad')
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
        natural_period: 2 pi/omega_n [s].
        damping_ratio: zeta.
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
    """Return the keys of `ship.roll`: fitted period and damping ratio, and the source of the fit.

    Args:
        asked: the test and the slope coefficient.

    Raises:
        SceneError: a file that cannot be read, or no decay in it; with the line.
    """
    import numpy as np

    decay = asked.decay
    units = [_unit(decay, 'time_column', ('_s',)), _unit(decay, 'roll_column', ('_rad', '_deg'))]
    columns = (decay.time_column, decay.roll_column)
    table = read_columns(decay.path, columns, remedy=_DECAY_FORM)
    time, roll = (
        unit * np.array(table.values[column]) for unit, column in zip(units, columns, strict=True)
    )
    backward = np.flatnonzero(np.diff(time) <= 0.0)
    if backward.size:
        line = table.lines[int(backward[0]) + 1]
        value, problem = float(time[backward[0] + 1]), 'must be later than the time before'
        remedy = 'Sort the rows and drop what is double.'
        where = f'line {line}, {decay.time_column}'
        raise SceneError(decay.path, where, value, problem, remedy)
    fit = fit_decay(*released(decay.path, time, roll, decay.cycles))
    longer = math.sqrt(decay.model_scale)
    period, sigma = longer * fit.natural_period, longer * fit.period_sigma
    if not fit.damping_ratio > 0.0:
        problem = f'is fitted to {decay.cycles} cycles, but must be > 0: the roll does not decay'
        remedy = 'Fit other cycles, or give natural_period and damping_ratio.'
        raise SceneError(decay.path, 'damping ratio', fit.damping_ratio, problem, remedy)
    said = (
        f'{source_name(decay.path)}: {decay.cycles} cycles, period {period:.5g} ± {sigma:.1g} s, '
        f'damping ratio {fit.damping_ratio:.3g} ± {fit.damping_sigma:.1g}'
    )
    return {
        'natural_period': period,
        'damping_ratio': fit.damping_ratio,
        'slope_coefficient': asked.slope_coefficient,
        'fitted_to': said[-LONGEST_TEXT:],
    }


def _unit(decay: RollDecay, key: str, suffixes: tuple[str, ...]) -> float:
    column = str(getattr(decay, key))
    for suffix in suffixes:
        if column.endswith(suffix):
            return _UNITS[suffix]
    problem = f'has no known unit; it must end in {" or ".join(suffixes)}'
    raise SceneError(decay.path, key, column, problem, 'Rename the column.')


def released(
    name: str, time: FloatArray, roll: FloatArray, cycles: int
) -> tuple[FloatArray, FloatArray]:
    """Return the part of a test in which the ship rolls freely.

    It begins where the roll first passes the middle after its largest angle (until then the ship
    may have been held) and lasts `cycles` cycles. The middle is the mean of the last quarter of
    the test.

    Args:
        name: name of the file, for messages.
        time: [s], increasing, shape (n,).
        roll: [rad], shape (n,).
        cycles: number of cycles.

    Raises:
        SceneError: there are not so many cycles, or too few samples in one.
    """
    import numpy as np

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
    """Fit rho = mean + exp(-zeta w t) (a cos w_d t + b sin w_d t), w_d = w sqrt(1 - zeta^2).

    Least squares over w and zeta; the other parameters are linear. The damping of a ship falls
    with the angle, so the residual of this linear decay is not white noise. The standard errors
    therefore count one independent residual in each half cycle.

    Args:
        time: [s], increasing, shape (n,), of whole cycles beginning at a zero crossing.
        roll: [rad], shape (n,).
    """
    import numpy as np
    from scipy.optimize import least_squares

    t = time - time[0]
    half_cycles, first = _first_guess(t, roll)

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


def _first_guess(t: FloatArray, roll: FloatArray) -> tuple[int, list[float]]:
    """Return the number of half cycles, w from it, and zeta from the sizes of both halves."""
    import numpy as np

    about = roll - np.mean(roll)
    up = about > 0.0
    half_cycles = max(int(np.count_nonzero(up[1:] != up[:-1])) + 1, 2)
    half = len(t) // 2
    early, late = (float(np.sqrt(np.mean(part**2))) for part in (about[:half], about[half:]))
    omega = math.pi * half_cycles / float(t[-1])
    decrement = 2.0 * math.log(early / late) / float(t[-1])
    return half_cycles, [omega, min(max(decrement / omega, 1e-4), 0.9)]


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
