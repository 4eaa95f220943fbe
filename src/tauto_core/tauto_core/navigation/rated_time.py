"""The time over which the filter takes the rate of the clock for one and the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauto_core.samples import JointSamples, TimeSamples

GROWTH = 1.5
"""Least growth of the rate's sigma where the state is reopened.

An outlier ν is beyond 5 √S, and S is at least τ² times the variance of the rate. Reopened and
updated, its sigma is about ν/(2τ), so it has grown by 2.5. Any other observation reduces it.
"""


@dataclass
class _Check:
    """An observation, and the reading at its stamp; the stamp alone until that has come."""

    stamp_ns: int
    reading: tuple[int, int] | None = None


class RatedTime:
    """Finds when the rate that is estimated now began, from observations, readings and estimates.

    The model of the clock has one rate, which walks slowly, until an outlier that has to be
    believed reopens the state: then the rate may have changed since the observation before. Once
    a later observation has come, the rate is measured from the reopening. Of each topic the
    batches come in order; observations come no later than the readings and estimates at their
    stamps, and readings no later than estimates.
    """

    def __init__(self) -> None:
        self._checks: list[_Check] = []
        self._read = self._told = 0
        self._reopened: int | None = None
        self._sigma = np.inf

    def observe(self, observations: TimeSamples) -> None:
        """Take the next batch of `clock/observation`."""
        last = self._checks[-1].stamp_ns if self._checks else -1
        stamps = np.unique(observations.stamp_ns[observations.stamp_ns > last])
        self._checks += [_Check(stamp) for stamp in stamps.tolist()]

    def read(self, readings: TimeSamples) -> None:
        """Take the next batch of `clock/reading`."""
        stamps = readings.stamp_ns
        for check in self._checks[self._read :]:
            place = int(np.searchsorted(stamps, check.stamp_ns))
            if place == len(stamps):
                return
            check.reading = int(stamps[place]), int(readings.time_ref_ns[place])
            self._read += 1

    def estimate(self, estimates: JointSamples) -> None:
        """Take the next batch of `drift/estimate`, n > 0."""
        stamps = estimates.stamp_ns
        known = estimates.position[:, estimates.name.index('rate_sigma_s_per_day')]
        sigmas = np.concatenate(([self._sigma], known))
        for check in self._checks[self._told :]:
            place = int(np.searchsorted(stamps, check.stamp_ns))
            if place == len(stamps):
                break
            if sigmas[place + 1] > GROWTH * sigmas[place]:
                self._reopened = self._told
            self._told += 1
        self._sigma = float(known[-1])

    def start(self) -> tuple[int, int] | None:
        """Return stamp and reading where the time begins [ns]; None where that is the start."""
        if self._reopened is None:
            return None
        measured = self._told > self._reopened + 1
        place = self._reopened if measured else self._reopened - 1
        return self._checks[place].reading if place >= 0 else None
