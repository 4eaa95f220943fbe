"""The rate at which a ship's motion is sampled, chosen for the accuracy of a scene.

The interpolation error of each wave between samples (`ship.buffer`) is known in closed form. The
part that reaches the clock's reading depends on the machine. It is bounded by factors measured
over the built-in and the benchmark's scenes, from 2 to 12.5 Hz, against 40 Hz
(docs/theory/accuracy.md).
"""

from __future__ import annotations

import math
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import FloatArray
from tauto_core.scene.errors import TautoError
from tauto_core.scene.sections import ACCURACY
from tauto_core.scene.times import DAY_S, NS_PER_S, exact_step
from tauto_core.ship.motions import Channels, ShipKind, Surroundings
from tauto_core.ship.waves import Fades, Harmonics

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

ROLL_BEFORE, FORCE_BEFORE = 1, 4
"""Samples on either side of a piece in the windows of roll, which has rates, and of force."""

MAX_STRIDE = 8
"""Most samples that one piece spans."""

LARGEST_TURN = 0.4
"""Largest phase of a case's fast mode between two samples [rad]. The interpolation error is then
below 3e-8 of the amplitude of that mode.
"""

COARSE, LARGEST_COARSE_TURN = 1e-3, 1.2
"""At an accuracy of 1e-3 s/day or more, the largest phase is 1.2 rad, since the sea hardly excites
the fast mode: the reading changed by 1e-5 s in 2.5 days of a winter sea, and by up to 2.4e-5 s in
random seas, mostly at the start.
"""

LARGEST_SLOW_TURN = 0.05
"""Largest phase of the slow mode between two samples for large angles [rad]. The overtones of a 1
rad swing then change the wheel's angle by 1e-9, relative, and at 0.1 rad phase by 1e-6.
"""

MOST_STEP_PARTS = 64
"""Largest number of parts into which a step of the ship's motion is divided."""

RATES_HZ: tuple[float, ...] = (
    *(1.0, 1.25, 1.6, 2.0, 2.5, 4.0, 5.0, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 40.0, 50.0),
    *(80.0, 100.0, 125.0, 200.0, 250.0, 400.0, 500.0, 1000.0, 2000.0),
)
"""Rates to choose from [Hz]. Their steps are whole nanoseconds."""

REACHES = 1e-2
"""Bound of the ratio of the clock's relative rate error to the motion's. Measured on fixed clocks
with an escapement: 1.3e-4 over six hours, 2e-3 over half a minute, mostly from the first piece,
which has a one-sided window.
"""

REMEMBERS = 10.0
"""Factor on `REACHES` without an escapement, since errors of the amplitude persist (measured
ratio: at most 5e-2).
"""

HUNG = 30.0
"""Factor on `REACHES` if the sea may excite a suspended case or a swinging thread (measured ratio:
at most 50, and 200 without an escapement).
"""


UNDER_WAY = 1e-3
"""The same ratio for all pieces but the first, for a fixed clock with an escapement. Measured:
1.3e-4 in the worst of forty days of a log.
"""

BEGUN_S = 30.0
"""Error of the reading of such a clock over the error of the first piece [s]. Measured: 8 s after
three hours, in which the escapement restores the amplitude.
"""

HUNG_UNDER_WAY, HUNG_BEGUN_S = 0.2, 300.0
"""The same two for a clock in a case with linear equations. Measured: 0.04 in 2.5 days of a winter
passage with a weight, much less with a force, and 60 s in random waves.
"""

TRIED_WINDOWS = 64
"""Windows at the beginning of a run in which the apparent gravity itself is interpolated."""

MOST_WAVES = 128
"""Largest number of waves of a roll for which that is done."""

NEARLY_WEIGHTLESS = 0.1
"""Windows with less apparent gravity, over g, are left out: at 0 the direction has a kink that
polynomials cannot follow.
"""

SEARCHED = 64
"""Number of parts of a run's beginning, and of instants in each, searched for the steepest."""

SEARCH_TURN = 0.7
"""Mean phase of the roll between two of these instants [rad]."""

FIRST_REACHES, STEEP_REACHES = 1.0 / 30.0, 0.1
"""Weights of the errors of overtones in the first piece and, in the mean square, at the steepest
instants. Errors of 1e-6 s were found with overtones off by 60 to 2000 times the error allowed to
the waves.
"""

