"""The effect on a voyage of one node that is frozen for a while (SIGSTOP, SIGCONT), or killed.

    .venv/bin/python benchmarks/graph_freeze.py [--seconds 5 14 25 60] [--paces 100 max] [--jobs 4]

Each row is a voyage of `tauto graph`, at a pace or flat out, where its messages go in packs, in
which one node was frozen once. It must end well with nothing lost and every message in the bag,
or within 5 s of the thaw with an error that names the node. DDS by itself forgets a participant
after 20 s. Last, each node is killed once (SIGKILL): the voyage must end with the name of the
node, and what was sailed until then must be read from the bag. Results:
benchmarks/graph_freeze.json; the exit code is 1 if a row fails.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path
from typing import Any

from tauto_core.bags import read_bag

NODES = ('ship_motion', 'trochlea', 'drift_estimator', 'longitude', 'recorder')
PACES = {'100': ('measured', 600.0), 'max': ('second_cam_at_sea', 7200.0)}
"""By pace: a scene and the length of the voyage [s], which takes some seconds."""

PATIENCE_S = 600.0
RECORDED_BYTES = 2000
ENDS_S = 5.0
RESULTS = Path(__file__).with_suffix('.json')

SAID_CHARACTERS = 3000
"""Enough for the stacks of a node that hangs."""


def node_of(supervisor: int, node: str) -> int | None:
    """Return the process of a node that a supervisor has started."""
    for status in Path('/proc').glob('[0-9]*/stat'):
        try:
            parent = int(status.read_text().rpartition(')')[2].split()[1])
            words = status.with_name('cmdline').read_bytes()
        except OSError:
            continue
        if parent == supervisor and f'\0tauto_nodes\0{node}\0'.encode() in words:
            return int(status.parent.name)
    return None


def wait_for_messages(bag: Path, process: subprocess.Popen[str]) -> None:
    """Return when the bag has some messages."""
    deadline_s = time.monotonic() + PATIENCE_S
    while not any(file.stat().st_size > RECORDED_BYTES for file in bag.glob('*.mcap')):
        if process.poll() is not None or time.monotonic() > deadline_s:
            return
        time.sleep(0.05)


def strike(node: str, seconds: float | None, pace: str) -> dict[str, Any]:
    """Return what became of a voyage with this node frozen for so long, or killed (None)."""
    code = 'from tauto_core.cli import main; main()'
    with tempfile.TemporaryDirectory(prefix='tauto_freeze_') as folder:
        bag = Path(folder) / 'bag'
        scene, duration_s = PACES[pace]
        options = ['--duration', str(duration_s), '--speed', pace, '--out', str(bag), '--json']
        process = subprocess.Popen(
            [sys.executable, '-c', code, 'graph', scene, *options],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        wait_for_messages(bag, process)
        pid = node_of(process.pid, node)
        assert pid is not None, process.communicate()[1]
        os.kill(pid, signal.SIGKILL if seconds is None else signal.SIGSTOP)
        time.sleep(seconds or 0.0)
        ended = process.poll() is not None
        thawed_s = time.monotonic()
        if seconds is not None:
            os.kill(pid, signal.SIGCONT)
        said, words = process.communicate(timeout=PATIENCE_S)
        after_s = time.monotonic() - thawed_s
        kept = sum(read_bag(bag).counts.values())
    row: dict[str, Any] = {'node': node, 'frozen_s': seconds, 'pace': pace}
    row['exit_code'] = process.returncode
    if process.returncode == 0:
        topics = json.loads(said)['topics']
        row['written'] = sum(numbers['written'] for numbers in topics.values())
        row['lost'] = sum(numbers['lost'] for numbers in topics.values())
    else:
        row['ended_s_after_thaw'] = 0.0 if ended else round(after_s, 1)
        row['names_the_node'] = f'node {node} ended by SIGKILL' in words or (
            seconds is not None and node in words
        )
        row['kept'] = kept
        row['said'] = words.strip()[-SAID_CHARACTERS:]
    return row


def is_fine(row: dict[str, Any], whole: int) -> bool:
    """Whether a voyage ended complete, or ended soon with the name of the node.

    A voyage whose node was killed must end so, and keep what was sailed.
    """
    if row['exit_code'] == 0:
        return bool(row['lost'] == 0 and row['written'] == whole)
    if row['frozen_s'] is None:
        return bool(row['names_the_node'] and row['kept'])
    return bool(row['names_the_node'] and row['ended_s_after_thaw'] <= ENDS_S)


def main() -> int:
    """Freeze each node for each time, print the outcome and write it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, nargs='+', default=[5.0, 14.0, 25.0, 60.0])
    parser.add_argument('--nodes', nargs='+', default=list(NODES), choices=NODES)
    parser.add_argument('--paces', nargs='+', default=list(PACES), choices=PACES)
    parser.add_argument('--jobs', type=int, default=4, help='voyages side by side')
    asked = parser.parse_args()
    with ThreadPoolExecutor(asked.jobs) as pool:
        frozen = product(asked.nodes, asked.seconds, asked.paces)
        killed = product(asked.nodes, [None], ['100'])
        rows = list(pool.map(lambda case: strike(*case), [*frozen, *killed]))
    whole = {
        pace: max(row.get('written', 0) for row in rows if row['pace'] == pace)
        for pace in asked.paces
    }
    for row in rows:
        row['fine'] = is_fine(row, whole[row['pace']])
        print(json.dumps(row))
    result = {'paces': PACES, 'messages': whole, 'rows': rows}
    RESULTS.write_text(json.dumps(result, indent=2) + '\n', 'utf-8')
    return 0 if all(row['fine'] for row in rows) else 1


if __name__ == '__main__':
    sys.exit(main())
