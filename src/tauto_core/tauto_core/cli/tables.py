"""Results as tables to read: what a voyage or a bag says of the clock."""

from __future__ import annotations

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


def _rows(result: Section) -> list[tuple[str, str]]:
    rows = []
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

    prize = longitude['prize_pounds']
    return [
        ('longitude error, raw', error('raw_error')),
        ('longitude error, corrected', error('error')),
        ('its sigma', _number(longitude['sigma_nmi'], '.4f', 'nmi')),
        ('the Act of 1714 pays', '–' if prize is None else f'£{prize:,}'),
    ]


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
