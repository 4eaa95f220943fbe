"""The equations of the suspended case (C in axle.md), once for all peers, and in numba.

`bends` is arithmetic alone, so that it takes floats and heyoka's expressions alike.
`numbers` is (e, c, k, g); the state is (theta, phi, theta', phi').
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from tauto_core.samples import FloatArray

STATES = 4


def bends(numbers: Any, rates: Any, normal: Any, delta: Any) -> tuple[Any, Any]:
    """Return theta'' and phi''.

    Args:
        numbers: e, c, k, g.
        rates: theta', phi'.
        normal: sin and cos of theta.
        delta: sin and cos of delta = phi - theta.
    """
    e, c, k, g = numbers
    theta_square, phi_square = rates[0] * rates[0], rates[1] * rates[1]
    sine, cosine = delta
    wide = c * sine
    pressed = g * normal[1] + e * theta_square + c * phi_square * cosine
    phi_bend = -wide * pressed / (k * k + wide * wide)
    theta_bend = (c * (phi_square * sine - phi_bend * cosine) - g * normal[0]) / e
    return theta_bend, phi_bend


compiled_bends = njit(cache=True, nogil=True)(bends)


@njit(cache=True, nogil=True)
def fill_slope(state: FloatArray, numbers: Any, out: FloatArray) -> None:
    """Fill in the derivative of the state, shape (4,)."""
    theta, delta = state[0], state[1] - state[0]
    out[0], out[1] = state[2], state[3]
    out[2], out[3] = compiled_bends(
        numbers,
        (state[2], state[3]),
        (math.sin(theta), math.cos(theta)),
        (math.sin(delta), math.cos(delta)),
    )


@njit(cache=True, nogil=True)
def case_gauss_advance(
    state: FloatArray,
    lost: FloatArray,
    step: float,
    steps: int,
    ratio: FloatArray,
    weights: FloatArray,
    numbers: Any,
) -> None:
    """Advance the state in place by Gauss–Legendre steps, each iterated until it is constant.

    Args:
        state: shape (4,).
        lost: rounding errors carried over, shape (4,).
        step: [s], taken `steps` times.
        ratio, weights: a_ij/b_j (s, s) and b (s,).
        numbers: of the case.
    """
    s = len(weights)
    gains, new = np.zeros((s, STATES)), np.empty((s, STATES))
    there, rates = np.empty(STATES), np.empty(STATES)
    for _ in range(steps):
        last, stalls = np.inf, 0
        for _ in range(60):
            change = 0.0
            for i in range(s):
                for m in range(STATES):
                    total = 0.0
                    for j in range(s):
                        total += ratio[i, j] * gains[j, m]
                    there[m] = state[m] + total
                fill_slope(there, numbers, rates)
                for m in range(STATES):
                    new[i, m] = step * weights[i] * rates[m]
                    change += abs(new[i, m] - gains[i, m])
            gains, new = new, gains
            # as for the wheel: iterated down to rounding
            stalls += 1 if change >= last and change < 1e-10 else 0
            if stalls == 2:
                break
            last = change
        for m in range(STATES):
            part = lost[m]
            for i in range(s):
                part += gains[i, m]
            whole = state[m] + part
            lost[m] = part - (whole - state[m])
            state[m] = whole
