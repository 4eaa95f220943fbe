"""What all kinds of power share: keys, pull, messages."""

from __future__ import annotations

from typing import ClassVar

from tauto_core.curves.kind import Pull
from tauto_core.scene.kinds import Kind

FOLDER = 'tauto_core.machines.powers'


class PowerKind(Kind):
    """What pulls the thread. Each kind is a module of `machines/powers` that names its `KIND`.

    Its mechanics, in Python and compiled, are its `pull`, whose form covers weights, springs,
    constant forces and their sums.

    Attributes:
        words: name of the power in messages.
    """

    words: ClassVar[str]

    kind: str

    @property
    def pull(self) -> Pull:
        """The pull in the thread."""
        raise NotImplementedError

    @property
    def acts_as(self) -> str:
        """The effect that a cam would have to correct: `weight` or `spring`; `force`: none."""
        pull = self.pull
        if pull.carried_mass:
            return 'weight'
        return 'spring' if pull.stiffness else 'force'

    def left_out(self) -> tuple[str, ...]:
        """Return the terms that it does not have."""
        return ()
