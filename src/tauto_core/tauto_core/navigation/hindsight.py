"""The drift in hindsight, from all readings and observations."""

from __future__ import annotations

from typing import Any

import numpy as np

from tauto_core.navigation.assumptions import clock_model
from tauto_core.navigation.estimates import Passed, estimate_names, estimate_values
from tauto_core.navigation.filtering import Filtered, Known, filter_phases
from tauto_core.navigation.kalman import ClockModel, prior
from tauto_core.navigation.ordering import BEFORE_ALL, in_order
from tauto_core.navigation.phases import observed_phases, on_line
from tauto_core.navigation.regressors import RecordedIntegrals
from tauto_core.navigation.smoother import smooth
from tauto_core.samples import NS_PER_S, FloatArray, IntArray, JointSamples, TimeSamples, take
from tauto_core.scene import Scene


def filtered_drift(
    reading: TimeSamples,
    observation: TimeSamples | None,
    model: ClockModel,
    motion: RecordedIntegrals | None = None,
) -> Filtered:
    """Return the result of the filter for all observations in the order of their stamps.

    Args:
        reading: at least one; the dial is set right at the first. Those out of order are left out.
        observation: None: there were none. Of several with one stamp the first is used; those
            before the first reading and after the last are left out.
        model: the model of the clock and the observations.
        motion: with covariates, the source of their integrals.
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


def hindsight(
    reading: TimeSamples,
    observation: TimeSamples | None,
    corrected: TimeSamples,
    estimate: JointSamples,
    scene: Scene,
) -> dict[str, Any]:
    """Return the smoothed drift of the clock, and how well it would have corrected the dial.

    Args:
        reading: readings of the dial, at least one.
        observation: observations of the true time.
        corrected: the readings corrected by the drift as it was known at the time.
        estimate: the drift as it was known at the time, with the integrals of covariates.
        scene: gives the assumptions about clock and observations.

    Returns:
        `stamp_s` of the observations used and, at each, the smoothed `estimate_names`, as lists;
        root mean square and largest size of the remaining error of the clock: `rms_s`, `worst_s`
        in hindsight, `at_the_time_rms_s` and `at_the_time_worst_s` for `corrected`.
    """
    model = clock_model(scene)
    motion = RecordedIntegrals(estimate, model.names) if model.coefficients else None
    way = filtered_drift(reading, observation, model, motion)
    smoother = smooth(way, model)
    used = way.stamp_ns[1:]
    kept = take(reading, in_order(reading.stamp_ns, BEFORE_ALL))
    known = smoother.at(kept.stamp_ns, None if motion is None else motion.at(kept.stamp_ns))
    values = estimate_values(smoother.at(used, way.integrals_s[1:]), model.names, _passed(way))
    error = (kept.time_ref_ns - kept.stamp_ns) / NS_PER_S
    rms, worst = _size(error - known.x)
    rms_then, worst_then = _size((corrected.time_ref_ns - corrected.stamp_ns) / NS_PER_S)
    columns = zip(estimate_names(model.names), values.T.tolist(), strict=True)
    return {
        'rms_s': rms,
        'worst_s': worst,
        'at_the_time_rms_s': rms_then,
        'at_the_time_worst_s': worst_then,
        'stamp_s': (used / NS_PER_S).tolist(),
        **dict(columns),
    }


def _passed(way: Filtered) -> Passed | None:
    """Return time and integrals of the observations since the first, if there are covariates."""
    integrals = way.integrals_s
    if not integrals.shape[1]:
        return None
    elapsed_s = (way.stamp_ns[1:] - way.stamp_ns[0]) / NS_PER_S
    return Passed(elapsed_s, integrals[1:], integrals[1:] - integrals[0])


def _size(error_s: FloatArray) -> tuple[float, float]:
    return float(np.sqrt(np.mean(error_s * error_s))), float(np.abs(error_s).max())