ONE_THREAD = 2**17
"""Largest matrix product, in multiplications, that takes a single thread. A second one takes
longer to start than the work.
"""

ROUNDING = 1e-14
"""Relative error of the motion by rounding, which finer samples do not reduce."""


def rate_for(
    scene: Surroundings,
    ship: ShipKind,
    accuracy: float,
    *,
    forgets: bool,
    swings: bool,
    case_hz: float | None,
    linear: bool = False,
) -> float:
    """Return the lowest of `RATES_HZ` that keeps the error of the rate below the accuracy.

    The steps divide the log interval, and each wave has more than two. If no rate is high enough,
    it is the highest that fits. If the motion has a fault, it is the ship's own. With an
    escapement and a coarser accuracy than the default, the first piece counts once, unless its
    error persists in a swinging thread or a widely swinging case.

    Args:
        scene: the scene of the motion.
        ship: the motion, of which the own rate does not matter.
        accuracy: error of the clock's rate by sampling [s/day].
        forgets: whether an escapement restores the amplitude.
        swings: whether the sea may excite case or thread.
        case_hz: least rate for the modes of a suspended case [Hz], `None` without a case.
        linear: whether only a case swings, by linear equations.
    """
    rates = [rate for rate in _rates_hz(scene) if case_hz is None or rate >= case_hz]

    def worst(ship: ShipKind) -> list[ShipKind]:
        return [sea.ship for sea in ship.worst_seas(scene)]

    if forgets and (linear or not swings) and accuracy > ACCURACY:
        # a trial of the scene (`checks.cost`) begins in one of the worst seas
        demands = _under_way(accuracy, worst, worst, hung=case_hz is not None)
    else:
        allowed = accuracy / (DAY_S * REACHES)
        allowed /= (1.0 if forgets else REMEMBERS) * (HUNG if swings else 1.0)
        demands = [(False, allowed, worst)]
    return _lowest(scene, ship, rates, demands, strides=case_hz is None)


def rate_under_way(scene: Surroundings, ship: ShipKind, accuracy: float) -> float:
    """Return the lowest rate for a voyage of days of a fixed clock with an escapement.

    The first piece counts once, in the sea in which the voyage begins, not in the worst one as in
    `rate_for`.
    """
    demands = _under_way(
        accuracy,
        lambda ship: [*ship.seas_at_start(scene)],
        lambda ship: [sea.ship for sea in ship.worst_seas(scene)],
    )
    return _lowest(scene, ship, _rates_hz(scene), demands, strides=True)


Seas: TypeAlias = 'Callable[[ShipKind], list[ShipKind]]'
"""The seas that count: the ship in each of them."""

Demand: TypeAlias = tuple[bool, float, Seas]
"""Whether windows have both sides, the largest error, and the seas."""


def _under_way(
    accuracy: float, at_start: Seas, later: Seas, *, hung: bool = False
) -> list[Demand]:
    """Return the demands of a clock with an escapement, for which the first piece counts once."""
    begun_s, share = (HUNG_BEGUN_S, HUNG_UNDER_WAY) if hung else (BEGUN_S, UNDER_WAY)
    return [(False, accuracy / begun_s, at_start), (True, accuracy / (DAY_S * share), later)]


def largest_turn(accuracy: float | None, *, linear: bool) -> float:
    """Return the largest phase of a case's fast mode between two samples [rad].

    `accuracy` [s/day] is the scene's. `linear`: the case swings by linear equations.
    """
    coarse = accuracy is not None and accuracy >= COARSE and linear
    return LARGEST_COARSE_TURN if coarse else LARGEST_TURN


def _rates_hz(scene: Surroundings) -> list[float]:
    return [rate for rate in RATES_HZ if scene.log_interval_ns % exact_step(rate) == 0]


