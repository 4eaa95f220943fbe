"""Legs against published geodesics and rhumb lines, and the differential equation of a course."""

import math

import numpy as np
import pytest
from geographiclib.geodesic import Geodesic
from scipy.integrate import solve_ivp

from tauto_core.ship.passage import geodesic_leg, rhumb_leg

A_M, F = 6_378_137.0, 1.0 / 298.257223563
E2 = F * (2.0 - F)


def degrees(d, m, s):
    return math.copysign(abs(d) + m / 60.0 + s / 3600.0, d)


# the example of the manual page RhumbSolve(1) of GeographicLib
JFK = (degrees(40, 38, 23), degrees(-73, 46, 44))
SINGAPORE = (degrees(1, 21, 33), degrees(103, 59, 22))
SINGAPORE_M = 18_523_563
WAYPOINTS = [
    (degrees(40, 38, 23.0), degrees(-73, 46, 44.0)),
    (degrees(36, 24, 30.3), degrees(-51, 28, 26.4)),
    (degrees(32, 10, 26.8), degrees(-30, 20, 57.3)),
    (degrees(27, 56, 13.2), degrees(-10, 10, 54.2)),
    (degrees(23, 41, 50.1), degrees(9, 12, 45.5)),
    (degrees(19, 27, 18.7), degrees(27, 59, 22.1)),
    (degrees(15, 12, 40.2), degrees(46, 17, 1.1)),
    (degrees(10, 57, 55.9), degrees(64, 12, 52.8)),
    (degrees(6, 43, 7.3), degrees(81, 53, 28.8)),
    (degrees(2, 28, 16.2), degrees(99, 24, 54.5)),
]


def test_the_published_rhumb_line_to_singapore():
    leg = rhumb_leg(JFK, SINGAPORE)
    assert leg.length_m == pytest.approx(SINGAPORE_M, abs=0.5)
    # printed to 0.1"
    assert leg.course_deg == pytest.approx(degrees(103, 34, 58.2), abs=0.05 / 3600.0)
    latitude, longitude = leg.places(2e6 * np.arange(10) / leg.length_m)
    # the published places are 2000 km apart on the course printed: 0.05" of it is 0.15" after
    # 18 000 km, and they are printed to 0.1"
    np.testing.assert_allclose(latitude, [p[0] for p in WAYPOINTS], rtol=0, atol=0.2 / 3600)
    np.testing.assert_allclose(longitude, [p[1] for p in WAYPOINTS], rtol=0, atol=0.2 / 3600)


@pytest.mark.parametrize(
    ('start', 'end'),
    [
        ((50.79, -1.11), (17.93, -76.84)),
        ((45.0, 0.0), (45.0, 100.0)),
        ((45.0, 0.0), (45.0 + 1e-7, 100.0)),
        ((-33.9, 151.2), (-54.8, -68.3)),
        ((10.0, 10.0), (-60.0, 10.0)),
        ((60.0, 0.0), (88.0, -170.0)),
    ],
)
def test_a_rhumb_line_keeps_its_course(start, end):
    """dφ/ds = cos α/M, dλ/ds = sin α/(N cos φ), by DOP853 at 1e-13: 1e-10° is 0.01 mm."""
    leg = rhumb_leg(start, end)
    course = leg.course(0.3)

    def slope(_, place):
        w = 1.0 - E2 * math.sin(place[0]) ** 2
        return [
            math.cos(course) * w**1.5 / (A_M * (1.0 - E2)),
            math.sin(course) * math.sqrt(w) / (A_M * math.cos(place[0])),
        ]

    parts = np.linspace(0.0, 1.0, 9)
    way = solve_ivp(
        slope,
        (0.0, leg.length_m),
        np.radians(start),
        'DOP853',
        parts * leg.length_m,
        rtol=1e-13,
        atol=1e-15,
    )
    expected = np.degrees(way.y)
    latitude, longitude = leg.places(parts)
    np.testing.assert_allclose(latitude, expected[0], rtol=0, atol=1e-10)
    wrapped = np.remainder(longitude - expected[1] + 180.0, 360.0) - 180.0
    # near a pole a course is a spiral: its error in metres shrinks with the parallel
    np.testing.assert_allclose(wrapped * np.cos(way.y[0]), 0.0, atol=1e-10)
    assert abs(latitude[-1] - end[0]) < 1e-12
    assert abs(math.remainder(longitude[-1] - end[1], 360.0)) < 1e-12
    assert leg.highest_deg == max(abs(start[0]), abs(end[0]))


@pytest.mark.parametrize(
    ('start', 'end', 'length_m'),
    [
        # Wellington to Salamanca, example of the documentation of geographiclib
        ((-41.32, 174.81), (40.96, -5.50), 19959679.267),
        # a quarter of the meridian of WGS 84: 10 001 965.729 m
        ((0.0, 10.0), (90.0, 10.0), 10001965.729),
        # ten degrees of the equator, a circle of radius 6 378 137 m
        ((0.0, 0.0), (0.0, 10.0), math.radians(10.0) * A_M),
    ],
)
def test_geodesics_have_the_published_length(start, end, length_m):
    assert geodesic_leg(start, end).length_m == pytest.approx(length_m, abs=1e-3)
    if start[0] * end[0] == 0.0:  # meridian and equator are both geodesic and rhumb line
        assert rhumb_leg(start, end).length_m == pytest.approx(length_m, abs=1e-3)


@pytest.mark.parametrize(
    ('start', 'end'),
    [
        ((50.79, -1.11), (17.93, -76.84)),
        ((-41.32, 174.81), (40.96, -5.50)),
        ((80.0, 0.0), (80.0, 170.0)),
        ((0.0, 0.0), (0.5, 179.5)),
        ((5.0, 5.0), (5.0, 5.0)),
    ],
)
def test_the_series_of_a_geodesic_is_the_geodesic(start, end):
    """Each place against Karney's direct solution, to 1e-12° (0.1 µm): series and rounding."""
    leg = geodesic_leg(start, end)
    parts = np.linspace(0.0, 1.0, 101)
    line = Geodesic.WGS84.InverseLine(*start, *end)
    found = [line.Position(part * line.s13) for part in parts.tolist()]
    latitude, longitude = leg.places(parts)
    np.testing.assert_allclose(latitude, [p['lat2'] for p in found], rtol=0, atol=1e-12)
    apart = [math.remainder(a - p['lon2'], 360.0) for a, p in zip(longitude, found, strict=True)]
    np.testing.assert_allclose(apart * np.cos(np.radians(latitude)), 0.0, atol=1e-12)
    # a hundred places of a leg come within 0.01° of its northernmost
    highest = max(abs(p['lat2']) for p in found)
    assert highest <= leg.highest_deg + 1e-12
    assert leg.highest_deg == pytest.approx(highest, abs=0.01)
