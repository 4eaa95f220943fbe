"""The kinds of air: by the places of the voyage."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, Strict

from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene.errors import ABSENT, Problem
from tauto_core.scene.sections import Itinerary, Number, Section
from tauto_core.ship.air import AirKind, AirySurroundings, beyond
from tauto_core.ship.passage import Passage


class AirAt(Section):
    """The temperature of the air where the ship is at a place of the voyage."""

    waypoint: Annotated[int, Strict(), Field(ge=0)] = Field(
        description='number of a place of the voyage: 0 the departure, then the waypoints, then '
        'the arrival'
    )
    celsius: Number = Field(description='temperature of the air there, -60 to 60 [°C]')


class RouteAir(AirKind):
    """Air by the places of the voyage; between them its temperature is linear in the time sailed.

    Before the first place that is named and after the last one it is constant.
    """

    rank = 1
    starter: ClassVar[Mapping[str, Any]] = {'celsius': 15.0}

    kind: Literal['route'] = 'route'
    at: tuple[AirAt, ...] | None = Field(
        default=None, description='list of {waypoint, celsius}, in the order of the voyage'
    )
    celsius: Number | None = Field(
        default=None,
        description='one temperature in place of the list, for a clock in harbour too, -60 to 60 '
        '[°C]',
    )

    def knots(self, scene: AirySurroundings) -> tuple[IntArray, FloatArray]:
        """Return the times at the named places, and the temperatures there."""
        if self.at is None or scene.voyage is None:
            return np.zeros(1, np.int64), np.array([self.celsius], np.float64)
        places_ns = Passage(scene, scene.voyage).places_ns
        return (
            np.array([places_ns[each.waypoint] for each in self.at], np.int64),
            np.array([each.celsius for each in self.at]),
        )

    def problems(self, voyage: Itinerary | None) -> Iterator[Problem]:
        """Yield what is wrong with its places and temperatures."""
        if self.celsius is not None:
            yield from beyond('air.celsius', self.celsius)
            if self.at is not None:
                yield Problem(
                    'air.celsius', self.celsius, 'does not go with at', 'Leave one of them out.'
                )
        elif self.at is None:
            yield Problem(
                'air.at',
                ABSENT,
                'is missing, and there is no celsius in its place',
                'Write `at: [{waypoint: 0, celsius: …}, …]`, or `celsius: …`.',
            )
        if self.at is None:
            return
        if voyage is None:
            yield Problem(
                'air.at',
                ABSENT,
                'names places of a voyage, and the scene has none',
                'Write `celsius: …` for a clock in harbour, or `voyage: …`.',
            )
        if not self.at:
            yield Problem('air.at', ABSENT, 'is empty', 'Name at least one place.')
        for index, each in enumerate(self.at):
            yield from beyond(f'air.at[{index}].celsius', each.celsius)
            last = 0 if voyage is None else len(voyage.places) - 1
            if voyage is not None and each.waypoint > last:
                yield Problem(
                    f'air.at[{index}].waypoint',
                    each.waypoint,
                    f'is not a place of the voyage, which has {last + 1}: 0 is the departure, '
                    f'{last} the arrival',
                    f'Give a number from 0 to {last}.',
                )
        for index, (before, after) in enumerate(pairwise(self.at), 1):
            if after.waypoint <= before.waypoint:
                yield Problem(
                    f'air.at[{index}].waypoint',
                    after.waypoint,
                    f'does not come after the place before it, {before.waypoint}',
                    'Name each place once, in the order of the voyage.',
                )


KINDS = (RouteAir,)
