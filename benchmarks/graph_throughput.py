"""How many messages a second go through the whole graph, recorded, without losing one.

    .venv/bin/python benchmarks/graph_throughput.py [--rounds 3] [--duration 3600]

Each row is a voyage flat out (`--speed max`), from the first message to the closed bag, without
start-up and, since a first run has compiled the kernels, without compilation; of several rounds,
one variant after the other, the fastest. `messages_per_s` counts what the recorder wrote; each
ship/imu also goes to the trochlea. `cpu_us` is the CPU time of all processes over a message,
start-up taken off. `ours` is the share of our code and its libraries in the nodes' CPU time while
they spin; the rest is rclpy and DDS. `latency` is the time from the stamp of a message of a 100 Hz
sensor, sent by this process, to its receipt by another one through rclpy, and to the receipt here
of the reading that it leads to, for which the clock needs later samples too.
Results: benchmarks/graph_throughput.json.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future

from tauto_core.bags import encode, header_stamp_ns
from tauto_core.samples import NS_PER_S, READING, SHIP_IMU
from tauto_core.scene import load_scene
from tauto_core.ship.imu import imu_from_roll
from tauto_nodes.graph import Plan, graph_environment, run_graph
from tauto_nodes.qos import port
from tauto_nodes.running import executor_named

SCENE = 'second_cam_at_sea'
SHORT_S = 60.0
RATE_HZ = 100
LATENCY_S = 20.0
RESULTS = Path(__file__).with_suffix('.json')
VARIANTS: dict[str, dict[str, Any]] = {
    'a process each': {},
    'a process each, not packed': {'packed': False},
    'one process': {'compose': True},
    'one process, not packed': {'compose': True, 'packed': False},
    'a process each, single-threaded executor': {'executor': 'single'},
}


def cpu_s() -> float:
    """Return the CPU time of all children that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def sail(plan: Plan, duration_s: float) -> dict[str, Any]:
    """Return the figures of one voyage of this length [s]."""
    plan, before_s = replace(plan, duration_s=duration_s), cpu_s()
    outcome = run_graph(plan, load_scene(plan.scene, duration=duration_s), lambda _: None)
    return {
        'messages': sum(numbers['written'] for numbers in outcome.counts.values()),
        'lost': outcome.lost,
        'voyage_s': round(outcome.voyage_s, 3),
        'start_s': round(outcome.start_s, 3),
        'cpu_s': cpu_s() - before_s,
    }


def measure(plan: Plan, duration_s: float) -> dict[str, Any]:
    """Return the figures of one voyage, with what start-up costs taken off its CPU time."""
    short, row = sail(plan, SHORT_S), sail(plan, duration_s)
    used_s = row.pop('cpu_s') - short['cpu_s']
    return {
        **row,
        'messages_per_s': round(row['messages'] / row['voyage_s']),
        'sea_s_per_s': round(duration_s / row['voyage_s']),
        'cpu_us': round(1e6 * used_s / (row['messages'] - short['messages']), 1),
    }


@contextmanager
def sampled(folder: Path) -> Any:
    """Let the children of this process sample themselves into a folder."""
    before = os.environ.get('PYTHONPATH', '')
    here = Path(__file__).with_name('sampling')
    given = {'TAUTO_SAMPLES': str(folder), 'PYTHONPATH': f'{here}:{before}'.rstrip(':')}
    os.environ.update(given)
    try:
        yield
    finally:
        del os.environ['TAUTO_SAMPLES']
        os.environ['PYTHONPATH'] = before


def share_of_ours(plan: Plan, duration_s: float) -> float:
    """Return the share of our code in the CPU time of the nodes while they spin."""
    with tempfile.TemporaryDirectory(prefix='tauto_samples_') as folder:
        with sampled(Path(folder)):
            sail(plan, duration_s)
        counts: Counter[str] = Counter()
        for file in Path(folder).glob('*.json'):
            counts.update(json.loads(file.read_text('utf-8')))
    return counts['ours'] / counts.total()


def percentiles_ms(waits_ns: list[int]) -> dict[str, float]:
    """Return the median and the 99th percentile [ms]."""
    p50, p99 = np.percentile(waits_ns, [50, 99]) / 1e6
    return {'p50_ms': round(float(p50), 2), 'p99_ms': round(float(p99), 2), 'n': len(waits_ns)}


