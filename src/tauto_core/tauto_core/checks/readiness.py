"""Whether a scene is plausible and can run: checks that need machine, dial and ship together."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tauto_core.clockwork.trochlea import stale_dial
from tauto_core.machines import (
    AnyMachine,
    HangingMachine,
    LeverMachine,
    Machine,
    OtherRegulator,
    QuadratureError,
    compile_machine,
)
from tauto_core.motion import make_propagator, propagator_name
from tauto_core.scene import Scene
from tauto_core.scene.errors import (
    ABSENT,
    Argument,
    ArgumentText,
    DescentError,
    Problem,
    PropagationError,
    SceneError,
)
from tauto_core.scene.times import DAY_S, LAST_STAMP_S
from tauto_core.ship import Passage, ShipMotion
from tauto_core.ship.buffer import sensed_parts
from tauto_core.ship.imu import attitude
from tauto_core.wording import span

if TYPE_CHECKING:
    from tauto_core.machines import FluidPendulum


# -----------------------------------------------------------------------------
# Warnings for numbers that are possible but probably in the wrong unit. The worst are refused.
#
# The bounds are about an order of magnitude outside the built-in scenes, the machines of Sully,
# Harrison and Euler, watches (a balance of 1e-9 kg m2 that swings by 5 rad) and tower clocks.
# Machines, gravity and ships above these limits need `anyway`: they are untested and may take
# minutes. Smaller ones are safe, and so are a passage, a log or observations of any size: these
# only cause a warning. `magnitudes` refuses numbers that doubles cannot compute with.

_LENGTH = (('millimetres', 1e-3), ('centimetres', 1e-2), ('inches', 0.0254), ('feet', 0.3048))
_MASS = (('grams', 1e-3), ('pounds', 0.45359237))
_TIME = (('milliseconds', 1e-3), ('minutes', 60.0), ('hours', 3600.0), ('days', DAY_S))
_ANGLE = (('degrees', math.pi / 180.0),)
_INERTIA = (('kg cm2', 1e-4), ('kg mm2', 1e-6), ('g cm2', 1e-7))
_FORCE = (('millinewtons', 1e-3), ('grams-force', 9.80665e-3))
_RATE = (('samples a minute', 1.0 / 60.0),)


class _Sizes(NamedTuple):
    """The range of a key in existing machines and voyages. 0 is always allowed."""

    low: float
    high: float
    unit: str
    slips: tuple[tuple[str, float], ...]


_SIZES = {
    key: _Sizes(low, high, unit, slips)
    for key, low, high, unit, slips in (
        ('duration', 10.0, 400.0 * DAY_S, 's', _TIME),
        ('gravity', 1.0, 30.0, 'm/s2', (('cm/s2', 1e-2), ('feet/s2', 0.3048))),
        ('trochlea.inertia', 1e-10, 1.0, 'kg m2', _INERTIA),
        ('trochlea.cam.base_radius', 1e-4, 0.5, 'm', _LENGTH),
        ('trochlea.cam.lever_rate', 1e-4, 0.5, 'm/rad', _LENGTH),
        ('trochlea.cam.radius', 2e-4, 1.0, 'm', _LENGTH),
        ('trochlea.cam.root_depth', 1e-4, 0.5, 'm', _LENGTH),
        ('trochlea.cam.period', 0.05, 20.0, 's', _TIME),
        ('trochlea.thread.distance', 2e-3, 5.0, 'm', _LENGTH),
        ('trochlea.thread.arm', 2e-3, 5.0, 'm', _LENGTH),
        ('trochlea.thread.arc', 2e-3, 5.0, 'm', _LENGTH),
        ('trochlea.thread.tail.mass', 1e-5, 50.0, 'kg', _MASS),
        ('trochlea.thread.tail.distance', 2e-3, 5.0, 'm', _LENGTH),
        ('trochlea.thread.weight_arm', 2e-3, 5.0, 'm', _LENGTH),
        ('trochlea.thread.length', 5e-3, 20.0, 'm', _LENGTH),
        ('trochlea.thread.inertia', 0.0, 10.0, 'kg m2', _INERTIA),
        ('trochlea.imbalance.moment', 1e-12, 0.1, 'kg m', ()),
        ('trochlea.power.mass', 1e-4, 50.0, 'kg', _MASS),
        ('trochlea.power.force', 1e-4, 500.0, 'N', _FORCE),
        ('trochlea.power.stiffness', 0.0, 1e4, 'N/m', (('mN/m', 1e-3),)),
        ('trochlea.release_angle', 0.0, 2.0 * math.pi, 'rad', _ANGLE),
        ('regulator.diameter', 1e-3, 2.0, 'm', _LENGTH),
        ('regulator.body_density', 100.0, 23_000.0, 'kg/m3', (('g/cm3', 1e3),)),
        ('regulator.fluid_density', 0.1, 14_000.0, 'kg/m3', (('g/cm3', 1e3),)),
        ('regulator.pendulum_length', 1e-3, 100.0, 'm', _LENGTH),
        ('regulator.axle_radius', 1e-5, 5.0, 'm', _LENGTH),
        ('regulator.depth', 1e-4, 100.0, 'm', _LENGTH),
        ('regulator.gyration_radius', 1e-4, 50.0, 'm', _LENGTH),
        ('regulator.release_arc', 0.0, 100.0, 'm', _LENGTH),
        ('escapement.energy', 1e-11, 0.1, 'J', (('millijoules', 1e-3), ('microjoules', 1e-6))),
        ('escapement.angle', 0.0, math.pi, 'rad', _ANGLE),
        ('ship.rate', 0.5, 2000.0, 'Hz', _RATE),
        ('ship.height', 0.0, 100.0, 'm', _LENGTH),
        ('ship.components[*].amplitude', 0.0, 1.2, 'rad', _ANGLE),
        ('ship.components[*].period', 0.5, 300.0, 's', _TIME),
        ('ship.heave[*].amplitude', 0.0, 20.0, 'm', _LENGTH),
        ('ship.heave[*].period', 0.5, 300.0, 's', _TIME),
        ('ship.sea.significant_wave_height', 0.01, 25.0, 'm', _LENGTH),
        ('ship.sea.peak_period', 1.0, 40.0, 's', _TIME),
        ('ship.roll.natural_period', 1.0, 60.0, 's', _TIME),
        ('ship.roll.damping_ratio', 1e-3, 1.0, '', (('per cent', 1e-2),)),
        ('ship.roll.slope_coefficient', 0.0, 5.0, '', (('per cent', 1e-2),)),
        ('ship.speed', 0.0, 25.0, 'm/s', (('km/h', 1.0 / 3.6), ('knots', 1852.0 / 3600.0))),
        ('suspension.support_radius', 1e-4, 1.0, 'm', _LENGTH),
        ('suspension.axle_radius', 1e-5, 0.5, 'm', _LENGTH),
        ('suspension.depth', 0.0, 5.0, 'm', _LENGTH),
        ('suspension.gyration_radius', 0.0, 5.0, 'm', _LENGTH),
        ('suspension.damping_ratio', 1e-3, 1.0, '', (('per cent', 1e-2),)),
        ('suspension.friction_angle', 1e-5, 0.5, 'rad', _ANGLE),
        ('clock.nominal_period', 0.05, 20.0, 's', _TIME),
        ('voyage.speed', 0.1, 25.0, 'm/s', (('km/h', 1.0 / 3.6), ('knots', 1852.0 / 3600.0))),
        ('drift.observation_sigma', 0.0, 3600.0, 's', _TIME),
        ('log.interval', 1e-3, 7.0 * DAY_S, 's', _TIME),
    )
}


# Sections in which a number above the range is refused.
_REFUSED = ('gravity', 'trochlea', 'regulator', 'escapement', 'suspension', 'ship', 'clock')


def implausible(scene: Scene) -> list[str]:
    """Return a warning for each number of a scene that is probably in the wrong unit.

    It names the key, its value, the limit, and the value in the unit that was probably meant.
    """
    return [
        f'{key} = {value:g}: {_comparison(value, sizes)}. {_meant(key, value, sizes)}'
        for key, value, sizes in _odd(scene)
    ]


def _odd(scene: Scene) -> Iterator[tuple[str, float, _Sizes]]:
    for key, value in _numbers('', scene.model_dump(exclude_none=True)):
        sizes = _SIZES.get(re.sub(r'\[\d+\]', '[*]', key))
        if sizes is not None and value and not sizes.low <= abs(value) <= sizes.high:
            yield key, value, sizes


def _numbers(path: str, content: object) -> Iterator[tuple[str, float]]:
    if isinstance(content, dict):
        for name, value in content.items():
            yield from _numbers(f'{path}.{name}' if path else str(name), value)
    elif isinstance(content, list | tuple):
        for place, value in enumerate(content):
            yield from _numbers(f'{path}[{place}]', value)
    elif isinstance(content, float):
        yield path, content


def _comparison(value: float, sizes: _Sizes) -> str:
    is_above = abs(value) > sizes.high
    limit = sizes.high if is_above else sizes.low
    if sizes.unit == 's' and limit >= 60.0:
        size = span(limit)
    else:
        size = f'{limit:.3g}{" " if sizes.unit else ""}{sizes.unit}'
    familiar = ''  # the value in turns or days, if that helps
    if sizes.unit == 'rad' and abs(value) > math.tau:
        familiar = f'{abs(value) / math.tau:.2g} turns, '
    elif sizes.unit == 's' and abs(value) >= 2.0 * DAY_S:
        familiar = f'{span(abs(value))}, '
    text = f'{familiar}{"more" if is_above else "less"} than {size}'
    return f'{text}, the {"most" if is_above else "least"} that any known machine or voyage has'


def _meant(key: str, value: float, sizes: _Sizes) -> str:
    """Return the value that was probably meant, as a sentence."""
    name = key.rpartition('.')[2]
    meant = [
        f'in {unit}, write {name}: {value * size:.4g}'
        for unit, size in sizes.slips
        if sizes.low <= abs(value * size) <= sizes.high
    ]
    return f'If it is {"; ".join(meant)}.' if meant else f'Its unit is {sizes.unit or 1}.'


# -----------------------------------------------------------------------------
# Whether a scene can run: checks that need machine, dial and ship together.

FASTEST_M_S = 25.0
"""More than any merchantman or man-of-war reached: 49 knots."""


STRONGEST_DRAG = 1e4
"""Largest viscous drag over the critical 2Iω₀. With more, steps of I/c₁ would take minutes."""


class Built(NamedTuple):
    """Machine and ship's motion of a scene, built once for its checks and its run."""

    machine: AnyMachine | OtherRegulator
    motion: ShipMotion


