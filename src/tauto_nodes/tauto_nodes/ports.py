"""Publishers and subscriptions for serialised messages: QoS, packs, counters, diagnostics.

Messages travel as the bytes that tauto_core.bags encodes and decodes: rclpy never builds a
message object, so a payload in the graph is the payload in the bag.
"""

from __future__ import annotations

import difflib
import struct
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any, ParamSpec

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import SetParametersResult
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import (
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSProfile,
    QoSReliabilityPolicy,
    qos_policy_name_from_kind,
)
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions
from std_msgs.msg import UInt8MultiArray

from tauto_core import samples as s
from tauto_core.bags import TOPICS
from tauto_core.samples import OBSERVATION, SCENE, SHIP_FIX
from tauto_nodes.errors import NodesError, ParameterError
from tauto_nodes.flow import BATCH, PACKED_TIMES, Flow
from tauto_nodes.parameters import QOS_PREFIX, declare, overrides_of, shared_names, take_raw

if TYPE_CHECKING:
    from tauto_nodes.member import Member


# -----------------------------------------------------------------------------
# Ports: a topic's message class and quality of service, from the topic table of the bags.

MIN_DEPTH = 1000
"""Least KEEP_LAST depth under flow control: above what may be in flight (flow.WINDOW)."""

INFINITE_NS = 2**63 - 1
"""The value that rmw reports for a time without limit."""

