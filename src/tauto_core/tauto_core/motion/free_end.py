"""Event-to-event steps: the propagator and its driver.

Between two impulses of an escapement the motion is smooth and takes half a swing. One step of
sixteen Gauss nodes in the rotating frame covers it. The step's length is an unknown like its
stages. It is predicted and then corrected by θ/θ̇ at the end of the step, which is the impulse.

Such a step begins at an impulse and reads all spans of forcing that it covers. A row logged in its
interior is the end of a step of given length from the same impulse. The assumptions of a step are
checked at its nodes. If one fails, the driver of `stepping` continues to the next impulse.
"""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.curves.cam import ArcLever
from tauto_core.kernels import entry, inlined
from tauto_core.machines import Machine, SlackThreadError
from tauto_core.motion.collocation import Collocation
from tauto_core.motion.forcing import Forcing, Motion, Temperatures
from tauto_core.motion.free_step import (
    DUE,
    HOLDS,
    LONGEST,
    LONGEST_ON_THREAD,
    MISSES,
    MOST_LENGTHS,
    MOST_SPANS,
    PAST,
    RING,
    ROW_SETTLED,
    SHORTEST,
    UNKNOWN,
    FreeEnd,
    FreeHalfSwing,
    FreeState,
    Rates,
    WheelInstant,
    arc_sine,
    end_of,
    event_after,
    fill_from_spans,
    fill_rates,
    given_by_impulse,
    holds,
    holds_on_thread,
    lasting,
    late_for_impulse,
    late_for_kink,
    lay_out_pieces,
    longer_by_gravity,
    moving,
    settle,
    ship_at,
    span_at,
    time_to_impulse,
    to_impulse,
    to_impulse_on_thread,
)
from tauto_core.motion.gauss_step import (
    LEAST_SETTLED,
    MAX_SWEEPS,
    MOST_POWERS,
    PART_STEP,
    Mode,
    Omega,
    Step,
    Work,
    copy_planes,
    fill_rotations,
    finish,
    gauss_constants,
    make_work,
    rows_of_eight,
    start_stages,
    sum_exactly,
    sweep,
)
from tauto_core.motion.lanes import SIZE, WIDE_SIZE, fma, row_of, store
from tauto_core.motion.slack import SPANNED, SlackThread, rest_of
from tauto_core.motion.stepping import (
    OK,
    ROW,
    STRUCK,
    LoggedRow,
    Model,
    Spans,
    bounds_of,
    count_step,
    over_span,
    restore_record,
    signs_at_nodes,
    state_of,
    step_error,
    write_row,
)
from tauto_core.motion.system import (
    NOWHERE,
    ForcingPieces,
    Inputs,
    Instant,
    Plane,
    RunningState,
    SteppedRun,
    Tolerance,
    mode_of,
    planes_of,
)
from tauto_core.motion.wells import ArcShape, arc_of
from tauto_core.motion.wheel import (
    HOT_NODES,
    WHEEL_NODES,
    Wheel,
    disturbance_on_land,
    error_factor,
    lasting_shape,
    reference_frequency,
    stages_of,
)
from tauto_core.samples import FloatArray, State
from tauto_core.scene.errors import CamRangeError

LEAST_FREE_SETTLED, LEAST_FREE_ERROR = 1e-11, 1e-13
"""Least iteration error and least error of a step, above rounding."""

LEAST_BENT_ERROR, MOST_ON_LAND = 1e-11, 1e-12
"""Least error of a step with a bent arm, which has more harmonics, and its largest error on land.
The sea has the rest.
"""

LEAST_KINKED_ERROR, MOST_ON_LAND_KINKED = 1e-8, 1e-9
"""The same errors on a kinked cam, which has a strongly anharmonic well: 3e-4 s/day."""


def arm_is_bent(machine: Machine) -> bool:
    """Return whether the coordinate is the angle, in a smooth well of a nonlinear arm.

    Such a swing needs one more sweep: with two, the weight's own cam errs by 6e-4 s/day.
    """
    smooth = not machine.cam.kinked and not machine.is_linear
    return smooth and lasting_shape(machine) is None


