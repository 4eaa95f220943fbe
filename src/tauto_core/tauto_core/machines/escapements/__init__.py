"""The built-in escapements. A module of this folder adds a further kind.

The plain escapement has impulses that weaken with the train. In a remontoire a small spring drives
the escapement, and the train only rewinds it and spends its surplus energy on a fly. The impulses
then weaken only with the small spring between two rewindings. Harrison's fourth timekeeper rewinds
eight times a minute (*The Principles of Mr. Harrison's Time-keeper, with Plates of the same*,
London 1767), with five beats a second: every 37 or 38 impulses.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, Strict

from tauto_core.machines.parts import EscapementKind, ImpulseDecline, Train
from tauto_core.scene.errors import Problem
from tauto_core.scene.sections import Positive, Section


class Escapement(EscapementKind):
    """Impulse once a beat, at angle · sgn θ̇ (positive: after the middle)."""

    rank = 1
    starter = {'energy': 1.234e-4}

    kind: Literal['impulse'] = 'impulse'
    train: Train | None = Field(
        default=None,
        description='mapping: fall, impulses. When left out all impulses are equal',
    )

    @property
    def ebb(self) -> ImpulseDecline | None:
        """Decline with the train."""
        if self.train is None or self.train.fall == 0.0:
            return None
        return ImpulseDecline(self.train.fall, self.train.impulses)


class Remontoire(Section):
    """The small spring that drives the escapement."""

    impulses: Annotated[int, Strict(), Field(ge=1, le=10**6)] = Field(
        description='impulses of the escapement between two rewindings, 1 to 1e6'
    )
    fall: Annotated[float, Strict(), Field(ge=0.0, le=1.0)] = Field(
        default=0.0,
        description='fall of its energy from one rewinding to just before the next, relative to '
        'its mean, 0 to 1',
    )


class DrivingTrain(Train):
    """The train that rewinds the small spring."""

    energy: Positive = Field(
        description='work that the train can supply for an impulse, less friction, averaged over '
        'a winding [J]'
    )

    @property
    def least(self) -> float:
        """Work that the train can supply for an impulse just before it is wound [J]."""
        return self.energy * (1.0 - 0.5 * self.fall)


class RemontoireEscapement(EscapementKind):
    """Impulse once a beat from a small spring that the train rewinds, independent of the train."""

    rank = 2
    starter = {'energy': 1.234e-4, 'remontoire': {'impulses': 15, 'fall': 0.02}}

    kind: Literal['remontoire'] = 'remontoire'
    remontoire: Remontoire = Field(description='mapping: impulses, fall')
    train: DrivingTrain | None = Field(
        default=None,
        description='mapping: energy, fall, impulses. When left out the train can always rewind '
        'the spring',
    )

    @property
    def ebb(self) -> ImpulseDecline | None:
        """Decline with the small spring, independent of the train."""
        if self.remontoire.fall == 0.0:
            return None
        return ImpulseDecline(self.remontoire.fall, self.remontoire.impulses)

    def problems(self) -> Iterator[Problem]:
        """Yield contradictions between its keys, such as a train too weak to rewind."""
        yield from super().problems()
        if self.train is not None and self.train.least < self.energy:
            factor = 1.0 - 0.5 * self.train.fall
            yield Problem(
                'escapement.train.energy',
                self.train.energy,
                f'leaves {self.train.least:.6g} J for an impulse before the train is wound, less '
                f'than the {self.energy:.6g} J (escapement.energy) that rewinding the remontoire '
                'takes: the clock stops there',
                f'Use at least {self.energy / factor:.6g} J, or a train that falls by less.',
            )


KINDS = Escapement, RemontoireEscapement
