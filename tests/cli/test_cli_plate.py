"""The plate of `tauto cam`: its files read by other programs, and measured."""

from __future__ import annotations

import json
import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from ezdxf import path as dxf_path
from ezdxf.filemanagement import readfile
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.samples import FloatArray
from tauto_core.scene import load_scene

SCENES = ('measured', 'ideal', 'clock_own_cam_spring')


def run(*arguments: str | Path) -> str:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.stderr
    return result.stdout


def support(x: FloatArray, y: FloatArray, psi: FloatArray) -> FloatArray:
    """Return how far a taut thread on the left of the slot is from the axle [mm].

    It comes from the slot, and its line touches the plate where that reaches farthest along the
    normal.
    """
    bottom = np.min(y[(np.abs(x) < 0.2) & (y > 0.0)])
    left = (x < 0.0) & (y > bottom + 0.25)
    points = np.stack([x[left], y[left]])
    return np.array([np.max(np.cos(a) * points[0] + np.sin(a) * points[1]) for a in psi])


def rate_s_per_day(angle: FloatArray, wrong: FloatArray, slope: float, amplitude: float) -> float:
    """Return 86400 · 2/(π t'(0) A²) ∫ δt θ dθ/√(A² − θ²), by first-order perturbation.

    It holds for a constant force and a linear lever arm.
    """
    phase = (np.arange(4000) + 0.5) * (0.5 * math.pi / 4000)
    at = amplitude * np.sin(phase)
    integral = float(np.mean(np.interp(at, angle, wrong) * at)) * 0.5 * math.pi
    return 86400.0 * 2.0 / (math.pi * slope * amplitude**2) * integral


@pytest.mark.parametrize('name', SCENES)
def test_the_lever_arm_rebuilt_from_the_dxf(name: str, tmp_path: Path) -> None:
    """ezdxf flattens the outline. Half the thread is added to how far a taut thread is away."""
    file = tmp_path / 'plate.dxf'
    facts = json.loads(run('cam', '--plate', name, '--dxf', file, '--thread', '0.5', '--json'))
    document = readfile(file)
    assert not document.audit().errors
    assert document.units == 4  # millimetres
    (outline,) = document.modelspace().query('LWPOLYLINE[layer=="PLATE"]')
    assert outline.closed
    # chords of a nanometre's sagitta, well below the tolerance of ten
    flat = dxf_path.make_path(outline).flattening(1e-6, segments=4)
    x, y, _ = np.array([tuple(point) for point in flat]).T
    scene = load_scene(name)
    assert scene.trochlea is not None
    cam = scene.trochlea.made_cam(scene.g)
    angle = np.linspace(1e-3, facts['reach_rad'] - 1e-3, 900)
    psi = cam.psi(angle)
    arm = 0.25 + support(x, y, psi)
    # through a hole, ψ − arcsin(t/a) is the angle of the wheel
    turned = psi - np.arcsin(arm / (1e3 * cam.hole_distance))
    wrong = arm - 1e3 * cam.lever_arm(np.maximum(turned, 0.0))
    acts = angle > facts['acts_from_rad']
    assert np.max(np.abs(wrong[acts])) < 1.5 * facts['tolerance_mm']
    # before the cheeks act the edge holds the thread r θ₀³/6 away, and no more
    assert 0.0 < np.max(wrong[~acts]) < 1e-3
    if name != 'measured':
        return
    # with the flattening a nanometre low at worst, 0.055 s/day at 0.2 rad
    for row in facts['rates']:
        measured = rate_s_per_day(turned, wrong, 5.0, row['amplitude_rad'])
        assert measured == pytest.approx(
            row['as_drawn_s_per_day'], abs=0.012 / row['amplitude_rad']
        )


def test_the_path_of_the_cutter_and_the_holes_are_in_the_dxf(tmp_path: Path) -> None:
    file = tmp_path / 'plate.dxf'
    run(
        'cam',
        '--plate',
        'measured',
        '--dxf',
        file,
        '--bore',
        '2',
        '--pins',
        '1',
        '--pin-circle',
        '3.2',
    )
    space = readfile(file).modelspace()
    circles = {
        layer: [(c.dxf.center.x, c.dxf.center.y, c.dxf.radius) for c in space.query(query)]
        for layer in ('BORE', 'PIN', 'TOOL')
        for query in [f'CIRCLE[layer=="{layer}"]']
    }
    assert circles['BORE'] == [(0.0, 0.0, 1.0)]
    assert [math.hypot(x, y) for x, y, _ in circles['PIN']] == pytest.approx([3.2, 3.2])
    assert sorted(radius for _, _, radius in circles['TOOL']) == [0.375, 0.375, 0.875]
    (tool,) = space.query('LWPOLYLINE[layer=="TOOL"]')
    (outline,) = space.query('LWPOLYLINE[layer=="PLATE"]')
    areas = []
    for edge in (tool, outline):
        points = np.array([(p.x, p.y) for p in dxf_path.make_path(edge).flattening(1e-5)])
        steps = np.roll(points, -1, axis=0) - points
        areas.append(
            (
                float(np.sum(points[:, 0] * steps[:, 1] - points[:, 1] * steps[:, 0])) / 2.0,
                float(np.sum(np.hypot(*steps.T))),
            )
        )
    # Steiner: a parallel curve at d encloses L d + π d² more, once round
    (outside, _), (inside, length) = areas
    assert outside - inside == pytest.approx(length * 0.125 + math.pi * 0.125**2, rel=1e-4)


