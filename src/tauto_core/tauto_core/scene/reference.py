"""The kinds that a scene can contain, and the page about them, docs/scenes.md."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from tauto_core.scene.explain import models_of, one_of
from tauto_core.scene.fields import Section
from tauto_core.scene.kinds import Kind, OneOf
from tauto_core.scene.models import Scene
from tauto_core.ship.sea_files import FILE_FORMS

_HEAD = """\
# Scenes: sections, kinds and keys

Generated from the models of the code (`python -m tauto_core.scene.reference`); a test keeps the
two equal. Numbers are in SI units and radians. A key without a default must be given. Where the
default is *left out*, the part is not simulated unless the key says otherwise. A section *from a
file* is read when the scene is loaded; the scene that runs, which is also written to the bag, has
its numbers instead.
"""


def all_kinds() -> tuple[type[Kind], ...]:
    """Return the models of all kinds, in the order of the sections."""
    return tuple(chain(*(kinds.models for kinds in _folders(Scene))))


def _folders(model: type[BaseModel]) -> Iterator[OneOf]:
    """Yield the folders of kinds for the sections below a model."""
    for field in model.model_fields.values():
        kinds = one_of(field)
        if kinds is not None:
            yield kinds
        # a kind may have a section with kinds of its own
        yield from chain(*map(_folders, models_of(field)))


def page() -> str:
    """Return docs/scenes.md."""
    parts = [_HEAD, _of_model('The scene', Scene)]
    for key, models in _sections(Scene, ''):
        for model in models:
            kind = model.model_fields.get('kind') or model.model_fields.get('spectrum')
            names = [] if kind is None or len(models) == 1 else list(get_args(kind.annotation))
            title = f'`{key}`' + ''.join(f', {" or ".join(names)}' for _ in names[:1])
            parts.append(_of_model(title, model))
        form = FILE_FORMS.get(key.removeprefix('ship.'))
        if form is not None:
            parts.append(_of_model(f'`{key}`, from a file', form))
            parts += [_of_model(f'`{part}`', each) for part, (each,) in _sections(form, key)]
    return '\n'.join(parts)


def _sections(model: type[BaseModel], path: str) -> Iterator[tuple[str, list[type[BaseModel]]]]:
    """Yield the key path and the models of each section below a model, depth first."""
    for name, field in model.model_fields.items():
        models = models_of(field)
        if models:
            key = f'{path}.{name}' if path else name
            yield key, models
            for each in models:
                yield from _sections(each, key)


def _of_model(title: str, model: type[BaseModel]) -> str:
    rows = [
        f'| `{name}` | {_default(field)} | {_meaning(name, field)} |'
        for name, field in model.model_fields.items()
    ]
    said = ' '.join((model.__doc__ or '').split())
    table = ['| key | default | meaning |', '|---|---|---|', *rows]
    return '\n'.join([f'## {title}', '', said, '', *table, ''])


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return ''
    value = field.default
    if value is None:
        return 'left out'
    if isinstance(value, Section):
        return f'`{value.model_dump(mode="json", exclude_none=True)}`'
    return f'`{value!r}`'


def _meaning(name: str, field: FieldInfo) -> str:
    kinds = one_of(field)
    if kinds is not None:
        names = ', '.join(str(each.model_fields['kind'].default) for each in kinds.models)
        return f'{field.description}: {names}'
    if name == 'kind' and not field.description:
        return f'{field.default}'
    return (field.description or '').replace('|', '\\|')


if __name__ == '__main__':
    print(page(), end='')
