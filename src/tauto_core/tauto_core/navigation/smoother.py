"""The fixed-interval smoother: the drift at each instant, estimated from all observations.

It gives the result of Rauch, Tung and Striebel's smoother in the form of Bryson and Frazier, which
inverts no covariance (Bierman, Fixed interval smoothing with discrete measurements, Int. J.
Control 18, 1973). It goes backwards over the observations used, with innovation ν of variance S,
gain K, H = (1, 0, 0) and transition F, and updates an adjoint λ and its information Λ:

    before an observation:  λ ← (I − KH)ᵀ λ − Hᵀ ν/S,   Λ ← (I − KH)ᵀ Λ (I − KH) + Hᵀ H/S
    over a time τ:          λ ← Fᵀ λ,                   Λ ← Fᵀ Λ F

The smoothed state at any instant is x̂ − P λ, its covariance P − P Λ P, with the filter's x̂ and P
at that instant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauto_core.navigation.dense import covariance, estimate, means
from tauto_core.navigation.filtering import Filtered
from tauto_core.navigation.kalman import ClockModel, Estimate, predict, same_fields
from tauto_core.samples import NS_PER_S, FloatArray, IntArray

BLOCK = 65_536
"""Number of instants smoothed at once; each takes nine numbers of memory."""


@dataclass(frozen=True)
class Smoother:
    """Estimates of the drift from all observations, earlier and later.

    Args:
        way: the run of the filter.
        model: its model.
        adjoint: λ just before each observation used, (m, n), n = 3 and the coefficients.
        information: Λ just before each, (m, n, n).
        rate_variance: for each state of the run, by how much a reopening at the next observation
            widens the variance of the rate, (m + 1,).
    """

    way: Filtered
    model: ClockModel
    adjoint: FloatArray
    information: FloatArray
    rate_variance: FloatArray

    def at(
        self, stamp_ns: IntArray, integrals_s: FloatArray | None = None
    ) -> Estimate[FloatArray]:
        """Return mean and covariance given all observations, (n,).

        Args:
            stamp_ns: in any order, none before the start of the filter. After the last observation
                the result is the filter's own prediction. At an instant where the rate is taken to
                have changed, it is the rate after the change.
            integrals_s: integrals of the covariates at these stamps [s], (n, c); None: there are
                none.
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
        known, passed = self.way.stamp_ns, self.way.integrals_s
        place = np.searchsorted(known[1:], stamp_ns, 'right')
        since = (stamp_ns - known[place]) / NS_PER_S
        gained = tuple((integrals_s - passed[place]).T)
        known_then = same_fields(self.way.states, (column[place] for column in self.way.states))
        # where the next observation reopened the state, the rate may have changed here
        changed = known_then.yy + self.rate_variance[place]
        now = predict(known_then._replace(yy=changed), since, self.model, gained)
        later = place < len(self.adjoint)
        if not later.any():
            return now
        ahead = np.minimum(place, len(self.adjoint) - 1)
        f = _transition(
            np.where(later, known[ahead + 1] - stamp_ns, 0) / NS_PER_S,
            np.where(later[:, None], passed[ahead + 1] - integrals_s, 0.0),
        )
        p = covariance(now, self.model.names)
        weight = later.astype(np.float64)[:, None]
        pulled = p @ np.swapaxes(f, 1, 2)
        mean = (
            means(now, self.model.names)
            - weight * (pulled @ self.adjoint[ahead, :, None])[:, :, 0]
        )
        less = pulled @ self.information[ahead] @ np.swapaxes(pulled, 1, 2)
        return estimate(mean, p - weight[:, :, None] * less, self.model.names)


def smooth(way: Filtered, model: ClockModel) -> Smoother:
    """Return the smoother for a run of the filter over all observations.

    Args:
        way: the whole run of the filter, from the setting of the dial.
        model: the model of the filter.
    """
    expected, elapsed = way.expected(model), way.elapsed_s()
    variance = expected.xx + way.sigma_s * way.sigma_s
    innovation = way.phase_s - expected.x
    gain = covariance(expected, model.names)[:, 0] / variance[:, None]
    count, size = gain.shape
    adjoint, information = np.empty((count, size)), np.empty((count, size, size))
    between = _transition(elapsed, np.diff(way.integrals_s, axis=0))
    keep = np.broadcast_to(np.eye(size), (count, size, size)).copy()
    keep[:, :, 0] -= gain
    back, known = np.zeros(size), np.zeros((size, size))
    for k in reversed(range(count)):
        back, known = keep[k].T @ back, keep[k].T @ known @ keep[k]
        back[0] -= innovation[k] / variance[k]
        known[0, 0] += 1.0 / variance[k]
        adjoint[k], information[k] = back, known
        back, known = between[k].T @ back, between[k].T @ known @ between[k]
    rate = way.opened_s / np.where(elapsed > 0.0, elapsed, np.inf)
    return Smoother(way, model, adjoint, information, np.append(rate * rate, 0.0))


def _transition(elapsed_s: FloatArray, gained_s: FloatArray) -> FloatArray:
    """Return F over each time, (m, n, n), where c integrals grow by `gained_s`, (m, c)."""
    size = 3 + gained_s.shape[1]
    f = np.broadcast_to(np.eye(size), (len(elapsed_s), size, size)).copy()
    f[:, 0, 1] = f[:, 1, 2] = elapsed_s
    f[:, 0, 2] = 0.5 * elapsed_s * elapsed_s
    f[:, 0, 3:] = gained_s
    return f
