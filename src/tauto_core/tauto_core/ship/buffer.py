"""The samples that a moving clock still needs, and the forcing computed from them.

A piece spans one or more sample steps. It is used as soon as its interpolation windows are
complete, at most four samples after its end. Stages may lag by `LOOKAHEAD` samples.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from tauto_core.motion.forcing import Forcing, Polynomials, Window
from tauto_core.samples import FloatArray, HungImu, ImuSamples, IntArray, Stateful, take
from tauto_core.scene import Scene
from tauto_core.scene.errors import PropagationError, SceneError, TautoError
from tauto_core.scene.times import NS_PER_S
from tauto_core.ship.imu import Sensed, ThreadPlane, contiguous, force_in_plane, in_parts
from tauto_core.ship.sampling import (
    FORCE_BEFORE,
    LARGEST_SLOW_TURN,
    MAX_STRIDE,
    MOST_STEP_PARTS,
    ROLL_BEFORE,
    largest_turn,
)

# -----------------------------------------------------------------------------
# Polynomials that represent the ship's motion between its samples.
#
# A piece spans n steps. Roll has a rate: with one more sample on either side, n + 3 samples give
# a Hermite polynomial of degree 2n + 5 (for coarse samples without fitting, three more samples
# and degree 2n + 13). The specific force has no rate: with four more samples on either side,
# n + 9 samples give a Lagrange polynomial of degree n + 8. Both are in powers of x, 0 to 1 over
# the piece.
#
# The remainder for a wave of angular frequency Ω and unit amplitude, sampled every h, is at most
# (Ωh)^w max|ω(u)|/w!, with w conditions and ω(u) the product of the distances to their nodes, in
# steps. For n = 1, mid-piece: roll (Ωh)⁸ (3/4)⁴/8! = 8e-6 (Ωh)⁸, force (Ωh)¹⁰ (945/32)²/10! =
# 2.4e-4 (Ωh)¹⁰ (Stoer & Bulirsch, Introduction to Numerical Analysis, 2.1).
#
# Measured for a wave of 5 s and unit amplitude: largest error of the value, of the first
# derivative over Ω, of the second over Ω² (the last two are mostly rounding of the samples).
#
# | n | force, 20 Hz       | roll, 20 Hz        | force, 10 Hz       | roll, 10 Hz        |
# |---|--------------------|--------------------|--------------------|--------------------|
# | 1 | 3e-16 1e-14 6e-13  | 2e-15 9e-15 1e-11  | 2e-13 6e-12 1e-10  | 5e-13 5e-14 8e-10  |
# | 2 | 2e-16 4e-15 1e-13  | 2e-16 4e-15 3e-13  | 1e-14 4e-13 9e-12  | 7e-16 5e-15 1e-12  |
# | 3 | 3e-16 7e-15 2e-13  | 2e-16 9e-15 5e-13  | 1e-15 3e-14 6e-13  | 2e-16 4e-15 1e-13  |
# | 4 | 3e-16 4e-15 2e-13  | 2e-16 5e-15 9e-13  | 3e-16 5e-15 7e-14  | 3e-16 4e-15 1e-13  |
# | 6 | 3e-16 8e-15 2e-13  | 3e-16 1e-14 2e-12  | 3e-16 5e-15 7e-14  | 2e-16 4e-15 5e-13  |
# | 8 | 6e-16 1e-14 4e-13  | 7e-16 3e-14 1e-11  | 3e-16 6e-15 1e-13  | 7e-16 1e-14 3e-12  |
#
# At the start of a run pieces span one step, unless the motion is known to be smooth: wide
# one-sided windows magnify noise up to a thousandfold.

ROLL_POINTS, FORCE_POINTS = 4, 10

COARSE_NS, COARSE_BEFORE = 400_000_000, 3
"""Step above which windows are wider [ns], for the sake of the first piece with its one-sided
window. Closer samples would only lose to rounding. Break-even is 2.5 Hz in a sea of 9 s.
"""


@dataclass(frozen=True)
class SamplePieces:
    """Pieces of motion between samples of a buffer, arrays of shape (n,).

    Attributes:
        begin: index of the first sample of each piece.
        end: index of the last.
        regular: whether the window is centred and evenly spaced. Such pieces have equal lengths.
    """

    begin: IntArray
    end: IntArray
    regular: NDArray[np.bool_]

    def part(self, which: slice | IntArray) -> SamplePieces:
        """Return some of the pieces."""
        return SamplePieces(self.begin[which], self.end[which], self.regular[which])


def _conditions(stride: int, margin: int, *, slopes: bool) -> int:
    return (stride + 1 + 2 * margin) * (2 if slopes else 1)


@lru_cache(maxsize=64)
def newton_basis(stride: int, margin: int, *, slopes: bool) -> FloatArray:
    """Return Newton's basis in powers of x over a piece of `stride` even steps.

    Column k has the coefficients of Π_{i<k} (stride·x + margin − z_i), with z = 0, 1, 2, … and a
    factor 1/k! for values, and z = 0, 0, 1, 1, … for values and slopes. The window has `margin`
    samples before and after the piece. Each number is correctly rounded.
    """
    size = _conditions(stride, margin, slopes=slopes)
    basis = np.zeros((-(-size // 2) * 2,) * 2)
    row = [Fraction(1)]
    for k in range(size):
        scale = 1 if slopes else math.factorial(k)
        basis[: k + 1, k] = [float(value / scale) for value in row]
        shift = margin - (k // 2 if slopes else k)
        row = [
            shift * low + stride * high
            for low, high in zip([*row, Fraction(0)], [Fraction(0), *row], strict=True)
        ]
    return basis


def polynomials(
    stamps_ns: IntArray,
    values: FloatArray,
    rates: FloatArray | None,
    pieces: SamplePieces,
    *,
    stride: int,
    offset: int,
    wide: int | None = None,
) -> FloatArray:
    """Return the coefficients over pieces, shape (n, w), from values and their rates [1/s].

    w = stride + 9, with rates 2·(stride + 3). Irregular pieces of several steps have windows of
    the same width (`wide` samples before and after, if given). Pieces of one step have windows of
    `FORCE_POINTS` or `ROLL_POINTS` samples, or all that exist, and zeros in higher powers. Windows
    are shifted to stay within the run, which began `offset` samples before `stamps_ns`.
    """
    from tauto_core.ship.fitting import fit_hermite, fit_values, fit_windows  # imports kernels

    slopes = rates is not None
    margin, points = (ROLL_BEFORE, ROLL_POINTS) if slopes else (FORCE_BEFORE, FORCE_POINTS)
    wide_margin = margin if wide is None else wide
    size = _conditions(stride, wide_margin, slopes=slopes)
    result = np.empty((len(pieces.begin), size))
    if not len(result):
        return result
    rows = np.flatnonzero(pieces.regular)
    if len(rows):
        basis = newton_basis(stride, wide_margin, slopes=slopes)
        begins = pieces.begin[rows] - wide_margin
        if rates is None:
            fit_values(basis, size, values, begins, rows, result)
        else:
            step_s = np.asarray((stamps_ns[begins + 1] - stamps_ns[begins]) * 1e-9, np.float64)
            fit_hermite(basis, size, values, rates, step_s, begins, rows, result)
    if len(rows) < len(result):
        long = pieces.end - pieces.begin > 1
        kinds = (long, wide_margin, stride + 1 + 2 * wide_margin), (~long, margin, points)
        for which, earlier, wanted in kinds:
            rows = np.flatnonzero(which & ~pieces.regular)
            begin, end = pieces.begin[rows], pieces.end[rows]
            count = min(wanted, offset + len(stamps_ns))
            begins = np.maximum(begin + offset - earlier, 0) - offset
            begins = np.minimum(begins, len(stamps_ns) - count)
            fit_windows(stamps_ns, values, rates, (begin, end), begins, count, rows, result)
    return result


@lru_cache(maxsize=2 * MAX_STRIDE)
def window_nodes(stride: int, margin: int) -> tuple[float, ...]:
    """Return x at the samples of a regular piece's window, with `margin` samples before it."""
    points = _conditions(stride, margin, slopes=False)
    return tuple((i - margin) / stride for i in range(points))


