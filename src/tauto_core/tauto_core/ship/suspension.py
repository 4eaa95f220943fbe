"""The clock's case hung in the ship, on an axle or in gimbals (theory/suspension.md).

`Suspension` turns the ship's motion into the reading of a sensor fixed in the case at the clock.
The ship's sensor is at the centre of the bearing or of the gimbals' pivots. Without friction an
axle transmits only the acceleration. The contact force acts along its normal, so the specific
force at the case's centre of gravity, the place of the clock, points along θ with the size N/M: θ
is the apparent vertical, N/M the apparent gravity. The sensor reads (N/M) (sin(φ − θ), cos(φ − θ))
to port and up.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tauto_core.kernels import entry
from tauto_core.motion import smooth_tolerance
from tauto_core.motion.forcing import beyond_small_angles, lifted_off
from tauto_core.motion.gauss_step import sine_versine
from tauto_core.motion.lanes import SIZE, lane, larger, largest, lowest, splat
from tauto_core.motion.suspended_case import BearingMotion, CaseMotion, contact_force
from tauto_core.samples import FloatArray, HungImu, Stateful
from tauto_core.scene import Scene
from tauto_core.ship.buffer import InCommon, MotionBuffer, SharedBuffers, sensed_step_ns
from tauto_core.ship.imu import Sensed, contiguous, in_parts
from tauto_core.ship.kernels import eight, store_forces
from tauto_core.ship.suspensions import SuspensionKind

# -----------------------------------------------------------------------------
# Whether the axle of a suspended case stays in its bearing, also between samples
# (theory/suspension.md).
#
# The contact force over the mass is P/(1 + (c/k)² sin²δ) with δ = φ − θ and
#
#     P = (g + z̈) cos θ − ÿ sin θ + e θ̇² + c φ̇² cos δ,
#
# so contact is lost when P falls to 0. Between two instants P is approximated by the cubic
# through its values and slopes, both in closed form. If the fast mode turns by ωh, the cubic is
# off by at most (2ωh)⁴/384 of the amplitude of P in that mode, 1e-3 at ωh = 0.4.


class HungCase(NamedTuple):
    """A case hung at small angles.

    Attributes:
        e: support's radius less the axle's [m].
        c: depth of the centre of gravity below the axle's centre [m].
        k: radius of gyration [m].
        gravity: g [m/s2], of the equations of small angles.
    """

    e: float
    c: float
    k: float
    gravity: float


class BearingForce(NamedTuple):
    """The specific force at the bearing and its slope, arrays of shape (n,) [m/s2, m/s3]."""

    sway: FloatArray
    lift: FloatArray
    sway_rate: FloatArray
    lift_rate: FloatArray


def force_at(bearing: BearingMotion, x: FloatArray) -> BearingForce:
    """Return the specific force at a place of each part's piece, 0 ≤ x ≤ 1, (Σ parts,)."""
    piece = bearing.piece
    channels = []
    for coefficients in (bearing.sway, bearing.lift):
        value, slope = np.zeros((2, len(x)))
        for j in range(coefficients.shape[1] - 1, -1, -1):
            slope = slope * x + value
            value = value * x + coefficients[piece, j]
        channels.append((value, slope / (bearing.length_ns[piece] * 1e-9)))
    (sway, sway_rate), (lift, lift_rate) = channels
    return BearingForce(sway, lift, sway_rate, lift_rate)


def lost_at(
    case: HungCase, bearing: BearingMotion, at_begin: CaseMotion, at_end: CaseMotion
) -> float | None:
    """Return the time of the first loss of contact [s] from the start, or `None`.

    `at_begin` and `at_end` are the case's motion at both ends of each part, all (Σ parts,).
    """
    end, end_ns, piece = bearing.end, bearing.end_ns, bearing.piece
    is_first = np.concatenate([[True], piece[1:] != piece[:-1]])
    begin = np.where(is_first, 0.0, np.roll(end, 1))
    begin_ns = np.where(is_first, bearing.begin_ns[piece], np.roll(end_ns, 1))
    length = (end_ns - begin_ns) * 1e-9
    ends, slopes = np.empty((2, 2, len(end)))
    for side, (motion, x) in enumerate(((at_begin, begin), (at_end, end))):
        force = force_at(bearing, x)
        ends[side] = pressing(case, motion, force.sway, force.lift)
        slopes[side] = length * pressing_rate(case, motion, force)
    loss = first_loss(ends, slopes)
    if loss is None:
        return None
    stretch, share = loss
    return float(begin_ns[stretch] * 1e-9 + share * length[stretch])


