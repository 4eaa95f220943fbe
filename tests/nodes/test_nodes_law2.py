"""Law 2: the graph is only a transport. Its bag equals the bag of `tauto sail`."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from tauto_core.bags import read_bag
from tauto_core.cli.app import app
from tauto_core.samples import (
    READING,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    SLACK,
    ImuSamples,
    TemperatureSamples,
)
from tauto_core.scene import load_scene, parse_scene
from tauto_core.voyage import sail, summarise_bag
from tauto_nodes import GraphError
from tauto_nodes.graph import GraphPlan, run_graph

IN_A_SLOOP = """\
duration: 600.0
trochlea:
  inertia: 4.0e-4
  cam: {kind: involute, base_radius: 0.0053681}
  thread: {kind: vertical}
  power: {kind: weight, mass: 0.3, massless: true}
  release_angle: 1.0
ship:
  kind: sea
  rate: 10.0
  height: 1.0
  hull: sloop
  clock: {forward: 5.0}
  heading: 2.356
  roll: {natural_period: 8.0, damping_ratio: 0.08}
  sea: {spectrum: bretschneider, significant_wave_height: 2.5, peak_period: 9.0}
"""


@pytest.fixture(autouse=True)
def own_domain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each graph takes a free domain, as those of users do."""
    monkeypatch.delenv('ROS_DOMAIN_ID', raising=False)


def assert_equal_bags(one: Path, other: Path) -> None:
    """Same topics, payload for payload, with the same log times; the same said of the sea."""
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


# Five minutes of measured motion flat out, one process a node; then the still ship, whose motion
# is one sample a log interval; then a scene that keeps no motion in its bag, all in one process;
# then a suspended clock, for which the ship must look further ahead; then a sea, of which the
# bag's metadata tell.
@pytest.mark.parametrize(
    ('scene', 'duration_s', 'compose'),
    [
        ('measured', 300.0, False),
        ('ideal', 3600.0, True),
        ('portsmouth_jamaica', 600.0, True),
        ('suspended_weight_at_sea', 60.0, True),
        ('buoy_44004_supply', 60.0, True),
    ],
)
def test_bag_of_the_graph_is_the_bag_of_sail(
    scene: str, duration_s: float, compose: bool, tmp_path: Path
) -> None:
    loaded = load_scene(scene, duration=duration_s)
    told: list[float] = []
    plan = GraphPlan(scene, tmp_path / 'graph', duration_s=duration_s, speed=0.0, compose=compose)
    outcome = run_graph(plan, loaded, lambda standing: told.append(standing.share))
    assert outcome.lost == 0
    assert outcome.signal == 0
    assert told == sorted(told)
    offline = sail(loaded, tmp_path / 'sail').result
    assert_equal_bags(tmp_path / 'sail', tmp_path / 'graph')
    counts = {f'/{topic}': n['written'] for topic, n in outcome.counts.items() if n['written']}
    assert counts == read_bag(tmp_path / 'graph').counts
    summary = summarise_bag(tmp_path / 'graph')
    assert {key: summary[key] for key in ('clock', 'drift')} == {
        key: offline[key] for key in ('clock', 'drift')
    }


def test_a_graph_sails_the_scene_as_it_was_changed(tmp_path: Path) -> None:
    """Nodes load a file or a name; a scene that was changed after loading is neither."""
    loaded = load_scene('measured', duration=20.0, **{'trochlea.release_angle': 0.3})
    plan = GraphPlan('measured', tmp_path / 'graph', 20.0, 0.0, compose=True, changed=True)
    assert run_graph(plan, loaded, lambda _: None).lost == 0
    sail(loaded, tmp_path / 'sail')
    assert_equal_bags(tmp_path / 'sail', tmp_path / 'graph')


