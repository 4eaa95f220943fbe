"""The interface between the driver and a system, and the ship's motion that drives it.

A system (a wheel, a lever, a swinging thread, a case) is a NamedTuple of numbers with the methods
of `System`. Properties known when compiling cost no time: a wheel without an escapement has no
code for impulses.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Protocol

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
# The ship's motion at an instant and at the nodes of a step.
#
# Over a piece of forcing every channel is a polynomial of x, 0 ≤ x ≤ 1. `set_piece` copies the
# coefficients of all channels and of their time derivatives into `work.piece`, one power of x in
# each row. One pass of Horner's scheme then evaluates them all.

DRIVE, DRIVE_RATE, DRIVE_BEND, TILT, TILT_RATE, TILT_BEND, APPARENT_GRAVITY, LEAN = range(8)
"""Columns of a piece: drive and tilt, each with two time derivatives, then gravity and lean."""

HEAT_POWERS = 4
"""Coefficients of a parameter of the machine over a log interval: a cubic."""


class HeatTerms(NamedTuple):
    """The machine's thermal parameters, over its inertia I, as columns of a piece.

    Attributes:
        carried, force, stiffness, weight, viscous: as in `wells.PerInertia`. For a lever `weight`
            is κ (`lever`). For a swinging thread `weight` is m r/I, `carried` r and `force` ṙ
            [m/s].
        share: I at the reference temperature `at_celsius`, over I. It multiplies the torques on
            the wheel that heat does not change.
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
"""First column and number of `HeatTerms`. A piece has columns beyond `SIZE` only if heat acts."""

HOT_NODES = ('hot',) * HOT_NUMBERS
"""Rows of the nodes: `HeatTerms`, if heat acts."""


class HeatPieces(NamedTuple):
    """The machine's thermal parameters over log intervals, and the place of each piece in them.

    Attributes:
        terms: coefficients of u^j, u from 0 to 1 over an interval: a row of `HeatTerms` for each
            power of each interval, (intervals · HEAT_POWERS, SIZE).
        interval: the interval of each span, (n,).
        begin, size: u at the beginning of the span's piece, and the piece's length in u, (n,).
    """

    terms: FloatArray
    interval: IntArray
    begin: FloatArray
    size: FloatArray


class ForcingPieces(NamedTuple):
    """Pieces of forcing. An absent channel is `None`.

    Attributes:
        length_s: length of each piece [s], (n,).
        drive, tilt, gravity, lean: coefficients of x^j of the channels of `Inputs`, (n, powers).
        hot: the machine's thermal parameters, if heat changes it.
    """

    length_s: FloatArray
    drive: FloatArray | None
    tilt: FloatArray | None
    gravity: FloatArray | None
    lean: FloatArray | None = None
    hot: HeatPieces | None = None


class StepPlace(NamedTuple):
    """The place of a step in its piece of forcing.

    Attributes:
        length: length of the piece [s].
        terms: number of powers in use.
        begin: x at the beginning of the step.
        size: length of the step in x. It lasts size · length seconds.
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
    """The ship's motion at an instant. Absent channels are zero.

    Attributes:
        drive: the direction of the thread's neutral line [rad] (`Forcing.neutral`): γ for a wheel,
            β of the apparent vertical for a lever or a swinging thread. For a suspended case, ÿ
            of its bearing [m/s2].
        tilt: τ, the angle of the neutral line in the case [rad]. A suspended case has none.
        gravity: the apparent gravity [m/s2]: g_eff for a machine, g + z̈ for a suspended case.
        lean: β − γ of an unbalanced wheel [rad].
        hot: the machine's thermal parameters, or `None` if heat does not change it.
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
    channel: FloatArray | None,
    k: int,
    column: int,
    per_s: float,
    terms: int,
    rows: FloatArray,
    first_row: int,
) -> None:
    """Fill three columns with a channel and its first two time derivatives."""
    if channel is None:
        return
    powers, size = channel.shape[1], width(rows)
    above = above_rate = 0.0
    for j in range(terms - 1, -1, -1):
        coefficient = channel[k, j] if j < powers else 0.0
        rate, bend = (j + 1) * per_s * above, (j + 1) * per_s * above_rate
        place = (first_row + j) * size + column
        rows[place], rows[place + 1], rows[place + 2] = coefficient, rate, bend
        above, above_rate = coefficient, rate


