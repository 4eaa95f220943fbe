"""A harmonic well on a moving ship: the exact step for a polynomial, in the turning frame.

Euler's second cam with a force, and any linear lever arm under a constant pull that goes with the
case, obey with ψ = θ + α_c and viscous drag c₁

    ψ̈ + 2δψ̇ + ω₀²ψ = f,    f = ω₀² α_c + 2δ α̇_c,    2δ = c₁/I,    ω₀² = F t'/I.

z = ψ̇ + δψ + iωψ with ω² = ω₀² − δ² obeys ż = (iω − δ) z + f. In the frame that turns with ω,
Y = e^{−iωt} z, a span of length h is one addition and one constant factor:

    Y(t + h) = e^{−δh} (Y(t) + e^{−iωt} b),    b = ∫₀^h e^{(δ − iω)s} f(t + s) ds.

f is a polynomial over the span, so that b is a constant row times its coefficients. ωt is reduced
exactly from the time (`phase.half_turns`): no error grows with the number of steps but the
rounding of their sum. A span may take many swings: while the swing outweighs the roll, what it
passes follows from how far it turns. Source: variation of constants.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import localcontext
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from tauto_core.machines import Machine
from tauto_core.motion.forcing import Forcing, Motion
from tauto_core.motion.harmonic import frequency, half_turns_per_ns
from tauto_core.motion.limits import edge_reached, released_beyond
from tauto_core.motion.phase import DIGITS, half_turns, phase_rate, principal
from tauto_core.samples import FloatArray, IntArray, State

if TYPE_CHECKING:
    from tauto_core.motion.turn_and_add import Shapes

NAME = 'forced_harmonic'

TURN = 0.35
"""Longest part of a turn that is taken at one go where the roll may outweigh the swing [rad]."""

PROBES = 8
"""Instants of a span at which the line's tilt is looked at: as many as samples it may span."""


class ForcedHarmonic:
    """Propagator of a linear well whose neutral line is the case's, underdamped."""

    name = NAME

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        drag = machine.drag
        self._delta = 0.5 * (drag.viscous if drag else 0.0) / machine.inertia
        self._omega0 = machine.frequency
        exact = frequency(machine)
        with localcontext() as context:
            context.prec = DIGITS
            exact = (exact * exact - type(exact)(self._delta) ** 2).sqrt()
        self._omega = float(exact)
        self._half_turns_per_ns = half_turns_per_ns(exact)
        self._floats, self._ints = np.zeros(6), np.zeros(3, np.int64)
        self._time_ns = 0
        self._start_angle = 0.0

    def release(self, forcing: Forcing) -> Motion:
        """Release the wheel at rest in the case at the beginning of the first span.

        Raises:
            PropagationError: a release beyond the cam.
        """
        machine = self._machine
        angle = machine.release_angle
        if not abs(angle) <= machine.cam.range_rad:
            raise released_beyond(machine, angle)
        tilt = _line(forcing, np.zeros(1, np.int64), forcing.begin[:1])
        psi, rate = angle + tilt[0][0], tilt[1][0]
        self._time_ns = 0
        y = rate + self._delta * psi, self._omega * psi
        self._floats = np.array([*y, 0.0, 0.0, angle, 0.0])
        self._ints = np.array([0, 0, np.sign(angle)], np.int64)
        self._start_angle = float(principal(machine, np.array([angle]), np.zeros(1))[0])
        return self._motion(np.array([[angle, 0.0, 0.0, 0.0]]), tilt[2])

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans; return the motion at their logged ends.

        Raises:
            PropagationError: the edge of the cam.
        """
        from tauto_core.motion.turn_and_add import OK, turn_and_add  # imports numba

        shape, shapes = self._shapes(forcing)
        logged = np.flatnonzero(forcing.logged)
        rows = np.empty((len(logged), 4))
        code, k, at = turn_and_add(
            (self._omega, self._delta, self._omega0),
            self._machine.cam.range_rad,
            shape,
            shapes,
            self._frame(forcing),
            forcing.neutral,
            forcing.logged,
            self._floats,
            self._ints,
            np.empty(2 + 2 * PROBES),
            rows,
        )
        if code != OK:
            left = (1.0 - at) * (forcing.end[k] - forcing.begin[k]) * forcing.length_s[k]
            raise edge_reached(self._machine, float(forcing.end_ns[k] * 1e-9 - left))
        self._time_ns = int(forcing.end_ns[-1])
        return self._motion(rows, _line(forcing, logged, forcing.end[logged])[2])

    def _frame(self, forcing: Forcing) -> FloatArray:
        """Return cos ωt, sin ωt at the beginnings of the spans and at the end, (n + 1, 2)."""
        times = np.concatenate([[self._time_ns], forcing.end_ns])
        half, fraction = half_turns(times, self._half_turns_per_ns)
        sign = np.where(half % 2 == 0, 1.0, -1.0)
        return np.stack([sign * np.cos(np.pi * fraction), sign * np.sin(np.pi * fraction)], axis=1)

    def _shapes(self, forcing: Forcing) -> tuple[IntArray, Shapes]:
        """Return which shape each span has, (n,), and the shapes."""
        from tauto_core.motion.turn_and_add import Shapes  # imports numba

        width = 0 if forcing.neutral is None else forcing.neutral.shape[1]
        given = np.stack([forcing.length_s, forcing.begin, forcing.end], axis=1)
        # Most spans are alike; only the others are worth sorting.
        other = np.flatnonzero(np.any(given != given[0], axis=1))
        kinds, which = np.unique(given[other], axis=0, return_inverse=True)
        shape = np.zeros(len(given), np.int64)
        shape[other] = 1 + which.reshape(-1)
        found = [
            _shape(self._omega0, self._delta, length, begin, end, width)
            for length, begin, end in [given[0].tolist(), *kinds.tolist()]
        ]
        most = max(each.parts for each in found)
        part, ends = np.zeros((2, len(found), most, 2, width))
        for n, each in enumerate(found):
            part[n, : each.parts], ends[n, : each.parts] = each.part, each.end
        return shape, Shapes(
            np.array([each.parts for each in found]),
            np.stack([each.whole for each in found]),
            part,
            ends,
            np.array([each.time_s for each in found]),
        )

    def _motion(self, rows: FloatArray, tilt_acceleration: FloatArray) -> Motion:
        """Return the motion from rows of θ, θ̇, turns and beats, and α̈_c."""
        angle, rate = rows[:, 0].copy(), rows[:, 1].copy()
        machine = self._machine
        stiffness = self._omega0 * self._omega0
        acceleration = -tilt_acceleration - 2.0 * self._delta * rate - stiffness * angle
        half = (principal(machine, angle, rate) - self._start_angle) / math.pi
        whole = np.floor(half)
        return Motion(
            angle=angle,
            rate=rate,
            torque=-machine.inertia * stiffness * angle,
            half_turns=2 * rows[:, 2].astype(np.int64) + whole.astype(np.int64),
            fraction=half - whole,
            phase_rate=phase_rate(machine, angle, rate, acceleration),
            beats=rows[:, 3].astype(np.int64),
        )

    def state(self) -> State:
        """Return Y, angle and rate, the time they belong to and the counters."""
        return {
            'floats': self._floats.copy(),
            'ints': self._ints.copy(),
            'time_ns': self._time_ns,
            'start_angle': self._start_angle,
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self._floats, self._ints = np.array(state['floats']), np.array(state['ints'])
        self._time_ns, self._start_angle = state['time_ns'], state['start_angle']


def _line(
    forcing: Forcing, piece: IntArray, x: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return α_c and its first two time derivatives at x in some pieces."""
    value = first = second = np.zeros(len(x))
    if forcing.neutral is None:
        return value, first, second
    per_s = 1.0 / forcing.length_s[piece]
    for j in range(forcing.neutral.shape[1] - 1, -1, -1):
        second = second * x + first
        first = first * x + value
        value = value * x + forcing.neutral[piece, j]
    return value, first * per_s, 2.0 * second * per_s * per_s


