"""Rows of the stress table that compare the predicted error of a scene with the actual one.

Random scenes at sea, for every propagator, fixed or suspended, with real threads or ideal ones,
with and without an escapement, at 1 to 20 samples a second. The actual error is the largest
distance of the reading, at logged instants, from DOP853 on the exact motion of the ship
(`exact_phase`); the prediction is `error_s` of `tauto scene check`. The actual error must not
exceed the prediction, nor be less than a thirtieth of it unless it is below the accuracy of
DOP853.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml
from stress_cases import (
    ARC,
    FORCE,
    HOLE,
    HOLE_CAM,
    VERTICAL,
    Row,
    phase_error,
    sail,
    without_settings,
)

from tauto_core.checks.cost import RESOLUTION_S, forecast
from tauto_core.checks.readiness import check_scene
from tauto_core.machines import FluidPendulum, compile_machine
from tauto_core.samples import PHASE
from tauto_core.scene import Scene, load_scene, parse_scene
from tauto_core.scene.errors import PropagationError, SceneError
from tauto_core.scene.sections import Solver
from tauto_core.scene.times import LEGIBLE

SEED = 1726
SCENES = 100
FACTOR = 30.0
RATES = (1.0, 1.0, 2.0, 2.0, 4.0, 4.0, 5.0, 8.0, 10.0, 20.0)
"""Sampling rates, one of which is drawn [Hz]; a case needs at least `HUNG` for its own swings."""
HUNG = 4.0
TOLD_S = 1e-11
"""Accuracy of DOP853 at a relative tolerance of 1e-13 over these runs [s]."""

CALM = {'kind': 'involute', 'base_radius': 0.005}
WEIGHT = {'cam': CALM, 'thread': VERTICAL, 'power': {'kind': 'weight', 'mass': 0.322}}
FORCED = {'cam': HOLE_CAM, 'thread': HOLE, 'power': {'kind': 'force', 'force': FORCE}}
SPRING = {**FORCED, 'power': {'kind': 'spring', 'force': FORCE, 'stiffness': 5.0}}
CHEEK = {'cam': ARC, 'thread': VERTICAL, 'power': {'kind': 'force', 'force': FORCE}}
HEAVY_CHEEK = {**WEIGHT, 'cam': {'kind': 'circular_arc', 'radius': 0.006, 'root_depth': 0.003}}
LEVER = {
    'cam': {'kind': 'involute', 'base_radius': 0.02},
    'thread': {'kind': 'lever', 'arm': 0.1, 'weight_arm': 0.15, 'length': 0.3},
    'power': {'kind': 'weight', 'mass': 0.05},
}
HANGING = {**WEIGHT, 'thread': {'kind': 'hanging', 'length': 1.0}}
SHORTER = {**WEIGHT, 'thread': {'kind': 'hanging', 'length': 0.5}}
OWN_CAM_WEIGHT = {**WEIGHT, 'cam': {'kind': 'weight_corrected', 'period': 1.0}}
OWN_CAM_SPRING = {
    'cam': {'kind': 'spring_corrected', 'period': 1.0},
    'thread': HOLE,
    'power': {'kind': 'spring', 'force': 3.1582734083486, 'stiffness': 50.0},
}
OWN_CAM_LEVER = {**LEVER, 'cam': {'kind': 'lever_corrected', 'period': 1.0}}
PENDULUM = {
    'inertia': 0.01,
    'cam': {'kind': 'hole', 'lever_rate': 0.0005},
    'thread': HOLE,
    'power': {'kind': 'force', 'force': 1e-4},
    'imbalance': {'moment': 0.0402445},
    'release_angle': 0.1,
}
CASE = {'kind': 'axle', 'support_radius': 0.32, 'axle_radius': 0.02, 'depth': 0.3}
HUNG_CASE = {'suspension': {**CASE, 'gyration_radius': 0.3}}


def driven(energy: float = 1.23e-4, angle: float = 0.0) -> dict[str, Any]:
    """Return drag, and the escapement that gives as much energy at each beat [J]."""
    return {
        'drag': {'viscous': 1.25e-5},
        'escapement': {'kind': 'impulse', 'energy': energy, 'angle': angle},
    }


KINDS: dict[str, dict[str, Any]] = {
    'force': {'trochlea': FORCED},
    'force, drag': {'trochlea': FORCED, 'drag': {'viscous': 1e-5}},
    'weight': {'trochlea': WEIGHT},
    'massless weight': {
        'trochlea': {**WEIGHT, 'power': {'kind': 'weight', 'mass': 0.322, 'massless': True}}
    },
    'weight, drag, escapement': {'trochlea': WEIGHT, **driven()},
    'circular arc': {'trochlea': CHEEK},
    'spring': {'trochlea': SPRING},
    'lever': {'trochlea': LEVER},
    'hanging thread': {'trochlea': HANGING},
    'hung, force': {'trochlea': FORCED, **HUNG_CASE},
    'hung, weight': {'trochlea': WEIGHT, 'suspension': {**CASE, 'gyration_radius': 0.25}},
    'driven force': {'trochlea': FORCED, **driven()},
    'driven cheek': {'trochlea': CHEEK, **driven()},
    'driven cheek, weight': {'trochlea': HEAVY_CHEEK, **driven(angle=0.1)},
    'driven lever': {'trochlea': LEVER, **driven(angle=0.1)},
    'driven hanging thread': {'trochlea': SHORTER, **driven()},
    'driven own cam, weight': {'trochlea': OWN_CAM_WEIGHT, **driven()},
    'driven own cam, spring': {'trochlea': OWN_CAM_SPRING, **driven(angle=-0.1)},
    'driven own cam, lever': {'trochlea': OWN_CAM_LEVER, **driven()},
    'driven pendulum': {'trochlea': PENDULUM, **driven(1.23e-6)},
    'hung, driven weight': {'trochlea': WEIGHT, **driven(), **HUNG_CASE},
    'hung, driven cheek, weight': {'trochlea': HEAVY_CHEEK, **driven(), **HUNG_CASE},
    'hung, driven lever': {'trochlea': LEVER, **driven(), **HUNG_CASE},
    'hung, driven hanging thread': {'trochlea': SHORTER, **driven(), **HUNG_CASE},
    'hung, driven own cam, lever': {'trochlea': OWN_CAM_LEVER, **driven(), **HUNG_CASE},
}
"""Each kind runs a different propagator, or a different system in it. What is driven steps from
impulse to impulse at the coarser accuracies.
"""


@dataclass(frozen=True)
class Comparison:
    """A scene, the predicted and actual error of its reading [s], and whether it is chaotic."""

    scene: Scene
    predicted_s: float
    found_s: float
    is_chaotic: bool

    @property
    def short(self) -> float:
        """Actual error, less the accuracy of DOP853, over the prediction; at most 1."""
        return max(self.found_s - TOLD_S, 0.0) / self.predicted_s

    @property
    def beyond(self) -> float:
        """The prediction over the actual error, or over the accuracy of DOP853."""
        return self.predicted_s / max(self.found_s, TOLD_S)


def drawn(
    count: int, kinds: tuple[str, ...] = tuple(KINDS), rates: tuple[float, ...] = RATES
) -> Iterator[Scene]:
    """Yield random scenes that run, of each kind in turn."""
    random = np.random.default_rng(SEED)
    made = 0
    while made < count:
        kind = kinds[made % len(kinds)]
        try:
            scene = _scene(random, kind, rates)
            check_scene(scene)
            sail(scene)
        except (PropagationError, SceneError):
            continue
        made += 1
        yield scene


def _scene(random: np.random.Generator, kind: str, rates: tuple[float, ...]) -> Scene:
    sections = KINDS[kind]
    trochlea = sections['trochlea']
    hung = 'suspension' in sections
    rate = float(random.choice([each for each in rates if each >= HUNG or not hung]))
    ship = _components(random, rate) if random.random() < 0.6 else _sea(random)
    release = random.uniform(0.3, 1.2) * random.choice([-1.0, 1.0])
    release *= trochlea.get('release_angle', 1.0)
    content = {
        **sections,
        'name': f'{kind}, {ship["kind"]}, {rate:g} Hz',
        'duration': 15.0 if hung or 'circular_arc' in str(sections) else 30.0,
        'seed': int(random.integers(2**31)),
        'trochlea': {'inertia': 4e-4, **trochlea, 'release_angle': float(release)},
        'ship': {**ship, 'rate': rate, 'height': float(random.uniform(-2.0, 6.0))},
    }
    return parse_scene(yaml.safe_dump(content), 'stress')


def _components(random: np.random.Generator, rate: float) -> dict[str, Any]:
    """Return up to four waves of roll and two of heave, of at least four samples each."""

    def waves(count: int, largest: float) -> list[dict[str, float]]:
        return [
            {
                'amplitude': float(random.uniform(0.1, 1.0) * largest * (period / 12.0) ** 2),
                'period': float(period),
                'phase': float(random.uniform(-math.pi, math.pi)),
            }
            for period in np.exp(random.uniform(*np.log([max(4.0 / rate, 1.0), 16.0]), count))
        ]

    heave = int(random.integers(3))
    return {
        'kind': 'components',
        'components': waves(int(random.integers(1, 5)), 0.08),
        **({'heave': waves(heave, 0.6)} if heave else {}),
    }


def _sea(random: np.random.Generator) -> dict[str, Any]:
    """Return a sea whose shortest waves have more than two samples."""
    return {
        'kind': 'sea',
        'sea': {
            'spectrum': 'bretschneider',
            'significant_wave_height': float(random.uniform(0.5, 3.0)),
            'peak_period': float(random.uniform(9.0, 15.0)),
            'components': 24,
        },
        'roll': {
            'natural_period': float(random.uniform(9.0, 16.0)),
            'damping_ratio': 0.08,
            'slope_coefficient': 0.7,
        },
        'heave': bool(random.random() < 0.5),
    }


def compared(scene: Scene) -> Comparison:
    """Return the predicted and the actual error of a scene's reading."""
    machine = compile_machine(scene)
    assert not isinstance(machine, FluidPendulum)
    told = forecast(scene, machine)
    away = phase_error(scene)
    nominal_s = scene.clock.nominal_period or machine.small_period
    found_s = float(np.max(np.abs(away))) * nominal_s / math.tau
    chaotic = told.growth is not None and told.growth.is_chaotic
    return Comparison(scene, told.phase_error_s, found_s, chaotic)


