"""A voyage as a ROS 2 graph: all nodes on one scene, recorded, from start to end."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import rclpy
import yaml
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import try_shutdown
from std_msgs.msg import String

from tauto_core import samples as s
from tauto_core.bags import TOPICS
from tauto_core.scene import Scene, scene_yaml
from tauto_nodes.domains import DOMAIN, check_discovery, claim_domain, enclave_of
from tauto_nodes.errors import GraphError
from tauto_nodes.flow import CREDIT_TOPIC, Report
from tauto_nodes.launching import graph_middleware
from tauto_nodes.parameter import FOLDER
from tauto_nodes.qos import CREDIT_QOS
from tauto_nodes.rclpy_private import RCLError
from tauto_nodes.recorder import Recorded
from tauto_nodes.running import executor_named
from tauto_nodes.supervisor import Child, Supervisor, noted_signals
from tauto_nodes.work_folder import work_folder

NODES = ('recorder', 'longitude', 'drift_estimator', 'trochlea', 'ship_motion')
SILENT_S = 120.0
"""Time after which a silent node counts as frozen [s]; each node reports once a second."""

OWN_PAUSE_S = 1.0
STALL_S = 600.0
"""Kernels that a machine under heavy load compiles for the first time can take minutes."""

SPIN_S = 0.05
STDOUT, STDERR = 1, 2


@dataclass(frozen=True)
class Plan:
    """What to run.

    Args:
        scene: name or file, as the nodes are to load it.
        duration_s: replaces the scene's; 0: its own.
        speed: sea time by wall time; 0: as fast as possible.
        out: folder of the bag.
        force: replace a bag that is there.
        compose: all nodes in one process.
        namespace: namespace of the graph; empty: the root.
        executor: executor of all nodes, `events` or `single`.
        packed: whether at full speed the nodes send each other many messages in one.
        changed: whether keys of the scene were given other values, so that the nodes load the
            scene as it was checked and not what `scene` names.
    """

    scene: str
    out: Path
    duration_s: float = 0.0
    speed: float = 60.0
    force: bool = False
    compose: bool = False
    namespace: str = ''
    executor: str = 'events'
    packed: bool = True
    changed: bool = False


@dataclass(frozen=True)
class Outcome:
    """The result of a run of the graph.

    Args:
        counts: received, written and lost, by topic.
        signal: number of the signal that ended the voyage early; 0: it went to its end.
        start_s: wall time until the recorder got its first message [s].
        voyage_s: wall time from then to the closed bag [s].
    """

    counts: dict[str, dict[str, int]] = field(default_factory=dict)
    signal: int = 0
    start_s: float = 0.0
    voyage_s: float = 0.0

    @property
    def lost(self) -> int:
        """Messages lost, of all topics."""
        return sum(numbers['lost'] for numbers in self.counts.values())


def parameters_of(plan: Plan, scene: Scene, report: Path) -> dict[str, Any]:
    """Return the content of the parameter file for all nodes."""
    file = Path(plan.scene)
    voyage = {
        'scene': str(file.resolve()) if file.is_file() else plan.scene,
        'duration': float(plan.duration_s),
    }
    topics = ['all'] if scene.keeps_motion else [t for t in TOPICS if t != s.SHIP_IMU]
    own: dict[str, dict[str, Any]] = {
        'ship_motion': {**voyage, 'speed': float(plan.speed)},
        'trochlea': voyage,
        'drift_estimator': voyage,
        'longitude': voyage,
        'recorder': {
            'output': str(plan.out.resolve()),
            'force': plan.force,
            'topics': topics,
            'report': str(report),
        },
    }
    prefix = f'/{plan.namespace.strip("/")}'.rstrip('/')
    # No object comes twice: the parser of ROS takes no YAML aliases.
    return {
        f'{prefix}/{node}': {
            'ros__parameters': {
                **own[node],
                'executor': plan.executor,
                'flow_control': 'credits',
                'packed': plan.packed and plan.speed == 0.0,
                'graph': list(NODES),
            }
        }
        for node in NODES
    }


@contextmanager
def graph_environment() -> Iterator[dict[str, str]]:
    """Set this process' ROS environment and yield it for the children.

    Discovery stays on this machine, the domain is a free one, and Fast DDS gets our profile
    (`fastdds_loopback.xml`), unless the environment says otherwise.
    """
    check_discovery()
    given = graph_middleware()
    domain = None if os.environ.get(DOMAIN) else claim_domain()
    if domain is not None:
        given[DOMAIN] = str(domain.number)
    before = {name: os.environ.get(name) for name in given}
    os.environ.update(given)
    try:
        yield dict(os.environ)
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        if domain is not None:
            domain.release()


@contextmanager
def stdout_left_alone() -> Iterator[None]:
    """Let what C libraries write to stdout go to stderr: Fast DDS logs its troubles there.

    `tauto graph --json` prints one object on stdout, and nothing else.
    """
    sys.stdout.flush()
    kept = os.dup(STDOUT)
    os.dup2(STDERR, STDOUT)
    try:
        yield
    finally:
        os.dup2(kept, STDOUT)
        os.close(kept)


class _Watch:
    """Listens to the credits of the graph, for progress and for a standstill."""

    def __init__(self, namespace: str, executor: str) -> None:
        args = ['--ros-args', *enclave_of('supervisor')]
        try:
            rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
            self._node = Node('supervisor', namespace=namespace, start_parameter_services=False)
        except RCLError as error:
            try_shutdown()
            raise GraphError(f'ROS does not start in this environment: {error}') from error
        self._node.create_subscription(String, CREDIT_TOPIC, self._hear, CREDIT_QOS, raw=True)
        self._executor = executor_named(executor)
        self._executor.add_node(self._node)
        self.reports: dict[str, Report] = {}
        self.heard_s: dict[str, float] = {}
        self._spun_s = time.monotonic()
        self.moved_s = time.monotonic()

    def _hear(self, octets: bytes) -> None:
        report = Report.from_octets(octets)
        self.heard_s[report.node] = time.monotonic()
        if self.reports.get(report.node) != report:
            self.moved_s = time.monotonic()
        self.reports[report.node] = report

    def spin(self) -> None:
        """Listen for a moment, to all reports that come."""
        stood_s = time.monotonic() - self._spun_s
        if stood_s > OWN_PAUSE_S:  # this process stood still, and heard nobody meanwhile
            self.heard_s = {node: at_s + stood_s for node, at_s in self.heard_s.items()}
        self._executor.spin_until_future_complete(Future(), SPIN_S)
        self._spun_s = time.monotonic()

    def recorded(self, topic: str) -> int:
        """Return how many messages of a topic the recorder has taken."""
        report = self.reports.get('recorder')
        return report.taken.get(topic, 0) if report else 0

    def close(self) -> None:
        """End the context; nothing of the node stays in the domain."""
        self._executor.remove_node(self._node)
        self._executor.shutdown()
        self._node.destroy_node()
        try_shutdown()


def run_graph(plan: Plan, scene: Scene, progress: Callable[[float], None]) -> Outcome:
    """Run a graph to the scene's end or the first signal; the bag is closed in both cases.

    Args:
        plan: what to run; its scene and folder have been checked.
        scene: the same scene, loaded.
        progress: called with the fraction that is recorded, from 0 to 1.

    Raises:
        GraphError: a node died or would not end, the graph stood still for STALL_S, or readings
            are missing from the bag.
    """
    born_s = time.monotonic()
    with (
        noted_signals() as signals,
        stdout_left_alone(),
        graph_environment() as environment,
        work_folder(os.environ.get(FOLDER)) as folder,
    ):
        report = folder / 'report.json'
        arguments = _arguments(plan, scene, folder, report)
        names = ('compose',) if plan.compose else NODES
        with Supervisor(folder, environment) as supervisor:
            for name in names:
                supervisor.start(name, [*arguments, *enclave_of(name)])
            watch = _Watch(plan.namespace, plan.executor)
            try:
                while not signals.came and supervisor.exit_code(names[0]) is None:
                    watch.spin()
                    progress(min(watch.recorded(s.READING) / scene.log_count, 1.0))
                    supervisor.check(ended=names[:1])
                    _check_stall(watch)
            finally:
                watch.close()
            killed = supervisor.stop()
        if killed:
            raise _hung(killed, plan.out)
        recorded = _recorded(report, supervisor, names[0], interrupted=signals.came > 0)
        if recorded is None or recorded.began_s is None:
            return Outcome(signal=signals.came)
        if not signals.came:
            _check_whole(recorded, scene)
        return Outcome(
            recorded.topics,
            0 if recorded.complete else signals.came,
            start_s=recorded.began_s - born_s,
            voyage_s=recorded.closed_s - recorded.began_s,
        )


def _arguments(plan: Plan, scene: Scene, folder: Path, report: Path) -> list[str]:
    """Write the parameters, and the scene where it was changed; return the nodes' arguments."""
    if plan.changed:
        file = folder / 'scene.yaml'
        file.write_text(scene_yaml(scene), 'utf-8')
        plan = replace(plan, scene=str(file), duration_s=scene.duration)
    parameters = folder / 'parameters.yaml'
    parameters.write_text(yaml.safe_dump(parameters_of(plan, scene, report)), 'utf-8')
    arguments = ['--ros-args', '--params-file', str(parameters)]
    if plan.namespace:
        arguments += ['-r', f'__ns:=/{plan.namespace.strip("/")}']
    return arguments


