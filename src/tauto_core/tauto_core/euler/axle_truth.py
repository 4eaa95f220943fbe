"""Reference values for the pendulum on an axle, found without the formulas of paper C.

The eigenvalues of the flexibility matrix, whose rows are (e, c) and (e, c + k²/c), are b and b′;
motions are integrated; Lagrange's equations check Euler's own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tauto_core.machines.axle_pendulum import AxlePendulum, AxleState, forces
from tauto_core.samples import FloatArray

E, C, K, G = 0.1, 0.3, 0.15, 9.81
"""The body of the examples [m, m/s2]."""

THETA, PHI, THETA_RATE, PHI_RATE = 0.4, -0.7, 1.1, -0.3
"""A state far from rest [rad, rad/s]."""

SPEED, SPIN, TIME = 0.01, 0.02, 0.5
"""Initial n [m/s] and ν [rad/s] of a motion from equilibrium, and its time of comparison [s]."""


class TrueModes(NamedTuple):
    """b, b′ and B, B′ = cφ/θ of both modes."""

    b: float
    b_prime: float
    B: float
    B_prime: float


def true_modes(e: float, c: float, k: float) -> TrueModes:
    """Return both modes from the flexibility matrix."""
    values, vectors = np.linalg.eig(np.array([[e, c], [e, c + k * k / c]]))
    # body and link tilt to the same side in the slow mode, to opposite sides in the fast one
    tilts = c * vectors[1] / vectors[0]
    slow = int(np.argmax(tilts))
    fast = 1 - slow
    return TrueModes(*(float(x) for x in (values[slow], values[fast], tilts[slow], tilts[fast])))


def linear_motion(e: float, start: FloatArray, time_s: float) -> FloatArray:
    """Return θ, φ and their rates after some time by the linear equations, through DOP853."""
    from scipy.integrate import solve_ivp

    def slope(_: float, y: FloatArray) -> list[float]:
        bend = -G * C / K**2 * (y[1] - y[0])
        return [y[2], y[3], (-G * y[0] - C * bend) / e, bend]

    found = solve_ivp(slope, (0.0, time_s), start, method='DOP853', rtol=1e-12, atol=1e-18)
    end: FloatArray = found.y[:, -1]
    return end


def half_period(ratio: float) -> float:
    """Return when a body released in the shape θ : φ = c : ratio first comes to rest [s]."""
    from scipy.optimize import brentq

    def rate(time_s: float) -> float:
        return float(linear_motion(E, np.array([C, ratio, 0.0, 0.0]) * 1e-3, time_s)[3])

    guess = math.pi * math.sqrt((E + ratio) / G)
    return float(brentq(rate, 0.9 * guess, 1.1 * guess, xtol=1e-14))


def by_euler() -> FloatArray:
    """Return θ̈ and φ̈ far from rest by §8–10, whose two equations are linear in both."""

    def excess(bend: FloatArray) -> FloatArray:
        x = -E * (bend[0] * math.sin(THETA) + THETA_RATE**2 * math.cos(THETA))
        x -= C * (bend[1] * math.sin(PHI) + PHI_RATE**2 * math.cos(PHI))
        y = E * (bend[0] * math.cos(THETA) - THETA_RATE**2 * math.sin(THETA))
        y += C * (bend[1] * math.cos(PHI) - PHI_RATE**2 * math.sin(PHI))
        delta = math.sin(PHI - THETA)
        turned = C * delta * (x * math.cos(THETA) + y * math.sin(THETA))
        return np.array(
            [
                x * math.sin(THETA) - y * math.cos(THETA) - G * math.sin(THETA),
                turned - K**2 * bend[1] - G * C * math.cos(THETA) * delta,
            ]
        )

    at_zero = excess(np.zeros(2))
    matrix = np.stack([excess(unit) - at_zero for unit in np.eye(2)], axis=1)
    return np.asarray(np.linalg.solve(matrix, -at_zero), np.float64)


def by_lagrange() -> FloatArray:
    """Return θ̈ and φ̈ far from rest by Lagrange's equations for a link and a body."""
    cosine, sine = math.cos(PHI - THETA), math.sin(PHI - THETA)
    mass = np.array([[E * E, E * C * cosine], [E * C * cosine, C * C + K * K]])
    force = [
        E * C * sine * PHI_RATE**2 - G * E * math.sin(THETA),
        -E * C * sine * THETA_RATE**2 - G * C * math.sin(PHI),
    ]
    return np.asarray(np.linalg.solve(mass, np.array(force, np.float64)), np.float64)


def on_a_plane(body: AxlePendulum, phi: float, time_s: float) -> FloatArray:
    """Return s, φ and rates after a release from rest, by the full equations."""
    from scipy.integrate import solve_ivp

    def slope(_: float, y: FloatArray) -> list[float]:
        now = forces(body, AxleState(*y))
        return [y[2], y[3], float(now.arc_acceleration), float(now.tilt_acceleration)]

    found = solve_ivp(
        slope, (0.0, time_s), [0.0, phi, 0.0, 0.0], method='DOP853', rtol=1e-12, atol=1e-14
    )
    end: FloatArray = found.y[:, -1]
    return end


def part_that_falls() -> float:
    """Return the share of 1000 random bodies on convex supports that have an unstable mode."""
    rng = np.random.default_rng(1780)
    e, c, k = 10.0 ** rng.uniform(-2.0, 2.0, (3, 1000))
    matrices = np.stack([np.stack([-e, c], 1), np.stack([-e, c + k * k / c], 1)], 1)
    return float(np.mean(np.min(np.linalg.eigvals(matrices).real, axis=1) < 0.0))


def pushed_motion(time_s: float) -> FloatArray:
    """Return θ, φ and their rates after the push of SPEED and SPIN in equilibrium."""
    return linear_motion(E, np.array([0.0, 0.0, (SPEED - C * SPIN) / E, SPIN]), time_s)


def pushed_amplitudes() -> FloatArray:
    """Return α and α′ of that motion, its components along the eigenvectors."""
    own = true_modes(E, C, K)
    slow, fast = math.sqrt(G / own.b), math.sqrt(G / own.b_prime)
    shapes = np.array([[C * slow, C * fast], [own.B * slow, own.B_prime * fast]])
    return np.asarray(
        np.linalg.solve(shapes, np.array([(SPEED - C * SPIN) / E, SPIN])), np.float64
    )
