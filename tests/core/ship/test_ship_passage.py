"""The passage: places and times over waypoints, and voyages that cannot be sailed."""

from itertools import pairwise

import numpy as np
import pytest
from geographiclib.geodesic import Geodesic

from tauto_core.checks.readiness import check_scene, plausibility_warnings
from tauto_core.scene import load_scene, parse_scene, scene_yaml
from tauto_core.scene.errors import SceneError
from tauto_core.ship import Observations, Passage, schedule

S = 1_000_000_000
DAY = 86_400
MADEIRA = [32.75, -16.95]
JAMAICA = {
    'departure': [50.79, -1.11],
    'waypoints': [[48.5, -6.0], {'place': MADEIRA, 'landfall': True}, [15.5, -61.4]],
    'arrival': [17.93, -76.84],
    'sails_at': 14.0 * DAY,
    'arrives_at': 95.0 * DAY,
}

PORT = {'observation_interval': 86_400.0}


def scene_of(duration=100.0 * DAY, **changes):
    voyage = {key: value for key, value in (JAMAICA | changes).items() if value is not None}
    return load_scene(
        'ideal', duration=duration, log={'interval': 600.0}, drift=PORT, voyage=voyage
    )


def passage_of(duration=100.0 * DAY, **changes):
    scene = scene_of(duration, **changes)
    return Passage(scene, scene.voyage)


def refusal(**changes):
    with pytest.raises(SceneError) as caught:
        check_scene(scene_of(**changes))
    assert caught.value.remedy.endswith('.')
    return caught.value


@pytest.mark.parametrize('track', [None, 'geodesic', 'rhumb'])
def test_the_ship_passes_every_waypoint_at_constant_speed(track):
    passage = passage_of(track=track)
    landfall, arrival = passage.landfalls_ns
    assert arrival == passage.arrives_ns == 95 * DAY * S
    latitude, longitude = passage.places(np.array([0, landfall, 95 * DAY * S]))
    # a nanosecond of the way is a picometre, and the series leave 1e-13 degrees
    np.testing.assert_allclose(latitude, [50.79, MADEIRA[0], 17.93], rtol=0, atol=1e-12)
    np.testing.assert_allclose(longitude, [-1.11, MADEIRA[1], -76.84], rtol=0, atol=1e-12)
    made = np.linspace(14 * DAY, 95 * DAY, 811).astype(np.int64) * S
    places = np.stack(passage.places(made), axis=1).tolist()
    steps = [Geodesic.WGS84.Inverse(*one, *other)['s12'] for one, other in pairwise(places)]
    # 11 km a step: geodesic and rhumb line agree to 1e-6. Corners shorten three steps
    even = np.sort(steps)[3:]
    np.testing.assert_allclose(even, passage.length_m / 810, rtol=1e-6)


def test_speed_tells_the_arrival():
    passage = passage_of(arrives_at=None, speed=1.5)
    assert passage.arrives_ns == 14 * DAY * S + round(passage.length_m / 1.5 * S)
    assert passage.length_m == passage_of().length_m


@pytest.mark.parametrize('track', ['geodesic', 'rhumb'])
def test_places_do_not_depend_on_the_batch(track):
    passage = passage_of(track=track)
    at = np.linspace(13 * DAY * S, 96 * DAY * S, 103).astype(np.int64)
    whole = np.stack(passage.places(at))
    for size in (1, 2, 7):
        parts = [np.stack(passage.places(at[k : k + size])) for k in range(0, 103, size)]
        np.testing.assert_array_equal(np.concatenate(parts, axis=1), whole)


def test_the_way_goes_on_over_the_date_line():
    passage = passage_of(
        departure=[-40.0, 175.0], waypoints=None, arrival=[-50.0, -170.0], track='rhumb'
    )
    _, longitude = passage.places(np.linspace(14 * DAY, 95 * DAY, 500).astype(np.int64) * S)
    assert longitude.min() >= -180.0
    assert longitude.max() < 180.0
    steps = np.remainder(np.diff(longitude), 360.0)
    assert steps.max() < 0.04


