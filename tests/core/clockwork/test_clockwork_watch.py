"""Windows of a sensor, by SciPy's rotations: a fault has one line, and no honest sensor alarms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tauto_core.clockwork import LiveTrochlea
from tauto_core.clockwork.live import WINDOW_S, SensorWatch
from tauto_core.samples import SHIP_IMU, ImuSamples, SpatialImu, join, take
from tauto_core.scene import load_scene
from tauto_core.ship.imu import sensed
from tauto_core.voyage import ShipSource

START_NS = 1_700_000_000 * 10**9
UP = np.array([0.0, 0.0, 9.81])


def swing(t, size, period_s, phase=0.0):
    return size * np.sin(2.0 * math.pi * t / period_s + phase)


def attitude(t, angles):
    return Rotation.from_euler('ZYX', np.column_stack([angle(t) for angle in angles[::-1]]))


SEA = (
    lambda t: swing(t, 0.12, 8.0) + swing(t, 0.03, 5.3, 1.0),
    lambda t: swing(t, 0.08, 6.1, 0.5),
    lambda t: 0.4 + swing(t, 0.05, 40.0),
)
"""Roll, pitch and yaw [rad] at a time [s]."""


def stream(angles=SEA, seconds=80.0, rate_hz=50.0, accelerated=None, lag_s=0.0) -> ImuSamples:
    """An ideal sensor, with an attitude late by `lag_s`."""
    t = np.arange(round(seconds * rate_hz)) / rate_hz
    turned, h = attitude(t, angles), 1e-5
    omega = (attitude(t - h, angles).inv() * attitude(t + h, angles)).as_rotvec() / (2.0 * h)
    moved = np.column_stack([0.0 * t, 0.0 * t, swing(t, 0.8, 7.0)])
    force = turned.inv().apply(UP + (moved if accelerated is None else accelerated(t)))
    stamps = START_NS + np.rint(t * 1e9).astype(np.int64)
    return sensed(stamps, attitude(t - lag_s, angles).as_quat(), omega, force)


def rough(imu: ImuSamples, seed: int) -> ImuSamples:
    """Add noise and bias of a cheap MEMS sensor: 0.2 degrees, 0.5 degrees/s, 10 mg."""
    rng, n = np.random.default_rng(seed), len(imu.stamp_ns)
    tilts = Rotation.from_rotvec(0.0035 * rng.standard_normal((n, 3)))
    gyro = 0.009 * rng.choice([-1.0, 1.0], 3) + 0.005 * rng.standard_normal((n, 3))
    force = 0.1 * rng.choice([-1.0, 1.0], 3) + 0.05 * rng.standard_normal((n, 3))
    return replace(
        imu,
        orientation=(Rotation.from_quat(imu.orientation) * tilts).as_quat(),
        angular_velocity=imu.angular_velocity + gyro,
        linear_acceleration=imu.linear_acceleration + force,
    )


def alarms(imu: ImuSamples) -> list[str]:
    """All that a watch says of a stream."""
    watch, said = SensorWatch(9.81), []
    while len(imu.stamp_ns):
        end = watch.feed(imu)
        said.append(watch.stuck(take(imu, slice(0, end)))[1])
        imu = take(imu, slice(end, None))
        if watch.is_full:
            said.append(watch.fault())
            watch.begin(WINDOW_S)
    return [words for words in said if words]


def turned(imu: ImuSamples, degrees: float) -> ImuSamples:
    off = Rotation.from_euler('y', degrees, degrees=True)
    return replace(imu, linear_acceleration=off.apply(imu.linear_acceleration))


def scaled(name: str, factor: object):
    return lambda imu: replace(imu, **{name: getattr(imu, name) * factor})


def stays(*names: str):
    """Freeze vectors at their first values."""
    return lambda imu: replace(
        imu, **{n: np.repeat(getattr(imu, n)[:1], len(imu.stamp_ns), axis=0) for n in names}
    )


def axis_stays(name: str, axis: int):
    """Freeze one number at its first value, which is not 0."""

    def spoil(imu):
        numbers = getattr(imu, name).copy()
        numbers[:, axis] = numbers[0, axis]
        return replace(imu, **{name: numbers})

    return spoil


ALL = ('orientation', 'angular_velocity', 'linear_acceleration')
FAULTS = {
    'deg_s': (scaled('angular_velocity', 57.2957795), 'is it in deg/s?'),
    'sign_x': (scaled('angular_velocity', [-1.0, 1.0, 1.0]), 'is the sign of that axis wrong?'),
    'sign_y': (scaled('angular_velocity', [1.0, -1.0, -1.0]), 'is the sign of that axis wrong?'),
    'wxyz': (
        lambda imu: replace(imu, orientation=imu.orientation[:, [3, 0, 1, 2]]),
        'is the order of the quaternion w, x, y, z?',
    ),
    'dead_gyro': (scaled('angular_velocity', 0.0), 'are both alive'),
    'dead_attitude': (stays('orientation'), 'are both alive'),
    'frozen': (stays(*ALL), 'all its numbers have stayed the same for a second'),
    'dead_axis': (axis_stays('linear_acceleration', 1), 'y of linear_acceleration has stayed'),
    'dead_yaw': (axis_stays('angular_velocity', 2), 'z of angular_velocity has stayed the same'),
    'dead_force': (scaled('linear_acceleration', 0.0), 'the accelerometer dead?'),
    'in_g': (scaled('linear_acceleration', 1.0 / 9.81), 'is it in g?'),
    'no_gravity': (
        lambda imu: replace(imu, linear_acceleration=imu.linear_acceleration - UP),
        'is gravity removed?',
    ),
    'too_large': (scaled('linear_acceleration', 1.5), 'is the sensor calibrated?'),
    'ned': (scaled('linear_acceleration', [1.0, -1.0, -1.0]), '(NED)?'),
    'remounted': (lambda imu: turned(imu, 40.0), 'mounted as imu_rotation says?'),
}


@pytest.mark.parametrize('fault', FAULTS)
def test_a_fault_is_named_with_its_remedy(fault):
    spoil, hint = FAULTS[fault]
    said = alarms(spoil(rough(stream(seconds=40.0, rate_hz=20.0), 1)))
    assert any(hint in words for words in said)


@pytest.mark.parametrize(('fault', 'begins_s'), [('deg_s', 20.0), ('frozen', 0.0), ('ned', 20.0)])
def test_a_fault_is_reported_once(fault, begins_s):
    """From the start, or of a driver that starts anew. It lasts for half a minute."""
    spoil, hint = FAULTS[fault]
    stage, imu = LiveTrochlea(load_scene('measured')), rough(stream(rate_hz=20.0), 1)
    first, last = round(20 * begins_s), round(20 * (begins_s + 30.0))
    parts = [take(imu, slice(*rows)) for rows in ((0, first), (first, last), (last, None))]
    parts[1] = spoil(parts[1])
    heard, troubles = [], []
    for part in parts:
        for k in range(0, len(part.stamp_ns), 10):
            stage.feed({SHIP_IMU: take(part, slice(k, k + 10))})
            heard += stage.news()
        troubles.append(stage.trouble)
    assert hint in troubles[1]
    assert not troubles[2]
    counts = stage.health()
    assert counts['sensor_refused'] + counts['sensor_stuck'] > 5 * 20
    assert [hint in line for line in heard].count(True) == 1
    assert len(heard) <= 2 + (begins_s > 0.0)


ANCHORED = (lambda t: swing(t, 0.003, 4.0), lambda t: swing(t, 0.002, 3.0), lambda t: 0.0 * t)


@pytest.mark.parametrize(
    ('angles', 'lag_s', 'rate_hz'),
    [
        (SEA, 0.0, 100.0),
        (SEA, 0.15, 10.0),
        # at anchor, 20 degrees of pitch, a case on its gimbals, a heeled yacht
        (ANCHORED, 0.0, 10.0),
        ((SEA[0], lambda t: swing(t, 0.35, 5.0), SEA[2]), 0.1, 10.0),
        ((lambda t: swing(t, 0.5, 2.2), lambda t: swing(t, 0.3, 1.7), SEA[2]), 0.05, 100.0),
        ((lambda t: 0.5 + swing(t, 0.2, 6.0), SEA[1], lambda t: 0.2 * t), 0.1, 10.0),
    ],
)
def test_no_honest_sensor_alarms(angles, lag_s, rate_hz):
    assert not alarms(rough(stream(angles, rate_hz=rate_hz, lag_s=lag_s), 2))


@pytest.mark.parametrize('rate_hz', [20.0, 200.0])
def test_neither_slamming_nor_turns_nor_vibration_alarm(rate_hz):
    def accelerated(t):
        """The ship slams every 7 s after a fall, turns hard, and its engine runs."""
        since = t % 7.0
        up = np.where(since < 0.05, 30.0, np.where(since > 6.5, -9.7, 0.0))
        up += swing(t, 2.0, 1 / 37.0)
        return np.column_stack([swing(t, 1.0, 30.0), swing(t, 2.5, 60.0), up])

    assert not alarms(rough(stream(rate_hz=rate_hz, accelerated=accelerated), 3))


@pytest.mark.parametrize(
    'name', ['measured', 'boussole_pacific', 'buoy_44004_supply', 'second_cam_at_sea']
)
def test_no_shipped_scene_alarms(name):
    scene = load_scene(name)
    parts: list[ImuSamples] = []
    source = ShipSource(scene)
    while len(parts) < 6 and (batches := source.produce(500)):
        if isinstance(imu := batches.get(SHIP_IMU), SpatialImu):
            imu = imu.samples(True, True, slice(None))
        parts += [imu] if isinstance(imu, ImuSamples) else []
    assert not parts or not alarms(join(parts))
