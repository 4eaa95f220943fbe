"""The cases of the stress table: machines, and runs of them."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import Machine, compile_machine
from tauto_core.motion import Forcing
from tauto_core.motion.stepping import TOLERANCE
from tauto_core.samples import SHIP_IMU, Batches, join
from tauto_core.scene import Scene, parse_scene
from tauto_core.ship import ShipMotion

# The independent programs of the tests: reference_propagator, thread_references.
sys.path.append(str(Path(__file__).resolve().parents[1] / 'tests' / 'core' / 'motion'))

INERTIA, LEVER_RATE, FORCE = 4.0e-4, 0.01, 2.0


@dataclass(frozen=True)
class Row:
    """A line of the table: a measured figure, and the limits between which it must lie.

    NaN lies between no limits.
    """

    name: str
    setting: str
    measured: float
    high: float
    low: float = -math.inf

    @property
    def holds(self) -> bool:
        """Whether the figure is within its limits."""
        return bool(self.low <= self.measured <= self.high)

    @property
    def limit(self) -> str:
        """The limits in words."""
        if self.low == -math.inf:
            return f'<= {self.high:.3g}'
        return f'{self.low:.3g} to {self.high:.3g}'


VERTICAL = {'kind': 'vertical'}
HOLE = {'kind': 'hole', 'distance': 0.08}
HOLE_CAM = {'kind': 'hole', 'lever_rate': LEVER_RATE}
ARC = {'kind': 'circular_arc', 'radius': 0.02, 'root_depth': 0.01}


WELLS: dict[str, dict[str, Any]] = {
    'weight': {
        'cam': {'kind': 'involute', 'base_radius': LEVER_RATE},
        'thread': VERTICAL,
        # m r^2/I, r the base radius, is a half
        'power': {'kind': 'weight', 'mass': 0.5 * INERTIA / LEVER_RATE**2},
    },
    'arc': {'cam': ARC, 'thread': VERTICAL, 'power': {'kind': 'force', 'force': FORCE}},
    'spring': {
        'cam': HOLE_CAM,
        'thread': HOLE,
        'power': {'kind': 'spring', 'force': FORCE, 'stiffness': 50.0},
    },
}
"""Conservative wells that are far from harmonic, each for another reason."""


def machine_of(trochlea: dict[str, Any]) -> Machine:
    """Return the machine of Euler's second cam, released at 1 rad on land, with changes."""
    scene = {
        'name': 'stress',
        'duration': 60.0,
        'log': {'interval': 1.0},
        'solver': {'tolerance': TOLERANCE},
        'trochlea': {'inertia': INERTIA, 'release_angle': 1.0, **trochlea},
    }
    return compile_machine(parse_scene(yaml.safe_dump(scene), 'stress'))


def sail(scene: Scene) -> Batches:
    """Return all output of the trochlea in a scene."""
    ship, stage = ShipMotion(scene), TrochleaStage(scene)
    said = [stage.feed({SHIP_IMU: ship.produce(ship.total)}), stage.finish()]
    names = {name for batch in said for name in batch}
    return {name: join([batch[name] for batch in said if name in batch]) for name in names}


def land(step_s: float, count: int) -> Forcing:
    """Return spans of one step each on land, all of them logged."""
    ends_ns = np.round(np.arange(1, count + 1) * (step_s * 1e9)).astype(np.int64)
    ones = np.ones(count)
    return Forcing(step_s * ones, 0.0 * ones, ones, ends_ns, ones > 0.0)
