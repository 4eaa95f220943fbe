"""A sea whose phases stay exact at late times.

Far from the start omega t + phase loses digits. So long runs are divided into stretches, each with
time zero at its beginning and phases reduced exactly.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from benchmarks.work_precision.problems import Numbers, Sea
from tauto_core.samples import FloatArray


def turns_at(sea: Sea, time_s: float) -> list[Fraction]:
    """Return the fractional turns of each component since the start."""
    time = Fraction(time_s)
    return [time / Fraction(float(period)) % 1 for period in sea.period]


def sea_from(sea: Sea | None, time_s: float) -> FloatArray:
    """Return the sea with time zero at `time_s`: rows amplitude, omega, phase; shape (3, n)."""
    if sea is None:
        return np.empty((3, 0))
    turns = np.array([float(turn) for turn in turns_at(sea, time_s)])
    return np.stack([sea.amplitude, sea.omega, sea.phase + 2.0 * np.pi * turns])


def stretches(duration_s: float, length_s: float) -> Iterator[tuple[float, float]]:
    """Yield (start, length) of consecutive stretches [s] that make up a duration."""
    start = 0.0
    while start < duration_s:
        yield start, min(length_s, duration_s - start)
        start += length_s


def constants_of(numbers: Numbers) -> FloatArray:
    """Return the numbers in the order of the kernels, shape (8,)."""
    return np.array(
        [
            numbers.inertia,
            numbers.lever_rate,
            numbers.force,
            numbers.mass,
            numbers.gravity,
            numbers.viscous,
            numbers.impulse_energy,
            0.0 if numbers.sea is None else numbers.sea.height,
        ]
    )
