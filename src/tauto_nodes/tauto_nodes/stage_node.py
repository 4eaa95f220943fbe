"""A stage of tauto_core with messages on both sides."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from std_srvs.srv import Trigger

from tauto_core.bags import decode, encode
from tauto_core.samples import Batches, Samples, Stage, count
from tauto_core.scene import Scene, load_scene
from tauto_nodes.diagnostics import Diagnostics
from tauto_nodes.errors import NodesError
from tauto_nodes.member import Member
from tauto_nodes.parameters import Settings
from tauto_nodes.qos import port


def scene_of(settings: Settings) -> Scene:
    """Return the scene that the parameters `scene` and `duration` name; SceneError otherwise."""
    duration = settings.number('duration')
    if duration > 0.0:
        return load_scene(settings.text('scene'), duration=duration)
    return load_scene(settings.text('scene'))


class StageNode(Member):
    """Subscribes to the stage's inputs, publishes its outputs; driven by stamps alone.

    Without flow control it flushes at shutdown and when `~/finish` (std_srvs/Trigger) is called.

    Args:
        role: which node of the parameter table this is.
        build: makes the stage from the settings.
        node_options: handed to rclpy.node.Node.
    """

    def __init__(self, role: str, build: Callable[[Settings], Stage], **node_options: Any) -> None:
        super().__init__(role, **node_options)
        self.stage = build(self.settings)
        reliability = str(self.settings.values.get('imu_reliability', 'reliable'))
        self.connect(
            [port(topic, reliability) for topic in self.stage.inputs],
            [port(topic) for topic in self.stage.outputs],
        )
        self.create_service(Trigger, '~/finish', self._finish)
        self.diagnostics = Diagnostics(self)

    def take(self, payloads: Mapping[str, Sequence[bytes]]) -> None:
        """Feed the stage what came and send what it says."""
        self._send(self.stage.feed({t: _samples(t, raw) for t, raw in payloads.items()}))

    def at_end(self) -> None:
        """Send what the stage still holds back."""
        self._send(self.stage.finish())

    def close(self) -> None:
        """Flush where no end marker would have done it."""
        if self.flow is None and self.failure is None:
            self.end_input()

    def health(self) -> dict[str, int]:
        """Return the stage's counters."""
        return self.stage.health()

    def _send(self, batches: Batches) -> None:
        for topic, samples in batches.items():
            if count(samples):
                self.send(topic, encode(topic, samples))

    def _finish(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if self.flow is not None:
            response.success = False
            response.message = 'flow_control = credits: the end marker of the source finishes'
            return response
        try:
            self.end_input()
        except Exception as error:
            self.failure = error
        response.success = self.failure is None
        response.message = str(self.failure or 'flushed; what comes now is left aside')
        return response


def _samples(topic: str, payloads: Sequence[bytes]) -> Samples:
    samples = decode(topic, payloads, np.zeros(len(payloads), np.int64))
    if count(samples) != len(payloads):
        raise NodesError(f'{topic}: {len(payloads)} messages decode to {count(samples)} samples')
    return samples
