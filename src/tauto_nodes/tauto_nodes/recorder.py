"""Records the graph to a bag: payloads as they come, log time = the stamp in the header."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tauto_core import samples as s
from tauto_core.bags import TOPICS, BagWriter, decode, header_stamp_ns
from tauto_core.samples import Samples, TextSamples
from tauto_core.scene import Scene, parse_scene
from tauto_core.ship import bag_metadata
from tauto_nodes.diagnostics import Diagnostics
from tauto_nodes.errors import ParameterError
from tauto_nodes.member import Member
from tauto_nodes.parameters import Settings
from tauto_nodes.qos import port
from tauto_nodes.running import main_of
from tauto_nodes.stage_node import scene_of


def topics_of(settings: Settings) -> list[str]:
    """Return the topics to record, in the order of the table.

    Raises:
        ParameterError: a topic that is not in the table.
        SceneError: the scene cannot be run.
    """
    asked = settings.names('topics')
    if unknown := [name for name in asked if name not in TOPICS and name != 'all']:
        raise ParameterError(
            f'topics = {list(asked)}: {unknown[0]} is not in the table; it holds '
            f'{", ".join(TOPICS)}, or say all'
        )
    chosen = [name for name in TOPICS if name in asked or 'all' in asked]
    if settings.text('scene') and not scene_of(settings).keeps_motion:
        chosen = [name for name in chosen if name != s.SHIP_IMU]
    return chosen


class Recorder(Member):
    """Writes its topics to a bag until their ends have come, or until it is stopped.

    The bag is closed cleanly either way; then received, written and lost are told per topic.
    The exit code is 1 if anything was lost.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('recorder', **node_options)
        topics = topics_of(self.settings)
        reliability = self.settings.text('imu_reliability')
        self._bag = BagWriter(
            Path(self.settings.text('output')),
            force=self.settings.flag('force'),
            namespace=self.get_namespace().strip('/'),
        )
        self._closed = False
        self.connect([port(topic, reliability) for topic in topics], [])
        self.diagnostics = Diagnostics(self)
        # Last, so that a refusal leaves no folder behind; messages come only once the node spins.
        self._bag.__enter__()

    def take(self, payloads: Mapping[str, Sequence[bytes]]) -> None:
        """Write what came: from our own graph without the wire's padding, else as it is."""
        for topic, messages in payloads.items():
            if self.flow is not None or not TOPICS[topic].stamped:
                # DDS pads to four bytes; encoded again, a payload is what `tauto sail` writes.
                samples = _samples(topic, messages)
                self._bag.write({topic: samples})
                if isinstance(samples, TextSamples):
                    for one in _scenes(samples):
                        self._bag.describe(bag_metadata(one))
                continue
            for message in messages:
                self._bag.write_raw(topic, message, header_stamp_ns(message))

    def at_end(self) -> None:
        """Close the bag: all that was sent has come, or is lost."""
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
        finally:
            failed = self.failure
            self._bag.__exit__(type(failed) if failed else None, failed, None)
        if self.failure is None:
            self._tell()

    def counts(self) -> dict[str, dict[str, int]]:
        """Return received, written and lost by topic; lost as far as the ends are known."""
        totals = self.flow.totals if self.flow is not None else {}
        return {
            topic: {
                'received': source.received,
                'written': self._bag.counts.get(topic, 0),
                'lost': max(totals.get(topic, source.received) - source.received, 0),
            }
            for topic, source in self.inputs.items()
        }

    def _tell(self) -> None:
        counts = self.counts()
        for topic, numbers in counts.items():
            self.get_logger().info(
                f'{topic}: received {numbers["received"]}, written {numbers["written"]}, '
                f'lost {numbers["lost"]}'
            )
        if any(numbers['lost'] for numbers in counts.values()):
            self.exit_code = 1
        if self.settings.text('report'):
            Path(self.settings.text('report')).write_text(json.dumps(counts), 'utf-8')


def _samples(topic: str, messages: Sequence[bytes]) -> Samples:
    samples = decode(topic, messages, np.zeros(len(messages), np.int64))
    if not isinstance(samples, TextSamples):
        return samples
    starts = [one.starts_at_ns for one in _scenes(samples)]
    return replace(samples, stamp_ns=np.array(starts, np.int64))


def _scenes(samples: TextSamples) -> list[Scene]:
    return [parse_scene(str(text), f'topic {s.SCENE}') for text in samples.data]


main = main_of(Recorder)

if __name__ == '__main__':
    main()
