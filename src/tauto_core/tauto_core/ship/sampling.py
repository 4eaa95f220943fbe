"""The rate at which a ship's motion is sampled, chosen for the accuracy that a scene asks for.

The error of the motion between its samples is known without sailing: that of the interpolation of
each wave (`ship.buffer`), by the product of the distances to the nodes. How much of it reaches the
reading depends on the machine. It is bounded by factors that were measured over the built-in
scenes and those of the benchmark, from 2 to 12.5 Hz, against 40 Hz: see
docs/theory/accuracy.md.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

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
"""Samples on either side of a piece in the windows of roll, which has a rate, and of the force."""

MAX_STRIDE = 8
"""Most samples that one piece spans."""

LARGEST_TURN = 0.4
"""Largest phase of the fast mode of a case between two samples [rad]; the interpolation error is
then below 3e-8 of the amplitude of that mode.
"""

COARSE, LARGEST_COARSE_TURN = 1e-3, 1.2
"""The same where the accuracy is at least so much [s/day]: the sea hardly moves the fast mode, so
that it changed the reading by 1e-5 s in 2.5 days of a winter sea. Most of that is made at the
start: up to 2.4e-5 s in random seas.
"""

LARGEST_SLOW_TURN = 0.05
"""Largest phase of the slow mode between two samples where angles may be large [rad]. A swing of
1 rad has overtones, which then put the wheel off by 1e-9 of its swing; at 0.1 rad it is 1e-6.
"""

MOST_STEP_PARTS = 64
"""Largest number of parts into which a step of the ship's motion is divided."""

RATES_HZ: tuple[float, ...] = (
    *(1.0, 1.25, 1.6, 2.0, 2.5, 4.0, 5.0, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 40.0, 50.0),
    *(80.0, 100.0, 125.0, 200.0, 250.0, 400.0, 500.0, 1000.0, 2000.0),
)
"""Rates to choose from [Hz]; their steps are whole nanoseconds."""

REACHES = 1e-2
"""Part of the error of the motion that reaches the clock's rate, both relative: at most 1.3e-4 in
fixed clocks with an escapement over six hours, 2e-3 in half a minute. It is largest in the first
piece, whose window has one side.
"""

REMEMBERS = 10.0
"""The same over that of a clock with an escapement, where there is none: it keeps a wrong
amplitude, and its rate with it: 5e-2 in all at most.
"""

HUNG = 30.0
"""The same over that of a fixed clock, where the sea may excite a suspended case or a thread that
swings, unless `HUNG_UNDER_WAY` is for it (found: 50, and 200 without an escapement, both in all).
"""


UNDER_WAY = 1e-3
"""The same for the error of all pieces but the first, of a fixed clock with an escapement: found
1.3e-4, in the worst of forty days of a log.
"""

BEGUN_S = 30.0
"""Error of the reading of such a clock over the error of the first piece [s]:
found 8 s after three hours, in which the escapement brings the amplitude back.
"""

HUNG_UNDER_WAY, HUNG_BEGUN_S = 0.2, 300.0
"""The same for a clock in a case that swings by linear equations: found 0.04 in all, in 2.5 days
of a winter's passage with a weight, and next to nothing with a force; and 60 s, in random waves.
"""

TRIED_WINDOWS = 64
"""Windows at the beginning of a run at which the apparent gravity itself is interpolated."""

MOST_WAVES = 128
"""Most waves of a roll whose force is computed at those windows."""

NEARLY_WEIGHTLESS = 0.1
"""Apparent gravity over g, below which no rate is asked for: where it vanishes it has a kink,
which no polynomial follows.
"""

SEARCHED = 64
"""Parts of the beginning of a run in whose steepest instants overtones are taken, and the instants
looked at in each part.
"""

SEARCH_TURN = 0.7
"""Mean phase of the roll from one of these instants to the next [rad]."""

FIRST_REACHES, STEEP_REACHES = 1.0 / 30.0, 0.1
"""Parts of the error of overtones that count, of the first piece and, in the mean square, of those
at the steepest instants: an error of 1e-6 s was found where they were 60 to 2000 times as large as
the error that is allowed to the waves.
"""

ONE_THREAD = 2**17
"""Products of numbers in a product of matrices that takes a single thread: a second one takes
longer to start than the rest of the work.
"""

