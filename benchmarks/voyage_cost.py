"""The costs from which `tauto scene check` predicts the run time of a voyage.

    .venv/bin/python -m benchmarks.voyage_cost [--repeats N] [--out FILE]

Shipped scenes are sailed without a bag, chunk by chunk as `voyage.sail` does, and the processor
time of ship, clock and navigation is taken apart. The least of the repeats counts, so that other
work on the machine shows little. Each constant of `tauto_core.checks.cost` follows from one scene
or from the difference of two. The figures are printed beside the constants in use and written to
benchmarks/voyage_cost.json.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import time
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from tauto_core.checks import cost
from tauto_core.checks.readiness import check_scene
from tauto_core.clockwork import TrochleaStage
from tauto_core.motion import propagator_name
from tauto_core.navigation import DriftStage, LongitudeStage, covariates
from tauto_core.navigation.regressors import SHAKEN_BY
from tauto_core.results import Summary
from tauto_core.samples import SHIP_IMU, Batches, Samples, Stage
from tauto_core.scene import Scene, load_scene
from tauto_core.scene.loader import StillShip
from tauto_core.ship.buffer import felt_parts
from tauto_core.voyage import QUIET_CHUNK, Pipeline, ShipSource

RESULTS = Path(__file__).with_suffix('.json')
DAY_S = 86_400.0
AT_SEA_S, ON_LAND_S = 7200.0, 10.0 * DAY_S
STARTS = {
    'harmonic': 'ideal',
    'half_swings': 'globe_in_oil',
    'forced_harmonic': 'second_cam_at_sea',
    'collocation': 'involute_weight_at_sea',
}
"""A scene for each propagator, of which a minute is sailed for the cost of the start."""


class Timed:
    """A stage with the processor time that it has taken [s]."""

    def __init__(self, stage: Stage) -> None:
        self.stage, self.inputs, self.spent_s = stage, stage.inputs, 0.0

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Feed the stage."""
        began_s = time.thread_time()
        said = self.stage.feed(batches)
        self.spent_s += time.thread_time() - began_s
        return said

    def finish(self) -> Batches:
        """End the stage."""
        began_s = time.thread_time()
        said = self.stage.finish()
        self.spent_s += time.thread_time() - began_s
        return said


def stage_ns(scene: Scene, repeats: int) -> dict[str, float]:
    """Return the least processor time of ship, clock and navigation [ns].

    One more run comes first, which compiles the kernels.
    """
    tried = [_once(scene) for _ in range(repeats + 1)][1:]
    return {name: 1e9 * min(each[name] for each in tried) for name in tried[0]}


def _once(scene: Scene) -> dict[str, float]:
    machine, motion = check_scene(scene)
    heard = any(name in SHAKEN_BY for name in scene.drift.covariates or ())
    source = ShipSource(scene, motion, says_scene=False, as_messages=heard)
    clock = Timed(TrochleaStage(scene, machine=machine))
    navigator = Timed(DriftStage(scene)), Timed(LongitudeStage(scene))
    stages: Any = Pipeline([clock, *navigator])  # type: ignore[list-item]
    summary, ship_s, summary_s = Summary(scene, machine), 0.0, 0.0
    while source.produced < source.total:
        began_s = time.thread_time()
        batches = source.produce(QUIET_CHUNK)
        ship_s += time.thread_time() - began_s
        said = stages.feed(batches)
        began_s = time.thread_time()
        summary.feed(said)
        summary_s += time.thread_time() - began_s
    summary.feed(stages.finish())
    return {
        'ship': ship_s,
        'clock': clock.spent_s,
        'navigation': summary_s + sum(each.spent_s for each in navigator),
    }


def sailed(name: str, duration: float, **changes: Any) -> Scene:
    """Return a shipped scene without its voyage; `__` in the names of keys stands for a dot."""
    given = {key.replace('__', '.'): value for key, value in changes.items()}
    log = {'interval': 1.0, 'motion': False}
    drift = {'observation_interval': 600.0}
    scene = load_scene(name, **{'log': log, 'drift': drift, **given, 'duration': duration})
    return scene.model_copy(update={'voyage': None})


def on_land(name: str, interval_s: float) -> Scene:
    """Return a scene on a ship that lies still, with nothing that hinders the swing."""
    log = {'interval': interval_s, 'motion': False}
    scene = sailed(name, ON_LAND_S, log=log, drift={'observation_interval': DAY_S})
    bare = {'ship': StillShip(), 'drag': None, 'escapement': None}
    return scene.model_copy(update=bare)


