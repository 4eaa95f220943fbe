"""Measured wave spectra: from a table or a buoy's file to the spectrum of a scene.

A table has the columns `frequency_hz` and `energy_density_m2_per_hz`. The files of buoys are read
by wavespectra, the optional extra `spectra`; directional spectra are summed over the directions.
"""

from __future__ import annotations

import glob
import math
import warnings
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import Any, Literal

from pydantic import Field

from tauto_core.scene.csv_columns import read_columns
from tauto_core.scene.data import data_path, source_name
from tauto_core.scene.errors import ABSENT, SceneError, install
from tauto_core.scene.fields import LONGEST_TEXT, Section, Text
from tauto_core.ship.sea_sections import ComponentCount

FREQUENCY, DENSITY = 'frequency_hz', 'energy_density_m2_per_hz'
NDBC_MISSING = 999.0
"""The values that NDBC writes where nothing was measured."""

_FORM = (
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
    table = read_columns(asked.path, (FREQUENCY, DENSITY), remedy=_FORM)
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
