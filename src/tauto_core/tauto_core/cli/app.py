"""The commands of `tauto`.

Exit codes: 0 for success, 2 for a bad command line or scene, 1 for anything that failed on the
way, 130 after Ctrl-C, 143 after SIGTERM. Results go to stdout, messages to stderr; with `--json`
stdout holds one object and nothing else. A traceback means a fault of the program, never of its
input.
"""

from __future__ import annotations

import gc
import json
import os
import re
import signal
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command_name, get_group
from typer.models import CommandInfo, TyperInfo

from tauto_core.cli import bag, curves, euler, hull, many, scene, show
from tauto_core.cli.terminal import (
    Anyway,
    AsJson,
    Duration,
    SceneName,
    Settings,
    Terminated,
    be_quiet,
    drop_output,
    ended_by_sigterm,
    given_values,
    option,
    prepare_streams,
    print_rich,
    say,
    say_oddities,
    say_warnings,
    send_lost_again,
)
from tauto_core.scene.errors import TautoError, UsageError, spelled

if TYPE_CHECKING:
    from rich.console import RenderableType


# -----------------------------------------------------------------------------
# The commands that a Typer knows, built one at a time: to build them all takes 40 ms.


class Registered(Mapping[str, Any]):
    """Commands and groups by name, each built when it is first asked for.

    Args:
        register: with whose decorators they are registered; later ones count, too.
    """

    def __init__(self, register: typer.Typer) -> None:
        self._register = register
        self._built: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        """Return a command, as the parser wants it."""
        if name not in self._built:
            info = self._known()[name]
            alone = typer.Typer(rich_markup_mode=None)
            if isinstance(info, CommandInfo):
                alone.registered_commands = [info]
            else:
                alone.registered_groups = [info]
            self._built[name] = get_group(alone).commands[name]
        return self._built[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._known())

    def __len__(self) -> int:
        return len(self._known())

    def _known(self) -> dict[str, CommandInfo | TyperInfo]:
        """Return what is registered, commands first."""
        named = {
            each.name or get_command_name(each.callback.__name__): each
            for each in self._register.registered_commands
            if each.callback is not None
        }
        groups = {each.name: each for each in self._register.registered_groups if each.name}
        return {**named, **groups}


# -----------------------------------------------------------------------------
# Commands that other distributions add through the entry-point group `tauto.commands`.
#
# They are loaded when they run, not for `tauto --help`; without their distribution the error
# names the remedy.

GROUP = 'tauto.commands'
ROS_COMMANDS = {
    'graph': 'Sail a scene as real ROS 2 nodes, recorded to MCAP.',
    'play': 'Play a bag into a ROS 2 graph.',
}
REMEDY = (
    "On x86-64 Linux `make sail` installs it, or pip install -e 'src/tauto_nodes[ros]'; on a "
    'machine with ROS 2 Jazzy see the README. `tauto sail` needs no ROS.'
)


class MissingCommandError(TautoError):
    """A command whose distribution, or what it needs, is not installed."""


def add_to(commands: typer.Typer) -> None:
    """Register the ROS commands; they are looked for when called."""
    for name, summary in ROS_COMMANDS.items():
        commands.command(
            name,
            help=summary,
            add_help_option=False,
            context_settings={'ignore_unknown_options': True, 'allow_extra_args': True},
        )(_run)


def _run(ctx: typer.Context) -> None:
    """Pass the rest of the command line to the command of the same name."""
    name = str(ctx.info_name)
    try:
        function = _load(name)
        holder = typer.Typer(add_completion=False, rich_markup_mode=None)
        holder.command(name)(function)
        command: Any = typer.main.get_command(holder)
        with command.make_context(name, list(ctx.args), parent=ctx.parent) as inner:
            command.invoke(inner)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition('.')[0] not in ('rclpy', 'tauto_nodes'):
            raise
        raise MissingCommandError(
            f'`tauto {name}` needs {error.name}, which is not installed. {REMEDY}'
        ) from None


def _load(name: str) -> Any:
    from importlib.metadata import entry_points

    for entry in entry_points(group=GROUP, name=name):
        return entry.load()
    raise MissingCommandError(
        f'`tauto {name}` needs tauto_nodes, which is not installed. {REMEDY}'
    )


