"""The base of all nodes: ports, messages in and out, errors, an end, and diagnostics.

Messages travel as the bytes that tauto_core.bags encodes and decodes: rclpy never builds a
message object, so a payload in the graph is the payload in the bag.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from typing import Any, NamedTuple, ParamSpec, cast

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import (
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSProfile,
    QoSReliabilityPolicy,
)
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions

from tauto_core import samples as s
from tauto_core.bags import TOPICS, decode
from tauto_core.navigation import ESTIMATE_NAMES
from tauto_core.samples import OBSERVATION, SCENE, SHIP_FIX, SLACK, Samples
from tauto_core.scene.errors import BagError
from tauto_nodes import NodesError, ParameterError
from tauto_nodes.live.parameters import QOS_PREFIX, declare, overrides_of, take_raw

# -----------------------------------------------------------------------------
# Ports: publishers and subscriptions for serialised messages, their quality of service and state.

MIN_DEPTH = 1000
"""Least KEEP_LAST depth under flow control: above what may be in flight (credits.WINDOW)."""


@dataclass(frozen=True)
class TopicPort:
    """One side of a topic: its relative or absolute name, the rclpy message class, and the quality
    of service before overrides.
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


def profile_of(depth: int, *, reliable: bool, latched: bool) -> QoSProfile:
    """Return a quality of service with KEEP_LAST."""
    durability, reliability = QoSDurabilityPolicy, QoSReliabilityPolicy
    return QoSProfile(
        depth=depth,
        reliability=reliability.RELIABLE if reliable else reliability.BEST_EFFORT,
        durability=durability.TRANSIENT_LOCAL if latched else durability.VOLATILE,
    )


def port(topic: str, imu_reliability: str = 'reliable') -> TopicPort:
    """Return the port of a topic of the table. `imu_reliability` is for ship/imu."""
    entry = TOPICS[topic]
    reliable = topic != s.SHIP_IMU or imu_reliability == 'reliable'
    profile = profile_of(entry.depth, reliable=reliable, latched=entry.latched)
    return TopicPort(topic, message_class(entry.ros_type), profile)