def test_the_template_is_to_scale_on_a4(tmp_path: Path) -> None:
    file = tmp_path / 'paper.svg'
    run('cam', '--plate', 'ideal', '--template', file)
    root = ET.fromstring(file.read_text(encoding='utf-8'))
    assert root.attrib['width'] == '210mm'
    assert root.attrib['height'] == '297mm'
    assert root.attrib['viewBox'] == '0 0 210 297'  # a unit is a millimetre
    space = {'svg': 'http://www.w3.org/2000/svg'}
    check = root.find(".//svg:path[@id='CHECK']", space)
    assert check is not None
    assert check.attrib['d'].endswith('h100')
    drawn = root.find(".//svg:path[@id='PLATE']", space)
    assert drawn is not None
    # the width comes from the plate in the DXF, from the corners of the path
    dxf = tmp_path / 'plate.dxf'
    run('cam', '--plate', 'ideal', '--dxf', dxf)
    (outline,) = readfile(dxf).modelspace().query('LWPOLYLINE[layer=="PLATE"]')
    corners = np.array(outline.get_points('xy'))
    ends = re.findall(r'(?:M|L|A\S+ \S+ 0 [01] [01] )(-?[\d.]+) (-?[\d.]+)', drawn.attrib['d'])
    found = np.array(ends, float)[:-1] * [1.0, -1.0]
    np.testing.assert_allclose(found, corners, atol=1e-6)
    # the sagitta of an arc of SVG is the bulge of DXF times half the chord
    arcs = re.findall(r'[ML]|A(\S+) (\S+) 0 0 ([01])', drawn.attrib['d'])[1:]
    chords = np.hypot(*(np.roll(corners, -1, axis=0) - corners).T)
    for (radius, _, flag), chord, (bulge,) in zip(
        arcs, chords, outline.get_points('b'), strict=True
    ):
        if bulge == 0.0:
            assert not radius
            continue
        half, r = 0.5 * chord, float(radius)
        sagitta = r - math.sqrt(max(r * r - half * half, 0.0))
        assert sagitta == pytest.approx(half * abs(bulge), abs=2e-3)
        assert flag == str(int(bulge < 0.0))


def test_a_plate_larger_than_the_paper_is_refused(
    tmp_path: Path,
) -> None:
    paper, dxf = tmp_path / 'paper.svg', tmp_path / 'plate.dxf'
    large = ['cam', 'measured', '--set', 'trochlea.cam.base_radius=0.15']
    result = CliRunner().invoke(app, [*large, '--template', str(paper), '--dxf', str(dxf)])
    assert result.exit_code == 2
    assert 'mm is larger than the 180 × 177 mm of a sheet of A4' in result.stderr
    assert 'Print the drawing to scale, --svg, in parts' in result.stderr
    assert not list(tmp_path.iterdir())


TOY = ('cam', 'measured', '--plate', '--set', 'trochlea.cam.base_radius=0.002')


def test_a_dxf_of_lines_has_corners_on_the_arcs(tmp_path: Path) -> None:
    """R12 without arcs and bulges. The area of a ring of n chords is n/2 r² sin(2π/n).

    The Bézier curves by which ezdxf flattens arcs are off by 2.7e-4 of a radius, of 0.15 mm.
    """
    for name, more in (('arcs', ()), ('lines', ('--lines',))):
        run(*TOY, '--thread', '0.3', '--dxf', tmp_path / f'{name}.dxf', *more)
    arcs, document = (readfile(tmp_path / f'{name}.dxf') for name in ('arcs', 'lines'))
    assert document.dxfversion == 'AC1009'
    assert not document.audit().errors
    kinds = {each.dxftype() for each in document.modelspace()}
    assert kinds == {'POLYLINE', 'TEXT'}
    for layer in ('PLATE', 'TOOL'):
        (edge,) = arcs.modelspace().query(f'LWPOLYLINE[layer=="{layer}"]')
        near = np.array([(p.x, p.y) for p in dxf_path.make_path(edge).flattening(1e-6)])
        lines = document.modelspace().query(f'POLYLINE[layer=="{layer}"]')
        assert all(each.is_closed and not each.has_arc for each in lines)
        points = np.array([(v.x, v.y) for v in lines[0].points()])
        near = near[np.any(near != np.roll(near, -1, axis=0), axis=1)]
        ends = np.roll(near, -1, axis=0) - near
        for point in points[::7]:
            share = np.clip(np.sum((point - near) * ends, 1) / np.sum(ends**2, 1), 0.0, 1.0)
            assert np.min(np.hypot(*(near + share[:, None] * ends - point).T)) < 5e-5
    (bore,) = document.modelspace().query('POLYLINE[layer=="BORE"]')
    x, y = np.array([(v.x, v.y) for v in bore.points()]).T
    count, area = len(x), 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
    assert area == pytest.approx(0.5 * count * 0.25 * math.sin(math.tau / count), rel=1e-9)
    # the sagitta r (1 − cos(π/n)) of half a radius
    assert 0.5 * (1.0 - math.cos(math.pi / count)) < 1e-4


