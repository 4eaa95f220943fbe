"""What a navigator finds when he goes over his readings and observations at home."""

from __future__ import annotations

from typing import Any

import numpy as np

from tauto_core.navigation.drift import ESTIMATE_NAMES, clock_model, estimate_values
from tauto_core.navigation.filtering import Filtered, Known, filter_phases
from tauto_core.navigation.kalman import ClockModel, prior
from tauto_core.navigation.ordering import BEFORE_ALL, in_order
from tauto_core.navigation.phases import observed_phases
from tauto_core.navigation.smoother import smooth
from tauto_core.samples import NS_PER_S, FloatArray, IntArray, TimeSamples, take
from tauto_core.scene import Scene


def filtered_drift(
    reading: TimeSamples, observation: TimeSamples | None, model: ClockModel
) -> Filtered:
    """Return what the filter makes of all observations in the order of their stamps.

    Args:
        reading: at least one; the dial is set right at the first. Those out of order are left out.
        observation: None: there were none. Of those of one stamp the first counts; those before
            the first reading and after the last are left out.
        model: of the clock and the observations.
    """
    reading = take(reading, in_order(reading.stamp_ns, BEFORE_ALL))
    stamps: IntArray = reading.stamp_ns
    start = Known(int(stamps[0]), prior(model))
    if observation is None:
        return filter_phases(start, [], [], model)
    at, first = np.unique(observation.stamp_ns, return_index=True)
    within = (at >= stamps[0]) & (at <= stamps[-1])
    at, observed = at[within], observation.time_ref_ns[first[within]]
    phases = observed_phases(stamps, reading.time_ref_ns, at, observed)
    sources = observation.source[first[within]].tolist()
    sigmas = [model.sigma_of(source) for source in sources]
    return filter_phases(start, at.tolist(), phases.tolist(), model, sigmas)


def hindsight(
    reading: TimeSamples, observation: TimeSamples | None, corrected: TimeSamples, scene: Scene
) -> dict[str, Any]:
    """Return the smoothed drift of the clock, and how well it would have corrected the dial.

    Args:
        reading: of the dial, at least one.
        observation: of the true time.
        corrected: the reading less the drift as it was known at the time.
        scene: says what is assumed of clock and observations.

    Returns:
        `stamp_s` of the observations used and, at each, the smoothed `ESTIMATE_NAMES`, as lists;
        root mean square and largest size of what is left of the clock's error: `rms_s`, `worst_s`
        in hindsight, `at_the_time_rms_s` and `at_the_time_worst_s` of `corrected`.
    """
    model = clock_model(scene)
    way = filtered_drift(reading, observation, model)
    smoother = smooth(way, model)
    used = way.stamp_ns[1:]
    values = estimate_values(smoother.at(used))
    kept = take(reading, in_order(reading.stamp_ns, BEFORE_ALL))
    error = (kept.time_ref_ns - kept.stamp_ns) / NS_PER_S
    rms, worst = _size(error - smoother.at(kept.stamp_ns).x)
    rms_then, worst_then = _size((corrected.time_ref_ns - corrected.stamp_ns) / NS_PER_S)
    columns = zip(ESTIMATE_NAMES, values.T.tolist(), strict=True)
    return {
        'rms_s': rms,
        'worst_s': worst,
        'at_the_time_rms_s': rms_then,
        'at_the_time_worst_s': worst_then,
        'stamp_s': (used / NS_PER_S).tolist(),
        **dict(columns),
    }


def _size(error_s: FloatArray) -> tuple[float, float]:
    return float(np.sqrt(np.mean(error_s * error_s))), float(np.abs(error_s).max())
