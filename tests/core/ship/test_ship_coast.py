"""The coasts of maps: known places on land and at sea, and outlines cut by a frame."""

import math

import numpy as np
import pytest
from matplotlib.path import Path

from tauto_core.samples import FloatArray
from tauto_core.ship.coast import (
    MapFrame,
    _is_land,
    coast_km,
    inland_km,
    land,
    map_frame,
    ocean_of,
    place_name,
)


def is_land(outlines: list[FloatArray], longitude: float, latitude: float) -> bool:
    """Return whether a place is within an odd number of outlines, by matplotlib."""
    return sum(Path(each.T).contains_point((longitude, latitude)) for each in outlines) % 2 == 1


WORLD = MapFrame(-180.0, -90.0, 180.0, 90.0)


@pytest.mark.parametrize(
    ('place', 'latitude', 'longitude', 'on_land'),
    [
        ('London', 51.5, -0.12, True),
        ('Madeira, which 1:110m lacks', 32.75, -17.0, True),
        ('Jamaica', 18.15, -77.3, True),
        ('south of Jamaica', 17.5, -77.3, False),
        ('the Caspian, water within land', 42.0, 50.5, False),
        ('Chukotka, beyond 180', 67.0, -175.0, True),
        ('the south pole', -89.5, 100.0, True),
    ],
)
def test_known_places_are_on_land_or_at_sea(place, latitude, longitude, *, on_land):
    about = MapFrame(longitude - 5.0, max(latitude - 4.0, -90.0), longitude + 5.0, latitude + 4.0)
    for within in (WORLD, about):
        assert is_land(land(within), longitude, latitude) == on_land, place


def test_the_same_land_lies_a_turn_further_east() -> None:
    here, there = MapFrame(140.0, -50.0, 180.0, 0.0), MapFrame(-220.0, -50.0, -180.0, 0.0)
    for one, other in zip(land(here), land(there), strict=True):
        np.testing.assert_allclose(one[0] - 360.0, other[0], atol=1e-9)
        np.testing.assert_allclose(one[1], other[1], atol=1e-9)


def test_outlines_are_closed_and_keep_to_their_frame() -> None:
    of = MapFrame(-84.0, 6.0, 47.0, 61.0)
    outlines = land(of)
    # a page that shows half of the Atlantic stays small
    assert sum(outline.shape[1] for outline in outlines) < 12_000
    for x, y in outlines:
        assert (x[0], y[0]) == (x[-1], y[-1])
        assert of.west <= x.min() <= x.max() <= of.east
        assert of.south <= y.min() <= y.max() <= of.north


def test_the_area_of_ireland_is_known() -> None:
    """84,421 km² (Ordnance Survey Ireland), at 1:50 million to some percent."""
    (outline,) = (
        each for each in land(MapFrame(-11.0, 51.0, -5.0, 56.0)) if is_land([each], -8.0, 53.3)
    )
    x, y = np.radians(outline)
    # the cylinder of Lambert keeps areas
    z, radius_km = np.sin(y), 6371.0
    area = 0.5 * abs(float(np.sum(x[:-1] * z[1:] - x[1:] * z[:-1]))) * radius_km**2
    assert area == pytest.approx(84_421.0, rel=0.03)


def test_a_frame_holds_its_places_and_has_the_ratio_asked_for() -> None:
    found = map_frame(np.array([-76.8, -1.1, math.nan]), np.array([17.9, 50.8, 0.0]), 1.5)
    assert found.west < -76.8
    assert found.east > -1.1
    assert found.south < 17.9
    assert found.north > 50.8
    wide = (found.east - found.west) / found.stretch
    assert wide / (found.north - found.south) == pytest.approx(1.5, rel=0.02)
    still = map_frame(np.array([5.0]), np.array([60.0]))
    assert still.north - still.south == pytest.approx(0.5)


def test_ports_have_names_and_the_open_sea_has_none() -> None:
    assert place_name(32.6, -16.9) == 'Madeira'
    assert place_name(17.93, -76.84) == 'Jamaica'
    assert place_name(-20.2, 57.5 - 360.0) == 'Mauritius'
    assert place_name(40.0, -40.0) == ''


