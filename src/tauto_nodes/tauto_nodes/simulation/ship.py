"""The ship: its motion, its place and the navigator's observations, paced by wall time."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import repeat
from typing import Any

import numpy as np
from rcl_interfaces.msg import SetParametersResult
from rclpy.parameter import Parameter as RosParameter

from tauto_core import samples as s
from tauto_core.bags import encode
from tauto_core.voyage import ShipSource
from tauto_nodes import ParameterError
from tauto_nodes.live import main_of
from tauto_nodes.live.node import port
from tauto_nodes.live.player import SourceNode, StampedMessage

OUTPUTS = (s.SCENE, s.SHIP_FIX, s.SHIP_TEMPERATURE, s.OBSERVATION, s.SHIP_IMU)


def ship_messages(ship: ShipSource) -> Iterator[StampedMessage]:
    """Yield the ship's messages by stamp, and at one stamp in the order of OUTPUTS.

    The last temperature is beyond the motion, and goes with its last sample.
    """
    while True:
        batches = ship.produce(256)
        rows: list[StampedMessage] = []
        for topic in OUTPUTS:
            if topic in batches:
                last_ns = batches[s.SHIP_IMU].stamp_ns[-1]
                stamps = np.minimum(batches[topic].stamp_ns, last_ns).tolist()
                rows += zip(stamps, repeat(topic), encode(topic, batches[topic]), strict=False)
        if not rows:
            return
        rows.sort(key=lambda row: row[0])
        yield from rows


class ShipMotionNode(SourceNode):
    """Publishes scene, ship/imu, ship/fix, ship/temperature and clock/observation of a scene."""

    def __init__(self, **node_options: Any) -> None:
        super().__init__('ship_motion', 'speed', **node_options)
        refused = (
            'speed = 0.0: as fast as possible needs flow_control = credits, or messages are lost. '
            'Set it on all nodes, or give a speed'
        )
        paced = not self.settings.credits
        if paced and self.settings['speed'] == 0.0:
            raise ParameterError(f'{self.get_fully_qualified_name()}: {refused}')

        def check(changes: list[RosParameter]) -> SetParametersResult:
            bad = paced and any(c.name == 'speed' and c.value == 0.0 for c in changes)
            return SetParametersResult(successful=not bad, reason=refused if bad else '')

        self.add_on_set_parameters_callback(check)
        scene = self.settings.scene()
        self.connect([], [port(topic) for topic in OUTPUTS])
        self.start(ship_messages(ShipSource(scene)))


ship_motion = main_of(ShipMotionNode)
