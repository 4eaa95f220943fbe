"""Newton's method for many equations at once, each independent of the others."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tauto_core.samples import FloatArray

_STEPS = 100


def bracketed_newton(
    equation: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
    start: FloatArray,
    bracket: tuple[FloatArray | float, FloatArray | float],
    relative: float = 0.0,
    absolute: FloatArray | float = 0.0,
) -> FloatArray:
    """Return the roots of increasing functions, in the shape of `start`.

    Newton's method inside a bracket that only shrinks; where a step would leave the bracket, the
    bracket is halved. An element whose last step was within the tolerance keeps its value while
    others continue, so the bits of a root do not depend on the rest of the batch.

    Args:
        equation: value and derivative of the functions at x, element by element.
        start: first x.
        bracket: least and largest x, broadcast against `start`; infinite where Newton's method
            cannot overshoot.
        relative: tolerance of the last step, as a share of the root.
        absolute: further tolerance of the last step, added to the first; broadcast too.
    """
    low, high = (np.broadcast_to(np.asarray(end, np.float64), start.shape) for end in bracket)
    x, settled = np.clip(start, low, high), np.zeros(start.shape, np.bool_)
    for _ in range(_STEPS):
        value, slope = equation(x)
        low, high = np.where(value <= 0.0, x, low), np.where(value >= 0.0, x, high)
        # where the derivative is 0 the bracket is halved
        with np.errstate(divide='ignore', invalid='ignore'):
            trial = x - value / slope
        inside = (trial >= low) & (trial <= high)
        moved = np.where(inside, trial, 0.5 * (low + high))
        near = np.abs(moved - x) <= absolute + relative * np.abs(moved)
        x, settled = np.where(settled, x, moved), settled | near
        if np.all(settled):
            break
    return np.asarray(x)
