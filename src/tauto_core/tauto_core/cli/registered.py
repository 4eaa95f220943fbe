"""The commands that a Typer knows, built one at a time: to build them all takes 40 ms."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import typer
from typer.main import get_command_name, get_group
from typer.models import CommandInfo, TyperInfo


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
