"""A spring without inertia (theory E2)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tauto_core.curves.cam import Pull
from tauto_core.machines.parts import PowerKind
from tauto_core.scene.fields import NonNegative, Positive


class SpringPower(PowerKind):
    """Spring without inertia: pull = force + stiffness · draw, the length of thread drawn."""

    words = 'a spring'
    rank = 3
    starter = {'force': 3.158, 'stiffness': 50.0}

    kind: Literal['spring'] = 'spring'
    force: Positive = Field(description='pull at zero draw [N]')
    stiffness: NonNegative = Field(description='stiffness [N/m]')

    @property
    def pull(self) -> Pull:
        """The force at zero draw, and the stiffness."""
        return Pull(force=self.force, stiffness=self.stiffness)

    @property
    def acts_as(self) -> str:
        """`spring`, also without stiffness."""
        return 'spring'


KIND = SpringPower
