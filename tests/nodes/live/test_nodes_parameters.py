"""Parameters: refused with the reason, documented from the table, used by launch and config."""

from __future__ import annotations

import ast
import json
import math
import os
import sys
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import pytest
import yaml
from conftest import overrides
from modules import module_of, run_program
from rclpy.node import Node
from rclpy.parameter import Parameter

from tauto_core.scene.errors import TautoError
from tauto_nodes import ParameterError
from tauto_nodes.commands import nodes_of, strangers_of
from tauto_nodes.live import SUPERVISOR
from tauto_nodes.live.parameters import PARAMETERS, declare
from tauto_nodes.live.stages import TrochleaNode

ROOT = Path(__file__).parents[3]
PACKAGE = ROOT / 'src' / 'tauto_nodes'
GRAPH_ROLES = [
    role for role, table in PARAMETERS.items() if 'flow_control' in {p.name for p in table}
]


@pytest.mark.parametrize(
    ('role', 'name', 'value', 'said'),
    [
        ('ship_motion', 'speed', -1.0, 'speed = -1.0: must lie in [0, 1e+06] s/s'),
        ('ship_motion', 'speed', math.nan, 'speed = nan: must lie in'),
        ('ship_motion', 'speed', 2, 'speed = 2: is of type integer, must be double. Write 2.0'),
        ('ship_motion', 'speed', 'fast', "speed = 'fast': is of type string, must be double"),
        ('ship_motion', 'sped', 2.0, 'no such parameter of ship_motion. The nearest is speed'),
        ('trochlea', 'imu_reliability', 'besteffort', 'must be one of reliable, best_effort'),
        ('trochlea', 'scene', '', "scene = '': must be given"),
        ('recorder', 'topics', 'all', "topics = 'all': is of type string, must be string[]"),
    ],
)
def test_refused_with_the_reason(ros: Any, role: str, name: str, value: object, said: str) -> None:
    ros(())
    node = Node(role, **overrides(**{name: value}))
    with pytest.raises(ParameterError) as refusal:
        declare(node, role)
    assert said in str(refusal.value)
    assert refusal.value.exit_code == 2


