"""`tauto axle`: a body on a cylindrical axle, its lengths and its motion from any start."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tauto_core.cli.terminal import AsJson, say, takes
from tauto_core.scene.errors import UsageError
from tauto_core.scene.times import STANDARD_GRAVITY
from tauto_core.wording import printed

if TYPE_CHECKING:
    from tauto_core.machines.axle_pendulum import AxleClock

MOST_ROWS = 10_000


def axle(
    depth: Annotated[
        float,
        takes(
            'M',
            "c: depth of the centre of gravity below the axle's centre, or that of the "
            'rockers [m].',
            'm',
        ),
    ],
    gyration_radius: Annotated[
        float, takes('M', 'k: radius of gyration about the centre of gravity [m].', 'm')
    ],
    support: Annotated[str, takes('KIND', 'concave, plane, convex or cradle.')] = 'plane',
    support_radius: Annotated[
        float | None, takes('M', 'Radius of the support [m]; left out: plane.', 'm')
    ] = None,
    axle_radius: Annotated[
        float, takes('M', 'Radius of the axle, or of the rockers [m].', 'm')
    ] = 0.0,
    contact: Annotated[str, takes('KIND', 'smooth, rolling or coulomb.')] = 'smooth',
    friction: Annotated[
        float | None, takes('MU', 'Coefficient of friction; with coulomb.')
    ] = None,
    release_tilt: Annotated[
        float, takes('RAD', 'Tilt of the body at the start [rad].', 'rad')
    ] = 0.0,
    release_arc: Annotated[
        float | None,
        takes(
            'M',
            "Arc of a smooth axle's centre at the start [m]; left out: that of the regular "
            'motion.',
            'm',
        ),
    ] = None,
    push_speed: Annotated[
        float | None,
        takes('M/S', 'n: speed of the centre of gravity at the start [m/s] (§4).', 'm/s'),
    ] = None,
    push_spin: Annotated[
        float, takes('RAD/S', 'ν: angular velocity at the start [rad/s] (§4).', 'rad/s')
    ] = 0.0,
    duration: Annotated[float, takes('S', 'Length of the motion [s].', 's')] = 2.0,
    every: Annotated[float, takes('S', 'A row for each of these intervals [s].', 's')] = 0.1,
    gravity: Annotated[
        float, takes('G', 'Acceleration of gravity [m/s2].', 'm/s2')
    ] = STANDARD_GRAVITY,
    as_json: AsJson = False,
) -> None:
    """Compute the motion of a body on a cylindrical axle.

    The axle lies in a hollow, on a plane or on a convex support, or the body stands on the rockers
    of a cradle. The motion is exact from any start, until the axle lifts off. Without friction,
    Euler's case, there are two modes; an axle that rolls has one (§40).
    """
    from pydantic import ValidationError

    from tauto_core.machines.axle_pendulum import AxleRegulator
    from tauto_core.motion.axle import axle_table

    keys: dict[str, Any] = {
        'support': support,
        'support_radius': support_radius,
        'axle_radius': axle_radius,
        'depth': depth,
        'gyration_radius': gyration_radius,
        'contact': contact,
        'friction': friction,
        'release_tilt': release_tilt,
        'release_arc': release_arc,
        'push_speed': push_speed,
        'push_spin': push_spin,
    }
    try:
        body = AxleRegulator(kind='axle', **keys)
    except ValidationError as error:
        first = error.errors()[0]
        option = '--' + str(first['loc'][0]).replace('_', '-')
        raise UsageError(f'{option} = {first["input"]!r}: {first["msg"]}; give another') from None
    for problem in body.problems({}, 'still', still=True):
        option = '--' + problem.key.removeprefix('regulator.').replace('_', '-')
        raise UsageError(f'{option}: {problem.problem}. {problem.remedy}')
    for option, value in (('--gravity', gravity), ('--duration', duration), ('--every', every)):
        if not 0.0 < value < math.inf:
            raise UsageError(f'{option} = {value!r}: must be above 0 and finite; give another')
    if duration / every > MOST_ROWS:
        raise UsageError(
            f'--every = {every!r}: makes more than {MOST_ROWS} rows of {duration!r} s; give a '
            'longer interval'
        )
    clock = body.clock(gravity)
    table = axle_table(clock, duration, every)
    lengths = body_lengths(clock)
    if as_json:
        columns = {
            name: values.tolist() for name, values in asdict(table).items() if name[:5] != 'ends_'
        }
        facts = {
            **lengths,
            'ends_s': table.ends_s,
            'ends_why': table.ends_why or None,
            'rows': [
                dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
            ],
        }
        typer.echo(json.dumps(facts, allow_nan=False))
        return
    for name, length in lengths.items():
        if length is not None:
            words, _, unit = name.rpartition('_')
            typer.echo(f'{words.replace("_", " "):22} {length:.9g} {unit}')
    heads = ('time s', 'θ rad', 'φ rad', 's m', 'N/Mg', 'slip m/s', 'φ small')
    typer.echo('  '.join(f'{head:>10}' for head in heads))
    for row in zip(
        table.time_s, table.theta_rad, table.phi_rad, table.arc_m, table.contact, table.slip_m_s,
        table.small_phi_rad, strict=True,
    ):  # fmt: skip
        typer.echo('  '.join(f'{printed(float(value), "+z.6f"):>10}' for value in row))
    if table.ends_s is not None:
        say(f'after {table.ends_s:.6g} s {table.ends_why}')


def body_lengths(clock: AxleClock) -> dict[str, float | None]:
    """Return the lengths and periods of small swings, and the shapes of the modes.

    Names end in the unit. An axle that rolls has one length; a mode that drifts has none.
    """
    if clock.contact != 'smooth':
        length = clock.lengths[0]
        period = math.tau * math.sqrt(length / clock.body.gravity) if length > 0.0 else None
        return {'length_m': length, 'period_s': period}
    modes, found = clock.body.modes, {}
    shapes = modes.tilt_per_arc
    for name, length, shape in (('b', modes.b, shapes[0]), ('b_prime', modes.b_prime, shapes[1])):
        finite = math.isfinite(length)
        found[f'{name}_m'] = length if finite else None
        found[f'{name}_period_s'] = (
            math.tau * math.sqrt(length / clock.body.gravity) if finite and length > 0.0 else None
        )
        # φ : s, which a plane has too
        found[f'{name}_tilt_per_arc_rad/m'] = shape if math.isfinite(shape) else None
    return found
