"""Compiled reading of an IMU; import on first use only.

Each sample is computed by itself and in a fixed order: the bits do not depend on the batch.
"""

import math
from typing import Any

from tauto_core.kernels import entry, inlined
from tauto_core.motion.lanes import (
    SIZE,
    fma,
    lane,
    larger,
    largest,
    least,
    load,
    negative,
    root,
    splat,
    store,
    total,
    with_lane,
)
from tauto_core.samples import FloatArray, IntArray
from tauto_core.ship.source_kernels import eight, half_angles, specific_force

LARGEST = 1e150
"""Larger values, even if they do not overflow themselves, are checked more closely."""

STEEP = 0.495
"""Half the sine of the pitch beyond which samples are checked more closely."""

MODERATE = math.sqrt(2.0) - 1.0
"""Tangent of 22.5 degrees: the largest angle whose series is summed."""

TINY = 1e-300
"""Keeps vectors of no length, or along the other axis, from being divided."""

INVERSE_ODDS = tuple((-1) ** k / (2 * k + 1) for k in range(21))
"""Coefficients with their signs in the series of the arc tangent."""


@entry
def all_good(
    stamp_ns: IntArray,
    last_stamp_ns: int,
    orientation: FloatArray,
    angular_velocity: FloatArray,
    force: FloatArray,
    off_unit: float,
) -> bool:
    """Return whether stamps increase and all samples are finite, have a roll and are not doubtful.

    A pitch above 82 degrees also counts as doubtful: 2 (w y - z x) is its sine.

    Args:
        stamp_ns: shape (n,), n > 0.
        last_stamp_ns: the stamp before the first.
        orientation: shape (n, 4).
        angular_velocity: shape (n, 3).
        force: shape (n, 3).
        off_unit: difference from 1 that the quaternion's norm must not reach.
    """
    rows = len(stamp_ns) // SIZE
    off, steep, finite = splat(0.0), splat(0.0), splat(0.0)
    for i in range(rows):
        x, y, z, w = _quaternions(orientation, i)
        norm = (x * x + y * y) + (z * z + w * w)
        off, steep = larger(off, norm - 1.0), larger(steep, w * y - z * x)
        finite = fma(norm, 0.0, finite)
    limit = off_unit * (2.0 - off_unit)
    good = largest(off) < limit and largest(steep) < STEEP and total(finite) == 0.0
    for i in range(SIZE * rows, len(stamp_ns)):
        x, y, z, w = orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3]
        norm = (x * x + y * y) + (z * z + w * w)
        good &= abs(norm - 1.0) < limit and abs(w * y - z * x) < STEEP
    for numbers in (angular_velocity.reshape(-1), force.reshape(-1)):
        for i in range(len(numbers)):
            good &= abs(numbers[i]) < LARGEST
    good &= stamp_ns[0] > last_stamp_ns
    for i in range(len(stamp_ns) - 1):
        good &= stamp_ns[i + 1] > stamp_ns[i]
    return good


@inlined
def _quaternions(orientation: FloatArray, i: int) -> tuple[Any, Any, Any, Any]:
    """Return x, y, z, w of the eight samples from 8 i on, as lanes."""
    a, b = load(orientation, 4 * i), load(orientation, 4 * i + 1)
    c, d = load(orientation, 4 * i + 2), load(orientation, 4 * i + 3)
    x, y = _every_fourth(a, b, c, d, 0), _every_fourth(a, b, c, d, 1)
    return x, y, _every_fourth(a, b, c, d, 2), _every_fourth(a, b, c, d, 3)


@inlined
def _every_fourth(a: Any, b: Any, c: Any, d: Any, k: int) -> Any:
    x = with_lane(splat(lane(a, k)), 1, lane(a, k + 4))
    x = with_lane(with_lane(x, 2, lane(b, k)), 3, lane(b, k + 4))
    x = with_lane(with_lane(x, 4, lane(c, k)), 5, lane(c, k + 4))
    return with_lane(with_lane(x, 6, lane(d, k)), 7, lane(d, k + 4))


@entry
def spaced(times: IntArray, least: int) -> bool:
    """Return whether all times are at least so far apart."""
    good = True
    for i in range(len(times) - 1):
        good &= times[i + 1] - times[i] >= least
    return good


