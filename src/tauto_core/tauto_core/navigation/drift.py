"""The drift stage: readings and observations in, estimate and corrected time out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import ClassVar, cast

import numpy as np

from tauto_core.clockwork.dial_setting import DialSetting
from tauto_core.navigation.filtering import REFUSED, REOPENED, Filtered, Known, filter_phases
from tauto_core.navigation.kalman import (
    RANDOM_WALK_FM_FLOOR_PER_S,
    WHITE_FM_FLOOR_S,
    ClockModel,
    Estimate,
    predict,
    prior,
    reopen,
)
from tauto_core.navigation.ordering import AFTER_ALL, BEFORE_ALL, in_order
from tauto_core.navigation.phases import observed_phases
from tauto_core.navigation.track import Track
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
    join,
    same,
    scalars,
    take,
)
from tauto_core.scene import Scene
from tauto_core.ship.observations import schedule
from tauto_core.wording import counted

ESTIMATE_NAMES = ('offset_s', 'offset_sigma_s', 'rate_s_per_day', 'rate_sigma_s_per_day')
HISTORY = 4096
"""Readings remembered, beyond those held back, for observations that come late."""

AHEAD_NS = 86_400 * NS_PER_S
"""An observation stamped later than this after the newest reading is of another clock."""

MOST_NS = 4e18
"""Beyond the times of ROS, within int64."""

PATIENCE = 3.0
"""Observation intervals for which the filter trusts itself rather than an outlier."""


def clock_model(scene: Scene) -> ClockModel:
    """Return what `drift` says of the clock, with its noise or that of a good clock (the floors).

    Outliers are refused for three observation intervals: after that, as at a landfall, the
    clock is likelier to have changed than the observer to be wrong.
    """
    drift, clock = scene.drift, scene.clock
    return ClockModel(
        observation_sigma_s=drift.observation_sigma,
        prior_rate_sigma=drift.prior_rate_sigma / SECONDS_PER_DAY,
        states=drift.states,
        white_fm_s=max(WHITE_FM_FLOOR_S, clock.white_fm_s),
        random_walk_fm_per_s=max(RANDOM_WALK_FM_FLOOR_PER_S, clock.random_walk_fm_per_s),
        gate=drift.gate,
        patience_s=PATIENCE * drift.observation_interval,
        **({} if drift.lunars is None else {'lunar_sigma_s': drift.lunars.sigma}),
    )


class DriftStage:
    """Estimates offset and rate of the dial and takes the offset from its readings.

    One `drift/estimate` and one `clock/corrected` go out for each `clock/reading`, at its stamp.
    The dial is taken as set right, within `kalman.SETTING_SIGMAS`, at the first reading, and
    anew where a reading says that it was set since (`DialSetting`). Where one says that the dial
    has stood still, the offset moves by that much, and the state is reopened on it. An
    observation is compared with the reading at its stamp, or with the line between the readings
    on both sides. Outliers are refused (`filtering`) and counted, and so is each time that the
    state was reopened.

    Args:
        scene: gives the observations' sigma and schedule and the prior.
        expect_schedule: an estimate at t uses every observation with stamp <= t, whatever the
            order of arrival between the topics: readings at and after the next scheduled
            observation wait until it, or a later one, has come, or until `finish`. False: an
            observation counts for the readings that go out after it came. It may be late by
            `HISTORY` readings, and by `track.REMEMBERED` later observations, which the filter
            then goes over again in the order of the stamps.
    """

    inputs: ClassVar[tuple[str, ...]] = (READING, OBSERVATION)
    outputs: ClassVar[tuple[str, ...]] = (ESTIMATE, CORRECTED)

    def __init__(self, scene: Scene, expect_schedule: bool = True) -> None:
        self._model = clock_model(scene)
        self._schedule = schedule(scene) if expect_schedule else None
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

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Take readings and observations; return what can be said now."""
        runs = list(_settings(batches.get(READING)))
        if runs and not self._is_set_otherwise(runs[0]):
            self._accept_readings(runs.pop(0))
        if OBSERVATION in batches:
            self._accept_observations(cast(TimeSamples, batches[OBSERVATION]))
        said: list[Batches] = []
        for reading in runs:
            said.append(self._release(AFTER_ALL))
            self._begin_again(reading)
            self._accept_readings(reading)
        said.append(self._release(self._next_scheduled_ns()))
        return merged(said)

    def _is_set_otherwise(self, reading: TimeSamples) -> bool:
        """Tell whether readings come from a dial set, or stopped, since the last one."""
        setting = DialSetting.of(str(reading.source[0]))
        return setting is not None and setting != self._setting

    def _begin_again(self, reading: TimeSamples) -> None:
        """Forget the readings before; go on from the estimate as far as it still holds."""
        before, setting = self._setting, DialSetting.of(str(reading.source[0]))
        self._setting = setting or before
        if before is None or setting is None or self._track is None:
            return
        self._stamp = self._reference = np.empty(0, np.int64)
        self._released = 0
        if not setting.is_same_as(before):
            self._health['dial_settings'] += 1
            self._last_reading_ns = self._last_observation_ns = BEFORE_ALL
            self._pending, self._track = {}, None
            return
        self._health['dial_stops'] += 1
        lost_s = (setting.lost_ns - before.lost_ns) / NS_PER_S
        last, at_ns = self._track.last, int(reading.stamp_ns[0])
        now = predict(last.estimate, max(at_ns - last.stamp_ns, 0) / NS_PER_S, self._model)
        opened = reopen(now._replace(x=now.x - lost_s), lost_s, math.inf)
        self._track = Track(Known(at_ns, opened), self._model)

    def finish(self) -> Batches:
        """Release the readings that wait; count the observations that did not come."""
        last = self._last_observation_ns
        said = self._release(AFTER_ALL)
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
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
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

    def health(self) -> dict[str, int]:
        """Return counters: refused, missing, unused and delayed samples, states reopened."""
        track = self._track
        return {
            **self._health,
            'observations_gated': track.count(REFUSED) if track else 0,
            'estimates_reopened': track.count(REOPENED) if track else 0,
        }

    def _accept_readings(self, reading: TimeSamples) -> None:
        kept = in_order(reading.stamp_ns, self._last_reading_ns)
        stamps = reading.stamp_ns[kept]
        self._health['readings_out_of_order'] += len(kept) - len(stamps)
        if not len(stamps):
            return
        if self._track is None:
            self._track = Track(Known(int(stamps[0]), prior(self._model)), self._model)
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
        """Tell whether an observation is the next of the schedule, or one after it; count."""
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
        """Tell whether an observation can be of this clock and is not a repetition; count."""
        if self._track is not None and stamp > self._last_reading_ns + AHEAD_NS:
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

    def _release(self, before_ns: int) -> Batches:
        """Use the observations and say the readings with stamp < before_ns."""
        ready = int(np.searchsorted(self._stamp, before_ns))
        if not ready:
            return {}
        way = self._use_observations(self._stamp[:ready])
        stamps = self._stamp[self._released : ready]
        references = self._reference[self._released : ready]
        remembered = 1 if self._schedule is not None else HISTORY
        forgotten = max(ready - remembered, 0)
        self._stamp, self._reference = self._stamp[forgotten:], self._reference[forgotten:]
        self._released = ready - forgotten
        return _estimates(stamps, references, way, self._model) if len(stamps) else {}

    def _use_observations(self, ready: IntArray) -> Filtered:
        """Update with the observations that `ready` reaches; return the filter's way to there."""
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
        return self._track.use(stamps, phases.tolist(), sigmas)