def free_end_of(machine: Machine, sweeps: int) -> FreeEnd:
    """Return the settings of event-to-event steps for a number of sweeps ≥ 1."""
    floor, phase = LEAST_FREE_ERROR, NEAR if sweeps <= MOST_IN_ONE else NEARER
    if machine.cam.kinked:
        floor, phase = (LEAST_KINKED_ERROR, NEAR_KINKED if sweeps <= MOST_IN_ONE else NEARER)
    elif arm_is_bent(machine):
        floor, phase = (LEAST_BENT_ERROR, NEAR_BENT if sweeps <= MOST_IN_ONE else NEARER)
    settled = max(LEAST_FREE_SETTLED, 10.0 ** -(2 * sweeps + 1))
    error, close = max(floor, 1e-6 * settled), 10.0 ** -(1.0 + 0.5 * sweeps)
    omega = reference_frequency(machine)
    usual_s = math.pi / omega
    swing, slower, slower_yet, spent = 1.0, 0.0, 0.0, 0.0
    if machine.cam.kinked:
        swing = _greatest(machine, omega, 1.0)
        changes = [_greatest(machine, omega, share) / swing - 1.0 for share in NEIGHBOURS]
        periods = [machine.period(machine.release_angle * share) for share in (*NEIGHBOURS, 1.0)]
        slopes = [
            (period / periods[-1] - 1.0) / change
            for period, change in zip(periods, changes, strict=False)
        ]
        slower_yet = (slopes[1] - slopes[0]) / (changes[1] - changes[0])
        slower = slopes[1] - slower_yet * changes[1]
        spent = 0.25 * usual_s * machine.drag.viscous / machine.inertia if machine.drag else 0.0
    return FreeEnd(sweeps, settled, error, phase, close, usual_s, swing, slower, slower_yet, spent)


NEIGHBOURS = 0.8, 0.9
"""Amplitudes over the release at which the period is compared with the period of the release."""


def _greatest(machine: Machine, omega: float, share: float) -> float:
    """Return the largest |Y| of a swing on land, for an amplitude of `share` of the release."""
    reached = min(abs(machine.release_angle), machine.cam.range_rad) * share
    return math.sqrt(2.0 * float(machine.potential(reached)) / machine.inertia) / omega


MOST_IN_ONE = 3
"""Sweeps up to which a near prediction of the length is not corrected by a second step."""

NEAR, NEARER = 0.01, 1e-4
"""Phase between the end of a step and the impulse within which the slopes are extrapolated [rad].

The extrapolation errs by some 6e-9 s/day within NEAR, and by a hundredth of it within NEARER,
which mostly takes a second length.
"""

NEAR_BENT, NEAR_KINKED = 0.004, 0.003
"""NEAR with a bent arm, and on a kinked cam."""


def takes_free_ends(machine: Machine) -> bool:
    """Return whether a machine can step from event to event.

    It needs an escapement, a drag without kink or static friction, a cam without joints, and a
    half swing for which sixteen stages are enough.
    """
    drag, cam, shape = machine.drag, machine.cam, lasting_shape(machine)
    if machine.escapement is None or cam.joints.size or not (drag is None or drag.is_linear):
        return False
    if cam.kinked and not _swings_on_cheek(machine):
        return False
    if shape is not None or machine.is_linear:
        return stages_of(machine, shape) == WIDE_SIZE
    most_error = MOST_ON_LAND_KINKED if cam.kinked else MOST_ON_LAND
    return _on_land(machine, shape, reference_frequency(machine)).error <= most_error


def _swings_on_cheek(machine: Machine) -> bool:
    """Return whether a release on land swings over the kink of a cheek, alike on both sides."""
    if not isinstance(machine.cam.lever, ArcLever) or machine.imbalance is not None:
        return False
    try:
        return machine.release_angle != 0.0 and machine.period(machine.release_angle) > 0.0
    except (CamRangeError, SlackThreadError):
        return False


class OnLand(NamedTuple):
    """Half a swing on land.

    Attributes:
        u, v: change of U and V at its stages, over its amplitude, (WIDE_SIZE,).
        error: error of one step over it, relative to the state. Infinite without convergence.
    """

    u: FloatArray
    v: FloatArray
    error: float


