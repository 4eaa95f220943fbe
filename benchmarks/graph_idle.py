"""What nodes that wait for messages cost: CPU time of each process, in percent of a core.

    .venv/bin/python benchmarks/graph_idle.py [--seconds 60]

All nodes of a live clock run without a sensor, each in its process, in a free domain and with the
middleware's own profile, as live.launch.py starts them, and beside them a node of rclpy with one
timer of a second. It begins `SETTLE_S` after all of them are up, however long they take to start.
The main thread is that of Python; the others are those of the middleware. A recorder as it is by
default records /diagnostics, too, that is, a message a second of each node; one with the topics of
the table alone gets nothing.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import rclpy

from tauto_core.bags import TOPICS
from tauto_nodes.live import DOMAIN, local_discovery
from tauto_nodes.simulation import claim_domain

SETTLE_S = 10.0
FOREIGN = ('-p', 'source:=foreign')
BARE = (
    'import rclpy, rclpy.experimental.events_executor as e, rclpy.task as t\n'
    'rclpy.init(); node = rclpy.create_node("bare"); node.create_timer(1.0, lambda: None)\n'
    'executor = e.EventsExecutor(); executor.add_node(node)\n'
    'executor.spin_until_future_complete(t.Future(), 3600.0)'
)


def commands(folder: Path) -> dict[str, list[str]]:
    """Return the command of each node."""
    topics = f'topics:=[{", ".join(TOPICS)}]'
    arguments = {
        'trochlea': FOREIGN,
        'drift_estimator': FOREIGN,
        'longitude': FOREIGN,
        'markers': (),
        'recorder': (),
        'recorder, single': ('-p', 'executor:=single'),
        'recorder, table': ('-p', topics),
        'recorder, table, single': ('-p', topics, '-p', 'executor:=single'),
    }
    run = [sys.executable, '-m', 'tauto_nodes']
    found = {}
    for number, (name, each) in enumerate(arguments.items()):
        role = name.partition(',')[0]
        own = ['-r', f'__node:={role}_{number}']
        if role == 'recorder':
            own += ['-p', f'output:={folder / str(number)}']
        found[name] = [*run, role, '--ros-args', *own, *each]
    return {**found, 'rclpy, one timer': [sys.executable, '-c', BARE]}


def cpu_s(pid: int) -> tuple[float, float]:
    """Return the CPU time that a process has used so far, and that of its main thread [s]."""
    found = []
    for stat in (f'/proc/{pid}/stat', f'/proc/{pid}/task/{pid}/stat'):
        words = Path(stat).read_text('utf-8').rpartition(')')[2].split()
        found.append(sum(map(int, words[11:13])) / os.sysconf('SC_CLK_TCK'))
    return found[0], found[1]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, default=60.0, help='of each measurement')
    asked = parser.parse_args()
    domain = claim_domain()
    environment = {**os.environ, **local_discovery(), DOMAIN: str(domain.number)}
    with tempfile.TemporaryDirectory() as folder:
        nodes = {
            name: subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL)
            for name, command in commands(Path(folder)).items()
        }
        try:
            os.environ.update(environment)
            rclpy.init()
            onlooker: Any = rclpy.create_node('onlooker')
            while (  # a node says how it is once it is ready
                onlooker.count_publishers('/diagnostics') < len(nodes) - 1
                or 'bare' not in onlooker.get_node_names()
            ):
                time.sleep(0.1)
            onlooker.destroy_node()
            time.sleep(SETTLE_S)
            before = {name: cpu_s(node.pid) for name, node in nodes.items()}
            time.sleep(asked.seconds)
            for name, node in nodes.items():
                pairs = zip(cpu_s(node.pid), before[name], strict=True)
                whole, main = (100.0 * (now - then) / asked.seconds for now, then in pairs)
                print(f'{name:23} {whole:5.2f} %, its main thread {main:5.2f} %', flush=True)
            print(f'load {os.getloadavg()[0]:.0f}')
        finally:
            for node in nodes.values():
                node.terminate()
            for node in nodes.values():
                node.wait()


if __name__ == '__main__':
    main()
