"""The files of a sea: read into the scene, or refused with file and line."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from tauto_core.scene import SceneError, load_scene, parse_scene, scene_yaml
from tauto_core.scene.tables import data_path
from tauto_core.ship.sections import Rao

SPECTRUM = 'shipped:ndbc_44004/2000-01-01T02.csv'
OPERATOR = 'shipped:supply_rao/supply_rao.csv'
ROLL = {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7}
HEAD = 'frequency_hz,energy_density_m2_per_hz\n'
BEAM = 0.5 * math.pi


def ship(**keys: object) -> dict[str, object]:
    sea = {'spectrum': 'file', 'path': SPECTRUM}
    return {'kind': 'sea', 'sea': sea, 'rao': {'path': OPERATOR, 'heading': BEAM}, **keys}


def refused(message: str, **keys: object) -> None:
    with pytest.raises(SceneError, match=message):
        load_scene('ideal', ship={k: v for k, v in ship(**keys).items() if v is not None})


def operator_rows() -> list[dict[str, float]]:
    with data_path(OPERATOR).open() as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


def test_a_scene_holds_the_tables_and_needs_no_file(tmp_path: Path) -> None:
    for path, name in ((SPECTRUM, 'sea.csv'), (OPERATOR, 'ship.csv')):
        (tmp_path / name).write_text(data_path(path).read_text())
    still = scene_yaml(load_scene('ideal', ship={'kind': 'still'}, duration=60.0))
    before, _, after = still.partition('ship:')
    sea = (
        'ship:\n  kind: sea\n  sea: {spectrum: file, path: sea.csv}\n'
        '  rao: {path: ship.csv, heading: 2.0}\n'
    )
    (tmp_path / 'scene.yaml').write_text(before + sea + after[after.index('clock:') :])
    scene = load_scene(tmp_path / 'scene.yaml')
    resolved = scene_yaml(scene)
    for name in ('sea.csv', 'ship.csv', 'scene.yaml'):
        (tmp_path / name).unlink()
    assert parse_scene(resolved, 'bag') == scene
    assert str(tmp_path) not in resolved
    assert (scene.ship.sea.source, scene.ship.rao.source) == ('sea.csv', 'ship.csv')


def test_the_table_is_that_of_the_file() -> None:
    sea = load_scene('ideal', ship=ship()).ship.sea
    rows = np.loadtxt(data_path(SPECTRUM), delimiter=',', skiprows=1)
    np.testing.assert_array_equal(sea.frequency, rows[:, 0])
    np.testing.assert_array_equal(sea.energy_density, rows[:, 1])


def test_a_row_at_rest_without_energy_is_dropped(tmp_path: Path) -> None:
    (tmp_path / 'x.csv').write_text(HEAD + '0.0,0.0\n0.1,1.0\n\n0.2,2.0\n')
    sea = {'spectrum': 'file', 'path': str(tmp_path / 'x.csv'), 'components': 7}
    read = load_scene('ideal', ship=ship(sea=sea)).ship.sea
    assert (read.frequency, read.energy_density, read.components) == ((0.1, 0.2), (1.0, 2.0), 7)


def at_heading(heading: float) -> Rao:
    return load_scene('ideal', ship=ship(rao={'path': OPERATOR, 'heading': heading})).ship.rao


@pytest.mark.parametrize('heading_deg', [0, 130, 180])
def test_the_operator_at_a_heading_of_the_file_is_the_files(heading_deg: int) -> None:
    rao = at_heading(math.radians(heading_deg))
    rows = [row for row in operator_rows() if row['heading_deg'] == heading_deg]
    for key, column in (
        ('angular_frequency', 'omega_radps'),
        ('roll_real', 'roll_re'),
        ('roll_imaginary', 'roll_im'),
        ('heave_real', 'heave_re'),
        ('heave_imaginary', 'heave_im'),
    ):
        # rounding of degrees to radians and back
        wanted = [row[column] for row in rows]
        np.testing.assert_allclose(getattr(rao, key), wanted, rtol=1e-12, atol=1e-12)


def test_an_operator_is_linear_and_mirrored_to_starboard() -> None:
    low, middle, high = (at_heading(math.radians(x)) for x in (40.0, 42.5, 50.0))
    expected = 0.75 * np.array(low.roll_imaginary) + 0.25 * np.array(high.roll_imaginary)
    np.testing.assert_allclose(middle.roll_imaginary, expected, rtol=1e-10, atol=1e-15)
    starboard = at_heading(math.radians(360.0 - 42.5))
    np.testing.assert_allclose(starboard.roll_real, np.negative(middle.roll_real), rtol=1e-9)
    np.testing.assert_allclose(starboard.heave_real, middle.heave_real, rtol=1e-9)


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('', r'x\.csv: line 1, column frequency_hz: is missing.*wavespectra converts'),
        (HEAD + '0.1,1\n', r'number of frequencies = 1: is not enough'),
        (
            HEAD + '0.1,1\n0.2,-0.5\n',
            r'line 3, energy_density_m2_per_hz = -0\.5: must be at least',
        ),
        (HEAD + '0.2,1\n0.1,1\n', r'line 3, frequency_hz = 0\.1: must be greater.*0\.2 Hz.*Sort'),
        (HEAD + '0,1\n0.1,1\n', r'line 2, frequency_hz = 0\.0: must be greater'),
        (HEAD + '0.1,0\n0.2,0\n', r'is 0 m2/Hz at all frequencies: the spectrum is empty'),
    ],
)
def test_bad_spectra_are_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / 'x.csv').write_text(text)
    refused(message, sea={'spectrum': 'file', 'path': str(tmp_path / 'x.csv')})


@pytest.mark.parametrize(
    ('keys', 'message'),
    [
        ({'frequency': [0.1], 'energy_density': [1.0]}, r'sea\.frequency = \[0\.1\]: has less'),
        ({'frequency': [0.1, 0.1], 'energy_density': [1.0, 1.0]}, r'frequency\[1\] = 0\.1: must'),
        ({'frequency': [0.1, 0.2], 'energy_density': [1.0]}, r'has 1 values for 2 frequencies'),
        ({'frequency': [0.1, 0.2], 'energy_density': [0.0, 0.0]}, r'the spectrum is empty'),
        ({'frequency': [0.1, 0.2], 'energy_density': [1.0, -1.0]}, r'density\[1\] = -1\.0'),
        ({'frequency': [0.1, 0.2]}, r'sea\.energy_density: is missing'),
        ({'peak_period': 9.0}, r'is not a key of spectrum table'),
    ],
)
def test_bad_tables_are_refused(keys: dict[str, object], message: str) -> None:
    refused(message, sea={'spectrum': 'table', 'source': 'x', **keys})


@pytest.mark.parametrize(
    ('keys', 'message'),
    [
        ({'sea': {'spectrum': 'flat'}}, r'sea\.spectrum = .flat.*bretschneider.*table, file'),
        ({'sea': {'spectrum': 'file'}}, r'ship\.sea\.path: is missing'),
        ({'sea': {'spectrum': 'file', 'path': 'none.csv'}}, r'sea\.path = .*no such file'),
        ({'sea': {'spectrum': 'file', 'path': SPECTRUM, 'time': 'x'}}, r'time = .x.*not a key'),
        (
            {'sea': {'spectrum': 'file', 'path': 'x', 'format': 'spotter'}},
            r'sea\.format.* any more',
        ),
        ({'rao': None}, r'ship\.roll: is missing, and there is no rao'),
        (
            {'rao': None, 'roll': {'decay': {}}},
            r'ship\.roll\.decay: is not a key any more: .*Give natural',
        ),
        ({'roll': ROLL}, r'ship\.rao: does not go with ship\.roll'),
        ({'heading': 1.0}, r'ship\.heading = 1\.0: does not go with ship\.rao'),
        ({'rao': {'path': OPERATOR, 'heading': 90.0}}, r'rao\.heading = 90\.0: must be less'),
        ({'rao': {'path': OPERATOR, 'heading': -0.1}}, r'rao\.heading = -0\.1: must be at least'),
        ({'rao': {'path': SPECTRUM, 'heading': 1.0}}, r'column heading_deg: is missing'),
        ({'speed': -1.0}, r'ship\.speed = -1\.0: must be at least 0'),
        ({'speed': 300.0}, r'ship\.speed = 300\.0: must be at most 50'),
    ],
)
def test_bad_keys_are_refused(keys: dict[str, object], message: str) -> None:
    refused(message, **keys)


ROWS = 'heading_deg,omega_radps,roll_re,roll_im{}\n{}\n'
TWO = '90,1,0,1,0\n90,2,0,1,0\n80,1,0,1,0\n80,2,0,1,0\n90,1,0,1,5\n90,2,0,1,5'


@pytest.mark.parametrize(
    ('columns', 'rows', 'message'),
    [
        ('', '80,0.1,0,1\n80,3,0,1', r'heading = 1\.57.*is 90 deg.*covers 80 to 80 deg'),
        ('', '90,0.2,0,1\n90,0.1,0,1', r'line 3, omega_radps = 0\.1: must be greater'),
        ('', '90,0,0,1\n90,0.1,0,1', r'line 2, omega_radps = 0\.0: must be greater than 0'),
        ('', '90,1,0,1', r'omega_radps = 1\.0: is the only frequency'),
        ('', '0,1,0,1\n0,2,0,1\n90,1,0,1\n90,3,0,1', r'line 4, omega_radps = 1\.0: begins a head'),
        (',speed_mps', '90,1,0,1,0\n90,2,0,1,5', r'line 3, omega_radps = 2\.0: begins a head'),
        (',speed_mps', '90,1,0,1,0\n90,2,0,1,-5', r'line 3, speed_mps = -5\.0: must not be neg'),
        (',speed_mps', TWO, r'line 6, speed_mps = 5\.0: .*, 5 m/s, without the heading 80 deg'),
        (',sway_re', '90,1,0,1,0\n90,2,0,1,5', r'line 1, column sway_im: is missing.*roll_im'),
    ],
)
def test_bad_operators_are_refused(tmp_path: Path, columns: str, rows: str, message: str) -> None:
    (tmp_path / 'x.csv').write_text(ROWS.format(columns, rows))
    refused(message, rao={'path': str(tmp_path / 'x.csv'), 'heading': BEAM})


def test_heave_needs_an_operator_of_heave(tmp_path: Path) -> None:
    (tmp_path / 'x.csv').write_text(ROWS.format('', '90,0.1,0,1\n90,3,0,1'))
    rao = {'path': str(tmp_path / 'x.csv'), 'heading': BEAM}
    refused(
        r'ship\.heave = True: asks for heave, which the operator does not have',
        rao=rao,
        heave=True,
    )
