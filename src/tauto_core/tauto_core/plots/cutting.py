"""The curve of a scene for the workshop: points as CSV, drawings to scale as SVG and DXF.

All files are in millimetres. Cheeks may be cut back by half the thickness of the thread.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO, StringIO
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.curves.drawing import (
    CUT,
    LETTER,
    MM_PER_M,
    TEXT_MM,
    CamDrawing,
    Cheeks,
    LeverCheek,
    cheeks,
    cheeks_meet_rad,
    draw_cam,
    draw_in_fluid,
    draw_uneven,
    lever_cheek,
)
from tauto_core.curves.fluid import coordinates, fluid_outline, radius_of_curvature
from tauto_core.curves.lever_geometry import MirroredLever
from tauto_core.files import write_output
from tauto_core.machines import FluidPendulum, LeverMachine, compile_machine
from tauto_core.plots.machine import cam_extent
from tauto_core.scene.errors import Argument, UsageError

if TYPE_CHECKING:
    from tauto_core.curves import DescentCurve
    from tauto_core.samples import FloatArray
    from tauto_core.scene import Scene

MM_PER_INCH = 25.4
POINTS_PER_MM = 72.0 / MM_PER_INCH
_MARGIN_MM = 5.0
COLUMNS = ('x_mm', 'y_mm', 'angle_rad')
THICKEST_MM = 100.0
FEWEST_POINTS, MOST_POINTS = 2, 1_000_000
FORMATS = ('csv', 'svg', 'dxf')


@dataclass(frozen=True)
class CamCut:
    """The files written of a cam, or of a curve in a fluid.

    Attributes:
        files: the files.
        reach_rad: angle of the wheel at which the cheeks end [rad]; None for a curve in a fluid.
        acts_from_rad: angle from which on the thread touches the cheeks [rad], where its
            thickness was given.
        meeting_rad: angle at which the cheeks cross, where that is before they end [rad]: beyond
            it they cannot be cut from one plate.
    """

    files: tuple[Path, ...]
    reach_rad: float | None = None
    acts_from_rad: float | None = None
    meeting_rad: float | None = None


def check_cut(points: int, thread_mm: float) -> None:
    """Refuse, before a scene is read, numbers with which no cam can be cut.

    Too few or too many points, or a thread too thick for any cam, are a UsageError.
    """
    if not FEWEST_POINTS <= points <= MOST_POINTS:
        raise UsageError(
            Argument('points', points, spaced=True),
            f': must be {FEWEST_POINTS} to {MOST_POINTS} on each cheek. Give another, or leave it '
            'out',
        )
    if not 0.0 <= thread_mm <= THICKEST_MM:
        raise UsageError(
            Argument('thread_mm', thread_mm, spaced=True),
            f': must be 0 to {THICKEST_MM:g} mm. Give the thickness of the thread, or leave it '
            'out',
        )


def cut(
    scene: Scene,
    files: Mapping[str, Path],
    *,
    points: int = 200,
    reach_rad: float | None = None,
    thread_mm: float = 0.0,
) -> CamCut:
    """Write the cheeks of a scene's cam, or its curve in a fluid; replaces the files.

    The files are by format: csv, svg or dxf. Each cheek or branch has so many points, up to
    `reach_rad` within the cam (None: `cam_extent`), and is cut back by half the thickness of the
    thread. A reach beyond the cam, a thread that it cannot guide, either for a curve in a fluid,
    and what `check_cut` refuses, are a UsageError; a cam or curve that cannot be built is a
    SceneError, a file that cannot be written an OutputError.
    """
    check_cut(points, thread_mm)
    written = tuple(files.values())
    if scene.trochlea is None:
        curve = _fluid_curve(scene, reach_rad, thread_mm)
        outline = fluid_outline(curve, points)
        x, y = (MM_PER_M * part for part in outline)
        if 'csv' in files:
            rows = zip(x.tolist(), y.tolist(), strict=True)
            write_rows(files['csv'], ('x_mm', 'y_mm'), rows)
        _write_drawings(draw_in_fluid(curve, (x, y), scene.name), files)
        return CamCut(written)
    reach = cam_extent(scene) if reach_rad is None else reach_rad
    if scene.trochlea.cam.kind == 'lever_corrected':
        shape, ends = _lever_shape(scene, reach)
        right, left = (lever_cheek(shape, end, points, thread_mm / MM_PER_M) for end in ends)
        acts_from = max(abs(float(side.angle[0])) for side in (right, left))
        acts_from_rad = _checked_thread(scene, thread_mm, acts_from)
        if 'csv' in files:
            write_sides(files['csv'], left, right)
        at_left, at_right = ((MM_PER_M * side.x, MM_PER_M * side.y) for side in (left, right))
        rate = MM_PER_M * shape.base_radius
        said = _lever_words(scene, shape, left, right, thread_mm)
        _write_drawings(draw_uneven(at_left, at_right, rate, scene.name, said), files)
        return CamCut(written, reach, acts_from_rad)
    cam = scene.trochlea.made_cam(scene.g)
    _check_reach(reach, cam.range_rad)
    try:
        both = cheeks(cam, points, reach, thread_mm / MM_PER_M)
    except UsageError as error:
        if not thread_mm:
            raise
        thick = Argument('thread_mm', f'{thread_mm:g} mm', spaced=True)
        raise UsageError(thick, ': ', error.message) from None
    acts_from_rad = _checked_thread(scene, thread_mm, float(both.angle[0]))
    if 'csv' in files:
        write_points(files['csv'], both)
    _write_drawings(draw_cam(cam, both, scene.name), files)
    meeting = cheeks_meet_rad(cam)
    return CamCut(written, reach, acts_from_rad, meeting if both.angle[-1] > meeting else None)


def few_points(
    scene: Scene, reach_rad: float | None = None, thread_mm: float = 0.0
) -> dict[str, FloatArray]:
    """Return eleven points of one cheek or branch, by column; arguments as for `cut`."""
    if scene.trochlea is None:
        curve = _fluid_curve(scene, reach_rad, thread_mm)
        arc = np.linspace(0.0, curve.descent_cusp, 11)
        height, level = coordinates(curve, arc)
        first = {'arc_mm': MM_PER_M * arc, 'slope': curve.slope(arc)}
        lengths = {'x_mm': level, 'y_mm': height}
        radius = radius_of_curvature(curve, arc)
    else:
        reach = cam_extent(scene) if reach_rad is None else reach_rad
        if scene.trochlea.cam.kind == 'lever_corrected':
            shape, (_, end) = _lever_shape(scene, reach)
            at = np.linspace(0.0, end, 11)
            angle, arm, (x, y) = shape.theta(at), shape.lever_arm(at), shape.contact(at)
            radius = shape.radius_of_curvature(at)
        else:
            cam = scene.trochlea.made_cam(scene.g)
            _check_reach(reach, cam.range_rad)
            angle = np.linspace(0.0, reach, 11)
            arm, (x, y) = cam.lever_arm(angle), cam.contact(angle)
            radius = cam.radius_of_curvature(angle)
        first, lengths = {'angle_rad': angle}, {'lever_arm_mm': arm, 'x_mm': x, 'y_mm': y}
    lengths['radius_of_curvature_mm'] = radius
    return first | {name: MM_PER_M * length for name, length in lengths.items()}


def _fluid_curve(scene: Scene, reach_rad: float | None, thread_mm: float) -> DescentCurve:
    """Return the curve of a scene in a fluid; refuse options that belong to a cam."""
    machine = compile_machine(scene)
    if reach_rad is not None or thread_mm or not isinstance(machine, FluidPendulum):
        raise UsageError(
            Argument('thread_mm', f'{thread_mm} mm', spaced=True)
            if reach_rad is None
            else Argument('reach_rad', f'{reach_rad!r} rad', spaced=True),
            ': belongs to a cam, and this scene has a curve in a fluid, which is drawn to its '
            'cusps. Leave it out',
        )
    return machine.curve


def _lever_shape(
    scene: Scene, reach_rad: float
) -> tuple[CorrectedLeverGeometry | MirroredLever, list[float]]:
    """Return the shape of a lever's cam, and its parameter τ at both ends."""
    machine = compile_machine(scene)
    assert isinstance(machine, LeverMachine)
    _check_reach(reach_rad, machine.range_rad)
    shape = cast(CorrectedLeverGeometry | MirroredLever, machine.geometry)
    return shape, shape.tau_of(np.array([-1.0, 1.0]) * reach_rad).tolist()


