"""The suspended case and its bearing: full equations, small-angle modes, and gimbals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import NDArray

from tauto_core.kernels import compiled, entry, inlined
from tauto_core.machines.axle_pendulum import Modes, exact_lengths, modes
from tauto_core.motion import stepping
from tauto_core.motion.events import ride_held
from tauto_core.motion.forcing import PHASE_DIGITS, lifted_off
from tauto_core.motion.gauss_step import Mode, Omega, Work, make_work, sine_versine
from tauto_core.motion.lanes import (
    SIZE,
    WIDE_SIZE,
    Lanes,
    Numeric,
    NumericPair,
    fma,
    lane,
    larger,
    row_of,
    splat,
    store,
    width,
)
from tauto_core.motion.linear import (
    STATE,
    LinearLaw,
    Oscillator,
    SpanShape,
    U,
    add_up,
    cosine_sine,
    oscillator,
    responses,
    turns_at,
    unique_rows,
)
from tauto_core.motion.stepping import (
    ITERATION_SHARE,
    TOLERANCE,
    restore_record,
    state_of,
    state_type,
    tolerance_of,
)
from tauto_core.motion.system import (
    APPARENT_GRAVITY,
    DRIVE,
    NOWHERE,
    TILT_RATE,
    Exits,
    ForcingPieces,
    Inputs,
    Instant,
    Plane,
    RunningState,
    SteppedRun,
    StepPlace,
    System,
    column_at,
    first_below,
    nodes_of,
)
from tauto_core.motion.wells import term
from tauto_core.samples import FloatArray, IntArray, State, Stateful
from tauto_core.scene.errors import PropagationError

# -----------------------------------------------------------------------------
# Motion of the bearing from which a case hangs, and motion of the case.


@dataclass(frozen=True)
class BearingMotion:
    """Specific force at the bearing's centre over n consecutive pieces, as polynomials.

    In each piece x runs from 0 to 1. The case's motion is computed at the ends of equal parts of
    each piece, rounded to whole nanoseconds.

    Attributes:
        begin_ns: start of each piece, from the start of the run [ns], (n,).
        length_ns: length of each piece [ns], (n,).
        parts: number of parts of each piece, ≥ 1, (n,).
        sway: coefficients of x^j of ÿ, to port [m/s2], (n, m).
        lift: coefficients of g + z̈, up [m/s2], (n, m).
        roll: coefficients of the ship's roll ρ [rad], (n, m′), or `None` without friction.
    """

    begin_ns: IntArray
    length_ns: IntArray
    parts: IntArray
    sway: FloatArray
    lift: FloatArray
    roll: FloatArray | None = None

    @cached_property
    def piece(self) -> IntArray:
        """Index of each part's piece, (Σ parts,)."""
        return np.repeat(np.arange(len(self.parts)), self.parts)

    @cached_property
    def end_ns(self) -> IntArray:
        """End of each part, from the start of the run [ns], (Σ parts,)."""
        piece, parts = self.piece, self.parts
        number = np.arange(1, len(piece) + 1) - (np.cumsum(parts) - parts)[piece]
        ends: IntArray = ends_of_parts(self.length_ns[piece], parts[piece], number)
        return self.begin_ns[piece] + ends

    @cached_property
    def end(self) -> FloatArray:
        """x at the end of each part, 0 < x ≤ 1, (Σ parts,)."""
        piece = self.piece
        ends: FloatArray = (self.end_ns - self.begin_ns[piece]) / self.length_ns[piece]
        return ends

    def at_ends(self) -> FloatArray:
        """Return ÿ and g + z̈ at the ends of the parts [m/s2], (2, Σ parts)."""
        channels = self.sway[self.piece].T, self.lift[self.piece].T
        return np.stack([polyval(self.end, channel, tensor=False) for channel in channels])


def ends_of_parts(length_ns: IntArray | int, parts: IntArray | int, number: Any) -> Any:
    """Return the end of the number-th of equal parts of a length, in whole nanoseconds [ns].

    `number` is 1 to `parts`, or 0 for the beginning.
    """
    return (2 * number * length_ns + parts) // (2 * parts)


