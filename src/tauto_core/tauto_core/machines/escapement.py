"""What all kinds of escapement share: keys, energy of the impulses, messages."""

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
    """How the impulses weaken while the spring or weight that drives them runs down.

    The impulse number k since the start has the energy·(1 + fall·(½ − u)), u = (k mod n + ½)/n,
    with n impulses between windings; so the mean over a winding is the energy itself.

    Attributes:
        fall: fall of the energy from the first impulse after a winding to the last, relative to
            its mean.
        impulses: number n of impulses between two windings.
    """

    fall: float
    impulses: int

    def strength(self, given: int) -> float:
        """Return the next impulse's energy relative to the mean, after `given` impulses."""
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
        """How impulses weaken between windings; None if they are all equal."""
        return None

    @property
    def recoil(self) -> float:
        """Constant torque against the direction of the last impulse, until the next [N m]."""
        return 0.0 if self.rest is None else self.rest.recoil

    @property
    def friction(self) -> float:
        """Friction torque against the motion [N m]."""
        return 0.0 if self.rest is None else self.rest.friction

    @property
    def work(self) -> float:
        """Mean energy that it gives in a swing: two impulses, and the loop of the recoil [J]."""
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
