"""The verdict over a whole voyage, from the topic `longitude/error` alone."""

from __future__ import annotations

import numpy as np

from tauto_core.navigation.longitude import ERROR_NAMES, column
from tauto_core.navigation.prize import prize_pounds
from tauto_core.samples import JointSamples, count


class LongitudeTally:
    """Final and worst error of the longitude over all batches fed."""

    def __init__(self) -> None:
        self._final: dict[str, float] = {}
        self._worst_nmi = 0.0

    def feed(self, errors: JointSamples) -> None:
        """Take the next batch of `longitude/error`.

        Raises:
            EstimationError: one of `ERROR_NAMES` is missing.
        """
        columns = {name: column(errors, name) for name in ERROR_NAMES}
        if not count(errors):
            return
        self._final = {name: float(values[-1]) for name, values in columns.items()}
        self._worst_nmi = max(self._worst_nmi, float(np.abs(columns['error_nmi']).max()))

    def result(self) -> dict[str, float] | None:
        """Return the last errors, the worst corrected distance and the prize; None if none came.

        Keys: `ERROR_NAMES` at the last stamp, `worst_error_nmi` (magnitude), `prize_pounds` (an
        int) for the last corrected distance, as the Act was judged at the landfall.
        """
        if not self._final:
            return None
        pounds = prize_pounds(abs(self._final['error_nmi']))
        return {**self._final, 'worst_error_nmi': self._worst_nmi, 'prize_pounds': pounds}
