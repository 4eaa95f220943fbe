"""Cosine and sine of angles kept as whole numbers of 2⁻⁶⁴ turns: exact, however many turns.

Each is computed by itself and in a fixed order: the bits do not depend on the batch.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.lanes import SIZE, load, store
from tauto_core.samples import FloatArray

RADIANS_PER_UNIT = 2.0 * math.pi / 2.0**64
INVERSE_FACTORIALS = tuple((-1) ** (k // 2) / math.factorial(k) for k in range(18))
"""Coefficients with their signs in the series of sine (odd) and cosine (even)."""

HALF, LOW_HALF = np.uint64(32), np.uint64(2**32 - 1)


@compiled
def turns_at(time_ns: int, turns: np.uint64, fine: np.uint64) -> np.uint64:
    """Return the angle of a uniform rotation, two units off at most [2⁻⁶⁴ turns].

    Args:
        time_ns: time since the angle was zero [ns], ≥ 0.
        turns: turns a nanosecond: the first 64 binary digits.
        fine: the next 64.
    """
    time = np.uint64(time_ns)
    a, b, c, d = time >> HALF, time & LOW_HALF, fine >> HALF, fine & LOW_HALF
    # the upper half of time · fine is what the finer digits carry over
    return time * turns + (a * c + (a * d >> HALF) + (b * c >> HALF))


@compiled
def cosine_sine(turns: NDArray[np.uint64], cosine: FloatArray, sine: FloatArray) -> None:
    """Fill cosine and sine of angles in 2⁻⁶⁴ turns, reduced exactly to half a right angle."""
    eighth, bits = np.uint64(2**61), np.uint64(62)
    rest = np.empty(len(turns))
    for i in range(len(turns)):
        quarters = (turns[i] + eighth) >> bits
        rest[i] = np.int64(turns[i] - (quarters << bits)) * RADIANS_PER_UNIT
    rows = len(turns) // SIZE
    for i in range(rows):
        c, s = short_cosine_sine(load(rest, i))
        store(cosine, i, c)
        store(sine, i, s)
    for i in range(SIZE * rows, len(turns)):
        cosine[i], sine[i] = short_cosine_sine(rest[i])
    for i in range(len(turns)):
        quarters = np.int64((turns[i] + eighth) >> bits) & 3
        c, s = cosine[i], sine[i]
        # chosen, not branched to: which quarter it is cannot be foreseen
        across = (quarters & 1) != 0
        back = 1.0 - (quarters & 2)
        cosine[i], sine[i] = back * (-s if across else c), back * (c if across else s)


@inlined
def short_cosine_sine(x: Any) -> Any:
    """Return cosine and sine of an angle, or lanes of them, up to half a right angle.

    There the Taylor series to x^16 and x^17 are exact to rounding (the next terms are below 3e-18
    and 2e-19); they can be computed for several angles at once, unlike the library's functions.
    """
    f, z = INVERSE_FACTORIALS, x * x
    odd, even = f[17] * z + f[15], f[16] * z + f[14]
    odd, even = odd * z + f[13], even * z + f[12]
    odd, even = odd * z + f[11], even * z + f[10]
    odd, even = odd * z + f[9], even * z + f[8]
    odd, even = odd * z + f[7], even * z + f[6]
    odd, even = odd * z + f[5], even * z + f[4]
    odd, even = odd * z + f[3], even * z + f[2]
    return 1.0 + z * even, x + x * (z * odd)
