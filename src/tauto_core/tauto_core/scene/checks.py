"""Rules that tie several keys of a scene together.

Each check yields `Problem`s with the path of the key at fault, the limit and the remedy.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from decimal import Decimal
from typing import TYPE_CHECKING

from tauto_core.scene.errors import ABSENT, Problem
from tauto_core.scene.times import exact_nanoseconds, exact_step

if TYPE_CHECKING:
    from tauto_core.scene.models import ComponentsShip, Recorded, RecordedShip, Scene, SeaShip

# builtin_interfaces/Time holds whole seconds in 32 bits, the sign among them.
LAST_STAMP_S = 2**31 - 1
# The ship sends up to four samples beyond the end.
SAMPLES_BEYOND_END = 4
# Half a rounding is 1.1e-16, and a step makes several; 1e-3 of a swing is minutes a day.
LEAST_TOLERANCE, LARGEST_TOLERANCE = 1e-15, 1e-3

THREADS_OF_CAM = {
    'involute': ('vertical', 'lever', 'hanging'),
    'hole': ('hole',),
    'circular_arc': ('vertical',),
    # A lever law makes a cam for either thread; a hole only turns the normal by arcsin(t/a).
    'table': ('vertical', 'hole'),
}


# What lifts a weight whose inertia is part of the motion.
REAL_THREADS = ('lever', 'hanging')


def problems(scene: Scene) -> Iterator[Problem]:
    """Yield everything that is wrong between the keys of a scene of valid sections."""
    yield from _machine(scene)
    grid = list(_whole_nanoseconds(scene))
    yield from grid
    if not grid:
        yield from _grids(scene)
    yield from _ship(scene)
    yield from _voyage(scene)
    yield from _solver(scene)


def _machine(scene: Scene) -> Iterator[Problem]:
    cam, thread = scene.trochlea.cam.kind, scene.trochlea.thread.kind
    fitting = THREADS_OF_CAM[cam]
    if thread not in fitting:
        cams = ', '.join(kind for kind, threads in THREADS_OF_CAM.items() if thread in threads)
        yield Problem(
            'trochlea.thread.kind',
            thread,
            f'does not go with trochlea.cam.kind {cam}',
            f'Use thread kind {" or ".join(fitting)}, or a cam of kind {cams}.',
        )
    if thread in REAL_THREADS:
        yield from _real_thread(scene, thread)
    if scene.ship.kind == 'still' and scene.trochlea.release_angle == 0.0:
        yield Problem(
            'trochlea.release_angle',
            0.0,
            'leaves the wheel at rest for ever on a ship that lies still',
            'Release it at an angle other than 0 rad.',
        )


def _real_thread(scene: Scene, thread: str) -> Iterator[Problem]:
    power = scene.trochlea.power
    if power.kind != 'weight':
        yield Problem(
            'trochlea.power.kind',
            power.kind,
            f'does not go with trochlea.thread.kind {thread}, which carries a weight',
            'Use power kind weight, or thread kind vertical.',
        )
    elif power.massless:
        yield Problem(
            'trochlea.power.massless',
            True,
            f'does not go with trochlea.thread.kind {thread}, where the weight moves the thread',
            'Leave it out, or use thread kind vertical.',
        )
    if scene.drag is not None and scene.drag.coulomb > 0.0:
        yield Problem(
            'drag.coulomb',
            scene.drag.coulomb,
            f'does not go with trochlea.thread.kind {thread}',
            'Use viscous or quadratic drag, or thread kind vertical or hole.',
        )


def _whole_nanoseconds(scene: Scene) -> Iterator[Problem]:
    times = {
        'starts_at': scene.starts_at,
        'duration': scene.duration,
        'log.interval': scene.log.interval,
        'drift.observation_interval': scene.drift.observation_interval,
    }
    for key, value in times.items():
        if exact_nanoseconds(value).denominator != 1:
            yield Problem(
                key,
                value,
                'is not a whole number of nanoseconds',
                'Give it to at most nine decimals.',
            )
    if scene.ship.kind == 'still':
        return
    step = exact_step(scene.ship.rate)
    if step.denominator != 1 or step < 1:
        whole = max(round(step), 1)
        yield Problem(
            'ship.rate',
            scene.ship.rate,
            f'makes steps of {float(step):.12g} ns, which must be whole nanoseconds',
            f'Use a rate that divides 1e9, for example {_near_rate(scene.ship.rate)} Hz, '
            f'or exactly 1e9/{whole}.',
        )


def _near_rate(rate_hz: float) -> float:
    """Return the nearest common sampling rate."""
    common = (0.1, 0.5, 1.0, 2.0, 4.0, 5.0, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 32.0, 40.0, 50.0)
    fast = (64.0, 80.0, 100.0, 125.0, 128.0, 160.0, 200.0, 250.0, 400.0, 500.0, 1000.0)
    return min((*common, *fast), key=lambda near: abs(math.log(near / rate_hz)))


def _grids(scene: Scene) -> Iterator[Problem]:
    interval_ns, step_ns = scene.log_interval_ns, scene.step_ns
    interval = scene.log.interval
    if interval_ns % step_ns:
        yield Problem(
            'log.interval',
            interval,
            f'is not a whole number of steps of {Decimal(step_ns) / 10**9:.12g} s (ship.rate '
            f'{scene.ship.rate!r} Hz)',
            f'Use {_multiple(interval_ns, step_ns)}.',
        )
    for key, value, value_ns in (
        ('duration', scene.duration, scene.duration_ns),
        (
            'drift.observation_interval',
            scene.drift.observation_interval,
            round(exact_nanoseconds(scene.drift.observation_interval)),
        ),
    ):
        if value_ns % interval_ns:
            yield Problem(
                key,
                value,
                f'is not a whole number of log intervals (log.interval {interval!r} s)',
                f'Use {_multiple(value_ns, interval_ns)}, or change log.interval.',
            )
    end_ns = scene.starts_at_ns + scene.duration_ns + SAMPLES_BEYOND_END * step_ns
    if end_ns > LAST_STAMP_S * 10**9:
        yield Problem(
            'duration',
            scene.duration,
            f'ends at {Decimal(end_ns) / 10**9:.12g} s with the {SAMPLES_BEYOND_END} steps beyond '
            f'the end; ROS stamps end at {LAST_STAMP_S} s',
            'Shorten it, or let starts_at be earlier.',
        )


def _multiple(value_ns: int, grid_ns: int) -> str:
    below = value_ns // grid_ns * grid_ns
    near = [f'{Decimal(ns) / 10**9:.15g}' for ns in (below, below + grid_ns) if ns]
    return ' or '.join(near) + ' s'


def _ship(scene: Scene) -> Iterator[Problem]:
    ship = scene.ship
    if ship.kind == 'components':
        yield from _components(ship)
    elif ship.kind == 'sea':
        yield from _sea(ship)
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
            yield from _sampled(f'ship.{name}[{index}].period', component.period, ship.rate)
    total = math.fsum(component.amplitude for component in ship.components)
    if total >= math.pi / 2:
        yield Problem(
            'ship.components',
            total,
            'is the sum of the amplitudes [rad], which must be less than π/2: the ship capsizes',
            'Give amplitudes in radians, not degrees.',
        )


def _sampled(key: str, period: float, rate_hz: float) -> Iterator[Problem]:
    if period * rate_hz <= 2.0:
        yield Problem(
            key,
            period,
            f'is not longer than two steps ({2.0 / rate_hz:.6g} s): ship.rate {rate_hz!r} Hz '
            'cannot sample it',
            'Give a longer period or a higher ship.rate.',
        )


def _sea(ship: SeaShip) -> Iterator[Problem]:
    yield from _sampled('ship.sea.peak_period', ship.sea.peak_period, ship.rate)
    if ship.sea.spectrum == 'bretschneider' and 'gamma' in ship.sea.model_fields_set:
        yield Problem(
            'ship.sea.gamma',
            ship.sea.gamma,
            'does not go with spectrum bretschneider, which has no peak enhancement',
            'Leave it out, or use spectrum jonswap.',
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


def _voyage(scene: Scene) -> Iterator[Problem]:
    voyage = scene.voyage
    if voyage is not None and voyage.arrives_at <= voyage.sails_at:
        yield Problem(
            'voyage.arrives_at',
            voyage.arrives_at,
            f'must be later than voyage.sails_at, {voyage.sails_at!r} s',
            'Give both from the start of the scene, in the order of the voyage.',
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
