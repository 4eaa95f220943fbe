"""A hull in the sea of a scene: the IMU readings and the effect on a clock (hull.md)."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.ensembles.comparison import with_roll
from tauto_core.samples import FloatArray, ImuSamples
from tauto_core.scene import Scene, load_scene, parse_scene, scene_yaml
from tauto_core.scene.errors import SceneError, UsageError
from tauto_core.ship.hull import named_hull
from tauto_core.ship.source import ShipMotion
from tauto_core.voyage import sail

DAY_S = 86_400.0
G = 9.80665
SIX = 'shipped:supply_rao/supply_six.csv'
CAPSIZES = {'shape': 'deptford', 'centre_of_gravity': 0.8}
CLOCK = """\
name: in_a_hull
duration: 36000.0
trochlea:
  inertia: 4.0e-4
  cam: {kind: involute, base_radius: 0.0053681}
  thread: {kind: vertical}
  power: {kind: weight, mass: 0.3, massless: true}
  release_angle: 1.0
ship:
  kind: sea
  rate: 10.0
  height: 3.0
  hull: deptford
  clock: {forward: 12.0}
  heading: 3.14159
  roll: {natural_period: 11.0, damping_ratio: 0.08}
  sea: {spectrum: bretschneider, significant_wave_height: 2.5, peak_period: 9.0}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Any:
    def made(without: tuple[str, ...] = (), **overrides: object) -> Scene:
        file = tmp_path / 'in_a_hull.yaml'
        lines = CLOCK.splitlines()
        kept = (line for line in lines if not line.strip().startswith(without or ('#',)))
        file.write_text('\n'.join(kept))
        return load_scene(str(file), **overrides)

    return made


def level_accelerations(imu: ImuSamples) -> FloatArray:
    turned = Rotation.from_quat(imu.orientation).apply(imu.linear_acceleration)
    return np.asarray(turned - np.array([0.0, 0.0, G]))


def rates(ready: Scene) -> tuple[float, float]:
    """Return the dial's rate, and the mean of sqrt(|f|/g) - 1 in the thread's plane [s/day]."""
    from tauto_core.ship.imu import force_in_plane

    assert ready.trochlea is not None
    motion = ShipMotion(ready)
    force = force_in_plane(motion.produce(motion.total), ready.trochlea.thread_plane)
    size = np.hypot(force[:, 1], force[:, 2])
    felt = DAY_S * float(np.mean(np.sqrt(size / G)) - 1.0)
    still = sail(scene_on_land(ready)).result['clock']['rate_s_per_day']
    return sail(ready).result['clock']['rate_s_per_day'] - still, felt


def scene_on_land(ready: Scene) -> Scene:
    from tauto_core.ship.motions import StillShip

    return ready.model_copy(update={'ship': StillShip()})


@pytest.mark.parametrize(
    ('plane', 'printed'), [('vertical', -53.8), ('free', -46.8), ('ship', -91.0)]
)
def test_a_weight_in_head_seas_loses_by_its_plane(scene: Any, plane: str, printed: float) -> None:
    """Third row of hull.md's table. Its hull has another centre of gravity, by a metre or so."""
    found, felt = rates(scene(**{'trochlea.plane': plane}))
    # waves of 9 s are slow compared with a swing of 1 s: the next order is (1/9)², of a third
    assert found == pytest.approx(felt, rel=0.03)
    # ten hours of 64 waves have the mean square of the spectrum to some per cent
    assert found == pytest.approx(printed, rel=0.08)


def test_weather_has_six_motions_too(scene: Any) -> None:
    states = [
        {'at': 0.0, 'significant_wave_height': 1.0, 'peak_period': 7.0},
        {'at': 2400.0, 'significant_wave_height': 3.0, 'peak_period': 9.0},
    ]
    weather = {'kind': 'states', 'states': states}
    ready = scene(('sea:',), **{'duration': 4800.0, 'ship.weather': weather})
    motion = ShipMotion(ready)
    acceleration = level_accelerations(motion.produce(motion.total))
    early, late = (np.sqrt(np.mean(part**2, axis=0)) for part in np.split(acceleration[:-5], 2))
    assert np.all(late[[0, 2]] > early[[0, 2]])
    assert np.all(early[[0, 2]] > 0.01)


def test_the_scene_of_a_bag_contains_the_file_of_the_hull(scene: Any, tmp_path: Path) -> None:
    named_hull('sloop').save(tmp_path / 'mine.npz')
    by_file = scene(**{'ship.hull': {'path': str(tmp_path / 'mine.npz'), 'length': 31.0}})
    (tmp_path / 'mine.npz').unlink()
    again = parse_scene(scene_yaml(by_file), 'a bag')
    assert again == by_file
    by_name = scene(**{'ship.hull': {'shape': 'sloop', 'length': 31.0}})
    ours, theirs = (ShipMotion(each).produce(50) for each in (again, by_name))
    np.testing.assert_array_equal(ours.linear_acceleration, theirs.linear_acceleration)


def test_a_hull_sets_the_cutoff_of_the_sea(scene: Any) -> None:
    """Waves of a tenth of 44 m. A given cutoff stands, and a bag keeps it."""
    ready = scene()
    shortest = 2.0 * math.pi * G / (ready.ship.sea.cutoff * 2.0 * math.pi / 9.0) ** 2
    assert shortest == pytest.approx(4.4, rel=1e-12)
    assert parse_scene(scene_yaml(ready), 'a bag') == ready
    assert scene(**{'ship.sea.cutoff': 4.0}).ship.sea.cutoff == 4.0
    state = {'at': 0.0, 'significant_wave_height': 1.0, 'peak_period': 9.0}
    weather = {'kind': 'states', 'states': [state]}
    changing = scene(('sea:',), **{'ship.weather': weather})
    again = parse_scene(scene_yaml(changing), 'a bag')
    for each in (changing, again):
        [found] = each.ship.states(each)
        assert found.sea.cutoff == ready.ship.sea.cutoff
    cork = scene(
        ('sea:', 'hull:', 'clock:'),
        **{'ship.weather': weather, 'ship.roll.slope_coefficient': 0.7},
    )
    assert cork.ship.weather.cutoff == 4.0


