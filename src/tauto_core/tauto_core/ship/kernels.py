"""Compiled sums of harmonics and IMU arithmetic; import on first use only (numba).

Each sample is computed by itself and in a fixed order: the bits do not depend on the batch.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tauto_core.samples import FloatArray, IntArray
from tauto_core.ship.waves import TOGETHER

RADIANS_PER_UNIT = 2.0 * math.pi / 2.0**64
INVERSE_FACTORIALS = tuple((-1) ** (k // 2) / math.factorial(k) for k in range(18))
"""Signed as in the series of sine (odd) and cosine (even)."""

LARGEST = 1e150
"""What is larger, and does not overflow by itself, is looked at more closely."""


@njit(cache=True, nogil=True)
def sum_blocks(
    first_block: int,
    mean: float,
    phase: NDArray[np.uint64],
    increment: NDArray[np.uint64],
    amplitude: FloatArray,
    omega: FloatArray,
    cosine: FloatArray,
    sine: FloatArray,
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
        cosine: cos(theta_j), shape (n, block/2).
        sine: sin(theta_j), shape (n, block/2).
        value: output, shape (blocks, block), or None.
        rate: output, likewise.
        acceleration: output, likewise.
    """
    half = cosine.shape[1]
    a, b = np.empty((3, len(phase))), np.empty((3, len(phase)))
    even, odd = np.empty((3, half)), np.empty((3, half))
    some = value if value is not None else acceleration
    for block in range(some.shape[0]):  # type: ignore[union-attr]
        for i in range(len(phase)):
            turns = phase[i] + np.uint64(first_block + block) * increment[i]
            start = np.int64(turns) * RADIANS_PER_UNIT
            w = omega[i]
            p, q = amplitude[i] * math.cos(start), amplitude[i] * math.sin(start)
            a[0, i], b[0, i] = p, -q
            a[1, i], b[1, i] = -w * q, -w * p
            a[2, i], b[2, i] = -w * w * p, w * w * q
        _accumulate(a, cosine, even, value, rate, acceleration)
        _accumulate(b, sine, odd, value, rate, acceleration)
        if value is not None:
            _fold(mean, even[0], odd[0], value[block])
        if rate is not None:
            _fold(0.0, even[1], odd[1], rate[block])
        if acceleration is not None:
            _fold(0.0, even[2], odd[2], acceleration[block])


@njit(cache=True, nogil=True)
def _accumulate(
    factors: FloatArray,
    table: FloatArray,
    sums: FloatArray,
    value: FloatArray | None,
    rate: FloatArray | None,
    acceleration: FloatArray | None,
) -> None:
    """Sum factor times table over the components, for the orders asked for."""
    sums[:] = 0.0
    x, y, z = sums[0], sums[1], sums[2]
    f, g, h = factors[0], factors[1], factors[2]
    for i in range(0, table.shape[0], TOGETHER):
        t0, t1, t2, t3 = table[i], table[i + 1], table[i + 2], table[i + 3]
        f0, f1, f2, f3 = f[i], f[i + 1], f[i + 2], f[i + 3]
        g0, g1, g2, g3 = g[i], g[i + 1], g[i + 2], g[i + 3]
        h0, h1, h2, h3 = h[i], h[i + 1], h[i + 2], h[i + 3]
        for j in range(table.shape[1]):
            if value is not None:
                x[j] += (f0 * t0[j] + f1 * t1[j]) + (f2 * t2[j] + f3 * t3[j])
            if rate is not None:
                y[j] += (g0 * t0[j] + g1 * t1[j]) + (g2 * t2[j] + g3 * t3[j])
            if acceleration is not None:
                z[j] += (h0 * t0[j] + h1 * t1[j]) + (h2 * t2[j] + h3 * t3[j])


@njit(cache=True, nogil=True)
def _fold(mean: float, even: FloatArray, odd: FloatArray, out: FloatArray) -> None:
    half = len(even)
    for j in range(half):
        out[half + j] = mean + (even[j] + odd[j])
    for j in range(half):
        out[half - 1 - j] = mean + (even[j] - odd[j])


@njit(cache=True, nogil=True)
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
    """Fill what an IMU beside the clock reads (equations: `imu.imu_samples`).

    Args:
        angle: rho, shape (n,).
        rate: rho', shape (n,).
        acceleration: rho'', shape (n,), or None where height is 0.
        heave: z_s'' [m/s2], or None.
        height: of the clock above the roll axis [m].
        gravity: g [m/s2].
        orientation: output, shape (n, 4).
        angular_velocity: output, shape (n, 3).
        force: output, shape (n, 3).
    """
    sine, cosine = np.empty(len(angle)), np.empty(len(angle))
    _half_angles(angle, sine, cosine)
    for i in range(len(angle)):
        s, c = sine[i], cosine[i]
        weight = gravity
        if heave is not None:
            weight += heave[i]
        force_y, force_z = weight * (2.0 * s * c), weight * ((c - s) * (c + s))
        if acceleration is not None:
            force_y -= height * acceleration[i]
            force_z -= height * (rate[i] * rate[i])
        orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3] = s, 0.0, 0.0, c
        angular_velocity[i, 0], angular_velocity[i, 1], angular_velocity[i, 2] = rate[i], 0.0, 0.0
        force[i, 0], force[i, 1], force[i, 2] = 0.0, force_y, force_z


