"""The sea that the machines feel, at an instant and in pieces, and the states that come of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from benchmarks.work_precision.equations import piece_kernels as kernels
from benchmarks.work_precision.problems import CaseProblem, Numbers, Problem, Sea
from tauto_core.samples import FloatArray

# -----------------------------------------------------------------------------
# A sea whose phases stay exact at late times.
#
# Far from the start omega t + phase loses digits. So long runs are divided into stretches, each
# with time zero at its beginning and phases reduced exactly.


def turns_at(sea: Sea, time_s: float) -> list[Fraction]:
    """Return the fractional turns of each component since the start."""
    time = Fraction(time_s)
    return [time / Fraction(float(period)) % 1 for period in sea.period]


def sea_from(sea: Sea | None, time_s: float) -> FloatArray:
    """Return the sea with time zero at `time_s`: rows amplitude, omega, phase; shape (3, n)."""
    if sea is None:
        return np.empty((3, 0))
    turns = np.array([float(turn) for turn in turns_at(sea, time_s)])
    return np.stack([sea.amplitude, sea.omega, sea.phase + 2.0 * np.pi * turns])


def stretches(duration_s: float, length_s: float) -> Iterator[tuple[float, float]]:
    """Yield (start, length) of consecutive stretches [s] that make up a duration."""
    start = 0.0
    while start < duration_s:
        yield start, min(length_s, duration_s - start)
        start += length_s


def constants_of(numbers: Numbers) -> FloatArray:
    """Return the numbers in the order of the kernels, shape (8,)."""
    return np.array(
        [
            numbers.inertia,
            numbers.lever_rate,
            numbers.force,
            numbers.mass,
            numbers.gravity,
            numbers.viscous,
            numbers.impulse_energy,
            0.0 if numbers.sea is None else numbers.sea.height,
        ]
    )


# -----------------------------------------------------------------------------
# The sea in equal pieces of time, each stretch fitted to the exact sum of waves as it comes.

_ORDERS = 4
"""Number of derivatives of roll, itself included, for the apparent vertical and its rate."""


class SeaPieces:
    """Chains of the channels that act on a machine (`piece_kernels`).

    The linear machine depends on the roll, which is linear in the waves, so one matrix gives its
    chain from their phasors. The other needs gamma' and g_eff, and with impulses the lean.

    A piece of `length_s` is fitted at `points` points; the chains are multiplied by `scale`.
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
        """Yield the remaining time of a stretch [s] and the chains of its next pieces."""
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


# -----------------------------------------------------------------------------
# What the peers' equations share: one first-order form for the wheel, its start and end.
#
# The case's equations are in `case_kernels`; its state is (theta, phi, theta', phi'). For the
# wheel, x = psi - gamma is the angle that the cam feels, eps = m b^2/I, and u = p/I is the
# momentum of the machine over the wheel's inertia (docs/theory/machine_at_sea.md):
#
#     x' = (u - gamma')/(1 + eps x^2)
#     u' = x (eps x'^2 - b (P + m g_eff)/I) - (c/I) theta',      theta' = x' + gamma' - rho'
#
# No gamma'' is needed. The lean is eta = gamma - rho = atan2(A, B), A = z0 rho'' - g sin rho,
# B = g cos rho - z0 rho'^2 (specific force in the ship's axes, ship.md), and
# g_eff^2 = A^2 + B^2.


@dataclass(frozen=True)
class Vertical:
    """Thread and ship at an instant: lean eta, eta' [rad, rad/s], g_eff [m/s2], rho, rho'."""

    lean: float
    lean_rate: float
    gravity: float
    roll: float
    roll_rate: float


def vertical(numbers: Numbers, time_s: float) -> Vertical:
    """Return the direction of the thread at a time from the start [s]."""
    gravity, sea = numbers.gravity, numbers.sea
    if sea is None:
        return Vertical(0.0, 0.0, gravity, 0.0, 0.0)
    angle = sea.omega * time_s + sea.phase
    cosine, sine = sea.amplitude * np.cos(angle), sea.amplitude * np.sin(angle)
    roll, rate = np.sum(cosine), -np.sum(sea.omega * sine)
    second, third = -np.sum(sea.omega**2 * cosine), np.sum(sea.omega**3 * sine)
    across = sea.height * second - gravity * np.sin(roll)
    along = gravity * np.cos(roll) - sea.height * rate * rate
    across_rate = sea.height * third - gravity * np.cos(roll) * rate
    along_rate = -rate * (gravity * np.sin(roll) + 2 * sea.height * second)
    square = across * across + along * along
    follows = 1.0 if numbers.follows_vertical else 0.0
    return Vertical(
        follows * np.arctan2(across, along),
        follows * (across_rate * along - across * along_rate) / square,
        np.sqrt(square),
        roll,
        rate,
    )


def mass_ratio(numbers: Numbers) -> float:
    """Return eps = m b^2/I."""
    return numbers.mass * numbers.lever_rate**2 / numbers.inertia


def start(numbers: Numbers) -> tuple[float, float]:
    """Return x [rad] and u [rad/s] of the wheel released at rest in its case."""
    at = vertical(numbers, 0.0)
    x = numbers.release_angle - at.lean
    u = -(1 + mass_ratio(numbers) * x * x) * at.lean_rate + at.lean_rate + at.roll_rate
    return x, u


def wheel(numbers: Numbers, time_s: float, x: float, u: float) -> tuple[float, float]:
    """Return theta [rad] and theta' [rad/s] of the wheel in its case."""
    at = vertical(numbers, time_s)
    speed = (u - at.lean_rate - at.roll_rate) / (1 + mass_ratio(numbers) * x * x)
    return x + at.lean, speed + at.lean_rate


def pieces_start(numbers: Numbers) -> tuple[float, float]:
    """Return x and u, or of a force psi and psi', of the wheel released at rest in its case."""
    if numbers.mass:
        return start(numbers)
    at = vertical(numbers, 0.0)
    return numbers.release_angle + at.roll, at.roll_rate


def pieces_wheel(numbers: Numbers, time_s: float, x: float, u: float) -> tuple[float, float]:
    """Return theta [rad] and theta' [rad/s] of such a state."""
    if numbers.mass:
        return wheel(numbers, time_s, x, u)
    at = vertical(numbers, time_s)
    return x - at.roll, u - at.roll_rate


def start_of(problem: Problem) -> tuple[float, ...]:
    """Return the state at the start: x and u, or the case's theta, phi and their rates."""
    if isinstance(problem, CaseProblem):
        return problem.numbers.release_angle, problem.numbers.release_angle, 0.0, 0.0
    return start(problem.numbers)


def end_of(problem: Problem, time_s: float, state: Any) -> tuple[float, float]:
    """Return the angle [rad] and rate [rad/s] that are compared: theta of the wheel or phi."""
    if isinstance(problem, CaseProblem):
        return float(state[1]), float(state[3])
    return wheel(problem.numbers, time_s, float(state[0]), float(state[1]))
