"""The suspended case at any angles, moved over pieces of the bearing's motion."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.machines.modes import modes
from tauto_core.motion import axle, stepping
from tauto_core.motion.bearing import BearingMotion, CaseMotion
from tauto_core.motion.lanes import SIZE, WIDE_SIZE
from tauto_core.motion.limits import lifted_off, turned_over
from tauto_core.motion.outside import Pieces
from tauto_core.motion.step_size import TOLERANCE
from tauto_core.motion.stepped import tolerance_of
from tauto_core.motion.system import restore_record, state_of, state_type
from tauto_core.motion.work import make_work
from tauto_core.samples import State
from tauto_core.scene.errors import PropagationError

LONG = 1.0
"""Phase of the fast mode in a step [rad] beyond which sixteen stages cost less than eight."""


class AxleSwing:
    """Propagator of the case under the full equations, a step or more for each part of a piece.

    Args:
        e: support's radius less the axle's [m], > 0.
        c: depth of the centre of gravity below the axle's centre [m], > 0.
        k: radius of gyration [m], > 0.
        gravity: g [m/s2]; it sets the rotating frame, while the acting force is g + z̈ of the
            pieces.
        tolerance: error allowed in a step, relative to the state; at least TOLERANCE.
        step_s: length of the parts to come [s], which decides the number of stages; 0 where it
            is not known.
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
        self._own, self._system = own, axle.SuspendedCase(e, c, k, own.B, own.B_prime)
        stages = WIDE_SIZE if fast * step_s > LONG else SIZE
        self._tolerance = tolerance_of(
            max(tolerance or TOLERANCE, TOLERANCE), axle.ERROR_OF_LAST, 2.0 ** -(2 * stages + 1)
        )
        self._state = np.zeros((), state_type(axle.PLANES))
        self._work = make_work(axle.PLANES, axle.NODES, stages)

    def release(self, sway: float, lift: float) -> float:
        """Start at rest, at the time 0, along the apparent vertical; return its direction [rad].

        Args:
            sway: ÿ of the bearing then [m/s2].
            lift: g + z̈ then [m/s2], > 0.
        """
        tilt = math.atan2(-sway, lift)
        self._state = np.zeros((), state_type(axle.PLANES))
        self._state['planes']['x'] = self._own.coordinates_at(tilt, self._system.c)
        return tilt

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts.

        Raises:
            PropagationError: the axle lifts off, the case turns over, or no convergence.
        """
        # x counts the parts of a piece: equal ones then have equal lengths to the last bit, and
        # share the tables of their rotations
        piece, parts = bearing.piece, bearing.parts
        passed = (bearing.end_ns - bearing.begin_ns[piece]) * parts[piece]
        end = np.asarray(passed / bearing.length_ns[piece], np.float64)
        begin = np.roll(end, 1)
        begin[np.cumsum(parts) - parts] = 0.0
        length = np.asarray(bearing.length_ns * 1e-9 / parts, np.float64)[piece]
        sway, lift = (
            (channel / np.power(parts[:, None], np.arange(channel.shape[1], dtype=float)))[piece]
            for channel in (bearing.sway, bearing.lift)
        )
        rows = np.empty(len(piece), stepping.ROW)
        code, part, x = stepping.advance(
            self._system,
            self._omega,
            self._tolerance,
            math.inf,
            Pieces(length, sway, None, lift),
            stepping.Spans(begin, end, np.ones(len(piece), np.bool_)),
            self._state,
            self._work,
            rows,
        )
        if code != stepping.OK:
            at_s = float(bearing.begin_ns[piece[part]] * 1e-9 + x * length[part])
            raise _failure(code, self._tolerance.step, at_s)
        names = 'angle', 'coordinate', 'rate', 'speed'
        return CaseMotion(*(np.ascontiguousarray(rows[name]) for name in names))

    def state(self) -> State:
        """Return the running state of the driver, X and Y of both planes among it."""
        return state_of(self._state)

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        restore_record(self._state, state)


def _failure(code: int, tolerance: float, time_s: float) -> PropagationError:
    if code == stepping.SLACK:
        return lifted_off(time_s)
    if code == stepping.EDGE:
        return turned_over(time_s)
    return PropagationError(
        f'no convergence to the tolerance {tolerance:g} of the suspended case. Raise '
        'ship.rate, or give the case a larger gyration_radius',
        time_s,
    )
