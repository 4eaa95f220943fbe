"""The passage: the route of the ship, and her position at each time."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene.errors import SceneError
from tauto_core.scene.times import NS_PER_S, nanoseconds
from tauto_core.scene.voyages import (
    HIGHEST_LATITUDE_DEG,
    WIDEST_AWARD_NMI,
    Voyage,
    key_of_place,
)
from tauto_core.ship.legs import GeodesicLeg, Leg, geodesic_leg, rhumb_leg
from tauto_core.ship.motion_kind import Surroundings


class Passage:
    """The voyage of a scene: in port, then at constant speed from place to place, then in port.

    Times are nanoseconds from the start of the scene.

    Attributes:
        length_m: length of the route [m].
        sails_ns: time of setting sail.
        arrives_ns: time of arrival; with `voyage.speed`, from the length of the route.
        places_ns: times at which she is at each of `voyage.places`.
        landfalls_ns: those of the waypoints that are landfalls, and `arrives_ns`.

    Raises:
        SceneError: a leg that comes too near a pole or is not the only shortest one, or a speed
            with which she does not arrive within the scene.
    """

    def __init__(self, scene: Surroundings, voyage: Voyage) -> None:
        self._voyage = voyage
        self._legs = _legs(scene, voyage)
        self._ends_m = np.cumsum([leg.length_m for leg in self._legs])
        self.length_m = float(self._ends_m[-1])
        self.sails_ns = nanoseconds(voyage.sails_at)
        self.arrives_ns = nanoseconds(_arrives_at(scene, voyage, self.length_m))
        under_way = self.arrives_ns - self.sails_ns
        passed = [
            self.sails_ns + round(under_way * (float(end) / self.length_m))
            for end in self._ends_m[:-1]
        ]
        self.places_ns = (self.sails_ns, *passed, self.arrives_ns)
        landfalls = [
            time
            for time, waypoint in zip(passed, voyage.waypoints or (), strict=True)
            if waypoint.landfall
        ]
        self.landfalls_ns = (*landfalls, self.arrives_ns)

    @property
    def speed_m_s(self) -> float:
        """Speed over the ground under way [m/s]."""
        return self.length_m * NS_PER_S / (self.arrives_ns - self.sails_ns)

    def is_under_way(self, time_ns: int) -> bool:
        """Return whether she is between the ports at a time from the start of the scene."""
        return self.sails_ns < time_ns < self.arrives_ns

    def course(self, time_ns: int) -> float:
        """Return the course made good at a time from the start of the scene [rad].

        From north to the east, 0 to 2π. At a waypoint it is the course after it; before she sails
        it is the first course, after her arrival the last one.
        """
        under_way = self.arrives_ns - self.sails_ns
        made_m = self.length_m * ((time_ns - self.sails_ns) / under_way)
        made_m = min(max(made_m, 0.0), self.length_m)
        index = min(int(np.searchsorted(self._ends_m, made_m, 'right')), len(self._legs) - 1)
        leg = self._legs[index]
        begin_m = float(self._ends_m[index]) - leg.length_m
        return leg.course((made_m - begin_m) / (leg.length_m or 1.0))

    def places(self, time_ns: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return latitudes and longitudes at some times [degrees]; each depends on its time alone.

        Args:
            time_ns: from the start of the scene, (n,).
        """
        latitude, longitude = (np.full(len(time_ns), each) for each in self._voyage.departure)
        arrived = time_ns >= self.arrives_ns
        latitude[arrived], longitude[arrived] = self._voyage.arrival
        at_sea = (time_ns > self.sails_ns) & ~arrived
        under_way = self.arrives_ns - self.sails_ns
        made_m = self.length_m * ((time_ns - self.sails_ns) / max(under_way, 1))
        which = np.searchsorted(self._ends_m[:-1], made_m, 'right')
        for index, leg in enumerate(self._legs):
            here = at_sea & (which == index)
            if here.any():
                begin = float(self._ends_m[index]) - leg.length_m
                part = (made_m[here] - begin) / (leg.length_m or 1.0)
                latitude[here], longitude[here] = leg.places(part)
        return latitude, longitude


def _legs(scene: Surroundings, voyage: Voyage) -> list[Leg]:
    """Return the legs from place to place."""
    legs: list[Leg] = []
    for index, (start, end) in enumerate(pairwise(voyage.places), 1):
        leg = rhumb_leg(start, end) if voyage.track == 'rhumb' else geodesic_leg(start, end)
        key = key_of_place(voyage, index)
        before = key_of_place(voyage, index - 1)
        if leg.highest_deg > HIGHEST_LATITUDE_DEG:
            raise SceneError(
                scene.name,
                key,
                list(end),
                f'the shortest way from {before} goes to {leg.highest_deg:.4f}° of latitude; '
                f'beyond {HIGHEST_LATITUDE_DEG:.2f}° any longitude is within '
                f'{WIDEST_AWARD_NMI:g} nautical miles of any other',
                'Put a waypoint between them, or use track rhumb.',
            )
        if isinstance(leg, GeodesicLeg) and not leg.unique:
            raise SceneError(
                scene.name,
                key,
                list(end),
                f'lies opposite {before} on the globe: there are two shortest ways',
                'Put a waypoint on the way that is meant.',
            )
        legs.append(leg)
    return legs


def _arrives_at(scene: Surroundings, voyage: Voyage, length_m: float) -> float:
    """Return the time of arrival from the start [s]."""
    if voyage.speed is None:
        return math.nan if voyage.arrives_at is None else voyage.arrives_at
    arrives_at = voyage.sails_at + length_m / voyage.speed
    if arrives_at > scene.duration:
        left = scene.duration - voyage.sails_at
        faster = f'a speed of at least {_rounded_up(length_m / left)}, ' if left > 0.0 else ''
        raise SceneError(
            scene.name,
            'voyage.speed',
            voyage.speed,
            f'takes {length_m / voyage.speed:.6g} s for the {length_m:.6g} m of the way, so that '
            f'she arrives {arrives_at - scene.duration:.6g} s after the end of the scene '
            f'(duration {scene.duration!r} s)',
            f'Give {faster}a longer duration, or arrives_at, which may lie beyond the end.',
        )
    if round(length_m / voyage.speed * NS_PER_S) < 1:
        raise SceneError(
            scene.name,
            'voyage.speed',
            voyage.speed,
            'makes the whole way in less than a nanosecond',
            'Give it in m/s.',
        )
    return arrives_at


def _rounded_up(value: float) -> str:
    """Return a number > 0 rounded up to four digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 3)
    return f'{math.ceil(value / unit) * unit:.4g}'