@inlined
def _set_column(
    channel: FloatArray | None, k: int, column: int, terms: int, rows: FloatArray, first_row: int
) -> None:
    """Fill one column with a channel."""
    if channel is None:
        return
    powers, size = channel.shape[1], width(rows)
    for j in range(terms):
        rows[(first_row + j) * size + column] = channel[k, j] if j < powers else 0.0


@inlined
def set_channels(
    pieces: ForcingPieces, k: int, tilted: bool, terms: int, rows: FloatArray, first_row: int
) -> None:
    """Fill the columns of the present channels of piece k, one power in each row."""
    per_s = 1.0 / pieces.length_s[k]
    _set_channel(pieces.drive, k, DRIVE, per_s, terms, rows, first_row)
    if tilted:
        _set_channel(pieces.tilt, k, TILT, per_s, terms, rows, first_row)
    _set_column(pieces.gravity, k, APPARENT_GRAVITY, terms, rows, first_row)
    _set_column(pieces.lean, k, LEAN, terms, rows, first_row)


@inlined
def _set_hot(hot: HeatPieces, k: int, work: Work) -> None:
    """Fill the columns of the thermal parameters: p(begin + size · x) of each polynomial p(u)."""
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
    """Fill `work.piece` with piece k and return its length [s] and number of powers.

    The number is even, since `outside_at` takes two powers at a time. Columns of absent channels
    stay zero. Columns of τ are filled only if `tilted`.
    """
    terms = max(_terms(pieces.drive), _terms(pieces.tilt), _terms(pieces.gravity))
    if pieces.hot is not None:
        terms = max(terms, HEAT_POWERS)
        _set_hot(pieces.hot, k, work)
    terms += terms % 2
    set_channels(pieces, k, tilted, terms, work.piece, 0)
    return pieces.length_s[k], terms


@inlined
def powers_at(rows: FloatArray, first_row: int, count: int, x: float) -> Lanes:
    """Return Σ x^j · row (first_row + j); even and odd powers separately, for speed."""
    even, odd, square = filled(rows, 0.0), filled(rows, 0.0), x * x
    if count % 2 == 1:
        even = row_of(rows, first_row + count - 1)
    for j in range(first_row + count - 1 - count % 2, first_row, -2):
        odd = fma(odd, square, row_of(rows, j))
        even = fma(even, square, row_of(rows, j - 1))
    return fma(odd, x, even)


@inlined
def thermal_terms_of(values: Lanes, first_lane: int) -> HeatTerms:
    """Return the thermal parameters from consecutive lanes."""
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
    """Return the forcing at an instant from the values of its columns."""
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
    return outside_of(values, thermal_terms_of(values, HOT) if width(work.piece) > SIZE else None)


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
def difference(column: int, second: int, terms: int, x: Lanes, work: Work) -> Lanes:
    """Return one column of the piece minus another at lanes of x."""
    value, size = filled(x, 0.0), width(work.piece)
    for j in range(terms - 1, -1, -1):
        place = j * size
        value = fma(value, x, work.piece[place + column] - work.piece[place + second])
    return value


@inlined
def fill_hot(x: Lanes, work: Work) -> None:
    """Fill the rows of the thermal parameters at lanes of x."""
    for i in range(HOT_NUMBERS):
        store(work.nodes.hot, i, column_at(HOT + i, HEAT_POWERS, x, work))


@inlined
def keep(rows: FloatArray, times: Lanes, initial: bool, value: Lanes, row: int = 0) -> None:
    """Store values in a row at all nodes if `initial`, otherwise at nodes with times ≥ 0."""
    if not initial:
        value = chosen(times, row_of(rows, row), value)
    store(rows, row, value)


@inlined
def thermal_at_nodes(work: Work) -> HeatTerms:
    """Return the thermal parameters at the nodes of a step, after `fill_hot`."""
    rows = work.nodes.hot
    return HeatTerms(
        row_of(rows, 0),
        row_of(rows, 1),
        row_of(rows, 2),
        row_of(rows, 3),
        row_of(rows, 4),
        row_of(rows, 5),
        row_of(rows, 6),
    )


