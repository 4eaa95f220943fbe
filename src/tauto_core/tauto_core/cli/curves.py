"""`tauto cam`, `tauto design`, `tauto isochronism`: the curve, to look at, to cut, to design."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from tauto_core.cli.terminal import AsJson, SceneName, Settings, given_values, say
from tauto_core.scene.errors import UsageError, naming
from tauto_core.scene.times import STANDARD_GRAVITY

if TYPE_CHECKING:
    from tauto_core.machines.design import Design


# -----------------------------------------------------------------------------
# `tauto cam`: the curve of a scene, to look at and to cut.

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
    from tauto_core.cli.terminal import progress_bar
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
    from tauto_core.plots.machine import cam_extent

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
        raise UsageError(f'--thread = {thread_mm:g} mm: ', error.message) from None
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


# -----------------------------------------------------------------------------
# `tauto design`: from a wanted period to cam, pull or wheel, and back.

Quantity = float | None


def design(
    period: Annotated[
        Quantity, typer.Option(metavar='S', help='Period of a full swing [s].')
    ] = None,
    pendulum: Annotated[
        Quantity, typer.Option(metavar='LENGTH', help='Or of a simple pendulum of this length.')
    ] = None,
    inertia: Annotated[
        Quantity, typer.Option(metavar='KGM2', help="The wheel's moment of inertia [kg m2].")
    ] = None,
    disc_weight: Annotated[
        Quantity, typer.Option(metavar='WEIGHT', help='Or its weight, if it is a uniform disc,')
    ] = None,
    disc_radius: Annotated[
        Quantity, typer.Option(metavar='LENGTH', help='and its radius.')
    ] = None,
    disc_is_base: Annotated[
        bool, typer.Option('--disc-is-base', help="The disc's radius is the base radius (XX).")
    ] = False,
    pull: Annotated[
        Quantity, typer.Option(metavar='WEIGHT', help='Pull in the thread, without inertia.')
    ] = None,
    base_radius: Annotated[
        Quantity,
        typer.Option(metavar='LENGTH', help="Base radius of the involute; a hole's rate."),
    ] = None,
    length_unit: Annotated[
        str,
        typer.Option(metavar='UNIT', help='m, mm, scruple, rhenish_foot, line or paris_foot.'),
    ] = 'm',
    weight_unit: Annotated[
        str, typer.Option(metavar='UNIT', help='N, kg or pound (of Paris).')
    ] = 'N',
    gravity: Annotated[
        float, typer.Option(metavar='G', help='Acceleration of gravity [m/s2].')
    ] = STANDARD_GRAVITY,
    as_json: AsJson = False,
) -> None:
    """Find what is left out of a design of a wheel and its cam.

    Of period, moment of inertia, pull and base radius three give the fourth (Euler 1727, XIX-XXI).
    A disc counts as two numbers, weight and radius, one of which may be what is left out.
    """
    from tauto_core.machines.design import check_size

    check_size('--gravity', gravity)
    metres, newtons = _units(length_unit, weight_unit, gravity)
    given = {
        'period': (period, 1.0),
        'pendulum': (pendulum, metres),
        'inertia': (inertia, 1.0),
        'disc-weight': (disc_weight, newtons),
        'disc-radius': (disc_radius, metres),
        'pull': (pull, newtons),
        'base-radius': (base_radius, metres),
    }
    for name, (value, _) in given.items():
        if value is not None:
            check_size(f'--{name}', value)
    known = {name: value * unit for name, (value, unit) in given.items() if value is not None}
    found, disc = _solved(known, gravity, disc_is_base)
    facts = _facts(found, disc, gravity)
    if as_json:
        typer.echo(json.dumps(facts, allow_nan=False))
        return
    _print(facts, length_unit, metres, weight_unit, newtons)


def _units(length: str, weight: str, gravity: float) -> tuple[float, float]:
    """Return the units in metres and newtons."""
    from tauto_core.machines.design import LENGTHS_M, WEIGHTS_KG

    if length not in LENGTHS_M:
        raise UsageError(f'--length-unit = {length!r}: use one of {", ".join(LENGTHS_M)}')
    if weight not in ('N', *WEIGHTS_KG):
        raise UsageError(f'--weight-unit = {weight!r}: use one of N, {", ".join(WEIGHTS_KG)}')
    return LENGTHS_M[length], 1.0 if weight == 'N' else WEIGHTS_KG[weight] * gravity


def _solved(
    known: dict[str, float], gravity: float, disc_is_base: bool
) -> tuple[Design, dict[str, float]]:
    """Return the design, and weight and radius of the disc if there is one."""
    from tauto_core.machines import design as rules

    _check_alternatives(known, disc_is_base)
    period = known.get('period')
    if 'pendulum' in known:
        period = 2.0 * rules.half_period(known['pendulum'], gravity)
    pull, base = known.get('pull'), known.get('base-radius')
    weight, radius = known.get('disc-weight'), known.get('disc-radius')
    inertia = known.get('inertia')
    if disc_is_base:
        weight, pull, base = _disc_is_base(period, weight, pull, base, gravity)
        radius = base
    if weight is not None and radius is not None:
        inertia = rules.disc_inertia(weight, radius, gravity)
    found = rules.complete(
        period=None if disc_is_base else period, inertia=inertia, pull=pull, lever_rate=base
    )
    if weight is not None:
        radius = radius or rules.disc_radius(found.inertia, weight, gravity)
        return found, {'weight': weight, 'radius': radius}
    if radius is not None:
        weight = rules.disc_weight(found.inertia, radius, gravity)
        return found, {'weight': weight, 'radius': radius}
    return found, {}


def _check_alternatives(known: dict[str, float], disc_is_base: bool) -> None:
    for name, other in (
        ('period', 'pendulum'),
        ('inertia', 'disc-weight'),
        ('inertia', 'disc-radius'),
    ):
        if name in known and other in known:
            raise UsageError(f'--{name} and --{other} say the same thing twice. Leave one out')
    if disc_is_base and ('disc-radius' in known or 'inertia' in known):
        raise UsageError(
            '--disc-is-base makes the radius of the disc the base radius. Leave out --disc-radius '
            'and --inertia'
        )


def _disc_is_base(
    period: Quantity, weight: Quantity, pull: Quantity, base: Quantity, gravity: float
) -> tuple[float, float, float]:
    """Return Q, P and r of L = Q r/(2P), where one of L, Q, P, r was left out."""
    from tauto_core.machines import design as rules

    length = None if period is None else rules.length_of_period(period, gravity)
    match length, weight, pull, base:
        case None, float(), float(), float():
            return weight, pull, base
        case float(), None, float(), float():
            return 2.0 * pull * length / base, pull, base
        case float(), float(), None, float():
            return weight, weight * base / (2.0 * length), base
        case float(), float(), float(), None:
            return weight, pull, rules.base_radius_of_disc(weight, pull, length)
    raise UsageError(
        'with --disc-is-base three of --period (or --pendulum), --disc-weight, --pull and '
        '--base-radius give the fourth. Leave out exactly one'
    )


def _facts(found: Design, disc: dict[str, float], gravity: float) -> dict[str, float]:
    return {
        'period_s': found.period,
        'pendulum_m': found.pendulum_length(gravity),
        'inertia_kg_m2': found.inertia,
        **{f'disc_{name}_{unit}': disc[name] for name, unit in _DISC if name in disc},
        'pull_n': found.pull,
        'base_radius_m': found.lever_rate,
        'gravity_m_s2': gravity,
    }


_DISC = (('weight', 'n'), ('radius', 'm'))


def _print(
    facts: dict[str, float], length: str, metres: float, weight: str, newtons: float
) -> None:
    # Six digits: a micrometre in a metre, and 0.05 s/day of the period; --json has all.
    units = {'_m': (length, metres), '_n': (weight, newtons)}
    names = {'_s': 's', '_kg_m2': 'kg m2', '_m_s2': 'm/s2'}
    for key, value in facts.items():
        for ending, unit in names.items():
            if key.endswith(ending):
                typer.echo(f'{key.removesuffix(ending).replace("_", " "):14} {value:.6g} {unit}')
                break
        else:
            ending = key[-2:]
            unit, size = units[ending]
            name = key.removesuffix(ending).replace('_', ' ')
            typer.echo(f'{name:14} {value / size:.6g} {unit}')


# -----------------------------------------------------------------------------
# `tauto isochronism`: how well a regulator keeps one period at every amplitude.


def isochronism(
    scene: SceneName,
    amplitudes: Annotated[
        str,
        typer.Option(
            metavar='A,B,…',
            help='Amplitudes of the free swings [rad], such as 0.2,0.6,1; of a body in a fluid '
            '[m].',
        ),
    ],
    settings: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Give period and rate against amplitude, on land.

    Drag and escapement are left out, so that the swings are free.

    Of a body in a fluid also the time of the descent; the amplitude is the arc of the release,
    and the period the time to the other side and back from where it gets to.
    """
    from tauto_core.machines import free_swings
    from tauto_core.scene import load_scene

    loaded = load_scene(scene, **given_values(settings))
    with naming(scene, loaded.name):
        found = free_swings(loaded, _numbers(amplitudes), loaded.clock.nominal_period)
    if not as_json:
        typer.echo(found)
        return
    columns = found.columns()
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    facts = {
        'nominal_period_s': found.nominal_period_s,
        'rows': [dict(zip(columns, row, strict=True)) for row in rows],
    }
    typer.echo(json.dumps(facts, allow_nan=False))


def _numbers(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(',')]
    except ValueError:
        raise UsageError(
            f'--amplitudes = {text!r}: must be numbers with commas between, in radians '
            '(metres in a fluid). '
            'Write for example 0.1,0.5,1'
        ) from None
