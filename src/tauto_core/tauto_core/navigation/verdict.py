"""The verdict on a whole voyage, its projection, and the scatter of its rate."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from tauto_core.machines import AnyMachine, HangingMachine, OtherRegulator
from tauto_core.navigation.drift import mean_rate
from tauto_core.navigation.kalman import ClockModel, Estimate, predict
from tauto_core.navigation.longitude import (
    ARCMIN_PER_S,
    BEFORE_ALL,
    ERROR_NAMES,
    LEAST_UNCHECKED_DAYS,
    column,
    prize_pounds,
    required_rate_s_per_day,
)
from tauto_core.samples import (
    ESTIMATE,
    LONGITUDE_ERROR,
    LONGITUDE_FIX,
    OBSERVATION,
    READING,
    FixSamples,
    FloatArray,
    IntArray,
    JointSamples,
    Samples,
    TimeSamples,
    count,
)
from tauto_core.scene import Scene
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.ship.source import LANDFALL, LUNAR
from tauto_core.wording import span

# -----------------------------------------------------------------------------
# The time over which the filter assumes a single rate of the clock.

GROWTH = 1.5
"""Least growth of the rate's sigma when the state is reopened.

An outlier ν is beyond 5 √S, and S is at least τ² times the variance of the rate. Reopened and
updated, its sigma is about ν/(2τ): it has grown by 2.5. Any other observation reduces it.
"""


class RatedTime:
    """Finds when the present rate began, from observations, readings and estimates.

    The model of the clock has one rate, which walks slowly, until an accepted outlier reopens the
    state. Then the rate may have changed since the previous observation. Once a later observation
    has come, the rate is measured from the reopening. Batches come in order within a topic:
    observations no later than the readings and estimates at their stamps, and readings no later
    than estimates.
    """

    def __init__(self) -> None:
        self._checks: list[int] = []  # stamps of the observations
        self._readings: list[tuple[int, int]] = []  # at these stamps, as far as they have come
        self._told = 0
        self._reopened: int | None = None
        self._sigma = np.inf

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take the next batches of observations, readings and estimates, of any topics."""
        if isinstance(observed := batches.get(OBSERVATION), TimeSamples):
            last_ns = self._checks[-1] if self._checks else -1
            self._checks += np.unique(observed.stamp_ns[observed.stamp_ns > last_ns]).tolist()
        if isinstance(readings := batches.get(READING), TimeSamples):
            waiting = self._checks[len(self._readings) :]
            for place in np.searchsorted(readings.stamp_ns, waiting).tolist():
                if place < count(readings):
                    reading = readings.stamp_ns[place], readings.time_ref_ns[place]
                    self._readings.append((int(reading[0]), int(reading[1])))
        estimates = batches.get(ESTIMATE)
        if not isinstance(estimates, JointSamples) or not count(estimates):
            return
        new_sigmas = column(estimates, 'rate_sigma_s_per_day')
        sigmas = np.concatenate(([self._sigma], new_sigmas))
        for place in np.searchsorted(estimates.stamp_ns, self._checks[self._told :]).tolist():
            if place < count(estimates):
                if sigmas[place + 1] > GROWTH * sigmas[place]:
                    self._reopened = self._told
                self._told += 1
        self._sigma = float(new_sigmas[-1])

    def start(self) -> tuple[int, int] | None:
        """Return stamp and reading when the rate began [ns], `None` if it began at the start."""
        if self._reopened is None:
            return None
        measured = self._told > self._reopened + 1
        place = self._reopened if measured else self._reopened - 1
        return self._readings[place] if 0 <= place < len(self._readings) else None


# -----------------------------------------------------------------------------
# The standard error of a run's mean rate, from the slowest changes of its rate.

PARTS = 1024
"""Number of parts of a run. It separates the slowest changes from the jitter of single readings by
waves and escapement.
"""

LEAST_PARTS = 32

