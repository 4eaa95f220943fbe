"""What a voyage will cost in run time, and how exact it will be, told beforehand.

Both are rough. A cost is the number of things to do times the nanoseconds measured for one. Errors
are those of the simulation against its own equations and the exact sea, not the clock's error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tauto_core.machines import AnyMachine, Machine, SlackThreadError
from tauto_core.motion import make_propagator, propagator_name
from tauto_core.samples import NS_PER_S, SECONDS_PER_DAY, FloatArray
from tauto_core.scene import ComponentsShip, RecordedShip, Scene, SeaShip, StillShip
from tauto_core.scene.errors import CamRangeError
from tauto_core.ship import ShipMotion
from tauto_core.ship.interpolation import FORCE_BEFORE, MAX_STRIDE, ROLL_BEFORE

# Least of four runs of 10 h at sea or 100 days on land, each stage timed by itself, of the shipped
# scenes ideal, second_cam_at_sea, involute_weight_at_sea and portsmouth_jamaica, and of the cheek
# before Euler on land (action_angle). The start: processor time of `tauto sail` of a minute.
# Intel Xeon, Python 3.11, Numba 0.68.
MEASURED_ON = 'a core at 2.5 GHz'
START_S = {'harmonic': 0.5, 'action_angle': 0.5, 'forced_harmonic': 1.7, 'collocation': 1.7}
SHIP_NS_A_SAMPLE, SHIP_NS_A_COMPONENT = 30.0, 0.5
FORCED_NS_A_SAMPLE = 560.0
NS_A_STEP, NS_AN_IMPULSE = 1000.0, 5000.0
NS_A_STEP_OF_THREAD = {'lever': 5000.0, 'hanging': 2000.0}
NS_A_LOG = {'harmonic': 400.0, 'action_angle': 32_000.0}
NAVIGATION_NS_A_LOG = 1200.0

PERIOD_ERROR = 1e-14
"""Relative error of a period by quadrature, at most (tests of machines)."""
ORDER = 16
"""Of the collocation."""
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
        shortest_wave_s: least period in the ship's motion [s]; None where it lies still or its
            motion was measured.
    """

    run_s: float
    steps_a_swing: float | None
    steady_error_s: float | None
    growing_error_s_per_day: float
    shortest_wave_s: float | None


def forecast(scene: Scene, machine: AnyMachine, motion: ShipMotion) -> Forecast:
    """Return what a scene will cost and how exact it will be.

    Args:
        scene: one that can sail.
        machine: of the scene.
        motion: of the scene's ship.
    """
    name = propagator_name(machine, still=isinstance(scene.ship, StillShip))
    swing_s = _swing_s(machine)
    steps = _steps(scene, machine, swing_s) if name == 'collocation' else None
    waves = _waves(scene)
    steady = None
    if not isinstance(scene.ship, RecordedShip):
        samples = 1 if steps is None else steps.samples
        sampled = sampling_error_s(waves, machine, samples, scene.step_ns / NS_PER_S)
        steady = sampled + 0.5 * swing_s * UNIT_ROUNDING
    return Forecast(
        run_s=_run_s(scene, name, motion, scene.duration / swing_s, steps),
        steps_a_swing=None if steps is None else steps.a_swing,
        steady_error_s=steady,
        growing_error_s_per_day=_growth(scene, machine, name, swing_s, steps),
        shortest_wave_s=float(math.tau / waves.frequency.max()) if len(waves.frequency) else None,
    )


@dataclass(frozen=True)
class _Steps:
    """Steps of the collocation: samples a piece, steps a swing, a step by the longest allowed."""

    samples: int
    a_swing: float
    shorter: float