def _lowest(
    scene: Surroundings,
    ship: ShipKind,
    rates: Sequence[float],
    demands: Sequence[Demand],
    *,
    strides: bool,
) -> float:
    """Return the lowest rate that meets all demands. `strides`: pieces span several samples."""
    if not rates:
        return ship.rate
    try:
        finest = ship.model_copy(update={'rate': rates[-1]})
        moving = [
            (inner, max(allowed, ROUNDING), sea.channels(scene))
            for inner, allowed, seas in demands
            for sea in seas(finest)
            if not sea.lies_still
        ]
        tests = [
            (inner, allowed, tuple(_waves(scene, ship, motion)))
            for inner, allowed, motion in moving
        ]
        curved = [case for case in moving if _has_overtones(case[2], ship)]
        bent = [case for case in curved if _rolls_in_few_waves(case[2])]
        steep = [
            (inner, allowed, _Steep(motion, scene, ship))
            for inner, allowed, motion in curved
            if not _rolls_in_few_waves(motion)
        ]
    except TautoError:  # reported when the motion is made
        return ship.rate
    for rate in rates[:-1]:
        logs = round(scene.log_interval_ns * rate / NS_PER_S)
        fitting = (n for n in range(MAX_STRIDE, 0, -1) if logs % n == 0)
        stride = next(fitting) if strides else 1
        met = (
            np.linalg.norm(
                amplitude * _remainder(stride, omega / rate, slopes=slopes, inner=inner)
            )
            <= allowed
            for inner, allowed, waves in tests
            for amplitude, omega, slopes in waves
        )
        if not all(met):
            continue
        stray = any(
            _strays(motion, scene, ship, rate, stride, inner=inner) > allowed
            for inner, allowed, motion in bent
        )
        stray = stray or any(
            _misses_overtones(motion, rate, stride, inner=inner) > allowed
            for inner, allowed, motion in steep
        )
        if not stray and _follows(scene, ship, rate):
            return rate
    return rates[-1]


def _follows(scene: Surroundings, ship: ShipKind, rate: float) -> bool:
    """Return whether the ship accepts a rate."""
    sampled = ship.model_copy(update={'rate': rate})
    try:
        sampled.channels(scene)
    except TautoError:
        return False
    return next(sampled.problems(), None) is None


def _waves(
    scene: Surroundings, ship: ShipKind, channels: Channels
) -> Iterator[tuple[FloatArray, FloatArray, bool]]:
    """Yield amplitudes [rad, or over g], frequencies [rad/s], and whether rates are sampled."""
    for force in (channels.force_y, channels.force_z):
        if force is not None:
            yield np.abs(force.amplitude) / scene.g, force.angular_frequency, False
    if isinstance(channels.roll, Harmonics):
        size, omega = np.abs(channels.roll.amplitude), channels.roll.angular_frequency
        yield size, omega, True
        # roll sways a clock at this height, with a force that has no sampled rate
        yield size * omega**2 * abs(ship.height) / scene.g, omega, False
    six = channels.six
    lifted = (channels.heave,) if six is None else (channels.heave, six.sway, six.surge)
    for motion in lifted:
        if isinstance(motion, Harmonics):
            omega = motion.angular_frequency
            yield np.abs(motion.amplitude) * omega**2 / scene.g, omega, False


def _strays(
    motion: Channels, scene: Surroundings, ship: ShipKind, rate: float, stride: int, *, inner: bool
) -> float:
    """Return the largest error of the interpolated apparent gravity, over g, and its direction.

    The force has overtones of the roll, which `_waves` leaves out. So the force itself is
    interpolated, in the first window (unless only those with both sides count) and in some that
    follow.
    """
    error = 0.0
    force = partial(_apparent, motion, g=scene.g, height=ship.height)
    for wide in {True, inner}:
        count = min(TRIED_WINDOWS, int(scene.duration * rate / stride)) if wide else 1
        starts = stride * np.arange(max(count, 1), dtype=np.float64)
        wrong = _wrong(force, starts, rate, stride, wide=wide, part='whole')
        error = max(error, float(np.max(wrong, initial=0.0)))
    return error


def _wrong(
    force_at: Callable[[_Times], _Force],
    starts: FloatArray,
    rate: float,
    stride: int,
    *,
    wide: bool,
    part: Literal['whole', 'overtones'],
) -> FloatArray:
    """Return errors of a part of the force in windows that begin at samples, (2, n', m).

    Windows that are nearly weightless are left out.
    """
    values, _, places = _weights(stride, False, wide)
    nodes = np.arange(values.shape[1], dtype=np.float64)
    force = force_at(_Times(starts / rate, np.concatenate([nodes, places]) / rate))
    sampled, exact = np.split(getattr(force, part), [len(nodes)], axis=2)
    heavy = np.min(force.whole[1], axis=1) > NEARLY_WEIGHTLESS
    return np.asarray(np.abs(sampled @ values.T - exact)[:, heavy])


