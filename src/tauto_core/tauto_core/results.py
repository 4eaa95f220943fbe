"""The results of a voyage: figures, the answer in a sentence, groups of rows, arrays with
units."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from tauto_core.clockwork import SwingTally
from tauto_core.machines import AnyMachine, Machine, OtherRegulator, compile_machine
from tauto_core.motion import propagator_name
from tauto_core.navigation import (
    LEAST_UNCHECKED_DAYS,
    LongitudeTally,
    RatedTime,
    RateError,
    RateScatter,
    grade,
    has_settled,
    projection,
)
from tauto_core.navigation.covariates import assumption, dial_model, expected_walk_per_s
from tauto_core.navigation.drift import has_mean_rate, mean_rate
from tauto_core.samples import (
    ESTIMATE,
    JOINT_STATES,
    PHASE,
    READING,
    SHIP_TEMPERATURE,
    SLACK,
    JointSamples,
    Samples,
    TemperatureSamples,
    TimeSamples,
)
from tauto_core.scene import Scene
from tauto_core.scene.errors import TautoError, install
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.ship.coast import ends_of
from tauto_core.wording import figure, least, significant, span, with_sigma

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset


def drawn_by(module: str, name: str) -> Any:
    """Return a function of `plots` by name, since `plots` imports results and not the reverse."""
    return getattr(import_module(f'tauto_core.plots.{module}'), name)


# -----------------------------------------------------------------------------
# The figures of a voyage, computed from the topics alone, for `tauto sail`, `graph` and `replay`.


class Summary:
    """Collects the figures of a voyage from the samples on all topics."""

    def __init__(self, scene: Scene, machine: AnyMachine | OtherRegulator | None = None) -> None:
        self._scene, self._built = scene, machine
        self._last: dict[str, JointSamples] = {}
        self._first_reading: tuple[int, int] | None = None
        self._last_reading: tuple[int, int] | None = None
        self._scatter: RateScatter | None = None
        self._error: RateError | None = None
        self._air = (math.inf, -math.inf)
        self._slack_s = self._lost_joule = 0.0
        self._rated = RatedTime()
        self._tally = LongitudeTally()
        self._swings = SwingTally(scene, machine)

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take batches of any topics, in order within a topic.

        Observations must not come after longitudes that include them, nor readings after estimates
        at their stamps.
        """
        self._swings.feed(batches)
        self._tally.feed(batches)
        self._rated.feed(batches)
        air = batches.get(SHIP_TEMPERATURE)
        if isinstance(air, TemperatureSamples) and len(air.stamp_ns):
            (low, high), celsius = self._air, air.temperature
            self._air = min(low, float(celsius.min())), max(high, float(celsius.max()))
        for topic, samples in batches.items():
            if not len(samples.stamp_ns):
                continue
            if topic == READING and isinstance(samples, TimeSamples):
                ends = [(int(samples.stamp_ns[i]), int(samples.time_ref_ns[i])) for i in (0, -1)]
                if self._first_reading is None:
                    length_ns = max(self._scene.log_count - 1, 1) * self._scene.log_interval_ns
                    self._first_reading = ends[0]
                    self._scatter = RateScatter(ends[0][0], length_ns)
                self._last_reading = ends[1]
                if self._scatter is not None:
                    self._scatter.feed(samples)
                    self._error = None
            elif isinstance(samples, JointSamples):
                self._last[topic] = samples
                if topic == SLACK:
                    self._slack_s += float(np.sum(samples.position[:, 1]))
                    self._lost_joule += float(np.sum(samples.position[:, 2]))

    def result(self) -> dict[str, Any]:
        """Return all figures, with the scene's name and the answer."""
        figures = {
            'trochlea': self.trochlea(),
            'clock': self.clock(),
            'drift': self.drift(),
            'longitude': self.longitude(),
        }
        sea = sea_of(self._scene) | ends_of(self._scene.voyage, self._scene.duration)
        return {
            'scene': self._scene.name,
            'answer': answer({**figures, **sea}),
            'duration_s': self._scene.duration,
            'propagator': self.propagator,
            **sea,
            **figures,
            **self.air(),
        }

    def air(self) -> dict[str, dict[str, float]]:
        """Return the `air` of a result, the range of the clock's temperature, if known."""
        low, high = self._air
        if low > high:
            return {}
        return {'air': {'lowest_celsius': low, 'highest_celsius': high}}

    def clock(self) -> dict[str, Any]:
        """Return the dial's reading since the start, its error and its mean rate.

        `rate_standard_error_s_per_day` is None if the run alone cannot show it, see `RateScatter`
        and `has_settled`. If the clock stopped, both rates are None.
        """
        error = self._rate_error()
        if self._first_reading is None or self._last_reading is None or error is None:
            return {}
        (_, dial_start), (end, dial_end) = self._first_reading, self._last_reading
        return {
            'reading_s': (dial_end - dial_start) / NS_PER_S,
            'error_s': (dial_end - end) / NS_PER_S,
            'rate_s_per_day': None
            if self._has_stopped
            else _rate(self._first_reading, self._last_reading),
            'rate_standard_error_s_per_day': None
            if self._has_stopped
            else error.standard_error_s_per_day,
        }

    @property
    def _has_stopped(self) -> bool:
        return self._swings.result().get('stopped_s') is not None

    def _rate_error(self) -> RateError | None:
        if self._error is None and self._scatter is not None:
            error = self._scatter.rate_error()
            self._error = has_settled(self._scene, self._machine, error)
        return self._error

    @cached_property
    def _machine(self) -> AnyMachine | OtherRegulator:
        return self._built or compile_machine(self._scene)

    @property
    def propagator(self) -> str:
        """Name of the propagator that runs the scene."""
        return propagator_name(self._machine, still=self._scene.lies_still)

    def trochlea(self) -> dict[str, float | str | None]:
        """Return the regulator's small-amplitude period, its final state, and its swing.

        If small swings have no period, it is the period of the swing as released, as `period_of`
        says. The swing comes from `SwingTally.result`. If the thread was slack, `slacks` is the
        number of times, `slack_s` the total time, `slack_lost_joule` the energy lost in tautening.
        """
        wheel, phase = self._last.get(JOINT_STATES), self._last.get(PHASE)
        if wheel is None or phase is None:
            return {}
        machine = self._machine
        in_fluid = isinstance(machine, OtherRegulator)
        place, speed = ('arc_m', 'speed_m_s') if in_fluid else ('angle_rad', 'rate_rad_s')
        slack: dict[str, float] = {}
        if SLACK in self._last:
            slack = {
                'slacks': round(_named(self._last[SLACK])['slacks']),
                'slack_s': self._slack_s,
                'slack_lost_joule': self._lost_joule,
            }
        grows = isinstance(machine, Machine) and not machine.has_small_swings
        return {
            'period_s': machine.small_period,
            **({'period_of': 'the swing as released'} if grows else {}),
            place: float(wheel.position[-1, 0]),
            speed: float(wheel.velocity[-1, 0]),
            'phase_rad': _named(phase)['phase'],
            'beats': round(_named(phase)['beats']),
            **self._swings.result(),
            **slack,
        }

    def drift(self) -> dict[str, float]:
        """Return the last estimate, and its errors in standard deviations; {} for a stopped clock.

        `offset_error_sigmas` compares the estimated offset with the error of the dial.
        `rate_error_sigmas` compares the estimated rate with `rate_compared_s_per_day`, the mean
        rate of the dial since `rate_compared_from_s` after the first reading: since the start, or
        since the covariance was last inflated (`RatedTime`). With covariates it compares the
        estimated mean of the voyage. The standard deviation includes the random walk of the rate
        about this mean. The three need more than one instant.
        """
        estimate, clock = self._last.get(ESTIMATE), self.clock()
        if estimate is None or self._has_stopped:
            return {}
        values = _named(estimate)
        if clock:
            wrong_s = values['offset_s'] - clock['error_s']
            values['offset_error_sigmas'] = wrong_s / values['offset_sigma_s']
        begin, end = self._first_reading, self._last_reading
        if begin is not None and end is not None and begin != end:
            rate, sigma = mean_rate(values)
            start = (None if has_mean_rate(values) else self._rated.start()) or begin
            true = _rate(start, end)
            # a random walk of density q ends √(qT/3) rms from its mean over T, or
            # √(q(u − u²/T + u³/3T²)) if it begins u before the end
            elapsed_s, model = (end[0] - start[0]) / NS_PER_S, dial_model(self._scene)
            u = model.under_way_s(start[0], end[0])
            variance = expected_walk_per_s(self._scene) * elapsed_s / 3.0
            variance += model.under_way_per_s * (u - u**2 / elapsed_s + u**3 / elapsed_s**2 / 3.0)
            wandered = DAY_S * math.sqrt(variance)
            values['rate_error_sigmas'] = (rate - true) / math.hypot(sigma, wandered)
            values['rate_compared_from_s'] = (start[0] - begin[0]) / NS_PER_S
            values['rate_compared_s_per_day'] = true
        return values

    def longitude(self) -> dict[str, Any]:
        """Return the longitude errors and the prize by the Act of 1714.

        The keys come from `LongitudeTally.result`, `belief_of` and, if the clock was unchecked for
        less than `LEAST_UNCHECKED_DAYS`, `projection`.
        """
        result = self._tally.result()
        if result is None:
            return {}
        result |= belief_of(result, assumption(self._scene))
        clock, estimate, error = self.clock(), self.drift(), self._rate_error()
        if self._has_stopped:
            return {**result, 'projection': [], 'not_projected': 'the clock stopped'}
        tried = result['unchecked_days'] >= LEAST_UNCHECKED_DAYS
        if tried or not clock or not estimate or error is None:
            return {**result, 'projection': [], 'not_projected': None}
        return {
            **result,
            **projection(
                clock['rate_s_per_day'],
                error,
                estimate,
                dial_model(self._scene),
                result['latitude_deg'] or 0.0,
                self._scene.clock.random_walk_fm_per_s,
            ),
        }


