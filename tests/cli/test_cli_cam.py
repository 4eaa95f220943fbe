"""The files of `tauto cam`, of cheeks and of the plate: read by other programs, and measured."""

from __future__ import annotations

import csv
import json
import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, refused, run
from ezdxf import bbox
from ezdxf import path as dxf_path
from ezdxf.filemanagement import readfile

from tauto_core.samples import FloatArray
from tauto_core.scene import load_scene

TOY = ('cam', 'measured', '--plate', '--set', 'trochlea.cam.base_radius=0.002')


def rows(path: Path) -> np.ndarray:
    read = csv.DictReader(path.read_text(encoding='utf-8').splitlines())
    return np.array([[float(row[key]) for key in ('x_mm', 'y_mm', 'angle_rad')] for row in read])


@pytest.mark.parametrize(
    ('name', 'thread'), [('involute_weight_at_sea', '0.4'), ('ideal', '0'), ('ideal', '0.4')]
)
def test_dxf_and_svg_hold_the_points_in_millimetres(
    name: str, thread: str, tmp_path: Path
) -> None:
    dxf, points, svg, again = (tmp_path / f'cam.{kind}' for kind in ('dxf', 'csv', 'svg', '2.svg'))
    asked = ('cam', name, '--thread', thread, '--points', '60')
    run(*asked, '--dxf', dxf, '--csv', points, '--svg', svg)
    document = readfile(dxf)
    assert document.units == 4  # millimetres, DXF reference of INSUNITS
    assert not document.audit().errors
    space, table = document.modelspace(), rows(points)
    left, right = (
        np.array(space.query(f'LWPOLYLINE[layer=="CHEEK_{side}"]').first.get_points('xy'))
        for side in ('LEFT', 'RIGHT')
    )
    np.testing.assert_allclose(left, table[-60:, :2], atol=1e-9)
    np.testing.assert_allclose(right, table[:60, :2][::-1], atol=1e-9)
    np.testing.assert_array_equal(table[::-1] * [-1.0, 1.0, -1.0], table)
    assert np.all(np.diff(table[:, 2]) >= 0.0)
    layers = {entity.dxf.layer for entity in space}
    assert layers >= {'THREAD', 'AXLE', 'BASE_CIRCLE', 'SCALE', 'NOTES'}
    assert ('HOLE' in layers) == (name == 'ideal')
    # the SVG holds millimetres to six decimals, y downwards, the same each time
    root = ET.parse(svg).getroot()
    assert root.attrib['width'].endswith('mm')
    path = root.find('.//{*}path[@class="CHEEK_LEFT"]').attrib['d']
    drawn = np.array(re.findall(r'-?[\d.]+', path), float).reshape(-1, 2) * [1.0, -1.0]
    np.testing.assert_allclose(drawn, left, atol=1e-6)
    run(*asked, '--svg', again)
    assert again.read_bytes() == svg.read_bytes()


def test_dxf_of_an_involute_against_its_equation(tmp_path: Path) -> None:
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


@pytest.mark.parametrize('name', ['measured', 'globe_in_oil'])
def test_a_drawing_fills_its_page_and_is_legible_at_800_px(name: str, tmp_path: Path) -> None:
    """No caption is wider than the cam, or 75 mm, and letters stay 9 pixels high."""
    svg, dxf = tmp_path / 'cam.svg', tmp_path / 'cam.dxf'
    run('cam', name, '--svg', svg, '--dxf', dxf)
    space = readfile(dxf).modelspace()
    cut = bbox.extents(space.query('LWPOLYLINE'))
    width = float(re.search(r'width="([\d.]+)mm"', svg.read_text(encoding='utf-8'))[1])
    assert width <= max(cut.size.x, 75.0) + 10.001
    heights = [text.dxf.height for text in space.query('TEXT')]
    assert min(heights) * 800.0 / width >= 9.0


def test_a_corrected_cam_is_drawn_where_it_does_not_sweep_away(tmp_path: Path) -> None:
    points, cam = tmp_path / 'cam.csv', 'trochlea.cam={kind: weight_corrected, period: 1.0}'
    light = ('involute_weight_at_sea', '--set', cam, '--set', 'trochlea.power.mass=0.02')
    run('cam', *light, '--csv', points)
    # up to t = λ = √(I/m), not to the edge with an arm a thousand times longer
    assert np.abs(rows(points)[:, :2]).max() < 10e3 * math.sqrt(4e-4 / 0.02)


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


