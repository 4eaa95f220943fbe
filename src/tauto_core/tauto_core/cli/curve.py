"""`tauto cam` and `tauto isochronism`: the curve of a scene, and how well it does its work."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from tauto_core.cli.options import AsJson, SceneName
from tauto_core.scene.errors import TautoError, UsageError, naming

if TYPE_CHECKING:
    from tauto_core.machines import Isochronism
    from tauto_core.machines.fluid_pendulum import DescentIsochronism
    from tauto_core.samples import FloatArray
    from tauto_core.scene import Scene

MM_PER_M = 1000.0
MM_PER_INCH = 25.4
MARGIN_MM = 2.0
FEWEST_POINTS, MOST_POINTS = 2, 1_000_000
HEADER = ('angle_rad', 'lever_arm_mm', 'x_mm', 'y_mm', 'radius_of_curvature_mm')
FLUID_HEADER = ('arc_mm', 'slope', 'x_mm', 'y_mm', 'radius_of_curvature_mm')


class Curve(NamedTuple):
    """A curve to print and to draw."""

    header: tuple[str, ...]
    rows: Callable[[], Sequence[FloatArray]]
    """Columns of a few points, as the header says."""
    outline: Callable[[int], tuple[FloatArray, FloatArray]]
    """(x, y) of so many points on each half [m]."""


class OutputError(TautoError):
    """A file that cannot be written."""


def cam(
    scene: SceneName,
    csv: Annotated[
        Path | None, typer.Option(help='Write the outline as x_mm,y_mm; replaces the file.')
    ] = None,
    svg: Annotated[
        Path | None, typer.Option(help='Draw the outline to scale; replaces the file.')
    ] = None,
    reach: Annotated[
        float | None,
        typer.Option(
            metavar='RAD', help='Largest angle drawn; default: all of the cam, at most one turn.'
        ),
    ] = None,
    points: Annotated[
        int, typer.Option(metavar='N', help='Points on each cheek or branch.')
    ] = 200,
) -> None:
    """Give the curve of a cam, to look at and to cut.

    The frame turns with the wheel, its origin is the axle, +y points along the thread at rest. Of
    a curve in a fluid the origin is its lowest point, +y points upwards, and descents begin at
    x > 0. Without --csv and --svg, a few points of one cheek or branch are printed.
    """
    from tauto_core.scene import load_scene

    if not FEWEST_POINTS <= points <= MOST_POINTS:
        raise UsageError(
            f'--points = {points}: must be {FEWEST_POINTS} to {MOST_POINTS} on each cheek. Give '
            'another, or leave it out'
        )
    loaded = load_scene(scene)
    with naming(scene, loaded.name):
        curve = _of_cam(loaded, reach) if loaded.regulator is None else _in_fluid(loaded, reach)
    if csv is None and svg is None:
        _print_rows(curve)
        return
    x, y = (MM_PER_M * part for part in curve.outline(points))
    if csv is not None:
        _write_csv(csv, ('x_mm', 'y_mm'), zip(x.tolist(), y.tolist(), strict=True))
    if svg is not None:
        _draw(svg, x, y, loaded.name)


def isochronism(
    scene: SceneName,
    amplitudes: Annotated[
        str,
        typer.Option(
            metavar='A,B,…', help='Amplitudes of the free swings [rad]; of a body in a fluid [m].'
        ),
    ],
    as_json: AsJson = False,
) -> None:
    """Tell period and rate against amplitude, on land, without drag and escapement.

    Of a body in a fluid also the time of the descent; the amplitude is the arc of the release,
    and the period the time to the other side and back from where it gets to.
    """
    from tauto_core import machines
    from tauto_core.scene import load_scene

    loaded = load_scene(scene)
    with naming(scene, loaded.name):
        machine = machines.compile_machine(loaded)
    numbers, nominal = _numbers(amplitudes), loaded.clock.nominal_period
    if isinstance(machine, machines.FluidPendulum):
        descents = machines.descent_isochronism(machine, numbers, nominal)
        typer.echo(json.dumps(descents, allow_nan=False)) if as_json else _print_descents(descents)
    else:
        swings = machines.isochronism(machine, numbers, nominal)
        typer.echo(json.dumps(swings, allow_nan=False)) if as_json else _print_swings(swings)


def _print_swings(found: Isochronism) -> None:
    typer.echo(f'nominal period {found["nominal_period_s"]:.12g} s')
    typer.echo(f'{"amplitude rad":>14}  {"period s":>16}  {"rate s/day":>16}')
    for row in found['rows']:
        amplitude, period, rate = row['amplitude_rad'], row['period_s'], row['rate_s_per_day']
        typer.echo(f'{amplitude:14.6g}  {period:16.12f}  {rate:+16.9f}')


def _print_descents(found: DescentIsochronism) -> None:
    typer.echo(f'nominal period {found["nominal_period_s"]:.12g} s')
    typer.echo(f'{"amplitude m":>14}  {"descent s":>16}  {"period s":>16}  {"rate s/day":>16}')
    for row in found['rows']:
        typer.echo(
            f'{row["amplitude_m"]:14.6g}  {row["descent_s"]:16.12f}  {row["period_s"]:16.12f}  '
            f'{row["rate_s_per_day"]:+16.9f}'
        )


def _numbers(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(',')]
    except ValueError:
        raise UsageError(
            f'--amplitudes = {text!r}: must be numbers with commas between, in radians '
            '(metres in a fluid). '
            'Write for example 0.1,0.5,1'
        ) from None


def _of_cam(scene: Scene, reach: float | None) -> Curve:
    """Return the cheeks of a scene's cam.

    Raises:
        UsageError: a reach beyond the cam, or no cam.
    """
    from math import tau

    import numpy as np

    from tauto_core.curves import make_cam, outline

    if scene.trochlea is None:
        raise UsageError(f'{scene.name}: has no trochlea, so there is no cam')
    cam = make_cam(scene.trochlea)
    if reach is not None and not 0.0 < reach <= cam.range_rad:
        raise UsageError(
            f'--reach = {reach!r} rad: must be > 0 and within the range of the cam, '
            f'{cam.range_rad!r} rad. Give another, or leave it out'
        )

    def rows() -> Sequence[FloatArray]:
        angle = np.linspace(0.0, min(cam.range_rad, tau) if reach is None else reach, 11)
        lengths = (cam.lever_arm(angle), *cam.contact(angle), cam.radius_of_curvature(angle))
        return angle, *(MM_PER_M * length for length in lengths)

    return Curve(HEADER, rows, lambda points: outline(cam, points, reach))


def _in_fluid(scene: Scene, reach: float | None) -> Curve:
    """Return the curve in the fluid of a scene.

    Raises:
        UsageError: a reach, which is an angle of a cam.
        SceneError: a curve that cannot be built.
    """
    import numpy as np

    from tauto_core.curves.fluid_outline import coordinates, fluid_outline, radius_of_curvature
    from tauto_core.machines import FluidPendulum, compile_machine

    machine = compile_machine(scene)
    if reach is not None or not isinstance(machine, FluidPendulum):
        raise UsageError(
            f'--reach = {reach!r} rad: is an angle of a cam, and this scene has a curve in a '
            'fluid, which is drawn to its cusps. Leave it out'
        )
    curve = machine.curve

    def rows() -> Sequence[FloatArray]:
        arc = np.linspace(0.0, curve.descent_cusp, 11)
        height, level = coordinates(curve, arc)
        lengths = (level, height, radius_of_curvature(curve, arc))
        return MM_PER_M * arc, curve.slope(arc), *(MM_PER_M * length for length in lengths)

    return Curve(FLUID_HEADER, rows, lambda points: fluid_outline(curve, points))


def _print_rows(curve: Curve) -> None:
    header = curve.header
    typer.echo('  '.join(f'{name:>{max(len(name), 12)}}' for name in header))
    for row in zip(*(column.tolist() for column in curve.rows()), strict=True):
        typer.echo(
            '  '.join(
                f'{value:{max(len(name), 12)}.6f}' for name, value in zip(header, row, strict=True)
            )
        )


def _write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[float]]) -> None:
    lines = [','.join(header), *(','.join(map(repr, row)) for row in rows)]
    try:
        path.write_text('\n'.join(lines) + '\n', encoding='utf-8')
    except OSError as error:
        raise _refused(path, error) from None


def _draw(path: Path, x: FloatArray, y: FloatArray, title: str) -> None:
    """Draw a polyline [mm] so that a millimetre is one on paper; a cross is the origin."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    left, right = min(0.0, x.min()) - MARGIN_MM, max(0.0, x.max()) + MARGIN_MM
    low, high = min(0.0, y.min()) - MARGIN_MM, max(0.0, y.max()) + MARGIN_MM
    figure = Figure(figsize=((right - left) / MM_PER_INCH, (high - low) / MM_PER_INCH))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(left, right), ylim=(low, high))
    axes.set_axis_off()
    axes.plot(x, y, color='black', linewidth=0.3)
    axes.plot([0.0], [0.0], '+', color='black', markersize=6.0, markeredgewidth=0.3)
    # the same scene must give the same file
    with mpl.rc_context({'svg.hashsalt': title}):
        try:
            figure.savefig(path, format='svg', metadata={'Title': title, 'Date': None})
        except OSError as error:
            raise _refused(path, error) from None


def _refused(path: Path, error: OSError) -> OutputError:
    return OutputError(f'{path}: cannot be written: {error.strerror}. Name another file')
