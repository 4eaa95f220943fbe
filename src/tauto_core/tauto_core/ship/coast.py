"""The coasts of the world for maps: Natural Earth's land at 1:50 million, cut to a frame.

`land` returns outlines in degrees, and a `Chart` with `is_map` draws them. Longitudes may run
beyond ±180°, for voyages across the Pacific. `place_name` names a port, `ocean_of` the ocean.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tauto_core.samples import FloatArray

if TYPE_CHECKING:
    from tauto_core.scene.sections import Itinerary

HUNDREDTH_DEG = 0.01
"""Unit of the stored coordinates [°], 0.6 nautical miles of latitude."""
FINEST = 1000
"""Coasts are thinned to this number of steps across a frame, about a pixel each."""
NARROWEST_DEG = 0.5
"""Least height and width of a frame [°]: 30 nautical miles of latitude."""
MARGIN = 0.06
"""Margin about the places of a map, as a share of the larger side of its frame."""
STEEPEST_DEG = 84.0
"""Largest latitude [°] to which the scale of a map follows the meridians."""


class MapFrame(NamedTuple):
    """The sides of a map [°], with west < east and south < north."""

    west: float
    south: float
    east: float
    north: float

    @property
    def stretch(self) -> float:
        """Length of a degree of latitude over a degree of longitude, in the middle of the map."""
        middle = min(abs(0.5 * (self.south + self.north)), STEEPEST_DEG)
        return 1.0 / math.cos(math.radians(middle))


def map_frame(longitude: FloatArray, latitude: FloatArray, ratio: float = 0.0) -> MapFrame:
    """Return the frame of places [°], with a margin about them.

    Args:
        longitude, latitude: (n,), n > 0. Values that are not finite are ignored.
        ratio: width over height of the drawn map, to which the shorter side is enlarged, or 0.
    """
    finite = np.isfinite(longitude) & np.isfinite(latitude)
    x, y = longitude[finite], latitude[finite]
    west, east, south, north = (float(bound) for bound in (x.min(), x.max(), y.min(), y.max()))
    stretch = MapFrame(west, south, east, north).stretch
    # sides in degrees of latitude
    wide, high = (east - west) / stretch, north - south
    margin = 2.0 * MARGIN * max(wide, high)
    wide, high = (max(side + margin, NARROWEST_DEG) for side in (wide, high))
    if ratio:
        wide, high = max(wide, ratio * high), max(high, wide / ratio)
    wide, high = min(wide * stretch, 360.0), min(high, 180.0)
    middle = min(max(0.5 * (south + north), 0.5 * high - 90.0), 90.0 - 0.5 * high)
    centre = 0.5 * (west + east)
    return MapFrame(
        centre - 0.5 * wide, middle - 0.5 * high, centre + 0.5 * wide, middle + 0.5 * high
    )


def land(of: MapFrame) -> list[FloatArray]:
    """Return the land within a frame as closed outlines, (2, n) each: longitude, latitude [°].

    Points beyond the frame are moved to its sides, so an outline may be off by a step there. An
    outline within another is water: fill all by the even-odd rule. They are thinned to a
    thousandth of the frame.
    """
    west, south, east, north = of
    finest = max(max(east - west, north - south) / FINEST, HUNDREDTH_DEG)
    outlines = []
    for outline in _outlines():
        low, high = outline.min(axis=1), outline.max(axis=1)
        if high[1] < south or low[1] > north:
            continue
        west_turn = math.ceil((west - high[0]) / 360.0)
        east_turn = math.floor((east - low[0]) / 360.0)
        # keep the first point in each square of a grid. Small islands keep all: St Helena is a
        # destination
        cell = np.floor(outline / finest)
        mask = np.concatenate(([True], np.any(np.diff(cell, axis=1) != 0.0, axis=0)))
        mask[-1] = True
        thinned = outline[:, mask] if mask.sum() > 8 else outline
        for turn in range(west_turn, east_turn + 1):
            x = np.clip(thinned[0] + 360.0 * turn, west, east)
            y = np.clip(thinned[1], south, north)
            # what lies outside has no area
            if abs(float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))) < 1e-6:
                continue
            shape = np.stack((x, y))
            stays = shape[:, 1:] == shape[:, :-1]
            shape = shape[:, np.append([True], ~stays.all(axis=0))]
            # nor are the points needed that lie between two others of a side
            stays = shape[:, 1:] == shape[:, :-1]
            between = np.any(stays[:, 1:] & stays[:, :-1], axis=0)
            outlines.append(shape[:, np.concatenate(([True], ~between, [True]))])
    return outlines


@cache
def _outlines() -> tuple[FloatArray, ...]:
    """Return the outlines of all land, the longest first, (2, n) each [°]."""
    with np.load(Path(__file__).with_name('coasts.npz')) as data:
        steps, length = data['steps'].astype(np.int64), data['length']
    ends = np.cumsum(length)
    return tuple(
        HUNDREDTH_DEG * np.cumsum(steps[:, end - count : end], axis=1)
        for end, count in zip(ends.tolist(), length.tolist(), strict=True)
    )


NAMED_NMI = 60.0
"""Distance up to which a place has the name of a port or island [nmi]."""

PLACES = {
    'Portsmouth': (50.80, -1.10),
    'Plymouth': (50.37, -4.14),
    'Deptford': (51.48, -0.02),
    'Texel': (53.05, 4.80),
    'Brest': (48.38, -4.49),
    'Lorient': (47.75, -3.37),
    'Bordeaux': (44.84, -0.58),
    'Cádiz': (36.53, -6.29),
    'Lisbon': (38.70, -9.17),
    'Gibraltar': (36.14, -5.35),
    'Madeira': (32.65, -16.90),
    'Tenerife': (28.47, -16.25),
    'Cape Verde': (14.92, -23.51),
    'St Helena': (-15.92, -5.72),
    'Cape of Good Hope': (-33.90, 18.43),
    'Mauritius': (-20.16, 57.50),
    'Bombay': (18.93, 72.84),
    'Madras': (13.08, 80.29),
    'Batavia': (-6.13, 106.81),
    'Canton': (22.20, 113.54),
    'Botany Bay': (-33.99, 151.23),
    'Tahiti': (-17.50, -149.50),
    'Cape Horn': (-55.98, -67.27),
    'Rio de Janeiro': (-22.91, -43.17),
    'Barbados': (13.10, -59.62),
    'Antigua': (17.12, -61.85),
    'Martinique': (14.60, -61.07),
    'Jamaica': (17.94, -76.84),
    'Saint-Domingue': (19.76, -72.20),
    'Havana': (23.14, -82.35),
    'Boston': (42.36, -71.05),
    'New York': (40.70, -74.02),
    'Halifax': (44.65, -63.57),
    'Québec': (46.81, -71.20),
}
"""Ports and islands of the age of sail: latitude north, longitude east [°]."""


def place_name(latitude: float, longitude: float) -> str:
    """Return the name of the nearest of `PLACES`, or '' if it is farther than `NAMED_NMI`."""
    east = math.cos(math.radians(latitude))

    def away_nmi(name: str) -> float:
        north_deg, east_deg = PLACES[name]
        turned = math.remainder(longitude - east_deg, 360.0)
        return 60.0 * math.hypot(latitude - north_deg, east * turned)

    nearest = min(PLACES, key=away_nmi)
    return nearest if away_nmi(nearest) <= NAMED_NMI else ''


# -----------------------------------------------------------------------------
# Places on land.

_KM_PER_DEG = 60.0 * 1.852
# Largest distance at which a coast is sought.
_FARTHEST_KM = 200.0
# Bands of a degree on either side that cover it: 220 km.
_REACH = 2


@cache
def _sides() -> tuple[FloatArray, ...]:
    """Return the sides of all outlines, for each degree of latitude from the south.

    Each array, (4, n), holds longitude and latitude of both ends [°].
    """
    sides = np.concatenate(
        [np.concatenate((line[:, :-1], line[:, 1:])) for line in _outlines()], axis=1
    )
    low, high = np.minimum(sides[1], sides[3]), np.maximum(sides[1], sides[3])
    bands = range(-90, 91)
    return tuple(sides[:, (low < band + 1) & (high >= band)] for band in bands)


def inland_km(latitude: float, longitude: float) -> float:
    """Return the distance of a place on land from the nearest coast [km].

    It is 0 at sea, and inf beyond 200 km. The coasts are good to a few kilometres. Islands that
    are not on the map are sea.
    """
    square = math.floor(latitude), math.floor(math.remainder(longitude, 360.0))
    at_sea = _is_open(*square) or not _is_land(latitude, longitude)
    return 0.0 if at_sea else coast_km(latitude, longitude)


def _is_land(latitude: float, longitude: float) -> bool:
    """Return whether the parallel to the east of a place crosses an odd number of coasts."""
    x, y, to_x, to_y = _sides()[math.floor(latitude) + 90]
    crossed = (y <= latitude) != (to_y <= latitude)
    where = x[crossed] + (latitude - y[crossed]) * (to_x - x)[crossed] / (to_y - y)[crossed]
    return any(np.count_nonzero(where > east) % 2 for east in _turns(longitude))


@cache
def _is_open(south: int, west: int) -> bool:
    """Return whether a square of a degree has neither land nor coast, as for most log entries."""
    x, _, to_x, _ = _sides()[south + 90]
    low, high = np.minimum(x, to_x), np.maximum(x, to_x)
    begins = np.array(_turns(west + 0.5))[:, None] - 0.5
    has_coast = np.any((low <= begins + 1.0) & (high >= begins))
    return not (has_coast or _is_land(south + 0.5, west + 0.5))


LANDFALL_KM = 30.0
"""Largest distance from the coast of a landfall [km]. The maps err by less."""


def no_landfall(latitude: float, longitude: float) -> str | None:
    """Return a text if a place at sea is too far from the coast for a landfall, else `None`."""
    offing = coast_km(latitude, longitude)
    if inland_km(latitude, longitude) or offing <= LANDFALL_KM:
        return None
    distance = 'more than 200' if math.isinf(offing) else f'{offing:.0f}'
    return f'at sea, {distance} km from the coast: no landfall'


def ends_of(voyage: Itinerary | None, duration_s: float) -> dict[str, str]:
    """Return `ends` of a result if the whole log is sailed and ends without a landfall."""
    log = None if voyage is None else voyage.log
    if log is None or log.at[-1] > duration_s:
        return {}
    where = no_landfall(*log.entries[-1][1:3])
    return {} if where is None else {'ends': where}


def coast_km(latitude: float, longitude: float) -> float:
    """Return the distance of a place, at sea or on land, from the nearest coast [km].

    It is inf beyond 200 km.
    """
    band, west, east = _sides_about(math.floor(latitude))
    scale = np.array([[math.cos(math.radians(latitude))], [1.0]]) * _KM_PER_DEG
    reach = _FARTHEST_KM / float(scale[0, 0])
    nearest = math.inf
    for meridian in _turns(longitude):
        sides = band[:, (west <= meridian + reach) & (east >= meridian - reach)]
        way = (sides[2:] - sides[:2]) * scale
        begin = (sides[:2] - np.array([[meridian], [latitude]])) * scale
        square = np.maximum(np.sum(way * way, axis=0), 1e-12)
        share = np.clip(-np.sum(begin * way, axis=0) / square, 0.0, 1.0)
        nearest = min(nearest, float(np.min(np.hypot(*(begin + share * way)), initial=math.inf)))
    return nearest if nearest < _FARTHEST_KM else math.inf


@cache
def _sides_about(south: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the sides of outlines near a band from `south` [°], their west and east ends."""
    bands, band = _sides(), south + 90
    sides = np.concatenate(bands[max(band - _REACH, 0) : band + _REACH + 1], axis=1)
    return sides, np.minimum(sides[0], sides[2]), np.maximum(sides[0], sides[2])