def check_scene(scene: Scene, motion: ShipMotion | None = None) -> Built:
    """Check how the parts of a scene fit together, and build machine and motion.

    `motion` is the ship's, if it has been built.

    Raises:
        SceneError: the machine or its suspension cannot be built, the impulse is beyond the range
            of the wheel, the release with the ship's motion at the start is beyond the cam
            (reading.md), drag makes the wheel creep, the motion is too abrupt for every
            propagator, or the voyage cannot be sailed.
        MotionDataError: measured motion cannot be used.
    """
    if scene.voyage is not None:
        Passage(scene, scene.voyage)
    machine = compile_machine(scene)
    _check_dial(scene, machine.frequency)
    if isinstance(machine, OtherRegulator):
        from tauto_core.machines import FluidPendulum  # few scenes have one

        if isinstance(machine, FluidPendulum):
            _check_swing(scene, machine)
        return Built(machine, motion or ShipMotion(scene))
    _check_escapement(scene, machine.range_rad)
    _check_drag(scene, machine)
    sensed_parts(scene)
    motion = motion or ShipMotion(scene)
    _check_start(scene, machine, motion)
    _check_motion(scene, machine)
    return Built(machine, motion)


def check_known(scene: Scene) -> None:
    """Refuse a machine or ship larger than any known, probably in the wrong unit (SceneError).

    Drag that prevents swings is refused, too. Every command that sails calls it, unless `anyway`.
    """
    problems = [
        Problem(key, value, _comparison(value, sizes), _meant(key, value, sizes))
        for key, value, sizes in _odd(scene)
        if abs(value) > sizes.high
        and key.partition('.')[0] in _REFUSED
        and key != 'ship.rate'  # only how the motion is sampled
    ] or _overdamped(scene)
    if problems:
        anyway = (' To sail it all the same, say ', Argument('anyway', value=True), '.')
        raise SceneError.of(
            scene.name,
            (replace(item, remedy=ArgumentText(item.remedy, *anyway)) for item in problems),
        )


