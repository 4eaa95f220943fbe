"""Compiled sums of harmonics, their fading, and IMU readings. Import them on first use only.

Each sample is computed by itself in a fixed order, so its bits do not depend on the batch.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import entry, inlined
from tauto_core.motion.forcing import LEAST_UPWARD
from tauto_core.motion.lanes import (
    SIZE,
    fma,
    lane,
    larger,
    largest,
    lowest,
    negative,
    row_of,
    splat,
    square_root,
    store,
    with_lane,
)
from tauto_core.motion.linear import cosine_sine, short_cosine_sine
from tauto_core.samples import FloatArray, IntArray

# A loop over a tuple is unrolled with a constant variable.
LANES = tuple(range(SIZE))
_THREE, _FOUR = (0, 1, 2), (0, 1, 2, 3)

# limits of orientations that are refused
NORM_TOLERANCE = 1e-3
SMALLEST_NORM = 1e-6
SMALLEST_COS_PITCH = 1e-6


@inlined
def strided(rows: tuple[Any, ...], start: int, step: int) -> Any:
    """Return the numbers at start, start + step, … of concatenated rows of eight, as lanes.

    This takes components of vectors out of their array. `start` and `step` are compile-time
    constants.
    """
    x = splat(lane(rows[start // SIZE], start % SIZE))
    for r in LANES:
        k = start + step * r
        x = with_lane(x, r, lane(rows[k // SIZE], k % SIZE))
    return x


@inlined
def interleaved(parts: tuple[Any, ...], row: int) -> Any:
    """Return a row of eight of the array of vectors with the given components as lanes.

    The inverse of `strided`: number k of the array is component k % n of vector k // n.
    """
    x, n = splat(0.0), len(parts)
    for r in LANES:
        k = SIZE * row + r
        x = with_lane(x, r, lane(parts[k % n], k // n))
    return x


# -----------------------------------------------------------------------------
# Sums of harmonics.

BLOCKS_TOGETHER = 8
"""Blocks summed while a part of the table is in the first-level cache."""


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
    """Fill sum a cos(φ) and its first and second derivative over whole blocks.

    φ = φ_b ± θ_j with φ_b at the middle of block b, exact in 2⁻⁶⁴ turns, and θ_j from there to the
    j-th sample on either side, from a table. cos θ contributes equally to both sides, sin θ with
    opposite signs. Outputs have the shape (blocks, block). `None` leaves one out of the compiled
    code.

    `phase` at the middle of the scene's first block and its `increment` per block are in 2⁻⁶⁴
    turns. `table` has cos(θ_j), then sin(θ_j), of each component, a row for eight j, (block n/4,
    8). `mean` is added to the value.
    """
    n = len(phase)
    turns, sine, cosine = np.empty(n, np.uint64), np.empty(n), np.empty(n)
    sums = value if value is not None else acceleration
    blocks, strips = sums.shape[0], sums.shape[1] // SIZE  # type: ignore[union-attr]
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
    """Sum factor times table over the components, for the given orders.

    Two eights of samples on either side of the middle of a block, from `strip` on, are summed
    together. The sums stay in registers, each factor is read once, and the sums are independent.
    """
    n, zero = len(factors), splat(0.0)
    x = y = z = zero, zero, zero, zero
    for i in range(n):
        a, b = 2 * (strip * n + i), 2 * ((strip + 1) * n + i)
        c, s = row_of(table, a), row_of(table, a + 1)
        d, t = row_of(table, b), row_of(table, b + 1)
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
def _added(
    sums: tuple[Any, Any, Any, Any], c: Any, s: Any, d: Any, t: Any, p: float, q: float
) -> tuple[Any, Any, Any, Any]:
    """Add to the sums of cosines and of sines of one eight, then of the next."""
    return fma(c, p, sums[0]), fma(s, q, sums[1]), fma(d, p, sums[2]), fma(t, q, sums[3])


@inlined
def _store_sums(
    sums: tuple[Any, Any, Any, Any], mean: float, middle: int, strip: int, out: FloatArray | None
) -> None:
    """Write two eights on either side of the middle, in sample order."""
    if out is None:
        return
    above, below = middle + strip, middle - 1 - strip
    store(out, above, mean + (sums[0] + sums[1]))
    store(out, below, strided((mean + (sums[0] - sums[1]),), 7, -1))
    store(out, above + 1, mean + (sums[2] + sums[3]))
    store(out, below - 1, strided((mean + (sums[2] - sums[3]),), 7, -1))


# -----------------------------------------------------------------------------
# Readings of an IMU at the clock, and roll and force from them.


@entry
def encode_imu(
    angle: FloatArray,
    rate: FloatArray | None,
    acceleration: FloatArray | None,
    heave: FloatArray | None,
    height: float,
    gravity: float,
    orientation: FloatArray,
    angular_velocity: FloatArray | None,
    force: FloatArray | None,
) -> None:
    """Fill the readings of an IMU at the clock (equations: `imu.imu_samples`).

    `acceleration` ρ̈ is `None` at height 0, and `heave` z̈_s without heave. Outputs that are
    `None`, and a rate that they do not need, are left out of the compiled code. Outputs are padded
    to a multiple of eight.
    """
    zero = splat(0.0)
    for i in range(len(orientation) // SIZE):
        s, c = half_angles(0.5 * eight(angle, i))
        turning = zero if rate is None else eight(rate, i)
        for row in _FOUR:
            store(orientation, 4 * i + row, interleaved((s, zero, zero, c), row))
        if angular_velocity is not None:
            for row in _THREE:
                store(angular_velocity, 3 * i + row, interleaved((turning, zero, zero), row))
        if force is not None:
            weight = splat(gravity)
            if heave is not None:
                weight = weight + eight(heave, i)
            y, z = weight * (2.0 * s * c), weight * ((c - s) * (c + s))
            if acceleration is not None:
                y = y - height * eight(acceleration, i)
                z = z - height * (turning * turning)
            for row in _THREE:
                store(force, 3 * i + row, interleaved((zero, y, z), row))


@entry
def encode_six(
    roll: FloatArray,
    pitch: FloatArray,
    yaw: FloatArray,
    roll_rate: FloatArray | None,
    pitch_rate: FloatArray | None,
    yaw_rate: FloatArray | None,
    forward: FloatArray | None,
    port: FloatArray | None,
    up: FloatArray | None,
    orientation: FloatArray,
    angular_velocity: FloatArray | None,
    force: FloatArray | None,
) -> None:
    """Fill the readings of an IMU on a ship with six motions (`imu.imu_from_motions`).

    Inputs have the shape (n,), outputs (n', 4) and (n', 3) with n' >= n a multiple of eight. `up`
    contains gravity. Outputs that are `None`, and their inputs, are left out of the compiled code.
    """
    for i in range(len(orientation) // SIZE):
        sr, cr = half_angles(0.5 * eight(roll, i))
        sp, cp = half_angles(0.5 * eight(pitch, i))
        sy, cy = half_angles(0.5 * eight(yaw, i))
        turned = (
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        )
        sr, cr = 2.0 * sr * cr, (cr - sr) * (cr + sr)
        sp, cp = 2.0 * sp * cp, (cp - sp) * (cp + sp)
        sy, cy = 2.0 * sy * cy, (cy - sy) * (cy + sy)
        for row in _FOUR:
            store(orientation, 4 * i + row, interleaved(turned, row))
        if angular_velocity is not None:
            p, q, r = eight(roll_rate, i), eight(pitch_rate, i), eight(yaw_rate, i)  # type: ignore[arg-type]
            turning = p - r * sp, q * cr + r * cp * sr, r * cp * cr - q * sr
            for row in _THREE:
                store(angular_velocity, 3 * i + row, interleaved(turning, row))
        if force is not None:
            x, y, z = eight(forward, i), eight(port, i), eight(up, i)  # type: ignore[arg-type]
            # along the mean heading turned by the yaw, then by the pitch, then by the roll
            ahead, aside = cy * x + sy * y, cy * y - sy * x
            deck = sp * ahead + cp * z
            axes = cp * ahead - sp * z, cr * aside + sr * deck, cr * deck - sr * aside
            for row in _THREE:
                store(force, 3 * i + row, interleaved(axes, row))


@inlined
def eight(channel: FloatArray, i: int) -> Any:
    """Return the eight samples from 8 i on, zeros beyond the last."""
    begin, x = SIZE * i, splat(0.0)
    if begin + SIZE <= len(channel):
        return row_of(channel, i)
    for r in range(len(channel) - begin):
        x = with_lane(x, r, channel[begin + r])
    return x


@inlined
def half_angles(angle: Any) -> Any:
    """Return sine and cosine of lanes of half an angle."""
    c, s = short_cosine_sine(angle)
    if largest(angle) > 0.25 * math.pi:
        for r in range(SIZE):
            x = lane(angle, r)
            if abs(x) > 0.25 * math.pi:
                s, c = with_lane(s, r, math.sin(x)), with_lane(c, r, math.cos(x))
    return s, c


MODERATE = math.sqrt(2.0) - 1.0
"""Tangent of 22.5 degrees, the largest argument of the arc tangent's series."""

