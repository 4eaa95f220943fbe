"""`tauto fleet SCENE --logs FILE`: clocks on the passages of a log-book, and the tables of it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from tauto_core.cli.tables import of_fleet
from tauto_core.cli.terminal import counting_bar, ended_by_sigterm, print_rich, progress_bar, say
from tauto_core.scene.errors import UsageError
from tauto_core.wording import counted, figure, percent

if TYPE_CHECKING:
    from rich.table import Table

    from tauto_core.ensembles.trial_answers import ClockAnswers, TrialAnswers
    from tauto_core.ensembles.workers import Crew
    from tauto_core.scene import Scene


@dataclass(frozen=True)
class Asked:
    """The values of the command's options; None where an option was not given.

    Attributes:
        logs: file of the log-book.
        compare: names of further clocks, with commas between; `clocks`: the built-in ones.
        days, years: from the least to the largest, as `42..`, `..100` or `1770..1790`.
        port, ocean, sample: as `trials.Choice` has them.
        harbour_days: days of rating before the first entry.
        wind_draws, hull_draws: number of repetitions with another random wind or hull.
        local_time_s: error of the navigator's local time [s].
        skip_wrong: leave out passages that cannot be sailed.
    """

    logs: str
    compare: str | None
    days: str
    years: str | None
    port: str | None
    ocean: str | None
    sample: int | None
    harbour_days: float
    wind_draws: int
    hull_draws: int
    local_time_s: float
    skip_wrong: bool


def between(option: str, text: str, example: str, unit: str | None = None) -> tuple[float, float]:
    """Return the ends of a range `A..B`, either of which may be missing; else a UsageError.

    They are in `unit`, or have a unit.
    """
    from tauto_core.scene.units import measure

    def end(said: str) -> float:
        return float(said) if unit is None else measure(said, unit)

    least, dots, most = text.partition('..')
    try:
        low = end(least) if least else -math.inf
        high = (end(most) if most else math.inf) if dots else low
        if not low <= high:
            raise ValueError
    except ValueError:
        raise UsageError(
            f'{option} {text}: must be a range from the least to the largest. Write for example '
            f'{example}'
        ) from None
    return low, high


def sail_logs(
    scene: Scene,
    origin: str,
    asked: Asked,
    crew: Crew,
    out: Path | None,
    plots: Sequence[Path],
    *,
    shortened_s: float | None,
    anyway: bool,
    as_json: bool,
) -> None:
    """Sail a scene's clock, and others, along the passages of a log-book; print the result."""
    from tauto_core.ensembles.trial_answers import answers_of, check_local_time
    from tauto_core.ensembles.trials import (
        Choice,
        clocks_beside,
        make_trial,
        sail_trial,
    )
    from tauto_core.ship.coast import LANDFALL_KM

    check_local_time(asked.local_time_s)
    low, high = (-math.inf, math.inf)
    if asked.years is not None:
        low, high = between('--years', asked.years, '1770..1790')
    choice = Choice(
        days=between('--days', asked.days, '42..', 'd'),
        years=(low, high),
        port=asked.port,
        ocean=asked.ocean,
        sample=asked.sample,
    )
    scenes = [(origin, scene)]
    if asked.compare is not None:
        names = [each.strip() for each in asked.compare.split(',')]
        scenes += clocks_beside(scene, origin, names)
    with progress_bar(asked.logs) as progress:
        trial = make_trial(
            asked.logs,
            scenes,
            choice,
            progress=progress,
            harbour_days=asked.harbour_days,
            longest_s=shortened_s,
            wind_draws=asked.wind_draws,
            hull_draws=asked.hull_draws,
            skip_wrong=asked.skip_wrong,
            anyway=anyway,
        )
    for _, why in trial.left_out:
        say(f'left out: {why}')
    for clock in trial.rules.clocks:
        if clock.why_unsensed:
            say(f'{clock.name}: is not tried with thermometer and IMU: {clock.why_unsensed}')
    with ended_by_sigterm(), counting_bar('voyages', trial.ships) as counting:
        sailed = sail_trial(trial, crew, out, counting)
    answers = answers_of(sailed, asked.local_time_s)
    for path in plots:
        from tauto_core.plots.tracks import draw_trial

        draw_trial(sailed, answers, path)
        say(f'wrote {path}')
    if out is not None:
        say(f'wrote {out / "ships.parquet"}')
    if as_json:
        typer.echo(json.dumps(asdict(answers), allow_nan=False))
        return
    print_rich(answers.answer, *trial_tables(answers), *_remarks(answers))
    away = list(dict.fromkeys(each['passage'] for each in answers.voyages if each['ends']))
    if away:
        print_rich(
            f'the last entry of {counted(len(away), "passage")} lies at sea, more than '
            f'{LANDFALL_KM:g} km from the coast; no landfall there: {", ".join(away[:5])}'
            + ', …'
            * (len(away) > 5)
        )


