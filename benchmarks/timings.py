"""How long the parts take that a user waits for.

    .venv/bin/python benchmarks/timings.py PART [OPTION …]

PART is one of

    start     the first result of each shipped scene, in a first and a second run, into start.json
    fleet     a fleet of a thousand ships on two processes, into fleets.json
    weather   a sample of ship/imu in weather, compared with one sea

The options of a part are listed by `timings.py PART --help`.
"""

from __future__ import annotations

import argparse
import compileall
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tauto_core import fleet
from tauto_core.scene import Scene, load_scene
from tauto_core.scene.times import DAY_S
from tauto_core.ship import ShipMotion

# -----------------------------------------------------------------------------
# Start: time to the first result of a scene, in a first run and in a second one.
#
# Each shipped scene is sailed for ten minutes in a process of its own: cold with an empty folder
# of compiled kernels, then warm with those from the first run. Python's own byte code is present
# in both, as after an installation or any first command. Wall time is what a user waits for; CPU
# time, user and system together, remains comparable on a machine with other work. The least of the
# repeats counts. The rows of a build, by default this version, are kept under its name beside
# those of others, with the machine's load at the beginning.

RESULTS = Path(__file__).with_name('start.json')
DURATION_S = 600.0
COLD_S, WARM_S = 4.0, 0.8
"""Largest times that a first and a second run should take."""
TAUTO = (sys.executable, '-m', 'tauto_core')


def command_s(arguments: list[str], cache: str) -> dict[str, float]:
    """Return wall and CPU command_s of one command with a given folder of kernels."""
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
    """Return the cold and warm command_s of a scene."""
    command, cold, warm = ['sail', scene, '--duration', str(DURATION_S), '--json'], [], []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as cache:
            cold.append(command_s(command, cache))
            warm.append(command_s(command, cache))
    return {'cold': least(cold), 'warm': least(warm)}


def start(words: list[str]) -> None:
    """Measure the scenes, print each, write them down."""
    import tauto_core
    from tauto_core.scene import shipped_scenes

    compileall.compile_dir(str(Path(tauto_core.__file__).parent), quiet=1)
    parser = argparse.ArgumentParser('timings.py start', allow_abbrev=False)
    parser.add_argument('scenes', nargs='*', metavar='SCENE')
    parser.add_argument('--build', default=tauto_core.__version__)
    parser.add_argument('--repeats', type=int, default=3)
    given = parser.parse_args(words)
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


# -----------------------------------------------------------------------------
# Fleet: wall time and the processor time of all processes.
#
# The load of the machine at the start shows whether others used it, too.


def second_cam() -> Scene:
    """Return 81 days of Euler's second cam with a force, its waves sampled twice a second."""
    scene = load_scene(
        'second_cam_at_sea',
        duration=81.0 * DAY_S,
        log={'interval': 60.0, 'motion': False},
        drift={'observation_interval': DAY_S},
    )
    return scene.model_copy(update={'ship': scene.ship.model_copy(update={'rate': 2.0})})


def escapement() -> Scene:
    """Return a day of the weight with drag and escapement that sails to Jamaica."""
    return load_scene('portsmouth_jamaica', duration=DAY_S, voyage=None)


FLEETS = {
    'cam': ('1000 ships of the second cam, 81 days', second_cam),
    'escapement': ('1000 ships with an escapement, a day', escapement),
}


def thousand_ships(words: list[str]) -> None:
    """Sail a fleet, print and write its times."""
    parser = argparse.ArgumentParser('timings.py fleet')
    parser.add_argument('kind', choices=tuple(FLEETS))
    parser.add_argument('--ships', type=int, default=1000)
    parser.add_argument('--out', type=Path, default=Path(__file__).with_name('fleets.json'))
    given = parser.parse_args(words)
    name, make = FLEETS[given.kind]
    drawn = {'trochlea.release_angle': {'kind': 'uniform', 'low': 0.9, 'high': 1.1}}
    load, began = os.getloadavg()[0], time.perf_counter()
    found = fleet(make(), ships=given.ships, vary=drawn, jobs=2)
    wall_s = time.perf_counter() - began
    used = [
        resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    ]
    results = json.loads(given.out.read_text('utf-8')) if given.out.exists() else {}
    results[name] = {
        'ships': given.ships,
        'failed': sum(found.answers.failures.values()),
        'wall_s': wall_s,
        'processor_s': sum(each.ru_utime + each.ru_stime for each in used),
        'processor_s_in_ships': sum(row['run_s'] for row in found.rows),
        'load_at_start': load,
    }
    print(json.dumps(results[name], indent=2))
    given.out.write_text(json.dumps(results, indent=2) + '\n', 'utf-8')


# -----------------------------------------------------------------------------
# Weather: processor time per sample of ship/imu, same ship.
#
# A calm, a steady sea and a change from one sea into another are sampled in turn with the sea
# alone, and the least time of each counts.

ROUNDS = 7
HIGH = {'significant_wave_height': 2.5, 'peak_period': 9.0}
LOW = {'significant_wave_height': 1.5, 'peak_period': 7.0}
SHIP = {
    'kind': 'sea',
    'roll': {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7},
    'heave': True,
    'height': 3.0,
    'rate': 10.0,
}


def scene_of(samples: int, *states: dict[str, object]) -> Scene:
    """Return a ship in the states at both ends of a scene, or in one sea where there are none."""
    duration = 60.0 * (samples // 600)
    sea: dict[str, object] = {'sea': {'spectrum': 'bretschneider', **HIGH}}
    if states:
        listed = [{'at': duration * k, **state} for k, state in enumerate(states)]
        sea = {'weather': {'kind': 'states', 'states': listed}}
    return load_scene('ideal', ship={**SHIP, **sea}, duration=duration)


def nanoseconds_a_sample(scene: Scene) -> float:
    """Return the processor time of a scene per sample, without set-up."""
    motion = ShipMotion(scene)
    motion.produce(1)
    began, samples = time.process_time_ns(), motion.total
    while len(motion.produce(65_536).stamp_ns):
        pass
    return (time.process_time_ns() - began) / samples


def weather(words: list[str]) -> None:
    """Print a row for each kind of weather."""
    parser = argparse.ArgumentParser('timings.py weather')
    parser.add_argument('--samples', type=int, default=600_000, help='of each scene')
    samples = parser.parse_args(words).samples
    still: dict[str, object] = {'still': True}
    scenes = {
        'one sea': scene_of(samples),
        'steady weather': scene_of(samples, HIGH, HIGH),
        'a change of seas': scene_of(samples, HIGH, LOW),
        'a sea that comes': scene_of(samples, still, HIGH),
        'a calm': scene_of(samples, still, still, HIGH),
    }
    # the calm lasts to the end of the scene, and the sea comes after it
    least = dict.fromkeys(scenes, float('inf'))
    for _ in range(ROUNDS):
        for name, scene in scenes.items():
            least[name] = min(least[name], nanoseconds_a_sample(scene))
    for name, cost in least.items():
        print(f'{name:18} {cost:7.1f} ns a sample  {cost / least["one sea"]:5.2f}')


PARTS = {'start': start, 'fleet': thousand_ships, 'weather': weather}

if __name__ == '__main__':
    asked = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    asked.add_argument('part', choices=PARTS)
    PARTS[asked.parse_args(sys.argv[1:2]).part](sys.argv[2:])
