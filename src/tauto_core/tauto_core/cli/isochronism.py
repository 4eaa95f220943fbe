"""`tauto isochronism`: how well a regulator keeps one period at every amplitude."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

from tauto_core.cli.options import AsJson, SceneName, Settings, given_values
from tauto_core.scene.errors import UsageError, naming

if TYPE_CHECKING:
    from tauto_core.machines import Isochronism
    from tauto_core.machines.fluid_pendulum import DescentIsochronism


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
    from tauto_core import machines
    from tauto_core.scene import load_scene

    loaded = load_scene(scene, **given_values(settings))
    if loaded.regulator is not None:
        from tauto_core.machines.fluid_regulator import compile_fluid_pendulum

        with naming(scene, loaded.name):
            pendulum = compile_fluid_pendulum(loaded.name, loaded.gravity, loaded.regulator)
        numbers, nominal = _numbers(amplitudes), loaded.clock.nominal_period
        descents = machines.descent_isochronism(pendulum, numbers, nominal)
        typer.echo(json.dumps(descents, allow_nan=False)) if as_json else _print_descents(descents)
        return
    with naming(scene, loaded.name):
        machine = machines.compile_trochlea(loaded)
    numbers, nominal = _numbers(amplitudes), loaded.clock.nominal_period
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
