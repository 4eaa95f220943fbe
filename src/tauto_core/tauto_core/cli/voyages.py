"""Commands that sail voyages, or read their bags.

`tauto sail`, `replay`, `plot` and `report` take one voyage, `compare` several clocks in one sea,
`fleet` many ships; `tauto bag` is for damaged bags.
"""

from __future__ import annotations

import json
import os
import shlex
import sys
from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tauto_core.cli.terminal import (
    Accuracy,
    Anyway,
    AsJson,
    Duration,
    Plots,
    SceneName,
    Settings,
    counting_bar,
    ended_by_sigterm,
    given_values,
    listed,
    option,
    print_rich,
    progress_bar,
    say,
    say_oddities,
    say_once,
    show_result,
    takes,
)
from tauto_core.scene.errors import UsageError, naming, spelled
from tauto_core.wording import counted

if TYPE_CHECKING:
    from tauto_core.voyage import Voyage

# -----------------------------------------------------------------------------
# One voyage, sailed or read again.


def sail(
    scene: SceneName,
    out: Annotated[
        Path | None, takes('DIR', 'Folder of the bag; without it no bag is written.')
    ] = None,
    duration: Duration = None,
    accuracy: Accuracy = None,
    settings: Settings = None,
    force: Annotated[bool, typer.Option('--force', help='Replace the bag in --out.')] = False,
    anyway: Anyway = False,
    as_json: AsJson = False,
) -> None:
    """Sail a scene without ROS: how far wrong is the clock?

    The result has the error of the dial, the distance between the ship and the place where the
    clock puts her, and the prize by the Act of 1714. With --out it writes a bag, of which
    `tauto report` makes a page.
    """
    from tauto_core import voyage
    from tauto_core.scene import load_scene

    loaded = load_scene(scene, **given_values(settings, duration, accuracy))
    if force and out is None:
        raise UsageError('--force replaces the bag in --out, and there is no --out. Name it')
    odd = say_oddities(loaded, scene, anyway=anyway)
    with ended_by_sigterm(), progress_bar(loaded.name) as progress:
        result = voyage.sail(
            loaded,
            out,
            origin=scene,
            force=force,
            anyway=anyway,
            keep=False,
            progress=progress,
            judge=True,
        ).result
    say_once(result.get('warnings', ()), odd)
    if as_json:
        show_result(result, None)
        return
    from tauto_core.cli.tables import voyage_table

    show_result(result, voyage_table(result))