def waves_of(scene: Scene) -> int:
    """Return the number of harmonics of a sea, summed over the samples of the motion."""
    motion = check_scene(scene)[1]
    channels = 1 + bool(motion.metadata.get('heave'))
    return motion.total * channels * int(motion.metadata['components'])


def steps_of(scene: Scene) -> tuple[float, float]:
    """Return the number of steps and of events that are predicted for a scene."""
    machine, motion = check_scene(scene)
    swings = scene.duration / machine.period(machine.release_angle)  # type: ignore[union-attr]
    steps = cost.forecast(scene, machine, motion).steps_a_swing or 0.0
    return swings * steps, 2.0 * swings * (scene.escapement is not None)


def measured(repeats: int) -> dict[str, float]:
    """Return the constants, by their names."""
    found: dict[str, float] = {}
    plain = sailed('cheek_before_euler', AT_SEA_S)
    found['SHIP_NS_A_SAMPLE'] = stage_ns(plain, repeats)['ship'] / check_scene(plain)[1].total
    force = sailed('second_cam_at_sea', AT_SEA_S)
    many = sailed('second_cam_at_sea', AT_SEA_S, ship__sea__components=1024)
    few_ns, many_ns = stage_ns(force, repeats), stage_ns(many, repeats)
    both_ns = [each['ship'] + each['clock'] for each in (few_ns, many_ns)]
    a_component = (both_ns[1] - both_ns[0]) / (waves_of(many) - waves_of(force))
    found['SHIP_NS_A_COMPONENT'] = a_component
    found['NAVIGATION_NS_A_LOG'] = few_ns['navigation'] / force.log_count

    def clock_ns(scene: Scene) -> float:
        """Return the time of the clock without that of the sea, which is summed in it."""
        return stage_ns(scene, repeats)['clock'] - a_component * waves_of(scene)

    felt = check_scene(force)[1].total * felt_parts(force)
    found['FORCED_NS_A_SAMPLE'] = clock_ns(force) / felt
    weight = sailed('involute_weight_at_sea', AT_SEA_S)
    found['NS_A_STEP'] = clock_ns(weight) / steps_of(weight)[0]
    driven = sailed('clock_involute_weight', AT_SEA_S).model_copy(update={'suspension': None})
    steps, events = steps_of(driven)
    found['NS_AN_EVENT'] = (clock_ns(driven) - steps * found['NS_A_STEP']) / events
    for kind, name in (('lever', 'sully_lever_at_sea'), ('hanging', 'hanging_thread_at_sea')):
        steps, events = steps_of(scene := sailed(name, AT_SEA_S))
        rest_ns = clock_ns(scene) - events * found['NS_AN_EVENT']
        found[f'NS_A_STEP_OF_THREAD {kind}'] = rest_ns / steps
    air = {'kind': 'route', 'celsius': 20.0, 'diurnal': 5.0}
    hot = sailed('involute_weight_at_sea', AT_SEA_S, trochlea__material='brass', air=air)
    found['HEAT_FACTOR'] = clock_ns(hot) / steps_of(hot)[0] / found['NS_A_STEP']
    found['NS_A_NEWTON_STEP'] = _newton_step_ns(repeats)
    hung = sailed('suspended_weight_at_sea', 600.0)
    case_ns = clock_ns(hung) - steps_of(hung)[0] * found['NS_A_STEP']
    found['SUSPENDED_NS_A_SAMPLE'] = case_ns / (check_scene(hung)[1].total * felt_parts(hung))
    found |= _on_land(repeats)
    found['COVARIATE_NS_A_SAMPLE'] = _covariates(weight, repeats)
    found['SLOW_COVARIATE_NS_A_LOG'] = _slow_covariate(repeats)
    found['COEFFICIENT_RUNS_S'] = max(_trials(repeats))
    return found | {f'START_S {name}': _start_s(of, repeats) for name, of in STARTS.items()}


def _newton_step_ns(repeats: int) -> float:
    """Return the cost of a step whose equations take Newton's method [ns]: of a heavy weight."""
    scene = sailed('measured', 60.0, trochlea__cam__base_radius=5.0)
    clock = TrochleaStage(scene)
    clock.feed({SHIP_IMU: check_scene(scene)[1].produce(60 * 20 + 5)})
    clock.finish()
    return stage_ns(scene, repeats)['clock'] / int(clock.state()['propagator']['newton'])