def overriding(controlled: bool) -> QoSOverridingOptions:
    """Return the options that let parameters override history, depth and reliability.

    With flow control, overrides under which messages could be lost are refused.
    """

    def check(profile: QoSProfile) -> SetParametersResult:
        shallow = (
            profile.history == QoSHistoryPolicy.KEEP_LAST
            and profile.depth < MIN_DEPTH
            and profile.durability != QoSDurabilityPolicy.TRANSIENT_LOCAL
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


class Times(NamedTuple):
    """When a message was received and sent [ns], by the clock of the system."""

    received_ns: int
    sent_ns: int

    @staticmethod
    def told(info: Mapping[str, Any] | None) -> Times:
        """Return the times of the middleware, or now for both."""
        if info is None:
            now_ns = time.time_ns()
            return Times(now_ns, now_ns)
        return Times(info['received_timestamp'] or time.time_ns(), info['source_timestamp'])


@dataclass
class Input:
    """State of one subscription.

    Attributes:
        is_shared: whether many publish there, and silence is normal.
        is_signed: whether messages name their graph.
        last_s: time of the last message or new publisher [s].
        times: times of the `pending` messages, if the node keeps them.
    """

    is_shared: bool = False
    is_signed: bool = False
    subscription: Any = None
    received: int = 0
    taken: int = 0
    last_s: float | None = None
    matched: int = 0
    incompatible: int = 0
    pending: list[bytes] = field(default_factory=list)
    times: list[Times] = field(default_factory=list)


@dataclass
class Output:
    """State of one publisher. `matched` counts its subscribers."""

    publisher: Any
    sent: int = 0
    matched: int = 0
    queue: deque[bytes] = field(default_factory=deque)

    @property
    def watched(self) -> bool:
        """Whether somebody outside of the own graph takes single messages."""
        return bool(self.matched)

    def look(self) -> None:
        """Count the subscribers."""
        self.matched = self.publisher.get_subscription_count()

    def publish(self, payloads: Sequence[bytes]) -> None:
        """Send messages."""
        for payload in payloads:
            self.publisher.publish(payload)
        self.sent += len(payloads)


def node_of(info: Any) -> str:
    """Return the full name of the node that a publisher belongs to."""
    # rmw's name for an unknown or unnamed node
    if info.node_name == '_NODE_NAME_UNKNOWN_':
        return 'a node not yet known by name'
    return f'{info.node_namespace.rstrip("/")}/{info.node_name}'


# -----------------------------------------------------------------------------
# From serialised messages to samples. Invalid messages are counted and ignored.
#
# Foreign nodes may publish on a topic. A message that cannot be decoded, belongs to another frame,
# or has wrong names or NaN neither ends a node nor hides its neighbours in a batch.


def short(said: object, write: Callable[[object], str] = repr) -> str:
    """Return a part of a message in at most 80 characters, for logs and /diagnostics."""
    return text if len(text := write(said)) <= 80 else f'{text[:79]}…'


class Intake:
    """Decodes the messages of one topic of the table.

    `note` is called with a reason and its description for each ignored message. The first message
    decides about the frame and the names of the others.
    """

    def __init__(self, topic: str, note: Callable[[str, str], None]) -> None:
        self._topic, self._note = topic, note
        self._kind: tuple[str, tuple[str, ...], tuple[int, ...]] | None = None
        # Names with which the scalars must begin. For other topics the first message decides.
        self._required = ESTIMATE_NAMES if topic == s.ESTIMATE else None

    def samples(self, payloads: Sequence[bytes]) -> tuple[s.Samples | None, list[bytes]]:
        """Return the samples of the usable messages, or `None`, and these messages.

        Messages without a header are stamped 0.
        """
        try:
            whole = self._decoded(payloads)
            if not any(self._faults(whole)):
                return whole, list(payloads)
        except BagError:
            pass  # one by one it is found which of them cannot be decoded
        good: list[tuple[s.Samples, bytes]] = []
        for payload in payloads:
            try:
                sample = self._decoded([payload])
                fault = next(self._faults(sample), None)
            except BagError as error:
                fault = 'undecodable', short(error, str)
            if fault is None:
                good.append((sample, payload))
            else:
                self._note(fault[0], f'a message is ignored: {fault[1]}')
        if not good:
            return None, []
        return s.join([cast(s.TimeSamples, one) for one, _ in good]), [raw for _, raw in good]

    def _decoded(self, payloads: Sequence[bytes]) -> s.Samples:
        samples = decode(self._topic, payloads, np.zeros(len(payloads), np.int64))
        if s.count(samples) != len(payloads):
            raise BagError(f'{self._topic}: {len(payloads)} messages, other samples')
        return samples

    def _faults(self, samples: s.Samples) -> Iterator[tuple[str, str]]:
        """Yield the faults of samples, each in a word and in full."""
        if isinstance(samples, s.TextSamples | s.SpatialImu):
            return
        if samples.stamp_ns.min() < 0:
            yield 'out_of_range', f'stamped {samples.stamp_ns.min() * 1e-9:.6g} s, before 0'
        names: tuple[str, ...] = ()
        widths: tuple[int, ...] = ()
        if isinstance(samples, s.JointSamples):
            names = samples.name
            numbers = (samples.position, samples.velocity, samples.effort)
            widths = tuple(number.shape[1] for number in numbers)
            if not all(np.isfinite(number).all() for number in numbers):
                yield 'not_finite', 'it has NaN or an infinite number'
        if self._required is not None and names[: len(self._required)] != self._required:
            yield 'other_names', f'names {short(names)}, which do not begin with {self._required}'
        if self._kind is None:
            self._kind = samples.frame_id, names, widths
        frame, first_names, first_widths = self._kind
        if frame != samples.frame_id:
            words = f'frame {short(samples.frame_id)}, not {short(frame)} as before'
            yield 'other_frame', f'{words}. After a change of the sensor start the node again'
        if first_names != names:
            yield 'other_names', f'names {short(names)}, not {short(first_names)} as before'
        if first_widths != widths:
            yield (
                'other_widths',
                f'arrays of {short(widths)} numbers, not {short(first_widths)} as before',
            )


# -----------------------------------------------------------------------------
# The node.

P = ParamSpec('P')

TICK_S = 0.01
"""Interval at which a node that paces time works [s]. Others work so long after a message has
come, and if they are calm, without flow control, CALM_S after it."""

CALM_S = 0.1

LOOK_S = 0.3
"""Interval at which they look after their ports and other tasks [s]: an idle node costs CPU mainly
by waking up."""

BATCH = 200
"""Messages after which a node works without waiting for its tick."""


class GraphNode(Node):
    """Base of the nodes. Subclasses override `take`, `at_end`, `tick`, `close`, `health`.

    `role` is the node's key in the table of parameters.py, and its default name.
    """

    keeps_times = False
    """Whether `times` has, in `take`, when each message was received and sent."""

    is_calm = False
    """Whether no subscriber of the node needs its messages within a tenth of a second."""

    paces = False
    """Whether the node sends by the wall clock."""

    def __init__(self, role: str, **node_options: Any) -> None:
        super().__init__(role, **node_options)
        self.role = role
        self.settings = declare(self, role)
        self.steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.inputs: dict[str, Input] = {}
        self.outputs: dict[str, Output] = {}
        self.times: dict[str, list[Times]] = {}
        self.flow: Any = None
        """The node's part in the flow control of a voyage, or `None` on a boat."""
        self.diagnostics: Diagnostics | None = None
        self.failure: Exception | None = None
        self.over = False
        self.exit_code = 0
        self.input_over = False
        self.waiting: list[str] = []
        """Nodes for which the outputs wait before they send."""
        self._soon: Any = None
        self._intakes: dict[str, Intake] = {}
        self._left_aside: dict[str, int] = {}
        self.last_alarm = 0.0, ''
        """Time [s], by `time.monotonic()`, and words of the last `alarm`."""

    # For subclasses.

    def take(self, payloads: Mapping[str, Sequence[bytes]]) -> None:
        """Take messages that have arrived, by topic."""

    def at_end(self) -> None:
        """Publish the last results: the input has ended."""

    def lost(self, short: Mapping[str, int]) -> None:
        """Act on the numbers of lost messages, by topic.

        NodesError: the node could no longer publish results of the scene.
        """
        raise NodesError(f'messages were lost on the way: {dict(short)}. Start the voyage again')

    def tick(self) -> None:
        """Work at each tick of the steady clock and when credits come."""

    def close(self) -> None:
        """Leave the graph cleanly, while the context is alive."""

    def health(self) -> dict[str, int]:
        """Return counters of refused messages and bridged gaps."""
        clashes = {t: source.incompatible for t, source in self.inputs.items()}
        return self._left_aside | {f'{t} incompatible_qos': n for t, n in clashes.items() if n}

    def waits_on_shutdown(self) -> bool:
        """Whether the node, after a request to stop, waits for messages of others."""
        return False

    @property
    def trouble(self) -> str:
        """The fault that stops the node at present, or an empty text."""
        return ''

    @property
    def notices(self) -> list[str]:
        """Missing inputs without which the node works at present, with remedies."""
        return []

    # Faults of messages.

    def decoded(self, topic: str, raw: Sequence[bytes]) -> tuple[Samples | None, list[bytes]]:
        """Return the samples of the usable messages, and these. Only they end a silence."""
        if topic not in self._intakes:
            self._intakes[topic] = Intake(topic, partial(self.note, topic))
        samples, good = self._intakes[topic].samples(raw)
        if samples is not None:
            self.inputs[topic].last_s = time.monotonic()
        return samples, good

    def note(self, topic: str, reason: str, words: str) -> None:
        """Count a fault of a message. In our own graph it is a NodesError."""
        if self.flow is not None:
            raise NodesError(f'{topic}: {reason}: {words}')
        self.leave_aside(topic, reason, words)

    def leave_aside(self, topic: str, reason: str, words: str) -> None:
        """Count an ignored message, and log the first of a kind."""
        key = f'{topic} {reason}'
        self._left_aside[key] = self._left_aside.get(key, 0) + 1
        if self._left_aside[key] == 1:
            self.get_logger().warning(f'{topic}: {words} (counted as {reason})')

    def alarm(self, words: str) -> None:
        """Report an error in /diagnostics for a while."""
        self.last_alarm = time.monotonic(), words

    # Errors.

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
        """Give up: neither take nor send messages. /rosout and /diagnostics get the reason."""
        if self.failure is None:
            self.failure = error
            self.get_logger().fatal(f'{type(error).__name__}: {error}')
            if self.diagnostics is not None:
                self.diagnostics.publish()

    # Ports.

    def connect(self, inputs: Sequence[TopicPort], outputs: Sequence[TopicPort]) -> None:
        """Create the ports and begin to tick.

        NodesError: the graph's names do not hold the node. ParameterError: QoS overrides that do
        not go with flow control.
        """
        if self.settings.credits:
            # by name: a boat does not import the simulation
            control = import_module('tauto_nodes.simulation.credits').Credits
            self.flow = control(self, [p.name for p in inputs], [p.name for p in outputs])
        try:
            for port in outputs:
                publisher = self.create_publisher(
                    port.message,
                    port.name,
                    port.profile,
                    qos_overriding_options=overriding(self.settings.credits),
                )
                self.outputs[port.name] = (
                    Output(publisher) if self.flow is None else self.flow.output(port, publisher)
                )
            for port in inputs:
                self.listen_to(port)
        except InvalidQosOverridesError as error:
            raise ParameterError(f'{self.get_fully_qualified_name()}: {error}') from error
        for name in overrides_of(self):  # rclpy declares those of its ports, and ignores others
            if name.startswith(QOS_PREFIX) and not self.has_parameter(name):
                has = ', '.join(self.get_parameters_by_prefix(QOS_PREFIX.rstrip('.')))
                self.get_logger().warning(f'{name}: is of no port of this node. It has {has}')
        if self.paces:
            every_s = TICK_S
        else:
            every_s = LOOK_S if self.flow is None else self.flow.turns_s
            soon_s = CALM_S if self.is_calm and self.flow is None else TICK_S
            self._soon = self.create_timer(soon_s, self.guard(self._hurry), clock=self.steady)
            self._soon.cancel()
        self.create_timer(every_s, self.guard(self._tick), clock=self.steady)

    def listen_to(self, port: TopicPort, *, is_shared: bool = False) -> Any:
        """Create a subscription with its state in `inputs`. Return it."""
        source = self.inputs[port.name] = Input(is_shared)
        if self.flow is not None and self.flow.listen_to(port, source):
            return source.subscription
        drains = self.settings['executor'] == 'single'

        def take(payload: bytes, info: Mapping[str, Any] | None = None) -> None:
            if self.keeps_times:
                source.times.append(Times.told(info))
            self.received(source, [payload])
            # One message a wait is all that rclpy takes, and a wait costs it milliseconds.
            for _ in range(BATCH if drains else 0):
                if (more := take_raw(source.subscription)) is None:
                    return
                payload, info = more
                if self.keeps_times:
                    source.times.append(Times.told(info))
                self.received(source, [payload])

        def asks_too_much(info: Any) -> None:
            source.incompatible = info.total_count
            self.get_logger().error(
                f"{port.name}: a publisher's quality of service does not match. "
                'Set qos_overrides or imu_reliability'
            )

        source.subscription = self.create_subscription(
            port.message,
            port.name,
            # the events executor fails if a callback asks for more (7.1.6)
            self.guard(take if drains and self.keeps_times else lambda one: take(one)),  # noqa: PLW0108
            port.profile,
            raw=True,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=asks_too_much),
            qos_overriding_options=overriding(self.settings.credits),
        )
        return source.subscription

    def look_at_links(self) -> None:
        """Note how many publishers and subscribers each port is matched with.

        It does not use the events for them, nor for lost messages: rmw_fastrtps locks event and
        reader in opposite orders, and can deadlock (its pull request 890, not in Jazzy).
        """
        for topic, source in self.inputs.items():
            count = source.subscription.get_publisher_count()
            if count != source.matched:
                source.matched, source.last_s = count, time.monotonic()
                if count < 2 or source.is_shared or source.is_signed:
                    continue
                words = f'{topic}: more than one publisher ({self.sources_of(topic)})'
                if self.flow is None:
                    self.get_logger().warning(
                        f'{words}. Their messages are mixed. Stop all but one'
                    )
                else:
                    remedy = 'Stop the other, or give the graph a namespace or a ROS_DOMAIN_ID'
                    self.fail(NodesError(f'{words}, and credits know one source only. {remedy}'))
        for output in self.outputs.values():
            output.look()

    def sources_of(self, topic: str) -> str:
        """Return the names of the nodes that publish on an input's topic."""
        name = self.inputs[topic].subscription.topic_name
        return ', '.join(sorted(map(node_of, self.get_publishers_info_by_topic(name))))

    # In.

    def received(self, source: Input, payloads: list[bytes]) -> None:
        """Keep the messages. Process them if there are many."""
        if self.input_over:
            return
        source.received += len(payloads)
        source.pending += payloads
        self.hurry()
        batch = BATCH if self.flow is None else self.flow.batch
        if len(source.pending) >= batch and not self.backlogged:
            self.work()
            if self.flow is not None:
                self.flow.report()

    def hurry(self) -> None:
        """Work soon, not only when the next look is due."""
        if self._soon is not None and self._soon.is_canceled():
            self._soon.reset()

    def _hurry(self) -> None:
        self._soon.cancel()
        if self.flow is not None:
            self._tick()
            return
        self.tick()
        self.work()

    def work(self) -> None:
        """Take the pending messages."""
        # While its own output waits, a node takes no input: this holds its sources back.
        if self.backlogged:
            return
        now = time.monotonic()
        payloads = {}
        for topic, source in self.inputs.items():
            if source.pending:
                payloads[topic] = source.pending
                source.taken += len(source.pending)
                source.last_s = now if self.flow is not None else source.last_s
                source.pending = []
                self.times[topic], source.times = source.times, []
        if payloads:
            self.take(payloads)

    # Out.

    @property
    def backlogged(self) -> bool:
        """Whether messages wait because a consumer is behind."""
        return any(output.queue for output in self.outputs.values())

    def send(self, topic: str, payloads: Sequence[bytes]) -> None:
        """Publish messages in order, now or as soon as flow control allows."""
        self.outputs[topic].queue.extend(payloads)
        self.pump(topic)

    def pump(self, topic: str) -> None:
        """Publish waiting messages, as far as flow control allows."""
        output = self.outputs[topic]
        count = len(output.queue)
        if self.flow is not None and count:
            count = self.flow.allowed(topic, output)
        if count > 0:
            output.publish([output.queue.popleft() for _ in range(count)])

    def end_input(self) -> None:
        """Process all pending messages and publish the last results. Ignore later input."""
        if not self.input_over:
            self.work()
            self.input_over = True
            self.at_end()

    def _tick(self) -> None:
        self.look_at_links()
        self.tick()
        # Waiting messages are sent before new work, which a node with a backlog does not take.
        for topic in self.outputs:
            self.pump(topic)
        self.work()
        if self.flow is not None:
            self.flow.turn()


