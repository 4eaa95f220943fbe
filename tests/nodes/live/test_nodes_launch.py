"""The launch files under a real `ros2 launch`: refusals, shutdown, and no remains.

They need launch, launch_ros, ros2launch and an installed tauto_nodes: a ROS
machine, after `colcon build` and sourcing. None of the three is on PyPI. On a machine without ROS
build the jazzy branches of launch, launch_ros, ros2cli and rosidl_runtime_py elsewhere. With
$TAUTO = the repository and $TAUTO/.venv/bin on the PATH, in an empty folder:

    for r in launch launch_ros ros2cli rosidl_runtime_py
    do git clone --branch jazzy https://github.com/ros2/$r; done
    find . -name package.xml | xargs sed -i '/<test_depend>/d; /composition_interfaces/d'
    pip install --target deps osrf-pycommon psutil netifaces packaging
    export PYTHONPATH=$PWD/deps
    python -m colcon build --base-paths launch launch_ros ros2cli rosidl_runtime_py $TAUTO/src \
        --packages-up-to ros2launch ros2pkg ros2run ros2topic tauto_nodes
    source install/setup.bash
    export PYTHONPATH=$PYTHONPATH:$PWD/stand_in AMENT_PREFIX_PATH=$AMENT_PREFIX_PATH:$TAUTO/.venv
    cd $TAUTO
    python -m pytest -p no:launch_testing -p no:launch_ros tests/nodes/live/test_nodes_launch.py

`stand_in` holds a package `composition_interfaces` with a module `srv`: its classes `LoadNode`,
`ListNodes` and `UnloadNode` have empty classes `Request` and `Response`: launch_ros imports them,
and our launch files do not use them. The two pytest plugins need an older pytest. Build again
after each change, since the tests run the installed nodes.
"""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
from conftest import PATIENCE_S, until
from rclpy.node import Node

from tauto_core.bags import check_bag, read_bag

ABSENT = [
    name
    for name in ('launch', 'launch_ros', 'ros2launch', 'ros2cli', 'composition_interfaces')
    if importlib.util.find_spec(name) is None
]
INSTALLED = any(
    (Path(prefix) / 'lib/tauto_nodes/trochlea').is_file()
    for prefix in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
)
pytestmark = pytest.mark.skipif(
    bool(ABSENT) or not INSTALLED,
    reason=f'not on PyPI and not installed: {", ".join(ABSENT)}'
    if ABSENT
    else 'no installed tauto_nodes is sourced: colcon build, then source install/setup.bash',
)

NODES = ('ship_motion', 'trochlea', 'drift_estimator', 'longitude', 'recorder')
"""Only what hangs takes so long, however busy the machine."""

# A shell that starts jobs in the background lets them ignore SIGINT. The Python of `ros2` need not
# see Tauto's packages, but its nodes do.
ROS2 = """
import signal
import sys
for name in ('pydantic', 'tauto_core', 'tauto_nodes', 'typer', 'mcap', 'rosbags'):
    sys.modules[name] = None
from ros2cli.cli import main
signal.signal(signal.SIGINT, signal.default_int_handler)
raise SystemExit(main())
"""
MARK = 'TAUTO_LAUNCH_TEST'


