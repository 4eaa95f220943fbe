"""The readings of a `PlanarImu`, with the same bits as from its samples as messages."""

from __future__ import annotations

from tauto_core.samples import FloatArray, ImuSamples, PlanarImu
from tauto_core.ship.imu import imu_samples, plain


def message(imu: PlanarImu) -> ImuSamples:
    """Return the samples field for field as the message has them."""
    acceleration, heave = imu.accelerations()
    return imu_samples(
        imu.stamp_ns, imu.roll, imu.roll_rate, acceleration, heave, imu.height, imu.gravity
    )


def read_roll(imu: PlanarImu, roll: FloatArray, rate: FloatArray | None) -> None:
    """Fill in the roll as computed from the quaternion, and the roll rate."""
    from tauto_core.ship.kernels import planar_roll  # imports kernels

    planar_roll(plain(imu.roll), plain(imu.roll_rate), roll, rate)


def read_force(imu: PlanarImu, tilt: FloatArray | None, size: FloatArray | None) -> None:
    """Fill in direction and size of the specific force: see `kernels.force_of`."""
    from tauto_core.ship.kernels import planar_force  # imports kernels

    acceleration, heave = imu.accelerations()
    planar_force(
        plain(imu.roll),
        plain(imu.roll_rate),
        None if acceleration is None else plain(acceleration),
        None if heave is None else plain(heave),
        imu.height,
        imu.gravity,
        tilt,
        size,
    )
