"""The suspended case at small angles: both modes, each with the exact step for a polynomial.

    e θ̈ + c φ̈ + g θ = −ÿ,    k² φ̈ + g c (φ − θ) = 0                       (theory E3)

θ = c (q + q′) and φ = Bq + B′q′ leave q̈ + ω²q = −ÿ/(ec + B²) with ω² = g/b, and the like with
B′, b′. z = q̇ + iωq obeys ż = iωz + f; in the frame that turns with ω, Y = e^{−iωt} z, a piece is
one addition:

    Y(t + h) = Y(t) + e^{−iωt} ∫₀^h e^{−iωs} f(t + s) ds.

ωt is reduced exactly from the time, with ω to 40 digits: nothing grows with the number of steps
but the rounding of their sum. Source: variation of constants; motion.forced_harmonic.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import lru_cache

import numpy as np

from tauto_core.machines.modes import exact_lengths, modes
from tauto_core.motion.bearing import BearingMotion, CaseMotion, ends_of_parts
from tauto_core.motion.harmonic import half_turns_per_ns
from tauto_core.motion.phase import DIGITS, half_turns
from tauto_core.samples import FloatArray, IntArray, State

_ROOTS, _WEIGHTS = np.polynomial.legendre.leggauss(16)


@dataclass(frozen=True)
class _Mode:
    """A mode: ω, ω/π per ns in two floats, B, and what q̈ takes of −ÿ."""

    omega: float
    per_ns: tuple[float, float]
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
        _Mode(float(slow), half_turns_per_ns(slow), own.B, 1.0 / (own.B * apart)),
        _Mode(float(fast), half_turns_per_ns(fast), own.B_prime, -1.0 / (own.B_prime * apart)),
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
        self._y = np.zeros((2, 2))

    def release(self, sway: float, lift: float) -> float:  # noqa: ARG002
        """Start at rest, at the time 0, with θ = φ = −ÿ/g [rad], and return that.

        Args:
            sway: ÿ of the bearing then [m/s2].
            lift: g + z̈ then [m/s2]; of no consequence at small angles.
        """
        tilt = -sway / self._gravity
        slow, fast = self._modes
        c, apart = self._c, slow.tilt - fast.tilt
        q = tilt * (c - fast.tilt) / (c * apart)
        q_fast = tilt * (slow.tilt - c) / (c * apart)
        self._y = np.array([[0.0, slow.omega * q], [0.0, fast.omega * q_fast]])
        return tilt

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts."""
        q, rate = np.empty((2, 2, len(bearing.end)))
        for m, mode in enumerate(self._modes):
            rate[m], q[m] = self._advance_mode(m, mode, bearing)
            q[m] /= mode.omega
        slow, fast = (mode.tilt for mode in self._modes)
        return CaseMotion(
            self._c * (q[0] + q[1]),
            slow * q[0] + fast * q[1],
            self._c * (rate[0] + rate[1]),
            slow * rate[0] + fast * rate[1],
        )

    def _advance_mode(
        self, m: int, mode: _Mode, bearing: BearingMotion
    ) -> tuple[FloatArray, FloatArray]:
        """Return q̇ and ωq at the ends of the parts."""
        re, im = _responses(mode, bearing)
        c, s = _frame(mode, bearing.begin_ns)
        last = np.cumsum(bearing.parts) - 1
        y = np.empty((2, len(c) + 1))
        y[:, 0] = self._y[m]
        y[0, 1:] = c * re[last] + s * im[last]
        y[1, 1:] = c * im[last] - s * re[last]
        # one addition after the other, however the pieces are batched
        np.cumsum(y, axis=1, out=y)
        self._y[m] = y[:, -1]
        c_begin, s_begin = (np.repeat(each, bearing.parts) for each in (c, s))
        y_re = np.repeat(y[0, :-1], bearing.parts) + (c_begin * re + s_begin * im)
        y_im = np.repeat(y[1, :-1], bearing.parts) + (c_begin * im - s_begin * re)
        y_re[last], y_im[last] = y[:, 1:]
        since_ns = bearing.end_ns - np.repeat(bearing.begin_ns, bearing.parts)
        turned = mode.omega * 1e-9 * since_ns
        c, s = np.cos(turned), np.sin(turned)
        y_re, y_im = c * y_re - s * y_im, s * y_re + c * y_im
        return c_begin * y_re - s_begin * y_im, s_begin * y_re + c_begin * y_im

    def state(self) -> State:
        """Return Y of both modes."""
        return {'y': self._y.copy()}

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self._y = np.array(state['y'])


def _frame(mode: _Mode, times_ns: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return cos ωt and sin ωt."""
    half, fraction = half_turns(times_ns, mode.per_ns)
    sign = np.where(half % 2 == 0, 1.0, -1.0)
    return sign * np.cos(np.pi * fraction), sign * np.sin(np.pi * fraction)


def _responses(mode: _Mode, bearing: BearingMotion) -> tuple[FloatArray, FloatArray]:
    """Return ∫ e^{−iωs} f ds from each piece's beginning to the ends of its parts, (Σ parts,)."""
    re, im = np.empty((2, len(bearing.end)))
    shapes = np.stack([bearing.length_ns, bearing.parts], axis=1)
    first = np.cumsum(bearing.parts) - bearing.parts
    other = np.any(shapes != shapes[0], axis=1)
    groups = [np.flatnonzero(~other), *np.flatnonzero(other)[:, None]]
    for pieces in groups:
        length, parts = (int(each) for each in shapes[pieces[0]])
        rows = _rows(mode, length, parts, bearing.sway.shape[1])
        sway = bearing.sway[pieces]
        some = np.zeros((2, len(pieces), parts))
        for j in range(sway.shape[1]):
            some += rows[:, None, :, j] * sway[:, j, None]
        at = first[pieces][:, None] + np.arange(parts)
        re[at], im[at] = some
    return re, im


@lru_cache(maxsize=1024)
def _rows(mode: _Mode, length_ns: int, parts: int, width: int) -> FloatArray:
    """Return what takes the coefficients of ÿ to the integrals, (2, parts, width).

    Gauss–Legendre in each part, over which the frame turns by less than a radian.
    """
    place = np.arange(parts + 1)
    ends = ends_of_parts(length_ns, parts, place) / length_ns
    middle, half = 0.5 * (ends[1:] + ends[:-1]), 0.5 * (ends[1:] - ends[:-1])
    x = middle[:, None] + half[:, None] * _ROOTS
    length_s = length_ns * 1e-9
    weight = (-mode.share * length_s) * half[:, None] * _WEIGHTS
    turned = mode.omega * length_s * x
    powers = x[:, :, None] ** np.arange(width)
    parts_of = [
        np.sum((weight * wave)[:, :, None] * powers, axis=1)
        for wave in (np.cos(turned), -np.sin(turned))
    ]
    return np.cumsum(np.stack(parts_of), axis=1)