def _overdamped(scene: Scene) -> list[Problem]:
    if scene.drag is None or scene.drag.viscous == 0.0:
        return []
    machine = compile_machine(scene)
    if isinstance(machine, OtherRegulator):  # only its fluid resists
        return []
    critical = 2.0 * machine.inertia * machine.frequency
    if scene.drag.viscous <= critical:
        return []
    problem = f'keeps the wheel from swinging, as {critical:.3g} N m s and more do'
    remedy = f'Use a hundredth of that, {0.01 * critical:.3g} N m s, or less.'
    return [Problem('drag.viscous', scene.drag.viscous, problem, remedy)]


def plausibility_warnings(
    scene: Scene, machine: AnyMachine | OtherRegulator | None = None
) -> list[str]:
    """Return warnings about a scene that can run: possible values that are probably mistakes.

    `machine` is the scene's, if it has been built.
    """
    texts = [*implausible(scene), *map(str, _overdamped(scene))]
    if scene.clock.nominal_period is not None and not texts:
        texts += stale_dial(scene, machine or compile_machine(scene))
    if scene.voyage is None:
        return texts
    passage = Passage(scene, scene.voyage)
    times = passage.places_ns
    speeds = [passage.speed_m_s((a + b) // 2) for a, b in pairwise(times)]
    speed = max(speeds)
    if speed > FASTEST_M_S:
        place = speeds.index(speed) + 1
        key = 'sails_at' if scene.voyage.arrives_at is None else 'arrives_at'
        value = getattr(scene.voyage, key)
        if scene.voyage.times[place] is not None and place < len(times) - 1:
            key, value = f'waypoints[{place - 1}].at', scene.voyage.times[place]
        texts.append(
            f'voyage.{key} = {value:g}: makes the ship sail at {speed:.3g} m/s, more than '
            f'{FASTEST_M_S:g} m/s, the most of any known ship. If the times are in days, write '
            f'{key}: {value * DAY_S:.6g}.'
        )
    return texts


def _check_start(scene: Scene, machine: AnyMachine, motion: ShipMotion) -> None:
    tilt = 0.0
    # a suspended case begins at rest, θ = φ
    tilts = scene.suspension is None and machine.sensed_angle(0.0, 1.0) != 0.0
    if tilts and math.isfinite(machine.range_rad):
        begun = motion.state()
        angles = attitude(motion.produce(1))  # imports kernels
        motion.restore(begun)
        tilt = float(np.arctan2(-angles.force_y[0], angles.force_z[0]))
    angle = machine.sensed_angle(machine.release_angle, tilt)
    if not abs(angle) <= machine.range_rad:
        raise SceneError(
            scene.name,
            'trochlea.release_angle',
            machine.release_angle,
            f'with the roll at the start the cam feels {angle:.6g} rad, beyond its range of '
            f'±{machine.range_rad:.6g} rad',
            f'Release the wheel nearer to rest{machine.widening}.',
        )


def _check_motion(scene: Scene, machine: AnyMachine) -> None:
    still = scene.lies_still
    if isinstance(machine, HangingMachine) or _is_resolved(machine, still):
        return
    from tauto_core.motion.closed_forms import LARGEST_DEGREE
    from tauto_core.motion.lever import MOST_SHAPE_TERMS

    lever = isinstance(machine, LeverMachine)
    changes = 'the inertia of weight and lever' if lever else 'the swing'
    raise SceneError(
        scene.name,
        'trochlea.inertia' if lever else 'trochlea.release_angle',
        machine.inertia if lever else machine.release_angle,
        f'{changes} changes too abruptly for the series of the motion: at most '
        f'{MOST_SHAPE_TERMS} Chebyshev coefficients in steps, {LARGEST_DEGREE} in closed form',
        'Release the wheel nearer to rest, or use a heavier wheel, a lighter weight or a softer '
        'spring.',
    )


def _is_resolved(machine: Machine | LeverMachine, still: bool) -> bool:
    """Return whether the series of the motion converge, as far as the sea does not matter."""
    try:
        name = propagator_name(machine, still=still)
        if name == 'action_angle':
            make_propagator(machine, still=True)
        elif isinstance(machine, LeverMachine):
            from tauto_core.motion.lever import arc_series

            arc_series(machine)
    except (PropagationError, QuadratureError):
        return False
    return True


def _check_escapement(scene: Scene, range_rad: float) -> None:
    if scene.escapement is None or abs(scene.escapement.angle) < range_rad:
        return
    raise SceneError(
        scene.name,
        'escapement.angle',
        scene.escapement.angle,
        f'no swing reaches it: the range of the wheel is ±{range_rad:.6g} rad',
        'Let the escapement act nearer to the middle (0), or take a cam with a longer range.',
    )


def _check_drag(scene: Scene, machine: AnyMachine) -> None:
    """Refuse viscous drag in which the wheel creeps in steps of I/c₁. Perhaps c₁ is a slip."""
    critical = 2.0 * machine.inertia * machine.frequency
    if scene.drag is None or scene.drag.viscous <= STRONGEST_DRAG * critical:
        return
    raise SceneError(
        scene.name,
        'drag.viscous',
        scene.drag.viscous,
        f'is more than {STRONGEST_DRAG:g} times what keeps a wheel from swinging: it creeps',
        f'Use at most {STRONGEST_DRAG * critical:.3g} N m s. A wheel swings with less than '
        f'{critical:.3g} N m s.',
    )


def _check_swing(scene: Scene, machine: FluidPendulum) -> None:
    try:
        machine.period(machine.release_arc)
    except (DescentError, QuadratureError) as error:
        raise SceneError(
            scene.name,
            'regulator.release_arc',
            machine.release_arc,
            str(error),
            'Release the body nearer to A, or change body or fluid.',
        ) from None


def _check_dial(scene: Scene, frequency: float) -> None:
    regulator = 'trochlea' if scene.regulator is None else 'regulator'
    period = math.tau / frequency if frequency > 0.0 else math.inf
    nominal = scene.clock.nominal_period or period
    if not (period > 0.0 and nominal <= LAST_STAMP_S):
        raise SceneError(
            scene.name,
            regulator if scene.clock.nominal_period is None else 'clock.nominal_period',
            ABSENT if scene.clock.nominal_period is None else nominal,
            f'makes a period of {nominal:.6g} s on the dial, which must be > 0 and at most '
            f'{LAST_STAMP_S} s, the last ROS stamp',
            f'Check the units in {regulator} and of gravity, or give another nominal_period.',
        )
    dial_s = scene.starts_at + scene.duration * nominal / period
    if not dial_s <= LAST_STAMP_S:
        raise SceneError(
            scene.name,
            'clock.nominal_period',
            nominal,
            f'with a period of {period:.6g} s the dial would reach {dial_s:.6g} s, after the '
            f'last ROS stamp, {LAST_STAMP_S} s',
            'Give a nominal_period near the period, or leave it out.',
        )
