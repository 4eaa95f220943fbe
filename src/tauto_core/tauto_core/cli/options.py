"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, TypeAlias

import typer

from tauto_core.scene.errors import ABSENT, SceneError, UsageError

SceneName: TypeAlias = Annotated[
    str,
    typer.Argument(metavar='SCENE', help='A YAML file, or a name that `tauto scenes` lists.'),
]
AsJson: TypeAlias = Annotated[
    bool, typer.Option('--json', help='Print one JSON object on stdout, nothing else there.')
]
Plots: TypeAlias = Annotated[
    list[Path] | None,
    typer.Option(
        '--plot', metavar='FILE', help='Draw it as .svg, .png or .pdf; replaces the file.'
    ),
]
Anyway: TypeAlias = Annotated[
    bool,
    typer.Option('--anyway', help='Sail machines and ships beyond all that are known, too.'),
]
Duration: TypeAlias = Annotated[
    float | None, typer.Option(metavar='S', help='Sail this long instead [s].')
]
Settings: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        '--set',
        metavar='KEY=VALUE',
        help='Another value for a key of the scene, such as ship.sea.peak_period=8; may come '
        'several times. The value null removes the key.',
    ),
]


def given_values(settings: list[str] | None, duration: float | None = None) -> dict[str, Any]:
    """Return what --set and --duration change in a scene, by the paths of the keys.

    `ABSENT` stands for null, which removes a key.

    Raises:
        UsageError: no KEY=VALUE, a value that is no YAML or empty, or a key that comes twice.
    """
    from tauto_core.scene.yaml_text import read_mapping

    given: dict[str, Any] = {} if duration is None else {'duration': duration}
    for setting in settings or ():
        path, equals, text = (part.strip() for part in setting.partition('='))
        if not path or not equals:
            raise UsageError(f'--set {setting}: has no KEY=. Write for example duration=600')
        if path in given:
            raise UsageError(f'--set {setting}: {path} is given twice. Leave one of them out')
        try:
            given[path] = read_mapping(f'value: {text}', '--set')['value']
        except SceneError as error:
            raise UsageError(
                f'--set {setting}: {error.problem}. Write one value, in quotes for the shell '
                "where it has blanks or brackets: --set 'voyage.departure=[50.8, -1.1]'"
            ) from None
        if given[path] is None and text.lower() not in ('null', '~'):
            raise UsageError(f'--set {setting}: has no value. Write one after the =')
        if given[path] is None:
            given[path] = ABSENT
    return given
