"""The run time of a voyage and the error of its simulation, predicted by short trial runs."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from tauto_core.clockwork import TrochleaStage
from tauto_core.clockwork.trochlea import nominal_period_s
from tauto_core.machines import (
    AnyMachine,
    AxleClock,
    FluidPendulum,
    OtherRegulator,
    SlackThreadError,
    compile_machine,
)
from tauto_core.motion import (
    asked_tolerance,
    make_collocation,
    make_propagator,
    propagator_name,
    steps_in,
)
from tauto_core.motion.forcing import LEAST_UPWARD
from tauto_core.samples import (
    PHASE,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    Batches,
    FloatArray,
    TemperatureSamples,
)
from tauto_core.scene import Scene
from tauto_core.scene.errors import CamRangeError, PropagationError, SceneError
from tauto_core.scene.sections import LEAST_TOLERANCE, Solver
from tauto_core.scene.times import DAY_S, LEGIBLE, NS_PER_S
from tauto_core.ship import ShipMotion
from tauto_core.ship.airs import BoxTemperature
from tauto_core.ship.buffer import samples_a_piece, sensed_parts, sensed_step_ns
from tauto_core.ship.motions import SixMotions
from tauto_core.ship.sampling import MAX_STRIDE, least_upward
from tauto_core.ship.waves import Harmonics

# -----------------------------------------------------------------------------
# The error of a scene's reading, found by running its beginning more than once.
#
# The beginning is run as the scene asks, and again with finer samples of the motion and a finer
# tolerance. At the same instants the two readings differ by the error of sampling and steps. This
# includes effects for which a formula would need details of each machine: one-sided windows at the
# start, the effect of a wrong amplitude on the rate, a swinging case or thread, impulses,
# resonance. Errors that both runs share are not seen: the machine's own parameters and rounding.
#
# If the propagator takes steps, two more runs through the same sea show how a small distance
# grows: the wheel of one is released `RELEASED_APART` nearer to rest, far more than rounding. If
# the distance grows exponentially the motion is chaotic, and all errors grow with it.

SAFETY = 3.0
"""Factor on the difference of the runs: the finer run is not exact, and later errors may add up
less favourably.
"""

FINER: tuple[int, ...] = (*range(4, 65), 3, 2)
"""Numbers of parts of a step in the finer run. The first that gives whole nanoseconds is used."""

FINER_TOLERANCE = 1e-3
"""Factor of the tolerance in the finer run."""

WORK = 6.0
"""Work of the runs for the errors over one run as asked: two of the same, one four times finer."""

FIRST_CHUNK, CHUNK = 64, 4096
"""Least and largest number of samples fed at once."""

CHUNK_S = 0.05
"""Processor time of a chunk above which the next is not larger [s]."""

COMPILED_S, COMPILING_S = 20.0, 5.0
"""Motion at the beginning of a run that may compile kernels, and the processor time for compiling
in all runs together [s].
"""

LEAST_LOGS = 32
"""Least number of instants at which runs are compared. With fewer the log interval is shortened,
if the pieces of motion keep their length.
"""

STEEPEST = 3.0
"""Largest power of time by which an error grows: a force in resonance changes the amplitude in
proportion to t, and with an amplitude-dependent rate the phase in proportion to t².
"""

RELEASED_APART = 1e-11
"""Initial distance of two motions to measure its growth [rad]."""

APART_TOLERANCE = 2e-12
"""Largest tolerance of their steps. It keeps errors in a swing below `RELEASED_APART`."""

SMALL_APART = 0.1
"""Largest distance of two phases at which its growth is proportional to it [rad]."""

GROWTH_LENGTHS = 5.0
"""Length over which growth is followed, over the length of the other runs, which cost more."""

GROWTH_PIECES = 6
"""Number of pieces that measure the scatter of growth, after the first quarter, in which the
distance spreads from the amplitude to the phase.
"""

SURE = 2.0
"""Standard errors that are added to the growth rate after the trial."""


@dataclass
class Limit:
    """The processor time that trial runs may still take together, and that of compiling [s]."""

    left_s: float = math.inf
    compiling_s: float = COMPILING_S

    def charge(self, spent_s: float, *, may_compile: bool) -> float:
        """Add the cost of a part of a run [s] and return it without the time of compiling."""
        compiling_s = min(spent_s, self.compiling_s) if may_compile else 0.0
        self.compiling_s -= compiling_s
        self.left_s -= spent_s - compiling_s
        return spent_s - compiling_s


@dataclass(frozen=True)
class Growth:
    """The growth of a small distance between two motions in the same sea.

    Attributes:
        followed_s: time over which it was small and was followed [s].
        per_s: finite-time Lyapunov exponent [1/s]: rate at which the logarithm of the largest
            distance so far grew after the first quarter of that time.
        per_s_sigma: its standard error, from the scatter of pieces of that time [1/s].
        is_chaotic: whether it grew exponentially: by more than the power `STEEPEST` of time after
            the half or the quarter. Otherwise `per_s` falls with the time followed.
    """

    followed_s: float
    per_s: float
    per_s_sigma: float
    is_chaotic: bool

    @property
    def grows(self) -> bool:
        """Whether it grew after the quarter by more than half as much as by a change of rate."""
        return 0.75 * self.followed_s * self.per_s > 0.5 * math.log(4.0)


@dataclass(frozen=True)
class _Ran:
    """Half turns and fractions at the logged instants of a run, (n, 2), its cost and its end.

    `cost_a_second` is the processor time of a second of motion [s]. It excludes the start, which
    may compile kernels.
    """

    phases: FloatArray
    was_cut: bool
    cost_a_second: float = 0.0


def try_out(
    scene: Scene,
    nominal_s: float,
    rounding_s: float,
    longest_s: float,
    tolerance: float | None,
    limit: Limit | None = None,
    lasts_s: float = math.inf,
) -> Forecast:
    """Run the beginning of a scene as it is, with a finer tolerance, and with finer samples too.

    The dial advances by `nominal_s` in a turn of the phase, and its error by rounding is
    `rounding_s`. `tolerance` is `None` if the propagator takes no steps, on a moving ship. The
    beginning lasts at most `longest_s`, but at least two log intervals. Growth is followed
    `GROWTH_LENGTHS` times as long. After `lasts_s` sampling causes no more errors, unless errors
    grow.

    In the result `rounding_error_s` is only of rounding that grows, and `error_s` is `None`. A
    finer tolerance may divide the motion into other pieces, and the difference then counts as
    sampling or as steps.
    """
    limit = Limit() if limit is None else limit
    scene, ends_s = _closely_logged(scene, longest_s, tolerance), scene.duration
    beginning, followed = (_beginning(scene, n * longest_s) for n in (1.0, GROWTH_LENGTHS))
    parts = None if scene.lies_still else _finer_parts(scene)
    stepping, thread = tolerance is not None, scene.trochlea and scene.trochlea.thread.kind
    # a wheel on land has one degree of freedom and no change with time: no chaos
    may_be_chaotic = stepping and (not scene.lies_still or thread == 'hanging')
    # if a run costs more than planned, time is left for as much of the finer ones
    runs = [_run(beginning, limit, 0.5 * limit.left_s / WORK)]
    if runs[0].was_cut:
        length_s = max(len(runs[0].phases) - 1, 0) * scene.log_interval_ns / NS_PER_S
        beginning = followed = _beginning(scene, length_s)
    steps = sampling = growing = None
    if tolerance is not None:
        beginning = _stepped(beginning, max(FINER_TOLERANCE * tolerance, LEAST_TOLERANCE))
        runs.append(_run(beginning, limit))
        steps = 0.5 * nominal_s * _half_turns_apart(runs[0], runs[1])
    if parts is not None:
        runs.append(_run(_sampled_finer(beginning, parts), limit))
        sampling = 0.5 * nominal_s * _half_turns_apart(runs[-2], runs[-1])
    if tolerance is not None and may_be_chaotic:
        twin = _stepped(followed, min(tolerance, APART_TOLERANCE))
        runs += [_run(twin, limit, 0.5 * limit.left_s), _run(_released_apart(twin), limit)]
        growing = _Growing.of(runs[-2], runs[-1], scene)
    interval_s = scene.log_interval_ns / NS_PER_S
    count = min(len(series) for series in (runs[0].phases, steps, sampling) if series is not None)
    trial = Forecast(
        run_s=ends_s * runs[0].cost_a_second,
        steps_a_swing=None,
        error_s=None,
        sampling_error_s=None,
        steps_error_s=None,
        rounding_error_s=0.0,
        tried_s=max(count - 1, 0) * interval_s,
        was_cut=any(ran.was_cut for ran in runs),
        growth=None if growing is None else growing.found,
    )
    if trial.was_cut and count < 2:
        return trial
    errors = [error if error is None else error[:count] for error in (sampling, steps)]
    times: FloatArray = np.arange(count, dtype=np.float64) * interval_s
    grows = trial.growth is not None and trial.growth.grows
    sampled_s = ends_s if grows else min(lasts_s, ends_s)
    bounds = [
        None if error is None else SAFETY * extrapolated(times, error, until_s, rounding_s)
        for error, until_s in zip(errors, (sampled_s, ends_s), strict=True)
    ]
    grown_rounding_s, until_s = 0.0, None
    if growing is not None and growing.found.is_chaotic:
        starts_s = [0.0 if error is None else growing.start_s(times, error) for error in errors]
        # steps of the random walk by rounding after an e-fold of the growth do not count
        rounding = rounding_s / math.sqrt(max(growing.found.per_s * ends_s, 1.0))
        grown = growing.size_at(ends_s)
        bounds = [
            None if bound is None else min(max(bound, SAFETY * start_s * grown), ends_s)
            for bound, start_s in zip(bounds, starts_s, strict=True)
        ]
        grown_rounding_s = min(SAFETY * rounding * grown, ends_s)
        until_s = growing.time_of(
            LEGIBLE * nominal_s / (SAFETY * (sum(starts_s) + rounding)), ends_s
        )
    return replace(
        trial,
        sampling_error_s=bounds[0],
        steps_error_s=bounds[1] if stepping else 0.0,
        rounding_error_s=grown_rounding_s,
        bounded_until_s=until_s,
    )


def _beginning(scene: Scene, longest_s: float) -> Scene:
    interval_s = scene.log_interval_ns / NS_PER_S
    logs = min(max(int(longest_s / interval_s * (1.0 + 1e-12)), 2), scene.log_count - 1)
    return scene.model_copy(update={'duration': logs * interval_s})


def _closely_logged(scene: Scene, longest_s: float, tolerance: float | None) -> Scene:
    """Return a scene with `LEAST_LOGS` intervals at first, if its pieces keep their length."""
    most_ns = min(longest_s, scene.duration) * NS_PER_S / LEAST_LOGS
    if scene.log_interval_ns <= most_ns:
        return scene
    step_ns = 1 if scene.lies_still else scene.step_ns
    steps, most_steps = scene.log_interval_ns // step_ns, int(most_ns / step_ns)
    machine = compile_machine(scene)
    fill = steps_in(make_propagator(machine, still=scene.lies_still, tolerance=tolerance))
    piece = samples_a_piece(scene, fill)
    fewest = math.ceil(scene.log_interval_ns / most_ns)
    # fractions of the interval reach the end of the scene; otherwise any number of steps
    parts = (steps // n for n in range(fewest, 4 * fewest) if steps % n == 0)
    numbers = range(most_steps, max(most_steps - 4 * MAX_STRIDE, 0), -1)
    for samples in (*parts, *numbers):
        log = scene.log.model_copy(update={'interval': samples * step_ns / NS_PER_S})
        closer = scene.model_copy(update={'log': log})
        if samples_a_piece(closer, fill) == piece:
            return closer
    return scene


def _finer_parts(scene: Scene) -> int | None:
    """Return into how many parts a finer run divides a step, `None` if that is impossible."""
    hung, finer = scene.suspension, FINER
    if hung is not None and hung.sticks:  # samples of the case round off its jumps
        fewest = FINER[0] * sensed_parts(scene)
        finer = tuple(range(fewest, 2 * fewest)) + FINER
    for parts in finer:
        try:
            sensed_parts(_sampled_finer(scene, parts))
        except SceneError:  # the suspension divides the step, too
            continue
        if scene.step_ns % parts == 0:
            return parts
    return None


def _sampled_finer(scene: Scene, parts: int) -> Scene:
    ship = scene.ship.model_copy(update={'rate': NS_PER_S / (scene.step_ns / parts)})
    return scene.model_copy(update={'ship': ship})


def _stepped(scene: Scene, tolerance: float) -> Scene:
    return scene.model_copy(update={'solver': Solver(tolerance=tolerance)})


def _released_apart(scene: Scene) -> Scene:
    """Return a scene with the wheel released nearer to rest, by `RELEASED_APART`."""
    assert scene.trochlea is not None  # a body in a fluid takes no steps
    release = scene.trochlea.release_angle
    angle = release - math.copysign(RELEASED_APART, release)
    released = scene.trochlea.model_copy(update={'release_angle': angle})
    return scene.model_copy(update={'trochlea': released})


def _half_turns_apart(a: _Ran, b: _Ran) -> FloatArray:
    count = min(len(a.phases), len(b.phases))
    difference: FloatArray = (a.phases[:count] - b.phases[:count]).sum(axis=1)
    return difference


def _run(scene: Scene, limit: Limit, most_s: float = math.inf) -> _Ran:
    """Run a scene to its end, or to the last logged instant before an error in its motion."""
    while True:
        try:
            return _sailed(scene, limit, min(most_s, limit.left_s))
        except PropagationError as ended:
            interval_s = scene.log_interval_ns / NS_PER_S
            logs = math.ceil(min(ended.time_s, scene.duration) / interval_s) - 1
            if logs < 1:
                return _Ran(np.empty((0, 2)), False)
            scene = scene.model_copy(update={'duration': logs * interval_s})


def _sailed(scene: Scene, limit: Limit, most_s: float) -> _Ran:
    """Return the readings of a run until it ends or has used its processor time."""
    motion, stage, phases = ShipMotion(scene), TrochleaStage(scene), [np.empty((0, 2))]
    step_s, chunk, reached_s, spent_s, cut = scene.step_ns / NS_PER_S, FIRST_CHUNK, 0.0, 0.0, False
    costs = list[list[float]]()

    def take(batches: Batches) -> None:
        if PHASE in batches:
            phases.append(batches[PHASE].position[:, 1:3])  # type: ignore[union-attr]

    box = BoxTemperature(scene) if SHIP_TEMPERATURE in stage.inputs else None
    warm, log_ns = 0, scene.log_interval_ns

    # The chunks do not change the result.
    while not cut:
        began_s = time.thread_time()
        imu = motion.sense(chunk)
        if not len(imu.stamp_ns):
            take(stage.finish())
            costs[-1][0] += time.thread_time() - began_s
            break
        batches: Batches = {SHIP_IMU: imu}
        if box is not None:
            log_end = -((scene.starts_at_ns - int(imu.stamp_ns[-1])) // log_ns)
            logs = np.arange(warm, log_end + 1)
            warm, zeros = log_end + 1, np.zeros(len(logs))
            stamps = scene.starts_at_ns + logs * log_ns
            batches[SHIP_TEMPERATURE] = TemperatureSamples(stamps, '', box.at(logs), zeros)
        take(stage.feed(batches))
        took_s, moved_s = time.thread_time() - began_s, len(imu.stamp_ns) * step_s
        spent_s += limit.charge(took_s, may_compile=reached_s < COMPILED_S)
        costs.append([took_s, moved_s])
        reached_s += moved_s
        chunk = min(2 * chunk, CHUNK) if took_s < CHUNK_S else max(chunk // 2, FIRST_CHUNK)
        cut = spent_s >= most_s
    cost_s, moved_s = np.sum(costs[len(costs) // 2 :], axis=0).tolist()
    return _Ran(np.concatenate(phases), cut, cost_s / moved_s)


class _Growing:
    """The logarithm of the largest distance so far of two motions over the initial one."""

    def __init__(self, times: FloatArray, logs: FloatArray) -> None:
        self._times, self._logs = times, logs
        end_s = float(times[-1])
        edges = np.interp(end_s * np.linspace(0.25, 1.0, GROWTH_PIECES + 1), times, logs)
        pieces, piece_s = np.diff(edges), 0.75 * end_s / GROWTH_PIECES
        by_power = STEEPEST * math.log(2.0)
        mid, quarter = (logs[-1] - np.interp(part * end_s, times, logs) for part in (0.5, 0.25))
        self.found = Growth(
            followed_s=end_s,
            per_s=float(np.mean(pieces)) / piece_s,
            per_s_sigma=float(np.std(pieces, ddof=1)) / math.sqrt(GROWTH_PIECES) / piece_s,
            is_chaotic=bool(mid > by_power or quarter > 2.0 * by_power),
        )

    @classmethod
    def of(cls, a: _Ran, b: _Ran, scene: Scene) -> _Growing | None:
        """Return the growth between two runs, `None` if their motion ends at once."""
        angle = math.pi * np.maximum.accumulate(np.abs(_half_turns_apart(a, b)))
        angle = angle[angle <= SMALL_APART]
        if len(angle) <= GROWTH_PIECES:
            return None
        interval_s = scene.log_interval_ns / NS_PER_S
        times: FloatArray = np.arange(len(angle), dtype=np.float64) * interval_s
        return cls(times, np.log(np.maximum(angle / RELEASED_APART, 1.0)))

    @property
    def _quickest_per_s(self) -> float:
        return self.found.per_s + SURE * self.found.per_s_sigma

    def size_at(self, time_s: float) -> float:
        """Return the ratio at a time, or its largest value; inf if doubles overflow."""
        beyond_s = max(time_s - self.found.followed_s, 0.0)
        log = float(np.interp(time_s, self._times, self._logs)) + self._quickest_per_s * beyond_s
        return math.exp(log) if log < 700.0 else math.inf

    def time_of(self, size: float, end_s: float) -> float | None:
        """Return the time at which a ratio is reached [s], `None` if not before the end."""
        log = math.log(size)
        if log <= self._logs[-1]:
            time_s = float(self._times[np.searchsorted(self._logs, log)])
        else:
            time_s = self.found.followed_s + (log - float(self._logs[-1])) / self._quickest_per_s
        return time_s if time_s < end_s else None

    def start_s(self, times: FloatArray, error: FloatArray) -> float:
        """Return the error at the start [s] from which the observed error has grown.

        Later errors grow less. Errors of the first quarter are not yet the lasting ones.
        """
        late = times >= 0.25 * times[-1]
        grown = np.exp(np.interp(times[late], self._times, self._logs))
        return float(np.max(np.abs(error[late]) / grown))


def extrapolated(times: FloatArray, error: FloatArray, end_s: float, rounding_s: float) -> float:
    """Return the largest size of an error at a later time, by extrapolation, at most `end_s`.

    Its largest size so far grows on by the power of time in the second half of the known part, or
    linearly if that gives more. An error within rounding does not grow. Times are evenly spaced
    from 0. A clock with an error of `end_s` is useless.
    """
    if len(times) < 2:
        return 0.0
    tried_s, sizes = float(times[-1]), np.abs(error)
    size, half_size = (float(np.max(sizes[times <= tried_s / n])) for n in (1, 2))
    if end_s <= tried_s or size == 0.0:
        return size
    doubling = math.log(size / max(half_size, min(rounding_s, size)))
    power = min(doubling / math.log(2.0), STEEPEST)
    slope = abs(float(np.polyfit(times, error, 1)[0]))
    longer = size + slope * (end_s - tried_s)
    return min(max(size * math.pow(end_s / tried_s, power), longer), end_s)


# -----------------------------------------------------------------------------
# The run time of a voyage and the error of its simulation.
#
# The run time is measured in runs of the beginning. Errors are those of the simulation relative to
# its own equations and the exact sea, not the clock's. They are bounds from the same runs
# (`try_out`), in weather in each sea that may be the worst.

# Rough processor times. They give trial runs their length, which must not vary with the machine
# and its load because the bounds follow from it, and ensembles their number of processes.
NS_A_SAMPLE, NS_A_HUNG_SAMPLE = 50.0, 300.0
NS_A_STEP = {'axle': 1e6, 'half_swings': 2e4, 'collocation': 1000.0}
"""For a step of the wheel, by propagator. Those of an axle are not compiled."""
NS_A_LOG = 1000.0
AXLE_PHASE_A_STEP = 1.0
"""Phase of a step of a body on an axle [rad]."""
AXLE_ERROR = 1e-12
"""Error of the phase by these steps, over the time."""
TIMED_S = 0.1
"""Approximate processor time of a run that measures the cost of a scene without trials [s]."""

PERIOD_ERROR = 1e-14
"""Largest relative error of a period by quadrature (tests of machines)."""
UNIT_ROUNDING = 2.0**-53

RESOLUTION_S = 1e-9
"""Resolution of the reading and smallest bound [s]: readings are in whole nanoseconds."""

TRIAL_RUN_S = 0.8
"""Approximate run time of the trials for errors together [s], and of the trials for growth. It
limits their length.
"""
CREEP_TRIED_S = 60.0
"""Length of the trials of a wheel that drag lets creep home [s]. Without a swing its steps cannot
be predicted, and the trials may cost many times the prediction.
"""
LONGEST_TRIAL_S = 10.0
"""Processor time after which trials that cost more than predicted are cut [s]."""


@dataclass(frozen=True)
class Forecast:
    """Expected cost and error of a scene.

    Errors are bounds for the reading of the dial at any logged instant of the run [s]. No run that
    was compared with independent programs exceeded them, and no error above rounding was below a
    thirtieth of them (benchmarks/stress_forecast.py).

    Attributes:
        run_s: processor time of `tauto sail` here without a bag, within a factor of three [s].
        steps_a_swing: steps laid out in a full swing, `None` if the propagator takes no steps.
        error_s: bound of all the following together, at least `RESOLUTION_S`. `None` if one of
            them is unknown, or the motion is chaotic and the end unknown.
        sampling_error_s: bound of the error by sampling the ship's motion. `None` on a still ship,
            and if its step has no divisor for a finer one. Measured motion is taken as exact.
        steps_error_s: bound of the error of the steps by their tolerance, or of a closed form by
            the accuracy of its period. `None` if the trials were cut before a result.
        rounding_error_s: approximate error of the phase by rounding alone, with its growth in a
            chaotic motion, without the rounding of the reading to nanoseconds.
        tried_s: length of the trial runs [s], `None` without trials. Beyond it the bounds are
            extrapolated.
        was_cut: whether the trials were cut, since they cost much more than predicted.
        growth: growth of a small distance between two motions in the same sea (`Growth`). `None`
            without steps, and on land unless a thread swings.
        bounded_until_s: time from which the bound exceeds a quarter of a period in a chaotic
            motion, else `None`.
        decided_by: the sea with the largest bound: `why` it was tried, `highest` or `met fastest`
            or both, and its figures as in `weather.states`. `None` without weather.
        shortest_wave_s: least period in the motion of the clock there, with the swings of its case
            [s]. `None` for a fixed clock on a still ship or with measured motion.
    """

    run_s: float
    steps_a_swing: float | None
    error_s: float | None
    sampling_error_s: float | None
    steps_error_s: float | None
    rounding_error_s: float
    tried_s: float | None = None
    shortest_wave_s: float | None = None
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
    machine: AnyMachine | OtherRegulator,
    progress: Callable[[float], None] | None = None,
    trial_s: float | None = None,
) -> Forecast:
    """Return the expected cost and error of a scene that runs, with its machine.

    `progress` is called with the fraction of the seas that were tried. The trials take about
    `trial_s` of processor time, by default `TRIAL_RUN_S`, and as much for growth [s].
    """
    trial_s = TRIAL_RUN_S if trial_s is None else trial_s
    still = scene.lies_still
    if isinstance(machine, AxleClock):
        # at sea, or if the axle slips, no bound is known
        lost_s = scene.duration * AXLE_ERROR if still and machine.contact != 'coulomb' else None
        step_s = AXLE_PHASE_A_STEP / machine.fastest
        rounding_s = _rounding_s(scene.duration, step_s, machine.small_period)
        return _of_lost(scene, lost_s, rounding_s, None if still else _shortest_wave_s(scene))
    if isinstance(machine, FluidPendulum):
        rounding_s = 0.5 * machine.small_period * UNIT_ROUNDING
        return _of_lost(scene, scene.duration * PERIOD_ERROR, rounding_s)
    assert not isinstance(machine, OtherRegulator)
    name = propagator_name(machine, still=still)
    stepping = name == 'collocation'
    nominal_s = nominal_period_s(scene, machine)
    step_s = _step_s(scene, machine) if stepping else sensed_step_ns(scene) / NS_PER_S
    rounding_s = _rounding_s(scene.duration, step_s, nominal_s)
    if still and not stepping:
        lost_s = scene.duration * PERIOD_ERROR if name == 'action_angle' else 0.0
        return _of_lost(scene, lost_s, rounding_s, _shortest_wave_s(scene))
    seas = scene.ship.worst_seas(scene)
    longest_s = scene.duration * trial_s / (len(seas) * WORK * work_s(scene))
    if machine.drag and machine.drag.viscous > 2.0 * machine.inertia * machine.frequency:
        longest_s = min(longest_s, CREEP_TRIED_S)
    trials: list[tuple[float, Forecast, Scene, dict[str, Any] | None]] = []
    for sea in seas:
        in_sea = scene.model_copy(update={'ship': sea.ship})
        trial = try_out(
            in_sea,
            nominal_s,
            rounding_s,
            longest_s,
            tolerance(scene, machine) if stepping else None,
            Limit(LONGEST_TRIAL_S * trial_s / TRIAL_RUN_S / len(seas)),
            sea.lasts_s,
        )
        is_sampled = in_sea.lies_still or trial.sampling_error_s is not None
        unknown = trial.steps_error_s is None or not is_sampled
        state = None if sea.figures is None else {'why': sea.why, **sea.figures}
        trials.append((math.inf if unknown else trial.phase_error_s, trial, in_sea, state))
        if progress is not None:
            progress(len(trials) / len(seas))
    parts_s, trial, in_sea, state = max(trials, key=lambda row: row[0])
    rounding_s += trial.rounding_error_s
    is_known = math.isfinite(parts_s) and trial.bounded_until_s is None
    swing_s = machine.small_period
    with suppress(CamRangeError, SlackThreadError):  # not free as released
        swing_s = machine.period(machine.release_angle)
    return replace(
        trial,
        steps_a_swing=swing_s / step_s if stepping else None,
        error_s=_stated(parts_s - trial.rounding_error_s + rounding_s) if is_known else None,
        rounding_error_s=rounding_s,
        shortest_wave_s=_shortest_wave_s(in_sea),
        was_cut=any(trial.was_cut for _, trial, _, _ in trials),
        decided_by=state,
    )


JUDGED_IN_S = 0.2
"""Approximate processor time of the trials that measure the accuracy of a voyage [s]."""


def accuracy_reached(scene: Scene, machine: AnyMachine | OtherRegulator) -> dict[str, Any]:
    """Return the accuracy that a scene states, and the accuracy of its run [s/day].

    `bound_s_per_day` is the bound of `Forecast` over the days of the run, at least one, or `None`.
    `holds` says whether it is within the accuracy, `chaotic` whether small differences grow
    exponentially.
    """
    result = forecast(scene, machine, trial_s=JUDGED_IN_S)
    bound = None
    if result.error_s is not None:
        bound = float(result.phase_error_s / max(scene.duration / DAY_S, 1.0))
    return {
        'asked_s_per_day': scene.accuracy,
        'bound_s_per_day': bound,
        'holds': bound is not None and scene.accuracy is not None and bound <= scene.accuracy,
        'chaotic': result.growth is not None and bool(result.growth.is_chaotic),
        'rate_hz': None if scene.lies_still else scene.ship.rate,
        'tolerance': None if result.steps_a_swing is None else tolerance(scene, machine),
    }


def is_steep(scene: Scene, machine: AnyMachine | OtherRegulator) -> bool:
    """Return whether the ship rolls too steeply for any rate to keep the default accuracy.

    If the upward force in a fixed case falls below `LEAST_UPWARD`, the law of the thread changes.
    No polynomial is exact across this change, and no samples are dense enough.
    """
    follows = not isinstance(machine, OtherRegulator) and machine.follows_apparent_vertical
    is_fixed = not scene.lies_still and scene.suspension is None
    return follows and is_fixed and least_upward(scene, scene.ship) < LEAST_UPWARD


def missed_words(result: Mapping[str, Any]) -> str:
    """Return the warning of a run that may not keep the requested accuracy."""
    bound = result['bound_s_per_day']
    text = 'no bound is known' if bound is None else f'the bound is {bound:.1g} s'
    return (
        f'solver.accuracy = {result["asked_s_per_day"]:g} s a day: {text}'
        f'{", since the motion is chaotic" if result["chaotic"] else ""}. Ask for less, or state '
        'ship.rate and solver.tolerance'
    )


def _stated(error_s: float) -> float:
    return max(error_s + 0.5 * RESOLUTION_S, RESOLUTION_S)


def _of_lost(
    scene: Scene, lost_s: float | None, rounding_s: float, shortest_wave_s: float | None = None
) -> Forecast:
    """Return the forecast of a scene without sampling, with the error of its propagator."""
    beginning = _beginning(scene, scene.duration * TIMED_S / work_s(scene))
    run_s = scene.duration * _run(beginning, Limit()).cost_a_second
    error_s = None if lost_s is None else _stated(lost_s + rounding_s)
    return Forecast(
        run_s, None, error_s, None, lost_s, rounding_s, shortest_wave_s=shortest_wave_s
    )


def _rounding_s(duration_s: float, step_s: float, nominal_s: float) -> float:
    """Return half a unit of the fraction plus the random walk of each step's rounding."""
    walk = math.sqrt(duration_s / step_s) / math.tau
    return nominal_s * UNIT_ROUNDING * (0.5 + walk)