class CaseMotion(NamedTuple):
    """Motion of the case at n instants, all (n,).

    Attributes:
        theta: tilt θ of the contact's normal [rad] (φ in gimbals).
        phi: tilt φ of the case [rad].
        theta_rate: θ̇ [rad/s].
        phi_rate: φ̇ [rad/s].
        sway: ÿ of the bearing [m/s2].
        lift: g + z̈ of the bearing [m/s2].
        phi_bend: φ̈ in gimbals [rad/s2], `None` on an axle.
    """

    theta: FloatArray
    phi: FloatArray
    theta_rate: FloatArray
    phi_rate: FloatArray
    sway: FloatArray
    lift: FloatArray
    phi_bend: FloatArray | None = None


class CaseSwing(Protocol):
    """Propagator of the case. Splitting a motion into several calls does not change its bits."""

    def release(
        self, sway: float, lift: float, roll: float = 0.0, roll_rate: float = 0.0
    ) -> float:
        """Start at rest in equilibrium at time 0 and return θ = φ [rad].

        Args:
            sway: ÿ of the bearing [m/s2].
            lift: g + z̈ of the bearing [m/s2], > 0.
            roll: ρ [rad], used if the bearing rubs.
            roll_rate: ρ̇ [rad/s], likewise.
        """

    def bend_at_rest(self, roll_rate: float) -> float:
        """Return φ̈ of a case at rest along the apparent vertical, at ρ̇ of the ship [rad/s2]."""
        return 0.0

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts. The pieces continue the last call's."""

    def state(self) -> State:
        """Return everything that later output depends on."""

    def restore(self, state: State) -> None:
        """Continue from a saved state."""


# -----------------------------------------------------------------------------
# The full equations of the suspended case, as a system of two rotating planes, one per normal
# mode.
#
# θ is the tilt of the contact's normal, φ the tilt of the case, δ = φ − θ. In a moving bearing
# (axle.2) and (axle.3) become (suspension.md)
#
#     N/M = ((g + z̈) cos θ − ÿ sin θ + e θ̇² + c φ̇² cos δ)/(1 + (c/k)² sin²δ),
#     φ̈ = −(N/M) c sin δ/k²,    e θ̈ = −(g + z̈) sin θ − ÿ cos θ − c φ̈ cos δ + c φ̇² sin δ.
#
# θ = c (q + q′) and φ = Bq + B′q′ (`axle_pendulum`). X and Y are q and q̇/ω of each mode. The
# disturbances of the planes are then of third order in the amplitude, or come from the bearing.

CASE_NODES = 'sway', 'lift', 'contact', 'theta', 'delta'
"""Rows of the nodes: ÿ, g + z̈, N/M, θ and δ."""

OVER = 3.0
"""|θ| or |δ| at which the case counts as turned over [rad]."""

CASE_ERROR_OF_LAST = 1.0
"""Upper bound of a step's error over the square of its last Legendre coefficient (`stepping`)."""


class AxleNumbers(NamedTuple):
    """Constants of the equations: e, c, k, and B and B′ of the modes [m]."""

    e: float
    c: float
    k: float
    B: float
    B_prime: float


