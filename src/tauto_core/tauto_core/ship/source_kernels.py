"""Compiled sums of harmonics and readings of an IMU; import on first use only.

Each sample is computed by itself and in a fixed order: the bits do not depend on the batch.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import entry, inlined
from tauto_core.motion.lanes import SIZE, fma, lane, largest, load, splat, store, with_lane
from tauto_core.motion.linear import cosine_sine, short_cosine_sine
from tauto_core.samples import FloatArray

BLOCKS_TOGETHER = 8
"""Blocks for which a part of the table is used while it is in the processor's first cache."""


@entry
def sum_blocks(
    first_block: int,
    mean: float,
    phase: NDArray[np.uint64],
    increment: NDArray[np.uint64],
    amplitude: FloatArray,
    omega: FloatArray,
    table: FloatArray,
    value: FloatArray | None,
    rate: FloatArray | None,
    acceleration: FloatArray | None,
) -> None:
    """Return sum a cos(phi) and its first and second derivative over whole blocks.

    phi = phi_b +- theta_j: phi_b at the middle of block b, exact in 2^-64 turns; theta_j from
    there to the j-th sample on either side, from a table. cos theta adds to both alike, sin theta
    with both signs. Outputs that are None are not in the compiled code.

    Args:
        first_block: index of the first block, counted from the start of the scene, >= 0.
        mean: added to the value.
        phase: phase at the middle of the first block of the scene [2^-64 turns], shape (n,).
        increment: advance of the phase in a block [2^-64 turns], shape (n,).
        amplitude: a, shape (n,).
        omega: angular frequency [rad/s], shape (n,).
        table: table of eight j after another, of each component, cos(theta_j), then sin(theta_j);
            shape (block n/4, 8).
        value: output, shape (blocks, block), or None.
        rate: output, likewise.
        acceleration: output, likewise.
    """
    n = len(phase)
    turns, sine, cosine = np.empty(n, np.uint64), np.empty(n), np.empty(n)
    some = value if value is not None else acceleration
    blocks, strips = some.shape[0], some.shape[1] // SIZE  # type: ignore[union-attr]
    factors = np.empty((BLOCKS_TOGETHER, n, 6))
    for begin in range(0, blocks, BLOCKS_TOGETHER):
        count = min(BLOCKS_TOGETHER, blocks - begin)
        for block in range(count):
            for i in range(n):
                turns[i] = phase[i] + np.uint64(first_block + begin + block) * increment[i]
            cosine_sine(turns, cosine, sine)
            for i in range(n):
                w, p, q = omega[i], amplitude[i] * cosine[i], amplitude[i] * sine[i]
                factors[block, i, 0], factors[block, i, 1] = p, -q
                factors[block, i, 2], factors[block, i, 3] = -w * q, -w * p
                factors[block, i, 4], factors[block, i, 5] = -w * w * p, w * w * q
        for strip in range(0, strips // 2, 2):
            for block in range(count):
                middle = (begin + block) * strips + strips // 2
                _accumulate(mean, factors[block], table, strip, middle, value, rate, acceleration)


@inlined
def _accumulate(
    mean: float,
    factors: FloatArray,
    table: FloatArray,
    strip: int,
    middle: int,
    value: FloatArray | None,
    rate: FloatArray | None,
    acceleration: FloatArray | None,
) -> None:
    """Sum factor times table over the components, for the orders asked for.

    Two eights of samples on either side of the middle of a block are summed together: their sums
    stay in registers, a factor is read once for all of them, and no sum waits for another.

    Args:
        strip: the first of the two eights, counted from the middle.
        middle: place of the middle in the outputs, in eights of samples.
    """
    n, x, y, z = len(factors), _no_sums(), _no_sums(), _no_sums()
    for i in range(n):
        one, two = 2 * (strip * n + i), 2 * ((strip + 1) * n + i)
        c, s = load(table, one), load(table, one + 1)
        d, t = load(table, two), load(table, two + 1)
        if value is not None:
            x = _added(x, c, s, d, t, factors[i, 0], factors[i, 1])
        if rate is not None:
            y = _added(y, c, s, d, t, factors[i, 2], factors[i, 3])
        if acceleration is not None:
            z = _added(z, c, s, d, t, factors[i, 4], factors[i, 5])
    _store_sums(x, mean, middle, strip, value)
    _store_sums(y, 0.0, middle, strip, rate)
    _store_sums(z, 0.0, middle, strip, acceleration)


@inlined
def _no_sums() -> tuple[Any, Any, Any, Any]:
    return splat(0.0), splat(0.0), splat(0.0), splat(0.0)


@inlined
def _added(
    sums: tuple[Any, Any, Any, Any], c: Any, s: Any, d: Any, t: Any, p: float, q: float
) -> tuple[Any, Any, Any, Any]:
    """Add to the sums of cosines and of sines of one eight, then of the next."""
    return fma(c, p, sums[0]), fma(s, q, sums[1]), fma(d, p, sums[2]), fma(t, q, sums[3])


@inlined
def _store_sums(
    sums: tuple[Any, Any, Any, Any], mean: float, middle: int, strip: int, out: FloatArray | None
) -> None:
    """Write two eights on either side of the middle, in one order."""
    if out is None:
        return
    right, left = middle + strip, middle - 1 - strip
    store(out, right, mean + (sums[0] + sums[1]))
    store(out, left, _turned(mean + (sums[0] - sums[1])))
    store(out, right + 1, mean + (sums[2] + sums[3]))
    store(out, left - 1, _turned(mean + (sums[2] - sums[3])))


@inlined
def _turned(x: Any) -> Any:
    """Return lanes in the opposite order."""
    y = with_lane(splat(lane(x, 7)), 1, lane(x, 6))
    y = with_lane(with_lane(y, 2, lane(x, 5)), 3, lane(x, 4))
    y = with_lane(with_lane(y, 4, lane(x, 3)), 5, lane(x, 2))
    return with_lane(with_lane(y, 6, lane(x, 1)), 7, lane(x, 0))


@entry
def encode(
    angle: FloatArray,
    rate: FloatArray,
    acceleration: FloatArray | None,
    heave: FloatArray | None,
    height: float,
    gravity: float,
    orientation: FloatArray,
    angular_velocity: FloatArray,
    force: FloatArray,
) -> None:
    """Fill the readings of an IMU beside the clock (equations: `imu.imu_samples`).

    Args:
        angle: rho, shape (n,).
        rate: rho', shape (n,).
        acceleration: rho'', shape (n,), or None where height is 0.
        heave: z_s'' [m/s2], shape (n,), or None.
        height: height of the clock above the roll axis [m].
        gravity: g [m/s2].
        orientation: output, shape (n', 4), n' >= n a multiple of eight.
        angular_velocity: output, shape (n', 3).
        force: output, likewise.
    """
    zero = splat(0.0)
    for i in range(len(orientation) // SIZE):
        s, c = half_angles(0.5 * eight(angle, i))
        turning = eight(rate, i)
        y, z = specific_force(s, c, i, turning, acceleration, heave, height, gravity)
        store(orientation, 4 * i, _fours(s, c, 0))
        store(orientation, 4 * i + 1, _fours(s, c, 2))
        store(orientation, 4 * i + 2, _fours(s, c, 4))
        store(orientation, 4 * i + 3, _fours(s, c, 6))
        _store_threes(angular_velocity, i, turning, zero, zero)
        _store_threes(force, i, zero, y, z)


@inlined
def specific_force(
    s: Any,
    c: Any,
    i: int,
    turning: Any,
    acceleration: FloatArray | None,
    heave: FloatArray | None,
    height: float,
    gravity: float,
) -> tuple[Any, Any]:
    """Return f'_y and f'_z of the eight samples from 8 i on, from half angles and roll rate."""
    weight = splat(gravity)
    if heave is not None:
        weight = weight + eight(heave, i)
    y, z = weight * (2.0 * s * c), weight * ((c - s) * (c + s))
    if acceleration is not None:
        y = y - height * eight(acceleration, i)
        z = z - height * (turning * turning)
    return y, z


@inlined
def eight(channel: FloatArray, i: int) -> Any:
    """Return the eight samples from 8 i on, zeros beyond the last."""
    begin, x = SIZE * i, splat(0.0)
    if begin + SIZE <= len(channel):
        return load(channel, i)
    for r in range(len(channel) - begin):
        x = with_lane(x, r, channel[begin + r])
    return x


@inlined
def half_angles(half: Any) -> Any:
    """Return sine and cosine of lanes of half the angle."""
    c, s = short_cosine_sine(half)
    if largest(half) > 0.25 * math.pi:
        for r in range(SIZE):
            x = lane(half, r)
            if abs(x) > 0.25 * math.pi:
                s, c = with_lane(s, r, math.sin(x)), with_lane(c, r, math.cos(x))
    return s, c


@inlined
def _fours(x: Any, w: Any, first: int) -> Any:
    """Return two quaternions (x, 0, 0, w) of lanes, from sample `first` on."""
    row = with_lane(with_lane(splat(0.0), 0, lane(x, first)), 3, lane(w, first))
    return with_lane(with_lane(row, 4, lane(x, first + 1)), 7, lane(w, first + 1))


@inlined
def _store_threes(out: FloatArray, i: int, x: Any, y: Any, z: Any) -> None:
    """Write eight vectors from lanes of x, y, z to rows 3 i to 3 i + 2."""
    a = with_lane(with_lane(splat(lane(x, 0)), 1, lane(y, 0)), 2, lane(z, 0))
    a = with_lane(with_lane(with_lane(a, 3, lane(x, 1)), 4, lane(y, 1)), 5, lane(z, 1))
    store(out, 3 * i, with_lane(with_lane(a, 6, lane(x, 2)), 7, lane(y, 2)))
    b = with_lane(with_lane(splat(lane(z, 2)), 1, lane(x, 3)), 2, lane(y, 3))
    b = with_lane(with_lane(with_lane(b, 3, lane(z, 3)), 4, lane(x, 4)), 5, lane(y, 4))
    store(out, 3 * i + 1, with_lane(with_lane(b, 6, lane(z, 4)), 7, lane(x, 5)))
    c = with_lane(with_lane(splat(lane(y, 5)), 1, lane(z, 5)), 2, lane(x, 6))
    c = with_lane(with_lane(with_lane(c, 3, lane(y, 6)), 4, lane(z, 6)), 5, lane(x, 7))
    store(out, 3 * i + 2, with_lane(with_lane(c, 6, lane(y, 7)), 7, lane(z, 7)))
