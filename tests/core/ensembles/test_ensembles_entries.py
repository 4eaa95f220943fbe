"""The entries of a comparison: one passage for all, refusals before anything starts."""

import math

import numpy as np
import pytest

from tauto_core.ensembles.comparison import (
    BEYOND_SULLY,
    CLOCKS,
    SHARED,
    make_entries,
    significant_roll_deg,
    with_roll,
)
from tauto_core.scene import load_scene, scene_yaml, shipped_scenes
from tauto_core.scene.errors import ABSENT, SceneError, UsageError
from tauto_core.ship import ShipMotion
from tauto_core.ship.imu import attitude
from tauto_core.ship.motions import Component, ComponentsShip


def rolling(name, *, base='second_cam_at_sea', duration=60.0, roll=0.1, **changes):
    harmonic = {'kind': 'components', 'components': [{'amplitude': roll, 'period': 9.0}]}
    ship = {**harmonic, 'rate': 10.0}
    return load_scene(base, name=name, duration=duration, ship=ship, **changes)


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a scene and returns its path as text."""

    def write(file: str, name: str | None = None, duration: float = 60.0, roll: float = 0.1):
        path = tmp_path / f'{file}.yaml'
        path.write_text(scene_yaml(rolling(name or file, duration=duration, roll=roll)))
        return str(path)

    return write


def test_the_shipped_clocks_differ_in_nothing_but_the_clock():
    clocks = [load_scene(name) for name in CLOCKS]
    everyone = (*CLOCKS, *BEYOND_SULLY)
    assert sorted(everyone) == [name for name in shipped_scenes() if name.startswith('clock_')]
    common = {*SHARED, 'drag', 'escapement', 'suspension'}
    # how the navigator expects the rate to walk belongs to the clock. The sampling rate follows
    # from its accuracy, for which a swinging thread needs more
    apart = {'drift': {'white_fm', 'random_walk_fm'}, 'ship': {'rate'}}
    alike = {'include': common, 'exclude': apart}
    first = clocks[0].model_dump(**alike)
    for clock in clocks:
        assert clock.model_dump(**alike) == first
        assert clock.trochlea.inertia == 4e-4
        assert clock.trochlea.release_angle == 1.0
        # how finely it is reckoned is no part of the clock
        assert clock.accuracy <= 1e-3


def test_the_clocks_beyond_sully_sail_in_the_same_sea():
    first, *others = [load_scene(name) for name in (CLOCKS[0], *BEYOND_SULLY)]
    alike = {'include': {*SHARED, 'suspension'}, 'exclude': {'drift': {'white_fm'}}}
    for clock in others:
        assert clock.model_dump(**alike) == first.model_dump(**alike)
        assert clock.drag == first.drag


def test_clocks_share_the_higher_sampling_rate():
    names = ('hanging_thread_at_sea', 'suspended_weight_at_sea')
    needed = [load_scene(name, duration=60.0).ship.rate for name in names]
    assert needed[0] < needed[1]
    entries = make_entries(names, ship_of=names[0], duration=60.0)
    assert {entry.scene.ship.rate for entry in entries} == {needed[1]}


@pytest.mark.parametrize(
    ('cases', 'hung'), [('both', [False, True]), ('with', [True]), ('without', [False])]
)
def test_clocks_are_compared_fixed_and_hung(write, cases, hung):
    entries = make_entries(CLOCKS[:2], duration=60.0, cases=cases)
    assert [(each.scene.name, each.hung) for each in entries] == [
        (name, how) for name in CLOCKS[:2] for how in hung
    ]
    path = write('fixed')
    if cases != 'with':
        assert [each.hung for each in make_entries([path], cases=cases)] == [False]
        return
    with pytest.raises(UsageError, match=r'fixed\.yaml has no suspension\. Write one'):
        make_entries([path], cases=cases)


def test_scenes_of_two_seas_are_refused_with_their_keys(write):
    one, other = write('one'), write('other', duration=120.0, roll=0.2)
    with pytest.raises(UsageError) as caught:
        make_entries([one, other])
    said = str(caught.value)
    assert f'{other} does not make the passage of {one}: duration = 120.0 against 60.0; ' in said
    assert 'ship.components' in said
    assert f'ship_of={one}' in said


def test_one_passage_can_be_taken_for_all(write):
    one, other = write('one'), write('other', duration=120.0, roll=0.2)
    entries = make_entries([one, other], ship_of=other, duration=30.0)
    for entry in entries:
        assert entry.scene.duration == 30.0
        assert entry.scene.ship == load_scene(other).ship


def test_overrides_of_the_passage_go_to_its_scene(write):
    one, other = write('one'), load_scene(write('other', duration=120.0))
    values = {'ship.components.0.amplitude': 0.1, 'drift.white_fm': 2.0, 'clock.white_fm': 3.0}
    [entry] = make_entries([one], ship_of=other, overrides=values)
    assert entry.scene.ship.components[0].amplitude == 0.1
    assert (entry.scene.drift.white_fm, entry.scene.clock.white_fm) == (2.0, 3.0)
    assert entry.scene.duration == 120.0


def test_a_clock_keeps_its_noise_on_another_passage(write):
    entries = make_entries(['clock_hanging_thread', write('one')], ship_of=write('two'))
    assert [entry.scene.drift.white_fm for entry in entries] == [45.0, 45.0, None]


def test_two_rows_of_one_name_are_refused(write):
    with pytest.raises(UsageError, match="has the same name, 'same'"):
        make_entries([write('one', 'same'), write('other', 'same')])
    with pytest.raises(UsageError, match='a roll comes twice'):
        make_entries([write('one')], rolls_deg=[5.0, 5.0])


def test_a_bad_duration_names_the_key_before_anything_starts(write):
    with pytest.raises(SceneError, match=r'duration = -1\.0'):
        make_entries([write('one')], duration=-1.0)


def test_a_roll_that_carries_the_release_off_the_cam_is_refused():
    changed = {
        'trochlea.cam': {'kind': 'weight_corrected', 'period': 1.0},
        'trochlea.power.mass': 0.3,
        'trochlea.release_angle': 5.3,
    }
    off = rolling('off', base='involute_weight_at_sea', roll=0.01, **changed)
    make_entries([off])
    with pytest.raises(SceneError, match=r'off: trochlea\.release_angle = 5\.3'):
        make_entries([off], rolls_deg=[30.0])


CORK = {'ship.hull': ABSENT, 'ship.roll.slope_coefficient': 0.7, 'ship.heave': True}
"""A ship without a hull, with a roll that can be chosen."""


@pytest.mark.parametrize('roll_deg', [0.0, 30.0])
def test_the_significant_roll_is_twice_its_root_mean_square(roll_deg):
    """Over 64 components and 10 h the mean square is known to 5 %, so the root to 3 %."""
    scene = load_scene('second_cam_at_sea', duration=36_000.0, **CORK, **{'ship.rate': 20.0})
    rolled = with_roll(scene, roll_deg)
    felt = attitude(ShipMotion(rolled).produce(720_000)).roll
    twice = 2.0 * math.degrees(float(np.sqrt(np.mean(felt**2))))
    assert twice == pytest.approx(roll_deg, rel=0.03)
    assert significant_roll_deg(rolled) == pytest.approx(roll_deg, rel=1e-14)
    assert rolled.ship.sea == scene.ship.sea
    assert 'slope_coefficient' in scene_yaml(rolled)


def test_a_roll_by_response_operator_is_scaled_with_it():
    scene = load_scene('buoy_44004_supply', duration=60.0)
    rolled = with_roll(scene, 5.0)
    assert significant_roll_deg(rolled) == pytest.approx(5.0, rel=1e-14)
    assert rolled.ship.rao.heave_real == scene.ship.rao.heave_real


def test_a_harmonic_rolls_by_the_root_of_two_of_its_amplitude():
    ship = ComponentsShip(components=(Component(amplitude=0.1, period=9.0),))
    scene = load_scene('ideal').model_copy(update={'ship': ship})
    assert significant_roll_deg(scene) == pytest.approx(math.degrees(0.1 * math.sqrt(2.0)))
    rolled = with_roll(scene, 10.0)
    assert rolled.ship.components[0].amplitude == pytest.approx(math.radians(10.0) / 2.0**0.5)


@pytest.mark.parametrize(
    ('name', 'roll_deg', 'words'),
    [
        ('second_cam_at_sea', 46.0, 'must be between 0 and 45 degrees'),
        ('second_cam_at_sea', math.nan, 'must be between 0 and 45 degrees'),
        ('ideal', 10.0, r'ship\.kind still\) is zero'),
        ('measured', 10.0, r'ship\.kind recorded\) was measured'),
    ],
)
def test_a_roll_that_cannot_be_made_is_refused(name, roll_deg, words):
    with pytest.raises(UsageError, match=words):
        with_roll(load_scene(name), roll_deg)
