"""Numbers of a machine out of all proportion are refused by their key, before any overflow."""

import pytest

from tauto_core.scene import SceneError, load_scene

SCENES = {
    'regulator': 'globe_in_oil',
    'suspension': 'suspended_weight_at_sea',
    'trochlea.thread': 'sully_lever_at_sea',
}


def parsed(key, value):
    """A shipped scene with one number changed."""
    name = SCENES.get(key.rpartition('.')[0], 'involute_weight_at_sea')
    return load_scene(name, **{key: value})


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
