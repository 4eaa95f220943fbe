"""The ship and the clock in it as markers for RViz and Foxglove, and as transforms.

Frames follow REP-105 and REP-103: map → base_link → clock_mount → clock_case → wheel, x forward, y
to port, z up. The wheel turns about x, as the ship rolls. Markers are in `map`, visible without
transforms: the wheels on PyPI have no tf2_msgs. If another node publishes a transform to a frame,
this one does not, since a frame has one parent.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Quaternion, TransformStamped
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from scipy.spatial.transform import Rotation
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from tauto_core.plots.chart import Line
from tauto_core.plots.machine import draw_machine
from tauto_core.samples import JOINT_STATES, SHIP_IMU, FloatArray, ImuSamples, JointSamples
from tauto_core.scene.times import NS_PER_S
from tauto_core.ship.imu import quaternion_of_angles
from tauto_nodes import NodesError
from tauto_nodes.live import main_of
from tauto_nodes.live.node import Diagnostics, GraphNode, TopicPort, message_class, port

MARKERS, TF, TF_STATIC = 'markers', '/tf', '/tf_static'
RGB = {
    'grey': (0.5, 0.5, 0.5),
    'blue': (0.2, 0.4, 0.8),
    'orange': (0.9, 0.5, 0.1),
    'green': (0.2, 0.6, 0.3),
}
# half a deck from the stem [m], and the outline of both halves
_DECK = np.array(
    [[15, 0, 0], [10.5, 2.7, 0], [3, 3.9, 0], [-9, 3.6, 0], [-15, 2.4, 0], [-15, 0, 0]]
)
_SHIP = np.concatenate([_DECK, _DECK[::-1] * [1.0, -1.0, 1.0]])


def clock_points(line: Line, magnify: float) -> FloatArray:
    """Return the points of a drawn line in the frame of the clock [m], shape (n, 3).

    The drawing, in millimetres, is seen from astern: its x is to starboard, its y upwards.
    """
    x, y = np.asarray(line.x, float), np.asarray(line.y, float)
    return 1e-3 * magnify * np.column_stack((np.zeros_like(x), -x, y))


def marker(name: str, number: int, points: FloatArray, colour: str, width_m: float) -> Marker:
    """Return a line strip in `map`, without an attitude."""
    strip = Marker(ns=name, id=number, type=Marker.LINE_STRIP, action=Marker.ADD)
    strip.header.frame_id = 'map'
    strip.scale.x = width_m
    red, green, blue = RGB[colour]
    strip.color = ColorRGBA(r=red, g=green, b=blue, a=1.0)
    strip.points = [Point(x=x, y=y, z=z) for x, y, z in points.tolist()]
    return strip


def transform(parent: str, child: str, rotation: FloatArray) -> TransformStamped:
    """Return a transform without a stamp. All frames have the ship's origin."""
    x, y, z, w = rotation.tolist()
    made = TransformStamped(child_frame_id=child)
    made.header.frame_id = parent
    made.transform.rotation = Quaternion(x=x, y=y, z=z, w=w)
    return made


def moving(ship: FloatArray, wheel: FloatArray) -> list[TransformStamped]:
    """Return the transforms of /tf."""
    return [transform('map', 'base_link', ship), transform('clock_case', 'wheel', wheel)]


def fixed() -> list[TransformStamped]:
    """Return the transforms of /tf_static. A suspended case is shown at rest in its mount."""
    still = np.array([0.0, 0.0, 0.0, 1.0])
    chain = (('base_link', 'clock_mount'), ('clock_mount', 'clock_case'))
    return [transform(parent, child, still) for parent, child in chain]


def identity_of(one: TransformStamped) -> tuple[object, ...]:
    """Return the key that distinguishes a transform from another node's."""
    q, stamp = one.transform.rotation, one.header.stamp
    return one.header.frame_id, one.child_frame_id, stamp.sec, stamp.nanosec, q.x, q.y, q.z, q.w


