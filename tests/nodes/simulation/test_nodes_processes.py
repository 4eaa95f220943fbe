"""Nodes and graphs as processes: signals, exit codes, last words, no orphans."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from itertools import cycle
from pathlib import Path

import pytest
from builtin_interfaces.msg import Time
from conftest import PATIENCE_S, start, until
from diagnostic_msgs.msg import DiagnosticArray
from modules import run_program
from rcl_interfaces.msg import Log
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from typer.testing import CliRunner

from tauto_core.bags import check_bag, read_bag
from tauto_core.cli.app import app
from tauto_nodes.live import executor_named
from tauto_nodes.simulation import supervisor as graph
from tauto_nodes.simulation.supervisor import Child

BAG = Path(__file__).parents[3] / 'bags' / 'cheek_1min'
NODES = ('ship_motion', 'trochlea', 'drift_estimator', 'longitude', 'recorder')


def tauto(*arguments: str) -> list[str]:
    code = 'from tauto_core.cli import main; main()'
    return [sys.executable, '-c', code, *arguments]


def graph_into(
    out: Path, *options: str, env: dict[str, str] | None = None
) -> subprocess.Popen[str]:
    """Start a graph that sails `measured` into a bag, with pipes for its output."""
    words = tauto('graph', 'measured', '--out', str(out), *options)
    pipes = {'stdout': subprocess.PIPE, 'stderr': subprocess.PIPE}
    return subprocess.Popen(words, **pipes, text=True, env=env)


def is_recording(out: Path) -> bool:
    """Return whether the file of a bag has more than its first records."""
    return any(file.stat().st_size > 2000 for file in out.glob('*.mcap'))


def nodes_under(pid: int) -> list[int]:
    """Return the child processes of `pid`."""
    children = []
    for status in Path('/proc').glob('[0-9]*/stat'):
        try:
            fields = status.read_text().rpartition(')')[2].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            children.append(int(status.parent.name))
    return children


def alive(pid: int) -> bool:
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0] != 'Z'
    except OSError:
        return False


def test_a_signal_ends_every_node_with_0(tmp_path: Path) -> None:
    # The ship comes last: a clock that hears its second sample first ends with an error. A signal
    # noted before a node spins ends it just as well.
    output = tmp_path / 'bag'
    processes: dict[str, subprocess.Popen[str]] = {}
    for node in ('longitude', 'recorder', 'ship_motion'):
        if node == 'ship_motion':
            until(lambda: all(_handles_sigterm(p.pid) for p in processes.values()))
        processes[node] = start(
            node,
            '--ros-args',
            *(['-p', f'output:={output}'] if node == 'recorder' else []),
            *(['-p', 'executor:=single'] if node == 'longitude' else []),
        )
    until(lambda: _handles_sigterm(processes['ship_motion'].pid))
    for process, number in zip(processes.values(), cycle((signal.SIGINT, signal.SIGTERM))):
        process.send_signal(number)
    for node, process in processes.items():
        words, _ = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 0, (node, words)
        assert 'Traceback' not in words


def _handles_sigterm(pid: int) -> bool:
    """Whether the process has a handler for SIGTERM, which Python does not set."""
    lines = Path(f'/proc/{pid}/status').read_text().splitlines()
    caught = next(int(line.split()[1], 16) for line in lines if line.startswith('SigCgt'))
    return bool(caught >> (signal.SIGTERM - 1) & 1)


def test_bad_parameters_end_with_2_and_no_traceback() -> None:
    cases = {'speed:=-1.0': 'speed = -1.0: must lie in', '--speed=3': 'unknown argument --speed=3'}
    processes = {
        case: start('ship_motion', *([case] if case[0] == '-' else ['--ros-args', '-p', case]))
        for case in cases
    }
    for case, process in processes.items():
        words, _ = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 2, words
        assert cases[case] in words
        assert 'Traceback' not in words


def test_no_orphans_when_the_supervisor_is_killed(tmp_path: Path) -> None:
    out = tmp_path / 'bag'
    process = subprocess.Popen(
        tauto('graph', 'measured', '--speed', '5', '--out', str(out)), stderr=subprocess.DEVNULL
    )
    until(lambda: any(out.glob('*.mcap')))
    until(lambda: len(nodes_under(process.pid)) == 5)
    nodes = nodes_under(process.pid)
    until(lambda: all(_handles_sigterm(pid) for pid in nodes))
    process.kill()
    process.wait()
    until(lambda: not any(alive(pid) for pid in nodes))
    assert read_bag(out).warnings == ()


def shared_memory(pid: int) -> set[str]:
    """Return the files of Fast DDS in shared memory that a process has mapped."""
    try:
        lines = Path(f'/proc/{pid}/maps').read_text().splitlines()
    except OSError:
        return set()
    return {line.split()[5] for line in lines if '/dev/shm/' in line and 'fastrtps' in line}


def udp_ports() -> set[int]:
    """Return the ports on which any process of this machine listens."""
    lines = Path('/proc/net/udp').read_text().splitlines()[1:]
    return {int(line.split()[1].rpartition(':')[2], 16) for line in lines}


def test_a_node_that_dies_is_named_and_each_has_its_enclave(
    tmp_path: Path, ros: Callable[[Sequence[str]], None]
) -> None:
    out = tmp_path / 'bag'
    process = graph_into(out, '--speed', '5')
    until(lambda: len(nodes_under(process.pid)) == 5)
    ros(())
    onlooker = Node('onlooker')
    found = onlooker.get_node_names_and_namespaces_with_enclaves
    enclaves = {(name, '/', f'/tauto/{name}') for name in NODES}
    until(lambda: {row for row in found() if row[0] != 'onlooker'} == enclaves)
    onlooker.destroy_node()
    victim = node_of(process.pid, 'longitude')
    assert not any(map(shared_memory, (process.pid, *nodes_under(process.pid))))
    assert 7400 + 250 * int(os.environ['ROS_DOMAIN_ID']) not in udp_ports()  # none by multicast
    os.kill(victim, signal.SIGKILL)
    _, words = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1
    assert 'node longitude ended by SIGKILL before the voyage did' in words


def node_of(pid: int, node: str) -> int:
    """Return the process of a node that a supervisor has started."""
    return next(
        child
        for child in nodes_under(pid)
        if f'tauto_nodes\0{node}\0'.encode() in Path(f'/proc/{child}/cmdline').read_bytes()
    )


def test_a_recorder_that_is_stopped_makes_no_whole_voyage(tmp_path: Path) -> None:
    out = tmp_path / 'bag'
    process = graph_into(out, '--speed', '20', '--json')
    until(lambda: is_recording(out))
    os.kill(node_of(process.pid, 'recorder'), signal.SIGTERM)
    said, words = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, said) == (1, ''), words
    assert 'stopped before the voyage was over' in words
    assert 'cut_short' in (out / 'metadata.yaml').read_text()


def test_a_frozen_node_loses_nothing_nor_holds_others_up(tmp_path: Path) -> None:
    """DDS forgets a participant that is silent for 20 s, unless our profile says otherwise.

    Two nodes stand still for longer. Before they go on a foreign subscriber stops, and stands
    still to the end.
    """
    watch = (
        'import rclpy, sys; from rclpy.node import Node; from sensor_msgs.msg import Imu; '
        "rclpy.init(); node = Node('frozen'); came = []; "
        "node.create_subscription(Imu, 'ship/imu', came.append, 10)\n"
        'while not came: rclpy.spin_once(node)\n'
        'print(len(came), flush=True); rclpy.spin(node)'
    )
    environment = {**os.environ, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    watcher = subprocess.Popen(
        [sys.executable, '-c', watch], stdout=subprocess.PIPE, text=True, env=environment
    )
    out = tmp_path / 'bag'
    process = graph_into(out, '--speed', '100', '--json', env=environment)
    try:
        assert watcher.stdout is not None
        assert watcher.stdout.readline() == '1\n'
        until(lambda: is_recording(out))
        frozen = [node_of(process.pid, node) for node in ('trochlea', 'recorder')]
        for pid in frozen:
            os.kill(pid, signal.SIGSTOP)
        thaw_s = time.monotonic() + 22.0
        until(lambda: time.monotonic() > thaw_s)
        watcher.send_signal(signal.SIGSTOP)
        for pid in frozen:
            os.kill(pid, signal.SIGCONT)
        said, words = process.communicate(timeout=PATIENCE_S)
    finally:
        watcher.kill()
        watcher.communicate()
    assert process.returncode == 0, words
    topics = json.loads(said)['topics']
    assert {numbers['lost'] for numbers in topics.values()} == {0}
    assert topics['ship/imu']['written'] == 12_005
    assert check_bag(out).whole


def test_a_clock_before_zero_ends_no_node(
    ros: Callable[[Sequence[str]], None], tmp_path: Path
) -> None:
    executors = {'longitude': 'events', 'drift_estimator': 'single'}
    logs = {node: tmp_path / f'{node}.log' for node in executors}
    # The events executor tells of each such time itself, which would fill a pipe.
    with contextlib.ExitStack() as files:
        processes = {
            node: start(
                node,
                *('--ros-args', '-p', 'use_sim_time:=true', '-p', f'executor:={executor}'),
                stdout=files.enter_context(logs[node].open('w')),
            )
            for node, executor in executors.items()
        }
    ros(())
    simulator, executor = Node('simulator'), executor_named('single')
    executor.add_node(simulator)
    clock = simulator.create_publisher(Clock, '/clock', QoSProfile(depth=10))
    complained: set[str] = set()
    reported: set[str] = set()

    def hear(array: DiagnosticArray) -> None:
        if array.header.stamp.sec == 3:
            reported.update(status.name for status in array.status)

    latched = QoSProfile(depth=100, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
    simulator.create_subscription(
        Log,
        '/rosout',
        lambda log: complained.add(log.name) if 'negative' in log.msg else None,
        latched,  # a complaint may come before the subscription is matched
    )
    simulator.create_subscription(DiagnosticArray, '/diagnostics', hear, QoSProfile(depth=10))
    for second, heard in ((-5, complained), (3, reported)):
        deadline_s = time.monotonic() + PATIENCE_S
        while not executors.keys() <= heard:  # others in the domain may be heard, too
            assert all(process.poll() is None for process in processes.values())
            assert time.monotonic() < deadline_s, heard
            clock.publish(Clock(clock=Time(sec=second)))
            executor.spin_once(0.05)
    executor.shutdown()
    simulator.destroy_node()
    for node, process in processes.items():
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=PATIENCE_S) == 0, logs[node].read_text()


def test_a_node_that_hangs_says_where_before_it_is_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = (
        'import time; from tauto_nodes.live import run_nodes; '
        'run_nodes([lambda: time.sleep(3600)])'
    )
    log = tmp_path / 'stuck.log'
    with log.open('wb') as words:
        process = subprocess.Popen(
            [sys.executable, '-c', code], stdout=words, stderr=words, start_new_session=True
        )
    child = Child('stuck', process, log)
    until(lambda: _handles_sigterm(process.pid))
    monkeypatch.setattr(graph, 'TERM_S', 0.5)
    assert graph.Supervisor(tmp_path, {}, [child]).stop() == [child]
    assert process.returncode == -signal.SIGABRT
    assert 'live/__init__.py' in child.said()
    assert 'in <lambda>' in child.said()


def test_a_log_folder_that_cannot_be_made_has_a_remedy() -> None:
    home = {name: value for name, value in os.environ.items() if not name.startswith('ROS_LOG')}
    nowhere = {**home, 'HOME': '/proc/nowhere'}
    done = run_program(sys.executable, '-m', 'tauto_nodes', 'longitude', env=nowhere)
    assert done.returncode == 2
    assert "log directory '/proc/nowhere/.ros/log'" in done.stderr
    assert done.stderr.endswith('Set ROS_LOG_DIR to a folder that can be written\n')


HELD = """
import ctypes, sys
import rclpy.node
from tauto_nodes import live as running
running.LEAVE_S = 1.0
rclpy.node.Node.destroy_node = lambda node: ctypes.PyDLL(None).sleep(3600)
"""
"""A middleware that never returns and holds the interpreter's lock, as its deadlocks do."""


