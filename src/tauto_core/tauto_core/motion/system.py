"""The interface between the driver and a system, and the motion of the ship that it feels.

A system – a wheel, a lever, a swinging thread, a case – is a NamedTuple of numbers with the
methods of `System`. Branches that are decided when compiling cost nothing: a wheel without an
escapement has no code for impulses.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.gauss_step import Mode, Omega, Planes, Work, inside
from tauto_core.motion.lanes import (
    SIZE,
    Lanes,
    Numeric,
    chosen,
    filled,
    fma,
    lane,
    lowest,
    row_of,
    store,
    width,
)
from tauto_core.samples import FloatArray, IntArray

# -----------------------------------------------------------------------------
# The motion of the ship: at an instant, and at the nodes of a step.
#
# The forcing consists of pieces, in each of which every channel is a polynomial of x, 0 to 1. For
# the piece of a span, `set_piece` lays the polynomials of all channels and of their time
# derivatives side by side, the coefficients of a power of x in each row of `work.piece`: one pass
# of Horner's scheme then evaluates them all.

DRIVE, DRIVE_RATE, DRIVE_BEND, TILT, TILT_RATE, TILT_BEND, APPARENT_GRAVITY, LEAN = range(8)
"""Columns of a piece: the drive and the tilt, each with two time derivatives; gravity, lean."""

HEAT_POWERS = 4
"""Powers of x of a number of the machine over a log interval: a cubic."""


class HeatTerms(NamedTuple):
    """The numbers of a machine that heat changes, over its inertia I, as columns of a piece.

    Attributes:
        carried, force, stiffness, weight, viscous: as in `wells.PerInertia`. Of a lever `weight`
            is κ (`lever`); of a swinging thread it is m r/I, `carried` r and `force` ṙ [m/s].
        share: I at `at_celsius`, where the machine's numbers hold, over I. Torques on the wheel
            that heat does not change are multiplied by it.
        growth: İ/I [1/s].
    """

    carried: Numeric
    force: Numeric
    stiffness: Numeric
    weight: Numeric
    viscous: Numeric
    share: Numeric
    growth: Numeric


HOT, HOT_NUMBERS = SIZE, 7
"""First column of `HeatTerms`, and how many; columns beyond `SIZE` are there where heat acts."""


class HeatPieces(NamedTuple):
    """The numbers of the machine over log intervals, and where in them the pieces lie.

    Attributes:
        terms: coefficients of u^j, u from 0 to 1 over an interval: a row of `HeatTerms` for each
            power of each interval, (intervals · HEAT_POWERS, SIZE).
        interval: the interval of each span, (n,).
        begin, size: u where the piece of a span begins, and its length in u, (n,).
    """

    terms: FloatArray
    interval: IntArray
    begin: FloatArray
    size: FloatArray


class ForcingPieces(NamedTuple):
    """ForcingPieces of forcing; a channel is None where it is absent.

    Attributes:
        length_s: length of each piece [s], (n,).
        drive, tilt, gravity, lean: coefficients of x^j of the channels of `Inputs`, (n, powers).
        hot: the numbers of the machine, where heat changes them.
    """

    length_s: FloatArray
    drive: FloatArray | None
    tilt: FloatArray | None
    gravity: FloatArray | None
    lean: FloatArray | None = None
    hot: HeatPieces | None = None


class StepPlace(NamedTuple):
    """Where a step is.

    Attributes:
        length: length of its piece of forcing [s].
        terms: number of powers in use.
        begin: where the step begins, in x of the piece.
        size: length of the step, in x: size · length seconds.
    """

    length: float
    terms: int
    begin: float
    size: float


class ChannelAt(NamedTuple):
    """A channel at an instant: its value, and its first and second time derivative."""

    value: float
    rate: float
    bend: float


class Inputs(NamedTuple):
    """The motion of the ship at an instant; zeros where a channel is absent.

    Attributes:
        drive: the forcing of the system. For a machine it is the direction of its thread's neutral
            line [rad]: γ of a wheel, β of the apparent vertical for a lever or a swinging thread
            (`Forcing.neutral`). For a suspended case it is ÿ of its bearing [m/s2].
        tilt: τ, the angle of the neutral line in the case [rad]; absent for a suspended case.
        gravity: the apparent gravity [m/s2]: g_eff of a machine, g + z̈ of a suspended case.
        lean: β − γ, the apparent vertical less the drive of an unbalanced wheel [rad].
        hot: the machine's numbers; None where heat does not change them.
    """

    drive: ChannelAt
    tilt: ChannelAt
    gravity: float
    lean: float = 0.0
    hot: HeatTerms | None = None


@compiled
def _terms(channel: FloatArray | None) -> int:
    """Return the number of powers of a channel."""
    return 0 if channel is None else channel.shape[1]


@inlined
def _set_channel(
    channel: FloatArray | None, k: int, column: int, per_s: float, terms: int, work: Work
) -> None:
    """Fill three columns with a channel and its first two time derivatives."""
    if channel is None:
        return
    powers, size = channel.shape[1], width(work.piece)
    above = above_rate = 0.0
    for j in range(terms - 1, -1, -1):
        coefficient = channel[k, j] if j < powers else 0.0
        rate, bend = (j + 1) * per_s * above, (j + 1) * per_s * above_rate
        place = j * size + column
        work.piece[place], work.piece[place + 1], work.piece[place + 2] = coefficient, rate, bend
        above, above_rate = coefficient, rate


@inlined
def _set_hot(hot: HeatPieces, k: int, work: Work) -> None:
    """Fill the columns of the machine's numbers: p(begin + size · x) of each polynomial p(u)."""
    row, b, s, size = hot.interval[k] * HEAT_POWERS, hot.begin[k], hot.size[k], width(work.piece)
    for i in range(HOT_NUMBERS):
        a0, a1 = hot.terms[row, i], hot.terms[row + 1, i]
        a2, a3 = hot.terms[row + 2, i], hot.terms[row + 3, i]
        place = HOT + i
        work.piece[place] = a0 + b * (a1 + b * (a2 + b * a3))
        work.piece[place + size] = s * (a1 + b * (2.0 * a2 + 3.0 * b * a3))
        work.piece[place + 2 * size] = s * s * (a2 + 3.0 * b * a3)
        work.piece[place + 3 * size] = s * s * s * a3


