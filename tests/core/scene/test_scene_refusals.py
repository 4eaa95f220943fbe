"""Every bad scene is refused before anything starts, with file, key, value, limit and remedy."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from tauto_core import files
from tauto_core.scene import SceneError, load_scene, parse_scene
from tauto_core.scene.errors import ABSENT, UsageError
from tauto_core.scene.loader import read_mapping
from tauto_core.ship import ShipMotion


def good() -> dict[str, Any]:
    """Return the content of a scene that is accepted: a recorded ship, a voyage, a log."""
    return {
        'name': 'good',
        'duration': 600.0,
        'trochlea': {
            'inertia': 4e-4,
            'cam': {'kind': 'involute', 'base_radius': 0.01},
            'thread': {'kind': 'vertical'},
            'power': {'kind': 'force', 'force': 1.5},
            'release_angle': 1.0,
        },
        'escapement': {'kind': 'impulse', 'energy': 1e-6},
        'ship': {
            'kind': 'recorded',
            'recorded': {'path': 'roll.csv', 'time_column': 't_s', 'roll_column': 'roll_deg'},
        },
        'voyage': {
            'departure': [50.0, -1.0],
            'arrival': [18.0, -77.0],
            'sails_at': 60.0,
            'arrives_at': 600.0,
        },
        'drift': {'observation_interval': 60.0},
    }


SEA = {
    'kind': 'sea',
    'sea': {'spectrum': 'jonswap', 'significant_wave_height': 2.5, 'peak_period': 9.0},
    'roll': {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7},
}
WAVES = {'kind': 'components', 'components': [{'amplitude': 0.1, 'period': 9.0}]}
FAST = {'kind': 'components', 'components': [{'amplitude': 0.1, 'period': 1.5}]}
CHOP = {'spectrum': 'jonswap', 'significant_wave_height': 0.1, 'peak_period': 1.5}
MIRROR = {'spectrum': 'jonswap', 'significant_wave_height': 1e-300, 'peak_period': 9.0}
TIDE = {'spectrum': 'jonswap', 'significant_wave_height': 1.0, 'peak_period': 1e300}
HIGH = CHOP | {'significant_wave_height': 1e200, 'peak_period': 9.0}
DEGREES = {'kind': 'components', 'components': [{'amplitude': 8.0, 'period': 9.0}]}
FLAT = SEA['sea'] | {'spectrum': 'bretschneider', 'gamma': 3.3}
FORCES = {'path': 'run.mcap', 'topic': '/imu', 'scale': 2.0}
REMOVED = object()


def storm(at: float) -> dict[str, Any]:
    """Return a ship in weather with one state, at a time from the start [s]."""
    state = {'at': at, 'significant_wave_height': 9.0, 'peak_period': 12.0}
    return {'kind': 'sea', 'weather': {'kind': 'states', 'states': [state]}, 'roll': SEA['roll']}


def put(content: dict[str, Any], path: str, value: object) -> None:
    """Set or remove the value at a path such as `ship.recorded.path`."""
    *sections, key = path.split('.')
    for name in sections:
        content = content[name]
    if value is REMOVED:
        del content[key]
    else:
        content[key] = value


def changed(*changes: tuple[str, object]) -> str:
    content = good()
    for path, value in changes:
        put(content, path, value)
    return yaml.safe_dump(content)


def refusal(*changes: tuple[str, object]) -> SceneError:
    with pytest.raises(SceneError) as caught:
        parse_scene(changed(*changes), 'bad.yaml')
    assert caught.value.exit_code == 2
    return caught.value


def test_the_scene_that_the_refusals_spoil_is_accepted() -> None:
    assert parse_scene(yaml.safe_dump(good()), 'good.yaml').duration == 600.0


@pytest.mark.parametrize(
    ('path', 'value', 'key', 'said'),
    [
        # unknown keys and kinds
        ('trochlea.cam.base_radus', 0.01, 'trochlea.cam.base_radus', 'Did you mean `base_radius`'),
        ('duratoin', 600.0, 'duratoin', 'Did you mean `duration`'),
        ('trochlea.cam.lever_rate', 0.01, 'trochlea.cam.lever_rate', 'not a key of kind inv'),
        ('trochlea.cam.kind', 'involut', 'trochlea.cam.kind', 'involute, hole, circular_arc, tab'),
        ('trochlea.thread', {}, 'trochlea.thread.kind', 'is missing'),
        ('trochlea.power.kind', ['force'], 'trochlea.power.kind', 'force, weight, spring'),
        ('ship', {'kind': 'still', 'components': []}, 'ship.components', 'not a key of kind s'),
        ('ship', SEA | {'sea': SEA['sea'] | {'spectrum': 'x'}}, 'ship.sea.spectrum', 'jonswap'),
        # missing
        ('trochlea', REMOVED, 'trochlea', 'is missing'),
        ('trochlea.inertia', REMOVED, 'trochlea.inertia', 'kg m2'),
        # kinds of value
        ('duration', '600.0', 'duration', 'quotes'),
        ('duration', True, 'duration', 'truth value'),
        ('trochlea.inertia', None, 'trochlea.inertia', 'not empty'),
        ('seed', 1.5, 'seed', 'whole number'),
        ('name', 5, 'name', 'must be text'),
        ('name', '', 'name', 'at least one character'),
        ('name', 'two\nlines', 'name', 'one line'),
        ('name', 'a' * 1001, 'name', 'at most 1000'),
        ('log', {'motion': 'yes'}, 'log.motion', 'true or false'),
        ('ship.recorded', 'roll.csv', 'ship.recorded', 'mapping'),
        ('voyage.departure', 50.0, 'voyage.departure', 'must be a list'),
        # ranges
        ('duration', float('nan'), 'duration', 'finite'),
        ('trochlea.inertia', 0.0, 'trochlea.inertia', 'greater than 0'),
        ('escapement.energy', 0.0, 'escapement.energy', 'greater than 0'),
        ('escapement.energy', -1e-6, 'escapement.energy', 'at least 0'),
        ('escapement.rest', {'recoil': 1e40}, 'escapement.rest.recoil', 'at most 1e+30'),
        ('drift.states', 4, 'drift.states', '2 or 3'),
        ('drift.observation_sigma', 0.0, 'drift.observation_sigma', 'at least 1e-09'),
        ('ship', SEA | {'sea': HIGH}, 'ship.sea.significant_wave_height', 'at most 100'),
        ('voyage.arrival', [0.0, -180.5], 'voyage.arrival[1]', 'at least -180'),
        ('voyage.arrival', [1.0, 2.0, 3.0], 'voyage.arrival', 'limit is at most 2'),
        ('solver', {'accuracy': 1e-3, 'tolerance': 1e-6}, 'solver.tolerance', 'follows from'),
        # combinations
        ('trochlea.thread', {'kind': 'hole', 'distance': 0.1}, 'trochlea.thread.kind', 'vertical'),
        ('trochlea.cam', {'kind': 'hole', 'lever_rate': 0.01}, 'trochlea.thread.kind', 'hole'),
        ('ship.rate', 3.0, 'ship.rate', '4.0 Hz'),
        ('ship.rate', 3e9, 'ship.rate', 'whole nanoseconds'),
        ('ship.rate', 0.5, 'ship.rate', 'at most 1 s are interpolated. Use 1.0 Hz or more'),
        ('ship', SEA | {'rate': 0.8}, 'ship.rate', 'leaves 1.25 s between samples'),
        ('ship', FAST | {'rate': 0.5}, 'ship.rate', 'Use more than 1.33333 Hz, two samples in'),
        ('log', {'interval': 0.13}, 'log.interval', 'Use 0.1 s'),
        ('log', {'interval': 1e-10}, 'log.interval', 'nanoseconds'),
        ('log', {'interval': 7.0}, 'log.interval', 'Use 6 s'),
        ('drift.observation_interval', 60.5, 'drift.observation_interval', 'Use 60 or 61 s'),
        ('duration', 0.5, 'duration', 'Use 1 s'),
        ('starts_at', 2147483400.0, 'duration', '2147483647'),
        ('voyage.sails_at', 600.0, 'voyage.arrives_at', 'later than voyage.sails_at, 600.0'),
        ('voyage.sails_at', 600 - 1e-10, 'voyage.arrives_at', 'by a nanosecond or more'),
        ('voyage.arrives_at', 1e300, 'voyage.arrives_at', 'at most 2147483647'),
        ('ship', storm(1e12), 'ship.weather.states[0].at', 'at most 2147483647'),
        ('ship', SEA | {'sea': MIRROR}, 'ship.sea.significant_wave_height', 'at least 1e-30'),
        ('ship', SEA | {'sea': TIDE}, 'ship.sea.peak_period', 'at most 1e+30'),
        ('ship', WAVES | {'height': 1e300}, 'ship.height', 'at most 1e+30'),
        ('voyage.arrives_at', REMOVED, 'voyage.arrives_at', 'or `speed: …` [m/s]'),
        ('voyage.speed', 3.0, 'voyage.speed', 'does not go with voyage.arrives_at, 600.0 s'),
        ('voyage.track', 'great circle', 'voyage.track', "must be 'geodesic' or 'rhumb'"),
        ('voyage.arrival', [90.0, 0.0], 'voyage.arrival', 'nearer to a pole than 89.68°'),
        ('voyage.waypoints', [[-89.7, 0.0]], 'voyage.waypoints[0]', 'nearer to a pole'),
        ('voyage.waypoints', [20.0, 30.0], 'voyage.waypoints[0]', 'mapping'),
        ('voyage.waypoints', [{'at': 9.0}], 'voyage.waypoints[0].place', 'is missing'),
        ('voyage.waypoints', [[50.0, -1.0]], 'voyage.waypoints[0]', 'as voyage.departure'),
        ('voyage.waypoints', [[50.0 + 1e-12, -1.0]], 'voyage.waypoints[0]', 'as voyage.departure'),
        (
            'voyage.waypoints',
            [[9, 180], [9, -180]],
            'voyage.waypoints[1]',
            'as voyage.waypoints[0]',
        ),
        ('voyage.waypoints', [[18.0, -77.0]], 'voyage.arrival', 'Leave one of them out'),
        ('ship.recorded.passband', [0.4, 0.02], 'ship.recorded.passband', 'Use [0.02, 0.4]'),
        ('ship.recorded.passband', [0.2, 0.2], 'ship.recorded.passband', 'must rise'),
        ('ship.recorded.passband', [0.02, 10.0], 'ship.recorded.passband', '10 Hz'),
        ('ship.recorded.scale', 0.0, 'ship.recorded.scale', 'stops all motion'),
        ('ship.recorded.topic', 'imu', 'ship.recorded.time_column', 'Leave out topic'),
        ('ship.recorded.roll_column', REMOVED, 'ship.recorded.roll_column', 'for a bag give'),
        ('ship', {'kind': 'components'}, 'ship.components', 'there is no heave either'),
        ('ship', FAST | {'rate': 1.0}, 'ship.components[0].period', 'two steps'),
        ('ship', WAVES | {'heave': []}, 'ship.heave', 'at least 1'),
        ('ship', SEA | {'rate': 1.0, 'sea': CHOP}, 'ship.sea.peak_period', 'two steps'),
        ('ship', SEA | {'sea': FLAT}, 'ship.sea.gamma', 'bretschneider'),
        ('ship.recorded', FORCES, 'ship.recorded.scale', ''),
        ('drift.covariates', ['temprature'], 'drift.covariates[0]', 'did you mean temperature?'),
        ('ship', DEGREES, 'ship.components', 'radians, not degrees'),
    ],
)
def test_refused(path: str, value: object, key: str, said: str) -> None:
    error = refusal((path, value))
    assert error.key == key
    assert error.file == 'bad.yaml'
    message = str(error)
    assert message.startswith(f'bad.yaml: {key}')
    assert said in message
    if error.value is not ABSENT:
        assert f'{key} = ' in message
    assert error.remedy.endswith('.')


@pytest.mark.parametrize('ship', [{'kind': 'still'}, SEA], ids=lambda ship: ship['kind'])
def test_only_an_unfitting_log_interval_is_refused(ship: Any) -> None:
    """7 s divides neither 600 nor 60 s. The interval in the remedy divides both."""
    asked = [('ship', ship), ('drift.observation_interval', 60.0)]
    for interval in (7.0, 0.13):
        error = refusal(*asked, ('log', {'interval': interval}))
        assert [each.key for each in error.problems] == ['log.interval']
        for near in re.findall(r'[\d.]+', error.remedy.removesuffix('.')):
            parse_scene(changed(*asked, ('log', {'interval': float(near)})), 'good.yaml')


def test_the_rate_in_a_remedy_is_accepted() -> None:
    for rate, interval in ((8.3333333, 1.0), (7.0, 0.04), (0.3, 0.1), (1500.0, 1.0)):
        log = ('log', {'interval': interval})
        error = refusal(('ship', WAVES | {'rate': rate}), log)
        near = re.search(r'for example ([\d.]+) Hz', error.remedy)
        assert near, error.remedy
        parse_scene(changed(('ship', WAVES | {'rate': float(near[1])}), log), 'good.yaml')


def test_a_time_that_alone_does_not_fit_the_log_is_refused() -> None:
    error = refusal(('duration', 599.5), ('drift.observation_interval', 60.5))
    assert [each.key for each in error.problems] == ['duration', 'drift.observation_interval']


def test_a_voyage_at_some_speed_goes_somewhere() -> None:
    error = refusal(
        ('voyage.arrives_at', REMOVED), ('voyage.speed', 1.0), ('voyage.arrival', [50.0, -1.0])
    )
    assert error.key == 'voyage.arrival'
    assert 'Give arrives_at in place of speed' in error.remedy


def test_a_rhumb_line_half_round_the_globe_has_two_sides() -> None:
    error = refusal(('voyage.track', 'rhumb'), ('voyage.arrival', [18.0, 179.0]))
    assert error.key == 'voyage.arrival'
    assert 'to the east and to the west are equally long' in str(error)


def test_a_scene_that_ends_in_port_is_refused_unless_cut(tmp_path: Path) -> None:
    content = good() | {'ship': {'kind': 'still'}}
    content['voyage'] |= {'sails_at': 700.0, 'arrives_at': 900.0}
    file = tmp_path / 'port.yaml'
    file.write_text(yaml.safe_dump(content))
    with pytest.raises(SceneError, match='after the end of the scene') as caught:
        load_scene(file)
    assert (caught.value.key, caught.value.value) == ('voyage.sails_at', 700.0)
    load_scene(file, duration=600.0)
    content['voyage']['sails_at'] = 600.0
    file.write_text(yaml.safe_dump(content))
    load_scene(file)


def test_a_still_ship_refuses_a_wheel_that_never_moves() -> None:
    error = refusal(('ship', {'kind': 'still'}), ('trochlea.release_angle', 0.0))
    assert error.key == 'trochlea.release_angle'


def test_all_problems_are_said_the_first_in_the_attributes() -> None:
    error = refusal(('duration', -1.0), ('trochlea.inertia', 'heavy'), ('sip', 1))
    assert [problem.key for problem in error.problems] == ['duration', 'trochlea.inertia', 'sip']
    assert (error.key, error.value) == ('duration', -1.0)
    assert len(str(error).splitlines()) == 3


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('', 'is empty'),
        ('# only a comment\n', 'is empty'),
        ('- 1\n- 2\n', 'is a list'),
        ('hello', 'is a text'),
        ('3.5', 'is a number'),
        ('a: 1\nb: [1, 2\nc: 3\n', 'line 3, column 2'),
        ('a: 1\n\tb: 2\n', 'line 2, column 1'),
        ('duration: 1\nname: x\nduration: 2\n', "line 3, column 1: the key 'duration' com"),
        ('drag: {viscous: 0, viscous: 1}\n', "'viscous' comes twice"),
        ('1: 2\n', 'a key must be a word'),
        ('? [a]\n: 2\n', 'a key must be a word'),
        ('a: &x 1\nb: *x\n', 'anchors and aliases'),
        ('a: !!python/object:os.system {}\n', 'the tag'),
        ('a: !mine 3\n', 'the tag'),
        ('a: !!int "three"\n', 'cannot be read as int'),
        ('a: ' + '9' * 5000 + '\n', 'cannot be read as int'),
        ('a: 1\n---\nb: 2\n', 'line 2'),
        ('a: \x00', 'YAML syntax'),
        ('[' * 5000 + ']' * 5000, 'nest'),
        ('[' * 30 + ']' * 30, 'is nested more than 20 deep'),
    ],
)
def test_text_that_is_no_scene(text: str, said: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_scene(text, 'bad.yaml')
    assert said in str(caught.value)
    assert str(caught.value).startswith('bad.yaml: ')
    assert len(str(caught.value)) < 500


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    binary = tmp_path / 'binary.yaml'
    binary.write_bytes(b'\xff\xfe\x00')
    large = tmp_path / 'large.yaml'
    large.write_bytes(b'#' * 1_000_001)
    bag = tmp_path / 'bag'
    bag.mkdir()
    (bag / 'bag_0.mcap').touch()
    for name, said in (
        (tmp_path / 'none.yaml', 'no such file'),
        (binary / 'within.yaml', 'no such file'),
        (tmp_path, 'is a folder'),
        (bag, 'is a bag. .* read by: tauto replay'),
        (binary, 'is not UTF-8 text'),
        (large, 'larger than'),
        ('a\0b', 'cannot be read'),
        ('measurd', 'Did you mean measured?'),
    ):
        with pytest.raises(SceneError, match=said) as caught:
            load_scene(name)
        assert caught.value.file == str(name)


def test_an_empty_name_is_refused_as_such() -> None:
    with pytest.raises(UsageError, match='scene: is empty'):
        load_scene('')


def test_a_key_of_a_section_that_a_name_stands_for_says_so() -> None:
    with pytest.raises(
        SceneError, match=r"scene: ship\.hull is 'deptford'\. Name a key of the scene"
    ):
        load_scene('portsmouth_jamaica', **{'ship.hull.length': 34.0})


@pytest.mark.parametrize('value', [-1.0, 0.5, '600', float('nan')])
def test_a_refused_override_is_not_the_scene_s_own(value: object) -> None:
    with pytest.raises(SceneError, match=r"duration is given, in place of the scene's") as caught:
        load_scene('measured', duration=value)
    assert caught.value.key == 'duration'


@pytest.mark.parametrize('path', ['none.csv', 'folder', 'shipped:none.csv', 'shipped:../x.csv'])
def test_data_that_are_not_there(tmp_path: Path, path: str) -> None:
    (tmp_path / 'folder').mkdir()
    content = good()
    content['ship']['recorded']['path'] = path
    content['trochlea']['cam'] = {'kind': 'table', 'path': path}
    scene = tmp_path / 'scene.yaml'
    scene.write_text(yaml.safe_dump(content))
    with pytest.raises(SceneError) as caught:
        load_scene(scene)
    keys = {problem.key for problem in caught.value.problems}
    assert keys == {'ship.recorded.path', 'trochlea.cam.path'}
    assert path.removeprefix('shipped:') in str(caught.value)


@pytest.mark.parametrize(
    ('change', 'key', 'said'),
    [
        ({'ship.speed': 20.0}, 'ship.speed', 'the voyage gives the speed'),
        ({'ship.hull': {'shape': 'sloop', 'length': 440.0}}, 'ship.hull.length', 'mean 44'),
    ],
)
def test_a_ship_of_a_passage_is_refused_by_her_own_key(change, key, said):
    with pytest.raises(SceneError, match=said) as caught:
        ShipMotion(load_scene('portsmouth_jamaica', **change))
    assert caught.value.key == key


def test_more_values_than_a_scene_has_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A megabyte of small lists would take a third of a gigabyte, and many seconds."""
    monkeypatch.setattr(files, '_MOST_VALUES', 1_000)
    assert read_mapping(f'a: [{"1," * 900}1]', 'few') == {'a': [1] * 901}
    with pytest.raises(SceneError, match=r'has more than 1,000 values.*Put numbers into a file'):
        read_mapping(f'a: [{"1," * 1_000}1]', 'many')


def test_of_thousands_of_unknown_keys_the_first_hundred_are_told() -> None:
    text = ''.join(f'a{k}: 1\n' for k in range(2_000))
    with pytest.raises(SceneError) as caught:
        parse_scene(text, 'many')
    assert len(caught.value.problems) == 100
