"""Selects the samples of a topic that come in order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import IntArray

BEFORE_ALL = int(np.iinfo(np.int64).min)
"""Stamp for "nothing has come yet" [ns]."""

AFTER_ALL = int(np.iinfo(np.int64).max)
"""Stamp later than that of any sample [ns]."""


def in_order(stamp_ns: IntArray, last_ns: int) -> NDArray[np.bool_]:
    """Return which stamps are later than `last_ns` and than all stamps before them."""
    if len(stamp_ns) == 1:  # nodes usually get one message at a time
        return np.array([stamp_ns[0] > last_ns])
    newest = np.maximum.accumulate(np.concatenate(([last_ns], stamp_ns)))[:-1]
    kept: NDArray[np.bool_] = stamp_ns > newest
    return kept
