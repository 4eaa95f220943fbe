"""The first use of all: no kernel is compiled yet, and the sensor is already there."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from conftest import Bench
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import Imu
from test_nodes_faults import START_NS

from tauto_core.samples import READING, SHIP_IMU
from tauto_core.scene.times import NS_PER_S
from tauto_nodes.live.node import port

RATE_HZ = 100
SECONDS = 3
DEPTH = 100
"""Of the subscription's queue, 1 s of the sensor: less than the kernels take to compile."""


class Sensor:
    """An IMU on a ship at rest, which sends at its rate."""

    def __init__(self, node: Node) -> None:
        self._publisher = node.create_publisher(Imu, SHIP_IMU, port(SHIP_IMU).profile)
        self._sent = 0
        node.create_timer(1.0 / RATE_HZ, self._send)

    def _send(self) -> None:
        message = Imu()
        message.header.frame_id = 'clock_mount'
        stamp_ns = START_NS + self._sent * NS_PER_S // RATE_HZ
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, NS_PER_S)
        message.orientation.w = 1.0
        message.linear_acceleration.z = 9.80665
        self._publisher.publish(message)
        self._sent += 1

    @property
    def is_heard(self) -> bool:
        """Whether a subscription is matched."""
        return bool(self._publisher.get_subscription_count())


def kernels_in(folder: Path) -> set[str]:
    return {file.name for file in folder.rglob('*') if file.is_file()}


def test_kernels_are_compiled_before_a_sensor_is_listened_to(bench: Bench, tmp_path: Path) -> None:
    node = bench.add(Node('xsens'))
    sensor = Sensor(node)
    said: list[DiagnosticStatus] = []
    readings: list[Any] = []
    depth = QoSProfile(depth=1000)
    node.create_subscription(
        DiagnosticArray, '/diagnostics', lambda a: said.extend(a.status), depth
    )
    node.create_subscription(port(READING).message, READING, readings.append, depth)
    values = {
        'source': 'foreign',
        'scene': 'second_cam_at_sea',
        f'qos_overrides./{SHIP_IMU}.subscription.depth': DEPTH,
    }
    arguments = [word for name, value in values.items() for word in ('-p', f'{name}:={value}')]
    cache = tmp_path / 'cache'
    process = subprocess.Popen(
        [sys.executable, '-m', 'tauto_nodes', 'trochlea', '--ros-args', *arguments],
        env={**os.environ, 'TAUTO_CACHE_DIR': str(cache)},
    )
    try:
        bench.until(lambda: sensor.is_heard or process.poll() is not None)
        compiled = kernels_in(cache)
        assert process.poll() is None
        assert compiled
        bench.until(
            lambda: any(
                one.key == f'{SHIP_IMU} received' and int(one.value) >= SECONDS * RATE_HZ
                for one in (said[-1].values if said else ())
            )
        )
        assert kernels_in(cache) == compiled
        assert said[-1].level == DiagnosticStatus.OK, said[-1].message
        # Readings a second apart: no sample in between was lost.
        assert len(readings) >= SECONDS - 1
        stamps = [reading.header.stamp.sec for reading in readings]
        assert stamps == list(range(stamps[0], stamps[0] + len(stamps)))
    finally:
        process.terminate()
        assert process.wait(300.0) == 0
