"""`tauto bag`: whether a bag is whole, and a sound one from what is left of one that is not."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from tauto_core.cli.terminal import AsJson, option
from tauto_core.scene.errors import spelled

commands = typer.Typer(
    help='See whether a bag is whole, or recover what is left of one.', no_args_is_help=True
)
BagPath = Annotated[Path, typer.Argument(metavar='BAG', help='A rosbag2 folder or an .mcap file.')]


@commands.command()
def check(bag: BagPath, as_json: AsJson = False) -> None:
    """Read all of a bag, and say what is wrong with it.

    The exit code is 1 if it is not whole. Checked are the ends of its files, checksums,
    indices, metadata.yaml, payloads, the order of the log times, and whether the recording was cut
    short.
    """
    from tauto_core.bags import check_bag

    found = check_bag(bag)
    notes = [spelled(note, option) for note in found.notes]
    counts = found.bag.counts
    if as_json:
        result = {
            'bag': str(bag),
            'whole': found.whole,
            'cut_short': found.cut_short,
            'damage': found.damage,
            'faults': found.faults,
            'notes': notes,
            'topics': counts,
        }
        typer.echo(json.dumps(result))
    else:
        for line in [*_findings(found), *(f'note: {note}' for note in notes)]:
            typer.echo(line)
    if not found.whole:
        raise typer.Exit(1)


def _findings(found: Any) -> list[str]:
    path, counts = found.bag.path, found.bag.counts
    held = f'{sum(counts.values())} messages on {len(counts)} topics'
    lines = [*found.damage, *found.faults]
    if found.cut_short:
        lines.append(f'{path}: the recording was cut short before the voyage was over')
    if found.damage:
        lines.append(f'{path} is damaged; {held} can be read: `tauto bag recover {path}`')
    elif found.whole:
        lines.append(f'{path} is whole: {held}')
    else:
        lines.append(f'{path}: its files are whole, {held}')
    return lines


@commands.command()
def recover(
    bag: BagPath,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar='DIR',
            help='Folder of the new bag; otherwise BAG_recovered beside the old one.',
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write what can be read of a damaged bag as a new one.

    The old one is left as it is.
    """
    from tauto_core.bags import recover_bag

    made = recover_bag(bag, out)
    if as_json:
        result = {
            'bag': str(bag),
            'recovered': str(made.path),
            'start_ns': made.start_ns,
            'end_ns': made.end_ns,
            'lost': list(made.lost),
            'missing': made.missing,
            'topics': made.counts,
        }
        typer.echo(json.dumps(result))
        return
    for lost in made.lost:
        typer.echo(lost)
    if made.missing:
        typer.echo(f'{made.missing} messages that the index counts cannot be read')
    span_s = (made.end_ns - made.start_ns) * 1e-9
    typer.echo(
        f'{made.path} holds {sum(made.counts.values())} messages on {len(made.counts)} topics, '
        f'{span_s:g} s'
    )
