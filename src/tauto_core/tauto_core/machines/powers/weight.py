"""A hanging weight (Euler 1727, XX)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tauto_core.curves.cam import Pull
from tauto_core.machines.parts import PowerKind
from tauto_core.scene.fields import Flag, Positive


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

    def left_out(self) -> tuple[str, ...]:
        """Return the inertia where it is neglected."""
        return ("the weight's inertia",) if self.massless else ()


KIND = WeightPower
