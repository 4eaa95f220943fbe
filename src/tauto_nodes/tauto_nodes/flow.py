"""Flow control by credits, and messages in packs; without ROS.

A consumer reports how many messages of each topic it has taken. A sender keeps at most WINDOW
messages of a topic in flight to its slowest consumer; the queues in between are deeper, so none
overflows. docs/nodes.md explains why this neither loses messages nor deadlocks.
"""

from __future__ import annotations

import json
import struct
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from tauto_nodes import NodesError

WINDOW = 800
"""Messages of one topic that may be in flight to a consumer."""

BATCH = 200
"""Messages after which a consumer works and reports without waiting for its tick."""

PACKED_TIMES = 10
"""Factor of window and batch where messages go in packs: a message costs little then, and the
constant cost of a piece of work is shared by more messages."""

RUN = 'TAUTO_RUN'
"""Environment variable: when a node's graph began [ns], which distinguishes two graphs."""

CREDIT_TOPIC = '_tauto/credit'
END_TOPIC = '_tauto/end'

_TEXT = struct.Struct('<4sI')
_LITTLE_ENDIAN = b'\x00\x01\x00\x00'


@dataclass(frozen=True)
class Report:
    """The report of a node on `_tauto/credit`; the latest one replaces all earlier ones.

    It has the messages `taken` so far of each topic that the node subscribes to, which of these
    have found a publisher (`matched`), and whether its publishers have found all their
    subscribers (`ready`). `run` is that of its graph (RUN); 0: its nodes were started one by one.
    """

    node: str
    taken: dict[str, int]
    matched: tuple[str, ...] = ()
    ready: bool = False
    run: int = 0

    def to_json(self) -> str:
        """Return the message's text."""
        return json.dumps(vars(self))

    def to_octets(self) -> bytes:
        """Return the serialised message (CDR of std_msgs/String)."""
        text = self.to_json().encode()
        return _TEXT.pack(_LITTLE_ENDIAN, len(text) + 1) + text + b'\x00'

    @staticmethod
    def from_octets(octets: bytes) -> Report:
        """Return the report in a serialised message; NodesError if it has none."""
        return Report.from_json(octets[_TEXT.size :].partition(b'\x00')[0])

    @staticmethod
    def from_json(text: str | bytes) -> Report:
        """Return the report in a message's text; NodesError if it is not a report."""
        try:
            content = json.loads(text)
            return Report(
                str(content['node']),
                {str(topic): int(n) for topic, n in content['taken'].items()},
                tuple(content['matched']),
                bool(content['ready']),
                int(content.get('run', 0)),
            )
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise NodesError(f'{CREDIT_TOPIC}: not a credit report: {text[:80]!r}') from error


@dataclass(frozen=True)
class End:
    """The end marker of a node on `_tauto/end`: how many messages of each topic it has sent."""

    node: str
    sent: dict[str, int]
    run: int = 0

    def to_json(self) -> str:
        """Return the message's text."""
        return json.dumps(vars(self))

    @staticmethod
    def from_json(text: str) -> End:
        """Return the end marker in a message; NodesError if it has none."""
        try:
            content = json.loads(text)
            sent = {str(topic): int(n) for topic, n in content['sent'].items()}
            return End(str(content['node']), sent, int(content.get('run', 0)))
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise NodesError(f'{END_TOPIC}: not an end marker: {text[:80]!r}') from error