class SuspendedCase(AxleNumbers, System):
    """The case as `system.System`."""

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill ÿ and g + z̈."""
        x, nodes = nodes_of(place, work), work.nodes
        store(nodes.sway, 0, column_at(DRIVE, place.terms, x, work))
        store(nodes.lift, 0, column_at(APPARENT_GRAVITY, place.terms, x, work))

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the disturbances d2 of the planes, and N/M, θ and δ. d1 stays zero.

        The modes accelerate by q̈ = (c φ̈ − B′θ̈)/D and q̈′ = (B θ̈ − c φ̈)/D, with D = c (B −
        B′).
        """
        e, c, k, B, B_prime = self
        q, fast_q = row_of(work.x, 0), row_of(work.x, 1)
        nodes = work.nodes
        rate, other_rate = row_of(work.y, 0), row_of(work.y, 1)
        theta, delta = c * (q + fast_q), fma(fast_q, B_prime - c, (B - c) * q)
        rates = _angles(self, omega[0] * rate, omega[1] * other_rate)
        sway, lift = row_of(nodes.sway), row_of(nodes.lift)
        contact, sin_theta, cos_theta, sin_delta, cos_delta = contact_force(
            (e, c, k), theta, delta, rates, sway, lift
        )
        # the division in the contact force takes longest: the terms that need it come last
        free = fma(sin_delta, c * (rates[1] * rates[1]), -fma(lift, sin_theta, sway * cos_theta))
        phi_bend = contact * (sin_delta * (-c / (k * k)))
        e_theta_bend = fma(cos_delta * -c, phi_bend, free)
        per = 1.0 / (c * (B - B_prime))
        per_first, second = per / omega[0], per / omega[1]
        slow = fma(phi_bend, c * per_first, omega[0] * q)
        fast = fma(phi_bend, -c * second, omega[1] * fast_q)
        store(work.d2, 0, fma(e_theta_bend, -B_prime * per_first / e, slow))
        store(work.d2, 1, fma(e_theta_bend, B * second / e, fast))
        store(nodes.contact, 0, contact)
        store(nodes.theta, 0, theta)
        store(nodes.delta, 0, delta)

    def exits(self, mode: Mode, omega: Omega, work: Work) -> Exits:
        """Return whether the case turns over or its axle lifts off."""
        nodes = work.nodes
        margin = OVER - larger(row_of(nodes.theta), row_of(nodes.delta))
        edge, slack = first_below(margin, work), first_below(row_of(nodes.contact), work)
        return Exits(edge, slack, edge > 1.0, OVER)

    def coordinates(self, work: Work) -> Lanes:
        """Return φ at the nodes."""
        return row_of(work.nodes.theta) + row_of(work.nodes.delta)

    def coordinate(self, planes: tuple[Plane, ...]) -> float:
        """Return φ."""
        return _angles(self, planes[0].x, planes[1].x)[1]

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Inputs) -> Instant:
        """Return the case at an instant, without θ̈ and φ̈, which no caller uses."""
        theta, phi = _angles(self, planes[0].x, planes[1].x)
        rates = _angles(self, omega[0] * planes[0].y, omega[1] * planes[1].y)
        lengths = self.e, self.c, self.k
        contact = contact_force(lengths, theta, phi - theta, rates, at.drive.value, at.gravity)[0]
        margin = OVER - max(abs(theta), abs(phi - theta))
        return Instant(
            angle=theta,
            rate=rates[0],
            bend=0.0,
            tension=contact,
            margin=margin,
            torque=0.0,
            coordinate=phi,
            speed=rates[1],
            acceleration=0.0,
        )


@inlined
def _angles(system: SuspendedCase, q: Numeric, q_prime: Numeric) -> NumericPair:
    """Return θ and φ from q and q′, or their rates from q̇ and q̇′."""
    return system.c * (q + q_prime), system.B * q + system.B_prime * q_prime


@inlined
def contact_force(
    lengths: tuple[float, float, float],
    theta: Numeric,
    delta: Numeric,
    rates: NumericPair,
    sway: Numeric,
    lift: Numeric,
) -> tuple[Numeric, Numeric, Numeric, Numeric, Numeric]:
    """Return N/M, sin θ, cos θ, sin δ and cos δ. The lengths are e, c and k [m]."""
    e, c, k = lengths
    sin_theta, versine_theta = sine_versine(theta)
    sin_delta, versine_delta = sine_versine(delta)
    cos_theta, cos_delta = 1.0 - versine_theta, 1.0 - versine_delta
    eccentric = (c / k) * sin_delta
    centripetal = fma(c * (rates[1] * rates[1]), cos_delta, e * (rates[0] * rates[0]))
    pressing = fma(lift, cos_theta, fma(-sway, sin_theta, centripetal))
    contact = pressing / fma(eccentric, eccentric, 1.0)
    return contact, sin_theta, cos_theta, sin_delta, cos_delta


# -----------------------------------------------------------------------------
# Propagators of the full equations over pieces of the bearing's motion.

LONG = 1.0
"""Phase of the fast mode in a step [rad] above which sixteen stages cost less than eight."""


