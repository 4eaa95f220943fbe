"""`tauto plate`: the cam as a plate to cut, to print, and to build a wheel with."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from tauto_core.cli.terminal import (
    AsJson,
    SceneName,
    Settings,
    given_values,
    measured,
    progress_bar,
    say,
)
from tauto_core.wording import significant

Size: TypeAlias = float | None
File: TypeAlias = Path | None


def plate(
    scene: SceneName,
    dxf: Annotated[
        File, typer.Option(metavar='FILE', help='Draw it for the machine; replaces the file.')
    ] = None,
    template: Annotated[
        File,
        typer.Option(
            metavar='FILE',
            help='Draw it to scale on A4 (.svg), large ones on several sheets; replaces the file.',
        ),
    ] = None,
    step: Annotated[
        File,
        typer.Option(
            metavar='FILE', help='Write wheel, cheeks and axle as solids; replaces the file.'
        ),
    ] = None,
    stl: Annotated[
        File,
        typer.Option(
            metavar='DIR', help='Write DIR/wheel.stl, cheeks.stl and axle.stl; replaces them.'
        ),
    ] = None,
    thread: Annotated[
        float,
        typer.Option(
            metavar='MM',
            parser=measured('mm'),
            help='Thickness of the thread, and width of its slot.',
        ),
    ] = 0.5,
    cutter: Annotated[
        float,
        typer.Option(
            metavar='MM',
            parser=measured('mm'),
            help='Diameter of the cutter, or kerf; 0: without the path of its centre.',
        ),
    ] = 0.25,
    tolerance: Annotated[
        float,
        typer.Option(
            metavar='MM', parser=measured('mm'), help='Greatest distance between arcs and cheeks.'
        ),
    ] = 1e-5,
    reach: Annotated[
        Size,
        typer.Option(
            metavar='RAD',
            parser=measured('rad'),
            help='Largest angle of the cheeks; default: as `cam`.',
        ),
    ] = None,
    bore: Annotated[
        Size,
        typer.Option(
            metavar='MM',
            parser=measured('mm'),
            help='Diameter of the bore; default: half the cusp.',
        ),
    ] = None,
    pins: Annotated[
        Size,
        typer.Option(
            metavar='MM',
            parser=measured('mm'),
            help='Diameter of the pin holes; default: 0.3 cusps.',
        ),
    ] = None,
    pin_circle: Annotated[
        Size,
        typer.Option(
            metavar='MM',
            parser=measured('mm'),
            help='Distance of pins from the axle; default: 0.65 cusps.',
        ),
    ] = None,
    slot: Annotated[
        Size,
        typer.Option(
            metavar='MM', parser=measured('mm'), help='Depth of the slot; default: 0.3 cusps.'
        ),
    ] = None,
    thickness: Annotated[
        float,
        typer.Option(
            metavar='MM',
            parser=measured('mm'),
            help='Thickness of the plate, for --step and --stl.',
        ),
    ] = 2.0,
    settings: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Turn the cam into a plate to cut or to print.

    Both cheeks are the edge of one plate, closed by an arc about the axle, with a slot for the
    thread, a bore and two pin holes. Lengths that are left out are multiples of the distance from
    the cusp to the axle. The command prints the sizes of the plate and its cost in s/day at
    several amplitudes, on land.

    --step and --stl need the extra `cad`. The rim of the wheel is chosen so that all three solids
    together, in brass, have the moment of inertia of the scene.
    """
    from tauto_core.api import plate as make_plate

    with progress_bar('plate'):
        made = make_plate(
            scene,
            dxf=dxf,
            template=template,
            step=step,
            stl=stl,
            thread_mm=thread,
            cutter_mm=cutter,
            tolerance_mm=tolerance,
            reach_rad=reach,
            bore_mm=bore,
            pins_mm=pins,
            pin_circle_mm=pin_circle,
            slot_mm=slot,
            thickness_mm=thickness,
            **given_values(settings),
        )
    for file in made.files:
        say(f'wrote {file}')
    if as_json:
        typer.echo(json.dumps(made.facts(), allow_nan=False))
        return
    typer.echo('\n'.join(made.words()))
    rates = made.rates
    typer.echo('amplitude   rounded cusp   as drawn   1 µm too deep   [rad, s/day]')
    for amplitude, *cost in zip(
        rates.amplitude_rad, rates.edge, rates.outline, rates.one_micrometre, strict=True
    ):
        cells = [significant(each, 2, signed=True) for each in cost]
        typer.echo('{:9.4g}   {:>12}   {:>8}   {:>13}'.format(amplitude, *cells))
