"""`tauto cam`, `design`, `isochronism`, `euler`: a curve, its plate, Euler's claims."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from shutil import get_terminal_size
from textwrap import wrap
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from tauto_core.cli.terminal import (
    AsJson,
    OptionalFloat,
    SceneName,
    Settings,
    given_values,
    listed,
    progress_bar,
    say,
    takes,
)
from tauto_core.scene.errors import naming
from tauto_core.scene.times import STANDARD_GRAVITY
from tauto_core.wording import significant

if TYPE_CHECKING:
    from tauto_core.euler import Claim


# -----------------------------------------------------------------------------
# `tauto cam`: the curve of a scene, to look at, and to cut, print or build a wheel with.

File: TypeAlias = Path | None
SHOWN = 11
"""Points that are printed."""


def cam(
    scene: SceneName,
    csv: Annotated[File, takes('FILE', 'Write the points of the outline.')] = None,
    svg: Annotated[File, takes('FILE', 'Draw it to scale.')] = None,
    dxf: Annotated[File, takes('FILE', 'Draw it for the workshop.')] = None,
    template: Annotated[
        File, takes('FILE', 'Draw the plate on A4 (.svg), a large one on several sheets.')
    ] = None,
    step: Annotated[File, takes('FILE', 'Write wheel, cheeks and axle as solids.')] = None,
    stl: Annotated[File, takes('DIR', 'Write DIR/wheel.stl, cheeks.stl and axle.stl.')] = None,
    plate: Annotated[
        bool,
        typer.Option('--plate', help='Close both cheeks into a plate; --template and solids do.'),
    ] = False,
    reach: Annotated[
        OptionalFloat,
        takes(
            'RAD',
            'Largest angle drawn; default: half as far again as the wheel swings, within '
            'the cam and before the cheeks meet.',
            'rad',
        ),
    ] = None,
    points: Annotated[int, takes('N', 'Points on each cheek or branch.')] = 200,
    thread: Annotated[
        OptionalFloat,
        takes(
            'MM',
            'Thickness of the thread; cheeks are cut back by half; default: 0, of a plate 0.5.',
            'mm',
        ),
    ] = None,
    cutter: Annotated[
        OptionalFloat,
        takes(
            'MM',
            'Diameter of the cutter, or kerf; 0: without the path of its centre; default: 0.25.',
            'mm',
        ),
    ] = None,
    tolerance: Annotated[
        OptionalFloat,
        takes('MM', 'Greatest distance between arcs and cheeks; default: 1e-05.', 'mm'),
    ] = None,
    bore: Annotated[
        OptionalFloat, takes('MM', 'Diameter of the bore; default: half the cusp.', 'mm')
    ] = None,
    pins: Annotated[
        OptionalFloat, takes('MM', 'Diameter of the pin holes; default: 0.3 cusps.', 'mm')
    ] = None,
    pin_circle: Annotated[
        OptionalFloat, takes('MM', 'Distance of pins from the axle; default: 0.65 cusps.', 'mm')
    ] = None,
    slot: Annotated[
        OptionalFloat, takes('MM', 'Depth of the slot; default: 0.3 cusps.', 'mm')
    ] = None,
    thickness: Annotated[
        OptionalFloat, takes('MM', 'Thickness of the plate, for solids; default: 2.', 'mm')
    ] = None,
    settings: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Look at a cam's curve, draw it, or turn it into a plate.

    The frame turns with the wheel, its origin is the axle, +y points along the thread at rest. Of
    a curve in a fluid the origin is its lowest point, +y points upwards, and descents begin at
    x > 0. A few points of one cheek or branch are printed where no file is written. Files that
    exist are replaced.

    Both cheeks are the edge of a plate, closed by an arc about the axle, with a slot for the
    thread, a bore and two pin holes. Lengths that are left out are multiples of the distance from
    the cusp to the axle. The sizes of the plate are printed, and its cost in s/day at several
    amplitudes, on land.

    --step and --stl need the extra `cad`. The rim of the wheel is chosen so that all three solids
    together, in brass, have the moment of inertia of the scene.
    """
    from tauto_core.api import cam as make_cam

    files = {'csv': csv, 'svg': svg, 'dxf': dxf, 'template': template, 'step': step, 'stl': stl}
    is_read = not any(files.values()) and not plate
    with progress_bar('cam'):
        made = make_cam(
            scene,
            **files,
            plate=plate,
            points=SHOWN if is_read else points,
            reach_rad=reach,
            thread_mm=thread,
            cutter_mm=cutter,
            tolerance_mm=tolerance,
            bore_mm=bore,
            pins_mm=pins,
            pin_circle_mm=pin_circle,
            slot_mm=slot,
            thickness_mm=thickness,
            **given_values(settings),
        )
    wheel = made.scene.trochlea
    if reach is None and wheel is not None:
        say(
            f'the cheeks end at {made.reach_rad:.4g} rad, for a wheel released at '
            f'{abs(wheel.release_angle):g} rad; --reach asks for another end'
        )
    if made.meeting_rad is not None:
        say(
            f'the cheeks cross at {made.meeting_rad:.4g} rad and cannot be cut from one plate '
            'beyond it: give a smaller --reach'
        )
    if made.acts_from_rad is not None and made.plate is None:
        say(f'a thread of {thread:g} mm bends round the edges up to {made.acts_from_rad:.4g} rad')
    for file in made.files:
        say(f'wrote {file}')
    if as_json:
        typer.echo(json.dumps(made.facts(), allow_nan=False))
    elif made.plate is not None:
        typer.echo('\n'.join(made.plate.words()))
        rates = made.plate.rates
        typer.echo('amplitude   rounded cusp   as drawn   1 µm too deep   [rad, s/day]')
        for amplitude, *cost in zip(
            rates.amplitude_rad, rates.edge, rates.outline, rates.one_micrometre, strict=True
        ):
            cells = [significant(each, 2, signed=True) for each in cost]
            typer.echo('{:9.4g}   {:>12}   {:>8}   {:>13}'.format(amplitude, *cells))
    elif is_read:
        columns = made.columns()
        widths = [max(len(name), 12) for name in columns]
        figures = zip(*(column.tolist() for column in columns.values()), strict=True)
        # A tenth of a micrometre, which no cutter keeps; --csv has all digits. Figures for
        # other programs: a hyphen is the minus that they read.
        for row in (columns, *([f'{value:z.4f}' for value in row] for row in figures)):
            shown = zip(row, widths, strict=True)
            typer.echo('  '.join(f'{cell:>{width}}' for cell, width in shown))


