"""Propagators of motions that are known at any time, so that they have no running state."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from tauto_core.motion.forcing import Forcing, Motion
from tauto_core.samples import IntArray, State


class ClosedForm(ABC):
    """A propagator whose motion is a function of the time since the release."""

    @abstractmethod
    def motion_at(self, time_ns: IntArray) -> Motion:
        """Return the motion at times since the release [ns], (n,)."""

    def release(self, forcing: Forcing) -> Motion:
        """Return the motion at the start."""
        del forcing
        return self.motion_at(np.zeros(1, np.int64))

    def advance(self, forcing: Forcing) -> Motion:
        """Return the motion at the logged ends of the spans."""
        return self.motion_at(forcing.end_ns[forcing.logged])

    def state(self) -> State:
        """Return the empty state: the motion is known at any time."""
        return {}

    def restore(self, state: State) -> None:
        """Accept the empty state."""
        del state