ComplexArray: TypeAlias = NDArray[np.complex128]


class _Times:
    """Times t_n + u_m [s], (n, m), at which sums of harmonics are products of two matrices.

    e^{iΩ(t + u)} = e^{iΩt} e^{iΩu}: n + m exponentials of each wave serve n m instants.
    """

    def __init__(self, start_s: FloatArray, offset_s: FloatArray) -> None:
        self._start_s, self._offset_s = start_s, offset_s
        self._turned: dict[bytes, tuple[ComplexArray, FloatArray]] = {}

    def summed(self, wave: Harmonics | Fades | None, order: int) -> FloatArray:
        """Return a derivative of a sum of harmonics, (n, m), zeros without harmonics."""
        if not isinstance(wave, Harmonics):
            return np.zeros((len(self._start_s), len(self._offset_s)))
        omega, key = wave.angular_frequency, wave.period.tobytes()
        if key not in self._turned:  # the motions of a ship in a sea share their periods
            angle = np.outer(omega, self._offset_s)
            self._turned[key] = (
                np.exp(1j * np.outer(self._start_s, omega)),
                np.concatenate([np.cos(angle), np.sin(angle)]),
            )
        start, offset = self._turned[key]
        turned = start * (wave.amplitude * (1j * omega) ** order * np.exp(1j * wave.phase))
        waves = np.concatenate([turned.real, -turned.imag], axis=1)
        rows = max(1, ONE_THREAD // max(1, offset.size))
        parts = np.split(waves, range(rows, len(waves), rows))
        total: FloatArray = np.concatenate([part @ offset for part in parts])
        return total if order else total + wave.mean


class _Force(NamedTuple):
    """The apparent gravity over g, arrays of shape (n, m) but the first.

    Attributes:
        whole: its direction [rad] and its size, (2, n, m).
        overtones: their nonlinear parts, (2, n, m).
        upward: its component upwards in the ship.
        bent: distance from the apparent gravity at rest, over its size.
    """

    whole: FloatArray
    overtones: FloatArray
    upward: FloatArray
    bent: FloatArray


class _Steep:
    """The apparent gravity at a clock, and the instants at which it is most nonlinear.

    Attributes:
        at_s: the steepest instant of each of `SEARCHED` parts of the beginning [s].
        force: returns the apparent gravity at some times.
        least_upward: least component upwards in the ship [m/s²].
    """

    def __init__(self, channels: Channels, scene: Surroundings, ship: ShipKind) -> None:
        assert isinstance(channels.roll, Harmonics)
        size, omega = np.abs(channels.roll.amplitude), channels.roll.angular_frequency
        turns, n = float(np.linalg.norm(size * omega)), SEARCHED
        step_s = scene.duration / n**2
        if turns > 0.0:
            step_s = min(step_s, SEARCH_TURN * float(np.linalg.norm(size)) / turns)
        offsets: FloatArray = step_s * np.arange(n, dtype=np.float64)
        begins: FloatArray = n * offsets
        self.force = partial(_apparent, channels, g=scene.g, height=ship.height)
        force = self.force(_Times(begins, offsets))
        self.at_s: FloatArray = begins + offsets[np.argmax(force.bent, axis=1)]
        self.least_upward = scene.g * float(np.min(force.upward))


def _apparent(channels: Channels, times: _Times, g: float, height: float) -> _Force:
    """Return the apparent gravity at some times (ship.md, hull.md)."""
    six = channels.six
    roll, heave = times.summed(channels.roll, 0), times.summed(channels.heave, 2)
    sine, cosine = np.sin(roll), np.cos(roll)
    if six is None:
        rate, bend = (times.summed(channels.roll, order) for order in (1, 2))
        ahead, sway = np.zeros_like(roll), -height * bend
        aside = sway * cosine + height * rate**2 * sine
        upright = g + heave + sway * sine - height * rate**2 * cosine
    else:
        forward, sway = (times.summed(motion, 2) for motion in (six.surge, six.sway))
        pitch, yaw = (times.summed(motion, 0) for motion in (six.pitch, six.yaw))
        along = np.cos(yaw) * forward + np.sin(yaw) * sway
        aside = np.cos(yaw) * sway - np.sin(yaw) * forward
        up = g + heave
        ahead = np.cos(pitch) * along - np.sin(pitch) * up
        upright = np.sin(pitch) * along + np.cos(pitch) * up
    size = np.sqrt(ahead**2 + aside**2 + upright**2) / g
    direction = np.arctan2(-aside, upright)
    return _Force(
        np.stack([direction, size]),
        np.stack([direction + sway / g, size - 1.0 - heave / g]),
        (upright * cosine - aside * sine) / g,
        np.hypot(aside, upright - g) / (g * size),
    )


def _has_overtones(channels: Channels, ship: ShipKind) -> bool:
    """Return whether the force at the clock is nonlinear in the waves."""
    roll, heave = channels.roll, channels.heave
    if not isinstance(roll, Harmonics) or isinstance(heave, Fades) or channels.force_z is not None:
        return False
    return channels.six is not None or ship.height != 0.0


def _rolls_in_few_waves(channels: Channels) -> bool:
    roll = channels.roll
    return (
        channels.six is None and isinstance(roll, Harmonics) and len(roll.amplitude) <= MOST_WAVES
    )


def _misses_overtones(motion: _Steep, rate: float, stride: int, *, inner: bool) -> float:
    """Return the weighted error of the interpolated overtones, over g, or of the direction.

    Like `_strays`, but at the steepest instants, since steep rolls are rare in a sea of many
    waves.
    """
    error = 0.0
    for wide in {True, inner}:
        pieces = np.floor(motion.at_s * (rate / stride)) if wide else np.zeros(1)
        starts: FloatArray = np.maximum(stride * pieces - FORCE_BEFORE * wide, 0.0)
        wrong = _wrong(motion.force, starts, rate, stride, wide=wide, part='overtones').max(axis=2)
        if wrong.size:
            mean = float(np.max(np.sqrt(np.mean(wrong * wrong, axis=1))))
            error = max(error, (STEEP_REACHES if wide else FIRST_REACHES) * mean)
    return error


def least_upward(scene: Surroundings, ship: ShipKind) -> float:
    """Return the least specific force upwards in the ship, in the worst seas [m/s²].

    At the beginning of the run, for a computed motion, else infinite.
    """
    lowest = math.inf
    for sea in ship.worst_seas(scene):
        channels = sea.ship.channels(scene)
        if isinstance(channels.roll, Harmonics) and channels.force_z is None:
            lowest = min(lowest, _Steep(channels, scene, sea.ship).least_upward)
    return lowest


def _remainder(stride: int, turns: FloatArray, *, slopes: bool, inner: bool = False) -> FloatArray:
    """Return the largest error over a piece of a wave of unit amplitude.

    `turns` are Ωh of the waves. The window begins at the piece, as at the start of a run, or has
    both sides.
    """
    values, rates, places = _weights(stride, slopes, inner)
    nodes = np.arange(values.shape[1])
    waves = np.exp(1j * np.outer(nodes, turns))
    estimate = values @ waves + rates @ (1j * turns * waves)
    error: FloatArray = np.max(np.abs(estimate - np.exp(1j * np.outer(places, turns))), axis=0)
    return error


@lru_cache(maxsize=4 * MAX_STRIDE)
def _weights(stride: int, slopes: bool, inner: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the weights of values and rates at places of a piece, and the places.

    Lagrange's polynomials, or with slopes Hermite's (Stoer & Bulirsch, 2.1).
    """
    margin = ROLL_BEFORE if slopes else FORCE_BEFORE
    nodes = np.arange(stride + 1 + 2 * margin, dtype=np.float64)
    places: FloatArray = (np.arange(2 * stride, dtype=np.float64) + 0.5) / 2.0 + margin * inner
    rows = [np.delete(nodes, j) for j in range(len(nodes))]
    lagrange: FloatArray = np.stack(
        [
            np.prod((places[:, None] - row) / (node - row), axis=1)
            for node, row in zip(nodes, rows, strict=True)
        ],
        axis=1,
    )
    if not slopes:
        return lagrange, np.zeros_like(lagrange), places
    away = places[:, None] - nodes
    bend = np.array([np.sum(1.0 / (node - row)) for node, row in zip(nodes, rows, strict=True)])
    square: FloatArray = lagrange * lagrange
    return (1.0 - 2.0 * away * bend) * square, away * square, places
