"""Programs of command line and launch files: `tauto graph`, `tauto play`, `launch_plan`."""

from __future__ import annotations

import difflib
import hashlib
import json
import math
import os
import secrets
import sys
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tauto_core import api
from tauto_core.bags import check_folder
from tauto_core.checks.readiness import check_known, check_scene
from tauto_core.cli.calls import option_of
from tauto_core.cli.terminal import AsJson, SceneName, Settings, given_values
from tauto_core.samples import OBSERVATION, SHIP_FIX, SHIP_IMU
from tauto_core.scene import load_scene, scene_yaml
from tauto_core.scene.errors import TautoError, UsageError, spelled
from tauto_nodes import ParameterError, as_parameter

if TYPE_CHECKING:
    pass

# -----------------------------------------------------------------------------
# `tauto graph` and `tauto play`. The command line loads them from the group `tauto.commands`.

MAX_SPEED = 1e6


def _namespace(text: str) -> str:
    from rclpy.exceptions import InvalidNamespaceException
    from rclpy.validate_namespace import validate_namespace

    name = text.strip('/')
    try:
        validate_namespace(f'/{name}')
    except InvalidNamespaceException as error:
        raise UsageError(f'--namespace {text!r}: {error}'.replace('\n', ' ')) from error
    return name


def graph(
    scene: SceneName,
    *,
    speed: Annotated[
        str, typer.Option(metavar='X|max', help='Sea seconds in a second, or as fast as it goes.')
    ] = '60',
    out: Annotated[
        Path | None,
        typer.Option(metavar='DIR', help='Folder of the bag. Default: bags/out/SCENE.'),
    ] = None,
    force: Annotated[bool, option_of('sail', 'force')] = False,
    anyway: Annotated[bool, option_of('sail', 'anyway')] = False,
    duration: Annotated[str | None, option_of('sail', 'duration')] = None,
    accuracy: Annotated[str | None, option_of('sail', 'accuracy')] = None,
    settings: Settings = None,
    namespace: Annotated[str, typer.Option(metavar='NAME', help='Namespace of the graph.')] = '',
    as_json: AsJson = False,
) -> None:
    """Sail a scene as real ROS 2 nodes, recorded to MCAP."""
    from tauto_core.cli.tables import aligned, voyage_table
    from tauto_core.cli.terminal import progress_bar, say_plausibility
    from tauto_core.scene.errors import naming
    from tauto_core.voyage import compile_kernels, summarise_bag
    from tauto_nodes.simulation.supervisor import GraphPlan, run_graph

    try:
        pace = 0.0 if speed == 'max' else float(speed)
    except ValueError:
        pace = math.nan
    if speed != 'max' and not 0.0 < pace <= MAX_SPEED:  # also false for NaN
        raise UsageError(
            f'--speed {speed}: must be a number in (0, {MAX_SPEED:g}], sea seconds a second, or '
            'max'
        )
    loaded = api.load(scene, duration=duration, accuracy=accuracy, **given_values(settings))
    say_plausibility(loaded, scene, anyway=anyway)
    with naming(scene, loaded.name):
        check_scene(loaded)
    folder = out or Path('bags/out') / Path(scene).stem
    check_folder(folder, force=force)
    plan = GraphPlan(
        scene,
        folder,
        0.0 if duration is None else loaded.duration,
        pace,
        force,
        _namespace(namespace),
        changed=bool(settings) or accuracy is not None,
    )
    began_s = time.monotonic()
    with progress_bar(loaded.name) as progress:
        compile_kernels(loaded)  # once, and not in each node
        outcome = run_graph(plan, loaded, progress)
    heads = 'received', 'written', 'lost'
    counts = (
        (topic, *(str(numbers[key]) for key in heads)) for topic, numbers in outcome.counts.items()
    )
    typer.echo('\n'.join(aligned([('topic', *heads), *counts])), err=True)
    for line in outcome.node_warnings:
        typer.echo(f'tauto: the graph said: {line}', err=True)
    if outcome.signal:
        sailed = any(numbers['written'] for numbers in outcome.counts.values())
        kept = f'{folder} holds the voyage until then' if sailed else 'no message was recorded yet'
        typer.echo(f'tauto: stopped early, {kept}', err=True)
        raise typer.Exit(128 + outcome.signal)
    result: dict[str, Any] = {
        **summarise_bag(folder),
        'wall_s': time.monotonic() - began_s,
        'start_s': outcome.start_s,
        'voyage_s': outcome.voyage_s,
        'topics': outcome.counts,
        'bag': str(folder),
    }
    if as_json:
        typer.echo(json.dumps(result, allow_nan=False))
    else:
        typer.echo(voyage_table(result))
    if outcome.lost:
        typer.echo(f'tauto: {outcome.lost} messages were lost on the way', err=True)
        raise typer.Exit(1)


