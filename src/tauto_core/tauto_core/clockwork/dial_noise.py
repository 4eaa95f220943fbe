"""Noise of the dial: white and random-walk frequency noise, in exact discrete form (theory E8)."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.samples import NS_PER_S, FloatArray, IntArray, State
from tauto_core.scene import Scene

BLOCK = 4096
"""Number of log indices drawn from one generator; the result depends on it."""

STREAM = 0x6469616C
"""Number of this stream of random numbers from the scene's seed ("dial" in ASCII)."""


class DialNoise:
    """Noise that is added to the reading: phase x [s] and relative rate y over log intervals τ.

    x' = x + τ y + w₁, y' = y + w₂; w₁ and w₂ are normal with the covariance

        | q1 τ + q2 τ³/3   q2 τ²/2 |
        | q2 τ²/2          q2 τ    |

    of the integrals over τ of ẋ = y + white noise (q1), ẏ = white noise (q2): Zucca and Tavella,
    Metrologia 42 (2005) 289. x = y = 0 at log index 0, when the dial is set. The two normal
    numbers of an index are a function of the seed and the index alone.

    Args:
        scene: its `clock.white_fm`, `clock.random_walk_fm`, `log.interval` and `seed`.
    """

    def __init__(self, scene: Scene) -> None:
        self._seed = scene.seed
        tau = scene.log_interval_ns / NS_PER_S
        q1, q2 = scene.clock.white_fm_s, scene.clock.random_walk_fm_per_s
        self._tau = tau
        # w₁ is half of τ w₂ and an independent part of the variance q1 τ + q2 τ³ (1/3 − 1/4)
        self._own_sigma = math.sqrt(q1 * tau + q2 * tau**3 / 12.0)
        self._rate_sigma = math.sqrt(q2 * tau)
        self._index, self._x, self._y = 0, 0.0, 0.0
        self._block, self._normals = -1, np.empty((0, 2))

    def offsets_ns(self, index: IntArray) -> IntArray:
        """Return the noise of the readings at some log indices [ns], (n,).

        Args:
            index: increasing, none before the last one of the previous call.
        """
        first = self._index
        x, _ = self.advance(int(index[-1]))
        return np.rint(NS_PER_S * x[index - first]).astype(np.int64)

    def advance(self, last: int) -> tuple[FloatArray, FloatArray]:
        """Return x [s] and y from the index reached to `last`, both included."""
        normal = self._drawn(self._index + 1, last)
        steps = self._rate_sigma * normal[:, 1]
        y = np.cumsum(np.concatenate(([self._y], steps)))
        own = self._own_sigma * normal[:, 0] + (0.5 * self._tau) * steps
        x = np.cumsum(np.concatenate(([self._x], self._tau * y[:-1] + own)))
        self._index, self._x, self._y = last, float(x[-1]), float(y[-1])
        return x, y

    def _drawn(self, first: int, last: int) -> FloatArray:
        """Return the normal numbers of the indices first to last, (last − first + 1, 2)."""
        parts = [np.empty((0, 2))]
        for block in range(first // BLOCK, last // BLOCK + 1) if first <= last else ():
            if block != self._block:
                seeds = np.random.SeedSequence(self._seed, spawn_key=(STREAM, block))
                generator = np.random.Generator(np.random.PCG64(seeds))
                self._block, self._normals = block, generator.standard_normal((BLOCK, 2))
            begin, end = max(first - block * BLOCK, 0), last + 1 - block * BLOCK
            parts.append(self._normals[begin:end])
        return np.concatenate(parts)

    def state(self) -> State:
        """Return index, phase and rate reached."""
        return {'index': self._index, 'x': self._x, 'y': self._y}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._index, self._x, self._y = state['index'], state['x'], state['y']
