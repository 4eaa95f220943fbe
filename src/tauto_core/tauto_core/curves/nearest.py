"""The nearest value that works, which errors name as the remedy."""

from __future__ import annotations

import math
from collections.abc import Callable

MOST_STEPS = 40
# the interval is then narrower than the rounding to the printed digits
_HALVINGS = 20
_DIGITS = 4


def nearest(value: float, factor: float, works: Callable[[float], bool]) -> float:
    """Return the nearest value that works, in the direction of the factor.

    It is rounded to four digits, away from the value that does not work.

    Args:
        value: > 0, does not work.
        factor: other than 1; applied repeatedly until a value works.
        works: test of a value; true for all values beyond the first that works.
    """
    bad, good = value, value * factor
    while not works(good):
        bad, good = good, good * factor
    return _between(bad, good, works)


def nearest_if_any(value: float, factor: float, works: Callable[[float], bool]) -> float | None:
    """Return the same, or None if 40 steps by the factor find nothing that works."""
    bad, good = value, value * factor
    for _ in range(MOST_STEPS):
        if works(good):
            return _between(bad, good, works)
        bad, good = good, good * factor
    return None


def farther(arm: float) -> str:
    """Return the remedy for a cam whose lever arm would be too long for its hole [m]."""
    return f', or move the hole to at least {arm:.6g} m from the axle'


def choices(*tried: tuple[str, str, float, float, Callable[[float], bool]]) -> str:
    """Return the remedies that work, as the end of a sentence; empty if none does."""
    found = that_work(*tried)
    return f', or use {found}' if found else ''


def that_work(*tried: tuple[str, str, float, float, Callable[[float], bool]]) -> str:
    """Return the remedies that work: each as words, unit, value, direction and test."""
    found = (
        (words, unit, nearest_if_any(value, factor, works))
        for words, unit, value, factor, works in tried
    )
    return ' or '.join(
        f'{words} {value:.4g} {unit}' for words, unit, value in found if value is not None
    )


def _between(bad: float, good: float, works: Callable[[float], bool]) -> float:
    up = good > bad
    for _ in range(_HALVINGS):
        middle = math.sqrt(bad) * math.sqrt(good)
        bad, good = (bad, middle) if works(middle) else (middle, good)
    exponent = math.floor(math.log10(good)) + 1 - _DIGITS
    share = good / 10.0**exponent
    digits, step = (math.ceil(share), 1) if up else (math.floor(share), -1)
    # tests the number as it will be typed, since near the edge rounding decides
    while not works(typed := float(f'{digits}e{exponent}')):
        digits += step
    return typed