@entry
def roll_of(
    orientation: FloatArray,
    angular_velocity: FloatArray | None,
    roll: FloatArray,
    rate: FloatArray | None,
) -> None:
    """Fill the roll in [-pi, pi] and, of an angular velocity, the roll rate [rad/s].

    Equations: `imu.attitude`; the quaternion's norm cancels.

    Args:
        orientation: shape (n, 4).
        angular_velocity: shape (n, 3), or None.
        roll: output, shape (n,).
        rate: output, shape (n,), or None.
    """
    rows = len(roll) // SIZE
    for i in range(rows):
        x, y, z, w = _quaternions(orientation, i)
        sine, cosine = 2.0 * (w * x + y * z), (w * w - x * x) + (z * z - y * y)
        _store_directions(sine, cosine, i, roll)
        if angular_velocity is not None:
            p, q, r = _vectors(angular_velocity, i)
            across = q * sine + r * cosine
            squared = sine * sine + cosine * cosine
            store(rate, i, p + across * (2.0 * (w * y - z * x)) / squared)
    for i in range(SIZE * rows, len(roll)):
        x, y, z, w = orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3]
        sine, cosine = 2.0 * (w * x + y * z), (w * w - x * x) + (z * z - y * y)
        roll[i] = _direction(sine, cosine)
        if angular_velocity is not None:
            across = angular_velocity[i, 1] * sine + angular_velocity[i, 2] * cosine
            squared = sine * sine + cosine * cosine
            more = across * (2.0 * (w * y - z * x)) / squared
            rate[i] = angular_velocity[i, 0] + more  # type: ignore[index]


@entry
def force_of(force: FloatArray, tilt: FloatArray | None, size: FloatArray | None) -> None:
    """Fill the direction of (-f_y, f_z), turned upwards in the case, and its size.

    A force that would throw the weight out of the top of the case counts as negative. The pull
    then passes through zero smoothly, and the slack thread is found there.

    Args:
        force: shape (n, 3).
        tilt: output, to starboard in the case [rad], shape (n,), or None.
        size: output, negative where the force was turned [m/s2], shape (n,), or None.
    """
    rows = len(force) // SIZE
    for i in range(rows):
        _, y, z = _vectors(force, i)
        _store_forces(y, z, i, tilt, size)
    for i in range(SIZE * rows, len(force)):
        _store_upwards(force[i, 1], force[i, 2], i, tilt, size)


@entry
def planar_roll(
    angle: FloatArray, turning: FloatArray, roll: FloatArray, rate: FloatArray | None
) -> None:
    """Fill the roll as `roll_of` would from the quaternion of a ship that only rolls.

    The bits are those of `roll_of` for the output of `source_kernels.encode`.

    Args:
        angle: rho [rad], shape (n,).
        turning: rho' [rad/s], shape (n,).
        roll: output, in [-pi, pi], shape (n,).
        rate: output [rad/s], shape (n,), or None.
    """
    rows = len(angle) // SIZE
    for i in range(rows):
        s, c = half_angles(0.5 * load(angle, i))
        # 0.0 stands for the other terms of quaternion and angular velocity
        _store_directions(2.0 * (c * s + 0.0), (c * c - s * s) + 0.0, i, roll)
        if rate is not None:
            store(rate, i, load(turning, i) + 0.0)
    s, c = half_angles(0.5 * eight(angle, rows))
    for r in range(len(angle) - SIZE * rows):
        x, w = lane(s, r), lane(c, r)
        roll[SIZE * rows + r] = _direction(2.0 * (w * x + 0.0), (w * w - x * x) + 0.0)
        if rate is not None:
            rate[SIZE * rows + r] = turning[SIZE * rows + r] + 0.0


@entry
def planar_force(
    angle: FloatArray,
    rate: FloatArray,
    acceleration: FloatArray | None,
    heave: FloatArray | None,
    height: float,
    gravity: float,
    tilt: FloatArray | None,
    size: FloatArray | None,
) -> None:
    """Fill the results of `force_of` for the force from `source_kernels.encode`."""
    rows = len(angle) // SIZE
    for i in range(rows + 1):
        s, c = half_angles(0.5 * eight(angle, i))
        y, z = specific_force(s, c, i, eight(rate, i), acceleration, heave, height, gravity)
        if i < rows:
            _store_forces(y, z, i, tilt, size)
        else:
            for r in range(len(angle) - SIZE * rows):
                _store_upwards(lane(y, r), lane(z, r), SIZE * rows + r, tilt, size)


@inlined
def _store_forces(
    y: Any, z: Any, i: int, tilt: FloatArray | None, size: FloatArray | None
) -> None:
    """Write the results of `force_of` for lanes to row i."""
    if tilt is not None:
        _store_directions(-y, z, i, tilt)
    if size is not None:
        store(size, i, root(y * y + z * z))
    if least(z) < 0.0:
        for r in range(SIZE):
            _store_upwards(lane(y, r), lane(z, r), SIZE * i + r, tilt, size)


@inlined
def _store_upwards(
    y: float, z: float, i: int, tilt: FloatArray | None, size: FloatArray | None
) -> None:
    """Write the results of `force_of` for one sample."""
    up = -1.0 if z < 0.0 else 1.0
    if tilt is not None:
        tilt[i] = _direction(-up * y, abs(z))
    if size is not None:
        size[i] = up * math.sqrt(y * y + z * z)


