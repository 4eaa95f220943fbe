"""The run time of a voyage and the error of its simulation, predicted before it is sailed.

A cost is a rough figure: the number of operations times the nanoseconds measured for one. Errors
are those of the simulation relative to its own equations and the exact sea, not the clock's error.
They are bounds, found by running the beginning (`trial`), in weather in each sea that may be the
worst.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from tauto_core.machines import AnyMachine, FluidPendulum, Machine, SlackThreadError
from tauto_core.motion import make_collocation, propagator_name, steps_in
from tauto_core.samples import NS_PER_S, FloatArray
from tauto_core.scene import Scene
from tauto_core.scene.errors import CamRangeError
from tauto_core.ship import ShipMotion
from tauto_core.ship.buffer import samples_a_piece
from tauto_core.ship.felt_step import case_modes, felt_parts, felt_step_ns
from tauto_core.ship.waves import Harmonics
from tauto_core.trial import WORK, Dial, Growth, Limit, Trial, try_out

if TYPE_CHECKING:
    from tauto_core.motion.real_threads import RealThreads
    from tauto_core.motion.wheel import Collocation

# Processor times, the least of four runs: `python -m benchmarks.voyage_cost`, whose results are in
# benchmarks/voyage_cost.json. Intel Xeon, Python 3.11; the kernels were compiled and optimised.
MEASURED_ON = 'a core at 2.3 GHz'
START_S = {
    'harmonic': 0.58,
    'action_angle': 0.58,
    'half_swings': 0.6,
    'forced_harmonic': 0.63,
    'collocation': 0.7,
}
SHIP_NS_A_SAMPLE, SHIP_NS_A_COMPONENT = 9.2, 0.065
FORCED_NS_A_SAMPLE = 25.0
SUSPENDED_NS_A_SAMPLE = 270.0
NS_A_STEP, NS_AN_EVENT = 780.0, 440.0
NS_A_NEWTON_STEP = 6900.0
NS_A_STEP_OF_THREAD = {'lever': 1100.0, 'hanging': 700.0}
NS_A_HALF_SWING = 4800.0
NS_A_LOG = {'harmonic': 270.0, 'action_angle': 1150.0, 'half_swings': 30_000.0}
NAVIGATION_NS_A_LOG = 440.0
COVARIATE_NS_A_SAMPLE = 53.0
COEFFICIENT_RUNS_S = 1.5
"""Run time of the trial runs, for the most expensive machine without a suspension [s]."""

PERIOD_ERROR = 1e-14
"""Largest relative error of a period by quadrature (tests of machines)."""
UNIT_ROUNDING = 2.0**-53

RESOLUTION_S = 1e-9
"""Resolution of the reading, which is in whole nanoseconds: no smaller bound is stated [s]."""

TRIAL_RUN_S = 0.8
"""Approximate run time of the trials for errors together [s], and of those for growth; it limits
how much of a scene they cover.
"""
LONGEST_TRIAL_S = 10.0
"""Processor time after which trials are cut that cost more than was predicted [s]."""


@dataclass(frozen=True)
class Forecast:
    """Expected cost and error of a scene.

    Errors are bounds for the reading of the dial at any logged instant of the run [s]. Of the runs
    compared with independent programs none exceeded them, and none whose error was more than
    rounding was below a thirtieth of them (benchmarks/stress_forecast.py).

    Attributes:
        run_s: run time of `tauto sail` without a bag, within a factor of two or three [s].
        steps_a_swing: steps in a full swing, where the propagator takes steps; else None.
        error_s: bound of all the following together, at least `RESOLUTION_S`; None where one of
            them is not known, or where the motion is chaotic and nothing is known of the end.
        sampling_error_s: bound of the error by sampling the ship's motion; None on a ship that
            lies still, and where its step has no divisor with which to try a finer one. Measured
            motion is taken as exact within its pass-band.
        steps_error_s: bound of the error of the steps by their tolerance, or of a closed form by
            the accuracy of its period; None where the trials were cut before any was seen.
        rounding_error_s: approximate error of the phase by rounding alone, with what it grows to
            where the motion is chaotic. A sum near it means that the run is as exact as doubles
            allow. The reading is rounded to whole nanoseconds besides.
        tried_s: length of the scene that was run to find the bounds [s]; None: nothing had to be.
            Beyond it they are extrapolated.
        was_cut: whether the trials cost so much more than predicted that they were cut.
        growth: growth of a small distance between two motions in the same sea (`trial.Growth`);
            None where no steps are taken, and on land unless a thread swings.
        bounded_until_s: time from which on the bound exceeds a quarter of a period, in a chaotic
            motion; else None.
        decided_by: the sea in which the largest bound was found: `why` it was tried, `highest` or
            `met fastest` or both, and its figures as in `weather.states`; None without weather.
        shortest_wave_s: least period in the motion that the clock feels there, including the
            swings of a suspended case [s]; None on a ship that lies still or whose motion was
            measured, without a suspension.
    """

    run_s: float
    steps_a_swing: float | None
    error_s: float | None
    sampling_error_s: float | None
    steps_error_s: float | None
    rounding_error_s: float
    tried_s: float | None
    shortest_wave_s: float | None
    was_cut: bool = False
    growth: Growth | None = None
    bounded_until_s: float | None = None
    decided_by: dict[str, Any] | None = None

    @property
    def phase_error_s(self) -> float:
        """Bound of the error of the phase, which is not rounded to nanoseconds [s]."""
        parts = self.sampling_error_s, self.steps_error_s, self.rounding_error_s
        return sum(part for part in parts if part is not None)


def forecast(
    scene: Scene,
    machine: AnyMachine | FluidPendulum,
    motion: ShipMotion,
    progress: Callable[[float], None] | None = None,
) -> Forecast:
    """Return the expected cost and error of a scene.

    Args:
        scene: a scene that runs.
        machine: the machine of the scene.
        motion: the motion of the scene's ship.
        progress: called with the share done of the trials, from 0 to 1.
    """
    if isinstance(machine, FluidPendulum):
        return _forecast_in_fluid(scene, machine, motion)
    still = scene.lies_still
    name = propagator_name(machine, still=still)
    swing_s = _swing_s(machine)
    allowed = None if scene.solver is None else scene.solver.tolerance
    engine = make_collocation(machine, allowed) if name == 'collocation' else None
    samples = samples_a_piece(scene, steps_in(engine))
    piece_s = samples * felt_step_ns(scene) / NS_PER_S
    steps = None if engine is None else _steps(scene, machine, engine, swing_s, piece_s)
    nominal_s = scene.clock.nominal_period or machine.small_period
    run_s = _run_s(scene, name, motion, scene.duration / swing_s, steps)
    step_s = felt_step_ns(scene) / NS_PER_S if steps is None else swing_s / steps.a_swing
    rounding_s = _rounding_s(scene.duration, step_s, nominal_s)
    if steps is None and still:
        lost_s = scene.duration * PERIOD_ERROR if name == 'action_angle' else 0.0
        return Forecast(
            run_s=run_s,
            steps_a_swing=None,
            error_s=_stated(lost_s + rounding_s),
            sampling_error_s=None,
            steps_error_s=lost_s,
            rounding_error_s=rounding_s,
            tried_s=None,
            shortest_wave_s=_shortest_wave_s(scene),
        )
    seas = scene.ship.worst_seas(scene)
    longest_s = scene.duration * TRIAL_RUN_S / (len(seas) * WORK * (run_s - START_S[name]))
    found: list[tuple[float, Trial, Scene, dict[str, Any] | None]] = []
    for sea in seas:
        there = scene.model_copy(update={'ship': sea.ship})
        limit = Limit(LONGEST_TRIAL_S / len(seas), partial(_tell, progress, len(found), len(seas)))
        trial = try_out(
            there,
            Dial(nominal_s, rounding_s),
            longest_s,
            None if steps is None else tolerance(scene),
            limit,
            sea.lasts_s,
        )
        unknown = trial.steps_s is None or not (there.lies_still or trial.sampling_s is not None)
        parts_s = (trial.sampling_s or 0.0) + (trial.steps_s or 0.0) + trial.rounding_s
        state = None if sea.figures is None else {'why': sea.why, **sea.figures}
        found.append((math.inf if unknown else parts_s, trial, there, state))
    parts_s, trial, there, state = max(found, key=lambda each: each[0])
    newton_a_swing = max(each.newton_a_second for _, each, _, _ in found) * swing_s
    rounding_s += trial.rounding_s
    known = math.isfinite(parts_s) and trial.until_s is None
    a_swing = None if steps is None else max(steps.a_swing, newton_a_swing)
    return Forecast(
        run_s=run_s + scene.duration / swing_s * newton_a_swing * NS_A_NEWTON_STEP / NS_PER_S,
        steps_a_swing=a_swing,
        error_s=_stated(parts_s - trial.rounding_s + rounding_s) if known else None,
        sampling_error_s=trial.sampling_s,
        steps_error_s=trial.steps_s,
        rounding_error_s=rounding_s,
        tried_s=trial.tried_s,
        shortest_wave_s=_shortest_wave_s(there),
        was_cut=any(each.was_cut for _, each, _, _ in found),
        growth=trial.growth,
        bounded_until_s=trial.until_s,
        decided_by=state,
    )


def _stated(error_s: float) -> float:
    """Return the bound that is stated of a reading, which is rounded to `RESOLUTION_S`."""
    return max(error_s + 0.5 * RESOLUTION_S, RESOLUTION_S)


def _tell(progress: Callable[[float], None] | None, done: int, seas: int, share: float) -> None:
    """Tell the share done of the trials in all seas."""
    if progress is not None:
        progress((done + share) / seas)


def _forecast_in_fluid(scene: Scene, machine: FluidPendulum, motion: ShipMotion) -> Forecast:
    half_swings = 2.0 * scene.duration / machine.small_period
    run_s = _run_s(scene, 'half_swings', motion, 0.0, None)
    rounding, lost = 0.5 * machine.small_period * UNIT_ROUNDING, scene.duration * PERIOD_ERROR
    return Forecast(
        run_s=run_s + half_swings * NS_A_HALF_SWING / NS_PER_S,
        steps_a_swing=None,
        error_s=_stated(lost + rounding),
        sampling_error_s=None,
        steps_error_s=lost,
        rounding_error_s=rounding,
        tried_s=None,
        shortest_wave_s=None,
    )


def _rounding_s(duration_s: float, step_s: float, nominal_s: float) -> float:
    """Return half a unit of the fraction, and the sum of random rounding errors of each step."""
    walk = math.sqrt(duration_s / step_s) / math.tau
    return nominal_s * UNIT_ROUNDING * (0.5 + walk)


def _shortest_wave_s(scene: Scene) -> float | None:
    frequencies = scene_waves(scene).frequency.tolist()
    if scene.suspension is not None:
        squares = case_modes(scene.suspension).squared_frequencies(scene.gravity)
        frequencies.append(math.sqrt(squares[1]))
    return math.tau / max(frequencies) if frequencies else None


@dataclass(frozen=True)
class _Steps:
    """Steps of the collocation in a swing, and the events in it: impulses, and passages over a
    kink of the cam."""

    a_swing: float
    events: int


def _steps(
    scene: Scene,
    machine: AnyMachine,
    engine: Collocation | RealThreads,
    swing_s: float,
    piece_s: float,
) -> _Steps:
    step_s = piece_s / math.ceil(piece_s / engine.longest_step_s)
    kinked = isinstance(machine, Machine) and machine.cam.kinked
    return _Steps(swing_s / step_s, 2 * (int(kinked) + int(scene.escapement is not None)))


def tolerance(scene: Scene) -> float:
    """Return the relative error that a scene allows in one step of the collocation."""
    if scene.solver is not None and scene.solver.tolerance is not None:
        return scene.solver.tolerance
    from tauto_core.motion.stepping import TOLERANCE  # imports kernels

    return TOLERANCE


@dataclass(frozen=True)
class Waves:
    """The harmonics of a ship's motion, arrays of shape (n,).

    Attributes:
        frequency: Ω [rad/s], > 0.
        roll: amplitude [rad].
        sway: amplitude of the apparent vertical's direction [rad].
        heave: amplitude of the apparent gravity, over gravity.
    """

    frequency: FloatArray
    roll: FloatArray
    sway: FloatArray
    heave: FloatArray


def scene_waves(scene: Scene) -> Waves:
    """Return a scene's waves, linearised: β = H ρ̈/g, g_eff = g + z̈ (theory E1).

    None for a ship that lies still, or whose motion was measured; in weather those of the highest
    sea.
    """
    ship = scene.ship
    roll = heave = np.empty((2, 0))
    if ship.is_computed:
        moved = ship.roughest(scene).channels(scene)
        roll, heave = (
            np.array([motion.amplitude, motion.period])
            if isinstance(motion, Harmonics)
            else none_of_it
            for motion, none_of_it in ((moved.roll, roll), (moved.heave, heave))
        )
    rolls, heaves = math.tau / roll[1], math.tau / heave[1]
    none = np.zeros(len(heaves))
    return Waves(
        np.concatenate([rolls, heaves]),
        np.concatenate([roll[0], none]),
        np.concatenate([abs(ship.height) * roll[0] * rolls**2 / scene.gravity, none]),
        np.concatenate([0.0 * rolls, heave[0] * heaves**2 / scene.gravity]),
    )


def _swing_s(machine: AnyMachine) -> float:
    """Return the period of the swing as released; of small swings if it cannot swing freely."""
    try:
        return machine.period(machine.release_angle)
    except (CamRangeError, SlackThreadError):
        return machine.small_period


def _run_s(
    scene: Scene, name: str, motion: ShipMotion, swings: float, steps: _Steps | None
) -> float:
    told = motion.metadata
    channels = 1 + bool(told.get('heave'))
    waves = channels * int(told.get('components', 0)) * float(told.get('seas_at_once', 1.0))
    work_ns = scene.log_count * (NAVIGATION_NS_A_LOG + NS_A_LOG.get(name, 0.0))
    work_ns += motion.total * (SHIP_NS_A_SAMPLE + SHIP_NS_A_COMPONENT * waves)
    felt = motion.total * felt_parts(scene)
    if scene.drift.covariates:
        work_ns += motion.total * COVARIATE_NS_A_SAMPLE * len(scene.drift.covariates)
        work_ns += COEFFICIENT_RUNS_S * NS_PER_S
    if scene.suspension is not None:
        work_ns += felt * SUSPENDED_NS_A_SAMPLE
    if name == 'forced_harmonic':
        work_ns += felt * FORCED_NS_A_SAMPLE
    if steps is not None:
        work_ns += swings * (steps.a_swing * step_ns(scene) + steps.events * NS_AN_EVENT)
    return START_S[name] + work_ns / NS_PER_S


def step_ns(scene: Scene) -> float:
    """Return the cost of a step of the collocation for the scene's kind of thread [ns]."""
    thread = '' if scene.trochlea is None else scene.trochlea.thread.kind
    return NS_A_STEP_OF_THREAD.get(thread, NS_A_STEP)
