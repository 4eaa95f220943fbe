"""`tauto fleet`: many voyages of one scene; how often is the longitude found?"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tauto_core.cli.options import (
    Anyway,
    AsJson,
    Duration,
    Plots,
    SceneName,
    Settings,
    given_values,
)
from tauto_core.cli.terminal import print_rich
from tauto_core.cli.voice import say
from tauto_core.wording import counted, figure, printed

if TYPE_CHECKING:
    from rich.table import Table

    from tauto_core.fleets import Answers, Fleet
    from tauto_core.fleets.answers import Within

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
    from tauto_core.cli.ending import ended_by_sigterm
    from tauto_core.cli.progress import counting_bar
    from tauto_core.figure_file import check_plot
    from tauto_core.fleets import Plan, draw, read_draws, sail_fleet
    from tauto_core.scene import load_scene
    from tauto_core.workers import Crew

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
        _print(result)


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
    from tauto_core.fleets.answers import QUANTILES

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


def _print(result: Fleet) -> None:
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

    from tauto_core.cli.whole_table import WholeTable

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
    from tauto_core.fleets.answers import QUANTILES

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
