"""Warnings of values in the wrong unit; existing machines and shipped scenes give none."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.readiness import oddities
from tauto_core.scene import Scene, load_scene, scene_yaml, shipped_scenes
from tauto_core.scene.plausible import implausible


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
    ('measured', 'trochlea.cam.base_radius', 0.5001, 'more than 0.5 m', 'in centimetres', '0.00'),
    ('measured', 'trochlea.power.mass', 322.0, 'more than 50 kg', 'in grams', '0.322'),
    ('measured', 'trochlea.inertia', 4.0, 'more than 1 kg m2', 'in kg cm2', '0.0004'),
    ('measured', 'trochlea.inertia', 4000.0, 'more than 1 kg m2', 'in g cm2', '0.0004'),
    ('measured', 'duration', 600.0 * 86_400.0, '600 days, more than 400 days', 'in mill', '5.18'),
    ('measured', 'duration', 1.0, 'less than 10 s', 'in days', '8.64e+04'),
    ('measured', 'gravity', 981.0, 'more than 30 m/s2', 'in cm/s2', '9.81'),
    ('measured', 'gravity', 32.2, 'more than 30 m/s2', 'in feet/s2', '9.815'),
    ('measured', 'clock.nominal_period', 1005.0, 'more than 20 s', 'in milliseconds', '1.005'),
    ('measured', 'ship.height', 300.0, 'more than 100 m', 'in centimetres', '3'),
    ('measured', 'voyage.speed', 500.0, 'more than 25 m/s', 'Its unit is m/s', ''),
    ('second_cam_at_sea', 'trochlea.thread.distance', 80.0, 'more than 5 m', 'millim', '0.08'),
    ('second_cam_at_sea', 'trochlea.power.force', 1579.0, 'more than 500 N', 'in milli', '1.579'),
    ('second_cam_at_sea', 'ship.roll.damping_ratio', 8.0, 'more than 1', 'in per cent', '0.08'),
    ('second_cam_at_sea', 'ship.sea.peak_period', 9000.0, 'more than 40 s', 'in millis', '9'),
    ('cheek_before_euler', 'ship.components[0].amplitude', 1.4, 'more than 1.2 rad', 'deg', '0.0'),
    ('cheek_before_euler', 'escapement.energy', 19.5, 'more than 0.1 J', 'in millijou', '0.0195'),
    ('cheek_before_euler', 'escapement.angle', 10.0, 'more than 3.14 rad', 'in degrees', '0.174'),
    ('suspended_weight_at_sea', 'suspension.depth', 100.0, 'more than 5 m', 'in millim', '0.1'),
    ('globe_in_oil', 'regulator.body_density', 7.8, 'less than 100 kg/m3', 'in g/cm3', '7800'),
]


@pytest.mark.parametrize('name', shipped_scenes())
def test_nothing_that_ships_is_doubted(name: str) -> None:
    assert oddities(load_scene(name)) == []


@pytest.mark.parametrize(('name', 'key', 'value', 'limit', 'slip', 'meant'), SLIPS)
def test_a_slip_of_the_unit_names_key_value_limit_and_remedy(
    name: str, key: str, value: float, limit: str, slip: str, meant: str
) -> None:
    [said] = implausible(changed(name, key, value))
    assert said.startswith(f'{key} = {value:g}: ')
    for words in (limit, slip, f': {meant}' if meant else ''):
        assert words in said, said


def test_times_of_a_voyage_in_days_are_doubted() -> None:
    way = {'departure': [50.8, -1.1], 'arrival': [17.9, -76.8], 'sails_at': 14, 'arrives_at': 95}
    [said] = oddities(load_scene('ideal', voyage=copy.deepcopy(way)))
    assert said.startswith('voyage.arrives_at = 95: makes the ship sail at ')
    assert 'write arrives_at: 8.208e+06' in said


def test_sail_and_check_say_it_before_all_else(tmp_path: Path) -> None:
    file = tmp_path / 'heavy.yaml'
    content = scene_yaml(load_scene('ideal', duration=60.0)).replace('1.0', '7.0')
    file.write_text(content, encoding='utf-8')
    for command in (('sail', file), ('scene', 'check', file)):
        run = CliRunner().invoke(app, [str(word) for word in command])
        assert run.exit_code == 0, run.stderr
        assert run.stderr.count('tauto: trochlea.release_angle = 7: 1.1 turns') == 1
