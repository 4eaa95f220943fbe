"""A long voyage flat out: memory stays flat, nothing is lost, the bag is whole.

    .venv/bin/python benchmarks/soak.py [--minutes 60] [--scene second_cam_at_sea] [--compose]

A voyage of ten hours tells how fast this machine sails; the long one then lasts about --minutes.
The resident memory of each node is looked at once a second. Warm-up is the first tenth, at least
30 s.
Results: benchmarks/soak.json. The exit code is 1 if the memory of a node leaves a band of 5 MB
about its value at the end of the warm-up, a message was lost or the bag is not whole.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

from tauto_core.bags.soundness import check_bag
from tauto_core.scene import load_scene
from tauto_nodes.graph import NODES, Plan, run_graph

BAND_MB = 5.0
LOOK_S = 1.0
TRIAL_S = 36_000.0
LEAST_WARM_S = 30.0
RESULTS = Path(__file__).with_suffix('.json')


class Memory:
    """Looks at the resident memory of this process' nodes until it is stopped."""

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
                    words = status.with_name('cmdline').read_bytes().decode().split('\0')
                    pages = int(status.with_name('statm').read_text().split()[1])
                except (OSError, IndexError):
                    continue
                names = [word for word in words if word.startswith('tauto_nodes.')]
                if parent == os.getpid() and names:
                    node = names[0].partition('.')[2]
                    self.seen.setdefault(node, []).append((at_s, pages * page_mb))

    def bands(self, warm_s: float) -> dict[str, dict[str, float]]:
        """Return by node the memory [MB] at the end of the warm-up, and the range after it."""
        found = {}
        for node, rows in self.seen.items():
            after = [mb for at_s, mb in rows if at_s >= warm_s]
            if after:
                found[node] = {
                    'warm_mb': round(after[0], 1),
                    'least_mb': round(min(after), 1),
                    'most_mb': round(max(after), 1),
                }
        return found


def voyage(plan: Plan, duration_s: float) -> Any:
    """Sail this long."""
    scene = load_scene(plan.scene, duration=duration_s)
    return run_graph(
        Plan(plan.scene, plan.out, duration_s, 0.0, True, plan.compose), scene, lambda _: None
    )


def main() -> int:
    """Sail, look at memory, losses and the bag; print and write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--minutes', type=float, default=60.0)
    parser.add_argument('--scene', default='second_cam_at_sea')
    parser.add_argument('--compose', action='store_true')
    parser.add_argument('--out', type=Path, help='folder for the bag; default: a temporary one')
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix='tauto_soak_') as temporary:
        bag = (asked.out or Path(temporary)) / 'soak'
        plan = Plan(asked.scene, bag, compose=asked.compose)
        trial = voyage(plan, TRIAL_S)
        duration_s = max(TRIAL_S, TRIAL_S * asked.minutes * 60.0 / trial.voyage_s)
        with Memory() as memory:
            outcome = voyage(plan, float(round(duration_s)))
        sound = check_bag(bag)
        size_mb = sum(file.stat().st_size for file in bag.iterdir()) / 1e6
    warm_s = outcome.start_s + max(LEAST_WARM_S, 0.1 * outcome.voyage_s)
    bands = memory.bands(warm_s)
    expected = ('compose',) if asked.compose else NODES
    flat = set(bands) == set(expected) and all(
        abs(band[end] - band['warm_mb']) <= BAND_MB
        for band in bands.values()
        for end in ('least_mb', 'most_mb')
    )
    written = sum(numbers['written'] for numbers in outcome.counts.values())
    result = {
        'scene': asked.scene,
        'compose': asked.compose,
        'minutes': round(outcome.voyage_s / 60.0, 1),
        'messages': written,
        'messages_per_s': round(written / outcome.voyage_s),
        'lost': outcome.lost,
        'bag_mb': round(size_mb, 1),
        'bag_is_whole': sound.whole,
        'memory': bands,
        'memory_is_flat': flat,
    }
    print(json.dumps(result, indent=2))
    RESULTS.write_text(json.dumps(result, indent=2) + '\n', 'utf-8')
    return 0 if flat and sound.whole and not outcome.lost else 1


if __name__ == '__main__':
    sys.exit(main())
