"""A ship that moves in all six ways: her harmonics at the clock, and the reading of an IMU there.

Level axes: x along her mean heading, y to port, z up. Her own axes follow from them by yaw ψ about
z (bow to port), pitch θ about y (bow down) and roll ρ about x (starboard down), in this order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, Literal, NamedTuple, TypeAlias, TypeVar

import numpy as np

from tauto_core.samples import FloatArray, ImuSamples, IntArray
from tauto_core.ship.imu import contiguous, sensed
from tauto_core.ship.waves import Encounter, Fades, Harmonics

if TYPE_CHECKING:
    from tauto_core.ship.hull import ClockPlace, Hull, Response

M = TypeVar('M', Harmonics, Fades)

ThreadPlane: TypeAlias = Literal['free', 'vertical', 'ship']
"""The plane in which the weight of a clock can follow the apparent vertical (G7 in hull.md).

`free`: a thread that leans in all directions. `vertical`: gimbals hold the wheel's axle level.
`ship`: the plane athwart that is fixed to the ship and pitches with her.
"""


@dataclass(frozen=True)
class SixMotions(Generic[M]):
    """The motions of a ship, each a sum of harmonics; displacements are those of the clock.

    Attributes:
        surge: forward [m].
        sway: to port [m].
        heave: up [m].
        roll: starboard down [rad].
        pitch: bow down [rad].
        yaw: bow to port [rad].
    """

    surge: M
    sway: M
    heave: M
    roll: M
    pitch: M
    yaw: M


def hull_answer(
    waves: Harmonics, hull: Hull, place: ClockPlace, course: Encounter
) -> SixMotions[Harmonics]:
    """Return the motions of a hull, at a place in her, in the waves that she meets.

    Args:
        waves: elevation amidships [m], with the frequencies of a ship at rest.
        hull: the ship with her weights.
        place: of the clock.
        course: speed and heading.

    Raises:
        HullError: a speed beyond the validity of the coefficients, or a place outside the hull.
    """
    hull.check_place(place)
    response = hull.response(waves.angular_frequency, course.heading, course.speed)
    return at_clock(waves, response, place, course)


def at_clock(
    waves: Harmonics, response: Response, place: ClockPlace, course: Encounter
) -> SixMotions[Harmonics]:
    """Return the motions at a place in a ship, in the waves that she meets.

    Args:
        waves: elevation at her origin [m], with the frequencies of a ship at rest, (n,).
        response: her motions in each of them.
        place: of the clock.
        course: speed and heading.
    """
    factors = np.concatenate((response.displacement(place), response.motions[:, 3:]), axis=1)
    return SixMotions(
        *(
            course.answer(waves, waves.amplitude * np.abs(factor), np.angle(factor))
            for factor in factors.T
        )
    )


class Turned(NamedTuple):
    """Angles of the ship and their derivatives, each [rad] or [rad/s], (n,)."""

    roll: FloatArray
    pitch: FloatArray
    yaw: FloatArray


def imu_from_motions(
    stamp_ns: IntArray,
    angle: Turned,
    rate: Turned | None,
    acceleration: tuple[FloatArray, FloatArray, FloatArray] | None,
    gravity: FloatArray | float,
) -> ImuSamples:
    """Return the reading of an IMU fixed to the ship beside the clock.

    Specific force f = Rᵀ(a + g ẑ), R = R_z(ψ) R_y(θ) R_x(ρ), and the turning in her own axes

        ω_x = ρ̇ − ψ̇ sin θ,  ω_y = θ̇ cos ρ + ψ̇ cos θ sin ρ,  ω_z = −θ̇ sin ρ + ψ̇ cos θ cos ρ.

    The bits of a sample depend on its own values alone, and not on whether all are needed.

    Args:
        stamp_ns: true time of each sample [ns], (n,).
        angle: roll, pitch, yaw.
        rate: their derivatives; None: the angular velocity is not needed, and is empty.
        acceleration: of the clock forward, to port and up, in level axes [m/s²]; None: the force
            is not needed, and is empty.
        gravity: gravity, less Eötvös' term [m/s²].
    """
    from tauto_core.ship.kernels import encode_six  # imports kernels

    n = len(stamp_ns)
    whole = -(-n // 8) * 8
    orientation = np.empty((whole, 4))
    turning = None if rate is None else np.empty((whole, 3))
    force = None if acceleration is None else np.empty((whole, 3))
    parts: list[FloatArray | None] = [*angle, *(rate or (None,) * 3), None, None, None]
    if acceleration is not None:
        forward, port, up = acceleration
        parts[6:] = forward, port, up + gravity
    given = (None if part is None else contiguous(part) for part in parts)
    encode_six(*given, orientation, turning, force)
    none = np.empty((0, 3))
    return sensed(
        stamp_ns,
        orientation[:n],
        none if turning is None else turning[:n],
        none if force is None else force[:n],
    )


def force_in_plane(imu: ImuSamples, plane: ThreadPlane) -> FloatArray:
    """Return the specific force that a clock's thread can follow, its last two columns.

    They are athwart and upright in the axes of the case; the first, along the axle, does not
    count. Where the thread leans freely its part is added to the size of the rest, along their
    direction: the weight pulls with all of |f|, the wheel feels the direction athwart alone.

    Args:
        imu: samples that `imu.screen` has passed.
        plane: see `ThreadPlane`.
    """
    force = imu.linear_acceleration
    if plane == 'ship':
        return force
    from tauto_core.ship import kernels  # kernels

    orientation, force = contiguous(imu.orientation), contiguous(force)
    # a sample of a ship that only rolls has the same bits in all planes
    if kernels.rolls_alone(orientation, force):
        return force
    felt = np.empty((-(-len(force) // 8) * 8, 3))
    kernels.force_in_plane(orientation, force, plane == 'vertical', felt)
    return felt[: len(force)]


def level_force(imu: ImuSamples) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the specific force forward, to port and up, in level axes that yaw with the ship.

    Args:
        imu: samples that `imu.screen` has passed.
    """
    x, y, z = (np.ascontiguousarray(imu.linear_acceleration[:, i]) for i in range(3))
    sr, cr, sp, cp = _roll_and_pitch(imu.orientation)
    aside, deck = cr * y - sr * z, sr * y + cr * z
    return cp * x + sp * deck, aside, cp * deck - sp * x


def _roll_and_pitch(orientation: FloatArray) -> tuple[FloatArray, ...]:
    """Return sine and cosine of roll and pitch, of quaternions of any norm (n, 4)."""
    qx, qy, qz, qw = (np.ascontiguousarray(orientation[:, i]) for i in range(4))
    # homogeneous in the quaternion; sine and cosine of the roll times cos θ
    square = (qx * qx + qy * qy) + (qz * qz + qw * qw)
    sr, cr = 2.0 * (qw * qx + qy * qz), (qw * qw - qx * qx) + (qz * qz - qy * qy)
    cp = np.hypot(sr, cr)
    return sr / cp, cr / cp, 2.0 * (qw * qy - qz * qx) / square, cp / square
