"""`tauto cam` and `tauto isochronism`: the curve of a scene, and how well it does its work."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tauto_core.cli.options import AsJson, SceneName
from tauto_core.scene.errors import UsageError, naming

if TYPE_CHECKING:
    from tauto_core.curves import Cam

MM_PER_M = 1000.0
THICKEST_MM = 100.0
FEWEST_POINTS, MOST_POINTS = 2, 1_000_000
HEADER = ('angle_rad', 'lever_arm_mm', 'x_mm', 'y_mm', 'radius_of_curvature_mm')


def cam(
    scene: SceneName,
    csv: Annotated[
        Path | None,
        typer.Option(help='Write both cheeks as x_mm,y_mm,angle_rad; replaces the file.'),
    ] = None,
    svg: Annotated[
        Path | None, typer.Option(help='Draw them to scale, with dimensions; replaces the file.')
    ] = None,
    dxf: Annotated[
        Path | None, typer.Option(help='Draw them for a machine tool [mm]; replaces the file.')
    ] = None,
    reach: Annotated[
        float | None,
        typer.Option(
            metavar='RAD', help='Largest angle drawn; default: all of the cam, at most one turn.'
        ),
    ] = None,
    points: Annotated[int, typer.Option(metavar='N', help='Points on each cheek.')] = 200,
    thread: Annotated[
        float,
        typer.Option(metavar='MM', help='Thickness of the thread; cheeks are cut back by half.'),
    ] = 0.0,
) -> None:
    """Give the curve of a cam, to look at and to cut.

    The frame turns with the wheel, its origin is the axle, +y points along the thread at rest.
    Without --csv, --svg and --dxf, a few points of one cheek are printed.
    """
    from tauto_core.curves import make_cam
    from tauto_core.scene import load_scene

    if not FEWEST_POINTS <= points <= MOST_POINTS:
        raise UsageError(
            f'--points = {points}: must be {FEWEST_POINTS} to {MOST_POINTS} on each cheek. Give '
            'another, or leave it out'
        )
    loaded = load_scene(scene)
    with naming(scene, 'trochlea'):
        curve = make_cam(loaded.trochlea, loaded.gravity)
    if reach is not None and not 0.0 < reach <= curve.range_rad:
        raise UsageError(
            f'--reach = {reach!r} rad: must be > 0 and within the range of the cam, '
            f'{curve.range_rad!r} rad. Give another, or leave it out'
        )
    if csv is None and svg is None and dxf is None:
        _print_rows(curve, reach)
        return
    _write_files(curve, loaded.name, {'csv': csv, 'svg': svg, 'dxf': dxf}, reach, points, thread)


def _write_files(
    curve: Cam,
    title: str,
    files: dict[str, Path | None],
    reach: float | None,
    points: int,
    thread_mm: float,
) -> None:
    from tauto_core.cli import cam_files
    from tauto_core.curves import cheeks
    from tauto_core.curves.workshop import draw

    if not 0.0 <= thread_mm <= THICKEST_MM:
        raise UsageError(
            f'--thread = {thread_mm}: must be 0 to {THICKEST_MM:g} mm. Give the thickness of the '
            'thread, or leave it out'
        )
    cut = cheeks(curve, points, reach, thread_mm / cam_files.MM_PER_M)
    if (csv := files['csv']) is not None:
        cam_files.write_points(csv, cut)
    drawing = draw(curve, cut, title)
    if (svg := files['svg']) is not None:
        cam_files.write_svg(svg, drawing)
    if (dxf := files['dxf']) is not None:
        cam_files.write_dxf(dxf, drawing)


def isochronism(
    scene: SceneName,
    amplitudes: Annotated[
        str, typer.Option(metavar='A,B,…', help='Amplitudes of the free swings [rad].')
    ],
    as_json: AsJson = False,
) -> None:
    """Tell period and rate against amplitude, on land, without drag and escapement."""
    from tauto_core import machines
    from tauto_core.scene import load_scene

    loaded = load_scene(scene)
    with naming(scene, loaded.name):
        machine = machines.compile_machine(loaded)
    found = machines.isochronism(machine, _numbers(amplitudes), loaded.clock.nominal_period)
    if as_json:
        typer.echo(json.dumps(found, allow_nan=False))
        return
    typer.echo(f'nominal period {found["nominal_period_s"]:.12g} s')
    typer.echo(f'{"amplitude rad":>14}  {"period s":>16}  {"rate s/day":>16}')
    for row in found['rows']:
        amplitude, period, rate = row['amplitude_rad'], row['period_s'], row['rate_s_per_day']
        typer.echo(f'{amplitude:14.6g}  {period:16.12f}  {rate:+16.9f}')


def _numbers(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(',')]
    except ValueError:
        raise UsageError(
            f'--amplitudes = {text!r}: must be numbers with commas between, in radians. '
            'Write for example 0.1,0.5,1'
        ) from None


def _print_rows(curve: Cam, reach: float | None) -> None:
    import numpy as np

    angle = np.linspace(0.0, curve.drawn_rad if reach is None else reach, 11)
    columns = (
        angle,
        *(
            MM_PER_M * part
            for part in (
                curve.lever_arm(angle),
                *curve.contact(angle),
                curve.radius_of_curvature(angle),
            )
        ),
    )
    typer.echo('  '.join(f'{name:>{max(len(name), 12)}}' for name in HEADER))
    for row in zip(*(column.tolist() for column in columns), strict=True):
        typer.echo(
            '  '.join(
                f'{value:{max(len(name), 12)}.6f}' for name, value in zip(HEADER, row, strict=True)
            )
        )