def test_a_graph_is_as_exact_as_it_is_asked_to_be(tmp_path: Path) -> None:
    """Of the accuracy the rate follows, in place of the one that the scene states."""
    scene = tmp_path / 'in_a_sloop.yaml'
    scene.write_text(IN_A_SLOOP, encoding='utf-8')
    asked = ('--duration', '30', '--accuracy', '0.1')
    for command, options in (('graph', ('--compose', '--speed', 'max')), ('sail', ())):
        words = [command, str(scene), *asked, *options, '--out', str(tmp_path / command)]
        run = CliRunner().invoke(app, words)
        assert run.exit_code == 0, run.stderr
    assert_equal_bags(tmp_path / 'sail', tmp_path / 'graph')
    sailed = parse_scene(read_bag(tmp_path / 'graph').scene, 'graph')
    assert (sailed.accuracy, sailed.states_accuracy) == (0.1, True)
    assert sailed.ship.rate < 10.0


def test_a_clock_in_a_hull_reads_in_a_graph_what_it_reads_offline(tmp_path: Path) -> None:
    scene = tmp_path / 'in_a_sloop.yaml'
    scene.write_text(IN_A_SLOOP, encoding='utf-8')
    flat_out = ('--compose', '--speed', 'max')
    for command, options in (('graph', flat_out), ('sail', ())):
        words = [command, str(scene), *options, '--out', str(tmp_path / command)]
        run = CliRunner().invoke(app, words)
        assert run.exit_code == 0, run.stderr
    assert_equal_bags(tmp_path / 'sail', tmp_path / 'graph')
    bag = read_bag(tmp_path / 'graph')
    assert bag.counts[f'/{READING}'] == 601
    imu = bag.samples(SHIP_IMU)
    assert isinstance(imu, ImuSamples)
    assert len(imu.stamp_ns) >= 6001
    # without a hull, ships of a scene roll and heave only
    assert np.std(imu.linear_acceleration[:, 0]) > 0.1
    assert np.std(imu.angular_velocity[:, 1:], axis=0).min() > 1e-3


def test_the_temperature_of_a_graph_is_the_one_offline(tmp_path: Path) -> None:
    """Logged every 5 s, the last one lies beyond all samples of the motion."""
    scene = tmp_path / 'warming.yaml'
    air = 'air: {kind: route, celsius: 12.0, diurnal: 4.0, box_hours: 0.5}\n'
    scene.write_text(f'{IN_A_SLOOP}{air}log: {{interval: 5.0}}\n', encoding='utf-8')
    sail(load_scene(scene), tmp_path / 'sail')
    plan = GraphPlan(str(scene), tmp_path / 'graph', speed=0.0, compose=True)
    assert run_graph(plan, load_scene(scene), lambda _: None).lost == 0
    assert_equal_bags(tmp_path / 'sail', tmp_path / 'graph')
    felt = read_bag(tmp_path / 'graph').samples(SHIP_TEMPERATURE)
    assert isinstance(felt, TemperatureSamples)
    assert felt.frame_id == 'clock_case'
    np.testing.assert_array_equal(felt.stamp_ns, (86_400 + 5 * np.arange(122)) * 10**9)
    assert np.all(np.diff(felt.temperature) < 0.0)


CORK_ON_A_PASSAGE = """\
duration: 600.0
trochlea:
  inertia: 4.0e-4
  cam: {kind: involute, base_radius: 0.0053681}
  thread: {kind: vertical}
  power: {kind: weight, mass: 0.3}
  release_angle: 1.0
ship:
  kind: sea
  heave: true
  rate: 20.0
  roll: {natural_period: 8.0, damping_ratio: 0.08, slope_coefficient: 0.7}
  weather: {kind: log}
voyage:
  log:
    source: two noons
    passage: '17700101-1'
    entries:
    - ['1770-01-01T12:00', 48.0, -6.0, 270.0, 9.3, null]
    - ['1770-01-02T12:00', 46.5, -8.0, 290.0, 12.3, null]
"""


