"""A weight and a spring on one thread, and the isochronous cam for both."""

from __future__ import annotations

import numpy as np
import pytest

from tauto_core.machines import compile_machine
from tauto_core.scene import SceneError, parse_scene

BOTH = '{kind: weight_and_spring, mass: 0.05, stiffness: 5.0}'
SYNTHESISED = '{kind: synthesised, period: 1.5, range: 2.0}'
VERTICAL = '{kind: vertical}'


def scene(cam=SYNTHESISED, power=BOTH, thread=VERTICAL, release=1.0):
    return parse_scene(
        f'duration: 10\ntrochlea: {{inertia: 4.0e-4, cam: {cam}, thread: {thread}, '
        f'power: {power}, release_angle: {release}}}',
        's',
    )


def test_the_pull_is_that_of_both():
    machine = compile_machine(scene('{kind: involute, base_radius: 0.01}'))
    lift = np.array([0.0, 0.01, 0.03])
    np.testing.assert_allclose(machine.pull(lift), 0.05 * 9.80665 + 5.0 * lift, rtol=1e-15)
    assert machine.mass(1.0) == pytest.approx(4e-4 + 0.05 * 1e-4, rel=1e-15)
    energy = machine.potential(1.0)
    assert energy == pytest.approx(0.05 * 9.80665 * 0.005 + 0.5 * 5.0 * 0.005**2, rel=1e-14)


def test_its_synthesised_cam_keeps_one_period():
    """Of every swing, by quadrature. Under Euler's cam the swings differ by more than 1 %."""
    amplitudes = (0.1, 0.7, 1.4, 2.0)
    periods = [compile_machine(scene()).period(amplitude) for amplitude in amplitudes]
    np.testing.assert_allclose(periods, 1.5, rtol=1e-11)
    plain = compile_machine(scene('{kind: involute, base_radius: 0.01}'))
    assert abs(plain.period(2.0) / plain.period(0.1) - 1.0) > 0.01


def test_a_cam_made_for_one_of_them_names_the_one_for_both():
    with pytest.raises(SceneError, match='together use cam kind synthesised'):
        scene('{kind: weight_corrected, period: 1.5}')


@pytest.mark.parametrize(
    ('cam', 'thread', 'key'),
    [
        ('{kind: synthesised, period: 0.001, range: 2.0}', VERTICAL, 'trochlea.cam.period'),
        (SYNTHESISED, '{kind: hole, distance: 0.001}', 'trochlea.cam.kind'),
    ],
    ids=['too fast for the weight', 'beyond the hole'],
)
def test_what_no_cam_can_do_is_refused(cam, thread, key):
    with pytest.raises(SceneError) as caught:
        compile_machine(scene(cam, thread=thread))
    assert caught.value.key == key
    assert caught.value.remedy.endswith('.')
    assert len(caught.value.problem) > 20
