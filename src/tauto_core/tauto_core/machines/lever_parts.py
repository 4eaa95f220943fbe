"""What all of Sully's levers share, whatever cam the thread leaves: parts, edges, and τ of θ."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tauto_core.curves.bisection import bisect
from tauto_core.curves.newton import bracketed_newton
from tauto_core.samples import FloatArray

LEAST_COSINE = 0.1
"""cos(β − δ) or cos β at the edge: beyond, the lever is within six degrees of a dead point (in
line with the thread) or of upright."""

LEAST_FREE = 0.1
"""Part of the thread that is still free at the edge."""

_SCAN = 4096


class Pose(NamedTuple):
    """Where the parts are, arrays of any one shape.

    Attributes:
        u: θ − δ, the direction of the thread's line in the wheel's frame; of an involute, what
            the thread has wound up [rad].
        beta: β of the lever above the level [rad].
        delta: δ of the thread from the plumb line [rad].
        free: length of the thread from the cam to B [m].
    """

    u: FloatArray
    beta: FloatArray
    delta: FloatArray
    free: FloatArray


def clear(beta: FloatArray, delta: FloatArray, free: FloatArray) -> np.ndarray:
    """Return where lever and thread keep clear of a dead point, of upright, and of its end.

    Args:
        beta: β of the lever [rad], NaN where it cannot be.
        delta: δ of the thread [rad], likewise.
        free: length of the thread from the cam to B, by that at rest, likewise.
    """
    least = np.minimum(np.cos(beta), np.cos(beta - delta))
    return np.asarray((least >= LEAST_COSINE) & (free >= LEAST_FREE))


def edges(usable: Callable[[FloatArray], np.ndarray]) -> tuple[float, float]:
    """Return the least and largest τ up to which all between is usable, by bisection.

    Args:
        usable: of τ, (n,); not so at τ = ±1, where the lever is upright.
    """
    return -_edge(usable, -1.0), _edge(usable, 1.0)


def tau_of(
    theta: FloatArray,
    within: tuple[float, float],
    angle: Callable[[FloatArray], FloatArray],
    rate: Callable[[FloatArray], FloatArray],
) -> FloatArray:
    """Return τ of the wheel's angle (Newton's method, kept in brackets).

    Args:
        theta: θ of the wheel [rad], of any shape.
        within: least and largest τ.
        angle: θ of τ [rad], increasing.
        rate: dθ/dτ.
    """
    theta = np.asarray(theta, np.float64)
    start = np.asarray(theta / rate(np.zeros(1))[0])
    return bracketed_newton(
        lambda tau: (angle(tau) - theta, rate(tau)), start, within, relative=2e-16
    )


def _edge(usable: Callable[[FloatArray], np.ndarray], side: float) -> float:
    grid = side * np.arange(1, _SCAN + 1) / _SCAN
    b = float(grid[np.argmin(usable(grid))])
    return abs(bisect(lambda tau: bool(usable(np.array([tau]))[0]), b - side / _SCAN, b)[0])
