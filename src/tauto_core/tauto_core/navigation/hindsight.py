"""The drift in hindsight: the fixed-interval smoother over all readings and observations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from tauto_core.navigation.covariates import clock_model
from tauto_core.navigation.drift import (
    Passed,
    estimate_names,
    estimate_values,
    observed_phases,
    on_line,
)
from tauto_core.navigation.kalman import (
    ClockModel,
    Estimate,
    Filtered,
    Known,
    covariance,
    estimate,
    filter_phases,
    means,
    predict,
    prior,
    reopen,
    same_fields,
)
from tauto_core.navigation.longitude import BEFORE_ALL, in_order
from tauto_core.navigation.regressors import RecordedIntegrals
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    OBSERVATION,
    READING,
    Batches,
    FloatArray,
    IntArray,
    JointSamples,
    TimeSamples,
    take,
)
from tauto_core.scene import Scene
from tauto_core.scene.times import NS_PER_S

# -----------------------------------------------------------------------------
# The fixed-interval smoother: the drift at each instant, estimated from all observations.
#
# It is that of Rauch, Tung and Striebel (Maximum likelihood estimates of linear dynamic systems,
# AIAA J. 3, 1965), with each covariance as a sum of squares. Let x and P be the filter's state at
# an instant, F and Q transition and noise from there to the next observation used, x⁻ and P⁻ the
# filter's prediction for it, and x⁺ and P⁺ the smoothed state there. The smoothed state is
#
#     C = P Fᵀ (P⁻)⁻¹,   x̂ = x + C (x⁺ − x⁻),   P̂ = (I − CF) P (I − CF)ᵀ + C (P⁺ + Q) Cᵀ.
#
# In hindsight the first day's rate is known a million times better than at the time, so that any
# form with a difference, such as P + C (P⁺ − P⁻) Cᵀ, loses all digits there. C minimises (I − CF)
# P (I − CF)ᵀ + C Q Cᵀ, so the rounding of C enters only by its square.

BLOCK = 65_536
"""Number of instants smoothed at once, each of which takes some hundred numbers of memory."""

RIDGE = float(np.finfo(np.float64).eps)
"""Added to the diagonal of a matrix of correlations, as much as rounding does to it, so that it
can be inverted where it is singular but for rounding.
"""


@dataclass(frozen=True)
class Smoother:
    """Estimates of the drift from all observations, earlier and later.

    Args:
        way: the run of the filter.
        model: its model.
        expected: the filter's prediction for each observation used, (m,).
        mean: smoothed mean at each of them, (m, n), n = 3 and the coefficients.
        spread: smoothed covariance at each, (m, n, n).
        rate_variance: for each state of the run, by how much a reopening at the next observation
            widens the variance of the rate, (m + 1,).
    """

    way: Filtered
    model: ClockModel
    expected: Estimate[FloatArray]
    mean: FloatArray
    spread: FloatArray
    rate_variance: FloatArray

    def at(
        self, stamp_ns: IntArray, integrals_s: FloatArray | None = None
    ) -> Estimate[FloatArray]:
        """Return mean and covariance given all observations, (n,), at stamps in any order.

        None lies before the start of the filter. After the last observation the result is the
        filter's own prediction. At an instant where the rate is taken to have changed, it is the
        rate after the change. Integrals of c covariates at these stamps are (n, c) [s].
        """
        if integrals_s is None:
            integrals_s = np.empty((len(stamp_ns), 0))
        blocks = [
            self._block(stamp_ns[first : first + BLOCK], integrals_s[first : first + BLOCK])
            for first in range(0, max(len(stamp_ns), 1), BLOCK)
        ]
        columns = zip(*blocks, strict=True)
        return same_fields(self.way.states, (np.concatenate(column) for column in columns))

    def _block(self, stamp_ns: IntArray, integrals_s: FloatArray) -> Estimate[FloatArray]:
        way, names = self.way, self.model.names
        place = np.searchsorted(way.stamp_ns[1:], stamp_ns, 'right')
        since = (stamp_ns - way.stamp_ns[place]) / NS_PER_S
        gained = tuple((integrals_s - way.integrals_s[place]).T)

        def at(states: Estimate[FloatArray], where: IntArray) -> Estimate[FloatArray]:
            return same_fields(states, (column[where] for column in states))

        known = at(way.states, place)
        # where the next observation reopened the state, the rate may have changed here
        changed = known._replace(yy=known.yy + self.rate_variance[place])
        now = predict(changed, since, self.model, gained)
        later = np.flatnonzero(place < len(self.mean))
        if not later.size:
            return now
        ahead = place[later]
        elapsed = (way.stamp_ns[ahead + 1] - stamp_ns[later]) / NS_PER_S
        f = _transition(elapsed, way.integrals_s[ahead + 1] - integrals_s[later])
        noise = _noise(way.states, elapsed, self.model)
        jumped = noise._replace(xx=noise.xx + way.opened_s[ahead] ** 2)
        expected = at(self.expected, ahead)
        mean, p = means(now, names), covariance(now, names)
        gain, part = _backwards(
            p[later], f, covariance(jumped, names), covariance(expected, names)
        )
        learned = self.mean[ahead] - means(expected, names)
        mean[later] += (gain @ learned[:, :, None])[:, :, 0]
        p[later] = part + gain @ self.spread[ahead] @ np.swapaxes(gain, 1, 2)
        return estimate(mean, p, names)


def smooth(way: Filtered, model: ClockModel) -> Smoother:
    """Return the smoother for the whole run of a filter, from the setting of the dial."""
    expected, elapsed = way.expected(model), way.elapsed_s()
    since = np.where(elapsed > 0.0, elapsed, np.inf)
    noise = reopen(_noise(way.states, elapsed, model), way.opened_s, since)
    f = _transition(elapsed, np.diff(way.integrals_s, axis=0))
    mean, ahead = means(way.states, model.names), means(expected, model.names)
    p, q, before = (covariance(each, model.names) for each in (way.states, noise, expected))
    gain, part = _backwards(p[:-1], f, q, before)
    for k in reversed(range(1, len(elapsed))):
        mean[k] += gain[k] @ (mean[k + 1] - ahead[k])
        p[k] = part[k] + gain[k] @ p[k + 1] @ gain[k].T
    rate = way.opened_s / since
    return Smoother(way, model, expected, mean[1:], p[1:], np.append(rate * rate, 0.0))


def _transition(elapsed_s: FloatArray, gained_s: FloatArray) -> FloatArray:
    """Return F over each time, (m, n, n), where c integrals grow by `gained_s`, (m, c)."""
    size = 3 + gained_s.shape[1]
    f = np.broadcast_to(np.eye(size), (len(elapsed_s), size, size)).copy()
    f[:, 0, 1] = f[:, 1, 2] = elapsed_s
    f[:, 0, 2] = 0.5 * elapsed_s * elapsed_s
    f[:, 0, 3:] = gained_s
    return f


def _noise(
    like: Estimate[FloatArray], elapsed_s: FloatArray, model: ClockModel
) -> Estimate[FloatArray]:
    """Return Q over each time, as the covariance of an estimate, (m,)."""
    none = same_fields(like, (np.zeros(len(elapsed_s)) for _ in like))
    return predict(none, elapsed_s, model, (none.x,) * len(model.names))


def _backwards(
    p: FloatArray, f: FloatArray, noise: FloatArray, expected: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return C, and the part (I − CF) P (I − CF)ᵀ + C Q Cᵀ of P̂; each (m, n, n)."""
    size = expected.shape[1]
    sigma = np.sqrt(np.diagonal(expected, axis1=1, axis2=2))
    # a state that is known for certain, as the ageing in a model without it, learns nothing
    sigma = np.where(sigma > 0.0, sigma, 1.0)[:, :, None]
    correlation = expected / sigma / np.swapaxes(sigma, 1, 2)
    inside = np.arange(size)
    correlation[:, inside, inside] = 1.0 + RIDGE
    gain = np.swapaxes(np.linalg.solve(correlation, f @ p / sigma) / sigma, 1, 2)
    keep = np.eye(size) - gain @ f
    part = keep @ p @ np.swapaxes(keep, 1, 2) + gain @ noise @ np.swapaxes(gain, 1, 2)
    return gain, part


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


