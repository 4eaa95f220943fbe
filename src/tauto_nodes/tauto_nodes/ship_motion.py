"""The ship: its motion, its place and the navigator's observations, paced by wall time."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import repeat
from typing import Any, Protocol

from rcl_interfaces.msg import SetParametersResult
from rclpy.parameter import Parameter as RosParameter

from tauto_core import samples as s
from tauto_core.bags import encode
from tauto_core.voyage import ShipSource
from tauto_nodes.errors import ParameterError
from tauto_nodes.member import Item, SourceNode
from tauto_nodes.ports import port
from tauto_nodes.running import main_of
from tauto_nodes.stage_node import scene_of

CHUNK = 256
"""IMU samples computed at a time."""

OUTPUTS = (s.SCENE, s.SHIP_FIX, s.OBSERVATION, s.SHIP_IMU)


class Source(Protocol):
    """A source of the ship's batches: the next `count` steps, nothing at the end."""

    def produce(self, count: int) -> s.Batches:
        """Return the batches of the next steps, by topic."""
        ...


def items_of(source: Source) -> Iterator[Item]:
    """Yield the source's messages by stamp; at one stamp in the order of OUTPUTS."""
    while True:
        batches = source.produce(CHUNK)
        rows: list[Item] = []
        for topic in OUTPUTS:
            if topic in batches:
                stamps = batches[topic].stamp_ns.tolist()
                rows += zip(stamps, repeat(topic), encode(topic, batches[topic]), strict=False)
        if not rows:
            return
        rows.sort(key=lambda row: row[0])
        yield from rows


class ShipMotion(SourceNode):
    """Publishes scene, ship/imu, ship/fix and clock/observation of a scene."""

    def __init__(self, **node_options: Any) -> None:
        super().__init__('ship_motion', 'speed', **node_options)
        if problem := self._problem(self.settings.number('speed')):
            raise ParameterError(f'{self.get_fully_qualified_name()}: {problem}')
        self.add_on_set_parameters_callback(self._check)
        scene = scene_of(self.settings)
        self.connect([], [port(topic) for topic in OUTPUTS])
        self.start(items_of(ShipSource(scene)))

    def _problem(self, speed: float) -> str:
        if speed != 0.0 or self.settings.credits:
            return ''
        return (
            'speed = 0.0: as fast as possible needs flow_control = credits, or messages are lost. '
            'Set it on all nodes, or give a speed'
        )

    def _check(self, changes: list[RosParameter]) -> SetParametersResult:
        found = [p for c in changes if c.name == 'speed' and (p := self._problem(c.value))]
        return SetParametersResult(successful=not found, reason='; '.join(found))


main = main_of(ShipMotion)

if __name__ == '__main__':
    main()
