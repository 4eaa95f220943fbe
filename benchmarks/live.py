"""What a live clock costs, and how late it is, beside a minimal pipeline of rclpy in the same run.

    .venv/bin/python benchmarks/live.py [--seconds 60] [--rate 100] [--out benchmarks/live.json]

Each node is a process of its own, as live.launch.py starts it, in a free domain. A sensor
publishes ship/imu with the time of sending as its stamp, best effort. The minimal pipeline is
three nodes of plain rclpy with a message class in each callback: the first answers the first
sample of each second on min/reading, the others hand it on. A latency is the time of receipt less
the stamp of the reading, which is that of the sample due then. CPU is of one core, over the same
time; *idle* has no sensor. A busy machine lengthens all of them: compare within a run.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import TimeReference

from tauto_core.bags import encode, header_stamp_ns
from tauto_core.samples import SHIP_IMU
from tauto_core.ship.imu import imu_from_roll
from tauto_nodes.live import DOMAIN, executor_named, local_discovery
from tauto_nodes.live.node import port
from tauto_nodes.simulation import claim_domain

SETTLE_S = 8.0
CHAIN = ('reading', 'estimate', 'error')
TOPICS = {
    'tauto': ('clock/reading', 'drift/estimate', 'longitude/error'),
    'minimal': tuple(f'min/{name}' for name in CHAIN),
}
MINIMAL = """
import sys
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Imu, TimeReference

came, said = sys.argv[1:]
rclpy.init()
node = rclpy.create_node('minimal_' + said.rpartition('/')[2])
publisher = node.create_publisher(TimeReference, said, 10)
last = 0

def hear(message):
    global last
    if came != 'ship/imu' or message.header.stamp.sec != last:
        last = message.header.stamp.sec
        publisher.publish(TimeReference(header=message.header))

kind, qos = (Imu, qos_profile_sensor_data) if came == 'ship/imu' else (TimeReference, 10)
node.create_subscription(kind, came, hear, qos)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""


def commands(folder: Path, scene: str) -> dict[str, list[str]]:
    """Return the command of each process."""
    sensor = ('-p', 'imu_reliability:=best_effort')
    foreign = ('-p', 'source:=foreign', '-p', f'scene:={scene}')
    arguments = {
        'trochlea': (*foreign, *sensor),
        'drift_estimator': foreign,
        'longitude': foreign,
        'recorder': ('-p', f'output:={folder / "bag"}', '-p', 'executor:=single', *sensor),
    }
    nodes = {
        role: [sys.executable, '-m', 'tauto_nodes', role, '--ros-args', *own]
        for role, own in arguments.items()
    }
    heard = [SHIP_IMU, *TOPICS['minimal']]
    for name, came, said in zip(CHAIN, heard, TOPICS['minimal'], strict=False):
        nodes[f'minimal {name}'] = [sys.executable, '-c', MINIMAL, came, said]
    return nodes


def cpu_s(pid: int) -> float:
    """Return the CPU time that a process has used so far [s]."""
    words = Path(f'/proc/{pid}/stat').read_text('utf-8').rpartition(')')[2].split()
    return sum(map(int, words[11:13])) / os.sysconf('SC_CLK_TCK')


def percent(
    nodes: dict[str, subprocess.Popen[bytes]], wait: Callable[[], None]
) -> dict[str, float]:
    """Return the CPU of each process while something is waited for, in percent of a core."""
    began_s, before = time.monotonic(), {name: cpu_s(node.pid) for name, node in nodes.items()}
    wait()
    elapsed_s = time.monotonic() - began_s
    return {
        name: round(100.0 * (cpu_s(node.pid) - before[name]) / elapsed_s, 2)
        for name, node in nodes.items()
    }