ROUNDING = 1e-14
"""Error of the motion below which it is that of rounding, which finer samples do not reduce."""


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

    The steps divide the log interval, and a wave has more than two of them. Where no rate is
    high enough it is the highest that fits; where the motion cannot be had, the ship's own. Of a
    clock with an escapement, asked for less than the default, the first piece counts once, unless
    its thread swings, or its case widely: they keep what that piece gave them.

    Args:
        scene: the scene of the motion.
        ship: how she moves; her own rate does not matter.
        accuracy: error of the clock's rate by sampling [s/day].
        forgets: whether an escapement keeps the amplitude.
        swings: whether case or thread swings, which the sea may excite.
        case_hz: least rate that the modes of a suspended case allow [Hz]; None without a case.
        linear: whether all that swings is a case, by linear equations.
    """
    rates = [rate for rate in _rates_hz(scene) if case_hz is None or rate >= case_hz]

    def worst(ship: ShipKind) -> list[ShipKind]:
        return [sea.ship for sea in ship.worst_seas(scene)]

    if forgets and (linear or not swings) and accuracy > ACCURACY:
        # a trial of the scene (`checks.cost`) has its first piece in one of the worst seas
        demands = _under_way(accuracy, worst, worst, hung=case_hz is not None)
    else:
        allowed = accuracy / (DAY_S * REACHES)
        allowed /= (1.0 if forgets else REMEMBERS) * (HUNG if swings else 1.0)
        demands = [(False, allowed, worst)]
    return _lowest(scene, ship, rates, demands, strides=case_hz is None)


def rate_under_way(scene: Surroundings, ship: ShipKind, accuracy: float) -> float:
    """Return the lowest rate for a voyage of days of a fixed clock with an escapement.

    The first piece, whose window has one side, counts once and not as if all were like it: in the
    sea in which the voyage begins, not in the worst one as for `rate_for`.
    """
    demands = _under_way(
        accuracy,
        lambda ship: [*ship.seas_at_start(scene)],
        lambda ship: [sea.ship for sea in ship.worst_seas(scene)],
    )
    return _lowest(scene, ship, _rates_hz(scene), demands, strides=True)


Seas: TypeAlias = 'Callable[[ShipKind], list[ShipKind]]'
"""The seas of a ship that count: the ship in each."""

Demand: TypeAlias = tuple[bool, float, Seas]
"""Whether windows have both sides, the error that is allowed there, and in which seas."""


def _under_way(
    accuracy: float, at_start: Seas, later: Seas, *, hung: bool = False
) -> list[Demand]:
    """Return the demands of a clock with an escapement; its first piece counts once."""
    begun_s, share = (HUNG_BEGUN_S, HUNG_UNDER_WAY) if hung else (BEGUN_S, UNDER_WAY)
    return [(False, accuracy / begun_s, at_start), (True, accuracy / (DAY_S * share), later)]


def largest_turn(accuracy: float | None, *, linear: bool) -> float:
    """Return the largest phase of the fast mode of a case between two samples [rad].

    `accuracy` is that of the scene; `linear`: whether the case swings by linear equations.
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
    """Return the lowest rate that meets all demands; pieces span samples if there are strides."""
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
        bent = [case for case in moving if _is_bent(case[2], ship)]
        steep = [
            (inner, allowed, _Steep(motion, scene, ship))
            for inner, allowed, motion in moving
            if _has_overtones(motion, ship) and not _is_bent(motion, ship)
        ]
    except TautoError:  # it is said where the motion is made
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
    """Return whether nothing refuses the ship at a rate."""
    sampled = ship.model_copy(update={'rate': rate})
    try:
        sampled.channels(scene)
    except TautoError:
        return False
    return next(sampled.problems(), None) is None