def _on_land(machine: Machine, shape: ArcShape | None, omega: float) -> OnLand:
    """Return half a swing on land at the amplitude of the release."""
    constants = gauss_constants(WIDE_SIZE)
    amplitude = machine.release_angle if shape is None else arc_of(machine.release_angle, shape.k)
    if machine.cam.kinked:
        amplitude = _greatest(machine, omega, 1.0)
    drag = machine.drag.viscous / machine.inertia if machine.drag else 0.0
    cosine, sine = np.cos(math.pi * constants.nodes), np.sin(math.pi * constants.nodes)
    u, v = np.zeros(WIDE_SIZE), np.full(WIDE_SIZE, amplitude)
    if amplitude == 0.0:
        return OnLand(u, v, 0.0)
    change = last_term = 0.0
    for _ in range(SWEEPS_ON_LAND):
        x, y = cosine * u + sine * v, cosine * v - sine * u
        d1, d2 = disturbance_on_land(machine, shape, omega, x, y)
        if shape is not None:
            d2 = d2 - drag * y
        u_before, slopes = u, (cosine * d1 - sine * d2, sine * d1 + cosine * d2)
        u = slopes[0] @ constants.columns * (math.pi / omega)
        v = slopes[1] @ constants.columns * (math.pi / omega) + amplitude
        change = float(np.max(np.abs(u - u_before)))
        last_term = max(abs(float(slope @ constants.projection[-1])) for slope in slopes)
    settled = change <= ROW_SETTLED * LEAST_FREE_SETTLED * abs(amplitude)
    factor = error_factor(machine, shape, WIDE_SIZE)
    error = step_error(factor, math.pi / omega * last_term / abs(amplitude), False)
    return OnLand(u / amplitude, v / amplitude - 1.0, error if settled else math.inf)


FREE = np.dtype(
    [
        *((name, 'f8') for name in ('x', 'x_rest', 'line_rate', 'gravity')),
        *((name, 'f8') for name in ('forth', 'back')),
        *((name, 'i8') for name in ('shown', 'waits', 'missed')),
        ('free', '?'),
    ],
    align=True,
)

SWEEPS_ON_LAND = 20
"""Sweeps that settle the stages of half a swing on land if event-to-event steps are efficient."""

CONSTANTS = 'half_cosine', 'half_sine', 'land_u', 'land_v'
"""Rows of constants of a wheel: cos πξ and sin πξ, and `OnLand.u` and `OnLand.v`."""

TO_END = 'first', 'second', 'third'
"""Rows of integrals of the slopes' Taylor series about the end of the step."""

WAITS = 15
"""Further half swings that the driver takes after a step did not hold."""


@inlined
def _to_row(
    run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd, row: LoggedRow
) -> int:
    """Write the row at the end of the last span if it precedes the impulse. The state stays."""
    wheel, omega, state, work = swing.system, run.omega, run.state, run.work
    h, mode = swing.known_s, mode_of(state)
    if wheel.kinked and h > LONGEST * expected_s(run, swing, free, free_end):
        return PAST
    if not isinstance(wheel, Wheel):
        # beyond the second turning point the motion looks as if it preceded the impulse
        expected = time_to_impulse(run, swing, free_end.usual_s) * lasting(run, free)
        if not h <= LONGEST * expected:
            return PAST
    fill_from_spans(swing, h, work)
    step = Step(wheel, mode, omega, h, PART_STEP, state.planes, work)
    fill_rotations(step)
    start_stages(step)
    settled, _ = sweep(step, max(LEAST_SETTLED, ROW_SETTLED * free_end.settled), MAX_SWEEPS)
    if not settled:
        return MISSES
    finish(step)
    k, x = span_at(swing, h)
    at = ship_at(swing, k, x)
    now = wheel.instant(mode, omega, planes_of(omega, work.end), at)
    if is_past(wheel, state, now):
        return PAST
    if not _holds(run, swing, mode, free_end.error, h):
        return MISSES
    # advance the state for the row, then restore it
    turns, beats = state.turns, state.beats
    saved: tuple[tuple[float, float, float, float], ...] = ()
    for p in range(len(omega)):
        plane = state.planes[p]
        saved = (*saved, (plane.x, plane.x_rest, plane.y, plane.y_rest))
    below = wheel.coordinate(planes_of(omega, state.planes)) < 0.0
    signs = signs_at_nodes(wheel.coordinates(work), below, NOWHERE, work)
    copy_planes(omega, work.end, state.planes)
    count_step(True, signs, run, 0, 0.0)
    write_row(run, at, row)
    state.turns, state.beats = turns, beats
    for p in range(len(omega)):
        plane = state.planes[p]
        plane.x, plane.x_rest, plane.y, plane.y_rest = saved[p]
    return HOLDS