def _check_reach(reach_rad: float, range_rad: float) -> None:
    if not 0.0 < reach_rad <= range_rad:
        raise UsageError(
            Argument('reach_rad', f'{reach_rad!r} rad', spaced=True),
            f': must be > 0 and within the range of the cam, {range_rad!r} rad. Give another, or '
            'leave it out',
        )


def _checked_thread(scene: Scene, thread_mm: float, acts_from_rad: float) -> float | None:
    """Return from where on a thick thread touches the cheeks; refuse one that never does."""
    if not thread_mm:
        return None
    assert scene.trochlea is not None
    release = abs(scene.trochlea.release_angle)
    if acts_from_rad >= release > 0.0:
        raise UsageError(
            Argument('thread_mm', f'{thread_mm:g} mm', spaced=True),
            f': bends round the edges of the cheeks up to {acts_from_rad:.4g} rad, and the wheel '
            f'is released at {release:.4g} rad: it never touches them. Use a thinner thread',
        )
    return acts_from_rad


def _write_drawings(drawing: CamDrawing, files: Mapping[str, Path]) -> None:
    if 'svg' in files:
        write_svg(files['svg'], drawing)
    if 'dxf' in files:
        write_dxf(files['dxf'], drawing)


def _lever_words(
    scene: Scene,
    shape: CorrectedLeverGeometry | MirroredLever,
    left: LeverCheek,
    right: LeverCheek,
    thread_mm: float,
) -> list[str]:
    """Return the dimensions needed to cut and mount the cheeks, one line each."""
    assert scene.trochlea is not None
    arc = getattr(scene.trochlea.thread, 'arc', None) is not None
    held = (
        'place where the thread at rest touches the arc, of'
        if arc
        else 'end B of the thread at rest, AB'
    )
    on_right = ', on the right' if shape.side < 0.0 else ''
    return [
        'millimetres, 1:1; origin: the axle; +y: the thread at rest; cut CHEEK_LEFT, CHEEK_RIGHT',
        f'base radius {MM_PER_M * shape.base_radius:.6g} mm; drawn to {left.angle[-1]:.6g} rad',
        f'fulcrum level with the {held} {MM_PER_M * shape.arm:.6g} mm{on_right}; '
        f'free thread {MM_PER_M * shape.length:.6g} mm',
        f'cheeks cut back by half the thread, {thread_mm:.6g} mm thick; they act from '
        f'{right.angle[0]:.6g} and {left.angle[0]:.6g} rad on'
        if thread_mm
        else 'for a thin thread: nothing is taken off for its thickness',
    ]