def test_a_small_cam_is_also_drawn_enlarged_with_its_scale(tmp_path: Path) -> None:
    """A plate of some 8 mm ten times, of which no line is black, and one of 40 mm not at all."""
    small, large = tmp_path / 'small.svg', tmp_path / 'large.svg'
    run(*TOY, '--thread', '0.3', '--svg', small, '--template', tmp_path / 'paper.svg')
    run('cam', 'ideal', '--plate', '--svg', large)
    for file in (small, tmp_path / 'paper.svg'):
        text = file.read_text('utf-8')
        assert 'enlarged 10 : 1' in text
        (view,) = re.findall(r'scale\(10\)">(.*)</g>', text, re.DOTALL)
        assert 'black' not in view
        assert ' id=' not in view
        assert text.count('class="BORE"') == 1
    assert 'enlarged' not in large.read_text('utf-8')


def test_parts_too_small_for_a_tool_are_named_with_a_remedy() -> None:
    """A bore of half and pins of 0.3 cusps: a tool of 1 mm needs a cusp at 3.33 mm."""
    result = CliRunner().invoke(app, [*TOY])
    words = 'the cusp is 2 mm from the axle, and a tool of 1 mm makes no pin holes of 0.6 mm.'
    assert words in result.stderr
    pull, weight, puts = map(
        float,
        re.findall(r'pull of (\S+) N, a weight of (\S+) g, puts it at (\S+) mm', result.stderr)[0],
    )
    assert weight == pytest.approx(1e3 * pull / 9.80665, rel=5e-3)
    design = ['design', '--period', '1', '--inertia', '1e-4', '--json', '--pull']
    before, after = (
        json.loads(run(*design, str(each)))
        for each in (1e-4 * math.tau**2 / 0.002, 1e-4 * math.tau**2 / (1e-3 * puts))
    )
    assert words in before['too_small']
    assert after['too_small'] == ''
    assert 3.333 < puts < 3.333 / 0.88
    assert '--tool' in run('cam', '-h')
    assert json.loads(run(*TOY, '--tool', '0.6', '--json'))['too_small'] == ''


@pytest.mark.parametrize('thread', [2.0, 1.5, 1.35])
def test_a_thread_too_thick_for_its_cusp_is_refused(thread: float) -> None:
    result = CliRunner().invoke(app, [*TOY, '--thread', str(thread)])
    assert result.exit_code == 2
    said = re.match(
        r'tauto: --thread = \S+ mm: the slot for it leaves no room for a bore of 1 mm within a '
        r'cusp 2 mm from the axle. Use a thread of at most (\S+) mm',
        result.stderr.splitlines()[-1],
    )
    assert said
    run(*TOY, '--thread', said[1])


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (('measured', '--lines'), '--lines: needs --dxf. Give both'),
        (('globe_in_oil',), 'scene = globe_in_oil: has no pair of mirror-image cheeks'),
        (('clock_own_cam_lever',), 'has no pair of mirror-image cheeks'),
        (('measured', '--cutter', '1'), '--cutter = 1 mm: the cutter'),
        (('measured', '--pin-circle', '9'), 'Give another place: --pins, --pin-circle'),
        (('measured', '--reach', '-1'), '--reach = -1.0 rad: must be > 0'),
        (('measured', '--tool', '-1'), '--tool = -1.0: must be > 0 mm'),
        (('measured', '--dxf', 'plate.svg'), '--dxf plate.svg: must end in .dxf'),
        (('measured', '--template', 'a.pdf'), '--template a.pdf: must end in .svg'),
    ],
)
def test_refusals_name_the_option(arguments: tuple[str, ...], words: str) -> None:
    result = CliRunner().invoke(app, ['cam', '--plate', *arguments])
    assert result.exit_code == 2
    assert words in result.stderr


def test_the_figures_are_printed() -> None:
    said = run('cam', '--plate', 'measured')
    assert 'rounded cusp: +0.018 s/day at 0.2 rad' in said
    assert '64 arcs a cheek, within 1e-05 mm' in said
