"""The longitude stage: the ship's position by the clock, its error, and the prize."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import reduce
from typing import ClassVar, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from tauto_core.clockwork.trochlea import DialSetting
from tauto_core.kernels import entry
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    LONGITUDE_ERROR,
    LONGITUDE_FIX,
    READING,
    SHIP_FIX,
    Batches,
    FixSamples,
    FloatArray,
    IntArray,
    JointSamples,
    Samples,
    Stateful,
    TimeSamples,
    count,
    join,
    merged,
    scalars,
    take,
)
from tauto_core.scene import Scene
from tauto_core.scene.errors import EstimationError
from tauto_core.scene.sections import WIDEST_AWARD_NMI
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.ship import Passage
from tauto_core.ship.passage import wrap

# -----------------------------------------------------------------------------
# Selects the samples of a topic that come in order.

BEFORE_ALL = int(np.iinfo(np.int64).min)
"""Stamp before all samples [ns]."""

AFTER_ALL = int(np.iinfo(np.int64).max)
"""Stamp after all samples [ns]."""


def in_order(stamp_ns: IntArray, last_ns: int) -> NDArray[np.bool_]:
    """Return which stamps are later than `last_ns` and than all stamps before them."""
    if len(stamp_ns) == 1:  # nodes usually get one message at a time
        return np.array([stamp_ns[0] > last_ns])
    newest = np.maximum.accumulate(np.concatenate(([last_ns], stamp_ns)))[:-1]
    is_newer: NDArray[np.bool_] = stamp_ns > newest
    return is_newer


# -----------------------------------------------------------------------------
# The true positions of the ship.

FRAME_ID = 'clock_mount'
STATUS_FIX, STATUS_NO_FIX = 0, -1
SERVICE_UNKNOWN = 0
COVARIANCE_DIAGONAL_KNOWN = 2
POSITION_VARIANCE_M2 = 1.0
"""Variance of each known coordinate [m²]. Some readers of NavSatFix refuse zeros."""


class Route:
    """The true positions of a scene's ship, as fixes.

    The ship is at the departure until `voyage.sails_at`, then moves at constant speed over the
    waypoints (`ship.Passage`) and stays at the arrival. Without a voyage it stays at 0°, 0°, where
    a minute of longitude is a nautical mile.

    Attributes:
        length_m: length of the route [m], 0 without a voyage.

    Raises:
        SceneError: the route cannot be sailed, see `Passage`.
    """

    def __init__(self, scene: Scene) -> None:
        self._starts_at_ns = scene.starts_at_ns
        self._passage = None if scene.voyage is None else Passage(scene, scene.voyage)
        self.length_m = 0.0 if self._passage is None else self._passage.length_m

    def fixes(self, stamp_ns: IntArray) -> FixSamples:
        """Return the true positions at some stamps [ns], in degrees at altitude 0.

        The frame `clock_mount` is at these positions, as NavSatFix requires. Each position depends
        only on its own stamp.
        """
        if self._passage is None:
            latitude, longitude = np.zeros((2, len(stamp_ns)))
        else:
            latitude, longitude = self._passage.places(stamp_ns - self._starts_at_ns)
        variances = np.full((len(stamp_ns), 3), POSITION_VARIANCE_M2)
        return fix_samples(stamp_ns, latitude, longitude, variances)


def fix_samples(
    stamp_ns: IntArray, latitude: FloatArray, longitude: FloatArray, variances_m2: FloatArray
) -> FixSamples:
    """Return positions [degrees north, east] as NavSatFix samples, with a valid fix at altitude 0.

    `variances_m2` are of east, north and up, (n, 3).
    """
    n = len(stamp_ns)
    covariance = np.zeros((n, 9))
    covariance[:, [0, 4, 8]] = variances_m2
    return FixSamples(
        stamp_ns,
        FRAME_ID,
        np.full(n, STATUS_FIX, np.int8),
        np.full(n, SERVICE_UNKNOWN, np.uint16),
        latitude,
        longitude,
        np.zeros(n),
        covariance,
        np.full(n, COVARIANCE_DIAGONAL_KNOWN, np.uint8),
    )


ERROR_NAMES = ('raw_error_arcmin', 'raw_error_nmi', 'error_arcmin', 'error_nmi', 'sigma_nmi')
ARCMIN_PER_S = 15.0 / 60.0
"""Angle by which the mean sun moves in a second [arc minutes] (longitude.md)."""

HALF_TURN_ARCMIN = 180.0 * 60.0

EQUATOR_M_PER_S = 2.0 * math.pi * 6_378_137.0 / DAY_S
"""Speed of the mean sun along the equator of WGS 84 [m/s], 463.8."""

# A fix stamped more than this after the newest reading belongs to another clock.
_AHEAD_NS = 3600 * NS_PER_S

HELD = 4096
"""Largest number of samples of a topic that wait for partners without `expect_fix`."""


_COUNTED = (
    'out_of_order', 'fixes_invalid', 'fixes_from_future', 'stamps_unjoined', 'dial_settings',
)  # fmt: skip


def longitude_error_arcmin(clock_error_s: FloatArray) -> FloatArray:
    """Return the error of the longitude [arc minutes, east positive] for a clock fast by x [s].

    λ = −15″ x in [−180°, 180°): a fast clock puts the ship west of its true meridian
    (longitude.md). A clock shows the time of day, so an error of a whole day does not count.
    """
    return wrap(-ARCMIN_PER_S * clock_error_s, HALF_TURN_ARCMIN)


def column(samples: JointSamples, name: str) -> FloatArray:
    """Return one of the named scalars of a message, (n,). EstimationError if it is missing."""
    if name not in samples.name:
        raise EstimationError(
            f'{name} is missing: the message has {", ".join(samples.name) or "no names"}. '
            f'Send a JointState whose names include {name}'
        )
    values: FloatArray = samples.position[:, samples.name.index(name)]
    return values


@entry
def cosines_of_degrees(degrees: FloatArray, out: FloatArray) -> None:
    """Fill the cosines of angles in degrees (n,).

    The bits of np.cos may depend on the place in an array, and a list takes ten times as long.
    """
    for i in range(len(degrees)):
        out[i] = math.cos(degrees[i] * (math.pi / 180.0))


PERSISTS_S = 60.0
"""Time for which a receiver must give places out of reach until they are accepted [s]."""

FIX_NOISE_M = 100.0
"""Distance of two fixes that need not be motion [m]."""

Place: TypeAlias = tuple[int, float, float]
"""Stamp [ns], latitude and longitude [degrees]."""


class LiveFixes(Stateful):
    """Sorts the fixes of a real receiver, which may lack one or give a wrong one.

    A fix is refused at 0°, 0°, which a receiver without a fix may give, and out of the ship's
    reach since the last one, unless such places persist for `PERSISTS_S`.

    Args:
        max_age_s: age of a fix after which the place is unknown [s].
        max_speed: largest speed of the ship [m/s], by which the sigma of a place grows with age.
    """

    state_names = ('last', 'strayed', 'health')

    def __init__(self, max_age_s: float = 10.0, max_speed: float = 50.0) -> None:
        self.max_age_s, self.max_speed = max_age_s, max_speed
        self._last: Place | None = None
        self._strayed: tuple[int, Place] | None = None
        self._health = dict.fromkeys(('fixes_at_0_0', 'fixes_out_of_reach', 'fixes_moved'), 0)

    def taken(self, fix: FixSamples) -> NDArray[np.bool_]:
        """Return which of the next fixes, in order, are taken, and count the others."""
        columns = (fix.stamp_ns, fix.latitude, fix.longitude)
        return np.array(
            [self._takes(place) for place in zip(*map(np.ndarray.tolist, columns), strict=True)]
        )

    def _takes(self, place: Place) -> bool:
        fault = 'fixes_at_0_0' if place[1:] == (0.0, 0.0) else ''
        if not fault and self._last is not None and not self._reaches(self._last, place):
            first_ns, previous = self._strayed or (place[0], place)
            self._strayed = (first_ns if self._reaches(previous, place) else place[0]), place
            persists_s = (place[0] - self._strayed[0]) / NS_PER_S
            fault = 'fixes_moved' if persists_s >= PERSISTS_S else 'fixes_out_of_reach'
        if fault:
            self._health[fault] += 1
        if fault in ('', 'fixes_moved'):
            self._last, self._strayed = place, None
            return True
        return False

    def _reaches(self, origin: Place, target: Place) -> bool:
        turned = math.remainder(target[2] - origin[2], 360.0) * math.cos(math.radians(origin[1]))
        apart_m = math.hypot(turned, target[1] - origin[1]) * EQUATOR_M_PER_S * DAY_S / 360.0
        return apart_m <= FIX_NOISE_M + self.max_speed * abs(target[0] - origin[0]) / NS_PER_S

    def health(self) -> dict[str, int]:
        """Return counters of refused fixes, and of accepted places that were out of reach."""
        return dict(self._health)


class LongitudeStage(Stateful):
    """Computes the ship's longitude by the clock and compares it with the true one.

    Four topics are joined by stamp, in any order of arrival between them. A stamp that one of them
    lacks is left out and counted. `longitude/fix` has the latitude of `ship/fix` and the longitude
    by the corrected clock, wrapped to [−180°, 180°), with the east variance of the estimated
    offset, (463.8 m/s · cos φ · σ)². `longitude/error` has the names `ERROR_NAMES`. Nautical miles
    are arc minutes × cos φ: at a pole any longitude is right.

    A live clock knows its place only from fixes. Its `longitude/fix`, by a chronometer and no
    satellite, has STATUS_NO_FIX. It is silent, without nautical miles, while the place is unknown.

    Args:
        scene: gives the position if there is no fix.
        expect_fix: False: each reading takes the latest valid fix at or before it that has come,
            before the first fix the scene's route from the setting of the dial on.
        live: the receiver of a live clock, which expects no fix of each stamp.
    """

    state_names = ('held', 'last_ns', 'first_ns', 'setting', 'stale', 'live', 'age_s', 'health')
    inputs: ClassVar[tuple[str, ...]] = (SHIP_FIX, READING, CORRECTED, ESTIMATE)
    outputs: ClassVar[tuple[str, ...]] = (LONGITUDE_FIX, LONGITUDE_ERROR)

    def __init__(
        self, scene: Scene, expect_fix: bool = True, live: LiveFixes | None = None
    ) -> None:
        expect_fix = expect_fix and live is None
        self._live, self._age_s = live, math.inf
        self._route = Route(scene)
        self._starts_at_ns = scene.starts_at_ns
        self._first_ns: int | None = None
        self._expect_fix = expect_fix
        self._joined = self.inputs if expect_fix else self.inputs[1:]
        self._held: dict[str, Samples] = {}
        self._last_ns = dict.fromkeys(self.inputs, BEFORE_ALL)
        self._setting: DialSetting | None = None
        self._stale: list[str] = []
        self._health = dict.fromkeys(_COUNTED, 0)

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Take new samples, and return longitudes of the stamps that every topic has reached."""
        if self._expect_fix:
            return self._feed(batches)
        outputs, remaining = [], dict(batches)
        while remaining:  # one run of time after the other, since stamps may go back
            parts = {topic: cast(TimeSamples, remaining.pop(topic)) for topic in list(remaining)}
            for topic, samples in parts.items():
                steps_back = np.diff(samples.stamp_ns) < 0
                if topic == READING:
                    steps_back |= samples.source[1:] != samples.source[:-1]
                if topic != SHIP_FIX and steps_back.any():
                    cut = int(np.argmax(steps_back)) + 1
                    parts[topic] = take(samples, slice(0, cut))
                    remaining[topic] = take(samples, slice(cut, None))
            outputs.append(self._feed(parts))
        return merged(outputs)

    def _feed(self, batches: Mapping[str, Samples]) -> Batches:
        if READING in batches:
            self._see_setting(cast(TimeSamples, batches[READING]))
        for topic in self.inputs:
            if topic in batches:
                self._hold(topic, batches[topic])
        outputs = self._say()
        for topic, samples in self._held.items() if not self._expect_fix else ():
            excess = count(samples) - HELD
            if excess > 0:
                self._held[topic] = take(cast(TimeSamples, samples), slice(excess, None))
                if topic in self._joined:
                    self._health['stamps_unjoined'] += excess
        return outputs

    def _see_setting(self, reading: TimeSamples) -> None:
        """Start again with a new setting. Topics drop samples until their stamps go back, too."""
        for source in dict.fromkeys(reading.source.tolist()):
            setting = DialSetting.of(str(source))
            if setting is None:
                continue
            if self._setting is not None and not setting.is_same_as(self._setting):
                self._health['dial_settings'] += 1
                self._stale = list(self.inputs)
                self._held, self._first_ns = {}, None
            elif (
                self._setting is not None
                and setting.unsure_ns > self._setting.unsure_ns
                and reading.stamp_ns[0] <= self._last_ns[READING]
            ):
                self._stale = list(self._joined)
                self._held = {t: samples for t, samples in self._held.items() if t == SHIP_FIX}
            self._setting = setting

    def finish(self) -> Batches:
        """Drop and count the stamps that still wait for a partner."""
        stamps = [self._held[topic].stamp_ns for topic in self._joined if topic in self._held]
        if stamps:
            self._health['stamps_unjoined'] += len(reduce(np.union1d, stamps))
        self._held = {
            topic: self._held[topic] for topic in self._held if topic not in self._joined
        }
        return {}

    @property
    def notices(self) -> list[str]:
        """The remedy if the place is unknown."""
        if self._live is None or self._age_s <= self._live.max_age_s:
            return []
        why = (
            f'the last fix is {self._age_s:.4g} s old, fix_max_age is {self._live.max_age_s:g}'
            if math.isfinite(self._age_s)
            else 'no fix has come'
        )
        return [
            f'the place is unknown: {why}. Publish sensor_msgs/NavSatFix on ship/fix, of a valid '
            'fix. longitude/fix is silent, and longitude/error has no nautical miles'
        ]

    def health(self) -> dict[str, int]:
        """Return counters of refused samples and of stamps without a partner."""
        return {**self._health, **(self._live.health() if self._live else {})}

    def _hold(self, topic: str, samples: Samples) -> None:
        new = cast(TimeSamples, samples)
        if topic == SHIP_FIX:
            fix = cast(FixSamples, samples)
            # false for NaN
            on_globe = (np.abs(fix.latitude) <= 90.0) & (np.abs(fix.longitude) <= 360.0)
            valid = on_globe & (fix.status >= STATUS_FIX)
            self._health['fixes_invalid'] += int(np.count_nonzero(~valid))
            new = _only(new, valid)
            if not self._expect_fix and self._last_ns[READING] > BEFORE_ALL:
                if self._last_ns[SHIP_FIX] > self._last_ns[READING] + _AHEAD_NS:
                    self._held.pop(SHIP_FIX, None)  # no reading could check these
                    self._last_ns[SHIP_FIX] = BEFORE_ALL
                is_near = new.stamp_ns <= self._last_ns[READING] + _AHEAD_NS
                self._health['fixes_from_future'] += int(np.count_nonzero(~is_near))
                new = _only(new, is_near)
        if topic in self._stale and count(new):
            jumps = np.flatnonzero(np.diff(new.stamp_ns, prepend=self._last_ns[topic]) <= 0)
            self._last_ns[topic] = BEFORE_ALL if len(jumps) else int(new.stamp_ns[-1])
            new = take(new, slice(int(jumps[0]) if len(jumps) else count(new), None))
            if len(jumps):
                self._stale.remove(topic)
        is_new = in_order(new.stamp_ns, self._last_ns[topic])
        self._health['out_of_order'] += len(is_new) - int(np.count_nonzero(is_new))
        new = _only(new, is_new)
        if self._live is not None and topic == SHIP_FIX and count(new):
            new = _only(new, self._live.taken(cast(FixSamples, new)))
        if not count(new):
            return
        self._last_ns[topic] = int(new.stamp_ns[-1])
        old = self._held.get(topic)
        self._held[topic] = new if old is None else join([cast(TimeSamples, old), new])

    def _say(self) -> Batches:
        if any(topic not in self._held for topic in self._joined):
            return {}
        parts = self._matched()
        reading = cast(TimeSamples, parts[READING])
        stamps = reading.stamp_ns
        if not len(stamps):
            return {}
        sigma_s = column(cast(JointSamples, parts[ESTIMATE]), 'offset_sigma_s')
        fix = cast(FixSamples, parts[SHIP_FIX]) if self._expect_fix else self._places(stamps)
        raw, error = (
            longitude_error_arcmin((clock.time_ref_ns - clock.stamp_ns) / NS_PER_S)
            for clock in (reading, cast(TimeSamples, parts[CORRECTED]))
        )
        cosine = np.empty(len(stamps))
        cosines_of_degrees(np.ascontiguousarray(fix.latitude), cosine)
        values = np.column_stack(
            (raw, raw * cosine, error, error * cosine, ARCMIN_PER_S * sigma_s * cosine)
        )
        east_sigma_m = EQUATOR_M_PER_S * cosine * sigma_s
        variances = np.full((len(stamps), 3), POSITION_VARIANCE_M2)
        variances[:, 0] = east_sigma_m * east_sigma_m
        if self._live is not None:
            variances += fix.position_covariance[:, [0, 4, 8]]
        longitude = wrap(fix.longitude + error / 60.0)
        place = fix_samples(stamps, fix.latitude, longitude, variances)
        if self._live is not None:
            place.status[:] = STATUS_NO_FIX
            place = take(place, np.isfinite(fix.latitude))
        return {LONGITUDE_FIX: place, LONGITUDE_ERROR: scalars(stamps, ERROR_NAMES, values)}

    def _matched(self) -> dict[str, Samples]:
        """Take from each joined topic the samples up to the stamp that all topics have reached."""
        parts = {topic: cast(TimeSamples, self._held.pop(topic)) for topic in self._joined}
        stamps = [part.stamp_ns for part in parts.values()]
        if all(np.array_equal(stamps[0], each) for each in stamps):
            return dict(parts)
        horizon_ns = min(self._last_ns[topic] for topic in self._joined)
        for topic, samples in parts.items():
            reached = samples.stamp_ns <= horizon_ns
            if not reached.all():
                self._held[topic] = take(samples, ~reached)
            parts[topic] = take(samples, reached)
        stamps = [part.stamp_ns for part in parts.values()]
        common = reduce(np.intersect1d, stamps)
        self._health['stamps_unjoined'] += len(reduce(np.union1d, stamps)) - len(common)
        return {t: take(part, np.isin(part.stamp_ns, common)) for t, part in parts.items()}

    def _places(self, stamps: IntArray) -> FixSamples:
        """Return the latest fix at each stamp, or else the route. A live clock has NaN instead."""
        if self._first_ns is None:
            self._first_ns = self._setting.set_ns if self._setting else int(stamps[0])
        places = self._route.fixes(stamps - self._first_ns + self._starts_at_ns)
        fixes, live = self._held.get(SHIP_FIX), self._live
        if live is not None:
            places.latitude[:], places.longitude[:], self._age_s = math.nan, math.nan, math.inf
        if not isinstance(fixes, FixSamples):
            return places
        latest = np.searchsorted(fixes.stamp_ns, stamps, 'right') - 1
        has_fix = latest >= 0
        if live is not None:
            age_s = np.where(has_fix, (stamps - fixes.stamp_ns[latest]) / NS_PER_S, math.inf)
            self._age_s, has_fix = float(age_s[-1]), age_s <= live.max_age_s
            strayed_m = live.max_speed * age_s[has_fix, None]
            places.position_covariance[has_fix] = strayed_m * strayed_m
        places.latitude[has_fix] = fixes.latitude[latest[has_fix]]
        places.longitude[has_fix] = fixes.longitude[latest[has_fix]]
        self._held[SHIP_FIX] = take(fixes, slice(max(int(latest[-1]), 0), None))
        return places