CREDIT_QOS = QoSProfile(depth=100)
END_QOS = QoSProfile(depth=32, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
PACK_QOS = QoSProfile(depth=MIN_DEPTH * PACKED_TIMES)


@dataclass(frozen=True)
class Port:
    """One side of a topic.

    Args:
        name: relative or absolute topic name.
        message: the rclpy message class.
        profile: quality of service, before overrides.
    """

    name: str
    message: Any
    profile: QoSProfile

    @property
    def is_latched(self) -> bool:
        """Whether late subscribers get the last message."""
        return bool(self.profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL)


def message_class(ros_type: str) -> Any:
    """Return the class of a type named like `sensor_msgs/msg/Imu`.

    Raises:
        NodesError: its package is not installed.
    """
    package, _, name = ros_type.partition('/msg/')
    try:
        return getattr(import_module(f'{package}.msg'), name)
    except (ImportError, AttributeError) as error:
        raise NodesError(
            f'message type {ros_type}: not installed here. Install the ROS package {package}, '
            'or leave its topics out'
        ) from error


def type_name(message: Any) -> str:
    """Return the name of the type that `message_class` finds."""
    return f'{message.__module__.partition(".")[0]}/msg/{message.__name__}'


def port(topic: str, imu_reliability: str = 'reliable') -> Port:
    """Return the port of a topic of the table; `imu_reliability` matters for ship/imu only."""
    entry = TOPICS[topic]
    best_effort = topic == s.SHIP_IMU and imu_reliability == 'best_effort'
    reliability = (
        QoSReliabilityPolicy.BEST_EFFORT if best_effort else QoSReliabilityPolicy.RELIABLE
    )
    durability = (
        QoSDurabilityPolicy.TRANSIENT_LOCAL if entry.latched else QoSDurabilityPolicy.VOLATILE
    )
    profile = QoSProfile(depth=entry.depth, reliability=reliability, durability=durability)
    return Port(topic, message_class(entry.ros_type), profile)


def can_match(offered: QoSProfile, requested: QoSProfile) -> bool:
    """Return whether a subscription that asks for `requested` can match one of our publishers.

    Ours offer no deadline and no liveliness lease. rclpy's own check takes the infinite times
    that a discovered subscription reports for finite ones.
    """
    reliable = QoSReliabilityPolicy.RELIABLE
    latched = QoSDurabilityPolicy.TRANSIENT_LOCAL
    return (
        (offered.reliability == reliable or requested.reliability != reliable)
        and (offered.durability == latched or requested.durability != latched)
        and requested.deadline.nanoseconds in (0, INFINITE_NS)
        and requested.liveliness_lease_duration.nanoseconds in (0, INFINITE_NS)
    )


def overriding(controlled: bool) -> QoSOverridingOptions:
    """Return the options that let parameters override history, depth and reliability.

    With flow control, overrides under which messages could be lost are refused.
    """

    def check(profile: QoSProfile) -> SetParametersResult:
        latched = profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL
        shallow = (
            profile.history == QoSHistoryPolicy.KEEP_LAST
            and profile.depth < MIN_DEPTH
            and not latched
        )
        lossy = profile.reliability != QoSReliabilityPolicy.RELIABLE
        if not controlled or not (shallow or lossy):
            return SetParametersResult(successful=True)
        return SetParametersResult(
            successful=False,
            reason=f'depth = {profile.depth}, reliability = {profile.reliability.name.lower()}: '
            f'flow_control = credits needs reliable and a depth of at least {MIN_DEPTH}',
        )

    return QoSOverridingOptions.with_default_policies(callback=check)


def refuse_unknown_qos(node: Node) -> None:
    """See that each `qos_overrides` key is one of a publisher or subscription of this node.

    Call it when these have been made: rclpy declares the keys of each, and ignores all others.

    Raises:
        ParameterError: which key none of them has, and the nearest that there is.
    """
    asked = [name for name in overrides_of(node) if name.startswith(QOS_PREFIX)]
    shared = shared_names(node.get_fully_qualified_name(), sys.argv)
    known = list(node.get_parameters_by_prefix(QOS_PREFIX.rstrip('.')))
    problems = []
    for name in asked:
        if node.has_parameter(name) or name in shared:
            continue
        nearest = difflib.get_close_matches(name.removeprefix(QOS_PREFIX), known, 1, 0.0)
        there = f'the nearest is {QOS_PREFIX}{nearest[0]}' if nearest else 'it has none'
        problems.append(f'{name}: no publisher or subscription of this node has it; {there}')
    if problems:
        raise ParameterError(f'{node.get_fully_qualified_name()}: ' + '; '.join(problems))


# -----------------------------------------------------------------------------
# Many messages in one, between the nodes of our own graph: the overhead is paid once.
#
# A pack is a std_msgs/UInt8MultiArray. Its data are, as little-endian uint32, the number of
# messages and their lengths, then the messages, with their exact lengths: DDS pads none of them.

PACK_TOPIC = '_tauto/pack/'
"""Prefix of the name of a packed topic."""

MOST_BYTES = 60_000
"""Largest size of a pack of more than one message: it fits into a UDP datagram."""

# CDR: encapsulation, no dimensions, no offset, length of the data.
_HEAD = struct.Struct('<4sIII')
_LITTLE_ENDIAN = b'\x00\x01\x00\x00'


def pack(payloads: Sequence[bytes]) -> Iterator[bytes]:
    """Yield the serialised packs of messages, in their order."""
    first = size = 0
    for last, payload in enumerate(payloads):
        if size and size + len(payload) > MOST_BYTES:
            yield _packed(payloads[first:last])
            first, size = last, 0
        size += len(payload)
    if payloads:
        yield _packed(payloads[first:])


def _packed(payloads: Sequence[bytes]) -> bytes:
    n = len(payloads)
    lengths = struct.pack(f'<{n + 1}I', n, *map(len, payloads))
    data = b''.join([lengths, *payloads])
    return _HEAD.pack(_LITTLE_ENDIAN, 0, 0, len(data)) + data


def unpack(topic: str, octets: bytes) -> list[bytes]:
    """Return the messages of a serialised pack.

    Args:
        topic: whose messages they are.
        octets: the pack.

    Raises:
        NodesError: it is none.
    """
    try:
        (n,) = struct.unpack_from('<I', octets, _HEAD.size)
        lengths = struct.unpack_from(f'<{n}I', octets, _HEAD.size + 4)
    except struct.error:
        raise NodesError(f'{PACK_TOPIC}{topic}: not a pack of messages: {octets[:40]!r}') from None
    at = _HEAD.size + 4 * (n + 1)
    if at + sum(lengths) > len(octets):
        raise NodesError(
            f'{PACK_TOPIC}{topic}: a pack of {n} messages is cut short: {len(octets)} bytes'
        )
    messages = []
    for length in lengths:
        messages.append(octets[at : at + length])
        at += length
    return messages


# -----------------------------------------------------------------------------
# /diagnostics: one status a second from each node, named with its namespace.
#
# A node publishes OK, WARN and ERROR; STALE is what an aggregator says of a node that is silent.

PERIOD_S = 1.0

IRREGULAR = (SCENE, OBSERVATION)
"""Topics whose silence means nothing."""

OPTIONAL = (SCENE, OBSERVATION, SHIP_FIX)
"""Topics that a graph on a live sensor may do without."""

RECENT_S = 10.0
"""Time after a counter has risen during which it causes a warning [s]."""

LAST_WORDS_S = 1

Finding = tuple[bytes, str]


def assess(member: Member, now_s: float, recent: dict[str, int] | None = None) -> Finding:
    """Return the worst level and the reasons for it.

    Args:
        member: the node whose status it is.
        now_s: steady time [s], as time.monotonic gives it.
        recent: by how much counters have risen in the last RECENT_S; None: since the start.
    """
    risen = {name: n for name, n in member.health().items() if n} if recent is None else recent
    found = list(_findings(member, now_s, risen))
    level = max((level for level, _ in found), default=DiagnosticStatus.OK)
    words = '; '.join(words for at, words in found if at == level)
    return level, words or ('finished' if member.input_over else 'under way')


def _findings(member: Member, now_s: float, risen: dict[str, int]) -> Iterator[Finding]:
    error, warn = DiagnosticStatus.ERROR, DiagnosticStatus.WARN
    if member.failure is not None:
        yield error, f'failed: {member.failure}'
    if clash := [
        t for t, source in member.inputs.items() if source.incompatible and not source.matched
    ]:
        yield error, f'incompatible QoS on {", ".join(clash)}'
    if member.input_over:
        return
    if member.trouble:
        yield error, member.trouble
    if passed := member.recent_alarm(now_s):
        yield error, passed
    yield from _missing(member, now_s)
    for topic, source in member.inputs.items():
        if source.matched > 1:
            yield warn, f'several publishers on {topic}: {", ".join(member.sources_of(topic))}'
    if len(twins := member.twins()) > 1:
        yield warn, f'{len(twins)} nodes are named {twins[0]}'
    if risen:
        counters = ', '.join(f'{name} {n}' for name, n in risen.items())
        yield warn, f'in the last {RECENT_S:g} s: {counters}'


def _missing(member: Member, now_s: float) -> Iterator[Finding]:
    """Yield what is missing: nodes, publishers, messages."""
    if member.waiting:
        yield DiagnosticStatus.WARN, f'waiting for {", ".join(member.waiting)}'
    lonely = [topic for topic, source in member.inputs.items() if not source.matched]
    if member.flow is None:
        # A recorder takes what there is; a stage can do without what is optional.
        needed = [topic for topic in lonely if topic not in OPTIONAL]
        lonely = needed if member.outputs or len(lonely) == len(member.inputs) else []
    if unsent := [topic for topic in lonely if not member.misfits(topic)]:
        yield DiagnosticStatus.WARN, f'no publisher on {", ".join(unsent)}'
    for topic in lonely:
        if others := member.misfits(topic):
            wanted = member.inputs[topic].type_name
            yield (
                DiagnosticStatus.WARN,
                f'no publisher of {wanted} on {topic}: {", ".join(others)}. Let one send {wanted}',
            )
    limit_s = member.settings.number('stale_after')
    if silent := [
        topic
        for topic, source in member.inputs.items()
        if topic not in IRREGULAR
        and source.matched
        and source.last_s is not None
        and now_s - source.last_s > limit_s
    ]:
        level = DiagnosticStatus.ERROR if member.outputs else DiagnosticStatus.WARN
        yield level, f'nothing for {limit_s:g} s on {", ".join(silent)}'


class Diagnostics:
    """Publishes a member's status once a second, and whenever it is asked to."""

    def __init__(self, member: Member) -> None:
        self._member = member
        self._past: deque[tuple[float, dict[str, int]]] = deque()
        self._publisher = member.create_publisher(
            DiagnosticArray, '/diagnostics', QoSProfile(depth=10)
        )
        # Not guarded: a node that has failed in a foreign executor goes on saying so.
        member.create_timer(PERIOD_S, self.publish, clock=member.steady)

    def publish(self) -> None:
        """Publish the status as it is now."""
        member, now_s = self._member, time.monotonic()
        health = member.health()
        level, message = assess(member, now_s, self._risen(now_s, health))
        counts = {f'{topic} received': port.received for topic, port in member.inputs.items()}
        counts |= {f'{topic} sent': port.sent for topic, port in member.outputs.items()}
        status = DiagnosticStatus(
            level=level,
            name=member.get_fully_qualified_name().lstrip('/'),
            message=message,
            values=[KeyValue(key=k, value=str(n)) for k, n in {**counts, **health}.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = member.get_clock().now().to_msg()
        self._publisher.publish(array)

    def deliver(self) -> None:
        """Wait, for a moment, until the last status has reached who subscribes to it."""
        self._publisher.wait_for_all_acked(Duration(seconds=LAST_WORDS_S))

    def _risen(self, now_s: float, health: dict[str, int]) -> dict[str, int]:
        self._past.append((now_s, health))
        while len(self._past) > 1 and self._past[1][0] <= now_s - RECENT_S:
            self._past.popleft()
        at_s, before = self._past[0]
        if now_s - at_s < RECENT_S:
            before = {}  # not yet that old
        return {
            name: n - before.get(name, 0) for name, n in health.items() if n > before.get(name, 0)
        }


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
