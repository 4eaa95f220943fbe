"""A ship in one sea after another: the states, and how they follow the route."""

import math
from typing import Any

import numpy as np
import pytest

from tauto_core.scene import Scene, load_scene
from tauto_core.ship import Passage, ShipMotion, bag_metadata
from tauto_core.ship.weathers import seas_at_once

S = 1_000_000_000
ROLL = {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7}
HIGH = {'significant_wave_height': 2.5, 'peak_period': 9.0}
LOW = {'significant_wave_height': 1.0, 'peak_period': 7.0}
CALM = {'still': True}
PORTS: dict[str, Any] = {
    'departure': [50.79, -1.11],
    'waypoints': [[32.6, -16.9]],
    'arrival': [17.93, -76.84],
}


def scene_of(*states: dict[str, Any], duration: float = 7200.0, voyage=None, **keys) -> Scene:
    weather = {'kind': 'states', 'states': list(states)}
    weather |= {name: keys.pop(name) for name in ('follow_route', 'spectrum') if name in keys}
    ship = {'kind': 'sea', 'weather': weather, 'roll': ROLL, 'heave': True, 'height': 3.0, **keys}
    return load_scene('ideal', ship=ship, duration=duration, voyage=voyage)


def one_sea(sea: dict[str, Any], duration: float = 7200.0, **keys) -> Scene:
    sea = {'spectrum': 'bretschneider', **sea}
    ship = {'kind': 'sea', 'sea': sea, 'roll': ROLL, 'heave': True, 'height': 3.0, **keys}
    return load_scene('ideal', ship=ship, duration=duration)


def test_weather_of_one_state_is_the_one_sea_bit_for_bit():
    for keys in ({}, {'heading': 2.0, 'speed': 5.0}):
        weather = ShipMotion(scene_of({'at': 100.0, **HIGH}, duration=300.0, **keys))
        alone = ShipMotion(one_sea(HIGH, duration=300.0, **keys))
        one, other = weather.produce(10**6), alone.produce(10**6)
        for name in ('stamp_ns', 'orientation', 'angular_velocity', 'linear_acceleration'):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_each_state_has_its_spectrum_and_phases():
    """Seas of the same height: the same bins and energy, but no frequency or phase in common."""
    states = {'at': 0.0, **HIGH}, {'at': 3600.0, **LOW}, {'at': 5400.0, **LOW}
    scene = scene_of(*states, {'at': 7200.0, **HIGH})
    heave = scene.ship.channels(scene).heave
    assert heave.sums == (0, 1, 1, 3)
    first, low, last = (heave.of(number) for number in (0, 1, 3))
    for sea, height in ((first, 2.5), (low, 1.0), (last, 2.5)):
        # 4 √(Σ a²/2) is set to Hs by one factor: a few roundings
        assert 4.0 * math.sqrt(0.5 * np.sum(sea.amplitude**2)) == pytest.approx(height, rel=1e-14)
    assert not np.isin(first.period, last.period).any()
    assert not np.isin(first.phase, last.phase).any()
    # a bin is 3.3 % wide
    np.testing.assert_allclose(first.period, last.period, rtol=0.034)


def test_speed_and_heading_follow_the_route():
    """Waves to the west meet a ship bound north from abeam."""
    voyage = {**PORTS, 'sails_at': 1000.0, 'arrives_at': 5_000_000.0}
    sea = {**HIGH, 'waves_to': 1.5 * math.pi}
    states = [{'waypoint': 0, **sea}, {'at': 1_000_000.0, **sea}, {'waypoint': 1, **sea}]
    scene = scene_of(*states, {'waypoint': 2, **sea}, voyage=voyage, follow_route=True)
    passage = Passage(scene, scene.voyage)
    found = scene.ship.states(scene)
    assert [state.at_ns for state in found] == [
        1000 * S,
        1_000_000 * S,
        passage.places_ns[1],
        5_000_000 * S,
    ]
    speed = passage.speed_m_s(passage.sails_ns + 1)
    assert [state.speed for state in found] == [0.0, speed, speed, 0.0]
    for state in found:
        apart = state.heading - (passage.course(state.at_ns) - 1.5 * math.pi)
        assert abs(math.remainder(apart, math.tau)) < 1e-12
    north = {'departure': [0.0, 0.0], 'arrival': [10.0, 0.0]}
    voyage = {**north, 'sails_at': 0.0, 'arrives_at': 1_000_000.0}
    scene = scene_of({'at': 1000.0, **sea}, voyage=voyage, follow_route=True)
    assert scene.ship.states(scene)[0].heading == pytest.approx(0.5 * math.pi, abs=1e-12)


