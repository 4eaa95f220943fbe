"""Messages per second through the whole graph, recorded, without a loss.

    .venv/bin/python benchmarks/graph_throughput.py [--rounds 3] [--duration 14400]

Each row is a voyage flat out (`--speed max`), with packs or without. Its time runs from the first
message in the bag's file to the closed bag, without start-up; an earlier voyage has compiled the
kernels. The variants alternate over several rounds. The fastest voyage and the least CPU time
count. `messages_per_s` counts the messages that the recorder wrote, and `cpu_us` is the CPU time
of all nodes for a message, without the CPU time of a short voyage.
Results: benchmarks/graph_throughput.json. benchmarks/live.py has the latencies of a live clock.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import rclpy

from tauto_core.scene import load_scene
from tauto_nodes.simulation.supervisor import GraphPlan, run_graph

SCENE = 'second_cam_at_sea'
SHORT_S = 60.0
LOOK_S = 0.002
RECORDED_BYTES = 2000
RESULTS = Path(__file__).with_suffix('.json')
VARIANTS: dict[str, dict[str, Any]] = {
    'a process each': {},
    'a process each, not packed': {'packed': False},
}

Row = dict[str, Any]


class BagClock:
    """Sees, from outside, when a bag gets its first message and when it is closed."""

    def __init__(self, bag: Path) -> None:
        self._bag = bag
        self._began_s = self._closed_s = 0.0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)

    def __enter__(self) -> BagClock:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    @property
    def voyage_s(self) -> float:
        """Time from the first message to the closed bag [s]."""
        assert 0.0 < self._began_s < self._closed_s, f'{self._bag} was not seen to grow and close'
        return self._closed_s - self._began_s

    def _look(self) -> None:
        while not self._over.wait(LOOK_S):
            now_s = time.monotonic()
            if self._began_s == 0.0:
                sizes = (file.stat().st_size for file in self._bag.glob('*.mcap'))
                if any(size > RECORDED_BYTES for size in sizes):
                    self._began_s = now_s
            elif (self._bag / 'metadata.yaml').is_file():
                self._closed_s = now_s
                return


def sail(options: Row, duration_s: float) -> Row:
    """Return messages, losses, time and CPU time of one voyage of this length [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / 'bag'
        plan = GraphPlan(SCENE, bag, duration_s=duration_s, speed=0.0, **options)
        with BagClock(bag) as clock:
            outcome = run_graph(plan, load_scene(SCENE, duration=duration_s), lambda _: None)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return {
        'messages': sum(numbers['written'] for numbers in outcome.counts.values()),
        'lost': outcome.lost,
        'voyage_s': round(clock.voyage_s, 3),
        'cpu_s': after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
    }


def main() -> None:
    """Measure, print, write down."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--duration', type=float, default=14_400.0, help='of the voyages [s]')
    asked = parser.parse_args()
    sail({}, SHORT_S)  # compiles the kernels
    rounds = [
        {
            name: (sail(options, SHORT_S), sail(options, asked.duration))
            for name, options in VARIANTS.items()
        }
        for _ in range(asked.rounds)
    ]
    rows = []
    for name in VARIANTS:
        short, long = zip(*(voyages[name] for voyages in rounds), strict=True)
        row = min(long, key=lambda voyage: voyage['voyage_s'])
        start_s, used_s = (min(voyage['cpu_s'] for voyage in some) for some in (short, long))
        messages = row['messages'] - short[0]['messages']
        rows.append(
            {
                'variant': name,
                'messages': row['messages'],
                'lost': sum(voyage['lost'] for voyage in long),
                'voyage_s': row['voyage_s'],
                'messages_per_s': round(row['messages'] / row['voyage_s']),
                'sea_s_per_s': round(asked.duration / row['voyage_s']),
                'cpu_us': round(1e6 * (used_s - start_s) / messages, 1),
            }
        )
        print(json.dumps(rows[-1]))
    machine = {
        'cpus': os.cpu_count(),
        'load': round(os.getloadavg()[0], 1),
        'processor': platform.machine(),
        'python': platform.python_version(),
        'rmw': rclpy.get_rmw_implementation_identifier(),
    }
    result = {'scene': SCENE, 'duration_s': asked.duration, 'machine': machine, 'rows': rows}
    RESULTS.write_text(json.dumps(result, indent=2) + '\n', 'utf-8')


if __name__ == '__main__':
    main()
