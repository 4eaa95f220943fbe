"""The cost of a whole passage, and of a second clock at the same time."""

from __future__ import annotations

import multiprocessing
import threading
import time
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from benchmarks.work_precision.peers.tauto import Tauto
from benchmarks.work_precision.problems import PASSAGE_S, problems
from tauto_core.scene.times import DAY_S

SETTING = '10 Hz 1e-12'
ROUNDS = 3


def passage(duration_s: float = PASSAGE_S) -> dict[str, Any]:
    """Return the cost of problem c over a passage (sea, motion and clock), without a bag."""
    problem = next(p for p in problems() if p.key == 'c')
    outcome = Tauto().solve(problem, SETTING, duration_s)
    return {
        'problem': problem.key,
        'program': Tauto.name,
        'setting': SETTING,
        'duration_s': duration_s,
        'run_s': outcome.run_s,
        'us_per_oscillation': 1e6 * outcome.run_s * problem.period_s / duration_s,
    }


def two_at_once(duration_s: float = DAY_S) -> dict[str, Any]:
    """Return the ratio of the times of two runs of problem c in two threads and of one.

    The same for two processes, which share nothing but the machine, gives the limit for threads.
    """
    one_s = two_s = apart_s = float('inf')
    tauto = Tauto()
    # compiles, so that only runs are timed
    _wall(tauto, 1, min(duration_s, 60.0))
    spawn = multiprocessing.get_context('spawn')
    with ProcessPoolExecutor(2, spawn, _in_process, (min(duration_s, 60.0),)) as pool:
        # both processes are running, with their kernels, before one is timed
        list(pool.map(_in_process, [0.0, 0.0]))
        for _ in range(ROUNDS):
            one_s = min(one_s, _wall(tauto, 1, duration_s))
            two_s = min(two_s, _wall(tauto, 2, duration_s))
            began = time.perf_counter()
            list(pool.map(_in_process, [duration_s, duration_s]))
            apart_s = min(apart_s, time.perf_counter() - began)
    return {
        'problem': 'c',
        'setting': SETTING,
        'duration_s': duration_s,
        'one_s': one_s,
        'two_s': two_s,
        'ratio': two_s / one_s,
        'processes_ratio': apart_s / one_s,
    }


def _in_process(duration_s: float) -> None:
    """Run problem c in a process of its own; a duration of zero runs nothing."""
    if duration_s:
        _run(Tauto(), duration_s)


def _run(tauto: Tauto, duration_s: float) -> None:
    tauto.solve(next(p for p in problems() if p.key == 'c'), SETTING, duration_s)


def _wall(tauto: Tauto, runs: int, duration_s: float) -> float:
    """Return the time that runs in as many threads take together [s]."""
    threads = [threading.Thread(target=_run, args=(tauto, duration_s)) for _ in range(runs)]
    began = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return time.perf_counter() - began
