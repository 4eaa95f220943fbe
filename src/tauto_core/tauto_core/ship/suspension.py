"""The clock's case hung on a cylindrical axle in a bearing of the ship (Euler 1780; theory E3).

It takes the ship's motion, and returns what a sensor fixed in the case at the clock would read.
The bearing's centre is where the ship's sensor is. Of the ship's motion only its acceleration
reaches the case, since the axle lies in the bearing without friction. The contact pushes along its
normal alone, so the specific force at the centre of gravity of the case, where the clock is,
points along θ and has the size N/M: θ is the apparent vertical and N/M the apparent gravity. In
the case the sensor reads (N/M) (sin(φ − θ), cos(φ − θ)) to port and up.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.motion.forcing import beyond_small_angles, lifted_off
from tauto_core.motion.suspended_case import BearingMotion, CaseMotion, CaseSwing
from tauto_core.samples import FloatArray, ImuSamples, IntArray, PlanarImu, State
from tauto_core.scene import Scene
from tauto_core.ship.buffer import MotionBuffer
from tauto_core.ship.contact import Case, lost_at, pressing
from tauto_core.ship.felt_step import felt_step_ns
from tauto_core.ship.imu import attitude, imu_from_roll
from tauto_core.ship.planar import message

SMALL_ANGLE = 0.5
"""Largest tilt [rad] for the equations of small angles; there sin differs by 4 %."""


class _BearingBuffer(MotionBuffer):
    """Turns samples into polynomials of the specific force at the bearing, piece by piece."""

    def __init__(self, *, step_ns: int, felt_ns: int, max_gap_s: float) -> None:
        super().__init__(
            apparent_vertical=True,
            apparent_gravity=True,
            still=False,
            step_ns=step_ns,
            max_gap_s=max_gap_s,
        )
        self._felt_ns = felt_ns

    def _channels(self) -> tuple[str, ...]:
        return ('sway', 'lift')

    def _fill(self, imu: ImuSamples | PlanarImu, new: dict[str, FloatArray]) -> None:
        """Fill in ÿ and g + z̈: the specific force turned by the roll (theory E1)."""
        read = attitude(message(imu) if isinstance(imu, PlanarImu) else imu)
        c, s = np.cos(read.roll), np.sin(read.roll)
        new['sway'][:] = read.force_y * c - read.force_z * s
        new['lift'][:] = read.force_y * s + read.force_z * c

    def first(self) -> tuple[float, float]:
        """Return ÿ and g + z̈ at the first sample at hand [m/s2]."""
        return float(self._data['sway'][0]), float(self._data['lift'][0])

    def motion(self, *, final: bool) -> BearingMotion | None:
        """Return the motion over the pieces that are complete, None where there is none."""
        latest = 2**63 - 1
        pieces = self._ready(latest, latest, final=final)
        if not len(pieces.begin):
            return None
        begin, end = self._times[pieces.begin], self._times[pieces.end]
        found = BearingMotion(
            begin_ns=begin,
            length_ns=end - begin,
            parts=-(-(end - begin) // self._felt_ns),
            sway=self._channel('sway', None, pieces),
            lift=self._channel('lift', None, pieces),
        )
        self._next = self._first + int(pieces.end[-1])
        self._forget()
        return found


class Suspension:
    """Turns samples of ship/imu into those of a sensor in the case, up to four samples later.

    At the start the case hangs at rest in equilibrium: θ = φ along the apparent vertical (at small
    angles −ÿ/g), both rates 0.

    Args:
        scene: one with a suspension.
        max_gap_s: longest time between samples that is interpolated [s].

    Raises:
        SceneError: a fast mode that no sampling of the ship's motion resolves.
    """

    def __init__(self, scene: Scene, *, max_gap_s: float) -> None:
        assert scene.suspension is not None
        hung = scene.suspension
        self._large = hung.large_angles
        e = hung.support_radius - hung.axle_radius
        self._case = Case(e, hung.depth, hung.gyration_radius, scene.gravity)
        tolerance = scene.solver.tolerance if scene.solver else None
        self._swing = _swing_of(self._large, self._case, tolerance)
        self._buffer = _BearingBuffer(
            step_ns=scene.step_ns, felt_ns=felt_step_ns(scene), max_gap_s=max_gap_s
        )
        self._released = False
        self._last = np.zeros(4)

    @property
    def bridged(self) -> int:
        """Number of gaps in the ship's motion that were interpolated."""
        return self._buffer.bridged

    @property
    def crowded(self) -> int:
        """Number of samples of the ship that were left out because they are too close together."""
        return self._buffer.crowded

    def feed(self, imu: ImuSamples | PlanarImu, origin_ns: int) -> ImuSamples | None:
        """Take screened samples; return those of the case that are known by now, if any.

        Raises:
            PropagationError: the axle lifts off, the swing is too large, a gap in the motion.
        """
        if not len(imu.stamp_ns):
            return None
        self._buffer.add(imu, origin_ns)
        return self._advance(origin_ns, final=False)

    def finish(self, origin_ns: int) -> ImuSamples | None:
        """Return the remaining samples, interpolated with one-sided windows."""
        return self._advance(origin_ns, final=True)

    def _advance(self, origin_ns: int, *, final: bool) -> ImuSamples | None:
        first = None if self._released else self._release()
        bearing = self._buffer.motion(final=final)
        if bearing is None:
            return None
        case = self._swing.advance(bearing)
        delta = case.phi - case.theta
        wide = (self._case.c / self._case.k) * np.sin(delta)
        pressed = pressing(self._case, case, *bearing.at_ends())
        contact = pressed / (1.0 + wide * wide)
        if self._large:
            _check_contact(contact, bearing.end_ns)
        else:
            self._check_small(case, bearing, pressed)
        columns = [
            case.phi,
            case.phi_rate,
            contact * np.sin(delta),
            contact * np.cos(delta),
        ]
        stamps: IntArray = bearing.end_ns
        if first is not None:
            self._released = True
            stamps = np.concatenate([bearing.begin_ns[:1], stamps])
            columns = [
                np.concatenate([[at_start], column])
                for at_start, column in zip(first, columns, strict=True)
            ]
        return imu_from_roll(stamps + origin_ns, *columns)

    def _release(self) -> tuple[float, float, float, float] | None:
        """Put the case in equilibrium; return φ, φ̇ and the force in it."""
        if not self._buffer.has_samples:
            return None
        sway, lift = self._buffer.first()
        if not lift > 0.0:
            raise lifted_off(0.0)
        tilt = self._swing.release(sway, lift)
        self._last = np.array([tilt, tilt, 0.0, 0.0])
        return tilt, 0.0, 0.0, lift * math.cos(tilt) - sway * math.sin(tilt)

    def _check_small(self, case: CaseMotion, bearing: BearingMotion, pressed: FloatArray) -> None:
        """Refuse a case that lifts off or swings too wide, also between samples.

        The interval between two batches is checked with the later batch, so batches do not matter.
        """
        after = np.stack([case.theta, case.phi, case.theta_rate, case.phi_rate])
        before = np.concatenate([self._last[:, None], after[:, :-1]], axis=1)
        self._last = after[:, -1].copy()
        lost_s = lost_at(self._case, bearing, CaseMotion(*before), case, pressed)
        size = np.maximum(np.abs(case.theta), np.abs(case.phi))
        beyond = np.flatnonzero(size > SMALL_ANGLE)
        if beyond.size:
            at_s = float(bearing.end_ns[beyond[0]] * 1e-9)
            if lost_s is None or at_s < lost_s:
                raise beyond_small_angles(float(size[beyond[0]]), SMALL_ANGLE, at_s)
        if lost_s is not None:
            raise lifted_off(lost_s)

    def state(self) -> State:
        """Return all that the next output depends on."""
        return {
            'released': self._released,
            'last': self._last.copy(),
            'buffer': self._buffer.state(),
            'swing': self._swing.state(),
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._released = state['released']
        self._last = np.array(state['last'])
        self._buffer.restore(state['buffer'])
        self._swing.restore(state['swing'])


def _check_contact(contact: FloatArray, end_ns: IntArray) -> None:
    """Refuse a case that lifts off at a sample; its propagator checks between samples."""
    lost = contact <= 0.0
    if np.any(lost):
        raise lifted_off(float(end_ns[np.argmax(lost)] * 1e-9))


def _swing_of(large: bool, case: Case, tolerance: float | None) -> CaseSwing:
    if large:
        from tauto_core.motion.suspended_case import AxleSwing  # imports kernels

        return AxleSwing(*case, tolerance=tolerance)
    from tauto_core.motion.suspended_case import AxleModes

    return AxleModes(*case)
