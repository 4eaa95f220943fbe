"""The commands of `tauto`.

Exit codes: 0 for success, 2 for a bad command line or scene, 1 for anything that failed on the
way, 130 after Ctrl-C, 143 after SIGTERM. Results go to stdout, messages to stderr; with `--json`
stdout holds one object and nothing else. A traceback means a fault of the program, never of its
input.
"""

from __future__ import annotations

import gc
import os
import re
import signal
import sys
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command_name, get_group
from typer.models import CommandInfo, TyperInfo

from tauto_core.cli import axle, curves, hull, logbook, scene, voyages
from tauto_core.cli.terminal import (
    Terminated,
    be_quiet,
    drop_output,
    option,
    prepare_streams,
    say_warnings,
    send_lost_again,
)
from tauto_core.scene.errors import TautoError, spelled

if TYPE_CHECKING:
    pass


# -----------------------------------------------------------------------------
# The commands that a Typer knows, built one at a time: to build them all takes 40 ms.


class Registered(Mapping[str, Any]):
    """Commands and groups by name, each built at its first use.

    Commands that the decorators of `register` add later are included.
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
        """Return the names of all commands and groups, commands first."""
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
    'machine with ROS 2 Jazzy see docs/howto/jazzy.md. `tauto sail` needs no ROS.'
)


class MissingCommandError(TautoError):
    """The distribution of a command, or a library that it needs, is not installed."""


def run_of_ros(ctx: typer.Context) -> None:
    """Pass the rest of the command line to the command of the same name."""
    from importlib.metadata import entry_points

    name = str(ctx.info_name)
    found = next(iter(entry_points(group=GROUP, name=name)), None)
    if found is None:
        raise MissingCommandError(
            f'`tauto {name}` needs tauto_nodes, which is not installed. {REMEDY}'
        )
    try:
        function = found.load()
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


commands = typer.Typer()
"""The Typer app that holds the commands."""


class Commands(TyperGroup):
    """All commands; they share the handling of errors and the option `--quiet`."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{**settings, 'commands': Registered(commands)})

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Remove `--quiet` from the command line, wherever it stands."""
        ours = args[: args.index('--')] if '--' in args else args
        be_quiet(not {'--quiet', '-q'}.isdisjoint(ours))
        kept = [word for word in ours if word not in ('--quiet', '-q')] + args[len(ours) :]
        if kept[:1] == ['plate']:  # the name of 0.2, for a release
            kept[:1] = ['cam', '--plate']
        return list(super().parse_args(ctx, kept))

    def invoke(self, ctx: Any) -> Any:
        """Run the command; turn errors into messages on stderr and an exit code."""
        try:
            return super().invoke(ctx)
        except typer.BadParameter as error:
            comma = (
                w for w in sys.argv[1:] if re.fullmatch(r'[-+]?\d*,\d+', w.rpartition('=')[2])
            )
            if word := next(comma, ''):
                error.message += f'. Write {word.replace(",", ".")}, with a decimal point'
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


app = typer.Typer(
    name='tauto',
    cls=Commands,
    no_args_is_help=True,
    add_completion=True,
    context_settings={'help_option_names': ['-h', '--help']},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


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
    gc.set_threshold(
        100_000
    )  # imports make many objects and no garbage, so collecting during them only costs time
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
    """Print an error on stderr, with its notes."""
    for line in (words, *getattr(error, '__notes__', ())):
        typer.echo(f'tauto: {line}', err=True)


scene_commands = typer.Typer(help='Look at one scene, or begin one.', no_args_is_help=True)
bag_commands = typer.Typer(
    help='See whether a bag is whole, or recover what is left of one.', no_args_is_help=True
)
commands.add_typer(scene_commands, name='scene')
commands.add_typer(bag_commands, name='bag')
commands.command()(voyages.sail)
commands.command()(voyages.replay)
commands.command()(scene.scenes)
commands.command()(curves.cam)
commands.command()(curves.isochronism)
commands.command()(axle.axle)
commands.command()(curves.design)
commands.command()(hull.hull)
commands.command()(logbook.logbook)
commands.command()(voyages.budget)
commands.command()(voyages.compare)
commands.command()(voyages.fleet)
commands.command()(voyages.plot)
commands.command()(voyages.report)
commands.command()(curves.euler)
scene_commands.command()(scene.check)
scene_commands.command(cls=scene.NewCommand)(scene.new)
scene_commands.command()(scene.schema)
bag_commands.command('check')(voyages.check_bag)
bag_commands.command('recover')(voyages.recover_bag)
for name, summary in ROS_COMMANDS.items():
    commands.command(
        name,
        help=summary,
        add_help_option=False,
        context_settings={'ignore_unknown_options': True, 'allow_extra_args': True},
    )(run_of_ros)
