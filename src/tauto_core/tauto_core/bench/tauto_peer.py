"""Tauto itself: from the scene to the wheel, all in.

At sea the time is that of the ship's motion and the trochlea's stage, chunk by chunk as
`tauto sail` feeds them, without bag, navigation and summary. On land it is the propagator's alone,
one span over the whole time, the mean of a thousand.
"""

from __future__ import annotations

import time
from importlib.metadata import version

import numpy as np

from tauto_core.bench.peer import Outcome
from tauto_core.bench.problems import Problem
from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import compile_machine
from tauto_core.motion import Forcing, make_propagator
from tauto_core.samples import JOINT_STATES, NS_PER_S, SHIP_IMU, Batches, JointSamples
from tauto_core.scene import Scene
from tauto_core.ship import ShipMotion
from tauto_core.voyage import CHUNK

NAME = 'tauto'
REPEATS = 1000
WARM_S = 60.0

_CLOSED_FORM = 'closed form'
_TOLERANCES = ('1e-6', '1e-8', '1e-10', '1e-12', '1e-14')


class Tauto:
    """This program; settings are the ship's sample rate and the solver's tolerance."""

    name = NAME

    def __init__(self) -> None:
        self._warmed: dict[tuple[str, str], float] = {}

    def version(self) -> str:
        """Return the version of tauto_core."""
        return version('tauto_core')

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return 'RATE Hz TOLERANCE', coarse to fine, or what needs neither."""
        if problem.numbers.sea is None:
            return (_CLOSED_FORM,)
        if not problem.numbers.mass:
            return ('1.6 Hz', '2 Hz', '2.5 Hz', '5 Hz', '10 Hz', '20 Hz')
        # what an escapement keeps going forgets how finely the sea was sampled
        rates = (5, 10) if problem.numbers.impulse_energy else (10, 20)
        return tuple(f'{rate} Hz {each}' for rate in rates for each in _TOLERANCES)

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem."""
        if setting == _CLOSED_FORM:
            return _on_land(problem, duration_s)
        key = problem.key, setting
        if key not in self._warmed:
            first, again = (_at_sea(scene_of(problem, setting, WARM_S)) for _ in range(2))
            self._warmed[key] = max(0.0, first.run_s - again.run_s)
        outcome = _at_sea(scene_of(problem, setting, duration_s))
        compile_s = outcome.compile_s + self._warmed[key]
        return Outcome(duration_s, outcome.angle, outcome.rate, outcome.run_s, compile_s)


def scene_of(problem: Problem, setting: str, duration_s: float) -> Scene:
    """Return a problem's scene at a setting and of a length [s], logged at its end alone."""
    rate, *tolerance = setting.replace(' Hz', '').split()
    scene = problem.scene.model_dump()
    scene['duration'], scene['log']['interval'] = duration_s, duration_s
    scene['drift']['observation_interval'] = duration_s
    scene['ship']['rate'] = float(rate)
    scene['solver'] = {'tolerance': float(tolerance[0])} if tolerance else None
    return Scene.model_validate(scene)


def _at_sea(scene: Scene) -> Outcome:
    began = time.perf_counter()
    ship, stage = ShipMotion(scene), TrochleaStage(scene)
    ready = time.perf_counter()
    said: Batches = {}
    for _ in range(0, ship.total, CHUNK):
        said = stage.feed({SHIP_IMU: ship.produce(CHUNK)}) or said
    said = stage.finish() or said
    run_s = time.perf_counter() - ready
    wheel = said[JOINT_STATES]
    if not isinstance(wheel, JointSamples):
        raise TypeError(f'{JOINT_STATES} holds {type(wheel).__name__}')
    angle, rate = float(wheel.position[-1, 0]), float(wheel.velocity[-1, 0])
    return Outcome(scene.duration, angle, rate, run_s, ready - began)


def _on_land(problem: Problem, duration_s: float) -> Outcome:
    began = time.perf_counter()
    propagator = make_propagator(compile_machine(problem.scene), still=True)
    whole = Forcing(
        length_s=np.array([duration_s]),
        begin=np.zeros(1),
        end=np.ones(1),
        end_ns=np.array([round(duration_s * NS_PER_S)]),
        logged=np.ones(1, np.bool_),
    )
    propagator.release(whole)
    ready = time.perf_counter()
    for _ in range(REPEATS):
        motion = propagator.advance(whole)
    run_s = (time.perf_counter() - ready) / REPEATS
    return Outcome(duration_s, float(motion.angle[0]), float(motion.rate[0]), run_s, ready - began)
