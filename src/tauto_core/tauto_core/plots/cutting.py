"""The cam of a scene for the workshop: its cheeks, or the plate that carries both.

Points are CSV, a drawing is DXF or SVG to scale. A plate is also a paper template, or the solids
of `plots.solids`. All files are in millimetres. Cheeks may be cut back by half the thread.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, cast
from xml.sax.saxutils import escape

import numpy as np

from tauto_core.curves.cam import Cam, Setting
from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.curves.cams.linear import Involute
from tauto_core.curves.drawing import (
    MM_PER_M,
    TOOL_MM,
    ArcPath,
    Cheek,
    Circle,
    Plate,
    PlateRates,
    cam_plate,
    cheek,
    cheeks_meet_rad,
    lever_cheek,
    plate_rates,
    too_small,
)
from tauto_core.curves.fluid import coordinates, fluid_outline, radius_of_curvature
from tauto_core.curves.lever_geometry import MirroredLever
from tauto_core.files import check_place, write_output
from tauto_core.machines import FluidPendulum, LeverMachine, compile_machine
from tauto_core.plots.machine import cam_extent
from tauto_core.scene.errors import Argument, UsageError
from tauto_core.wording import significant

if TYPE_CHECKING:
    from tauto_core.samples import FloatArray
    from tauto_core.scene import Scene

FEWEST_POINTS, MOST_POINTS = 2, 1_000_000
THICKEST_MM = 100.0
DRAWN = ('csv', 'svg', 'dxf')
ENDINGS = {**{kind: f'.{kind}' for kind in DRAWN}, 'template': '.svg', 'step': '.step'}
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
        scene: the scene.
        x_m, y_m: point, across and along the thread at rest, (n,) [m].
        radius_of_curvature_m: radius of curvature, (n,) [m].
        angle_rad: angle of the wheel at which the thread leaves the point, (n,) [rad].
        lever_arm_m: lever arm at that angle, (n,) [m].
        arc_m: arc of a curve in a fluid from its lowest point, (n,) [m].
        slope: sine of its inclination, (n,).
        files: the files written.
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
    plate: ScenePlate | None = None
    too_small: str = ''

    def __repr__(self) -> str:
        return f'<CamOutline of {self.scene.name}: {len(self.x_m)} points>'

    def _repr_html_(self) -> str:
        from tauto_core.plots.notebook import cam_html

        if self.reach_rad is None:
            return f'<p>{escape(repr(self))}</p>'
        return cam_html(self.scene, len(self.x_m), self.reach_rad, float(self.lever_arm_m[-1]))

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
        left_out = {'keys_left_out': list(self.keys_left_out), 'too_small': self.too_small}
        if self.plate is not None:
            return self.plate.facts() | left_out
        ends = ('reach_rad', 'acts_from_rad', 'meeting_rad')
        return {
            'scene': self.scene.name,
            **left_out,
            **{name: getattr(self, name) for name in ends},
            **{name: column.tolist() for name, column in self.columns().items()},
        }


def check_cut(
    files: Mapping[str, Path], sizes: Mapping[str, float], is_plate: bool, points: int
) -> None:
    """Check the arguments before a scene is read.

    UsageError: a wrong ending, a place without write access, a size of a plate without a plate,
    too few or too many points, or a thread too thick for any cam.
    """
    thread_mm = sizes.get('thread_mm', 0.0)
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
    if is_plate:
        return
    for name, size in sizes.items():
        if name not in ('thread_mm', 'tool_mm'):
            raise UsageError(
                Argument(name, f'{size:g} mm', spaced=True),
                ': is a size of a plate. Ask for one, ',
                Argument('plate', True),
                ', or leave it out',
            )
    if not 0.0 <= thread_mm <= THICKEST_MM:
        raise UsageError(
            Argument('thread_mm', thread_mm, spaced=True),
            f': must be 0 to {THICKEST_MM:g} mm. Give the thickness of the thread, or leave it '
            'out',
        )
    if thread_mm and not files:
        raise UsageError(
            Argument('thread_mm', f'{thread_mm} mm', spaced=True),
            ': counts for a cheek in a file, and the table shows a thin thread. Add ',
            *(Argument('csv'), ', ', Argument('svg'), ' or ', Argument('dxf')),
            ', or leave it out',
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
    thread_mm = plate.plate.cheek.thread if plate else sizes.get('thread_mm', 0.0)
    outline, table, drawing = (_fluid_curve if scene.trochlea is None else _cheeks)(
        scene, points, reach_rad, {**sizes, 'thread_mm': thread_mm}
    )
    written: list[Path] = []
    if plate is not None:
        drawing = plate.drawing()
        # solids first, which may be refused, before any file is written
        if 'step' in files or 'stl' in files:
            from tauto_core.plots.solids import THICKNESS_MM, write_solids

            thickness = sizes.get('thickness_mm', THICKNESS_MM)
            solids = plate.plate, scene.name, plate.setting.inertia, thickness
            written += write_solids(*solids, files.get('step'), files.get('stl'))
        if 'template' in files:
            write_template(files['template'], plate)
            written.insert(0, files['template'])
    if 'csv' in files:
        write_rows(
            files['csv'], tuple(table), zip(*map(np.ndarray.tolist, table.values()), strict=True)
        )
    if 'svg' in files:
        write_output(files['svg'], drawing.svg())
    if 'dxf' in files:
        write_output(files['dxf'], drawing.dxf(sizes.get('tolerance_mm', 1e-4) if lines else None))
    written += [files[kind] for kind in DRAWN if kind in files]
    return replace(outline, files=tuple(written), plate=plate)


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
    drawing = explained(scene.name, [Line(CURVE, x, y)], [Circle(AXLE, 0.0, 0.0, 1.0)], words)
    return outline, {'x_mm': x, 'y_mm': y}, drawing


def _cheeks(
    scene: Scene, points: int, reach_rad: float | None, sizes: Mapping[str, float]
) -> tuple[CamOutline, dict[str, FloatArray], Drawing]:
    """Return the cheeks of a scene, their points and their drawing.

    The points go from the end of the cheek for negative angles, on the right of the drawing, to
    the end of the other. A common tip is one row.
    """
    assert scene.trochlea is not None
    reach, thread_mm = cam_extent(scene) if reach_rad is None else reach_rad, sizes['thread_mm']
    hole, meeting, small = math.inf, math.inf, ''
    if scene.trochlea.cam.kind == 'lever_corrected':
        machine = compile_machine(scene)
        assert isinstance(machine, LeverMachine)
        _check_reach(reach, machine.range_rad)
        shape = cast(CorrectedLeverGeometry | MirroredLever, machine.geometry)
        ends = shape.tau_of(np.array([-1.0, 1.0]) * reach).tolist()
        right, left = (lever_cheek(shape, end, points, thread_mm / MM_PER_M) for end in ends)
        at = np.linspace(0.0, ends[1], points)
        curve = (*shape.contact(at), shape.radius_of_curvature(at))
        lever = shape.theta(at), shape.lever_arm(at)
        rate = tip = MM_PER_M * shape.base_radius
        acts = f'{right.angle[0]:.6g} and {left.angle[0]:.6g}'
        words = _lever_words(scene, shape, left)
    else:
        cam = scene.trochlea.made_cam(scene.g)
        _check_reach(reach, cam.range_rad)
        try:
            left = cheek(cam, points, reach, thread_mm / MM_PER_M)
        except UsageError as error:
            if not thread_mm:
                raise
            raise UsageError(
                Argument('thread_mm', f'{thread_mm:g} mm', spaced=True), ': ', error.message
            ) from None
        right = Cheek(-left.angle, -left.x, left.y)
        angle = np.linspace(0.0, reach, points)
        curve = (*cam.contact(angle), cam.radius_of_curvature(angle))
        lever = angle, cam.lever_arm(angle)
        rate, tip = (MM_PER_M * float(size) for size in (cam.lever_rate(0.0), cam.p(0.0)))
        hole, meeting = MM_PER_M * cam.hole_distance, cheeks_meet_rad(cam)
        small = too_small(
            tip,
            scene.trochlea.power.pull.at_rest(scene.g),
            scene.g,
            sizes.get('tool_mm', TOOL_MM),
            sizes,
        )
        acts = f'{left.angle[0]:.6g}'
        words = _cam_words(cam, float(left.angle[-1]))
    acts_from = max(abs(float(side.angle[0])) for side in (right, left))
    release = abs(scene.trochlea.release_angle)
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
        meeting_rad=meeting if left.angle[-1] > meeting else None,
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
        Line(name, MM_PER_M * side.x, MM_PER_M * side.y)
        for name, side in ((CHEEK_LEFT, left), (CHEEK_RIGHT, right))
    ]
    circles = [Circle(AXLE, 0.0, 0.0, 1.0), Circle(BASE_CIRCLE, 0.0, 0.0, rate)]
    above = max(2.0 * tip, *(float(np.max(line.y)) + _GAP_MM for line in lines))
    if math.isfinite(hole):
        circles.append(Circle(HOLE, 0.0, hole, max(0.5 * thread_mm, 0.5)))
        above = hole
    lines.append(Line(THREAD, np.zeros(2), np.array([tip, above])))
    backwards = slice(None, 0 if left.x[0] == right.x[0] else None, -1)
    table = {
        name: scale * np.concatenate([on_right[backwards], on_left])
        for name, scale, on_right, on_left in zip(
            ('x_mm', 'y_mm', 'angle_rad'),
            (MM_PER_M, MM_PER_M, 1.0),
            (right.x, right.y, right.angle),
            (left.x, left.y, left.angle),
            strict=True,
        )
    }
    return outline, table, explained(scene.name, lines, circles, words)


def _check_reach(reach_rad: float, range_rad: float) -> None:
    if not 0.0 < reach_rad <= range_rad:
        raise UsageError(
            Argument('reach_rad', f'{reach_rad!r} rad', spaced=True),
            f': must be > 0 and within the range of the cam, {range_rad!r} rad. Leave it out for '
            'the default',
        )


def _cam_words(cam: Cam, reach_rad: float) -> list[str]:
    """Return the dimensions of a cam with equal cheeks, one line each."""
    name = 'base radius' if isinstance(cam, Involute) else 'lever arm a radian, at rest'
    reach = f'{reach_rad:.6g} rad'
    rate, widest, wound = (
        f'{MM_PER_M * float(length):.6g} mm'
        for length in (cam.lever_rate(0.0), cam.lever_arm(reach_rad), cam.arc_length(reach_rad))
    )
    is_endless, is_upright = math.isinf(cam.range_rad), math.isinf(cam.hole_distance)
    return [
        f'{name} {rate}, lever arm at {reach}: {widest}',
        f'range of the cam {"without end" if is_endless else f"{cam.range_rad:.6g} rad"}, '
        f'drawn up to {reach}',
        f'length of thread wound at {reach}: {wound}',
        'thread vertical'
        if is_upright
        else f'thread through a hole {MM_PER_M * cam.hole_distance:.6g} mm from the axle',
    ]


def _lever_words(
    scene: Scene, shape: CorrectedLeverGeometry | MirroredLever, left: Cheek
) -> list[str]:
    """Return the dimensions of a lever's cam, one line each."""
    assert scene.trochlea is not None
    arc = getattr(scene.trochlea.thread, 'arc', None) is not None
    place = (
        'point of the arc touched by the thread at rest, of'
        if arc
        else 'end B of the thread at rest, AB'
    )
    on_right = ', on the right' if shape.side < 0.0 else ''
    return [
        f'base radius {MM_PER_M * shape.base_radius:.6g} mm, drawn to {left.angle[-1]:.6g} rad',
        f'fulcrum level with the {place} {MM_PER_M * shape.arm:.6g} mm{on_right}, '
        f'free thread {MM_PER_M * shape.length:.6g} mm',
    ]