@compiled
def set_piece(pieces: ForcingPieces, k: int, tilted: bool, work: Work) -> tuple[float, int]:
    """Lay out piece k, of at most `MOST_POWERS`; return its length [s] and its powers.

    The number of powers is made even, since `outside_at` takes two at a time. Columns of absent
    channels stay zero, and those of τ as they are unless `tilted`.
    """
    drive, tilt, gravity = pieces.drive, pieces.tilt, pieces.gravity
    per_s = 1.0 / pieces.length_s[k]
    terms = max(_terms(drive), _terms(tilt), _terms(gravity))
    if pieces.hot is not None:
        terms = max(terms, HEAT_POWERS)
        _set_hot(pieces.hot, k, work)
    terms += terms % 2
    _set_channel(drive, k, DRIVE, per_s, terms, work)
    if tilted:
        _set_channel(tilt, k, TILT, per_s, terms, work)
    if gravity is not None:
        powers, size = gravity.shape[1], width(work.piece)
        for j in range(terms):
            work.piece[j * size + APPARENT_GRAVITY] = gravity[k, j] if j < powers else 0.0
    if pieces.lean is not None:
        powers, size = pieces.lean.shape[1], width(work.piece)
        for j in range(terms):
            work.piece[j * size + LEAN] = pieces.lean[k, j] if j < powers else 0.0
    return pieces.length_s[k], terms


@inlined
def powers_at(rows: FloatArray, first_row: int, count: int, x: float) -> Lanes:
    """Return Σ x^j · row (first_row + j).

    Even and odd powers are summed apart, so that half as many operations wait for one another.
    """
    even, odd, square = filled(rows, 0.0), filled(rows, 0.0), x * x
    if count % 2 == 1:
        even = row_of(rows, first_row + count - 1)
    for j in range(first_row + count - 1 - count % 2, first_row, -2):
        odd = fma(odd, square, row_of(rows, j))
        even = fma(even, square, row_of(rows, j - 1))
    return fma(odd, x, even)


@inlined
def hot_of(values: Lanes, first_lane: int) -> HeatTerms:
    """Return the machine's numbers, which lie side by side from a lane on."""
    return HeatTerms(
        lane(values, first_lane),
        lane(values, first_lane + 1),
        lane(values, first_lane + 2),
        lane(values, first_lane + 3),
        lane(values, first_lane + 4),
        lane(values, first_lane + 5),
        lane(values, first_lane + 6),
    )