def _settings(reading: Samples | None) -> Iterator[TimeSamples]:
    """Yield runs of readings that say the same of their dial."""
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


def _estimates(
    stamps: IntArray, references: IntArray, way: Filtered, model: ClockModel
) -> Batches:
    """Return estimate and corrected time of readings, each from the last state known at it.

    Every reading is predicted from that state in one step: the result does not depend on the
    log interval.
    """
    place = np.searchsorted(way.stamp_ns[1:], stamps, 'right')
    elapsed = (stamps - way.stamp_ns[place]) / NS_PER_S
    now = predict(Estimate(*(column[place] for column in way.states)), elapsed, model)
    # absurd observations can lead beyond int64; no message holds what is cut to this
    error_ns = np.nan_to_num(np.clip(now.x * NS_PER_S, -MOST_NS, MOST_NS), nan=MOST_NS)
    corrected = references - np.rint(error_ns).astype(np.int64)
    return {
        ESTIMATE: scalars(stamps, ESTIMATE_NAMES, estimate_values(now)),
        CORRECTED: TimeSamples(stamps, '', corrected, same('corrected', len(stamps))),
    }


def estimate_values(now: Estimate[FloatArray]) -> FloatArray:
    """Return the values of `ESTIMATE_NAMES`, (n, 4)."""
    return np.column_stack(
        (now.x, np.sqrt(now.xx), now.y * SECONDS_PER_DAY, np.sqrt(now.yy) * SECONDS_PER_DAY)
    )


_SAID = {
    'readings_out_of_order': '{readings} {were} out of order and left out',
    'observations_out_of_order': '{observations} came after later ones and {were} left out',
    'observations_repeated': '{observations} had the stamp of another and {were} left out',
    'observations_delayed': '{observations} came after later ones; the filter went back for '
    '{them}',
    'observations_from_future': '{observations} {were} stamped a day or more after the newest '
    'reading and left out: check whose clock stamped {them}',
    'observations_unscheduled': '{observations} {were} not at the times of the scene and left out',
    'observations_missing': '{observations} of the scene did not come',
    'observations_too_old': '{observations} {were} older than what is remembered and left out',
    'observations_unmatched': '{observations} {were} stamped after the last reading and left out',
    'observations_gated': '{observations} {were} refused as {outliers}, beyond drift.gate = '
    '{gate:g} sigmas',
    'dial_stops': 'the dial had stood still {times}; the offset was moved and reopened by that',
    'dial_settings': 'the dial was set anew {times}; the estimate began again',
    'estimates_reopened': '{observations} beyond drift.gate = {gate:g} sigmas had to be believed: '
    'the clock has jumped, or its rate is not what was assumed (drift.prior_rate_sigma = '
    '{prior:g} s/day)',
}


def drift_warnings(health: Mapping[str, int], scene: Scene) -> list[str]:
    """Return in words what the drift stage counted.

    Args:
        health: its counters; those of other stages are passed over.
        scene: that it ran with.
    """
    values = {'gate': scene.drift.gate, 'prior': scene.drift.prior_rate_sigma}
    return [
        f'drift: {words.format(**values, **_agreeing(health[name]))}'
        for name, words in _SAID.items()
        if health.get(name)
    ]


def _agreeing(number: int) -> dict[str, str]:
    """Return the words that depend on how many there are."""
    return {
        'observations': counted(number, 'observation'),
        'readings': counted(number, 'reading'),
        'were': 'was' if number == 1 else 'were',
        'them': 'it' if number == 1 else 'them',
        'outliers': 'an outlier' if number == 1 else 'outliers',
        'times': 'once' if number == 1 else f'{number} times',
    }
