"""Commands that other distributions add through the entry-point group `tauto.commands`.

They are loaded when they run, not for `tauto --help`; without their distribution the error names
the remedy.
"""

from __future__ import annotations

from typing import Any

import typer

from tauto_core.scene.errors import TautoError

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
