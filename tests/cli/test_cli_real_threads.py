"""Sully's lever and the swinging thread on the command line."""

import json

import pytest
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.machines import compile_machine
from tauto_core.scene import load_scene

SCENES = ('sully_lever_at_sea', 'hanging_thread_at_sea')


def answer(*words):
    result = CliRunner().invoke(app, [*words, '--json'])
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


@pytest.mark.parametrize('name', SCENES)
def test_isochronism_shows_what_the_dial_is_regulated_for(name):
    rows = answer('isochronism', name, '--amplitudes', '0.5,1')['rows']
    # a wheel that swings less is faster; at the release the dial is right
    assert rows[0]['rate_s_per_day'] > 100.0
    assert rows[1]['rate_s_per_day'] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.usefixtures('short_trials')
@pytest.mark.parametrize(
    ('name', 'why'),
    [(SCENES[0], 'the apparent gravity moves the lever'), (SCENES[1], 'the thread swings')],
)
def test_scene_check_says_what_runs(name, why):
    facts = answer('scene', 'check', name)
    assert facts['propagator'] == 'collocation'
    assert why in facts['reason']
    assert facts['cam_range_rad'] == compile_machine(load_scene(name)).range_rad
    assert facts['expected']['steps_a_swing'] > 5.0


@pytest.mark.parametrize('name', SCENES)
def test_a_minute_at_sea(name):
    said = answer('sail', name, '--duration', '60')
    assert said['propagator'] == 'collocation'
    assert said['trochlea']['beats'] == pytest.approx(118, abs=4)
    assert abs(said['clock']['error_s']) < 1.5
    scene = load_scene(name)
    assert said['trochlea']['period_s'] == compile_machine(scene).small_period
