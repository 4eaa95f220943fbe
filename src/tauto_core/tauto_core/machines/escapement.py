"""What every kind of escapement has: its keys, the energy of its impulses, and its words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, NamedTuple

from pydantic import Field, Strict

from tauto_core.scene.errors import Problem
from tauto_core.scene.fields import NonNegative, Number, Section
from tauto_core.scene.kinds import Kind

FOLDER = 'tauto_core.machines.escapements'


class Rest(Section):
    """Friction and recoil of the tooth that rests on a pallet between impulses (theory E2)."""

    friction: NonNegative = Field(
        default=0.0, description='friction torque against the motion [N m]'
    )
    recoil: NonNegative = Field(
        default=0.0,
        description='constant torque against the direction of the last impulse, '
        'until the next [N m]',
    )


class Ebb(NamedTuple):
    """How impulses weaken as what drives them runs down, until it is wound again.

    The k-th impulse since the start gives energy·(1 + fall·(½ − u)), u = (k mod n + ½)/n, n of
    `impulses`; then the mean over a winding is the energy itself.

    Attributes:
        fall: from the first impulse after a winding to the last, by the mean energy.
        impulses: between two windings.
    """

    fall: float
    impulses: int

    def strength(self, given: int) -> float:
        """Return the energy of the next impulse by the mean, after so many since the start."""
        return 1.0 + self.fall * (0.5 - (given % self.impulses + 0.5) / self.impulses)


class Train(Section):
    """A driving train that weakens between two windings."""

    fall: Annotated[float, Strict(), Field(ge=0.0, le=1.0)] = Field(
        description='fall of the driving energy from one winding to just before the next, '
        'relative to its mean, 0 to 1'
    )
    impulses: Annotated[int, Strict(), Field(ge=1, le=10**9)] = Field(
        description='impulses of the escapement between two windings, 1 to 1e9'
    )


class EscapementKind(Kind):
    """Impulse once a beat, at angle · sgn θ̇ (positive: after the middle).

    Each kind is a module of `machines/escapements` that names its `KIND`.
    """

    kind: str
    energy: NonNegative = Field(
        description='energy given each beat [J]; 0 only where recoil drives the wheel'
    )
    angle: Number = Field(
        default=0.0,
        description='angle of the wheel in its case at the '
        'impulse [rad], positive after the middle',
    )
    rest: Rest | None = Field(default=None, description='mapping: friction, recoil')

    @property
    def ebb(self) -> Ebb | None:
        """How impulses weaken between windings; None: they are all the same."""
        return None

    @property
    def recoil(self) -> float:
        """Torque against the last impulse, until the next [N m]."""
        return 0.0 if self.rest is None else self.rest.recoil

    @property
    def friction(self) -> float:
        """Torque against the motion [N m]."""
        return 0.0 if self.rest is None else self.rest.friction

    @property
    def work(self) -> float:
        """What it gives in a swing, in the mean: two impulses, and the loop of the recoil [J]."""
        return 2.0 * self.energy + 4.0 * self.recoil * self.angle

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong between its keys."""
        if self.energy == 0.0 and not self.work > 0.0:
            yield Problem(
                'escapement.energy',
                0.0,
                'must be greater than 0 J: nothing else drives the wheel, since recoil does so '
                'only where it is held past the middle (escapement.rest.recoil and '
                'escapement.angle greater than 0)',
                'Give the impulse an energy, or both recoil and a positive angle.',
            )

    def left_out(self) -> tuple[str, ...]:
        """Return the terms that it does not have."""
        return () if self.recoil else ('recoil',)
