"""The samples a moving clock still needs, and the forcing they make.

A piece runs from one sample to the next. It is used as soon as its interpolation windows are
complete: at most four samples later, so that stages may lag by `LOOKAHEAD` samples.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tauto_core.motion.forcing import Forcing
from tauto_core.samples import FloatArray, ImuSamples, IntArray, State, take
from tauto_core.scene.errors import PropagationError
from tauto_core.ship.imu import attitude
from tauto_core.ship.interpolation import (
    FORCE_BEFORE,
    FORCE_POINTS,
    ROLL_BEFORE,
    ROLL_POINTS,
    polynomials,
)

BRIDGED_STEPS = 1.5
CROWDED_PART = 4
"""A sample less than this part of a step after the last one is left out: polynomials through
roll and roll rate at two instants δ apart multiply their noise by (step/δ)³."""


class MotionBuffer:
    """Turns motion samples into forcing, the same whatever batches they come in.

    Args:
        apparent_vertical: the neutral line is the apparent vertical, not the case's.
        apparent_gravity: the pull follows the apparent gravity.
        still: the platform lies still: samples only pace the run.
        step_ns: nominal time between samples; longer pieces count as bridged, samples that crowd
            within a quarter of it (or of the last step, where shorter) are left out [ns].
        max_gap_s: longest piece that is interpolated; None where samples only pace [s].
    """

    def __init__(
        self,
        *,
        apparent_vertical: bool,
        apparent_gravity: bool,
        still: bool,
        step_ns: int,
        max_gap_s: float | None,
    ) -> None:
        self._apparent_vertical = apparent_vertical and not still
        self._apparent_gravity = apparent_gravity and not still
        self._still = still
        self._step_ns = step_ns
        self._max_gap_s = max_gap_s
        self._times: IntArray = np.empty(0, np.int64)
        self._data: dict[str, FloatArray] = {name: np.empty(0) for name in self._channels()}
        self._first = 0
        self._next = 0
        self._rolls = 0
        self._last_roll = 0.0
        self.bridged = 0
        self.crowded = 0

    def add(self, imu: ImuSamples, origin_ns: int) -> None:
        """Take screened samples; times count from the origin."""
        kept = self._spaced(imu.stamp_ns - origin_ns)
        self.crowded += len(kept) - int(np.count_nonzero(kept))
        if not kept.any():
            return
        imu = take(imu, kept)
        self._times = np.concatenate([self._times, imu.stamp_ns - origin_ns])
        if self._data:
            new = self._channel_values(imu)
            for name, known in self._data.items():
                self._data[name] = np.concatenate([known, new[name]])

    def _channels(self) -> tuple[str, ...]:
        """Return the names of what has to be interpolated."""
        if self._still:
            return ()
        tilt = ('tilt',) if self._apparent_vertical else ()
        gravity = ('gravity',) if self._apparent_gravity else ()
        return ('roll', 'roll_rate', *tilt, *gravity)

    def _channel_values(self, imu: ImuSamples) -> dict[str, FloatArray]:
        felt = attitude(imu)
        rolls = self._rolls + np.cumsum(self._wraps(felt.roll))
        self._rolls, self._last_roll = int(rolls[-1]), float(felt.roll[-1])
        # A force that would throw the weight out of the top of the case counts as negative: the
        # pull then passes through zero smoothly, and the slack thread is found there.
        up = np.where(felt.force_z < 0.0, -1.0, 1.0)
        new = {'roll': felt.roll + 2.0 * np.pi * rolls, 'roll_rate': felt.roll_rate}
        if self._apparent_vertical:
            new['tilt'] = np.arctan2(-up * felt.force_y, up * felt.force_z)
        if self._apparent_gravity:
            new['gravity'] = up * np.hypot(felt.force_y, felt.force_z)
        return new

    def _spaced(self, times: IntArray) -> NDArray[np.bool_]:
        """Return which samples keep their distance, judged by the nominal or the last step."""
        past = [int(time) for time in self._times[-2:]]
        kept = np.ones(len(times), np.bool_)
        distances = np.diff(times, prepend=self._times[-1:])
        if self._still or np.all(CROWDED_PART * distances >= self._step_ns):
            return kept
        for i, time in enumerate(times.tolist()):
            step = min(self._step_ns, past[-1] - past[-2]) if len(past) == 2 else self._step_ns
            kept[i] = not past or CROWDED_PART * (time - past[-1]) >= step
            if kept[i]:
                past = [*past[-1:], time]
        return kept

    def _wraps(self, roll: FloatArray) -> IntArray:
        """Return by how many turns each roll must be shifted more than the one before it."""
        jump = np.diff(roll, prepend=self._last_roll)
        return np.where(jump < -np.pi, 1, np.where(jump > np.pi, -1, 0))

    def forcing(self, log_ns: int, end_ns: int | None, *, final: bool) -> Forcing | None:
        """Return the forcing over the pieces that are complete, None where there is none.

        Args:
            log_ns: time between logged instants [ns].
            end_ns: no span goes beyond this time [ns]; None: no end.
            final: no more samples will come: windows at the end become one-sided.

        Raises:
            PropagationError: the next piece is longer than `max_gap_s`; the call before gave
                all that comes before it.
        """
        pieces = self._before_gap(self._ready(end_ns, final=final))
        if not len(pieces):
            return None
        times = self._times
        stop = times[pieces[-1] + 1] if end_ns is None else min(times[pieces[-1] + 1], end_ns)
        start = times[pieces[0]]
        logs = np.arange(start // log_ns + 1, stop // log_ns + 1) * log_ns
        joints = times[pieces + 1]
        ends = _merged(joints[joints <= stop], logs)
        begins = np.concatenate([[start], ends[:-1]])
        piece = np.searchsorted(times, begins, 'right') - 1
        length = times[piece + 1] - times[piece]
        spans = Forcing(
            length_s=np.asarray(length * 1e-9, np.float64),
            begin=(begins - times[piece]) / length,
            end=(ends - times[piece]) / length,
            end_ns=ends,
            logged=ends % log_ns == 0,
            **self._polynomials(piece, final=final),
        )
        self._next = self._first + int(pieces[-1]) + 1
        self._forget()
        return spans

    def _windows(self) -> tuple[tuple[int, int], ...]:
        """Return (samples before the piece, samples in all) of the windows in use."""
        roll = (ROLL_BEFORE, ROLL_POINTS)
        if self._apparent_vertical or self._apparent_gravity:
            return roll, (FORCE_BEFORE, FORCE_POINTS)
        return (roll,)

    def _ready(self, end_ns: int | None, *, final: bool) -> IntArray:
        """Return the indices of the complete pieces not yet used, in the buffer."""
        index = np.arange(self._next - self._first, len(self._times) - 1)
        if not self._still and not final:
            for before, points in self._windows():
                last = np.maximum(index + self._first - before, 0) + points - 1
                index = index[last < self._first + len(self._times)]
        if end_ns is not None:
            index = index[self._times[index] < end_ns]
        return index

    def _before_gap(self, pieces: IntArray) -> IntArray:
        """Return the pieces before the first that is too long; raise where that is the first."""
        length = self._times[pieces + 1] - self._times[pieces]
        if self._max_gap_s is not None:
            long = np.flatnonzero(length > self._max_gap_s * 1e9)
            if len(long) and long[0] == 0:
                raise PropagationError(
                    f'no ship motion for {length[0] * 1e-9:.6g} s; at most '
                    f'{self._max_gap_s:g} s are interpolated. Repair the source of ship/imu and '
                    'start again',
                    float(self._times[pieces[0]] * 1e-9),
                )
            if len(long):
                pieces, length = pieces[: long[0]], length[: long[0]]
        self.bridged += int(np.count_nonzero(length > BRIDGED_STEPS * self._step_ns))
        return pieces

    def _polynomials(self, piece: IntArray, *, final: bool) -> dict[str, FloatArray | None]:
        if self._still:
            return {}
        width = max(2 * ROLL_POINTS, FORCE_POINTS)
        roll = self._channel('roll', 'roll_rate', ROLL_BEFORE, ROLL_POINTS, piece, width, final)
        result: dict[str, FloatArray | None] = {'neutral': roll}
        force = (FORCE_BEFORE, FORCE_POINTS, piece, width, final)
        if self._apparent_vertical:
            result['case'] = roll
            result['neutral'] = roll + self._channel('tilt', None, *force)
        if self._apparent_gravity:
            result['gravity'] = self._channel('gravity', None, *force)
        return result

    def _channel(
        self,
        name: str,
        rate: str | None,
        before: int,
        points: int,
        piece: IntArray,
        width: int,
        final: bool,
    ) -> FloatArray:
        have = self._first + len(self._times)
        points = min(points, have)
        first = np.maximum(piece + self._first - before, 0)
        if final:
            first = np.minimum(first, have - points)
        slopes = None if rate is None else self._data[rate]
        found = polynomials(
            self._times, self._data[name], slopes, first - self._first, points, piece
        )
        return np.pad(found, ((0, 0), (0, width - found.shape[1])))

    def _forget(self) -> None:
        """Drop the samples no later window can reach."""
        drop = max(self._next - FORCE_POINTS - self._first, 0)
        self._times = self._times[drop:]
        self._data = {name: values[drop:] for name, values in self._data.items()}
        self._first += drop

    def state(self) -> State:
        """Return samples and counters."""
        return {
            'times': self._times.copy(),
            'data': {name: values.copy() for name, values in self._data.items()},
            'first': self._first,
            'next': self._next,
            'rolls': self._rolls,
            'last_roll': self._last_roll,
            'bridged': self.bridged,
            'crowded': self.crowded,
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self._times = np.array(state['times'])
        self._data = {name: np.array(values) for name, values in state['data'].items()}
        self._first, self._next = state['first'], state['next']
        self._rolls, self._last_roll = state['rolls'], state['last_roll']
        self.bridged, self.crowded = state['bridged'], state['crowded']


def _merged(joints: IntArray, logs: IntArray) -> IntArray:
    """Return two increasing arrays as one; mostly the second is part of the first."""
    places = np.searchsorted(joints, logs)
    inside = places < len(joints)
    new = np.concatenate([logs[inside][joints[places[inside]] != logs[inside]], logs[~inside]])
    return joints if not len(new) else np.union1d(joints, new)
