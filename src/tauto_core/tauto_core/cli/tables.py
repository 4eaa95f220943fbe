"""Results to read on a terminal: the answer in a sentence, then the figures in groups."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from rich.console import Group
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from tauto_core.answer import answer
from tauto_core.wording import significant, span

if TYPE_CHECKING:
    from rich.console import RenderableType

Section = Mapping[str, Any]
Row = tuple[str, str, str]
"""Label, value, unit."""

SIGNS = 'Signs: + is a fast clock and a place to the east. A slow clock puts the ship east.'


def voyage_table(result: Section) -> RenderableType:
    """Return what a voyage says: the answer, then a table in groups, then where the bag is.

    Args:
        result: what `voyage.sail` and `tauto graph` return; groups whose section is absent or
            empty are left out.
    """
    seconds = result.get('duration_s')
    title = str(result.get('scene') or 'bag')
    parts: list[RenderableType] = [
        Text(title if seconds is None else f'{title}: {span(seconds)}', style='italic'),
        Text(answer(result), style='bold'),
        Padding(_grouped(result), (1, 0)),
        Text(SIGNS),
    ]
    if bag := result.get('bag'):
        parts.append(Text(f'Bag: {bag}', no_wrap=True, overflow='ignore'))
    return Group(*parts)


def _grouped(result: Section) -> Table:
    table = Table.grid(padding=(0, 2, 0, 0))
    table.add_column(no_wrap=True)
    table.add_column(justify='right', no_wrap=True)
    table.add_column(no_wrap=True)
    for name, section, rows in _GROUPS:
        if content := result.get(section):
            table.add_row(Text(name, style='bold'))
            for label, value, unit in rows(content):
                table.add_row(f'  {label}', value, unit)
    return table


def sea_words(sea: Section) -> str:
    """Return what a ship's sea is (`ship.sea_metadata`) in a line."""
    said = (
        f'{sea.get("source", sea["spectrum"])}, Hs {sea["significant_wave_height_m"]:.3g} m, '
        f'Tp {sea["peak_period_s"]:.3g} s, seed {sea["seed"]}'
    )
    heading, speed = math.degrees(sea['heading_rad']), sea['speed_m_s']
    return f'{said}; waves {heading:.4g}° off following, speed {speed:g} m/s'


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


def _clock_rows(clock: Section) -> list[Row]:
    return [
        ('error of the dial', significant(clock['error_s'], signed=True), 's'),
        ('rate', significant(clock['rate_s_per_day'], signed=True), 's/day'),
    ]


def _drift_rows(drift: Section) -> list[Row]:
    return [
        ('offset', _with_sigma(drift, 'offset_s', 'offset_sigma_s'), 's'),
        ('rate', _with_sigma(drift, 'rate_s_per_day', 'rate_sigma_s_per_day'), 's/day'),
    ]


def _longitude_rows(longitude: Section) -> list[Row]:
    return [
        ('by the dial', significant(longitude['raw_error_nmi'], signed=True), 'nmi'),
        ('corrected', _with_sigma(longitude, 'error_nmi', 'sigma_nmi'), 'nmi'),
        *_worst_rows(longitude),
    ]


def _worst_rows(longitude: Section) -> list[Row]:
    """Return the worst moments on the way."""
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
    """Return what the Act of 1714 pays; or what a voyage too short for it projects to."""
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
            (f'{days}, by the dial', significant(row['raw_error_nmi'], signed=True), 'nmi'),
            (f'{days}, corrected', _with_sigma(row, 'error_nmi', 'sigma_nmi'), 'nmi'),
        ]
    return rows


def _count_rows(counts: Section) -> list[Row]:
    return [(topic, f'{messages:,}', '') for topic, messages in counts.items()]


def _with_sigma(section: Section, value: str, sigma: str) -> str:
    return f'{significant(section[value], signed=True)} ± {significant(section[sigma], 3)}'


_GROUPS: tuple[tuple[str, str, Callable[[Any], list[Row]]], ...] = (
    ('sea', 'sea', _sea_rows),
    ('regulator', 'trochlea', _regulator_rows),
    ('clock', 'clock', _clock_rows),
    ('drift, estimated ± its standard deviation', 'drift', _drift_rows),
    ('longitude, error', 'longitude', _longitude_rows),
    ('verdict of the Act of 1714', 'longitude', _verdict_rows),
    ('messages', 'counts', _count_rows),
)
"""In the order of the page: name, section of the result, and its rows."""
