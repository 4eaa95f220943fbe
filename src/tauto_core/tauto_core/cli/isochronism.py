"""`tauto isochronism`: how well a regulator keeps one period at every amplitude."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from tauto_core.cli.options import AsJson, SceneName, Settings, given_values
from tauto_core.scene.errors import UsageError, naming


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