@dataclass(frozen=True)
class _Shape:
    """What `turn_and_add` needs of spans that begin and end alike: see `Shapes` there."""

    parts: int
    time_s: float
    whole: FloatArray
    part: FloatArray
    end: FloatArray


@lru_cache(maxsize=1024)
def _shape(
    omega0: float, delta: float, length_s: float, begin: float, end: float, width: int
) -> _Shape:
    omega = math.sqrt(omega0 * omega0 - delta * delta)
    time_s = (end - begin) * length_s
    parts = max(math.ceil(omega0 * time_s / TURN), 1)
    if not width:
        none = np.zeros((parts, 2, 0))
        return _Shape(parts, time_s, np.zeros((0, 2 + 2 * PROBES)), none, none)
    edges = begin + (end - begin) * np.arange(parts + 1) / parts
    edges[-1] = end
    part = _response(omega0, delta, length_s, edges, width)
    turned = np.exp((delta - 1j * omega) * (edges[:-1] - begin) * length_s)
    # the real and the imaginary row of each part, turned back to the span's beginning
    whole = (turned[:, None] * (part[:, 0] + 1j * part[:, 1])).sum(axis=0)
    probes = begin + (end - begin) * np.arange(1, PROBES + 1) / PROBES
    probes[-1] = end
    line, line_rate = _powers(probes, length_s, width)
    seen = np.stack([line, line_rate / omega0], axis=1).reshape(-1, width)
    return _Shape(
        parts,
        time_s,
        np.ascontiguousarray(np.vstack([whole.real, whole.imag, seen]).T),
        part,
        np.stack(_powers(edges[1:], length_s, width), axis=1),
    )


def _powers(x: FloatArray, length_s: float, width: int) -> tuple[FloatArray, FloatArray]:
    """Return rows that take the coefficients to the value and to its time derivative at x."""
    powers = x[..., None] ** np.arange(width)
    slopes = np.zeros_like(powers)
    slopes[..., 1:] = np.arange(1, width) * powers[..., :-1] / length_s
    return powers, slopes


def _response(
    omega0: float, delta: float, length_s: float, edges: FloatArray, width: int
) -> FloatArray:
    """Return the real and imaginary rows that take the coefficients of α_c to b, (m, 2, width).

    Gauss–Legendre with 24 nodes a part: over at most TURN the integrand's remainder is far below
    rounding.
    """
    omega = math.sqrt(omega0 * omega0 - delta * delta)
    roots, weights = np.polynomial.legendre.leggauss(24)
    begin, long = edges[:-1, None], np.diff(edges)[:, None]
    x = begin + 0.5 * long * (roots + 1.0)
    s = (x - begin) * length_s
    weight = 0.5 * weights * long * length_s * np.exp(delta * s)
    powers, slopes = _powers(x, length_s, width)
    f = omega0 * omega0 * powers + 2.0 * delta * slopes
    rows = weight * np.cos(omega * s), -weight * np.sin(omega * s)
    return np.stack([np.einsum('mi,mij->mj', row, f) for row in rows], axis=1)
