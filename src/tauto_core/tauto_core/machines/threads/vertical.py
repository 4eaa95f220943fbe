"""The ideal thread of one direction (Euler 1727, VII)."""

from __future__ import annotations

from typing import Literal

from tauto_core.machines.trochlea import ThreadKind


class VerticalThread(ThreadKind):
    """Ideal thread, along the apparent vertical under a weight, else fixed in the case."""

    upright = True
    rank = 1

    kind: Literal['vertical'] = 'vertical'


KIND = VerticalThread
