"""The suspended case at small angles: both modes, each with the exact step of `linear`.

    e θ̈ + c φ̈ + g θ = −ÿ,    k² φ̈ + g c (φ − θ) = 0                       (theory E3)

θ = c (q + q′) and φ = Bq + B′q′ leave q̈ + ω²q = −ÿ/(ec + B²) with ω² = g/b, and the like with
B′, b′; z = q̇ + iωq obeys ż = iωz − ÿ/(ec + B²).
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tauto_core.machines.modes import exact_lengths, modes
from tauto_core.motion.bearing import BearingMotion, CaseMotion, ends_of_parts
from tauto_core.motion.linear import STATE, Given, Oscillator, Spans, oscillator, propagate
from tauto_core.motion.phase import DIGITS
from tauto_core.motion.responses import Law, Shape, responses, sorted_out
from tauto_core.samples import IntArray, State


class _Mode(NamedTuple):
    """A mode: its oscillator, B, and the share of −ÿ in q̈."""

    of: Oscillator
    tilt: float
    share: float


def _both(e: float, c: float, k: float, gravity: float) -> tuple[_Mode, _Mode]:
    own = modes(e, c, k * k)
    with localcontext() as context:
        context.prec = DIGITS
        lengths = exact_lengths(Decimal(e), Decimal(c), Decimal(k) ** 2)
        slow, fast = ((Decimal(gravity) / length).sqrt() for length in lengths)
    apart = own.B - own.B_prime
    return (
        _Mode(oscillator(slow), own.B, 1.0 / (own.B * apart)),
        _Mode(oscillator(fast), own.B_prime, -1.0 / (own.B_prime * apart)),
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
        self._modes = _both(e, c, k, gravity)
        self._c, self._gravity = c, gravity
        self._swings = [np.zeros((), STATE) for _ in self._modes]

    def release(self, sway: float, lift: float) -> float:  # noqa: ARG002
        """Start at rest, at the time 0, with θ = φ = −ÿ/g [rad], and return that.

        Args:
            sway: ÿ of the bearing then [m/s2].
            lift: g + z̈ then [m/s2]; it does not matter at small angles.
        """
        tilt = -sway / self._gravity
        slow, fast = self._modes
        c, apart = self._c, slow.tilt - fast.tilt
        q = tilt * (c - fast.tilt) / (c * apart)
        q_fast = tilt * (slow.tilt - c) / (c * apart)
        self._swings = [np.zeros((), STATE) for _ in self._modes]
        self._swings[0]['im'], self._swings[1]['im'] = slow.of.omega * q, fast.of.omega * q_fast
        return tilt

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts."""
        piece = bearing.piece
        shape, shapes = _shapes(bearing)
        # a part is a span: what gives ÿ is the row of its piece
        given = Given(np.empty(0), np.empty(0), -1 - piece, np.ascontiguousarray(bearing.sway))
        q, rate = np.empty((2, 2, len(piece)))
        for m, (mode, swing) in enumerate(zip(self._modes, self._swings, strict=True)):
            law = Law(mode.of.omega, 0.0, -mode.share, 0.0)
            made = responses(law, shapes, (), bearing.sway.shape[1])
            spans = Spans(int(bearing.begin_ns[0]), bearing.end_ns, shape, made, given)
            rate[m], q[m] = propagate(mode.of, spans, swing).z(slice(None))
            q[m] /= mode.of.omega
        slow, fast = (mode.tilt for mode in self._modes)
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
    """Return the shape of each part, (Σ parts,), and the shapes."""
    kind, kinds = sorted_out(bearing.length_ns, bearing.parts)
    shapes: list[Shape] = []
    first: list[int] = []
    for length_ns, parts in kinds:
        first.append(len(shapes))
        ends = ends_of_parts(int(length_ns), int(parts), np.arange(int(parts) + 1)) / length_ns
        shapes += [Shape(length_ns * 1e-9, *edges) for edges in pairwise(ends.tolist())]
    # from the place among all parts to that among those of the piece
    off = np.array(first)[kind] - (np.cumsum(bearing.parts) - bearing.parts)
    return np.arange(len(bearing.piece)) + off[bearing.piece], tuple(shapes)
