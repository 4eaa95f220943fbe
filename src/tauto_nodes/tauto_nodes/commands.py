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
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from tauto_core import api
from tauto_core.bags import check_folder
from tauto_core.checks.readiness import check_known, check_scene
from tauto_core.cli.calls import option_of
from tauto_core.cli.terminal import AsJson, SceneName, Settings, given_values, print_rich
from tauto_core.samples import OBSERVATION, SHIP_FIX, SHIP_IMU
from tauto_core.scene import load_scene, scene_yaml
from tauto_core.scene.errors import TautoError, UsageError, spelled
from tauto_nodes import ParameterError, as_parameter

if TYPE_CHECKING:
    from tauto_core.bags import Bag

# -----------------------------------------------------------------------------
# `tauto graph` and `tauto play`. The command line loads them from the group `tauto.commands`.

MAX_SPEED = 1e6
MOST_COMPLAINTS = 20


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
    from rich.table import Table

    from tauto_core.cli.tables import voyage_table
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
    counts = Table('topic', 'received', 'written', 'lost')
    for topic, numbers in outcome.counts.items():
        counts.add_row(topic, *(str(numbers[key]) for key in ('received', 'written', 'lost')))
    print_rich(counts, err=True)
    for line in outcome.node_warnings[:MOST_COMPLAINTS]:
        typer.echo(f'tauto: the graph said: {line}', err=True)
    if (more := len(outcome.node_warnings) - MOST_COMPLAINTS) > 0:
        typer.echo(f'tauto: the graph said {more} things more', err=True)
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
        print_rich(voyage_table(result))
    if outcome.lost:
        typer.echo(f'tauto: {outcome.lost} messages were lost on the way', err=True)
        raise typer.Exit(1)


def _playable(path: Path, rate: float, topics: list[str]) -> Bag:
    """Return the bag. Refuse a rate or topics that cannot be played, by the command's options."""
    from tauto_core.bags import read_bag
    from tauto_nodes.live.parameters import PARAMETERS
    from tauto_nodes.live.player import ports_of

    known = {parameter.name: parameter for parameter in PARAMETERS['player']}
    low, high = known['rate'].low, known['rate'].high
    if not low <= rate <= high:  # also true for NaN
        raise UsageError(f'--rate {rate:g}: must lie between {low:g} and {high:g}. Use 1 or 10')
    bag = read_bag(path)
    has = ', '.join(bag.topics)
    each: list[tuple[str, ...]] = [(topic,) for topic in topics]
    for asked in each or [cast(tuple[str, ...], known['topics'].default)]:
        try:
            ports_of(bag, asked)
        except ParameterError:
            said = (
                f'--topic {asked[0]}: is not in {path}. Name one of'
                if topics
                else (f'{path}: has no topic that drives the graph. Name topics with --topic')
            )
            raise UsageError(f'{said} {has}') from None
    return bag


def play(
    bag: Annotated[Path, typer.Argument(metavar='BAG', help='A rosbag2 folder or an .mcap file.')],
    *,
    rate: Annotated[
        float, typer.Option(metavar='X', help='Seconds of the bag in a second.')
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
    from tauto_core.cli.terminal import say
    from tauto_nodes.live import run_nodes
    from tauto_nodes.live.player import PlayerNode

    opened = _playable(bag, rate, topic or [])
    arguments = ['--ros-args', '-r', f'__ns:=/{_namespace(namespace)}']
    values: dict[str, Any] = {'bag': str(bag), 'rate': float(rate), 'publish_clock': publish_clock}
    if topic:
        values['topics'] = list(topic)
    for name, value in values.items():
        arguments += ['-p', f'{name}:={json.dumps(value)}']
    say(f'{bag}: plays when each topic has a subscriber, after two seconds anyway')
    if code := run_nodes((partial(PlayerNode, bag=opened),), arguments):
        raise typer.Exit(code)


# -----------------------------------------------------------------------------
# The program `launch_plan`: it checks the arguments of a launch file and plans its nodes.
#
# `ros2 launch` runs in the system's Python, which may lack the nodes' packages, so the launch
# files ask this program, which runs in the Python of the nodes.

# arguments that are parameters of the same name, with a node that has them
_ROLES = {
    'speed': 'ship_motion',
    'duration': 'ship_motion',
    'imu_reliability': 'trochlea',
    'executor': 'trochlea',
}


def problems_of(given: Mapping[str, str]) -> list[str]:
    """Return the problems of the arguments of a launch, in words."""
    from tauto_nodes.live.parameters import PARAMETERS

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
    names = ('force', 'anyway', 'publish_clock', 'use_sim_time', 'markers')
    flags = {name: given.get(name, 'false').lower() for name in names}
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
    return ['out :=: must name the folder of the bag'] if nowhere else []


def state_folder(given: Mapping[str, str]) -> str:
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
    """Answer the question on standard input, in JSON. Exit code 2 refuses the launch.

    The question has the `kind` of launch, the arguments `given`, the words `typed`, the `folder`
    for the parameters, and the process of the launch, the `supervisor`. The answer has the names
    of the `nodes`, their `environment` and the `remappings`.
    """
    from tauto_nodes.live import SUPERVISOR, check_discovery, local_discovery, remove_left
    from tauto_nodes.live.parameters import check_executor, write_parameters

    asked = json.load(sys.stdin)
    given, folder = asked['given'], Path(asked['folder'])
    remove_left(folder.parent)
    live = asked['kind'] == 'live'
    try:
        if problems := [*strangers_of(asked['typed'], given), *problems_of(given)]:
            raise ParameterError('; '.join(problems))
        check_executor(given['executor'])
        check_discovery()
        environment = {SUPERVISOR: str(asked['supervisor'])}
        if live:
            environment |= local_discovery()
            nodes = live_nodes(given)
        else:
            from tauto_nodes.simulation import graph_middleware
            from tauto_nodes.simulation.credits import RUN

            environment |= graph_middleware() | {RUN: secrets.token_hex()}
            nodes = voyage_nodes(given)
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
    answer = {'nodes': list(nodes), 'environment': environment, 'remappings': remappings}
    sys.stdout.write(json.dumps(answer) + '\n')
