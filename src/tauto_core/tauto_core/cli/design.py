"""`tauto design`: from a wanted period to cam, pull or wheel, and back."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

from tauto_core.cli.options import AsJson
from tauto_core.scene.constants import STANDARD_GRAVITY
from tauto_core.scene.errors import UsageError

if TYPE_CHECKING:
    from tauto_core.machines.design import Design

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
