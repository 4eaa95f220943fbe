"""IMU samples, attitude, and refusals."""

import math
from dataclasses import fields, replace

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tauto_core.samples import ImuSamples, join, take
from tauto_core.ship import REFUSALS, attitude, imu_samples, screen

G = 9.80665


def sensor(n: int = 5) -> ImuSamples:
    """Return n good samples of a rolling ship."""
    k = np.arange(n)
    stamps = 1_000 + 50 * k.astype(np.int64)
    roll = 0.2 * np.sin(0.3 * k)
    return imu_samples(stamps, roll, 0.1 * roll, -0.2 * roll, None, 3.0, G)


def test_specific_force_is_second_derivative_of_the_place():
    """Reference: acceleration by differentiating the position of the clock in 30 digits."""
    height = 2.7

    def roll(t):
        return mpmath.mpf('0.3') * mpmath.cos(t) + mpmath.mpf('0.1') * mpmath.sin(2 * t)

    def heave(t):
        return mpmath.mpf('0.8') * mpmath.sin(mpmath.mpf('0.7') * t)

    def y(t):
        return -height * mpmath.sin(roll(t))

    def z(t):
        return heave(t) + height * mpmath.cos(roll(t))

    times = [0.3, 1.1, 2.9]
    with mpmath.workdps(30):
        rho = [roll(t) for t in times]
        force = [(mpmath.diff(y, t, 2), mpmath.diff(z, t, 2) + G) for t in times]
        expected = [
            (c * fy + s * fz, -s * fy + c * fz)
            for (fy, fz), c, s in zip(
                force, map(mpmath.cos, rho), map(mpmath.sin, rho), strict=True
            )
        ]
        derivatives = [[float(mpmath.diff(roll, t, n)) for t in times] for n in range(3)]
        heaving = np.array([float(mpmath.diff(heave, t, 2)) for t in times])
    angle, rate, acceleration = (np.array(each) for each in derivatives)
    imu = imu_samples(np.array([1, 2, 3]), angle, rate, acceleration, heaving, height, G)
    # rounding of numbers near 10
    np.testing.assert_allclose(
        imu.linear_acceleration[:, 1:], np.array(expected, float), rtol=0, atol=2e-14
    )
    assert (imu.linear_acceleration[:, 0] == 0.0).all()


def test_attitude_takes_the_roll_of_yaw_pitch_roll():
    """Reference: SciPy's intrinsic z-y-x angles and the textbook kinematics of Euler angles."""
    random = np.random.default_rng(3)
    yaw, pitch, roll = random.uniform([-3, -1.4, -3], [3, 1.4, 3], (300, 3)).T
    yaw_rate, pitch_rate, roll_rate = random.normal(size=(3, 300))
    omega = np.stack(
        [
            roll_rate - yaw_rate * np.sin(pitch),
            pitch_rate * np.cos(roll) + yaw_rate * np.cos(pitch) * np.sin(roll),
            -pitch_rate * np.sin(roll) + yaw_rate * np.cos(pitch) * np.cos(roll),
        ],
        axis=1,
    )
    quaternion = Rotation.from_euler('ZYX', np.stack([yaw, pitch, roll], axis=1)).as_quat()
    force = random.normal(size=(300, 3))
    imu = replace(
        sensor(300), orientation=quaternion, angular_velocity=omega, linear_acceleration=force
    )
    felt = attitude(imu)
    # tan(pitch) up to 6 and cos(pitch) down to 0.17 amplify rounding
    np.testing.assert_allclose(felt.roll, roll, rtol=0, atol=5e-15)
    np.testing.assert_allclose(felt.roll_rate, roll_rate, rtol=0, atol=5e-14)
    np.testing.assert_array_equal(np.stack([felt.force_y, felt.force_z], axis=1), force[:, 1:])


def test_roll_lies_above_minus_pi_and_up_to_pi():
    upside_down = np.array([[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, -0.0], [-1.0, 0.0, 0.0, 0.0]])
    felt = attitude(replace(sensor(3), orientation=upside_down))
    np.testing.assert_array_equal(felt.roll, [np.pi] * 3)


def test_norm_of_the_quaternion_does_not_matter():
    imu = sensor(50)
    stretched = attitude(replace(imu, orientation=1.0009 * imu.orientation))
    np.testing.assert_allclose(stretched.roll, attitude(imu).roll, rtol=0, atol=1e-15)
    assert (
        screen(replace(imu, orientation=1.0009 * imu.orientation), None)[1] == screen(imu, None)[1]
    )


def test_covariances_are_positive_on_the_diagonal_alone():
    imu = sensor(2)
    for name in ('orientation', 'angular_velocity', 'linear_acceleration'):
        matrix = getattr(imu, f'{name}_covariance').reshape(2, 3, 3)
        assert (np.diagonal(matrix, axis1=1, axis2=2) > 0.0).all()
        assert np.count_nonzero(matrix) == 6