# -----------------------------------------------------------------------------
# The time step of the motion at the clock, which a suspension makes finer.


def sensed_parts(scene: Scene) -> int:
    """Return the number of equal parts of a step of ship/imu for the clock, 1 if not suspended.

    It is the least number that divides the step into whole nanoseconds and limits the turn of the
    fast mode to `largest_turn`, and with large angles the slow mode's to `LARGEST_SLOW_TURN`.

    Raises:
        SceneError: a mode is too fast.
    """
    hung = scene.suspension
    if hung is None:
        return 1
    step_s = scene.step_ns / NS_PER_S
    slow, *_, fast = 2 * hung.frequencies(scene.g)
    turn = largest_turn(scene.accuracy, linear=hung.is_linear)
    needed_hz = fast / turn
    if hung.large_angles:
        needed_hz = max(needed_hz, slow / LARGEST_SLOW_TURN)
    for parts in range(max(math.ceil(needed_hz * step_s), 1), MOST_STEP_PARTS + 1):
        if scene.step_ns % parts == 0:
            return parts
    if needed_hz > fast / turn and needed_hz * step_s > MOST_STEP_PARTS:
        raise SceneError(
            scene.name,
            'ship.rate',
            scene.ship.rate,
            f'is too low for wide swings of the case, with a slow mode of {slow:.6g} rad/s',
            f'Use a rate of at least {needed_hz / MOST_STEP_PARTS:.6g} Hz, or set '
            'suspension.large_angles to false.',
        )
    limit = turn * MOST_STEP_PARTS / step_s
    if fast <= limit:
        raise SceneError(
            scene.name,
            'ship.rate',
            scene.ship.rate,
            f'cannot be divided finely enough for the suspension with a fast mode of '
            f'{fast:.6g} rad/s: a step of {scene.step_ns} ns has no divisor that fits',
            'Use a rate whose step is a round number of nanoseconds, for example 20.0 Hz.',
        )
    raise SceneError(
        scene.name,
        'suspension.gyration_radius',
        hung.gyration_radius,
        f'gives the case a fast mode of {fast:.6g} rad/s (h′ = {scene.g / fast**2:.6g} m), '
        f'while the limit at {scene.ship.rate!r} Hz is {limit:.6g}',
        f'Use a larger one, or a ship.rate of {fast / limit * scene.ship.rate:.6g} Hz or more.',
    )


