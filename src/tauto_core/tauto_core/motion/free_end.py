"""Free-end steps: one step from impulse to impulse, whose length is solved with its stages.

Between two impulses of an escapement the motion is smooth, and takes half a swing. One step of
sixteen Gauss nodes in the rotating frame spans it. Its length T is predicted, and corrected by
θ/θ̇ at its end when the stages are nearly settled: so the impulse is the end of the step by
construction, and needs no search, no short step back and no layout of a stretch.

Such a step begins at an impulse and reads as many spans of forcing as it covers. A row that is
logged on its way is the end of a step of given length from the same impulse. What a step assumes
is checked at its nodes; where that fails, the driver of `stepping` continues to the next impulse.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from tauto_core.curves.cam import ArcLever
from tauto_core.kernels import entry, inlined
from tauto_core.machines import Machine
from tauto_core.motion.forcing import Forcing, Motion, Temperatures
from tauto_core.motion.gauss_step import (
    COSINE,
    LEAST_SETTLED,
    MAX_SWEEPS,
    PART_STEP,
    SINE,
    Omega,
    Step,
    Work,
    copy_planes,
    evaluate,
    fill_rotations,
    finish,
    gauss_constants,
    make_work,
    rotation,
    start_stages,
    sum_exactly,
    sweep,
)
from tauto_core.motion.lanes import (
    SIZE,
    WIDE_SIZE,
    Lanes,
    chosen,
    filled,
    fma,
    folded_both,
    lane,
    larger,
    largest,
    load,
    store,
    total,
)
from tauto_core.motion.passages import bounds_of, count_step, signs_at_nodes
from tauto_core.motion.stepping import (
    OK,
    ROW,
    STRUCK,
    LoggedRow,
    Moved,
    Spans,
    over_span,
    restore_record,
    state_of,
    step_error,
    write_row,
)
from tauto_core.motion.system import (
    HEAT_POWERS,
    NOWHERE,
    ChannelAt,
    ForcingPieces,
    HotNumbers,
    HotPieces,
    Instant,
    Mode,
    Outside,
    Plane,
    RunningState,
    SteppedRun,
    Tolerance,
    mode_of,
    planes_of,
)
from tauto_core.motion.wells import ArcShape, arc_of, kick, lever_arm, mass_of
from tauto_core.motion.wheel import (
    HOT_NODES,
    WHEEL_NODES,
    Collocation,
    Wheel,
    angle_at,
    disturbance_on_land,
    error_factor,
    lasting_shape,
    reference_frequency,
    stages_of,
    surely_within,
    wheel_at_nodes,
    wheel_now,
)
from tauto_core.samples import FloatArray, State


class FreeEnd(NamedTuple):
    """How free-end steps are taken.

    Attributes:
        sweeps: least sweeps of the stages; each takes a factor of some 60 off the error.
        settled: share of the state that the last sweep may have left; more are made until then.
        error: error allowed in a step, relative to the state.
        near: phase from the impulse within which a step is not repeated [rad].
        close: phase from the impulse within which the ship's motion is carried on to it [rad].
        usual_s: half a swing on land [s].
        swing: its largest Y, in the middle [rad].
        slower: relative change of the time of half a swing over that of Y.
    """

    sweeps: int
    settled: float
    error: float
    near: float
    close: float
    usual_s: float
    swing: float
    slower: float


LEAST_FREE_SETTLED, LEAST_FREE_ERROR = 1e-11, 1e-13
"""Below them rounding would decide."""

LEAST_BENT_ERROR, MOST_ON_LAND = 1e-11, 1e-12
"""The same of a bent swing, whose slopes have more harmonics; and the most that its steps may err
on land, so that the sea is left the rest.
"""

LEAST_KINKED_ERROR, MOST_ON_LAND_KINKED = 1e-8, 1e-9
"""The same of a swing on a kinked cam, whose well is strongly anharmonic: 3e-4 s/day."""


def free_end_of(machine: Machine, sweeps: int) -> FreeEnd:
    """Return the settings for a number of sweeps, ≥ 1."""
    bent = lasting_shape(machine) is None and not machine.is_linear
    settled = max(LEAST_FREE_SETTLED, 10.0 ** -(2 * sweeps + 1))
    least = LEAST_BENT_ERROR if bent else LEAST_FREE_ERROR
    if machine.cam.kinked:
        least = LEAST_KINKED_ERROR
    error, close = max(least, 1e-6 * settled), 10.0 ** -(1.0 + 0.5 * sweeps)
    near = NEAR if sweeps <= MOST_IN_ONE else NEARER
    if bent:
        most = MOST_IN_ONE if machine.cam.kinked else MOST_IN_ONE - 1
        near = NEAR_BENT if sweeps <= most else NEARER
    omega = reference_frequency(machine)
    swing, slower = _greatest(machine, omega, 1.0), 0.0
    if machine.cam.kinked:
        periods = [machine.period(machine.release_angle * share) for share in NEIGHBOURS]
        swings = [_greatest(machine, omega, share) for share in NEIGHBOURS]
        slower = math.log(periods[1] / periods[0]) / math.log(swings[1] / swings[0])
    return FreeEnd(sweeps, settled, error, near, close, math.pi / omega, swing, slower)


NEIGHBOURS = 0.9, 1.0
"""Swings, over the release, whose times are compared."""


def _greatest(machine: Machine, omega: float, share: float) -> float:
    """Return the largest |Y| of a swing on land, by its amplitude over the release."""
    reached = min(abs(machine.release_angle), machine.cam.range_rad) * share
    return math.sqrt(2.0 * float(machine.potential(reached)) / machine.inertia) / omega


MOST_IN_ONE = 3
"""Sweeps up to which one length is tried where it is near."""

NEAR, NEARER = 0.01, 1e-4
"""Phase from the end of a step within which its slopes are extrapolated to the impulse [rad].

