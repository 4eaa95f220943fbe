"""Errors of a scene: pydantic's errors in words of scenes, limits of numbers."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from tauto_core.scene.errors import ABSENT, Problem
from tauto_core.scene.sections import KindIn
from tauto_core.scene.units import NUMBER, declared, misfit

# -----------------------------------------------------------------------------
# Pydantic's errors as problems in words of scenes.

NO_KEY = 'is not a key of'
"""Beginning of the message about an unknown key."""

_LONGEST_KEY = 80
_MOST_TOLD = 100
# keys that distinguish the kinds of a section
TAGS = ('kind', 'spectrum')
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

# Keys of earlier versions, with the reason and the remedy.
_TAKEN_AWAY = {
    'suspension.mass': (
        'is no longer a key: the wheel does not turn the case',
        'Leave it out. `tauto scene check` gives the effect of a case of 10 kg.',
    ),
    'ship.sea.time': (
        'is no longer a key: files of buoys are not read',
        'Leave it out. wavespectra makes the CSV of a spectrum (docs/seas.md).',
    ),
}
_OF_TEXT = ('string_too_short', 'string_too_long', 'string_pattern_mismatch')


def explain(error: ValidationError, root: type[BaseModel]) -> tuple[Problem, ...]:
    """Return the first hundred of pydantic's errors about `root`, with keys, values, remedies."""
    problems: list[Problem] = []
    details = error.errors(include_url=False)
    for detail in details[:_MOST_TOLD]:
        place = detail['loc']
        if detail['type'] == 'too_short' and any(
            item['loc'][: len(place)] == place for item in details if item is not detail
        ):
            continue  # its items were refused and are not counted
        if detail['type'] == 'combination':
            problems += detail['ctx']['problems']
        else:
            problems.append(_problem(detail, root))
    return tuple(problems)


def _problem(detail: ErrorDetails, root: type[BaseModel]) -> Problem:
    key, field, owner = _locate(detail['loc'], root)
    value, kind = detail['input'], detail['type']
    context = detail.get('ctx', {})
    if kind == 'missing':
        return Problem(key, ABSENT, 'is missing', _give(key, field))
    if kind == 'extra_forbidden':
        if key in _TAKEN_AWAY:
            return Problem(key, value, *_TAKEN_AWAY[key])
        keys, tag, kinds = list(owner.model_fields), _tag(owner), ' or '.join(_kinds(owner))
        matches = difflib.get_close_matches(str(detail['loc'][-1]), keys, 1)
        remedy = f'Did you mean `{matches[0]}`? ' if matches else ''
        what = f'{NO_KEY} {tag} {kinds}' if kinds else f'{NO_KEY} this section'
        return Problem(key, value, what, f'{remedy}Keys here: {", ".join(keys)}.')
    if kind in ('union_tag_not_found', 'union_tag_invalid'):
        return _wrong_kind(key, value, field)
    if kind in _ORDER:
        words, limit = _ORDER[kind]
        problem = f'must be {words} {context[limit]!r}'
    elif (
        kind == 'float_type'
        and isinstance(value, str)
        and (why := misfit(value, declared(field and field.description) or ''))
    ):
        return Problem(key, value, why[0], f'{_give(key, field)} {why[1]}'.strip())
    elif kind in _KINDS:
        suffix = '' if kind in _OF_TEXT else _found(value)
        problem = f'must be {_KINDS[kind]}{suffix}'
    elif kind == 'literal_error':
        words = context['expected']
        matches = difflib.get_close_matches(str(value), re.findall(r"'(\w+)'", words), 1)
        problem = f'must be {words}'
        if matches:
            problem += f'; did you mean {matches[0]}?'
        elif not (isinstance(value, str) and "'" in words):
            problem += _found(value)
    elif kind in ('too_long', 'too_short'):
        low, high = context.get('min_length'), context.get('max_length')
        limit = f'at most {high}' if low is None else f'at least {low}'
        problem = f'has {context["actual_length"]} items, the limit is {limit}'
    else:
        problem = detail['msg'][:1].lower() + detail['msg'][1:]
    return Problem(key, value, problem, _give(key, field))


_TYPES = {
    bool: 'a truth value',
    str: 'text',
    type(None): 'empty',
    dict: 'a mapping',
    list: 'a list',
}


def _found(value: object) -> str:
    text, is_number = _TYPES.get(type(value)), re.fullmatch(NUMBER, str(value).strip())
    quoted = ' (leave out quotes around numbers)' if text == 'text' and is_number else ''
    return f', not {text}{quoted}' if text else ''


def _give(key: str, field: FieldInfo | None) -> str:
    name = key.rpartition('.')[2].partition('[')[0]
    if field is None or field.description is None:
        return f'Correct `{name}`.'
    return f'Write `{name}: …`, {field.description}.'


def _wrong_kind(key: str, value: object, field: FieldInfo | None) -> Problem:
    models = models_of(field)
    tag, kinds = _tag(models[0]), [kind for model in models for kind in _kinds(model)]
    kinds += [] if field is None else [str(item) for item in field.examples or ()]
    choice = value.get(tag) if isinstance(value, dict) else None
    matches = difflib.get_close_matches(str(choice), kinds, 1)
    guess = f'Did you mean {matches[0]}? ' if matches else ''
    remedy = f'{guess}Use one of {", ".join(kinds)}.'
    if not isinstance(value, dict) or tag not in value:
        return Problem(f'{key}.{tag}', ABSENT, 'is missing', remedy)
    return Problem(f'{key}.{tag}', value[tag], f'unknown {tag}', remedy)


