"""Machines that cannot be built: named with value, limit and remedy."""

import math

import numpy as np
import pytest

from tauto_core.checks.readiness import check_scene
from tauto_core.machines import compile_machine
from tauto_core.scene import load_scene
from tauto_core.scene.errors import ABSENT, SceneError

HOLE, VERTICAL = {'kind': 'hole', 'distance': 0.08}, {'kind': 'vertical'}
WEIGHT = {
    'cam': {'kind': 'weight_corrected', 'period': 2.0},
    'power': {'kind': 'weight', 'mass': 0.05},
}
SPRING = {
    'cam': {'kind': 'spring_corrected', 'period': 1.0},
    'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 50.0},
}


CONSTANT = {
    'cam': {'kind': 'hole', 'lever_rate': 0.01},
    'power': {'kind': 'force', 'force': 2.0},
    'thread': HOLE,
}
ARC = CONSTANT | {
    'cam': {'kind': 'circular_arc', 'radius': 0.02, 'root_depth': 0.01},
    'thread': VERTICAL,
}
BOTH = {'kind': 'weight_and_spring', 'mass': 0.05, 'stiffness': 5.0}
FAST = {'kind': 'synthesised', 'period': 0.001, 'range': 2.0}
WIDE = {'kind': 'synthesised', 'period': 1.5, 'range': 2.0}
NEAR = {'kind': 'hole', 'distance': 0.001}
ROLL = {'kind': 'components', 'components': [{'amplitude': 0.1, 'period': 9.0}]}


def scene(ship=None, **trochlea):
    parts = {'inertia': 4e-4, 'thread': VERTICAL, 'release_angle': 1.0}
    return load_scene('ideal', ship=ship, clock=ABSENT, trochlea=parts | trochlea)


def refusal(**trochlea):
    with pytest.raises(SceneError) as caught:
        compile_machine(scene(**trochlea))
    return str(caught.value)


def of_mass(mass):
    return {'kind': 'weight', 'mass': mass}


@pytest.mark.parametrize('thread', [HOLE, VERTICAL], ids=lambda thread: thread['kind'])
def test_a_spring_too_stiff_for_a_convex_cheek(thread):
    message = refusal(
        **{**SPRING, 'power': {**SPRING['power'], 'stiffness': 5000.0}}, thread=thread
    )
    assert message.startswith("ideal: trochlea.cam.kind = 'spring_corrected': has a cheek")
    assert 'from 0 to 0.58' in message
    assert 'Use a softer spring, a longer period or a nearer hole' in message
    # of a vertical thread κ < P²/(3 I ω²)
    soft = {**SPRING['power'], 'stiffness': 0.999 * 4.0 / (3 * 4e-4 * math.tau**2)}
    machine = compile_machine(scene(**{**SPRING, 'power': soft}, thread=thread))
    assert np.all(machine.cam.radius_of_curvature(np.linspace(1e-6, 3.0, 300)) > 0.0)