# -----------------------------------------------------------------------------
# The files.


def write_points(path: Path, cut: Cheeks) -> None:
    """Write both cheeks as x_mm, y_mm, angle_rad, from the end of one to the end of the other.

    At positive angles the thread leaves the cheek on the left of the drawing. A tip that both
    share is one row.
    """
    x, y, angle = (MM_PER_M * cut.x).tolist(), (MM_PER_M * cut.y).tolist(), cut.angle.tolist()
    shared = 1 if x[0] == 0.0 else 0
    mirrored = [(-a, b, -c) for a, b, c in zip(x, y, angle, strict=True)][shared:]
    rows: Sequence[tuple[float, ...]] = [
        *reversed(mirrored),
        *zip(x, y, angle, strict=True),
    ]
    write_rows(path, COLUMNS, rows)


def write_sides(path: Path, left: LeverCheek, right: LeverCheek) -> None:
    """Write two cheeks that are not mirror images, from the end of the right to that of the left.

    A tip that both share is written once.
    """
    common = left.angle[0] == right.angle[0]
    columns = [
        (MM_PER_M * np.concatenate([second[::-1], first[int(common) :]])).tolist()
        for first, second in ((left.x, right.x), (left.y, right.y))
    ]
    angles = np.concatenate([right.angle[::-1], left.angle[int(common) :]]).tolist()
    write_rows(path, COLUMNS, zip(*columns, angles, strict=True))


