"""Tauto itself: from the scene to the wheel, everything included.

At sea the time is that of the ship's motion and the trochlea's stage, chunk by chunk as
`tauto sail` feeds them, without bag, navigation and summary. On land it is that of the propagator
alone, one span over the whole time, the mean of a thousand. The case (f) is computed by `motion`
for a bearing at rest, an hour at a time as the ship's motion would come.
"""

from __future__ import annotations

import math
import time
from contextlib import nullcontext
from dataclasses import replace

import numpy as np

import tauto_core
from benchmarks.work_precision.equations.sea import stretches
from benchmarks.work_precision.peer import Outcome
from benchmarks.work_precision.problems import CaseProblem, HungCase, Problem, WheelProblem
from tauto_core.clockwork import TrochleaStage
from tauto_core.kernels import optimised
from tauto_core.machines import compile_machine
from tauto_core.motion import Forcing, make_propagator
from tauto_core.motion.suspended_case import BearingMotion
from tauto_core.samples import JOINT_STATES, SHIP_IMU, Batches, JointSamples
from tauto_core.scene import Scene
from tauto_core.scene.times import NS_PER_S
from tauto_core.ship import ShipMotion
from tauto_core.voyage import QUIET_CHUNK

NAME = 'tauto'
REPEATS = 1000
WARM_S = 60.0
STRETCH_S = 3600.0

_CLOSED_FORM = 'closed form'
_LOOSE = ('1e-3', '1e-4')
_TOLERANCES = ('1e-6', '1e-8', '1e-9', '1e-10', '1e-12', '1e-14')
_CASE_TOLERANCES = ('1e-9', '1e-10', '2e-12')


class Tauto:
    """This program; settings are the ship's sample rate and the solver's tolerance.

    Those of the case are the steps asked for and the tolerance; steps that miss it are halved.
    """

    name = NAME

    def __init__(self) -> None:
        self._warm: set[tuple[str, str, bool]] = set()

    def version(self) -> str:
        """Return the version of tauto_core."""
        return tauto_core.__version__

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return 'RATE Hz TOLERANCE', coarse to fine, or what needs neither."""
        if isinstance(problem, CaseProblem):
            return tuple(
                f'{rate} Hz {each}' for rate in (31.25, 40, 50) for each in _CASE_TOLERANCES
            )
        if problem.numbers.sea is None:
            return (_CLOSED_FORM,)
        if not problem.numbers.mass:
            return ('1.25 Hz', '1.6 Hz', '2 Hz', '2.5 Hz', '5 Hz', '10 Hz', '20 Hz')
        # with an escapement the clock forgets how finely the sea was sampled
        goes = problem.numbers.impulse_energy > 0.0
        coarse, fine = ((2, 2.5), (4, 5, 10)) if goes else ((2, 2.5, 4, 5), (10, 20))
        # steps end at impulses, before they are as long as the tolerance allows
        each_rate = _LOOSE * goes + _TOLERANCES
        found = [f'{rate} Hz {each}' for rate in coarse for each in (*_LOOSE, '1e-6')]
        return (*found, *(f'{rate} Hz {each}' for rate in fine for each in each_rate))

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem."""
        if isinstance(problem, WheelProblem) and setting == _CLOSED_FORM:
            return _on_land(problem, duration_s)
        long, compiling_s = duration_s > WARM_S, 0.0
        key = problem.key, setting, long
        if key not in self._warm:
            self._warm.add(key)
            # runs longer than a first run use optimised code
            with optimised() if long else nullcontext():
                first, again = (_stepped(problem, setting, WARM_S) for _ in range(2))
            compiling_s = max(0.0, first.run_s - again.run_s)
        outcome = _stepped(problem, setting, duration_s)
        return replace(outcome, compile_s=outcome.compile_s + compiling_s)


def _stepped(problem: Problem, setting: str, duration_s: float) -> Outcome:
    if isinstance(problem, CaseProblem):
        return _hung(problem.numbers, setting, duration_s)
    return _at_sea(scene_of(problem, setting, duration_s))


def _hung(case: HungCase, setting: str, duration_s: float) -> Outcome:
    began = time.perf_counter()
    from tauto_core.motion.suspended_case import AxleSwing  # imports kernels

    first, tolerance = setting.split(' Hz ')
    rate, gravity = float(first), case.gravity
    swing = AxleSwing(
        case.e, case.c, case.k, gravity, tolerance=float(tolerance), step_s=1.0 / rate
    )
    # an accelerated bearing until the start lets the case hang at that angle
    swing.release(-gravity * math.tan(case.release_angle), gravity)
    ready = time.perf_counter()
    for start, length in stretches(duration_s, STRETCH_S):
        at_rest = BearingMotion(
            begin_ns=np.array([round(start * NS_PER_S)]),
            length_ns=np.array([round(length * NS_PER_S)]),
            parts=np.array([round(length * rate)]),
            sway=np.zeros((1, 1)),
            lift=np.full((1, 1), gravity),
        )
        motion = swing.advance(at_rest)
    run_s = time.perf_counter() - ready
    angle, speed = float(motion.phi[-1]), float(motion.phi_rate[-1])
    return Outcome(duration_s, angle, speed, run_s, ready - began)


def scene_of(problem: WheelProblem, setting: str, duration_s: float) -> Scene:
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
    for _ in range(0, ship.total, QUIET_CHUNK):
        said = stage.feed({SHIP_IMU: ship.sense(QUIET_CHUNK)}) or said
    said = stage.finish() or said
    run_s = time.perf_counter() - ready
    wheel = said[JOINT_STATES]
    if not isinstance(wheel, JointSamples):
        raise TypeError(f'{JOINT_STATES} holds {type(wheel).__name__}')
    angle, rate = float(wheel.position[-1, 0]), float(wheel.velocity[-1, 0])
    return Outcome(scene.duration, angle, rate, run_s, ready - began)


def _on_land(problem: WheelProblem, duration_s: float) -> Outcome:
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