def _shortest_wave_s(scene: Scene) -> float | None:
    frequencies = scene_waves(scene).frequency.tolist()
    if scene.suspension is not None:
        frequencies.append(scene.suspension.frequencies(scene.g)[-1])
    return math.tau / max(frequencies) if frequencies else None


def work_s(scene: Scene) -> float:
    """Return a rough processor time of a voyage from its operations [s].

    It is the same on every machine. `Forecast.run_s` is measured.
    """
    machine = compile_machine(scene)
    name = propagator_name(machine, still=scene.lies_still)
    work_ns = scene.samples * NS_A_SAMPLE + scene.log_count * NS_A_LOG
    if scene.suspension is not None:
        work_ns += scene.samples * sensed_parts(scene) * NS_A_HUNG_SAMPLE
    if name in NS_A_STEP:
        work_ns += scene.duration / _step_s(scene, machine) * NS_A_STEP[name]
    return work_ns / NS_PER_S


def _step_s(scene: Scene, machine: AnyMachine | OtherRegulator) -> float:
    """Return the length of a step of the wheel [s]."""
    if isinstance(machine, AxleClock):
        return AXLE_PHASE_A_STEP / machine.fastest
    if isinstance(machine, FluidPendulum):
        return 0.5 * machine.small_period
    assert not isinstance(machine, OtherRegulator)
    engine = make_collocation(machine, tolerance(scene, machine))
    piece_s = samples_a_piece(scene, steps_in(engine)) * sensed_step_ns(scene) / NS_PER_S
    return piece_s / math.ceil(piece_s / engine.longest_step_s)