def play(
    bag: Annotated[Path, typer.Argument(metavar='BAG', help='A rosbag2 folder or an .mcap file.')],
    *,
    rate: Annotated[
        float, typer.Option(metavar='X', min=1e-3, max=1e6, help='Seconds of the bag in a second.')
    ] = 1.0,
    topic: Annotated[
        list[str] | None,
        typer.Option(
            metavar='TOPIC',
            help='A topic to play, or all. Default: the topics that drive the graph.',
        ),
    ] = None,
    namespace: Annotated[str, typer.Option(metavar='NAME', help='Namespace to play into.')] = '',
    publish_clock: Annotated[
        bool, typer.Option('--publish-clock', help='Publish /clock as well.')
    ] = False,
) -> None:
    """Play a bag into a ROS 2 graph, in the domain that the environment names."""
    from tauto_core.bags import read_bag
    from tauto_core.cli.terminal import say
    from tauto_nodes.live import run_nodes
    from tauto_nodes.live.player import PlayerNode

    read_bag(bag)
    arguments = ['--ros-args', '-r', f'__ns:=/{_namespace(namespace)}']
    values: dict[str, Any] = {'bag': str(bag), 'rate': float(rate), 'publish_clock': publish_clock}
    if topic:
        values['topics'] = list(topic)
    for name, value in values.items():
        arguments += ['-p', f'{name}:={json.dumps(value)}']
    say(f'{bag}: plays when each topic has a subscriber, after two seconds anyway')
    if code := run_nodes((PlayerNode,), arguments):
        raise typer.Exit(code)


# -----------------------------------------------------------------------------
# The program `launch_plan`: it checks the arguments of a launch file and plans its nodes.
#
# `ros2 launch` runs in the system's Python, which may lack the nodes' packages, so the launch
# files ask this program, which runs in the Python of the nodes.

_NUMBERS = ('speed', 'duration')
_FLAGS = ('force', 'anyway', 'publish_clock', 'use_sim_time', 'markers')


def nodes_of(kind: str, given: Mapping[str, str]) -> dict[str, dict[str, object]]:
    """Return the parameters of the nodes of a launch by executable, for the arguments `given`.

    TautoError: an argument is refused.
    """
    from tauto_nodes.live.parameters import PARAMETERS

    values: dict[str, Any] = dict(given)
    for name, text in given.items():
        try:
            if name in _FLAGS:
                values[name] = {'true': True, 'false': False}[text.lower()]
            elif name in _NUMBERS:
                values[name] = float(text)
        except (KeyError, ValueError):
            what = 'true or false' if name in _FLAGS else 'a number'
            raise ParameterError(f'{name} := {text}: must be {what}') from None
    duration = values.get('duration')
    scene = load_scene(given['scene'], **({'duration': duration} if duration else {}))
    if not values['anyway']:
        check_known(scene)
    check_scene(scene)
    if not Path(given['params_file']).is_file():
        raise ParameterError(f'params_file := {given["params_file"]}: there is no such file')
    nodes = live_nodes(values) if kind == 'live' else voyage_nodes(values)
    problems = [
        problem
        for role, held in nodes.items()
        for parameter in PARAMETERS[role]
        if parameter.name in held and (problem := parameter.problem(held[parameter.name]))
    ]
    if problems:
        raise ParameterError('; '.join(dict.fromkeys(problems)))
    if given['out']:
        check_folder(Path(given['out']), force=values.get('force', False))
    return nodes


