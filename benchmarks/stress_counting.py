"""Rows of the stress table on the counting of turns and beats, for clocks with recoil at sea.

Recoil turns the wheel back soon after its impulse and shifts the middle of the swing, and the
ship's motion moves the neutral line, so a count can go wrong here. Each random clock is compared
with SciPy's DOP853 over the same pieces of the ship's motion, which follows the angles themselves
and looks between its steps for passages that come in pairs.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from reference_propagator import Reference
from stress_cases import FORCE, HOLE, HOLE_CAM, LEVER_RATE, Row, scene_of, weight

from tauto_core.machines import Machine, compile_machine
from tauto_core.motion.wheel import Collocation
from tauto_core.ship import ShipMotion
from tauto_core.ship.buffer import MotionBuffer

CLOCKS = 50
SEED = 1726
DURATION_S = 30.0
PHASE_RAD = 1e-9
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
        'duration': DURATION_S,
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


def _forcing(sections: dict[str, Any]) -> tuple[Machine, Any]:
    scene = scene_of(**sections)
    machine = compile_machine(scene)
    assert isinstance(machine, Machine)
    ship = ShipMotion(scene)
    buffer = MotionBuffer(
        apparent_vertical=machine.follows_apparent_vertical,
        apparent_gravity=machine.feels_gravity,
        still=False,
        step_ns=scene.step_ns,
        max_gap_s=1.0,
        stride=2,
    )
    buffer.add(ship.produce(ship.total), scene.starts_at_ns)
    return machine, buffer.forcing(scene.log_interval_ns, scene.duration_ns, final=True)


def recoil() -> list[Row]:
    """Return how many of the random clocks are counted wrongly, and the phase differences."""
    rng, miscounted, apart = np.random.default_rng(SEED), 0, 0.0
    for _ in range(CLOCKS):
        machine, forcing = _forcing(_clock(rng))
        runs = []
        for propagator in (Collocation(machine, 1e-12), Reference(machine)):
            propagator.release(forcing)
            runs.append(propagator.advance(forcing))
        phases = [math.pi * (run.half_turns + run.fraction) for run in runs]
        distance = float(np.max(np.abs(phases[0] - phases[1])))
        beats = bool(np.array_equal(runs[0].beats, runs[1].beats))
        miscounted += 0 if beats and distance < math.pi else 1
        apart = max(apart, distance)
    setting = f'{CLOCKS} clocks, {DURATION_S:g} s each'
    return [
        Row('clocks with recoil at sea, miscounted', setting, float(miscounted), 0.0),
        Row('clocks with recoil at sea, phase [rad]', setting, apart, PHASE_RAD),
    ]
