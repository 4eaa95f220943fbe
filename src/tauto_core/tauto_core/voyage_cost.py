"""What a voyage will cost in run time, and how exact it will be, told beforehand.

Both are rough. A cost is the number of things to do times the nanoseconds measured for one. Errors
are those of the simulation against its own equations and the exact sea, not the clock's error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tauto_core.machines import AnyMachine, FluidPendulum, Machine, SlackThreadError
from tauto_core.motion import make_collocation, propagator_name, steps_in
from tauto_core.samples import NS_PER_S, SECONDS_PER_DAY, FloatArray
from tauto_core.scene import Scene
from tauto_core.scene.errors import CamRangeError
from tauto_core.ship import ShipMotion
from tauto_core.ship.buffer import samples_a_piece
from tauto_core.ship.felt_step import case_modes, felt_parts, felt_step_ns
from tauto_core.ship.interpolation import FORCE_BEFORE, ROLL_BEFORE

if TYPE_CHECKING:
    from tauto_core.motion.collocation import Collocation
    from tauto_core.motion.real_threads import RealThreads

# Least of four runs of 10 h at sea or 100 days on land, each stage timed by itself, of the shipped
# scenes ideal, second_cam_at_sea, involute_weight_at_sea and portsmouth_jamaica, and of the cheek
# before Euler on land (action_angle); a day of globe_in_oil on each of its curves, of which the
# dearest counts. Impulses, levers and swinging threads: the eight clocks of `tauto compare` over
# 81 days. The start: processor time of `tauto sail` of a minute.
# Intel Xeon, Python 3.11, Numba 0.68.
MEASURED_ON = 'a core at 2.5 GHz'
START_S = {
    'harmonic': 0.5,
    'action_angle': 0.5,
    'half_swings': 1.0,
    'forced_harmonic': 1.7,
    'collocation': 1.7,
}
SHIP_NS_A_SAMPLE, SHIP_NS_A_COMPONENT = 30.0, 0.5
FORCED_NS_A_SAMPLE = 180.0
SUSPENDED_NS_A_SAMPLE = 1100.0
NS_A_STEP, NS_AN_EVENT = 800.0, 1500.0
NS_A_STEP_OF_THREAD = {'lever': 2000.0, 'hanging': 1600.0}
NS_A_HALF_SWING = 8000.0
NS_A_LOG = {'harmonic': 400.0, 'action_angle': 32_000.0, 'half_swings': 50_000.0}
NAVIGATION_NS_A_LOG = 1200.0

PERIOD_ERROR = 1e-14
"""Relative error of a period by quadrature, at most (tests of machines)."""
UNIT_ROUNDING = 2.0**-53


@dataclass(frozen=True)
class Forecast:
    """Cost and error expected of a scene.

    Attributes:
        run_s: run time of `tauto sail` without a bag, within a factor of two or three [s].
        steps_a_swing: steps in a full swing, where the propagator takes steps; else None.
        steady_error_s: about the error of the reading that does not grow: rounding of the phase,
            and what sampling the ship's motion leaves out [s]; None for measured motion, whose
            truth between the samples nobody knows. A well whose rate depends on the amplitude
            makes a drift of what is wrong with the amplitude; that is not in it.
        growing_error_s_per_day: most that the error of the reading can grow [s/day].
        shortest_wave_s: least period in the motion that the clock feels, the swings of a
            suspended case included [s]; None on a ship that lies still or whose motion was
            measured, without a suspension.
    """

    run_s: float
    steps_a_swing: float | None
    steady_error_s: float | None
    growing_error_s_per_day: float
    shortest_wave_s: float | None


def forecast(scene: Scene, machine: AnyMachine | FluidPendulum, motion: ShipMotion) -> Forecast:
    """Return what a scene will cost and how exact it will be.

    Args:
        scene: one that can sail.
        machine: of the scene.
        motion: of the scene's ship.
    """
    if isinstance(machine, FluidPendulum):
        return _forecast_in_fluid(scene, machine, motion)
    name = propagator_name(machine, still=scene.lies_still)
    swing_s = _swing_s(machine)
    allowed = None if scene.solver is None else scene.solver.tolerance
    engine = make_collocation(machine, allowed) if name == 'collocation' else None
    samples = samples_a_piece(scene, steps_in(engine))
    piece_s = samples * felt_step_ns(scene) / NS_PER_S
    steps = None if engine is None else _steps(scene, machine, engine, swing_s, piece_s)
    waves, bearing = scene_waves(scene), 0.0
    if scene.suspension is not None:
        waves, seas = _in_the_case(scene, waves), waves
        bearing = _bearing_error_s(seas, waves, machine, scene.step_ns / NS_PER_S)
    steady = None
    if scene.ship.is_computed:
        step_s = felt_step_ns(scene) / NS_PER_S
        sampled = sampling_error_s(waves, machine, samples, step_s)
        steady = sampled + bearing + 0.5 * swing_s * UNIT_ROUNDING
    return Forecast(
        run_s=_run_s(scene, name, motion, scene.duration / swing_s, steps),
        steps_a_swing=None if steps is None else steps.a_swing,
        steady_error_s=steady,
        growing_error_s_per_day=_growth(scene, machine, name, swing_s, steps),
        shortest_wave_s=float(math.tau / waves.frequency.max()) if len(waves.frequency) else None,
    )


def _forecast_in_fluid(scene: Scene, machine: FluidPendulum, motion: ShipMotion) -> Forecast:
    half_swings = 2.0 * scene.duration / machine.small_period
    run_s = _run_s(scene, 'half_swings', motion, 0.0, None)
    return Forecast(
        run_s=run_s + half_swings * NS_A_HALF_SWING / NS_PER_S,
        steps_a_swing=None,
        steady_error_s=0.5 * machine.small_period * UNIT_ROUNDING,
        growing_error_s_per_day=SECONDS_PER_DAY * PERIOD_ERROR,
        shortest_wave_s=None,
    )


@dataclass(frozen=True)
class _Steps:
    """Steps of the collocation: how many a swing, a step by the longest allowed, their order, and
    the events in a swing: impulses, and passages over a kink of the cam."""

    a_swing: float
    shorter: float
    order: int
    events: int


def _steps(
    scene: Scene,
    machine: AnyMachine,
    engine: Collocation | RealThreads,
    swing_s: float,
    piece_s: float,
) -> _Steps:
    longest_s = engine.longest_step_s
    step_s = piece_s / math.ceil(piece_s / longest_s)
    kinked = isinstance(machine, Machine) and machine.cam.kinked
    events = 2 * (int(kinked) + int(scene.escapement is not None))
    return _Steps(swing_s / step_s, step_s / longest_s, engine.order, events)


def tolerance(scene: Scene) -> float:
    """Return the relative error that a scene allows in one step of the collocation."""
    if scene.solver is not None and scene.solver.tolerance is not None:
        return scene.solver.tolerance
    from tauto_core.motion.step_size import TOLERANCE  # imports kernels

    return TOLERANCE


@dataclass(frozen=True)
class Waves:
    """The harmonics of a ship's motion, arrays of shape (n,).

    Attributes:
        frequency: Ω [rad/s], > 0.
        roll: amplitude [rad].
        sway: amplitude of the apparent vertical's direction [rad].
        heave: amplitude of the apparent gravity, by gravity.
    """

    frequency: FloatArray
    roll: FloatArray
    sway: FloatArray
    heave: FloatArray


def scene_waves(scene: Scene) -> Waves:
    """Return a scene's waves, linearised: β = H ρ̈/g, g_eff = g + z̈ (theory E1).

    None of a ship that lies still, or whose motion was measured.
    """
    ship = scene.ship
    roll = heave = np.empty((2, 0))
    if ship.is_computed:
        moved = ship.channels(scene)
        roll, heave = (
            channel if harmonics is None else np.array([harmonics.amplitude, harmonics.period])
            for harmonics, channel in ((moved.roll, roll), (moved.heave, heave))
        )
    rolls, heaves = math.tau / roll[1], math.tau / heave[1]
    none = np.zeros(len(heaves))
    return Waves(
        np.concatenate([rolls, heaves]),
        np.concatenate([roll[0], none]),
        np.concatenate([abs(ship.height) * roll[0] * rolls**2 / scene.gravity, none]),
        np.concatenate([0.0 * rolls, heave[0] * heaves**2 / scene.gravity]),
    )


def _in_the_case(scene: Scene, waves: Waves) -> Waves:
    """Return what a suspended case makes of the ship's waves, and its own two swings.

    Each mode answers a wave of the apparent vertical by ω²/(ω² − Ω²), in resonance by what the
    scene's length lets it grow to (theory E3). Its own swings are as large as the release from
    the apparent vertical makes them.
    """
    assert scene.suspension is not None
    own, c = case_modes(scene.suspension), scene.suspension.depth
    released = float(np.linalg.norm(waves.sway)) / math.sqrt(2.0)
    theta, phi = np.zeros((2, len(waves.frequency)))
    frequency, swings = [], []
    ratios = (own.B, own.B_prime, own.b), (own.B_prime, own.B, own.b_prime)
    for ratio, other, length in ratios:
        square = scene.gravity / length
        apart = square - waves.frequency**2
        least = 2.0 * math.sqrt(square) / scene.duration
        apart = np.where(np.abs(apart) < least, least, apart)
        share = length * c / (ratio * (ratio - other))
        theta += waves.sway * (share * square / apart)
        phi += waves.sway * (share * ratio / c * square / apart)
        frequency.append(math.sqrt(square))
        swings.append((released * share, released * share * ratio / c))
    free = np.abs(np.array(swings))
    return Waves(
        np.concatenate([waves.frequency, frequency]),
        np.concatenate([np.abs(phi), free[:, 1]]),
        np.concatenate([np.abs(theta), free[:, 0]]),
        np.concatenate([waves.heave, free[:, 0] ** 2]),
    )


def remainder(turn: FloatArray, samples: int, *, slopes: bool) -> FloatArray:
    """Return the most that interpolation is off for waves of unit amplitude.

    (Ωh)^w max|ω(u)|/w!, with w conditions and ω(u) the product of the distances to their nodes,
    in samples, over a piece (`ship.interpolation`).

    Args:
        turn: Ωh, what the wave turns between two samples [rad].
        samples: that a piece spans.
        slopes: whether the rate of the channel is known too.
    """
    before, times = (ROLL_BEFORE, 2) if slopes else (FORCE_BEFORE, 1)
    nodes = np.arange(-before, samples + before + 1)
    places = np.linspace(0.0, samples, 16 * samples + 1)
    distance = np.abs(np.prod(places[:, None] - nodes, axis=1)).max() ** times
    conditions = times * len(nodes)
    return np.asarray(turn**conditions * distance / math.factorial(conditions))


def sampling_error_s(waves: Waves, machine: AnyMachine, samples: int, step_s: float) -> float:
    """Return about how far the reading is off because the motion is sampled [s].

    An error of the neutral line turns the phase by as much, by the amplitude of the swing; one of
    the pull, δg/g at Ω, by ω/(2Ω) δg/g. Waves add up as independent. The apparent vertical and
    gravity hold products of waves too: these are taken at 2Ω, where little is left to see.

    Args:
        waves: in the ship's motion.
        machine: what feels them.
        samples: that a piece of the interpolation spans.
        step_s: between samples [s].
    """
    turn, swing = waves.frequency * step_s, abs(machine.release_angle) or 1.0
    steepness = float(np.linalg.norm([waves.sway, waves.heave])) / math.sqrt(2.0)
    value = remainder(turn, samples, slopes=False)
    value += steepness * remainder(2.0 * turn, samples, slopes=False)
    if machine.follows_apparent_vertical:
        line = value * waves.sway / swing
    else:
        line = remainder(turn, samples, slopes=True) * waves.roll / swing
    pull = value * waves.heave * machine.frequency / (2.0 * waves.frequency)
    parts = [line, pull] if machine.feels_gravity else [line]
    return float(np.linalg.norm(parts)) / machine.frequency


def _bearing_error_s(seas: Waves, case: Waves, machine: AnyMachine, step_s: float) -> float:
    """Return about how far the reading is off because the bearing's motion is sampled [s].

    The case answers an error of the sway as it answers the sway.

    Args:
        seas: waves of the ship's motion.
        case: what the case makes of them, first, and its own swings.
        machine: what feels the case.
        step_s: between samples of the ship's motion [s].
    """
    turn, count = seas.frequency * step_s, len(seas.frequency)
    steepness = float(np.linalg.norm([seas.sway, seas.heave])) / math.sqrt(2.0)
    value = remainder(turn, 1, slopes=False)
    value += steepness * remainder(2.0 * turn, 1, slopes=False)
    tilt = case.sway if machine.follows_apparent_vertical else case.roll
    line = value * tilt[:count] / (abs(machine.release_angle) or 1.0)
    pull = value * seas.heave * machine.frequency / (2.0 * seas.frequency)
    parts = [line, pull] if machine.feels_gravity else [line]
    return float(np.linalg.norm(parts)) / machine.frequency


def _swing_s(machine: AnyMachine) -> float:
    """Return the period of the swing released, or of small swings where it cannot swing freely."""
    try:
        return machine.period(machine.release_angle)
    except (CamRangeError, SlackThreadError):
        return machine.small_period


def _run_s(
    scene: Scene, name: str, motion: ShipMotion, swings: float, steps: _Steps | None
) -> float:
    channels = 1 + bool(motion.metadata.get('heave'))
    waves = channels * int(motion.metadata.get('components', 0))
    work_ns = scene.log_count * (NAVIGATION_NS_A_LOG + NS_A_LOG.get(name, 0.0))
    work_ns += motion.total * (SHIP_NS_A_SAMPLE + SHIP_NS_A_COMPONENT * waves)
    felt = motion.total * felt_parts(scene)
    if scene.suspension is not None:
        work_ns += felt * SUSPENDED_NS_A_SAMPLE
    if name == 'forced_harmonic':
        work_ns += felt * FORCED_NS_A_SAMPLE
    if steps is not None:
        work_ns += swings * (steps.a_swing * step_ns(scene) + steps.events * NS_AN_EVENT)
    return START_S[name] + work_ns / NS_PER_S


def step_ns(scene: Scene) -> float:
    """Return what a step of the collocation costs, by the scene's kind of thread [ns]."""
    thread = '' if scene.trochlea is None else scene.trochlea.thread.kind
    return NS_A_STEP_OF_THREAD.get(thread, NS_A_STEP)


def _growth(
    scene: Scene, machine: AnyMachine, name: str, swing_s: float, steps: _Steps | None
) -> float:
    """Return the most that the reading's error can grow in a day [s/day].

    A step's error is the tolerance where the step is the longest, and in a smooth well goes with
    its power of the order; what is left to the iteration does not. All steps are taken to err
    alike; rounding errs at random.
    """
    step_s = felt_step_ns(scene) / NS_PER_S if steps is None else swing_s / steps.a_swing
    rounding = math.sqrt(SECONDS_PER_DAY / step_s) * UNIT_ROUNDING * swing_s / math.tau
    if steps is not None:
        smooth = not isinstance(machine, Machine) or not machine.cam.joints.size
        from tauto_core.motion.step_size import settled_at  # imports kernels

        allowed = tolerance(scene)
        error = allowed * (steps.shorter**steps.order if smooth else 1.0) + settled_at(allowed)
        return SECONDS_PER_DAY * steps.a_swing * error / math.tau + rounding
    if name == 'forced_harmonic':
        return rounding
    return SECONDS_PER_DAY * PERIOD_ERROR if name == 'action_angle' else 0.0
