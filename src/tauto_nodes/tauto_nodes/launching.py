"""Shared by the launch files: arguments checked before anything starts, and the end of nodes."""

from __future__ import annotations

import atexit
import difflib
import hashlib
import math
import os
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from tauto_core.bags import check_folder, is_cut_short
from tauto_core.checks.readiness import check_known, check_scene
from tauto_core.samples import SHIP_IMU
from tauto_core.scene import load_scene, scene_yaml
from tauto_core.scene.errors import TautoError, spelled
from tauto_nodes import GraphError, ParameterError, as_parameter
from tauto_nodes.flow import RUN
from tauto_nodes.parameters import FOLDER_VARIABLE, PARAMETERS, write_parameters
from tauto_nodes.running import (
    SUPERVISOR,
    check_discovery,
    enclave_of,
    local_discovery,
    work_folder,
)

STOP_S = '60'
"""Time that a node has after SIGINT until SIGTERM, and after that until SIGKILL [s]. Launch's own
is 5 s; a recorder that is killed before it has closed its bag leaves it without metadata."""

ARGUMENTS = {
    'scene': 'scene file (absolute path) or name of a shipped scene',
    'speed': 'sea seconds in a second; 0.0: as fast as the graph can',
    'duration': "replaces the duration of the scene [s]; 0.0: the scene's own",
    'imu': 'topic of the sensor, sensor_msgs/Imu',
    'imu_reliability': 'what the sensor offers: best_effort or reliable',
    'imu_rotation': 'roll, pitch and yaw of the sensor, in degrees, as in 0 0 90; empty: as the '
    'clock',
    'out': 'folder of the bag; empty, with a sensor only: nothing is recorded',
    'force': 'replace a bag that is there',
    'anyway': 'sail machines and ships beyond all that are known, too',
    'state_folder': 'folder for the states of the stages; default: one for each scene, in '
    'tauto_states of ROS_HOME (~/.ros) or of TAUTO_FOLDER; empty: none is saved',
    'namespace': 'namespace of the nodes',
    'executor': 'what spins the nodes: events or single',
    'params_file': 'parameters of all nodes',
}
"""Arguments that launch files take: each file takes those for which it has a default."""

_ROLES = {
    'speed': 'ship_motion',
    'duration': 'ship_motion',
    'imu_reliability': 'trochlea',
    'executor': 'trochlea',
}
"""Arguments that are parameters of the same name, with a node whose table has them."""


def problems_of(given: Mapping[str, str]) -> list[str]:
    """Return what is wrong with the arguments of a launch, in words."""
    problems = []
    for name, role in _ROLES.items():
        if (text := given.get(name)) is None:
            continue
        parameter = next(parameter for parameter in PARAMETERS[role] if parameter.name == name)
        value: object = text
        if isinstance(parameter.default, float):
            try:
                value = float(text)
            except ValueError:
                value = math.nan
        if problem := parameter.problem(value):
            problems.append(problem.replace(' = nan', f' := {text}'))
    if not Path(given['params_file']).is_file():
        problems.append(f'params_file := {given["params_file"]}: there is no such file')
    flags = {name: given.get(name, 'false').lower() for name in ('force', 'anyway')}
    for name, flag in flags.items():
        if flag not in ('true', 'false'):
            problems.append(f'{name} := {given[name]}: must be true or false')
    if problems:
        return problems
    duration = float(given.get('duration', '0'))
    try:
        scene = load_scene(given['scene'], **({'duration': duration} if duration else {}))
        if flags['anyway'] == 'false':
            check_known(scene)
        check_scene(scene)
        if given['out']:
            check_folder(Path(given['out']), force=flags['force'] == 'true')
    except TautoError as error:
        return [spelled(error.message, as_parameter)]
    return (
        []
        if given['out'] or 'speed' not in given
        else ['out :=: a voyage is recorded; name a folder']
    )


def state_folder(given: Mapping[str, str]) -> str:
    """Return the folder of the states: that given, or by default one for the scene.

    A dial goes on where it stood only if it is the same clock, and so each scene has its own.
    """
    folder = given['state_folder']
    if folder != 'default':
        return str(Path(folder).absolute()) if folder else ''
    home = os.environ.get('ROS_HOME') or Path.home() / '.ros'
    scene = Path(given['scene'])
    text = hashlib.sha256(scene_yaml(load_scene(given['scene'])).encode()).hexdigest()
    place = Path(os.environ.get(FOLDER_VARIABLE) or home, 'tauto_states')
    return str(place.absolute() / f'{scene.stem}_{text[:8]}')