@pytest.mark.parametrize('name', ['measured', 'ideal'])
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
    turned = psi - np.arcsin(arm / (1e3 * cam.distance))
    wrong = arm - 1e3 * cam.lever_arm(np.maximum(turned, 0.0))
    acts = angle > facts['acts_from_rad']
    assert np.max(np.abs(wrong[acts])) < 1.5 * facts['tolerance_mm']
    # before the cheeks act the edge holds the thread r θ₀³/6 away, and no more
    assert 0.0 < np.max(wrong[~acts]) < 1e-3
    # with the flattening a nanometre low at worst, 0.055 s/day at 0.2 rad
    for row in facts['rates'] if name == 'measured' else ():
        measured = rate_s_per_day(turned, wrong, 5.0, row['amplitude_rad'])
        limit = 0.012 / row['amplitude_rad']
        assert measured == pytest.approx(row['as_drawn_s_per_day'], abs=limit)


def test_the_path_of_the_cutter_and_the_holes_are_in_the_dxf(tmp_path: Path) -> None:
    file = tmp_path / 'plate.dxf'
    holes = ('--bore', '2', '--pins', '1', '--pin-circle', '3.2')
    run('cam', '--plate', 'measured', '--dxf', file, *holes)
    space = readfile(file).modelspace()
    circles = {
        layer: [(c.dxf.center.x, c.dxf.center.y, c.dxf.radius) for c in space.query(query)]
        for layer in ('BORE', 'PIN', 'TOOL')
        for query in [f'CIRCLE[layer=="{layer}"]']
    }
    assert circles['BORE'] == [(0.0, 0.0, 1.0)]
    assert [math.hypot(x, y) for x, y, _ in circles['PIN']] == pytest.approx([3.2, 3.2])
    assert sorted(radius for _, _, radius in circles['TOOL']) == [0.375, 0.375, 0.875]
    # a cross at the centre of each hole, for a punch
    crosses = [bbox.extents([each]) for each in space.query('LWPOLYLINE[layer=="CENTRE"]')]
    assert [(c.center.x, c.center.y) for c in crosses] == [
        pytest.approx(hole[:2], abs=1e-12) for hole in (*circles['BORE'], *circles['PIN'])
    ]
    areas = []
    for layer in ('TOOL', 'PLATE'):
        (edge,) = space.query(f'LWPOLYLINE[layer=="{layer}"]')
        points = np.array([(p.x, p.y) for p in dxf_path.make_path(edge).flattening(1e-5)])
        steps = np.roll(points, -1, axis=0) - points
        area = 0.5 * np.sum(points[:, 0] * steps[:, 1] - points[:, 1] * steps[:, 0])
        areas.append((float(area), float(np.sum(np.hypot(*steps.T)))))
    # Steiner: a parallel curve at d encloses L d + π d² more, once round
    (outside, _), (inside, length) = areas
    assert outside - inside == pytest.approx(length * 0.125 + math.pi * 0.125**2, rel=1e-4)


def test_the_arcs_of_the_svg_are_those_of_the_dxf(tmp_path: Path) -> None:
    svg, dxf = tmp_path / 'plate.svg', tmp_path / 'plate.dxf'
    run('cam', '--plate', 'ideal', '--svg', svg, '--dxf', dxf)
    path = ET.parse(svg).getroot().find('.//{*}path[@class="PLATE"]').attrib['d']
    (outline,) = readfile(dxf).modelspace().query('LWPOLYLINE[layer=="PLATE"]')
    corners = np.array(outline.get_points('xy'))
    ends = re.findall(r'(?:M|L|A\S+ \S+ 0 [01] [01] )(-?[\d.]+) (-?[\d.]+)', path)
    np.testing.assert_allclose(np.array(ends, float)[:-1] * [1.0, -1.0], corners, atol=1e-6)
    # the sagitta of an arc of SVG is the bulge of DXF times half the chord
    arcs = re.findall(r'[ML]|A(\S+) (\S+) 0 0 ([01])', path)[1:]
    chords = np.hypot(*(np.roll(corners, -1, axis=0) - corners).T)
    bulges = [bulge for (bulge,) in outline.get_points('b')]
    for (radius, _, flag), chord, bulge in zip(arcs, chords, bulges, strict=True):
        assert bool(radius) == (bulge != 0.0)
        if radius:
            half, r = 0.5 * chord, float(radius)
            sagitta = r - math.sqrt(max(r * r - half * half, 0.0))
            assert sagitta == pytest.approx(half * abs(bulge), abs=2e-3)
            assert flag == str(int(bulge < 0.0))


