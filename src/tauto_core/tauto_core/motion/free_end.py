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
from copy import deepcopy
from dataclasses import asdict, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.curves.cam import ArcLever
from tauto_core.kernels import entry, inlined
from tauto_core.machines import Machine
from tauto_core.motion.collocation import Collocation
from tauto_core.motion.forcing import SPANNED, Forcing, Motion, Temperatures, swings_freely
from tauto_core.motion.free_step import (
    DUE,
    HOLDS,
    LONGEST,
    LONGEST_ON_THREAD,
    MISSES,
    MOST_SPANS,
    PAST,
    RING,
    ROW_SETTLED,
    UNKNOWN,
    FreeEnd,
    FreeHalfSwing,
    FreeState,
    expected_s,
    fill_from_spans,
    holds,
    is_past,
    lay_out_pieces,
    ship_at,
    span_at,
    to_next,
)
from tauto_core.motion.gauss_step import (
    LEAST_SETTLED,
    MAX_SWEEPS,
    MOST_POWERS,
    PART_STEP,
    Omega,
    Step,
    Work,
    fill_rotations,
    finish,
    gauss_constants,
    make_work,
    rows_of_eight,
    start_stages,
    sum_exactly,
    sweep,
)
from tauto_core.motion.lanes import SIZE, WIDE_SIZE
from tauto_core.motion.slack import SlackThread
from tauto_core.motion.stepping import (
    OK,
    ROW,
    STRUCK,
    Model,
    Spans,
    bounds_of,
    fill_row,
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
    RunningState,
    SteppedRun,
    Tolerance,
    mode_of,
    planes_of,
)
from tauto_core.motion.wells import ArcShape, arc_of
from tauto_core.motion.wheel import (
    THERMAL_NODES,
    WHEEL_NODES,
    Wheel,
    disturbance_on_land,
    error_factor,
    lasting_shape,
    reference_frequency,
    stages_of,
)
from tauto_core.samples import FloatArray, State

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


def free_end(sweeps: int, floor: float, near: float, usual_s: float) -> FreeEnd:
    """Return the settings of event-to-event steps for a number of sweeps ≥ 1.

    Args:
        sweeps: as in `FreeEnd`.
        floor: least error of a step.
        near: `FreeEnd.near_phase` up to `MOST_IN_ONE` sweeps [rad].
        usual_s: half a swing on land [s].
    """
    settled = max(LEAST_FREE_SETTLED, 10.0 ** -(2 * sweeps + 1))
    phase, close = near if sweeps <= MOST_IN_ONE else NEARER, 10.0 ** -(1.0 + 0.5 * sweeps)
    error = max(floor, 1e-6 * settled)
    return FreeEnd(sweeps, settled, error, phase, close, usual_s, 1.0, 0.0, 0.0, 0.0)


def free_end_of(machine: Machine, sweeps: int) -> FreeEnd:
    """Return the settings of a wheel for a number of sweeps ≥ 1."""
    omega = reference_frequency(machine)
    usual_s = math.pi / omega
    if not machine.cam.kinked:
        bent = arm_is_bent(machine)
        floor, near = (LEAST_BENT_ERROR, NEAR_BENT) if bent else (LEAST_FREE_ERROR, NEAR)
        return free_end(sweeps, floor, near, usual_s)
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
    settings = free_end(sweeps, LEAST_KINKED_ERROR, NEAR_KINKED, usual_s)
    return settings._replace(swing=swing, slower=slower, slower_yet=slower_yet, spent=spent)


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
    # over the kink of a cheek, alike on both sides
    on_cheek = isinstance(cam.lever, ArcLever) and machine.imbalance is None
    if cam.kinked and not (on_cheek and swings_freely(machine)):
        return False
    if shape is not None or machine.is_linear:
        return stages_of(machine, shape) == WIDE_SIZE
    most_error = MOST_ON_LAND_KINKED if cam.kinked else MOST_ON_LAND
    return _on_land(machine, shape, reference_frequency(machine)).error <= most_error


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
    error = step_error(factor, math.pi / omega * last_term / abs(amplitude))
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
    run: SteppedRun, swing: FreeHalfSwing, free: FreeState, free_end: FreeEnd, row: Any
) -> int:
    """Write the row at the end of the last span if it precedes the impulse. The state stays."""
    wheel, omega, state, work = swing.system, run.omega, run.state, run.work
    h, mode = swing.known_s, mode_of(state)
    # beyond the second turning point the motion looks as if it preceded the event
    may_be_late = wheel.kinked or not isinstance(wheel, Wheel)
    if may_be_late and not h <= LONGEST * expected_s(run, swing, free, free_end):
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
    if not holds(run, swing, mode, free_end.error, h):
        return MISSES
    below = wheel.coordinate(planes_of(omega, state.planes)) < 0.0
    signs = signs_at_nodes(wheel.coordinates(work), below, NOWHERE, work)
    below = now.coordinate < 0.0
    turns = state.turns + signs.turns + (1 if signs.below and not below else 0)
    beats = state.beats + signs.beats + (1 if signs.behind != below else 0)
    fill_row(now, turns, beats, row)
    return HOLDS


