"""The base of all nodes: they work on messages, take part in flow control, and end."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from std_msgs.msg import String

from tauto_nodes.errors import NodesError
from tauto_nodes.flow import (
    BATCH,
    CREDIT_TOPIC,
    END_TOPIC,
    PACKED_TIMES,
    WINDOW,
    End,
    Flow,
    Report,
    known,
)
from tauto_nodes.intake import Intake
from tauto_nodes.ports import Input, Output, PortNode
from tauto_nodes.qos import CREDIT_QOS, END_QOS, Port, can_match, type_name

TICK_S = 0.01
HELLO_S = 0.05
SOON_S = 0.1
"""Fewer messages than a batch are reported as taken after this time [s]."""

REPEAT_S = 1.0
LOST_AFTER_S = 10.0
ALARM_S = 10.0
"""Time for which /diagnostics still reports an error that has passed [s]."""


class Member(PortNode):
    """Base of the nodes. Subclasses override `take`, `at_end`, `tick`, `close`, `health`.

    Args:
        role: says which node of the table in parameters.py this is; also its default name.
        node_options: handed to rclpy.node.Node.
    """

    def __init__(self, role: str, **node_options: Any) -> None:
        super().__init__(role, **node_options)
        times = PACKED_TIMES if self.settings.packed else 1
        self._window, self._batch = WINDOW * times, BATCH * times
        self.over = False
        self.exit_code = 0
        self.steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.input_over = False
        self._ended = False
        self._totals_s: float | None = None
        self._waiting: list[str] = []
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

        Raises:
            NodesError: what the node would publish from now on is not what the scene says.
        """
        raise NodesError(f'messages were lost on the way: {dict(short)}. Start the voyage again')

    def tick(self) -> None:
        """Do what is due; called every TICK_S of the steady clock and when credits come."""

    def close(self) -> None:
        """Leave the graph cleanly; the context is still alive."""

    def health(self) -> dict[str, int]:
        """Return counters of what was refused or bridged."""
        ports: Iterable[tuple[str, Input | Output]] = chain(
            self.inputs.items(), self.outputs.items()
        )
        clashes = {f'{topic} incompatible_qos': p.incompatible for topic, p in ports}
        return {**self._left_aside, **{name: n for name, n in clashes.items() if n}}

    @property
    def trouble(self) -> str:
        """What keeps the node from working at present; empty if nothing does."""
        return ''

    # What it notices.

    def intake(self, topic: str) -> Intake:
        """Return the decoder of the messages of a topic."""
        if topic not in self._intakes:
            self._intakes[topic] = Intake(topic, partial(self.note, topic))
        return self._intakes[topic]

    def note(self, topic: str, reason: str, words: str) -> None:
        """Count what is wrong with a message; name the first one of a kind in the log.

        Raises:
            NodesError: the message comes from our own graph, which must not lose any.
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

    # Ports.

    def connect(self, inputs: Sequence[Port], outputs: Sequence[Port]) -> None:
        """Create the ports and begin to tick.

        Raises:
            NodesError: the graph's names do not hold the node.
            ParameterError: QoS overrides that do not go with flow control, or of no port.
        """
        controlled = self.settings.credits
        if controlled:
            names = known(self.settings.names('graph'), self.get_name())
            topics = tuple(p.name for p in inputs), tuple(p.name for p in outputs)
            self.flow = Flow(self.get_name(), names, *topics)
        self.open_ports(inputs, outputs)
        if controlled:
            self._credit = self.create_publisher(String, CREDIT_TOPIC, CREDIT_QOS)
            self._end = self.create_publisher(String, END_TOPIC, END_QOS)
            hear = self.guard(self._hear)
            self.create_subscription(String, CREDIT_TOPIC, hear, CREDIT_QOS, raw=True)
            self.create_subscription(String, END_TOPIC, self.guard(self._hear_end), END_QOS)
        self.create_timer(TICK_S, self.guard(self._tick), clock=self.steady)

    # In.

    def received(self, source: Input, payloads: list[bytes]) -> None:
        """Keep the messages; process them if there are many."""
        if self.input_over:
            return
        source.received += len(payloads)
        source.pending += payloads
        if len(source.pending) >= self._batch and not self.backlogged:
            self._work()
            if self.flow is not None:
                self._report()

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
                source.last_s = now
                source.pending = []
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

    # Flow control.

    def _hear(self, octets: bytes) -> None:
        assert self.flow is not None
        report = Report.from_octets(octets)
        if report.node == self.flow.node:
            return
        self.flow.hear(report)
        for topic, output in self.outputs.items():
            if output.queue:
                self._pump(topic, output)
        if not self.backlogged:
            self.tick()

    def _hear_end(self, message: String) -> None:
        assert self.flow is not None
        self.flow.hear_end(End.from_json(message.data))

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

    @property
    def waiting(self) -> list[str]:
        """What the node's outputs wait for before anything may be sent."""
        return self._waiting

    def _report(self) -> None:
        assert self.flow is not None
        now = time.monotonic()
        due_s = REPEAT_S
        if not self.flow.everyone_ready():
            due_s = HELLO_S
            self._waiting = self.flow.waiting(
                {topic: self._found(topic) for topic in self.outputs}
            )
        matched = tuple(topic for topic, source in self.inputs.items() if source.matched > 0)
        taken = {topic: source.taken for topic, source in self.inputs.items()}
        report = Report(self.flow.node, taken, matched, not self._waiting)
        if now - self._reported_s >= due_s or self._is_news(report, now - self._reported_s):
            self._credit.publish(report.to_octets())
            self.flow.hear(report)
            self._reported, self._reported_s = report, now

    def _is_news(self, report: Report, since_s: float) -> bool:
        """Whether others should hear a report before it is due: each costs all of them time."""
        known = self._reported
        if known is None or (report.matched, report.ready) != (known.matched, known.ready):
            return True
        fresh = [n - known.taken[topic] for topic, n in report.taken.items()]
        return max(fresh, default=0) >= self._batch or (any(fresh) and since_s >= SOON_S)

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

    @property
    def output_over(self) -> bool:
        """Whether all that the node will ever send has been published."""
        return self.input_over and not self.backlogged

    def _tick(self) -> None:
        self.look_at_links()
        self.tick()
        for topic, output in self.outputs.items():
            if output.queue:
                self._pump(topic, output)
        self._work()
        if self.flow is None:
            return
        if self.inputs and not self.input_over:
            self._close_input()
        if self.output_over and self.outputs and not self._ended:
            self._ended = True
            sent = {topic: output.sent for topic, output in self.outputs.items()}
            self._end.publish(String(data=End(self.get_name(), sent).to_json()))
        self._report()
