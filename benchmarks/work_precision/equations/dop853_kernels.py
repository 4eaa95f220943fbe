"""DOP853 in numba: steps, error estimate and step control of Hairer, Nørsett and Wanner (II.10).

The coefficients are SciPy's. The machine is moved either by the exact sum of waves, or by the
chains of a piece (`piece_kernels`), whose value at t is sum z_j (2 t/L)^j.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from scipy.integrate import DOP853

from benchmarks.work_precision.equations.case_kernels import fill_slope as fill_case_slope
from benchmarks.work_precision.equations.wheel_kernels import (
    ENERGY,
    FORCE,
    INERTIA,
    LEVER,
    MASS,
    VISCOUS,
    impulse,
    roll_of,
    slope,
    vertical_at,
    wheel_angle,
)
from tauto_core.samples import FloatArray

WAVES, PIECES, CASE = range(3)
"""The forcing: the sum of waves (none on land), or pieces of it; or the problem of the case."""

_A, _B, _C = (np.ascontiguousarray(each) for each in (DOP853.A, DOP853.B, DOP853.C))
_E3, _E5 = (np.ascontiguousarray(each) for each in (DOP853.E3, DOP853.E5))
_STAGES = len(_B)
_SAFETY, _LEAST, _MOST = 0.9, 0.2, 10.0
_SMALLEST_S = 1e-12


@njit(cache=True, nogil=True)
def _channel(chain: FloatArray, at: float) -> float:
    total = 0.0
    for j in range(len(chain) - 1, -1, -1):
        total = total * at + chain[j]
    return total


@njit(cache=True, nogil=True)
def _channel_rate(chain: FloatArray, at: float) -> float:
    total = 0.0
    for j in range(len(chain) - 1, 0, -1):
        total = total * at + j * chain[j]
    return total


@njit(cache=True, nogil=True)
def fill_slope(
    kind: int,
    time: float,
    state: FloatArray,
    constants: FloatArray,
    sea: FloatArray,
    per_half: float,
    out: FloatArray,
) -> None:
    """Fill in the derivative of the state.

    Args:
        kind: `WAVES`, `PIECES` or `CASE`.
        time: from time zero of `sea`, or from the piece's start [s].
        state: as of `wheel_kernels`, or (theta, phi, theta', phi').
        constants: of the problem, or e, c, k, g of the case.
        sea: amplitude, omega and phase, shape (3, n), or chains, a row a channel.
        per_half: 2/L of a piece [1/s].
        out: output, of the state's shape.
    """
    if kind == CASE:
        numbers = (constants[0], constants[1], constants[2], constants[3])
        fill_case_slope(state, numbers, out)
    elif constants[MASS] == 0.0:
        roll = roll_of(time, sea) if kind == WAVES else _channel(sea[0], time * per_half)
        out[0] = state[1]
        out[1] = constants[FORCE] * constants[LEVER] / constants[INERTIA] * (roll - state[0])
    elif kind == WAVES:
        felt = vertical_at(time, sea, constants)
        out[0], out[1] = slope(state[0], state[1], felt, constants)
    else:
        at, felt = time * per_half, np.zeros(5)
        felt[2], felt[0] = _channel(sea[0], at), _channel(sea[1], at)
        if constants[VISCOUS] != 0.0:
            # beta' - rho' is all that drag feels of both
            felt[4] = felt[2] - per_half * _channel_rate(sea[2], at)
        out[0], out[1] = slope(state[0], state[1], felt, constants)


@njit(cache=True, nogil=True)
def _theta(
    kind: int,
    time: float,
    state: FloatArray,
    constants: FloatArray,
    sea: FloatArray,
    per_half: float,
) -> float:
    if kind == WAVES:
        return wheel_angle(time, state, constants, sea)
    return float(state[0]) + _channel(sea[2], time * per_half)


@njit(cache=True, nogil=True)
def _gain(
    kind: int,
    time: float,
    state: FloatArray,
    constants: FloatArray,
    sea: FloatArray,
    per_half: float,
) -> float:
    """Return the gain of p from the impulse that meets this state [kg m2/s]."""
    if kind == WAVES:
        return impulse(time, state, constants, sea)
    at = time * per_half
    x, lean_rate = state[0], per_half * _channel_rate(sea[2], at)
    mass = constants[INERTIA] + constants[MASS] * (constants[LEVER] * x) ** 2
    speed = (state[1] - constants[INERTIA] * _channel(sea[0], at)) / mass + lean_rate
    faster = math.sqrt(speed * speed + 2.0 * constants[ENERGY] / mass)
    return float(mass * (math.copysign(faster, speed) - speed))


@njit(cache=True, nogil=True)
def _try_step(
    kind: int,
    time: float,
    h: float,
    state: FloatArray,
    slopes: FloatArray,
    goal: FloatArray,
    constants: FloatArray,
    sea: FloatArray,
    per_half: float,
) -> None:
    """Fill in the stages after the first, the state at the step's end and its slope."""
    for i in range(1, _STAGES):
        for m in range(len(state)):
            total = 0.0
            for j in range(i):
                total += _A[i, j] * slopes[j, m]
            goal[m] = state[m] + h * total
        fill_slope(kind, time + _C[i] * h, goal, constants, sea, per_half, slopes[i])
    for m in range(len(state)):
        total = 0.0
        for j in range(_STAGES):
            total += _B[j] * slopes[j, m]
        goal[m] = state[m] + h * total
    fill_slope(kind, time + h, goal, constants, sea, per_half, slopes[_STAGES])


