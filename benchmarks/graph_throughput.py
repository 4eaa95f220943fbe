"""Messages per second through the whole graph, recorded, without losing any.

    .venv/bin/python benchmarks/graph_throughput.py [--rounds 3] [--beside TREE]

Each row is a voyage flat out (`--speed max`), from the first message in the bag's file to the
closed bag, both seen from outside and so in the same way for each build. It is without start-up
and, since a first run has compiled the kernels, without compilation. Builds and variants alternate
over several rounds; the fastest and the least CPU time count. `--beside` names another tree of
this repository, such as a git worktree of an earlier commit. Its rows are given beside ours, and
`times` is the ratio of its rate, and of its CPU time per message, to ours.

`messages_per_s` counts the messages that the recorder wrote; each ship/imu also goes to the
trochlea. Where they are packed, one ROS message carries many of them: `ros_messages_per_s` counts
what all nodes published, a pack as one. `cpu_us` is the CPU time of all nodes per message, without
start-up. `ours` is the share of our code and its libraries in the nodes' CPU time while they spin;
the rest is rclpy and DDS.
Results: benchmarks/graph_throughput.json. benchmarks/live.py has the latencies of a live clock.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Mapping
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


def environment_of(tree: Path | None, samples: Path | None = None) -> dict[str, str]:
    """Return the environment of a process that runs a build; ours by default.

    Args:
        tree: root of its repository.
        samples: folder into which the process and its children write samples of themselves.
    """
    paths = [tree / 'src/tauto_core', tree / 'src/tauto_nodes'] if tree is not None else []
    given = dict(os.environ)
    if samples is not None:
        paths.insert(0, Path(__file__).with_name('sampling'))
        given['TAUTO_SAMPLES'] = str(samples)
    before = given.get('PYTHONPATH', '')
    given['PYTHONPATH'] = os.pathsep.join([*map(str, paths), *([before] if before else [])])
    return given


def ask(environment: Mapping[str, str], *words: str) -> Any:
    """Return the output of this program in a process of its own."""
    done = subprocess.run(
        [sys.executable, __file__, *words], env=environment, stdout=subprocess.PIPE, check=True
    )
    return json.loads(done.stdout)


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


def sail(options: Row, duration_s: float) -> None:
    """Print the figures of one voyage of this length [s] (`--sail`); null if this build cannot."""
    known = {field.name for field in dataclasses.fields(GraphPlan)}
    if not options.keys() <= known:
        print('null')
        return
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / 'bag'
        plan = GraphPlan(SCENE, bag, duration_s=duration_s, speed=0.0, **options)
        with BagClock(bag) as clock:
            outcome = run_graph(plan, load_scene(SCENE, duration=duration_s), lambda _: None)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    figures = {
        'messages': sum(numbers['written'] for numbers in outcome.counts.values()),
        'lost': outcome.lost,
        'voyage_s': round(clock.voyage_s, 3),
        'cpu_s': used.ru_utime + used.ru_stime,
    }
    print(json.dumps(figures))


def measure(tree: Path | None, options: Row, duration_s: float) -> Row | None:
    """Return the figures of one voyage, its CPU time without that of start-up."""
    environment, words = environment_of(tree), json.dumps(options)
    short, row = (
        ask(environment, '--sail', words, '--duration', str(length_s))
        for length_s in (SHORT_S, duration_s)
    )
    if row is None:
        return None
    used_s = row.pop('cpu_s') - short['cpu_s']
    return {
        **row,
        'messages_per_s': round(row['messages'] / row['voyage_s']),
        'sea_s_per_s': round(duration_s / row['voyage_s']),
        'cpu_us': round(1e6 * used_s / (row['messages'] - short['messages']), 1),
    }


def better(best: Row | None, row: Row) -> Row:
    """Return the faster of two rows, with the least CPU time of both and the sum of losses."""
    if best is None:
        return row
    fast = max(best, row, key=lambda one: one['messages_per_s'])
    least_us = min(best['cpu_us'], row['cpu_us'])
    return {**fast, 'cpu_us': least_us, 'lost': best['lost'] + row['lost']}


def sampled(tree: Path | None, options: Row, duration_s: float) -> tuple[float, int]:
    """Return the share of our code in the CPU time of spinning nodes, and what they published."""
    with tempfile.TemporaryDirectory(prefix='tauto_samples_') as folder:
        environment = environment_of(tree, Path(folder))
        ask(environment, '--sail', json.dumps(options), '--duration', str(duration_s))
        counts: Counter[str] = Counter()
        for file in Path(folder).glob('*.json'):
            counts.update(json.loads(file.read_text('utf-8')))
    published = counts.pop('published')
    return round(counts['ours'] / counts.total(), 2), published


def compare(rows: list[Row]) -> list[Row]:
    """Return the ratios of the other build to ours, for each variant that both have."""
    found = {(row['build'], row['variant']): row for row in rows}
    return [
        {
            'variant': variant,
            'messages_per_s': round(row['messages_per_s'] / old['messages_per_s'], 2),
            'cpu_us': round(row['cpu_us'] / old['cpu_us'], 2),
        }
        for (build, variant), row in found.items()
        if build == 'ours' and (old := found.get(('beside', variant)))
    ]


def run(asked: argparse.Namespace) -> Row:
    """Measure all variants of all builds, in turn."""
    builds: dict[str, Path | None] = {'ours': None}
    if asked.beside:
        builds['beside'] = asked.beside.resolve()
    cases = [(build, variant) for variant in asked.variants for build in builds]
    best: dict[tuple[str, str], Row] = {}
    for tree in builds.values():
        measure(tree, {}, SHORT_S + 1.0)  # compiles the kernels
    for _ in range(asked.rounds):
        for case in cases:
            row = measure(builds[case[0]], VARIANTS[case[1]], asked.duration)
            if row is not None:
                best[case] = better(best.get(case), row)
    rows = []
    for (build, variant), row in best.items():
        ours, published = sampled(builds[build], VARIANTS[variant], asked.duration)
        each = {'ros_messages': published, 'ours': ours}
        each['ros_messages_per_s'] = round(published / row['voyage_s'])
        rows.append({'build': build, 'variant': variant, **row, **each})
        print(json.dumps(rows[-1]), flush=True)
    return {'rows': rows, 'times': compare(rows)}


def main() -> None:
    """Measure, print, write down."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--duration', type=float, default=3600.0, help='of the voyages [s]')
    parser.add_argument('--variants', nargs='+', default=list(VARIANTS), choices=VARIANTS)
    parser.add_argument('--beside', type=Path, help='another tree of the repository')
    parser.add_argument('--sail', type=json.loads, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.sail is not None:
        sail(asked.sail, asked.duration)
        return
    found = run(asked)
    machine = {
        'cpus': os.cpu_count(),
        'load': round(os.getloadavg()[0], 1),
        'processor': platform.machine(),
        'python': platform.python_version(),
        'rmw': rclpy.get_rmw_implementation_identifier(),
    }
    result = {'scene': SCENE, 'duration_s': asked.duration, 'machine': machine, **found}
    RESULTS.write_text(json.dumps(result, indent=2) + '\n', 'utf-8')


if __name__ == '__main__':
    main()