def test_a_dxf_of_lines_has_corners_on_the_arcs(tmp_path: Path) -> None:
    """R12 without arcs and bulges.

    The Bézier curves by which ezdxf flattens arcs are off by 2.7e-4 of a radius, of 0.15 mm.
    """
    for name, more in (('arcs', ()), ('lines', ('--lines',))):
        run(*TOY, '--thread', '0.3', '--dxf', tmp_path / f'{name}.dxf', *more)
    arcs, document = (readfile(tmp_path / f'{name}.dxf') for name in ('arcs', 'lines'))
    assert document.dxfversion == 'AC1009'
    assert not document.audit().errors
    assert {each.dxftype() for each in document.modelspace()} == {'POLYLINE', 'TEXT'}
    (edge,) = arcs.modelspace().query('LWPOLYLINE[layer=="PLATE"]')
    near = np.array([(p.x, p.y) for p in dxf_path.make_path(edge).flattening(1e-6)])
    (lines,) = document.modelspace().query('POLYLINE[layer=="PLATE"]')
    assert lines.is_closed
    assert not lines.has_arc
    near = near[np.any(near != np.roll(near, -1, axis=0), axis=1)]
    ends = np.roll(near, -1, axis=0) - near
    for point in np.array([(v.x, v.y) for v in lines.points()])[::7]:
        share = np.clip(np.sum((point - near) * ends, 1) / np.sum(ends**2, 1), 0.0, 1.0)
        assert np.min(np.hypot(*(near + share[:, None] * ends - point).T)) < 5e-5


def test_a_small_cam_is_also_drawn_enlarged_with_its_scale(tmp_path: Path) -> None:
    """A plate of some 8 mm ten times, of which no line is black, and one of 40 mm not at all."""
    small, large = tmp_path / 'small.svg', tmp_path / 'large.svg'
    run(*TOY, '--thread', '0.3', '--svg', small)
    run('cam', 'ideal', '--plate', '--svg', large)
    text = small.read_text('utf-8')
    assert 'enlarged 10 : 1' in text
    (view,) = re.findall(r'scale\(10\)">(.*)</g>', text, re.DOTALL)
    assert view.count('class="PIN"') == 2
    assert not re.search('black|SCALE', view)
    assert 'enlarged' not in large.read_text('utf-8')


def test_parts_too_small_for_a_tool_are_named_with_a_remedy() -> None:
    """A bore of half and pins of 0.3 cusps: a tool of 1 mm needs a cusp at 3.33 mm."""
    result = invoke(*TOY)
    words = 'the cusp is 2 mm from the axle, and a tool of 1 mm makes no pin holes of 0.6 mm.'
    assert words in result.stderr
    found = re.findall(r'pull of (\S+) N, a weight of (\S+) g, puts it at (\S+) mm', result.stderr)
    pull, weight, puts = map(float, found[0])
    assert weight == pytest.approx(1e3 * pull / 9.80665, rel=5e-3)
    design = ['design', '--period', '1', '--inertia', '1e-4', '--json', '--pull']
    before, after = (
        json.loads(run(*design, str(each)))
        for each in (1e-4 * math.tau**2 / 0.002, 1e-4 * math.tau**2 / (1e-3 * puts))
    )
    assert words in before['too_small']
    assert after['too_small'] == ''
    assert 3.333 < puts < 3.333 / 0.88
    assert json.loads(run(*TOY, '--tool', '0.6', '--json'))['too_small'] == ''


@pytest.mark.parametrize('thread', [2.0, 1.35])
def test_a_thread_too_thick_for_its_cusp_is_refused(thread: float) -> None:
    result = invoke(*TOY, '--thread', str(thread))
    assert result.exit_code == 2
    told = re.match(
        r'tauto: --thread = \S+ mm: the slot for it leaves no room for a bore of 1 mm within a '
        r'cusp 2 mm from the axle. Use a thread of at most (\S+) mm',
        result.stderr.splitlines()[-1],
    )
    assert told
    run(*TOY, '--thread', told[1])


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (('measured', '--lines'), '--lines: needs --dxf. Give both'),
        (('globe_in_oil',), 'scene = globe_in_oil: has no pair of mirror-image cheeks'),
        (('clock_own_cam_lever',), 'has no pair of mirror-image cheeks'),
        (('measured', '--cutter', '1'), '--cutter = 1 mm: the cutter'),
        (('measured', '--pin-circle', '9'), 'Give another place: --pins, --pin-circle'),
        (('measured', '--slot', '4'), ' mm. Give a smaller hole: --bore, --slot'),
        (('measured', '--reach', '-1'), '--reach = -1.0 rad: must be > 0'),
        (('measured', '--tool', '-1'), '--tool = -1.0: must be > 0 mm'),
        (('measured', '--dxf', 'plate.svg'), '--dxf plate.svg: must end in .dxf'),
        (('measured', '--template', 'a.svg'), '--template: is no longer written. Use --svg'),
    ],
)
def test_refusals_name_the_option(arguments: tuple[str, ...], words: str) -> None:
    assert words in refused('cam', '--plate', *arguments)


def test_the_figures_are_printed() -> None:
    said = run('cam', '--plate', 'measured')
    assert 'rounded cusp: +0.018 s/day at 0.2 rad' in said
    assert '64 arcs a cheek, within 1e-05 mm' in said