@njit(cache=True, nogil=True)
def _half_angles(angle: FloatArray, sine: FloatArray, cosine: FloatArray) -> None:
    """Fill sine and cosine of half the angle, shape (n,).

    Up to a right angle the Taylor series to x^17 and x^16 are exact to rounding (the next terms
    are below 2e-19 and 3e-18); several fit one instruction, which the library's functions do not.
    """
    for i in range(len(angle)):
        x = 0.5 * angle[i]
        z = x * x
        odd, even = INVERSE_FACTORIALS[17], INVERSE_FACTORIALS[16]
        for k in range(15, 2, -2):
            odd = odd * z + INVERSE_FACTORIALS[k]
            even = even * z + INVERSE_FACTORIALS[k - 1]
        sine[i] = x + x * (z * odd)
        cosine[i] = 1.0 + z * even
    for i in range(len(angle)):
        if not abs(angle[i]) <= 0.5 * math.pi:
            sine[i], cosine[i] = math.sin(0.5 * angle[i]), math.cos(0.5 * angle[i])


@njit(cache=True, nogil=True)
def all_good(
    stamp_ns: IntArray,
    last_stamp_ns: int,
    orientation: FloatArray,
    angular_velocity: FloatArray,
    force: FloatArray,
    norms: tuple[float, float],
    smallest_cos_pitch: float,
) -> bool:
    """Return whether stamps rise and all samples are finite with a roll; no doubtful ones.

    Args:
        stamp_ns: shape (n,), n > 0.
        last_stamp_ns: the stamp before the first.
        orientation: shape (n, 4).
        angular_velocity: shape (n, 3).
        force: shape (n, 3).
        norms: limits of the quaternion's norm, exclusive.
        smallest_cos_pitch: limit for a roll, exclusive.
    """
    low, high = norms[0] * norms[0], norms[1] * norms[1]
    limit = smallest_cos_pitch * smallest_cos_pitch
    good = True
    for i in range(len(stamp_ns)):
        x, y, z, w = orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3]
        norm = (x * x + y * y) + (z * z + w * w)
        sine, cosine = 2.0 * (w * x + y * z), (w * w - x * x) + (z * z - y * y)
        good &= (norm > low) & (norm < high) & (sine * sine + cosine * cosine > limit)
    for numbers in (angular_velocity.reshape(-1), force.reshape(-1)):
        for i in range(len(numbers)):
            good &= abs(numbers[i]) < LARGEST
    good &= stamp_ns[0] > last_stamp_ns
    for i in range(len(stamp_ns) - 1):
        good &= stamp_ns[i + 1] > stamp_ns[i]
    return good


@njit(cache=True, nogil=True)
def roll_vector(orientation: FloatArray, sine: FloatArray, cosine: FloatArray) -> None:
    """Fill the roll's sine and cosine, times cos(pitch) and the quaternion's squared norm.

    Args:
        orientation: shape (n, 4).
        sine: output, shape (n,).
        cosine: output, shape (n,).
    """
    for i in range(len(sine)):
        x, y, z, w = orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3]
        sine[i] = 2.0 * (w * x + y * z)
        cosine[i] = (w * w - x * x) + (z * z - y * y)


@njit(cache=True, nogil=True, error_model='numpy')
def roll_rate(
    orientation: FloatArray,
    angular_velocity: FloatArray,
    sine: FloatArray,
    cosine: FloatArray,
    rate: FloatArray,
) -> None:
    """Fill the roll rate [rad/s] (equation: `imu.attitude`) from what `roll_vector` has filled.

    Args:
        orientation: shape (n, 4).
        angular_velocity: shape (n, 3).
        sine: shape (n,).
        cosine: shape (n,).
        rate: output, shape (n,).
    """
    for i in range(len(rate)):
        x, y, z, w = orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3]
        across = angular_velocity[i, 1] * sine[i] + angular_velocity[i, 2] * cosine[i]
        squared = sine[i] * sine[i] + cosine[i] * cosine[i]
        rate[i] = angular_velocity[i, 0] + across * (2.0 * (w * y - z * x)) / squared


@njit(cache=True, nogil=True)
def force_vector(across: FloatArray, along: FloatArray, size: FloatArray) -> None:
    """Turn (f_y, f_z) in place to (-f_y, f_z), upwards in the case; fill its size.

    Args:
        across: f_y, then to starboard in the case [m/s2], shape (n,).
        along: f_z, then never negative [m/s2], shape (n,).
        size: output, negative where the force was turned [m/s2], shape (n,).
    """
    for i in range(len(across)):
        y, z = across[i], along[i]
        up = 1.0 - 2.0 * (z < 0.0)
        across[i] = -up * y
        along[i] = abs(z)
        size[i] = up * math.sqrt(y * y + z * z)


@njit(cache=True, nogil=True)
def unwrap(angle: FloatArray, turns: int, last: float) -> tuple[int, float]:
    """Add whole turns in place, so that no step exceeds half a turn; return turns and last angle.

    Args:
        angle: in [-pi, pi], shape (n,).
        turns: whole turns of the angle before these.
        last: that angle, in (-pi, pi].
    """
    for i in range(len(angle)):
        now = angle[i] if angle[i] > -math.pi else math.pi
        if now - last < -math.pi:
            turns += 1
        elif now - last > math.pi:
            turns -= 1
        angle[i] = now + 2.0 * math.pi * turns
        last = now
    return turns, last
