"""What a whole passage costs, and what a second clock beside the first costs."""

from __future__ import annotations

import threading
import time
from typing import Any

from tauto_core.bench.problems import PASSAGE_S, problems
from tauto_core.bench.tauto_peer import Tauto
from tauto_core.samples import SECONDS_PER_DAY

SETTING = '10 Hz 1e-12'
ROUNDS = 3
NEEDED_US = 3.0
NEEDED_RATIO = 1.15


def passage(duration_s: float = PASSAGE_S) -> dict[str, Any]:
    """Return the cost of problem c over a passage, all in (sea, motion, clock), without a bag.

    Args:
        duration_s: of the passage [s].
    """
    problem = next(p for p in problems() if p.key == 'c')
    outcome = Tauto().solve(problem, SETTING, duration_s)
    return {
        'problem': problem.key,
        'program': Tauto.name,
        'setting': SETTING,
        'duration_s': duration_s,
        'run_s': outcome.run_s,
        'us_per_oscillation': 1e6 * outcome.run_s * problem.period_s / duration_s,
        'needed_us': NEEDED_US,
    }


def two_at_once(duration_s: float = SECONDS_PER_DAY) -> dict[str, Any]:
    """Return how much longer two runs of problem c in two threads take than one.

    Args:
        duration_s: of each run [s].
    """
    one_s = two_s = float('inf')
    tauto = Tauto()
    # compiles, so that only runs are timed
    _wall(tauto, 1, min(duration_s, 60.0))
    for _ in range(ROUNDS):
        one_s = min(one_s, _wall(tauto, 1, duration_s))
        two_s = min(two_s, _wall(tauto, 2, duration_s))
    return {
        'problem': 'c',
        'setting': SETTING,
        'duration_s': duration_s,
        'one_s': one_s,
        'two_s': two_s,
        'ratio': two_s / one_s,
        'needed_ratio': NEEDED_RATIO,
    }


def _wall(tauto: Tauto, runs: int, duration_s: float) -> float:
    """Return the time that runs in as many threads take together [s]."""
    problem = next(p for p in problems() if p.key == 'c')
    threads = [
        threading.Thread(target=tauto.solve, args=(problem, SETTING, duration_s))
        for _ in range(runs)
    ]
    began = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return time.perf_counter() - began
