"""A weight and a spring that pull the same thread."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tauto_core.curves.cam import Pull
from tauto_core.machines.parts import PowerKind
from tauto_core.scene.fields import Positive


class WeightAndSpringPower(PowerKind):
    """Hanging weight, and a spring on the same thread: pull = mass · g + stiffness · draw."""

    words = 'a weight and a spring together'
    rank = 4
    starter = {'mass': 0.322, 'stiffness': 50.0}

    kind: Literal['weight_and_spring'] = 'weight_and_spring'
    mass: Positive = Field(description='mass of the weight [kg]')
    stiffness: Positive = Field(
        description='stiffness of the spring, which is slack at rest [N/m]'
    )

    @property
    def pull(self) -> Pull:
        """The weight with its inertia, and the stiffness."""
        return Pull(carried_mass=self.mass, pulling_mass=self.mass, stiffness=self.stiffness)

    @property
    def acts_as(self) -> str:
        """Both; no closed form corrects them together."""
        return 'weight_and_spring'


KIND = WeightAndSpringPower
