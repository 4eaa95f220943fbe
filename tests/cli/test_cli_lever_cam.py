"""A lever's own cam, from the scene to the workshop."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from command_line import refused, run
from ezdxf.filemanagement import readfile

OWN_CAM = [
    *('cam', 'sully_lever_at_sea', '--set', 'clock.nominal_period=null'),
    *('--set', 'trochlea.cam={kind: lever_corrected, period: 1.0}'),
]


def test_both_cheeks_are_written_for_themselves(tmp_path: Path) -> None:
    files = [tmp_path / f'cam.{kind}' for kind in ('csv', 'svg', 'dxf')]
    run(*OWN_CAM, '--reach', 1.5, '--csv', files[0], '--svg', files[1], '--dxf', files[2])
    rows = list(csv.DictReader(files[0].read_text(encoding='utf-8').splitlines()))
    x, y, angle = (np.array([float(r[k]) for r in rows]) for k in ('x_mm', 'y_mm', 'angle_rad'))
    assert angle[[0, -1]] == pytest.approx([-1.5, 1.5], abs=1e-12)
    assert x[0] > 0.0 > x[-1]
    # no mirror images
    assert abs(y[0] - y[-1]) > 1.0
    document = readfile(files[2])
    assert document.units == 4
    (left,) = document.modelspace().query('LWPOLYLINE[layer=="CHEEK_LEFT"]')
    drawn = np.array(list(left.get_points('xy')))
    np.testing.assert_allclose(drawn[-1], [x[-1], y[-1]], rtol=0, atol=1e-9)
    assert files[1].read_text(encoding='utf-8').startswith('<?xml')


def test_what_cannot_be_drawn_is_refused(tmp_path: Path) -> None:
    assert '--reach = 3.0 rad' in refused(*OWN_CAM, '--reach', 3)
    file = tmp_path / 'never.csv'
    thick = ('--thread', 90, '--reach', 0.5, '--csv', file)
    assert 'Use a thinner thread' in refused(*OWN_CAM, *thick)
    assert not file.exists()
