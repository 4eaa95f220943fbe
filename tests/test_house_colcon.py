"""The packages as colcon sees, builds and installs them."""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from subprocess import CompletedProcess

import pytest
from modules import run_program

ROOT = Path(__file__).parents[1]
PACKAGES = ('tauto_core', 'tauto_nodes')
STAGES = ['trochlea', 'drift_estimator', 'longitude']
NODES = ['ship_motion', *STAGES, 'recorder', 'player', 'markers']


def colcon(log: Path, *arguments: str | Path) -> str:
    command = (sys.executable, '-m', 'colcon', '--log-base', log)
    result = run_program(*command, *arguments, cwd=ROOT / 'ros_ws')
    assert result.returncode == 0, result.stderr
    return result.stdout


@pytest.fixture(scope='module')
def install(tmp_path_factory: pytest.TempPathFactory) -> Path:
    base = tmp_path_factory.mktemp('colcon')
    bases = ('--build-base', base / 'build', '--install-base', base / 'install')
    colcon(base / 'log', 'build', *bases)
    return base / 'install'


def sourced(install: Path, *command: str | Path) -> CompletedProcess[str]:
    return run_program('bash', '-c', '. "$0" && exec "$@"', install / 'setup.bash', *command)


def test_colcon_takes_both_for_ros_packages(tmp_path: Path) -> None:
    found = {tuple(line.split('\t')[::2]) for line in colcon(tmp_path, 'list').splitlines()}
    assert found == {(package, '(ros.ament_python)') for package in PACKAGES}


def test_executables_are_where_ros2_run_looks(install: Path) -> None:
    nodes = install / 'tauto_nodes' / 'lib' / 'tauto_nodes'
    assert {file.name for file in nodes.iterdir()} >= set(NODES)
    assert (install / 'tauto_core' / 'lib' / 'tauto_core' / 'tauto').exists()


@pytest.mark.parametrize('folder', ['launch', 'config', 'layouts'])
def test_share_holds_what_users_open(install: Path, folder: str) -> None:
    source = ROOT / 'src' / 'tauto_nodes' / folder
    share = install / 'tauto_nodes' / 'share' / 'tauto_nodes' / folder
    expected = {file.name: file.read_bytes() for file in source.iterdir() if file.is_file()}
    assert expected
    assert {file.name: file.read_bytes() for file in share.iterdir()} == expected


def test_the_index_finds_the_share_folders(install: Path) -> None:
    program = (
        'from ament_index_python.packages import get_package_share_directory as share\n'
        f'print(*(share(package) for package in {PACKAGES!r}))'
    )
    result = sourced(install, sys.executable, '-c', program)
    assert result.returncode == 0, result.stderr
    assert result.stdout.split() == [
        str(install / package / 'share' / package) for package in PACKAGES
    ]


def test_the_installed_core_carries_its_scenes_and_data(install: Path) -> None:
    tauto = install / 'tauto_core' / 'lib' / 'tauto_core' / 'tauto'
    result = sourced(install, tauto, 'scene', 'check', 'measured')
    assert result.returncode == 0, result.stderr
    program = 'import tauto_core; print(tauto_core.__file__)'
    where = sourced(install, sys.executable, '-c', program).stdout.strip()
    assert Path(where).is_relative_to(install)


@pytest.mark.parametrize('node', NODES)
def test_an_installed_node_refuses_an_unknown_parameter(install: Path, node: str) -> None:
    program = install / 'tauto_nodes' / 'lib' / 'tauto_nodes' / node
    result = sourced(install, program, '--ros-args', '-p', 'no_such_parameter:=1')
    assert result.returncode != 0
    assert 'no_such_parameter' in result.stderr
    assert 'Traceback' not in result.stderr


def test_colcon_test_runs_the_tests_of_the_nodes(install: Path, tmp_path: Path) -> None:
    bases = ('--build-base', install.parent / 'build', '--install-base', install)
    asked = ('--packages-select', 'tauto_nodes', '--pytest-args', '-k', 'packs')
    colcon(tmp_path, 'test', *bases, '--return-code-on-test-failure', *asked)
    results = ET.parse(install.parent / 'build' / 'tauto_nodes' / 'pytest.xml').getroot()
    suite = next(results.iter('testsuite'))
    assert int(suite.attrib['tests']) > 5
    assert {suite.attrib[kind] for kind in ('errors', 'failures', 'skipped')} == {'0'}