def hindsight(samples: Batches, scene: Scene) -> dict[str, Any]:
    """Return the smoothed drift of the clock, and how well it would have corrected the dial.

    The samples are readings, at least one, observations, and the estimates and corrected readings
    as they were known at the time. The result has `stamp_s` of the observations used and, at each,
    the smoothed `estimate_names`, as lists; and root mean square and largest size of the remaining
    error of the clock: `rms_s`, `worst_s` in hindsight, `at_the_time_rms_s` and
    `at_the_time_worst_s` for `corrected`.
    """
    reading, observation, corrected = (
        cast(TimeSamples, samples.get(topic)) for topic in (READING, OBSERVATION, CORRECTED)
    )
    estimate = cast(JointSamples, samples[ESTIMATE])
    model = clock_model(scene)
    motion = RecordedIntegrals(estimate, model.names) if model.coefficients else None
    way = filtered_drift(reading, observation, model, motion)
    smoother = smooth(way, model)
    used = way.stamp_ns[1:]
    kept = take(reading, in_order(reading.stamp_ns, BEFORE_ALL))
    known = smoother.at(kept.stamp_ns, None if motion is None else motion.at(kept.stamp_ns))
    passed, integrals = None, way.integrals_s
    if integrals.shape[1]:
        elapsed_s = (used - way.stamp_ns[0]) / NS_PER_S
        passed = Passed(elapsed_s, integrals[1:], integrals[1:] - integrals[0])
    values = estimate_values(smoother.at(used, integrals[1:]), model.names, passed)
    left = (kept.time_ref_ns - kept.stamp_ns) / NS_PER_S - known.x
    then = (corrected.time_ref_ns - corrected.stamp_ns) / NS_PER_S
    columns = zip(estimate_names(model.names), values.T.tolist(), strict=True)
    return {
        'rms_s': float(np.sqrt(np.mean(left * left))),
        'worst_s': float(np.abs(left).max()),
        'at_the_time_rms_s': float(np.sqrt(np.mean(then * then))),
        'at_the_time_worst_s': float(np.abs(then).max()),
        'stamp_s': (used / NS_PER_S).tolist(),
        **dict(columns),
    }
