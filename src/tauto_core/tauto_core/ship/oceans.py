"""The ocean in which a place at sea lies.

The meridians that part them are those of the International Hydrographic Organization (Limits of
Oceans and Seas, 1953): Cape Agulhas, the South East Cape of Tasmania, Cape Horn. Inner seas count
with their ocean. North of Australia a line through the islands, and the Isthmus of America by a
few points, take the place of coasts.
"""

from __future__ import annotations

import math

import numpy as np

OCEANS = (
    'North Atlantic',
    'South Atlantic',
    'Indian Ocean',
    'North Pacific',
    'South Pacific',
)

_AGULHAS_DEG, _TASMANIA_DEG, _HORN_DEG = 20.0, 146.8167, -67.2667
_ISLES_DEG = -8.0
"""Latitude of the islands from Java to Timor, north of which the Pacific begins at Sumatra."""
_SUMATRA_DEG = 100.0

# fmt: off
_DIVIDE_DEG = np.array([
    (-56.0, -67.27), (-50.0, -72.0), (-40.0, -71.5), (-18.0, -69.5), (-5.0, -78.0), (0.0, -77.0),
    (5.0, -76.8), (7.5, -77.0), (9.2, -80.0), (9.3, -83.0), (10.5, -84.5), (14.5, -89.5),
    (17.0, -94.5), (20.0, -100.0), (30.0, -108.0), (60.0, -125.0),
])
# fmt: on
"""Latitudes and longitudes of points between the oceans in America, from Cape Horn northwards."""


def ocean_of(latitude: float, longitude: float) -> str:
    """Return the one of `OCEANS` in which a place lies, in degrees; the equator is northern."""
    east = math.remainder(longitude, 360.0)
    north = latitude >= 0.0
    divide = _HORN_DEG if latitude < _DIVIDE_DEG[0, 0] else np.interp(latitude, *_DIVIDE_DEG.T)
    if divide <= east < _AGULHAS_DEG:
        return OCEANS[0] if north else OCEANS[1]
    ends_deg = _TASMANIA_DEG if latitude < _ISLES_DEG else _SUMATRA_DEG
    if _AGULHAS_DEG <= east < ends_deg:
        return OCEANS[2]
    return OCEANS[3] if north else OCEANS[4]
