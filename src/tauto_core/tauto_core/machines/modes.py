"""The two modes of paper C: a pendulum on an axle, and Euler's wheel on a swinging thread alike.

    e θ̈ + c φ̈ = −G θ,    k² φ̈ = −G c (φ − θ)                          (Euler 1780 II, 12–13)

Of a thread, e → l₀, c → r, k² → I/m, θ → the thread's inclination, φ → the wheel's angle.
"""

from __future__ import annotations

import math
from typing import NamedTuple


class Modes(NamedTuple):
    """Lengths of the isochronous pendulums and shapes (Euler 1780 II, 42).

    A mode with the length b moves as θ = c sin wt, φ = B sin wt with w = √(G/b), B = b − e.

    Attributes:
        slow: b, the longer length [m].
        fast: b', the shorter [m].
        slow_share: B of the slow mode [m], > 0.
        fast_share: B' of the fast mode [m], < 0.
    """

    slow: float
    fast: float
    slow_share: float
    fast_share: float


def modes(e: float, c: float, k_squared: float) -> Modes:
    """Return both modes, in forms without cancellation.

    b + b' = e + c + k²/c, b b' = e k²/c, B B' = −c e.

    Args:
        e: support's radius less the axle's; of a thread its length [m], > 0.
        c: from the axle to the centre of gravity; of a wheel the cam's base radius [m], > 0.
        k_squared: square of the radius of gyration; of a wheel I/m [m2], > 0.
    """
    total, difference = k_squared + c * c + c * e, k_squared + c * c - c * e
    root = math.hypot(difference, 2.0 * c * math.sqrt(c * e))
    slow, fast = (total + root) / (2.0 * c), 2.0 * e * k_squared / (total + root)
    if difference >= 0.0:
        share = (difference + root) / (2.0 * c)
        return Modes(slow, fast, share, -c * e / share)
    share = (difference - root) / (2.0 * c)
    return Modes(slow, fast, -c * e / share, share)
