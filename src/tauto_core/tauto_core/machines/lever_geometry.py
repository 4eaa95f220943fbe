"""Sully's lever: where thread and lever are when the wheel has turned (Euler 1727, V).

The thread leaves an involute of base radius r on the wheel's axle C, is inclined by δ and tied at
B to a lever AD that turns about A. At rest the lever is horizontal and B under C. With u = θ − δ,
n = (cos δ, sin δ) and d = (sin δ, −cos δ)

    B = r u n + (r + l) d,    l = l₀ − r u²/2,    |B − A| = AB,    A = (−AB, −(r + l₀)).

B's distance from C knows u² only, and the lever's angle β only: given either of them, the other
and θ follow without iteration. `u` is therefore what everything here is a function of. Forms are
free of cancellation near rest, where β falls with u².
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauto_core.samples import FloatArray

LEAST_COSINE = 0.1
"""cos(β − δ) or cos β at the edge: beyond, the lever is within six degrees of a dead point, in line
with the thread, or of upright."""

LEAST_FREE = 0.1
"""Part of the thread that is still free at the edge."""

_SCAN = 4096
_NEWTON = 60


@dataclass(frozen=True)
class LeverGeometry:
    """The lengths of a lever machine, each > 0.

    Attributes:
        base_radius: r of the involute [m].
        arm: AB, from the fulcrum to the thread [m].
        length: l₀ of the free thread at rest [m].
    """

    base_radius: float
    arm: float
    length: float

    @property
    def depth(self) -> float:
        """Depth of B under C at rest, r + l₀ [m]."""
        return self.base_radius + self.length

    def free(self, u: FloatArray) -> FloatArray:
        """Return l, the thread's free length [m]."""
        return self.length - 0.5 * self.base_radius * u * u

    def beta(self, u: FloatArray) -> FloatArray:
        """Return β, the lever's angle above the horizontal [rad]; NaN where there is none.

        (r + l₀) sin β − AB (1 − cos β) = K, a quadratic equation for tan β/2.
        """
        square = self.base_radius * u * u
        k = square * (self.length - 0.25 * square) / (2.0 * self.arm)
        rest = self.depth**2 - k * (k + 2.0 * self.arm)
        root = np.sqrt(np.where(rest > 0.0, rest, np.nan))
        return np.asarray(2.0 * np.arctan(k / (self.depth + root)))

    def u_of_sine(self, sine: FloatArray) -> FloatArray:
        """Return u ≥ 0 of sin β ≥ 0, β at most a right angle."""
        half = sine / (1.0 + np.sqrt((1.0 - sine) * (1.0 + sine)))
        q = 2.0 * self.arm * sine * (self.depth - self.arm * half)
        free = np.sqrt(self.length * self.length - q)
        return np.asarray(np.sqrt(2.0 * q / (self.base_radius * (self.length + free))))

    def delta(self, u: FloatArray, beta: FloatArray) -> FloatArray:
        """Return δ, the thread's inclination [rad]."""
        half = np.sin(0.5 * beta)
        across, down = -2.0 * self.arm * half * half, self.depth - self.arm * np.sin(beta)
        inner = np.arctan2(self.base_radius * u, self.base_radius + self.free(u))
        return np.asarray(np.arctan2(across, down) - inner)

    def theta(self, u: FloatArray) -> FloatArray:
        """Return θ, the wheel's angle [rad]."""
        return np.asarray(u + self.delta(u, self.beta(u)))

    def rates(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dθ/du and dβ/du; the first vanishes at a dead point, neither is singular there."""
        beta = self.beta(u)
        fall = self.depth * np.cos(beta) - self.arm * np.sin(beta)
        free = self.free(u)
        cosine = np.cos(beta - self.delta(u, beta))
        return free * cosine / fall, self.base_radius * u * free / (self.arm * fall)

    def slopes(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dβ/dθ, the ratio of the two lever arms, and d²β/dθ² [1/rad]."""
        beta = self.beta(u)
        delta = self.delta(u, beta)
        sine, cosine = np.sin(beta - delta), np.cos(beta - delta)
        arm = self.arm * cosine
        first = self.base_radius * u / arm
        inclines = -(self.base_radius + self.arm * first * sine) / self.free(u)
        second = self.base_radius * (1.0 - inclines) / arm
        return first, second + first * sine / cosine * (first - inclines)

    def u_of(self, theta: FloatArray) -> FloatArray:
        """Return u of the wheel's angle, within the edges (Newton's method, kept in brackets)."""
        low, high = (np.full_like(theta, edge) for edge in self.edges())
        u = np.clip(theta * (1.0 + self.base_radius / self.length), low, high)
        for _ in range(_NEWTON):
            beyond = self.theta(u) - theta
            low, high = np.where(beyond < 0.0, u, low), np.where(beyond > 0.0, u, high)
            new = u - beyond / self.rates(u)[0]
            new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
            done = np.abs(new - u) <= 2e-16 * np.abs(new)
            u = new
            if done.all():
                break
        return np.asarray(u)

    def edges(self) -> tuple[float, float]:
        """Return the least and the largest u: where a dead point or the thread's end is near."""
        longest = float(np.sqrt(2.0 * (1.0 - LEAST_FREE) * self.length / self.base_radius))
        return -self._edge(-longest), self._edge(longest)

    def _edge(self, longest: float) -> float:
        """Return the largest |u| of usable geometry on a side."""
        grid = longest * np.arange(1, _SCAN + 1) / _SCAN
        bad = np.flatnonzero(~self._usable(grid))
        if not len(bad):
            return abs(longest)
        a, b = float(grid[bad[0]] - longest / _SCAN), float(grid[bad[0]])
        for _ in range(60):
            middle = 0.5 * (a + b)
            good = bool(self._usable(np.array([middle]))[0])
            a, b = (middle, b) if good else (a, middle)
        return abs(a)

    def _usable(self, u: FloatArray) -> np.ndarray:
        beta = self.beta(u)
        cosine = np.cos(beta - self.delta(u, beta))
        fall = self.depth * np.cos(beta) - self.arm * np.sin(beta)
        return np.asarray((np.minimum(cosine, np.cos(beta)) >= LEAST_COSINE) & (fall > 0.0))