commands = typer.Typer()
"""With which the commands are registered."""


class Commands(TyperGroup):
    """All commands, with one handling of errors, and one `--quiet`."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{**settings, 'commands': Registered(commands)})

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Remove `--quiet` from the command line, wherever it stands."""
        ours = args[: args.index('--')] if '--' in args else args
        be_quiet(not {'--quiet', '-q'}.isdisjoint(ours))
        kept = [word for word in ours if word not in ('--quiet', '-q')] + args[len(ours) :]
        return list(super().parse_args(ctx, kept))

    def invoke(self, ctx: Any) -> Any:
        """Run the command; turn errors into messages on stderr and an exit code."""
        try:
            return super().invoke(ctx)
        except typer.BadParameter as error:
            error.message += _decimal_comma(sys.argv[1:])
            raise
        except TautoError as error:
            _tell(spelled(error.message, option), error)
            raise typer.Exit(error.exit_code) from None
        except Terminated as error:
            _tell('terminated', error)
            raise typer.Exit(128 + signal.SIGTERM) from None
        except KeyboardInterrupt as error:
            _tell('interrupted', error)
            raise typer.Exit(128 + signal.SIGINT) from None


def _decimal_comma(words: Sequence[str]) -> str:
    """Return the number with a decimal point where it has a decimal comma; otherwise ''."""
    found = [word for word in words if re.fullmatch(r'[-+]?\d*,\d+', word.rpartition('=')[2])]
    return ''.join(f'. Write {word.replace(",", ".")}, with a decimal point' for word in found[:1])


app = typer.Typer(
    name='tauto',
    cls=Commands,
    no_args_is_help=True,
    add_completion=True,
    context_settings={'help_option_names': ['-h', '--help']},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
scene_commands = typer.Typer(help='Look at one scene, or begin one.', no_args_is_help=True)
commands.add_typer(scene_commands, name='scene')
commands.add_typer(bag.commands, name='bag')


def _print_version(wanted: bool) -> None:
    if wanted:
        from tauto_core.version import code, version

        typer.echo(f'tauto {version()} (code {code()})')
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[
        bool,
        typer.Option(
            '--version', is_eager=True, callback=_print_version, help='Print the version.'
        ),
    ] = False,
    quiet: Annotated[
        bool,
        typer.Option(
            '--quiet',
            '-q',
            help='Print nothing but the result and errors; may stand anywhere in the line.',
        ),
    ] = False,
) -> None:
    """Sully and Euler's sea clock on a rolling ship: how far wrong is it on the chart?"""


def run() -> None:
    """Run `tauto` with the arguments of the process; never returns."""
    # a scene does not use pydantic plugins, and looking for them reads all installed packages
    os.environ.setdefault('PYDANTIC_DISABLE_PLUGINS', '__all__')
    prepare_streams()
    say_warnings()
    send_lost_again()
    gc.set_threshold(100_000)  # imports make much and leave nothing to collect
    try:
        app()
    except OSError as error:
        # typer ends at a closed pipe; errors of other files have their names
        if error.filename is not None:
            raise
        _tell(f'standard output cannot be written: {error.strerror}. Make room', error)
        drop_output()
        sys.exit(1)


def _tell(words: str, error: BaseException) -> None:
    """Print on stderr what went wrong, with the notes of the error."""
    for line in (words, *getattr(error, '__notes__', ())):
        typer.echo(f'tauto: {line}', err=True)


def _warn(warnings: Iterable[str], said: Sequence[str] = ()) -> None:
    """Print warnings about the input on stderr, except those that were printed already."""
    for warning in warnings:
        if warning not in said:
            say(warning)


def _show(result: Mapping[str, Any], table: RenderableType | None) -> None:
    """Print a result: the table, or the object where there is none."""
    if table is None:
        typer.echo(json.dumps(result, allow_nan=False))
        return
    print_rich(table)