class SteppedSwing(CaseSwing):
    """Propagator of a case that takes one or more steps per part.

    The tolerance is relative to the state, and at least TOLERANCE.
    """

    def __init__(
        self,
        system: System,
        omega: Omega,
        nodes: tuple[str, ...],
        stages: int,
        tolerance: float | None,
    ) -> None:
        self._omega, self._system = omega, system
        # iteration errors of large swings add up: with a larger share of a coarse tolerance the
        # result is 15 to 50 times worse, at the same cost
        self._tolerance = tolerance_of(
            max(tolerance or TOLERANCE, TOLERANCE),
            CASE_ERROR_OF_LAST,
            2.0 ** -(2 * stages + 1),
            ITERATION_SHARE,
        )
        self._state = np.zeros((), state_type(len(omega)))
        self._work = make_work(len(omega), nodes, stages)

    def _rows(self, bearing: BearingMotion) -> NDArray[np.void]:
        """Return the driver's rows at the ends of the parts.

        Raises a PropagationError if the axle lifts off, the case turns over, or a step does not
        converge.
        """
        # x counts parts: equal parts then have bit-equal lengths and share their rotation tables
        piece, parts = bearing.piece, bearing.parts
        elapsed_ns = (bearing.end_ns - bearing.begin_ns[piece]) * parts[piece]
        end = np.asarray(elapsed_ns / bearing.length_ns[piece], np.float64)
        begin = np.roll(end, 1)
        begin[np.cumsum(parts) - parts] = 0.0
        length = np.asarray(bearing.length_ns * 1e-9 / parts, np.float64)[piece]

        def of_parts(channel: FloatArray) -> FloatArray:
            powers = np.arange(channel.shape[1], dtype=float)
            coefficients: FloatArray = (channel / np.power(parts[:, None], powers))[piece]
            return coefficients

        rows = np.empty(len(piece), stepping.ROW)
        code, part, x = stepping.advance(
            self._system,
            self._omega,
            self._tolerance,
            math.inf,
            ForcingPieces(
                length,
                of_parts(bearing.sway),
                None if bearing.roll is None else -of_parts(bearing.roll),
                of_parts(bearing.lift),
            ),
            stepping.Spans(begin, end, np.ones(len(piece), np.bool_)),
            self._state,
            self._work,
            rows,
        )
        if code != stepping.OK:
            at_s = float(bearing.begin_ns[piece[part]] * 1e-9 + x * length[part])
            if code == stepping.SLACK:
                raise lifted_off(at_s)
            if code == stepping.EDGE:
                raise PropagationError(
                    'the suspended case turned over (more than 3 rad from the contact or from '
                    "the vertical). Keep its period away from the sea's, or hang it nearer to the "
                    'roll axis (ship.height)',
                    at_s,
                )
            raise PropagationError(
                f'no convergence to the tolerance {self._tolerance.step:g} of the suspended case. '
                'Raise ship.rate, or give the case a larger gyration_radius',
                at_s,
            )
        return rows

    def state(self) -> State:
        """Return the driver's running state, with X and Y of all planes."""
        return state_of(self._state)

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        restore_record(self._state, state)


class AxleSwing(SteppedSwing):
    """Propagator of the case by the full equations.

    Args:
        e: radius of the support minus radius of the axle [m], > 0.
        c: depth of the centre of gravity below the axle's centre [m], > 0.
        k: radius of gyration [m], > 0.
        gravity: g of the rotating frame [m/s2]. The acting force is g + z̈ of the pieces.
        tolerance: tolerance of a step, relative to the state.
        step_s: length of the coming parts [s], which decides the stages, or 0 if unknown.
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
        self._mode_shapes, self._depth = modes(e, c, k * k), c
        slow, fast = (square**0.5 for square in self._mode_shapes.squared_frequencies(gravity))
        system = SuspendedCase(e, c, k, self._mode_shapes.B, self._mode_shapes.B_prime)
        stages = WIDE_SIZE if fast * step_s > LONG else SIZE
        super().__init__(system, (slow, fast), CASE_NODES, stages, tolerance)

    def release(
        self, sway: float, lift: float, roll: float = 0.0, roll_rate: float = 0.0
    ) -> float:
        """Start at rest along the apparent vertical and return its direction [rad]."""
        del roll, roll_rate  # without friction they do not matter
        tilt = math.atan2(-sway, lift)
        self._state = np.zeros((), state_type(2))
        self._state['planes']['x'] = self._mode_shapes.coordinates_at(tilt, self._depth)
        return tilt

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts, with the errors of `_rows`."""
        rows, ends = self._rows(bearing), bearing.at_ends()
        names = 'angle', 'coordinate', 'rate', 'speed'
        return CaseMotion(*map(np.ascontiguousarray, map(rows.__getitem__, names)), *ends)


