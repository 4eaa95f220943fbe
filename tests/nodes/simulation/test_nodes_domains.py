"""Environments in which the nodes of a graph could not find each other are refused at once."""

from __future__ import annotations

import contextlib
import socket
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from modules import run_program

from tauto_nodes import GraphError, ParameterError, simulation
from tauto_nodes.live import check_discovery

GRAPH = [sys.executable, '-m', 'tauto_core', 'graph', 'measured', '--speed', 'max']
REACH, NUMBER = 'ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_DOMAIN_ID'


@pytest.mark.parametrize(
    ('variable', 'value', 'said'),
    [
        (REACH, 'OFF', 'the nodes of a graph could not find each other'),
        (REACH, 'localhost', 'must be one of LOCALHOST, SUBNET, SYSTEM_DEFAULT'),
        (NUMBER, '233', 'must be a whole number from 0 to 232'),
        (NUMBER, '-1', 'must be a whole number from 0 to 232'),
        (NUMBER, 'seven', 'must be a whole number from 0 to 232'),
    ],
)
def test_what_ros_would_misread_is_refused(
    variable: str, value: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(variable, value)
    with pytest.raises(ParameterError, match=f'{variable} = {value}: {said}'):
        check_discovery()


@pytest.mark.parametrize('number', ['', '0', '100', '232'])
@pytest.mark.parametrize('reach', ['', 'LOCALHOST', 'SUBNET', 'SYSTEM_DEFAULT'])
def test_what_ros_allows_is_allowed(
    number: str, reach: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(NUMBER, number)
    monkeypatch.setenv(REACH, reach)
    check_discovery()


def test_a_domain_that_is_named_has_one_graph_a_namespace() -> None:
    with simulation.graph_environment('a'), simulation.graph_environment('b'):
        said = 'another graph of the namespace /a sails in this domain'
        with pytest.raises(GraphError, match=said), simulation.graph_environment('/a/'):
            pass


def test_a_place_that_cannot_be_written_is_named() -> None:
    with pytest.raises(GraphError, match='/proc: no folder can be made there'):
        simulation.work_folder('/proc')


def test_a_graph_finds_its_nodes_in_a_crowded_domain(tmp_path: Path, ros_domain: int) -> None:
    """By default a participant that is not found by multicast is looked for at 32 places.

    The ports of the first forty are taken, as by participants of others.
    """
    first = 7410 + 250 * ros_domain
    with contextlib.ExitStack() as taken:
        for port in range(first, first + 2 * 40):
            crowd = taken.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            with contextlib.suppress(OSError):  # a participant of an earlier test has it
                crowd.bind(('', port))
        done = run_program(*GRAPH, '--duration', '20', '--out', tmp_path / 'bag')
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize('part', ['discovery_config', 'data_writer', 'data_reader'])
def test_both_profiles_of_fast_dds_agree_but_for_the_transport(part: str) -> None:
    found = []
    for name in ('fastdds.xml', 'fastdds_loopback.xml'):
        tree = ElementTree.parse(Path(simulation.__file__).with_name(name))
        [element] = tree.iterfind(f'.//{{*}}{part}')
        found.append(ElementTree.canonicalize(ElementTree.tostring(element), strip_text=True))
    assert found[0] == found[1]
