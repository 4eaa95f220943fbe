"""Fleets: two workers against one and against two plain processes, overhead, memory, long fleets.

    .venv/bin/python benchmarks/fleets.py [--ships N] [--long {cam,escapement}] [--out FILE]

The results are written to benchmarks/fleets.json. Ratios for two workers are compared with those
of two plain processes, in the same run, that sail the same ships and share nothing. `--long` sails
a fleet of a thousand ships instead, and adds its wall time, the processor time of all processes,
and the load of the machine, which shows whether others used it too.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import platform
import resource
import time
from contextlib import closing
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from tauto_core.ensembles.fleets import Plan, as_draws, sail_fleet, sail_ship
from tauto_core.ensembles.workers import Crew, run_each
from tauto_core.scene import load_scene
from tauto_core.scene.models import Scene

DAY_S = 86_400.0
PASSAGE_S = 81.0 * DAY_S
DRAWN = {'trochlea.release_angle': {'kind': 'uniform', 'low': 0.9, 'high': 1.1}}
TOUCH_S = 60.0
"""Duration of a voyage so short that its set-up is most of it."""


def second_cam(duration: float) -> Scene:
    """Return the scene of Euler's second cam with a force, its waves sampled twice a second."""
    scene = load_scene(
        'second_cam_at_sea',
        duration=duration,
        log={'interval': 60.0, 'motion': False},
        drift={'observation_interval': min(DAY_S, duration)},
    )
    return scene.model_copy(update={'ship': scene.ship.model_copy(update={'rate': 2.0})})


def escapement(duration: float) -> Scene:
    """Return the scene of the weight with drag and escapement that sails to Jamaica."""
    return load_scene('portsmouth_jamaica', duration=duration, voyage=None)


def plan(scene: Scene, ships: int, drawn: dict[str, Any] | None = None) -> Plan:
    return Plan(scene, scene.name, ships, as_draws(DRAWN if drawn is None else drawn, 'vary'))


def _nothing(_share: float) -> None:
    pass


def _sail_part(fleet: Plan, numbers: range, begin: Any, ready: Any) -> None:
    sail_ship(fleet, 0, _nothing)
    ready.release()
    begin.wait()
    for number in numbers:
        sail_ship(fleet, number, _nothing)


def plain_s(fleet: Plan, processes: int) -> float:
    """Return the time that plain processes take for a fleet, once each has sailed a ship."""
    context = multiprocessing.get_context('spawn')
    begin, ready = context.Event(), context.Semaphore(0)
    parts = [range(k, fleet.ships, processes) for k in range(processes)]
    crew = [context.Process(target=_sail_part, args=(fleet, part, begin, ready)) for part in parts]
    for each in crew:
        each.start()
    for _ in crew:
        ready.acquire()
    began = time.perf_counter()
    begin.set()
    for each in crew:
        each.join()
    return time.perf_counter() - began


def workers_s(fleet: Plan, jobs: int) -> float:
    """Return the time that workers take for a fleet, from the first finished ship to the last.

    One ship per worker sails before, so that all libraries are loaded.
    """
    first = 2 * jobs
    warm = plan(fleet.scene, fleet.ships + first)
    began = 0.0
    with closing(run_each(partial(sail_ship, warm), range(warm.ships), Crew(jobs))) as ended:
        for count, _ in enumerate(ended, 1):
            if count == first:
                began = time.perf_counter()
    return time.perf_counter() - began


def overhead_s(make: Any, ships: int) -> dict[str, float]:
    """Return the processor time of a ship apart from her motion, with and without a drawn machine.

    It is that of a voyage of a minute, less the cost of a minute within a voyage of an hour.
    """
    found = {}
    for name, drawn in (('same machine', {}), ('machine drawn', DRAWN)):
        times = []
        for duration in (TOUCH_S, 60.0 * TOUCH_S):
            fleet = plan(make(duration), ships, drawn)
            sail_ship(fleet, 0, _nothing)
            took = []
            for number in range(ships):
                began = time.thread_time()
                sail_ship(fleet, number, _nothing)
                took.append(time.thread_time() - began)
            times.append(min(took))
        a_minute = (times[1] - times[0]) / 59.0
        found[name] = times[0] - a_minute
    return found


