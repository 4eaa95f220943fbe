"""Numbers with a unit in words, in scenes, overrides and options."""

import json
import math

import pytest
from jsonschema import Draft202012Validator
from typer.main import get_command
from typer.testing import CliRunner

import tauto_core
from tauto_core.cli.app import ENTRIES, app
from tauto_core.ensembles.fleets import as_draws
from tauto_core.scene import SceneError, load_scene, parse_scene, scene_yaml
from tauto_core.scene.reference import schema
from tauto_core.scene.sections import LogFile
from tauto_core.scene.units import in_unit, misfit

SCENE = """\
duration: 10 min
trochlea:
  inertia: 4 kg cm2
  cam: {kind: involute, base_radius: 5 mm}
  thread: {kind: vertical}
  power: {kind: weight, mass: 300 g}
  release_angle: 60 deg
drag: {viscous: 1e-6}
log: {interval: 500 ms}
"""

NUMBERS = {
    # text, unit of the key: the number, by the definitions of the units
    ('5 mm', 'm'): 0.005,
    ('5mm', 'm'): 0.005,
    ('9.3 mm', 'm'): 0.0093,  # 9.3 times 0.001 rounds to another number
    ('1 inch', 'm'): 0.0254,
    ('1 scruple', 'm'): 0.00031385,
    ('12 paris_line', 'm'): 0.02707,
    ('12 kn', 'm/s'): 12 * 1852 / 3600,
    ('36 h', 'days'): 1.5,
    ('1 min/day', 's/day'): 60.0,
    ('60 deg', 'rad'): math.radians(60.0),
    ('−3°', 'rad'): math.radians(-3.0),
    ('1 turn', 'rad'): math.tau,
    ('30 arcmin', 'deg'): 0.5,
    ('1 rad', 'deg'): math.degrees(1.0),
    ('68 degF', '°C'): 20.0,
    ('0 K', '°C'): -273.15,
    ('4 kg cm2', 'kg m2'): 4e-4,
    ('4 kg·cm²', 'kg m2'): 4e-4,
    ('0.9 g/cm3', 'kg/m3'): 900.0,
    ('-10.7 s/day/K', 's/day/K'): -10.7,
    ('1e-999 m', 'm'): 0.0,
}


@pytest.mark.parametrize(('text', 'unit'), NUMBERS)
def test_a_text_is_the_number_in_the_unit_that_is_asked(text: str, unit: str) -> None:
    """Equal to the last bit: degrees as `math.radians` has them, decimals as Python reads them."""
    assert in_unit(text, unit) == NUMBERS[text, unit]


@pytest.mark.parametrize(
    ('text', 'unit', 'problem', 'remedy'),
    [
        ('5 min', 'm', 'must be a length [m], not a time', 'mm, cm'),
        ('1 g', 'm/s2', 'must be an acceleration [m/s2], not a mass', 'm/s2'),
        ('20 degC', 'K', 'must be a difference of temperatures [K], not a temperature', 'K.'),
        ('5 nm', 'm', "'nm' is not a known unit; did you mean nmi?", 'nmi'),
        ('5 degC m', 'm', "'degC m' is not a known unit", 'mm'),
        ('5 m/s s', 'm', "'m/s s' is not a known unit", 'mm'),
        ('5e mm', 'm', "'e mm' is not a known unit; did you mean mm?", 'mm'),
        ('5,5 mm', 'm', 'has a decimal comma', 'Write 5.5 mm.'),
        ('1e999 m', 'm', 'is too large for a number in m', 'm'),
    ],
)
def test_what_does_not_fit_is_told(text: str, unit: str, problem: str, remedy: str) -> None:
    assert in_unit(text, unit) is text
    said = misfit(text, unit)
    assert said is not None
    assert said[0] == problem
    assert remedy in said[1]


@pytest.mark.parametrize(
    'text', ['nan m', 'inf m', '5', '1_0 mm', '0x10 m', 'mm', '', '1e9999999 m', '5 ' + 90 * 'm']
)
def test_what_is_no_number_with_a_unit_stays_a_text(text: str) -> None:
    assert in_unit(text, 'm') is text


def test_a_scene_in_words_is_the_scene_in_numbers() -> None:
    scene = parse_scene(SCENE, 'words')
    numbers = SCENE
    for word, number in {
        '10 min': '600',
        '4 kg cm2': '4e-4',
        '5 mm': '0.005',
        '300 g': '0.3',
        '60 deg': repr(math.radians(60.0)),
        '500 ms': '0.5',
    }.items():
        numbers = numbers.replace(word, number)
    assert scene_yaml(scene) == scene_yaml(parse_scene(numbers, 'numbers'))
    # bags and --json have the number
    assert 'base_radius: 0.005\n' in scene_yaml(scene)


def test_lists_and_places_have_units_too() -> None:
    scene = tauto_core.load(
        'measured',
        **{'voyage.departure': ['50.79 deg', '-66.6 arcmin'], 'voyage.arrives_at': '76 d'},
    )
    assert scene.voyage is not None
    assert scene.voyage.departure == (50.79, -1.11)
    assert scene.voyage.arrives_at == 76 * 86400.0


def test_the_form_of_a_file_has_units_too() -> None:
    assert LogFile(path='log.csv', harbour_days='36 h').harbour_days == 1.5


