"""Nodes that pace time: they send stamped messages when these are due. The player of a bag."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any, TypeAlias

from rclpy.duration import Duration
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock as ClockMessage

from tauto_core.bags import TOPICS, Bag, read_bag
from tauto_core.scene.times import NS_PER_S
from tauto_nodes import NodesError, ParameterError
from tauto_nodes.live import main_of
from tauto_nodes.live.node import (
    MIN_DEPTH,
    Diagnostics,
    GraphNode,
    TopicPort,
    message_class,
    node_of,
    port,
)

StampedMessage: TypeAlias = tuple[int, str, bytes]
"""Stamp [ns], topic, payload."""

BURST = 1000
"""Most messages sent in one tick: a node at full speed must still receive."""

SLICE = 4
"""Most messages sent at once to a node outside of the graph. A queue of ten, as in `ros2 topic
echo` and many nodes, then does not overflow."""

PAUSE_S = 1.5e-3
"""Time between two slices [s]: rclpy takes a message in some 0.2 ms."""


class SourceNode(GraphNode):
    """Sends messages, ordered by stamp, at a pace.

    With flow control it begins when the whole graph is matched, else when each of its topics has a
    subscriber or after the parameter `wait`. `pace` names the parameter with the stamped seconds
    per second (0: unpaced).
    """

    paces = True

    def __init__(self, role: str, pace: str, **node_options: Any) -> None:
        super().__init__(role, **node_options)
        self._pace_name = pace
        self._pace = self.settings[pace]
        self._items: Iterator[StampedMessage] = iter(())
        self._next: StampedMessage | None = None
        self.sent_until_ns = 0
        """Stamp of the last sent item [ns], or 0."""
        self._clock_ns = -1
        self._sea_clock: Any = None
        self._born_s = time.monotonic()
        self._base: tuple[float, int] | None = None
        self.add_post_set_parameters_callback(self._repace)

    def start(self, items: Iterator[StampedMessage]) -> None:
        """Begin with these items once the subscribers are there. The ports must be connected.

        NodesError: another node publishes /clock.
        """
        if self.settings['publish_clock']:
            # Discovery takes a while to hear of another publisher.
            deadline_s = time.monotonic() + 1.0
            while time.monotonic() < deadline_s:
                if others := self.get_publishers_info_by_topic('/clock'):
                    raise NodesError(
                        f'publish_clock = True: {node_of(others[0])} already publishes /clock, '
                        'and time has one source. Leave publish_clock out, or stop the other'
                    )
                time.sleep(0.02)
            self._sea_clock = self.create_publisher(ClockMessage, '/clock', QoSProfile(depth=10))
        self._items = items
        self._next = next(items, None)
        self.diagnostics = Diagnostics(self)

    def all_sent(self) -> None:
        """Do what remains when the last item has been sent."""

    def tick(self) -> None:
        """Send the due messages."""
        now_s = time.monotonic()
        if self._base is None:
            # Without flow control the number of subscribers is unknown.
            unheard = any(not p.publisher.get_subscription_count() for p in self.outputs.values())
            waits = unheard and now_s - self._born_s < self.settings['wait']
            if waits if self.flow is None else not self.flow.everyone_ready():
                return
            self._base = (now_s, self._next[0] if self._next else 0)
        due_ns = self._due_ns(now_s)
        due: list[StampedMessage] = []
        is_watched = any(output.watched for output in self.outputs.values())
        late_s = (due_ns - (self._next[0] if self._next else 0)) / NS_PER_S / (self._pace or 1.0)
        # a source late by half a second sends at once: the pace is too high for it
        is_spread = is_watched and self._pace > 0.0 and late_s < 0.5
        most = 6 * SLICE if is_spread else BURST
        while self._next and not self.backlogged and len(due) < most and self._next[0] <= due_ns:
            due.append(self._next)
            self._next = next(self._items, None)
        self.sent_until_ns = due[-1][0] if due else self.sent_until_ns
        at_once = SLICE if is_spread else BURST
        for first in range(0, len(due), at_once):
            if first:
                time.sleep(PAUSE_S)
            part = due[first : first + at_once]
            if self.flow is not None:  # nodes of our graph join topics by stamps, not by arrival
                part.sort(key=itemgetter(1))
            for topic, messages in groupby(part, itemgetter(1)):
                self.send(topic, [payload for _, _, payload in messages])
        if self._sea_clock is not None and self.sent_until_ns > self._clock_ns:
            self._clock_ns = self.sent_until_ns
            message = ClockMessage()
            message.clock.sec, message.clock.nanosec = divmod(self._clock_ns, NS_PER_S)
            self._sea_clock.publish(message)
        if self._next is None and not self.input_over and not self.backlogged:
            self.input_over = True
            self.all_sent()

    def _due_ns(self, now_s: float) -> float:
        assert self._base is not None
        if self._pace == 0.0:
            return math.inf
        since_s, from_ns = self._base
        return float(from_ns + (now_s - since_s) * self._pace * NS_PER_S)

    def _repace(self, changes: list[RosParameter]) -> None:
        for change in changes:
            if change.name == self._pace_name:
                now_s = time.monotonic()
                if self._base is not None:
                    # from the last message on: the new pace must not act backwards
                    self._base = (now_s, int(min(self._due_ns(now_s), self.sent_until_ns)))
                self._pace = float(change.value)


# -----------------------------------------------------------------------------
# The player: the messages of a bag, at a pace, payloads untouched.


def ports_of(bag: Bag, asked: tuple[str, ...]) -> dict[str, TopicPort]:
    """Return the ports to play on, by the topic's name in the bag.

    Raises:
        ParameterError: the bag lacks these topics.
        NodesError: a message type is not installed.
    """
    ports = {}
    # in a bag with several namespaces, names stay absolute
    prefix = '' if bag.namespace is None else f'/{bag.namespace}/'.replace('//', '/')
    for topic, ros_type in bag.topics.items():
        name = topic.removeprefix(prefix)
        if 'all' not in asked and not any(f'/{topic}'.endswith(f'/{one}') for one in asked):
            continue
        known = name in TOPICS and TOPICS[name].ros_type == ros_type
        foreign = QoSProfile(depth=MIN_DEPTH)
        ports[topic] = port(name) if known else TopicPort(name, message_class(ros_type), foreign)
    if not ports:
        raise ParameterError(
            f'topics = {list(asked)}: the bag lacks them. It has {", ".join(bag.topics)}'
        )
    return ports


class PlayerNode(SourceNode):
    """Publishes a bag's topics under the player's namespace, and ends with the bag."""

    def __init__(self, **node_options: Any) -> None:
        super().__init__('player', 'rate', **node_options)
        bag = read_bag(Path(self.settings['bag']))
        for warning in bag.warnings:
            self.get_logger().warning(warning)
        ports = ports_of(bag, self.settings['topics'])
        self.connect([], list(ports.values()))
        self.start(
            (stamp_ns, ports[topic].name, payload)
            for topic, _, stamp_ns, payload in bag.messages(ports)
        )

    def all_sent(self) -> None:
        """End when the subscribers have acknowledged."""
        for output in self.outputs.values():
            output.publisher.wait_for_all_acked(Duration(seconds=10))
        sent = ', '.join(f'{topic} {output.sent}' for topic, output in self.outputs.items())
        self.get_logger().info(f'played {sent}')
        self.over = True


player = main_of(PlayerNode)