@inlined
def heated_now(system: Any, at: Inputs) -> Any:
    """Return a system with its parameters at an instant, unchanged if heat does not act."""
    if system.heat is None or at.hot is None:
        return system
    return system.heated(at.hot)


@inlined
def heated_at_nodes(system: Any, work: Work) -> Any:
    """Return a system with its parameters at the nodes, unchanged if heat does not act."""
    return system if system.heat is None else system.heated(thermal_at_nodes(work))


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
        angle, rate, bend: θ [rad], θ̇ and θ̈ of the wheel in its case, or of a suspended case's
            contact.
        tension: tension of the thread, force in a suspended case's contact, or a quantity of the
            same sign.
        margin: a quantity that is positive only within the range of the system.
        torque: torque of the thread on the wheel, over I [rad/s2].
        coordinate, speed, acceleration: ϑ of the wheel, s of the lever, u of the swinging thread
            or φ of a suspended case, and its first two time derivatives. Its upward passages of
            zero count as turns of the phase.
        drift: the time derivatives of X and ωY of each plane, for systems with the default
            `System.drift`.
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
    """Whether a step leaves the range, by its nodes.

    Attributes:
        edge: first node past the range of the system, or NOWHERE.
        slack: first node with a slack thread, or NOWHERE.
        is_within: whether the whole step is certainly within the range.
        reach: largest coordinate at the nodes.
        is_near: whether the thread may go slack after the last node.
    """

    edge: float
    slack: float
    is_within: bool
    reach: float
    is_near: bool = False


class Tolerance(NamedTuple):
    """The accuracy of steps. Errors are relative to the state.

    Attributes:
        step: error allowed in a step.
        factor: error of a step over the square of its last coefficient (`wheel.error_factor`).
        settled: error to which the stage equations are iterated.
        near_phase: phase from an event within which the midpoint rule moves the state to it [rad].
        coarsen: if no step of a span errs by more, the next steps are twice as long.
    """

    step: float
    factor: float
    settled: float
    near_phase: float
    coarsen: float


