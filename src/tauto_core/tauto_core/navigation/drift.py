"""The drift stage: readings and observations in, estimate and corrected time out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from operator import sub
from typing import Any, ClassVar, NamedTuple, TypeAlias, cast

import numpy as np

from tauto_core.clockwork.trochlea import DialSetting, nominal_period_s
from tauto_core.machines import compile_machine
from tauto_core.navigation.covariates import clock_model
from tauto_core.navigation.kalman import (
    REFUSED,
    REOPENED,
    SOURCES,
    ClockModel,
    Estimate,
    Filtered,
    Known,
    covariances,
    estimate_of,
    filter_phases,
    pairs,
    predict,
    prior,
    same_fields,
)
from tauto_core.navigation.longitude import AFTER_ALL, BEFORE_ALL, LiveFixes, in_order
from tauto_core.navigation.regressors import HELD_NS, MotionRegressors, integral_names, regressors
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    OBSERVATION,
    READING,
    Batches,
    FloatArray,
    IntArray,
    Samples,
    State,
    Stateful,
    TimeSamples,
    merged,
    same,
    scalars,
    take,
)
from tauto_core.scene import Scene
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.ship.source import schedule
from tauto_core.wording import counted

# -----------------------------------------------------------------------------
# The clock's error at the instants of the observations, between the readings.


def observed_phases(
    stamp_ns: IntArray, reference_ns: IntArray, at_ns: IntArray, observed_ns: IntArray
) -> FloatArray:
    """Return reading minus observed true time at each observation within the readings [s], (n,).

    The error is linear between two readings. Observations do not affect each other.
    """
    error = on_line(stamp_ns, (reference_ns - stamp_ns)[:, None], at_ns)[:, 0]
    return np.asarray((error - (observed_ns - at_ns)) / NS_PER_S, np.float64)


def on_line(stamp_ns: IntArray, values: FloatArray | IntArray, at_ns: IntArray) -> FloatArray:
    """Return values (m, c) by linear interpolation at instants within the readings, (n, c).

    Integers below 2^53 are exact.
    """
    upper = np.searchsorted(stamp_ns, at_ns)
    lower = np.maximum(upper - 1, 0)
    span = np.maximum(stamp_ns[upper] - stamp_ns[lower], 1)
    part = ((at_ns - stamp_ns[lower]) / span)[:, None]
    between = values[lower] + (values[upper] - values[lower]) * part
    result: FloatArray = np.where((stamp_ns[upper] == at_ns)[:, None], values[upper], between)
    return result


# -----------------------------------------------------------------------------
# The contents of `drift/estimate` and `clock/corrected`.

ESTIMATE_NAMES = ('offset_s', 'offset_sigma_s', 'rate_s_per_day', 'rate_sigma_s_per_day')
"""Names in every estimate. With covariates others follow (`estimate_names`)."""

MEAN_RATE_NAMES = ('mean_rate_s_per_day', 'mean_rate_sigma_s_per_day')

MOST_NS = 4e18
"""More than the times of ROS, and within int64 [ns]."""


class Elapsed(NamedTuple):
    """Time and integrals since the first reading.

    Attributes:
        elapsed_s: time since the first reading [s], (n,).
        integrals_s: integrals of the covariates [s], (n, c).
        gained_s: their growth since the first reading [s], (n, c).
    """

    elapsed_s: FloatArray
    integrals_s: FloatArray
    gained_s: FloatArray


def estimate_names(covariates: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the values of an estimate with these covariates."""
    if not covariates:
        return ESTIMATE_NAMES
    learned = [f'{name}_coefficient{part}' for name in covariates for part in ('', '_sigma')]
    return (*ESTIMATE_NAMES, *MEAN_RATE_NAMES, *learned, *integral_names(covariates))


def _sigma(variance: FloatArray) -> FloatArray:
    """Return the sigma of a variance, infinite if rounding of absurd stamps made it negative."""
    return np.sqrt(np.where(variance < 0.0, np.inf, variance))


