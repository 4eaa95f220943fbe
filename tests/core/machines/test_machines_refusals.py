"""Machines that cannot be built: named with value and limit, and the remedy works."""

import math
import re

import numpy as np
import pytest
import yaml

from tauto_core.checks.readiness import check_scene
from tauto_core.curves import Involute
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


def numbers(message, pattern):
    found = re.search(pattern, message)
    assert found, message
    return [float(each) for each in found.groups()]


@pytest.mark.parametrize('thread', [HOLE, VERTICAL], ids=lambda thread: thread['kind'])
def test_too_light_a_weight(thread):
    """The range on a vertical thread is πL/(4λ), which grows with the root of the mass."""
    message = refusal(**WEIGHT, thread=thread, release_angle=9.0)
    assert 'trochlea.release_angle = 9.0: is beyond the cam' in message
    mass, period = numbers(message, r'at least ([\d.]+) kg .* at least ([\d.]+) s')
    better = [
        {'power': {'kind': 'weight', 'mass': mass}},
        {'cam': {'kind': 'weight_corrected', 'period': period}},
    ]
    for change in better:
        machine = compile_machine(scene(**{**WEIGHT, **change}, thread=thread, release_angle=9.0))
        # the nearest that works
        assert 9.0 <= machine.cam.range_rad < 9.02
    if thread is VERTICAL:
        gravity, omega = 9.80665, math.pi
        least = 16 * omega**4 * 4e-4 * 81 / (math.pi * gravity) ** 2
        assert mass == pytest.approx(least, rel=1e-3)


def test_a_hole_inside_the_swing():
    message = refusal(**WEIGHT, thread=HOLE, release_angle=8.0)
    (distance,) = numbers(message, r'hole to at least ([\d.]+) m')
    farther = {'kind': 'hole', 'distance': distance}
    machine = compile_machine(scene(**WEIGHT, thread=farther, release_angle=7.999))
    assert machine.cam.range_rad == pytest.approx(8.0, rel=1e-5)
    plain = {'cam': {'kind': 'hole', 'lever_rate': 0.01}, 'power': {'kind': 'force', 'force': 2.0}}
    message = refusal(**plain, thread=HOLE, release_angle=9.0)
    assert numbers(message, r'hole to at least ([\d.]+) m') == [0.09]
    stiff = {**SPRING, 'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 1.0}}
    message = refusal(**stiff, thread=HOLE, release_angle=30.0)
    (distance,) = numbers(message, r'hole to at least ([\d.]+) m')
    arm = float(compile_machine(scene(**stiff)).cam.lever_arm(30.0))
    assert distance == pytest.approx(arm, rel=1e-5)


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


def test_the_plain_cam_that_is_named_keeps_the_period():
    message = refusal(**{**WEIGHT, 'power': {'kind': 'force', 'force': 2.0}})
    (radius,) = numbers(message, r'base_radius: ([\d.]+)')
    machine = compile_machine(
        scene(
            cam={'kind': 'involute', 'base_radius': radius}, power={'kind': 'force', 'force': 2.0}
        )
    )
    assert isinstance(machine.cam, Involute)
    assert machine.period(3.0) == pytest.approx(2.0, rel=1e-5)


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


def test_a_lever_that_its_cam_turns_too_far():
    """Each remedy works and is the nearest; a longer thread is named only where it helps."""
    lever = {**LEVER, 'thread': {**LEVER['thread'], 'arm': 0.01}}
    message = refusal(**lever)
    radius, arm = numbers(
        message, r'base_radius of at most ([\d.e-]+) m or a lever arm of at least ([\d.e-]+) m'
    )
    for change in (
        {'cam': {'kind': 'involute', 'base_radius': radius}},
        {'thread': {**lever['thread'], 'arm': arm}},
    ):
        machine = compile_machine(scene(**{**lever, **change}))
        assert 1.0 <= machine.range_rad < 1.002
    assert 'thread of at least' not in message
    short = {**LEVER, 'thread': {**LEVER['thread'], 'length': 0.01}}
    (length,) = numbers(refusal(**short), r'a thread of at least ([\d.e-]+) m')
    machine = compile_machine(scene(**{**short, 'thread': {**short['thread'], 'length': length}}))
    assert 1.0 <= machine.range_rad < 1.002


def test_a_weight_too_light_for_the_period_of_a_lever():
    lever = {
        **LEVER,
        'cam': {'kind': 'lever_corrected', 'period': 1.0},
        'power': {'kind': 'weight', 'mass': 0.001},
    }
    mass, period = numbers(
        refusal(**lever), r'a weight of at least ([\d.]+) kg or a period of at least ([\d.]+) s'
    )
    for change in (
        {'power': {'kind': 'weight', 'mass': mass}},
        {'cam': {'kind': 'lever_corrected', 'period': period}},
    ):
        machine = compile_machine(scene(**{**lever, **change}))
        assert 1.0 <= machine.range_rad < 1.002


def test_a_hanging_thread_that_is_all_wound_up():
    hanging = {**LEVER, 'thread': {'kind': 'hanging', 'length': 0.001}}
    length, radius = numbers(
        refusal(**hanging), r'at least ([\d.]+) m or a base_radius of at most ([\d.e-]+) m'
    )
    for change in (
        {'thread': {'kind': 'hanging', 'length': length}},
        {'cam': {'kind': 'involute', 'base_radius': radius}},
    ):
        assert 1.0 <= compile_machine(scene(**{**hanging, **change})).range_rad < 1.001


def unresolved(**trochlea):
    with pytest.raises(SceneError, match='too abruptly') as caught:
        check_scene(scene(**trochlea))
    return caught.value


def test_a_lever_whose_inertia_no_series_resolves():
    """Before anything starts, at sea, where the motion is integrated; the named remedy works."""
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
    """On a still ship, where the swing released is one series."""
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
    mote = {'diameter': 1e-6, 'release_arc': 0.4}
    with pytest.raises(SceneError, match='a larger or denser body') as caught:
        compile_machine(in_fluid(**mote))
    said = r'diameter of at least ([\d.e-]+) m or a body_density of at least ([\d.e+]+) kg/m3'
    for key, value in zip(
        ('diameter', 'body_density'), numbers(str(caught.value), said), strict=True
    ):
        compile_machine(in_fluid(**mote | {key: value}))
        with pytest.raises(SceneError, match='cusp'):
            compile_machine(in_fluid(**mote | {key: 0.998 * value}))


@pytest.mark.parametrize('fluid', [7800.0, 13_534.0])
@pytest.mark.parametrize('release', [0.3, -0.3])
def test_a_fluid_in_which_the_body_does_not_sink(fluid, release):
    """The nearest body and the nearest fluid: their curves hold the release, and no nearer one."""
    changes = {'fluid_density': fluid, 'release_arc': release}
    with pytest.raises(SceneError, match='the globe does not sink') as caught:
        compile_machine(in_fluid(**changes))
    assert caught.value.key == 'regulator.fluid_density'
    said = r'body_density of at least ([\d.e+]+) kg/m3, or a lighter fluid, of at most ([\d.]+) kg'
    for key, value, worse in zip(
        ('body_density', 'fluid_density'),
        numbers(str(caught.value), said),
        (0.998, 1.002),
        strict=True,
    ):
        check_scene(in_fluid(**changes | {key: value}))
        with pytest.raises(SceneError):
            compile_machine(in_fluid(**changes | {key: worse * value}))


def test_a_mote_on_a_cycloid_is_refused_without_a_grid_of_its_whole_way():
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