def test_landfall_is_observed_at_the_next_logged_instant():
    scene = scene_of()
    landfall, _ = Passage(scene, scene.voyage).landfalls_ns
    seen = Observations(scene).between(0, 10**18)
    stamps = seen.stamp_ns[seen.source == 'landfall'] - scene.starts_at_ns
    grid = 600 * S
    assert stamps.tolist() == [(landfall // grid + 2) * grid, (95 * DAY + 600) * S]
    assert np.array_equal(seen.stamp_ns, schedule(scene))
    assert len(schedule(scene)) == 15 + 2


def test_a_voyage_is_read_back_as_it_was_written():
    scene = scene_of(track='rhumb', arrives_at=None, speed=1.5)
    assert parse_scene(scene_yaml(scene), 'bag') == scene
    bare = scene_of(waypoints=None)
    assert 'waypoints' not in scene_yaml(bare)
    assert 'track' not in scene_yaml(bare)


def test_a_way_over_a_pole_is_refused():
    error = refusal(departure=[70.0, 10.0], waypoints=[[70.0, -170.0]])
    assert (error.key, error.value) == ('voyage.waypoints[0]', [70.0, -170.0])
    assert '90.0000° of latitude; beyond 89.68°' in str(error)
    # half the parallel of 89.68° is 60 nautical miles
    near = {'departure': [89.6, 0.0], 'waypoints': None, 'arrival': [89.6, 120.0]}
    assert refusal(**near).key == 'voyage.arrival'
    check_scene(scene_of(**near | {'track': 'rhumb'}))


@pytest.mark.parametrize(
    ('speed', 'duration', 'said'),
    [
        (0.5, 100.0 * DAY, 'Give a speed of at least 1.204, '),
        (1e-300, 100.0 * DAY, 'after the end of the scene'),
        (1.0, 10.0 * DAY, 'Give a longer duration'),
    ],
)
def test_a_speed_that_does_not_fit_the_scene_is_refused(speed, duration, said):
    error = refusal(duration=duration, arrives_at=None, speed=speed)
    assert (error.key, error.value) == ('voyage.speed', speed)
    assert said in str(error)


TIMED = {
    'departure': [48.0, -6.0],
    'waypoints': [
        {'place': [45.0, -9.0], 'at': 2.0 * DAY},
        {'place': [45.0, -9.0], 'at': 2.5 * DAY},
        [40.0, -12.0],
        {'place': MADEIRA, 'at': 6.0 * DAY, 'landfall': True},
    ],
    'arrival': [28.5, -16.2],
    'sails_at': 1.0 * DAY,
    'arrives_at': 7.0 * DAY,
}


def way(one, other):
    """Return the geodesic between two places, by Karney's program."""
    return Geodesic.WGS84.Inverse(*one, *other)


def test_a_voyage_has_the_speeds_of_its_places():
    passage = passage_of(10.0 * DAY, **TIMED)
    # by Karney's program: the legs' lengths over the times between the places
    first = way(TIMED['departure'], [45.0, -9.0])
    long = way([45.0, -9.0], [40.0, -12.0])['s12'] + way([40.0, -12.0], MADEIRA)['s12']
    last = way(MADEIRA, TIMED['arrival'])
    speeds = {1.5: first['s12'] / DAY, 2.2: 0.0, 4.0: long / (3.5 * DAY), 6.5: last['s12'] / DAY}
    for day, speed in (speeds | {0.5: 0.0, 7.5: 0.0}).items():
        assert passage.speed_m_s(round(day * DAY * S)) == pytest.approx(speed, rel=1e-12)
    # a missing time follows from the way
    passed = 2.5 + 3.5 * way([45.0, -9.0], [40.0, -12.0])['s12'] / long
    assert passage.places_ns[3] == pytest.approx(passed * DAY * S, abs=2)
    assert passage.landfalls_ns == (6 * DAY * S, 7 * DAY * S)


def test_a_ship_is_at_each_place_at_its_time():
    passage = passage_of(10.0 * DAY, **TIMED)
    places = passage.places(np.array(passage.places_ns, np.int64))
    wanted = [[48.0, -6.0], [45.0, -9.0], [45.0, -9.0], [40.0, -12.0], MADEIRA, [28.5, -16.2]]
    np.testing.assert_allclose(np.transpose(places), wanted, rtol=0, atol=1e-11)
    # halfway in time is halfway along the geodesic
    (latitude,), (longitude,) = passage.places(np.array([round(1.5 * DAY) * S]))
    line = Geodesic.WGS84.InverseLine(48.0, -6.0, 45.0, -9.0)
    middle = line.Position(0.5 * line.s13)
    assert (latitude, longitude) == pytest.approx((middle['lat2'], middle['lon2']), abs=1e-11)


def test_course_at_a_place_or_at_anchor_is_the_next():
    passage = passage_of(10.0 * DAY, **TIMED)
    for day, one, other in (
        (1.0, TIMED['departure'], [45.0, -9.0]),
        (2.0, [45.0, -9.0], [40.0, -12.0]),
        (2.3, [45.0, -9.0], [40.0, -12.0]),
        (3.0, None, [40.0, -12.0]),  # under way
        (6.0, MADEIRA, TIMED['arrival']),
    ):
        at = round(day * DAY) * S
        start = one or np.concatenate(passage.places(np.array([at])))
        wanted = np.radians(way(start, other)['azi1'] % 360.0)
        assert passage.course(at) == pytest.approx(wanted, abs=1e-9)
    arrival = np.radians(way(MADEIRA, TIMED['arrival'])['azi2'] % 360.0)
    assert passage.course(8 * DAY * S) == pytest.approx(arrival, abs=1e-9)


def test_course_at_the_last_place_is_the_one_of_arrival():
    ends = {'waypoints': [{'place': [28.5, -16.2], 'at': 2.0 * DAY}], 'arrives_at': 3.0 * DAY}
    passage = passage_of(10.0 * DAY, **(TIMED | ends))
    came = np.radians(way(TIMED['departure'], [28.5, -16.2])['azi2'] % 360.0)
    assert passage.course(round(2.5 * DAY) * S) == pytest.approx(came, abs=1e-9)


@pytest.mark.parametrize(
    ('changes', 'key', 'what'),
    [
        ({'arrives_at': None, 'speed': 2.0}, 'voyage.waypoints[0].at', 'speed'),
        ({'sails_at': 3.0 * DAY}, 'voyage.waypoints[0].at', 'later'),
        ({'arrives_at': 5.0 * DAY}, 'voyage.arrives_at', 'later'),
        ({'waypoints': [TIMED['waypoints'][0], [45.0, -9.0]]}, 'voyage.waypoints[1]', 'same pl'),
    ],
)
def test_times_that_no_ship_keeps_are_refused_by_key(changes, key, what):
    error = refusal(**(TIMED | changes))
    assert error.key == key
    assert what in f'{error.problem} {error.remedy}'


def test_a_leg_faster_than_any_ship_is_warned_of_by_its_own_time():
    waypoints = [{'place': MADEIRA, 'at': 1.2 * DAY}]
    said = plausibility_warnings(scene_of(10.0 * DAY, **(TIMED | {'waypoints': waypoints})))
    assert any('voyage.waypoints[0].at' in each for each in said)
