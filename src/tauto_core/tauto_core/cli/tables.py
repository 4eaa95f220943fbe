"""Results as tables to read on a terminal; imported when one is printed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console, ConsoleOptions, Group, RenderResult
from rich.measure import Measurement
from rich.padding import Padding
from rich.table import Column, Table
from rich.text import Text

from tauto_core.results import SIGNS, answer, groups
from tauto_core.wording import figure, printed, span, with_sigma

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table


# -----------------------------------------------------------------------------
# A table that a narrow terminal does not cut: half a figure would be read as another.

_ANY_WIDTH = 10_000


class WholeTable(Table):
    """A table in which columns with `no_wrap` stay as wide as what they hold.

    Other columns wrap between words, or within those too long if their overflow is `fold`. Where
    that is not enough, the table is wider than the terminal, which breaks its lines.
    """

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Render the table once the columns know how wide they have to be."""
        roomy = options.update(max_width=_ANY_WIDTH)
        for column in self.columns:
            column.min_width = _narrowest(column, console, roomy)
        if all(column.min_width for column in self.columns):
            needed = Measurement.get(console, roomy, self).minimum
            options = options.update(max_width=max(options.max_width, needed))
        yield from super().__rich_console__(console, options)


def _narrowest(column: Column, console: Console, options: ConsoleOptions) -> int | None:
    """Return the width below which a column would be cut; None if it never is."""
    if column.overflow == 'fold' and not column.no_wrap:
        return None
    cells = [column.header, *column.cells]
    widths = [Measurement.get(console, options, cell) for cell in cells if cell]
    return max((each.maximum if column.no_wrap else each.minimum for each in widths), default=None)


Section = Mapping[str, Any]

_SENTENCE = 43
"""Width of the longest label; a sentence in place of a figure is broken there, since it would
push all figures to the right.
"""


def voyage_table(result: Section) -> RenderableType:
    """Return a voyage as text: the answer, a table in groups, and the place of the bag.

    Args:
        result: what `voyage.sail` and `tauto graph` return; groups whose section is absent or
            empty are left out.
    """
    seconds = result.get('duration_s')
    title = str(result.get('scene') or 'bag')
    parts: list[RenderableType] = [
        Text(title if seconds is None else f'{title}: {span(seconds)}', style='italic'),
        Text(answer(result), style='bold'),
        Text(''),
        _grouped(result),  # a padding around it would cut it
        Text(''),
        Text(SIGNS),
    ]
    if bag := result.get('bag'):
        parts.append(Text(f'Bag: {bag}', no_wrap=True, overflow='ignore'))
    return Group(*parts)


def _grouped(result: Section) -> Table:
    table = WholeTable.grid(padding=(0, 2, 0, 0))
    table.add_column()
    table.add_column(justify='right', no_wrap=True)
    table.add_column(no_wrap=True)
    for name, rows in groups(result):
        table.add_row(Text(name, style='bold'))
        for label, value, unit in rows:
            said = label if value else fill(label, _SENTENCE)
            table.add_row(Padding(said, (0, 0, 0, 2)), value, unit)
    return table


def sea_words(sea: Section) -> str:
    """Return a ship's sea (`ship.sea_metadata`) as a line of text."""
    said = (
        f'{sea.get("source", sea["spectrum"])}, Hs {sea["significant_wave_height_m"]:.3g} m, '
        f'Tp {sea["peak_period_s"]:.3g} s, seed {sea["seed"]}'
    )
    heading, speed = math.degrees(sea['heading_rad']), sea['speed_m_s']
    return f'{said}; waves {printed(heading, ".4g")}° off following, speed {speed:g} m/s'


# -----------------------------------------------------------------------------
# A replay as tables to read: the voyage, the drift in hindsight, the stability of the clock.


def replay_tables(result: Mapping[str, Any]) -> RenderableType:
    """Return the tables of a replay: the voyage, and the further ones that were asked for."""
    tables = [voyage_table(result)]
    if smoothed := result.get('smoothed'):
        tables.append(_hindsight(smoothed))
    if stability := result.get('stability'):
        tables.append(_stability(stability))
    return Group(*tables)