def sensed_step_ns(scene: Scene) -> int:
    """Return the step of the motion at the clock [ns]."""
    return scene.step_ns // sensed_parts(scene)


BRIDGED_STEPS = 1.5
CROWDED_PART = 4
"""A sample less than 1/4 of a step after the last one is dropped: polynomials through
roll and roll rate at two instants δ apart multiply their noise by (step/δ)³.
"""

_LATEST_NS = 2**63 - 1

T = TypeVar('T')


PIECE_COST = 0.5
"""Fixed cost of a piece, in steps of the propagator."""

WORTH = 0.9
"""Shorter pieces are used if they reduce the cost to less than this fraction."""


def samples_a_piece(scene: Scene, steps_in: Callable[[float], int] = lambda _: 1) -> int:
    """Return the number of steps of a piece, for pieces that end at logged instants.

    Longer pieces are more accurate, as less of them is near the edge of the fitted window. Shorter
    ones are used if whole steps of the propagator fit them better. `steps_in` returns its number
    of steps in a length [s].
    """
    if scene.lies_still:
        return 1
    step_ns = sensed_step_ns(scene)
    logs = scene.log_interval_ns // step_ns
    largest, *fewer = (n for n in range(MAX_STRIDE, 0, -1) if logs % n == 0)

    def cost(samples: int) -> float:
        return (PIECE_COST + steps_in(samples * step_ns * 1e-9)) / samples

    best = min(fewer, key=cost, default=largest)
    return best if cost(best) < WORTH * cost(largest) else largest