def pressing(case: HungCase, motion: CaseMotion, sway: FloatArray, lift: FloatArray) -> FloatArray:
    """Return P [m/s2], (n,)."""
    pressed = lift * np.cos(motion.theta) - sway * np.sin(motion.theta)
    pressed += case.e * motion.theta_rate**2
    pressed += case.c * np.cos(motion.phi - motion.theta) * motion.phi_rate**2
    return np.asarray(pressed)


def pressing_rate(case: HungCase, motion: CaseMotion, force: BearingForce) -> FloatArray:
    """Return dP/dt at small angles [m/s3], (n,) (theory/suspension.md)."""
    e, c, k, gravity = case
    theta, phi, theta_rate, phi_rate = (
        motion.theta,
        motion.phi,
        motion.theta_rate,
        motion.phi_rate,
    )
    delta = phi - theta
    phi_bend = -gravity * c / (k * k) * delta
    theta_bend = -(force.sway + gravity * theta + c * phi_bend) / e
    sine, cosine = np.sin(theta), np.cos(theta)
    rate = force.lift_rate * cosine - force.sway_rate * sine
    rate -= (force.lift * sine + force.sway * cosine) * theta_rate
    rate += 2.0 * e * theta_rate * theta_bend
    rate += 2.0 * c * phi_rate * phi_bend * np.cos(delta)
    rate -= c * phi_rate**2 * np.sin(delta) * (phi_rate - theta_rate)
    return np.asarray(rate)


def first_loss(ends: FloatArray, slopes: FloatArray) -> tuple[int, float] | None:
    """Return the first interval in which P reaches 0, and the fraction of it, or `None`.

    `ends` has P at beginning and end of n intervals, `slopes` dP/dx there for x from 0 to 1, both
    (2, n).
    """
    a, b = ends
    # a + b₁x + b₂x² + b₃x³, the highest power first
    second, third = 3.0 * (b - a) - 2.0 * slopes[0] - slopes[1], slopes.sum(axis=0) - 2.0 * (b - a)
    cubics = np.stack([third, second, slopes[0], a])
    # a slope at an end adds at most 4/27 of itself to the cubic
    dips = np.maximum(-slopes[0], 0.0) + np.maximum(slopes[1], 0.0)
    low = np.minimum(a, b) - 4.0 / 27.0 * dips
    for stretch in np.flatnonzero(low <= 0.0).tolist():
        if a[stretch] <= 0.0:
            return stretch, 0.0
        # the rounding of a cubic, and of its roots
        cubic = cubics[:, stretch]
        roots = np.roots(np.where(np.abs(cubic) > 1e-14 * np.abs(cubic).max(), cubic, 0.0))
        real = roots.real[np.abs(roots.imag) < 1e-9]
        shares = real[(real > -1e-12) & (real < 1.0 + 1e-12)]
        if shares.size:
            return stretch, min(max(float(shares.min()), 0.0), 1.0)
    return None


SMALL_ANGLE = 0.5
"""Largest tilt [rad] for the equations of small angles, at which sin differs by 4 %."""

SURELY_PRESSES = 0.5
"""Contact force over the mass and g beyond which no loss is sought between samples.

A mode that turns by ωh ≤ 1.2 from sample to sample falls between them by at most 1 − cos(½ωh) =
0.18 of its amplitude. To fall from ½ g to 0 it needs 2.8 g, with which samples are negative.
"""


