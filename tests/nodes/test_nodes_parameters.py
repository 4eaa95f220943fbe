"""Parameters: refused with the reason, documented from the table, used by launch and config."""

from __future__ import annotations

import ast
import math
from pathlib import Path
from typing import Any

import pytest
import yaml
from conftest import overrides
from rclpy.node import Node
from rclpy.parameter import Parameter

from tauto_nodes.errors import GraphError, ParameterError
from tauto_nodes.launching import end_of, live_problems, voyage_problems
from tauto_nodes.parameters import PARAMETERS, declare, reference_page

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / 'src' / 'tauto_nodes'


@pytest.mark.parametrize(
    ('role', 'name', 'value', 'said'),
    [
        ('ship_motion', 'speed', -1.0, 'speed = -1.0: must lie in [0, 1e+06] s/s'),
        ('ship_motion', 'speed', math.nan, 'speed = nan: must lie in'),
        ('ship_motion', 'speed', 2, 'speed = 2: is an integer, must be a double; write 2.0'),
        ('ship_motion', 'speed', 'fast', "speed = 'fast': is of type string, must be double"),
        (
            'ship_motion',
            'sped',
            2.0,
            'sped: no such parameter of ship_motion; the nearest is speed',
        ),
        ('trochlea', 'imu_reliability', 'besteffort', 'must be one of reliable, best_effort'),
        ('trochlea', 'scene', '', "scene = '': must be given"),
        ('recorder', 'topics', 'all', "topics = 'all': is of type string, must be string[]"),
        ('longitude', 'imu_reliability', 'reliable', 'no such parameter of longitude'),
    ],
)
def test_refused_with_the_reason(ros: Any, role: str, name: str, value: object, said: str) -> None:
    ros(())
    node = Node(role, **overrides(**{name: value}))
    with pytest.raises(ParameterError) as refusal:
        declare(node, role)
    assert said in str(refusal.value)
    assert refusal.value.exit_code == 2


def test_all_problems_in_one_text(ros: Any) -> None:
    ros(())
    node = Node('recorder', **overrides(force='yes', topcs=('scene',)))
    with pytest.raises(
        ParameterError, match=r'force .*; topcs: .* topics; output .* must be given'
    ):
        declare(node, 'recorder')


def test_unknown_name_in_a_parameter_file(ros: Any, tmp_path: Path) -> None:
    file = tmp_path / 'p.yaml'
    file.write_text('/**:\n  ros__parameters:\n    scne: measured\n')
    ros(('--params-file', str(file)))
    with pytest.raises(ParameterError, match=r'scne: no such parameter of longitude.*scene'):
        declare(Node('longitude'), 'longitude')


def test_what_ros_itself_knows_is_let_through(ros: Any) -> None:
    ros(('-p', 'use_sim_time:=true', '-p', 'qos_overrides./ship/imu.publisher.depth:=2000'))
    settings = declare(Node('longitude'), 'longitude')
    assert settings.text('scene') == 'measured'


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
    assert (ROOT / 'docs' / 'parameters.md').read_text() == reference_page()


@pytest.mark.parametrize('file', sorted((PACKAGE / 'config').glob('*.yaml')), ids=lambda f: f.stem)
def test_config_uses_declared_parameters_only(file: Path, ros: Any) -> None:
    for pattern, content in yaml.safe_load(file.read_text()).items():
        roles = [r for r in PARAMETERS if pattern in ('/**', f'/**/{r}') and r != 'player']
        assert roles, f'{pattern} names no node'
        for role in roles:
            table = {p.name: p for p in PARAMETERS[role]}
            for name, value in content['ros__parameters'].items():
                given = tuple(value) if isinstance(value, list) else value
                assert type(given) is type(table[name].default)
                assert not table[name].problem(given)
    ros(('--params-file', str(file)))


@pytest.mark.parametrize('file', sorted((PACKAGE / 'launch').glob('*.py')), ids=lambda f: f.stem)
def test_launch_files_compile_and_set_what_there_is(file: Path) -> None:
    tree = ast.parse(file.read_text(), file.name)
    known = {parameter.name for table in PARAMETERS.values() for parameter in table}
    table = next(
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == 'ARGUMENTS'
    )
    assert isinstance(table, ast.Dict)
    arguments = {ast.literal_eval(key) for key in table.keys if key is not None}
    assert arguments <= known | {'out', 'namespace', 'params_file', 'imu'}
    given = {
        ast.unparse(node.slice).strip("'")
        for node in ast.walk(tree)
        if isinstance(node, ast.Subscript) and ast.unparse(node.value) == 'given'
    }
    assert given <= arguments


VOYAGE = {
    'scene': 'measured',
    'speed': '60.0',
    'duration': '0.0',
    'out': 'no_such_folder',
    'force': 'false',
    'namespace': '',
    'executor': 'events',
    'params_file': str(PACKAGE / 'config' / 'voyage.yaml'),
}


@pytest.mark.parametrize(
    ('wrong', 'said'),
    [
        ({'speed': 'abc'}, 'speed := abc: must lie in'),
        ({'speed': '-1'}, 'speed = -1.0: must lie in'),
        ({'duration': '-5'}, 'duration = -5.0'),
        ({'force': 'perhaps'}, 'force := perhaps: must be true or false'),
        ({'executor': 'multi'}, 'must be one of events, single'),
        ({'params_file': 'nowhere.yaml'}, 'there is no such file'),
        ({'scene': 'no_such_scene'}, 'no_such_scene'),
        ({'out': str(PACKAGE)}, 'exists already'),
    ],
)
def test_a_launch_is_refused_before_anything_starts(wrong: dict[str, str], said: str) -> None:
    assert voyage_problems(VOYAGE) == []
    assert said in '; '.join(voyage_problems({**VOYAGE, **wrong}))
    sensor = {'imu': '/x', 'imu_reliability': 'best_effort', 'state_folder': '', **VOYAGE}
    assert live_problems({**sensor, 'out': ''}) == []
    assert 'one of' in '; '.join(live_problems({**sensor, 'imu_reliability': 'perhaps'}))


class _Context:
    """What the end of a node asks of a launch."""

    def __init__(self, is_shutdown: bool) -> None:
        self.is_shutdown = is_shutdown


@pytest.mark.parametrize('code', [0, 1, -9])
def test_the_end_of_any_node_but_the_last_one_fails_the_launch(code: int) -> None:
    event = type('ProcessExited', (), {'returncode': code})
    with pytest.raises(GraphError, match=f'node trochlea ended with exit code {code} before'):
        end_of('trochlea', event, _Context(False), last='recorder')
    assert end_of('trochlea', event, _Context(True), last='recorder') == []
    if code:
        with pytest.raises(GraphError, match='node recorder'):
            end_of('recorder', event, _Context(False), last='recorder')