# -----------------------------------------------------------------------------
# A drawing to scale in millimetres, with its dimensions.

TEXT_MM, TEXT_OF_WIDTH = 2.5, 0.014
"""Least height of letters [mm], and its share of the width of a wide drawing."""

LETTER, LINE = 0.62, 1.6
"""Largest width of a letter, and distance of lines, over the height of letters."""

CHEEK_LEFT, CHEEK_RIGHT, CURVE = 'CHEEK_LEFT', 'CHEEK_RIGHT', 'CURVE'
THREAD, AXLE, BASE_CIRCLE, HOLE = 'THREAD', 'AXLE', 'BASE_CIRCLE', 'HOLE'
CUT = (CHEEK_LEFT, CHEEK_RIGHT, CURVE, 'PLATE', 'BORE', 'PIN')
"""Layers to cut. TOOL is the path of a cutter, and all others are information."""

VIEW_MM, VIEW_SCALES = 75.0, (5, 10, 20, 50, 100)
"""Largest side of an enlarged view [mm], and its scales, for drawings up to 15 mm."""

_GAP_MM, _MARGIN_MM = 4.0, 5.0
_BARS_MM = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)
_BLUE = '#1f77b4'


class Line(NamedTuple):
    """A line [mm], an open polyline or a closed path of arcs (`ArcPath`)."""

    layer: str
    x: FloatArray
    y: FloatArray
    bulge: FloatArray | None = None

    def svg(self) -> str:
        """Return the data of an SVG path, with y downwards."""
        parts = [f'M{self.x[0]:.6f} {-self.y[0]:.6f}']
        is_closed = self.bulge is not None
        bulges = np.zeros(len(self.x) - 1) if self.bulge is None else self.bulge
        targets = [np.roll(part, -1)[: len(bulges)] for part in (self.x, self.y)]
        chords = np.hypot(targets[0] - self.x[: len(bulges)], targets[1] - self.y[: len(bulges)])
        for x, y, chord, bulge in zip(*targets, chords, bulges, strict=True):
            if bulge == 0.0:
                parts.append(f'L{x:.6f} {-y:.6f}')
                continue
            radius = 0.25 * chord * (1.0 / abs(bulge) + abs(bulge))
            # arcs turn by at most half a turn. With y downwards a left turn is SVG's flag 0
            parts.append(f'A{radius:.6f} {radius:.6f} 0 0 {int(bulge < 0.0)} {x:.6f} {-y:.6f}')
        return ''.join(parts) + 'Z' * is_closed


