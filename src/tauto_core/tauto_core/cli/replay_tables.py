"""A replay as tables to read: the voyage, the drift in hindsight, the stability of the clock."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Group
from rich.table import Table

from tauto_core.cli.tables import voyage_table
from tauto_core.cli.whole_table import WholeTable
from tauto_core.wording import figure, with_sigma

if TYPE_CHECKING:
    from rich.console import RenderableType


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