def _on_land(repeats: int) -> dict[str, float]:
    found = {}
    scene = on_land('ideal', 1.0)
    found['NS_A_LOG harmonic'] = stage_ns(scene, repeats)['clock'] / scene.log_count
    arc = on_land('cheek_before_euler', 60.0)
    assert propagator_name(check_scene(arc)[0], still=True) == 'action_angle'
    found['NS_A_LOG action_angle'] = stage_ns(arc, repeats)['clock'] / arc.log_count
    half_swings, logs = [], []
    for curve in ('euler', 'cycloid', 'symmetric'):
        often, rarely = (
            sailed(
                'globe_in_oil',
                3600.0,
                regulator__curve=curve,
                log={'interval': interval_s, 'motion': False},
            )
            for interval_s in (0.5, 60.0)
        )
        many, few = (stage_ns(each, repeats)['clock'] for each in (often, rarely))
        a_log = (many - few) / (often.log_count - rarely.log_count)
        swung = 2.0 * often.duration / check_scene(often)[0].small_period
        logs.append(a_log)
        half_swings.append((few - a_log * rarely.log_count) / swung)
    return {**found, 'NS_A_LOG half_swings': max(logs), 'NS_A_HALF_SWING': max(half_swings)}


def _covariates(plain: Scene, repeats: int) -> float:
    """Return what one covariate adds for each sample of the motion [ns]."""
    known = {'roll': {'value': 0.0, 'sigma': 1.0}}
    heard = plain.drift.model_copy(update={'covariates': ('roll',)})
    drift = type(plain.drift).model_validate({**heard.model_dump(), 'coefficients': known})
    both = (plain, plain.model_copy(update={'drift': drift}))
    without, with_it = (sum(stage_ns(each, repeats).values()) for each in both)
    return (with_it - without) / check_scene(plain)[1].total


def _slow_covariate(repeats: int) -> float:
    """Return what the temperature as a covariate adds for each logged instant [ns]."""
    drift = {
        'covariates': ['temperature'],
        'coefficients': {'temperature': {'value': 0.0, 'sigma': 1e-5}},
    }
    air = {'kind': 'route', 'celsius': 20.0, 'diurnal': 5.0}
    plain = sailed('involute_weight_at_sea', AT_SEA_S, air=air)
    heard = sailed('involute_weight_at_sea', AT_SEA_S, air=air, drift=drift)
    without, with_it = (sum(stage_ns(each, repeats).values()) for each in (plain, heard))
    return (with_it - without) / plain.log_count


def _trials(repeats: int) -> list[float]:
    """Return the least processor time of trial runs of each machine [s]."""
    found = []
    for name in ('involute_weight_at_sea', 'sully_lever_at_sea', 'hanging_thread_at_sea'):
        scene = sailed(name, 60.0, drift__covariates=['roll', 'heave'])
        times = []
        for _ in range(repeats + 1):
            covariates._runs.cache_clear()
            covariates._fit.cache_clear()
            began_s = time.thread_time()
            tried = covariates.runs(scene)
            covariates.fit(scene, tuple(each.coefficient for each in tried))
            times.append(time.thread_time() - began_s)
        found.append(min(times[1:]))
    return found


def _start_s(name: str, repeats: int) -> float:
    """Return the processor time of `tauto sail` of a minute, with compiled kernels [s]."""
    tauto = (sys.executable, '-c', 'from tauto_core.cli import main; main()')
    times = []
    for _ in range(repeats + 1):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        words = ('sail', name, '--duration', '60', '--quiet', '--json')
        subprocess.run([*tauto, *words], check=True, stdout=subprocess.DEVNULL, timeout=600)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times[1:])


def in_use(name: str) -> float:
    """Return a constant of `voyage_cost`; behind a blank stands its key."""
    constant, _, key = name.partition(' ')
    value = getattr(cost, constant)
    return float(value[key] if key else value)


def main() -> None:
    """Measure all constants, print them beside those in use, and write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--repeats', type=int, default=4)
    parser.add_argument('--out', type=Path, default=RESULTS)
    asked = parser.parse_args()
    load_before = os.getloadavg()[0]
    found = measured(asked.repeats)
    for name, value in found.items():
        print(f'{name:30} {value:12.4g}   in use {in_use(name):10.4g}')
    machine = {
        'python': platform.python_version(),
        'llvmlite': version('llvmlite'),
        'processors': os.cpu_count(),
        'load': [load_before, os.getloadavg()[0]],
        'repeats': asked.repeats,
    }
    asked.out.write_text(json.dumps({**machine, 'constants': found}, indent=1) + '\n', 'utf-8')


if __name__ == '__main__':
    main()