The second derivative that this takes from the polynomial of the step leaves some 6e-9 s/day within
NEAR, and a hundredth of it within NEARER, at the price of a second length.
"""

NEAR_BENT = 0.003
"""The same of a bent swing and two sweeps: it leaves 2e-5 s/day, where NEAR would leave 1e-4."""


def takes_free_ends(machine: Machine) -> bool:
    """Return whether a machine can step from impulse to impulse.

    It needs an escapement and nothing but a cam's kink that happens between two impulses: no kink
    of the drag, no friction that holds, no joints; and a swing for half of which sixteen stages
    are enough. Where the case swings with it, the driver takes the steps.
    """
    drag, cam, shape = machine.drag, machine.cam, lasting_shape(machine)
    if machine.escapement is None or machine.case is not None:
        return False
    if cam.joints.size or not (drag is None or drag.is_linear):
        return False
    if cam.kinked and not (isinstance(cam.lever, ArcLever) and machine.release_angle):
        return False
    if shape is not None or machine.is_linear:
        return stages_of(machine, shape) == WIDE_SIZE
    most = MOST_ON_LAND_KINKED if cam.kinked else MOST_ON_LAND
    return _on_land(machine, shape, reference_frequency(machine)).error <= most


class OnLand(NamedTuple):
    """Half a swing on land.

    Attributes:
        u, v: how far U and V go at its stages, over its amplitude.
        error: error of one step over it, relative to the state; infinite if that does not settle.
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
    change = last = 0.0
    for _ in range(SWEEPS_ON_LAND):
        x, y = cosine * u + sine * v, cosine * v - sine * u
        d1, d2 = disturbance_on_land(machine, shape, omega, x, y)
        if shape is not None:
            d2 = d2 - drag * y
        before, slopes = u, (cosine * d1 - sine * d2, sine * d1 + cosine * d2)
        u = slopes[0] @ constants.columns * (math.pi / omega)
        v = slopes[1] @ constants.columns * (math.pi / omega) + amplitude
        change = float(np.max(np.abs(u - before)))
        last = max(abs(float(slope @ constants.projection[-1])) for slope in slopes)
    settled = change <= ROW_SETTLED * LEAST_FREE_SETTLED * abs(amplitude)
    factor = error_factor(machine, shape, WIDE_SIZE)
    error = step_error(factor, math.pi / omega * last / abs(amplitude), False)
    return OnLand(u / amplitude, v / amplitude - 1.0, error if settled else math.inf)


class FreeState(Protocol):
    """Where free-end steps are: a record of FREE in compiled code.

    Attributes:
        x, x_rest: where in the first span kept the half swing began, as two doubles.
        line_rate: γ̇ there [rad/s].
        gravity: g_eff there [m/s2].
        shown: first of the spans kept whose row, if any, is not written yet.
        waits: half swings to come that the driver takes, after a step that did not hold.
        missed: steps that did not hold.
        free: whether the state is that just after an impulse or a kink; otherwise at the end of a
            span.
    """

    x: float
    x_rest: float
    line_rate: float
    gravity: float
    shown: int
    waits: int
    missed: int
    free: bool


FREE = np.dtype(
    [
        *((name, 'f8') for name in ('x', 'x_rest', 'line_rate', 'gravity')),
        *((name, 'i8') for name in ('shown', 'waits', 'missed')),
        ('free', '?'),
    ],
    align=True,
)

SHORTEST, LONGEST = 0.8, 1.2
"""Least and greatest length of a half swing, over that on land."""

MOST_LENGTHS = 4
"""Most lengths tried of one step; its prediction seldom errs by more than `NEAR`."""

MORE_SWEEPS = 12
"""Most sweeps beyond the number set."""

SWEEPS_ON_LAND = 20
"""Sweeps that settle the stages of half a swing on land, where free-end steps pay."""

ROW_SETTLED = 1e-3
"""How far the stages settle for a logged row, over `FreeEnd.settled`."""

CONSTANTS = 'half_cosine', 'half_sine', 'land_u', 'land_v', 'first', 'second', 'third'
"""Rows of constants: cos and sin of πξ, U and V on land over the amplitude, and integrals of the
slopes' Taylor series about the end of the step.
"""

WAITS = 15
"""Half swings of the driver after the one that a step did not hold for."""

MOST_SPANS = 12
"""Most spans of forcing in a half swing; with more the driver's steps are as cheap."""

HOLDS, MISSES, PAST, UNKNOWN, DUE = range(5)
"""A step holds; its assumptions fail; the instant wanted lies beyond the impulse; the spans known
do not reach; a row is due on the way.
"""


class Rates(NamedTuple):
    """Coefficients of x^j of γ̇ and τ̇ over the pieces [rad/s]; None where a channel is absent.

    They have as many powers as the channels, which all have the same number.
    """

    line: FloatArray | None
    tilt: FloatArray | None


@inlined
def _fill_rates(
    channel: FloatArray | None, pieces: ForcingPieces, rates: FloatArray | None
) -> None:
    """Fill the coefficients of the time derivative of a channel."""
    if channel is None or rates is None:
        return
    powers = channel.shape[1]
    for i in range(channel.shape[0]):
        per_s = 1.0 / pieces.length_s[i]
        for j in range(1, powers):
            rates[i, j - 1] = channel[i, j] * (j * per_s)
        rates[i, powers - 1] = 0.0


class FreeHalfSwing(NamedTuple):
    """A half swing that begins at an impulse or a kink, and the spans that it may read.

    Attributes:
        wheel: the system that swings.
        k, x: span, and x of its piece, where it begins.
        last: last span that it may read.
        known_s: time from the beginning to the end of that [s].
        square: x² + y² above which the swing is clear of tilt and impulse.
        bend: bound of |γ̈| [rad/s2].
        powers: number of powers of every channel.
        spans, pieces, rates: all of them.
    """

    wheel: Wheel
    k: int
    x: float
    last: int
    known_s: float
    square: float
    bend: float
    powers: int
    spans: Spans
    pieces: ForcingPieces
    rates: Rates


