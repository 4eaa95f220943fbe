"""Weather in scene files: records of buoys, their gaps, and refusals."""

import math
import re
from pathlib import Path
from typing import Any

import pytest

from tauto_core.scene import Scene, SceneError, load_scene, parse_scene, scene_yaml
from tauto_core.ship import ShipMotion

ROLL = {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7}
HIGH = {'significant_wave_height': 2.5, 'peak_period': 9.0}
# rows 2, 3 and 5 have no waves
BUOY = """\
time_utc,significant_wave_height_m,peak_period_s,waves_from_deg
2019-01-01T00:00,2.50,9.09,270
2019-01-01T00:10,nan,nan,nan
2019-01-01T01:00,MM,MM,MM
2019-01-01T02:00,3.00,10.00,280
2019-01-01T03:00,3.10,,
2019-01-01T04:00,3.20,10.81,290
"""
HEAD, *LINES = BUOY.splitlines()


NORTH = {'departure': [0.0, 0.0], 'arrival': [10.0, 0.0], 'sails_at': 0.0, 'arrives_at': 1e6}
TRADES = {'climate': 'trades'}
LACKS_ONE = BUOY.replace('10.00,280', '10.00,')


def scene_of(weather: dict[str, Any], duration: float = 3600.0, **keys: Any) -> Scene:
    ship = {'kind': 'sea', 'weather': weather, 'roll': ROLL, 'heave': True, 'rate': 20.0}
    return load_scene('ideal', ship=ship, duration=duration, **keys)


def record(folder: Path, text: str, **keys: Any) -> dict[str, Any]:
    file = folder / 'buoy.csv'
    file.write_text(text, encoding='utf-8')
    return {'kind': 'record', 'path': str(file), **keys}


def refusal(weather: dict[str, Any], **keys: Any) -> str:
    with pytest.raises(SceneError) as caught:
        ShipMotion(scene_of(weather, **keys))
    return str(caught.value)


def climate(*regions, **keys):
    return {'kind': 'climate', 'regions': list(regions), **keys}


def states_of(*states: dict[str, Any], **keys: Any) -> dict[str, Any]:
    return {'kind': 'states', 'states': list(states), **keys}


def test_a_record_is_read_and_gaps_are_bridged(tmp_path: Path) -> None:
    weather = scene_of(record(tmp_path, BUOY)).ship.weather
    assert weather.source == 'buoy.csv'
    assert weather.time == (0.0, 7200.0, 14_400.0)
    assert weather.significant_wave_height == (2.5, 3.0, 3.2)
    assert weather.peak_period == (9.09, 10.0, 10.81)
    # from 270 is to 90
    assert weather.waves_to == pytest.approx([math.radians(each) for each in (90, 100, 110)])
    assert weather.gaps_bridged == 0
    # the latest row first, without a direction, from a time between two rows
    text = '\n'.join([HEAD, *reversed(LINES)]).replace('290', '')
    later = scene_of(record(tmp_path, text, begins='2019-01-01T01:30'), 1800.0).ship.weather
    assert later.time == (-5400.0, 1800.0, 9000.0)
    assert later.waves_to is None


def test_seconds_count_from_the_first_row(tmp_path: Path) -> None:
    rows = ''.join(f'{1000 + 3600 * k},{1 + 0.1 * k:.1f},8.0\n' for k in (0, 1, 2, 4, 5))
    asked = record(tmp_path, f'time_s,significant_wave_height_m,peak_period_s\n{rows}')
    weather = scene_of(asked, duration=18_000.0).ship.weather
    assert weather.time == (0.0, 3600.0, 7200.0, 14_400.0, 18_000.0)
    assert weather.gaps_bridged == 1


def test_a_bag_needs_no_file_of_the_record(tmp_path: Path) -> None:
    scene = scene_of(record(tmp_path, BUOY))
    (tmp_path / 'buoy.csv').unlink()
    again = parse_scene(scene_yaml(scene), 'bag')
    assert again == scene
    assert str(tmp_path) not in scene_yaml(scene)
    assert ShipMotion(again).metadata['source'] == 'buoy.csv'