@inlined
def _vectors(rows: FloatArray, i: int) -> tuple[Any, Any, Any]:
    """Return x, y, z of the eight vectors from 8 i on, as lanes."""
    a, b, c = load(rows, 3 * i), load(rows, 3 * i + 1), load(rows, 3 * i + 2)
    x = with_lane(with_lane(splat(lane(a, 0)), 1, lane(a, 3)), 2, lane(a, 6))
    x = with_lane(with_lane(with_lane(x, 3, lane(b, 1)), 4, lane(b, 4)), 5, lane(b, 7))
    x = with_lane(with_lane(x, 6, lane(c, 2)), 7, lane(c, 5))
    y = with_lane(with_lane(splat(lane(a, 1)), 1, lane(a, 4)), 2, lane(a, 7))
    y = with_lane(with_lane(with_lane(y, 3, lane(b, 2)), 4, lane(b, 5)), 5, lane(c, 0))
    y = with_lane(with_lane(y, 6, lane(c, 3)), 7, lane(c, 6))
    z = with_lane(with_lane(splat(lane(a, 2)), 1, lane(a, 5)), 2, lane(b, 0))
    z = with_lane(with_lane(with_lane(z, 3, lane(b, 3)), 4, lane(b, 6)), 5, lane(c, 1))
    return x, y, with_lane(with_lane(z, 6, lane(c, 4)), 7, lane(c, 7))


@inlined
def _arctan(x: Any) -> Any:
    """Return the arc tangent of a number, or of lanes, up to MODERATE.

    There Taylor's series to x^41 is exact to rounding (the next term is below 2e-18 of the first).
    """
    f, square = INVERSE_ODDS, x * x
    fourth = square * square
    even, odd = fma(fourth, f[20], f[18]), fma(fourth, f[19], f[17])
    even, odd = fma(fourth, even, f[16]), fma(fourth, odd, f[15])
    even, odd = fma(fourth, even, f[14]), fma(fourth, odd, f[13])
    even, odd = fma(fourth, even, f[12]), fma(fourth, odd, f[11])
    even, odd = fma(fourth, even, f[10]), fma(fourth, odd, f[9])
    even, odd = fma(fourth, even, f[8]), fma(fourth, odd, f[7])
    even, odd = fma(fourth, even, f[6]), fma(fourth, odd, f[5])
    even, odd = fma(fourth, even, f[4]), fma(fourth, odd, f[3])
    even, odd = fma(fourth, even, f[2]), fma(fourth, odd, f[1])
    return fma(x * square, fma(square, even, odd), x)


@inlined
def _direction(sine: float, cosine: float) -> float:
    """Return the angle of a vector, at moderate angles with the bits of `_store_directions`."""
    reach = MODERATE * cosine - TINY
    if reach - sine < 0.0 or reach + sine < 0.0:
        return math.atan2(sine, cosine)
    return _arctan(sine / cosine)


@inlined
def _store_directions(sine: Any, cosine: Any, i: int, angle: FloatArray) -> None:
    """Write the angles of lanes of vectors to row i; each by itself, whatever its neighbours."""
    store(angle, i, _arctan(sine / cosine))
    reach = MODERATE * cosine - TINY
    steep = negative(reach - sine) | negative(reach + sine)
    if steep != 0:
        for r in range(SIZE):
            if steep >> r & 1:
                angle[SIZE * i + r] = math.atan2(lane(sine, r), lane(cosine, r))


@entry
def unwrap(angle: FloatArray, turns: int, last: float) -> tuple[int, float]:
    """Add whole turns in place, so that no step exceeds half a turn; return turns and last angle.

    Args:
        angle: in [-pi, pi], shape (n,).
        turns: whole turns of the angle before these.
        last: that angle, in (-pi, pi].
    """
    narrow, whole, reach = abs(last) < 0.5 * math.pi, 2.0 * math.pi * turns, splat(0.0)
    rows = len(angle) // SIZE
    for i in range(rows):
        reach = larger(reach, load(angle, i))
    for i in range(SIZE * rows, len(angle)):
        narrow &= abs(angle[i]) < 0.5 * math.pi
    if narrow and largest(reach) < 0.5 * math.pi and len(angle):
        last = angle[-1]
        for i in range(rows):
            store(angle, i, load(angle, i) + whole)
        for i in range(SIZE * rows, len(angle)):
            angle[i] += whole
        return turns, last
    for i in range(len(angle)):
        now = angle[i] if angle[i] > -math.pi else math.pi
        if now - last < -math.pi:
            turns += 1
        elif now - last > math.pi:
            turns -= 1
        angle[i] = now + 2.0 * math.pi * turns
        last = now
    return turns, last