@inlined
def outside_of(values: Lanes, hot: HeatTerms | None) -> Inputs:
    """Return the forcing by its columns at an instant."""
    return Inputs(
        ChannelAt(lane(values, DRIVE), lane(values, DRIVE_RATE), lane(values, DRIVE_BEND)),
        ChannelAt(lane(values, TILT), lane(values, TILT_RATE), lane(values, TILT_BEND)),
        lane(values, APPARENT_GRAVITY),
        lane(values, LEAN),
        hot,
    )


@compiled
def outside_at(terms: int, x: float, work: Work) -> Inputs:
    """Return the forcing at x of the current piece."""
    values = powers_at(work.piece, 0, terms, x)
    return outside_of(values, hot_of(values, HOT) if width(work.piece) > SIZE else None)


@inlined
def nodes_of(place: StepPlace, work: Work) -> Lanes:
    """Return x at the nodes of a step."""
    return row_of(work.fractions) * place.size + place.begin


@inlined
def column_at(which: int, terms: int, x: Lanes, work: Work) -> Lanes:
    """Return a column of the piece at lanes of x."""
    value, size = filled(x, 0.0), width(work.piece)
    for j in range(terms - 1, -1, -1):
        value = fma(value, x, work.piece[j * size + which])
    return value


@inlined
def columns(column: int, terms: int, x: Lanes, work: Work) -> tuple[Lanes, Lanes]:
    """Return a column and the next one, side by side, at lanes of x."""
    a, b, size = filled(x, 0.0), filled(x, 0.0), width(work.piece)
    for j in range(terms - 1, -1, -1):
        place = j * size + column
        a, b = fma(a, x, work.piece[place]), fma(b, x, work.piece[place + 1])
    return a, b


@inlined
def difference(column: int, second: int, terms: int, x: Lanes, work: Work) -> Lanes:
    """Return the first column of the piece less the second at lanes of x."""
    value, size = filled(x, 0.0), width(work.piece)
    for j in range(terms - 1, -1, -1):
        place = j * size
        value = fma(value, x, work.piece[place + column] - work.piece[place + second])
    return value


@inlined
def fill_hot(x: Lanes, work: Work) -> None:
    """Fill the rows of the machine's numbers at lanes of x."""
    nodes = work.nodes
    store(nodes.carried, 0, column_at(HOT, HEAT_POWERS, x, work))
    store(nodes.force, 0, column_at(HOT + 1, HEAT_POWERS, x, work))
    store(nodes.stiffness, 0, column_at(HOT + 2, HEAT_POWERS, x, work))
    store(nodes.weight, 0, column_at(HOT + 3, HEAT_POWERS, x, work))
    store(nodes.viscous, 0, column_at(HOT + 4, HEAT_POWERS, x, work))
    store(nodes.share, 0, column_at(HOT + 5, HEAT_POWERS, x, work))
    store(nodes.growth, 0, column_at(HOT + 6, HEAT_POWERS, x, work))


@inlined
def keep(row: FloatArray, times: Lanes, initial: bool, value: Lanes) -> None:
    """Store values at the nodes of the first span, or at those that come later."""
    if not initial:
        value = chosen(times, row_of(row), value)
    store(row, 0, value)


@inlined
def hot_at_nodes(work: Work) -> HeatTerms:
    """Return the machine's numbers at the nodes of a step, after `fill_hot`."""
    rows = work.nodes
    return HeatTerms(
        row_of(rows.carried),
        row_of(rows.force),
        row_of(rows.stiffness),
        row_of(rows.weight),
        row_of(rows.viscous),
        row_of(rows.share),
        row_of(rows.growth),
    )


# -----------------------------------------------------------------------------
# The interface of a system to the driver.

NOWHERE = 2.0
"""A fraction beyond any step."""


class Plane(NamedTuple):
    """X and Y of a rotating plane at an instant."""

    x: float
    y: float


class Instant(NamedTuple):
    """The system at an instant.

    Attributes:
        angle, rate, bend: θ [rad], θ̇ and θ̈: of the wheel in its case, or of a suspended case's
            contact.
        tension: tension of the thread, or force in a suspended case's contact, or a quantity of
            the same sign.
        margin: a quantity that is positive within the range of the system, and only there.
        torque: torque of the thread on the wheel, over I [rad/s2].
        coordinate, speed, acceleration: the quantity whose upward passages of zero are counted as
            turns of the phase, and its first two time derivatives: ϑ of the wheel, s of the lever,
            u of the swinging thread, φ of a suspended case.
        drift: the time derivatives of X and ωY of each plane, where `System.drift` takes them
            from here.
    """

    angle: float
    rate: float
    bend: float
    tension: float
    margin: float
    torque: float
    coordinate: float
    speed: float
    acceleration: float
    drift: tuple[Plane, ...] = ()


