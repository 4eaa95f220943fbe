"""Scenes with Sully's lever or a swinging thread: compatible and incompatible parts."""

from typing import Any

import pytest
import yaml

from tauto_core.checks.readiness import check_scene
from tauto_core.machines import HangingMachine, LeverMachine, compile_machine
from tauto_core.scene import Scene, parse_scene
from tauto_core.scene.errors import SceneError

THREADS: dict[str, dict[str, Any]] = {
    'lever': {'kind': 'lever', 'arm': 0.1, 'weight_arm': 0.15, 'length': 0.3},
    'hanging': {'kind': 'hanging', 'length': 0.3},
}
MASSLESS = {'kind': 'weight', 'mass': 0.05, 'massless': True}
ARC = {'kind': 'circular_arc', 'radius': 0.02, 'root_depth': 0.01}
RUBS = {'kind': 'impulse', 'energy': 1e-5, 'rest': {'friction': 1e-6}}


def scene_of(thread: dict[str, Any], **sections: Any) -> Scene:
    trochlea = {
        'inertia': 4e-4,
        'cam': {'kind': 'involute', 'base_radius': 0.02},
        'thread': thread,
        'power': {'kind': 'weight', 'mass': 0.05},
        'release_angle': 1.0,
        **sections.pop('trochlea', {}),
    }
    base = {'name': 'threads', 'duration': 60.0, 'trochlea': trochlea, **sections}
    return parse_scene(yaml.safe_dump(base), 'threads')


def test_the_numbers_of_the_scene_are_those_of_the_machine() -> None:
    lever = compile_machine(scene_of(THREADS['lever'] | {'inertia': 2e-5}))
    assert isinstance(lever, LeverMachine)
    assert lever.turned_inertia == pytest.approx(0.05 * 0.15**2 + 2e-5, rel=1e-15)
    assert (lever.geometry.arm, lever.geometry.length) == (0.1, 0.3)
    assert lever.geometry.base_radius == 0.02
    hanging = compile_machine(scene_of(THREADS['hanging'], gravity=9.81))
    assert isinstance(hanging, HangingMachine)
    assert (hanging.mass, hanging.length, hanging.gravity) == (0.05, 0.3, 9.81)


@pytest.mark.parametrize('kind', THREADS)
@pytest.mark.parametrize(
    ('sections', 'key', 'said'),
    [
        ({'trochlea': {'power': MASSLESS}}, 'power.massless', 'Leave it out'),
        ({'trochlea': {'cam': ARC}}, 'thread.kind', 'cam of kind involute'),
        ({'drag': {'coulomb': 1e-6}}, 'drag.coulomb', 'Use viscous or quadratic drag'),
        ({'escapement': RUBS}, 'rest.friction', 'Use viscous or quadratic drag'),
    ],
)
def test_what_does_not_go_with_them(kind, sections, key, said):
    with pytest.raises(SceneError) as caught:
        scene_of(THREADS[kind], **sections)
    assert caught.value.key.endswith(key)
    assert said in str(caught.value)


@pytest.mark.parametrize('kind', THREADS)
def test_a_release_beyond_what_the_thread_allows_is_refused(kind: str) -> None:
    with pytest.raises(SceneError, match=r'trochlea\.release_angle = 6\.0: is beyond the range'):
        compile_machine(scene_of(THREADS[kind], trochlea={'release_angle': 6.0}))


def test_the_roll_at_the_start_counts_for_a_swinging_thread_only() -> None:
    """At 0.3 rad and more of apparent tilt the wheel has wound up that much less or more."""
    ship = {'kind': 'components', 'components': [{'amplitude': 0.3, 'period': 8.0}]}
    near = compile_machine(scene_of(THREADS['hanging'])).range_rad - 0.01
    scene = scene_of(THREADS['hanging'], trochlea={'release_angle': near}, ship=ship)
    with pytest.raises(SceneError, match='with the roll at the start'):
        check_scene(scene)
    low = compile_machine(scene_of(THREADS['lever'])).range_rad - 0.01
    check_scene(scene_of(THREADS['lever'], trochlea={'release_angle': low}, ship=ship))
