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


def exponential_mean(z: FloatArray) -> FloatArray:
    """Return (eᶻ − 1)/z, the mean of the exponential from 0 to z; 1 at 0."""
    apart = np.where(z == 0.0, 1.0, z)
    return np.where(z == 0.0, 1.0, np.expm1(apart) / apart)


def exponential_defect(z: FloatArray) -> FloatArray:
    """Return 2 (eᶻ − 1 − z)/z², 1 at 0, by its power series where |z| < 1."""
    series = np.ones_like(z)
    small = np.where(np.abs(z) < 1.0, z, 0.0)
    for k in range(20, 2, -1):
        series = 1.0 + small / k * series
    large = np.where(np.abs(z) < 1.0, 1.0, z)
    return np.where(np.abs(z) < 1.0, series, 2.0 * (np.expm1(large) - large) / (large * large))


def logarithmic_mean(z: FloatArray) -> FloatArray:
    """Return ln(1 + z)/z, 1 at 0, for z > −1."""
    apart = np.where(z == 0.0, 1.0, z)
    return np.where(z == 0.0, 1.0, np.log1p(apart) / apart)
