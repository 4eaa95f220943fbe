"""`tauto graph` and `tauto play`; the command line loads them from the group `tauto.commands`."""

from __future__ import annotations

import json
import math
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from tauto_core.cli.calls import option_of
from tauto_core.cli.terminal import AsJson, SceneName, Settings, given_values, print_rich
from tauto_core.scene.errors import UsageError

if TYPE_CHECKING:
    from tauto_core.bags import Bag

MAX_SPEED = 1e6
MOST_COMPLAINTS = 20
EXECUTORS = ('events', 'single')


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
        typer.Option(metavar='DIR', help='Folder of the bag; default: bags/out/SCENE.'),
    ] = None,
    force: Annotated[bool, option_of('sail', 'force')] = False,
    anyway: Annotated[bool, option_of('sail', 'anyway')] = False,
    duration: Annotated[float | None, option_of('sail', 'duration')] = None,
    accuracy: Annotated[float | None, option_of('sail', 'accuracy')] = None,
    settings: Settings = None,
    compose: Annotated[
        bool, typer.Option('--compose', help='All nodes in one process instead of one each.')
    ] = False,
    namespace: Annotated[str, typer.Option(metavar='NAME', help='Namespace of the graph.')] = '',
    executor: Annotated[
        str,
        typer.Option(metavar='events|single', help='Executor of the nodes; single is slower.'),
    ] = 'events',
    as_json: AsJson = False,
) -> None:
    """Sail a scene as real ROS 2 nodes, recorded to MCAP."""
    from rich.table import Table

    from tauto_core.bags import check_folder
    from tauto_core.checks.readiness import check_scene
    from tauto_core.cli.tables import voyage_table
    from tauto_core.cli.terminal import progress_bar, say_oddities
    from tauto_core.scene import load_scene
    from tauto_core.scene.errors import naming
    from tauto_core.voyage import compile_kernels, summarise_bag
    from tauto_nodes.graph import GraphPlan, run_graph

    try:
        pace = 0.0 if speed == 'max' else float(speed)
    except ValueError:
        pace = math.nan
    if speed != 'max' and not 0.0 < pace <= MAX_SPEED:  # also false for NaN
        raise UsageError(
            f'--speed {speed}: must be a number in (0, {MAX_SPEED:g}], sea seconds a second, or '
            'max'
        )
    place = _namespace(namespace)
    if executor not in EXECUTORS:
        raise UsageError(f'--executor {executor}: must be {" or ".join(EXECUTORS)}')
    loaded = load_scene(scene, **given_values(settings, duration, accuracy))
    say_oddities(loaded, scene, anyway=anyway)
    with naming(scene, loaded.name):
        check_scene(loaded)
    folder = out or Path('bags/out') / Path(scene).stem
    check_folder(folder, force=force)
    plan = GraphPlan(
        scene,
        folder,
        duration or 0.0,
        pace,
        force,
        compose,
        place,
        executor,
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
    for line in outcome.complaints[:MOST_COMPLAINTS]:
        typer.echo(f'tauto: the graph said: {line}', err=True)
    if (more := len(outcome.complaints) - MOST_COMPLAINTS) > 0:
        typer.echo(f'tauto: the graph said {more} things more', err=True)
    if outcome.signal:
        sailed = any(numbers['written'] for numbers in outcome.counts.values())
        kept = f'{folder} holds what was sailed until then' if sailed else 'nothing was sailed yet'
        typer.echo(f'tauto: stopped early; {kept}', err=True)
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
    """Return the bag; refuse a rate or topics that cannot be played, in the command's words."""
    from tauto_core.bags import read_bag
    from tauto_nodes import ParameterError
    from tauto_nodes.parameters import PARAMETERS
    from tauto_nodes.sources import ports_of

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
                f'--topic {asked[0]}: is not in {path}; name one of'
                if topics
                else (f'{path}: has nothing that drives the graph; name with --topic')
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
            metavar='TOPIC', help='A topic to play, or all; default: what drives the graph.'
        ),
    ] = None,
    namespace: Annotated[str, typer.Option(metavar='NAME', help='Namespace to play into.')] = '',
    publish_clock: Annotated[
        bool, typer.Option('--publish-clock', help='Publish /clock as well.')
    ] = False,
) -> None:
    """Play a bag into a ROS 2 graph, in the domain that the environment names."""
    from tauto_core.cli.terminal import progress_bar, say
    from tauto_nodes.running import run_nodes
    from tauto_nodes.sources import PlayerNode

    opened = _playable(bag, rate, topic or [])
    arguments = ['--ros-args', '-r', f'__ns:=/{_namespace(namespace)}']
    values: dict[str, Any] = {'bag': str(bag), 'rate': float(rate), 'publish_clock': publish_clock}
    if topic:
        values['topics'] = list(topic)
    for name, value in values.items():
        arguments += ['-p', f'{name}:={json.dumps(value)}']
    say(f'{bag}: plays when each topic has a subscriber, after two seconds anyway')
    made: list[PlayerNode] = []

    def player() -> PlayerNode:
        made.append(PlayerNode(bag=opened, progress=progress))
        return made[0]

    with progress_bar(str(bag)) as progress:
        code = run_nodes((player,), arguments)
    if any(each.over for each in made):
        say(f'{bag}: played to its end')
    if code:
        raise typer.Exit(code)
