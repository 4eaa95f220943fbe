"""The air and the box of the clock: against an integration, closed forms, and in any chunks."""

from __future__ import annotations

import math
import re
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tauto_core.samples import SHIP_TEMPERATURE, TemperatureSamples, join
from tauto_core.scene import Scene, load_scene
from tauto_core.scene.errors import SceneError
from tauto_core.ship.air import BoxTemperature
from tauto_core.ship.passage import Passage
from tauto_core.voyage import ShipSource

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
    """Return the box at the logged instants by DOP853, from where the closed form starts."""
    air = scene.air
    assert air is not None

    def slope(t: float, y: np.ndarray) -> float:
        hour = (scene.starts_at + t) / HOUR_S + longitude(t) / 15.0
        swing = air.diurnal * math.cos(math.tau * (hour - air.warmest_hour) / 24.0)
        return (mean(t) + swing - y) / (air.box_hours * HOUR_S)

    times = scene.log.interval * np.arange(scene.log_count)
    y, found = [float(box(scene)[0])], np.empty(scene.log_count)
    edges = sorted({0.0, *(k for k in knots_s if 0.0 < k < times[-1]), times[-1]})
    for a, b in pairwise(edges):
        run = solve_ivp(slope, (a, b), y, 'DOP853', dense_output=True, rtol=1e-12, atol=1e-11)
        here = (times >= a) & (times <= b)
        found[here] = run.sol(times[here])[0]
        y = run.y[:, -1]
    return found


@pytest.mark.parametrize(
    ('diurnal', 'box_hours'), [(0.0, 6.0), (3.0, 6.0), (4.0, 0.2), (5.0, 90.0)]
)
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
    air = {'kind': 'route', 'celsius': 12.0, 'diurnal': 3.0, 'warmest_hour': 14.0}
    scene = scene_of(air, 3.0, voyage=None)
    hours = np.arange(scene.log_count) / 6.0
    lag = math.tau / 24.0 * 6.0
    expected = 12.0 + 3.0 / math.hypot(1.0, lag) * np.cos(
        math.tau / 24.0 * (hours - 14.0) - math.atan(lag)
    )
    np.testing.assert_allclose(box(scene), expected, rtol=0.0, atol=1e-13)


def test_the_warmest_hour_is_that_of_the_sun_at_her_longitude() -> None:
    voyage = {**VOYAGE, 'departure': [17.93, -75.0], 'sails_at': 5.0 * DAY_S}
    air = {'kind': 'route', 'celsius': 12.0, 'diurnal': 3.0, 'box_hours': 1e-3}
    in_port = box(scene_of(air, 3.0, voyage=voyage, gravity='normal'))[:144]
    # 75° west: noon there is at 17 h
    assert np.argmax(in_port) == 17 * 6


@pytest.mark.parametrize('kind', ['still', 'sea'])
def test_the_topic_has_the_same_bits_in_any_chunks_and_reaches_beyond_the_motion(kind) -> None:
    air = {'kind': 'route', 'celsius': 12.0, 'diurnal': 3.0}
    if kind == 'still':
        scene = scene_of({**air, 'celsius': None, 'at': AT}, 3.0)
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


def test_a_scene_without_air_has_no_temperature() -> None:
    scene = load_scene('involute_weight_at_sea', duration=60.0)
    assert SHIP_TEMPERATURE not in ShipSource(scene).produce(10**6)


ROUTE = {'kind': 'route', 'at': AT}


@pytest.mark.parametrize(
    ('air', 'voyage', 'said'),
    [
        (
            {**ROUTE, 'at': [{'waypoint': 0, 'celsius': 293.0}]},
            VOYAGE,
            r'at\[0\].celsius = 293.0: must lie between -60 and 60 °C. Write 19.85 if',
        ),
        ({'kind': 'route', 'celsius': -61.0}, None, 'between -60 and 60 °C. Give it in'),
        (
            {**ROUTE, 'at': [{'waypoint': 4, 'celsius': 9.0}]},
            VOYAGE,
            r'at\[0\].waypoint = 4: is not a place of the voyage, which has 4',
        ),
        (
            {**ROUTE, 'at': AT[::-1]},
            VOYAGE,
            r'at\[1\].waypoint = 1: does not come after the place before it, 3',
        ),
        ({**ROUTE, 'at': []}, VOYAGE, 'air.at: is empty'),
        (ROUTE, None, 'names places of a voyage, and the scene has none'),
        ({**ROUTE, 'celsius': 3.0}, VOYAGE, 'does not go with at'),
        ({'kind': 'route'}, None, 'air.at: is missing, and there is no celsius'),
        ({**ROUTE, 'box_hours': 0.0}, VOYAGE, 'box_hours = 0.0: must be greater than 0.0'),
        ({**ROUTE, 'diurnal': -1.0}, VOYAGE, 'diurnal = -1.0: must be at least 0.0'),
    ],
)
def test_impossible_air_is_refused(air, voyage, said) -> None:
    with pytest.raises(SceneError) as error:
        scene_of(air, voyage=voyage)
    found = str(error.value).replace(" (air is given, in place of the scene's)", '')
    assert re.search(said, found), found
