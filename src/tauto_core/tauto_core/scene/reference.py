"""The keys of a scene as documentation page, as JSON schema, and as a scene to start from."""

from __future__ import annotations

import json
import os
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Set
from difflib import get_close_matches
from functools import cache
from itertools import chain, combinations, product
from pathlib import Path
from typing import Any, cast, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from tauto_core.curves.cam import CAMS
from tauto_core.files import write_whole
from tauto_core.machines.design import WheelDesign
from tauto_core.machines.drags import Drag
from tauto_core.machines.parts import ESCAPEMENTS, POWERS
from tauto_core.machines.trochlea import THREADS
from tauto_core.scene.errors import Argument, UsageError
from tauto_core.scene.loader import Scene, parse_scene, write_mapping
from tauto_core.scene.refuse import TAGS, models_of, one_of
from tauto_core.scene.sections import Kind, KindIn, LogFile, Section, kind_of, kinds_in
from tauto_core.scene.units import NUMBER, declared, units_table
from tauto_core.ship.airs import AirRecordFile
from tauto_core.ship.hindcast import AirHindcastFile, HindcastFile
from tauto_core.ship.motions import FOLDER as SHIPS
from tauto_core.ship.sea_files import FILE_FORMS, RaoFile, RecordFile
from tauto_core.ship.sections import Rao

_HEAD = """\
# Scenes: sections, kinds and keys

`make docs` makes this page from the models of the code. Numbers are in SI units and radians,
unless a key says otherwise; [units in words](#units-in-words) are understood. A key without a
default is required. A part *left out* by default is not simulated, unless the key says otherwise.
A section *from a file* is read when the scene is loaded. The loaded scene, which a bag contains,
has the numbers.
"""

_UNITS = """\
## Units in words

If the meaning of a key has a unit in brackets, its value may be a text of a number and a unit:
`base_radius: 5 mm`, `duration: 10 min`, `--set 'trochlea.release_angle=60 deg'`,
`tauto.load('measured', duration='1 h')`. The same holds for options of the command line
(`--duration 10min`, `--from '36 h'`), arguments in Python (`tauto.design(pull='300 g', …)`) and
the distributions of `tauto fleet --vary`. The loaded scene, bags and `--json` have the number in
the unit of the key.

{table}

Units may be multiplied and divided: `4 kg cm2`, `-10.7 s/day/K`, `2 mm/deg`. The prefixes are n, µ
or u, m and k, and `cm`. Refused are `nm`, which sailors use for nautical miles, units of another
kind (`base_radius: 5 min` is a time), units for keys without one, and numbers without a unit in
quotes.

The foot is 0.3048 m and the pound 0.45359237 kg, by the agreement of 1959, the nautical mile
1852 m (NIST SP 811). The foot of Paris is 324.84 mm (1766), its pound 489.5 g, the Rhenish foot
313.85 mm (1816), the scruple its thousandth.
"""

# models of sections that are read from a file
_FROM_FILES: dict[str, type[Section]] = {**FILE_FORMS, 'air': AirRecordFile, 'voyage.log': LogFile}

# models of sections that are read from a hindcast along the voyage
_FROM_HINDCASTS: dict[str, type[Section]] = {'weather': HindcastFile, 'air': AirHindcastFile}


def all_kinds() -> tuple[type[Kind], ...]:
    """Return the models of all kinds, in the order of the sections."""
    return tuple(chain(*(kinds.models for kinds in _folders(Scene))))


def _folders(model: type[BaseModel]) -> Iterator[KindIn]:
    """Yield the folders of kinds for the sections below a model."""
    for field in model.model_fields.values():
        kinds = one_of(field)
        if kinds is not None:
            yield kinds
        # a kind may contain a section with kinds
        yield from chain(*map(_folders, models_of(field)))