@inlined
def _number(hot: HotPieces, k: int, which: int, x: Lanes) -> Lanes:
    """Return one of `HotNumbers` at lanes of x of piece k."""
    row, u = hot.interval[k] * HEAT_POWERS, fma(x, hot.size[k], hot.begin[k])
    value = fma(u, hot.terms[row + 3, which], hot.terms[row + 2, which])
    value = fma(value, u, hot.terms[row + 1, which])
    return fma(value, u, hot.terms[row, which])


@inlined
def _ship_at(half: FreeHalfSwing, k: int, x: float) -> Outside:
    """Return the forcing at x of piece k, without γ, and the machine's numbers there."""
    pieces, rates = half.pieces, half.rates
    per_s = 1.0 / pieces.length_s[k]
    line = line_slope = tilt = tilt_rate = tilt_slope = gravity = lean = 0.0
    # one loop for all channels: they are short, and the end of a loop may be mispredicted
    for j in range(half.powers - 1, -1, -1):
        if rates.line is not None:
            line_slope, line = fma(line_slope, x, line), fma(line, x, rates.line[k, j])
        if pieces.tilt is not None and rates.tilt is not None:
            tilt = fma(tilt, x, pieces.tilt[k, j])
            tilt_slope = fma(tilt_slope, x, tilt_rate)
            tilt_rate = fma(tilt_rate, x, rates.tilt[k, j])
        if pieces.gravity is not None:
            gravity = fma(gravity, x, pieces.gravity[k, j])
        if pieces.lean is not None:
            lean = fma(lean, x, pieces.lean[k, j])
    hot = None
    if pieces.hot is not None:
        terms, row = pieces.hot.terms, pieces.hot.interval[k] * HEAT_POWERS
        u = pieces.hot.begin[k] + pieces.hot.size[k] * x
        all_ = fma(load(terms, row + 3), u, load(terms, row + 2))
        all_ = fma(fma(all_, u, load(terms, row + 1)), u, load(terms, row))
        hot = HotNumbers(
            lane(all_, 0),
            lane(all_, 1),
            lane(all_, 2),
            lane(all_, 3),
            lane(all_, 4),
            lane(all_, 5),
            lane(all_, 6),
        )
    return Outside(
        ChannelAt(0.0, line, line_slope * per_s),
        ChannelAt(tilt, tilt_rate, tilt_slope * per_s),
        gravity,
        lean,
        hot,
    )


@inlined
def _place(half: FreeHalfSwing, time: float) -> tuple[int, float]:
    """Return span and x of its piece a time [s] after the beginning; the last span has no end."""
    k, x, spans, lengths = half.k, half.x, half.spans, half.pieces.length_s
    left = time
    while k < half.last:
        whole = (spans.end[k] - x) * lengths[k]
        if left < whole:
            break
        left -= whole
        k += 1
        x = spans.begin[k]
    return k, x + left / lengths[k]


@inlined
def _keep(row: FloatArray, later: Lanes, first: bool, value: Lanes) -> None:
    """Store values at the nodes of the first span, or at those that come later."""
    if not first:
        value = chosen(later, load(row), value)
    store(row, 0, value)


@inlined
def _fill_nodes(half: FreeHalfSwing, h: float, work: Work) -> None:
    """Fill the forcing at the nodes of a step of length h, each from its span."""
    spans, pieces, rates, nodes = half.spans, half.pieces, half.rates, work.nodes
    seconds, none = load(work.fractions) * h, filled(work.fractions, 0.0)
    wheel, k, x, since, interval = half.wheel, half.k, half.x, 0.0, -1
    felt = wheel.felt
    store(nodes.line_bend, 0, filled(none, half.bend))
    while True:
        length = pieces.length_s[k]
        per_s, first, later = 1.0 / length, k == half.k, seconds - since
        at = fma(later, per_s, x)
        line = tilt = gravity = lean = none
        for j in range(half.powers - 1, -1, -1):
            if rates.line is not None:
                line = fma(line, at, rates.line[k, j])
            if rates.tilt is not None and wheel.feels_drag:
                tilt = fma(tilt, at, rates.tilt[k, j])
            if pieces.gravity is not None:
                gravity = fma(gravity, at, pieces.gravity[k, j])
            if pieces.lean is not None:
                lean = fma(lean, at, pieces.lean[k, j])
        if felt.line is not None:
            _keep(nodes.line_rate, later, first, line)
        if felt.tilt is not None and wheel.feels_drag:
            _keep(nodes.tilt_rate, later, first, tilt)
        if felt.gravity is not None:
            _keep(nodes.gravity, later, first, gravity)
        if felt.lean is not None:
            _keep(nodes.lean, later, first, lean)
        if pieces.hot is not None and pieces.hot.interval[k] != interval:
            # one cubic holds over all pieces of a log interval
            hot, interval = pieces.hot, pieces.hot.interval[k]
            _keep(nodes.carried, later, first, _number(hot, k, 0, at))
            _keep(nodes.force, later, first, _number(hot, k, 1, at))
            _keep(nodes.stiffness, later, first, _number(hot, k, 2, at))
            _keep(nodes.weight, later, first, _number(hot, k, 3, at))
            _keep(nodes.viscous, later, first, _number(hot, k, 4, at))
            _keep(nodes.share, later, first, _number(hot, k, 5, at))
            _keep(nodes.growth, later, first, _number(hot, k, 6, at))
        since += (spans.end[k] - x) * length
        if since >= h or k == half.last:
            break
        k += 1
        x = spans.begin[k]


@inlined
def _arc_sine(x: float) -> float:
    """Return arcsin x to a thousandth for |x| < 0.6, for predictions."""
    square = x * x
    return x * (1.0 + square * (1 / 6 + square * (3 / 40 + square * (15 / 336))))


