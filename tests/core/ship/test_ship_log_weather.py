"""Seas grown from a log's wind: against published heights and the method's own closed forms."""

import math
import pickle

import numpy as np
import pytest

from tauto_core.samples import (
    JOINT_STATES,
    LONGITUDE_ERROR,
    READING,
    SHIP_FIX,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    merged,
)
from tauto_core.scene import load_scene
from tauto_core.scene.sections import has_wind
from tauto_core.ship.weathers import log as weather
from tauto_core.ship.weathers.log import fetch_of_height, fetch_of_hours, grown, grown_seas
from tauto_core.voyage import ShipSource, pipeline

# WMO-No. 306: probable height of waves in the open sea, Beaufort 3 to 11 [m], at CLIWOC's speeds
PROBABLE = {
    4.6: 0.6,
    6.7: 1.0,
    9.3: 2.0,
    12.3: 3.0,
    15.4: 4.0,
    19.0: 5.5,
    22.6: 7.0,
    26.8: 9.0,
    30.9: 11.5,
}


@pytest.mark.parametrize(('wind', 'height'), PROBABLE.items())
def test_a_day_of_wind_makes_the_probable_height_of_the_wmo(wind, height):
    ((sea, swell),) = grown_seas([0.0], [wind], [270.0])
    assert sea.height == pytest.approx(height, rel=0.15)
    assert swell.height == 0.0


def test_wind_that_blows_on_makes_the_sea_of_the_whole_time():
    twice = grown_seas([0.0, 24.0], [10.0, 10.0], [270.0, 300.0])
    once = grown(fetch_of_hours(48.0, 10.0), 10.0)
    assert twice[1][0][:2] == pytest.approx(once, rel=1e-12)
    assert twice[1][1].height == 0.0


def test_growth_ends_with_largest_fetch_and_height():
    sea = grown_seas([24.0 * day for day in range(30)], [10.0] * 30, [0.0] * 30)[-1][0]
    assert sea[:2] == grown(weather.LARGEST_FETCH_M, 10.0)
    assert grown(1e12, 10.0)[0] == pytest.approx(0.30 * 100.0 / 9.80665, rel=1e-3)


def test_the_fetch_of_a_height_is_the_inverse_of_growth():
    for fetch in (1e4, 3e5, 4e6):
        assert fetch_of_height(grown(fetch, 8.0)[0], 8.0) == pytest.approx(fetch, rel=1e-9)


def test_a_sea_that_the_wind_leaves_is_a_swell_that_decays():
    (first, _), (second, swell), (third, older) = grown_seas(
        [0.0, 24.0, 48.0], [12.0, 8.0, 0.5], [270.0, 0.0, 0.0]
    )
    assert swell == (first.height * math.exp(-24.0 / 36.0), first.period, 270.0)
    assert second[:2] == grown(fetch_of_hours(24.0, 8.0), 8.0)
    assert third.height == 0.0
    # added in energy, each decayed over the day, with period and direction of the higher
    parts = swell.height * math.exp(-24.0 / 36.0), second.height * math.exp(-24.0 / 36.0)
    assert older.height == pytest.approx(math.hypot(*parts), rel=1e-12)
    higher = swell if parts[0] > parts[1] else second
    assert older[1:] == higher[1:]


def test_the_passage_of_the_esperance_has_the_seas_of_the_method():
    """Worked out apart from this code: 1.25 and 4.67 m of wind sea, 0.43 and 2.40 m of swell."""
    log = load_scene('esperance_to_the_cape').voyage.log
    windy = [
        (24.0 * day, entry[4] or 0.0, entry[3] or 0.0)
        for day, entry in zip(log.days, log.entries, strict=True)
        if has_wind(entry)
    ]
    seas = grown_seas(*zip(*windy, strict=True))
    sea, swell = np.array([[wind.height, far.height] for wind, far in seas]).T
    found = sea.mean(), sea.max(), swell.mean(), swell.max()
    assert found == pytest.approx((1.25, 4.67, 0.43, 2.40), abs=0.006)


