"""Warnings of values in the wrong unit, and refusals. Built-in scenes cause no warning."""

import copy
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import yaml
from typer.testing import CliRunner

import tauto_core as tauto
from tauto_core.checks.readiness import check_known, implausible, plausibility_warnings
from tauto_core.cli.app import app
from tauto_core.ensembles.fleets import Plan, as_draws
from tauto_core.scene import Scene, load_scene, scene_yaml, shipped_scenes
from tauto_core.scene.errors import SceneError


def changed(name: str, key: str, value: object) -> Scene:
    """Return a shipped scene with one number written otherwise."""
    content: Any = yaml.safe_load(scene_yaml(load_scene(name)))
    *path, last = key.replace('[', '.').replace(']', '').split('.')
    section = content
    for part in path:
        section = section[int(part) if part.isdigit() else part]
    section[int(last) if last.isdigit() else last] = value
    if last == 'speed':
        del section['arrives_at']
    return Scene.model_validate(content)


SLIPS = [
    ('measured', 'trochlea.release_angle', 57.3, 'more than 6.28 rad', 'in degrees', '1'),
    ('measured', 'trochlea.cam.base_radius', 5.0, 'more than 0.5 m', 'in millimetres', '0.005'),
    ('measured', 'trochlea.inertia', 4.0, 'more than 1 kg m2', 'in kg cm2', '0.0004'),
    ('measured', 'duration', 600.0 * 86_400.0, '600 days, more than 400 days', 'in mill', '5.18'),
    ('measured', 'duration', 1.0, 'less than 10 s', 'in days', '8.64e+04'),
    ('measured', 'gravity', 981.0, 'more than 30 m/s2', 'in cm/s2', '9.81'),
    ('measured', 'ship.height', 300.0, 'more than 100 m', 'in centimetres', '3'),
    ('measured', 'voyage.speed', 500.0, 'more than 25 m/s', 'Its unit is m/s', ''),
    ('second_cam_at_sea', 'trochlea.thread.distance', 80.0, 'more than 5 m', 'millim', '0.08'),
    ('second_cam_at_sea', 'ship.roll.damping_ratio', 8.0, 'more than 1', 'in per cent', '0.08'),
    ('cheek_before_euler', 'ship.components[0].amplitude', 1.4, 'more than 1.2 rad', 'deg', '0.0'),
    ('cheek_before_euler', 'escapement.angle', 10.0, 'more than 3.14 rad', 'in degrees', '0.174'),
]


@pytest.mark.parametrize('name', shipped_scenes())
def test_nothing_that_ships_is_doubted(name: str) -> None:
    scene = load_scene(name)
    check_known(scene)
    assert plausibility_warnings(scene) == []


@pytest.mark.parametrize(('name', 'key', 'value', 'limit', 'slip', 'meant'), SLIPS)
def test_a_slip_of_the_unit_names_key_value_limit_and_remedy(name, key, value, limit, slip, meant):
    [said] = implausible(changed(name, key, value))
    assert said.startswith(f'{key} = {value:g}: ')
    for words in (limit, slip, f': {meant}' if meant else ''):
        assert words in said, said


def test_times_of_a_voyage_in_days_are_doubted() -> None:
    way = {'departure': [50.8, -1.1], 'arrival': [17.9, -76.8], 'sails_at': 14, 'arrives_at': 95}
    [said] = plausibility_warnings(load_scene('ideal', voyage=copy.deepcopy(way)))
    assert said.startswith('voyage.arrives_at = 95: makes the ship sail at ')
    assert 'write arrives_at: 8.208e+06' in said


BEYOND = [
    ('measured', 'trochlea.release_angle', 57.3),
    ('measured', 'ship.height', 300.0),
    ('cheek_before_euler', 'ship.components[0].amplitude', 1.4),
    ('suspended_weight_at_sea', 'suspension.depth', 100.0),
]
"""Numbers of machine, gravity and ship that are larger than any known."""

SAFE = [
    ('measured', 'duration', 600.0 * 86_400.0),
    ('measured', 'voyage.speed', 500.0),
    ('second_cam_at_sea', 'ship.rate', 4000.0),
]
"""Numbers that are smaller than any known, or do not change what machine and ship do."""


