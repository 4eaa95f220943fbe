"""`tauto scenes`, and `tauto scene show`, `new` and `schema`."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from typing import Any

import typer
from typer.core import TyperCommand, TyperOption

from tauto_core.cli.terminal import SceneName


def shipped_summary(name: str) -> str:
    """Return the description of a built-in scene: its first comment, up to the colon."""
    text = (files('tauto_core.scene') / 'shipped' / f'{name}.yaml').read_text(encoding='utf-8')
    lines = []
    for line in text.splitlines():
        if not line.startswith('#'):
            break
        lines.append(line.lstrip('# '))
    return ' '.join(lines).partition(':')[0]


def scenes(names: list[str], as_json: bool, _: Mapping[str, Any]) -> dict[str, Any] | str:
    """Return the built-in scenes with their descriptions."""
    summaries = {name: shipped_summary(name) for name in names}
    if as_json:
        return {'scenes': summaries}
    width = max(map(len, summaries))
    return '\n'.join(f'{name:{width}}  {summary}' for name, summary in summaries.items())


class NewCommand(TyperCommand):
    """`tauto scene new`: its help lists the installed kinds."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help, with the kinds of each section."""
        from tauto_core.scene.reference import CHOICES
        from tauto_core.scene.sections import kind_of, kinds_in

        for option in self.params:
            if isinstance(option, TyperOption) and option.name in CHOICES:
                names = [kind_of(model) for model in kinds_in(CHOICES[option.name])]
                suffix = '; without it there is none' if option.name == 'escapement' else ''
                option.help = f'{", ".join(names[:-1])} or {names[-1]}{suffix}.'
        super().format_help(ctx, formatter)


def show(scene: SceneName) -> None:
    """Print the file of a scene, with its comments."""
    from tauto_core.scene.loader import scene_text

    typer.echo(scene_text(scene), nl=False)


def schema() -> None:
    """Print the JSON schema of scenes, for editors."""
    from tauto_core.scene.reference import FILE

    typer.echo(FILE.read_text(encoding='utf-8'), nl=False)