@pytest.mark.parametrize(
    ('key', 'value', 'said'),
    [
        ('gravity', '1 min', "gravity = '1 min': must be an acceleration [m/s2], not a time"),
        ('trochlea.cam.base_radius', '-5 mm', 'base_radius = -0.005: must be greater than 0.0'),
        ('gravity', '1 g', "gravity = '1 g': must be an acceleration [m/s2], not a mass"),
        ('solver.tolerance', '5 m', "'5 m': must be a number without a unit"),
        ('seed', '5 m', "seed = '5 m': must be a whole number, not text"),
        ('trochlea.cam.base_radius', '5', 'leave out quotes around numbers'),
    ],
)
def test_a_scene_refuses_what_does_not_fit(key: str, value: str, said: str) -> None:
    with pytest.raises(SceneError) as caught:
        tauto_core.load('involute_weight_at_sea', **{key: value})
    assert len(caught.value.problems) == 1
    assert said in str(caught.value)
    assert 'Write `' in str(caught.value)


def test_editors_take_a_scene_in_words() -> None:
    valid = Draft202012Validator(schema())
    written = parse_scene(SCENE, 'words').model_dump(mode='json', exclude_none=True)
    written['duration'] = '10 min'
    assert valid.is_valid(written)
    for wrong in ('ten minutes', '600', -600.0, '6,5 s'):
        written['duration'] = wrong
        assert not valid.is_valid(written)


def test_every_number_in_brackets_is_a_unit_that_is_known() -> None:
    """Each key with a unit in brackets takes a text. One is tried through the schema."""
    found = schema()['$defs'] | {'Scene': schema()}
    units = [
        (name, key)
        for name, model in found.items()
        for key, each in model.get('properties', {}).items()
        if '[' in each.get('description', '') and 'number' in json.dumps(each)
    ]
    silent = [
        (name, key)
        for name, key in units
        if '"pattern"' not in json.dumps(found[name]['properties'][key])
    ]
    # lists of places and mappings: their items are tested by themselves
    lists = {'entries', 'waypoints', 'temperature', 'components', 'seas'}
    assert {key for _, key in silent} <= lists
    assert len(units) > 100


@pytest.mark.parametrize(
    ('line', 'said'),
    [
        ('sail ideal --duration x', "--duration = 'x': must be a number [s]"),
        ('plot ideal roll --from 5mm', "--from = '5mm': must be a time [s], not a length"),
        ('design --pull 5min', "--pull = '5min': must be a force [N], not a time"),
    ],
)
def test_an_option_refuses_what_does_not_fit(line: str, said: str) -> None:
    result = CliRunner().invoke(app, line.split())
    assert result.exit_code == 2
    assert said in ' '.join(result.stderr.split())


def test_numbers_that_take_no_unit_have_none() -> None:
    """Options that are plain floats are ratios. The calls convert all others."""
    plain = {
        option.name
        for name in ENTRIES
        if (command := get_command(app).commands[name]) and not hasattr(command, 'commands')
        for option in command.params
        if option.type_descriptor.annotation is float
    }
    assert plain == {'friction', 'block', 'roll_damping'}


def test_python_and_the_command_line_take_the_same_units() -> None:
    def designed(*words: str) -> dict[str, object]:
        result = CliRunner().invoke(app, ['design', '--json', '--inertia', '4 kg cm2', *words])
        assert result.exit_code == 0, result.stderr
        found: dict[str, object] = json.loads(result.stdout)
        return found

    # a weight of 300 g pulls with 300 g × g
    sizes = ('--base-radius', '5 mm', '--pull')
    by_mass = designed(*sizes, '300 g')
    assert by_mass['pull_n'] == 0.3 * 9.80665
    assert designed(*sizes, f'{0.3 * 9.80665!r} N') == by_mass
    found = tauto_core.design(inertia='4 kg cm2', base_radius='5 mm', pull='300 g')
    assert (found.pull_n, found.period_s) == (by_mass['pull_n'], by_mass['period_s'])
    degrees = tauto_core.isochronism('ideal', ['30 deg'])
    assert degrees.amplitude_rad[0] == math.radians(30.0)
    assert tauto_core.cam('ideal', reach_rad='30 deg').angle_rad[-1] == math.radians(30.0)
    with pytest.raises(tauto_core.TautoError, match=r"thread_mm = '1 s': must be a length \[mm\]"):
        tauto_core.cam('ideal', svg='cam.svg', thread_mm='1 s')
    with pytest.raises(tauto_core.TautoError, match=r"from_s = '1 m': must be a time \[s\]"):
        tauto_core.plot('ideal', 'roll', from_s='1 m')


def test_what_a_fleet_draws_is_in_the_unit_of_the_key() -> None:
    scene = load_scene(
        'involute_weight_at_sea', duration=60.0, air={'kind': 'constant', 'celsius': 20.0}
    )
    said: dict[str, object] = {
        'trochlea.cam.base_radius': {'kind': 'normal', 'sigma': '20 um', 'mean': '5 mm'},
        'trochlea.release_angle': {'kind': 'list', 'values': ['60 deg', 1]},
        'air.celsius': {'kind': 'uniform', 'low': '68 degF', 'high': 30},
    }
    radius, angle, warm = as_draws(said, 'vary', scene).values()
    assert (radius.sigma, radius.mean) == (2e-5, 0.005)
    assert angle.values == (math.radians(60.0), 1)
    assert (warm.low, warm.high) == (20.0, 30.0)
    # a spread of temperatures is no temperature: 9 °F are 5 K, not −13 °C
    for spread in ('5 K', 5):
        (air,) = as_draws(
            {'air.celsius': {'kind': 'normal', 'sigma': spread}}, 'v', scene
        ).values()
        assert air.sigma == 5.0
    for key, sigma, problem in (
        ('trochlea.cam.base_radius', '5 s', r'base_radius.sigma = .5 s.: must be a length \[m\]'),
        ('air.celsius', '5 degC', r'celsius.sigma = .5 degC.: must be a difference of temp'),
    ):
        with pytest.raises(SceneError, match=problem):
            as_draws({key: {'kind': 'normal', 'sigma': sigma}}, 'vary', scene)
