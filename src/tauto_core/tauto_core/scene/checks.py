"""Rules that tie several keys of a scene together.

Each check yields `Problem`s with the path of the key at fault, the limit and the remedy.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from decimal import Decimal
from typing import TYPE_CHECKING

from tauto_core.scene.errors import ABSENT, Problem
from tauto_core.scene.magnitudes import out_of_proportion
from tauto_core.scene.sea_checks import sampled, sea_problems
from tauto_core.scene.times import exact_nanoseconds, exact_step
from tauto_core.scene.voyages import voyage_problems

if TYPE_CHECKING:
    from tauto_core.scene.models import Scene
    from tauto_core.scene.regulators import FluidTautochroneRegulator, Trochlea
    from tauto_core.scene.ships import ComponentsShip, Recorded, RecordedShip

# builtin_interfaces/Time holds whole seconds in 32 bits, the sign among them.
LAST_STAMP_S = 2**31 - 1
# Interpolation of the motion reaches so many samples beyond its end.
LOOKAHEAD = 4
# Half a rounding is 1.1e-16, and a step makes several; 1e-3 of a swing is minutes a day.
LEAST_TOLERANCE, LARGEST_TOLERANCE = 1e-15, 1e-3

THREADS_OF_CAM = {
    'involute': ('vertical', 'lever', 'hanging'),
    'hole': ('hole',),
    'circular_arc': ('vertical',),
    # A lever law makes a cam for either thread; a hole only turns the normal by arcsin(t/a).
    'table': ('vertical', 'hole'),
    'weight_corrected': ('vertical', 'hole'),
    'spring_corrected': ('vertical', 'hole'),
    'lever_corrected': ('lever',),
}
# What a corrected cam corrects.
POWER_OF_CAM = {'weight_corrected': 'weight', 'spring_corrected': 'spring'}


def samples_beyond_end(scene: Scene) -> int:
    """Return how many samples beyond the end a ship that moves sends.

    A suspension looks ahead itself, and the clock in it looks ahead in what it says.
    """
    return LOOKAHEAD if scene.suspension is None else 2 * LOOKAHEAD


# What lifts a weight whose inertia is part of the motion.
REAL_THREADS = ('lever', 'hanging')


def problems(scene: Scene) -> Iterator[Problem]:
    """Yield everything that is wrong between the keys of a scene of valid sections."""
    yield from out_of_proportion(scene)
    if scene.regulator is not None:
        yield from _in_fluid(scene, scene.regulator)
    if scene.trochlea is not None:
        yield from _machine(scene, scene.trochlea)
    if scene.trochlea is None and scene.regulator is None:
        yield Problem(
            'trochlea',
            ABSENT,
            'is missing, and there is no regulator in its place',
            'Write `trochlea: …`, mapping: inertia, cam, thread, power, release_angle; or '
            '`regulator: …`, mapping with `kind`.',
        )
    grid = list(_whole_nanoseconds(scene))
    yield from grid
    if not grid:
        yield from _grids(scene)
    yield from _ship(scene)
    yield from _suspension(scene)
    yield from voyage_problems(scene)
    yield from _solver(scene)


def _in_fluid(scene: Scene, regulator: FluidTautochroneRegulator) -> Iterator[Problem]:
    given = {
        'trochlea': 'a scene has one regulator',
        'drag': 'the fluid is the drag',
        'escapement': 'nothing drives a body in a fluid',
        'suspension': "in Euler's equations curve and fluid are at rest",
    }
    for key, why in given.items():
        if getattr(scene, key, None) is not None:
            remedy = f'Leave out {key}, or take a trochlea instead of the regulator.'
            yield Problem(key, ABSENT, f'does not go with regulator: {why}', remedy)
    if scene.ship.kind != 'still':
        yield Problem(
            'ship.kind',
            scene.ship.kind,
            "does not go with regulator: in Euler's equations curve and fluid are at rest",
            'Use ship kind still.',
        )
    if regulator.fluid_density >= regulator.body_density:
        yield Problem(
            'regulator.fluid_density',
            regulator.fluid_density,
            f'must be less than regulator.body_density, {regulator.body_density!r} kg/m3, or the '
            f'{regulator.body} does not sink',
            'Take a denser body or a lighter fluid.',
        )
    if regulator.release_arc == 0.0:
        yield Problem(
            'regulator.release_arc',
            0.0,
            'leaves the body at rest for ever',
            'Release it at an arc other than 0 m.',
        )


def _machine(scene: Scene, trochlea: Trochlea) -> Iterator[Problem]:
    cam, thread = trochlea.cam.kind, trochlea.thread.kind
    fitting = THREADS_OF_CAM[cam]
    if thread not in fitting:
        cams = ', '.join(kind for kind, threads in THREADS_OF_CAM.items() if thread in threads)
        yield Problem(
            'trochlea.thread.kind',
            thread,
            f'does not go with trochlea.cam.kind {cam}',
            f'Use thread kind {" or ".join(fitting)}, or a cam of kind {cams}.',
        )
    yield from _corrected(scene, trochlea)
    if thread in REAL_THREADS:
        yield from _real_thread(scene, trochlea)
    if scene.ship.kind == 'still' and trochlea.release_angle == 0.0:
        yield Problem(
            'trochlea.release_angle',
            0.0,
            'leaves the wheel at rest for ever on a ship that lies still',
            'Release it at an angle other than 0 rad.',
        )


def _corrected(scene: Scene, trochlea: Trochlea) -> Iterator[Problem]:
    """Yield what is wrong with the power of a cam that is made for one kind of it."""
    cam, power = trochlea.cam, trochlea.power
    if cam.kind not in POWER_OF_CAM or not hasattr(cam, 'period'):
        return
    weightless = power.kind == 'weight' and power.massless
    if power.kind == POWER_OF_CAM[cam.kind] and not weightless:
        return
    pull = power.mass * scene.gravity if power.kind == 'weight' else power.force
    omega = math.tau / cam.period
    rate = trochlea.inertia * omega * omega / pull
    plain = (
        f'cam {{kind: involute, base_radius: {rate:.6g}}}'
        if trochlea.thread.kind == 'vertical'
        else f'cam {{kind: hole, lever_rate: {rate:.6g}}}'
    )
    others = {
        'weight': 'a weight whose inertia counts needs cam kind weight_corrected',
        'spring': 'a spring needs cam kind spring_corrected',
        'force': f'a pull without inertia or stiffness needs {plain}',
    }
    yield Problem(
        'trochlea.power.massless' if weightless else 'trochlea.power.kind',
        True if weightless else power.kind,
        f'does not go with trochlea.cam.kind {cam.kind}, which is made for power kind '
        f'{POWER_OF_CAM[cam.kind]}',
        f'For the period of {cam.period!r} s {others["force" if weightless else power.kind]}.',
    )


def _real_thread(scene: Scene, trochlea: Trochlea) -> Iterator[Problem]:
    thread, power = trochlea.thread.kind, trochlea.power
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
    beyond = samples_beyond_end(scene)
    end_ns = scene.starts_at_ns + scene.duration_ns + beyond * step_ns
    if end_ns > LAST_STAMP_S * 10**9:
        yield Problem(
            'duration',
            scene.duration,
            f'ends at {Decimal(end_ns) / 10**9:.12g} s with the {beyond} steps beyond '
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