@inlined
def _predicted(run: SteppedRun, half: FreeHalfSwing, free: FreeState, usual_s: float) -> float:
    """Return the time to the next impulse [s], on a harmonic swing as `Wheel.ahead_s` does."""
    wheel, plane, way = half.wheel, run.state.planes[0], -float(run.state.direction)
    k, x = _place(half, usual_s)
    then = _ship_at(half, k, x)
    q, y = angle_at(wheel, plane.x), plane.y - free.line_rate / run.omega[0]
    per_size = 1.0 / math.sqrt(q * q + y * y)
    since, until = -way * q * per_size, (wheel.impulse - way * then.tilt.value) * per_size
    ahead = math.pi + _arc_sine(until) - _arc_sine(since)
    if wheel.felt.gravity is not None:
        # (1 + more)^(−1/2)
        more = 0.5 * (free.gravity + then.gravity) / wheel.gravity - 1.0
        ahead *= 1.0 - more * (0.5 - more * (0.375 - more * 0.3125))
    return ahead * (usual_s / math.pi)


@inlined
def _late(wheel: Wheel, way: float, now: Instant, omega: Omega) -> float:
    """Return the time to the impulse [s], a short one."""
    return _until(wheel.impulse - way * now.angle, way, now.rate, now.bend, omega)


@inlined
def _until(left: float, way: float, rate: float, bend: float, omega: Omega) -> float:
    """Return the time in which an angle moves `left` on its way, to the third order.

    Its rate [rad/s] changes by `bend` [rad/s2]; see `events.back_to`.
    """
    late = left / (way * rate)
    turned, phase = late * bend / rate, omega[0] * late
    return late * (1.0 - 0.5 * turned * (1.0 - turned) + phase * phase / 6.0)


@inlined
def _given(
    wheel: Wheel, mode: Mode, w: float, now: Instant, at: Outside, late: float, given: int
) -> float:
    """Return the momentum w that an impulse adds, a short time after an instant.

    It is `Wheel.strike` with ϑ, γ̇ and τ̇ carried on by their derivatives.
    """
    per_inertia, line, tilt = wheel_now(wheel, at).per_inertia, at.drive, at.tilt
    if per_inertia.impulse is None:
        return 0.0
    q = now.coordinate + late * (now.speed + 0.5 * late * now.acceleration)
    t, way = lever_arm(wheel.lever, mode.side, q).t, mode.direction
    line_rate, tilt_rate = line.rate + late * line.bend, tilt.rate + late * tilt.bend
    if wheel.shape is None:
        mass = mass_of(per_inertia.carried, t)
        rate = (w - line_rate) / mass + tilt_rate
        return kick(per_inertia.impulse, per_inertia.carried, t, rate, way, given) * mass
    per_n = math.sqrt(1.0 + (wheel.shape.k * q) * (wheel.shape.k * q))
    rate = (w - line_rate / per_n) / per_n + tilt_rate
    return kick(per_inertia.impulse, per_inertia.carried, t, rate, way, given) * per_n


@inlined
def _fill_rotations(omega: Omega, h: float, work: Work) -> None:
    """Fill the rotations to the nodes: by πξ from a table, and by (ωh − π)ξ in few terms."""
    nodes = work.nodes
    angle = load(work.fractions) * (omega[0] * h - math.pi)
    square = angle * angle
    sine, versine = filled(angle, SINE[6]), filled(angle, COSINE[6])
    for j in range(5, -1, -1):
        sine, versine = fma(sine, square, SINE[j]), fma(versine, square, COSINE[j])
    sine, versine = sine * angle, versine * square
    cosine_0, sine_0 = load(nodes.half_cosine), load(nodes.half_sine)
    store(work.cosine, PART_STEP, cosine_0 - fma(sine_0, sine, cosine_0 * versine))
    store(work.sine, PART_STEP, sine_0 + fma(cosine_0, sine, -(sine_0 * versine)))
    # these rows are not those of a step that `gauss_step` has made
    work.rotations[PART_STEP].h = math.nan


@inlined
def _turn(run: SteppedRun, time: float) -> tuple[float, float]:
    """Return cos and sin of the rotation over a time, near half a turn without a kink."""
    if run.system.kinked:
        return rotation(run.omega[0] * time)
    return _half_turn(run.omega[0] * time)


@inlined
def _half_turn(angle: float) -> tuple[float, float]:
    """Return cos and sin of an angle near π."""
    small = angle - math.pi
    square = small * small
    sine, versine = SINE[6], COSINE[6]
    for j in range(5, -1, -1):
        sine, versine = fma(sine, square, SINE[j]), fma(versine, square, COSINE[j])
    return versine * square - 1.0, -(sine * small)


class StepEnd(NamedTuple):
    """The end of a step: U and V, and the rotation to X and Y."""

    u: float
    v: float
    cosine: float
    sine: float

    @property
    def plane(self) -> Plane:
        """X and Y."""
        return Plane(
            self.cosine * self.u + self.sine * self.v, self.cosine * self.v - self.sine * self.u
        )


@inlined
def _end(run: SteppedRun, h: float) -> StepEnd:
    """Return the end of the step last collocated."""
    work, start, weights = run.work, run.state.planes[0], load(run.work.quadrature)
    cosine, sine = _turn(run, h)
    u = start.x + h * total(weights * load(work.k1))
    v = start.y + h * total(weights * load(work.k2))
    return StepEnd(u, v, cosine, sine)


@inlined
def _end_later(run: SteppedRun, h: float, late: float, end: StepEnd, drift: Plane) -> Plane:
    """Return the state a short time after the end of a step.

    The slopes there are those of the state, and change as the polynomial of the step does.
    """
    work, nodes, w = run.work, run.work.nodes, run.omega[0]
    eta, plane = late / h, end.plane
    d1, d2 = drift.x - w * plane.y, drift.y / w + w * plane.x
    k1, k2 = end.cosine * d1 - end.sine * d2, end.sine * d1 + end.cosine * d2
    weights = fma(load(nodes.third), eta, load(nodes.second))
    weights = fma(weights, eta, load(nodes.first)) * (eta * eta * h)
    u = end.u + (late * k1 + total(weights * load(work.k1)))
    v = end.v + (late * k2 + total(weights * load(work.k2)))
    cosine, sine = _turn(run, h + late)
    return StepEnd(u, v, cosine, sine).plane