class Launch:
    """A running `ros2 launch tauto_nodes ...`, with processes known by their environment."""

    def __init__(self, log: Path, file: str, *arguments: str) -> None:
        self.log, self.mark = log, f'{MARK}={log}'
        self.temporary = log.parent / 'temporary'
        self.temporary.mkdir(exist_ok=True)
        folders = {
            'ROS_HOME': str(log.parent / 'home'),
            'ROS_LOG_DIR': str(log.parent / 'log'),
            'TMPDIR': str(self.temporary),
        }
        environment = {**os.environ, MARK: str(log), **folders}
        with log.open('wb') as words:
            self.process = subprocess.Popen(
                [sys.executable, '-c', ROS2, 'launch', 'tauto_nodes', file, *arguments],
                cwd=log.parent,
                env=environment,
                stdout=words,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def nodes(self) -> dict[str, int]:
        """Return the processes of its nodes, by executable."""
        found = {}
        for words in Path('/proc').glob('[0-9]*/cmdline'):
            try:
                told = words.with_name('environ').read_bytes().split(b'\0')
                said = os.fsdecode(words.read_bytes()).split('\0')
                programs = [word for word in said if '/lib/tauto_nodes/' in word]
            except OSError:
                continue
            if programs and self.mark.encode() in told:
                found[Path(programs[0]).name] = int(words.parent.name)
        return found

    def said(self) -> str:
        """Return what launch and nodes have written."""
        return self.log.read_text('utf-8', 'replace')

    def code(self) -> int:
        """Return the exit code of the launch once it has ended and left nothing behind."""
        code = self.process.wait(PATIENCE_S)
        until(lambda: not self.nodes())
        if code >= 0:  # the next start removes the folder of a killed one
            assert not list(self.temporary.iterdir())
        return code


@contextmanager
def launched(folder: Path, file: str, *arguments: str) -> Iterator[Launch]:
    """Yield a launch, and kill its remains afterwards."""
    launch = Launch(folder / 'launch.log', file, *arguments)
    try:
        yield launch
    finally:
        left = [launch.process.pid] if launch.process.poll() is None else []
        for pid in (*left, *launch.nodes().values()):
            os.kill(pid, signal.SIGKILL)
        launch.process.wait(PATIENCE_S)


@contextmanager
def at_sea(folder: Path, *arguments: str) -> Iterator[Launch]:
    """Yield a voyage whose first messages are in its bag."""
    slow = ('speed:=5.0', f'out:={folder / "bag"}', *arguments)
    with launched(folder, 'voyage.launch.py', *slow) as launch:
        bag = folder / 'bag'
        until(
            lambda: (
                launch.process.poll() is not None
                or any(file.stat().st_size > 2000 for file in bag.glob('*.mcap'))
            )
        )
        assert launch.process.poll() is None, launch.said()
        yield launch


@pytest.mark.parametrize(
    ('file', 'wrong', 'said'),
    [
        ('voyage', 'speed:=abc', 'speed := abc: must be a number'),
        ('voyage', 'sped:=5.0', 'sped: no such argument. The nearest is speed'),
        ('live', 'scene:=no_such', 'no_such: there is no such file or built-in scene'),
    ],
)
def test_bad_arguments_are_refused_before_anything_starts(
    tmp_path: Path, file: str, wrong: str, said: str
) -> None:
    with launched(tmp_path, f'{file}.launch.py', wrong) as launch:
        assert launch.code() != 0
        assert said in launch.said()
        assert 'process started' not in launch.said()


@pytest.mark.parametrize('executor', ['events', 'single'])
def test_a_voyage_ends_well_with_a_whole_bag(tmp_path: Path, executor: str) -> None:
    flat_out = ('speed:=0.0', 'duration:=120.0', f'executor:={executor}', 'namespace:=clock_a')
    with launched(tmp_path, 'voyage.launch.py', *flat_out, 'out:=bag') as launch:
        assert launch.code() == 0, launch.said()
    assert check_bag(tmp_path / 'bag').whole
    counts = read_bag(tmp_path / 'bag').counts
    assert counts['/clock_a/clock/reading'] == 121
    assert counts['/clock_a/ship/imu'] > 2400


@pytest.mark.parametrize('node', ['recorder', 'ship_motion', 'trochlea'])
def test_a_killed_node_ends_the_launch(tmp_path: Path, node: str) -> None:
    with at_sea(tmp_path) as launch:
        os.kill(launch.nodes()[node], signal.SIGKILL)
        assert launch.code() == 1
        assert f'node {node} ended with exit code -9 before its time' in launch.said()


@pytest.mark.parametrize('node', ['recorder', 'trochlea'])
def test_a_node_that_is_stopped_ends_the_launch_and_not_well(tmp_path: Path, node: str) -> None:
    with at_sea(tmp_path) as launch:
        os.kill(launch.nodes()[node], signal.SIGTERM)
        assert launch.code() == 1
        assert f'node {node} ' in launch.said()
    assert check_bag(tmp_path / 'bag').cut_short


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_whatever_ends_the_launch_ends_the_nodes(tmp_path: Path, number: signal.Signals) -> None:
    with at_sea(tmp_path) as launch:
        os.kill(launch.process.pid, number)
        assert launch.code() == (0 if number == signal.SIGINT else -number)
        assert check_bag(tmp_path / 'bag').cut_short, launch.said()


def readings(bag: Path) -> int:
    """Return how many readings a bag holds that is still being written."""
    files = list(bag.glob('*.mcap'))
    return read_bag(files[0]).counts.get('/clock/reading', 0) if files else 0


def test_a_live_clock_follows_a_bag_and_ends_with_its_node(
    tmp_path: Path, ros: Callable[[Sequence[str]], None]
) -> None:
    given = ('speed:=0.0', 'duration:=60.0', 'out:=sensor')
    with launched(tmp_path, 'voyage.launch.py', *given) as launch:
        assert launch.code() == 0, launch.said()
    live = ('imu:=/xsens/imu', 'imu_reliability:=reliable', 'out:=live')
    with launched(tmp_path, 'live.launch.py', *live) as launch:
        ros(())
        onlooker = Node('onlooker')
        until(lambda: onlooker.count_subscribers('/xsens/imu') == 2)  # trochlea and recorder
        onlooker.destroy_node()
        play = [sys.executable, '-m', 'tauto_nodes', 'player', '--ros-args']
        given = ('bag:=sensor', 'rate:=10.0', 'topics:=[scene, ship/imu]')
        for parameter in given:
            play += ['-p', parameter]
        play += ['-r', 'ship/imu:=/xsens/imu']
        subprocess.run(play, cwd=tmp_path, check=True, timeout=PATIENCE_S)
        until(lambda: readings(tmp_path / 'live') > 20)
        os.kill(launch.nodes()['trochlea'], signal.SIGINT)
        assert launch.code() == 1
        assert 'node trochlea ended with exit code 0 before its time' in launch.said()
    counts = read_bag(tmp_path / 'live').counts
    # The player starts with the first of the two. The other may come seconds later.
    assert counts['/xsens/imu' if '/xsens/imu' in counts else '/ship/imu'] > 600


def test_a_live_node_that_dies_is_started_again(tmp_path: Path) -> None:
    names = ('trochlea', 'recorder')
    with launched(tmp_path, 'live.launch.py', 'out:=live') as launch:
        until(lambda: {*names} <= launch.nodes().keys() and list((tmp_path / 'live').glob('*')))
        first = launch.nodes()
        for name in names:
            os.kill(first[name], signal.SIGKILL)
        until(lambda: all(launch.nodes().get(name, first[name]) != first[name] for name in names))
        until(lambda: list((tmp_path / 'live_2').glob('*.mcap')))  # a bag beside the first
        os.kill(launch.process.pid, signal.SIGINT)
        assert launch.code() == 0
        assert 'node trochlea ended with exit code -9: it is started again' in launch.said()
    assert check_bag(tmp_path / 'live_2').whole
    assert read_bag(tmp_path / 'live_2').scene is not None


def test_a_live_node_that_refuses_to_start_ends_the_launch(tmp_path: Path) -> None:
    with launched(tmp_path, 'live.launch.py', 'imu_rotation:=sideways') as launch:
        assert launch.code() == 1
        assert "imu_rotation = 'sideways': must be roll, pitch and yaw" in launch.said()
        assert 'ended with exit code 2 before its time' in launch.said()
