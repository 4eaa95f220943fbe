"""`tauto compare`: several clocks through the same sea, side by side."""

from __future__ import annotations

import json
from dataclasses import asdict
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from tauto_core.cli.options import Anyway, AsJson, Duration, Plots
from tauto_core.cli.terminal import print_rich
from tauto_core.cli.voice import say
from tauto_core.scene.errors import UsageError
from tauto_core.wording import figure, significant, span

if TYPE_CHECKING:
    from rich.table import Table

    from tauto_core.comparison import Comparison, Row


COLUMNS = ('rate\ns/day', 'spread\ns/day', 'error\ns', 'dial\nnmi', 'rated\nnmi')
PRIZES = ('dial\n£', 'rated\n£')

_CAPTION = (
    'rate: mean of the run; spread: standard deviation of the rates over {} each; nmi: east of '
    'the truth, by the dial, and rated: corrected for the rate found in port, in the same sea; '
    '{}'
)
_PRIZE = '£: what the Act of 1714 pays'
_TOO_SHORT = 'the Act of 1714 pays nothing for a voyage of less than six weeks'


class Cases(StrEnum):
    """Whether the cases of the clocks are suspended."""

    BOTH = 'both'
    WITH = 'with'
    WITHOUT = 'without'


def compare(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(metavar='SCENE…', help='Files or shipped names; none: the shipped clocks.'),
    ] = None,
    ship_of: Annotated[
        str | None,
        typer.Option(
            metavar='SCENE', help='Send all clocks on the passage of this scene: ship, voyage, …'
        ),
    ] = None,
    duration: Duration = None,
    roll: Annotated[
        str | None,
        typer.Option(
            metavar='A,B,…',
            help='Significant amplitudes of the roll [deg], twice its root mean square; heave '
            'and waves stay.',
        ),
    ] = None,
    suspension: Annotated[
        Cases, typer.Option(help='Cases hung as in the scenes, or fixed to the ship.')
    ] = Cases.BOTH,
    jobs: Annotated[int, typer.Option(metavar='N', help='Processes at once.')] = 2,
    plot: Plots = None,
    anyway: Anyway = False,
    as_json: AsJson = False,
) -> None:
    """Sail several clocks through the same sea, side by side.

    Which of them finds the longitude? The column `dial` is the longitude by the dial alone, which
    the shipped clocks have regulated on land. The column `rated` allows for the rate observed in
    port, where the ship lies in the same sea.
    """
    from tauto_core import comparison
    from tauto_core.cli.ending import ended_by_sigterm
    from tauto_core.cli.progress import progress_bar
    from tauto_core.figure_file import check_plot

    for path in plot or ():
        check_plot(path)
    entries = comparison.make_entries(
        scenes or (),
        ship_of=ship_of,
        duration=duration,
        rolls_deg=_degrees(roll),
        cases=suspension.value,
        anyway=anyway,
    )
    with ended_by_sigterm(), progress_bar(f'{len(entries)} clocks') as progress:
        result = comparison.compare(entries, jobs=jobs, progress=progress)
    for path in plot or ():
        comparison.draw(result, path)
        say(f'wrote {path}')
    if as_json:
        typer.echo(json.dumps(asdict(result), allow_nan=False))
    else:
        _print(result)


def _degrees(text: str | None) -> list[float]:
    if text is None:
        return []
    try:
        return [float(part) for part in text.split(',')]
    except ValueError:
        raise UsageError(
            f'--roll {text!r}: must be numbers with commas between, in degrees. Write for '
            'example 0,10,20'
        ) from None


def _print(result: Comparison) -> None:
    print_rich(comparison_table(result), *failures(result))


def failures(result: Comparison) -> list[str]:
    """Return why clocks stopped: one line for each clock and case, at its first such roll."""
    found: dict[tuple[str, str], str] = {}
    for row in result.rows:
        if row.stopped is not None:
            found.setdefault((row.clock, _case(row)), row.stopped.why)
    return [f'{clock}, {case}: {why}' for (clock, case), why in found.items()]


def comparison_table(result: Comparison) -> Table:
    """Return one line for each clock: rate, spread, error at the end, longitudes, prizes."""
    from rich import box

    from tauto_core.cli.whole_table import WholeTable

    releases = ', '.join(f'{each:g}' for each in sorted({row.release for row in result.rows}))
    judged = any(row.prize_pounds is not None for row in result.rows)
    table = WholeTable(
        title=f'{span(result.duration_s)} in the same sea, released at {releases} rad',
        title_justify='left',
        caption=_CAPTION.format(span(result.piece_s), _PRIZE if judged else _TOO_SHORT),
        caption_justify='left',
        box=box.SIMPLE_HEAD,
        show_edge=False,
        padding=0,
    )
    rolls = len({row.roll_deg for row in result.rows}) > 1
    table.add_column('clock')
    table.add_column('case', no_wrap=True)
    for name in (*['roll\n°'] * rolls, *COLUMNS, *PRIZES[: 2 * judged]):
        table.add_column(name, justify='right', no_wrap=True)
    for row in result.rows:
        roll = [significant(row.roll_deg)] * rolls
        name = row.clock.removeprefix('clock_').replace('_', ' ')
        table.add_row(name, _case(row), *roll, *_figures(row), *_prizes(row)[: 2 * judged])
    return table


def _case(row: Row) -> str:
    return 'hung' if row.suspended else 'fixed'


def _figures(row: Row) -> list[str]:
    return [
        'stopped' if row.stopped else figure(row.rate_s_per_day, 's/day', signed=True),
        figure(row.rate_spread_s_per_day, 's/day'),
        figure(row.error_s, 's', signed=True),
        figure(row.raw_error_nmi, 'nmi', signed=True),
        figure(row.error_nmi, 'nmi', signed=True),
    ]


def _prizes(row: Row) -> list[str]:
    both = (row.raw_prize_pounds, row.prize_pounds)
    return ['–' if pounds is None else f'{pounds:,}' for pounds in both]
