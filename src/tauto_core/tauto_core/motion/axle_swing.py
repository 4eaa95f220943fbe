"""The suspended case at any angles, moved over pieces of the bearing's motion."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.machines.modes import modes
from tauto_core.motion import axle
from tauto_core.motion.bearing import BearingMotion, CaseMotion
from tauto_core.motion.lanes import SIZE, WIDE_SIZE
from tauto_core.motion.limits import lifted_off, turned_over
from tauto_core.motion.step_size import TOLERANCE, settled_at
from tauto_core.motion.work import PLANE, make_work
from tauto_core.samples import State
from tauto_core.scene.errors import PropagationError

LONG = 1.0
"""Angle that the fast mode turns in a step beyond which sixteen stages cost less than eight."""


class AxleSwing:
    """The case under the full equations, a step or more for each part of a piece.

    Args:
        e: support's radius less the axle's [m], > 0.
        c: depth of the centre of gravity below the axle's centre [m], > 0.
        k: radius of gyration [m], > 0.
        gravity: g [m/s2]; it sets the rotating frame, while the acting force is g + z̈ of the
            pieces.
        tolerance: error allowed in a step relative to the state, if larger than TOLERANCE.
        step_s: length of the parts to come [s], which may be long: it decides the number of
            stages.
    """

    def __init__(
        self,
        e: float,
        c: float,
        k: float,
        gravity: float,
        *,
        tolerance: float | None = None,
        step_s: float = 0.0,
    ) -> None:
        own = modes(e, c, k * k)
        slow, fast = (square**0.5 for square in own.squared_frequencies(gravity))
        self._omega = slow, fast
        self._system = axle.SuspendedCase(e, c, k, own.B, own.B_prime)
        self._tolerance = max(tolerance or TOLERANCE, TOLERANCE)
        self._planes = np.zeros(axle.PLANES, PLANE)
        stages = WIDE_SIZE if fast * step_s > LONG else SIZE
        self._work = make_work(axle.PLANES, axle.NODES, stages)

    def release(self, sway: float, lift: float) -> float:
        """Start at rest, at the time 0, along the apparent vertical; return its direction [rad].

        Args:
            sway: ÿ of the bearing then [m/s2].
            lift: g + z̈ then [m/s2], > 0.
        """
        tilt = math.atan2(-sway, lift)
        c, slow, fast = self._system.c, self._system.tilt, self._system.tilt_prime
        q, other = tilt * (c - fast) / (c * (slow - fast)), tilt * (slow - c) / (c * (slow - fast))
        self._planes[:] = [(q, 0.0, 0.0, 0.0), (other, 0.0, 0.0, 0.0)]
        return tilt

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts.

        Raises:
            PropagationError: the axle lifts off, the case turns over, or no convergence.
        """
        piece, end_ns = bearing.piece, bearing.end_ns
        first = np.concatenate([[True], piece[1:] != piece[:-1]])
        begin = np.roll(bearing.end, 1)
        begin[first] = 0.0
        begin_ns = np.where(first, bearing.begin_ns[piece], np.roll(end_ns, 1))
        length = np.asarray((end_ns - begin_ns) * 1e-9, np.float64)
        rows = np.empty(len(piece), axle.ROW)
        parts = axle.Parts(piece, begin, bearing.end, length)
        code, part, fraction = axle.advance(
            self._system,
            self._omega,
            axle.Bearing(bearing.sway, bearing.lift),
            self._tolerance,
            settled_at(self._tolerance),
            self._planes,
            self._work,
            parts,
            rows,
        )
        if code != axle.OK:
            at_s = float(begin_ns[part] * 1e-9 + fraction * length[part])
            raise _failure(code, self._tolerance, at_s)
        names = rows.dtype.names or ()
        return CaseMotion(**{name: np.ascontiguousarray(rows[name]) for name in names})

    def state(self) -> State:
        """Return X and Y of both planes."""
        return {'planes': self._planes.copy()}

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self._planes = state['planes'].copy()


def _failure(code: int, tolerance: float, time_s: float) -> PropagationError:
    if code == axle.LIFTED_OFF:
        return lifted_off(time_s)
    if code == axle.TURNED_OVER:
        return turned_over(time_s)
    return PropagationError(
        f'no convergence to the tolerance {tolerance:g} of the suspended case. Raise '
        'ship.rate, or give the case a larger gyration_radius',
        time_s,
    )
