"""Flow control by credits, and messages in packs.

A consumer reports how many messages of each topic it has taken. A sender keeps at most WINDOW
messages of a topic in flight to its slowest consumer. The queues in between are deeper, and do not
overflow. docs/nodes.md explains why this neither loses messages nor deadlocks.
"""

from __future__ import annotations

import hmac
import json
import os
import struct
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, pairwise
from typing import Any

from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from std_msgs.msg import String, UInt8MultiArray

from tauto_core.bags import TOPICS
from tauto_nodes import NodesError
from tauto_nodes.live.node import (
    BATCH,
    MIN_DEPTH,
    GraphNode,
    Input,
    Output,
    TopicPort,
    type_name,
)

WINDOW = 800
"""Messages of one topic that may be in flight to a consumer."""

PACKED_TIMES = 10
"""Factor of window and batch for messages in packs: each costs little, and more of them share the
constant cost of a piece of work."""

RUN = 'TAUTO_RUN'
"""Environment variable: the key of a node's graph, which its processes alone know."""

HELLO_S = 0.1
"""Interval of the reports until all nodes of the graph are ready [s]."""

REPEAT_S = 1.0
"""Interval of later reports, if less than a batch is new [s]: a node lives. A window is four
batches, so unreported messages do not hold up the sender."""

LOST_AFTER_S = 10.0
"""Silence after the last reports after which missing messages count as lost [s]."""

CREDIT_TOPIC = '_tauto/credit'

CREDIT_QOS = QoSProfile(depth=100)
PACK_QOS = QoSProfile(depth=MIN_DEPTH * PACKED_TIMES)

# ----------------------------------------------------------------------------- The messages of the
# nodes of one graph to each other. Foreign nodes may publish on their topics, so each message has
# a mark that needs the graph's key (RUN). A message with another mark or form, or a repeated one,
# is a ForeignMessageError: it is counted and ignored.

MARK = 16
"""Bytes of a mark: the first ones of HMAC-SHA-256 (RFC 2104) over topic and content."""

MOST_TEXT = 65_536
"""Largest report that is read [bytes]. Ours have some 500."""

_TEXT = struct.Struct('<4sI')
_LITTLE_ENDIAN = b'\x00\x01\x00\x00'
_NO_MESSAGE = ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError


class ForeignMessageError(NodesError):
    """A message that is not of this graph."""


def mark(key: bytes, topic: str, content: bytes) -> bytes:
    """Return the mark of a message. Without a key every process can make it."""
    return hmac.digest(key or b'none', topic.encode() + b'\0' + content, 'sha256')[:MARK]


def _counts(content: Any) -> dict[str, int]:
    """Return the number of messages by topic. ValueError: they are not counts."""
    counts = {str(topic): n for topic, n in content.items()}
    if not all(type(n) is int and 0 <= n < 2**63 for n in counts.values()):
        raise ValueError
    return counts


@dataclass(frozen=True)
class Report:
    """The report of a node on `_tauto/credit`. The latest one replaces all earlier ones.

    It has the messages `taken` so far of each subscribed topic, the topics with a publisher
    (`matched`), whether its publishers have all their subscribers (`ready`), and, once the node
    has sent everything, the messages `sent` of each topic. The `number` rises from report to
    report of a node.
    """

    node: str
    taken: dict[str, int]
    matched: tuple[str, ...] = ()
    ready: bool = False
    number: int = field(default=0, compare=False)
    sent: dict[str, int] = field(default_factory=dict)

    def to_octets(self, key: bytes) -> bytes:
        """Return the serialised message (CDR of std_msgs/String): JSON and the graph's mark."""
        text = json.dumps(vars(self)).encode()
        text += b' ' + mark(key, CREDIT_TOPIC, text).hex().encode()
        return _TEXT.pack(_LITTLE_ENDIAN, len(text) + 1) + text + b'\x00'

    @staticmethod
    def from_octets(octets: bytes, key: bytes) -> Report:
        """Return the report in a serialised message.

        ForeignMessageError: it is not of this graph, or counts what another node sends.
        """
        text, _, end = octets[_TEXT.size : MOST_TEXT].partition(b'\x00')[0].rpartition(b' ')
        if not hmac.compare_digest(end, mark(key, CREDIT_TOPIC, text).hex().encode()):
            raise ForeignMessageError(f'{text[:80]!r} is not of this graph')
        try:
            content = json.loads(text)
            node, sent = str(content['node']), _counts(content['sent'])
            if not all(TOPICS[topic].node == node for topic in sent):
                raise ValueError
            return Report(
                node,
                _counts(content['taken']),
                tuple(map(str, content['matched'])),
                bool(content['ready']),
                int(content['number']),
                sent,
            )
        except _NO_MESSAGE:
            raise ForeignMessageError(f'{octets[8:88]!r} is no credit report') from None


