"""Rows of the stress table from random scenes: what breaks the engine, what miscounts."""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from stress_cases import (
    ARC,
    FORCE,
    HOLE,
    HOLE_CAM,
    INVOLUTE,
    LEVER_RATE,
    VERTICAL,
    Row,
    sail,
    scene_of,
    weight,
)

from tauto_core.machines import Machine, compile_machine
from tauto_core.motion.collocation import Collocation
from tauto_core.samples import JOINT_STATES, PHASE, READING, SLACK, Batches
from tauto_core.scene import Scene
from tauto_core.scene.errors import CamRangeError, PropagationError, SceneError

# -----------------------------------------------------------------------------
# A search for a scene that breaks the engine: NaN, bits that depend on chunks, too large errors.
#
# Every scene must either run or be refused with an error of Tauto that states the reason and the
# time. A run is compared with the run at a thousandth of the tolerance, over the same pieces of
# the motion, so that the error of sampling is the same in both. Their distance is then at most the
# error that the steps may make. The growth of a disturbance on the way is not part of that bound;
# the scenes drawn stay far below it, but for those whose thread goes slack.

TOLERANCE = 1e-12
DURATION_S = 20.0
CHUNK = 7


@dataclass
class Tally:
    """The result of a search: numbers of scenes, and the largest distance over the bound.

    `chunks` counts scenes with other bits in chunks, `silent` errors without a reason or a time.
    """

    scenes: int = 0
    refused: int = 0
    not_finite: int = 0
    chunks: int = 0
    silent: int = 0
    excess: float = 0.0
    worst: Scene | None = None


