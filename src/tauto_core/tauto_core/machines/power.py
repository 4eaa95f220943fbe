"""What every kind of power has: its keys, its pull, and its words."""

from __future__ import annotations

from typing import ClassVar

from tauto_core.curves.kind import Pull
from tauto_core.scene.kinds import Kind

FOLDER = 'tauto_core.machines.powers'


class PowerKind(Kind):
    """What pulls the thread. Each kind is a module of `machines/powers` that names its `KIND`.

    Its law, plain and compiled, is its `pull`: of that form are weights, springs and constant
    forces, and any of them together.

    Attributes:
        words: what it is, for messages.
    """

    words: ClassVar[str]

    kind: str

    @property
    def pull(self) -> Pull:
        """What it does in the thread."""
        raise NotImplementedError

    @property
    def acts_as(self) -> str:
        """What a cam would have to correct: `weight` or `spring`; `force`: nothing."""
        pull = self.pull
        if pull.carried_mass:
            return 'weight'
        return 'spring' if pull.stiffness else 'force'

    def left_out(self) -> tuple[str, ...]:
        """Return the terms that it does not have."""
        return ()
