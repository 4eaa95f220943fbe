"""Rules that tie several keys of a scene together.

Each check yields `Problem`s with the path of the key at fault, the limit and the remedy.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from tauto_core.scene.errors import ABSENT, Problem
from tauto_core.scene.machine_checks import regulator_problems
from tauto_core.scene.magnitudes import out_of_proportion
from tauto_core.scene.sea_checks import sampled, sea_problems
from tauto_core.scene.time_checks import time_problems
from tauto_core.scene.voyages import voyage_problems

if TYPE_CHECKING:
    from tauto_core.scene.models import Scene
    from tauto_core.scene.ships import ComponentsShip, Recorded, RecordedShip

# Half a rounding is 1.1e-16, and a step makes several; 1e-3 of a swing is minutes a day.
LEAST_TOLERANCE, LARGEST_TOLERANCE = 1e-15, 1e-3


def problems(scene: Scene) -> Iterator[Problem]:
    """Yield everything that is wrong between the keys of a scene of valid sections."""
    yield from out_of_proportion(scene)
    yield from regulator_problems(scene)
    yield from time_problems(scene)
    yield from _ship(scene)
    yield from _suspension(scene)
    yield from voyage_problems(scene)
    yield from _solver(scene)


def _ship(scene: Scene) -> Iterator[Problem]:
    ship = scene.ship
    if ship.kind == 'components':
        yield from _components(ship)
    elif ship.kind == 'sea':
        yield from sea_problems(ship)
    elif ship.kind == 'recorded':
        yield from _recorded(ship)


def _components(ship: ComponentsShip) -> Iterator[Problem]:
    if not ship.components and ship.heave is None:
        yield Problem(
            'ship.components',
            list(ship.components),
            'has no component, and there is no heave: nothing moves',
            'Give at least one {amplitude, period, phase}, or use kind still.',
        )
    for name, components in (('components', ship.components), ('heave', ship.heave or ())):
        for index, component in enumerate(components):
            yield from sampled(f'ship.{name}[{index}].period', component.period, ship.rate)
    total = math.fsum(component.amplitude for component in ship.components)
    if total >= math.pi / 2:
        yield Problem(
            'ship.components',
            total,
            'is the sum of the amplitudes [rad], which must be less than π/2: the ship capsizes',
            'Give amplitudes in radians, not degrees.',
        )


def _recorded(ship: RecordedShip) -> Iterator[Problem]:
    recorded = ship.recorded
    yield from _source(recorded)
    low, high = recorded.passband
    band = list(recorded.passband)
    if low >= high:
        yield Problem(
            'ship.recorded.passband',
            band,
            'must rise from the lowest to the highest frequency [Hz]',
            f'Use [{min(low, high)!r}, {max(low, high)!r}].'
            if low > high
            else 'Give two different frequencies, for example [0.02, 0.4].',
        )
    if max(low, high) >= ship.rate / 2.0:
        yield Problem(
            'ship.recorded.passband',
            band,
            f'must lie below half of ship.rate, {ship.rate / 2.0:.6g} Hz',
            'Lower its upper edge or raise ship.rate.',
        )
    if recorded.scale == 0.0:
        yield Problem(
            'ship.recorded.scale',
            recorded.scale,
            'must not be 0: nothing moves',
            'Use 1.0 for the motion as measured, or ship kind still.',
        )


def _source(recorded: Recorded) -> Iterator[Problem]:
    columns = {
        'time_column': recorded.time_column,
        'roll_column': recorded.roll_column,
        'heave_column': recorded.heave_column,
    }
    if recorded.topic is not None:
        for key, column in columns.items():
            if column is not None:
                yield Problem(
                    f'ship.recorded.{key}',
                    column,
                    'names a CSV column, but topic says that path is a bag',
                    'Leave out topic for a CSV, the columns for a bag.',
                )
        if recorded.scale not in (0.0, 1.0):
            yield Problem(
                'ship.recorded.scale',
                recorded.scale,
                'does not go with a bag: a measured specific force holds gravity and cannot be '
                'scaled',
                'Use 1.0, or a CSV of roll and heave.',
            )
        return
    for key in ('time_column', 'roll_column'):
        if columns[key] is None:
            yield Problem(
                f'ship.recorded.{key}',
                ABSENT,
                'is missing',
                'Name the column with its unit, for example t_s and roll_deg; '
                'for a bag give topic instead.',
            )


def _suspension(scene: Scene) -> Iterator[Problem]:
    hung = scene.suspension
    if hung is None:
        return
    if scene.ship.kind == 'still':
        yield Problem(
            'suspension',
            hung.kind,
            'has nothing to do on a ship that lies still: the case hangs at rest',
            'Leave it out, or let the ship move.',
        )
    if hung.support_radius <= hung.axle_radius:
        yield Problem(
            'suspension.support_radius',
            hung.support_radius,
            f'must be larger than suspension.axle_radius, {hung.axle_radius!r} m: on a bearing '
            'that is no hollow b′ is negative, and the case falls from it',
            f'Use for example {2.0 * hung.axle_radius!r}, or a thinner axle.',
        )
    if hung.depth <= 0.0:
        below = -hung.depth or hung.gyration_radius
        yield Problem(
            'suspension.depth',
            hung.depth,
            'must be greater than 0: a case whose centre of gravity does not hang below its axle '
            'topples',
            f'Use for example {abs(below) or 0.1!r}: positive is below the axle.',
        )
    if hung.gyration_radius <= 0.0:
        yield Problem(
            'suspension.gyration_radius',
            hung.gyration_radius,
            'must be greater than 0: a case without extent turns in no time (b′ = 0)',
            f'Use for example {0.5 * abs(hung.depth) or 0.05!r}.',
        )


def _solver(scene: Scene) -> Iterator[Problem]:
    tolerance = None if scene.solver is None else scene.solver.tolerance
    if tolerance is None or LEAST_TOLERANCE <= tolerance <= LARGEST_TOLERANCE:
        return
    if tolerance < LEAST_TOLERANCE:
        yield Problem(
            'solver.tolerance',
            tolerance,
            f'is below {LEAST_TOLERANCE:g}, the rounding of double precision, which no step '
            'can meet',
            f'Leave it out, or use {LEAST_TOLERANCE:g}.',
        )
    else:
        yield Problem(
            'solver.tolerance',
            tolerance,
            f'must be at most {LARGEST_TOLERANCE:g} of the swing in one step',
            f'Leave it out, or use {LARGEST_TOLERANCE:g}.',
        )
