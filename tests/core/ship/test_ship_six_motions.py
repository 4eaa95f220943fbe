"""What an IMU reads on a ship with six motions, and the force that a thread can follow."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tauto_core.samples import FloatArray, ImuSamples, SpatialImu, join, take
from tauto_core.scene import Scene, load_scene
from tauto_core.ship import ShipMotion
from tauto_core.ship.imu import (
    ShipAngles,
    ThreadPlane,
    force_in_plane,
    imu_from_motions,
    message,
    parted,
)
from tauto_core.ship.waves import Harmonics, SampledHarmonics

G = 9.81
N = 400


def motion() -> tuple[ShipAngles, ShipAngles, tuple[FloatArray, ...]]:
    random = np.random.default_rng(1724)
    angle = ShipAngles(*random.uniform(-0.6, 0.6, (3, N)))
    rate = ShipAngles(*random.uniform(-0.5, 0.5, (3, N)))
    return angle, rate, tuple(random.uniform(-3.0, 3.0, (3, N)))


def turned(angle: ShipAngles) -> Rotation:
    return Rotation.from_euler('ZYX', np.stack((angle.yaw, angle.pitch, angle.roll), axis=1))


def test_orientation_and_force_are_those_of_scipys_rotations() -> None:
    angle, rate, acceleration = motion()
    imu = imu_from_motions(np.arange(N), angle, rate, acceleration, G)
    from_ship = turned(angle)
    same = np.abs(np.sum(imu.orientation * from_ship.as_quat(), axis=1))
    np.testing.assert_allclose(same, 1.0, atol=1e-15)
    level = np.stack(acceleration, axis=1) + np.array([0.0, 0.0, G])
    np.testing.assert_allclose(imu.linear_acceleration, from_ship.inv().apply(level), atol=1e-14)


def test_the_turning_is_the_derivative_of_the_orientation() -> None:
    angle, rate, acceleration = motion()
    imu = imu_from_motions(np.arange(N), angle, rate, acceleration, G)
    h = 1e-5
    ahead, behind = (
        turned(ShipAngles(*(a + s * h * r for a, r in zip(angle, rate, strict=True))))
        for s in (1.0, -1.0)
    )
    # in the ship's axes, by central differences: h² times a third derivative of about 1
    found = (behind.inv() * ahead).as_rotvec() / (2.0 * h)
    np.testing.assert_allclose(imu.angular_velocity, found, atol=1e-9)


def test_a_free_thread_pulls_with_the_whole_force() -> None:
    angle, rate, acceleration = motion()
    imu = imu_from_motions(np.arange(N), angle, rate, acceleration, G)
    found = force_in_plane(imu, 'free')
    x, y, z = acceleration
    # |f| does not change as the ship turns
    size = np.hypot(found[:, 1], found[:, 2])
    np.testing.assert_allclose(size, np.sqrt(x**2 + y**2 + (z + G) ** 2))
    along = np.arctan2(imu.linear_acceleration[:, 1], imu.linear_acceleration[:, 2])
    np.testing.assert_allclose(np.arctan2(found[:, 1], found[:, 2]), along, atol=1e-15)


def test_gimbals_leave_the_force_of_a_plane_that_only_rolls() -> None:
    """The case has the ship's roll and yaw but not her pitch."""
    angle, rate, acceleration = motion()
    imu = imu_from_motions(np.arange(N), angle, rate, acceleration, G)
    level = np.stack(acceleration, axis=1) + np.array([0.0, 0.0, G])
    case = turned(ShipAngles(angle.roll, np.zeros(N), angle.yaw)).inv().apply(level)
    np.testing.assert_allclose(force_in_plane(imu, 'vertical')[:, 1:], case[:, 1:], atol=1e-14)


ROLL = {'natural_period': 11.0, 'damping_ratio': 0.08}
HULL = {'ship.hull': 'deptford', 'ship.speed': 2.0, 'duration': 120.0, 'ship.rate': 10.0}
CHANGING = [
    {'at': t, 'significant_wave_height': h, 'peak_period': 8.0} for t, h in ((0, 1), (900, 3))
]


def at_sea(name: str = 'involute_weight_at_sea', **changes: object) -> Scene:
    return load_scene(name, **{**HULL, **changes})


