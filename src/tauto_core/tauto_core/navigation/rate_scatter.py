"""The standard error of a run's mean rate, from the scatter of the rates of its parts."""

from __future__ import annotations

import math
import statistics

import numpy as np

from tauto_core.samples import SECONDS_PER_DAY, TimeSamples

PARTS = 10
"""Few enough that each part is longer than the effects of single waves, and enough to estimate
their scatter.
"""

LEAST_PARTS = 3


class RateScatter:
    """Takes the readings of a dial in order, in batches of any size, and keeps eleven of them.

    The mean rate of a run is the mean of the rates of its equal parts. If these are independent,
    its standard error is s/√n, with s the standard deviation of n parts: the method of batch means
    (Law & Kelton, Simulation Modeling and Analysis, 9.5.3). Neighbouring parts share a reading,
    whose error changes them in opposite directions; that makes the result too large, never too
    small.

    Args:
        first_ns: stamp of the first reading [ns].
        length_ns: length of the run [ns], > 0; of a run that ends early only whole parts count.
    """

    def __init__(self, first_ns: int, length_ns: int) -> None:
        self._ends_ns = [first_ns + part * length_ns // PARTS for part in range(PARTS + 1)]
        self._kept: list[tuple[int, int]] = []

    def feed(self, readings: TimeSamples) -> None:
        """Keep the first reading at or after the end of each part."""
        stamps = readings.stamp_ns
        while self._ends_ns and len(stamps) and self._ends_ns[0] <= stamps[-1]:
            index = int(np.searchsorted(stamps, self._ends_ns.pop(0)))
            reading = int(stamps[index]), int(readings.time_ref_ns[index])
            if reading not in self._kept[-1:]:
                self._kept.append(reading)

    def standard_error_s_per_day(self) -> float | None:
        """Return the standard error of the mean rate [s/day]; None for fewer than three parts."""
        rates = [
            ((dial - dial_before) / (stamp - before) - 1.0) * SECONDS_PER_DAY
            for (before, dial_before), (stamp, dial) in zip(
                self._kept, self._kept[1:], strict=False
            )
        ]
        if len(rates) < LEAST_PARTS:
            return None
        return statistics.stdev(rates) / math.sqrt(len(rates))