@commands.command()
def sail(
    scene: SceneName,
    out: Annotated[
        Path | None,
        typer.Option(metavar='DIR', help='Folder of the bag; without it no bag is written.'),
    ] = None,
    duration: Duration = None,
    settings: Settings = None,
    force: Annotated[bool, typer.Option('--force', help='Replace the bag in --out.')] = False,
    anyway: Anyway = False,
    as_json: AsJson = False,
) -> None:
    """Sail a scene without ROS: how far wrong is the clock?

    The result also says how far the ship is from where the clock puts her, and what the Act of
    1714 would have paid. With --out, `tauto report` makes a page of the bag.
    """
    from tauto_core import voyage
    from tauto_core.cli.terminal import progress_bar
    from tauto_core.scene import load_scene

    loaded = load_scene(scene, **given_values(settings, duration))
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
        ).result
    _warn(result.get('warnings', ()), odd)
    if as_json:
        _show(result, None)
        return
    from tauto_core.cli.tables import voyage_table

    _show(result, voyage_table(result))


@commands.command()
def replay(
    bag: Annotated[Path, typer.Argument(metavar='BAG', help='A rosbag2 folder or an .mcap file.')],
    scene: Annotated[
        str | None,
        typer.Option(metavar='SCENE', help='The scene, where the bag does not hold its own.'),
    ] = None,
    smooth: Annotated[
        bool,
        typer.Option(
            '--smooth',
            help='Also give the drift in hindsight: at each instant from all observations, those '
            'that came later too, as one works out a voyage at home. No navigator can have it at '
            'sea.',
        ),
    ] = False,
    stability: Annotated[
        bool,
        typer.Option(
            '--stability',
            help="Also give the stability of the clock: Allan's deviation and its kin against the "
            'averaging time, with 95 % confidence.',
        ),
    ] = False,
    plot: Annotated[
        Path | None,
        typer.Option(metavar='FILE', help='Draw the stability (.svg, .png); replaces the file.'),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Estimate drift and longitude again, from a bag alone."""
    from tauto_core import voyage
    from tauto_core.bags import read_bag
    from tauto_core.cli.tables import replay_tables
    from tauto_core.cli.terminal import progress_bar
    from tauto_core.files import check_plot
    from tauto_core.scene import load_scene

    if plot is not None:
        if not stability:
            raise UsageError('--plot draws what --stability gives. Give both, or neither')
        check_plot(plot)
    loaded = None if scene is None else load_scene(scene)
    with progress_bar(f'replay {bag}'):
        opened = read_bag(bag)
        replayed = voyage.replay(opened, loaded, smooth=smooth, stability=stability, keep=False)
    result = replayed.result
    _warn(result['warnings'])
    if plot is not None:
        replayed.plot('stability', plot)
        say(f'wrote {plot}')
    _show(result, None if as_json else replay_tables(result))


@commands.command()
def scenes(as_json: AsJson = False) -> None:
    """List the scenes that ship with Tauto, for `tauto sail NAME`."""
    from tauto_core.cli.scene import shipped_summary
    from tauto_core.scene import shipped_scenes

    found = {name: shipped_summary(name) for name in shipped_scenes()}
    if as_json:
        typer.echo(json.dumps({'scenes': found}))
        return
    width = max(map(len, found))
    for name, summary in found.items():
        typer.echo(f'{name:{width}}  {summary}')


@scene_commands.command()
def check(scene: SceneName, settings: Settings = None, as_json: AsJson = False) -> None:
    """Check a scene without sailing it, and say what would run.

    Machines and ships beyond all that are known are warned of, where commands that sail refuse
    them without --anyway.
    """
    from tauto_core.cli.scene import facts_table
    from tauto_core.cli.terminal import progress_bar
    from tauto_core.scene import load_scene
    from tauto_core.scene.errors import naming

    with progress_bar(scene) as progress:
        loaded = load_scene(scene, **given_values(settings))
        from tauto_core.checks.facts import scene_facts

        with naming(scene, loaded.name):
            facts = scene_facts(loaded, progress)
    _warn(facts.get('warnings', ()))
    _show(facts, None if as_json else facts_table(facts))


scene_commands.command(cls=scene.NewCommand)(scene.new)
scene_commands.command()(scene.schema)
commands.command()(curves.cam)
commands.command()(curves.isochronism)
commands.command()(curves.design)
commands.command()(hull.hull)
commands.command()(many.compare)
commands.command()(many.fleet)
commands.command()(show.plot)
commands.command()(show.report)
commands.command()(euler.euler)
add_to(commands)
