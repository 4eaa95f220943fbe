"""Finding the place where a condition ceases to hold, by bisection."""

from __future__ import annotations

from collections.abc import Callable

HALVINGS = 60
"""Number of halvings, after which the interval is no longer than the rounding error of its first
length.
"""


def bisect(holds: Callable[[float], bool], good: float, bad: float) -> tuple[float, float]:
    """Return two neighbouring numbers: at the first a condition holds, at the second it does not.

    Args:
        holds: the condition, true from `good` up to one place and false from there to `bad`.
        good: a number at which it holds.
        bad: a number at which it does not, on either side.
    """
    for _ in range(HALVINGS):
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good, bad