def estimate_values(
    now: Estimate[FloatArray], covariates: tuple[str, ...], passed: Elapsed | None = None
) -> FloatArray:
    """Return the values of `estimate_names`, (n, names). Covariates need `passed`."""
    clock = [now.x, _sigma(now.xx), now.y * DAY_S, _sigma(now.yy) * DAY_S]
    if passed is None:
        return np.column_stack(clock)
    state, names = now._asdict(), ('y', *covariates)
    learned = [
        column for name in covariates for column in (state[name], _sigma(state[f'{name}_{name}']))
    ]
    # the mean rate y + Σ k_j ⟨x_j⟩ since the first reading, and its sigma
    elapsed = np.where(passed.elapsed_s > 0.0, passed.elapsed_s, np.inf)
    weights = [np.ones(len(elapsed)), *(column / elapsed for column in passed.gained_s.T)]
    rate = sum(weight * state[name] for weight, name in zip(weights, names, strict=True))
    variance = np.zeros(len(elapsed))
    for (i, j), field in zip(pairs(len(names)), covariances(names), strict=True):
        variance = variance + (1.0 if i == j else 2.0) * weights[i] * weights[j] * state[field]
    sigma = np.sqrt(np.maximum(variance, 0.0))
    mean = rate * DAY_S, sigma * DAY_S
    return np.column_stack((*clock, *mean, *learned, passed.integrals_s))


def has_mean_rate(found: Mapping[str, float]) -> bool:
    """Return whether an estimate has the mean rate of the voyage, due to covariates."""
    return MEAN_RATE_NAMES[0] in found


def mean_rate(found: Mapping[str, float]) -> tuple[float, float]:
    """Return the rate of an estimate and its sigma [s/day], with covariates the voyage's mean."""
    rate, sigma = MEAN_RATE_NAMES if has_mean_rate(found) else ESTIMATE_NAMES[2:]
    return found[rate], found[sigma]


def estimates(
    stamps: IntArray,
    references: IntArray,
    way: Filtered,
    model: ClockModel,
    passed: Elapsed | None,
) -> Batches:
    """Return estimate and corrected time for readings, each from the last state at its stamp.

    Every reading is predicted from this state in one step: the result does not depend on the log
    interval.
    """
    place = np.searchsorted(way.stamp_ns[1:], stamps, 'right')
    elapsed = (stamps - way.stamp_ns[place]) / NS_PER_S
    gained = () if passed is None else tuple((passed.integrals_s - way.integrals_s[place]).T)
    then = same_fields(way.states, (column[place] for column in way.states))
    sailed_ns = np.maximum(way.stamp_ns[place], model.sails_ns)
    under_way_s = np.maximum(stamps - sailed_ns, 0) / NS_PER_S
    now = predict(then, elapsed, model, gained, under_way_s)
    # absurd observations could exceed int64
    error_ns = np.nan_to_num(np.clip(now.x * NS_PER_S, -MOST_NS, MOST_NS), nan=MOST_NS)
    corrected = references - np.rint(error_ns).astype(np.int64)
    values = estimate_values(now, model.names, passed)
    return {
        ESTIMATE: scalars(stamps, estimate_names(model.names), values),
        CORRECTED: TimeSamples(stamps, '', corrected, same('corrected', len(stamps))),
    }


# -----------------------------------------------------------------------------
# The recent run of the filter, which is repeated when an observation comes late.

REMEMBERED = 64
"""Least number of recent observations that the filter can repeat."""

Observed: TypeAlias = tuple[int, float, float, tuple[float, ...]]
"""Stamp [ns], phase and its sigma [s], and integrals of the covariates [s]."""