class Exits(NamedTuple):
    """Whether a step leaves the range, as seen at its nodes.

    Attributes:
        edge: first node past the range of the system, or NOWHERE.
        slack: first node with a slack thread, or NOWHERE.
        is_within: whether all of the step surely lies within the range.
        reach: largest coordinate at the nodes.
        is_near: whether the thread may be slack at the end of the step, though not at its nodes.
    """

    edge: float
    slack: float
    is_within: bool
    reach: float
    is_near: bool = False


class Tolerance(NamedTuple):
    """The accuracy of steps; errors are relative to the state.

    Attributes:
        step: error allowed in a step.
        factor: that error over the square of the last coefficient (`stepping.error_factor`).
        settled: error to which the stage equations are iterated.
        near_phase: phase from an event within which the midpoint rule leads the state to it [rad].
        coarsen: error of all steps of a span below which the next ones are twice as long.
    """

    step: float
    factor: float
    settled: float
    near_phase: float
    coarsen: float


class RunningState(Protocol):
    """The running state: a record of `stepping.state_type` in compiled code.

    Attributes:
        planes: X and Y of each rotating plane.
        held_angle: θ at which friction holds the wheel [rad].
        side, direction, pallet: as in `Mode`.
        turns: upward passages of zero of the coordinate since the release.
        beats: passages of zero of θ, less those by which it is ahead (`stepping.ahead`).
        level: how often steps are halved.
        newton: steps that took Newton's method.
        given: impulses so far.
        armed: whether an impulse is due in this half swing.
        held: whether friction holds the wheel.
    """

    planes: Planes
    held_angle: float
    side: int
    direction: int
    pallet: int
    turns: int
    beats: int
    level: int
    newton: int
    given: int
    armed: bool
    held: bool


class System(Protocol):
    """A system that moves, as the driver sees it; its methods run in compiled code only.

    Methods with a body are defaults for systems that derive from this class: no escapement, kink
    or friction that holds; a thread that may go slack; motion in the case that matters; and a
    coordinate that is X of the first plane. The driver calls `drift`, `wheel_angle` and `strike`
    where there are an escapement, a kink or drag with a kink, and `set_off` at the release too.
    """

    @property
    def impulse(self) -> float:
        """Angle of the impulse [rad]; infinite without one."""
        return math.inf

    @property
    def pace(self) -> float:
        """Frequency of the swing [rad/s], by which the phase between events is measured."""

    @property
    def feels_impulse(self) -> bool:
        """Whether an escapement pushes the wheel."""
        return self.impulse < math.inf

    @property
    def recoils(self) -> bool:
        """Whether a resting tooth pushes the wheel back; known when compiling."""
        return False

    @property
    def drag_has_kink(self) -> bool:
        """Whether the drag has a kink at the turning points."""
        return False

    @property
    def kinked(self) -> bool:
        """Whether the law has a kink where the coordinate is zero; known when compiling."""
        return False

    @property
    def sticks(self) -> bool:
        """Whether friction may hold the wheel; known when compiling."""
        return False

    @property
    def has_weight(self) -> bool:
        """Whether the thread may go slack; known when compiling."""
        return True

    @property
    def feels_tilt(self) -> bool:
        """Whether τ matters within a span, and not at its end alone; known when compiling."""
        return True

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill the system's rows with the forcing at the nodes of a step."""

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the rows d1 and d2 from x and y (stages)."""

    def exits(self, mode: Mode, omega: Omega, work: Work) -> Exits:
        """Return whether the step last collocated leaves the range."""

    def coordinates(self, work: Work) -> Lanes:
        """Return a quantity with the sign of `Instant.coordinate`, at the nodes of the step."""
        return row_of(work.x)

    def coordinate(self, planes: tuple[Plane, ...]) -> float:
        """Return the same quantity at an instant."""
        return planes[0].x

    def clear_square(
        self, omega: Omega, pieces: ForcingPieces, k: int, besides: float = 0.0
    ) -> float:
        """Return the bound over piece k with which `clear` compares the square of the swing.

        With an angle `besides`, the swing is clear of θ = ± that angle, too.
        """
        return 0.0

    def clear(self, square: float, omega: Omega, work: Work) -> bool:
        """Return whether the swing is clear of the tilt at all nodes (`stepping.passages`)."""
        return True

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Inputs) -> Instant:
        """Return the system at an instant."""

    def set_off(self, omega: Omega, angle: float, at: Inputs, state: RunningState) -> None:
        """Set the state at θ = angle, θ̇ = 0: held by friction, or the direction it moves in."""
        raise TypeError('nothing happens to this system on its way')

    def move_with_case(self, run: SteppedRun, place: StepPlace) -> float:
        """Move the held wheel with the case; return the fraction of the step where it goes."""
        raise TypeError('friction does not hold this system')

    def breaks_loose(self, mode: Mode, angle: float, at: Inputs) -> bool:
        """Return whether friction does not hold the system at rest at an angle (`ride_held`)."""
        raise TypeError('friction does not hold this system')

    def rest_at(self, omega: Omega, angle: float, at: Inputs, state: RunningState) -> None:
        """Put the system at rest in the ship at an angle."""
        raise TypeError('friction does not hold this system')

    def leaves_kink(self, mode: Mode, omega: Omega, planes: Planes, work: Work) -> bool:
        """Return whether the motion surely leaves a kink from the beginning of the step on."""
        return True

    def drift(self, mode: Mode, omega: Omega, at: Inputs, now: Instant) -> tuple[Plane, ...]:
        """Return the time derivatives of X and ωY of each plane, in the place of X and Y."""
        return now.drift

    def wheel_angle(self, planes: tuple[Plane, ...], at: Inputs) -> float:
        """Return θ alone."""
        raise TypeError('nothing happens to this system on its way')

    def strike(
        self, mode: Mode, omega: Omega, at: Inputs, now: Instant, state: RunningState
    ) -> None:
        """Let the escapement's impulse change the planes."""
        raise TypeError('nothing happens to this system on its way')

    def ahead_s(
        self, omega: Omega, length: float, terms: int, x: float, state: RunningState, work: Work
    ) -> float:
        """Return the time to a little after the next expected event [s], or inf."""
        return math.inf


