"""Sums of harmonics, as a ship under way meets them, and in a sea that changes.

x(t) = mean + sum a_i cos(2π t/T_i + ε_i), t = k step from the start of the scene.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import FloatArray
from tauto_core.scene.times import NS_PER_S

SUM_BLOCK = 512
TOGETHER = 8
"""Number of samples summed together, as lanes (`kernels`)."""
MOST_KEPT = 3
"""Number of sums kept in memory: two during a change, and one that has ended or comes next."""
_UNITS_PER_TURN = 2**64
_TWO_PI = Fraction(62831853071795864769252867665590057683943387987502, 10**49)


@dataclass(frozen=True)
class Harmonics:
    """x(t) = mean + sum a_i cos(2π t/T_i + ε_i), t from the start of the scene.

    The period is the exact number, not the angular frequency: it fixes the phase after 100 days.

    Attributes:
        amplitude: a, in the unit of x, shape (n,).
        period: T [s], > 0, shape (n,).
        phase: ε [rad], shape (n,).
        mean: in the unit of x.
    """

    amplitude: FloatArray
    period: FloatArray
    phase: FloatArray
    mean: float = 0.0

    @property
    def angular_frequency(self) -> FloatArray:
        """2π/T [rad/s], shape (n,)."""
        return 2.0 * np.pi / self.period

    def most(self, order: int) -> float:
        """Return an upper bound of the size of a derivative of the sum."""
        size = float(np.sum(np.abs(self.amplitude) * self.angular_frequency**order))
        return size + (0.0 if order else abs(self.mean))


def together(sums: Sequence[Harmonics]) -> Harmonics:
    """Return the sum of several sums of harmonics."""
    amplitude, period, phase = (
        np.concatenate([getattr(part, name) for part in sums])
        for name in ('amplitude', 'period', 'phase')
    )
    return Harmonics(amplitude, period, phase, sum(part.mean for part in sums))


class SampledHarmonics:
    """Values and derivatives of harmonics at sample indices k, t = k step.

    Phases are integers in 2⁻⁶⁴ turns. A sample's phase is off by at most (k/SUM_BLOCK + 1) 2⁻⁶⁵
    turns plus rounding: 1e-13 rad after 100 days at 20 Hz. Whole blocks of `SUM_BLOCK` samples are
    computed at absolute indices, and the last block is kept. A sample's bits depend on its index
    alone, and single samples cost little more than many together.

    Args:
        harmonics: the sum.
        step_ns: time between samples [ns], > 0.
    """

    def __init__(self, harmonics: Harmonics, step_ns: int) -> None:
        self._mean = harmonics.mean
        # motions athwart in head seas
        self._is_zero = harmonics.mean == 0.0 and not harmonics.amplitude.any()
        if self._is_zero:
            return
        steps, increment, table = _advance(harmonics.period.tobytes(), step_ns)
        angles = [phase.as_integer_ratio() for phase in harmonics.phase.tolist()]
        pi_above, pi_below = _TWO_PI.as_integer_ratio()
        phases = [(above * pi_below, below * pi_above) for above, below in angles]
        middles = [
            (2 * e * d + (SUM_BLOCK - 1) * n * b, 2 * b * d)
            for (e, b), (n, d) in zip(phases, steps, strict=True)
        ]
        self._arguments = (
            _units(middles),
            increment,
            np.array(harmonics.amplitude),
            np.array(harmonics.angular_frequency),
            table,
        )
        self._kept: dict[tuple[int, ...], tuple[int, list[FloatArray]]] = {}

    def between(self, start: int, stop: int, *orders: int) -> list[FloatArray]:
        """Return samples k = start ... stop - 1 of each order of derivative, (stop - start,).

        The orders 0 (the value), 1, 2 come in increasing order, with 0 or 2 among them.
        """
        if self._is_zero:
            return [np.zeros(stop - start) for _ in orders]
        begin, blocks = self._kept.get(orders, (0, [np.empty(0)]))
        if start < begin or stop > begin + len(blocks[0]):
            from tauto_core.ship.kernels import sum_blocks  # only when needed

            begin, end = start // SUM_BLOCK * SUM_BLOCK, -(-stop // SUM_BLOCK) * SUM_BLOCK
            outputs: list[FloatArray | None] = [None, None, None]
            for order in orders:
                outputs[order] = np.empty(((end - begin) // SUM_BLOCK, SUM_BLOCK))
            sum_blocks(begin // SUM_BLOCK, self._mean, *self._arguments, *outputs)
            blocks = [out.reshape(-1) for out in outputs if out is not None]
            self._kept[orders] = end - SUM_BLOCK, [x[-SUM_BLOCK:].copy() for x in blocks]
        return [x[start - begin : stop - begin] for x in blocks]


@lru_cache(maxsize=2 * MOST_KEPT)
def _advance(
    periods: bytes, step_ns: int
) -> tuple[list[tuple[int, int]], NDArray[np.uint64], FloatArray]:
    """Return the phase steps of periods [s], which all motions of a ship in a sea share.

    These are the exact turns of a step, as pairs of integers, the advance in a block [2⁻⁶⁴ turns],
    and the table of cosines and sines of `kernels.sum_blocks`.
    """
    # Fraction reduces to lowest terms and would cost ten times as much
    pairs = [period.as_integer_ratio() for period in np.frombuffer(periods).tolist()]
    steps = [(step_ns * below, NS_PER_S * above) for above, below in pairs]
    # from the middle of a block, between two samples, to those after it
    units = _units([(n, 2 * d) for n, d in steps])[:, None] * np.arange(
        1, SUM_BLOCK, 2, dtype=np.uint64
    )
    angle = units.astype(np.int64) * float(_TWO_PI / _UNITS_PER_TURN)
    angle = angle.reshape(len(steps), SUM_BLOCK // 2 // TOGETHER, TOGETHER).swapaxes(0, 1)
    # cosines and sines by turns, a row of eight in one line of the cache
    spare = np.empty(2 * angle.size + TOGETHER)
    offset = -(spare.ctypes.data // spare.itemsize) % TOGETHER
    table = spare[offset : offset + 2 * angle.size].reshape(*angle.shape[:2], 2, TOGETHER)
    np.cos(angle, out=table[:, :, 0])
    np.sin(angle, out=table[:, :, 1])
    return steps, _units([(SUM_BLOCK * n, d) for n, d in steps]), table.reshape(-1, TOGETHER)


def _units(turns: Sequence[tuple[int, int]]) -> NDArray[np.uint64]:
    """Return the fractional parts of exact turns in units of 2⁻⁶⁴ turns, rounded half to even."""
    units = []
    for numerator, denominator in turns:
        unit, part = divmod(numerator * _UNITS_PER_TURN, denominator)
        up = 2 * part > denominator or (2 * part == denominator and unit % 2 == 1)
        units.append((unit + up) % _UNITS_PER_TURN)
    return np.array(units, np.uint64)


# -----------------------------------------------------------------------------
# Waves as a ship under way meets them (theory/sea.md).

STANDING = 1e-12
"""Least encounter frequency [rad/s]. Slower waves are taken to move with the ship."""


@dataclass(frozen=True)
class Encounter:
    """Speed and heading of a ship in a long-crested sea.

    Attributes:
        speed: V [m/s], >= 0.
        heading: μ, direction in which the waves run, from the bow to port [rad]: 0 following
            seas, π/2 beam seas, π head seas.
        gravity: g [m/s2].
    """

    speed: float
    heading: float
    gravity: float

    def frequency(self, omega: FloatArray) -> FloatArray:
        """Return the encounter frequency ω - ω² V cos(μ)/g [rad/s] of waves ω > 0 in deep water.

        It is negative if the ship overtakes the waves.
        """
        if self.speed == 0.0:
            return omega
        met: FloatArray = omega - omega**2 * (self.speed * math.cos(self.heading) / self.gravity)
        return met

    def answer(self, waves: Harmonics, amplitude: FloatArray, lead: FloatArray) -> Harmonics:
        """Return the response sum amplitude_i cos(ω_e,i t + ε_i + lead_i) to waves ω, ε."""
        phase = waves.phase + lead
        if self.speed == 0.0:
            return Harmonics(amplitude, waves.period, phase)
        met = self.frequency(waves.angular_frequency)
        period = 2.0 * np.pi / np.maximum(np.abs(met), STANDING)
        return Harmonics(amplitude, period, np.where(met < 0.0, -phase, phase))

    def met(self, waves: Harmonics) -> Harmonics:
        """Return the elevation at the ship."""
        return self.answer(waves, waves.amplitude, np.zeros_like(waves.phase))


# -----------------------------------------------------------------------------
# Motion in a sea that changes: sums of harmonics that fade into one another
# (theory/weather.md).
#
# Between two states, at t_k and t_k+1, the motion is
#
#     x(t) = cos(½π s(u)) x_k(t) + sin(½π s(u)) x_k+1(t),    u = (t − t_k)/(t_k+1 − t_k),
#     s(u) = 35 u⁴ − 84 u⁵ + 70 u⁶ − 20 u⁷.
#
# The two are independent, so the variance is cos² σ_k² + sin² σ_k+1², without a dip. Three
# derivatives of s vanish at both ends. The process is evolutionary (Priestley, Evolutionary
# spectra and non-stationary processes, J. R. Stat. Soc. B 27, 1965).


@dataclass(frozen=True)
class Fades:
    """x(t) for states at increasing times, constant before the first and after the last.

    Attributes:
        at_ns: time of each state from the start of the scene, possibly before it, (n,), n > 0.
        sums: number of the sum of harmonics of each state, (n,), repeated if the motion continues.
            The states of one sum are adjacent.
        of: function that gives the harmonics of a sum, or `None` for a calm, x = 0.
    """

    at_ns: tuple[int, ...]
    sums: tuple[int, ...]
    of: Callable[[int], Harmonics | None]

    def most(self, order: int) -> float:
        """Return an upper bound of the size of a derivative of the motion, of order 0 to 2.

        During a change the derivatives of the angle contribute. They are below 1/s (and 1/s2) in
        changes of ten seconds or more.
        """
        sums = [self.of(number) for number in set(self.sums)]
        sizes = [sum(wave.most(n) for n in range(order + 1)) for wave in sums if wave is not None]
        return 4.0 * max(sizes, default=0.0)


class SampledFades:
    """Values and derivatives of a motion that fades, at sample indices k, t = k step.

    A sample's bits depend on its index alone. Only the sums that are present are computed: one in
    a steady sea, with the bits of `SampledHarmonics`, and two in a change.

    Args:
        fades: the motion.
        step_ns: time between samples [ns], > 0.
    """

    def __init__(self, fades: Fades, step_ns: int) -> None:
        self._fades, self._step_ns = fades, step_ns
        # the first sample at or after each state
        self._begins = [-(-at // step_ns) for at in fades.at_ns]
        self._kept: dict[int, SampledHarmonics | None] = {}
        self._zeros = np.zeros(0)

    def between(self, start: int, stop: int, *orders: int) -> list[FloatArray]:
        """Return samples k = start ... stop - 1 of each order, as `SampledHarmonics.between`."""
        parts, sums = [], self._fades.sums
        while start < stop:
            state = bisect_right(self._begins, start) - 1
            following = state + 1
            end = min([stop, *self._begins[following : following + 1]])
            state = max(state, 0)
            old = sums[state]
            new = sums[following] if following < len(sums) else old
            if old == new:
                parts.append(self._alone(old, (start, end), orders))
            else:
                parts.append(self._fading(state, (old, new), (start, end), orders))
            start = end
        if len(parts) == 1:
            return parts[0]
        return [np.concatenate(columns) for columns in zip(*parts, strict=True)]

    def _alone(
        self, number: int, span: tuple[int, int], orders: tuple[int, ...]
    ) -> list[FloatArray]:
        """Return samples of one sum. In a calm all orders share one array of zeros."""
        if number not in self._kept:
            harmonics = self._fades.of(number)
            while len(self._kept) >= MOST_KEPT:
                self._kept.pop(next(iter(self._kept)))
            self._kept[number] = (
                None if harmonics is None else SampledHarmonics(harmonics, self._step_ns)
            )
        sums = self._kept[number]
        if sums is not None:
            return sums.between(*span, *orders)
        samples = span[1] - span[0]
        if len(self._zeros) < samples:
            self._zeros = np.zeros(samples)
        return [self._zeros[:samples] for _ in orders]

    def _fading(
        self, state: int, numbers: tuple[int, int], span: tuple[int, int], orders: tuple[int, ...]
    ) -> list[FloatArray]:
        from tauto_core.ship.kernels import fade  # imports kernels

        motions = []
        for number in numbers:
            parts = self._alone(number, span, tuple(range(orders[-1] + 1)))
            # placeholders: `fade` reads only the derivatives that its outputs need
            motions.append((*parts, *[parts[0]] * (3 - len(parts))))
        samples = span[1] - span[0]
        outputs: list[FloatArray | None] = [None, None, None]
        for order in orders:
            outputs[order] = np.empty(-(-samples // TOGETHER) * TOGETHER)
        begin_ns, end_ns = self._fades.at_ns[state : state + 2]
        fade(span[0], self._step_ns, begin_ns, end_ns - begin_ns, *motions, *outputs)
        return [out[:samples] for out in outputs if out is not None]
