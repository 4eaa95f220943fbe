"""The commands on a scene with a body in a fluid."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from command_line import run

from tauto_core.curves import FluidTautochrone
from tauto_core.machines import compile_machine
from tauto_core.scene import load_scene

OIL = 'globe_in_oil'


def curve() -> FluidTautochrone:
    found = compile_machine(load_scene(OIL)).curve
    assert isinstance(found, FluidTautochrone)
    return found


def test_the_curve_is_written_in_millimetres_from_cusp_to_cusp(tmp_path: Path) -> None:
    run('cam', OIL, '--csv', tmp_path / 'c.csv', '--svg', tmp_path / 'c.svg', '--points', '300')
    rows = list(csv.DictReader((tmp_path / 'c.csv').read_text(encoding='utf-8').splitlines()))
    x, y = (np.array([float(row[key]) for row in rows]) for key in ('x_mm', 'y_mm'))
    assert len(x) == 599
    assert y[-1] == pytest.approx(1e3 * float(curve().height(curve().descent_cusp)), rel=1e-15)
    # the polyline is shorter than the arc by the square of its spacing
    length = np.sum(np.hypot(np.diff(x), np.diff(y))[299:])
    assert length == pytest.approx(1e3 * curve().descent_cusp, rel=1e-5)
    assert (tmp_path / 'c.svg').read_text(encoding='utf-8').startswith('<?xml')


def test_the_printed_rows_end_at_the_cusp() -> None:
    header, *rows = run('cam', OIL).splitlines()
    assert header.split() == ['arc_mm', 'slope', 'x_mm', 'y_mm', 'radius_of_curvature_mm']
    arc, slope, _, _, radius = (float(word) for word in rows[-1].split())
    assert arc == pytest.approx(1e3 * curve().descent_cusp, abs=1e-4)
    assert (slope, radius) == (1.0, 0.0)


def test_check_names_curve_range_and_what_runs() -> None:
    facts = json.loads(run('scene', 'check', OIL, '--json'))
    assert facts['propagator'] == 'half_swings'
    assert 'in closed form' in facts['reason']
    assert facts['curve'] == 'euler'
    assert facts['curve_range_m'] == [curve().ascent_cusp, curve().descent_cusp]
    assert facts['release_arc_m'] == 0.4
    assert facts['left_out'][0]['key'] == 'regulator.added_mass'
    assert facts['expected']['steps_a_swing'] is None
    low, high = facts['curve_range_m']
    assert f'−{-low:.4g} m to {high:.4g} m of arc' in run('scene', 'check', OIL)
