"""The files of `tauto cam`: read again and measured."""

from __future__ import annotations

import csv
import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from ezdxf import bbox
from ezdxf.filemanagement import readfile
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.curves import CircularArc, Involute, SpringCorrected, cheek
from tauto_core.scene.errors import UsageError

SCENE = """
duration: 60.0
trochlea:
  inertia: 4.0e-4
  cam: {kind: weight_corrected, period: 1.0}
  thread: {kind: THREAD}
  power: {kind: weight, mass: 0.2}
  release_angle: 1.0
"""
NAMES = ('involute_weight_at_sea', 'ideal', 'cheek_before_euler', 'corrected')


def run(*arguments: str | Path) -> str:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.stderr
    return result.stdout


@pytest.fixture
def scene(tmp_path: Path):
    def path(name: str) -> str:
        if name != 'corrected':
            return name
        file = tmp_path / 'corrected.yaml'
        file.write_text(SCENE.replace('THREAD', 'hole, distance: 0.08'))
        return str(file)

    return path


def rows(path: Path) -> np.ndarray:
    read = csv.DictReader(path.read_text(encoding='utf-8').splitlines())
    return np.array([[float(row[key]) for key in ('x_mm', 'y_mm', 'angle_rad')] for row in read])


@pytest.mark.parametrize('thread', ['0', '0.4'])
@pytest.mark.parametrize('name', NAMES)
def test_dxf_holds_the_points_in_millimetres(name, thread, scene, tmp_path):
    dxf, points = tmp_path / 'cam.dxf', tmp_path / 'cam.csv'
    run('cam', scene(name), '--dxf', dxf, '--csv', points, '--thread', thread, '--points', '60')
    document = readfile(dxf)
    assert document.units == 4  # millimetres, DXF reference of INSUNITS
    space, table = document.modelspace(), rows(points)
    left = np.array(space.query('LWPOLYLINE[layer=="CHEEK_LEFT"]').first.get_points('xy'))
    right = np.array(space.query('LWPOLYLINE[layer=="CHEEK_RIGHT"]').first.get_points('xy'))
    np.testing.assert_allclose(left, table[-60:, :2], atol=1e-9)
    np.testing.assert_allclose(right, table[:60, :2][::-1], atol=1e-9)
    np.testing.assert_array_equal(table[::-1] * [-1.0, 1.0, -1.0], table)
    assert np.all(np.diff(table[:, 2]) >= 0.0)
    layers = {entity.dxf.layer for entity in space}
    assert layers >= {'THREAD', 'AXLE', 'BASE_CIRCLE', 'SCALE', 'NOTES'}
    assert ('HOLE' in layers) == (name in ('ideal', 'corrected'))
    thread_line = space.query('LWPOLYLINE[layer=="THREAD"]').first.get_points('xy')
    assert [x for x, _ in thread_line] == [0.0, 0.0]
    assert not document.audit().errors


def test_dxf_of_an_involute_against_its_equation(tmp_path):
    """Polar: a point at distance ρ of a base circle r belongs to the angle √(ρ²/r² − 1)."""
    dxf = tmp_path / 'cam.dxf'
    run('cam', 'involute_weight_at_sea', '--dxf', dxf, '--reach', '3')
    space = readfile(dxf).modelspace()
    (circle,) = space.query('CIRCLE[layer=="BASE_CIRCLE"]')
    assert circle.dxf.radius == 5.0
    left = np.array(space.query('LWPOLYLINE[layer=="CHEEK_LEFT"]').first.get_points('xy'))
    z = np.sqrt(np.maximum(np.hypot(*left.T) ** 2 / 25.0 - 1.0, 0.0))
    assert z[-1] == pytest.approx(3.0, rel=1e-12)
    turned = np.unwrap(np.arctan2(-left[:, 0], left[:, 1]))
    np.testing.assert_allclose(5.0 * turned, 5.0 * (z - np.arctan(z)), atol=1e-9)
    scale = bbox.extents(space.query('LWPOLYLINE[layer=="SCALE"]'))
    words = [text.dxf.text for text in space.query('TEXT')]
    assert words[0] == f'{scale.size.x:g} mm'
    assert 'base radius 5 mm' in ' '.join(words)
    assert 'up to 3 rad' in ' '.join(map(str.strip, words))