def test_a_record_turns_the_waves_against_the_course(tmp_path: Path) -> None:
    asked = record(tmp_path, BUOY, follow_route=True)
    scene = scene_of(asked, voyage=NORTH)
    found = scene.ship.states(scene)
    # bound north: waves to the east run to starboard
    expected = [math.radians(360.0 - each) for each in (90, 100, 110)]
    assert [state.heading for state in found] == pytest.approx(expected, abs=1e-9)
    assert found[0].speed == 0.0
    assert found[1].speed == pytest.approx(1105854.8 / 1e6, rel=1e-4)


def test_a_row_without_direction_is_left_out_on_a_route(tmp_path: Path) -> None:
    """Its neighbours keep their headings, and the missing one does not turn all waves abeam."""
    asked = record(tmp_path, LACKS_ONE, follow_route=True)
    scene = scene_of(asked, voyage=NORTH)
    assert scene.ship.weather.time == (0.0, 14_400.0)
    headings = [state.heading for state in scene.ship.states(scene)]
    assert headings == pytest.approx([math.radians(each) for each in (270, 250)], abs=1e-9)
    motion = ShipMotion(scene)
    assert motion.metadata['rows_without_direction'] == 1
    assert [each for each in motion.warnings if '1 row of buoy.csv without a direction' in each]
    begins = record(tmp_path, BUOY.replace('9.09,270', '9.09,'), follow_route=True)
    assert scene_of(begins, voyage=NORTH).ship.weather.time == (0.0, 7200.0)


def test_the_gap_of_a_missing_direction_is_bridged(tmp_path: Path) -> None:
    asked = record(tmp_path, LACKS_ONE, follow_route=True, max_gap=14_399.0)
    said = refusal(asked, voyage=NORTH)
    assert 'line 7: comes 14400 s after the last row with waves and their direction' in said


def test_where_no_row_has_a_direction_a_warning_says_so(tmp_path: Path) -> None:
    text = re.sub('(270|280|290)', '', BUOY)
    asked = record(tmp_path, text, follow_route=True)
    scene = scene_of(asked, voyage=NORTH)
    assert scene.ship.weather.time == (0.0, 7200.0, 14_400.0)
    motion = ShipMotion(scene)
    assert [each for each in motion.warnings if 'all waves have the heading ship.heading' in each]


@pytest.mark.parametrize(
    'keys', [{}, {'rao': {'path': 'shipped:supply_rao/supply_rao.csv', 'heading': 1.75}}]
)
def test_directions_that_do_not_matter_may_be_missing(keys, tmp_path):
    """The route is not followed, or a response operator has a heading of its own."""
    asked = record(tmp_path, LACKS_ONE, follow_route=bool(keys))
    filtered = keys or {'roll': ROLL}
    ship = {'kind': 'sea', 'weather': asked, 'heave': True, 'rate': 20.0, **filtered}
    scene = load_scene('ideal', ship=ship, duration=3600.0, voyage=NORTH)
    assert scene.ship.weather.time == (0.0, 7200.0, 14_400.0)
    assert not [each for each in ShipMotion(scene).warnings if 'direction' in each]


@pytest.mark.parametrize(
    ('text', 'keys', 'said'),
    [
        (BUOY.replace('9.09', '80'), {}, 'line 2, peak_period_s = 80.0: must be greater than 0'),
        (BUOY.replace('2.50', '-2'), {}, 'height_m = -2.0: must be greater than 0 and at most 30'),
        (BUOY.replace('270', '999'), {}, 'waves_from_deg = 999.0: must be at least 0 and at most'),
        (BUOY.replace('T02', 'T00'), {}, 'line 5: has the time of another row'),
        (BUOY.replace('2019-01-01T02', 'noon'), {}, "time_utc = 'noon:00': is not a date and tim"),
        (HEAD, {}, 'has no row with a wave height and a period'),
        ('', {}, 'column time_s: is missing'),
        (BUOY, {'begins': 'noon'}, "begins = 'noon': is not a date and time"),
        (BUOY, {'begins': '2021-01-01'}, 'is not within the record, from 2019-01-01T00:00 to'),
        (BUOY, {'format': 'ndbc'}, "format = 'ndbc': is not a key any more: all files are CSV"),
        (BUOY, {'max_gap': 7199.0}, 'line 5: comes 7200 s after the last row with waves; max_gap'),
    ],
)
def test_a_record_that_cannot_be_used_is_refused_by_line(text, keys, said, tmp_path):
    assert said in refusal(record(tmp_path, text, **keys))


