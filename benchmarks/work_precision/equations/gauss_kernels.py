"""Gauss–Legendre on the equations of the wheel and of the case, compiled by numba.

The state is (x, p) of the weight-driven machine (`wheel_kernels`), or that of the case, which is
twice as long and feels no sea (`case_kernels`). A rule is its nodes c, shape (s,), a_ij/b_j,
shape (s, s), and weights b, shape (s,).
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numba import njit

from benchmarks.work_precision.equations.case_kernels import fill_slope
from benchmarks.work_precision.equations.wheel_kernels import (
    INERTIA,
    impulse,
    slope,
    vertical_at,
    wheel_angle,
)
from tauto_core.samples import FloatArray

Rule: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]


@njit(cache=True, nogil=True)
def _fill(state: FloatArray, felt: FloatArray, constants: FloatArray, out: FloatArray) -> None:
    if len(state) == 2:
        out[0], out[1] = slope(state[0], state[1], felt, constants)
    else:
        fill_slope(state, constants, out)


@njit(cache=True, nogil=True)
def gauss_step(
    state: FloatArray,
    time: float,
    step: float,
    rule: Rule,
    constants: FloatArray,
    sea: FloatArray,
) -> FloatArray:
    """Return the gain of the state in one step, iterated until it no longer changes.

    Args:
        state: at `time`.
        time: from time zero of `sea` [s].
        step: [s].
        rule: of Gauss–Legendre.
        constants: of the problem.
        sea: of the problem.
    """
    nodes, ratio, weights = rule
    s, n = len(nodes), len(state)
    felt, unit = np.zeros((s, 5)), np.ones(n)
    if n == 2:
        unit[1] = constants[INERTIA]
        for i in range(s):
            felt[i] = vertical_at(time + nodes[i] * step, sea, constants)
    gains, new = np.empty((s, n)), np.empty((s, n))
    there, rates = np.empty(n), np.empty(n)
    for i in range(s):
        _fill(state, felt[i], constants, rates)
        gains[i] = step * weights[i] * rates
    last, stalls = np.inf, 0
    for _ in range(60):
        change = 0.0
        for i in range(s):
            for m in range(n):
                total = 0.0
                for j in range(s):
                    total += ratio[i, j] * gains[j, m]
                there[m] = state[m] + total
            _fill(there, felt[i], constants, rates)
            for m in range(n):
                new[i, m] = step * weights[i] * rates[m]
                change += abs(new[i, m] - gains[i, m]) / unit[m]
        gains, new = new, gains
        # ending the iteration above rounding would make the amplitude drift
        stalls += 1 if change >= last and change < (1e-12 if n == 2 else 1e-10) else 0
        if stalls == 2:
            break
        last = change
    return gains.sum(axis=0)


@njit(cache=True, nogil=True)
def _add(state: FloatArray, lost: FloatArray, gain: FloatArray) -> None:
    """Add with compensation of rounding (Kahan)."""
    for i in range(len(state)):
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
    rule: Rule,
    constants: FloatArray,
    sea: FloatArray,
) -> float:
    """Advance the state in place over a stretch from time zero of `sea`; return the side of theta.

    A step in which theta changes sign is shortened, by Newton's method on its length, to end
    there; the impulse follows.

    Args:
        state: at the start.
        lost: what rounding kept back, of the state's shape.
        side: sign of theta at the start; 0 without impulses.
        duration: of the stretch [s].
        steps: of equal length.
        rule: of Gauss–Legendre.
        constants: of the problem.
        sea: of the problem.
    """
    time = 0.0
    for k in range(1, steps + 1):
        goal = duration * k / steps
        while time < goal:
            step = goal - time
            gain = gauss_step(state, time, step, rule, constants, sea)
            if side == 0.0 or wheel_angle(goal, state + gain, constants, sea) * side > 0.0:
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
                gain = gauss_step(state, time, step, rule, constants, sea)
                if abs(change) < 1e-10:  # the next correction would be some 1e-20
                    break
            _add(state, lost, gain)
            time += step
            _add(state, lost, np.array([0.0, impulse(time, state, constants, sea)]))
            side = -side
    return side
