"""Machines that cannot be built: named with value and limit, and the remedy works."""

import math
import re

import numpy as np
import pytest
import yaml

from tauto_core.checks.readiness import check_scene
from tauto_core.machines import compile_machine
from tauto_core.motion.lever import arc_series
from tauto_core.scene.errors import PropagationError, SceneError
from tauto_core.scene.loader import parse_scene

HOLE, VERTICAL = {'kind': 'hole', 'distance': 0.08}, {'kind': 'vertical'}
WEIGHT = {
    'cam': {'kind': 'weight_corrected', 'period': 2.0},
    'power': {'kind': 'weight', 'mass': 0.05},
}
SPRING = {
    'cam': {'kind': 'spring_corrected', 'period': 1.0},
    'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 50.0},
}


ROLL = {'kind': 'components', 'components': [{'amplitude': 0.1, 'period': 9.0}]}


def scene(ship=None, **trochlea):
    base = {'inertia': 4e-4, 'thread': VERTICAL, 'release_angle': 1.0}
    content = {'name': 'test', 'duration': 10.0, 'trochlea': {**base, **trochlea}}
    if ship is not None:
        content['ship'] = ship
    return parse_scene(yaml.safe_dump(content), 'test')


def refusal(**trochlea):
    with pytest.raises(SceneError) as caught:
        compile_machine(scene(**trochlea))
    return str(caught.value)


def of_mass(mass):
    return {'kind': 'weight', 'mass': mass}


def numbers(message, pattern):
    found = re.search(pattern, message)
    assert found, message
    return [float(each) for each in found.groups()]


@pytest.mark.parametrize('thread', [HOLE, VERTICAL], ids=lambda thread: thread['kind'])
def test_a_spring_too_stiff_for_a_convex_cheek(thread):
    power = {'kind': 'spring', 'force': 2.0, 'stiffness': 5000.0}
    message = refusal(**{**SPRING, 'power': power}, thread=thread)
    assert message.startswith('test: trochlea.power.stiffness = 5000.0: the cheek')
    assert 'from 0 to 0.58' in message
    stiffness, period = numbers(
        message, r'at most ([\d.]+) N/m, or a period of at least ([\d.]+) s'
    )
    for change in (
        {'power': {**power, 'stiffness': stiffness}},
        {'power': power, 'cam': {'kind': 'spring_corrected', 'period': period}},
    ):
        machine = compile_machine(scene(**{**SPRING, **change}, thread=thread))
        angle = np.linspace(1e-6, 3.0, 300)
        assert np.all(machine.cam.radius_of_curvature(angle) > 0.0)
    if thread is VERTICAL:
        # κ < P²/(3 I ω²)
        assert stiffness == pytest.approx(4.0 / (3 * 4e-4 * math.tau**2), rel=1e-3)


@pytest.mark.parametrize(
    ('changes', 'key', 'said'),
    [
        ({'power': {'kind': 'force', 'force': 2.0}}, 'power.kind', 'base_radius: 0.00197392'),
        (
            {'power': {**WEIGHT['power'], 'massless': True}},
            'power.massless',
            'base_radius: 0.00805',
        ),
        ({'power': SPRING['power']}, 'power.kind', 'spring_corrected'),
        ({'cam': SPRING['cam']}, 'power.kind', 'weight_corrected'),
        (
            {'power': {'kind': 'force', 'force': 2.0}, 'thread': HOLE},
            'power.kind',
            'lever_rate: 0.0019',
        ),
        ({'cam': {'kind': 'weight_corrected', 'period': 0.0}}, 'cam.period', 'greater than 0'),
        ({'cam': {'kind': 'lever_corrected', 'period': 1.0}}, 'thread.kind', 'thread kind lever'),
    ],
)
def test_a_cam_made_for_another_power(changes, key, said):
    message = refusal(**{**WEIGHT, **changes})
    assert f'trochlea.{key}' in message
    assert said in message


@pytest.mark.parametrize('period', [1e-200, 1e200])
@pytest.mark.parametrize('kind', [WEIGHT, SPRING], ids=['weight', 'spring'])
def test_a_period_out_of_all_proportion(kind, period):
    message = refusal(**{**kind, 'cam': {**kind['cam'], 'period': period}})
    assert f'trochlea.cam.period = {period!r}' in message


LEVER = {
    'cam': {'kind': 'involute', 'base_radius': 0.02},
    'thread': {'kind': 'lever', 'arm': 0.1, 'weight_arm': 0.15, 'length': 0.3},
    'power': {'kind': 'weight', 'mass': 0.05},
}