def _hung(killed: Sequence[Child], bag: Path) -> GraphError:
    """Return the error that names the nodes that did not end, with where they were."""
    return GraphError(
        f'{", ".join(child.name for child in killed)} did not end on SIGTERM and had to be '
        f'killed; `tauto replay {bag}` tells what the bag holds. This is a fault of Tauto or its '
        'middleware: please report it with these words:\n'
        + '\n'.join(child.said() for child in killed)
    )


def _check_stall(watch: _Watch) -> None:
    now_s = time.monotonic()
    if frozen := [node for node, at_s in watch.heard_s.items() if now_s - at_s > SILENT_S]:
        raise GraphError(
            f'node {", ".join(sorted(frozen))} has not been heard for {SILENT_S:g} s: it hangs or '
            'was stopped. What was recorded until then is in the bag; start the voyage again'
        )
    if now_s - watch.moved_s > STALL_S:
        silent = sorted(set(NODES) - set(watch.reports)) or ['none; all have been heard']
        raise GraphError(
            f'the graph has stood still for {STALL_S:g} s (nodes never heard: '
            f'{", ".join(silent)}). A network filter on the loopback interface, another '
            f'{DOMAIN} in the environment or a machine under heavy load can do this'
        )


def _check_whole(recorded: Recorded, scene: Scene) -> None:
    """Refuse to call a bag whole that lacks readings which were neither sent nor lost."""
    reading = recorded.topics[s.READING]
    if (had := reading['received'] + reading['lost']) != scene.log_count:
        raise GraphError(
            f'the clock has published {had} readings where the scene has {scene.log_count}; the '
            'bag holds those. This is a fault of Tauto: please report it with the scene'
        )


def _recorded(
    report: Path, supervisor: Supervisor, name: str, *, interrupted: bool
) -> Recorded | None:
    """Return the recorder's report; raise if its process ended in any other way than a loss."""
    try:
        said = Recorded(**json.loads(report.read_text('utf-8'))) if report.is_file() else None
    except ValueError as error:
        raise GraphError(
            f'{report}: the recorder could not write its report; the bag is closed. Make room '
            'there, or set TMPDIR to another place'
        ) from error
    if interrupted:
        return said
    lost = said is not None and any(numbers['lost'] for numbers in said.topics.values())
    if supervisor.exit_code(name) != (1 if lost else 0):
        raise supervisor.died(name)
    if said is not None and not said.complete:
        raise GraphError(
            f'node {name} was stopped before the voyage was over; the bag holds what was '
            'sailed until then, and says so (cut_short). Start the voyage again'
        )
    return said