def _steps(scene: Scene, machine: AnyMachine, swing_s: float) -> _Steps:
    allowed = None if scene.solver is None else scene.solver.tolerance
    still = isinstance(scene.ship, StillShip)
    longest_s = make_propagator(machine, still=still, tolerance=allowed).longest_step_s
    samples = samples_a_piece(scene, longest_s)
    piece_s = samples * scene.step_ns / NS_PER_S
    step_s = piece_s / math.ceil(piece_s / longest_s)
    return _Steps(samples, swing_s / step_s, step_s / longest_s)


def tolerance(scene: Scene) -> float:
    """Return the relative error that a scene allows in one step of the collocation."""
    if scene.solver is not None and scene.solver.tolerance is not None:
        return scene.solver.tolerance
    from tauto_core.motion.collocation import TOLERANCE  # imports numba

    return TOLERANCE


def samples_a_piece(scene: Scene, longest_step_s: float) -> int:
    """Return how many samples of the motion a step spans: logged instants end steps.

    Args:
        scene: its rate and log.
        longest_step_s: of the propagator [s]; where a sample is longer, it is cut into steps.
    """
    logs = scene.log_interval_ns // scene.step_ns
    most = min(MAX_STRIDE, int(longest_step_s * NS_PER_S) // scene.step_ns)
    return next(n for n in range(max(most, 1), 0, -1) if logs % n == 0)


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


def _waves(scene: Scene) -> Waves:
    """Return a scene's waves, linearised: β = H ρ̈/g, g_eff = g + z̈ (theory E1)."""
    from tauto_core.ship.sea import sea_motion

    ship = scene.ship
    roll = heave = np.empty((2, 0))
    if isinstance(ship, ComponentsShip):
        roll = np.array([(c.amplitude, c.period) for c in ship.components]).reshape(-1, 2).T
        heave = np.array([(c.amplitude, c.period) for c in ship.heave or ()]).reshape(-1, 2).T
    elif isinstance(ship, SeaShip):
        sea = sea_motion(scene, ship)
        roll = np.array([sea.roll.amplitude, sea.roll.period])
        if ship.heave:
            heave = np.array([sea.elevation.amplitude, sea.elevation.period])
    rolls, heaves = math.tau / roll[1], math.tau / heave[1]
    none = np.zeros(len(heaves))
    return Waves(
        np.concatenate([rolls, heaves]),
        np.concatenate([roll[0], none]),
        np.concatenate([abs(ship.height) * roll[0] * rolls**2 / scene.gravity, none]),
        np.concatenate([0.0 * rolls, heave[0] * heaves**2 / scene.gravity]),
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
    if name == 'forced_harmonic':
        work_ns += motion.total * FORCED_NS_A_SAMPLE
    if steps is not None:
        impulses = 0 if scene.escapement is None else 2
        step_ns = NS_A_STEP_OF_THREAD.get(scene.trochlea.thread.kind, NS_A_STEP)
        work_ns += swings * (steps.a_swing * step_ns + impulses * NS_AN_IMPULSE)
    return START_S[name] + work_ns / NS_PER_S


def _growth(
    scene: Scene, machine: AnyMachine, name: str, swing_s: float, steps: _Steps | None
) -> float:
    """Return the most that the reading's error can grow in a day [s/day].

    A step's error is the tolerance where the step is the longest, and goes with its 16th power
    in a smooth well. All steps are taken to err alike; rounding errs at random.
    """
    step_s = scene.step_ns / NS_PER_S if steps is None else swing_s / steps.a_swing
    rounding = math.sqrt(SECONDS_PER_DAY / step_s) * UNIT_ROUNDING * swing_s / math.tau
    if steps is not None:
        cam = machine.cam if isinstance(machine, Machine) else None
        smooth = cam is None or cam.linear_rate is not None or cam.kinked
        error = tolerance(scene) * (steps.shorter**ORDER if smooth else 1.0)
        return SECONDS_PER_DAY * steps.a_swing * error / math.tau + rounding
    if name == 'forced_harmonic':
        return rounding
    return SECONDS_PER_DAY * PERIOD_ERROR if name == 'action_angle' else 0.0