TINY = 1e-300
"""Keeps null vectors, and those along the other axis, from a division by zero."""

INVERSE_ODDS = tuple((-1) ** k / (2 * k + 1) for k in range(21))
"""Coefficients of the arc tangent's series, with signs."""


@entry
def refuse_samples(
    stamp_ns: IntArray,
    last_stamp_ns: int,
    orientation: FloatArray,
    angular_velocity: FloatArray,
    force: FloatArray,
    reasons: IntArray,
) -> None:
    """Fill the reasons, from the fourth of `imu.REFUSALS` on, of samples that have none so far."""
    last = last_stamp_ns
    for k in range(len(reasons)):
        if reasons[k] != 0:
            continue
        x, y, z, w = orientation[k, 0], orientation[k, 1], orientation[k, 2], orientation[k, 3]
        defect = 0.0 * x + 0.0 * y + 0.0 * z + 0.0 * w  # NaN, unless all are finite
        for j in range(3):
            defect += 0.0 * angular_velocity[k, j] + 0.0 * force[k, j]
        square = (x * x + y * y) + (z * z + w * w)
        sine, cosine = 2.0 * (w * x + y * z), (w * w - x * x) + (z * z - y * y)
        if not defect == 0.0:  # noqa: SIM201
            reasons[k] = 4
        elif square < SMALLEST_NORM * SMALLEST_NORM:
            reasons[k] = 5
        elif abs(math.sqrt(square) - 1.0) > NORM_TOLERANCE:
            reasons[k] = 6
        elif sine * sine + cosine * cosine < SMALLEST_COS_PITCH * SMALLEST_COS_PITCH:
            reasons[k] = 7
        elif stamp_ns[k] > last:
            last = stamp_ns[k]
        else:
            reasons[k] = 8 if stamp_ns[k] == last else 9


