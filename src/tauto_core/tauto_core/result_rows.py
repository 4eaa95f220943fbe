"""The figures of a voyage in groups of rows, as the terminal and the report print them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from tauto_core.wording import figure, significant, span, to_sigma, with_sigma

Section: TypeAlias = Mapping[str, Any]
Row: TypeAlias = tuple[str, str, str]
"""Label, value, unit."""

SIGNS = (
    'Signs: + is a fast clock, and a place to the east. A slow clock puts the ship east. ± and σ '
    'are standard deviations. Those of estimated and corrected figures are as the navigator knows '
    'them, who sees the observations alone; that of the dial is from the slowest changes of its '
    'rate during the run, and counts in both projections. An error in σ is the estimate less the '
    'truth, over the standard deviation; the truth is the error of the dial, and its mean rate '
    'over the time that the row names.'
)


def groups(result: Section) -> list[tuple[str, list[Row]]]:
    """Return the groups of a result: name and rows; those without a section are left out."""
    return [
        (name, rows(content))
        for name, section, rows in _GROUPS
        if (content := result.get(section))
    ]


def _weather_rows(weather: Section) -> list[Row]:
    return [
        ('states of the sea', f'{len(weather["states"])}', ''),
        ('significant wave height, median', significant(weather['median_m']), 'm'),
        ('significant wave height, highest', significant(weather['highest_m']), 'm'),
    ]


def _sea_rows(sea: Section) -> list[Row]:
    return [
        ('spectrum', str(sea['spectrum']), ''),
        ('significant wave height', significant(sea['significant_wave_height_m']), 'm'),
        ('peak period', significant(sea['peak_period_s']), 's'),
        ('waves run, off the bow', significant(math.degrees(sea['heading_rad'])), '°'),
        ('speed of the ship', significant(sea['speed_m_s']), 'm/s'),
        ('seed', str(sea['seed']), ''),
    ]


def _regulator_rows(trochlea: Section) -> list[Row]:
    rows = [('period of small swings', significant(trochlea['period_s'], 4), 's')]
    if 'amplitude_rad' in trochlea:
        rows.append(('amplitude at the end', significant(trochlea['amplitude_rad']), 'rad'))
    if trochlea.get('stopped_s') is not None:
        rows.append(('stopped after', figure(trochlea['stopped_s'], 's'), 's'))
    return rows


_COEFFICIENT = '_coefficient'


def _clock_rows(clock: Section) -> list[Row]:
    return [
        ('error of the dial', figure(clock['error_s'], 's', signed=True), 's'),
        ('rate', figure(clock['rate_s_per_day'], 's/day', signed=True), 's/day'),
    ]


def _drift_rows(drift: Section) -> list[Row]:
    """Return the estimate, and where both are known its errors in standard deviations."""
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
        rows += _rate_error_rows(drift)
    return rows


def _rate_error_rows(drift: Section) -> list[Row]:
    """Return the error of the estimated rate, and with which mean rate of the dial it compares."""
    if 'mean_rate_s_per_day' in drift:
        return [_sigmas('error of the rate, mean of the voyage', drift['rate_error_sigmas'])]
    since_s = drift['rate_compared_from_s']
    if since_s == 0.0:
        return [_sigmas('error of the rate, mean of the run', drift['rate_error_sigmas'])]
    # The rate of the clock's group is the mean of the whole run, so that this one must be shown.
    since = f'after {span(since_s)}'
    true = to_sigma(drift['rate_compared_s_per_day'], drift['rate_sigma_s_per_day'], signed=True)
    return [
        (f'rate of the dial, mean {since}', true, 's/day'),
        _sigmas(f'error of the rate, mean {since}', drift['rate_error_sigmas']),
    ]


def _sigmas(label: str, error: float) -> Row:
    return label, significant(error, 2, signed=True), 'σ'


def _longitude_rows(longitude: Section) -> list[Row]:
    return [
        ('by the dial', figure(longitude['raw_error_nmi'], 'nmi', signed=True), 'nmi'),
        ('corrected', _with_sigma(longitude, 'error_nmi', 'sigma_nmi'), 'nmi'),
        *_worst_rows(longitude),
    ]


def _worst_rows(longitude: Section) -> list[Row]:
    """Return the largest errors since she left port, before which the clock was being rated."""
    if 'worst_since_s' not in longitude:
        return []
    since_s = longitude['worst_since_s']
    since = 'of the run' if since_s == 0.0 else f'after {span(since_s)}'
    return [
        (
            f'worst {since}, {clock}, at {span(longitude[f"worst_{prefix}at_s"])}',
            figure(longitude[f'worst_{prefix}error_nmi'], 'nmi'),
            'nmi',
        )
        for clock, prefix in (('by the dial', 'raw_'), ('corrected', ''))
    ]


def _verdict_rows(longitude: Section) -> list[Row]:
    """Return what the Act of 1714 pays; for a shorter voyage that it pays nothing, and the
    projected errors.
    """
    if longitude.get('prize_pounds') is None:
        none = ('none: unchecked for less than six weeks', '', '')
        return [none, *_projection_rows(longitude)]
    where = 'landfall' if longitude['landfalls'] else 'the end'
    rows = []
    for landfall in (longitude['landfalls'] or [longitude])[:-1]:
        rows += _prize_rows(landfall, f'landfall after {span(landfall["at_s"])}')
    return rows + _prize_rows(longitude, f'{where} after {span(longitude["at_s"])}')


def _prize_rows(judged: Section, where: str) -> list[Row]:
    return [
        (f'{where}, {clock}', f'{judged[prize]:,}', '£')
        for clock, prize in (('corrected', 'prize_pounds'), ('by the dial', 'raw_prize_pounds'))
        if judged[prize] is not None
    ]


def _projection_rows(longitude: Section) -> list[Row]:
    rows = []
    for row in longitude.get('projection') or []:
        days = f'projected to {row["days"]:g} days unchecked'
        rows += [
            (
                f'{days}, {clock}',
                _with_sigma(row, f'{prefix}error_nmi', f'{prefix}sigma_nmi'),
                'nmi',
            )
            for clock, prefix in (('by the dial', 'raw_'), ('corrected', ''))
            if row[f'{prefix}error_nmi'] is not None
        ]
    reason = longitude.get('not_projected')
    return [*rows, (reason, '', '')] if reason else rows


def _count_rows(counts: Section) -> list[Row]:
    return [(topic, f'{messages:,}', '') for topic, messages in counts.items()]


def _with_sigma(section: Section, value: str, sigma: str) -> str:
    return with_sigma(section[value], section[sigma])


_GROUPS: tuple[tuple[str, str, Callable[[Any], list[Row]]], ...] = (
    ('sea', 'sea', _sea_rows),
    ('weather', 'weather', _weather_rows),
    ('regulator', 'trochlea', _regulator_rows),
    ('clock', 'clock', _clock_rows),
    ('drift, estimated ± its standard deviation', 'drift', _drift_rows),
    ('longitude, error', 'longitude', _longitude_rows),
    ('verdict of the Act of 1714', 'longitude', _verdict_rows),
    ('messages', 'counts', _count_rows),
)
"""The groups in the order of the page: name, section of the result, function for the rows."""
