"""A voyage as a ROS 2 graph: all nodes on one scene, their processes, from start to end."""

from __future__ import annotations

import os
import re
import secrets
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from tauto_core import samples as s
from tauto_core.bags import TOPICS
from tauto_core.scene import Scene, scene_yaml
from tauto_nodes import GraphError
from tauto_nodes.live import DOMAIN, SUPERVISOR, Signals
from tauto_nodes.live.parameters import FOLDER_VARIABLE, write_parameters
from tauto_nodes.live.recorder import RecorderReport
from tauto_nodes.simulation import graph_environment, work_folder
from tauto_nodes.simulation.credits import RUN

# -----------------------------------------------------------------------------
# The processes of a graph: started together, watched, stopped together.

TERM_S = 600.0
"""Time that a node has to end [s]: on a busy machine a bag can take minutes to close."""

POLL_S = 0.02

# Marks of warnings and errors in the logs of rclpy and Fast DDS.
_COMPLAINT = re.compile(r'\[(WARN|ERROR|FATAL)\]|\w (Error|Warning)\]')

_COLOUR = re.compile(r'\x1b\[[\d;]*m')
_TIME = re.compile(r'^[-\d]+ [.:\d]+ |\[\d+\.\d+\] ')


@dataclass
class Child:
    """One node's process, with the file that takes its output."""

    name: str
    process: subprocess.Popen[bytes]
    log: Path

    def said(self) -> str:
        """Return the last lines that it wrote."""
        return '\n'.join(self.lines()[-25:])

    def lines(self) -> list[str]:
        """Return all lines that it wrote, without colours."""
        words = self.log.read_text('utf-8', 'replace')
        return _COLOUR.sub('', words).strip().splitlines()