class MarkersNode(GraphNode):
    """Draws the latest motion at most `rate` times a second, and only while somebody subscribes.

    Without a subscriber it does not subscribe either, and costs the graph no time.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('markers', **node_options)
        magnify = self.settings['magnify']
        width_m = 2e-3 * magnify
        self._turning: list[Marker] = []
        self._fixed = [marker('ship', 0, _SHIP, 'grey', 0.1)]
        for number, part in enumerate(draw_machine(self.settings.scene()).parts):
            strip = marker(part.name, number, clock_points(part, magnify), part.colour, width_m)
            (self._turning if part.moves_with == 'wheel' else self._fixed).append(strip)
        self._ship: FloatArray | None = None
        self._angle_rad = 0.0
        self._stamp_ns = 0
        self._drawn_s = 0.0
        self._listening: list[Any] = []
        self.given: set[str] = set()
        """Frames to which others have transforms."""
        self._own: deque[tuple[object, ...]] = deque(maxlen=100)
        self._born_s = time.monotonic()
        outputs = [TopicPort(MARKERS, MarkerArray, QoSProfile(depth=1))]
        self._tree: Any = None
        try:
            self._tree = message_class('tf2_msgs/msg/TFMessage')
        except NodesError:
            self.get_logger().info('tf2_msgs is not installed here: markers only, no transforms')
        else:
            latched = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
            outputs.append(TopicPort(TF, self._tree, QoSProfile(depth=100)))
            outputs.append(TopicPort(TF_STATIC, self._tree, latched))
            all_of_them = QoSProfile(depth=100, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
            self.create_subscription(self._tree, TF_STATIC, self.hear, all_of_them)
        self.connect([], outputs)
        self.diagnostics = Diagnostics(self)

    def hear(self, message: Any) -> None:
        """Note the frames to which others have transforms."""
        for one in message.transforms:
            if identity_of(one) not in self._own:
                self.given.add(one.child_frame_id)

    def ours(self, transforms: Sequence[TransformStamped]) -> list[TransformStamped]:
        """Return the transforms to frames that no other node publishes, and remember them."""
        found = [one for one in transforms if one.child_frame_id not in self.given]
        self._own += map(identity_of, found)
        return found

    def take(self, payloads: Mapping[str, Sequence[bytes]]) -> None:
        """Keep the latest attitude and angle, and draw when due."""
        for topic, messages in payloads.items():
            samples, _ = self.decoded(topic, messages[-1:])
            if isinstance(samples, ImuSamples) and samples.orientation[-1].any():
                self._ship = samples.orientation[-1]
                self._stamp_ns = int(samples.stamp_ns[-1])
            elif isinstance(samples, JointSamples):
                self._angle_rad = float(samples.position[-1, 0])
        self._draw()

    def tick(self) -> None:
        """Give the fixed transforms once, and listen while somebody subscribes."""
        # it listens for 2 s before it gives the fixed transforms
        is_due = self._tree is not None and time.monotonic() - self._born_s > 2.0
        if is_due and not (output := self.outputs[TF_STATIC]).sent:
            output.publisher.publish(self._tree(transforms=self.ours(fixed())))
            output.sent += 1
        looked_at = [self.outputs[name] for name in (MARKERS, TF) if name in self.outputs]
        wanted = any(output.matched for output in looked_at)
        if wanted and not self._listening:
            reliability = self.settings['imu_reliability']
            ports = (port(SHIP_IMU, reliability), port(JOINT_STATES))
            self._listening = [self.listen_to(one) for one in ports]
            if self._tree is not None:
                hearing = self.create_subscription(
                    self._tree, TF, self.hear, QoSProfile(depth=100)
                )
                self._listening.append(hearing)
        elif not wanted and self._listening:
            for subscription in self._listening:
                self.destroy_subscription(subscription)
            self._listening = []
            self.inputs.clear()
            self._ship = None

    def _draw(self) -> None:
        now_s = time.monotonic()
        if self._ship is None or now_s - self._drawn_s < 1.0 / self.settings['rate']:
            return
        ship, wheel = self._ship, quaternion_of_angles(self._angle_rad, 0.0, 0.0)
        self._ship, self._drawn_s = None, now_s
        second, nanosecond = divmod(self._stamp_ns, NS_PER_S)
        chain = moving(ship, wheel)
        turned = (Rotation.from_quat(ship) * Rotation.from_quat(wheel)).as_quat()
        for strips, pose in ((self._fixed, ship), (self._turning, turned)):
            x, y, z, w = pose.tolist()
            for strip in strips:
                strip.pose.orientation = Quaternion(x=x, y=y, z=z, w=w)
        for one in (*self._fixed, *self._turning, *chain):
            one.header.stamp.sec, one.header.stamp.nanosec = second, nanosecond
        self._send(MARKERS, MarkerArray(markers=[*self._fixed, *self._turning]))
        if self._tree is not None:
            self._send(TF, self._tree(transforms=self.ours(chain)))

    def _send(self, topic: str, message: Any) -> None:
        output = self.outputs[topic]
        if output.matched:
            output.publisher.publish(message)
            output.sent += 1


markers = main_of(MarkersNode)
