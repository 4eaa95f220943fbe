"""Parameters: refused with the reason, documented from the table, used by launch and config."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import yaml
from conftest import overrides
from rclpy.node import Node
from rclpy.parameter import Parameter

from tauto_nodes.errors import ParameterError
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


def test_launch_file_compiles_and_names_what_there_is() -> None:
    text = (PACKAGE / 'launch' / 'voyage.launch.py').read_text()
    names: dict[str, Any] = {}
    head = text.index('ARGUMENTS'), text.index('def _node')
    exec(compile(text[head[0] : head[1]], 'voyage.launch.py', 'exec'), names)
    compile(text, 'voyage.launch.py', 'exec')
    assert set(names['ARGUMENTS']) == {'scene', 'speed', 'out', 'force', 'namespace'}
    for parameter, role in (
        ('output', 'recorder'),
        ('force', 'recorder'),
        ('speed', 'ship_motion'),
    ):
        assert f"'{parameter}':" in text
        assert parameter in {p.name for p in PARAMETERS[role]}
    assert "'voyage.yaml'" in text
    assert (PACKAGE / 'config' / 'voyage.yaml').is_file()
