"""What the launch files share: arguments checked before anything starts, ends that are seen."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tauto_core.bags import check_folder
from tauto_core.readiness import check_scene
from tauto_core.scene import load_scene
from tauto_core.scene.errors import TautoError
from tauto_nodes.errors import GraphError
from tauto_nodes.parameters import PARAMETERS

PROFILES = ('FASTDDS_DEFAULT_PROFILES_FILE', 'FASTRTPS_DEFAULT_PROFILES_FILE')
"""Environment variables that name a profile of Fast DDS, of 3 and of 2."""


def fast_dds_profile() -> dict[str, str]:
    """Return the environment that gives a graph of ours its profile; empty where one is set."""
    if any(os.environ.get(name) for name in PROFILES):
        return {}
    return {PROFILES[1]: str(Path(__file__).with_name('fastdds.xml'))}


def voyage_problems(given: Mapping[str, str]) -> list[str]:
    """Return what is wrong with the arguments of voyage.launch.py, in words."""
    problems = [
        *_of_table('ship_motion', {name: given[name] for name in ('speed', 'duration')}),
        *_of_table('trochlea', {'executor': given['executor']}),
        *_file(given['params_file']),
    ]
    force = given['force'].lower()
    if force not in ('true', 'false'):
        problems.append(f'force := {given["force"]}: must be true or false')
    if problems:
        return problems
    duration = float(given['duration'])
    try:
        scene = load_scene(given['scene'], **({'duration': duration} if duration else {}))
        check_scene(scene)
        check_folder(Path(given['out']), force=force == 'true')
    except TautoError as error:
        return [str(error)]
    return []


def live_problems(given: Mapping[str, str]) -> list[str]:
    """Return what is wrong with the arguments of live.launch.py, in words."""
    names = ('executor', 'imu_reliability')
    problems = [
        *_of_table('trochlea', {name: given[name] for name in names}),
        *_file(given['params_file']),
    ]
    try:
        check_scene(load_scene(given['scene']))
        if given['out']:
            check_folder(Path(given['out']))
    except TautoError as error:
        problems.append(str(error))
    return problems


def _of_table(role: str, given: Mapping[str, str]) -> list[str]:
    """Return what the table of parameters says against launch arguments of the same names."""
    problems = []
    for parameter in PARAMETERS[role]:
        if parameter.name not in given:
            continue
        text = given[parameter.name]
        value: object = text
        if isinstance(parameter.default, float):
            try:
                value = float(text)
            except ValueError:
                value = math.nan
        if problem := parameter.problem(value):
            problems.append(problem.replace(' = nan', f' := {text}'))
    return problems


def _file(name: str) -> list[str]:
    return [] if Path(name).is_file() else [f'params_file := {name}: there is no such file']


def end_of(name: str, event: Any, context: Any, *, last: str) -> list[Any]:
    """Return what a launch does when a node has ended: it ends, and well only if all was well.

    Args:
        name: of the node.
        event: launch's ProcessExited.
        context: of the launch.
        last: the node whose good end is the end of the voyage; empty: there is none.

    Raises:
        GraphError: it ended before its time; launch then ends the others, and itself with 1.
    """
    if context.is_shutdown:
        return []
    if event.returncode == 0 and name == last:
        from launch.actions import Shutdown

        return [Shutdown(reason='the voyage is over')]
    raise GraphError(f'node {name} ended with exit code {event.returncode} before its time')
