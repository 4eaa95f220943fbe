"""Records the graph to a bag, payloads as they come.

The log time of a simulated voyage is the stamp in the header: its bag is independent of the wall
clock. In a live one the log time is the time of receipt, and the publish time the time of sending,
as in rosbag2. They show the delay of a sensor, and an error of its clock.
"""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from itertools import count, repeat
from operator import itemgetter
from pathlib import Path
from typing import Any

from rclpy.qos import QoSDurabilityPolicy, QoSReliabilityPolicy

from tauto_core import samples as s
from tauto_core.bags import TOPICS, BagWriter, encode, header_stamp_ns
from tauto_core.bags.write import CUT_SHORT, declared_topic
from tauto_core.samples import TextSamples
from tauto_core.scene import Scene, parse_scene, scene_yaml
from tauto_core.scene.errors import BagError, SceneError
from tauto_core.ship import bag_metadata
from tauto_nodes import NodesError, ParameterError
from tauto_nodes.live import main_of
from tauto_nodes.live.node import (
    MIN_DEPTH,
    Diagnostics,
    GraphNode,
    Times,
    TopicPort,
    message_class,
    port,
    profile_of,
)
from tauto_nodes.live.parameters import NodeSettings


@dataclass(frozen=True)
class RecorderReport:
    """The recorder's report on a voyage, under way and at its end, in the file named `report`.

    Times are of `time.monotonic()`, on Linux one clock for all processes.

    Args:
        complete: whether the ends of all topics had come.
        began_s: time of the first message [s], if any.
        closed_s: time at which the bag was closed [s], if it is.
        topics: received, written and lost, by topic.
        heard_s: when each node of the graph was last heard [s].
        moved_s: time of the last new report of any of them [s].
    """

    complete: bool
    began_s: float | None
    closed_s: float | None
    topics: dict[str, Any]
    heard_s: dict[str, float]
    moved_s: float

    def write(self, file: Path) -> None:
        """Write the report, as JSON."""
        file.write_text(json.dumps(asdict(self)), 'utf-8')

    @staticmethod
    def read(file: Path) -> RecorderReport | None:
        """Return the report, or `None` before the first. ValueError: it is incomplete.

        It is being written, or there was no room for it.
        """
        try:
            return RecorderReport(**json.loads(file.read_text('utf-8')))
        except FileNotFoundError:
            return None


ALSO = ('/diagnostics', '/tf_static')
"""Topics of a live bag that are not in the table: health of the nodes, and mountings."""

STAGES = ('trochlea', 'drift_estimator', 'longitude')
"""Nodes that send their remaining messages on a request to stop."""

LINGER_S = 5.0
"""Longest time that a stopped live recorder waits for the nodes' last messages [s]."""


def topics_of(settings: NodeSettings) -> tuple[list[str], list[str]]:
    """Return the topics of the table to record, in its order, and the names of others.

    ParameterError: a topic is not in the table. SceneError: the scene cannot be run.
    """
    asked = settings['topics']
    foreign = [name for name in asked if name.startswith('/')]
    if foreign and settings.credits:
        raise ParameterError(
            f'topics = {list(asked)}: {foreign[0]} is not of the graph, and with flow_control = '
            'credits its losses are unknown. Record it by ros2 bag'
        )
    known = [name for name in asked if name not in foreign]
    if unknown := [name for name in known if name not in TOPICS and name != 'all']:
        raise ParameterError(
            f'topics = {list(asked)}: {unknown[0]} is not in the table. It holds '
            f'{", ".join(TOPICS)}. Use one of these, all, or an absolute name of another topic'
        )
    if 'all' in known and not settings.credits:
        foreign += [name for name in ALSO if name not in foreign]
    chosen = [name for name in TOPICS if name in known or 'all' in known]
    if settings['scene']:
        left_out = set() if settings.scene().keeps_motion else {s.SHIP_IMU}
        if not settings.credits:
            left_out.add(s.SCENE)  # it is known, and written at once
        chosen = [name for name in chosen if name not in left_out]
    return chosen, foreign


