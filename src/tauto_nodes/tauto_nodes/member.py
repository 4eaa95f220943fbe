"""The base of all nodes: they work on messages, take part in flow control, pace time, and end."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import chain, groupby
from operator import itemgetter
from typing import Any, TypeAlias, cast

import numpy as np
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock as ClockMessage
from std_msgs.msg import String

from tauto_core import samples as s
from tauto_core.bags import decode
from tauto_core.navigation import ESTIMATE_NAMES
from tauto_core.samples import (
    NS_PER_S,
    FixSamples,
    ImuSamples,
    JointSamples,
    Samples,
    TextSamples,
    TimeSamples,
)
from tauto_core.scene.errors import BagError
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
from tauto_nodes.ports import (
    CREDIT_QOS,
    END_QOS,
    Diagnostics,
    Input,
    Output,
    Port,
    PortNode,
    can_match,
    node_of,
    type_name,
)

# -----------------------------------------------------------------------------
# From serialised messages to samples; invalid messages are counted and ignored.
#
# Anybody may publish anything on a topic. A message that cannot be decoded, belongs to another
# frame, or has wrong names or NaN neither ends a node nor hides its neighbours. The fate of a
# message does not depend on the others that came with it.

NAMES = {s.ESTIMATE: ESTIMATE_NAMES}
"""Names with which a topic's scalars must begin; for other topics the first message decides."""


class Intake:
    """Decodes the messages of one topic.

    Args:
        topic: of the table.
        note: called with a reason and its description, once for each message that is ignored.
    """

    def __init__(self, topic: str, note: Callable[[str, str], None]) -> None:
        self._topic, self._note = topic, note
        self._kind: tuple[str, tuple[str, ...], tuple[int, ...]] | None = None
        self._required = NAMES.get(topic)

    def samples(self, payloads: Sequence[bytes]) -> tuple[Samples | None, list[bytes]]:
        """Return the samples of the usable messages, None if there are none, and these messages.

        Messages without a header are stamped 0.
        """
        try:
            whole = self._decoded(payloads)
            if self._is_good(whole):
                return whole, list(payloads)
        except BagError:
            pass
        good = [(one, payload) for payload in payloads if (one := self._one(payload)) is not None]
        if not good:
            return None, []
        return s.join([cast(TimeSamples, one) for one, _ in good]), [raw for _, raw in good]

    def _decoded(self, payloads: Sequence[bytes]) -> Samples:
        samples = decode(self._topic, payloads, np.zeros(len(payloads), np.int64))
        if s.count(samples) != len(payloads):
            raise BagError(f'{self._topic}: {len(payloads)} messages, other samples')
        return samples

    def _one(self, payload: bytes) -> Samples | None:
        try:
            sample = self._decoded([payload])
        except BagError as error:
            self._note('undecodable', f'a message is left aside: {error}')
            return None
        if self._is_good(sample):
            return sample
        reason, words = self._fault(sample)
        self._note(reason, f'a message is left aside: {words}')
        return None

    def _is_good(self, samples: Samples) -> bool:
        return not any(self._fault(samples))

    def _fault(self, samples: Samples) -> tuple[str, str]:
        """Return what is wrong with samples, in a word and in full; empty where nothing is."""
        if isinstance(samples, TextSamples | s.PlanarImu):
            return '', ''
        return next(self._faults(samples), ('', ''))

    def _faults(
        self, samples: ImuSamples | JointSamples | TimeSamples | FixSamples
    ) -> Iterator[tuple[str, str]]:
        if samples.stamp_ns.min() < 0:
            yield 'out_of_range', f'stamped {samples.stamp_ns.min() * 1e-9:.6g} s, before 0'
        names: tuple[str, ...] = ()
        widths: tuple[int, ...] = ()
        if isinstance(samples, JointSamples):
            names = samples.name
            numbers = (samples.position, samples.velocity, samples.effort)
            widths = tuple(number.shape[1] for number in numbers)
            if not all(np.isfinite(number).all() for number in numbers):
                yield 'not_finite', 'one of its numbers is none'
        if self._required is not None and names[: len(self._required)] != self._required:
            yield 'other_names', f'names {names}, which do not begin with {self._required}'
        if self._kind is None:
            self._kind = samples.frame_id, names, widths
        frame, first_names, first_widths = self._kind
        if frame != samples.frame_id:
            yield 'other_frame', f'frame {samples.frame_id!r}, not {frame!r} as before'
        if first_names != names:
            yield 'other_names', f'names {names}, not {first_names} as before'
        if first_widths != widths:
            yield 'other_widths', f'arrays of {widths} numbers, not {first_widths} as before'


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


# -----------------------------------------------------------------------------
# A node that paces time: it sends stamped messages when they are due.

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