# -----------------------------------------------------------------------------
# /diagnostics: one status a second from each node, named with its namespace.
#
# A node publishes OK, WARN and ERROR. An aggregator calls a silent node STALE.

PERIOD_S = 1.0

IRREGULAR = (SCENE, OBSERVATION, SLACK)
"""Topics that may be silent."""

OPTIONAL = (SCENE, OBSERVATION, SHIP_FIX, SLACK)
"""Topics that a graph on a live sensor may do without."""

RECENT_S = 10.0
"""Time for which /diagnostics has an error that has passed, or a counter that has risen [s]."""

LATE, LATE_PART = ('out_of_order', 'duplicated'), 20
"""Counters of late and repeated messages, of which one in so many is usual in a network."""

Finding = tuple[bytes, str]


def assess(node: GraphNode, now_s: float, recent: dict[str, int] | None = None) -> Finding:
    """Return the worst level and the reasons for it, at a steady time as of time.monotonic [s].

    `recent` has the increase of the counters in the last RECENT_S (default: since the start).
    """
    risen = {name: n for name, n in node.health().items() if n} if recent is None else recent
    found = list(_findings(node, now_s, risen))
    level = max((level for level, _ in found), default=DiagnosticStatus.OK)
    words = '; '.join(words for at, words in found if at == level)
    return level, words or ('finished' if node.input_over else 'under way')


