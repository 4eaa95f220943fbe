"""The suspended case at small angles: both normal modes, by the exact steps of `linear`.

    (E3.1)  e θ̈ + c φ̈ + g θ = −ÿ,    k² φ̈ + g c (φ − θ) = 0

With θ = c (q + q′) and φ = Bq + B′q′ (`machines.modes`) each mode is an oscillator of its own,
q̈ + ω²q = −ÿ/(ec + B²) with ω² = g/b, so that z = q̇ + iωq obeys ż = iωz − ÿ/(ec + B²). The same
holds of q′ with B′ and b′.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tauto_core.machines.modes import Modes, exact_lengths, modes
from tauto_core.motion.bearing import BearingMotion, CaseMotion, ends_of_parts
from tauto_core.motion.forcing import Polynomials
from tauto_core.motion.linear import (
    STATE,
    Oscillator,
    Spans,
    oscillator,
    propagate,
)
from tauto_core.motion.phase import DIGITS
from tauto_core.motion.responses import Law, Shape, responses, sorted_out
from tauto_core.samples import IntArray, State


class _Mode(NamedTuple):
    """A normal mode.

    Attributes:
        of: its oscillator.
        share: 1/(ec + B²), the part of −ÿ that drives q [1/m2].
    """

    of: Oscillator
    share: float


def _both_modes(own: Modes, e: float, c: float, k: float, gravity: float) -> tuple[_Mode, _Mode]:
    """Return the slow and the fast mode; ec = −BB′, so that ec + B² = B (B − B′)."""
    with localcontext() as context:
        context.prec = DIGITS
        lengths = exact_lengths(Decimal(e), Decimal(c), Decimal(k) ** 2)
        slow, fast = ((Decimal(gravity) / length).sqrt() for length in lengths)
    apart = own.B - own.B_prime
    return (
        _Mode(oscillator(slow), 1.0 / (own.B * apart)),
        _Mode(oscillator(fast), -1.0 / (own.B_prime * apart)),
    )


class AxleModes:
    """The case as a sum of two modes.

    Args:
        e: support's radius less the axle's [m], > 0.
        c: depth of the centre of gravity below the axle's centre [m], > 0.
        k: radius of gyration [m], > 0.
        gravity: g [m/s2].
    """

    def __init__(self, e: float, c: float, k: float, gravity: float) -> None:
        self._own = modes(e, c, k * k)
        self._modes = _both_modes(self._own, e, c, k, gravity)
        self._c, self._gravity = c, gravity
        self._swings = [np.zeros((), STATE) for _ in self._modes]

    def release(self, sway: float, lift: float) -> float:  # noqa: ARG002
        """Start at rest, at the time 0, with θ = φ = −ÿ/g [rad], and return that.

        Args:
            sway: ÿ of the bearing then [m/s2].
            lift: g + z̈ then [m/s2]; it does not matter at small angles.
        """
        tilt = -sway / self._gravity
        self._swings = [np.zeros((), STATE) for _ in self._modes]
        at_rest = self._own.coordinates_at(tilt, self._c)
        for swing, mode, q in zip(self._swings, self._modes, at_rest, strict=True):
            swing['im'] = mode.of.omega * q
        return tilt

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts; the lift does not matter."""
        piece = bearing.piece
        shape, shapes = _shapes(bearing)
        # each part is a span, over which u = ÿ has the coefficients of its piece
        sway = np.ascontiguousarray(bearing.sway)
        u = Polynomials(np.empty(0), np.empty(0), -1 - piece, sway)
        q, rate = np.empty((2, 2, len(piece)))
        for m, (mode, swing) in enumerate(zip(self._modes, self._swings, strict=True)):
            law = Law(mode.of.omega, 0.0, -mode.share, 0.0)
            made = responses(law, shapes, (), bearing.sway.shape[1])
            spans = Spans(int(bearing.begin_ns[0]), bearing.end_ns, shape, made, u)
            rate[m], q[m] = propagate(mode.of, spans, swing).z(slice(None))
            q[m] /= mode.of.omega
        slow, fast = self._own.B, self._own.B_prime
        return CaseMotion(
            self._c * (q[0] + q[1]),
            slow * q[0] + fast * q[1],
            self._c * (rate[0] + rate[1]),
            slow * rate[0] + fast * rate[1],
        )

    def state(self) -> State:
        """Return Y of both modes."""
        return {'swings': [swing.copy() for swing in self._swings]}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._swings = [swing.copy() for swing in state['swings']]


def _shapes(bearing: BearingMotion) -> tuple[IntArray, tuple[Shape, ...]]:
    """Return the index of each part's shape, (Σ parts,), and the shapes."""
    kind, kinds = sorted_out(bearing.length_ns, bearing.parts)
    shapes: list[Shape] = []
    first: list[int] = []
    for length_ns, parts in kinds:
        first.append(len(shapes))
        ends = ends_of_parts(int(length_ns), int(parts), np.arange(int(parts) + 1)) / length_ns
        shapes += [Shape(length_ns * 1e-9, *edges) for edges in pairwise(ends.tolist())]
    # from a part's index among all parts to that among the parts of its piece
    shift = np.array(first)[kind] - (np.cumsum(bearing.parts) - bearing.parts)
    return np.arange(len(bearing.piece)) + shift[bearing.piece], tuple(shapes)