def sea_of(scene: Scene) -> dict[str, Any]:
    """Return the `sea` or `weather` of a result, if the ship has one."""
    ship = scene.ship
    return {ship.reported_as: ship.metadata(scene)} if ship.reported_as else {}


def _rate(first: tuple[int, int], last: tuple[int, int]) -> float:
    """Return the gain of a dial between two (stamp, reading) [s/day]; 0 for the same stamp."""
    (start, dial_start), (end, dial_end) = first, last
    elapsed, gained = (end - start) / NS_PER_S, (dial_end - end) - (dial_start - start)
    return gained / NS_PER_S / elapsed * DAY_S if elapsed else 0.0


def _named(samples: JointSamples) -> dict[str, float]:
    """Return the last sample's values by name."""
    values = samples.position[-1].tolist()
    return dict(zip(samples.name, values, strict=True))


# -----------------------------------------------------------------------------
# The answer of a voyage in one sentence.


def answer(result: Mapping[str, Any]) -> str:
    """Return the answer in a sentence, with remarks about damage, landfall, slack and hull."""
    slack, trochlea = '', result.get('trochlea') or {}
    if slacks := trochlea.get('slacks'):
        times = 'once' if slacks == 1 else f'{slacks:,} times'
        slack = f' The thread went slack {times}, for {figure(trochlea["slack_s"], "s")} s in all.'
    cork, sea = '', result.get('sea') or result.get('weather') or {}
    if sea.get('heave') and not sea.keys() & {'hull', 'operator'}:
        cork = (
            ' The ship has no hull: it heaves with the waves, and their sideways half is left '
            'out. ship.hull gives it one.'
        )
    ends = f' The last entry of the log is {result["ends"]}.' if 'ends' in result else ''
    text = f'{_answer(result)}{ends}{slack}{cork}'
    return f'The bag is not whole. {text}' if result.get('damage') else text