@dataclass(frozen=True)
class Drawing:
    """A drawing in the wheel's frame [mm]: origin at the axle, +y along the thread at rest.

    Attributes:
        title: title of the drawing.
        lines: lines, those to cut first.
        circles: axle, base circle and holes.
        notes: dimensions in words, as wide as the drawing or 75 mm, with the beginnings (x, y) of
            their base lines.
        text_mm: height of letters.
    """

    title: str
    lines: Sequence[Line]
    circles: Sequence[Circle]
    notes: Sequence[tuple[float, float, str]] = ()
    text_mm: float = TEXT_MM

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, bottom, right and top of the drawing without the length of the text [mm]."""
        points = [
            (line.x, line.y)
            if line.bulge is None
            else ArcPath(line.x, line.y, line.bulge).polygon(1e-3)
            for line in self.lines
        ]
        points += [
            (
                np.array([c.x - c.radius, c.x + c.radius]),
                np.array([c.y - c.radius, c.y + c.radius]),
            )
            for c in self.circles
        ]
        x, y = (np.concatenate(part) for part in zip(*points, strict=True))
        low = min([float(np.min(y)), *(y for _, y, _ in self.notes)])
        return float(np.min(x)), low, float(np.max(x)), float(np.max(y))

    def shapes(self, pen: float = 1.0) -> str:
        """Return lines and circles as SVG, y downwards, thinner if they are not cut."""

        def style(layer: str) -> str:
            colour, width = ('black', 0.18) if layer in CUT else (_BLUE, 0.11)
            return f'fill="none" stroke="{colour}" stroke-width="{pen * width:.4g}"'

        lines = [f'<path id="{a.layer}" {style(a.layer)} d="{a.svg()}"/>' for a in self.lines]
        return '\n'.join(lines) + ''.join(
            f'\n<circle class="{hole.layer}" {style(hole.layer)} cx="{hole.x:.6f}" '
            f'cy="{-hole.y:.6f}" r="{hole.radius:.6f}"/>'
            for hole in self.circles
        )

    def enlarged(self, across: float, above: float) -> tuple[str, float, float]:
        """Return a small drawing enlarged, as SVG, with its width and height [mm].

        Its left upper corner is at (across, above), y upwards. It is empty for a drawing that is
        not small. A DXF leaves it out, since a cutter would follow it.
        """
        drawing = Drawing(self.title, [a for a in self.lines if a.layer != 'SCALE'], self.circles)
        left, low, right, top = drawing.box
        scale = VIEW_MM // max(right - left, top - low)
        scale = max((ratio for ratio in VIEW_SCALES if ratio <= scale), default=0)
        if not scale:
            return '', 0.0, 0.0
        shapes = re.sub(
            r' id="\w+"|class="\w+" ', '', drawing.shapes(self.text_mm / TEXT_MM / scale)
        )
        text = f'<text x="{across:.4f}" y="{-above:.4f}">enlarged {scale} : 1</text>'
        place = across - scale * left, -above + scale * top + LINE * self.text_mm
        return (
            f'<g font-family="sans-serif" font-size="{self.text_mm:.4g}">{text}</g>\n<g '
            f'transform="translate({place[0]:.4f} {place[1]:.4f}) scale({scale})">'
            f'{shapes.replace("black", _BLUE)}</g>',
            scale * (right - left),
            scale * (top - low) + LINE * self.text_mm,
        )

    def svg(self) -> bytes:
        """Return the drawing as SVG to scale, with a small one enlarged on the right."""
        left, low, right, top = self.box
        ends = (x + LETTER * self.text_mm * len(text) for x, _, text in self.notes)
        right = max(right, *ends)
        view, across, down = self.enlarged(right + _GAP_MM, top)
        right, low = (right + _GAP_MM + across, min(low, top - down)) if view else (right, low)
        width = right - left + 2.0 * _MARGIN_MM
        height = top - low + 2.0 * _MARGIN_MM
        texts = [
            f'<text x="{x:.4f}" y="{-y:.4f}">{escape(text)}</text>' for x, y, text in self.notes
        ]
        words = '\n'.join(texts)
        font = f'font-family="sans-serif" font-size="{self.text_mm:.4g}"'
        shapes = self.shapes(self.text_mm / TEXT_MM)
        body = f'{shapes}\n<g {font} xml:space="preserve">\n{words}\n</g>{view}'
        box = left - _MARGIN_MM, -top - _MARGIN_MM, width, height
        return svg_document(self.title, box, body)

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
        layers = [line.layer for line in self.lines] + [hole.layer for hole in self.circles]
        for layer in dict.fromkeys(layers):
            document.layers.add(layer, color=7 if layer in CUT else 1 if layer == 'TOOL' else 5)
        document.layers.add('NOTES', color=5)
        space = document.modelspace()
        # a circle is a path of two arcs
        sides, round_trip = np.array([-1.0, 1.0]), np.ones(2)
        rings = (
            Line(a.layer, a.x + a.radius * sides, np.full(2, a.y), round_trip)
            for a in (self.circles if sagitta else ())
        )
        for line in (*self.lines, *rings):
            bulge = np.zeros_like(line.x) if line.bulge is None else line.bulge
            close, attributes = line.bulge is not None, {'layer': line.layer}
            if sagitta is None:
                points = np.column_stack([line.x, line.y, bulge]).tolist()
                space.add_lwpolyline(points, 'xyb', close=close, dxfattribs=attributes)
            else:
                x, y = ArcPath(line.x, line.y, bulge).polygon(sagitta) if close else line[1:3]
                points = np.column_stack([x, y]).tolist()
                space.add_polyline2d(points, close=close, dxfattribs=attributes)
        for ring in self.circles if sagitta is None else ():
            space.add_circle((ring.x, ring.y), ring.radius, dxfattribs={'layer': ring.layer})
        for *place, text in self.notes:
            note = space.add_text(text, height=self.text_mm, dxfattribs={'layer': 'NOTES'})
            note.set_placement(place)
        for kind in sorted(document.entitydb.dxf_types_in_use()):  # ezdxf's own order is by hash
            document.classes.add_class(kind)
        written = StringIO()
        document.write(written)
        return document.encode(written.getvalue())


def explained(
    title: str, lines: Sequence[Line], circles: Sequence[Circle], dimensions: Sequence[str]
) -> Drawing:
    """Return a drawing with a scale bar, and its dimensions in words below."""
    left, low, right, _ = Drawing(title, lines, circles).box
    width = right - left
    text_mm = max(TEXT_MM, TEXT_OF_WIDTH * width)
    bar = max((size for size in _BARS_MM if size <= 0.5 * width), default=_BARS_MM[0])
    place = low - _GAP_MM
    ticks = np.array([1.0, -1.0, 0.0, 0.0, 1.0, -1.0]) * text_mm / TEXT_MM
    along = np.array([0.0, 0.0, 0.0, bar, bar, bar])
    # the text next to a small cam is 75 mm wide
    letters = int(max(width, 75.0) / (LETTER * text_mm))
    words = [
        line
        for text in (f'{bar:g} mm', title, *dimensions)
        for line in textwrap.wrap(text, letters, subsequent_indent='  ', break_on_hyphens=False)
    ]
    notes = [(left, place - LINE * text_mm * (n + 1.25), text) for n, text in enumerate(words)]
    scale = Line('SCALE', left + along, place + ticks)
    return Drawing(title, (*lines, scale), circles, notes, text_mm)


def svg_document(title: str, box: tuple[float, float, float, float], body: str) -> bytes:
    """Return an SVG to scale of a box: left, top, width and height [mm]."""
    left, top, width, height = (f'{size:.6g}' for size in box)
    return f"""<?xml version="1.0"?>
