"""The first use of all: no kernel is compiled yet, and the sensor is already there."""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import count
from pathlib import Path
from typing import Any

from conftest import Bench, publish, publisher_of, still_sensor
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.qos import QoSProfile

from tauto_core.samples import READING, SHIP_IMU
from tauto_nodes.live.node import port

RATE_HZ = 100
SECONDS = 3
DEPTH = 100
"""Of the subscription's queue, 1 s of the sensor: less than the kernels take to compile."""


def kernels_in(folder: Path) -> set[str]:
    return {file.name for file in folder.rglob('*') if file.is_file()}


def test_kernels_are_compiled_before_a_sensor_is_listened_to(bench: Bench, tmp_path: Path) -> None:
    node = bench.add(Node('xsens'))
    publisher, sent = publisher_of(node, SHIP_IMU), count()

    def send() -> None:
        publish(publisher, still_sensor(1.0 / RATE_HZ, next(sent) / RATE_HZ, RATE_HZ))

    node.create_timer(1.0 / RATE_HZ, send)
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
        bench.until(lambda: publisher.get_subscription_count() or process.poll() is not None)
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
        bench.until(lambda: len(readings) >= SECONDS - 1)
        stamps = [reading.header.stamp.sec for reading in readings]
        assert stamps == list(range(stamps[0], stamps[0] + len(stamps)))
    finally:
        process.terminate()
        assert process.wait(300.0) == 0
