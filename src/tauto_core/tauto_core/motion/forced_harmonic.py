"""A harmonic well on a moving ship: the exact step for a polynomial, in the turning frame.

Euler's second cam with a force, and any linear lever arm under a constant pull that goes with the
case, obey with ψ = θ + α_c and viscous drag c₁

    ψ̈ + 2δψ̇ + ω₀²ψ = f,    f = ω₀² α_c + 2δ α̇_c,    2δ = c₁/I,    ω₀² = F t'/I.

z = ψ̇ + δψ + iωψ with ω² = ω₀² − δ² obeys ż = (iω − δ) z + f. In the frame that turns with ω,
Y = e^{−iωt} z, a span of length h is one addition and one constant factor:

    Y(t + h) = e^{−δh} (Y(t) + e^{−iωt} b),    b = ∫₀^h e^{(δ − iω)s} f(t + s) ds.

f is a polynomial over the span, so that b is a constant row times its coefficients. ωt is reduced
exactly from the time (`phase.half_turns`): no error grows with the number of steps but the
rounding of their sum. Source: variation of constants.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import localcontext
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tauto_core.machines import Machine
from tauto_core.motion.forcing import Forcing, Motion
from tauto_core.motion.harmonic import frequency, half_turns_per_ns
from tauto_core.motion.limits import edge_reached, released_beyond
from tauto_core.motion.phase import DIGITS, half_turns, phase_rate, principal
from tauto_core.samples import FloatArray, IntArray, State

NAME = 'forced_harmonic'

TURN = 0.8
"""Longest part of a turn that is counted at one go [rad]; longer spans are divided."""


@dataclass(frozen=True)
class _Steps:
    """Spans divided into steps of at most TURN.

    Attributes:
        span: which span each step belongs to, (n,).
        begin, end: where in the piece each step begins and ends, (n,).
        offset_s: time from the span's beginning to the step's [s], (n,).
        last: whether the step ends its span, (n,).
    """

    span: IntArray
    begin: FloatArray
    end: FloatArray
    offset_s: FloatArray
    last: NDArray[np.bool_]


class ForcedHarmonic:
    """Propagator of a linear well whose neutral line is the case's, underdamped."""

    longest_step_s = 0.0

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
        self._y, self._lost = np.zeros(2), np.zeros(2)
        self._time_ns = 0
        self._last = np.zeros(2)
        self._start_angle = 0.0
        self._counts = np.zeros(3, np.int64)

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
        self._lost = np.zeros(2)
        self._y = np.array([rate + self._delta * psi, self._omega * psi])
        self._last = np.array([angle, 0.0])
        self._counts = np.array([0, 0, np.sign(angle)], np.int64)
        self._start_angle = float(principal(machine, np.array([angle]), np.zeros(1))[0])
        return self._motion(
            np.array([angle]), np.zeros(1), tilt[2], np.zeros(1, np.int64), np.zeros(1, np.int64)
        )

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans; return the motion at their logged ends.

        Raises:
            PropagationError: the edge of the cam.
        """
        from tauto_core.motion.turn_and_add import turn_and_add  # imports numba

        steps = self._divide(forcing)
        kind, responses = self._responses(forcing, steps)
        decay = np.exp(-self._delta * (steps.end - steps.begin) * forcing.length_s[steps.span])
        angle, rate = np.empty(len(kind)), np.empty(len(kind))
        turn_and_add(
            self._omega,
            self._delta,
            (steps.span, steps.end, decay, kind),
            responses,
            self._frame(forcing, steps),
            forcing.length_s,
            forcing.neutral,
            self._y,
            self._lost,
            angle,
            rate,
        )
        self._check_edge(forcing, steps, angle, rate)
        turns, beats = self._count(angle, rate)
        self._time_ns = int(forcing.end_ns[-1])
        logged = np.flatnonzero(steps.last & forcing.logged[steps.span])
        bend = _line(forcing, steps.span[logged], steps.end[logged])[2]
        return self._motion(angle[logged], rate[logged], bend, turns[logged], beats[logged])

    def _divide(self, forcing: Forcing) -> _Steps:
        whole = (forcing.end - forcing.begin) * forcing.length_s
        parts = np.maximum(np.ceil(self._omega0 * whole / TURN), 1.0).astype(np.int64)
        span = np.repeat(np.arange(len(parts)), parts)
        index = np.arange(len(span)) - np.repeat(np.cumsum(parts) - parts, parts)
        width = (forcing.end - forcing.begin)[span] / parts[span]
        last = index == parts[span] - 1
        begin = forcing.begin[span] + index * width
        return _Steps(
            span=span,
            begin=begin,
            end=np.where(last, forcing.end[span], begin + width),
            offset_s=index * width * forcing.length_s[span],
            last=last,
        )

    def _frame(self, forcing: Forcing, steps: _Steps) -> FloatArray:
        """Return cos ωt, sin ωt at the beginnings of the steps and at the end, (n + 1, 2)."""
        times = np.concatenate([[self._time_ns], forcing.end_ns])
        half, fraction = half_turns(times, self._half_turns_per_ns)
        sign = np.where(half % 2 == 0, 1.0, -1.0)
        cosine, sine = sign * np.cos(np.pi * fraction), sign * np.sin(np.pi * fraction)
        c, s = np.cos(self._omega * steps.offset_s), np.sin(self._omega * steps.offset_s)
        frame = np.empty((len(steps.span) + 1, 2))
        frame[:-1, 0] = cosine[steps.span] * c - sine[steps.span] * s
        frame[:-1, 1] = sine[steps.span] * c + cosine[steps.span] * s
        frame[-1] = cosine[-1], sine[-1]
        return frame

    def _responses(self, forcing: Forcing, steps: _Steps) -> tuple[IntArray, FloatArray]:
        """Return which response each step has, (n,), and the responses, (kinds, 2, m)."""
        width = 1 if forcing.neutral is None else forcing.neutral.shape[1]
        shapes = np.stack([forcing.length_s[steps.span], steps.begin, steps.end], axis=1)
        # Most steps are alike; only the others are worth sorting.
        other = np.flatnonzero(np.any(shapes != shapes[0], axis=1))
        kinds, which = np.unique(shapes[other], axis=0, return_inverse=True)
        kind = np.zeros(len(shapes), np.int64)
        kind[other] = 1 + which.reshape(-1)
        found = [
            _response(self._omega0, self._delta, length, begin, end, width)
            for length, begin, end in [shapes[0].tolist(), *kinds.tolist()]
        ]
        return kind, np.stack(found)

    def _check_edge(
        self, forcing: Forcing, steps: _Steps, angle: FloatArray, rate: FloatArray
    ) -> None:
        """Raise where a step goes beyond the cam, with the time to the step's resolution."""
        edge = self._machine.cam.range_rad
        if math.isinf(edge):
            return
        swing = np.hypot(angle, rate / self._omega0)
        for n in np.flatnonzero(swing > edge * (1.0 - 1e-12)).tolist():
            before = np.array([angle[n - 1], rate[n - 1]]) if n else self._last
            left = (steps.end[n] - steps.begin[n]) * forcing.length_s[steps.span[n]]
            fraction = _first_beyond(before, np.array([angle[n], rate[n]]), left, edge)
            if fraction is not None:
                k = steps.span[n]
                x = steps.begin[n] + fraction * (steps.end[n] - steps.begin[n])
                late = (forcing.end[k] - x) * forcing.length_s[k]
                raise edge_reached(self._machine, float(forcing.end_ns[k] * 1e-9 - late))

    def _count(self, angle: FloatArray, rate: FloatArray) -> tuple[IntArray, IntArray]:
        """Return turns of (θ, −θ̇) about the origin and passages of θ through zero, so far."""
        x = np.concatenate([self._last[:1], angle])
        y = 0.0 - np.concatenate([self._last[1:], rate])
        crosses = (y[:-1] < 0.0) != (y[1:] < 0.0)
        drop = np.where(crosses, y[:-1] - y[1:], 1.0)
        left = x[:-1] + (x[1:] - x[:-1]) * (y[:-1] / drop) < 0.0
        turn = np.where(crosses & left, np.where(y[1:] < 0.0, 1, -1), 0)
        turns = self._counts[0] + np.cumsum(turn)
        sign = np.concatenate([self._counts[2:], np.sign(angle).astype(np.int64)])
        known = np.maximum.accumulate(np.where(sign != 0, np.arange(len(sign)), 0))
        sign = sign[known]
        passed = (sign[1:] != sign[:-1]) & (sign[:-1] != 0)
        beats = self._counts[1] + np.cumsum(passed)
        self._last = np.array([angle[-1], rate[-1]])
        self._counts = np.array([turns[-1], beats[-1], sign[-1]], np.int64)
        return turns, beats

    def _motion(
        self,
        angle: FloatArray,
        rate: FloatArray,
        tilt_acceleration: FloatArray,
        turns: IntArray,
        beats: IntArray,
    ) -> Motion:
        machine = self._machine
        stiffness = self._omega0 * self._omega0
        acceleration = -tilt_acceleration - 2.0 * self._delta * rate - stiffness * angle
        half = (principal(machine, angle, rate) - self._start_angle) / math.pi
        whole = np.floor(half)
        return Motion(
            angle=angle,
            rate=rate,
            torque=-machine.inertia * stiffness * angle,
            half_turns=2 * turns + whole.astype(np.int64),
            fraction=half - whole,
            phase_rate=phase_rate(machine, angle, rate, acceleration),
            beats=beats,
        )

    def state(self) -> State:
        """Return Y, the time it belongs to and the counters."""
        return {
            'y': self._y.copy(),
            'lost': self._lost.copy(),
            'time_ns': self._time_ns,
            'last': self._last.copy(),
            'start_angle': self._start_angle,
            'counts': self._counts.copy(),
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self._y, self._lost = np.array(state['y']), np.array(state['lost'])
        self._last = np.array(state['last'])
        self._time_ns, self._start_angle = state['time_ns'], state['start_angle']
        self._counts = np.array(state['counts'])


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


@lru_cache(maxsize=1024)
def _response(
    omega0: float, delta: float, length_s: float, begin: float, end: float, width: int
) -> FloatArray:
    """Return the real and imaginary rows that take the coefficients of α_c to b, (2, width).

    Gauss–Legendre with 24 nodes: over a step of at most TURN the integrand's remainder is far
    below rounding.
    """
    omega = math.sqrt(omega0 * omega0 - delta * delta)
    roots, weights = np.polynomial.legendre.leggauss(24)
    x = begin + 0.5 * (end - begin) * (roots + 1.0)
    s = (x - begin) * length_s
    weight = 0.5 * weights * (end - begin) * length_s * np.exp(delta * s)
    powers = x[:, None] ** np.arange(width)
    slopes = np.zeros_like(powers)
    slopes[:, 1:] = np.arange(1, width) * powers[:, :-1] / length_s
    f = omega0 * omega0 * powers + 2.0 * delta * slopes
    return np.stack([(weight * np.cos(omega * s)) @ f, -(weight * np.sin(omega * s)) @ f])


def _first_beyond(
    before: FloatArray, after: FloatArray, step_s: float, edge: float
) -> float | None:
    """Return the fraction of a step at which |θ| first exceeds the edge, None where it does not.

    Between the ends θ is the cubic through both angles and rates, off by less than 1e-3 of the
    swing over the longest step.
    """
    a, c = before[0], before[1] * step_s
    b, d = after[0] - a - c, after[1] * step_s - c
    cubic = np.polynomial.Polynomial([a, c, 3.0 * b - d, d - 2.0 * b])
    roots = np.concatenate([np.atleast_1d((cubic - side).roots()) for side in (edge, -edge)])
    real = np.real(roots[np.abs(np.imag(roots)) < 1e-9])
    within = real[(real >= 0.0) & (real <= 1.0)]
    return float(within.min()) if len(within) else None
