"""The passage: legs on WGS 84, and the ship's position at each time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev
from numpy.polynomial.legendre import leggauss

from tauto_core.curves.numerics import chebyshev_coefficients, chebyshev_nodes
from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene.errors import SceneError
from tauto_core.scene.sections import (
    HIGHEST_LATITUDE_DEG,
    WIDEST_AWARD_NMI,
    Itinerary,
    key_of_place,
)
from tauto_core.scene.times import NS_PER_S, nanoseconds
from tauto_core.ship.motions import Surroundings

# -----------------------------------------------------------------------------
# Legs of a voyage on WGS 84: geodesics and rhumb lines, as Chebyshev series along the route.
#
# A series needs additions and multiplications only, so the bits of a sample do not depend on its
# index in the array. Other elementary functions come from `math`, sample by sample.

EQUATOR_M = 6_378_137.0
FLATTENING = 1.0 / 298.257223563
SQUARED_ECCENTRICITY = FLATTENING * (2.0 - FLATTENING)

# the truncated terms of cos(σ) over half a turn, and of f³, are below rounding
_GEODESIC_NODES = 32
# enough for the secant of the latitude from 89.7° south to 89.7° north, the hardest leg
_RHUMB_NODES = 512
_QUADRATURE_NODES, _QUADRATURE_WEIGHTS = leggauss(32)


def wrap(angle: FloatArray, half_turn: float = 180.0) -> FloatArray:
    """Return angles in [−half a turn, half a turn). Values in the range keep their bits."""
    is_inside = (angle >= -half_turn) & (angle < half_turn)
    wrapped = np.mod(angle + half_turn, 2.0 * half_turn) - half_turn
    # mod rounds numbers just below a turn up to it
    wrapped = np.where(wrapped < half_turn, wrapped, -half_turn)
    return np.where(is_inside, angle, wrapped)


@dataclass(frozen=True)
class GeodesicLeg:
    """The shortest route (Karney, J. Geod. 87, 2013), by the direction of the vertical along it.

    Attributes:
        length_m: length [m].
        highest_deg: largest |latitude| [degrees].
        vertical: Chebyshev coefficients of (cos φ cos λ, cos φ sin λ, sin φ), (m, 3).
    """

    length_m: float
    highest_deg: float
    vertical: FloatArray

    def places(self, part: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return latitudes, and longitudes in [−180, 180), at shares of the leg [degrees], (n,).

        The bits of each place depend on its own share alone.
        """
        x, y, z = chebyshev.chebval(2.0 * part - 1.0, self.vertical).tolist()
        latitude = [
            math.degrees(math.atan2(c, math.hypot(a, b))) for a, b, c in zip(x, y, z, strict=True)
        ]
        longitude = [math.degrees(math.atan2(b, a)) for a, b in zip(x, y, strict=True)]
        return np.array(latitude), wrap(np.array(longitude))

    def course(self, part: float) -> float:
        """Return the course at a share of the leg, from north to the east [rad], 0 to 2π.

        It follows from the derivative of the vertical: M dφ north, N cos φ dλ east.
        """
        along = 2.0 * part - 1.0
        turning = chebyshev.chebder(self.vertical)
        x, y, z = np.asarray(chebyshev.chebval(along, self.vertical)).tolist()
        dx, dy, dz = np.asarray(chebyshev.chebval(along, turning)).tolist()
        across = math.hypot(x, y)
        north, east = dz * across - z * (x * dx + y * dy) / across, (x * dy - y * dx) / across
        # N/M = (1 − e² sin²φ)/(1 − e²)
        to_north = north * (1.0 - SQUARED_ECCENTRICITY)
        return math.atan2(east * (1.0 - SQUARED_ECCENTRICITY * z * z), to_north) % math.tau


@lru_cache(maxsize=4096)  # a scene computes its legs several times, a fleet for each ship
def geodesic_leg(start: tuple[float, float], end: tuple[float, float]) -> GeodesicLeg:
    """Return the geodesic between two places [degrees]."""
    from geographiclib.geodesic import Geodesic

    line = Geodesic.WGS84.InverseLine(*start, *end, Geodesic.STANDARD | Geodesic.DISTANCE_IN)
    length: float = line.s13

    ways = (0.5 * length * (chebyshev_nodes(_GEODESIC_NODES) + 1.0)).tolist()
    points = [line.Position(way, Geodesic.LATITUDE | Geodesic.LONGITUDE) for way in ways]
    latitude, longitude = np.radians([(point['lat2'], point['lon2']) for point in points]).T
    across = np.cos(latitude)
    vertical = np.stack((across * np.cos(longitude), across * np.sin(longitude), np.sin(latitude)))
    azimuths = line.azi1, line.Position(length, Geodesic.AZIMUTH)['azi2']
    return GeodesicLeg(
        length,
        _highest(start[0], end[0], azimuths),
        chebyshev_coefficients(vertical).T,
    )


