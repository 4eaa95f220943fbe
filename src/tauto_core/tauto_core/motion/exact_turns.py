"""Cosine and sine of angles that are whole numbers of 2⁻⁶⁴ turns.

Whole turns fall off where the 64 bits overflow, so that an angle is as exact after a century as at
the start. Every angle is computed in the same order of operations, alone or in lanes: the bits do
not depend on how many are computed together.
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
SIGNED_INVERSE_FACTORIALS = tuple((-1) ** (k // 2) / math.factorial(k) for k in range(18))
"""Coefficients of x^k in the Taylor series of cosine, k even, and of sine, k odd."""

HALF, LOW_HALF = np.uint64(32), np.uint64(2**32 - 1)


@compiled
def turns_at(time_ns: int, high: np.uint64, low: np.uint64) -> np.uint64:
    """Return the angle of a uniform rotation, less than three units too small [2⁻⁶⁴ turns].

    Args:
        time_ns: time since the angle was zero [ns], ≥ 0.
        high: turns per nanosecond, the first 64 binary digits of the fraction.
        low: the next 64.
    """
    time = np.uint64(time_ns)
    a, b, c, d = time >> HALF, time & LOW_HALF, low >> HALF, low & LOW_HALF
    # time · high and, from halves of 32 bits, the upper 64 bits of time · low; each of the three
    # products that are cut off there, b · d among them, may lose a unit
    return time * high + (a * c + (a * d >> HALF) + (b * c >> HALF))


@compiled
def cosine_sine(turns: NDArray[np.uint64], cosine: FloatArray, sine: FloatArray) -> None:
    """Fill cosine and sine of angles [2⁻⁶⁴ turns], which are reduced exactly to ±π/4.

    An angle is a number of quarter turns and a rest of at most an eighth.
    """
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
        # a choice of numbers, not a branch, since no processor predicts which quarter it is
        odd = (quarters & 1) != 0
        sign = 1.0 - (quarters & 2)
        cosine[i], sine[i] = sign * (-s if odd else c), sign * (c if odd else s)


@inlined
def short_cosine_sine(x: Any) -> Any:
    """Return cosine and sine of an angle x, or lanes of them, |x| ≤ π/4 [rad].

    There the Taylor series up to x^16 and x^17 are exact to rounding, since the next terms are
    below 3e-18 and 2e-19. Unlike the library's functions they serve several angles at once.
    """
    f, z = SIGNED_INVERSE_FACTORIALS, x * x
    odd, even = f[17] * z + f[15], f[16] * z + f[14]
    odd, even = odd * z + f[13], even * z + f[12]
    odd, even = odd * z + f[11], even * z + f[10]
    odd, even = odd * z + f[9], even * z + f[8]
    odd, even = odd * z + f[7], even * z + f[6]
    odd, even = odd * z + f[5], even * z + f[4]
    odd, even = odd * z + f[3], even * z + f[2]
    return 1.0 + z * even, x + x * (z * odd)
