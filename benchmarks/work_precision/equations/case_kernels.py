"""The equations of the suspended case (C in axle.md), once for all peers, and in numba.

`bends` is arithmetic alone, so that it takes floats and heyoka's expressions alike.
`numbers` is (e, c, k, g); the state is (theta, phi, theta', phi').
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from tauto_core.samples import FloatArray


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
        (numbers[0], numbers[1], numbers[2], numbers[3]),
        (state[2], state[3]),
        (math.sin(theta), math.cos(theta)),
        (math.sin(delta), math.cos(delta)),
    )
