"""The clock's error at the instants of the observations, between the readings."""

from __future__ import annotations

import numpy as np

from tauto_core.samples import NS_PER_S, FloatArray, IntArray


def observed_phases(
    stamp_ns: IntArray, reference_ns: IntArray, at_ns: IntArray, observed_ns: IntArray
) -> FloatArray:
    """Return reading minus observed time at each observation [s], (n,).

    The error is linear between two readings. The result for one observation does not depend on the
    others.

    Args:
        stamp_ns: stamps of the readings, increasing.
        reference_ns: readings of the dial at these stamps.
        at_ns: times of the observations, within the readings; (n,).
        observed_ns: the true time as it was observed; (n,).
    """
    after = np.searchsorted(stamp_ns, at_ns)
    before = np.maximum(after - 1, 0)
    error = reference_ns - stamp_ns
    left, right = error[before], error[after]
    span = np.maximum(stamp_ns[after] - stamp_ns[before], 1)
    # integers below 2^53 ns, 104 days, are exact
    between = left + (right - left) * ((at_ns - stamp_ns[before]) / span)
    dial_error = np.where(stamp_ns[after] == at_ns, right, between)
    return np.asarray((dial_error - (observed_ns - at_ns)) / NS_PER_S, np.float64)


def on_line(stamp_ns: IntArray, values: FloatArray, at_ns: IntArray) -> FloatArray:
    """Return values at instants between readings by linear interpolation, (n, c).

    Args:
        stamp_ns: stamps of the readings, increasing, (m,).
        values: the values at these stamps, (m, c).
        at_ns: within the readings, (n,).
    """
    after = np.searchsorted(stamp_ns, at_ns)
    before = np.maximum(after - 1, 0)
    span = np.maximum(stamp_ns[after] - stamp_ns[before], 1)
    part = ((at_ns - stamp_ns[before]) / span)[:, None]
    between = values[before] + (values[after] - values[before]) * part
    return np.where((stamp_ns[after] == at_ns)[:, None], values[after], between)
