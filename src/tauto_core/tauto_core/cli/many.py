"""`tauto compare` and `tauto fleet`: several clocks, or many ships, on one voyage."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tauto_core.cli.terminal import (
    Anyway,
    AsJson,
    Duration,
    Plots,
    SceneName,
    Settings,
    given_values,
    print_rich,
    say,
)
from tauto_core.scene.errors import UsageError
from tauto_core.wording import counted, figure, printed, significant, span

if TYPE_CHECKING:
    from rich.table import Table

    from tauto_core.ensembles.answers import Answers, Within
    from tauto_core.ensembles.comparison import Comparison, Row
    from tauto_core.ensembles.fleets import Fleet


# -----------------------------------------------------------------------------
# `tauto compare`: several clocks through the same sea, side by side.

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
    from tauto_core.cli.terminal import ended_by_sigterm, progress_bar
    from tauto_core.ensembles import comparison
    from tauto_core.files import check_plot

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
        _print_comparison(result)


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


def _print_comparison(result: Comparison) -> None:
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

    from tauto_core.cli.tables import WholeTable

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


# -----------------------------------------------------------------------------
# `tauto fleet`: many voyages of one scene; how often is the longitude found?

_CLOCKS = {'raw': 'dial', 'corrected': 'rated'}


def fleet(
    scene: SceneName,
    ships: Annotated[int, typer.Option(metavar='N', help='How many ships.')] = 100,
    vary: Annotated[
        Path | None,
        typer.Option(
            metavar='FILE', help='YAML: keys of the scene, and how each is drawn for every ship.'
        ),
    ] = None,
    duration: Duration = None,
    settings: Settings = None,
    jobs: Annotated[int, typer.Option(metavar='N', help='Processes at once on this machine.')] = 2,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar='ADDRESS', help='Sail on the workers of this dask scheduler.'),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar='DIR',
            help='Write a row a ship to ships.parquet there; go on with what it has.',
        ),
    ] = None,
    plot: Plots = None,
    anyway: Anyway = False,
    as_json: AsJson = False,
) -> None:
    """Send many ships on one voyage: how many find the longitude?

    Each has her own seed, so her own observations and noise of the clock, where ship.kind is sea
    her own waves, and what --vary draws.
    """
    from tauto_core.cli.terminal import counting_bar, ended_by_sigterm
    from tauto_core.ensembles.answers import draw
    from tauto_core.ensembles.fleets import Plan, read_draws, sail_fleet
    from tauto_core.ensembles.workers import Crew
    from tauto_core.files import check_plot
    from tauto_core.scene import load_scene

    for path in plot or ():
        check_plot(path)
    crew = Crew(jobs, scheduler)
    draws = read_draws(vary) if vary is not None else {}
    loaded = load_scene(scene, **given_values(settings, duration))
    plan = Plan(loaded, scene, ships, draws, str(vary or scene))
    for warning in plan.warnings:
        say(warning)
    with ended_by_sigterm(), counting_bar('ships', ships) as progress:
        result = sail_fleet(plan, crew, out, progress, anyway=anyway)
    for path in plot or ():
        draw(result, path)
        say(f'wrote {path}')
    if out is not None:
        say(f'wrote {out / "ships.parquet"}')
    if as_json:
        typer.echo(json.dumps(_as_object(result), allow_nan=False))
    else:
        _print_fleet(result)


def _as_object(result: Fleet) -> dict[str, object]:
    return {'scene': result.plan.scene.name, **asdict(result.answers)}


def answer(result: Answers) -> str:
    """Return in a sentence how often the longitude was found within the Act's first limit; of a
    voyage that the Act does not judge, how large the errors are.
    """
    if result.within is None:
        return _errors_alone(result)
    rated, dial = (result.within[name][0] for name in ('corrected', 'raw'))
    return (
        f'Of {counted(result.ships, "ship")} {_percent(rated.share)} ({_percent(rated.low)} to '
        f'{_percent(rated.high)} with 95 % confidence) found their longitude within '
        f'{rated.limit_nmi:g} nautical miles by the rated clock, {_percent(dial.share)} by the '
        'dial alone.'
    )


def _errors_alone(result: Answers) -> str:
    """Return medians and 95 % quantiles of the errors in a sentence."""
    from tauto_core.ensembles.answers import QUANTILES

    rated, dial = (result.quantiles_nmi[name] for name in ('corrected', 'raw'))
    if rated is None or dial is None:
        return f'None of {counted(result.ships, "ship")} arrived.'
    lost, ships = sum(result.failures.values()), counted(result.ships, 'ship')
    who = f'the {result.ships - lost} of {ships} that arrived' if lost else ships
    (half, most), (half_dial, most_dial) = (
        [figure(sizes[QUANTILES.index(share)], 'nmi').lstrip('<') for share in (0.5, 0.95)]
        for sizes in (rated, dial)
    )
    return (
        f'Of {who}, {result.unchecked()}, half are within {half} nautical miles by the rated '
        f'clock and 95 % within {most}; by the dial alone within {half_dial} and {most_dial}. '
        'That is no verdict: the Act of 1714 asks for six weeks.'
    )


def _print_fleet(result: Fleet) -> None:
    failures = result.answers.failures.items()
    print_rich(
        answer(result.answers),
        *tables(result.answers),
        *(f'{counted(number, "ship")} failed: {why}' for why, number in failures),
    )


def tables(result: Answers) -> list[Table]:
    """Return quantiles of the error, influences, and of a long voyage shares within the Act's
    limits.
    """
    found = [] if result.within is None else [_shares(result.within)]
    found.append(_quantiles(result))
    return found + [_influences(result)] * bool(result.influences)


def _table(title: str, *columns: str) -> Table:
    from rich import box

    from tauto_core.cli.tables import WholeTable

    table = WholeTable(title=title, title_justify='left', box=box.SIMPLE_HEAD, padding=0)
    first, *others = columns
    table.add_column(first)
    for name in others:
        table.add_column(name, justify='right')
    return table


def _shares(within: dict[str, list[Within]]) -> Table:
    limits = (f'{each.limit_nmi:g} nmi' for each in within['raw'])
    table = _table('ships within', 'clock', *limits)
    for clock, said in _CLOCKS.items():
        table.add_row(
            said,
            *(
                f'{_percent(each.share)} ({_percent(each.low)}–{_percent(each.high)})'
                for each in within[clock]
            ),
        )
    return table


def _quantiles(result: Answers) -> Table:
    from tauto_core.ensembles.answers import QUANTILES

    table = _table(
        'error of the longitude below which so many ships stay [nmi]',
        'clock',
        *(f'{_percent(each)}' for each in QUANTILES),
    )
    for clock, said in _CLOCKS.items():
        sizes: Sequence[float | None] = result.quantiles_nmi[clock] or [None] * len(QUANTILES)
        table.add_row(said, *(figure(size, 'nmi') for size in sizes))
    return table


def _influences(result: Answers) -> Table:
    clocks = tuple(_CLOCKS.values())
    sizes = (f'{name}, size' for name in clocks)
    table = _table('rank correlation with the error, and with its size', 'key', *clocks, *sizes)
    for each in result.influences:
        ranks = (each.raw, each.corrected, each.raw_size, each.corrected_size)
        table.add_row(each.key, *(_signed(value) for value in ranks))
    return table


def _signed(value: float | None) -> str:
    return '–' if value is None else printed(value, '+z.2f')


def _percent(share: float) -> str:
    return f'{100.0 * share:.3g} %'
