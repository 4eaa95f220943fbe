"""The cases of the stress table: machines, runs on land and at sea."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import Machine, compile_machine
from tauto_core.motion import Forcing
from tauto_core.motion.collocation import Collocation
from tauto_core.motion.gauss_step import PLANE
from tauto_core.motion.stepping import TOLERANCE
from tauto_core.samples import PHASE, SHIP_IMU, Batches, FloatArray, join
from tauto_core.scene import Scene, parse_scene, scene_yaml
from tauto_core.ship import ShipMotion

# The independent programs of the tests: reference_propagator, motion_cases.
sys.path.append(str(Path(__file__).resolve().parents[1] / 'tests' / 'core' / 'motion'))

INERTIA, LEVER_RATE, FORCE = 4.0e-4, 0.01, 2.0


@dataclass(frozen=True)
class Row:
    """A line of the table: a measured figure, and the limits between which it must lie.

    NaN lies between no limits. A limit that is known to be broken has a reason; if it then holds,
    the row is reported, so that the reason does not outlive the fault.
    """

    name: str
    setting: str
    measured: float
    high: float
    low: float = -math.inf
    known_fault: str = ''

    @property
    def holds(self) -> bool:
        """Whether the figure is within its limits."""
        return bool(self.low <= self.measured <= self.high)

    @property
    def verdict(self) -> str:
        """The verdict of the row."""
        if self.known_fault:
            return 'HOLDS, NO FAULT ANY MORE' if self.holds else f'known: {self.known_fault}'
        return '' if self.holds else 'BROKEN'

    @property
    def limit(self) -> str:
        """The limits in words."""
        if self.low == -math.inf:
            return f'<= {self.high:.3g}'
        return f'{self.low:.3g} to {self.high:.3g}'


VERTICAL = {'kind': 'vertical'}
HOLE = {'kind': 'hole', 'distance': 0.08}
INVOLUTE = {'kind': 'involute', 'base_radius': LEVER_RATE}
HOLE_CAM = {'kind': 'hole', 'lever_rate': LEVER_RATE}
ARC = {'kind': 'circular_arc', 'radius': 0.02, 'root_depth': 0.01}


def weight(ratio: float) -> dict[str, Any]:
    """Return the weight on the involute with m r^2/I = ratio, r the base radius."""
    mass = ratio * INERTIA / LEVER_RATE**2
    return {'cam': INVOLUTE, 'thread': VERTICAL, 'power': {'kind': 'weight', 'mass': mass}}


WELLS: dict[str, dict[str, Any]] = {
    'weight': weight(0.5),
    'arc': {'cam': ARC, 'thread': VERTICAL, 'power': {'kind': 'force', 'force': FORCE}},
    'spring': {
        'cam': HOLE_CAM,
        'thread': HOLE,
        'power': {'kind': 'spring', 'force': FORCE, 'stiffness': 50.0},
    },
}
"""Conservative wells that are far from harmonic, each for another reason."""


def scene_of(trochlea: dict[str, Any] | None = None, **sections: Any) -> Scene:
    """Return Euler's second cam with a force, released at 1 rad on land, with changes."""
    base = {
        'name': 'stress',
        'duration': 60.0,
        'log': {'interval': 1.0},
        'solver': {'tolerance': TOLERANCE},
        'trochlea': {
            'inertia': INERTIA,
            'cam': HOLE_CAM,
            'thread': HOLE,
            'power': {'kind': 'force', 'force': FORCE},
            'release_angle': 1.0,
            **(trochlea or {}),
        },
    }
    return parse_scene(yaml.safe_dump({**base, **sections}), 'stress')


def machine_of(trochlea: dict[str, Any] | None = None, **sections: Any) -> Machine:
    """Return the machine of such a scene."""
    return compile_machine(scene_of(trochlea, **sections))


def rolling(*components: tuple[float, float, float], **more: Any) -> dict[str, Any]:
    """Return a ship that rolls by (amplitude [rad], period [s], phase [rad]) about the clock."""
    keys = ('amplitude', 'period', 'phase')
    roll = [dict(zip(keys, component, strict=True)) for component in components]
    return {'kind': 'components', 'components': roll, 'height': 0.0, **more}


def sail(scene: Scene, *, chunk: int | None = None, finer: float | None = None) -> Batches:
    """Return all output of the trochlea in a scene, fed at once or in chunks of samples.

    With `finer`, the collocation keeps this tolerance, over the pieces of motion of the scene's
    own.
    """
    ship, stage = ShipMotion(scene), TrochleaStage(scene)
    if finer is not None and isinstance(stage._propagator, Collocation):
        stage._propagator = Collocation(stage._machine, finer)
    said: list[Batches] = []
    while len((imu := ship.produce(chunk or ship.total)).stamp_ns):
        said.append(stage.feed({SHIP_IMU: imu}))
    said.append(stage.finish())
    return joined(said)


def joined(batches: list[Batches]) -> Batches:
    """Return batches, one after the other, as one."""
    names = {name for batch in batches for name in batch}
    return {name: join([batch[name] for batch in batches if name in batch]) for name in names}


def without_settings(scene: Scene, **solver: float) -> str:
    """Return a scene in YAML without its rate of samples, with the settings given."""
    content = yaml.safe_load(scene_yaml(scene))
    content['ship'].pop('rate', None)
    content['solver'] = solver or None
    return yaml.safe_dump(content)


@lru_cache(maxsize=200)
def _exact_phase(scene: str) -> FloatArray:
    from reference_propagator import exact_phase

    return exact_phase(parse_scene(scene, 'stress'))


def phase_error(scene: Scene) -> FloatArray:
    """Return the error of the phase at logged instants after the first [rad], in ±π.

    The truth is DOP853 on the exact motion of the ship. Rate and accuracy do not change it.
    """
    phase = sail(scene)[PHASE].position[1:]
    away = math.pi * (phase[:, 1] % 2.0 + phase[:, 2]) - _exact_phase(without_settings(scene))
    return np.asarray((away + math.pi) % math.tau - math.pi)


def land(step_s: float, count: int, every: int = 1) -> Forcing:
    """Return spans of one step each on land, with every so many of them logged."""
    index = np.arange(1, count + 1)
    ends_ns = np.round(index * (step_s * 1e9)).astype(np.int64)
    return Forcing(
        np.full(count, step_s), np.zeros(count), np.ones(count), ends_ns, index % every == 0
    )


def states(engine: Collocation, step_s: float, logs: int, every: int) -> FloatArray:
    """Release on land; return (x, momentum per inertia) after every so many steps, (logs, 2).

    The engine keeps the state in twofold numbers, of which long doubles hold more digits than
    doubles do. A step is no longer than the engine's own.
    """
    spans = land(step_s, every, every)
    engine.release(spans)
    planes = np.empty(logs, PLANE)
    for k in range(logs):
        engine.advance(spans)
        planes[k] = engine._state['planes'][0]
    x, x_rest, y, y_rest = (planes[name].astype(np.longdouble) for name in PLANE.names or ())
    return np.stack([x + x_rest, np.longdouble(engine._omega) * (y + y_rest)], axis=1)


def energy(machine: Machine, angle: FloatArray, rate: FloatArray) -> FloatArray:
    """Return M theta'^2/2 + V on land [J]."""
    return 0.5 * machine.mass(angle) * rate**2 + machine.potential(angle)


def exponent(lags: FloatArray, sizes: FloatArray) -> float:
    """Return the slope of log size against log lag."""
    return float(np.polyfit(np.log(lags), np.log(sizes), 1)[0])
