"""The ship as a source: independent of the split, resumable, right at any time."""

import subprocess
import sys
from dataclasses import fields
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tauto_core.clockwork import TrochleaStage
from tauto_core.samples import JOINT_STATES, PHASE, SHIP_IMU, ImuSamples, SpatialImu, join
from tauto_core.scene import Scene, load_scene
from tauto_core.ship import LOOKAHEAD, ShipMotion, attitude

SCENES = Path(__file__).parents[1] / 'scenes_ref'
ROLL = {'natural_period': 11.0, 'damping_ratio': 0.08}
SEA = {'significant_wave_height': 2.5, 'peak_period': 9.0}
STATES = [{'at': 0.0, **SEA}, {'at': 600.0, 'still': True}, {'at': 1200.0, **SEA}]
CHANGING = {
    'kind': 'sea',
    'height': 3.0,
    'rate': 5.0,
    'heave': True,
    'roll': {**ROLL, 'slope_coefficient': 0.7},
    'weather': {'kind': 'states', 'states': STATES},
}
HULL = {
    'kind': 'sea',
    'hull': 'deptford',
    'clock': {'forward': 12.0},
    'heading': 3.1,
    'roll': ROLL,
    'sea': {'spectrum': 'bretschneider', **SEA},
}
KINDS = {
    'still': lambda: load_scene('ideal', duration=1200.0),
    'components': lambda: load_scene(SCENES / 'e4_weight_roll_heave.yaml', duration=60.0),
    'sea': lambda: load_scene('involute_weight_at_sea', duration=60.0),
    'recorded': lambda: load_scene('measured', duration=60.0),
    'real': lambda: load_scene('buoy_44004_supply', duration=60.0),
    'weather': lambda: load_scene('ideal', ship=CHANGING, duration=1320.0),
    'hull': lambda: load_scene('ideal', ship=HULL, duration=300.0),
}


@cache
def scene_of(kind: str) -> Scene:
    return KINDS[kind]()


@cache
def whole(kind: str) -> ImuSamples:
    return ShipMotion(scene_of(kind)).produce(10**6)


def assert_same(a: ImuSamples, b: ImuSamples) -> None:
    for field in fields(a):
        np.testing.assert_array_equal(getattr(a, field.name), getattr(b, field.name))


@pytest.mark.parametrize('kind', sorted(KINDS))
@settings(max_examples=2, deadline=None)
@given(counts=st.lists(st.integers(1, 700), max_size=12))
@example(counts=[1] * 20)
@example(counts=[1, 511, 512, 1999, 3100, 400])  # beyond a block, and each state of the weather
def test_bits_do_not_depend_on_the_split_nor_on_a_resume(kind, counts):
    scene = scene_of(kind)
    ship = ShipMotion(scene)
    parts = []
    for count in counts:
        parts.append(ship.produce(count))
        state = ship.state()
        ship = ShipMotion(scene)
        ship.restore(state)
    parts.append(ship.produce(10**6))
    assert_same(join(parts), whole(kind))
    assert len(ship.produce(5).stamp_ns) == 0


def test_stamps_and_number_of_samples():
    moving, still = whole('components'), whole('still')
    assert len(moving.stamp_ns) == 60 * 20 + 1 + LOOKAHEAD
    start = scene_of('components').starts_at_ns
    assert moving.stamp_ns[[0, 1, -1]].tolist() == [
        start,
        start + 50_000_000,
        start + 1204 * 50_000_000,
    ]
    scene = scene_of('still')
    assert len(still.stamp_ns) == scene.log_count
    assert np.diff(still.stamp_ns).tolist() == [scene.log_interval_ns] * (scene.log_count - 1)


def test_still_ship_feels_gravity_alone():
    imu = whole('still')
    assert (imu.orientation == [0.0, 0.0, 0.0, 1.0]).all()
    assert (imu.angular_velocity == 0.0).all()
    assert (imu.linear_acceleration == [0.0, 0.0, scene_of('still').gravity]).all()


def test_heave_alone_leaves_the_roll_at_zero():
    heave = [{'amplitude': 1.0, 'period': 10.0}]
    ship = {'kind': 'components', 'heave': heave, 'rate': 20.0}
    felt = attitude(ShipMotion(load_scene('ideal', ship=ship, duration=60.0)).produce(201))
    assert (felt.roll == 0.0).all()
    assert (felt.force_y == 0.0).all()
    # half a period after the crest the ship is lifted by w^2
    expected = load_scene('ideal').gravity + (2.0 * np.pi / 10.0) ** 2
    assert felt.force_z[100] == pytest.approx(expected, rel=1e-15)


IMPORTS = """
import sys, tauto_core.ship
assert not {'llvmlite', 'scipy', 'rosbags', 'mcap'} & set(sys.modules)
from tauto_core.scene import load_scene
for name in ('measured', 'buoy_44004_supply'):
    tauto_core.ship.ShipMotion(load_scene(name))
assert 'scipy' not in sys.modules
"""


def test_a_ship_imports_nothing_slow():
    """Importing scipy.interpolate takes longer than all the rest of a warm start."""
    assert subprocess.run([sys.executable, '-c', IMPORTS], check=False).returncode == 0


@pytest.mark.parametrize('name', ['second_cam_at_sea', 'measured'])
def test_a_clock_goes_alike_by_messages_and_without(name):
    scene = load_scene(name, duration=60.0)
    stages = [TrochleaStage(scene), TrochleaStage(scene)]
    ships = [ShipMotion(scene), ShipMotion(scene)]
    for n in (311, ships[0].total):
        (one, other) = (
            stage.feed({SHIP_IMU: imu})
            for stage, imu in zip(stages, (ships[0].produce(n), ships[1].sense(n)), strict=True)
        )
        for topic in (JOINT_STATES, PHASE):
            assert one[topic].position.tobytes() == other[topic].position.tobytes()
            assert one[topic].velocity.tobytes() == other[topic].velocity.tobytes()


@pytest.mark.parametrize('height', [0.0, 1e149, 1e308])
def test_samples_that_may_overflow_come_as_a_message(height):
    """It is screened, and refused under the name of its fault. A checked scene has less height."""
    ship = {'kind': 'components', 'components': [{'amplitude': 0.5, 'period': 0.5}]}
    scene = load_scene('second_cam_at_sea', duration=60.0, ship=ship)
    high = scene.ship.model_copy(update={'height': height})
    sensed = ShipMotion(scene.model_copy(update={'ship': high})).sense(10)
    assert isinstance(sensed, SpatialImu if height < 1e149 else ImuSamples)