@inlined
def _holds(run: SteppedRun, half: FreeHalfSwing, mode: Mode, error: float, h: float) -> bool:
    """Return whether a step is exact enough, within range, and clear of tilt and impulse."""
    wheel, omega, work = half.wheel, run.omega, run.work
    tail, start = load(work.tail), run.state.planes[0]
    last = max(abs(total(tail * load(work.k1))), abs(total(tail * load(work.k2)))) * h
    size = math.sqrt(start.x * start.x + start.y * start.y)
    if not step_error(run.tolerance.factor, last / size, False) <= error:
        return False
    if not wheel.clear(half.square, omega, work):
        return False
    if wheel.has_weight:
        # by rough bounds alone, since the row of γ̈ is a bound
        return surely_within(wheel_at_nodes(wheel, work), mode, omega, work)
    beyond = wheel.beyond(mode, omega, work)
    return beyond.within and beyond.edge > 1.0 and beyond.slack > 1.0


@inlined
def _settle(step: Step, least: int, floor: float) -> bool:
    """Sweep the stages `least` times and until they have settled; return whether so.

    As `gauss_step.sweep`, which looks at the changes from the first sweep on.
    """
    work, start = step.work, step.planes[0]
    before = change = math.inf
    for n in range(least + MORE_SWEEPS):
        evaluate(step)
        if n >= least and change * change <= floor * (before - change):
            return True
        u, v = folded_both(work.folded, 0, WIDE_SIZE // 2 + 1, load(work.k1), load(work.k2))
        u, v = fma(u, step.h, start.x), fma(v, step.h, start.y)
        if n >= least - 2:
            before = change
            change = largest(larger(u - load(work.u), v - load(work.v)))
        store(work.u, 0, u)
        store(work.v, 0, v)
    return False


@inlined
def _to_impulse(
    run: SteppedRun, half: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next impulse and let it act, or leave all as it is.

    Returns HOLDS or MISSES, and the length of the step [s].
    """
    wheel, omega, state, work = half.wheel, run.omega, run.state, run.work
    way, plane, usual_s = -float(state.direction), state.planes[0], free_end.usual_s
    mode = Mode(float(state.side), way, float(state.pallet))
    h = _predicted(run, half, free, usual_s)
    for n in range(MOST_LENGTHS):
        if not SHORTEST * usual_s < h < LONGEST * usual_s:
            return MISSES, 0.0
        _fill_nodes(half, h, work)
        _fill_rotations(omega, h, work)
        if n == 0:
            store(work.u, 0, fma(load(work.nodes.land_u), plane.y, plane.x))
            store(work.v, 0, fma(load(work.nodes.land_v), plane.y, plane.y))
        step = Step(wheel, mode, omega, h, PART_STEP, state.planes, work)
        if not _settle(step, free_end.sweeps, free_end.settled * abs(plane.y)):
            return MISSES, 0.0
        k, x = _place(half, h)
        at, end = _ship_at(half, k, x), _end(run, h)
        now = wheel.instant(mode, omega, (end.plane,), at)
        if not way * now.rate > 0.0:
            return MISSES, 0.0
        late = _late(wheel, way, now, omega)
        if omega[0] * abs(late) > free_end.near:
            h += late
            continue
        if not _holds(run, half, mode, free_end.error, h):
            return MISSES, 0.0
        found = signs_at_nodes(wheel.coordinates(work), plane.x < 0.0, NOWHERE, work)
        drift, since = wheel.drift(mode, omega, at, now)[0], late
        if omega[0] * abs(late) > free_end.close:
            # look again from where the impulse was expected
            there = _end_later(run, h, late, end, drift)
            k, x = _place(half, h + late)
            at = _ship_at(half, k, x)
            now = wheel.instant(mode, omega, (there,), at)
            since = _late(wheel, way, now, omega)
            late += since
        there = _end_later(run, h, late, end, drift)
        added = _given(wheel, mode, omega[0] * there.y, now, at, since, state.given)
        plane.x, plane.x_rest, plane.y_rest = there.x, 0.0, 0.0
        plane.y = there.y + added / omega[0]
        free.line_rate, free.gravity = at.drive.rate + since * at.drive.bend, at.gravity
        state.direction = -state.direction
        state.armed, state.pallet = False, state.direction
        state.given += 1
        count_step(True, found, run, 0, 0.0)
        return HOLDS, h + late
    return MISSES, 0.0


AT_ONCE = 1e-9
"""Phase from the kink to the impulse, or back, within which both happen at one place [rad]."""

SHORT, MOST_LATE = 0.3, 0.05
"""Longest step to an event that lies ahead, over half a swing on land; and the largest error of a
predicted length, over the length, at which a step is not made anew.
"""

ONWARD_SWEEPS = 2
"""Least sweeps of such a step: it is short."""


@inlined
def _goes_on(state: RunningState) -> bool:
    """Return whether kink or impulse come before the turning point of θ."""
    return state.armed or state.side * state.direction < 0


@inlined
def _expected(run: SteppedRun, half: FreeHalfSwing, free: FreeState, free_end: FreeEnd) -> float:
    """Return the time to the next kink or impulse, whichever comes first [s]."""
    wheel, state, plane = half.wheel, run.state, run.state.planes[0]
    d, q, y = float(state.direction), plane.x, plane.y - free.line_rate / run.omega[0]
    per_size = 1.0 / math.sqrt(q * q + y * y)
    since = _arc_sine(d * q * per_size)
    if _goes_on(state):
        reach = 0.0
        if state.armed:
            k, x = _place(half, 0.0)
            reach = wheel.impulse - d * _ship_at(half, k, x).tilt.value
        return (_arc_sine(reach * per_size) - since) / run.omega[0]
    k, x = _place(half, free_end.usual_s)
    then, quicker = _ship_at(half, k, x), 1.0
    if wheel.felt.gravity is not None:
        # (1 + more)^(−1/2)
        more = 0.5 * (free.gravity + then.gravity) / wheel.gravity - 1.0
        quicker -= more * (0.5 - more * (0.375 - more * 0.3125))
    # from kink to kink a larger swing takes another time; heavier, the same Y is a smaller one
    larger_by = quicker / (per_size * free_end.swing) - 1.0
    half_s = free_end.usual_s * quicker * (1.0 + free_end.slower * larger_by)
    reach = min(0.0, wheel.impulse + d * then.tilt.value)
    return half_s + (_arc_sine(reach * per_size) - since) / run.omega[0]


@inlined
def _late_for_kink(way: float, now: Instant, omega: Omega) -> float:
    """Return the time to the kink [s], a short one."""
    return _until(-way * now.coordinate, way, now.speed, now.acceleration, omega)


@inlined
def _solve(
    run: SteppedRun, half: FreeHalfSwing, free_end: FreeEnd, mode: Mode, h: float
) -> tuple[bool, bool, float, float]:
    """Collocate the step to the next kink or impulse, which is expected after a time h [s].

    Returns whether it holds, whether it ends with an impulse, its length, and how far beyond it
    the event is [s].
    """
    wheel, omega, state, work, way = half.wheel, run.omega, run.state, run.work, mode.direction
    plane, usual_s, turns = state.planes[0], free_end.usual_s, not _goes_on(state)
    shortest, longest = (
        (SHORTEST * usual_s, LONGEST * usual_s) if turns else (0.0, SHORT * usual_s)
    )
    least, settled = free_end.sweeps, free_end.settled
    if not turns:
        least, settled = ONWARD_SWEEPS, ROW_SETTLED * settled
    struck, late = state.armed, 0.0
    for n in range(MOST_LENGTHS):
        if not shortest < h < longest:
            break
        _fill_nodes(half, h, work)
        step = Step(wheel, mode, omega, h, PART_STEP, state.planes, work)
        fill_rotations(step)
        if n == 0:
            start_stages(step)
            if turns:
                store(work.u, 0, fma(load(work.nodes.land_u), plane.y, plane.x))
                store(work.v, 0, fma(load(work.nodes.land_v), plane.y, plane.y))
        if not _settle(step, least, settled * abs(plane.y)):
            break
        k, x = _place(half, h)
        now = wheel.instant(mode, omega, (_end(run, h).plane,), _ship_at(half, k, x))
        if not (way * now.rate > 0.0 and way * now.speed > 0.0):
            break
        kink, impulse = _late_for_kink(way, now, omega), _late(wheel, way, now, omega)
        if turns:
            struck = impulse < kink
        late = impulse if struck else kink
        if omega[0] * abs(late) <= free_end.near and abs(late) <= MOST_LATE * h:
            return _holds(run, half, mode, free_end.error, h), struck, h, late
        h += late
    return False, struck, h, late


@inlined
def _act(
    run: SteppedRun,
    half: FreeHalfSwing,
    free: FreeState,
    mode: Mode,
    struck: bool,
    there: Plane,
    at: Outside,
    now: Instant,
    since: float,
) -> None:
    """Let an impulse or the kink act on the state `there`, a short time after an instant."""
    state, plane, turns = run.state, run.state.planes[0], not _goes_on(run.state)
    added = 0.0
    if struck:
        w = run.omega[0] * there.y
        added = _given(half.wheel, mode, w, now, at, since, state.given)
    plane.x, plane.x_rest, plane.y_rest = there.x, 0.0, 0.0
    plane.y = there.y + added / run.omega[0]
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
    run: SteppedRun, half: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next kink or impulse and let it act, or leave all as it is.

    Returns HOLDS or MISSES, and the length of the step [s].
    """
    wheel, omega, state, work = half.wheel, run.omega, run.state, run.work
    plane, onward = state.planes[0], _goes_on(state)
    way = float(state.direction) if onward else -float(state.direction)
    mode = Mode(float(state.side), way, float(state.pallet))
    h = _expected(run, half, free, free_end)
    if onward and omega[0] * abs(h) < AT_ONCE:
        k, x = _place(half, 0.0)
        at = _ship_at(half, k, x)
        now = wheel.instant(mode, omega, planes_of(omega, state.planes), at)
        _act(run, half, free, mode, state.armed, Plane(plane.x, plane.y), at, now, 0.0)
        return HOLDS, 0.0
    held, struck, h, late = _solve(run, half, free_end, mode, h)
    if not held:
        return MISSES, 0.0
    found = signs_at_nodes(wheel.coordinates(work), plane.x < 0.0, NOWHERE, work)
    k, x = _place(half, h)
    at, end = _ship_at(half, k, x), _end(run, h)
    now = wheel.instant(mode, omega, (end.plane,), at)
    drift, since = wheel.drift(mode, omega, at, now)[0], late
    if omega[0] * abs(late) > free_end.close:
        # look again from where the event was expected
        there = _end_later(run, h, late, end, drift)
        k, x = _place(half, h + late)
        at = _ship_at(half, k, x)
        now = wheel.instant(mode, omega, (there,), at)
        since = _late(wheel, way, now, omega) if struck else _late_for_kink(way, now, omega)
        late += since
    _act(run, half, free, mode, struck, _end_later(run, h, late, end, drift), at, now, since)
    count_step(True, found, run, 0, 0.0)
    return HOLDS, h + late


@inlined
def _onward(
    run: SteppedRun, half: FreeHalfSwing, free: FreeState, free_end: FreeEnd
) -> tuple[int, float]:
    """Step to the next event, as `_to_impulse`."""
    if half.wheel.kinked:
        return _to_event(run, half, free, free_end)
    return _to_impulse(run, half, free, free_end)


@inlined
def _is_past(wheel: Wheel, state: RunningState, now: Instant) -> bool:
    """Return whether the next event of a state is past at an instant."""
    d = float(state.direction)
    if wheel.kinked:
        onward = _goes_on(state)
        way = d if onward else -d
        struck = (state.armed or not onward) and not way * now.angle < wheel.impulse
        crossed = not state.armed and not state.side * now.coordinate > 0.0
        return (onward or way * now.rate > 0.0) and (struck or crossed)
    return d * now.rate < 0.0 and not -d * now.angle < wheel.impulse


@inlined
def _to_row(
    run: SteppedRun, half: FreeHalfSwing, free: FreeState, free_end: FreeEnd, row: LoggedRow
) -> int:
    """Write the row at the end of the last span if it precedes the impulse; the state stays."""
    wheel, omega, state, work = half.wheel, run.omega, run.state, run.work
    plane, h, mode = state.planes[0], half.known_s, mode_of(state)
    if wheel.kinked and h > LONGEST * _expected(run, half, free, free_end):
        return PAST
    _fill_nodes(half, h, work)
    step = Step(wheel, mode, omega, h, PART_STEP, state.planes, work)
    fill_rotations(step)
    start_stages(step)
    settled, _ = sweep(step, max(LEAST_SETTLED, ROW_SETTLED * free_end.settled), MAX_SWEEPS)
    if not settled:
        return MISSES
    finish(step)
    k, x = _place(half, h)
    at = _ship_at(half, k, x)
    now = wheel.instant(mode, omega, planes_of(omega, work.end), at)
    if _is_past(wheel, state, now):
        return PAST
    if not _holds(run, half, mode, free_end.error, h):
        return MISSES
    # the state is advanced for the row, and then restored
    turns, beats = state.turns, state.beats
    x, x_rest, y, y_rest = plane.x, plane.x_rest, plane.y, plane.y_rest
    found = signs_at_nodes(wheel.coordinates(work), x < 0.0, NOWHERE, work)
    copy_planes(omega, work.end, state.planes)
    count_step(True, found, run, 0, 0.0)
    write_row(run, at, row)
    state.turns, state.beats = turns, beats
    plane.x, plane.x_rest, plane.y, plane.y_rest = x, x_rest, y, y_rest
    return HOLDS


@inlined
def _ahead(
    start: FreeHalfSwing, shown: int, reach_s: float, squares: FloatArray, bends: FloatArray
) -> tuple[int, FreeHalfSwing]:
    """Return the spans to read: up to a row that is due, or as far as a half swing may last.

    What is read so does not depend on how many spans are known. The code is DUE, HOLDS, UNKNOWN,
    or MISSES where there are too many.
    """
    spans, k, last, x = start.spans, start.k, start.k, start.x
    known_s, square, bend, code = 0.0, 0.0, 0.0, UNKNOWN
    while True:
        known_s += (spans.end[last] - x) * start.pieces.length_s[last]
        square, bend = max(square, squares[last]), max(bend, bends[last])
        if known_s >= reach_s:
            code = HOLDS
        elif spans.logged[last] and last >= shown:
            code = DUE
        elif last - k == MOST_SPANS:
            code = MISSES
        if code != UNKNOWN or last + 1 == len(spans.begin):
            break
        last += 1
        x = spans.begin[last]
    known = FreeHalfSwing(
        start.wheel,
        k,
        start.x,
        last,
        known_s,
        square,
        bend,
        start.powers,
        spans,
        start.pieces,
        start.rates,
    )
    return code, known


@entry
def advance_freely(
    system: Wheel,
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
    free: FreeState,
    free_end: FreeEnd,
) -> tuple[int, int, float]:
    """Advance the state over all spans, as `stepping.advance` does; the rates are filled first.

    Returns a code, and the span and the x in its piece where the run ended: with OK, the span from
    which on they are needed again.
    """
    run = SteppedRun(system, omega, tolerance, state, work)
    reach_s, written, count = LONGEST * free_end.usual_s, 0, len(spans.begin)
    squares, bends = np.empty(count), np.empty(count)
    _fill_rates(pieces.drive, pieces, rates.line)
    _fill_rates(pieces.tilt, pieces, rates.tilt)
    for i in range(count):
        _, bends[i] = bounds_of(rates.line, i, 1.0 / pieces.length_s[i])
        squares[i] = system.clear_square(omega, pieces, i, abs(system.impulse))
    k, shown = 0, free.shown
    while k < count:
        x = free.x if free.free else spans.begin[k]
        start = FreeHalfSwing(system, k, x, k, 0.0, 0.0, 0.0, powers, spans, pieces, rates)
        if free.free and free.waits == 0:
            time = 0.0
            code, half = _ahead(start, shown, reach_s, squares, bends)
            if code == UNKNOWN:
                break
            if code == DUE:
                code = _to_row(run, half, free, free_end, rows[written])
                if code == HOLDS:
                    written += 1
                    shown = half.last + 1
                    continue
            if code != MISSES:
                code, time = _onward(run, half, free, free_end)
            if code == HOLDS:
                j, x = _place(half, time)
                further = sum_exactly(free.x, free.x_rest + time / pieces.length_s[k])
                x, free.x_rest = further if j == k else (x, 0.0)
                free.x = min(x, spans.end[j])
                k = j
                continue
            free.waits, free.missed = WAITS + 1, free.missed + 1
        # the driver continues to the next impulse, or to the end of the span
        code, x, _ = over_span(k, run, longest_s, pieces, spans, spans.logged[k], x, True)
        if code == STRUCK:
            at = _ship_at(start, k, x)
            free.x, free.x_rest, free.free = x, 0.0, True
            free.line_rate, free.gravity = at.drive.rate, at.gravity
            free.waits = max(free.waits - 1, 0)
            continue
        if code != OK:
            return code, k, x
        if spans.logged[k] and k >= shown:
            write_row(run, _ship_at(start, k, x), rows[written])
            written += 1
        free.free = False
        k += 1
    free.shown = max(shown - k, 0)
    return OK, k, 0.0


def _joined(first: Forcing | None, second: Forcing) -> Forcing:
    """Return the spans of one forcing and then those of another."""
    if first is None:
        return second
    before, after = first.temperatures, second.temperatures
    temperatures = after
    if before is not None and after is not None:
        # an interval that both have is there once, so that its spans are known to lie in one
        new = 1 if before.begin_s[-1] == after.begin_s[0] else 0
        temperatures = Temperatures(
            np.concatenate([before.celsius, after.celsius[new:]]),
            np.concatenate([before.begin_s, after.begin_s[new:]]),
            after.interval_s,
            np.concatenate([before.interval, after.interval + (len(before.begin_s) - new)]),
            np.concatenate([before.place, after.place]),
        )

    def both(name: str) -> Any:
        one, two = getattr(first, name), getattr(second, name)
        if one is None:
            return None
        if one.ndim == 2 and one.shape[1] != two.shape[1]:
            powers = max(one.shape[1], two.shape[1])
            one, two = (np.pad(each, ((0, 0), (0, powers - each.shape[1]))) for each in (one, two))
        return np.concatenate([one, two])

    return replace(second, **{name: both(name) for name in _SPANNED}, temperatures=temperatures)


def _part(forcing: Forcing, first: int) -> Forcing:
    """Return the spans from the first wanted on."""
    parts: dict[str, Any] = {
        name: None if (rows := getattr(forcing, name)) is None else rows[first:].copy()
        for name in _SPANNED
    }
    felt = forcing.temperatures
    if felt is not None:
        passed = int(felt.interval[first])
        felt = Temperatures(
            felt.celsius[passed:].copy(),
            felt.begin_s[passed:].copy(),
            felt.interval_s,
            felt.interval[first:] - passed,
            felt.place[first:].copy(),
        )
    return replace(forcing, **parts, temperatures=felt)


def _evened(pieces: ForcingPieces) -> tuple[ForcingPieces, int]:
    """Return the pieces with as many powers in each channel, and how many; none without any."""
    channels = {name: getattr(pieces, name) for name in ('drive', 'tilt', 'gravity', 'lean')}
    powers = max((row.shape[1] for row in channels.values() if row is not None), default=0)
    padded: dict[str, Any] = {
        name: np.pad(row, ((0, 0), (0, powers - row.shape[1])))
        for name, row in channels.items()
        if row is not None and row.shape[1] < powers
    }
    return pieces._replace(**padded), powers


_SPANNED = (
    'length_s',
    'begin',
    'end',
    'end_ns',
    'logged',
    'neutral',
    'tilt',
    'gravity',
    'lean',
)


class FreeEndCollocation(Collocation):
    """Propagator of a wheel with an escapement that steps from impulse to impulse."""

    def __init__(self, machine: Machine, tolerance: float | None, sweeps: int) -> None:
        super().__init__(machine, tolerance, WIDE_SIZE)
        self._free_end = free_end_of(machine, sweeps)
        self._free = np.zeros((), FREE)
        self._kept: Forcing | None = None
        rows, columns = (HOT_NODES, 2 * SIZE) if self._hot else (WHEEL_NODES, SIZE)
        self._work = make_work(1, (*rows, *CONSTANTS), WIDE_SIZE, columns)
        constants, nodes = gauss_constants(WIDE_SIZE), self._work['nodes']
        nodes['half_cosine'] = np.cos(math.pi * constants.nodes)
        nodes['half_sine'] = np.sin(math.pi * constants.nodes)
        land = _on_land(machine, self._shape, self._omega)
        nodes['land_u'], nodes['land_v'] = land.u, land.v
        # integrals of the slopes' Taylor series about the end, by derivatives of Legendre's P_n
        n, at_end = np.arange(WIDE_SIZE), np.ones(WIDE_SIZE)
        for j, name in enumerate(('first', 'second', 'third'), start=1):
            at_end = at_end * (n - j + 1) * (n + j) / (2.0 * j)
            nodes[name] = (2.0**j / math.factorial(j + 1) * at_end) @ constants.projection

    @property
    def missed(self) -> int:
        """Steps so far that did not hold, after each of which the driver took `WAITS` + 1."""
        return int(self._free['missed'])

    def release(self, forcing: Forcing) -> Motion:
        """Release the wheel, as `Collocation`."""
        self._free[()], self._kept = np.zeros((), FREE), None
        return super().release(forcing)

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans, as `Collocation`; keep those of a half swing under way."""
        forcing, self._kept = _joined(self._kept, forcing), None
        return super().advance(forcing)

    def _run(
        self,
        forcing: Forcing,
        moved: Moved,
        tolerance: Tolerance,
        longest_s: float,
        state: NDArray[np.void] | None = None,
        work: NDArray[np.void] | None = None,
    ) -> tuple[NDArray[np.void], int, int, float]:
        shown = int(self._free['shown'])
        rows = np.empty(int(np.count_nonzero(forcing.logged[shown:])), ROW)
        pieces, powers = _evened(self._outside(forcing))
        rates = (
            None if row is None else np.empty_like(row) for row in (pieces.drive, pieces.tilt)
        )
        code, k, x = advance_freely(
            *moved,
            tolerance,
            longest_s,
            pieces,
            Spans(forcing.begin, forcing.end, forcing.logged),
            self._state,
            self._work,
            rows,
            Rates(*rates),
            powers,
            self._free,
            self._free_end,
        )
        if code == OK:
            self._kept = _part(forcing, k) if k < len(forcing.begin) else None
        else:
            # no row beyond the place of a slack thread is shown: free-end steps are surely taut
            rows = rows[: np.count_nonzero(forcing.logged[shown:k])]
            self._free['free'], self._free['shown'] = False, 0
        return rows, code, k, x

    def state(self) -> State:
        """Return the running state, and the spans of the half swing that is under way."""
        kept = self._kept
        spans = None
        if kept is not None:
            felt = kept.temperatures
            spans = {name: getattr(kept, name) for name in _SPANNED}
            spans['temperatures'] = None if felt is None else dict(vars(felt))
        return {**super().state(), 'free': state_of(self._free), 'spans': spans}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        super().restore(state)
        restore_record(self._free, state['free'])
        spans, self._kept = state['spans'], None
        if spans is not None:
            felt = spans['temperatures']
            felt = None if felt is None else Temperatures(**felt)
            self._kept = Forcing(**{**spans, 'temperatures': felt})
