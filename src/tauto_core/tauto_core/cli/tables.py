"""Results to read on a terminal: the answer in a sentence, then the figures in groups."""

from __future__ import annotations

import math
from collections.abc import Mapping
from textwrap import fill
from typing import TYPE_CHECKING, Any

from rich.console import Group
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from tauto_core.answer import answer
from tauto_core.cli.whole_table import WholeTable
from tauto_core.result_rows import SIGNS, groups
from tauto_core.wording import printed, span

if TYPE_CHECKING:
    from rich.console import RenderableType

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
