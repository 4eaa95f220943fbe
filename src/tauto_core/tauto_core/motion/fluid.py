"""A body on a curve in a fluid, one half swing after another, without steps inside them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from decimal import Decimal, localcontext
from typing import NamedTuple, Protocol, cast

import numpy as np
from numpy.polynomial import chebyshev

from tauto_core.curves.fluid import FluidTautochrone
from tauto_core.curves.numerics import complete_series
from tauto_core.machines import FluidPendulum
from tauto_core.machines.fluid_pendulum import (
    euler_half_swing,
    reverse_half_swing,
)
from tauto_core.motion.closed_forms import ClosedForm
from tauto_core.motion.forcing import BELOW_ONE, PHASE_DIGITS, PI, Motion
from tauto_core.samples import FloatArray, IntArray, State
from tauto_core.scene.errors import PropagationError

# -----------------------------------------------------------------------------
# The sequence of half swings in a fluid, and the body's place within a half swing.
#
# A law gives the duration and the end of the half swing from rest at a signed arc, and the body's
# place at a time within it. On Euler's curve both are closed forms (`machines.fluid_pendulum`), on
# others those of `machines.half_swings`. A voyage has millions of half swings:
# their durations and ends are smooth functions of the start, held as Chebyshev series. The place
# is needed in few of them.

SWING_DEGREE = 512
# Numbers of coefficients tried: 9 to SWING_DEGREE + 1.
_COUNTS = tuple(1 + 2**n for n in range(3, 10))

SWING_TAIL = 2.0**-48
"""A series is complete if its last three coefficients are below this."""

# Numbers held at once to compute places within half swings.
_NUMBERS = 2**20


class SwingEnd(NamedTuple):
    """A half swing as a function of its start."""

    excess: float
    """Duration divided by π/ω, minus 1."""
    end: float
    """Signed arc at its end [m]."""


class HalfSwingTable:
    """Duration and end of all half swings on one branch, from the widest [m] down to 0.

    Raises a PropagationError if no series of degree 512 describes them.
    """

    def __init__(self, swing: Callable[[float], tuple[float, float]], widest: float) -> None:
        self._widest = widest

        def series(terms: int) -> FloatArray:
            # by least squares, which for so few terms is no slower than the discrete transform
            nodes = np.cos(np.pi * (np.arange(terms) + 0.5) / terms)
            starts = widest * 0.5 * (1.0 + nodes)
            rows = np.array([swing(start) for start in starts.tolist()])
            values = np.stack([rows[:, 0], -rows[:, 1] / starts], axis=1)
            return np.asarray(chebyshev.chebfit(nodes, values, terms - 1), np.float64).T

        coefficients = complete_series(series, _COUNTS, SWING_TAIL, tail_count=3, scale=1.0)
        if coefficients is not None:
            # highest first, without trailing coefficients below rounding
            series_rows = (chebyshev.chebtrim(row, 2.0**-56) for row in coefficients)
            self._excess, self._ratio = (row.tolist()[::-1] for row in series_rows)
            return
        raise PropagationError(
            f'half swings from {widest:.6g} m take more than {SWING_DEGREE} Chebyshev '
            'coefficients: the fluid resists too strongly. Release the body nearer to A, or use a '
            'larger or denser body or a lighter fluid',
            0.0,
        )

    def __call__(self, start: float) -> SwingEnd:
        """Return duration and end of the half swing from rest at a signed arc [m]."""
        x = 2.0 * (start / self._widest) - 1.0
        return SwingEnd(_sum(self._excess, x), -start * _sum(self._ratio, x))


class Law(Protocol):
    """The half swings of a machine."""

    def course(self, start: float) -> SwingEnd:
        """Return duration and end of the half swing from rest at a signed arc [m]."""

    def place(self, start: FloatArray, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return signed arc [m] and its rate [m/s] at times [s] since rest at signed arcs."""

    def with_friction(self, start: FloatArray, slope: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the arcs of zero net force along the curve, and slopes with friction.

        Both are 0 for a body that friction holds.

        Args:
            start: signed arcs from which the bodies came [m].
            slope: slopes at their places.
        """
        return np.zeros_like(start), slope


class EulerLaw(Law):
    """Half swings on Euler's curve, in closed form both ways."""

    def __init__(self, machine: FluidPendulum, curve: FluidTautochrone) -> None:
        self._machine, self._curve = machine, curve
        start = machine.release_arc
        _, end = machine.swing(start)
        self._tables = {
            widest > 0.0: HalfSwingTable(machine.swing, widest) for widest in (start, end)
        }

    def course(self, start: float) -> SwingEnd:
        """Return duration and end of the half swing from rest at a signed arc [m]."""
        return self._tables[start > 0.0](start)

    def place(self, start: FloatArray, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return signed arc [m] and its rate [m/s] at times [s] since rest at signed arcs."""
        arc, rate = np.empty_like(start), np.empty_like(start)
        forth, gravity = start > 0.0, self._machine.gravity
        arc[forth], rate[forth] = euler_half_swing(self._curve, gravity, start[forth], time[forth])
        reverse = ~forth
        arc[reverse], rate[reverse] = reverse_half_swing(
            self._curve.kappa, self._machine.frequency, -start[reverse], time[reverse]
        )
        return arc, rate


class BranchedLaw(Law):
    """Half swings over other curves, or with constant friction."""

    def __init__(self, machine: FluidPendulum) -> None:
        self._ways = machine.both_ways(machine.release_arc)
        self._half_s = math.pi / machine.frequency
        self._tables: dict[bool, HalfSwingTable] = {}
        if machine.friction == 0.0 and not np.any(machine.curve.joints):
            # smooth except at A: duration and end are smooth functions of the start
            start = machine.release_arc
            for widest in (start, self._swing(start)[1]):
                self._tables[widest > 0.0] = HalfSwingTable(self._swing, widest)

    def _swing(self, start: float) -> tuple[float, float]:
        course = self._ways.course(start)
        return course.duration / self._half_s - 1.0, course.end

    def course(self, start: float) -> SwingEnd:
        """Return duration and end of the half swing from rest at a signed arc [m]."""
        table = self._tables.get(start > 0.0)
        return SwingEnd(*self._swing(start)) if table is None else table(start)

    def with_friction(self, start: FloatArray, slope: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return both as `BothWays` does."""
        return self._ways.with_friction(start, slope)

    def place(self, start: FloatArray, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return signed arc [m] and its rate [m/s] at times [s] since rest at signed arcs."""
        return self._ways.place(start, time)


def swing_law(machine: FluidPendulum) -> Law:
    """Return the law of a machine's half swings."""
    if machine.is_euler:
        return EulerLaw(machine, cast(FluidTautochrone, machine.curve))
    return BranchedLaw(machine)


def _sum(series: list[float], x: float) -> float:
    """Return a Chebyshev series by Clenshaw's recurrence."""
    b1 = b2 = 0.0
    for coefficient in series[:-1]:
        b1, b2 = 2.0 * x * b1 - b2 + coefficient, b1
    return x * b1 - b2 + series[-1]


# -----------------------------------------------------------------------------
# A body on a curve in a fluid, one half swing after another.
#
# Each half swing starts from the end of the last, which the fluid has shortened, at rest at a
# signed arc. The state is this arc and the instant, as a whole number of nanoseconds and a
# fraction: the instant keeps its digits in a run of any length.
#
# `Motion.angle` is the arc s [m], `rate` ds/dt [m/s], `torque` the force of the weight in the
# fluid along the curve [N]. The phase is defined as in reading.md: (s, −ṡ/ω) with ω = √(g/f). With
# friction, arcs count from the point of zero net force until the body is held.


# Later than every instant of a run [ns].
_NEVER_NS = 2**63


@dataclass
class _Now:
    """The present half swing."""

    count: int
    """Number of half swings before it."""
    start: float
    """Signed arc at its beginning [m]."""
    begin_ns: int
    """Its beginning, from the release: whole nanoseconds …"""
    begin_rest: float
    """… and the fraction, 0 ≤ fraction < 1."""


class HalfSwings(ClosedForm):
    """Propagator of a body in a fluid, released at rest away from A, on a platform at rest.

    Raises a PropagationError if the fluid resists too strongly for the series.
    """

    name = 'half_swings'

    def __init__(self, machine: FluidPendulum) -> None:
        self._machine = machine
        self._law = swing_law(machine)
        with localcontext() as context:
            context.prec = PHASE_DIGITS
            # π √(f/g) [ns] as a whole number and a fraction
            length = Decimal(machine.curve.pendulum_length)
            half_period_ns = PI * (length / Decimal(machine.gravity)).sqrt() * 10**9
            self._half_ns = int(half_period_ns)
            self._half_rest = float(half_period_ns - self._half_ns)
        self._now = _Now(0, machine.release_arc, 0, 0.0)
        self._course = self._law.course(machine.release_arc)

    def state(self) -> State:
        """Return the present half swing."""
        return asdict(self._now)

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._now = _Now(**state)
        self._course = self._law.course(self._now.start)

    def motion_at(self, time_ns: IntArray) -> Motion:
        """Return the motion at non-decreasing times [ns], (n,)."""
        count = np.empty(len(time_ns), np.int64)
        start, time = np.empty(len(time_ns)), np.empty(len(time_ns))
        for row, instant in enumerate(time_ns.tolist()):
            next_swing = self._next(self._now, self._course)
            while (next_swing.begin_ns, next_swing.begin_rest) <= (instant, 0.0):
                self._now, self._course = next_swing, self._law.course(next_swing.start)
                next_swing = self._next(self._now, self._course)
            now = self._now
            count[row], start[row] = now.count, now.start
            time[row] = max((instant - now.begin_ns) - now.begin_rest, 0.0) * 1e-9
        arc, rate = self._law.place(start, time)
        machine, curve = self._machine, self._machine.curve
        omega, slope = machine.frequency, curve.slope(arc)
        drag = curve.kappa * rate * np.abs(rate)
        if machine.viscous:
            drag = drag + machine.viscous * rate
        # a resistance ∝ v takes the same share from each swing: one day the arc underflows
        middle, pull, widest = np.zeros_like(arc), slope, np.where(start == 0.0, 1.0, start)
        if machine.friction:
            middle, pull = self._law.with_friction(start, slope)
            widest = np.where(start == middle, 1.0, start - middle)
        acceleration = -curve.gamma * machine.gravity * pull - drag
        # divided by the amplitude, to keep squares from underflowing
        x, y = (arc - middle) / widest, np.maximum(-rate / (omega * widest), 0.0)
        turned = np.arctan2(y, x) / math.pi
        square = x * x + y * y
        areal = omega * y * y - x * (acceleration / (omega * widest))
        return Motion(
            angle=arc,
            rate=rate,
            torque=-machine.weight * slope,
            half_turns=count,
            fraction=np.minimum(turned, BELOW_ONE),
            phase_rate=np.divide(areal, square, np.zeros_like(square), where=square > 0.0),
            beats=count + (x < 0.0),
        )

    def _next(self, now: _Now, course: SwingEnd) -> _Now:
        """Return the half swing after this one."""
        if math.isinf(course.excess):  # friction holds it forever
            return _Now(now.count + 1, course.end, _NEVER_NS, 0.0)
        excess = course.excess * (self._half_ns + self._half_rest)
        fraction_ns = now.begin_rest + self._half_rest + excess
        whole_ns = math.floor(fraction_ns)
        begin = now.begin_ns + self._half_ns + whole_ns
        return _Now(now.count + 1, course.end, begin, fraction_ns - whole_ns)
