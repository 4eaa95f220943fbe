"""An hour flat out: memory must stay constant, nothing may be lost, the bag must be readable.

    .venv/bin/python benchmarks/soak.py [--minutes 60] [--scene second_cam_at_sea]

The voyage has no end; after --minutes it is stopped as by Ctrl-C. The resident memory of each node
is sampled once a second; the first quarter, at least 30 s, is warm-up. Results:
benchmarks/soak.json. The exit code is 1 if a node grows by more than 5 MB over its memory at the
end of the warm-up (it may shrink, since systems take idle pages back), the stamps of a topic have
a gap, or the bag is damaged.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from tauto_core.bags.check import check_bag
from tauto_core.bags.read import open_mcap
from tauto_core.samples import OBSERVATION
from tauto_core.scene import load_scene
from tauto_nodes.simulation.supervisor import NODE_NAMES, GraphPlan, Outcome, run_graph

GROWTH_MB = 5.0
LOOK_S = 1.0
ENDLESS_S = 1e8
LEAST_WARM_S = 30.0
WARM_PART = 0.25
"""Queues find their largest size when the machine first keeps a node waiting, which is chance."""

RESULTS = Path(__file__).with_suffix('.json')


class Memory:
    """Samples the resident memory of this process' nodes until it is stopped."""

    def __init__(self) -> None:
        self.seen: dict[str, list[tuple[float, float]]] = {}
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)

    def __enter__(self) -> Memory:
        self._began_s = time.monotonic()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _look(self) -> None:
        page_mb = os.sysconf('SC_PAGE_SIZE') / 1e6
        while not self._over.wait(LOOK_S):
            at_s = time.monotonic() - self._began_s
            for status in Path('/proc').glob('[0-9]*/stat'):
                try:
                    parent = int(status.read_text().rpartition(')')[2].split()[1])
                    words = os.fsdecode(status.with_name('cmdline').read_bytes()).split('\0')
                    pages = int(status.with_name('statm').read_text().split()[1])
                except (OSError, IndexError):
                    continue
                if parent == os.getpid() and 'tauto_nodes' in words[:-1]:
                    node = words[words.index('tauto_nodes') + 1]
                    self.seen.setdefault(node, []).append((at_s, pages * page_mb))

    def bands(self, warm_s: float) -> dict[str, dict[str, Any]]:
        """Return by node the memory [MB] at the end of the warm-up, and the range after it.

        `tenths_mb` are the medians of the tenths of that time: they tell growth from waves.
        """
        found = {}
        for node, rows in self.seen.items():
            after = [mb for at_s, mb in rows if at_s >= warm_s]
            if after:
                found[node] = {
                    'warm_mb': round(after[0], 1),
                    'least_mb': round(min(after), 1),
                    'most_mb': round(max(after), 1),
                    'tenths_mb': [
                        round(float(np.median(part)), 1) for part in np.array_split(after, 10)
                    ],
                }
        return found


def sail(plan: GraphPlan, minutes: float) -> tuple[Outcome, dict[str, dict[str, Any]]]:
    """Sail for so long; return what came of it and the memory of the nodes."""
    scene = load_scene(plan.scene, duration=plan.duration_s)
    stop = threading.Timer(60.0 * minutes, os.kill, (os.getpid(), signal.SIGINT))
    stop.daemon = True

    def begin(share: float) -> None:
        if share > 0.0 and stop.ident is None:
            stop.start()

    with Memory() as memory:
        outcome = run_graph(plan, scene, begin)
    warm_s = outcome.start_s + max(LEAST_WARM_S, WARM_PART * outcome.voyage_s)
    return outcome, memory.bands(warm_s)


def gaps_in(bag: Path) -> dict[str, int]:
    """Return for each topic the number of irregular steps of its stamps, except for observations.

    A topic of the clock or the ship has one message for each step of the scene.
    """
    file = open_mcap(next(bag.glob('*.mcap')))
    steps: dict[int, Counter[int]] = {channel: Counter() for channel in file.channels}
    last_ns: dict[int, int] = {}
    with file.path.open('rb') as stream:
        for span in file.spans:
            for stamp_ns, channel, _ in file.messages(span, stream):
                if channel in last_ns:
                    steps[channel][round((stamp_ns - last_ns[channel]) / 1e6)] += 1
                last_ns[channel] = stamp_ns
    return {
        file.channels[channel].topic: found.total() - max(found.values())
        for channel, found in steps.items()
        if found and not file.channels[channel].topic.endswith(OBSERVATION)
    }


def main() -> int:
    """Sail, check memory, gaps and the bag; print and write the outcome."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--minutes', type=float, default=60.0)
    parser.add_argument('--scene', default='second_cam_at_sea')
    parser.add_argument('--out', type=Path, help='folder for the bag; default: a temporary one')
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix='tauto_soak_') as temporary:
        bag = (asked.out or Path(temporary)) / 'soak'
        plan = GraphPlan(asked.scene, bag, ENDLESS_S, 0.0, True)
        outcome, bands = sail(plan, asked.minutes)
        print(json.dumps(bands), flush=True)
        sound, gaps = check_bag(bag), gaps_in(bag)
        size_mb = sum(file.stat().st_size for file in bag.iterdir()) / 1e6
    flat = set(bands) == set(NODE_NAMES) and all(
        band['most_mb'] - band['warm_mb'] <= GROWTH_MB for band in bands.values()
    )
    written = sum(numbers['written'] for numbers in outcome.counts.values())
    damage = [*sound.damage, *sound.faults]
    result = {
        'scene': asked.scene,
        'minutes': round(outcome.voyage_s / 60.0, 1),
        'messages': written,
        'messages_per_s': round(written / outcome.voyage_s),
        'load': round(os.getloadavg()[0], 1),
        'gaps': gaps,
        'bag_mb': round(size_mb, 1),
        'damage': damage,
        'memory': bands,
        'memory_is_flat': flat,
    }
    print(json.dumps(result, indent=2))
    RESULTS.write_text(json.dumps(result, indent=2) + '\n', 'utf-8')
    return 0 if flat and not damage and not any(gaps.values()) else 1


if __name__ == '__main__':
    sys.exit(main())
