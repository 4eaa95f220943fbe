"""Results as tables to read: what a voyage or a bag says of the clock."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rich.table import Table

Section = Mapping[str, Any]


def voyage_table(result: Section) -> Table:
    """Return the table of a voyage.

    Args:
        result: what `voyage.sail` and `tauto graph` return; of its sections `clock`, `drift` and
            `longitude`, those absent or None give no rows.
    """
    seconds = result.get('duration_s')
    title = str(result.get('scene') or 'bag')
    table = Table(
        title=title if seconds is None else f'{title}: {span(seconds)}',
        title_justify='left',
        show_header=False,
    )
    table.add_column()
    table.add_column(justify='right')
    for label, value in _rows(result):
        table.add_row(label, value)
    return table


def replay_table(result: Section) -> Table:
    """Return the table of a replay: that of the voyage, and how many messages the bag holds."""
    table = voyage_table(result)
    for topic, messages in (result.get('counts') or {}).items():
        table.add_row(f'messages on {topic}', f'{messages:,}')
    return table


def span(seconds: float, digits: int = 4) -> str:
    """Return a duration [s] in the unit a reader would use, to so many digits."""
    units = ((86_400.0, 'days'), (3_600.0, 'hours'), (60.0, 'minutes'), (0.0, 'seconds'))
    size, unit = next(each for each in units if seconds >= 2.0 * each[0])
    rounded = float(f'{seconds / (size or 1.0):.{digits}g}')
    return f'{rounded:g} {unit}'


def sea_words(sea: Section) -> str:
    """Return what a ship's sea is (`ship.sea_metadata`) in a line."""
    said = (
        f'{sea.get("source", sea["spectrum"])}, Hs {sea["significant_wave_height_m"]:.3g} m, '
        f'Tp {sea["peak_period_s"]:.3g} s, seed {sea["seed"]}'
    )
    heading, speed = math.degrees(sea['heading_rad']), sea['speed_m_s']
    return f'{said}; waves {heading:.4g}° off following, speed {speed:g} m/s'


def _rows(result: Section) -> list[tuple[str, str]]:
    rows = []
    if sea := result.get('sea'):
        rows.append(('sea', sea_words(sea)))
    if trochlea := result.get('trochlea'):
        rows += _trochlea_rows(trochlea)
    if clock := result.get('clock'):
        rows += [
            ('clock error', _side(clock['error_s'], '.6f', 's', 'fast', 'slow')),
            ('clock rate', _number(clock['rate_s_per_day'], '+.6f', 's/day')),
        ]
    if drift := result.get('drift'):
        rows += [
            ('drift: offset estimated', _estimate(drift, 'offset', 's', '')),
            ('drift: rate estimated', _estimate(drift, 'rate', 's_per_day', 's/day')),
        ]
    if longitude := result.get('longitude'):
        rows += _longitude_rows(longitude)
    if bag := result.get('bag'):
        rows.append(('bag', str(bag)))
    return rows


def _trochlea_rows(trochlea: Section) -> list[tuple[str, str]]:
    rows = [('period of the trochlea', _number(trochlea['period_s'], '.9f', 's'))]
    if 'amplitude_rad' in trochlea:
        rows.append(('amplitude at the end', _number(trochlea['amplitude_rad'], '.6f', 'rad')))
    if trochlea.get('stopped_s') is not None:
        rows.append(('the clock stopped', f'after {trochlea["stopped_s"]:.9g} s'))
    return rows


def _longitude_rows(longitude: Section) -> list[tuple[str, str]]:
    def error(prefix: str) -> str:
        minutes = _number(_size(longitude[f'{prefix}_arcmin']), '.4f', 'arcmin')
        miles = _side(longitude[f'{prefix}_nmi'], '.4f', 'nmi', 'east', 'west')
        return f'{minutes} = {miles}'

    rows = [
        ('longitude error, raw', error('raw_error')),
        ('longitude error, corrected', error('error')),
        ('its sigma', _number(longitude['sigma_nmi'], '.4f', 'nmi')),
        ('the Act of 1714 pays', _pounds(longitude['prize_pounds'])),
    ]
    return rows + _verdict_rows(longitude) if 'at_s' in longitude else rows


def _verdict_rows(longitude: Section) -> list[tuple[str, str]]:
    """Return when the longitude was judged, what the dial alone earns, and the worst moments."""
    *before, _ = longitude['landfalls'] or [None]
    rows = [
        ('… for the raw clock', _pounds(longitude['raw_prize_pounds'])),
        ('judged', ('at the landfall, ' if longitude['landfalls'] else '') + _after(longitude)),
    ]
    for label, prefix in (('raw', 'raw_'), ('corrected', '')):
        found = {name: longitude[f'worst_{prefix}{name}'] for name in ('error_nmi', 'at_s')}
        paid = _pounds(longitude[f'worst_{prefix}prize_pounds'])
        said = f'{found["error_nmi"]:.4f} nmi {_after(found)}: {paid}'
        rows.append((f'worst on the way, {label}', said))
    for landfall in before:
        raw, corrected = (
            f'{abs(landfall[f"{prefix}error_nmi"]):.4f} nmi: '
            f'{_pounds(landfall[f"{prefix}prize_pounds"])}'
            for prefix in ('raw_', '')
        )
        rows.append((f'landfall {_after(landfall)}', f'raw {raw}; corrected {corrected}'))
    if (rate := longitude['required_rate_s_per_day']) is not None:
        unchecked = span(longitude['unchecked_days'] * 86_400.0)
        rows.append((f'rate for £20,000 after {unchecked} unchecked', f'within {rate:.3f} s/day'))
    return rows


def _after(moment: Section) -> str:
    return f'after {span(moment["at_s"])}'


def _pounds(prize: int | None) -> str:
    return '–' if prize is None else f'£{prize:,}'


def _size(value: float | None) -> float | None:
    return None if value is None else abs(value)


def _number(value: float | None, form: str, unit: str) -> str:
    return '–' if value is None else f'{value:{form}} {unit}'


def _side(value: float | None, form: str, unit: str, positive: str, negative: str) -> str:
    """Return a signed quantity as a size and a side; none where it rounds to zero."""
    if value is None:
        return '–'
    size = f'{abs(value):{form}}'
    side = '' if float(size) == 0.0 else f' {positive if value > 0.0 else negative}'
    return f'{size} {unit}{side}'


def _estimate(drift: Section, what: str, suffix: str, unit: str) -> str:
    unit = unit or suffix
    value = _number(drift[f'{what}_{suffix}'], '+.6f', '')
    return f'{value}± {_number(drift[f"{what}_sigma_{suffix}"], ".6f", unit)}'
