"""Times in whole nanoseconds, numbers and dates in texts, constants. No NumPy, no pydantic."""

from __future__ import annotations

from contextlib import suppress
from datetime import UTC, datetime, timedelta
from fractions import Fraction
from functools import lru_cache

NS_PER_S = 1_000_000_000
DAY_S = 86_400.0

# -----------------------------------------------------------------------------
# Constants of scenes that are used without pydantic.

STANDARD_GRAVITY = 9.80665
"""Standard gravity [m/s2], exact by definition (3rd CGPM, 1901)."""

LEGIBLE = 0.25
"""Error of a reading, in periods, above which the phase is lost."""


# builtin_interfaces/Time has seconds as int32
LAST_STAMP_S = 2**31 - 1
# samples that interpolation needs beyond the end of a motion
LOOKAHEAD = 4
EPOCH_1990_NS = 631_152_000 * 10**9
"""Earlier stamps come from a simulation, or from a computer without a set clock [ns]."""

MAX_GAP_S = 1.0
"""Longest time between samples of the motion that is interpolated [s]."""


@lru_cache(1024)  # a voyage converts some times again and again
def exact_nanoseconds(seconds: float) -> Fraction:
    """Return seconds as nanoseconds, from the shortest decimal that reads back as `seconds`.

    0.1 s is 100 000 000 ns, not 100 000 000.0000000055 ns.
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


# -----------------------------------------------------------------------------
# Numbers and dates in tables, logs and tracks.

EARLIEST_YEAR, LATEST_YEAR = 1500, 2999
"""Limits of years: a date plus a voyage stays within the calendar."""


def number_in(text: str) -> float:
    """Return the number in a text, such as 1.5e3 or nan, or raise ValueError.

    Unlike in Python, 1_0 and digits of other scripts are errors.
    """
    with suppress(ValueError):
        if '_' not in text and text.isascii():
            return float(text)
    raise ValueError('is not a number')


def utc_in(text: str) -> datetime:
    """Return a date and time in UTC, such as 2000-01-01T02:00, or raise ValueError."""
    if 'T24' in text or ' 24:' in text:
        raise ValueError('has the hour 24; write 00:00 of the next day')
    try:
        instant = datetime.fromisoformat(text)
    except ValueError:
        raise ValueError('is not a date and time, such as 1791-10-26T13:00') from None
    return in_utc(instant)


def in_utc(instant: datetime) -> datetime:
    """Return a time in UTC, also without a zone, or raise ValueError."""
    if not EARLIEST_YEAR <= instant.year <= LATEST_YEAR:
        raise ValueError(f'must lie in the years {EARLIEST_YEAR} to {LATEST_YEAR}')
    return instant.replace(tzinfo=UTC) if instant.tzinfo is None else instant.astimezone(UTC)


def utc_on(year: float, month: float, day: float, seconds: float) -> datetime:
    """Return a time in UTC, rounded to seconds, from date and seconds since midnight.

    ValueError for a wrong date, or seconds outside [0, 86400).
    """
    if not all(map(float.is_integer, (year, month, day))):
        raise ValueError('year, month and day must be whole numbers')
    if not 0.0 <= seconds < DAY_S:
        raise ValueError('the hour must be at least 0 and less than 24')
    try:
        midnight = datetime(int(year), int(month), int(day))
    except OverflowError as error:
        raise ValueError(str(error)) from None
    return in_utc(midnight) + timedelta(seconds=round(seconds))
