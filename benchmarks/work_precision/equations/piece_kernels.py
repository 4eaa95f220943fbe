"""The sea as polynomials over equal pieces of time, and the loop over them, compiled by numba.

Over a piece a channel is interpolated at Chebyshev points of the first kind. The result is
z_j = f^(j) (L/2)^j/j! at the piece's start, j < n. This is the state of the chain
z_j' = (2/L)(j + 1) z_j+1, whose first member is the channel over the whole piece, of length L.

The derivatives follow from the Chebyshev coefficients c_k by T_k^(j)(1) = prod_i<j (k^2 - i^2)/
(2i + 1) and T_k(-x) = (-1)^k T_k(x). Both steps are done one after the other, since their product
would cancel most of its digits.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from benchmarks.work_precision.equations.wheel_kernels import vertical_of
from tauto_core.samples import FloatArray

BLOCK = 64
"""Number of pieces fitted together; phases are computed anew at the start of each such block."""
GAMMA_RATE, GRAVITY, LEAN = range(3)
"""Channels of the weight-driven machine: gamma' [rad/s], g_eff [m/s2], gamma - rho [rad]."""
_NEWTON_STEPS = 30


def chebyshev_points(n: int) -> FloatArray:
    """Return the n Chebyshev points of the first kind in [-1, 1]."""
    points: FloatArray = np.cos(np.pi * (np.arange(n) + 0.5) / n)
    return points


def to_chebyshev(n: int) -> FloatArray:
    """Return the matrix from values at the points to Chebyshev coefficients, shape (n, n)."""
    k, i = np.meshgrid(np.arange(n), np.arange(n), indexing='ij')
    matrix: FloatArray = 2.0 / n * np.cos(np.pi * k * (i + 0.5) / n)
    matrix[0] *= 0.5
    return matrix


def to_chain(n: int) -> FloatArray:
    """Return the matrix from Chebyshev coefficients to f^(j)(-1)/j!, shape (n, n)."""
    matrix = np.zeros((n, n))
    for k in range(n):
        value = 1
        for j in range(k + 1):
            matrix[j, k] = (-1) ** (k + j) * value
            # exact, since Chebyshev polynomials in powers of 1 - x have integer coefficients
            value = value * (k * k - j * j) // ((2 * j + 1) * (j + 1))
    return matrix


def _make_call(
    _context: Any, _address: Any, _state: Any, _par: Any, _time: Any, _step: Any, _tc: Any
) -> Any:
    pointer = ir.IntType(8).as_pointer()

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(ir.VoidType(), [pointer] * 5).as_pointer()
        function = builder.inttoptr(arguments[0], kind)
        builder.call(function, [builder.inttoptr(each, pointer) for each in arguments[1:]])
        return context.get_dummy_value()

    return types.void(*[types.intp] * 6), generate


call_step: Any = intrinsic(_make_call)
"""Calls heyoka's compiled step at an address with pointers to its five arguments."""


@njit(cache=True, nogil=True)
def fill_phasors(sea: FloatArray, time: float, turns: FloatArray, phasors: FloatArray) -> None:
    """Fill in a block's phasors, cosines and then sines.

    Args:
        sea: rows amplitude, omega, phase, shape (3, n).
        time: of the first piece from time zero of `sea` [s].
        turns: cos and sin of omega times each piece's offset, shape (BLOCK, 2, n).
        phasors: output, shape (pieces, 2 n).
    """
    n = sea.shape[1]
    c, s = np.empty(n), np.empty(n)
    for j in range(n):
        angle = sea[1, j] * time + sea[2, j]
        c[j], s[j] = math.cos(angle), math.sin(angle)
    for p in range(len(phasors)):
        for j in range(n):
            phasors[p, j] = c[j] * turns[p, 0, j] - s[j] * turns[p, 1, j]
            phasors[p, n + j] = s[j] * turns[p, 0, j] + c[j] * turns[p, 1, j]


@njit(cache=True, nogil=True)
def fill_chains(
    rolls: FloatArray,
    constants: FloatArray,
    scale: float,
    coefficients: FloatArray,
    chain: FloatArray,
    chains: FloatArray,
) -> None:
    """Fill in the chains of the weight-driven machine at the start of each piece.

    Args:
        rolls: roll and three derivatives at the points, shape (pieces, 4 n).
        constants: of the problem.
        scale: of the chains.
        coefficients: matrix from values to Chebyshev coefficients, shape (n, n).
        chain: matrix from these to the chain, shape (n, n).
        chains: output, shape (pieces, channels n), channels 2 or 3.
    """
    n = len(chain)
    channels = chains.shape[1] // n
    values = np.empty((3, n))
    row = np.empty(n)
    for p in range(len(chains)):
        for i in range(n):
            r0, r1, r2, r3 = rolls[p, 4 * i : 4 * i + 4]
            gravity, beta, rate = vertical_of(r0, r1, r2, r3, constants)
            values[GAMMA_RATE, i], values[GRAVITY, i] = rate, gravity
            values[LEAN, i] = beta - r0
        for m in range(channels):
            row[:] = 0.0
            for i in range(n):
                value = scale * values[m, i]
                for k in range(n):
                    row[k] += coefficients[i, k] * value
            for j in range(n):
                total = 0.0
                for k in range(n - 1, j - 1, -1):
                    total += chain[j, k] * row[k]
                chains[p, m * n + j] = total