def _waves(
    scene: Surroundings, ship: ShipKind, channels: Channels
) -> Iterator[tuple[FloatArray, FloatArray, bool]]:
    """Yield amplitudes [rad, or over g], frequencies [rad/s], whether rates come with them."""
    for force in (channels.force_y, channels.force_z):
        if force is not None:
            yield np.abs(force.amplitude) / scene.g, force.angular_frequency, False
    if isinstance(channels.roll, Harmonics):
        size, omega = np.abs(channels.roll.amplitude), channels.roll.angular_frequency
        yield size, omega, True
        # roll sways a clock at this height, and no rate comes with that force
        yield size * omega**2 * abs(ship.height) / scene.g, omega, False
    six = channels.six
    lifted = (channels.heave,) if six is None else (channels.heave, six.sway, six.surge)
    for motion in lifted:
        if isinstance(motion, Harmonics):
            omega = motion.angular_frequency
            yield np.abs(motion.amplitude) * omega**2 / scene.g, omega, False


def _is_bent(channels: Channels, ship: ShipKind) -> bool:
    """Return whether a roll of few waves, at a height, bends the force at the clock."""
    roll, heave = channels.roll, channels.heave
    if not isinstance(roll, Harmonics) or isinstance(heave, Fades) or ship.height == 0.0:
        return False
    return channels.six is None and channels.force_z is None and len(roll.amplitude) <= MOST_WAVES


def _strays(
    motion: Channels, scene: Surroundings, ship: ShipKind, rate: float, stride: int, *, inner: bool
) -> float:
    """Return the largest error of the interpolated apparent gravity, over g, and its direction.

    The roll makes forces of higher orders in its angle, and the direction of the whole is no
    linear function of it: these are overtones, which `_waves` does not have. So the force itself
    is taken at the first window, unless only those with both sides count, and at some that follow.
    """
    error = 0.0
    for wide in {True, inner}:
        values, _, places = _weights(stride, False, wide)
        count = min(TRIED_WINDOWS, int(scene.duration * rate / stride)) if wide else 1
        begins = stride * np.arange(max(count, 1))[:, None]
        nodes = _apparent((begins + np.arange(values.shape[1])) / rate, motion, ship, scene)
        true = _apparent((begins + places) / rate, motion, ship, scene)
        heavy = np.min(nodes[1], axis=1) > NEARLY_WEIGHTLESS
        for value, exact in zip(nodes, true, strict=True):
            wrong = np.abs(value @ values.T - exact)[heavy]
            error = max(error, float(np.max(wrong, initial=0.0)))
    return error


def _apparent(
    time_s: FloatArray, channels: Channels, ship: ShipKind, scene: Surroundings
) -> tuple[FloatArray, FloatArray]:
    """Return direction [rad] and size over g of the apparent gravity at some times (ship.md)."""
    roll, rate, bend = (_summed(channels.roll, time_s, order) for order in range(3))
    sway = -ship.height * (bend * np.cos(roll) - rate**2 * np.sin(roll))
    lift = scene.g - ship.height * (bend * np.sin(roll) + rate**2 * np.cos(roll))
    lift += _summed(channels.heave, time_s, 2)
    return np.arctan2(-sway, lift), np.hypot(sway, lift) / scene.g


def _summed(wave: Harmonics | Fades | None, time_s: FloatArray, order: int) -> FloatArray:
    """Return a derivative of a sum of harmonics at some times."""
    total = np.zeros_like(time_s)
    if isinstance(wave, Harmonics):
        total += 0.0 if order else wave.mean
        waves = zip(wave.amplitude, wave.angular_frequency, wave.phase, strict=True)
        for size, omega, phase in waves:
            angle = omega * time_s + (phase + 0.5 * np.pi * order)
            total += size * omega**order * np.cos(angle)
    return total


ComplexArray: TypeAlias = NDArray[np.complex128]