def tolerance(scene: Scene, machine: AnyMachine | OtherRegulator) -> float:
    """Return the relative error that a scene allows in one step of the collocation."""
    stated = None if scene.solver is None else scene.solver.tolerance
    error = asked_tolerance(machine, accuracy=scene.accuracy, tolerance=stated)
    if error is not None:
        return error
    from tauto_core.motion.stepping import TOLERANCE  # imports kernels

    return TOLERANCE


class Waves(NamedTuple):
    """Ω [rad/s] of a ship's harmonics, and their sways of the apparent vertical [rad], (n,)."""

    frequency: FloatArray
    sway: FloatArray


def scene_waves(scene: Scene) -> Waves:
    """Return a scene's waves, linearised: β = H ρ̈/g, g_eff = g + z̈ (ship.md).

    They are empty for a still ship or measured motion. In weather they belong to the highest sea.
    """
    if not scene.ship.is_computed:
        return Waves(np.empty(0), np.empty(0))
    channels = scene.ship.roughest(scene).channels(scene)
    if isinstance(channels.six, SixMotions) and isinstance(channels.six.sway, Harmonics):
        # all six motions have the frequencies of encounter
        frequency = channels.six.sway.angular_frequency
        return Waves(frequency, channels.six.sway.amplitude * frequency**2 / scene.g)
    rolls, heaves = (
        (motion.amplitude, motion.angular_frequency)
        if isinstance(motion, Harmonics)
        else (np.empty(0), np.empty(0))
        for motion in (channels.roll, channels.heave)
    )
    sway = abs(scene.ship.height) * rolls[0] * rolls[1] ** 2 / scene.g
    return Waves(np.concatenate([rolls[1], heaves[1]]), np.concatenate([sway, 0.0 * heaves[1]]))