def strangers_of(typed: Iterable[str], known: Iterable[str]) -> list[str]:
    """Return, in words, which typed arguments are nearly one of the known; launch ignores them.

    Others may be those of a launch file that includes ours.
    """
    names = [argument.partition(':=')[0] for argument in typed]
    near = {
        name: match[0]
        for name in names
        if name not in known and (match := difflib.get_close_matches(name, known, 1, 0.75))
    }
    return [f'{name}: no such argument; the nearest is {match}' for name, match in near.items()]


def launch_description(
    defaults: Mapping[str, str],
    config: str,
    parameters: Callable[[Mapping[str, str]], Mapping[str, Mapping[str, object]]],
    *,
    last: str = '',
    environment: Callable[[], Mapping[str, str]] = local_discovery,
) -> Any:
    """Return the launch description of a graph: arguments, their check, nodes, their ends.

    The nodes talk within this machine unless the environment says otherwise, and end with the
    launch, even if it is killed. `defaults` are those of its arguments, names of ARGUMENTS;
    `config` is the default `params_file` in the share folder. Once the arguments have been
    checked, `parameters` is called with them and returns those of each node to start, by
    executable, and `environment` returns variables for the nodes. The good end of the node `last`
    is the end of the voyage; empty: there is none.
    """
    from launch import LaunchDescription  # type: ignore[attr-defined]  # our folder, to mypy
    from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable
    from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
    from launch_ros.actions import Node
    from launch_ros.substitutions import FindPackageShare

    share = FindPackageShare('tauto_nodes')
    known = {**defaults, 'params_file': PathJoinSubstitution([share, 'config', config])}

    def nodes(context: Any) -> list[Any]:
        given = {name: LaunchConfiguration(name).perform(context) for name in known}
        strange = strangers_of(context.argv, known)
        if problems := [*strange, *problems_of(given)]:
            raise ParameterError('; '.join(problems))
        check_discovery()
        variables = {SUPERVISOR: str(os.getpid()), RUN: str(time.time_ns()), **environment()}
        own = parameters(given)
        whole = {name: {'executor': given['executor'], **held} for name, held in own.items()}
        # A file of ours: from a mapping, launch_ros makes a temporary one for each node, and
        # leaves it there.
        kept = ExitStack()
        atexit.register(kept.close)
        folder = kept.enter_context(work_folder(os.environ.get(FOLDER_VARIABLE)))
        file = str(write_parameters(folder, given['namespace'], whole))
        imu, out = given.get('imu', SHIP_IMU), given['out']
        started = [
            Node(
                package='tauto_nodes',
                executable=name,
                name=name,
                namespace=given['namespace'],
                parameters=[given['params_file'], file],
                ros_arguments=enclave_of(name),
                remappings=[(SHIP_IMU, imu)] if imu != SHIP_IMU else [],
                output='screen',
                sigterm_timeout=STOP_S,
                sigkill_timeout=STOP_S,
                on_exit=lambda event, context, name=name: end_of(name, event, context, last, out),
            )
            for name in own
        ]
        return [
            *(SetEnvironmentVariable(name, value) for name, value in variables.items()),
            *started,
        ]

    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=value, description=ARGUMENTS[name])
                for name, value in known.items()
            ),
            OpaqueFunction(function=nodes),
        ]
    )


def end_of(name: str, event: Any, context: Any, last: str, out: str) -> list[Any]:
    """Return what a launch does when a node has ended: it ends, and well only if all was well.

    The good end of the node `last` is the end of the voyage; it has closed the bag `out` by then.
    For a node that ended before its time this raises GraphError, at which launch ends the others,
    and itself with 1. `event` is launch's ProcessExited.
    """
    if context.is_shutdown:
        return []
    if event.returncode == 0 and name == last:
        if is_cut_short(Path(out)):
            raise GraphError(
                f'node {name} was stopped before the voyage was over; {out} holds what was sailed '
                'until then, and says so (cut_short)'
            )
        from launch.actions import Shutdown

        return [Shutdown(reason='the voyage is over')]
    raise GraphError(f'node {name} ended with exit code {event.returncode} before its time')
