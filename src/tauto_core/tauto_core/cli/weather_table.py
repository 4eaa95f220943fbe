"""The weather of a scene, to read on a terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tauto_core.wording import printed

if TYPE_CHECKING:
    from rich.table import Table

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

    from tauto_core.cli.whole_table import WholeTable

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
