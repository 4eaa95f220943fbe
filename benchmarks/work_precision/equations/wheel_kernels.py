"""The problems' equations and the plain integrators on them, compiled by numba.

`constants` is (I, b, P, m, g, c, E, z0) as in `Numbers`; `sea` has the rows amplitude, omega and
phase at time zero of the kernel. The state of the weight-driven machine is (x, p) with
p = M(x) x' + I gamma', so that no second derivative of gamma is needed; that of the linear
machine is (psi, psi').
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from tauto_core.samples import FloatArray

INERTIA, LEVER, FORCE, MASS, GRAVITY, VISCOUS, ENERGY, HEIGHT = range(8)


@njit(cache=True, nogil=True)
def roll_of(time: float, sea: FloatArray) -> float:
    """Return the roll [rad] at a time [s]."""
    roll = 0.0
    for j in range(sea.shape[1]):
        roll += sea[0, j] * math.cos(sea[1, j] * time + sea[2, j])
    return roll


@njit(cache=True, nogil=True)
def roll_rates(time: float, sea: FloatArray) -> tuple[float, float, float, float]:
    """Return roll and its first three derivatives [rad/s^k]."""
    r0 = r1 = r2 = r3 = 0.0
    for j in range(sea.shape[1]):
        omega = sea[1, j]
        angle = omega * time + sea[2, j]
        cosine, sine = sea[0, j] * math.cos(angle), sea[0, j] * math.sin(angle)
        r0 += cosine
        r1 -= omega * sine
        r2 -= omega * omega * cosine
        r3 += omega * omega * omega * sine
    return r0, r1, r2, r3


@njit(cache=True, nogil=True)
def vertical_of(
    r0: float, r1: float, r2: float, r3: float, constants: FloatArray
) -> tuple[float, float, float]:
    """Return g_eff [m/s2], beta [rad] and its rate [rad/s] from roll and derivatives."""
    height, sine, cosine = constants[HEIGHT], math.sin(r0), math.cos(r0)
    across = -height * (r2 * cosine - r1 * r1 * sine)
    up = constants[GRAVITY] - height * (r2 * sine + r1 * r1 * cosine)
    across_rate = -height * (r3 * cosine - 3.0 * r1 * r2 * sine - r1**3 * cosine)
    up_rate = -height * (r3 * sine + 3.0 * r1 * r2 * cosine - r1**3 * sine)
    square = across * across + up * up
    rate = (across * up_rate - up * across_rate) / square
    return math.sqrt(square), math.atan2(-across, up), rate


@njit(cache=True, nogil=True)
def slope(x: float, p: float, vertical: FloatArray, constants: FloatArray) -> tuple[float, float]:
    """Return x' and p' of the weight-driven machine.

    `vertical` is g_eff, beta, beta', roll, roll'.
    """
    inertia, lever = constants[INERTIA], constants[LEVER]
    carried = constants[MASS] * lever * lever
    speed = (p - inertia * vertical[2]) / (inertia + carried * x * x)
    torque = carried * x * speed * speed - constants[MASS] * vertical[0] * lever * x
    if constants[VISCOUS] != 0.0:
        torque -= constants[VISCOUS] * (speed + vertical[2] - vertical[4])
    return speed, torque


@njit(cache=True, nogil=True)
def vertical_at(time: float, sea: FloatArray, constants: FloatArray) -> FloatArray:
    """Return g_eff, beta, beta', roll, roll' at a time, shape (5,)."""
    out = np.zeros(5)
    out[0] = constants[GRAVITY]
    if sea.shape[1]:
        r0, r1, r2, r3 = roll_rates(time, sea)
        out[0], out[1], out[2] = vertical_of(r0, r1, r2, r3, constants)
        out[3], out[4] = r0, r1
    return out


@njit(cache=True, nogil=True)
def wheel_angle(time: float, state: FloatArray, constants: FloatArray, sea: FloatArray) -> float:
    """Return theta = x + beta - roll of the weight-driven machine [rad]."""
    r0, r1, r2, _ = roll_rates(time, sea)
    _, beta, _ = vertical_of(r0, r1, r2, 0.0, constants)
    return float(state[0]) + beta - r0


@njit(cache=True, nogil=True)
def impulse(time: float, state: FloatArray, constants: FloatArray, sea: FloatArray) -> float:
    """Return the gain of p from the impulse that meets this state [kg m2/s]."""
    vertical = vertical_at(time, sea, constants)
    x = state[0]
    mass = constants[INERTIA] + constants[MASS] * (constants[LEVER] * x) ** 2
    speed = (state[1] - constants[INERTIA] * vertical[2]) / mass + vertical[2] - vertical[4]
    faster = math.sqrt(speed * speed + 2.0 * constants[ENERGY] / mass)
    return float(mass * (math.copysign(faster, speed) - speed))


@njit(cache=True, nogil=True)
def gauss_step(
    state: FloatArray,
    time: float,
    step: float,
    nodes: FloatArray,
    ratio: FloatArray,
    weights: FloatArray,
    constants: FloatArray,
    sea: FloatArray,
) -> FloatArray:
    """Return the gain of (x, p) in one Gauss–Legendre step, iterated until it no longer changes.

    Args:
        state: (x, p) at `time`.
        time: from time zero of `sea` [s].
        step: [s].
        nodes, ratio, weights: c (s,), a_ij/b_j (s, s) and b (s,).
        constants, sea: of the problem.
    """
    s = len(nodes)
    vertical = np.empty((s, 5))
    gains = np.empty((s, 2))
    for i in range(s):
        vertical[i] = vertical_at(time + nodes[i] * step, sea, constants)
        first = slope(state[0], state[1], vertical[i], constants)
        gains[i, 0] = step * weights[i] * first[0]
        gains[i, 1] = step * weights[i] * first[1]
    last, stalls = np.inf, 0
    for _ in range(60):
        new = np.empty((s, 2))
        change = 0.0
        for i in range(s):
            x = p = 0.0
            for j in range(s):
                x += ratio[i, j] * gains[j, 0]
                p += ratio[i, j] * gains[j, 1]
            rates = slope(state[0] + x, state[1] + p, vertical[i], constants)
            new[i, 0] = step * weights[i] * rates[0]
            new[i, 1] = step * weights[i] * rates[1]
            change += abs(new[i, 0] - gains[i, 0])
            change += abs(new[i, 1] - gains[i, 1]) / constants[INERTIA]
        gains = new
        # ending the iteration above rounding would make the amplitude drift
        stalls += 1 if change >= last and change < 1e-12 else 0
        if stalls == 2:
            break
        last = change
    gain = np.zeros(2)
    for i in range(s):
        gain += gains[i]
    return gain


@njit(cache=True, nogil=True)
def _add(state: FloatArray, lost: FloatArray, gain: FloatArray) -> None:
    """Add with compensation of rounding (Kahan)."""
    for i in range(2):
        part = gain[i] + lost[i]
        total = state[i] + part
        lost[i] = part - (total - state[i])
        state[i] = total


@njit(cache=True, nogil=True)
def gauss_advance(
    state: FloatArray,
    lost: FloatArray,
    side: float,
    duration: float,
    steps: int,
    nodes: FloatArray,
    ratio: FloatArray,
    weights: FloatArray,
    constants: FloatArray,
    sea: FloatArray,
) -> float:
    """Advance (x, p) in place over a stretch from time zero of `sea`; return the side of theta.

    A step in which theta changes sign is shortened, by Newton's method on its length, to end
    there; the impulse follows.

    Args:
        state: (x, p).
        lost: rounding errors carried over, shape (2,).
        side: sign of theta at the start.
        duration: of the stretch [s], in `steps` of equal length.
        nodes, ratio, weights, constants, sea: as of `gauss_step`.
    """
    time = 0.0
    for k in range(1, steps + 1):
        goal = duration * k / steps
        while time < goal:
            step = goal - time
            gain = gauss_step(state, time, step, nodes, ratio, weights, constants, sea)
            if (
                constants[ENERGY] == 0.0
                or wheel_angle(goal, state + gain, constants, sea) * side > 0.0
            ):
                _add(state, lost, gain)
                time = goal
                continue
            for _ in range(12):
                there = state + gain
                angle = wheel_angle(time + step, there, constants, sea)
                vertical = vertical_at(time + step, sea, constants)
                speed, _ = slope(there[0], there[1], vertical, constants)
                change = angle / (speed + vertical[2] - vertical[4])
                step -= change
                gain = gauss_step(state, time, step, nodes, ratio, weights, constants, sea)
                if abs(change) < 1e-10:  # the next correction would be some 1e-20
                    break
            _add(state, lost, gain)
            time += step
            _add(state, lost, np.array([0.0, impulse(time, state, constants, sea)]))
            side = -side
    return side