def bounds(count: int = SCENES, kinds: tuple[str, ...] = tuple(KINDS)) -> list[Row]:
    """Return by kind how far predictions are below and above actual errors."""
    found = [compared(scene) for scene in drawn(count, kinds)]
    rows = []
    for kind in kinds:
        mine = [
            each for each in found if each.scene.name.startswith(f'{kind}, {each.scene.ship.kind}')
        ]
        legible = sum(each.found_s > TOLD_S for each in mine)
        setting = f'{kind}: {len(mine)} scenes, {legible} with an error above {TOLD_S:g} s'
        short = max(each.short for each in mine)
        rows.append(
            Row('error of the reading found by that predicted, largest', setting, short, 1.0)
        )
        for chaotic, where, limit in ((False, '', FACTOR), (True, ', in chaos', CHAOTIC_FACTOR)):
            beyond = [each.beyond for each in mine if each.is_chaotic == chaotic]
            words = f'error of the reading predicted by that found, largest{where}'
            rows += [Row(words, setting, max(beyond), limit)] if beyond else []
    return rows


ACCURACIES = (1e-9, 1e-7, 1e-5, 1e-3, 1e-1)


def accuracies(count: int = SCENES, kinds: tuple[str, ...] = tuple(KINDS)) -> list[Row]:
    """Return by accuracy asked how far bound and accuracy are exceeded, over the same scenes.

    The accuracy is that of a day, and a shorter run may err as much; what a run of seconds shows
    is the error of its first windows, the largest of all.
    """
    rows, scenes = [], list(drawn(count, kinds))
    for asked in ACCURACIES:
        found = []
        for scene in scenes:
            found.append(compared(parse_scene(without_settings(scene, accuracy=asked), 'stress')))
        setting = f'{count} scenes asked for {asked:g} s/day'
        short = max(each.short for each in found)
        over = max(each.found_s - TOLD_S for each in found) / asked
        rows.append(
            Row('error of the reading found by that predicted, largest', setting, short, 1.0)
        )
        rows.append(
            Row('error of the reading found by that asked for, largest', setting, over, 1.0)
        )
    return rows