@inlined
def _holds(run: SteppedRun, swing: FreeHalfSwing, mode: Mode, error: float, h: float) -> bool:
    """Return whether a step is exact enough, within range, and clear of tilt and impulse."""
    if isinstance(swing.system, Wheel):
        return holds(run, swing, mode, error, h)
    return holds_on_thread(run, swing, mode, error, h)


@inlined
def _to_next(
    run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next event, as `free_step.to_impulse`."""
    if isinstance(swing.system, Wheel):
        return to_next(run, swing, free, free_end)
    return to_impulse_on_thread(run, swing, free, free_end)


@inlined
def _ahead(
    start: FreeHalfSwing, first_due: int, reach_s: float, squares: FloatArray, bends: FloatArray
) -> tuple[int, FreeHalfSwing]:
    """Return a code and the half swing with the spans to read.

    They end at the next due row (DUE), or at the longest half swing (HOLDS). The code is UNKNOWN
    if the known spans end before, and MISSES if there are too many. More known spans do not change
    the result.
    """
    spans, k, last_span, x = start.spans, start.k, start.k, start.x
    known_s, square, bend, code = 0.0, 0.0, 0.0, UNKNOWN
    while True:
        known_s += (spans.end[last_span] - x) * start.pieces.length_s[last_span]
        square, bend = max(square, squares[last_span]), max(bend, bends[last_span])
        if known_s >= reach_s:
            code = HOLDS
        elif spans.logged[last_span] and last_span >= first_due:
            code = DUE
        elif last_span - k == MOST_SPANS:
            code = MISSES
        if code != UNKNOWN or last_span + 1 == len(spans.begin):
            break
        last_span += 1
        x = spans.begin[last_span]
    swing = FreeHalfSwing(
        start.system,
        k,
        start.x,
        last_span,
        known_s,
        square,
        bend,
        start.powers,
        spans,
        start.pieces,
        start.rates,
        start.table,
    )
    return code, swing


@entry
def advance_freely(
    system: Any,
    omega: Omega,
    tolerance: Tolerance,
    longest_s: float,
    pieces: ForcingPieces,
    spans: Spans,
    state: RunningState,
    work: Work,
    rows: NDArray[np.void],
    rates: Rates,
    powers: int,
    table: FloatArray,
    free: FreeState,
    free_end: FreeEnd,
) -> tuple[int, int, float]:
    """Advance the state over all spans, as `stepping.advance`, after filling the rates.

    Returns a code, and span and x at the end of a failed run. With OK the span is the first one
    that the next call needs again.
    """
    run = SteppedRun(system, omega, tolerance, state, work)
    longest = LONGEST if isinstance(system, Wheel) else LONGEST_ON_THREAD
    reach_s, written, count = longest * free_end.usual_s, 0, len(spans.begin)
    squares, bends = np.empty(count), np.empty(count)
    fill_rates(pieces, rates)
    for i in range(count):
        _, bends[i] = bounds_of(rates.line, i, 1.0 / pieces.length_s[i])
        squares[i] = system.clear_square(omega, pieces, i, abs(system.impulse))
    k, first_due, unlaid = 0, free.shown, 0
    while k < count:
        x = free.x if free.free else spans.begin[k]
        start = FreeHalfSwing(system, k, x, k, 0.0, 0.0, 0.0, powers, spans, pieces, rates, table)
        if free.free and free.waits == 0:
            time = 0.0
            code, swing = _ahead(start, first_due, reach_s, squares, bends)
            if code == UNKNOWN:
                break
            unlaid = lay_out_pieces(pieces, rates, powers, max(unlaid, k), swing.last_span, table)
            if code == DUE:
                code = _to_row(run, swing, free, free_end, rows[written])
                if code == HOLDS:
                    written += 1
                    first_due = swing.last_span + 1
                    continue
            if code != MISSES:
                code, time = _to_next(run, swing, free, free_end)
            if code == HOLDS:
                j, x = span_at(swing, time)
                further = sum_exactly(free.x, free.x_rest + time / pieces.length_s[k])
                x, free.x_rest = further if j == k else (x, 0.0)
                free.x = min(x, spans.end[j])
                k = j
                continue
            free.waits, free.missed = WAITS + 1, free.missed + 1
            free.forth = free.back = 0.0
        # the driver of `stepping` continues to the next impulse, or to the end of the span
        unlaid = lay_out_pieces(pieces, rates, powers, max(unlaid, k), k, table)
        code, x, _ = over_span(k, run, longest_s, pieces, spans, spans.logged[k], x, True)
        if code == STRUCK:
            at = ship_at(start, k, x)
            free.x, free.x_rest, free.free = x, 0.0, True
            free.line_rate, free.gravity = at.drive.rate, at.gravity
            free.waits = max(free.waits - 1, 0)
            continue
        if code != OK:
            return code, k, x
        if spans.logged[k] and k >= first_due:
            write_row(run, ship_at(start, k, x), rows[written])
            written += 1
        free.free = False
        k += 1
    free.shown = max(first_due - k, 0)
    return OK, k, 0.0


def _joined(former: Forcing | None, second: Forcing) -> Forcing:
    """Return the spans of two consecutive forcings as one."""
    if former is None:
        return second
    head, tail = former.temperatures, second.temperatures
    temperatures = tail
    if head is not None and tail is not None:
        # keep a shared interval once: its spans must have one index
        new = 1 if head.begin_s[-1] == tail.begin_s[0] else 0
        temperatures = Temperatures(
            np.concatenate([head.celsius, tail.celsius[new:]]),
            np.concatenate([head.begin_s, tail.begin_s[new:]]),
            tail.interval_s,
            np.concatenate([head.interval, tail.interval + (len(head.begin_s) - new)]),
            np.concatenate([head.place, tail.place]),
        )

    def both(name: str) -> Any:
        a, b = getattr(former, name), getattr(second, name)
        if a is None:
            return None
        if a.ndim == 2 and a.shape[1] != b.shape[1]:
            powers = max(a.shape[1], b.shape[1])
            a, b = (np.pad(array, ((0, 0), (0, powers - array.shape[1]))) for array in (a, b))
        return np.concatenate([a, b])

    return replace(second, **{name: both(name) for name in SPANNED}, temperatures=temperatures)


def _part(forcing: Forcing, start: int, stop: int | None = None) -> Forcing:
    """Return the spans from `start` up to `stop`, exclusive."""
    wanted = slice(start, stop)
    parts: dict[str, Any] = {
        name: None if (rows := getattr(forcing, name)) is None else rows[wanted].copy()
        for name in SPANNED
    }
    temperatures = forcing.temperatures
    if temperatures is not None:
        first_interval = int(temperatures.interval[start])
        temperatures = Temperatures(
            temperatures.celsius[first_interval:].copy(),
            temperatures.begin_s[first_interval:].copy(),
            temperatures.interval_s,
            temperatures.interval[wanted] - first_interval,
            temperatures.place[wanted].copy(),
        )
    return replace(forcing, **parts, temperatures=temperatures)


def _evened(pieces: ForcingPieces) -> tuple[ForcingPieces, int]:
    """Return the pieces padded to one number of powers in all channels, and that number."""
    channels = {name: getattr(pieces, name) for name in ('drive', 'tilt', 'gravity', 'lean')}
    powers = max((row.shape[1] for row in channels.values() if row is not None), default=0)
    padded: dict[str, Any] = {
        name: np.pad(row, ((0, 0), (0, powers - row.shape[1])))
        for name, row in channels.items()
        if row is not None and row.shape[1] < powers
    }
    return pieces._replace(**padded), powers


class FreeEnds(SlackThread):
    """A propagator that steps from event to event.

    A derived class sets `_free_end` and `_free`, and calls `_fill_constants`.
    """

    _free_end: FreeEnd
    _free: NDArray[np.void]
    _table: FloatArray
    _spans: Forcing | None = None

    def _fill_constants(self) -> None:
        """Fill the rows `TO_END` by P_n'(1), P_n''(1) …"""
        self._table = rows_of_eight(RING * MOST_POWERS)
        constants, nodes = gauss_constants(WIDE_SIZE), self._work['nodes']
        n, at_end = np.arange(WIDE_SIZE), np.ones(WIDE_SIZE)
        for j, name in enumerate(TO_END, start=1):
            at_end = at_end * (n - j + 1) * (n + j) / (2.0 * j)
            nodes[name] = (2.0**j / math.factorial(j + 1) * at_end) @ constants.projection

    @property
    def missed(self) -> int:
        """Steps so far that did not hold. After each the driver took `WAITS` + 1 half swings."""
        return int(self._free['missed'])

    def _released(self, forcing: Forcing) -> tuple[NDArray[np.void], float]:
        self._free[()], self._spans = np.zeros((), FREE), None
        return super()._released(forcing)

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans and keep the spans of an unfinished half swing."""
        open_spans, self._spans = self._spans, None
        if open_spans is None:
            return super().advance(forcing)
        # join only a few spans to the kept ones, without copying the many after them
        count = len(forcing.begin)
        lead = min(count, 2 * MOST_SPANS)
        motion = super().advance(_joined(open_spans, _part(forcing, 0, lead)))
        if lead == count:
            return motion
        k, self._spans = (lead - (0 if self._spans is None else len(self._spans.begin)), None)
        motions = motion, super().advance(rest_of(forcing, k, float(forcing.begin[k])))
        columns = (np.concatenate([getattr(m, f.name) for m in motions]) for f in fields(Motion))
        return Motion(*columns)

    def _run(
        self,
        forcing: Forcing,
        model: Model,
        tolerance: Tolerance,
        longest_s: float,
        state: NDArray[np.void] | None = None,
        work: NDArray[np.void] | None = None,
    ) -> tuple[NDArray[np.void], int, int, float]:
        first_due = int(self._free['shown'])
        rows = np.empty(int(np.count_nonzero(forcing.logged[first_due:])), ROW)
        pieces, powers = _evened(self._outside(forcing))
        rates = (
            None if row is None else np.empty_like(row) for row in (pieces.drive, pieces.tilt)
        )
        code, k, x = advance_freely(
            *model,
            tolerance,
            longest_s,
            pieces,
            Spans(forcing.begin, forcing.end, forcing.logged),
            self._state,
            self._work,
            rows,
            Rates(*rates),
            powers,
            self._table,
            self._free,
            self._free_end,
        )
        if code == OK:
            self._spans = _part(forcing, k) if k < len(forcing.begin) else None
        else:
            # drop rows beyond the end: in event-to-event steps the thread is certainly taut
            rows = rows[: np.count_nonzero(forcing.logged[first_due:k])]
            self._free['free'], self._free['shown'] = False, 0
        return rows, code, k, x

    def state(self) -> State:
        """Return the running state, and the spans of an unfinished half swing."""
        open_spans = self._spans
        spans = None
        if open_spans is not None:
            temperatures = open_spans.temperatures
            spans = {name: getattr(open_spans, name) for name in SPANNED}
            spans['temperatures'] = None if temperatures is None else dict(vars(temperatures))
        return {**super().state(), 'free': state_of(self._free), 'spans': spans}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        super().restore(state)
        restore_record(self._free, state['free'])
        spans, self._spans = state['spans'], None
        if spans is not None:
            temperatures = spans['temperatures']
            temperatures = None if temperatures is None else Temperatures(**temperatures)
            self._spans = Forcing(**{**spans, 'temperatures': temperatures})


class FreeEndCollocation(FreeEnds, Collocation):
    """Propagator of a wheel with an escapement that steps from event to event."""

    def __init__(self, machine: Machine, tolerance: float | None, sweeps: int) -> None:
        super().__init__(machine, tolerance, WIDE_SIZE)
        self._free_end = free_end_of(machine, sweeps)
        self._free = np.zeros((), FREE)
        rows, columns = (HOT_NODES, 2 * SIZE) if self._hot else (WHEEL_NODES, SIZE)
        self._work = make_work(1, (*rows, *CONSTANTS, *TO_END), WIDE_SIZE, columns)
        constants, nodes = gauss_constants(WIDE_SIZE), self._work['nodes']
        nodes['half_cosine'] = np.cos(math.pi * constants.nodes)
        nodes['half_sine'] = np.sin(math.pi * constants.nodes)
        land = _on_land(machine, self._shape, self._omega)
        nodes['land_u'], nodes['land_v'] = land.u, land.v
        self._fill_constants()


# -----------------------------------------------------------------------------
# Event-to-event steps on a kinked cam: to the kink or to the impulse, whichever comes first.
#
# A step continues the law of its first side over the kink, and its end gives the times of both
# events. A half swing is a long step over the turning point and a short one between kink and
# impulse, which differ by the tilt of the neutral line.

AT_ONCE = 1e-9
"""Phase between kink and impulse within which both are simultaneous [rad]."""

SHORT, MOST_LATE = 0.3, 0.05
"""Longest step between kink and impulse, over half a swing on land, and the largest error of a
predicted length, over the length, without a repetition of the step.
"""

ONWARD_SWEEPS = 2
"""Least sweeps of a step between kink and impulse."""


@inlined
def goes_on(state: RunningState) -> bool:
    """Return whether a kink or an impulse comes before the turning point of θ."""
    return state.armed or state.side * state.direction < 0


@inlined
def expected_s(run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd) -> float:
    """Return the time to the next kink or impulse, whichever comes first [s]."""
    wheel, state, plane = swing.system, run.state, run.state.planes[0]
    d, q, y = float(state.direction), plane.x, plane.y - free.line_rate / run.omega[0]
    per_size = 1.0 / math.sqrt(q * q + y * y)
    if goes_on(state):
        reach = 0.0
        if state.armed:
            k, x = span_at(swing, 0.0)
            reach = wheel.impulse - d * ship_at(swing, k, x).tilt.value
        return (arc_sine(reach * per_size) - arc_sine(d * q * per_size)) / run.omega[0]
    k, x = span_at(swing, free_end.usual_s)
    then, quicker = ship_at(swing, k, x), 1.0
    k, x = span_at(swing, 0.5 * free_end.usual_s)
    middle = ship_at(swing, k, x)
    # in the middle of the half swing the acceleration of the neutral line shifts the centre
    shift = d * middle.drive.bend / (run.omega[0] * run.omega[0])
    since = arc_sine((d * q + shift) * per_size)
    if wheel.channels.gravity is not None:
        quicker = longer_by_gravity(swing, free, middle, then)
    # the time from kink to kink depends on the swing, and the swing of a given Y on gravity
    larger_by = quicker / (per_size * free_end.swing) - 1.0 - free_end.spent
    time = 1.0 + larger_by * (free_end.slower + larger_by * free_end.slower_yet)
    half_s = free_end.usual_s * quicker * time
    reach = min(0.0, wheel.impulse + d * then.tilt.value)
    return half_s + (arc_sine((reach - shift) * per_size) - since) / run.omega[0]


@inlined
def _act(
    run: SteppedRun,
    swing: FreeHalfSwing,
    free: FreeState,
    mode: Mode,
    struck: bool,
    goal: Plane,
    at: Inputs,
    now: WheelInstant,
    since: float,
) -> None:
    """Apply an impulse or the kink to the state `goal`, a short time after an instant."""
    state, plane, turns = run.state, run.state.planes[0], not goes_on(run.state)
    added = 0.0
    if struck:
        added = given_by_impulse(swing.system, mode, goal, run.omega, now, at, since, state.given)
    plane.x, plane.x_rest, plane.y_rest = goal.x, 0.0, 0.0
    plane.y = goal.y + added
    free.line_rate, free.gravity = at.drive.rate + since * at.drive.bend, at.gravity
    if turns:
        state.direction = -state.direction
    if struck:
        state.armed, state.pallet = False, state.direction
        state.given += 1
    else:
        state.armed, state.side = turns, -state.side


@inlined
def _to_event(
    run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next kink or impulse and apply it (HOLDS), or keep the state (MISSES).

    Returns the code and the length of the step [s].
    """
    wheel, omega, state, work = swing.system, run.omega, run.state, run.work
    plane, onward = state.planes[0], goes_on(state)
    way = float(state.direction) if onward else -float(state.direction)
    mode = Mode(float(state.side), way, float(state.pallet))
    h = expected_s(run, swing, free, free_end)
    if onward and omega[0] * abs(h) < AT_ONCE:
        k, x = span_at(swing, 0.0)
        at = ship_at(swing, k, x)
        now = moving(wheel, mode, omega, Plane(plane.x, plane.y), at)
        _act(run, swing, free, mode, state.armed, Plane(plane.x, plane.y), at, now, 0.0)
        return HOLDS, 0.0
    usual_s, least_sweeps, settled, struck = (
        free_end.usual_s,
        free_end.sweeps,
        free_end.settled,
        state.armed,
    )
    shortest, longest = SHORTEST * usual_s, LONGEST * usual_s
    if onward:
        shortest, longest, least_sweeps = 0.0, SHORT * usual_s, ONWARD_SWEEPS
    for n in range(MOST_LENGTHS):
        if not shortest < h < longest:
            break
        fill_from_spans(swing, h, work)
        k, x = span_at(swing, h)
        at = ship_at(swing, k, x)
        step = Step(wheel, mode, omega, h, PART_STEP, state.planes, work)
        fill_rotations(step)
        if n == 0:
            start_stages(step)
            if not onward:
                store(work.u, 0, fma(row_of(work.nodes.land_u), plane.y, plane.x))
                store(work.v, 0, fma(row_of(work.nodes.land_v), plane.y, plane.y))
        if not settle(step, least_sweeps, settled * abs(plane.y), n > 0):
            break
        end = end_of(run, h)
        now = moving(wheel, mode, omega, end.plane, at)
        if not (way * now.rate > 0.0 and way * now.speed > 0.0):
            break
        late, impulse = late_for_kink(way, now, omega), late_for_impulse(wheel, way, now, omega)
        if not onward:
            struck = impulse < late
        if struck:
            late = impulse
        if omega[0] * abs(late) > free_end.near_phase or abs(late) > MOST_LATE * h:
            h += late
            continue
        if not holds(run, swing, mode, free_end.error, h):
            break
        signs = signs_at_nodes(wheel.coordinates(work), plane.x < 0.0, NOWHERE, work)
        late, since, at, now, goal = event_after(
            run, swing, mode, h, late, end, at, now, free_end, struck
        )
        _act(run, swing, free, mode, struck, goal, at, now, since)
        count_step(True, signs, run, 0, 0.0)
        return HOLDS, h + late
    return MISSES, 0.0


@inlined
def to_next(
    run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next event, as `to_impulse`."""
    if swing.system.kinked:
        return _to_event(run, swing, free, free_end)
    return to_impulse(run, swing, free, free_end)


@inlined
def is_past(wheel: Wheel, state: RunningState, now: Instant | WheelInstant) -> bool:
    """Return whether the next event of a state precedes an instant."""
    d = float(state.direction)
    if wheel.kinked:
        onward = goes_on(state)
        way = d if onward else -d
        struck = (state.armed or not onward) and not way * now.angle < wheel.impulse
        crossed = not state.armed and not state.side * now.coordinate > 0.0
        return (onward or way * now.rate > 0.0) and (struck or crossed)
    return d * now.rate < 0.0 and not -d * now.angle < wheel.impulse
