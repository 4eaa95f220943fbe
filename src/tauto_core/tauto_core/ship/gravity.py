"""Gravity on the way: normal gravity by latitude, and Eötvös' term of a ship that moves.

Gravity at the ellipsoid of WGS 84 depends on the latitude φ alone (Somigliana 1929; NIMA TR8350.2,
3rd ed., section 4.2). A ship that sails east turns faster than the Earth, so that what she carries
weighs less (Eötvös 1919).
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene.times import NS_PER_S
from tauto_core.ship.passage import EQUATOR_M, SQUARED_ECCENTRICITY, Passage

EQUATOR_M_S2 = 9.7803253359
"""Normal gravity at the equator."""

SOMIGLIANA = 0.00193185265241
"""Somigliana's k = (b γ_pole)/(a γ_equator) − 1."""

EARTH_RATE = 7.292115e-5
"""Rotation of the Earth [rad/s]."""

KNOT_S = 60
"""Time between the knots of `GravityOnTheWay` [s].

Between them gravity is linear: at 5 m/s this is wrong by less than 1e-10 m/s², at 50 m/s by
less than 1e-8. Where she sails or alters course, Eötvös' term changes over two intervals.
"""


def normal_gravity(latitude_rad: FloatArray | float) -> FloatArray:
    """Return the gravity of the ellipsoid of WGS 84, at its surface [m/s²].

    γ(φ) = γ_e (1 + k sin²φ)/√(1 − e² sin²φ).

    Args:
        latitude_rad: geodetic latitude φ [rad], any shape.
    """
    return _of_squared_sine(np.asarray(np.sin(latitude_rad) ** 2))


def _of_squared_sine(squared: FloatArray) -> FloatArray:
    """Return normal gravity for sin²φ."""
    return np.asarray(
        EQUATOR_M_S2 * (1.0 + SOMIGLIANA * squared) / np.sqrt(1.0 - SQUARED_ECCENTRICITY * squared)
    )


def eotvos(
    latitude_rad: FloatArray | float, east: FloatArray | float, north: FloatArray | float
) -> FloatArray:
    """Return by how much less a mass weighs on a ship that moves [m/s²].

    2 Ω v_E cos φ + v_E²/N + v_N²/M, with the ellipsoid's radii of curvature N across the meridian
    and M along it.

    Args:
        latitude_rad: geodetic latitude φ [rad].
        east: speed over the ground towards the east, v_E [m/s].
        north: speed towards the north, v_N [m/s].
    """
    squeezed = 1.0 - SQUARED_ECCENTRICITY * np.sin(latitude_rad) ** 2
    across = EQUATOR_M / np.sqrt(squeezed)
    along = across * (1.0 - SQUARED_ECCENTRICITY) / squeezed
    turning = 2.0 * EARTH_RATE * np.cos(latitude_rad) * np.asarray(east)
    return np.asarray(turning + np.square(east) / across + np.square(north) / along)


def gravity_between(
    elapsed_s: FloatArray, latitude: FloatArray, longitude: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return normal gravity at places (n,), and Eötvös' term between them (n - 1,) [m/s²].

    Each value depends on its own places alone.

    Args:
        elapsed_s: time from each place to the next [s], (n - 1,).
        latitude: degrees north, (n,).
        longitude: degrees east.
    """
    # the bits of np.sin may depend on the place in an array
    sine = np.array([math.sin(math.radians(each)) for each in latitude.tolist()])
    turn = np.diff(longitude)
    turn = np.radians(turn - 360.0 * np.round(turn / 360.0)) / elapsed_s
    middle = 0.5 * (sine[1:] + sine[:-1])
    squeezed = 1.0 - SQUARED_ECCENTRICITY * middle * middle
    across = EQUATOR_M / np.sqrt(squeezed)
    along = across * (1.0 - SQUARED_ECCENTRICITY) / squeezed
    cosine = np.sqrt(1.0 - middle * middle)
    east = across * cosine * turn
    north = along * np.radians(np.diff(latitude)) / elapsed_s
    lifted = 2.0 * EARTH_RATE * cosine * east + east * east / across + north * north / along
    return _of_squared_sine(sine * sine), lifted


class GravityOnTheWay:
    """Vertical specific force on a ship without waves, γ(φ) less Eötvös' term, along a passage.

    It is piecewise linear, with a knot every `KNOT_S`. The speeds are those between the knots on
    either side.

    Args:
        passage: the way.
        duration_ns: last time needed, from the start of the scene [ns]; later ones have
            the last value.
    """

    def __init__(self, passage: Passage, duration_ns: int) -> None:
        step = KNOT_S * NS_PER_S
        # one knot more on either side, for the speeds at the first and the last
        self._knots_ns: IntArray = np.arange(-1, duration_ns // step + 3, dtype=np.int64) * step
        latitude_deg, longitude_deg = passage.places(self._knots_ns)
        latitude, longitude = np.radians(latitude_deg), np.radians(longitude_deg)
        turn = longitude[2:] - longitude[:-2]
        eastward = turn - 2.0 * np.pi * np.round(turn / (2.0 * np.pi))
        squeezed = 1.0 - SQUARED_ECCENTRICITY * np.sin(latitude[1:-1]) ** 2
        across = EQUATOR_M / np.sqrt(squeezed)
        along = across * (1.0 - SQUARED_ECCENTRICITY) / squeezed
        here = latitude[1:-1]
        east = across * np.cos(here) * eastward / (2.0 * KNOT_S)
        north = along * (latitude[2:] - latitude[:-2]) / (2.0 * KNOT_S)
        self._knots_ns = self._knots_ns[1:-1]
        self._values = normal_gravity(here) - eotvos(here, east, north)

    def at(self, time_ns: IntArray) -> FloatArray:
        """Return the gravity at some times from the start of the scene [m/s²], (n,).

        Each value depends on its time alone.
        """
        step = KNOT_S * NS_PER_S
        knot = np.minimum(time_ns // step, len(self._values) - 2)
        part = np.clip((time_ns - knot * step) / step, 0.0, 1.0)
        first = self._values[knot]
        found: FloatArray = first + part * (self._values[knot + 1] - first)
        return found