def test_bag_has_the_weather():
    scene = scene_of({'at': 0.0, **CALM}, {'at': 3600.0, **HIGH, 'heading': 2.0, 'speed': 3.0})
    told = bag_metadata(scene)
    assert told['weather.kind'] == 'states'
    assert (told['weather.highest_m'], told['weather.seed']) == (2.5, scene.seed)
    names = 'at_s', 'significant_wave_height_m', 'peak_period_s', 'heading_rad', 'speed_m_s'
    assert told['weather.states'] == [
        dict(zip(names, numbers, strict=True))
        for numbers in ((0.0, 0.0, None, None, None), (3600.0, 2.5, 9.0, 2.0, 3.0))
    ]
    assert ShipMotion(scene).metadata['states'] == told['weather.states']


@pytest.mark.parametrize(
    ('states', 'expected'),
    [
        ([(0.0, HIGH)], 1.0),
        ([(0.0, HIGH), (3600.0, LOW)], 1.5),
        ([(0.0, CALM), (3600.0, HIGH), (7200.0, HIGH)], 1.0),
        ([(0.0, CALM), (3600.0, CALM), (7200.0, HIGH)], 0.5),
        ([(1800.0, LOW), (5400.0, HIGH)], 1.5),
    ],
)
def test_how_many_seas_are_summed(states, expected):
    scene = scene_of(*({'at': at, **sea} for at, sea in states))
    found = seas_at_once(scene.ship.states(scene), scene.duration_ns)
    assert found == pytest.approx(expected, rel=1e-15)


def test_predictions_go_by_the_highest_sea():
    scene = scene_of(
        {'at': 0.0, **LOW}, {'at': 3600.0, **HIGH, 'heading': 2.0}, {'at': 7200.0, **LOW}
    )
    rough = scene.ship.roughest(scene)
    assert (rough.sea.significant_wave_height, rough.heading, rough.weather) == (2.5, 2.0, None)
    assert one_sea(HIGH).ship.roughest(scene) == one_sea(HIGH).ship


def test_worst_seas_are_the_highest_and_the_fastest_met():
    """Short waves from ahead are met fastest, not shorter ones from astern or without height."""
    ahead = {'significant_wave_height': 1.2, 'peak_period': 6.0, 'heading': 3.1, 'speed': 3.0}
    scene = scene_of(
        {'at': 0.0, **HIGH},
        {'at': 3600.0, **ahead},
        {'at': 7200.0, **ahead, 'peak_period': 5.0, 'heading': 0.0},
        {'at': 10_800.0, **ahead, 'peak_period': 5.0, 'significant_wave_height': 0.01},
    )
    highest, fastest = scene.ship.worst_seas(scene)
    assert (highest.why, highest.figures['at_s']) == ('highest', 0.0)
    assert (fastest.why, fastest.figures['at_s']) == ('met fastest', 3600.0)
    assert fastest.ship.sea.peak_period == 6.0
    assert 0.0 < fastest.lasts_s < highest.lasts_s == scene.duration
    (only,) = scene_of({'at': 0.0, **HIGH}).ship.worst_seas(scene)
    assert only.why == 'highest and met fastest'
