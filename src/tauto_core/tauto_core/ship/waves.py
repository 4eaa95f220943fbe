"""Sums of harmonics, sampled on the grid of the scene, accurate at any time.

x(t) = mean + sum a_i cos(2 pi t/T_i + eps_i), t = k step from the start of the scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import NS_PER_S, FloatArray

BLOCK = 512
TOGETHER = 8
"""Number of samples summed together (source_kernels)."""
_UNITS_PER_TURN = 2**64
_TWO_PI = Fraction(62831853071795864769252867665590057683943387987502, 10**49)


@dataclass(frozen=True)
class Harmonics:
    """x(t) = mean + sum a_i cos(2 pi t/T_i + eps_i); t from the start of the scene.

    The period, not the angular frequency, is the exact number: the phase after 100 days is that
    of exactly this period.

    Attributes:
        amplitude: a, in the unit of x, shape (n,).
        period: T [s], > 0, shape (n,).
        phase: eps [rad], shape (n,).
        mean: in the unit of x.
    """

    amplitude: FloatArray
    period: FloatArray
    phase: FloatArray
    mean: float = 0.0

    @property
    def angular_frequency(self) -> FloatArray:
        """2 pi/T [rad/s], shape (n,)."""
        return 2.0 * np.pi / self.period

    def most(self, order: int) -> float:
        """Return a bound of the size of the sum's derivative of some order."""
        size = float(np.sum(np.abs(self.amplitude) * self.angular_frequency**order))
        return size + (0.0 if order else abs(self.mean))


class SampledHarmonics:
    """Values and derivatives of harmonics at sample indices k, t = k step.

    Phases are kept as integers in 2^-64 turns, so that a sample's phase is off by at most
    (k/BLOCK + 1) 2^-65 turns plus rounding: 1e-13 rad after 100 days at 20 Hz. Whole blocks of
    `BLOCK` samples at absolute indices are computed, and the last one is kept. So the bits of a
    sample depend on its index alone, and single samples cost little more than many together.

    Args:
        harmonics: the sum.
        step_ns: time between samples [ns], > 0.
    """

    def __init__(self, harmonics: Harmonics, step_ns: int) -> None:
        self._mean = harmonics.mean
        steps = [_steps_in_turns(step_ns, float(T)) for T in harmonics.period]
        phases = [_turns(float(eps)) for eps in harmonics.phase]
        # from the middle of a block, between two samples, to those after it
        within = _units([(n, 2 * d) for n, d in steps])[:, None] * np.arange(
            1, BLOCK, 2, dtype=np.uint64
        )
        angle = within.astype(np.int64) * float(_TWO_PI / _UNITS_PER_TURN)
        angle = angle.reshape(len(steps), BLOCK // 2 // TOGETHER, TOGETHER).swapaxes(0, 1)
        middles = [
            (2 * e * d + (BLOCK - 1) * n * b, 2 * b * d)
            for (e, b), (n, d) in zip(phases, steps, strict=True)
        ]
        self._arguments = (
            _units(middles),
            _units([(BLOCK * n, d) for n, d in steps]),
            np.array(harmonics.amplitude),
            np.array(harmonics.angular_frequency),
            _table(np.asarray(angle, np.float64)),
        )
        self._kept: dict[tuple[int, ...], tuple[int, list[FloatArray]]] = {}

    def between(self, first: int, last: int, *orders: int) -> list[FloatArray]:
        """Return samples k = first ... last - 1 of each order asked for, shape (last - first,).

        Args:
            first: >= 0.
            last: > first.
            orders: the orders of the derivatives, rising: 0 (the value), 1, 2; with 0 or 2 among
                them.
        """
        begin, blocks = self._kept.get(orders, (0, [np.empty(0)]))
        if first < begin or last > begin + len(blocks[0]):
            begin, end = first // BLOCK * BLOCK, -(-last // BLOCK) * BLOCK
            blocks = self._blocks(begin // BLOCK, end // BLOCK, orders)
            self._kept[orders] = end - BLOCK, [x[-BLOCK:].copy() for x in blocks]
        return [x[first - begin : last - begin] for x in blocks]

    def _blocks(self, first: int, last: int, orders: tuple[int, ...]) -> list[FloatArray]:
        from tauto_core.ship.source_kernels import sum_blocks  # only when needed

        outputs: list[FloatArray | None] = [None, None, None]
        for order in orders:
            outputs[order] = np.empty((last - first, BLOCK))
        sum_blocks(first, self._mean, *self._arguments, *outputs)
        return [out.reshape(-1) for out in outputs if out is not None]


def _table(angle: FloatArray) -> FloatArray:
    """Return cosines and sines by turns, shape (.., 8), a row in one line of the cache.

    Args:
        angle: shape (.., components, 8).
    """
    spare = np.empty(2 * angle.size + TOGETHER)
    first = -(spare.ctypes.data // spare.itemsize) % TOGETHER
    table = spare[first : first + 2 * angle.size].reshape(*angle.shape[:2], 2, TOGETHER)
    np.cos(angle, out=table[:, :, 0])
    np.sin(angle, out=table[:, :, 1])
    return table.reshape(-1, TOGETHER)


# Fractions as pairs of integers; reducing them to lowest terms would cost ten times as much.
def _steps_in_turns(step_ns: int, period_s: float) -> tuple[int, int]:
    """Return the exact turns of a step."""
    numerator, denominator = period_s.as_integer_ratio()
    return step_ns * denominator, NS_PER_S * numerator


def _turns(angle: float) -> tuple[int, int]:
    """Return the exact turns of an angle [rad]."""
    numerator, denominator = angle.as_integer_ratio()
    return numerator * _TWO_PI.denominator, denominator * _TWO_PI.numerator


def _units(turns: Sequence[tuple[int, int]]) -> NDArray[np.uint64]:
    """Return the fractional parts of exact turns, rounded to 2^-64 turns, halves to even."""
    return np.array([_unit(*each) for each in turns], np.uint64)


def _unit(numerator: int, denominator: int) -> int:
    whole, rest = divmod(numerator * _UNITS_PER_TURN, denominator)
    up = 2 * rest > denominator or (2 * rest == denominator and whole % 2 == 1)
    return (whole + up) % _UNITS_PER_TURN
