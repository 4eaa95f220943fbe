"""Time to the first result of each shipped scene, in a first run and in a second one.

    .venv/bin/python benchmarks/start.py [SCENE …] [--build NAME] [--repeats N]

Each scene is sailed for ten minutes in a process of its own: cold with an empty folder of compiled
kernels, then warm with the kernels of the first run. Python's own byte code is present in both, as
after an installation. Wall time is the wait of a user. CPU time, user and system together, remains
comparable on a machine with other work. The least of the repeats counts. benchmarks/start.json
keeps the rows of each build under its name, with the load of the machine at the beginning.
"""

from __future__ import annotations

import argparse
import compileall
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import tauto_core
from tauto_core.scene import shipped_scenes

RESULTS = Path(__file__).with_suffix('.json')
DURATION_S = 600.0
COLD_S, WARM_S = 4.0, 0.8
"""Largest times that a first and a second run should take."""
TAUTO = (sys.executable, '-m', 'tauto_core')


def command_s(arguments: list[str], cache: str) -> dict[str, float]:
    """Return wall and CPU times of one command with a given folder of kernels."""
    environment = {**os.environ, 'TAUTO_CACHE_DIR': cache, 'NUMBA_CACHE_DIR': cache}
    environment.pop('PYTHONDONTWRITEBYTECODE', None)
    before, began = os.times(), time.perf_counter()
    subprocess.run(
        [*TAUTO, *arguments], env=environment, check=True, stdout=subprocess.DEVNULL, timeout=600
    )
    wall, after = time.perf_counter() - began, os.times()
    cpu = after.children_user + after.children_system
    cpu -= before.children_user + before.children_system
    return {'wall_s': round(wall, 3), 'cpu_s': round(cpu, 3)}


def least(rows: list[dict[str, float]]) -> dict[str, float]:
    """Return the least of each figure."""
    return {name: min(row[name] for row in rows) for name in rows[0]}


def first_and_second(scene: str, repeats: int) -> dict[str, dict[str, float]]:
    """Return the cold and warm times of a scene."""
    command, cold, warm = ['sail', scene, '--duration', str(DURATION_S), '--json'], [], []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as cache:
            cold.append(command_s(command, cache))
            warm.append(command_s(command, cache))
    return {'cold': least(cold), 'warm': least(warm)}


def main() -> None:
    """Measure the scenes, print each, write them down."""
    compileall.compile_dir(str(Path(tauto_core.__file__).parent), quiet=1)
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('scenes', nargs='*', metavar='SCENE')
    parser.add_argument('--build', default=tauto_core.__version__)
    parser.add_argument('--repeats', type=int, default=3)
    given = parser.parse_args()
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {'builds': {}}
    build = results['builds'].setdefault(given.build, {'scenes': {}})
    if not given.scenes:
        build['scenes'] = {}
    build['python'], build['load'] = platform.python_version(), round(os.getloadavg()[0], 2)
    build['help'] = least([command_s(['--help'], '') for _ in range(5)])
    print('--help', json.dumps(build['help']))
    for scene in given.scenes or shipped_scenes():
        build['scenes'][scene] = first_and_second(scene, given.repeats)
        print(scene, json.dumps(build['scenes'][scene]), flush=True)
        RESULTS.write_text(json.dumps(results, indent=1) + '\n')
    for run, limit in (('cold', COLD_S), ('warm', WARM_S)):
        walls = [rows[run]['wall_s'] for rows in build['scenes'].values()]
        slow = sum(wall > limit for wall in walls)
        print(f'{run}: {min(walls)} to {max(walls)} s; {slow} of {len(walls)} above {limit} s')


if __name__ == '__main__':
    main()