# -----------------------------------------------------------------------------
# Packs: many messages in one, between the nodes of our own graph. The overhead is paid once.
#
# A pack is a std_msgs/UInt8MultiArray. Its data are its mark and, little-endian, how many messages
# of the topic came before it (uint64), the number of messages and their lengths (uint32), then the
# messages, with their exact lengths: DDS does not pad them.

PACK_TOPIC = '_tauto/pack/'
"""Prefix of the name of a packed topic."""

MOST_BYTES = 60_000
"""Largest size of a pack of more than one message: it fits into a UDP datagram."""

# CDR: encapsulation, no dimensions, no offset, length of the data.
_HEAD = struct.Struct('<4sIII')


def pack(key: bytes, topic: str, payloads: Sequence[bytes], sent: int = 0) -> Iterator[bytes]:
    """Yield the serialised packs of a topic's messages, after `sent` earlier ones."""
    first = size = 0
    for last, payload in enumerate(payloads):
        if size and size + len(payload) > MOST_BYTES:
            yield _packed(key, topic, payloads[first:last], sent + first)
            first, size = last, 0
        size += len(payload)
    if payloads:
        yield _packed(key, topic, payloads[first:], sent + first)


def _packed(key: bytes, topic: str, payloads: Sequence[bytes], sent: int) -> bytes:
    n = len(payloads)
    lengths = struct.pack(f'<Q{n + 1}I', sent, n, *map(len, payloads))
    data = b''.join([lengths, *payloads])
    head = _HEAD.pack(_LITTLE_ENDIAN, 0, 0, MARK + len(data))
    return head + mark(key, topic, data) + data


def unpack(key: bytes, topic: str, octets: bytes) -> tuple[int, list[bytes]]:
    """Return the number of messages before a serialised pack, and its messages.

    ForeignMessageError: the pack is not of this graph.
    """
    try:
        size = _HEAD.unpack_from(octets)[3]
        data = octets[_HEAD.size + MARK : _HEAD.size + size]
        if not hmac.compare_digest(octets[_HEAD.size :][:MARK], mark(key, topic, data)):
            raise ValueError
        sent, n = struct.unpack_from('<QI', data)
        lengths = struct.unpack_from(f'<{n}I', data, 12)
        places = list(accumulate(lengths, initial=12 + 4 * n))
        if places[-1] != len(data):
            raise ValueError
    except (struct.error, ValueError):
        raise ForeignMessageError(f'{octets[:40]!r} is no pack of this graph') from None
    return sent, [data[begin:end] for begin, end in pairwise(places)]


# -----------------------------------------------------------------------------
# The part of one node.


def can_match(offered: QoSProfile, requested: QoSProfile) -> bool:
    """Return whether a subscription that asks for `requested` can match one of our publishers.

    Ours offer no deadline and no liveliness lease. rclpy's own check takes the infinite times
    that a discovered subscription reports for finite ones.
    """
    return (
        (
            offered.reliability == QoSReliabilityPolicy.RELIABLE
            or requested.reliability != QoSReliabilityPolicy.RELIABLE
        )
        and (
            offered.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL
            or requested.durability != QoSDurabilityPolicy.TRANSIENT_LOCAL
        )
        and requested.deadline.nanoseconds in (0, 2**63 - 1)
        and requested.liveliness_lease_duration.nanoseconds
        in (0, 2**63 - 1)  # rmw reports the second
    )