@inlined
def vectors(array: FloatArray, i: int, places: tuple[int, ...]) -> tuple[Any, ...]:
    """Return the components of the eight vectors from 8 i on, each as lanes, 0 beyond the last."""
    rows: tuple[Any, ...] = ()
    parts: tuple[Any, ...] = ()
    if SIZE * i + SIZE <= len(array):
        for k in places:
            rows = (*rows, row_of(array, len(places) * i + k))
        for k in places:
            parts = (*parts, strided(rows, k, len(places)))
        return parts
    for k in places:
        x = splat(0.0)
        for r in range(len(array) - SIZE * i):
            x = with_lane(x, r, array[SIZE * i + r, k])
        parts = (*parts, x)
    return parts


@inlined
def put(channel: FloatArray, i: int, x: Any) -> None:
    """Write lanes to the eight samples from 8 i on, up to the last."""
    if SIZE * i + SIZE <= len(channel):
        store(channel, i, x)
    else:
        for r in range(len(channel) - SIZE * i):
            channel[SIZE * i + r] = lane(x, r)


@entry
def roll_of(
    orientation: FloatArray,
    angular_velocity: FloatArray | None,
    roll: FloatArray,
    rate: FloatArray | None,
) -> None:
    """Fill the roll in [−π, π] and, with an angular velocity, the roll rate [rad/s].

    Equations: `imu.attitude`. The quaternion's norm cancels.
    """
    for i in range(-(-len(roll) // SIZE)):
        x, y, z, w = vectors(orientation, i, _FOUR)
        sine, cosine = 2.0 * (w * x + y * z), (w * w - x * x) + (z * z - y * y)
        put(roll, i, _directions(sine, cosine))
        if angular_velocity is not None:
            p, q, r = vectors(angular_velocity, i, _THREE)
            across = q * sine + r * cosine
            squared = sine * sine + cosine * cosine
            put(rate, i, p + across * (2.0 * (w * y - z * x)) / squared)  # type: ignore[arg-type]


@entry
def force_of(force: FloatArray, tilt: FloatArray | None, size: FloatArray | None) -> None:
    """Fill the direction of (-f_y, f_z) [rad], upwards in the case, and its size [m/s²].

    A thread cannot follow a force with less than `LEAST_UPWARD` upwards in the case, because its
    direction would turn round at once. The direction is then computed with a smooth upward
    component of at least half of that. The size is the component along the direction, negative if
    the force would throw the weight out of the top of the case. Both are smooth in the force,
    which lets the slack be detected. `motion.threads.transverse` gives the rest of the force. The
    direction is positive to starboard in the case.
    """
    for i in range(-(-len(force) // SIZE)):
        _, y, z = vectors(force, i, _THREE)
        store_forces(y, z, i, tilt, size)


@entry
def rolls_alone(orientation: FloatArray, force: FloatArray) -> bool:
    """Return whether the ship only rolls, without a force along the axle."""
    for k in range(len(force)):
        if force[k, 0] != 0.0 or orientation[k, 1] != 0.0 or orientation[k, 2] != 0.0:
            return False
    return True


@entry
def force_in_plane(
    orientation: FloatArray, force: FloatArray, upright: bool, out: FloatArray
) -> None:
    """Fill the specific force that a clock's thread can follow (`imu.force_in_plane`).

    The thread's plane is upright, or the thread leans freely. The outputs (n', 3) are padded to a
    multiple of eight. The quaternion's norm cancels.
    """
    for i in range(-(-len(force) // SIZE)):
        x, y, z = vectors(force, i, _THREE)
        if upright:
            a, b, c, w = vectors(orientation, i, _FOUR)
            y, z = _upright(a, b, c, w, x, y, z)
            # in a pure roll both planes are the same, to the last bit
            tilted = (x * x + b * b) + c * c
        else:
            across = y * y + z * z
            stretch = square_root(1.0 + (x * x) / across)
            y, z = y * stretch, z * stretch
            tilted = across
        for row in _THREE:
            store(out, 3 * i + row, interleaved((x, y, z), row))
        if not lowest(tilted) > 0.0:
            for k in range(SIZE * i, min(SIZE * i + SIZE, len(force))):
                _store_in_plane(orientation, force, k, upright, out)


@inlined
def _upright(a: Any, b: Any, c: Any, w: Any, x: Any, y: Any, z: Any) -> tuple[Any, Any]:
    """Return the force athwart and upright in a case without pitch (a, b, c, w: ship)."""
    sine, cosine = 2.0 * (w * a + b * c), (w * w - a * a) + (c * c - b * b)
    across = square_root(sine * sine + cosine * cosine)
    sr, cr = sine / across, cosine / across
    square = (a * a + b * b) + (c * c + w * w)
    aside, deck = cr * y - sr * z, sr * y + cr * z
    up = (across * deck - 2.0 * (w * b - c * a) * x) / square
    return cr * aside + sr * up, cr * up - sr * aside


@inlined
def _store_in_plane(
    orientation: FloatArray, force: FloatArray, k: int, upright: bool, out: FloatArray
) -> None:
    """Write the force of one sample, unchanged if pitch or axial force are absent."""
    x, y, z = force[k, 0], force[k, 1], force[k, 2]
    if upright:
        a, b, c, w = orientation[k, 0], orientation[k, 1], orientation[k, 2], orientation[k, 3]
        if x != 0.0 or b != 0.0 or c != 0.0:
            y, z = _upright(a, b, c, w, x, y, z)
    elif x != 0.0:
        across = y * y + z * z
        if across > 0.0:
            stretch = math.sqrt(1.0 + (x * x) / across)
            y, z = y * stretch, z * stretch
    out[k, 0], out[k, 1], out[k, 2] = x, y, z


@entry
def level_force_of(
    orientation: FloatArray, force: FloatArray, upright: bool, aside: FloatArray, up: FloatArray
) -> None:
    """Fill the specific force in the athwartship plane, in level axes: to port, and up.

    The plane pitches with the ship, or is upright. The quaternion's norm cancels.
    """
    for k in range(len(aside)):
        x, y, z, w = orientation[k, 0], orientation[k, 1], orientation[k, 2], orientation[k, 3]
        sine, cosine = 2.0 * (w * x + y * z), (w * w - x * x) + (z * z - y * y)
        across = math.sqrt(sine * sine + cosine * cosine)
        deck = (sine * force[k, 1] + cosine * force[k, 2]) / across
        aside[k], up[k] = (cosine * force[k, 1] - sine * force[k, 2]) / across, deck
        if upright:
            square = (x * x + y * y) + (z * z + w * w)
            up[k] = (across * deck - 2.0 * (w * y - z * x) * force[k, 0]) / square


@inlined
def store_forces(y: Any, z: Any, i: int, tilt: FloatArray | None, size: FloatArray | None) -> None:
    """Write the results of `force_of` for lanes to row i."""
    upward, pull = z, square_root(y * y + z * z)
    if lowest(z) < LEAST_UPWARD:
        for r in range(SIZE):
            a, b = lane(y, r), lane(z, r)
            if b < LEAST_UPWARD:
                # continuous with its slope, and at least half of the least
                c = 0.5 * LEAST_UPWARD * (1.0 + math.exp(2.0 * (b / LEAST_UPWARD - 1.0)))
                upward = with_lane(upward, r, c)
                pull = with_lane(pull, r, (a * a + b * c) / math.sqrt(a * a + c * c))
    if tilt is not None:
        put(tilt, i, _directions(-y, upward))
    if size is not None:
        put(size, i, pull)


@inlined
def _arctan(x: Any) -> Any:
    """Return the arc tangent of a number, or of lanes, up to MODERATE.

    Taylor's series to x⁴¹ is exact to rounding: the next term is below 2e-18 of the first.
    """
    f, square = INVERSE_ODDS, x * x
    fourth = square * square
    even, odd = fma(fourth, f[20], f[18]), fma(fourth, f[19], f[17])
    for k in (16, 14, 12, 10, 8, 6, 4, 2):
        even, odd = fma(fourth, even, f[k]), fma(fourth, odd, f[k - 1])
    return fma(x * square, fma(square, even, odd), x)


@inlined
def _directions(sine: Any, cosine: Any) -> Any:
    """Return the angles of lanes of vectors, each independent of its neighbours."""
    angle, reach = _arctan(sine / cosine), MODERATE * cosine - TINY
    steep = negative(reach - sine) | negative(reach + sine)
    if steep != 0:
        for r in range(SIZE):
            if steep >> r & 1:
                angle = with_lane(angle, r, math.atan2(lane(sine, r), lane(cosine, r)))
    return angle


@entry
def unwrap(angle: FloatArray, turns: int, last_angle: float) -> tuple[int, float]:
    """Add whole turns in place to bound steps by half a turn. Return turns and last angle.

    Angles are in [−π, π]. `turns` and `last_angle` belong to the previous angle.
    """
    count, reach = -(-len(angle) // SIZE), splat(0.0)
    for i in range(count):
        reach = larger(reach, eight(angle, i))
    if len(angle) and max(abs(last_angle), largest(reach)) < 0.5 * math.pi:
        last_angle, offset = angle[-1], 2.0 * math.pi * turns
        for i in range(count):
            put(angle, i, eight(angle, i) + offset)
        return turns, last_angle
    for i in range(len(angle)):
        now = angle[i] if angle[i] > -math.pi else math.pi
        if now - last_angle < -math.pi:
            turns += 1
        elif now - last_angle > math.pi:
            turns -= 1
        angle[i] = now + 2.0 * math.pi * turns
        last_angle = now
    return turns, last_angle


# -----------------------------------------------------------------------------
# Fading of one motion into another.

ROOT_HALF = math.sqrt(0.5)


@entry
def fade(
    start: int,
    step_ns: int,
    begin_ns: int,
    length_ns: int,
    old: tuple[FloatArray, FloatArray, FloatArray],
    new: tuple[FloatArray, FloatArray, FloatArray],
    value: FloatArray | None,
    rate: FloatArray | None,
    acceleration: FloatArray | None,
) -> None:
    """Fill x = cos(θ) a + sin(θ) b and its derivatives, θ = ½π s(u) (equations: `waves`).

    With p = cos(θ) a + sin(θ) b and q = cos(θ) b − sin(θ) a, and likewise p′, q′, p″ of the
    derivatives of a and b (`old` and `new`),

        x = p,    ẋ = p′ + θ̇ q,    ẍ = p″ + 2 θ̇ q′ + θ̈ q − θ̇² p.

    The series of sine and cosine takes θ − π/4, its whole range. Outputs that are `None`, and
    derivatives that no output needs, are left out of the compiled code. Outputs are padded to a
    multiple of eight. Times are from the start of the scene.
    """
    per_s, length = 1e9 / length_ns, float(length_ns)
    for k in range(-(-len(old[0]) // SIZE)):
        begin, times = (start + SIZE * k) * step_ns - begin_ns, splat(0.0)
        for r in range(SIZE):  # each time is exact, or rounded by itself
            times = with_lane(times, r, float(begin + r * step_ns))
        u = times / length
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
