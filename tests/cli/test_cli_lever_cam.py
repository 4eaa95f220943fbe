"""A lever's own cam, from the scene to the workshop."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import yaml
from ezdxf.filemanagement import readfile
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.scene import load_scene, scene_yaml


@pytest.fixture
def own_cam(tmp_path: Path) -> str:
    content = yaml.safe_load(scene_yaml(load_scene('sully_lever_at_sea')))
    content['trochlea']['cam'] = {'kind': 'lever_corrected', 'period': 1.0}
    content['clock'] = {}
    path = tmp_path / 'own_cam.yaml'
    path.write_text(yaml.safe_dump(content), encoding='utf-8')
    return str(path)


def run(*arguments: object, code: int = 0) -> str:
    result = CliRunner().invoke(app, list(map(str, arguments)))
    assert result.exit_code == code, result.stderr
    return result.stderr if code else result.stdout


def test_both_cheeks_are_written_for_themselves(own_cam: str, tmp_path: Path) -> None:
    files = [tmp_path / f'cam.{kind}' for kind in ('csv', 'svg', 'dxf')]
    run('cam', own_cam, '--reach', 1.5, '--csv', files[0], '--svg', files[1], '--dxf', files[2])
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


def test_what_cannot_be_drawn_is_refused(own_cam: str, tmp_path: Path) -> None:
    assert '--reach = 3.0 rad' in run('cam', own_cam, '--reach', 3, code=2)
    file = tmp_path / 'never.csv'
    thick = ('cam', own_cam, '--thread', 90, '--reach', 0.5, '--csv', file)
    assert 'Use a thinner thread' in run(*thick, code=2)
    assert not file.exists()
