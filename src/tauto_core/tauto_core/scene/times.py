"""Times as whole nanoseconds, default numbers of scenes; no NumPy, no pydantic."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

NS_PER_S = 1_000_000_000
DAY_S = 86_400.0

# -----------------------------------------------------------------------------
# Default numbers of scenes, apart from the models so that using them loads no pydantic.

STANDARD_GRAVITY = 9.80665
"""Standard gravity [m/s2]; exact by definition (3rd CGPM, 1901)."""

LEGIBLE = 0.25
"""Error of a reading, in periods, above which the phase is lost."""


# builtin_interfaces/Time has whole seconds in 32 bits, including the sign.
LAST_STAMP_S = 2**31 - 1
# Number of samples that interpolation needs beyond the end of a motion.
LOOKAHEAD = 4
MAX_GAP_S = 1.0
"""Longest time between samples of the motion that is interpolated [s]."""


@lru_cache(1024)  # a voyage asks for some times again and again
def exact_nanoseconds(seconds: float) -> Fraction:
    """Return seconds as nanoseconds, exact in the shortest decimal that reads back as `seconds`.

    0.1 s is 100 000 000 ns, not the 100 000 000.0000000055 ns of its binary value.
    """
    return Fraction(repr(float(seconds))) * NS_PER_S


def nanoseconds(seconds: float) -> int:
    """Return seconds as the nearest whole nanosecond."""
    return round(exact_nanoseconds(seconds))


@lru_cache(1024)
def exact_step(rate_hz: float) -> Fraction:
    """Return the time between samples at a rate > 0 [ns]."""
    return NS_PER_S / Fraction(repr(float(rate_hz)))


def step_of_rate(rate_hz: float) -> int:
    """Return the time between samples [ns], for a rate that divides into whole nanoseconds."""
    return round(exact_step(rate_hz))


def whole_intervals(length_ns: int, interval_ns: int) -> int:
    """Return the longest whole number of intervals in a length [ns]."""
    return length_ns // interval_ns * interval_ns
