"""`tauto cam`: the curve of a scene, to look at and to cut."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from tauto_core.cli.options import SceneName, Settings, given_values
from tauto_core.cli.voice import say
from tauto_core.scene.errors import UsageError, naming

if TYPE_CHECKING:
    from tauto_core.curves import Cam, DescentCurve
    from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
    from tauto_core.curves.drawing import Drawing
    from tauto_core.machines.lever_cheeks import Cheek
    from tauto_core.samples import FloatArray
    from tauto_core.scene import Scene

    Rows: TypeAlias = tuple[tuple[str, ...], Sequence[FloatArray]]

MM_PER_M = 1000.0
THICKEST_MM = 100.0
FEWEST_POINTS, MOST_POINTS = 2, 1_000_000
HEADER = ('angle_rad', 'lever_arm_mm', 'x_mm', 'y_mm', 'radius_of_curvature_mm')
FLUID_HEADER = ('arc_mm', 'slope', 'x_mm', 'y_mm', 'radius_of_curvature_mm')


def cam(
    scene: SceneName,
    csv: Annotated[
        Path | None,
        typer.Option(metavar='FILE', help='Write the points of the outline; replaces the file.'),
    ] = None,
    svg: Annotated[
        Path | None, typer.Option(metavar='FILE', help='Draw it to scale; replaces the file.')
    ] = None,
    dxf: Annotated[
        Path | None,
        typer.Option(metavar='FILE', help='Draw it for the workshop; replaces the file.'),
    ] = None,
    reach: Annotated[
        float | None,
        typer.Option(
            metavar='RAD',
            help='Largest angle drawn; default: half as far again as the wheel swings, within '
            'the cam and before the cheeks meet.',
        ),
    ] = None,
    points: Annotated[
        int, typer.Option(metavar='N', help='Points on each cheek or branch.')
    ] = 200,
    thread: Annotated[
        float,
        typer.Option(metavar='MM', help='Thickness of the thread; cheeks are cut back by half.'),
    ] = 0.0,
    settings: Settings = None,
) -> None:
    """Give the curve of a cam, to look at and to cut.

    The frame turns with the wheel, its origin is the axle, +y points along the thread at rest. Of
    a curve in a fluid the origin is its lowest point, +y points upwards, and descents begin at
    x > 0. Without --csv, --svg and --dxf, a few points of one cheek or branch are printed.
    """
    from tauto_core.cli.progress import progress_bar
    from tauto_core.scene import load_scene

    if not FEWEST_POINTS <= points <= MOST_POINTS:
        raise UsageError(
            f'--points = {points}: must be {FEWEST_POINTS} to {MOST_POINTS} on each cheek. Give '
            'another, or leave it out'
        )
    if not 0.0 <= thread <= THICKEST_MM:
        raise UsageError(
            f'--thread = {thread}: must be 0 to {THICKEST_MM:g} mm. Give the thickness of the '
            'thread, or leave it out'
        )
    files = {'csv': csv, 'svg': svg, 'dxf': dxf}
    for kind, file in files.items():
        if file is not None and file.suffix.lower() not in ('', f'.{kind}'):
            raise UsageError(
                f'--{kind} {file}: ends in {file.suffix}, and what is written is {kind.upper()}. '
                f'Name it {file.with_suffix("." + kind).name}, or ask for the other format'
            )
    loaded = load_scene(scene, **given_values(settings))
    with naming(scene, loaded.name), progress_bar(f'cam of {loaded.name}'):
        if loaded.trochlea is None:
            shown = _in_fluid(loaded, files, reach, points, thread)
        else:
            end = _extent(loaded) if reach is None else reach
            drawn = _lever_cheeks if loaded.trochlea.cam.kind == 'lever_corrected' else _cheeks
            shown = drawn(loaded, files, end, points, thread)
    if shown is not None:
        _print_rows(*shown)
    for file in files.values():
        if file is not None:
            say(f'wrote {file}')


def _extent(scene: Scene) -> float:
    """Return the default angle up to which the cheeks are drawn [rad]."""
    from tauto_core.cam_extent import cam_extent

    assert scene.trochlea is not None
    extent, release = cam_extent(scene), abs(scene.trochlea.release_angle)
    say(
        f'the cheeks end at {extent:.4g} rad, for a wheel released at {release:g} rad; --reach '
        'asks for another end'
    )
    return extent


def _cheeks(
    scene: Scene, files: dict[str, Path | None], reach: float, points: int, thread_mm: float
) -> Rows | None:
    """Write the cheeks of a scene's cam, or return a few points of one.

    Raises:
        UsageError: a reach beyond the cam, or a thread too thick for it.
        SceneError: a cam that cannot be built.
    """
    from tauto_core.cli import cam_files
    from tauto_core.curves.drawing import cheeks, cheeks_meet_rad, draw

    assert scene.trochlea is not None
    curve = scene.trochlea.made_cam(scene.gravity)
    if not 0.0 < reach <= curve.range_rad:
        raise UsageError(
            f'--reach = {reach!r} rad: must be > 0 and within the range of the cam, '
            f'{curve.range_rad!r} rad. Give another, or leave it out'
        )
    if not any(files.values()):
        _refuse_thickness(thread_mm)
        return HEADER, _few_of_cam(curve, reach)
    try:
        cut = cheeks(curve, points, reach, thread_mm / MM_PER_M)
    except UsageError as error:
        if not thread_mm:
            raise
        raise UsageError(f'--thread = {thread_mm:g} mm: {error}') from None
    if cut.angle[-1] > (meeting := cheeks_meet_rad(curve)):
        say(
            f'the cheeks cross at {meeting:.4g} rad and cannot be cut from one plate beyond it: '
            'give a smaller --reach'
        )
    _check_thread(scene, thread_mm, float(cut.angle[0]))
    if (csv := files['csv']) is not None:
        cam_files.write_points(csv, cut)
    _write_drawings(draw(curve, cut, scene.name), files)
    return None


def _lever_cheeks(
    scene: Scene, files: dict[str, Path | None], reach: float, points: int, thread_mm: float
) -> Rows | None:
    """Write the cheeks of a lever's cam, which are not mirror images, or return a few points.

    Raises:
        UsageError: a reach beyond the cam, or a thread too thick for it.
        SceneError: a cam that cannot be built.
    """
    import numpy as np

    from tauto_core.cli import cam_files
    from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
    from tauto_core.curves.drawing import draw_uneven
    from tauto_core.machines import LeverMachine, compile_machine
    from tauto_core.machines.lever_cheeks import cheek

    machine = compile_machine(scene)
    assert isinstance(machine, LeverMachine)
    assert isinstance(machine.geometry, CorrectedLeverGeometry)
    shape, edge = machine.geometry, machine.range_rad
    if not 0.0 < reach <= edge:
        raise UsageError(
            f'--reach = {reach!r} rad: must be > 0 and within the range of the cam, {edge!r} rad. '
            'Give another, or leave it out'
        )
    ends = shape.tau_of(np.array([-1.0, 1.0]) * reach).tolist()
    if not any(files.values()):
        _refuse_thickness(thread_mm)
        tau = np.linspace(0.0, ends[1], 11)
        lengths = (shape.lever_arm(tau), *shape.contact(tau), shape.radius_of_curvature(tau))
        return HEADER, (shape.theta(tau), *(MM_PER_M * length for length in lengths))
    right, left = (cheek(shape, end, points, thread_mm / MM_PER_M) for end in ends)
    _check_thread(scene, thread_mm, max(abs(float(side.angle[0])) for side in (right, left)))
    if (csv := files['csv']) is not None:
        cam_files.write_sides(csv, left, right)
    rate = MM_PER_M * shape.base_radius
    at_left, at_right = ((MM_PER_M * side.x, MM_PER_M * side.y) for side in (left, right))
    _write_drawings(
        draw_uneven(
            at_left, at_right, rate, scene.name, _lever_words(shape, left, right, thread_mm)
        ),
        files,
    )
    return None


def _lever_words(
    shape: CorrectedLeverGeometry, left: Cheek, right: Cheek, thread_mm: float
) -> list[str]:
    """Return the dimensions needed to cut and mount the cheeks, one line each."""
    return [
        'millimetres, 1:1; origin: the axle; +y: the thread at rest; cut CHEEK_LEFT, CHEEK_RIGHT',
        f'base radius {MM_PER_M * shape.base_radius:.6g} mm; drawn to {left.angle[-1]:.6g} rad',
        f'fulcrum level with the end B of the thread at rest, AB {MM_PER_M * shape.arm:.6g} mm; '
        f'free thread {MM_PER_M * shape.length:.6g} mm',
        f'cheeks cut back by half the thread, {thread_mm:.6g} mm thick; they act from '
        f'{right.angle[0]:.6g} and {left.angle[0]:.6g} rad on'
        if thread_mm
        else 'for a thin thread: nothing is taken off for its thickness',
    ]


def _check_thread(scene: Scene, thread_mm: float, acts_from_rad: float) -> None:
    """Refuse a thread too thick for the cheeks; return the angle at which the cheeks begin.

    Raises:
        UsageError: the cheeks begin beyond the angle of the release.
    """
    if not thread_mm:
        return
    assert scene.trochlea is not None
    release = abs(scene.trochlea.release_angle)
    if acts_from_rad >= release > 0.0:
        raise UsageError(
            f'--thread = {thread_mm:g} mm: bends round the edges of the cheeks up to '
            f'{acts_from_rad:.4g} rad, and the wheel is released at {release:.4g} rad: it never '
            'touches them. Use a thinner thread'
        )
    say(f'a thread of {thread_mm:g} mm bends round the edges up to {acts_from_rad:.4g} rad')


def _refuse_thickness(thread_mm: float) -> None:
    """Refuse a thickness of the thread where only the centre line is printed."""
    if thread_mm:
        raise UsageError(
            f'--thread = {thread_mm} mm: counts for a cheek that is written; the points printed '
            'are those of a thin thread. Add --csv, --svg or --dxf, or leave it out'
        )


def _in_fluid(
    scene: Scene, files: dict[str, Path | None], reach: float | None, points: int, thread_mm: float
) -> Rows | None:
    """Write the curve of a scene in a fluid, or return a few of its points.

    Raises:
        UsageError: a reach or a thread, which only cams have.
        SceneError: a curve that cannot be built.
    """
    from tauto_core.cli import cam_files
    from tauto_core.curves.drawing import draw_in_fluid
    from tauto_core.curves.fluid import fluid_outline
    from tauto_core.machines import FluidPendulum, compile_machine

    machine = compile_machine(scene)
    given = f'--reach = {reach!r} rad' if reach is not None else f'--thread = {thread_mm} mm'
    if reach is not None or thread_mm or not isinstance(machine, FluidPendulum):
        raise UsageError(
            f'{given}: belongs to a cam, and this scene has a curve in a fluid, which is drawn to '
            'its cusps. Leave it out'
        )
    if not any(files.values()):
        return FLUID_HEADER, _few_of_fluid(machine.curve)
    x, y = (MM_PER_M * part for part in fluid_outline(machine.curve, points))
    if (csv := files['csv']) is not None:
        rows = zip(x.tolist(), y.tolist(), strict=True)
        cam_files.write_rows(csv, ('x_mm', 'y_mm'), rows)
    _write_drawings(draw_in_fluid(machine.curve, (x, y), scene.name), files)
    return None


def _write_drawings(drawing: Drawing, files: dict[str, Path | None]) -> None:
    from tauto_core.cli import cam_files

    if (svg := files['svg']) is not None:
        cam_files.write_svg(svg, drawing)
    if (dxf := files['dxf']) is not None:
        cam_files.write_dxf(dxf, drawing)


def _few_of_cam(curve: Cam, reach: float) -> Sequence[FloatArray]:
    import numpy as np

    angle = np.linspace(0.0, reach, 11)
    lengths = (curve.lever_arm(angle), *curve.contact(angle), curve.radius_of_curvature(angle))
    return angle, *(MM_PER_M * length for length in lengths)


def _few_of_fluid(curve: DescentCurve) -> Sequence[FloatArray]:
    import numpy as np

    from tauto_core.curves.fluid import coordinates, radius_of_curvature

    arc = np.linspace(0.0, curve.descent_cusp, 11)
    height, level = coordinates(curve, arc)
    lengths = (level, height, radius_of_curvature(curve, arc))
    return MM_PER_M * arc, curve.slope(arc), *(MM_PER_M * length for length in lengths)


def _print_rows(header: tuple[str, ...], columns: Sequence[FloatArray]) -> None:
    widths = [max(len(name), 12) for name in header]
    figures = zip(*(column.tolist() for column in columns), strict=True)
    # A tenth of a micrometre, which no cutter keeps; --csv has all digits. Figures for other
    # programs: a hyphen is the minus that they read.
    for row in (header, *([f'{value:z.4f}' for value in row] for row in figures)):
        cells = zip(row, widths, strict=True)
        typer.echo('  '.join(f'{cell:>{width}}' for cell, width in cells))
