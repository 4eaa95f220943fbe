"""The filter over a whole voyage at once, and its estimates as vectors and matrices."""

from __future__ import annotations

import numpy as np

from tauto_core.navigation import Known, filter_phases, prior
from tauto_core.navigation.drift import observed_phases, on_line
from tauto_core.navigation.kalman import ClockModel, Estimate, Filtered, covariances, pairs
from tauto_core.navigation.longitude import BEFORE_ALL, in_order
from tauto_core.navigation.regressors import RecordedIntegrals
from tauto_core.samples import FloatArray, IntArray, TimeSamples, take


def filtered_drift(
    reading: TimeSamples,
    observation: TimeSamples | None,
    model: ClockModel,
    motion: RecordedIntegrals | None = None,
) -> Filtered:
    """Return the result of the filter for all observations in the order of their stamps.

    The dial is set right at the first of at least one reading; those out of order are left out. Of
    several observations with one stamp the first is used; those before the first reading and after
    the last are left out. With covariates `motion` gives their integrals.
    """
    reading = take(reading, in_order(reading.stamp_ns, BEFORE_ALL))
    stamps: IntArray = reading.stamp_ns
    reached = np.empty((len(stamps), 0)) if motion is None else motion.at(stamps)
    start = Known(int(stamps[0]), prior(model), integrals_s=tuple(reached[0].tolist()))
    if observation is None:
        return filter_phases(start, [], [], model)
    at, first = np.unique(observation.stamp_ns, return_index=True)
    within = (at >= stamps[0]) & (at <= stamps[-1])
    at, observed = at[within], observation.time_ref_ns[first[within]]
    phases = observed_phases(stamps, reading.time_ref_ns, at, observed)
    sources = observation.source[first[within]].tolist()
    sigmas = [model.sigma_of(source) for source in sources]
    integrals = on_line(stamps, reached, at).tolist()
    return filter_phases(start, at.tolist(), phases.tolist(), model, sigmas, integrals)


def means(known: Estimate[FloatArray], coefficients: tuple[str, ...]) -> FloatArray:
    """Return the means of x, y, d and the coefficients, (n, 3 + c)."""
    return np.column_stack([getattr(known, name) for name in ('x', 'y', 'd', *coefficients)])


def covariance(known: Estimate[FloatArray], coefficients: tuple[str, ...]) -> FloatArray:
    """Return P of each instant, (n, 3 + c, 3 + c)."""
    names = ('x', 'y', 'd', *coefficients)
    p = np.empty((len(known.x), len(names), len(names)))
    for (i, j), field in zip(pairs(len(names)), covariances(names), strict=True):
        p[:, i, j] = p[:, j, i] = getattr(known, field)
    return p
