"""The route against published geodesics and the sphere."""

import math

import numpy as np
import pytest

from tauto_core.navigation import Route
from tauto_core.samples import take
from tauto_core.scene import parse_scene

S = 1_000_000_000
DAY = 86_400
TROCHLEA = """
trochlea:
  inertia: 4.0e-4
  cam: {kind: involute, base_radius: 0.010}
  thread: {kind: vertical}
  power: {kind: force, force: 2.0}
  release_angle: 1.0
starts_at: 100.0
duration: 8640000.0
log: {interval: 60.0}
drift: {observation_interval: 86400.0}
"""


def route_of(departure=None, arrival=None, sails_at=14.0 * DAY, arrives_at=95.0 * DAY):
    voyage = ''
    if departure:
        voyage = (
            f'voyage: {{departure: {list(departure)}, arrival: {list(arrival)}, '
            f'sails_at: {sails_at}, arrives_at: {arrives_at}}}'
        )
    return Route(parse_scene(TROCHLEA + voyage, 'test'))


def stamps(*days):
    return np.array([(100 + round(day * DAY)) * S for day in days], np.int64)


PLYMOUTH, JAMAICA = (50.37, -4.14), (17.93, -76.84)


def haversine_m(one, other, radius_m=6_371_008.8):
    (a, b), (c, d) = np.radians(one), np.radians(other)
    half = math.sin((c - a) / 2) ** 2 + math.cos(a) * math.cos(c) * math.sin((d - b) / 2) ** 2
    return 2 * radius_m * math.asin(math.sqrt(half))


@pytest.mark.parametrize(
    ('departure', 'arrival', 'length_m'),
    [
        # Wellington to Salamanca, example of the documentation of geographiclib
        ((-41.32, 174.81), (40.96, -5.50), 19959679.267),
        # ten degrees of the equator, a circle of radius 6 378 137 m
        ((0.0, 0.0), (0.0, 10.0), math.radians(10.0) * 6_378_137.0),
    ],
)
def test_length_is_the_published_one(departure, arrival, length_m):
    route = route_of(departure, arrival)
    assert route.length_m == pytest.approx(length_m, abs=1e-3)
    # the sphere differs from the ellipsoid by at most 0.56 %
    assert route.length_m == pytest.approx(haversine_m(departure, arrival), rel=5.6e-3)


def test_the_ship_waits_sails_at_constant_speed_and_stays():
    route = route_of(PLYMOUTH, JAMAICA)
    fix = route.fixes(stamps(0, 13.9, 14, 54.5, 95, 99))
    places = list(zip(fix.latitude.tolist(), fix.longitude.tolist(), strict=True))
    assert places[:3] == [PLYMOUTH] * 3
    assert places[4:] == [JAMAICA] * 2
    middle = places[3]
    assert haversine_m(PLYMOUTH, middle) == pytest.approx(route.length_m / 2, rel=5.6e-3)
    assert haversine_m(middle, JAMAICA) == pytest.approx(route.length_m / 2, rel=5.6e-3)
    # equal times, equal ways: 1e-6 for the curvature of the geodesic over 62 m a step
    days = 14 + np.arange(1, 5) * 60.0 / DAY
    steps = route.fixes(stamps(*days))
    ways = np.hypot(np.diff(steps.latitude), np.diff(steps.longitude) * np.cos(np.radians(50.37)))
    np.testing.assert_allclose(ways, ways[0], rtol=1e-6)


def test_the_way_is_continuous_at_both_ports():
    route = route_of(PLYMOUTH, JAMAICA)
    edges = stamps(14, 95)
    near = route.fixes(np.array([edges[0] + 1, edges[1] - 1]))
    np.testing.assert_allclose(near.latitude, [PLYMOUTH[0], JAMAICA[0]], rtol=0, atol=1e-12)
    np.testing.assert_allclose(near.longitude, [PLYMOUTH[1], JAMAICA[1]], rtol=0, atol=1e-12)


def test_places_do_not_depend_on_the_batch():
    route = route_of(PLYMOUTH, JAMAICA)
    at = stamps(*np.linspace(0, 100, 41))
    whole = route.fixes(at)
    for index in range(41):
        one = route.fixes(at[index : index + 1])
        part = take(whole, slice(index, index + 1))
        assert (one.latitude, one.longitude) == (part.latitude, part.longitude)


def test_without_a_voyage_the_ship_lies_where_a_minute_is_a_mile():
    fix = route_of().fixes(stamps(0, 50))
    np.testing.assert_array_equal(fix.latitude, 0.0)
    np.testing.assert_array_equal(fix.longitude, 0.0)
    assert (fix.frame_id, set(fix.status), set(fix.position_covariance_type)) == (
        'clock_mount',
        {0},
        {2},
    )
    np.testing.assert_array_equal(fix.position_covariance, np.tile(np.eye(3).ravel(), (2, 1)))


def test_a_voyage_to_where_it_began_stays_there():
    fix = route_of(PLYMOUTH, PLYMOUTH).fixes(stamps(0, 40, 99))
    np.testing.assert_allclose(fix.latitude, PLYMOUTH[0], rtol=0, atol=1e-13)
    np.testing.assert_allclose(fix.longitude, PLYMOUTH[1], rtol=0, atol=1e-13)
