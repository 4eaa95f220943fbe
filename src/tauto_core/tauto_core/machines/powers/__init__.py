"""The powers that ship; a module of this folder adds further ones.

A constant pull without inertia, as Euler assumes (1727, X), a hanging weight (1727, XX), a spring
without inertia, and both on one thread.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tauto_core.curves.cam import Pull
from tauto_core.curves.materials import NamedMaterial
from tauto_core.machines.parts import PowerKind
from tauto_core.scene.sections import Flag, NonNegative, Positive

OF_SPRING = Field(
    default=None,
    description='material of the spring, a name or mapping: expansion, modulus; when left out its '
    'force does not change with temperature',
)


class ForcePower(PowerKind):
    """Constant pull without inertia."""

    words = 'a pull without inertia or stiffness'
    rank = 1
    starter = {'force': 3.158}

    kind: Literal['force'] = 'force'
    force: Positive = Field(description='pull in the thread [N]')
    material: NamedMaterial | None = OF_SPRING

    @property
    def pull(self) -> Pull:
        """The constant force."""
        return Pull(force=self.force)


class WeightPower(PowerKind):
    """Hanging weight; `massless` keeps its pull and neglects its inertia."""

    words = 'a weight whose inertia counts'
    rank = 2
    starter = {'mass': 0.322}

    kind: Literal['weight'] = 'weight'
    mass: Positive = Field(description='mass of the weight [kg]')
    massless: Flag = Field(
        default=False, description='true: the inertia of the weight is neglected'
    )

    @property
    def pull(self) -> Pull:
        """The weight, and its inertia unless that is neglected."""
        return Pull(carried_mass=0.0 if self.massless else self.mass, pulling_mass=self.mass)


class SpringPower(PowerKind):
    """Spring without inertia: pull = force + stiffness · draw, the length of thread drawn."""

    words = 'a spring'
    rank = 3
    starter = {'force': 3.158, 'stiffness': 50.0}

    kind: Literal['spring'] = 'spring'
    force: Positive = Field(description='pull at zero draw [N]')
    stiffness: NonNegative = Field(description='stiffness [N/m]')
    material: NamedMaterial | None = OF_SPRING

    @property
    def pull(self) -> Pull:
        """The force at zero draw, and the stiffness."""
        return Pull(force=self.force, stiffness=self.stiffness)

    @property
    def acts_as(self) -> str:
        """`spring`, also without stiffness."""
        return 'spring'


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
    material: NamedMaterial | None = OF_SPRING

    @property
    def pull(self) -> Pull:
        """The weight with its inertia, and the stiffness."""
        return Pull(carried_mass=self.mass, pulling_mass=self.mass, stiffness=self.stiffness)

    @property
    def acts_as(self) -> str:
        """Both; no closed form corrects them together."""
        return 'weight_and_spring'


KINDS = ForcePower, WeightPower, SpringPower, WeightAndSpringPower
