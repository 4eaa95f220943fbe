"""The base of all nodes: ports, messages in and out, flow control, an end, and diagnostics."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, ParamSpec

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_policy_name_from_kind
from rclpy.qos_overriding_options import InvalidQosOverridesError
from std_msgs.msg import String, UInt8MultiArray

from tauto_core.samples import OBSERVATION, SCENE, SHIP_FIX, SLACK, Samples
from tauto_core.scene.times import NS_PER_S
from tauto_nodes import NodesError, ParameterError
from tauto_nodes.flow import (
    BATCH,
    CREDIT_TOPIC,
    END_TOPIC,
    PACK_TOPIC,
    PACKED_TIMES,
    RUN,
    WINDOW,
    End,
    Flow,
    Report,
    unpack,
)
from tauto_nodes.parameters import declare, take_raw
from tauto_nodes.ports import (
    CREDIT_QOS,
    END_QOS,
    PACK_QOS,
    Input,
    Intake,
    Output,
    Times,
    TopicPort,
    can_match,
    node_of,
    overriding,
    refuse_unknown_qos,
    type_name,
)

P = ParamSpec('P')

TICK_S = 0.01
"""Interval at which a node of a graph with flow control, or one that paces time, works [s]. Others
work so long after a message has come, and if they are calm, CALM_S after it."""

CALM_S = 0.1

LOOK_S = 0.3
"""Interval at which they look after their ports and what else is due [s]: most of what an idle
node costs is to wake up."""

HELLO_S = 0.05
"""Interval of the reports until all nodes of the graph are ready [s]."""

SOON_S = 0.1
"""Fewer messages than a batch are reported as taken after this time [s]."""

REPEAT_S = 1.0
"""Interval of the reports from then on, if nothing is new [s]: they say that a node lives."""

LOST_AFTER_S = 10.0
"""Silence after the end markers that makes what is still missing count as lost [s]."""

COMMON_DEPTH = 10
"""Messages that the queue of a subscriber usually holds."""

ALARM_S = 10.0
"""Time for which /diagnostics still reports an error that has passed [s]."""


class GraphNode(Node):
    """Base of the nodes. Subclasses override `take`, `at_end`, `tick`, `close`, `health`.

    `role` says which node of the table in parameters.py this is; it is also its default name.
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
        times = PACKED_TIMES if self.settings.packed else 1
        self._window, self._batch = WINDOW * times, BATCH * times
        self._run = int(os.environ.get(RUN) or 0)
        self._met = False
        self.inputs: dict[str, Input] = {}
        self.outputs: dict[str, Output] = {}
        self.times: dict[str, list[Times]] = {}
        self.flow: Flow | None = None
        self.diagnostics: Diagnostics | None = None
        self.failure: Exception | None = None
        self.over = False
        self.exit_code = 0
        self.input_over = False
        self.waiting: list[str] = []
        """What the outputs wait for before anything may be sent."""
        self._soon: Any = None
        self._ended = False
        self._totals_s: float | None = None
        self._reported_s = 0.0
        self._reported: Report | None = None
        self._intakes: dict[str, Intake] = {}
        self._left_aside: dict[str, int] = {}
        self._alarm: tuple[float, str] | None = None

    # What a subclass says.

    def take(self, payloads: Mapping[str, Sequence[bytes]]) -> None:
        """Take messages that have arrived, by topic."""

    def at_end(self) -> None:
        """Publish what is still held back, since no more input will come."""

    def lost(self, short: Mapping[str, int]) -> None:
        """Act on messages that were sent and will not come, by topic: their number.

        NodesError: what the node would publish from now on is not what the scene says.
        """
        raise NodesError(f'messages were lost on the way: {dict(short)}. Start the voyage again')

    def tick(self) -> None:
        """Do what is due; called at each tick of the steady clock and when credits come."""

    def close(self) -> None:
        """Leave the graph cleanly; the context is still alive."""

    def health(self) -> dict[str, int]:
        """Return counters of what was refused or bridged."""
        ports: list[tuple[str, Input | Output]] = [*self.inputs.items(), *self.outputs.items()]
        clashes = {f'{topic} incompatible_qos': p.incompatible for topic, p in ports}
        return {**self._left_aside, **{name: n for name, n in clashes.items() if n}}

    def lingers(self) -> bool:
        """Whether the node, after a request to stop, waits for messages of others."""
        return False

    @property
    def trouble(self) -> str:
        """What keeps the node from working at present; empty if nothing does."""
        return '; '.join(intake.trouble for intake in self._intakes.values() if intake.trouble)

    @property
    def notices(self) -> list[str]:
        """What the node works without at present, with the remedies."""
        return []

    # What it notices.

    def intake(self, topic: str) -> Intake:
        """Return the decoder of the messages of a topic."""
        if topic not in self._intakes:
            self._intakes[topic] = Intake(topic, partial(self.note, topic))
        return self._intakes[topic]

    def decoded(self, topic: str, raw: Sequence[bytes]) -> tuple[Samples | None, list[bytes]]:
        """Return the samples of the usable messages, and these; others do not end a silence."""
        samples, good = self.intake(topic).samples(raw)
        if samples is not None:
            self.inputs[topic].last_s = time.monotonic()
        return samples, good

    def note(self, topic: str, reason: str, words: str) -> None:
        """Count what is wrong with a message; name the first one of a kind in the log.

        A message of our own graph, which must not lose any, raises NodesError.
        """
        if self.flow is not None:
            raise NodesError(f'{topic}: {reason}: {words}')
        key = f'{topic} {reason}'
        self._left_aside[key] = self._left_aside.get(key, 0) + 1
        if self._left_aside[key] == 1:
            self.get_logger().warning(f'{topic}: {words} (counted as {reason})')

    def twins(self) -> list[str]:
        """Return the nodes that are named like this one, itself included."""
        own = self.get_fully_qualified_name()
        others = self.get_node_names_and_namespaces()
        full = [f'{place.rstrip("/")}/{name}' for name, place in others]
        return [name for name in full if name == own]

    def alarm(self, words: str) -> None:
        """Report an error in /diagnostics for a while."""
        self._alarm = time.monotonic(), words

    def recent_alarm(self, now_s: float) -> str:
        """Return what was last alarming, for `ALARM_S` after it; empty where nothing is."""
        if self._alarm is None or now_s - self._alarm[0] > ALARM_S:
            return ''
        return self._alarm[1]

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
        """Give up: nothing is taken or sent any more; /rosout and /diagnostics get the reason."""
        if self.failure is None:
            self.failure = error
            self.get_logger().fatal(f'{type(error).__name__}: {error}')
            if self.diagnostics is not None:
                self.diagnostics.publish()

    # Ports.

    def connect(self, inputs: Sequence[TopicPort], outputs: Sequence[TopicPort]) -> None:
        """Create the ports and begin to tick.

        NodesError: the graph's names do not hold the node. ParameterError: QoS overrides that do
        not go with flow control, or of no port.
        """
        if self.settings.credits:
            topics = tuple(p.name for p in inputs), tuple(p.name for p in outputs)
            self.flow = Flow(self.get_name(), self.settings.names('graph'), *topics, self._run)
        try:
            for port in outputs:
                self._publish_on(port)
            for port in inputs:
                self.listen_to(port)
        except InvalidQosOverridesError as error:
            raise ParameterError(f'{self.get_fully_qualified_name()}: {error}') from error
        refuse_unknown_qos(self)
        if self.flow is not None:
            self._credit = self.create_publisher(String, CREDIT_TOPIC, CREDIT_QOS)
            self._end = self.create_publisher(String, END_TOPIC, END_QOS)
            hear, flow = self.guard(self._hear), self.flow
            hear_end = self.guard(lambda message: flow.hear_end(End.from_json(message.data)))
            self.create_subscription(String, CREDIT_TOPIC, hear, CREDIT_QOS, raw=True)
            self.create_subscription(String, END_TOPIC, hear_end, END_QOS)
        is_driven = self.flow is None and not self.paces
        every_s = LOOK_S if is_driven else TICK_S
        self.create_timer(every_s, self.guard(self._tick), clock=self.steady)
        if is_driven:
            soon_s = CALM_S if self.is_calm else TICK_S
            self._soon = self.create_timer(soon_s, self.guard(self._hurry), clock=self.steady)
            self._soon.cancel()

    def _publish_on(self, port: TopicPort) -> None:
        def offers_too_little(info: Any) -> None:
            output.incompatible = info.total_count
            self.get_logger().warning(
                f'{port.name}: a subscriber asks for more than this node offers '
                f'({qos_policy_name_from_kind(info.last_policy_kind)}) and gets nothing'
            )

        publisher = self.create_publisher(
            port.message,
            port.name,
            port.profile,
            event_callbacks=PublisherEventCallbacks(incompatible_qos=offers_too_little),
            qos_overriding_options=overriding(self.settings.credits),
        )
        output = self.outputs[port.name] = Output(publisher, is_latched=port.is_latched)
        if self.settings.packed:
            name = PACK_TOPIC + port.name
            output.carrier = self.create_publisher(UInt8MultiArray, name, PACK_QOS)
            output.run = self._run

    def listen_to(self, port: TopicPort, *, is_shared: bool = False) -> Any:
        """Create a subscription with its state in `inputs`; return it."""
        message = UInt8MultiArray if self.settings.packed else port.message
        source = self.inputs[port.name] = Input(type_name(message), is_shared)
        if self.settings.packed:
            source.subscription = self.create_subscription(
                UInt8MultiArray,
                PACK_TOPIC + port.name,
                self.guard(
                    lambda octets: self.received(source, unpack(port.name, octets, self._run))
                ),
                PACK_QOS,
                raw=True,
            )
            return source.subscription
        drains = self.settings.text('executor') == 'single'

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

        def take_alone(payload: bytes) -> None:
            take(payload)  # the events executor fails where a callback asks for more (7.1.6)

        def asks_too_much(info: Any) -> None:
            source.incompatible = info.total_count
            self.get_logger().error(
                f"{port.name}: a publisher's quality of service does not match; "
                'set qos_overrides or imu_reliability'
            )

        source.subscription = self.create_subscription(
            port.message,
            port.name,
            self.guard(take if drains and self.keeps_times else take_alone),
            port.profile,
            raw=True,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=asks_too_much),
            qos_overriding_options=overriding(self.settings.credits),
        )
        return source.subscription

    def link_name(self, topic: str) -> str:
        """Return the full name of the topic that carries a topic's messages to the graph."""
        return self.resolve_topic_name(PACK_TOPIC + topic if self.settings.packed else topic)

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
                # packs tell which graph they are of
                if count > 1 and not (source.is_shared or (self._run and self.settings.packed)):
                    self._several_sources(topic)
        for output in self.outputs.values():
            output.matched = output.link.get_subscription_count()
            if output.carrier is not None:
                output.watchers = output.publisher.get_subscription_count()

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
        else:
            self.fail(
                NodesError(
                    f'{words}; with flow_control = credits a topic has one source only. Stop the '
                    'other, or give the graph a namespace or a ROS_DOMAIN_ID of its own'
                )
            )

    # In.

    def received(self, source: Input, payloads: list[bytes]) -> None:
        """Keep the messages; process them if there are many."""
        if self.input_over:
            return
        source.received += len(payloads)
        source.pending += payloads
        if self._soon is not None and self._soon.is_canceled():
            self._soon.reset()
        if len(source.pending) >= self._batch and not self.backlogged:
            self._work()
            if self.flow is not None:
                self._report()

    def _hurry(self) -> None:
        self._soon.cancel()
        self.tick()
        self._work()

    def _work(self) -> None:
        # While its own output waits, a node takes nothing: that is what holds its sources back.
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
        output = self.outputs[topic]
        output.queue.extend(payloads)
        self._pump(topic, output)

    def _pump(self, topic: str, output: Output) -> None:
        count = len(output.queue)
        if self.flow is not None and count:
            count = min(count, self._window - self.flow.in_flight(topic, output.sent))
        if count > 0:
            output.publish([output.queue.popleft() for _ in range(count)])
        if count > COMMON_DEPTH and output.carrier is not None and output.watchers:
            self._name_watchers(topic, output, count)

    def _name_watchers(self, topic: str, output: Output, count: int) -> None:
        """Say, once for each, who beside the graph may lose messages: they are in no account."""
        infos = self.get_subscriptions_info_by_topic(output.publisher.topic_name)
        for name in sorted({node_of(info) for info in infos} - output.named):
            output.named.add(name)
            self.get_logger().warning(
                f'{topic}: {name} is not of the graph and gets {count} messages at once; what '
                'does not fit into its queue is lost, and nobody counts it. Give it a deeper one, '
                'or let the voyage sail at a pace (speed 60)'
            )

    # Flow control.

    def _hear(self, octets: bytes) -> None:
        assert self.flow is not None
        report = Report.from_octets(octets)
        if report.run != self._run:
            self._meet(report)
            return
        if report.node == self.flow.node:
            return
        self.flow.hear(report)
        for topic, output in self.outputs.items():
            self._pump(topic, output)
        if not self.backlogged:
            self.tick()

    def _meet(self, other: Report) -> None:
        """Let the earlier graph go on, and end the later one with a NodesError."""
        if 0 < other.run < self._run:
            since = time.strftime('%Y-%m-%d %H:%M:%S', time.localtime(other.run // NS_PER_S))
            raise NodesError(
                f'another graph of the namespace {self.get_namespace()} sails in this domain '
                f'since {since}, and it goes on. Wait for its end, or give this one a namespace '
                'or a ROS_DOMAIN_ID of its own'
            )
        self._reported = None  # so that it hears of us at once
        if not self._met:
            self.get_logger().warning('a second graph starts in this namespace; it is ignored')
        self._met = True

    def strangers(self) -> list[str]:
        """Return who else publishes on the outputs of a graph that takes nothing from them."""
        if not (self._run and self.settings.packed):
            return []
        own = self.get_fully_qualified_name()
        return [
            f'{name} publishes {topic}, too; the graph ignores it'
            for topic, output in self.outputs.items()
            for info in self.get_publishers_info_by_topic(output.publisher.topic_name)
            if (name := node_of(info)) != own
        ]

    def _found(self, topic: str) -> set[str]:
        """Return the names of the nodes of this namespace whose subscriptions are matched."""
        publisher = self.outputs[topic].link
        heard = [
            info
            for info in self.get_subscriptions_info_by_topic(publisher.topic_name)
            if can_match(publisher.qos_profile, info.qos_profile)
            and info.topic_type == type_name(publisher.msg_type)
        ]
        # A matched publisher counts its readers but does not name them: all of them, or none.
        if publisher.get_subscription_count() < len(heard):
            return set()
        here = self.get_namespace()
        return {info.node_name for info in heard if info.node_namespace == here}

    def _report(self) -> None:
        assert self.flow is not None
        now = time.monotonic()
        due_s = REPEAT_S
        if not self.flow.everyone_ready():
            due_s = HELLO_S
            self.waiting = self.flow.waiting({topic: self._found(topic) for topic in self.outputs})
        matched = tuple(topic for topic, source in self.inputs.items() if source.matched > 0)
        taken = {topic: source.taken for topic, source in self.inputs.items()}
        report = Report(self.flow.node, taken, matched, not self.waiting, self._run)
        # A report costs every node time: before it is due it must be news to them.
        since_s, last = now - self._reported_s, self._reported
        is_news = last is None or (matched, report.ready) != (last.matched, last.ready)
        if last is not None and not is_news:
            fresh = [n - last.taken[topic] for topic, n in taken.items()]
            is_news = max(fresh, default=0) >= self._batch or (any(fresh) and since_s >= SOON_S)
        if since_s >= due_s or is_news:
            self._credit.publish(report.to_octets())
            self.flow.hear(report)
            self._reported, self._reported_s = report, now

    def _close_input(self) -> None:
        """End when all that was sent has come, or when the rest will not come any more."""
        assert self.flow is not None
        short = self.flow.short({t: source.received for t, source in self.inputs.items()})
        if short is None or self.backlogged:
            return
        if self._totals_s is None:
            self._totals_s = time.monotonic()
        if short:
            last_s = max(source.last_s or self._totals_s for source in self.inputs.values())
            if time.monotonic() - max(last_s, self._totals_s) < LOST_AFTER_S:
                return
            self.lost(short)
        self.end_input()

    def end_input(self) -> None:
        """Process what is pending and publish what is held back; later input is ignored."""
        if not self.input_over:
            self._work()
            self.input_over = True
            self.at_end()

    def _tick(self) -> None:
        self.look_at_links()
        self.tick()
        # Waiting messages are sent before new work, which a node with a backlog does not take.
        for topic, output in self.outputs.items():
            self._pump(topic, output)
        self._work()
        if self.flow is None:
            return
        if self.inputs and not self.input_over:
            self._close_input()
        if self.outputs and self.input_over and not self.backlogged and not self._ended:
            self._ended = True
            sent = {topic: output.sent for topic, output in self.outputs.items()}
            self._end.publish(String(data=End(self.get_name(), sent, self._run).to_json()))
        self._report()


# -----------------------------------------------------------------------------
# /diagnostics: one status a second from each node, named with its namespace.
#
# A node publishes OK, WARN and ERROR; STALE is what an aggregator says of a node that is silent.

PERIOD_S = 1.0

IRREGULAR = (SCENE, OBSERVATION, SLACK)
"""Topics whose silence means nothing."""

OPTIONAL = (SCENE, OBSERVATION, SHIP_FIX, SLACK)
"""Topics that a graph on a live sensor may do without."""

RECENT_S = 10.0
"""Time after a counter has risen during which it causes a warning [s]."""

Finding = tuple[bytes, str]


def assess(node: GraphNode, now_s: float, recent: dict[str, int] | None = None) -> Finding:
    """Return the worst level and the reasons for it, at a steady time as of time.monotonic [s].

    `recent` has the increase of the counters in the last RECENT_S; None: since the start.
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
    if passed := node.recent_alarm(now_s):
        yield error, passed
    yield from _missing(node, now_s)
    for stranger in node.strangers():
        yield warn, stranger
    for topic, source in node.inputs.items():
        if source.matched > 1 and not source.is_shared:
            yield warn, f'several publishers on {topic}: {", ".join(node.sources_of(topic))}'
    if len(twins := node.twins()) > 1:
        yield warn, f'{len(twins)} nodes are named {twins[0]}'
    for notice in node.notices:
        yield warn, notice
    if risen:
        counters = ', '.join(f'{name} {n}' for name, n in risen.items())
        yield warn, f'in the last {RECENT_S:g} s: {counters}'


def _missing(node: GraphNode, now_s: float) -> Iterator[Finding]:
    """Yield what is missing: nodes, publishers, messages."""
    if node.waiting:
        yield DiagnosticStatus.WARN, f'waiting for {", ".join(node.waiting)}'
    lonely = [topic for topic, source in node.inputs.items() if not source.matched]
    if node.flow is None:
        # A recorder takes what there is; a stage can do without what is optional.
        needed = [t for t in lonely if t not in OPTIONAL and not node.inputs[t].is_shared]
        lonely = needed if node.outputs or len(lonely) == len(node.inputs) else []
    misfits = {topic: node.misfits(topic) for topic in lonely}
    if unsent := [topic for topic, others in misfits.items() if not others]:
        yield DiagnosticStatus.WARN, f'no publisher on {", ".join(unsent)}'
    for topic, others in misfits.items():
        if others:
            wanted = node.inputs[topic].type_name
            yield (
                DiagnosticStatus.WARN,
                f'no publisher of {wanted} on {topic}: {", ".join(others)}. Let one send {wanted}',
            )
    limit_s = node.settings.number('stale_after')
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
        health = node.health()
        self._past.append((now_s, health))
        while len(self._past) > 1 and self._past[1][0] <= now_s - RECENT_S:
            self._past.popleft()
        at_s, before = self._past[0]
        if now_s - at_s < RECENT_S:
            before = {}  # not yet that old: all that has been counted is recent
        risen = {k: n - before.get(k, 0) for k, n in health.items() if n > before.get(k, 0)}
        level, message = assess(node, now_s, risen)
        counts = {f'{topic} received': port.received for topic, port in node.inputs.items()}
        counts |= {f'{topic} sent': port.sent for topic, port in node.outputs.items()}
        status = DiagnosticStatus(
            level=level,
            name=node.get_fully_qualified_name().lstrip('/'),
            hardware_id=str(node.settings.values.get('scene', '')),
            message=message,
            values=[KeyValue(key=k, value=str(n)) for k, n in {**counts, **health}.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = node.get_clock().now().to_msg()
        self._publisher.publish(array)

    def deliver(self) -> None:
        """Wait, for a moment, until the last status has reached who subscribes to it."""
        self._publisher.wait_for_all_acked(Duration(seconds=1))