@njit(cache=True, nogil=True)
def _error(
    h: float,
    state: FloatArray,
    goal: FloatArray,
    slopes: FloatArray,
    rtol: float,
    atol: FloatArray,
) -> float:
    fifth = third = 0.0
    for m in range(len(state)):
        size = atol[m] + rtol * max(abs(state[m]), abs(goal[m]))
        five = three = 0.0
        for j in range(_STAGES + 1):
            five += _E5[j] * slopes[j, m]
            three += _E3[j] * slopes[j, m]
        fifth += (five / size) ** 2
        third += (three / size) ** 2
    if fifth == 0.0:
        return 0.0
    return float(h * fifth / math.sqrt((fifth + 0.01 * third) * len(state)))


@njit(cache=True, nogil=True)
def advance_dop853(
    kind: int,
    state: FloatArray,
    begin: float,
    end: float,
    h: float,
    rtol: float,
    atol: FloatArray,
    constants: FloatArray,
    sea: FloatArray,
    per_half: float,
    side: float,
) -> tuple[float, float]:
    """Advance the state in place; return the next step to try and the side of theta.

    A step in which theta changes sign is shortened by the secant rule to end there; the impulse
    follows.

    Args:
        kind, state, constants, sea, per_half: as of `fill_slope`.
        begin, end: [s].
        h: step to try [s].
        rtol, atol: relative and absolute tolerance, the latter of the state's shape.
        side: sign of theta; 0 without impulses.
    """
    slopes = np.empty((_STAGES + 1, len(state)))
    goal, time = np.empty(len(state)), begin
    fill_slope(kind, time, state, constants, sea, per_half, slopes[0])
    while time < end:
        size = min(h, end - time)
        _try_step(kind, time, size, state, slopes, goal, constants, sea, per_half)
        error = _error(size, state, goal, slopes, rtol, atol)
        factor = _MOST if error == 0.0 else min(_MOST, max(_LEAST, _SAFETY * error**-0.125))
        if error >= 1.0 and size > _SMALLEST_S:
            h = size * min(1.0, factor)
            continue
        if size == h or factor < 1.0:
            h = size * factor
        met = side != 0.0 and (
            _theta(kind, time + size, goal, constants, sea, per_half) * side <= 0.0
        )
        if met:
            size = _meet(kind, time, size, state, slopes, goal, constants, sea, per_half)
        state[:] = goal
        time = end if not met and size == end - time else time + size
        if met:
            state[1] += _gain(kind, time, state, constants, sea, per_half)
            side = -side
            fill_slope(kind, time, state, constants, sea, per_half, slopes[0])
        else:
            slopes[0] = slopes[_STAGES]
    return h, side


@njit(cache=True, nogil=True)
def _meet(
    kind: int,
    time: float,
    size: float,
    state: FloatArray,
    slopes: FloatArray,
    goal: FloatArray,
    constants: FloatArray,
    sea: FloatArray,
    per_half: float,
) -> float:
    """Return the length of the step at whose end theta is zero, with the state there in `goal`."""
    before, at_before = 0.0, _theta(kind, time, state, constants, sea, per_half)
    now = size
    for _ in range(20):
        at_now = _theta(kind, time + now, goal, constants, sea, per_half)
        if at_now == at_before:
            break
        change = at_now * (now - before) / (at_now - at_before)
        before, at_before = now, at_now
        now -= change
        _try_step(kind, time, now, state, slopes, goal, constants, sea, per_half)
        if abs(change) < 1e-10 * size:  # the next correction would be below rounding
            break
    return now
