"""Plays a bag into the graph: its messages, at a pace, payloads untouched."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import QoSProfile

from tauto_core.bags import TOPICS, Bag, read_bag
from tauto_nodes.errors import ParameterError
from tauto_nodes.member import Item, SourceNode
from tauto_nodes.ports import MIN_DEPTH, Port, message_class, port
from tauto_nodes.running import main_of

ACKNOWLEDGE_S = 10


def relative(bag: Bag, topic: str) -> str:
    """Return a topic of the bag less the bag's namespace; absolute where it has not just one."""
    if bag.namespace is None:
        return topic
    prefix = f'/{bag.namespace}/' if bag.namespace else '/'
    return topic.removeprefix(prefix)


def ports_of(bag: Bag, asked: tuple[str, ...]) -> dict[str, Port]:
    """Return the ports to play on, by the topic's name in the bag.

    Raises:
        ParameterError: the bag has none of the topics asked for.
        NodesError: a message type that is not installed.
    """
    ports = {}
    for topic, ros_type in bag.topics.items():
        name = relative(bag, topic)
        if 'all' not in asked and not any(f'/{topic}'.endswith(f'/{one}') for one in asked):
            continue
        known = name in TOPICS and TOPICS[name].ros_type == ros_type
        foreign = QoSProfile(depth=MIN_DEPTH)
        ports[topic] = port(name) if known else Port(name, message_class(ros_type), foreign)
    if not ports:
        raise ParameterError(
            f'topics = {list(asked)}: the bag has none of them; it has {", ".join(bag.topics)}'
        )
    return ports


class Player(SourceNode):
    """Publishes a bag's topics under the player's namespace; ends with the bag.

    Args:
        bag: the bag, if it has been opened already; otherwise the parameter `bag` names it.
        progress: called with the share of the bag that was played, from 0 to 1.
        node_options: handed to rclpy.node.Node.
    """

    def __init__(
        self,
        *,
        bag: Bag | None = None,
        progress: Callable[[float], None] | None = None,
        **node_options: Any,
    ) -> None:
        super().__init__('player', 'rate', **node_options)
        self._progress = progress
        bag = bag or read_bag(Path(self.settings.text('bag')))
        for warning in bag.warnings:
            self.get_logger().warning(warning)
        ports = ports_of(bag, self.settings.names('topics'))
        self._begin_ns, self._end_ns = bag.start_ns or 0, bag.end_ns or 0
        self.connect([], list(ports.values()))
        self.start(self._items_of(bag, ports))

    def tick(self) -> None:
        """Send what is due, and report how far the bag has been played."""
        super().tick()
        if self._progress is not None:
            played_ns = max(self.sent_until_ns - self._begin_ns, 0)
            self._progress(played_ns / max(self._end_ns - self._begin_ns, 1))

    def all_sent(self) -> None:
        """End when the subscribers have acknowledged."""
        for output in self.outputs.values():
            output.publisher.wait_for_all_acked(Duration(seconds=ACKNOWLEDGE_S))
        sent = ', '.join(f'{topic} {output.sent}' for topic, output in self.outputs.items())
        self.get_logger().info(f'played {sent}')
        self.over = True

    @staticmethod
    def _items_of(bag: Bag, ports: dict[str, Port]) -> Iterator[Item]:
        for topic, _, stamp_ns, payload in bag.messages(ports):
            yield stamp_ns, ports[topic].name, payload


main = main_of(Player)

if __name__ == '__main__':
    main()