def test_a_blocked_node_prints_its_calls(tmp_path: Path) -> None:
    (tmp_path / 'sitecustomize.py').write_text(HELD)
    process = subprocess.Popen(
        [sys.executable, '-m', 'tauto_nodes', 'longitude'],
        env={**os.environ, 'PYTHONPATH': str(tmp_path)},
        stderr=subprocess.PIPE,
        text=True,
    )
    until(lambda: _handles_sigterm(process.pid))
    process.send_signal(signal.SIGTERM)
    _, words = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1
    assert words.startswith('Timeout (0:00:01)!')
    assert 'in _leave' in words


def test_graph_and_play_from_the_command_line(tmp_path: Path) -> None:
    """Complaints of the middleware are told beside the result.

    Fast DDS writes its log to stdout: here, in each node, an error of its profile.
    """
    out, profile = tmp_path / 'bag', tmp_path / 'profile.xml'
    profile.write_text(
        '<dds xmlns="http://www.eprosima.com"><profiles>'
        '<participant profile_name="odd" is_default_profile="true"><rtps><odd/></rtps>'
        '</participant></profiles></dds>'
    )
    brief = ('measured', '--duration', '20', '--speed', 'max')
    environment = {**os.environ, 'FASTRTPS_DEFAULT_PROFILES_FILE': str(profile)}
    done = run_program(*tauto('graph', *brief, '--out', str(out), '--json'), env=environment)
    assert done.returncode == 0, done.stderr
    said = [line for line in done.stderr.splitlines() if 'XMLPARSER' in line]
    assert f"tauto: the graph said: [XMLPARSER Error] Error parsing '{profile}'" in said[-1]
    assert len(set(said)) == len(said)
    result = json.loads(done.stdout)
    assert result['topics']['clock/reading'] == {'received': 21, 'written': 21, 'lost': 0}
    assert result['bag'] == str(out)
    assert 0.0 < result['voyage_s'] < result['wall_s'] - result['start_s']
    played = run_program(*tauto('play', str(out), '--rate', '100', '--topic', 'clock/reading'))
    assert played.returncode == 0, played.stderr
    assert 'played clock/reading 21' in played.stdout + played.stderr
    assert played.stderr.startswith(f'tauto: {out}: plays when each topic has a subscriber')


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (['graph', 'measured', '--speed', 'quick'], '--speed quick: must be a number'),
        (['graph', 'measured', '--speed', 'nan'], '--speed nan: must be a number'),
        (['graph', 'no_such_scene'], 'no_such_scene'),
        (['graph', 'measured', '--namespace', 'a b'], '--namespace'),
        (['graph', 'measured', '--out', str(BAG)], f'{BAG} exists already'),
        (['play', 'nosuch'], 'nosuch does not exist'),
        (['play', str(BAG), '--rate', '0'], "Invalid value for '--rate'"),
    ],
)
def test_what_cannot_be_sailed_or_played_is_refused(words: list[str], said: str) -> None:
    done = CliRunner().invoke(app, words)
    assert (done.exit_code, done.stdout) == (2, '')
    assert said in done.stderr