def test_a_record_must_last_as_long_as_the_scene(tmp_path: Path) -> None:
    said = refusal(record(tmp_path, BUOY), duration=18_000.0)
    assert 'ship.weather.time = 14400.0' in said
    assert 'Set duration to at most 14400' in said
    coarse = {'log.interval': 7000.0, 'drift.observation_interval': 7000.0}
    said = refusal(record(tmp_path, BUOY), duration=21_000.0, **coarse)
    assert 'Set duration to at most 14000,' in said


def test_a_record_that_is_not_there_is_refused(tmp_path: Path) -> None:
    said = refusal({'kind': 'record', 'path': str(tmp_path / 'none.txt')})
    assert 'ship.weather.path' in said
    assert 'there is no such file' in said


@pytest.mark.parametrize(
    ('weather', 'said'),
    [
        (states_of(), 'ship.weather.states: has no waves'),
        (states_of({'at': 0.0, 'still': True}), 'ship.weather.states: has no waves'),
        (states_of(HIGH), 'states[0].at: is missing, and there is no waypoint'),
        (states_of({'at': 0.0, 'waypoint': 0, **HIGH}), 'states[0].at = 0.0: does not go with'),
        (states_of({'at': 0.0, 'peak_period': 9.0}), 'significant_wave_height: is missing'),
        (states_of({'at': 0.0, **HIGH, 'still': True}), 'does not go with still'),
        (states_of({'at': 0.0, **HIGH, 'waves_to': 1.0}), 'needs the course made good'),
        (
            states_of({'at': 0.0, **HIGH, 'waves_to': 1.0, 'heading': 1.0}, follow_route=True),
            'waves_to = 1.0: does not go with heading',
        ),
        (states_of({'at': 0.0, **HIGH, 'speed': 1.0}, follow_route=True), 'speed = 1.0: does not'),
        (states_of({'at': 0.0, **HIGH}, follow_route=True), 'follow_route = True: needs a voyage'),
        (states_of({'waypoint': 0, **HIGH}), 'states[0].waypoint = 0: needs a voyage'),
        (states_of({'at': 0.0, **HIGH, 'peak_period': 0.05}), 'peak_period = 0.05: is not longer'),
        (states_of({'at': 0.0, **HIGH, 'peak_period': 0.3}), 'peak_period = 0.3: the sh'),
        (states_of({'at': 9.0, **HIGH}, {'at': 9.0, **HIGH}), 'states[1].at = 9.0: must be later'),
        (states_of({'at': 0.0, 'still': True}, {'at': 599.0, **HIGH}), 'at least 600 s'),
        (states_of({'at': 0.0, **HIGH, 'sped': 1.0}), 'Did you mean `speed`?'),
        ({'kind': 'squall'}, "ship.weather.kind = 'squall': unknown kind"),
        ({'kind': 'climate', 'regions': []}, 'regions = []: has 0 items, the limit is at least 1'),
        ({'kind': 'climate', 'regions': [{}]}, 'regions[0].median_wave_height: is missing'),
        (climate(TRADES, TRADES), 'regions[1].at: is missing, and there is no waypoint'),
        (climate(TRADES, port={'still': True}), 'ship.weather.port: needs a voyage'),
        (climate(TRADES, port={'peak_period': 5.0}), 'port.significant_wave_height: is missing'),
        ({'kind': 'climate', 'regions': [{'climate': 'doldrums'}]}, "climate = 'doldrums': must"),
    ],
)
def test_weather_that_cannot_be_is_refused_by_key(weather: dict[str, Any], said: str) -> None:
    assert said in refusal(weather)


def test_a_place_beyond_the_voyage_is_refused() -> None:
    said = refusal(states_of({'waypoint': 2, **HIGH}), voyage=NORTH)
    assert 'waypoint = 2: is not a place of the voyage, which has 2' in said


@pytest.mark.parametrize('keys', [{}, {'sea': {'spectrum': 'bretschneider', **HIGH}}])
def test_a_ship_has_one_sea_or_weather(keys: dict[str, Any]) -> None:
    ship = {'kind': 'sea', 'roll': ROLL, **keys}
    if keys:
        ship['weather'] = states_of({'at': 0.0, **HIGH})
    with pytest.raises(SceneError) as caught:
        load_scene('ideal', ship=ship)
    said = 'does not go with ship.sea' if keys else 'ship.sea: is missing, and there is no weather'
    assert said in str(caught.value)