def latencies(executor: Any, node: Any, seconds: float, rate_hz: float) -> dict[str, list[float]]:
    """Publish motion for a time; return p50 and the greatest latency of each topic [ms]."""
    late: dict[str, list[float]] = {}

    def listen(topic: str) -> None:
        kind = TimeReference if topic.startswith('min') else port(topic).message
        late[topic] = []

        def hear(octets: bytes) -> None:
            late[topic].append((time.time_ns() - header_stamp_ns(octets)) * 1e-6)

        node.create_subscription(kind, topic, hear, QoSProfile(depth=100), raw=True)

    for topic in (*TOPICS['tauto'], *TOPICS['minimal']):
        listen(topic)
    publisher = node.create_publisher(port(SHIP_IMU).message, SHIP_IMU, qos_profile_sensor_data)
    while publisher.get_subscription_count() < 3:
        executor.spin_until_future_complete(rclpy.task.Future(), 0.1)
    start_ns = (time.time_ns() // 10**9 + 2) * 10**9
    t = np.arange(round(seconds * rate_hz)) / rate_hz
    roll, rate = 0.12 * np.sin(np.pi / 4 * t), 0.03 * np.pi * np.cos(np.pi / 4 * t)
    stamps = start_ns + np.rint(t * 1e9).astype(np.int64)
    motion = imu_from_roll(stamps, roll, rate, 9.81 * np.sin(roll), 9.81 * np.cos(roll))
    for stamp_ns, octets in zip(stamps.tolist(), encode(SHIP_IMU, motion), strict=True):
        while (left_s := (stamp_ns - time.time_ns()) * 1e-9) > 0.0:
            executor.spin_until_future_complete(rclpy.task.Future(), left_s)
        publisher.publish(octets)
    # the first readings wait for the test of the sensor
    kept = {topic: values[5:] for topic, values in late.items()}
    return {t: [round(float(f(v)), 1) for f in (np.median, np.max)] for t, v in kept.items() if v}


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, default=60.0, help='of the measurement')
    parser.add_argument('--rate', type=float, default=100.0, help='of the sensor [Hz]')
    parser.add_argument('--scene', default='measured', help='of the clock')
    parser.add_argument('--out', type=Path, default=Path(__file__).with_suffix('.json'))
    asked = parser.parse_args()
    domain = claim_domain()
    os.environ.update({**local_discovery(), DOMAIN: str(domain.number)})
    with tempfile.TemporaryDirectory() as folder:
        began_s = time.monotonic()
        nodes = {
            name: subprocess.Popen(command, stderr=subprocess.DEVNULL)
            for name, command in commands(Path(folder), asked.scene).items()
        }
        try:
            rclpy.init()
            node: Any = rclpy.create_node('sensor')
            executor = executor_named('events')
            executor.add_node(node)
            while (
                node.count_publishers('/diagnostics') < 4  # the minimal nodes have none
                or not node.count_publishers('min/error')
            ):
                if ended := [
                    name for name, process in nodes.items() if process.poll() is not None
                ]:
                    raise SystemExit(f'{", ".join(ended)} ended. Run the node alone to see why')
                time.sleep(0.1)
            start_s = round(time.monotonic() - began_s, 1)
            time.sleep(SETTLE_S)
            idle = percent(nodes, lambda: time.sleep(0.3 * asked.seconds))
            late: dict[str, list[float]] = {}
            busy = percent(
                nodes, lambda: late.update(latencies(executor, node, asked.seconds, asked.rate))
            )
        finally:
            for process in nodes.values():
                process.terminate()
            for process in nodes.values():
                process.wait()
    result = {
        'sensor_hz': asked.rate,
        'seconds': asked.seconds,
        'load': round(os.getloadavg()[0], 1),
        'start_s': start_s,
        'latency_ms_p50_max': late,
        'cpu_percent': busy,
        'cpu_percent_idle': idle,
    }
    kept = json.loads(asked.out.read_text('utf-8')) if asked.out.exists() else {}
    text = json.dumps({**kept, asked.scene: result}, indent=1) + '\n'
    sys.stdout.write(text)
    asked.out.write_text(text, 'utf-8')


if __name__ == '__main__':
    main()