LONG = (
    ('second_cam_at_sea', 8.0, (1726,)),
    ('cheek_before_euler', 8.0, (1726,)),
    ('sully_lever_at_sea', 8.0, (1726,)),
    ('suspended_weight_at_sea', 8.0, (1726,)),
    ('involute_weight_at_sea', 12.0, (1726, 1, 2, 3)),
    ('involute_weight_at_sea', 36.0, (1726, 1, 2, 3)),
    ('hanging_thread_at_sea', 8.0, (1726, 1, 2, 3, 4, 5)),
)
"""Scenes that are run for so many hours, by their seeds."""
LOGGED = {'log.interval': 10.0, 'log.motion': False, 'drift.observation_interval': 3600.0}
FINER_RATE = 4.0
CHAOTIC_FACTOR = 1e5
"""The same where errors grow exponentially, by ten decades up to the time for which there is a
bound. Growth two standard errors faster than was found makes up to five of them.
"""


def compared_long(scene: Scene) -> tuple[Comparison, float]:
    """Return the errors of a scene that is logged every 10 s, and how long they have a bound [s].

    The actual error is the largest distance from a run with four times as many samples and a
    tolerance of 1e-13, up to the time for which there is a bound.
    """
    machine = compile_machine(scene)
    assert not isinstance(machine, FluidPendulum)
    told = forecast(scene, machine)
    ship = scene.ship.model_copy(update={'rate': FINER_RATE * scene.ship.rate})
    finer = scene.model_copy(update={'ship': ship, 'solver': Solver(tolerance=1e-13)})
    one, other = (sail(each)[PHASE].position[:, 1:3] for each in (scene, finer))
    nominal_s = scene.clock.nominal_period or machine.small_period
    apart_s = 0.5 * nominal_s * np.abs((one - other).sum(axis=1))
    end, predicted_s = len(apart_s), told.error_s
    if told.bounded_until_s is not None:
        end, predicted_s = int(told.bounded_until_s / 10.0), LEGIBLE * nominal_s
    assert predicted_s is not None
    chaotic = told.growth is not None and told.growth.is_chaotic
    return Comparison(scene, predicted_s, float(np.max(apart_s[:end])), chaotic), end * 10.0