def _turns(longitude: float) -> tuple[float, float, float]:
    """Return a longitude [°] and its equivalents, as some outlines run beyond ±180°."""
    middle = math.remainder(longitude, 360.0)
    return middle, middle - 360.0, middle + 360.0


# -----------------------------------------------------------------------------
# Oceans, parted by meridians of the International Hydrographic Organization (Limits of Oceans and
# Seas, 1953): Cape Agulhas, the South East Cape of Tasmania, Cape Horn. Inner seas count with
# their ocean, the Mediterranean and the polar seas of Europe with the Atlantic. A line through the
# islands north of Australia and a few points along America replace the coasts.

OCEANS = ('North Atlantic', 'South Atlantic', 'Indian Ocean', 'North Pacific', 'South Pacific')

_AGULHAS_DEG, _TASMANIA_DEG, _HORN_DEG = 20.0, 146.8167, -67.2667
# Latitude of the islands from Java to Timor. North of it the Pacific begins at Sumatra.
_ISLES_DEG = -8.0
_SUMATRA_DEG = 100.0
# North of the gulfs of Suez and Persia no water east of 20° E belongs to the Indian Ocean.
_SUEZ_DEG = 30.5

# fmt: off
_DIVIDE_DEG = np.array([
    (-56.0, -67.27), (-50.0, -72.0), (-40.0, -71.5), (-18.0, -69.5), (-5.0, -78.0), (0.0, -77.0),
    (5.0, -76.8), (7.5, -77.0), (9.2, -80.0), (9.3, -83.0), (10.5, -84.5), (14.5, -89.5),
    (17.0, -94.5), (20.0, -100.0), (30.0, -108.0), (60.0, -125.0),
])
# fmt: on
"""Latitude and longitude of the divide between the oceans in America, from Cape Horn north."""


def ocean_of(latitude: float, longitude: float) -> str:
    """Return the ocean of a place [°], one of `OCEANS`. The equator is northern."""
    east = math.remainder(longitude, 360.0)
    north = latitude >= 0.0
    divide = _HORN_DEG if latitude < _DIVIDE_DEG[0, 0] else np.interp(latitude, *_DIVIDE_DEG.T)
    if divide <= east < _AGULHAS_DEG:
        return OCEANS[0] if north else OCEANS[1]
    ends_deg = _TASMANIA_DEG if latitude < _ISLES_DEG else _SUMATRA_DEG
    if _AGULHAS_DEG <= east < ends_deg:
        return OCEANS[0] if latitude > _SUEZ_DEG else OCEANS[2]
    return OCEANS[3] if north else OCEANS[4]