def models_of(field: FieldInfo | None) -> list[type[BaseModel]]:
    """Return the models among the alternatives of a field or its items."""
    if field is None:
        return []
    if kinds := one_of(field):
        return list(kinds.models)
    parts = _parts(field.annotation)
    return [part for part in parts if isinstance(part, type) and issubclass(part, BaseModel)]


def one_of(field: FieldInfo) -> KindIn | None:
    """Return the `KindIn` of a field, if any."""
    parts = (*field.metadata, *_parts(field.annotation))
    return next((part for part in parts if isinstance(part, KindIn)), None)


def _parts(annotation: Any) -> Iterator[Any]:
    """Yield an annotation and all that it contains."""
    yield annotation
    for part in get_args(annotation):
        yield from _parts(part)


def _tag(model: type[BaseModel]) -> str:
    """Return the key that distinguishes a model from its siblings, or ''."""
    keys = model.model_fields
    # an optional spectrum does not distinguish models
    return next(
        (tag for tag in TAGS if tag in keys and (tag == 'kind' or keys[tag].is_required())), ''
    )


def _kinds(model: type[BaseModel]) -> list[str]:
    """Return the values of that key for this model."""
    tag = _tag(model)
    return [str(kind) for kind in get_args(model.model_fields[tag].annotation)] if tag else []


def _locate(
    location: tuple[int | str, ...], root: type[BaseModel]
) -> tuple[str, FieldInfo | None, type[BaseModel]]:
    """Return key path, field and owning model of an error's location, without tags of unions."""
    owner, field, key = root, None, ''
    parts = iter(location)
    for part in parts:
        if isinstance(part, int):
            key += f'[{part}]'
            continue
        if part.startswith('function-'):  # a validator, not a key
            continue
        models = models_of(field)
        # in a union the location includes the kind
        kinds = None if field is None else one_of(field)
        if field is not None and (
            field.discriminator is not None or (kinds is not None and len(kinds.models) > 1)
        ):
            owner = next(model for model in models if part in _kinds(model))
            field = None
            continue
        if models:
            owner = models[0]
        text = part[:_LONGEST_KEY]
        key = f'{key}.{text}' if key else text
        field = owner.model_fields.get(part)
    return key, field, owner


# -----------------------------------------------------------------------------
# Limits of numbers in double precision.

# squares of ratios of three such numbers neither overflow nor underflow
LEAST_SIZE, LARGEST_SIZE = 1e-30, 1e30
# a fusee has about ten turns; a release in degrees exceeds this
LARGEST_TURNS = 10

SECTIONS = ('gravity', 'trochlea', 'regulator', 'drag', 'escapement', 'ship', 'suspension')
# terms that are only added to larger ones may be arbitrarily small
_MAY_VANISH = frozenset(
    (
        'trochlea.release_angle',
        'trochlea.thread.inertia',
        'trochlea.thread.inclination',
        'trochlea.power.stiffness',
        'regulator.release_arc',
        'regulator.fluid_density',
        'regulator.added_mass',
        'regulator.viscous',
        'drag.viscous',
        'drag.quadratic',
        'drag.coulomb',
        'escapement.angle',
        'escapement.energy',
        'escapement.rest.friction',
        'escapement.rest.recoil',
    )
)
# other numbers of a ship may be small, but not these divisors and scales
_OF_SHIPS = frozenset(
    ('rate', 'period', 'frequency', 'natural_period', 'peak_period', 'significant_wave_height')
)


def out_of_proportion(content: Mapping[str, object]) -> Iterator[Problem]:
    """Yield a problem for each nonzero number in the `SECTIONS` of a scene out of these limits."""
    for key, value in _numbers('', content):
        size, remedy = abs(value), 'Check its unit.'
        name = key.rpartition('.')[2].partition('[')[0]
        may_vanish = name not in _OF_SHIPS if key.startswith('ship.') else key in _MAY_VANISH
        if key == 'trochlea.release_angle' and size > LARGEST_TURNS * math.tau:
            end = '.'
            if size <= 360.0:
                radians = f'{math.radians(value):.4g}'
                end = f': if {value:g} is in degrees, write release_angle: {radians}.'
            limit = f'at most {LARGEST_TURNS * math.tau:.4g} rad in size, {LARGEST_TURNS} turns '
            limit += 'of the thread'
            remedy = f'Angles are in radians, 90° = 1.571{end}'
        elif size > LARGEST_SIZE:
            limit = f'at most {LARGEST_SIZE:g} in size, or results overflow'
        elif 0.0 < size < LEAST_SIZE and not may_vanish:
            limit = f'at least {LEAST_SIZE:g} in size, or results vanish'
        else:
            continue
        yield Problem(key, value, f'must be {limit}', remedy)


def _numbers(path: str, content: object) -> Iterator[tuple[str, float]]:
    if isinstance(content, Mapping):
        for name, value in content.items():
            yield from _numbers(f'{path}.{name}' if path else name, value)
    elif isinstance(content, tuple):
        for index, value in enumerate(content):
            yield from _numbers(f'{path}[{index}]', value)
    elif isinstance(content, float):
        yield path, content
