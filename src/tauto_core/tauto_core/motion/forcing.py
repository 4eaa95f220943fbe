"""The forcing of the machine, as polynomials over short pieces of time.

A piece is the time between two joints (motion samples, neighbours or several apart); x runs from 0
to 1 over its `length_s`. A span is the part of a piece, from `begin` to `end`, that a propagator
covers at once; spans follow each other without gaps and end where a sample must be logged.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import FloatArray, IntArray


@dataclass(frozen=True)
class Window:
    """The neutral line as the samples that its polynomials interpolate, for linear propagators.

    Attributes:
        nodes: x of the p samples of a regular piece's window.
        values: γ of samples that lie evenly in regular windows [rad], (m,).
        rates: γ̇ of the same [rad/s], (m,).
        first: place in these at which the window of a span's piece begins, ≥ 0; of a piece that
            is not regular −1 less the row of `fitted`; (n,).
        fitted: coefficients of x^j over the pieces that are not regular, (k, 2p).
    """

    nodes: tuple[float, ...]
    values: FloatArray
    rates: FloatArray
    first: IntArray
    fitted: FloatArray


@dataclass(frozen=True)
class Forcing:
    """n consecutive spans and the polynomials that hold over them.

    Attributes:
        length_s: length of the piece each span belongs to [s], (n,).
        begin: where in the piece the span begins, 0 ≤ begin < end ≤ 1, (n,).
        end: where in the piece the span ends, (n,).
        end_ns: time of the span's end from the start of the run [ns], (n,).
        logged: whether the state at the span's end is wanted, (n,).
        neutral: coefficients of x^j of the neutral line's direction γ [rad], (n, m), or None
            where the platform lies still or a window takes its place.
        tilt: the same of the neutral line's tilt in the case, γ − α_c [rad], (n, m'); None where
            it is zero: the thread goes with the case, or the platform lies still.
        gravity: the same of the apparent gravity [m/s2], (n, m''); None where the pull does not
            feel it.
        window: the neutral line by samples; None: not asked for.
    """

    length_s: FloatArray
    begin: FloatArray
    end: FloatArray
    end_ns: IntArray
    logged: NDArray[np.bool_]
    neutral: FloatArray | None = None
    tilt: FloatArray | None = None
    gravity: FloatArray | None = None
    window: Window | None = None


def check_powers(forcing: Forcing, most: int) -> None:
    """Refuse channels with more powers of x than a propagator takes.

    Raises:
        ValueError: one has more than `most`.
    """
    for name in ('neutral', 'tilt', 'gravity'):
        channel = getattr(forcing, name)
        if channel is not None and channel.shape[1] > most:
            raise ValueError(
                f'Forcing.{name} has {channel.shape[1]} powers of x, at most {most} are taken. '
                'Divide its pieces'
            )


@dataclass(frozen=True)
class Motion:
    """The regulator's motion at logged instants; every array is (n,).

    `half_turns` + `fraction` is the oscillator phase in half turns, less its value at the start.
    """

    angle: FloatArray
    """θ, the wheel in its case [rad]."""
    rate: FloatArray
    """θ̇ [rad/s]."""
    torque: FloatArray
    """Torque of the thread on the wheel [N m]."""
    half_turns: IntArray
    fraction: FloatArray
    phase_rate: FloatArray
    """φ̇ [rad/s]."""
    beats: IntArray
    """Passages of θ through zero since the start."""


def no_motion() -> Motion:
    """Return the motion at no instant."""
    none, counts = np.empty(0), np.empty(0, np.int64)
    return Motion(none, none, none, counts, none, none, counts)
