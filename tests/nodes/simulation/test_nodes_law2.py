"""Law 2: the graph is only a transport. Its bag equals the bag of `tauto sail`."""

from __future__ import annotations

import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from conftest import DRIFT, WARM
from typer.testing import CliRunner

from tauto_core.bags import read_bag
from tauto_core.cli.app import app
from tauto_core.samples import ESTIMATE, READING, SHIP_IMU, SHIP_TEMPERATURE, SLACK, ImuSamples
from tauto_core.scene import load_scene, parse_scene, scene_yaml
from tauto_core.voyage import sail, summarise_bag
from tauto_nodes.simulation.supervisor import GraphPlan, run_graph

SLOOP = yaml.safe_load("""
{ship.hull: sloop, ship.clock: {forward: 5.0}, ship.heading: 2.356, ship.rate: 10.0,
 ship.height: 1.0, ship.roll.natural_period: 8.0}
""")


def own_scene(**given: Any) -> str:
    """Return the text of a changed scene."""
    return scene_yaml(load_scene('involute_weight_at_sea', **given))


@pytest.fixture(autouse=True)
def own_domain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each graph takes a free domain, as for a user."""
    monkeypatch.delenv('ROS_DOMAIN_ID', raising=False)


def assert_equal_bags(one: Path, other: Path) -> None:
    """Same topics, payload for payload, with the same log times and the same sea."""
    told = [
        yaml.safe_load((bag / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
        for bag in (one, other)
    ]
    assert told[0]['custom_data'] == told[1]['custom_data']
    first, second = read_bag(one), read_bag(other)
    assert first.counts == second.counts
    for topic in first.topics:
        stamps, payloads = first.payloads(topic)
        again, copies = second.payloads(topic)
        np.testing.assert_array_equal(stamps, again)
        assert payloads == copies, topic


ON_A_PASSAGE = yaml.safe_load("""
ship:
  {kind: sea, heave: true, rate: 20.0, weather: {kind: log},
   roll: {natural_period: 8.0, damping_ratio: 0.08, slope_coefficient: 0.7}}
voyage:
  log:
    source: two noons
    passage: '17700101-1'
    entries:
    - ['1770-01-01T12:00', 48.0, -6.0, 270.0, 9.3, null]
    - ['1770-01-02T12:00', 46.5, -8.0, 290.0, 12.3, null]
""")
WARMING = {'kind': 'constant', 'celsius': 12.0, 'diurnal': 4.0, 'box_hours': 0.5}
WARM_SLOOP = own_scene(**SLOOP, air=WARMING, **{'log.interval': 5.0})

SCENES: dict[str, tuple[str, float, str]] = {
    # the scene, its duration [s], a topic that it must have
    'no motion in its bag': ('portsmouth_jamaica', 300.0, READING),
    'hung, the ship looks further ahead': ('suspended_weight_at_sea', 60.0, SHIP_IMU),
    'a hull; the last temperature lies beyond the motion': (WARM_SLOOP, 60.0, SHIP_TEMPERATURE),
    'a young sea, each side counts the slacks': (own_scene(**ON_A_PASSAGE), 600.0, SLACK),
    'motion is a covariate': (own_scene(drift=DRIFT), 60.0, ESTIMATE),
    'latitude and thermometer are covariates': (WARM, 1800.0, ESTIMATE),
}


def middleware_threads() -> set[str]:
    """Return the threads of this process' DDS participants, by task."""
    threads = Path('/proc/self/task').iterdir()
    return {task.name for task in threads if (task / 'comm').read_text().startswith('dds.ev')}


@pytest.mark.parametrize('name', SCENES)
def test_bag_of_the_graph_is_the_bag_of_sail(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The supervisor does not import the middleware, which can hang a node.

    Nor do the nodes import files of the working folder.
    """
    monkeypatch.chdir(tmp_path)
    for module in ('json', 'yaml', 'tauto_nodes', 'sitecustomize'):
        Path(f'{module}.py').write_text(f"raise SystemExit('{module} of the working folder')")
    scene, duration_s, topic = SCENES[name]
    if '\n' in scene:
        (tmp_path / 'own.yaml').write_text(scene, encoding='utf-8')
        scene = str(tmp_path / 'own.yaml')
    loaded = load_scene(scene, duration=duration_s)
    told: list[float] = []
    seen: set[str] = set()
    before = middleware_threads()

    def look(share: float) -> None:
        told.append(share)
        seen.update(middleware_threads() - before)

    outcome = run_graph(GraphPlan(scene, tmp_path / 'graph', duration_s, 0.0), loaded, look)
    assert outcome.lost == outcome.signal == len(seen) == 0
    assert told == sorted(told)
    offline = sail(loaded, tmp_path / 'sail').result
    assert_equal_bags(tmp_path / 'sail', tmp_path / 'graph')
    counts = {f'/{topic}': n['written'] for topic, n in outcome.counts.items() if n['written']}
    assert counts == read_bag(tmp_path / 'graph').counts
    assert counts[f'/{topic}'] > 0
    summary = summarise_bag(tmp_path / 'graph')
    assert {key: summary[key] for key in ('clock', 'drift')} == {
        key: offline[key] for key in ('clock', 'drift')
    }


def test_a_graph_is_as_exact_as_it_is_asked_to_be(tmp_path: Path) -> None:
    """Of the accuracy the rate follows, in place of the one that the scene states."""
    scene = tmp_path / 'in_a_sloop.yaml'
    scene.write_text(own_scene(**SLOOP), encoding='utf-8')
    asked = ('--duration', '30', '--accuracy', '0.1')
    for command, options in (('graph', ('--speed', 'max')), ('sail', ())):
        words = [command, str(scene), *asked, *options, '--out', str(tmp_path / command)]
        run = CliRunner().invoke(app, words)
        assert run.exit_code == 0, run.stderr
    assert_equal_bags(tmp_path / 'sail', tmp_path / 'graph')
    felt = sail(load_scene(scene, duration=30.0)).samples[SHIP_IMU]
    assert isinstance(felt, ImuSamples)
    assert np.abs(felt.linear_acceleration[:, 0]).max() > 0.1  # the hull surges and pitches
    sailed = parse_scene(read_bag(tmp_path / 'graph').scene, 'graph')
    assert sailed.accuracy == 0.1
    assert sailed.solver is not None
    assert sailed.ship.rate < 10.0


def test_a_signal_after_the_bag_is_closed_cuts_nothing_short(tmp_path: Path) -> None:
    loaded = load_scene('measured', duration=5.0)
    bag = tmp_path / 'graph'
    deadline_s = time.monotonic() + 300.0

    def signalled_when_closed(_: float) -> None:
        while not (bag / 'metadata.yaml').exists():
            assert time.monotonic() < deadline_s, 'the bag was not closed in time'
            time.sleep(0.05)
        signal.raise_signal(signal.SIGTERM)

    plan = GraphPlan('measured', bag, 5.0, 0.0)
    outcome = run_graph(plan, loaded, signalled_when_closed)
    assert outcome.signal == 0
    assert outcome.counts['clock/reading']['written'] == loaded.log_count
