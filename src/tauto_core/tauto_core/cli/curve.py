"""`tauto cam` and `tauto isochronism`: the curve of a scene, and how well it does its work."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tauto_core.cli.options import AsJson, SceneName
from tauto_core.scene.errors import TautoError, UsageError, naming

if TYPE_CHECKING:
    from tauto_core.curves import Cam
    from tauto_core.samples import FloatArray

MM_PER_M = 1000.0
MM_PER_INCH = 25.4
MARGIN_MM = 2.0
FEWEST_POINTS, MOST_POINTS = 2, 1_000_000
HEADER = ('angle_rad', 'lever_arm_mm', 'x_mm', 'y_mm', 'radius_of_curvature_mm')


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
    points: Annotated[int, typer.Option(metavar='N', help='Points on each cheek.')] = 200,
) -> None:
    """Give the curve of a cam, to look at and to cut.

    The frame turns with the wheel, its origin is the axle, +y points along the thread at rest.
    Without --csv and --svg, a few points of one cheek are printed.
    """
    from tauto_core.curves import make_cam, outline
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
    if csv is None and svg is None:
        _print_rows(curve, reach)
        return
    x, y = (MM_PER_M * part for part in outline(curve, points, reach))
    if csv is not None:
        _write_csv(csv, ('x_mm', 'y_mm'), zip(x.tolist(), y.tolist(), strict=True))
    if svg is not None:
        _draw(svg, x, y, loaded.name)


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
    from math import tau

    import numpy as np

    angle = np.linspace(0.0, min(curve.range_rad, tau) if reach is None else reach, 11)
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


def _write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[float]]) -> None:
    lines = [','.join(header), *(','.join(map(repr, row)) for row in rows)]
    try:
        path.write_text('\n'.join(lines) + '\n', encoding='utf-8')
    except OSError as error:
        raise _refused(path, error) from None


def _draw(path: Path, x: FloatArray, y: FloatArray, title: str) -> None:
    """Draw a polyline [mm] so that a millimetre is a millimetre on paper; a cross is the axle."""
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