def memory_mb(ships: int) -> list[float]:
    """Return the memory of a worker after each of its ships [MB], in the order of finishing."""
    found: dict[int, list[float]] = {}
    task = partial(_sail_and_weigh, plan(second_cam(DAY_S), ships))
    with closing(run_each(task, range(ships), Crew(2))) as ended:
        for each in ended:
            assert each.result is not None, each.error
            pid, size = each.result
            found.setdefault(pid, []).append(size)
    return max(found.values(), key=len)


def _sail_and_weigh(fleet: Plan, number: int, tell: Any) -> tuple[int, float]:
    sail_ship(fleet, number, tell)
    pages = int(Path('/proc/self/statm').read_text('ascii').split()[1])
    return os.getpid(), pages * os.sysconf('SC_PAGE_SIZE') / 1e6


def efficiency(make: Any, duration: float, ships: int) -> dict[str, float]:
    """Return the gain of two over one: workers, and plain processes in the same run."""
    fleet = plan(make(duration), ships)
    times = {
        'one plain process': plain_s(fleet, 1),
        'two plain processes': plain_s(fleet, 2),
        'one worker': workers_s(fleet, 1),
        'two workers': workers_s(fleet, 2),
    }
    plain = times['one plain process'] / times['two plain processes']
    return {
        **times,
        'plain gain': plain,
        'gain of the workers': times['one plain process'] / times['two workers'],
        'of what the machine gives': times['two plain processes'] / times['two workers'],
    }


def whole(fleet: Plan) -> dict[str, Any]:
    """Return the time of a fleet from the command to the answer, and the answer."""
    began, load = time.perf_counter(), [os.getloadavg()[0]]
    told = time.monotonic()

    def look(_ships: float) -> None:
        nonlocal told
        if time.monotonic() > told + 60.0:
            told = time.monotonic()
            load.append(os.getloadavg()[0])

    found = sail_fleet(fleet, Crew(2), progress=look)
    wall_s = time.perf_counter() - began
    used = [
        resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    ]
    return {
        'ships': fleet.ships,
        'failed': sum(found.answers.failures.values()),
        'wall_s': wall_s,
        'processor_s': sum(each.ru_utime + each.ru_stime for each in used),
        'processor_s_in_ships': sum(row['run_s'] for row in found.rows),
        'mean_load': sum(load) / len(load),
    }


def short(ships: int) -> dict[str, Any]:
    """Return gain of two workers, overhead and memory."""
    sizes = memory_mb(10 * ships)
    return {
        'machine': {
            'cpus': os.cpu_count(),
            'python': platform.python_version(),
            **{name: version(name) for name in ('distributed', 'numpy', 'llvmlite')},
        },
        'second cam, ten days': efficiency(second_cam, 10.0 * DAY_S, ships),
        'weight and escapement, a day': efficiency(escapement, DAY_S, ships),
        'overhead a ship [s]': {
            'second cam': overhead_s(second_cam, 10),
            'weight and escapement': overhead_s(escapement, 10),
        },
        'memory of a worker [MB]': {
            'ships': len(sizes),
            'after a tenth': sizes[len(sizes) // 10],
            'at the end': sizes[-1],
        },
    }


LONG = {
    'cam': ('1000 ships of the second cam, 81 days', second_cam, PASSAGE_S),
    'escapement': ('1000 ships with an escapement, a day', escapement, DAY_S),
}


def main() -> None:
    """Measure, print and write down."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--ships', type=int, default=24)
    parser.add_argument('--long', choices=tuple(LONG), help='a fleet of a thousand ships')
    parser.add_argument('--out', type=Path, default=Path(__file__).with_suffix('.json'))
    asked = parser.parse_args()
    found = json.loads(asked.out.read_text('utf-8')) if asked.out.exists() else {}
    if asked.long:
        name, make, duration = LONG[asked.long]
        found[name] = whole(plan(make(duration), 1000))
    else:
        found.update(short(asked.ships))
    asked.out.write_text(json.dumps(found, indent=2) + '\n', 'utf-8')
    print(json.dumps(found, indent=2))


if __name__ == '__main__':
    main()
