"""Where the ship truly is."""

from __future__ import annotations

import numpy as np
from geographiclib.geodesic import Geodesic

from tauto_core.samples import FixSamples, FloatArray, IntArray
from tauto_core.scene import Scene
from tauto_core.scene.times import nanoseconds

FRAME_ID = 'clock_mount'
STATUS_FIX = 0
SERVICE_UNKNOWN = 0
COVARIANCE_DIAGONAL_KNOWN = 2
POSITION_VARIANCE_M2 = 1.0
"""Variance of each coordinate that is taken as known [m²]: NavSatFix readers refuse zeros."""


class Route:
    """The voyage along the geodesic of WGS 84 from departure to arrival (Karney, J. Geod. 2013).

    Until `voyage.sails_at` the ship lies at the departure, from `voyage.arrives_at` on at the
    arrival, in between it makes constant speed. Without a voyage it lies at 0°, 0°, where a
    minute of longitude is a nautical mile.

    Attributes:
        length_m: length of the geodesic [m].
    """

    def __init__(self, scene: Scene) -> None:
        voyage = scene.voyage
        self._departure = voyage.departure if voyage else (0.0, 0.0)
        self._arrival = voyage.arrival if voyage else (0.0, 0.0)
        self._sails_ns = scene.starts_at_ns + (nanoseconds(voyage.sails_at) if voyage else 0)
        self._arrives_ns = scene.starts_at_ns + (nanoseconds(voyage.arrives_at) if voyage else 0)
        self._line = Geodesic.WGS84.InverseLine(
            *self._departure, *self._arrival, Geodesic.STANDARD | Geodesic.DISTANCE_IN
        )
        self.length_m: float = self._line.s13

    def fixes(self, stamp_ns: IntArray) -> FixSamples:
        """Return the true positions at some stamps [ns]; degrees, altitude 0, frame `clock_mount`.

        The frame is that of the place whose position is told, as NavSatFix asks. Each position
        depends on its own stamp alone.
        """
        places = np.full((len(stamp_ns), 2), self._departure)
        places[stamp_ns >= self._arrives_ns] = self._arrival
        at_sea = np.flatnonzero((stamp_ns > self._sails_ns) & (stamp_ns < self._arrives_ns))
        for index in at_sea.tolist():
            places[index] = self._place(int(stamp_ns[index]))
        variances = np.full((len(stamp_ns), 3), POSITION_VARIANCE_M2)
        latitude, longitude = np.ascontiguousarray(places.T)
        return fix_samples(stamp_ns, latitude, longitude, variances)

    def _place(self, stamp: int) -> tuple[float, float]:
        part = (stamp - self._sails_ns) / (self._arrives_ns - self._sails_ns)
        position = self._line.Position(
            part * self.length_m, Geodesic.LATITUDE | Geodesic.LONGITUDE
        )
        return position['lat2'], position['lon2']


def fix_samples(
    stamp_ns: IntArray, latitude: FloatArray, longitude: FloatArray, variances_m2: FloatArray
) -> FixSamples:
    """Return positions as NavSatFix tells them, with a valid fix at altitude 0.

    Args:
        stamp_ns: stamps [ns], (n,).
        latitude: degrees, north positive, (n,).
        longitude: degrees, east positive, (n,).
        variances_m2: variances of east, north, up [m²], (n, 3).
    """
    n = len(stamp_ns)
    covariance = np.zeros((n, 9))
    covariance[:, [0, 4, 8]] = variances_m2
    return FixSamples(
        stamp_ns,
        FRAME_ID,
        np.full(n, STATUS_FIX, np.int8),
        np.full(n, SERVICE_UNKNOWN, np.uint16),
        latitude,
        longitude,
        np.zeros(n),
        covariance,
        np.full(n, COVARIANCE_DIAGONAL_KNOWN, np.uint8),
    )
