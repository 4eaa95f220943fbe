"""The thread through a fixed hole (Euler 1727, XXII)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tauto_core.machines.trochlea import ThreadKind
from tauto_core.scene.fields import Positive


class HoleThread(ThreadKind):
    """Thread through a hole that is fixed in the case."""

    rank = 2
    starter = {'distance': 0.08}

    kind: Literal['hole'] = 'hole'
    distance: Positive = Field(description='distance of the hole from the axle [m]')

    @property
    def hole_distance(self) -> float:
        """Distance of the hole from the axle [m]."""
        return self.distance


KIND = HoleThread