def scenes_page() -> str:
    """Return the page of the keys, with each model once under all its keys."""
    keys: dict[tuple[type[BaseModel], ...], list[str]] = {(Scene,): ['The scene']}

    def add(title: str, models: list[type[BaseModel]]) -> None:
        titles = keys.setdefault(tuple(models), [])
        if title not in titles:
            titles.append(title)

    for key, models in _sections(Scene, ''):
        add(f'`{key}`', models)
        for source, forms in (('file', _FROM_FILES), ('hindcast', _FROM_HINDCASTS)):
            if form := forms.get(key.removeprefix('ship.')):
                add(f'`{key}`, from a {source}', [form])
                for part, parts in _sections(form, key):
                    add(f'`{part}`', parts)
    sections = [
        _of_model(f'## {", ".join(titles)}', models[0])
        if len(models) == 1
        else _of_kinds(f'## {", ".join(titles)}', models)
        for models, titles in keys.items()
    ]
    return '\n'.join([_HEAD, *sections, _UNITS.format(table=units_table())])


def _sections(model: type[BaseModel], path: str) -> Iterator[tuple[str, list[type[BaseModel]]]]:
    """Yield key path and models of each section below a model, depth first."""
    for name, field in model.model_fields.items():
        models = models_of(field)
        if models:
            key = f'{path}.{name}' if path else name
            yield key, models
            for section in models:
                yield from _sections(section, key)


def _of_kinds(title: str, models: tuple[type[BaseModel], ...]) -> str:
    """Return the text about a key with several kinds: shared keys, then each kind."""
    every = [_rows(model) for model in models]
    shared = {
        key: row
        for key, row in every[0].items()
        if key not in TAGS and all(rows.get(key) == row for rows in every)
    }
    tag = next(key for key in TAGS if key in every[0])
    names = {model: get_args(model.model_fields[tag].annotation) for model in models}
    row = f'| `{tag}` |  | {", ".join(chain(*names.values()))} |'
    kinds = (
        _of_model(f'### {" or ".join(kinds)}', model, leave_out={tag, *shared})
        for model, kinds in names.items()
    )
    return '\n'.join([title, '', *_table({tag: row, **shared}), *kinds])


def _of_model(title: str, model: type[BaseModel], leave_out: Set[str] = frozenset()) -> str:
    text = textwrap.fill(' '.join((model.__doc__ or '').split()), 120, break_on_hyphens=False)
    rows = {key: row for key, row in _rows(model).items() if key not in leave_out}
    return '\n'.join([title, '', text, '', *_table(rows)])


def _rows(model: type[BaseModel]) -> dict[str, str]:
    """Return the row of each key: its default and its meaning."""
    rows = {}
    for name, field in model.model_fields.items():
        default = '' if field.is_required() else f'`{field.default!r}`'
        if field.default is None:
            default = 'left out'
        elif isinstance(field.default, Section):
            default = f'`{field.default.model_dump(mode="json", exclude_none=True)}`'
        meaning = (field.description or '').replace('|', '\\|')
        if name == 'kind' and not meaning:
            meaning = f'{field.default}'
        if not field.exclude:
            rows[name] = f'| `{name}` | {default} | {meaning} |'
    return rows


def _table(rows: Mapping[str, str]) -> list[str]:
    return ['| key | default | meaning |', '|---|---|---|', *rows.values(), ''] if rows else []


# -----------------------------------------------------------------------------
# The JSON schema of scene files, for editors and other programs.
#
# Pydantic makes the schema. Added are sections from files, the required key `kind`, and waypoints
# written as places.

FILE = Path(__file__).with_name('scene.schema.json')
"""The schema in the package, written by `python -m tauto_core.scene.reference`."""

_REF = '#/$defs/'
# the same characters without classes, which few programs know
_ONE_LINE = (r'\p{Cc}\p{Zl}\p{Zp}', r'\u0000-\u001f\u007f-\u009f\u2028\u2029')


