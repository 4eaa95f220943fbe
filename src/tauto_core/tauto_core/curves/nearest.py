"""The nearest value that works: what an error names as its remedy."""

from __future__ import annotations

import math
from collections.abc import Callable

_HALVINGS = 40
_DIGITS = 4


def nearest(value: float, factor: float, works: Callable[[float], bool]) -> float:
    """Return the value nearest to one that does not work, in the direction of the factor.

    It is rounded to four digits, away from what does not work.

    Args:
        value: > 0, does not work.
        factor: other than 1; by it again and again something is found that works.
        works: of a value, and of all beyond it.
    """
    bad, good = value, value * factor
    while not works(good):
        bad, good = good, good * factor
    for _ in range(_HALVINGS):
        middle = math.sqrt(bad * good)
        bad, good = (bad, middle) if works(middle) else (middle, good)
    unit = 10.0 ** (math.floor(math.log10(good)) + 1 - _DIGITS)
    return (math.ceil if factor > 1.0 else math.floor)(good / unit) * unit
