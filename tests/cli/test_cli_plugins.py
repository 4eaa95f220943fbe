"""`tauto graph` and `tauto play` come from another distribution, or say how to get it."""

from __future__ import annotations

import importlib.metadata
from importlib.metadata import EntryPoint
from typing import Annotated

import pytest
import typer
from command_line import invoke
from typer.testing import Result

from tauto_core.scene.errors import UsageError


def sail_nodes(scene: str, speed: Annotated[float, typer.Option()] = 60.0) -> None:
    """Stand in for the graph."""
    if speed <= 0.0:
        raise UsageError(f'--speed = {speed}: must be > 0. Give another')
    if scene == 'needs_rclpy':
        raise ModuleNotFoundError("No module named 'rclpy'", name='rclpy')
    if scene == 'needs_other':
        raise ModuleNotFoundError("No module named 'other'", name='other')
    typer.echo(f'{scene} at {speed}')


def install(monkeypatch: pytest.MonkeyPatch, *entries: EntryPoint) -> None:
    def found(*, group: str, name: str) -> list[EntryPoint]:
        return [entry for entry in entries if (entry.group, entry.name) == (group, name)]

    monkeypatch.setattr(importlib.metadata, 'entry_points', found)


def graph(*arguments: str) -> Result:
    return invoke('graph', *arguments)


@pytest.fixture
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    install(monkeypatch, EntryPoint('graph', f'{__name__}:sail_nodes', 'tauto.commands'))


@pytest.mark.usefixtures('_installed')
class TestInstalled:
    def test_gets_its_arguments(self) -> None:
        assert graph('ideal', '--speed', '2').stdout == 'ideal at 2.0\n'

    def test_shows_its_own_help(self) -> None:
        result = graph('--help')
        assert result.exit_code == 0
        assert 'Usage: tauto graph' in result.stdout.replace('root ', 'tauto ')
        assert '--speed' in result.stdout

    def test_its_errors_are_those_of_every_command(self) -> None:
        result = graph('ideal', '--speed', '0')
        assert (result.exit_code, result.stdout) == (2, '')
        assert result.stderr.startswith('tauto: --speed = 0.0')

    def test_a_bad_option_exits_2(self) -> None:
        assert graph('ideal', '--nonsense').exit_code == 2

    def test_without_ros_names_the_remedy(self) -> None:
        result = graph('needs_rclpy')
        assert result.exit_code == 1
        assert 'rclpy' in result.stderr
        assert 'make sail' in result.stderr

    def test_a_missing_module_of_another_kind_is_a_fault(self) -> None:
        assert isinstance(graph('needs_other').exception, ModuleNotFoundError)


@pytest.mark.parametrize('name', ['graph', 'play'])
def test_not_installed_names_the_remedy(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    install(monkeypatch)
    for arguments in ([name], [name, '--help'], [name, 'x', '--rate', '2']):
        result = invoke(*arguments)
        assert result.exit_code == 1
        assert 'tauto_nodes' in result.stderr
        assert 'make sail' in result.stderr
    assert name in invoke('--help').stdout
