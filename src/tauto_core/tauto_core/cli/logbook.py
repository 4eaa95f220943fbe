"""`tauto logbook`: the passages of a log-book, and a scene of one of them."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tauto_core.cli.terminal import AsJson, Plots, progress_bar, say, takes
from tauto_core.scene.errors import UsageError
from tauto_core.wording import place

if TYPE_CHECKING:
    from tauto_core.ship.logbook import LoggedPassage

HARBOUR_DAYS = 14.0
"""Default days of rating before the first entry."""


INLAND_KM = 30.0
"""Distance from the coast beyond which a place on land is reported: maps err by less [km]."""


def logbook(
    file: Annotated[
        str,
        typer.Argument(metavar='FILE', help='Log-book: our columns, CLIWOC, or a track in GPX.'),
    ],
    passage: Annotated[str | None, takes('ID', 'Write a scene that sails this passage.')] = None,
    scene: Annotated[
        str, takes('SCENE', 'Scene whose machine, ship and navigator sail it.')
    ] = 'portsmouth_jamaica',
    harbour_days: Annotated[
        float,
        takes('DAYS', 'Days in harbour before the first entry, which the log does not hold.', 'd'),
    ] = HARBOUR_DAYS,
    winds: Annotated[
        str | None, takes('FILE', 'For a track: CSV of utc, wind_from_deg, wind_mps.')
    ] = None,
    out: Annotated[
        str | None,
        typer.Option('--out', '-o', metavar='FILE', help='File of the scene; else printed.'),
    ] = None,
    plot: Plots = None,
    as_json: AsJson = False,
) -> None:
    """List the passages of a log-book, or write a scene of one.

    Doubtful entries are listed, and --plot draws the tracks on a map. A passage that cannot be
    sailed is named with its row and the reason.
    """
    from tauto_core.files import check_plot
    from tauto_core.scene.tables import missing_file
    from tauto_core.ship.logbook import read_passages

    for name in filter(None, (file, winds)):
        for found in missing_file('FILE', name, folders=True):
            raise UsageError(f'{name}: {found.problem}. {found.remedy}')
    for path in plot or ():
        check_plot(path)
        if passage is not None:
            raise UsageError(f'--plot {path}: draws all passages. Leave out --passage, or this')
    if passage is not None:
        _write(file, passage, scene, harbour_days, winds, out)
        return
    if out is not None:
        raise UsageError(f'--out {out}: is the file of a scene. Name a passage with --passage')
    with progress_bar(file) as progress:
        rows, passages = [], []
        for each in read_passages(file, winds=winds, progress=progress):
            rows.append(_facts(each))
            if plot:  # only a map needs all entries at once
                passages.append(each)
    if plot and passages:
        from tauto_core.plots.tracks import draw_passages

        for path in plot:
            draw_passages(passages, path)
            say(f'wrote {path}')
    if as_json:
        typer.echo(json.dumps({'passages': rows}, allow_nan=False))
        return
    width = max([len(row['passage']) for row in rows] + [7])
    ends = [', '.join(place(*row[key]) for key in ('first_place', 'last_place')) for row in rows]
    way = max(map(len, [*ends, 'from, to']))
    typer.echo(
        f'{"passage":{width}}  first day   days  noons  wind   air  {"from, to":{way}}  '
        'ship; what is doubtful'
    )
    for row, between in zip(rows, ends, strict=True):
        told = [f'cannot be sailed: {each}' for each in row['problems']] or row['notes']
        days = '' if row['days'] is None else f'{row["days"]:.1f}'
        typer.echo(
            f'{row["passage"]:{width}}  {row["first_utc"][:10]:10} {days:>5}  {row["entries"]:5}  '
            f'{row["wind_share"]:4.0%}  {row["air_share"]:4.0%}  {between:{way}}  '
            + '; '.join([row['ship'] or '?', *told])
        )
    sound = sum(not row['problems'] for row in rows)
    typer.echo(f'{len(rows)} passages, {sound} of them can be sailed: --passage ID writes a scene')


def _facts(passage: LoggedPassage) -> dict[str, Any]:
    """Return the JSON of a passage: names with units, missing values as None."""
    problems = [f'{each.key}: {each.problem}' for each in passage.problems()]
    sound = not problems
    return {
        'passage': passage.name,
        'ship': passage.ship,
        'nation': passage.nation,
        'from': passage.sailed_from,
        'to': passage.bound_to,
        'first_utc': passage.entries[0][0],
        'last_utc': passage.entries[-1][0],
        'days': passage.days if sound else None,
        'entries': len(passage.entries),
        'first_place': list(passage.entries[0][1:3]),
        'last_place': list(passage.entries[-1][1:3]),
        'wind_share': passage.share(4),
        'air_share': passage.share(5),
        'problems': problems,
        'notes': [*passage.notes(), *_ashore(passage)] if sound else [],
    }


def _ashore(passage: LoggedPassage) -> list[str]:
    """Return notes on entries that lie on land, and on a last one that does not reach it."""
    from tauto_core.ship.coast import inland_km, no_landfall

    far = [inland_km(*entry[1:3]) for entry in passage.entries]
    rows = [index for index, km in enumerate(far) if km > INLAND_KM]
    found = []
    if rows:
        where = ', '.join(f'{index + 1}' for index in rows[:5]) + ', …' * (len(rows) > 5)
        found.append(f'more than {INLAND_KM:g} km inland: row{"s" * (len(rows) > 1)} {where}')
    if (away := no_landfall(*passage.entries[-1][1:3])) is not None:
        found.append(f'last entry {away}')
    return found


def _write(
    file: str, name: str, scene: str, harbour_days: float, winds: str | None, out: str | None
) -> None:
    """Write or print the scene of a passage, after it has been checked."""
    from tauto_core.files import check_place, write_whole
    from tauto_core.scene.loader import load_scene, parse_scene, scene_yaml, write_mapping
    from tauto_core.ship.logbook import scene_of_passage, sound_passage

    if out is not None:
        if not out.endswith(('.yaml', '.yml')):
            raise UsageError(f'--out {out}: must end in .yaml. Name another file')
        check_place(Path(out), 'out')
    found = sound_passage(file, name, winds=winds)
    own = load_scene(scene)
    content = own.model_dump(mode='json', exclude_none=True)
    text = write_mapping(scene_of_passage(content, found, harbour_days))
    text = scene_yaml(parse_scene(text, name))
    if out is None:
        typer.echo(text, nl=False)
        return
    write_whole(Path(out), text.encode())
    say(f'wrote {out}. Sail it with: {shlex.join(("tauto", "sail", out))}')
