"""A constant pull without inertia, as Euler assumes (1727, X)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tauto_core.curves.cam import Pull
from tauto_core.machines.parts import PowerKind
from tauto_core.scene.fields import Positive


class ForcePower(PowerKind):
    """Constant pull without inertia."""

    words = 'a pull without inertia or stiffness'
    rank = 1
    starter = {'force': 3.158}

    kind: Literal['force'] = 'force'
    force: Positive = Field(description='pull in the thread [N]')

    @property
    def pull(self) -> Pull:
        """The constant force."""
        return Pull(force=self.force)


KIND = ForcePower