@pytest.mark.parametrize(
    ('role', 'name', 'value'),
    [
        ('recorder', 'output', '/tmp/bag'),
        ('recorder', 'output', '{}/../bag'),
        ('recorder', 'report', '{}/out/report.json'),
        ('trochlea', 'state_folder', '/var'),
        ('longitude', 'scene', '/etc/passwd'),
        ('player', 'bag', '{}/out'),
    ],
)
def test_paths_stay_in_the_folder_that_the_environment_names(
    role: str, name: str, value: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = {parameter.name: parameter for parameter in PARAMETERS[role]}
    folder = tmp_path / 'ours'
    folder.mkdir()
    (folder / 'out').symlink_to(tmp_path)
    stray = value.format(folder)
    assert table[name].problem(stray) == ''
    monkeypatch.setenv('TAUTO_FOLDER', str(folder))
    assert f'{name} = {stray!r}: is outside of TAUTO_FOLDER' in table[name].problem(stray)
    assert table[name].problem(str(folder / 'inside')) == ''
    assert PARAMETERS['longitude'][0].problem('measured') == ''


def test_all_problems_in_one_text(ros: Any) -> None:
    ros(())
    node = Node('recorder', **overrides(force='yes', topcs=('scene',)))
    with pytest.raises(
        ParameterError, match=r'force .*; topcs: .* topics; output .* must be given'
    ):
        declare(node, 'recorder')


def test_what_ros_or_another_node_knows_is_let_through(
    ros: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    """A parameter file may be for all nodes. A slip in a QoS override is a warning."""
    qos = 'qos_overrides./ship/imu.subscription'
    names = ('use_sim_time:=true', 'speed:=2.0', f'{qos}.depth:=2000', f'{qos}.dept:=7')
    ros([word for name in names for word in ('-p', name)])
    trochlea = TrochleaNode(**overrides(source='foreign'))
    assert trochlea.settings['scene'] == 'measured'
    (said,) = [line for line in capfd.readouterr().err.splitlines() if 'qos_overrides' in line]
    assert f'{qos}.dept: is of no port of this node. It has' in said
    assert '/ship/imu.subscription.depth' in said


def test_changes_at_run_time(ros: Any) -> None:
    ros(())
    node = Node('ship_motion')
    declare(node, 'ship_motion')

    def change(name: str, value: object) -> Any:
        return node.set_parameters([Parameter(name, value=value)])[0]

    assert change('speed', 3.0).successful
    refused = change('speed', -3.0)
    assert not refused.successful
    assert not change('scene', 'ideal').successful
    assert node.get_parameter('speed').value == 3.0


def test_reference_page_is_the_table() -> None:
    page = module_of(ROOT / 'docs' / 'parameters.py').reference_page()
    shared, *nodes = page.split('\n## ')[1:]
    for role, section in zip(PARAMETERS, nodes, strict=True):
        assert section.startswith(f'{role}\n')
        for parameter in PARAMETERS[role]:
            row = f'| `{parameter.name}` |'
            place = section if row in section else shared
            line = next(line for line in place.splitlines() if line.startswith(row))
            assert parameter.description in line
            assert place is section or role in line.split('|')[2]


@pytest.mark.parametrize('file', sorted((PACKAGE / 'config').glob('*.yaml')), ids=lambda f: f.stem)
def test_config_uses_declared_parameters_only(file: Path, ros: Any) -> None:
    for pattern, content in yaml.safe_load(file.read_text()).items():
        roles = [r for r in GRAPH_ROLES if pattern in ('/**', f'/**/{r}')]
        assert roles, f'{pattern} names no node'
        for role in roles:
            table = {p.name: p for p in PARAMETERS[role]}
            for name, value in content['ros__parameters'].items():
                given = tuple(value) if isinstance(value, list) else value
                assert type(given) is type(table[name].default)
                assert not table[name].problem(given)
    ros(('--params-file', str(file)))


LAUNCH = sorted((PACKAGE / 'launch').glob('*.py'))


@pytest.mark.parametrize('file', LAUNCH, ids=lambda f: f.stem)
def test_launch_files_need_nothing_of_ours(file: Path) -> None:
    """`ros2` runs them in the system's Python, which may lack the nodes' packages."""
    tree = ast.parse(file.read_text(), file.name)
    imported = set()
    for node in ast.walk(tree):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module or ''] if isinstance(node, ast.ImportFrom) else []
        imported |= {name.partition('.')[0] for name in names}
    assert imported - sys.stdlib_module_names <= {'launch', 'launch_ros', 'yaml'}


def arguments_of(kind: str) -> dict[str, str]:
    """Return the arguments of a launch file with their defaults, read without launch."""
    tree = ast.parse((PACKAGE / 'launch' / f'{kind}.launch.py').read_text())
    (table,) = (
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == 'ARGUMENTS'
    )
    assert isinstance(table, ast.Dict)
    config = {'voyage': 'voyage.yaml', 'live': 'foreign_imu.yaml'}[kind]
    held = {}
    for name, (value, _) in zip(table.keys, (v.elts for v in table.values), strict=True):
        is_file = ast.literal_eval(name) == 'params_file'
        file = str(PACKAGE / 'config' / config)
        held[ast.literal_eval(name)] = file if is_file else ast.literal_eval(value)
    return held


def planned(
    folder: Path, kind: str, typed: list[str] | None = None, **given: str
) -> CompletedProcess[str]:
    """Return what `launch_plan` answers to a launch with these arguments."""
    asked = {
        'kind': kind,
        'given': {**arguments_of(kind), **given},
        'typed': typed or [],
        'folder': str(folder),
        'supervisor': os.getpid(),
    }
    program = 'import sys; from tauto_nodes.commands import launch_plan; launch_plan();'
    program += f'assert ("tauto_nodes.simulation" in sys.modules) is {kind == "voyage"}'
    return run_program(sys.executable, '-c', program, input=json.dumps(asked))


@pytest.mark.parametrize('kind', ['voyage', 'live'])
def test_the_plan_of_a_launch_has_parameters_that_its_nodes_have(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    given = {'out': str(tmp_path / 'bag')}
    if kind == 'live':
        given |= {'imu': '/xsens/imu', 'use_sim_time': 'true', 'topics': '/battery'}
    run = planned(tmp_path, kind, **given)
    assert run.returncode == 0, run.stderr
    plan = json.loads(run.stdout.splitlines()[-1])
    assert plan['environment'][SUPERVISOR] == str(os.getpid())
    assert plan['remappings'] == ({'ship/imu': '/xsens/imu'} if kind == 'live' else {})
    written = yaml.safe_load((tmp_path / 'parameters.yaml').read_text())
    assert {name.strip('/') for name in written} == set(plan['nodes'])
    assert 'markers' in plan['nodes']
    for name, section in written.items():
        table = {p.name: p for p in PARAMETERS[name.strip('/')]}
        held = section['ros__parameters']
        assert held.pop('use_sim_time', False) is (kind == 'live')
        for key, value in held.items():
            whole = tuple(value) if isinstance(value, list) else value
            assert type(whole) is type(table[key].default), (name, key)
            assert not table[key].problem(whole)
    if kind == 'live':
        assert written['/recorder']['ros__parameters']['topics'] == ['all', '/battery']


def test_a_plan_is_refused_in_words(tmp_path: Path) -> None:
    run = planned(tmp_path, 'voyage', ['sped:=5.0'])
    assert run.returncode == 2
    assert 'sped: no such argument. The nearest is speed' in run.stderr
    assert 'Traceback' not in run.stderr
    assert not (tmp_path / 'parameters.yaml').exists()


@pytest.mark.parametrize(
    ('wrong', 'said'),
    [
        ({'speed': 'abc'}, 'speed := abc: must be a number'),
        ({'speed': '-1'}, 'speed = -1.0: must lie in'),
        ({'duration': '-5'}, 'duration = -5.0'),
        ({'force': 'perhaps'}, 'force := perhaps: must be true or false'),
        ({'executor': 'multi'}, 'must be one of events, single'),
        ({'params_file': 'nowhere.yaml'}, 'there is no such file'),
        ({'scene': 'no_such'}, 'no_such: there is no such file or built-in scene'),
        ({'out': str(PACKAGE)}, 'exists already'),
        ({'out': ''}, "output = '': must be given"),
    ],
)
def test_a_launch_is_refused_before_anything_starts(wrong: dict[str, str], said: str) -> None:
    voyage = {**arguments_of('voyage'), 'out': 'no_such_folder'}
    assert len(nodes_of('voyage', voyage)) == 6
    with pytest.raises(TautoError) as refused:
        nodes_of('voyage', {**voyage, **wrong})
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ('typed', 'said'),
    [
        (['sped:=5.0', 'out:=bag'], ['sped: no such argument. The nearest is speed']),
        (['durations:=5.0'], ['durations: no such argument. The nearest is duration']),
        (['robot_name:=x', 'launch-prefix:=nice', 'speed:=1'], []),
    ],
)
def test_a_slip_in_the_name_of_a_launch_argument(typed: list[str], said: list[str]) -> None:
    assert strangers_of(typed, arguments_of('voyage')) == said