def write_rows(path: Path, header: Sequence[str], rows: Iterable[Sequence[float]]) -> None:
    """Write numbers in full under a header."""
    lines = [','.join(header), *(','.join(map(repr, row)) for row in rows)]
    write_output(path, ('\n'.join(lines) + '\n').encode())


def write_svg(path: Path, drawing: CamDrawing) -> None:
    """Write a drawing to scale, in millimetres on paper."""
    import matplotlib as mpl
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle

    left, low, right, top = drawing.box
    longest = max(note.x + LETTER * drawing.text_mm * len(note.text) for note in drawing.notes)
    x, y = (
        (left - _MARGIN_MM, max(right, longest) + _MARGIN_MM),
        (low - _MARGIN_MM, top + _MARGIN_MM),
    )
    figure = Figure(figsize=((x[1] - x[0]) / MM_PER_INCH, (y[1] - y[0]) / MM_PER_INCH))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=x, ylim=y)
    axes.set_axis_off()
    pen = drawing.text_mm / TEXT_MM
    for line in drawing.lines:
        cut = line.layer in CUT
        axes.plot(
            line.x,
            line.y,
            color='black' if cut else 'tab:blue',
            linewidth=pen * (0.5 if cut else 0.3),
            gid=line.layer,
        )
    for each in drawing.circles:
        ring = Circle(
            (each.x, each.y), each.radius, fill=False, linewidth=0.3 * pen, gid=each.layer
        )
        ring.set_edgecolor('tab:blue')
        axes.add_patch(ring)
    for note in drawing.notes:
        axes.text(note.x, note.y, note.text, fontsize=drawing.text_mm * POINTS_PER_MM)
    # the same scene must give the same file
    drawn = BytesIO()
    with mpl.rc_context({'svg.hashsalt': drawing.title}):
        figure.savefig(drawn, format='svg', metadata={'Title': drawing.title, 'Date': None})
    write_output(path, drawn.getvalue())


def write_dxf(path: Path, drawing: CamDrawing) -> None:
    """Write a drawing as DXF R2010 in millimetres, a layer for each kind of line."""
    from ezdxf import units
    from ezdxf.filemanagement import new

    document = new('R2010', setup=False, units=units.MM)
    layers = [line.layer for line in drawing.lines]
    layers += [each.layer for each in drawing.circles] + [note.layer for note in drawing.notes]
    for layer in dict.fromkeys(layers):
        document.layers.add(layer, color=7 if layer in CUT else 5)
    space = document.modelspace()
    for line in drawing.lines:
        points = zip(line.x.tolist(), line.y.tolist(), strict=True)
        space.add_lwpolyline(points, dxfattribs={'layer': line.layer})
    for each in drawing.circles:
        space.add_circle((each.x, each.y), each.radius, dxfattribs={'layer': each.layer})
    for note in drawing.notes:
        text = space.add_text(note.text, height=drawing.text_mm, dxfattribs={'layer': note.layer})
        text.set_placement((note.x, note.y))
    written = StringIO()
    document.write(written)
    write_output(path, document.encode(written.getvalue()))
