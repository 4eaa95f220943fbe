"""`tauto replay`: stability, its figure, and reports of bad observations."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import invoke, run

SCENE = """\
name: a noisy clock
duration: 2400.0
trochlea:
  inertia: 4.0e-4
  cam: {kind: involute, base_radius: 0.010}
  thread: {kind: vertical}
  power: {kind: force, force: 2.0}
  release_angle: 1.0
clock: {white_fm: 2.0}
drift: {observation_interval: 600.0, observation_sigma: 0.01, prior_rate_sigma: 100.0}
log: {interval: 10.0}
"""


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp('replay')
    (folder / 'noisy.yaml').write_text(SCENE, encoding='utf-8')
    sailed = invoke('sail', folder / 'noisy.yaml', '--out', folder / 'bag')
    assert sailed.exit_code == 0, sailed.stderr
    assert sailed.stderr == ''
    return folder / 'bag'


def test_the_stability(bag: Path) -> None:
    stability = json.loads(run('replay', bag, '--stability', '--json'))['stability']
    assert (stability['samples'], stability['interval_s']) == (241, 10.0)
    rows = stability['rows']
    assert [row['tau_s'] for row in rows] == [10.0, 20.0, 40.0, 80.0, 160.0, 320.0]
    shown = invoke('replay', bag, '--stability').stdout
    assert 'white FM' in shown
    assert 'τ, s' in shown
    assert '…' not in shown


def test_observations_that_disagree_are_said_by_sail_and_replay(tmp_path: Path) -> None:
    scene = tmp_path / 'off.yaml'
    # the dial gains a thousandth, 86 s/day, instead of the assumed 0.1 s/day
    off = SCENE.replace('white_fm: 2.0', 'nominal_period: 0.888').replace('100.0}', '0.1}')
    scene.write_text(off, encoding='utf-8')
    sailed = invoke('sail', scene, '--out', tmp_path / 'bag')
    replayed = invoke('replay', tmp_path / 'bag')
    for ended in (sailed, replayed):
        assert ended.exit_code == 0
        said = 'drift: 1 observation beyond drift.gate = 5 sigmas had to be believed'
        assert said in ended.stderr
        assert 'drift.prior_rate_sigma = 0.1 s/day' in ended.stderr


def test_a_bag_cut_before_its_readings_says_that_it_was_cut(bag: Path, tmp_path: Path) -> None:
    (whole,) = bag.glob('*.mcap')
    (tmp_path / 'cut.mcap').write_bytes(whole.read_bytes()[:3000])
    cut = invoke('replay', tmp_path / 'cut.mcap')
    assert cut.exit_code == 1
    for words in ('there is no topic clock/reading', 'the chunk at byte 797 is damaged (2150 of'):
        assert words in cut.stderr
    assert 'See tauto bag check' in cut.stderr