@pytest.mark.parametrize(('name', 'key', 'value'), BEYOND)
def test_a_machine_or_ship_beyond_all_that_are_known_is_refused(name, key, value):
    with pytest.raises(SceneError) as refused:
        check_known(changed(name, key, value))
    assert (refused.value.key, refused.value.value) == (key, value)
    assert 'the most that any known machine or voyage has' in refused.value.problem
    assert refused.value.remedy.count('To sail it all the same, say anyway=True.') == 1


@pytest.mark.parametrize(('name', 'key', 'value'), SAFE)
def test_what_is_only_unusual_is_warned_of(name: str, key: str, value: float) -> None:
    scene = changed(name, key, value)
    check_known(scene)
    assert len(implausible(scene)) == 1


def test_all_that_is_beyond_is_named_at_once() -> None:
    beyond = {'trochlea.release_angle': 57.0, 'escapement.energy': 5.0}
    with pytest.raises(SceneError) as refused:
        check_known(load_scene('cheek_before_euler', **beyond))
    assert [each.key for each in refused.value.problems] == list(beyond)


def test_drag_in_which_no_wheel_swings_is_refused() -> None:
    """Critical is 2 I omega = 5.03e-3 N m s."""
    check_known(load_scene('ideal', **{'drag.viscous': 5.02e-3}))
    with pytest.raises(SceneError, match=r'drag\.viscous = 0\.00504: keeps the wheel from sw'):
        check_known(load_scene('ideal', **{'drag.viscous': 5.04e-3}))
    [said] = plausibility_warnings(load_scene('ideal', **{'drag.viscous': 5.04e-3}))
    assert said.endswith('Use a hundredth of that, 5.03e-05 N m s, or less.')


def heavy(folder: Path) -> Path:
    """Write a scene with a release beyond any known, which sails all the same."""
    file = folder / 'heavy.yaml'
    content = scene_yaml(load_scene('ideal', duration=60.0)).replace('1.0', '7.0')
    file.write_text(content, encoding='utf-8')
    return file


COMMANDS = [('sail',), ('plot', 'error', '--out', 'error.svg')]


@pytest.mark.parametrize('command', COMMANDS, ids=lambda command: command[0])
def test_commands_refuse_it_without_anyway(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    name, *options = command
    words = [name, str(heavy(tmp_path)), *options]
    refused = CliRunner().invoke(app, words)
    assert refused.exit_code == 2
    assert 'trochlea.release_angle = 7.0: 1.1 turns, more than 6.28 rad' in refused.stderr
    assert refused.stderr.count('turns') == 1
    assert CliRunner().invoke(app, [*words, '--anyway']).exit_code == 0


@pytest.mark.filterwarnings('ignore:all ships meet the same motion')
def test_python_refuses_it_unless_told_to_sail_anyway(tmp_path: Path) -> None:
    scene = tauto.load(heavy(tmp_path))
    calls: list[Callable[..., object]] = [
        partial(tauto.sail, scene),
        partial(tauto.plot, scene, 'error'),
        partial(tauto.compare, str(heavy(tmp_path))),
        partial(tauto.fleet, scene, ships=1, jobs=1),
    ]
    for call in calls:
        with pytest.raises(SceneError, match=r'say anyway=True\.$'):
            call()
        call(anyway=True)


def test_a_ship_of_a_fleet_is_refused_as_drawn() -> None:
    scene = load_scene('ideal')
    draws = as_draws(
        {'trochlea.release_angle': {'kind': 'uniform', 'low': 5.0, 'high': 9.0}}, 'vary', scene
    )
    plan = Plan(scene, 'ideal', 20, draws)
    with pytest.raises(SceneError, match=r'ship [0-9]+, as drawn: 1.* turns, more than'):
        plan.check()
    replace(plan, anyway=True).check()


def test_sail_and_check_say_it_before_all_else(tmp_path: Path) -> None:
    for command in (('sail', heavy(tmp_path), '--anyway'), ('scene', 'check', heavy(tmp_path))):
        run = CliRunner().invoke(app, [str(word) for word in command])
        assert run.exit_code == 0, run.stderr
        assert run.stderr.count('tauto: trochlea.release_angle = 7: 1.1 turns') == 1
