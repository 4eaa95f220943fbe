"""A body on a curve in a fluid, half swing after half swing, without a step inside any.

The fluid shortens each half swing, so that they must be computed one after the other; the body's
place within one is then known at once (`swing_laws`). A half swing begins at rest at a signed arc.
The state is this arc and the instant, a whole number of nanoseconds and a fraction, so that the
instant keeps its digits however long the run.

`Motion.angle` is the arc s [m], `rate` ds/dt [m/s], `torque` what the weight in the fluid exerts
along the curve [N]; the phase is that of theory E4, (s, −ṡ/ω) with ω = √(g/f).
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from decimal import Decimal, localcontext

import numpy as np

from tauto_core.machines import FluidPendulum
from tauto_core.motion.forcing import Forcing, Motion
from tauto_core.motion.phase import BELOW_ONE, DIGITS, PI
from tauto_core.motion.swing_laws import Course, swing_law
from tauto_core.samples import FloatArray, IntArray, State

NAME = 'half_swings'


@dataclass
class _Now:
    """The half swing under way."""

    count: int
    """Half swings before it."""
    start: float
    """Signed arc at which it began [m]."""
    begin_ns: int
    """When it began, from the release: whole nanoseconds …"""
    begin_rest: float
    """… and the fraction, 0 ≤ fraction < 1."""


class HalfSwings:
    """Propagator of a body in a fluid on a platform at rest.

    Args:
        machine: the machine, released at rest away from A.

    Raises:
        PropagationError: a fluid that resists too strongly for the series.
    """

    name = NAME

    def __init__(self, machine: FluidPendulum) -> None:
        self._machine = machine
        self._law = swing_law(machine)
        self._half_ns, self._half_rest = _half_period(machine)
        self._now = _Now(0, machine.release_arc, 0, 0.0)
        self._course = self._law.course(machine.release_arc)

    def release(self, forcing: Forcing) -> Motion:
        """Return the motion at the start."""
        del forcing
        return self._motion_at(np.zeros(1, np.int64))

    def advance(self, forcing: Forcing) -> Motion:
        """Return the motion at the logged ends of the spans."""
        return self._motion_at(forcing.end_ns[forcing.logged])

    def state(self) -> State:
        """Return the half swing under way."""
        return asdict(self._now)

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._now = _Now(**state)
        self._course = self._law.course(self._now.start)

    def _motion_at(self, time_ns: IntArray) -> Motion:
        """Return the motion at times that do not decrease [ns], (n,)."""
        count = np.empty(len(time_ns), np.int64)
        start, time = np.empty(len(time_ns)), np.empty(len(time_ns))
        for row, instant in enumerate(time_ns.tolist()):
            after = self._next(self._now, self._course)
            while (after.begin_ns, after.begin_rest) <= (instant, 0.0):
                self._now, self._course = after, self._law.course(after.start)
                after = self._next(self._now, self._course)
            now = self._now
            count[row], start[row] = now.count, now.start
            time[row] = max((instant - now.begin_ns) - now.begin_rest, 0.0) * 1e-9
        arc, rate = self._law.place(start, time)
        return self._motion(count, start, arc, rate)

    def _next(self, now: _Now, course: Course) -> _Now:
        """Return the half swing after the one under way."""
        rest = now.begin_rest + self._half_rest + course.excess * self._half_ns
        whole = math.floor(rest)
        begin = now.begin_ns + self._half_ns + whole
        return _Now(now.count + 1, course.end, begin, rest - whole)

    def _motion(
        self, count: IntArray, start: FloatArray, arc: FloatArray, rate: FloatArray
    ) -> Motion:
        """Return the motion from half swings, arcs and their rates, (n,)."""
        machine, curve = self._machine, self._machine.curve
        omega, slope = machine.frequency, curve.slope(arc)
        drag = curve.kappa * rate * np.abs(rate)
        acceleration = -curve.gamma * machine.gravity * slope - drag
        # divided by the amplitude, so that no square underflows
        x, y = arc / start, np.maximum(-rate / (omega * start), 0.0)
        turned = np.arctan2(y, x) / math.pi
        square = x * x + y * y
        areal = omega * y * y - x * (acceleration / (omega * start))
        return Motion(
            angle=arc,
            rate=rate,
            torque=-machine.weight * slope,
            half_turns=count,
            fraction=np.minimum(turned, BELOW_ONE),
            phase_rate=np.divide(areal, square, np.zeros_like(square), where=square > 0.0),
            beats=count + (x < 0.0),
        )


def _half_period(machine: FluidPendulum) -> tuple[int, float]:
    """Return π √(f/g) [ns] as a whole number and a fraction."""
    with localcontext() as context:
        context.prec = DIGITS
        length = Decimal(machine.curve.pendulum_length)
        half = PI * (length / Decimal(machine.gravity)).sqrt() * 10**9
        whole = int(half)
        return whole, float(half - whole)