@pytest.mark.parametrize(
    ('place', 'least', 'most'),
    [
        ((48.86, 2.35), 140.0, 185.0),  # Paris: Dieppe is 145 km away, Le Havre 175
        ((43.60, 1.44), 135.0, 155.0),  # Toulouse: Narbonne's coast
        ((51.51, -0.13), 20.0, 60.0),  # London: the estuary of the Thames
        ((40.42, -3.70), math.inf, math.inf),  # Madrid, 300 km from Valencia
        ((66.5, 185.0), 1.0, 60.0),  # Chukotka, beyond the dateline
        ((66.5, -175.0), 1.0, 60.0),
        ((0.0, -25.0), 0.0, 0.0),
        ((42.0, 50.5), 0.0, 0.0),  # the Caspian Sea, an outline within an outline
    ],
)
def test_towns_have_their_known_distance_from_the_sea(place, least, most):
    assert least <= inland_km(*place) <= most


def test_the_squares_of_open_sea_hold_no_place_on_land() -> None:
    """Against matplotlib's count of outlines, with half of the places on the sides of squares."""
    random = np.random.default_rng(1)
    places = np.column_stack(
        [random.uniform(-80.0, 80.0, 600), random.uniform(-180.0, 180.0, 600)]
    )
    places[::2] = np.round(places[::2])
    outlines = land(WORLD)
    within = sum(Path(each.T).contains_points(places[1::2, ::-1]).astype(int) for each in outlines)
    shown = [inland_km(*place) > 0.0 for place in places[1::2].tolist()]
    # the outlines of a world map are thinned to a third of a degree, at the coast
    near = np.array([coast_km(*place) < 60.0 for place in places[1::2].tolist()])
    assert np.all((np.array(shown) == (within % 2 == 1)) | near)
    assert 0.2 < np.mean(shown) < 0.5
    for latitude, longitude in places.tolist():
        assert (inland_km(latitude, longitude) > 0.0) == _is_land(latitude, longitude)


@pytest.mark.parametrize(
    ('place', 'least', 'most'),
    [
        ((42.88, -10.27), 76.0, 88.0),  # a degree west of Cape Finisterre: 81.7 km
        ((43.60, 1.44), 135.0, 155.0),  # Toulouse: from the land's side too
        ((-30.0, 0.0), math.inf, math.inf),
    ],
)
def test_the_coast_is_as_far_from_the_sea_as_from_the_land(place, least, most):
    assert least <= coast_km(*place) <= most
    assert coast_km(place[0], place[1] + 360.0) == pytest.approx(coast_km(*place), rel=1e-9)


@pytest.mark.parametrize(
    ('latitude', 'longitude', 'ocean'),
    [
        (47.0, -8.0, 'North Atlantic'),  # Biscay
        (23.5, -82.0, 'North Atlantic'),  # off Havana
        (8.0, -80.5, 'North Pacific'),  # the bay of Panama
        (-35.5, -54.0, 'South Atlantic'),  # off the River Plate
        (-57.0, -67.0, 'South Atlantic'),  # either side of the Horn
        (-57.0, -68.0, 'South Pacific'),
        (-12.0, -78.0, 'South Pacific'),  # Callao
        (-36.0, 19.0, 'South Atlantic'),  # either side of the Cape
        (-36.0, 21.0, 'Indian Ocean'),
        (29.9, 48.5, 'Indian Ocean'),  # the head of the gulf of Persia
        (31.5, 30.0, 'North Atlantic'),  # Alexandria, and Archangel
        (65.0, 39.5, 'North Atlantic'),
        (76.0, 60.0, 'North Atlantic'),
        (-10.0, 105.0, 'Indian Ocean'),  # south and north of Java
        (-5.0, 110.0, 'South Pacific'),
        (14.0, 120.0, 'North Pacific'),  # off Manila
        (-43.0, 150.0, 'South Pacific'),  # east of Tasmania
        (10.0, 181.0, 'North Pacific'),
    ],
)
def test_seas_belong_to_their_ocean(latitude: float, longitude: float, ocean: str) -> None:
    """By the limits of the International Hydrographic Organization, but for polar seas."""
    assert ocean_of(latitude, longitude) == ocean
    assert ocean_of(latitude, longitude - 360.0) == ocean