def schema() -> dict[str, Any]:
    """Return the schema (JSON Schema 2020-12)."""
    content = Scene.model_json_schema(ref_template=_REF + '{model}')
    definitions = content['$defs']
    for form in (*_FROM_FILES.values(), *_FROM_HINDCASTS.values()):
        of_file = form.model_json_schema(ref_template=_REF + '{model}')
        definitions |= of_file.pop('$defs', {})
        definitions[form.__name__] = of_file
    ship, waypoint = definitions['SeaShip']['properties'], definitions['Waypoint']
    ship['sea']['anyOf'][0]['oneOf'].append({'$ref': f'{_REF}SpectrumFile'})
    ship['sea'].pop('examples')
    ship['rao']['anyOf'].insert(1, {'$ref': f'{_REF}RaoFile'})
    ship['hull']['anyOf'] += [{'$ref': f'{_REF}HullFile'}, {'type': 'string'}]
    ship['weather']['anyOf'][0]['oneOf'].extend(
        {'$ref': f'{_REF}{form.__name__}'} for form in (RecordFile, HindcastFile)
    )
    air = content['properties']['air']['anyOf'][0]
    air['oneOf'] += [
        {'$ref': f'{_REF}{form.__name__}'} for form in (AirRecordFile, AirHindcastFile)
    ]
    # keys that follow from a log-book are not required
    logged = definitions['Itinerary']
    logged['properties']['log']['anyOf'].insert(1, {'$ref': f'{_REF}LogFile'})
    logged['anyOf'] = [{'required': logged.pop('required')}, {'required': ['log']}]
    by_log = {'properties': {'voyage': {'required': ['log']}}, 'required': ['voyage']}
    definitions['Landfall'] = waypoint
    place = waypoint['properties']['place']
    definitions['Waypoint'] = {'anyOf': [{'$ref': f'{_REF}Landfall'}, place]}
    # a section without `kind` is of the default kind, if there is one
    defaults = {folder.default for folder in _folders(Scene)}
    names = [kind.__name__ for kind in all_kinds() if kind_of(kind) not in defaults]
    forms = (RecordFile, HindcastFile, AirRecordFile, AirHindcastFile)
    for name in (*names, *(form.__name__ for form in forms)):
        definitions[name].setdefault('required', []).insert(0, 'kind')
    content['anyOf'] = [{'required': ['trochlea']}, {'required': ['regulator']}]
    content['allOf'] = [{'anyOf': [{'required': content.pop('required')}, by_log]}]
    head = {'$schema': 'https://json-schema.org/draft/2020-12/schema', 'title': 'Scene of Tauto'}
    cleaned: dict[str, Any] = _cleaned({**head, **content, 'title': head['title']})
    return cleaned


def _cleaned(part: Any) -> Any:
    """Return a part without pydantic's discriminators and titles of keys."""
    if isinstance(part, list):
        return [_cleaned(item) for item in part]
    if isinstance(part, str):
        return part.replace(*_ONE_LINE)
    if not isinstance(part, dict):
        return part
    content = {key: value for key, value in part.items() if key != 'discriminator'}
    if 'properties' in content:
        content['properties'] = {
            name: _or_with_unit(item) if declared(item.get('description')) else item
            for name, item in (
                (name, {key: value for key, value in item.items() if key != 'title'})
                for name, item in content['properties'].items()
            )
        }
    return {key: _cleaned(value) for key, value in content.items()}


def _or_with_unit(part: Any) -> Any:
    """Return a part in which texts with a unit are allowed for numbers."""
    if isinstance(part, list):
        return [_or_with_unit(item) for item in part]
    if not isinstance(part, dict):
        return part
    if part.get('type') != 'number':
        return {key: _or_with_unit(item) for key, item in part.items()}
    # limits apply to numbers only, the pattern to texts
    return {**part, 'type': ['number', 'string'], 'pattern': f'^{NUMBER} *[^ 0-9.,]'}