@pytest.mark.parametrize('changing', [False, True])
def test_what_a_clock_needs_has_the_bits_of_the_whole_message(changing: bool) -> None:
    scene = at_sea()
    if changing:
        weather = {'kind': 'states', 'states': CHANGING}
        ship = {'kind': 'sea', 'weather': weather, 'roll': ROLL, 'hull': 'deptford', 'rate': 10.0}
        scene = load_scene('involute_weight_at_sea', duration=120.0, ship=ship)
    whole, motion = ShipMotion(scene).produce(700), ShipMotion(scene)
    for part in (slice(0, 90), slice(90, 700)):  # in other batches
        sensed = motion.sense(part.stop - part.start)
        assert isinstance(sensed, SpatialImu)
        both, force, turning = (
            sensed.samples(*needed, slice(None))
            for needed in ((True, True), (False, True), (True, False))
        )
        for imu in (both, force, turning):
            assert imu.orientation.tobytes() == whole.orientation[part].tobytes()
        for imu in (both, force):
            felt = imu.linear_acceleration
            assert felt.tobytes() == whole.linear_acceleration[part].tobytes()
        for imu in (both, turning):
            turned = imu.angular_velocity
            assert turned.tobytes() == whole.angular_velocity[part].tobytes()
        assert force.angular_velocity.shape == turning.linear_acceleration.shape == (0, 3)


def test_parts_that_fit_the_cache_have_the_bits_of_the_whole(monkeypatch):
    monkeypatch.setattr('tauto_core.samples.IN_CACHE', 512)
    motion = ShipMotion(at_sea())
    begun, sensed = motion.sense(37), motion.sense(1000)
    assert isinstance(begun, SpatialImu)
    assert isinstance(sensed, SpatialImu)
    _, sensed = parted(sensed, 70)
    assert isinstance(sensed, SpatialImu)
    whole, parts = message(sensed), list(sensed.parts(True, True))
    assert [(rows.start, rows.stop) for rows, _ in parts] == [(0, 405), (405, 917), (917, 930)]
    joined = join([part for _, part in parts])
    for name in ('stamp_ns', 'orientation', 'angular_velocity', 'linear_acceleration'):
        assert getattr(joined, name).tobytes() == getattr(whole, name).tobytes()
    assert sensed.first == 37 + 70


def test_a_ship_that_may_pitch_upright_is_screened_as_messages() -> None:
    rough = at_sea(**{'ship.sea.significant_wave_height': 29.0, 'ship.hull': 'ketch'})
    assert isinstance(ShipMotion(rough).sense(10), ImuSamples)


def test_no_waves_have_the_bits_of_summed_zeros() -> None:
    period, phase = np.array([7.0, 11.0]), np.array([0.1, 2.0])
    flat = SampledHarmonics(Harmonics(np.zeros(2), period, phase), 10**8)
    tiny = SampledHarmonics(Harmonics(np.full(2, 1e-320), period, phase), 10**8)
    for zero, summed in zip(flat.between(5, 900, 0, 1), tiny.between(5, 900, 0, 1), strict=True):
        assert zero.tobytes() == np.zeros(895).tobytes()
        np.testing.assert_allclose(zero, summed, atol=1e-300)


@pytest.mark.parametrize('plane', ['free', 'vertical'])
def test_the_force_of_a_sample_does_not_depend_on_its_neighbours(plane: ThreadPlane) -> None:
    """Samples without a part along the axle, or with that alone, included."""
    angle, rate, acceleration = motion()
    imu = imu_from_motions(np.arange(N), angle, rate, acceleration, G)
    force, orientation = imu.linear_acceleration.copy(), imu.orientation.copy()
    force[3, 0], force[11] = 0.0, (2.0, 0.0, 0.0)
    force[20, 0], orientation[20, 1:3] = 0.0, 0.0
    imu = replace(imu, linear_acceleration=force, orientation=orientation)
    together = force_in_plane(imu, plane)
    for k in range(N):
        alone = force_in_plane(take(imu, slice(k, k + 1)), plane)
        np.testing.assert_array_equal(together[k], alone[0])
    np.testing.assert_array_equal(together[20], force[20])
    assert np.isfinite(together).all()
