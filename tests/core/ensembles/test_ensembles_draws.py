"""The draws for a ship: distributions as stated, ships and keys independent of each other."""

import numpy as np
import pytest
from scipy.stats import kstest, norm, truncnorm, uniform

from tauto_core.ensembles.fleets import Plan, as_draws, read_draws
from tauto_core.scene import load_scene
from tauto_core.scene.errors import SceneError

RADIUS = 'trochlea.cam.base_radius'
SCENE = load_scene('involute_weight_at_sea', duration=60.0)


def plan(ships=50, **draws):
    """Return a fleet. Keys have two underscores for a point."""
    said = {key.replace('__', '.'): draw for key, draw in draws.items()}
    return Plan(SCENE, SCENE.name, ships, as_draws(said, 'vary.yaml', SCENE), 'vary.yaml')


def drawn(key, ships, **draw):
    fleet = plan(ships, **{key: draw})
    return np.array([fleet.ship(k).drawn[key] for k in range(ships)])


@pytest.mark.parametrize(
    ('draw', 'law'),
    [
        ({'kind': 'normal', 'sigma': 2e-5}, norm(0.005, 2e-5)),
        ({'kind': 'normal', 'mean': 0.0055, 'sigma': 2e-5}, norm(0.0055, 2e-5)),
        (
            {'kind': 'normal', 'sigma': 2e-5, 'low': 0.005, 'high': 0.00504},
            truncnorm(0.0, 2.0, 0.005, 2e-5),
        ),
        ({'kind': 'uniform', 'low': 0.0045, 'high': 0.0055}, uniform(0.0045, 0.001)),
    ],
)
def test_values_follow_the_law_stated(draw, law):
    """Kolmogorov and Smirnov's test of 300 seeded values. 1 in 1000 would fail by chance."""
    assert SCENE.trochlea.cam.base_radius == 0.005
    assert kstest(drawn(RADIUS, 300, **draw), law.cdf).pvalue > 1e-3


def test_a_list_is_drawn_evenly():
    found = drawn('ship.sea.peak_period', 300, kind='list', values=[8.0, 9.0, 10.0])
    counts = [np.count_nonzero(found == value) for value in (8.0, 9.0, 10.0)]
    assert sum(counts) == 300
    assert min(counts) > 70  # 100 expected, standard deviation 8.2


def test_more_ships_and_more_keys_change_nothing_of_the_others():
    key, release = 'trochlea.release_angle', {'kind': 'uniform', 'low': 0.8, 'high': 1.2}
    few = plan(3, **{key: release})
    more = plan(
        30, ship__sea__peak_period={'kind': 'list', 'values': [8.0, 9.0]}, **{key: release}
    )
    for number in range(3):
        assert few.ship(number).drawn[key] == more.ship(number).drawn[key]
        assert few.ship(number).scene.seed == more.ship(number).scene.seed


def test_every_ship_has_a_seed_and_a_sea_of_her_own():
    fleet = plan(200)
    seeds = {fleet.ship(number).scene.seed for number in range(200)}
    assert len(seeds) == 200
    assert fleet.ship(0).scene == SCENE.model_copy(update={'seed': fleet.ship(0).scene.seed})


@pytest.mark.parametrize(
    ('draws', 'said'),
    [
        ({'trochlea__cam__base_radius': {'kind': 'normal', 'sigma': 0.1}}, '-0.'),
        ({'name': {'kind': 'normal', 'sigma': 1.0}}, 'not a number'),
    ],
)
def test_a_ship_that_cannot_be_is_refused_with_key_and_remedy(draws, said):
    with pytest.raises(SceneError) as caught:
        plan(**draws).check()
    message = str(caught.value)
    assert message.startswith('vary.yaml: ')
    assert next(iter(draws)).replace('__', '.').rsplit('.', 1)[0] in message
    assert 'as drawn' in message
    assert said in message


@pytest.mark.parametrize(
    ('key', 'said'),
    [
        ('trochlea.cam.base_radiu', 'Did you mean `base_radius`'),
        ('trochlae.cam.base_radius', 'Did you mean `trochlea`'),
        ('ship.kind.x', "ship.kind.x: there is no such key in the scene: ship.kind is '"),
        ('trochlea..release_angle', 'trochlea..release_angle: has an empty name. Write names'),
        ('', "'': has an empty name. Write names"),
    ],
)
@pytest.mark.parametrize(
    'draw', [{'kind': 'normal', 'sigma': 2e-5}, {'kind': 'list', 'values': ['a']}]
)
def test_a_key_that_no_scene_has_is_refused_in_the_words_of_set(key, said, draw):
    fleet = Plan(SCENE, 'x', 2, as_draws({key: draw}, 'vary.yaml', SCENE), 'vary.yaml')
    for refused in (fleet.check, lambda: load_scene('measured', **{key: 1.0})):
        with pytest.raises(SceneError) as caught:
            refused()
        assert said in str(caught.value)
        assert 'Narrow' not in str(caught.value)


@pytest.mark.parametrize(
    ('draw', 'said'),
    [
        ({'kind': 'normal'}, 'sigma'),
        ({'kind': 'normal', 'sigma': -1.0}, 'greater than 0'),
        ({'kind': 'normal', 'sigma': 1.0, 'low': 2.0, 'high': 1.0}, 'must be below'),
        ({'kind': 'uniform', 'low': 2.0, 'high': 1.0}, 'must be below'),
        ({'kind': 'uniform', 'low': 2.0}, 'high'),
        ({'kind': 'list', 'values': []}, 'at least 1'),
        ({'kind': 'list', 'values': [1.0, 'a']}, 'all numbers'),
        ({'kind': 'gauss', 'sigma': 1.0}, "'normal', 'uniform', 'list'"),
        (2.0, 'dictionary'),
    ],
)
def test_what_is_no_distribution_is_refused(draw, said):
    with pytest.raises(SceneError) as caught:
        as_draws({RADIUS: draw}, 'vary.yaml', SCENE)
    assert said in str(caught.value)
    assert str(caught.value).startswith(f'vary.yaml: {RADIUS}')


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(SceneError, match=r'none\.yaml.*cannot be read'):
        read_draws(tmp_path / 'none.yaml', SCENE)