def damage_sentence(result: Mapping[str, Any]) -> str:
    """Return a sentence about the damage of the bag of a result, empty if it is whole."""
    damage = result.get('damage')
    if not damage:
        return ''
    remainder = f'; and {len(damage) - 2} more' if len(damage) > 2 else ''
    return f'The bag is not whole: {"; ".join(damage[:2])}{remainder}'


def _answer(result: Mapping[str, Any]) -> str:
    longitude = result.get('longitude') or {}
    trochlea = result.get('trochlea') or {}
    stopped_s = trochlea.get('stopped_s')
    if stopped_s is not None:
        return (
            f'The clock stopped after {span(stopped_s)}: {trochlea["stopped_why"]}, and the '
            'longitude cannot be found from it.'
        )
    raw_nmi = longitude.get('raw_error_nmi')
    if raw_nmi is None:
        return 'The longitude is not known: no reading of the clock could be compared.'
    at_s, unchecked_s = longitude['at_s'], longitude['unchecked_days'] * DAY_S
    if at_s == 0.0:
        when = 'At the start'
    elif unchecked_s == 0.0:
        when = f'After {span(at_s)}, checked to the end,'
    elif unchecked_s == at_s:
        when = f'After {span(at_s)} unchecked'
    else:
        when = f'After {span(at_s)}, the last {span(unchecked_s)} unchecked,'
    is_off = abs(raw_nmi) >= least('nmi')
    place = (
        f'{figure(abs(raw_nmi), "nmi")} nmi {_side(raw_nmi)}'
        if is_off
        else f'within {least("nmi"):g} nmi'
    )
    # the side of the corrected longitude is named if it differs from the dial's
    east_nmi = longitude['error_nmi']
    corrected = f'{with_sigma(abs(east_nmi), longitude["sigma_nmi"], signed=False)} nmi'
    nowhere = not float(corrected.split(maxsplit=1)[0].replace(',', ''))
    if not (nowhere or (is_off and east_nmi * raw_nmi > 0.0)):
        corrected = f'{corrected} {_side(east_nmi)}'
    # a voyage too short for the Act has prize None, not 0
    judged = longitude.get('prize_pounds') is not None
    verdict = f' That is {grade(abs(east_nmi))}.' if judged else ''
    belief = f' {longitude["belief"]}' if 'belief' in longitude else ''
    return (
        f'{when} the dial puts the ship {place} of its true place; rated and corrected, '
        f'{corrected}.{verdict}{belief}'
    )


