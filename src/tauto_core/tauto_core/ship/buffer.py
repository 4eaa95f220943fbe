"""The samples that a moving clock still needs, and the forcing computed from them.

A piece runs from one sample to the next or over several. It is used as soon as its interpolation
windows are complete: at most four samples after its end, so that stages may lag by `LOOKAHEAD`
samples.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tauto_core.motion.forcing import Forcing, Polynomials, Window
from tauto_core.samples import FloatArray, ImuSamples, IntArray, PlanarImu, State, take
from tauto_core.scene import Scene
from tauto_core.scene.errors import PropagationError
from tauto_core.ship.felt_step import felt_step_ns
from tauto_core.ship.imu import plain
from tauto_core.ship.interpolation import (
    COARSE_BEFORE,
    COARSE_NS,
    FORCE_BEFORE,
    FORCE_POINTS,
    MAX_STRIDE,
    ROLL_BEFORE,
    ROLL_POINTS,
    Pieces,
    polynomials,
    window_nodes,
    windows,
)
from tauto_core.ship.planar import read_force, read_roll

BRIDGED_STEPS = 1.5
CROWDED_PART = 4
"""A sample less than 1/4 of a step after the last one is left out: polynomials through
roll and roll rate at two instants δ apart multiply their noise by (step/δ)³.
"""

_LATEST_NS = 2**63 - 1


PIECE_COST = 0.5
"""Cost of a piece in addition to that of its steps, in steps."""

WORTH = 0.9
"""Shorter pieces are used if they reduce the cost below this fraction."""


def samples_a_piece(scene: Scene, steps_in: Callable[[float], int] = lambda _: 1) -> int:
    """Return the number of samples in a piece, such that pieces end at logged instants.

    A polynomial over a longer piece is more accurate, since less of the piece is near the edge of
    the fitted window. Shorter pieces are used where whole steps fit them better.

    Args:
        scene: a scene that runs.
        steps_in: number of steps that the propagator takes in a piece of a given length [s].
    """
    if scene.lies_still:
        return 1
    step_ns = felt_step_ns(scene)
    logs = scene.log_interval_ns // step_ns
    most, *fewer = (n for n in range(MAX_STRIDE, 0, -1) if logs % n == 0)

    def cost(samples: int) -> float:
        return (PIECE_COST + steps_in(samples * step_ns * 1e-9)) / samples

    best = min(fewer, key=cost, default=most)
    return best if cost(best) < WORTH * cost(most) else most


class MotionBuffer:
    """Turns motion samples into forcing; the result does not depend on batches.

    Args:
        apparent_vertical: whether the neutral line is the apparent vertical, not fixed to the
            case.
        apparent_gravity: whether the pull is proportional to the apparent gravity.
        still: whether the platform lies still; samples then only set the pace of the run.
        step_ns: nominal time between samples [ns]. Longer steps count as bridged; samples within a
            quarter of it (or of the last step, where shorter) after the last one are left out.
        max_gap_s: longest time between samples that is interpolated [s]; None where samples only
            set the pace.
        stride: samples that a piece spans, 1 to 8, where they are evenly spaced and no logged
            instant falls inside.
        smooth: whether the motion is free of noise. The first pieces may then span as many samples
            as the others, with windows that begin at the first sample; such windows magnify noise
            a thousandfold.
        by_samples: whether a neutral line fixed to the case is given by samples, not fitted.
    """

    def __init__(
        self,
        *,
        apparent_vertical: bool,
        apparent_gravity: bool,
        still: bool,
        step_ns: int,
        max_gap_s: float | None,
        stride: int = 1,
        smooth: bool = False,
        by_samples: bool = False,
    ) -> None:
        if not 1 <= stride <= MAX_STRIDE:
            raise ValueError(f'stride = {stride}: must lie in [1, {MAX_STRIDE}]')
        self._apparent_vertical = apparent_vertical and not still
        self._apparent_gravity = apparent_gravity and not still
        self._still = still
        self._step_ns = step_ns
        self._max_gap_ns = _LATEST_NS if max_gap_s is None else round(max_gap_s * 1e9)
        self._stride = stride
        self._smooth = smooth
        self._by_samples = by_samples and not self._apparent_vertical
        wide = self._by_samples and step_ns > COARSE_NS
        self._before = COARSE_BEFORE if wide else ROLL_BEFORE
        self._times: IntArray = np.empty(0, np.int64)
        self._data: dict[str, FloatArray] = {name: np.empty(0) for name in self._channels()}
        self._first = 0
        self._next = 0
        self._turns = 0
        self._last_roll = 0.0
        self.bridged = 0
        self.crowded = 0

    def add(self, imu: ImuSamples | PlanarImu, origin_ns: int) -> None:
        """Take screened samples; times are counted from the origin."""
        if isinstance(imu, ImuSamples):
            kept = self._spaced(imu.stamp_ns - origin_ns)
            if kept is not None:
                self.crowded += len(kept) - int(np.count_nonzero(kept))
                imu = take(imu, kept)
        if not len(imu.stamp_ns):
            return
        known, n = len(self._times), len(self._times) + len(imu.stamp_ns)
        times = np.empty(n, np.int64)
        times[:known] = self._times
        np.subtract(imu.stamp_ns, origin_ns, out=times[known:])
        joined = {name: np.empty(n) for name in self._data}
        for name, values in self._data.items():
            joined[name][:known] = values
        if joined:
            self._fill(imu, {name: values[known:] for name, values in joined.items()})
        self._times, self._data = times, joined

    @property
    def has_samples(self) -> bool:
        """Whether the buffer holds any sample."""
        return len(self._times) > 0

    def _channels(self) -> tuple[str, ...]:
        """Return the names of the channels; `line` is the direction of the neutral line."""
        if self._still:
            return ()
        line = ('line', 'tilt') if self._apparent_vertical else ('line', 'line_rate')
        return (*line, 'gravity') if self._apparent_gravity else line

    def _fill(self, imu: ImuSamples | PlanarImu, new: dict[str, FloatArray]) -> None:
        """Fill the channels of new samples."""
        from tauto_core.ship import kernels  # kernels

        roll, rate = new['line'], new.get('line_rate')
        tilt, gravity = new.get('tilt'), new.get('gravity')
        force = tilt is not None or gravity is not None
        if isinstance(imu, PlanarImu):
            read_roll(imu, roll, rate)
            if force:
                read_force(imu, tilt, gravity)
        else:
            velocity = None if rate is None else plain(imu.angular_velocity)
            kernels.roll_of(plain(imu.orientation), velocity, roll, rate)
            if force:
                kernels.force_of(plain(imu.linear_acceleration), tilt, gravity)
        self._turns, self._last_roll = kernels.unwrap(roll, self._turns, self._last_roll)
        if tilt is not None:
            roll += tilt

    def _spaced(self, times: IntArray) -> NDArray[np.bool_] | None:
        """Return which samples are far enough from the one before; None if all are."""
        least = -(-self._step_ns // CROWDED_PART)
        if self._still:
            return None
        from tauto_core.ship import kernels  # kernels

        new = len(self._times) == 0 or times[0] - self._times[-1] >= least
        if new and kernels.spaced(times, least):
            return None
        past = [int(time) for time in self._times[-2:]]
        kept = np.ones(len(times), np.bool_)
        for i, time in enumerate(times.tolist()):
            step = min(self._step_ns, past[-1] - past[-2]) if len(past) == 2 else self._step_ns
            kept[i] = not past or CROWDED_PART * (time - past[-1]) >= step
            if kept[i]:
                past = [*past[-1:], time]
        return kept

    def forcing(self, log_ns: int, end_ns: int | None, *, final: bool) -> Forcing | None:
        """Return the forcing over the pieces that are complete, None where there is none.

        Args:
            log_ns: time between logged instants [ns].
            end_ns: no span goes beyond this time [ns]; None: no end.
            final: no more samples will come, so windows at the end become one-sided.

        Raises:
            PropagationError: the next piece is longer than `max_gap_s`; everything before it was
                returned by the previous call.
        """
        end = _LATEST_NS if end_ns is None else end_ns
        pieces = self._ready(log_ns, end, final=final)
        if not len(pieces.begin):
            return None
        stops = self._times[pieces.end]
        starts = np.concatenate([self._times[pieces.begin[:1]], stops[:-1]])
        logs = np.arange(starts[0] // log_ns + 1, min(stops[-1], end) // log_ns + 1) * log_ns
        at = np.searchsorted(stops, logs)
        if stops[-1] <= end and np.array_equal(stops[at], logs):
            spans, piece = _whole(starts, stops, at), None
        else:
            spans, piece = _cut(starts, stops, log_ns, end)
        if not self._still:
            spans = replace(spans, **self._polynomials(pieces, piece))
        self._next = self._first + int(pieces.end[-1])
        self._forget()
        return spans

    def _ready(self, log_ns: int, end_ns: int, *, final: bool) -> Pieces:
        """Return the complete pieces not yet used, up to the first gap; raise if it is next."""
        times, begin = self._times, self._next - self._first
        bridged_ns = int(BRIDGED_STEPS * self._step_ns)
        if self._still:
            index = np.arange(begin, len(times) - 1)
            index = index[times[index] < end_ns]
            self.bridged += int(np.count_nonzero(times[index + 1] - times[index] > bridged_ns))
            return Pieces(index, index + 1, np.zeros(len(index), np.bool_))
        from tauto_core.ship.fitting import Gaps, Widths, choose_pieces  # imports kernels

        force = self._apparent_vertical or self._apparent_gravity
        if force:
            widths = Widths(FORCE_BEFORE, FORCE_BEFORE, FORCE_POINTS)
        else:
            widths = Widths(self._before, ROLL_BEFORE, ROLL_POINTS)
        first, last, regular, bridged, gap = choose_pieces(
            times,
            self._first,
            begin,
            self._stride,
            widths,
            log_ns,
            end_ns,
            Gaps(bridged_ns, self._max_gap_ns),
            self._smooth,
            final,
        )
        if gap and not len(first):
            raise PropagationError(
                f'no ship motion for {(times[begin + 1] - times[begin]) * 1e-9:.6g} s; at most '
                f'{self._max_gap_ns * 1e-9:g} s are interpolated. Repair the source of ship/imu '
                'and start again',
                float(times[begin] * 1e-9),
            )
        self.bridged += bridged
        return Pieces(first, last, regular)

    def _polynomials(self, pieces: Pieces, piece: IntArray | None) -> dict[str, Any]:
        """Return the polynomials of the motion over each span."""
        if self._by_samples:
            return {'window': self._window(pieces, piece)}
        found = {'neutral': self._channel('line', self._data.get('line_rate'), pieces)}
        if self._apparent_vertical:
            found['tilt'] = self._channel('tilt', None, pieces)
        if self._apparent_gravity:
            found['gravity'] = self._channel('gravity', None, pieces)
        if piece is not None:
            found = {name: coefficients[piece] for name, coefficients in found.items()}
        return found

    def _window(self, pieces: Pieces, piece: IntArray | None) -> Window:
        """Return the samples of the neutral line over each span."""
        values, rates = self._data['line'], self._data['line_rate']
        stride, before = self._stride, self._before
        first, fitted = windows(
            self._times, values, rates, pieces, stride=stride, offset=self._first, before=before
        )
        if piece is not None:
            first = first[piece]
        return Window(window_nodes(stride, before), Polynomials(values, rates, first, fitted))

    def _channel(self, name: str, rates: FloatArray | None, pieces: Pieces) -> FloatArray:
        return polynomials(
            self._times,
            self._data[name],
            rates,
            pieces,
            stride=self._stride,
            offset=self._first,
        )

    def _forget(self) -> None:
        """Drop the samples that no later window can reach."""
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
            'turns': self._turns,
            'last_roll': self._last_roll,
            'bridged': self.bridged,
            'crowded': self.crowded,
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._times = np.array(state['times'])
        self._data = {name: np.array(values) for name, values in state['data'].items()}
        self._first, self._next = state['first'], state['next']
        self._turns, self._last_roll = state['turns'], state['last_roll']
        self.bridged, self.crowded = state['bridged'], state['crowded']


def _whole(starts: IntArray, stops: IntArray, at_logs: IntArray) -> Forcing:
    """Return a span for each piece."""
    n = len(starts)
    logged = np.zeros(n, np.bool_)
    logged[at_logs] = True
    length_s = np.asarray((stops - starts) * 1e-9, np.float64)
    return Forcing(length_s, np.zeros(n), np.ones(n), stops, logged)


def _cut(starts: IntArray, stops: IntArray, log_ns: int, end_ns: int) -> tuple[Forcing, IntArray]:
    """Return pieces cut at logged instants and at the end, and the piece of each span."""
    until = np.minimum(stops, end_ns)
    passed = starts // log_ns
    inside = (until - 1) // log_ns - passed
    piece = np.repeat(np.arange(len(starts)), inside + 1)
    to_last = np.arange(1, len(piece) + 1) - np.cumsum(inside + 1)[piece]
    logs = (passed + inside + 1)[piece] + to_last
    ends = np.where(to_last < 0, logs * log_ns, until[piece])
    begins = np.concatenate([starts[:1], ends[:-1]])
    start, length = starts[piece], (stops - starts)[piece]
    spans = Forcing(
        length_s=np.asarray(length * 1e-9, np.float64),
        begin=(begins - start) / length,
        end=(ends - start) / length,
        end_ns=ends,
        logged=ends % log_ns == 0,
    )
    return spans, piece
