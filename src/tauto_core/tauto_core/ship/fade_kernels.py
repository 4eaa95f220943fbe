"""Compiled fading of one motion into another; import on first use only.

Each sample is computed by itself and in a fixed order: the bits do not depend on the batch.
"""

import math
from typing import Any

from tauto_core.kernels import entry, inlined
from tauto_core.motion.lanes import SIZE, splat, store, with_lane
from tauto_core.motion.linear import short_cosine_sine
from tauto_core.samples import FloatArray
from tauto_core.ship.source_kernels import eight

ROOT_HALF = math.sqrt(0.5)


@entry
def fade(
    first: int,
    step_ns: int,
    begin_ns: int,
    length_ns: int,
    old: tuple[FloatArray, FloatArray, FloatArray],
    new: tuple[FloatArray, FloatArray, FloatArray],
    value: FloatArray | None,
    rate: FloatArray | None,
    acceleration: FloatArray | None,
) -> None:
    """Fill x = cos(θ) a + sin(θ) b and its derivatives, θ = ½π s(u) (equations: `fading`).

    With p = cos(θ) a + sin(θ) b and q = cos(θ) b − sin(θ) a, and likewise p′, q′, p″ of the
    derivatives of a and b,

        x = p,    ẋ = p′ + θ̇ q,    ẍ = p″ + 2 θ̇ q′ + θ̈ q − θ̇² p.

    Sine and cosine are those of θ − π/4, which the series takes over its whole range. Outputs
    that are None are not in the compiled code, nor are derivatives that no output needs.

    Args:
        first: index of the first sample from the start of the scene, >= 0.
        step_ns: time between samples.
        begin_ns: time at which the fading begins, from the start of the scene.
        length_ns: length of the fading, > 0.
        old: a and its first and second derivative [1/s, 1/s2], shape (n,).
        new: b, likewise.
        value: output x, shape (n',), n' >= n a multiple of eight, or None.
        rate: output ẋ, likewise.
        acceleration: output ẍ, likewise.
    """
    per_s, length = 1e9 / length_ns, float(length_ns)
    for k in range(-(-len(old[0]) // SIZE)):
        u = _since((first + SIZE * k) * step_ns - begin_ns, step_ns) / length
        v = 1.0 - u
        s = (u * u) * (u * u) * (35.0 + u * (-84.0 + u * (70.0 - 20.0 * u)))
        turning = (0.5 * math.pi * 140.0 * per_s) * ((u * v) * (u * v) * (u * v))
        cosine, sine = short_cosine_sine((0.5 * math.pi) * (s - 0.5))
        c, d = ROOT_HALF * (cosine - sine), ROOT_HALF * (cosine + sine)
        a, b = eight(old[0], k), eight(new[0], k)
        p, q = c * a + d * b, c * b - d * a
        if value is not None:
            store(value, k, p)
        if rate is not None or acceleration is not None:
            a, b = eight(old[1], k), eight(new[1], k)
        if rate is not None:
            store(rate, k, (c * a + d * b) + turning * q)
        if acceleration is not None:
            bending = (0.5 * math.pi * 420.0 * per_s * per_s) * ((u * v) * (u * v) * (v - u))
            across = c * b - d * a
            along = c * eight(old[2], k) + d * eight(new[2], k)
            turned = bending * q - turning * turning * p
            store(acceleration, k, (along + 2.0 * turning * across) + turned)


@inlined
def _since(time_ns: int, step_ns: int) -> Any:
    """Return eight times, a step apart, as floats: each is exact, or rounded by itself."""
    times = splat(0.0)
    for r in range(SIZE):
        times = with_lane(times, r, float(time_ns + r * step_ns))
    return times
