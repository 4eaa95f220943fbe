"""A node that paces time: it sends stamped messages when they are due."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter
from typing import Any, TypeAlias

from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock as ClockMessage

from tauto_core.samples import NS_PER_S
from tauto_nodes.diagnostics import Diagnostics
from tauto_nodes.errors import NodesError
from tauto_nodes.member import Member
from tauto_nodes.ports import node_of

Item: TypeAlias = tuple[int, str, bytes]

BURST = 1000
"""Most messages sent in one tick, so that a node at full speed still hears the others."""

CLOCK_TOPIC = '/clock'
LOOK_S = 1.0


class SourceNode(Member):
    """Sends items (stamp [ns], topic, payload), ordered by stamp, at a pace.

    With flow control it begins when the whole graph is matched, else when each of its topics has a
    subscriber or after the parameter `wait`.

    Args:
        role: says which node of the parameter table this is.
        pace: name of the parameter with the pace, stamped seconds per second; 0: unpaced.
        node_options: handed to rclpy.node.Node.
    """

    def __init__(self, role: str, pace: str, **node_options: Any) -> None:
        super().__init__(role, **node_options)
        self._pace_name = pace
        self._pace = self.settings.number(pace)
        self._items: Iterator[Item] = iter(())
        self._next: Item | None = None
        self._last_ns = 0
        self._clock_ns = -1
        self._sea_clock: Any = None
        self._born_s = time.monotonic()
        self._base: tuple[float, int] | None = None
        self.add_post_set_parameters_callback(self._repace)

    def start(self, items: Iterator[Item]) -> None:
        """Begin with these items once the subscribers are there; ports are connected by now.

        Raises:
            NodesError: /clock is wanted, but somebody else publishes it.
        """
        if self.settings.flag('publish_clock'):
            self._sea_clock = self._clock_publisher()
        self._items = items
        self._next = next(items, None)
        self.diagnostics = Diagnostics(self)

    @property
    def sent_until_ns(self) -> int:
        """Stamp of the last item that was sent [ns]; 0 before the first."""
        return self._last_ns

    def all_sent(self) -> None:
        """Do what remains when the last item has been sent."""

    def tick(self) -> None:
        """Send what is due."""
        if self._base is None and not self._may_start():
            return
        now_s = time.monotonic()
        if self._base is None:
            self._base = (now_s, self._next[0] if self._next else 0)
        self._send_until(self._due_ns(now_s))
        if self._sea_clock is not None and self._last_ns > self._clock_ns:
            self._clock_ns = self._last_ns
            message = ClockMessage()
            message.clock.sec, message.clock.nanosec = divmod(self._clock_ns, NS_PER_S)
            self._sea_clock.publish(message)
        if self._next is None and not self.input_over and not self.backlogged:
            self.input_over = True
            self.all_sent()

    def _send_until(self, due_ns: float) -> None:
        if self.backlogged:
            return
        due: list[Item] = []
        while self._next is not None and len(due) < BURST and self._next[0] <= due_ns:
            due.append(self._next)
            self._next = next(self._items, None)
        if not due:
            return
        self._last_ns = due[-1][0]
        if self.flow is not None:  # nodes of our graph join topics by stamps, not by arrival
            due.sort(key=itemgetter(1))
        for topic, items in groupby(due, itemgetter(1)):
            self.send(topic, [payload for _, _, payload in items])

    def _may_start(self) -> bool:
        if self.flow is not None:
            return self.flow.everyone_ready()
        alone = any(
            output.publisher.get_subscription_count() == 0 for output in self.outputs.values()
        )
        return not alone or time.monotonic() - self._born_s >= self.settings.number('wait')

    def _due_ns(self, now_s: float) -> float:
        assert self._base is not None
        if self._pace == 0.0:
            return math.inf
        since_s, from_ns = self._base
        return from_ns + (now_s - since_s) * self._pace * NS_PER_S

    def _repace(self, changes: list[RosParameter]) -> None:
        for change in changes:
            if change.name == self._pace_name:
                now_s = time.monotonic()
                if self._base is not None:
                    due_ns = min(self._due_ns(now_s), self._last_ns)
                    self._base = (now_s, int(due_ns))
                self._pace = float(change.value)

    def _clock_publisher(self) -> Any:
        deadline_s = time.monotonic() + LOOK_S
        while time.monotonic() < deadline_s:
            if others := self.get_publishers_info_by_topic(CLOCK_TOPIC):
                raise NodesError(
                    f'publish_clock = True: {node_of(others[0])} already publishes {CLOCK_TOPIC}, '
                    'and time can have one source only. Leave publish_clock out, or stop the other'
                )
            time.sleep(0.02)
        return self.create_publisher(ClockMessage, CLOCK_TOPIC, QoSProfile(depth=10))
