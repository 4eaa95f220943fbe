"""The program `launch_plan`: it checks the arguments of a launch file and plans its nodes.

`ros2 launch` runs in the system's Python, which need not see what the nodes need, so the launch
files ask this program, which runs in the Python of the nodes.
"""

from __future__ import annotations

import difflib
import hashlib
import json
import math
import os
import sys
import time
from collections.abc import Iterable, Mapping
from pathlib import Path

from tauto_core.bags import check_folder
from tauto_core.checks.readiness import check_known, check_scene
from tauto_core.samples import OBSERVATION, SHIP_FIX, SHIP_IMU
from tauto_core.scene import load_scene, scene_yaml
from tauto_core.scene.errors import TautoError, spelled
from tauto_nodes import ParameterError, as_parameter
from tauto_nodes.flow import RUN
from tauto_nodes.parameters import (
    FOLDER_VARIABLE,
    PARAMETERS,
    check_executor,
    write_parameters,
)
from tauto_nodes.running import (
    SUPERVISOR,
    check_discovery,
    graph_middleware,
    local_discovery,
    remove_left,
)

# Arguments that are parameters of the same name, with a node whose table has them.
_ROLES = {
    'speed': 'ship_motion',
    'duration': 'ship_motion',
    'imu_reliability': 'trochlea',
    'executor': 'trochlea',
}

_FLAGS = ('force', 'anyway', 'publish_clock', 'use_sim_time', 'markers')


def problems_of(given: Mapping[str, str]) -> list[str]:
    """Return the problems of the arguments of a launch, in words."""
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
    flags = {name: given.get(name, 'false').lower() for name in _FLAGS}
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
    nowhere = not given['out'] and 'speed' in given
    return ['out :=: a voyage is recorded; name a folder'] if nowhere else []


def state_folder(given: Mapping[str, str]) -> str:
    """Return the folder of the states: that given, or by default one for the scene.

    A dial may only continue the same clock, so each scene has its own folder.
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
    """Return the typed arguments that resemble a known one, in words; launch would ignore them.

    Others may be those of a launch file that includes ours.
    """
    names = [argument.partition(':=')[0] for argument in typed]
    near = {
        name: match[0]
        for name in names
        if name not in known and (match := difflib.get_close_matches(name, known, 1, 0.75))
    }
    return [f'{name}: no such argument; the nearest is {match}' for name, match in near.items()]


# -----------------------------------------------------------------------------
# The parameters of the nodes of each kind of launch, by executable.


def voyage_nodes(given: Mapping[str, str]) -> dict[str, dict[str, object]]:
    """Return the nodes of voyage.launch.py."""
    common = {'scene': given['scene'], 'duration': float(given['duration']), 'packed': True}
    bag = {'output': str(Path(given['out']).absolute()), 'force': _is_true(given['force'])}
    pace = {'speed': float(given['speed']), 'publish_clock': _is_true(given['publish_clock'])}
    nodes: dict[str, dict[str, object]] = {
        'recorder': {**common, **bag},
        'longitude': {**common},
        'drift_estimator': {**common},
        'trochlea': {**common},
        'ship_motion': {**common, **pace},
    }
    if _is_true(given['markers']):
        nodes['markers'] = {'scene': given['scene']}
    return nodes


def live_nodes(given: Mapping[str, str]) -> dict[str, dict[str, object]]:
    """Return the nodes of live.launch.py."""
    sensor = {'imu_reliability': given['imu_reliability']}
    mounted = {**sensor, 'imu_rotation': given['imu_rotation']}
    stage = {'scene': given['scene'], 'state_folder': state_folder(given)}
    nodes: dict[str, dict[str, object]] = {
        'longitude': {**stage},
        'drift_estimator': {**stage, **mounted},
        'trochlea': {**stage, **mounted},
    }
    if given['out']:
        nodes['recorder'] = {
            'scene': given['scene'],
            'output': str(Path(given['out']).absolute()),
            'topics': ['all', *given['topics'].split()],
            'beside': True,
            'executor': 'single',  # it alone reports when a message was sent
            **sensor,
        }
    if _is_true(given['markers']):
        nodes['markers'] = {'scene': given['scene'], **sensor}
    if _is_true(given['use_sim_time']):
        nodes = {name: {**held, 'use_sim_time': True} for name, held in nodes.items()}
    return nodes


def _is_true(flag: str) -> bool:
    return flag.lower() == 'true'


def launch_plan() -> None:
    """Answer the question on standard input, in JSON; exit code 2 says that the launch is refused.

    The question has the `kind` of launch, the arguments `given`, the words `typed`, the `folder`
    for the parameters, and the process of the launch, the `supervisor`. The answer has the names
    of the `nodes`, their `environment` and the `remappings`.
    """
    asked = json.load(sys.stdin)
    given, folder = asked['given'], Path(asked['folder'])
    remove_left(folder.parent)
    live = asked['kind'] == 'live'
    try:
        if problems := [*strangers_of(asked['typed'], given), *problems_of(given)]:
            raise ParameterError('; '.join(problems))
        check_executor(given['executor'])
        check_discovery()
        environment = local_discovery() if live else graph_middleware()
        nodes = live_nodes(given) if live else voyage_nodes(given)
    except TautoError as error:
        sys.stderr.write(spelled(error.message, as_parameter) + '\n')
        sys.exit(ParameterError.exit_code)
    executor = {'executor': given['executor']}
    whole = {name: {**executor, **held} for name, held in nodes.items()}
    write_parameters(folder, given['namespace'], whole)
    named = {SHIP_IMU: 'imu', OBSERVATION: 'observation', SHIP_FIX: 'fix'}
    remappings = {
        topic: given[name] for topic, name in named.items() if given.get(name, topic) != topic
    }
    supervised = {SUPERVISOR: str(asked['supervisor']), RUN: str(time.time_ns())}
    answer = {
        'nodes': list(nodes),
        'environment': {**environment, **supervised},
        'remappings': remappings,
    }
    sys.stdout.write(json.dumps(answer) + '\n')
