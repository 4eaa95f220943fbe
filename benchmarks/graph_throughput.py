"""How many messages a second go through the whole graph, recorded, without losing one.

    .venv/bin/python benchmarks/graph_throughput.py

Each row is a voyage flat out (`--speed max`), from the first message to the closed bag, without
start-up and, since a first run has compiled the kernels, without compilation. `messages_per_s`
counts what the recorder wrote; each ship/imu also goes to the trochlea. Results:
benchmarks/graph_throughput.json.
"""

from __future__ import annotations

import json
import os
import platform
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import rclpy

from tauto_core.scene import load_scene
from tauto_nodes.graph import Plan, run_graph

SCENE = 'second_cam_at_sea'
DURATION_S = 3600.0
RESULTS = Path(__file__).with_suffix('.json')
VARIANTS = {
    'events, a process each': {'executor': 'events'},
    'events, one process': {'executor': 'events', 'compose': True},
    'single, a process each': {'executor': 'single'},
}


def measure(plan: Plan, duration_s: float) -> dict[str, Any]:
    """Return the figures of one voyage of this length [s]."""
    plan = replace(plan, duration_s=duration_s)
    outcome = run_graph(plan, load_scene(plan.scene, duration=duration_s), lambda _: None)
    written = sum(numbers['written'] for numbers in outcome.counts.values())
    return {
        'messages': written,
        'lost': outcome.lost,
        'voyage_s': round(outcome.voyage_s, 3),
        'start_s': round(outcome.start_s, 3),
        'messages_per_s': round(written / outcome.voyage_s),
        'sea_s_per_s': round(duration_s / outcome.voyage_s),
    }


def main() -> None:
    """Measure all variants, print them, write them down."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        plan = Plan(SCENE, Path(folder) / 'bag', speed=0.0, force=True)
        measure(plan, 60.0)
        for name, options in VARIANTS.items():
            rows.append({'variant': name, **measure(replace(plan, **options), DURATION_S)})
            print(json.dumps(rows[-1]))
    machine = {
        'cpus': os.cpu_count(),
        'processor': platform.machine(),
        'python': platform.python_version(),
        'rmw': rclpy.get_rmw_implementation_identifier(),
    }
    result = {'scene': SCENE, 'duration_s': DURATION_S, 'machine': machine, 'rows': rows}
    RESULTS.write_text(json.dumps(result, indent=2) + '\n', 'utf-8')


if __name__ == '__main__':
    main()
