"""Translates pydantic's errors into problems in the words of the scene."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from itertools import chain
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from tauto_core.scene.errors import ABSENT, Problem
from tauto_core.scene.kinds import OneOf

NO_KEY = 'is not a key of'
"""How what is said of an unknown key begins."""

_LONGEST_KEY = 80
# Keys that distinguish the kinds of a section.
_TAGS = ('kind', 'spectrum')
_ORDER = {
    'greater_than': ('greater than', 'gt'),
    'greater_than_equal': ('at least', 'ge'),
    'less_than': ('less than', 'lt'),
    'less_than_equal': ('at most', 'le'),
}
_KINDS = {
    'float_type': 'a number',
    'int_type': 'a whole number',
    'int_from_float': 'a whole number',
    'bool_type': 'true or false, without quotes',
    'string_type': 'text',
    'string_unicode': 'text of Unicode characters',
    'model_type': 'a mapping of keys to values',
    'model_attributes_type': 'a mapping of keys to values',
    'dict_type': 'a mapping of keys to values',
    'tuple_type': 'a list',
    'finite_number': 'a finite number',
    'string_too_short': 'at least one character',
    'string_too_long': 'at most 1000 characters',
    'string_pattern_mismatch': 'one line without control characters',
}

_OF_TEXT = ('string_too_short', 'string_too_long', 'string_pattern_mismatch')


def explain(error: ValidationError, root: type[BaseModel]) -> tuple[Problem, ...]:
    """Return what pydantic refused, with key paths, values and remedies.

    Args:
        error: raised by `root`.
        root: the model of the whole.
    """
    found: list[Problem] = []
    for detail in error.errors(include_url=False):
        if detail['type'] == 'combination':
            found += detail['ctx']['problems']
        else:
            found.append(_problem(detail, root))
    return tuple(found)


def _problem(detail: ErrorDetails, root: type[BaseModel]) -> Problem:
    key, field, owner = _locate(detail['loc'], root)
    value, kind = detail['input'], detail['type']
    context = detail.get('ctx', {})
    if kind == 'missing':
        return Problem(key, ABSENT, 'is missing', _give(key, field))
    if kind == 'extra_forbidden':
        return Problem(key, value, *_unknown_key(str(detail['loc'][-1]), owner, root))
    if kind in ('union_tag_not_found', 'union_tag_invalid'):
        return _wrong_kind(key, value, field)
    if kind in _ORDER:
        words, limit = _ORDER[kind]
        problem = f'must be {words} {context[limit]!r}'
    elif kind in _KINDS:
        found = '' if kind in _OF_TEXT else _found(value)
        problem = f'must be {_KINDS[kind]}{found}'
    elif kind == 'literal_error':
        problem = f'must be {context["expected"]}{_found(value)}'
    elif kind in ('too_long', 'too_short'):
        problem = f'has {context["actual_length"]} items, the limit is {_limit(context)}'
    else:
        problem = detail['msg'][:1].lower() + detail['msg'][1:]
    return Problem(key, value, problem, _give(key, field))


def _limit(context: dict[str, Any]) -> str:
    if 'min_length' in context:
        return f'at least {context["min_length"]}'
    return f'at most {context["max_length"]}'


def _found(value: object) -> str:
    if isinstance(value, bool):
        return ', not a truth value'
    if isinstance(value, str):
        if _is_number(value):
            return ', not text (leave out quotes around numbers)'
        if _is_number(value.replace(',', '.', 1)):
            return f', and has a decimal comma: write {value.replace(",", ".", 1)}'
        return ', not text'
    if value is None:
        return ', not empty'
    names: tuple[tuple[type, str], ...] = ((dict, 'mapping'), (list, 'list'))
    return next((f', not a {name}' for of, name in names if isinstance(value, of)), '')


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _give(key: str, field: FieldInfo | None) -> str:
    name = key.rpartition('.')[2].partition('[')[0]
    if field is None or field.description is None:
        return f'Correct `{name}`.'
    return f'Write `{name}: …`, {field.description}.'


def _unknown_key(name: str, owner: type[BaseModel], root: type[BaseModel]) -> tuple[str, str]:
    keys = list(owner.model_fields)
    near = difflib.get_close_matches(name, keys, 1)
    remedy = f'Did you mean `{near[0]}`? ' if near else ''
    elsewhere = [_kinds(other) for other in _siblings(owner, root) if name in other.model_fields]
    tag, kinds = _tag(owner), ' or '.join(_kinds(owner))
    if elsewhere:
        remedy += f'`{name}` goes with {tag} {" or ".join(chain(*elsewhere))}. '
    what = f'{NO_KEY} {tag} {kinds}' if kinds else f'{NO_KEY} this section'
    return what, f'{remedy}Keys here: {", ".join(keys)}.'


def _wrong_kind(key: str, value: object, field: FieldInfo | None) -> Problem:
    models = models_of(field)
    tag, kinds = _tag(models[0]), [kind for model in models for kind in _kinds(model)]
    kinds += [] if field is None else [str(each) for each in field.examples or ()]
    given = value.get(tag) if isinstance(value, dict) else None
    near = difflib.get_close_matches(str(given), kinds, 1)
    guess = f'Did you mean {near[0]}? ' if near else ''
    remedy = f'{guess}Use one of {", ".join(kinds)}.'
    if not isinstance(value, dict) or tag not in value:
        return Problem(f'{key}.{tag}', ABSENT, 'is missing', remedy)
    return Problem(f'{key}.{tag}', value[tag], f'unknown {tag}', remedy)


def models_of(field: FieldInfo | None) -> list[type[BaseModel]]:
    """Return the models among the alternatives of a field, those of list items included."""

    def walk(annotation: Any) -> Iterator[type[BaseModel]]:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            yield annotation
        for part in get_args(annotation):
            yield from walk(part)

    if field is None:
        return []
    kinds = one_of(field)
    return list(walk(field.annotation)) if kinds is None else list(kinds.models)


def _is_union(field: FieldInfo) -> bool:
    """Return whether the location of a pydantic error includes the kind."""
    kinds = one_of(field)
    return field.discriminator is not None or (kinds is not None and len(kinds.models) > 1)


def one_of(field: FieldInfo) -> OneOf | None:
    """Return the marker of a field that takes the kinds of a folder."""

    def walk(annotation: Any) -> Iterator[OneOf]:
        if isinstance(annotation, OneOf):
            yield annotation
        for part in (*getattr(annotation, '__metadata__', ()), *get_args(annotation)):
            yield from walk(part)

    said = (each for each in field.metadata if isinstance(each, OneOf))
    return next(chain(said, walk(field.annotation)), None)


def _tag(model: type[BaseModel]) -> str:
    """Return the key that distinguishes a model from its siblings; empty if there is none."""
    keys = model.model_fields
    # a spectrum that may be left out distinguishes nothing
    return next(
        (tag for tag in _TAGS if tag in keys and (tag == 'kind' or keys[tag].is_required())), ''
    )


def _kinds(model: type[BaseModel]) -> list[str]:
    """Return the values of that key that name this model."""
    tag = _tag(model)
    return [str(kind) for kind in get_args(model.model_fields[tag].annotation)] if tag else []


def _siblings(owner: type[BaseModel], root: type[BaseModel]) -> list[type[BaseModel]]:
    """Return the other kinds of the same section."""
    for field in root.model_fields.values():
        models = models_of(field)
        if owner in models:
            return [model for model in models if model is not owner]
        for model in models:
            found = _siblings(owner, model)
            if found:
                return found
    return []


def _locate(
    location: tuple[int | str, ...], root: type[BaseModel]
) -> tuple[str, FieldInfo | None, type[BaseModel]]:
    """Return the key path, the field and the model that owns it, without the tags of unions."""
    owner, field, key = root, None, ''
    parts = iter(location)
    for part in parts:
        if isinstance(part, int):
            key += f'[{part}]'
            continue
        models = models_of(field)
        if field is not None and _is_union(field):
            owner = next(model for model in models if part in _kinds(model))
            field = None
            continue
        if models:
            owner = models[0]
        shown = part[:_LONGEST_KEY]
        key = f'{key}.{shown}' if key else shown
        field = owner.model_fields.get(part)
    return key, field, owner
