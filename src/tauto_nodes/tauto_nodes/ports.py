"""Publishers and subscriptions for serialised messages, and their counters.

Messages travel as the bytes that tauto_core.bags encodes and decodes: rclpy never builds a
message object, so a payload in the graph is the payload in the bag.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, ParamSpec

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import qos_policy_name_from_kind
from rclpy.qos_overriding_options import InvalidQosOverridesError
from std_msgs.msg import UInt8MultiArray

from tauto_nodes.diagnostics import Diagnostics
from tauto_nodes.errors import NodesError, ParameterError
from tauto_nodes.flow import BATCH, Flow
from tauto_nodes.packs import PACK_TOPIC, pack, unpack
from tauto_nodes.parameters import declare
from tauto_nodes.qos import PACK_QOS, Port, overriding, refuse_unknown_qos, type_name
from tauto_nodes.rclpy_private import take_raw

P = ParamSpec('P')

_NAMELESS = '_NODE_NAME_UNKNOWN_'
"""What rmw says of a publisher whose node it has not heard of yet, or that has none."""


@dataclass
class Input:
    """State of one subscription.

    `type_name`: of the messages it takes; `last_s`: when a message or a publisher came last [s].
    """

    type_name: str
    subscription: Any = None
    received: int = 0
    taken: int = 0
    last_s: float | None = None
    matched: int = 0
    incompatible: int = 0
    pending: list[bytes] = field(default_factory=list)


@dataclass
class Output:
    """State of one publisher.

    `carrier`: of packs, where the graph has them; the topic itself then carries what others
    subscribe to, `watchers` in number. `matched` counts the subscribers within the graph.
    """

    publisher: Any
    carrier: Any = None
    is_latched: bool = False
    watchers: int = 0
    sent: int = 0
    matched: int = 0
    incompatible: int = 0
    queue: deque[bytes] = field(default_factory=deque)

    @property
    def link(self) -> Any:
        """What carries the messages to the nodes of the graph."""
        return self.carrier or self.publisher

    def publish(self, payloads: Sequence[bytes]) -> None:
        """Send messages, packed where the graph has packs."""
        if self.carrier is not None:
            for octets in pack(payloads):
                self.carrier.publish(octets)
        if self.carrier is None or self.watchers or self.is_latched:
            for payload in payloads:
                self.publisher.publish(payload)
        self.sent += len(payloads)


class PortNode(Node):
    """A node with the parameters of its role and counted ports. Subclasses say `received`.

    Args:
        role: says which node of the table in parameters.py this is; also its default name.
        node_options: handed to rclpy.node.Node.
    """

    def __init__(self, role: str, **node_options: Any) -> None:
        super().__init__(role, **node_options)
        self.role = role
        self.settings = declare(self, role)
        self.failure: Exception | None = None
        self.flow: Flow | None = None
        self.diagnostics: Diagnostics | None = None
        self.inputs: dict[str, Input] = {}
        self.outputs: dict[str, Output] = {}

    def received(self, source: Input, payloads: list[bytes]) -> None:
        """Take messages that have come."""

    def open_ports(self, inputs: Sequence[Port], outputs: Sequence[Port]) -> None:
        """Create the publishers and subscriptions.

        Raises:
            ParameterError: QoS overrides that do not go with flow control, or of no port.
        """
        try:
            for port in outputs:
                self._publish_on(port)
            for port in inputs:
                self.listen_to(port)
        except InvalidQosOverridesError as error:
            raise ParameterError(f'{self.get_fully_qualified_name()}: {error}') from error
        refuse_unknown_qos(self)

    def guard(self, callback: Callable[P, None]) -> Callable[P, None]:
        """Return the callback, wrapped so that an error ends the node with that reason."""

        def guarded(*args: P.args, **kwargs: P.kwargs) -> None:
            if self.failure is not None:
                return
            try:
                callback(*args, **kwargs)
            except Exception as error:
                self.fail(error)

        return guarded

    def fail(self, error: Exception) -> None:
        """Give up: nothing is taken or sent any more; /rosout and /diagnostics get the reason."""
        if self.failure is None:
            self.failure = error
            self.get_logger().fatal(f'{type(error).__name__}: {error}')
            if self.diagnostics is not None:
                self.diagnostics.publish()

    def link_name(self, topic: str) -> str:
        """Return the full name of the topic that carries a topic's messages to the graph."""
        return self.resolve_topic_name(PACK_TOPIC + topic if self.settings.packed else topic)

    def _publish_on(self, port: Port) -> None:
        packed = self.settings.packed
        events = PublisherEventCallbacks(
            incompatible_qos=lambda info: self._offers_too_little(port.name, info)
        )
        publisher = self.create_publisher(
            port.message,
            port.name,
            port.profile,
            event_callbacks=events,
            qos_overriding_options=overriding(self.settings.credits),
        )
        output = Output(publisher, is_latched=port.is_latched)
        self.outputs[port.name] = output
        if packed:
            name = PACK_TOPIC + port.name
            output.carrier = self.create_publisher(UInt8MultiArray, name, PACK_QOS)

    def listen_to(self, port: Port) -> Any:
        """Create a subscription with its state in `inputs`; return it."""
        message = UInt8MultiArray if self.settings.packed else port.message
        source = self.inputs[port.name] = Input(type_name(message))
        if self.settings.packed:
            source.subscription = self.create_subscription(
                UInt8MultiArray,
                PACK_TOPIC + port.name,
                self.guard(lambda octets: self.received(source, unpack(port.name, octets))),
                PACK_QOS,
                raw=True,
            )
            return source.subscription
        drains = self.settings.text('executor') == 'single'

        def take(payload: bytes) -> None:
            self.received(source, [payload])
            # One message a wait is all that rclpy takes, and a wait costs it milliseconds.
            for _ in range(BATCH if drains else 0):
                if (more := take_raw(source.subscription)) is None:
                    return
                self.received(source, [more])

        events = SubscriptionEventCallbacks(
            incompatible_qos=lambda info: self._asks_too_much(port.name, info)
        )
        source.subscription = self.create_subscription(
            port.message,
            port.name,
            self.guard(take),
            port.profile,
            raw=True,
            event_callbacks=events,
            qos_overriding_options=overriding(self.settings.credits),
        )
        return source.subscription

    def look_at_links(self) -> None:
        """Note how many publishers and subscribers each port is matched with.

        The events that tell of them are not asked for, nor those of lost messages: rmw_fastrtps
        locks event and reader in opposite orders when it takes one and when the next one comes,
        and then both wait for good (ros2/rmw_fastrtps pull request 890, not in Jazzy).
        """
        for topic, source in self.inputs.items():
            count = source.subscription.get_publisher_count()
            if count != source.matched:
                source.matched, source.last_s = count, time.monotonic()
                if count > 1:
                    self._several_sources(topic)
        for output in self.outputs.values():
            output.matched = output.link.get_subscription_count()
            if output.carrier is not None:
                output.watchers = output.publisher.get_subscription_count()

    def _asks_too_much(self, topic: str, info: Any) -> None:
        self.inputs[topic].incompatible = info.total_count
        self.get_logger().error(
            f"{topic}: a publisher's quality of service does not match; "
            'set qos_overrides or imu_reliability'
        )

    def _offers_too_little(self, topic: str, info: Any) -> None:
        self.outputs[topic].incompatible = info.total_count
        self.get_logger().warning(
            f'{topic}: a subscriber asks for more than this node offers '
            f'({qos_policy_name_from_kind(info.last_policy_kind)}) and gets nothing'
        )

    def sources_of(self, topic: str) -> list[str]:
        """Return the names of the nodes that publish what an input takes."""
        wanted = self.inputs[topic].type_name
        infos = self.get_publishers_info_by_topic(self.link_name(topic))
        return sorted(node_of(info) for info in infos if info.topic_type == wanted)

    def misfits(self, topic: str) -> list[str]:
        """Return the publishers on an input's topic that send another type, each in words."""
        wanted = self.inputs[topic].type_name
        return sorted(
            f'{node_of(info)} sends {info.topic_type}'
            for info in self.get_publishers_info_by_topic(self.link_name(topic))
            if info.topic_type != wanted
        )

    def _several_sources(self, topic: str) -> None:
        words = f'{topic}: more than one publisher ({", ".join(self.sources_of(topic))})'
        if self.flow is None:
            self.get_logger().warning(f'{words}; their messages are mixed. Stop all but one')
        elif self.failure is None:
            self.fail(
                NodesError(
                    f'{words}; with flow_control = credits a topic has one source only. Stop the '
                    'other, or give the graph a namespace or a ROS_DOMAIN_ID of its own'
                )
            )


def node_of(info: Any) -> str:
    """Return the full name of the node that a publisher belongs to."""
    if info.node_name == _NAMELESS:
        return 'a node not yet known by name'
    return f'{info.node_namespace.rstrip("/")}/{info.node_name}'