@entry
def _feel(
    case: HungCase, motion: CaseMotion, lean: FloatArray, pull: FloatArray
) -> tuple[float, float]:
    """Fill direction and size of the specific force at the clock (`samples.HungImu`).

    Return the least N/M on an axle, and the largest of |θ| and |φ|. Outputs are padded to
    a multiple of eight. Each sample is computed by itself.
    """
    n, press = len(motion.phi), math.inf
    widest = splat(0.0)
    for i in range(len(lean) // SIZE):
        theta, phi = eight(motion.theta, i), eight(motion.phi, i)
        rates = eight(motion.theta_rate, i), eight(motion.phi_rate, i)
        sway, lift = eight(motion.sway, i), eight(motion.lift, i)
        if motion.phi_bend is None:
            contact, _, _, sine, cosine = contact_force(
                (case.e, case.c, case.k), theta, phi - theta, rates, sway, lift
            )
            y, z = contact * sine, contact * cosine
            if SIZE * i + SIZE <= n:
                press = min(press, lowest(contact))
            else:
                for r in range(n - SIZE * i):
                    press = min(press, lane(contact, r))
            widest = larger(larger(widest, theta), phi)
        else:
            sine, versine = sine_versine(phi)
            cosine = 1.0 - versine
            y = sway * cosine + lift * sine + case.c * eight(motion.phi_bend, i)
            z = lift * cosine - sway * sine + case.c * (rates[1] * rates[1])
        store_forces(y, z, i, lean, pull)
    return press, largest(widest)


class BearingBuffer(MotionBuffer):
    """Turns samples into polynomials of the specific force at the bearing, piece by piece.

    With friction in the bearing the roll is a third channel. The force is taken in the athwartship
    plane fixed to the ship, or for gimbals in the upright plane.
    """

    def __init__(self, scene: Scene, hung: SuspensionKind, *, max_gap_s: float | None) -> None:
        self._rolls = hung.link == 0.0
        super().__init__(
            apparent_vertical=True,
            apparent_gravity=True,
            still=False,
            step_ns=scene.step_ns,
            max_gap_s=max_gap_s,
            plane=hung.plane or 'ship',
        )
        self._felt_ns = sensed_step_ns(scene)

    def channel_names(self) -> tuple[str, ...]:
        """Return the names of both components of the specific force, and of the roll."""
        return ('sway', 'lift', 'roll', 'roll_rate') if self._rolls else ('sway', 'lift')

    def fill(self, imu: Sensed | HungImu, new: dict[str, FloatArray]) -> None:
        """Fill in ÿ and g + z̈: the specific force turned by the roll (theory/ship.md)."""
        from tauto_core.ship import kernels  # kernels

        assert not isinstance(imu, HungImu)
        roll, rate = new.get('roll'), new.get('roll_rate')
        upright = self._plane == 'vertical'
        for rows, part in in_parts(imu, self._rolls, True):
            orientation, force = contiguous(part.orientation), contiguous(part.linear_acceleration)
            sway, lift = new['sway'][rows], new['lift'][rows]
            kernels.level_force_of(orientation, force, upright, sway, lift)
            if roll is not None and rate is not None:
                velocity = contiguous(part.angular_velocity)
                kernels.roll_of(orientation, velocity, roll[rows], rate[rows])
        if roll is not None:
            self._turns, self._last_roll = kernels.unwrap(roll, self._turns, self._last_roll)

    def first(self) -> tuple[float, ...]:
        """Return ÿ and g + z̈ [m/s2] at the first sample and, with friction, ρ and ρ̇."""
        return tuple(float(values[0]) for values in self._data.values())

    def motion(self, *, final: bool) -> BearingMotion | None:
        """Return the motion over the complete pieces, or `None`."""
        latest = 2**63 - 1
        pieces = self.ready(latest, latest, final=final)
        if not len(pieces.begin):
            return None
        begin, end = self._times[pieces.begin], self._times[pieces.end]
        motion = BearingMotion(
            begin_ns=begin,
            length_ns=end - begin,
            parts=-(-(end - begin) // self._felt_ns),
            sway=self.fitted('sway', pieces),
            lift=self.fitted('lift', pieces),
            roll=self.fitted('roll', pieces, self._data['roll_rate']) if self._rolls else None,
        )
        self.forget(pieces)
        return motion


class Suspension(Stateful):
    """Turns samples of ship/imu into a clock's motion in the case, up to four samples later.

    At the start the case hangs at rest in equilibrium: θ = φ along the apparent vertical (at small
    angles −ÿ/g), both rates 0.

    Args:
        scene: one with a suspension.
        max_gap_s: longest time between samples that is interpolated [s].

    Raises:
        SceneError: no sampling of the ship's motion resolves the fast mode.
    """

    state_names = ('released', 'last', 'buffer', 'swing')

    def __init__(self, scene: Scene, *, max_gap_s: float) -> None:
        assert scene.suspension is not None
        hung = scene.suspension
        self._large = hung.large_angles
        self._case = HungCase(hung.link, hung.depth, hung.gyration_radius, scene.g)
        tolerance = scene.solver.tolerance if scene.solver else None
        if scene.accuracy is not None:
            tolerance = smooth_tolerance(scene.accuracy)
        self._swing = hung.swing(scene.g, tolerance)
        self._buffer = BearingBuffer(scene, hung, max_gap_s=max_gap_s)
        self._released = False
        self._last = np.zeros(4)

    @property
    def bridged(self) -> int:
        """Number of gaps in the ship's motion that were interpolated."""
        return self._buffer.bridged

    @property
    def crowded(self) -> int:
        """Number of the ship's samples that were dropped because they are too close together."""
        return self._buffer.crowded

    def feed(self, imu: Sensed, origin_ns: int) -> HungImu | None:
        """Take screened samples and return the case's samples that they determine, if any.

        Raises:
            PropagationError: the axle lifts off, the swing is too large, a gap in the motion.
        """
        if not len(imu.stamp_ns):
            return None
        self._buffer.add(imu, origin_ns)
        return self._advance(origin_ns, final=False)

    def finish(self, origin_ns: int) -> HungImu | None:
        """Return the remaining samples, interpolated with one-sided windows."""
        return self._advance(origin_ns, final=True)

    def _advance(self, origin_ns: int, *, final: bool) -> HungImu | None:
        start: tuple[float, ...] | None = None
        if not self._released and self._buffer.has_samples:  # in equilibrium
            sway, lift, *rolling = self._buffer.first()
            if not lift > 0.0:
                raise lifted_off(0.0)
            tilt = self._swing.release(sway, lift, *rolling)
            self._last = np.array([tilt, tilt, 0.0, 0.0])
            rubbed = self._swing.bend_at_rest(rolling[1]) if rolling else 0.0
            across, upright = self._case.c * rubbed, lift * math.cos(tilt) - sway * math.sin(tilt)
            start = tilt, 0.0, math.atan2(-across, upright), math.hypot(across, upright)
        bearing = self._buffer.motion(final=final)
        if bearing is None:
            return None
        case = self._swing.advance(bearing)
        n, stamps = len(case.phi), bearing.end_ns
        lean, pull = np.empty((2, -(-n // SIZE) * SIZE))
        press, widest = _feel(self._case, case, lean, pull)
        if case.phi_bend is None and self._large:
            if not press > 0.0:  # at a sample. The propagator checks between samples
                lost = pressing(self._case, case, case.sway, case.lift) <= 0.0
                raise lifted_off(float(stamps[np.argmax(lost)] * 1e-9))
        elif case.phi_bend is None:
            self._check_small(case, bearing, press, widest)
        columns = [case.phi, case.phi_rate, lean[:n], pull[:n]]
        if start is not None:
            self._released = True
            stamps = np.concatenate([bearing.begin_ns[:1], stamps])
            columns = [np.append(*pair) for pair in zip(start, columns, strict=True)]
        return HungImu(stamps + origin_ns, *columns)

    def _check_small(
        self, case: CaseMotion, bearing: BearingMotion, press: float, widest: float
    ) -> None:
        """Refuse a case that lifts off or swings too wide, also between samples.

        The interval between two batches is checked with the later one. `press` is the least
        contact force, `widest` the largest angle.
        """
        last_row, self._last = self._last, np.array([column[-1] for column in case[:4]])
        presses = press > SURELY_PRESSES * self._case.gravity
        if presses and widest <= SMALL_ANGLE:
            return
        at_begin = case._replace(
            **{
                name: np.append(last_row[i], getattr(case, name)[:-1])
                for i, name in enumerate(CaseMotion._fields[:4])
            }
        )
        lost_s = None if presses else lost_at(self._case, bearing, at_begin, case)
        size = np.maximum(np.abs(case.theta), np.abs(case.phi))
        wide = np.flatnonzero(size > SMALL_ANGLE)
        if wide.size:
            at_s = float(bearing.end_ns[wide[0]] * 1e-9)
            if lost_s is None or at_s < lost_s:
                raise beyond_small_angles(float(size[wide[0]]), SMALL_ANGLE, at_s)
        if lost_s is not None:
            raise lifted_off(lost_s)


# -----------------------------------------------------------------------------
# A case in which several clocks of one sea hang.


class CaseInCommon(InCommon):
    """The suspension of one of several clocks that are fed in turn in one sea.

    Their cases move alike, so the first clock computes the motion. Arguments as for
    `Suspension`, and the clocks' buffers and `parts`, the key of their parts of the samples.
    """

    part: Suspension

    def __init__(
        self, scene: Scene, buffers: SharedBuffers, parts: object, *, max_gap_s: float
    ) -> None:
        words = repr(scene.suspension), repr(scene.solver)
        self.key = parts, scene.g, scene.step_ns, scene.accuracy, *words
        super().__init__(buffers.common(self.key, lambda: Suspension(scene, max_gap_s=max_gap_s)))

    def feed(self, imu: Sensed, origin_ns: int) -> HungImu | None:
        """Take screened samples and return the case's samples that they determine, if any."""
        return self.in_turn(lambda: self.part.feed(imu, origin_ns))

    def finish(self, origin_ns: int) -> HungImu | None:
        """Return the remaining samples, interpolated with one-sided windows."""
        return self.in_turn(lambda: self.part.finish(origin_ns))
