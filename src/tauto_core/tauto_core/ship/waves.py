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
"""Samples summed at one go (source_kernels)."""
_UNITS_PER_TURN = 2**64
_TWO_PI = Fraction(62831853071795864769252867665590057683943387987502, 10**49)


@dataclass(frozen=True)
class Harmonics:
    """x(t) = mean + sum a_i cos(2 pi t/T_i + eps_i); t from the start of the scene.

    The period, not the angular frequency, is the given number: the phase after 100 days is that
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


class SampledHarmonics:
    """Values and derivatives of harmonics at sample indices k, t = k step.

    Phases are kept as integers in 2^-64 turns, so that a sample's phase is off by at most
    (k/BLOCK + 1) 2^-65 turns plus rounding: 1e-13 rad after 100 days at 20 Hz. Whole blocks of
    `BLOCK` samples at absolute indices are computed, and the last one is kept: a sample's bits
    depend on its index alone, and samples asked for one by one cost little more than together.

    Args:
        harmonics: the sum.
        step_ns: time between samples [ns], > 0.
        orders: of the derivatives to compute, rising: 0 (the value), 1, 2; with 0 or 2 among them.
    """

    def __init__(self, harmonics: Harmonics, step_ns: int, orders: tuple[int, ...]) -> None:
        self._mean = harmonics.mean
        self._orders = orders
        steps = [Fraction(step_ns, NS_PER_S) / Fraction(float(T)) for T in harmonics.period]
        phases = [Fraction(float(eps)) / _TWO_PI for eps in harmonics.phase]
        # from the middle of a block, between two samples, to those after it
        within = _units([x / 2 for x in steps])[:, None] * np.arange(1, BLOCK, 2, dtype=np.uint64)
        angle = within.astype(np.int64) * float(_TWO_PI / _UNITS_PER_TURN)
        angle = angle.reshape(len(steps), BLOCK // 2 // TOGETHER, TOGETHER).swapaxes(0, 1)
        middle = Fraction(BLOCK - 1, 2)
        self._arguments = (
            _units([eps + middle * x for eps, x in zip(phases, steps, strict=True)]),
            _units([BLOCK * x for x in steps]),
            np.array(harmonics.amplitude),
            np.array(harmonics.angular_frequency),
            _table(np.asarray(angle, np.float64)),
        )
        self._kept_from = 0
        self._kept = [np.empty(0) for _ in orders]

    def between(self, first: int, last: int) -> list[FloatArray]:
        """Return samples k = first ... last - 1 of each order asked for, shape (last - first,).

        Args:
            first: >= 0.
            last: > first.
        """
        if self._kept_from <= first and last <= self._kept_from + len(self._kept[0]):
            begin, blocks = self._kept_from, self._kept
        else:
            begin, end = first // BLOCK * BLOCK, -(-last // BLOCK) * BLOCK
            blocks = self._blocks(begin // BLOCK, end // BLOCK)
            self._kept_from, self._kept = end - BLOCK, [x[-BLOCK:].copy() for x in blocks]
        return [x[first - begin : last - begin] for x in blocks]

    def _blocks(self, first: int, last: int) -> list[FloatArray]:
        from tauto_core.ship.source_kernels import sum_blocks  # only when needed

        outputs: list[FloatArray | None] = [None, None, None]
        for order in self._orders:
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


def _units(turns: Sequence[Fraction]) -> NDArray[np.uint64]:
    """Return the fractional parts of exact turns, rounded to 2^-64 turns."""
    return np.array([round(x * _UNITS_PER_TURN) % _UNITS_PER_TURN for x in turns], np.uint64)