def state_folder(given: Mapping[str, Any]) -> str:
    """Return the folder of the states: that given, or by default one for the scene.

    A dial may only continue the same clock, so each scene has its own folder.
    """
    from tauto_nodes.live.parameters import FOLDER_VARIABLE

    if (folder := given['state_folder']) != 'default':
        return '' if folder in ('', 'none') else str(Path(folder).absolute())
    home = os.environ.get('ROS_HOME') or Path.home() / '.ros'
    scene = Path(given['scene'])
    text = hashlib.sha256(scene_yaml(load_scene(given['scene'])).encode()).hexdigest()
    place = Path(os.environ.get(FOLDER_VARIABLE) or home, 'tauto_states')
    return str(place.absolute() / f'{scene.stem}_{text[:8]}')


def strangers_of(typed: Iterable[str], known: Iterable[str]) -> list[str]:
    """Return a text for each typed argument that resembles a known one. Launch would ignore it.

    Other unknown ones may belong to a launch file that includes ours.
    """
    names = [argument.partition(':=')[0] for argument in typed]
    near = {
        name: match[0]
        for name in names
        if name not in known and (match := difflib.get_close_matches(name, known, 1, 0.75))
    }
    return [f'{name}: no such argument. The nearest is {match}' for name, match in near.items()]


# The parameters of the nodes of each kind of launch, by executable.


def voyage_nodes(given: Mapping[str, Any]) -> dict[str, dict[str, object]]:
    """Return the nodes of voyage.launch.py."""
    common = {key: given[key] for key in ('scene', 'duration', 'executor')} | {'packed': True}
    bag = given['out'] and str(Path(given['out']).absolute())
    pace = {key: given[key] for key in ('speed', 'publish_clock')}
    nodes: dict[str, dict[str, object]] = {
        'recorder': {**common, 'output': bag, 'force': given['force']},
        'longitude': {**common},
        'drift_estimator': {**common},
        'trochlea': {**common},
        'ship_motion': {**common, **pace},
    }
    if given['markers']:
        nodes['markers'] = {'scene': given['scene'], 'executor': given['executor']}
    return nodes


def live_nodes(given: Mapping[str, Any]) -> dict[str, dict[str, object]]:
    """Return the nodes of live.launch.py."""
    sensor = {'imu_reliability': given['imu_reliability']}
    mounted = {**sensor, 'imu_rotation': given['imu_rotation']}
    own = {'scene': given['scene'], 'executor': given['executor']}
    stage = {**own, 'state_folder': state_folder(given)}
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
    if given['markers']:
        nodes['markers'] = {**own, **sensor}
    if given['use_sim_time']:
        nodes = {name: {**held, 'use_sim_time': True} for name, held in nodes.items()}
    return nodes


def launch_plan() -> None:
    """Answer the question on standard input, in JSON. Exit code 2 refuses the launch.

    The question has the `kind` of launch, the arguments `given`, the words `typed`, the `folder`
    for the parameters, and the process of the launch, the `supervisor`. The answer has the names
    of the `nodes`, their `environment` and the `remappings`.
    """
    from tauto_nodes.live import SUPERVISOR, check_discovery, local_discovery
    from tauto_nodes.live.parameters import write_parameters

    asked = json.load(sys.stdin)
    given, folder = asked['given'], Path(asked['folder'])
    try:
        if strangers := strangers_of(asked['typed'], given):
            raise ParameterError('; '.join(strangers))
        check_discovery()
        nodes = nodes_of(asked['kind'], given)
        environment = {SUPERVISOR: str(asked['supervisor'])}
        if asked['kind'] == 'live':
            environment |= local_discovery()
        else:
            from tauto_nodes.simulation import graph_middleware
            from tauto_nodes.simulation.credits import RUN

            environment |= graph_middleware() | {RUN: secrets.token_hex()}
    except TautoError as error:
        sys.stderr.write(spelled(error.message, as_parameter) + '\n')
        sys.exit(ParameterError.exit_code)
    write_parameters(folder, given['namespace'], nodes)
    named = {SHIP_IMU: 'imu', OBSERVATION: 'observation', SHIP_FIX: 'fix'}
    remappings = {
        topic: given[name] for topic, name in named.items() if given.get(name, topic) != topic
    }
    answer = {'nodes': list(nodes), 'environment': environment, 'remappings': remappings}
    sys.stdout.write(json.dumps(answer) + '\n')