def test_wind_sea_and_swell_keep_directions_at_a_turn():
    scene = load_scene('esperance_to_the_cape')
    states = scene.ship.states(scene)
    log = scene.voyage.log
    turned = [state for state in states if state.key == 'voyage.log.entries[13]']
    before, after = turned
    assert (after.at_ns - before.at_ns) / 1e9 == 600.0
    assert before.speed != after.speed
    # wind from 113 degrees: its sea runs to 293
    wind_from = log.entries[13][3]
    for state, at_ns in ((before, before.at_ns), (after, after.at_ns)):
        course = scene.ship.setting(scene).passage_for('', None).course(at_ns)
        wanted = (course - math.radians(wind_from + 180.0)) % math.tau
        assert state.heading == pytest.approx(wanted, abs=1e-12)
        assert state.swell is not None
        assert state.swell.heading != state.heading
        assert state.height == pytest.approx(
            math.hypot(state.sea.significant_wave_height, state.swell.height), rel=1e-12
        )


def test_distant_swell_is_there_only_if_given():
    far = {'significant_wave_height': 1.5, 'peak_period': 11.0, 'waves_to': 1.0}
    plain = load_scene('esperance_to_the_cape')
    asked = load_scene('esperance_to_the_cape', **{'ship.weather.background_swell': far})
    for one, other in zip(plain.ship.states(plain), asked.ship.states(asked), strict=True):
        if one.key.startswith('voyage.log.entries'):
            assert other.height == pytest.approx(math.hypot(one.height, 1.5), rel=1e-9)


def sailed(scene, parts=1):
    """Return motion, temperature, positions and readings. Each part goes on from a saved state."""
    source, stages, found = ShipSource(scene), pipeline(scene), []
    share = -(-source.total // parts)
    while source.produced < source.total:
        if source.produced:
            saved = pickle.dumps((source.state(), stages.state()))
            source, stages = ShipSource(scene), pipeline(scene)
            for each, state in zip((source, stages), pickle.loads(saved), strict=True):
                each.restore(state)
        found.append(stages.feed(source.produce(share)))
    found.append(stages.finish())
    whole = merged(found)
    return {
        'stamp': whole[READING].stamp_ns,
        'reading': whole[READING].time_ref_ns,
        'wheel': whole[JOINT_STATES].position,
        'position': whole[SHIP_FIX].longitude,
        'temperature': whole[SHIP_TEMPERATURE].temperature,
        'error': whole[LONGITUDE_ERROR].position,
    }, whole[SHIP_IMU].angular_velocity


def test_a_logged_passage_in_two_parts_has_the_bits_of_one():
    """Resumed, or shorter, or with a log that ends soon after the run, not eight hours later."""
    entries = [
        (f'1791-10-26T{hour:02}:00', 28.0 - 0.05 * hour, -16.5, 15.0 * hour, 9.0, 20.0 + hour)
        for hour in (8, 10, 12, 14, 18, 22)
    ]
    keys = {'ship.rate': 4.0, 'log.interval': 100.0}
    made = [
        load_scene(
            'esperance_to_the_cape',
            **keys,
            duration=duration,
            voyage={
                'log': {
                    'source': 'made up',
                    'passage': 'It',
                    'harbour_days': 0.02,
                    'entries': entries[:count],
                }
            },
        )
        for count, duration in ((len(entries), 12_000.0), (4, 12_000.0), (4, 9_000.0))
    ]
    found, motion = sailed(made[0])
    assert len(found['reading']) == 121
    assert np.ptp(found['wheel']) > 1.0
    assert np.ptp(found['temperature']) > 1.0
    assert np.abs(motion[10_000:]).max() > 1e-2
    for other, moved in (sailed(made[0], 2), sailed(made[1]), sailed(made[2])):
        assert moved.tobytes() == motion[: len(moved)].tobytes()
        for name, values in other.items():
            assert values.tobytes() == found[name][: len(values)].tobytes(), name
    assert len(other['reading']) == 91


def test_hull_ignores_ripples_and_limits_fast_legs():
    scene = load_scene('esperance_to_the_cape')
    calm = [entry for entry in scene.voyage.log.entries if entry[4] == 1.0]
    assert calm
    most = 0.25 * math.sqrt(scene.g * 44.0)
    for state in scene.ship.states(scene):
        assert 0.0 <= state.speed <= most * (1.0 + 1e-9)
        if state.sea is not None:
            assert state.sea.peak_period > 1.6
