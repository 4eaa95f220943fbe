"""Imu bags of other recorders as the ship's motion: complete, truncated, and refused."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from rosbags.typesys import Stores, get_typestore

from tauto_core.scene import load_scene
from tauto_core.scene.errors import MotionDataError
from tauto_core.ship import ShipMotion, attitude

STORE = get_typestore(Stores.ROS2_JAZZY)
IMU = 'sensor_msgs/msg/Imu'
STEP_NS = 50_000_000
N = 2001


def roll_at(time_s: np.ndarray) -> np.ndarray:
    return 0.05 + 0.1 * np.cos(2 * np.pi * 0.11 * time_s)


@dataclass
class Sensor:
    """The fields of an Imu message."""

    stamp_ns: int
    orientation: list[float]
    angular_velocity: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    linear_acceleration: list[float] = field(default_factory=lambda: [0.1, 0.2, 9.7])
    covariance: list[float] = field(default_factory=lambda: [0.0] * 9)

    def payload(self) -> bytes:
        types = STORE.types
        stamp = types['builtin_interfaces/msg/Time'](*divmod(self.stamp_ns, 10**9))
        vector = types['geometry_msgs/msg/Vector3']
        message = types[IMU](
            header=types['std_msgs/msg/Header'](stamp=stamp, frame_id='imu_link'),
            orientation=types['geometry_msgs/msg/Quaternion'](*self.orientation),
            orientation_covariance=np.array(self.covariance),
            angular_velocity=vector(*self.angular_velocity),
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=vector(*self.linear_acceleration),
            linear_acceleration_covariance=np.zeros(9),
        )
        return bytes(STORE.serialize_cdr(message, IMU))


def sensors(n: int = N) -> list[Sensor]:
    time_s = np.arange(n) * STEP_NS / 1e9
    return [
        Sensor(
            10**18 + k * STEP_NS,
            [np.sin(rho / 2), 0.0, 0.0, np.cos(rho / 2)],
            linear_acceleration=[0.0, 9.8 * np.sin(rho), 9.8 * np.cos(rho)],
        )
        for k, rho in enumerate(roll_at(time_s).tolist())
    ]


def write(path: Path, messages: list[Sensor], *, kind: str = IMU, encoding: str = 'cdr') -> Path:
    with path.open('wb') as stream:
        writer = Writer(stream, chunk_size=16_384)
        writer.start(profile='ros2')
        schema = writer.register_schema(kind, 'ros2msg', b'')
        channel = writer.register_channel('/imu/data', encoding, schema)
        for message in messages:
            writer.add_message(channel, message.stamp_ns, message.payload(), message.stamp_ns)
        writer.finish()
    return path


def motion(path: Path, topic: str = '/imu/data', duration: float = 60.0) -> ShipMotion:
    recorded = {'path': str(path), 'topic': topic}
    ship = {'kind': 'recorded', 'recorded': recorded, 'rate': 20.0}
    return ShipMotion(load_scene('ideal', duration=duration, ship=ship, log={'interval': 1.0}))


def test_bag_gives_the_measured_motion(tmp_path):
    ship = motion(write(tmp_path / 'a.mcap', sensors()))
    assert ship.warnings == ()
    felt = attitude(ship.produce(1201))
    expected = roll_at(np.arange(1201) / 20.0)
    # 0.11 Hz is a harmonic of the mirrored 100 s. The quaternion's rounding, then the DCT's
    np.testing.assert_allclose(felt.roll, expected, rtol=0, atol=1e-14)
    # of g sin(roll) and g cos(roll) the 4th harmonic is beyond 0.4 Hz: g 0.1^4/192 = 5e-6
    np.testing.assert_allclose(felt.force_y, 9.8 * np.sin(expected), rtol=0, atol=6e-6)
    np.testing.assert_allclose(felt.force_z, 9.8 * np.cos(expected), rtol=0, atol=6e-6)


def test_a_record_that_breaks_off_warns_or_is_too_short(tmp_path):
    path = write(tmp_path / 'a.mcap', sensors())
    whole = path.read_bytes()
    path.write_bytes(whole[:-5])
    (warning,) = motion(path).warnings
    assert 'a.mcap: it was cut within its index' in warning
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(MotionDataError, match='the record only'):
        motion(path, duration=90.0)


def test_bag_broken_off_before_its_first_message_is_refused(tmp_path):
    path = write(tmp_path / 'a.mcap', sensors())
    path.write_bytes(path.read_bytes()[:60])
    with pytest.raises(MotionDataError, match=r'has no topic .*it has none'):
        motion(path)


def spoiled(index: int, **values: object) -> list[Sensor]:
    messages = sensors(1200)
    for name, value in values.items():
        setattr(messages[index], name, value)
    return messages


@pytest.mark.parametrize(
    ('reason', 'values'),
    [
        ('not_finite', {'linear_acceleration': [0.0, np.nan, 0.0]}),
        ('out_of_order', {'stamp_ns': 10**18 + 5}),
    ],
)
def test_unusable_messages_are_refused(tmp_path, reason, values):
    path = write(tmp_path / 'a.mcap', spoiled(700, **values))
    with pytest.raises(MotionDataError, match=rf'a\.mcap: Imu message 701 .*{reason}; 1 of 1200'):
        motion(path, duration=10.0)


def test_gap_too_long_is_refused(tmp_path):
    messages = sensors()
    path = write(tmp_path / 'a.mcap', messages[:500] + messages[600:])
    with pytest.raises(MotionDataError, match=r'message 501: gap of 5\.05 s'):
        motion(path)


def test_other_type_encoding_and_topic_are_refused(tmp_path):
    other = write(tmp_path / 'a.mcap', sensors(5), kind='nav_msgs/msg/Odometry')
    with pytest.raises(MotionDataError, match=r'holds nav_msgs/msg/Odometry, but must hold'):
        motion(other)
    ros1 = write(tmp_path / 'b.mcap', sensors(5), encoding='ros1')
    with pytest.raises(MotionDataError, match=r"is encoded as 'ros1'"):
        motion(ros1)
    with pytest.raises(MotionDataError, match=r"no topic '/imu'; it has /imu/data: sensor_msgs"):
        motion(ros1, '/imu')
    empty = write(tmp_path / 'c.mcap', [])
    with pytest.raises(MotionDataError, match='has no messages'):
        motion(empty)