def _hindsight(smoothed: Mapping[str, Any]) -> Table:
    count = len(smoothed['stamp_s'])
    table = WholeTable(
        title=f'the drift in hindsight, from {count:,} observations',
        title_justify='left',
        show_header=False,
    )
    table.add_column()
    table.add_column(justify='right', no_wrap=True)
    for when, prefix in (('at the time', 'at_the_time_'), ('in hindsight', '')):
        for which in ('rms', 'worst'):
            error = figure(smoothed[f'{prefix}{which}_s'], 's')
            table.add_row(f'error of the estimate {when}, {which}', f'{error} s')
    if count:
        rates, sigmas = smoothed['rate_s_per_day'], smoothed['rate_sigma_s_per_day']
        for name, place in (('least', rates.index(min(rates))), ('most', rates.index(max(rates)))):
            table.add_row(
                f'rate in hindsight, {name}',
                f'{with_sigma(rates[place], sigmas[place])} s/day',
            )
    return table


def _stability(stability: Mapping[str, Any]) -> Table:
    percent = f'{100.0 * stability["confidence"]:g} %'
    table = WholeTable(
        title=f'stability from {stability["samples"]:,} readings, as deviations of the relative '
        f'frequency\n(1e-5 is 0.864 s/day); behind each the bounds of {percent} confidence,\n'
        'in per cent below and above it',
        title_justify='left',
        box=box.SIMPLE,
        pad_edge=False,
        padding=(0, 1),
    )
    for name in ('τ, s', 'Allan', 'modified', 'Hadamard'):
        table.add_column(name, justify='right', no_wrap=True)
    table.add_column('noise', no_wrap=True)
    for row in stability['rows']:
        deviations = [_bounded(row, kind) for kind in ('allan', 'modified', 'hadamard')]
        table.add_row(f'{row["tau_s"]:g}', *deviations, row['noise'])
    return table


def _bounded(row: Mapping[str, Any], kind: str) -> str:
    value, low, high = row[kind], row[f'{kind}_low'], row[f'{kind}_high']
    if not value:
        return '0'
    return f'{value:.1e} −{100.0 * (1.0 - low / value):.0f} +{100.0 * (high / value - 1.0):.0f}'


# -----------------------------------------------------------------------------
# The weather of a scene, to read on a terminal.

ROWS = 24
"""Largest number of rows of a table; if there are more states, several share a row."""

DAY_S = 86_400.0


def weather_words(weather: Mapping[str, Any]) -> str:
    """Return a ship's weather (`ship.motions.sea.weather_metadata`) as a line of text."""
    bridged = weather.get('gaps_bridged')
    return (
        f'{weather.get("source", weather["kind"])}, {len(weather["states"])} states, Hs '
        f'{weather["median_m"]:.3g} m in the median, {weather["highest_m"]:.3g} m at most, '
        f'seed {weather["seed"]}; {weather["seas_at_once"]:.3g} seas summed at once'
        + (f'; {bridged} gaps bridged' if bridged else '')
    )


def weather_table(weather: Mapping[str, Any]) -> Table:
    """Return the states as a table; where there are many, several share a row as ranges."""
    from rich import box

    states = weather['states']
    together = math.ceil(len(states) / ROWS)
    title = 'weather' if together == 1 else f'weather, {together} states a row'
    caption = 'heading: direction the waves run to, from the bow to port; 0 following'
    table = WholeTable(title=title, title_justify='left', caption=caption, box=box.SQUARE)
    for heading in ('from day', 'Hs, m', 'Tp, s', 'heading, °', 'speed, m/s'):
        table.add_column(heading, justify='right')
    for first in range(0, len(states), together):
        row = states[first : first + together]
        table.add_row(
            f'{row[0]["at_s"] / DAY_S:.2f}',
            _range([state['significant_wave_height_m'] for state in row], 2),
            _range([state['peak_period_s'] for state in row], 1),
            _range([_degrees(state['heading_rad']) for state in row], 0),
            _range([state['speed_m_s'] for state in row], 2),
        )
    return table


def _degrees(heading_rad: float | None) -> float | None:
    """Return a heading from −180° to 180°, so that seas from astern are about 0."""
    if heading_rad is None:
        return None
    return math.degrees(math.remainder(heading_rad, math.tau))


def _range(values: Sequence[float | None], decimals: int) -> str:
    """Return the least and the largest of the known values; for a calm a dash."""
    known = [value for value in values if value is not None]
    if not known:
        return '–'
    low, high = (printed(value, f'z.{decimals}f') for value in (min(known), max(known)))
    return low if low == high else f'{low} to {high}'
