"""The sea in equal pieces of time, each stretch fitted to the exact sum of waves as it comes."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from benchmarks.work_precision.equations import piece_kernels as kernels
from benchmarks.work_precision.equations.sea import constants_of, sea_from
from benchmarks.work_precision.problems import Numbers, Sea
from tauto_core.samples import FloatArray

_ORDERS = 4
"""Number of derivatives of roll, itself included, for the apparent vertical and its rate."""


class SeaPieces:
    """Chains of the channels that act on a machine (`piece_kernels`).

    The linear machine depends on the roll, which is linear in the waves, so one matrix gives its
    chain from their phasors. The other needs gamma' and g_eff, and with impulses the lean.

    Args:
        numbers: numbers of the problem.
        sea: sea of the problem.
        length_s: length of a piece [s].
        points: number of points at which each piece is fitted.
        scale: scale of the chains.
    """

    def __init__(
        self, numbers: Numbers, sea: Sea, length_s: float, points: int, scale: float
    ) -> None:
        self.length_s, self.points, self.scale = length_s, points, scale
        self.channels = 1 if not numbers.mass else 3 if numbers.impulse_energy else 2
        self._sea, self._constants = sea, constants_of(numbers)
        self._linear = not numbers.mass
        self._fit, self._chain = kernels.to_chebyshev(points), kernels.to_chain(points)
        self._table = self._sampling()
        angle = length_s * np.arange(kernels.BLOCK)[:, None, None] * sea.omega
        self._turns = np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
        self._phasors = np.empty((kernels.BLOCK, 2 * len(sea.omega)))
        self._chains = np.empty((kernels.BLOCK, self.channels * points))

    def _sampling(self) -> FloatArray:
        """Return the matrix from phasors to roll and derivatives at points, or to the chain."""
        at = 0.5 * self.length_s * (1.0 + kernels.chebyshev_points(self.points))
        order = np.arange(1 if self._linear else _ORDERS)
        omega = self._sea.omega[:, None, None]
        angle = omega * at[:, None] + 0.5 * np.pi * order
        size = self._sea.amplitude[:, None, None] * omega**order
        table = np.concatenate([size * np.cos(angle), -size * np.sin(angle)])
        table = table.reshape(-1, self.points * len(order))
        if not self._linear:
            return table
        return np.ascontiguousarray(self.scale * (self._chain @ (self._fit @ table.T)).T)

    def blocks(self, begin_s: float, length_s: float) -> Iterator[tuple[float, FloatArray]]:
        """Yield the remaining time of a stretch [s] and the chains of its next pieces.

        Args:
            begin_s: beginning of the stretch, from the start [s].
            length_s: length of the stretch [s].
        """
        sea, now = sea_from(self._sea, begin_s), 0.0
        while now < length_s:
            left = length_s - now
            pieces = min(kernels.BLOCK, math.ceil(left / self.length_s))
            phasors, chains = self._phasors[:pieces], self._chains[:pieces]
            kernels.fill_phasors(sea, now, self._turns, phasors)
            if self._linear:
                np.matmul(phasors, self._table, out=chains)
            else:
                rolls = phasors @ self._table
                kernels.fill_chains(
                    rolls, self._constants, self.scale, self._fit.T.copy(), self._chain, chains
                )
            yield left, chains
            now += kernels.BLOCK * self.length_s