def _findings(node: GraphNode, now_s: float, risen: dict[str, int]) -> Iterator[Finding]:
    error, warn = DiagnosticStatus.ERROR, DiagnosticStatus.WARN
    if node.failure is not None:
        yield error, f'failed: {node.failure}'
    if clash := [
        t for t, source in node.inputs.items() if source.incompatible and not source.matched
    ]:
        yield error, f'incompatible QoS on {", ".join(clash)}'
    if node.input_over:
        return
    if node.trouble:
        yield error, node.trouble
    alarmed_s, words = node.last_alarm
    if words and now_s - alarmed_s <= RECENT_S:
        yield error, words
    yield from _missing(node, now_s)
    for topic, source in node.inputs.items():
        if source.matched > 1 and not source.is_shared:
            yield warn, f'several publishers on {topic}: {node.sources_of(topic)}'
    for notice in node.notices:
        yield warn, notice
    if risen:
        counters = ', '.join(f'{name} {n}' for name, n in risen.items())
        yield warn, f'in the last {RECENT_S:g} s: {counters}'


def _missing(node: GraphNode, now_s: float) -> Iterator[Finding]:
    """Yield missing nodes, publishers and messages."""
    if node.waiting:
        yield DiagnosticStatus.WARN, f'waiting for {", ".join(node.waiting)}'
    lonely = [topic for topic, source in node.inputs.items() if not source.matched]
    if node.flow is None:
        # A recorder takes any topics, and a stage does not need the optional ones.
        needed = [t for t in lonely if t not in OPTIONAL and not node.inputs[t].is_shared]
        lonely = needed if node.outputs or len(lonely) == len(node.inputs) else []
    if lonely:
        yield DiagnosticStatus.WARN, f'no publisher on {", ".join(lonely)}'
    limit_s = node.settings['stale_after']
    if silent := [
        topic
        for topic, source in node.inputs.items()
        if topic not in IRREGULAR
        and not source.is_shared
        and source.matched
        and source.last_s is not None
        and now_s - source.last_s > limit_s
    ]:
        level = DiagnosticStatus.ERROR if node.outputs else DiagnosticStatus.WARN
        yield level, f'nothing for {limit_s:g} s on {", ".join(silent)}'


