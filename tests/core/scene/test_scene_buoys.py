"""Files of buoys, against the library that reads them and their own figures."""

import sys
from pathlib import Path

import numpy as np
import pytest

from tauto_core.scene import SceneError, load_scene
from tauto_core.scene.tables import data_path
from tauto_core.ship.sea import height_and_period

ROLL = {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7}
TABLE = 'shipped:ndbc_44004/2000-01-01T02.csv'


def sea_of(path: Path | str, form: str, time: str | None = None) -> object:
    asked = {'spectrum': 'file', 'path': str(path), 'format': form}
    asked |= {} if time is None else {'time': time}
    return load_scene('ideal', ship={'kind': 'sea', 'sea': asked, 'roll': ROLL}).ship.sea


def ndbc(tmp_path: Path, *, gap: bool = False, hours: tuple[str, ...] = ('00', '02')) -> Path:
    """Write the shipped spectrum as NDBC writes it, under several hours of half the energy."""
    rows = np.loadtxt(data_path(TABLE), delimiter=',', skiprows=1)
    lines = ['YYYY MM DD hh ' + ' '.join(f'{f:6.3f}' for f in rows[:, 0])]
    for hour in hours:
        factor = 1.0 if hour == '02' else 0.25
        cells = [f'{factor * s:6.4f}' for s in rows[:, 1]]
        if gap:
            cells[5] = '999.00'
        lines.append(f'2000 01 01 {hour} ' + ' '.join(cells))
    (tmp_path / '44004w2000.txt').write_text('\n'.join(lines) + '\n')
    return tmp_path / '44004w2000.txt'


def test_an_extra_that_is_missing_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, 'wavespectra', None)
    with pytest.raises(SceneError, match=r'needs the library wavespectra.*tauto_core\[spectra\]'):
        sea_of(ndbc(tmp_path), 'ndbc', '2000-01-01T02:00')


@pytest.fixture
def library() -> object:
    # it compiles nothing, but takes seconds to import
    return pytest.importorskip('wavespectra')


@pytest.mark.usefixtures('library')
def test_an_ndbc_spectrum_is_chosen_by_its_time(tmp_path: Path) -> None:
    file = ndbc(tmp_path)
    sea = sea_of(file, 'ndbc', '2000-01-01T02:00')
    rows = np.loadtxt(data_path(TABLE), delimiter=',', skiprows=1)
    np.testing.assert_array_equal(sea.frequency, rows[:, 0])
    np.testing.assert_array_equal(sea.energy_density, rows[:, 1])
    assert sea.source == '44004w2000.txt 2000-01-01T02:00:00'
    half = sea_of(file, 'ndbc', '2000-01-01T01:00+01:00')
    assert height_and_period(half)[0] == pytest.approx(0.5 * height_and_period(sea)[0], rel=1e-4)


@pytest.mark.usefixtures('library')
def test_a_time_that_chooses_no_one_spectrum_is_refused(tmp_path: Path) -> None:
    file = ndbc(tmp_path)
    told = '2 spectra from 2000-01-01T00:00:00 to 2000-01-01T02:00:00'
    with pytest.raises(SceneError, match=f'time: is missing, and the file holds {told}'):
        sea_of(file, 'ndbc')
    with pytest.raises(SceneError, match=r'not a time of the file.*Use 2000-01-01T02:00:00 or'):
        sea_of(file, 'ndbc', '2000-01-01T03:00')
    with pytest.raises(SceneError, match=r'time = .noon.*is not a date and time'):
        sea_of(file, 'ndbc', 'noon')
    twice = ndbc(tmp_path, hours=('00', '02', '02'))
    with pytest.raises(SceneError, match='names 2 spectra of the file'):
        sea_of(twice, 'ndbc', '2000-01-01T02:00')


@pytest.mark.usefixtures('library')
def test_a_gap_is_refused_with_its_frequency(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r'at 0\.08 Hz, energy density = nan: is a gap'):
        sea_of(ndbc(tmp_path, gap=True), 'ndbc', '2000-01-01T02:00')


def test_heights_are_those_of_the_library(library: object, tmp_path: Path) -> None:
    """Its sum over bins and our trapezoids differ at the two ends, by 0.1 % here."""
    file = ndbc(tmp_path, hours=('02',))
    density = library.read_ndbc_ascii(str(file)).efth.spec.oned()
    height, period = height_and_period(sea_of(file, 'ndbc'))
    assert height == pytest.approx(float(density.spec.hs(tail=False)[0]), rel=1e-3)
    assert period == pytest.approx(float(density.spec.tp(smooth=False)[0]), rel=1e-6)


@pytest.mark.usefixtures('library')
def test_a_datawell_file_has_the_height_of_its_header(tmp_path: Path) -> None:
    """Twelve lines of header: Hs in cm on the second, the largest density on the fourth."""
    rows = np.loadtxt(data_path(TABLE), delimiter=',', skiprows=1)
    most = rows[:, 1].max()
    head = ['1', '172.5', '4.0', f'{most:.4f}', '25', '19', '7', '0', '0', '0', '213.8', '68.2']
    body = [f'{f:.3f},{s / most:.6E},0,30,0,2' for f, s in rows]
    (tmp_path / 'buoy.spt').write_text('\n'.join([*head, *body]) + '\n')
    with pytest.raises(SceneError, match=r'name = .buoy\.spt.: lacks station and time'):
        sea_of(tmp_path / 'buoy.spt', 'datawell')
    named = tmp_path / 'buoy}2024-09-09T01h15Z.spt'
    (tmp_path / 'buoy.spt').rename(named)
    sea = sea_of(named, 'datawell')
    assert height_and_period(sea)[0] == pytest.approx(1.725, abs=0.001)
    assert sea.source.endswith('2024-09-09T01:15:00')


@pytest.mark.usefixtures('library')
def test_a_triaxys_file_is_read(tmp_path: Path) -> None:
    head = [
        'TRIAXYS BUOY DATA REPORT - TAS01970',
        'TYPE    = NON-DIRECTIONAL SPECTRUM',
        'DATE    = 2018-01-31 21:00(UTC)',
        'NUMBER OF FREQUENCIES              =   4',
        'INITIAL FREQUENCY (Hz)             =   0.000',
        'FREQUENCY SPACING (Hz)             =   0.100',
        'COLUMN 1 = FREQUENCY (Hz)',
        'COLUMN 2 = SPECTRAL DENSITY (M^2/Hz)',
    ]
    body = ['0.000  0.0', '0.100  1.0', '0.200  3.0', '0.300  0.5']
    (tmp_path / 'x.NONDIRSPEC').write_text('\n'.join([*head, *body]) + '\n')
    sea = sea_of(tmp_path / 'x.NONDIRSPEC', 'triaxys')
    np.testing.assert_allclose(sea.frequency, [0.1, 0.2, 0.3], rtol=1e-12)
    np.testing.assert_allclose(sea.energy_density, [1.0, 3.0, 0.5], rtol=1e-12)


@pytest.mark.usefixtures('library')
@pytest.mark.parametrize('form', ['ndbc', 'spotter', 'triaxys'])
def test_a_file_of_another_kind_is_refused(tmp_path: Path, form: str) -> None:
    (tmp_path / 'x.csv').write_text('name: a scene\nduration: 1\n')
    with pytest.raises(SceneError, match=rf'x\.csv: cannot be read as format {form}: \w+Error'):
        sea_of(tmp_path / 'x.csv', form)