@njit(cache=True, nogil=True)
def advance_pieces(
    step: int,
    state: FloatArray,
    chains: FloatArray,
    length: float,
    duration: float,
    side: float,
    tc: FloatArray,
    kick: tuple[float, float, float, float],
) -> float:
    """Advance the state in place over pieces; return the side of theta.

    With impulses, a step's Taylor polynomials give the instant at which theta passes zero, by
    Newton's method between the ends of the step, and the state there.

    Args:
        step: address of heyoka's step.
        state: x and u, or psi and psi', and then the chains.
        chains: at the start of each piece, shape (pieces, chains).
        length: of a piece [s].
        duration: no further than this [s].
        side: sign of theta; 0 without impulses.
        tc: a step's Taylor coefficients, shape (states, order + 1).
        kick: eps, 2 E/I, scale of the chains, 2/L.
    """
    nothing, time, h = np.zeros(1), np.zeros(1), np.zeros(1)
    asked = tc.ctypes.data if side != 0.0 else 0
    lean = 2 + LEAN * ((len(state) - 2) // 3)
    for p in range(len(chains)):
        state[2:] = chains[p]
        goal = min(length, duration - p * length)
        time[0] = 0.0
        while time[0] < goal:
            left = goal - time[0]
            h[0] = left
            call_step(
                step,
                state.ctypes.data,
                nothing.ctypes.data,
                time.ctypes.data,
                h.ctypes.data,
                asked,
            )
            if side == 0.0 or (state[0] + state[lean] / kick[2]) * side > 0.0:
                time[0] = goal if h[0] == left else time[0] + h[0]
                continue
            time[0] += _back_to_passage(state, tc, lean, h[0], kick[2])
            _give_impulse(state, lean, kick)
            side = -side
    return side


@njit(cache=True, nogil=True)
def _back_to_passage(
    state: FloatArray, tc: FloatArray, lean: int, end: float, scale: float
) -> float:
    """Put the state where theta passes zero in the last step; return the time from its start."""
    theta = tc[0] + tc[lean] / scale
    now = _root(theta, end)
    state[:] = 0.0
    # all states of a power together: sums of one state wait for each other
    for k in range(tc.shape[1] - 1, -1, -1):
        for i in range(len(state)):
            state[i] = state[i] * now + tc[i, k]
    return now


@njit(cache=True, nogil=True)
def _give_impulse(state: FloatArray, lean: int, kick: tuple[float, float, float, float]) -> None:
    """Raise the kinetic energy of the wheel in its case by E."""
    eps, twice, scale, per_half = kick
    load = 1.0 + eps * state[0] * state[0]
    lean_rate = state[lean + 1] * per_half / scale
    speed = (state[1] - state[2] / scale) / load + lean_rate
    faster = math.sqrt(speed * speed + twice / load)
    state[1] += load * (math.copysign(faster, speed) - speed)


@njit(cache=True, nogil=True)
def _root(theta: FloatArray, end: float) -> float:
    """Return the zero of a polynomial between 0 and `end`, where it changes sign."""
    low, high = 0.0, end
    rising = theta[0] < 0.0
    now = 0.5 * end
    for _ in range(_NEWTON_STEPS):
        value = rate = 0.0
        for k in range(len(theta) - 1, -1, -1):
            rate = rate * now + value
            value = value * now + theta[k]
        if (value < 0.0) == rising:
            low = now
        else:
            high = now
        next_ = now - value / rate if rate != 0.0 else low
        if not low <= next_ <= high:
            next_ = 0.5 * (low + high)
        change = abs(next_ - now)
        now = next_
        if change <= 4e-16 * end:
            break
    return now


@njit(cache=True, nogil=True)
def advance_batch(
    step: int,
    state: FloatArray,
    chains: FloatArray,
    length: float,
    duration: float,
    sides: FloatArray,
    tc: FloatArray,
    kick: tuple[float, float, float, float],
) -> None:
    """Advance the states of several ships in place over pieces, each at its own pace.

    A ship takes the polynomials of its next piece as soon as it is there, while the others are
    still on their way; those that are through wait with steps of length 0.

    Args:
        step: address of heyoka's step, of a batch.
        state: shape (states, ships), a ship's as in `advance_pieces`.
        chains: at the start of each piece, shape (pieces, chains, ships).
        length, duration, kick: as of `advance_pieces`.
        sides: sign of theta, a ship; 0 without impulses; changed in place.
        tc: a step's Taylor coefficients, shape (states, order + 1, ships).
    """
    states, ships = state.shape
    pieces = len(chains)
    nothing, now, h = np.zeros(1), np.zeros(ships), np.zeros(ships)
    at = np.zeros(ships, np.int64)
    goal = np.empty(ships)
    one = np.empty(states)
    asked = tc.ctypes.data if sides[0] != 0.0 else 0
    lean = 2 + LEAN * ((states - 2) // 3)
    state[2:] = chains[0]
    goal[:] = min(length, duration)
    under_way = ships
    while under_way:
        for lane in range(ships):
            h[lane] = goal[lane] - now[lane] if at[lane] < pieces else 0.0
        call_step(
            step,
            state.ctypes.data,
            nothing.ctypes.data,
            now.ctypes.data,
            h.ctypes.data,
            asked,
        )
        for lane in range(ships):
            if at[lane] == pieces:
                continue
            side = sides[lane]
            left = goal[lane] - now[lane]
            if side == 0.0 or (state[0, lane] + state[lean, lane] / kick[2]) * side > 0.0:
                now[lane] = goal[lane] if h[lane] == left else now[lane] + h[lane]
            else:
                now[lane] += _back_to_passage(one, tc[:, :, lane], lean, h[lane], kick[2])
                _give_impulse(one, lean, kick)
                state[:, lane] = one
                sides[lane] = -side
            if now[lane] >= goal[lane]:
                at[lane] += 1
                if at[lane] < pieces:
                    state[2:, lane] = chains[at[lane], :, lane]
                    now[lane] = 0.0
                    goal[lane] = min(length, duration - at[lane] * length)
                else:
                    under_way -= 1
