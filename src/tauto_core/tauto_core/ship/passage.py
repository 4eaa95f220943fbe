"""The passage: which way the ship takes, and when she is where."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene import Scene, Voyage
from tauto_core.scene.errors import SceneError
from tauto_core.scene.times import NS_PER_S, nanoseconds
from tauto_core.scene.voyages import HIGHEST_LATITUDE_DEG, WIDEST_AWARD_NMI, key_of_place
from tauto_core.ship.legs import GeodesicLeg, Leg, geodesic_leg, rhumb_leg


class Passage:
    """The voyage of a scene: in port, then at constant speed from place to place, then in port.

    Times are nanoseconds from the start of the scene.

    Attributes:
        length_m: of the whole way [m].
        sails_ns: time of setting sail.
        arrives_ns: time of arrival; with `voyage.speed`, from the length of the way.
        landfalls_ns: times at which she passes the waypoints that are landfalls, and `arrives_ns`.

    Raises:
        SceneError: a leg that goes too near a pole or is not the only shortest, or a speed that
            does not reach the arrival within the scene.
    """

    def __init__(self, scene: Scene, voyage: Voyage) -> None:
        self._voyage = voyage
        self._legs = _legs(scene, voyage)
        self._ends_m = np.cumsum([leg.length_m for leg in self._legs])
        self.length_m = float(self._ends_m[-1])
        self.sails_ns = nanoseconds(voyage.sails_at)
        self.arrives_ns = nanoseconds(_arrives_at(scene, voyage, self.length_m))
        under_way = self.arrives_ns - self.sails_ns
        passed = [
            self.sails_ns + round(under_way * (float(end) / self.length_m))
            for end, waypoint in zip(self._ends_m[:-1], voyage.waypoints or (), strict=True)
            if waypoint.landfall
        ]
        self.landfalls_ns = (*passed, self.arrives_ns)

    def places(self, time_ns: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return latitudes and longitudes at some times [degrees], each of its time alone.

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


def _legs(scene: Scene, voyage: Voyage) -> list[Leg]:
    """Return the way from place to place."""
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


def _arrives_at(scene: Scene, voyage: Voyage, length_m: float) -> float:
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
    """Return a number > 0 with four digits, none smaller than itself."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 3)
    return f'{math.ceil(value / unit) * unit:.4g}'
