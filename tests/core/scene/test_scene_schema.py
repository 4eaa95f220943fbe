"""The JSON schema follows from the models, and accepts the same scenes."""

from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from tauto_core.scene import SceneError, parse_scene
from tauto_core.scene.loader import read_mapping
from tauto_core.scene.reference import FILE, FOLDERS, new_scene, schema, schema_text
from tauto_core.scene.sections import kind_of, kinds_in
from tauto_core.ship.motions import FOLDER as SHIPS

SHIPPED = FILE.parent / 'shipped'
REFERENCES = sorted((Path(__file__).parents[1] / 'scenes_ref').glob('*.yaml'))
VALID = Draft202012Validator(schema())
SEA = """\
duration: 10.0
trochlea:
  inertia: 4e-4
  cam: {kind: involute, base_radius: 0.005}
  thread: {kind: vertical}
  power: {kind: weight, mass: 0.3}
  release_angle: 1.0
ship:
  kind: sea
  sea: {spectrum: jonswap, significant_wave_height: 2.0, peak_period: 9.0}
  roll: {natural_period: 11.0, damping_ratio: 0.08, slope_coefficient: 0.7}
voyage:
  departure: [50, 0]
  waypoints: [[40, -10], {place: [30, -20], landfall: true}]
  arrival: [20, -50]
  sails_at: 0
  speed: 5
escapement: {energy: 1e-4}
"""
SPECTRUM = '{spectrum: file, path: "shipped:ndbc_44004/2000-01-01T02.csv", components: 5}'


def problems(text: str) -> list[Any]:
    return list(VALID.iter_errors(read_mapping(text, 'scene')))


def test_the_schema_that_ships_is_that_of_the_models() -> None:
    """`python -m tauto_core.scene.reference` prints it."""
    Draft202012Validator.check_schema(schema())
    assert FILE.read_text(encoding='utf-8') == schema_text()


@pytest.mark.parametrize(
    'file', [*sorted(SHIPPED.glob('*.yaml')), *REFERENCES], ids=lambda file: file.stem
)
def test_it_accepts_every_scene_that_ships(file: Path) -> None:
    assert not problems(file.read_text(encoding='utf-8'))


def test_it_accepts_every_new_scene() -> None:
    for key, folder in {'ship': SHIPS, **FOLDERS}.items():
        for model in kinds_in(folder):
            assert not problems(new_scene('new', {key: kind_of(model)})), model


def test_it_knows_places_files_and_the_usual_escapement() -> None:
    assert not problems(SEA)
    sea = '{spectrum: jonswap, significant_wave_height: 2.0, peak_period: 9.0}'
    assert sea in SEA
    assert not problems(SEA.replace(sea, SPECTRUM))
    assert problems(SEA.replace(sea, SPECTRUM.replace('path: ', 'paths: ')))


@pytest.mark.parametrize(
    ('old', 'new'),
    [
        ('duration: 10.0', 'duration: 0'),
        ('duration: 10.0', 'duration: "10"'),
        ('duration: 10.0', 'durations: 10.0'),
        ('kind: involute', 'kind: involut'),
        ('kind: involute, ', ''),
        ('kind: vertical', 'kind: hole'),
        ('base_radius: 0.005', 'base_radius: -0.005'),
        ('base_radius: 0.005', 'radius: 0.005'),
        ('spectrum: jonswap', 'spectrum: flat'),
        ('[50, 0]', '[95, 0]'),
        ('[50, 0]', '[50, 0, 0]'),
        ('[40, -10]', '[40]'),
        ('energy: 1e-4', 'energie: 1e-4'),
        ('duration: 10.0', 'name: "a\\tb"\nduration: 10.0'),
        ('trochlea:\n', 'log:\n'),
    ],
)
def test_it_refuses_what_the_models_refuse(old: str, new: str) -> None:
    """One key at a time. Relations between keys are tested by `tauto scene check`."""
    wrong = SEA.replace(old, new, 1)
    assert wrong != SEA
    with pytest.raises(SceneError):
        parse_scene(wrong, 'scene')
    assert problems(wrong)