def test_orientation_and_gravity_at_any_roll():
    """In 30 digits. Allowed is a unit in the last place of 1, and two of g for each component."""
    roll = np.linspace(-3.2, 3.2, 641)
    zero = np.zeros(641)
    imu = imu_samples(np.arange(641), roll, 2.0 * roll, zero, None, 0.0, 1.0)
    np.testing.assert_array_equal(imu.angular_velocity, np.column_stack((2.0 * roll, zero, zero)))
    with mpmath.workdps(30):
        half = [
            (float(mpmath.sin(x / 2)), float(mpmath.cos(x / 2))) for x in map(mpmath.mpf, roll)
        ]
        whole = [(float(mpmath.sin(x)), float(mpmath.cos(x))) for x in map(mpmath.mpf, roll)]
    np.testing.assert_allclose(imu.orientation[:, [0, 3]], half, rtol=0, atol=2.3e-16)
    np.testing.assert_allclose(imu.linear_acceleration[:, 1:], whole, rtol=0, atol=4.5e-16)


@pytest.mark.parametrize('heaves', [False, True])
def test_a_sample_has_the_same_bits_alone_and_among_others(heaves):
    """Eight are encoded at one go, those beyond a right angle one by one."""
    roll, rate, bend, heave = np.random.default_rng(5).normal(size=(4, 203)) * 1.5
    up = heave if heaves else None
    whole = imu_samples(np.arange(203), roll, rate, bend, up, 2.0, 9.8)
    for i in range(203):
        one = slice(i, i + 1)
        up_1 = None if up is None else up[one]
        alone = imu_samples(np.arange(i, i + 1), roll[one], rate[one], bend[one], up_1, 2.0, 9.8)
        for field in fields(whole):
            found, wanted = getattr(alone, field.name), getattr(take(whole, one), field.name)
            np.testing.assert_array_equal(found, wanted)


def spoil(imu: ImuSamples, name: str, row: int, value: object) -> ImuSamples:
    array = getattr(imu, name).copy()
    array[row] = value
    return replace(imu, **{name: array})


ABSENT = [-1.0, *[0.0] * 8]
SPOILED = [
    ('orientation_absent', 'orientation_covariance', ABSENT),
    ('angular_velocity_absent', 'angular_velocity_covariance', ABSENT),
    ('linear_acceleration_absent', 'linear_acceleration_covariance', ABSENT),
    ('not_finite', 'orientation', [0.0, np.nan, 0.0, 1.0]),
    ('not_finite', 'angular_velocity', [np.inf, 0.0, 0.0]),
    ('not_finite', 'linear_acceleration', [0.0, 0.0, -np.inf]),
    ('zero_quaternion', 'orientation', [0.0, 0.0, 0.0, 0.0]),
    ('not_unit_quaternion', 'orientation', [0.0, 0.0, 0.0, 1.0011]),
    ('not_unit_quaternion', 'orientation', [1e308, 1e308, 1e308, 1e308]),
    ('roll_undefined', 'orientation', [0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)]),
    ('duplicated', 'stamp_ns', 1_050),
    ('out_of_order', 'stamp_ns', 1_049),
]


@pytest.mark.parametrize(('reason', 'name', 'value'), SPOILED)
def test_screen_refuses_and_counts(reason, name, value):
    imu = sensor(5)
    kept, counts = screen(spoil(imu, name, 2, value), 999)
    assert counts == {**dict.fromkeys(REFUSALS, 0), reason: 1}
    np.testing.assert_array_equal(kept.stamp_ns, imu.stamp_ns[[0, 1, 3, 4]])
    np.testing.assert_array_equal(kept.orientation, imu.orientation[[0, 1, 3, 4]])


def test_screen_keeps_a_steep_pitch():
    half = math.radians(0.5 * 89.9)
    imu = spoil(sensor(9), 'orientation', 3, [0.0, math.sin(half), 0.0, math.cos(half)])
    kept, counts = screen(imu, None)
    assert len(kept.stamp_ns) == 9
    assert not any(counts.values())


def test_screen_accepts_unknown_covariance_and_uses_last_stamp():
    imu = replace(sensor(3), orientation_covariance=np.zeros((3, 9)))
    assert len(screen(imu, None)[0].stamp_ns) == 3
    kept, counts = screen(imu, 1_050)
    assert kept.stamp_ns.tolist() == [1_100]
    assert (counts['duplicated'], counts['out_of_order']) == (1, 1)
    empty, none = screen(take(imu, slice(0, 0)), 7)
    assert len(empty.stamp_ns) == 0
    assert not any(none.values())


@settings(max_examples=25, deadline=None)
@given(
    stamps=st.lists(st.integers(1, 12), min_size=1, max_size=20),
    spoiled=st.lists(st.tuples(st.integers(0, 19), st.sampled_from(SPOILED[:10])), max_size=6),
    cut=st.integers(0, 20),
)
def test_screen_does_not_depend_on_the_split(stamps, spoiled, cut):
    imu = replace(sensor(len(stamps)), stamp_ns=np.array(stamps, np.int64))
    for row, (_, name, value) in spoiled:
        if row < len(stamps):
            imu = spoil(imu, name, row, value)
    whole, counts = screen(imu, None)
    first, counts_1 = screen(take(imu, slice(0, cut)), None)
    last = int(first.stamp_ns[-1]) if len(first.stamp_ns) else None
    second, counts_2 = screen(take(imu, slice(cut, None)), last)
    assert (np.diff(whole.stamp_ns) > 0).all()
    assert counts == {name: counts_1[name] + counts_2[name] for name in REFUSALS}
    parts = join([first, second])
    for field in fields(whole):
        np.testing.assert_array_equal(getattr(parts, field.name), getattr(whole, field.name))
