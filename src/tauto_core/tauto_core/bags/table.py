"""The topic table: the content, publisher and QoS of every topic.

Nodes, codec, writer, reader and the page of topics (docs/topics.py) all use it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from tauto_core import samples as s

TopicKind: TypeAlias = Literal[
    'time', 'string', 'string[]', 'float64', 'float64[]', 'int8', 'uint8', 'uint16'
]

DEPTH = 1000
"""KEEP_LAST depth of the streams, above the 800 messages that flow control allows in flight."""


@dataclass(frozen=True)
class Field:
    """One message field, in the order of serialisation, and the sample field that holds it.

    Args:
        message: path in the message, for example `header.stamp`, or of the struct for consecutive
            `float64` members of one struct.
        sample: attribute of the sample class.
        kind: primitive type in the message. `time` is int32 seconds and uint32 nanoseconds, in
            the sample one integer of nanoseconds.
        length: number of consecutive primitives. If above 1, the last axis of the sample field.
        unit: unit of the value, or empty.
        shared: whether the sample class holds one value for the whole batch.
    """

    message: str
    sample: str
    kind: TopicKind
    length: int = 1
    unit: str = ''
    shared: bool = False


@dataclass(frozen=True)
class MessageType:
    """A ROS message type and the sample class that holds it."""

    name: str
    samples: type[s.Samples]
    fields: tuple[Field, ...]

    @property
    def stamped(self) -> bool:
        """Whether the message has a header. If not, its stamp is the log time."""
        return self.fields[0].kind == 'time'


_HEADER = (
    Field('header.stamp', 'stamp_ns', 'time', unit='ns'),
    Field('header.frame_id', 'frame_id', 'string', shared=True),
)

STRING = MessageType('std_msgs/msg/String', s.TextSamples, (Field('data', 'data', 'string'),))
IMU = MessageType(
    'sensor_msgs/msg/Imu',
    s.ImuSamples,
    (
        *_HEADER,
        Field('orientation', 'orientation', 'float64', 4),
        Field('orientation_covariance', 'orientation_covariance', 'float64', 9, 'rad2'),
        Field('angular_velocity', 'angular_velocity', 'float64', 3, 'rad/s'),
        Field(
            'angular_velocity_covariance', 'angular_velocity_covariance', 'float64', 9, 'rad2/s2'
        ),
        Field('linear_acceleration', 'linear_acceleration', 'float64', 3, 'm/s2'),
        Field(
            'linear_acceleration_covariance',
            'linear_acceleration_covariance',
            'float64',
            9,
            'm2/s4',
        ),
    ),
)
JOINT_STATE = MessageType(
    'sensor_msgs/msg/JointState',
    s.JointSamples,
    (
        *_HEADER,
        Field('name', 'name', 'string[]', shared=True),
        Field('position', 'position', 'float64[]'),
        Field('velocity', 'velocity', 'float64[]'),
        Field('effort', 'effort', 'float64[]'),
    ),
)
TIME_REFERENCE = MessageType(
    'sensor_msgs/msg/TimeReference',
    s.TimeSamples,
    (
        *_HEADER,
        Field('time_ref', 'time_ref_ns', 'time', unit='ns'),
        Field('source', 'source', 'string'),
    ),
)
NAV_SAT_FIX = MessageType(
    'sensor_msgs/msg/NavSatFix',
    s.FixSamples,
    (
        *_HEADER,
        Field('status.status', 'status', 'int8'),
        Field('status.service', 'service', 'uint16'),
        Field('latitude', 'latitude', 'float64', unit='deg'),
        Field('longitude', 'longitude', 'float64', unit='deg'),
        Field('altitude', 'altitude', 'float64', unit='m'),
        Field('position_covariance', 'position_covariance', 'float64', 9, 'm2'),
        Field('position_covariance_type', 'position_covariance_type', 'uint8'),
    ),
)
TEMPERATURE = MessageType(
    'sensor_msgs/msg/Temperature',
    s.TemperatureSamples,
    (
        *_HEADER,
        Field('temperature', 'temperature', 'float64', unit='°C'),
        Field('variance', 'variance', 'float64', unit='K2'),
    ),
)

MESSAGE_TYPES: dict[str, MessageType] = {
    kind.name: kind
    for kind in (STRING, IMU, JOINT_STATE, TIME_REFERENCE, NAV_SAT_FIX, TEMPERATURE)
}


@dataclass(frozen=True)
class Topic:
    """One topic of the suite.

    The QoS is RELIABLE, KEEP_LAST of `depth`, and VOLATILE, or TRANSIENT_LOCAL if `latched`.
    Deadline, lifespan and liveliness are infinite: publishers with others would not match.

    Args:
        name: relative name.
        message: message type.
        node: the node that publishes it.
        meaning: the meaning of the values.
        depth: KEEP_LAST depth.
        latched: whether late subscribers get the last message.
    """

    name: str
    message: MessageType
    node: str
    meaning: str
    depth: int = DEPTH
    latched: bool = False

    @property
    def ros_type(self) -> str:
        """Full name of the ROS type, for example `sensor_msgs/msg/Imu`."""
        return self.message.name


TOPICS: dict[str, Topic] = {
    topic.name: topic
    for topic in (
        Topic(
            s.SCENE,
            STRING,
            'ship_motion',
            'the resolved scene as YAML, which makes a bag complete. Once, at the start',
            depth=1,
            latched=True,
        ),
        Topic(
            s.SHIP_IMU,
            IMU,
            'ship_motion',
            'attitude, angular velocity and specific force at the clock, frame `clock_mount`, '
            'at the rate of the ship',
        ),
        Topic(s.SHIP_FIX, NAV_SAT_FIX, 'ship_motion', 'true position of the ship'),
        Topic(
            s.SHIP_TEMPERATURE,
            TEMPERATURE,
            'ship_motion',
            'temperature in the box of the clock and its thermometer, frame `clock_case`, linear '
            'between two stamps. Only if the scene has `air`',
        ),
        Topic(
            s.JOINT_STATES,
            JOINT_STATE,
            'trochlea',
            'the wheel in its case, name `wheel`: angle [rad], angular velocity [rad/s], '
            'torque [N m]. In a fluid the body, name `body`: arc [m], speed [m/s], force along '
            'the curve [N]',
        ),
        Topic(
            s.PHASE,
            JOINT_STATE,
            'trochlea',
            'the oscillator, names `phase` [rad], `half_turns`, `half_turn_fraction`, `beats`',
        ),
        Topic(
            s.SLACK,
            JOINT_STATE,
            'trochlea',
            'the thread is taut again after it was slack, names `slacks`, the number so far, '
            '`slack_s`, the length of this one, `lost_joule`, the energy lost as it tautened. '
            'Stamp: when it tautened. No message while the thread stays taut',
        ),
        Topic(
            s.READING,
            TIME_REFERENCE,
            'trochlea',
            'stamp: true time. time_ref: reading of the dial. source: `dial`, with a live sensor '
            'also its setting and its lost time (docs/live.md)',
        ),
        Topic(
            s.OBSERVATION,
            TIME_REFERENCE,
            'ship_motion',
            'time_ref: the true time as the navigator observed it. source: kind of observation',
        ),
        Topic(
            s.CORRECTED,
            TIME_REFERENCE,
            'drift_estimator',
            'time_ref: the reading less the estimated error of the clock. source: `corrected`',
        ),
        Topic(
            s.ESTIMATE,
            JOINT_STATE,
            'drift_estimator',
            'the estimated error of the clock, names `offset_s`, `offset_sigma_s`, '
            '`rate_s_per_day`, `rate_sigma_s_per_day`. With `drift.covariates` that rate is for '
            'a ship at rest, and there are also `mean_rate_s_per_day`, the mean with the motion '
            'since the start, `mean_rate_sigma_s_per_day`, and for each covariate, such as heave, '
            '`heave_coefficient`, `heave_coefficient_sigma` and `heave_integral_s`',
        ),
        Topic(
            s.LONGITUDE_FIX,
            NAV_SAT_FIX,
            'longitude',
            'position by the corrected clock, with its variance as east covariance. With a live '
            'sensor STATUS_NO_FIX, since a chronometer is not a satellite',
        ),
        Topic(
            s.LONGITUDE_ERROR,
            JOINT_STATE,
            'longitude',
            'error of the longitude, east positive, raw and corrected. Names end in '
            '`_arcmin` and `_nmi`',
        ),
    )
}


def offered_qos(depth: int, *, latched: bool) -> list[dict[str, Any]]:
    """Return the QoS of a reliable publisher with KEEP_LAST, spelt as in rosbag2 metadata 9."""
    infinite = {'sec': 9223372036, 'nsec': 854775807}
    return [
        {
            'history': 'keep_last',
            'depth': depth,
            'reliability': 'reliable',
            'durability': 'transient_local' if latched else 'volatile',
            'deadline': dict(infinite),
            'lifespan': dict(infinite),
            'liveliness': 'automatic',
            'liveliness_lease_duration': dict(infinite),
            'avoid_ros_namespace_conventions': False,
        }
    ]