BELIEVED = 5.0
"""Standard deviations beyond which an error refutes the navigator's model."""


def belief_of(longitude: Mapping[str, Any], assumes: str) -> dict[str, Any]:
    """Return the navigator's assumption about the rate, and whether it holds.

    `assumes` is his assumption. `error_sigmas` is the largest error of the longitude at a landfall
    or the end, in his standard deviations, at `error_sigmas_at_s` [s]. `model_holds` is whether it
    is within `BELIEVED`. `belief` has all this in words.
    """
    judged = [
        (abs(row['error_nmi']) / row['sigma_nmi'], row['at_s'])
        for row in (*longitude['landfalls'], longitude)
        if row['sigma_nmi']
    ]
    sigmas, at_s = max(judged, default=(0.0, longitude['at_s']))
    holds = sigmas <= BELIEVED
    belief = f"The ± is the navigator's, who expects {assumes}."
    if not holds:
        when = f' after {span(at_s)}' if at_s != longitude['at_s'] else ''
        equation = '' if 'follow' in assumes else 'the rate equation (drift.covariates), '
        belief += (
            f' His model does not hold: the error was {significant(sigmas, 2)} of his standard '
            f'deviations{when}. Remedies: {equation}a rate that wanders (drift.random_walk_fm), '
            'or a fix at sea (drift.lunars).'
        )
    return {
        'assumes': assumes,
        'error_sigmas': sigmas,
        'error_sigmas_at_s': at_s,
        'model_holds': holds,
        'belief': belief,
    }


def _side(east_nmi: float) -> str:
    return 'east' if east_nmi > 0.0 else 'west'


# -----------------------------------------------------------------------------
# The figures of a voyage in groups of rows, as the terminal and the report print them.

