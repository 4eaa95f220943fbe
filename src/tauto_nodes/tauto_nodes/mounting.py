"""How a live sensor is mounted: by a parameter, by its frame, or by a static transform of tf2."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rclpy.time import Time

from tauto_core.samples import SHIP_IMU, FloatArray, ImuSamples
from tauto_core.ship.imu import MOUNT_FRAME, mounted, quaternion_of_angles
from tauto_nodes import ParameterError


def rotation_of(text: str) -> FloatArray:
    """Return the quaternion that `imu_rotation` says in degrees; ParameterError: it says none."""
    try:
        roll, pitch, yaw = np.radians([float(word) for word in text.replace(',', ' ').split()])
        if not np.isfinite([roll, pitch, yaw]).all():
            raise ValueError
    except ValueError:
        raise ParameterError(
            f'imu_rotation = {text!r}: must be roll, pitch and yaw in degrees, as in 0 0 90'
        ) from None
    return quaternion_of_angles(roll, pitch, yaw)


class StaticTransforms:
    """The static transforms of tf2 that a node has heard; ImportError where tf2_ros is missing.

    /tf is not used: a frame that moves relative to the clock is no mounting.
    """

    def __init__(self, node: Node) -> None:
        from tf2_msgs.msg import TFMessage
        from tf2_ros import Buffer, TransformException

        self._buffer: Any = Buffer()
        self._unknown: type[Exception] = TransformException
        latched = QoSProfile(depth=100, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(TFMessage, '/tf_static', self._hear, latched)

    def _hear(self, message: Any) -> None:
        for one in message.transforms:
            self._buffer.set_transform_static(one, SHIP_IMU)

    def to_clock(self, frame: str) -> FloatArray | None:
        """Return the rotation that takes vectors from a frame to the clock's; None: not known."""
        try:
            found = self._buffer.lookup_transform(MOUNT_FRAME, frame, Time())
        except self._unknown:
            return None
        q = found.transform.rotation
        return np.array([q.x, q.y, q.z, q.w])


class Mounting:
    """Turns the samples of a sensor into the axes of the clock.

    Where `imu_rotation` says nothing the frame must be `clock_mount`, or one from which a static
    transform leads there. Samples of any other are left aside, and `trouble` says so.
    """

    def __init__(self, node: Node, imu_rotation: str) -> None:
        self._node = node
        self._given = rotation_of(imu_rotation) if imu_rotation else None
        self._transforms: StaticTransforms | None = None
        self._frame = MOUNT_FRAME
        self._mount: FloatArray | None = None
        self.trouble = ''

    def applied(self, samples: ImuSamples) -> ImuSamples | None:
        """Return the samples in the axes of the clock; None where the mounting is not known."""
        frame = samples.frame_id
        if self._given is not None:
            return mounted(samples, self._given)
        if frame == MOUNT_FRAME:
            self.trouble = ''
            return samples
        if frame != self._frame or self._mount is None:
            if self._transforms is None:
                with suppress(ImportError):
                    self._transforms = StaticTransforms(self._node)
            self._mount = None if self._transforms is None else self._transforms.to_clock(frame)
            if self._mount is None:
                self._refuse(frame)
            else:
                self._frame, self.trouble = frame, ''
                self._node.get_logger().info(f'{SHIP_IMU}: frame {frame!r} is turned as tf2 says')
        return None if self._mount is None else mounted(samples, self._mount)

    def _refuse(self, frame: str) -> None:
        asked = (
            'tf2 has no static transform from it'
            if self._transforms is not None
            else 'tf2_ros is not installed here'
        )
        words = (
            f'{SHIP_IMU}: frame {frame!r} is not {MOUNT_FRAME} (x forward, y to port, z up), and '
            f'{asked}; its messages are left aside. Say how the sensor is mounted: imu_rotation'
        )
        if words != self.trouble:
            self._node.get_logger().error(words)
        self.trouble = words
