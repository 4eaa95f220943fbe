"""The drift stage: readings and observations in, estimate and corrected time out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from operator import sub
from typing import ClassVar, cast

import numpy as np

from tauto_core.clockwork.dial_setting import DialSetting
from tauto_core.navigation.assumptions import clock_model
from tauto_core.navigation.estimates import Passed, estimates
from tauto_core.navigation.filtering import REFUSED, REOPENED, Filtered, Known, filter_phases
from tauto_core.navigation.kalman import predict, prior, reopen
from tauto_core.navigation.ordering import AFTER_ALL, BEFORE_ALL, in_order
from tauto_core.navigation.phases import observed_phases, on_line
from tauto_core.navigation.regressors import HELD_S, Motion, Regressors
from tauto_core.navigation.track import Track
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    NS_PER_S,
    OBSERVATION,
    READING,
    Batches,
    FloatArray,
    IntArray,
    Samples,
    State,
    TimeSamples,
    join,
    take,
)
from tauto_core.scene import Scene
from tauto_core.ship.observations import schedule

HELD_NS = round(HELD_S * NS_PER_S)

HISTORY = 4096
"""Number of readings kept, beyond those held back, for observations that come late."""

AHEAD_NS = 86_400 * NS_PER_S
"""An observation stamped later than this after the newest reading belongs to another clock."""


class DriftStage:
    """Estimates offset and rate of the dial, and subtracts the offset from its readings.

    For each `clock/reading` one `drift/estimate` and one `clock/corrected` are published with its
    stamp. The dial is assumed to be set right, within `kalman.SETTING_SIGMAS`, at the first
    reading, and again at each reading that reports a new setting (`DialSetting`). Where a reading
    reports that the dial has stood still, the offset changes by that time, and its variance grows
    accordingly. An observation is compared with the reading at its stamp, or with the line between
    the readings on both sides. Outliers (`filtering`) are refused and counted, and so is each
    reopening of the state.

    With covariates `ship/imu` is an input too, and readings wait until the motion has reached
    them. In a live graph they wait at most until readings `HELD_S` later have come. The motion is
    then assumed to have continued as usual, and that is counted.

    Args:
        scene: gives the observations' sigma and schedule and the prior.
        expect_schedule: True: an estimate at t uses every observation with stamp <= t, whatever
            the order of arrival between the topics. Readings at and after the next scheduled
            observation wait until it, or a later one, has come, or until `finish`. False: an
            observation affects the readings that are published after it came. It may be late by
            `HISTORY` readings, and by `track.REMEMBERED` later observations, for which the filter
            is then repeated in the order of the stamps.
        motion: a source of the integrals of the covariates that replaces `ship/imu`.
    """

    outputs: ClassVar[tuple[str, ...]] = (ESTIMATE, CORRECTED)

    def __init__(
        self, scene: Scene, expect_schedule: bool = True, motion: Motion | None = None
    ) -> None:
        self._model = clock_model(scene)
        self._schedule = schedule(scene) if expect_schedule else None
        self._motion = motion
        if motion is None and self._model.coefficients:
            self._motion = Regressors(scene, live=not expect_schedule)
        self._integral = np.empty((0, len(self._model.coefficients)))
        self._begun: tuple[int, tuple[float, ...]] | None = None
        none = np.empty(0, np.int64)
        self._stamp, self._reference = none, none
        self._released = 0
        self._pending: dict[int, tuple[int, float]] = {}
        self._last_reading_ns = BEFORE_ALL
        self._last_observation_ns = BEFORE_ALL
        self._track: Track | None = None
        self._setting: DialSetting | None = None
        self._health = {
            'readings_out_of_order': 0,
            'observations_out_of_order': 0,
            'observations_repeated': 0,
            'observations_delayed': 0,
            'observations_from_future': 0,
            'observations_unscheduled': 0,
            'observations_missing': 0,
            'observations_too_old': 0,
            'observations_unmatched': 0,
            'dial_stops': 0,
            'dial_settings': 0,
        }

    @property
    def inputs(self) -> tuple[str, ...]:
        """Topics of the dial, of the observations, and of the motion if it is used."""
        return (READING, OBSERVATION, *(self._motion.inputs if self._motion else ()))

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Take readings, observations and motion; return what can be published now."""
        if self._motion is not None:
            self._motion.feed(batches)
        runs = list(_settings(batches.get(READING)))
        if runs and not self._is_set_otherwise(runs[0]):
            self._accept_readings(runs.pop(0))
        if OBSERVATION in batches:
            self._accept_observations(cast(TimeSamples, batches[OBSERVATION]))
        said: list[Batches] = []
        for reading in runs:
            said.append(self._release(AFTER_ALL, final=True))
            self._begin_again(reading)
            self._accept_readings(reading)
        said.append(self._release(self._next_scheduled_ns()))
        return merged(said)

    def _is_set_otherwise(self, reading: TimeSamples) -> bool:
        """Return whether readings come from a dial that was set or stopped since the last one."""
        setting = DialSetting.of(str(reading.source[0]))
        return setting is not None and setting != self._setting

    def _begin_again(self, reading: TimeSamples) -> None:
        """Forget the earlier readings; continue from the estimate as far as it is still valid."""
        before, setting = self._setting, DialSetting.of(str(reading.source[0]))
        self._setting = setting or before
        if before is None or setting is None or self._track is None:
            return
        self._stamp = self._reference = np.empty(0, np.int64)
        self._integral = self._integral[:0]
        self._released = 0
        if not setting.is_same_as(before):
            self._health['dial_settings'] += 1
            self._last_reading_ns = self._last_observation_ns = BEFORE_ALL
            self._pending, self._track = {}, None
            return
        self._health['dial_stops'] += 1
        lost_s = (setting.lost_ns - before.lost_ns) / NS_PER_S
        last, at_ns = self._track.last, int(reading.stamp_ns[0])
        reached = self._integrals_at(reading.stamp_ns[:1])
        gained = tuple(map(sub, reached, last.integrals_s))
        elapsed_s = max(at_ns - last.stamp_ns, 0) / NS_PER_S
        now = predict(last.estimate, elapsed_s, self._model, gained)
        opened = reopen(now._replace(x=now.x - lost_s), lost_s, math.inf)
        self._track = Track(Known(at_ns, opened, integrals_s=reached), self._model)

    def finish(self) -> Batches:
        """Release the readings that wait; count the observations that did not come."""
        last = self._last_observation_ns
        said = self._release(AFTER_ALL, final=True)
        if self._schedule is not None:
            due = (self._schedule > last) & (self._schedule <= self._last_reading_ns)
            self._health['observations_missing'] += int(np.count_nonzero(due))
        self._health['observations_unmatched'] += len(self._pending)
        self._pending = {}
        return said

    def state(self) -> State:
        """Return readings, observations and estimate."""
        return {
            'stamp': self._stamp,
            'reference': self._reference,
            'released': self._released,
            'pending': list(self._pending.items()),
            'last_reading_ns': self._last_reading_ns,
            'last_observation_ns': self._last_observation_ns,
            'track': None if self._track is None else self._track.state(),
            'setting': None if self._setting is None else self._setting.source(),
            'health': dict(self._health),
            **self._state_of_motion(),
        }

    def _state_of_motion(self) -> State:
        if self._motion is None:
            return {}
        return {
            'integral': self._integral,
            'begun': self._begun,
            'motion': self._motion.state(),
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._stamp = state['stamp']
        self._reference = state['reference']
        self._released = state['released']
        self._pending = dict(state['pending'])
        self._last_reading_ns = state['last_reading_ns']
        self._last_observation_ns = state['last_observation_ns']
        self._track = None
        if state['track'] is not None:
            self._track = Track(Known(0, prior(self._model)), self._model)
            self._track.restore(state['track'])
        self._setting = None if state['setting'] is None else DialSetting.of(state['setting'])
        self._health = dict(state['health'])
        if self._motion is not None:
            self._integral, self._begun = state['integral'], state['begun']
            self._motion.restore(state['motion'])

    def health(self) -> dict[str, int]:
        """Return counters: refused, missing, unused and delayed samples, states reopened."""
        track = self._track
        return {
            **self._health,
            'observations_gated': track.count(REFUSED) if track else 0,
            'estimates_reopened': track.count(REOPENED) if track else 0,
            **(self._motion.health() if self._motion else {}),
        }

    def _accept_readings(self, reading: TimeSamples) -> None:
        kept = in_order(reading.stamp_ns, self._last_reading_ns)
        stamps = reading.stamp_ns[kept]
        self._health['readings_out_of_order'] += len(kept) - len(stamps)
        if not len(stamps):
            return
        self._last_reading_ns = int(stamps[-1])
        self._stamp = np.concatenate((self._stamp, stamps))
        self._reference = np.concatenate((self._reference, reading.time_ref_ns[kept]))

    def _accept_observations(self, observation: TimeSamples) -> None:
        stamps: list[int] = observation.stamp_ns.tolist()
        references: list[int] = observation.time_ref_ns.tolist()
        sigmas = [self._model.sigma_of(source) for source in observation.source.tolist()]
        accepts = self._is_foreign_new if self._schedule is None else self._is_due
        for stamp, reference, sigma in zip(stamps, references, sigmas, strict=True):
            if accepts(stamp):
                self._pending[stamp] = reference, sigma
                self._last_observation_ns = max(stamp, self._last_observation_ns)

    def _is_due(self, stamp: int) -> bool:
        """Return whether an observation is the next scheduled or a later one; count the others."""
        assert self._schedule is not None
        if stamp <= self._last_observation_ns:
            self._health['observations_out_of_order'] += 1
            return False
        place = int(np.searchsorted(self._schedule, stamp))
        if place == len(self._schedule) or self._schedule[place] != stamp:
            self._health['observations_unscheduled'] += 1
            return False
        expected = int(np.searchsorted(self._schedule, self._last_observation_ns, 'right'))
        self._health['observations_missing'] += place - expected
        return True

    def _is_foreign_new(self, stamp: int) -> bool:
        """Return whether an observation may be this clock's and is new; count the others."""
        if BEFORE_ALL < self._last_reading_ns < stamp - AHEAD_NS:
            self._health['observations_from_future'] += 1
            return False
        if stamp > self._last_observation_ns:
            return True
        if stamp in self._pending or (self._track is not None and self._track.has(stamp)):
            self._health['observations_repeated'] += 1
            return False
        self._health['observations_delayed'] += 1
        return True

    def _next_scheduled_ns(self) -> int:
        if self._schedule is None:
            return AFTER_ALL
        place = int(np.searchsorted(self._schedule, self._last_observation_ns, 'right'))
        return int(self._schedule[place]) if place < len(self._schedule) else AFTER_ALL

    def _release(self, before_ns: int, *, final: bool = False) -> Batches:
        """Use the observations, and publish the readings with stamp < before_ns.

        Args:
            before_ns: readings from this stamp on are held back for an observation.
            final: whether readings no longer wait for the motion either.
        """
        if self._motion is not None and not final:
            before_ns = min(before_ns, self._moved_ns(self._motion))
        ready = max(int(np.searchsorted(self._stamp, before_ns)), self._released)
        if not ready:
            return {}
        if self._motion is not None:
            new = self._motion.at(self._stamp[len(self._integral) : ready])
            self._integral = np.concatenate((self._integral, new))
        if self._track is None:
            self._begin()
        way = self._use_observations(self._stamp[:ready])
        stamps = self._stamp[self._released : ready]
        references = self._reference[self._released : ready]
        passed = self._passed(stamps, self._integral[self._released : ready])
        remembered = 1 if self._schedule is not None else HISTORY
        forgotten = max(ready - remembered, 0)
        self._stamp, self._reference = self._stamp[forgotten:], self._reference[forgotten:]
        self._integral = self._integral[forgotten:]
        self._released = ready - forgotten
        return estimates(stamps, references, way, self._model, passed) if len(stamps) else {}

    def _moved_ns(self, motion: Motion) -> int:
        """Return the stamp before which readings need not wait for the motion any longer."""
        reached_ns = motion.reached_ns
        if self._schedule is None:
            reached_ns = max(reached_ns, self._last_reading_ns - HELD_NS)
        return reached_ns + 1

    def _begin(self) -> None:
        """Set the dial at the first reading."""
        first = int(self._stamp[0])
        reached = tuple(self._integral[0].tolist()) if self._motion is not None else ()
        self._begun = first, reached
        known = Known(first, prior(self._model), integrals_s=reached)
        self._track = Track(known, self._model)

    def _passed(self, stamps: IntArray, integrals: FloatArray) -> Passed | None:
        """Return time and integrals of readings since the first one, if there are covariates."""
        if self._motion is None or self._begun is None:
            return None
        first, begun = self._begun
        elapsed_s = (stamps - first) / NS_PER_S
        return Passed(elapsed_s, integrals, integrals - np.array(begun))

    def _use_observations(self, ready: IntArray) -> Filtered:
        """Update with the observations up to the last of `ready`; return the run of the filter."""
        assert self._track is not None
        newest, oldest = int(ready[-1]), max(int(ready[0]), self._track.oldest_ns)
        reached = sorted(stamp for stamp in self._pending if stamp <= newest)
        stamps = [stamp for stamp in reached if stamp >= oldest]
        self._health['observations_too_old'] += len(reached) - len(stamps)
        observed = {stamp: self._pending.pop(stamp) for stamp in reached}
        if not stamps:
            return filter_phases(self._track.last, [], [], self._model)
        at = np.array(stamps, np.int64)
        true = np.array([observed[stamp][0] for stamp in stamps], np.int64)
        phases = observed_phases(self._stamp, self._reference, at, true)
        sigmas = [observed[stamp][1] for stamp in stamps]
        if self._motion is None:
            return self._track.use(stamps, phases.tolist(), sigmas)
        known = self._stamp[: len(self._integral)]
        reached = on_line(known, self._integral, at).tolist()
        return self._track.use(stamps, phases.tolist(), sigmas, list(map(tuple, reached)))

    def _integrals_at(self, stamp_ns: IntArray) -> tuple[float, ...]:
        """Return the integrals at one stamp [s]."""
        return tuple(self._motion.at(stamp_ns)[0].tolist()) if self._motion is not None else ()


def _settings(reading: Samples | None) -> Iterator[TimeSamples]:
    """Yield runs of readings that describe the same setting of their dial."""
    if not isinstance(reading, TimeSamples) or not len(reading.stamp_ns):
        return
    source = reading.source
    changes = (np.flatnonzero(source[1:] != source[:-1]) + 1).tolist()
    for first, last in pairwise([0, *changes, len(source)]):
        yield take(reading, slice(first, last))


def merged(said: list[Batches]) -> Batches:
    """Return batches of the same topics, in order, as one."""
    topics = dict.fromkeys(topic for batches in said for topic in batches)
    return {
        topic: join([cast(TimeSamples, batches[topic]) for batches in said if topic in batches])
        for topic in topics
    }