def _only(samples: TimeSamples, which: NDArray[np.bool_]) -> TimeSamples:
    return samples if which.all() else take(samples, which)


# -----------------------------------------------------------------------------
# The verdict of the Longitude Act of 1714 (13 Ann. c. 14).

AWARDS = ((30.0, 20_000), (40.0, 15_000), (WIDEST_AWARD_NMI, 10_000))
"""(distance [nautical miles], pounds): half a degree, two thirds of a degree, one degree."""

LEAST_UNCHECKED_DAYS = 42.0
"""Six weeks, a voyage to the West Indies. A shorter voyage does not qualify for the prize."""


def prize_pounds(distance_nmi: float) -> int:
    """Return the prize by the Act for a longitude found within a distance >= 0 [pounds].

    £20,000 within 30 miles, £15,000 within 40, £10,000 within 60, the limits included, else 0
    (longitude.md). NaN or a negative distance is an EstimationError.
    """
    if not distance_nmi >= 0.0:
        raise EstimationError(
            f'distance = {distance_nmi} nmi: must be a number >= 0. '
            'Give the magnitude of the error in nautical miles'
        )
    return next((pounds for limit, pounds in AWARDS if distance_nmi <= limit), 0)


def grade(distance_nmi: float) -> str:
    """Return how good a longitude is by the limits of the Act, in words."""
    for limit_nmi, pounds in AWARDS:
        if distance_nmi <= limit_nmi:
            return f'within {limit_nmi:g} nmi, worth £{pounds:,} by the Act of 1714'
    widest, best = AWARDS[-1][0], AWARDS[0][0]
    return f'beyond {widest:g} nmi, worth nothing by the Act of 1714; {best:g} are worth most'


def required_rate_s_per_day(days: float, latitude_deg: float) -> float:
    """Return the error of the rate [s/day] that just keeps within the first award, 30 miles.

    30 nmi/(cos φ · ¼ arcmin/s · days): a constant error, `days` > 0 since the clock was last
    compared with the true time, at a landfall in latitude φ (longitude.md). `days` <= 0 is an
    EstimationError.
    """
    if not days > 0.0:
        raise EstimationError(
            f'days = {days}: must be > 0. Give the time since the clock was last compared'
        )
    seconds = AWARDS[0][0] / (ARCMIN_PER_S * math.cos(math.radians(latitude_deg)))
    return seconds / days