@dataclass
class Packer(Output):
    """State of a publisher that sends packs to the graph, on the topic of a `carrier`.

    The topic itself carries single messages for its `watchers`, the number of foreign subscribers.
    `matched` counts the subscribers within the graph of a `key`.
    """

    port: Any = None
    carrier: Any = None
    key: bytes = b''
    watchers: int = 0

    @property
    def watched(self) -> bool:
        """Whether somebody takes single messages."""
        return bool(self.watchers)

    def look(self) -> None:
        """Count the subscribers of both topics."""
        self.matched = self.carrier.get_subscription_count()
        self.watchers = self.publisher.get_subscription_count()

    def publish(self, payloads: Sequence[bytes]) -> None:
        """Send messages in packs, and singly to foreign subscribers."""
        for octets in pack(self.key, self.port.name, payloads, self.sent):
            self.carrier.publish(octets)
        if self.watchers or self.port.is_latched:
            super().publish(payloads)
        else:
            self.sent += len(payloads)


class Credits:
    """The part of a node, its `owner`, in the flow control of its graph.

    The parameter `graph` names all nodes, the owner included. Messages of anybody else are counted
    and ignored. `totals` has the messages of each topic that senders say they have sent,
    `heard_s` the time when each node was last heard, `moved_s` the time when a report last
    differed from the one before, both by `time.monotonic()` [s].
    """

    turns_s = HELLO_S
    """Interval at which the node takes its turn without messages [s]."""

    def __init__(self, owner: GraphNode, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        self._owner, self._inputs, self._outputs = owner, inputs, outputs
        self._name, self._graph = owner.get_name(), owner.settings['graph']
        if self._name not in self._graph or len(set(self._graph)) != len(self._graph):
            raise NodesError(
                f'graph = {list(self._graph)}: must name every node of the graph once, '
                f'{self._name} among them'
            )
        self._key = os.environ.get(RUN, '').encode()
        self._packs = owner.settings.packed
        times = PACKED_TIMES if self._packs else 1
        self._window, self.batch = WINDOW * times, BATCH * times
        self._reports: dict[str, Report] = {}
        self.totals: dict[str, int] = {}
        self.heard_s: dict[str, float] = {}
        self.moved_s = time.monotonic()
        self._totals_s: float | None = None
        self._reported_s = 0.0
        self._reported: Report | None = None
        self._credit = owner.create_publisher(String, CREDIT_TOPIC, CREDIT_QOS)
        hear = self._heard(CREDIT_TOPIC, self._hear)
        owner.create_subscription(String, CREDIT_TOPIC, hear, CREDIT_QOS, raw=True)

    def output(self, port: TopicPort, publisher: Any) -> Output:
        """Return the state of a publisher, with packs if the graph has them."""
        if not self._packs:
            return Output(publisher)
        carrier = self._owner.create_publisher(UInt8MultiArray, PACK_TOPIC + port.name, PACK_QOS)
        return Packer(publisher, port=port, carrier=carrier, key=self._key)

    def listen_to(self, port: TopicPort, source: Input) -> bool:
        """Subscribe to the packs of a topic. Return whether the graph has packs."""
        if self._packs:
            name, come = PACK_TOPIC + port.name, 0

            def take(octets: bytes) -> None:
                nonlocal come
                sent, payloads = unpack(self._key, port.name, octets)
                if sent < come:
                    raise ForeignMessageError('a pack comes again')
                come = sent + len(payloads)
                self._owner.received(source, payloads)

            source.is_signed = bool(self._key)
            source.subscription = self._owner.create_subscription(
                UInt8MultiArray, name, self._heard(name, take), PACK_QOS, raw=True
            )
        return self._packs

    def allowed(self, topic: str, output: Output) -> int:
        """Return how many of the waiting messages of a topic its slowest consumer allows."""
        taken = [report.taken[topic] for report in self._reports.values() if topic in report.taken]
        in_flight = output.sent - min(taken, default=output.sent)
        return min(len(output.queue), self._window - in_flight)

    def everyone_ready(self) -> bool:
        """Return whether all nodes of the graph have said so."""
        reports = self._reports
        return len(reports) == len(self._graph) and all(one.ready for one in reports.values())

    def turn(self) -> None:
        """Close the input when all has come, and report."""
        if self._owner.inputs and not self._owner.input_over:
            self._close_input()
        self.report()

    def report(self) -> None:
        """Report the taken messages if they are new or the report is due."""
        now, owner = time.monotonic(), self._owner
        due_s = REPEAT_S
        if not self.everyone_ready():
            due_s = HELLO_S
            owner.waiting = self._waiting()
        matched = tuple(topic for topic, source in owner.inputs.items() if source.matched > 0)
        taken = {topic: source.taken for topic, source in owner.inputs.items()}
        is_over = owner.input_over and not owner.backlogged
        sent = {topic: output.sent for topic, output in owner.outputs.items() if is_over}
        number = 1 + (self._reported.number if self._reported is not None else 0)
        report = Report(self._name, taken, matched, not owner.waiting, number, sent)
        # A report costs every node time: before it is due it must be news to them.
        since_s, last = now - self._reported_s, self._reported
        said = matched, report.ready, sent
        is_news = last is None or said != (last.matched, last.ready, last.sent)
        if last is not None and not is_news:
            fresh = [n - last.taken[topic] for topic, n in taken.items()]
            is_news = max(fresh, default=0) >= self.batch
        if since_s >= due_s or is_news:
            self._credit.publish(report.to_octets(self._key))
            self._note(report)
            self._reported, self._reported_s = report, now

    def _note(self, report: Report) -> None:
        self.heard_s[report.node] = time.monotonic()
        if self._reports.get(report.node) != report:
            self.moved_s = self.heard_s[report.node]
        self._reports[report.node] = report

    def _heard(self, topic: str, take: Callable[[bytes], None]) -> Callable[[bytes], None]:
        """Return the callback of a topic of the graph. It counts foreign messages."""

        def hear(octets: bytes) -> None:
            try:
                take(octets)
            except ForeignMessageError as error:
                self._owner.leave_aside(topic, 'not_of_this_graph', str(error))

        return self._owner.guard(hear)

    def _hear(self, octets: bytes) -> None:
        report, owner = Report.from_octets(octets, self._key), self._owner
        if report.node not in self._graph or report.node == self._name:
            return
        last = self._reports.get(report.node)
        if last is not None and report.number <= last.number:
            raise ForeignMessageError('a report comes again')
        self._note(report)
        self.totals.update(report.sent)
        for topic in owner.outputs:
            owner.pump(topic)
        if not owner.backlogged:
            owner.tick()
        if report.sent or any(source.pending for source in owner.inputs.values()):
            owner.hurry()

    def _waiting(self) -> list[str]:
        """Return the nodes and subscriptions that must come before anything may be sent."""
        if absent := [name for name in self._graph if name not in self._reports]:
            return [f'node {name}' for name in absent]
        return [
            f'subscription of {name} to {topic}'
            for topic in self._outputs
            for name, report in self._reports.items()
            if topic in report.taken
            and (name not in self._matched(topic) or topic not in report.matched)
        ]

    def _matched(self, topic: str) -> set[str]:
        """Return the names of the nodes of this namespace with matched subscriptions."""
        output, owner = self._owner.outputs[topic], self._owner
        publisher = output.carrier if isinstance(output, Packer) else output.publisher
        heard = [
            info
            for info in owner.get_subscriptions_info_by_topic(publisher.topic_name)
            if can_match(publisher.qos_profile, info.qos_profile)
            and info.topic_type == type_name(publisher.msg_type)
        ]
        # A matched publisher counts its readers but does not name them.
        if publisher.get_subscription_count() < len(heard):
            return set()
        here = owner.get_namespace()
        return {info.node_name for info in heard if info.node_namespace == here}

    def _close_input(self) -> None:
        """End when all that was sent has come, or when the rest will not come any more."""
        inputs, now_s = self._owner.inputs, time.monotonic()
        if self._owner.backlogged or any(topic not in self.totals for topic in self._inputs):
            return
        self._totals_s = self._totals_s or now_s
        missing = {t: self.totals[t] - inputs[t].received for t in self._inputs}
        if short := {topic: n for topic, n in missing.items() if n > 0}:
            last_s = max(source.last_s or self._totals_s for source in inputs.values())
            if now_s - max(last_s, self._totals_s) < LOST_AFTER_S:
                return
            self._owner.lost(short)
        self._owner.end_input()
