"""The built-in threads: the ideal ones here, lever and hanging thread in modules of their own.

A module of this folder adds a further kind.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tauto_core.machines.trochlea import ThreadKind
from tauto_core.scene.sections import Positive


class VerticalThread(ThreadKind):
    """Ideal thread, along the apparent vertical under a weight, otherwise fixed in the case."""

    upright = True
    rank = 1

    kind: Literal['vertical'] = 'vertical'


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


KINDS = VerticalThread, HoleThread