def extrapolations() -> list[Row]:
    """Return how bounds compare with the errors of long runs, chaotic ones among them."""
    rows = []
    for name, hours, seeds in LONG:
        for seed in seeds:
            scene = load_scene(name, duration=hours * 3600.0, seed=seed, **LOGGED)
            found, end_s = compared_long(scene)
            setting = f'{name}, {end_s / 3600.0:.1f} of {hours:g} h, seed {seed}'
            setting += ', chaotic' * found.is_chaotic
            rows += [
                Row(
                    'error of a long run by that predicted',
                    setting,
                    found.found_s / found.predicted_s,
                    1.0,
                ),
                Row(
                    'error predicted of a long run by that found',
                    setting,
                    found.predicted_s / max(found.found_s, RESOLUTION_S),
                    CHAOTIC_FACTOR if found.is_chaotic else FACTOR,
                ),
            ]
    return rows


HOUR_ACCURACIES = (1e-7, 1e-5, 1e-3)
STEADY = tuple(kind for kind in KINDS if kind != 'driven pendulum')
"""Kinds whose reading is well defined in any sea. The roll tilts a pendulum's swing by more than
it is wide, and the dial counts a turn more or less where it just fails to reach the middle.
"""


def hours(count: int = 2 * len(STEADY), kinds: tuple[str, ...] = STEADY) -> list[Row]:
    """Return by accuracy asked how far bound and accuracy are exceeded in an hour.

    What happens once in a thousand swings, such as an impulse that is missed, shows only here.
    """
    rows, scenes = [], list(drawn(count, kinds))
    for asked in HOUR_ACCURACIES:
        found = []
        for scene in scenes:
            content = yaml.safe_load(without_settings(scene, accuracy=asked))
            content |= {'duration': 3600.0, 'log': {'interval': 10.0, 'motion': False}}
            content['drift'] = {'observation_interval': 3600.0}
            try:
                found.append(compared_long(parse_scene(yaml.safe_dump(content), 'stress'))[0])
            except PropagationError:  # the sea drives the wheel out of its range
                continue
        calm = [each for each in found if not each.is_chaotic]
        setting = f'{len(found)} scenes, an hour each, asked for {asked:g} s/day'
        short = max(each.short for each in found)
        # in chaos no accuracy is promised
        over = max(each.found_s for each in calm) / asked
        rows += [
            Row('error of the reading found by that predicted, largest', setting, short, 1.0),
            Row(
                'error of the reading found by that asked for, largest',
                f'{setting}, {len(found) - len(calm)} chaotic ones left out',
                over,
                1.0,
            ),
        ]
    return rows
