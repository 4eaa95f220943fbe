"""Normal gravity against boule, Eötvös' term against its definition, and both along a passage."""

import math

import boule
import numpy as np
import pytest
from geographiclib.geodesic import Geodesic

from tauto_core.scene import Scene, load_scene, parse_scene, scene_yaml
from tauto_core.scene.errors import SceneError
from tauto_core.scene.times import NS_PER_S
from tauto_core.ship.passage import EARTH_RATE, GravityOnTheWay, Passage, eotvos, normal_gravity
from tauto_core.ship.source import ShipMotion
from tauto_core.voyage import sail

DAY_S = 86400.0
KNOT = 1852.0 / 3600.0
A, B = Geodesic.WGS84.a, Geodesic.WGS84.a * (1.0 - Geodesic.WGS84.f)


def test_normal_gravity_is_that_of_boule() -> None:
    # boule evaluates the closed form of Li and Götze (2001), not Somigliana's
    latitude = np.linspace(-90.0, 90.0, 721)
    zero = np.zeros_like(latitude)
    mgal = boule.WGS84.normal_gravity((zero, latitude, zero))
    # the constants of TR8350.2 have ten digits
    np.testing.assert_allclose(normal_gravity(np.radians(latitude)), mgal * 1e-5, atol=1e-9)


def earth_fixed(latitude: float, longitude: float) -> np.ndarray:
    """Return the place on the ellipsoid in axes that turn with the Earth [m]."""
    across = A * A / math.hypot(A * math.cos(latitude), B * math.sin(latitude))
    on_axis = across * (B / A) ** 2
    return np.array(
        [
            across * math.cos(latitude) * math.cos(longitude),
            across * math.cos(latitude) * math.sin(longitude),
            on_axis * math.sin(latitude),
        ]
    )


@pytest.mark.parametrize('latitude_deg', [-62.0, 18.0])
@pytest.mark.parametrize('course_deg', [61.0, 200.0, 270.0])
def test_eotvos_is_the_difference_of_vertical_accelerations(latitude_deg, course_deg):
    """The vertical part of the acceleration in space, by differences of positions."""
    latitude, speed, h = math.radians(latitude_deg), 8.0, 60.0

    def vertical_acceleration(speed: float) -> float:
        places = []
        for time in (-h, 0.0, h):
            line = Geodesic.WGS84.Direct(latitude_deg, 0.0, course_deg, speed * time)
            turned = math.radians(line['lon2']) + EARTH_RATE * time
            places.append(earth_fixed(math.radians(line['lat2']), turned))
        up = np.array([math.cos(latitude), 0.0, math.sin(latitude)])
        return float(up @ (places[0] - 2.0 * places[1] + places[2])) / (h * h)

    felt = vertical_acceleration(0.0) - vertical_acceleration(speed)
    east, north = (speed * f(math.radians(course_deg)) for f in (math.sin, math.cos))
    # differences over a minute are wrong by (Ω h)²/12 of 2 Ω v
    assert eotvos(latitude, east, north) == pytest.approx(felt, rel=1e-4, abs=2e-8)


def test_gravity_follows_place_and_speed_of_a_passage() -> None:
    scene = load_scene('portsmouth_jamaica')
    assert scene.voyage is not None
    passage = Passage(scene, scene.voyage)
    way = GravityOnTheWay(passage, scene.duration_ns)
    times = np.linspace(passage.sails_ns + 10**12, passage.arrives_ns - 10**12, 500)
    times = times.astype(np.int64)
    corners = np.array(passage.places_ns)
    clear = np.abs(times[:, None] - corners).min(axis=1) > 150 * NS_PER_S
    for time in times[clear][::7].tolist():
        latitude = math.radians(float(passage.places(np.array([time]))[0][0]))
        course, speed = passage.course(time), passage.speed_m_s(time)
        moved = eotvos(latitude, speed * math.sin(course), speed * math.cos(course))
        at = float(way.at(np.array([time]))[0])
        # linear between knots of a minute
        assert at == pytest.approx(float(normal_gravity(latitude) - moved), abs=1e-9)


