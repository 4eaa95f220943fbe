"""The kinds of a scene's sections are found in their folders. The reference has all of them."""

import subprocess
import sys

import pytest
from pydantic import BaseModel, TypeAdapter

from tauto_core.scene import Scene, SceneError, parse_scene, scene_yaml
from tauto_core.scene.reference import all_kinds, models_of, scenes_page, schema
from tauto_core.scene.sections import Kind, kind_of

TROCHLEA = """
trochlea:
  inertia: 4e-4
  cam: {kind: involute, base_radius: 0.01}
  thread: {kind: vertical}
  power: {kind: force, force: 2.0}
  release_angle: 1.0
"""


def test_reference_page_has_every_key_of_the_schema() -> None:
    found = scenes_page()
    assert 'Undefined' not in found
    for name, definition in schema()['$defs'].items():
        keys = [f'| `{key}` |' for key in definition.get('properties', ())]
        assert all(key in found for key in keys), name


def test_every_kind_and_key_says_what_it_is() -> None:
    for model in all_kinds():
        assert model.__doc__ != model.__mro__[1].__doc__, model
        assert all(
            field.description for name, field in model.model_fields.items() if name != 'kind'
        )


def test_every_default_lies_within_its_own_limits() -> None:
    """A key that is left out is as good as one with the default that the reference shows."""
    models: set[type[BaseModel]] = {Scene, *all_kinds()}
    while more := {m for each in models for f in each.model_fields.values() for m in models_of(f)}:
        if more <= models:
            break
        models |= more
    defaults = 0
    for model in models:
        for field in model.model_fields.values():
            default = field.get_default(call_default_factory=True, validated_data={})
            if not (field.is_required() or default is None):
                assert TypeAdapter(field.rebuild_annotation()).validate_python(default) == default
                defaults += 1
    assert defaults > 100


def test_kinds_of_a_section_differ_in_their_key_and_their_rank() -> None:
    sections: dict[type, list[type[Kind]]] = {}
    for model in all_kinds():
        section = next(base for base in model.__mro__ if Kind in base.__bases__)
        sections.setdefault(section, []).append(model)
    assert len(sections) == 9
    for models in sections.values():
        assert len({kind_of(model) for model in models}) == len(models)
        assert len({model.rank for model in models}) == len(models)


def test_what_a_scene_may_hold_loads_neither_scipy_nor_numba() -> None:
    """All kinds are known to every scene. Special needs are imported when used."""
    program = (
        'import sys\n'
        'from tauto_core.scene import load_scene\n'
        "load_scene('portsmouth_jamaica')\n"
        "print(sorted({'scipy', 'numba', 'mcap', 'rosbags', 'matplotlib'} & set(sys.modules)))"
    )
    said = subprocess.run(
        [sys.executable, '-c', program], check=False, capture_output=True, text=True
    )
    assert said.stdout.strip() == '[]', said.stderr


def test_an_escapement_without_kind_gives_plain_impulses() -> None:
    scene = parse_scene(f'duration: 10\n{TROCHLEA}escapement: {{energy: 1e-6}}', 's')
    assert scene.escapement is not None
    assert scene.escapement.kind == 'impulse'
    assert parse_scene(scene_yaml(scene), 'bag') == scene
    with pytest.raises(SceneError, match=r'escapement\.energy: is missing'):
        parse_scene(f'duration: 10\n{TROCHLEA}escapement: {{angle: 0.1}}', 's')
