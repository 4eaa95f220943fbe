"""The error of a scene's reading, found by running its beginning more than once.

The beginning is run as the scene asks, and again with finer samples of the motion and a finer
tolerance. At the same instants the two readings differ by the error of sampling and steps. That
includes effects for which an interpolation formula would need details of each machine: one-sided
windows at the start, the effect of a wrong amplitude on the rate, a case or a thread that swings,
impulses, resonance. Errors that both runs share are not seen: the machine's own numbers, and
rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tauto_core.clockwork import TrochleaStage
from tauto_core.samples import NS_PER_S, PHASE, SHIP_IMU, Batches, FloatArray
from tauto_core.scene import Scene, Solver
from tauto_core.scene.errors import PropagationError, SceneError
from tauto_core.scene.sections import LEAST_TOLERANCE
from tauto_core.ship import ShipMotion
from tauto_core.ship.felt_step import felt_parts

SAFETY = 3.0
"""Factor on the difference found: the finer run is not exact either, and errors of later swings
may add up more unfavourably than those tried.
"""

FINER = (*range(4, 65), 3, 2)
"""Numbers of parts into which the finer run divides a step; the first that gives whole nanoseconds
is used.
"""

FINER_TOLERANCE = 1e-3
"""Factor of the tolerance in the finer run."""

CHUNK = 4096
"""Number of samples fed at once."""

STEEPEST = 3.0
"""Largest power of time by which an error grows: a force in resonance changes the amplitude in
proportion to t, and so the phase in proportion to t² where the rate depends on the amplitude.
"""

CHAOTIC = 1.5, 12.0
"""An error is taken to grow exponentially if its logarithm grows by more in the second half of a
trial than in its second quarter, and the error by more than this factor.
"""


@dataclass(frozen=True)
class Dial:
    """The quantities that turn phases into readings.

    Attributes:
        nominal_s: time by which the dial advances in a turn of the phase [s].
        rounding_s: error below which differences mean nothing [s].
    """

    nominal_s: float
    rounding_s: float


@dataclass(frozen=True)
class Trial:
    """The errors that trial runs of the beginning of a scene showed.

    Attributes:
        tried_s: length of the beginning [s].
        sampling_s: bound of the error of the reading in the whole run by sampling the motion [s];
            None on a ship that lies still, or where no finer step is a whole number of
            nanoseconds.
        steps_s: the same for the steps; 0 where none are taken. A finer tolerance may divide the
            motion into other pieces; the difference by these may count as sampling or as steps.
    """

    tried_s: float
    sampling_s: float | None
    steps_s: float


def try_out(scene: Scene, dial: Dial, longest_s: float, tolerance: float | None) -> Trial:
    """Run the beginning of a scene as it is, with a finer tolerance, and with finer samples too.

    Args:
        scene: a scene that runs, on a ship that moves or with a propagator that takes steps.
        dial: the dial of the scene.
        longest_s: length of the beginning, in whole log intervals, at least two [s].
        tolerance: tolerance of the steps; None where none are taken.
    """
    interval_s = scene.log_interval_ns / NS_PER_S
    logs = min(max(int(longest_s / interval_s), 2), scene.log_count - 1)
    beginning = scene.model_copy(update={'duration': logs * interval_s})
    phases, steps_s = _phases(beginning), 0.0
    if tolerance is not None:
        solver = Solver(tolerance=max(FINER_TOLERANCE * tolerance, LEAST_TOLERANCE))
        beginning = beginning.model_copy(update={'solver': solver})
        as_asked, phases = phases, _phases(beginning)
        steps_s = _bound(as_asked, phases, scene, dial)
    finer = None if scene.lies_still else _finer(beginning)
    sampling_s = None if finer is None else _bound(phases, _phases(finer), scene, dial)
    return Trial(beginning.duration, sampling_s, steps_s)


def _finer(scene: Scene) -> Scene | None:
    """Return a scene with its motion sampled more finely; None where that is impossible."""
    for parts in FINER:
        rate = NS_PER_S / (scene.step_ns / parts)
        ship = scene.ship.model_copy(update={'rate': rate})
        finer = scene.model_copy(update={'ship': ship})
        try:
            felt_parts(finer)
        except SceneError:  # a suspended case divides the step itself
            continue
        if scene.step_ns % parts == 0:
            return finer
    return None


def _phases(scene: Scene) -> FloatArray:
    """Return half turns and fractions at logged instants, (n, 2).

    Up to the end, or to the last logged instant before the motion ends with an error.
    """
    while True:
        try:
            return _sailed(scene)
        except PropagationError as ended:
            interval_s = scene.log_interval_ns / NS_PER_S
            logs = math.ceil(min(ended.time_s, scene.duration) / interval_s) - 1
            if logs < 1:
                return np.empty((0, 2))
            scene = scene.model_copy(update={'duration': logs * interval_s})


def _sailed(scene: Scene) -> FloatArray:
    """Return half turns and fractions at the logged instants of a scene, (n, 2)."""
    motion, stage, said = ShipMotion(scene), TrochleaStage(scene), [np.empty((0, 2))]

    def take(batches: Batches) -> None:
        if PHASE in batches:
            said.append(batches[PHASE].position[:, 1:3])  # type: ignore[union-attr]

    while len((imu := motion.sense(CHUNK)).stamp_ns):
        take(stage.feed({SHIP_IMU: imu}))
    take(stage.finish())
    return np.concatenate(said)


def _bound(one: FloatArray, other: FloatArray, scene: Scene, dial: Dial) -> float:
    """Return a bound of the difference between two runs at the end of a scene [s]."""
    both = min(len(one), len(other))
    half_turns = (one[:both] - other[:both]).sum(axis=1)
    apart: FloatArray = 0.5 * dial.nominal_s * half_turns
    times = np.arange(both, dtype=np.float64) * (scene.log_interval_ns / NS_PER_S)
    return SAFETY * extrapolated(times, apart, scene.duration, dial.rounding_s)


def extrapolated(times: FloatArray, error: FloatArray, end_s: float, rounding_s: float) -> float:
    """Return the largest size of an error at a later time, by extrapolation.

    Its largest size so far continues to grow as in the second half of the known part, by a power
    of time, or exponentially if that fits; or as a straight line, if that gives more.

    Args:
        times: increasing from 0, evenly spaced, (n,) [s].
        error: known there, (n,).
        end_s: the later time [s].
        rounding_s: size below which the error is noise.

    Returns:
        At most `end_s`; a clock with such an error shows nothing.
    """
    if len(times) < 2:
        return 0.0
    tried_s, sizes = float(times[-1]), np.abs(error)
    most, half, quarter = (float(np.max(sizes[times <= tried_s / n])) for n in (1, 2, 4))
    if end_s <= tried_s or most == 0.0:
        return most
    doubling = math.log(most / max(half, min(rounding_s, most)))
    before = math.log(max(half, rounding_s) / max(quarter, rounding_s))
    if doubling > max(CHAOTIC[0] * before, math.log(CHAOTIC[1])):
        exponent = doubling * (end_s - tried_s) / (0.5 * tried_s)
    else:
        exponent = min(doubling / math.log(2.0), STEEPEST) * math.log(end_s / tried_s)
    slope = abs(float(np.polyfit(times, error, 1)[0]))
    known_s = math.log(end_s / most)
    grown = end_s if exponent > known_s else most * math.exp(exponent)
    return min(max(grown, most + slope * (end_s - tried_s)), end_s)
