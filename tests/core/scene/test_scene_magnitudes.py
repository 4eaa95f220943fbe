"""Numbers of a machine out of all proportion are refused by their key, before any overflow."""

from typing import Any

import pytest
import yaml

from tauto_core.scene.errors import SceneError
from tauto_core.scene.loader import parse_scene

TROCHLEA = {
    'inertia': 4e-4,
    'cam': {'kind': 'involute', 'base_radius': 0.01},
    'thread': {'kind': 'lever', 'arm': 0.1, 'weight_arm': 0.15, 'length': 0.3},
    'power': {'kind': 'weight', 'mass': 0.05},
    'release_angle': 1.0,
}
GLOBE = {
    'kind': 'fluid_tautochrone',
    'body': 'globe',
    'diameter': 0.05,
    'body_density': 7800.0,
    'fluid_density': 900.0,
    'pendulum_length': 1.0,
    'release_arc': 0.1,
}
HUNG = {
    'kind': 'axle',
    'support_radius': 0.02,
    'axle_radius': 0.005,
    'depth': 0.1,
    'gyration_radius': 0.05,
}
ROLL = {'kind': 'components', 'components': [{'amplitude': 0.1, 'period': 9.0}]}


def parsed(key, value):
    """A scene with one number changed."""
    content = {'name': 'test', 'duration': 10.0, 'gravity': 9.8, 'ship': ROLL}
    if key.startswith('regulator'):
        content |= {'regulator': dict(GLOBE), 'ship': {'kind': 'still'}}
    else:
        trochlea = {
            name: dict(part) if isinstance(part, dict) else part for name, part in TROCHLEA.items()
        }
        content |= {'trochlea': trochlea, 'suspension': dict(HUNG), 'drag': {}}
    *path, last = key.split('.')
    section: Any = content
    for name in path:
        section = section[name]
    section[last] = value
    return parse_scene(yaml.safe_dump(content), 'test')


@pytest.mark.parametrize(
    'key',
    [
        'gravity',
        'trochlea.inertia',
        'trochlea.cam.base_radius',
        'trochlea.thread.length',
        'trochlea.power.mass',
        'suspension.depth',
        'suspension.gyration_radius',
        'regulator.diameter',
        'regulator.pendulum_length',
    ],
)
@pytest.mark.parametrize(('value', 'limit'), [(1e-300, 'at least 1e-30'), (1e300, 'at most 1e')])
def test_sizes_out_of_all_proportion(key, value, limit):
    with pytest.raises(SceneError, match=limit) as caught:
        parsed(key, value)
    assert (caught.value.key, caught.value.value) == (key, value)


@pytest.mark.parametrize(
    'key',
    [
        'trochlea.release_angle',
        'trochlea.thread.inertia',
        'drag.quadratic',
        'regulator.fluid_density',
        'regulator.release_arc',
    ],
)
def test_what_is_only_added_may_be_as_small_as_it_likes(key):
    parsed(key, 1e-300)
    with pytest.raises(SceneError, match='at most') as caught:
        parsed(key, 1e200)
    assert caught.value.key == key
