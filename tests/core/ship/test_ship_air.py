"""The air and the box of the clock: against an integration, closed forms, and in any chunks."""

import math
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tauto_core.bags import read_bag
from tauto_core.checks.facts import scene_facts
from tauto_core.samples import SHIP_TEMPERATURE, TemperatureSamples, join
from tauto_core.scene import Scene, load_scene, parse_scene, scene_yaml
from tauto_core.scene.errors import SceneError
from tauto_core.ship.airs import ZONAL_CELSIUS, ZONAL_LATITUDES, BoxTemperature, zonal_celsius
from tauto_core.ship.passage import Passage
from tauto_core.voyage import ShipSource, replay, sail, summarise_bag

HOUR_S, DAY_S = 3600.0, 86_400.0
VOYAGE: dict[str, Any] = {
    'departure': [50.79, -1.11],
    'waypoints': [[36.97, -25.1], [17.1, -61.8]],
    'arrival': [17.93, -76.84],
    'sails_at': 2.0 * DAY_S,
    'arrives_at': 9.0 * DAY_S,
}
AT = [{'waypoint': n, 'celsius': c} for n, c in ((0, 6.0), (1, 19.0), (3, 27.5))]


def scene_of(air: dict[str, Any], days: float = 10.0, **keys: Any) -> Scene:
    keys = {'voyage': VOYAGE, 'gravity': 9.8, 'log': {'interval': 600.0}, **keys}
    drift = {'observation_interval': DAY_S / 2}
    return load_scene('ideal', duration=days * DAY_S, air=air, drift=drift, **keys)


def box(scene: Scene) -> np.ndarray:
    return BoxTemperature(scene).at(np.arange(scene.log_count))


def integrated(scene: Scene, mean, longitude, knots_s) -> np.ndarray:
    """Return the box at the logged instants by DOP853, from the start of the closed form."""
    air = scene.air
    assert air is not None

    def slope(t: float, y: np.ndarray) -> float:
        hour = (scene.starts_at + t) / HOUR_S + longitude(t) / 15.0
        swing = air.diurnal * math.cos(math.tau * (hour - air.warmest_hour) / 24.0)
        return (mean(t) + swing - y) / (air.box_hours * HOUR_S)

    times = scene.log.interval * np.arange(scene.log_count)
    reached, found = float(box(scene)[0]), np.empty(scene.log_count)
    edges = sorted({0.0, *(k for k in knots_s if 0.0 < k < times[-1]), times[-1]})
    for a, b in pairwise(edges):
        here = (times >= a) & (times <= b)
        at = np.unique(np.append(times[here], b))
        run = solve_ivp(slope, (a, b), [reached], 'DOP853', t_eval=at, rtol=1e-10, atol=1e-9)
        found[here], reached = run.y[0, : here.sum()], float(run.y[0, -1])
    return found


@pytest.mark.parametrize(('diurnal', 'box_hours'), [(0.0, 6.0), (4.0, 0.2), (5.0, 90.0)])
def test_the_box_is_that_of_an_integration_along_a_voyage(diurnal, box_hours) -> None:
    air = {'kind': 'route', 'at': AT, 'diurnal': diurnal, 'box_hours': box_hours}
    scene = scene_of(air)
    assert scene.voyage is not None
    passage = Passage(scene, scene.voyage)
    places_s = np.array(passage.places_ns) / 1e9

    def mean(t):
        return float(np.interp(t, places_s[[0, 1, 3]], [6.0, 19.0, 27.5]))

    each_s = np.arange(0.0, scene.duration + 1.0, 120.0)
    each_deg = passage.places((each_s * 1e9).astype(np.int64))[1]

    def longitude(t):
        return float(np.interp(t, each_s, each_deg))

    # the longitude is taken as linear within ten minutes
    np.testing.assert_allclose(
        box(scene), integrated(scene, mean, longitude, places_s), rtol=0.0, atol=2e-6
    )


def test_a_swing_in_harbour_is_less_in_the_box_and_later() -> None:
    """D/√(1 + (ωτ)²), behind by atan(ωτ)/ω."""
    air = {'kind': 'constant', 'celsius': 12.0, 'diurnal': 3.0, 'warmest_hour': 14.0}
    scene = scene_of(air, 3.0, voyage=None)
    hours = np.arange(scene.log_count) / 6.0
    lag = math.tau / 24.0 * 6.0
    expected = 12.0 + 3.0 / math.hypot(1.0, lag) * np.cos(
        math.tau / 24.0 * (hours - 14.0) - math.atan(lag)
    )
    np.testing.assert_allclose(box(scene), expected, rtol=0.0, atol=1e-13)


