"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

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
