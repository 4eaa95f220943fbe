"""The cam of a scene for the workshop: its cheeks, or the plate that carries both.

Points are CSV, a drawing is DXF or SVG to scale, the solids of a plate are in `plots.solids`. All
files are in millimetres. Cheeks may be cut back by half the thread.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

import numpy as np

from tauto_core.curves.cam import Cam
from tauto_core.curves.cams.linear import Involute
from tauto_core.curves.drawing import (
    MM_PER_M,
    TOOL_MM,
    ArcPath,
    Circle,
    Plate,
    cam_plate,
    cheeks_meet_rad,
    plate_rates,
    polyline,
    too_small,
)
from tauto_core.curves.fluid import coordinates, fluid_outline, radius_of_curvature
from tauto_core.files import check_place, write_output
from tauto_core.machines import FluidPendulum, compile_machine
from tauto_core.plots.machine import both_cheeks, cam_extent, cam_shape
from tauto_core.scene.errors import Argument, UsageError
from tauto_core.wording import significant

if TYPE_CHECKING:
    from tauto_core.samples import FloatArray
    from tauto_core.scene import Scene

FEWEST_POINTS, MOST_POINTS = 2, 1_000_000
ENDINGS = {'csv': '.csv', 'svg': '.svg', 'dxf': '.dxf', 'step': '.step'}
"""Endings of the files of a cam. An STL is a folder."""

PLATE_SIZES = {'thread_mm': 0.5, 'cutter_mm': 0.25, 'tolerance_mm': 1e-5}
"""Default thread, cutter (the wire of a spark eroder) and tolerance."""

AMPLITUDES = (0.1, 0.2, 0.5, 1.0)
"""Amplitudes for the costs of a plate [rad], in addition to the release angle."""


@dataclass(frozen=True, eq=False, repr=False)
class CamOutline:
    """The curve of a scene's cam, with its files and plate.

    The points belong to the cheek for positive angles, in the wheel's frame with its origin at the
    axle. A curve in a fluid has the branch of descent from its lowest point on, +y upwards,
    without angles and lever arms.

    Attributes:
        x_m, y_m: point, across and along the thread at rest, (n,) [m].
        radius_of_curvature_m: radius of curvature, (n,) [m].
        angle_rad: angle of the wheel at which the thread leaves the point, (n,) [rad].
        lever_arm_m: lever arm at that angle, (n,) [m].
        arc_m, slope: arc of a curve in a fluid [m], and sine of its inclination there, (n,).
        reach_rad: angle of the wheel at which the cheeks end [rad], None for a curve in a fluid.
        acts_from_rad: least angle with the thread on the cheeks [rad], for a given thickness.
        meeting_rad: angle at which the cheeks cross [rad], if they do. One plate ends there.
        plate: the plate and its cost in rate, on request.
        too_small: warning about holes of a plate (`curves.drawing.too_small`).
    """

    scene: Scene
    x_m: FloatArray
    y_m: FloatArray
    radius_of_curvature_m: FloatArray
    angle_rad: FloatArray = field(default_factory=lambda: np.empty(0))
    lever_arm_m: FloatArray = field(default_factory=lambda: np.empty(0))
    arc_m: FloatArray = field(default_factory=lambda: np.empty(0))
    slope: FloatArray = field(default_factory=lambda: np.empty(0))
    files: tuple[Path, ...] = ()
    reach_rad: float | None = None
    acts_from_rad: float | None = None
    meeting_rad: float | None = None
    plate: Plate | None = None
    too_small: str = ''

    def __repr__(self) -> str:
        return f'<CamOutline of {self.scene.name}: {len(self.x_m)} points>'

    @property
    def keys_left_out(self) -> tuple[str, ...]:
        """Sections of the scene that do not affect the cam, which is at `trochlea.at_celsius`."""
        return self.scene.sections_besides()

    def columns(self) -> dict[str, FloatArray]:
        """Return the points by column, lengths in millimetres."""
        of_cam = {'angle_rad': self.angle_rad, 'lever_arm_mm': MM_PER_M * self.lever_arm_m}
        of_fluid = {'arc_mm': MM_PER_M * self.arc_m, 'slope': self.slope}
        return (of_fluid if self.reach_rad is None else of_cam) | {
            'x_mm': MM_PER_M * self.x_m,
            'y_mm': MM_PER_M * self.y_m,
            'radius_of_curvature_mm': MM_PER_M * self.radius_of_curvature_m,
        }

    def facts(self) -> dict[str, object]:
        """Return points and ends for JSON, or the dimensions and costs of a plate."""
        plate, name = self.plate, {'scene': self.scene.name}
        left_out = {'keys_left_out': list(self.keys_left_out), 'too_small': self.too_small}
        if plate is None:
            ends = ('reach_rad', 'acts_from_rad', 'meeting_rad')
            columns = {name: column.tolist() for name, column in self.columns().items()}
            return name | left_out | {end: getattr(self, end) for end in ends} | columns
        assert plate.rates is not None
        costs = ('rounded_cusp', 'as_drawn', 'micrometre_too_deep')
        names = ['amplitude_rad', *(f'{cost}_s_per_day' for cost in costs)]
        sizes = {
            'thread_mm': plate.cheek.thread,
            'slot_mm': plate.slot,
            'cutter_mm': plate.cutter,
            'tolerance_mm': plate.tolerance,
            'arcs_a_cheek': len(plate.cheek.radius),
            'reach_rad': plate.reach_rad,
            'acts_from_rad': plate.acts_from_rad,
            'bore_mm': 2.0 * plate.holes[0].radius,
            'pins_mm': 2.0 * plate.holes[1].radius,
            'pins_at_mm': [[hole.x, hole.y] for hole in plate.holes[1:]],
            'rates': [
                dict(zip(names, row, strict=True)) for row in np.transpose(plate.rates).tolist()
            ],
        }
        return name | sizes | left_out


def check_cut(
    files: Mapping[str, Path], sizes: Mapping[str, float], is_plate: bool, points: int
) -> None:
    """Check the arguments before a scene is read.

    UsageError: a wrong ending, a place without write access, a size of a plate without a plate,
    too few or too many points, or a negative thread.
    """
    for name, ending in ENDINGS.items():
        if name in files:
            if files[name].suffix.lower() not in ('', ending):
                raise UsageError(
                    Argument(name, files[name]), f': must end in {ending}. Name another file'
                )
            check_place(files[name], name)
    if 'step' in files or 'stl' in files:
        from tauto_core.plots.solids import THICKNESS_MM, check_solids

        check_solids(sizes.get('thickness_mm', THICKNESS_MM))
    if not FEWEST_POINTS <= points <= MOST_POINTS:
        raise UsageError(
            Argument('points', points, spaced=True),
            f': must be {FEWEST_POINTS} to {MOST_POINTS} on each cheek. Leave it out for the '
            'default',
        )
    for name, size in sizes.items():
        if not is_plate and name not in ('thread_mm', 'tool_mm'):
            raise UsageError(
                Argument(name, f'{size:g} mm', spaced=True),
                ': is a size of a plate. Ask for one, ',
                Argument('plate', True),
                ', or leave it out',
            )
    if not 0.0 <= sizes.get('thread_mm', 0.0) < math.inf:
        raise UsageError(
            Argument('thread_mm', sizes['thread_mm'], spaced=True),
            ': must be ≥ 0 mm. Give the thickness of the thread, or leave it out',
        )


def outline_of(
    scene: Scene,
    files: Mapping[str, Path],
    sizes: Mapping[str, float],
    is_plate: bool,
    points: int,
    reach_rad: float | None,
    *,
    lines: bool = False,
) -> CamOutline:
    """Return a scene's cam, or its curve in a fluid, and write or replace its files.

    Args:
        scene: the scene, after `check_cut` of the other arguments.
        files: paths by the argument of `tauto.cam`.
        sizes: thickness of the thread and sizes of a plate [mm], by name.
        is_plate: whether to make a plate.
        points: points on each cheek or branch.
        reach_rad: end of the cheeks [rad], within the cam, by default `cam_extent`.
        lines: whether a DXF has chords in place of arcs.

    Raises:
        UsageError: see `plate_of`, a reach beyond the cam, a thread that it cannot guide, or
            either of these for a curve in a fluid.
        SceneError: a cam or curve that cannot be built.
        OutputError: a file that cannot be written.
    """
    plate = plate_of(scene, reach_rad, sizes) if is_plate else None
    thread_mm = plate.cheek.thread if plate else sizes.get('thread_mm', 0.0)
    outline, table, drawing = (_fluid_curve if scene.trochlea is None else _cheeks)(
        scene, points, reach_rad, {**sizes, 'thread_mm': thread_mm}
    )
    written: list[Path] = []
    if plate is not None:
        # a cross at the centre of each hole, as one line
        arms = 1.6 * np.array([[-1.0, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, -1.0]])
        centres = [
            polyline('CENTRE', hole.x + hole.radius * arms[0], hole.y + hole.radius * arms[1])
            for hole in plate.holes
        ]
        tool = () if plate.tool is None else (plate.tool,)
        drawing = Drawing(
            scene.name,
            (plate.outline, *tool, *centres),
            (*plate.holes, *plate.tool_holes),
            plate_words(plate),
        )
        # solids first, which may be refused, before any file is written
        if 'step' in files or 'stl' in files:
            from tauto_core.plots.solids import THICKNESS_MM, write_solids

            assert scene.trochlea is not None
            written += write_solids(
                plate,
                scene.name,
                scene.trochlea.parts(scene.g).inertia,
                sizes.get('thickness_mm', THICKNESS_MM),
                files.get('step'),
                files.get('stl'),
            )
    rows = np.column_stack(list(table.values())).tolist()
    text = '\n'.join([','.join(table), *(','.join(map(repr, row)) for row in rows), ''])
    contents: dict[str, Callable[[], bytes]] = {
        'csv': text.encode,
        'svg': drawing.svg,
        'dxf': lambda: drawing.dxf(sizes.get('tolerance_mm', 1e-4) if lines else None),
    }
    for kind, content in contents.items():
        if kind in files:
            write_output(files[kind], content())
            written.append(files[kind])
    return replace(outline, files=tuple(written), plate=plate)


def plate_of(
    scene: Scene, reach_rad: float | None = None, sizes: Mapping[str, float] | None = None
) -> Plate:
    """Return the plate of a scene's cam, and its cost in rate on land.

    The sizes of `cam_plate` [mm] default to `PLATE_SIZES`, the reach [rad] to `cam_extent`.
    UsageError: see `cam_plate`, or a scene without a pair of mirror-image cheeks. SceneError: a
    cam that cannot be built.
    """
    trochlea = scene.trochlea
    if trochlea is None or trochlea.cam.kind == 'lever_corrected':
        raise UsageError(
            Argument('scene', scene.name, spaced=True),
            ': has no pair of mirror-image cheeks for a plate. Other curves are drawn without ',
            Argument('plate', True),
        )
    cam = trochlea.made_cam(scene.g)
    reach = _checked_reach(scene, reach_rad, cam.range_rad)
    lengths = {**PLATE_SIZES, **(sizes or {})}
    for of_others in ('thickness_mm', 'tool_mm'):
        lengths.pop(of_others, None)
    plate = cam_plate(cam, reach, **lengths)
    angles = {*AMPLITUDES, abs(trochlea.release_angle)}
    swings = np.array(sorted(a for a in angles if plate.acts_from_rad < a <= reach) or [reach])
    setting = trochlea.thread.setting(trochlea.parts(scene.g))
    return replace(plate, rates=plate_rates(plate, cam, setting, swings))


def plate_words(plate: Plate) -> list[str]:
    """Return the dimensions and costs of a plate in words, a line each."""
    assert plate.rates is not None
    holes, swings = plate.holes, plate.rates.amplitude_rad.tolist()
    at = swings.index(0.2) if 0.2 in swings else 0
    _, edge, outline, deep = (significant(float(x[at]), 2, signed=True) for x in plate.rates)
    words = [
        'millimetres, 1:1. Origin: the axle, +y: the thread at rest',
        f'thread {plate.cheek.thread:g} mm in a slot {plate.slot:.4g} mm wide. The cheeks act '
        f'from {plate.acts_from_rad:.4g} to {plate.reach_rad:.4g} rad',
        f'bore {2.0 * holes[0].radius:g} mm, two pin holes {2.0 * holes[1].radius:g} mm at '
        f'({holes[1].x:.5g}, {holes[1].y:.5g}) and ({holes[2].x:.5g}, {holes[2].y:.5g})',
        f'{len(plate.cheek.radius)} arcs a cheek, within {plate.tolerance:g} mm',
        f'rounded cusp: {edge} s/day at {swings[at]:g} rad, with the arcs {outline} s/day',
        f'both cheeks cut a micrometre too deep: {deep} s/day at {swings[at]:g} rad',
    ]
    if plate.tool is not None:
        words.append(
            f'TOOL: centre of a cutter of {plate.cutter:g} mm, outside the plate, inside the holes'
        )
    return words


def _checked_reach(scene: Scene, reach_rad: float | None, range_rad: float) -> float:
    """Return the given end of the cheeks within the range of the cam, or `cam_extent`."""
    reach = cam_extent(scene) if reach_rad is None else reach_rad
    if not 0.0 < reach <= range_rad:
        raise UsageError(
            Argument('reach_rad', f'{reach!r} rad', spaced=True),
            f': must be > 0 and within the range of the cam, {range_rad!r} rad. Leave it out for '
            'the default',
        )
    return reach


def _fluid_curve(
    scene: Scene, points: int, reach_rad: float | None, sizes: Mapping[str, float]
) -> tuple[CamOutline, dict[str, FloatArray], Drawing]:
    """Return the curve of a scene in a fluid, its points and its drawing."""
    machine = compile_machine(scene)
    if reach_rad is not None or sizes['thread_mm'] or not isinstance(machine, FluidPendulum):
        raise UsageError(
            Argument('thread_mm', f'{sizes["thread_mm"]} mm', spaced=True)
            if reach_rad is None
            else Argument('reach_rad', f'{reach_rad!r} rad', spaced=True),
            ': belongs to a cam, and this scene has a curve in a fluid, which is drawn to its '
            'cusps. Leave it out',
        )
    curve = machine.curve
    arc = np.linspace(0.0, curve.descent_cusp, points)
    height, level = coordinates(curve, arc)
    radius = radius_of_curvature(curve, arc)
    outline = CamOutline(scene, level, height, radius, arc_m=arc, slope=curve.slope(arc))
    x, y = (MM_PER_M * part for part in fluid_outline(curve, points))
    ascent = curve.ascent_cusp
    words = [
        'millimetres, 1:1. Origin: the lowest point, +y upwards. Descents begin on the right',
        f'pendulum in vacuum {MM_PER_M * curve.pendulum_length:.6g} mm, kappa {curve.kappa:.6g} '
        f'1/m, gamma {curve.gamma:.6g}',
        f'arc of descent to its cusp {MM_PER_M * curve.descent_cusp:.6g} mm, of ascent '
        + (f'{MM_PER_M * abs(ascent):.6g} mm' if math.isfinite(ascent) else 'without end'),
    ]
    drawing = Drawing(
        scene.name, [polyline('CURVE', x, y)], [Circle('AXLE', 0.0, 0.0, 1.0)], words
    )
    return outline, {'x_mm': x, 'y_mm': y}, drawing


def _cheeks(
    scene: Scene, points: int, reach_rad: float | None, sizes: Mapping[str, float]
) -> tuple[CamOutline, dict[str, FloatArray], Drawing]:
    """Return the cheeks of a scene, their points and their drawing.

    The points go from the end of the cheek for negative angles, on the right of the drawing, to
    the end of the other. A common tip is one row.
    """
    trochlea, thread_mm = scene.trochlea, sizes['thread_mm']
    assert trochlea is not None
    hole, meeting, small = math.inf, math.inf, ''
    shape, range_rad = cam_shape(scene)
    reach = _checked_reach(scene, reach_rad, range_rad)
    try:
        right, left = both_cheeks(shape, reach, points, thread_mm / MM_PER_M)
    except UsageError as error:
        named = Argument('thread_mm', f'{thread_mm:g} mm', spaced=True)
        raise UsageError(named, ': ', error.message) from None
    end = float(left.angle[-1])
    acts = f'{left.angle[0]:.6g}'
    if not isinstance(shape, Cam):
        at = np.linspace(0.0, float(shape.tau_of(np.array([reach]))[0]), points)
        curve = (*shape.contact(at), shape.radius_of_curvature(at))
        lever = shape.theta(at), shape.lever_arm(at)
        rate = tip = MM_PER_M * shape.base_radius
        acts = f'{right.angle[0]:.6g} and {acts}'
        words = [
            f'base radius {rate:.6g} mm, drawn up to {end:.6g} rad',
            f'fulcrum {MM_PER_M * shape.arm:.6g} mm from the thread at rest, on the '
            f'{"right" if shape.side < 0.0 else "left"}, free thread '
            f'{MM_PER_M * shape.length:.6g} mm',
        ]
    else:
        cam = shape
        angle = np.linspace(0.0, reach, points)
        curve = (*cam.contact(angle), cam.radius_of_curvature(angle))
        lever = angle, cam.lever_arm(angle)
        rate, tip = (MM_PER_M * float(size) for size in (cam.lever_rate(0.0), cam.p(0.0)))
        hole, meeting = MM_PER_M * cam.distance, cheeks_meet_rad(cam)
        pull, tool = trochlea.power.pull.at_rest(scene.g), sizes.get('tool_mm', TOOL_MM)
        small = too_small(tip, pull, scene.g, tool, sizes)
        words = [
            f'{"base radius" if isinstance(cam, Involute) else "lever arm a radian, at rest"} '
            f'{rate:.6g} mm, drawn up to {end:.6g} rad',
            'thread vertical'
            if math.isinf(hole)
            else f'thread through a hole {hole:.6g} mm from the axle',
        ]
    acts_from = max(abs(float(side.angle[0])) for side in (right, left))
    release = abs(trochlea.release_angle)
    if thread_mm and acts_from >= release > 0.0:
        raise UsageError(
            Argument('thread_mm', f'{thread_mm:g} mm', spaced=True),
            f': bends round the edges of the cheeks up to {acts_from:.4g} rad, and the wheel '
            f'is released at {release:.4g} rad, short of them. Use a thinner thread',
        )
    outline = CamOutline(
        scene,
        *curve,
        *lever,
        reach_rad=reach,
        acts_from_rad=acts_from if thread_mm else None,
        meeting_rad=meeting if end > meeting else None,
        too_small=small,
    )
    words = [
        'millimetres, 1:1. Origin: the axle, +y: the thread at rest. Cut CHEEK_LEFT, CHEEK_RIGHT',
        *words,
        f'cheeks cut back by half the thread, {thread_mm:.6g} mm thick, which act from {acts} rad '
        'on'
        if thread_mm
        else 'for a thin thread, not cut back',
    ]
    lines = [
        polyline(name, MM_PER_M * side.x, MM_PER_M * side.y)
        for name, side in (('CHEEK_LEFT', left), ('CHEEK_RIGHT', right))
    ]
    circles = [Circle('AXLE', 0.0, 0.0, 1.0), Circle('BASE_CIRCLE', 0.0, 0.0, rate)]
    above = max(2.0 * tip, *(float(np.max(line.y)) + _GAP_MM for line in lines))
    if math.isfinite(hole):
        circles.append(Circle('HOLE', 0.0, hole, max(0.5 * thread_mm, 0.5)))
        above = hole
    lines.append(polyline('THREAD', np.zeros(2), np.array([tip, above])))
    backwards = slice(None, 0 if left.x[0] == right.x[0] else None, -1)
    angle, x, y = (np.concatenate([a[backwards], b]) for a, b in zip(right, left, strict=True))
    table = {'x_mm': MM_PER_M * x, 'y_mm': MM_PER_M * y, 'angle_rad': angle}
    return outline, table, Drawing(scene.name, lines, circles, words)


# -----------------------------------------------------------------------------
# A drawing to scale in millimetres, with its dimensions.

TEXT_MM, TEXT_OF_WIDTH = 2.5, 0.014
"""Least height of letters [mm], and its share of the width of a wide drawing."""

LETTER, LINE = 0.62, 1.6
"""Largest width of a letter, and distance of lines, over the height of letters."""

CUT = ('CHEEK_LEFT', 'CHEEK_RIGHT', 'CURVE', 'PLATE', 'BORE', 'PIN')
"""Layers to cut. TOOL is the path of a cutter, and all others are information."""

NARROWEST_MM = 75.0
"""Least width of the words and of the space for the scale bar."""

_GAP_MM, _MARGIN_MM = 4.0, 5.0
_BARS_MM = (50.0, 100.0, 200.0, 500.0, 1000.0)
_BLUE = '#1f77b4'

VIEW_MM, VIEW_SCALES = 75.0, (5, 10, 20, 50, 100)
"""Largest side of an enlarged view [mm], and its scales, for drawings up to 15 mm."""


class Drawing:
    """Lines and circles to scale [mm], with a scale bar, and the dimensions in words below.

    The frame is the wheel's: origin at the axle, +y along the thread at rest. The lines to cut are
    first.
    """

    def __init__(
        self,
        title: str,
        lines: Sequence[ArcPath],
        circles: Sequence[Circle],
        dimensions: Sequence[str],
    ) -> None:
        edges = [shape.polygon(1e-3) for shape in (*lines, *(ring.path for ring in circles))]
        x, y = (np.concatenate(part) for part in zip(*edges, strict=True))
        left, low, width = float(np.min(x)), float(np.min(y)), float(np.ptp(x))
        self.title, self.circles = title, circles
        self.text_mm = max(TEXT_MM, TEXT_OF_WIDTH * width)
        room = max(width, NARROWEST_MM)
        bar = max(size for size in _BARS_MM if size <= room or size == _BARS_MM[0])
        place, tick = low - _GAP_MM, self.text_mm / TEXT_MM
        ticks = np.array([1.0, -1.0, 0.0, 0.0, 1.0, -1.0]) * tick
        along = np.array([0.0, 0.0, 0.0, bar, bar, bar])
        self.lines = (*lines, polyline('SCALE', left + along, place + ticks))
        self._edges = left, -float(np.max(y)), max(width, float(np.ptp(y)))
        letters = int(room / (LETTER * self.text_mm))
        words = [
            line
            for text in (f'{bar:g} mm', title, *dimensions)
            for line in textwrap.wrap(
                text, letters, subsequent_indent='  ', break_on_hyphens=False
            )
        ]
        self.notes = [
            (left, place - LINE * self.text_mm * (n + 1.25), text) for n, text in enumerate(words)
        ]
        longest = LETTER * self.text_mm * max(map(len, words))
        # left, top, width and height, y downwards
        self.box = (
            left - _MARGIN_MM,
            -float(np.max(y)) - _MARGIN_MM,
            max(width, bar, longest) + 2.0 * _MARGIN_MM,
            float(np.max(y)) - self.notes[-1][1] + 2.0 * _MARGIN_MM,
        )

    def svg(self) -> bytes:
        """Return the drawing as SVG, y downwards, thinner where it is not cut.

        A small one is drawn on the right once more, enlarged and in blue. A DXF leaves that out,
        since a cutter would follow it.
        """
        pen = self.text_mm / TEXT_MM

        def shapes(lines: Iterable[ArcPath], cut: str, pen: float) -> str:
            def style(layer: str) -> str:
                colour, width = (cut, 0.18) if layer in CUT else (_BLUE, 0.11)
                return f'fill="none" stroke="{colour}" stroke-width="{pen * width:.4g}"'

            return '\n'.join(
                [f'<path class="{a.layer}" {style(a.layer)} d="{a.svg()}"/>' for a in lines]
                + [
                    f'<circle class="{c.layer}" {style(c.layer)} cx="{c.x:.6f}" cy="{-c.y:.6f}" '
                    f'r="{c.radius:.6f}"/>'
                    for c in self.circles
                ]
            )

        left, top, width, height = self.box
        texts, view = [*self.notes], ''
        edge, ceiling, size = self._edges
        if scale := max((ratio for ratio in VIEW_SCALES if ratio * size <= VIEW_MM), default=0):
            across = left + width
            texts.append((across, -ceiling, f'enlarged {scale} : 1'))
            at = across - scale * edge, ceiling + LINE * self.text_mm - scale * ceiling
            view = f'<g transform="translate({at[0]:.4f} {at[1]:.4f}) scale({scale})">'
            # the scale bar, the last line, is not enlarged
            view += shapes(self.lines[:-1], _BLUE, pen / scale) + '</g>'
            width += scale * size + _MARGIN_MM
            height = max(height, scale * size + LINE * self.text_mm + 2.0 * _MARGIN_MM)
        words = '\n'.join(
            f'<text x="{x:.4f}" y="{-y:.4f}">{escape(text)}</text>' for x, y, text in texts
        )
        place = f'x="{left:.6g}" y="{top:.6g}" width="{width:.6g}" height="{height:.6g}"'
        return f"""<?xml version="1.0"?>