def test_warmest_hour_follows_the_longitude() -> None:
    voyage = {**VOYAGE, 'departure': [17.93, -75.0], 'sails_at': 5.0 * DAY_S}
    air = {'kind': 'constant', 'celsius': 12.0, 'diurnal': 3.0, 'box_hours': 1e-3}
    in_port = box(scene_of(air, 3.0, voyage=voyage, gravity='normal'))[:144]
    # 75° west: noon there is at 17 h
    assert np.argmax(in_port) == 17 * 6


@pytest.mark.parametrize('kind', ['still', 'sea'])
def test_temperature_has_same_bits_in_any_chunks(kind) -> None:
    air = {'kind': 'constant', 'celsius': 12.0, 'diurnal': 3.0}
    if kind == 'still':
        scene = scene_of({'kind': 'route', 'at': AT, 'diurnal': 3.0}, 3.0)
    else:
        scene = load_scene('involute_weight_at_sea', duration=60.0, air=air, log={'interval': 5.0})
    whole = ShipSource(scene)
    imu, felt = ((said := whole.produce(10**6))['ship/imu'], said[SHIP_TEMPERATURE])
    assert isinstance(felt, TemperatureSamples)
    interval = scene.log_interval_ns
    np.testing.assert_array_equal(np.diff(felt.stamp_ns), interval)
    assert felt.stamp_ns[0] == scene.starts_at_ns
    assert 0 <= felt.stamp_ns[-1] - imu.stamp_ns[-1] < interval
    rng = np.random.default_rng(1)
    parts, source = [], ShipSource(scene)
    while said := source.produce(int(rng.integers(1, 200))):
        parts += [said[SHIP_TEMPERATURE]] if SHIP_TEMPERATURE in said else []
        state = source.state()
        source = ShipSource(scene)
        source.restore(state)
    again = join(parts)
    np.testing.assert_array_equal(again.stamp_ns, felt.stamp_ns)
    assert again.temperature.tobytes() == felt.temperature.tobytes()


ROUTE = {'kind': 'route', 'at': AT}
RECORD = {'kind': 'record', 'source': 'x', 'time': [0.0, 9000.0], 'celsius': [8.0, 9.0]}


@pytest.mark.parametrize(
    ('air', 'voyage', 'said'),
    [
        (
            {**ROUTE, 'at': [{'waypoint': 0, 'celsius': 93.0}]},
            VOYAGE,
            r'at\[0\].celsius = 93.0: .* 60',
        ),
        ({'kind': 'constant', 'celsius': -61.0}, None, 'celsius = -61.0: must be at least -60'),
        (
            {**ROUTE, 'at': [{'waypoint': 4, 'celsius': 9.0}]},
            VOYAGE,
            r'= 4: is not a place of the v',
        ),
        ({**ROUTE, 'at': AT[::-1]}, VOYAGE, r'at\[1\].waypoint = 1: does not come after .*, 3'),
        ({**ROUTE, 'at': []}, VOYAGE, 'at = .*: has 0 items, the limit is at least 1'),
        (ROUTE, None, 'the scene has no voyage. Write `kind: constant'),
        ({'kind': 'route'}, VOYAGE, 'voyage.date: is needed for the mean temperature'),
        ({'kind': 'route'}, {**VOYAGE, 'date': '1761-02-30'}, "date = '1761-02-30': is not a day"),
        ({'kind': 'route'}, {**VOYAGE, 'date': 1761}, 'voyage.date = 1761: is not a day'),
        (ROUTE, {**VOYAGE, 'date': '1300-01-01'}, 'must lie in the years 1500 to 2999'),
        (RECORD, None, 'lasts from 0 s to 9000 s by the scene, which lasts from 0 to 864000.0 s'),
        ({**RECORD, 'celsius': [1.0]}, None, 'has 1 values for 2 times'),
        ({**RECORD, 'time': [0.0, 0.0]}, None, r'air.time\[1\] = 0.0: must be later'),
        ({**RECORD, 'celsius': [8.0, 280.0]}, None, r'celsius\[1\] = 280.0: must be at most 60'),
    ],
)
def test_impossible_air_is_refused(air, voyage, said) -> None:
    with pytest.raises(SceneError) as error:
        scene_of(air, voyage=voyage)
    assert re.search(
        said, str(error.value).replace(" (air is given, in place of the scene's)", '')
    )


