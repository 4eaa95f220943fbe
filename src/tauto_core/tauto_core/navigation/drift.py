"""The drift stage: readings and observations in, estimate and corrected time out."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import ClassVar, cast

import numpy as np

from tauto_core.navigation.kalman import ClockModel, Estimate, filter_phases, predict, prior
from tauto_core.navigation.ordering import AFTER_ALL, BEFORE_ALL, in_order
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    NS_PER_S,
    OBSERVATION,
    READING,
    SECONDS_PER_DAY,
    Batches,
    FloatArray,
    IntArray,
    Samples,
    State,
    TimeSamples,
    same,
    scalars,
)
from tauto_core.scene import Scene
from tauto_core.ship.observations import schedule

ESTIMATE_NAMES = ('offset_s', 'offset_sigma_s', 'rate_s_per_day', 'rate_sigma_s_per_day')
HISTORY = 4096
"""Readings remembered, beyond those held back, for observations that come late."""


def clock_model(scene: Scene) -> ClockModel:
    """Return what `drift` says of the clock, with the noise of a good clock (the floors)."""
    drift = scene.drift
    return ClockModel(
        observation_sigma_s=drift.observation_sigma,
        prior_rate_sigma=drift.prior_rate_sigma / SECONDS_PER_DAY,
        states=drift.states,
    )


class DriftStage:
    """Estimates offset and rate of the dial and takes the offset from its readings.

    One `drift/estimate` and one `clock/corrected` go out for each `clock/reading`, at its stamp.
    The dial is taken as set right at the first reading. An observation is compared with the
    reading at its stamp, or with the line between the readings on both sides of it.

    Args:
        scene: gives the observations' sigma and schedule and the prior.
        expect_schedule: an estimate at t uses every observation with stamp <= t, whatever the
            order of arrival between the topics: readings at and after the next scheduled
            observation wait until it, or a later one, has come, or until `finish`. False: an
            observation counts for the readings that go out after it came; it may be late by
            `HISTORY` readings.
    """

    inputs: ClassVar[tuple[str, ...]] = (READING, OBSERVATION)
    outputs: ClassVar[tuple[str, ...]] = (ESTIMATE, CORRECTED)

    def __init__(self, scene: Scene, expect_schedule: bool = True) -> None:
        self._model = clock_model(scene)
        self._schedule = schedule(scene) if expect_schedule else None
        none = np.empty(0, np.int64)
        self._stamp, self._reference = none, none
        self._released = 0
        self._pending: list[tuple[int, int]] = []
        self._last_reading_ns = BEFORE_ALL
        self._last_observation_ns = BEFORE_ALL
        self._estimate = prior(self._model)
        self._estimate_ns = BEFORE_ALL
        self._health = {
            'readings_out_of_order': 0,
            'observations_out_of_order': 0,
            'observations_unscheduled': 0,
            'observations_missing': 0,
            'observations_too_old': 0,
            'observations_unmatched': 0,
        }

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Take readings and observations; return what can be said now."""
        if READING in batches:
            self._accept_readings(cast(TimeSamples, batches[READING]))
        if OBSERVATION in batches:
            self._accept_observations(cast(TimeSamples, batches[OBSERVATION]))
        return self._release(self._next_scheduled_ns())

    def finish(self) -> Batches:
        """Release the readings that wait; count the observations that did not come."""
        last = self._last_observation_ns
        said = self._release(AFTER_ALL)
        if self._schedule is not None:
            due = (self._schedule > last) & (self._schedule <= self._last_reading_ns)
            self._health['observations_missing'] += int(np.count_nonzero(due))
        self._health['observations_unmatched'] += len(self._pending)
        self._pending = []
        return said

    def state(self) -> State:
        """Return readings, observations and estimate."""
        return {
            'stamp': self._stamp,
            'reference': self._reference,
            'released': self._released,
            'pending': list(self._pending),
            'last_reading_ns': self._last_reading_ns,
            'last_observation_ns': self._last_observation_ns,
            'estimate': tuple(self._estimate),
            'estimate_ns': self._estimate_ns,
            'health': dict(self._health),
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self._stamp = state['stamp']
        self._reference = state['reference']
        self._released = state['released']
        self._pending = [(stamp, reference) for stamp, reference in state['pending']]
        self._last_reading_ns = state['last_reading_ns']
        self._last_observation_ns = state['last_observation_ns']
        self._estimate = Estimate(*state['estimate'])
        self._estimate_ns = state['estimate_ns']
        self._health = dict(state['health'])

    def health(self) -> dict[str, int]:
        """Return counters: refused, missing and unused samples."""
        return dict(self._health)

    def _accept_readings(self, reading: TimeSamples) -> None:
        kept = in_order(reading.stamp_ns, self._last_reading_ns)
        stamps = reading.stamp_ns[kept]
        self._health['readings_out_of_order'] += len(kept) - len(stamps)
        if not len(stamps):
            return
        if self._estimate_ns == BEFORE_ALL:
            self._estimate_ns = int(stamps[0])
        self._last_reading_ns = int(stamps[-1])
        self._stamp = np.concatenate((self._stamp, stamps))
        self._reference = np.concatenate((self._reference, reading.time_ref_ns[kept]))

    def _accept_observations(self, observation: TimeSamples) -> None:
        stamps: list[int] = observation.stamp_ns.tolist()
        references: list[int] = observation.time_ref_ns.tolist()
        for stamp, reference in zip(stamps, references, strict=True):
            if stamp <= self._last_observation_ns:
                self._health['observations_out_of_order'] += 1
            elif self._scheduled(stamp):
                self._pending.append((stamp, reference))
                self._last_observation_ns = stamp

    def _scheduled(self, stamp: int) -> bool:
        if self._schedule is None:
            return True
        place = int(np.searchsorted(self._schedule, stamp))
        if place == len(self._schedule) or self._schedule[place] != stamp:
            self._health['observations_unscheduled'] += 1
            return False
        expected = int(np.searchsorted(self._schedule, self._last_observation_ns, 'right'))
        self._health['observations_missing'] += place - expected
        return True

    def _next_scheduled_ns(self) -> int:
        if self._schedule is None:
            return AFTER_ALL
        place = int(np.searchsorted(self._schedule, self._last_observation_ns, 'right'))
        return int(self._schedule[place]) if place < len(self._schedule) else AFTER_ALL

    def _release(self, before_ns: int) -> Batches:
        """Use the observations and say the readings with stamp < before_ns."""
        ready = int(np.searchsorted(self._stamp, before_ns))
        if not ready:
            return {}
        since, known = self._use_observations(self._stamp[:ready])
        stamps = self._stamp[self._released : ready]
        references = self._reference[self._released : ready]
        remembered = 1 if self._schedule is not None else HISTORY
        forgotten = max(ready - remembered, 0)
        self._stamp, self._reference = self._stamp[forgotten:], self._reference[forgotten:]
        self._released = ready - forgotten
        return _estimates(stamps, references, since, known, self._model) if len(stamps) else {}

    def _use_observations(self, ready: IntArray) -> tuple[IntArray, Estimate[FloatArray]]:
        """Update with the observations that `ready` reaches.

        Returns the stamps of the states known from the last one before on, and these states.
        """
        oldest, newest = int(ready[0]), int(ready[-1])
        since, phases = [self._estimate_ns], []
        reached = sum(stamp <= newest for stamp, _ in self._pending)
        for stamp, observed in self._pending[:reached]:
            if stamp < oldest:
                self._health['observations_too_old'] += 1
                continue
            since.append(stamp)
            phases.append((self._reading_error(stamp) - (observed - stamp)) / NS_PER_S)
        self._pending = self._pending[reached:]
        elapsed = [(late - early) / NS_PER_S for early, late in pairwise(since)]
        known = filter_phases(self._estimate, elapsed, phases, self._model)
        self._estimate = Estimate(*(float(column[-1]) for column in known))
        self._estimate_ns = since[-1]
        return np.array(since, np.int64), known

    def _reading_error(self, stamp: int) -> float:
        """Return reading minus true time [ns] at a stamp within the known readings."""
        after = int(np.searchsorted(self._stamp, stamp))
        right, right_error = self._error_at(after)
        if right == stamp:
            return float(right_error)
        left, left_error = self._error_at(after - 1)
        return left_error + (right_error - left_error) * (stamp - left) / (right - left)

    def _error_at(self, index: int) -> tuple[int, int]:
        stamp = int(self._stamp[index])
        return stamp, int(self._reference[index]) - stamp


def _estimates(
    stamps: IntArray,
    references: IntArray,
    since: IntArray,
    known: Estimate[FloatArray],
    model: ClockModel,
) -> Batches:
    """Return estimate and corrected time of readings, each from the last state known at it.

    Every reading is predicted from that state in one step: the result does not depend on the
    log interval.
    """
    place = np.searchsorted(since[1:], stamps, 'right')
    elapsed = (stamps - since[place]) / NS_PER_S
    now = predict(Estimate(*(column[place] for column in known)), elapsed, model)
    values = np.column_stack(
        (now.x, np.sqrt(now.xx), now.y * SECONDS_PER_DAY, np.sqrt(now.yy) * SECONDS_PER_DAY)
    )
    corrected = references - np.rint(now.x * NS_PER_S).astype(np.int64)
    return {
        ESTIMATE: scalars(stamps, ESTIMATE_NAMES, values),
        CORRECTED: TimeSamples(stamps, '', corrected, same('corrected', len(stamps))),
    }