_Section: TypeAlias = Mapping[str, Any]
# Label, value, unit.
_Row: TypeAlias = tuple[str, str, str]

SIGNS = (
    'Signs: + is a fast clock, and a place to the east. A slow clock puts the ship east. ± and σ '
    "are standard deviations: for estimated and corrected figures by the navigator's observations "
    'and model, for the dial by the slowest changes of its rate during the run. Both projections '
    'include the latter. An error in σ is (estimate − truth)/σ. The truth is the error of the '
    'dial, or its mean rate over the time in the row.'
)


def groups(result: _Section) -> list[tuple[str, list[_Row]]]:
    """Return the name and rows of each group for which a result has a section."""
    return [
        (name, rows(content))
        for name, section, rows in _GROUPS
        if (content := result.get(section))
    ]


def budget_rows(budget: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """Return the rows of a budget (`Budget.facts`) as text: cause, rate, miles, on land or sea."""
    rows = []
    for row in (*budget['rows'], budget['sum'], budget['interaction'], budget['whole']):
        east, rate, sigma = row['east_nmi'], row['rate_s_per_day'], row['sigma_s_per_day']
        # a sigma below 0.001 s/day is not shown
        fine = not sigma or sigma < least('s/day')
        rate_text = figure(rate, 's/day', signed=True) if fine else with_sigma(rate, sigma)
        miles = f'{figure(abs(east), "nmi")} {_side(east)}' if east else '0'
        where = {'land': 'on land', 'sea': 'at sea'}[row['found']]
        rows.append((row['cause'], rate_text, miles, where))
    return rows


def _hull_row(sea: _Section) -> list[_Row]:
    return [('hull', str(sea['hull']), '')] if 'hull' in sea else []


def _weather_rows(weather: _Section) -> list[_Row]:
    return [
        *_hull_row(weather),
        ('states of the sea', f'{len(weather["states"])}', ''),
        ('significant wave height, median', significant(weather['median_m']), 'm'),
        ('significant wave height, highest', significant(weather['highest_m']), 'm'),
    ]


def _sea_rows(sea: _Section) -> list[_Row]:
    return [
        ('spectrum', str(sea['spectrum']), ''),
        ('significant wave height', significant(sea['significant_wave_height_m']), 'm'),
        ('peak period', significant(sea['peak_period_s']), 's'),
        ('waves run, off the bow', significant(math.degrees(sea['heading_rad'])), '°'),
        ('speed of the ship', significant(sea['speed_m_s']), 'm/s'),
        *_hull_row(sea),
        ('seed', str(sea['seed']), ''),
    ]


def _accuracy_rows(accuracy: _Section) -> list[_Row]:
    bound = accuracy['bound_s_per_day']
    return [
        ('asked for', f'{accuracy["asked_s_per_day"]:g}', 's/day'),
        ('bound of its error', 'not known' if bound is None else f'{bound:.1g}', 's/day'),
    ]


def _regulator_rows(trochlea: _Section) -> list[_Row]:
    of = trochlea.get('period_of', 'small swings')
    rows = [(f'period of {of}', significant(trochlea['period_s'], 4), 's')]
    if 'amplitude_rad' in trochlea:
        rows.append(('amplitude at the end', significant(trochlea['amplitude_rad']), 'rad'))
    if trochlea.get('slacks'):
        rows.append(('thread slack', f'{trochlea["slacks"]:,}', 'times'))
        rows.append(('slack in all', figure(trochlea['slack_s'], 's'), 's'))
    if trochlea.get('stopped_s') is not None:
        rows.append(('stopped after', figure(trochlea['stopped_s'], 's'), 's'))
    return rows


_COEFFICIENT = '_coefficient'


def _clock_rows(clock: _Section) -> list[_Row]:
    rows = [('error of the dial', figure(clock['error_s'], 's', signed=True), 's')]
    if clock['rate_s_per_day'] is not None:
        rows.append(('rate', figure(clock['rate_s_per_day'], 's/day', signed=True), 's/day'))
    return rows


def _drift_rows(drift: _Section) -> list[_Row]:
    """Return the estimate and, if known, its errors in standard deviations."""
    rows = [
        ('offset', _with_sigma(drift, 'offset_s', 'offset_sigma_s'), 's'),
        ('rate', _with_sigma(drift, 'rate_s_per_day', 'rate_sigma_s_per_day'), 's/day'),
    ]
    if 'mean_rate_s_per_day' in drift:
        rows[1] = ('rate, ship at rest', *rows[1][1:])
        mean = _with_sigma(drift, 'mean_rate_s_per_day', 'mean_rate_sigma_s_per_day')
        rows.append(('rate, mean of the voyage', mean, 's/day'))
    rows += [
        (
            f'coefficient of {key[: -len(_COEFFICIENT)]}',
            _with_sigma(drift, key, f'{key}_sigma'),
            '',
        )
        for key in drift
        if key.endswith(_COEFFICIENT)
    ]
    if 'offset_error_sigmas' in drift:
        rows.append(_sigmas('error of the offset', drift['offset_error_sigmas']))
    if 'rate_error_sigmas' in drift:
        since_s = drift['rate_compared_from_s']
        of = 'of the run' if since_s == 0.0 else f'after {span(since_s)}'
        of = 'of the voyage' if 'mean_rate_s_per_day' in drift else of
        rows.append(_sigmas(f'error of the rate, mean {of}', drift['rate_error_sigmas']))
    return rows


def _sigmas(label: str, error: float) -> _Row:
    return label, significant(error, 2, signed=True), 'σ'


def _longitude_rows(longitude: _Section) -> list[_Row]:
    """Return the errors at the end, and the largest since the ship left port."""
    rows = [
        ('by the dial', figure(longitude['raw_error_nmi'], 'nmi', signed=True), 'nmi'),
        ('corrected', _with_sigma(longitude, 'error_nmi', 'sigma_nmi'), 'nmi'),
    ]
    if 'worst_since_s' not in longitude:
        return rows
    since_s = longitude['worst_since_s']
    since = 'of the run' if since_s == 0.0 else f'after {span(since_s)}'
    return rows + [
        (
            f'worst {since}, {clock}, at {span(longitude[f"worst_{prefix}at_s"])}',
            figure(longitude[f'worst_{prefix}error_nmi'], 'nmi'),
            'nmi',
        )
        for clock, prefix in (('by the dial', 'raw_'), ('corrected', ''))
    ]


def _verdict_rows(longitude: _Section) -> list[_Row]:
    """Return the prizes by the Act of 1714, or for a shorter voyage the projected errors."""
    rows = []
    if longitude.get('prize_pounds') is None:
        rows.append(('none: unchecked for less than six weeks', '', ''))
        for row in longitude.get('projection') or []:
            days = f'projected to {row["days"]:g} days unchecked'
            for clock, prefix in (('by the dial', 'raw_'), ('corrected', '')):
                if row[f'{prefix}error_nmi'] is not None:
                    error = _with_sigma(row, f'{prefix}error_nmi', f'{prefix}sigma_nmi')
                    rows.append((f'{days}, {clock}', error, 'nmi'))
        if reason := longitude.get('not_projected'):
            rows.append((reason, '', ''))
        return rows
    where = 'landfall' if longitude['landfalls'] else 'the end'
    for landfall in (longitude['landfalls'] or [longitude])[:-1]:
        rows += _prize_rows(landfall, f'landfall after {span(landfall["at_s"])}')
    return rows + _prize_rows(longitude, f'{where} after {span(longitude["at_s"])}')


def _prize_rows(judged: _Section, where: str) -> list[_Row]:
    return [
        (f'{where}, {clock}', f'{judged[prize]:,}', '£')
        for clock, prize in (('corrected', 'prize_pounds'), ('by the dial', 'raw_prize_pounds'))
        if judged[prize] is not None
    ]


def _with_sigma(section: _Section, value: str, sigma: str) -> str:
    return with_sigma(section[value], section[sigma])


# Groups in their order: name, section of the result, function that makes the rows.
_GROUPS: tuple[tuple[str, str, Callable[[Any], list[_Row]]], ...] = (
    ('sea', 'sea', _sea_rows),
    ('weather', 'weather', _weather_rows),
    ('regulator', 'trochlea', _regulator_rows),
    ('clock', 'clock', _clock_rows),
    ('drift, estimated ± its standard deviation', 'drift', _drift_rows),
    ('longitude, error', 'longitude', _longitude_rows),
    ('verdict of the Act of 1714', 'longitude', _verdict_rows),
    ('accuracy of the simulation', 'accuracy', _accuracy_rows),
    ('messages', 'counts', lambda counts: [(t, f'{n:,}', '') for t, n in counts.items()]),
)


# -----------------------------------------------------------------------------
# The arrays of a voyage as a dataset of xarray or a frame of pandas.

LOGGED = (
    'time_s', 'clock_error_s', 'corrected_error_s', 'estimated_error_s', 'estimated_error_sigma_s',
    'estimated_rate_s_per_day', 'estimated_rate_sigma_s_per_day', 'estimated_mean_rate_s_per_day',
    'estimated_mean_rate_sigma_s_per_day', 'angle_rad', 'angular_velocity_rad_s', 'phase_rad',
    'raw_longitude_error_nmi', 'longitude_error_nmi', 'longitude_sigma_nmi', 'latitude_deg',
    'longitude_deg', 'clock_longitude_deg', 'temperature_celsius', 'roll_rad',
)  # fmt: skip
"""Names of the arrays on the log grid, time first."""

OBSERVED = ('observation_time_s', 'observed_error_s')
"""The same for arrays with a value for each observation."""

MOTION = ('motion_time_s', 'motion_roll_rad', 'motion_gravity_m_s2')
"""The same for arrays with a value for each sample of the ship's motion."""

_NAME = re.compile('(.*?)_(s|s_per_day|rad|rad_s|nmi|celsius|m_s2|deg)')
_UNITS = {
    's_per_day': 's/day', 'rad_s': 'rad/s', 'nmi': 'nautical_mile', 'celsius': 'degC',
    'm_s2': 'm/s2',
}  # fmt: skip
_ON_A_CURVE = {
    'angle_rad': {'units': 'm', 'long_name': 'arc'},
    'angular_velocity_rad_s': {'units': 'm/s', 'long_name': 'speed'},
}
"""Attributes of two arrays of a regulator without a wheel."""


def attributes(voyage: Any, name: str) -> dict[str, str]:
    """Return `units` (UDUNITS, as in the CF conventions) and `long_name` of an array."""
    if voyage.scene.regulator is not None and name in _ON_A_CURVE:
        return _ON_A_CURVE[name]
    match = _NAME.fullmatch(name)
    assert match is not None
    words, unit = match.groups()
    if unit == 'deg':
        unit = 'degrees_north' if words == 'latitude' else 'degrees_east'
    return {'units': _UNITS.get(unit, unit), 'long_name': words.replace('_', ' ')}


def dataset(voyage: Any) -> Dataset:
    """Return the arrays of a voyage as a dataset, see `Voyage.to_xarray`."""
    try:
        import xarray
    except ModuleNotFoundError:
        raise TautoError(f'xarray is not installed. Run {install("arrays")}') from None
    arrays: dict[str, Any] = {}
    for table in (LOGGED, OBSERVED, MOTION):
        for name in table:
            values = getattr(voyage, name)
            if len(values):
                arrays[name] = table[0], values, attributes(voyage, name)
    return xarray.Dataset(arrays, attrs={'scene': voyage.scene.name, 'answer': voyage.answer})


def frame(voyage: Any) -> DataFrame:
    """Return the logged arrays of a voyage as a frame, see `Voyage.to_pandas`."""
    data = dataset(voyage)
    logged = [name for name in LOGGED if name in data.variables]
    table = data[logged[1:]].to_dataframe()
    table.attrs = {**data.attrs, 'units': {name: data[name].attrs['units'] for name in logged}}
    return table