class SteppedRun(NamedTuple):
    """The data that all steps of a run share; a named tuple costs nothing in compiled code."""

    system: System
    omega: Omega
    tolerance: Tolerance
    state: RunningState
    work: Work


class StepWatch(NamedTuple):
    """The step last collocated, evaluated anywhere within it by its stage polynomials."""

    run: SteppedRun
    mode: Mode
    place: StepPlace

    def planes(self, xi: float) -> tuple[Plane, ...]:
        """Return X and Y of each plane at a fraction of the step, after `fill_integrals`."""
        omega, length = self.run.omega, self.place.size * self.place.length
        start, work = self.run.state.planes, self.run.work
        planes: tuple[Plane, ...] = ()
        for p in range(len(omega)):
            x, y = inside(omega, p, length, xi, start, work)
            planes = (*planes, Plane(x, y))
        return planes

    def outside(self, xi: float) -> Inputs:
        """Return the motion of the ship at a fraction of the step."""
        place = self.place
        return outside_at(place.terms, place.begin + xi * place.size, self.run.work)

    def instant(self, xi: float) -> Instant:
        """Return the system at a fraction of the step."""
        system, omega = self.run.system, self.run.omega
        now: Instant = system.instant(self.mode, omega, self.planes(xi), self.outside(xi))
        return now


@inlined
def mode_of(state: RunningState) -> Mode:
    """Return the mode of a state."""
    return Mode(float(state.side), float(state.direction), float(state.pallet))


@inlined
def planes_of(omega: Omega, planes: Planes) -> tuple[Plane, ...]:
    """Return X and Y of each plane, rounded to one double each."""
    rounded: tuple[Plane, ...] = ()
    for p in range(len(omega)):
        rounded = (*rounded, Plane(planes[p].x, planes[p].y))
    return rounded


@inlined
def near_zero(values: Lanes) -> bool:
    """Return whether values fall so fast at the last nodes that they may be below zero after."""
    end = width(values) - 1
    fell = lane(values, end - 1) - lane(values, end)
    return not lane(values, end) > fell


@compiled
def first_below(values: Lanes, work: Work) -> float:
    """Return the first node, as a fraction of the step, with a value <= 0, or NOWHERE."""
    if lowest(values) > 0.0:
        return NOWHERE
    for i in range(width(values)):
        if not lane(values, i) > 0.0:
            return lane(row_of(work.fractions), i)
    return NOWHERE
