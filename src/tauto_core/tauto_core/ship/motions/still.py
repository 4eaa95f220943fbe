"""No motion."""

from __future__ import annotations

from typing import Literal

from tauto_core.ship.motion_kind import Channels, ShipKind, Surroundings


class StillShip(ShipKind):
    """A ship that lies still, or a clock on land."""

    lies_still = True
    rank = 1

    kind: Literal['still'] = 'still'

    def channels(self, scene: Surroundings) -> Channels:
        """Return no motion."""
        del scene
        return Channels()

    @property
    def motions(self) -> tuple[str, ...]:
        """None."""
        return ()


KIND = StillShip