class Diagnostics:
    """Publishes a node's status once a second, and whenever it is asked to."""

    def __init__(self, node: GraphNode) -> None:
        self._node = node
        self._past: deque[tuple[float, dict[str, int]]] = deque()
        self._publisher = node.create_publisher(
            DiagnosticArray, '/diagnostics', QoSProfile(depth=10)
        )
        # Not guarded: a node that has failed in a foreign executor keeps reporting it.
        node.create_timer(PERIOD_S, self.publish, clock=node.steady)

    def publish(self) -> None:
        """Publish the status as it is now."""
        node, now_s = self._node, time.monotonic()
        health, inputs = node.health(), node.inputs.items()
        received = {f'{topic} received': source.received for topic, source in inputs}
        self._past.append((now_s, {**health, **received}))
        while len(self._past) > 1 and self._past[1][0] <= now_s - RECENT_S:
            self._past.popleft()
        at_s, before = self._past[0]
        elapsed_s = now_s - at_s
        # not yet that old: all that has been counted is recent
        counted = before if elapsed_s >= RECENT_S else {}
        late = max(1, sum(n - counted.get(k, 0) for k, n in received.items()) // LATE_PART)
        rises = {k: n - counted.get(k, 0) for k, n in health.items()}
        risen = {k: n for k, n in rises.items() if n > (late if k in LATE else 0)}
        level, message = assess(node, now_s, risen)
        values: dict[str, object] = {**received}
        for topic, source in inputs:
            if elapsed_s:
                came = source.received - before.get(f'{topic} received', 0)
                values[f'{topic} rate [Hz]'] = f'{came / elapsed_s:.4g}'
            if source.last_s is not None:
                values[f'{topic} age [s]'] = f'{now_s - source.last_s:.3g}'
        values |= {f'{topic} sent': port.sent for topic, port in node.outputs.items()}
        status = DiagnosticStatus(
            level=level,
            name=node.get_fully_qualified_name().lstrip('/'),
            hardware_id=str(node.settings.values.get('scene', '')),
            message=message,
            values=[KeyValue(key=k, value=str(n)) for k, n in {**values, **health}.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = node.get_clock().now().to_msg()
        self._publisher.publish(array)

    def deliver(self) -> None:
        """Wait a moment until the last status has reached its subscribers."""
        self._publisher.wait_for_all_acked(Duration(seconds=1))
