"""A ship that only rolls and heaves: the clock's readings without a message in between."""

import math

import numpy as np
import pytest

from tauto_core.clockwork import TrochleaStage
from tauto_core.samples import JOINT_STATES, PHASE, SHIP_IMU, ImuSamples, PlanarImu
from tauto_core.scene import load_scene
from tauto_core.ship import ShipMotion, kernels
from tauto_core.ship.imu import message, read_force, read_roll

G = 9.81


def sensed(n, size, heave=1.0):
    """Rolls up to a size, and heaves that now and then throw the clock's weight upwards."""
    rng = np.random.default_rng(n)
    roll, rate, bend, up = rng.normal(size=(4, n))
    roll *= size / np.max(np.abs(roll))
    roll[::7] = 0.0
    return PlanarImu(np.arange(n), roll, rate, lambda: (bend, heave * up), 2.0, G)


@pytest.mark.parametrize('size', [1e-3, 0.3, 1.5, math.pi])
@pytest.mark.parametrize('n', [1, 7, 8, 203])
def test_the_clock_reads_the_bits_that_the_message_says(n, size):
    imu = sensed(n, size, heave=8.0)
    said = message(imu)
    found, wanted = np.empty((2, 4, n))
    read_roll(imu, found[0], found[1])
    read_force(imu, found[2], found[3])
    kernels.roll_of(said.orientation, said.angular_velocity, wanted[0], wanted[1])
    kernels.force_of(said.linear_acceleration, wanted[2], wanted[3])
    assert found.tobytes() == wanted.tobytes()
    if n > 100:
        assert np.any(wanted[3] < 0.0)  # some forces point down in the case


@pytest.mark.parametrize('name', ['second_cam_at_sea', 'involute_weight_at_sea', 'measured'])
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
def test_what_may_overflow_comes_as_a_message(height):
    """It is screened, and refused under the name of its fault. A checked scene has less height."""
    ship = {'kind': 'components', 'components': [{'amplitude': 0.5, 'period': 0.5}]}
    scene = load_scene('second_cam_at_sea', duration=60.0, ship=ship)
    high = scene.ship.model_copy(update={'height': height})
    sensed = ShipMotion(scene.model_copy(update={'ship': high})).sense(10)
    assert isinstance(sensed, PlanarImu if height < 1e149 else ImuSamples)