def _highest(start: float, end: float, azimuths: tuple[float, float]) -> float:
    """Return the largest |latitude| [degrees] of a geodesic, by Clairaut's cos β sin α."""
    northing = [math.cos(math.radians(azimuth)) for azimuth in azimuths]
    if northing[0] * northing[1] >= 0.0:  # the latitude has no extreme between the ends
        return max(abs(start), abs(end))
    reduced = math.atan((1.0 - FLATTENING) * math.tan(math.radians(start)))
    cosine = math.cos(reduced) * abs(math.sin(math.radians(azimuths[0])))
    return math.degrees(math.atan2(math.sqrt(1.0 - cosine * cosine), (1.0 - FLATTENING) * cosine))


@dataclass(frozen=True)
class RhumbLeg:
    """The route of constant course, as series of latitude and longitude.

    Attributes:
        length_m: length [m].
        highest_deg: largest |latitude| [degrees].
        course_deg: course, from north to east.
        latitude: Chebyshev coefficients [degrees].
        longitude: Chebyshev coefficients [degrees], not wrapped.
    """

    length_m: float
    highest_deg: float
    course_deg: float
    latitude: FloatArray
    longitude: FloatArray

    def places(self, part: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the places at shares of the leg, as a `GeodesicLeg` does."""
        along = 2.0 * part - 1.0
        latitude, longitude = (
            np.asarray(chebyshev.chebval(along, series), np.float64)
            for series in (self.latitude, self.longitude)
        )
        return latitude, wrap(longitude)

    def course(self, part: float) -> float:
        """Return the constant course."""
        return math.radians(self.course_deg)


def rhumb_leg(start: tuple[float, float], end: tuple[float, float]) -> RhumbLeg:
    """Return the shorter rhumb line between two places [degrees] (longitude.md).

    On a course α, a distance s changes the meridian arc by dm = cos α ds and the longitude by
    dλ = sin α ds/r, with the radius r of the parallel. So 1/r has the same mean over the leg as
    over the meridian. With the departure p = Δλ/⟨1/r⟩ and the meridian arc Δm, s = √(Δm² + p²) and
    tan α = p/Δm, on any course.
    """
    start_rad, turn = math.radians(start[0]), math.radians(end[0] - start[0])
    eastward = math.remainder(end[1] - start[1], 360.0)

    part = _part_of_turn(start_rad, turn, 0.5 * (chebyshev_nodes(_RHUMB_NODES) + 1.0))
    latitude_rad = start_rad + turn * part
    squeezed = 1.0 - SQUARED_ECCENTRICITY * np.sin(latitude_rad) ** 2
    parallel_m = EQUATOR_M * np.cos(latitude_rad) / np.sqrt(squeezed)
    gained = chebyshev.chebint(_series(1.0 / parallel_m), lbnd=-1)
    over_all = float(chebyshev.chebval(1.0, gained))
    meridian = float(_mean_curvature_m(start_rad, turn, np.ones(1))[0]) * turn
    departure = math.radians(eastward) * 2.0 / over_all
    longitude = np.asarray(gained * (eastward / over_all), np.float64)
    longitude[0] += start[1]
    latitude = (end[0] - start[0]) * _series(part)
    latitude[0] += start[0]
    return RhumbLeg(
        math.hypot(meridian, departure),
        max(abs(start[0]), abs(end[0])),
        math.degrees(math.atan2(departure, meridian)) % 360.0,
        latitude,
        longitude,
    )


def _series(values: FloatArray) -> FloatArray:
    """Return the Chebyshev series through values at the nodes, without terms below rounding."""
    series = chebyshev_coefficients(values)
    return np.asarray(chebyshev.chebtrim(series, 2e-16 * float(np.abs(values).max())), np.float64)


def _part_of_turn(latitude: float, turn: float, part: FloatArray) -> FloatArray:
    """Return the share of a change of latitude at a share of its meridian arc."""
    total = _mean_curvature_m(latitude, turn, np.ones(1))
    share = part
    for _ in range(4):  # Newton, from within the 1 % by which the radius of curvature varies
        excess = share * _mean_curvature_m(latitude, turn, share) - part * total
        share = share - excess / _curvature_m(latitude + turn * share)
    return share


def _mean_curvature_m(latitude: float, turn: float, part: FloatArray) -> FloatArray:
    """Return the mean radius of curvature of the meridian over parts of a change of latitude."""
    angles = latitude + 0.5 * turn * part[:, None] * (_QUADRATURE_NODES + 1.0)
    means: FloatArray = 0.5 * (_curvature_m(angles) * _QUADRATURE_WEIGHTS).sum(axis=1)
    return means


def _curvature_m(latitude_rad: FloatArray) -> FloatArray:
    """Return the meridian's radius of curvature [m]: a (1 − e²)/(1 − e² sin²φ)^(3/2)."""
    squeezed = 1.0 - SQUARED_ECCENTRICITY * np.sin(latitude_rad) ** 2
    return np.asarray(EQUATOR_M * (1.0 - SQUARED_ECCENTRICITY) / (squeezed * np.sqrt(squeezed)))


class Passage:
    """The voyage of a scene: in port, then from place to place, then in port.

    Between places with known times the speed is constant. Times are nanoseconds from the start of
    the scene.

    Attributes:
        length_m: length of the route [m].
        sails_ns: time of departure.
        arrives_ns: time of arrival.
        places_ns: times at `voyage.places`.
        landfalls_ns: times at the waypoints that are landfalls, and `arrives_ns`.

    Raises:
        SceneError: a leg comes too near a pole, or the ship does not arrive within the scene at
            `voyage.speed`.
    """

    def __init__(self, scene: Surroundings, voyage: Itinerary) -> None:
        self._voyage = voyage
        self._legs = _legs(scene, voyage)
        self._ends_m = np.cumsum([leg.length_m for leg in self._legs])
        self.length_m = float(self._ends_m[-1])
        self.sails_ns = nanoseconds(voyage.sails_at)
        self.arrives_ns = nanoseconds(_arrives_at(scene, voyage, self.length_m))
        made_m = [0.0, *self._ends_m.tolist()]
        times = [None if time is None else nanoseconds(time) for time in voyage.times]
        times[-1] = self.arrives_ns
        # the known times, and the distance made good until then
        marks = [(at, way_m) for at, way_m in zip(times, made_m, strict=True) if at is not None]
        self._known_ns = np.array([at for at, _ in marks], np.int64)
        self._known_m = np.array([way_m for _, way_m in marks])
        for place, at in enumerate(times):
            if at is None:
                row = int(np.searchsorted(self._known_m, made_m[place], 'right')) - 1
                (begin, begin_m), (end, end_m) = marks[row : row + 2]
                part = (made_m[place] - begin_m) / (end_m - begin_m)
                times[place] = begin + round((end - begin) * part)
        self.places_ns = tuple(at for at in times if at is not None)
        landfalls = [
            time
            for time, waypoint in zip(self.places_ns[1:-1], voyage.waypoints or (), strict=True)
            if waypoint.landfall
        ]
        self.landfalls_ns = (*landfalls, self.arrives_ns)

    def speed_m_s(self, time_ns: int) -> float:
        """Return the speed over the ground [m/s], 0 in the ports. At a place: the next speed."""
        if not self.sails_ns < time_ns < self.arrives_ns:
            return 0.0
        stretch = int(np.searchsorted(self._known_ns, time_ns, 'right')) - 1
        run_m = float(self._known_m[stretch + 1]) - float(self._known_m[stretch])
        return run_m * NS_PER_S / int(self._known_ns[stretch + 1] - self._known_ns[stretch])

    def course(self, time_ns: int) -> float:
        """Return the course made good, from north to the east [rad], 0 to 2π.

        At a place it is the next course, before departure the first, after arrival the last.
        """
        made_m = float(self._made_m(np.array([time_ns], np.int64))[0])
        made_m = min(max(made_m, 0.0), self.length_m)
        index = min(int(np.searchsorted(self._ends_m, made_m, 'right')), len(self._legs) - 1)
        while index and self._legs[index].length_m == 0.0:
            index -= 1
        leg = self._legs[index]
        begin_m = float(self._ends_m[index]) - leg.length_m
        return leg.course(min((made_m - begin_m) / (leg.length_m or 1.0), 1.0))

    def _made_m(self, time_ns: IntArray) -> FloatArray:
        """Return the distances made good [m], extrapolated before and after the voyage."""
        top = len(self._known_ns) - 2
        stretch = np.clip(np.searchsorted(self._known_ns, time_ns, 'right') - 1, 0, top)
        begin_ns, begin_m = self._known_ns[stretch], self._known_m[stretch]
        took = np.maximum(self._known_ns[stretch + 1] - begin_ns, 1)
        run_m = self._known_m[stretch + 1] - begin_m
        return np.asarray(begin_m + run_m * ((time_ns - begin_ns) / took))

    def places(self, time_ns: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return latitudes and longitudes [degrees], (n,). Each depends on its time alone."""
        latitude, longitude = (np.full(len(time_ns), start) for start in self._voyage.departure)
        arrived = time_ns >= self.arrives_ns
        latitude[arrived], longitude[arrived] = self._voyage.arrival
        at_sea = (time_ns > self.sails_ns) & ~arrived
        made_m = self._made_m(time_ns)
        which = np.searchsorted(self._ends_m[:-1], made_m, 'right')
        for index in np.unique(which[at_sea]).tolist():
            leg, rows = self._legs[index], at_sea & (which == index)
            begin = float(self._ends_m[index]) - leg.length_m
            part = (made_m[rows] - begin) / (leg.length_m or 1.0)
            latitude[rows], longitude[rows] = leg.places(part)
        return latitude, longitude


def _legs(scene: Surroundings, voyage: Itinerary) -> list[GeodesicLeg | RhumbLeg]:
    legs: list[GeodesicLeg | RhumbLeg] = []
    for index, (start, end) in enumerate(pairwise(voyage.places), 1):
        leg = rhumb_leg(start, end) if voyage.track == 'rhumb' else geodesic_leg(start, end)
        key = key_of_place(voyage, index)
        origin = key_of_place(voyage, index - 1)
        if leg.highest_deg > HIGHEST_LATITUDE_DEG:
            raise SceneError(
                scene.name,
                key,
                list(end),
                f'the shortest way from {origin} goes to {leg.highest_deg:.4f}° of latitude; '
                f'beyond {HIGHEST_LATITUDE_DEG:.2f}° any longitude is within '
                f'{WIDEST_AWARD_NMI:g} nautical miles of any other',
                'Put a waypoint between them, or use track rhumb.',
            )
        legs.append(leg)
    return legs


def _arrives_at(scene: Surroundings, voyage: Itinerary, length_m: float) -> float:
    if voyage.speed is None:
        return math.nan if voyage.arrives_at is None else voyage.arrives_at
    arrives_at = voyage.sails_at + length_m / voyage.speed
    if arrives_at > scene.duration:
        remaining_s = scene.duration - voyage.sails_at
        faster = ''
        if remaining_s > 0.0:  # 5e-4 more than needed, for the rounding to four digits
            faster = f'a speed of at least {1.0005 * length_m / remaining_s:.4g}, '
        raise SceneError(
            scene.name,
            'voyage.speed',
            voyage.speed,
            f'takes {length_m / voyage.speed:.6g} s for the {length_m:.6g} m of the way, and the '
            f'ship arrives {arrives_at - scene.duration:.6g} s after the end of the scene '
            f'(duration {scene.duration!r} s)',
            f'Give {faster}a longer duration, or arrives_at, which may be after the end.',
        )
    return arrives_at


# -----------------------------------------------------------------------------
# Gravity on the way: normal gravity on the ellipsoid of WGS 84 (Somigliana 1929, NIMA TR8350.2,
# 3rd ed., section 4.2), less Eötvös' term (1919): a ship that sails east turns faster than the
# Earth, and the weight of everything on board falls.

EQUATOR_M_S2 = 9.7803253359
"""Normal gravity at the equator."""

SOMIGLIANA = 0.00193185265241
"""Somigliana's k = (b γ_pole)/(a γ_equator) − 1."""

EARTH_RATE = 7.292115e-5
"""Rotation of the Earth [rad/s]."""

KNOT_S = 60
"""Time between the knots of `GravityOnTheWay` [s].

Linear interpolation errs by less than 1e-10 m/s² at 5 m/s, 1e-8 at 50 m/s. At departure and at a
change of course, Eötvös' term changes over two intervals.
"""


def normal_gravity(latitude_rad: FloatArray | float) -> FloatArray:
    """Return the gravity at the surface of the ellipsoid of WGS 84 [m/s²].

    γ(φ) = γ_e (1 + k sin²φ)/√(1 − e² sin²φ), with the geodetic latitude φ.
    """
    return _of_squared_sine(np.asarray(np.sin(latitude_rad) ** 2))


def _of_squared_sine(squared: FloatArray) -> FloatArray:
    return np.asarray(
        EQUATOR_M_S2 * (1.0 + SOMIGLIANA * squared) / np.sqrt(1.0 - SQUARED_ECCENTRICITY * squared)
    )


def _radii_m(squared: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the radii of curvature across and along the meridian [m] for sin²φ."""
    squeezed = 1.0 - SQUARED_ECCENTRICITY * squared
    across = EQUATOR_M / np.sqrt(squeezed)
    return across, across * (1.0 - SQUARED_ECCENTRICITY) / squeezed


def eotvos(
    latitude_rad: FloatArray | float, east: FloatArray | float, north: FloatArray | float
) -> FloatArray:
    """Return Eötvös' term, the loss of gravity on a moving ship [m/s²].

    2 Ω v_E cos φ + v_E²/N + v_N²/M, with the ellipsoid's radii of curvature N across the meridian
    and M along it.

    `east` and `north` are the components of the speed over the ground [m/s].
    """
    across, along = _radii_m(np.asarray(np.sin(latitude_rad) ** 2))
    turning = 2.0 * EARTH_RATE * np.cos(latitude_rad) * np.asarray(east)
    return np.asarray(turning + np.square(east) / across + np.square(north) / along)


def gravity_between(
    elapsed_s: FloatArray, latitude: FloatArray, longitude: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return normal gravity at places (n,), and Eötvös' term between them (n - 1,) [m/s²].

    Places are in degrees north and east. `elapsed_s` is the time from each to the next, (n - 1,).
    """
    # the bits of np.sin may depend on the index in an array
    sine = np.array([math.sin(math.radians(angle)) for angle in latitude.tolist()])
    turn = np.diff(longitude)
    turn = np.radians(turn - 360.0 * np.round(turn / 360.0)) / elapsed_s
    middle = 0.5 * (sine[1:] + sine[:-1])
    across, along = _radii_m(middle * middle)
    cosine = np.sqrt(1.0 - middle * middle)
    east = across * cosine * turn
    north = along * np.radians(np.diff(latitude)) / elapsed_s
    lifted = 2.0 * EARTH_RATE * cosine * east + east * east / across + north * north / along
    return _of_squared_sine(sine * sine), lifted


class GravityOnTheWay:
    """Vertical specific force on a ship without waves, γ(φ) less Eötvös' term, along a passage.

    It is piecewise linear, with a knot every `KNOT_S`, and constant after `duration_ns`. The speed
    at a knot is the mean between its neighbours.
    """

    def __init__(self, passage: Passage, duration_ns: int) -> None:
        step = KNOT_S * NS_PER_S
        # one knot more on either side, for the speeds at the first and the last
        self._knots_ns: IntArray = np.arange(-1, duration_ns // step + 3, dtype=np.int64) * step
        latitude_deg, longitude_deg = passage.places(self._knots_ns)
        latitude, longitude = np.radians(latitude_deg), np.radians(longitude_deg)
        turn = longitude[2:] - longitude[:-2]
        eastward = turn - 2.0 * np.pi * np.round(turn / (2.0 * np.pi))
        at = latitude[1:-1]
        across, along = _radii_m(np.sin(at) ** 2)
        east = across * np.cos(at) * eastward / (2.0 * KNOT_S)
        north = along * (latitude[2:] - latitude[:-2]) / (2.0 * KNOT_S)
        self._knots_ns = self._knots_ns[1:-1]
        self._values = normal_gravity(at) - eotvos(at, east, north)

    def at(self, time_ns: IntArray) -> FloatArray:
        """Return the gravity at times from the start of the scene [m/s²], (n,), each by itself."""
        step = KNOT_S * NS_PER_S
        knot = np.minimum(time_ns // step, len(self._values) - 2)
        part = np.clip((time_ns - knot * step) / step, 0.0, 1.0)
        begin = self._values[knot]
        gravity: FloatArray = begin + part * (self._values[knot + 1] - begin)
        return gravity