# -----------------------------------------------------------------------------
# `tauto design`: from a wanted period to cam, pull or wheel, and back.

SizeText: TypeAlias = str | None
"""A number in the unit that another option names, or one with a unit."""


def design(
    period: Annotated[OptionalFloat, takes('S', 'Period of a full swing [s].', 's')] = None,
    pendulum: Annotated[
        SizeText, takes('LENGTH', 'Or of a simple pendulum of this length.')
    ] = None,
    inertia: Annotated[
        OptionalFloat, takes('KGM2', "The wheel's moment of inertia [kg m2].", 'kg m2')
    ] = None,
    disc_weight: Annotated[
        SizeText, takes('WEIGHT', 'Or its weight, if it is a uniform disc,')
    ] = None,
    disc_radius: Annotated[SizeText, takes('LENGTH', 'and its radius.')] = None,
    disc_is_base: Annotated[
        bool, typer.Option('--disc-is-base', help="The disc's radius is the base radius (XX).")
    ] = False,
    pull: Annotated[SizeText, takes('WEIGHT', 'Pull in the thread, without inertia.')] = None,
    base_radius: Annotated[
        SizeText, takes('LENGTH', "Base radius of the involute; a hole's rate.")
    ] = None,
    length_unit: Annotated[
        str, takes('UNIT', 'm, mm, scruple, rhenish_foot, line or paris_foot.')
    ] = 'm',
    weight_unit: Annotated[str, takes('UNIT', 'N, kg or pound (of Paris).')] = 'N',
    gravity: Annotated[
        float, takes('G', 'Acceleration of gravity [m/s2].', 'm/s2')
    ] = STANDARD_GRAVITY,
    as_json: AsJson = False,
) -> None:
    """Find the missing number in the design of a wheel and its cam.

    Of period, moment of inertia, pull and base radius three give the fourth (Euler 1727, XIX-XXI).
    A disc counts as two numbers, weight and radius, one of which may be the missing one.

    LENGTH and WEIGHT are in --length-unit and --weight-unit, or have a unit, as `5 mm`, `3 N` or
    `300 g`.
    """
    from tauto_core.machines import design as rules

    sizes = {
        'period': period,
        'pendulum': pendulum,
        'inertia': inertia,
        'disc_weight': disc_weight,
        'disc_radius': disc_radius,
        'pull': pull,
        'base_radius': base_radius,
    }
    found = rules.wheel_design(
        sizes,
        disc_is_base=disc_is_base,
        length_unit=length_unit,
        weight_unit=weight_unit,
        gravity=gravity,
    )
    facts = {name: value for name, value in asdict(found).items() if value is not None}
    if as_json:
        typer.echo(json.dumps(facts, allow_nan=False))
        return
    metres, newtons = rules.units(length_unit, weight_unit, gravity)
    printed = (  # the longest ending first: gravity's is that of a length, too
        ('_kg_m2', 'kg m2', 1.0),
        ('_m_s2', 'm/s2', 1.0),
        ('_s', 's', 1.0),
        ('_m', length_unit, metres),
        ('_n', weight_unit, newtons),
    )
    for key, value in facts.items():
        ending, unit, size = next(each for each in printed if key.endswith(each[0]))
        # Six digits: a micrometre in a metre, and 0.05 s/day of the period; --json has all.
        typer.echo(f'{key.removesuffix(ending).replace("_", " "):14} {value / size:.6g} {unit}')


