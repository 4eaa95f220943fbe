"""The error of a clock along a passage, at as many instants as a figure needs."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tauto_core.samples import NS_PER_S, READING, SECONDS_PER_DAY, FloatArray, Samples, TimeSamples
from tauto_core.scene import Scene

PIECES = 96
"""Number of equal pieces of a passage at whose ends the error is kept."""


class ErrorTrace:
    """Keeps the clock's error at the ends of at most PIECES equal pieces of a scene.

    A piece is a whole number of log intervals; a shorter remainder at the end is not used.

    Args:
        scene: the scene of the readings.
    """

    def __init__(self, scene: Scene) -> None:
        self._starts_at_ns = scene.starts_at_ns
        self._piece_ns = scene.log_interval_ns * math.ceil((scene.log_count - 1) / PIECES)
        self._stamps: list[int] = []
        self._errors: list[int] = []

    @property
    def piece_s(self) -> float:
        """Length of a piece [s]."""
        return self._piece_ns / NS_PER_S

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take batches of any topics, in order within a topic."""
        reading = batches.get(READING)
        if not isinstance(reading, TimeSamples):
            return
        kept = (reading.stamp_ns - self._starts_at_ns) % self._piece_ns == 0
        stamps = reading.stamp_ns[kept]
        self._stamps += (stamps - self._starts_at_ns).tolist()
        self._errors += (reading.time_ref_ns[kept] - stamps).tolist()

    @property
    def time_s(self) -> FloatArray:
        """Time from the start at the ends of the pieces, the start itself first [s], (n,)."""
        return np.array(self._stamps, np.int64) / NS_PER_S

    @property
    def error_s(self) -> FloatArray:
        """Reading less true time then [s], (n,)."""
        return np.array(self._errors, np.int64) / NS_PER_S

    def rate_spread(self) -> float | None:
        """Return the standard deviation of the rates of the pieces [s/day]; None for one piece."""
        rates = np.diff(self.error_s) / self.piece_s * SECONDS_PER_DAY
        return float(np.std(rates, ddof=1)) if len(rates) > 1 else None
