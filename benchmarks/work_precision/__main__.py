"""The command line of the benchmark; `make bench` runs it in full."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from benchmarks.work_precision import page as speed_page
from benchmarks.work_precision.figure import draw
from benchmarks.work_precision.passage import passage as time_passage
from benchmarks.work_precision.passage import two_at_once
from benchmarks.work_precision.runner import bench
from tauto_core.cli.terminal import AsJson, option
from tauto_core.files import check_plot
from tauto_core.scene.errors import TautoError, UsageError, spelled


def main(
    problem: Annotated[
        str | None, typer.Option(metavar='A,B,…', help='Problems, of a to f; default: all.')
    ] = None,
    peers: Annotated[
        str | None,
        typer.Option(metavar='NAME,…', help='Programs; default: all that are installed.'),
    ] = None,
    quick: Annotated[
        bool, typer.Option('--quick', help='Few settings and short runs: to see that all works.')
    ] = False,
    budget: Annotated[
        float | None,
        typer.Option(min=0.1, metavar='S', help='Time allowed a run [s]; default: 20.'),
    ] = None,
    first: Annotated[
        bool, typer.Option('--first', help='Also the first run of each program, all cold.')
    ] = False,
    passage: Annotated[
        bool,
        typer.Option('--passage', help='Also an 81-day passage all in, and two runs at once.'),
    ] = False,
    show_file: Annotated[
        Path | None,
        typer.Option('--show', metavar='JSON', help='Run nothing: show, and draw, a result.'),
    ] = None,
    into_page: Annotated[
        Path | None,
        typer.Option('--page', metavar='FILE', help="Put the result's table into this file."),
    ] = None,
    plot: Annotated[
        list[Path] | None, typer.Option(metavar='FILE', help='Draw it; replaces the file.')
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Measure run time against error, compared with other programs for the same equations.

    Programs that are not installed are named and left out. Without --quick or a small --budget it
    takes hours on a quiet machine.
    """
    for path in plot or ():
        check_plot(path)
    if show_file is not None:
        result = json.loads(show_file.read_text('utf-8'))
    else:
        result = bench(
            _names(problem), _names(peers), quick=quick, budget_s=budget, cold=first, say=_say
        )
        if passage:
            _say('passage')
            result['passage'] = time_passage()
            _say('two at once')
            result['two_at_once'] = two_at_once()
    for path in plot or ():
        draw(result, path)
    if into_page is not None:
        speed_page.update(into_page, result)
    if as_json:
        typer.echo(json.dumps(result, allow_nan=False, indent=1))
    else:
        _show(result)


def _show(result: Mapping[str, Any]) -> None:
    """Print the table of the page, and what could not be measured."""
    typer.echo(speed_page.block(result))
    for name, keys in result['not_offered'].items():
        typer.echo(f'{name} cannot express problem {", ".join(keys)}')
    for failed in result['failed']:
        typer.echo('{problem}: {program} {setting}: {why}'.format(**failed))


def _names(text: str | None) -> list[str] | None:
    return None if text is None else [name.strip().lower() for name in text.split(',')]


def _say(words: str) -> None:
    typer.echo(f'benchmark: {words}', err=True)


app = typer.Typer(add_completion=False)
app.command()(main)


def run() -> None:
    """Run the command line; exit 2 for what cannot be asked, 1 for what failed."""
    try:
        app()
    except TautoError as error:
        typer.echo(f'benchmark: {spelled(error.message, option)}', err=True)
        sys.exit(2 if isinstance(error, UsageError) else 1)


if __name__ == '__main__':
    run()
