"""The two normal modes of a link on which a heavy body swings (theory C; Euler 1780, 12–28, 42).

A massless link of length e carries at its end C a body whose centre of gravity is c below C, with
the radius of gyration k about it. To first order in the tilts θ of the link and φ of the body

    e θ̈ + c φ̈ + g θ = 0,    k² φ̈ + g c (φ − θ) = 0.

Each mode keeps time with a simple pendulum of length b or b′ and has the ratio θ : φ = c : B or
c : B′, with

    b + b′ = (k² + c² + ce)/c,    b b′ = e k²/c,    B B′ = −ce,    b = e + B,  b′ = e + B′.

An axle of radius b₀ that lies without friction in a bearing of radius a is such a link with
e = a − b₀; on a plane 1/e = 0, on a convex support e < 0. A thread that swings and winds on a
wheel is one too: e is its free length, c the cam's base radius, k² = I/m.
"""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from typing import NamedTuple

DIGITS = 60
HUGE = 1e100
"""Lengths [m] above which the squares in a formula would overflow."""


class Modes(NamedTuple):
    """The slow and the fast mode; on a convex support the stable and the unstable one.

    Attributes:
        b: length of the simple pendulum that keeps time with the slow mode [m]; infinite on a
            plane, where the mode is a steady drift.
        b_prime: the same for the fast mode [m]; negative where that mode is unstable.
        B: tilt of the body in the slow mode, θ : φ = c : B [m].
        B_prime: the same for the fast mode [m].
    """

    b: float
    b_prime: float
    B: float
    B_prime: float

    @property
    def swings(self) -> bool:
        """Whether no mode is unstable: both lengths are positive or zero."""
        return self.b > 0.0 and self.b_prime >= 0.0

    @property
    def tilt_per_arc(self) -> tuple[float, float]:
        """φ/s in the slow and the fast mode [rad/m], s = eθ ≠ 0: B/(ce) = −1/B′, and −1/B."""
        return -1.0 / self.B_prime, -1.0 / self.B

    def coordinates_at(self, tilt: float, c: float) -> tuple[float, float]:
        """Return q and q′ of θ = c (q + q′), φ = Bq + B′q′ where θ = φ = tilt.

        Args:
            tilt: of link and body [rad].
            c: depth of the centre of gravity below the end of the link [m].
        """
        apart = c * (self.B - self.B_prime)
        return tilt * (c - self.B_prime) / apart, tilt * (self.B - c) / apart

    def squared_frequencies(self, gravity: float) -> tuple[float, float]:
        """Return ω² = g/b of both modes [rad2/s2]; negative if unstable, 0 for a drift."""
        fast = gravity / self.b_prime if self.b_prime else math.inf
        return gravity / self.b, fast


def modes(e: float, c: float, k_squared: float) -> Modes:
    """Return both modes, without cancellation from the knife-edge to the plane and beyond.

    Of the two forms D² = (k² + c² − ce)² + 4c³e = (k² + c² + ce)² − 4cek² the one without a
    difference is used. Of two roots the one whose terms have one sign is computed; the other
    follows from their product.

    Args:
        e: length of the link [m]; ±inf: a plane; negative: convex.
        c: depth of the centre of gravity below the end of the link [m]; negative: above it.
        k_squared: square of the radius of gyration [m2], ≥ 0.

    Raises:
        ValueError: c = 0, where gravity turns the body in neither direction; k² < 0; or values
            that are not finite numbers.
    """
    if math.isnan(e) or not math.isfinite(c) or c == 0.0 or not 0.0 <= k_squared < math.inf:
        raise ValueError(
            f'e = {e!r}, c = {c!r}, k_squared = {k_squared!r}: c must be finite and not 0, '
            'k_squared finite and at least 0'
        )
    # e = p/q, so that a plane has q = 0
    p, q = (e, 1.0) if abs(e) < HUGE else (math.copysign(1.0, e), 1.0 / abs(e))
    link = c * p
    total, rest = q * k_squared + c * (q * c + p), q * k_squared + c * (q * c - p)
    if link >= 0.0:
        root = math.hypot(rest, 2.0 * abs(c) * math.sqrt(link * q))
    else:
        root = math.hypot(total, 2.0 * math.sqrt(-link * q * k_squared))
    added = total + math.copysign(root, total)
    large, small = _over(added, 2.0 * c * q), 2.0 * p * k_squared / added
    b, b_prime = (large, small) if total >= 0.0 else (small, large)
    spread = rest + math.copysign(root, rest)
    leading, other = _over(spread, 2.0 * c * q), -2.0 * c * c * p / spread
    tilt, tilt_prime = (leading, other) if rest >= 0.0 else (other, leading)
    return Modes(b, b_prime, tilt, tilt_prime)


def _over(above: float, below: float) -> float:
    if below:
        return above / below
    return math.copysign(math.inf, above) * math.copysign(1.0, below)


def exact_lengths(e: Decimal, c: Decimal, k_squared: Decimal) -> tuple[Decimal, Decimal]:
    """Return b and b′ [m] to some 40 digits, for phases followed through millions of turns.

    Args:
        e: length of the link [m], > 0, finite.
        c: depth [m], > 0.
        k_squared: square of the radius of gyration [m2], > 0.
    """
    with localcontext() as context:
        context.prec = DIGITS
        total = k_squared + c * c + c * e
        b = (total + (total * total - 4 * c * e * k_squared).sqrt()) / (2 * c)
        return b, e * k_squared / (c * b)
