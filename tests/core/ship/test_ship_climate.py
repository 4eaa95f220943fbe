"""Weather drawn from a climate, against the closed forms of its process (weather.md)."""

import math
from typing import Any

import numpy as np
import pytest

from tauto_core.scene import Scene, SceneError, load_scene
from tauto_core.ship.weathers import WeatherSetting
from tauto_core.ship.weathers.climate import CLIMATES

DAY_S = 86_400.0
ROLL = {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7}
OWN = {
    'median_wave_height': 2.0,
    'log_deviation': 0.4,
    'correlation_time': 100_000.0,
    'steepness': 0.03,
}
VOYAGE = {
    'departure': [50.79, -1.11],
    'waypoints': [[32.6, -16.9]],
    'arrival': [17.93, -76.84],
    'sails_at': 5.0 * DAY_S,
    'arrives_at': 55.1 * DAY_S,
}


def scene_of(
    *regions: dict[str, Any], seed: int = 1, days: float = 400.0, voyage=None, **weather
) -> Scene:
    weather = {'kind': 'climate', 'regions': list(regions), **weather}
    # a rate is given, since choosing one takes the sea of every state
    ship = {'kind': 'sea', 'weather': weather, 'roll': ROLL, 'heave': True, 'rate': 20.0}
    return load_scene('ideal', ship=ship, seed=seed, duration=days * DAY_S, voyage=voyage)


def states_of(scene: Scene):
    ship = scene.ship
    return ship.weather.resolved(WeatherSetting(scene, ship.weather, 0.5 * math.pi, 0.0))


def test_height_is_log_normal_with_the_given_memory():
    """Four standard deviations. Of n states n (1 − ρ)/(1 + ρ) count, with ρ² in squares."""
    scene = scene_of(OWN)  # to load it takes longer than to draw its seas
    seeds = (scene.model_copy(update={'seed': seed}) for seed in range(20))
    heights = [[state.height for state in states_of(each)] for each in seeds]
    x = np.log(np.array(heights) / 2.0) / 0.4
    rho = math.exp(-21_600.0 / 100_000.0)
    worth = x.size * (1.0 - rho) / (1.0 + rho)
    assert abs(x.mean()) < 4.0 / math.sqrt(worth)
    square = rho * rho
    worth_of_squares = x.size * (1.0 - square) / (1.0 + square)
    assert abs(np.mean(x * x) - 1.0) < 4.0 * math.sqrt(2.0 / worth_of_squares)
    assert abs(np.mean(x**4) - 3.0) < 4.0 * math.sqrt(96.0 / worth_of_squares)
    for lag in (1, 2, 4, 12):
        found = np.mean(x[:, lag:] * x[:, :-lag])
        assert abs(found - rho**lag) < 4.0 * math.sqrt(2.0 / worth_of_squares), lag
    noise = (x[:, 1:] - rho * x[:, :-1]) / math.sqrt(1.0 - rho * rho)
    n = noise.size
    assert abs(noise.mean()) < 4.0 / math.sqrt(n)
    assert abs(noise.var() - 1.0) < 4.0 * math.sqrt(2.0 / n)
    assert abs(np.mean(noise[:, 1:] * noise[:, :-1])) < 4.0 / math.sqrt(n)
    assert abs(np.mean(noise[:, 1:] * x[:, :-2])) < 4.0 / math.sqrt(n)


@pytest.mark.parametrize('days', [10.0, 10.1875])
def test_a_seed_draws_the_same_weather_however_long_the_scene(days):
    """The last state is at the end or later, and the sea is the same as in a longer scene."""
    long, short, other = (
        scene_of(OWN, seed=seed, days=length) for seed, length in ((3, 40.0), (3, days), (4, days))
    )
    heights = [[state.height for state in states_of(each)] for each in (long, short, other)]
    assert heights[0][: len(heights[1])] == heights[1]
    assert not set(heights[1]) & set(heights[2])
    assert states_of(short)[-1].at_ns >= short.duration_ns


def test_scene_that_ends_at_sea_has_weather_of_the_whole():
    """Its last change goes on to the next state at sea, not to the port of arrival."""
    port = {'still': True}
    whole, part = (scene_of(OWN, days=days, voyage=VOYAGE, port=port) for days in (60.0, 10.0625))
    states = [states_of(each) for each in (whole, part)]
    assert [each.height for each in states[1][:-1]] == [
        each.height for each in states[0][: len(states[1]) - 1]
    ]
    assert states[1][-2].at_ns >= part.duration_ns


@pytest.mark.parametrize('arrives_at', np.arange(3000.0, 4300.0, 400.0).tolist())
def test_the_last_change_into_port_is_never_too_quick(arrives_at):
    """With states ten minutes apart the arrival may come shortly after one."""
    voyage = {**VOYAGE, 'sails_at': 1000.0, 'arrives_at': arrives_at}
    scene = scene_of(OWN, days=0.05, voyage=voyage, port={'still': True}, interval=600.0)
    times = [state.at_ns for state in scene.ship.states(scene)]
    assert np.min(np.diff(times)) >= 600 * 10**9


def test_each_region_has_its_climate_and_the_departure_goes_on():
    """A region with another median has the same sea, only higher in proportion."""
    plain = states_of(scene_of(OWN, days=30.0))
    higher = {**OWN, 'median_wave_height': 6.0, 'at': 10.0 * DAY_S}
    changed = states_of(scene_of(OWN, higher, days=30.0))
    for before, after in zip(plain, changed, strict=True):
        factor = 3.0 if after.at_ns >= 10 * 86_400 * 10**9 else 1.0
        assert after.height == pytest.approx(factor * before.height, rel=1e-14)


def test_the_ports_have_their_sea_and_the_way_its_regions():
    regions = {'climate': 'north_atlantic_winter'}, {'climate': 'trades', 'waypoint': 1}
    port = {'significant_wave_height': 0.3, 'peak_period': 5.0}
    scene = scene_of(*regions, days=60.0, voyage=VOYAGE, port=port, follow_route=True)
    states = scene.ship.states(scene)
    heights = [state.height for state in states]
    assert [states[k].at_ns / 86_400e9 for k in (0, 1, 2, -1)] == [0.0, 5.0, 5.25, 55.1]
    assert (heights[0], heights[1], heights[-1]) == (0.3, 0.3, 0.3)
    assert 0.3 not in heights[2:-1]
    assert [states[k].speed for k in (0, 1, -1)] == [0.0, 0.0, 0.0]
    assert len({state.speed for state in states[2:-1]}) == 1
    steep = [math.tau * each.height / (scene.g * each.sea.peak_period**2) for each in states]
    first = states[2:-1][0], states[2:-1][-1]
    assert steep[2] == pytest.approx(CLIMATES['north_atlantic_winter'].steepness, rel=1e-13)
    assert steep[-2] == pytest.approx(CLIMATES['trades'].steepness, rel=1e-13)
    # to the south-west against a sea from the west, then with the trade wind behind
    assert math.cos(first[0].heading) < -0.5
    assert math.cos(first[1].heading) > 0.9


def test_numbers_of_ones_own_replace_those_of_a_known_climate():
    scene = scene_of({'climate': 'trades', 'log_deviation': 0.0}, days=2.0)
    assert {state.height for state in states_of(scene)} == {CLIMATES['trades'].median_wave_height}


def test_a_sea_higher_than_any_is_refused_before_anything_starts():
    scene = scene_of({**OWN, 'median_wave_height': 25.0, 'log_deviation': 1.5}, days=30.0)
    with pytest.raises(SceneError, match=r'regions\[0\].*higher than any known \(30 m\)'):
        scene.ship.channels(scene)