def schema_text() -> str:
    """Return the text of the schema's file."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + '\n'


# -----------------------------------------------------------------------------
# A scene to start from: every key with its unit and meaning, and values that run.
#
# The values come from `Kind.starter`: a wheel of 4 kg cm2 with a period of about one second and an
# amplitude of one radian.

WIDTH = 99
ENDINGS = ('.yaml', '.yml')

FOLDERS = {'cam': CAMS, 'thread': THREADS, 'power': POWERS, 'escapement': ESCAPEMENTS}
"""Sections that must be compatible, and the folders of their kinds."""

CHOICES = {'ship': SHIPS, **FOLDERS}
"""Sections of a new scene with a choice of kinds."""

# text that needs no quotes in YAML
_PLAIN = re.compile(
    r'(?!(?:true|false|null|yes|no|on|off|y|n)$)[a-z]\w*', re.ASCII | re.IGNORECASE
)
_USUAL = {'cam': 'involute', 'thread': 'vertical', 'power': 'weight', 'escapement': ''}
_FORMS: dict[type[BaseModel], type[BaseModel]] = {Rao: RaoFile}
# values in the comments of sections and keys that are left out
_LEFT_OUT: dict[str, Any] = {
    'voyage': {
        'departure': [50.79, -1.11],
        'arrival': [17.93, -76.84],
        'sails_at': 300.0,
        'arrives_at': 1.5e6,
    },
    'regulator': {
        'kind': 'fluid_tautochrone',
        'body': 'globe',
        'diameter': 0.05,
        'body_density': 7800.0,
        'fluid_density': 900.0,
        'pendulum_length': 0.99362,
        'release_arc': 0.4,
    },
    'solver': {'tolerance': 1e-10},
    'clock': {'nominal_period': 1.0},
    'trochlea.material': 'brass',
    'trochlea.cam.material': 'steel',
    'trochlea.power.material': 'steel',
    'trochlea.compensation': {'takes': -10.7, 'leaves': -0.01},
    'drag.oil': 'sperm',
    'air': {'kind': 'constant', 'celsius': 15.0},
    'escapement.train': {'fall': 0.1, 'impulses': 86400, 'energy': 1.5e-4},
    'escapement.rest': {'friction': 1e-6},
    'ship.rao': {'path': 'shipped:supply_rao/supply_rao.csv', 'heading': 1.75},
    'ship.heading': 1.5708,
    'ship.roll.fitted_to': 'decay test of …',
    'ship.recorded.topic': '/imu/data',
    'clock.white_fm': 0.1,
    'clock.random_walk_fm': 0.01,
    'drift.white_fm': 0.1,
    'drift.random_walk_fm': 0.01,
    'drift.covariates': ['heave', 'roll'],
    'drift.coefficients.heave': {'value': 1.0, 'sigma': 0.05},
    'drift.coefficients.roll': {'value': 0.01, 'sigma': 0.02},
    'drift.coefficients.gravity': {'value': 1.005, 'sigma': 0.01},
    'drift.coefficients.temperature': {'value': -1.2e-4, 'sigma': 1e-5},
    'drift.coefficients.temperature_squared': {'value': 0.0, 'sigma': 1e-7},
    'log.motion': True,
    'voyage.date': '1761-11-18',
    'voyage.track': 'geodesic',
    'voyage.waypoints': [[36.97, -25.1]],
    'voyage.speed': 5.0,
}


def new_scene(name: str, kinds: Mapping[str, str]) -> str:
    """Return the text of a runnable scene with comments.

    `kinds` are wanted for keys of `CHOICES`. The others are chosen to be compatible. UsageError
    for unknown or incompatible kinds.
    """
    wanted = {'ship': 'sea', **kinds}
    for key, kind in wanted.items():
        names = [kind_of(model) for model in kinds_in(CHOICES[key])]
        if kind not in names:
            matches = get_close_matches(kind, names, 1)
            guess = f'Did you mean {matches[0]}? ' if matches else ''
            text = f': unknown kind. {guess}Use one of {", ".join(names)}'
            raise UsageError(Argument(key, kind), text)
    pairs = fitting({key: kind for key, kind in wanted.items() if key in FOLDERS})
    content = _content(name, wanted['ship'], pairs)
    head = [
        f'# yaml-language-server: $schema={FILE.as_uri()}',
        '#',
        *_prose(
            'SI units and radians. Remove the # in front of a key to use it. Keys left out are '
            'not simulated, or as the comment says.'
        ),
        '',
    ]
    return '\n'.join([*head, *_lines(Scene, content, '', '')]) + '\n'


def write_scene(file: str | None, text_of: Callable[[str], str]) -> str:
    """Return the text of a scene, a function of its name, and write it to a new file, if named.

    UsageError if the file exists, has another ending or cannot be written.
    """
    if file is None:
        return text_of('new_scene')
    argument, place = Argument('file', file), Path(file)
    if file.endswith(os.sep) or place.is_dir():  # a Path drops the slash of a folder
        raise UsageError(argument, ': is a folder. Name a file in it, such as new.yaml')
    if place.exists():
        raise UsageError(argument, ': exists, and is not replaced. Name another file')
    if not file.endswith(ENDINGS):
        example = place.with_suffix(ENDINGS[0])
        raise UsageError(argument, f': must end in {" or ".join(ENDINGS)}. Use {example}')
    # the name of a file may contain bytes that are not text
    text = text_of(place.stem.encode('utf-8', 'replace').decode())
    try:
        write_whole(place, text.encode())
    except OSError as error:
        why = f': cannot be written: {error.strerror}. Name another file'
        raise UsageError(argument, why) from None
    return text


def scene_of_design(design: WheelDesign, name: str) -> str:
    """Return the checked scene of a design, released at 1 rad on land, as YAML."""
    head = (
        '# Found by tauto design. The pull has no inertia; a weight has, with another cam:\n'
        f'#   cam: {{kind: weight_corrected, period: {design.period_s:.9g}}}\n'
        f'#   power: {{kind: weight, mass: {design.pull_n / design.gravity_m_s2:.6g}}}\n'
    )
    trochlea = {
        'inertia': design.inertia_kg_m2,
        'cam': {'kind': 'involute', 'base_radius': design.base_radius_m},
        'thread': {'kind': 'vertical'},
        'power': {'kind': 'force', 'force': design.pull_n},
        'release_angle': 1.0,
    }
    settings = {'name': name, 'duration': 3600.0, 'gravity': design.gravity_m_s2}
    text = head + write_mapping({**settings, 'trochlea': trochlea})
    parse_scene(text, name)
    return text


def fitting(wanted: Mapping[str, str]) -> dict[str, str]:
    """Return compatible kinds for `FOLDERS`, if possible the usual ones.

    UsageError, with compatible kinds, if the wanted kinds are incompatible.
    """

    def rows(some: Mapping[str, str]) -> list[dict[str, str]]:
        return [row for row in compatible_kinds() if some.items() <= row.items()]

    if every := rows(wanted):
        return every[0]
    # name a pair of incompatible kinds, if there is one
    pairs = ({one: wanted[one], two: wanted[two]} for one, two in combinations(wanted, 2))
    wanted = next((pair for pair in pairs if not rows(pair)), wanted)
    advice: list[str | Argument] = []
    for key in wanted:
        fits = {row[key] for row in rows({name: wanted[name] for name in wanted if name != key})}
        if kinds := [kind for kind in map(kind_of, kinds_in(FOLDERS[key])) if kind in fits]:
            advice += ['; or ', Argument(key, ' or '.join(kinds))]
    typed = [part for key, kind in wanted.items() for part in (' and ', Argument(key, kind))]
    raise UsageError(*typed[1:], ': do not go together. Use ', *advice[1:])


def goes_together(kinds: Mapping[str, str]) -> bool:
    """Return whether kinds are compatible with the values of a new scene; '': no escapement."""
    try:
        Scene.model_validate(_content('new', 'still', kinds))
    except ValidationError:
        return False
    return True


@cache
def compatible_kinds() -> tuple[dict[str, str], ...]:
    """Return all compatible combinations of kinds, the usual ones first."""
    every = [[kind_of(model) for model in kinds_in(folder)] for folder in FOLDERS.values()]
    every[-1].insert(0, '')
    rows = (dict(zip(FOLDERS, row, strict=True)) for row in product(*every))

    def oddity(row: Mapping[str, str]) -> tuple[int, int]:
        # number of unusual kinds, then of cam and power among them
        odd = [key for key, usual in _USUAL.items() if row[key] != usual]
        return len(odd), sum(key in ('cam', 'power') for key in odd)

    return tuple(sorted(filter(goes_together, rows), key=oddity))


def _started(key: str, kind: str) -> dict[str, Any]:
    model = next(model for model in kinds_in(CHOICES[key]) if kind_of(model) == kind)
    return {'kind': kind, **model.starter}


def _content(name: str, ship: str, kinds: Mapping[str, str]) -> dict[str, Any]:
    gives = kinds['escapement']
    return {
        'name': name,
        'duration': 600.0,
        'trochlea': {
            'inertia': 4.0e-4,
            **{key: _started(key, kinds[key]) for key in ('cam', 'thread', 'power')},
            'release_angle': 1.0,
        },
        **(
            {'drag': dict(Drag.starter), 'escapement': _started('escapement', gives)}
            if gives
            else {}
        ),
        'ship': _started('ship', ship),
        # wide enough for a weight, which loses a minute a day at sea
        'drift': {'observation_interval': 60.0, 'prior_rate_sigma': 100.0},
    }


def _lines(model: type[BaseModel], stated: Mapping[str, Any], path: str, edge: str) -> list[str]:
    """Return the keys of a model as lines of YAML, each after `edge`.

    A key missing in `stated` has its default or is commented out. `path` is the section's path.
    """
    lines: list[str] = []
    # the key of the kind comes first
    for name, field in sorted(model.model_fields.items(), key=lambda item: item[0] != 'kind'):
        if field.exclude or (name == 'gamma' and stated.get('spectrum') != 'jonswap'):
            continue
        key = f'{path}.{name}' if path else name
        # a section without values is left out, too
        empty = isinstance(field.default, BaseModel) and not field.default.model_dump(
            exclude_none=True
        )
        out = name not in stated and (empty or field.default is None or field.is_required())
        value = _LEFT_OUT.get(key) if out else stated.get(name, field.default)
        section = _section(field, value, out=out)
        if section is None:
            text = field.description or ''
            if name == 'kind' and issubclass(model, Kind):
                siblings = next(kinds.models for kinds in _folders(Scene) if model in kinds.models)
                text = f'one of {", ".join(map(kind_of, siblings))}'
            lines += _entry(edge, name, value, text, out=out)
            continue
        if not path:
            lines.append(edge.rstrip())
        values = value if isinstance(value, dict) else {}
        tag = getattr(section, 'starter', None)
        if out and tag is not None:
            values = {'kind': kind_of(cast(type[Kind], section)), **tag}
        first_sentences = ' '.join((section.__doc__ or '').split('\n\n')[0].split())
        lines += _entry(edge, name, None, first_sentences, out=out)
        lines += _lines(section, values, key, f'{edge}#  ' if out else f'{edge}  ')
    return lines


def _section(field: FieldInfo, value: object, *, out: bool) -> type[BaseModel] | None:
    """Return the model of a field's section, None for a number, a text or a list."""
    models, kinds = models_of(field), one_of(field)
    if not models or not (isinstance(value, dict | BaseModel) or (out and value is None)):
        return None
    model = type(value) if isinstance(value, BaseModel) else models[0]
    if kinds and isinstance(value, dict):
        tag = value.get('kind', kinds.default)
        model = next(model for model in kinds.models if kind_of(model) == tag)
    return _FORMS.get(model, model)