# -----------------------------------------------------------------------------
# `tauto isochronism`: how well a regulator keeps one period at every amplitude.


def isochronism(
    scene: SceneName,
    amplitudes: Annotated[
        str,
        takes(
            'A,B,…',
            'Amplitudes of the free swings [rad], such as 0.2,0.6,1; of a body in a fluid [m].',
        ),
    ],
    settings: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Print period and rate against amplitude, on land.

    Drag and escapement are left out, so that the swings are free.

    A body in a fluid also has a time of descent. Its amplitude is the arc of the release, and its
    period is the time to the turning point on the other side and back.
    """
    from tauto_core.machines import free_swings
    from tauto_core.scene import load_scene

    loaded = load_scene(scene, **given_values(settings))
    unit = 'rad' if loaded.regulator is None else 'm'
    words = 'radians (metres in a fluid)'
    asked = listed('--amplitudes =', amplitudes, unit, words, '0.1,0.5,1')
    with naming(scene, loaded.name):
        found = free_swings(loaded, asked, loaded.clock.nominal_period)
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


# -----------------------------------------------------------------------------
# `tauto euler`: every claim of Euler's papers, checked.

_NARROWEST = 60
_INDENT = ' ' * 23


def euler(
    page: Annotated[
        Path | None, takes('DIR', 'Write DIR/euler.md and DIR/figures/*.svg instead of the list.')
    ] = None,
    site: Annotated[
        Path | None, takes('DIR', 'Write an interactive page for each paper, DIR/*.html, instead.')
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Check the claims of Euler's papers by computation.

    Exit code 1 if a claim that should hold fails, or one that should fail holds.
    """
    from tauto_core.euler.page import all_claims, summary

    claims = all_claims()
    if page is not None:
        from tauto_core.euler.page import write_page

        for file in write_page(page, claims):
            typer.echo(f'wrote {file}', err=True)
    if site is not None:
        from tauto_core.euler.site import write_site

        for file in write_site(site, claims):
            typer.echo(f'wrote {file}', err=True)
    if as_json:
        typer.echo(json.dumps({'claims': list(map(claim_facts, claims))}, allow_nan=False))
    elif page is None and site is None:
        width = max(get_terminal_size().columns, _NARROWEST)
        for claim in claims:
            typer.echo('\n'.join(claim_lines(claim, width)))
        typer.echo('\n'.join(wrap(summary(claims), width)))
    wrong = [claim for claim in claims if claim.verdict != claim.expected]
    for claim in wrong:
        typer.echo(
            f'tauto: {claim.paper} §{claim.paragraph}, {claim.said}: {claim.verdict} '
            f'(off by {claim.difference:.3g}, tolerance {claim.tolerance:.3g}), should be '
            f'{claim.expected}. Look for the fault in what was computed',
            err=True,
        )
    if wrong:
        raise typer.Exit(1)


def claim_facts(claim: Claim) -> dict[str, Any]:
    """Return a claim as JSON; what cannot be evaluated is None."""
    return {
        'paper': claim.paper,
        'paragraph': claim.paragraph,
        'claim': claim.said,
        'stands': claim.stands or None,
        'value': claim.value if math.isfinite(claim.value) else None,
        'computed': claim.computed,
        'difference': claim.difference if math.isfinite(claim.difference) else None,
        'tolerance': claim.tolerance,
        'verdict': claim.verdict,
        'expected': claim.expected,
        'must': claim.must or None,
        'must_value': claim.must_value,
        'adds': claim.adds or None,
        'because': claim.reason or None,
    }


def claim_lines(claim: Claim, width: int) -> list[str]:
    """Return a claim in lines: words and verdict, the formula as it stands, and its fault."""
    head = f'{claim.paper} §{claim.paragraph}'
    words = f'{head:<12} {claim.verdict:<9} {claim.said}'
    lines = wrap(words, width, subsequent_indent=_INDENT)
    value = f' = {claim.value:.9g}' if math.isfinite(claim.value) else ''
    said = [f'as it stands: {claim.stands}{value}'] if claim.stands else []
    if claim.must:
        said.append(f'as it must be: {claim.must}')
    if claim.adds:
        said.append(f'Tauto adds: {claim.adds}' + ('' if claim.stands else value))
    said.append(f'computed: {claim.computed:.9g}')
    if math.isfinite(claim.difference):
        said.append(f'off by {claim.difference:.1e}')
    for words in ('; '.join(said), claim.reason):
        lines += wrap(words, width, initial_indent=_INDENT, subsequent_indent=_INDENT)
    return lines
