"""Differences of nearly equal functions, to full relative precision at small arguments."""

from __future__ import annotations

import numpy as np

from tauto_core.samples import FloatArray


def sine_defect(x: FloatArray) -> FloatArray:
    """Return x − sin x, by its power series where |x| < 1."""
    small = np.where(np.abs(x) < 1.0, x, 0.0)
    square = small * small
    tail = np.ones_like(square)
    for k in range(9, 1, -1):
        tail = 1.0 - square / (2 * k * (2 * k + 1)) * tail
    return np.where(np.abs(x) < 1.0, small * square / 6.0 * tail, x - np.sin(x))


def involute_defect(x: FloatArray) -> FloatArray:
    """Return sin x − x cos x, by its power series where |x| < 1."""
    small = np.where(np.abs(x) < 1.0, x, 0.0)
    square = small * small
    tail = np.ones_like(square)
    for k in range(9, 0, -1):
        tail = 1.0 - square / (2 * k * (2 * k + 3)) * tail
    return np.where(np.abs(x) < 1.0, small * square / 3.0 * tail, np.sin(x) - x * np.cos(x))


def arctangent_defect(x: FloatArray) -> FloatArray:
    """Return x − arctan x, by its power series where |x| < 1/2."""
    small = np.where(np.abs(x) < 0.5, x, 0.0)
    square = small * small
    series = np.zeros_like(square)
    for k in range(26, 0, -1):
        series = 1.0 / (2 * k + 1) - square * series
    return np.where(np.abs(x) < 0.5, small * square * series, x - np.arctan(x))
