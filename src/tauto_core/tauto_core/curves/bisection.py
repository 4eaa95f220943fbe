"""Where a condition ceases to hold, by halving."""

from __future__ import annotations

from collections.abc import Callable

HALVINGS = 60
"""After them the interval is a rounding of its first length, or less."""


def bisect(holds: Callable[[float], bool], good: float, bad: float) -> tuple[float, float]:
    """Return two neighbouring numbers: at the first a condition holds, at the second it does not.

    Args:
        holds: the condition, true from `good` up to one place and false from there to `bad`.
        good: where it holds.
        bad: where it does not, on either side.
    """
    for _ in range(HALVINGS):
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good, bad