COSINES = 20
"""Number of coefficients for the memory of the rate."""

SLOWEST = 4
"""Number of coefficients for the standard error. More would include faster changes, which tell
less about the mean. Fewer would make it uncertain by more than a third.
"""

MEMORIES = np.geomspace(0.003, 1.0, 30)
"""Memories of a rate in lengths of the run, with equal prior probabilities. A shorter one has the
same coefficients as no memory, and a longer one cannot be measured.
"""

LONGEST = 0.1
"""Memory, in lengths of the run, beyond which the run is too short: ten of its parts would not be
independent.
"""

NEGLIGIBLE_S_PER_DAY = 0.001
"""Standard error that is good enough for any memory: 0.02 nmi after 81 days."""

TOO_SHORT = 'cannot be projected from so short a run: '
"""Beginning of the reasons that a longer run removes."""


class RateError(NamedTuple):
    """How well the mean rate of a run is known.

    Attributes:
        standard_error_s_per_day: of the mean rate [s/day], `None` if it is unknown.
        length_s: length of the run [s].
        why_unknown: the reason for `None`, with the remedy if there is one; otherwise empty.
    """

    standard_error_s_per_day: float | None
    length_s: float
    why_unknown: str = ''


class RateScatter:
    """Takes the readings of a dial in order, in batches of any size, and keeps 1,025 of them.

    With the rate y and the length T of the run, the coefficients

        c_j = √2/T ∫ y(t) cos(πjt/T) dt,   j = 1, 2, …

    have the variance of the mean rate itself if the memory of y is at most T/j, whatever its
    correlation over shorter times: both are the density of y at frequencies near zero, over T. So
    the mean of the first `SLOWEST` c_j² is the square of the standard error (the equally weighted
    cosine estimator: Müller, J. Econometrics 141, 2007; Lazarus, Lewis, Stock and Watson, JBES
    36, 2018). It holds in two more cases. Jitter of the readings at both ends of the run gives
    c_j² twice the variance of the mean. A transient at the start that has died away gives c_j √2
    times the bias of the mean.

    A rate that forgets e-fold in θ has c_j² that fall off as 1/(1 + (πjθ/T)²), and a mean of the
    variance c_0² (1 − θ/T (1 − exp(−T/θ))). The likelihood of the first `COSINES`, normal and
    independent, weights the `MEMORIES`. The square of the standard error is the mean over them. If
    a memory beyond `LONGEST` is likelier than not, the error is unknown.

    Args:
        first_ns: stamp of the first reading [ns].
        length_ns: length of the run [ns], > 0. It may end early.
    """

    def __init__(self, first_ns: int, length_ns: int) -> None:
        self._ends_ns = np.array(
            [first_ns + part * length_ns // PARTS for part in range(PARTS + 1)], dtype=np.int64
        )
        self._passed = 0
        self._kept: list[tuple[int, int]] = []

    def feed(self, readings: TimeSamples) -> None:
        """Keep the first reading at or after the end of each part."""
        stamps = readings.stamp_ns
        if not len(stamps):
            return
        reached = int(np.searchsorted(self._ends_ns, stamps[-1], side='right'))
        places = np.unique(np.searchsorted(stamps, self._ends_ns[self._passed : reached]))
        self._passed = max(self._passed, reached)
        for reading in zip(
            stamps[places].tolist(), readings.time_ref_ns[places].tolist(), strict=True
        ):
            if reading not in self._kept[-1:]:
                self._kept.append(reading)

    def rate_error(self) -> RateError:
        """Return how well the mean rate of the readings so far is known."""
        points = np.array(self._kept, dtype=np.int64).reshape(-1, 2)
        parts = max(len(points) - 1, 0)
        length_s = float(points[-1, 0] - points[0, 0]) / NS_PER_S if parts else 0.0
        if parts < LEAST_PARTS:
            return RateError(
                None,
                length_s,
                f'{TOO_SHORT}it is logged {len(points)} times, and how its rate scatters shows in '
                f'{LEAST_PARTS + 1} or more. Sail longer, or log more often',
            )
        # c_j [s/day] for j = 1 to COSINES, the rate being constant in each part
        elapsed, gained = points[:, 0] - points[0, 0], points[:, 1] - points[:, 0]
        rate = np.diff(gained) / np.diff(elapsed) * DAY_S
        turns = math.pi * np.arange(1, COSINES + 1)[:, None]
        weights = np.diff(np.sin(turns * (elapsed / elapsed[-1])), axis=1) / turns
        squares = (math.sqrt(2.0) * np.sum(weights * rate, axis=1)) ** 2
        if not squares.any():
            return RateError(0.0, length_s)
        shape = 1.0 / (1.0 + (np.pi * np.outer(MEMORIES, np.arange(1, COSINES + 1))) ** 2)
        levels = squares / shape
        likely = -0.5 * np.sum(np.log(shape) + np.log(np.mean(levels, 1))[:, None], axis=1)
        chance = np.exp(likely - np.max(likely))
        chance /= np.sum(chance)
        of_mean = 1.0 - MEMORIES * (1.0 - np.exp(-1.0 / MEMORIES))
        sigma = math.sqrt(float(np.sum(chance * np.mean(levels[:, :SLOWEST], 1) * of_mean)))
        if np.sum(chance[MEMORIES > LONGEST]) > 0.5 and sigma > NEGLIGIBLE_S_PER_DAY:
            return RateError(
                None,
                length_s,
                f'{TOO_SHORT}its rate still changes from one end to the other, so the mean is '
                f'known to {sigma:.2g} s/day at best. Sail longer',
            )
        return RateError(sigma, length_s)


# -----------------------------------------------------------------------------
# The error that the rate of a short run would cause on a voyage of the Act of 1714.

PROJECTED_DAYS = (42.0, 81.0)
"""Six weeks, about a passage to the West Indies, to which the Act sends the clock; and the days
of H4 between its comparisons at Portsmouth and in Jamaica, 1761 to 1762.
"""

HALF_TURN_S = 0.5 * DAY_S
"""Error of a clock that is half a turn of longitude, the largest distance of two places."""

FORGOTTEN = 10.0
"""Number of time constants of the swing after which a run no longer depends on its start: the
standard error is then too small by a factor of 1.5 at most, as for a rate of that memory.
"""

AMPLITUDE_SHARE = 0.1
"""Relative change of an undamped amplitude by waves; in the built-in scenes it is 0.05 after an
hour.
"""

LEAST_EFFECT_S_PER_DAY = 0.01
"""Largest negligible effect on the rate: 0.2 nmi after 81 days."""

_CANNOT = 'cannot be projected: '
_WANDERS = 'so each wave changes it for good'


def has_settled(scene: Scene, machine: AnyMachine | OtherRegulator, found: RateError) -> RateError:
    """Return the uncertainty of the mean rate, if the swing no longer depends on its start.

    The effect of release and first waves on an undamped swing lasts for the whole run, and the
    next: the rate scatters about its own mean, which the run alone does not show. That matters if
    the rate depends on the amplitude by more than its standard error, `found` from the run.
    """
    if isinstance(machine, OtherRegulator):
        return found

    still, hung = scene.lies_still, scene.suspension
    drag = None if machine.drag is None or machine.drag.is_zero else machine.drag
    dies, hangs = (
        drag is not None and machine.escapement is None,
        isinstance(machine, HangingMachine),
    )
    depends, settled_s = False, 0.0
    if not (still or dies or isinstance(machine, HangingMachine)):
        threshold = max(found.standard_error_s_per_day or 0.0, LEAST_EFFECT_S_PER_DAY)
        amplitude = abs(machine.release_angle)
        low, full = machine.period((1.0 - AMPLITUDE_SHARE) * amplitude), machine.period(amplitude)
        depends = abs(low / full - 1.0) * DAY_S > threshold
        if drag is not None and depends:
            # the energy of a harmonic swing comes e-fold nearer to the steady one in J/damping
            damping = drag.damping(machine.frequency * amplitude)
            settled_s = FORGOTTEN * (machine.inertia / damping)
    swings = hung is not None and not hung.is_damped and not (still or dies or hangs)
    reasons = {
        f'{_CANNOT}the swing dies away, since there is drag and no escapement to make good for '
        'it. Give the clock an escapement': dies,
        f'{_CANNOT}nothing holds the swing of the thread, {_WANDERS}': hangs and not still,
        f'{_CANNOT}nothing damps the wheel, on whose amplitude the rate depends, {_WANDERS}. Give '
        'the clock drag and an escapement': depends and drag is None,
        f'{_CANNOT}nothing damps the swing of the case, on which the rate depends, {_WANDERS}':
        swings and (depends or machine.feels_gravity),
        f'{TOO_SHORT}its rate depends on the amplitude, which takes {span(settled_s, 2)} to '
        'settle. Sail longer': found.length_s < settled_s,
    }  # fmt: skip
    why = next((words for words, holds in reasons.items() if holds), None)
    return found if why is None else RateError(None, found.length_s, why)


def projection(
    rate_s_per_day: float,
    error: RateError,
    estimate: Mapping[str, float],
    model: ClockModel,
    latitude_deg: float,
    random_walk_fm_per_s: float = 0.0,
) -> dict[str, Any]:
    """Return the error after `PROJECTED_DAYS` unchecked of a clock set right at departure.

    The dial gains y T, which puts the ship y T · ¼ arcmin/s · cos φ to the west. With the standard
    error s of y over a run of the length T₀ the gain has the variance s² T² + s² T₀ T: the rate of
    the run may differ from the mean of all runs, and so may the voyage's. Random-walk noise q of
    the dial adds q T₀ T²/3 + q T³/3. Correction by the estimated rate ŷ (`mean_rate`) leaves (y −
    ŷ) T; with covariates it assumes that the ship's motion continues. Its standard deviation has
    the navigator's uncertainty by his own model (`kalman.predict` under way, from an exact offset,
    without coefficients) and the variance of y, since he has rated the clock in this run alone.

    There is no projection without a standard error, nor beyond half a turn. `projection` has for
    each number of `days` `raw_error_nmi` of the dial, `error_nmi` of the corrected clock, both
    positive to the east, and the standard deviations `raw_sigma_nmi` and `sigma_nmi`, `None`
    beyond half a turn. `not_projected` is the reason for missing values, or `None`.
    """
    if error.standard_error_s_per_day is None:
        return {'projection': [], 'not_projected': error.why_unknown}
    nmi_per_s = ARCMIN_PER_S * math.cos(math.radians(latitude_deg))
    scatter = (error.standard_error_s_per_day / DAY_S) ** 2
    estimated, sigma = mean_rate(estimate)
    start = Estimate(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, (sigma / DAY_S) ** 2, 0.0, 0.0)
    rows: list[dict[str, Any]] = []
    missing: dict[str, str] = {}
    for days in PROJECTED_DAYS:
        time_s = days * DAY_S
        of_rate = scatter * (time_s + error.length_s) * time_s
        of_rate += random_walk_fm_per_s * error.length_s * time_s**2 / 3.0
        dial = of_rate + random_walk_fm_per_s * time_s**3 / 3.0
        corrected = of_rate + predict(start, time_s, model, (), time_s).xx
        row: dict[str, Any] = {'days': days}
        for clock, prefix, gained_s, variance in (
            ('the dial', 'raw_', rate_s_per_day * days, dial),
            ('the corrected clock', '', (rate_s_per_day - estimated) * days, corrected),
        ):
            sigma_s = math.sqrt(variance)
            uncertain, is_far = sigma_s > HALF_TURN_S, abs(gained_s) > HALF_TURN_S
            row[f'{prefix}error_nmi'] = None if uncertain or is_far else -gained_s * nmi_per_s
            row[f'{prefix}sigma_nmi'] = None if uncertain or is_far else sigma_s * nmi_per_s
            if uncertain:
                missing.setdefault(
                    clock, f'{TOO_SHORT}after {days:g} days its ± is {_turn(sigma_s)}'
                )
            elif is_far:
                missing.setdefault(
                    clock, f'{_CANNOT}after {days:g} days it is wrong by {_turn(gained_s)}'
                )
        rows.append(row)
    reasons = [f'{clock} {why}' for clock, why in missing.items()]
    return {'projection': rows, 'not_projected': '; '.join(reasons) or None}


def _turn(error_s: float) -> str:
    return f'{abs(error_s):,.0f} s, more than half a turn of longitude, {HALF_TURN_S:,.0f} s'


# -----------------------------------------------------------------------------
# The verdict on a whole voyage, from the contents of the topics alone.

_JUDGED = ('raw_error_nmi', 'error_nmi')

_Row: TypeAlias = tuple[int, FloatArray]


class _RowsBefore:
    """The last row of a topic, and the last one before each of several instants."""

    def __init__(self) -> None:
        self.last: _Row | None = None
        self.before: dict[int, _Row | None] = {}

    def mark(self, instant_ns: int) -> None:
        """Keep the last row before an instant. It is unknown if later rows have come already."""
        came = self.last is not None and self.last[0] >= instant_ns
        self.before[instant_ns] = None if came else self.last

    def feed(self, stamp_ns: IntArray, rows: FloatArray) -> None:
        """Take the next rows, (n, m), n > 0."""
        for instant in self.before:
            place = int(np.searchsorted(stamp_ns, instant))
            if place:
                self.before[instant] = (int(stamp_ns[place - 1]), rows[place - 1].copy())
        self.last = (int(stamp_ns[-1]), rows[-1].copy())


class LongitudeTally:
    """Error of the longitude at landfalls, at the end and at its worst, over all batches.

    The last sample before its observation, when the clock was not yet checked, judges a landfall.
    The worst error is sought after the last observation in port: before that the clock was being
    rated. Lunar distances are not checks: a voyage is unchecked between places of known longitude.
    Feed observations no later than the errors that include them.
    """

    def __init__(self) -> None:
        self._errors, self._latitudes = _RowsBefore(), _RowsBefore()
        self._first_ns = 0
        self._worst: dict[str, tuple[float, int]] = {}  # size [nmi] and stamp
        self._in_port_ns = BEFORE_ALL
        self._checked_before: dict[int, int | None] = {}
        self._last_checked: int | None = None

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take the next batches of observations, places and errors, of any topics.

        A missing name of an error is an EstimationError.
        """
        if isinstance(observed := batches.get(OBSERVATION), TimeSamples):
            marks = zip(observed.stamp_ns.tolist(), observed.source.tolist(), strict=True)
            for stamp, source in marks:
                if source == LUNAR:
                    continue  # the place is not known there
                if source == LANDFALL:
                    self._checked_before[stamp] = self._last_checked
                    self._errors.mark(stamp)
                    self._latitudes.mark(stamp)
                else:
                    self._in_port_ns = stamp
                    self._worst = {}
                self._last_checked = stamp
        fixes, errors = batches.get(LONGITUDE_FIX), batches.get(LONGITUDE_ERROR)
        if isinstance(fixes, FixSamples) and count(fixes):  # they have the latitude
            self._latitudes.feed(fixes.stamp_ns, fixes.latitude[:, None])
        if not isinstance(errors, JointSamples) or not count(errors):
            return
        columns = {name: column(errors, name) for name in ERROR_NAMES}
        if self._errors.last is None:
            self._first_ns = int(errors.stamp_ns[0])
        self._errors.feed(errors.stamp_ns, np.column_stack(list(columns.values())))
        left_port = int(np.searchsorted(errors.stamp_ns, self._in_port_ns))
        if left_port < count(errors):
            for name in _JUDGED:
                sizes = np.abs(columns[name][left_port:])
                place = int(sizes.argmax())
                if name not in self._worst or sizes[place] > self._worst[name][0]:
                    self._worst[name] = (
                        float(sizes[place]),
                        int(errors.stamp_ns[left_port + place]),
                    )

    def result(self) -> dict[str, Any] | None:
        """Return the verdict, `None` without errors. Times are from the first error [s].

        Keys: as in each of the `landfalls`, at the last of them, or without landfalls at the
        last sample. `landfalls`, a list; `worst_error_nmi` (magnitude), `worst_at_s`,
        `worst_prize_pounds` of the corrected clock, and `worst_raw_…` of the dial, since
        `worst_since_s`, the last observation in port, or 0.

        A landfall has `at_s`, `latitude_deg` (`None` if unknown), `ERROR_NAMES`, `unchecked_days`
        since the observation before it or the setting of the dial, `prize_pounds` for the
        corrected distance, as the Act judges it, `raw_prize_pounds`, and `required_rate_s_per_day`
        for £20,000 after this time. These three, and the prizes for the worst errors, are `None`
        if less than `LEAST_UNCHECKED_DAYS` were unchecked, since no such voyage qualifies.
        """
        if self._errors.last is None:
            return None
        landfalls = [
            self._verdict(row, self._latitudes.before[mark], self._checked_before[mark])
            for mark, row in self._errors.before.items()
            if row is not None
        ]
        at_end = self._verdict(self._errors.last, self._latitudes.last, self._last_checked)
        stamp, values = self._errors.last
        errors = dict(zip(ERROR_NAMES, values.tolist(), strict=True))
        (raw_nmi, raw_ns), (worst_nmi, worst_ns) = (
            self._worst.get(name, (abs(errors[name]), stamp)) for name in _JUDGED
        )
        judged = landfalls[-1] if landfalls else at_end
        tried = judged['prize_pounds'] is not None
        return {
            **judged,
            'landfalls': landfalls,
            'worst_since_s': self._time_s(min(max(self._in_port_ns, self._first_ns), stamp)),
            'worst_error_nmi': worst_nmi,
            'worst_at_s': self._time_s(worst_ns),
            'worst_prize_pounds': prize_pounds(worst_nmi) if tried else None,
            'worst_raw_error_nmi': raw_nmi,
            'worst_raw_at_s': self._time_s(raw_ns),
            'worst_raw_prize_pounds': prize_pounds(raw_nmi) if tried else None,
        }

    def _verdict(self, row: _Row, latitude: _Row | None, checked_ns: int | None) -> dict[str, Any]:
        stamp, values = row
        errors = dict(zip(ERROR_NAMES, values.tolist(), strict=True))
        since = self._first_ns if checked_ns is None else checked_ns
        days = max(stamp - since, 0) / NS_PER_S / DAY_S
        tried = days >= LEAST_UNCHECKED_DAYS
        degrees = None if latitude is None else float(latitude[1][0])
        required = None
        if tried and degrees is not None:
            required = required_rate_s_per_day(days, degrees)
        return {
            'at_s': self._time_s(stamp),
            'latitude_deg': degrees,
            **errors,
            'unchecked_days': days,
            'prize_pounds': prize_pounds(abs(errors['error_nmi'])) if tried else None,
            'raw_prize_pounds': prize_pounds(abs(errors['raw_error_nmi'])) if tried else None,
            'required_rate_s_per_day': required,
        }

    def _time_s(self, stamp: int) -> float:
        return (stamp - self._first_ns) / NS_PER_S