@dataclass
class Supervisor:
    """Starts nodes as processes of one group and ends them, as a context manager.

    The logs go to `folder`. The children get the `environment`.
    """

    folder: Path
    environment: Mapping[str, str]
    children: list[Child] = field(default_factory=list)
    key: str = field(default_factory=secrets.token_hex, repr=False)

    def start(self, name: str, arguments: Sequence[str]) -> None:
        """Start `python -m tauto_nodes NAME` with these arguments."""
        log = self.folder / f'{name}.log'
        with log.open('wb') as words:
            process = subprocess.Popen(
                [sys.executable, '-P', '-m', 'tauto_nodes', name, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=words,
                stderr=subprocess.STDOUT,
                env={**self.environment, SUPERVISOR: str(os.getpid()), RUN: self.key},
                start_new_session=True,
            )
        self.children.append(Child(name, process, log))

    def check(self, ended: Sequence[str] = ()) -> None:
        """Raise GraphError if a node has ended that is not among those which may have `ended`.

        The error names the node, how it ended, and its last output.
        """
        for child in self.children:
            if child.process.poll() is not None and child.name not in ended:
                raise self.died(child.name)

    def died(self, name: str) -> GraphError:
        """Return the error that says how a node ended, with its last output."""
        child = next(child for child in self.children if child.name == name)
        code = child.process.wait()
        how = f'by {signal.Signals(-code).name}' if code < 0 else f'with exit code {code}'
        return GraphError(
            f'node {name} ended {how} before the voyage did. It said:\n'
            + (child.said() or 'nothing')
        )

    def exit_code(self, name: str) -> int | None:
        """Return a node's exit code, or `None` while it runs."""
        return next(c.process.poll() for c in self.children if c.name == name)

    def node_warnings(self) -> tuple[str, ...]:
        """Return the warnings and errors that the nodes and the middleware wrote, each once."""
        lines = (line for child in self.children for line in child.lines())
        said = (_TIME.sub('', line) for line in lines if _COMPLAINT.search(line))
        return tuple(dict.fromkeys(said))

    def stop(self) -> list[Child]:
        """End all nodes by SIGTERM. Return those that took more than TERM_S and were killed.

        They get SIGABRT first, and write the stack of each thread (`run`).
        """
        late = self._signal(signal.SIGTERM, TERM_S)
        for number in (signal.SIGABRT, signal.SIGKILL):
            self._signal(number, 5.0)
        return late

    def _signal(self, number: signal.Signals, patience_s: float) -> list[Child]:
        """Send the running nodes a signal. Return those that run after a while."""
        deadline_s = time.monotonic() + patience_s
        for child in (running := self._running()):
            os.killpg(child.process.pid, number)
        while running and time.monotonic() < deadline_s:
            time.sleep(POLL_S)
            running = self._running()
        return running

    def _running(self) -> list[Child]:
        return [child for child in self.children if child.process.poll() is None]

    def __enter__(self) -> Supervisor:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


NODE_NAMES = ('recorder', 'longitude', 'drift_estimator', 'trochlea', 'ship_motion')
SILENT_S = 120.0
"""Time after which a silent node counts as frozen [s]. Each node reports once a second."""

STALL_S = 600.0
"""Time without progress after which a graph counts as stalled [s]: on a machine under heavy load
the first compilation of kernels can take minutes."""


@dataclass(frozen=True)
class GraphPlan:
    """The voyage to run.

    Args:
        scene: name or file for the nodes.
        duration_s: replaces the scene's, unless 0.
        speed: sea time by wall time, or 0: as fast as possible.
        out: folder of the bag.
        force: replace a bag that is there.
        namespace: namespace of the graph. Empty: the root.
        packed: whether the nodes send each other many messages in one, and so know their own.
        changed: whether keys of the scene were changed. The nodes then load the checked scene, not
            the file `scene`.
    """

    scene: str
    out: Path
    duration_s: float = 0.0
    speed: float = 60.0
    force: bool = False
    namespace: str = ''
    packed: bool = True
    changed: bool = False


@dataclass(frozen=True)
class Outcome:
    """The result of a run of the graph.

    Args:
        counts: received, written and lost, by topic.
        signal: number of the signal that ended the voyage early, or 0.
        start_s: wall time until the recorder got its first message [s].
        voyage_s: wall time from then to the closed bag [s].
        complaints: warnings and errors of the nodes and the middleware.
    """

    counts: dict[str, dict[str, int]] = field(default_factory=dict)
    signal: int = 0
    start_s: float = 0.0
    voyage_s: float = 0.0
    node_warnings: tuple[str, ...] = ()

    @property
    def lost(self) -> int:
        """Messages lost, of all topics."""
        return sum(numbers['lost'] for numbers in self.counts.values())


def parameters_of(plan: GraphPlan, scene: Scene, report: Path) -> dict[str, dict[str, Any]]:
    """Return the parameters of all nodes, by name."""
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
    return {
        node: {
            **own[node],
            'flow_control': 'credits',
            'packed': plan.packed,
            'graph': list(NODE_NAMES),
        }
        for node in NODE_NAMES
    }


@dataclass
class Watchdog:
    """Reads the recorder's report, for progress and for a standstill.

    The supervisor is not a node, and cannot hang as a node can.
    """

    report: Path
    said: RecorderReport | None = None
    blind_s: float = field(default_factory=time.monotonic)
    """Time of the last failed reading [s]: no node is judged by earlier reports."""

    def look(self) -> None:
        """Wait a moment and read the report."""
        time.sleep(0.05)
        try:
            self.said = RecorderReport.read(self.report) or self.said
        except ValueError:  # half written, or there is no room for it
            self.blind_s = time.monotonic()

    def recorded(self, topic: str) -> int:
        """Return the number of messages of a topic that the recorder has."""
        return int(self.said.topics[topic]['received']) if self.said else 0

    def check(self) -> None:
        """Raise GraphError if the graph stands still, with the names of the silent nodes."""
        now_s = time.monotonic()
        heard_s = self.said.heard_s if self.said else {}
        silent = [n for n, at_s in heard_s.items() if now_s - max(at_s, self.blind_s) > SILENT_S]
        if silent:  # the recorder hears all nodes
            frozen = 'recorder' if 'recorder' in silent else ', '.join(sorted(silent))
            raise GraphError(
                f'node {frozen} has not been heard for {SILENT_S:g} s: it hangs or was stopped. '
                'The bag holds the voyage until then. Start it again'
            )
        moved_s = self.said.moved_s if self.said else self.blind_s
        if now_s - max(moved_s, self.blind_s) > STALL_S:
            unheard = sorted(set(NODE_NAMES) - set(heard_s)) or ['none']
            raise GraphError(
                f'the graph has stood still for {STALL_S:g} s (nodes never heard: '
                f'{", ".join(unheard)}). A network filter on the loopback interface, another '
                f'{DOMAIN} in the environment or a machine under heavy load can do this'
            )


def run_graph(plan: GraphPlan, scene: Scene, progress: Callable[[float], None]) -> Outcome:
    """Run a graph to the scene's end or the first signal, and close the bag.

    The scene and the folder of the plan must have been checked. `scene` is the loaded scene of the
    plan. `progress` is called with the recorded fraction of the readings. GraphError: a node died
    or would not end, the graph stood still for STALL_S, or readings are missing from the bag.
    """
    born_s = time.monotonic()
    with (
        Signals() as signals,
        graph_environment(plan.namespace) as environment,
        work_folder(os.environ.get(FOLDER_VARIABLE)) as place,
    ):
        folder = Path(place)
        report = folder / 'report.json'
        if plan.changed:
            file = folder / 'scene.yaml'
            file.write_text(scene_yaml(scene), 'utf-8')
            plan = replace(plan, scene=str(file), duration_s=scene.duration)
        parameters = write_parameters(folder, plan.namespace, parameters_of(plan, scene, report))
        arguments = ['--ros-args', '--params-file', str(parameters)]
        if plan.namespace:
            arguments += ['-r', f'__ns:=/{plan.namespace.strip("/")}']
        with Supervisor(folder, environment) as supervisor:
            for name in NODE_NAMES:
                # only a name, without ROS_SECURITY_ENABLE (config/sros2_policy.xml)
                supervisor.start(name, [*arguments, '--enclave', f'/tauto/{name}'])
            watch = Watchdog(report)
            while not signals.came and supervisor.exit_code(NODE_NAMES[0]) is None:
                watch.look()
                supervisor.check(ended=NODE_NAMES[:1])
                watch.check()
                progress(min(watch.recorded(s.READING) / scene.log_count, 1.0))
            killed = supervisor.stop()
        if killed:
            raise GraphError(
                f'{", ".join(child.name for child in killed)} did not end on SIGTERM and had to '
                f'be killed. `tauto replay {plan.out}` shows its bag. This is a fault '
                'of Tauto or its middleware: please report it with these words:\n'
                + '\n'.join(child.said() for child in killed)
            )
        recorded = _recorded(report, supervisor, NODE_NAMES[0], interrupted=signals.came > 0)
        if recorded is None or recorded.began_s is None or recorded.closed_s is None:
            return Outcome(signal=signals.came)
        return Outcome(
            recorded.topics,
            0 if recorded.complete else signals.came,
            start_s=recorded.began_s - born_s,
            voyage_s=recorded.closed_s - recorded.began_s,
            node_warnings=supervisor.node_warnings() if recorded.complete else (),
        )


def _recorded(
    report: Path, supervisor: Supervisor, name: str, *, interrupted: bool
) -> RecorderReport | None:
    """Return the recorder's report. Raise if the bag was not closed, or too early."""
    try:
        said = RecorderReport.read(report)
    except ValueError as error:
        raise GraphError(
            f'{report}: the recorder could not write its report, but closed the bag. Make room '
            'there, or set TMPDIR to another place'
        ) from error
    if interrupted:
        return said
    if said is None or not said.complete:
        raise supervisor.died(name)
    return said
