"""`tauto cam` and `tauto isochronism`."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from command_line import invoke, refused, run


def test_the_printed_rows_hold_the_lever_arm_in_millimetres() -> None:
    rows = run('cam', 'involute_weight_at_sea', '--reach', '1').splitlines()
    angle, lever = (float(word) for word in rows[-1].split()[:2])
    assert (angle, lever) == (1.0, 5.0)


def test_how_far_the_cheeks_are_drawn_is_said(tmp_path: Path) -> None:
    asked = ('cam', 'involute_weight_at_sea', '--svg', tmp_path / 'cam.svg')
    said = 'the cheeks end at 1.5 rad, for a wheel released at 1 rad'
    assert said in invoke(*asked).stderr
    assert 'cross at 4.493 rad' in invoke(*asked, '--reach', '4.5').stderr
    assert 'cross' not in invoke(*asked, '--reach', '4.49').stderr


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
