"""A body that sinks in a fluid: its effective weight and its resistance.

Euler, *Curva tautochrona in fluido* (1729), 10–12. The resistance is the weight of a column of
fluid as high as the fall that gives the speed: the full column on the base of a cylinder moving
along its axis (C_d = 1), half of it on a globe (C_d = 1/2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from tauto_core.scene.errors import DescentError

# drag coefficient × base area × size a/(2 × volume): 1/2 and 3/8
_DRAG = {'cylinder': 0.5, 'globe': 0.375}
_VOLUME = {'cylinder': 0.25 * math.pi, 'globe': math.pi / 6.0}


@dataclass(frozen=True)
class ImmersedBody:
    """A globe or cylinder in its fluid.

    Attributes:
        shape: 'globe' or 'cylinder'.
        size: a, diameter of the globe, height of the cylinder along its motion [m], > 0.
        density: m of the body [kg/m3]; except for the weight, only its ratio to the fluid's
            matters.
        fluid_density: n of the fluid [kg/m3], ≥ 0 and less than the body's.
        added_mass: C, coefficient of added mass, ≥ 0. Euler: 0; a globe in potential flow: 1/2.

    Raises:
        DescentError: a number out of its range; a fluid as dense as the body or denser.
    """

    shape: Literal['globe', 'cylinder']
    size: float
    density: float
    fluid_density: float
    added_mass: float = 0.0

    def __post_init__(self) -> None:
        if self.shape not in _DRAG:
            raise DescentError(f'shape = {self.shape!r}: must be globe or cylinder')
        for name, least in (('size', 0.0), ('density', 0.0)):
            value = getattr(self, name)
            if not least < value < math.inf:
                raise DescentError(f'{name} = {value!r}: must be finite and above 0; give another')
        if not 0.0 <= self.added_mass < math.inf:
            raise DescentError(
                f'added_mass = {self.added_mass!r}: must be finite and at least 0; a globe in an '
                'ideal fluid has 0.5'
            )
        if not 0.0 <= self.fluid_density < self.density:
            raise DescentError(
                f'fluid_density = {self.fluid_density!r} kg/m3: must be at least 0 and less than '
                f'the density of the {self.shape}, {self.density!r} kg/m3, or it does not sink; '
                'take a denser body or a lighter fluid'
            )

    @property
    def kappa(self) -> float:
        """κ = n/(2(m + Cn)a) of a cylinder, 3n/(8(m + Cn)a) of a globe [1/m]."""
        return _DRAG[self.shape] * self.fluid_density / (self._inertia * self.size)

    @property
    def gamma(self) -> float:
        """γ = (m − n)/(m + Cn)."""
        return (self.density - self.fluid_density) / self._inertia

    @property
    def sunk_mass(self) -> float:
        """Mass of the body less that of the fluid displaced [kg].

        A cylinder is taken to be as wide as it is high; its motion does not depend on that.
        """
        return (self.density - self.fluid_density) * _VOLUME[self.shape] * self.size**3

    @property
    def _inertia(self) -> float:
        return self.density + self.added_mass * self.fluid_density
