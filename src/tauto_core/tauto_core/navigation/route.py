"""The true positions of the ship."""

from __future__ import annotations

import numpy as np

from tauto_core.samples import FixSamples, FloatArray, IntArray
from tauto_core.scene import Scene
from tauto_core.ship import Passage

FRAME_ID = 'clock_mount'
STATUS_FIX = 0
SERVICE_UNKNOWN = 0
COVARIANCE_DIAGONAL_KNOWN = 2
POSITION_VARIANCE_M2 = 1.0
"""Variance of each known coordinate [m²]; some readers of NavSatFix refuse zeros."""


class Route:
    """The true positions of a scene's ship, as fixes.

    Until `voyage.sails_at` the ship lies at the departure, and after its arrival at the arrival.
    In between it moves at constant speed over the waypoints (`ship.Passage`). Without a voyage it
    lies at 0°, 0°, where a minute of longitude is a nautical mile.

    Attributes:
        length_m: length of the route [m]; 0 without a voyage.

    Raises:
        SceneError: a route that cannot be sailed, as `Passage` says.
    """

    def __init__(self, scene: Scene) -> None:
        self._starts_at_ns = scene.starts_at_ns
        self._passage = None if scene.voyage is None else Passage(scene, scene.voyage)
        self.length_m = 0.0 if self._passage is None else self._passage.length_m

    def fixes(self, stamp_ns: IntArray) -> FixSamples:
        """Return the true positions at some stamps [ns]; degrees, altitude 0, frame `clock_mount`.

        The frame is at the place whose position is given, as NavSatFix requires. Each position
        depends on its own stamp alone.
        """
        if self._passage is None:
            latitude, longitude = np.zeros((2, len(stamp_ns)))
        else:
            latitude, longitude = self._passage.places(stamp_ns - self._starts_at_ns)
        variances = np.full((len(stamp_ns), 3), POSITION_VARIANCE_M2)
        return fix_samples(stamp_ns, latitude, longitude, variances)


def fix_samples(
    stamp_ns: IntArray, latitude: FloatArray, longitude: FloatArray, variances_m2: FloatArray
) -> FixSamples:
    """Return positions as NavSatFix samples, with a valid fix at altitude 0.

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