def listen(count: int) -> None:
    """Print how long so many messages of the sensor were under way [ns] (`--listen`)."""
    rclpy.init()
    node, executor = Node('listener'), executor_named('events')
    executor.add_node(node)
    waits: list[int] = []
    known = port(SHIP_IMU)
    node.create_subscription(
        known.message,
        SHIP_IMU,
        lambda octets: waits.append(time.time_ns() - header_stamp_ns(octets)),
        known.profile,
        raw=True,
    )
    while len(waits) < count:
        executor.spin_until_future_complete(Future(), 0.2)
    print(json.dumps(waits))


def latency() -> dict[str, Any]:
    """Return how long a sensor's messages, and the readings they lead to, are under way."""
    count = round(RATE_HZ * LATENCY_S)
    with graph_environment():
        modules = (
            ['-m', 'tauto_nodes.trochlea', '--ros-args', '-p', 'source:=foreign'],
            [__file__, '--listen', str(count - RATE_HZ)],
        )
        clock, listener = (
            subprocess.Popen([sys.executable, *words], stdout=subprocess.PIPE, text=True)
            for words in modules
        )
        try:
            waits = _send(count)
            under_way = json.loads(listener.communicate(timeout=60.0)[0])
        finally:
            listener.kill()
            clock.terminate()
            clock.wait(60.0)
    return {'ship/imu': percentiles_ms(under_way), 'clock/reading': percentiles_ms(waits)}


def _send(count: int) -> list[int]:
    """Be the sensor; return how long after their stamps readings have come back [ns]."""
    rclpy.init()
    node, executor = Node('sensor'), executor_named('events')
    executor.add_node(node)
    imu, reading = port(SHIP_IMU), port(READING)
    publisher = node.create_publisher(imu.message, SHIP_IMU, imu.profile)
    waits: list[int] = []
    node.create_subscription(
        reading.message,
        READING,
        lambda octets: waits.append(time.time_ns() - header_stamp_ns(octets)),
        QoSProfile(depth=100),
        raw=True,
    )
    while publisher.get_subscription_count() < 2:
        executor.spin_until_future_complete(Future(), 0.05)
    none, began_ns = np.zeros(1), time.time_ns()
    for number in range(count):
        due_ns = began_ns + number * NS_PER_S // RATE_HZ
        while (left_ns := due_ns - time.time_ns()) > 0:
            executor.spin_until_future_complete(Future(), min(left_ns / 1e9, 0.002))
        stamp = np.array([time.time_ns()])
        publisher.publish(encode(SHIP_IMU, imu_from_roll(stamp, none, none, none, none + 9.81))[0])
    node.destroy_node()
    rclpy.try_shutdown()
    return waits


def main() -> None:
    """Measure all variants, print them, write them down."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--duration', type=float, default=3600.0, help='of the voyages [s]')
    parser.add_argument('--listen', type=int, default=0, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.listen:
        listen(asked.listen)
        return
    best: dict[str, dict[str, Any]] = {}
    with tempfile.TemporaryDirectory() as folder:
        plan = Plan(SCENE, Path(folder) / 'bag', speed=0.0, force=True)
        sail(plan, SHORT_S)
        for _ in range(asked.rounds):
            for name, options in VARIANTS.items():
                row = measure(replace(plan, **options), asked.duration)
                if name not in best or row['messages_per_s'] > best[name]['messages_per_s']:
                    best[name] = row
        for name, options in VARIANTS.items():
            ours = share_of_ours(replace(plan, **options), asked.duration)
            best[name] = {'variant': name, **best[name], 'ours': round(ours, 2)}
            print(json.dumps(best[name]), flush=True)
    waits = latency()
    print(json.dumps(waits))
    machine = {
        'cpus': os.cpu_count(),
        'load': round(os.getloadavg()[0], 1),
        'processor': platform.machine(),
        'python': platform.python_version(),
        'rmw': rclpy.get_rmw_implementation_identifier(),
    }
    result = {
        'scene': SCENE,
        'duration_s': asked.duration,
        'machine': machine,
        'rows': list(best.values()),
        'latency': waits,
    }
    RESULTS.write_text(json.dumps(result, indent=2) + '\n', 'utf-8')


if __name__ == '__main__':
    main()
