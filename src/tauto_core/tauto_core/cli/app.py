"""The commands of `tauto`.

Exit codes: 0 for success, 2 for a bad command line or scene, 1 for another failure, 130 after
Ctrl-C, 143 after SIGTERM, 129 after SIGHUP. Results go to stdout, messages to stderr. With
`--json` stdout has exactly one object. Wrong input never causes a traceback.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, NamedTuple, TypeAlias

import typer
from typer.core import TyperGroup
from typer.main import get_group

from tauto_core import api
from tauto_core.cli import shown
from tauto_core.cli.calls import Command, signature_of
from tauto_core.cli.terminal import (
    SceneName,
    Terminated,
    drop_output,
    ended_by_sigterm,
    messages,
    option,
    prepare_streams,
    progress_bar,
    saying_warnings,
    send_lost_again,
)
from tauto_core.scene.errors import Argument, ArgumentText, TautoError, UsageError, spelled

# -----------------------------------------------------------------------------
# The commands by name, built one at a time, since building all takes 40 ms.


class Group(NamedTuple):
    """Commands under one word, with their help."""

    help: str
    commands: Mapping[str, Command | Callable[..., None]]


Entry: TypeAlias = Command | Group | Callable[..., None]


class Registered(Mapping[str, Any]):
    """Commands and groups of the parser by name, built at their first use."""

    def __init__(self, entries: Mapping[str, Entry]) -> None:
        self._entries = entries
        self._built: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        """Return a command or a group."""
        if name not in self._built:
            alone, entry = typer.Typer(rich_markup_mode=None), self._entries[name]
            if isinstance(entry, Group):
                group = typer.Typer(help=entry.help, no_args_is_help=True)
                for word, command in entry.commands.items():
                    _add(group, word, command)
                alone.add_typer(group, name=name)
            else:
                _add(alone, name, entry)
            self._built[name] = get_group(alone).commands[name]
        return self._built[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)


def _add(to: typer.Typer, name: str, entry: Command | Callable[..., None]) -> None:
    if isinstance(entry, Command):
        to.command(name)(entry.function())
    elif name in ROS_COMMANDS:
        passing = {'ignore_unknown_options': True, 'allow_extra_args': True}
        settings: Any = {'add_help_option': False, 'context_settings': passing}
        to.command(name, help=ROS_COMMANDS[name], **settings)(entry)
    else:
        to.command(name)(entry)


# -----------------------------------------------------------------------------
# Commands that other distributions add through the entry-point group `tauto.commands`, loaded when
# they run.

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
    """The distribution of a command, or a library it needs, is not installed."""

    def __init__(self, command: str, needed: str) -> None:
        super().__init__(f'`tauto {command}` needs {needed}, which is not installed. {REMEDY}')


def run_of_ros(ctx: typer.Context) -> None:
    """Pass the rest of the command line to the command of the same name."""
    from importlib.metadata import entry_points

    name = str(ctx.info_name)
    entry_point = next(iter(entry_points(group=GROUP, name=name)), None)
    if entry_point is None:
        raise MissingCommandError(name, 'tauto_nodes')
    try:
        function = entry_point.load()
        holder = typer.Typer(add_completion=False, rich_markup_mode=None)
        holder.command(name)(function)
        command: Any = typer.main.get_command(holder)
        with command.make_context(name, list(ctx.args), parent=ctx.parent) as inner:
            command.invoke(inner)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition('.')[0] not in ('rclpy', 'tauto_nodes'):
            raise
        raise MissingCommandError(name, error.name) from None


class Commands(TyperGroup):
    """All commands, with the handling of errors and the option `--quiet`."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{**settings, 'commands': Registered(ENTRIES)})

    def format_commands(self, _ctx: Any, formatter: Any) -> None:
        """Write the first line of each command's help, without building the command."""
        with formatter.section('Commands'):
            formatter.write_dl([(name, _summary(name)) for name in ENTRIES])

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Remove `--quiet` from any place in the command line, and translate old words."""
        ours = args[: args.index('--')] if '--' in args else args
        messages['are_quiet'] = not {'--quiet', '-q'}.isdisjoint(ours)
        words = [word for word in ours if word not in ('--quiet', '-q')] + args[len(ours) :]
        if words[:1] == ['plate']:  # the name of 0.2, for a release
            words[:1] = ['cam', '--plate']
        options = {word.partition('=')[0] for word in words}
        for name, (command, instead) in api.GONE.items():
            if words[:1] == [command] and option(Argument(name)) in options:
                raise typer.BadParameter(spelled(ArgumentText(Argument(name), instead), option))
        return list(super().parse_args(ctx, words))

    def invoke(self, ctx: Any) -> Any:
        """Run the command, and convert errors to messages on stderr and an exit code."""
        try:
            with saying_warnings():
                return super().invoke(ctx)
        except TautoError as error:
            _tell(spelled(error.message, option), error)
            raise typer.Exit(error.exit_code) from None
        except Terminated as error:
            _tell('terminated', error)
            raise typer.Exit(128 + error.args[0]) from None
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


def _summary(name: str) -> str:
    entry = ENTRIES[name]
    if isinstance(entry, Group):
        return entry.help
    docs = entry.docs if isinstance(entry, Command) else ROS_COMMANDS.get(name, entry.__doc__)
    return (docs or '').partition('\n')[0]


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
            help='Print only the result and errors. May be anywhere in the command line.',
        ),
    ] = False,
) -> None:
    """Sully and Euler's sea clock on a rolling ship: how far wrong is it on the chart?"""


