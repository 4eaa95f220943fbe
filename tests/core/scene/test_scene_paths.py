"""Keys of a scene by their paths: reading, setting, and data files."""

import os
from pathlib import Path

import pytest

from tauto_core.scene import SceneError, load_scene
from tauto_core.scene.loader import put_value, remove_at, value_at


def test_a_path_leads_through_mappings_and_lists() -> None:
    content = {'voyage': {'waypoints': [[48.5, -6.0], [32.6, -16.9]]}, 'seed': None}
    assert value_at(content, 'voyage.waypoints.1.0') == 32.6
    for absent in ('voyage.arrival', 'voyage.waypoints.2', 'voyage.waypoints.x', 'seed.x', 'a.b'):
        assert value_at(content, absent) is None


def test_a_value_is_set_in_place_and_sections_are_added() -> None:
    content: dict[str, object] = {'voyage': {'waypoints': [[48.5, -6.0]]}, 'drift': None}
    for path, value in (('voyage.waypoints.0.1', -7.0), ('drift.lunars.sigma', 60.0), ('seed', 4)):
        put_value(content, path, value, 'scene')
    assert content == {
        'voyage': {'waypoints': [[48.5, -7.0]]},
        'drift': {'lunars': {'sigma': 60.0}},
        'seed': 4,
    }


def test_what_is_removed_is_gone_and_what_is_not_there_is_left() -> None:
    content: dict[str, object] = {'voyage': {'waypoints': [1.0, 2.0]}, 'seed': 3}
    for path in ('voyage.waypoints.0', 'seed', 'drag', 'drag.viscous', 'voyage.waypoints.7'):
        remove_at(content, path)
    assert content == {'voyage': {'waypoints': [2.0]}}


@pytest.mark.parametrize('path', ['seed.x', 'seed.x.y', 'list.1', 'list.x', 'list.1.y'])
def test_a_path_through_a_value_is_no_path(path: str) -> None:
    with pytest.raises(SceneError, match='there is no such key'):
        put_value({'seed': 1, 'list': [0]}, path, 2, 'scene')


def test_an_override_equals_a_changed_file(tmp_path: Path) -> None:
    text = Path(load_scene.__globals__['_SHIPPED'], 'involute_weight_at_sea.yaml').read_text()
    assert text.count('peak_period: 9.0') == 1
    file = tmp_path / 'involute_weight_at_sea.yaml'
    file.write_text(text.replace('peak_period: 9.0', 'peak_period: 7.5'))
    changed = load_scene('involute_weight_at_sea', **{'ship.sea.peak_period': 7.5})
    assert changed == load_scene(file)
    assert changed != load_scene('involute_weight_at_sea')


@pytest.mark.parametrize(
    ('path', 'value', 'key', 'words'),
    [
        ('ship.sea.peak_period', -1.0, 'ship.sea.peak_period', 'ship.sea.peak_period is given'),
        ('ship.sea', {'kind': 'x'}, 'ship.sea.spectrum', r'\(ship.sea is given, in place'),
        ('ship.sea.peak_perod', 7.0, 'ship.sea.peak_perod', 'Did you mean `peak_period`'),
        ('duration.minutes', 7.0, 'duration.minutes', 'no such key'),
    ],
)
def test_a_refused_value_names_the_path_that_gave_it(path, value, key, words):
    with pytest.raises(SceneError, match=words) as caught:
        load_scene('involute_weight_at_sea', **{path: value})
    assert key in [each.key for each in caught.value.problems]


def test_data_that_are_given_lie_in_the_working_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'arm.csv').write_text('angle_rad,lever_arm_m\n0,0\n1,0.005\n2,0.01\n')
    scene = load_scene('measured', **{'trochlea.cam': {'kind': 'table', 'path': 'arm.csv'}})
    assert scene.trochlea is not None
    assert getattr(scene.trochlea.cam, 'path', None) == os.path.join(tmp_path, 'arm.csv')