@dataclass
class Flow:
    """One node's view of the graph, which names all nodes, its own included, and its topics.

    Messages from the nodes of another `run` are ignored.

    `heard_s` has the time when each node was last heard, `moved_s` the time when a report last
    differed from the one before, both by `time.monotonic()` [s].
    """

    node: str
    graph: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    run: int = 0
    reports: dict[str, Report] = field(default_factory=dict)
    totals: dict[str, int] = field(default_factory=dict)
    heard_s: dict[str, float] = field(default_factory=dict)
    moved_s: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        """Refuse names that do not hold the node itself, or one of them twice."""
        if self.node not in self.graph or len(set(self.graph)) != len(self.graph):
            raise NodesError(
                f'graph = {list(self.graph)}: must name every node of the graph once, {self.node} '
                'among them'
            )

    def hear(self, report: Report) -> None:
        """Take a node's report; those of nodes outside the graph are ignored."""
        if report.node not in self.graph or report.run != self.run:
            return
        self.heard_s[report.node] = time.monotonic()
        if self.reports.get(report.node) != report:
            self.moved_s = self.heard_s[report.node]
        self.reports[report.node] = report

    def hear_end(self, end: End) -> None:
        """Take a node's end marker."""
        if end.node in self.graph and end.run == self.run:
            self.totals.update(end.sent)

    def absent(self) -> list[str]:
        """Return the nodes of the graph that have not been heard."""
        return [name for name in self.graph if name not in self.reports]

    def consumers(self, topic: str) -> list[str]:
        """Return the nodes that subscribe to a topic."""
        return [name for name, report in self.reports.items() if topic in report.taken]

    def in_flight(self, topic: str, sent: int) -> int:
        """Return how many of `sent` messages the slowest consumer has not taken."""
        taken = [report.taken[topic] for report in self.reports.values() if topic in report.taken]
        return sent - min(taken, default=sent)

    def waiting(self, found: dict[str, set[str]]) -> list[str]:
        """Return the nodes and subscriptions missing before anything may be sent; empty if ready.

        `found` has, by output, the names of the nodes that its publisher has matched.
        """
        if absent := self.absent():
            return [f'node {name}' for name in absent]
        return [
            f'subscription of {name} to {topic}'
            for topic in self.outputs
            for name in self.consumers(topic)
            if name not in found.get(topic, ()) or topic not in self.reports[name].matched
        ]

    def everyone_ready(self) -> bool:
        """Return whether all nodes of the graph have said so."""
        return not self.absent() and all(report.ready for report in self.reports.values())

    def short(self, received: dict[str, int]) -> dict[str, int] | None:
        """Return the messages missing of each input; None before all its ends have come."""
        if any(topic not in self.totals for topic in self.inputs):
            return None
        return {
            topic: missing
            for topic in self.inputs
            if (missing := self.totals[topic] - received[topic]) > 0
        }


# -----------------------------------------------------------------------------
# Packs: many messages in one, between the nodes of our own graph. The overhead is paid once.
#
# A pack is a std_msgs/UInt8MultiArray. Its data are, little-endian, the graph's run (uint64), the
# number of messages and their lengths (uint32), then the messages, with their exact lengths: DDS
# pads none of them.

PACK_TOPIC = '_tauto/pack/'
"""Prefix of the name of a packed topic."""

MOST_BYTES = 60_000
"""Largest size of a pack of more than one message: it fits into a UDP datagram."""

# CDR: encapsulation, no dimensions, no offset, length of the data.
_HEAD = struct.Struct('<4sIII')


def pack(payloads: Sequence[bytes], run: int = 0) -> Iterator[bytes]:
    """Yield the serialised packs of a run's messages, in their order."""
    first = size = 0
    for last, payload in enumerate(payloads):
        if size and size + len(payload) > MOST_BYTES:
            yield _packed(payloads[first:last], run)
            first, size = last, 0
        size += len(payload)
    if payloads:
        yield _packed(payloads[first:], run)


def _packed(payloads: Sequence[bytes], run: int) -> bytes:
    n = len(payloads)
    lengths = struct.pack(f'<Q{n + 1}I', run, n, *map(len, payloads))
    data = b''.join([lengths, *payloads])
    return _HEAD.pack(_LITTLE_ENDIAN, 0, 0, len(data)) + data


def unpack(topic: str, octets: bytes, run: int = 0) -> list[bytes]:
    """Return the messages of a serialised pack of a topic, none where it is of another run.

    NodesError: it is not a pack.
    """
    try:
        sender, n = struct.unpack_from('<QI', octets, _HEAD.size)
        if sender != run:
            return []
        lengths = struct.unpack_from(f'<{n}I', octets, _HEAD.size + 12)
    except struct.error:
        raise NodesError(f'{PACK_TOPIC}{topic}: not a pack of messages: {octets[:40]!r}') from None
    at = _HEAD.size + 8 + 4 * (n + 1)
    if at + sum(lengths) > len(octets):
        raise NodesError(
            f'{PACK_TOPIC}{topic}: a pack of {n} messages is cut short: {len(octets)} bytes'
        )
    messages = []
    for length in lengths:
        messages.append(octets[at : at + length])
        at += length
    return messages