class Track(Stateful):
    """Takes observations in any order, and gives the state as if they had come in order.

    It begins with the state when the dial was set, or after a stop, following the track `before`.

    Attributes:
        last: the state after all observations so far.
        oldest_ns: the earliest stamp of a further observation.
    """

    state_names = ('oldest_ns', 'counts', 'seen', 'fates')

    def __init__(self, start: Known, model: ClockModel, before: Track | None = None) -> None:
        self._model = model
        self._base = self.last = start
        self.oldest_ns = start.stamp_ns
        self._seen: list[Observed] = []
        self._fates: list[int] = []
        fates = (REFUSED, REOPENED)
        self._counts = {fate: before.count(fate) if before else 0 for fate in fates}

    def has(self, stamp_ns: int) -> bool:
        """Return whether an observation of this stamp is remembered."""
        return any(observed[0] == stamp_ns for observed in reversed(self._seen))

    def count(self, fate: int) -> int:
        """Return the number of observations that were REFUSED or REOPENED the state."""
        return self._counts[fate] + self._fates.count(fate)

    def use(
        self,
        stamp_ns: Sequence[int],
        phase_s: Sequence[float],
        sigma_s: Sequence[float] | None = None,
        integrals_s: Sequence[tuple[float, ...]] = (),
    ) -> Filtered:
        """Take observations of new stamps, none before `oldest_ns`, and return the repeated run.

        It begins at the last state before the first of them, or earlier. `filter_phases` explains
        the arguments.
        """
        if sigma_s is None:
            sigma_s = [self._model.observation_sigma_s] * len(stamp_ns)
        integrals_s = integrals_s or [()] * len(stamp_ns)
        new = sorted(zip(stamp_ns, phase_s, sigma_s, integrals_s, strict=True))
        start, kept = self.last, len(self._seen)
        if self._seen and new and new[0][0] < self._seen[-1][0]:
            start, kept, new = self._base, 0, sorted(new + self._seen)
        way = self._filtered(start, new)
        self.last = way.after(len(new))
        self._seen = self._seen[:kept] + new
        self._fates = self._fates[:kept] + way.fate.tolist()
        old = len(self._seen) - REMEMBERED
        if old >= REMEMBERED:  # move the base forward
            before = self._seen[:old]
            is_new = old >= kept
            run = way if is_new else self._filtered(self._base, before)
            self._base, self.oldest_ns = run.after(old - kept * is_new), before[-1][0] + 1
            self._counts = {
                fate: n + self._fates[:old].count(fate) for fate, n in self._counts.items()
            }
            self._seen, self._fates = self._seen[old:], self._fates[old:]
        return way

    def _filtered(self, start: Known, new: Sequence[Observed]) -> Filtered:
        stamps, phases, sigmas, integrals = zip(*new, strict=True) if new else ((), (), (), ())
        return filter_phases(start, stamps, phases, self._model, sigmas, integrals)

    def state(self) -> State:
        """Return everything that the next result depends on."""
        return {
            **super().state(),
            'base': _plain(self._base),
            'last': _plain(self.last),
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        super().restore(state)
        self._base, self.last = self._known(state['base']), self._known(state['last'])

    def _known(self, plain: tuple[Any, ...]) -> Known:
        stamp_ns, estimate, *fields = plain
        return Known(stamp_ns, estimate_of(self._model.names)(*estimate), *fields)


def _plain(state: Known) -> tuple[Any, ...]:
    stamp_ns, estimate, *fields = state
    return stamp_ns, tuple(estimate), *fields


# -----------------------------------------------------------------------------
# The counters of the drift stage as text.

_WARNINGS = {
    'readings_out_of_order': '{readings} {were} out of order and left out',
    'observations_out_of_order': '{observations} came after later ones and {were} left out',
    'observations_repeated': '{observations} had the stamp of another and {were} left out',
    'observations_delayed': '{observations} came after later ones, and the filter went back for '
    '{them}',
    'observations_from_future': '{observations} {were} stamped a day or more after the newest '
    'reading and left out: check whose clock stamped {them}',
    'observations_unscheduled': '{observations} {were} not at the times of the scene and left out',
    'observations_missing': '{observations} of the scene did not come',
    'observations_too_old': '{observations} {were} older than the remembered readings and left '
    'out',
    'observations_unknown': '{observations} named a source of time without a sigma and {were} '
    f'left out. Sources are {", ".join(SOURCES[1:])} (drift.observation_sigma, '
    'drift.lunars.sigma, drift.gnss_sigma)',
    'observations_years_off': '{observations} {were} ten years or more from the clock that '
    'stamped {them} and left out: the receiver has no fix yet, its firmware is of an earlier era '
    "of GPS, or the computer's clock is not set",
    'observations_unmatched': '{observations} {were} stamped after the last reading and left out',
    'observations_gated': '{observations} {were} refused as {outliers}, beyond drift.gate = '
    '{gate:g} sigmas',
    'motion_refused': '{samples} of ship/imu could not be used and {were} left out',
    'motion_gaps': 'ship/imu broke off {times}: the mean effect of the motion was assumed',
    'motion_unknown': 'ship/imu did not reach {readings}: the mean effect of the motion was '
    'assumed',
    'latitude_refused': '{samples} of ship/fix could not be used for gravity and {were} left out',
    'latitude_unknown': '{readings} had no place on ship/fix in the hour before: gravity was taken'
    ' as last known, at first as at the departure. Publish sensor_msgs/NavSatFix on ship/fix, or '
    'leave gravity out of drift.covariates',
    'temperature_refused': '{samples} of ship/temperature {were} not in degrees Celsius and left '
    'out',
    'temperature_unknown': '{readings} had no ship/temperature in the hour before: it was taken '
    'as last known, at first as at the start. Publish sensor_msgs/Temperature on '
    'ship/temperature, or leave it out of drift.covariates',
    'dial_stops': 'the dial had stood still {times}, and the offset was moved by the lost time',
    'dial_settings': 'the dial was set again {times}, and the estimate began again',
    'estimates_reopened': '{observations} beyond drift.gate = {gate:g} sigmas had to be believed: '
    'the clock has jumped, or its rate differs from the assumed one (drift.prior_rate_sigma = '
    '{prior:g} s/day)',
}


def drift_warnings(health: Mapping[str, int], scene: Scene) -> list[str]:
    """Return warnings for the counters of the drift stage. Other counters are ignored."""
    warnings = []
    for name, words in _WARNINGS.items():
        if number := health.get(name):
            is_single = number == 1
            text = words.format(
                gate=scene.drift.gate,
                prior=scene.drift.prior_rate_sigma,
                observations=counted(number, 'observation'),
                samples=counted(number, 'sample'),
                readings=counted(number, 'reading'),
                were='was' if is_single else 'were',
                them='it' if is_single else 'them',
                outliers='an outlier' if is_single else 'outliers',
                times='once' if is_single else f'{number} times',
            )
            warnings.append(f'drift: {text}')
    return warnings


HISTORY = 4096
"""Number of published readings that are kept for late observations."""

_COUNTED = (
    'readings_out_of_order', 'observations_out_of_order', 'observations_repeated',
    'observations_delayed', 'observations_from_future', 'observations_unscheduled',
    'observations_missing', 'observations_too_old', 'observations_unmatched',
    'observations_unknown', 'observations_years_off', 'dial_stops', 'dial_settings',
)  # fmt: skip

MOST_OFF_NS = round(3652.5 * DAY_S) * NS_PER_S
"""Distance of an observed time from its stamp that no clock has. A receiver without a fix gives a
time before GPS, and one of an earlier era is off by 1,024 weeks.
"""

RELEASE_SIGMA = 0.6
"""Sigma of the dial's change by a release until the wheel has settled, in swings. The root mean
square over six breaks of 5 to 22 s was 0.14 (measured), 0.55 (involute_weight_at_sea) and 0.56
(hanging_thread_at_sea).
"""

# An observation stamped more than this after the newest reading belongs to another clock.
_AHEAD_NS = 86_400 * NS_PER_S


class DriftStage(Stateful):
    """Estimates offset and rate of the dial, and subtracts the offset from its readings.

    Each `clock/reading` gives a `drift/estimate` and a `clock/corrected` with its stamp. The dial
    is assumed to be right, within `kalman.SETTING_SIGMAS`, when it was set: the readings state
    this (`DialSetting`), otherwise it is the first one. The estimate begins there, however late
    the first reading comes, and again with each new setting. If a reading reports that the dial
    has stood still, the offset changes by that time, and its variance grows accordingly. An
    observation is compared with the reading at its stamp, or with the line between the readings on
    both sides. Refused outliers (`filter_phases`) and reopened states are counted.

    With covariates the topics of their regressors are inputs too (`ship/imu`, `ship/fix`,
    `ship/temperature`), and readings wait for them, in a live graph at most until readings
    `HELD_S` later have come. Then the mean motion and the last known gravity and temperature are
    used, and counted.

    Args:
        scene: gives the observations' sigma and schedule and the prior.
        expect_schedule: True: an estimate at t uses every observation with stamp <= t, in any
            order of arrival between the topics. Readings at and after the next scheduled
            observation wait until it, or a later one, has come, or until `finish`. False: an
            observation affects readings that are published after it. It may be late by
            `HISTORY` readings and `REMEMBERED` later observations. Then the filter is repeated in
            the order of the stamps.
        motion: a source of the integrals of the covariates that replaces these topics.
        fixes: sorts the fixes of a live receiver.
    """

    outputs: ClassVar[tuple[str, ...]] = (ESTIMATE, CORRECTED)
    state_names = (
        'stamp', 'reference', 'integral', 'begun', 'released', 'pending', 'last_reading_ns',
        'last_observation_ns', 'late_s', 'health', 'motion',
        'setting',
    )  # fmt: skip

    def __init__(
        self,
        scene: Scene,
        expect_schedule: bool = True,
        motion: MotionRegressors | None = None,
        fixes: LiveFixes | None = None,
    ) -> None:
        self._scene, self._model = scene, clock_model(scene)
        if not expect_schedule:
            self._model = replace(self._model, patience_s=math.inf)
        self._schedule = schedule(scene) if expect_schedule else None
        self._motion = motion
        if motion is None and self._model.coefficients:
            self._motion = regressors(scene, live=not expect_schedule, fixes=fixes)
        self._integral = np.empty((0, len(self._model.coefficients)))
        self._begun: tuple[int, tuple[float, ...]] | None = None
        empty = np.empty(0, np.int64)
        self._stamp, self._reference = empty, empty
        self._released = 0
        self._pending: dict[int, tuple[int, float]] = {}
        self._last_reading_ns = BEFORE_ALL
        self._last_observation_ns = BEFORE_ALL
        self._track: Track | None = None
        self._setting: DialSetting | None = None
        self._late_s = 0.0
        self._health = dict.fromkeys(_COUNTED, 0)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Topics of the dial, of the observations, and of the motion if it is used."""
        return (READING, OBSERVATION, *(self._motion.inputs if self._motion else ()))

    @property
    def notices(self) -> list[str]:
        """The missing inputs of the last estimates, with the remedy."""
        lost = self._motion.lost if self._motion else ()
        names = [f'{name}_unknown' for name in lost]
        # report a fault of the sights until somebody corrects it
        names += ['observations_unknown', 'observations_years_off', 'estimates_reopened']
        health = self.health()
        warnings = drift_warnings({name: health[name] for name in names}, self._scene)
        if self._late_s:
            warnings.append(
                f'drift: the estimate began in mid-voyage, {self._late_s:.6g} s after the dial '
                'was set: its sigma is drift.prior_rate_sigma times this time until an '
                'observation comes'
            )
        return warnings

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Take readings, observations and motion, and return the samples that can be published."""
        if self._motion is not None:
            self._motion.feed(batches)
        # runs of readings that describe the same setting of the dial
        runs: list[TimeSamples] = []
        reading = batches.get(READING)
        if isinstance(reading, TimeSamples) and len(reading.stamp_ns):
            changes = np.flatnonzero(reading.source[1:] != reading.source[:-1]) + 1
            edges = pairwise([0, *changes.tolist(), len(reading.source)])
            runs = [take(reading, slice(begin, end)) for begin, end in edges]
            setting = DialSetting.of(str(reading.source[0]))
            if setting is None or setting == self._setting:
                self._accept_readings(runs.pop(0))
        if OBSERVATION in batches:
            self._accept_observations(cast(TimeSamples, batches[OBSERVATION]))
        outputs: list[Batches] = []
        for run in runs:
            outputs.append(self._release(AFTER_ALL, final=True))
            self._begin_again(run)
            self._accept_readings(run)
        due_ns = AFTER_ALL
        if self._schedule is not None:
            place = int(np.searchsorted(self._schedule, self._last_observation_ns, 'right'))
            if place < len(self._schedule):
                due_ns = int(self._schedule[place])
        outputs.append(self._release(due_ns))
        return merged(outputs)

    def _begin_again(self, reading: TimeSamples) -> None:
        """Drop the earlier readings, and continue from the estimate as far as it is valid."""
        former, setting = self._setting, DialSetting.of(str(reading.source[0]))
        self._setting = setting or former
        if former is None or setting is None or self._track is None:
            return
        integrals = tuple(self._integral[-1].tolist()) if len(self._integral) else ()
        self._stamp = self._reference = np.empty(0, np.int64)
        self._integral, self._released = self._integral[:0], 0
        if not setting.is_same_as(former):
            self._health['dial_settings'] += 1
            self._last_reading_ns = self._last_observation_ns = BEFORE_ALL
            self._pending, self._track = {}, None
            return
        self._health['dial_stops'] += 1
        base, at_ns = self._track.last, int(reading.stamp_ns[0])
        newest_ns = max(at_ns, self._last_reading_ns)
        if newest_ns > at_ns:  # the stamps have gone back
            self._last_reading_ns = self._last_observation_ns = BEFORE_ALL
        gained = tuple(map(sub, integrals, base.integrals_s))
        opened = self._stopped(base.estimate, (base.stamp_ns, newest_ns), gained, former, setting)
        reached = self._motion.at(reading.stamp_ns[:1]) if self._motion else np.empty((1, 0))
        restart = Known(at_ns, opened, integrals_s=tuple(reached[0].tolist()))
        self._track = Track(restart, self._model, self._track)

    def _stopped(
        self,
        then: Estimate[float],
        between_ns: tuple[int, int],
        gained_s: tuple[float, ...],
        former: DialSetting,
        setting: DialSetting,
    ) -> Estimate[float]:
        """Return an estimate at the end of a time in which the dial has partly stood still.

        Offset, rate and covariance change only over the rest, in which the integrals of the
        covariates grow by `gained_s`. Each known stop adds the unknown phase of the next release,
        `RELEASE_SIGMA` of a swing, and steps back of the stamps all their length.
        """
        lost_ns = setting.lost_ns - former.lost_ns
        unsure_s = (setting.unsure_ns - former.unsure_ns) / NS_PER_S
        since_ns, until_ns = between_ns
        ran_s = max(until_ns - since_ns - lost_ns, 0) / NS_PER_S
        under_way_s = min(self._model.under_way_s(since_ns, until_ns), ran_s)
        now = predict(then, ran_s, self._model, gained_s, under_way_s)
        release_s = RELEASE_SIGMA * nominal_period_s(self._scene, compile_machine(self._scene))
        opened = (setting.stops - former.stops) * release_s * release_s + unsure_s * unsure_s
        return now._replace(x=now.x - lost_ns / NS_PER_S, xx=now.xx + opened)

    def finish(self) -> Batches:
        """Release the readings that wait, and count the observations that did not come."""
        last_ns = self._last_observation_ns
        batches = self._release(AFTER_ALL, final=True)
        if self._schedule is not None:
            due = (self._schedule > last_ns) & (self._schedule <= self._last_reading_ns)
            self._health['observations_missing'] += int(np.count_nonzero(due))
        self._health['observations_unmatched'] += len(self._pending)
        self._pending = {}
        return batches

    def state(self) -> State:
        """Return readings, observations and estimate."""
        return {
            **super().state(),
            'track': None if self._track is None else self._track.state(),
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        super().restore(state)
        self._track = None
        if state['track'] is not None:
            self._track = Track(Known(0, prior(self._model)), self._model)
            self._track.restore(state['track'])

    def health(self) -> dict[str, int]:
        """Return counters: refused, missing, unused and delayed samples, reopened states."""
        track = self._track
        return {
            **self._health,
            'observations_gated': track.count(REFUSED) if track else 0,
            'estimates_reopened': track.count(REOPENED) if track else 0,
            **(self._motion.health() if self._motion else {}),
        }

    def _accept_readings(self, reading: TimeSamples) -> None:
        is_new = in_order(reading.stamp_ns, self._last_reading_ns)
        stamps = reading.stamp_ns[is_new]
        self._health['readings_out_of_order'] += len(is_new) - len(stamps)
        if not len(stamps):
            return
        self._last_reading_ns = int(stamps[-1])
        self._stamp = np.concatenate((self._stamp, stamps))
        self._reference = np.concatenate((self._reference, reading.time_ref_ns[is_new]))

    def _accept_observations(self, observation: TimeSamples) -> None:
        stamps: list[int] = observation.stamp_ns.tolist()
        references: list[int] = observation.time_ref_ns.tolist()
        sigmas = [self._model.sigma_of(source) for source in observation.source.tolist()]
        accepts = self._is_foreign_new if self._schedule is None else self._is_due
        valid = np.isin(observation.source.astype(str), SOURCES) | (self._schedule is not None)
        self._health['observations_unknown'] += int(np.count_nonzero(~valid))
        for stamp, reference, sigma, named in zip(stamps, references, sigmas, valid, strict=True):
            if self._schedule is None and abs(reference - stamp) > MOST_OFF_NS:
                self._health['observations_years_off'] += 1
            elif named and accepts(stamp):
                self._pending[stamp] = reference, sigma
                self._last_observation_ns = max(stamp, self._last_observation_ns)

    def _is_due(self, stamp: int) -> bool:
        """Return whether an observation is the next scheduled or a later one. Count the others."""
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
        """Return whether an observation may be this clock's and is new. Count the others."""
        if BEFORE_ALL < self._last_reading_ns < stamp - _AHEAD_NS:
            self._health['observations_from_future'] += 1
            return False
        if stamp > self._last_observation_ns:
            return True
        if stamp in self._pending or (self._track is not None and self._track.has(stamp)):
            self._health['observations_repeated'] += 1
            return False
        self._health['observations_delayed'] += 1
        return True

    def _release(self, before_ns: int, *, final: bool = False) -> Batches:
        """Use the observations, and publish the readings before `before_ns`, or all if `final`."""
        if self._motion is not None and not final:
            reached_ns = self._motion.reached_ns
            if self._schedule is None:  # in a live graph they wait no longer than HELD_S
                reached_ns = max(reached_ns, self._last_reading_ns - HELD_NS)
            before_ns = min(before_ns, reached_ns + 1)
        ready = max(int(np.searchsorted(self._stamp, before_ns)), self._released)
        if not ready:
            return {}
        if self._motion is not None:
            new = self._motion.at(self._stamp[len(self._integral) : ready])
            self._integral = np.concatenate((self._integral, new))
        if self._track is None:
            first_ns = int(self._stamp[0])
            setting = self._setting or DialSetting(first_ns)
            set_ns = min(setting.set_ns, first_ns)
            late_ns = first_ns - set_ns
            self._late_s = late_ns / NS_PER_S if late_ns > HELD_NS else 0.0
            reached = tuple(self._integral[0].tolist()) if self._motion is not None else ()
            self._begun = first_ns, reached
            start = Known(first_ns, prior(self._model), integrals_s=reached)
            if setting.stops or setting.unsure_ns:
                still, fresh = (0.0,) * len(start.integrals_s), DialSetting(set_ns)
                opened = self._stopped(start.estimate, (set_ns, first_ns), still, fresh, setting)
                start = start._replace(estimate=opened)
            else:
                start = start._replace(stamp_ns=set_ns)
            self._track = Track(start, self._model)
        way = self._use_observations(self._stamp[:ready])
        stamps = self._stamp[self._released : ready]
        references = self._reference[self._released : ready]
        passed = None
        if self._motion is not None and self._begun is not None:
            first_ns, begun = self._begun
            integrals = self._integral[self._released : ready]
            passed = Elapsed(
                (stamps - first_ns) / NS_PER_S, integrals, integrals - np.array(begun)
            )
        remembered = 1 if self._schedule is not None else HISTORY
        forgotten = max(ready - remembered, 0)
        self._stamp, self._reference = self._stamp[forgotten:], self._reference[forgotten:]
        self._integral = self._integral[forgotten:]
        self._released = ready - forgotten
        return estimates(stamps, references, way, self._model, passed) if len(stamps) else {}

    def _use_observations(self, ready: IntArray) -> Filtered:
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
        self._late_s = 0.0
        if self._motion is None:
            return self._track.use(stamps, phases.tolist(), sigmas)
        reading_ns = self._stamp[: len(self._integral)]
        reached = on_line(reading_ns, self._integral, at).tolist()
        return self._track.use(stamps, phases.tolist(), sigmas, list(map(tuple, reached)))
