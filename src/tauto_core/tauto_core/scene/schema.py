"""The JSON schema of scene files, for editors and other programs.

It is the schema of the models with additions that pydantic cannot make: sections that a file
may replace, the required key `kind`, a waypoint that is written as its place.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tauto_core.scene.models import Scene
from tauto_core.scene.reference import all_kinds
from tauto_core.ship.sea_files import FILE_FORMS
from tauto_core.ship.weather_file import RecordFile

FILE = Path(__file__).with_name('scene.schema.json')
"""The schema that ships, which `python -m tauto_core.scene.schema` prints."""

_REF = '#/$defs/'
# The same set of characters, without the character classes that few programs know.
_ONE_LINE = (r'\p{Cc}\p{Zl}\p{Zp}', r'\u0000-\u001f\u007f-\u009f\u2028\u2029')


def schema() -> dict[str, Any]:
    """Return the schema, of JSON Schema 2020-12."""
    found = Scene.model_json_schema(ref_template=_REF + '{model}')
    definitions = found['$defs']
    for form in FILE_FORMS.values():
        of_file = form.model_json_schema(ref_template=_REF + '{model}')
        definitions |= of_file.pop('$defs', {})
        definitions[form.__name__] = of_file
    ship, waypoint = definitions['SeaShip']['properties'], definitions['Waypoint']
    ship['sea']['anyOf'][0]['oneOf'].append({'$ref': f'{_REF}SpectrumFile'})
    ship['sea'].pop('examples')
    ship['roll']['anyOf'].insert(1, {'$ref': f'{_REF}RollFromDecay'})
    ship['rao']['anyOf'].insert(1, {'$ref': f'{_REF}RaoFile'})
    ship['weather']['anyOf'][0]['oneOf'].append({'$ref': f'{_REF}RecordFile'})
    definitions['Landfall'] = waypoint
    place = waypoint['properties']['place']
    definitions['Waypoint'] = {'anyOf': [{'$ref': f'{_REF}Landfall'}, place]}
    for name in (*(model.__name__ for model in all_kinds()), RecordFile.__name__):
        # an escapement without a kind is of the kind impulse
        if name != 'Escapement':
            required = definitions[name].setdefault('required', [])
            required.insert(0, 'kind')
    found['anyOf'] = [{'required': ['trochlea']}, {'required': ['regulator']}]
    head = {'$schema': 'https://json-schema.org/draft/2020-12/schema', 'title': 'Scene of Tauto'}
    cleaned: dict[str, Any] = _cleaned({**head, **found, 'title': head['title']})
    return cleaned


def _cleaned(part: Any) -> Any:
    """Return a part without pydantic's discriminators and without titles that only repeat keys."""
    if isinstance(part, list):
        return [_cleaned(each) for each in part]
    if isinstance(part, str):
        return part.replace(*_ONE_LINE)
    if not isinstance(part, dict):
        return part
    kept = {key: value for key, value in part.items() if key != 'discriminator'}
    if 'properties' in kept:
        kept['properties'] = {
            name: {key: value for key, value in each.items() if key != 'title'}
            for name, each in kept['properties'].items()
        }
    return {key: _cleaned(value) for key, value in kept.items()}


def schema_text() -> str:
    """Return the schema as the file that ships."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + '\n'


if __name__ == '__main__':
    print(schema_text(), end='')
