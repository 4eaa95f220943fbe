"""`tauto scenes`, `tauto scene …`: list the built-in scenes, check a scene, write a new one."""

from __future__ import annotations

import json
import shlex
from importlib.resources import files
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperOption

from tauto_core.cli.terminal import (
    Accuracy,
    AsJson,
    SceneName,
    Settings,
    given_values,
    progress_bar,
    say,
    say_once,
    show_result,
)
from tauto_core.scene.errors import naming


def shipped_summary(name: str) -> str:
    """Return the description of a built-in scene: its first comment, up to the colon."""
    text = (files('tauto_core.scene') / 'shipped' / f'{name}.yaml').read_text(encoding='utf-8')
    lines = []
    for line in text.splitlines():
        if not line.startswith('#'):
            break
        lines.append(line.lstrip('# '))
    return ' '.join(lines).partition(':')[0]


def scenes(as_json: AsJson = False) -> None:
    """List the built-in scenes, for `tauto sail NAME`."""
    from tauto_core.scene import shipped_scenes

    found = {name: shipped_summary(name) for name in shipped_scenes()}
    if as_json:
        typer.echo(json.dumps({'scenes': found}))
        return
    width = max(map(len, found))
    for name, summary in found.items():
        typer.echo(f'{name:{width}}  {summary}')


def check(
    scene: SceneName,
    accuracy: Accuracy = None,
    settings: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Check a scene without sailing it: cost, accuracy and omissions.

    Machines and ships beyond all that are known cause a warning here; commands that sail refuse
    them without --anyway.
    """
    from tauto_core.scene import load_scene

    with progress_bar(scene) as progress:
        loaded = load_scene(scene, **given_values(settings, accuracy=accuracy))
        from tauto_core.checks.facts import scene_facts

        with naming(scene, loaded.name):
            facts = scene_facts(loaded, progress)
    say_once(facts.get('warnings', ()))
    if as_json:
        show_result(facts, None)
        return
    from tauto_core.cli.tables import facts_table

    show_result(facts, facts_table(facts))


KindChoice = Annotated[str | None, typer.Option(metavar='KIND')]


class NewCommand(TyperCommand):
    """`tauto scene new`: its help lists the kinds found when the help is printed."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help, with the kinds of each section."""
        from tauto_core.scene.reference import ASKED
        from tauto_core.scene.sections import kind_of, kinds_in

        for option in self.params:
            if isinstance(option, TyperOption) and option.name in ASKED:
                names = [kind_of(model) for model in kinds_in(ASKED[option.name])]
                none = '; without it there is none' if option.name == 'escapement' else ''
                option.help = f'{", ".join(names[:-1])} or {names[-1]}{none}.'
        super().format_help(ctx, formatter)


def new(
    ship: KindChoice = None,
    cam: KindChoice = None,
    thread: KindChoice = None,
    power: KindChoice = None,
    escapement: KindChoice = None,
    out: Annotated[
        str | None,  # a Path drops the slash of a folder
        typer.Option(
            '--out',
            '-o',
            metavar='FILE',
            help='The file, ending in .yaml; without it, standard output.',
        ),
    ] = None,
) -> None:
    """Write a scene that sails, with the unit and meaning of every key.

    Kinds that are not named are chosen to fit those that are. Without any, the scene is Euler's
    involute under a weight, in a wind sea.
    """
    from tauto_core.scene.reference import write_scene

    asked = {'ship': ship, 'cam': cam, 'thread': thread, 'power': power, 'escapement': escapement}
    text = write_scene(out, {key: kind for key, kind in asked.items() if kind is not None})
    if out is None:
        typer.echo(text, nl=False)
    else:
        say(f'wrote {out}. Sail it with: {shlex.join(("tauto", "sail", out))}')


def schema() -> None:
    """Print the JSON schema by which editors check scenes."""
    from tauto_core.scene.reference import FILE

    typer.echo(FILE.read_text(encoding='utf-8'), nl=False)