def test_a_passage_of_a_log_with_a_slack_thread_is_the_same_in_a_graph(tmp_path: Path) -> None:
    """She rides on every wave of a young sea, and each side counts the slacks."""
    scene = tmp_path / 'cork.yaml'
    scene.write_text(CORK_ON_A_PASSAGE, encoding='utf-8')
    sail(load_scene(scene), tmp_path / 'sail')
    plan = GraphPlan(str(scene), tmp_path / 'graph', speed=0.0, compose=True)
    assert run_graph(plan, load_scene(scene), lambda _: None).lost == 0
    assert_equal_bags(tmp_path / 'sail', tmp_path / 'graph')
    assert read_bag(tmp_path / 'graph').counts[f'/{SLACK}'] > 0


def test_a_real_passage_at_sea_is_the_same_in_a_graph(tmp_path: Path) -> None:
    """The Espérance out of Tenerife, past the turn of five minutes to her first course at sea."""
    at_sea = {'voyage.log.harbour_days': 0.0, 'log.interval': 5.0, 'log.motion': True}
    loaded = load_scene('esperance_to_the_cape', duration=360.0, **at_sea)
    flat_out = GraphPlan(
        'esperance_to_the_cape', tmp_path / 'graph', 360.0, 0.0, compose=True, changed=True
    )
    assert run_graph(flat_out, loaded, lambda _: None).lost == 0
    sail(loaded, tmp_path / 'sail')
    assert_equal_bags(tmp_path / 'sail', tmp_path / 'graph')
    bag = read_bag(tmp_path / 'graph')
    assert bag.counts[f'/{READING}'] == 73
    imu, felt = bag.samples(SHIP_IMU), bag.samples(SHIP_TEMPERATURE)
    assert isinstance(imu, ImuSamples)
    assert isinstance(felt, TemperatureSamples)
    # Auribeau's log has a wind at that noon, and the air's temperature
    assert np.std(imu.linear_acceleration, axis=0).min() > 1e-3
    assert 15.0 < felt.temperature.mean() < 30.0


def middleware_threads() -> set[str]:
    """Return the threads of this process' DDS participants, by task."""
    threads = Path('/proc/self/task').iterdir()
    return {task.name for task in threads if (task / 'comm').read_text().startswith('dds.ev')}


def test_who_runs_a_graph_is_no_part_of_it(tmp_path: Path) -> None:
    """What can hang a node in the middleware cannot hang the supervisor."""
    before = middleware_threads()
    plan = GraphPlan('measured', tmp_path / 'graph', 5.0, 0.0, compose=True)
    seen: set[str] = set()
    told: list[float] = []

    def look(share: float) -> None:
        told.append(share)
        seen.update(middleware_threads() - before)

    run_graph(plan, load_scene('measured', duration=5.0), look)
    assert told
    assert not seen


def test_a_bag_that_lacks_readings_is_not_called_whole(tmp_path: Path) -> None:
    # Nodes that sail five seconds of six publish too few, and lose none.
    plan = GraphPlan('measured', tmp_path / 'graph', 5.0, 0.0, compose=True)
    with pytest.raises(GraphError, match='has published 6 readings where the scene has 7'):
        run_graph(plan, load_scene('measured', duration=6.0), lambda _: None)
    assert read_bag(tmp_path / 'graph').counts['/clock/reading'] == 6


def test_a_signal_after_the_bag_is_closed_cuts_nothing_short(tmp_path: Path) -> None:
    loaded = load_scene('measured', duration=5.0)
    bag = tmp_path / 'graph'
    deadline_s = time.monotonic() + 300.0

    def signalled_when_closed(_: float) -> None:
        while not (bag / 'metadata.yaml').exists():
            assert time.monotonic() < deadline_s, 'the bag was not closed in time'
            time.sleep(0.05)
        signal.raise_signal(signal.SIGTERM)

    plan = GraphPlan('measured', bag, 5.0, 0.0, compose=True)
    outcome = run_graph(plan, loaded, signalled_when_closed)
    assert outcome.signal == 0
    assert outcome.counts['clock/reading']['written'] == loaded.log_count
