"""The figures of a voyage in groups of rows, as the terminal and the report print them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from tauto_core.wording import significant, span

Section: TypeAlias = Mapping[str, Any]
Row: TypeAlias = tuple[str, str, str]
"""Label, value, unit."""

SIGNS = (
    'Signs: + is a fast clock, and a place to the east. A slow clock puts the ship east. ± and σ '
    'are standard deviations. Those of estimated and corrected figures are as the navigator knows '
    'them, who sees the observations alone; that of the dial is from the scatter of its rate in '
    'ten parts of the run. An error in σ is the estimate less the truth, over the standard '
    'deviation; the true rate is the mean rate of the dial.'
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
        ('significant wave height', significant(sea['significant_wave_height_m'], 3), 'm'),
        ('peak period', significant(sea['peak_period_s'], 3), 's'),
        ('waves run, off the bow', significant(math.degrees(sea['heading_rad']), 3), '°'),
        ('speed of the ship', significant(sea['speed_m_s'], 3), 'm/s'),
        ('seed', str(sea['seed']), ''),
    ]


def _regulator_rows(trochlea: Section) -> list[Row]:
    rows = [('period of small swings', significant(trochlea['period_s']), 's')]
    if 'amplitude_rad' in trochlea:
        rows.append(('amplitude at the end', significant(trochlea['amplitude_rad']), 'rad'))
    if trochlea.get('stopped_s') is not None:
        rows.append(('stopped after', significant(trochlea['stopped_s']), 's'))
    return rows


_COEFFICIENT = '_coefficient'


def _clock_rows(clock: Section) -> list[Row]:
    return [
        ('error of the dial', significant(clock['error_s'], signed=True), 's'),
        ('rate', significant(clock['rate_s_per_day'], signed=True), 's/day'),
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
    of_rate = 'rate, mean of the voyage' if 'mean_rate_s_per_day' in drift else 'rate'
    wrong = {
        'offset': drift.get('offset_error_sigmas'),
        of_rate: drift.get('rate_error_sigmas'),
    }
    rows += [
        (f'error of the {name}', significant(value, 3, signed=True), 'σ')
        for name, value in wrong.items()
        if value is not None
    ]
    return rows


def _longitude_rows(longitude: Section) -> list[Row]:
    return [
        ('by the dial', significant(longitude['raw_error_nmi'], signed=True), 'nmi'),
        ('corrected', _with_sigma(longitude, 'error_nmi', 'sigma_nmi'), 'nmi'),
        *_worst_rows(longitude),
    ]


def _worst_rows(longitude: Section) -> list[Row]:
    """Return the largest errors on the way."""
    return [
        (
            f'worst, {clock}, after {span(longitude[f"worst_{prefix}at_s"])}',
            significant(longitude[f'worst_{prefix}error_nmi']),
            'nmi',
        )
        for clock, prefix in (('by the dial', 'raw_'), ('corrected', ''))
        if f'worst_{prefix}at_s' in longitude
    ]


def _verdict_rows(longitude: Section) -> list[Row]:
    """Return what the Act of 1714 pays; for a shorter voyage the projected errors."""
    if longitude.get('prize_pounds') is None:
        return _projection_rows(longitude.get('projection') or [])
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


def _projection_rows(projected: list[Section]) -> list[Row]:
    rows = []
    for row in projected:
        days = f'projected to {row["days"]:g} days unchecked'
        rows += [
            (f'{days}, by the dial', _with_sigma(row, 'raw_error_nmi', 'raw_sigma_nmi'), 'nmi'),
            (f'{days}, corrected', _with_sigma(row, 'error_nmi', 'sigma_nmi'), 'nmi'),
        ]
    return rows


def _count_rows(counts: Section) -> list[Row]:
    return [(topic, f'{messages:,}', '') for topic, messages in counts.items()]


def _with_sigma(section: Section, value: str, sigma: str) -> str:
    said = significant(section[value], signed=True)
    return said if section[sigma] is None else f'{said} ± {significant(section[sigma], 3)}'


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
