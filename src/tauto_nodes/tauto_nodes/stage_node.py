"""A stage of tauto_core with messages on both sides."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from std_srvs.srv import Trigger

from tauto_core.bags import encode
from tauto_core.samples import Batches, Samples, Stage, TimeSamples, count, take
from tauto_core.scene import Scene, load_scene
from tauto_core.scene.errors import BagError
from tauto_core.voyage import refused_words
from tauto_nodes.diagnostics import Diagnostics
from tauto_nodes.errors import NodesError, ParameterError
from tauto_nodes.member import Member
from tauto_nodes.parameters import Settings
from tauto_nodes.qos import port
from tauto_nodes.state_file import StateFile


def scene_of(settings: Settings) -> Scene:
    """Return the scene that the parameters `scene` and `duration` name; SceneError otherwise."""
    duration = settings.number('duration')
    if duration > 0.0:
        return load_scene(settings.text('scene'), duration=duration)
    return load_scene(settings.text('scene'))


class StageNode(Member):
    """Subscribes to the stage's inputs, publishes its outputs; driven by stamps alone.

    Without flow control it flushes at shutdown and when `~/finish` (std_srvs/Trigger) is called.
    With a `state_folder` it saves its state instead of flushing, and goes on from it when it is
    started again.

    Args:
        role: says which node of the parameter table this is.
        build: makes the stage from the settings.
        node_options: handed to rclpy.node.Node.
    """

    def __init__(self, role: str, build: Callable[[Settings], Stage], **node_options: Any) -> None:
        super().__init__(role, **node_options)
        self._file = self._state_file()
        saved = self._file.load() if self._file is not None else None
        self.stage = build(self.settings)
        if self._file is not None and saved is not None:
            self.stage.restore(saved)
            self.get_logger().info(f'goes on from the state in {self._file.path}')
        self._saved_s = time.monotonic()
        self._changed = False
        reliability = str(self.settings.values.get('imu_reliability', 'reliable'))
        self.connect(
            [port(topic, reliability) for topic in self.stage.inputs],
            [port(topic) for topic in self.stage.outputs],
        )
        self.create_service(Trigger, '~/finish', self._finish)
        self.diagnostics = Diagnostics(self)

    def take(self, payloads: Mapping[str, Sequence[bytes]]) -> None:
        """Feed the stage with what arrived and send what it returns."""
        batches = {}
        for topic, raw in payloads.items():
            samples, _ = self.intake(topic).samples(raw)
            if samples is not None:
                batches[topic] = samples
        if batches:
            self._send(self.stage.feed(batches))
            if self.flow is not None and (words := refused_words(self.stage.health())):
                raise NodesError(words)
            self._changed = True
        for line in getattr(self.stage, 'news', list)():
            self.get_logger().error(line)
            self.alarm(line)

    @property
    def trouble(self) -> str:
        """What keeps the stage from publishing anything; empty if nothing does."""
        return str(getattr(self.stage, 'trouble', ''))

    def at_end(self) -> None:
        """Send what the stage still holds back; no state remains to continue from."""
        self._send(self.stage.finish())
        if self._file is not None:
            self._file.remove()

    def tick(self) -> None:
        """Save the state when it is due."""
        due_s = self._saved_s + self.settings.number('state_interval')
        if self._changed and time.monotonic() >= due_s:
            self._save()

    def close(self) -> None:
        """Save the state, or flush where no end marker would have done it."""
        if self.flow is not None or self.failure is not None or self.input_over:
            return
        if self._file is None:
            self.end_input()
        else:
            self._work()
            self._save()

    def _state_file(self) -> StateFile | None:
        folder = self.settings.text('state_folder')
        if not folder:
            return None
        if self.settings.credits:
            raise ParameterError(
                f'state_folder = {folder!r}: with flow_control = credits a graph runs as a whole '
                'or not at all. Leave it out'
            )
        name = self.get_fully_qualified_name()
        return StateFile(Path(folder), name, scene_of(self.settings))

    def _save(self) -> None:
        if self._file is None:
            return
        self._saved_s, self._changed = time.monotonic(), False
        try:
            self._file.save(self.stage.state())
        except OSError as error:
            self.alarm(f'{self._file.path} cannot be written ({error.strerror})')

    def health(self) -> dict[str, int]:
        """Return the stage's counters."""
        return {**super().health(), **self.stage.health()}

    def _send(self, batches: Batches) -> None:
        for topic, samples in batches.items():
            if count(samples):
                self.send(topic, self._encoded(topic, samples))

    def _encoded(self, topic: str, samples: Samples) -> list[bytes]:
        """Return the messages; samples that no message can hold are left out and counted."""
        try:
            return encode(topic, samples)
        except BagError as error:
            if count(samples) == 1:
                self.note(topic, 'unsayable', str(error))
                return []
            each = (
                take(cast(TimeSamples, samples), slice(k, k + 1)) for k in range(count(samples))
            )
            return [payload for one in each for payload in self._encoded(topic, one)]

    def _finish(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if self.flow is not None:
            response.success = False
            response.message = 'flow_control = credits: the end marker of the source finishes'
            return response
        try:
            self.end_input()
        except Exception as error:
            self.fail(error)
        response.success = self.failure is None
        response.message = str(self.failure or 'flushed; what comes now is left aside')
        return response