class RecorderNode(GraphNode):
    """Writes its topics to a bag until their ends have come, or until it is stopped.

    It always closes the bag cleanly, and reports the numbers received, written and lost for each
    topic. The exit code is 1 after a loss.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('recorder', **node_options)
        topics, self._sought = topics_of(self.settings)
        self.keeps_times = self.is_calm = not self.settings.credits
        reliability = self.settings['imu_reliability']
        folder = Path(self.settings['output'])
        if self.settings['beside'] and folder.exists():
            beside = (folder.with_name(f'{folder.name}_{number}') for number in count(2))
            folder = next(other for other in beside if not other.exists())
        self._bag = BagWriter(
            folder,
            force=self.settings['force'],
            namespace=self.get_namespace().strip('/'),
            chunk_bytes=round(1024 * self.settings['chunk_size']),
            compression=self.settings['compression'],
        )
        self._closed = False
        self._began_s: float | None = None
        # Without flow control a voyage has no end marker: stopping the recorder ends it.
        self._complete = not self.settings.credits
        self._flushed_s = self._told_s = time.monotonic()
        self._unflushed = False
        self._early: dict[str, list[bytes]] = {}
        self._readings: int | None = None
        self._waits_for_scene = self.settings.credits and s.SCENE in topics
        self._sought_s = 0.0
        self._leaves_s: float | None = None
        self.connect([port(topic, reliability) for topic in topics], [])
        self.diagnostics = Diagnostics(self)
        # Last, because a refusal must not leave a folder. Messages come only once the node spins.
        self._bag.__enter__()
        if self.settings['scene'] and not self.settings.credits:
            scene, now_ns = self.settings.scene(), time.time_ns()
            (message,) = encode(s.SCENE, s.text(now_ns, scene_yaml(scene)))
            self._bag.describe(bag_metadata(scene))
            self._bag.write_raw(s.SCENE, message, now_ns)

    def take(self, payloads: Mapping[str, Sequence[bytes]]) -> None:
        """Write the messages, without the padding of the wire if from our own graph.

        The scene of our own graph is written first.
        """
        if payloads and self._began_s is None:
            self._began_s = time.monotonic()
        if self._waits_for_scene:
            for topic, messages in payloads.items():
                self._early.setdefault(topic, []).extend(messages)
            if s.SCENE not in self._early:
                return
            self._waits_for_scene = False
            payloads = {s.SCENE: self._early.pop(s.SCENE), **self._early}
            self._early = {}
        self._unflushed = True
        if self.flow is None:
            self._write_live(payloads)
            return
        rows: list[tuple[int, str, bytes]] = []
        for topic, messages in payloads.items():
            if self.settings.packed and topic != s.SCENE:
                rows += [(header_stamp_ns(message), topic, message) for message in messages]
                continue
            samples, _ = self.decoded(topic, messages)
            if isinstance(samples, TextSamples):
                for text in map(str, samples.data):
                    scene = self._described(text)
                    self._readings = scene.log_count if s.READING in self.inputs else None
                    self._bag.write({s.SCENE: s.text(scene.starts_at_ns, text)})
            elif samples is not None:
                # DDS pads to four bytes. Encoded again, a payload is what `tauto sail` writes.
                whole = encode(topic, samples)
                rows += zip(samples.stamp_ns.tolist(), repeat(topic), whole, strict=False)
        rows.sort(key=itemgetter(0))  # as far as the nodes go together, in the order of time
        for stamp_ns, topic, message in rows:
            self._bag.write_raw(topic, message, stamp_ns)

    def _write_live(self, payloads: Mapping[str, Sequence[bytes]]) -> None:
        rows: list[tuple[Times, str, bytes]] = []
        for topic, messages in payloads.items():
            times = dict(zip(map(id, messages), self.times[topic], strict=True))
            good = list(messages)
            if not self.inputs[topic].is_shared:
                samples, good = self.decoded(topic, messages)
                if isinstance(samples, TextSamples):
                    pairs = zip(good, map(str, samples.data), strict=True)
                    good = [message for message, text in pairs if self._is_scene(text)]
            rows += [(times[id(message)], topic, message) for message in good]
        rows.sort(key=itemgetter(0))
        for (received_ns, sent_ns), topic, message in rows:
            self._bag.write_raw(topic, message, received_ns, sent_ns)

    def _is_scene(self, text: str) -> bool:
        try:
            self._described(text)
        except SceneError as error:
            self.note(s.SCENE, 'not_a_scene', str(error).splitlines()[0])
            return False
        return True

    def _described(self, text: str) -> Scene:
        """Return the scene of a message, and describe the bag by it."""
        scene = parse_scene(text, f'topic {s.SCENE}')
        self._bag.describe(bag_metadata(scene))
        return scene

    def _seek(self) -> None:
        """Subscribe to the foreign topics that have found a publisher, as it offers them."""
        for name in list(self._sought):
            if not (infos := self.get_publishers_info_by_topic(name)):
                continue
            self._sought.remove(name)
            offered = [info.qos_profile for info in infos]
            reliable = all(q.reliability == QoSReliabilityPolicy.RELIABLE for q in offered)
            latched = all(q.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL for q in offered)
            profile = profile_of(MIN_DEPTH, reliable=reliable, latched=latched)
            try:
                message = message_class(infos[0].topic_type)
                declared = declared_topic(name, infos[0].topic_type, MIN_DEPTH, latched=latched)
            except (NodesError, BagError) as error:
                self.get_logger().warning(f'{name} is not recorded: {error}')
                continue
            self._bag.declare(name, declared)
            self.listen_to(TopicPort(name, message, profile), is_shared=True)

    def lost(self, short: Mapping[str, int]) -> None:
        """Report the loss, also by the exit code, and keep the messages."""
        self.get_logger().error(f'lost on the way: {dict(short)}')

    def tick(self) -> None:
        """Flush and report when it is due."""
        if self._closed:
            return
        now_s = time.monotonic()
        if self._sought and now_s >= self._sought_s + 1.0:
            self._sought_s = now_s
            self._seek()
        if self.flow is not None and now_s >= self._told_s + 0.2:
            self._told_s = now_s
            # Without room for a report the bag goes on. The last report must be written.
            with suppress(OSError):
                self._report_to_file(closed_s=None)
        if self._unflushed and now_s >= self._flushed_s + self.settings['flush_interval']:
            self._bag.flush()
            self._flushed_s, self._unflushed = now_s, False

    def waits_on_shutdown(self) -> bool:
        """Whether the nodes of a live clock, after a request to stop, may send more."""
        if self.flow is not None or self._closed or self.failure is not None:
            return False
        now_s = time.monotonic()
        self._leaves_s = self._leaves_s or now_s + LINGER_S
        computed = [t for t in self.inputs if t in TOPICS and TOPICS[t].node in STAGES]
        return now_s < self._leaves_s and any(self.inputs[t].matched for t in computed)

    def at_end(self) -> None:
        """Close the bag: all that was sent has come, or is lost.

        It is whole if the clock has been read as often as the scene says.
        """
        had = self.inputs[s.READING].received if self._readings is not None else None
        self._complete = had == self._readings
        if not self._complete:
            self.get_logger().error(f'{had} of {self._readings} readings have come')
        self.close()
        self.over = True

    def close(self) -> None:
        """Close the bag and report. A failed bag keeps its messages."""
        if self._closed:
            return
        self._closed = True
        try:
            if self.failure is None:
                self.work()
                self._waits_for_scene = False
                self.take(self._early)
            if not self._complete:
                self._bag.describe(CUT_SHORT)
        finally:
            failed = self.failure
            self._bag.__exit__(type(failed) if failed else None, failed, None)
        if self.failure is not None:
            return
        closed_s, counts = time.monotonic(), self.counts()
        for topic, numbers in counts.items():
            lost = 'unknown' if numbers['lost'] is None else numbers['lost']
            self.get_logger().info(
                f'{topic}: received {numbers["received"]}, written {numbers["written"]}, '
                f'lost {lost}'
            )
        if any(numbers['lost'] for numbers in counts.values()):
            self.exit_code = 1
        if not self._complete:
            self.exit_code = 1
            self.get_logger().error(
                'stopped before the voyage was over. The bag says so (cut_short)'
            )
        self._report_to_file(closed_s)

    def counts(self) -> dict[str, dict[str, int | None]]:
        """Return the numbers received, written and lost by topic. Lost is `None` if unknown.

        With flow control senders report their numbers. Without it the loss is unknown: to ask the
        middleware can lock the node (`look_at_links`).
        """
        totals = self.flow.totals if self.flow is not None else {}
        return {
            topic: {
                'received': source.received,
                'written': self._bag.counts.get(topic, 0),
                'lost': max(totals.get(topic, source.received) - source.received, 0)
                if self.flow is not None
                else None,
            }
            for topic, source in self.inputs.items()
        }

    def _report_to_file(self, closed_s: float | None) -> None:
        if self.settings['report']:
            heard_s = self.flow.heard_s if self.flow is not None else {}
            moved_s = self.flow.moved_s if self.flow is not None else time.monotonic()
            RecorderReport(
                self._complete, self._began_s, closed_s, self.counts(), heard_s, moved_s
            ).write(Path(self.settings['report']))


recorder = main_of(RecorderNode)
