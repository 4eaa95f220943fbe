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

    x runs from 0 to 1 over a piece. The motion of the case is wanted at the ends of the equal
    parts of each piece, rounded to whole nanoseconds.

    Attributes:
        begin_ns: time of each piece's beginning from the start of the run [ns], (n,).
        length_ns: its length [ns], (n,).
        parts: in how many parts it is divided, ≥ 1, (n,).
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
        """Piece of each part, (Σ parts,)."""
        return np.repeat(np.arange(len(self.parts)), self.parts)

    @cached_property
    def end_ns(self) -> IntArray:
        """Time of each part's end from the start of the run [ns], (Σ parts,)."""
        piece = self.piece
        place = np.arange(1, len(piece) + 1) - (np.cumsum(self.parts) - self.parts)[piece]
        length, parts = self.length_ns[piece], self.parts[piece]
        return self.begin_ns[piece] + ends_of_parts(length, parts, place)

    @cached_property
    def end(self) -> FloatArray:
        """Where in its piece each part ends, 0 < x ≤ 1, (Σ parts,)."""
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


def ends_of_parts(length_ns: IntArray | int, parts: IntArray | int, place: IntArray) -> IntArray:
    """Return where the place-th of equal parts ends, to the nearest nanosecond [ns]."""
    ends: IntArray = (2 * place * length_ns + parts) // (2 * parts)
    return ends


@dataclass(frozen=True)
class CaseMotion:
    """Tilt θ of the contact's normal and φ of the case, and their rates, arrays of shape (n,)."""

    theta: FloatArray
    phi: FloatArray
    theta_rate: FloatArray
    phi_rate: FloatArray


class CaseSwing(Protocol):
    """Moves the case; batches do not change the result, and it can be resumed."""

    def release(self, sway: float, lift: float) -> float:
        """Start at rest, at the time 0, hanging in equilibrium; return θ = φ [rad].

        Args:
            sway: ÿ of the bearing then [m/s2].
            lift: g + z̈ then [m/s2], > 0.
        """
        ...

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts of pieces that follow those before."""
        ...

    def state(self) -> State:
        """Return all that the next output depends on."""
        ...

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        ...