def test_gravity_in_port_is_normal_in_any_batches() -> None:
    scene = load_scene('portsmouth_jamaica')
    assert scene.voyage is not None
    way = GravityOnTheWay(Passage(scene, scene.voyage), scene.duration_ns)
    port = normal_gravity(math.radians(scene.voyage.departure[0]))
    assert float(way.at(np.array([0]))[0]) == float(port)
    times = np.arange(0, scene.duration_ns, 7_777_777_777_777)
    whole = way.at(times)
    assert [float(way.at(times[i : i + 1])[0]) for i in range(len(times))] == whole.tolist()


SOUTHWARD = {
    'duration': 172_800.0,
    'trochlea.cam.base_radius': 0.0053681,
    'trochlea.power': {'kind': 'weight', 'mass': 0.3, 'massless': True},
    'ship': {'kind': 'still'},
    'voyage': {
        'departure': [50.8, -1.1],
        'arrival': [17.9, -40.0],
        'sails_at': 3600.0,
        'arrives_at': 169_200.0,
    },
    'clock': {},
    'log.interval': 60.0,
}


def southward(**overrides: object) -> Scene:
    return load_scene('involute_weight_at_sea', **SOUTHWARD | overrides)


def test_gravity_is_normal_on_a_voyage_and_a_number_elsewhere() -> None:
    scene = southward()
    assert scene.gravity == 'normal'
    assert scene.g == float(normal_gravity(math.radians(50.8)))
    assert southward(gravity=9.8).g == 9.8
    assert load_scene('ideal').gravity == 9.80665
    assert parse_scene(scene_yaml(scene), 'a bag') == scene


def test_normal_gravity_needs_a_voyage() -> None:
    with pytest.raises(SceneError, match='latitude, and there is no voyage') as caught:
        load_scene('ideal', gravity='normal')
    assert caught.value.key == 'gravity'


def test_a_weight_follows_the_root_of_gravity_on_the_way() -> None:
    """The wheel is linear: its action is kept while its frequency changes, φ = ∫√(mgr/I) dt."""
    scene = southward()
    assert scene.voyage is not None
    voyage = sail(scene)
    time_ns = voyage.time_s * 1e9
    gravity = GravityOnTheWay(Passage(scene, scene.voyage), scene.duration_ns)
    pace = np.sqrt(gravity.at(time_ns.astype(np.int64)) / scene.g)
    lost = np.concatenate([[0.0], np.cumsum(30.0 * (pace[1:] + pace[:-1] - 2.0))])
    assert lost[-1] < -45.0
    # The phase of (θ, −θ̇/ω₀) runs ahead and behind by ½(ω/ω₀ − 1)/2π turns.
    wobble = 0.5 * (1.0 - pace.min()) / math.tau
    error = voyage.clock_error_s - lost
    # Eötvös' term has corners at departure and arrival, which samples of a minute round off.
    corners = np.abs(voyage.time_s[:, None] - [3600.0, 169_200.0]).min(axis=1) < 300.0
    assert np.abs(error[~corners]).max() < 1.01 * wobble + 1e-6
    assert np.abs(error).max() < 1e-3


def test_at_sea_gravity_is_beside_the_heave() -> None:
    sea = {
        'kind': 'components',
        'rate': 4.0,
        'height': 0.0,
        'components': [{'amplitude': 0.1, 'period': 9.0, 'phase': 0.0}],
    }
    normal, number = (
        ShipMotion(southward(duration=172_800.0, ship=sea, **more))
        for more in ({}, {'gravity': 9.80665})
    )
    felt, plain = (motion.produce(motion.total).linear_acceleration for motion in (normal, number))
    scene = southward()
    assert scene.voyage is not None
    way = GravityOnTheWay(Passage(scene, scene.voyage), scene.duration_ns)
    weighs = way.at(np.arange(len(felt), dtype=np.int64) * 250_000_000)
    np.testing.assert_allclose(
        np.linalg.norm(felt, axis=1) - np.linalg.norm(plain, axis=1), weighs - 9.80665, atol=5e-15
    )