<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" \
viewBox="{left} {top} {width} {height}">
<title>{escape(title)}</title>
<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="white"/>
{body}
</svg>
""".encode()


def write_rows(path: Path, header: Sequence[str], rows: Iterable[Sequence[float]]) -> None:
    """Write numbers in full under a header."""
    lines = [','.join(header), *(','.join(map(repr, row)) for row in rows)]
    write_output(path, ('\n'.join(lines) + '\n').encode())


# -----------------------------------------------------------------------------
# The plate of a scene's cam, and its cost in rate.


@dataclass(frozen=True)
class ScenePlate:
    """The plate of a scene, its cam, and its cost in rate.

    Attributes:
        name: name of the scene.
        plate: the plate.
        cam: the cam.
        setting: the machine of the cam.
        rates: the effect of the plate on the rate of free swings on land.
    """

    name: str
    plate: Plate
    cam: Cam
    setting: Setting
    rates: PlateRates

    def words(self, *, tool: bool = True) -> list[str]:
        """Return the dimensions and costs in words, a line each, with the tool if drawn."""
        plate, holes = self.plate, self.plate.holes
        small = 0.2 if 0.2 in self.rates.amplitude_rad else float(self.rates.amplitude_rad[0])
        at = int(np.argmin(np.abs(self.rates.amplitude_rad - small)))
        edge, outline, deep = (
            significant(float(cost[at]), 2, signed=True)
            for cost in (self.rates.edge, self.rates.outline, self.rates.one_micrometre)
        )
        words = [
            'millimetres, 1:1. Origin: the axle, +y: the thread at rest',
            f'thread {plate.cheek.thread:g} mm in a slot {plate.slot:.4g} mm wide. The cheeks act '
            f'from {plate.acts_from_rad:.4g} to {plate.reach_rad:.4g} rad',
            f'bore {2.0 * holes[0].radius:g} mm, two pin holes {2.0 * holes[1].radius:g} mm at '
            f'({holes[1].x:.5g}, {holes[1].y:.5g}) and ({holes[2].x:.5g}, {holes[2].y:.5g})',
            f'{len(plate.cheek.radius)} arcs a cheek, within {plate.tolerance:g} mm',
            f'rounded cusp: {edge} s/day at {small:g} rad, with the arcs {outline} s/day',
            f'both cheeks cut a micrometre too deep: {deep} s/day at {small:g} rad',
        ]
        if tool and plate.tool is not None:
            words.append(
                f'TOOL: centre of a cutter of {plate.cutter:g} mm, outside the plate, inside the '
                'holes'
            )
        return words

    def drawing(self) -> Drawing:
        """Return the plate and the path of a cutter as a drawing."""
        plate = self.plate
        lines = [Line('PLATE', *plate.outline)]
        lines += [Line('TOOL', *plate.tool)] if plate.tool is not None else []
        return explained(self.name, lines, (*plate.holes, *plate.tool_holes), self.words())

    def facts(self) -> dict[str, object]:
        """Return dimensions and costs for JSON."""
        plate, rates = self.plate, self.rates
        costs = (rates.amplitude_rad, rates.edge, rates.outline, rates.one_micrometre)
        columns = [cost.tolist() for cost in costs]
        return {
            'scene': self.name,
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
                {
                    'amplitude_rad': amplitude,
                    'rounded_cusp_s_per_day': edge,
                    'as_drawn_s_per_day': outline,
                    'micrometre_too_deep_s_per_day': deep,
                }
                for amplitude, edge, outline, deep in zip(*columns, strict=True)
            ],
        }


def plate_of(
    scene: Scene, reach_rad: float | None = None, sizes: Mapping[str, float] | None = None
) -> ScenePlate:
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
    reach = cam_extent(scene) if reach_rad is None else reach_rad
    _check_reach(reach, cam.range_rad)
    lengths = {**PLATE_SIZES, **(sizes or {})}
    for of_others in ('thickness_mm', 'tool_mm'):
        lengths.pop(of_others, None)
    plate = cam_plate(cam, reach, **lengths)
    angles = {*AMPLITUDES, abs(trochlea.release_angle)}
    swings = np.array(sorted(a for a in angles if plate.acts_from_rad < a <= reach) or [reach])
    setting = trochlea.thread.setting(trochlea.parts(scene.g))
    return ScenePlate(scene.name, plate, cam, setting, plate_rates(plate, cam, setting, swings))


# -----------------------------------------------------------------------------
# The paper template, on one sheet.

PAPER_MM = (210.0, 297.0)
MARGIN_MM = 15.0
CHECK_MM = 100.0
# Space for the words at the foot of the template, and letters in a line of 3.2 mm.
_WORDS_MM, _LINE_MM = 90.0, 5.0
_LETTERS = 88


def write_template(path: Path, made: ScenePlate) -> None:
    """Write a plate to scale on a sheet of A4, with a line to check the print.

    It replaces an existing file. UsageError: a plate larger than the sheet.
    """
    plate = made.plate
    x, y = plate.outline.polygon(1e-3)
    size = width, height = float(np.ptp(x)), float(np.ptp(y))
    room = (PAPER_MM[0] - 2.0 * MARGIN_MM, PAPER_MM[1] - 2.0 * MARGIN_MM - _WORDS_MM)
    if any(length > limit for length, limit in zip(size, room, strict=True)):
        raise UsageError(
            Argument('template', path, spaced=True),
            f': the plate of {width:.4g} × {height:.4g} mm is larger than the {room[0]:g} × '
            f'{room[1]:g} mm of a sheet of A4. Print the drawing to scale, ',
            Argument('svg'),
            ', in parts, or give a smaller ',
            Argument('reach_rad'),
        )
    # y points down on paper. The thread at rest begins outside the plate
    shapes = Drawing(made.name, [Line('PLATE', *plate.outline)], plate.holes)
    view = shapes.enlarged(0.5 * PAPER_MM[0] - MARGIN_MM, -2.0 * MARGIN_MM)[0]
    share = 0.25 if view else 0.5
    across = share * PAPER_MM[0] - 0.5 * float(np.max(x) + np.min(x))
    down = MARGIN_MM + 0.5 * (room[1] + float(np.max(y) + np.min(y)))
    crosses = ''.join(
        f'<path d="M{hole.x - arm:.4f} {-hole.y:.4f}h{2.0 * arm:.4f}'
        f'M{hole.x:.4f} {-hole.y - arm:.4f}v{2.0 * arm:.4f}"/>\n'
        for hole in plate.holes
        for arm in [1.6 * hole.radius]
    )
    ruler = PAPER_MM[1] - MARGIN_MM - _WORDS_MM + 14.0
    words = [
        line
        for text in made.words(tool=False)
        for line in textwrap.wrap(text, _LETTERS, subsequent_indent='  ')
    ]
    hint = 'Print at 100 %. The arrow points along the thread at rest.'
    texts = [(ruler + 16.0 + _LINE_MM * row, line) for row, line in enumerate(words)]
    lines = '\n'.join(
        f'<text x="{MARGIN_MM}" y="{at}">{escape(line)}</text>'
        for at, line in [(MARGIN_MM + 10.0, hint), *texts]
    )
    begin = 0.5 * (PAPER_MM[0] - CHECK_MM)
    ticks = ''.join(
        f'M{begin + at} {ruler}v{-4 if at % 50 == 0 else -2.5 if at % 10 == 0 else -1.5}'
        for at in range(0, int(CHECK_MM) + 1, 5)
    )
    heading = f'{made.name}: the plate of the cam, 1:1'
    page = f"""<g font-family="sans-serif" font-size="3.2" fill="black">
<text x="{MARGIN_MM}" y="{MARGIN_MM + 4.0}" font-size="5">{escape(heading)}</text>
<text x="{0.5 * PAPER_MM[0]}" y="{ruler + 6.0}" text-anchor="middle">{CHECK_MM:g} mm: measure \
this line before cutting</text>
{lines}
</g>
<g fill="none" stroke="black" stroke-width="0.15">
<path id="CHECK" d="M{begin} {ruler}h{CHECK_MM:g}"/>
<path d="{ticks}"/>
<g transform="translate({across:.6f} {down:.6f})">
{shapes.shapes()}
<g stroke="{_BLUE}" stroke-width="0.1">
{crosses}<path d="M0 {-float(np.max(y)) - 3.0:.4f}v-8m-1.2 2.4l1.2 -2.4l1.2 2.4"/>
</g>
</g>
</g>{view}"""
    write_output(path, svg_document(heading, (0.0, 0.0, *PAPER_MM), page))
