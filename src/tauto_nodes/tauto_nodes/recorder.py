"""Records the graph to a bag: payloads as they come, log time = the stamp in the header."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from tauto_core import samples as s
from tauto_core.bags import TOPICS, BagWriter, header_stamp_ns
from tauto_core.bags.write import CUT_SHORT
from tauto_core.samples import TextSamples
from tauto_core.scene import parse_scene
from tauto_core.scene.errors import SceneError
from tauto_core.scene.times import NS_PER_S
from tauto_core.ship import bag_metadata
from tauto_nodes import ParameterError
from tauto_nodes.node import Diagnostics, GraphNode
from tauto_nodes.parameters import NodeSettings
from tauto_nodes.ports import port
from tauto_nodes.running import main_of


@dataclass(frozen=True)
class RecorderReport:
    """What the recorder says of a voyage under way and at its end, in the file named `report`.

    Times are those of `time.monotonic()`, which on Linux is one clock for all processes.

    Args:
        complete: whether the ends of all topics had come.
        began_s: when its first message came [s]; None: none came.
        closed_s: when the bag was closed [s]; None: it is open.
        topics: received, written and lost, by topic.
        heard_s: when each node of the graph was last heard [s].
        moved_s: when the report of any of them last said something new [s].
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
        """Return the report; None if there is none yet.

        ValueError: it is being written, or there was no room for it.
        """
        try:
            return RecorderReport(**json.loads(file.read_text('utf-8')))
        except FileNotFoundError:
            return None


MOST_DISORDER_NS = NS_PER_S
"""Stamps that go back further than this begin a new run of their topic."""

REPORT_S = 0.2
"""Interval at which a graph is told how far the voyage is [s]."""


def topics_of(settings: NodeSettings) -> list[str]:
    """Return the topics to record, in the order of the table.

    ParameterError: a topic is not in the table. SceneError: the scene cannot be run.
    """
    asked = settings.names('topics')
    if unknown := [name for name in asked if name not in TOPICS and name != 'all']:
        raise ParameterError(
            f'topics = {list(asked)}: {unknown[0]} is not in the table; it holds '
            f'{", ".join(TOPICS)}, or say all'
        )
    chosen = [name for name in TOPICS if name in asked or 'all' in asked]
    if settings.text('scene') and not settings.scene().keeps_motion:
        chosen = [name for name in chosen if name != s.SHIP_IMU]
    return chosen


class RecorderNode(GraphNode):
    """Writes its topics to a bag until their ends have come, or until it is stopped.

    The bag is closed cleanly either way; then the numbers received, written and lost are reported
    for each topic. The exit code is 1 if anything was lost.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('recorder', **node_options)
        topics = topics_of(self.settings)
        reliability = self.settings.text('imu_reliability')
        self._bag = BagWriter(
            Path(self.settings.text('output')),
            force=self.settings.flag('force'),
            namespace=self.get_namespace().strip('/'),
            chunk_bytes=round(1024 * self.settings.number('chunk_size')),
            compression=self.settings.text('compression'),
        )
        self._closed = False
        self._began_s: float | None = None
        self._newest_ns: dict[str, int] = {}
        # Without flow control nobody says when a voyage is over: stopping the recorder ends it.
        self._complete = not self.settings.credits
        self._flushed_s = self._told_s = time.monotonic()
        self._unflushed = False
        self._early: dict[str, list[bytes]] = {}
        self._waits_for_scene = self.settings.credits and s.SCENE in topics
        self.connect([port(topic, reliability) for topic in topics], [])
        self.diagnostics = Diagnostics(self)
        # Last, so that a refusal leaves no folder behind; messages come only once the node spins.
        self._bag.__enter__()

    def take(self, payloads: Mapping[str, Sequence[bytes]]) -> None:
        """Write what arrived, without the padding of the wire if it is from our own graph.

        The scene of our own graph is written first, so that any bag says what it holds.
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
        for topic, messages in payloads.items():
            if self.settings.packed and topic != s.SCENE:
                for message in messages:
                    self._bag.write_raw(topic, message, header_stamp_ns(message))
                continue
            samples, good = self.decoded(topic, messages)
            if samples is None:
                continue
            if isinstance(samples, TextSamples):
                self._write_scenes(samples)
            elif self.flow is not None:
                # DDS pads to four bytes; encoded again, a payload is what `tauto sail` writes.
                self._bag.write({topic: samples})
            else:
                for message, stamp_ns in zip(good, samples.stamp_ns.tolist(), strict=True):
                    self._bag.write_raw(topic, message, stamp_ns)
                self._see_order(topic, samples.stamp_ns.tolist())

    def _write_scenes(self, samples: TextSamples) -> None:
        for text in map(str, samples.data):
            try:
                scene = parse_scene(text, f'topic {s.SCENE}')
            except SceneError as error:
                self.note(s.SCENE, 'not_a_scene', str(error).splitlines()[0])
                continue
            self._bag.write({s.SCENE: s.text(scene.starts_at_ns, text)})
            self._bag.describe(bag_metadata(scene))

    def _see_order(self, topic: str, stamps_ns: list[int]) -> None:
        """Count and name a jump back of a topic's stamps: the bag then holds two runs of it."""
        for was_ns, is_ns in pairwise([self._newest_ns.get(topic, 0), *stamps_ns]):
            if is_ns < was_ns - MOST_DISORDER_NS:
                words = f'stamps went back by {(was_ns - is_ns) * 1e-9:.6g} s'
                self.note(topic, 'stamps_went_back', words)
        self._newest_ns[topic] = stamps_ns[-1]

    def lost(self, short: Mapping[str, int]) -> None:
        """Say it, and keep what has come: the report and the exit code tell of the loss."""
        self.get_logger().error(f'lost on the way: {dict(short)}')

    def tick(self) -> None:
        """Flush and report when it is due."""
        if self._closed:
            return
        now_s = time.monotonic()
        if self.flow is not None and now_s >= self._told_s + REPORT_S:
            self._told_s = now_s
            # Without room for it the bag goes on; the last report, which counts, must be written.
            with suppress(OSError):
                self._report_to_file(closed_s=None)
        if self._unflushed and now_s >= self._flushed_s + self.settings.number('flush_interval'):
            self._bag.flush()
            self._flushed_s, self._unflushed = now_s, False

    def at_end(self) -> None:
        """Close the bag: all that was sent has come, or is lost."""
        self._complete = True
        self.close()
        self.over = True

    def close(self) -> None:
        """Close the bag and report; after a failure of its own the bag keeps what it has."""
        if self._closed:
            return
        self._closed = True
        try:
            if self.failure is None:
                self._work()
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
            self.get_logger().warning(
                'stopped before the end of the voyage; the bag says so (cut_short)'
            )
        self._report_to_file(closed_s)

    def counts(self) -> dict[str, dict[str, int | None]]:
        """Return the numbers received, written and lost by topic; lost is None if unknown.

        With flow control senders say how many they have sent. Without it nobody does: what the
        middleware can tell is not asked for, since that can lock the node (`look_at_links`).
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
        if self.settings.text('report'):
            heard_s = self.flow.heard_s if self.flow is not None else {}
            moved_s = self.flow.moved_s if self.flow is not None else time.monotonic()
            RecorderReport(
                self._complete, self._began_s, closed_s, self.counts(), heard_s, moved_s
            ).write(Path(self.settings.text('report')))


recorder = main_of(RecorderNode)