class MotionBuffer(Stateful):
    """Turns motion samples into forcing, independently of batches.

    Args:
        apparent_vertical: whether the neutral line is the apparent vertical, not fixed to the
            case.
        apparent_gravity: whether the pull is proportional to the apparent gravity.
        still: whether the platform is at rest. Samples then only set the pace of the run.
        step_ns: nominal step [ns]. Longer steps count as bridged. Samples within a quarter of it
            (or of the last step, if shorter) after the last one are dropped.
        max_gap_s: longest time between samples that is interpolated [s], or `None` at rest.
        plane: the plane in which the thread can follow the force.
        stride: steps that a piece spans, 1 to 8, if they are even and no logged instant falls
            inside.
        smooth: whether the motion is free of noise. The first pieces may then span `stride`, with
            one-sided windows, which magnify noise a thousandfold.
        by_samples: whether a neutral line fixed to the case is given by samples, not fitted.
        unbalanced: whether the wheel is. A neutral line fixed to the case then needs β − γ, too.
    """

    state_names = ('times', 'data', 'first', 'next', 'turns', 'last_roll', 'bridged', 'crowded')

    def __init__(
        self,
        *,
        apparent_vertical: bool,
        apparent_gravity: bool,
        still: bool,
        step_ns: int,
        max_gap_s: float | None,
        plane: ThreadPlane = 'ship',
        stride: int = 1,
        smooth: bool = False,
        by_samples: bool = False,
        unbalanced: bool = False,
    ) -> None:
        self._apparent_vertical = apparent_vertical and not still
        self._apparent_gravity = apparent_gravity and not still
        self._leans = unbalanced and not still and not apparent_vertical
        self._still = still
        self._plane: ThreadPlane = plane
        self._step_ns = step_ns
        self._max_gap_ns = _LATEST_NS if max_gap_s is None else round(max_gap_s * 1e9)
        self._stride = stride
        self._smooth = smooth
        self._by_samples = by_samples and not self._apparent_vertical
        wide = self._by_samples and step_ns > COARSE_NS
        self._margin = COARSE_BEFORE if wide else ROLL_BEFORE
        self._times: IntArray = np.empty(0, np.int64)
        self._data: dict[str, FloatArray] = {name: np.empty(0) for name in self.channel_names()}
        self._first = self._next = self._turns = 0
        self._last_roll = 0.0
        self.bridged = self.crowded = 0

    def add(self, imu: Sensed | HungImu, origin_ns: int) -> None:
        """Add screened samples. Times count from the origin."""
        if isinstance(imu, ImuSamples):
            is_spaced = self._spaced(imu.stamp_ns - origin_ns)
            if is_spaced is not None:
                self.crowded += len(is_spaced) - int(np.count_nonzero(is_spaced))
                imu = take(imu, is_spaced)
        if not len(imu.stamp_ns):
            return
        old, n = len(self._times), len(self._times) + len(imu.stamp_ns)
        times = np.empty(n, np.int64)
        times[:old] = self._times
        np.subtract(imu.stamp_ns, origin_ns, out=times[old:])
        joined = {name: np.empty(n) for name in self._data}
        for name, values in self._data.items():
            joined[name][:old] = values
        if joined:
            self.fill(imu, {name: values[old:] for name, values in joined.items()})
        self._times, self._data = times, joined

    @property
    def has_samples(self) -> bool:
        """Whether the buffer holds any sample."""
        return len(self._times) > 0

    def channel_names(self) -> tuple[str, ...]:
        """Return the names of the channels. `line` is the direction of the neutral line."""
        if self._still:
            return ()
        line = ('line', 'tilt') if self._apparent_vertical else ('line', 'line_rate')
        extra = ('gravity',) * self._apparent_gravity + ('lean',) * self._leans
        return (*line, *extra)

    def fill(self, imu: Sensed | HungImu, new: dict[str, FloatArray]) -> None:
        """Fill the channels of new samples."""
        from tauto_core.ship import kernels  # kernels

        roll, rate = new['line'], new.get('line_rate')
        tilt, gravity = new.get('tilt'), new.get('gravity')
        lean = new.get('lean', tilt)
        force = lean is not None or gravity is not None
        if isinstance(imu, HungImu):
            channels = (roll, imu.tilt), (rate, imu.rate), (lean, imu.lean), (gravity, imu.pull)
            for channel, values in channels:
                if channel is not None:
                    channel[:] = values
        else:
            for rows, part in in_parts(imu, rate is not None, force):
                rates, leans, pulls = (
                    None if array is None else array[rows] for array in (rate, lean, gravity)
                )
                velocity = None if rate is None else contiguous(part.angular_velocity)
                kernels.roll_of(contiguous(part.orientation), velocity, roll[rows], rates)
                if force:
                    in_plane = contiguous(force_in_plane(part, self._plane))
                    kernels.force_of(in_plane, leans, pulls)
            self._turns, self._last_roll = kernels.unwrap(roll, self._turns, self._last_roll)
        if tilt is not None:
            roll += tilt

    def _spaced(self, times: IntArray) -> NDArray[np.bool_] | None:
        """Return which samples are far enough from the one before, or `None` if all are."""
        least_ns = -(-self._step_ns // CROWDED_PART)
        if self._still:
            return None
        new = len(self._times) == 0 or times[0] - self._times[-1] >= least_ns
        if new and np.all(np.diff(times) >= least_ns):
            return None
        past = [int(time) for time in self._times[-2:]]
        is_spaced = np.ones(len(times), np.bool_)
        for i, time in enumerate(times.tolist()):
            step = min(self._step_ns, past[-1] - past[-2]) if len(past) == 2 else self._step_ns
            is_spaced[i] = not past or CROWDED_PART * (time - past[-1]) >= step
            if is_spaced[i]:
                past = [*past[-1:], time]
        return is_spaced

    def forcing(self, log_ns: int, end_ns: int | None, *, final: bool) -> Forcing | None:
        """Return the forcing over the complete pieces, or `None` if there is no such piece.

        Spans end at logged instants and at `end_ns`. With `final` no more samples will come, and
        the windows at the end become one-sided.

        Raises:
            PropagationError: the next piece is longer than `max_gap_s`.
        """
        end = _LATEST_NS if end_ns is None else end_ns
        pieces = self.ready(log_ns, end, final=final)
        if not len(pieces.begin):
            return None
        stops = self._times[pieces.end]
        starts = np.concatenate([self._times[pieces.begin[:1]], stops[:-1]])
        logs = np.arange(starts[0] // log_ns + 1, min(stops[-1], end) // log_ns + 1) * log_ns
        at = np.searchsorted(stops, logs)
        if stops[-1] <= end and np.array_equal(stops[at], logs):
            n, piece = len(starts), None  # a span for each piece
            logged = np.zeros(n, np.bool_)
            logged[at] = True
            length_s = np.asarray((stops - starts) * 1e-9, np.float64)
            spans = Forcing(length_s, np.zeros(n), np.ones(n), stops, logged)
        else:
            spans, piece = _cut(starts, stops, log_ns, end)
        if not self._still:
            spans = replace(spans, **self._polynomials(pieces, piece))
        self.forget(pieces)
        return spans

    def ready(self, log_ns: int, end_ns: int, *, final: bool) -> SamplePieces:
        """Return the complete pieces not yet used, up to the first gap. Raise if it is next."""
        times, begin = self._times, self._next - self._first
        bridged_ns = int(BRIDGED_STEPS * self._step_ns)
        if self._still:
            index = np.arange(begin, len(times) - 1)
            index = index[times[index] < end_ns]
            self.bridged += int(np.count_nonzero(times[index + 1] - times[index] > bridged_ns))
            return SamplePieces(index, index + 1, np.zeros(len(index), np.bool_))
        from tauto_core.ship.fitting import choose_pieces  # imports kernels

        force = self._apparent_vertical or self._apparent_gravity
        widths = self._margin, ROLL_BEFORE, ROLL_POINTS
        if force:
            widths = FORCE_BEFORE, FORCE_BEFORE, FORCE_POINTS
        begins, ends, regular, bridged, gap = choose_pieces(
            times,
            self._first,
            begin,
            self._stride,
            *widths,
            log_ns,
            end_ns,
            bridged_ns,
            self._max_gap_ns,
            self._smooth,
            final,
        )
        if gap and not len(begins):
            raise PropagationError(
                f'no ship motion for {(times[begin + 1] - times[begin]) * 1e-9:.6g} s; at most '
                f'{self._max_gap_ns * 1e-9:g} s are interpolated. Repair the source of ship/imu '
                'and start again',
                float(times[begin] * 1e-9),
            )
        self.bridged += bridged
        return SamplePieces(begins, ends, regular)

    def _polynomials(self, pieces: SamplePieces, piece: IntArray | None) -> dict[str, Any]:
        if self._by_samples:
            values, rates = self._data['line'], self._data['line_rate']
            # a regular piece has its first sample, an irregular one −1 − its row of `fitted`
            irregular = np.flatnonzero(~pieces.regular)
            samples = pieces.begin - self._margin
            samples[irregular] = -1 - np.arange(len(irregular))
            fitted = self.fitted('line', pieces.part(irregular), rates, wide=self._margin)
            if piece is not None:
                samples = samples[piece]
            nodes = window_nodes(self._stride, self._margin)
            return {'window': Window(nodes, Polynomials(values, rates, samples, fitted))}
        names = [name for name in ('tilt', 'gravity', 'lean') if name in self._data]
        channels: dict[str, Any] = {name: self.fitted(name, pieces) for name in names}
        channels['neutral'] = self.fitted('line', pieces, self._data.get('line_rate'))
        if piece is not None:
            channels = {name: coefficients[piece] for name, coefficients in channels.items()}
        return channels

    def fitted(
        self,
        name: str,
        pieces: SamplePieces,
        rates: FloatArray | None = None,
        wide: int | None = None,
    ) -> FloatArray:
        """Return the polynomials of a channel, as `polynomials` does."""
        return polynomials(
            self._times,
            self._data[name],
            rates,
            pieces,
            stride=self._stride,
            offset=self._first,
            wide=wide,
        )

    def forget(self, used: SamplePieces) -> None:
        """Drop the samples that later pieces do not need."""
        self._next = self._first + int(used.end[-1])
        drop = max(self._next - FORCE_POINTS - self._first, 0)
        self._times = self._times[drop:]
        self._data = {name: values[drop:] for name, values in self._data.items()}
        self._first += drop


TURNS = 4
"""Number of recent answers kept. A clock may take several parts of its samples at once."""


@dataclass
class _Shared:
    """A part that several clocks share, and its latest answers."""

    part: Any
    turns: int = 0
    last_ns: int = -1
    log: deque[tuple[Any, TautoError | None]] = field(default_factory=lambda: deque(maxlen=TURNS))


class SharedBuffers:
    """Buffers and cases that clocks in one sea share, fed in turn. Each is computed once.

    Clocks with the same settings and the same parts of samples share their forcing.
    """

    def __init__(self) -> None:
        self._known: dict[tuple[object, ...], _Shared] = {}

    def common(self, key: tuple[object, ...], make: Callable[[], object]) -> _Shared:
        """Return the shared part with this key, made for the first clock."""
        if key not in self._known:
            self._known[key] = _Shared(make())
        return self._known[key]

    def buffer(self, parts: object, **settings: Any) -> BufferInCommon:
        """Return a clock's view of the buffer with these settings; `parts` is part of its key."""
        key = parts, *sorted(settings.items())
        return BufferInCommon(self.common(key, lambda: MotionBuffer(**settings)))


class InCommon:
    """One clock's view of a shared buffer or case."""

    part: Any

    def __init__(self, shared: _Shared) -> None:
        self._shared, self.part, self._turn = shared, shared.part, 0
        self.bridged = self.crowded = 0

    def in_turn(self, compute: Callable[[], T]) -> T:
        """Return, or raise, the answer of the next turn. The first clock to ask computes it."""
        shared = self._shared
        self._turn += 1
        if self._turn > shared.turns:
            shared.turns = self._turn
            try:
                shared.log.append((compute(), None))
            except TautoError as error:
                shared.log.append((None, error))
        self.bridged, self.crowded = self.part.bridged, self.part.crowded
        if shared.turns - self._turn >= len(shared.log):
            raise RuntimeError('a clock is fed behind the others in its sea')
        answer, failed = shared.log[self._turn - shared.turns - 1]
        if failed is not None:
            raise failed
        return cast(T, answer)


class BufferInCommon(InCommon):
    """One clock's view of a shared buffer."""

    part: MotionBuffer

    def add(self, imu: Sensed | HungImu, origin_ns: int) -> None:
        """Add screened samples, unless another clock has added them."""
        shared = self._shared
        if int(imu.stamp_ns[-1]) > shared.last_ns:
            self.part.add(imu, origin_ns)
            shared.last_ns = int(imu.stamp_ns[-1])

    def forcing(self, log_ns: int, end_ns: int | None, *, final: bool) -> Forcing | None:
        """Return the forcing over the complete pieces, as `MotionBuffer.forcing` does."""
        return self.in_turn(lambda: self.part.forcing(log_ns, end_ns, final=final))


def _cut(starts: IntArray, stops: IntArray, log_ns: int, end_ns: int) -> tuple[Forcing, IntArray]:
    """Return spans, pieces cut at logged instants and at the end, and the piece of each."""
    until = np.minimum(stops, end_ns)
    log_begin = starts // log_ns
    cuts = (until - 1) // log_ns - log_begin
    piece = np.repeat(np.arange(len(starts)), cuts + 1)
    to_last = np.arange(1, len(piece) + 1) - np.cumsum(cuts + 1)[piece]
    logs = (log_begin + cuts + 1)[piece] + to_last
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