@pytest.mark.parametrize(
    ('changes', 'key', 'said'),
    [
        ({'ship.hull': 'slop'}, 'ship.hull.shape', 'Did you mean sloop'),
        ({'ship.hull': {'shape': 'sloop', 'length': 440.0}}, 'ship.hull.length', '400'),
        ({'ship.hull': {'length': 30.0}}, 'ship.hull', 'neither a shape nor a path'),
        ({'ship.hull': {'path': 'none.npz'}}, 'ship.hull.path', 'no such file'),
        ({'ship.hull': CAPSIZES}, 'ship.hull.centre_of_gravity', 'metacentre, 0.699 m .* caps'),
        ({'ship.rao': {'path': SIX}}, 'ship.rao', 'does not go with ship.roll'),
        ({'ship.clock': {'forward': 30.0}}, 'ship.clock.forward', 'outside the hull'),
        ({'ship.height': -9.0}, 'ship.height', 'outside the hull'),
        ({'ship.speed': 12.0}, 'ship.speed', 'Froude'),
        ({'ship.roll.natural_period': 2.0}, 'ship.roll.natural_period', 'period'),
        ({'without': ('hull:',)}, 'ship.roll.slope_coefficient', 'no hull'),
        ({'without': ('hull:',), 'ship.roll.slope_coefficient': 0.7}, 'ship.clock', 'in a hull'),
        (
            {'trochlea.plane': 'free', 'trochlea.thread': {'kind': 'hole', 'distance': 0.08},
             'trochlea.cam': {'kind': 'hole', 'lever_rate': 0.01}},
            'trochlea.plane',
            'guided or swings',
        ),
    ],
)  # fmt: skip
def test_refused(scene: Any, changes: dict[str, Any], key: str, said: str) -> None:
    with pytest.raises(SceneError, match=said) as caught:
        ShipMotion(scene(**changes))
    assert caught.value.key == key


def test_a_hull_with_an_operator_and_without_a_roll_is_refused(scene: Any) -> None:
    with pytest.raises(SceneError, match=r'does not go with ship\.rao: the motions') as caught:
        scene(('roll:',), **{'ship.rao': {'path': SIX}})
    assert caught.value.key == 'ship.hull'


def test_a_file_that_is_no_hull_is_refused_by_its_name(scene: Any, tmp_path: Path) -> None:
    file = tmp_path / 'mine.npz'
    file.write_bytes(b'a,b\n1,2\n')
    with pytest.raises(SceneError, match=r'it is not an \.npz file') as caught:
        scene(**{'ship.hull': {'path': str(file)}})
    assert str(file) in str(caught.value)


def test_heave_beside_a_hull_is_legal_and_changes_nothing(scene: Any) -> None:
    plain, asked = (
        ShipMotion(scene(**{'ship.heave': heave})).produce(50) for heave in (False, True)
    )
    np.testing.assert_array_equal(plain.linear_acceleration, asked.linear_acceleration)


# at 40 m/s waves are also too fast for the samples, and more samples would not help
@pytest.mark.parametrize('speed', [9.0, 40.0])
def test_a_leg_that_is_too_fast_is_named(scene: Any, speed: float) -> None:
    voyage = {'departure': [0.0, 0.0], 'arrival': [0.0, 5.0], 'sails_at': 0.0, 'speed': speed}
    states = [{'at': 60.0, 'significant_wave_height': 1.0, 'peak_period': 9.0}]
    weather = {'kind': 'states', 'follow_route': True, 'states': states}
    keys = {'ship.weather': weather, 'voyage': voyage, 'duration': 86_400.0}
    with pytest.raises(SceneError, match=r'leg from voyage\.departure to voyage\.arr') as caught:
        ShipMotion(scene(('sea:',), **keys))
    assert caught.value.key == 'ship.weather.states[0]'
    assert 'Froude number of 0.25' in str(caught.value)


def test_the_answer_says_that_a_ship_has_no_hull(scene: Any) -> None:
    short = {'duration': 60.0}
    cork = scene(
        ('hull:', 'clock:'), **short, **{'ship.heave': True, 'ship.roll.slope_coefficient': 0.7}
    )
    assert sail(cork).result['answer'].endswith('ship.hull gives it one.')
    ship = sail(scene(**short)).result
    assert 'ship.hull' not in ship['answer']
    assert ship['sea']['hull'] == 'deptford'
    assert 'ship.hull' not in sail(load_scene('buoy_44004_supply', **short)).result['answer']


def test_the_roll_of_a_hull_cannot_be_scaled(scene: Any) -> None:
    with pytest.raises(UsageError, match='follows from the hull'):
        with_roll(scene(), 5.0)


@pytest.mark.usefixtures('short_trials')
def test_scene_check_names_the_hull_or_its_absence() -> None:
    def hull_row(*settings: str) -> str:
        options = [word for setting in settings for word in ('--set', setting)]
        command = ['scene', 'check', 'involute_weight_at_sea', *options]
        result = CliRunner().invoke(app, command)
        return next(line for line in result.stdout.splitlines() if line.startswith('hull '))

    without = ('ship.hull=null', 'ship.heave=true', 'ship.roll.slope_coefficient=0.7')
    assert 'none: it heaves' in hull_row(*without)
    assert 'sloop' in hull_row('ship.hull=sloop')
