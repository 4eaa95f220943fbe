"""The plain escapement, whose impulses weaken with the train."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tauto_core.machines.parts import Ebb, EscapementKind, Train


class Escapement(EscapementKind):
    """Impulse once a beat, at angle · sgn θ̇ (positive: after the middle)."""

    rank = 1
    starter = {'energy': 1.234e-4}

    kind: Literal['impulse'] = 'impulse'
    train: Train | None = Field(
        default=None,
        description='mapping: fall, impulses; when left out all impulses are equal',
    )

    @property
    def ebb(self) -> Ebb | None:
        """That of the train."""
        if self.train is None or self.train.fall == 0.0:
            return None
        return Ebb(self.train.fall, self.train.impulses)


KIND = Escapement