# -----------------------------------------------------------------------------
# The result as text.

WAYS = {
    'raw': 'dial alone',
    'corrected': 'rated in harbour',
    'sensed': 'with thermometer and IMU',
}


def trial_tables(answers: TrialAnswers) -> Iterator[Table]:
    """Yield the table of prizes, the quantiles, and the parts by season and by ocean."""
    from tauto_core.ensembles.answers import QUANTILES

    several = len(answers.clocks) > 1
    rows = [(clock, way) for clock in answers.clocks for way in clock.ways]

    def called(clock: ClockAnswers, way: str) -> str:
        return f'{clock.clock}, {WAYS[way]}' if several else WAYS[way]

    if answers.judged:
        limits = [f'{each.limit_nmi:g} nmi' for each in answers.clocks[0].ways['raw'].prizes]
        drawn = ['± wind'] * bool(answers.wind_draws) + ['± hull'] * bool(answers.hull_draws)
        sights = f'30 nmi, local time ± {answers.local_time_s:g} s'
        title = 'passages within (95 % confidence)'
        table = of_fleet(title, 'clock', *limits, sights, *drawn)
        for clock, way in rows:
            prizes = clock.ways[way].prizes
            first = prizes[0]
            spreads = [first.wind] * bool(answers.wind_draws)
            spreads += [first.hull] * bool(answers.hull_draws)
            table.add_row(
                called(clock, way),
                *(each.said for each in prizes),
                percent(first.with_local_time),
                *('–' if each is None else f'± {percent(each)}' for each in spreads),
            )
        yield table
    title = 'error below which so many passages stay [nmi]'
    table = of_fleet(title, 'clock', *(percent(each) for each in QUANTILES))
    for clock, way in rows:
        sizes: Sequence[float | None] = clock.ways[way].quantiles_nmi or [None] * len(QUANTILES)
        table.add_row(called(clock, way), *(figure(size, 'nmi') for size in sizes))
    yield table
    if answers.wind_draws or answers.hull_draws:
        title = 'change of the error of a passage in the median [nmi]'
        table = of_fleet(title, 'clock', 'wind drawn anew', 'hull drawn anew')
        for clock, way in rows:
            found = clock.ways[way]
            changes = (found.wind_nmi, found.hull_nmi)
            table.add_row(called(clock, way), *(figure(each, 'nmi') for each in changes))
        yield table
    if answers.judged:
        for title, parts in (('season', 'seasons'), ('ocean', 'oceans')):
            yield _parts(answers, title, parts, called)


def _parts(answers: TrialAnswers, title: str, parts: str, called: Any) -> Table:
    table = of_fleet('', title, 'clock', 'passages', '30 nmi', '40 nmi', '60 nmi', 'median, nmi')
    for clock in answers.clocks:
        for way in clock.ways:
            for part in getattr(clock.ways[way], parts):
                cells = [str(count) for count in (part.passages, *part.within)]
                median = figure(part.median_nmi, 'nmi')
                table.add_row(part.name, called(clock, way), *cells, median)
    return table


def _remarks(answers: TrialAnswers) -> Iterator[str]:
    """Yield the voyages that ended early, and the differences of ships in company."""
    for clock in answers.clocks:
        if clock.stopped:
            yield f'{clock.clock}: stopped on {counted(clock.stopped, "passage")}'
        for why, number in clock.failures.items():
            yield f'{clock.clock}: {counted(number, "passage")} failed: {why}'
        differ = [
            abs(each.differ_nmi[clock.clock]['corrected'])
            for each in answers.companies
            if 'corrected' in each.differ_nmi.get(clock.clock, {})
        ]
        if differ:
            rms = math.sqrt(sum(each * each for each in differ) / len(differ))
            pairs = counted(len(differ), 'pair')
            yield (
                f'{clock.clock}: on {pairs} of ships in company the rated clock differs by '
                f'{figure(rms, "nmi")} nmi rms between two logs when they part'
            )
