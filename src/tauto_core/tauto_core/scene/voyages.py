"""The voyage: from port to port by way of waypoints, and the rules between its keys."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from tauto_core.scene.errors import ABSENT, Problem
from tauto_core.scene.fields import Flag, Instant, Position, Positive, Section
from tauto_core.scene.times import nanoseconds

WIDEST_AWARD_NMI = 60.0
"""Distance within which the Act of 1714 pays anything [nautical miles]."""

HIGHEST_LATITUDE_DEG = math.degrees(math.acos(WIDEST_AWARD_NMI / (180.0 * 60.0)))
"""89.68°; nearer to a pole half a parallel, 10800′ cos φ, is shorter than `WIDEST_AWARD_NMI`."""

SAME_PLACE_DEG = 1e-9
"""Places nearer to each other in latitude and longitude, a tenth of a millimetre, are the same."""


def _with_place(value: object) -> object:
    """Accept a waypoint that is written as its place alone."""
    return {'place': value} if isinstance(value, list | tuple) else value


class Waypoint(Section):
    """A place that the ship passes. Written as `[latitude, longitude]` it is no landfall."""

    place: Position = Field(description='[latitude, longitude] in degrees, north and east +')
    landfall: Flag = Field(
        default=False,
        description='true: land is sighted, so the longitude is known and the clock is checked',
    )


class Voyage(Section):
    """From port to port at constant speed; times from the start of the scene."""

    departure: Position = Field(description='[latitude, longitude] in degrees, north and east +')
    waypoints: (
        Annotated[
            tuple[Annotated[Waypoint, BeforeValidator(_with_place)], ...], Field(max_length=1000)
        ]
        | None
    ) = Field(
        default=None,
        description='list of [latitude, longitude] or {place: [latitude, longitude], '
        'landfall: true}, at most 1000, in the order of the voyage',
    )
    arrival: Position = Field(description='[latitude, longitude] in degrees, north and east +')
    track: Literal['geodesic', 'rhumb'] | None = Field(
        default=None,
        description='geodesic, the shortest route between places, or rhumb, a constant course '
        'between places; geodesic when left out',
    )
    sails_at: Instant = Field(description='time of setting sail, from the start [s]')
    arrives_at: Instant | None = Field(
        default=None, description='time of landfall, from the start [s]; or give speed'
    )
    speed: Positive | None = Field(
        default=None, description='speed over the ground [m/s]; or give arrives_at'
    )

    @property
    def places(self) -> tuple[Position, ...]:
        """Departure, waypoints, arrival."""
        between = (each.place for each in self.waypoints or ())
        return (self.departure, *between, self.arrival)

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong between its keys, without computing the route."""
        yield from _times(self)
        yield from _places(self)


def key_of_place(voyage: Voyage, index: int) -> str:
    """Return the path to the key of one of `voyage.places`."""
    if index == 0:
        return 'voyage.departure'
    last = len(voyage.places) - 1
    return 'voyage.arrival' if index == last else f'voyage.waypoints[{index - 1}]'


def _times(voyage: Voyage) -> Iterator[Problem]:
    if voyage.arrives_at is None and voyage.speed is None:
        yield Problem(
            'voyage.arrives_at',
            ABSENT,
            'is missing, and there is no speed in its place',
            'Write `arrives_at: …`, time of landfall from the start [s], or `speed: …` [m/s].',
        )
    if voyage.arrives_at is None:
        return
    if voyage.speed is not None:
        yield Problem(
            'voyage.speed',
            voyage.speed,
            f'does not go with voyage.arrives_at, {voyage.arrives_at!r} s; one is enough',
            'Leave one of them out.',
        )
    if nanoseconds(voyage.arrives_at) <= nanoseconds(voyage.sails_at):
        yield Problem(
            'voyage.arrives_at',
            voyage.arrives_at,
            f'must be later than voyage.sails_at, {voyage.sails_at!r} s, by a nanosecond or more',
            'Give both from the start of the scene, in the order of the voyage.',
        )


def _places(voyage: Voyage) -> Iterator[Problem]:
    for index, (latitude, longitude) in enumerate(voyage.places):
        if abs(latitude) > HIGHEST_LATITUDE_DEG:
            yield Problem(
                key_of_place(voyage, index),
                [latitude, longitude],
                f'lies nearer to a pole than {HIGHEST_LATITUDE_DEG:.2f}°, where any longitude is '
                f'within {WIDEST_AWARD_NMI:g} nautical miles of any other',
                'Choose a place farther from the pole.',
            )
    for index, (one, other) in enumerate(pairwise(voyage.places), 1):
        apart = abs(math.remainder(other[1] - one[1], 360.0))
        same = max(abs(other[0] - one[0]), apart) < SAME_PLACE_DEG
        # a ship may lie in port throughout, but then a time of arrival is needed
        if same and (voyage.waypoints or voyage.speed is not None):
            yield Problem(
                key_of_place(voyage, index),
                list(other),
                f'is the same place as {key_of_place(voyage, index - 1)}, before it',
                'Leave one of them out, or correct it.'
                if voyage.waypoints
                else 'Give arrives_at in place of speed, or another place.',
            )
        elif voyage.track == 'rhumb' and apart == 180.0:
            yield Problem(
                key_of_place(voyage, index),
                list(other),
                f'is 180° of longitude from {key_of_place(voyage, index - 1)}: the rhumb lines to '
                'the east and to the west are equally long',
                'Put a waypoint on the side that is meant.',
            )