@pytest.mark.parametrize(
    ('changes', 'key', 'said'),
    [
        ({'power': CONSTANT['power']}, 'power.kind', 'cam kind involute'),
        ({'power': WEIGHT['power'] | {'massless': True}}, 'power.massless', 'cam kind involute'),
        ({'power': SPRING['power']}, 'power.kind', 'spring_corrected'),
        ({'cam': SPRING['cam']}, 'power.kind', 'weight_corrected'),
        ({'power': BOTH}, 'power.kind', 'a weight and a spring together use cam kind synthesised'),
        ({'cam': FAST, 'power': BOTH}, 'cam.period', 'slower by itself'),
        ({'cam': WIDE, 'power': BOTH, 'thread': NEAR}, 'cam.kind', 'longer than the hole is away'),
        ({'power': CONSTANT['power'], 'thread': HOLE}, 'power.kind', 'cam kind hole'),
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


TROCHLEA = load_scene('sully_lever_at_sea').trochlea.model_dump()
LEVER = {part: TROCHLEA[part] for part in ('cam', 'thread', 'power')}


def on_lever(**changes):
    return {**LEVER, 'thread': {**LEVER['thread'], **changes}}


LIGHT = {**LEVER, 'cam': {'kind': 'lever_corrected', 'period': 1.0}, 'power': of_mass(0.001)}
STIFF = {**SPRING, 'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 1.0}, 'thread': HOLE}
BEYOND = {
    'weight': ({**WEIGHT, 'release_angle': 9.0}, 'use a heavier weight or a longer period'),
    'hole': ({**CONSTANT, 'release_angle': 8.01}, 'move the hole away from the axle'),
    'hole at sea': (
        {**CONSTANT, 'release_angle': -8.01, 'ship': ROLL},
        'move the hole away from the axle',
    ),
    'arc': ({**ARC, 'release_angle': 3.2}, 'give the cam a wider range'),
    'arc, weight': (
        {**ARC, 'release_angle': 3.2, 'power': of_mass(0.2)},
        'give the cam a wider range',
    ),
    'hole, spring': ({**STIFF, 'release_angle': 30.0}, 'move the hole away from the axle'),
    'lever': (on_lever(arm=0.01), 'use a smaller cam, a longer lever or a longer thread'),
    'light weight': (LIGHT, 'use a heavier weight or a longer period'),
    'hanging': (
        {**LEVER, 'thread': {'kind': 'hanging', 'length': 0.001}},
        'use a longer thread or a smaller base_radius',
    ),
}


@pytest.mark.parametrize(('parts', 'remedy'), BEYOND.values(), ids=BEYOND.keys())
def test_a_release_beyond_the_range_names_the_change(parts, remedy):
    message, release = refusal(**parts), parts.get('release_angle', 1.0)
    assert f'trochlea.release_angle = {release}: is beyond' in message
    assert f'nearer to rest, or {remedy}.' in message


def unresolved(**trochlea):
    with pytest.raises(SceneError, match='too abruptly') as caught:
        check_scene(scene(**trochlea))
    return caught.value


def test_a_lever_whose_inertia_no_series_resolves():
    """Before anything starts, at sea, with integrated motion."""
    heavy = {**LEVER, 'power': {'kind': 'weight', 'mass': 1.0}, 'ship': ROLL}
    error = unresolved(**heavy)
    assert (error.key, error.value, error.exit_code) == ('trochlea.inertia', 4e-4, 2)
    assert '128 Chebyshev coefficients in steps' in error.problem
    check_scene(scene(**heavy | {'release_angle': 0.1}))


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
    error = unresolved(cam=LEVER['cam'], **parts, release_angle=-60.0)
    assert (error.key, error.value) == ('trochlea.release_angle', -60.0)
    assert 'nearer to rest, or use a heavier wheel' in error.remedy


@pytest.mark.parametrize(
    ('release', 'remedy'),
    [
        (90.0, '90° = 1.571: if 90 is in degrees, write release_angle: 1.571.'),
        (-270.0, 'if -270 is in degrees, write release_angle: -4.712.'),
        (1e30, 'Angles are in radians, 90° = 1.571.'),
    ],
)
def test_a_release_of_more_turns_than_any_thread_has(release, remedy):
    force = CONSTANT | {'cam': LEVER['cam'], 'thread': VERTICAL}
    with pytest.raises(SceneError, match=r'at most 62\.83 rad in size, 10 turns') as caught:
        scene(**force, release_angle=release)
    assert (caught.value.key, caught.value.value) == ('trochlea.release_angle', release)
    assert caught.value.remedy.endswith(remedy)
    scene(**force, release_angle=-62.8)


def in_fluid(**changes):
    return load_scene(
        'globe_in_oil', **{f'regulator.{key}': each for key, each in changes.items()}
    )


@pytest.mark.parametrize(
    ('curve', 'release'),
    [('euler', 1.5), ('cycloid', 1.5), ('cycloid', -1.5), ('symmetric', 1.5), ('symmetric', -1.5)],
)
def test_a_release_beyond_the_cusp(curve, release):
    changes = {'curve': curve, 'release_arc': release}
    with pytest.raises(SceneError, match='beyond the cusp') as caught:
        compile_machine(in_fluid(**changes))
    assert 'a longer pendulum or a larger or denser body' in str(caught.value)
    compile_machine(in_fluid(**changes, pendulum_length=5.0))


@pytest.mark.parametrize('fluid', [7800.0, 13_534.0])
def test_a_fluid_in_which_the_body_does_not_sink(fluid):
    with pytest.raises(SceneError, match='the globe does not sink') as caught:
        compile_machine(in_fluid(fluid_density=fluid, release_arc=0.3))
    assert caught.value.key == 'regulator.fluid_density'


def test_a_mote_on_a_cycloid_is_refused_without_a_series():
    with pytest.raises(SceneError, match='the fluid resists too strongly'):
        check_scene(in_fluid(diameter=1e-20, release_arc=0.4, curve='cycloid'))


@pytest.mark.parametrize('angle', [8.0, -9.0])
def test_an_impulse_that_no_swing_reaches(angle):
    """Euler's second cam ends at a/b = 8 rad."""
    escapement = {'energy': 1e-6, 'angle': angle}
    with pytest.raises(SceneError, match=r'the range of the wheel is ±8 rad.*nearer to the mid'):
        check_scene(load_scene('ideal', escapement=escapement))
    escapement['angle'] = math.copysign(7.9, angle)
    check_scene(load_scene('ideal', escapement=escapement))