class _Times:
    """Times t_n + u_m [s], (n, m), at which sums of harmonics are products of two matrices.

    e^{iΩ(t + u)} = e^{iΩt} e^{iΩu}: n + m exponentials of each wave do for n m instants, so that
    hundreds of waves cost little.
    """

    def __init__(self, start_s: FloatArray, offset_s: FloatArray) -> None:
        self._start_s, self._offset_s = start_s, offset_s
        self._turned: dict[bytes, tuple[ComplexArray, FloatArray]] = {}

    def summed(self, wave: Harmonics | Fades | None, order: int) -> FloatArray:
        """Return a derivative of a sum of harmonics, (n, m); zero without one."""
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
        overtones: its direction [rad] and its size, less their linear parts, (2, n, m).
        size: of the whole.
        upward: its part upwards in the ship.
        bent: how far it is from that of a ship at rest, over its size.
    """

    overtones: FloatArray
    size: FloatArray
    upward: FloatArray
    bent: FloatArray


class _Steep:
    """The apparent gravity at a clock, and the instants at which the motions bend it most.

    Attributes:
        at_s: the steepest instant of each of `SEARCHED` parts of the beginning [s].
        least_upward: least part upwards in the ship that the force has there [m/s²].
    """

    def __init__(self, channels: Channels, scene: Surroundings, ship: ShipKind) -> None:
        self._channels, self._g, self._height = channels, scene.g, ship.height
        assert isinstance(channels.roll, Harmonics)
        size, omega = np.abs(channels.roll.amplitude), channels.roll.angular_frequency
        turns, n = float(np.linalg.norm(size * omega)), SEARCHED
        step_s = scene.duration / n**2
        if turns > 0.0:
            step_s = min(step_s, SEARCH_TURN * float(np.linalg.norm(size)) / turns)
        offsets: FloatArray = step_s * np.arange(n, dtype=np.float64)
        begins: FloatArray = n * offsets
        force = self.force(_Times(begins, offsets))
        self.at_s: FloatArray = begins + offsets[np.argmax(force.bent, axis=1)]
        self.least_upward = scene.g * float(np.min(force.upward))

    def force(self, times: _Times) -> _Force:
        """Return the force at some times (ship.md, hull.md)."""
        channels, six, g, height = self._channels, self._channels.six, self._g, self._height
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
            np.stack([direction + sway / g, size - 1.0 - heave / g]),
            size,
            (upright * cosine - aside * sine) / g,
            np.hypot(aside, upright - g) / (g * size),
        )


def _has_overtones(channels: Channels, ship: ShipKind) -> bool:
    """Return whether the force at the clock is no linear function of the waves."""
    roll, heave = channels.roll, channels.heave
    if not isinstance(roll, Harmonics) or isinstance(heave, Fades) or channels.force_z is not None:
        return False
    return channels.six is not None or ship.height != 0.0


def _misses_overtones(motion: _Steep, rate: float, stride: int, *, inner: bool) -> float:
    """Return the error of the interpolated overtones that counts, over g, or of the direction.

    As `_strays` does for few waves, it takes the first window, unless only those with both sides
    count, and others, but at the steepest instants: in a sea of many waves steep rolls are rare.
    """
    error = 0.0
    for wide in {True, inner}:
        values, _, places = _weights(stride, False, wide)
        pieces = np.floor(motion.at_s * (rate / stride)) if wide else np.zeros(1)
        starts: FloatArray = np.maximum(stride * pieces - FORCE_BEFORE * wide, 0.0)
        nodes = np.arange(values.shape[1], dtype=np.float64)
        offsets = np.concatenate([nodes, places]) * (1.0 / rate)
        begins: FloatArray = starts * (1.0 / rate)
        force = motion.force(_Times(begins, offsets))
        sampled, exact = np.split(force.overtones, [len(nodes)], axis=2)
        heavy = np.min(force.size, axis=1) > NEARLY_WEIGHTLESS
        wrong = np.max(np.abs(sampled @ values.T - exact), axis=2)[:, heavy]
        if wrong.size:
            mean = float(np.max(np.sqrt(np.mean(wrong * wrong, axis=1))))
            error = max(error, (STEEP_REACHES if wide else FIRST_REACHES) * mean)
    return error


def least_upward(scene: Surroundings, ship: ShipKind) -> float:
    """Return the least force upwards in the ship, in the worst seas [m/s²].

    At the beginning of the run, and for a ship whose motion was computed; else infinite.
    """
    lowest = math.inf
    for sea in ship.worst_seas(scene):
        channels = sea.ship.channels(scene)
        if isinstance(channels.roll, Harmonics) and channels.force_z is None:
            lowest = min(lowest, _Steep(channels, scene, sea.ship).least_upward)
    return lowest


def _remainder(stride: int, turns: FloatArray, *, slopes: bool, inner: bool = False) -> FloatArray:
    """Return the largest error over a piece of a wave of unit amplitude.

    `turns` are Ωh of the waves. The window begins at the piece, as at the start of a run, or it
    has both sides.
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