def _entry(edge: str, name: str, value: Any, text: str, *, out: bool) -> list[str]:
    """Return a key with its value, followed or (if the line is long) preceded by its meaning."""
    key = f'{edge}{"#" if out else ""}{name}: {_yaml(value)}'.rstrip()
    if not text:
        return [key]
    line = f'{key:<34}  # {text}'
    if len(line) <= WIDTH:
        return [line]
    if len(key) > WIDTH:  # a list of mappings
        key, *items = f'{edge}{name}:', *(f'{edge}  - {_yaml(item)}' for item in value)
        return [*_prose(text, edge), key, *items]
    return [*_prose(text, edge), key]


def _prose(text: str, edge: str = '') -> list[str]:
    return textwrap.wrap(text, WIDTH, initial_indent=f'{edge}# ', subsequent_indent=f'{edge}# ')


def _yaml(value: Any) -> str:
    """Return a value as YAML within a line."""
    if value is None:
        return ''
    if isinstance(value, list | tuple):
        return f'[{", ".join(map(_yaml, value))}]'
    if isinstance(value, dict):
        return '{' + ', '.join(f'{key}: {_yaml(item)}' for key, item in value.items()) + '}'
    if isinstance(value, str):
        return value if _PLAIN.fullmatch(value) else json.dumps(value, ensure_ascii=False)
    return json.dumps(value)


if __name__ == '__main__':
    FILE.write_text(schema_text(), encoding='utf-8')
    print(scenes_page(), end='')