def _logarithmic(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(math.log(low), math.log(high)).map(math.exp)


def _section(**parts: Any) -> st.SearchStrategy[dict[str, Any]]:
    """Return a section of a scene, some of whose values are drawn."""
    drawn = st.SearchStrategy
    return st.fixed_dictionaries(
        {key: part if isinstance(part, drawn) else st.just(part) for key, part in parts.items()}
    )


FORCED = _section(kind='force', force=FORCE)
HEAVY = _section(kind='weight', mass=_logarithmic(0.01, 20.0))
SPRING = _section(kind='spring', force=FORCE, stiffness=_logarithmic(0.1, 1e3))
COMPONENT = _section(
    amplitude=st.floats(0.0, 0.3), period=st.floats(2.0, 20.0), phase=st.floats(-3.0, 3.0)
)
LAND = _section(kind='still')
SEA = _section(
    kind='components',
    components=st.lists(COMPONENT, min_size=1, max_size=4),
    heave=st.one_of(st.none(), st.lists(COMPONENT, min_size=1, max_size=2)),
    rate=st.sampled_from([2.0, 5.0, 20.0, 100.0]),
    height=st.floats(-5.0, 10.0),
)
TABLES = tempfile.TemporaryDirectory(prefix='tauto_')


def _table(departure: float) -> dict[str, str]:
    """Return a cam of 81 points on t = r (angle + departure * angle^3), to 4 rad."""
    path = Path(TABLES.name, f'{departure:.17g}.csv')
    angle = np.linspace(0.0, 4.0, 81)
    rows = np.stack([angle, LEVER_RATE * (angle + departure * angle**3)], axis=1)
    np.savetxt(path, rows, '%.17g', ',', header='angle_rad,lever_arm_m', comments='')
    return {'kind': 'table', 'path': str(path)}


TABULATED = st.floats(-0.02, 0.05).map(_table)
NONE = st.none()
VISCOUS = _section(viscous=_logarithmic(1e-9, 1e-1))
COULOMB = _section(coulomb=_logarithmic(1e-9, 3e-2))
ALL_DRAG = _section(
    viscous=_logarithmic(1e-9, 1e-3),
    quadratic=_logarithmic(1e-9, 1e-4),
    coulomb=_logarithmic(1e-9, 1e-3),
)
IMPULSE = _section(kind='impulse', energy=_logarithmic(1e-9, 1e-2), angle=st.floats(-0.5, 0.5))
RELEASES = st.one_of(st.floats(0.01, 3.0), st.floats(-3.0, -0.01), _logarithmic(1e-9, 1e-2))

# Each kind is compiled for itself, which takes longer than all its runs.
KINDS = (
    (st.just(INVOLUTE), VERTICAL, HEAVY, NONE, NONE, SEA),
    (st.just(HOLE_CAM), HOLE, FORCED, NONE, NONE, SEA),
    (st.just(HOLE_CAM), HOLE, FORCED, COULOMB, NONE, LAND),
    (st.just(INVOLUTE), VERTICAL, HEAVY, ALL_DRAG, IMPULSE, SEA),
    (st.just(ARC), VERTICAL, SPRING, VISCOUS, IMPULSE, LAND),
    (st.just(ARC), VERTICAL, FORCED, NONE, NONE, SEA),
    (TABULATED, VERTICAL, FORCED, VISCOUS, NONE, SEA),
)


@st.composite
def scenes(draw: st.DrawFn, kinds: int) -> dict[str, Any]:
    """Return the sections of a random scene of one of the first so many KINDS."""
    cam, thread, power, drag, escapement, ship = draw(st.sampled_from(KINDS[:kinds]))
    return {
        'trochlea': {
            'cam': draw(cam),
            'thread': thread,
            'power': draw(power),
            'release_angle': draw(RELEASES),
        },
        'drag': draw(drag),
        'escapement': draw(escapement),
        'ship': draw(ship),
    }


def _run(
    sections: dict[str, Any], *, chunk: int | None = None, finer: float | None = None
) -> Batches | str:
    """Return the output of a scene, or the message of its refusal."""
    try:
        scene = scene_of(**sections, duration=DURATION_S, solver={'tolerance': TOLERANCE})
        return sail(scene, chunk=chunk, finer=finer)
    except (SceneError, CamRangeError) as error:
        return f'refused: {error}'
    except PropagationError as error:
        known = math.isfinite(error.time_s) and -1e-9 <= error.time_s <= DURATION_S + 1e-9
        return f'stopped: {error}' if known else 'silent'


def _same(a: Batches | str, b: Batches | str) -> bool:
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    return all(
        np.array_equal(a[topic].position, b[topic].position) for topic in (JOINT_STATES, PHASE)
    ) and np.array_equal(a[READING].time_ref_ns, b[READING].time_ref_ns)


def examine(sections: dict[str, Any], tally: Tally) -> None:
    """Run a scene at once, in chunks and at a finer tolerance, and count what is wrong."""
    tally.scenes += 1
    coarse = _run(sections)
    tally.chunks += not _same(coarse, _run(sections, chunk=CHUNK))
    if isinstance(coarse, str):
        tally.refused += 1
        tally.silent += coarse == 'silent'
        return
    tally.not_finite += not np.all(np.isfinite(coarse[JOINT_STATES].position))
    tally.not_finite += not np.all(np.isfinite(coarse[JOINT_STATES].velocity))
    fine = _run(sections, finer=TOLERANCE * 1e-3)
    if isinstance(fine, str) or SLACK in coarse:  # a thread that tautens multiplies a disturbance
        return
    scene = scene_of(**sections, duration=DURATION_S)
    excess = _excess(scene, coarse, fine)
    if excess > tally.excess:
        tally.excess, tally.worst = excess, scene


def _excess(scene: Scene, coarse: Batches, fine: Batches) -> float:
    """Return the largest distance of two runs, over the bound."""
    machine = compile_machine(scene)
    a, b = coarse[JOINT_STATES], fine[JOINT_STATES]
    away = np.hypot(
        a.position[:, 0] - b.position[:, 0],
        (a.velocity[:, 0] - b.velocity[:, 0]) / machine.frequency,
    )
    size = float(np.max(np.hypot(b.position[:, 0], b.velocity[:, 0] / machine.frequency)))
    turned = machine.frequency * DURATION_S
    # assumes at least two steps a radian
    return float(np.max(away)) / (size * TOLERANCE * 2.0 * turned)


def search(examples: int, kinds: int = len(KINDS)) -> list[Row]:
    """Return the result of a search over so many random scenes, of so many kinds."""
    tally = Tally()

    @settings(
        max_examples=examples,
        derandomize=True,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(scenes(kinds))
    def look(sections: dict[str, Any]) -> None:
        examine(sections, tally)

    look()
    setting = f'{tally.scenes} random scenes of {DURATION_S:g} s, {tally.refused} refused'
    return [
        Row('scenes with numbers that are not finite', setting, tally.not_finite, 0.0),
        Row('scenes with other bits in chunks', setting, tally.chunks, 0.0),
        Row('errors without words or time', setting, tally.silent, 0.0),
        Row('distance from a finer run, in parts of the bound', setting, tally.excess, 1.0),
    ]


# -----------------------------------------------------------------------------
# The counting of turns and beats, for clocks with recoil at sea.
#
# Recoil turns the wheel back soon after its impulse and shifts the middle of the swing, and the
# ship's motion moves the neutral line, so a count can go wrong here. Each random clock is compared
# with SciPy's DOP853 over the same pieces of the ship's motion, which follows the angles
# themselves and looks between its steps for passages that come in pairs.

COUNTED_CLOCKS = 50
COUNTED_SEED = 1726
COUNTED_S = 30.0
COUNTED_RAD = 1e-9
"""Both programs err by about 1e-11 rad; a wrong count shows as 2π."""


def _clock(rng: np.random.Generator) -> dict[str, Any]:
    """Return a random clock with recoil on a rolling, heaving ship."""
    heavy = rng.random() < 0.5
    machine = (
        weight(10.0 ** rng.uniform(-2.0, -0.5)) if heavy else {'cam': HOLE_CAM, 'thread': HOLE}
    )
    amplitude = float(10.0 ** rng.uniform(-1.5, 0.0) * rng.choice([-1.0, 1.0]))
    torque = FORCE * LEVER_RATE * abs(amplitude)
    waves = [
        {
            'amplitude': float(rng.uniform(0.02, 0.15)),
            'period': float(rng.uniform(4.0, 12.0)),
            'phase': float(rng.uniform(0.0, math.tau)),
        }
        for _ in range(4)
    ]
    return {
        'duration': COUNTED_S,
        'trochlea': {**machine, 'release_angle': amplitude},
        'drag': {'viscous': float(rng.uniform(0.0, 2e-5)), 'quadratic': 1e-300},
        'escapement': {
            'kind': 'impulse',
            'energy': float(rng.uniform(0.0, 0.1)) * torque * abs(amplitude),
            'angle': float(rng.uniform(-0.3, 0.3)) * abs(amplitude),
            'rest': {'recoil': float(rng.uniform(0.02, 0.4)) * torque},
        },
        'ship': {'kind': 'components', 'components': waves[:3], 'heave': waves[3:], 'height': 2.0},
        'log': {'interval': 0.5},
    }


def recoil() -> list[Row]:
    """Return how many of the random clocks are counted wrongly, and the phase differences."""
    from motion_cases import moved, sampled
    from reference_propagator import Reference

    rng, miscounted, apart = np.random.default_rng(COUNTED_SEED), 0, 0.0
    for _ in range(COUNTED_CLOCKS):
        scene = scene_of(**_clock(rng))
        machine = compile_machine(scene)
        assert isinstance(machine, Machine)
        forcing = sampled(scene, machine)
        runs = [moved(each, forcing) for each in (Collocation(machine, 1e-12), Reference(machine))]
        phases = [math.pi * (run.half_turns + run.fraction) for run in runs]
        distance = float(np.max(np.abs(phases[0] - phases[1])))
        beats = bool(np.array_equal(runs[0].beats, runs[1].beats))
        miscounted += 0 if beats and distance < math.pi else 1
        apart = max(apart, distance)
    setting = f'{COUNTED_CLOCKS} clocks, {COUNTED_S:g} s each'
    return [
        Row('clocks with recoil at sea, miscounted', setting, float(miscounted), 0.0),
        Row('clocks with recoil at sea, phase [rad]', setting, apart, COUNTED_RAD),
    ]
