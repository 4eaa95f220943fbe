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
    root,
    splat,
    store,
    total,
    with_lane,
)
from tauto_core.samples import FloatArray, IntArray

LARGEST = 1e150
"""What is larger, and does not overflow by itself, is looked at more closely."""

STEEP = 0.495
"""Half the sine of the pitch beyond which samples are looked at more closely."""


@entry
def all_good(
    stamp_ns: IntArray,
    last_stamp_ns: int,
    orientation: FloatArray,
    angular_velocity: FloatArray,
    force: FloatArray,
    off_unit: float,
) -> bool:
    """Return whether stamps rise and all samples are finite with a roll; no doubtful ones.

    Doubtful is a pitch above 82 degrees, too: 2 (w y - z x) is its sine.

    Args:
        stamp_ns: shape (n,), n > 0.
        last_stamp_ns: the stamp before the first.
        orientation: shape (n, 4).
        angular_velocity: shape (n, 3).
        force: shape (n, 3).
        off_unit: by how much the quaternion's norm may be off 1, exclusive.
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
def roll_vector(orientation: FloatArray, sine: FloatArray, cosine: FloatArray) -> None:
    """Fill the roll's sine and cosine, times cos(pitch) and the quaternion's squared norm.

    Args:
        orientation: shape (n, 4).
        sine: output, shape (n,).
        cosine: output, shape (n,).
    """
    rows = len(sine) // SIZE
    for i in range(rows):
        x, y, z, w = _quaternions(orientation, i)
        store(sine, i, 2.0 * (w * x + y * z))
        store(cosine, i, (w * w - x * x) + (z * z - y * y))
    for i in range(SIZE * rows, len(sine)):
        x, y, z, w = orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3]
        sine[i] = 2.0 * (w * x + y * z)
        cosine[i] = (w * w - x * x) + (z * z - y * y)


@entry
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


@entry
def force_vector(
    force: FloatArray, across: FloatArray, along: FloatArray, size: FloatArray
) -> None:
    """Fill (-f_y, f_z), turned upwards in the case, and its size.

    A force that would throw the weight out of the top of the case counts as negative: the pull
    then passes through zero smoothly, and the slack thread is found there.

    Args:
        force: shape (n, 3).
        across: output, to starboard in the case [m/s2], shape (n,).
        along: output, never negative [m/s2], shape (n,).
        size: output, negative where the force was turned [m/s2], shape (n,).
    """
    rows = len(size) // SIZE
    for i in range(rows):
        a, b, c = load(force, 3 * i), load(force, 3 * i + 1), load(force, 3 * i + 2)
        y = with_lane(with_lane(splat(lane(a, 1)), 1, lane(a, 4)), 2, lane(a, 7))
        y = with_lane(with_lane(with_lane(y, 3, lane(b, 2)), 4, lane(b, 5)), 5, lane(c, 0))
        y = with_lane(with_lane(y, 6, lane(c, 3)), 7, lane(c, 6))
        z = with_lane(with_lane(splat(lane(a, 2)), 1, lane(a, 5)), 2, lane(b, 0))
        z = with_lane(with_lane(with_lane(z, 3, lane(b, 3)), 4, lane(b, 6)), 5, lane(c, 1))
        z = with_lane(with_lane(z, 6, lane(c, 4)), 7, lane(c, 7))
        store(across, i, -y)
        store(along, i, z)
        store(size, i, root(y * y + z * z))
        if least(z) < 0.0:
            for k in range(SIZE * i, SIZE * i + SIZE):
                across[k], along[k], size[k] = _upwards(force[k, 1], force[k, 2])
    for i in range(SIZE * rows, len(size)):
        across[i], along[i], size[i] = _upwards(force[i, 1], force[i, 2])


@inlined
def _upwards(y: float, z: float) -> tuple[float, float, float]:
    up = -1.0 if z < 0.0 else 1.0
    return -up * y, abs(z), up * math.sqrt(y * y + z * z)


@entry
def unwrap(angle: FloatArray, turns: int, last: float) -> tuple[int, float]:
    """Add whole turns in place, so that no step exceeds half a turn; return turns and last angle.

    Args:
        angle: in [-pi, pi], shape (n,).
        turns: whole turns of the angle before these.
        last: that angle, in (-pi, pi].
    """
    narrow = abs(last) < 0.5 * math.pi
    for i in range(len(angle)):
        narrow &= abs(angle[i]) < 0.5 * math.pi
    if narrow and len(angle):
        last = angle[-1]
        for i in range(len(angle)):
            angle[i] += 2.0 * math.pi * turns
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