# -----------------------------------------------------------------------------
# Small angles: both normal modes, by the exact steps of `linear`.
#
#     (suspension.1)  e θ̈ + c φ̈ + g θ = −ÿ,    k² φ̈ + g c (φ − θ) = 0
#
# With θ = c (q + q′) and φ = Bq + B′q′ (`axle_pendulum`) each mode is an independent oscillator,
# q̈ + ω²q = −ÿ/(ec + B²) with ω² = g/h. Then z = q̇ + iωq obeys ż = iωz − ÿ/(ec + B²). For q′
# replace B and h by B′ and h′.


class _Mode(NamedTuple):
    """A normal mode.

    Attributes:
        of: its oscillator.
        share: 1/(ec + B²), the part of −ÿ that drives q [1/m2].
    """

    of: Oscillator
    share: float


AT_END = 4
"""Column of x^j at a part's end, after the real and imaginary parts of b of both modes."""

STRIP = 32
"""Number of pieces per batch of cosines and sines, chosen to fit the first-level cache."""


class _Parts(NamedTuple):
    """Data of the parts that do not depend on the bearing's motion.

    Attributes:
        first_row: index in `rows` of the first part of each piece, (n,).
        after_ns: end of each part, from the beginning of its piece [ns].
        rows: factors of the coefficients in b of both modes and in the value at the end.
    """

    first_row: IntArray
    after_ns: IntArray
    rows: FloatArray


@entry
def _move_modes(
    c: float,
    mode_shapes: Modes,
    slow: Oscillator,
    fast: Oscillator,
    begin_ns: IntArray,
    parts: IntArray,
    sway: FloatArray,
    lift: FloatArray,
    table: _Parts,
    slow_swing: Any,
    second: Any,
    motion: CaseMotion,
) -> None:
    """Move both modes over all parts, and fill in the motion at their ends.

    The size of a batch does not change the bits of a part.
    """
    most_parts = 0
    for p in range(len(parts)):
        most_parts = max(most_parts, parts[p])
    rows, width, room = table.rows, table.rows.shape[1], STRIP * most_parts + 1
    turns, fast_turns = np.empty(room, np.uint64), np.empty(room, np.uint64)
    frame, fast_frame = np.empty((2, room)), np.empty((2, room))
    k, per_slow, per_fast = 0, 1.0 / slow.omega, 1.0 / fast.omega
    y = slow_swing.re, slow_swing.im, slow_swing.lost_re, slow_swing.lost_im
    z = second.re, second.im, second.lost_re, second.lost_im
    for begin in range(0, len(begin_ns), STRIP):
        end = min(begin + STRIP, len(begin_ns))
        turns[0] = turns_at(begin_ns[begin], slow.turns_per_ns, slow.turns_per_ns_low)
        fast_turns[0] = turns_at(begin_ns[begin], fast.turns_per_ns, fast.turns_per_ns_low)
        m = 0
        for p in range(begin, end):
            for i in range(parts[p]):
                m += 1
                time_ns = begin_ns[p] + table.after_ns[table.first_row[p] + i]
                turns[m] = turns_at(time_ns, slow.turns_per_ns, slow.turns_per_ns_low)
                fast_turns[m] = turns_at(time_ns, fast.turns_per_ns, fast.turns_per_ns_low)
        cosine_sine(turns, frame[0], frame[1])
        cosine_sine(fast_turns, fast_frame[0], fast_frame[1])
        m = 0
        for p in range(begin, end):
            for i in range(parts[p]):
                driven, lifted, row = splat(0.0), splat(0.0), (table.first_row[p] + i) * width
                for j in range(sway.shape[1]):
                    driven = fma(row_of(rows, row + j), sway[p, j], driven)
                for j in range(lift.shape[1]):
                    lifted = fma(row_of(rows, row + j), lift[p, j], lifted)
                y = add_up(y, frame[0, m], frame[1, m], lane(driven, 0), lane(driven, 1))
                z = add_up(z, fast_frame[0, m], fast_frame[1, m], lane(driven, 2), lane(driven, 3))
                m += 1
                cos, sin = frame[0, m], frame[1, m]
                q_rate, q = cos * y[0] - sin * y[1], per_slow * (cos * y[1] + sin * y[0])
                cos, sin = fast_frame[0, m], fast_frame[1, m]
                rate, fast_q = (cos * z[0] - sin * z[1], per_fast * (cos * z[1] + sin * z[0]))
                motion.theta[k] = c * (q + fast_q)
                motion.phi[k] = mode_shapes.B * q + mode_shapes.B_prime * fast_q
                motion.theta_rate[k] = c * (q_rate + rate)
                motion.phi_rate[k] = mode_shapes.B * q_rate + mode_shapes.B_prime * rate
                motion.sway[k], motion.lift[k] = lane(driven, AT_END), lane(lifted, AT_END)
                k += 1
    slow_swing.re, slow_swing.im, slow_swing.lost_re, slow_swing.lost_im = y
    second.re, second.im, second.lost_re, second.lost_im = z


