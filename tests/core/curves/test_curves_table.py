"""Tabulated cams: the spline, and refused tables."""

import math
import re

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from tauto_core.curves import Table, load_table
from tauto_core.curves.cams.table import TableCam
from tauto_core.machines.powers import ForcePower
from tauto_core.machines.sections import Trochlea
from tauto_core.machines.threads import HoleThread, VerticalThread
from tauto_core.scene.errors import SceneError


def write(path, angles, arms):
    rows = [f'{angle!r},{arm!r}' for angle, arm in zip(angles, arms, strict=True)]
    path.write_text('\n'.join(['angle_rad,lever_arm_m', *rows]))
    return path


def test_quintic_is_reproduced(tmp_path):
    """A quintic spline through points of an odd quintic is that quintic."""
    law = Polynomial([0.0, 0.01, 0.0, 0.001, 0.0, -0.0001])
    angles = np.array([0.0, 0.1, 0.35, 0.5, 0.9, 1.2, 1.3, 1.8, 2.0])
    cam = load_table(write(tmp_path / 'cam.csv', angles.tolist(), law(angles).tolist()))
    angle = np.linspace(0.0, 2.0, 41)
    np.testing.assert_allclose(cam.lever_arm(angle), law(angle), rtol=1e-13)
    np.testing.assert_allclose(cam.lever_rate(angle), law.deriv()(angle), rtol=1e-11)
    np.testing.assert_allclose(cam.lever_curvature(angle), law.deriv(2)(angle), atol=1e-12)
    np.testing.assert_allclose(cam.lift(angle), law.integ()(angle), rtol=1e-13)
    np.testing.assert_array_equal(cam.lever_arm(-angle[1:]), -cam.lever_arm(angle[1:]))
    assert (cam.range_rad, cam.kinked, cam.linear_rate) == (2.0, False, None)


GOOD = ['angle_rad,lever_arm_m', '0,0', '0.1,1', '0.2,2', '0.3,3', '0.4,4', '0.5,5']


def changed(line, text):
    return [*GOOD[: line - 1], text, *GOOD[line:]]


REFUSED = {
    'infinite': (changed(5, '0.3,inf'), 'line 5, lever_arm_m', "'inf'"),
    'few': (GOOD[:-1], 'number of rows', '5'),
    'start': (changed(2, '0.01,0'), 'line 2', '0.01'),
    'negative': (changed(2, '-0.1,-1'), 'line 2', 'mirror image'),
    'down': (changed(5, '0.15,3'), 'line 5, angle_rad', 'greater than the angle before'),
    'arm': (changed(5, '0.3,0'), 'line 5, lever_arm_m', '> 0'),
}


@pytest.mark.parametrize(('lines', 'key', 'text'), REFUSED.values(), ids=REFUSED.keys())
def test_refused(tmp_path, lines, key, text):
    path = tmp_path / 'bad.csv'
    path.write_text('\n'.join(lines))
    with pytest.raises(SceneError) as caught:
        load_table(path, distance=6.0)
    assert caught.value.file == str(path)
    assert caught.value.key.startswith(key)
    assert text in str(caught.value)
    assert caught.value.exit_code == 2


def trochlea(cam, thread):
    return Trochlea(
        inertia=1e-4, cam=cam, thread=thread, power=ForcePower(force=1.0), release_angle=0.1
    )


@pytest.mark.parametrize(
    ('thread', 'distance'), [(VerticalThread(), math.inf), (HoleThread(distance=0.08), 0.08)]
)
def test_a_table_is_the_cam_of_a_scene(thread, distance, tmp_path):
    table = TableCam(path=str(write(tmp_path / 'cam.csv', range(7), [k / 100 for k in range(7)])))
    cam = trochlea(table, thread).made_cam(9.81)
    assert isinstance(cam, Table)
    assert (cam.range_rad, cam.distance) == (6.0, distance)


@pytest.mark.parametrize(
    ('law', 'hollow'),
    [
        # R = t + t'' is −0.2 (ϑ + ϑ³) and 0.4 ϑ − 0.1 ϑ³
        (Polynomial([0.0, 1.0, 0.0, -0.2]), (0.0, 2.0)),
        (Polynomial([0.0, 1.0, 0.0, -0.1]), (2.0, 2.5)),
    ],
    ids=['from the tip', 'from 2 rad'],
)
def test_a_table_that_no_thread_can_wrap(law, hollow, tmp_path):
    angles = np.linspace(0.0, hollow[1], 26)
    file = write(tmp_path / 'cam.csv', angles.tolist(), (0.01 * law(angles)).tolist())
    table = trochlea(TableCam(path=str(file)), VerticalThread())
    begin, end = hollow
    with pytest.raises(SceneError, match='a thread bridges a hollow') as caught:
        table.made_cam(9.81)
    said = re.search(r'hollow from ([\d.]+) to ([\d.]+) rad', str(caught.value))
    np.testing.assert_allclose([float(x) for x in said.groups()], [begin, end], atol=1e-5)
    assert ('End the cam before 2' in str(caught.value)) == (begin > 0.0)
    if begin:
        few = angles < begin
        write(file, angles[few].tolist(), (0.01 * law(angles[few])).tolist())
        assert table.made_cam(9.81).range_rad == angles[few][-1]


@pytest.mark.parametrize(
    ('arm', 'distance', 'message'),
    [(1e-7, 1.0, 'does not drive the wheel back'), (0.1, 0.4, 'longer than the hole is away')],
    ids=['dips', 'too long'],
)
def test_a_spline_that_leaves_its_limits_between_the_rows(arm, distance, message, tmp_path):
    arms = [0.0, arm, 0.2, 0.3, 0.4, 0.5]
    file = write(tmp_path / 'cam.csv', [0.1 * k for k in range(6)], arms)
    with pytest.raises(SceneError, match=message):
        trochlea(TableCam(path=str(file)), HoleThread(distance=distance)).made_cam(9.81)
