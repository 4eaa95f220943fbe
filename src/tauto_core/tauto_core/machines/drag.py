"""The drag on the wheel: torques against its motion in the case (theory E2)."""

from __future__ import annotations

from pydantic import Field

from tauto_core.samples import FloatArray
from tauto_core.scene.fields import NonNegative, Section


class Drag(Section):
    """Torque against the motion of the wheel in its case: c₁θ̇ + c₂θ̇|θ̇| + c₀ sgn θ̇."""

    viscous: NonNegative = Field(default=0.0, description='c₁ [N m s]')
    quadratic: NonNegative = Field(default=0.0, description='c₂ [N m s2]')
    coulomb: NonNegative = Field(default=0.0, description='c₀ [N m]')

    @property
    def is_zero(self) -> bool:
        """Whether all of it is 0."""
        return not (self.viscous or self.quadratic or self.coulomb)

    def torque(self, rate: FloatArray) -> FloatArray:
        """Return the torque against the motion at θ̇ ≥ 0 [N m]."""
        return self.viscous * rate + self.quadratic * rate * rate + self.coulomb

    def with_friction(self, friction: float) -> Drag:
        """Return the drag together with another friction [N m]."""
        return Drag(
            viscous=self.viscous, quadratic=self.quadratic, coulomb=self.coulomb + friction
        )

    def left_out(self) -> tuple[str, ...]:
        """Return the terms that are 0."""
        terms = {
            'viscous drag': self.viscous,
            'quadratic drag': self.quadratic,
            'friction': self.coulomb,
        }
        return tuple(name for name, value in terms.items() if not value)
