"""The motion of the bearing in which a case hangs, and the motion of the case."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from tauto_core.samples import FloatArray, IntArray, State


@dataclass(frozen=True)
class BearingMotion:
    """The specific force at the bearing's centre over n consecutive pieces, as polynomials.

    x runs from 0 to 1 over a piece. The motion of the case is computed at the ends of equal parts
    of each piece, rounded to whole nanoseconds.

    Attributes:
        begin_ns: time of each piece's beginning from the start of the run [ns], (n,).
        length_ns: its length [ns], (n,).
        parts: number of parts that it is divided into, ≥ 1, (n,).
        sway: coefficients of x^j of ÿ, to port [m/s2], (n, m).
        lift: the same of g + z̈, up [m/s2], (n, m).
    """

    begin_ns: IntArray
    length_ns: IntArray
    parts: IntArray
    sway: FloatArray
    lift: FloatArray

    @cached_property
    def piece(self) -> IntArray:
        """Index of the piece that each part belongs to, (Σ parts,)."""
        return np.repeat(np.arange(len(self.parts)), self.parts)

    @cached_property
    def end_ns(self) -> IntArray:
        """Time of each part's end from the start of the run [ns], (Σ parts,)."""
        piece = self.piece
        number = np.arange(1, len(piece) + 1) - (np.cumsum(self.parts) - self.parts)[piece]
        length, parts = self.length_ns[piece], self.parts[piece]
        return self.begin_ns[piece] + ends_of_parts(length, parts, number)

    @cached_property
    def end(self) -> FloatArray:
        """x at which each part ends in its piece, 0 < x ≤ 1, (Σ parts,)."""
        piece = self.piece
        ends: FloatArray = (self.end_ns - self.begin_ns[piece]) / self.length_ns[piece]
        return ends

    def at_ends(self) -> tuple[FloatArray, FloatArray]:
        """Return ÿ and g + z̈ at the ends of the parts [m/s2], (Σ parts,)."""
        sway, lift = np.zeros((2, len(self.end)))
        for j in range(self.sway.shape[1] - 1, -1, -1):
            sway = sway * self.end + self.sway[self.piece, j]
            lift = lift * self.end + self.lift[self.piece, j]
        return sway, lift


def ends_of_parts(length_ns: IntArray | int, parts: IntArray | int, number: IntArray) -> IntArray:
    """Return when the number-th of equal parts of a length ends, rounded to nanoseconds [ns].

    Args:
        length_ns: length of the whole [ns].
        parts: number of parts.
        number: of the part, 1 to `parts`; 0 gives the beginning.
    """
    ends: IntArray = (2 * number * length_ns + parts) // (2 * parts)
    return ends


@dataclass(frozen=True)
class CaseMotion:
    """The motion of the case at n instants, all (n,).

    Attributes:
        theta: tilt θ of the contact's normal [rad].
        phi: tilt φ of the case [rad].
        theta_rate: θ̇ [rad/s].
        phi_rate: φ̇ [rad/s].
    """

    theta: FloatArray
    phi: FloatArray
    theta_rate: FloatArray
    phi_rate: FloatArray


class CaseSwing(Protocol):
    """Propagator of the case; how the motion is divided into calls does not change the result."""

    def release(self, sway: float, lift: float) -> float:
        """Start at rest, at the time 0, hanging in equilibrium; return θ = φ [rad].

        Args:
            sway: ÿ of the bearing then [m/s2].
            lift: g + z̈ then [m/s2], > 0.
        """
        ...

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts; the pieces follow those of the last call."""
        ...

    def state(self) -> State:
        """Return all that the next output depends on."""
        ...

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        ...
