"""The contents of `drift/estimate` and `clock/corrected` for an estimate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tauto_core.navigation.coefficients import pairs
from tauto_core.navigation.filtering import Filtered
from tauto_core.navigation.kalman import ClockModel, Estimate, covariances, predict, same_fields
from tauto_core.navigation.regressors import integral_names
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    NS_PER_S,
    SECONDS_PER_DAY,
    Batches,
    FloatArray,
    IntArray,
    TimeSamples,
    same,
    scalars,
)

ESTIMATE_NAMES = ('offset_s', 'offset_sigma_s', 'rate_s_per_day', 'rate_sigma_s_per_day')
"""Names in every estimate; with covariates others follow (`estimate_names`)."""

MEAN_RATE_NAMES = ('mean_rate_s_per_day', 'mean_rate_sigma_s_per_day')

MOST_NS = 4e18
"""Above the times of ROS, and within int64."""


class Passed(NamedTuple):
    """Time and integrals of readings since the first one.

    Attributes:
        elapsed_s: time since the first reading [s], (n,).
        integrals_s: integrals of the covariates [s], (n, c).
        gained_s: their growth since the first reading [s], (n, c).
    """

    elapsed_s: FloatArray
    integrals_s: FloatArray
    gained_s: FloatArray


def estimate_names(covariates: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the values of an estimate with these covariates."""
    if not covariates:
        return ESTIMATE_NAMES
    learned = [f'{name}_coefficient{part}' for name in covariates for part in ('', '_sigma')]
    return (*ESTIMATE_NAMES, *MEAN_RATE_NAMES, *learned, *integral_names(covariates))


def estimate_values(
    now: Estimate[FloatArray], covariates: tuple[str, ...], passed: Passed | None = None
) -> FloatArray:
    """Return the values of `estimate_names`, (n, names).

    Args:
        now: estimates, (n,).
        covariates: the covariates of the model.
        passed: with covariates, time and integrals since the first reading.
    """
    clock = [now.x, np.sqrt(now.xx), now.y * SECONDS_PER_DAY, np.sqrt(now.yy) * SECONDS_PER_DAY]
    if passed is None:
        return np.column_stack(clock)
    known = now._asdict()
    learned = [
        column for name in covariates for column in (known[name], np.sqrt(known[f'{name}_{name}']))
    ]
    return np.column_stack(
        (*clock, *_mean_rate(now, covariates, passed), *learned, passed.integrals_s)
    )


def _mean_rate(
    now: Estimate[FloatArray], covariates: tuple[str, ...], passed: Passed
) -> tuple[FloatArray, FloatArray]:
    """Return y + Σ k_j ⟨x_j⟩ with the means since the first reading, and its sigma [s/day]."""
    known, names = now._asdict(), ('y', *covariates)
    elapsed = np.where(passed.elapsed_s > 0.0, passed.elapsed_s, np.inf)
    weights = [np.ones(len(elapsed)), *(column / elapsed for column in passed.gained_s.T)]
    rate = sum(weight * known[name] for weight, name in zip(weights, names, strict=True))
    variance = np.zeros(len(elapsed))
    for (i, j), field in zip(pairs(len(names)), covariances(names), strict=True):
        variance = variance + (1.0 if i == j else 2.0) * weights[i] * weights[j] * known[field]
    sigma = np.sqrt(np.maximum(variance, 0.0))
    return rate * SECONDS_PER_DAY, sigma * SECONDS_PER_DAY


def has_mean_rate(found: Mapping[str, float]) -> bool:
    """Return whether an estimate by name has the mean rate of the voyage, due to covariates."""
    return MEAN_RATE_NAMES[0] in found


def mean_rate(found: Mapping[str, float]) -> tuple[float, float]:
    """Return the rate of an estimate and its sigma [s/day], with covariates the voyage's mean.

    Args:
        found: an estimate by name.
    """
    rate, sigma = MEAN_RATE_NAMES if has_mean_rate(found) else ESTIMATE_NAMES[2:]
    return found[rate], found[sigma]


def estimates(
    stamps: IntArray,
    references: IntArray,
    way: Filtered,
    model: ClockModel,
    passed: Passed | None,
) -> Batches:
    """Return estimate and corrected time for readings, each from the last state at its stamp.

    Every reading is predicted from that state in one step, so the result does not depend on the
    log interval.
    """
    place = np.searchsorted(way.stamp_ns[1:], stamps, 'right')
    elapsed = (stamps - way.stamp_ns[place]) / NS_PER_S
    gained = () if passed is None else tuple((passed.integrals_s - way.integrals_s[place]).T)
    then = same_fields(way.states, (column[place] for column in way.states))
    now = predict(then, elapsed, model, gained)
    # absurd observations could exceed int64; no message has times as large as this limit
    error_ns = np.nan_to_num(np.clip(now.x * NS_PER_S, -MOST_NS, MOST_NS), nan=MOST_NS)
    corrected = references - np.rint(error_ns).astype(np.int64)
    values = estimate_values(now, model.names, passed)
    return {
        ESTIMATE: scalars(stamps, estimate_names(model.names), values),
        CORRECTED: TimeSamples(stamps, '', corrected, same('corrected', len(stamps))),
    }
