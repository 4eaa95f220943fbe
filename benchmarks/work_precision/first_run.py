"""The time of a first run: a new process, nothing compiled, a minute of the problem.

    python -m benchmarks.work_precision.first_run PROBLEM PEER SETTING

runs it once; `first_runs` times such processes from outside, each with empty folders for anything
that a program keeps compiled. Starting Python and importing are included.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import Any

LENGTH_S = 60.0
LIMIT_S = 300.0
"""Time limit; a program that takes longer has no figure."""


def first_runs(
    rows: Iterable[Mapping[str, Any]], say: Callable[[str], None]
) -> list[dict[str, Any]]:
    """Return problem, program, setting and `first_run_s` for each program with a row.

    The setting is that of its cheapest row within the error at which programs are compared, or
    else of its most accurate one. `say` is called with a description of each run.
    """
    from benchmarks.work_precision.ratios import cheapest, targets

    rows = list(rows)
    found = []
    for key, name in dict.fromkeys((row['problem'], row['program']) for row in rows):
        row = cheapest(rows, key, [name], targets()[key]) or min(
            (row for row in rows if (row['problem'], row['program']) == (key, name)),
            key=lambda row: float(row['error_s_per_day']),
        )
        say(f'{key}: {name} {row["setting"]}, first run')
        seconds = first_run(key, name, row['setting'])
        if seconds is not None:
            setting = {'problem': key, 'program': name, 'setting': row['setting']}
            found.append({**setting, 'first_run_s': seconds})
    return found


def first_run(key: str, name: str, setting: str) -> float | None:
    """Return the time of a first run [s]; None where it failed or took more than `LIMIT_S`."""
    with tempfile.TemporaryDirectory() as empty:
        kept = ('NUMBA_CACHE_DIR', 'TAUTO_CACHE_DIR', 'XDG_CACHE_HOME', 'HOME')
        began = time.perf_counter()
        try:
            subprocess.run(
                [sys.executable, '-m', 'benchmarks.work_precision.first_run', key, name, setting],
                env={**os.environ, **dict.fromkeys(kept, empty)},
                check=True,
                capture_output=True,
                timeout=LIMIT_S,
            )
        except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
            return None
        return time.perf_counter() - began


def main() -> None:
    """Run a minute of a problem."""
    from benchmarks.work_precision.peer import PEERS
    from benchmarks.work_precision.problems import problems

    key, name, setting = sys.argv[1:]
    if name.startswith('heyoka'):
        with suppress(ModuleNotFoundError):
            import heyoka

            heyoka.llvm_state.set_diskcache_enabled(False)
    (problem,) = (each for each in problems() if each.key == key)
    PEERS[name]().solve(problem, setting, LENGTH_S)


if __name__ == '__main__':
    main()