def run() -> None:
    """Run `tauto` with the arguments of the process; never returns."""
    # pydantic would search all installed packages for plugins
    os.environ.setdefault('PYDANTIC_DISABLE_PLUGINS', '__all__')
    prepare_streams()
    send_lost_again()
    gc.set_threshold(100_000)  # imports create many objects and no garbage
    try:
        app()
    except OSError as error:
        # typer handles a closed pipe
        if error.filename is not None:
            _tell(f'{error.filename}: {error.strerror}. Name another place', error)
        else:
            _tell(f'standard output cannot be written: {error.strerror}. Make room', error)
            drop_output()
    except MemoryError as error:
        _tell('out of memory. Sail a shorter scene, or give the process more memory', error)
    sys.exit(1)


def _tell(words: str, error: BaseException) -> None:
    """Print an error on stderr, with its notes."""
    for line in (words, *getattr(error, '__notes__', ())):
        typer.echo(f'tauto: {line}', err=True)


# -----------------------------------------------------------------------------
# Commands that are more than one call, or none.


def cam(given: dict[str, Any]) -> Any:
    """Return a cam, by default with few points if they are only printed."""
    files = 'csv', 'svg', 'dxf', 'step', 'stl'
    if given.keys().isdisjoint(files) and not given['plate']:
        given.setdefault('points', 11)
    with progress_bar('cam'):
        return api.cam(**given)


def fleet(given: dict[str, Any]) -> Any:
    """Send many ships on one voyage, or clocks along the passages of a log-book."""
    call, other_call = ('trial', 'fleet') if 'logs' in given else ('fleet', 'trial')
    unknown = signature_of(other_call).keys() - signature_of(call).keys()
    for name, value in given.items():
        if name in unknown and value is not False:
            wrong = ': needs ', Argument('logs'), '. Name a log-book, or leave it out'
            if call == 'trial':
                wrong = ': does not go with ', Argument('logs'), '. Leave one of them out'
            raise UsageError(Argument(name, value), *wrong)
    chosen = {key: value for key, value in given.items() if key not in unknown}
    things = 'voyages' if call == 'trial' else 'ships'
    with ended_by_sigterm(), progress_bar(things) as progress:
        return getattr(api, call)(**chosen, progress=progress)


def show_scene(scene: SceneName) -> None:
    """Print the file of a scene, with its comments."""
    from tauto_core.scene.loader import scene_text

    typer.echo(scene_text(scene), nl=False)


def print_schema() -> None:
    """Print the JSON schema of scenes, for editors."""
    from tauto_core.scene.reference import FILE

    typer.echo(FILE.read_text(encoding='utf-8'), nl=False)


DRAWN: Any = {
    'shown': lambda *_: None,
    'has_json': False,
    'has_scene': True,
    'warns': True,
    'writes': ('file',),
}
ENTRIES: dict[str, Entry] = {
    'sail': Command(('sail',), shown.voyage, has_scene=True, warns=True, writes=()),
    'replay': Command(('replay',), shown.voyage),
    'scenes': Command(('scenes',), shown.scenes),
    'cam': Command(('cam',), shown.cam, has_scene=True, writes=(), run=cam),
    'isochronism': Command(('isochronism',), shown.isochronism, has_scene=True),
    'axle': Command(('axle',), shown.axle),
    'altitudes': Command(('altitudes',), shown.altitudes),
    'design': Command(('design',), shown.design, writes=('file',)),
    'hull': Command(('hull',), shown.hull, writes=('out', 'plot')),
    'logbook': Command(('logbook',), shown.logbook),
    'budget': Command(('budget',), shown.budget, has_scene=True, warns=True),
    'compare': Command(('compare',), shown.comparison),
    'fleet': Command(('fleet', 'trial'), shown.fleet, has_scene=True, run=fleet),
    'plot': Command(('plot',), **DRAWN, default_file='{title}_{what}.svg'),
    'report': Command(('report',), **DRAWN, default_file='{title}.html'),
    'euler': Command(
        ('claims',),
        shown.claims,
        writes=('site',),
        holds=lambda claims: all(claim.verdict == claim.expected for claim in claims),
    ),
    **dict.fromkeys(ROS_COMMANDS, run_of_ros),
    'scene': Group(
        'Check or print a scene, or write a new one.',
        {
            'check': Command(('check',), shown.facts, has_scene=True),
            'new': Command(('new_scene',), shown.scene, has_json=False),
            'show': show_scene,
            'schema': print_schema,
        },
    ),
    'bag': Group(
        'Check a bag, or recover its readable messages.',
        {
            'check': Command(('check_bag',), shown.soundness, holds=lambda bag: bag.whole),
            'recover': Command(('recover_bag',), shown.recovered, writes=()),
        },
    ),
}
"""All commands, in the order of the help."""