<svg xmlns="http://www.w3.org/2000/svg" width="{width:.6g}mm" height="{height:.6g}mm" \
viewBox="{left:.6g} {top:.6g} {width:.6g} {height:.6g}">
<title>{escape(self.title)}</title>
<rect {place} fill="white"/>
{shapes(self.lines, 'black', pen)}
<g font-family="sans-serif" font-size="{self.text_mm:.4g}" xml:space="preserve">
{words}
</g>
{view}
</svg>
""".encode()

    def dxf(self, sagitta: float | None = None) -> bytes:
        """Return the drawing as DXF R2010 in millimetres, a layer for each kind of line.

        With a sagitta [mm] it is R12, with chords within it in place of arcs.
        """
        from ezdxf import options, units  # type: ignore[attr-defined]
        from ezdxf.document import Drawing as Document
        from ezdxf.filemanagement import new

        options.write_fixed_meta_data_for_testing = True  # no dates, no random GUID
        # R12 has no unit, which the notes name, and `new` would warn
        document = (
            new('R2010', setup=False, units=units.MM) if sagitta is None else Document.new('R12')
        )
        layers = [line.layer for line in self.lines] + [ring.layer for ring in self.circles]
        for layer in dict.fromkeys(layers):
            document.layers.add(layer, color=7 if layer in CUT else 1 if layer == 'TOOL' else 5)
        document.layers.add('NOTES', color=5)
        space = document.modelspace()
        for line in (*self.lines, *(ring.path for ring in self.circles if sagitta)):
            on = {'layer': line.layer}
            if sagitta is None:
                points = np.column_stack([line.x, line.y, line.bulge]).tolist()
                space.add_lwpolyline(points, 'xyb', close=line.is_closed, dxfattribs=on)
            else:
                points = np.column_stack(line.polygon(sagitta)).tolist()
                space.add_polyline2d(points, close=line.is_closed, dxfattribs=on)
        for c in () if sagitta else self.circles:
            space.add_circle((c.x, c.y), c.radius, dxfattribs={'layer': c.layer})
        for *place, text in self.notes:
            note = space.add_text(text, height=self.text_mm, dxfattribs={'layer': 'NOTES'})
            note.set_placement(place)
        for kind in sorted(document.entitydb.dxf_types_in_use()):  # ezdxf's own order is by hash
            document.classes.add_class(kind)
        written = StringIO()
        document.write(written)
        return document.encode(written.getvalue())