def test_climate_is_its_table_in_the_middle_of_a_month() -> None:
    middle = (np.arange(12) + 0.5) / 12.0
    for latitude, row in zip(ZONAL_LATITUDES, ZONAL_CELSIUS, strict=True):
        np.testing.assert_allclose(zonal_celsius(np.full(12, latitude), middle), row, atol=1e-11)
    # beyond the rows constant, between them linear, over the new year too
    assert zonal_celsius(np.array([-85.0]), middle[:1]) == ZONAL_CELSIUS[0, 0]
    found = zonal_celsius(np.array([45.0, 40.0]), np.array([1.0 / 24.0, 1.0]))
    expected = [ZONAL_CELSIUS[11:13, 0].mean(), ZONAL_CELSIUS[11, [11, 0]].mean()]
    np.testing.assert_allclose(found, expected, atol=1e-11)


def test_a_voyage_has_the_climate_of_its_places_and_its_date() -> None:
    air = {'kind': 'route', 'box_hours': 1e-3}
    for date, month in (('1761-01-14', 0), ('1761-07-14', 6)):
        voyage = {**VOYAGE, 'departure': [50.0, 0.0], 'date': date}
        found = box(scene_of(air, voyage=voyage, gravity='normal'))
        # within three days of the middle of the month, by at most 2.6 K a month
        at = ZONAL_CELSIUS[12, month], np.interp(17.93, ZONAL_LATITUDES, ZONAL_CELSIUS[:, month])
        np.testing.assert_allclose(found[[0, -1]], at, atol=0.6)


def recorded(tmp_path: Path, rows: str, date: str | None = None, **keys: Any) -> Scene:
    (tmp_path / 'air.csv').write_text(rows, encoding='utf-8')
    air = {'kind': 'record', 'path': str(tmp_path / 'air.csv'), 'box_hours': 2.0, **keys}
    voyage = {**VOYAGE, 'sails_at': DAY_S, 'date': date}
    return scene_of(air, 2.0, voyage=voyage)


DAYS = 'time_s,celsius\n-3600,8\n82000,14\n160000,10\n172800,9\n'
DATED = (
    'time_utc,celsius\n1761-11-16T23:00,8\n1761-11-17T22:46:40,14\n1761-11-18T20:26:40,10\n'
    '1761-11-19,9\n'
)


def test_record_is_packed_into_the_scene(tmp_path) -> None:
    scene = recorded(tmp_path, DAYS)
    (tmp_path / 'air.csv').unlink()
    assert parse_scene(scene_yaml(scene), 'again') == scene
    assert scene.air is not None
    at_ns, celsius = scene.air.knots(scene)
    assert (at_ns / 10**9).tolist() == [-3600.0, 82_000.0, 160_000.0, 172_800.0]
    assert celsius.tolist() == [8.0, 14.0, 10.0, 9.0]


def test_dates_of_a_record_are_those_of_the_voyage(tmp_path) -> None:
    by_seconds = box(recorded(tmp_path, DAYS))
    np.testing.assert_array_equal(box(recorded(tmp_path, DATED, '1761-11-18')), by_seconds)
    begun = recorded(tmp_path, DATED, begins='1761-11-17')
    np.testing.assert_array_equal(box(begun), by_seconds)


@pytest.mark.parametrize(
    ('rows', 'said'),
    [
        (
            DAYS.replace(',14', ',287'),
            'line 3, celsius = 287.0: must be .* at most 60 °C. Give it in',
        ),
        (DAYS.replace('82000', '-3600'), 'line 3, time_s = -3600.0: must be later than the row'),
        (DAYS.replace('82000', '82801'), 'line 3: comes 86401 s after .*longest_gap_hours,'),
        (DAYS.replace('-3600', '3600'), 'lasts from 3600 s to 172800 s by the scene'),
        (DATED.replace('1761', '1762'), 'correct voyage.date'),
    ],
)
def test_impossible_records_are_refused(rows, said, tmp_path) -> None:
    with pytest.raises(SceneError, match=said):
        recorded(tmp_path, rows, '1761-11-18')


def test_checks_and_results_have_the_range_in_the_box(tmp_path) -> None:
    air = {'kind': 'constant', 'celsius': 12.0, 'diurnal': 3.0}
    scene, bag = scene_of(air, 2.0, voyage=None), tmp_path / 'bag'
    np.testing.assert_array_equal(sail(scene).temperature_celsius, box(scene))
    results = [scene_facts(scene), sail(scene, bag, keep=False).result, summarise_bag(bag)]
    results += [replay(read_bag(bag), keep=keep).result for keep in (True, False)]
    swing = 3.0 / math.hypot(1.0, math.tau / 4.0)
    for result in results:
        found = result['air']['lowest_celsius'], result['air']['highest_celsius']
        assert found == pytest.approx((12.0 - swing, 12.0 + swing), abs=1e-3)
    assert 'air' not in sail(load_scene('ideal', duration=60.0)).result