def on_lever(**changes):
    return {**LEVER, 'thread': {**LEVER['thread'], **changes}}


LIGHT = {**LEVER, 'cam': {'kind': 'lever_corrected', 'period': 1.0}, 'power': of_mass(0.001)}
STIFF = {**SPRING, 'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 1.0}, 'thread': HOLE}
CONSTANT = {
    'cam': {'kind': 'hole', 'lever_rate': 0.01},
    'power': {'kind': 'force', 'force': 2.0},
    'thread': HOLE,
}
MASS_OR_PERIOD = r'at least ([\d.]+) kg .*a period of at least ([\d.]+) s'
TO_HOLE = r'hole to at least ([\d.]+) m'


def of_period(kind):
    return lambda value: {'cam': {'kind': kind, 'period': value}}


def weight(value):
    return {'power': of_mass(value)}


def hole(value):
    return {'thread': {'kind': 'hole', 'distance': value * (1 + 1e-5)}}


def radius(value):
    return {'cam': {'kind': 'involute', 'base_radius': value}}


REMEDIES = {
    'weight': ({**WEIGHT, 'release_angle': 9.0}, MASS_OR_PERIOD,
               [weight, of_period('weight_corrected')]),
    'weight, hole': ({**WEIGHT, 'thread': HOLE, 'release_angle': 9.0}, MASS_OR_PERIOD,
                     [weight, of_period('weight_corrected')]),
    'hole, weight': ({**WEIGHT, 'thread': HOLE, 'release_angle': 8.0}, TO_HOLE, [hole]),
    'hole, force': ({**CONSTANT, 'release_angle': 9.0}, TO_HOLE, [hole]),
    'hole, spring': ({**STIFF, 'release_angle': 30.0}, TO_HOLE, [hole]),
    'lever': (on_lever(arm=0.01),
              r'base_radius of at most ([\d.e-]+) m or a lever arm of at least ([\d.e-]+) m',
              [radius, lambda value: on_lever(arm=value)]),
    'short thread': (on_lever(length=0.01), r'a thread of at least ([\d.e-]+) m',
                     [lambda value: on_lever(length=value)]),
    'light weight': (LIGHT, MASS_OR_PERIOD.replace('.*', 'or '),
                     [weight, of_period('lever_corrected')]),
    'hanging': ({**LEVER, 'thread': {'kind': 'hanging', 'length': 0.001}},
                r'at least ([\d.]+) m or a base_radius of at most ([\d.e-]+) m',
                [lambda value: {'thread': {'kind': 'hanging', 'length': value}}, radius]),
}  # fmt: skip


@pytest.mark.parametrize(('parts', 'pattern', 'changes'), REMEDIES.values(), ids=REMEDIES.keys())
def test_the_remedy_for_the_range_is_the_nearest(parts, pattern, changes):
    message, release = refusal(**parts), parts.get('release_angle', 1.0)
    assert f'trochlea.release_angle = {release}: is beyond' in message
    for value, change in zip(numbers(message, pattern), changes, strict=True):
        machine = compile_machine(scene(**parts | change(value)))
        assert release <= machine.range_rad < 1.0025 * release


def test_the_least_mass_on_a_vertical_thread():
    """The range is πL/(4λ), which grows with the root of the mass."""
    mass, _ = numbers(refusal(**WEIGHT, release_angle=9.0), MASS_OR_PERIOD)
    least = 16 * math.pi**4 * 4e-4 * 81 / (math.pi * 9.80665) ** 2
    assert mass == pytest.approx(least, rel=1e-3)


def unresolved(**trochlea):
    with pytest.raises(SceneError, match='too abruptly') as caught:
        check_scene(scene(**trochlea))
    return caught.value


def test_a_lever_whose_inertia_no_series_resolves():
    """Before anything starts, at sea, with integrated motion. The named remedy works."""
    heavy = {**LEVER, 'power': {'kind': 'weight', 'mass': 1.0}, 'ship': ROLL}
    error = unresolved(**heavy)
    assert (error.key, error.value, error.exit_code) == ('trochlea.inertia', 4e-4, 2)
    assert '128 Chebyshev coefficients in steps' in error.problem
    inertia, release = numbers(
        str(error), r'at least ([\d.e-]+) kg m2 or a release_angle of at most ([\d.]+) rad'
    )
    check_scene(scene(**heavy | {'inertia': inertia}))
    check_scene(scene(**heavy | {'release_angle': release}))
    for worse in ({'inertia': 0.99 * inertia}, {'release_angle': 1.01 * release}):
        with pytest.raises(PropagationError, match='too abruptly'):
            arc_series(compile_machine(scene(**heavy | worse)))


@pytest.mark.parametrize(
    'parts',
    [
        {'inertia': 4e-14, 'power': {'kind': 'weight', 'mass': 0.05}},
        {'inertia': 4e-4, 'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 5e6}},
    ],
    ids=lambda parts: parts['power']['kind'],
)
def test_a_release_too_far_for_any_series(parts):
    """On a still ship the swing is one series."""
    far = {'cam': {'kind': 'involute', 'base_radius': 0.02}, **parts}
    error = unresolved(**far, release_angle=-60.0)
    assert (error.key, error.value) == ('trochlea.release_angle', -60.0)
    (release,) = numbers(str(error), r'a release_angle of at most ([\d.e+]+) rad')
    check_scene(scene(**far, release_angle=-release))
    unresolved(**far, release_angle=1.01 * release)


@pytest.mark.parametrize(
    ('release', 'remedy'),
    [
        (90.0, '90° = 1.571: if 90 is in degrees, write release_angle: 1.571.'),
        (-270.0, 'if -270 is in degrees, write release_angle: -4.712.'),
        (1e30, 'Angles are in radians, 90° = 1.571.'),
    ],
)
def test_a_release_of_more_turns_than_any_thread_has(release, remedy):
    force = {
        'cam': {'kind': 'involute', 'base_radius': 0.02},
        'power': {'kind': 'force', 'force': 2.0},
    }
    with pytest.raises(SceneError, match=r'at most 62\.83 rad in size, 10 turns') as caught:
        scene(**force, release_angle=release)
    assert (caught.value.key, caught.value.value) == ('trochlea.release_angle', release)
    assert caught.value.remedy.endswith(remedy)
    scene(**force, release_angle=-62.8)


GLOBE = {
    'kind': 'fluid_tautochrone',
    'body': 'globe',
    'diameter': 0.05,
    'body_density': 7800.0,
    'fluid_density': 900.0,
    'pendulum_length': 1.0,
}


def in_fluid(**changes):
    content = {'name': 'test', 'duration': 10.0, 'regulator': {**GLOBE, **changes}}
    return parse_scene(yaml.safe_dump(content), 'test')


@pytest.mark.parametrize(
    ('curve', 'release'),
    [('euler', 1.5), ('cycloid', 1.5), ('cycloid', -1.5), ('symmetric', 1.5), ('symmetric', -1.5)],
)
def test_a_release_beyond_the_cusp(curve, release):
    changes = {'curve': curve, 'release_arc': release}
    with pytest.raises(SceneError, match='beyond the cusp') as caught:
        compile_machine(in_fluid(**changes))
    (length,) = numbers(str(caught.value), r'pendulum_length of at least ([\d.]+) m')
    compile_machine(in_fluid(**changes, pendulum_length=length))
    with pytest.raises(SceneError):
        compile_machine(in_fluid(**changes, pendulum_length=0.998 * length))


def test_no_pendulum_is_long_enough_for_a_mote():
    with pytest.raises(SceneError, match='a longer pendulum or a larger or denser body'):
        compile_machine(in_fluid(diameter=1e-6, release_arc=0.4))


@pytest.mark.parametrize('fluid', [7800.0, 13_534.0])
def test_a_fluid_in_which_the_body_does_not_sink(fluid):
    with pytest.raises(SceneError, match='the globe does not sink') as caught:
        compile_machine(in_fluid(fluid_density=fluid, release_arc=0.3))
    assert caught.value.key == 'regulator.fluid_density'


def test_a_mote_on_a_cycloid_is_refused_without_a_grid():
    with pytest.raises(SceneError, match='the fluid resists too strongly'):
        check_scene(in_fluid(diameter=1e-20, release_arc=0.4, curve='cycloid'))


@pytest.mark.parametrize('angle', [8.0, -9.0])
def test_an_impulse_that_no_swing_reaches(angle):
    """Euler's second cam ends at a/b = 8 rad."""
    content = {
        'name': 'test',
        'duration': 10.0,
        'trochlea': {
            'inertia': 4e-4,
            'cam': {'kind': 'hole', 'lever_rate': 0.01},
            'thread': HOLE,
            'power': {'kind': 'force', 'force': 2.0},
            'release_angle': 1.0,
        },
        'escapement': {'energy': 1e-6, 'angle': angle},
    }
    with pytest.raises(SceneError, match=r'the range of the wheel is ±8 rad.*nearer to the mid'):
        check_scene(parse_scene(yaml.safe_dump(content), 'test'))
    content['escapement']['angle'] = math.copysign(7.9, angle)
    check_scene(parse_scene(yaml.safe_dump(content), 'test'))