class AxleModes(Stateful, CaseSwing):
    """The case as a sum of two modes, with e, c, k [m] and g [m/s2] as in `AxleSwing`."""

    state_names = ('swings',)

    def __init__(self, e: float, c: float, k: float, gravity: float) -> None:
        self._mode_shapes = modes(e, c, k * k)
        with localcontext() as context:
            context.prec = PHASE_DIGITS
            lengths = exact_lengths(Decimal(e), Decimal(c), Decimal(k) ** 2)
            slow, fast = ((Decimal(gravity) / length).sqrt() for length in lengths)
        # ec = −BB′, hence ec + B² = B (B − B′)
        difference = self._mode_shapes.B - self._mode_shapes.B_prime
        self._modes = (
            _Mode(oscillator(slow), 1.0 / (self._mode_shapes.B * difference)),
            _Mode(oscillator(fast), -1.0 / (self._mode_shapes.B_prime * difference)),
        )
        self._c, self._gravity = c, gravity
        self._swings = [np.zeros((), STATE) for _ in self._modes]

    def release(
        self, sway: float, lift: float, roll: float = 0.0, roll_rate: float = 0.0
    ) -> float:
        """Start at rest with θ = φ = −ÿ/g and return it [rad]. The other arguments are unused."""
        del lift, roll, roll_rate
        tilt = -sway / self._gravity
        self._swings = [np.zeros((), STATE) for _ in self._modes]
        at_rest = self._mode_shapes.coordinates_at(tilt, self._c)
        for swing, mode, q in zip(self._swings, self._modes, at_rest, strict=True):
            swing['im'] = mode.of.omega * q
        return tilt

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts. The lift has no effect at small angles."""
        kind, kinds = unique_rows(bearing.length_ns, bearing.parts)
        shapes: list[SpanShape] = []
        first_rows: list[int] = []
        after_ns: list[int] = []
        for length_ns, parts in kinds:
            first_rows.append(len(shapes))
            ends = ends_of_parts(int(length_ns), int(parts), np.arange(int(parts) + 1))
            shapes += [
                SpanShape(length_ns * 1e-9, *x) for x in pairwise((ends / length_ns).tolist())
            ]
            after_ns += ends[1:].tolist()
        rows = np.zeros((len(shapes), max(bearing.sway.shape[1], bearing.lift.shape[1]), SIZE))
        for m, mode in enumerate(self._modes):
            law = LinearLaw(mode.of.omega, 0.0, -mode.share, 0.0)
            basis = responses(law, shapes, (), rows.shape[1]).rows[: len(shapes)]
            rows[..., 2 * m : 2 * m + 2], rows[..., AT_END] = (basis[..., :U], basis[..., U])
        motion = CaseMotion(*np.empty((6, int(bearing.parts.sum()))))
        table = _Parts(np.array(first_rows)[kind], np.array(after_ns), rows)
        (slow, fast), begin_ns = (mode.of for mode in self._modes), bearing.begin_ns
        pieces = begin_ns, bearing.parts, bearing.sway, bearing.lift
        _move_modes(self._c, self._mode_shapes, slow, fast, *pieces, table, *self._swings, motion)
        return motion


# -----------------------------------------------------------------------------
# The case in gimbals: a pendulum on pivots that are fixed in the ship and rub on it.
#
# φ is the tilt of the case and ρ the roll of the ship. The torques are divided by the moment of
# inertia about the pivots, M (k² + l²):
#
#     φ̈ = −p ((g + z̈) sin φ + ÿ cos φ) − 2ζω_c (φ̇ − ρ̇) − f sgn (φ̇ − ρ̇),    p = l/(k² + l²)
#
# (suspension.2). The case's angle in the ship, φ − ρ, plays the part of a wheel's θ in its case.
# The driver finds the turning points of φ − ρ, at which the friction f reverses, and moves the
# case with the ship while friction holds it. The neutral line is the vertical: τ = −ρ.

GIMBALS_NODES = 'sway', 'lift', 'roll_rate'
"""Rows of the nodes: ÿ, g + z̈ and ρ̇."""


class GimbalsLaw(NamedTuple):
    """Torques on a case in gimbals, over its moment of inertia.

    Attributes:
        pull: p = l/(k² + l²) [1/m].
        damping: 2ζω_c [1/s], or `None`.
        friction: f [rad/s2], or `None`.
    """

    pull: float
    damping: float | None
    friction: float | None


@inlined
def gimbals_bend(
    law: GimbalsLaw, phi: Numeric, sliding: Numeric, direction: float, sway: Numeric, lift: Numeric
) -> Numeric:
    """Return φ̈ at φ, from φ̇ − ρ̇ (`sliding`) and its sign, ÿ and g + z̈."""
    sine, versine = sine_versine(phi)
    turned = law.pull * fma(lift, sine, sway * (1.0 - versine))
    return -(turned + term(law.damping, sliding) + term(law.friction, direction))


class _GimbalsNumbers(NamedTuple):
    """Torques on the case, and ω_c of small oscillations [rad/s]."""

    law: GimbalsLaw
    pace: float


class GimbalsCase(_GimbalsNumbers, System):
    """The case as `system.System`, in one plane: X = φ, ω_cY = φ̇."""

    @property
    def drag_has_kink(self) -> bool:
        """Whether friction reverses with the sliding."""
        return self.law.friction is not None

    @property
    def sticks(self) -> bool:
        """Whether friction may hold the case in the ship."""
        return self.law.friction is not None

    @property
    def has_weight(self) -> bool:
        """Return False: there is no thread."""
        return False

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill ÿ, g + z̈ and ρ̇."""
        x, nodes = nodes_of(place, work), work.nodes
        store(nodes.sway, 0, column_at(DRIVE, place.terms, x, work))
        store(nodes.lift, 0, column_at(APPARENT_GRAVITY, place.terms, x, work))
        store(nodes.roll_rate, 0, -column_at(TILT_RATE, place.terms, x, work))

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill d2. d1 stays zero."""
        nodes = work.nodes
        phi, rate = row_of(work.x), omega[0] * row_of(work.y)
        sliding = rate - row_of(nodes.roll_rate)
        sway, lift = row_of(nodes.sway), row_of(nodes.lift)
        bend = gimbals_bend(self.law, phi, sliding, mode.direction, sway, lift)
        # Ẏ = −ωX + d₂, so d₂ = φ̈/ω + ωX
        store(work.d2, 0, fma(bend, 1.0 / omega[0], omega[0] * phi))

    def exits(self, mode: Mode, omega: Omega, work: Work) -> Exits:
        """Return whether the case turns over."""
        x = row_of(work.x)
        edge = first_below(OVER - larger(x, x), work)
        return Exits(edge, NOWHERE, edge > 1.0, OVER)

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Inputs) -> Instant:
        """Return the case at an instant. `angle` is φ − ρ, its angle in the ship."""
        phi, rate = planes[0].x, omega[0] * planes[0].y
        sliding = rate + at.tilt.rate
        bend = gimbals_bend(self.law, phi, sliding, mode.direction, at.drive.value, at.gravity)
        return Instant(
            angle=phi + at.tilt.value,
            rate=sliding,
            bend=bend + at.tilt.bend,
            tension=1.0,
            margin=OVER - abs(phi),
            torque=0.0,
            coordinate=phi,
            speed=rate,
            acceleration=bend,
        )

    def drift(self, mode: Mode, omega: Omega, at: Inputs, now: Instant) -> tuple[Plane, ...]:
        """Return φ̇ and φ̈."""
        return (Plane(now.speed, now.acceleration),)

    def set_off(self, omega: Omega, angle: float, at: Inputs, state: RunningState) -> None:
        """Put the case at φ − ρ = angle, at rest in the ship: held, or starting to slide."""
        self.rest_at(omega, angle, at, state)
        needed = holding(self.law, angle, at)
        state.held = abs(needed) <= term(self.law.friction, 1.0)
        if state.held:
            state.held_angle = angle
        elif needed != 0.0:
            # friction would have to act this way to hold the case, which therefore slides the
            # other way
            state.direction = -1 if needed > 0.0 else 1

    def move_with_case(self, run: SteppedRun, place: StepPlace) -> float:
        """Move the held case with the ship until it breaks loose, and return the fraction."""
        return ride_held(self, run, place, 2 * width(run.work.fractions))

    def breaks_loose(self, mode: Mode, angle: float, at: Inputs) -> bool:
        """Return whether holding φ − ρ = angle takes more friction than there is."""
        return abs(holding(self.law, angle, at)) > term(self.law.friction, 1.0)

    def rest_at(self, omega: Omega, angle: float, at: Inputs, state: RunningState) -> None:
        """Put the case at rest in the ship at φ − ρ = angle."""
        plane = state.planes[0]
        plane.x, plane.x_rest = angle - at.tilt.value, 0.0
        plane.y, plane.y_rest = -at.tilt.rate / omega[0], 0.0


@compiled
def holding(law: GimbalsLaw, angle: float, at: Inputs) -> float:
    """Return the friction, over the moment of inertia, that holds φ = angle + ρ.

    The held case has φ̈ = ρ̈ and φ̇ = ρ̇, hence no damping.
    """
    phi = angle - at.tilt.value
    turned = law.pull * (at.gravity * math.sin(phi) + at.drive.value * math.cos(phi))
    return turned - at.tilt.bend


class GimbalsSwing(SteppedSwing):
    """Propagator of a case in gimbals, at any angle.

    Args:
        pull: p = l/(k² + l²) [1/m], > 0.
        gravity: g at the start, which sets the rotating frame [m/s2].
        damping: 2ζω_c [1/s], ≥ 0.
        friction: f [rad/s2], ≥ 0.
        tolerance: tolerance of a step, relative to the state.
    """

    def __init__(
        self,
        pull: float,
        gravity: float,
        *,
        damping: float = 0.0,
        friction: float = 0.0,
        tolerance: float | None = None,
    ) -> None:
        self._law = GimbalsLaw(pull, damping or None, friction or None)
        omega = math.sqrt(pull * gravity)
        super().__init__(GimbalsCase(self._law, omega), (omega,), GIMBALS_NODES, SIZE, tolerance)

    def release(
        self, sway: float, lift: float, roll: float = 0.0, roll_rate: float = 0.0
    ) -> float:
        """Start at rest along the apparent vertical in a ship that may be rolling."""
        tilt = math.atan2(-sway, lift)
        state = self._state = np.zeros((), state_type(1))
        state['planes']['x'] = tilt
        state['side'] = state['pallet'] = 1
        state['direction'] = -1 if roll_rate > 0.0 else 1
        if self._law.friction and roll_rate == 0.0:
            state['held'], state['held_angle'] = True, tilt - roll
        return tilt

    def bend_at_rest(self, roll_rate: float) -> float:
        """Return φ̈ of a case that hangs at rest in a ship with ρ̇ [rad/s2]."""
        damping, friction = self._law.damping or 0.0, self._law.friction or 0.0
        return damping * roll_rate + friction * float(np.sign(roll_rate))

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts.

        Raises a PropagationError if the case turns over, or a step does not converge.
        """
        rows, (sway, lift) = self._rows(bearing), bearing.at_ends()
        names = 'coordinate', 'speed', 'acceleration'
        phi, rate, bend = map(np.ascontiguousarray, map(rows.__getitem__, names))
        return CaseMotion(phi, phi, rate, rate, sway, lift, bend)