def replay(
    bag: Annotated[Path, typer.Argument(metavar='BAG', help='A rosbag2 folder or an .mcap file.')],
    scene: Annotated[
        str | None, takes('SCENE', 'The scene, where the bag does not hold its own.')
    ] = None,
    smooth: Annotated[bool, typer.Option('--smooth', hidden=True)] = False,
    stability: Annotated[
        bool,
        typer.Option(
            '--stability',
            help="Also give the stability of the clock: Allan's deviation and its kin against the "
            'averaging time, with 95 % confidence.',
        ),
    ] = False,
    plot: Annotated[
        Path | None, takes('FILE', 'Draw the stability (.svg, .png); replaces the file.')
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Estimate drift and longitude again, from a bag alone."""
    from tauto_core import voyage
    from tauto_core.bags import read_bag
    from tauto_core.cli.tables import replay_tables
    from tauto_core.files import check_plot
    from tauto_core.scene import load_scene

    if smooth:
        raise UsageError(
            '--smooth: no drift in hindsight is estimated any more. Use the estimate at the end, '
            '`drift` of --json, which knows all observations'
        )
    if plot is not None:
        if not stability:
            raise UsageError('--plot draws what --stability gives. Give both, or neither')
        check_plot(plot)
    loaded = None if scene is None else load_scene(scene)
    with progress_bar(f'replay {bag}'):
        opened = read_bag(bag)
        replayed = voyage.replay(opened, loaded, stability=stability, keep=False)
    result = replayed.result
    say_once(result['warnings'])
    if plot is not None:
        replayed.plot('stability', plot)
        say(f'wrote {plot}')
    show_result(result, None if as_json else replay_tables(result))


# -----------------------------------------------------------------------------
# A voyage to look at: one picture, or a page.

Source = Annotated[
    str,
    typer.Argument(metavar='BAG|SCENE', help='A bag, or a scene, which is sailed for it.'),
]
_WHAT = (
    'error, rate, drift, longitude, stability, amplitude, phase, weather, temperature, roll, '
    'spectrum, map, cam or machine.'
)
_UNIT = (
    'in the unit of the time axis of `plot error`: days for a voyage of two days or more, then '
)
_UNIT += 'hours, minutes, seconds; or with a unit, as 36 h'


def plot(
    source: Source,
    what: Annotated[str, typer.Argument(metavar='WHAT', help=_WHAT)],
    out: Annotated[
        Path | None,
        typer.Option(
            '--out',
            '-o',
            metavar='FILE',
            help='Ending in .svg, .png or .pdf; is replaced. Default: NAME_WHAT.svg.',
        ),
    ] = None,
    from_time: Annotated[
        str | None,
        typer.Option(
            '--from',
            metavar='T',
            help=f'Begin roll or spectrum here, {_UNIT}. Without --from and --to: the roughest '
            'ten minutes.',
        ),
    ] = None,
    to_time: Annotated[
        str | None,
        typer.Option('--to', metavar='T', help='End it here; default: ten minutes after --from.'),
    ] = None,
    duration: Duration = None,
    accuracy: Accuracy = None,
    settings: Settings = None,
    anyway: Anyway = False,
) -> None:
    """Draw one picture of a bag or a scene.

    Pictures of a scene alone (weather, cam, machine) are drawn without sailing it.
    """
    from tauto_core.api import is_bag
    from tauto_core.plots.contents import OF_A_SCENE, check_picture, time_unit
    from tauto_core.scene import load_scene
    from tauto_core.voyage import Voyage

    file = out or Path(f'{title_of(source)}_{what}.svg')
    check_picture(what, file, part=from_time is not None or to_time is not None)
    for name, at in (('--from', from_time), ('--to', to_time)):
        _on_axis(name, at, 1.0)  # a text that is not a time is refused before the scene is sailed
    given = given_values(settings, duration, accuracy)
    if what in OF_A_SCENE and not is_bag(source):
        scene = load_scene(source, **given)
        say_oddities(scene, source, anyway=True)  # it does not sail
        with naming(source, scene.name):
            Voyage(scene, {}, {}).plot(what, file)
    else:
        voyage = _voyage(source, given, anyway)
        unit_s, _ = time_unit(float(voyage.time_s[-1]))
        begin = _on_axis('--from', from_time, unit_s)
        voyage.plot(what, file, from_s=begin, to_s=_on_axis('--to', to_time, unit_s))
    say(f'wrote {file}')


def _on_axis(option: str, text: str | None, unit_s: float) -> float | None:
    """Return a time [s] that is given in the unit of the axis, or with another."""
    from tauto_core.scene.units import quantity

    if text is None:
        return None
    try:
        return float(text) * unit_s
    except ValueError:
        return quantity(text, 's', f'{option} {text!r}')


def report(
    source: Source,
    out: Annotated[
        Path | None,
        typer.Option(
            '--out', '-o', metavar='FILE', help='Ending in .html; is replaced. Default: NAME.html.'
        ),
    ] = None,
    duration: Duration = None,
    accuracy: Accuracy = None,
    settings: Settings = None,
    anyway: Anyway = False,
) -> None:
    """Write a voyage as one page: answer, map, ship, charts."""
    from tauto_core.plots.page import check_report, write_report

    file = out or Path(f'{title_of(source)}.html')
    check_report(file)
    command = (
        shlex.join(['tauto', *sys.argv[1:]]) if len(sys.argv) > 1 else f'tauto report {source}'
    )
    voyage = _voyage(source, given_values(settings, duration, accuracy), anyway)
    say('drawing')
    write_report(voyage, file, command)
    say(f'wrote {file}')


def _voyage(source: str, given: dict[str, Any], anyway: bool) -> Voyage:
    from tauto_core.api import is_bag
    from tauto_core.bags import read_bag
    from tauto_core.scene import load_scene
    from tauto_core.voyage import replay, sail

    if is_bag(source):
        if given:
            raise UsageError(
                '--duration, --accuracy and --set are for a scene, and a bag was sailed '
                'already. Leave them out'
            )
        voyage = replay(read_bag(Path(source)))
        said = voyage.result['warnings']
    else:
        scene = load_scene(source, **given)
        say_oddities(scene, source, anyway=anyway)
        with progress_bar(scene.name) as progress:
            voyage = sail(scene, origin=source, anyway=anyway, progress=progress)
        said = ()
    for warning in said:
        say(warning)
    return voyage


def title_of(source: str) -> str:
    """Return the folder's name, or the file's name without its suffix, as a title."""
    place = Path(os.path.abspath(source))  # `.` has no name
    return place.name if place.is_dir() else place.stem


# -----------------------------------------------------------------------------
# `tauto compare`: several clocks through the same sea, side by side.


class _Cases(StrEnum):
    """Whether the cases of the clocks are suspended."""

    BOTH = 'both'
    WITH = 'with'
    WITHOUT = 'without'


def compare(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar='SCENE…', help='Files or built-in names; none: the built-in clocks.'
        ),
    ] = None,
    ship_of: Annotated[
        str | None, takes('SCENE', 'Send all clocks on the passage of this scene: ship, voyage, …')
    ] = None,
    duration: Duration = None,
    accuracy: Accuracy = None,
    roll: Annotated[
        str | None,
        takes(
            'A,B,…',
            'Significant amplitudes of the roll [deg], twice its root mean square; heave '
            'and waves stay.',
        ),
    ] = None,
    suspension: Annotated[
        _Cases, typer.Option(help='Cases hung as in the scenes, or fixed to the ship.')
    ] = _Cases.BOTH,
    logs: Annotated[
        str | None, takes('FILE', 'Sail a passage of this log-book, in the sea of its wind.')
    ] = None,
    passage: Annotated[str | None, takes('ID', 'With --logs: which; see `tauto logbook`.')] = None,
    harbour_days: Annotated[
        float | None, takes('DAYS', 'With --logs: days of rating before it; else 14.', 'd')
    ] = None,
    jobs: Annotated[int, takes('N', 'Processes at once.')] = 2,
    plot: Plots = None,
    anyway: Anyway = False,
    as_json: AsJson = False,
) -> None:
    """Sail several clocks through the same sea, side by side.

    Which of them finds the longitude? The column `dial` is the longitude by the dial alone, which
    the built-in clocks have regulated on land. The column `rated` allows for the rate observed in
    port, where the ship lies in the same sea. With --logs they sail a passage of a log-book in the
    ship of --ship-of or of the first clock; their dials are regulated where it begins.
    """
    from tauto_core.ensembles import comparison
    from tauto_core.files import check_plot

    for path in plot or ():
        check_plot(path)
    logged = None
    if logs is not None:
        from tauto_core.ensembles.trials import check_logs
        from tauto_core.ship.coast import no_landfall
        from tauto_core.ship.logbook import sound_passage

        check_logs(logs)
        logged = sound_passage(logs, passage)
        away = no_landfall(*logged.entries[-1][1:3])
        for note in [*logged.notes(), *([f'the last entry is {away}'] * (away is not None))]:
            say(f'passage {logged.name}: {note}')
    for name, value in (('--passage', passage), ('--harbour-days', harbour_days)):
        if logs is None and value is not None:
            raise UsageError(f'{name} {value}: needs --logs. Name a log-book, or leave it out')
    entries = comparison.make_entries(
        scenes or (),
        ship_of=ship_of,
        duration=duration,
        accuracy=accuracy,
        rolls_deg=[] if roll is None else listed('--roll', roll, 'deg', 'degrees', '0,10,20'),
        cases=suspension.value,
        anyway=anyway,
        passage=logged,
        harbour_days=14.0 if harbour_days is None else harbour_days,
    )
    with ended_by_sigterm(), progress_bar(f'{len(entries)} clocks') as progress:
        result = comparison.compare(entries, jobs=jobs, progress=progress)
    for path in plot or ():
        comparison.draw_comparison(result, path)
        say(f'wrote {path}')
    if as_json:
        typer.echo(json.dumps(asdict(result), allow_nan=False))
        return
    from tauto_core.cli.tables import comparison_table, failures

    print_rich(comparison_table(result), *failures(result))


# -----------------------------------------------------------------------------
# `tauto budget`: the causes of a clock's rate.


def budget(
    scene: SceneName,
    out: Annotated[
        Path | None,
        takes(
            'FILE|BAG',
            'Keep it in a file (.json), or in the folder of the voyage, whose report then '
            'shows it.',
        ),
    ] = None,
    duration: Duration = None,
    accuracy: Accuracy = None,
    settings: Settings = None,
    jobs: Annotated[int, takes('N', 'Processes at once.')] = 2,
    anyway: Anyway = False,
    as_json: AsJson = False,
) -> None:
    """Break a clock's rate down into its causes.

    Each cause at sea is switched off in turn, in the same waves: the motions of the ship, gravity
    that changes on the way, heat. The effects of dial, amplitude, drag and escapement are found on
    land. The budget then states how far badly known numbers may change the rate, and the effect of
    small changes.
    """
    from tauto_core.ensembles.budget import account, budget_file
    from tauto_core.ensembles.workers import Crew
    from tauto_core.scene import load_scene

    crew = Crew(jobs)
    loaded = load_scene(scene, **given_values(settings, duration, accuracy))
    place = None if out is None else budget_file(out, loaded)
    say_oddities(loaded, scene, anyway=anyway)
    with ended_by_sigterm(), progress_bar(loaded.name) as progress:
        found = account(loaded, crew, progress, origin=scene, anyway=anyway)
    if place is not None:
        found.write(place)
        say(f'wrote {place}')
    if as_json:
        typer.echo(json.dumps(found.facts(), allow_nan=False))
        return
    from tauto_core.cli.tables import budget_tables

    print_rich(*budget_tables(found.facts()))


# -----------------------------------------------------------------------------
# `tauto fleet`: many voyages of one scene; how often is the longitude found?


def fleet(
    scene: SceneName,
    ships: Annotated[int | None, takes('N', 'How many ships; else 100.')] = None,
    vary: Annotated[
        Path | None,
        takes('FILE', 'YAML: keys of the scene, and how each is drawn for every ship.'),
    ] = None,
    duration: Duration = None,
    accuracy: Accuracy = None,
    settings: Settings = None,
    jobs: Annotated[int, takes('N', 'Processes at once on this machine.')] = 2,
    scheduler: Annotated[
        str | None, takes('ADDRESS', 'Sail on the workers of this dask scheduler.')
    ] = None,
    out: Annotated[
        Path | None,
        takes(
            'DIR', 'Write a row for each ship to ships.parquet there; go on from the rows it has.'
        ),
    ] = None,
    logs: Annotated[
        str | None, takes('FILE', 'Sail the passages of this log-book, each in its own wind.')
    ] = None,
    compare: Annotated[
        str | None,
        takes(
            'A,B,…',
            'With --logs: further clocks in the same sea, fixed to the ship; `clocks`: the '
            'built-in ones.',
        ),
    ] = None,
    days: Annotated[
        str | None, takes('A..B', 'With --logs: length of the passages; else 42.. days.')
    ] = None,
    years: Annotated[str | None, takes('A..B', 'With --logs: years of the first entry.')] = None,
    port: Annotated[str | None, takes('NAME', 'With --logs: from or to this port.')] = None,
    ocean: Annotated[
        str | None, takes('NAME', 'With --logs: most entries in this ocean, as pacific.')
    ] = None,
    sample: Annotated[
        int | None, takes('N', 'With --logs: this many of them, evenly over the list.')
    ] = None,
    harbour_days: Annotated[
        float | None, takes('DAYS', 'With --logs: days of rating before each; else 14.', 'd')
    ] = None,
    wind_draws: Annotated[
        int | None, takes('N', 'With --logs: sail each N times more, with another wind each time.')
    ] = None,
    hull_draws: Annotated[
        int | None, takes('N', 'With --logs: sail each N times more, with another hull.')
    ] = None,
    local_time: Annotated[
        float | None,
        takes('S', "With --logs: error of the navigator's local time; else 4 s.", 's'),
    ] = None,
    skip_wrong: Annotated[
        bool,
        typer.Option('--skip-wrong', help='With --logs: leave out passages with a wrong row.'),
    ] = False,
    plot: Plots = None,
    anyway: Anyway = False,
    as_json: AsJson = False,
) -> None:
    """Send many ships on one voyage: how many find the longitude?

    Each ship has her own seed, and so her own observations, noise of the clock and, where
    ship.kind is sea, waves. --vary draws other keys for each. With --logs each sails a passage of
    a log-book.
    """
    from tauto_core.ensembles.answers import draw_fleet
    from tauto_core.ensembles.fleets import Plan, read_draws, sail_fleet
    from tauto_core.ensembles.workers import Crew
    from tauto_core.files import check_plot
    from tauto_core.scene import load_scene

    for path in plot or ():
        check_plot(path)
    crew = Crew(jobs, scheduler)
    of_logs = {
        '--compare': compare,
        '--days': days,
        '--years': years,
        '--port': port,
        '--ocean': ocean,
        '--sample': sample,
        '--harbour-days': harbour_days,
        '--wind-draws': wind_draws,
        '--hull-draws': hull_draws,
        '--local-time': local_time,
    }
    if logs is not None:
        from tauto_core.cli.trials import Asked, sail_logs

        for name, other in (('--ships', ships), ('--vary', vary)):
            if other is not None:
                raise UsageError(
                    f'{name} {other}: does not go with --logs, whose passages are the ships. '
                    'Leave one of them out'
                )
        loaded = load_scene(scene, **given_values(settings, None, accuracy))
        asked = Asked(
            logs,
            compare,
            '42..' if days is None else days,
            years,
            port,
            ocean,
            sample,
            14.0 if harbour_days is None else harbour_days,
            wind_draws or 0,
            hull_draws or 0,
            4.0 if local_time is None else local_time,
            skip_wrong,
        )
        sail_logs(
            loaded,
            scene,
            asked,
            crew,
            out,
            plot or (),
            shortened_s=duration,
            anyway=anyway,
            as_json=as_json,
        )
        return
    for name, value in of_logs.items():
        if value is not None:
            raise UsageError(f'{name} {value}: needs --logs. Name a log-book, or leave it out')
    if skip_wrong:
        raise UsageError('--skip-wrong: needs --logs. Name a log-book, or leave it out')
    ships = 100 if ships is None else ships
    loaded = load_scene(scene, **given_values(settings, duration, accuracy))
    draws = read_draws(vary, loaded) if vary is not None else {}
    plan = Plan(loaded, scene, ships, draws, str(vary or scene))
    for warning in plan.warnings:
        say(warning)
    with ended_by_sigterm(), counting_bar('ships', ships) as progress:
        result = sail_fleet(plan, crew, out, progress, anyway=anyway)
    for path in plot or ():
        draw_fleet(result, path)
        say(f'wrote {path}')
    if out is not None:
        say(f'wrote {out / "ships.parquet"}')
    if as_json:
        facts = {'scene': result.plan.scene.name, **asdict(result.answers)}
        typer.echo(json.dumps(facts, allow_nan=False))
        return
    from tauto_core.cli.tables import fleet_tables

    failures = result.answers.failures.items()
    print_rich(
        result.answers.answer,
        *fleet_tables(result.answers),
        *(f'{counted(number, "ship")} failed: {why}' for why, number in failures),
    )


# -----------------------------------------------------------------------------
# `tauto bag`: check whether a bag is whole, and recover the readable part of a damaged one.

BagPath = Annotated[Path, typer.Argument(metavar='BAG', help='A rosbag2 folder or an .mcap file.')]


def check_bag(bag: BagPath, as_json: AsJson = False) -> None:
    """Read all of a bag and report its faults.

    The exit code is 1 if it is not whole. The command checks the ends of its files, checksums,
    indices, metadata.yaml, payloads, the order of the log times, and whether the recording was cut
    short.
    """
    from tauto_core import bags

    found = bags.check_bag(bag)
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
        held = f'{sum(counts.values()):,} messages on {len(counts)} topics'
        lines, path = [*found.damage, *found.faults], found.bag.path
        if found.cut_short:
            lines.append(f'{path}: the recording was cut short before the voyage was over')
        if found.damage:
            lines.append(f'{path} is damaged; {held} can be read: `tauto bag recover {path}`')
        elif found.whole:
            lines.append(f'{path} is whole: {held}')
        else:
            lines.append(f'{path}: its files are whole, {held}')
        typer.echo('\n'.join([*lines, *(f'note: {note}' for note in notes)]))
    if not found.whole:
        raise typer.Exit(1)


def recover_bag(
    bag: BagPath,
    out: Annotated[
        Path | None,
        takes('DIR', 'Folder of the new bag; otherwise BAG_recovered beside the old one.'),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write the readable part of a damaged bag as a new bag.

    The old bag is not changed.
    """
    from tauto_core import bags

    made = bags.recover_bag(bag, out)
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
        f'{made.path} holds {sum(made.counts.values()):,} messages on {len(made.counts)} topics, '
        f'{span_s:g} s'
    )