@pytest.mark.parametrize('name', ['measured', 'clock_own_cam_lever', 'globe_in_oil'])
def test_a_drawing_fills_its_page_and_is_legible_at_800_px(name, tmp_path):
    """No caption is wider than the cam, or 75 mm, and letters stay 9 pixels high in the README."""
    svg, dxf = tmp_path / 'cam.svg', tmp_path / 'cam.dxf'
    run('cam', name, '--svg', svg, '--dxf', dxf)
    space = readfile(dxf).modelspace()
    cut = bbox.extents(space.query('LWPOLYLINE'))
    width = float(re.search(r'width="([\d.]+)mm"', svg.read_text(encoding='utf-8'))[1])
    assert width <= max(cut.size.x, 75.0) + 10.001
    heights = [text.dxf.height for text in space.query('TEXT')]
    assert min(heights) * 800.0 / width >= 9.0


def test_thick_thread_runs_on_a_parallel_curve(scene, tmp_path):
    """Its centre line, half a thickness outside the cheek, is the thin thread's curve."""
    thin, thick = tmp_path / 'thin.csv', tmp_path / 'thick.csv'
    run('cam', scene('corrected'), '--csv', thin, '--reach', '3', '--points', '4000')
    run('cam', scene('corrected'), '--csv', thick, '--reach', '3', '--thread', '0.8')
    curve, cut = rows(thin), rows(thick)
    assert len(cut) == 400
    cut = cut[cut[:, 2] > 0.05]
    gaps = [np.min(np.hypot(*(curve[:, :2] - row[:2]).T)) for row in cut[::20]]
    # the curve is a polyline of 4000 points
    np.testing.assert_allclose(gaps, 0.4, rtol=5e-4)


def test_thick_thread_on_an_involute_begins_it_later():
    cut = cheek(Involute(0.005), 50, 2.0, 0.5e-3)
    assert cut.angle[0] == pytest.approx(0.05, rel=1e-12)
    # involutes of one circle are parallel: shifted by half a thickness of arc
    radius = np.hypot(cut.x, cut.y)
    np.testing.assert_allclose(radius, 0.005 * np.hypot(1.0, cut.angle - 0.05), rtol=1e-12)
    arc = cheek(CircularArc(0.02, 0.01), 20, None, 1e-3)
    assert arc.angle[0] == 0.0
    np.testing.assert_allclose(np.hypot(arc.x + 0.02, arc.y - 0.01), 0.0195, rtol=1e-13)


@pytest.mark.parametrize('name', NAMES)
def test_svg_is_to_scale_and_the_same_each_time(name, scene, tmp_path):
    files = [tmp_path / f'{i}.svg' for i in range(2)]
    for file in files:
        run('cam', scene(name), '--svg', file, '--csv', tmp_path / 'cam.csv', '--reach', '1')
    assert files[0].read_bytes() == files[1].read_bytes()
    root = ET.parse(files[0]).getroot()
    space = {'svg': 'http://www.w3.org/2000/svg'}
    found = {}
    for layer in ('CHEEK_LEFT', 'CHEEK_RIGHT', 'THREAD', 'SCALE'):
        path = root.find(f".//svg:path[@id='{layer}']", space).attrib['d']
        numbers = np.array(re.findall(r'-?[\d.]+', path), float).reshape(-1, 2)
        found[layer] = np.ptp(numbers, axis=0)
    table = rows(tmp_path / 'cam.csv')
    half = table[len(table) // 2 :, :2]
    # the file holds millimetres to six decimals
    np.testing.assert_allclose(found['CHEEK_LEFT'], np.ptp(half, axis=0), atol=1.1e-6)
    np.testing.assert_allclose(found['CHEEK_RIGHT'], found['CHEEK_LEFT'], atol=1.1e-6)
    assert found['SCALE'][0] in (1.0, 2.0, 5.0, 10.0, 20.0) or found['SCALE'][0] == pytest.approx(
        round(found['SCALE'][0]), abs=1e-5
    )
    for side in ('width', 'height'):
        assert root.attrib[side].endswith('mm')


def test_the_remedy_of_a_thread_that_does_not_fit_works():
    cam = Involute(0.01)
    assert cheek(cam, 10, 7.0, 0.5e-3).angle[-1] == 7.0
    with pytest.raises(UsageError, match='nowhere as round'):
        cheek(CircularArc(0.02, 0.01), thread_thickness=0.05)
    hollow = SpringCorrected(0.01, 200.0)
    with pytest.raises(UsageError, match='hollow from its tip'):
        cheek(hollow)


def test_a_corrected_cam_is_drawn_where_it_does_not_sweep_away(tmp_path):
    file, points = tmp_path / 'vertical.yaml', tmp_path / 'cam.csv'
    file.write_text(SCENE.replace('THREAD', 'vertical').replace('mass: 0.2', 'mass: 0.02'))
    run('cam', file, '--csv', points)
    # up to t = λ = √(I/m), not to the edge with an arm a thousand times longer
    assert np.abs(rows(points)[:, :2]).max() < 10e3 * math.sqrt(4e-4 / 0.02)