class RunningState(Protocol):
    """The running state, a record of `stepping.state_type` in compiled code.

    Attributes:
        planes: X and Y of each rotating plane.
        held_angle: θ at which friction holds the wheel [rad].
        side, direction, pallet: as in `Mode`.
        turns: upward passages of zero of the coordinate since the release.
        beats: passages of zero of θ minus its lead over the coordinate (`stepping.ahead`).
        level: halvings of the steps.
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
    given: int
    armed: bool
    held: bool


class System(Protocol):
    """A moving system as the driver uses it. Its methods run in compiled code only.

    The defaults describe a system with no escapement, no kink and no static friction, with a
    thread that may go slack, and with X of the first plane as its coordinate. The driver calls
    `drift`, `wheel_angle` and `strike` only for a system with an escapement or a kink.
    """

    @property
    def impulse(self) -> float:
        """Angle of the impulse [rad], infinite without an escapement."""
        return math.inf

    @property
    def pace(self) -> float:
        """Frequency of the swing [rad/s], which converts time between events into phase.

        1 for a system without events that are timed by it.
        """
        return 1.0

    @property
    def feels_impulse(self) -> bool:
        """Whether an escapement pushes the wheel."""
        return self.impulse < math.inf

    @property
    def recoils(self) -> bool:
        """Whether a resting tooth pushes the wheel back (known when compiling)."""
        return False

    @property
    def drag_has_kink(self) -> bool:
        """Whether the drag has a kink at the turning points."""
        return False

    @property
    def kinked(self) -> bool:
        """Whether the law has a kink at coordinate zero (known when compiling)."""
        return False

    @property
    def sticks(self) -> bool:
        """Whether friction may hold the wheel (known when compiling)."""
        return False

    @property
    def has_weight(self) -> bool:
        """Whether the thread may go slack (known when compiling)."""
        return True

    @property
    def feels_tilt(self) -> bool:
        """Whether τ acts within a span, not only at its end (known when compiling)."""
        return True

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill the system's rows with the forcing at the nodes of a step."""

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the rows d1 and d2 from x and y (stages)."""

    def exits(self, mode: Mode, omega: Omega, work: Work) -> Exits:
        """Return whether the step last collocated leaves the range."""

    def coordinates(self, work: Work) -> Lanes:
        """Return a quantity with the sign of `Instant.coordinate` at the nodes of the step."""
        return row_of(work.x)

    def coordinate(self, planes: tuple[Plane, ...]) -> float:
        """Return a quantity with the sign of `Instant.coordinate` at an instant."""
        return planes[0].x

    def clear_square(
        self, omega: Omega, pieces: ForcingPieces, k: int, besides: float = 0.0
    ) -> float:
        """Return the least square of a swing over piece k that is clear of tilt and ±`besides`."""
        return 0.0

    def clear(self, square: float, omega: Omega, work: Work) -> bool:
        """Return whether the swing exceeds the bound of `clear_square` at all nodes."""
        return True

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Inputs) -> Instant:
        """Return the system at an instant."""

    def set_off(self, omega: Omega, angle: float, at: Inputs, state: RunningState) -> None:
        """Set the state at θ = angle, θ̇ = 0: held by friction, or about to move."""
        raise TypeError('this system has no events')

    def move_with_case(self, run: SteppedRun, place: StepPlace) -> float:
        """Move the held wheel with the case until it breaks loose; return that fraction, or 1."""
        raise TypeError('friction does not hold this system')

    def breaks_loose(self, mode: Mode, angle: float, at: Inputs) -> bool:
        """Return whether friction fails to hold the system at rest at an angle (`ride_held`)."""
        raise TypeError('friction does not hold this system')

    def rest_at(self, omega: Omega, angle: float, at: Inputs, state: RunningState) -> None:
        """Put the system at rest in the ship at an angle."""
        raise TypeError('friction does not hold this system')

    def leaves_kink(self, mode: Mode, omega: Omega, planes: Planes, work: Work) -> bool:
        """Return whether the motion certainly leaves a kink from the beginning of the step on."""
        return True

    def drift(self, mode: Mode, omega: Omega, at: Inputs, now: Instant) -> tuple[Plane, ...]:
        """Return the time derivatives of X and ωY of each plane."""
        return now.drift

    def wheel_angle(self, planes: tuple[Plane, ...], at: Inputs) -> float:
        """Return θ at an instant."""
        raise TypeError('this system has no events')

    def strike(
        self, mode: Mode, omega: Omega, at: Inputs, now: Instant, state: RunningState
    ) -> None:
        """Apply the escapement's impulse to the planes."""
        raise TypeError('this system has no events')

    def ahead_s(
        self, omega: Omega, length: float, terms: int, x: float, state: RunningState, work: Work
    ) -> float:
        """Return the time to shortly after the next expected event [s], or infinity."""
        return math.inf


class SteppedRun(NamedTuple):
    """The data that all steps of a run share."""

    system: System
    omega: Omega
    tolerance: Tolerance
    state: RunningState
    work: Work


class StepWatch(NamedTuple):
    """The step last collocated, evaluated at any fraction by its stage polynomials."""

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
        """Return the ship's motion at a fraction of the step."""
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
    """Return X and Y of each plane, each rounded to one double."""
    rounded: tuple[Plane, ...] = ()
    for p in range(len(omega)):
        rounded = (*rounded, Plane(planes[p].x, planes[p].y))
    return rounded


@inlined
def near_zero(values: Lanes) -> bool:
    """Return whether values at the last nodes fall so fast that they may pass zero after them."""
    end = width(values) - 1
    fell = lane(values, end - 1) - lane(values, end)
    return not lane(values, end) > fell


@compiled
def first_below(values: Lanes, work: Work) -> float:
    """Return the fraction of the step at the first node with a value <= 0, or NOWHERE."""
    if lowest(values) > 0.0:
        return NOWHERE
    for i in range(width(values)):
        if not lane(values, i) > 0.0:
            return lane(row_of(work.fractions), i)
    return NOWHERE
