"""The built-in drag. A module of this folder adds a further kind."""

from __future__ import annotations

from typing import Literal

from pydantic import Field
from pydantic.json_schema import SkipJsonSchema

from tauto_core.machines.parts import DragKind


class Drag(DragKind):
    """Torque against the motion of the wheel in its case: c₁θ̇ + c₂θ̇|θ̇| + c₀ sgn θ̇."""

    rank = 1
    starter = {'viscous': 1.25e-5}

    # a drag without `kind` is this one, and is written without it
    kind: SkipJsonSchema[Literal['polynomial']] = Field(default='polynomial', exclude=True)


KINDS = (Drag,)
