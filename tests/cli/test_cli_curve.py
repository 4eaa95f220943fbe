"""`tauto cam` and `tauto isochronism`."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, refused, run


def outline_mm(path: Path) -> tuple[np.ndarray, np.ndarray]:
    rows = list(csv.DictReader(path.read_text(encoding='utf-8').splitlines()))
    x, y = (np.array([float(row[key]) for row in rows]) for key in ('x_mm', 'y_mm'))
    return x, y


def test_csv_of_the_involute_is_the_involute_of_its_base_circle(tmp_path: Path) -> None:
    # In polar form: at distance ρ the unrolled angle is sqrt(ρ²/r² − 1), r = 5 mm; the cheek
    # begins at the thread at rest, on the base circle.
    file = tmp_path / 'cam.csv'
    run('cam', 'involute_weight_at_sea', '--csv', file, '--reach', '1.5', '--points', '50')
    x, y = outline_mm(file)
    assert len(x) == 99
    assert np.min(np.hypot(x, y)) == pytest.approx(5.0, rel=1e-12)
    assert np.max(np.hypot(x, y)) == pytest.approx(5.0 * math.hypot(1.0, 1.5), rel=1e-12)
    np.testing.assert_allclose(x, -x[::-1], atol=1e-12)


def test_the_printed_rows_hold_the_lever_arm_in_millimetres() -> None:
    rows = run('cam', 'involute_weight_at_sea', '--reach', '1').splitlines()
    angle, lever = (float(word) for word in rows[-1].split()[:2])
    assert (angle, lever) == (1.0, 5.0)


def test_isochronism_prints_nanoseconds_and_json_all_digits() -> None:
    asked = ('isochronism', 'cheek_before_euler', '--amplitudes', '0.2')
    nominal, _, row, left_out = run(*asked).splitlines()
    assert nominal == 'nominal period 0.999827348 s'
    assert left_out == 'left out: drag, escapement, ship'
    assert row.split() == ['0.2', '1.198159930', '−14,301.876']
    (found,) = json.loads(run(*asked, '--json'))['rows']
    assert found['period_s'] == pytest.approx(1.198159929531, abs=1e-12)


def test_isochronism_is_that_at_the_temperature_of_the_clock() -> None:
    """A wheel that grows by α, its cam and its lever with it, swings slower by √(1 + αΔ)."""
    brass_per_kelvin, kelvin = 18.9e-6, 10.0
    asked = ('isochronism', 'ideal', '--amplitudes', '1', '--set', 'trochlea.material=brass')
    (found,) = json.loads(run(*asked, '--set', 'air.celsius=30', '--json'))['rows']
    slower = math.sqrt(1.0 + brass_per_kelvin * kelvin)
    assert found['rate_s_per_day'] == pytest.approx(86_400.0 * (1.0 / slower - 1.0), abs=1e-6)


def test_a_thread_that_never_touches_the_cheeks_is_refused(tmp_path: Path) -> None:
    """R = r θ for the involute of 5 mm: 1.5 mm of radius at 0.3 rad, 25 mm beyond the release."""
    file = tmp_path / 'cam.svg'
    assert '--thread = 50' in refused('cam', 'measured', '--svg', str(file), '--thread', '50')
    assert not file.exists()
    thin = invoke('cam', 'measured', '--svg', str(file), '--thread', '1')
    assert thin.exit_code == 0
    assert 'bends round the edges up to' in thin.stderr
    assert f'wrote {file}' in thin.stderr


def test_the_cheeks_go_half_as_far_again_as_the_wheel_swings(tmp_path: Path) -> None:
    file = tmp_path / 'cam.csv'
    said = invoke('cam', 'involute_weight_at_sea', '--csv', str(file))
    assert 'the cheeks end at 1.5 rad, for a wheel released at 1 rad' in said.stderr
    x, y = outline_mm(file)
    assert np.max(np.hypot(x, y)) == pytest.approx(5.0 * math.hypot(1.0, 1.5), rel=1e-12)
    # the cheek of positive angles, the second half, stays on its own side
    assert np.all(x[len(x) // 2 + 1 :] < 0.0)


def test_an_extent_at_which_the_cheeks_cross_is_said(tmp_path: Path) -> None:
    asked = ['cam', 'involute_weight_at_sea', '--svg', str(tmp_path / 'cam.svg'), '--reach']
    assert 'cross at 4.493 rad' in invoke(*asked, '4.5').stderr
    assert 'cross' not in invoke(*asked, '4.49').stderr
