"""A harmonic well on a moving ship: the exact step for a polynomial, in the turning frame.

Euler's second cam with a force, and any linear lever arm under a constant pull that goes with the
case, obey with ψ = θ + α_c and viscous drag c₁

    ψ̈ + 2δψ̇ + ω₀²ψ = f,    f = ω₀² α_c + 2δ α̇_c,    2δ = c₁/I,    ω₀² = F t'/I.

z = ψ̇ + δψ + iωψ with ω² = ω₀² − δ² obeys ż = (iω − δ) z + f. In the frame that turns with ω,
Y = e^{−iωt} z, a span of length h is one addition and one constant factor:

    Y(t + h) = e^{−δh} (Y(t) + e^{−iωt} b),    b = ∫₀^h e^{(δ − iω)s} f(t + s) ds.

f is a polynomial over the span, so that b is a constant row times what gives the polynomial: its
coefficients or, where the samples are even, the samples themselves, and nothing is fitted. ωt is
reduced exactly from the time: no error grows with the number of steps but the rounding of their
sum. A span may take many swings: while the swing outweighs the roll, what it passes follows from
how far it turns. Source: variation of constants.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import localcontext
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tauto_core.machines import Machine
from tauto_core.motion.forcing import Forcing, Motion, no_motion
from tauto_core.motion.harmonic import frequency
from tauto_core.motion.limits import edge_reached, released_beyond
from tauto_core.motion.phase import DIGITS, PI, phase_rate, within_turn
from tauto_core.samples import FloatArray, IntArray, State

if TYPE_CHECKING:
    from tauto_core.motion.turn_and_add import Given, Shapes

NAME = 'forced_harmonic'
SIZE = 8
"""Numbers in a row of `lanes`, which imports numba."""

TURN = 0.35
"""Longest part of a turn that is taken at one go where the roll may outweigh the swing [rad]."""

_COMPLEX_STEP = 1e-200
_ROOTS, _WEIGHTS = np.polynomial.legendre.leggauss(24)


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
            units_per_ns = int(exact / (2 * PI * 10**9) * 2**128)
        self._omega = float(exact)
        self._turning = np.uint64(units_per_ns >> 64), np.uint64(units_per_ns % 2**64)
        self._floats, self._ints = np.zeros(6), np.zeros(2, np.int64)
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
        window, first = forcing.window, forcing.neutral
        if window is not None:
            # no window of a run's first piece is centred
            first = window.fitted
        tilt = _line(None if first is None else first[:1], forcing.length_s[:1], forcing.begin[:1])
        psi, rate = angle + tilt[0][0], tilt[1][0]
        self._time_ns = 0
        y = rate + self._delta * psi, self._omega * psi
        self._floats = np.array([*y, 0.0, 0.0, angle, 0.0])
        self._ints = np.zeros(2, np.int64)
        self._start_angle = float(within_turn(machine, np.array([angle]), np.zeros(1))[0])
        return self._motion(np.array([[angle, 0.0, 0.0, 0.0]]), tilt[2])

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans; return the motion at their logged ends.

        Raises:
            PropagationError: the edge of the cam.
        """
        from tauto_core.motion.turn_and_add import OK, turn_and_add  # imports kernels

        shape, shapes = self._shapes(forcing)
        logged = np.flatnonzero(forcing.logged)
        rows = np.empty((len(logged), 4))
        code, k, at = turn_and_add(
            (self._omega, self._delta, self._omega0),
            self._machine.cam.range_rad,
            self._turning,
            shapes,
            shape,
            self._time_ns,
            forcing.end_ns,
            _given(forcing),
            np.empty((1, shapes.whole.shape[1])),
            forcing.logged,
            self._floats,
            self._ints,
            rows,
        )
        if code != OK:
            left = (1.0 - at) * (forcing.end[k] - forcing.begin[k]) * forcing.length_s[k]
            raise edge_reached(self._machine, float(forcing.end_ns[k] * 1e-9 - left))
        self._time_ns = int(forcing.end_ns[-1])
        if not len(logged):
            return no_motion()
        fitted = _fitted(forcing, logged)
        return self._motion(rows, _line(fitted, forcing.length_s[logged], forcing.end[logged])[2])

    def _shapes(self, forcing: Forcing) -> tuple[IntArray, Shapes]:
        """Return which shape each span has, (n,), and the shapes."""
        window, neutral = forcing.window, forcing.neutral
        sampled = np.zeros(len(forcing.end), np.bool_) if window is None else window.first >= 0
        columns = forcing.length_s, forcing.begin, forcing.end, sampled
        # Most spans are alike; only the others are worth sorting.
        usual = [column[len(column) // 2] for column in columns]
        unlike = np.zeros(len(sampled), np.bool_)
        for column, one in zip(columns, usual, strict=True):
            unlike |= column != one
        shape, kinds = np.zeros(len(unlike), np.int64), [tuple(map(float, usual))]
        if unlike.any():
            others = np.stack([column[unlike] for column in columns], axis=1)
            more, which = np.unique(others, axis=0, return_inverse=True)
            kinds += map(tuple, more.tolist())
            shape[unlike] = 1 + which.reshape(-1)
        # a table of many kinds is large, and seldom wanted again
        make = _shapes if len(kinds) > 1 else _kept_shapes
        return shape, make(
            self._omega0,
            self._delta,
            tuple(kinds),
            () if window is None else window.nodes,
            2 * len(window.nodes) if window else 0 if neutral is None else neutral.shape[1],
        )

    def _motion(self, rows: FloatArray, tilt_acceleration: FloatArray) -> Motion:
        """Return the motion from rows of θ, θ̇, turns and beats, and α̈_c."""
        angle, rate = rows[:, 0].copy(), rows[:, 1].copy()
        machine = self._machine
        stiffness = self._omega0 * self._omega0
        acceleration = -tilt_acceleration - 2.0 * self._delta * rate - stiffness * angle
        half = (within_turn(machine, angle, rate) - self._start_angle) / math.pi
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


def _given(forcing: Forcing) -> Given | None:
    """Return what makes α_c over each span; None: it does not move."""
    window, neutral = forcing.window, forcing.neutral
    if window is not None:
        return window.values, window.rates, window.first, window.fitted
    if neutral is None:
        return None
    return np.empty(0), np.empty(0), -1 - np.arange(len(neutral)), neutral


def _fitted(forcing: Forcing, logged: IntArray) -> FloatArray | None:
    """Return the coefficients of α_c over the logged spans' pieces."""
    if forcing.window is not None:
        return forcing.window.logged
    return None if forcing.neutral is None else forcing.neutral[logged]


def _line(
    polynomials: FloatArray | None, length_s: FloatArray, x: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return α_c and its first two time derivatives at x in pieces of some lengths."""
    value = first = second = np.zeros(len(x))
    if polynomials is None:
        return value, first, second
    for coefficient in polynomials.T[::-1]:
        second = second * x + first
        first = first * x + value
        value = value * x + coefficient
    per_s = 1.0 / length_s
    return value, first * per_s, 2.0 * second * per_s * per_s


def _shapes(
    omega0: float,
    delta: float,
    kinds: tuple[tuple[float, ...], ...],
    nodes: tuple[float, ...],
    width: int,
) -> Shapes:
    """Return the shapes of some lengths [s], begins, ends, and whether samples are given."""
    from tauto_core.motion.turn_and_add import Shapes  # imports kernels

    found = [
        _shape(omega0, delta, length, begin, end, nodes if sampled else None, width)
        for length, begin, end, sampled in kinds
    ]
    length_s, begin, end, sampled = np.array(kinds).T
    time_s = (end - begin) * length_s
    parts = np.array([len(each.part) for each in found])
    return Shapes(
        per_slope=1.0 / np.where(sampled > 0.0, omega0, length_s * omega0),
        time=time_s,
        half_turns=math.sqrt(omega0 * omega0 - delta * delta) * time_s / math.pi,
        decay=np.array([math.exp(-delta * each) for each in time_s]),
        whole=np.stack([each.whole for each in found]),
        parts=parts,
        first=np.cumsum(parts) - parts,
        part=np.concatenate([each.part for each in found]),
        end=np.concatenate([each.end for each in found]),
    )


_kept_shapes = lru_cache(maxsize=8)(_shapes)


@dataclass(frozen=True)
class _Shape:
    """What `turn_and_add` needs of spans that begin and end alike: see `Shapes` there."""

    whole: FloatArray
    part: FloatArray
    end: FloatArray


@lru_cache(maxsize=1024)
def _shape(
    omega0: float,
    delta: float,
    length_s: float,
    begin: float,
    end: float,
    nodes: tuple[float, ...] | None,
    width: int,
) -> _Shape:
    """Return the tables of a shape; `nodes` of samples, None: powers of x."""
    omega = math.sqrt(omega0 * omega0 - delta * delta)
    parts = max(math.ceil(omega0 * (end - begin) * length_s / TURN), 1)
    if not width:
        none = np.zeros((parts, 2, 0))
        return _Shape(np.zeros((0, SIZE)), none, none)
    edges = begin + (end - begin) * np.arange(parts + 1) / parts
    edges[-1] = end
    part = _response(omega0, delta, length_s, edges, nodes, width)
    # turned back to the span's beginning
    turned = np.exp((delta - 1j * omega) * (edges[:-1] - begin) * length_s)
    whole = (turned[:, None] * part).sum(axis=0)
    value, slope = _basis(edges[1:], length_s, nodes, width)
    ends = np.stack([value, slope / length_s], axis=1)
    columns = [whole.real, whole.imag, *ends[-1]]
    return _Shape(
        np.stack(columns + [np.zeros(width)] * (SIZE - len(columns)), axis=1),
        np.stack([part.real, part.imag], axis=1),
        ends,
    )


def _response(
    omega0: float,
    delta: float,
    length_s: float,
    edges: FloatArray,
    nodes: tuple[float, ...] | None,
    width: int,
) -> NDArray[np.complex128]:
    """Return rows that take what makes α_c to b over each part between edges, (m, width).

    Gauss–Legendre: over a part, at most TURN, the integrand's remainder is far below rounding.
    """
    omega = math.sqrt(omega0 * omega0 - delta * delta)
    begin, long = edges[:-1, None], np.diff(edges)[:, None]
    x = begin + 0.5 * long * (_ROOTS + 1.0)
    s = (x - begin) * length_s
    weight = 0.5 * _WEIGHTS * long * length_s * np.exp((delta - 1j * omega) * s)
    value, slope = _basis(x, length_s, nodes, width)
    f = omega0 * omega0 * value + 2.0 * delta / length_s * slope
    rows: NDArray[np.complex128] = np.einsum('mi,mij->mj', weight, f)
    return rows


def _basis(
    x: FloatArray, length_s: float, nodes: tuple[float, ...] | None, width: int
) -> tuple[FloatArray, FloatArray]:
    """Return rows that take what makes α_c to its value and its slope at x.

    That is values and rates at nodes, or the coefficients of x^j where there are none.
    """
    if nodes is None:
        return _powers(x, width)
    value, slope = _cardinals(x, np.array(nodes))
    for rows in (value, slope):
        rows[..., len(nodes) :] *= length_s
    return value, slope


def _powers(x: FloatArray, width: int) -> tuple[FloatArray, FloatArray]:
    """Return rows that take the coefficients of x^j to the value and the slope at x."""
    powers = x[..., None] ** np.arange(width)
    slopes = np.zeros_like(powers)
    slopes[..., 1:] = np.arange(1, width) * powers[..., :-1]
    return powers, slopes


def _cardinals(x: FloatArray, nodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return rows that take values, then slopes, at nodes to value and slope at x (Hermite).

    To the value at a node z belongs (1 − 2 l'(z) (x − z)) l², to the slope (x − z) l², with l
    Lagrange's polynomial of z. Their own slopes are the imaginary part of a tiny step into the
    complex plane, which cancels nothing.
    """
    gaps = x[..., None] - nodes + 1j * _COMPLEX_STEP
    value, slope = np.empty((2, *gaps.shape), np.complex128)
    for i, node in enumerate(nodes):
        apart = node - np.delete(nodes, i)
        square = np.prod(np.delete(gaps, i, axis=-1) / apart, axis=-1) ** 2
        value[..., i] = (1.0 - 2.0 * np.sum(1.0 / apart) * gaps[..., i]) * square
        slope[..., i] = gaps[..., i] * square
    rows = np.concatenate([value, slope], axis=-1)
    return rows.real, rows.imag / _COMPLEX_STEP