@inlined
def _ahead(
    spans: Spans,
    lengths: FloatArray,
    k: int,
    x: float,
    first_due: int,
    reach_s: float,
    squares: FloatArray,
    bends: FloatArray,
) -> tuple[int, int, float, float, float]:
    """Return a code, and `last_span`, `known_s`, `square`, `bend` of a half swing from x in k on.

    It reads up to the next due row (DUE), or up to the longest half swing (HOLDS). The code is
    UNKNOWN if the known spans end before, and MISSES if there are too many. More known spans do
    not change the result.
    """
    last_span, known_s, square, bend, code = k, 0.0, 0.0, 0.0, UNKNOWN
    while True:
        known_s += (spans.end[last_span] - x) * lengths[last_span]
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
    return code, last_span, known_s, square, bend


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
    line_rates: FloatArray | None,
    powers: int,
    table: FloatArray,
    free: FreeState,
    free_end: FreeEnd,
) -> tuple[int, int, float]:
    """Advance the state over all spans, as `stepping.advance`.

    `line_rates` are the coefficients of γ̇ over the pieces.

    Returns a code, and span and x at the end of a failed run. With OK the span is the first one
    that the next call needs again.
    """
    run = SteppedRun(system, omega, tolerance, state, work)
    longest = LONGEST if isinstance(system, Wheel) else LONGEST_ON_THREAD
    reach_s, written, count = longest * free_end.usual_s, 0, len(spans.begin)
    squares, bends = np.empty(count), np.empty(count)
    for i in range(count):
        _, bends[i] = bounds_of(line_rates, i, 1.0 / pieces.length_s[i])
        squares[i] = system.clear_square(omega, pieces, i, abs(system.impulse))
    k, first_due, unlaid = 0, free.shown, 0
    while k < count:
        x = free.x if free.free else spans.begin[k]
        start = FreeHalfSwing(system, k, x, k, 0.0, 0.0, 0.0, powers, spans, pieces, table)
        if free.free and free.waits == 0:
            time = 0.0
            code, last_span, known_s, square, bend = _ahead(
                spans, pieces.length_s, k, x, first_due, reach_s, squares, bends
            )
            swing = FreeHalfSwing(
                system, k, x, last_span, known_s, square, bend, powers, spans, pieces, table
            )
            if code == UNKNOWN:
                break
            unlaid = lay_out_pieces(pieces, powers, max(unlaid, k), last_span, table)
            if code == DUE:
                code = _to_row(run, swing, free, free_end, rows[written])
                if code == HOLDS:
                    written += 1
                    first_due = last_span + 1
                    continue
            if code != MISSES:
                code, time = to_next(run, swing, free, free_end)
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
        unlaid = lay_out_pieces(pieces, powers, max(unlaid, k), k, table)
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
        self._table = rows_of_eight(RING * MOST_POWERS).reshape(-1)
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
        return super().advance(_joined(open_spans, forcing))

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
        pieces = self._outside(forcing)
        channels = pieces.drive, pieces.tilt, pieces.gravity, pieces.lean
        powers = max((row.shape[1] for row in channels if row is not None), default=0)
        line, line_rates = pieces.drive, None
        if line is not None:
            line_rates = line[:, 1:] * (np.arange(1, line.shape[1]) / pieces.length_s[:, None])
        code, k, x = advance_freely(
            *model,
            tolerance,
            longest_s,
            pieces,
            Spans(forcing.begin, forcing.end, forcing.logged),
            self._state,
            self._work,
            rows,
            line_rates,
            powers,
            self._table,
            self._free,
            self._free_end,
        )
        if code == OK:
            self._spans = deepcopy(forcing.part(k)) if k < len(forcing.begin) else None
        else:
            # drop rows beyond the end: in event-to-event steps the thread is certainly taut
            rows = rows[: np.count_nonzero(forcing.logged[first_due:k])]
            self._free['free'], self._free['shown'] = False, 0
        return rows, code, k, x

    def state(self) -> State:
        """Return the running state, and the spans of an unfinished half swing."""
        spans = None if self._spans is None else asdict(self._spans)
        return {**super().state(), 'free': state_of(self._free), 'spans': spans}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        super().restore(state)
        restore_record(self._free, state['free'])
        spans, self._spans = state['spans'], None
        if spans is not None:
            heat = spans['temperatures']
            heat = None if heat is None else Temperatures(**heat)
            self._spans = Forcing(**{**spans, 'temperatures': heat})


class FreeEndCollocation(FreeEnds, Collocation):
    """Propagator of a wheel with an escapement that steps from event to event."""

    def __init__(self, machine: Machine, tolerance: float | None, sweeps: int) -> None:
        super().__init__(machine, tolerance, WIDE_SIZE)
        self._free_end = free_end_of(machine, sweeps)
        self._free = np.zeros((), FREE)
        rows, columns = (THERMAL_NODES, 2 * SIZE) if self._hot else (WHEEL_NODES, SIZE)
        self._work = make_work(1, (*rows, *CONSTANTS, *TO_END), WIDE_SIZE, columns)
        constants, nodes = gauss_constants(WIDE_SIZE), self._work['nodes']
        nodes['half_cosine'] = np.cos(math.pi * constants.nodes)
        nodes['half_sine'] = np.sin(math.pi * constants.nodes)
        land = _on_land(machine, self._shape, self._omega)
        nodes['land_u'], nodes['land_v'] = land.u, land.v
        self._fill_constants()
